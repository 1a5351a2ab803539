"""The simplest coordinates in which a system separates, and how they are found.

    x = origin + frame · X(u),     T = m/2 Σ h_k²(u) u̇_k²

as in ``chart``.

``simplify_potential`` writes √sinh²μ as sinh μ and acos(cos ν) as ν, which is right for μ > 0 and 0 < ν < π. Whether it
is on the other sides too (a root or a logarithm has one sign on each) is looked up at a point of each: it is, where V
is analytic through the plane between them; or V has a crease there, and the coordinates end at it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import product

import sympy as sp

from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.time_limit import SearchTimeError, seconds_left, within_seconds
from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.curvilinear import curvilinear_map
from hjsolve.coordinates.charts.outer_map import OuterMap, flat_map, sphere_map
from hjsolve.coordinates.charts.transform import Cartesian, chart_and_axes, web_of
from hjsolve.coordinates.curved.sphere import OnSphere, charts_on_sphere
from hjsolve.coordinates.find import cartesian_form, find_coordinates, sphere_below
from hjsolve.coordinates.gauge import field_in, find_gauge
from hjsolve.coordinates.results import SeparableCoordinates, Web
from hjsolve.coordinates.small_oscillations import normal_modes
from hjsolve.coordinates.superintegrable import independent_integrals, modes_in_words, webs_in_words
from hjsolve.errors import InvalidSystemError, NotSeparableError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.system import Coordinate, System, linear_terms, placed
from hjsolve.separation import Separation, separate
from hjsolve.separation.obstruction.advice import small_oscillations

_DIGITS = 30
_OFFSETS = (sp.Rational(37, 101), sp.Rational(53, 97), sp.Rational(41, 89))
"""Where in its range each coordinate is looked at."""
_PAIRED = ("elliptic", "elliptic cylinder", "parabolic", "parabolic cylinder", "oblate spheroidal")
"""Kinds in which (u, v) and (−u, −v), or (−u, π − v), are one point: half of the range of one of them is enough."""

Point = tuple[sp.Expr, ...]

_BY_COST = (
    "cartesian", "circular cylinder", "polar", "spherical", "parabolic", "parabolic cylinder", "rotational parabolic",
    "elliptic", "elliptic cylinder", "prolate spheroidal", "oblate spheroidal", "conical", "paraboloidal",
    "ellipsoidal",
)  # fmt: skip
"""Kinds of webs, those first whose separated equations are the simplest."""
_WITHOUT_ENDS = ("conical", "paraboloidal", "ellipsoidal")
"""Kinds whose usual chart covers one octant."""


def find_chart(system: System, refused: object, *, budget: float = 20.0) -> Chart:
    """Find the simplest coordinates in which a system separates that does not in its own.

    Normal modes where T and V are quadratic with constant coefficients, else the web of ``find_coordinates`` whose
    equations are the simplest: by kind, a single web before one of a family, plain numbers before roots.

    Args:
        system: natural, in Cartesian coordinates where it is not quadratic.
        refused: what ``separate`` said of it in its own coordinates.
        budget: seconds that the whole search may take, to about one.

    Raises:
        NotSeparableError: there are none, none could be certified, or that was not decided within the budget; the
            error carries the verdict.
    """
    refuse_kinks(system.kinks, "the search for coordinates")
    why = "the given coordinates do not separate"
    with within_seconds(budget):
        try:
            return _found(system, why, refused, budget)
        except SearchTimeError:
            raise NotSeparableError(f"{why}, and whether others do {_not_in(budget)}", refused) from None


def _not_in(budget: float) -> str:
    return (
        f"was not decided in {budget:g} s. Give more time, solve(…, budget=), or the parameters numbers in the formula"
    )


def _found(system: System, why: str, refused: object, budget: float) -> Chart:
    try:
        curved = curvilinear_map(system)
    except InvalidSystemError as reason:
        raise NotSeparableError(f"{why}, and others are not looked for: {reason}", refused) from None
    if curved is None:
        return _found_in_space(system, why, refused, budget)
    chart = _found_in_space(curved.space, why, refused, budget)
    x = [chart.transformation[c.name] for c in curved.space.coordinates]
    expressed = {c.name: e for c, e in zip(system.coordinates, curved.in_given_coordinates(x), strict=True)}
    return replace(chart, original=system, outer=curved, transformation=expressed)


def _found_in_space(system: System, why: str, refused: object, budget: float) -> Chart:
    try:
        sphere = sphere_below(system)
    except InvalidSystemError as reason:
        raise NotSeparableError(f"{why}, and others are not looked for: {reason}", refused) from None
    if sphere is not None:
        return _chart_on_sphere(sphere, why, refused, budget)
    for c in system.coordinates:
        if c.domain.kind != "line":
            raise NotSeparableError(
                f"{why}, and others are looked for only where all coordinates run along the whole line; "
                f'{c.name} has the domain "{c.domain.written(c.name)}"',
                refused,
            )
    if any(a != 0 for a in linear_terms(system)):
        chart = _in_another_gauge(system, why, budget) or _without_the_field(system, why, budget)
        if chart is not None:
            return chart
        raise NotSeparableError(
            f"{why}, nor do straight ones, nor those in which it separates without the terms linear in the velocities, "
            "in any gauge in which some are ignorable. Where all coefficients are constant, see gyroscopic_modes",
            refused,
        )
    if small_oscillations(system):
        try:
            return _modal(system, f"{why}; T and V are quadratic with constant coefficients", budget)
        except InvalidSystemError as reason:
            raise NotSeparableError(f"{why}, and normal modes are not available: {reason}", refused) from None
    try:
        found = find_coordinates(system, special=False, budget=budget)
    except InvalidSystemError as reason:
        raise NotSeparableError(f"{why}, and others are not looked for: {reason}", refused) from None
    cartesian = cartesian_form(system)
    return _simplest(found, cartesian, partial(_charted, cartesian=cartesian, budget=budget), why, refused)


def _chart_on_sphere(given: OnSphere, why: str, refused: object, budget: float) -> Chart:
    """Return the simplest web on a sphere."""
    sphere = given.sphere
    outer = sphere_map(sphere.system, sphere.mass, sphere.normal)
    if outer is None:
        raise NotSeparableError(
            f"{why}, and on a sphere others are looked for only where T and V are given in an angle from the pole or "
            "the equator with its whole domain, 0 < theta < pi or -pi/2 < b < pi/2, and an angle about the axis; "
            "find_coordinates lists them all the same",
            refused,
        )
    found = find_coordinates(sphere.system, special=False, budget=budget)
    charted = partial(_charted_on_sphere, given=given, outer=outer)
    return _simplest(found, given.space, charted, why, refused)


def _simplest(
    found: SeparableCoordinates, cartesian: Cartesian, charted: Callable[[Web, str], Chart | None], why: str,
    refused: object,
) -> Chart:  # fmt: skip
    """Return the chart of the web whose equations are the simplest of those that can be certified."""
    several = f", the simplest of {len(found.webs)} webs" if len(found.webs) > 1 else ", the only web"
    for web in sorted(found.webs, key=_cost):
        chart = charted(web, f"{why}; {web.kind} coordinates do{several}{_freedom(web)}")
        if chart is not None:
            independent = independent_integrals(found, cartesian)
            more = webs_in_words(found, cartesian, web.kind, independent)
            return replace(chart, remark=_remarks(chart.remark, more, found.undecided), independent=independent)
    if not found.webs and found.undecided:
        raise SearchTimeError
    if not found.webs:
        raise NotSeparableError(f"{why}. {found.advice}{_at_the_values(found)}", refused)
    names = "; ".join(map(str, found.webs))
    raise NotSeparableError(
        f"{why}. There may be others ({names}), but none of them was certified on all of its domain in the time "
        "allowed; give more, solve(…, budget=)",
        refused,
    )


def _at_the_values(found: SeparableCoordinates) -> str:
    """Say that a system separates at the default values of its parameters, where it does, but not at general ones."""
    system = found.system
    values = {p.symbol: p.value for p in system.parameters if p.value is not None}
    domains = {c.name: c.domain.written(c.name) for c in system.coordinates}
    if not values or len(values) < len(system.parameters):
        return ""
    at = System(domains, system.kinetic.xreplace(values), system.potential.xreplace(values), title=system.title)
    there = find_coordinates(at, special=False)
    if not any(web.certified for web in there.webs):
        return ""
    where = ", ".join(f"{symbol} = {value}" for symbol, value in values.items())
    return (
        f"\nThat holds for general values of the parameters; at {where} it separates in "
        f"{', '.join(there.kinds)} coordinates: write these values into the formula"
    )


def _remarks(*parts: str) -> str:
    return "; ".join(part for part in parts if part)


def _cost(web: Web) -> tuple[int, bool, int]:
    size = sum(int(sp.count_ops(e)) for e in web.transformation.values())
    return _BY_COST.index(web.kind), web.freedom > 0, size


def _charted(web: Web, reason: str, *, cartesian: Cartesian, budget: float) -> Chart | None:
    """Return the chart of a web, in coordinates without ends; None where ``separate`` does not certify it."""
    if web.kind in _WITHOUT_ENDS:
        web = web_of(web, cartesian, budget=budget, covering=True)
    system = valid_everywhere(web, cartesian)
    if system is None:
        return None
    if system != web.system:
        web = _with(web, system, budget)
    if not isinstance(web.verdict, Separation):
        return None
    local, axes = chart_and_axes(web, cartesian, covering=True)
    there = _there(cartesian.system, web.transformation, web.system)
    own = dict(zip(local.symbols, (web.system.symbols[name] for name in web.coordinates), strict=True))
    frame = cartesian.stretch * sp.Matrix([list(axis) for axis in axes]).T
    origin = cartesian.stretch * sp.Matrix(web.centre)
    return Chart(
        web.kind, web.coordinates, web.transformation, web.remark, reason, cartesian.system,
        there, replace(web.verdict, system=there), tuple(origin), sp.ImmutableMatrix(frame), tuple(own.values()),
        tuple(x.xreplace(own) for x in local.place), tuple(h.xreplace(own) for h in local.scale), cartesian.mass,
        web.lengths, flat_map(cartesian.system),
    )  # fmt: skip


def _charted_on_sphere(web: Web, reason: str, *, given: OnSphere, outer: OuterMap) -> Chart | None:
    """Return the chart of a web on a sphere.

    None where ``separate`` does not certify it, or it covers one octant alone.
    """
    local = next(charts_on_sphere(web, given))
    if not isinstance(web.verdict, Separation) or tuple(s.name for s in local.symbols) != web.coordinates:
        return None
    own = dict(zip(local.symbols, (web.system.symbols[name] for name in web.coordinates), strict=True))
    frame = sp.ImmutableMatrix(sp.Matrix([list(axis) for axis in web.axes]).T)
    return Chart(
        web.kind, web.coordinates, web.transformation, web.remark, reason, given.sphere.system, web.system,
        web.verdict, web.centre, frame, tuple(own.values()),
        tuple(x.xreplace(own) for x in local.place), tuple(h.xreplace(own) for h in local.scale), given.sphere.mass,
        web.lengths, outer,
    )  # fmt: skip


def _with(web: Web, system: System, budget: float) -> Web:
    """Return a web whose coordinates have other ranges, so that their symbols are other ones."""
    new = {web.system.symbols[name]: system.symbols[name] for name in web.coordinates}
    there = {name: formula.xreplace(new) for name, formula in web.transformation.items()}
    return replace(web, system=system, verdict=separate(system, budget=seconds_left(budget)), transformation=there)


def _there(original: System, transformation: Mapping[str, sp.Expr], found: System) -> System:
    """Return the system found, with the place that the given one has, as a function of its own coordinates."""
    at = {original.coordinate(name).symbol: e for name, e in transformation.items()}
    return placed(found, tuple((axis, formula.xreplace(at)) for axis, formula in original.place.items()))


def _freedom(web: Web) -> str:
    if not web.freedom:
        return ""
    return f"; one of a family ({web.family}): the motion has more integrals than it needs, and frequencies that agree"


def _in_another_gauge(system: System, why: str, budget: float) -> Chart | None:
    """Return the system with a gauge, and axes, in which coordinates are ignorable; None where it is coupled."""
    try:
        gauge = find_gauge(system, seconds_left(budget))
        verdict = None if gauge is None else separate(gauge.system, budget=seconds_left(budget))
    except WorkLimitError:
        raise SearchTimeError from None
    if gauge is None or not isinstance(verdict, Separation):
        return None
    symbols = tuple(c.symbol for c in gauge.system.coordinates)
    there = dict(zip((c.name for c in system.coordinates), gauge.frame * sp.Matrix(symbols), strict=True))
    found = _there(system, there, gauge.system)
    masses = sp.diag(*(sp.diff(gauge.system.kinetic, c.velocity, 2) for c in gauge.system.coordinates))
    return Chart(
        "cartesian", tuple(c.name for c in gauge.system.coordinates), there,
        f"momenta are less by the gradient of {gauge.function}",
        f"{why}; in another gauge they do" if gauge.frame.is_Identity else f"{why}; turned ones do, in another gauge",
        system, found, replace(verdict, system=found), (sp.S.Zero,) * len(symbols), gauge.frame, symbols, symbols,
        tuple(masses.diagonal()), sp.S.One, {}, flat_map(system), linear=gauge.linear, gauge=gauge.function,
    )  # fmt: skip


def _without_the_field(system: System, why: str, budget: float) -> Chart | None:
    """Return coordinates in which a system separates with and without its terms linear in the velocities."""
    linear = sp.Add(*(a * c.velocity for a, c in zip(linear_terms(system), system.coordinates, strict=True)))
    domains = {c.name: c.domain.written(c.name) for c in system.coordinates}
    plain = System(
        domains, sp.expand(system.kinetic - linear), system.potential, {p.name: p for p in system.parameters},
        title=system.title,
    )  # fmt: skip
    try:
        webs, cartesian = find_coordinates(plain, special=False, budget=budget).webs, cartesian_form(plain)
    except InvalidSystemError:
        return None
    for web in sorted((web for web in webs if web.kind != "cartesian"), key=_cost):
        chart = _charted(web, f"{why}; {web.kind} coordinates do", cartesian=cartesian, budget=budget)
        if chart is None:
            continue
        there = {system.coordinate(name).symbol: e for name, e in chart.transformation.items()}
        try:
            field = field_in(chart.system, there, system, seconds_left(budget))
            verdict = None if field is None else separate(field[0], budget=seconds_left(budget))
        except WorkLimitError:
            raise SearchTimeError from None
        if field is None or not isinstance(verdict, Separation):
            continue
        remark = f"momenta are less by the gradient of {field[2]}" if field[2] != 0 else ""
        found = _there(system, chart.transformation, field[0])
        return replace(
            chart, original=system, system=found, separation=replace(verdict, system=found), outer=flat_map(system),
            remark=_remarks(chart.remark, remark), linear=field[1], gauge=field[2],
        )  # fmt: skip
    return None


def _modal(system: System, reason: str, budget: float) -> Chart:
    modes = normal_modes(system, budget=seconds_left(budget))
    if not isinstance(modes.verdict, Separation):
        raise InvalidSystemError("the modes could not be certified")
    names = tuple(mode.name for mode in modes.modes)
    symbols = tuple(modes.system.symbols[name] for name in names)
    there, remark = _there(system, modes.transformation, modes.system), _remarks(modes.remark, modes_in_words(modes))
    return Chart(
        "normal modes", names, modes.transformation, remark, reason, system, there,
        replace(modes.verdict, system=there),
        tuple(modes.equilibrium.values()), modes.matrix, symbols, symbols, tuple(mode.mass for mode in modes.modes),
        sp.S.One, {}, flat_map(system),
    )  # fmt: skip


def valid_everywhere(web: Web, cartesian: Cartesian) -> System | None:
    """Return the system of a web with ranges of the coordinates in which its potential is the one given.

    Args:
        web: a web with its transformed system.
        cartesian: the system as given.

    Returns:
        The system, where needed with a coordinate that ends at a crease of V; None where no such ranges are known.
    """
    system = web.system
    sides = [_sides(c, shift, cartesian.values) for c, shift in zip(system.coordinates, _OFFSETS, strict=False)]
    wrong = [point for point in product(*sides) if not _agree(web, cartesian, point)]
    if not wrong:
        return system
    if web.kind not in _PAIRED:
        return None
    for k in (1, 0):
        if all(point[k] < 0 for point in wrong):
            return _ended(system, k, angle=system.coordinates[k].domain.kind == "angle")
    return None


def _sides(c: Coordinate, shift: sp.Rational, values: Mapping[sp.Symbol, sp.Expr]) -> Point:
    """One point on each side of the planes that a coordinate may have for edges of its domain's parts."""
    low, high = (None if end is None else end.xreplace(dict(values)) for end in (c.domain.lower, c.domain.upper))
    if c.domain.kind == "angle":
        quarter = shift * sp.Rational(3, 2)
        return quarter, quarter - 3, 3 - quarter, -quarter
    if low is None and high is None:
        return shift, -shift
    if low is not None and high is not None:
        return low + shift * (high - low), high - shift * (high - low) / 2
    return (low + shift, low + 5 * shift) if low is not None else (high - shift, high - 5 * shift)


def _agree(web: Web, cartesian: Cartesian, point: Point) -> bool:
    """Return whether V of the web is V as given at one point, parameters at the values that decide signs."""
    at = {c.symbol: x for c, x in zip(web.system.coordinates, point, strict=True)} | dict(cartesian.values)
    place = {
        c.symbol: web.transformation[c.name].xreplace(at).evalf(_DIGITS + 10) for c in cartesian.system.coordinates
    }
    given = cartesian.system.potential.xreplace({**cartesian.values, **place}).evalf(_DIGITS + 5)
    ours = web.system.potential.xreplace(at).evalf(_DIGITS + 5)
    if given.has(sp.nan, sp.zoo, sp.oo) or ours.has(sp.nan, sp.zoo, sp.oo):
        return False
    return bool(abs(given - ours) <= sp.Float(10) ** -(_DIGITS - 8) * (1 + abs(given)))


def _ended(system: System, k: int, *, angle: bool) -> System:
    """Return the system with coordinate k positive, and smaller than π where it was an angle."""
    name = system.coordinates[k].name
    domains = {c.name: c.domain.written(c.name) for c in system.coordinates}
    domains[name] = f"0 < {name} < pi" if angle else f"0 < {name}"
    return System(domains, system.kinetic, system.potential, {p.name: p for p in system.parameters}, title=system.title)
