"""Systems from H(q, p) of several freedoms: T and V by the Legendre transformation, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.system import hamiltonian

PLANE = {"x": "line", "y": "line"}
CASES = {
    "Kepler": ("p_r**2/(2*m) + p_theta**2/(2*m*r**2) - k/r", {"r": "0 < r", "theta": "angle"}, {"m": 2, "k": 3}),
    "coupled": ("p_x**2 + p_x*p_y/2 + p_y**2 + x**2*y", PLANE, {}),
    "field": ("(p_x + B*y/2)**2/2 + (p_y - B*x/2)**2/2 + x*y", PLANE, {"B": "1/3"}),
    "depends on place": ("(1 + x**2)*p_x**2/2 + p_x*p_y*sin(y)/4 + p_y**2 + x*p_y", PLANE, {}),
}


@pytest.mark.parametrize("name", CASES)
def test_the_hamiltonian_of_the_system_is_the_one_given(name):
    text, coordinates, parameters = CASES[name]
    system = hjsolve.from_hamiltonian(text, coordinates, parameters)
    symbols = system.symbols | {f"p_{c.name}": c.momentum for c in system.coordinates}
    assert sp.simplify(hamiltonian(system) - sp.sympify(text, locals=symbols)) == 0


def test_relativity_is_recognised():
    """The same motion as that of the catalog's entry, and no other words for m and c are needed."""
    text = "sqrt(M**2*w**4 + w**2*(p_r**2 + p_theta**2/r**2)) - k/r"
    own = hjsolve.from_hamiltonian(text, {"r": "0 < r", "theta": "angle"}, {"M": 1, "w": 10, "k": 1})
    assert (own.relativity.mass.name, own.relativity.light.name) == ("M", "w")
    entry = hjsolve.solve(hjsolve.catalog.load("relativistic-kepler"))
    given = {"q": {"r": 1, "theta": 0}, "p": {"r": "0.1", "theta": "1.1"}}
    names = [p.name for p in entry.system.parameters]
    values = {n: {"k": 1}.get(n, 10 if n == entry.system.relativity.light.name else 1) for n in names}
    theirs, ours = entry.motion(**given, parameters=values), hjsolve.solve(own).motion(**given)
    for n, value in theirs.frequencies.items():
        np.testing.assert_allclose(ours.frequencies[n].value, value.value, rtol=1e-15, atol=0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("p_x**4*y + p_y**2", "of several degrees of freedom H must be quadratic"),
        ("x*p_x + x*p_y", "of several degrees of freedom H must be quadratic"),
        ("x*p_x + x**2*p_y**2", "the velocities do not follow"),
        ("p_x**2 + y**2", "there is no p_y"),
        ("sqrt(1 + p_x**2 + p_y**2)", "rest mass"),
    ],
)
def test_what_is_neither_is_refused(text, words):
    with pytest.raises(InvalidSystemError, match=words):
        hjsolve.from_hamiltonian(text, PLANE)


def test_the_command_line_takes_h_itself(capsys):
    kepler = ["--coordinate", "r: 0 < r", "--coordinate", "theta: angle", "--parameter", "k=1"]
    assert main(["check", *kepler, "--hamiltonian", "p_r**2/2 + p_theta**2/(2*r**2) - k/r"]) == 0
    assert "Separates in r and θ" in capsys.readouterr().out
    assert main(["solve", "--coordinate", "q: line", "--hamiltonian", "q*p"]) == 0
    assert "H is linear in its momentum" in capsys.readouterr().out
    assert main(["check", *kepler, "--hamiltonian", "p_r**2/2", "-V", "1/r"]) == 2
    assert "takes the place of SYSTEM, --kinetic and --potential" in capsys.readouterr().err
    assert main(["check", "--coordinate", "q: line", "--hamiltonian", "p**4 + q**2"]) == 2
    assert "hjsolve.from_hamiltonian" in capsys.readouterr().err
    assert main(["check", "--hamiltonian", "p**2"]) == 2
    assert "needs --coordinate" in capsys.readouterr().err


def test_h_may_hold_the_time_where_it_is_of_second_degree_in_the_momenta() -> None:
    """Ex 6-9 and P6-13 given by H: the frame is found as it is for T and V; the driven one is solved by a quadratic S."""
    anchor = hjsolve.from_hamiltonian("p**2/(2*m) + k*(t - q)**2/2", {"q": "line"}, {"m": 1, "k": 1})
    assert hjsolve.solve(anchor).kind == "frame"
    posed = hjsolve.System({"q": "line"}, "m/2*dot(q)**2", "k*(t - q)**2/2", {"m": 1, "k": 1})
    given = {"q": {"q": "0.3"}, "velocity": {"q": "0.4"}, "t0": "1/2"}
    found, expected = (hjsolve.solve(s).motion(**given).at(2) for s in (anchor, posed))
    assert abs(found.q["q"] - expected.q["q"]) <= found.error.q["q"] + expected.error.q["q"]
    two = hjsolve.from_hamiltonian(
        "(p_x**2 + p_y**2)/2 + (2 + cos(t))*x**2 + y**2/2 + x*y*t", {"x": "line", "y": "line"}
    )
    assert hjsolve.solve(two).kind == "quadratic"
    for H in ("p**4 + q*t", "q*p + t**2*p", "exp(p) + t"):
        with pytest.raises(hjsolve.InvalidSystemError, match="with the time"):
            hjsolve.from_hamiltonian(H, {"q": "line"})
    root = "V*t + sqrt(m**2*c**4 + c**2*(p_x**2 + p_y**2))"
    with pytest.raises(hjsolve.InvalidSystemError, match="with the time"):
        hjsolve.from_hamiltonian(root, {"x": "line", "y": "line"}, {"V": 1, "m": 1, "c": 1})
