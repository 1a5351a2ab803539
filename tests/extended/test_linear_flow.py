"""The flow of ż = A z + b: against exponentials of matrices in twice the digits, Jordan blocks and all; true errors."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve.extended.linear_flow import _prepared, affine, flow_of, path_of

OSCILLATOR = sp.Matrix([[0, 1], [-1, 0]])
CASES = {
    "oscillator": (OSCILLATOR, [0, 0], [1, 1]),
    "oscillator with a force": (OSCILLATOR, [0, 3], [1, 1]),
    "free fall": (sp.Matrix([[0, 1], [0, 0]]), [0, -1], [3]),
    "two alike": (sp.Matrix(sp.BlockDiagMatrix(OSCILLATOR, OSCILLATOR).as_explicit()), [0] * 4, [1, 1]),
    "a block of two": (sp.Matrix([[0, 1, 1, 0], [-1, 0, 0, 1], [0, 0, 0, 1], [0, 0, -1, 0]]), [0] * 4, [1, 2]),
    "growth and spirals": (sp.Matrix([[1, 2, 0], [-2, 1, 1], [0, 1, -3]]), [1, 0, 2], [1, 1]),
    "roots of 2": (sp.Matrix([[0, sp.sqrt(2)], [-1, sp.sqrt(2) / 4]]), [0, sp.sqrt(2)], [1, 1]),
    "nearly alike": (sp.Matrix([[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [0, 0, -1 - sp.Rational(1, 10**12), 0]]),
                     [0] * 4, [1, 1]),
}  # fmt: skip


@pytest.mark.parametrize("digits", [15, 40])
@pytest.mark.parametrize("name", CASES)
def test_the_flow_is_the_exponential_within_its_bound(name: str, digits: int) -> None:
    A, b, blocks = CASES[name]
    Â = affine(A, sp.Matrix(b))
    flow = flow_of(Â)
    assert sorted(f.block for f in flow.factors) == sorted(blocks)
    assert sum(f.multiplicity * f.polynomial.degree() for f in flow.factors) == Â.rows
    start = [sp.Rational(k + 2, 7) for k in range(A.rows)] + [sp.S.One]
    path = path_of(flow, start, sp.Integer(9), digits)
    with mp.workdps(2 * digits + 40):
        matrix = mp.matrix([[mpf(sp.N(x, 2 * digits + 40)) for x in Â.row(i)] for i in range(Â.rows)])
        for t in ("-2.5", "0", "0.125", "9"):
            expected = mp.expm(matrix * mpf(t)) * mp.matrix([mpf(x.p) / x.q for x in start])
            z, bound = path.at(path.context.mpf(t)), mpf(path.bound(path.context.mpf(t)))
            largest = max(abs(x) for x in expected)
            assert all(abs(mpf(a) - e) <= bound for a, e in zip(z, expected, strict=True))
            assert bound <= largest * mpf(10) ** -(digits + 2) if t == "9" else bound < mpf(10) ** -digits


def test_multiplicities_are_exact_where_roots_differ_by_a_trillionth() -> None:
    A, b, _ = CASES["nearly alike"]
    assert sorted(f.multiplicity for f in flow_of(A).factors) == [1]
    assert sorted(f.multiplicity for f in flow_of(A.subs(sp.Rational(-1, 10**12) - 1, -1)).factors) == [2]
    assert len(b) == 4


@pytest.mark.parametrize(
    ("name", "wider"),
    [("two alike", 1e4), ("a block of two", 1e5), ("growth and spirals", 1e6), ("nearly alike", 1e16)],
)
def test_the_bound_holds_where_only_few_bits_are_carried(name: str, wider: float) -> None:
    """With 70 bits the rounding is large enough to be seen: the bound is above it, by so much at most.

    Roots that differ by a trillionth are told apart with 40 bits of the 70, and the bound grows with their nearness.
    """
    A, b, _ = CASES[name]
    Â = affine(A, sp.Matrix(b))
    start = [sp.Rational(k + 2, 7) for k in range(A.rows)] + [sp.S.One]
    flow = flow_of(Â)
    approximate, exact = _prepared(flow, start, 70), path_of(flow, start, sp.Integer(9), 60)
    for t in ("-2.5", "4", "9"):
        pairs = zip(approximate.at(approximate.context.mpf(t)), exact.at(exact.context.mpf(t)), strict=True)
        with mp.workdps(60):
            error = max(abs(mpf(a) - mpf(e)) for a, e in pairs)
            assert error <= mpf(approximate.bound(approximate.context.mpf(t))) <= max(error, mpf(2) ** -70) * mpf(wider)
            assert error > 0


@pytest.mark.parametrize(("what", "exponent"), [("start", 2), ("exponent", 0)])
def test_the_bound_is_twice_the_error_where_both_are_known_exactly(what: str, exponent: int) -> None:
    """ż = λz with a wrong start, δ e^{λt} off, or ż = 0 with a wrong exponent, e^{δt} − 1 off."""
    path = _prepared(flow_of(sp.Matrix([[exponent]])), [sp.S.One], 200)
    (((λ, (v,)),), ((V, _),)), δ = (path.terms, path.sizes), path.context.ldexp(1, -60)
    if what == "start":
        wrong = replace(path, terms=[(λ, [v * (path.context.mpf(1) + δ)])], start=δ)
    else:
        wrong = replace(path, terms=[(λ + δ, [v])], sizes=[(V, [δ])])
    for t in ("0.5", "3", "20"):
        at = path.context.mpf(t)
        error = path.context.mpf(abs(wrong.at(at)[0] - path.at(at)[0]))
        assert error <= wrong.bound(at) <= error * path.context.mpf("2.01")
