"""The declared names of a system: coordinates and parameters, their symbols, and which names may be used."""

from __future__ import annotations

import keyword
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve import arguments
from hjsolve.display.shown import Shown
from hjsolve.display.visible_text import hidden_character
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.parser import RESERVED
from hjsolve.formulas.point_values import CONTEXT, evaluate
from hjsolve.formulas.read import number
from hjsolve.formulas.tokens import nearest_name, printable
from hjsolve.mechanics.domains import Domain, read_domain

Assumption = Literal["real", "positive", "negative", "nonnegative", "nonzero", "integer"]
_ASSUMPTIONS: tuple[Assumption, ...] = get_args(Assumption)
_OF_HJSOLVE = re.compile(r"(alpha|beta|mode)_[0-9]+")
_APPLIED = re.compile(r"\s*(\w+)\s*\(\s*(\w+(?:\s*,\s*\w+)*)\s*\)\s*")
_MAX_NAME = 40


@dataclass(frozen=True, repr=False)
class Coordinate(Shown):
    """A generalized coordinate with the symbols of its value q, velocity ``dot(q)`` and momentum ``p_q``.

    The value's symbol is positive (negative) where the domain proves it; all three are real.

    Attributes:
        name: as written in formulas.
        domain: the values it may take.
        symbol: of the value q.
        velocity: the symbol ``dot(q)``.
        momentum: the symbol ``p_q``.
    """

    name: str
    domain: Domain
    symbol: sp.Symbol
    velocity: sp.Symbol
    momentum: sp.Symbol


@dataclass(frozen=True, repr=False)
class Parameter(Shown):
    """A constant of the system; made by ``parameter``.

    Attributes:
        name: as written in formulas.
        symbol: real, and of the sign that ``assume`` says.
        value: the exact default, or None where a number must be given before anything is computed.
        assume: what holds for every value: real, positive, negative, nonnegative, nonzero, integer.
        unit: for display only.
        meaning: for display only.
    """

    name: str
    symbol: sp.Symbol
    value: sp.Expr | None
    assume: Assumption
    unit: str
    meaning: str

    @property
    def required(self) -> str:
        """What a value must be, in words."""
        return "an integer" if self.assume == "integer" else self.assume


@arguments.with_known_names('parameter("k", "1/2", assume="positive", unit="N/m")')
def parameter(name: str, value: object = None, *, assume: str = "real", unit: str = "", meaning: str = "") -> Parameter:
    """Declare a parameter.

    Args:
        name: as written in formulas.
        value: default, any number that ``formulas.read.number`` takes; None for no default.
        assume: ``real``, ``positive``, ``negative``, ``nonnegative``, ``nonzero`` or ``integer``; every later value
            must satisfy it.
        unit: unit of the value, for display.
        meaning: a few words, for display.

    Returns:
        The parameter, for ``System(parameters=…)``.

    Raises:
        InvalidSystemError: the name cannot be used, the assumption is unknown, or the value does not satisfy it.
        ExpressionError: the value is not a number.

    Example:
        >>> parameter("k", "1/2", assume="positive").value
        1/2
    """
    name = arguments.ascii_name(name)
    check_name(name, "parameter")
    for part, text in (("unit", unit), ("meaning", meaning)):
        refuse_hidden(text, f"parameter {name}: {part}")
    if name == "t":
        raise InvalidSystemError(
            "parameter t: t is the time, which needs no declaration in T and V. Rename the constant"
        )
    known = next((known for known in _ASSUMPTIONS if known == assume), None)
    if known is None:
        raise InvalidSystemError(
            f"parameter {name}: assume={printable(repr(assume))[:40]} is unknown; "
            f"write one of {', '.join(_ASSUMPTIONS)}"
        )
    exact = None if value is None else number(value, source=f"parameter {name}")
    declared = with_assumption(Parameter(name, sp.Symbol(name, real=True), exact, "real", unit, meaning), known)
    check_value(declared)
    return declared


def with_assumption(declared: Parameter, assume: Assumption) -> Parameter:
    """Return a parameter of which something else holds, with the symbol that says so.

    Args:
        declared: the parameter.
        assume: what holds for every value.
    """
    known = {} if assume == "real" else {assume: True}
    return replace(declared, symbol=sp.Symbol(declared.name, real=True, **known), assume=assume)


def refuse_hidden(text: object, source: str) -> None:
    """Refuse a text for display that holds a control or bidirectional character.

    Args:
        text: as the user wrote it.
        source: what it is called in the message.

    Raises:
        InvalidSystemError: it holds one.
    """
    if hidden := hidden_character(str(text)):
        raise InvalidSystemError(f"{source}: the character {hidden} in it cannot be displayed; leave it out")


def check_value(declared: Parameter) -> None:
    """Refuse a value that contradicts the parameter's assumption.

    Args:
        declared: the parameter; one without a value passes.

    Raises:
        InvalidSystemError: the value has another sign than the parameter must have, or is not an integer.
    """
    if contradicts(declared):
        raise InvalidSystemError(f"parameter {declared.name} = {declared.value}: it must be {declared.required}")


_SIGNS = {"positive": (1,), "negative": (-1,), "nonnegative": (0, 1), "nonzero": (-1, 1)}


def contradicts(declared: Parameter, assumption: Assumption | None = None) -> bool:
    """Return whether the value is not as it must be; one that is missing is.

    Args:
        declared: the parameter.
        assumption: what must hold; None for the parameter's own.
    """
    value, assume = declared.value, assumption or declared.assume
    if value is None:
        return False
    if assume == "integer":
        return not value.is_Integer
    sign = 0 if value.is_zero else CONTEXT.sign(evaluate(value, {}))
    return sign not in _SIGNS.get(assume, (-1, 0, 1))


def replaced(parameters: Iterable[Parameter], values: Mapping[str, object]) -> Iterator[Parameter]:
    """Parameters with other values.

    Args:
        parameters: as declared.
        values: name → number; None takes the default away.

    Raises:
        InvalidSystemError: a value contradicts an assumption.
        ExpressionError: a value is not a number.
    """
    for p in parameters:
        if p.name in values:
            value = values[p.name]
            p = replace(p, value=None if value is None else number(value, source=f"parameter {p.name}"))
            check_value(p)
        yield p


def read_parameters(given: Mapping[str, object]) -> tuple[Parameter, ...]:
    """Return the parameters of a mapping name → Parameter, number or None.

    Args:
        given: as the user wrote it.

    Returns:
        The parameters in the order given.

    Raises:
        InvalidSystemError: no mapping, a ``Parameter`` under another name than its own, or a bad name or value.
    """
    if not isinstance(given, Mapping):
        raise InvalidSystemError(
            f'parameters: expected a mapping such as {{"m": 1, "k": None}}, got {type(given).__name__}'
        )
    read = []
    for name, value in arguments.table(given, "parameters").items():
        if isinstance(value, Parameter) and value.name != name:
            raise InvalidSystemError(f"parameters: {printable(str(name))[:40]} is given the parameter {value.name}")
        read.append(value if isinstance(value, Parameter) else parameter(name, value))
    return tuple(read)


def read_coordinates(given: Mapping[str, object], parameters: tuple[Parameter, ...]) -> tuple[Coordinate, ...]:
    """Return the coordinates of a mapping name → domain, with the symbols that T and V are written in.

    Args:
        given: as the user wrote it; domains as in ``read_domain``.
        parameters: declared before; ends of domains may hold them.

    Returns:
        The coordinates in the order given.

    Raises:
        InvalidSystemError: no mapping or an empty one, a bad name or domain, or a name declared twice.
    """
    if not isinstance(given, Mapping):
        raise InvalidSystemError(
            f'coordinates: expected a mapping such as {{"r": "0 < r", "theta": "angle"}}, got {type(given).__name__}'
        )
    if not given:
        raise InvalidSystemError('coordinates: at least one is needed, such as {"x": "line"}')
    given = arguments.table(given, "coordinates")
    for name in given:
        check_name(name, "coordinate")
    check_clashes([*given], [p.name for p in parameters])
    symbols = {p.name: p.symbol for p in parameters}
    return tuple(_coordinate(name, read_domain(name, domain, symbols)) for name, domain in given.items())


def read_functions(given: object, coordinates: Iterable[str], names: Mapping[str, sp.Symbol]) -> dict[str, sp.Expr]:
    """Return the functions left undetermined, of texts such as ``v1(r)`` or ``f(x, y)``: name → v1(r).

    Args:
        given: the texts.
        coordinates: the names that may be arguments.
        names: every declared name and its symbol.

    Raises:
        InvalidSystemError: no list of such texts, a name that is taken, or an argument that is not a coordinate.
    """
    example = 'write functions=["v1(r)"], the name of the function and the coordinates it depends on'
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InvalidSystemError(f"functions: expected a list of texts; {example}")
    places, found = list(coordinates), dict[str, sp.Expr]()
    for text in given:
        match = _APPLIED.fullmatch(text) if isinstance(text, str) else None
        if match is None:
            shown = printable(repr(text))[:60]
            raise InvalidSystemError(f"functions: {shown} is not a function of coordinates; {example}")
        name, arguments = match[1], [a.strip() for a in match[2].split(",")]
        check_name(name, "function")
        if name in names or name in found:
            raise InvalidSystemError(f"functions: {name} is declared twice; rename the function")
        for argument in arguments:
            if argument not in places:
                raise unknown_names(argument, places, "coordinate")
        if len(set(arguments)) < len(arguments):
            raise InvalidSystemError(f"functions: {text.strip()}: an argument occurs twice")
        found[name] = sp.Function(name)(*(names[a] for a in arguments))
    return found


def _coordinate(name: str, domain: Domain) -> Coordinate:
    sign = domain.sign()
    symbol = sp.Symbol(name, real=True) if sign == "unknown" else sp.Symbol(name, real=True, **{sign: True})
    return Coordinate(name, domain, symbol, sp.Symbol(f"dot({name})", real=True), sp.Symbol(f"p_{name}", real=True))


def check_name(name: object, role: str) -> None:
    """Refuse what is not an ASCII identifier, a Python keyword, and names that already mean something.

    Args:
        name: as the user wrote it.
        role: what it names, for the message: ``coordinate``, ``parameter`` ….

    Raises:
        InvalidSystemError: no identifier, or a name that means something already; the message says what to write.
    """
    shown = printable(str(name))[:_MAX_NAME]
    if not isinstance(name, str):
        raise InvalidSystemError(f"{role} {shown}: a name must be a text, got {type(name).__name__}")
    if keyword.iskeyword(name):
        other = {"lambda": "lam"}.get(name, f"{name}_")
        raise InvalidSystemError(f"{role} {shown}: a word of Python cannot be a name; write {other}")
    if len(name) > _MAX_NAME or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise InvalidSystemError(
            f"{role} '{shown}': a name is an ASCII letter followed by letters, digits or _, at most {_MAX_NAME}, "
            "such as r, theta, m_1"
        )
    if name in RESERVED:
        raise InvalidSystemError(f"{role} {shown}: the name is taken by the formula language; write {name}_0")
    if _OF_HJSOLVE.fullmatch(name):
        raise InvalidSystemError(f"{role} {shown}: the name is kept for the constants of the solution; rename it")


def check_clashes(coordinates: list[str], parameters: list[str]) -> None:
    """Refuse a name that is declared twice, or that is the momentum of a coordinate.

    Raises:
        InvalidSystemError: a name in both lists, or ``p_x`` next to a coordinate ``x``.
    """
    for name in parameters:
        if name in coordinates:
            raise InvalidSystemError(f"{name} is both a coordinate and a parameter; rename one of them")
    for name in (*coordinates, *parameters):
        if name.startswith("p_") and name[2:] in coordinates:
            raise InvalidSystemError(f"{name} is the name of the momentum of {name[2:]}; choose another name")


def free_name(name: str, taken: Iterable[str]) -> str:
    """Return a name that cannot be taken for one of those taken.

    Underscores are added at its end, which print as primes.

    Names that differ only in an underscore inside, r0 and r_0, are written alike.

    Args:
        name: the name wanted.
        taken: names in use.
    """
    looks = {_looks(other) for other in taken}
    while _looks(name) in looks:
        name += "_"
    return name


def clock_of(formulas: Iterable[object], declared: Collection[str]) -> tuple[Parameter, ...]:
    """Return the time t as a parameter without a value where T or V holds it and t is not declared; else nothing.

    Args:
        formulas: T and V as they were given, texts or sympy expressions.
        declared: names of coordinates and parameters.
    """
    if "t" in declared or not any(map(_holds_time, formulas)):
        return ()
    return (Parameter("t", sp.Symbol("t", real=True), None, "real", "", "time"),)


def _holds_time(formula: object) -> bool:
    if isinstance(formula, str):
        return re.search(r"(?<![\w'])t(?![\w('])", formula) is not None
    if not isinstance(formula, sp.Expr):
        return False
    moving = (AppliedUndef, sp.Derivative)  # x(t) and its derivative are how sympy writes q and dot(q)
    plain = formula.replace(lambda e: isinstance(e, moving), lambda _: sp.Dummy())
    return any(s.name == "t" for s in plain.free_symbols)


def time_letter(names: Iterable[str]) -> str:
    """Return what the parameter of a motion is called: t, or another letter where that is taken."""
    taken = list(names)
    return next(name for name in ("t", "tau", "s", "sigma", "t_") if free_name(name, taken) == name)


def _looks(name: str) -> tuple[str, int]:
    bare = name.rstrip("_")
    return bare.replace("_", ""), len(name) - len(bare)


def unknown_names(name: object, known: Iterable[str], role: str) -> InvalidSystemError:
    """Return the error for a name that the system does not declare.

    Args:
        name: as the user wrote it.
        known: the names declared; the message offers the nearest.
        role: what it should name, for the message: ``coordinate``, ``parameter`` ….
    """
    shown, known = printable(str(name))[:_MAX_NAME], list(known)
    near = nearest_name(shown, known)
    hint = f"did you mean {near}?" if near else f"known are {', '.join(known)}" if known else "it has none"
    return InvalidSystemError(f"{shown!r} is not a {role} of the system; {hint}")
