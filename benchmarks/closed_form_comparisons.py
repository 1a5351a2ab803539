"""One form in doubles against another computation of the same number, at thousands of motions: what is allowed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from benchmarks.closed_form_campaign import FAULTS
from benchmarks.closed_form_draws import Reals, Seeds, Table, exact
from benchmarks.closed_form_quadratures import ULP
from hjsolve.closed_form.compiled_forms import CompiledRegime
from hjsolve.closed_form.form_context import FormContext
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names

FAR = 100
"""Units of the last place that a form in doubles may be off, at condition 1."""
JUDGED = 3
"""Differences of one number that are worked out again in many digits, the worst first."""
_DIGITS = 25, 60, 120
"""Of a form that is worked out again: at E of 1e-72 all of the first are lost, and the form says so by its error."""
_KNOWN = 1e-18
"""Of itself, how far the form may be off by what it says, before more digits are taken."""
_STEPS = 1e-6, 1e-9, 1e-12
"""Of a relative change that the condition is worked out by: the square root of what a form loses, and less where both
sides are of another regime, as next to a separatrix; with the last one 4 500 units by the condition still show."""


@dataclass
class Row:
    """One number of one regime.

    Attributes:
        name: of the form.
        count: motions at which it was compared.
        missing: motions of the regime at which the other side has no number, or the quadrature did not settle.
        nan: motions at which the form has none in doubles.
        worst: the largest difference, in units of what is allowed.
        ulp: the largest difference beyond the other side's claims, in units of the last place by the condition.
        beyond: motions at which the form loses more digits in doubles than is allowed, and is right in many.
        faults: what is wrong, a line each.
    """

    name: str
    count: int = 0
    missing: int = 0
    nan: int = 0
    worst: float = 0.0
    ulp: float = 0.0
    beyond: int = 0
    faults: list[str] = field(default_factory=list)


@dataclass
class Met:
    """A regime and what was found in it.

    Attributes:
        form: of the regime.
        context: of the solution.
        motions: that were compared.
        seeds: about which others are drawn.
        constants: of the motions, a table for each set of parameters.
        rows: name of a form → what was found.
    """

    form: RegimeForms
    context: FormContext
    motions: int = 0
    seeds: Seeds | None = None
    constants: list[Table] = field(default_factory=list)
    rows: dict[str, Row] = field(default_factory=dict)

    @cached_property
    def regime(self) -> CompiledRegime:
        """As ``lambdify`` compiles forms for arrays."""
        return CompiledRegime(self.form, numpy=True)

    @cached_property
    def inside(self) -> Callable[..., Any]:
        """A number at motions of the regime, nan at others."""
        places = [curve.coordinate.symbol for curve, _ in self.form.regime.regions]
        return self.regime.function(sp.Add(*dict.fromkeys([*places, *self.form.regime.example])))

    @cached_property
    def functions(self) -> dict[str, Callable[..., Any]]:
        """Name of a form → it in doubles."""
        return {name: self.regime.function(expression, name) for name, expression in self.form.named().items()}

    @cached_property
    def angles(self) -> set[str]:
        """Angles, of which a rounding is one of a radian."""
        return {c.name for c in self.form.solution.system.coordinates if c.domain.kind == "angle"}

    def row(self, name: str) -> Row:
        return self.rows.setdefault(name, Row(name))

    def at(self, name: str, given: Mapping[str, Reals]) -> Reals:
        """Return a form in doubles."""
        function = self.functions[name]
        shape = np.shape(next(iter(given.values())))
        names = function.names  # type: ignore[attr-defined]
        held = {n: given[n] if n in given else np.zeros(shape) for n in names if n in given or n.startswith("beta_")}
        return np.broadcast_to(function(**held), shape).astype(float)


def taken(table: Mapping[str, Reals], kept: NDArray[np.int64]) -> Table:
    return {name: value[kept] for name, value in table.items()}


def condition(own: Met, name: str, given: Mapping[str, Reals], errors: Mapping[str, Reals]) -> tuple[Reals, Reals]:
    """Return Σ|x ∂f/∂x|, and Σ|δx ∂f/∂x|, by differences in doubles: the larger of both sides."""
    names = [n for n in own.functions[name].names if n in given]  # type: ignore[attr-defined]
    (count,) = np.shape(next(iter(given.values())))
    slopes = _slopes(own, name, given, names, _STEPS[0])
    for step in _STEPS[1:]:
        left = np.flatnonzero(np.isnan(slopes).any(axis=0))
        if len(left):
            nearer = _slopes(own, name, taken(given, left), names, step)
            slopes[:, left] = np.where(np.isnan(slopes[:, left]), nearer, slopes[:, left])
    size, moved = np.zeros(count), np.zeros(count)
    for n, slope in zip(names, slopes, strict=True):
        size = size + np.nan_to_num(_unit(own, n, given[n]) * slope)
        moved = moved + np.nan_to_num(errors.get(n, np.zeros(count)) * slope)
    return size, moved


def _slopes(own: Met, name: str, given: Mapping[str, Reals], names: list[str], step: float) -> Reals:
    """Return |∂f/∂x| for each name, a row each; nan where neither side is of the regime."""
    (count,) = np.shape(next(iter(given.values())))
    steps = {n: step * np.where(given[n] == 0, 1.0, _unit(own, n, given[n])) for n in names}
    # all arguments, a step to either side of each, in one call: roots and regimes are worked out for whole arrays
    columns = {n: np.tile(v, 1 + 2 * len(names)).reshape(-1, count) for n, v in given.items()}
    for k, n in enumerate(names):
        columns[n][1 + 2 * k] -= steps[n]
        columns[n][2 + 2 * k] += steps[n]
    middle, *sides = own.at(name, {n: v.ravel() for n, v in columns.items()}).reshape(-1, count)
    found = [
        np.fmax(*(abs((side - middle) / steps[n]) for side in sides[2 * k : 2 * k + 2])) for k, n in enumerate(names)
    ]
    return np.array(found).reshape(len(names), count)


def _unit(own: Met, name: str, value: Reals) -> Reals:
    return np.fmax(abs(value), 1.0) if name in own.angles else abs(value)


def compare(
    own: Met, name: str, given: Mapping[str, Reals], other: Reals, claim: Reals, errors: Mapping[str, Reals],
    right: Callable[[int], float] | None = None,
) -> None:  # fmt: skip
    """Compare one form in doubles with another computation of the same, and keep what is found.

    Args:
        own: the regime.
        name: of the form.
        given: its arguments.
        other: the other computation's values; nan where it has none.
        claim: how far it may be off.
        errors: name of an argument → how far it may be off for the other computation.
        right: number of a motion → the form in many digits at the motion's own exact constants; None for at ``given``.
    """
    row = own.row(name)
    known = np.isfinite(other) & np.isfinite(claim)
    for n in own.functions[name].names:  # type: ignore[attr-defined]
        known &= np.isfinite(given[n]) if n in given else True
    row.missing += int((~known).sum())
    if not known.any():
        return
    kept = np.flatnonzero(known)
    given, other, claim = taken(given, kept), other[kept], claim[kept]
    errors = taken(errors, kept)
    values = own.at(name, given)
    row.count += len(kept)
    none = ~np.isfinite(values)
    row.nan += int(none.sum())
    off = abs(values - other)
    odd = np.flatnonzero(~none & (off > claim + 4 * ULP * abs(other)))
    allowed, doubtful = claim + FAR * ULP * abs(other), claim.copy()
    if len(odd):
        size, moved = condition(own, name, taken(given, odd), taken(errors, odd))
        unit = ULP * np.fmax(size, abs(other[odd])) + 5e-324
        row.ulp = max(row.ulp, float(np.max((off[odd] - claim[odd] - moved) / unit)))
        allowed[odd] = claim[odd] + moved + FAR * unit
        doubtful[odd] = claim[odd] + (moved if right is None else 0.0)
    ratio = np.where(none, np.inf, off / np.where(allowed > 0, allowed, 5e-324))
    ratio[off == 0] = 0.0
    row.worst = float(max([row.worst, *ratio[(ratio <= 1)]]))
    suspicious = sorted(np.flatnonzero(~(ratio <= 1)), key=lambda k: -ratio[k])
    for k in suspicious[:JUDGED]:
        _judge(
            row,
            own,
            name,
            taken(given, np.array([k])),
            float(other[k]),
            float(doubtful[k]),
            int(kept[k]),
            right,
            float(values[k]),
        )
    row.beyond += max(0, len(suspicious) - JUDGED)


def _judge(
    row: Row, own: Met, name: str, given: Table, other: float, claim: float, motion: int,
    right: Callable[[int], float] | None, value: float,
) -> None:  # fmt: skip
    """Work a form out again in many digits: is it the doubles that lose, or is something wrong."""
    given = {n: v for n, v in given.items() if n in own.functions[name].names}  # type: ignore[attr-defined]
    words = ", ".join(f"{n}={float(v[0])!r}" for n, v in given.items())
    try:
        again = (
            right(motion)
            if right is not None
            else in_many_digits(own.form, name, {n: float(v[0]) for n, v in given.items()})
        )
    except FAULTS as error:
        row.faults.append(f"{name}: {value!r} in doubles, {other!r} ± {claim:.1e} by the other side, "
                          f"{type(error).__name__}: {str(error)[:150]} in many digits, at {words}")  # fmt: skip
        return
    if abs(again - other) <= claim + 8 * ULP * abs(other):
        row.beyond += 1
        row.worst = max(row.worst, 1.0)
        return
    row.faults.append(f"{name}: {value!r} in doubles, {again!r} in many digits, {other!r} ± {claim:.1e} at {words}")


def in_many_digits(form: RegimeForms, name: str, numbers: Mapping[str, float | sp.Rational]) -> float:
    """Return a form at doubles, or at exact numbers, worked out in many digits.

    Args:
        form: of a regime.
        name: of the quantity.
        numbers: name of a symbol → its value; a β that is left out is 0.
    """
    needed = needed_names(form.named()[name].free_symbols, form.where)[1]
    names = {s.name for s in (*form.regime.example, *needed)}
    held = {n: exact(v) if isinstance(v, float) else v for n, v in numbers.items() if n in names}
    held = {n: sp.S.Zero for n in names if n.startswith("beta_")} | held
    for digits in _DIGITS:
        found = form.evaluate(name, {n: str(v) for n, v in held.items()}, digits)
        if found.error <= _KNOWN * abs(found.value):
            break
    return float(found.value)
