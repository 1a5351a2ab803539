"""Angles of n states by running integrals over short arcs: where θ is small next to its rounding.

θₖ = Σⱼ (∂J/∂c)⁻¹ₖⱼ Σᵢ Gᵢⱼ, Gᵢⱼ = ∫ kᵢⱼ/pᵢ dqᵢ from the lower turning point (Goldstein, 3rd ed., §10.6). The engine
gives G as mean growth plus oscillations, with an absolute error. Nearly unbound orbits pass their inner turning point
in 1e-15 of a period; there the difference of those two has no digits, but G is an integral over a short arc of φ:

    Gᵢⱼ(φ) = Gᵢⱼ(φ₀) + ∫_{φ₀}^{φ} kᵢⱼ/pᵢ dqᵢ/dφ dφ,

by the rule of Gauss and Legendre (Trefethen, SIAM Review 50 (2008) 67, §1), with φ₀ the turning point, G = 0, where θ
is small, and the phase at which the engine gave G elsewhere. The difference of two rules is part of the claim. Next to
a = 0 the integrand changes on the distance a′ = F′/½F″ of another zero or a pole of F from the turning point, which
both rules would miss if they were in φ: they are in t, φ = φₐ sinh t, W sin²(φₐ/2) = a′.

Of the tori of n orbits none has a coordinate that rotates or rests; ``frames`` are between what they move, ``arcs``
where integrals begin, and ``exact`` is whether p² is from 32 digits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.to_states.places_on_tori import AngleTask, Frames, placed
from hjsolve.ensembles.to_states.tori import Tori, coordinate_at

_NODES, _MORE, _FEW = 20, 32, 12
"""Nodes on an arc, of the second rule, and of searches in doubles."""
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


class ShortArcs(NamedTuple):
    """Where running integrals begin.

    Attributes:
        phases: φ₀, shape (separated, n).
        known: of the engine; G at φ₀.
        inverse: (∂J/∂c)⁻¹, shape (n, separated, separated).
    """

    phases: Reals
    known: Integrals
    inverse: Reals

    @classmethod
    def of(cls, known: Integrals, inverse: Reals, φ: Reals, ends: Mask) -> ShortArcs:
        """Begin at turning points or where the engine gave G.

        Args:
            known: of the engine.
            inverse: (∂J/∂c)⁻¹.
            φ: the phases of the engine.
            ends: which coordinates begin at their lower turning point, shape (separated, n).
        """
        begin = np.where(ends[:, None], 0.0, known.running)
        errors = np.where(ends[:, None], 0.0, known.running_errors)
        return cls(np.where(ends, 0.0, φ), known._replace(running=begin, running_errors=errors), inverse)

    def take(self, index: Integers | Mask) -> ShortArcs:
        """Return some of them."""
        known = Integrals._make(x[..., index] for x in self.known)
        return ShortArcs(self.phases[:, index], known, self.inverse[index])


class AnglesByArcs(NamedTuple):
    """Angles at the ends of arcs: of the separated coordinates, of ignorable ones at zero, and bounds; (…, n)."""

    separated: Reals
    errors: Reals
    ignorable: Reals
    ignorable_errors: Reals


def angles_by_arcs(
    task: AngleTask, tori: Tori, frames: Frames, arcs: ShortArcs, φ: Reals, *, exact: bool, proved: bool = False
) -> AnglesByArcs:
    """Return angles at phases.

    Args:
        φ: phases, shape (separated, n).
        proved: whether a second rule tells the error of the first; else bounds hold rounding only.
    """
    more, sizes = _integrated(
        (task, tori, frames), arcs.phases, φ, _MORE if proved else _NODES if exact else _FEW, exact=exact
    )
    known, size = arcs.known, len(φ)
    errors = known.running_errors + _ROUNDING * (sizes + np.abs(known.running))
    if proved:
        fewer, _ = _integrated((task, tori, frames), arcs.phases, φ, _NODES, exact=exact)
        errors = errors + np.abs(more - fewer)
    running, errors = (known.running + more).sum(axis=0), errors.sum(axis=0)
    θ = times(arcs.inverse, running[:size])
    # an error of ∂J/∂c moves Σ ∂J/∂c θ, which G has to equal
    errors = errors + np.sum((known.mean_errors + 4 * size * EPS * np.abs(known.means)) * np.abs(θ)[:, None], axis=0)
    θ_errors = times(np.abs(arcs.inverse), errors[:size]) + 2 * EPS * np.abs(θ)
    places = [task.model.ignorable[name] for name in task.model.angles]
    ignorable = running[places] - np.sum(known.means[:, places] * θ[:, None], axis=0)
    own = errors[places] + np.sum(np.abs(known.means[:, places]) * θ_errors[:, None], axis=0)
    return AnglesByArcs(θ, θ_errors, ignorable, own)


def _integrated(
    system: tuple[AngleTask, Tori, Frames], begin: Reals, end: Reals, nodes: int, *, exact: bool
) -> tuple[Reals, Reals]:
    """∫ kᵢⱼ/pᵢ dqᵢ from phases to phases, and that of the sizes; shape (separated, constants, n)."""
    task, tori, frames = system
    scale = _scales(task, tori, frames)
    span = np.stack([np.arcsinh(φ / scale) for φ in (begin, end)])
    with np.errstate(invalid="ignore"):
        longest = 0.5 * np.abs(span[1] - span[0]).max(axis=0)
        pieces = 2 ** np.ceil(np.log2(np.where(longest > _LONG, longest / _LONG, 1.0))).astype(int)
    found = np.empty((2, len(begin), len(tori.values), begin.shape[1]))
    for count in np.unique(pieces):
        some = np.flatnonzero(pieces == count)
        own = (task, tori.take(some), frames.take(some)) if len(some) < len(pieces) else system
        x, weights = np.polynomial.legendre.leggauss(nodes)
        x = ((x + 2 * np.arange(count)[:, None] + 1) / count - 1).ravel()
        rule = x, np.tile(weights / count, count)
        found[..., some] = _by_one_rule(own, scale[:, some], span[..., some], rule, exact=exact)
    return found[0], found[1]


def _by_one_rule(
    system: tuple[AngleTask, Tori, Frames], scale: Reals, span: Reals, rule: tuple[Reals, Reals], *, exact: bool
) -> Reals:
    """Integrals, and those of the sizes, between the t of ``span``; shape (2, separated, constants, n)."""
    (task, tori, frames), (x, weights), (size, n) = system, rule, scale.shape
    half = 0.5 * (span[1] - span[0])
    t = 0.5 * (span[1] + span[0]) + half * x[:, None, None]
    φ, stretch = (part.transpose(1, 0, 2) for part in (scale * np.sinh(t), scale * np.cosh(t)))
    each = np.tile(np.arange(n), len(x))
    at = placed(task, tori.take(each), frames.take(each), np.ascontiguousarray(φ).reshape(size, -1), exact=exact)
    with np.errstate(all="ignore"):
        rates = at.rates.reshape(size, -1, len(x), n) * stretch[:, None]
        sums = np.stack([np.einsum("k,ijkn->ijn", weights, r) for r in (rates, np.abs(rates))])
        return np.stack([half, np.abs(half)])[:, :, None] * sums


def _scales(task: AngleTask, tori: Tori, frames: Frames) -> Reals:
    """Return the phases φₐ on which integrands change next to lower turning points, at most 1."""
    rows = []
    for k, bases in enumerate(frames.bases):
        one = coordinate_at(*task, tori, k)
        with np.errstate(all="ignore"):
            given = np.stack([bases[0], *one.constants])
            _, first, second = run_rows(one.programs.views[0].bend, one.parameters, given)
            rows.append(2 * np.sqrt(np.fmin(np.abs(2 * first / second) / frames.widths[k], 0.25)))
    return np.stack(rows)


def phases_by_arcs(
    task: AngleTask, tori: Tori, frames: Frames, arcs: ShortArcs, given: tuple[Reals, Reals], *, exact: bool
) -> tuple[Reals, Mask]:
    """Find the phases with given angles from other phases, by Newton's method with steps that have to shrink.

    Args:
        given: angles, and phases to begin with, shape (separated, n).

    Returns:
        Phases, and which of them are known to rounding.
    """
    θ, base = given[0], given[1].copy()
    size, n = θ.shape
    trial, step, matrices = base.copy(), np.zeros((size, n)), np.full((n, size, size), np.nan)
    fraction, left, active = np.ones(n), np.full(n, np.inf), np.arange(n)
    for round_ in range(_ROUNDS):
        if not len(active):
            break
        own, among, mine = tori.take(active), frames.take(active), arcs.take(active)
        found = angles_by_arcs(task, own, among, mine, trial[:, active], exact=exact)
        residual = wrapped(θ[:, active] - found.separated)
        with np.errstate(all="ignore"):
            # steps are compared by one matrix: angles of one orbit may differ in size by 1e15
            seen = np.abs(times(matrices[active], residual)).max(axis=0)
            better = np.asarray(seen < (1 - 0.25 * fraction[active]) * left[active]) if round_ else _finite(residual)
        here = active[better]
        base[:, here] = trial[:, here]
        rates = placed(task, own.take(better), among.take(better), trial[:, here], exact=exact).rates[:, :size]
        matrices[here] = inverses(arcs.inverse[here] @ rates.transpose(2, 1, 0))
        newton = times(matrices[here], residual[:, better])
        with np.errstate(all="ignore"):
            left[here] = np.abs(newton).max(axis=0)
            step[:, here], fraction[here] = newton, np.fmin(1.0, _LONGEST / left[here])
        fraction[active[~better]] *= 0.25
        # what the last step leaves is its square
        last = better & (np.abs(step[:, active]) <= _SETTLED * np.abs(base[:, active])).all(axis=0)
        base[:, active[last]] += step[:, active[last]]
        active = active[
            ~last & (better | (left[active] > _SETTLED)) & (fraction[active] >= _LEAST_STEP) & np.isfinite(left[active])
        ]
        trial[:, active] = base[:, active] + fraction[active] * step[:, active]
    return base, left <= _SETTLED


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
