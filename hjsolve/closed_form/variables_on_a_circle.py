"""Variables for functions of sin κq and cos κq: cos, sin, tan and cot of κq or of its half.

Which of them is monotone depends on the domain: on a turn of an angle, or of a line on which P² is periodic, the half
about a place; on a part of a turn the one that is monotone there; between poles at cos κq = 0 the sine.
Along an angle a + b cos nq + c sin nq has n equal wells, and the half sine about each of them (DLMF 22.19(i)).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.closed_form.change_of_variable import (
    Substitution,
    condition_on,
    extended_domain_ends,
    possible_signs,
    scaled_end,
)
from hjsolve.mechanics.coordinates_and_parameters import Coordinate

S, C = sp.Symbol("_S", real=True), sp.Symbol("_C", real=True)
_CIRCULAR = (sp.sin, sp.cos, sp.tan)
_MOST_WELLS = 12
"""Equal wells along an angle of which each has a variable of its own."""


def circular_variables(square: sp.Expr, coordinate: Coordinate, x: sp.Symbol) -> Iterator[Substitution]:
    """Yield sines, cosines and tangents in which P² is rational.

    Args:
        square: P²(q), made of circular functions of one argument and of its multiples.
        coordinate: q, with its domain.
        x: the symbol of the variable.
    """
    q = coordinate.symbol
    lower, upper = extended_domain_ends(coordinate)
    line, angle = lower is -sp.oo and upper is sp.oo, coordinate.domain.kind == "angle"
    middle, centred = _about_middle(square, q) if line or angle else (sp.S.Zero, square)
    if middle != 0:  # -cos(x - d) is a pendulum about d
        for one in circular_variables(centred, coordinate, x):
            yield replace(one, place=one.place.subs(q, q - middle), inverse=one.inverse + middle)
        return
    found = _base(square, q, _CIRCULAR)
    if found is None:
        return
    known = [found]
    # the whole angle before its half: cos x has half the degree of cos² (x/2)
    while (doubled := _of_whole_angle(*known[-1])) is not None and (line or len(known) < 2):
        known.append(doubled)
    wells = _number_of_wells(known[-1][0]) if angle else 1
    if wells > 1:
        yield from _half_sine(known[-1][1], _Turn(q, x, known[-1][0], wells))
    if line or (angle and known[-1][0] == 1):
        known = known[-1:]
    none = True
    if line or (not angle and found[0].free_symbols):
        yield from _between_poles(*found, q, x)
    for κ, function in known:
        for variable in _of_multiples(function, κ, coordinate, x, turn=line or (angle and κ == 1)):
            none = False
            yield variable
    if none and wells > 1:
        yield from _on_a_turn(known[-1][1], _Turn(q, x, known[-1][0], wells), _even(known[-1][1], S, C))
    if (
        none and found[0].free_symbols
    ):  # how many turns are in the domain depends on letters: one about zero is looked at
        while (doubled := _of_whole_angle(*known[-1])) is not None:
            known.append(doubled)
        κ, function = known[-1]
        yield from _of_multiples(function, κ, coordinate, x, turn=True)


def _about_middle(square: sp.Expr, q: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """Return the place from which all arguments are multiples of q, and P² seen from there; 0 where there is none."""
    atoms = [a for a in square.atoms(*_CIRCULAR) if a.has(q)]
    slopes = [sp.diff(a.args[0], q) for a in atoms]
    if not atoms or any(slope.has(q) for slope in slopes):
        return sp.S.Zero, square
    offsets = [sp.expand(a.args[0] - slope * q) for a, slope in zip(atoms, slopes, strict=True)]
    middle = sp.cancel(-offsets[0] / slopes[0])
    if any(sp.cancel(δ + slope * middle) != 0 for δ, slope in zip(offsets, slopes, strict=True)):
        return sp.S.Zero, square
    return middle, square.xreplace({a: a.func(slope * q) for a, slope in zip(atoms, slopes, strict=True)})


def _number_of_wells(κ: sp.Expr) -> int:
    """Return how often P² repeats itself along an angle: cos 3q three times; 1 where that is not known."""
    return int(κ) if κ.is_Integer and κ <= _MOST_WELLS else 1


def _of_multiples(
    function: sp.Expr, κ: sp.Expr, coordinate: Coordinate, x: sp.Symbol, *, turn: bool
) -> Iterator[Substitution]:  # fmt: skip
    """Yield a function of sin κq and cos κq."""
    q = coordinate.symbol
    lower, upper = extended_domain_ends(coordinate)
    w0, w1 = scaled_end(κ, lower), scaled_end(κ, upper)
    w = κ * q
    even_s, even_c = _even(function, S, C), _even(function, C, S)
    if turn:
        for side in possible_signs(κ):
            yield from _on_a_turn(function.subs(S, side * S), _Turn(q, x, side * κ), even_s)
        return
    if _inside(w0, w1, sp.S.Zero, sp.pi) and even_s is not None:
        yield Substitution(
            x, sp.cos(w), sp.acos(x) / κ, κ**2 * (1 - x**2), even_s.subs(C, x), sp.cos(w1), sp.cos(w0), False
        )
    elif _inside(w0, w1, -sp.pi / 2, sp.pi / 2) and even_c is not None:
        yield Substitution(
            x, sp.sin(w), sp.asin(x) / κ, κ**2 * (1 - x**2), even_c.subs(S, x), sp.sin(w0), sp.sin(w1), True
        )
    elif even_s is not None and _inside(w0, w1, -sp.pi, sp.pi):  # 1 + cos w = 2 cos² (w/2), however it was typed
        slope = κ**2 * (1 - x**2) / 4
        low, high = sp.sin(w0 / 2), sp.sin(w1 / 2)
        yield Substitution(x, sp.sin(w / 2), 2 * sp.asin(x) / κ, slope, even_s.subs(C, 1 - 2 * x**2), low, high, True)
    elif even_s is not None and _inside(w0, w1, sp.S.Zero, 2 * sp.pi):
        slope = κ**2 * (1 - x**2) / 4
        low, high = sp.cos(w1 / 2), sp.cos(w0 / 2)
        yield Substitution(x, sp.cos(w / 2), 2 * sp.acos(x) / κ, slope, even_s.subs(C, 2 * x**2 - 1), low, high, False)
    if even_s is None and _inside(w0, w1, sp.S.Zero, 2 * sp.pi):
        # x = cot(w/2): sin w = 2x/(1 + x²), cos w = (x² − 1)/(x² + 1)
        half = function.subs({S: 2 * x / (1 + x**2), C: (x**2 - 1) / (1 + x**2)}, simultaneous=True)
        low, high = -_tan((w1 - sp.pi) / 2), -_tan((w0 - sp.pi) / 2)
        place, inverse = sp.cot(w / 2), (sp.pi - 2 * sp.atan(x)) / κ
        yield Substitution(x, place, inverse, κ**2 * (1 + x**2) ** 2 / 4, half, low, high, False)
    if _inside(w0, w1, -sp.pi, sp.pi):
        half = function.subs({S: 2 * x / (1 + x**2), C: (1 - x**2) / (1 + x**2)}, simultaneous=True)
        yield Substitution(
            x, sp.tan(w / 2), 2 * sp.atan(x) / κ, κ**2 * (1 + x**2) ** 2 / 4, half, _tan(w0 / 2), _tan(w1 / 2), True
        )


def _between_poles(κ: sp.Expr, function: sp.Expr, q: sp.Symbol, x: sp.Symbol) -> Iterator[Substitution]:
    """Yield sin κq where cos κq = 0 ends the motion on both sides of zero."""
    even = _even(function, C, S)
    if even is None or any(sp.fraction(sp.cancel(even))[1].subs(S, side) != 0 for side in (1, -1)):
        return
    one = sp.S.One
    slope, w = κ**2 * (1 - x**2), κ * q
    yield Substitution(x, sp.sin(w), sp.asin(x) / κ, slope, even.subs(S, x), -one, one, True, condition=condition_on(κ))


def _on_a_turn(function: sp.Expr, scale: _Turn, even: sp.Expr | None) -> Iterator[Substitution]:
    """Of an angle, or of a line along which P² is periodic: sines of the half about a place, tangents of the half."""
    x = scale.x
    yield from _half_sine(function, scale)
    # even in sin w: cos w = 1 − 2 sin² (w/2) about the lowest place, 2 sin² − 1 about the highest
    if even is not None and (not even.is_polynomial(C) or sp.degree(even, C) > 1):
        for middle, sign in ((sp.S.Zero, 1), (sp.pi, -1)):
            for well in scale.middles(middle):
                yield scale.about(well, even.subs(C, sign * (1 - 2 * x**2)))
    half = function.subs({S: 2 * x / (1 + x**2), C: (1 - x**2) / (1 + x**2)}, simultaneous=True)
    for well in scale.middles(sp.S.Zero):
        yield scale.tangent(well, half)
    # about the opposite place: a libration about π is one interval of x
    half = function.subs({S: -2 * x / (1 + x**2), C: (x**2 - 1) / (1 + x**2)}, simultaneous=True)
    for well in scale.middles(sp.pi):
        yield scale.tangent(well, half)


def _tan(w: sp.Expr) -> sp.Expr:
    value = sp.tan(w)
    if value is sp.zoo:
        return sp.oo if sp.sign(w) == 1 else -sp.oo
    return value


@dataclass(frozen=True)
class _Turn:
    """A coordinate over a turn.

    Attributes:
        q: the coordinate.
        x: the variable.
        κ: 2π over the turn; positive.
        wells: how many such turns make up one of the coordinate: 1 but for an angle.
    """

    q: sp.Symbol
    x: sp.Symbol
    κ: sp.Expr
    wells: int = 1

    def middles(self, δ: sp.Expr) -> list[sp.Expr]:
        """Return δ, and so many turns more as there are wells."""
        return [δ + 2 * sp.pi * k for k in range(self.wells)]

    def tangent(self, δ: sp.Expr, function: sp.Expr) -> Substitution:
        """X = tan((κq − δ)/2).

        Args:
            δ: the middle of the turn.
            function: P² in x.
        """
        κ, x = self.κ, self.x
        slope, inverse, place = κ**2 * (1 + x**2) ** 2 / 4, (δ + 2 * sp.atan(x)) / κ, sp.tan((κ * self.q - δ) / 2)
        turn, more = 2 * sp.pi / κ, condition_on(κ)
        return Substitution(x, place, inverse, slope, function, -sp.oo, sp.oo, True, True, turn, more, self.wells)

    def about(self, δ: sp.Expr, function: sp.Expr) -> Substitution:
        """X = sin((κq − δ)/2).

        Args:
            δ: the middle of the turn.
            function: P² in x.
        """
        κ, x = self.κ, self.x
        slope, inverse, place = κ**2 * (1 - x**2) / 4, (δ + 2 * sp.asin(x)) / κ, sp.sin((κ * self.q - δ) / 2)
        turn, one = 2 * sp.pi / κ, sp.S.One
        more = condition_on(κ)
        return Substitution(x, place, inverse, slope, function, -one, one, True, True, turn, more, self.wells)


def _half_sine(function: sp.Expr, scale: _Turn) -> Iterator[Substitution]:
    """Yield a + b cos w + c sin w = a + d cos(w − δ), d > 0: x = sin((w − δ)/2), as for the pendulum."""
    if not function.is_polynomial(S, C):
        return
    terms = sp.Poly(function, S, C)
    if any(sum(m) > 1 for m in terms.monoms()):
        return
    a, b, c = (terms.coeff_monomial(m) for m in (1, C, S))
    if c == 0:
        δ, d = sp.S.Zero, b
    elif b == 0:
        δ, d = sp.pi / 2, c
    else:
        common = _of_known_sign(sp.gcd(b, c))
        cosine, sine = sp.cancel(b / common), sp.cancel(c / common)
        δ, d = sp.atan2(sine, cosine), common * sp.sqrt(sp.expand(sine**2 + cosine**2))
    if d.is_negative:
        δ, d = δ + sp.pi, -d
    for middle, size in ((δ, d), (δ + sp.pi, -d)):  # about either place of rest
        for well in scale.middles(middle):
            yield scale.about(well, a + size * (1 - 2 * scale.x**2))


def _of_known_sign(product: sp.Expr) -> sp.Expr:
    """Return the part of a product whose sign is known, made positive: squares, and what is positive or negative."""
    found = sp.S.One
    for factor in sp.Mul.make_args(product):
        base, power = factor.as_base_exp()
        known = factor.is_positive or factor.is_negative
        found *= factor if known else base ** (power - power % 2) if power.is_Integer else 1
    return -found if found.is_negative else found


def _base(
    square: sp.Expr, q: sp.Symbol, functions: tuple[type[sp.Function], ...]
) -> tuple[sp.Expr, sp.Expr] | None:  # fmt: skip
    """κ, and the function written in S = sin κq and C = cos κq; None where the arguments are no multiples of one."""
    atoms = [a for a in square.atoms(*functions) if a.has(q)]
    slopes = [sp.diff(a.args[0], q) for a in atoms]
    if not atoms or any(slope.has(q) for slope in slopes):
        return None
    first = slopes[0]
    ratios = [sp.cancel(slope / first) for slope in slopes]
    if not all(r.is_Rational for r in ratios):
        return None
    step = ratios[0]
    # sin 2x and sin 3x are functions of sin x and cos x: κ is the greatest common divisor of the multiples
    for r in ratios[1:]:
        step = sp.gcd(step, r)
    κ = abs(step) * first
    if κ.is_negative:
        κ = -κ
    u = sp.Dummy("u", real=True)
    table = {}
    for a, slope in zip(atoms, slopes, strict=True):
        n, δ = sp.cancel(slope / κ), sp.expand(a.args[0] - slope * q)
        sine, cosine = sp.expand_trig(sp.sin(n * u)), sp.expand_trig(sp.cos(n * u))
        s, c = sine * sp.cos(δ) + cosine * sp.sin(δ), cosine * sp.cos(δ) - sine * sp.sin(δ)
        table[a] = {sp.sin: s, sp.cos: c, sp.tan: s / c}[a.func]
    written = square.xreplace(table).xreplace({sp.sin(u): S, sp.cos(u): C})
    return None if written.has(u) or written.has(q) else (κ, _on_the_circle(written))


def _on_the_circle(function: sp.Expr) -> sp.Expr:
    """Return a rational function of S and C with S² = 1 − C²: the same however it was typed."""
    top, bottom = (
        sp.Poly(sp.rem(sp.expand(part), S**2 + C**2 - 1, S), S, C) for part in sp.fraction(sp.together(function))
    )
    if bottom.degree(S) > 0:
        conjugate = sp.Poly(bottom.as_expr().subs(S, -S), S, C)
        circle = sp.Poly(S**2 + C**2 - 1, S, C)
        top, bottom = (sp.rem((part * conjugate), circle) for part in (top, bottom))
    return sp.cancel(top.as_expr() / bottom.as_expr())


def _of_whole_angle(κ: sp.Expr, function: sp.Expr) -> tuple[sp.Expr, sp.Expr] | None:
    """Sines of 2κq for those of κq, where half a turn changes nothing: 4 cos² (x/2) is 2 + 2 cos x; None elsewhere."""
    top, bottom = (sp.Poly(part, S, C) for part in sp.fraction(function))
    odd = {(i + j) % 2 for part in (top, bottom) for i, j in part.monoms()}
    if len(odd) > 1:
        return None
    if odd == {1}:
        top, bottom = (part * sp.Poly(C, S, C) for part in (top, bottom))
    above, below = (
        sp.Add(*(c * (S / 2) ** i * ((1 + C) / 2) ** ((j - i) // 2) for (i, j), c in part.terms()))
        for part in (top, bottom)
    )
    return 2 * κ, _on_the_circle(above / below)


def _even(function: sp.Expr, odd: sp.Symbol, kept: sp.Symbol) -> sp.Expr | None:
    """Return the function with odd² = 1 − kept²; None where an odd power is left."""
    top, bottom = sp.fraction(sp.together(function))
    parts = []
    for part in (top, bottom):
        if not part.is_polynomial(S, C):
            return None
        reduced = sp.rem(sp.expand(part), odd**2 + kept**2 - 1, odd)
        parts.append(sp.expand(reduced))
    top, bottom = parts
    if top.has(odd) and bottom.has(odd):
        conjugate = bottom.subs(odd, -odd)
        top, bottom = (sp.rem(sp.expand(part * conjugate), odd**2 + kept**2 - 1, odd) for part in (top, bottom))
    return None if top.has(odd) or bottom.has(odd) else top / bottom


def _inside(w0: sp.Expr, w1: sp.Expr, low: sp.Expr, high: sp.Expr) -> bool:
    return bool((w0 - low).is_nonnegative and (high - w1).is_nonnegative)
