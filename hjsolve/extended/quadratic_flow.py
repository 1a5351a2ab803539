"""The motion of a system whose H is of second degree in q and p, with coefficients that depend on the time.

ż = A(t) z + b(t) is integrated by Taylor series, each step with a proved remainder. Let |A(s)| ≤ M and |b(s)| ≤ β for
complex |s − t_k| ≤ ρ (disk arithmetic on the formulas). Then |z(s)| ≤ (|z_k| + ρβ) e^{Mρ} =: Z there, so that the
Taylor coefficients of z are at most Z ρ^{−j} (Cauchy), and a series cut after h^J leaves at most

    Z (h/ρ)^{J+1}/(1 − h/ρ),   |h| < ρ.

An error grows by at most e^{∫ν}, ν(t) = |½ (A + Aᵀ)|, in Euclid's norm (the logarithmic norm, Dahlquist 1958), after a
constant scaling of p that makes q and p alike. More digits are carried until the bound at the end is small enough.
So S = ½ q·A q + B·q + C
need not be known in closed form to be exact (Greenwood P6-13 and Ex 2-5 are driven oscillators of this kind):

    A = P_q Q_q⁻¹,   B = Q_q⁻ᵀ α + g_p − A g_q,   ∂S/∂q = A q + B

with Q_q, P_q the derivatives of q(t) and p(t) by q(t₀), g the motion from z = 0, and α = p(t₀) constant. C is the
action of the motion g_α from q(t₀) = 0 less ½ q·Aq + B·q at its place. H = H₂ + h·z + H₀, sorted by degree in z, has
p·q̇ − H = ½ d(p·q)/dt − ½ h·z − H₀, so that one more linear equation gives it:

    C = w − ½ q·B along g_α,   ẇ = −½ h(t)·z − H₀(t),   w(t₀) = 0
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.complex_disks import Disks, single
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.arithmetic.power_series import FloatingPoint, SeriesProgram
from hjsolve.errors import NotConvergedError
from hjsolve.extended.ends_of_domains import Approach, Wall, first_end
from hjsolve.lowering import lower
from hjsolve.motion.charted.collisions import Ends
from hjsolve.motion.initial_data import to_bits

_RATIO = 4
"""ρ/h: each term of the series is at most a quarter of the one before in the bound."""
_MOST_STEPS, _LEAST_RADIUS = 20_000, 2.0**-40


@dataclass(frozen=True)
class QuadraticFlow:
    """ż = A(t) z + b(t), exact formulas in the time.

    Attributes:
        matrix: A, shape (m, m).
        force: b, shape (m, 1).
        time: the symbol of the time.
    """

    matrix: sp.ImmutableMatrix
    force: sp.ImmutableMatrix
    time: sp.Symbol

    def integrate(
        self,
        starts: list[list[sp.Expr]],
        t0: sp.Expr,
        times: list[sp.Expr],
        digits: int,
        walls: Sequence[Wall] = (),
    ) -> tuple[list[list[list[Mpf]]], list[Mpf], Ends]:
        """Follow several initial states to several times.

        Args:
            starts: states at t0, exact.
            times: exact, in any order.
            digits: of the numbers, relative to the largest.
            walls: ends of domains, which the first of the states is not followed beyond.

        Returns:
            For each time the states, and a bound on the error of each of their numbers; of no meaning beyond the first
            and last time, which are None where no wall is met.

        Raises:
            NotConvergedError: a coefficient is singular before a time is reached, or too many steps would be needed.
        """
        span = [float(to_bits(t - t0)(64)) for t in times]
        for extra in (10, 20, 40, 80, 160, 320):
            found, bounds, ends = self._followed(starts, t0, times, span, digits + extra, walls)
            sizes = [max([abs(x) for z in states for x in z] + [1]) for states in found]
            if all(e <= size * e.context.mpf(10) ** -(digits + 1) for e, size in zip(bounds, sizes, strict=True)):
                return found, bounds, ends
        raise NotConvergedError("explicit time: the error grows too fast for the digits wanted; ask for earlier times")

    def _followed(
        self,
        starts: list[list[sp.Expr]],
        t0: sp.Expr,
        times: list[sp.Expr],
        span: list[float],
        digits: int,
        walls: Sequence[Wall],
    ) -> tuple[list[list[list[Mpf]]], list[Mpf], Ends]:
        found: list[Any] = [None] * len(times)
        bounds: list[Any] = [None] * len(times)
        ends = []
        for sign in (1, -1):
            chosen = [k for k, x in enumerate(span) if x * sign >= 0 and found[k] is None]
            walk = _Walk(self, starts, t0, digits, walls)
            for k in sorted(chosen, key=lambda k: abs(span[k])):
                walk.to(times[k])
                found[k], bounds[k] = walk.states(), walk.error
            ends.append(walk.end)
        return found, bounds, (ends[1], ends[0])

    def size_around(self, t: float, radius: float) -> tuple[float, float]:
        """Return a bound on |A| over a disk about a time, and its radius: smaller where a formula is singular in it.

        Args:
            radius: the greatest radius.

        Raises:
            NotConvergedError: A or b is singular at the time, or next to it.
        """
        while radius > _LEAST_RADIUS:
            A, b = self._bounds(t, radius)
            if np.isfinite(A) and np.isfinite(b) and A * radius <= 8:
                return A, radius
            radius /= 2
        raise NotConvergedError(f"explicit time: a coefficient of H is singular at or next to t = {t:.6g}")

    def _bounds(self, t: float, radius: float) -> tuple[float, float]:
        """Norms of A and b over a disk."""
        m = self.matrix.rows
        sizes = self._sizes([*self.matrix, *self.force], t, radius)
        return float(sizes[: m * m].reshape(m, m).sum(axis=1).max()), float(sizes[m * m :].max())

    def growth(self, t: float, radius: float, scale: sp.Expr) -> float:
        """Return a bound on ν = |½ (A + Aᵀ)| over the times within a radius, p measured in units of ``scale``.

        Args:
            radius: of the interval.
            scale: positive number.
        """
        m, n = self.matrix.rows, self.matrix.rows // 2
        D = sp.diag(*([sp.S.One] * n), *([1 / scale] * n))
        A = D * self.matrix * D.inv()
        sizes = self._sizes(list((A + A.T) / 2), t, radius).reshape(m, m)
        return float(min(np.sqrt((sizes**2).sum()), sizes.sum(axis=1).max()))

    def _sizes(self, entries: list[sp.Expr], t: float, radius: float) -> Reals:
        tape = lower(entries, [self.time])
        with np.errstate(all="ignore"):
            disks = tape.run(Disks(), [single(complex(t), radius)])
        return np.array([float(np.max(d.largest)) if bool(np.all(d.known)) else np.inf for d in disks])

    def scale(self, t: float) -> sp.Expr:
        """Return a unit of momentum, √(k m) as a number: the root of |A_pq|/|A_qp| at a time."""
        n = self.matrix.rows // 2
        A = np.array(self.matrix.subs(self.time, sp.Float(t)).evalf(8).tolist(), dtype=float)
        stiff, light = np.abs(A[n:, :n]).sum(), np.abs(A[:n, n:]).sum()
        known = np.isfinite([stiff, light]).all() and stiff > 0 and light > 0
        return sp.Rational(str(float(f"{np.sqrt(stiff / light):.2g}"))) if known else sp.S.One


def with_action(flow: QuadraticFlow, rest: sp.Expr) -> QuadraticFlow:
    """Return the flow of (q, w, p, 1) with ẇ = −½ h·z − H₀: w + ½ (p·q − p₀·q₀) is the action ∫ p·q̇ − H dt.

    Args:
        flow: of (q, p), with the slope h of H at z = 0 as its force: b = J h.
        rest: H₀(t).
    """
    m, n = flow.matrix.rows, flow.matrix.rows // 2
    h = [*(-flow.force[n:, :]), *flow.force[:n, :]]
    order = [*range(n), m, *range(n, m), m + 1]
    A = sp.zeros(m + 2, m + 2)
    A[:m, :m], A[:m, m + 1] = flow.matrix, flow.force
    A[m, :m], A[m, m + 1] = -sp.Matrix([h]) / 2, -rest
    return QuadraticFlow(A[order, :][:, order].as_immutable(), sp.zeros(m + 2, 1).as_immutable(), flow.time)


class _Walk:
    """The states at one time, carried from step to step with a bound on their error."""

    def __init__(
        self, flow: QuadraticFlow, starts: list[list[sp.Expr]], t0: sp.Expr, digits: int, walls: Sequence[Wall] = ()
    ):
        self._flow, self._digits, self._walls = flow, digits, walls
        self.end: Estimate | None = None
        self._bits = int(3.33 * digits) + 40
        self._context = multiprecision(self._bits)
        self._program: SeriesProgram[Mpf] = SeriesProgram(FloatingPoint(Multi(self._bits)))
        self._times = self._program.new()
        slots = lower([*flow.matrix, *flow.force], [flow.time]).run(self._program, [self._times])
        self._entries = [self._program.coefficients(slot) for slot in slots]
        m = flow.matrix.rows
        self._rows = [[(c, m * r + c, flow.time in flow.matrix[r, c].free_symbols)
                       for c in range(m) if flow.matrix[r, c] != 0] for r in range(m)]  # fmt: skip
        self._t = self._context.convert(to_bits(t0)(self._bits))
        self._z = [[self._context.convert(to_bits(x)(self._bits)) for x in z] for z in starts]
        self._scale = flow.scale(float(self._t))
        self.error = self._context.mpf(0)
        self._steps = 0

    def states(self) -> list[list[Mpf]]:
        """Return a copy of the states."""
        return [list(z) for z in self._z]

    def to(self, time: sp.Expr) -> None:
        """Go on to a time, or to the end of a domain."""
        end = self._context.convert(to_bits(time)(self._bits))
        while self._t != end and self.end is None:
            left = end - self._t
            size, ρ = self._flow.size_around(float(self._t), max(min(2.0, float(abs(left)) * _RATIO), 2.0**-20))
            h = left if abs(left) * _RATIO <= ρ else self._context.sign(left) * self._context.mpf(ρ) / _RATIO
            self._step(h, size, ρ)
            self._t = end if h is left else self._t + h
            self._steps += 1
            if self._steps > _MOST_STEPS:
                raise NotConvergedError(f"explicit time: more than {_MOST_STEPS} steps to t = {float(end):.6g}")

    def _step(self, h: Mpf, size: float, ρ: float) -> None:
        context = self._context
        _, force = self._flow._bounds(float(self._t), ρ)
        largest = max(abs(x) for z in self._z for x in z) + self.error
        top = (largest + ρ * context.mpf(force)) * context.exp(context.mpf(size) * ρ)
        order = int(self._digits * 3.33 / np.log2(_RATIO)) + 8
        left = top * context.mpf(_RATIO) ** -(order + 1) * _RATIO / (_RATIO - 1)
        coefficients = self._coefficients(order)
        m = self._flow.matrix.rows
        powers = [h**j for j in range(order + 1)]
        first: list[list[Mpf]] = []
        for k, z in enumerate(self._z):
            series = [[x] for x in z]
            for j in range(order):
                row = []
                for r, held in enumerate(self._rows):
                    total = coefficients[m * m + r][j]
                    for c, place, moving in held:
                        entry = coefficients[place]
                        total += (
                            context.fdot(zip(entry[: j + 1], series[c][j::-1], strict=True))
                            if moving else entry[0] * series[c][j]
                        )  # fmt: skip
                    row.append(total / (j + 1))
                for c, x in enumerate(row):
                    series[c].append(x)
            self._z[k] = [context.fdot(zip(series[r], powers, strict=True)) for r in range(m)]
            first = first if k else series
        rounding = top * context.ldexp(1, 12 - self._bits)
        ν = self._flow.growth(float(self._t), float(abs(h)), self._scale)
        larger = max(float(self._scale), 1 / float(self._scale)) * m
        self.error = self.error * context.exp(context.mpf(ν) * abs(h)) + larger * (left + rounding)
        if self._walls:
            slope = size * self.error + 2 * (order + 2) * left / abs(h)
            # the error is a motion, too: Cauchy's estimate of its second derivative within ¼ρ
            bend = 4 * self.error * context.exp(context.mpf(size) * ρ) / ρ**2 + 2 * ((order + 2) / abs(h)) ** 2 * left
            self._look_for_ends(first, h, slope, bend)

    def _look_for_ends(self, series: list[list[Mpf]], h: Mpf, slope: Mpf, bend: Mpf) -> None:
        """Look whether a step of Taylor series passes a wall.

        Args:
            series: coefficients of the coordinates in the time from the beginning of the step.
            h: the step.
            slope, bend: bounds on the errors of first and second derivatives.
        """
        context, sign = self._context, self._context.sign(h)
        signed = [[sign**j * c for j, c in enumerate(series[wall.row])] for wall in self._walls]
        rates = [[j * c for j, c in enumerate(row)][1:] for row in signed]
        bends = [[j * (j - 1) * abs(c) for j, c in enumerate(row)][2:] for row in signed]
        walls = [wall._replace(row=i) for i, wall in enumerate(self._walls)]

        def at(s: Mpf) -> Approach:
            values, slopes = ([context.polyval(row[::-1], s) for row in rows] for rows in (signed, rates))
            return Approach(values, slopes, self.error, slope)

        end = first_end(walls, context.mpf(0), abs(h), at, lambda i, _, b: context.polyval(bends[i][::-1], b) + bend)
        if end is not None:
            self.end = Estimate(self._t + sign * end.value, end.error + abs(self._t) * context.ldexp(1, 4 - self._bits))

    def _coefficients(self, order: int) -> list[list[Mpf]]:
        """Taylor coefficients of the entries of A and b at the time."""
        self._program.restart()
        for k in range(order + 1):
            self._times.append(self._context.zero if k > 1 else self._context.one if k else self._t)
            self._program.extend(k)
        return [[entry(k) for k in range(order + 1)] for entry in self._entries]
