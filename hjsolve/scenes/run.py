"""The run of a scene: its arcs, the quantities it wants of each, and the state at its times."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.errors import InvalidInputError, MissingValueError, NotSeparableError
from hjsolve.initial import to_bits
from hjsolve.motion import Motion
from hjsolve.numeric.counting import counted
from hjsolve.numeric.estimate import Estimate
from hjsolve.scenes.arcs import Leg, Piece, pieces, start_of
from hjsolve.scenes.crossing import bits_of
from hjsolve.scenes.flights import signed
from hjsolve.scenes.orbits import orbit_table
from hjsolve.scenes.path import belongings, sampled, trajectory
from hjsolve.scenes.refusal import dissipative, words
from hjsolve.scenes.results import Arc, Choice, Run, Trajectory
from hjsolve.scenes.scene import Scene
from hjsolve.solution import Solution, solve
from hjsolve.trajectory.dense import OnDemand

__all__ = ["Arc", "Choice", "Run", "Trajectory", "first_arguments", "run", "sampled", "solved"]
_FIELDS = (
    "constants", "kinds", "turning_points", "actions", "periods", "frequencies", "mean_velocities", "boundary_times",
)  # fmt: skip
_TIMED, _OWN = frozenset({"trajectory", "angles"}), frozenset({"angles", "orbit", "boundary_times"})
"""What needs times inside an arc; what is not the same on all arcs of one free motion."""


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
        found, rest = pieces(scene, solution, first_arguments(scene))
        wholes = _Wholes(scene, solution)
        busy = np.zeros(len(found) + 1, dtype=bool)
        if scene.times is not None and {"trajectory", "angles"} & set(scene.want):
            busy[belongings(sampled(scene.times, scene.digits), found, rest)] = True
        last = None if rest is None else rest.time
        arcs = tuple(
            _arc(scene, solution, piece, bool(timed), wholes, last if piece is found[-1] else None)
            for piece, timed in zip(found, busy, strict=False)
        )
        path = trajectory(scene, arcs, found, rest, wholes) if "trajectory" in scene.want else None
    return Run(scene, solution, arcs, path, {}, work, rest=rest)


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


class _Wholes:
    """The free motions of flights, and their mirror images, to the digits of the scene: each is made once."""

    def __init__(self, scene: Scene, solution: Solution):
        self.scene, self.solution, self.known = scene, solution, dict[tuple[Any, ...], Motion]()

    def __call__(self, piece: Piece, signs: Mapping[str, int] | None = None) -> Motion:
        """Of its own time zero; with momenta of other signs, if given."""
        assert piece.free is not None
        turned = tuple(name for name, sign in (signs or {}).items() if sign < 0)
        key = (piece.free, turned)
        if key not in self.known:
            arguments, values = {**piece.leg.arguments, "t0": 0}, piece.free.motion.initial.values
            if turned:
                p = {c.name: values[c.momentum] for c in self.scene.system.coordinates}
                arguments |= {"velocity": None, "p": {n: -x if n in turned else x for n, x in p.items()}}
            self.known[key] = self.solution.motion(**arguments, digits=self.scene.digits, want=self.scene.want)
        return self.known[key]


def _arc(
    scene: Scene, solution: Solution, piece: Piece, timed: bool, wholes: _Wholes, rest: Estimate | None
) -> Arc:
    """Compute what is wanted of an arc."""

    def made(leg: Leg) -> Motion:
        return solution.motion(**leg.arguments, digits=scene.digits, want=scene.want, certified=scene.certified)

    names = [n for n in (*_FIELDS, "angles", "orbit") if n in scene.want and (n != "angles" or scene.times)]
    ends = rest if rest is not None else None if piece.ends is None else _moment(piece.ends, scene.digits)
    if piece.flight is None:
        motion = cache(lambda: made(piece.leg))
        source = motion if timed or not _TIMED & set(scene.want) else cache(lambda: _untimed(scene, solution, piece))
        begins = _moment(sp.sympify(piece.leg.arguments.get("t0", 0)), scene.digits)
        quantities = {name: _quantity(scene, piece, name, source() if name not in _TIMED else motion())
                      for name in names}  # fmt: skip
        return Arc(begins, ends, piece.events, piece.leg.turns, quantities, motion)
    flight, free = piece.flight, piece.free
    assert free is not None
    leg = cache(lambda: start_of(piece))
    motion = cache(lambda: made(leg()))
    angles = tuple(c.name for c in scene.system.coordinates if c.domain.kind == "angle")

    def shared(name: str) -> Any:
        whole = motion() if name in _OWN else wholes(piece, signed(free, flight.signs))
        return _quantity(scene, piece, name, whole)

    begins = _moment(flight.begin, scene.digits, flight.doubt)
    turns = OnDemand(angles, lambda name: leg().turns.get(name, 0))
    return Arc(begins, ends, piece.events, turns, OnDemand(tuple(names), shared), motion)


def _untimed(scene: Scene, solution: Solution, piece: Piece) -> Motion:
    """The motion of an arc without a wanted time, for its quantities alone."""
    want = [word for word in scene.want if word not in _TIMED]
    return solution.motion(**piece.leg.arguments, digits=scene.digits, want=want, certified=scene.certified)


def _quantity(scene: Scene, piece: Piece, name: str, motion: Motion) -> Any:
    if name == "angles":
        assert scene.times is not None
        array = sampled(scene.times, scene.digits)
        return motion.angles(array[_mask(array, motion.t0, piece.ends)])
    return orbit_table(scene.orbit, motion) if name == "orbit" else getattr(motion, name)


def _mask(array: Any, begins: Any, ends: Any) -> Any:
    """Which times lie in [begins, ends)."""
    low, high = (t if t is None or array.dtype != float else float(t) for t in (begins, ends))
    inside = (array >= low).astype(bool)
    return inside if high is None else inside & (array < high).astype(bool)


def _moment(time: Any, digits: int, doubt: Any = 0) -> Estimate:
    """A time, exact or in many digits, as a number with its error."""
    value = to_bits(time)(bits_of(max(digits, 15))) if isinstance(time, sp.Expr) else time
    if digits <= 15:
        known = isinstance(time, sp.Rational) and sp.Rational(float(value)) == time
        return Estimate(float(value), 0.0 if known else abs(float(value)) * 2.0**-52 + float(doubt))
    return Estimate(value, abs(value) * value.context.mpf(10) ** -digits + doubt)
