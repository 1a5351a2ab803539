"""From a solution, or a motion, to the forms of its regimes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import sympy as sp

from hjsolve.closed_form.assemble import assembled
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.form_context import FormContext, SpecialCase
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.pieces import CoordinateIntegrals, piece
from hjsolve.closed_form.regime import described_regime
from hjsolve.closed_form.regions import RootInterval, in_its_well, root_interval_of
from hjsolve.closed_form.sampling import Sample, samples
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.special_cases import deciders, fixed_constant, special_cases_of
from hjsolve.closed_form.time_limit import OutOfTimeError, out_of_time
from hjsolve.closed_form.verification import flaws
from hjsolve.precision import mp

MOST_REGIMES = 16
"""Of a solution, as they are met: a motion in another one has its own derived."""
_SAMPLES, _SPECIAL_SAMPLES, _SEED = 100, 30, 1
"""Motions that are drawn to meet regimes, fewer where a constant is fixed already; always the same ones."""


def forms_of_solution(context: FormContext, known: Sequence[RegimeForms] = ()) -> tuple[RegimeForms, ...]:
    """Return the forms of every regime that samples meet, those of general constants first, as far as the time goes.

    Args:
        context: of the solution.
        known: forms that need not be found again.
    """
    solution, found = context.solution, [*known]
    specials: list[SpecialCase] = [{}, *special_cases_of(context.curves, context.constants)]
    special_values = [d for own in context.curves.values() for c in own[:1] for d in deciders(c, context.constants)]
    for special in specials:
        count = _SPECIAL_SAMPLES if special else _SAMPLES
        local = context.at(special)
        for sample in samples(solution, count, _SEED, special):
            if len(found) >= MOST_REGIMES or out_of_time():
                return _ordered(found[len(known) :])
            # most samples fall into regimes that are known: asking costs milliseconds, deriving seconds
            if any(_alike(form, sample) for form in found):
                continue
            # forms of E = 0 divide by E in general
            if not special and _by_chance(special_values, sample):
                continue
            form = form_of_sample(context, local, special, sample)
            if form is not None:
                found.append(form)
    return _ordered(found[len(known) :])


def _ordered(found: list[RegimeForms]) -> tuple[RegimeForms, ...]:
    """General constants before special ones, and bounded motions before others."""

    def rank(form: RegimeForms) -> tuple[int, int]:
        kinds = form.regime.kinds.values()
        return len(form.regime.special), sum(kind not in ("libration", "rotation") for kind in kinds)

    return tuple(sorted(found, key=rank))


def _by_chance(special_values: Sequence[sp.Expr], sample: Sample) -> bool:
    """Return whether random constants happen to be special ones, whose forms are not those of general constants."""
    at = Signs(sample.values, mp.mpf(0))
    return any(at.there(value) == 0 for value in special_values)


def _alike(form: RegimeForms, sample: Sample) -> bool:
    """Return whether a motion is of a regime that has its form already."""
    return form.regime.holds(sample.values) and _on(form.regime.regions, sample)


def _on(regions: Iterable[tuple[MomentumCurve, RootInterval]], sample: Sample) -> bool:
    """Whether a motion is between the same roots of the same curves."""
    found = ((root_interval_of(curve, sample), region) for curve, region in regions)
    return all(there is not None and there.key == region.key for there, region in found)


def form_of_sample(
    context: FormContext, local: Mapping[str, list[MomentumCurve]], special: SpecialCase, sample: Sample
) -> RegimeForms | None:  # fmt: skip
    """Return the forms of the regime a motion is in; None where it is at rest, or asymptotic, in a coordinate.

    Args:
        context: of the solution.
        local: the curves in the special case.
        special: constant → what it is.
        sample: the motion.
    """
    pieces = dict[str, CoordinateIntegrals]()
    for name in context.solution.momentum_squared:
        own = _piece(context, name, local[name], special, sample)
        if own is None:
            # a curve, and still no piece: the motion is asymptotic there, and no other coordinate matters
            if local[name]:
                return None
            continue
        pieces[name] = own
    conditions, regions = dict[sp.Expr, int](), list[tuple[MomentumCurve, object]]()
    kinds = dict[str, str]()
    for name, own in pieces.items():
        conditions |= own.conditions
        regions += own.regions
        kinds[name] = own.kind
    ordering = "; ".join(filter(None, (_ordering(own) for own in pieces.values())))
    made = described_regime(kinds, special, conditions, tuple(regions), sample.values, ordering)  # type: ignore[arg-type]
    return assembled(context, pieces, made, special)


def _ordering(own: CoordinateIntegrals) -> str:
    """In which well a coordinate moves, or between which of its real roots, where P has named ones."""
    if own.regions and own.kind == "libration" and (s := own.regions[0][0].substitution).closed:
        if own.regions[0][0].coordinate.domain.kind != "angle":
            return f"{own.name} about {s.q(sp.S.Zero)}, or whole periods {s.turn} from there"
        if s.turns > 1:
            return f"{own.name} about {s.q(sp.S.Zero)}"
    if not own.regions or own.regions[0][0].degree <= 2:
        return ""
    curve, region = own.regions[0]
    if (not own.where and len(region.roots) <= 2) or curve.substitution.closed:
        return ""
    ends = [_nth(k) if what == "root" else "" for what, k in (region.lower, region.upper)]
    roots = (
        f"of the {len(region.roots)} real roots of the radicand" if len(region.roots) > 1 else "root of the radicand"
    )
    if all(ends):
        return f"{curve.substitution.place} between the {ends[0]} and the {ends[1]} {roots}"
    side, named = ("below", ends[1]) if ends[1] else ("above", ends[0])
    if not named:
        return f"{curve.substitution.place} in its whole range: no root of the radicand in it"
    return f"{curve.substitution.place} {side} the {named} {roots}"


def _nth(index: int) -> str:
    """Return the ordinal of a root that has so many below it."""
    words = ("first", "second", "third", "fourth")
    return words[index] if index < len(words) else f"{index + 1}th"


def _piece(
    context: FormContext, name: str, own: list[MomentumCurve], special: SpecialCase, sample: Sample
) -> CoordinateIntegrals | None:
    """Return the piece of a coordinate: one that was found before where it is of the same regime."""
    key = (name, tuple(special.items()))
    for known in context.pieces.setdefault(key, []):
        if _same_piece(known, sample):
            return moved_to(known, sample)
    numerators = {k: n.subs(dict(special)) for k, n in context.numerators[name].items()}
    numerators = {k: n for k, n in numerators.items() if n != 0}
    prefix = "x" if len(context.curves) == 1 else f"x_{name}"
    made = piece(name, numerators, own, sample, prefix, context.solution.lower_limits[name])
    if made is None:
        return None
    held = list(made.integrals | made.cycles)
    try:
        # never shown unverified: what runs out of time is refused as what is wrong is
        made.refuse(flaws(made, held, context.digits))
    except OutOfTimeError as error:
        made.refuse(dict.fromkeys(held, f"not verified: {error}"))
    context.pieces[key].append(made)
    return made


def moved_to(known: CoordinateIntegrals, sample: Sample) -> CoordinateIntegrals:
    """Return a piece that was found with another motion of its regime, at this one.

    All pieces of a form share one motion.
    """
    regions = [(curve, found) for curve, _ in known.regions if (found := root_interval_of(curve, sample)) is not None]
    return replace(known, sample=sample, region=regions[0][1] if regions else known.region, regions=regions)


def _same_piece(known: CoordinateIntegrals, sample: Sample) -> bool:
    here = all(in_its_well(curve, sample) for curve, _ in known.regions)
    return here and Signs(sample.values, mp.mpf(0)).agree(known.conditions) and _on(known.regions, sample)


def special_of(context: FormContext, exact: Mapping[sp.Symbol, sp.Expr]) -> Iterator[tuple[sp.Symbol, sp.Expr]]:
    """Yield the constants that are special at exact values: what each is in terms of the others.

    Args:
        context: of the solution.
        exact: symbol → exact value, of parameters and constants.
    """
    from hjsolve.motion.initial_data import number_is_zero

    for own in context.curves.values():
        for curve in own[:1]:
            for decider in deciders(curve, context.constants):
                if number_is_zero(decider.xreplace(dict(exact))):
                    special = fixed_constant(decider, context.constants)
                    if special is not None:
                        yield from special.items()
