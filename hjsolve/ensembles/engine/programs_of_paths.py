"""Programs of paths through the complex plane: F and its first and second derivatives by the constants, with errors.

Over an offset x in a view of F (``lowered_solution``), t = dq/dχ there, the constants and bounds on their errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.machine.complex_writer import AnalyticWriter, ComplexRunningError, ComplexValue, ComplexWriter
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode, Value
from hjsolve.arithmetic.running_error import WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.lowered_solution import multiplied_out
from hjsolve.ensembles.engine.program_parts import MADE, ParameterRows
from hjsolve.formulas.removable_poles import without_removable_poles
from hjsolve.lowering import lower, with_plain_exponents
from hjsolve.solution.quadratures import Solution

_ROUNDED = 32 * UNIT
"""Roundings of products of F and its derivatives that make an integrand, and of t."""


@dataclass(frozen=True)
class PathPrograms:
    """Codes of one view of F on paths.

    Attributes:
        means: Re x, Im x, Re t, Im t, c ↦ Re r, Im r, Re F r, and real and imaginary parts of ½ F_j r and of
            (½ F_jk − ¼ F_j F_k/F) r, k ≥ j, where r = ±t/√F.
        bounds: the same with a bound on the error of x before c, and those of c after it ↦ bounds on the errors of the
            integrands, and then their sizes, F r first.
    """

    means: MachineCode
    bounds: MachineCode


def path_programs(solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr]) -> list[PathPrograms]:
    """Return the codes of the lower and of the upper half of a coordinate.

    Args:
        solution: of the system.
        name: of a separated coordinate.
        values: every parameter → exact number.
    """
    system, coordinate = solution.system, solution.system.coordinate(name)
    F = with_plain_exponents(solution.momentum_squared[name], values)
    F = without_removable_poles(F, coordinate.symbol)
    constants = tuple(c.symbol for c in solution.constants.values())
    parameters = tuple(p.symbol for p in system.parameters)
    ends = (coordinate.domain.lower, 1), (coordinate.domain.upper, -1)
    tapes = [_differentiated(F, coordinate.symbol, constants, parameters, end, sign) for end, sign in ends]
    return [_programs(tape, len(constants), len(parameters)) for tape in tapes]


@lru_cache(maxsize=MADE)
def _differentiated(
    F: sp.Expr, q: sp.Symbol, constants: tuple[sp.Symbol, ...], parameters: tuple[sp.Symbol, ...],
    end: sp.Expr | None, sign: int,
) -> Tape:  # fmt: skip
    """F, F_j, F_jk (k ≥ j) in x, q = end ± x; q itself where there is no end."""
    first = [sp.diff(F, c) for c in constants]
    second = [sp.diff(first[j], c) for j in range(len(constants)) for c in constants[j:]]
    seen = [F, *first, *second]
    if end is not None:
        seen = [multiplied_out(e.subs(q, end + sign * q), q) for e in seen]
    return lower(seen, [q, *constants, *parameters])


@lru_cache(maxsize=MADE)
def _programs(tape: Tape, constants: int, parameters: int) -> PathPrograms:
    return PathPrograms(_means(tape, constants, parameters), _bounds(tape, constants, parameters))


def _means(tape: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    xr, xi, tr, ti, *rows = writer.inputs(4 + constants)
    a = AnalyticWriter(writer)
    known = [ComplexValue(v) for v in (*rows, *ParameterRows(writer, parameters).plain)]
    F, *others = tape.run(a, [ComplexValue(xr, xi), *known])
    t, half, quarter = ComplexValue(tr, ti), a.rational(1, 2), a.rational(1, 4)
    r = a.unary("sqrt", a.div(a.mul(t, t), F))
    found, part = [a.mul(half, a.mul(f, r)) for f in others[:constants]], a.mul(quarter, a.div(r, F))
    position = constants
    for j in range(constants):
        steep = a.mul(others[j], part)
        for k in range(j, constants):
            flat = a.mul(half, a.mul(others[position], r))
            found.append(a.sub(flat, a.mul(steep, others[k])))
            position += 1
    zero = writer.number(0.0)
    parts = [part for f in (r, *found) for part in (f.re, zero if f.im is None else f.im)]
    return writer.code([*parts[:2], a.mul(F, r).re, *parts[2:]])


def _bounds(tape: Tape, constants: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    xr, xi, tr, ti, blur, *rows = writer.inputs(5 + 2 * constants)
    plain, add, mul = ComplexWriter(writer), writer.add, writer.mul
    numbers = ParameterRows(writer, parameters)
    pairs = [*zip(rows[:constants], rows[constants:], strict=True), *((x.value, x.error) for x in numbers.rounded)]
    known = [WithErrorBound(ComplexValue(v), None if e is None else ComplexValue(e)) for v, e in pairs]
    place = WithErrorBound(ComplexValue(xr, xi), ComplexValue(blur))
    results = tape.run(ComplexRunningError(plain), [place, *known])
    zero, half, quarter = (writer.number(x) for x in (0.0, 0.5, 0.25))
    sizes = [plain.unary("abs", f.value).re for f in results]
    errors = [zero if f.error is None else f.error.re for f in results]
    root = writer.unary("sqrt", sizes[0])
    r = writer.div(plain.unary("abs", ComplexValue(tr, ti)).re, root)
    relative = writer.div(errors[0], sizes[0])  # δr = ½ r δF/F
    part, rounded = writer.div(mul(quarter, r), sizes[0]), writer.number(_ROUNDED)
    total, bounds = [mul(sizes[0], r)], [mul(mul(half, errors[0]), r)]

    def put(size: Value, bound: Value) -> None:
        total.append(size)
        bounds.append(bound)

    for f, e in zip(sizes[1 : 1 + constants], errors[1:], strict=False):
        flat = mul(half, mul(f, r))
        put(flat, add(mul(half, mul(e, r)), mul(mul(half, relative), flat)))
    position = 1 + constants
    for j in range(constants):
        for k in range(j, constants):
            (f, g), (e, d) = ((x[1 + j], x[1 + k]) for x in (sizes, errors))
            flat, steep = mul(half, mul(sizes[position], r)), mul(part, mul(f, g))
            bound = add(mul(half, mul(errors[position], r)), mul(part, add(mul(e, g), mul(f, d))))
            bound = add(bound, mul(relative, add(mul(half, flat), mul(writer.number(1.5), steep))))
            put(add(flat, steep), bound)
            position += 1
    return writer.code([*map(add, bounds, (mul(rounded, x) for x in total)), *total])
