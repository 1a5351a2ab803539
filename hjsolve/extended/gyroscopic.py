"""Linear gyroscopic systems: separated by a linear symplectic normal form, where no change of coordinates does it.

With constant M, T₁ = Σ G_ij q̇_i q_j and V = ½ qᵀK q the motion is M q̈ + (G − Gᵀ) q̇ + K q = 0 (Greenwood (3-117)), with
the characteristic equation det(M λ² + (G − Gᵀ) λ + K) = 0. In the space of (q, p), ż = J S z with S the Hessian of H.
Where all λ are imaginary and simple, the real and imaginary parts of the eigenvectors, scaled, make a symplectic N:

    z = N (Q, P),   NᵀJN = J,   H = Σ σ_k ω_k (Q_k² + P_k²)/2,   σ_k = ±1.

The modes are oscillators, those with σ = −1 of negative energy: stable by gyroscopic forces although V has no minimum.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Context, Elementwise, Mpc, Mpf, MpfMatrix
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, InvalidSystemError, NotConvergedError
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, hamiltonian, kinetic_rest, linear_terms, mass_matrix, momenta, velocities
from hjsolve.motion.initial_data import complete_numbers, one_of_velocity_and_p, parameter_values, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import Errors, State
from hjsolve.precision import one_at_a_time
from hjsolve.solution.quadratures import solve

LAMBDA = sp.Symbol("lambda")


@dataclass(frozen=True, repr=False)
class LinearModes(Shown):
    """The characteristic exponents of a linear system and, where it is stable, its normal form.

    Attributes:
        system: as posed.
        polynomial: det(M λ² + (G − Gᵀ) λ + K) in the symbol ``lambda``, parameters kept.
        exponents: all λ, ``mpc``, by size of the imaginary part, those with positive real or imaginary part first.
        ratios: for each of ``exponents`` the amplitudes A_i/A_1 by coordinate; empty where A_1 = 0.
        stable: True where all λ are imaginary and simple.
        frequencies: ω_k of the modes, increasing.
        signs: σ_k, the sign of each mode's energy.
        matrix: N as an ``mpmath`` matrix of 2n rows: q then p; None where the system is not stable.
        normal_form: the modes as a system that separates, coordinates ``Q1`` …; None where not stable.
        values: the parameters used, by symbol.
        digits: of all numbers.
    """

    system: System
    polynomial: sp.Expr
    exponents: tuple[Mpf | Mpc, ...]
    ratios: tuple[Mapping[str, Any], ...]
    stable: bool
    frequencies: tuple[Mpf, ...]
    signs: tuple[int, ...]
    matrix: Any
    normal_form: System | None
    values: Mapping[sp.Symbol, sp.Expr]
    digits: int

    @arguments.by_name('motion(q={"q1": 1, "q2": 0}, velocity={"q1": 0, "q2": 0})')
    def motion(
        self,
        *,
        q: Mapping[str, object],
        velocity: Mapping[str, object] | None = None,
        p: Mapping[str, object] | None = None,
    ) -> ModalMotion:
        """Start a motion from initial data of the system as posed.

        Args:
            q: position of every coordinate.
            velocity: of every coordinate, or
            p: its canonical momentum.

        Raises:
            InvalidInputError: the system is not stable, or velocity and p are both given or both missing.
        """
        if self.normal_form is None:
            raise InvalidInputError(
                "modes.motion: the modes do not all oscillate at different frequencies, since some exponent is zero, "
                "repeated or not imaginary; the exponents of this object show which"
            )
        bits = _bits(self.digits)
        z = multiprecision(bits).matrix([to_bits(x)(bits) for x in _canonical(self, q, velocity, p)])
        modal = _inverse(self.matrix) * z
        names = [c.name for c in self.normal_form.coordinates]
        n = len(names)
        data = [{name: number(modal[i + k], source="mode") for i, name in enumerate(names)} for k in (0, n)]
        return ModalMotion(self, solve(self.normal_form).motion(q=data[0], p=data[1], digits=self.digits))


@dataclass(frozen=True, eq=False, repr=False)
class ModalMotion(Shown):
    """A motion expressed in the coordinates as posed.

    Attributes:
        modes: the normal form.
        motion: of the modes, by Hamilton–Jacobi.
    """

    modes: LinearModes
    motion: Motion

    @property
    def kinds(self) -> Mapping[str, str]:
        """The kinds of motion of the modes ``Q1`` …."""
        return self.motion.kinds

    @property
    def constants(self) -> Mapping[str, Estimate]:
        """The constants of the motion of the modes."""
        return self.motion.constants

    def at(self, t: object) -> State:
        """Return the state in the coordinates as posed at a time or at an array of times; as ``Motion.at``.

        q and p are N times those of the modes, and their errors abs(N) times theirs. N is known to far more digits.

        Args:
            t: a time or an array of times.
        """
        state, context = self.motion.at(t), multiprecision(_bits(self.modes.digits))
        rows = [*self.modes.matrix.tolist(), *_speeds(self.modes)]
        modal = [_converted(x, context) for x in (*state.q.values(), *state.p.values())]
        q, p, velocity = self._named([sum(a * x for a, x in zip(row, modal, strict=True)) for row in rows])

        def bounds() -> Errors:
            unit = context.mpf(10) ** (1 - self.modes.digits)
            errors = [_converted(e, context) for e in (*state.error.q.values(), *state.error.p.values())]
            uncertainties = [e + unit * np.abs(x) for e, x in zip(errors, modal, strict=True)]
            sums = [sum(abs(a) * e for a, e in zip(row, uncertainties, strict=True)) for row in rows]
            return Errors(*self._named(sums))

        return State(t, q, p, velocity, {}, state.status, bounds)

    def _named(self, values: list[Mpf]) -> Iterator[dict[str, Mpf]]:
        """Return the values of q, p and velocity by coordinate."""
        names = [c.name for c in self.modes.system.coordinates]
        return (dict(zip(names, values[k * len(names) :], strict=False)) for k in range(3))


def _converted(x: AtTimes, context: Context) -> Elementwise:
    array = np.asarray(x)
    return np.frompyfunc(context.convert, 1, 1)(array) if array.ndim else context.convert(x)


def _speeds(modes: LinearModes) -> list[list[Mpf]]:
    """q̇ = ∂H/∂p as rows of numbers times (Q, P)."""
    z = sp.Matrix([c.symbol for c in modes.system.coordinates] + [c.momentum for c in modes.system.coordinates])
    rates = sp.Matrix(list(velocities(modes.system).values())).jacobian(z).subs(modes.values)
    context = multiprecision(_bits(modes.digits))
    found = context.matrix([[to_bits(x)(context.prec) for x in rates.row(i)] for i in range(rates.rows)]) * modes.matrix
    return [list(row) for row in found.tolist()]


@one_at_a_time
def gyroscopic_modes(
    system: System | str | Path, *, parameters: Mapping[str, object] | None = None, digits: int = 30
) -> LinearModes:
    """Bring a linear system to normal form by a linear symplectic map.

    Args:
        system: constant masses, T₁ bilinear, T₀ and V quadratic in the coordinates; or the id or file of a
            catalog entry.
        parameters: values that differ from the defaults.
        digits: of all numbers.

    Returns:
        The modes, with their frequencies and shapes.

    Raises:
        InvalidSystemError: the system is not linear, or has a constant force.
        MissingValueError: a parameter has no value.
        InvalidInputError: no system at all, or digits out of range.

    Example:
        >>> gyroscopic_modes("gyroscopic-pair").stable
        True

    References:
        Greenwood (1977), (3-117), (3-129), Ex 3-4, P3-10; Arnold, Mathematical Methods, appendix 6.
    """
    system = system_of(system, "gyroscopic_modes")
    refuse_kinks(system.kinks, "gyroscopic_modes")
    digits = arguments.digits(digits)
    M, Γ, K = _matrices(system)
    values = parameter_values(system, parameters or {})
    polynomial = sp.expand((M * LAMBDA**2 + Γ * LAMBDA + K).det())
    bits = _bits(digits)
    squares, simple = _squares(polynomial.subs(values), bits)
    context = multiprecision(bits)
    exponents = [sign * context.sqrt(context.mpc(s)) for s in squares for sign in (1, -1)]
    tiny = context.mpf(2) ** (-bits // 2)
    stable = simple and all(s.real < 0 and abs(s.imag) <= tiny * abs(s) for s in map(context.mpc, squares))
    ratios = tuple(_ratios(system, M, Γ, K, values, λ, context) for λ in exponents)
    if not stable:
        return LinearModes(system, polynomial, tuple(exponents), ratios, False, (), (), None, None, values, digits)
    ω = tuple(sorted(context.sqrt(-context.mpc(s).real) for s in squares))
    S = _hessian(system, values, context)
    columns = [_pair(S, w, context) for w in ω]
    N = _joined([c[0] for c in columns], [c[1] for c in columns], context)
    signs = tuple(c[2] for c in columns)
    return LinearModes(
        system, polynomial, tuple(exponents), ratios, True, ω, signs, N, _oscillators(system, ω, signs), values, digits
    )


def _bits(digits: int) -> int:
    return bits_for(digits, 128)


def _matrices(system: System) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """M, G − Gᵀ and K, all constant."""
    q = [c.symbol for c in system.coordinates]
    M = sp.Matrix(mass_matrix(system))
    V = sp.expand(system.potential - kinetic_rest(system))
    G = sp.Matrix([[sp.diff(a, s) for s in q] for a in linear_terms(system)])
    K = sp.hessian(V, q)
    origin = dict.fromkeys(q, sp.S.Zero)
    if any(set(q) & x.free_symbols for x in [*M, *G, *K]):
        raise InvalidSystemError("linear modes: M, T1 and V must be constant, bilinear, quadratic in the coordinates")
    if any(sp.expand(sp.diff(V, s).subs(origin)) != 0 for s in q):
        raise InvalidSystemError("linear modes: V has a term of first degree; measure the coordinates from equilibrium")
    return M, G - G.T, K


def _squares(polynomial: sp.Expr, bits: int) -> tuple[list[Mpf], bool]:
    """Return the roots of the characteristic equation in λ², and whether all are simple and none is zero."""
    context = multiprecision(bits)
    s = sp.Symbol("s")
    in_squares = sp.Poly(polynomial.subs(LAMBDA, sp.sqrt(s)), s)
    coefficients = [context.convert(to_bits(c)(bits)) for c in in_squares.all_coeffs()]
    try:
        roots = context.polyroots(coefficients, maxsteps=400, extraprec=2 * bits)
    except context.NoConvergence:
        raise NotConvergedError("the characteristic equation has roots too close to tell apart") from None
    discriminant = sp.discriminant(in_squares.as_expr(), s) if in_squares.degree() > 1 else sp.S.One
    simple = abs(discriminant.evalf(30)) > 1e-25 and abs(coefficients[-1]) > 0
    return sorted(roots, key=abs), bool(simple)


def _ratios(
    system: System,
    M: sp.Matrix,
    Γ: sp.Matrix,
    K: sp.Matrix,
    values: Mapping[sp.Symbol, sp.Expr],
    λ: Mpf | Mpc,
    context: Context,
) -> dict[str, Mpf | Mpc]:
    """A_i/A_1 of the amplitudes with M λ² A + Γ λ A + K A = 0: the cofactors of one row."""
    n = M.rows
    numbers = [[[to_bits(sp.sympify(X[i, j]).subs(values))(context.prec) for j in range(n)] for i in range(n)]
               for X in (M, Γ, K)]  # fmt: skip
    A = context.matrix(
        [[numbers[0][i][j] * λ**2 + numbers[1][i][j] * λ + numbers[2][i][j] for j in range(n)] for i in range(n)]
    )
    best = max((_cofactors(A, row, context) for row in range(n)), key=lambda v: max(abs(x) for x in v))
    if abs(best[0]) <= context.mpf(2) ** (-context.prec // 2) * max(abs(x) for x in best):
        return {}
    return {c.name: best[i] / best[0] for i, c in enumerate(system.coordinates)}


def _cofactors(A: MpfMatrix, row: int, context: Context) -> list[Mpf | Mpc]:
    n = A.rows
    found = []
    for j in range(n):
        minor = [[A[i, k] for k in range(n) if k != j] for i in range(n) if i != row]
        found.append((-1) ** (row + j) * _determinant(minor, context))
    return found


def _determinant(rows: list[list[Mpf]], context: Context) -> Mpf:
    """Gaussian elimination; 0 where a column has no pivot, as a minor of a decoupled coordinate has (mpmath raises)."""
    product, left = context.mpf(1), [list(row) for row in rows]
    while left:
        best = max(range(len(left)), key=lambda i: abs(left[i][0]))
        pivot, *rest = left.pop(best)
        if not pivot:
            return context.mpf(0)
        product *= -pivot if best % 2 else pivot
        left = [[x - row[0] / pivot * y for x, y in zip(row[1:], rest, strict=True)] for row in left]
    return product


def _hessian(system: System, values: Mapping[sp.Symbol, sp.Expr], context: Context) -> MpfMatrix:
    z = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    S = sp.hessian(sp.expand(hamiltonian(system)), z).subs(values)
    return context.matrix([[to_bits(S[i, j])(context.prec) for j in range(len(z))] for i in range(len(z))])


def _symplectic(n: int, context: Context) -> MpfMatrix:
    J: MpfMatrix = context.matrix(2 * n, 2 * n)
    for i in range(n):
        J[i, n + i], J[n + i, i] = 1, -1
    return J


def _pair(S: MpfMatrix, ω: Mpf, context: Context) -> tuple[MpfMatrix, MpfMatrix, int]:
    """Return the columns of N that belong to one frequency, and the sign of the mode's energy."""
    n = S.rows // 2
    J = _symplectic(n, context)
    A = (J * S) * context.mpc(1) - context.mpc(0, 1) * ω * context.eye(2 * n)
    rows = [_cofactors(A, row, context) for row in range(2 * n)]
    v = max(rows, key=lambda x: max(abs(y) for y in x))
    size = max(abs(x) for x in v)
    u, w = context.matrix([(x / size).real for x in v]), context.matrix([(x / size).imag for x in v])
    κ = (u.T * J * w)[0]
    scale = context.sqrt(abs(κ))
    return (u / scale, w / scale, 1) if κ > 0 else (w / scale, u / scale, -1)


def _joined(first: list[MpfMatrix], second: list[MpfMatrix], context: Context) -> MpfMatrix:
    columns = [*first, *second]
    return context.matrix([[c[i] for c in columns] for i in range(len(columns))])


def _inverse(N: MpfMatrix) -> MpfMatrix:
    """N⁻¹ = −J Nᵀ J of a symplectic matrix."""
    J = _symplectic(N.rows // 2, N.ctx)
    return -(J * N.T * J)


def _oscillators(system: System, ω: tuple[Mpf, ...], signs: tuple[int, ...]) -> System:
    """H = Σ σ ω (Q² + P²)/2 as T and V; T is indefinite where modes have negative energy."""
    names = [f"Q{k + 1}" for k in range(len(ω))]
    kinetic = " + ".join(f"({s})*dot({n})**2/(2*omega_{k + 1})" for k, (n, s) in enumerate(zip(names, signs)))
    potential = " + ".join(f"({s})*omega_{k + 1}*{n}**2/2" for k, (n, s) in enumerate(zip(names, signs)))
    return System(
        dict.fromkeys(names, "line"), kinetic, potential, {f"omega_{k + 1}": w for k, w in enumerate(ω)},
        signature="definite" if min(signs) > 0 else "indefinite", title=f"{system.title}, normal form",
    )  # fmt: skip


def _canonical(
    modes: LinearModes, q: Mapping[str, object], velocity: Mapping[str, object] | None, p: Mapping[str, object] | None
) -> list[sp.Expr]:
    """(q, p) exact."""
    system = modes.system
    what, given = one_of_velocity_and_p(velocity, p)
    places, rates = (complete_numbers(system.coordinates, group, name) for name, group in (("q", q), (what, given)))
    if what == "velocity":
        at = dict(modes.values) | {c.symbol: places[c.name] for c in system.coordinates}
        at |= {c.velocity: rates[c.name] for c in system.coordinates}
        rates = {name: formula.subs(at) for name, formula in momenta(system).items()}
    return [*places.values(), *(number(rates[c.name], source=f"p[{c.name}]") for c in system.coordinates)]
