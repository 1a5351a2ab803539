"""Derivatives of random motions: is every claimed error at least the true one?

    python -m benchmarks.derivatives_campaign --motions 10000 --seed 1

Random motions over the whole catalog (``tests/support/random_motions``): hard starts on purpose, at turning points,
next to ends of domains, nearly at rest. Each is differentiated by all initial data and all parameters, and compared
along one random direction of them all with differences of motions of ``DIGITS`` digits, (f(h) − f(−h))/2h with
h = 10^−15: right to 25 digits where the third derivatives are no larger than 10^5. Status 1 where an error is larger
than was claimed.
"""

from __future__ import annotations

import argparse
import collections
import random
import signal
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import mpmath
import sympy as sp

from hjsolve.errors import HJSolveError
from tests.support import random_motions

DIGITS = 42
STEP = sp.Rational(1, 10**15)
QUANTITIES = ("actions", "frequencies", "angles", "turning_points", "state")
_LONGEST = 60
"""Seconds for one motion and its two neighbours."""
number = mpmath.mp.clone()
number.dps = 60


class TooLongError(Exception):
    """A motion took longer than ``_LONGEST``."""


def values(motion: Any, t: str) -> dict[tuple[str, ...], Any]:
    """Everything that is differentiated, as many-digit numbers."""
    state, found = motion.at(t), {}
    for name in state.q:
        found["q", name], found["p", name] = state.unwrapped(name), state.p[name]
    for quantity in ("actions", "frequencies"):
        found |= {(quantity, name): e.value for name, e in getattr(motion, quantity).items()}
    for name, ends in motion.turning_points.items():
        if motion.kinds[name] != "equilibrium":
            found |= {("turning_points", name, k): e.value for k, e in enumerate(ends) if e is not None}
    if motion.frequencies:
        found |= {("angles", name): x for name, x in motion.angles(t).items()}
    return found


def neighbours(solution: Any, motion: Any, direction: dict[tuple[str, str], sp.Expr], t: str) -> dict[Any, Any]:
    """Return Derivatives along a direction, by differences of motions of many digits."""
    system, initial = solution.system, motion.initial.values
    base = {
        "q": {c.name: initial[c.symbol] for c in system.coordinates},
        "p": {c.name: initial[c.momentum] for c in system.coordinates},
        "parameters": {p.name: initial[p.symbol] for p in system.parameters},
    }
    columns = []
    for k in (1, -1):
        moved = {group: dict(own) for group, own in base.items()}
        for (group, name), x in direction.items():
            moved[group][name] = moved[group][name] + k * STEP * x
        columns.append(values(solution.motion(**moved, digits=DIGITS), t))
    result, h = {}, number.mpf(STEP.p) / STEP.q
    for key in set.intersection(*(set(c) for c in columns)):
        f = [number.convert(c[key]) for c in columns]
        if key[0] == "angles":
            f = [f[0], *(x - 2 * number.pi * number.nint((x - f[0]) / (2 * number.pi)) for x in f[1:])]
        result[key] = (f[0] - f[1]) / (2 * h)
    return result


def judged(index: int, seed: int, counts: collections.Counter[str]) -> list[str]:
    """Differentiate one motion; the claims that do not hold, in words."""
    draw = random_motions.draw(seed, index)
    rng = random.Random(f"derivatives/{seed}/{index}")
    solution = random_motions.solution(draw.entry)
    motion = solution.motion(**draw.arguments)
    t = f"{rng.uniform(-3, 3) * max((float(p.value) for p in motion.periods.values()), default=1.0):.9g}"
    found = motion.derivatives(QUANTITIES, ("initial", "parameters"), t=t)
    system = solution.system
    keys = [(g, c.name) for g in ("q", "p") for c in system.coordinates]
    keys += [("parameters", p.name) for p in system.parameters if p.assume != "integer"]
    direction = {key: sp.Rational(rng.randint(-9, 9), 8) for key in keys}
    broken = []
    for key, truth in neighbours(solution, motion, direction, t).items():
        if found.status.get(key[0], {}).get(key[1]) != "ok":
            counts["without a derivative"] += 1
            continue
        total, claim = number.mpf(0), 0.0
        for (group, name), x in direction.items():
            variable = name if group == "parameters" else f"{group}.{name}"
            value, error = found.value[key[0]][key[1]][variable], found.error[key[0]][key[1]][variable]
            if len(key) == 3:
                value, error = value[key[2]], error[key[2]]
            total += number.convert(value) * x.p / x.q
            claim += error * abs(float(x))
        if not number.isfinite(truth) or total != total:
            continue
        counts["numbers"] += 1
        error = abs(total - truth)
        if error > claim + 1e-20 * (1 + abs(truth)):
            broken.append(f"{draw.entry} #{index} t={t} {key}: error {float(error):.2g}, claimed {claim:.2g}")
    return broken


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motions", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="stop after that time")
    parser.add_argument("--refused", action="store_true", help="print what is refused")
    options = parser.parse_args()

    def stop(*_: object) -> None:
        raise TooLongError

    signal.signal(signal.SIGALRM, stop)
    counts: collections.Counter[str] = collections.Counter()
    faults, begin = [], time.monotonic()
    for index in range(options.first, options.first + options.motions):
        if time.monotonic() - begin > options.seconds:
            break
        signal.alarm(_LONGEST)
        try:
            broken = judged(index, options.seed, counts)
            counts["motions"] += 1
            faults += broken
            for line in broken:
                print(line, flush=True)
        except TooLongError:
            counts["too long"] += 1
        except HJSolveError as refused:
            counts[f"refused: {type(refused).__name__}"] += 1
            if options.refused:
                print(index, type(refused).__name__, refused, flush=True)
        finally:
            signal.alarm(0)
    print(dict(counts), f"{len(faults)} claims do not hold")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
