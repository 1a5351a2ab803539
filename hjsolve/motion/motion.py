"""One motion of a separable system: constants, kinds, turning points, periods, actions, and where it is at any time.

Everything is computed from Jacobi's theorem (Greenwood (5-70), (5-71)): the constants come exactly from the initial
data, each separated coordinate is classified and integrated over its anomaly (``one_coordinate/``), and q(t) inverts
the time law. No differential equation is integrated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.formulas.read import number
from hjsolve.lowering import momentum_squared_tapes
from hjsolve.motion import quantities
from hjsolve.motion.initial_data import ZERO_BITS, InBits, Initial, domain_ends, expanded, initial_data, sign, to_bits
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.state import State
from hjsolve.one_coordinate.allowed_regions import forbidden, others
from hjsolve.one_coordinate.classify import Located, locate
from hjsolve.one_coordinate.coordinate_motion import PARTS, Open
from hjsolve.one_coordinate.coordinate_start import Start
from hjsolve.one_coordinate.momentum_squared import Radicand, has_period
from hjsolve.solution.quadratures import Solution
from hjsolve.time_law.open_motion import Plan, plan
from hjsolve.time_law.torus import Torus, torus

_FARTHEST, _MOST_ANGLE = 2**1000, 2**48
QUANTITIES: Mapping[str, frozenset[str]] = {
    "constants": frozenset(), "kinds": frozenset(), "turning_points": frozenset(), "actions": frozenset({"action"}),
    "periods": frozenset({"time"}), "frequencies": frozenset({"time"}), "mean_velocities": frozenset({"time"}),
    "angles": frozenset({"time"}), "boundary_times": frozenset({"time"}), "orbit": frozenset({"time", "place"}),
    "trajectory": frozenset({"time", "place"}),
}  # fmt: skip
"""What may be asked of a motion, and the integrals each needs (``numeric.course.PARTS``)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion, started by ``Solution.motion``; see the module's text.

    Attributes:
        solution: what is solved.
        initial: the exact initial data and constants.
        t0: the initial time, exact.
        digits: digits asked of every number.
        located: separated coordinate → its course and the ends of its region.
        equations: Jacobi's equations made ready for inversion; None where every coordinate is ignorable.
        kinds: coordinate → libration, rotation, escape, equilibrium, asymptotic, boundary or ignorable.
        turning_points: coordinate → (lower, upper), None where there is none on that side; no key for a rotation.
        constants: name → Estimate.
        actions: coordinate → J = (1/2π) ∮ p dq over a full cycle, signed like p for a rotation.
        frequencies: coordinate → Ω = ∂H/∂J in radians per unit time, where it exists.
        periods: coordinate → 2π/|Ω|.
        boundary_times: coordinate → time at which it reaches an end of its domain.
        parts: what was integrated, of ``numeric.course.PARTS``; all of it unless ``want`` asked for less.
        states: for a certified motion, the rule that starts the motion its states are read from.
        given: the input as it came. again: the rule that starts it anew with other digits or changed input.
    """

    solution: Solution
    initial: Initial
    t0: sp.Expr
    digits: int
    located: Mapping[str, Located]
    equations: Torus | Plan | None
    kinds: Mapping[str, str]
    turning_points: Mapping[str, tuple[Estimate | None, Estimate | None]]
    constants: Mapping[str, Estimate]
    actions: Mapping[str, Estimate]
    frequencies: Mapping[str, Estimate]
    periods: Mapping[str, Estimate]
    boundary_times: Mapping[str, Estimate]
    parts: frozenset[str] = PARTS
    states: Callable[[], Motion] | None = field(default=None, repr=False)
    given: Mapping[str, Any] = field(default_factory=dict, repr=False)
    again: Callable[[int, Mapping[str, Any]], Motion] | None = field(default=None, repr=False)

    @property
    def nodes(self) -> int:
        """Quadrature nodes of the dearest coordinate."""
        return max((quantities.nodes_of(place.course) for place in self.located.values()), default=0)

    @property
    def mean_velocities(self) -> dict[str, Estimate]:
        """Mean velocities ⟨dq/dt⟩ of the ignorable coordinates that are no angles, where all others are bounded.

        The drift of a charge in crossed fields; dt/dτ of a geodesic, by which frequencies per unit of proper time are
        divided to give those of a far observer.
        """
        self._require("mean_velocities")
        source = self._source
        return quantities.mean_velocities(source.solution, source.initial, source.equations, source.digits)

    def at(self, t: Any) -> State:
        """Return the state at a time or times.

        Args:
            t: number (int, float, decimal or rational string, Fraction, mpf) or an array or list of them.

        Returns:
            The state; float64 up to 15 digits, mpf above.

        Raises:
            InvalidInputError: a time that is no finite real number.
        """
        from hjsolve.motion.state_at import state_at

        self._require("trajectory")
        return state_at(self._source, t)

    def time_at(self, name: str, value: Any, passage: int = 0) -> Estimate:
        """Return the time of the passage-th crossing of a position, counted from t₀ on.

        Args:
            name: coordinate.
            value: position; for an angle modulo 2π.
            passage: 0 for the first crossing at t ≥ t₀, 1 for the next, −1 for the last before t₀ …

        Raises:
            InvalidInputError: an unknown coordinate, a value that is no number, or a passage that is not whole.
            OutsideMotionError: the motion never reaches that position, or not that often.
        """
        from hjsolve.motion.crossings import crossing_time

        self.solution.system.coordinate(name)
        self._require("periods" if name in self.located else "trajectory")
        return crossing_time(self._source, name, value, passage)

    def orbit(self, name: str, *, along: str, values: Any) -> Any:
        """Return one coordinate where another passes given values for the first time after t₀ (orbit equation).

        Args:
            name: coordinate wanted; unwrapped if it is an angle.
            along: coordinate whose values are given.
            values: positions of ``along``, shape (m,).

        Returns:
            Array of shape (m,).

        Raises:
            InvalidInputError: an unknown coordinate, or a value that is no number.
            OutsideMotionError: the motion never reaches a value.
        """
        from hjsolve.motion.crossings import crossing_times

        for coordinate in (name, along):
            self.solution.system.coordinate(coordinate)
        times = crossing_times(self._source, along, values)
        return self.at(times).unwrapped(name)

    def angles(self, t: Any) -> dict[str, Any]:
        """Return the angle variables θ = θ₀ + Ω (t − t₀), in (−π, π], of every coordinate that has a frequency.

        θ of a libration is zero when all coordinates stand at their lower turning points.
        """
        from hjsolve.motion.crossings import angle_variables

        self._require("angles")
        return angle_variables(self._source, t)

    def input_doubt(self) -> dict[str, dict[str, float]]:
        """Return how far each number can move when every float input moves by half an ulp; see ``conditioning``."""
        from hjsolve.motion.input_sensitivity import input_doubt

        return input_doubt(self)

    @property
    def other_regions(self) -> dict[str, tuple[tuple[Estimate | None, Estimate | None], ...]]:
        """Where else each separated coordinate could move with the same constants: other wells, and places of rest.

        Coordinate → intervals (lower, upper) in order, without the one the motion is in (``turning_points``); None for
        an end that is no turning point. At most ``numeric.regions.MOST`` on each side. Worked out when it is read.
        """
        result = {}
        for name, place in self.located.items():
            begin = _start(self.solution, self.initial, name)
            found = others(begin, place.lower, place.upper, self.digits)
            result[name] = tuple(quantities.ends(region, self.digits) for region in found)
        return result

    @property
    def _source(self) -> Motion:
        return self.states() if self.states else self

    def _require(self, quantity: str) -> None:
        if not QUANTITIES[quantity] <= self.parts:
            raise InvalidInputError(f'this motion was started without what {quantity} need; add "{quantity}" to want')


def start(
    solution: Solution,
    *,
    q: Mapping[str, Any],
    velocity: Mapping[str, Any] | None = None,
    p: Mapping[str, Any] | None = None,
    constants: Mapping[str, Any] | None = None,
    signs: Mapping[str, int] | None = None,
    parameters: Mapping[str, Any] | None = None,
    t0: Any = 0,
    digits: int = FLOAT_DIGITS,
    certified: bool = False,
    want: Iterable[str] | None = None,
) -> Motion:
    """Start a motion from initial data.

    Args:
        solution: of the system.
        q: coordinate → position, every one.
        velocity: coordinate → velocity, every one; or
        p: coordinate → canonical momentum, every one; or
        constants: name of a constant of the motion (``Solution.constants``) → value, every one, with
        signs: separated coordinate → 1 or −1, the sign its root P = √P² starts with; needless where P = 0.
        parameters: name → value, where it differs from the default.
        t0: time of the initial data.
        digits: relative digits wanted, at least 1; float64 up to 15.
        certified: prove constants, turning points, actions, frequencies and periods (needs the extra ``certified``);
            states stay estimates, at the digits asked.
        want: which of ``QUANTITIES`` will be asked; nothing else is integrated. None for all.

    Returns:
        The motion.

    Raises:
        InvalidInputError: initial data that are no numbers, incomplete, or outside the domain.
        MissingValueError: a parameter or an initial value is missing.
        ForbiddenMotionError: no real motion has these constants.
        NotConvergedError: a turning point or an integral could not be had to the digits asked.

    Example:
        >>> import hjsolve
        >>> kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
        >>> motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        >>> motion.kinds["r"], round(motion.periods["r"].value, 9)
        ('libration', 14.99332061)
    """
    digits = arguments.digits(digits)
    arguments.refuse_other(certified, bool, "certified", "True or False is needed")
    initial = initial_data(
        solution, q=q, velocity=velocity, p=p, constants=constants, signs=signs, parameters=parameters
    )
    wanted = None if want is None else arguments.words(want, "want", '["actions", "periods"]')
    parts, exact_t0 = parts_of(wanted), number(t0, source="t0")
    groups = {
        "q": q, "velocity": velocity, "p": p, "constants": constants, "signs": signs, "parameters": parameters,
    }  # fmt: skip
    given = {name: None if group is None else dict(group) for name, group in groups.items()}
    if certified:
        motion = _certified(solution, initial, exact_t0, max(digits, FLOAT_DIGITS), parts)
    else:
        motion = _move(solution, initial, exact_t0, max(digits, FLOAT_DIGITS), parts)
    return replace(motion, given=given, again=partial(_again, solution, given, exact_t0, wanted))


def _again(
    solution: Solution, given: Mapping[str, Any], t0: sp.Expr, want: frozenset[str] | None, digits: int,
    change: Mapping[str, Any],
) -> Motion:  # fmt: skip
    """Start a motion anew from what was given, with other digits or changed input."""
    return start(solution, **{**given, **change}, t0=t0, digits=digits, want=want)


def _move(solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str]) -> Motion:
    begins = {name: replace(_start(solution, initial, name), parts=parts) for name in solution.coordinates}
    located = {name: locate(_checked(begin), digits) for name, begin in begins.items()}
    return _assemble(solution, initial, t0, digits, located, parts)


def _certified(solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str]) -> Motion:
    """Make a motion of proved numbers; states come from a motion at full digits, when asked.

    The proof needs kinds and guesses, in few digits and without an integral.
    """
    from hjsolve.motion.certified import enclose, librating, lines, work_bits

    begins = {name: replace(_start(solution, initial, name), parts=frozenset[str]()) for name in solution.coordinates}
    radicands = {name: begin.radicand for name, begin in begins.items()}
    known = lines(radicands, initial, solution, work_bits(digits))
    located = {
        name: librating(begin, initial, solution, known[name]) or locate(_checked(begin), FLOAT_DIGITS)
        for name, begin in begins.items()
    }
    motion = Motion(
        solution, initial, t0, digits, located, None, _kinds(solution, located), {}, {}, {}, {}, {}, {}, parts,
        states=_States(solution, initial, t0, digits, parts),
    )  # fmt: skip
    proved = enclose(motion, digits, known)
    return replace(
        motion, constants=proved.constants, turning_points=proved.turning_points, actions=proved.actions,
        frequencies=proved.frequencies, periods=proved.periods,
    )  # fmt: skip


class _States:
    """The motion that the states of a certified one are read from, made when it is first asked for."""

    def __init__(self, *arguments: Any):
        self.arguments = arguments
        self.motion: Motion | None = None

    def __call__(self) -> Motion:
        if self.motion is None:
            self.motion = _move(*self.arguments)
        return self.motion

    def __reduce__(self) -> tuple[Any, ...]:
        return _States, self.arguments


def _kinds(solution: Solution, located: Mapping[str, Located]) -> dict[str, str]:
    return {
        c.name: str(located[c.name].course.kind) if c.name in located else "ignorable"
        for c in solution.system.coordinates
    }


def parts_of(want: Iterable[str] | None) -> frozenset[str]:
    """The integrals that the quantities wanted need.

    Raises:
        InvalidInputError: a name that is not in ``QUANTITIES``.
    """
    if want is None:
        return PARTS
    names = arguments.words(want, "want", '["actions", "periods"]')
    for name in sorted(names - QUANTITIES.keys()):
        raise InvalidInputError(f'want: "{name}" is not known; known are {", ".join(QUANTITIES)}')
    return frozenset[str]().union(*(QUANTITIES[name] for name in names))


def _start(solution: Solution, initial: Initial, name: str) -> Start:
    """Bring one separated coordinate over to numbers."""
    coordinate, F = solution.system.coordinate(name), solution.momentum_squared[name]
    constants = tuple(solution.constants[c].symbol for c in solution.constants)
    parameters = tuple(p.symbol for p in solution.system.parameters)
    exact = [initial.constants[c] for c in solution.constants] + [initial.values[s] for s in parameters]
    rules = [to_bits(value) for value in exact]
    squared, kernels, absent, periodic = momentum_squared_tapes(F, coordinate.symbol, constants, parameters)
    radicand = Radicand(squared, kernels, partial(_at_bits, rules))
    momentum, shift = initial.values[coordinate.momentum], solution.shift[name]
    ends = [None if end is None else to_bits(end) for end in domain_ends(solution.system, name, initial.values)]
    place = to_bits(initial.values[coordinate.symbol])
    angle = coordinate.domain.kind == "angle" and (periodic or has_period(radicand, place))
    root = expanded(momentum + shift.subs(initial.values)) if shift != 0 else expanded(momentum)
    forward = sign(root)
    if forward:
        radicand = radicand.guarded(place, _square(to_bits(root)))
    return Start(name, radicand, place, forward, ends[0], ends[1], angle, absent)


def _at_bits(rules: list[InBits], bits: int) -> list[Any]:
    return [rule(bits) for rule in rules]


def _square(root: Callable[[int], Any]) -> Callable[[int], Any]:
    """P² of a root that may be what two large numbers leave."""
    return lambda bits: root(bits + ZERO_BITS) ** 2


def _checked(begin: Start) -> Start:
    place = begin.place(256 + begin.radicand.guard)
    if abs(place) >= (_MOST_ANGLE if begin.angle else _FARTHEST):
        cure = "take whole turns off" if begin.angle else "write lengths in another unit"
        raise NotConvergedError(f"q[{begin.name}]: is so far out that doubles cannot tell places apart there; {cure}")
    value = begin.radicand.value(place, 256)
    if begin.forward and value < 0:
        raise forbidden(begin)
    return begin


def _assemble(
    solution: Solution, initial: Initial, t0: sp.Expr, digits: int, located: dict[str, Located], parts: frozenset[str]
) -> Motion:
    courses = [located[name].course for name in solution.coordinates]
    bits = int(3.33 * digits) + 128
    bounded = [c for c in courses if not isinstance(c, Open)]
    timed = "time" in parts
    equations = (
        None if not (courses and timed) else torus(bounded, bits) if len(bounded) == len(courses) else plan(courses)
    )
    kinds = _kinds(solution, located)
    frequencies = quantities.frequencies(solution, initial, equations, digits) if timed else {}
    motion = Motion(
        solution, initial, t0, digits, located, equations, kinds,
        {name: quantities.ends(place, digits) for name, place in located.items() if place.lower.kind != "round"},
        {name: quantities.rounded(to_bits(value)(bits), digits) for name, value in initial.constants.items()},
        quantities.actions(solution, initial, located, digits) if "action" in parts else {}, frequencies,
        {name: quantities.period(f) for name, f in frequencies.items() if f.value}, {}, parts,
    )  # fmt: skip
    if "boundary" not in kinds.values() or not timed:
        return motion
    from hjsolve.motion.crossings import boundary_times

    return replace(motion, boundary_times=boundary_times(motion))
