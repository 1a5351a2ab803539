"""Liouville's proofs hold where they should, and not of integrals whose antiderivative is written down."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.liouville import LinearBesideRational, NoRationalSolution, not_elementary
from hjsolve.closed_form.why_not import OfCoordinate

q = sp.Symbol("q", positive=True)
E, L, k, F, U, a, α = sp.symbols("E L k F U a alpha", real=True)

PROVED = {
    "log r": (E - k * sp.log(q) - L**2 / q**2, (1, 1 / q**2), LinearBesideRational),
    "log(r² + a²)": (E - k * sp.log(q**2 + a**2) - L**2 / q**2, (1, 1 / q**2), LinearBesideRational),
    "washboard": (E + U * sp.cos(a * q) + F * q, (1,), LinearBesideRational),
    "washboard, shifted": (E + U * sp.cos(q + α) - F * q * sp.sin(α), (1,), LinearBesideRational),
    "linear and exponential": (E - sp.exp(q) - F * q, (1,), LinearBesideRational),
    "a heavy disk": ((2 - sp.cos(q)) * (E + q + sp.cos(q + α)), (2 - sp.cos(q),), LinearBesideRational),
    "arc tangent": (E + sp.sin(q) * sp.atan(k * sp.sin(q)) - L**2 / sp.cos(q) ** 2, (1,), LinearBesideRational),
    "Gauss": (E + U * sp.exp(-(q**2) / a**2), (1,), NoRationalSolution),
    "Gauss in a parabola": (E - k * q**2 + U * sp.exp(-(q**2)), (1,), NoRationalSolution),
    "Yukawa": (E + k * sp.exp(-a * q) / q - L**2 / q**2, (1, 1 / q**2), NoRationalSolution),
}


@pytest.mark.parametrize("name", PROVED)
def test_potentials_whose_integrals_are_not_elementary(name: str) -> None:
    square, numerators, kind = PROVED[name]
    proof = not_elementary(square, map(sp.sympify, numerators), q)
    assert type(proof) is kind
    assert proof.proved
    assert str(proof).endswith("by Liouville's theorem its integrals are not elementary")


p = sp.Symbol("p", positive=True)
KNOWN = {
    "N is a multiple of (p²)′": (E - k * sp.log(q) - L**2 / q**2, p, L**2 / q**3 - k / (2 * q)),
    "and of A, a square": (q**2 * (E - k * sp.log(q)), p / q, -k / 2),
    "exponential": (4 - sp.exp(q), sp.log((2 + p) / (2 - p)), -2),
    "Gauss, with a factor q": (4 - U**2 * sp.exp(-(q**2)), sp.log((2 + p) / (2 - p)), 4 * q),
}


@pytest.mark.parametrize("name", KNOWN)
def test_an_elementary_integral_has_no_proof(name: str) -> None:
    square, antiderivative, N = KNOWN[name]
    off = sp.diff(antiderivative.subs(p, sp.sqrt(square)), q) - N / sp.sqrt(square)
    assert abs(sp.N(off.subs({E: 3, k: -2, L: sp.Rational(1, 3), U: 1, q: sp.Rational(7, 6)}), 30)) < 1e-25
    assert not_elementary(square, [sp.sympify(N)], q) is None


def test_a_proof_is_of_every_integral_and_of_what_is_not_rational() -> None:
    square = E - k * sp.log(q) - L**2 / q**2
    assert LinearBesideRational(q, square, (sp.S.One,)).holds()
    assert not LinearBesideRational(q, square, (sp.S.One, sp.diff(square, q))).holds()
    assert not LinearBesideRational(q, E - k / q, (sp.S.One,)).holds()  # (p²)′ is the derivative of 1/q
    assert not LinearBesideRational(q, E - q**2 + sp.cos(q), (sp.S.One,)).holds()
    assert not NoRationalSolution(q, E + U * sp.exp(-(q**2)), (sp.S.One, q)).holds()
    assert not NoRationalSolution(q, E + U * sp.exp(-q), (sp.S.One,)).holds()


@pytest.mark.parametrize(
    ("entry", "coordinate"),
    [("charge-in-radial-field", "r"), ("eccentric-disk", "theta"), ("perfect-oblate-spheroid", "w")],
)
def test_entries_say_why(entry: str, coordinate: str) -> None:
    motion = hjsolve.solve(entry).motion(**next(iter(hjsolve.catalog.describe(entry).motions.values())).arguments)
    form = own_form(motion)
    assert form is not None
    reason = form.why_not["time_law"]
    assert isinstance(reason, OfCoordinate)
    assert reason.coordinate == coordinate
    assert isinstance(reason.reason, LinearBesideRational)
    assert reason.holds()
