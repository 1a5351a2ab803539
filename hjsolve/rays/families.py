"""The verb of this room: wavefronts, orbits and caustics of the family that a motion belongs to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.by_value import ByValue
from hjsolve.display.renderers import renderer
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.motion import Motion
from hjsolve.motion.placing import PlaceFormulas
from hjsolve.motion.state import Placing
from hjsolve.motion.wanted import QUANTITIES
from hjsolve.precision import one_at_a_time
from hjsolve.rays.family_curve import FamilyCurve
from hjsolve.rays.same_constants import SameConstants, momentum_shift, started_with_same_constants
from hjsolve.rays.same_place import SamePlace, started_at_one_place

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FAMILIES = ("constants", "place")
_MOST_CURVES = 400
_ORBITS = {"constants": 12, "place": 48}


@dataclass(frozen=True, repr=False, eq=False)
class Wavefronts(ByValue, Shown):
    """Lines of equal W, orbits and caustics of a family of motions; made by ``wavefronts``.

    Attributes:
        family: ``constants``: the motions that differ in Jacobi's β alone; ``place``: all motions of the same energy
            from one place.
        fronts: lines W = const at equal steps of W.
        orbits: of the family, each orthogonal to the fronts in the kinetic metric; the first is the motion itself.
        caustics: where orbits of the family pile up: turning curves, or the envelope.
        motion: the motion asked about.
        maker: what the curves are made from.
    """

    family: str
    fronts: tuple[FamilyCurve, ...]
    orbits: tuple[FamilyCurve, ...]
    caustics: tuple[FamilyCurve, ...]
    motion: Motion = field(repr=False)
    maker: SameConstants | SamePlace = field(repr=False, compare=False)

    def _label(self) -> str:
        return f"wavefronts of the same {self.family}"

    def front(self, W: object) -> FamilyCurve:
        """Return the line on which W has a value; W is 0 at the place of the motion at t₀.

        Args:
            W: a number.

        Raises:
            InvalidInputError: no finite number.
        """
        return self.maker.fronts(np.array([_real(W, "W")]))[0]

    def front_at(self, t: object, S: object = 0) -> FamilyCurve:
        """Return where S = W − E (t − t₀) has a value at a time: the wavefront that moves.

        Args:
            t: the time.
            S: the value.

        Raises:
            InvalidInputError: no finite number.
        """
        E: Estimate = self.motion.constants["E"]
        passed = _real(t, "t") - float(self.motion.t0)
        return self.maker.fronts(np.array([_real(S, "S") + float(E.value) * passed]))[0]

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw fronts, orbits and caustics with matplotlib (extra ``report``).

        Args:
            ax: axes to draw on; None for new ones.

        Returns:
            The axes.

        Raises:
            InvalidInputError: the coordinates have no place in a plane.
            MissingExtraError: matplotlib is not installed.
        """
        return renderer("plots").plotted_wavefronts(self, ax)


@arguments.with_known_names('wavefronts(motion, "constants", fronts=24)')
@one_at_a_time
def wavefronts(motion: Motion, family: str = "constants", *, fronts: int = 24, orbits: int | None = None) -> Wavefronts:
    """Return the lines W = const about a motion, the orbits that cross them, and the caustics.

    W is Hamilton's characteristic function; along its gradient p goes the orbit, and in the metric of the kinetic
    energy the orbit is orthogonal to W = const (Greenwood section 5-2; Goldstein section 10-8). Of the family of the
    same constants everything is a quadrature, and its caustics are the turning curves. Of the family of the same place
    W is the action from there, and its caustic the envelope: of a projectile the parabola of safety.

    Args:
        motion: of two coordinates, or of two next to an ignorable one: then in the plane that turns with that.
        family: ``constants`` or ``place``.
        fronts: how many lines.
        orbits: how many orbits; of the family of a place, directions, at least 16. None for 12 and 48.

    Returns:
        The curves, each with errors.

    Raises:
        InvalidInputError: no such motion, or one with terms linear in the velocities.

    Example:
        >>> import hjsolve
        >>> motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        >>> found = wavefronts(motion)
        >>> [round(float(caustic.q["r"][0]), 6) for caustic in found.caustics]
        [1.0, 2.571429]
    """
    if not isinstance(motion, Motion):
        raise InvalidInputError(
            f"wavefronts: a Motion is needed, from solution.motion(…), not {arguments.described(motion)}"
        )
    if family not in FAMILIES:
        raise InvalidInputError(f'wavefronts: family is one of {", ".join(FAMILIES)}, not "{family}"')
    motion = motion.as_solved
    refuse_kinks(motion.solution.system.kinks, "wavefronts")
    usual = _ORBITS[family] if orbits is None else orbits
    counts = [min(_MOST_CURVES, arguments.whole(n, name, 1)) for n, name in ((fronts, "fronts"), (usual, "orbits"))]
    if not QUANTITIES["characteristic_function"] <= motion.separated.parts:
        raise InvalidInputError('wavefronts: this motion was started without W; add "characteristic_function" to want')
    if momentum_shift(motion) != 0:
        raise InvalidInputError("wavefronts: T has terms linear in the velocities, and orbits do not go along ∂W/∂q")
    maker: SameConstants | SamePlace
    if family == "place":
        maker = started_at_one_place(motion, _placing(motion), counts[1])
    else:
        maker = started_with_same_constants(motion, _placing(motion))
    lines = maker.fronts(maker.levels(counts[0]))
    return Wavefronts(family, lines, maker.orbits(counts[1]), maker.caustics(), motion, maker)


def _real(value: object, source: str) -> float:
    return float(sp.N(number(value, source=source), 30))


def _placing(motion: Motion) -> Placing | None:
    system = motion.solution.system
    place, values = system.place, motion.initial.values
    if not place:
        return None
    own = tuple((c.name, c.symbol) for c in system.coordinates)
    fixed = tuple((p.symbol, values[p.symbol]) for p in system.parameters if p.symbol in values)
    return PlaceFormulas(tuple(place), tuple(place.values()), own, fixed)
