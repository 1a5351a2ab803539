"""``hjsolve verify`` and ``hjsolve canonical``: the book's examples typed, with the three exit statuses."""

from __future__ import annotations

import json

import pytest

from hjsolve.command_line.main import main

KEPLER = ["verify", "kepler-planar", "-W", "p*theta + integral(sqrt(2*m*(E + k/r) - p**2/r**2), r)"]
OSCILLATOR = ["verify", "--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**2/2"]
PLACE_TO_PLACE = "((x**2 + a**2)*cos(t) - 2*x*a)/(2*sin(t))"


def assert_told(arguments: list[str], status: int, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == status
    out, error = capsys.readouterr()
    assert all(word in out + error for word in words)
    assert (out == "") == (status == 2)


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        ([*KEPLER, "--constant", "E", "--constant", "p"], 0, ["Yes: a complete integral", "(5-48)", "(5-54)"]),
        ([*KEPLER, "--constant", "E"], 2, ["p"]),
        (["verify", "kepler-planar", "-W", "p*theta + integral(sqrt(2*m*(E - k/r) - p**2/r**2), r)",
          "--constant", "E", "--constant", "p"], 1, ["No: H(q, dW/dq) = E fails", "A witness"]),
        ([*OSCILLATOR, "-S", PLACE_TO_PLACE, "--constant", "a"], 0, ["(5-52)"]),
        ([*OSCILLATOR, "-S", PLACE_TO_PLACE.replace("x**2 + a", "x**2 - a"), "--constant", "a"], 1, ["fails"]),
        ([*OSCILLATOR, "-W", "x/2*sqrt(2*E - x**2) + E*asin(x/sqrt(2*E))", "--constant", "E: 0 < E"], 0, ["Yes"]),
        ([*OSCILLATOR, "-S", "a*t + b*x", "-W", "x", "--constant", "a"], 2, ["one of them"]),
        ([*OSCILLATOR, "-W", "x"], 2, ["name the constants"]),
        (["verify", "hamiltonian-q-plus-p", "-S", "-alpha*t + alpha*q - q**2/2", "--constant", "alpha"], 0, ["Yes"]),
    ],
    ids=["Kepler", "constant missing", "wrong sign", "(5-108)", "wrong sign in (5-108)", "domain of a constant",
         "both", "no constants", "P5-1"],
)  # fmt: skip
def test_a_typed_complete_integral_is_proved_or_refuted(
    arguments: list[str], status: int, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert_told(arguments, status, words, capsys)


def test_what_was_not_decided_is_status_3_and_says_what_was_left(capsys: pytest.CaptureFixture[str]) -> None:
    """W is no sum: its slope in y holds an integral over x that nothing evaluates."""
    plane = ["--coordinate", "x: line", "--coordinate", "y: line", "-T", "(dot(x)**2 + dot(y)**2)/2"]
    W = "integral(sqrt(E + a*x*y), x)"
    assert main(["verify", *plane, "-W", W, "--constant", "E", "--constant", "a"]) == 3
    out = capsys.readouterr().out
    assert all(word in out for word in ("Not decided", "∫", "closed form"))


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["Q = atan(q/p)", "P = (q**2 + p**2)/2", "--domain", "p: 0 < p"], 0, ["with the valence 1", "F₁ = "]),
        (["Q = a*q", "P = b*p", "--constant", "a", "--constant", "b"], 0, ["valence a b", "not independent"]),
        (["Q = q + p", "P = p*q"], 1, ["No: (Q, P) is not a constant"]),
        (["--generating", "F2 = (P + m*v)*(q - v*t)", "--constant", "m: 0 < m", "--constant", "v",
          "--hamiltonian", "p**2/(2*m)"], 0, ["P = p − m v", "K = "]),
        (["Q1 = q1 - q2", "Q2 = q2", "P1 = p1", "P2 = p1 + p2", "--pair", "q1: p1", "--pair", "q2: p2"], 0, ["F₂"]),
        (["Q1 = q1 - q2", "Q2 = q2", "P1 = p1", "P2 = p1 - p2", "--pair", "q1: p1", "--pair", "q2: p2"], 1, ["No"]),
        (["Q"], 2, ["not an equation"]),
        (["Q = q", "P = p", "--pair", "q"], 2, ["a colon between them"]),
        ([], 2, ["give a map"]),
    ],
    ids=["P6-8", "Ex 6-10", "not canonical", "Ex 6-5", "two pairs", "two pairs, wrong", "no equation", "no pair", "none"],
)  # fmt: skip
def test_a_typed_map_is_proved_canonical_or_refuted(
    arguments: list[str], status: int, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["canonical", *arguments]) == status
    out, error = capsys.readouterr()
    assert all(word in out + error for word in words)


PLANE = ["--coordinate", "x: line", "--coordinate", "y: line", "-T", "(dot(x)**2 + dot(y)**2)/2"]
KEPLER_PLANE = [*PLANE, "-V", "-1/sqrt(x**2 + y**2)"]
RHOMBUS = ["--coordinate", "q1: line", "--coordinate", "q2: line", "-T", "2*dot(q1)**2 + dot(q2)**2/3"]
HIT = ["--q", "q1=0", "q2=0", "--velocity", "q1=-1", "q2=0", "--meets", "dot(q1) - dot(q2)/2 = 0"]
SLIDES = ["--q", "x=3/5", "y=4/5", "--velocity", "x=0", "y=0"]
PARABOLIC = ["--place", "x = (u**2 - v**2)/2", "--place", "y = u*v", "--new", "u: 0 < u", "--new", "v: line"]
POLAR = ["--place", "x = r*cos(phi)", "--place", "y = r*sin(phi)", "--new", "phi: angle"]
LENZ = "p_y*(x*p_y - y*p_x) - x/sqrt(x**2 + y**2)"


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["bracket", *PLANE, "--of", "p_x", "--of", "x*p_y - y*p_x"], 0, ["(6-212)", "−p_y"]),
        (["bracket", "spherical-pendulum", "--of", "H", "--of", "p_phi"], 0, ["0"]),
        (["bracket", "hamiltonian-q-plus-p", "--of", "q", "--of", "H"], 0, ["1"]),
        (["bracket", *PLANE, "--of", "p_x"], 2, ["two functions"]),
        (["integral", *KEPLER_PLANE, "--of", LENZ], 0, ["an integral of the motion"]),
        (["integral", *KEPLER_PLANE, "--of", LENZ, "--of", "x*p_y - y*p_x"], 0, ["not in involution"]),
        (["integral", "kepler-planar", "--of", "p_theta", "--of", "H"], 0, ["they are in involution"]),
        (["integral", "kepler-planar", "--of", "p_theta", "--of", "p_r"], 1, ["not an integral", "A witness"]),
        (["integral", "--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**2/2", "--of", "atan(x/p_x) - t"], 0, []),
        (["integral", "kepler-planar"], 2, ["--of p_theta"]),
        (["impact", *RHOMBUS, *HIT], 0, ["−3/5", "−6/5", "lost 4/5", "8/5", "c₁ + ½ q₂"]),
        (["impact", *RHOMBUS, *HIT, "--restitution", "1"], 0, ["lost 0", "Both are balanced"]),
        (["impact", *PLANE, "--q", "x=3", "y=4", "--velocity", "x=5", "y=0", "--meets", "x**2 + y**2 = 25"], 0,
         ["16/5", "−12/5", "lost 9/2"]),
        (["impact", *RHOMBUS, *HIT[:-2]], 2, ["--meets"]),
        (["impact", *RHOMBUS, *HIT[-2:]], 2, ["--q and --velocity"]),
        (["impact", *RHOMBUS, *HIT, "--restitution", "2"], 2, ["from 0"]),
        (["forces", *PLANE, "--holds", "y = 3*x**2"], 0, ["ẍ = −6 λ₁ x", "(5-22)", "6 ẋ²/(36 x² + 1)"]),
        (["forces", *PLANE, "--constraint", "y = 3*x**2"], 0, ["ẍ = −6 λ₁ x"]),
        (["forces", *PLANE], 2, ["give constraints"]),
        (["check", *PLANE, "--constraint", "y = 3*x**2"], 0, ["The constraints exert the forces", "λ = 6 ẋ²/(36 x² + 1)"]),
        (["contact", *PLANE, "-V", "y", *SLIDES, "--holds", "x**2 + y**2 >= 1"], 0,
         ["λ = (3/2) sin θ − E", "0.5333333333333333", "lets go", "is proved"]),
        (["contact", *PLANE, "-V", "y", *SLIDES, "--holds", "x**2 + y**2 >= 1", "--until", "1"], 0, ["does not end before t = 1"]),
        (["contact", *PLANE, "-V", "y", *SLIDES], 2, ["--holds"]),
        (["contact", *PLANE, "-V", "y", "--holds", "y >= 0"], 2, ["--q and --velocity"]),
        (["coordinates", *KEPLER_PLANE, *PARABOLIC], 0, ["Separates in u and v", "keeps its sign", "hjsolve solve"]),
        (["coordinates", *KEPLER_PLANE, *POLAR, "--new", "r: -1 < r"], 2, ["changes its sign"]),
        (["coordinates", *KEPLER_PLANE, "--place", "x"], 2, ["not an equation"]),
    ],
)  # fmt: skip
def test_the_other_tools_of_the_theorem(
    arguments: list[str], status: int, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert_told(arguments, status, words, capsys)


@pytest.mark.parametrize(("W", "status"), [("sqrt(2*E - x**2)", 0), ("sqrt(2*E + x**2)", 1)])
def test_a_complete_integral_is_compared_with_a_motion(W: str, status: int, capsys: pytest.CaptureFixture[str]) -> None:
    given = [*OSCILLATOR, "-W", f"integral({W}, x)", "--constant", "E", "--q", "x=3/10", "--velocity", "x=1"]
    assert main(given) == status
    assert ("agree with the motion" in capsys.readouterr().out) == (status == 0)


def test_answers_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    """What is printed is one object, exact numbers as text."""
    assert main(["impact", *RHOMBUS, *HIT, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["impact"]["velocity"] == {"q1": "-3/5", "q2": "-6/5"}
    assert found["next_arc"][0]["eliminated"] == {"q1": "c_1 + q2/2"}
    assert found["budget"] == {"q1": "0", "q2": "0", "energy": "0"}
    assert main(["contact", *PLANE, "-V", "y", *SLIDES, "--holds", "x**2 + y**2 >= 1", "--json"]) == 0
    left = json.loads(capsys.readouterr().out)
    assert (left["ended"], left["proved"], left["along"]["x**2 + y**2 >= 1"]) == (
        ["x**2 + y**2 >= 1"], True, "-E + 3*sin(theta)/2"
    )  # fmt: skip
    assert abs(left["q"]["y"]["value"] - 8 / 15) < 1e-15
    assert main(["integral", "kepler-planar", "--of", "p_r", "--json"]) == 1
    flaw = json.loads(capsys.readouterr().out)["integrals"]["p_r"]
    assert (flaw["kind"], flaw["witness"]["point"]["r"]) == ("Flaw", "3/2")
    assert main([*OSCILLATOR, "-W", "integral(sqrt(2*E - x**2), x)", "--constant", "E", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["answer"]["determinant"] == "1/sqrt(2*E - x**2)"
    assert main(["canonical", "Q = a*q", "P = b*p", "--constant", "a", "--constant", "b", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["answer"]["valence"] == "a*b"
    assert main(["bracket", *PLANE, "--of", "x", "--of", "p_x", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [{"f": "x", "g": "p_x", "bracket": "1"}]
