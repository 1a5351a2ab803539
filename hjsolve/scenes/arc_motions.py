"""Rules that start the motion of an arc when it is read: ten thousand bounces are not ten thousand motions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hjsolve.errors import required
from hjsolve.motion.motion import Motion
from hjsolve.scenes.arcs import FreeArc, Leg, start_of
from hjsolve.scenes.question import Question
from hjsolve.scenes.reflections import signed
from hjsolve.solution.quadratures import Solution


class ArcMotion:
    """Starts the motion of an arc, once; pickled, it is started anew.

    Args:
        scene, solution: what is run.
        piece: the arc.
        want: what of the motion, where not all that the scene wants.
    """

    def __init__(self, scene: Question, solution: Solution, piece: FreeArc, want: tuple[str, ...] | None = None):
        self.given = scene, solution, piece, want
        self._leg: Leg | None = None
        self._motion: Motion | None = None

    def __reduce__(self) -> tuple[object, ...]:
        return ArcMotion, self.given

    def leg(self) -> Leg:
        """Return where the arc starts."""
        if self._leg is None:
            self._leg = start_of(self.given[2])
        return self._leg

    def __call__(self) -> Motion:
        """Give the motion."""
        if self._motion is None:
            scene, solution, _, want = self.given
            self._motion = solution.motion(
                **self.leg().arguments, digits=scene.digits, want=scene.want if want is None else want,
                certified=scene.certified,
            )  # fmt: skip
        return self._motion


class TurnsBefore(Mapping[str, int]):
    """Whole turns made before an arc, worked out when they are read.

    Args:
        arc_motion: the motion of the arc.
        angles: names.
    """

    def __init__(self, arc_motion: ArcMotion, angles: tuple[str, ...]):
        self.arc_motion, self.angles = arc_motion, angles

    def __getitem__(self, name: str) -> int:
        if name not in self.angles:
            raise KeyError(name)
        return self.arc_motion.leg().turns.get(name, 0)

    def __iter__(self) -> Iterator[str]:
        return iter(self.angles)

    def __len__(self) -> int:
        return len(self.angles)

    def __repr__(self) -> str:
        return repr(dict(self))


class FreeMotions:
    """The free motions of flights, and their mirror images, to the digits of the scene: each is made once.

    Args:
        scene, solution: what is run.
    """

    def __init__(self, scene: Question, solution: Solution):
        self.scene, self.solution, self.known = scene, solution, dict[tuple[object, ...], Motion]()
        self._shared: dict[tuple[object, ...], dict[str, object]] = {}

    def __call__(self, piece: FreeArc) -> Motion:
        """Return the free motion of a flight, of its own time zero."""
        return self._turned(piece, ())

    def shared(self, piece: FreeArc, names: tuple[str, ...]) -> Mapping[str, object]:
        """Quantities that are the same on all flights of the same signs: one table for them all."""
        motion = self.mirrored(piece)
        key = (id(motion), names)
        if key not in self._shared:
            self._shared[key] = {name: getattr(motion, name) for name in names}
        return self._shared[key]

    def mirrored(self, piece: FreeArc) -> Motion:
        """Return the motion with momenta of the signs of the flight.

        What is the same along it is the same along that motion.
        """
        signs = signed(required(piece.free), required(piece.flight).signs)
        return self._turned(piece, tuple(name for name, sign in signs.items() if sign < 0))

    def _turned(self, piece: FreeArc, names: tuple[str, ...]) -> Motion:
        free = required(piece.free)
        key = (free, names)
        if key not in self.known:
            arguments, values = {**piece.leg.arguments, "t0": 0}, free.motion.initial.values
            if names:
                p = {c.name: values[c.momentum] for c in self.scene.system.coordinates}
                arguments |= {"velocity": None, "p": {n: -x if n in names else x for n, x in p.items()}}
            self.known[key] = self.solution.motion(**arguments, digits=self.scene.digits, want=self.scene.want)
        return self.known[key]
