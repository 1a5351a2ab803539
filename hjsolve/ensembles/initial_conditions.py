"""The door of an ensemble: arrays of any shape and real type become doubles of one shape, or one error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hjsolve.catalog.schema import nearest
from hjsolve.errors import InvalidInputError, MissingValueError
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import System
from hjsolve.separation import Zero, is_zero

_MASKED = "a masked array; give NaN for what is missing (array.filled(nan)), such orbits get a status"


@dataclass(frozen=True)
class InitialConditions:
    """Initial conditions, checked.

    Attributes:
        kind: ``p`` or ``velocity``, what ``rates`` are.
        q, rates: coordinate → float64 array; numpy or dask; each broadcasts to ``shape``.
        shape: of the result.
        lazy: whether any of them is a dask array.
    """

    kind: str
    q: Mapping[str, Any]
    rates: Mapping[str, Any]
    shape: tuple[int, ...]
    lazy: bool


def conditions(
    system: System, q: Mapping[str, Any], p: Mapping[str, Any] | None, velocity: Mapping[str, Any] | None
) -> InitialConditions:
    """Check the initial conditions of an ensemble.

    Args:
        system: whose coordinates they are.
        q: every coordinate → array, list or number; or the columns R and z of stars about the axis z.
        p, velocity: the same, one of the two; with R and z the columns vR, vT and vz.

    Raises:
        InvalidInputError: a name that is not a coordinate, columns of a potential without that axis, an array that does
            not hold real numbers, shapes that do not broadcast against each other, p and velocity both or neither.
        MissingValueError: a coordinate without values.
    """
    if (p is None) == (velocity is None):
        raise InvalidInputError("ensemble: give either p={…} or velocity={…}, values for every coordinate")
    if _has_columns(system, q):
        q, velocity = _from_columns(system, q, velocity)
    kind, rates = ("p", p) if velocity is None else ("velocity", velocity)
    given = {("q", name): value for name, value in _complete(system, q, "q").items()}
    given |= {(kind, name): value for name, value in _complete(system, rates, kind).items()}
    arrays = {key: _doubles(value, f"{key[0]}[{key[1]}]") for key, value in given.items()}
    shape = _common_shape(arrays)
    places = {name: array for (group, name), array in arrays.items() if group == "q"}
    speeds = {name: array for (group, name), array in arrays.items() if group == kind}
    return InitialConditions(kind, places, speeds, shape, any(is_dask(array) for array in arrays.values()))


def arrays_of(
    groups: Mapping[str, Mapping[str, Any]], names: list[str]
) -> tuple[dict[str, dict[str, Any]], tuple[int, ...]]:
    """Check groups of arrays that belong to the same orbits; the first group is complete.

    Args:
        groups: what they are called → name → array, list or number.
        names: that are known.

    Returns:
        The same as float64 arrays, numpy or dask, and the shape that they broadcast to.

    Raises:
        InvalidInputError: another name, no real numbers, shapes that do not match.
        MissingValueError: a name without values in the first group.
    """
    arrays = {}
    for k, (what, given) in enumerate(groups.items()):
        if not isinstance(given, Mapping):
            raise InvalidInputError(
                f"{what}: must map coordinates to arrays, e.g. {{{names[0]!r}: …}}, not {_kind(given)}"
            )
        for name, value in given.items():
            if name not in names:
                raise InvalidInputError(f"{what}: {name!r} has none in this solution; known are {', '.join(names)}")
            arrays[what, name] = _doubles(value, f"{what}[{name}]")
        if k == 0 and (missing := [name for name in names if name not in given]):
            raise MissingValueError(f"{what}: no values for {', '.join(missing)}; all of {', '.join(names)} are needed")
    shape = _common_shape(arrays)
    found = {what: {name: arrays[what, name] for name in given} for what, given in groups.items()}
    return found, shape


def _has_columns(system: System, q: object) -> bool:
    return isinstance(q, Mapping) and "R" in q and "R" not in {c.name for c in system.coordinates}


def _from_columns(system: System, q: Mapping[str, Any], velocity: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return places and velocities of stars about the axis z, taken to be where y = 0: there nothing is rounded."""
    told = "q[R]: columns of stars are q={'R': …, 'z': …}, velocity={'vR': …, 'vT': …, 'vz': …}"
    if {c.name for c in system.coordinates} != {"x", "y", "z"}:
        names = ", ".join(c.name for c in system.coordinates)
        raise InvalidInputError(f"{told}, for a system in x, y and z; this one is in {names}")
    if not isinstance(velocity, Mapping) or set(q) != {"R", "z"} or set(velocity) != {"vR", "vT", "vz"}:
        raise InvalidInputError(f"{told}; no others, for with V symmetric about z the azimuth is only added to phi")
    x, y = (system.coordinate(name).symbol for name in "xy")
    if not isinstance(is_zero(x * system.potential.diff(y) - y * system.potential.diff(x)), Zero):
        raise InvalidInputError(f"{told}, for a potential that is symmetric about z; give x, y and z")
    return {"x": q["R"], "y": 0, "z": q["z"]}, {"x": velocity["vR"], "y": velocity["vT"], "z": velocity["vz"]}


def _complete(system: System, given: Any, what: str) -> dict[str, Any]:
    names = [c.name for c in system.coordinates]
    if not isinstance(given, Mapping):
        raise InvalidInputError(f"{what}: must map coordinates to arrays, e.g. {{{names[0]!r}: …}}, not {_kind(given)}")
    for name in given:
        if name not in names:
            raise InvalidInputError(f'{what}: no coordinate "{name}"{nearest(str(name), names)}')
    missing = [name for name in names if name not in given]
    if missing:
        raise MissingValueError(f"{what}: no values for {', '.join(missing)}; every coordinate needs them")
    return {name: given[name] for name in names}


def _doubles(value: Any, source: str) -> Any:
    """Return the values as float64; a number written as text or Fraction is rounded to the nearest double."""
    if is_dask(value):
        if any(np.isnan(size) for size in value.shape):
            raise InvalidInputError(f"{source}: has blocks of unknown size; call its compute_chunk_sizes() first")
        return _checked_kind(value, source).astype(np.float64)
    if isinstance(value, np.ma.MaskedArray):
        raise InvalidInputError(f"{source}: is {_MASKED}")
    array = _as_numpy(value, source)
    if array.shape == () and array.dtype.kind not in "fiu":
        return np.asarray(float(number(value, source=source)), dtype=np.float64)
    return _checked_kind(array, source).astype(np.float64)


def _as_numpy(value: Any, source: str) -> Any:
    """Return a numpy array of what other libraries call an array.

    By ``__array__``, or by DLPack where the type has none.

    A ``RuntimeError`` of ``__array__`` is final: torch's DLPack hands out the memory of a tensor with a negative bit
    (``z.conj().imag``) as if there was none.
    """
    shared = hasattr(value, "__dlpack__") and hasattr(value, "__dlpack_device__")
    try:
        if not shared or hasattr(value, "__array__"):
            return np.asarray(value)
    except (TypeError, RuntimeError) as error:
        if not shared or isinstance(error, RuntimeError):
            raise InvalidInputError(f"{source}: {_kind(value)} gives no numpy array: {error}") from error
    except ValueError as error:
        raise InvalidInputError(f"{source}: is not an array: its rows have different lengths") from error
    try:
        return np.from_dlpack(value)
    except (TypeError, ValueError, RuntimeError, BufferError) as error:
        raise InvalidInputError(
            f"{source}: is {_kind(value)} that gives no numbers to the processor; "
            "bring it there first (torch: .detach().cpu(), cupy: .get(), jax: jax.device_get)"
        ) from error


def _checked_kind(array: Any, source: str) -> Any:
    if array.dtype.kind not in "fiu":
        raise InvalidInputError(
            f"{source}: must hold real numbers, not {'text' if array.dtype.kind in 'US' else array.dtype.name}; "
            "give an array of floats, or one number (exact text such as '1/3' is allowed for one number)"
        )
    return array


def _common_shape(arrays: Mapping[tuple[str, str], Any]) -> tuple[int, ...]:
    try:
        return tuple(np.broadcast_shapes(*(array.shape for array in arrays.values())))
    except ValueError as error:
        shapes = ", ".join(f"{kind}[{name}] {array.shape}" for (kind, name), array in arrays.items() if array.shape)
        raise InvalidInputError(f"ensemble: shapes do not match: {shapes}; they must broadcast to one shape") from error


def is_dask(value: Any) -> bool:
    """Return whether something is a dask array."""
    return hasattr(value, "dask") and hasattr(value, "map_blocks")


def _kind(value: Any) -> str:
    return f"a {type(value).__name__}"
