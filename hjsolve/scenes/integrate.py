"""A detour round Hamilton–Jacobi, only when a scene asks for it: Hamilton's equations with forces, integrated in time.

    q̇ = ∂H/∂p,   ṗ = −∂H/∂q + Q(q, q̇)          (Greenwood (4-27) with Q′; P4-2)

DOP853 (Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, §II.10) from scipy. The whole run is made
twice, the second time with the tolerance a hundred times finer; their difference is the error stated, and the run is
repeated finer still until it is below what the scene asks. What separation would have kept constant is followed along
the way: the drift of the former constants is part of the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve import catalog
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.arithmetic.work_counter import WorkCount
from hjsolve.catalog.effects import with_effects
from hjsolve.errors import MissingExtraError, NotConvergedError, required
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.mechanics.system import System, hamiltonian, momenta, velocities
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.state import Errors
from hjsolve.scenes.question import Question
from hjsolve.scenes.results import Run, Trajectory
from hjsolve.scenes.steps import Flow, Sampled, integrate_steps
from hjsolve.scenes.trajectory import sampled
from hjsolve.separation import Separation, separate

_FINEST = 2.3e-14


@dataclass(frozen=True)
class Numbers:
    """The start of a scene: exact, and in double precision.

    Attributes:
        parameters: by symbol, exact.
        exact: the state (q, p), exact.
        state: the same as doubles, shape (2n,).
        start: the initial time.
    """

    parameters: Mapping[sp.Symbol, sp.Expr]
    exact: tuple[sp.Expr, ...]
    state: Reals
    start: float


def integrated(scene: Question) -> Run:
    """Integrate a scene.

    Args:
        scene: what is asked; its ``method`` is ``integrate``.

    Returns:
        The run: trajectory and drift; no arcs, no quadratures.

    Raises:
        MissingExtraError: scipy is not installed.
        NotConvergedError: the digits asked were not reached.
    """
    try:
        import scipy  # noqa: F401 - here to fail early and plainly
    except ImportError as missing:
        raise MissingExtraError('method = "integrate" needs scipy: pip install "hjsolve[integrate]"') from missing
    numbers = numbers_of(scene)
    flow = flow_of(scene, numbers)
    times = np.array([float(t) for t in sampled(required(scene.times), 15)])
    best, error = _converged(scene, flow, numbers, times)
    drift = _drift(scene, numbers, best.states) if "constants" in scene.want else {}
    trajectory = _trajectory(scene, flow, times, best, error) if "trajectory" in scene.want else None
    return Run(scene, None, (), trajectory, drift, WorkCount(squares=0, kernels=0, places=flow.calls))


def numbers_of(scene: Question) -> Numbers:
    """Work out where a scene starts, momenta from velocities."""
    system, start = scene.system, required(scene.initial)
    values = dict(parameter_values(system, scene.parameters))
    parameters = dict(values)
    values |= {c.symbol: number(start.q[c.name], source=f"q[{c.name}]") for c in system.coordinates}
    if start.p is not None:
        p = {c.name: number(start.p[c.name], source=f"p[{c.name}]") for c in system.coordinates}
    else:
        speeds = {
            c.velocity: number(required(start.velocity)[c.name], source=f"velocity[{c.name}]")
            for c in system.coordinates
        }
        p = {name: formula.xreplace({**values, **speeds}) for name, formula in momenta(system).items()}
    state = [values[c.symbol] for c in system.coordinates] + [p[c.name] for c in system.coordinates]
    return Numbers(parameters, tuple(state), np.array([float(sp.N(x, 20)) for x in state]), float(sp.N(start.t, 20)))


def _compiled(formulas: list[sp.Expr], scene: Question, numbers: Numbers) -> Callable[[Reals], Reals]:
    """Return formulas of (q, p) as a function of the state: shape (2n,) or (2n, m) in, (number of formulas, …) out."""
    variables = [c.symbol for c in scene.system.coordinates] + [c.momentum for c in scene.system.coordinates]
    tape: Tape = lower(formulas, [*variables, *numbers.parameters])
    fixed = [float(sp.N(value, 20)) for value in numbers.parameters.values()]

    def evaluate(state: Reals) -> Reals:
        with np.errstate(all="ignore"):
            values = tape.run(Float64(), [*state, *fixed])
        return np.array([np.broadcast_to(v, np.shape(state)[1:]) for v in values])

    return evaluate


def slopes_of(scene: Question) -> list[sp.Expr]:
    """Hamilton's equations with the scene's forces: q̇ and then ṗ, in q, p and parameters.

    Returns:
        Length 2n.
    """
    system = scene.system
    H, speeds = hamiltonian(system), velocities(system)
    known = {c.velocity: speeds[c.name] for c in system.coordinates}
    slopes = [speeds[c.name] for c in system.coordinates]
    return slopes + [
        -sp.diff(H, c.symbol) + scene.forces.get(c.name, sp.S.Zero).subs(known) for c in system.coordinates
    ]


def flow_of(scene: Question, numbers: Numbers) -> Flow:
    """Give the equations of motion of a scene in double precision.

    Args:
        numbers: parameters and start of the motion.
    """
    return Flow(scene.system, _compiled(slopes_of(scene), scene, numbers), dict(numbers.parameters))


def _converged(scene: Question, flow: Flow, numbers: Numbers, times: Reals) -> tuple[Sampled, Reals]:
    """Run with finer and finer tolerance until two runs agree to the digits asked."""
    digits = scene.digits
    tolerance = 10.0 ** -(digits - 1)
    coarse = integrate_steps(flow, scene.events, numbers.start, numbers.state, times, tolerance)
    while True:
        tolerance = max(tolerance / 100, _FINEST)
        fine = integrate_steps(flow, scene.events, numbers.start, numbers.state, times, tolerance)
        error = np.abs(fine.states - coarse.states)
        scale = np.maximum(np.max(np.abs(fine.states), axis=1), 1e-300)
        worst = float(np.max(np.max(error, axis=1) / scale))
        if worst <= 10.0**-digits:
            return fine, 4 * np.maximum.accumulate(error, axis=1) + 16 * tolerance * scale[:, None]
        if tolerance <= _FINEST:
            raise NotConvergedError(
                f"{scene.source}: the integrator reached {worst:.1e}, not {digits} digits; ask for fewer, or less time"
            )
        coarse = fine


def former(scene: Question) -> tuple[Separation | None, tuple[str, ...]]:
    """Return the separation whose constants no longer hold, with as many of the scene's effects as keep it separable.

    Args:
        scene: one that does not separate.

    Returns:
        The separation, None where there is none; and the names of the effects it keeps.
    """
    kept: tuple[str, ...] = ()
    found: Separation | None = None
    for names in [(), *((name,) for name in scene.effects)]:
        trial = kept + names
        if any(scene.table.get("effects", {}).get(name, {}).get("force") for name in trial):
            continue
        system = catalog.from_table(with_effects(scene.table, trial, scene.source), source=scene.source)
        verdict = separate(system)
        if isinstance(verdict, Separation):
            found, kept = verdict, trial
    return found, kept


def _drift(scene: Question, numbers: Numbers, states: Reals) -> dict[str, Reals]:
    """Former constant → its value minus its value at the start; ``E`` is that of the full system."""
    verdict, _ = former(scene)
    formulas = {"E": hamiltonian(scene.system)}
    if verdict is not None:
        formulas |= {name: c.expression for name, c in verdict.constants.items() if name != str(verdict.shell.energy)}
    formulas = {name: _same_symbols(formula, scene.system) for name, formula in formulas.items()}
    evaluate = _compiled(list(formulas.values()), scene, numbers)
    begin = evaluate(numbers.state[:, None])
    return dict(zip(formulas, evaluate(states) - begin, strict=True))


def _same_symbols(formula: sp.Expr, system: System) -> sp.Expr:
    """Return the formula in the symbols of the full system (assumptions of a symbol do not depend on effects)."""
    known = {s.name: s for s in system.symbols.values()} | {c.momentum.name: c.momentum for c in system.coordinates}
    return formula.xreplace({s: known[s.name] for s in formula.free_symbols if s.name in known})


def _trajectory(scene: Question, flow: Flow, times: Reals, best: Sampled, error: Reals) -> Trajectory:
    names = [c.name for c in scene.system.coordinates]
    n, turns = len(names), dict[str, Integers]()
    q = {name: best.states[i] for i, name in enumerate(names)}
    p = {name: best.states[n + i] for i, name in enumerate(names)}
    for c in scene.system.coordinates:
        if c.domain.kind == "angle":
            turns[c.name] = np.ceil((q[c.name] - np.pi) / (2 * np.pi)).astype(int)
            q[c.name] = q[c.name] - 2 * np.pi * turns[c.name]
    slopes = flow.slopes(best.states)
    velocity = {name: slopes[i] for i, name in enumerate(names)}

    def errors() -> Errors:
        shifted = flow.slopes(best.states + error) - slopes
        return Errors(
            {name: error[i] for i, name in enumerate(names)}, {name: error[n + i] for i, name in enumerate(names)},
            {name: 2 * np.abs(shifted[i]) + 1e-15 * np.abs(velocity[name]) for i, name in enumerate(names)},
        )  # fmt: skip

    status = np.full(times.shape, "ok")
    return Trajectory(times, q, p, velocity, turns, status, best.arcs, errors)
