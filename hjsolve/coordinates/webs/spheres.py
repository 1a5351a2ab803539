"""The spherical factor: separable webs of a potential restricted to spheres about a centre.

On the unit sphere the Killing tensors are Σ c_ij L_i L_j with L = x × p about the centre; modulo L² a matrix c with two
equal eigenvalues makes spherical coordinates about the odd eigenvector, three different ones sphero-conical
coordinates, the roots s of Σ x_i²/(s − e_i) = 0 (Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117, §6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import sympy as sp

from hjsolve.coordinates.killing.killing_tensors import kernel
from hjsolve.coordinates.webs.concircular_families import representatives
from hjsolve.coordinates.webs.describe import in_words
from hjsolve.coordinates.webs.expanded_potential import flattened
from hjsolve.coordinates.webs.orthonormal_frames import (
    Sign,
    eigenframe,
    perpendicular_frame,
    righted,
    sort_frame,
    tidy_constant,
)
from hjsolve.coordinates.webs.piecewise_conditions import SolutionPiece
from hjsolve.coordinates.webs.rank_one import V as DIRECTION
from hjsolve.coordinates.webs.rank_one import direction, directions
from hjsolve.coordinates.webs.web import Geometry

_PAIRS = tuple(combinations_with_replacement(range(3), 2))


def rotation_tensors(x: Sequence[sp.Symbol]) -> tuple[sp.ImmutableMatrix, ...]:
    """Return the six Killing tensors L_a ⊙ L_b of rotations about the origin."""
    radius = sp.Matrix(list(x))
    turns = [sp.Matrix([int(i == a) for i in range(3)]).cross(radius) for a in range(3)]
    products = [(turns[a] * turns[b].T + turns[b] * turns[a].T) / 2 for a, b in _PAIRS]
    return tuple(sp.ImmutableMatrix(p.applyfunc(sp.expand)) for p in products)


def sphere_webs(sphere: Geometry, V: sp.Expr, x: Sequence[sp.Symbol], sign: Sign) -> list[Geometry]:
    """List the webs in which V separates after its radius is split off.

    Args:
        sphere: where the radius is split off; its family words are kept.
        V: potential in Cartesian coordinates x of equal mass.
        x: coordinates.
        sign: sign of a constant.

    Returns:
        Spherical and conical webs; the sphere itself (kind ``sphere``) where V on it does not separate.
    """
    moved = {q: q + c for q, c in zip(x, sphere.centre, strict=True) if c != 0}  # the origin becomes the centre
    about = flattened(V.subs(moved, simultaneous=True), x) if moved else V
    solutions = kernel(about, x, rotation_tensors(x), check=False)
    forms = [_form(v) for v in solutions.vectors]
    rows = sp.Matrix([[f[0, 0] - f[2, 2], f[1, 1] - f[2, 2], f[0, 1], f[0, 2], f[1, 2]] for f in forms])
    basis = [_unform(row) for row in rows.rref(simplify=True)[0].tolist() if any(row)]
    if not basis:
        return [sphere]
    webs = _conical(basis, sphere, sign) + _spherical(basis, sphere)
    return [_inherited(web, sphere) for web in webs]


def _inherited(web: Geometry, sphere: Geometry) -> Geometry:
    words = "; ".join(part for part in (sphere.family, web.family) if part)
    return replace(web, freedom=web.freedom + sphere.freedom, family=words)


def _form(vector: Sequence[sp.Expr]) -> sp.Matrix:
    form = sp.zeros(3, 3)
    for (a, b), c in zip(_PAIRS, vector, strict=True):
        form[a, b] += c / 2
        form[b, a] += c / 2
    return form


def _unform(row: Sequence[sp.Expr]) -> sp.Matrix:
    d, e, a, b, c = row
    return sp.Matrix([[d, a, b], [a, e, c], [b, c, 0]])


def _classified(form: sp.Matrix, sphere: Geometry, sign: Sign) -> Geometry | None:
    (low, e1), (middle, e2), (high, e3) = sort_frame(eigenframe(form), sign)
    equal = [tidy_constant(middle - low) == 0, tidy_constant(high - middle) == 0]
    if all(equal):
        return None
    if any(equal):
        return Geometry("spherical", sphere.centre, perpendicular_frame(e3 if equal[0] else e1))
    modulus = {"e1": sp.S.Zero, "e2": tidy_constant((middle - low) / (high - low)), "e3": sp.S.One}
    return Geometry("conical", sphere.centre, righted(e1, e2), (), modulus)


def _member(basis: Sequence[sp.Matrix], numbers: Sequence[sp.Expr], sphere: Geometry, sign: Sign) -> Geometry | None:
    form = sum((c * f for c, f in zip(numbers, basis, strict=True)), sp.zeros(3, 3))
    web = _classified(form, sphere, sign)
    return web if web is not None and web.kind == "conical" else None


def _conical(basis: Sequence[sp.Matrix], sphere: Geometry, sign: Sign) -> list[Geometry]:
    def member(values: tuple[sp.Expr, ...]) -> Geometry | None:
        return _member(basis, values, sphere, sign)

    best = representatives(member, len(basis), lambda g: g.kind, lambda g: g.complexity)
    return [in_words(best["conical"], len(basis) - 1, member)] if best else []


def _spherical(basis: Sequence[sp.Matrix], sphere: Geometry) -> list[Geometry]:
    """Find the members with two equal eigenvalues: the axes of spherical coordinates."""
    webs: list[Geometry] = []
    for piece in directions(basis):

        def member(values: tuple[sp.Expr, ...], piece: SolutionPiece = piece) -> Geometry | None:
            if piece.free[-1] == DIRECTION[2]:  # the z axis is the first that is tried
                values = (*values[1:], values[0])
            axis = direction(piece, values)
            return None if axis is None else Geometry("spherical", sphere.centre, perpendicular_frame(axis))

        best = representatives(member, len(piece.free), lambda _: "spherical", lambda web: web.complexity)
        webs += [in_words(found, len(piece.free) - 1, member) for found in best.values()]
    return webs
