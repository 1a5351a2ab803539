"""Variables x = φ(q) in which a squared momentum P²(q) is a rational function.

With G(x) = φ′(q)², every integral of a separated solution is ∫ N dq/√P² = ∫ N dx/√(P² G): rational in x but for one
square root, where both P² and G are rational in x. Candidates: q, q − b where P² is even about b, q², 1/q, √(q² + c),
and of sines, hyperbolic sines and exponentials of multiples of one argument κq: cos, sin, tan of the half, sin of the
half shifted, cosh, sinh, tanh, tanh of the half, exp, of κ(q − b) where all arguments have the same b; (q + c)^(1/n),
e^u with q = a sinh u; and u = arctan q, log q, where P² is that of a motion along u.
Each is used only where it is monotone on the whole domain of the coordinate, or on a turn of an angle, or of a line on
which P² is periodic. Where the sign of κ is open, each sign is a case of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import sympy as sp

from hjsolve.closed_form.change_of_variable import (
    Substitution,
    condition_on,
    extended_domain_ends,
    possible_signs,
    scaled_end,
)
from hjsolve.closed_form.variables_on_a_circle import circular_variables
from hjsolve.mechanics.coordinates_and_parameters import Coordinate

C, X = sp.Symbol("_C", real=True), sp.Symbol("_X", positive=True)
HYPERBOLIC = {
    sp.sinh: lambda w: (sp.exp(w) - sp.exp(-w)) / 2,
    sp.cosh: lambda w: (sp.exp(w) + sp.exp(-w)) / 2,
    sp.tanh: lambda w: (sp.exp(w) - sp.exp(-w)) / (sp.exp(w) + sp.exp(-w)),
}


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
        yield from circular_variables(square, coordinate, x)
    elif all(a.func in (sp.sinh, sp.cosh, sp.tanh, sp.exp) or isinstance(a, sp.exp) for a in inner):
        yield from _hyperbolic(square, q, lower, upper, x)
    elif len(inner) == 1 and inner[0].func in (sp.atan, sp.asinh, sp.atanh, sp.log):
        yield from _another_coordinate(square, q, inner[0], lower, upper, x)


def _plain(atom: sp.Expr) -> bool:
    return isinstance(atom, sp.Pow) and bool(atom.exp.is_Integer)


# -------------------------------------------------------------------------------------------- powers
def _algebraic(
    square: sp.Expr, q: sp.Symbol, lower: sp.Expr, upper: sp.Expr, x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    one, b = sp.S.One, _middle(square, q)
    if b != 0:
        yield Substitution(x, q - b, x + b, one, sp.cancel(square.subs(q, x + b)), lower - b, upper - b, True)
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


def _middle(square: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Return the place about which a squared momentum of more than second degree is even; 0 where there is none."""
    letters = sorted(square.free_symbols - {q}, key=str)
    values = {s: sp.Rational(13 + 8 * k, 11 + k) for k, s in enumerate(letters)}
    if _middle_of_numerator(square.xreplace(values), q) == 0:  # without letters it is soon seen
        return sp.S.Zero
    return _middle_of_numerator(square, q)


def _middle_of_numerator(square: sp.Expr, q: sp.Symbol) -> sp.Expr:
    P = sp.Poly(sp.numer(sp.together(square)), q)
    if P.degree() <= 2:
        return sp.S.Zero
    b = sp.cancel(-P.coeff_monomial(q ** (P.degree() - 1)) / (P.degree() * P.LC()))
    return b if b == 0 or sp.cancel(square - square.subs(q, 2 * b - q)) == 0 else sp.S.Zero


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


def _another_coordinate(
    square: sp.Expr, q: sp.Symbol, u: sp.Expr, lower: sp.Expr, upper: sp.Expr, x: sp.Symbol
) -> Iterator[Substitution]:  # fmt: skip
    """Yield u = φ(q) where P²/φ′², the square of its momentum, is rational in u alone: an oscillator in q = tan u."""
    slope = sp.diff(u, q)
    function = sp.cancel(sp.together((square / slope**2).xreplace({u: x})))
    if function.has(q) or u.args[0] != q:
        return
    ends = (sp.limit(u, q, lower, "+") if lower != -sp.oo else u.subs(q, lower), u.subs(q, upper))
    yield Substitution(x, u, u.inverse()(x), sp.S.One, function, *ends, True)


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
    for side in possible_signs(slopes[0]):
        κ = side * abs(step) * slopes[0]
        table = {
            a: X ** sp.cancel(slope / κ) * (sp.exp(δ) if middle == 0 else 1)
            for a, slope, δ in zip(atoms, slopes, offsets, strict=True)
        }
        function = sp.cancel(sp.together(plain.xreplace(table)))
        if function.has(q):
            return
        for multiple, of_multiple in _doubled(function):
            rate, w = multiple * κ, multiple * κ * (q - middle)
            ends = tuple(scaled_end(rate, end if end in (sp.oo, -sp.oo) else end - middle) for end in (lower, upper))
            for found in (
                *_both_exponentials(of_multiple, rate, w, ends, x),
                *_even_hyperbolic(of_multiple, rate, w, ends, x),
            ):
                yield replace(found, condition=condition_on(κ), inverse=found.inverse + middle)


def _doubled(function: sp.Expr) -> Iterator[tuple[int, sp.Expr]]:
    """Yield a function of X = e^w by itself, and those of e^{2w}, e^{4w} … that it is too, as tanh² w of cosh 2w."""
    multiple = 1
    yield multiple, function
    top, bottom = sp.fraction(function)
    while not any(n % 2 for part in (top, bottom) for (n,) in sp.Poly(part, X).monoms()) and function.has(X):
        top, bottom = (_of_square(part) for part in (top, bottom))
        multiple, function = 2 * multiple, top / bottom
        yield multiple, function


def _of_square(even: sp.Expr) -> sp.Expr:
    """Return an even polynomial of X as one of X²."""
    return sp.Add(*(c * X ** (n // 2) for (n,), c in sp.Poly(even, X).terms()))


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
