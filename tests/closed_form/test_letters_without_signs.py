"""Forms where no letter has an assumed sign: anomalies, shifts, even variables; values against the quadrature."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.regime import sign_is_fixed

PLACE, FASTER = {"x": "0.5"}, {"x": "0.3"}
LINES = {
    "shifted tanh squared": ("U*tanh((x - b)/a)**2", "line", {"U": 1, "a": "0.8", "b": "0.2"}),
    "Tietz": ("D*((1 - exp(-a*(x - b)))/(1 + c*exp(-a*(x - b))))**2", "line", {"D": 2, "a": "0.8", "b": "0.3", "c": "0.2"}),
    "one over cosh": ("-U/cosh(x/a)", "line", {"U": 1, "a": "0.8"}),
    "sinh squared": ("U*sinh(a*x)**2", "line", {"U": 1, "a": "0.8"}),
    "two cosines, hyperbolic": ("A*cosh(2*a*x) - B*cosh(a*x)", "line", {"A": "0.3", "B": 1, "a": 1}),
    "catenary as a potential": ("A*cosh(x/a)", "line", {"A": 1, "a": "0.8"}),
}  # fmt: skip


def _form(V: str, domain: str, letters: dict[str, object]) -> RegimeForms:
    system = hjsolve.System({"x": domain}, "m*dot(x)**2/2", V, {"m": 1, **letters})
    form = own_form(hjsolve.solve(system).motion(q=PLACE, velocity=FASTER))
    assert form is not None
    return form


def _period(form: RegimeForms) -> mpmath.mpf:
    """2 ∫ m dx/p between the turning points, in 110 digits, x = c − h cos u."""
    (square,), (x,) = form.solution.momentum_squared.values(), (form.solution.system.coordinates[0].symbol,)
    at = dict(form.regime.example)
    with mpmath.workdps(110):
        p2 = sp.lambdify(x, square.xreplace(at), "mpmath")
        ends = []
        for side in (-1, 1):
            inside, outside = mpmath.mpf("0.5"), mpmath.mpf("0.5")
            while p2(outside) > 0:
                inside, outside = outside, outside + side * mpmath.mpf("0.05")
            for _ in range(400):
                middle = (inside + outside) / 2
                inside, outside = (middle, outside) if p2(middle) > 0 else (inside, middle)
            ends.append(inside)
        low, high = ends
        c, h, m = (low + high) / 2, (high - low) / 2, mpmath.mpf(str(at[form.solution.system.symbols["m"]]))
        return 2 * mpmath.quad(
            lambda u: m * h * mpmath.sin(u) / mpmath.sqrt(p2(c - h * mpmath.cos(u))), [0, mpmath.pi / 2, mpmath.pi]
        )


@pytest.mark.nightly_cases(*list(LINES)[1:])
@pytest.mark.parametrize("name", LINES)
def test_periods_and_a_place_in_one_line(name: str) -> None:
    form = _form(*LINES[name])
    given = {s.name: v for s, v in form.regime.example.items()}
    value, expected = form.evaluate("periods.x", given, 50).value, _period(form)
    with mpmath.workdps(110):
        assert abs(value - expected) <= abs(expected) * mpmath.mpf(10) ** -40
    place = form.inverse.get("x", form.anomaly.get("x"))
    assert place is not None
    assert sp.count_ops(place) < 30
    assert not any("Carlson" in type(f).__name__ for f in form.named()["time_law"].atoms(sp.Function))


def test_a_shift_changes_no_energy() -> None:
    a, U, m, J = (sp.Symbol(n, real=True) for n in ("a", "U", "m", "J_x"))
    form = _form(*LINES["shifted tanh squared"])
    positive = {s: sp.Symbol(s.name, positive=True) for s in (a, U, m, J)}
    expected = U - (sp.sqrt(2 * m * U) - J / a) ** 2 / (2 * m)  # Flügge, problem 39: the quantum levels' limit
    assert sp.simplify((form.energy - expected).xreplace(positive)) == 0


def test_kepler_and_its_core_without_signs() -> None:
    """Kratzer's: r = a(1 − e cos ξ), n(t − t_p) = ξ − e sin ξ, though only E m < 0 and D a m > 0 are known."""
    system = hjsolve.System(
        {"r": "0 < r", "theta": "angle"}, "m*(dot(r)**2 + r**2*dot(theta)**2)/2",
        "-2*D*(a/r - a**2/(2*r**2))", {"m": 1, "D": 1, "a": "1.2"},
    )  # fmt: skip
    form = own_form(hjsolve.solve(system).motion(q={"r": 1, "theta": 0}, velocity={"r": "0.1", "theta": 1}))
    assert form is not None
    assert str(form.anomaly["r"]) == "a_1*(-e*cos(xi) + 1)"
    assert str(form.anomaly["t"]) == "t_p + (-e*sin(xi) + xi)/n"
    assert str(form.orbit["r"]) == "p/(e*cos(kappa*(theta - theta_p)) + 1)"
    assert "anomaly.theta" in form.named()


def test_a_fall_is_a_cycloid() -> None:
    system = hjsolve.System({"x": "0 < x"}, "m*dot(x)**2/2", "-k/x", {"m": 1, "k": 1})
    form = own_form(hjsolve.solve(system).motion(q={"x": 1}, velocity={"x": "0.3"}))
    assert form is not None
    assert str(form.anomaly["x"]) == "a*(1 - cos(xi))"
    assert str(form.anomaly["t"]) == "t_p + (xi - sin(xi))/n"


def test_signs_of_products() -> None:
    E, k, m = sp.symbols("E k m", real=True)
    relations = [E * m < 0, k * m > 0]
    assert sign_is_fixed(relations, k / E)
    assert sign_is_fixed(relations, E * k * m**2)
    assert not sign_is_fixed(relations, k)
    assert not sign_is_fixed(relations, E * k * m)
    assert not sign_is_fixed([sp.Ne(k, 0)], k)
