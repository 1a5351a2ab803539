"""Where a motion happens in space: read off the kinetic energy, or as ``System.place`` says; else the coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
import sympy as sp

from hjsolve.mechanics.system import Coordinate, System, mass_matrix
from hjsolve.motion.state import State
from hjsolve.reports.drawings.effective_potential import Array

Shape = Literal["line", "plane", "space", "sphere", "coordinates"]


@dataclass(frozen=True)
class Embedding:
    """How coordinates become places.

    Attributes:
        shape: ``line`` (one coordinate against time), ``plane``, ``space``, ``sphere`` (directions), or
            ``coordinates``.
        kind: ``cartesian``, ``polar``, ``spherical``, ``parabolic``, ``colatitude``, ``elevation``, ``place`` (as the
            system says) or empty.
        names: the coordinates used, in the order the kind wants.
        axes: names of the axes of the drawing.
        up: +1, or −1 where a polar angle is counted from the lowest point.
    """

    shape: Shape
    kind: str
    names: tuple[str, ...]
    axes: tuple[str, ...]
    up: int = 1


@lru_cache(maxsize=64)
def embedding(system: System) -> Embedding:
    """Recognise where a system lives.

    Returns:
        The embedding; ``coordinates`` where T is none of the familiar forms.
    """
    names = tuple(c.name for c in system.coordinates)
    if len(names) == 1:
        return Embedding("line", "", names, ("t", names[0]))
    M = mass_matrix(system)
    found = _sphere(system, M) or _flat(system, M)
    if found is not None and _agrees(found, system):
        return found
    axes = tuple(system.place)
    if len(axes) > 1:
        return Embedding("plane" if len(axes) == 2 else "space", "place", names, axes)
    return found or Embedding("coordinates", "", names[:2], names[:2])


def _agrees(found: Embedding, system: System) -> bool:
    """Return whether the usual place of such coordinates is the one that the system says, if it says one."""
    if not system.places or found.shape == "sphere":
        return True
    return usual_place(found, system) == tuple(formula for _, formula in system.places)


def usual_place(where: Embedding, system: System) -> tuple[sp.Expr, ...]:
    """Return the place of a system's point, one formula in its coordinates for each axis."""
    q = [system.coordinate(name).symbol for name in where.names]
    match where.kind:
        case "place":
            return tuple(formula for _, formula in system.places)
        case "colatitude":
            return sp.sin(q[0]) * sp.cos(q[1]), sp.sin(q[0]) * sp.sin(q[1]), where.up * sp.cos(q[0])
        case "elevation":
            return sp.cos(q[0]) * sp.cos(q[1]), sp.cos(q[0]) * sp.sin(q[1]), where.up * sp.sin(q[0])
        case "polar":
            return q[0] * sp.cos(q[1]), q[0] * sp.sin(q[1])
        case "parabolic":
            return q[0] ** 2 / 2 - q[1] ** 2 / 2, q[0] * q[1]
        case "spherical":
            ρ = q[0] * sp.sin(q[1])
            return ρ * sp.cos(q[2]), ρ * sp.sin(q[2]), q[0] * sp.cos(q[1])
        case _:
            return tuple(q)


def _diagonal(M: sp.Matrix) -> list[sp.Expr] | None:
    return [sp.expand(M[i, i]) for i in range(M.rows)] if M.is_diagonal() else None


def _same(a: sp.Expr, b: sp.Expr) -> bool:
    return bool(sp.expand(a - b) == 0)


def _flat(system: System, M: sp.Matrix) -> Embedding | None:
    diagonal, q = _diagonal(M), [c.symbol for c in system.coordinates]
    names = tuple(c.name for c in system.coordinates)
    if diagonal is None:
        return None
    scale, angles = diagonal[0], [c.domain.kind == "angle" for c in system.coordinates]
    if not any(angles) and all(not d.has(*q) and _same(d, scale) for d in diagonal):
        return Embedding("plane", "cartesian", names, names) if len(q) == 2 else None
    if not scale.has(*q) and _same(diagonal[1], scale * q[0] ** 2):
        if len(q) == 2 and angles == [False, True]:
            return Embedding("plane", "polar", names, ("x", "y"))
        if len(q) == 3 and _same(diagonal[2], scale * q[0] ** 2 * sp.sin(q[1]) ** 2):
            return Embedding("space", "spherical", names, ("x", "y", "z"))
    stretch = sp.cancel(scale / (q[0] ** 2 + q[1] ** 2))
    if len(q) == 2 and not stretch.has(*q) and _same(diagonal[1], scale):
        return Embedding("plane", "parabolic", names, ("x", "y"))
    return None


def _sphere(system: System, M: sp.Matrix) -> Embedding | None:
    """Return a polar angle or elevation θ and an azimuth φ whose inertia has I sin²θ or I cos²θ in it.

    Pendulum and top.
    """
    for i, polar in enumerate(system.coordinates):
        domain, inertia = polar.domain, M[i, i]
        if domain.kind != "interval" or domain.upper is None or inertia.has(*(c.symbol for c in system.coordinates)):
            continue
        kind = {(sp.S.Zero, sp.pi): "colatitude", (-sp.pi / 2, sp.pi / 2): "elevation"}.get(
            (domain.lower, domain.upper)
        )
        for j, azimuth in enumerate(system.coordinates):
            if kind is None or azimuth.domain.kind != "angle":
                continue
            whole = sp.expand(M[j, j])
            rest = sp.expand(whole - inertia * (sp.sin if kind == "colatitude" else sp.cos)(polar.symbol) ** 2)
            if len(sp.Add.make_args(rest)) < len(sp.Add.make_args(whole)) or rest == 0:
                up = _up(system, polar)
                return Embedding("sphere", kind, (polar.name, azimuth.name), ("x", "y", "z"), up)
    return None


def _up(system: System, polar: Coordinate) -> int:
    """+1 where the potential says that z points up, −1 where θ is counted from the lowest point."""
    rise = sp.diff(system.potential, polar.symbol).subs({s: v for s, v in system.defaults.items() if v is not None})
    slope = rise.subs(polar.symbol, 0 if polar.domain.lower != 0 else sp.pi / 2)
    outward = 1 if polar.domain.lower == 0 else -1
    return 1 if slope == 0 else -outward if slope.is_positive else outward


def place(where: Embedding, q: Mapping[str, Array]) -> tuple[Array, ...]:
    """Turn coordinates into Cartesian places.

    Args:
        q: coordinate → values, shape (n,).

    Returns:
        One array of shape (n,) for each axis.
    """
    values = [np.asarray(q[name], float) for name in where.names]
    match where.kind:
        case "polar":
            r, θ = values
            return r * np.cos(θ), r * np.sin(θ)
        case "parabolic":
            u, v = values
            return (u**2 - v**2) / 2, u * v
        case "spherical":
            r, θ, φ = values
            return r * np.sin(θ) * np.cos(φ), r * np.sin(θ) * np.sin(φ), r * np.cos(θ)
        case "colatitude":
            θ, φ = values
            return np.sin(θ) * np.cos(φ), np.sin(θ) * np.sin(φ), where.up * np.cos(θ)
        case "elevation":
            θ, φ = values
            return np.cos(θ) * np.cos(φ), np.cos(θ) * np.sin(φ), where.up * np.sin(θ)
        case _:
            return tuple(values)


def path_of(where: Embedding, state: State) -> tuple[Array, ...]:
    """Return the places of a state.

    Args:
        state: at n times.

    Returns:
        One array of shape (n,) for each axis.
    """
    if where.kind == "place":
        there = state.place
        return tuple(np.asarray(there[axis], float) for axis in where.axes)
    return place(where, {name: np.asarray(state.unwrapped(name), float) for name in where.names})


def projected(
    x: Array, y: Array, z: Array, *, azimuth: float = -0.9, elevation: float = 0.42
) -> tuple[Array, Array, Array]:
    """Look at places in space from a direction, without perspective.

    Args:
        x: first coordinates, shape (n,).
        y: second ones.
        z: upward ones.
        azimuth: angle of the viewer around the z axis, radians.
        elevation: angle of the viewer above the plane, radians.

    Returns:
        (right, up, towards the viewer), each of shape (n,).
    """
    across = -x * np.sin(azimuth) + y * np.cos(azimuth)
    forward = x * np.cos(azimuth) + y * np.sin(azimuth)
    up = z * np.cos(elevation) - forward * np.sin(elevation)
    return across, up, forward * np.cos(elevation) + z * np.sin(elevation)
