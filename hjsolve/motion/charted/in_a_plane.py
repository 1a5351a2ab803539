"""Motions that stay on an axis or in a plane of the web, expressed without the coordinates across it.

On the axis of an elliptic or parabolic web both coordinates are at rest in turn, and at a focus one takes over from the
other: h² vanishes there, and the separated equations come to it only as τ → ∞. Where V is regular there nothing happens
to the body. With X_k = 0, P_k = 0 and ∂V/∂X_k = 0 for X_k = 0 it has a system of fewer coordinates,

    H = Σ P²/(2m) + V(X), X_k = 0,

of which the motion is one as well, and in which a focus is a place like others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.coordinates.webs.expanded_potential import flattened
from hjsolve.errors import HJSolveError
from hjsolve.mechanics.system import System
from hjsolve.motion.charted.charted_motion import ChartedMotion
from hjsolve.motion.charted.initial_map import BITS, Frame, point_in_frame, rational_of
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import read_phase_point
from hjsolve.separation import Zero, is_zero
from hjsolve.solution.quadratures import solve

_WITH_FOCI = ("elliptic", "parabolic", "prolate", "rotational parabolic", "ellipsoidal", "paraboloidal")
_SECONDS = 3.0
Start = Mapping[str, object]


@dataclass(frozen=True, eq=False, repr=False)
class MotionInPlane(ChartedMotion):
    """A motion on an axis or in a plane of the web: kinds, actions and frequencies are those of it there.

    Attributes:
        plane: how the coordinates along it, X, Y or Z of the web's frame, are tied to the user's.
    """

    plane: Chart = field(kw_only=True, repr=False)

    @property
    def chart(self) -> Chart:
        """How the coordinates along the axis or in the plane are tied to the user's."""
        return self.plane


def motion_in_a_plane(chart: Chart, given: Mapping[str, Start | None], **options: Any) -> MotionInPlane | None:
    """Start a motion that stays on an axis or in a plane of the web, in the coordinates along it alone.

    Args:
        chart: of the web.
        given: q, velocity, p and parameters as the user gave them.
        options: of ``Solution.motion``: t0, digits, certified, want.

    Returns:
        The motion; None where it leaves every axis and plane, or V is not smooth there.

    Raises:
        InvalidInputError: unknown or missing names.
        MissingValueError: a value is missing.
    """
    if not chart.kind.startswith(_WITH_FOCI):
        return None
    values = read_phase_point(chart.original, given["q"] or {}, given["velocity"], given["p"], given["parameters"])
    X, P = _exact_point(chart, values)
    # X_k = P_k = 0 across the plane; whether it stays 0 is asked of the force
    inside = [k for k in range(len(X)) if X[k] != 0 or P[k] != 0]
    # at rest in the centre: it stays on any axis along which the force vanishes across
    for kept in [inside] if inside else [[k] for k in range(len(X))]:
        plane = _plane(chart, tuple(kept)) if len(kept) < len(X) else None
        if plane is None:
            continue
        names = plane.coordinates
        q, p = (dict(zip(names, (row[k] for k in kept), strict=True)) for row in (X, P))
        try:
            within = solve(plane.system, "find").motion(q=q, p=p, parameters=given["parameters"], **options)
        except HJSolveError:
            continue
        return MotionInPlane.of(within, plane=plane)
    return None


def _exact_point(chart: Chart, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[list[sp.Rational], list[sp.Rational]]:
    """X and P in the frame of the web: exact where all is rational, else right to more digits than are asked for."""
    known = dict(values)
    frame, origin, place, momentum = (
        sp.Matrix(rows).xreplace(known) for rows in (chart.frame, chart.origin, chart.outer.place, chart.outer.momentum)
    )
    if all(e.is_Rational for e in (*frame, *origin, *place, *momentum)):
        return list(frame.inv() * (place - origin)), list(frame.T * momentum)

    def numbers(bits: int) -> Frame:
        return point_in_frame(chart, lambda e: to_bits(e.xreplace(dict(values)))(bits), Multi(bits).context)

    # a coordinate that is 0 but for rounding must be 0: two precisions tell
    far, near = numbers(BITS), numbers(BITS // 2)
    X = [rational_of(a, b) for a, b in zip(far[0], near[0], strict=True)]
    return X, [rational_of(a, b) for a, b in zip(far[1], near[1], strict=True)]


def _plane(chart: Chart, kept: tuple[int, ...]) -> Chart | None:
    """Return the system without the coordinates across an axis or plane; None where a body there would leave it."""
    original = chart.space
    taken = {p.name for p in original.parameters}
    L = [sp.Symbol(name if name not in taken else f"{name}_web", real=True) for name in "XYZ"[: chart.frame.cols]]
    place = sp.Matrix(chart.origin) + chart.frame * sp.Matrix(L)
    at = dict(zip((c.symbol for c in original.coordinates), place, strict=True))
    V = original.potential.subs(at, simultaneous=True)
    across = {s: sp.S.Zero for k, s in enumerate(L) if k not in kept}
    for s in across:
        # ∂V/∂X_k = 0 on the whole plane: else the motion leaves it
        force = sp.diff(V, s).subs(across)
        if force.has(sp.nan, sp.zoo, sp.oo) or not isinstance(is_zero(force, budget=_SECONDS), Zero):
            return None
    along = [L[k] for k in kept]
    speeds = [sp.Symbol(f"dot({s.name})", real=True) for s in along]
    try:
        system = System(
            {s.name: "line" for s in along}, chart.mass / 2 * sp.Add(*(v**2 for v in speeds)),
            flattened(V.subs(across), along), {p.name: p for p in original.parameters},
            title=f"{original.title or 'system'} on {', '.join(s.name for s in along)} of its {chart.kind} coordinates",
        )  # fmt: skip
        separation = solve(system, "find").separation
    except HJSolveError:
        return None
    own = tuple(c.symbol for c in system.coordinates)
    frame = sp.ImmutableMatrix(chart.frame[:, list(kept)])
    full = list(sp.Matrix(chart.origin) + frame * sp.Matrix(own))
    user = chart.outer.in_given_coordinates(full) if isinstance(chart.outer, CurvilinearMap) else full
    return Chart(
        chart.kind, tuple(c.name for c in system.coordinates),
        {c.name: e for c, e in zip(chart.original.coordinates, user, strict=True)}, chart.remark,
        f"{chart.reason}; the motion stays where {', '.join(f'{s.name} = 0' for s in across)} and passes a focus",
        chart.original, system, separation, chart.origin, frame, own, own, (sp.S.One,) * len(own), chart.mass, {},
        chart.outer,
    )  # fmt: skip
