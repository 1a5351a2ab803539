"""Sines and cosines of a coordinate and a number together, put back: sin x cos c − cos x sin c = sin(x − c).

The field in which conditions are decided has sin x and cos x alone. A formula written in them loses what made it
short: 1/(1 + (2 sin((x − c)/2)/w)²) holds small numbers next to x = c, but its parts in sin x and cos x cancel.
"""

from __future__ import annotations

import sympy as sp
from sympy.simplify.fu import TR8, TR10i


def rejoined(e: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Return the same function with the sines and cosines of constants taken into those of q.

    A sum with one cosine, a + b cos θ, is written with the half angle that leaves the smaller constant.

    Args:
        q: the variable; other symbols are constants.
    """
    if not _has_angles_of_constants(e, q):
        return e
    joined = TR10i(e)
    return joined.replace(lambda part: part.is_Add and _has_angles_of_constants(part, q), lambda part: _one(part, q))


def _has_angles_of_constants(e: sp.Expr, q: sp.Symbol) -> bool:
    angles = e.atoms(sp.sin, sp.cos)
    return any(x.has(q) for x in angles) and not all(x.has(q) for x in angles)


def _one(e: sp.Add, q: sp.Symbol) -> sp.Expr:
    """Return a sum of products of sines and cosines as a sum of them; where only one holds q, by its half angle."""
    plain = sp.expand(TR8(e))
    waves = [x for x in plain.atoms(sp.sin, sp.cos) if x.has(q)]
    if len(waves) != 1:
        return min(plain, e, key=sp.count_ops)
    wave = waves[0]
    amplitude, rest = plain.coeff(wave), sp.expand(plain - plain.coeff(wave) * wave)
    if rest.has(q) or amplitude.has(q):
        return min(plain, e, key=sp.count_ops)
    half = sp.expand((wave.args[0] - (sp.pi / 2 if isinstance(wave, sp.sin) else 0)) / 2)
    sine, cosine = -2 * amplitude * sp.sin(half) ** 2, 2 * amplitude * sp.cos(half) ** 2
    constant, moving = min((rest + amplitude, sine), (rest - amplitude, cosine), key=lambda form: _size(form[0]))
    return constant + moving


def _size(constant: sp.Expr) -> tuple[float, int]:
    return (abs(float(constant)) if constant.is_number else 0.0, sp.count_ops(constant))
