"""From a web to the transformed system, certified by ``separate``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from random import Random

import sympy as sp

from hjsolve.algebra.time_limit import check_time, seconds_left
from hjsolve.coordinates.charts.charts import MERIDIAN, CoordinateRange, SeparableChart, chart
from hjsolve.coordinates.charts.covering import covering_chart
from hjsolve.coordinates.charts.simplify_potential import ChangeOfVariables
from hjsolve.coordinates.webs.expanded_potential import flattened
from hjsolve.coordinates.webs.orthonormal_frames import norm_squared, tidy_constant
from hjsolve.coordinates.webs.web import Geometry, Vector, Web
from hjsolve.mechanics.system import System
from hjsolve.separation import separate


@dataclass(frozen=True)
class Cartesian:
    """A natural system in Cartesian coordinates.

    Attributes:
        system: the system.
        mass: m of T = m/2 Σ Ẋ².
        x: symbols of the system's coordinates.
        stretch: x = stretch·X, a constant matrix; X are the coordinates of equal mass.
        X: symbols of the coordinates of equal mass (the same as x where the masses are equal).
        potential: V as a function of X.
        values: parameter → value used where a sign has to be known.
    """

    system: System
    mass: sp.Expr
    x: tuple[sp.Symbol, ...]
    stretch: sp.ImmutableMatrix
    X: tuple[sp.Symbol, ...]
    potential: sp.Expr
    values: Mapping[sp.Symbol, sp.Expr]


def chart_and_axes(
    geometry: Geometry | Web, cartesian: Cartesian, *, covering: bool
) -> tuple[SeparableChart, tuple[Vector, ...]]:
    """Return the local chart of a web, and the axes its X, Y, Z are counted along.

    Args:
        geometry: kind, centre, axes and constants of the web.
        cartesian: the system in Cartesian coordinates of equal mass.
        covering: the chart without ends (``covering``) instead of the usual one.
    """
    make = covering_chart if covering else chart
    n, symbol = len(cartesian.x), symbol_maker(cartesian)
    return _adapted(make(geometry.kind, geometry.lengths, n, symbol), geometry, cartesian)


def web_of(geometry: Geometry | Web, cartesian: Cartesian, *, budget: float | None, covering: bool = False) -> Web:
    """Build the transformed system of a web and let ``separate`` judge it.

    Args:
        geometry: kind, centre, axes and constants of the web.
        cartesian: the system in Cartesian coordinates of equal mass.
        budget: seconds for ``separate``; None where the verdict is another's to find (``restored``), and is None here.
        covering: in coordinates without ends (``covering``) instead of the usual ones.
    """
    n = len(cartesian.x)
    local, axes = chart_and_axes(geometry, cartesian, covering=covering)
    names = tuple(s.name for s in local.symbols)
    L = sp.symbols(f"X0:{n}", real=True)
    centre = geometry.centre
    moved = [
        sp.Add(c, *(tidy_constant(axis[i]) * Xi for axis, Xi in zip(axes, L, strict=True)))
        for i, c in enumerate(centre)
    ]
    in_frame = flattened(cartesian.potential.subs(dict(zip(cartesian.X, moved, strict=True)), simultaneous=True), L)
    carrier = ChangeOfVariables(dict(zip(L, local.place, strict=True)), domain_sign(local, cartesian), set())
    potential = carrier.carry(in_frame)
    speeds = [sp.Symbol(f"dot({name})", real=True) for name in names]
    kinetic = cartesian.mass / 2 * sp.Add(*(h * v**2 for h, v in zip(local.scale, speeds, strict=True)))
    check_time()
    ranges = [_range(s, where, potential) for s, where in zip(local.symbols, local.ranges, strict=True)]
    transformed = System(
        {name: where.text(name) for name, where in zip(names, ranges, strict=True)},
        kinetic,
        potential,
        {p.name: p for p in cartesian.system.parameters},
        title=f"{cartesian.system.title or 'system'} in {geometry.kind} coordinates",
    )
    own = {s: transformed.symbols[s.name] for s in local.symbols}
    placed = [c.xreplace(dict(zip(L, local.place, strict=True))).xreplace(own) for c in moved]
    old = cartesian.stretch * sp.Matrix(placed)
    transformation = {q.name: sp.expand(entry) for q, entry in zip(cartesian.system.coordinates, old, strict=True)}
    return Web(
        geometry.kind,
        geometry.centre,
        geometry.axes,
        geometry.foci,
        dict(geometry.lengths),
        geometry.freedom,
        geometry.family,
        names,
        transformation,
        transformed,
        None if budget is None else separate(transformed, budget=seconds_left(budget)),
        remark_of(geometry, local, carrier.assumed),
    )


def _range(symbol: sp.Symbol, where: CoordinateRange, potential: sp.Expr) -> CoordinateRange:
    """Return the range of a coordinate; half a turn of an angle that V contains, where acos(cos ν) stands for it."""
    if not where.periodic:
        return where
    circular = (sp.sin, sp.cos, sp.tan)
    rest = potential.replace(lambda e: isinstance(e, circular) and e.args[0] == symbol, lambda _: sp.S.One)
    return MERIDIAN if rest.has(symbol) else where


def _adapted(
    local: SeparableChart, geometry: Geometry | Web, cartesian: Cartesian
) -> tuple[SeparableChart, tuple[Vector, ...]]:
    """Return the chart and the axes to use.

    Cartesian axes keep the given names where nothing changes, and are not normalised where that would put symbolic
    square roots into the transformation.
    """
    n = len(cartesian.x)
    if geometry.kind != "cartesian":
        return local, geometry.axes
    if sp.Matrix(geometry.axes) == sp.eye(n):
        own = tuple(sp.Symbol(q.name, real=True) for q in cartesian.system.coordinates)
        return SeparableChart(own, local.ranges, own, local.scale), geometry.axes
    if not any(c.free_symbols for axis in geometry.axes for c in axis):
        return local, geometry.axes
    axes = []
    for axis in geometry.axes:
        lead = next(c for c in axis if c != 0)
        axes.append(tuple(sp.radsimp(sp.cancel(c / lead)) for c in axis))
    return replace(local, scale=tuple(sp.radsimp(sp.simplify(norm_squared(axis))) for axis in axes)), tuple(axes)


def symbol_maker(cartesian: Cartesian) -> Callable[[str, CoordinateRange], sp.Symbol]:
    """Return a maker of coordinate symbols; a name that is a parameter's gets a number."""
    taken = {p.name for p in cartesian.system.parameters}
    taken |= {name[2:] for name in taken if name.startswith("p_")}

    def symbol(name: str, where: CoordinateRange) -> sp.Symbol:
        free = name if name not in taken else next(f"{name}_{i}" for i in range(1, 99) if f"{name}_{i}" not in taken)
        if where.lower is not None and where.lower.is_nonnegative and not where.periodic:
            return sp.Symbol(free, real=True, positive=True)
        return sp.Symbol(free, real=True)

    return symbol


def domain_sign(local: SeparableChart, cartesian: Cartesian) -> Callable[[sp.Expr], int]:
    """Return the sign of an expression at random points of the domain; 0 where it changes or a parameter decides."""
    random = Random(11)  # noqa: S311
    points = [
        {
            **cartesian.values,
            **{
                s: _inside(where, cartesian.values, random)
                for s, where in zip(local.symbols, local.ranges, strict=True)
            },
        }
        for _ in range(6)
    ]

    def sign(expression: sp.Expr) -> int:
        if expression.is_positive or expression.is_negative:
            return 1 if expression.is_positive else -1
        if not expression.free_symbols & set(local.symbols):
            return 0
        check_time()
        values = [expression.xreplace(point).evalf(20) for point in points]
        if not all(v.is_real for v in values):
            return 0
        return 1 if all(v > 0 for v in values) else -1 if all(v < 0 for v in values) else 0

    return sign


def _inside(where: CoordinateRange, values: Mapping[sp.Symbol, sp.Expr], random: Random) -> sp.Expr:
    fraction = sp.Rational(random.randint(5, 95), 100)
    low, high = (None if end is None else end.xreplace(dict(values)) for end in (where.lower, where.upper))
    if low is not None and high is not None:
        return low + (high - low) * fraction
    return (
        4 * fraction - 2
        if low is None and high is None
        else low + 3 * fraction
        if high is None
        else high - 3 * fraction
    )


def remark_of(geometry: Geometry | Web, local: SeparableChart, assumed: Iterable[sp.Expr]) -> str:
    """Say what the chart covers and what was taken to be positive."""
    radicands = {
        p.base
        for v in (*geometry.foci, tuple(geometry.lengths.values()))
        for c in v
        for p in c.atoms(sp.Pow)
        if p.exp.is_Rational and not p.exp.is_Integer and p.base.free_symbols
    }
    order = sorted({*radicands, *assumed}, key=str)
    return "; ".join([local.remark] * bool(local.remark) + [f"for {e} > 0" for e in order if e.is_positive is None])
