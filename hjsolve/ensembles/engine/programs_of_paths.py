"""Programs of paths through the complex plane: F and its first and second derivatives by the constants, with errors.

Over an offset x in a view of F (``lowered_solution``), t = dq/dχ there, the variables and bounds on their errors. The
variables are the constants of the motion and, where they are varied, the parameters; of the second derivatives one is
by a constant.
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
from hjsolve.motion.derivatives.formulas import VariedSymbols
from hjsolve.solution.quadratures import Solution

_ROUNDED = 32 * UNIT
"""Roundings of products of F and its derivatives that make an integrand, and of t."""


@dataclass(frozen=True)
class PathPrograms:
    """Codes of one view of F on paths.

    Attributes:
        means: Re x, Im x, Re t, Im t, c ↦ Re r, Im r, Re F r, and real and imaginary parts of ½ F_j r and of
            (½ F_jk − ¼ F_j F_k/F) r, in the order of ``pairs``, where r = ±t/√F.
        bounds: the same with a bound on the error of x before c, and those of c after it ↦ bounds on the errors of the
            integrands, and then their sizes, F r first.
    """

    means: MachineCode
    bounds: MachineCode


def pairs(constants: int, varied: int) -> list[tuple[int, int]]:
    """List by which variables second derivatives are taken: a constant j, and every variable k ≥ j.

    Args:
        constants: how many constants there are, the first of the variables.
        varied: how many variables.
    """
    return [(j, k) for j in range(constants) for k in range(j, varied)]


def path_programs(
    solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], variables: VariedSymbols
) -> list[PathPrograms]:
    """Return the codes of the lower and of the upper half of a coordinate."""
    system, coordinate = solution.system, solution.system.coordinate(name)
    varied = set(variables.symbols)
    exponents = {s: v for s, v in values.items() if s not in varied}
    F = with_plain_exponents(solution.momentum_squared[name], exponents)
    F = without_removable_poles(F, coordinate.symbol)
    # parameters that are not varied stay inputs: a new value of them makes no program
    counts = len(variables.constants), variables.count
    fixed = tuple(p.symbol for p in system.parameters if p.symbol not in varied)
    ends = (coordinate.domain.lower, 1), (coordinate.domain.upper, -1)
    numbers = tuple((s, v) for s, v in values.items() if s in varied)
    tapes = [_differentiated(F, coordinate.symbol, variables, (fixed, numbers), end, sign) for end, sign in ends]
    return [_programs(tape, *counts, len(fixed)) for tape in tapes]


@lru_cache(maxsize=MADE)
def _differentiated(
    F: sp.Expr, q: sp.Symbol, variables: VariedSymbols,
    parameters: tuple[tuple[sp.Symbol, ...], tuple[tuple[sp.Symbol, sp.Expr], ...]], end: sp.Expr | None, sign: int,
) -> Tape:  # fmt: skip
    """F, F_j, F_jk at q = end ± x, or at x where there is no end; ``parameters`` are the fixed and the varied."""
    (fixed, numbers), symbols = parameters, variables.symbols
    first = [sp.diff(F, c) for c in symbols]
    second = [sp.diff(first[j], symbols[k]) for j, k in pairs(len(variables.constants), len(symbols))]
    # exponents that are varied are numbers only after the derivatives are taken
    seen = [with_plain_exponents(e, dict(numbers)) for e in (F, *first, *second)]
    if end is not None:
        # from the end of a domain, as in ``lowered_solution``: a pole there is a power of x
        seen = [multiplied_out(e.subs(q, end + sign * q), q) for e in seen]
    return lower(seen, [q, *symbols, *fixed])


@lru_cache(maxsize=MADE)
def _programs(tape: Tape, constants: int, varied: int, parameters: int) -> PathPrograms:
    return PathPrograms(_means(tape, constants, varied, parameters), _bounds(tape, constants, varied, parameters))


def _means(tape: Tape, constants: int, varied: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    xr, xi, tr, ti, *rows = writer.inputs(4 + varied)
    a = AnalyticWriter(writer)
    known = [ComplexValue(v) for v in (*rows, *ParameterRows(writer, parameters).plain)]
    F, *others = tape.run(a, [ComplexValue(xr, xi), *known])
    t, half, quarter = ComplexValue(tr, ti), a.rational(1, 2), a.rational(1, 4)
    # one root of a quotient; its sign is continued from step to step (``kernels.path_integrals``)
    r = a.unary("sqrt", a.div(a.mul(t, t), F))
    found, part = [a.mul(half, a.mul(f, r)) for f in others[:varied]], a.mul(quarter, a.div(r, F))
    for (j, k), f in zip(pairs(constants, varied), others[varied:], strict=True):
        # J_jk: (½ F_jk − ¼ F_j F_k/F) r, see ``contour_integrals``
        found.append(a.sub(a.mul(half, a.mul(f, r)), a.mul(a.mul(others[j], part), others[k])))
    zero = writer.number(0.0)
    # a real constant has no imaginary part to write; all rows have two
    parts = [part for f in (r, *found) for part in (f.re, zero if f.im is None else f.im)]
    return writer.code([*parts[:2], a.mul(F, r).re, *parts[2:]])


def _bounds(tape: Tape, constants: int, varied: int, parameters: int) -> MachineCode:
    writer = InstructionWriter()
    xr, xi, tr, ti, rounding_error, *rows = writer.inputs(5 + 2 * varied)
    plain, add, mul = ComplexWriter(writer), writer.add, writer.mul
    numbers = ParameterRows(writer, parameters)
    inputs = [*zip(rows[:varied], rows[varied:], strict=True), *((x.value, x.error) for x in numbers.rounded)]
    known = [WithErrorBound(ComplexValue(v), None if e is None else ComplexValue(e)) for v, e in inputs]
    place = WithErrorBound(ComplexValue(xr, xi), ComplexValue(rounding_error))
    results = tape.run(ComplexRunningError(plain), [place, *known])
    zero, half, quarter = (writer.number(x) for x in (0.0, 0.5, 0.25))
    sizes = [plain.unary("abs", f.value).re for f in results]
    errors = [zero if f.error is None else f.error.re for f in results]
    # bounds need only sizes: |r| = |t|/√|F|, real arithmetic
    root = writer.unary("sqrt", sizes[0])
    r = writer.div(plain.unary("abs", ComplexValue(tr, ti)).re, root)
    relative = writer.div(errors[0], sizes[0])  # δr = ½ r δF/F
    part, rounded = writer.div(mul(quarter, r), sizes[0]), writer.number(_ROUNDED)
    total, bounds = [mul(sizes[0], r)], [mul(mul(half, errors[0]), r)]

    def put(size: Value, bound: Value) -> None:
        total.append(size)
        bounds.append(bound)

    for f, e in zip(sizes[1 : 1 + varied], errors[1:], strict=False):
        flat = mul(half, mul(f, r))
        put(flat, add(mul(half, mul(e, r)), mul(mul(half, relative), flat)))
    own = zip(pairs(constants, varied), sizes[1 + varied :], errors[1 + varied :], strict=True)
    for (j, k), size, error in own:
        (f, g), (e, d) = ((x[1 + j], x[1 + k]) for x in (sizes, errors))
        flat, steep = mul(half, mul(size, r)), mul(part, mul(f, g))
        # δ(½ F_jk r) + δ(¼ F_j F_k r/F), but for δF
        bound = add(mul(half, mul(error, r)), mul(part, add(mul(e, g), mul(f, d))))
        # r ~ F^−½ and r/F ~ F^−3/2: half and three halves of δF/F
        bound = add(bound, mul(relative, add(mul(half, flat), mul(writer.number(1.5), steep))))
        put(add(flat, steep), bound)
    return writer.code([*map(add, bounds, (mul(rounded, x) for x in total)), *total])
