"""The numbers and the states of a motion as a table on the standard output: CSV, or one JSON object."""

from __future__ import annotations

import csv
import json
import re
import sys
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.propagation import short_bound
from hjsolve.errors import InvalidInputError
from hjsolve.extended.moving_frame_motion import FramedMotion
from hjsolve.formulas.read import number
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import AnyMotion, Errors, State
from hjsolve.scenes import Run
from hjsolve.scenes.results import Trajectory

_MOST_TIMES = 1_000_000
_NUMBERS = ("constants", "turning_points", "actions", "frequencies", "periods", "boundary_times")
_GROUPS = ("q", "p", "velocity")
_DOUBLES = 15
Rows = Iterator[Sequence[object]]
Json: TypeAlias = "str | float | list[Json] | dict[str, Json] | None"


def print_motion(motion: AnyMotion, options: Namespace) -> None:
    """Print the results of a motion, or its states at the times asked.

    Raises:
        InvalidInputError: times that cannot be read.
    """
    times = None if options.times is None else times_from_text(options.times, options.digits)
    own = motion.motion if isinstance(motion, FramedMotion) and isinstance(motion.motion, Motion) else motion
    state = None if times is None else _state(motion, times)
    if options.json:
        states = {} if times is None or state is None else _plain_states(times, state)
        _print_json({"kinds": dict(own.kinds), **_plain_numbers(own), **states})
    elif times is None or state is None:
        _print_csv(("quantity", "name", "value", "error"), _number_rows(own))
    else:
        _print_csv(*_state_table(times, state))


def _state(motion: AnyMotion, times: Sequence[str | float]) -> State:
    """Return the state; in a moving frame in its coordinates Q and in those of the system as posed, q."""
    state = motion.at(times)
    if not isinstance(motion, FramedMotion):
        return state
    inner = motion.motion.at(times)

    def errors() -> Errors:
        posed, moving = state.error, inner.error
        return Errors({**moving.q, **posed.q}, {**moving.p, **posed.p}, {**moving.velocity, **posed.velocity})

    q, p, velocity = ({**getattr(inner, group), **getattr(state, group)} for group in _GROUPS)
    return State(state.t, q, p, velocity, dict(inner.turns), state.status, errors)


def print_run(run: Run, options: Namespace) -> None:
    """Print the states of a scene at its times.

    Raises:
        InvalidInputError: ``--times`` next to a scene, or a scene that wants no states.
    """
    if options.times is not None:
        raise InvalidInputError(f"--times: {options.system} is a scene, which says its times itself")
    if run.trajectory is None:
        raise InvalidInputError(f'{options.system}: wants no states; add "trajectory" to want, and times')
    times = [_written(t) for t in run.trajectory.t]
    if options.json:
        _print_json(_plain_states(times, run.trajectory))
    else:
        _print_csv(*_state_table(times, run.trajectory))


def times_from_text(text: str, digits: int) -> list[str | float]:
    """Read times: ``start:stop:count``, both ends included, or numbers with commas between them.

    Args:
        text: as it was typed.
        digits: asked for; up to 15 evenly spaced times are doubles, beyond that they are exact.

    Returns:
        Times as ``Motion.at`` takes them.

    Raises:
        InvalidInputError: it is neither, or no number.
    """
    parts = text.split(":")
    if re.search(r"\d\s*-\s*\d", text) and not re.search(r"\d[eE]-\d", text):
        raise InvalidInputError(f'--times "{text}": for a range write start:stop:count, such as 0:10:101')
    if len(parts) == 1:
        times = [part.strip() for part in text.split(",")]
        for part in times:
            number(part, source="--times")
        return [*times]
    if len(parts) != 3 or not parts[2].strip().isdigit() or not 2 <= int(parts[2]) <= _MOST_TIMES:
        raise InvalidInputError(
            f'--times "{text}": write start:stop:count with a count from 2 to {_MOST_TIMES}, such as 0:10:101, or a '
            "list such as 0,1/2,1"
        )
    start, stop = (number(part.strip(), source="--times") for part in parts[:2])
    if not (start.is_Rational and stop.is_Rational):
        raise InvalidInputError(f'--times "{text}": start and stop must be rational, such as 0, 2.5 or 1/3')
    first, last, count = Fraction(int(start.p), int(start.q)), Fraction(int(stop.p), int(stop.q)), int(parts[2])
    exact = [first + (last - first) * k / (count - 1) for k in range(count)]
    return [float(t) if digits <= _DOUBLES else str(t) for t in exact]


# ------------------------------------------------------------------------------------------------ numbers
def _number_rows(motion: AnyMotion) -> Rows:
    for name, kind in motion.kinds.items():
        yield "kind", name, kind, ""
    for quantity in _NUMBERS:
        for name, found in getattr(motion, quantity, {}).items():
            if isinstance(found, Estimate):
                yield quantity, name, _written(found.value), short_bound(found.error)
            else:
                for side, end in zip(("lower", "upper"), found):
                    if end is not None:
                        yield quantity, f"{name}.{side}", _written(end.value), short_bound(end.error)


def _plain_numbers(motion: AnyMotion) -> dict[str, Json]:
    return {quantity: {name: _plain(x) for name, x in getattr(motion, quantity, {}).items()} for quantity in _NUMBERS}


def _plain(found: Estimate | tuple[Estimate | None, ...] | None) -> Json:
    if isinstance(found, Estimate):
        return {"value": _json_number(found.value), "error": _bound(found.error), "certified": found.certified}
    return None if found is None else [_plain(end) for end in found]


# ------------------------------------------------------------------------------------------------ states
def _columns(state: State | Trajectory) -> dict[str, object]:
    """Column → array: values, whole turns, errors, status."""
    columns = {f"{group}.{name}": x for group in _GROUPS for name, x in getattr(state, group).items()}
    columns |= {f"turns.{name}": x for name, x in state.turns.items()}
    error = state.error
    elsewhere = state.place if isinstance(state, State) and state.placing is not None else {}
    if any(name not in state.q for name in elsewhere):  # not the coordinates themselves
        columns |= {f"place.{name}": x for name, x in elsewhere.items()}
    for group in (*_GROUPS, *(("place",) if any(key.startswith("place.") for key in columns) else ())):
        for name, found in getattr(error, group).items():
            columns[f"error.{group}.{name}"] = np.frompyfunc(_bound, 1, 1)(np.asarray(found, dtype=object))
    return {**columns, "status": state.status}


def _state_table(times: Sequence[str | float], state: State | Trajectory) -> tuple[Sequence[str], Rows]:
    columns = _columns(state)
    count = len(times)
    arrays = [np.broadcast_to(np.asarray(column, dtype=object), (count,)) for column in columns.values()]
    return ("t", *columns), ((t, *map(_written, row)) for t, *row in zip(times, *arrays))


def _plain_states(times: Sequence[str | float], state: State | Trajectory) -> dict[str, Json]:
    count = len(times)
    arrays = {name: np.broadcast_to(np.asarray(x, dtype=object), (count,)) for name, x in _columns(state).items()}
    return {"t": list(times), **{name: [_json_number(x) for x in array] for name, array in arrays.items()}}


# ------------------------------------------------------------------------------------------------ writing
def _written(x: object) -> str:
    """Return a number with all its digits; empty where there is none."""
    if x is None:
        return ""
    if hasattr(x, "_mpf_"):
        context: Any = getattr(x, "context", None)
        return "" if x != x else str(context.nstr(x, int(context.prec / 3.32), strip_zeros=True))
    if isinstance(x, (float, np.floating)):
        return "" if x != x else repr(float(x))
    return str(x)


def _bound(error: Mpf | float | None) -> float | None:
    """Return an error with two digits, not below itself; None where there is none."""
    return None if error is None or not np.isfinite(float(error)) else float(short_bound(error))


def _json_number(x: Mpf | float | str | None) -> Json:
    """Doubles and integers as numbers; more digits as text; None where there is no number."""
    if x is None:
        return None
    if isinstance(x, (str, np.str_)):
        return str(x)
    if hasattr(x, "_mpf_"):
        return _written(x) or None
    if isinstance(x, (int, np.integer)):
        return int(x)
    return float(x) if np.isfinite(x) else None


def _print_csv(header: Sequence[str], rows: Rows) -> None:
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)


def _print_json(content: Mapping[str, Json]) -> None:
    json.dump(content, sys.stdout, ensure_ascii=False, indent=1, allow_nan=False)
    sys.stdout.write("\n")
