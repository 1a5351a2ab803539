"""Greenwood chapters 5 and 6: principal functions, brackets, symplectic matrices, generating functions F1 to F4."""

from itertools import combinations

import pytest
import sympy as sp
from mpmath import mp

from tests.support.book import RESULTS, Result, exact, result, solution

q, p, Q, P, time = sp.symbols("q p Q P t", positive=True)
x, x0, m, k, E, t0 = sp.symbols("x x0 m k E t0", positive=True)
w = sp.sqrt(k / m)


def hj(S: sp.Expr, variable: sp.Symbol = x) -> sp.Expr:
    """∂S/∂t + (∂S/∂x)²/2m + kx²/2 of the oscillator (5-52)."""
    return S.diff(time) + S.diff(variable) ** 2 / (2 * m) + k * variable**2 / 2


def primitive(symbol: sp.Symbol) -> sp.Expr:
    """∫ √(2mE − mkx²) dx."""
    a2 = 2 * E / k
    return sp.sqrt(m * k) / 2 * (symbol * sp.sqrt(a2 - symbol**2) + a2 * sp.asin(symbol / sp.sqrt(a2)))


@result("C67", "(5-102)")
def principal_function_with_energy():
    """S = -E*t + m*w*integral of sqrt(a^2 - x^2) solves the Hamilton-Jacobi equation."""
    return exact(hj(-E * time + primitive(x)))


@result("C67", "(5-106)")
def principal_function_of_the_ends_and_energy():
    """S(x, x0, t) before E is eliminated: stationary in E exactly where t - t0 is the time of the motion (5-95)."""
    S = -E * (time - t0) + primitive(x) - primitive(x0)
    slope = S.diff(E) + (time - t0)
    book = (sp.acos(x0 / sp.sqrt(2 * E / k)) - sp.acos(x / sp.sqrt(2 * E / k))) / w
    return exact(hj(S), sp.simplify((slope - book).diff(x)), (slope - book).subs(x, x0))


@result("C67", "(5-108)")
def principal_function_of_the_ends():
    """S = m*w/2*(x^2 + x0^2)*cot w(t - t0) - m*w*x*x0*csc w(t - t0) solves it, with -m*v0 = dS/dx0."""
    S = m * w / 2 * (x**2 + x0**2) * sp.cot(w * (time - t0)) - m * w * x * x0 / sp.sin(w * (time - t0))
    v0 = sp.Symbol("v0", real=True)
    there = x0 * sp.cos(w * (time - t0)) + v0 / w * sp.sin(w * (time - t0))
    return exact(hj(S), S.diff(x0).subs(x, there) + m * v0, S.diff(x).subs(x, there) - m * there.diff(time))


@result("C67", "(5-94), (5-95)")
def oscillator_time():
    """t - b = (1/w)*(acos(x0/a) - acos(x/a)) with a = sqrt(2E/(m*w^2)) is dW/dE."""
    a = sp.sqrt(2 * E / (m * w**2))
    return exact(primitive(x).diff(E, x) + ((sp.acos(x / a)) / w).diff(x))


def poisson(u: sp.Expr, v: sp.Expr) -> sp.Expr:
    return u.diff(q) * v.diff(p) - u.diff(p) * v.diff(q)


def lagrange(u: sp.Symbol, v: sp.Symbol, new: tuple[sp.Expr, sp.Expr]) -> sp.Expr:
    """[u, v] of (6-206)."""
    return new[0].diff(u) * new[1].diff(v) - new[1].diff(u) * new[0].diff(v)


MAPS = {
    "Ex 6-1": (sp.atan(q / p), (q**2 + p**2) / 2, 1),
    "Ex 6-2": (sp.sqrt(2 * q) * sp.exp(time) * sp.cos(p), sp.sqrt(2 * q) * sp.exp(-time) * sp.sin(p), 1),
    "Ex 6-8": (sp.sqrt(q) * sp.cos(p), sp.sqrt(q) * sp.sin(p), sp.Rational(1, 2)),
    "P6-1": (sp.sqrt(q**2 + p**2), -sp.sqrt(q**2 + p**2) * sp.atan(q / p), 1),
    "P6-2": (sp.sin(q), (p - m * k) / sp.cos(q), 1),
    "P6-6": (q * sp.cos(2 * p) ** 2, sp.tan(2 * p) / 2, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", MAPS)
def test_a_map_of_the_book_has_its_brackets_and_its_symplectic_matrix(name: str) -> None:
    """(Q, P) = mu (6-215), [q, p] = mu (6-207), MᵀZM = mu*Z (6-334)."""
    new_q, new_p, valence = MAPS[name]
    new = (new_q, new_p)
    M, Z = sp.Matrix(new).jacobian([q, p]), sp.Matrix([[0, 1], [-1, 0]])
    assert exact(poisson(*new) - valence, lagrange(q, p, new) - valence, M.T * Z * M - valence * Z) == 0


GENERATORS = {
    "P6-2 F2": ("F2", m * k * q + P * sp.sin(q), MAPS["P6-2"]),
    "P6-2 F3": ("F3", (m * k - p) * sp.asin(Q), MAPS["P6-2"]),
    "P6-8 F1": ("F1", q**2 * sp.cot(Q) / 2, (sp.atan(q / p), (q**2 + p**2) / 2, 1)),
    "Ex 6-6 free fall F1": (
        "F1",
        (q - Q) ** 2 / (2 * time) + k * time * (q + Q) / 2,
        (q - p * time + k * time**2 / 2, p - k * time, 1),
    ),
    "Galilei F2": ("F2", (P + m * k) * q, (q, p - m * k, 1)),
}  # fmt: skip


@pytest.mark.parametrize("name", GENERATORS)
def test_a_generating_function_gives_its_map(name: str) -> None:
    """F1: p = F1_q, P = -F1_Q; F2: p = F2_q, Q = F2_P; F3: q = -F3_p, P = -F3_Q (6-18)-(6-58)."""
    kind, F, (new_q, new_p, *_) = GENERATORS[name]
    put = {Q: new_q, P: new_p}
    relations = {
        "F1": [(F.diff(q), p), (-F.diff(Q), P)], "F2": [(F.diff(q), p), (F.diff(P), Q)],
        "F3": [(-F.diff(p), q), (-F.diff(Q), P)], "F4": [(-F.diff(p), q), (F.diff(P), Q)],
    }[kind]  # fmt: skip
    for left, right in relations:
        for point in ((0.3, 1.1), (0.7, 0.4)):
            at = {
                q: sp.Rational(str(point[0])),
                p: sp.Rational(str(point[1])),
                m: 2,
                k: sp.Rational(3, 7),
                time: sp.Rational(5, 4),
            }
            difference = sp.N((left - right).subs(put).subs(at), 40)
            assert abs(difference) < 1e-30, (left, right)


@result("C71", "Ex 6-6, free fall")
def free_fall_generator():
    """F1 = (q - Q)^2/2t + g*t*(q + Q)/2 - g^2*t^3/24 solves the Hamilton-Jacobi equation of H = p^2/2 - g*q exactly."""
    g = k
    F1 = (q - Q) ** 2 / (2 * time) + g * time * (q + Q) / 2
    residual = F1.diff(time) + F1.diff(q) ** 2 / 2 - g * q
    return exact(residual - g**2 * time**2 / 8, residual + (-(g**2) * time**3 / 24).diff(time))


@result("C67", "P6-8")
def oscillator_generators():
    """F2 = integral of sqrt(2P - q^2) gives q = sqrt(2P)*sin Q, p = sqrt(2P)*cos Q, and K = P."""
    F2 = (q * sp.sqrt(2 * P - q**2) + 2 * P * sp.asin(q / sp.sqrt(2 * P))) / 2
    return exact((F2.diff(q) ** 2 + q**2) / 2 - P, sp.simplify(F2.diff(P)) - sp.asin(q / sp.sqrt(2 * P)))


ENTRIES = (
    "kepler-planar",
    "spherical-staeckel",
    "lagrange-top",
    "liouville-three",
    "crossed-fields",
    "rod-with-sliding-end",
)


@pytest.mark.parametrize("entry", ENTRIES)
def test_the_map_to_alpha_and_beta_is_symplectic_at_a_point(entry: str) -> None:
    """(q, p) → (β, α) with −β = ∂W/∂α (6-76)–(6-79): Poisson brackets of the α's vanish, and MᵀZM = Z to 25 digits.

    The β's are differentiated through Jacobi's equations with mpmath, independently of ``hjsolve.solution.laws``.
    """
    found = solution(entry)
    system = found.system
    qs, ps = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    α = [c.symbol for c in found.constants.values()]
    values = {s.symbol: s.value for s in system.parameters}
    point = {s: sp.Rational(4 + i, 11 + i) for i, s in enumerate(qs)} | {
        s: sp.Rational(5 + i, 7) for i, s in enumerate(ps)
    }
    expressions = [c.expression.xreplace(values) for c in found.constants.values()]
    at = {a: sp.N(e.xreplace(point), 60) for a, e in zip(α, expressions, strict=True)}
    A = sp.Matrix([[sp.N(e.diff(s).xreplace(point), 50) for s in (*qs, *ps)] for e in expressions])
    n = len(qs)
    for i, j in combinations(range(n), 2):
        assert abs(sum(A[i, r] * A[j, n + r] - A[i, n + r] * A[j, r] for r in range(n))) < sp.Float("1e-40")
    slopes = []
    for name, momentum in found.momenta.items():
        branch = momentum.xreplace(values)
        F = found.momentum_squared.get(name)
        root = sp.sqrt(F.xreplace(values)) if F is not None else None
        shift = found.shift.get(name, sp.Integer(0)).xreplace(values)
        P = point[system.coordinate(name).momentum] + sp.N(shift.xreplace({**at, **point}), 50)
        sign = sp.sign(P)
        p_of_q = sign * root - shift if root is not None else branch
        slopes.append([sp.N(p_of_q.diff(a).xreplace({**at, **point}), 50) for a in α])
    mixed = sp.Matrix(slopes)  # ∂²W/∂qᵢ∂αⱼ = −∂βⱼ/∂qᵢ at fixed α
    with mp.workdps(50):
        product = A[:, n:] * mixed
    assert max(abs(x) for x in product - sp.eye(n)) < sp.Float("1e-25")


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
