"""Is the surface of a system a sphere, and where on it is a point? From T alone, by Gauss's theorema egregium.

T = ½ g(u̇, u̇) has constant curvature K > 0 if and only if it is that of a particle on a sphere, T = ½ ṅ·ṅ/K with |n| = 1
(Minding). n(u) is written down where g has a Killing vector along a coordinate, g = E(u) du² + G(u) dv²,

    n_z = G′/(2c √(EG)),   n_x + i n_y = √(KG)/c · exp(i c v),   c² = G′²/(4EG) + K G,

and where g is conformally flat with a quadratic factor, g = (dx² + dy²)/(K p²), p = a (x² + y²) + b x + c y + d
(stereographic coordinates). What is written down is proved: ṅ·ṅ/K = g.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice

import sympy as sp

from hjsolve.coordinates.webs.orthonormal_frames import Sign, tidy_constant
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.point_values import CONTEXT, NoValueError, evaluate
from hjsolve.mechanics.positive_definite import sample_points
from hjsolve.mechanics.system import System, mass_matrix
from hjsolve.separation.zero_test.zero_test import Zero, is_zero

NORMAL = sp.symbols("X Y Z", real=True)
"""n, the point on the unit sphere."""
_AGREE = CONTEXT.mpf(10) ** -60
_UNREAD = (
    "find_coordinates: T has the constant curvature {curvature}, so this is a sphere, but not in coordinates that are "
    "read here; give it as T = m/2 (dot(theta)**2 + sin(theta)**2*dot(phi)**2), or in stereographic coordinates"
)
_NEGATIVE = (
    "find_coordinates: T has the constant curvature {curvature} < 0, a hyperbolic plane; the plane, space and the "
    "sphere are supported"
)


@dataclass(frozen=True)
class Sphere:
    """A sphere that a system moves on.

    Attributes:
        system: of two coordinates.
        mass: m of T = m/2 ṅ·ṅ, with the square of the radius in it.
        normal: n(u), three functions of the system's coordinates.
        inverse: coordinate → function of ``NORMAL``.
    """

    system: System
    mass: sp.Expr
    normal: tuple[sp.Expr, ...]
    inverse: Mapping[sp.Symbol, sp.Expr]

    def carried(self, f: sp.Expr) -> sp.Expr | None:
        """Return a function of the coordinates as a function of ``NORMAL``; None where it is none of the sphere.

        Args:
            f: expression in the coordinates and parameters.
        """
        X, Y, Z = NORMAL
        moved = sp.expand_trig(f).subs(self.inverse, simultaneous=True)
        level = moved.replace(lambda e: e.is_Add and _same(e, 1 - Z**2), lambda _: X**2 + Y**2)
        level = min(level, _on_unit_sphere(level), key=sp.count_ops)
        back = dict(zip(NORMAL, self.normal, strict=True))
        return level if agree(level.subs(back, simultaneous=True), f, self.system) else None


def sphere_of(system: System, sign: Sign) -> Sphere | None:
    """Return the sphere that a system moves on; None where T has no constant curvature, or none but zero.

    Args:
        system: natural, of two coordinates.
        sign: sign of a constant.

    Raises:
        InvalidSystemError: the curvature is constant, but negative, or the coordinates are not read here.
    """
    u = tuple(q.symbol for q in system.coordinates)
    g = mass_matrix(system)
    if not g.free_symbols & set(u):
        return None
    raw = gaussian_curvature(g, u)
    if _varies(raw, system):
        return None
    curvature = sp.simplify(raw)
    if curvature.free_symbols & set(u) or curvature == 0:
        return None
    curvature = tidy_constant(curvature)
    if sign(curvature) < 0:
        raise InvalidSystemError(_NEGATIVE.format(curvature=curvature))
    unit = (curvature * g).applyfunc(sp.simplify)
    for read in (partial(_turned, one=0), partial(_turned, one=1), _stereographic):
        sphere = read(system, unit, tidy_constant(1 / curvature))
        if sphere is not None and _is_isometric(sphere, g):
            return sphere
    raise InvalidSystemError(_UNREAD.format(curvature=curvature))


def _varies(f: sp.Expr, system: System) -> bool:
    """Tell whether a function has two values at points with the same parameters; a quick look before a proof."""
    points = list(islice(sample_points(system.coordinates, system.parameters), 2))
    try:
        values = [evaluate(f, point) for point in points]
    except NoValueError:
        return False
    return any(abs(x - values[0]) > _AGREE * (1 + abs(x)) for x in values)


def gaussian_curvature(metric: sp.MatrixBase, u: tuple[sp.Symbol, ...]) -> sp.Expr:
    """Return K of E du² + 2F du dv + G dv² by Brioschi's formula.

    Args:
        metric: shape (2, 2).
        u: the two coordinates.
    """
    (x, y), (E, F, G) = u, (metric[0, 0], metric[0, 1], metric[1, 1])
    corner = -sp.diff(E, y, 2) / 2 + sp.diff(F, x, y) - sp.diff(G, x, 2) / 2
    first = sp.Matrix([
        [corner, sp.diff(E, x) / 2, sp.diff(F, x) - sp.diff(E, y) / 2],
        [sp.diff(F, y) - sp.diff(G, x) / 2, E, F],
        [sp.diff(G, y) / 2, F, G],
    ])  # fmt: skip
    e, g = sp.diff(E, y) / 2, sp.diff(G, x) / 2
    second = sp.Matrix([[0, e, g], [e, E, F], [g, F, G]])
    return (first.det() - second.det()) / (E * G - F**2) ** 2


def _turned(system: System, g: sp.MatrixBase, mass: sp.Expr, *, one: int) -> Sphere | None:
    """Return the sphere in coordinates with ``one`` along meridians, g = E(u) du² + G(u) dv² on the unit sphere."""
    u, v = (system.coordinates[k].symbol for k in (one, 1 - one))
    E, G = g[one, one], g[1 - one, 1 - one]
    if g[0, 1] != 0 or g.free_symbols & {v}:
        return None
    rate = sp.diff(G, u)
    c = tidy_constant(sp.sqrt(sp.simplify(rate**2 / (4 * E * G) + G)))
    if c.free_symbols & {u} or (system.coordinates[1 - one].domain.kind == "angle" and c != 1):
        return None
    ρ = _signed(sp.sqrt(G), system) / c
    Z = sp.simplify(_signed(rate / (2 * c * sp.sqrt(sp.simplify(E * G))), system))
    half = sp.sqrt(sp.simplify(1 - G / c**2))
    Z = next((z for z in (half, -half) if not half.has(sp.Abs) and agree(z, Z, system)), Z)
    inverse = _inverse(Z, u, system)
    if inverse is None:
        return None
    back = {u: inverse, v: sp.atan2(NORMAL[1], NORMAL[0]) / c}
    return Sphere(system, mass, (ρ * sp.cos(c * v), ρ * sp.sin(c * v), Z), back)


def _inverse(Z: sp.Expr, u: sp.Symbol, system: System) -> sp.Expr | None:
    """Solve Z(u) = n_z for u: the solution that is u on its domain."""
    w = sp.Dummy("w", real=True)
    solutions = {f(x) for f in (sp.acos, sp.asin, sp.atanh) for x in (w, -w)}
    with suppress(NotImplementedError):
        solutions |= {s for s in sp.solve(Z - w, u) if isinstance(s, sp.Expr)}
    for solution in sorted(solutions, key=lambda s: (sp.count_ops(s), str(s))):
        if agree(solution.subs(w, Z), u, system):
            return solution.subs(w, NORMAL[2])
    return None


def _stereographic(system: System, g: sp.MatrixBase, mass: sp.Expr) -> Sphere | None:
    """Return the sphere seen from its pole: g = 4 s² (dx² + dy²)/((1 + s² ((x − x₀)² + (y − y₀)²))²)."""
    x, y = (q.symbol for q in system.coordinates)
    if g[0, 1] != 0 or not _same(g[0, 0], g[1, 1]):
        return None
    p = sp.simplify(_signed(1 / sp.sqrt(sp.factor(g[0, 0])), system))
    if not p.is_polynomial(x, y):
        return None
    terms = sp.Poly(p, x, y)
    a = terms.coeff_monomial(x**2)
    if a == 0:
        return None
    s, x0, y0 = 2 * a, -terms.coeff_monomial(x) / (2 * a), -terms.coeff_monomial(y) / (2 * a)
    far = s**2 * ((x - x0) ** 2 + (y - y0) ** 2)
    normal = (2 * s * (x - x0) / (1 + far), 2 * s * (y - y0) / (1 + far), (1 - far) / (1 + far))
    X, Y, Z = NORMAL
    inverse = {x: x0 + X / (s * (1 + Z)), y: y0 + Y / (s * (1 + Z))}
    return Sphere(system, mass, normal, inverse)


def _on_unit_sphere(f: sp.Expr) -> sp.Expr:
    """Write a rational function of n without squares of n_y; anything else stays."""
    X, Y, Z = NORMAL
    if not f.is_rational_function(*NORMAL):
        return f
    top, bottom = (sp.rem(e, X**2 + Y**2 + Z**2 - 1, Y) for e in sp.fraction(sp.together(f)))
    return sp.cancel(top / bottom)


def _is_isometric(sphere: Sphere, g: sp.MatrixBase) -> bool:
    """Prove m ∂n/∂u_i·∂n/∂u_j = g_ij."""
    J = sp.Matrix(sphere.normal).jacobian([q.symbol for q in sphere.system.coordinates])
    left = sphere.mass * J.T * J - g
    return all(sp.simplify(e) == 0 or isinstance(is_zero(sp.simplify(e)), Zero) for e in left)


def _signed(f: sp.Expr, system: System) -> sp.Expr:
    """Write |a| as ±a with the sign it has on the domain."""

    def sign(a: sp.Expr) -> int:
        signs = {1 if evaluate(a, point) > 0 else -1 for point in sample_points(system.coordinates, system.parameters)}
        return signs.pop() if len(signs) == 1 else 0

    return f.replace(sp.Abs, lambda a: a * sign(a) or sp.Abs(a, evaluate=False))


def agree(f: sp.Expr, other: sp.Expr, system: System) -> bool:
    """Tell whether two functions agree wherever the second has a value, at points spread over the domain.

    Args:
        f: real, of the coordinates and parameters of the system.
        other: of the formula language.
        system: whose domain is meant.
    """
    for point in sample_points(system.coordinates, system.parameters):
        try:
            value = evaluate(other, point)
        except NoValueError:
            continue
        found = f.xreplace({s: sp.Rational(str(x)) for s, x in point.items()}).evalf(70)
        if not found.is_real or abs(CONTEXT.mpf(str(found)) - value) > _AGREE * (1 + abs(value)):
            return False
    return True


def _same(a: sp.Expr, b: sp.Expr) -> bool:
    return bool(sp.expand(a - b) == 0)
