"""Separability of a relativistic particle: the classical test of its energy shell, for every energy at once.

H = E squared gives (Greenwood (7-165) with p → ∂W/∂q)

    ½ (p − a)ᵀM⁻¹(p − a) − (E − V)²/(2 m₀c²) = −½ m₀c²,

a natural system with potential −(E − V)²/(2m₀c²), in which the true energy E is a parameter, at the energy −½m₀c².
It must separate for every E: both V and V² have to meet Stäckel's condition. Jacobi's integrals are then derivatives
with respect to the true E, which the separated momenta hold quadratically.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import sympy as sp

from hjsolve.errors import required
from hjsolve.mechanics.energy_shell import ReductionStep, Shell, energy_symbol
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.separation.verdicts import Constant, Separation, Verdict


def shell_system(system: System) -> System:
    """Return the natural system whose shell is the relativistic one; the true energy is a parameter of it.

    Args:
        system: of a relativistic particle.
    """
    relativity = required(system.relativity)
    energy = energy_symbol(system)
    m, c = relativity.mass, relativity.light
    return System(
        coordinates={q.name: q.domain.written(q.name) for q in system.coordinates},
        kinetic=system.kinetic,
        potential=-((energy - system.potential) ** 2) / (2 * m * c**2),
        parameters={p.name: p for p in system.parameters} | {energy.name: None},
        title=f"{system.title}, energy shell",
        id=system.id,
    )


def shell_energy(system: System) -> sp.Expr:
    """Return the value −½m₀c² that the shell's own energy has.

    Args:
        system: of a relativistic particle.
    """
    particle = required(system.relativity)
    return -particle.mass * particle.light**2 / 2


def decided(system: System, decide: Callable[[System], Verdict]) -> Verdict:
    """Decide a relativistic system by its shell.

    Args:
        system: with ``relativity``.
        decide: the test for natural systems.
    """
    verdict = decide(shell_system(system))
    if not isinstance(verdict, Separation):
        own = verdict.shell.energy if verdict.shell is not None else None
        steps = _steps(system, verdict.evidence, own)
        reduction = _steps(system, verdict.shell.steps, own) if verdict.shell is not None else ()
        shell = None if verdict.shell is None else replace(verdict.shell, system=system, steps=reduction)
        return replace(verdict, system=system, shell=shell, evidence=steps)
    energy = energy_symbol(system)
    H = hamiltonian(system)
    own = str(verdict.shell.energy)
    constants = {energy.name: Constant(energy.name, energy, H, "relativistic energy, rest energy included")}
    for name, constant in verdict.constants.items():
        if name != own:
            constants[name] = replace(constant, expression=constant.expression.subs(energy, H))
    shell = _shell(verdict.shell, system, energy, H)
    evidence = _steps(system, verdict.evidence, verdict.shell.energy)
    return replace(
        verdict, system=system, shell=shell, constants=constants, liouville=None, stackel=None, evidence=evidence
    )


def _shell(shell: Shell, system: System, energy: sp.Symbol, H: sp.Expr) -> Shell:
    """Return the shell in terms of the true energy; without essential coordinates H itself is the potential."""
    steps = _steps(system, shell.steps, shell.energy)
    potential = shell.potential if shell.coordinates else H
    return replace(shell, system=system, energy=energy, potential=potential, steps=steps)


def _steps(system: System, steps: tuple[ReductionStep, ...], own: sp.Symbol | None) -> tuple[ReductionStep, ...]:
    """Return the argument for the shell's system at its own energy −½m₀c², after the step that leads to it."""
    if own is None:
        return (_step(system), *steps)
    value = shell_energy(system)
    reduction = (
        step if step.formula is None else replace(step, formula=step.formula.xreplace({own: value})) for step in steps
    )
    return (_step(system), *reduction)


def _step(system: System) -> ReductionStep:
    relativity = required(system.relativity)
    m, c, E = relativity.mass, relativity.light, energy_symbol(system)
    text = (
        f"The relation (E - V)^2 = (H - V)^2 is quadratic in the momenta: divided by 2*{m}*{c}^2 it is the shell of a "
        f"natural system with the kinetic energy T and the potential shown, at the energy -{m}*{c}^2/2. It has to "
        f"separate for every value of the true energy {E}."
    )
    return ReductionStep("Relativistic energy shell", text, shell_system(system).potential)
