r"""The matrix between Jacobi's constants (β, α) and the state (q, p): the generating function W differentiated twice.

W(q, α) makes (β, α) ↦ (q, p) canonical, and along a motion β and α are constants (β of the energy but for t − t₀), so

    ∂(q, p)(t)/∂(q, p)(t₀) = D(t) D(t₀)⁻¹,   D = ∂(q, p)/∂(β, α),   D⁻¹ = −𝕁 Dᵀ 𝕁:

symplectic by its form, at any t. D is found without dividing by p: q_i and P_i are functions of a phase χ_i and of α,
and the phases are those for which Jacobi's equations hold,

    Σ_i (∂G_j/∂χ_i dχ_i + (G_j)_k dα_k) + dq_j = dβ_j          (dq_j of an ignorable coordinate only).

A coordinate at rest, F_i(q⁰(α); α) = 0 with F_i′ = 0, holds the others to α on which dF_i = 0: α = α(a) with fewer a,
and β_a = β·∂α/∂a. In place of the missing pair stand x = q_i − q⁰(α) and y = p_i, which turn with √(−F″/2)
(``at_rest``); they are canonical, and the motion of a adds ½ τ_i (max F_i)_jk to the second derivatives of W and
−y q⁰_a to β_a.

What the shift p = P − A(q; c, λ) of a momentum adds to derivatives: A = ∂χ/∂q, and −∂χ/∂c in the law of c.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.number_types import Context, Counts, Mpf, Numbers, Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import InvalidInputError
from hjsolve.motion.derivatives.along_branch import OpenVariations
from hjsolve.motion.derivatives.along_cycle import CycleVariations
from hjsolve.motion.derivatives.at_rest import RestVariations
from hjsolve.motion.derivatives.bounded import Bounded, converted, inverse, stacked, zeros
from hjsolve.motion.derivatives.formulas import VariedSymbols
from hjsolve.motion.derivatives.slopes import Slopes
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.formulas_at_places import tape_of
from hjsolve.motion.initial_data import Initial
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.solution.quadratures import Solution

CoordinateVariations = CycleVariations | OpenVariations | RestVariations


@dataclass(frozen=True, eq=False)
class StateByConstants:
    """D at one time.

    Attributes:
        state: ∂(q, p)/∂(B, x, a, y), shape (2n, 2n): all q, then all p, in the system's order.
        by_parameters: the same by the parameters, at constant (B, x, a, y), shape (2n, parameters).
    """

    state: Bounded
    by_parameters: Bounded


@dataclass(frozen=True, eq=False)
class ConstantsToState:
    """What is needed to write D down at any time.

    Attributes:
        source: the motion, in more digits than are asked.
        variables: the constants, and parameters where they are varied.
        parts: the separated coordinates with their derivatives.
        free: positions of the constants that are independent.
        tangent: ∂(constants, parameters)/∂(free constants, parameters).
        shift: derivatives of the shift of momenta; None where there is none.
        context: of the numbers.
    """

    source: SeparatedMotion
    variables: VariedSymbols
    parts: tuple[CoordinateVariations, ...]
    free: tuple[int, ...]
    tangent: Bounded
    shift: Tape | None
    context: Context

    @property
    def resting(self) -> list[int]:
        """Positions of the separated coordinates at rest."""
        return [i for i, part in enumerate(self.parts) if isinstance(part, RestVariations)]

    @property
    def freedoms(self) -> int:
        """Half the size of the matrix."""
        return len(self.source.solution.system.coordinates)

    def frames(self, χ: Sequence[Any], whole: Sequence[Any], errors: Sequence[Any]) -> list[StateByConstants]:
        """Return D at m times.

        Args:
            χ: phases, one array a separated coordinate, shape (m,).
            whole: turns beside them.
            errors: bounds on the errors of χ.
        """
        count = len(χ[0]) if len(χ) else 0
        if not count:
            return []
        slopes = [
            None if isinstance(part, RestVariations) else part.slopes(c, n, e)
            for part, c, n, e in zip(self.parts, χ, whole, errors, strict=True)
        ]
        return [self._frame(slopes, χ, whole, errors, m) for m in range(count)]

    def first_frame(self) -> StateByConstants:
        """Return D at t₀."""
        start = [np.array([self.context.convert(p.coordinate_motion.start)], dtype=object) for p in self.parts]
        none = [np.zeros(1, dtype=int) for _ in self.parts]
        small = [np.array([10.0**-self.source.digits]) for _ in self.parts]
        return self.frames(start, none, small)[0]

    def variations(self, columns: int) -> Bounded:
        """Return how constants and parameters change with (B, x, a, y) and the parameters.

        Args:
            columns: how many these are.
        """
        n, nf = self.freedoms, len(self.free)
        Z = zeros((self.variables.count, columns), self.context)
        Z.value[:, n : n + nf] = self.tangent.value[:, :nf]
        Z.value[:, 2 * n :] = self.tangent.value[:, nf:]
        return Z

    def _frame(
        self, slopes: Sequence[Slopes | None], χ: Sequence[Numbers], whole: Sequence[Counts],
        errors: Sequence[Numbers], m: int,
    ) -> StateByConstants:  # fmt: skip
        solution, c = self.source.solution, self.context
        names, n = list(solution.coordinates), self.freedoms
        nf, rest = len(self.free), self.resting
        columns = 2 * n + len(self.variables.parameters)
        Z = self.variations(columns)
        law = zeros((nf, columns), c)
        for f in range(nf):
            law.value[f, f] = c.mpf(1)
        dq: list[Bounded | None] = [None] * len(names)
        dP: list[Bounded | None] = [None] * len(names)
        T = self.tangent[: len(self.variables.constants), :nf].transposed
        for r, i in enumerate(rest):
            part = self.parts[i]
            x, y, τ = self._beside_rest(part, (χ[i][m], int(whole[i][m]), float(errors[i][m])), (nf + r, n + nf + r))
            moved = Bounded.exact(np.array(part.place_by(), dtype=object))  # type: ignore[union-attr]
            dq[i], dP[i] = x + moved @ Z, y
            # W of the coordinate at rest is ½ τ max F next to what is linear: by a twice, ½ τ (max F)_jk
            law = law - Bounded(T.value @ self._tops(part) @ Z.value, np.zeros(law.error.shape)) * _scaled(τ, law)
            # the constants move q⁰, the place of rest, and y q⁰_a is what a translation by it adds to β_a
            law = law + outer(T @ moved[: T.value.shape[1]], y)
        rates = []
        for own in slopes:
            if own is not None:
                # dβ − (G_j)_k dα_k, what Jacobi's equations leave for the phases
                law = law - T @ own.integrals[:, :, m] @ Z
                rates.append(T @ own.rates[:, m])
        moving = [i for i in range(len(names)) if i not in rest]
        separate, ignored = self._laws()
        if moving:
            G = stacked(rates, 1)
            # as many equations as phases: those of ignorable momenta only say where the ignorable coordinates are
            dχ = _solved(G[separate], law[separate], c)
            law = law - G @ dχ
            for row, i in enumerate(moving):
                own = slopes[i]
                dq[i] = outer(own.q[m], dχ[row]) + own.q_by[:, m] @ Z  # type: ignore[union-attr]
                dP[i] = outer(own.p[m], dχ[row]) + own.p_by[:, m] @ Z  # type: ignore[union-attr]
        return self._in_order(dq, dP, law, ignored, Z, self._places(χ, m))

    def _beside_rest(
        self, part: CoordinateVariations, phase: tuple[Mpf, int, float], own: tuple[int, int]
    ) -> tuple[Bounded, Bounded, Bounded]:
        """X and y of a coordinate at rest as rows over all columns, and τ."""
        c, (χ, turns, error) = self.context, phase
        gone = c.convert(χ) + 2 * c.pi * turns - c.convert(part.coordinate_motion.start)
        τ, now = part.flow(gone)  # type: ignore[union-attr]
        # the error of the phase counts with the rate of the flow, a difference over 2⁻⁶⁰ in numbers of many more bits
        _, later = part.flow(gone + c.mpf(2.0**-60))  # type: ignore[union-attr]
        columns = 2 * self.freedoms + len(self.variables.parameters)
        rows = []
        for k in range(2):
            row = zeros((columns,), c)
            for l in range(2):
                row.value[own[l]] = now[k][l]
                row.error[own[l]] = 2 * error * abs(float(later[k][l] - now[k][l])) * 2.0**60
            rows.append(row)
        return rows[0], rows[1], Bounded(np.array(τ, dtype=object), np.array(2 * error * (abs(float(τ)) + 1)))

    def _tops(self, part: Any) -> NDArray[Any]:
        """½ (max F)_jb."""
        n, count = len(self.variables.constants), self.variables.count
        return np.array([[part.top(j, b) / 2 for b in range(count)] for j in range(n)], dtype=object)

    def _laws(self) -> tuple[list[int], dict[str, int]]:
        """Rows of Jacobi's equations that belong to separation constants; ignorable coordinate → its row."""
        solution = self.source.solution
        momenta = {c.momentum.name: c.name for c in solution.system.coordinates if c.name not in solution.coordinates}
        names = [self.variables.constants[j] for j in self.free]
        return [f for f, name in enumerate(names) if name not in momenta], {
            momenta[name]: f for f, name in enumerate(names) if name in momenta
        }

    def _places(self, χ: Sequence[Numbers], m: int) -> list[Mpf]:
        return [
            self.context.convert(part.coordinate_motion.place(converted(c[m : m + 1], self.context))[0][0])
            for part, c in zip(self.parts, χ, strict=True)
        ]

    def _in_order(
        self, dq: list[Bounded | None], dP: list[Bounded | None], law: Bounded, ignored: dict[str, int], Z: Bounded,
        places: list[Mpf],
    ) -> StateByConstants:  # fmt: skip
        """Rows of the state, with what a shift of momenta adds."""
        solution, n = self.source.solution, self.freedoms
        names = list(solution.coordinates)
        others = [c for c in solution.system.coordinates if c.name not in names]
        shift = None
        if self.shift is not None:
            about = solution, self.source.initial, self.variables.count
            shift = shift_slopes(self.shift, *about, places, self.context)
        q = {name: row for name, row in zip(names, dq, strict=True) if row is not None}
        p = {name: row for name, row in zip(names, dP, strict=True) if row is not None}
        for k, coordinate in enumerate(others):
            q[coordinate.name] = law[ignored[coordinate.name]]
            p[coordinate.name] = Z[self.variables.constants.index(coordinate.momentum.name)]
            if shift is not None:
                places_moved = stacked([q[name] for name in names])
                q[coordinate.name] = q[coordinate.name] + shift.law_by_place[k] @ places_moved + shift.law_by[k] @ Z
        if shift is not None:
            # p = P − A(q; c, λ)
            moved = stacked([q[name] for name in names])
            for i, name in enumerate(names):
                p[name] = p[name] - shift.by_place[i] @ moved - shift.by[i] @ Z
        order = [c.name for c in solution.system.coordinates]
        whole = stacked([*(q[name] for name in order), *(p[name] for name in order)])
        return StateByConstants(whole[:, : 2 * n], whole[:, 2 * n :])


def symplectic_inverse(D: Bounded) -> Bounded:
    """Return −𝕁 Dᵀ 𝕁, the inverse of a symplectic matrix.

    Args:
        D: shape (2n, 2n).
    """
    n = len(D.value) // 2
    a, b, c, d = D[:n, :n], D[:n, n:], D[n:, :n], D[n:, n:]
    upper = np.concatenate([d.transposed.value, -b.transposed.value], axis=1)
    lower = np.concatenate([-c.transposed.value, a.transposed.value], axis=1)
    upper_error = np.concatenate([d.transposed.error, b.transposed.error], axis=1)
    lower_error = np.concatenate([c.transposed.error, a.transposed.error], axis=1)
    return Bounded(np.concatenate([upper, lower]), np.concatenate([upper_error, lower_error]))


def canonical_map(
    source: SeparatedMotion, variables: VariedSymbols, parts: Sequence[CoordinateVariations]
) -> ConstantsToState:
    """Make ready what D needs: which constants are independent of each other next to coordinates at rest.

    Args:
        source: the motion, in more digits than are asked.
        parts: the separated coordinates with their derivatives.

    Raises:
        InvalidInputError: a coordinate rests at a zero of p² of an order above two.
    """
    context = multiprecision(max(part.context.prec for part in parts))
    n, m = len(variables.constants), len(variables.parameters)
    rest = [part for part in parts if isinstance(part, RestVariations)]
    for part, name in zip(parts, source.solution.coordinates, strict=True):
        if isinstance(part, RestVariations) and not part.regular:
            raise InvalidInputError(
                f"derivatives: {name} rests at a multiple zero of p², where the motion next to it is not linear; "
                "start it at another place"
            )
    momenta = {c.momentum.name for c in source.solution.system.coordinates if c.name not in source.solution.coordinates}
    candidates = [j for j, name in enumerate(variables.constants) if name not in momenta]
    # dF_i = 0 ties one constant to the others for each coordinate at rest; the largest slopes are divided by
    slaved = _pivots([[part.at.by[j] for j in candidates] for part in rest])
    bound = [candidates[k] for k in slaved]
    free = tuple(j for j in range(n) if j not in bound)
    T = np.full((n + m, len(free) + m), context.mpf(0), dtype=object)
    for f, j in enumerate(free):
        T[j, f] = context.mpf(1)
    for b in range(m):
        T[n + b, len(free) + b] = context.mpf(1)
    if rest:
        own = Bounded.exact(np.array([[context.convert(part.at.by[j]) for j in bound] for part in rest], dtype=object))
        others = np.array([[context.convert(part.at.by[b]) for b in range(n + m)] for part in rest], dtype=object)
        # implicit functions: ∂α_bound/∂a = −(∂F/∂α_bound)⁻¹ ∂F/∂a
        T[bound, :] = -(inverse(own, context).value @ others @ T)
    shift = shift_tape(source.solution, variables)
    return ConstantsToState(source, variables, tuple(parts), free, Bounded.exact(T), shift, context)


def _pivots(rows: list[list[Mpf]]) -> list[int]:
    """Columns to solve for, by elimination with the largest pivots."""
    rows, chosen = [list(row) for row in rows], []
    for k in range(len(rows)):
        row = rows[k]
        pivot = max((j for j in range(len(row)) if j not in chosen), key=lambda j: abs(row[j]))
        chosen.append(pivot)
        for other in rows[k + 1 :]:
            ratio = other[pivot] / row[pivot]
            for j in range(len(other)):
                other[j] -= ratio * row[j]
    return chosen


def _solved(G: Bounded, right: Bounded, context: Context) -> Bounded:
    """G⁻¹ times the right sides, errors included."""
    return inverse(G, context) @ right


def outer(column: Bounded, row: Bounded) -> Bounded:
    """Return a number, or a column, times a row.

    Args:
        column, row: shapes () or (k,), and (m,).
    """
    return Bounded(
        np.multiply.outer(column.value, row.value),
        np.multiply.outer(column.error, row.size) + np.multiply.outer(column.size, row.error),
    )


def _scaled(number: Bounded, like: Bounded) -> Bounded:
    shape: Reals = like.error
    return Bounded(np.full(shape.shape, number.value[()], dtype=object), np.full(shape.shape, float(number.error)))


@dataclass(frozen=True, eq=False)
class ShiftSlopes:
    """Derivatives of the shift at one place.

    Attributes:
        by_place: ∂A_i/∂q_k, shape (separated, separated).
        by: ∂A_i/∂z_b, shape (separated, variables).
        law_by_place: ∂²χ/∂c_m∂q_k, shape (ignorable, separated).
        law_by: ∂²χ/∂c_m∂z_b, shape (ignorable, variables).
    """

    by_place: Bounded
    by: Bounded
    law_by_place: Bounded
    law_by: Bounded


def shift_slopes(
    tape: Tape, solution: Solution, initial: Initial, count: int, q: list[Mpf], context: Context
) -> ShiftSlopes:
    """Return the derivatives of the shift at a place.

    Args:
        tape: of ``shift_tape``.
        count: how many variables there are.
        q: places of the separated coordinates.
    """
    values = {**initial.values, **{solution.constants[c].symbol: initial.constants[c] for c in solution.constants}}
    numbers = [to_bits(values[s])(context.prec) for s in _known(solution)]
    found = tape.run(Multi(context.prec), [*(context.convert(x) for x in q), *numbers])
    ns = len(solution.coordinates)
    nm = len(solution.system.coordinates) - ns
    parts, position = [], 0
    for shape in ((ns, ns), (ns, count), (nm, ns), (nm, count)):
        size = shape[0] * shape[1]
        parts.append(Bounded.exact(np.array(found[position : position + size], dtype=object).reshape(shape)))
        position += size
    return ShiftSlopes(*parts)


def shift_tape(solution: Solution, variables: VariedSymbols) -> Tape | None:
    """Return the formulas of all derivatives of the shift; None where no momentum is shifted."""
    if all(A == 0 for A in solution.shift.values()):
        return None
    system = solution.system
    q = [system.coordinate(name).symbol for name in solution.coordinates]
    ignorable = [c for c in system.coordinates if c.name not in solution.coordinates]
    A, χ = [solution.shift[name] for name in solution.coordinates], solution.shift_potential
    laws = [sp.diff(χ, c.momentum) for c in ignorable]
    # in the order in which ``shift_slopes`` cuts them apart
    outputs = [sp.diff(a, x) for a in A for x in q] + [sp.diff(a, z) for a in A for z in variables.symbols]
    outputs += [sp.diff(a, c.momentum) for c in ignorable for a in A]
    outputs += [sp.diff(law, z) for law in laws for z in variables.symbols]
    return tape_of(tuple(outputs), (*q, *_known(solution)))


def _known(solution: Solution) -> list[sp.Symbol]:
    return [c.symbol for c in solution.constants.values()] + [p.symbol for p in solution.system.parameters]
