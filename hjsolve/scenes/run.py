"""The run of a scene: its arcs, the quantities it wants of each, and the state at its times."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.errors import InvalidInputError, MissingValueError, NotSeparableError
from hjsolve.initial import to_bits
from hjsolve.motion import Motion
from hjsolve.numeric.counting import Work, counted
from hjsolve.numeric.estimate import Estimate
from hjsolve.scenes import arcs as smooth
from hjsolve.scenes.crossing import bits_of
from hjsolve.scenes.events import Event
from hjsolve.scenes.orbits import orbit_table
from hjsolve.scenes.refusal import dissipative, words
from hjsolve.scenes.scene import Scene, Times
from hjsolve.solution import Solution, solve
from hjsolve.state import Errors, Known, State
from hjsolve.trajectory.dense import OnDemand

_FIELDS = (
    "constants", "kinds", "turning_points", "actions", "periods", "frequencies", "mean_velocities", "boundary_times",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Arc:
    """One smooth arc.

    Attributes:
        begins, ends: its times; ``ends`` None for the last.
        events: those that end it.
        motion: what was computed; of the wanted quantities only.
        turns: angle → whole turns made before the arc.
        quantities: wanted quantity → its values, as in ``Motion``.
    """

    begins: Estimate
    ends: Estimate | None
    events: tuple[Event, ...]
    motion: Motion
    turns: Mapping[str, int]
    quantities: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The states at the times of a scene; at the time of an event, the state just after it.

    Attributes:
        t: the times, shape (m,); float64 up to 15 digits, ``mpf`` above.
        q, p, velocity: coordinate → array (m,); angles in (−π, π].
        turns: angle → whole turns to be added to ``q``.
        status: ``ok`` or ``reaches_boundary`` for each time.
        arc: number of the arc each time belongs to.
        errors: the rule behind ``error``.
    """

    t: Any
    q: Mapping[str, Any]
    p: Mapping[str, Any]
    velocity: Mapping[str, Any]
    turns: Mapping[str, Any]
    status: Any
    arc: Any
    errors: Callable[[], Errors]

    def __reduce__(self) -> tuple[Any, ...]:
        numbers = (self.q, self.p, self.velocity, self.turns)
        return Trajectory, (self.t, *map(dict, numbers), self.status, self.arc, Known(self.error))

    @property
    def error(self) -> Errors:
        """Bounds on the errors of q, p and velocity, worked out when asked for."""
        return self.errors()

    def unwrapped(self, name: str) -> Any:
        """Return q with its whole turns."""
        return State(self.t, self.q, self.p, self.velocity, self.turns, self.status, self.errors).unwrapped(name)


@dataclass(frozen=True)
class Choice:
    """How a scene was run.

    Attributes:
        method: ``float64``, ``mpmath``, ``certified`` (ball arithmetic) or ``integrate``.
        digits: it was run with. why: in words.
        tried: (method, digits, seconds) of every run made, in order; the last one gave the answer.
    """

    method: str
    digits: int
    why: str
    tried: tuple[tuple[str, int, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Run:
    """What a scene gave; see ``Scene.run``.

    Attributes:
        scene: what was asked.
        solution: the quadratures; None where the scene was integrated.
        arcs: the smooth arcs in order; none where the scene was integrated.
        trajectory: the states, where they are wanted.
        drift: former constant → its change since the start at every time, where the scene was integrated.
        work: evaluations of p², of kernels, and of places, all that the run needed.
        choice: which method was chosen, and why.
    """

    scene: Scene
    solution: Solution | None
    arcs: tuple[Arc, ...]
    trajectory: Trajectory | None
    drift: Mapping[str, Any]
    work: Work
    choice: Choice | None = None

    def quantity(self, name: str, arc: int = 0) -> Any:
        """Return a wanted quantity of one arc, as in ``Motion``.

        Raises:
            InvalidInputError: the scene does not want it, or there is no such arc.
        """
        if not -len(self.arcs) <= arc < len(self.arcs):
            raise InvalidInputError(f"arc: {arc} does not exist; the scene has {len(self.arcs)}")
        if name not in self.arcs[arc].quantities:
            raise InvalidInputError(f'"{name}" was not computed; add it to want')
        return self.arcs[arc].quantities[name]


def run(scene: Scene, solution: Solution | None = None) -> Run:
    """Compute what a scene wants with the digits it has; a solution that is there already is not made again."""
    if scene.method == "integrate":
        from hjsolve.scenes.integrate import integrated

        _started(scene)
        return integrated(scene)
    if solution is None:
        solution = solved(scene)
        assert solution is not None
    if scene.certified and scene.events:
        raise InvalidInputError("proofs end at an event: the state there is computed, not proved; leave certified out")
    with counted() as work:
        found = smooth.pieces(scene, solution, first_arguments(scene))
        arcs = tuple(_arc(scene, solution, piece) for piece in found)
        trajectory = _trajectory(scene, arcs, found) if "trajectory" in scene.want else None
    return Run(scene, solution, arcs, trajectory, {}, work)


def _started(scene: Scene) -> None:
    if scene.sweep is not None:
        raise InvalidInputError(
            f"{scene.source}: has many motions; run it by hjsolve.sweep(scene, out) or `hjsolve sweep FILE -o OUT`"
        )
    if scene.initial is None:
        raise MissingValueError(f"{scene.source}: initial: missing, and the system has no default motion")


def solved(scene: Scene) -> Solution | None:
    """Solve the system of a scene; None where it is to be integrated.

    Raises:
        NotSeparableError: it does not separate, or a force acts on it.
        MissingValueError: nothing says where the motion starts.
    """
    _started(scene)
    if scene.method == "integrate":
        return None
    if scene.forces:
        verdict = dissipative(scene.system, scene.forces)
        raise NotSeparableError(words(verdict), verdict)
    try:
        return solve(scene.system)
    except NotSeparableError as error:
        text = f'{error}; or write method = "integrate" in the scene'
        raise NotSeparableError(text, error.verdict) from error


def first_arguments(scene: Scene) -> dict[str, Any]:
    """The arguments of the first motion, as the scene gives them."""
    start = scene.initial
    assert start is not None
    given = {"q": start.q, "velocity": start.velocity, "p": start.p, "parameters": scene.parameters, "t0": start.t}
    return {name: value for name, value in given.items() if value is not None}


def _arc(scene: Scene, solution: Solution, piece: smooth.Piece) -> Arc:
    motion = solution.motion(
        **piece.leg.arguments, digits=scene.digits, want=scene.want, certified=scene.certified
    )
    begins = _moment(motion.t0, scene.digits)
    ends = None if piece.ends is None else _moment(piece.ends, scene.digits)
    quantities = {name: getattr(motion, name) for name in _FIELDS if name in scene.want}
    if "angles" in scene.want and scene.times is not None:
        inside = _inside(scene.times, scene.digits, motion.t0, piece.ends)
        quantities["angles"] = motion.angles(inside)
    if "orbit" in scene.want:
        quantities["orbit"] = orbit_table(scene.orbit, motion)
    return Arc(begins, ends, piece.events, motion, piece.leg.turns, quantities)


def _moment(time: sp.Expr, digits: int) -> Estimate:
    value = to_bits(time)(bits_of(max(digits, 15)))
    if digits <= 15:
        exact = time.is_Rational and sp.Rational(float(value)) == time
        return Estimate(float(value), 0.0 if exact else abs(float(value)) * 2.0**-52)
    return Estimate(value, abs(value) * value.context.mpf(10) ** -digits)


def sampled(times: Times, digits: int) -> Any:
    """The times as an array: doubles where they are evenly spaced and 15 digits serve, exact numbers otherwise."""
    if digits <= 15 and not times.listed:
        return np.linspace(float(times.start), float(times.stop), times.count)
    return np.array(times.exact(), dtype=object)


def _inside(times: Times, digits: int, begins: sp.Expr, ends: sp.Expr | None) -> Any:
    array = sampled(times, digits)
    return array[_mask(array, begins, ends)]


def _mask(array: Any, begins: sp.Expr | None, ends: sp.Expr | None) -> Any:
    """Which times lie in [begins, ends)."""
    low, high = (None if t is None else float(t) if array.dtype == float else t for t in (begins, ends))
    inside = np.ones(array.shape, dtype=bool) if low is None else (array >= low).astype(bool)
    return inside if high is None else inside & (array < high).astype(bool)


def _trajectory(scene: Scene, arcs: tuple[Arc, ...], found: list[smooth.Piece]) -> Trajectory:
    """Put the states of the arcs together; a quantity is worked out when it is read."""
    assert scene.times is not None
    times = sampled(scene.times, scene.digits)
    begins = [None, *(arc.motion.t0 for arc in arcs[1:])]
    masks = [_mask(times, begin, piece.ends) for begin, piece in zip(begins, found, strict=True)]
    states = [(mask, arc, arc.motion.at(times[mask])) for mask, arc in zip(masks, arcs, strict=True) if mask.any()]
    coordinates = scene.system.coordinates
    names, angles = (tuple(c.name for c in coordinates if kind in ("any", c.domain.kind)) for kind in ("any", "angle"))

    def joined(part: Callable[[Arc, State, str], Any], name: str) -> Any:
        parts = [(mask, part(arc, state, name)) for mask, arc, state in states]
        result = np.empty(times.shape, dtype=parts[0][1].dtype if parts else float)
        for mask, values in parts:
            result[mask] = values
        return result

    def view(part: Callable[[Arc, State, str], Any], chosen: tuple[str, ...] = names) -> OnDemand:
        return OnDemand(chosen, lambda name: joined(part, name))

    def errors() -> Errors:
        bounds = {id(state): state.error for _, _, state in states}
        q, p = view(lambda _, s, n: bounds[id(s)].q[n]), view(lambda _, s, n: bounds[id(s)].p[n])
        return Errors(q, p, view(lambda _, s, n: bounds[id(s)].velocity[n]))

    number = np.zeros(times.shape, dtype=int)
    for mask, arc, _ in states:
        number[mask] = arcs.index(arc)
    return Trajectory(
        joined(lambda _a, s, _n: _numbers(s.t, scene.digits), ""), view(lambda _, s, n: s.q[n]),
        view(lambda _, s, n: s.p[n]), view(lambda _, s, n: s.velocity[n]),
        view(lambda a, s, n: s.turns[n] + a.turns.get(n, 0), angles), joined(lambda _a, s, _n: s.status, ""),
        number, errors,
    )  # fmt: skip


def _numbers(times: Any, digits: int) -> Any:
    if times.dtype == float:
        return times
    if digits <= 15:
        return np.array([float(t) for t in times])
    return np.array([to_bits(t)(bits_of(digits)) for t in times], dtype=object)
