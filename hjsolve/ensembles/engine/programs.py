"""Programs of one system for the compiled pass, written from its tapes and compiled by numba (extra ``fast``).

A program is straight-line Python over doubles, or the same inside a loop over nodes that LLVM vectorises. Its text
comes from operation codes and numbers (``arithmetic/python_source.py``); nothing that a user wrote gets into it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from pickle import PickleError
from threading import RLock
from types import FunctionType, ModuleType
from typing import Any

from hjsolve.arithmetic.divided_differences import FirstDifferences
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.python_source import PythonSource, function
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.program_cache import fingerprint, is_cached, path_for
from hjsolve.ensembles.engine.radicand_views import has_chords

_OWN = 4
_SEARCHED = 6
_LOOPED = 11
_GLANCED = 13
"""How many arguments ``compiled_turning_points.ends`` and ``compiled_clearance.glances`` have, and
``compiled_integrals.orbits`` after the kind of program."""

_PLACE = "(2.2204460492503131e-16)"


@dataclass(frozen=True)
class Programs:
    """Compiled functions of one separated coordinate.

    Attributes:
        value: (x, c) ↦ F, c being the tuple of constants.
        search: finds turning points; the arguments of ``compiled_turning_points.ends``.
        loop: integrates; the arguments of ``compiled_integrals.orbits`` after the first two.
    """

    value: Callable[..., Any]
    search: Callable[..., Any]
    loop: Callable[..., Any]


@dataclass(frozen=True)
class Compiled:
    """Compiled functions of a system.

    Attributes:
        start: fills the constants, their doubts and the shell momenta.
        glance: tells how many nodes are proved to be enough; the arguments of ``compiled_clearance.glances``.
        coordinates: programs of the separated coordinates.
    """

    start: Callable[..., Any]
    glance: Callable[..., Any]
    coordinates: tuple[Programs, ...]


def available() -> bool:
    """Tell whether numba can be imported."""
    return find_spec("numba") is not None


@cache
def _coordinate_text(coordinate: Separated, constants: int, numbers: tuple[float, ...], kernels: bool) -> str:
    unpack = "".join(f"    c{j} = c[{j}]\n" for j in range(constants))
    names = [f"c{j}" for j in range(constants)]
    literals = [f"({x!r})" for x in numbers]
    squared, full = coordinate.plain.squared, coordinate.plain.full
    tape = full if kernels else squared

    def plain(name: str, run: Callable[[PythonSource], Sequence[str]]) -> str:
        source = PythonSource()
        results = run(source)
        head, body = function(name, ["x", "c"], source, results).split("\n", 1)
        return f"{head}\n{unpack}{body}"

    def jet(source: PythonSource, order: int) -> list[str]:
        jets = Jets(source)
        inputs = [jets.variable("x"), *(Jet(k) for k in names + literals)]
        parts = squared.run(jets, inputs)[0]
        return ["(0.0)" if part is None else part for part in parts[: order + 1]]

    return "\n".join(
        (
            plain("value", lambda s: squared.run(s, ["x", *names, *literals])),
            plain("slope", lambda s: jet(s, 1)),
            plain("bend", lambda s: jet(s, 2)),
            _fill_text(coordinate.plain, unpack, names + literals, kernels),
            _doubts_text(tape, constants, numbers),
            _relative_text(coordinate.plain, unpack, names, numbers),
            f"def pack(C, i):\n    return ({''.join(f'C[{j}, i], ' for j in range(constants))})\n",
            _front("search", "ends(", _SEARCHED),
            _front("loop", f"orbits({_chorded(coordinate, kernels)}, {kernels}, ", _LOOPED),
        )
    )


def _chorded(coordinate: Separated, kernels: bool) -> bool:
    return kernels and has_chords(coordinate.plain)


def _front(name: str, call: str, count: int) -> str:
    arguments = ", ".join(f"x{k}" for k in range(count))
    return f"def {name}({arguments}):\n    {call}{arguments})\n"


_GLANCE = _front("glance", "glances(", _GLANCED)


def _fill_text(formula: LoweredFormula, unpack: str, known: list[str], kernels: bool) -> str:
    """Fill the buffer; with kernels F next to a turning point b is (q − b) F[b, q], which keeps its digits."""
    source = PythonSource()
    if kernels and has_chords(formula):
        chords = FirstDifferences(source, "d")
        inputs = [chords.variable("b", "x"), *(chords.constant(k) for k in known)]
        (F,) = formula.squared.run(chords, inputs)
        square = source.mul("d", F.slope)
        _, *weights = formula.full.run(source, ["x", *known])
    else:
        square, *weights = (formula.full if kernels else formula.squared).run(source, ["x", *known])
    fixed, moving, kept = _divided(source.lines)
    lines = [
        *moving,
        f"r = pace[j] * sqrt_((W * low[j]) * (W * high[j]) / {square})",
        f"buffer[0, j] = {square} * r",
        "buffer[1, j] = r",
        f"buffer[2, j] = {square}",
        *(f"buffer[{3 + k}, j] = {w} * r" for k, w in enumerate(weights)),
    ]
    near = ["lower = low[j] <= 0.5", *(f"{name} = low_{name} if lower else high_{name}" for name in ["b", *kept])]
    near += ["d = W * low[j] if lower else -(W * high[j])", "x = b + d"]
    body = "".join(f"        {line}\n" for line in near + lines)
    ends = "".join(
        f"    {''.join(f'{side}_{name}, ' for name in ['b', *kept])} = anchor({end}, c)\n"
        for side, end in (("low", "first"), ("high", "last"))
    )
    anchor = f"def anchor(b, c):\n{unpack}" + "".join(f"    {line}\n" for line in fixed)
    anchor += f"    return ({''.join(f'{name}, ' for name in ['b', *kept])})\n"
    head = "def fill(buffer, first, last, W, low, high, pace, count, c):\n"
    return f"{anchor}\n{head}{unpack}{ends}    for j in range(count):\n{body}"


def _divided(lines: list[str]) -> tuple[list[str], list[str], list[str]]:
    """Lines that depend on the turning point alone, those that depend on the node, and names that pass between."""
    fixed, moving, made, kept, depends = [], [], set(), [], {"x", "d"}
    for line in lines:
        left, right = line.split(" = ", 1)
        names, words = left.split(", "), re.findall(r"[A-Za-z_]\w*", right)
        if depends.isdisjoint(words):
            fixed.append(line)
            made.update(names)
        else:
            moving.append(line)
            depends.update(names)
            kept += [word for word in words if word in made and word not in kept]
    return fixed, moving, kept


def _relative_text(formula: LoweredFormula, unpack: str, names: list[str], numbers: tuple[float, ...]) -> str:
    """Bounds on the relative error of F[b, b + d]."""
    source = PythonSource()
    if not has_chords(formula):
        return "def relative(out, base, offset, c):\n    out[:] = 0.0\n"
    chords = FirstDifferences(RunningError(source, own=_OWN), WithErrorBound("d"))
    place = source.add("b", "d")
    inputs = [
        chords.variable(WithErrorBound("b"), WithErrorBound(place, source.mul(_PLACE, source.unary("abs", place))))
    ]
    inputs += [chords.constant(WithErrorBound(c)) for c in names]
    inputs += [chords.constant(WithErrorBound(f"({x!r})", f"({abs(x) * UNIT!r})")) for x in numbers]
    slope = formula.squared.run(chords, inputs)[0].slope
    head = f"def relative(out, base, offset, c):\n{unpack}    for g in range(out.shape[0]):\n"
    lines = ["b = base[g]", "d = offset[g]", *source.lines, f"out[g] = abs({slope.error}) / abs({slope.value})"]
    return head + "".join(f"        {line}\n" for line in lines)


def _doubts_text(tape: Tape, constants: int, numbers: tuple[float, ...]) -> str:
    """Bounds on the errors of F and the kernels, and F; the constants are in doubt where the mask is 1."""
    source = PythonSource()
    place = source.mul(_PLACE, source.unary("abs", "x"))
    inputs = [WithErrorBound("x", place), *(WithErrorBound(f"c{j}", f"e{j}") for j in range(constants))]
    inputs += [WithErrorBound(f"({x!r})", f"({abs(x) * UNIT!r})") for x in numbers]
    results = tape.run(RunningError(source, own=_OWN), inputs)
    unpack = "".join(f"    c{j} = c[{j}]\n    s{j} = e[{j}]\n" for j in range(constants))
    head = f"def doubts(out, place, mask, c, e):\n{unpack}    for g in range(out.shape[1]):\n"
    lines = ["x = place[g]", *(f"e{j} = mask[g] * s{j}" for j in range(constants)), *source.lines]
    lines += [f"out[{k}, g] = {'(0.0)' if r.error is None else r.error}" for k, r in enumerate(results)]
    lines += [f"out[{len(results)}, g] = {results[0].value}"]
    return head + "".join(f"        {line}\n" for line in lines)


def _start_text(model: Model) -> str:
    """The constants, their doubts, and the shell momenta, of every orbit; the momenta may be in doubt."""
    n = len(model.names)
    source = PythonSource()
    names = [f"q[{k}, i]" for k in range(n)] + [f"p[{k}, i]" for k in range(n)]
    numbers = [WithErrorBound(f"({x.high!r})", f"({abs(x.high) * UNIT!r})") for x in model.numbers]
    given = [WithErrorBound(x) for x in names[:n]]
    given += [WithErrorBound(x, f"doubt[{k}, i]") for k, x in enumerate(names[n:])]
    results = model.rule.run(RunningError(source, own=_OWN), [*given, *numbers])
    shifts = model.shift.run(source, [*names, *(x.value for x in numbers)])
    lines = list(source.lines)
    for j, result in enumerate(results):
        lines += [f"C[{j}, i] = {result.value}", f"E[{j}, i] = {'(0.0)' if result.error is None else result.error}"]
    for k, (coordinate, shift) in enumerate(zip(model.separated, shifts, strict=True)):
        lines.append(f"P[{k}, i] = p[{coordinate.index}, i] + {shift}")
    body = "".join(f"        {line}\n" for line in lines)
    return f"def start(q, p, doubt, C, E, P):\n    for i in range(q.shape[1]):\n{body}"


_PARTS = ("slope", "bend", "anchor", "fill", "doubts", "relative", "pack", "value")
_FRONTS = ("search", "loop")
_UNREADABLE = (OSError, EOFError, PickleError)
_ONE_AT_A_TIME = RLock()


def _compile(text: str, parts: Sequence[str], fronts: Sequence[str]) -> dict[str, Any]:
    """Compile functions from a text of our own making; the parts are what the fronts call, which are kept on disk."""
    path = path_for(text)
    made = _functions(text, parts, fronts, path)
    if path is None:
        return made
    again = cache(partial(_functions, text, parts, fronts, None))
    return made | {name: _careful(made[name], partial(_named, again, name)) for name in fronts}


def _named(made: Callable[[], dict[str, Any]], name: str) -> Callable[..., Any]:
    return made()[name]


def _functions(text: str, parts: Sequence[str], fronts: Sequence[str], path: Path | None) -> dict[str, Any]:
    """Compile the functions of a text, and our loops beside them, which call them by their names."""
    from numba import njit

    from hjsolve.ensembles.engine import compiled_clearance, compiled_integrals, compiled_rule, compiled_turning_points
    from hjsolve.ensembles.engine.elementary import NAMES, OPTIONS

    name = fingerprint(text)
    module = ModuleType(f"hjsolve_program_{name}")
    space = module.__dict__
    loose = [
        function
        for part in (compiled_rule, compiled_integrals, compiled_turning_points, compiled_clearance)
        for function in part.BOUND
    ]
    for part in (compiled_rule, compiled_integrals, compiled_turning_points, compiled_clearance):
        space.update({key: item for key, item in vars(part).items() if not key.startswith("__")})
    space.update(NAMES, **{f.__name__: FunctionType(f.__code__, space, f.__name__) for f in loose})
    sys.modules[module.__name__] = module  # where numba looks for the surroundings of kept functions
    # written by Source from codes and numbers
    exec(compile(text, str(path or f"<{module.__name__}>"), "exec"), space)  # noqa: S102
    for key in (*(f.__name__ for f in loose), *parts, *fronts):
        space[key].__qualname__ = f"{key}_{name}"  # machine code of two programs must not share names
        space[key] = njit(cache=path is not None and key in fronts, **OPTIONS)(space[key])
    return {key: space[key] for key in (*parts, *fronts)}


def _careful(run: Callable[..., Any], again: Callable[[], Callable[..., Any]]) -> Callable[..., Any]:
    """A function that is compiled in memory where what was kept cannot be read, or new code not be written."""

    def call(*arguments: Any) -> Any:
        try:
            return run(*arguments)
        except _UNREADABLE:
            return again()(*arguments)

    return call


def _numbers(model: Model) -> tuple[float, ...]:
    return tuple(pair.high for pair in model.numbers)


@cache
def compiled_programs(coordinate: Separated, constants: int, numbers: tuple[float, ...], kernels: bool) -> Programs:
    """Compile the programs of a coordinate, once in a process.

    Args:
        coordinate: the separated one.
        constants: how many there are.
        numbers: values of the parameters, doubles.
        kernels: whether ∂J/∂c are wanted.
    """
    made = _compile(_coordinate_text(coordinate, constants, numbers, kernels), _PARTS, _FRONTS)
    return Programs(made["value"], made["search"], made["loop"])


@cache
def _one_program(text: str, name: str) -> Any:
    return _compile(text, (), (name,))[name]


def compiled(model: Model, *, kernels: bool) -> Compiled:
    """Compile the programs of a system, once in a process.

    Args:
        model: of the system.
        kernels: True when ∂J/∂c are wanted.
    """
    with _ONE_AT_A_TIME:  # else several threads would compile the same
        parts = tuple(compiled_programs(c, len(model.constants), _numbers(model), kernels) for c in model.separated)
        return Compiled(_one_program(_start_text(model), "start"), _one_program(_GLANCE, "glance"), parts)


def is_kept(model: Model, *, kernels: bool) -> bool:
    """Tell whether ``compiled`` would find all of its machine code on disk.

    Args:
        model: the lowered solution.
        kernels: whether ∂J/∂c are wanted.
    """
    texts = (_coordinate_text(c, len(model.constants), _numbers(model), kernels) for c in model.separated)
    others = is_cached(_start_text(model), ("start",)) and is_cached(_GLANCE, ("glance",))
    return available() and others and all(is_cached(text, _FRONTS) for text in texts)
