"""``hjsolve verify`` and ``hjsolve canonical``: the book's examples typed, with the three exit statuses."""

from __future__ import annotations

import pytest

from hjsolve.command_line.main import main

KEPLER = ["verify", "kepler-planar", "-W", "p*theta + integral(sqrt(2*m*(E + k/r) - p**2/r**2), r)"]
OSCILLATOR = ["verify", "--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**2/2"]
PLACE_TO_PLACE = "((x**2 + a**2)*cos(t) - 2*x*a)/(2*sin(t))"


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
    assert main(arguments) == status
    out, error = capsys.readouterr()
    assert all(word in out + error for word in words)
    assert (out == "") == (status == 2)


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
