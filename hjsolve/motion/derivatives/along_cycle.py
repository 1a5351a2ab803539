r"""How the integrals of a libration or rotation change with constants and parameters: one more derivative of each.

Between turning points a(z) and b(z) the anomaly is q(χ; z) = a + (b − a) s(χ), with s a function of χ that is kept: any
such map serves, the best one for z serves next to z too. At fixed χ

    q_b = a_b (1 − s) + b_b s,  a_b = −F_b/F_q at a,  ρ_b = (ln p)_b = (F_b + F_q q_b)/(2F),  ω_b = (ln dq/dχ)_b,
    (k_j)_b = [½ (F_jb + F_jq q_b) + ½ F_j (ω_b − ρ_b)] (dq/dχ)/p,     k_j = ½ F_j (dq/dχ)/p,

where F_b + F_q q_b vanishes with F at both ends, so that ρ_b and (k_j)_b are analytic and periodic like k_j itself, and
no term is left over from the ends. Their means are the second derivatives of the action (differentiation under the
integral sign; the midpoint rule converges as for k_j: Trefethen & Weideman, SIAM Review 56 (2014) 385, §3). A rotation
has a fixed map, q_b = 0; along a line on which p² repeats itself after L(z) it is q_b = q L_b/L.

The series are summed over one phase at once, in integers (``Waves``): cos kχ and sin kχ follow from
e^{i(k+1)χ} = e^{ikχ} e^{iχ}; each product is rounded by one unit of the last place, which grows to at most k of them.
The guard bits cover it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.fourier import smooth
from hjsolve.arithmetic.number_types import Context, Counts, Mpf, Numbers
from hjsolve.errors import NotConvergedError, required
from hjsolve.motion.derivatives.bounded import Bounded, converted, stacked
from hjsolve.motion.derivatives.formulas import AtPlace, Evaluation, SquareDerivatives
from hjsolve.motion.derivatives.slopes import Slopes
from hjsolve.one_coordinate.coordinate_motion import Periodic
from hjsolve.one_coordinate.fourier_series import FourierSeries, fit
from hjsolve.one_coordinate.phase_map import Place

_GUARD = 24  # bits beyond those that terms and products lose


class Waves:
    """Series with coefficients of many digits, and bounds on the terms they lack."""

    def __init__(self, series: Sequence[FourierSeries], lacks: Sequence[float], bits: int):
        """Keep the series.

        Args:
            series: over one phase.
            lacks: absolute bounds on what each leaves out.
        """
        self.series, self.lacks, self.bits = tuple(series), np.array(lacks), bits
        self.context = multiprecision(bits)

    def means(self) -> Bounded:
        """Return all means."""
        return Bounded(self._means, self.lacks)

    def at(self, χ: NDArray[np.object_], full: NDArray[np.object_]) -> tuple[Bounded, Bounded]:
        """Return all functions, and all their integrals from the phase 0, shape (series, m) each.

        Args:
            χ: phases near [−π, π], shape (m,).
            full: the same with their turns.
        """
        count, mean, unit = len(self._means), self._means[:, None], np.array([[self.context.mpf(1)]], dtype=object)
        lacks = self.lacks[:, None]
        spread = 1 + np.abs(full).astype(float)[None, :]
        if not self._terms:
            values = mean * unit + 0 * χ[None, :]
            return Bounded(values, lacks + 0 * spread), Bounded(mean * full[None, :], lacks * spread)
        cosine, sine = self._waves(χ)
        (C, S), (Ck, Sk) = self._fixed
        # ∫ cos kχ = sin kχ/k and ∫ sin kχ = (1 − cos kχ)/k from 0: no second pass over the phases
        one = 1 << self._work
        librations = self._scaled(C @ cosine + S @ sine, count)
        heights = self._scaled(Ck @ sine + Sk @ (one - cosine), count)
        return Bounded(mean + librations, lacks + 0 * spread), Bounded(mean * full[None, :] + heights, lacks * spread)

    def _scaled(self, whole: Numbers, count: int) -> Numbers:
        result = np.empty(whole.shape, dtype=object)
        for k in range(count):
            shift = -self._shifts[k] - self._work
            result[k] = [self.context.mpf((int(x), shift)) for x in whole[k]]
        return result

    @cached_property
    def _means(self) -> Numbers:
        return np.array([self.context.mpf(0) + s.mean for s in self.series], dtype=object)

    @cached_property
    def _terms(self) -> int:
        return max((len(s.cosines) for s in self.series), default=0)

    @cached_property
    def _work(self) -> int:
        return self.bits + 2 * self._terms.bit_length() + _GUARD

    @cached_property
    def _shifts(self) -> list[int]:
        return [self._work - int(self.context.mag(largest)) if largest else 0 for largest in map(_largest, self.series)]

    @cached_property
    def _fixed(self) -> tuple[tuple[Numbers, Numbers], tuple[Numbers, Numbers]]:
        """Coefficients of cosines and sines as whole numbers; the same over k."""
        shape, c = (len(self.series), self._terms), self.context
        tables = tuple(np.zeros(shape, dtype=object) for _ in range(4))
        # each series is scaled by its own largest term, so that small ones keep their digits as whole numbers
        for row, (s, shift) in enumerate(zip(self.series, self._shifts, strict=True)):
            for table, part in ((0, s.cosines), (1, s.sines)):
                for k, x in enumerate(part if part is not None else ()):
                    number = c.ldexp(c.convert(x), shift)
                    tables[table][row, k] = int(c.nint(number))
                    tables[table + 2][row, k] = int(c.nint(number / (k + 1)))
        return (tables[0], tables[1]), (tables[2], tables[3])

    def _waves(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        work, fine = self._work, multiprecision(self._work + 8)
        cosine, sine = (np.empty((self._terms, len(χ)), dtype=object) for _ in range(2))
        for m, phase in enumerate(χ):
            x, y = (int(fine.nint(fine.ldexp(part, work))) for part in fine.cos_sin(fine.convert(phase)))
            a, b = x, y
            # products of whole numbers, much cheaper than a cosine of many digits for each k
            for k in range(self._terms):
                cosine[k, m], sine[k, m] = a, b
                a, b = (a * x - b * y) >> work, (a * y + b * x) >> work
        return cosine, sine


def _largest(series: FourierSeries) -> object:
    parts = [series.cosines] if series.sines is None else [series.cosines, series.sines]
    return max((abs(x) for part in parts for x in part), default=0)


_MORE, _ATTEMPTS = 1.5, 6
"""Nodes are made so many times more as long as the last coefficients are too large, and so often."""
_LOST = 4
"""Digits that second derivatives may have fewer than the integrals they are derivatives of."""
_STEP = 2.0**-60
"""Of a phase, by which the slopes of functions are measured that only serve error bounds."""


@dataclass(frozen=True, eq=False)
class CycleVariations:
    """A libration or rotation with the derivatives of its integrals.

    Attributes:
        coordinate_motion: the motion of the coordinate.
        rule: F and its derivatives.
        scale: (ln L)_b of a rotation along a line, one a variable.
        ends: a_b and b_b; none of a rotation.
        waves: series of k_b, one a variable (the constants first), then of (k_j)_b with b inside j, then of ρ_b.
        context: of the numbers.
    """

    coordinate_motion: Periodic
    rule: Evaluation
    scale: Sequence[Mpf | int]
    ends: tuple[list[Mpf], list[Mpf]] | None
    waves: Waves
    context: Context

    rests = False

    @property
    def _shape(self) -> tuple[int, int]:
        return self.rule.constants, len(self.scale)

    def means(self) -> Bounded:
        """Return J_b = ∂J/∂z_b of the unsigned action, shape (variables,)."""
        return self.waves.means()[: self._shape[1]]

    def second_means(self) -> Bounded:
        """Return ∂²J/∂κ_j∂z_b, shape (constants, variables)."""
        n, count = self._shape
        found = self.waves.means()[count : count + n * count]
        return Bounded(found.value.reshape(n, count), found.error.reshape(n, count))

    def slopes(self, χ: Numbers, whole: Counts, errors: Numbers) -> Slopes:
        """Return how place, momentum and integrals change with the phase and with the variables.

        Args:
            χ: phases near [−π, π], shape (m,).
            whole: turns beside them, shape (m,).
            errors: bounds on the errors of χ, shape (m,).
        """
        context = self.context
        χ = converted(χ, context)
        m = len(χ)
        # slopes by the phase serve error bounds alone: difference quotients are enough
        both = self._functions(np.concatenate([χ, χ + context.mpf(_STEP)]), np.concatenate([whole, whole]))
        here, beside = (Slopes(*(part[..., k : k + m] for part in both)) for k in (0, m))
        return here.with_phase_errors(beside, errors.astype(float), _STEP)

    def _functions(self, χ: NDArray[np.object_], whole: Counts) -> Slopes:
        context, coordinate_motion, π = self.context, self.coordinate_motion, self.context.pi
        q, p = coordinate_motion.place(χ)
        full: NDArray[np.object_] = χ + 2 * π * whole.astype(object)
        if coordinate_motion.rotates:
            q = q + coordinate_motion.length_of_turns(whole, q)
        ratio: NDArray[np.object_] = (
            coordinate_motion.ratio(χ) / coordinate_motion.radian**2
        )  # without the rate of a phase ψ
        lack = float(coordinate_motion.momentum.tail) * max(1.0, coordinate_motion.momentum.size)
        rate = np.array([self._rate(x) for x in χ], dtype=object)
        at = [self.rule.at(x) for x in q]
        turn = np.array([place.slope for place in at], dtype=object) * rate / ratio / 2
        momentum = Bounded(p, lack * np.abs(p).astype(float))
        n, count = self._shape
        values, integrals = self.waves.at(χ, full)
        second = integrals[count : count + n * count]
        return Slopes(
            Bounded.exact(converted(p / ratio * rate, context)),
            Bounded(turn, lack * np.abs(turn).astype(float)),
            values[:n],
            stacked([self._place_by(b, q) for b in range(count)]),
            momentum * values[count + n * count :],
            Bounded(second.value.reshape(n, count, -1), second.error.reshape(n, count, -1)),
        )

    def _rate(self, χ: Mpf) -> Mpf | int:
        arithmetic = Multi(self.context.prec)
        turn = 2 * self.context.pi
        place = self.coordinate_motion.anomaly.place(χ - turn * self.context.nint(χ / turn), arithmetic)
        return cast("Mpf | int", place.rate)

    def _place_by(self, b: int, q: Any) -> Bounded:
        if self.ends is None:
            return Bounded.exact(q * self.scale[b])
        a, c = self.coordinate_motion.turning_points
        low, high = self.ends[0][b], self.ends[1][b]
        # s = (q − a)/(c − a) is kept: between the ends the place moves by their mean, weighted with it
        return Bounded.exact(converted((low * (c - q) + high * (q - a)) / (c - a), self.context))


def cycle_variations(
    coordinate_motion: Periodic, formulas: SquareDerivatives, scale: Sequence[Mpf | int], digits: int
) -> CycleVariations:
    """Differentiate the integrals of a libration or rotation.

    Args:
        coordinate_motion: integrated to many digits.
        formulas: of its coordinate.
        scale: (ln L)_b, one a variable: how the length of a turn changes along a line; zeros of an angle.
        digits: wanted of the series.

    Raises:
        NotConvergedError: the series do not fall to the digits wanted.
    """
    bits = _bits(coordinate_motion)
    context, rule = multiprecision(bits), formulas.bound(bits)
    ends = None
    if not coordinate_motion.rotates:
        ends = tuple(_end_by(rule.at(context.convert(end))) for end in coordinate_motion.turning_points)
    # ω_b and ρ_b are as analytic as p itself: its number of nodes is where to begin; that of p dq/dχ too, since p and
    # k_j may be constant over the elliptic map of a pendulum, and then tell nothing of its strip
    known = (coordinate_motion.momentum, required(coordinate_motion.density))
    nodes = max(*(s.nodes for s in known), coordinate_motion.nodes, 8)
    for _ in range(_ATTEMPTS):
        rows, sizes = zip(
            *(
                _values(coordinate_motion, rule, scale, ends, place)
                for place in coordinate_motion.anomaly.places(nodes, Multi(bits))
            ),
            strict=True,
        )
        floors = [max(column) for column in zip(*sizes, strict=True)]
        series = fit(rows, even=coordinate_motion.anomaly.even, digits=digits, bits=bits, floors=floors)
        if max(float(s.tail) for s in series) <= 10.0 ** (_LOST - digits):
            break
        nodes = smooth(int(_MORE * nodes))
    else:
        raise NotConvergedError("the derivatives of the integrals over a cycle did not converge to the digits asked")
    largest = [max(floor, *(abs(float(row[k])) for row in rows)) for k, floor in enumerate(floors)]
    lacks = [4 * size * max(float(s.tail), 10.0**-digits) for s, size in zip(series, largest, strict=True)]
    return CycleVariations(coordinate_motion, rule, scale, ends, Waves(series, lacks, bits), context)  # type: ignore[arg-type]


def _bits(coordinate_motion: Periodic) -> int:
    anomaly = coordinate_motion.anomaly
    inner: Any = getattr(anomaly, "inner", anomaly)
    number = inner.lower if not coordinate_motion.rotates else inner.slow
    return int(number.context.prec)


def _end_by(at: AtPlace) -> list[Mpf]:
    """How a turning point moves: a_b = −F_b/F_q."""
    return [-by / at.slope for by in at.by]


def _values(
    coordinate_motion: Periodic,
    rule: Evaluation,
    scale: Sequence[Mpf | int],
    ends: tuple[list[Mpf], ...] | None,
    place: Place,
) -> tuple[list[Mpf | None], list[float]]:
    """k_b, then (k_j)_b, then ρ_b at one node, per unit of the phase ψ; and the sizes of what they are sums of."""
    radian, n = coordinate_motion.radian, rule.constants
    q = place.q * radian
    at = rule.at(cast("Mpf", q))
    speed = abs(cast("Mpf", place.speed)) * place.rate * radian
    weight = speed / at.value**0.5 / 2
    if ends is None:
        moved, stretched = [s * q for s in scale], scale
    else:
        width = coordinate_motion.turning_points[1] - coordinate_motion.turning_points[0]
        below, above = cast("Mpf", place.below) / width, cast("Mpf", place.above) / width
        moved = [low * above + high * below for low, high in zip(*ends, strict=True)]
        stretched = [(high - low) / width for low, high in zip(*ends, strict=True)]
    growth = [(by + at.slope * m) / (2 * at.value) for by, m in zip(at.by, moved, strict=True)]
    length = abs(q) if ends is None else width
    relative = [float(abs(move) / length) if length else 0.0 for move in moved]
    second, sizes = [], []
    for j in range(n):
        for b, move in enumerate(moved):
            terms = at.mixed[j][b] * weight, at.slope_by[j] * move * weight, at.by[j] * stretched[b] * weight
            own = at.by[j] * growth[b] * weight
            second.append(terms[0] + terms[1] + terms[2] - own)
            sizes.append(float(sum(map(abs, terms)) + abs(own) + abs(at.by[j]) * weight * relative[b]))
    density = 2 * weight * at.value  # where turns change their length p_b dq is not periodic, (p dq)_b is
    first = [density * (growth[b] + scale[b]) if scale[b] else by * weight for b, by in enumerate(at.by)]
    return [*first, *second, *growth], [*[0.0] * len(moved), *sizes, *relative]
