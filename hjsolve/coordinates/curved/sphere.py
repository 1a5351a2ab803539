"""All separable coordinates on a sphere: spherical about some axis, and sphero-conal (elliptic) coordinates.

A potential V(n) of the sphere becomes V(x/|x|)/|x|² in space. For K = Σ c_ab L_a ⊙ L_b, L = x × p, the one-form K·dV of
that potential is the one on the unit sphere, drawn back to space: d(K·dV) = 0 is the same equation, and the spherical
factor of the webs of space (``webs.spheres``) answers it (Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117, §6).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.algebra.time_limit import seconds_left
from hjsolve.coordinates.charts.charts import SeparableChart, chart
from hjsolve.coordinates.charts.covering import covering_chart
from hjsolve.coordinates.charts.simplify_potential import ChangeOfVariables
from hjsolve.coordinates.charts.transform import Cartesian, domain_sign, remark_of, symbol_maker
from hjsolve.coordinates.curved.embedding import NORMAL, Sphere, agree
from hjsolve.coordinates.killing.killing_tensors import Kernel, kernel
from hjsolve.coordinates.webs.expanded_potential import flattened
from hjsolve.coordinates.webs.orthonormal_frames import Sign
from hjsolve.coordinates.webs.spheres import rotation_tensors, sphere_webs
from hjsolve.coordinates.webs.web import Geometry, Web
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.system import System, placed
from hjsolve.separation import separate

_CENTRE = (sp.S.Zero,) * 3
_AXES = tuple(tuple(sp.Integer(int(i == j)) for j in range(3)) for i in range(3))
_NO_FUNCTION = (
    "find_coordinates: T is that of a sphere, but V could not be written as a function on the sphere, the same in all "
    "of the coordinates' domain"
)


@dataclass(frozen=True)
class OnSphere:
    """A system on a sphere, and its potential in space.

    Attributes:
        sphere: where it moves.
        potential: V as a function of ``NORMAL``.
        space: the homogeneous potential V(x/|x|)/|x|² of space, with the parameters of the system.
    """

    sphere: Sphere
    potential: sp.Expr
    space: Cartesian


def on_sphere(sphere: Sphere, values: Mapping[sp.Symbol, sp.Expr]) -> OnSphere:
    """Write the potential of a system in space.

    Args:
        sphere: that it moves on.
        values: parameter → value used where a sign has to be known.

    Raises:
        InvalidSystemError: V is not a function on the sphere.
    """
    V = sphere.carried(sphere.system.potential)
    if V is None:
        raise InvalidSystemError(_NO_FUNCTION)
    square = sp.Add(*(x**2 for x in NORMAL))
    homogeneous = V.subs({x: x / sp.sqrt(square) for x in NORMAL}, simultaneous=True) / square
    unit = sp.ImmutableMatrix(sp.eye(3))
    return OnSphere(
        sphere, V, Cartesian(sphere.system, sphere.mass, NORMAL, unit, NORMAL, sp.powdenest(homogeneous), values)
    )


def sphere_kernel(given: OnSphere) -> tuple[Kernel, tuple[sp.ImmutableMatrix, ...]]:
    """Return the Killing tensors of the sphere with d(K·dV) = 0, in the basis L_a ⊙ L_b that is returned too."""
    basis = rotation_tensors(NORMAL)
    return kernel(given.space.potential, NORMAL, basis), basis


def webs_on_sphere(given: OnSphere, *, budget: float) -> tuple[list[Geometry], tuple[Web, ...]]:
    """Return what webs there are on the sphere, and each with its system.

    Args:
        budget: seconds that ``separate`` may take for one web.
    """
    whole = Geometry("sphere", _CENTRE, _AXES)
    geometries = sphere_webs(whole, given.space.potential, NORMAL, Sign(given.space.values))
    return geometries, tuple(_web(g, given, budget) for g in geometries if g.kind != "sphere")


def _web(geometry: Geometry, given: OnSphere, budget: float) -> Web:
    """Return the web in coordinates of the whole sphere, or where these do not do, of one octant."""
    webs = [web for local in charts_on_sphere(geometry, given) if (web := _transformed(geometry, local, given, budget))]
    return next((web for web in webs if web.certified), webs[-1])


def charts_on_sphere(geometry: Geometry | Web, given: OnSphere) -> Iterator[SeparableChart]:
    """Yield the charts of a web on the unit sphere, that of the whole sphere first.

    Args:
        geometry: kind and constants of the web.
    """
    symbol = symbol_maker(given.space)
    for make in (covering_chart, chart) if geometry.kind == "conical" else (chart,):
        local = make(geometry.kind, geometry.lengths, 3, symbol)
        unit = {local.symbols[0]: sp.S.One}
        yield replace(
            local, symbols=local.symbols[1:], ranges=local.ranges[1:],
            place=tuple(x.subs(unit) for x in local.place), scale=tuple(h.subs(unit) for h in local.scale[1:]),
        )  # fmt: skip


def _transformed(geometry: Geometry, local: SeparableChart, given: OnSphere, budget: float) -> Web | None:
    """Return the transformed system; None where its V is not the given one everywhere."""
    space, sphere, names = given.space, given.sphere, tuple(s.name for s in local.symbols)
    L = sp.symbols("X0:3", real=True)
    moved = [sp.Add(*(axis[i] * Xi for axis, Xi in zip(geometry.axes, L, strict=True))) for i in range(3)]
    turned = given.potential.subs(dict(zip(NORMAL, moved, strict=True)), simultaneous=True)
    carrier = ChangeOfVariables(dict(zip(L, local.place, strict=True)), domain_sign(local, space), set())
    potential = carrier.carry(flattened(turned, L))
    speeds = [sp.Symbol(f"dot({name})", real=True) for name in names]
    kinetic = space.mass / 2 * sp.Add(*(h * v**2 for h, v in zip(local.scale, speeds, strict=True)))
    system = System(
        {name: where.text(name) for name, where in zip(names, local.ranges, strict=True)},
        kinetic,
        potential,
        {p.name: p for p in sphere.system.parameters},
        title=f"{sphere.system.title or 'system'} in {geometry.kind} coordinates",
    )
    own = {s: system.symbols[s.name] for s in local.symbols}
    at = dict(zip(L, (x.xreplace(own) for x in local.place), strict=True))
    normal = dict(zip(NORMAL, (x.xreplace(at) for x in moved), strict=True))
    if not agree(given.potential.subs(normal, simultaneous=True), system.potential, system):
        return None
    system = placed(system, tuple(zip("xyz", normal.values(), strict=True)))
    return Web(
        geometry.kind, geometry.centre, geometry.axes, geometry.foci, dict(geometry.lengths), geometry.freedom,
        geometry.family, names,
        {u.name: e.subs(normal, simultaneous=True) for u, e in sphere.inverse.items()}, system,
        separate(system, budget=seconds_left(budget)), _remark(geometry, local, carrier, sphere),
    )  # fmt: skip


def _remark(geometry: Geometry, local: SeparableChart, carrier: ChangeOfVariables, sphere: Sphere) -> str:
    axes = ", ".join(f"{name} = {x}" for name, x in zip("xyz", sphere.normal, strict=True))
    return "; ".join(part for part in (f"axes in {axes}", remark_of(geometry, local, carrier.assumed)) if part)
