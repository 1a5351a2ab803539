"""The separable coordinates of the plane and of space: names, domains, x(u) and h² in the local frame of the web.

T = m/2 Σ h_k² u̇_k². Octant charts (conical, ellipsoidal, paraboloidal) are the roots of

    ellipsoidal   Σ X_i²/(s − a_i) = a²,  X_i² = −a²Π_k (a_i − u_k)/Π_{j≠i}(a_i − a_j),    a₁ < u < a₂ < v < a₃ < w
    conical       Σ X_i²/(s − e_i) = 0,   X_i² = r² (e_i − μ)(e_i − ν)/Π_{j≠i}(e_i − e_j), e₁ < μ < e₂ < ν < e₃
    paraboloidal  Y²/(s − b) + Z²/(s − c) = a² s − 2aX, 2X = a (u + v + w − b − c),       u < b < v < c < w

(Kalnins 1986; Moon, Spencer, Field Theory Handbook; Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.coordinates.webs.web import Vector
from hjsolve.errors import InternalError


@dataclass(frozen=True)
class CoordinateRange:
    """The open interval a coordinate runs through; None where it has no end; an angle is periodic."""

    lower: sp.Expr | None = None
    upper: sp.Expr | None = None
    periodic: bool = False

    def text(self, name: str) -> str:
        """Return the domain as ``System`` wants it."""
        if self.periodic:
            return "angle"
        if self.lower is None and self.upper is None:
            return "line"
        left, right = (
            (f"{self.lower} < " if self.lower is not None else ""),
            (f" < {self.upper}" if self.upper is not None else ""),
        )
        return f"{left}{name}{right}"


LINE, ANGLE, HALF, MERIDIAN = (
    CoordinateRange(),
    CoordinateRange(-sp.pi, sp.pi, True),
    CoordinateRange(sp.S.Zero),
    CoordinateRange(sp.S.Zero, sp.pi),
)


@dataclass(frozen=True)
class SeparableChart:
    """Local coordinates u of a web.

    Attributes:
        symbols: the coordinates.
        ranges: where they run.
        place: X(u) in the local frame.
        scale: h_k²(u), so that T = m/2 Σ h_k² u̇_k².
        remark: what part of space is covered, or empty.
    """

    symbols: tuple[sp.Symbol, ...]
    ranges: tuple[CoordinateRange, ...]
    place: Vector
    scale: Vector
    remark: str = ""


Symbols = Callable[[str, CoordinateRange], sp.Symbol]
_OCTANT = "one octant of the frame; reflect it for the others"


def chart(kind: str, lengths: Mapping[str, sp.Expr], n: int, symbol: Symbols) -> SeparableChart:
    """Return the chart of a kind of web.

    Args:
        kind: as in ``Geometry.kind``.
        lengths: its constants.
        n: dimension.
        symbol: makes the symbol of a coordinate from its name and range (and renames it where it clashes).

    Raises:
        InternalError: a kind without a chart.
    """
    if kind == "cartesian":
        u = tuple(symbol(name, LINE) for name in ("xi", "eta", "zeta")[:n])
        return SeparableChart(u, (LINE,) * n, u, (sp.S.One,) * n)
    if kind.endswith("cylinder"):
        flat = {"circular": "polar", "elliptic": "elliptic", "parabolic": "parabolic"}[kind.split(maxsplit=1)[0]]
        base = _PLANE[flat](lengths, symbol)
        z = symbol("z", LINE)
        return SeparableChart(
            (*base.symbols, z), (*base.ranges, LINE), (*base.place, z), (*base.scale, sp.S.One), base.remark
        )
    known = {**_PLANE, **_SPACE}
    if kind not in known:
        raise InternalError(f"no chart of kind {kind}")
    return known[kind](lengths, symbol)


def _polar(_: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    r, θ = symbol("r", HALF), symbol("theta", ANGLE)
    return SeparableChart((r, θ), (HALF, ANGLE), (r * sp.cos(θ), r * sp.sin(θ)), (sp.S.One, r**2))


def _parabolic(_: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    u, v = symbol("u", LINE), symbol("v", LINE)
    h = u**2 + v**2
    return SeparableChart(
        (u, v), (LINE, LINE), ((u**2 - v**2) / 2, u * v), (h, h), f"({u}, {v}) and (−{u}, −{v}) are the same point"
    )


def _elliptic(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a, μ, ν = lengths["a"], symbol("mu", LINE), symbol("nu", ANGLE)
    h = a**2 * (sp.cosh(μ) ** 2 - sp.cos(ν) ** 2)
    place = (a * sp.cosh(μ) * sp.cos(ν), a * sp.sinh(μ) * sp.sin(ν))
    return SeparableChart((μ, ν), (LINE, ANGLE), place, (h, h), f"({μ}, {ν}) and (−{μ}, −{ν}) are the same point")


def _spherical(_: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    r, θ = symbol("r", HALF), symbol("theta", MERIDIAN)
    return _turned((r, θ), (HALF, MERIDIAN), (r * sp.sin(θ), r * sp.cos(θ)), (sp.S.One, r**2), symbol)


def _rotational_parabolic(_: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    u, v = symbol("u", HALF), symbol("v", HALF)
    return _turned((u, v), (HALF, HALF), (u * v, (u**2 - v**2) / 2), (u**2 + v**2, u**2 + v**2), symbol)


def _prolate(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a, μ, ν = lengths["a"], symbol("mu", HALF), symbol("nu", MERIDIAN)
    h = a**2 * (sp.cosh(μ) ** 2 - sp.cos(ν) ** 2)
    place = (a * sp.sinh(μ) * sp.sin(ν), a * sp.cosh(μ) * sp.cos(ν))
    return _turned((μ, ν), (HALF, MERIDIAN), place, (h, h), symbol)


def _oblate(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a, μ, ν = lengths["a"], symbol("mu", LINE), symbol("nu", MERIDIAN)
    h = a**2 * (sp.sinh(μ) ** 2 + sp.cos(ν) ** 2)
    place = (a * sp.cosh(μ) * sp.sin(ν), a * sp.sinh(μ) * sp.cos(ν))
    chart = _turned((μ, ν), (LINE, MERIDIAN), place, (h, h), symbol)
    return replace(chart, remark=f"({μ}, {ν}) and (−{μ}, pi − {ν}) are the same point")


def _turned(
    u: tuple[sp.Symbol, sp.Symbol],
    ranges: tuple[CoordinateRange, CoordinateRange],
    place: tuple[sp.Expr, sp.Expr],
    scale: tuple[sp.Expr, sp.Expr],
    symbol: Symbols,
) -> SeparableChart:
    """Rotate a half-plane (ρ, z) about the z axis."""
    φ, (ρ, z) = symbol("phi", ANGLE), place
    return SeparableChart((*u, φ), (*ranges, ANGLE), (ρ * sp.cos(φ), ρ * sp.sin(φ), z), (*scale, ρ**2))


def _rooted(constants: tuple[sp.Expr, ...], u: tuple[sp.Expr, ...], i: int) -> sp.Expr:
    """Return Π_k (a_i − u_k)/Π_{j≠i}(a_i − a_j)."""
    others = sp.prod([constants[i] - a for j, a in enumerate(constants) if j != i])
    return sp.prod([constants[i] - s for s in u]) / others


def _conical(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    e = tuple(lengths[f"e{i}"] for i in (1, 2, 3))
    ranges = (HALF, CoordinateRange(e[0], e[1]), CoordinateRange(e[1], e[2]))
    r, μ, ν = (symbol(name, where) for name, where in zip(("r", "mu", "nu"), ranges, strict=True))
    place = tuple(r * sp.sqrt(_rooted(e, (μ, ν), i)) for i in range(3))
    scale = tuple(r**2 * (other - s) / (4 * sp.prod([s - c for c in e])) for s, other in ((μ, ν), (ν, μ)))
    return SeparableChart((r, μ, ν), ranges, place, (sp.S.One, *scale), _OCTANT)


def _ellipsoidal(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a = tuple(lengths[f"a{i}"] for i in (1, 2, 3))
    ranges = (CoordinateRange(a[0], a[1]), CoordinateRange(a[1], a[2]), CoordinateRange(a[2]))
    u = tuple(symbol(name, where) for name, where in zip(("u", "v", "w"), ranges, strict=True))
    length = lengths["a"]
    place = tuple(length * sp.sqrt(-_rooted(a, u, i)) for i in range(3))
    scale = tuple(length**2 * sp.prod([s - o for o in u if o != s]) / (4 * sp.prod([s - c for c in a])) for s in u)
    return SeparableChart(u, ranges, place, scale, _OCTANT)


def _paraboloidal(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a, b, c = lengths["a"], lengths["b"], lengths["c"]
    ranges = (CoordinateRange(None, b), CoordinateRange(b, c), CoordinateRange(c))
    u = tuple(symbol(name, where) for name, where in zip(("u", "v", "w"), ranges, strict=True))
    y, z = (sp.sqrt(-_rooted((b, c), u, i)) for i in (0, 1))
    scale = tuple(a**2 * sp.prod([s - o for o in u if o != s]) / (4 * (s - b) * (s - c)) for s in u)
    return SeparableChart(
        u, ranges, (a * (sp.Add(*u) - b - c) / 2, a * y, a * z), scale, _OCTANT.replace("octant", "quarter")
    )


_PLANE = {"polar": _polar, "parabolic": _parabolic, "elliptic": _elliptic}
_SPACE = {
    "spherical": _spherical, "rotational parabolic": _rotational_parabolic, "prolate spheroidal": _prolate,
    "oblate spheroidal": _oblate, "conical": _conical, "ellipsoidal": _ellipsoidal, "paraboloidal": _paraboloidal,
}  # fmt: skip
