"""One motion of a separable system: constants, kinds, turning points, periods, actions, and where it is at any time.

Everything is computed from Jacobi's theorem (Greenwood (5-70), (5-71)): the constants come exactly from the initial
data, each separated coordinate is classified and integrated over its anomaly (``one_coordinate/``), and q(t) inverts
the time law. No differential equation is integrated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.arithmetic.number_types import Numbers
from hjsolve.display.by_value import same
from hjsolve.display.renderers import renderer
from hjsolve.display.shown import ShownMotion
from hjsolve.errors import InternalError, InvalidInputError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion import quantities
from hjsolve.motion.initial_data import Initial
from hjsolve.motion.separated import SeparatedMotion, coordinate_start
from hjsolve.motion.state import State
from hjsolve.motion.wanted import QUANTITIES
from hjsolve.one_coordinate.allowed_regions import others
from hjsolve.solution.quadratures import Solution

if TYPE_CHECKING:
    from hjsolve.motion.angles_along import AngleVariables
    from hjsolve.motion.derivative_values import MotionDerivatives
    from hjsolve.motion.in_units import MotionInUnits


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShownMotion):
    """A motion: what each coordinate does, its constants, and states at any time. ``Solution.motion`` starts one.

    Attributes:
        separated: what each separated coordinate does, and the equations that tie them to the time.
        kinds: coordinate → libration, rotation, escape, equilibrium, asymptotic, boundary or ignorable.
        turning_points: coordinate → (lower, upper), None where there is none on that side; no key for a rotation.
        constants: name → Estimate.
        actions: coordinate → J = (1/2π) ∮ p dq over a full cycle, signed like p for a rotation.
        frequencies: coordinate → Ω = ∂H/∂J in radians per unit time, where it exists.
        periods: coordinate → 2π/abs(Ω).
        boundary_times: coordinate → time at which it reaches an end of its domain.
        states: for a certified motion, the rule that gives what its states are read from.
        given: the input as it came.
        again: the rule that starts it anew with other digits or changed input.

    Example:
        >>> motion = solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        >>> motion.kinds
        {'r': 'libration', 'theta': 'ignorable'}
        >>> round(motion.periods["r"].value, 12), motion.periods["r"].error < 1e-14
        (14.99332061038..., True)
    """

    separated: SeparatedMotion = field(repr=False)
    kinds: Mapping[str, str]
    turning_points: Mapping[str, tuple[Estimate | None, Estimate | None]]
    constants: Mapping[str, Estimate]
    actions: Mapping[str, Estimate]
    frequencies: Mapping[str, Estimate]
    periods: Mapping[str, Estimate]
    boundary_times: Mapping[str, Estimate]
    states: Callable[[], SeparatedMotion] | None = field(default=None, repr=False)
    given: Mapping[str, Any] = field(default_factory=dict, repr=False)
    again: Callable[[int, Mapping[str, object]], Motion] | None = field(default=None, repr=False)

    @property
    def solution(self) -> Solution:
        """The solution that the motion belongs to."""
        return self.separated.solution

    @property
    def initial(self) -> Initial:
        """The exact initial data and constants."""
        return self.separated.initial

    @property
    def as_solved(self) -> Motion:
        """The same motion expressed in the coordinates of its solution; itself, where those are the given ones."""
        return self

    @property
    def t0(self) -> sp.Expr:
        """The initial time, exact."""
        return self.separated.t0

    @property
    def digits(self) -> int:
        """The number of digits requested."""
        return self.separated.digits

    @property
    def nodes(self) -> int:
        """The largest number of quadrature nodes used for a coordinate."""
        return max((place.coordinate_motion.nodes for place in self.separated.located.values()), default=0)

    @property
    def mean_velocities(self) -> dict[str, Estimate]:
        """The mean velocities ⟨dq/dt⟩ of ignorable coordinates that are not angles, if all others are bounded.

        Examples are the drift of a charge in crossed fields and dt/dτ of a geodesic. Divide a frequency per unit of
        proper time by the latter to obtain that seen by a distant observer.
        """
        self._require("mean_velocities")
        source = self._source
        return quantities.mean_velocities(source.solution, source.initial, source.equations, source.digits)

    @property
    def betas(self) -> dict[str, Estimate]:
        """Jacobi's constants β (Greenwood (5-70)), by constant of the motion; that of E is t₀ of the time law (5-71).

        They refer to ``lower_limits`` and to the passage through these that is nearest to the initial data.
        """
        from hjsolve.motion.characteristic import betas

        self._require("betas")
        return betas(self._source)

    @property
    def lower_limits(self) -> dict[str, Estimate]:
        """The lower limits of the quadratures of ``betas``, by separated coordinate.

        Each is the lower or only turning point, or the position of rest. A coordinate that does not turn has its
        position at t₀.
        """
        from hjsolve.motion.characteristic import lower_limits

        return lower_limits(self._source)

    def at(self, t: object) -> State:
        """Return the state at a time or times.

        Args:
            t: number (int, float, decimal or rational string, Fraction, mpf) or an array or list of them.

        Returns:
            The state; float64 up to 15 digits, mpf above.

        Raises:
            InvalidInputError: a time that is not a finite real number.
        """
        from hjsolve.motion.placing import with_place
        from hjsolve.motion.state_at import state_at_times

        self._require("trajectory")
        return with_place(self.solution.system, self.initial.values, state_at_times(self._source, t))

    def characteristic_function(
        self, t: object = None, *, q: Mapping[str, object] | None = None, branch: Mapping[str, int] | None = None
    ) -> Estimate | EstimateArray:
        """Return Hamilton's characteristic function W = ∫ p·dq from t₀, at a time or at a position on a branch.

        Along the motion each cycle adds ∮ p·dq. At a position q the sign of the momentum of each separated coordinate
        (of p + A if the momentum is shifted) selects the branch, and ∂W/∂q = p. On a libration W is counted once round
        from the lower turning point: rising on branch +1, falling on −1. The angle of a rotation is not reduced.

        Args:
            t: number (int, float, decimal or rational string, Fraction, mpf) or an array or list of them.
            q: in place of t, the position of every coordinate: numbers or arrays, which broadcast.
            branch: +1 or −1 by separated coordinate; +1 by default if there are two.

        Returns:
            The value and its error, with the shape of t or of the positions; nan after the end of the motion.

        Raises:
            InvalidInputError: both t and q or neither, a time or position that is not a finite real number, a
                coordinate that is missing or has no branches.
            OutsideMotionError: the motion never reaches the position, or never on that branch.
        """
        from hjsolve.motion.characteristic import waves_along
        from hjsolve.motion.wave_at_places import wave_at

        self._require("characteristic_function")
        if (t is None) == (q is None) or (q is None and branch is not None):
            raise InvalidInputError("characteristic_function: give a time t, or places q (with their branch)")
        if q is not None:
            return wave_at(self.separated, q, branch or {})
        return waves_along(self._source, t, principal=False)

    def principal_function(self, t: object) -> Estimate | EstimateArray:
        """Return Hamilton's principal function along the motion, S = W − E (t − t₀) = ∫ L dt from t₀ to t.

        Args:
            t: as for ``characteristic_function``, which also describes the result and the errors.
        """
        from hjsolve.motion.characteristic import waves_along

        self._require("characteristic_function")
        return waves_along(self._source, t, principal=True)

    def time_at(self, name: str, value: object, passage: int = 0) -> Estimate:
        """Return the time at which a coordinate passes a position: the first one from t₀ on, or another passage.

        Args:
            name: coordinate.
            value: position; for an angle modulo 2π.
            passage: 0 for the first crossing at t ≥ t₀, 1 for the next, −1 for the last before t₀ …

        Raises:
            InvalidInputError: an unknown coordinate, a value that is not a number, or a passage that is not whole.
            OutsideMotionError: the motion never reaches that position, or not that often.
        """
        from hjsolve.motion.crossings import crossing_time

        self.solution.system.coordinate(name)
        self._require("periods" if name in self.separated.located else "trajectory")
        return crossing_time(self._source, name, value, passage)

    def orbit(self, name: str, *, along: str, values: object) -> Numbers:
        """Return one coordinate where another passes given values for the first time after t₀ (orbit equation).

        Args:
            name: coordinate wanted; unwrapped if it is an angle.
            along: coordinate whose values are given.
            values: positions of ``along``, shape (m,).

        Returns:
            Array of shape (m,).

        Raises:
            InvalidInputError: an unknown coordinate, or a value that is not a number.
            OutsideMotionError: the motion never reaches a value.
        """
        from hjsolve.motion.crossings import crossing_times

        for coordinate in (name, along):
            self.solution.system.coordinate(coordinate)
        times = crossing_times(self._source, along, values)
        return self.at(times).unwrapped(name)

    def angles(self, t: object) -> AngleVariables:
        """Return the angle variables θ = θ₀ + Ω (t − t₀), in (−π, π], of every coordinate that has a frequency.

        The zero of θ is the lower turning point of a libration, and for a rotation the point half a turn from its
        highest barrier, where p² is smallest. Of equal barriers the first one above 0 counts.

        Args:
            t: a time or an array of times.

        Returns:
            Coordinate → angle in radians; a number for one time, else an array of the shape of t. ``.error`` holds
            the bounds on their errors, modulo 2π.

        Raises:
            InvalidInputError: a time that is not a finite real number.
        """
        from hjsolve.motion.angles_along import angle_variables

        self._require("angles")
        return angle_variables(self._source, t)

    def derivatives(
        self, of: Iterable[str] = ("actions", "frequencies"), by: Iterable[str] = ("constants",), t: object = None
    ) -> MotionDerivatives:
        """Return derivatives of the motion, from its differentiated integrals rather than from finite differences.

        ``initial`` differentiates by each q and p at t₀ ("q.r", "p.r"). ``constants`` differentiates by those of
        ``Solution.constants``, with Jacobi's constants β fixed for the state and the angles. ``parameters``
        differentiates by those of the system, with q and canonical p at t₀ fixed. ``actions`` ("J.r") differentiates by
        the actions, which gives the Hessian of the energy for the frequencies.

        Args:
            of: of ``actions``, ``frequencies``, ``periods``, ``turning_points``, ``constants``, ``angles``, ``state``.
            by: of ``initial``, ``constants``, ``parameters``, ``actions``.
            t: a time or an array of times, for the state and the angles; t₀ where left out.

        Returns:
            ``value["frequencies"]["r"]["E"]``, for the state ``value["q"]["r"]["q.theta"]`` and ``value["p"]``;
            ``error`` alike; ``status`` says where a derivative does not exist.

        Raises:
            InvalidInputError: another name, a time that is not a finite real number, a motion without derivatives:
                one through kinks of V or through poles, or at rest where the motion next to it is not linear.
            NotConvergedError: an integral did not converge to the digits asked.
        """
        found: MotionDerivatives = renderer("derivatives").derivatives_of(self, of, by, t)
        return found

    def transition_matrix(self, t: object) -> EstimateArray:
        """Return the transition matrix ∂(q, p)(t)/∂(q, p)(t₀), in a time that does not grow with t.

        It is D(t) D(t₀)⁻¹, where D is the derivative of the state by Jacobi's constants (β, α), so it is symplectic
        by construction (Greenwood (5-53), (6-215)).

        Args:
            t: a time or an array of times.

        Returns:
            Value and error of shape (…, 2n, 2n): rows and columns are all q, then all p, in the system's order; nan
            where the motion has ended.

        Raises:
            InvalidInputError, NotConvergedError: as of ``derivatives``.
        """
        found: EstimateArray = renderer("derivatives").transition_matrix(self, t)
        return found

    def __eq__(self, other: object) -> bool:
        """Return whether both are the same motion of the same system, with the same digits and the same proofs."""
        if type(other) is not type(self):
            return NotImplemented
        one, two = self.separated, other.separated
        return (
            one.solution.system == two.solution.system
            and (one.digits, one.parts, one.t0) == (two.digits, two.parts, two.t0)
            and same(one.initial.values, two.initial.values)
            and (self.states is None) == (other.states is None)
            and same(self.constants, other.constants)
        )

    def __hash__(self) -> int:
        return hash((self.separated.solution.system, self.separated.digits, self.separated.t0))

    def to_units(self, library: object) -> MotionInUnits:
        """Return the results as quantities of pint or astropy, in the units of the system.

        Args:
            library: ``"astropy"``, ``"pint"``, a registry of pint, or any unit of one of them.

        Raises:
            InvalidInputError: no library, or the system declares no units that fit T and V.
            MissingExtraError: the library is not installed (extra ``units``).
        """
        from hjsolve.motion.in_units import MotionInUnits, measures_of

        return MotionInUnits(self, measures=measures_of(self.solution, library))

    def input_sensitivity(self) -> dict[str, dict[str, float]]:
        """Return how far each number can move when every float input moves by half an ulp.

        Returns:
            By name of a quantity and of its coordinate or constant; in the units of the number.

        Raises:
            InternalError: the motion was made without a record of its input.
        """
        from hjsolve.motion.input_sensitivity import input_sensitivities

        if self.again is None:
            raise InternalError("this motion does not know its input")
        return input_sensitivities(self.again, self.given)

    @property
    def other_regions(self) -> dict[str, tuple[tuple[Estimate | None, Estimate | None], ...]]:
        """Where else each separated coordinate could move with the same constants: other wells, and places of rest.

        Coordinate → intervals (lower, upper) in order, without the one the motion is in (``turning_points``); None for
        an end that is not a turning point. At most ``one_coordinate.allowed_regions.MOST_REGIONS`` on each side. Worked
        out when it is read.
        """
        refuse_kinks(self.solution.system.kinks, "other_regions")
        result = {}
        for name, place in self.separated.located.items():
            begin = coordinate_start(self.separated.solution, self.separated.initial, name)
            found = others(begin, place.lower, place.upper, self.digits)
            result[name] = tuple(quantities.turning_points_of(region, self.digits) for region in found)
        return result

    @property
    def _source(self) -> SeparatedMotion:
        return self.states() if self.states else self.separated

    def _require(self, quantity: str) -> None:
        if not QUANTITIES[quantity] <= self.separated.parts:
            raise InvalidInputError(f'the motion was started without {quantity}; add "{quantity}" to want')
