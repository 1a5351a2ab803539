"""Write the ``[[reference]]`` tables of catalog/systems/*.toml anew.

    python -m tests.reference.regenerate [id …]

Periods, actions, frequencies and turning points come from the closed forms; states from Taylor integration of
Hamilton's equations, derived here from T and V with sympy alone. Each file keeps what is above the marker line.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import sympy
from mpmath import mp, mpf

from tests.reference import mechanics
from tests.reference.closed_forms import Values
from tests.reference.forms import THOROUGH, form
from tests.reference.mechanics import CATALOG, number
from tests.reference.taylor import Flow

MARKER = "# Reference values below this line are written by tests/reference/regenerate.py; see catalog/README.md.\n"
DIGITS = 40
TAYLOR = "Taylor series of Hamilton's equations, local error 1e-55"
FRACTION = mpf("0.03")
"""A time is passed over when a coordinate or momentum is smaller than this fraction of its size: a relative test of a
number near its own zero would only test rounding."""


@dataclass(frozen=True)
class Motion:
    """One catalog motion as numbers; everything derived from T and V by sympy, nothing by hjsolve."""

    entry: str
    name: str
    names: tuple[str, ...]
    angles: tuple[str, ...]
    parameters: dict[str, mpf]
    q: dict[str, mpf]
    p: dict[str, mpf]
    hamiltonian: sympy.Expr

    def flow(self) -> Flow:
        """A fresh Taylor integration from t = 0."""
        q, p = [sympy.Symbol(n) for n in self.names], [sympy.Symbol(f"p_{n}") for n in self.names]
        values = {sympy.Symbol(n): value for n, value in self.parameters.items()}
        return Flow(self.hamiltonian, q, p, values, [*self.q.values(), *self.p.values()])

    def closed_forms(self) -> Values:
        """The closed-form quantities of this motion."""
        return form(self.entry)(self.parameters, self.q, self.p)


def motions(entry: str) -> Iterator[Motion]:
    """Every motion of one entry, ``default`` (the table ``initial``) first."""
    table = mechanics.table(entry)
    names = tuple(c["name"] for c in table["coordinates"])
    kinetic, _ = mechanics.kinetic_and_potential(entry)
    for name, data in {"default": table["initial"], **table.get("motions", {})}.items():
        parameters = {par["name"]: number(par["value"]) for par in table.get("parameters", [])}
        parameters |= {n: number(text) for n, text in data.get("parameters", {}).items()}
        given = "p" if "p" in data else "velocity"
        q, v = ({n: number(data[key][n]) for n in names} for key in ("q", given))
        point = {sympy.Symbol(n): value for n, value in (q | parameters).items()}
        point |= {sympy.Symbol(f"v_{n}"): value for n, value in v.items()}
        p = v
        if given == "velocity":
            p = {n: mp.mpf(sympy.N(kinetic.diff(sympy.Symbol(f"v_{n}")).subs(point), mp.dps)) for n in names}
        yield Motion(
            entry,
            name,
            names,
            tuple(c["name"] for c in table["coordinates"] if c["domain"] == "angle"),
            parameters,
            q,
            p,
            mechanics.hamiltonian(entry),
        )


def principal(angle: mpf) -> mpf:
    """The value in (−π, π]."""
    return angle - 2 * mp.pi * mp.ceil((angle - mp.pi) / (2 * mp.pi))


def states(motion: Motion, closed: Values) -> Iterator[tuple[str, str, mpf]]:
    """(quantity, t, value) at generic times: −0.6, 0.3, 2.9 and (default motion) 50 times the slowest libration.

    Entries without a closed form get one time, in their default motion only.
    """
    if motion.entry not in THOROUGH and motion.name != "default":
        return
    periods = {n: closed[f"period.{n}"][0] for n in motion.names if f"period.{n}" in closed}
    turning = [period for n, period in periods.items() if f"turning_point.{n}.upper" in closed]
    unit = max(turning or periods.values(), default=mp.one)
    fractions = ["-0.6", "0.3", "2.9", "50"] if motion.name == "default" else ["-0.6", "2.9"]
    if motion.entry not in THOROUGH:
        fractions = ["0.7"]
    size = [abs(value) for value in (*motion.q.values(), *motion.p.values())]
    forward, backward = motion.flow(), motion.flow()
    for fraction in fractions:
        flow = backward if fraction.startswith("-") else forward
        t = mp.mpf(mp.nstr(unit * mp.mpf(fraction), 4 if abs(mp.mpf(fraction)) > 10 else 3))
        while True:
            text = mp.nstr(t, 8)
            numbers = flow.at(number(text))
            size = [max(s, abs(value)) for s, value in zip(size, numbers, strict=True)]
            if all(abs(value) > FRACTION * s for value, s in zip(numbers, size, strict=True) if s):
                break
            t += mp.sign(t) * mp.mpf("0.13")
        for n, value in zip(motion.names, numbers[: len(motion.names)], strict=True):
            if abs(value) > mp.mpf("1e-40"):
                yield f"q.{n}", text, principal(value) if n in motion.angles else value
        for n, value in zip(motion.names, numbers[len(motion.names) :], strict=True):
            if abs(value) > mp.mpf("1e-40"):
                yield f"p.{n}", text, value


def block(quantity: str, at: str, value: mpf, how: str) -> str:
    """One [[reference]] table."""
    text = mp.nstr(value, DIGITS, strip_zeros=True)
    return f'\n[[reference]]\nquantity = "{quantity}"\nat = {{{at}}}\nvalue = "{text}"\nhow = "{how}"\n'


def tables(entry: str) -> str:
    """All [[reference]] tables of one entry."""
    text = ""
    for motion in motions(entry):
        closed = motion.closed_forms()
        for quantity, (value, how) in closed.items():
            text += block(quantity, f'motion = "{motion.name}"', value, how)
        for quantity, t, value in states(motion, closed):
            text += block(quantity, f'motion = "{motion.name}", t = "{t}"', value, TAYLOR)
    return text


def main(entries: list[str]) -> None:
    """Rewrite the reference tables of the entries named, or of all."""
    mp.dps = 70
    for entry in entries or sorted(path.stem for path in CATALOG.glob("*.toml")):
        path = CATALOG / f"{entry}.toml"
        head = path.read_text(encoding="utf-8").split(MARKER)[0].rstrip("\n") + "\n\n"
        path.write_text(head + MARKER + tables(entry), encoding="utf-8")
        sys.stdout.write(f"{entry}: {path.read_text(encoding='utf-8').count('[[reference]]')} values\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
