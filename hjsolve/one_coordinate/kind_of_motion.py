"""What every kind of motion of one coordinate answers, and the answers that most kinds share.

Every kind answers the same questions for a phase χ that grows with time: where the coordinate is, and what the
integrals Gⱼ(χ) = ∫ kⱼ dq/p are, one for each constant of the motion. Greenwood (5-70), (5-71): the motion is the set
of phases for which Σᵢ Gᵢⱼ(χᵢ) keeps its value, and grows like t for the energy.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, cast

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers, Reals

if TYPE_CHECKING:
    from hjsolve.one_coordinate.chain import Chain
    from hjsolve.one_coordinate.open_branch import Branch

Kind = Literal["libration", "rotation", "escape", "equilibrium", "asymptotic", "boundary"]
Weights = tuple[float, ...]
"""w of a sum Σ wⱼ Gⱼ, one a constant of the motion."""
PARTS = frozenset({"time", "action", "place"})
"""What is integrated over a cycle: Jacobi's integrals (periods, times), the action, what places and momenta need."""


def arithmetic_of(array: Numbers) -> Float64 | Multi:
    """Return the arithmetic in which an array of phases is held.

    Args:
        array: of doubles, or of ``mpf``.
    """
    if array.dtype != object:
        return Float64()
    return Multi(cast("Mpf", array.flat[0]).context.prec) if array.size else Float64()


def elementwise(function: Callable[..., object], χ: Numbers, outputs: int) -> Any:
    """Apply a function of a float array, or of one ``mpf`` to an object array.

    Args:
        function: gives a tuple of ``outputs`` values, or one value where that is 1.
        χ: doubles or ``mpf``, shape (m,).
        outputs: how many values the function gives.
    """
    if χ.dtype != object:
        return function(χ)
    return np.frompyfunc(function, 1, outputs)(χ)


def phase_times(growth: Elementwise, χ: Reals) -> Reals:
    """Return |growth·χ| in doubles.

    Args:
        growth: in many digits.
        χ: phases, shape (m,).
    """
    size: Elementwise = np.abs(growth * np.abs(χ))
    return size.astype(float)


class KindOfMotion(ABC):
    """A motion of one coordinate as a function of its phase.

    The questions with an answer here are those that one kind alone answers otherwise: a ``Periodic`` has a direction,
    an ``AtRest`` rests, an ``Unbounded`` has branches and ends. Each kind gives itself, or None, as its ``cycle`` (a
    libration or rotation) and as ``bounded`` (it stays between two places).

    In its methods χ are phases, shape (m,); j is the position of a constant; a side is 1 ahead and −1 behind.

    Attributes:
        kind: as in ``Motion.kinds``.
        start: χ of the initial place.
        direction: of a rotation, the sign of dq/dχ; 1 of any other.
        stable: False where it rests on top of a barrier.
        rests: True where it stays where it is.
        one_scale: True where integrals are rounded like the greatest of their values (one series), not each like its
            own (panels).
    """

    kind: Kind
    start: Mpf | int
    stable: bool
    rests: ClassVar[bool] = False
    one_scale: ClassVar[bool] = False

    @abstractmethod
    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return q (not reduced to one turn) and the shell momentum at χ."""

    @abstractmethod
    def integral(self, j: int, χ: Numbers) -> Numbers:
        """Return Gⱼ from 0 to χ."""

    @abstractmethod
    def rate(self, j: int, χ: Numbers) -> Numbers:
        """Return dGⱼ/dχ."""

    @abstractmethod
    def momentum_integral(self, χ: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Return ∫ P dq from the phase 0 to χ, |P dq/dχ|, and what rounding refers to; nan beyond the panels."""

    @abstractmethod
    def rounding_size(self, weights: Weights, χ: Reals) -> Reals:
        """Return what the rounding of Σ wⱼ Gⱼ(χ) is relative to.

        Args:
            weights: wⱼ, one a constant.
        """

    @abstractmethod
    def place_in_two_doubles(self, χ: Reals, approximate: Reals) -> Pair:
        """Return q in two doubles, at phases in doubles.

        Args:
            approximate: q in doubles.
        """

    @abstractmethod
    def place_spacing(self, χ: Reals) -> Reals:
        """Return the size that the rounding of a place in two doubles refers to."""

    @property
    def branches(self) -> tuple[Branch | Chain, ...]:
        """The two branches of an open motion, ahead and behind; none for any other motion."""
        return ()

    @property
    def direction(self) -> int:
        """The sign of dq/dχ of a rotation."""
        return 1

    @property
    def rotates(self) -> bool:
        """True where a cycle takes the coordinate round, and not back."""
        return False

    @property
    def nodes(self) -> int:
        """Quadrature nodes behind the integrals over a cycle."""
        return 0

    @property
    def signed_action(self) -> Mpf | int | None:
        """(1/2π) ∮ P dq, signed like P for a rotation; None where there is no cycle."""
        return None

    def limits(self) -> tuple[float, float]:
        """Return the least and greatest phase there is: it goes on for ever."""
        return -np.inf, np.inf

    def ends(self, side: int) -> str:
        """Return how an open motion ends, ``boundary``, ``fall``, ``asymptote`` or ``infinity``; "" without an end."""
        return self.branches[side < 0].end_map.end if self.branches else ""

    def finished(self, side: int) -> bool:  # noqa: ARG002  (asked of an open motion)
        """Return whether the last phase held is the end of the motion, not of the panels."""
        return False

    def covering(self, χ: Numbers) -> Self:  # noqa: ARG002
        """Return the motion with enough panels for some phases, on each side as far as there are any."""
        return self

    def with_reach(self, ahead: float, back: float | None = None) -> Self:  # noqa: ARG002
        """Return the motion with enough panels for phases up to a size.

        Args:
            ahead: greatest phase.
            back: greatest −χ where panels behind shall reach elsewhere.
        """
        return self

    def probes(self) -> Reals:
        """Return phases all along the motion at which the sign of an integrand is looked at."""
        return np.linspace(-3.1, 3.1, 33)

    def stations(self, side: int) -> Reals:
        """Return phases from the start outward between which a search may begin, to the farthest there is."""
        start = float(self.start)
        return np.concatenate([[start], start + side * 2.0 ** np.arange(-2, 61)])

    def phase_rounding(self, χ: Reals) -> Reals | float:  # noqa: ARG002
        """Return the rounding of the map from phases to places as an uncertainty of χ in doubles; 0 of most."""
        return 0.0

    def momentum_noise(self, χ: Reals) -> Reals | float:  # noqa: ARG002
        """Return the rounding of p next to that of its value, in units of the last place: of a sum, and of χ in it."""
        return 0.0

    def in_doubles(self) -> Self:
        """Return the motion with the series of its momentum rounded to doubles, for vectorised use."""
        return self

    def rate_noise(self, j: int) -> float:  # noqa: ARG002
        """Return what rounding in doubles leaves open of dGⱼ/dχ where it is small."""
        return 0.0

    def spacing(self, j: int, χ: Numbers) -> Reals:
        """Return the size that the rounding of an integral refers to."""
        return np.abs(np.asarray(self.integral(j, χ), dtype=float))
