"""V = A xⁿ and motions of one power: periods by Γ, E(J) by a power, x(t) at E = 0 by a power of the time."""

from __future__ import annotations

import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.closed_form.closed_forms import closed_forms, own_form

A, E, J, m, t, t_p = (sp.Symbol(name, real=True) for name in ("A", "E", "J_x", "m", "t", "t_p"))


def forms(potential, domain="line", **parameters):
    system = hjsolve.System({"x": domain}, "dot(x)**2/2", potential, parameters=parameters)
    return closed_forms(system)


def number(form, **values):
    plain = sp.sympify(form).xreplace({s: sp.Symbol(s.name) for s in sp.sympify(form).free_symbols})
    return mp.mpf(sp.N(plain.subs({sp.Symbol(k): v for k, v in values.items()}), 30)._to_mpmath(100))


@pytest.mark.parametrize("n", [4, 6])
def test_actions_and_periods_of_a_power_are_those_of_landau_and_lifshitz(n):
    (form,) = forms(f"A*x**{n}", A=None)
    assert form.regime.words.startswith("x: libration; A > 0, E > 0")
    with mp.workdps(30):
        r = (mp.mpf(7) / 3) ** (mp.mpf(1) / n)
        period = 4 * r / mp.sqrt(14) * mp.beta(mp.mpf(1) / n, mp.mpf(1) / 2) / n
        action = 2 * r * mp.sqrt(14) * mp.beta(mp.mpf(1) / n, mp.mpf(3) / 2) / n / mp.pi
        assert abs(number(form.periods["x"], A=3, E=7) / period - 1) < 1e-25
        assert abs(number(form.actions["x"], A=3, E=7) / action - 1) < 1e-25
        assert abs(number(form.energy, A=3, J_x=sp.Float(str(action), 30)) / 7 - 1) < 1e-25


def test_the_quartic_oscillator_is_written_with_gamma_of_a_quarter():
    (form,) = forms("A*x**4", A=None)
    assert form.periods["x"].atoms(sp.gamma) == {sp.gamma(sp.Rational(1, 4))}


@pytest.mark.parametrize(
    ("potential", "domain", "place"),
    [
        ("-A/x", "0 < x", sp.cbrt(sp.Rational(9, 2) * A * (t - t_p) ** 2)),  # Greenwood (7-185)
        ("A*x**3", "line", -2 / (A * (t - t_p) ** 2)),
        ("-A/x**4", "0 < x", sp.root(18 * A * (t - t_p) ** 2, 6)),
    ],
)
def test_x_of_t_at_energy_zero_is_a_power_of_the_time(potential, domain, place):
    form = next(f for f in forms(potential, domain, A=None) if "E = 0" in f.regime.words)
    for at in ({"A": 2, "t": 3, "t_p": 1}, {"A": 5, "t": -1, "t_p": 4}):
        assert abs(number(form.inverse["x"], **at) / number(place, **at) - 1) < 1e-25
    assert "inverse.x" not in form.why_not


@pytest.mark.nightly
def test_outside_the_tops_of_a_double_barrier_a_separatrix_is_a_hyperbolic_cotangent():
    outer = [f for f in forms("A*x**2/2 - B*x**4", A=None, B=None) if "asymptotic" in f.regime.words]
    assert sorted(str(next(iter(f.inverse["x"].atoms(sp.coth, sp.tanh))).func) for f in outer) == [
        "coth",
        "coth",
        "tanh",
    ]


def test_both_wells_of_a_sextic_have_periods():
    wells = [f for f in forms("-A*x**2/2 + B*x**6", A=None, B=None) if "E < 0" in f.regime.words]
    assert wells
    assert all({"x"} == set(f.periods) == set(f.actions) for f in wells)


SEXTICS = {
    "a wall on either side": ("A*x**6", "1/3", "2"),
    "in a parabola": ("x**2/2 + A*x**6", "1/3", "2"),
    "about another place": ("A*(x - B)**6", "1/3", "2"),
    "in one of two wells": ("-x**2/2 - A*x**4 + 2*x**6", "2/5", "1/5"),
    "between two barriers": ("-x**2/20 + 3*x**4 - A*x**6/4", "1/3", "1/10"),
}


@pytest.mark.parametrize("name", SEXTICS)
def test_x_of_t_in_a_sextic_well_is_a_root_of_an_elliptic_function(name):
    """Its curve has genus 2, and is elliptic in x². Against an integration of Newton's equation, past turning points."""
    potential, place, speed = SEXTICS[name]
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", potential, parameters={"A": "1/2", "B": "1/7"})
    motion = hjsolve.solve(system).motion(q={"x": place}, velocity={"x": speed})
    form = own_form(motion)
    assert {"time_law", "inverse.x"} <= set(form.named())
    assert not set(form.why_not) & {"time_law", "inverse.x"}
    x, V = sp.Symbol("x"), sp.sympify(potential).subs({"A": sp.Rational(1, 2), "B": sp.Rational(1, 7)})
    with mp.workdps(30):
        force, start = (
            sp.lambdify(x, -sp.diff(V, x), "mpmath"),
            [mp.mpf(sp.N(sp.Rational(v), 35)) for v in (place, speed)],
        )
        path = mp.odefun(lambda _, y: [y[1], force(y[0])], 0, start)
        for time in ("0.7", "2.9"):
            given = {"t": time, "t_0": "0", "x_0": place, "E": str(motion.initial.constants["E"])}
            assert abs(form.evaluate("inverse.x", given, 25).value - path(mp.mpf(time))[0]) < 1e-20
