"""A motion told in the user's coordinates and computed in the separated ones that were found for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.arithmetic.number_types import Numbers
from hjsolve.coordinates.chart import Chart
from hjsolve.errors import InternalError, InvalidInputError
from hjsolve.motion.charted.collisions import Ends, between
from hjsolve.motion.charted.state_map import state_in
from hjsolve.motion.initial_data import Initial
from hjsolve.motion.motion import Motion
from hjsolve.motion.placing import with_place
from hjsolve.motion.state import State
from hjsolve.motion.through_poles.continued_motion import ContinuedMotion
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, eq=False, repr=False)
class ChartedMotion(Motion):
    """A motion of a system that separates in coordinates found for it (``solve(..., coordinates="find")``).

    ``at`` gives q, p and velocity in the user's coordinates; everything else is keyed by the separated ones.

    Attributes:
        within: the motion in the separated coordinates.
        ends: times of the collisions with a focus before and after t₀, between which the motion is told.
    """

    within: Motion | None = field(default=None, repr=False)
    ends: Ends = (None, None)

    @property
    def solution(self) -> Solution:
        """What is solved, in the separated coordinates."""
        return self._inner.solution

    @property
    def initial(self) -> Initial:
        """The initial data and constants, in the separated coordinates."""
        return self._inner.initial

    @property
    def as_solved(self) -> Motion:
        """The same motion told in the separated coordinates."""
        return self._inner

    @property
    def chart(self) -> Chart:
        """How the separated coordinates are tied to the user's."""
        if self.solution.chart is None:
            raise InternalError("a charted motion of a solution without a chart")
        return self.solution.chart

    def at(self, t: object) -> State:
        """Return the state at a time or times, in the user's coordinates.

        Args:
            t: number (int, float, decimal or rational string, Fraction, mpf) or an array or list of them.

        Returns:
            The state; float64 up to 15 digits, mpf above.

        Raises:
            InvalidInputError: a time that is no finite real number.
        """
        inner, values = self._inner, self._inner.initial.values
        if isinstance(inner, ContinuedMotion):
            state = state_in(self.chart, values, inner.unfolded(t), inner.dropped)
        else:
            state = state_in(self.chart, values, inner.at(t))
        state = state if self.ends == (None, None) else between(self.ends, state)
        return with_place(self.chart.original, values, state)

    def characteristic_function(
        self, t: object = None, *, q: Mapping[str, object] | None = None, branch: Mapping[str, int] | None = None
    ) -> Estimate | EstimateArray:
        """Return W = ∫ p·dq from t₀ to a time or times, or at places; it is the same in all coordinates.

        Args:
            t: number (int, float, decimal or rational string, Fraction, mpf) or an array or list of them.
            q: instead of t: separated coordinate → places; branches belong to separated coordinates.
            branch: separated coordinate → +1 or −1.

        Raises:
            InvalidInputError: a time or place that is no finite real number, a motion that ends in a collision, or that
                separates in another gauge, where ∫ p·dq is another.
        """
        self._refuse_collision()
        return self._inner.characteristic_function(t, q=q, branch=branch)

    def principal_function(self, t: object) -> Estimate | EstimateArray:
        """Return S = W − E (t − t₀) at a time or times; it is the same in all coordinates.

        Args:
            t: number (int, float, decimal or rational string, Fraction, mpf) or an array or list of them.

        Raises:
            InvalidInputError: a time that is no finite real number, a motion that ends in a collision, or one that
                separates in another gauge, where ∫ p·dq is another.
        """
        self._refuse_collision()
        return self._inner.principal_function(t)

    def _refuse_collision(self) -> None:
        if self.ends != (None, None):
            raise InvalidInputError("W and S: not given for a motion that ends in a collision with a focus")
        if self.chart.gauge != 0:
            raise InvalidInputError(
                "W and S: they depend on the gauge; motion.as_solved gives those of the gauge in which it separates, "
                f"to which Λ - Λ(t0) is to be added, Λ = {self.chart.gauge}"
            )

    def time_at(self, name: str, value: object, passage: int = 0) -> Estimate:
        """Return the time of the passage-th crossing of a position of a separated coordinate, counted from t₀ on.

        Args:
            name: separated coordinate.
            value: position; for an angle modulo 2π.
            passage: 0 for the first crossing at t ≥ t₀, 1 for the next, −1 for the last before t₀ …

        Raises:
            InvalidInputError: an unknown coordinate, a value that is no number, or a passage that is not whole.
            OutsideMotionError: the motion never reaches that position, or not that often.
        """
        self._refuse_given(name)
        return self._inner.time_at(name, value, passage)

    def orbit(self, name: str, *, along: str, values: object) -> Numbers:
        """Return one separated coordinate where another passes given values for the first time after t₀.

        Args:
            name: separated coordinate wanted; unwrapped if it is an angle.
            along: separated coordinate whose values are given.
            values: positions of ``along``, shape (m,).

        Returns:
            Array of shape (m,).

        Raises:
            InvalidInputError: an unknown coordinate, or a value that is no number.
            OutsideMotionError: the motion never reaches a value.
        """
        for coordinate in (name, along):
            self._refuse_given(coordinate)
        return self._inner.orbit(name, along=along, values=values)

    @property
    def _inner(self) -> Motion:
        if self.within is None:
            raise InternalError("a charted motion without the motion it is computed from")
        return self.within

    def _refuse_given(self, name: str) -> None:
        own = self.chart.coordinates
        if name not in own and name in (q.name for q in self.chart.original.coordinates):
            raise InvalidInputError(
                f"{name}: passages are those of the separated coordinates, {', '.join(own)}; at(t).q[{name!r}] gives "
                f"{name} at any time"
            )
