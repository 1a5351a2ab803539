"""The flow of a linear system ż = A z + b with constant coefficients, to any number of digits.

With the constant 1 as one more variable, ẑ = (z, 1), it is dẑ/dt = Â ẑ. Let λ run over the roots of the minimal
polynomial μ of Â, k_λ their multiplicities in it and q_λ = μ/(x − λ)^{k_λ}. Then (Gantmacher, ch. 5)

    e^{Ât} = Σ_λ e^{λt} Σ_{j < k_λ} t^j/j! V_{λj},   V_{λj} = (Â − λ)^j q_λ(Â) Σ_{i < k_λ − j} g_{λi} (Â − λ)^i,

g_{λi} the Taylor coefficients of 1/q_λ at λ. Multiplicities are exact: the characteristic polynomial is split into
squarefree factors f_i, and f_i^k is put into Â until it annihilates. So k_λ = 1 proves a complete set of modes.

**Error.** Let w(t) = Σ e^{λt} t^j/j! v_{λj} be the computed sum, v_{λj} for V_{λj} ẑ(0), rounding leaves r_{λj} =
Â v_{λj} − λ v_{λj} − v_{λ,j+1}. Then ẇ = Â w − Σ e^{λt} t^j/j! r_{λj}, and by variation of constants

    |w(t) − ẑ(t)| ≤ G(t) (|w(0) − ẑ(0)| + t Σ_{λj} e^{max(Re λ t, 0)} |t|^j/j! |r_{λj}|),   |e^{Âs}| ≤ G(t), 0 ≤ s ≤ t,

with G from the sum above and |q_λ(Â)| ≤ Π (|Â| + |μ|)^{k_μ}. More bits are taken until the bound is below the digits
that are asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Any

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Context, Mpc, Mpf, MpfMatrix
from hjsolve.errors import NotConvergedError
from hjsolve.motion.initial_data import to_bits

X = sp.Symbol("x")
_MOST_BITS = 1 << 16


@dataclass(frozen=True)
class Factor:
    """A squarefree factor of the characteristic polynomial.

    Attributes:
        polynomial: f(x), exact.
        multiplicity: of its roots in the characteristic polynomial.
        block: of its roots in the minimal polynomial, the size of the largest Jordan block; 1: as many modes as roots.
    """

    polynomial: sp.Poly
    multiplicity: int
    block: int


@dataclass(frozen=True)
class LinearFlow:
    """ż = A z, exact.

    Attributes:
        matrix: A, square.
        factors: of its characteristic polynomial.
    """

    matrix: sp.ImmutableMatrix
    factors: tuple[Factor, ...]

    def exponents(self, bits: int) -> list[tuple[Mpc, Factor]]:
        """Return the roots of the characteristic polynomial in so many bits, each once, with its factor."""
        context = multiprecision(bits)
        return [(context.mpc(λ), factor) for factor in self.factors for λ in _roots(factor.polynomial, context)]

    def projections(self, bits: int) -> list[tuple[Mpc, MpfMatrix]]:
        """Return for each exponent λ the projection V_{λ0} on its root space."""
        context = multiprecision(bits)
        A = _numbers(self.matrix, context)
        return [(λ, terms[0]) for λ, terms, _ in _terms(self, A, context.eye(A.rows), context)]


def affine(A: sp.Matrix, b: sp.Matrix) -> sp.Matrix:
    """Return Â = [[A, b], [0, 0]], with which (z, 1) moves linearly where ż = A z + b.

    Args:
        A: square matrix.
        b: column.
    """
    return sp.Matrix(sp.BlockMatrix([[A, b], [sp.zeros(1, A.rows), sp.zeros(1, 1)]]).as_explicit())


def flow_of(A: sp.Matrix) -> LinearFlow:
    """Factorise the characteristic polynomial of a linear system, and find the sizes of its Jordan blocks exactly.

    Args:
        A: square matrix of exact numbers.
    """
    exact = DomainMatrix.from_Matrix(A, extension=True)
    exact = exact.to_field()
    p = sp.Poly(exact.charpoly(), X, domain=exact.domain)
    split = [(g, m) for f, m in p.sqf_list()[1] for g in _without_zero(f)]
    values = [_at(f, exact) for f, _ in split]
    factors = []
    for i, (f, m) in enumerate(split):
        rest = exact.eye(A.rows, exact.domain).to_sparse()
        for j, (_, n) in enumerate(split):
            rest = rest if i == j else rest * values[j] ** n
        block = next(k for k in range(1, m + 1) if k == m or not any((rest * values[i] ** k).to_dok().values()))
        factors.append(Factor(f, m, block))
    return LinearFlow(A.as_immutable(), tuple(factors))


def _without_zero(f: sp.Poly) -> list[sp.Poly]:
    """Return a squarefree polynomial as x times the rest, where 0 is one of its roots: that root is then exact."""
    if f.nth(0) != 0:
        return [f]
    x = sp.Poly(X, X, domain=f.domain)
    return [x] if f.degree() == 1 else [x, f.quo(x)]


def _at(f: sp.Poly, A: DomainMatrix) -> DomainMatrix:
    """f(A), by Horner's rule."""
    one = A.eye(A.shape[0], A.domain).to_sparse()
    found = one * A.domain.zero
    for c in f.rep.to_list():
        found = found * A.to_sparse() + one * c
    return found


def _roots(f: sp.Poly, context: Context) -> list[Mpc]:
    """Roots of a squarefree polynomial; 0 exactly."""
    coefficients = [context.convert(to_bits(c)(context.prec)) for c in f.all_coeffs()]
    if f.degree() == 1 and f.nth(0) == 0:
        return [context.mpc(0)]
    try:
        found: list[Mpc] = context.polyroots(coefficients, maxsteps=400, extraprec=4 * context.prec)
    except context.NoConvergence:
        raise NotConvergedError("the characteristic equation has roots too close to tell apart") from None
    return found


def _terms(
    flow: LinearFlow, A: MpfMatrix, start: MpfMatrix, context: Context
) -> list[tuple[Mpc, list[MpfMatrix], list[Mpf]]]:
    """For each exponent λ: V_{λj} times the columns of ``start``, j < k_λ, and bounds on the sizes of V_{λj}."""
    roots, size = flow.exponents(context.prec), _size(A)
    found = []
    for λ, own in roots:
        others = [(μ, f.block) for μ, f in roots if μ is not λ]
        series = _inverse_series([(λ - μ, k) for μ, k in others], own.block, context)
        powers = [start * context.mpc(1)]
        for μ, k in others:
            for _ in range(k):
                powers[0] = A * powers[0] - powers[0] * μ
        for _ in range(own.block - 1):
            powers.append(A * powers[-1] - powers[-1] * λ)
        norm = context.fprod((size + abs(μ)) ** k for μ, k in others)
        norms = [norm * (size + abs(λ)) ** i for i in range(own.block)]
        left = [range(own.block - j) for j in range(own.block)]
        terms = [sum((powers[i + j] * series[i] for i in left[j]), 0 * powers[0]) for j in range(own.block)]
        sizes = [context.fsum(norms[i + j] * abs(series[i]) for i in left[j]) for j in range(own.block)]
        found.append((λ, terms, sizes))
    return found


def _inverse_series(gaps: list[tuple[Mpc, int]], length: int, context: Context) -> list[Mpc]:
    """Taylor coefficients of Π (d + s)^{−k} at s = 0."""
    series = [context.mpc(1)] + [context.mpc(0)] * (length - 1)
    for d, k in gaps:
        inverse = [context.binomial(-k, i) * d ** (-k - i) for i in range(length)]
        series = [context.fsum(series[i] * inverse[n - i] for i in range(n + 1)) for n in range(length)]
    return series


def _numbers(matrix: sp.ImmutableMatrix, context: Context) -> MpfMatrix:
    return context.matrix([[to_bits(x)(context.prec) for x in matrix.row(i)] for i in range(matrix.rows)])


def _size(matrix: MpfMatrix) -> Mpf:
    """Return the norm of the greatest row sum."""
    rows = [matrix.ctx.fsum(abs(matrix[i, j]) for j in range(matrix.cols)) for i in range(matrix.rows)]
    return max(rows)


@dataclass(frozen=True, eq=False)
class LinearPath:
    """z(t) of one initial state, ready to be evaluated.

    Attributes:
        terms: (λ, vectors v_{λ0} …), z = Re Σ e^{λt} Σ t^j/j! v_{λj}.
        sizes: for each term bounds on the sizes of V_{λj}, and the sizes of the residuals r_{λj}.
        start: |w(0) − z(0)|.
        scale: size of z at the start.
        context: of the numbers.
    """

    terms: list[tuple[Mpc, list[MpfMatrix]]]
    sizes: list[tuple[list[Mpf], list[Mpf]]]
    start: Mpf
    scale: Mpf
    context: Context

    def at(self, t: Mpf) -> list[Mpf]:
        """Return z at a time after the start.

        Args:
            t: the time, of either sign.
        """
        total: Any = 0
        for λ, v in self.terms:
            power = self.context.exp(λ * t)
            for j, column in enumerate(v):
                total = total + column * (power * t**j / self.context.factorial(j))
        return [self.context.re(x) for x in total]

    def bound(self, t: Mpf) -> Mpf:
        """Return a bound on the error of every number of z(t); see the head of this file.

        Args:
            t: the time after the start.
        """
        signed, t, growth, residual = t, abs(t), self.context.mpf(0), self.context.mpf(0)
        for (λ, _), (V, r) in zip(self.terms, self.sizes, strict=True):
            power = self.context.exp(max(self.context.re(λ) * signed, 0))
            for j, (size, rest) in enumerate(zip(V, r, strict=True)):
                growth += power * t**j / self.context.factorial(j) * size
                residual += power * t**j / self.context.factorial(j) * rest
        rounding = 64 * growth * self.context.ldexp(1, -self.context.prec) * (1 + self._phase(t))
        return 2 * growth * (self.start + t * residual) + rounding * self.scale

    def bend(self, i: int, start: Mpf, stop: Mpf) -> Mpf:
        """Return a bound on |d²z_i/dt²| from one time to another, errors of z apart.

        Args:
            start, stop: times after the start, of one sign, the second farther away.
        """
        return self._size_of(i, 2, start, stop)

    def stays_within(self, i: int, stop: Mpf) -> tuple[Mpf, Mpf]:
        """Return the part of a number that does not vary, and a bound on the rest from the start to a time."""
        fixed = next((self.context.re(v[0][i]) for λ, v in self.terms if λ == 0), self.context.mpf(0))
        return fixed, self._size_of(i, 0, self.context.mpf(0), stop) + self.bound(stop)

    def _size_of(self, i: int, order: int, start: Mpf, stop: Mpf) -> Mpf:
        """Bound on a derivative of z_i − fixed: each factor t^j/j! is differentiated k times, e^{λt} the others."""
        total, t = self.context.mpf(0), abs(stop)
        for λ, v in self.terms:
            power = self.context.exp(max(self.context.re(λ) * start, self.context.re(λ) * stop))
            for j, column in enumerate(v):
                if λ == 0 and j == 0:
                    continue
                parts = ((abs(λ) ** (order - k) * comb(order, k), j - k) for k in range(min(order, j) + 1))
                slope = self.context.fsum(size * t**left / self.context.factorial(left) for size, left in parts)
                total += power * slope * abs(column[i])
        return total

    def _phase(self, t: Mpf) -> Mpf:
        """Return the size of the greatest argument of an exponential: its rounding moves the phase."""
        return max(abs(λ) for λ, _ in self.terms) * t


def path_of(flow: LinearFlow, start: list[sp.Expr], span: sp.Expr, digits: int) -> LinearPath:
    """Prepare z(t) with enough bits that its error at every time of the span is below the digits wanted.

    Args:
        flow: the linear system.
        start: z at t = 0, exact.
        span: the greatest time that will be asked for, exact.
        digits: relative to the largest number that z may grow to.

    Raises:
        NotConvergedError: more than 65536 bits would be needed.
    """
    bits = int(3.33 * digits) + 160
    while bits <= _MOST_BITS:
        found = _prepared(flow, start, bits)
        t = found.context.convert(to_bits(sp.Abs(span))(bits))
        reached = max([abs(x) for x in found.at(t)] + [found.scale])
        if found.bound(t) <= reached * found.context.mpf(10) ** -(digits + 3):
            return found
        bits *= 2
    raise NotConvergedError(f"the linear motion needs more than {_MOST_BITS} bits at t = {span}")


def _prepared(flow: LinearFlow, start: list[sp.Expr], bits: int) -> LinearPath:
    context = multiprecision(bits)
    A, z = _numbers(flow.matrix, context), context.matrix([to_bits(x)(bits) for x in start])
    terms, sizes, total = [], [], -z
    for λ, v, norms in _terms(flow, A, z, context):
        residuals = [A * x - λ * x - (v[j + 1] if j + 1 < len(v) else x * 0) for j, x in enumerate(v)]
        terms.append((λ, v))
        sizes.append((norms, [_size(r) for r in residuals]))
        total = total + v[0]
    return LinearPath(terms, sizes, _size(total), max(abs(x) for x in z), context)
