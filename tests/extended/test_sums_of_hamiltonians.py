"""H of several degrees of freedom and any degree in p that is a sum: its parts, and its motions against scipy and mpmath."""

from __future__ import annotations

import pickle
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import hjsolve
from hjsolve.motion.state import AnyMotion

SUMS: dict[str, tuple[str, dict[str, str], dict[str, Any], dict[str, str], dict[str, str], list[list[str]]]] = {
    "a quartic and an oscillator": (
        "p_x**4 + k*x**2 + p_y**2/2 + a*y**4/4", {"x": "line", "y": "line"}, {"k": 1, "a": 2},
        {"x": "1", "y": "1"}, {"x": "0", "y": "0.3"}, [["x"], ["y"]]),
    "first degree and a square root": (
        "x*p_x + sqrt(1 + p_y**2) + y**2", {"x": "line", "y": "line"}, {},
        {"x": "1/2", "y": "1"}, {"x": "2", "y": "0.1"}, [["x"], ["y"]]),
    "a pair that is coupled": (
        "p_r**2/2 + p_f**2/(2*r**2) - 1/r + (p_z**2 + z**2)**2", {"r": "0 < r", "z": "line", "f": "angle"}, {},
        {"r": "1", "f": "0", "z": "1/2"}, {"r": "0", "f": "1.1", "z": "1/3"}, [["r", "f"], ["z"]]),
    "a product that has to be expanded": (
        "(p_x**2 + x**2)**2 + p_y**4 + y**2 + (x + 1)*(x - 1)", {"x": "line", "y": "line"}, {},
        {"x": "1", "y": "1/3"}, {"x": "1/2", "y": "1/4"}, [["x"], ["y"]]),
}  # fmt: skip


@pytest.mark.parametrize("name", SUMS)
def test_each_part_moves_by_its_own_hamiltonian(name: str) -> None:
    text, coordinates, parameters, q, p, groups = SUMS[name]
    problem = hjsolve.from_hamiltonian(text, coordinates, parameters)
    assert [[c.name for c in part.coordinates] for part in problem.parts] == groups
    motion = problem.motion(q=q, p=p)
    assert isinstance(motion, AnyMotion)
    names = [c.name for c in problem.coordinates]
    symbols = [c.symbol for c in problem.coordinates] + [c.momentum for c in problem.coordinates]
    H = problem.hamiltonian.subs({x.symbol: x.value for x in problem.parameters})
    slopes = [sp.diff(H, c.momentum) for c in problem.coordinates] + [
        -sp.diff(H, c.symbol) for c in problem.coordinates
    ]
    rates = sp.lambdify(symbols, slopes)
    start = [float(sp.Rational(group[n])) for group in (q, p) for n in names]
    twin = solve_ivp(lambda _t, y: rates(*y), (0, 3), start, "DOP853", rtol=1e-12, atol=1e-13, t_eval=[1.3, 3.0])
    state = motion.at(np.array([1.3, 3.0]))
    found = np.array([state.unwrapped(n) for n in names] + [state.p[n] for n in names], dtype=float)
    assert np.allclose(found, twin.y, rtol=1e-9, atol=1e-10)
    assert set(state.status) == {"ok"}
    E = motion.constants["E"]
    assert abs(E.value - float(H.subs(dict(zip(symbols, start, strict=True))))) <= E.error + 1e-15
    parts = [motion.constants[f"E_{'_'.join(group)}"].value for group in groups]
    assert abs(sum(parts) - E.value) < 1e-15 * (1 + sum(map(abs, parts)))
    assert all(np.all(np.abs(np.asarray(state.error.q[n], dtype=float)) < 1e-12) for n in names)
    assert pickle.loads(pickle.dumps(problem)).hamiltonian == problem.hamiltonian


def test_numbers_of_the_parts_and_many_digits() -> None:
    """p⁴ + x² has the period ∮ dx/(4 p³) and the action (1/2π) ∮ p dx; the oscillator 2π."""
    problem = hjsolve.from_hamiltonian("p_x**4 + x**2 + p_y**2/2 + w**2*y**2/2", {"x": "line", "y": "line"}, {"w": 1})
    motion = problem.motion(q={"x": 1, "y": 2}, p={"x": 0, "y": 0}, parameters={"w": 2}, digits=30)
    with mpmath.workdps(40):
        beta = mpmath.beta(mpmath.mpf(1) / 4, mpmath.mpf(1) / 2)  # ∫₀¹ (1 − x²)^(−3/4) dx = B(1/2, 1/4)/2
        assert abs(motion.periods["x"].value - beta / 2) < mpmath.mpf(10) ** -28
        assert abs(motion.periods["y"].value - mpmath.pi) < mpmath.mpf(10) ** -28
        y = motion.at("1/3").q["y"]
        assert abs(y - 2 * mpmath.cos(mpmath.mpf(2) / 3)) < mpmath.mpf(10) ** -28
    assert motion.turning_points["y"][1].value == 2
    assert motion.kinds == {"x": "libration", "y": "libration"}


@pytest.mark.parametrize(("H", "message"), [
    ("(p_x**2 + p_y**2)**2 + x**2", "quadratic in the momenta"),
    ("p_x**4 + p_y**4 + x*y", "quadratic in the momenta"),
    ("p_x**4 + x**2 + y**2", "no p_y"),
])  # fmt: skip
def test_what_is_no_sum_is_refused_as_before(H: str, message: str) -> None:
    with pytest.raises(hjsolve.InvalidSystemError, match=message):
        hjsolve.from_hamiltonian(H, {"x": "line", "y": "line"})


def test_wrong_names_are_refused() -> None:
    problem = hjsolve.from_hamiltonian("p_x**4 + x**2 + p_y**2 + a*y**2", {"x": "line", "y": "line"}, {"a": 1})
    start = {"q": {"x": 1, "y": 1}, "p": {"x": 0, "y": 0}}
    for change in ({"q": {"x": 1, "y": 1, "z": 0}}, {"parameters": {"b": 1}}):
        with pytest.raises(hjsolve.InvalidInputError, match="is not one of"):
            problem.motion(**{**start, **change})
    with pytest.raises(hjsolve.MissingValueError):
        problem.motion(q={"x": 1}, p={"x": 0, "y": 0})
