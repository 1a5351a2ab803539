"""The eleven webs of Euclidean space by the algorithm of Benenti, Eisenhart, Kalnins and Miller.

After Rajaratnam and McLenaghan (arXiv 1404.2565; with Valero, SIGMA 12 (2016) 117): take the concircular tensors
L = A + w⊙x + m x⊗x with d((tr L g − L) dV) = 0.

- Central (m = 1, centre −w), N = A − w⊗w: three different eigenvalues of N make an ellipsoidal web; two equal ones a
  spheroidal web, prolate where the odd one is the smaller; N = multiple of 1 splits off the radius: V is restricted to
  the sphere and its separable webs there are sought among K = Σ c_ij L_i L_j (spherical, conical).
- Axial (m = 0, w ≠ 0): A restricted to the plane perpendicular to w has different eigenvalues, paraboloidal, or equal
  ones, rotational parabolic.
- Constant: three different eigenvalues, Cartesian; two equal ones split off a direction: V is restricted to the plane
  perpendicular to it and the plane webs of the restriction give cylinders.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.coordinates.webs.concircular_families import Family, combination, representatives, tensor_parts
from hjsolve.coordinates.webs.cylinders import cylinder_webs
from hjsolve.coordinates.webs.describe import in_words
from hjsolve.coordinates.webs.orthonormal_frames import (
    Sign,
    attempt,
    eigenframe,
    norm_squared,
    perpendicular_frame,
    real_root,
    righted,
    sort_frame,
    stepped,
    tidy_constant,
    unit,
)
from hjsolve.coordinates.webs.piecewise_conditions import SolutionPiece, real_pieces
from hjsolve.coordinates.webs.rank_one import V, annihilators, trace_product
from hjsolve.coordinates.webs.spheres import sphere_webs
from hjsolve.coordinates.webs.web import Geometry, Vector

_ZERO = sp.S.Zero
_STANDARD: tuple[Vector, ...] = tuple(tuple(sp.Integer(int(i == j)) for j in range(3)) for i in range(3))


@dataclass(frozen=True)
class Potential:
    """V(x) in Cartesian coordinates of equal mass, and how to tell the sign of its constants."""

    V: sp.Expr
    x: tuple[sp.Symbol, ...]
    sign: Sign


def _ellipsoid(A: sp.MatrixBase, w: sp.MatrixBase, sign: Sign) -> Geometry | None:
    """L = A + w⊙x + x⊗x: centre −w, axes and constants from the eigenvalues of A − w⊗w; None where two are equal."""
    (low, e1), (middle, e2), (high, _) = sort_frame(eigenframe(A - w * w.T), sign)
    first, second = tidy_constant(middle - low), tidy_constant(high - middle)
    if first == 0 or second == 0:
        return None
    scale, (a2, a3) = _scaled(first, tidy_constant(high - low))
    constants = {"a": real_root(scale), "a1": _ZERO, "a2": a2, "a3": a3}
    return Geometry("ellipsoidal", tuple(tidy_constant(-c) for c in w), righted(e1, e2), (), constants)


def _scaled(*constants: sp.Expr) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """Take a common irrational factor out of some constants, so that the ends of the coordinates are rational."""
    largest = constants[-1]
    ratios = tuple(tidy_constant(c / largest) for c in constants)
    if largest.is_number and not largest.is_Rational and all(r.is_Rational for r in ratios):
        return largest, ratios
    return sp.S.One, constants


def _axial(A: sp.MatrixBase, w: sp.MatrixBase, sign: Sign) -> Geometry:
    """L = A + w⊙x; in the frame (e₁, e₂, d = w/|w|) a shift removes A d, what is left is A on the plane ⟂ d."""
    length = tidy_constant(sp.sqrt(sp.Add(*(c**2 for c in w))))
    d = tuple(tidy_constant(c / length) for c in w)
    A = (A / length).applyfunc(tidy_constant)
    e1, e2, _ = perpendicular_frame(d)
    frame = sp.Matrix([e1, e2]).T
    restricted = (frame.T * A * frame).applyfunc(tidy_constant)
    (low, f1), (high, f2) = sort_frame(eigenframe(restricted), sign)
    axes = [tuple(tidy_constant(c) for c in frame * sp.Matrix(f)) for f in (f1, f2)]
    # with A shifted so that its lower eigenvalue on the plane is 0: A + w⊙x = (x − f) ⊙ d + (high − low) e₂⊗e₂
    shifted = A - low * sp.eye(3)
    push = [-tidy_constant((sp.Matrix(e).T * shifted * sp.Matrix(d))[0]) for e in axes]
    along = -tidy_constant((sp.Matrix(d).T * shifted * sp.Matrix(d))[0]) / 2
    focus = stepped((_ZERO,) * 3, [(push[0], axes[0]), (push[1], axes[1]), (along, d)])
    gap = tidy_constant(high - low)
    if gap == 0:
        return Geometry("rotational parabolic", focus, perpendicular_frame(d), (focus,))
    return Geometry(
        "paraboloidal",
        focus,
        righted(d, axes[0]),
        (focus, stepped(focus, [(gap / 2, d)])),
        dict(zip(("a", "b", "c"), (_scaled(gap)[0], _ZERO, *_scaled(gap)[1]), strict=True)),
    )


def space_webs(family: Family, potential: Potential) -> list[Geometry]:
    """List the webs of a linear family of concircular tensors, one representative for every kind and component.

    Args:
        family: of concircular tensors in space.
        potential: V(x), and how to tell signs.
    """
    terms = (*family.axial, *family.constant)
    webs = attempt(lambda: cylinder_webs(family.constant, potential.V, potential.x, potential.sign))
    if family.axial:
        webs += attempt(lambda: _paraboloids(terms, potential)) + attempt(lambda: _rotational(terms, potential))
    if family.central is not None:
        webs += attempt(lambda: _from_spheres(family, potential))
        for kind in ("prolate spheroidal", "oblate spheroidal"):
            webs += attempt(lambda kind=kind: _spheroids(family, kind, potential.sign))  # type: ignore[misc]
        webs += attempt(lambda: _ellipsoids(family, terms, potential))
    return webs


def _paraboloids(terms: Sequence[sp.MatrixBase], potential: Potential) -> list[Geometry]:
    def paraboloid(values: tuple[sp.Expr, ...]) -> Geometry | None:
        return _axial_member(terms, values, potential, "paraboloidal")

    arbitrary = tuple(sp.Rational(2 * i * i + 1, 3 + i) for i in range(len(terms)))
    return _sampled(paraboloid, len(terms), len(terms) - 1) if paraboloid(arbitrary) is not None else []


def _axial_member(
    terms: Sequence[sp.MatrixBase], numbers: Sequence[sp.Expr], potential: Potential, kind: str
) -> Geometry | None:
    A, w, _ = tensor_parts(combination(None, terms, numbers, 3))
    web = _axial(A, w, potential.sign) if any(c != 0 for c in w) else None
    return web if web is not None and web.kind == kind else None


def _from_spheres(family: Family, potential: Potential) -> list[Geometry]:
    return [w for sphere in _spheres(family) for w in sphere_webs(sphere, potential.V, potential.x, potential.sign)]


def _ellipsoids(family: Family, terms: Sequence[sp.MatrixBase], potential: Potential) -> list[Geometry]:
    def ellipsoid(values: tuple[sp.Expr, ...]) -> Geometry | None:
        M = combination(family.central, terms, values, 3)
        A, w, _ = tensor_parts(M)
        return _ellipsoid(A, w, potential.sign) if _simple_spectrum(M) else None

    arbitrary = tuple(sp.Rational(3 * i * i + 2, 5 + i) for i in range(len(terms)))
    if not _simple_spectrum(combination(family.central, terms, arbitrary, 3)):
        return []
    return [_with_foci(web) for web in _sampled(ellipsoid, len(terms), len(terms))]


def _simple_spectrum(M: sp.MatrixBase) -> bool:
    """Tell whether N = A − w⊗w of a central tensor has three different eigenvalues."""
    A, w, m = tensor_parts(M)
    s = sp.Symbol("s")
    return bool(sp.simplify(sp.discriminant((A / m - w * w.T / m**2).charpoly(s).as_expr(s), s)) != 0)


def _split_parts(family: Family) -> tuple[tuple[sp.Symbol, ...], sp.Matrix, sp.Matrix, list[sp.Matrix]]:
    """Return the parameters s of w, w(s), A(s) − w(s)⊗w(s) and the functionals that do not see the constant tensors."""
    s = sp.symbols(f"s0:{len(family.axial)}", real=True)
    A, w, _ = tensor_parts(combination(family.central, family.axial, s, 3))
    return s, w, A - w * w.T, annihilators([sp.Matrix(M[:3, :3]) for M in family.constant])


def _spheres(family: Family) -> list[Geometry]:
    """Find the centres about which V splits off the radius: A − w⊗w is constant up to constant tensors."""
    s, w, N, functionals = _split_parts(family)
    webs: list[Geometry] = []
    for piece in real_pieces([trace_product(φ, N) for φ in functionals], s):

        def member(values: tuple[sp.Expr, ...], piece: SolutionPiece = piece) -> Geometry | None:
            centre = _at(-w, piece, values)
            return None if centre is None else Geometry("sphere", centre, _STANDARD)

        webs += _sampled(member, len(piece.free), len(piece.free))
    return webs


def _spheroids(family: Family, kind: str, sign: Sign) -> list[Geometry]:
    """Solve A − w⊗w + constant tensors = λ ∓ v⊗v: axis v, focal distance |v|, prolate for the upper sign.

    Where letters decide whether v is real (a² − c² of Kuzmin and Kutuzov's galaxy), their values do.
    """
    s, w, N, functionals = _split_parts(family)
    v = sp.Matrix(V)
    odd = v * v.T * (-1 if kind.startswith("prolate") else 1)
    webs: list[Geometry] = []
    for piece in real_pieces([trace_product(φ, N - odd) for φ in functionals], (*s, *V)):

        def member(values: tuple[sp.Expr, ...], piece: SolutionPiece = piece) -> Geometry | None:
            centre, axis = _at(-w, piece, values), _at(v, piece, values)
            if centre is None or axis is None or sign(norm_squared(axis)) <= 0:
                return None
            return _spheroid(kind, centre, axis)

        found = _sampled(member, len(piece.free), len(piece.free))
        webs += [web for web in found if (web.freedom, web.family) not in {(o.freedom, o.family) for o in webs}]
    return webs


def _spheroid(kind: str, centre: Vector, axis: Vector) -> Geometry:
    a = tidy_constant(sp.sqrt(sp.Add(*(c**2 for c in axis)))).replace(sp.Abs, lambda u: u)
    ends = (stepped(centre, [(sp.S.One, axis)]), stepped(centre, [(-sp.S.One, axis)]))
    foci = ends if kind.startswith("prolate") else ()
    return Geometry(kind, centre, perpendicular_frame(unit(axis)), foci, {"a": a})


def _at(vector: sp.MatrixBase, piece: SolutionPiece, values: Sequence[sp.Expr]) -> Vector | None:
    place = dict(zip(piece.free, values, strict=True))
    numbers = tuple(tidy_constant(c.subs(piece.values, simultaneous=True).subs(place)) for c in vector)
    return None if any(n.has(sp.zoo, sp.nan, sp.oo) for n in numbers) else numbers


def _with_foci(web: Geometry) -> Geometry:
    """Add the ends of the focal conics: on e₁ at a√(a₂−a₁) and a√(a₃−a₁), on e₂ at a√(a₃−a₂)."""
    a, a2, a3 = (web.lengths[name] for name in ("a", "a2", "a3"))
    ends = (
        (a * real_root(a2), web.axes[0]),
        (a * real_root(a3), web.axes[0]),
        (a * real_root(tidy_constant(a3 - a2)), web.axes[1]),
    )
    return replace(web, foci=tuple(stepped(web.centre, [(s * k, e)]) for k, e in ends for s in (1, -1)))


def _sampled(member: Callable[[tuple[sp.Expr, ...]], Geometry | None], count: int, freedom: int) -> list[Geometry]:
    """Return the simplest member of a family of one kind."""
    if freedom == 0:
        only = member(tuple(sp.S.One for _ in range(count)))
        return [] if only is None else [only]
    best = representatives(member, count, lambda g: g.kind, lambda g: g.complexity)
    return [in_words(found, freedom, member) for found in best.values()]


def _rotational(terms: Sequence[sp.MatrixBase], potential: Potential) -> list[Geometry]:
    """Find the axial tensors whose A is a multiple of 1 on the plane perpendicular to w."""
    t = sp.symbols(f"t0:{len(terms)}", real=True)
    shift = sp.Symbol("lambda_", real=True)
    A, w, _ = tensor_parts(combination(None, terms, t, 3))
    cross = sp.Matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    seen = cross.T * (A - shift * sp.eye(3)) * cross
    webs: list[Geometry] = []
    for piece in real_pieces([seen[i, j] for i in range(3) for j in range(i, 3)], (shift, *t)):
        if all(sp.expand(c.subs(piece.values)) == 0 for c in w):
            continue

        def member(values: tuple[sp.Expr, ...], piece: SolutionPiece = piece) -> Geometry | None:
            numbers = _at(sp.Matrix(t), piece, values)
            return None if numbers is None else _axial_member(terms, numbers, potential, "rotational parabolic")

        webs += _sampled(member, len(piece.free), len(piece.free) - 1)
    return webs
