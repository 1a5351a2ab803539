"""Constraints of an entry with T and V: each holds in its own coordinates, or is one that ``System`` eliminates.

The literature's coordinates are x = f(q, t) by the table ``[stated] map``. A form Σ aᵢ(x, t) dot(xᵢ) + a(x, t) is put
into q and dot(q) by the chain rule, and has to vanish identically; so has the rate of its integral. A constraint
between coordinates of the entry that does not vanish is to be eliminated. An integral F given with it must have
dF ∝ Σ aᵢ dxᵢ + a dt (Greenwood (1-20)): all 2 × 2 minors of the two rows of coefficients vanish.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.catalog.toml_file import Toml, TomlTable
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import parse
from hjsolve.separation.zero_test.zero_test import Zero, is_zero

_CURE = "choose coordinates in which it holds, and say in [stated] map what {} in them"


@dataclass(frozen=True)
class ToEliminate:
    """A constraint between coordinates of the entry.

    Attributes:
        number: place among the constraints of the entry, from 1.
        equation: text for ``System(constraints=…)``.
        constant: the constant of integration, as a table of ``parameters``; None where the equation has none.
    """

    number: int
    equation: str
    constant: TomlTable | None


def to_eliminate(table: Toml) -> list[ToEliminate]:
    """Give the constraints that ``System`` has to eliminate: those between coordinates of T and V that do not hold.

    Args:
        table: of an entry or of ``[system]``, its schema checked.

    Raises:
        InvalidInputError: a formula that cannot be read, or an integral that does not belong to its form.
    """
    given, found = table.get("constraint", []), list[ToEliminate]()
    if not given or "kinetic" not in table:
        return found
    entry = _Coordinates(table)
    taken = {c["name"] for key in ("coordinates", "parameters") for c in table.get(key, [])}
    for number, constraint in enumerate(given, start=1):
        where, names = f"constraint[{number}]", entry.names(constraint)
        if entry.foreign(names) or isinstance(is_zero(entry.form(constraint["form"], names, f"{where}.form")), Zero):
            continue
        if "integral" not in constraint:
            if "constant" in constraint:
                raise InvalidInputError(f"{where}.constant: the value of an integral; write the integral too")
            found.append(ToEliminate(number, constraint["form"], None))
            continue
        entry.refuse_false_integral(constraint, names, where)
        name = next(f"c_{k}" for k in range(1, len(taken) + 2) if f"c_{k}" not in taken)
        taken.add(name)
        meaning = f"value of {constraint['integral']}"
        value = {"value": constraint["constant"]} if "constant" in constraint else {}
        constant: TomlTable = {"name": name, "meaning": meaning, **value}
        found.append(ToEliminate(number, f"{constraint['integral']} = {name}", constant))
    return found


def constraint_faults(table: Toml) -> Iterator[str]:
    """Yield a fault for every constraint that T and V do not obey and ``System`` cannot eliminate, one line each.

    Args:
        table: of an entry, its schema checked.
    """
    given = table.get("constraint", [])
    if not given or "kinetic" not in table:
        return
    try:
        entry, eliminated = _Coordinates(table), {e.number for e in to_eliminate(table)}
    except InvalidInputError as error:
        yield " ".join(str(error).split())
        return
    for number, constraint in enumerate(given, start=1):
        where, names = f"constraint[{number}]", entry.names(constraint)
        if number in eliminated:
            continue
        cure = _CURE.format(f"{', '.join(names)} {'is' if len(names) == 1 else 'are'}")
        try:
            rates = {
                "form": entry.form(constraint["form"], names, f"{where}.form"),
                "integral": entry.rate(constraint.get("integral", "0"), names, f"{where}.integral"),
            }
        except InvalidInputError as error:
            yield " ".join(str(error).split())
            continue
        for key, rate in rates.items():
            if not isinstance(is_zero(rate), Zero):
                what = "form" if key == "form" else "rate of the integral"
                yield (
                    f"{where}: T and V are used as they stand, and in their coordinates the constraint does not hold "
                    f"(the {what} is {str(rate)[:80]}, not zero); {cure}"
                )
                break


class _Coordinates:
    """The coordinates of an entry, and those of the literature as functions of them."""

    def __init__(self, table: Toml):
        self._symbols = {c["name"]: sp.Symbol(c["name"], real=True) for c in table["coordinates"]}
        self._speeds = {name: sp.Symbol(f"dot({name})", real=True) for name in self._symbols}
        self._constants = {p["name"]: sp.Symbol(p["name"], real=True) for p in table.get("parameters", [])}
        self._time = sp.Symbol("t", real=True)
        known = {**self._symbols, **self._constants, "t": self._time}
        stated = table.get("stated", {}).get("map", {})
        texts = {**{name: name for name in self._symbols}, **stated}
        self._map = {name: parse(text, known, source=f"stated.map.{name}") for name, text in texts.items()}

    def names(self, constraint: Toml) -> list[str]:
        """Return the literature's coordinates that a constraint says it speaks of, else those that occur in it."""
        if "coordinates" in constraint:
            return list(constraint["coordinates"])
        texts = f"{constraint['form']} {constraint.get('integral', '')}"
        return [name for name in self._map if re.search(rf"(?<!\w){re.escape(name)}(?!\w)", texts)]

    def foreign(self, names: list[str]) -> list[str]:
        """Return those of the names that are no coordinates of T and V."""
        return [name for name in names if name != "t" and name not in self._symbols]

    def refuse_false_integral(self, constraint: Toml, names: list[str], where: str) -> None:
        """Refuse an integral whose differential is not proportional to the form, with a minor that does not vanish."""
        speeds = {name: sp.Dummy(f"dot({name})", real=True) for name in self._mapped(names, where)}
        known = {**self._symbols, **self._own}
        form = sp.expand(_difference(constraint["form"], known, speeds, f"{where}.form"))
        integral = parse(constraint["integral"], known, source=f"{where}.integral")
        if not form.free_symbols & set(speeds.values()):
            raise InvalidInputError(f"{where}.integral: the form holds no velocity, so that it is its own integral")
        variables = [*((speeds[n], self._symbols[n]) for n in speeds), (None, self._time)]
        rest = form.subs(dict.fromkeys(speeds.values(), 0))
        a = [rest if speed is None else form.coeff(speed, 1) for speed, _ in variables]
        F = [sp.diff(integral, x) for _, x in variables]
        others = [sp.diff(integral, q) for n, q in self._symbols.items() if n not in speeds]
        minors = [*others, *(a[i] * F[j] - a[j] * F[i] for i in range(len(a)) for j in range(i))]
        residual = next((m for m in minors if not isinstance(is_zero(m), Zero)), None)
        if residual is None and any(not isinstance(is_zero(f), Zero) for f in F):
            return
        fault = f"{str(residual)[:80]} is not zero" if residual is not None else "it does not vary"
        raise InvalidInputError(
            f"{where}.integral: its differential is not proportional to the form, since {fault}; leave the integral "
            "out to have it found, or correct it"
        )

    def rate(self, text: str, names: list[str], source: str) -> sp.Expr:
        """Return the time derivative of a function of the literature's coordinates ``names`` and of t."""
        mapped = {name: self._map[name] for name in self._mapped(names, source)}
        return self._derived(parse(text, mapped | self._own, source=source))

    def form(self, text: str, names: list[str], source: str) -> sp.Expr:
        """Return a form in the literature's coordinates ``names`` and their velocities, in q, dot(q) and t."""
        mapped = self._mapped(names, source)
        velocities = {name: sp.Dummy(f"dot({name})", real=True) for name in mapped}
        found = _difference(text, {n: self._map[n] for n in mapped} | self._own, velocities, source)
        return sp.expand(found.xreplace({velocities[name]: self._derived(self._map[name]) for name in mapped}))

    @property
    def _own(self) -> dict[str, sp.Expr]:
        return {**self._constants, "t": self._time}

    def _mapped(self, names: list[str], source: str) -> list[str]:
        wanted = [name for name in names if name != "t"]
        for name in wanted:
            if name not in self._map:
                raise InvalidInputError(f"{source}: T and V know no {name}; {_CURE.format(f'{name} is')}")
        return wanted

    def _derived(self, f: sp.Expr) -> sp.Expr:
        moving = sp.Add(*(sp.diff(f, q) * self._speeds[name] for name, q in self._symbols.items()))
        return sp.expand(sp.diff(f, self._time) + moving)


def _difference(text: str, known: Mapping[str, sp.Expr], velocities: Mapping[str, sp.Symbol], source: str) -> sp.Expr:
    """Return the left side of an equation minus the right one, which is 0 where it is left out."""
    sides = text.split("=")
    if len(sides) > 2:
        raise InvalidInputError(f'{source}: one equation is needed, such as "x**2 + y**2 = l**2"')
    left, *right = [parse(side, known, velocities=velocities, source=source) for side in sides]
    return left - sp.Add(*right)
