"""Which method a scene is run with: the cheapest that reaches the digits asked, or the best that fits into a time.

    accuracy = {digits = d}     up to 15: double precision. Above: mpmath; far above, for the results of a motion, the
                                one of mpmath and ball arithmetic that takes less, judged by both at 20 digits
    accuracy = {seconds = s}    more and more digits, each time with the method that should take less, as long as the
                                next run should still fit

How long a method takes with more digits is foretold by a power law from its last run. The exponents are those of the
catalog (docs/accuracy-and-cost.md).
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

from hjsolve.errors import InvalidInputError, MissingExtraError, NotConvergedError, required
from hjsolve.scenes.question import INTEGRATED_DIGITS, MOST_INTEGRATED_DIGITS, Question, Times
from hjsolve.scenes.results import Choice, Run
from hjsolve.scenes.run import run_by_quadratures, solved
from hjsolve.solution.quadratures import Solution

LADDER = (20, 30, 45, 70, 100, 150, 220, 330, 500)
INTEGRATED_LADDER = (4, 6, 8, INTEGRATED_DIGITS, MOST_INTEGRATED_DIGITS)
GROWTH = {"mpmath": 1.3, "certified": 0.6, "integrate": 1.5}
"""Exponents: seconds grow like digits to this power."""
PROOFS_FROM = 60
"""Digits above which ball arithmetic may be faster; below, it is not tried."""
_FEWEST, _MARGIN, _LEAP, _PROBE = 20, 1.3, 2.5, 5
_PROVED = frozenset({"constants", "kinds", "turning_points", "actions", "frequencies", "periods"})
Tried = tuple[str, int, float]


@dataclass
class _Runner:
    """Runs a scene with one method after the other and remembers how long each took.

    Attributes:
        scene, solution: what is run.
        tried: (method, digits, seconds), in order.
        known: method → (digits, seconds), of its last run or foretold.
    """

    scene: Question
    solution: Solution | None
    tried: tuple[Tried, ...] = ()
    known: dict[str, tuple[int, float]] = field(default_factory=dict)

    def go(self, method: str, digits: int) -> Run:
        """Run and time it."""
        begin = time.perf_counter()
        done = run_by_quadratures(replace(self.scene, digits=digits, certified=method == "certified"), self.solution)
        spent = time.perf_counter() - begin
        self.tried += ((method, digits, spent),)
        self.known[method] = (digits, spent)
        return done

    def expected(self, method: str, digits: int) -> float:
        """Seconds the method should take."""
        last, seconds = self.known[method]
        return seconds * (digits / last) ** GROWTH[method]


def run_chosen(scene: Question) -> Run:
    """Run a scene with the method its accuracy calls for; see ``Scene.run``."""
    begin = time.perf_counter()
    if scene.seconds is not None:
        return _within(scene, _Runner(scene, solved(scene)), scene.seconds, begin)
    if scene.method == "integrate":
        why = "the scene asks for an integrator; its tolerance was lowered until two runs agreed to the digits asked"
        return replace(run_by_quadratures(scene), choice=Choice("integrate", scene.digits, why))
    runner = _Runner(scene, solved(scene))
    method, why = _cheapest(scene, runner)
    done = runner.go(method, scene.digits)
    return replace(done, choice=Choice(method, scene.digits, why, runner.tried))


def _cheapest(scene: Question, runner: _Runner) -> tuple[str, str]:
    """Return the method for the digits asked, and why."""
    if scene.digits <= 15:
        return "float64", "double precision reaches up to 15 digits, and every other method does more"
    if not _provable(scene):
        return "mpmath", "above 15 digits states, and motions with events, come from mpmath alone"
    if scene.digits <= PROOFS_FROM:
        return "mpmath", f"up to {PROOFS_FROM} digits ball arithmetic does not pay"
    for method in ("mpmath", "certified"):
        try:
            runner.go(method, _FEWEST)
        except (InvalidInputError, MissingExtraError, NotConvergedError) as error:
            if method == "mpmath":
                raise
            return "mpmath", f"ball arithmetic cannot be used: {' '.join(str(error).split())}"
    seconds = {method: runner.expected(method, scene.digits) for method in ("mpmath", "certified")}
    method = min(seconds, key=lambda name: seconds[name])
    other = "certified" if method == "mpmath" else "mpmath"
    why = (
        f"judged by {_FEWEST} digits, {method} should take {seconds[method]:.2g} s for {scene.digits} digits, "
        f"{other} {seconds[other]:.2g} s"
    )
    return method, why


def _provable(scene: Question) -> bool:
    """Return whether all that is wanted could be proved, states and events apart."""
    return not scene.events and set(scene.want) <= _PROVED


def _within(scene: Question, runner: _Runner, seconds: float, begin: float) -> Run:
    """More and more digits, as long as the next run should fit."""
    integrated = scene.method == "integrate"
    ladder = INTEGRATED_LADDER if integrated else (15, *LADDER)
    names = ["integrate"] if integrated else ["mpmath", *(["certified"] if _provable(scene) else [])]
    best = runner.go("integrate" if integrated else "float64", ladder[0])
    chosen, why = runner.tried[-1], "no more digits are offered"
    if not integrated:
        _foretell(runner, chosen[2])
    while chosen[1] < ladder[-1]:
        found, why = _next(runner, names, chosen[1], ladder, seconds - (time.perf_counter() - begin))
        if found is None:
            break
        best, chosen = found, runner.tried[-1]
    spent = time.perf_counter() - begin
    late = f", though {seconds:.3g} s were allowed" if spent > seconds else f" of the {seconds:.3g} s allowed"
    return replace(best, choice=Choice(chosen[0], chosen[1], f"{spent:.2g} s were spent{late}; {why}", runner.tried))


def _foretell(runner: _Runner, once: float) -> None:
    """How long the methods will take the first time: a small multiple of double precision, and the states on top."""
    scene = runner.scene
    runner.known["certified"] = (15, 5 * once)
    runner.known["mpmath"] = (15, 1.5 * once)
    count = len(scene.times.exact()) if scene.times is not None else 0
    if not {"trajectory", "angles"} & set(scene.want) or count <= _PROBE:
        return
    clock = []
    for k in (1, _PROBE):
        few = replace(scene, times=Times(listed=(required(scene.times).last,) * k), digits=_FEWEST)
        start = time.perf_counter()
        run_by_quadratures(few, runner.solution)
        clock.append(time.perf_counter() - start)
    each = max(0.0, clock[1] - clock[0]) / (_PROBE - 1)
    runner.known["mpmath"] = (_FEWEST, clock[0] + (count - 1) * each)


def _next(runner: _Runner, names: list[str], last: int, ladder: tuple[int, ...], left: float) -> tuple[Run | None, str]:
    """Run with as many digits as should fit, by the method that should take less; None, and why, if none can."""
    above = [digits for digits in ladder if digits > last]
    reach = [digits for digits in above if digits <= _LEAP * last] or above[:1]
    while names:
        for digits in reversed(reach):
            method = min(names, key=lambda name: runner.expected(name, digits))
            expected = _MARGIN * runner.expected(method, digits)
            if expected <= left:
                break
        else:
            return None, f"{method} with {digits} digits should take {expected:.2g} s more"
        begin = time.perf_counter()
        try:
            return runner.go(method, digits), "no more digits are offered"
        except (InvalidInputError, MissingExtraError, NotConvergedError):
            names.remove(method)
            left -= time.perf_counter() - begin
    return None, f"no method reached {reach[0]} digits"
