r"""Derivatives of actions and frequencies: the matrix K = ∂J/∂α of the motion, and the derivatives of it.

With J_m = c_m for an ignorable coordinate K is square, Ω = ∂E/∂J is the row of E in K⁻¹, and

    dΩ = −Ω dK K⁻¹,     dK_lj = Σ_b ∂²J_l/∂α_j∂z_b dz_b,     ∂Ω_i/∂J_k = Σ_j ∂Ω_i/∂α_j (K⁻¹)_jk   (the Hessian of E).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.motion.derivatives.along_cycle import CycleVariations
from hjsolve.motion.derivatives.at_rest import RestVariations
from hjsolve.motion.derivatives.bounded import Bounded, inverse, stacked, zeros
from hjsolve.motion.derivatives.canonical import ConstantsToState
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.formulas_at_places import tape_of

_NODES = 8
"""Nodes a digit of the mean of a shift over a turn, as many as the action takes."""


@dataclass(frozen=True, eq=False)
class MeanMatrix:
    """K with its inverse and its derivatives; rows are the separated coordinates, then the ignorable ones.

    Attributes:
        inverse: ∂α_j/∂J_i at [j, i].
        second: ∂²J_l/∂α_j∂z_b at [l, j, b], of the separated coordinates.
        energy: position of E among the constants.
    """

    inverse: Bounded
    second: Bounded
    energy: int

    @property
    def frequencies(self) -> Bounded:
        """Ω of all coordinates, by unsigned actions."""
        return self.inverse[self.energy]

    def inverse_by(self, b: int) -> Bounded:
        """Return ∂(K⁻¹)/∂z_b.

        Args:
            b: position of the variable.
        """
        # d(K⁻¹) = −K⁻¹ dK K⁻¹; rows of ignorable coordinates are constant, so that dK has the others alone
        ns = len(self.second.value)
        return -(self.inverse[:, :ns] @ self.second[:, :, b] @ self.inverse)

    def frequencies_by(self) -> Bounded:
        """Return ∂Ω_i/∂z_b at [i, b]."""
        return stacked([self.inverse_by(b)[self.energy] for b in range(self.second.value.shape[2])], 1)


def has_means(part: object) -> bool:
    """Whether the action of a coordinate exists, with all its derivatives."""
    return isinstance(part, CycleVariations) or (isinstance(part, RestVariations) and part.coordinate_motion.stable)


def mean_matrix(map_: ConstantsToState) -> MeanMatrix | None:
    """Return K; None where some coordinate has no action."""
    if not all(map(has_means, map_.parts)):
        return None
    solution, c, n = map_.source.solution, map_.context, len(map_.variables.constants)
    K = zeros((n, n), c)
    for i, part in enumerate(map_.parts):
        means = part.means()[:n]  # type: ignore[union-attr]
        K.value[i], K.error[i] = means.value, means.error
    others = [q for q in solution.system.coordinates if q.name not in solution.coordinates]
    for row, q in enumerate(others, len(map_.parts)):
        # J_m = c_m of an ignorable coordinate: its row of K is a row of the unit matrix, and K is square
        K.value[row, map_.variables.constants.index(q.momentum.name)] = c.mpf(1)
    second = stacked([part.second_means() for part in map_.parts])  # type: ignore[union-attr]
    energy = map_.variables.constants.index(solution.separation.shell.energy.name)
    return MeanMatrix(inverse(K, c), second, energy)


def action_by(map_: ConstantsToState, i: int) -> Bounded:
    """Return ∂J/∂z_b of the action of a separated coordinate, signed like p for a rotation, shape (variables,).

    Args:
        i: position of the coordinate.
    """
    part = map_.parts[i]
    means = part.means()  # type: ignore[union-attr]
    # p = P − A: over a libration ∮ A dq = 0, over a turn it is not
    if isinstance(part, CycleVariations) and part.coordinate_motion.rotates:
        signed = means if part.coordinate_motion.direction > 0 else -means
        return signed - _shift_by(map_, i, part)
    return means


def _shift_by(map_: ConstantsToState, i: int, part: CycleVariations) -> Bounded:
    """Return the derivatives of (1/2π) ∫ A dq over a turn, by which a shift of p lessens the action of a rotation."""
    solution, values, c = map_.source.solution, map_.source.initial.values, map_.context
    name = solution.coordinates[i]
    A, q = solution.shift[name], solution.system.coordinate(name).symbol
    count = map_.variables.count
    if A == 0:
        return zeros((count,), c)
    outputs = [A, *(sp.diff(A, z) for z in map_.variables.symbols)]
    known = [s for s in values if s != q and any(e.has(s) for e in outputs)]
    constants = {solution.constants[k].symbol: x for k, x in map_.source.initial.constants.items()}
    numbers = [to_bits({**values, **constants}[s])(c.prec) for s in known]
    tape, field, nodes = tape_of(tuple(outputs), (q, *known)), Multi(c.prec), _NODES * map_.source.digits
    length = c.convert(part.coordinate_motion.radian)
    rows = [tape.run(field, [2 * c.pi * length * k / nodes, *numbers]) for k in range(nodes)]
    result: list[Mpf] = []
    for b in range(count):
        mean = c.fsum(c.convert(row[1 + b]) for row in rows) / nodes
        # the length of a turn may depend on a parameter, too: the upper end of the integral moves
        result.append(mean * length + part.scale[b] * length * rows[0][0])
    return Bounded.exact(np.array(result, dtype=object))
