"""Constant concircular tensors: Cartesian webs, and cylinders over the webs of a plane.

A constant tensor A is in the kernel exactly when it commutes with every Hessian of V. Three different eigenvalues
mean V = Σ Vᵢ along the eigenvectors. Two equal ones mean V = f(d·x) + U(plane ⟂ d): then every plane web of U gives a
cylinder web of V.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from hjsolve.coordinates.killing.killing_tensors import concircular_basis, kernel, killing_tensor
from hjsolve.coordinates.webs.concircular_families import family, representatives
from hjsolve.coordinates.webs.describe import in_words
from hjsolve.coordinates.webs.orthonormal_frames import (
    Sign,
    attempt,
    eigenframe,
    perpendicular_frame,
    righted,
    sort_frame,
    stepped,
    tidy_constant,
)
from hjsolve.coordinates.webs.piecewise_conditions import SolutionPiece
from hjsolve.coordinates.webs.plane import plane_webs
from hjsolve.coordinates.webs.rank_one import directions, members
from hjsolve.coordinates.webs.web import Geometry, Vector

_CYLINDER = {"polar": "circular cylinder", "parabolic": "parabolic cylinder", "elliptic": "elliptic cylinder"}
_ORIGIN: Vector = (sp.S.Zero, sp.S.Zero, sp.S.Zero)
_MOST_DIRECTIONS = 3


def cylinder_webs(constant: Sequence[sp.MatrixBase], V: sp.Expr, x: Sequence[sp.Symbol], sign: Sign) -> list[Geometry]:
    """List the Cartesian and cylinder webs of a family of constant tensors.

    Args:
        constant: matrices M = [[A, 0], [0, 0]], independent modulo the metric.
        V: potential in Cartesian coordinates x of equal mass.
        x: coordinates.
        sign: sign of a constant.

    Returns:
        The webs; kind ``split`` where V splits off a direction and the rest does not separate.
    """
    if not constant:
        return []
    forms = [sp.Matrix(M[:3, :3]) for M in constant]
    webs = attempt(lambda: _cartesian(forms, sign)) + attempt(
        lambda: [web for piece in directions(forms) for web in _over_directions(piece, V, x, sign)]
    )
    if any(web.kind != "split" for web in webs):
        webs = [web for web in webs if web.kind != "split"]
    return webs


def _form(forms: Sequence[sp.Matrix], numbers: Sequence[sp.Expr]) -> sp.Matrix:
    return sum((c * f for c, f in zip(numbers, forms, strict=True)), sp.zeros(3, 3))


def _cartesian(forms: Sequence[sp.Matrix], sign: Sign) -> list[Geometry]:
    def member(values: tuple[sp.Expr, ...]) -> Geometry | None:
        (low, e1), (middle, e2), (high, e3) = sort_frame(eigenframe(_form(forms, values)), sign)
        if tidy_constant(middle - low) == 0 or tidy_constant(high - middle) == 0:
            return None
        axes = sorted((e1, e2, e3), key=lambda v: [c != 0 for c in v], reverse=True)
        return Geometry("cartesian", _ORIGIN, righted(axes[0], axes[1]))

    freedom = {1: 0, 2: 0, 3: 1, 5: 3}.get(len(forms), 0)
    best = representatives(member, len(forms), lambda _: "cartesian", lambda web: web.complexity)
    return [in_words(web, freedom, member) for web in best.values()]


def _over_directions(piece: SolutionPiece, V: sp.Expr, x: Sequence[sp.Symbol], sign: Sign) -> list[Geometry]:
    freedom = len(piece.free) - 1
    trials = members(piece, _MOST_DIRECTIONS)[::-1]
    found = []
    for d in trials:
        frame = perpendicular_frame(d)
        webs = [web for web in _plane_webs(V, x, frame, sign) if web.kind != "cartesian"]
        found.append(webs or [Geometry("split", _ORIGIN, frame)])
    result: dict[str, Geometry] = {}
    for web in (web for webs in found for web in webs):
        everywhere = all(any(other.kind == web.kind for other in webs) for webs in found)
        result.setdefault(web.kind, _free_direction(web, freedom) if freedom and everywhere else web)
    return list(result.values())


def _free_direction(web: Geometry, freedom: int) -> Geometry:
    words = "the direction of the cylinder may be turned" + (" in a plane" if freedom == 1 else " at will")
    return replace(web, freedom=web.freedom + freedom, family="; ".join(p for p in (words, web.family) if p))


def _plane_webs(V: sp.Expr, x: Sequence[sp.Symbol], frame: tuple[Vector, Vector, Vector], sign: Sign) -> list[Geometry]:
    """Return the plane webs of V restricted to a plane perpendicular to the last axis of a frame."""
    p, q = sp.symbols("p_ q_", real=True)
    y = (p, q)
    for height in (0, 1, sp.Rational(3, 7), -2):
        place = stepped(_ORIGIN, [(p, frame[0]), (q, frame[1]), (sp.sympify(height), frame[2])])
        U = V.subs(dict(zip(x, place, strict=True)), simultaneous=True)
        if not U.has(sp.zoo, sp.nan, sp.oo):
            break
    tensors = tuple(killing_tensor(M, y) for M in concircular_basis(2))
    return plane_webs(
        family(kernel(sp.expand(U), y, tensors, check=False).vectors, 2), sign, lambda web: _lifted(web, frame)
    )


def _lifted(web: Geometry, frame: tuple[Vector, Vector, Vector]) -> Geometry:
    """Put a plane web into space, its axes first and the direction of the cylinder last."""

    def lift(v: Vector) -> Vector:
        return stepped(_ORIGIN, [(v[0], frame[0]), (v[1], frame[1])])

    first, second = (lift(v) for v in web.axes)
    return replace(
        web,
        kind=_CYLINDER.get(web.kind, web.kind),
        centre=lift(web.centre),
        axes=righted(first, second),
        foci=tuple(lift(f) for f in web.foci),
    )
