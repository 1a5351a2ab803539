"""Potentials that separate in a random web, hidden: turned, shifted, scaled, and written out in x, y and z.

The webs are written here in distances and coordinates of their frames, without any chart of hjsolve. Functions of one
variable are polynomials, exponentials, logarithms, roots and rational ones; two thirds of the potentials are closed by
a quadratic or quartic term, so that motions are bounded.
"""

from __future__ import annotations

import random
from functools import cache

import sympy as sp

_TURNS = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (0, 1, 1))
PLANE = ("cartesian", "polar", "parabolic", "elliptic")
SPACE = (
    "cartesian", "circular cylinder", "parabolic cylinder", "elliptic cylinder", "spherical", "prolate spheroidal",
    "oblate spheroidal", "rotational parabolic", "ellipsoidal",
)  # fmt: skip


@cache
def made(number: int) -> tuple[int, str, str]:
    """Return the potential of a number: how many coordinates, the web it was made in, and the text."""
    dice = random.Random(f"hidden web {number}")
    count = dice.choice((2, 3))
    kind = dice.choice((PLANE, SPACE)[count - 2])
    place = _frame(dice, count)
    return count, kind, str((_in_plane if count == 2 else _in_space)(dice, kind, place))


def _rational(dice: random.Random, most: int = 20) -> sp.Rational:
    return sp.Rational(dice.choice((-1, 1)) * dice.randint(1, most), 10)


def _frame(dice: random.Random, count: int) -> list[sp.Expr]:
    """X, Y (and Z): what is turned about one axis after the other, shifted and scaled, all by rational numbers."""
    place = sp.Matrix([s - _rational(dice) / 2 for s in sp.symbols("x y z", real=True)[:count]])
    for k, m in ((0, 1),) if count == 2 else ((0, 1), (1, 2)):
        a, b, c = dice.choice(_TURNS)
        turn = sp.eye(count)
        turn[k, k], turn[k, m], turn[m, k], turn[m, m] = (sp.Rational(e, c) for e in (a, b, -b, a))
        place = turn * place
    unit = sp.Rational(dice.randint(5, 15), 10)
    return [sp.expand(unit * e) for e in place]


def _function(dice: random.Random, t: sp.Expr, closed: int = 0) -> sp.Expr:
    """Return a random function of one variable; with ``closed`` the power of t that makes it grow."""
    kind = dice.choice(("polynomial", "exponential", "rational", "root", "logarithm", "none"))
    a, b = _rational(dice, 10), sp.Rational(dice.randint(5, 20), 10)
    told = {
        "polynomial": a * t + _rational(dice, 10) * t**2 / 2,
        "exponential": a * sp.exp(-b * t / 2),
        "rational": a / (b + t**2),
        "root": a * sp.sqrt(b + t**2),
        "logarithm": a * sp.log(b + t**2),
        "none": sp.S.Zero,
    }[kind]
    return told + (t**closed * abs(_rational(dice, 10)) if closed else 0)


def _split(dice: random.Random, far: sp.Expr, near: sp.Expr, below: sp.Expr, closed: int) -> sp.Expr:
    return (_function(dice, far, closed) + _function(dice, near)) / below


def _in_plane(dice: random.Random, kind: str, place: list[sp.Expr]) -> sp.Expr:
    X, Y = place
    closed = dice.random() < 2 / 3
    r = sp.sqrt(sp.expand(X**2 + Y**2))
    if kind == "cartesian":
        return _function(dice, X, 4 * closed) + _function(dice, Y, 2 * closed)
    if kind == "polar":
        return (
            _function(dice, r, 2 * closed) - abs(_rational(dice)) / r + (3 + X / r + _rational(dice, 10) * Y / r) / r**2
        )
    if kind == "parabolic":
        return _split(dice, r + X, r - X, r, 3 * closed)
    one, other = (sp.sqrt(sp.expand((X + s) ** 2 + Y**2)) for s in (-1, 1))
    return _split(dice, one + other, one - other, one * other, 3 * closed)


def _in_space(dice: random.Random, kind: str, place: list[sp.Expr]) -> sp.Expr:
    X, Y, Z = place
    closed = dice.random() < 2 / 3
    if kind == "cartesian":
        return sum((_function(dice, e, 2 * closed) for e in place), sp.S.Zero)
    if kind.endswith("cylinder"):
        shape = kind.removesuffix(" cylinder")
        return _in_plane(dice, "polar" if shape == "circular" else shape, [X, Y]) + _function(dice, Z, 2 * closed)
    flat, r2 = sp.expand(X**2 + Y**2), sp.expand(X**2 + Y**2 + Z**2)
    wall = abs(_rational(dice)) * sp.Rational(dice.choice((0, 1)), 10) / flat
    if kind == "ellipsoidal":
        a, b, c = dice.sample(range(1, 9), 3)
        return r2**2 * abs(_rational(dice, 10)) + sp.expand(a * X**2 + b * Y**2 + c * Z**2) / 2
    r = sp.sqrt(r2)
    if kind == "spherical":
        return _function(dice, r, 2 * closed) + _function(dice, Z / r) / r2 + 2 / r2 + wall
    if kind == "rotational parabolic":
        return _split(dice, r + Z, r - Z, r, 3 * closed) + wall
    if kind == "prolate spheroidal":
        low, high = (sp.sqrt(sp.expand(flat + (Z + s) ** 2)) for s in (-1, 1))
        return _split(dice, low + high, low - high, low * high, 3 * closed) + wall
    spread = sp.sqrt((r2 - 1) ** 2 + 4 * sp.expand(Z**2))
    return _function(dice, sp.sqrt((r2 - 1 + spread) / 2), 4 * closed) / spread + wall
