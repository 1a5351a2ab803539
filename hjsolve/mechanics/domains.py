"""Where a coordinate may go: the whole line, an angle, or an open interval; and the text that says so."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import sympy as sp

from hjsolve.arguments import ascii_name
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.read import parse
from hjsolve.formulas.tokens import nearest_name, printable

_EXAMPLES = '"line", "angle", "0 < r" or "-a < x < a"'
_INFINITE = re.compile(r"[+-]?\s*(oo|inf|infinity|∞)", re.IGNORECASE)


@dataclass(frozen=True)
class Domain:
    """The values of a coordinate.

    Attributes:
        kind: ``line`` (−∞ < q < ∞), ``angle`` (of period 2π), or ``interval``.
        lower: the open lower end of an interval; None where it has none.
        upper: the open upper end of an interval; None where it has none.
        closed: ends that were written with ``<=``; they have to be an axis or a pole of T (``check_closed_ends``).
    """

    kind: Literal["line", "angle", "interval"]
    lower: sp.Expr | None = None
    upper: sp.Expr | None = None
    closed: tuple[sp.Expr, ...] = field(default=(), compare=False)

    def written(self, name: str) -> str:
        """Return the text that declares this domain for the coordinate ``name``, e.g. ``0 < r``.

        Args:
            name: of the coordinate.
        """
        if self.kind != "interval":
            return self.kind
        left = "" if self.lower is None else f"{self.lower} < "
        return f"{left}{name}" + ("" if self.upper is None else f" < {self.upper}")

    def sign(self) -> Literal["positive", "negative", "unknown"]:
        """Return the sign that every value of the domain provably has."""
        if self.lower is not None and self.lower.is_nonnegative:
            return "positive"
        if self.upper is not None and self.upper.is_nonpositive:
            return "negative"
        return "unknown"


def read_domain(name: str, text: object, parameters: Mapping[str, sp.Expr]) -> Domain:
    """Read the domain of the coordinate ``name``.

    Args:
        text: ``line``, ``angle``, or an inequality such as ``0 < r``, ``r > 0``, ``-a < x < a``; ends are open. An
            axis or a pole may be written as an end that is included: ``0 <= R``, ``0 <= theta <= pi``.
        parameters: the names that bounds may use.

    Raises:
        InvalidSystemError: the text is not a such domain.
        ExpressionError: a bound is not a formula.
    """
    if not isinstance(text, str):
        raise InvalidSystemError(f"domain of {name}: expected a text, {_EXAMPLES}, got {type(text).__name__}")
    word = text.strip()
    if word in ("line", "angle"):
        return Domain(kind="line" if word == "line" else "angle")
    shown = printable(word[:60])
    strict = word.replace("≤", "<=").replace("≥", ">=")
    if "=" in re.sub(r"[<>]=", "", strict) or ("=" in strict and "2*pi" in word.replace(" ", "")):
        advice = 'write "angle" for a full turn' if "pi" in word else f"write {_EXAMPLES}"
        raise InvalidSystemError(f'domain of {name}: "{shown}" is not a domain; {advice}')
    included = [relation.endswith("=") for relation in re.findall(r"[<>]=?", strict)]
    word = strict.replace("=", "")
    sides = [ascii_name(side.strip()) for side in re.split(r"[<>]", word)]
    signs = set(re.findall(r"[<>]", word))
    if len(sides) not in (2, 3) or len(signs) != 1 or not all(side.strip() for side in sides):
        near = nearest_name(word, ("line", "angle"))
        hint = f'did you mean "{near}"?' if near else f"write {_EXAMPLES}"
        raise InvalidSystemError(f'domain of {name}: "{shown}" is not a domain; {hint}')
    if signs == {">"}:
        sides.reverse()
        included.reverse()
    domain = _interval(name, [side.strip() for side in sides], shown, parameters)
    ends = [domain.lower, domain.upper] if len(sides) == 3 else [domain.lower if sides[1] == name else domain.upper]
    closed = tuple(end for end, inside in zip(ends, included, strict=True) if inside and end is not None)
    return replace(domain, closed=closed)


def _interval(name: str, sides: list[str], shown: str, parameters: Mapping[str, sp.Expr]) -> Domain:
    """Return the interval lower < name < upper, either end of which may be missing."""
    if sides.count(name) != 1 or (len(sides) == 3 and sides[1] != name):
        message = f"expected {name} between its bounds, or on one side"
        raise InvalidSystemError(f'domain of {name}: "{shown}" does not bound {name}; {message}, as in "0 < {name}"')
    place = sides.index(name)
    bounds = []
    for side in (*sides[:place], *sides[place + 1 :]):
        if _INFINITE.fullmatch(side):
            raise InvalidSystemError(f'domain of {name}: "{shown}": leave out an infinite end, or write "line"')
        bounds.append(parse(side, parameters, source=f"domain of {name}"))
    lower, upper = (*bounds[:place], *([None] if place == 0 else []), *bounds[place:], None)[:2]
    if lower is not None and upper is not None and (upper - lower).is_nonpositive:
        raise InvalidSystemError(f'domain of {name}: "{shown}" is empty; the lower end must be below the upper')
    return Domain(kind="interval", lower=lower, upper=upper)
