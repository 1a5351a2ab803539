"""The webs of the plane: Cartesian, polar, parabolic, elliptic–hyperbolic.

A concircular tensor L = A + w⊙x + m x⊗x of the plane, modulo the metric, is a symmetric product (x − f₁) ⊙ (x − f₂):
two finite foci make an elliptic web, a double one a polar web, a focus and a direction a parabolic web (axis w), and
a constant tensor a Cartesian web. In the constants of Smirnov (math-ph/0604038) k⁴ = [(e′−c′)² + 4f′²]/a².
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce

import sympy as sp

from hjsolve.coordinates.webs.concircular_families import (
    Family,
    combination,
    representatives,
    simplest_members,
    tensor_parts,
)
from hjsolve.coordinates.webs.describe import in_words
from hjsolve.coordinates.webs.orthonormal_frames import Sign, attempt, real_root, stepped, tidy_constant, unit
from hjsolve.coordinates.webs.piecewise_conditions import real_pieces
from hjsolve.coordinates.webs.web import Geometry, Vector

Lift = Callable[[Geometry], Geometry]
_ORIGIN: Vector = (sp.S.Zero, sp.S.Zero)
_STANDARD: tuple[Vector, ...] = ((sp.S.One, sp.S.Zero), (sp.S.Zero, sp.S.One))


def _turned(first: Vector) -> tuple[Vector, ...]:
    return first, (tidy_constant(-first[1]), first[0])


def classify(M: sp.MatrixBase, sign: Sign) -> Geometry | None:
    """Return the web of one concircular tensor; None for a multiple of the metric.

    Args:
        M: [[A, w], [wᵀ, m]], shape (3, 3).
        sign: tells the sign of a constant.
    """
    A, w, m = tensor_parts(M)
    if m != 0:
        return _central(A / m, w / m, sign)
    if any(c != 0 for c in w):
        return _parabolic(A, w)
    if A[0, 1] == 0 and sp.expand(A[0, 0] - A[1, 1]) == 0:
        return None
    denominators = reduce(sp.lcm, (sp.denom(sp.together(c)) for c in A))
    axis = _low_direction((A * denominators).applyfunc(sp.cancel), sign)[1]
    return Geometry("cartesian", _ORIGIN, _STANDARD if axis in _STANDARD else _turned(axis))


def _low_direction(A: sp.MatrixBase, sign: Sign) -> tuple[sp.Expr, Vector]:
    """Return (λ_max − λ_min, unit eigenvector of λ_min) of a symmetric 2×2 matrix that is not a multiple of 1."""
    difference, off = sp.factor(A[0, 0] - A[1, 1]), sp.factor(A[0, 1])
    if off == 0:
        return (-difference, _STANDARD[0]) if sign(difference) < 0 else (difference, _STANDARD[1])
    gap = tidy_constant(sp.sqrt(sp.factor(difference**2 + 4 * off**2))).replace(sp.Abs, lambda u: u)
    gap = -gap if sign(gap) < 0 else gap
    return gap, unit((2 * off, sp.expand(-difference - gap)))


def _central(A: sp.MatrixBase, w: sp.MatrixBase, sign: Sign) -> Geometry:
    """L = A + w⊙x + x⊗x: centre −w, and foci where A − w⊗w has different eigenvalues."""
    centre = tuple(tidy_constant(-c) for c in w)
    rest = (A - w * w.T).applyfunc(sp.expand)
    if sp.simplify(rest[0, 1]) == 0 and sp.simplify(rest[0, 0] - rest[1, 1]) == 0:
        return Geometry("polar", centre, _STANDARD)
    gap, axis = _low_direction(rest, sign)
    k = real_root(gap)
    foci = (stepped(centre, [(k, axis)]), stepped(centre, [(-k, axis)]))
    return Geometry("elliptic", centre, _turned(axis), foci, {"a": k})


def _parabolic(A: sp.MatrixBase, w: sp.MatrixBase) -> Geometry:
    """L = A + w⊙x = (x − f)⊙w modulo the metric: −(w_x f_x − w_y f_y) = (A₁₁−A₂₂)/2, −(w_x f_y + w_y f_x) = A₁₂."""
    difference, off = (A[0, 0] - A[1, 1]) / 2, A[0, 1]
    square = w[0] ** 2 + w[1] ** 2
    focus = (
        tidy_constant(-(w[0] * difference + w[1] * off) / square),
        tidy_constant((w[1] * difference - w[0] * off) / square),
    )
    return Geometry("parabolic", focus, _turned(unit(tuple(w))), (focus,))


def _family_webs(
    kind: str, base: sp.MatrixBase | None, terms: Sequence[sp.MatrixBase], freedom: int, sign: Sign, lift: Lift
) -> list[Geometry]:
    """Return the simplest web of one kind in the linear family base + Σ t·term.

    Where the family holds letters, the simplest member is looked for at their values.
    """

    def member(values: tuple[sp.Expr, ...]) -> Geometry | None:
        found = classify(combination(base, terms, values, 2), sign)
        return lift(found) if found is not None and found.kind == kind else None

    def in_numbers(values: tuple[sp.Expr, ...]) -> Geometry | None:
        found = classify(sign.in_numbers(combination(base, terms, values, 2)), sign)
        return lift(found) if found is not None and found.kind == kind else None

    if freedom == 0:
        only = member(tuple(sp.S.One for _ in terms))
        return [only] if only is not None else []
    letters = any(M is not None and M.free_symbols for M in (base, *terms))
    best = simplest_members(member, len(terms), lambda _: kind, lambda g: g.complexity, in_numbers if letters else None)
    return [in_words(best[kind], freedom, member)] if best else []


def plane_webs(family: Family, sign: Sign, lift: Lift = lambda web: web) -> list[Geometry]:
    """List the webs of a linear family, one representative for every kind and component.

    Args:
        family: the concircular tensors with d(K·dV) = 0, of n = 2.
        sign: sign of a constant; decides on which axis the foci lie where parameters are left open.
        lift: puts a plane web where it belongs (a cylinder in space); the family words are made of the lifted webs.
    """
    webs: list[Geometry] = []
    if family.constant:
        webs += _family_webs("cartesian", None, family.constant, len(family.constant) - 1, sign, lift)
    if family.axial:
        terms = (*family.axial, *family.constant)
        webs += _family_webs("parabolic", None, terms, len(terms) - 1, sign, lift)
    if family.central is not None:
        terms = (*family.axial, *family.constant)
        webs += attempt(lambda: _polar(family, terms, sign, lift))
        webs += _family_webs("elliptic", family.central, terms, len(terms), sign, lift)
    return webs


def _polar(family: Family, terms: Sequence[sp.MatrixBase], sign: Sign, lift: Lift) -> list[Geometry]:
    """Solve A − w⊗w = multiple of 1 for the parameters of the family."""
    t = sp.symbols(f"t0:{len(terms)}", real=True)
    A, w, _ = tensor_parts(combination(family.central, terms, t, 2))
    rest = A - w * w.T
    webs = []
    for piece in real_pieces([rest[0, 0] - rest[1, 1], rest[0, 1]], t):

        def member(values: tuple[sp.Expr, ...], piece=piece) -> Geometry | None:  # type: ignore[no-untyped-def]
            place = dict(zip(piece.free, values, strict=True))
            numbers = tuple(piece.values[u].subs(place) for u in t)
            found = classify(combination(family.central, terms, numbers, 2), sign)
            return None if found is None else lift(found)

        best = representatives(member, len(piece.free), lambda _: "polar", lambda g: g.complexity)
        if best:
            webs.append(in_words(best["polar"], len(piece.free), member))
    return webs
