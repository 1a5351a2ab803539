"""A, B and C of S = ½ q·A q + B·q + C, with bounds on their errors.

A, B and C follow from solutions of linear equations with a proved error (``quadratic_flow``): with Q̂, P̂ for ∂q/∂q(t₀)
and ∂p/∂q(t₀), X for the computed Q̂⁻¹ and Â = P̂X, every entry of Q̂ and P̂ known to e, ε = n e,

    A − Â = (P − ÂQ) Q⁻¹,   ‖P − ÂQ‖ ≤ ‖P̂ − ÂQ̂‖ + ε (1 + ‖Â‖),   ‖Q⁻¹‖ ≤ ‖X‖/(1 − ‖1 − Q̂X‖ − ε‖X‖)

in the norm of row sums. Where that denominator is not positive, the time may be conjugate to t₀; more digits decide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.number_types import Mpf, MpfMatrix
from hjsolve.display.shown import Shown
from hjsolve.errors import NotConvergedError

_MOST_MORE_DIGITS = 40
"""Digits added while a time may be conjugate: beyond, det Q_q is below any number that the coefficients could mean."""
Followed = Callable[[int], tuple[list[list[Mpf]], Mpf]]


@dataclass(frozen=True, eq=False, repr=False)
class PrincipalCoefficients(Shown):
    """S = ½ q·A q + B·q + C at one time, in which α = p(t₀) is constant and S(q, t₀) = α·q.

    Attributes:
        t: the time.
        A: symmetric, shape (n, n), rows and columns as the coordinates; float64 up to 15 digits, ``mpf`` above.
        B: shape (n,).
        C: with its error.
        error_A, error_B: bounds on the error of every entry of A and of B.
    """

    t: object
    A: NDArray[Any]
    B: NDArray[Any]
    C: Estimate
    error_A: float
    error_B: float


def principal_coefficients(t: object, n: int, followed: Followed, digits: int) -> PrincipalCoefficients:
    """Return A, B and C at a time.

    Args:
        t: the time, for display.
        n: number of coordinates.
        followed: digits → states (q, w, p, 1) at the time, and a bound on the error of each number: of the motion from
            q(t₀) = 0 with p(t₀) = α, of that from z = 0, and of those from each unit of q(t₀).
        digits: of the results, relative to the largest of A, of B and of C.

    Raises:
        NotConvergedError: the time is conjugate to t₀, or next to it.
    """
    more = 0
    while more <= _MOST_MORE_DIGITS:
        states, e = followed(digits + more)
        found = _bounded(states, n, e)
        if found is not None:
            A, B, C, errors = found
            sizes = [max(map(abs, A)), max(map(abs, B)), abs(C)]
            context = C.context
            wanted = context.mpf(10) ** -digits
            if all(error <= max(size, wanted) * wanted for error, size in zip(errors, sizes, strict=True)):
                return _rounded(t, n, A, B, C, errors, digits)
        more = 2 * more or 10
    raise NotConvergedError(
        f"coefficients: t = {t} is conjugate to the initial time, or too near to such a time: S is not finite there"
    )


def _bounded(states: list[list[Mpf]], n: int, e: Mpf) -> tuple[MpfMatrix, MpfMatrix, Mpf, list[Mpf]] | None:
    """Return A, B, C and bounds; None where Q_q is not proved to have an inverse."""
    moved, rest, *bases = states
    context = moved[0].context
    p = slice(n + 1, 2 * n + 1)
    Q = context.matrix([[z[i] - rest[i] for z in bases] for i in range(n)])
    P = context.matrix([[z[n + 1 + i] - rest[n + 1 + i] for z in bases] for i in range(n)])
    if context.det(Q) == 0:
        return None
    X, unit = Q**-1, context.eye(n)
    ε = 2 * n * e
    rounding = context.ldexp(n + 2, 2 - context.prec)
    defect = _norm(unit - Q * X) + rounding * _norm(Q) * _norm(X)
    margin = 1 - defect - ε * _norm(X)
    if margin <= 0:
        return None
    A = P * X
    inverse = _norm(X) / margin
    left = _norm(P - A * Q) + rounding * (_norm(P) + _norm(A) * _norm(Q)) + ε * (1 + _norm(A))
    of_A = left * inverse
    place, momentum = context.matrix(moved[:n]), context.matrix(moved[p])
    B = momentum - A * place
    reach = _norm(place.T) + n * e
    of_B = e + of_A * reach + _norm(A) * e * n + rounding * (_norm(momentum) + _norm(A) * reach)
    C = moved[n] - context.fdot(zip(place, B, strict=True)) / 2
    largest = max(map(abs, B))
    of_C = e + (of_B * reach + largest * n * e + rounding * (abs(moved[n]) + largest * reach)) / 2
    return A, B, C, [of_A, of_B, of_C]


def _norm(M: MpfMatrix) -> Mpf:
    """Return the largest sum of absolute values of a row."""
    return max(M[0, 0].context.fsum(abs(M[i, j]) for j in range(M.cols)) for i in range(M.rows))


def _rounded(
    t: object, n: int, A: MpfMatrix, B: MpfMatrix, C: Mpf, errors: list[Mpf], digits: int
) -> PrincipalCoefficients:
    """Return numbers of the type that the digits call for; their rounding is part of the errors."""
    kind, unit = (float, 2.0**-53) if digits <= 15 else (object, C.context.mpf(10) ** -digits)
    sizes = max(map(abs, A)), max(map(abs, B)), abs(C)
    of_A, of_B, of_C = (float(e + unit * x) * (1 + 2.0**-50) for e, x in zip(errors, sizes, strict=True))
    matrix = np.array([[A[i, j] for j in range(n)] for i in range(n)], dtype=object).astype(kind)
    value = float(C) if kind is float else C
    return PrincipalCoefficients(
        t, matrix, np.array(list(B), dtype=object).astype(kind), Estimate(value, of_C), of_A, of_B
    )
