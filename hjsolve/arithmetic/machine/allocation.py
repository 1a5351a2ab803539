"""From written instructions to a ``MachineCode``.

What no result needs is left out, products are fused into sums, and rows are given out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.code import MachineCode
from hjsolve.arithmetic.machine.operations import LENGTH, OPERATIONS, RESULTS

Value = int
"""A number that a program works out, before it has a row."""


class Instruction(NamedTuple):
    """An operation, the values it makes, and those it takes."""

    name: str
    results: tuple[Value, ...]
    operands: tuple[Value, ...]


def allocated(
    written: Sequence[Instruction], inputs: Sequence[Value], parameters: Sequence[Value],
    numbers: Mapping[Value, float], results: Sequence[Value],
) -> MachineCode:  # fmt: skip
    """Return the code that works out some values.

    Rows of inputs, parameters and constants keep what is in them; so do those of what depends on parameters and
    constants alone, which is worked out once. Others go to another value when the last reader of theirs is done. No
    result has a row of its operands.

    Args:
        written: instructions, each after those whose results it takes.
        inputs, parameters: values that are given.
        results: the values wanted, in the order of the outputs.
    """
    lines = _needed(_fused(_needed(written, results), results), results)
    once, rest = _divided(lines, {*parameters, *numbers})
    used = {v for line in lines for v in line.operands} | set(results)
    constants = {value: number for value, number in numbers.items() if value in used}
    fixed = [*inputs, *parameters, *constants, *(v for line in once for v in line.results)]
    row = {value: k for k, value in enumerate(fixed)}
    rows = _give_rows(rest, row, results)
    return MachineCode(
        _bytes(rest, row), _bytes(once, row), len(inputs), len(parameters), tuple(constants.values()),
        tuple(row[v] for v in results), rows,
    )  # fmt: skip


def _needed(lines: Sequence[Instruction], results: Sequence[Value]) -> list[Instruction]:
    """Return the instructions that some values depend on."""
    wanted, kept = set(results), []
    for line in reversed(lines):
        if not wanted.isdisjoint(line.results):
            kept.append(line)
            wanted.update(line.operands)
    return kept[::-1]


def _divided(lines: Iterable[Instruction], known: set[Value]) -> tuple[list[Instruction], list[Instruction]]:
    """Instructions that depend on known values alone, and the others."""
    once, rest = [], []
    for line in lines:
        if known.issuperset(line.operands):
            once.append(line)
            known.update(line.results)
        else:
            rest.append(line)
    return once, rest


def _fused(lines: Sequence[Instruction], results: Sequence[Value]) -> list[Instruction]:
    """Make one operation of |a|·b, a·b ± c, c − a·b and |a|·b + c, where the first part has no other use."""
    uses = dict.fromkeys(results, 2)
    for line in lines:
        for v in line.operands:
            uses[v] = uses.get(v, 0) + 1
    found: dict[Value, Instruction] = {}
    for line in lines:
        for place in (0, 1) if line.name in {"add", "sub", "mul"} else ():
            part, other = found.get(line.operands[place]), line.operands[1 - place]
            name = _fusion(line.name, part.name, place) if part and uses[line.operands[place]] == 1 else None
            if part and name:
                line = Instruction(name, line.results, (*part.operands, other))
                break
        found[line.results[0]] = line
    return list(found.values())


def _fusion(outer: str, inner: str, place: int) -> str | None:
    """Return the operation that does both; the inner one is the first operand (place 0) or the second."""
    if outer == "mul":
        return "absmul" if inner == "abs" else None
    if inner == "mul":
        return "fma" if outer == "add" else ("fms", "fnma")[place]
    return "fmaabs" if inner == "absmul" and outer == "add" else None


def _give_rows(lines: Sequence[Instruction], row: dict[Value, int], results: Sequence[Value]) -> int:
    """Give every value of some instructions a row after those that are fixed; return how many rows there are then."""
    last = {v: k for k, line in enumerate(lines) for v in (*line.operands, *line.results)}
    last.update(dict.fromkeys((*results, *row), len(lines)))
    rows, free = len(row), list[int]()
    for k, line in enumerate(lines):
        for value in line.results:
            row[value] = free.pop() if free else rows
            rows = max(rows, row[value] + 1)
        done = {v for v in (*line.operands, *line.results) if last[v] == k}
        free += [row[v] for v in sorted(done)]
    return rows


def _bytes(lines: Sequence[Instruction], row: Mapping[Value, int]) -> bytes:
    """Instructions as integers; unused places name row 0."""
    written = np.zeros((len(lines), LENGTH), dtype=np.int32)
    for k, line in enumerate(lines):
        written[k, 0] = OPERATIONS[line.name].code
        written[k, 1 : 1 + len(line.results)] = [row[v] for v in line.results]
        written[k, 1 + RESULTS : 1 + RESULTS + len(line.operands)] = [row[v] for v in line.operands]
    return written.tobytes()
