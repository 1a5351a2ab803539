"""Random constants over the regimes of the catalog: forms against the quadrature to 40 digits, and in doubles.

    python -m benchmarks.closed_form_campaign [--motions 100] [--seed 7] [--seconds 60] [ENTRY …]

Each motion is drawn anew, until every regime that is met has so many, or the seconds of the processor for an entry are
over; of rare regimes, until ``RARE`` times as many were drawn. Its integrals are differentiated back and compared with
the quadrature of N/√p² at its own constants; periods, actions and frequencies in doubles are compared with the form to
20 digits, in units of the last place. A row for each regime, what is wrong below it, then the worst.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

import hjsolve
from hjsolve.closed_form.closed_forms import closed_forms
from hjsolve.closed_form.derive import _piece, form_of_sample, special_of
from hjsolve.closed_form.form_context import FormContext, context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.sampling import Sample, samples
from hjsolve.closed_form.verification import Compared, compared

SEEN = 20.0
"""Units of the last place from which the condition is worked out."""
NUMBERS = ("periods.", "actions.", "frequencies.")
DIGITS = 40
FAR = 100
"""Units of the last place that a form in doubles may be off, in the interior of its regime."""
PLACES = 20
"""Digits to which a number in doubles is known."""
MOST = 48
"""Regimes of an entry that are told apart."""
RARE = 5
"""Draws for each motion of a regime that is asked."""
SHOWN = 3
"""Faults of one regime that are printed."""
FAULTS = (hjsolve.HJSolveError, ArithmeticError, TypeError, ValueError)
"""What the evaluation of one number may raise; it is counted."""


@dataclass(frozen=True)
class Tried:
    """One quantity at one motion.

    Attributes:
        entry: of the catalog.
        name: of the quantity.
        kind: integral, number, nan (in doubles alone), error (of an evaluation), or refused (an integral that was not
            verified when its regime was first met, and is not shown to anybody).
        value: of an integral the largest difference from the quadrature by what is claimed, of a number the units of
            its last place by which it is off.
        regime: the words of the motion's.
        condition: by how much a relative change of the constants grows in the value (the sum over the constants); only
            where the value is far off, else 1.
        flaw: what is wrong; empty where nothing is.
        constants: of the motion, where something is wrong or far off.
        motion: its number among those of the entry.
    """

    entry: str
    name: str
    kind: str
    value: float = math.nan
    flaw: str = ""
    condition: float = 1.0
    constants: str = ""
    regime: str = ""
    motion: int = 0

    @property
    def excess(self) -> float:
        """Units of the last place beyond what the doubles nearest to the constants cost any formula."""
        return self.value / max(1.0, self.condition) if self.kind == "number" else 0.0

    @property
    def wrong(self) -> bool:
        """Whether it is a fault."""
        return bool(self.flaw) or self.excess > FAR


def tried(entry: str, motions: int, seed: int, seconds: float = math.inf) -> Iterator[Tried]:
    """Every integral, and every number of cycles, of random motions of an entry.

    Args:
        entry: of the catalog.
        motions: how many of each regime.
        seed: of the draw.
        seconds: of the processor after which no motion is begun.
    """
    solution = hjsolve.solve(entry)
    context, forms = context_of(solution), closed_forms(solution)
    numbers, met = [(form, _numbers(form)) for form in forms if not form.regime.special], Counter[str]()
    begin = time.process_time()
    for k, sample in enumerate(samples(solution, RARE * motions if seconds < math.inf else motions, seed, {})):
        found = next((pair for pair in numbers if pair[0].regime.holds(sample.values)), None)
        if found is None and len(numbers) < MOST and not dict(special_of(context, sample.values)):
            own = form_of_sample(context, context.curves, {}, sample)  # of a regime beyond those that are listed
            if own is not None:
                found = (own, _numbers(own))
                numbers.append(found)
        words = "" if found is None else found[0].regime.words
        met[words] += 1
        if met[words] > motions:
            continue
        if time.process_time() - begin > seconds:
            return
        own = [*_integrals(entry, context, sample), *([] if found is None else _doubles(entry, *found, sample))]
        constants = ", ".join(f"{s}={v}" for s, v in sample.values.items())
        for one in own:
            far = one.flaw or one.value > SEEN
            yield replace(one, regime=words, motion=k, constants=constants if far else "")


def _numbers(form: RegimeForms) -> dict[str, Any]:
    """Return the periods, actions and frequencies in doubles, compiled once for all motions of a regime."""
    return {name: function for name, function in form.lambdify("numpy").items() if name.startswith(NUMBERS)}


def _integrals(entry: str, context: FormContext, sample: Sample) -> Iterator[Tried]:
    special = dict(special_of(context, sample.values))  # by chance
    for name, curves in context.at(special).items():
        own = _piece(context, name, curves, special, sample)
        if own is None:
            continue
        for key, reason in own.why_not.items():
            if str(reason).startswith("not verified"):
                yield Tried(entry, f"{name}: {key}", "refused", flaw=str(reason))
        held = list(own.integrals | own.cycles)
        found = compared(own, held, DIGITS)
        for key in held:
            one = found.get(key, Compared())
            yield Tried(entry, f"{name}: {key}", "integral", one.difference, one.flaw)


def _doubles(entry: str, form: RegimeForms, functions: dict[str, Any], sample: Sample) -> Iterator[Tried]:
    """Periods, actions and frequencies at the doubles nearest to the constants of a motion."""
    given = {s.name: float(value) for s, value in sample.values.items()}
    for name, function in functions.items():
        held = {n: v for n, v in given.items() if n in _needed(form, name)}
        try:
            got = float(function(**{n: given[n] for n in function.names}))
            exact = form.evaluate(name, {n: repr(v) for n, v in held.items()}, PLACES).value
        except FAULTS as error:
            yield Tried(entry, name, "error", flaw=f"{type(error).__name__}: {error}")
            continue
        if not math.isfinite(got):
            yield Tried(entry, name, "nan", flaw=f"{got} in doubles, {exact}")
            continue
        ulps = float(abs(got - exact)) / float(np.spacing(abs(float(exact)))) if exact else abs(got) / 2**-53
        condition = _condition(form, name, held) if ulps > SEEN and exact else 1.0
        yield Tried(entry, name, "number", ulps, condition=condition)


def _condition(form: RegimeForms, name: str, given: dict[str, float]) -> float:
    """Return the sum of |x ∂f/∂x / f| over the constants x, by differences in many digits."""
    step, total = Fraction(1, 10**15), 0.0
    exact = form.evaluate(name, {n: repr(v) for n, v in given.items()}, DIGITS).value
    for n, value in given.items():
        moved = {**{k: repr(v) for k, v in given.items()}, n: str(Fraction(repr(value)) * (1 + step))}
        there = form.evaluate(name, moved, DIGITS).value
        total += float(abs((there - exact) / exact)) / float(step)
    return total


def _needed(form: RegimeForms, name: str) -> set[str]:
    own = needed_names(form.named()[name].free_symbols, form.where)[1]  # written out, Ω of three coordinates is long
    return {s.name for s in (*form.regime.example, *own)}


HEAD = (
    f"{'motions':>8}{'integrals':>10}{'refused':>8}{'diff/claim':>11}{'numbers':>8}{'nan':>5}{'errors':>7}"
    f"{'worst ulp':>10}{'beyond':>7}  regime"
)


def row(found: Sequence[Tried], words: str) -> str:
    """Return a row of the table: what was tried at the motions of one regime.

    Args:
        found: all of it.
        words: of the regime.
    """
    count = Counter(one.kind for one in found)
    worst = {kind: max((one.value for one in found if one.kind == kind), default=0.0) for kind in count}
    beyond = sum(one.excess > FAR for one in found)
    return (
        f"{len({one.motion for one in found}):>8}{count['integral']:>10}{count['refused']:>8}"
        f"{worst.get('integral', 0.0):>11.2g}{count['number']:>8}{count['nan']:>5}{count['error']:>7}"
        f"{worst.get('number', 0.0):>10.3g}{beyond:>7}  {words or 'no regime with a form'}"
    )


def told(faults: Iterable[Tried]) -> list[str]:
    """Return a line for each fault.

    Args:
        faults: what is wrong.
    """
    return [
        f"    {one.entry} {one.name} {one.kind}: {one.flaw or f'{one.value:.3g} ulp, condition {one.condition:.3g}'} "
        f"at {one.constants}"
        for one in faults
    ]


def main(arguments: Sequence[str]) -> None:
    """Print the table and the worst.

    Args:
        arguments: of the command line.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--motions", type=int, default=100)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=math.inf)
    parser.add_argument("entries", nargs="*")
    options = parser.parse_args(arguments)
    every = list[Tried]()
    print(HEAD)
    for entry in options.entries or hjsolve.catalog.ids("separable"):
        print(entry, flush=True)
        begin, regimes = time.process_time(), dict[str, list[Tried]]()
        for one in tried(entry, options.motions, options.seed, options.seconds):
            regimes.setdefault(one.regime, []).append(one)
        for words, found in regimes.items():
            faults = sorted((one for one in found if one.wrong), key=lambda one: -one.excess)
            print("\n".join([row(found, words), *told(faults[:SHOWN])]), flush=True)
            every += found
        print(f"    {time.process_time() - begin:.0f} s", flush=True)
    print(row([replace(one, motion=hash((one.entry, one.motion))) for one in every], "all"))
    print("\n".join(told(sorted((one for one in every if one.kind == "number"), key=lambda one: -one.excess)[:10])))


if __name__ == "__main__":
    main(sys.argv[1:])
