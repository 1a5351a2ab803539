"""Ensembles as differentiable functions of JAX (extra ``jax``).

    J(q, p), Ω(q, p),     dJ = ∂J/∂q dq + ∂J/∂p dp,     dΩ alike

The slopes are the exact ones of ``ensemble_derivatives`` by initial data. All is computed outside of JAX
(``jax.pure_callback``), with a rule for JVPs; what is linear in the tangents is transposed by JAX itself, so that VJPs,
``grad`` and ``jacobian`` follow. JAX calls back with a processor that takes subnormal numbers for 0, where no bound on
an error need hold: a thread with the arithmetic of IEEE 754 computes for it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hjsolve import arguments
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.orbit_derivatives import ensemble_derivatives, refuse_without_derivatives
from hjsolve.ensembles.orbits import ensemble as batch_of
from hjsolve.errors import InvalidInputError, MissingExtraError
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import parameter_values
from hjsolve.solution.quadratures import Solution, solve

try:
    import jax
except ImportError as missing:
    raise MissingExtraError('hjsolve.jax needs JAX: pip install "hjsolve[jax]"') from missing

_QUANTITIES = ("actions", "frequencies")
Array = npt.NDArray[np.float64]
Columns = Mapping[str, Any]
Traced = tuple[jax.Array, ...]


def ensemble(
    system: System | Solution | str | Path,
    want: Iterable[str] = _QUANTITIES,
    *,
    parameters: Mapping[str, Any] | None = None,
    threads: int | None = None,
) -> Callable[[Columns, Columns], dict[str, Any]]:
    """Return the actions and frequencies of many orbits as a function that JAX differentiates.

    The function takes q and p, coordinate → positions and canonical momenta, numbers or arrays that broadcast, and
    works under ``jax.jit``, ``vmap``, ``jvp``, ``grad`` and ``jacobian``. It returns, in float64 arrays of the common
    shape, ``actions`` and ``frequencies`` (coordinate → array), ``error`` (bounds on the errors of the values, alike)
    and ``status`` (codes of ``hjsolve.Status``). Numbers that do not exist are nan, and so are all derivatives of an
    orbit that is not ``ok``, or whose derivatives do not converge. Bounds on the errors of derivatives are those of
    ``hjsolve.ensemble_derivatives``. There are no second derivatives.

    Args:
        system: a system, its solution, or a catalog id or path of a .toml entry; in the coordinates in which it
            separates.
        want: of ``actions``, ``frequencies``.
        parameters: name → number, where it differs from the default.
        threads: as of ``hjsolve.ensemble``.

    Raises:
        InvalidInputError: another quantity; a solution in coordinates that were found; parameters that JAX traces; from
            the function, coordinates that are not those of the system, or JAX without 64 bits; from its derivatives,
            what ``hjsolve.ensemble_derivatives`` refuses, and second ones.
        MissingExtraError: JAX is not installed.

    Example:
        >>> import jax, hjsolve.jax
        >>> jax.config.update("jax_enable_x64", True)
        >>> orbits = hjsolve.jax.ensemble("kepler-planar")
        >>> def rate(p): return orbits({"r": 1.0, "theta": 0.0}, {"r": 0.0, "theta": p})["frequencies"]["r"]
        >>> round(float(jax.grad(rate)(1.2)), 9)  # −3 √(−2E) p, E = p²/2 − 1
        -2.693993318
    """
    asked = arguments.words(want, "want", '["actions", "frequencies"]')
    for name in sorted(asked - set(_QUANTITIES)):
        raise InvalidInputError(f'want: "{name}" has no derivatives in a batch; take {" or ".join(_QUANTITIES)}')
    quantities = tuple(name for name in _QUANTITIES if name in asked)
    solution = system if isinstance(system, Solution) else solve(system)
    given = {} if parameters is None else dict(arguments.table(parameters, "parameters"))
    parameter_values(solution.system, given)  # refuses unknown names and missing values
    if solution.chart is not None:
        raise InvalidInputError(
            "hjsolve.jax: q and p are varied in coordinates that separate as they are given; give solution.system"
        )
    names = tuple(c.name for c in solution.system.coordinates)
    ask: dict[str, Any] = {"parameters": given, "threads": threads}
    first = batch_of(
        solution, dict.fromkeys(names, np.zeros(0)), dict.fromkeys(names, np.zeros(0)), want=quantities, **ask
    )
    rows = tuple((quantity, name) for quantity in quantities for name in getattr(first, quantity))
    outside = _Outside(solution, names, rows, ask)
    flat = _differentiable(outside)

    def orbits(q: Columns, p: Columns) -> dict[str, Any]:
        if jax.dtypes.canonicalize_dtype(np.float64) != np.float64:
            raise InvalidInputError('JAX rounds to 32 bits; write jax.config.update("jax_enable_x64", True) first')
        for what, group in (("q", q), ("p", p)):
            if set(arguments.table(group, what)) != set(names):
                raise InvalidInputError(
                    f"{what}: give {', '.join(names)}, not {', '.join(map(str, group)) or 'nothing'}"
                )
        try:
            numbers = [jax.numpy.asarray(group[name], dtype=float) for group in (q, p) for name in names]
            x = jax.numpy.broadcast_arrays(*numbers)
        except (TypeError, ValueError) as fault:
            raise InvalidInputError(f"q, p: numbers or arrays that broadcast are needed: {fault}") from None
        found, errors, codes = flat(*x)
        result: dict[str, Any] = {quantity: {} for quantity in quantities}
        result["error"] = {quantity: {} for quantity in quantities}
        for (quantity, name), value, error in zip(rows, found, errors, strict=True):
            result[quantity][name], result["error"][quantity][name] = value, error
        return result | {"status": codes.astype(int)}

    return orbits


class _Worker:
    """A thread that keeps the arithmetic of the thread that imports this module: threads inherit it as they begin."""

    def __init__(self) -> None:
        self.begin()
        if hasattr(os, "register_at_fork"):  # a process that is forked has no threads but one
            os.register_at_fork(after_in_child=self.begin)

    def begin(self) -> None:
        """Start the thread now, not at the first call, which is one of JAX."""
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="hjsolve.jax")
        self._pool.submit(int).result()

    def run(self, function: Callable[..., tuple[Array, ...]], x: tuple[Array, ...]) -> tuple[Array, ...]:
        """Return what a function returns there.

        Args:
            x: its arguments.
        """
        return self._pool.submit(copy_context().run, function, *x).result()


_WORKER = _Worker()


class _Outside:
    """What is computed outside of JAX, from 2n arrays of one shape to arrays of that shape."""

    def __init__(
        self, solution: Solution, names: tuple[str, ...], rows: tuple[tuple[str, str], ...], ask: dict[str, Any]
    ):
        self.solution, self.names, self.rows, self.ask = solution, names, rows, ask

    def values(self, *x: Array) -> tuple[Array, ...]:
        """Return the rows, their errors, and the codes."""
        q, p = self._given(x)
        want = {quantity for quantity, _ in self.rows}
        return self._columns(batch_of(self.solution, q, p, want=want, **self.ask))

    def derivatives(self, *x: Array) -> tuple[Array, ...]:
        """Return the same, and ∂row/∂x, row by row."""
        q, p = self._given(x)
        found = ensemble_derivatives(self.solution, q, p, by={"initial"}, **self.ask)
        slopes = [part for quantity, name in self.rows for part in found.value[quantity][name].values()]
        return (*self._columns(found.batch), *slopes)

    def _given(self, x: tuple[Array, ...]) -> tuple[dict[str, Array], dict[str, Array]]:
        n = len(self.names)
        return dict(zip(self.names, x[:n], strict=True)), dict(zip(self.names, x[n:], strict=True))

    def _columns(self, batch: Batch) -> tuple[Array, ...]:
        values = [getattr(batch, quantity)[name] for quantity, name in self.rows]
        errors = [batch.error[quantity][name] for quantity, name in self.rows]
        columns = [np.asarray(e, dtype=float) for e in (*values, *errors)]
        return (*columns, np.asarray(batch.codes, dtype=float))


def _differentiable(outside: _Outside) -> Callable[..., Any]:
    m = len(outside.rows)

    def call(function: Callable[..., tuple[Array, ...]], count: int, x: Traced) -> Traced:
        like = (jax.ShapeDtypeStruct(x[0].shape, np.float64),) * count

        def there(*x: Array) -> tuple[Array, ...]:
            # an array of JAX becomes one of numpy here: on another thread that might wait for this one
            return _WORKER.run(function, tuple(np.asarray(e, dtype=float) for e in x))

        return jax.pure_callback(there, like, *x, vmap_method="broadcast_all")

    def split(found: Traced) -> tuple[Traced, Traced, jax.Array]:
        return tuple(found[:m]), tuple(found[m : 2 * m]), found[2 * m]

    @jax.custom_jvp
    def flat(*x: jax.Array) -> tuple[Traced, Traced, jax.Array]:
        return split(call(outside.values, 2 * m + 1, x))

    @jax.custom_jvp
    def slopes_there(*x: jax.Array) -> Traced:
        return call(outside.derivatives, 2 * m + 1 + m * len(x), x)

    @slopes_there.defjvp
    def _(x: Traced, moved: Traced) -> tuple[Traced, Traced]:  # noqa: ARG001  (the names are those of JAX)
        raise InvalidInputError("hjsolve.jax: there are no second derivatives; differentiate once")

    @flat.defjvp
    def _(x: Traced, moved: Traced) -> tuple[tuple[Traced, Traced, jax.Array], tuple[Traced, Traced, jax.Array]]:
        refuse_without_derivatives(outside.solution)  # here, where an error is not one of the runtime of JAX
        found = slopes_there(*x)
        values, errors, codes = split(found)
        slopes, none = found[2 * m + 1 :], jax.numpy.zeros_like
        rates = tuple(
            sum(
                (slope * dx for slope, dx in zip(slopes[i * len(x) : (i + 1) * len(x)], moved, strict=True)), none(x[0])
            )
            for i in range(m)
        )
        return (values, errors, codes), (rates, tuple(none(e) for e in errors), none(codes))

    return flat
