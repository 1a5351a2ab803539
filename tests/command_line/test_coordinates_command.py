"""``hjsolve coordinates``: webs with their places, the command that goes on, normal modes, exit statuses."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
import sympy as sp

from hjsolve import Separation, System, find_coordinates, separate
from hjsolve.command_line.main import main
from hjsolve.coordinates.killing.killing_tensors import kernel, killing_basis
from hjsolve.coordinates.killing.special_parameters import exceptional_values
from hjsolve.reports.sections.coordinates import command

Capture = pytest.CaptureFixture[str]
PLANE = ["--coordinate", "x: line", "--coordinate", "y: line", "-T", "m/2*(dot(x)**2 + dot(y)**2)"]
TWO_CENTRES = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)"


def asked(capture: Capture, *arguments: str) -> tuple[int, str]:
    status = main(["coordinates", *arguments])
    return status, capture.readouterr().out


def test_two_centres_are_found_with_foci_and_a_command_that_goes_on(capsys: Capture) -> None:
    status, out = asked(capsys, *PLANE, "-V", TWO_CENTRES, "--parameter", "m=2")
    assert status == 0
    assert "Separates in 1 orthogonal coordinate system: elliptic. It has 2 quadratic integrals" in " ".join(out.split())
    for line in ("Centre    (2, ½)", "(1, 2)", "(3, −1)", "certified: it separates"):
        assert line in out
    going_on = shlex.split(next(line for line in out.splitlines() if line.startswith("hjsolve solve")))
    assert main(["check", *going_on[2:]]) == 0
    assert "Separates in μ and ν" in capsys.readouterr().out


def test_the_command_of_every_web_is_read_back_as_the_same_system() -> None:
    system = System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "-k/sqrt(x**2 + y**2)", {"k": None})
    for web in find_coordinates(system).webs:
        words = shlex.split(command(web.system))
        pairs = list(zip(words[2::2], words[3::2]))
        places = dict(value.split(": ") for option, value in pairs if option == "--coordinate")
        (kinetic,) = [value for option, value in pairs if option == "-T"]
        (potential,) = [value for option, value in pairs if option == "-V"]
        again = System(places, kinetic, potential, {"k": None})
        assert [c.domain for c in again.coordinates] == [c.domain for c in web.system.coordinates]
        assert isinstance(separate(again), Separation)
        assert sp.simplify(again.kinetic - web.system.kinetic.subs(web.system.symbols["k"], again.symbols["k"])) == 0


def test_a_family_is_described(capsys: Capture) -> None:
    status, out = asked(capsys, *PLANE, "-V", "-k/sqrt(x**2 + y**2)", "--parameter", "m=1", "--parameter", "k=1")
    assert status == 0
    assert "One of a family with 1 free parameter: focus at (0, 0); axis in any direction." in out
    assert "4 quadratic integrals" in " ".join(out.split())


def test_nothing_found_is_status_1_and_never_called_not_integrable(capsys: Capture) -> None:
    status, out = asked(capsys, "henon-heiles")
    assert status == 1
    words = " ".join(out.replace("|", " ").split())
    assert "No orthogonal coordinates were found" in words
    assert "may still be integrable" in words
    assert "nonintegrable" not in words
    assert "not integrable" not in words


def test_values_of_parameters_with_more_integrals_are_listed(capsys: Capture) -> None:
    potential = "(A*x**2 + B*y**2)/2 + x**2*y + C*y**3"
    status, out = asked(
        capsys, *PLANE, "-V", potential, *(f"--parameter={name}" for name in ("A", "B", "C")), "--parameter=m=1"
    )
    assert status == 1
    assert "C = 2 " in out
    assert "B = A, C = ⅓  2" in out


def test_springs_are_taken_to_their_normal_modes(capsys: Capture) -> None:
    three = ["--coordinate", "x: line", "--coordinate", "y: line", "--coordinate", "z: line", "--coordinate", "w: line"]
    kinetic = "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2 + dot(w)**2)"
    potential = "k/2*((x - y)**2 + (y - z)**2 + (z - w)**2)"
    status, out = asked(capsys, *three, "-T", kinetic, "-V", potential, "--parameter", "m=1", "--parameter", "k=1")
    assert status == 0
    assert "Separates in its 4 normal modes" in out
    assert "drift" in out
    assert "2 k/m" in out, "ω² = 2k/m (1 − cos(π/2)) of the chain of four, Greenwood's method in (2-254)"


@pytest.mark.parametrize("name", ["pendulum", "crossed-fields"])
def test_what_is_not_cartesian_is_told_what_to_write(name: str, capsys: Capture) -> None:
    assert main(["coordinates", name]) in {1, 2}
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.strip().splitlines()) == 1


def test_a_positive_parameter_as_a_pivot_is_no_fault() -> None:
    """The only root of the pivot λ is excluded by the assumption; it is not a fault and no exceptional value."""
    x, y = sp.symbols("x y", real=True)
    λ = sp.Symbol("lambda_", positive=True)
    V = (x**2 + y**2) / 2 + λ * (x**2 * y - y**3 / 3)
    basis = killing_basis((x, y))
    assert exceptional_values(V, (x, y), basis, kernel(V, (x, y), basis)) == ((), True)
    free = sp.Symbol("mu", real=True)
    found, all_of_them = exceptional_values(V.subs(λ, free), (x, y), basis, kernel(V.subs(λ, free), (x, y), basis))
    assert all_of_them
    assert [(dict(one.conditions), one.dimension) for one in found] == [({free: 0}, 4)]


@pytest.mark.nightly
def test_solve_and_report_go_on_in_the_coordinates_found(capsys: Capture, tmp_path: Path) -> None:
    assert main(["solve", "--find", *PLANE, "-V", TWO_CENTRES, "--parameter", "m=2"]) == 0
    out = capsys.readouterr().out
    for line in ("Coordinates found: elliptic", "T = ½ m (ẋ² + ẏ²)", "the only web", "x = 2 + (3/2) sin ν sinh μ"):
        assert line in out
    start = ["--q", "x=0.3", "--q", "y=0.4", "--velocity", "x=0", "--velocity", "y=0.1"]
    target = tmp_path / "found.md"
    assert main(["report", "--find", *PLANE, "-V", TWO_CENTRES, "--parameter", "m=2", *start, "-o", str(target)]) == 0
    text = target.read_text(encoding="utf-8")
    assert "Coordinates found: elliptic" in text
    assert "periodic in $\\mu$ and $\\nu$" in text


def test_find_of_what_separates_nowhere_ends_with_1(capsys: Capture) -> None:
    potential = "(x**2 + y**2)/2 + x**2*y - y**3/3"
    assert main(["solve", "--find", *PLANE, "-V", potential, "--parameter", "m=1"]) == 1
    assert "not separable by a point transformation" in "".join(capsys.readouterr())
