"""A motion expressed in the user's coordinates and computed in the separated ones that were found for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.coordinates.chart import Chart
from hjsolve.errors import InternalError, InvalidInputError
from hjsolve.motion.charted.collisions import Ends, between
from hjsolve.motion.charted.state_map import state_in
from hjsolve.motion.initial_data import Initial
from hjsolve.motion.motion import Motion
from hjsolve.motion.placing import with_place
from hjsolve.motion.state import State
from hjsolve.motion.through_poles.continued_motion import ContinuedMotion
from hjsolve.motion.transformed_motion import TransformedMotion
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, eq=False, repr=False)
class ChartedMotion(TransformedMotion):
    """A motion of a system that separates in coordinates found for it (``solve(..., coordinates="find")``).

    ``at`` gives q, p and velocity in the user's coordinates; everything else is keyed by the separated ones.

    Attributes:
        ends: times of the collisions with a focus before and after t₀, between which the motion is known.
    """

    ends: Ends = (None, None)

    @property
    def solution(self) -> Solution:
        """The solution, in the separated coordinates."""
        return self.within.solution

    @property
    def initial(self) -> Initial:
        """The initial data and constants, in the separated coordinates."""
        return self.within.initial

    @property
    def as_solved(self) -> Motion:
        """The same motion expressed in the separated coordinates."""
        return self.within

    @property
    def chart(self) -> Chart:
        """How the separated coordinates are tied to the user's."""
        if self.solution.chart is None:
            raise InternalError("a charted motion of a solution without a chart")
        return self.solution.chart

    def at(self, t: object) -> State:
        """As ``Motion.at``; the state is in the user's coordinates."""
        inner, values = self.within, self.within.initial.values
        if isinstance(inner, ContinuedMotion):
            state = state_in(self.chart, values, inner.unfolded(t), inner.dropped)
        else:
            state = state_in(self.chart, values, inner.at(t))
        state = state if self.ends == (None, None) else between(self.ends, state)
        return with_place(self.chart.original, values, state)

    def characteristic_function(
        self, t: object = None, *, q: Mapping[str, object] | None = None, branch: Mapping[str, int] | None = None
    ) -> Estimate | EstimateArray:
        """As ``Motion.characteristic_function``; q and branch are those of the separated coordinates.

        W is the same in all coordinates.

        Raises:
            InvalidInputError: also for a motion that ends in a collision, or that separates in another gauge, where
                ∫ p·dq is another.
        """
        self._refuse_collision()
        return self.within.characteristic_function(t, q=q, branch=branch)

    def principal_function(self, t: object) -> Estimate | EstimateArray:
        """As ``Motion.principal_function``; the same errors as ``characteristic_function``."""
        self._refuse_collision()
        return self.within.principal_function(t)

    def _refuse_collision(self) -> None:
        if self.ends != (None, None):
            raise InvalidInputError("W and S: not given for a motion that ends in a collision with a focus")
        if self.chart.gauge != 0:
            raise InvalidInputError(
                "W and S: they depend on the gauge; motion.as_solved gives those of the gauge in which it separates, "
                f"to which Λ - Λ(t0) is to be added, Λ = {self.chart.gauge}"
            )

    def _refuse_given(self, name: str) -> None:
        own = self.chart.coordinates
        if name not in own and name in (q.name for q in self.chart.original.coordinates):
            raise InvalidInputError(
                f"{name}: passages are those of the separated coordinates, {', '.join(own)}; at(t).q[{name!r}] gives "
                f"{name} at any time"
            )
