"""Linear gyroscopic systems: separated by a linear symplectic normal form, where no change of coordinates does it.

With constant M, T₁ = Σ G_ij q̇_i q_j and V = ½ qᵀK q − fᵀq the motion is M q̈ + (G − Gᵀ) q̇ + K q = f (Greenwood
(3-117)), with the characteristic equation det(M λ² + (G − Gᵀ) λ + K) = 0. In the space of z = (q, p), ż = J (S z + h)
with S the Hessian of H. Its motion is a sum of e^{λt} times polynomials, exactly (``linear_flow``): oscillations,
drifts (λ = 0), growth. Where all λ are imaginary, not 0, and there are as many modes as roots, repeated ones
included, vectors of each eigenspace that make the Hermitian form v†Jv/2i diagonal, scaled, make a symplectic N:

    z − z* = N (Q, P),   NᵀJN = J,   H = Σ σ_k ω_k (Q_k² + P_k²)/2,   σ_k = ±1.

The modes are oscillators, those with σ = −1 of negative energy: stable by gyroscopic forces although V has no minimum.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Context, Mpc, Mpf, MpfMatrix, Numbers
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError, MissingValueError
from hjsolve.extended.ends_of_domains import Approach, Wall, first_end, walls_of
from hjsolve.extended.linear_flow import Factor, LinearFlow, LinearPath, affine, flow_of, path_of
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, hamiltonian, kinetic_rest, linear_terms, mass_matrix
from hjsolve.motion.charted.collisions import Ends, between
from hjsolve.motion.initial_data import parameter_values, read_phase_point, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.shapes import by_coordinate
from hjsolve.motion.state import Errors, State
from hjsolve.motion.times import exact_numbers
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
        stable: True where no motion grows: all λ are imaginary, and repeated ones have as many modes as roots (proved).
        complete: whether there are as many modes as exponents; False where some motion has a factor t, t², ….
        frequencies: ω_k of the modes that oscillate, increasing, each as often as it occurs; () where some exponent
            other than 0 is not imaginary, or has too few modes.
        signs: σ_k, the sign of the energy of each of them.
        drifts: half the number of exponents 0: coordinates that run on evenly, or rest.
        matrix: N as an ``mpmath`` matrix of 2n rows: q then p; None where not every mode oscillates.
        normal_form: the modes as a system that separates, coordinates ``Q1`` …; None where ``matrix`` is.
        values: the parameters used, by symbol.
        digits: of all numbers.
    """

    system: System
    polynomial: sp.Expr
    exponents: tuple[Mpf | Mpc, ...]
    ratios: tuple[Mapping[str, Mpf | Mpc], ...]
    stable: bool
    complete: bool
    frequencies: tuple[Mpf, ...]
    signs: tuple[int, ...]
    drifts: int
    matrix: MpfMatrix | None
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
        """Start a motion from initial data of the system as posed, at t = 0; stable or not.

        Args:
            q: position of every coordinate.
            velocity: of every coordinate, or
            p: its canonical momentum.

        Raises:
            InvalidInputError: velocity and p are both given or both missing, or a place is outside its domain.
        """
        parameters = {x.name: self.values[x.symbol] for x in self.system.parameters}
        values = read_phase_point(self.system, q, velocity, p, parameters)
        start = tuple(values[x] for x in phase_space(self.system))
        if self.normal_form is None or self.matrix is None:
            return ModalMotion(self, start, None)
        context = multiprecision(_bits(self.digits))
        A, b = equations(self.system, self.values)
        rest = A.LUsolve(-b)
        z = context.matrix([to_bits(x - r)(context.prec) for x, r in zip(start, rest, strict=True)])
        modal = _inverse(self.matrix) * z
        names = [c.name for c in self.normal_form.coordinates]
        n = len(names)
        data = [{name: number(modal[i + k], source="mode") for i, name in enumerate(names)} for k in (0, n)]
        return ModalMotion(self, start, solve(self.normal_form).motion(q=data[0], p=data[1], digits=self.digits))


@dataclass(frozen=True, eq=False, repr=False)
class ModalMotion(Shown):
    """A motion of a linear system, in the coordinates as posed.

    Attributes:
        modes: the exponents, and the normal form where there is one.
        start: q and p at t = 0, exact.
        motion: of the normal form, by Hamilton–Jacobi; None where not every mode oscillates.
    """

    modes: LinearModes
    start: tuple[sp.Expr, ...]
    motion: Motion | None
    _ends: dict[int, tuple[Mpf, Estimate | None]] = field(default_factory=dict, repr=False)

    @property
    def kinds(self) -> Mapping[str, str]:
        """The kinds of motion of the modes ``Q1`` …; where not all oscillate, of the coordinates as posed."""
        if self.motion is not None:
            return self.motion.kinds
        names = [c.name for c in self.modes.system.coordinates]
        path = self._path(sp.S.One)
        return {name: _kind(path, i) for i, name in enumerate(names)}

    @property
    def constants(self) -> Mapping[str, Estimate]:
        """The constants of the motion of the modes; where not all oscillate, the energy."""
        if self.motion is not None:
            return self.motion.constants
        at = dict(zip(phase_space(self.modes.system), self.start, strict=True)) | dict(self.modes.values)
        bits = _bits(self.modes.digits)
        E = to_bits(hamiltonian(self.modes.system).subs(at))(bits)
        return {"E": Estimate(E, abs(E) * E.context.mpf(10) ** -self.modes.digits)}

    def at(self, t: object) -> State:
        """Return the state in the coordinates as posed at a time or at an array of times; as ``Motion.at``."""
        shape, times = exact_numbers(t, "t")
        path = self._path(max((sp.Abs(x) for x in times), default=sp.S.Zero))
        context, n = path.context, len(self.modes.system.coordinates)
        A, b = equations(self.modes.system, self.modes.values)
        speeds = [[to_bits(x)(context.prec) for x in sp.Matrix(A.row(i)).row_join(b.row(i))] for i in range(n)]
        rows, bounds = [], []
        for exact in times:
            moment = context.convert(to_bits(exact)(context.prec))
            z, error = path.at(moment), path.bound(moment)
            rows.append([*z[:-1], *(context.fdot(row, z) for row in speeds)])
            bounds.append([*[error] * (2 * n), *(error * context.fsum(map(abs, row)) for row in speeds)])
        unit = context.mpf(2) ** -53 if self.modes.digits <= 15 else context.mpf(10) ** -self.modes.digits
        values, uncertainties = np.array(rows, dtype=object), np.array(bounds, dtype=object)
        small = np.abs(values) <= 8 * uncertainties  # what is rounding alone is reported as 0
        values, uncertainties = (
            np.where(small, context.mpf(0), values),
            np.where(small, 9 * uncertainties, uncertainties),
        )

        def errors() -> Errors:
            return Errors(*self._named(uncertainties + unit * np.abs(values), shape))

        q, p, velocity = self._named(values, shape)
        status = np.full(shape, "ok") if shape else "ok"
        state = State(t, q, p, velocity, {}, status, errors)
        ends = self._ends_within(path, times)
        return state if ends == (None, None) else between(ends, state)

    def _ends_within(self, path: LinearPath, times: Sequence[sp.Expr]) -> Ends:
        """Return when the motion came into its domain and leaves it, None where that is outside of the times."""
        walls, found = walls_of(self.modes.system, self.modes.values), []
        for sign in (-1, 1):
            zero, bits = path.context.mpf(0), path.context.prec
            span = max([path.context.convert(to_bits(sign * t)(bits)) for t in times] + [zero])
            known, end = self._ends.get(sign, (zero, None))
            if end is None and known < span:
                end = self._first_end(path, walls, sign, span)
                self._ends[sign] = span, end
            found.append(end)
        return found[0], found[1]

    def _first_end(self, path: LinearPath, walls: Sequence[Wall], sign: int, span: Mpf) -> Estimate | None:
        A, b = equations(self.modes.system, self.modes.values)
        rows, n = A.row_join(b), len(self.modes.system.coordinates)
        speeds = [[to_bits(x)(path.context.prec) for x in rows.row(i)] for i in range(2 * n)]
        size = max(path.context.fsum(map(abs, row)) for row in speeds)  # |A|: an error δ of z has |δ̈| = |A² δ|

        def at(s: Mpf) -> Approach:
            z, error = path.at(sign * s), path.bound(sign * s)
            return Approach(z[:n], [sign * path.context.fdot(row, z) for row in speeds[:n]], error, size * error)

        def bends(row: int, s: Mpf, until: Mpf) -> Mpf:
            return path.bend(row, sign * s, sign * until) + size**2 * path.bound(sign * until)

        near = []
        for wall in walls:
            fixed, rest = path.stays_within(wall.row, sign * span)
            if wall.side * (fixed - to_bits(wall.end)(path.context.prec)) <= rest:
                near.append(wall)
        end = first_end(near, path.context.mpf(0), span, at, bends)
        return end if end is None or sign > 0 else Estimate(-end.value, end.error)

    def _path(self, span: sp.Expr) -> LinearPath:
        A, b = equations(self.modes.system, self.modes.values)
        return path_of(flow_of(affine(A, b)), [*self.start, sp.S.One], span, max(self.modes.digits, 15))

    def _named(self, rows: Numbers, shape: tuple[int, ...]) -> Iterator[dict[str, AtTimes]]:
        columns = (rows.astype(float) if self.modes.digits <= 15 else rows).T
        return by_coordinate([c.name for c in self.modes.system.coordinates], columns, shape)


def _kind(path: LinearPath, i: int) -> str:
    """Whether a coordinate rests, stays bounded, or runs away, by the terms e^{λt} t^j that it holds."""
    context, found = path.context, "equilibrium"
    least = context.mpf(2) ** (-context.prec // 2) * path.scale
    for λ, v in path.terms:
        for j, column in enumerate(v):
            if abs(column[i]) <= least or (λ == 0 and j == 0):
                continue
            if j > 0 or abs(context.re(λ)) > context.mpf(2) ** (-context.prec // 2) * abs(λ):
                return "escape"
            found = "libration"
    return found


@arguments.with_known_names("gyroscopic_modes(system, digits=30)")
@one_at_a_time
def gyroscopic_modes(
    system: System | str | Path, *, parameters: Mapping[str, object] | None = None, digits: int = 30
) -> LinearModes:
    """Find the exponents of a linear system, and its normal form by a linear symplectic map where all modes oscillate.

    Args:
        system: constant masses, T₁ bilinear, T₀ and V of second degree in the coordinates; or the id or file of a
            catalog entry.
        parameters: values that differ from the defaults.
        digits: of all numbers.

    Returns:
        The modes, with their frequencies and shapes; ``motion`` starts any motion, stable or not.

    Raises:
        InvalidSystemError: the system is not linear.
        MissingValueError: a parameter has no value.
        NotConvergedError: exponents too close to tell apart.
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
    context = multiprecision(bits)
    flow = flow_of(equations(system, values)[0])
    found, imaginary = _squares(flow, bits)
    exponents = [
        sign * context.sqrt(s)
        for s, f in found for _ in range(f.multiplicity if s != 0 else f.multiplicity // 2) for sign in (1, -1)
    ]  # fmt: skip
    complete = all(f.block == 1 for _, f in found)
    ratios = tuple(_ratios(system, M, Γ, K, values, λ, context) for λ in exponents)
    zeros = next((f.multiplicity // 2 for s, f in found if s == 0), 0)
    plain = LinearModes(
        system, polynomial, tuple(exponents), ratios, imaginary and complete, complete, (), (), zeros, None, None,
        values, digits,
    )  # fmt: skip
    turning = [(s, f) for s, f in found if s != 0]
    if not imaginary or any(f.block > 1 for _, f in turning):
        return plain
    spaces = flow.projections(bits)
    found_pairs = [pair for s, _ in turning for pair in _pairs(spaces, context.sqrt(-s.real), context)]
    pairs = sorted(found_pairs, key=lambda pair: pair[2])
    ω, signs = tuple(pair[2] for pair in pairs), tuple(pair[3] for pair in pairs)
    plain = replace(plain, frequencies=ω, signs=signs)
    if zeros:
        return plain
    N = _joined([pair[0] for pair in pairs], [pair[1] for pair in pairs], context)
    return replace(plain, matrix=N, normal_form=_oscillators(system, ω, signs))


def linear_modes_of(system: System) -> LinearModes | None:
    """Return the modes of a system with terms linear in the velocities whose equations are linear; None of any other.

    Args:
        system: any; the defaults of its parameters are taken.
    """
    if system.relativity is not None or system.kinks or system.functions or not any(linear_terms(system)):
        return None
    try:
        return gyroscopic_modes(system, digits=20)
    except (InvalidSystemError, MissingValueError):
        return None


def equations(system: System, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Matrix, sp.Matrix]:
    """Return A and b of ż = A z + b, z = (q, p): Hamilton's equations of a linear system, exact.

    Args:
        system: whose H is of second degree in z.
    """
    z = phase_space(system)
    H, n = sp.expand(hamiltonian(system).subs(values)), len(system.coordinates)
    J = sp.Matrix(sp.BlockMatrix([[sp.zeros(n), sp.eye(n)], [-sp.eye(n), sp.zeros(n)]]).as_explicit())
    slopes = sp.Matrix([sp.diff(H, x) for x in z])
    return J * sp.hessian(H, z), J * slopes.subs(dict.fromkeys(z, 0))


def phase_space(system: System) -> list[sp.Symbol]:
    """Return the symbols of z = (q, p)."""
    return [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]


def _bits(digits: int) -> int:
    return bits_for(digits, 128)


def _matrices(system: System) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """M, G − Gᵀ and K, all constant."""
    q = [c.symbol for c in system.coordinates]
    M = sp.Matrix(mass_matrix(system))
    V = sp.expand(system.potential - kinetic_rest(system))
    G = sp.Matrix([[sp.diff(a, s) for s in q] for a in linear_terms(system)])
    K = sp.hessian(V, q)
    if any(set(q) & x.free_symbols for x in [*M, *G, *K]):
        raise InvalidSystemError(
            "linear modes: T must have constant masses and linear terms bilinear in q and dot(q), and V must be of "
            "second degree in the coordinates"
        )
    return M, G - G.T, K


def is_stable(system: System, values: Mapping[sp.Symbol, sp.Expr]) -> bool:
    """Return whether no motion of a linear system grows.

    Args:
        system: linear.
        values: of all parameters.
    """
    found, imaginary = _squares(flow_of(equations(system, values)[0]), _bits(15))
    return imaginary and all(factor.block == 1 for _, factor in found)


def _squares(flow: LinearFlow, bits: int) -> tuple[list[tuple[Mpc, Factor]], bool]:
    """λ² of the exponents, which come in pairs ±λ: each once, with its factor; and whether all λ are imaginary."""
    context = multiprecision(bits)
    found: list[tuple[Mpc, Factor]] = []
    for λ, factor in flow.exponents(bits):
        upper = context.im(λ) > 0 if abs(context.im(λ)) >= abs(context.re(λ)) else context.re(λ) > 0
        if λ == 0 or upper:
            found.append((λ**2, factor))
    imaginary = all(_negative(s, [x for x, _ in found], context) for s, _ in found if s != 0)
    return sorted(found, key=lambda pair: abs(pair[0])), imaginary


def _negative(s: Mpc, squares: list[Mpc], context: Context) -> bool:
    """Whether λ² is real and negative.

    The λ² are the simple roots of a real polynomial, so that one that is not real has its conjugate among them: an
    imaginary part far below the distance to all the others is rounding.
    """
    gaps = [abs(s - x) for x in squares if x is not s] + [abs(s)]
    return bool(s.real < 0 and abs(s.imag) <= min(gaps) * context.mpf(2) ** -16)


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


def _cofactors(A: MpfMatrix, row: int, context: Context) -> list[Mpf]:
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


def _symplectic(n: int, context: Context) -> MpfMatrix:
    J: MpfMatrix = context.matrix(2 * n, 2 * n)
    for i in range(n):
        J[i, n + i], J[n + i, i] = 1, -1
    return J


def _pairs(
    spaces: list[tuple[Mpc, MpfMatrix]], ω: Mpf, context: Context
) -> list[tuple[MpfMatrix, MpfMatrix, Mpf, int]]:
    """Return the columns of N that belong to one frequency, which may be repeated, with the sign of each mode's energy.

    ``spaces`` are the exponents, each with the projection on its eigenspace.
    """
    λ = context.mpc(0, ω)
    V = min(((abs(μ - λ), M) for μ, M in spaces), key=lambda pair: pair[0])[1]
    J, basis = _symplectic(V.rows // 2, context), list[MpfMatrix]()
    columns = [context.matrix([V[i, j] for i in range(V.rows)]) for j in range(V.cols)]
    rank = int(context.nint(context.re(sum(V[i, i] for i in range(V.rows)))))  # the trace of a projection
    for _ in range(rank):
        best = max(columns, key=context.norm)
        basis.append(best / context.norm(best))
        columns = [v - basis[-1] * (_adjoint(basis[-1]) * v)[0] for v in columns]
    Φ = context.matrix([[v[i] for v in basis] for i in range(V.rows)])
    κ, U = context.eighe(_adjoint(Φ) * J * Φ / context.mpc(0, 2))
    found = []
    for k, v in enumerate((Φ * U).T.tolist()):
        scale = context.sqrt(abs(κ[k]))
        u, w = (context.matrix([part(x) / scale for x in v]) for part in (context.re, context.im))
        found.append((u, w, ω, 1) if κ[k] > 0 else (w, u, ω, -1))
    return found


def _adjoint(matrix: MpfMatrix) -> MpfMatrix:
    return matrix.H


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
