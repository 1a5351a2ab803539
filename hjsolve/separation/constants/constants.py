"""The constants of the motion as functions of coordinates and momenta, with the names a physicist gives them."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.algebra.field import Element
from hjsolve.algebra.readable import printed_length, shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.coordinates_and_parameters import free_name
from hjsolve.mechanics.energy_shell import Shell, domain_bounds
from hjsolve.mechanics.system import Coordinate, System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.precision import mp
from hjsolve.separation.constants.known_integrals import Naming
from hjsolve.separation.forms.stackel import Matrix
from hjsolve.separation.verdicts import Constant
from hjsolve.separation.zero_test.interval_evaluation import Region

_PLACES = 4


def constants_of(shell: Shell, reader: Reader, matrix: Matrix | None) -> dict[str, Constant]:
    """E, then the separation constants α₂ …, then the ignorable momenta; by name, in this order.

    Args:
        shell: the shell H = E in essential coordinates.
        reader: of its field.
        matrix: the Stäckel Φ and ψ as elements; None where the shell does not separate or has one coordinate.
    """
    system = shell.system
    squares = (g * X for g, X in zip(shell.inverse_metric, shell.momentum_terms, strict=True))
    found = [Constant(str(shell.energy), shell.energy, sp.Add(*squares, shell.potential), _meaning_of_energy(system))]
    if matrix is not None and len(shell.coordinates) > 1:
        found += _separation_constants(shell, reader, matrix)
    for c in shell.ignorable:
        kind = "angular momentum" if c.domain.kind == "angle" else "momentum"
        if (sign := _sign_of_time(shell, c)) != 0:
            kind = "energy" if sign > 0 else "minus the energy"
        words = f"{kind} that belongs to {c.name}, which T and V do not contain"
        found.append(Constant(str(c.momentum), c.momentum, c.momentum, words))
    return {c.name: c for c in found}


def _meaning_of_energy(system: System) -> str:
    """Return what H is: the energy, Jacobi's integral, or the constant square of the velocity along a geodesic."""
    if system.signature == "indefinite" and system.potential == 0 and not any(linear_terms(system)):
        return "T, half the square of the velocity by this metric; not an energy"
    if kinetic_rest(system) != 0:
        return "Jacobi's integral T2 - T0 + V"
    return "energy T2 + V" if any(linear_terms(system)) else "energy T + V"


def _sign_of_time(shell: Shell, coordinate: Coordinate) -> int:
    """Return the sign of the metric along a coordinate that is the one time of a geodesic's metric somewhere.

    0 where none is.

    One of the metric's n > 2 signs, as a number at places of the domain, differs from all others: it is that of time.
    """
    system = shell.system
    angle, n = coordinate.domain.kind == "angle", len(system.coordinates)
    if system.signature != "indefinite" or system.potential != 0 or angle or n < 3 or any(linear_terms(system)):
        return 0
    mass, own = mass_matrix(system), system.coordinates.index(coordinate)
    region = Region(domain_bounds(system.coordinates), dict(system.defaults))
    for _, point in zip(range(_PLACES), region.points(sp.Tuple(*mass), seed=3)):
        numbers = mp.matrix([[mp.mpmathify(sp.N(mass[i, j].xreplace(point), 20)) for j in range(n)] for i in range(n)])
        if any(mp.im(number) != 0 for number in numbers):
            continue  # the root of a parameter that is negative here: no metric
        signs = [1 if value > 0 else -1 for value in mp.eigsy(numbers, eigvals_only=True)]
        lonely = -1 if signs.count(-1) == 1 else 1 if signs.count(1) == 1 else 0
        if lonely and numbers[own, own] * lonely > 0:
            return lonely
    return 0


def _separation_constants(shell: Shell, reader: Reader, matrix: Matrix) -> list[Constant]:
    """α = Φ⁻¹(½P² + ψ), from Stäckel's separated equations (Greenwood (5-142))."""
    inverted = inverse_stackel_matrix(reader, matrix.rows, [reader.element(g) for g in shell.inverse_metric])
    separated = [X + shortest_form(reader, ψ) for X, ψ in zip(shell.momentum_terms, matrix.column, strict=True)]
    taken = set(shell.system.symbols)
    meanings = [""] * len(inverted) if shell.null else Naming(shell, reader)(inverted[1:], matrix.column)
    names = [c.name for c in shell.coordinates]
    found = []
    for j in range(1, len(names)):
        holds = [name for name, row in zip(names, matrix.rows) if not row[j].is_zero]
        name = free_name(f"alpha_{j + 1}", taken)
        text = f"separation constant shared by {', '.join(holds)}"
        if known := meanings[j - 1]:
            text = f"{text}: {known}"
        weights = [shortest_form(reader, x) for x in inverted[j]]
        expression = sp.Add(*(w * square for w, square in zip(weights, separated)))
        found.append(Constant(name, sp.Symbol(name, real=True), expression, text))
    return found


def inverse_stackel_matrix(
    reader: Reader, rows: Sequence[Sequence[Element]], metric: Sequence[Element]
) -> list[list[Element]]:
    """Φ⁻¹ by cofactors; its first row is the metric, so 1/det Φ is gⁱⁱ over the cofactor of Φᵢ₁ and stays factored.

    Elimination would divide by pivots that cancel in the end, and multiply out what does not.

    Args:
        reader: reader of the field.
        rows: Φ, regular.
        metric: gⁱⁱ, with cᵀΦ = (1, 0, …, 0).
    """
    field, n = reader.field, range(len(rows))
    known: dict[tuple[tuple[int, ...], tuple[int, ...]], Element] = {}

    def minor(left: tuple[int, ...], columns: tuple[int, ...]) -> Element:
        if not left:
            return field.one
        if (left, columns) not in known:
            first, *rest = left
            terms = (
                rows[first][j] * (-1) ** k * minor(tuple(rest), (*columns[:k], *columns[k + 1 :]))
                for k, j in enumerate(columns)
                if not rows[first][j].is_zero
            )
            known[left, columns] = field.cancelled(field.total(terms))
        return known[left, columns]

    def cofactor(i: int, j: int) -> Element:
        return minor(tuple(k for k in n if k != i), tuple(k for k in n if k != j)) * (-1) ** (i + j)

    regular = [i for i in n if not cofactor(i, 0).is_zero]
    pivot = min(regular, key=lambda i: printed_length(cofactor(i, 0)) + printed_length(metric[i]))
    fraction = metric[pivot] / cofactor(pivot, 0)
    return [[field.cancelled(fraction * cofactor(i, j)) for i in n] for j in n]
