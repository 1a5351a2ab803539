"""Derivatives of actions and frequencies by constants of the motion, initial data and parameters, for many orbits.

The second derivatives of the actions come from ``contour_integrals``; ∂Ω/∂α = −Ω dK K⁻¹ with K = ∂J/∂α
(``motion.derivatives.integrals``). A parameter is a variable like a constant as long as these are held; how they change
with it at fixed q and p is in their formulas (``initial_data_derivatives``). What is integrated on a path is held
against what the ensemble found between the turning points, J and Ω, which nothing but F has in common with it: where
they disagree the path holds something else too, and another one, nearer to the motion, is taken.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.engine.contour_integrals import Integrand, Seconds, along, turn
from hjsolve.ensembles.engine.kernels.path_integrals import Paths
from hjsolve.ensembles.engine.lowered_solution import lowered_model, next_to_poles, parameter_pair
from hjsolve.ensembles.engine.paths_of_librations import ATTEMPTS, placed
from hjsolve.ensembles.engine.programs import system_programs
from hjsolve.ensembles.engine.programs_of_paths import path_programs
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.initial_data_derivatives import Slopes, by_initial_data, slopes_of_constants
from hjsolve.ensembles.orbits import ensemble
from hjsolve.ensembles.shifts_of_rotations import mean_shifts
from hjsolve.ensembles.turning_point_derivatives import periods_by_constants, slopes_of_ends, tape_of_ends
from hjsolve.errors import InvalidInputError, required
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.system import System
from hjsolve.motion.derivative_values import REMARKS, SQUARE_ROOT
from hjsolve.motion.derivatives.formulas import VariedSymbols, variables_of
from hjsolve.motion.initial_data import parameter_values
from hjsolve.solution.quadratures import Solution, solve

_TURNS = (48, 192, 768)
"""Steps of a whole turn, tried one after the other."""
_SAME = 1e-10
"""How well J and Ω must agree."""
_LITTLE = 1e-12
"""What steps may leave open, over the terms of the sum, without another path being tried."""
_ASYMPTOTIC = (
    "frequencies: an orbit is on a separatrix: its frequencies are 0 and go to 0 next to it like 1/ln, so they have no "
    "derivative; J and the constants of the motion are regular variables there, and so are q and p"
)
TOLERANCE = 1e-10
"""Largest claimed error of an orbit that is ``ok``, relative to the terms that it is the sum of."""


_BY = ("constants", "initial", "parameters")

_Groups = dict[str, Any]
"""Quantity or name → what belongs to it, down to columns."""


@dataclass(frozen=True, repr=False, eq=False)
class BatchDerivatives(ByValue, Shown):
    """Derivatives of the actions, frequencies, periods and turning points of many orbits.

    Attributes:
        value: ``actions``, ``frequencies``, ``periods`` or ``turning_points`` → coordinate → constant, initial datum
            ("q.r") or parameter → array of the shape of the initial conditions, of turning points a pair (lower,
            upper) of them; nan where the status is not ``ok``.
        error: bounds on their errors, of the same shape.
        status: ``ok``; ``not_converged`` where no path was found on which the integrals agree with the ensemble's, as
            next to a separatrix (``Motion.derivatives`` has more digits); else what the ensemble says of the orbit.
        ends: coordinate → status of its turning points: that of the orbit, or ``square_root`` where the coordinate is
            at rest, its J = 0, or next to it: they grow like √J. A coordinate that goes round has none, and ``ok``.
        batch: constants, actions, frequencies and turning points of the orbits.
    """

    value: Mapping[str, Mapping[str, Mapping[str, Any]]]
    error: Mapping[str, Mapping[str, Mapping[str, Any]]]
    status: Any
    ends: Mapping[str, Any]
    batch: Batch

    @property
    def remarks(self) -> tuple[str, ...]:
        """A sentence for each reason why some derivatives do not exist, and which variables are regular there."""
        found = [
            f"turning_points: {REMARKS[SQUARE_ROOT].format(name=name)}"
            for name, words in self.ends.items()
            if np.any(words == SQUARE_ROOT)
        ]
        if np.any(self.status == Status.ASYMPTOTIC.word):
            found.append(_ASYMPTOTIC)
        return tuple(found)


@arguments.with_known_names(
    'ensemble_derivatives(system, q={"r": [1, 2], "theta": 0}, p={"r": 0, "theta": 1}, by={"constants"})'
)
def ensemble_derivatives(
    system: System | Solution | str | Path,
    q: Mapping[str, Any],
    p: Mapping[str, Any] | None = None,
    velocity: Mapping[str, Any] | None = None,
    *,
    by: Iterable[str] = ("constants",),
    parameters: Mapping[str, Any] | None = None,
    threads: int | None = None,
) -> BatchDerivatives:
    """Differentiate actions, frequencies, periods and turning points of many orbits.

    By ``constants``, those of ``Solution.constants``; by ``initial``, q and canonical p ("q.r", "p.r") are varied one
    by one; by ``parameters``, each of them at fixed q and canonical p.

    Args:
        system: a system, its solution, or a catalog id or path of a .toml entry.
        q, p, velocity, parameters, threads: as of ``ensemble``.
        by: of ``constants``, ``initial`` and ``parameters``.

    Returns:
        ``value["frequencies"]["r"]["E"]``, ``value["actions"]["r"]["p.theta"]`` and so on, with errors and statuses.

    Raises:
        InvalidInputError: as of ``ensemble``; another word; V with kinks, no coordinate that is not ignorable,
            coordinates that were found where the initial data or parameters are varied, or dask arrays.

    Example:
        >>> found = ensemble_derivatives("kepler-planar", q={"r": [1.0], "theta": 0}, p={"r": 0, "theta": [1.2]})
        >>> round(float(found.value["frequencies"]["r"]["E"][0]), 12)  # −3 √(−2E)
        -2.244994432064
    """
    solution = system if isinstance(system, Solution) else solve(system)
    refuse_without_derivatives(solution)
    varied = arguments.words(by, "by", '["initial"]')
    if not varied or varied - {*_BY}:
        raise InvalidInputError(f"by: one or more of {', '.join(_BY)} are needed, not {', '.join(sorted(varied))}")
    if varied - {"constants"} and solution.chart is not None:
        raise InvalidInputError(
            "by: initial data and parameters are varied in coordinates that separate as they are given; write "
            f'motion.derivatives(by={{"{min(varied - {"constants"})}"}}) for each orbit, or give solution.system'
        )
    want = ("constants", "actions", "frequencies", "turning_points")
    batch = ensemble(solution, q, p, velocity, want=want, parameters=parameters, threads=threads)
    if batch.lazy:
        raise InvalidInputError("ensemble_derivatives: not of dask arrays; call it for each block")
    values = parameter_values(solution.system, parameters or {})
    variables = variables_of(solution, parameters="parameters" in varied)
    found = _derivatives(solution, batch, values, variables)
    if varied == {"constants"}:
        return found
    kind, rates = ("p", p) if velocity is None else ("velocity", velocity)
    slopes = slopes_of_constants(solution, {"q": q, kind: required(rates)}, values, variables.parameters)
    held = {"initial": [key for key in slopes if "." in key], "parameters": variables.parameters, "constants": ()}
    return _at_fixed_states(found, slopes, [key for word in varied for key in held[word]], "constants" in varied)


def refuse_without_derivatives(solution: Solution) -> None:
    """Raise where no orbit of a solution can be differentiated.

    Raises:
        InvalidInputError: V has kinks, or every coordinate is ignorable.
    """
    refuse_kinks(solution.system.kinks, "ensemble_derivatives")
    if not solution.coordinates:
        raise InvalidInputError(
            "ensemble_derivatives: not where every coordinate is ignorable; write motion.derivatives(…) for each"
        )


def _at_fixed_states(found: BatchDerivatives, slopes: Slopes, keys: list[str], constants: bool) -> BatchDerivatives:
    """Return derivatives by initial data and parameters, beside those by the constants or in place of them."""
    value: _Groups = {}
    errors: _Groups = {}
    for quantity, names in found.value.items():
        value[quantity], errors[quantity] = {}, {}
        for name, own in names.items():
            claims = found.error[quantity][name]
            rows, bounds = by_initial_data(own, claims, {key: slopes[key] for key in keys})
            kept = list(next(iter(slopes.values()))) if constants else []
            value[quantity][name] = {c: own[c] for c in kept} | rows
            errors[quantity][name] = {c: claims[c] for c in kept} | bounds
    return replace(found, value=value, error=errors)


def _derivatives(
    solution: Solution, batch: Batch, values: Mapping[sp.Symbol, sp.Expr], variables: VariedSymbols
) -> BatchDerivatives:
    """Differentiate by the constants, and by parameters where constants are held."""
    names, constants = list(solution.coordinates), variables.constants
    n, N, count = len(constants), variables.count, int(np.prod(batch.shape, dtype=int))
    status = np.ravel(np.asarray(batch.status)).astype(object)
    open_ = np.flatnonzero(status == "ok")
    K, K_error = np.full((n, N, count), np.nan), np.zeros((n, N, count))
    dK, error, sizes = (np.zeros((n, n, N, count)) for _ in range(3))
    good = np.zeros(count, dtype=bool)
    # what the ensemble did not decide has no derivative either
    good[open_] = True
    # another form of p² for orbits next to poles that cancel, as in the engine
    near = next_to_poles(solution)
    for i, name in enumerate(names):
        found = _coordinate(solution, values, (name, variables), batch, open_)
        left = np.flatnonzero(~found.good)
        if near is not None and len(left):
            found.put(left, _coordinate(near, values, (name, variables), batch, open_[left]))
        numbers, _ = _numbers(batch, values, variables)
        mean, turns = mean_shifts(solution, name, values, variables, numbers[:, open_]), _goes_round(batch, name, open_)
        # paths see |J| of the shell momentum; a rotation the other way has −J, less what shifts add to p
        direction = np.sign(np.ravel(batch.actions[name])[open_] + np.where(turns, mean.value[0], 0.0))
        direction = np.where(direction == 0, 1.0, direction)
        first, second = np.where(turns, mean.first, 0.0), np.where(turns, mean.second, 0.0)
        K[i][:, open_], K_error[i][:, open_] = direction * found.first - first[0], found.first_error + first[1]
        dK[i][:, :, open_], error[i][:, :, open_] = direction * found.second - second[0], found.error + second[1]
        sizes[i][:, :, open_] = found.scale + np.abs(second[0])
        good[open_[~found.good]] = False
    others = [c for c in solution.system.coordinates if c.name not in names]
    for row, c in enumerate(others, len(names)):
        K[row] = 0.0
        # the action of an ignorable angle is its momentum: one row of the unit matrix
        K[row, constants.index(c.momentum.name)] = 1.0
    return _collected((solution, values, variables), batch, (K, K_error, dK, error, sizes), good, status)


def _numbers(batch: Batch, values: Mapping[sp.Symbol, sp.Expr], variables: VariedSymbols) -> tuple[Reals, Reals]:
    """Return the variables of all orbits and bounds on their errors, shape (variables, n)."""
    rows = [
        [np.ravel(np.asarray(table[c], dtype=float)) for c in variables.constants]
        for table in (batch.constants, batch.error["constants"])
    ]
    for symbol in variables.symbols[len(variables.constants) :]:
        number = parameter_pair(values[symbol])
        for row, x in zip(rows, (number.high, abs(number.low) * (1 + EPS)), strict=True):
            row.append(np.full(rows[0][0].shape, x))
    return np.stack(rows[0]), np.stack(rows[1])


def _goes_round(batch: Batch, name: str, open_: Integers) -> Mask:
    ends = [np.ravel(np.asarray(end, dtype=float))[open_] for end in batch.turning_points[name]]
    return np.asarray(~(np.isfinite(ends[0]) & np.isfinite(ends[1])))


def _coordinate(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], which: tuple[str, VariedSymbols], batch: Batch,
    open_: Integers,
) -> Seconds:  # fmt: skip
    """Return the second derivatives of one action; good where they agree with it."""
    model, (name, variables) = lowered_model(solution, values), which
    programs = system_programs(model, kernels=False)
    k = next(k for k, c in enumerate(model.separated) if c.name == name)
    numbers, unsure = _numbers(batch, values, variables)
    κ = numbers[: len(variables.constants)]
    known = np.ascontiguousarray(np.concatenate([numbers, unsure])[:, open_].T)
    below, above = path_programs(solution, name, values, variables)
    fixed = programs.parameters if not variables.parameters else ()
    integrand = Integrand(below, above, fixed, len(κ), known)
    ends = [np.ravel(np.asarray(end, dtype=float))[open_] for end in batch.turning_points[name]]
    goes_round, mean = (
        _goes_round(batch, name, open_),
        mean_shifts(solution, name, values, variables, numbers[:, open_]),
    )
    J = np.abs(np.ravel(batch.actions[name])[open_] + np.where(goes_round, mean.value[0], 0.0))
    J_error = np.ravel(batch.error["actions"][name])[open_] + np.where(goes_round, mean.value[1], 0.0)
    n, N, m = len(κ), len(numbers), len(open_)
    second, error, scale = (np.zeros((n, N, m)) for _ in range(3))
    first = np.full((N, m), np.nan)
    none = np.full(m, np.nan)
    result = Seconds(0 * J, 0 * J, first, 0 * first, second, error, scale, none, np.zeros(m, dtype=bool))
    done = np.zeros(m, dtype=bool)
    turning = np.flatnonzero(~goes_round)
    found = placed(model.separated[k], programs, k, np.stack(ends)[:, turning], κ[:, open_[turning]])
    open_of_last = np.ones(len(turning))
    # circles first, then lines in the strip, nearer and nearer to the motion
    for attempt in range(ATTEMPTS):
        left = np.flatnonzero(~done[turning])
        for own, tables, paths, view, proved in found.paths(left, attempt, integrand.known[turning], open_of_last):
            made = along(integrand, tables, paths, view, proved)
            open_of_last[own] = np.where(_keep(result, done, turning[own], made, J, J_error), made.left, 1.0)
    # a rotation has no turning points to go round: the path is the real axis itself
    for count in _TURNS:
        left = np.flatnonzero(~done & goes_round)
        if len(left):
            one = np.ones(len(left))
            paths = Paths(np.zeros((2, len(left))), np.ones(2), one, 0 * one, integrand.known[left])
            _keep(result, done, left, along(integrand, turn(count), paths, 0, one < 0), J, J_error)
    return result


def _keep(result: Seconds, done: Mask, some: Integers, found: Seconds, J: Reals, J_error: Reals) -> Mask:
    """Keep what agrees with the action of the ensemble and is known best; return which agree.

    An orbit is done where steps leave little open.
    """
    with np.errstate(all="ignore"):
        known = (found.error <= TOLERANCE * found.scale).all(axis=(0, 1))
        agrees = np.abs(found.action - J[some]) <= J_error[some] + _SAME * np.abs(J[some]) + 4 * found.action_error
    # of the paths that agree with the ensemble's J the one that leaves least open is kept
    right = found.good & agrees & known & ~(result.left[some] <= found.left)
    result.put(some[right], Seconds._make(new[..., right] for new in found))
    done[some] = result.good[some] & (result.left[some] <= _LITTLE)
    return agrees


class _OfFrequencies(NamedTuple):
    """Ω and ∂Ω/∂x of n orbits, from K = ∂J/∂α and its derivatives.

    Attributes:
        Ω, uncertainty: the frequencies and what the errors of K leave open of them, shape (n, i).
        slopes, bound, scale: ∂Ωᵢ/∂x, its error, and the size of its terms without signs, shape (n, i, k).
    """

    Ω: Reals
    uncertainty: Reals
    slopes: Reals
    bound: Reals
    scale: Reals


def _of_frequencies(found: tuple[Reals, Reals, Reals, Reals, Reals], good: Mask, E: int, n: int) -> _OfFrequencies:
    """Differentiate K⁻¹, whose row of the energy are the frequencies: dK⁻¹ = −K⁻¹ dK K⁻¹."""
    K, K_error, dK, error, sizes = found
    # the unit matrix stands for orbits without one, so that all inverses are taken in one call
    matrices = np.where(good, K[:, :n], np.eye(n)[:, :, None]).transpose(2, 0, 1)
    with np.errstate(all="ignore"):
        inverse = np.linalg.inv(matrices)
        # Ωᵢ = ∂E/∂Jᵢ
        Ω = inverse[:, E, :]
        size = np.abs(inverse)
        row, rows = Ω[:, None, :], np.abs(Ω)[:, None, :]
        slopes, unsure, wide = (x.transpose(3, 2, 0, 1) for x in (dK, error + 8 * EPS * np.abs(dK), sizes))  # k, i, j
        varied = range(slopes.shape[1])
        # dK⁻¹ = −K⁻¹ dK K⁻¹, of which Ω is one row
        dΩ = -np.concatenate([row @ slopes[:, k] @ inverse for k in varied], axis=1).transpose(0, 2, 1)
        unsure_K = np.where(good, K_error[:, :n] + 64 * EPS * np.abs(K[:, :n]), 0.0).transpose(2, 0, 1)
        spread = size @ unsure_K @ size  # what the errors of K leave open of K⁻¹
        bound, terms = [], []
        for k in varied:
            steep = np.abs(slopes[:, k])
            # first order in what is not known of both factors K⁻¹
            rounded = rows @ steep @ spread + spread[:, E : E + 1, :] @ steep @ size
            # the size of all terms without signs: the claim is relative to it, as the derivative itself may vanish
            terms.append(rows @ wide[:, k] @ size)
            bound.append(rows @ unsure[:, k] @ size + rounded)
        bounds = np.concatenate(bound, axis=1).transpose(0, 2, 1) + 64 * EPS * np.abs(dΩ)
        scale = np.concatenate(terms, axis=1).transpose(0, 2, 1)
    return _OfFrequencies(Ω, spread[:, E, :], dΩ, bounds, scale)


def _collected(
    what: tuple[Solution, Mapping[sp.Symbol, sp.Expr], VariedSymbols], batch: Batch,
    found: tuple[Reals, Reals, Reals, Reals, Reals], good: Mask, status: Any,
) -> BatchDerivatives:  # fmt: skip
    """∂J/∂α and ∂Ω/∂α with their errors, the frequencies checked, and what follows from them."""
    solution, _, variables = what
    K, K_error, *_ = found
    constants, names = list(variables.constants), list(solution.coordinates)
    varied = [*constants, *variables.parameters]
    order = names + [c.name for c in solution.system.coordinates if c.name not in names]
    energy = constants.index(solution.separation.shell.energy.name)
    Ω, uncertainty_of_Ω, dΩ, bound, scale = _of_frequencies(found, good, energy, len(constants))
    _check(batch, order, Ω, uncertainty_of_Ω, good)
    with np.errstate(all="ignore"):
        good &= (bound <= TOLERANCE * scale).all(axis=(1, 2))
    status = np.where(~good & (status == "ok"), "not_converged", status)

    def shaped(x: Reals) -> Reals:
        return np.where(good, x, np.nan).reshape(batch.shape)

    value: _Groups = {"actions": {}, "frequencies": {}, "periods": {}}
    errors: _Groups = {"actions": {}, "frequencies": {}, "periods": {}}
    for i, name in enumerate(order):
        if name in batch.actions:
            value["actions"][name] = {c: shaped(K[i, j]) for j, c in enumerate(varied)}
            uncertainty = K_error[i].max(axis=0) + 64 * EPS * np.abs(K[i]).max(axis=0)
            errors["actions"][name] = {c: shaped(uncertainty) for c in varied}
        if name in batch.frequencies:
            value["frequencies"][name] = {c: shaped(dΩ[:, i, j]) for j, c in enumerate(varied)}
            errors["frequencies"][name] = {c: shaped(bound[:, i, j]) for j, c in enumerate(varied)}
            own = np.ravel(batch.frequencies[name]), np.ravel(batch.error["frequencies"][name])
            periods = [periods_by_constants(own, (dΩ[:, i, j], bound[:, i, j])) for j in range(len(varied))]
            value["periods"][name] = {c: shaped(x) for c, (x, _) in zip(varied, periods, strict=True)}
            errors["periods"][name] = {c: shaped(x) for c, (_, x) in zip(varied, periods, strict=True)}
    value["turning_points"], errors["turning_points"], ends = _ends(what, batch, good, status)
    return BatchDerivatives(value, errors, status.reshape(batch.shape), ends, batch)


def _ends(
    what: tuple[Solution, Mapping[sp.Symbol, sp.Expr], VariedSymbols], batch: Batch, good: Mask, status: Any
) -> tuple[_Groups, _Groups, _Groups]:
    """∂q/∂x of the turning points, their errors, and the statuses of them."""
    solution, values, variables = what
    varied, numbers = [*variables.constants, *variables.parameters], _numbers(batch, values, variables)
    fixed = () if variables.parameters else lowered_model(solution, values).numbers
    value: _Groups = {}
    errors: _Groups = {}
    statuses: _Groups = {}
    for name in solution.coordinates:
        places, open_ = (
            np.stack([np.ravel(np.asarray(end, dtype=float)) for end in table[name]])
            for table in (batch.turning_points, batch.error["turning_points"])
        )
        tape = tape_of_ends(solution, name, values, variables)
        found = slopes_of_ends(tape, fixed, (places, open_), numbers)
        # F_q is not known from 0: the end moves like √J there
        lost = good & (np.isfinite(places) & np.isnan(found.value).any(axis=0)).any(axis=0)
        fine = good & ~lost
        statuses[name] = np.where(lost, SQUARE_ROOT, status).reshape(batch.shape)
        for table, rows in ((value, found.value), (errors, found.error)):
            kept = np.where(fine, rows, np.nan).reshape(len(varied), 2, *batch.shape)
            table[name] = {c: (kept[j, 0], kept[j, 1]) for j, c in enumerate(varied)}
    return value, errors, statuses


def _check(batch: Batch, order: Iterable[str], Ω: Reals, spread: Reals, good: Mask) -> None:
    """Drop the orbits whose frequencies on the path are not those of the ensemble."""
    for i, name in enumerate(order):
        if name in batch.frequencies:
            there = np.ravel(batch.frequencies[name])
            with np.errstate(all="ignore"):
                # Ω from the path and from the nodes between turning points: nothing but F is common to both
                near = np.abs(Ω[:, i] - there) <= _SAME * np.abs(there) + spread[:, i]
            good &= near
