"""Constraints of an entry with T and V: each must hold in the entry's own coordinates, for nothing eliminates it.

The literature's coordinates are x = f(q, t) by the table ``[stated] map``. A form Σ aᵢ(x, t) dot(xᵢ) + a(x, t) is put
into q and dot(q) by the chain rule, and has to vanish identically; so has the rate of its integral.
"""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from hjsolve.catalog.toml_file import Toml
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import parse
from hjsolve.separation.zero_test.zero_test import Zero, is_zero

_CURE = "choose coordinates in which it holds, and say in [stated] map what {} in them"


def constraint_faults(table: Toml) -> Iterator[str]:
    """Yield a fault for every constraint that T and V do not obey, one line each.

    Args:
        table: of an entry, its schema checked.
    """
    given = table.get("constraint", [])
    if not given or "kinetic" not in table:
        return
    try:
        entry = _Coordinates(table)
    except InvalidInputError as error:
        yield " ".join(str(error).split())
        return
    for number, constraint in enumerate(given, start=1):
        where, names = f"constraint[{number}]", list(constraint["coordinates"])
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

    def rate(self, text: str, names: list[str], source: str) -> sp.Expr:
        """Return the time derivative of a function of the literature's coordinates ``names`` and of t."""
        mapped = {name: self._map[name] for name in self._mapped(names, source)}
        return self._derived(parse(text, mapped | self._own, source=source))

    def form(self, text: str, names: list[str], source: str) -> sp.Expr:
        """Return a form in the literature's coordinates ``names`` and their velocities, in q, dot(q) and t."""
        mapped = self._mapped(names, source)
        velocities = {name: sp.Dummy(f"dot({name})", real=True) for name in mapped}
        found = parse(text, {n: self._map[n] for n in mapped} | self._own, velocities=velocities, source=source)
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


__all__ = ["constraint_faults"]
