"""Exponentials of one variable with many exponents: numbers of several digits decide as short ones do."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.algebra import poly
from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.reader import Reader
from tests.support.random_separable import staeckel

DECIMALS = [("1.7", "0.31", "2.29"), ("1.2345", "0.6789", "0.31"), ("0.123", "0.457", "1.011")]


def _system(a, b, c, potential):
    """T of Liouville form in which sympy joins exp(-a x²) exp(-b x²) to one exponential."""
    f = f"(2 + exp(-{a}*x**2))*(3 + exp(-{b}*x**2)) + (1 + exp(-{c}*y**2))*(2 + exp(-{b}*y**2))"
    return hjsolve.System(
        {"x": "line", "y": "line"}, f"({f})*(dot(x)**2 + dot(y)**2)/2", f"({potential} + exp(-{c}*x**2) + y**4)/({f})"
    )


@pytest.mark.nightly_cases("decimals1")
@pytest.mark.parametrize("decimals", DECIMALS)
def test_decimals_of_several_digits_in_exponents_are_decided(decimals):
    assert isinstance(hjsolve.separate(_system(*decimals, "x**2")), hjsolve.Separation)
    assert isinstance(hjsolve.separate(_system(*decimals, "x**2*y")), hjsolve.Obstruction)


@pytest.mark.parametrize(("n", "seed"), [(2, 137), pytest.param(3, 101, marks=pytest.mark.nightly)])
def test_random_staeckel_systems_that_were_left_undecided_are_found_to_separate(n, seed):
    given = staeckel(seed, n)
    kinetic = " + ".join(f"dot({q})**2/(2*({g}))" for q, g in zip(given.names, given.inverse_metric, strict=True))
    system = hjsolve.System(dict.fromkeys(given.names, "line"), kinetic, str(given.potential))
    assert isinstance(hjsolve.separate(system), hjsolve.Separation)


def test_an_exponent_too_large_for_packed_monomials_ends_the_work_and_never_runs_into_the_next_generator():
    reader = Reader()
    x, y = (reader.element(s) for s in sp.symbols("x y", real=True))
    highest = (x * y) ** poly.MAX_DEGREE + 1
    assert max(e for m in highest.numerator for _, e in poly.exponents(m)) == poly.MAX_DEGREE
    with pytest.raises(WorkLimitError, match="exponents"):
        (x * y) ** (poly.MAX_DEGREE + 1) + 1
