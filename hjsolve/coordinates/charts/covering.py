"""Charts that cover all of space without ends: the motion passes coordinate planes and axes of the web as anywhere.

The roots of a confocal family rest at their ends, u = a₁ … a₂, where a motion crosses a coordinate plane and the signs
of x, y, z are lost. With the amplitudes

    ellipsoidal   u = a₂ − (a₂ − a₁) cos²χ,  v = a₂ + (a₃ − a₂) sin²ψ,  w = a₃ + (a₃ − a₂) sinh²μ
    conical       μ = e₂ − (e₂ − e₁) cos²χ,  ν = e₂ + (e₃ − e₂) sin²ψ
    paraboloidal  u = b − (c − b) sinh²μ,    v = b + (c − b) sin²ψ,     w = c + (c − b) sinh²ν

X, Y, Z are smooth functions of full angles and whole lines, and h² is a sum of squares: no difference of roots is left
that could cancel. Every point has two sets of coordinates or more; the separated equations do not mind. The plane
elliptic and parabolic coordinates of ``charts`` are of this kind already (Moon, Spencer, Field Theory Handbook).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from hjsolve.coordinates.charts.charts import ANGLE, HALF, LINE, SeparableChart, Symbols, chart


def covering_chart(kind: str, lengths: Mapping[str, sp.Expr], n: int, symbol: Symbols) -> SeparableChart:
    """Return the chart of a kind of web in coordinates without ends, as far as they can have none.

    Args:
        kind: as in ``Geometry.kind``.
        lengths: its constants.
        n: dimension.
        symbol: makes the symbol of a coordinate from its name and range (and renames it where it clashes).

    Raises:
        InternalError: a kind without a chart.
    """
    if kind in _COVERING:
        return _COVERING[kind](lengths, symbol)
    plain = chart(kind, lengths, n, symbol)
    if kind not in ("elliptic", "elliptic cylinder", "prolate spheroidal"):
        return plain
    return replace(plain, scale=tuple(map(_sum_of_squares, plain.scale)))


def _sum_of_squares(h: sp.Expr) -> sp.Expr:
    """Write cosh²μ − cos²ν as sinh²μ + sin²ν, which does not cancel at the foci."""
    squares = {f**2: 1 + sp.sinh(f.args[0]) ** 2 for f in h.atoms(sp.cosh)}
    squares |= {f**2: 1 - sp.sin(f.args[0]) ** 2 for f in h.atoms(sp.cos)}
    return sp.expand(h.subs(squares)) if squares else h


def _conical(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    e1, e2, e3 = (lengths[f"e{i}"] for i in (1, 2, 3))
    r, χ, ψ = symbol("r", HALF), symbol("chi", ANGLE), symbol("psi", ANGLE)
    low, high = (e2 - e1) * sp.cos(χ) ** 2, (e3 - e2) * sp.sin(ψ) ** 2
    below, above = e3 - e2 + low, e2 - e1 + high
    place = (
        r * sp.sin(χ) * sp.sqrt(above / (e3 - e1)),
        r * sp.cos(χ) * sp.sin(ψ),
        r * sp.cos(ψ) * sp.sqrt(below / (e3 - e1)),
    )
    h = r**2 * (low + high)
    return SeparableChart(
        (r, χ, ψ), (HALF, ANGLE, ANGLE), place, (sp.S.One, h / below, h / above), _twice(χ, ψ, "pi − {}", "−{}")
    )


def _ellipsoidal(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a, (a1, a2, a3) = lengths["a"], (lengths[f"a{i}"] for i in (1, 2, 3))
    χ, ψ, μ = symbol("chi", ANGLE), symbol("psi", ANGLE), symbol("mu", LINE)
    low, middle, inner = (a2 - a1) * sp.cos(χ) ** 2, (a3 - a2) * sp.sin(ψ) ** 2, (a3 - a2) * sp.cos(ψ) ** 2
    high = (a3 - a2) * sp.sinh(μ) ** 2
    below, above, outside = a3 - a2 + low, a2 - a1 + middle, a3 - a1 + high
    place = (
        a * sp.sin(χ) * sp.sqrt(above * outside / (a3 - a1)),
        a * sp.cos(χ) * sp.sin(ψ) * sp.cosh(μ) * sp.sqrt(a3 - a2),
        a * sp.cos(ψ) * sp.sinh(μ) * sp.sqrt((a3 - a2) * below / (a3 - a1)),
    )
    vu, wv, wu = low + middle, inner + high, below + high
    scale = (a**2 * vu * wu / below, a**2 * vu * wv / above, a**2 * wu * wv / outside)
    return SeparableChart((χ, ψ, μ), (ANGLE, ANGLE, LINE), place, scale, _twice(χ, ψ, "pi − {}", "−{}"))


def _paraboloidal(lengths: Mapping[str, sp.Expr], symbol: Symbols) -> SeparableChart:
    a, b, c = lengths["a"], lengths["b"], lengths["c"]
    d = c - b
    μ, ψ, ν = symbol("mu", LINE), symbol("psi", ANGLE), symbol("nu", LINE)
    place = (
        a * (b + d * (sp.sin(ψ) ** 2 + sp.sinh(ν) ** 2 - sp.sinh(μ) ** 2)) / 2,
        a * d * sp.sinh(μ) * sp.sin(ψ) * sp.cosh(ν),
        a * d * sp.cosh(μ) * sp.cos(ψ) * sp.sinh(ν),
    )
    vu, wv = sp.sinh(μ) ** 2 + sp.sin(ψ) ** 2, sp.cos(ψ) ** 2 + sp.sinh(ν) ** 2
    wu = 1 + sp.sinh(μ) ** 2 + sp.sinh(ν) ** 2
    scale = tuple(a**2 * d**2 * h for h in (vu * wu, vu * wv, wu * wv))
    return SeparableChart((μ, ψ, ν), (LINE, ANGLE, LINE), place, scale, _twice(μ, ψ, "−{}", "−{}"))


def _twice(one: sp.Symbol, other: sp.Symbol, first: str, second: str) -> str:
    return f"({one}, {other}) and ({first.format(one)}, {second.format(other)}) are the same point"


_COVERING = {"conical": _conical, "ellipsoidal": _ellipsoidal, "paraboloidal": _paraboloidal}
