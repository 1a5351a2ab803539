"""Closed forms of the catalog, evaluated with many digits: ``[[closed]]`` of an entry.

The error claimed is the difference of two evaluations, the second with twice as many guard digits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from hjsolve.arithmetic.floats import EPS, Multi, bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import Tape
from hjsolve.costs.answers import Answer, Value
from hjsolve.costs.trial import Task, Trial
from hjsolve.errors import HJSolveError, NotConvergedError
from hjsolve.formulas.read import parse
from hjsolve.functions.many_digits import legendre_e
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import sign, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.precision import mp
from hjsolve.scenes.question import Times
from hjsolve.scenes.run import first_arguments

_GUARD = 64
_T, _K, _ELL = sp.Symbol("t"), sp.Symbol("K"), sp.Symbol("Ell")
_WORDS = {"turning_point": "turning_points", "action": "actions", "frequency": "frequencies", "period": "periods"}


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """Formulas of one kind of motion, made ready.

    Attributes:
        names: of the numbers, as in ``Answer``.
        tape: their formulas; inputs: the exact values, K, E, t.
        states: how many of the last names are functions of the time.
        modulus: formula of the parameter m = k² of K(m) and E(m); None where none is needed.
        inputs: exact values by symbol.
        start: the initial time.
        left: quantities wanted that have no formula.
    """

    names: tuple[str, ...]
    tape: Tape
    states: int
    modulus: Tape | None
    inputs: Mapping[sp.Symbol, sp.Expr]
    start: sp.Expr
    left: tuple[str, ...]

    def values(self, bits: int, moments: Sequence[sp.Expr]) -> list[list[Mpf]]:
        """Evaluate.

        Args:
            moments: times, exact.

        Returns:
            One list a name: a single value, or one for each time.
        """
        plain = Multi(bits)
        inputs = [to_bits(value)(bits) for value in self.inputs.values()]
        m = self.modulus.run(plain, inputs)[0] if self.modulus is not None else plain.rational(0, 1)
        if self.modulus is not None:
            with mp.workprec(bits):
                inputs += [plain.context.ellipk(m), plain.context.convert(legendre_e(mp.convert(m)))]
        else:
            inputs += [m, m]
        fixed = len(self.names) - self.states
        rows = [self.tape.run(plain, [*inputs, to_bits(t - self.start)(bits)]) for t in moments if self.states]
        first = rows[0] if rows else self.tape.run(plain, [*inputs, plain.rational(0, 1)])
        return [[value] for value in first[:fixed]] + [[row[k] for row in rows] for k in range(fixed, len(self.names))]


def closed_trials(task: Task, levels: Sequence[int]) -> list[Trial]:
    """Return the closed form of an entry at several accuracies.

    Args:
        levels: digits beyond double precision.

    Returns:
        One trial a level and one at 15 digits; none where the entry has no closed form for this motion, an effect is
        switched on, or something happens on the way.
    """
    form = closed_form(task)
    return [] if form is None else [_trial(task, form, digits) for digits in (15, *levels)]


def closed_form(task: Task) -> ClosedForm | None:
    """Find the closed form of the scene's kind of motion.

    Raises:
        CatalogError: the entry's table cannot be read.
    """
    scene = task.scene
    tables = scene.table.get("closed", ())
    if not tables or task.solution is None or scene.effects or scene.events:
        return None
    motion = task.solution.motion(**first_arguments(scene), want={"kinds"})
    table = next((t for t in tables if all(motion.kinds.get(n) == k for n, k in t.get("kinds", {}).items())), None)
    return None if table is None else _prepared(task, motion, table)


def _prepared(task: Task, motion: Motion, table: Mapping[str, Any]) -> ClosedForm | None:
    system, source = task.scene.system, f"{task.scene.system.id}: closed"
    symbols: dict[str, sp.Symbol] = {p.name: p.symbol for p in system.parameters}
    inputs = {p.symbol: motion.initial.values[p.symbol] for p in system.parameters}
    for c in system.coordinates:
        for symbol in (c.symbol, c.momentum):
            symbols[symbol.name], inputs[symbol] = symbol, motion.initial.values[symbol]
        for word, value in (("abs", sp.Abs(inputs[c.momentum])), ("sign", sp.Integer(sign(inputs[c.momentum])))):
            symbol = symbols[f"{word}_{c.momentum.name}"] = sp.Symbol(f"{word}_{c.momentum.name}", real=True)
            inputs[symbol] = value
    for name, constant in motion.solution.constants.items():
        symbols[name], inputs[constant.symbol] = constant.symbol, motion.initial.constants[name]
    known = {**symbols, "K": _K, "Ell": _ELL, "t": _T}
    chosen = {name: text for name, text in table["formulas"].items() if _wanted(task, name)}
    if not chosen:
        return None
    ordered = sorted(chosen, key=lambda name: name.partition(".")[0] in "qp")
    formulas = [parse(chosen[name], known, source=f"{source}.{name}") for name in ordered]
    modulus = table.get("modulus")
    return ClosedForm(
        tuple(_name(name) for name in ordered), lower(formulas, [*inputs, _K, _ELL, _T]),
        sum(name.partition(".")[0] in "qp" for name in ordered),
        lower([parse(modulus, symbols, source=f"{source}.modulus")], list(inputs)) if modulus else None,
        inputs, motion.t0, tuple(_left(task, motion, chosen)),
    )  # fmt: skip


def _wanted(task: Task, name: str) -> bool:
    head = name.partition(".")[0]
    return task.states if head in "qp" else _WORDS.get(head) in task.scene.want


def _left(task: Task, motion: Motion, chosen: Mapping[str, str]) -> list[str]:
    """Quantities wanted that the motion has and that no formula gives."""
    cyclic = {"libration", "rotation"} & set(motion.kinds.values())
    heads = {_WORDS.get(name.partition(".")[0], "trajectory") for name in chosen}
    words = (*(_WORDS.values() if cyclic else ()), "trajectory")
    return [word for word in words if word in task.scene.want and word not in heads]


def _name(name: str) -> str:
    """``turning_point.r.lower`` → ``turning_points.r.0``, ``period.r`` → ``periods.r``."""
    head, _, rest = name.partition(".")
    rest = rest.removesuffix(".lower") + ".0" if rest.endswith(".lower") else rest
    rest = rest.removesuffix(".upper") + ".1" if rest.endswith(".upper") else rest
    return f"{_WORDS.get(head, head)}.{rest}"


def _trial(task: Task, form: ClosedForm, digits: int) -> Trial:
    bits = bits_for(digits, _GUARD)
    angles = {f"q.{c.name}" for c in task.scene.system.coordinates if c.domain.kind == "angle"}

    def compute(times: Times | None, _: float) -> dict[str, list[tuple[Value, Value]]]:
        moments = task.every if times is None else times.listed
        try:
            pairs = zip(form.values(bits, moments), form.values(bits + _GUARD, moments))
        except (ZeroDivisionError, HJSolveError) as error:
            raise NotConvergedError(f"the closed form fails here: {error}") from error
        return {n: [_rounded(x, y, digits) for x, y in zip(*both)] for n, both in zip(form.names, pairs)}

    def read(result: Mapping[str, list[tuple[Value, Value]]], places: Sequence[int]) -> Answer:
        numbers = {
            name: tuple(values[k] for k in places) if len(values) > 1 else tuple(values)
            for name, values in result.items()
        }
        sizes = {n: max(abs(float(v)) for v, _ in values) for n, values in result.items() if n[:2] in ("q.", "p.")}
        count = 2 * max((len(values) for values in result.values()), default=1) * len(form.names)
        return Answer(numbers, count, {n: size for n, size in sizes.items() if n not in angles})

    note = f"without {' and '.join('the states' if w == 'trajectory' else w.replace('_', ' ') for w in form.left)}"
    covers = "all" if not form.left else "numbers" if form.left == ("trajectory",) else "part"
    return Trial("closed form", digits, compute, read, "formulas", own=True, covers=covers,
                 note=note if form.left else "")  # fmt: skip


def _rounded(value: Mpf, again: Mpf, digits: int) -> tuple[Value, Value]:
    """Return the value to the digits asked, and what it claims."""
    context = again.context
    difference = 2 * abs(again - value)
    if digits <= 15:
        number = float(again)
        return number, float(difference) + abs(number) * EPS
    return again, difference + abs(again) * context.mpf(10) ** -digits
