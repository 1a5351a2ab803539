"""Jacobi's principle: the orbits of energy h are geodesics of the metric 2 (h − V) Σ m_ij dq_i dq_j.

    δ ∫ √(2(h − V)) ds = 0,   ds² = Σ m_ij dq_i dq_j   (Greenwood (4-176)–(4-179), Ex 4-7, P4-14)

The geodesics are the motions without a potential of T_J = 2 (h − V) T, at the energy ½ where the length is 1 for each
unit of the parameter. Their parameter s is the action: ds/dt = 2 (h − V) = 2T.
"""

from __future__ import annotations

from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.coordinates_and_parameters import free_name, parameter
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms


@arguments.with_known_names('jacobi_metric(system, energy="h")')
def jacobi_metric(system: System | str | Path, *, energy: str = "h") -> System:
    """Return the geodesics whose paths are the orbits of a system at one energy.

    Args:
        system: a natural system, T = T₂, or one with T₀, for which V′ = V − T₀; or the id or file of a catalog entry.
        energy: the name of the parameter that is the energy.

    Returns:
        A system in the same coordinates with T_J = 2 (h − V′) T₂ and no potential; it separates in coordinates in
        which the system does, and its orbit equations are the same.

    Raises:
        InvalidInputError: T has terms linear in the velocities, V has kinks, or the particle is relativistic.

    Example:
        >>> jacobi_metric("projectile", energy="h").kinetic
        m*(dot(x)**2 + dot(y)**2)*(-g*m*y + h)
    """
    given = system_of(system, "jacobi_metric")
    if any(linear_terms(given)) or given.kinks or given.relativity is not None:
        raise InvalidInputError(
            "jacobi_metric: T without terms linear in the velocities and V without kinks are needed; shift a closed "
            "linear term away first"
        )
    rest = kinetic_rest(given)
    name = free_name(energy, given.symbols)
    h = parameter(name, meaning="energy of the orbits")
    T = (h.symbol - given.potential + rest) * sp.factor(2 * sp.expand(given.kinetic - rest))
    domains = {c.name: c.domain.written(c.name) for c in given.coordinates}
    return System(
        domains, T, 0, {p.name: p for p in given.parameters} | {name: h}, signature="indefinite",
        title=f"{given.title}, orbits as geodesics" if given.title else "",
    )  # fmt: skip
