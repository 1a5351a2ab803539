"""Relativistic kinetic energy: formulas in the momenta and velocities of a classical T that has the same metric.

With T = ½ q̇ᵀM q̇ + a·q̇ of a particle of rest mass m₀ (M proportional to m₀),

    H = c √(m₀²c² + m₀ (p − a)ᵀM⁻¹(p − a)) + V        (Greenwood (7-165), (7-170)),
    q̇ = c m₀ M⁻¹(p − a) / √(…),     p = a + γ M q̇,     γ = (1 − q̇ᵀM q̇/(m₀c²))^(−1/2)      (7-159), (7-162).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.coordinates_and_parameters import Parameter


@dataclass(frozen=True)
class Relativity:
    """Which parameters are the rest mass and the speed of light."""

    mass: sp.Symbol
    light: sp.Symbol

    def energy(self, square: sp.Expr) -> sp.Expr:
        """H − V, given (p − a)ᵀM⁻¹(p − a).

        Args:
            square: (p − a)ᵀM⁻¹(p − a), M and a those of the classical T.
        """
        return self.light * sp.sqrt(self.mass**2 * self.light**2 + sp.expand_mul(self.mass * square))

    def speeds(self, classical: Sequence[sp.Expr], square: sp.Expr) -> list[sp.Expr]:
        """Return the velocities, given M⁻¹(p − a) and (p − a)ᵀM⁻¹(p − a).

        Args:
            classical: M⁻¹(p − a), shape (n,).
            square: (p − a)ᵀM⁻¹(p − a).
        """
        root = sp.sqrt(self.mass**2 * self.light**2 + sp.expand_mul(self.mass * square))
        return [self.light * self.mass * speed / root for speed in classical]

    def momenta(self, linear: Sequence[sp.Expr], classical: Sequence[sp.Expr], square: sp.Expr) -> list[sp.Expr]:
        """Return the momenta, given a, M q̇ and q̇ᵀM q̇.

        Args:
            linear: a of T₁ = Σ a_i q̇_i, shape (n,).
            classical: M q̇, shape (n,).
            square: q̇ᵀM q̇.
        """
        γ = 1 / sp.sqrt(1 - sp.expand_mul(sp.expand_mul(square) / self.mass) / self.light**2)
        return [a + γ * p for a, p in zip(linear, classical)]


def relativity_of(given: Mapping[str, str] | None, parameters: Sequence[Parameter]) -> Relativity | None:
    """Read ``{"mass": name, "light": name}``.

    Args:
        given: names of the parameters that are the rest mass and the speed of light; None for a classical system.
        parameters: as declared.

    Raises:
        InvalidSystemError: other keys, names that are no parameters, or parameters that may be negative.
    """
    if given is None:
        return None
    known = {p.name: p for p in parameters}
    if set(given) != {"mass", "light"}:
        raise InvalidSystemError('relativity: give the parameters {"mass": name, "light": name}, nothing else')
    for key, name in given.items():
        if name not in known:
            raise InvalidSystemError(f'relativity.{key}: "{name}" is not a parameter of the system')
        if known[name].assume != "positive":
            raise InvalidSystemError(f'relativity.{key}: declare {name} with assume = "positive"')
    return Relativity(known[given["mass"]].symbol, known[given["light"]].symbol)
