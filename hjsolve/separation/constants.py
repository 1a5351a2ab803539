"""The constants of the motion as functions of coordinates and momenta, with the names a physicist gives them."""

from __future__ import annotations

import sympy as sp

from ..algebra.field import Element
from ..algebra.readable import readable
from ..algebra.reader import Reader
from ..shell import Shell
from ..system import kinetic_rest, linear_terms
from .known_integrals import Naming
from .stackel import Matrix
from .verdicts import Constant


def constants_of(shell: Shell, reader: Reader, matrix: Matrix | None) -> dict[str, Constant]:
    """E, then the separation constants α₂ …, then the ignorable momenta; by name, in this order."""
    system = shell.system
    plain = not any(linear_terms(system)) and kinetic_rest(system) == 0
    energy = "energy T + V" if plain else "Jacobi's integral T2 - T0 + V"
    squares = (g * (c.momentum + a) ** 2 / 2 for g, c, a in zip(shell.inverse_metric, shell.coordinates, shell.shift))
    found = [Constant(str(shell.energy), shell.energy, sp.Add(*squares, shell.potential), energy)]
    if matrix is not None and len(shell.coordinates) > 1:
        found += _separation_constants(shell, reader, matrix)
    for c in shell.ignorable:
        kind = "angular momentum" if c.domain.kind == "angle" else "momentum"
        found.append(
            Constant(
                str(c.momentum), c.momentum, c.momentum, f"{kind} that belongs to {c.name}, which T and V do not hold"
            )
        )
    return {c.name: c for c in found}


def _separation_constants(shell: Shell, reader: Reader, matrix: Matrix) -> list[Constant]:
    """α = Φ⁻¹(½P² + ψ), from Stäckel's separated equations (Greenwood (5-142))."""
    inverse = _inverse(reader, matrix.rows)
    separated = []
    for c, a, ψ in zip(shell.coordinates, shell.shift, matrix.column):
        separated.append((c.momentum + a) ** 2 / 2 + readable(reader, ψ))
    taken = set(shell.system.symbols)
    meanings = Naming(shell, reader)(inverse[1:], matrix.column)
    names = [c.name for c in shell.coordinates]
    found = []
    for j in range(1, len(names)):
        holds = [name for name, row in zip(names, matrix.rows) if not row[j].is_zero]
        name = f"alpha_{j + 1}"
        while name in taken:
            name += "_"
        text = f"separation constant shared by {', '.join(holds)}"
        if known := meanings[j - 1]:
            text = f"{text}: {known}"
        weights = [readable(reader, x) for x in inverse[j]]
        expression = sp.Add(*(w * square for w, square in zip(weights, separated)))
        found.append(Constant(name, sp.Symbol(name, real=True), expression, text))
    return found


def _inverse(reader: Reader, rows: list[list[Element]]) -> list[list[Element]]:
    """Φ⁻¹ by Gauss–Jordan elimination that starts with the rows that hold least.

    A triangular Φ is solved from below.
    """
    field, n = reader.field, len(rows)
    work = [[*row, *(field.coerce(int(i == k)) for k in range(n))] for i, row in enumerate(rows)]
    left: list[int] = list(range(n))
    place: dict[int, int] = {}
    for _ in range(n):
        r = min(left, key=lambda i: sum(not x.is_zero for x in work[i][:n]))
        k = next(k for k in reversed(range(n)) if not work[r][k].is_zero and k not in place)
        left.remove(r)
        place[k] = r
        lead = work[r][k]
        work[r] = [field.cancelled(x / lead) for x in work[r]]
        for other in range(n):
            if other != r and not (c := work[other][k]).is_zero:
                work[other] = [field.cancelled(x - c * y) for x, y in zip(work[other], work[r])]
    return [work[place[k]][n:] for k in range(n)]
