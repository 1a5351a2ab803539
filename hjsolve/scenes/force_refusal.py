"""Why a scene cannot be solved by quadratures when forces act that no T and V contain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.mechanics.system import System


@dataclass(frozen=True)
class Dissipative:
    """The verdict on a system with forces outside T and V: there is no Hamilton–Jacobi equation.

    Attributes:
        system: the system without the forces.
        pair: the coordinates that the forces act on.
        part: ``dissipation``.
        residual: dH/dt = Σ Qᵢ q̇ᵢ, which would have to vanish for the energy to be a constant of the motion.
        advice: what to do instead.
    """

    system: System
    pair: tuple[str, ...]
    part: str
    residual: sp.Expr
    advice: str


def dissipative(system: System, forces: Mapping[str, sp.Expr]) -> Dissipative:
    """Make the verdict; Greenwood (3-4), (3-5): with Rayleigh's function F, the power is −2F.

    Args:
        system: without the forces.
        forces: coordinate → generalized force Q.
    """
    power = sp.Add(*(force * system.coordinate(name).velocity for name, force in forces.items()))
    advice = 'leave the effect out, or write method = "integrate" to run the scene through an ODE integrator'
    return Dissipative(system, tuple(forces), "dissipation", sp.expand(power), advice)


def force_words(verdict: Dissipative) -> str:
    """Return the error's line.

    Args:
        verdict: what the error is about.
    """
    return (
        f"a force that no T and V contain acts on {', '.join(verdict.pair)}: dH/dt = {verdict.residual}, so the energy "
        f"is not a constant and Hamilton-Jacobi does not apply; {verdict.advice}"
    )
