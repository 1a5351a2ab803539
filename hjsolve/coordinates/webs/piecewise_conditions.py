"""Real solution sets of small polynomial systems, one parametrised piece after the other.

The special members of a linear family of webs (the circles among the ellipses, the double eigenvalues) are given by
quadratic and cubic equations in few unknowns. They are split by factors, by linear unknowns and by sums of squares,
which is enough for the families that potentials have; what is left over gets a representative point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from random import Random

import sympy as sp

from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.webs.orthonormal_frames import TooHardError
from hjsolve.precision import mp

_MOST_BRANCHES = 400


@dataclass(frozen=True)
class SolutionPiece:
    """A part of a solution set: unknown → expression in the free unknowns.

    Attributes:
        values: every unknown, expressed in the free ones.
        free: the free unknowns; their number is the dimension of the piece.
        whole: False where only a representative was found.
    """

    values: dict[sp.Symbol, sp.Expr]
    free: tuple[sp.Symbol, ...]
    whole: bool = True


def real_pieces(equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]) -> list[SolutionPiece]:
    """Solve polynomial equations over the reals; parameters in the coefficients are generic.

    Args:
        equations: polynomials that have to vanish.
        unknowns: their variables; other symbols are parameters.

    Returns:
        The pieces found, without those that lie inside a larger one.

    Raises:
        TooHardError: too many branches; some pieces would be missing.
    """
    search = _Search(tuple(unknowns), [_MOST_BRANCHES])
    raw = _split(search, _Branch(tuple(sp.expand(e) for e in equations), {}, ()))
    if search.budget[0] < 0:
        raise TooHardError
    pieces: list[SolutionPiece] = []
    for branch in raw:
        full = {u: sp.together(_close(u, branch.values)) for u in unknowns}
        free = tuple(u for u in unknowns if u not in branch.values)
        if all(piece.values != full for piece in pieces):
            pieces.append(SolutionPiece(full, free, branch.whole))
    return [p for p in pieces if not _inside_another(p, pieces, equations, unknowns)]


@dataclass(frozen=True)
class _Search:
    unknowns: tuple[sp.Symbol, ...]
    budget: list[int]


@dataclass(frozen=True)
class _Branch:
    """Equations left, values found, polynomials that are not zero here."""

    equations: tuple[sp.Expr, ...]
    values: dict[sp.Symbol, sp.Expr]
    nonzero: tuple[sp.Expr, ...]
    whole: bool = True

    def put(self, u: sp.Symbol, value: sp.Expr, *extra: sp.Expr) -> _Branch:
        """Substitute an unknown everywhere."""
        equations = tuple(e.subs(u, value) for e in (*self.equations, *extra))
        return replace(
            self,
            equations=equations,
            values={**self.values, u: value},
            nonzero=tuple(e.subs(u, value) for e in self.nonzero),
        )


def _close(u: sp.Symbol, values: dict[sp.Symbol, sp.Expr]) -> sp.Expr:
    expression: sp.Expr = u
    while expression.free_symbols & set(values):
        expression = expression.xreplace(values)
    return expression


def _split(search: _Search, branch: _Branch) -> list[_Branch]:
    """Return the solved branches."""
    check_time()
    search.budget[0] -= 1
    if search.budget[0] < 0:
        return []
    zeros = [_factors(e, search.unknowns) for e in branch.nonzero]
    if None in zeros:
        return []
    known = {f for factors in zeros for f in factors or ()}
    parts = []
    for equation in branch.equations:
        factors = _factors(equation, search.unknowns)
        if factors is not None:
            parts.append([f for f in factors if f not in known and -f not in known])
    if [] in parts:
        return []
    branch = replace(branch, nonzero=tuple(sorted(known, key=str)))
    if not parts:
        return [branch]
    single = {part[0] for part in parts if len(part) == 1}
    parts = [part for part in parts if len(part) == 1 or not single & set(part)]
    parts.sort(key=lambda part: (len(part), sum(sp.count_ops(f) for f in part)))
    for part in parts:
        if len(part) > 1:
            rest = [sp.Mul(*other) for other in parts if other is not part]
            return [b for f in part for b in _split(search, replace(branch, equations=(f, *rest)))]
    return _single(search, replace(branch, equations=tuple(part[0] for part in parts)))


@lru_cache(maxsize=4096)
def _factors(equation: sp.Expr, unknowns: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, ...] | None:
    """Return the distinct factors that contain unknowns; None for 0 = 0, () for a contradiction."""
    numerator = sp.expand(sp.numer(sp.together(equation)))
    if numerator == 0:
        return None
    inside = sorted(numerator.free_symbols & set(unknowns), key=str)
    if not inside:
        return None if sp.simplify(numerator) == 0 else ()
    if max(sum(monomial) for monomial in sp.Poly(numerator, *inside).monoms()) == 1:
        return (numerator,)
    roots = [a for a in numerator.atoms(sp.Pow) if a.base.is_Rational and a.exp.is_Rational and not a.exp.is_Integer]
    options = {"extension": sorted(roots, key=str)} if roots else {}
    return tuple(f for f, _ in sp.factor_list(numerator, *inside, **options)[1])


def _single(search: _Search, branch: _Branch) -> list[_Branch]:
    """Eliminate one unknown from irreducible polynomials."""
    polynomials, unknowns = branch.equations, search.unknowns
    for p in polynomials:
        check_time()
        for u in unknowns:
            if p.has(u) and sp.degree(p, u) == 1 and not sp.Poly(p, u).LC().free_symbols & set(unknowns):
                return _split(search, branch.put(u, sp.expand(-p.subs(u, 0) / sp.Poly(p, u).LC())))
    for p in polynomials:
        squares = _sum_of_squares(p, [u for u in unknowns if p.has(u)])
        if squares is not None:
            others = tuple(q for q in polynomials if q is not p)
            return _split(search, replace(branch, equations=(*squares, *others)))
    for p in polynomials:
        inside = [u for u in unknowns if p.has(u)]
        if len(inside) == 1:
            return [b for root in _real_roots(p, inside[0]) for b in _split(search, branch.put(inside[0], root))]
    return _by_quotient(search, branch) or _representative(search, branch)


def _by_quotient(search: _Search, branch: _Branch) -> list[_Branch]:
    """Solve a polynomial that is linear in an unknown; its slope is zero, or it is not."""
    for p in branch.equations:
        for u in search.unknowns:
            if p.has(u) and sp.degree(p, u) == 1:
                slope, rest = sp.Poly(p, u).LC(), p.subs(u, 0)
                regular = replace(branch, nonzero=(*branch.nonzero, slope)).put(u, -rest / slope)
                others = tuple(q for q in branch.equations if q is not p)
                return _split(search, regular) + _split(search, replace(branch, equations=(slope, rest, *others)))
    return []


def _representative(search: _Search, branch: _Branch) -> list[_Branch]:
    u = next(u for u in search.unknowns if branch.equations[0].has(u))
    for guess in (sp.S.Zero, sp.S.One, -sp.S.One, sp.Integer(2), -sp.Integer(2), sp.S.Half):
        answer = _split(search, replace(branch, whole=False).put(u, guess))
        if answer:
            return answer
    return []


def _real_roots(p: sp.Expr, u: sp.Symbol) -> list[sp.Expr]:
    """Return the real roots of an irreducible polynomial; TooHardError where radicals do not show them to be real."""
    check_time()
    polynomial = sp.Poly(p, u)
    found = [r for r in sp.roots(polynomial) if r.is_real is not False and not r.has(sp.I)]
    if polynomial.degree() > 2 and (p.free_symbols != {u} or not _rational(polynomial)):
        raise TooHardError
    if polynomial.degree() > 2 and len(found) != sp.count_roots(polynomial):
        raise TooHardError
    return found


def _rational(polynomial: sp.Poly) -> bool:
    return all(c.is_Rational for c in polynomial.all_coeffs())


def _sum_of_squares(p: sp.Expr, unknowns: list[sp.Symbol]) -> list[sp.Expr] | None:
    """Return linear forms ℓ with p = ±Σ c ℓ², c > 0, with the zeros of p; None where p is not of the kind.

    A positive constant left over makes the form 1 (no solution).
    """
    polynomial = sp.Poly(p, *unknowns)
    if polynomial.total_degree() != 2:
        return None
    forms: list[sp.Expr] = []
    signs: set[int] = set()
    rest = p
    for u in unknowns:
        square = sp.Poly(rest, u)
        if square.degree() == 0:
            continue
        if square.degree() == 1:
            return None
        lead, half = square.LC(), square.coeff_monomial(u) / 2
        if lead.free_symbols & set(unknowns) or not (lead.is_positive or lead.is_negative):
            return None
        signs.add(1 if lead.is_positive else -1)
        forms.append(sp.expand(u + half / lead))
        rest = sp.expand(rest - lead * forms[-1] ** 2)
    if rest != 0:
        if not (rest.is_positive or rest.is_negative):
            return None
        signs.add(1 if rest.is_positive else -1)
        forms.append(sp.S.One)
    return forms if len(signs) == 1 else None


def _inside_another(
    piece: SolutionPiece, pieces: list[SolutionPiece], equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]
) -> bool:
    """Tell whether a piece lies in the closure of a larger one.

    The free unknowns of the larger piece are coordinates, so its parametrisation can be asked directly; where that
    divides by zero, the rank of the Jacobian at a generic point decides (a smooth point of the larger piece).
    """
    larger = [other for other in pieces if len(other.free) > len(piece.free)]
    if any(_covers(other, piece) for other in larger):
        return True
    if not larger:
        return False
    random = Random(3)  # noqa: S311
    symbols = sorted(sp.Tuple(*piece.values.values(), *equations).free_symbols, key=str)
    numbers = {s: sp.Rational(random.randint(11, 99), 17) for s in symbols}
    numbers.update({u: value.subs(numbers) for u, value in piece.values.items()})
    jacobian = [[sp.diff(e, u).subs(numbers) for u in unknowns] for e in equations]
    with mp.workdps(40):
        singular = mp.svd_c(mp.matrix([[mp.mpmathify(e.evalf(40)) for e in row] for row in jacobian]), compute_uv=False)
        rank = sum(1 for value in singular if abs(value) > mp.mpf(10) ** -20)
    return len(unknowns) - rank in {len(other.free) for other in larger}


def _covers(larger: SolutionPiece, smaller: SolutionPiece) -> bool:
    place = {f: smaller.values[f] for f in larger.free}
    images = {u: value.subs(place, simultaneous=True) for u, value in larger.values.items()}
    return all(sp.simplify(images[u] - smaller.values[u]) == 0 for u in images)
