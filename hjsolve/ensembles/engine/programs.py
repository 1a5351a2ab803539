"""Programs of one system for the compiled pass, compiled by numba (extra ``fast``) and kept on disk.

Only the texts of ``program_texts`` are compiled for each system. Our loops are compiled once for all of them, and call
the programs through pointers.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path
from pickle import PickleError
from threading import RLock
from types import ModuleType, SimpleNamespace
from typing import Any

from numpy import ndarray

from hjsolve.arithmetic.error_free import Pair
from hjsolve.ensembles.engine.compiled_types import signatures
from hjsolve.ensembles.engine.exact_texts import EXACT, exact_text
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.program_cache import fingerprint, is_cached, path_for
from hjsolve.ensembles.engine.program_texts import SMALL, VIEW, small_text, start_text, view_text
from hjsolve.ensembles.engine.radicand_views import has_chords

Function = Callable[..., Any]
"""A function that numba compiled."""

_UNREADABLE = (OSError, EOFError, PickleError)
_ONE_AT_A_TIME = RLock()
_MADE = 64

_LOOPS = {
    "crests": (("bend", "uncertainties"), 5),
    "ends": (("bend", "slopes"), 4),
    "small_ends": (("value", "bounds"), 6),
    "glances": ((), 7),
    "integrals": (("fill", "fill", "uncertainties", "uncertainties", "relative", "relative"), 6),
}
"""Our loops: the programs that they take first, and the number of their other arguments."""


def _front(name: str, count: int) -> str:
    arguments = ", ".join(f"x{k}" for k in range(count))
    return f"def front_{name}({arguments}):\n    {name}({arguments})\n"


_FRONTS = "\n".join(_front(name, len(programs) + count) for name, (programs, count) in _LOOPS.items())


@dataclass(frozen=True)
class ViewPrograms:
    """Compiled functions of one view of p²; see ``program_texts``.

    Attributes:
        value, bend, slopes: F and its derivatives.
        fill, uncertainties, relative: of the nodes, and bounds on errors.
        chords: whether F comes from its slopes next to a turning point.
    """

    value: Function
    bend: Function
    slopes: Function
    fill: Function
    uncertainties: Function
    relative: Function
    chords: bool


@dataclass(frozen=True)
class SmallPrograms:
    """Compiled functions of small motions.

    Attributes:
        value: F[q₀, q₀, q].
        bounds: ½F″ and a bound on the error of the former.
        fill, uncertainties, relative: as of a view.
        slope: F′ from 32 digits.
    """

    value: Function
    bounds: Function
    fill: Function
    uncertainties: Function
    relative: Function
    slope: Function


@dataclass(frozen=True)
class ExactPrograms:
    """Compiled functions of one view that knows p² to 32 digits; see ``exact_texts``.

    Attributes:
        exact_squares: F of many orbits.
        fill, uncertainties, relative: as of a view.
    """

    exact_squares: Function
    fill: Function
    uncertainties: Function
    relative: Function


@dataclass(frozen=True)
class Loop:
    """One of our loops.

    Attributes:
        dispatcher: numba's.
        programs: the names of the programs that it takes first.
        entries: what ``_kind`` says of the other arguments → machine code for them.
    """

    dispatcher: Any
    programs: tuple[str, ...]
    entries: dict[Hashable, Function] = field(default_factory=dict, compare=False)

    def __call__(self, *arguments: Any) -> None:
        """Run the loop; it is compiled when it is first used in a process, or read from disk."""
        kind = _kind(arguments[len(self.programs) :])
        entry = self.entries.get(kind)
        if entry is None:
            entry = self.entries[kind] = self._entry(arguments)
        entry(*arguments)

    def _entry(self, arguments: tuple[Any, ...]) -> Function:
        from numba import typeof
        from numba.core.errors import NumbaExperimentalFeatureWarning

        known, count = signatures(), len(self.programs)
        types = (*(_pointer(known[name]) for name in self.programs), *map(typeof, arguments[count:]))
        if types not in self.dispatcher.overloads:
            with _ONE_AT_A_TIME, warnings.catch_warnings():
                warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
                self.dispatcher.compile(types)
        entry: Function = self.dispatcher.overloads[types].entry_point
        return entry


def _kind(argument: Any) -> Hashable:
    """What numba's type of an argument depends on; to make the type itself takes numba several times as long."""
    if isinstance(argument, ndarray):
        return argument.dtype, argument.ndim, argument.flags.num
    if isinstance(argument, tuple):
        return type(argument), *map(_kind, argument)
    return (type(argument),)


@dataclass(frozen=True)
class Loops:
    """All of them; see the modules they come from."""

    crests: Loop
    ends: Loop
    small_ends: Loop
    glances: Loop
    integrals: Loop


@dataclass(frozen=True)
class CoordinatePrograms:
    """Compiled functions of one separated coordinate.

    Attributes:
        below, above: of the views of the lower and of the upper half.
        small: makes those of small motions.
        exact: makes those that know p² to 32 digits, of the lower and of the upper half.
    """

    below: ViewPrograms
    above: ViewPrograms
    small: Callable[[], SmallPrograms]
    exact: Callable[[], tuple[ExactPrograms, ExactPrograms]]


@dataclass(frozen=True)
class Compiled:
    """Compiled functions of a system.

    Attributes:
        start: fills the constants in two doubles, their uncertainties and the shell momenta.
        loops: ours.
        coordinates: programs of the separated coordinates.
    """

    start: Function
    loops: Loops
    coordinates: tuple[CoordinatePrograms, ...]


def available() -> bool:
    """Tell whether numba can be imported."""
    return find_spec("numba") is not None


def _pointer(signature: Any) -> Any:
    from numba import types

    return types.FunctionType(signature)


@cache
def _module(text: str, names: tuple[str, ...], loops: bool) -> dict[str, Any]:
    """Compile functions from a text of our own making; programs at once, the fronts of loops when first used."""
    path = path_for(text)
    try:
        return _functions(text, names, path, loops=loops)
    except _UNREADABLE:  # what was kept cannot be read, or new code not be written
        if path is None:
            raise
        return _functions(text, names, None, loops=loops)


def _functions(text: str, names: Sequence[str], path: Path | None, *, loops: bool) -> dict[str, Any]:
    from numba import njit

    from hjsolve.ensembles.engine.compiled_pairs import PAIRS
    from hjsolve.ensembles.engine.elementary import NAMES, OPTIONS

    known = {} if loops else signatures()
    name = fingerprint(text)
    module = ModuleType(f"hjsolve_program_{name}")
    space = module.__dict__
    space.update(_our_loops() if loops else NAMES | PAIRS)
    sys.modules[module.__name__] = module  # where numba looks for the surroundings of kept functions
    # written by PythonSource from codes and numbers
    exec(compile(text, str(path or f"<{module.__name__}>"), "exec"), space)  # noqa: S102
    for key in names:
        space[key].__qualname__ = f"{key}_{name}"  # machine code of two programs must not share names
        space[key] = njit(known.get(key), cache=path is not None, **OPTIONS)(space[key])
        if key in known:
            _remember_addresses(space[key], known[key])
    return {key: space[key] for key in names}


def _remember_addresses(dispatcher: Any, signature: Any) -> None:
    """Let numba know at once where a program is: it asks twice whenever a loop takes it, for 50 µs each time."""
    found = dispatcher.get_compile_result(signature)
    names = found.fndesc.llvm_cfunc_wrapper_name, found.fndesc.llvm_func_name
    places = {name: found.library.get_pointer_to_function(name) for name in names}
    library = SimpleNamespace(get_pointer_to_function=places.__getitem__)
    known = SimpleNamespace(fndesc=found.fndesc, library=library, signature=found.signature)
    dispatcher.get_compile_result = lambda _: known


def _our_loops() -> dict[str, Any]:
    from hjsolve.ensembles.engine import compiled_clearance, compiled_integrals, compiled_turning_points

    found = vars(compiled_turning_points) | vars(compiled_integrals) | vars(compiled_clearance)
    return {name: found[name] for name in _LOOPS}


@cache
def _loops() -> Loops:
    made = _module(_FRONTS, tuple(f"front_{name}" for name in _LOOPS), True)
    return Loops(**{name: Loop(made[f"front_{name}"], programs) for name, (programs, _) in _LOOPS.items()})


def _numbers(model: Model) -> tuple[float, ...]:
    return tuple(pair.high for pair in model.numbers)


def _view(formula: LoweredFormula, model: Model, kernels: bool) -> ViewPrograms:
    text = view_text(formula, len(model.constants), _numbers(model), kernels)
    return ViewPrograms(**_module(text, VIEW, False), chords=kernels and has_chords(formula))


def sides(coordinate: Separated) -> tuple[LoweredFormula, LoweredFormula]:
    """Return the formulas by which the lower and the upper half of a motion are seen.

    Args:
        coordinate: the separated one.
    """
    return coordinate.lower or coordinate.plain, coordinate.upper or coordinate.plain


def _programs(coordinate: Separated, model: Model, kernels: bool) -> CoordinatePrograms:
    below, above = (_view(formula, model, kernels) for formula in sides(coordinate))

    def small() -> SmallPrograms:
        with _ONE_AT_A_TIME:
            return _small(coordinate.plain, len(model.constants), model.numbers, kernels)

    def exact() -> tuple[ExactPrograms, ExactPrograms]:
        with _ONE_AT_A_TIME:
            known = len(model.constants), model.numbers, kernels
            texts = (exact_text(formula, *known, k == 1) for k, formula in enumerate(sides(coordinate)))
            lower, upper = (ExactPrograms(**_module(text, EXACT, False)) for text in texts)
            return lower, upper

    return CoordinatePrograms(below, above, small, exact)


@lru_cache(maxsize=_MADE)
def _small(formula: LoweredFormula, constants: int, numbers: tuple[Pair, ...], kernels: bool) -> SmallPrograms:
    return SmallPrograms(**_module(small_text(formula, constants, numbers, kernels), SMALL, False))


@lru_cache(maxsize=_MADE)
def _made(model: Model, kernels: bool) -> Compiled:
    parts = tuple(_programs(c, model, kernels) for c in model.separated)
    return Compiled(_module(start_text(model), ("start",), False)["start"], _loops(), parts)


def program(text: str, name: str) -> Function:
    """Compile a function, once in a process, or read it from disk.

    Args:
        text: of our own making.
        name: of the function in it, one of ``compiled_types.signatures``.
    """
    with _ONE_AT_A_TIME:
        made: Function = _module(text, (name,), False)[name]
        return made


def compiled(model: Model, *, kernels: bool) -> Compiled:
    """Compile the programs of a system, once in a process.

    Args:
        model: of the system.
        kernels: True when ∂J/∂c are wanted.
    """
    with _ONE_AT_A_TIME:  # else several threads would compile the same
        return _made(model, kernels)


def is_kept(model: Model, *, kernels: bool) -> bool:
    """Tell whether ``compiled`` would find its machine code on disk.

    Args:
        model: the lowered solution.
        kernels: whether ∂J/∂c are wanted.
    """
    formulas = [formula for c in model.separated for formula in sides(c)]
    texts = (view_text(formula, len(model.constants), _numbers(model), kernels) for formula in formulas)
    fronts = ("front_ends", "front_glances", "front_integrals")
    others = is_cached(start_text(model), ("start",)) and is_cached(_FRONTS, fronts)
    return available() and others and all(is_cached(text, VIEW) for text in texts)
