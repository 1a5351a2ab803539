"""The integrals over one cycle of a libration or rotation, as trigonometric series.

With p² = (q − a)(b − q) R between turning points (R = p² for a rotation) and |dq/dχ| = s √((q − a)(b − q)) of the
anomaly,

    kⱼ dq/p = kⱼ s/√R dχ,     p dq = (q − a)(b − q) s √R dχ,     J = (1/2π) ∮ p dq,     ∂J/∂κⱼ = (1/2π) ∮ kⱼ dq/p,

whose integrands are analytic and periodic in χ: values at equally spaced midpoints give their Fourier coefficients
(Trefethen & Weideman, SIAM Review 56 (2014) 385, §3).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.one_coordinate.coordinate_motion import PARTS, Anomaly, Kind, Periodic
from hjsolve.one_coordinate.fourier_series import fit, zero
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.phase_map import Place


def bounded(
    kind: Kind,
    anomaly: Anomaly,
    radicand: MomentumSquared,
    start: Mpf,
    skipped: tuple[bool, ...],
    digits: int,
    bits: int,
    nodes: int,
    parts: frozenset[str] = PARTS,
) -> Periodic:
    """Integrate over one cycle of a libration or rotation.

    Args:
        kind: libration or rotation.
        anomaly: the map, at ``bits``.
        radicand: p² and its kernels.
        start: χ of the initial place.
        skipped: which kernels are zero everywhere.
        bits: working precision, enough for the cancellation at the turning points.
        nodes: how many are proved to be enough, for half a turn where all is even; see ``resolution``.
        parts: what is integrated, of ``PARTS``; the rest is left at zero, and the action at None.
    """
    if not parts:
        empty = [zero() for _ in skipped]
        return Periodic(kind, anomaly, empty, zero(), None, start, radicand)
    # one pass over the nodes gives all integrands: F and its map are the costly part
    values = integrands(radicand, skipped, bits, parts)
    rows = [values(place) for place in anomaly.places(nodes, Multi(bits))]
    *kernels, momentum, density = fit(rows, even=anomaly.even, digits=digits, bits=bits, floors=_floors(radicand))
    return Periodic(kind, anomaly, kernels, momentum, density if "action" in parts else None, start, radicand)


def _floors(radicand: MomentumSquared) -> list[float]:
    return [0.0] * len(radicand.kernels.outputs) + [1.0, 0.0]


def integrands(
    radicand: MomentumSquared, skipped: tuple[bool, ...], bits: int, parts: frozenset[str]
) -> Callable[[Place], list[Mpf | None]]:
    """kⱼ (dq/dψ)/p for each constant, ln(p/(dq/dχ)), and p dq/dψ, all regular functions of the phase ψ (mostly χ).

    Args:
        radicand: p² and its kernels.
        skipped: kernels that are zero everywhere.
        parts: what is integrated, of ``PARTS``; the others come out as None.
    """
    arithmetic = Multi(bits)

    def functions(place: Place) -> list[Mpf | None]:
        # √R = √(F/((q − a)(b − q))): regular and without zero between and at the turning points
        root = (radicand.value(place.q, bits) / place.product) ** 0.5
        kernels: list[Mpf | None] = [None] * len(skipped)
        if "time" in parts:
            weights = radicand.weights(place.q, bits)
            # (dq/dψ)/p = stretch (dχ/dψ)/√R: the roots of (q − a)(b − q) have cancelled
            scale = place.stretch * place.rate / root
            kernels = [None if skip else w * scale for w, skip in zip(weights, skipped, strict=True)]
        # as a logarithm: p/(dq/dχ) may vary by a thousand orders, and its series then has relative accuracy everywhere
        momentum = arithmetic.context.log(root / place.stretch) if "place" in parts else None
        # p dq/dψ has a double zero at a turning point: product, and no root of it
        action = cast("Mpf", place.product * root * place.stretch * place.rate) if "action" in parts else None
        return [*kernels, momentum, action]

    return functions
