"""Integrals of which only the value over a cycle has a form, and time laws that are a cubic in the root of P."""

from __future__ import annotations

import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form


def form_of(potential, domain, place, velocity, **letters):
    system = hjsolve.System({"x": domain}, "m*dot(x)**2/2", potential, {"m": 1, **letters})
    return own_form(hjsolve.solve(system).motion(q={"x": place}, velocity={"x": velocity}), seconds=60)


def between(form, potential, **values):
    """∮ p dx and ∮ dx/p between the turning points nearest to zero, by quadrature: (J, T)."""
    x = sp.Symbol("x", real=True)
    V = sp.lambdify(x, sp.sympify(potential).subs({"x": x, **values}), "mpmath")
    E, m = mp.mpf(values["E"]), mp.mpf(values["m"])
    low, high = (mp.findroot(lambda q: V(q) - E, start) for start in values["near"])
    p = lambda q: mp.sqrt(mp.re(2 * m * (E - V(q))))  # noqa: E731
    middle, half = (low + high) / 2, (high - low) / 2
    turn = lambda f: mp.quad(lambda u: f(middle + half * mp.sin(u)) * half * mp.cos(u), [-mp.pi / 2, 0, mp.pi / 2])  # noqa: E731
    return 2 * turn(p) / (2 * mp.pi), 2 * turn(lambda q: m / p(q))


@pytest.mark.parametrize("n", [8, 10])
def test_every_even_power_has_period_action_and_energy(n):
    form = form_of(f"A*x**{n}", "line", "0.5", "0.3", A=2)
    given = {"A": 3, "m": 2, "E": 7}
    with mp.workdps(30):
        r = (mp.mpf(7) / 3) ** (mp.mpf(1) / n)
        period = 4 * r / mp.sqrt(7) * mp.beta(mp.mpf(1) / n, mp.mpf(1) / 2) / n
        action = 2 * r * mp.sqrt(28) * mp.beta(mp.mpf(1) / n, mp.mpf(3) / 2) / n / mp.pi
        assert abs(form.evaluate("actions.x", given, 25).value / action - 1) < 1e-24
        assert abs(form.evaluate("periods.x", given, 25).value / period - 1) < 1e-24
        J_found = sp.Float(str(action), 30)
    energy = form.energy.subs({s: given[s.name] for s in form.energy.free_symbols if s.name in given})
    (J,) = energy.free_symbols
    assert abs(sp.N(energy.subs(J, J_found), 25) / 7 - 1) < 1e-23
    assert form.time_law is None
    assert "time_law" in form.why_not


def test_the_hyperbolic_scarf_potential_has_an_elementary_action_and_energy():
    V = "a/cosh(x/b)**2 + c*sinh(x/b)/cosh(x/b)**2"
    form = form_of(V, "line", "0.2", "0.1", a=-1, b=1, c="0.3")
    assert not form.actions["x"].atoms(sp.elliptic_k, sp.elliptic_pi)
    given = {"a": -2, "b": 1, "c": 1, "m": 1, "E": sp.Rational(-1, 2)}
    with mp.workdps(30):
        J, T = between(form, V, near=(mp.mpf("-1.6"), mp.mpf("0.9")), **given)
        assert abs(form.evaluate("actions.x", given, 20).value / J - 1) < 1e-15
        assert abs(form.evaluate("periods.x", given, 20).value / T - 1) < 1e-15
        J_found = sp.Float(str(J), 30)
    energy = form.energy.subs({s: given[s.name] for s in form.energy.free_symbols if s.name in given})
    (symbol,) = energy.free_symbols
    assert abs(sp.N(energy.subs(symbol, J_found), 25) * 2 + 1) < 1e-15


@pytest.mark.parametrize(("potential", "place", "velocity", "arc"), [
    ("a*sqrt(x)", "0.5", "-0.3", sp.asin), ("-a*sqrt(x)", "0.5", "0.3", sp.asinh), ("a*sqrt(b + x)", "1.5", "-0.2", sp.asin),
])  # fmt: skip
def test_a_time_law_that_is_a_cubic_in_the_root_is_solved(potential, place, velocity, arc):
    """Newton's equation along x(t), by differences; on both sides of a turning point, where there is one."""
    form = form_of(potential, "0 < x", place, velocity, a=1, **({"b": 2} if "b" in potential else {}))
    assert {type(f) for f in form.inverse["x"].atoms(sp.asin, sp.asinh)} == {arc}  # of real quantities
    assert "inverse.x" not in form.why_not
    V = sp.sympify(potential).subs({"a": 1, "b": 2})
    E = sp.nsimplify(velocity) ** 2 / 2 + V.subs("x", sp.nsimplify(place))
    law = sp.lambdify(sp.Symbol("t", real=True), at_numbers(form, "inverse.x", E, place), "mpmath")
    force, energy = sp.lambdify("x", -sp.diff(V, "x"), "mpmath"), sp.lambdify("x", V, "mpmath")
    with mp.workdps(30):
        for time in ("0.1", "0.2", "0.35", "0.5"):
            t = mp.mpf(time)
            q, slope, bend = (mp.re(mp.diff(law, t, k)) for k in range(3))
            assert abs(bend - force(q)) < 1e-8
            assert abs(slope**2 / 2 + energy(q) - mp.mpf(sp.N(E, 30))) < 1e-12


def at_numbers(form, name, energy, place):
    """The form at the motion, as a function of t, begun on the branch p > 0."""
    values = {"E": energy, "a": 1, "b": 2, "m": 1, "t_0": 0, "x_0": sp.nsimplify(place)}
    explicit = form.written_out(name)
    return explicit.xreplace({s: values[s.name] for s in explicit.free_symbols if s.name in values})
