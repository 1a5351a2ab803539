"""A family of webs in words: what is fixed and what may be varied."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import sympy as sp

from hjsolve.coordinates.webs.concircular_families import FamilyMember
from hjsolve.coordinates.webs.orthonormal_frames import TooHardError, scalar_product
from hjsolve.coordinates.webs.web import Geometry, Vector, point_text

_PLACE = {"polar": "pole", "parabolic": "focus", "rotational parabolic": "focus", "parabolic cylinder": "focal line"}


def in_words(
    found: FamilyMember[Geometry], freedom: int, member: Callable[[tuple[sp.Expr, ...]], Geometry | None]
) -> Geometry:
    """Describe the family that a representative stands for by varying its parameters one at a time.

    Args:
        found: the representative and its parameter values.
        freedom: number of continuous parameters of the family.
        member: the web at given parameter values.
    """
    best = found.member
    if freedom == 0:
        return best
    others = [best]
    for index in range(len(found.values)):
        for step in (1, -1, 2):
            try:
                other = member(tuple(v + step * (i == index) for i, v in enumerate(found.values)))
            except TooHardError:
                continue
            if other is not None and other.kind == best.kind and other not in others:
                others.append(other)
                break
    return replace(best, freedom=freedom, family=_describe(best, others))


def _describe(best: Geometry, members: Sequence[Geometry]) -> str:
    clauses = []
    shared = [f for f in best.foci if all(any(_same(f, g) for g in member.foci) for member in members)]
    one_focus = len(best.foci) == 2 and len(shared) == 1
    place = _PLACE.get(best.kind, "centre")
    if best.kind != "cartesian":
        if one_focus:
            clauses.append(
                f"one focus at {point_text(shared[0])}, the other {_locus([_other(m, shared[0]) for m in members])}"
            )
        else:
            clauses.append(f"{place} {_locus([best.centre, *(m.centre for m in members)])}")
    if best.kind in ("conical", "ellipsoidal", "cartesian"):
        clauses.append(_frames(best, members))
    elif not one_focus and best.kind not in ("polar", "sphere"):
        index = (
            0
            if len(best.centre) == 2 or best.kind in ("elliptic cylinder", "parabolic cylinder", "paraboloidal")
            else 2
        )
        fixed = all(_parallel(m.axes[index], best.axes[index]) for m in members)
        clauses.append(f"axis along {point_text(best.axes[index])}" if fixed else _directions(members, index))
    if not one_focus and any(
        sp.simplify(m.lengths[key] - best.lengths[key]) != 0 for m in members for key in best.lengths
    ):
        clauses.append("any focal distance" if len(best.lengths) == 1 else "any constants of the web")
    return "; ".join(clauses)


def _frames(best: Geometry, members: Sequence[Geometry]) -> str:
    def fixed(axis: Vector) -> bool:
        return all(any(_parallel(axis, other) for other in member.axes) for member in members)

    kept = [axis for axis in best.axes if fixed(axis)]
    if len(kept) == len(best.axes):
        return "axes fixed"
    return f"one axis along {point_text(kept[0])}, the others turned about it" if kept else "axes in any directions"


def _directions(members: Sequence[Geometry], index: int) -> str:
    different: list[Vector] = []
    for member in members:
        if not any(_parallel(member.axes[index], axis) for axis in different):
            different.append(member.axes[index])
    if len(different) == 2 and len(members) > 3 and scalar_product(different[0], different[1]) == 0:
        return f"axis along {point_text(different[0])} or {point_text(different[1])}"
    rank = sp.Matrix(different).rank(simplify=True)
    if rank < len(different[0]):
        normal = sp.Matrix(different).nullspace()[0]
        return f"axis in any direction perpendicular to {point_text(list(normal))}"
    return "axis in any direction"


def _other(member: Geometry, focus: Vector) -> Vector:
    return next((f for f in member.foci if not _same(f, focus)), focus)


def _locus(points: Sequence[Vector]) -> str:
    """Say where some points lie: at one place, on a line, in a plane, anywhere."""
    first = points[0]
    differences = sp.Matrix([[sp.simplify(a - b) for a, b in zip(p, first, strict=True)] for p in points])
    rank = differences.rank(simplify=True)
    if rank == 0:
        return f"at {point_text(first)}"
    if rank == len(first):
        return "anywhere"
    if rank == 1:
        direction = next(row for row in differences.tolist() if any(row))
        lead = next(c for c in direction if c != 0)
        return f"on the line through {point_text(first)} along {point_text([sp.simplify(c / lead) for c in direction])}"
    normal = sp.Matrix(differences.rowspace()[0]).cross(sp.Matrix(differences.rowspace()[1]))
    return f"in the plane through {point_text(first)} perpendicular to {point_text(list(normal))}"


def _same(a: Vector, b: Vector) -> bool:
    return all(sp.simplify(p - q) == 0 for p, q in zip(a, b, strict=True))


def _parallel(a: Vector, b: Vector) -> bool:
    return sp.Matrix([a, b]).rank(simplify=True) == 1
