"""t(q), orbit equations and W of systems that books name, at random constants: 40 digits against ∫ of the printed integral.

Of Kerr's holes that is Mino's time, t and φ (Carter 1968, eqs. 61 to 64), of Lagrange's top φ and ψ with Π (Whittaker
§ 71), of two centres and Stark's atom the quadratures in τ, of an ellipsoid of revolution the longitude.
"""

from __future__ import annotations

from collections.abc import Callable

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.regions import root_interval_of
from hjsolve.closed_form.sampling import Sample, samples
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.precision import mp
from tests.support.entries import forms
from tests.support.gauss import gauss
from tests.support.turns import in_the_turn

STEP = sp.Rational(1, 10**4)
ENTRIES = {
    "kepler-planar": 6, "isochrone": 6, "morse": 4, "poeschl-teller": 4, "projectile": 6, "harmonic-oscillator": 4, "stark": 10,
    "two-centres-plane": 20, "two-centres-space": 20, "pendulum": 6, "bead-on-turning-wire": 6, "double-well": 6,
    "spherical-pendulum": 8, "lagrange-top": 8, "schwarzschild": 15, "kerr": 20, "oblate-geodesics": 8, "liouville-p5-6": 10,
}  # fmt: skip
"""Entry ↦ how many integrals are compared at least."""
PARTS = {
    "kerr": {"time_law", "orbit_equations.p_t", "orbit_equations.p_phi", "orbit_equations.alpha_2"},
    "lagrange-top": {"time_law", "orbit_equations.p_phi", "orbit_equations.p_psi"},
    "spherical-pendulum": {"time_law", "orbit_equations.p_phi"}, "oblate-geodesics": {"orbit_equations.p_lambda_"},
    "stark": {"time_law", "orbit_equations.alpha_2", "orbit_equations.p_phi"},
    "two-centres-space": {"time_law", "orbit_equations.alpha_2", "orbit_equations.p_phi"},
}  # fmt: skip


NIGHTLY = ("kerr", "schwarzschild", "two-centres-plane", "two-centres-space")


@pytest.mark.rotating(4)
@pytest.mark.nightly_cases(
    "liouville-p5-6", "bead-on-turning-wire", "isochrone", "pendulum", "lagrange-top", "oblate-geodesics", "spherical-pendulum", "stark"
)
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.nightly] if n in NIGHTLY else []) for n in ENTRIES]
)
def test_integrals_at_random_constants(name: str) -> None:
    solution = hjsolve.solve(name)
    general = [form for form in forms(name) if not form.regime.special]
    compared, parts = 0, set[str]()
    for sample in samples(solution, 12, 77):
        for form in general:
            if form.regime.holds(sample.values) and _on_its_piece(form, sample):
                found = _compared(form, sample)
                compared, parts = compared + len(found), parts | found
    assert compared >= ENTRIES[name]
    assert parts >= {"characteristic_function", *PARTS.get(name, ())}


def _on_its_piece(form: RegimeForms, sample: Sample) -> bool:
    found = [(root_interval_of(curve, sample), region) for curve, region in form.regime.regions]
    return all(there is not None and there.key == region.key for there, region in found)


def _compared(form: RegimeForms, sample: Sample) -> set[str]:
    """The integrals of a form that are those of the solution, from the place of the sample a little on."""
    solution, values = form.solution, dict(sample.values)
    for k, c in enumerate(solution.system.coordinates):
        if c.name in solution.coordinates:
            begin = in_the_turn(form, c.name, sample)
            values |= {c.symbol: _beside(solution, c, begin, sample), solution.lower_limits[c.name]: begin}
        else:
            values[c.symbol] = sp.Rational(k + 2, 7)
    time = sp.Symbol("t", real=True)
    values[time] = sp.Rational(3, 11)
    integrals = {f"orbit_equations.{n}": e.rhs for n, e in solution.orbit_equations.items()}
    integrals |= {"time_law": solution.time_law.rhs, "characteristic_function": solution.characteristic_function}
    compared = set[str]()
    for name, expression in form.named().items():
        if name not in integrals:
            continue
        with mp.workdps(60):
            expected = _quadrature(integrals[name], values)
        known = {*form.regime.example, *needed_names(expression.free_symbols, form.where)[1]}
        got = form.evaluate(name, {s.name: v for s, v in values.items() if s in known}, 40)
        assert abs(got.value - expected) + got.error <= 1e-38 * abs(expected), (name, form.regime.words, got, expected)
        compared.add(name)
    return compared


def _beside(solution: hjsolve.Solution, c: Coordinate, begin: sp.Expr, sample: Sample) -> sp.Expr:
    """A place near another one, on the side on which p² is greater: away from the nearest turning point."""
    square, numbers = solution.momentum_squared[c.name], many_digits(sample.values, 30)
    with mp.workdps(30):
        return max(
            (begin - STEP, begin + STEP), key=lambda q: number_of(square, numbers | many_digits({c.symbol: q}, 30))
        )


def _quadrature(expression: sp.Expr, values: dict[sp.Symbol, sp.Expr]) -> mpmath.mpf:
    """An expression with integrals, each by the rule of Gauss and Legendre."""
    numbers = many_digits(values, 60)
    total = number_of(expression.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero), numbers)
    for term in sp.Add.make_args(expression):
        for integral in term.atoms(sp.Integral):
            q, low, high = integral.limits[0]
            factor = number_of(term / integral, numbers)
            integrand = integral.function
            total += factor * _integral(
                lambda x, q=q, integrand=integrand: number_of(integrand, {**numbers, q: x}), numbers[low], numbers[high]
            )
    return total


def _integral(integrand: Callable[[mpmath.mpf], mpmath.mpf], low: mpmath.mpf, high: mpmath.mpf) -> mpmath.mpf:
    """With ever shorter pieces towards the lower end, where a turning point may be near."""
    for pieces in (0, 10):
        cuts = [low, *(low + (high - low) / 8**k for k in range(pieces, 0, -1)), high]
        value, error = mp.quad(integrand, cuts, error=True, method=gauss)
        if error <= mp.mpf(10) ** -42 * abs(value):
            return value
    raise AssertionError(f"the reference itself is not known well enough: {value} ± {error}")
