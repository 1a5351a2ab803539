"""The programs of one system: its tapes, run once in the arithmetic that writes instructions for the machine.

Every view of F = p² (from zero, from an end of the domain, from the start) has the same programs, over an offset x in
it, the constants c of the motion and bounds e on their errors. Parameters of the system are parameters of the programs:
a new value makes no new program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

from hjsolve.arithmetic.divided_differences import WITH_FIRST, FirstDifferences
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.machine.elementary import ROUNDINGS
from hjsolve.arithmetic.machine.pair_writer import PairOfValues, PairWriter
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode, Value
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.program_parts import ARITHMETIC, FINER, MADE, PLACE, ParameterRows, error_of, filled
from hjsolve.ensembles.engine.programs_of_small_motions import SmallPrograms, small_programs

_RELATIVE = 4 * UNIT
"""Relative error of F from 32 digits: it is rounded once to a double; three units are to spare."""


def sides(coordinate: Separated) -> tuple[LoweredFormula, LoweredFormula]:
    """Return the formulas by which the lower and the upper half of a motion are seen."""
    return coordinate.lower or coordinate.plain, coordinate.upper or coordinate.plain


def parameter_rows(numbers: Sequence[Pair]) -> list[float]:
    """Return the values of the parameters of every program: high parts, low parts, and bounds on what is left of them.

    Args:
        numbers: parameters of the system, in two doubles.
    """
    high, low = ([float(part) for part in parts] for parts in zip(*numbers, strict=True)) if numbers else ([], [])
    return [*high, *low, *(UNIT * abs(x) for x in high)]


@dataclass(frozen=True)
class ViewPrograms:
    """Codes of one view of F.

    Attributes:
        bend: x, c ↦ F, F′, F″.
        slopes: x, c ↦ F, F′.
        fill: d, x, root, b, c ↦ F r, r, F, kernels times r, at a distance d from the turning point b; r = root/√F. The
            place x = b + d comes apart from d, because next to a pole at x = 0 their sum loses its digits.
        errors: x, δx, mask, c, e ↦ bounds on the errors of F and of the kernels, F; mask = 0 counts no e.
        relative: b, d, x, δx, c ↦ a bound on the relative error of F[b, x]; None where F is evaluated as it is written.
        turn: as ``fill``, of motions that go round, far from all zeros of F: F is evaluated as it is written.
    """

    bend: MachineCode
    slopes: MachineCode
    fill: MachineCode
    errors: MachineCode
    relative: MachineCode | None
    turn: MachineCode


@dataclass(frozen=True)
class ExactPrograms:
    """Codes of one view that know F to 32 digits; known: c, low parts of c, and both turning points in two doubles.

    Attributes:
        squares: x, low part of x, c, low parts of c ↦ F.
        fill, errors: as of a view, at distances d from a turning point.
    """

    squares: MachineCode
    fill: MachineCode
    errors: MachineCode
    relative: None = None


@dataclass(frozen=True)
class CoordinatePrograms:
    """Codes of one separated coordinate.

    Attributes:
        coordinate: which.
        constants, parameters: how many there are.
        with_kernels: whether ∂J/∂c are wanted.
    """

    coordinate: Separated
    constants: int
    parameters: int
    with_kernels: bool

    @cached_property
    def views(self) -> tuple[ViewPrograms, ViewPrograms]:
        """Codes of the lower and of the upper half."""
        known = self.constants, self.parameters, self.with_kernels
        below, above = (_view(formula.squared, formula.full, *known) for formula in sides(self.coordinate))
        return below, above

    @cached_property
    def small(self) -> SmallPrograms:
        """Codes of small motions."""
        plain = self.coordinate.plain
        return small_programs(plain.squared, plain.full, self.constants, self.parameters, self.with_kernels)

    @cached_property
    def exact(self) -> tuple[ExactPrograms, ExactPrograms]:
        """Codes of the lower and of the upper half, to 32 digits."""
        known = self.constants, self.parameters, self.with_kernels
        below, above = (
            _exact(formula.squared, formula.full, *known, k == 1) for k, formula in enumerate(sides(self.coordinate))
        )
        return below, above


# ------------------------------------------------------------------------------------------------------- views


def _jet(writer: InstructionWriter, squared: Tape, constants: int, parameters: int) -> list[Value]:
    """F, F′, F″ at an input x."""
    jets = Jets(writer)
    x, *known = writer.inputs(1 + constants)
    numbers = ParameterRows(writer, parameters).plain
    parts = squared.run(jets, [jets.variable(x), *(Jet(k) for k in (*known, *numbers))])[0]
    return [writer.number(0.0) if part is None else part for part in parts]


@lru_cache(maxsize=MADE)
def _view(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool) -> ViewPrograms:
    writer = InstructionWriter()
    parts = _jet(writer, squared, constants, parameters)
    # F[b, b + d] where all functions of p² have a rule; else F as it is written, with the bound that this has
    chorded = kernels and (
        bool(squared.operations) and {operation.code for operation in squared.operations} <= WITH_FIRST | ARITHMETIC
    )
    return ViewPrograms(
        bend=writer.code(parts),
        slopes=writer.code(parts[:2]),
        fill=_fill(squared, full, constants, parameters, kernels, chorded),
        errors=_errors(full if kernels else squared, constants, parameters),
        relative=_relative(squared, constants, parameters) if chorded else None,
        turn=_fill(squared, full, constants, parameters, kernels, False),
    )


def _fill(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool, chorded: bool) -> MachineCode:
    """F next to a turning point b is d F[b, b + d], which keeps its digits, where there are rules for that."""
    writer = InstructionWriter()
    d, x, root, b, *known = writer.inputs(4 + constants)
    known += ParameterRows(writer, parameters).plain
    if chorded:
        chords = FirstDifferences(writer, d)
        (F,) = squared.run(chords, [chords.variable(b, x), *map(chords.constant, known)])
        # F(b) = 0: F = d F[b, b + d], which keeps its relative accuracy down to d = 0
        square = writer.mul(d, F.slope)
        # kernels do not vanish at a turning point: they are taken at x itself, as written
        _, *weights = full.run(writer, [x, *known])
    else:
        square, *weights = (full if kernels else squared).run(writer, [x, *known])
    return filled(writer, root, square, weights)


def _errors(tape: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    x, rounding_error, mask, *rows = writer.inputs(3 + 2 * constants)
    numbers = ParameterRows(writer, parameters)
    # one program for both: with mask 0 the constants count as exact, and the difference is what they do
    known = [WithErrorBound(c, writer.mul(mask, e)) for c, e in zip(rows[:constants], rows[constants:], strict=True)]
    results = tape.run(
        RunningError(writer, own=ROUNDINGS), [WithErrorBound(x, rounding_error), *known, *numbers.rounded]
    )
    return writer.code([*(error_of(writer, r) for r in results), results[0].value])


def _relative(squared: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    b, d, x, rounding_error, *known = writer.inputs(4 + constants)
    numbers = ParameterRows(writer, parameters)
    chords = FirstDifferences(RunningError(writer, own=ROUNDINGS), WithErrorBound(d))
    inputs = [chords.variable(WithErrorBound(b), WithErrorBound(x, rounding_error))]
    inputs += [chords.constant(WithErrorBound(c)) for c in known]
    inputs += [chords.constant(x) for x in numbers.rounded]
    # the bound on F[b, b + d] over its size: d is exact, so that of F is the same
    slope = squared.run(chords, inputs)[0].slope
    return writer.code([writer.div(writer.unary("abs", error_of(writer, slope)), writer.unary("abs", slope.value))])


# ------------------------------------------------------------------------------------------------------- 32 digits
@lru_cache(maxsize=MADE)
def _exact(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool, upper: bool) -> ExactPrograms:
    return ExactPrograms(
        squares=_squares(squared, constants, parameters),
        fill=_exact_fill(squared, full, constants, parameters, kernels, upper),
        errors=_exact_errors(squared, full, constants, parameters, kernels, upper),
    )


def _squares(squared: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    x, low, *rows = writer.inputs(2 + 2 * constants)
    known = [PairOfValues(*both) for both in zip(rows[:constants], rows[constants:], strict=True)]
    known += ParameterRows(writer, parameters).pairs
    return writer.code([squared.run(PairWriter(writer), [PairOfValues(x, low), *known])[0].high])


def _at(
    squared: Tape, writer: InstructionWriter, rows: Sequence[Value], numbers: ParameterRows, d: Value, upper: bool
) -> tuple[Value, Value]:
    """F at a distance d from a turning point, and the place in doubles."""
    pairs, constants = PairWriter(writer), (len(rows) - 4) // 2
    base = PairOfValues(*rows[-2:]) if upper else PairOfValues(*rows[-4:-2])
    # b in two doubles and d: the place next to a close zero is known to d's digits
    place = pairs.add(base, pairs.of(d))
    known = [PairOfValues(*both) for both in zip(rows[:constants], rows[constants : 2 * constants], strict=True)]
    return squared.run(pairs, [place, *known, *numbers.pairs])[0].high, place.high


def _exact_fill(squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool, upper: bool) -> MachineCode:
    writer = InstructionWriter()
    d, _, root, _, *rows = writer.inputs(4 + 2 * constants + 4)
    numbers = ParameterRows(writer, parameters)
    square, place = _at(squared, writer, rows, numbers, d, upper)
    weights = full.run(writer, [place, *rows[:constants], *numbers.plain])[1:] if kernels else []
    return filled(writer, root, square, weights)


def _exact_errors(
    squared: Tape, full: Tape, constants: int, parameters: int, kernels: bool, upper: bool
) -> MachineCode:
    """F is known relatively, but for a part of what doubles lose of it, and for the rounding of d, which moves it.

    The errors of the constants are never told apart.
    """
    writer = InstructionWriter()
    d, _, _, *rows = writer.inputs(3 + 2 * constants + 4 + constants)
    rows, e = rows[:-constants], rows[-constants:]
    numbers = ParameterRows(writer, parameters)
    square, place = _at(squared, writer, rows, numbers, d, upper)
    rounding_error = writer.mul(writer.number(PLACE), writer.unary("abs", place))
    known = [*map(WithErrorBound, rows[:constants], e), *numbers.rounded]
    inputs = [WithErrorBound(place, rounding_error), *known]
    # one run in doubles bounds the kernels, and by ``FINER`` of it what p² loses in 32 digits
    approximate, *others = (full if kernels else squared).run(RunningError(writer, own=ROUNDINGS), inputs)
    jets = Jets(writer)
    known_ = [*rows[:constants], *numbers.plain]
    first = squared.run(jets, [jets.variable(place), *map(Jet, known_)])[0].first
    slope = writer.number(0.0) if first is None else first
    moved = writer.mul(writer.number(PLACE), writer.unary("abs", writer.mul(d, slope)))
    own = writer.add(
        writer.mul(writer.number(_RELATIVE), writer.unary("abs", square)),
        writer.add(moved, writer.mul(writer.number(FINER), error_of(writer, approximate))),
    )
    return writer.code([own, *(error_of(writer, r) for r in others), square])


# ------------------------------------------------------------------------------------------------------- starts
@lru_cache(maxsize=MADE)
def start_code(rule: Tape, shift: Tape, indices: tuple[int, ...], coordinates: int, parameters: int) -> MachineCode:
    """Return the code of the constants.

    q, p, low parts of p, bounds on p's errors in doubles ↦ the constants, their low parts, bounds on their errors, and
    the shell momenta of the separated coordinates.

    Args:
        rule: the constants as functions of q, p and the parameters.
        shift: what is to be added to p.
        indices: places of the separated coordinates among all.
        coordinates, parameters: how many there are.
    """
    writer, n = InstructionWriter(), coordinates
    rows = writer.inputs(4 * n)
    numbers = ParameterRows(writer, parameters)
    places, momenta, low, spread = (rows[k : k + n] for k in range(0, 4 * n, n))
    given = [*map(WithErrorBound, places), *map(WithErrorBound, momenta, spread), *numbers.rounded]
    errors = [error_of(writer, r) for r in rule.run(RunningError(writer, own=ROUNDINGS), given)]
    pairs = PairWriter(writer)
    inputs = [*map(pairs.of, places), *map(PairOfValues, momenta, low), *numbers.pairs]
    constants, shifts = rule.run(pairs, inputs), shift.run(pairs, inputs)
    shell = [pairs.add(inputs[n + k], moved).high for k, moved in zip(indices, shifts, strict=True)]
    uncertain = [
        writer.add(writer.unary("abs", value.low), writer.mul(writer.number(FINER), error))
        for value, error in zip(constants, errors, strict=True)
    ]
    return writer.code([*(c.high for c in constants), *(c.low for c in constants), *uncertain, *shell])


@dataclass(frozen=True)
class SystemPrograms:
    """Codes of a system.

    Attributes:
        start: of the constants.
        coordinates: of the separated coordinates.
        parameters: their values, for every code.
    """

    start: MachineCode
    coordinates: tuple[CoordinatePrograms, ...]
    parameters: tuple[float, ...]


def system_programs(model: Model, *, kernels: bool) -> SystemPrograms:
    """Return the codes of a system.

    Args:
        kernels: whether ∂J/∂c are wanted.
    """
    constants, parameters = len(model.constants), len(model.numbers)
    indices = tuple(c.index for c in model.separated)
    start = start_code(model.rule, model.shift, indices, len(model.names), parameters)
    coordinates = tuple(CoordinatePrograms(c, constants, parameters, kernels) for c in model.separated)
    return SystemPrograms(start, coordinates, tuple(parameter_rows(model.numbers)))
