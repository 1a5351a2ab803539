"""What is asked of a torus: frequencies or a ratio of them, and what is held. A ratio is that of |Ω|."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve import arguments
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.tori.from_actions import kinds_given
from hjsolve.motion.tori.radicand_curve import RadicandCurve, curves_of
from hjsolve.resonances.equations import Equation
from hjsolve.resonances.families import MotionFamily
from hjsolve.resonances.kerr_elements import ELEMENTS, KerrFamily
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True)
class TorusQuestion:
    """What is asked of a torus.

    Attributes:
        users: what is solved, expressed in the user's coordinates where others were found.
        solution: the same in the coordinates that separate, which tori are looked for in.
        unknowns: names of the numbers that tell a motion: its constants, or p, e and x of Kerr's geodesics.
        equations: that its frequencies meet.
        held: constant → exact value.
        parameters: name → exact number, where it differs from the default.
        kinds: separated coordinate → libration or rotation.
        between: constant → least and greatest value that are looked at.
        digits: asked.
        certified: whether motions are, and roots are proved.
        words: the equations in words.
    """

    users: Solution
    solution: Solution
    unknowns: tuple[str, ...]
    equations: tuple[Equation, ...]
    held: Mapping[str, sp.Expr]
    parameters: Mapping[str, sp.Expr]
    kinds: Mapping[str, str]
    between: Mapping[str, tuple[float, float]]
    digits: int
    certified: bool
    words: str

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names of the constants that are looked for."""
        return tuple(name for name in self.unknowns if name not in self.held)

    @property
    def family(self) -> MotionFamily | KerrFamily:
        """The motions that differ in the one unknown."""
        (unknown,), held = self.unknown, {name: to_bits(value) for name, value in self.held.items()}
        if self.unknowns != ELEMENTS:
            return MotionFamily(self.solution, held, unknown, self.parameters)
        values = {
            p.name: value for p, value in zip(self.solution.system.parameters, self._values.values(), strict=True)
        }
        return KerrFamily(self.solution, held, unknown, dict(self.parameters), values["M"], values["a"])

    @property
    def _values(self) -> Mapping[sp.Symbol, sp.Expr]:
        return parameter_values(self.solution.system, self.parameters)

    @property
    def curves(self) -> list[RadicandCurve]:
        """p² of the separated coordinates, in doubles."""
        return curves_of(self.solution, self._values, {})


def asked(
    solution: Solution, *, frequencies: object, ratio: object, fixed: object, between: object, kinds: object,
    parameters: object, digits: object, certified: object,
) -> TorusQuestion:  # fmt: skip
    """Read the arguments of ``Solution.torus``, as they are given there.

    Raises:
        InvalidInputError: what is no number, names that are not known, or equations that do not fit the unknowns.
    """
    users, solution = solution, replace(solution, chart=None)
    refuse_kinks(solution.system.kinks, "torus")
    if (frequencies is None) == (ratio is None):
        raise InvalidInputError('torus: frequencies={"r": 0.5} or ratio={"r": 2, "theta": 3} is needed, one of them')
    example = '{"E": "-3/10"}'
    given = {n: number(v, source=f"fixed[{n}]") for n, v in arguments.table(fixed, "fixed", example).items()}
    table = arguments.table(parameters, "parameters", '{"m": 1}')
    letters = {n: number(v, source=f"parameters[{n}]") for n, v in table.items()}
    elements = ELEMENTS if solution.system.id == "kerr" and given.keys() & set(ELEMENTS) else ()
    unknowns = elements or tuple(solution.constants)
    letters |= {n: v for n, v in given.items() if n not in unknowns}
    held = {n: v for n, v in given.items() if n in unknowns}
    if "x" in elements and abs(held.get("x", sp.S.Zero)) == 1:
        raise InvalidInputError(
            "fixed[x]: theta rests on the equator for x = 1 and -1; write a number next to it, 0.999"
        )
    known = {x.name for x in solution.system.parameters}
    if stray := [n for n in letters if n not in known]:
        raise InvalidInputError(f"fixed: {stray[0]!r} is neither a constant ({', '.join(unknowns)}) nor a parameter")
    names = [c.name for c in solution.system.coordinates if c.name in solution.coordinates or c.domain.kind == "angle"]
    equations, words = _equations(frequencies, ratio, names)
    result = TorusQuestion(
        users, solution, unknowns, equations, held, letters, kinds_given(solution, kinds), _bounds(unknowns, between),
        max(15, arguments.digits(digits)), bool(certified), words,
    )  # fmt: skip
    if len(result.unknown) != len(equations):
        raise InvalidInputError(_wrong_number(result))
    return result


def _equations(frequencies: object, ratio: object, names: list[str]) -> tuple[tuple[Equation, ...], str]:
    what, given = ("frequencies", frequencies) if ratio is None else ("ratio", ratio)
    table = arguments.table(given, what, f'{{"{names[0]}": 2}}' if names else "{}")
    values = {n: number(v, source=f"{what}[{n}]") for n, v in table.items()}
    for name, value in values.items():
        if name not in names:
            raise InvalidInputError(f"{what}: {name!r} has no frequency in this solution; known are {', '.join(names)}")
        if not value.is_positive:
            raise InvalidInputError(f"{what}[{name}]: a positive number is needed; the sign of a turn is that of p")
    if ratio is None:
        found = tuple(Equation({name: sp.S.One}, value) for name, value in values.items())
        return found, ", ".join(f"Ω_{name} = {in_words(value)}" for name, value in values.items())
    if len(values) < 2:
        raise InvalidInputError('ratio: two coordinates or more are needed, such as {"r": 2, "theta": 3}')
    (first, of_first), *others = values.items()
    found = tuple(Equation({first: value, name: -of_first}, sp.S.Zero) for name, value in others)
    told = " : ".join(f"Ω_{name}" for name in values), " : ".join(in_words(value) for value in values.values())
    return found, " = ".join(told)


def in_words(value: sp.Expr) -> str:
    """Return a number as errors write it: exactly where that is short.

    Args:
        value: exact.
    """
    return str(value) if len(str(value)) < 12 else f"{float(value):.9g}"


def _bounds(unknowns: tuple[str, ...], between: object) -> dict[str, tuple[float, float]]:
    found = {}
    for name, pair in arguments.table(between, "between", '{"E": (-1, 0)}').items():
        if name not in unknowns or not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InvalidInputError(f'between[{name}]: a constant and two numbers are needed, such as {{"E": (-1, 0)}}')
        low, high = (float(number(x, source=f"between[{name}]")) for x in pair)
        if not low < high:
            raise InvalidInputError(f"between[{name}]: the first number must be less than the second")
        found[name] = (low, high)
    return found


def _wrong_number(torus: TorusQuestion) -> str:
    n, free = len(torus.equations), torus.unknown
    return (
        f"torus: {torus.words} {'are' if n > 1 else 'is'} {n} equation{'s' if n > 1 else ''} for {len(free)} unknown "
        f"constants ({', '.join(free) or 'none'}); fixed={{…}} must leave {n} of {', '.join(torus.unknowns)}"
    )
