"""Jacobi's functions against mpmath's theta functions, the inverse of Legendre's F, and differences; for every real parameter."""

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

from hjsolve.errors import InvalidInputError
from hjsolve.functions import JacobiAM, JacobiCN, JacobiDN, JacobiEpsilon, JacobiSN, modules
from tests.support.gauss import gauss

u, m = sp.symbols("u m", real=True)
FUNCTIONS = (JacobiAM, JacobiSN, JacobiCN, JacobiDN, JacobiEpsilon)
PARAMETERS = ["1/3", "99999/100000", "1/100000", "-1/2", "-40", "3/2", "17"]
ARGUMENTS = ["1/7", "-9/4", "13", "1000000007/3"]


def exact(text):
    number = sp.Rational(text)
    return mp.mpf(number.p) / number.q


def close(one, other, digits):
    with mp.workdps(digits + 10):
        return abs(mp.mpf(str(one)) - other) <= abs(other) * mp.mpf(10) ** -digits


@pytest.mark.parametrize("parameter", PARAMETERS)
@pytest.mark.parametrize("argument", ARGUMENTS)
def test_fifty_digits_are_those_of_theta_functions(argument, parameter):
    for function in FUNCTIONS[1:4]:
        value = sp.N(function(sp.Rational(argument), sp.Rational(parameter)), 52)
        with mp.workdps(75):
            assert close(value, mp.re(mp.ellipfun(function.letter, exact(argument), m=exact(parameter))), 50)


@pytest.mark.parametrize("parameter", ["0", "1/3", "99999/100000", "-1/2", "-40"])
@pytest.mark.parametrize("argument", ["1/7", "-9/4", "13", "40001/3"])
def test_the_amplitude_is_the_inverse_of_legendres_first_integral(argument, parameter):
    value = sp.N(JacobiAM(sp.Rational(argument), sp.Rational(parameter)), 52)
    with mp.workdps(60):
        assert close(sp.Rational(argument).evalf(60), mp.ellipf(mp.mpf(str(value)), exact(parameter)), 47)


def integral_of_dn(v, k, power):
    with mp.workdps(mp.dps + 5):
        pieces = mp.linspace(0, v, 5)
        return mp.quad(lambda w: mp.re(mp.ellipfun("dn", w, m=k)) ** power, pieces, method=gauss)


@pytest.mark.nightly_cases("17")
@pytest.mark.parametrize("parameter", ["1/3", "9/10", "1", "3/2", "17", "-3"])
def test_amplitude_and_epsilon_are_the_integrals_of_dn_and_its_square(parameter):
    place = (sp.Rational(13, 5), sp.Rational(parameter))
    with mp.workdps(22):
        for power, function in ((1, JacobiAM), (2, JacobiEpsilon)):
            assert close(sp.N(function(*place), 40), integral_of_dn(mp.mpf(13) / 5, exact(parameter), power), 18)


@pytest.mark.rotating(8)
@pytest.mark.nightly_cases("JacobiAM-5/2", "JacobiEpsilon-5/2")
@pytest.mark.parametrize("parameter", ["1/3", "9/10", "-3", "5/2"])
@pytest.mark.parametrize("function", FUNCTIONS)
def test_derivatives_are_the_limits_of_differences(function, parameter):
    """For m > 1 and m = −3 the place lies beyond the first quarter, where E(am|m) would be wrong."""

    def raw(v, k):
        if function in {JacobiAM, JacobiEpsilon}:
            return integral_of_dn(v, k, 1 if function is JacobiAM else 2)
        return mp.re(mp.ellipfun(function.letter, v, m=k))

    place = {u: sp.Rational(7, 5), m: sp.Rational(parameter)}
    with mp.workdps(20):
        v, k = mp.mpf(7) / 5, exact(parameter)
        assert close(sp.N(function(u, m).diff(u).subs(place), 40), mp.diff(lambda w: raw(w, k), v), 8)
        assert close(sp.N(function(u, m).diff(m).subs(place), 40), mp.diff(lambda w: raw(v, w), k), 8)


def test_exact_values():
    assert [f(0, m) for f in FUNCTIONS] == [0, 0, 1, 1, 0]
    assert [f(u, 0) for f in FUNCTIONS] == [u, sp.sin(u), sp.cos(u), 1, u]
    assert [f(u, 1) for f in FUNCTIONS] == [2 * sp.atan(sp.tanh(u / 2)), sp.tanh(u), sp.sech(u), sp.sech(u), sp.tanh(u)]
    assert [f(-u, m) for f in FUNCTIONS[:4]] == [-JacobiAM(u, m), -JacobiSN(u, m), JacobiCN(u, m), JacobiDN(u, m)]
    assert JacobiSN(sp.Float(2), sp.Float(1)) == sp.tanh(sp.Float(2))
    K = sp.elliptic_k(m)
    assert [f(K, m) for f in FUNCTIONS] == [sp.pi / 2, 1, 0, sp.sqrt(1 - m), sp.elliptic_e(m)]
    assert [f(-2 * K, m) for f in FUNCTIONS] == [-sp.pi, 0, -1, 1, -2 * sp.elliptic_e(m)]
    φ, small = sp.Symbol("phi", real=True), sp.Symbol("k", negative=True)
    assert [f(sp.elliptic_f(φ, small), small) for f in FUNCTIONS[:3]] == [φ, sp.sin(φ), sp.cos(φ)]
    assert JacobiSN(u, m).is_real
    assert JacobiAM(sp.I, sp.Rational(1, 2)).evalf(20).func == JacobiAM


def test_the_pythagorean_relations_follow_by_differentiation():
    squares = JacobiSN(u, m) ** 2 + JacobiCN(u, m) ** 2
    assert sp.expand(squares.diff(u)) == 0
    assert sp.expand((JacobiDN(u, m) ** 2 + m * JacobiSN(u, m) ** 2).diff(u)) == 0


def test_complex_arguments():
    value = sp.N(JacobiSN(1 + sp.I, sp.Rational(1, 3)), 40)
    with mp.workdps(50):
        assert close(sp.im(value), mp.im(mp.ellipfun("sn", mp.mpc(1, 1), m=mp.mpf(1) / 3)), 38)


def test_latex():
    assert sp.latex(JacobiSN(u, m)) == r"\operatorname{sn}\left(u\middle| m\right)"
    assert sp.latex(JacobiDN(u, m) ** 2) == r"\operatorname{dn}^{2}\left(u\middle| m\right)"


@pytest.mark.parametrize("backend", ["numpy", "scipy", "mpmath"])
def test_lambdify(backend):
    expression = JacobiSN(u, m) + 2 * JacobiCN(u, m) ** 2 - JacobiDN(u, m) * JacobiAM(u, m) + JacobiEpsilon(u, m)
    if backend == "scipy":
        pytest.importorskip("scipy")
    compiled = sp.lambdify((u, m), expression, backend)
    value = sp.N(expression.subs({u: sp.Rational(11, 5), m: sp.Rational(1, 3)}), 40)
    if backend == "mpmath":
        with mp.workdps(50):
            assert close(value, compiled(mp.mpf(11) / 5, mp.mpf(1) / 3), 38)
    else:
        assert compiled(np.full(2, 2.2), 1 / 3) == pytest.approx([float(value)] * 2, rel=1e-14, abs=0)


@pytest.mark.nightly
def test_doubles_for_every_real_parameter():
    from hjsolve.arithmetic import carlson

    rng = np.random.default_rng(17)
    near_one = 1 - 10.0 ** rng.uniform(-14, 0, 30)
    parameters = np.concatenate([rng.uniform(0, 1, 60), near_one, rng.uniform(-30, 30, 60), [0.0, 1.0]])
    arguments = rng.uniform(-8, 8, parameters.size)
    values = carlson.jacobi_functions(arguments, parameters)
    with mp.workdps(40):
        for i, (v, k) in enumerate(zip(arguments, parameters)):
            precise = [sp.N(f(sp.Float(v, 40), sp.Float(k, 40)), 30) for f in FUNCTIONS]
            slope = abs(sp.N(JacobiDN(sp.Float(v, 40), sp.Float(k, 40)), 15))
            room = 1e-15 * (4 + 4 * abs(v) * max(1.0, abs(k)) + 20 * slope)
            assert max(abs(float(a[i] - b)) for a, b in zip(values, precise)) < room


@pytest.mark.parametrize("backend", ["numpy", "mpmath"])
def test_legendres_integrals_in_tables_for_lambdify(backend):
    n, φ = sp.symbols("n phi", real=True)
    terms = [
        sp.elliptic_k(m), sp.elliptic_e(m), sp.elliptic_pi(n, m), sp.elliptic_f(φ, m), sp.elliptic_e(φ, m),
        sp.elliptic_pi(n, φ, m), JacobiSN(φ, m),
    ]  # fmt: skip
    compiled = sp.lambdify((n, φ, m), terms, modules=modules(backend))
    for place in ((0.3, 1.1, 0.4), (-2.0, -1.3, 0.9), (0.5, 7.0, -3.0), (0.2, 20.5, 0.7)):
        exact_ones = [sp.N(term.subs(dict(zip((n, φ, m), map(sp.Rational, place)))), 30) for term in terms]
        got = compiled(*map(mp.mpf, place)) if backend == "mpmath" else compiled(*place)
        assert [float(v) for v in got] == pytest.approx([float(v) for v in exact_ones], rel=3e-14, abs=3e-14)


def test_another_backend_is_refused():
    with pytest.raises(InvalidInputError, match='"numpy" or "mpmath"'):
        modules("tensorflow")


@pytest.mark.parametrize("size", [2.0, 1e3, 1e8, 1e14])
def test_integrals_of_the_third_kind_far_below_zero_keep_their_digits(size):
    """Π(n → −∞) is √|n| times less than F: F + n s³ R_J/3 would lose half of the digits of n."""
    from hjsolve.arithmetic import carlson

    rng = np.random.default_rng(3)
    n, φ, m = -size * rng.uniform(0.5, 2, 40), rng.uniform(-7, 7, 40), rng.uniform(0, 1, 40)
    got, whole = carlson.legendre_pi(n, φ, m), carlson.legendre_pi(n, m)
    with mp.workdps(60):
        for value, complete, own in zip(got, whole, zip(n, φ, m, strict=True), strict=True):
            exact = [mp.mpf(float(v)) for v in own]
            assert abs(value / mp.ellippi(*exact) - 1) < 2e-14
            assert abs(complete / mp.ellippi(exact[0], exact[2]) - 1) < 1e-14
