"""What a hyperelliptic curve reduces to: the least genus on which integrals of a coordinate lie, and what was tried.

An involution of the x-axis that maps P to itself divides the curve: x ↦ −x about the middle of the roots, x ↦ 1/x and
x ↦ −1/x (the reflections of an angle, through the tangent of its half). Even integrands over y² = P(x²) are those over
y² = X P(X), X = x², of about half the genus; so again and again. Of a curve of genus 2 every involution is looked for:
six branch points are exchanged in three pairs by a Möbius map if the three quadratics that have the pairs as roots
are linearly dependent (Bolza, Amer. J. Math. 10 (1887) 47).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import mpmath
import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve, genus, momentum_curve
from hjsolve.closed_form.liouville import not_elementary
from hjsolve.closed_form.regions import complex_roots
from hjsolve.closed_form.root_of_a_wave import conic_variables
from hjsolve.closed_form.why_not import HighGenus, NotFound, WhyNot
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.precision import mp

_DIGITS = 60
"""Of branch points: twice what tells a determinant from zero, for those of nearly double roots."""
_NOTHING = mp.mpf(10) ** -25
"""Of its terms, what is left of a determinant that is zero: roots have 60 digits, nearly double ones half as many."""


def why_no_form(found: Iterable[MomentumCurve]) -> WhyNot:
    """Return why a coordinate has no form at all: the genus that is left, and which involutions were looked for.

    Args:
        found: its curves, the simplest first; one at least.
    """
    curves = list(found)
    reduced = [(curve, *_reduced(_at_random(curve.polynomial))) for curve in curves]
    curve, P, steps = min(reduced, key=lambda row: (genus(row[1].degree()), row[2]))
    involution = _in_involution(P) if genus(P.degree()) == 2 else None
    return HighGenus(curve.substitution.place, _at_random(curve.polynomial), P, steps, involution)


def why_no_curve(square: sp.Expr, numerators: Iterable[sp.Expr], coordinate: Coordinate) -> WhyNot:
    """Return why a coordinate has no curve in a variable that is monotone along the motion.

    A proof that its integrals are not elementary, or the genus of a curve in another variable, or what p² is made of.

    Args:
        square: P²(q).
        numerators: N of its integrals, but that of W.
        coordinate: the coordinate.
    """
    q = coordinate.symbol
    proof = not_elementary(square, numerators, q)
    if proof is not None:
        return proof
    for variable in conic_variables(square, q, sp.Dummy("x", real=True)):
        curve = momentum_curve(variable, coordinate, square)
        if curve is not None and genus(curve.degree) > 1 and (why := why_no_form([curve])).proved:
            return why
    held = square.atoms(sp.Function) | {p for p in square.atoms(sp.Pow) if not p.exp.is_Integer}
    functions = sorted(str(a) for a in held if a.has(q))
    bare = square.xreplace({a: sp.Dummy() for a in square.atoms(sp.Function)}).has(q)
    named = [str(q)] * bare + functions
    return NotFound(f"p² is made of {', '.join(named)}: it is algebraic in no variable that is known here")


def _at_random(P: sp.Poly) -> sp.Poly:
    """P for rational constants that nobody chose: what is not special there is not special at all."""
    symbols = sorted(set().union(*(c.free_symbols for c in P.all_coeffs())), key=str)
    values = {s: sp.Rational(17 + 12 * k + k * k, 10 + 7 * k) for k, s in enumerate(symbols)}
    given = [c.xreplace(values) for c in P.all_coeffs()]
    return sp.Poly([c if c.is_Rational else sp.Rational(str(sp.N(c, _DIGITS))) for c in given], P.gen, domain="QQ")


def _reduced(P: sp.Poly) -> tuple[sp.Poly, int]:
    """P after all its reflections are divided out, and how many there were."""
    steps = 0
    while P.degree() > 4:
        divided = next(_divided(P), None)
        if divided is None or genus(divided.degree()) >= genus(P.degree()):
            break
        P, steps = divided, steps + 1
    return P, steps


def _divided(P: sp.Poly) -> Iterator[sp.Poly]:
    """X P(X) of every reflection of P, X the square of a variable in which P is even."""
    x, even = P.gen, P.degree() + P.degree() % 2
    middle = -P.coeff_monomial(x ** (P.degree() - 1)) / (P.degree() * P.LC())
    shifted = P.compose(sp.Poly(x + middle, x))
    below, above = sp.Poly(1 - x, x), sp.Poly(1 + x, x)
    parts = [c * above**n * below ** (even - n) for (n,), c in P.terms()]
    turned = sum(parts[1:], parts[0])
    for candidate in (shifted, turned):
        terms = [(n, c) for (n,), c in candidate.terms() if c != 0]
        if all(n % 2 == 0 for n, _ in terms):
            more = 1 if candidate.degree() == even or candidate is shifted else 0
            yield sp.Poly(sp.Add(*(c * x ** (n // 2 + more) for n, c in terms)), x)


def _in_involution(P: sp.Poly) -> bool:
    """Return whether a Möbius involution exchanges the six branch points of a curve of genus 2."""
    with mp.workdps(_DIGITS):
        coefficients = [mp.mpf(int(c.p)) / int(c.q) for c in P.all_coeffs()]
        points = [(root, mp.mpf(1)) for root in complex_roots(coefficients, _DIGITS)]
        points += [(mp.mpf(1), mp.mpf(0))] * (6 - len(points))
        return any(_dependent(pairs) for pairs in _pairings(points))


Point = tuple[mpmath.mpc, mpmath.mpf]
"""Of the projective line: x = first/second."""


def _quadratic(p: Point, q: Point) -> list[mpmath.mpc]:
    """Return the coefficients of the form with zeros p and q: three pairs of an involution have dependent ones."""
    return [p[1] * q[1], -(p[0] * q[1] + p[1] * q[0]), p[0] * q[0]]


def _dependent(pairs: Sequence[tuple[Point, Point]]) -> bool:
    """Return whether a determinant is zero, by the size of the terms it is made of: x → σx multiplies both by σ³."""
    (a, b, c), (d, e, f), (g, h, i) = (_quadratic(*pair) for pair in pairs)
    whole = mp.fsum((a * e * i, b * f * g, c * d * h, -c * e * g, -b * d * i, -a * f * h))
    # −(p + q) of p = −q is rounding: its size is |p| + |q|
    rows = ([abs(p[1] * q[1]), abs(p[0] * q[1]) + abs(p[1] * q[0]), abs(p[0] * q[0])] for p, q in pairs)
    (a, b, c), (d, e, f), (g, h, i) = rows
    return bool(abs(whole) <= _NOTHING * mp.fsum((a * e * i, b * f * g, c * d * h, c * e * g, b * d * i, a * f * h)))


def _pairings(points: list[Point]) -> Iterator[tuple[tuple[Point, Point], ...]]:
    """Yield the fifteen ways to part six points into pairs."""
    if not points:
        yield ()
        return
    first, *others = points
    for k, partner in enumerate(others):
        for rest in _pairings(others[:k] + others[k + 1 :]):
            yield ((first, partner), *rest)
