"""The programs of small motions, seen from the start q₀ by second differences (``arithmetic.divided_differences``).

F(q₀ + x) = P₀² + x (F′₀ + x F[q₀, q₀, q₀ + x]) keeps its digits where F hardly differs from its top.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from hjsolve.arithmetic.divided_differences import WITH_SECOND, SecondDifference, SecondDifferences
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.machine.elementary import ROUNDINGS
from hjsolve.arithmetic.machine.pair_writer import PairOfValues, PairWriter
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode, Value
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula
from hjsolve.ensembles.engine.program_parts import ARITHMETIC, MADE, PLACE, ParameterRows, error_of, filled

SMALL_KNOWN = 5
"""Of small motions, next to the constants: q₀, P₀², F′₀, a bound on the error of F[q, q, q + x], W."""

_ROUNDED, _OFFSETS = 6 * UNIT, 16 * UNIT
"""Roundings of P₀² + x (F′₀ + …); of distances from turning points and of what they are multiplied with."""


def has_slopes(formula: LoweredFormula) -> bool:
    """Tell whether F[q₀, q₀, q] has a rule, so that small motions can be seen from their start."""
    return {operation.code for operation in formula.squared.operations} <= WITH_SECOND | ARITHMETIC


@dataclass(frozen=True)
class SmallPrograms:
    """Codes of small motions about q₀, F(q₀ + x) = P₀² + x (F′₀ + x F[q₀, q₀, q₀ + x]); known: c and ``SMALL_KNOWN``.

    Attributes:
        value: x, known ↦ F[q₀, q₀, q₀ + x].
        bounds: q, c, e ↦ ½F″ and three times its running error.
        slope: q, c, low parts of c ↦ F′ to full relative accuracy, from 32 digits.
        fill, errors, relative: as of a view, over known.
        kernels: q, c, e ↦ the kernels, and bounds on their errors.
    """

    value: MachineCode
    bounds: MachineCode
    slope: MachineCode
    fill: MachineCode
    errors: MachineCode
    relative: MachineCode | None
    kernels: MachineCode


def _second(squared: Tape, writer: InstructionWriter, known: Sequence[Value], start: Value, offset: Value) -> Value:
    """F[b, b, b + x] of a start b."""

    def elementary(name: str, x: Value, d: Value) -> tuple[Value, Value, Value]:
        if name in {"sin", "cos"}:
            # Φ[x, x, x + d] of sine and cosine in one operation: both need the same two series
            s, c, bend_s, bend_c = writer.called("sincos_bends", x, d, results=4)
            return (s, c, bend_s) if name == "sin" else (c, writer.unary("neg", s), bend_c)
        if name in {"sinh", "cosh"}:
            s, c, bend_s, bend_c = writer.called("sinhcosh_bends", x, d, results=4)
            return (s, c, bend_s) if name == "sinh" else (c, s, bend_c)
        if name == "exp":
            e, bend = writer.called("exp_bend", x, d, results=2)
            return e, e, bend
        value, slope, bend = writer.called("log_bend", x, d, results=3)
        return value, slope, bend

    slopes = SecondDifferences(writer, offset, elementary, lambda x, y: writer.called("common_sign", x, y)[0])
    result = squared.run(slopes, [slopes.variable(start), *map(SecondDifference, known)])[0]
    # p² without q, or linear in it, has no second difference
    return writer.number(0.0) if result.second is None else result.second


def _square(writer: InstructionWriter, more: Sequence[Value], x: Value, second: Value) -> Value:
    _, square, first, *_ = more
    # P₀² + x (F′₀ + x t): three terms of known size, P₀² and F′₀ from 32 digits
    return writer.add(square, writer.mul(x, writer.add(first, writer.mul(x, second))))


def _from_end(
    squared: Tape, writer: InstructionWriter, known: Sequence[Value], more: Sequence[Value], b: Value, d: Value
) -> tuple[Value, Value]:
    """F[b, b + d] of a small motion from a turning point b, and the sizes of its two terms.

    As F vanishes at both turning points, s W apart, F(b + d) = d (d F[b, b, b + d] − s W F[b, b, b + s W]). What F is
    at the numbers that stand for them is left out by that, as a linear function.
    """
    # s W with the sign of d: the other turning point, seen from b
    origin, span = writer.add(more[0], b), writer.called("signed", d, more[4])[0]
    here = writer.mul(d, _second(squared, writer, known, origin, d))
    there = writer.mul(span, _second(squared, writer, known, origin, span))
    return writer.sub(here, there), writer.add(writer.unary("abs", here), writer.unary("abs", there))


@lru_cache(maxsize=MADE)
def small_programs(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool) -> SmallPrograms:
    """Return the codes of small motions.

    Args:
        squared, full: tapes of F, and of F and its kernels.
        constants, parameters: how many there are.
        kernels: whether ∂J/∂c are wanted.
    """
    return SmallPrograms(
        value=_small_value(squared, constants, parameters),
        bounds=_small_bounds(squared, constants, parameters),
        slope=_small_slope(squared, constants, parameters),
        fill=_small_fill(squared, full, constants, parameters, kernels),
        errors=_small_errors(squared, full, constants, parameters, kernels),
        relative=_small_relative(squared, constants, parameters) if kernels else None,
        kernels=_small_kernels(full, constants, parameters),
    )


def _small_value(squared: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    x, *rows = writer.inputs(1 + constants + SMALL_KNOWN)
    known = [*rows[:constants], *ParameterRows(writer, parameters).plain]
    return writer.code([_second(squared, writer, known, rows[constants], x)])


def _small_bounds(squared: Tape, constants: int, parameters: int) -> MachineCode:
    """Write ½F″ and a bound on its error that holds for slopes nearby, too."""
    writer = InstructionWriter()
    x, *rows = writer.inputs(1 + 2 * constants)
    numbers = ParameterRows(writer, parameters)
    jets = Jets(RunningError(writer, own=ROUNDINGS))
    known = [*map(WithErrorBound, rows[:constants], rows[constants:]), *numbers.rounded]
    # q₀ + x is rounded once
    place = WithErrorBound(x, writer.mul(writer.number(UNIT), writer.unary("abs", x)))
    bend = squared.run(jets, [jets.variable(place), *map(Jet, known)])[0].second
    if bend is None:
        return writer.code([writer.number(0.0)] * 2)
    size = writer.mul(writer.number(4 * UNIT), writer.unary("abs", bend.value))
    # 3 · ½ of the error of F″: what ½F″ may be off by at other places of the motion is counted, too
    error = writer.mul(writer.number(1.5), writer.add(error_of(writer, bend), size))
    return writer.code([writer.mul(writer.number(0.5), bend.value), error])


def _small_slope(squared: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    pairs = PairWriter(writer)
    jets = Jets(pairs)
    x, *rows = writer.inputs(1 + 2 * constants)
    known = [PairOfValues(*both) for both in zip(rows[:constants], rows[constants:], strict=True)]
    known += ParameterRows(writer, parameters).pairs
    first = squared.run(jets, [jets.variable(pairs.of(x)), *map(Jet, known)])[0].first
    return writer.code([writer.number(0.0) if first is None else first.high])


def _small_fill(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool) -> MachineCode:
    """With kernels F is seen from the turning points, where it keeps its digits."""
    writer = InstructionWriter()
    d, x, root, b, *rows = writer.inputs(4 + constants + SMALL_KNOWN)
    known, more = [*rows[:constants], *ParameterRows(writer, parameters).plain], rows[constants:]
    if kernels:
        # F = d F[b, b + d]: relative accuracy next to the turning point, which kernels over √F need
        square = writer.mul(d, _from_end(squared, writer, known, more, b, d)[0])
        weights = full.run(writer, [writer.add(more[0], x), *known])[1:]
    else:
        square, weights = _square(writer, more, x, _second(squared, writer, known, more[0], x)), []
    return filled(writer, root, square, weights)


def _small_errors(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool) -> MachineCode:
    writer = InstructionWriter()
    x, _, mask, *rows = writer.inputs(3 + 2 * constants + SMALL_KNOWN)
    c, more, e = rows[:constants], rows[constants : constants + SMALL_KNOWN], rows[constants + SMALL_KNOWN :]
    numbers = ParameterRows(writer, parameters)
    value = _square(writer, more, x, _second(squared, writer, [*c, *numbers.plain], more[0], x))
    wide = writer.mul(writer.number(2.0), writer.unary("abs", writer.mul(x, more[2])))
    rounding = writer.mul(writer.number(_ROUNDED), writer.add(more[1], wide))
    # x² times what is not known of the second difference
    own = writer.add(rounding, writer.mul(writer.mul(x, x), more[3]))
    others: list[Value] = []
    if kernels:
        q = writer.add(more[0], x)
        place = WithErrorBound(q, writer.mul(writer.number(PLACE), writer.unary("abs", q)))
        # mask 0 counts the constants as exact, as in ``programs``
        known = [WithErrorBound(k, writer.mul(mask, lost)) for k, lost in zip(c, e, strict=True)]
        results = full.run(RunningError(writer, own=ROUNDINGS), [place, *known, *numbers.rounded])[1:]
        others = [error_of(writer, r) for r in results]
    return writer.code([own, *others, value])


def _small_relative(squared: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    b, d, _, _, *rows = writer.inputs(4 + constants + SMALL_KNOWN)
    known, more = [*rows[:constants], *ParameterRows(writer, parameters).plain], rows[constants:]
    slope, terms = _from_end(squared, writer, known, more, b, d)
    # both second differences are multiplied by a length, d and W
    uncertainty = writer.mul(more[3], writer.add(writer.unary("abs", d), more[4]))
    error = writer.add(uncertainty, writer.mul(writer.number(_OFFSETS), terms))
    return writer.code([writer.div(error, writer.unary("abs", slope))])


def _small_kernels(full: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    q, *rows = writer.inputs(1 + 2 * constants)
    known = [*map(WithErrorBound, rows[:constants], rows[constants:]), *ParameterRows(writer, parameters).rounded]
    place = WithErrorBound(q, writer.mul(writer.number(PLACE), writer.unary("abs", q)))
    results = full.run(RunningError(writer, own=ROUNDINGS), [place, *known])[1:]
    return writer.code([*(r.value for r in results), *(error_of(writer, r) for r in results)])
