"""Carlson's integrals against their defining integrals, their derivatives against differences, at many digits and as code."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mp

from hjsolve.functions import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ

x, y, z, p = sp.symbols("x y z p", positive=True)
HALF, THREE_HALVES = sp.Rational(1, 2), sp.Rational(3, 2)


def integral(weight, powers):
    """weight ∫₀^∞ Π (t + aᵢ)^−nᵢ dt (DLMF 19.16.1–19.16.6) with t = s²/(1 − s)², smooth at both ends."""

    def integrand(s):
        t = (s / (1 - s)) ** 2
        value = 2 * s / (1 - s) ** 3
        for a, n in powers:
            value *= (t + a) ** (-n)
        return value

    return weight * mp.quad(integrand, [0, mp.mpf(1) / 4, mp.mpf(1) / 2, mp.mpf(3) / 4, 1])


DEFINED = {
    CarlsonRF: lambda a: integral(mp.mpf(1) / 2, [(v, mp.mpf(1) / 2) for v in a]),
    CarlsonRC: lambda a: integral(mp.mpf(1) / 2, [(a[0], mp.mpf(1) / 2), (a[1], 1)]),
    CarlsonRD: lambda a: integral(mp.mpf(3) / 2, [(a[0], mp.mpf(1) / 2), (a[1], mp.mpf(1) / 2), (a[2], mp.mpf(3) / 2)]),
    CarlsonRJ: lambda a: integral(
        mp.mpf(3) / 2, [(a[0], mp.mpf(1) / 2), (a[1], mp.mpf(1) / 2), (a[2], mp.mpf(1) / 2), (a[3], 1)]
    ),
}
APART = [("1/3", "2", "5/2", "7/5"), ("4", "1/10", "3", "1/7"), ("1", "2", "3", "30")]
PLACES = [*APART, ("3", "3", "2", "3"), ("2", "3", "3", "2")]


def close(one, other, digits):
    with mp.workdps(digits + 10):
        return abs(mp.mpf(str(one)) - other) <= abs(other) * mp.mpf(10) ** -digits


@pytest.mark.parametrize("function", DEFINED)
@pytest.mark.parametrize("place", PLACES)
def test_fifty_digits_are_those_of_the_defining_integral(function, place):
    numbers = [sp.Rational(a) for a in place][: 2 if function is CarlsonRC else 4 if function is CarlsonRJ else 3]
    with mp.workdps(60):
        defined = DEFINED[function]([mp.mpf(a.p) / a.q for a in numbers])
        assert close(sp.N(function(*numbers), 52), defined, 50)


@pytest.mark.parametrize("function", [CarlsonRF, CarlsonRC, CarlsonRD, CarlsonRJ])
@pytest.mark.parametrize("place", APART)
def test_derivatives_by_every_argument_are_the_limits_of_differences(function, place):
    count = 2 if function is CarlsonRC else 4 if function is CarlsonRJ else 3
    arguments, numbers = (x, y, z, p)[:count], [sp.Rational(a) for a in place][:count]
    for i, argument in enumerate(arguments):
        slope = function(*arguments).diff(argument).subs(dict(zip(arguments, numbers)))
        with mp.workdps(50):
            values = [mp.mpf(a.p) / a.q for a in numbers]
            raw = getattr(mp, f"ellip{function.letter.replace('_', '').lower()}")

            def along(v, i=i, raw=raw, values=values):
                return raw(*values[:i], v, *values[i + 1 :])

            limit = mp.diff(along, values[i])
            assert close(sp.N(slope, 40), limit, 20)


@pytest.mark.parametrize(
    ("expression", "form"),
    [
        (CarlsonRD(x, y, x), lambda a, b: mp.elliprd(a, b, a)),
        (CarlsonRD(y, x, x), lambda a, b: mp.elliprd(b, a, a)),
        (CarlsonRJ(x, x, y, x), lambda a, b: mp.elliprj(a, a, b, a)),
        (CarlsonRJ(x, x, y, 3 * x), lambda a, b: mp.elliprj(a, a, b, 3 * a)),
        (CarlsonRF(x, y, y), lambda a, b: mp.elliprf(a, b, b)),
        (CarlsonRF(x, 2 * x, y**2), lambda a, b: mp.elliprf(a, 2 * a, b * b)),
    ],
)
def test_derivatives_where_arguments_coincide_or_depend_on_each_other(expression, form):
    place = {x: sp.Rational(3, 7), y: sp.Rational(5, 2)}
    with mp.workdps(50):
        a, b = mp.mpf(3) / 7, mp.mpf(5) / 2
        assert close(sp.N(expression.diff(x).subs(place), 40), mp.diff(lambda v: form(v, b), a), 20)
        assert close(sp.N(expression.diff(y).subs(place), 40), mp.diff(lambda v: form(a, v), b), 20)


def test_symmetric_arguments_have_one_order():
    assert CarlsonRF(z, x, y) == CarlsonRF(x, y, z)
    assert CarlsonRD(y, x, z) == CarlsonRD(x, y, z) != CarlsonRD(x, z, y)
    assert CarlsonRJ(z, x, y, p) == CarlsonRJ(y, x, z, p) != CarlsonRJ(p, x, y, z)


def test_exact_values():
    assert CarlsonRF(x, x, x) == 1 / sp.sqrt(x)
    assert CarlsonRF(0, y, y) == sp.pi / (2 * sp.sqrt(y))
    assert CarlsonRF(y, x, y) == CarlsonRC(x, y)
    assert CarlsonRC(0, 4) == sp.pi / 4
    assert CarlsonRC(0, -4) == 0
    assert CarlsonRD(x, x, x) == x ** sp.Rational(-3, 2)
    assert CarlsonRJ(x, y, z, y) == CarlsonRD(x, z, y)
    assert CarlsonRF(0, 0, x) == CarlsonRD(x, y, 0) == CarlsonRJ(x, y, z, 0) == CarlsonRC(x, 0) == sp.oo
    assert CarlsonRF(x, y, z).is_positive
    assert sp.Symbol("q") in CarlsonRF(0, 1, sp.Symbol("q")).free_symbols


@pytest.mark.parametrize("place", [("9/4", "2"), ("1/3", "5"), ("7", "7/8"), ("0", "3")])
def test_the_elementary_form_is_the_function(place):
    function = CarlsonRC(*map(sp.Rational, place))
    elementary = sp.expand_func(function)
    assert not elementary.has(CarlsonRC)
    with mp.workdps(50):
        assert close(
            sp.N(elementary, 40), mp.elliprc(*(mp.mpf(sp.Rational(a).p) / sp.Rational(a).q for a in place)), 39
        )


def principal_value(a, q):
    """The integral of R_J(…, −q), or R_C(·, −q) for one root, about its pole: the odd part of the pole drops out."""

    def root(t):
        value = mp.mpf(1)
        for v in a:
            value /= mp.sqrt(t + v)
        return value

    near = mp.quad(lambda s: (root(q + s) - root(q - s)) / s, [0, q / 2, q])
    return near + mp.quad(lambda t: root(t) / (t - q), [2 * q, 4 * q, mp.inf])


@pytest.mark.parametrize(
    ("place", "q"), [(("1", "2", "3"), "1/2"), (("1/5", "4", "7"), "9"), (("2", "1/3", "1/4"), "2")]
)
def test_negative_last_arguments_are_principal_values(place, q):
    with mp.workdps(45):
        numbers, pole = (
            [mp.mpf(sp.Rational(a).p) / sp.Rational(a).q for a in place],
            mp.mpf(sp.Rational(q).p) / sp.Rational(q).q,
        )
        third = sp.N(CarlsonRJ(*map(sp.Rational, place), -sp.Rational(q)), 30)
        assert close(third, 3 * principal_value(numbers, pole) / 2, 25)
        first = sp.N(CarlsonRC(sp.Rational(place[0]), -sp.Rational(q)), 30)
        assert close(first, principal_value(numbers[:1], pole) / 2, 20)


def test_no_number_where_the_integral_does_not_exist():
    for function in (CarlsonRF(-1, 2, 3), CarlsonRD(1, 2, -3), CarlsonRJ(1, -2, 3, 4), CarlsonRC(-1, 2)):
        assert sp.N(function, 20) == function
        assert not sp.N(function, 20).is_Float


def test_complex_conjugate_arguments():
    value = sp.N(CarlsonRF(1, 2 + sp.I, 2 - sp.I), 40)
    with mp.workdps(50):
        assert close(sp.re(value), mp.re(DEFINED[CarlsonRF]([mp.mpf(1), mp.mpc(2, 1), mp.mpc(2, -1)])), 30)


def test_latex():
    assert sp.latex(CarlsonRF(x, y, z)) == r"R_{F}\left(x, y, z\right)"
    assert sp.latex(CarlsonRJ(x, y, z, p) ** 2) == r"R_{J}^{2}\left(x, y, z, p\right)"


@pytest.mark.parametrize("backend", ["numpy", "scipy", "mpmath"])
def test_lambdify(backend):
    expression = CarlsonRF(x, y, z) + 2 * CarlsonRC(x, y) - CarlsonRD(x, y, z) * CarlsonRJ(x, y, z, p)
    if backend == "scipy":
        pytest.importorskip("scipy")
    compiled = sp.lambdify((x, y, z, p), expression, backend)
    exact = sp.N(expression.subs({x: sp.Rational(1, 3), y: 2, z: 3, p: 4}), 40)
    if backend == "mpmath":
        with mp.workdps(50):
            assert close(exact, compiled(mp.mpf(1) / 3, mp.mpf(2), mp.mpf(3), mp.mpf(4)), 38)
    else:
        assert compiled(np.full(2, 1 / 3), 2.0, 3.0, 4.0) == pytest.approx([float(exact)] * 2, rel=2e-15, abs=0)


def test_numbers_are_right_however_far_apart_the_arguments_are():
    from hjsolve.arithmetic import carlson

    places = 10.0 ** np.random.default_rng(15).uniform(-12, 12, (4, 200))
    for name, count in (("rf", 3), ("rc", 2), ("rd", 3), ("rj", 4)):
        doubles = getattr(carlson, f"carlson_{name}")(*places[:count])
        with mp.workdps(40):
            exact = [getattr(mp, f"ellip{name}")(*map(mp.mpf, map(float, column))) for column in places[:count].T]
            assert max(abs(mp.mpf(float(d)) / e - 1) for d, e in zip(doubles, exact)) < 2e-15


def test_an_element_does_not_depend_on_its_neighbours():
    from hjsolve.arithmetic import carlson

    places = 10.0 ** np.random.default_rng(16).uniform(-6, 6, (4, 50))
    for name, count in (("rf", 3), ("rc", 2), ("rd", 3), ("rj", 4)):
        function = getattr(carlson, f"carlson_{name}")
        assert [float(function(*column)) for column in places[:count].T] == function(*places[:count]).tolist()


def test_doubles_outside_the_domain_are_nan_and_principal_values_agree():
    from hjsolve.arithmetic import carlson

    assert np.isnan(
        [
            carlson.carlson_rf(-1, 2, 3),
            carlson.carlson_rd(1, 2, -3),
            carlson.carlson_rj(1, -2, 3, 1),
            carlson.carlson_rc(-1, 2),
        ]
    ).all()
    assert carlson.carlson_rc(2, -3) == pytest.approx(float(mpmath.elliprc(2, -3)), rel=1e-15)
    exact = sp.N(CarlsonRJ(1, 2, 3, -sp.Rational(1, 2)), 20)
    assert carlson.carlson_rj([1, 1], 2, 3, [-0.5, 0.5]) == pytest.approx(
        [float(exact), float(mpmath.elliprj(1, 2, 3, 0.5))], rel=3e-15
    )
