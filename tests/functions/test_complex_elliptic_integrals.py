"""Elliptic integrals with complex poles, and on curves with two complex pairs, against Gauss' rule at 40 digits."""

from __future__ import annotations

import random
import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve.functions import CarlsonRCIm, CarlsonRCRe, CarlsonRJIm, CarlsonRJRe, c_source, modules
from hjsolve.functions.elliptic import (
    BranchPoints,
    NoForm,
    PartialFractions,
    around,
    between,
    complete,
    incomplete,
    inverse_between,
)
from hjsolve.functions.tables import own_modules
from tests.functions.test_elliptic_integrals import exact, number, random_integral, random_place
from tests.support.gauss import gauss

X = sp.Symbol("x", real=True)
FIRST = PartialFractions(((0, sp.S.One),))
A, B, V1, V2, V3 = sp.symbols("a b v1 v2 v3", real=True)
PARTS = (CarlsonRJRe(V1, V2, V3, A, B), CarlsonRJIm(V1, V2, V3, A, B), CarlsonRCRe(V1, A, B), CarlsonRCIm(V1, A, B))


def rational(R, x):
    value = sum(exact(c) * x**k for k, c in R.powers) + sum(exact(c) / (x - exact(r)) ** m for r, m, c in R.poles)
    squares = [((x - exact(re)) ** 2 + exact(im) ** 2, exact(a) * x + exact(b)) for re, im, a, b in R.complex_poles]
    return value + sum(top / bottom for bottom, top in squares)


def by_quadrature(R, P, low, high, ends):
    """∫ R dx/√P and ∫ |R| dx/√P, a root at an end taken out of P exactly; an end None is infinite."""

    def rest(x):
        factors = [x - exact(r) for k, r in enumerate(P.real) if k not in ends]
        factors += [(x - exact(α)) ** 2 + exact(β) ** 2 for α, β in P.pairs]
        return mp.sqrt(abs(mp.fprod([exact(P.leading), *factors])))

    def finite(t):
        h, s, c = exact(high - low), mp.sin(t / 2), mp.cos(t / 2)
        weight = (
            h
            * s
            * c
            / ((mp.sqrt(h) * s if ends[0] is not None else 1) * (mp.sqrt(h) * c if ends[1] is not None else 1))
        )
        x = exact(low) + h * s * s
        return rational(R, x) * weight / rest(x)

    def infinite(t):
        w = t / (1 - t)
        x = exact(low) + w * w if high is None else exact(high) - w * w
        return rational(R, x) * 2 / (1 - t) ** 2 / rest(x)

    f, to = (infinite, 1) if low is None or high is None else (finite, mp.pi)
    pieces = mp.linspace(0, to, 25)
    total = mp.quad(f, pieces, method=gauss, maxdegree=8)
    return total, mp.quad(lambda t: abs(f(t)), pieces, method=gauss, maxdegree=3)


def complex_poles(rng):
    return tuple(
        (number(rng, 12), abs(number(rng, 5)) + sp.Rational(1, 3), number(rng), number(rng))
        for _ in range(rng.choice((1, 1, 2)))
    )


def with_complex_poles(rng):
    """The integral by its form, by quadrature, and the size of the integrand."""
    P, interval, low, high, R = random_integral(rng)
    if None in interval:
        R = PartialFractions(((0, sp.Integer(2)),), (), complex_poles(rng))
    else:
        R = PartialFractions(R.powers[:1], R.poles[:1], complex_poles(rng))
    if rng.random() < 0.4:
        return complete(R, P, interval), *by_quadrature(R, P, low, high, interval)
    x = random_place(rng, low, high)
    lower = interval[0] is not None and (interval[1] is None or rng.random() < 0.5)
    form = incomplete(R, P, interval, X, "lower" if lower else "upper").xreplace({X: x})
    known = (
        by_quadrature(R, P, low, x, (interval[0], None)) if lower else by_quadrature(R, P, x, high, (None, interval[1]))
    )
    return form, *known


def two_pairs(rng):
    """A quartic without real roots, two places, and a rational function without a pole between them."""
    α = [number(rng), number(rng)]
    if rng.random() < 0.25:
        α[1] = α[0]
    P = BranchPoints(
        sp.Rational(rng.randint(1, 30), 7), (), tuple((a, abs(number(rng)) + sp.Rational(1, 3)) for a in α)
    )
    y, x = sorted((number(rng), number(rng) + sp.Rational(1, 13)))
    away = abs(number(rng, 5)) + sp.Rational(1, 9)
    poles = [(x + away if rng.random() < 0.5 else y - away, rng.choice([1, 1, 2, 3]), number(rng))] * rng.choice(
        (0, 1, 1)
    )
    return P, y, x, PartialFractions(tuple((k, number(rng)) for k in rng.sample(range(5), 2)), tuple(poles))


def without_real_roots(rng):
    """As ``with_complex_poles``; from the upper place to the lower one now and then."""
    P, y, x, R = two_pairs(rng)
    total, size = by_quadrature(R, P, y, x, (None, None))
    if rng.random() < 0.5:
        return between(R, P, y, X).xreplace({X: x}), total, size
    return between(R, P, x, X).xreplace({X: y}), -total, size


@pytest.mark.nightly_cases(
    "with_complex_poles-9000", "with_complex_poles-9001", "without_real_roots-9000", "without_real_roots-9001",
)  # fmt: skip
@pytest.mark.parametrize(
    "seed", [*range(9000, 9002), *(pytest.param(s, marks=pytest.mark.nightly) for s in range(9002, 9020))]
)
@pytest.mark.parametrize("made", [with_complex_poles, without_real_roots])
def test_five_random_integrals_are_right_to_thirty_digits(seed, made):
    rng = random.Random(seed)
    with mp.workdps(42):
        for _ in range(5):
            form, truth, size = made(rng)
            found = sp.N(form, 40)
            assert found.is_Float
            assert abs(mpf(str(found)) - truth) <= size * mpf(10) ** -30


@pytest.mark.nightly_cases("400")
@pytest.mark.parametrize("seed", [400, *(pytest.param(s, marks=pytest.mark.nightly) for s in range(401, 403))])
def test_without_real_roots_derivative_inverse_and_the_whole_line(seed):
    rng = random.Random(seed)
    for _ in range(3):
        P, y, x, R = two_pairs(rng)
        form = between(R, P, y, X)
        integrand = sum(c * X**k for k, c in R.powers) + sum(c / (X - r) ** m for r, m, c in R.poles)
        slope = sp.N((integrand / sp.sqrt(P.value(X))).xreplace({X: x}), 30)
        with mp.workdps(40):
            h = sp.Rational(1, 10**12)
            ends = [sp.N(form.xreplace({X: x + s * h}), 40) for s in (1, -1)]
            assert abs((ends[0] - ends[1]) / (2 * h) - slope) <= 1e-15 * (1 + abs(slope))
        assert abs(sp.N(form.xreplace({X: y}), 20, chop=True)) < 1e-15
        u = sp.N(between(FIRST, P, y, x), 45)
        for farther in (0, 1):
            assert abs(sp.N(inverse_between(P, y, u, farther=farther), 35) - x) <= 1e-25 * (1 + abs(x))
        far = sp.N(between(FIRST, P, -(10**12), 10**12), 30)
        assert abs(sp.N(around(FIRST, P), 30) - far) <= 1e-10 * far


@pytest.mark.parametrize("tables", [modules("mpmath"), own_modules(), "mpmath"])
def test_the_parts_as_code_of_mpmath(tables):
    """Code names each function in a module that has it; vinti's forms in many digits ended in an ImportError."""
    at = [sp.Rational(7, 5), sp.Rational(1, 3), sp.Rational(9, 4), sp.Rational(-5, 3), sp.Rational(2, 7)]
    compiled = sp.lambdify((V1, V2, V3, A, B), PARTS, modules=tables)
    with mp.workdps(30):
        known = [sp.N(part.xreplace(dict(zip((V1, V2, V3, A, B), at, strict=True))), 30) for part in PARTS]
        for got, value in zip(compiled(*(mpf(x.p) / x.q for x in at)), known, strict=True):
            assert abs(got - mpf(str(value))) <= 1e-27 * abs(got)


def test_numpy_and_derivatives_of_the_parts():
    rng = random.Random(8)
    compiled = sp.lambdify((V1, V2, V3, A, B), PARTS, modules=modules("numpy"))
    for _ in range(40):
        values = [10 ** rng.uniform(-3, 3) for _ in range(3)]
        values += [rng.choice((-1, 1)) * 10 ** rng.uniform(-3, 3) for _ in range(2)]
        at = dict(zip((V1, V2, V3, A, B), map(sp.Rational, values), strict=True))
        known = [float(sp.N(part.xreplace(at), 20)) for part in PARTS]
        sizes = [abs(complex(*known[:2]))] * 2 + [abs(complex(*known[2:]))] * 2
        for got, value, size in zip(compiled(*values), known, sizes, strict=True):
            assert abs(got - value) <= 2e-12 * size
    at = {
        V1: sp.Rational(7, 5),
        V2: sp.Rational(1, 3),
        V3: sp.Rational(9, 4),
        A: sp.Rational(-5, 3),
        B: sp.Rational(2, 7),
    }
    h = sp.Rational(1, 10**9)
    for part in PARTS:
        for symbol in part.free_symbols:
            ends = [sp.N(part.xreplace({**at, symbol: at[symbol] + s * h}), 40) for s in (1, -1)]
            assert abs(sp.N(sp.diff(part, symbol).xreplace(at), 20) - (ends[0] - ends[1]) / (2 * h)) < 1e-15
    assert np.isnan(compiled(-1.0, 1.0, 1.0, 1.0, 1.0)[0])


def test_the_parts_are_those_of_the_definition():
    """R_J = (3/2) ∫ dt/(√((t + x)(t + y)(t + z)) (t + p)), t = u²; a negative real part of p too."""
    with mp.workdps(30):
        x, y, z = mpf(2), mpf(0), mpf(3)
        for p in (mp.mpc(-1, "0.5"), mp.mpc(2, -3)):
            known = 3 * mp.quad(
                lambda u, p=p: u / (mp.sqrt((u * u + x) * (u * u + y) * (u * u + z)) * (u * u + p)),
                [0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3, 10, 100, mp.inf],
            )
            found = [
                sp.N(f(2, 0, 3, sp.Rational(str(p.real)), sp.Rational(str(p.imag))), 25)
                for f in (CarlsonRJRe, CarlsonRJIm)
            ]
            assert abs(mp.mpc(*(mpf(str(v)) for v in found)) - known) < mpf(10) ** -18


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_compiled_parts(tmp_path):
    places = [(0.25, 2.0, 3.0, -4.0, 0.5), (0.75, 0.0, 40.0, 0.5, -3.0)]
    text = "#include <math.h>\n#include <stdio.h>\n" + c_source(sp.Tuple(*PARTS))
    text += "static void at(double v1, double v2, double v3, double a, double b) {\n"
    text += "".join(f'    printf("%.17g\\n", {sp.ccode(part)});\n' for part in PARTS) + "}\n"
    text += "int main(void) {\n" + "".join(f"    at{place};\n" for place in places) + "    return 0;\n}\n"
    (tmp_path / "program.c").write_text(text)
    command = ["cc", "-std=c99", "-Wall", "-Werror", "-o", tmp_path / "program", tmp_path / "program.c", "-lm"]
    subprocess.run(command, check=True, timeout=100)
    found = subprocess.run(
        [tmp_path / "program"], check=True, capture_output=True, text=True, timeout=20
    ).stdout.split()
    compiled = sp.lambdify((V1, V2, V3, A, B), PARTS, modules=modules("numpy"))
    known = [float(value) for place in places for value in compiled(*place)]
    assert [float(value) for value in found] == pytest.approx(known, rel=1e-12)


def test_what_is_refused_says_why():
    P = BranchPoints(sp.S.One, (), ((0, 1), (2, 1)))
    with pytest.raises(NoForm, match="complex poles"):
        between(PartialFractions((), (), ((0, 1, 0, 1),)), P, sp.S.Zero, X)
    with pytest.raises(NoForm, match="first kind only"):
        around(PartialFractions(((1, sp.S.One),)), P)
