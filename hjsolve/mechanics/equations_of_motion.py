"""Hamilton's canonical equations and the Routhian of a system, as formulas."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.kinetic_energy import half_inverse_form


def canonical_equations(coordinates: Sequence[Coordinate], hamiltonian: sp.Expr) -> dict[str, sp.Eq]:
    """Return q̇ = ∂H/∂p (4-16) and ṗ = −∂H/∂q (4-17), by the names of q and p.

    Args:
        hamiltonian: its H(q, p).
    """
    rates = {c.name: sp.Eq(c.velocity, sp.diff(hamiltonian, c.momentum), evaluate=False) for c in coordinates}
    forces = {
        c.momentum.name: sp.Eq(
            sp.Symbol(f"dot({c.momentum.name})", real=True), -sp.diff(hamiltonian, c.symbol), evaluate=False
        )
        for c in coordinates
    }
    return rates | forces


def routhian(
    coordinates: Sequence[Coordinate], mass: sp.Matrix, linear: Sequence[sp.Expr], rest: sp.Expr, held: set[sp.Symbol]
) -> sp.Expr:
    """Return R = L − Σ β_i q̇_i with the ignorable q̇ eliminated, Greenwood (2-122).

    With m the mass matrix, a the linear terms of T, v the velocities that stay and π = β − a of the ignorable part,

        R = ½ vᵀm_ee v + a_e·v − ½ (π − m_ie v)ᵀ m_ii⁻¹ (π − m_ie v) + rest.

    Args:
        mass: m, shape (n, n).
        linear: a, shape (n,).
        rest: T₀ − V.
        held: symbols that T and V hold.

    Raises:
        InvalidSystemError: the ignorable velocities do not follow from their momenta.
    """
    left = [i for i, c in enumerate(coordinates) if c.symbol in held]
    gone = [i for i, c in enumerate(coordinates) if c.symbol not in held]
    speeds = sp.Matrix([coordinates[i].velocity for i in left])
    stays = sp.Add(
        *(
            sp.Rational(1, 2) * mass[i, j] * coordinates[i].velocity * coordinates[j].velocity
            for i in left
            for j in left
        ),
        *(linear[i] * coordinates[i].velocity for i in left),
    )
    if not gone:
        return stays + rest
    block = mass.extract(gone, gone)
    if block.det().is_zero:
        raise InvalidSystemError(
            "routhian: the ignorable velocities do not follow from their momenta (T is degenerate)"
        )
    coupling = mass.extract(gone, left) * speeds if left else sp.zeros(len(gone), 1)
    lacking = [coordinates[i].momentum - linear[i] - coupling[k, 0] for k, i in enumerate(gone)]
    return stays - half_inverse_form(sp.ImmutableMatrix(block), lacking) + rest
