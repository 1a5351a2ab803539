"""One branch of an open motion: its integrals from the start to its end, as far as they are asked for.

Over the parameter y of ``chebyshev_panels`` the kernels kⱼ |dq/dy|/|p| and |p|/|dq/dy|, times ``EndMap.rest``, are
analytic up to and including both ends; next to these p² is taken with as many bits more as its terms cancel.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from hjsolve.arithmetic.floats import Multi, bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.chebyshev_panels import EndMap, Panels
from hjsolve.one_coordinate.growing_panels import Growing
from hjsolve.one_coordinate.momentum_integral import swept
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.panel_integrands import Sight, Surrounding
from hjsolve.one_coordinate.time_along_a_path import TooSlowError

_MOST_BITS = 16384
"""Beyond the working precision: p² of 10⁻⁴⁹³² of its terms counts as 0, which no double and no typed number of a few
hundred digits comes near."""
_FINE = 8
"""Steps of the reach of panels in a factor of two: far out, what is not asked for may be much."""


@dataclass(frozen=True, eq=False)
class Branch:
    """One branch of an open motion, from its start to its end, with what is integrated along it."""

    end_map: EndMap
    radicand: MomentumSquared
    skipped: tuple[bool, ...]
    digits: int
    bits: int

    tabular = True

    def integrands(self, y: Mpf, extra: int = 0) -> list[Mpf]:
        """Return kernels kⱼ |dq/dy| / |p|, then |p|/|dq/dy| (times ``EndMap.rest``), at y, with so many bits more.

        Args:
            y: place on the branch.
            extra: bits above the working precision.
        """
        work = self.bits + extra
        # how near y is to either end, roughly: p² is small or large there, and its terms cancel
        x, left, _ = self.end_map.distances(y, Multi(64))
        nearest = min(v for v in (x, left) if v is not None)
        if nearest < self.end_map.length:
            # three bits for each power of two: q itself loses one of them, p² at a double zero two more
            work += 64 + 3 * int(max(0.0, -float(Multi(64).context.log(nearest / self.end_map.length, 2))))
        q, slope = self.end_map.position(y, Multi(work))
        p = self.radicand.value(q, work) ** 0.5
        weights = self.radicand.weights(q, work)
        kernels = [0 * p if skip else w * abs(slope) / p for w, skip in zip(weights, self.skipped, strict=True)]
        # |p|/|dq/dy| times a power of what is left: finite up to the end, so that Chebyshev polynomials serve
        return [*kernels, p / abs(slope) * self.end_map.rest(y, Multi(work))]

    def cancelled(self, y: Mpf, extra: int) -> int:
        """Return how many bits more than ``extra`` are needed at y, so that all digits are left of the integrands.

        Args:
            y: place on the branch.
            extra: bits above the working precision to begin with.

        Raises:
            NotConvergedError: p² is too small there.
        """
        enough, more = bits_for(self.digits, 16), extra
        # the same with twice the bits is the truth that fewer are compared with
        exact = self._seen(y, extra + 2 * self.bits)
        while True:
            lost = _disagreement(self._seen(y, more), exact)
            # all digits asked, and sixteen bits, agree
            if lost <= -enough:
                return more
            if more > _MOST_BITS:
                q = float(self.end_map.position(y, Multi(self.bits))[0])
                raise NotConvergedError(f"p² cannot be distinguished from zero near q = {q:.9g}")
            more += max(64, min(self.bits + more, lost + enough + 32))
            exact = self._seen(y, more + 2 * self.bits) if more >= extra + self.bits else exact

    def _seen(self, y: Mpf, extra: int) -> list[Mpf] | None:
        """Return the integrands; None where p² is all rounding."""
        try:
            values = self.integrands(y, extra)
        except ZeroDivisionError:
            return None
        return None if isinstance(values[-1], values[-1].context.mpc) else values

    def around(self, y: Mpf, rest: float) -> Surrounding:
        """Return what is around the place y, ``rest`` before the greatest y; see ``one_coordinate.panel_length``.

        Args:
            y: place on the branch.
            rest: what is left from there to the greatest y.
        """
        return Surrounding(self._sight, y, rest)

    @cached_property
    def _sight(self) -> Sight:
        return Sight(self.end_map, self.radicand, self.skipped, self.bits)

    def panels(self, weights: tuple[float, ...] | None, amount: float, *, partly: bool = False) -> Panels:
        """Return the integrals so far that |Σ wⱼ Gⱼ| reaches ``amount``; without weights, that y does.

        Args:
            weights: wⱼ, one a constant; None where y itself is meant.
            amount: how far the integrals must reach.
            partly: True where less will do: on the way to infinity, or to the end of a domain, the integrals are given
                as far as they can be computed.

        Raises:
            NotConvergedError: they cannot be had so far.
        """
        # an angle winds for ever on the way, but q and t settle: panels go as far as digits do
        if self.end_map.end == "fall":  # all of it, once
            return _panels(self, None, 1000 * _FINE)
        # rounded up to an eighth of an octave: requests that differ little share their panels
        power = int(np.ceil(_FINE * np.log2(max(abs(amount), 1e-290)))) + 1
        if partly and self.end_map.end != "asymptote":
            return _as_far_as_known(self, weights, power)
        if weights is None:  # powers go in steps: what they have too much may not be known
            known = _as_far_as_known(self, weights, power)
            if float(known.edges[-1]) >= amount:
                return known
        return _panels(self, weights, power)

    def swept(self, weights: tuple[float, ...] | None, amount: float) -> Panels:
        """Return panels of |P dq/dy| that reach as far as ``panels(weights, amount)``."""
        return swept(self, weights, amount)

    def carries(self, j: int) -> bool:
        """Return False where a kernel is zero all along.

        Args:
            j: position of the constant.
        """
        return not self.skipped[j]


def _disagreement(values: list[Mpf] | None, exact: list[Mpf] | None) -> int:
    """Return the largest relative difference, as a power of two."""
    if values is None or exact is None:
        return 0
    pairs = [(abs(v - e), abs(e)) for v, e in zip(values, exact, strict=True)]
    return max((e.context.mag(d / e) if e else 0 for d, e in pairs if d), default=-_MOST_BITS)


def farthest(digits: int) -> int:
    """Return the phase at which what is left of the branch to an asymptote, or of a fall, is below all digits."""
    return 60 + 2 * digits


@lru_cache(maxsize=64)
def _growing(branch: Branch) -> Growing:
    return Growing(branch.end_map, branch, digits=branch.digits, bits=branch.bits)


@lru_cache(maxsize=64)
def _panels(branch: Branch, weights: tuple[float, ...] | None, power: int) -> Panels:
    """Panels of a branch up to an amount of 2^(power/_FINE) (a pure function; the newest ones are kept)."""
    context = Multi(branch.bits).context
    limit = context.mpf(2) ** (context.mpf(power) / _FINE)
    far = Multi(branch.bits).context.mpf(2) ** 1000

    def enough(y: Mpf, integrals: list[Mpf]) -> bool:
        # what is left of the way, about e^(−y), is below all digits
        if branch.end_map.end in {"asymptote", "fall"} and y > farthest(branch.digits):
            return True
        if weights is None:
            return bool(y >= limit)
        return bool(abs(sum(w * g for w, g in zip(weights, integrals, strict=False))) > limit or y > far)

    return _growing(branch).until(enough)


@lru_cache(maxsize=64)
def _as_far_as_known(branch: Branch, weights: tuple[float, ...] | None, power: int) -> Panels:
    """Return the same, or all panels there are."""
    try:
        return _panels(branch, weights, power)
    except TooSlowError:  # what is known by then depends on the machine
        raise
    except NotConvergedError:
        return _growing(branch).known()
