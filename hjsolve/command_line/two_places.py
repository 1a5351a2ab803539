"""The command two-point: which motions join two places in a time, as CSV or one JSON object."""

from __future__ import annotations

import csv
import json
import sys
from argparse import Namespace

from hjsolve.arguments import whole
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.propagation import short_bound
from hjsolve.command_line import arguments_read
from hjsolve.errors import InvalidInputError, of_kind
from hjsolve.mechanics.typed_texts import typed_values
from hjsolve.solution.quadratures import solve
from hjsolve.two_point.asked.answers import Connection, Connections


def print_connections(options: Namespace) -> None:
    """Print the motions that join two places, and how complete they are on the error stream.

    Raises:
        InvalidInputError: a place or the time is missing or cannot be read.
    """
    if not options.start or not options.goal or options.time is None:
        raise InvalidInputError(
            "two-point: give both places and the time, such as --from r=1 theta=0 --to r=2 theta=pi/2 --time 3"
        )
    solution = solve(arguments_read.system(options), "find" if options.find else "as given")
    found = of_kind(
        solution.two_point(
            q0=typed_values(options.start, "--from"), q1=typed_values(options.goal, "--to"), time=options.time,
            turns=turns_from_text(options.turns), digits=options.digits,
            budget=options.budget,
        ),
        Connections,
    )  # fmt: skip
    if options.json:
        json.dump(_plain(found), sys.stdout, ensure_ascii=False, indent=1, allow_nan=False)
        sys.stdout.write("\n")
        return
    writer = csv.writer(sys.stdout, lineterminator="\n")
    names = list(found[0].p0) if len(found) else []
    writer.writerow(
        ["turns", "path", "S", "error.S", "E", "conjugate_points"]
        + [f"{end}.{name}" for end in ("p0", "p1") for name in names]
        + [f"error.{end}.{name}" for end in ("p0", "p1") for name in names]
    )
    for c in found:
        momenta = [e for end in (c.p0, c.p1) for e in end.values()]
        S = c.principal_function
        writer.writerow(
            [c.turns, c.path, _written(S.value), short_bound(S.error), _written(c.energy.value), c.conjugate_points]
            + [_written(e.value) for e in momenta] + [short_bound(e.error) for e in momenta]
        )  # fmt: skip
    sys.stderr.write(f"{found}\n")


def turns_from_text(text: str) -> list[int]:
    """Read numbers of turns: ``0:3`` for 0, 1, 2 and 3, or a list such as ``0,2``.

    Args:
        text: as it was typed.

    Raises:
        InvalidInputError: it is neither.
    """
    first, colon, last = text.partition(":")
    try:
        if colon:
            return list(range(whole(int(first), "--turns", 0), whole(int(last), "--turns", int(first)) + 1))
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise InvalidInputError(f'--turns "{text}": write 0:3 for 0 to 3 whole turns, or a list such as 0,2') from None


def _written(x: object) -> str:
    return repr(x) if isinstance(x, float) else str(x)


def _plain(found: Connections) -> dict[str, object]:
    return {
        "motions": [_motion(c) for c in found],
        "continua": [{"statement": c.statement, "free": list(c.free), "turns": c.turns} for c in found.continua],
        "complete": bool(found.complete),
        "statement": str(found.complete),
        "least_time": None if found.least_time is None else _number(found.least_time),
    }


def _motion(c: Connection) -> dict[str, object]:
    return {
        "turns": c.turns, "path": c.path, "S": _number(c.principal_function), "E": _number(c.energy),
        "conjugate_points": c.conjugate_points, "p0": {n: _number(e) for n, e in c.p0.items()},
        "p1": {n: _number(e) for n, e in c.p1.items()},
    }  # fmt: skip


def _number(e: Estimate) -> dict[str, object]:
    value = e.value if isinstance(e.value, float) else str(e.value)
    return {"value": value, "error": float(short_bound(e.error))}
