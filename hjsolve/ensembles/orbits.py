"""ensemble(): many orbits of one system at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from hjsolve import arguments, catalog
from hjsolve.coordinates.charts.outer_map import SphereMap
from hjsolve.display.progress import ProgressBar, Tally
from hjsolve.ensembles.axial_symmetry import about_axis
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.compute import Columns, compute_columns
from hjsolve.ensembles.initial_conditions import InitialConditions, conditions
from hjsolve.ensembles.layout import Layout, layout_of
from hjsolve.ensembles.task import EnsembleTask
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.quantities_given import in_units
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.velocity_frame import COORDINATE, factors_of, lengths_in_units
from hjsolve.solution.quadratures import AS_GIVEN, Solution, refuse_null, solve

_QUIET = 2.0
"""Seconds until the progress of an ensemble is shown."""


@arguments.with_known_names('ensemble(system, q={"r": [1, 2], "theta": 0}, velocity={"r": 0, "theta": [1.2, 0.8]})')
def ensemble(
    system: System | Solution | str | Path,
    q: Mapping[str, Any] | None = None,
    p: Mapping[str, Any] | None = None,
    velocity: Mapping[str, Any] | None = None,
    *,
    actions: Mapping[str, Any] | None = None,
    angles: Mapping[str, Any] | None = None,
    kinds: Mapping[str, str] | None = None,
    want: Iterable[str] | str | None = None,
    parameters: Mapping[str, Any] | None = None,
    threads: int | None = None,
    fallback: bool = True,
    compiled: bool | None = None,
    coordinates: str = AS_GIVEN,
    velocity_frame: str = COORDINATE,
    shown: bool | None = None,
) -> Batch:
    """Compute the actions, frequencies, … of many orbits of one system.

    A bad orbit (NaN, outside the domain, forbidden, unbounded) gets a status and NaN, and does not stop the batch.
    Every double of the input counts as the number it is; every error bound says how far the result can be from what
    that input gives. The result depends neither on the number of threads nor on what other orbits are in the ensemble
    (the last bits of states from actions may).

    Args:
        system: a system, its solution, or a catalog id or path of a .toml entry.
        q: every coordinate → array of positions, any shape, any real type; numbers and arrays broadcast. Dask arrays
            make the result lazy, one task a block.
        p: every coordinate → canonical momentum, or
        velocity: every coordinate → velocity. A system in x, y, z that is symmetric about z takes columns of stars
            as well: q with R and z, velocity with vR, vT and vz; the azimuth is 0.
        actions: instead of q, p and velocity: every coordinate that has an action → array of J; the result is the state
            with these actions, ``batch.q["r"]`` and ``batch.p["r"]`` (lazy from dask arrays, as with q). Where several
            wells have them an orbit is ``ambiguous``, unless ``q`` says a place in the one that is meant.
        angles: with actions, the same names → angle variables in radians; 0 where left out.
        kinds: with actions, separated coordinate → libration or rotation, where both have the same actions.
        want: ``state`` with actions, else of
            ``actions``, ``frequencies``, ``periods``, ``angles``, ``constants``, ``turning_points``; nothing else
            is computed. None for all.
        parameters: name → number, where it differs from the default; the same for all orbits.
        threads: how many; None for all cores that this process may use. Dask has its own, this is not for it.
        fallback: compute orbits that the vectorised engine hands back one by one, up to some tenths of a second each;
            without, they are ``not_converged``.
        compiled: accepted and ignored. Kernels are compiled once for all systems where numba is installed (extra
            ``fast``); ``HJSOLVE_COMPILED=0`` in the environment runs them as plain Python.
        coordinates: ``as given``, or ``find`` for others where the given ones do not separate, as of ``solve``: q, p
            and velocity stay those of the system as given, and the columns are those of the separated coordinates.
        velocity_frame: ``coordinate``: velocities are the rates of the coordinates; ``orthonormal``: lengths per time
            along their unit vectors (v_R, v_T = R φ̇, v_z), in polar, cylindrical, spherical or Cartesian coordinates.
        shown: whether progress is shown on standard error from two seconds on; None: on a terminal.

    Returns:
        The batch; ``batch.actions["r"]`` has the shape of the initial conditions.

    Raises:
        InvalidInputError: an unknown name, shapes that do not match, arrays that hold no real numbers.
        MissingValueError: a coordinate or a parameter without a value.
        NotSeparableError: the system does not separate; the error carries the verdict.

    Example:
        >>> batch = ensemble("kepler-planar", q={"r": [1.0, 2.0], "theta": 0}, p={"r": 0, "theta": 1.2}, want="actions")
        >>> batch.status.tolist(), [round(float(J), 6) for J in batch.actions["r"]]
        (['ok', 'ok'], [0.136306, 0.05])
    """
    arguments.refuse_other(fallback, bool, "fallback", "True or False is needed")
    arguments.refuse_other(shown, (bool, type(None)), "shown", "True, False or None (on a terminal) is needed")
    arguments.refuse_other(compiled, (bool, type(None)), "compiled", "True, False or None is needed")
    solution = _solution(system, coordinates)
    refuse_null(solution)
    if actions is not None:
        momenta = {"p": p is not None, "velocity": velocity is not None}
        arguments.refuse_unused(momenta, "actions={…} and angles={…} give the orbits")
        from hjsolve.ensembles.states_from_actions import batch_of_states

        return batch_of_states(
            solution, actions=actions, angles=angles, q=q, kinds=kinds, want=want, parameters=parameters,
            fallback=fallback, threads=threads,
        )  # fmt: skip
    arguments.refuse_unused({"angles": angles is not None, "kinds": kinds is not None}, "there are no actions={…}")
    given, layout = _starts(solution.system_as_given, q, p, velocity, velocity_frame), layout_of(solution, want)
    parameters = in_units(solution.system_as_given, parameters, "parameters")
    task = task_for(solution, layout.want, parameters, given.kind, fallback=fallback, frame=velocity_frame)
    return _batch(task, layout, given, threads, shown)


def _starts(
    users: System, q: Mapping[str, Any] | None, p: Mapping[str, Any] | None, velocity: Mapping[str, Any] | None,
    frame: str,
) -> InitialConditions:  # fmt: skip
    """Read the initial conditions: units off, lengths along unit vectors as they are."""
    if q is None:
        raise InvalidInputError('ensemble: no q={…}; write ensemble(system, q={"r": [1, 2]}, p={"r": 0})')
    q, factors = in_units(users, q, "q"), factors_of(users, frame, velocity)
    if factors is None or velocity is None:
        velocity = in_units(users, velocity, "velocity")
    else:
        velocity = lengths_in_units(users, velocity, factors)
    return conditions(users, q, in_units(users, p, "p"), velocity)


def _batch(
    task: EnsembleTask, layout: Layout, given: InitialConditions, threads: int | None, shown: bool | None
) -> Batch:  # fmt: skip
    """Compute the columns at once, or a lazy batch from arrays of dask."""
    if given.lazy:
        from hjsolve.ensembles.dask_blocks import lazily

        return lazily(task, layout, given)
    columns = _at_once(task, given, None if threads is None else arguments.whole(threads, "threads", 1), shown)
    return Batch({name: column.reshape(given.shape) for name, column in columns.items()}, layout, given.shape)


def task_for(
    solution: Solution, want: tuple[str, ...], parameters: Mapping[str, Any] | None, kind: str, *,
    fallback: bool = True, frame: str = COORDINATE,
) -> EnsembleTask:  # fmt: skip
    """Write the task of an ensemble: every parameter with its exact value.

    Args:
        want: quantities, in the order of the layout.
        parameters: name → number; the others take their defaults.
        kind: ``p`` or ``velocity``, what comes with the places.
        fallback: whether orbits that the vectorised engine hands back go to the engine of single motions.
        frame: of the velocities.

    Raises:
        InvalidInputError: an unknown parameter, or one with several values.
        MissingValueError: a parameter without a value.
    """
    if solution.chart is not None and isinstance(solution.chart.outer, SphereMap):
        raise InvalidInputError(
            "coordinates: ensembles are not started in the angles of a sphere where other coordinates were found; "
            "start each motion by solution.motion(q=…, velocity=…), or them all in the system of a web found"
        )
    about_axis(solution, frame)  # refuses starts that would be rounded
    exact = parameter_values(solution.system, _numbers(parameters))
    values = tuple((symbol.name, exact[symbol]) for symbol in sorted(exact, key=lambda s: s.name))
    found = None if solution.chart is None else solution
    return EnsembleTask(solution.system_as_given, want, values, kind, fallback, found, frame)


def _solution(system: Any, coordinates: str) -> Solution:
    if isinstance(system, Solution):
        return system
    if isinstance(system, str) and not system.endswith(".toml"):
        return _entry(system, coordinates)
    return solve(system_of(system, "ensemble"), coordinates)


@lru_cache(maxsize=16)
def _entry(name: str, coordinates: str) -> Solution:
    """Return the solution of a catalog entry: reading it takes as long as tens of thousands of orbits."""
    return solve(catalog.load(name), coordinates)


def _numbers(parameters: Mapping[str, Any] | None) -> dict[str, Any]:
    for name, value in arguments.table(parameters, "parameters", '{"m": 1}').items():
        if getattr(value, "shape", ()) != () or isinstance(value, (list, tuple)):
            raise InvalidInputError(f"parameters[{name}]: one number for all orbits is needed; call once a value")
    return dict(parameters or {})


def _at_once(task: EnsembleTask, given: InitialConditions, threads: int | None, shown: bool | None) -> Columns:
    names = [c.name for c in task.system.coordinates]

    def flat(array: Any) -> Any:
        return np.broadcast_to(array, given.shape).reshape(-1)

    q, rates = ([flat(group[n]) for n in names] for group in (given.q, given.rates))
    with ProgressBar(shown=shown, after=_QUIET) as progress:
        return compute_columns(task, q, rates, threads=threads, done=Tally(math.prod(given.shape), 0, progress).add)
