"""Formulas with integrals: the text ``integral(f, q)`` and sympy's ``Integral``, in the names that are declared."""

from __future__ import annotations

import re
from collections.abc import Mapping

import sympy as sp

from hjsolve.algebra.signs import Bounds
from hjsolve.arguments import ascii_name, described
from hjsolve.errors import ExpressionError, InvalidInputError
from hjsolve.formulas.parser import RESERVED
from hjsolve.formulas.read import admit, parse
from hjsolve.mechanics.coordinates_and_parameters import read_coordinates

_CALL = re.compile(r"\b(?:[iI]ntegral|integrate)\s*\(")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_MOST_INTEGRALS = 40
Names = Mapping[str, sp.Expr]
_NO_VELOCITIES: Mapping[str, sp.Symbol] = {}


def read_formula(
    given: object, names: Names, source: str, velocities: Mapping[str, sp.Symbol] = _NO_VELOCITIES
) -> sp.Expr:
    """Read a formula that may hold integrals.

    Args:
        given: a text, in which ``integral(f, q)`` is an antiderivative over q and ``integral(f, q, a)`` the integral
            from a to q; sympy's ``Integral`` and ``integrate`` are read as well; a sympy expression; or a number.
        names: the names that may occur and their symbols.
        source: what the formula is called in an error.
        velocities: what ``dot(q)`` stands for, by the name of the coordinate.

    Raises:
        ExpressionError: it cannot be read.
        InvalidInputError: neither text, sympy expression nor number.
    """
    if isinstance(given, str):
        return _of_text(given, names, source, velocities)
    if isinstance(given, sp.Expr):
        return _of_sympy(given, names, source, velocities)
    if isinstance(given, int):
        return sp.Integer(given)
    raise InvalidInputError(f"{source}: a formula as text or as a sympy expression is needed, not {described(given)}")


def _of_text(text: str, names: Names, source: str, velocities: Mapping[str, sp.Symbol]) -> sp.Expr:
    integrals: dict[str, sp.Expr] = {}
    while found := _CALL.search(text):
        if len(integrals) == _MOST_INTEGRALS:
            raise ExpressionError(f"{source}: more than {_MOST_INTEGRALS} integrals", source=source, text=text[:200])
        end = _closing(text, found.end(), source)
        name = f"integral_{len(integrals) + 1}"
        integrals[name] = _integral(text[found.end() : end], names, source)
        text = f"{text[: found.start()]}{name}{text[end + 1 :]}"
    letters = {name: sp.Dummy(name, real=True) for name in integrals}
    plain = parse(text, {**names, **letters}, velocities=velocities, source=source)
    return plain.xreplace({letters[name]: value for name, value in integrals.items()})


def _closing(text: str, start: int, source: str) -> int:
    depth = 1
    for place in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        if depth == 0:
            return place
    raise ExpressionError(f"{source}: integral( has no closing bracket", source=source, text=text[:200])


def _integral(inside: str, names: Names, source: str) -> sp.Expr:
    """∫ f dq, from a where a lower limit is given; the limit must not depend on q."""
    parts, depth = [""], 0
    for letter in inside:
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    if len(parts) == 2 and (ends := re.fullmatch(r"\s*\(([^,]*),([^,]*),([^,]*)\)\s*", parts[1])):
        if ends[1].strip() != ends[3].strip():
            raise ExpressionError(
                f"{source}: write integral(f, q, lower limit); its upper limit is q, not {ends[3].strip()[:40]}"
            )
        parts = [parts[0], ends[1], ends[2]]
    if len(parts) not in (2, 3):
        raise ExpressionError(
            f"{source}: write integral(f, q) or integral(f, q, lower limit), not integral({inside[:60]})",
            source=source, text=inside[:200],
        )  # fmt: skip
    name = ascii_name(parts[1].strip())
    q = names.get(name)
    if not isinstance(q, sp.Symbol):
        raise ExpressionError(f"{source}: integral over {name[:40]}, which is not a declared name", source=source)
    integrand = _of_text(parts[0], names, source, _NO_VELOCITIES)
    if len(parts) == 2:
        return sp.Integral(integrand, q)
    lower = _of_text(parts[2], names, source, _NO_VELOCITIES)
    if lower.has(q):
        raise ExpressionError(f"{source}: the lower limit of an integral over {name} depends on {name}", source=source)
    return sp.Integral(integrand, (q, lower, q))


def _of_sympy(given: sp.Expr, names: Names, source: str, velocities: Mapping[str, sp.Symbol]) -> sp.Expr:
    found: dict[str, sp.Expr] = {}
    letters: dict[sp.Basic, sp.Dummy] = {}

    def letter(node: sp.Basic) -> sp.Symbol:
        name = f"integral_{len(found) + 1}"
        found[name] = _admitted(node, names, source)
        letters[sp.Symbol(name)] = sp.Dummy(name, real=True)
        return sp.Symbol(name)

    plain = given.replace(lambda e: isinstance(e, sp.Integral), letter)
    own = {symbol.name: dummy for symbol, dummy in letters.items()}
    read = admit(plain, {**names, **own}, velocities=velocities, source=source)
    return read.xreplace({own[name]: value for name, value in found.items()})


def _admitted(node: sp.Integral, names: Names, source: str) -> sp.Expr:
    if len(node.limits) != 1:
        raise ExpressionError(f"{source}: an integral over one variable at a time is needed", source=source)
    variable, *ends = node.limits[0]
    own = names.get(variable.name, sp.Symbol(variable.name, real=True))
    integrand = _of_sympy(node.function, {**names, variable.name: own}, source, _NO_VELOCITIES)
    if not ends:
        return sp.Integral(integrand, own)
    return sp.Integral(integrand, (own, *(_of_sympy(sp.sympify(end), names, source, _NO_VELOCITIES) for end in ends)))


def new_names(given: object, taken: Names, source: str) -> tuple[dict[str, sp.Symbol], dict[sp.Symbol, Bounds]]:
    """Return the symbols of names that a user declares in a call, and the intervals they lie in.

    Args:
        given: a name or names, as text separated by commas or as a sequence of texts or symbols; or name → domain, as
            of a coordinate, where the formulas hold on one side only: ``{"alpha": "0 < alpha"}``.
        taken: names that mean something already.
        source: what they are called in an error.

    Raises:
        InvalidInputError: no names, or one that cannot be used.
    """
    if isinstance(given, Mapping):
        declared = read_coordinates({ascii_name(name): domain for name, domain in given.items()}, ())
        _free(list(given), taken, source)
        return {c.name: c.symbol for c in declared}, {
            c.symbol: (c.domain.lower, c.domain.upper) for c in declared if c.domain.kind != "angle"
        }
    if isinstance(given, str):
        given = given.split(",")
    if not isinstance(given, (tuple, list)) or not given:
        raise InvalidInputError(f'{source}: names are needed, such as ("E", "alpha"), not {described(given)}')
    names = [ascii_name(item.name if isinstance(item, sp.Symbol) else str(item).strip()) for item in given]
    _free(names, taken, source)
    return {name: sp.Symbol(name, real=True) for name in names}, {}


def _free(names: list[str], taken: Names, source: str) -> None:
    for place, name in enumerate(names):
        if not _NAME.fullmatch(name) or name in (*RESERVED, "integral"):
            raise InvalidInputError(f"{source}: {name[:40]!r} is not a name; write a letter, then letters, digits or _")
        if name in taken or name in names[:place]:
            raise InvalidInputError(f"{source}: {name} means something already; choose another name")
