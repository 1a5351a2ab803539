"""Random motions over the whole catalog: is every claimed error at least the true one?

    python benchmarks/campaign.py --count 10000 --out campaign.jsonl

Every number of a motion in double precision – constants, turning points, actions, frequencies, periods, times of
passages and of collisions, q(t), p(t) and velocities at several times, one of them up to 10⁷ periods away – is compared
with the truth, and its claimed error with the true one. Truth for q(t), p(t): Hamilton's equations integrated in
quadruple precision by heyoka (``quad_twin``; T and V alone, no quadrature). Truth for the other numbers, for
far times, and where heyoka is not there: the same motion at 25 digits, itself compared with heyoka on the way: a
difference is a ``conflict``. Results go to a file, one line a motion, so a campaign can be stopped and resumed.
Status 1 when a claim was false, a motion crashed, or the two truths differ.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import json
import math
import random
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import mpmath
import numpy as np

from hjsolve.errors import ForbiddenMotionError, InvalidInputError, NotConvergedError, OutsideMotionError
from hjsolve.motion.through_poles.continued_motion import ContinuedMotion
from tests.support import random_motions
from tests.support.random_motions import Draw

DIGITS = 25
ATTEMPTS = 8
QUADRUPLE = 1e-29
"""Error of a state of heyoka's, relative to its largest component: a coordinate at rest has it too."""
NUMBERS = ("constants", "actions", "frequencies", "periods", "boundary_times")
exact = mpmath.mp.clone()
exact.prec = 240


class TooLongError(Exception):
    """A motion took longer than allowed."""


@dataclass
class Finding:
    """What one random motion showed.

    Attributes:
        status: ok, not_converged (the engine said so), refused (no draw was a motion), too_long, crash.
        claims: how many claimed errors were compared.
        exact: how many values were exact to the last digit compared.
        ratios: floor(2·log10(claimed/true)) → count.
        lies: (quantity, claimed, true) where claimed < true.
        conflicts: (quantity, difference) where the two truths differ.
        twinned: claims whose truth came from the quadruple integration.
    """

    index: int
    entry: str
    kinds: str = ""
    status: str = "ok"
    claims: int = 0
    exact: int = 0
    twinned: int = 0
    ratios: dict[str, int] = field(default_factory=dict)
    lies: list[tuple[str, float, float]] = field(default_factory=list)
    conflicts: list[tuple[str, float]] = field(default_factory=list)
    seconds: float = 0.0
    message: str = ""

    def compare(
        self, what: str, value: Any, claimed: Any, truth: Any, rounding_error: float = 1e-22, floor: float = 0.0
    ) -> None:
        """Take down one claim; ``rounding_error`` is that of the truth, relative, ``floor`` the absolute one."""
        self.claims += 1
        true = abs(exact.convert(value) - exact.convert(truth))
        if not np.isfinite(float(value)) or not float(claimed) >= 0:
            self.lies.append((what, float(claimed), math.inf))
        elif not true:
            self.exact += 1
        elif true > exact.convert(claimed) + rounding_error * abs(exact.convert(truth)) + floor:
            self.lies.append((what, float(claimed), float(true)))
        elif claimed:
            bin_ = str(math.floor(2 * float(exact.log10(exact.convert(claimed) / true))))
            self.ratios[bin_] = self.ratios.get(bin_, 0) + 1


@functools.cache
def twin() -> Any | None:
    """Return the quadruple integration, where heyoka is installed."""
    try:
        importlib.import_module("heyoka")
    except ImportError:
        return None
    return importlib.import_module("benchmarks.quad_twin")


def judge(seed: int, index: int, limit: int = 30) -> Finding:
    """Draw a motion, compute it, compare every claim.

    Args:
        seed: of the campaign. index: of the motion.
        limit: seconds of processor time after which it is given up (0 for never).
    """
    finding = Finding(index, random_motions.draw(seed, index).entry)
    if twin():
        twin().ready(finding.entry)
    begin = time.process_time()
    signal.signal(signal.SIGPROF, _give_up)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        _judge(seed, index, finding)
    except NotConvergedError as error:
        finding.status, finding.message = "not_converged", str(error)
    except TooLongError:
        finding.status = "too_long"
    except Exception:  # noqa: BLE001  (a crash is what a campaign is for)
        finding.status, finding.message = "crash", traceback.format_exc(limit=-4)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    finding.seconds = round(time.process_time() - begin, 3)
    return finding


def _give_up(*_: Any) -> None:
    raise TooLongError


def _judge(seed: int, index: int, finding: Finding) -> None:
    for attempt in range(ATTEMPTS):
        draw = random_motions.draw(seed, index, attempt)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                motion = random_motions.solution(draw.entry).motion(**draw.arguments)
            break
        except (InvalidInputError, ForbiddenMotionError) as error:
            finding.message = str(error)
    else:
        finding.status = "refused"
        return
    finding.message = ""
    finding.kinds = ",".join(motion.kinds.values())
    far = random.Random(f"{seed}/{index}/far").random() < 0.2 or twin() is None
    wanted = None if far else ["turning_points", "actions", "periods", "boundary_times"]
    better = random_motions.solution(draw.entry).motion(**draw.arguments, digits=DIGITS, want=wanted)
    if better.kinds != motion.kinds:
        finding.lies.append((f"kinds {motion.kinds} {better.kinds}", 0.0, math.inf))
    _numbers(finding, motion, better)
    _states(finding, draw, motion, better if far else None)
    if far and motion.periods:
        _passages(finding, motion, better)


def _numbers(finding: Finding, motion: Any, better: Any) -> None:
    for group in NUMBERS:
        ours, theirs = getattr(motion, group), getattr(better, group)
        if set(ours) != set(theirs):
            finding.lies.append((f"{group}: {sorted(ours)} but {sorted(theirs)}", 0.0, math.inf))
        for name in set(ours) & set(theirs):
            finding.compare(f"{group}.{name}", ours[name].value, ours[name].error, theirs[name].value)
    for name, ends in motion.turning_points.items():
        for side, end, truth in zip(("lower", "upper"), ends, better.turning_points[name], strict=True):
            if (end is None) != (truth is None):
                finding.lies.append((f"turning_points.{name}.{side} {end} {truth}", 0.0, math.inf))
            elif end is not None:
                finding.compare(f"turning_points.{name}.{side}", end.value, end.error, truth.value)


def _states(finding: Finding, draw: Draw, motion: Any, better: Any | None) -> None:
    unit = max((float(e.value) for e in motion.periods.values()), default=1.0)
    near = [unit * x for x in draw.times]
    times = [*near, unit * draw.far] if motion.periods and better is not None else near
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        state = _running_on(motion, times)
        error = state.error
    other = twin().states(draw.entry, draw.arguments, near) if twin() else [None] * len(near)
    other += [None] * (len(times) - len(other))
    second = _running_on(better, times) if better is not None else None
    for m in range(len(times)):
        ended = state.status[m] != "ok"
        if second is not None and ended != (second.status[m] != "ok"):
            finding.lies.append((f"status at {times[m]!r}: {state.status[m]}, {second.status[m]}", 0.0, math.inf))
        if ended:
            continue
        for what, value, claimed in _values(motion, state, error, m):
            truths = [] if second is None else [_truth(second, what, m)]
            floor = 0.0
            if other[m] is not None and what in other[m]:
                truths.insert(0, other[m][what])
                floor = QUADRUPLE * float(max(abs(x) for x in other[m].values()))
                finding.twinned += 1
            if not truths:
                continue
            if isinstance(motion, ContinuedMotion) and what.startswith("q."):
                truths = [_same_turn(x, value) for x in truths]
            finding.compare(f"{what} at {times[m]!r}", value, claimed, truths[0], floor=floor)
            if len(truths) == 2 and abs(truths[0] - truths[1]) > 1e-17 * (1 + abs(truths[0])):
                finding.conflicts.append((f"{what} at {times[m]!r}", float(abs(truths[0] - truths[1]))))


def _running_on(motion: Any, times: list[float]) -> Any:
    """States in coordinates that run on through poles, as Hamilton's equations in them do; ``at`` folds them."""
    return (motion.unfolded if isinstance(motion, ContinuedMotion) else motion.at)(np.array(times))


def _same_turn(truth: Any, value: Any) -> Any:
    """Return the truth without the whole turns that a motion through poles does not count."""
    true = exact.convert(truth)
    return true - 2 * exact.pi * exact.nint((true - exact.convert(value)) / (2 * exact.pi))


def _values(motion: Any, state: Any, error: Any, m: int) -> Iterator[tuple[str, Any, Any]]:
    """Name, value (an angle with its whole turns) and claimed error of every component at one time."""
    for coordinate in motion.solution.system.coordinates:
        n = coordinate.name
        yield f"q.{n}", _whole(state, n, m), error.q[n][m]
        yield f"p.{n}", state.p[n][m], error.p[n][m]
        yield f"v.{n}", state.velocity[n][m], error.velocity[n][m]


def _whole(state: Any, name: str, m: int) -> Any:
    value = exact.convert(state.q[name][m])
    return value + 2 * exact.pi * int(state.turns[name][m]) if name in state.turns else value


def _truth(second: Any, what: str, m: int) -> Any:
    group, name = what.split(".", 1)
    return _whole(second, name, m) if group == "q" else {"p": second.p, "v": second.velocity}[group][name][m]


def _passages(finding: Finding, motion: Any, better: Any) -> None:
    """Record the times at which separated coordinates pass places of theirs."""
    state = motion.at(0.37 * max(e.value for e in motion.periods.values()))
    for name in motion.separated.located:
        for passage in (0, 3):
            try:
                ours = motion.time_at(name, float(state.q[name]), passage)
                truth = better.time_at(name, float(state.q[name]), passage)
            except (OutsideMotionError, InvalidInputError):
                continue
            finding.compare(f"time_at.{name}.{passage}", ours.value, ours.error, truth.value,
                            rounding_error=1e-22 if _alone(better) else 1e-13)  # fmt: skip


def _alone(better: Any) -> bool:
    """Return True where times of passages are available to many digits: one separated coordinate."""
    return len(better.separated.located) == 1


def _summary(findings: list[dict[str, Any]], seconds: float) -> int:
    ratios: Counter[int] = Counter()
    for f in findings:
        ratios.update({int(k): v for k, v in f["ratios"].items()})
    total, claims = sum(ratios.values()), sum(f["claims"] for f in findings)
    systems, twinned = len({f["entry"] for f in findings}), sum(f["twinned"] for f in findings)
    print(f"{len(findings)} motions of {systems} systems, {claims} claims,")
    print(f"{twinned} of them against heyoka in quadruple precision, {seconds:.0f} s of processor time")
    print("status:", dict(Counter(f["status"] for f in findings)))
    print("kinds:", dict(Counter(k for f in findings for k in f["kinds"].split(",") if k)))
    lies = [len(f["lies"]) for f in findings if f["lies"]]
    print(f"claimed < true: {sum(lies)} in {len(lies)} motions")
    print(f"the two truths differ: {sum(len(f['conflicts']) for f in findings)}")
    print(f"no error at all: {sum(f['exact'] for f in findings)}; claimed/true of the others:")
    below = 0
    for edge in sorted(ratios):
        below += ratios[edge]
        if edge % 2 == 1:
            print(f"   up to 10^{(edge + 1) // 2:<3d} {100 * below / total:6.2f} %")
    bad = [f for f in findings if f["lies"] or f["conflicts"] or f["status"] == "crash"]
    for f in bad[:40]:
        print(f["index"], f["entry"], f["status"], f["lies"][:3], f["conflicts"][:2], f["message"][-300:])
    for f in [f for f in findings if f["status"] in {"not_converged", "too_long"}][:40]:
        print(f["index"], f["entry"], f["status"], f["message"][:160])
    return int(bool(bad))


def main() -> int:
    """Run or resume a campaign."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000, help="motions (default 10000)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("campaign.jsonl"), help="one line a motion; resumed if there")
    parser.add_argument("--seconds", type=float, default=math.inf, help="stop after this time")
    parser.add_argument("--only", help="entries whose name holds this")
    parser.add_argument("--limit", type=int, default=30, help="seconds of processor time for a motion (default 30)")
    given = parser.parse_args()
    known = [json.loads(line) for line in given.out.read_text().splitlines()] if given.out.exists() else []
    done, begin = {f["index"] for f in known}, time.monotonic()
    with given.out.open("a") as file:
        for index in range(given.count):
            if time.monotonic() - begin > given.seconds:
                break
            name = random_motions.entries()[index % len(random_motions.entries())]
            if index in done or (given.only and given.only not in name):
                continue
            known.append(asdict(judge(given.seed, index, given.limit)))
            file.write(json.dumps(known[-1]) + "\n")
            file.flush()
    return _summary(known, sum(f["seconds"] for f in known))


if __name__ == "__main__":
    sys.exit(main())
