"""Another gauge: axes along which the forces do not change, and T in which these coordinates are ignorable.

    L = ½ ẋᵀM ẋ + aᵀẋ + T₀ − V,      Fᵢⱼ = ∂ᵢaⱼ − ∂ⱼaᵢ,      a → a − ∇Λ changes L by dΛ/dt only.

A shift along d leaves the equations of motion alone where d·∇(V − T₀) = 0 and d·∇F = 0, whatever gauge a is written in.
Shifts d, e with dᵀF e = 0 commute and have a gauge in which a depends on neither: for u along d, ∂ᵤa is closed, so that
∂ᵤa = ∇g, and Λ = ∫ g du takes u out of a. Landau's gauge of a uniform field is the first example (Landau and Lifshitz,
Quantum Mechanics, §112).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mpmath
import sympy as sp

from hjsolve.algebra.integration import antiderivative, closed_form_potential
from hjsolve.algebra.poly import Budget
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.precision import mp

_SAMPLES = 4
"""Places beyond the number of coordinates at which slopes are compared before a shift is proved."""

_DIGITS = 25
"""Digits to which a row is a combination of others; twice as many are computed."""


@dataclass(frozen=True)
class Gauge:
    """Axes and a gauge in which some coordinates are ignorable.

    Attributes:
        system: in u, x = frame · u.
        frame: columns, orthogonal in the sense of M.
        linear: a(u) of T₁ = Σ aₖ u̇ₖ in the new gauge.
        function: Λ(u) with (old) = (new) + ∇Λ.
    """

    system: System
    frame: sp.ImmutableMatrix
    linear: tuple[sp.Expr, ...]
    function: sp.Expr


def find_gauge(system: System, budget: float) -> Gauge | None:
    """Return the gauge in which most coordinates are ignorable; None where no shift leaves the forces alone.

    Args:
        system: all coordinates along the whole line; T with constant masses and terms linear in the velocities.
        budget: seconds for exact arithmetic.
    """
    x, M = [c.symbol for c in system.coordinates], mass_matrix(system)
    if not M.free_symbols.isdisjoint(x):
        return None
    a, V = linear_terms(system), system.potential - kinetic_rest(system)
    reader = Reader([*a, V, *M], domain_bounds(system.coordinates), Budget.seconds(budget))
    F = sp.Matrix(len(x), len(x), lambda i, j: sp.simplify(sp.diff(a[j], x[i]) - sp.diff(a[i], x[j])))
    shifts = _shifts([V, *F], x, reader)
    if not shifts:
        return None
    frame = _axes(shifts, M)
    u = [sp.Symbol(f"_u{k}", real=True) for k in range(len(x))]
    at = dict(zip(x, frame * sp.Matrix(u), strict=True))
    there = [sp.expand(e.xreplace(at)) for e in frame.T * sp.Matrix(a)]
    field = (frame.T * F * frame).applyfunc(lambda e: sp.expand(e.xreplace(at)))
    commuting: list[int] = []
    for k in range(len(shifts)):
        if all(sp.simplify(field[k, other]) == 0 for other in commuting):
            commuting.append(k)
    own = Reader([*there, *field], dict.fromkeys(u, (None, None)), Budget.seconds(budget))
    free = free_of(own, there, u, [u[k] for k in commuting])
    return None if free is None else _gauge(system, frame, M, u, free[0], free[1], V.xreplace(at))


def free_of(
    reader: Reader, linear: Sequence[sp.Expr], u: Sequence[sp.Symbol], ignorable: Sequence[sp.Symbol]
) -> tuple[list[sp.Expr], sp.Expr] | None:
    """Return a(u) in a gauge without some coordinates, and Λ with (old) = (new) + ∇Λ; None where it is not found.

    Args:
        reader: of what depends on u.
        linear: a(u).
        u: all coordinates.
        ignorable: coordinates on which F does not depend, and with F = 0 between them.
    """
    there, Λ = list(linear), sp.S.Zero
    for s in ignorable:
        slopes = [reader.element(sp.diff(e, s)) for e in there]
        part = antiderivative(reader, sp.expand(closed_form_potential(reader, u, slopes)), s)
        if part.has(sp.Integral):
            return None
        there = [shortest_form(reader, reader.element(e - sp.diff(part, x))) for e, x in zip(there, u, strict=True)]
        Λ += part
    return None if any(e.has(s) for e in there for s in ignorable) else (there, sp.expand(Λ))


def field_in(chart: System, transformation: Mapping[sp.Symbol, sp.Expr], system: System, budget: float) -> (
    tuple[System, tuple[sp.Expr, ...], sp.Expr] | None
):  # fmt: skip
    """Return a system with its terms linear in the velocities, in coordinates in which it separates without them.

    Args:
        chart: the system without these terms, in u.
        transformation: x, the given coordinates → expression in u.
        system: in x.
        budget: seconds for exact arithmetic.

    Returns:
        The system in u, aₖ(u) and Λ(u) as in ``Gauge``; None where it depends on a coordinate that was ignorable.
    """
    u, x = [c.symbol for c in chart.coordinates], [c.symbol for c in system.coordinates]
    J = sp.Matrix([transformation[s] for s in x]).jacobian(u)
    a = [sp.simplify(e) for e in J.T * sp.Matrix([e.xreplace(dict(transformation)) for e in linear_terms(system)])]
    F = [sp.simplify(sp.diff(a[j], u[i]) - sp.diff(a[i], u[j])) for i in range(len(u)) for j in range(i)]
    ignorable = [s for s in u if not any(e.has(s) for e in (*mass_matrix(chart), chart.potential, *F))]
    bounds = domain_bounds(chart.coordinates)
    reader = Reader([*a, *F, chart.potential, *mass_matrix(chart)], bounds, Budget.seconds(budget))
    free = free_of(reader, a, u, ignorable) if ignorable else None
    if free is None:
        return None
    T = chart.kinetic + sp.Add(*(e * c.velocity for e, c in zip(free[0], chart.coordinates, strict=True)))
    domains = {c.name: c.domain.written(c.name) for c in chart.coordinates}
    found = System(domains, T, chart.potential, {p.name: p for p in chart.parameters}, title=chart.title)
    return found, tuple(free[0]), free[1]


def _shifts(functions: Sequence[sp.Expr], x: Sequence[sp.Symbol], reader: Reader) -> list[sp.Matrix]:
    """Constant vectors d with d·∇f = 0 for every f, proved."""
    rows = [[sp.diff(f, s) for s in x] for f in functions]
    rows = [row for row in rows if any(e != 0 for e in row)]
    sampled = []
    for m in range(len(x) + _SAMPLES):
        at = {s: sp.Rational(sp.prime(3 * m + k + 4), sp.prime(2 * k + m + 2)) for k, s in enumerate(x)}
        sampled += [[e.subs(at) for e in row] for row in rows]
    if any(e.has(sp.nan, sp.zoo, sp.oo) for row in sampled for e in row):
        return []
    independent, guess = _kernel_in_digits(sampled, len(x))
    kernel = [] if len(independent) == len(x) else [sp.Matrix(d) for d in guess]
    if not _is_kernel(kernel, rows, reader):
        kernel = sp.Matrix(independent).nullspace(simplify=True)
        kernel = [sp.Matrix([sp.simplify(e) for e in d]) for d in kernel]
    return kernel if _is_kernel(kernel, rows, reader) else []


def _is_kernel(kernel: Sequence[sp.Matrix], rows: Sequence[Sequence[sp.Expr]], reader: Reader) -> bool:
    """Return whether every row vanishes along every vector, proved."""
    products = (sp.Add(*(c * e for c, e in zip(d, row, strict=True))) for d in kernel for row in rows)
    return all(reader.element(product).is_zero for product in products)


def _kernel_in_digits(
    rows: Sequence[Sequence[sp.Expr]], width: int
) -> tuple[list[Sequence[sp.Expr]], list[list[sp.Rational]]]:
    """Return rows that span all of them, and fractions that are their kernel to many digits.

    Exact elimination of surds has no end. Rows independent at one value of the letters are independent as formulas.
    Where that value is special the kernel is too large, and where the kernel depends on letters or surds the fractions
    are wrong: its proof fails.
    """
    letters = sorted({s for row in rows for e in row for s in e.free_symbols}, key=str)
    values = {s: sp.Rational(2 * k + 3, 2 * k + 4) for k, s in enumerate(letters)}
    chosen: list[Sequence[sp.Expr]] = []
    reduced: dict[int, list[mpmath.mpf]] = {}
    with mp.workdps(2 * _DIGITS):
        for row in rows:
            left = [mp.mpmathify(sp.N(e.xreplace(values), 2 * _DIGITS)) for e in row]
            size = max(map(abs, left))
            for pivot, other in reduced.items():
                left = [a - left[pivot] * b for a, b in zip(left, other, strict=True)]
            pivot = max(range(width), key=lambda k: abs(left[k]))
            if abs(left[pivot]) <= size * mp.mpf(10) ** -_DIGITS:
                continue
            chosen.append(row)
            left = [e / left[pivot] for e in left]
            reduced = {
                k: [a - other[pivot] * b for a, b in zip(other, left, strict=True)] for k, other in reduced.items()
            }
            reduced[pivot] = left
        free = [k for k in range(width) if k not in reduced]
        kernel = [
            [-_fraction(reduced[k][f]) if k in reduced else sp.Integer(k == f) for k in range(width)] for f in free
        ]
    return chosen, kernel


def _fraction(value: mpmath.mpf) -> sp.Rational:
    """Return the fraction with a small denominator next to a number."""
    return sp.Rational(str(mp.nstr(mp.re(value), 2 * _DIGITS))).limit_denominator(1000)


def _axes(shifts: Sequence[sp.Matrix], M: sp.Matrix) -> sp.ImmutableMatrix:
    """Return the shifts, and what completes them, as columns that are orthogonal in the sense of M."""
    unit = [sp.eye(M.rows)[:, k] for k in range(M.rows)]
    columns: list[sp.Matrix] = []
    for d in [*shifts, *unit]:
        for c in columns:
            d -= c * sp.simplify((c.T * M * d)[0] / (c.T * M * c)[0])
        d = d.applyfunc(sp.simplify)
        if any(e != 0 for e in d):
            columns.append(d)
    return sp.ImmutableMatrix(sp.Matrix.hstack(*columns))


def _gauge(
    system: System, frame: sp.ImmutableMatrix, M: sp.Matrix, u: Sequence[sp.Symbol], linear: Sequence[sp.Expr],
    Λ: sp.Expr, potential: sp.Expr,
) -> Gauge:  # fmt: skip
    """Return the system in u; axes along the given ones keep their names."""
    own = [c.name for c in system.coordinates]
    order, taken = list(range(len(u))), {p.name for p in system.parameters}
    hits = [[i for i in range(len(u)) if frame[i, k] != 0] for k in range(len(u))]
    if all(len(hit) == 1 and frame[hit[0], k] == 1 for k, hit in enumerate(hits)):
        order.sort(key=lambda k: hits[k][0])
        names = own
    else:
        names = [next(n for n in (f"{c}_turned", f"{c}_axis") if n not in taken) for c in own]
    frame = sp.ImmutableMatrix(frame[:, order])
    speeds = [sp.Symbol(f"dot({name})", real=True) for name in names]
    at = {u[k]: sp.Symbol(name, real=True) for k, name in zip(order, names, strict=True)}
    a = [linear[k].xreplace(at) for k in order]
    masses = (frame.T * M * frame).applyfunc(sp.simplify)
    T = sp.Add(*(masses[i, i] * v**2 / 2 + e * v for i, (v, e) in enumerate(zip(speeds, a, strict=True))))
    found = System(
        dict.fromkeys(names, "line"),
        T,
        sp.expand(potential.xreplace(at)),
        {p.name: p for p in system.parameters},
        title=f"{system.title or 'system'} in another gauge",
    )
    symbols = {sp.Symbol(c.name, real=True): c.symbol for c in found.coordinates}
    return Gauge(found, frame, tuple(e.xreplace(symbols) for e in a), sp.expand(Λ.xreplace(at).xreplace(symbols)))
