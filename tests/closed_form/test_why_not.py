"""Reasons are data: a true proof holds, a falsified one does not, and nothing with a form has a reason."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.why_not import (
    Contains,
    HighGenus,
    IndependentIntegrals,
    NotFound,
    NotOfTheFirstKind,
    OfCoordinate,
    TranscendentalEquation,
    WhyNot,
)
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(4)


def test_keplers_equation_is_refuted_where_its_root_term_is_taken_away() -> None:
    proof = forms("kepler-planar")[0].why_not["inverse.r"]
    assert isinstance(proof, TranscendentalEquation)
    assert proof.holds()
    assert str(proof) == "t(r) is Kepler's equation: r(t) has no closed form"
    circular = replace(proof, law=replace(proof.law, algebraic=sp.S.Zero))
    assert not circular.holds()  # e = 0: t is an arc function alone
    assert not replace(proof, law=replace(proof.law, terms=())).holds()  # √P alone: a square root


def test_two_logarithms_are_independent_where_their_factors_have_no_rational_ratio() -> None:
    law = forms("kepler-planar")[0].why_not["inverse.r"].law  # type: ignore[union-attr]
    ((weight, term),) = law.terms
    two = replace(law, algebraic=sp.S.Zero, terms=((weight, term), (sp.sqrt(2) * weight, term)))
    assert TranscendentalEquation("r", two).holds()
    three = replace(two, terms=((weight, term), (3 * weight, term)))  # log x + 3 log y = log x y³
    assert not TranscendentalEquation("r", three).holds()


def test_the_logarithms_of_two_complex_poles_are_independent_where_their_factors_are() -> None:
    """Of the trigonometric Rosen–Morse well; without the cotangent both factors are the same."""
    potential, parameters = "A/sin(x)**2 + 2*B*cot(x)", {"m": 1, "A": 1, "B": "1/3"}
    system = hjsolve.System({"x": "0 < x < pi"}, "m*dot(x)**2/2", potential, parameters)
    form = own_form(hjsolve.solve(system).motion(q={"x": 1}, velocity={"x": "1/5"}))
    assert form is not None
    proof = form.why_not["inverse.x"]
    assert isinstance(proof, TranscendentalEquation)
    assert proof.holds()
    ((weight, term),) = proof.law.terms
    same = replace(term, root=(sp.S.One, sp.S.Zero))  # type: ignore[type-var]
    assert not replace(proof, law=replace(proof.law, terms=((weight, same),))).holds()  # type: ignore[type-var]


def test_the_time_of_a_bead_on_a_cone_is_no_integral_of_the_first_kind() -> None:
    form = next(f for f in forms("cone") if f.regime.kinds["r"] == "libration")
    proof = form.why_not["inverse.r"]
    assert isinstance(proof, NotOfTheFirstKind)
    assert proof.holds()
    assert not replace(proof, rational=sp.Integer(3)).holds()
    assert {"r", "t", "phi"} <= set(form.anomaly)  # as functions of the argument of sn
    reason = form.why_not["inverse.phi"]
    assert isinstance(reason, Contains)
    assert reason.holds()


def test_nor_is_one_that_is_elliptic_in_the_square_of_the_place() -> None:
    """Of m(1 + b q²)q̇²/2, V = k q²/2 + c q⁴/4: dt = (1 + b X) dX/√(X P(X)) in X = q²."""
    proof = forms("one-degree-of-freedom")[0].why_not["inverse.q"]
    assert isinstance(proof, NotOfTheFirstKind)
    assert proof.holds()
    (b,) = (s for s in proof.rational.free_symbols if s.name == "b")
    assert not replace(proof, rational=proof.rational.xreplace({b: 0})).holds()  # of constant mass


@pytest.mark.nightly
def test_integrals_that_are_multiples_are_not_independent() -> None:
    proof = forms("kepler-prolate")[0].why_not["inverse.xi"]
    assert isinstance(proof, IndependentIntegrals)
    assert proof.holds()
    assert not replace(proof, ratio=sp.Integer(2)).holds()


def test_a_curve_with_a_double_root_or_of_low_degree_is_no_proof() -> None:
    reason = forms("flywheel-with-slider")[0].why_not["time_law"]
    assert isinstance(reason, OfCoordinate)
    proof = reason.reason
    assert isinstance(proof, HighGenus)
    assert reason.holds()
    x = proof.reduced.gen
    assert not replace(proof, reduced=sp.Poly((x - 1) ** 2 * (x**3 + 2), x)).holds()
    assert not replace(proof, reduced=sp.Poly(x**4 + 2, x)).holds()
    for broken in (replace(proof, involution=True), replace(proof, reduced=sp.Poly(x**4 + 2, x))):
        assert not broken.holds()
        assert not broken.proved
        assert "no closed form" not in str(broken)


@pytest.mark.nightly_cases("kerr", "two-centres-plane", "kepler-prolate", "garnier", "neumann")
@pytest.mark.parametrize(
    "name", ["pendulum", "kepler-planar", "cone", "spherical-pendulum", "isochrone", "kerr", "two-centres-plane",
             "kepler-prolate", "garnier", "neumann"],
)  # fmt: skip
def test_no_quantity_has_both_a_form_and_a_reason_and_every_proof_holds(name: str) -> None:
    for form in forms(name):
        assert not set(form.named()) & set(form.why_not)
        for reason in form.why_not.values():
            assert isinstance(reason, WhyNot)
            assert reason.holds() is reason.proved, reason
            assert reason.proved or "has no closed form" not in str(reason)


def test_what_was_not_found_claims_no_proof() -> None:
    assert not NotFound("nothing").proved
    assert not NotFound("nothing").holds()
