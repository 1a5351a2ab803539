"""Random constants over the regimes of the catalog: forms against the quadrature to 40 digits, and in doubles.

    python -m benchmarks.closed_form_campaign [--motions 100] [--seed 7] [--seconds 60] [ENTRY …]

Each motion is drawn anew, until every regime that is met has so many, or the seconds of the processor for an entry are
over; of rare regimes, until ``RARE`` times as many were drawn. Its integrals are differentiated back and compared with
the quadrature of N/√p² at its own constants; periods, actions and frequencies in doubles are compared with the form to
20 digits, in units of the last place. A line for each entry and regime, then the worst.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

import hjsolve
from hjsolve.closed_form.closed_forms import closed_forms
from hjsolve.closed_form.derive import _piece
from hjsolve.closed_form.form_context import FormContext, context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.sampling import Sample, samples
from hjsolve.closed_form.verification import flaws

SEEN = 20.0
"""Units of the last place from which the condition is worked out."""
NUMBERS = ("periods.", "actions.", "frequencies.")
DIGITS = 40
FAR = 100
"""Units of the last place that a form in doubles may be off, in the interior of its regime."""
PLACES = 20
"""Digits to which a number in doubles is known."""
RARE = 5
"""Draws for each motion of a regime that is asked."""


@dataclass(frozen=True)
class Tried:
    """One quantity at one motion.

    Attributes:
        entry: of the catalog.
        name: of the quantity.
        ulps: how far the value in doubles is from the form, in units of its last place; nan of an integral.
        regime: the words of the motion's.
        condition: by how much a relative change of the constants grows in the value (the sum over the constants); only
            where the value is far off, else 1.
        flaw: what is wrong with an integral; empty where nothing is.
    """

    entry: str
    name: str
    ulps: float
    flaw: str
    regime: str = ""
    condition: float = 1.0

    @property
    def excess(self) -> float:
        """Units of the last place beyond what the doubles nearest to the constants cost any formula."""
        return self.ulps / max(1.0, self.condition)


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
    for sample in samples(solution, RARE * motions if seconds < math.inf else motions, seed, {}):
        found = next((pair for pair in numbers if pair[0].regime.holds(sample.values)), None)
        words = "" if found is None else found[0].regime.words
        met[words] += 1
        if met[words] > motions:
            continue
        if time.process_time() - begin > seconds:
            return
        yield from (replace(one, regime=words) for one in _integrals(entry, context, sample))
        if found is not None:
            yield from (replace(one, regime=words) for one in _doubles(entry, *found, sample))


def _numbers(form: RegimeForms) -> dict[str, Any]:
    """Return the periods, actions and frequencies in doubles, compiled once for all motions of a regime."""
    return {name: function for name, function in form.lambdify("numpy").items() if name.startswith(NUMBERS)}


def _integrals(entry: str, context: FormContext, sample: Sample) -> Iterator[Tried]:
    for name, curves in context.curves.items():
        own = _piece(context, name, curves, {}, sample)
        if own is None:
            continue
        held = list(own.integrals | own.cycles)
        found = flaws(own, held, DIGITS)
        for key in held:
            yield Tried(entry, f"{name}: {key}", math.nan, found.get(key, ""))


def _doubles(entry: str, form: RegimeForms, functions: dict[str, Any], sample: Sample) -> Iterator[Tried]:
    """Periods, actions and frequencies at the doubles nearest to the constants of a motion."""
    given = {s.name: float(value) for s, value in sample.values.items()}
    for name, function in functions.items():
        arguments = {n: given[n] for n in function.names}
        got = float(function(**arguments))
        if math.isnan(got):
            continue
        held = {n: v for n, v in given.items() if n in _needed(form, name)}
        try:
            exact = form.evaluate(name, {n: repr(v) for n, v in held.items()}, PLACES).value
        except hjsolve.HJSolveError:
            continue
        ulps = float(abs(got - exact)) / float(np.spacing(abs(float(exact)))) if exact else 0.0
        condition = _condition(form, name, held) if ulps > SEEN else 1.0
        yield Tried(entry, name, ulps, "", condition=condition)


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


def main(arguments: Sequence[str]) -> None:
    """Print the counts and the worst.

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
    for entry in options.entries or hjsolve.catalog.ids("separable"):
        found = list(tried(entry, options.motions, options.seed, options.seconds))
        every += found
        ulps = [one.ulps for one in found if not math.isnan(one.ulps)]
        wrong = [one for one in found if one.flaw]
        told = f"worst {max(ulps):.3g} ulp" if ulps else "no numbers"
        print(
            f"{entry}: {len(found) - len(ulps)} integrals, {len(ulps)} numbers, {told}, {len(wrong)} differ", flush=True
        )
        for words, count in Counter(one.regime for one in found).items():
            far = sum(one.excess > FAR for one in found if one.regime == words)
            print(f"    {count} in {words or 'no regime with a form'}; {far} beyond {FAR} ulp and the condition")
        for one in wrong[:3]:
            print(f"    {one.name}: {one.flaw}")
    ulps_of = sorted((one for one in every if not math.isnan(one.ulps)), key=lambda one: -one.ulps)
    far = sum(one.excess > FAR for one in ulps_of)
    print(f"{len(every) - len(ulps_of)} integrals, {sum(bool(one.flaw) for one in every)} differ from the quadrature")
    print(f"{len(ulps_of)} numbers in doubles, {far} farther than {FAR} ulp and the condition")
    for one in ulps_of[:10]:
        print(f"    {one.entry} {one.name}: {one.ulps:.3g} ulp, condition {one.condition:.3g}")


if __name__ == "__main__":
    main(sys.argv[1:])
