"""Two places about a centre of attraction: distances, half the sweep angle, and what momenta are made of.

One text for doubles over arrays and for numbers of many digits: ``field`` is their arithmetic.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, NamedTuple

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import N, Numeric


class CentralPlaces(NamedTuple, Generic[N]):
    """Two places in the plane of an orbit that runs counterclockwise, or about the normal q0 × q1 in space.

    Attributes:
        r0, r1: distances from the centre.
        half_sine, half_cosine: of the sweep angle θ/2, 0 ≤ θ < 2π; the other way round has −half_cosine.
        radial0, radial1, tangent0, tangent1: for each coordinate, its momentum for a unit of radial and of transverse
            velocity and of mass. The other way round has −tangent.
    """

    r0: N
    r1: N
    half_sine: N
    half_cosine: N
    radial0: list[N]
    radial1: list[N]
    tangent0: list[N]
    tangent1: list[N]


def geometry(kind: str, q0: Sequence[Numeric], q1: Sequence[Numeric], field: Float64 | Multi) -> CentralPlaces:
    """Return the geometry of two places.

    Args:
        kind: of ``Attraction.kind``.
        q0, q1: coordinates in its order.
        field: of the numbers.
    """
    if kind == "polar":
        (r0, angle0), (r1, angle1) = q0, q1
        half = (angle1 - angle0) / 2
        sine, cosine = field.unary("sin", half), field.unary("cos", half)
        zero, one = 0 * sine, 1 + 0 * sine
        flip = field.where(sine < 0, -one, one)
        radial, turned = [one, zero], ([zero, r0 * one], [zero, r1 * one])
        return CentralPlaces(r0, r1, flip * sine, flip * cosine, radial, radial, *turned)
    if kind == "spherical":
        return _spherical(q0, q1, field)
    radii = [field.unary("sqrt", _total([x * x for x in q])) for q in (q0, q1)]
    u0, u1 = ([x / r for x in q] for q, r in zip((q0, q1), radii, strict=True))
    return _between(radii, u0, u1, field)


def _between(radii: Sequence[Numeric], u0: list[Numeric], u1: list[Numeric], field: Float64 | Multi) -> CentralPlaces:
    """From unit vectors: sin(θ/2) = |u₁ − u₀|/2 and cos(θ/2) = |u₁ + u₀|/2 up to 180°."""
    sine = field.unary("sqrt", _total([(b - a) ** 2 for a, b in zip(u0, u1, strict=True)])) / 2
    cosine = field.unary("sqrt", _total([(b + a) ** 2 for a, b in zip(u0, u1, strict=True)])) / 2
    if len(u0) == 2:
        cross = u0[0] * u1[1] - u0[1] * u1[0]
        cosine = field.where(cross < 0, -cosine, cosine)
        return CentralPlaces(radii[0], radii[1], sine, cosine, u0, u1, [-u0[1], u0[0]], [-u1[1], u1[0]])
    normal = _unit(_cross(u0, u1), field)
    return CentralPlaces(radii[0], radii[1], sine, cosine, u0, u1, _cross(normal, u0), _cross(normal, u1))


def _spherical(q0: Sequence[Numeric], q1: Sequence[Numeric], field: Float64 | Multi) -> CentralPlaces:
    """p_r = m ṙ, p_θ = m r v·e_θ, p_φ = m r sin θ v·e_φ."""
    frames = []
    for r, theta, phi in (q0, q1):
        s, c, sp, cp = (field.unary(name, angle) for angle in (theta, phi) for name in ("sin", "cos"))
        frames.append((r, s, [s * cp, s * sp, c], [c * cp, c * sp, -s], [-sp, cp, 0 * sp]))
    flat = _between([q0[0], q1[0]], frames[0][2], frames[1][2], field)
    tangents = []
    for (r, s, _, along, around), e in zip(frames, (flat.tangent0, flat.tangent1), strict=True):
        tangents.append([0 * r * s, r * _dot(e, along), r * s * _dot(e, around)])
    one, zero = 1 + 0 * flat.half_sine, 0 * flat.half_sine
    return flat._replace(
        radial0=[one, zero, zero], radial1=[one, zero, zero], tangent0=tangents[0], tangent1=tangents[1]
    )


def _cross(a: list[Numeric], b: list[Numeric]) -> list[Numeric]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _dot(a: list[Numeric], b: list[Numeric]) -> Numeric:
    return _total([x * y for x, y in zip(a, b, strict=True)])


def _total(terms: list[Numeric]) -> Numeric:
    total, *others = terms
    for term in others:
        total = total + term
    return total


def _unit(a: list[Numeric], field: Float64 | Multi) -> list[Numeric]:
    """Return a vector over its length; itself where that is zero."""
    size = field.unary("sqrt", _dot(a, a))
    return [x / field.where(size == 0, 1 + 0 * size, size) for x in a]
