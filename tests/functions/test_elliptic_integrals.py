"""Elliptic integrals in Carlson's and Legendre's functions against Gauss' rule at 40 digits, over random integrands."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy as sp
from mpmath import MPContext, mp, mpf

from hjsolve.functions import CarlsonRC, CarlsonRF, modules
from hjsolve.functions.elliptic import (
    BranchPoints,
    NoForm,
    PartialFractions,
    complete,
    incomplete,
    inverse,
)
from hjsolve.functions.many_digits import legendre_e, legendre_pi
from hjsolve.functions.tables import own_modules
from hjsolve.precision import mp as precise
from tests.reference.legendre_forms import legendre_complete, legendre_incomplete
from tests.support.gauss import gauss

X, U = sp.symbols("x u", real=True)
FIRST = PartialFractions(((0, sp.S.One),))


def night_from(first, seeds):
    """Seeds, those from ``first`` on only at night."""
    return [pytest.param(seed, marks=pytest.mark.nightly) if seed >= first else seed for seed in seeds]


def number(rng, reach=9):
    return sp.Rational(rng.randint(-reach * 7, reach * 7), rng.choice([5, 7, 11]))


def random_integral(rng):
    """Degree 3 or 4, all roots real or one pair complex, any interval where P > 0, powers and poles of every order."""
    degree, paired = rng.choice([3, 4]), rng.choice([False, False, True])
    real: set[sp.Expr] = set()
    while len(real) < degree - 2 * paired:
        real.add(number(rng))
    roots = tuple(sorted(real))
    interval = rng.choice([(None, 0), *((i, i + 1) for i in range(len(roots) - 1)), (len(roots) - 1, None)])
    above = len(roots) - 1 - interval[0] if interval[0] is not None else len(roots)
    leading = sp.Rational(rng.randint(1, 30), 7) * (-1) ** above
    P = BranchPoints(leading, roots, ((number(rng), abs(number(rng)) + sp.Rational(1, 3)),) if paired else ())
    low, high = (None if k is None else roots[k] for k in interval)
    poles = []
    for _ in range(rng.choice([0, 1, 2])):
        place = rng.choice(roots) if rng.random() < 0.3 else number(rng, 15)
        if (low is not None and place < low) or (high is not None and place > high):
            poles.append((place, rng.choice([1, 1, 2, 3]), number(rng)))
    powers = tuple((k, number(rng)) for k in rng.sample(range(5), rng.choice([1, 2])))
    return P, interval, low, high, PartialFractions(powers, tuple(poles))


def with_double_root(rng):
    """The same with two real roots next to the interval in one place; then the integral is elementary."""
    while True:
        P, interval, low, high, R = random_integral(rng)
        beside = [k for k in range(len(P.real)) if k not in interval]
        if len(beside) > 1 and beside[1] == beside[0] + 1:
            roots = list(P.real)
            roots[beside[1]] = roots[beside[0]]
            moved = [(roots[beside[0]] if place == P.real[beside[1]] else place, m, c) for place, m, c in R.poles]
            return BranchPoints(P.leading, tuple(roots)), interval, low, high, PartialFractions(R.powers, tuple(moved))


def random_place(rng, low, high):
    if low is not None and high is not None:
        return low + (high - low) * sp.Rational(rng.randint(1, 99), 100)
    away = sp.Rational(rng.randint(1, 100), 9)
    return low + away if high is None else high - away


def exact(value):
    return mpf(value.p) / value.q


def rational(R, x):
    return sum(exact(c) * x**k for k, c in R.powers) + sum(exact(c) / (x - exact(r)) ** m for r, m, c in R.poles)


def by_quadrature(R, P, low, high, ends):
    """∫ R dx/√P; a root at an end is taken out of P exactly, by x = low + (high − low) sin²(t/2) or x = end ± (t/(1 − t))²."""

    def rest(x):
        factors = [x - exact(r) for k, r in enumerate(P.real) if k not in ends]
        factors += [(x - exact(α)) ** 2 + exact(β) ** 2 for α, β in P.pairs]
        return abs(mp.fprod([exact(P.leading), *factors]))

    def between(t):
        h, s, c = exact(high - low), mp.sin(t / 2), mp.cos(t / 2)
        x, weight = exact(low) + h * s * s, h * s * c
        weight /= (mp.sqrt(h) * s if ends[0] is not None else 1) * (mp.sqrt(h) * c if ends[1] is not None else 1)
        return rational(R, x) * weight / mp.sqrt(rest(x))

    def to_infinity(t):
        w = t / (1 - t)
        x = exact(low) + w * w if high is None else exact(high) - w * w
        return rational(R, x) * 2 / (1 - t) ** 2 / mp.sqrt(rest(x))

    if low is None or high is None:
        return mp.quad(to_infinity, mp.linspace(0, 1, 33), method=gauss, maxdegree=8)
    return mp.quad(between, mp.linspace(0, mp.pi, 17), method=gauss, maxdegree=8)


def agree(value, truth, digits=30):
    found = sp.N(value, 40)
    assert found.is_Float
    assert abs(mpf(str(found)) - truth) <= abs(truth) * mpf(10) ** -digits + mpf(10) ** -(digits + 6)


@pytest.mark.nightly_cases("0", "10", "11", "1", "3", "4", "5", "6", "7", "8", "9")
@pytest.mark.parametrize("seed", night_from(12, range(20)))
def test_ten_random_integrals_are_right_to_thirty_digits(seed):
    """Of 200, those over a whole infinite interval have an integrand that converges there."""
    rng = random.Random(seed)
    with mp.workdps(42):
        for _ in range(10):
            P, interval, low, high, R = random_integral(rng)
            if rng.random() < 0.5:
                if None in interval:
                    R = PartialFractions(((0, sp.Integer(2)),), tuple((place, 1, c) for place, _, c in R.poles))
                agree(complete(R, P, interval), by_quadrature(R, P, low, high, interval))
                continue
            x = random_place(rng, low, high)
            start = "lower" if interval[0] is not None and (interval[1] is None or rng.random() < 0.5) else "upper"
            form = incomplete(R, P, interval, X, start).xreplace({X: x})
            if start == "lower":
                agree(form, by_quadrature(R, P, low, x, (interval[0], None)))
            else:
                agree(form, by_quadrature(R, P, x, high, (None, interval[1])))


@pytest.mark.rotating(2)
@pytest.mark.parametrize("seed", range(300, 304))
def test_double_roots_give_elementary_integrals(seed):
    rng = random.Random(seed)
    with mp.workdps(42):
        for _ in range(8):
            P, interval, low, high, R = with_double_root(rng)
            x = random_place(rng, low, high)
            start = "lower" if interval[0] is not None else "upper"
            form = incomplete(R, P, interval, X, start)
            assert incomplete(FIRST, P, interval, X, start).has(CarlsonRC)
            assert not incomplete(FIRST, P, interval, X, start).has(CarlsonRF)
            if start == "lower":
                agree(form.xreplace({X: x}), by_quadrature(R, P, low, x, (interval[0], None)))
            else:
                agree(form.xreplace({X: x}), by_quadrature(R, P, x, high, (None, interval[1])))
            u = sp.N(incomplete(FIRST, P, interval, x, start), 45)
            assert abs(sp.N(inverse(P, interval, U, start).xreplace({U: u}), 40) - x) <= 1e-30 * (1 + abs(x))


@pytest.mark.nightly_cases("100", "101")
@pytest.mark.parametrize("seed", night_from(102, range(100, 104)))
def test_derivative_inverse_and_legendres_form(seed):
    rng = random.Random(seed)
    for _ in range(3):
        P, interval, low, high, R = random_integral(rng)
        x = random_place(rng, low, high)
        start = "lower" if interval[0] is not None and (interval[1] is None or rng.random() < 0.5) else "upper"
        form = incomplete(R, P, interval, X, start)
        sign = 1 if start == "lower" else -1
        integrand = sum(c * X**k for k, c in R.powers) + sum(c / (X - r) ** m for r, m, c in R.poles)
        slope = sp.N((sign * integrand / sp.sqrt(P.value(X))).xreplace({X: x}), 30)
        assert abs(sp.N(sp.diff(form, X).xreplace({X: x}), 30) - slope) <= 1e-20 * (1 + abs(slope))
        u = sp.N(incomplete(FIRST, P, interval, x, start), 45)
        assert abs(sp.N(inverse(P, interval, U, start).xreplace({U: u}), 40) - x) <= 1e-30 * (1 + abs(x))
        value, legendre = sp.N(form.xreplace({X: x}), 35), legendre_incomplete(R, P, interval, X, start)
        assert (legendre is None) == bool(P.pairs)
        if legendre is not None:
            assert abs(sp.N(legendre.xreplace({X: x}), 35) - value) <= 1e-25 * (1 + abs(value))
        if legendre is not None and None not in interval:
            whole = sp.N(complete(R, P, interval), 35)
            assert abs(sp.N(legendre_complete(R, P, interval), 35) - whole) <= 1e-25 * (1 + abs(whole))


@pytest.mark.nightly_cases("200", "201")
@pytest.mark.parametrize("seed", night_from(202, range(200, 204)))
def test_both_ends_of_the_interval_belong_to_it(seed):
    """Zero at the beginning, the complete integral at the other end, in many digits and in numpy's doubles."""
    rng, seen = random.Random(seed), 0
    while seen < 6:
        P, interval, low, high, R = random_integral(rng)
        if None in interval:
            continue
        seen += 1
        whole = sp.N(complete(R, P, interval), 30)
        for start, (begin, end) in (("lower", (low, high)), ("upper", (high, low))):
            form = incomplete(R, P, interval, X, start)
            assert form.xreplace({X: begin}) == 0 or abs(sp.N(form.xreplace({X: begin}), 20)) < 1e-20
            assert abs(sp.N(form.xreplace({X: end}), 30) - whole) <= 1e-25 * (1 + abs(whole))
            compiled = sp.lambdify(X, form, modules=modules("numpy"))
            inside = np.linspace(float(low), float(high), 7)[1:-1]
            exact_ones = [float(sp.N(form.xreplace({X: sp.Rational(float(v))}), 25)) for v in inside]
            assert compiled(inside) == pytest.approx(exact_ones, rel=1e-8, abs=1e-8 * max(map(abs, exact_ones)))


def test_the_pendulums_quarter_period():
    """∫₀¹ dx/√((1 − x²)(1 − m x²)) = K(m), between 0 as no root: the same from −1 to 1 is twice that."""
    m = sp.Rational(1, 3)
    roots = (-1 / sp.sqrt(m), -sp.S.One, sp.S.One, 1 / sp.sqrt(m))
    found = complete(FIRST, BranchPoints(m, roots), (1, 2))
    assert abs(sp.N(found - 2 * sp.elliptic_k(m), 40)) < 1e-38


def test_symbolic_roots_stay_symbols():
    x1, x2, x3 = sp.symbols("x_1 x_2 x_3", real=True)
    P = BranchPoints(sp.S.One, (x1, x2, x3))
    found = complete(FIRST, P, (0, 1))
    assert found.free_symbols == {x1, x2, x3}
    assert sp.N(found.xreplace({x1: 0, x2: 1, x3: 3}), 30) == sp.N(
        complete(FIRST, BranchPoints(sp.S.One, (0, 1, 3)), (0, 1)), 30
    )


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (
            lambda: complete(PartialFractions(((1, sp.S.One),)), BranchPoints(sp.S.One, (0, 1, 2)), (2, None)),
            "diverges",
        ),
        (lambda: complete(FIRST, BranchPoints(sp.S.One, (0, 1)), (1, None)), "degree 2"),
        (
            lambda: incomplete(FIRST, BranchPoints(sp.S.One, (), ((0, 1), (2, 1))), (None, None), X, "lower"),
            "no real root",
        ),
        (lambda: incomplete(FIRST, BranchPoints(sp.S.One, (0, 1, 2)), (2, None), X, "upper"), "begin at a root"),
        (
            lambda: complete(
                PartialFractions((), ((sp.S.Zero, 1, sp.S.One),)), BranchPoints(sp.S.One, (0, 1, 2)), (0, 1)
            ),
            "pole",
        ),
        (
            lambda: complete(
                PartialFractions((), ((sp.S.One, 1, sp.S.One),)), BranchPoints(sp.S.One, (0, 1, 2)), (0, 1)
            ),
            "pole",
        ),
        (
            lambda: legendre_complete(
                PartialFractions((), (), ((0, 1, 0, 1),)), BranchPoints(sp.S.One, (0, 1, 2)), (0, 1)
            ),
            "complex poles",
        ),
    ],
)
def test_what_is_refused_says_why(call, says):
    with pytest.raises(NoForm, match=says):
        call()


@pytest.mark.parametrize("zeros", [3, 12, 26, 40])
def test_e_keeps_its_digits_next_to_the_separatrix(zeros):
    """mpmath's own was wrong by 1e-44 at 60 digits where 1 - m was 1e-26."""
    (own, _) = modules("mpmath")
    exact = MPContext()
    exact.dps = 120
    with mp.workdps(60):
        m = 1 - mpf(10) ** -zeros
        found, turned = own["elliptic_e"](m), own["elliptic_e"](mpf(-5), m)
    assert abs(exact.mpf(found) - exact.ellipe(exact.mpf(m))) < 1e-59
    assert abs(exact.mpf(turned) - exact.ellipe(exact.mpf(-5), exact.mpf(m))) < 1e-58


@pytest.mark.parametrize("away", ["1/3", "1/1000000000000"])
@pytest.mark.parametrize("side", [-1, 1])
def test_doubles_keep_a_whole_integral_where_a_pole_is_beside_a_root(away, side):
    """Next to a complex pair: all that grows is the half turn π/√(−P(ρ)), apart from the rest."""
    rng, away = random.Random(5), sp.Rational(away)
    for _ in range(6):
        low, high = sorted((number(rng), number(rng) + sp.Rational(1, 13)))
        P = BranchPoints(-1, (low, high), ((number(rng), abs(number(rng)) + sp.Rational(1, 3)),))
        pole = high + away if side > 0 else low - away
        at = dict(zip(sp.symbols("a:d"), (low, high, *P.pairs[0]), strict=True))
        x = sp.Symbol("x")
        named = BranchPoints(-1, tuple(at)[:2], (tuple(at)[2:],), sp.Poly(P.value(x), x))
        R = PartialFractions((), ((pole, 1, sp.S.One),))
        form = complete(R, named, (0, 1), lambda _: -side)
        got = sp.lambdify(list(at), sp.N(form, 17), modules=modules("numpy"))(*map(float, at.values()))
        exact = sp.N(complete(R, P, (0, 1)), 30)
        assert abs(got - exact) <= 64 * np.spacing(abs(float(exact)))


@pytest.mark.parametrize("angle", [(), ("0.4",), ("7.1",)])
def test_e_of_real_numbers_that_are_written_as_complex_ones(angle):
    # it raised a TypeError: a complex number has no order, though its imaginary part is 0
    with mp.workdps(30):
        φ, m = [mp.mpf(a) for a in angle], mp.mpf("0.3")
        real = legendre_e(*φ, m)
        assert legendre_e(*(mp.mpc(a, 0) for a in φ), mp.mpc(m, 0)) == real
        assert abs(real - mp.ellipe(*φ, m)) < mp.mpf(10) ** -28


def test_pi_of_a_case_that_is_not_taken_is_not_integrated(monkeypatch):
    """Beyond the pole mpmath integrates numerically: minutes at 480 digits, for a motion about two centres."""
    monkeypatch.setattr(type(precise), "quadsubdiv", lambda *_: pytest.fail("mpmath integrates"))
    n, m = sp.symbols("n m")
    pi = sp.elliptic_pi(n, sp.Rational(-6, 5), m)
    taken = sp.Piecewise((pi, n < 1), (m, True)) + sp.Piecewise((pi**2, n < 1), (0, True))
    compiled = sp.lambdify((n, m), taken, modules=own_modules(), cse=True)
    with precise.workdps(480):
        assert compiled(precise.mpf(3), precise.mpf(2) / 7) == precise.mpf(2) / 7
    with precise.workdps(40):
        given = [precise.mpf(1) / 4, precise.mpf(-0.7), precise.mpf(2) / 7]
        assert legendre_pi(*map(precise.mpc, given)) == legendre_pi(*given) == precise.ellippi(*given)
        assert precise.isnan(legendre_pi(precise.mpf(2), precise.mpf(2) / 7))
        assert precise.isnan(legendre_pi(precise.mpf(2), precise.nan))
