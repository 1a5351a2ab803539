"""Angles of n states by running integrals over short arcs: where θ is small next to its rounding.

θₖ = Σⱼ (∂J/∂c)⁻¹ₖⱼ Σᵢ Gᵢⱼ, Gᵢⱼ = ∫ kᵢⱼ/pᵢ dqᵢ from the lower turning point (Goldstein, 3rd ed., §10.6). The engine
gives G as mean growth plus oscillations, with an absolute error. Nearly unbound orbits pass their inner turning point
in 1e-15 of a period; there the difference of those two has no digits, but G is an integral over a short arc of φ:

    Gᵢⱼ(φ) = Gᵢⱼ(φ₀) + ∫_{φ₀}^{φ} kᵢⱼ/pᵢ dqᵢ/dφ dφ,

by the rule of Gauss and Legendre (Trefethen, SIAM Review 50 (2008) 67, §1), with φ₀ the turning point, G = 0, where θ
is small, and the phase at which the engine gave G elsewhere. The difference of two rules is part of the claim. Next to
a = 0 the integrand changes on the distance a′ = F′/½F″ of another zero or a pole of F from the turning point, which
both rules would miss if they were in φ: they are in t, φ = φₐ sinh t, W sin²(φₐ/2) = a′.

No coordinate of the tori of n orbits rotates or rests; ``arcs`` are where integrals begin, and ``exact`` is
whether p² is from 32 digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.over_rows import WIDTH, run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.kernels.short_arcs import ArcsOfLibrations, arc_integrals, lanes
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.places_on_tori import NEXT, Frames
from hjsolve.ensembles.to_states.tori import AngleTask, Tori, coordinate_at

_FEW, _NODES, _MORE = (np.polynomial.legendre.leggauss(n) for n in (12, 20, 32))
"""Nodes on an arc and their weights."""
SEARCHED, FINE, PROVED = (_FEW,), (_NODES,), (_MORE, _NODES)
"""Rules of searches, of angles, and of angles with an error: its difference from a second one."""
_MIDDLE = np.zeros(1), np.ones(1)
"""The middle of an arc alone, half as long as the arc."""
_LONG = 1.5
"""Half of a piece in t, whose nodes suffice for singularities at a distance of π/2."""
_ROUNDING = 16 * EPS
"""What rounding leaves open of kᵢⱼ/pᵢ dqᵢ/dφ, relatively: that of sin φ/2, of p² to 32 digits, and of the sum."""


_ROUNDS, _LEAST_STEP = 60, 2.0**-20
"""Evaluations of θ, and the fraction of a step below which an orbit is given up."""
_LONGEST = 0.5
"""Radians that a phase moves in one step, at most."""
_SETTLED = 1e-9
"""Step that is the last, over the phase, and in radians the one that ends the search where it makes nothing better."""


class Integrals(NamedTuple):
    """Integrals of the engine at the phases of n states; shape (separated, constants, n).

    Attributes:
        means, mean_errors: ∂J/∂c, and bounds on the errors.
        running, running_errors: G there, and bounds.
    """

    means: Reals
    mean_errors: Reals
    running: Reals
    running_errors: Reals


class Passages(NamedTuple):
    """How n orbits pass their turning points; arrays (separated, n).

    Attributes:
        scales: φₐ, on which integrands change next to lower turning points, at most 1.
        widths: W.
        ends, linear: offsets of both turning points, 0 where programs know them, and how far from them p² is linear,
            shape (separated, 2, n).
        known: what programs know, shape (separated, n, known).
    """

    scales: Reals
    widths: Reals
    ends: Reals
    linear: Reals
    known: Reals

    @classmethod
    def of(cls, task: AngleTask, tori: Tori, frames: Frames, *, exact: bool) -> Passages:
        """Look at the turning points of tori."""
        scales, ends, linear, known = [], [], [], []
        for k, (W, bases) in enumerate(zip(frames.widths, frames.bases, strict=True)):
            one, near = coordinate_at(*task, tori, k), []
            with np.errstate(all="ignore"):
                for side in (0, 1):
                    given = np.stack([bases[2 * side], *one.constants])
                    _, first, second = run_rows(one.programs.views[side].bend, one.parameters, given)
                    near.append(np.abs(2 * first / second))  # of another zero, or a pole
                scales.append(2 * np.sqrt(np.fmin(near[0] / W, 0.25)))
                linear.append([NEXT * np.fmin(W, distance) for distance in near])
            ends.append(0.0 * bases[::2] if exact else bases[::2])
            known.append(np.stack([*one.constants, *one.low, *bases] if exact else [*one.constants], axis=1))
        return cls(np.stack(scales), frames.widths, np.stack(ends), np.array(linear), np.stack(known))

    def take(self, index: Integers | Mask) -> Passages:
        """Return those of some orbits."""
        scales, widths, ends, linear = (np.ascontiguousarray(x[..., index]) for x in self[:4])
        return Passages(scales, widths, ends, linear, np.ascontiguousarray(self.known[:, index]))

    def integrals(
        self, task: AngleTask, span: tuple[Reals, Reals], rule: tuple[Reals, Reals], *, exact: bool
    ) -> tuple[Reals, Reals]:
        """Return ∫ kᵢⱼ/pᵢ dqᵢ over arcs, and that of the sizes; shape (separated, constants, n).

        Args:
            span: the middle and half the length of each arc in t, shape (separated, n).
            rule: nodes and weights.
            exact: whether p² is from 32 digits.
        """
        sums, sizes = np.zeros((2, len(self.scales), len(task.model.constants), self.scales.shape[1]))
        for k, programs in enumerate(task.programs.coordinates):
            middle, half = (np.ascontiguousarray(x[k]) for x in span)
            with np.errstate(invalid="ignore"):
                pieces = np.ceil(np.where(np.abs(half) > _LONG, np.abs(half) / _LONG, 1.0)).astype(np.int64)
            formulas = sides(task.model.separated[k])
            away = np.array([formulas[0].sign, -formulas[1].sign], dtype=float)
            codes = [view.fill for view in (programs.exact if exact else programs.views)]
            below, above = (code.program(WIDTH, task.programs.parameters, side) for side, code in enumerate(codes))
            widths, scales, ends, linear, known = (x[k] for x in (self.widths, self.scales, *self[2:]))
            arcs = ArcsOfLibrations(middle, half, pieces, scales, widths, ends, away, linear, known)
            arc_integrals(below, above, arcs, *rule, sums[k], sizes[k], lanes(WIDTH))
        return sums, sizes


class ShortArcs(NamedTuple):
    """Where running integrals begin.

    Attributes:
        begin: t₀, shape (separated, n).
        known: of the engine; G at t₀.
        inverse: (∂J/∂c)⁻¹, shape (n, separated, separated).
        passages: between what coordinates move.
    """

    begin: Reals
    known: Integrals
    inverse: Reals
    passages: Passages

    @classmethod
    def whole(cls, means: Reals, passages: Passages) -> ShortArcs:
        """Begin at the turning points of all coordinates, with nothing but ∂J/∂c; for searches.

        Args:
            means: ∂J/∂c, shape (separated, constants, n).
            passages: between what coordinates move.
        """
        size, none = len(means), np.zeros_like(means)
        inverse = inverses(means[:, :size].transpose(2, 1, 0))
        return cls(np.zeros_like(passages.scales), Integrals(means, none, none, none), inverse, passages)

    @classmethod
    def of(cls, known: Integrals, inverse: Reals, passages: Passages, φ: Reals, ends: Mask) -> ShortArcs:
        """Begin at turning points or where the engine gave G.

        Args:
            known: of the engine.
            inverse: (∂J/∂c)⁻¹.
            passages: between what coordinates move.
            φ: the phases of the engine.
            ends: which coordinates begin at their lower turning point, shape (separated, n).
        """
        begin = np.where(ends[:, None], 0.0, known.running)
        errors = np.where(ends[:, None], 0.0, known.running_errors)
        t = np.where(ends, 0.0, np.arcsinh(φ / passages.scales))
        return cls(t, known._replace(running=begin, running_errors=errors), inverse, passages)

    def take(self, index: Integers | Mask) -> ShortArcs:
        """Return some of them."""
        known = Integrals._make(x[..., index] for x in self.known)
        return ShortArcs(self.begin[:, index], known, self.inverse[index], self.passages.take(index))


class AnglesByArcs(NamedTuple):
    """Angles at the ends of arcs: of the separated coordinates, of ignorable ones at zero, and bounds; (…, n)."""

    separated: Reals
    errors: Reals
    ignorable: Reals
    ignorable_errors: Reals


def angles_by_arcs(
    task: AngleTask, arcs: ShortArcs, φ: Reals, rules: Sequence[tuple[Reals, Reals]], *, exact: bool
) -> AnglesByArcs:  # fmt: skip
    """Return angles at phases.

    Args:
        φ: phases, shape (separated, n).
        rules: nodes and weights; a second rule tells the error of the first, else bounds hold rounding only.
    """
    with np.errstate(invalid="ignore"):
        t = np.arcsinh(φ / arcs.passages.scales)
        span = 0.5 * (t + arcs.begin), 0.5 * (t - arcs.begin)
        more, sizes = arcs.passages.integrals(task, span, rules[0], exact=exact)
        known, size = arcs.known, len(φ)
        errors = known.running_errors + _ROUNDING * (sizes + np.abs(known.running))
        for rule in rules[1:]:
            fewer, _ = arcs.passages.integrals(task, span, rule, exact=exact)
            errors = errors + np.abs(more - fewer)
        running, errors = (known.running + more).sum(axis=0), errors.sum(axis=0)
        θ = times(arcs.inverse, running[:size])
        # what the rounding of the inverse mixes of large angles into small ones (Skeel, Math. Comp. 35 (1980) 817)
        θ = θ + times(arcs.inverse, running[:size] - np.sum(known.means[:, :size] * θ[:, None], axis=0))
        # an error of ∂J/∂c moves Σ ∂J/∂c θ, which G has to equal
        errors = errors + np.sum(
            (known.mean_errors + 4 * size * EPS * np.abs(known.means)) * np.abs(θ)[:, None], axis=0
        )
        θ_errors = times(np.abs(arcs.inverse), errors[:size]) + 2 * EPS * np.abs(θ)
        places = [task.model.ignorable[name] for name in task.model.angles]
        ignorable = running[places] - np.sum(known.means[:, places] * θ[:, None], axis=0)
        own = errors[places] + np.sum(np.abs(known.means[:, places]) * θ_errors[:, None], axis=0)
    return AnglesByArcs(θ, θ_errors, ignorable, own)


def _rates(task: AngleTask, passages: Passages, φ: Reals, *, exact: bool) -> Reals:
    """Return kᵢⱼ/pᵢ dqᵢ/dφ at phases, shape (separated, constants, n)."""
    t = np.arcsinh(φ / passages.scales)
    along, _ = passages.integrals(task, (t, np.ones_like(t)), _MIDDLE, exact=exact)
    return along / np.sqrt(passages.scales**2 + φ**2)[:, None]


def phases_by_arcs(
    task: AngleTask, arcs: ShortArcs, given: tuple[Reals, Reals], *, exact: bool
) -> tuple[Reals, Mask]:  # fmt: skip
    """Find the phases with given angles from other phases, by Newton's method with steps that have to shrink.

    Args:
        given: angles, and phases to begin with, shape (separated, n).

    Returns:
        Phases, and which of them are known to rounding.
    """
    θ, base = given[0], given[1].copy()
    size, n = θ.shape
    trial, step, matrices = base.copy(), np.zeros((size, n)), np.full((n, size, size), np.nan)
    fraction, left, active, known = np.ones(n), np.full(n, np.inf), np.arange(n), np.zeros(n, dtype=bool)
    for round_ in range(_ROUNDS):
        if not len(active):
            break
        mine = arcs.take(active)
        found = angles_by_arcs(task, mine, trial[:, active], FINE if exact else SEARCHED, exact=exact)
        with np.errstate(all="ignore"):
            residual = wrapped(θ[:, active] - found.separated)
            # steps are compared by one matrix: angles of one orbit may differ in size by 1e15
            seen = np.abs(times(matrices[active], residual)).max(axis=0)
            better = np.asarray(seen < (1 - 0.25 * fraction[active]) * left[active]) if round_ else _finite(residual)
        here = active[better]
        base[:, here] = trial[:, here]
        rates = _rates(task, mine.passages.take(better), trial[:, here], exact=exact)[:, :size]
        matrices[here] = inverses(arcs.inverse[here] @ rates.transpose(2, 1, 0))
        newton = times(matrices[here], residual[:, better])
        with np.errstate(all="ignore"):
            left[here] = np.abs(newton).max(axis=0)
            step[:, here], fraction[here] = newton, np.fmin(1.0, _LONGEST / left[here])
        fraction[active[~better]] *= 0.25
        # what the last step leaves is its square
        last = better & (np.abs(step[:, active]) <= _SETTLED * np.abs(base[:, active])).all(axis=0)
        base[:, active[last]] += step[:, active[last]]
        known[active[last]] = True
        active = active[
            ~last & (better | (left[active] > _SETTLED)) & (fraction[active] >= _LEAST_STEP) & np.isfinite(left[active])
        ]
        trial[:, active] = base[:, active] + fraction[active] * step[:, active]
    return base, known | (left <= _SETTLED)


def _finite(rows: Reals) -> Mask:
    return np.asarray(np.isfinite(rows).all(axis=0))


def wrapped(angle: Reals) -> Reals:
    """Reduce angles to [−π, π].

    Args:
        angle: radians.
    """
    found: Reals = angle - 2 * np.pi * np.rint(angle / (2 * np.pi))
    return found


def inverses(matrices: Reals) -> Reals:
    """Return inverses of small matrices, shape (n, i, j); NaN where there is none."""
    found = np.full(matrices.shape, np.nan)
    finite = np.flatnonzero(np.isfinite(matrices).all(axis=(1, 2)))
    fine = finite[np.linalg.det(matrices[finite]) != 0]
    found[fine] = np.linalg.inv(matrices[fine])
    return found


def times(matrices: Reals, vectors: Reals) -> Reals:
    """Return matrices (n, i, j) times vectors (j, n), shape (i, n).

    Args:
        vectors: of n orbits.
    """
    found: Reals = (matrices @ vectors.T[..., None])[..., 0].T
    return found
