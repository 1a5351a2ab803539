r"""Second derivatives of actions of many librations, on a closed path round both turning points.

J = (1/2π) ∮ √F dq does not change when its path is drawn away from the turning points, and there it may be
differentiated under the integral sign as often as is wanted, with no term that is large next to an end:

    J_j = (1/2π) ∮ ½ F_j dq/√F,      J_jk = (1/2π) ∮ (½ F_jk − ¼ F_j F_k/F) dq/√F.

The path is q = m + ρ e^{iχ} + (h²/4ρ) e^{−iχ} round m ± h. With D = ρ e^{iχ} − (h²/4ρ) e^{−iχ} it is dq = iD dχ and
F = −D²R, so that dq/√F = dχ/√R with R analytic and without zero between the path and the motion: nothing cancels, also
where h is small. Equal steps converge geometrically (Trefethen & Weideman, SIAM Review 56 (2014) 385, §2); where they
are n, every other one shows what n/2 leave open, c, and n leave about c².
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, single
from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.number_types import Complexes, Integers, Mask, Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.one_coordinate.regular_factor import ComplexPoints

_LONG, _NEAR = 48.0, 8.0
"""n η of a path e^η away: e^−48 is left where the next singularity is as far again; and what is added for small η."""
_POWER = 1.5
"""c^1.5 is claimed where c² is expected."""
_SAMPLED = 4
"""Every which step is run in disks."""
_PLACES = 16.0
"""Units of rounding of an evaluation of F and its derivatives, in its own size and in that of its terms."""


class Seconds(NamedTuple):
    """J, J_j, J_jk of one coordinate of m orbits, and bounds on the errors of the last.

    Attributes:
        action: J, shape (m,).
        first, first_error: J_j and bounds on their errors, shape (constants, m).
        second, error: J_jk, shape (constants, constants, m).
        scale: the mean size of what J_jk is the mean of, of the same shape.
        good: whether the path holds the turning points and nothing else, as far as it shows.
    """

    action: Reals
    first: Reals
    first_error: Reals
    second: Reals
    error: Reals
    scale: Reals
    good: Mask


class Integrand(NamedTuple):
    """p² of one coordinate of m orbits.

    Attributes:
        tape: F, F_j, F_jk (k ≥ j) in q, the constants and the parameters.
        alone: F alone.
        constants, uncertainty: κ and bounds on their errors, shape (constants, m).
        parameters: their values.
    """

    tape: Tape
    alone: Tape
    constants: Reals
    uncertainty: Reals
    parameters: list[float]

    def take(self, index: Integers) -> Integrand:
        """Return that of some of the orbits.

        Args:
            index: which.
        """
        return self._replace(constants=self.constants[:, index], uncertainty=self.uncertainty[:, index])

    def run(self, numbers: Any, q: Any) -> list[Any]:
        """Return F and its derivatives at places.

        Args:
            numbers: the arithmetic.
            q: places, shape (nodes, m).
        """
        found: list[Any] = self.tape.run(numbers, [q, *self.constants, *self.parameters])
        return found

    def doubt(self, q: Any) -> Reals:
        """Return a bound on the relative error of F: by disks, with the rounding of q and the errors of the constants.

        Args:
            q: places, shape (nodes, m).
        """
        known = [Disk(k + 0j, e) for k, e in zip(self.constants, self.uncertainty, strict=True)]
        fixed = [single(x, EPS * abs(x)) for x in self.parameters]
        F = self.alone.run(Disks(), [Disk(q + 0j, 4 * EPS * np.abs(q)), *known, *fixed])[0]
        return F.radius / np.abs(F.centre)


def along(integrand: Integrand, path: tuple[Reals, Reals, Reals], half: int) -> Seconds:
    """Integrate along q = m + ρ e^{iχ} + (h²/4ρ) e^{−iχ}; below the real axis everything is conjugate.

    Args:
        integrand: of m orbits.
        path: m, h and ρ, shape (m,).
        half: steps on half of the path, an even number.
    """
    middle, h, ρ = path
    turn = np.exp(1j * np.pi * (np.arange(half) + 0.5) / half)[:, None]
    out, back = ρ * turn, h * h / (4 * ρ) / turn
    D = out - back
    with np.errstate(all="ignore"):
        q = middle + (out + back)
        F, *others = integrand.run(ComplexPoints(), q)
        root = _continued(np.sqrt(-F / (D * D)))
        action = np.mean((F / root).real, axis=0)
        found = _differentiated(integrand, q, (F, others, root), turn)
        good = (root[-1].real > 0) & np.isfinite(action) & np.isfinite(found[2]).all(axis=(0, 1))
    return Seconds(action, *found, good)


def steps(η: Reals | float, factor: float = 1.0) -> int:
    """Return how many steps half of a path e^η away takes: more next to the motion, where the integrands grow.

    Args:
        η: how far it is.
        factor: by which there are more.
    """
    return 2 * int(np.ceil(factor * (_LONG + _NEAR * max(0.0, -float(np.log(η)))) / η / 4))


def _differentiated(
    integrand: Integrand, q: Any, values: tuple[Complexes, list[Complexes], Complexes], wave: Complexes
) -> tuple[Reals, Reals, Reals, Reals, Reals]:
    """J_j, J_jk, each with bounds on their errors, and scales, from F, its derivatives and √F per step.

    How well F is known is a guess from its terms, held at every fourth step against disks and enlarged by them.
    """
    (F, others, root), κ = values, integrand.constants
    n, shape = len(κ), F.shape
    first = [np.broadcast_to(f, shape) for f in others[:n]]
    parts = [k * f for k, f in zip(κ, first, strict=True)]
    size = _size(F - sum(parts)) + sum(map(_size, parts))
    relative = EPS * _PLACES * (1 + size / np.abs(F))
    some = slice(None, None, _SAMPLED)
    relative = relative * np.maximum(1.0, np.max(integrand.doubt(q[some]) / relative[some], axis=0))
    half, halves = 0.5 / root, []
    inverse = half / F
    halves = [f * half for f in first]
    second, error, scales = (np.zeros((n, n, shape[1])) for _ in range(3))
    position = n
    for j in range(n):
        bent = first[j] * inverse / 2
        for k in range(j, n):
            f = -bent * first[k]
            terms: Any = _size(f)
            if np.ndim(others[position]) or others[position] != 0:
                own = others[position] * half
                f, terms = f + own, terms + _size(own)
            second[j, k] = second[k, j] = np.mean(f.real, axis=0)
            scale = np.mean(terms, axis=0)
            error[j, k] = error[k, j] = 2 * np.mean(terms * relative, axis=0) + _left(f, wave)
            scales[j, k] = scales[k, j] = scale
            position += 1
    doubt = [2 * np.mean(_size(f) * relative, axis=0) + 4 * _left(f, wave) for f in halves]
    return np.array([np.mean(f.real, axis=0) for f in halves]), np.array(doubt), second, error, scales


def _left(f: Complexes, wave: Complexes) -> Reals:
    """Return what is left open of a mean: nearly the square of what half of the steps leave, in proportion."""
    scale, left = np.mean(_size(f), axis=0), np.maximum(_alternating(f), _alternating(f * wave))
    found: Reals = np.where(scale == 0, 0.0, scale * np.minimum(1.0, 4 * left / scale) ** _POWER)
    return found


def _alternating(f: Complexes) -> Reals:
    """Return what half of the steps leave open: a Fourier coefficient and its mirror image, which may cancel.

    They do not both in f and in f e^{iχ}.
    """
    gap = f.imag if np.iscomplexobj(f) else f
    return np.abs(np.mean(gap[::2], axis=0) - np.mean(gap[1::2], axis=0)) / 2


def _size(x: Complexes) -> Reals:
    """No less than the absolute value, and quicker."""
    return np.abs(x.real) + np.abs(x.imag) if np.iscomplexobj(x) else np.abs(x)


def _continued(root: Complexes) -> Complexes:
    """Return the branch that begins positive and changes sign nowhere."""
    turned = np.ones(root.shape)
    turned[0] = np.where(root[0].real < 0, -1.0, 1.0)
    turned[1:] = np.where((root[1:] * np.conj(root[:-1])).real < 0, -1.0, 1.0)
    return root * np.cumprod(turned, axis=0)


def round_the_circle(integrand: Integrand, half: int) -> Seconds:
    """Integrate rotations over a whole turn, on the real axis, where F > 0 everywhere.

    Args:
        integrand: of m orbits.
        half: half the number of steps.
    """
    # a quarter of a step off 0: from there alternating sums see even functions and odd ones
    q = np.pi * (np.arange(2 * half) + 0.25)[:, None] / half
    with np.errstate(all="ignore"):
        q = q + 0 * integrand.constants[0]
        F, *others = integrand.run(Float64(), q)
        root = np.sqrt(F)
        found = _differentiated(integrand, q, (F, others, root), np.cos(q))
        good = (F > 0).all(axis=0) & np.isfinite(found[2]).all(axis=(0, 1))
        return Seconds(np.mean(root, axis=0), *found, good)
