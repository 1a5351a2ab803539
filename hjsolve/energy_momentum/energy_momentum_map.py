"""The verb of this room: the map of two constants, with its regions, critical curves and isolated critical values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve import arguments, catalog
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.display.by_value import ByValue
from hjsolve.display.renderers import renderer
from hjsolve.display.shown import Shown
from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds
from hjsolve.energy_momentum.critical_curves import CriticalCurve, Window, equations
from hjsolve.energy_momentum.isolation import Reals
from hjsolve.energy_momentum.kinds_of_motion import KindsOfMotion
from hjsolve.energy_momentum.momentum_polynomial import polynomial_of, with_domain
from hjsolve.energy_momentum.monodromy import IsolatedCriticalValue, Monodromy, isolated_values, monodromy_round
from hjsolve.energy_momentum.orbits import bounded_orbits
from hjsolve.energy_momentum.windows import chosen_window, critical_curves, first_window
from hjsolve.errors import InvalidInputError, MissingValueError, of_kind
from hjsolve.formulas.read import number
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.initial_data import domain_ends, parameter_values
from hjsolve.motion.motion import Motion
from hjsolve.precision import one_at_a_time
from hjsolve.solution.quadratures import Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ACROSS, _UP = 90, 66
_FEW = (18, 13)
_IN_THE_CELL = 0.48661
"""Where in its cell a point of a grid lies: a critical curve often goes through the middle of a window."""


@dataclass(frozen=True, repr=False, eq=False)
class EnergyMomentumMap(ByValue, Shown):
    """The plane of two constants of the motion; made by ``energy_momentum_map``.

    Attributes:
        x, y: names of the two constants.
        window: ranges of x and y that are drawn.
        point: the constants of the user's motion; None where there is none.
        curves: critical curves in the window.
        isolated: critical values that lie on no curve, with motions all round.
        solution: of the system.
        constants: the other constants → exact value.
        coordinates: the separated coordinates.
    """

    x: str
    y: str
    window: Window
    point: tuple[float, float] | None
    curves: tuple[CriticalCurve, ...]
    isolated: tuple[IsolatedCriticalValue, ...]
    solution: Solution = field(repr=False)
    constants: Mapping[str, sp.Expr] = field(repr=False)
    coordinates: tuple[CoordinateKinds, ...] = field(repr=False)

    def _label(self) -> str:
        return f"map of {self.x} and {self.y}"

    def kinds_at(self, x: object, y: object, q: Mapping[str, float] | None = None) -> dict[str, Any]:
        """Return the kinds of motion at a point, or at many.

        Args:
            x, y: values of the two constants, numbers or arrays that broadcast.
            q: separated coordinate → place, for the kind of the one motion that passes there, as ``Motion.kinds``
                tells it; numbers or arrays.

        Returns:
            Separated coordinate → the kinds of its regions in order of q, an empty tuple where it cannot move. With q:
            every coordinate → one kind, empty where no motion passes there. Object arrays where arrays came in.

        Raises:
            InvalidInputError: a value that is not a finite number, or q without every separated coordinate.
        """
        xs, ys, shape = _points(x, y)
        found = {own.name: own.at(xs, ys) for own in self.coordinates}
        result: dict[str, Any] = {}
        if q is None:
            result = {name: regions.kinds for name, regions in found.items()}
        else:
            missing = [name for name in found if name not in q]
            if missing:
                raise InvalidInputError(f"kinds_at: q needs every separated coordinate; {missing[0]} is missing")
            for c in self.solution.system.coordinates:
                words = np.full(len(xs), "ignorable", dtype=object)
                if c.name in found:
                    places = np.broadcast_to(np.asarray(q[c.name], float), shape).ravel()
                    for i in range(len(xs)):
                        words[i] = found[c.name].kind_at(i, float(places[i]))
                result[c.name] = words
        if shape == ():
            return {name: words[0] for name, words in result.items()}
        return {name: words.reshape(shape) for name, words in result.items()}

    def grid(self, across: int = _ACROSS, up: int = _UP) -> tuple[Reals, Reals, NDArray[np.int64], list[KindsOfMotion]]:
        """Classify a grid of points over the window.

        Args:
            across, up: points in each direction.

        Returns:
            x, shape (across,); y, shape (up,); the number of the kinds at each point, shape (up, across); the kinds by
            number, those of most points first.
        """
        cells = zip(self.window, (across, up), strict=True)
        xs, ys = (low + (high - low) * (np.arange(n) + _IN_THE_CELL) / n for (low, high), n in cells)
        X, Y = (v.ravel() for v in np.meshgrid(xs, ys))
        found = self.kinds_at(X, Y)
        keys = [tuple(found[own.name][i] for own in self.coordinates) for i in range(len(X))]
        keys = [key if all(key) else tuple(() for _ in key) for key in keys]
        order = sorted(set(keys), key=lambda key: (not all(key), -keys.count(key)))
        numbers = np.array([order.index(key) for key in keys])
        regions = []
        for k, key in enumerate(order):
            mine = np.flatnonzero(numbers == k)
            i = int(mine[len(mine) // 2])
            kinds = {own.name: words for own, words in zip(self.coordinates, key, strict=True)}
            regions.append(KindsOfMotion(kinds, (float(X[i]), float(Y[i])), len(mine) / len(X)))
        return xs, ys, numbers.reshape(len(ys), len(xs)), regions

    @property
    def regions(self) -> tuple[KindsOfMotion, ...]:
        """The kinds of motion in the window, those of most points first."""
        quick = all(own.polynomial is not None for own in self.coordinates)
        return tuple(self.grid()[3] if quick else self.grid(*_FEW)[3])

    def actions_at(self, x: object, y: object) -> dict[str, EstimateArray]:
        """Return the actions at many points, of the first region of each coordinate.

        Args:
            x, y: values of the two constants, numbers or arrays that broadcast.

        Returns:
            Separated coordinate → J = (1/2π) ∮ p dq with its error, of the constants of motions begun at doubles; NaN
            where a coordinate has no bounded region, or an orbit was not had by ``ensemble(…, fallback=False)``.

        Raises:
            InvalidInputError: a value that is not a finite number.
        """
        xs, ys, shape = _points(x, y)
        good, batch = bounded_orbits(self.solution, self.coordinates, xs, ys, {"actions"})
        result = {}
        for own in self.coordinates:
            value, error = np.full(len(xs), np.nan), np.full(len(xs), np.nan)
            if batch is not None:
                value[good], error[good] = batch.actions[own.name], batch.error["actions"][own.name]
            result[own.name] = EstimateArray(value.reshape(shape), error.reshape(shape))
        return result

    def equation(self, coordinate: str) -> sp.Expr | None:
        """Return the discriminant of P² as a polynomial in the two constants; every double zero lies where it vanishes.

        Args:
            coordinate: a separated one.

        Returns:
            The polynomial without multiple factors; None where no variable is known in which P² is a polynomial.

        Raises:
            InvalidInputError: no separated coordinate of this name.
        """
        for own in self.coordinates:
            if own.name == coordinate:
                return equations(own, {})
        raise InvalidInputError(f'equation: "{coordinate}" is not separated')

    def monodromy(self, around: tuple[float, float] | None = None, radius: float | None = None) -> Monodromy:
        """Follow the tori over a circle round a point and tell what becomes of a basis of their periods.

        Args:
            around: the centre (x, y); None for the isolated critical value.
            radius: of the circle, as part of the window; None for one that meets no critical curve.

        Returns:
            The matrix, with the whole turns that the angles gain.

        Raises:
            InvalidInputError: no isolated critical value; more than one separated coordinate; neither constant is the
                momentum of an ignorable angle; the circle meets a critical curve.
            NotConvergedError: frequencies along the circle could not be computed.
        """
        if len(self.coordinates) != 1:
            raise InvalidInputError("monodromy: it is worked out for systems with one separated coordinate")
        angles = [c.name for c in self.solution.system.coordinates if c.domain.kind == "angle"]
        angles = [n for n in angles if n not in self.solution.coordinates]
        own = [n for n in angles if f"p_{n}" in (self.x, self.y)]
        if not own:
            raise InvalidInputError("monodromy: x or y must be the momentum of an ignorable angle, such as p_phi")
        if around is None:
            if not self.isolated:
                raise InvalidInputError("monodromy: there is no isolated critical value here; give around=(x, y)")
            around, radius = (self.isolated[0].x, self.isolated[0].y), radius or self.isolated[0].radius
        named = [own[0], *(n for n in angles if n != own[0])]
        return monodromy_round(self.solution, self.coordinates, around, radius or 0.05, self.window, named)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the map with matplotlib (extra ``report``).

        Args:
            ax: axes to draw on; None for new ones.

        Returns:
            The axes.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        return renderer("plots").plotted_map(self, ax)


def _points(x: object, y: object) -> tuple[Reals, Reals, tuple[int, ...]]:
    try:
        xs, ys = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    except (TypeError, ValueError):
        raise InvalidInputError("x, y: numbers or arrays of one shape are needed") from None
    if not (np.isfinite(xs).all() and np.isfinite(ys).all()):
        raise InvalidInputError("x, y: finite numbers are needed")
    return xs.ravel(), ys.ravel(), xs.shape


@arguments.with_known_names('energy_momentum_map(solution, "p_phi", "E")')
@one_at_a_time
def energy_momentum_map(
    solution: Solution | Motion,
    x: str | None = None,
    y: str | None = None,
    *,
    constants: Mapping[str, object] | None = None,
    parameters: Mapping[str, object] | None = None,
    window: Mapping[str, tuple[float, float]] | None = None,
) -> EnergyMomentumMap:
    """Map the kinds of motion over the plane of two constants of the motion.

    Args:
        solution: a solution, or one of its motions, whose constants are then a point of the map.
        x, y: names of the two constants. Left out, y is E, for geodesics p_t, and x the momentum of an ignorable
            angle, or else the next constant.
        constants: name → value of the other constants; those of the motion, or of the catalog's, where left out.
        parameters: name → value, where it differs from the motion's or the default.
        window: x and y by name → (low, high), the ranges drawn; None for ranges round the motion.

    Returns:
        The map: ``kinds_at``, ``regions``, ``curves``, ``isolated``, ``actions_at``, ``monodromy``, ``plot``.

    Raises:
        InvalidInputError: names that are no constants, one constant only, or ranges that are none.
        MissingValueError: a value of another constant, or a range, is needed.

    Example:
        >>> import hjsolve
        >>> pendulum = hjsolve.solve("spherical-pendulum")
        >>> found = hjsolve.energy_momentum_map(pendulum, x="p_phi", y="E")
        >>> found.kinds_at(0.5, 3.0)
        {'theta': ('libration',)}
        >>> found.monodromy().matrix in (((1, 0), (1, 1)), ((1, 0), (-1, 1)))
        True
    """
    solved, known = _subject(solution, parameters)
    names = list(solved.constants)
    if len(names) < 2 or not solved.coordinates:
        raise InvalidInputError("energy_momentum_map: the system has one constant only; its phase plane is the map")
    refuse_kinks(solved.system.kinks, "energy_momentum_map")
    x, y = _names(solved, x, y)
    for name in (x, y):
        if name not in names or x == y:
            raise InvalidInputError(f"energy_momentum_map: x and y are two of {', '.join(names)}, not {name!r}")
    others = {n: _other(n, constants, known.constants) for n in names if n not in (x, y)}
    symbols = (solved.constants[x].symbol, solved.constants[y].symbol)
    values = {**known.parameters, **{solved.constants[n].symbol: value for n, value in others.items()}}
    own = tuple(coordinate_kinds(solved, name, values, symbols, known.places) for name in solved.coordinates)
    point = None
    if all(name in known.constants for name in (x, y)):
        point = (float(sp.N(known.constants[x], 20)), float(sp.N(known.constants[y], 20)))
    ranges = chosen_window(window, (x, y)) or first_window(own, (x, y), point)
    curves = tuple(curve for coordinate in own for curve in critical_curves(coordinate, ranges))
    isolated = tuple(isolated_values(own, curves, ranges))
    return EnergyMomentumMap(x, y, ranges, point, curves, isolated, solved, others, own)


def _names(solution: Solution, x: str | None, y: str | None) -> tuple[str, str]:
    """Return the names of the two constants, those left out chosen."""
    names = list(solution.constants)
    if y is None:
        y = "p_t" if time_name(solution.system) != "t" and "p_t" in names and x != "p_t" else "E"
    angles = [f"p_{c.name}" for c in solution.system.coordinates if c.domain.kind == "angle"]
    likely = [*angles[::-1], *(n for n in names if n.startswith("p_")), *names]
    return x if x is not None else next((n for n in likely if n in names and n not in ("E", y)), names[-1]), y


@dataclass(frozen=True)
class _Known:
    """What a motion, or the catalog, tells: exact values of constants, parameters and places."""

    constants: Mapping[str, sp.Expr]
    parameters: Mapping[sp.Symbol, sp.Expr]
    places: Mapping[str, sp.Expr]


def _subject(subject: Solution | Motion, parameters: Mapping[str, object] | None) -> tuple[Solution, _Known]:
    given = dict(arguments.table(parameters, "parameters", '{"m": 1}'))
    if not isinstance(subject, (Solution, Motion)):
        raise InvalidInputError(
            f"energy_momentum_map: a Solution or a Motion is needed, not {arguments.described(subject)}"
        )
    motion = subject.as_solved if isinstance(subject, Motion) else _default(subject)
    solved = of_kind(motion.solution if isinstance(subject, Motion) and motion is not None else subject, Solution)
    if motion is None or given:
        return solved, _Known({}, parameter_values(solved.system, given), {})
    values = motion.initial.values
    places = {c.name: values[c.symbol] for c in solved.system.coordinates}
    numbers = {p.symbol: values[p.symbol] for p in solved.system.parameters}
    return solved, _Known(motion.initial.constants, numbers, places)


def _default(solution: Solution) -> Motion | None:
    """Return the catalog's default motion of a system, without its integrals; None where there is none."""
    entry = None if solution.chart is not None else catalog.entry_of(solution.system)
    if entry is None or "default" not in entry.motions:
        return None
    initial: dict[str, Any] = {**entry.motions["default"].arguments, "want": ["constants", "turning_points"]}
    return solution.motion(**initial)


def _other(name: str, given: Mapping[str, object] | None, known: Mapping[str, sp.Expr]) -> sp.Expr:
    if given is not None and name in given:
        return number(given[name], source=f"constants[{name}]")
    if name in known:
        return known[name]
    raise MissingValueError(f"energy_momentum_map: no value for {name}; write constants={{{name!r}: …}}")


def coordinate_kinds(
    solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], symbols: tuple[sp.Symbol, sp.Symbol],
    places: Mapping[str, sp.Expr],
) -> CoordinateKinds:  # fmt: skip
    """Make one separated coordinate ready for many points of the plane of two constants.

    Args:
        values: symbol → exact number, of the parameters and the other constants.
        symbols: of the two constants.
        places: coordinate → a place inside its domain, as far as known.
    """
    coordinate = solution.system.coordinate(name)
    low, high = domain_ends(solution.system, name, values)
    F = solution.momentum_squared[name].subs(dict(values))
    kind: Literal["line", "angle", "interval"] = coordinate.domain.kind
    if kind == "angle" and sp.simplify(F.subs(coordinate.symbol, coordinate.symbol + 2 * sp.pi) - F) != 0:
        kind = "line"
    place = places.get(name, _middle(low, high))
    scale = abs(float(sp.N(place - low if low is not None else place))) or 1.0
    polynomial = polynomial_of(F, with_domain(coordinate, low, high, kind), *symbols, scale)
    return CoordinateKinds(solution, name, values, symbols, polynomial, place)


def _middle(low: sp.Expr | None, high: sp.Expr | None) -> sp.Expr:
    if low is not None and high is not None:
        return (low + high) / 2
    return low + 1 if low is not None else high - 1 if high is not None else sp.S.One
