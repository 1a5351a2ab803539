"""Variables x = φ(q) in which a squared momentum P²(q) is a rational function.

With G(x) = φ′(q)², every integral of a separated solution is ∫ N dq/√P² = ∫ N dx/√(P² G): rational in x but for one
square root, where both P² and G are rational in x. Candidates: q, q², 1/q, √(q² + c), and of sines, hyperbolic
sines and exponentials of multiples of one argument κq: cos, sin, tan of the half, sin of the half shifted, cosh, sinh,
tanh, tanh of the half, exp, of κ(q − b) where all arguments have the same b; (q + c)^(1/n), and e^u with q = a sinh u.
Each is used only where it is monotone on the whole domain of the coordinate, or on a turn of an angle, or of a line on
which P² is periodic. Where the sign of κ is open, each sign is a case of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.mechanics.coordinates_and_parameters import Coordinate

S, C, X = sp.Symbol("_S", real=True), sp.Symbol("_C", real=True), sp.Symbol("_X", positive=True)
HYPERBOLIC = {
    sp.sinh: lambda w: (sp.exp(w) - sp.exp(-w)) / 2,
    sp.cosh: lambda w: (sp.exp(w) + sp.exp(-w)) / 2,
    sp.tanh: lambda w: (sp.exp(w) - sp.exp(-w)) / (sp.exp(w) + sp.exp(-w)),
}


@dataclass(frozen=True, repr=False)
class Substitution(Shown):
    """A variable x = φ(q), monotone on the domain of q.

    Attributes:
        x: the variable.
        place: φ(q).
        inverse: q as a function of x.
        slope_squared: G(x) = φ′(q)².
        function: P² as a function of x.
        lower: the lower end of the values of x, ±oo allowed.
        upper: the upper end.
        increasing: whether x grows with q.
        closed: whether x runs over its whole range while q makes one turn: a rotation is then the whole range.
        turn: how long a turn is, in q.
        condition: positive where the variable is that; 1 where it is so for every value of the letters.
    """

    x: sp.Symbol
    place: sp.Expr
    inverse: sp.Expr
    slope_squared: sp.Expr
    function: sp.Expr
    lower: sp.Expr
    upper: sp.Expr
    increasing: bool
    closed: bool = False
    turn: sp.Expr = 2 * sp.pi
    condition: sp.Expr = sp.S.One


def known_substitutions(square: sp.Expr, coordinate: Coordinate, x: sp.Symbol) -> Iterator[Substitution]:
    """Every variable known here in which a squared momentum is rational.

    Args:
        square: P²(q).
        coordinate: q, with its domain.
        x: the symbol to use for the variable.
    """
    q = coordinate.symbol
    lower, upper = extended_domain_ends(coordinate)
    inner = [a for a in square.atoms(sp.Function, sp.Pow) if a.has(q) and not _plain(a)]
    if not inner:
        yield from _algebraic(square, q, lower, upper, x)
    elif all(isinstance(a, sp.Pow) for a in inner):
        yield from _with_root(square, q, inner, lower, upper, x)
        yield from _with_root_on_a_line(square, q, inner, lower, upper, x)
        yield from _rational_powers(square, q, inner, lower, upper, x)
    elif all(a.func in (sp.sin, sp.cos, sp.tan) for a in inner):
        yield from _trigonometric(square, coordinate, x)
    elif all(a.func in (sp.sinh, sp.cosh, sp.tanh, sp.exp) or isinstance(a, sp.exp) for a in inner):
        yield from _hyperbolic(square, q, lower, upper, x)


def extended_domain_ends(coordinate: Coordinate) -> tuple[sp.Expr, sp.Expr]:
    """Return the ends of a domain as extended real numbers; one turn about zero of an angle."""
    domain = coordinate.domain
    if domain.kind == "angle":
        return -sp.pi, sp.pi
    return (
        -sp.oo if domain.lower is None else domain.lower,
        sp.oo if domain.upper is None else domain.upper,
    )


def _plain(atom: sp.Expr) -> bool:
    return isinstance(atom, sp.Pow) and bool(atom.exp.is_Integer)


# -------------------------------------------------------------------------------------------- powers
def _algebraic(
    square: sp.Expr, q: sp.Symbol, lower: sp.Expr, upper: sp.Expr, x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    one = sp.S.One
    yield Substitution(x, q, x, one, square.subs(q, x), lower, upper, True)
    if not (lower.is_nonnegative or upper.is_nonpositive):
        return
    grows, sign = bool(lower.is_nonnegative), 1 if lower.is_nonnegative else -1
    z = sp.Dummy("z", positive=True)
    halved = sp.cancel(square).subs(q, sp.sqrt(z)) if sp.cancel(square - square.subs(q, -q)) == 0 else None
    if halved is not None:
        low, high = (lower, upper) if grows else (upper, lower)
        even = sp.powdenest(halved, force=True).subs(z, x)
        yield Substitution(x, q**2, sign * sp.sqrt(x), 4 * x, even, low**2, high**2, grows)
    if grows and lower == 0:
        top = sp.S.Zero if upper is sp.oo else 1 / upper
        yield Substitution(x, 1 / q, 1 / x, x**4, square.subs(q, 1 / x), top, sp.oo, False)


def _with_root(
    square: sp.Expr, q: sp.Symbol, roots: list[sp.Expr], lower: sp.Expr, upper: sp.Expr, x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    """One root √(q² + c), q of one sign: x is the root itself."""
    inside = {root.base for root in roots}
    if len(inside) != 1 or any(sp.denom(root.exp) != 2 for root in roots):
        return
    (radicand,) = inside
    if not radicand.is_polynomial(q) or sp.degree(radicand, q) != 2 or not lower.is_nonnegative:
        return
    c2, c1, c0 = sp.Poly(radicand, q).all_coeffs()
    if c1 != 0 or not c2.is_positive:
        return
    y = sp.Dummy("y", positive=True)
    plain = square.xreplace({root: y ** (2 * root.exp) for root in roots})
    even = sp.cancel(plain)
    if sp.cancel(even - even.subs(q, -q)) != 0:
        return
    function = sp.cancel(sp.powdenest(even.subs(q, sp.sqrt((y**2 - c0) / c2)), force=True)).subs(y, x)
    if function.has(q):
        return
    low = sp.sqrt(radicand.subs(q, lower))
    high = sp.oo if upper is sp.oo else sp.sqrt(radicand.subs(q, upper))
    slope = c2 * (x**2 - c0) / x**2
    yield Substitution(x, sp.sqrt(radicand), sp.sqrt((x**2 - c0) / c2), slope, function, low, high, True)


def _with_root_on_a_line(
    square: sp.Expr, q: sp.Symbol, roots: list[sp.Expr], lower: sp.Expr, upper: sp.Expr, x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    """One root √(q² + c), q of both signs: x = q + √(q² + c), Euler's."""
    inside = {root.base for root in roots}
    if len(inside) != 1 or any(sp.denom(root.exp) != 2 for root in roots) or lower.is_nonnegative:
        return
    (radicand,) = inside
    if not radicand.is_polynomial(q) or sp.degree(radicand, q) != 2:
        return
    c2, c1, c0 = sp.Poly(radicand, q).all_coeffs()
    if c1 != 0 or not c2.is_positive or (not (c0 / c2).is_positive and (c0 / c2).is_nonnegative is not True):
        return
    c, y = sp.cancel(c0 / c2), sp.Dummy("y", positive=True)
    place, root = (y - c / y) / 2, (y + c / y) / 2
    table = {r: (sp.sqrt(c2) * root) ** (2 * r.exp) for r in roots}
    function = sp.cancel(sp.together(square.xreplace(table).subs(q, place))).subs(y, x)
    if function.has(q):
        return
    euler = q + sp.sqrt(q**2 + c)
    low, high = (
        (sp.S.Zero if lower is -sp.oo else euler.subs(q, lower)),
        (sp.oo if upper is sp.oo else euler.subs(q, upper)),
    )
    yield Substitution(x, euler, place.subs(y, x), (x / root.subs(y, x)) ** 2, function, low, high, True)


def _rational_powers(
    square: sp.Expr, q: sp.Symbol, powers: list[sp.Expr], lower: sp.Expr, upper: sp.Expr, x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    """Fractional powers of multiples of q + c > 0: x = (q + c)^(1/n)."""
    base = powers[0].base
    linear = base.is_polynomial(q) and sp.degree(base, q) == 1 and all(p.exp.is_Rational for p in powers)
    if lower is -sp.oo or not linear:
        return
    shift = sp.cancel(base.subs(q, 0) / sp.diff(base, q))
    factors, start = {power: sp.cancel(power.base / (q + shift)) for power in powers}, lower + shift
    n = sp.ilcm(1, *(int(p.exp.q) for p in powers))
    if n == 1 or start.is_negative or any(f.has(q) for f in factors.values()):
        return
    y = sp.Dummy("y", positive=True)
    table = {p: f**p.exp * y ** (n * p.exp) for p, f in factors.items()}
    function = square.xreplace(table).subs(q, y**n - shift).subs(y, x)
    low, high = (sp.oo if end is sp.oo else (end + shift) ** sp.Rational(1, n) for end in (lower, upper))
    yield Substitution(
        x, (q + shift) ** sp.Rational(1, n), x**n - shift, (x ** (1 - n) / n) ** 2, function, low, high, True,
        condition=sp.S.One if start.is_nonnegative else start,
    )  # fmt: skip


# -------------------------------------------------------------------------------------------- circular functions
def _trigonometric(square: sp.Expr, coordinate: Coordinate, x: sp.Symbol) -> Iterator[Substitution]:
    q = coordinate.symbol
    lower, upper = extended_domain_ends(coordinate)
    found = _base(square, q, (sp.sin, sp.cos, sp.tan))
    if found is None:
        return
    line, angle, known = lower is -sp.oo and upper is sp.oo, coordinate.domain.kind == "angle", [found]
    while (doubled := _of_whole_angle(*known[-1])) is not None and (line or len(known) < 2):
        known.append(doubled)
    if line or (angle and known[-1][0] == 1):
        known = known[-1:]
    none = True
    if line or (not angle and found[0].free_symbols):
        yield from _between_poles(*found, q, x)
    for κ, function in known:
        for variable in _of_multiples(function, κ, coordinate, x, turn=line or (angle and κ == 1)):
            none = False
            yield variable
    if (
        none and found[0].free_symbols
    ):  # how many turns are in the domain depends on letters: one about zero is looked at
        while (doubled := _of_whole_angle(*known[-1])) is not None:
            known.append(doubled)
        κ, function = known[-1]
        yield from _of_multiples(function, κ, coordinate, x, turn=True)


def _of_multiples(
    function: sp.Expr, κ: sp.Expr, coordinate: Coordinate, x: sp.Symbol, *, turn: bool
) -> Iterator[Substitution]:  # fmt: skip
    """Yield a function of sin κq and cos κq."""
    q = coordinate.symbol
    lower, upper = extended_domain_ends(coordinate)
    w0, w1 = _scaled(κ, lower), _scaled(κ, upper)
    w = κ * q
    even_s, even_c = _even(function, S, C), _even(function, C, S)
    if turn:
        for side in _sides(κ):
            yield from _on_a_turn(function.subs(S, side * S), side * κ, q, x, even_s)
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
    yield Substitution(x, sp.sin(w), sp.asin(x) / κ, slope, even.subs(S, x), -one, one, True, condition=_condition(κ))


def _on_a_turn(
    function: sp.Expr, κ: sp.Expr, q: sp.Symbol, x: sp.Symbol, even: sp.Expr | None
) -> Iterator[Substitution]:  # fmt: skip
    """Of an angle, or of a line along which P² is periodic: sines of the half about a place, tangents of the half."""
    scale = _Turn(q, x, κ)
    yield from _half_sine(function, scale)
    if even is not None and (not even.is_polynomial(C) or sp.degree(even, C) > 1):
        for middle, sign in ((sp.S.Zero, 1), (sp.pi, -1)):
            yield scale.about(middle, even.subs(C, sign * (1 - 2 * x**2)))
    half = function.subs({S: 2 * x / (1 + x**2), C: (1 - x**2) / (1 + x**2)}, simultaneous=True)
    slope, turn, more = κ**2 * (1 + x**2) ** 2 / 4, 2 * sp.pi / κ, _condition(κ)
    place, inverse = sp.tan(κ * q / 2), 2 * sp.atan(x) / κ
    yield Substitution(x, place, inverse, slope, half, -sp.oo, sp.oo, True, True, turn, more)
    # about the opposite place: a libration about π is one interval of x
    half = function.subs({S: -2 * x / (1 + x**2), C: (x**2 - 1) / (1 + x**2)}, simultaneous=True)
    place, inverse = sp.tan((κ * q - sp.pi) / 2), (sp.pi + 2 * sp.atan(x)) / κ
    yield Substitution(x, place, inverse, slope, half, -sp.oo, sp.oo, True, True, turn, more)


def _sides(κ: sp.Expr) -> tuple[int, ...]:
    """Return the signs of a factor that are possible."""
    return (1,) if κ.is_positive else (-1,) if κ.is_negative else (1, -1)


def _condition(κ: sp.Expr) -> sp.Expr:
    """Return what must be positive; 1 where it is."""
    return sp.S.One if κ.is_positive else κ


def _scaled(κ: sp.Expr, end: sp.Expr) -> sp.Expr:
    """Return an end of the domain times a positive factor."""
    return end if end in (sp.oo, -sp.oo) else κ * end


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
    """

    q: sp.Symbol
    x: sp.Symbol
    κ: sp.Expr

    def about(self, δ: sp.Expr, function: sp.Expr) -> Substitution:
        """X = sin((κq − δ)/2).

        Args:
            δ: the middle of the turn.
            function: P² in x.
        """
        κ, x = self.κ, self.x
        slope, inverse, place = κ**2 * (1 - x**2) / 4, (δ + 2 * sp.asin(x)) / κ, sp.sin((κ * self.q - δ) / 2)
        turn, one = 2 * sp.pi / κ, sp.S.One
        return Substitution(x, place, inverse, slope, function, -one, one, True, True, turn, _condition(κ))


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
        common = sp.gcd(b, c)
        if common.is_positive is None:
            return
        common = common if common.is_positive else -common
        δ = sp.atan2(sp.cancel(c / common), sp.cancel(b / common))
        d = common * sp.sqrt(sp.expand(sp.cancel(c / common) ** 2 + sp.cancel(b / common) ** 2))
    if d.is_negative:
        δ, d = δ + sp.pi, -d
    for middle, size in ((δ, d), (δ + sp.pi, -d)):  # about either place of rest
        yield scale.about(middle, a + size * (1 - 2 * scale.x**2))


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


# -------------------------------------------------------------------------------------------- hyperbolic functions
def _hyperbolic(square: sp.Expr, q: sp.Symbol, lower: sp.Expr, upper: sp.Expr, x: sp.Symbol) -> Iterator[Substitution]:
    plain = square.replace(lambda a: a.func in HYPERBOLIC and a.has(q), lambda a: HYPERBOLIC[a.func](a.args[0]))
    atoms = [a for a in plain.atoms(sp.exp) if a.has(q)]
    slopes = [sp.diff(a.args[0], q) for a in atoms]
    if not atoms or any(slope.has(q) for slope in slopes):
        return
    ratios = [sp.cancel(slope / slopes[0]) for slope in slopes]
    if not all(r.is_Rational for r in ratios):
        return
    step = ratios[0]
    for r in ratios[1:]:
        step = sp.gcd(step, r)
    offsets = [sp.expand(a.args[0] - slope * q) for a, slope in zip(atoms, slopes, strict=True)]
    middle = sp.cancel(-offsets[0] / slopes[0])
    if any(sp.cancel(δ + slope * middle) != 0 for δ, slope in zip(offsets, slopes, strict=True)):
        middle = sp.S.Zero
    for side in _sides(slopes[0]):
        κ = side * abs(step) * slopes[0]
        table = {
            a: X ** sp.cancel(slope / κ) * (sp.exp(δ) if middle == 0 else 1)
            for a, slope, δ in zip(atoms, slopes, offsets, strict=True)
        }
        function, w = sp.cancel(sp.together(plain.xreplace(table))), κ * (q - middle)
        if function.has(q):
            return
        ends = tuple(_scaled(κ, end if end in (sp.oo, -sp.oo) else end - middle) for end in (lower, upper))
        for found in (*_both_exponentials(function, κ, w, ends, x), *_even_hyperbolic(function, κ, w, ends, x)):
            yield replace(found, condition=_condition(κ), inverse=found.inverse + middle)


def _both_exponentials(
    function: sp.Expr, κ: sp.Expr, w: sp.Expr, range_: tuple[sp.Expr, sp.Expr], x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    low, high = (sp.exp(end) for end in range_)
    yield Substitution(x, sp.exp(w), sp.log(x) / κ, κ**2 * x**2, function.subs(X, x), low, high, True)
    low, high = (sp.exp(-end) for end in reversed(range_))
    yield Substitution(x, sp.exp(-w), -sp.log(x) / κ, κ**2 * x**2, function.subs(X, 1 / x), low, high, False)


def _even_hyperbolic(
    function: sp.Expr, κ: sp.Expr, w: sp.Expr, range_: tuple[sp.Expr, sp.Expr], x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    """Cosh, sinh, tanh, tanh of the half, where the function is rational in one of them: X ↔ 1/X, X ↔ −1/X, X² ↔ …."""
    w0, w1 = range_
    found = _invariant(function, sp.S(1))
    if found is not None and w0.is_nonnegative:
        yield Substitution(
            x, sp.cosh(w), sp.acosh(x) / κ, κ**2 * (x**2 - 1), found.subs(C, x), sp.cosh(w0), sp.cosh(w1), True
        )
    elif found is not None:
        slope, half = κ**2 * (1 - x**2) ** 2 / 4, found.subs(C, (1 + x**2) / (1 - x**2))
        low, high = sp.tanh(w0 / 2), sp.tanh(w1 / 2)
        yield Substitution(x, sp.tanh(w / 2), 2 * sp.atanh(x) / κ, slope, half, low, high, True)
    if (found := _invariant(function, sp.S(-1))) is not None:
        yield Substitution(
            x, sp.sinh(w), sp.asinh(x) / κ, κ**2 * (x**2 + 1), found.subs(C, x), sp.sinh(w0), sp.sinh(w1), True
        )
    if sp.cancel(function - function.subs(X, -X)) == 0:
        z = sp.Dummy("z", positive=True)
        squared = sp.powdenest(function.subs(X, sp.sqrt(z)), force=True)
        found = sp.cancel(squared.subs(z, (1 + x) / (1 - x)))
        yield Substitution(
            x, sp.tanh(w), sp.atanh(x) / κ, κ**2 * (1 - x**2) ** 2, found, sp.tanh(w0), sp.tanh(w1), True
        )


def _invariant(function: sp.Expr, sign: sp.Expr) -> sp.Expr | None:
    """Return the function of X written in C = ½(X ± 1/X), where it is the same at X and ±1/X; None otherwise."""
    top, bottom = sp.fraction(sp.cancel(function))
    if sp.cancel(function - function.subs(X, sign / X)) != 0:
        return None
    relation = X**2 - 2 * C * X + sign
    parts = [sp.Poly(sp.rem(sp.expand(part), relation, X), X) for part in (top, bottom)]
    (b1, a1), (b2, a2) = ((p.coeff_monomial(X), p.coeff_monomial(1)) for p in parts)
    # (a1 + b1 X)/(a2 + b2 X) with X = C ± √(C² ∓ 1): rational where a1 b2 = a2 b1
    ratio = b1 / b2 if sp.expand(b2) != 0 else a1 / a2
    return sp.cancel(ratio)
