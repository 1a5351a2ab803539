"""Integrals past pairs of complex poles, against quadratures; and textbook potentials that need them."""

from itertools import pairwise
from random import Random

import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.closed_form.complex_poles import pair_of_complex_poles
from hjsolve.closed_form.signs import Signs

x = sp.Symbol("x", real=True)


def drawn(seed):
    """Draw a quadratic, a pair of poles and a numerator; every fifth pair is even, every seventh P linear."""
    dice = Random(seed)
    A, B, C, p, K, L = (sp.Rational(dice.randint(-30, 30), 10) for _ in range(6))
    q = sp.Rational(dice.randint(1, 30), 10)
    if seed % 5 == 0:
        B, p = sp.S.Zero, sp.S.Zero
    return (sp.S.Zero if seed % 7 == 0 else A, B, C), (p, q), (K, L)


def pieces(A, B, C):
    """Intervals, of at most 12 in length, on which P > 0."""
    P = sp.Poly(A * x**2 + B * x + C, x)
    roots = sorted(sp.re(r) for r in P.nroots(n=30) if abs(sp.im(r)) < 1e-12)
    cuts = roots or [6]
    ends = [(cuts[0] - 12, cuts[0]), *pairwise(cuts), (cuts[-1], cuts[-1] + 12)]
    return [(a, b) for a, b in ends if P.eval((a + b) / 2) > 0 and (roots or (a, b) == ends[0])]


def has_two_branch_points(seed):
    (A, B, C), _, _ = drawn(seed)
    return (A != 0 or B != 0) and B**2 != 4 * A * C


SEEDS = [seed for seed in range(40) if has_two_branch_points(seed)]


@pytest.mark.parametrize("seed", [*SEEDS[:16], *(pytest.param(s, marks=pytest.mark.nightly) for s in SEEDS[16:])])
def test_the_integral_is_that_of_a_quadrature(seed):
    (A, B, C), (p, q), (K, L) = drawn(seed)
    P = sp.Poly(A * x**2 + B * x + C, x)
    for low, high in pieces(A, B, C):
        found = pair_of_complex_poles(P, (p, q, K, L), Signs({}, mp.mpf(str((low + high) / 2))))
        with mp.workdps(30):
            value = sp.lambdify(x, found.written(x), "mpmath")
            integrand = sp.lambdify(x, found.integrand(x) / sp.sqrt(P.as_expr()), "mpmath")
            a, b = (
                mp.mpf(str(low + fraction * (high - low))) for fraction in (sp.Rational(1, 20), sp.Rational(19, 20))
            )
            assert abs(value(b) - value(a) - mp.quad(integrand, mp.linspace(a, b, 9))) < 1e-18


@pytest.mark.parametrize(
    ("potential", "domain", "place", "energy"),
    [
        # Rosen and Morse, trigonometric: y = J a + sqrt(2 m A), E = y^2/2m - 2 m B^2/y^2
        ("A/sin(a*x)**2 + 2*B*cot(a*x)", "0 < x < pi/a", "1", lambda J, m, A, B, a: _levels(J * a + _root(2 * m * A), m, B)),
        # an oscillator of the mass m/(1 + a x^2) (Mathews and Lakshmanan 1974)
        ("A*x**2/(2*(1 + a*x**2))", "line", "1/3", lambda J, m, A, B, a: J * mp.sqrt(A / m) - a * J**2 / (2 * m)),
        # Scarf, between poles whose place the domain does not name
        ("(A + B*sin(a*x))/cos(a*x)**2", "-3*pi/4 < x < 3*pi/4", "1/3", None),
        ("A*tan(a*x)**2", "-3*pi/4 < x < 3*pi/4", "1/3", lambda J, m, A, B, a: (J * a + _root(2 * m * A)) ** 2 / (2 * m) - A),
    ],
)  # fmt: skip
def test_textbook_potentials(potential, domain, place, energy):
    values = {"m": "3/2", "A": "2", "B": "1/3", "a": "2/3"}
    kinetic = "m*dot(x)**2/(2*(1 + a*x**2))" if domain == "line" else "m*dot(x)**2/2"
    used = {name: value for name, value in values.items() if name in potential + kinetic}
    solution = hjsolve.solve(hjsolve.System({"x": domain}, kinetic, potential, used))
    motion = solution.motion(q={"x": place}, velocity={"x": "1/5"}, digits=25)
    form = hjsolve.closed_forms(motion)[0]
    assert form.time_law is not None
    assert form.characteristic_function is not None
    with mp.workdps(30):
        J, E = motion.actions["x"], motion.constants["E"].value
        held = {s.name: s for s in form.energy.free_symbols}
        given = {held[n]: sp.Rational(v) for n, v in used.items() if n in held} | {held["J_x"]: sp.Float(J.value, 30)}
        assert abs(sp.N(form.energy.subs(given), 25) - E) < 1e-22
        if energy is not None:
            m, A, B, a = (mp.mpf(sp.Rational(values[n]).p) / sp.Rational(values[n]).q for n in ("m", "A", "B", "a"))
            assert abs(energy(J.value, m, A, B, a) - E) < 1e-22


def _root(value):
    return mp.sqrt(value)


def _levels(y, m, B):
    return y**2 / (2 * m) - 2 * m * B**2 / y**2
