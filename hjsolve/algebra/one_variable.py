"""Is a function of one variable zero on an interval, wherever it is defined? Decided, not guessed.

The function is made of rational operations, roots, logarithms and inverse functions over x, over sines and cosines of
one angle, or over exponentials of one argument. With t = x, t = tan(w/2) or t = exp(w) it becomes algebraic in t, but
for logarithms and inverse functions.

**Pieces.** Zeros of radicands, denominators and arguments of logarithms lie among the real roots of polynomials in t
(norms, by resultants), which are isolated exactly. Between two of them everything is analytic.

**Algebraic functions.** On the compact curve to which f belongs, a cover of the t-line by at most K = Π q sheets (q the
order of each root), f has at most K h(f) zeros unless it is the zero function, where the height h counts poles:
h(t) = 1, h(f + g), h(fg) ≤ h(f) + h(g), h(1/f) = h(f), h(f^(1/q)) = h(f)/q. So f vanishes on a piece if it vanishes at
more than K h(f) places of it, and at a rational place that is a question of algebraic numbers (``constants``). The
signs of the roots on the piece are taken care of by the places themselves.

**Logarithms and inverse functions** that occur with constant coefficients go away in the derivative; f vanishes on a
piece if f′ does and f does at one place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import sympy as sp

from hjsolve.algebra.constants import NotAlgebraicError, algebraic_is_zero, constant_is_zero
from hjsolve.algebra.critical import AnalyticPiece, TooLargeError, analytic_pieces
from hjsolve.algebra.curve import AlgebraicCurve, curve_of
from hjsolve.algebra.elementary import PRIMITIVES, at_one_place, composed
from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.algebra.poly import Budget
from hjsolve.algebra.signs import Bounds

MAX_PLACES = 400


class UndecidableError(ArithmeticError):
    """These rules do not reach the function."""


_GIVE_UP = (UndecidableError, TooLargeError, NotAlgebraicError, NoEnclosureError, ZeroDivisionError, sp.PolynomialError)


def vanishes(f: sp.Expr, x: sp.Symbol, bounds: Bounds, budget: Budget) -> bool:
    """Proof that a function of x is zero on the open interval, where it is defined; False proves nothing.

    Args:
        f: of x alone.
        bounds: ends of the interval, numbers; None is infinite.
        budget: raises ``WorkLimitError`` when it is used up.
    """
    try:
        z = sp.Dummy(x.name)  # no assumption: sympy would write √(x²) as |x| again
        return _vanishes(composed(f.xreplace({x: z})), z, bounds, budget)
    except _GIVE_UP:
        return False


def _vanishes(f: sp.Expr, x: sp.Symbol, bounds: Bounds, budget: Budget) -> bool:
    if f.is_Mul:
        return any(_factor_vanishes(factor, x, bounds, budget) for factor in f.args if factor.has(x))
    if not f.has(x):
        return constant_is_zero(at_one_place(f)) is True
    primitives = [p for p in f.atoms(*PRIMITIVES) if p.has(x)]
    if primitives:
        return _with_primitives(f, primitives, x, bounds, budget)
    return all(_algebraic(part, x, bounds, budget) for part in _parts(f, x))


def _factor_vanishes(f: sp.Expr, x: sp.Symbol, bounds: Bounds, budget: Budget) -> bool:
    try:
        return _vanishes(f, x, bounds, budget)
    except _GIVE_UP:
        return False


# -------------------------------------------------------------------------------- algebraic functions


def _algebraic(f: sp.Expr, x: sp.Symbol, bounds: Bounds, budget: Budget) -> bool:
    curve = curve_of([f], x, bounds)
    (g,) = curve.carried([f])
    need = _places_needed(g, curve.t)
    found = [_vanishes_on(g, piece, curve, need, budget) for piece in analytic_pieces([g], curve.t, curve.ends, budget)]
    return True in found and False not in found


def _vanishes_on(g: sp.Expr, piece: AnalyticPiece, curve: AlgebraicCurve, need: int, budget: Budget) -> bool | None:
    """Return whether g is zero at so many places of a piece; None where it is defined nowhere on it."""
    for place in piece.places(need):
        budget.check()
        value = g.xreplace({curve.t: place})
        if not _is_defined(value):
            return None
        if not algebraic_is_zero(value):
            return False
    return True


def _is_defined(value: sp.Expr) -> bool:
    """Whether an even root of a negative number, or the logarithm of one, occurs: a sign that a whole piece shares."""
    if value.has(sp.I):
        return False
    for node in sp.preorder_traversal(value):
        inside = _radicand(node)
        if inside is not None and _sign(inside) < 0:
            return False
    return not value.has(sp.zoo, sp.nan)


def _radicand(node: sp.Basic) -> sp.Expr | None:
    if isinstance(node, sp.log):
        return node.args[0]
    if isinstance(node, sp.Pow) and node.exp.is_Rational and not node.exp.is_Integer:
        return node.base
    return None


def _sign(x: sp.Expr) -> int:
    """Return the sign of a constant that is not zero.

    Raises:
        UndecidableError: it may be zero.
    """
    if x.is_Rational:
        return int(sp.sign(x))
    for precision in (64, 256, 1024):
        try:
            lower, upper = enclose(x, {}, precision)
        except NoEnclosureError:
            continue
        if lower > 0 or upper < 0:
            return 1 if lower > 0 else -1
    raise UndecidableError


def _places_needed(g: sp.Expr, t: sp.Symbol) -> int:
    sheets = 1
    orders: dict[sp.Expr, int] = {}
    for p in g.atoms(sp.Pow):
        if p.base.has(t) and not p.exp.is_Integer:
            if not p.exp.is_Rational:
                raise UndecidableError
            orders[p.base] = int(sp.ilcm(orders.get(p.base, 1), p.exp.q))
    for q in orders.values():
        sheets *= q
    need = int(sheets * _height(g, t)) + 1
    if need > MAX_PLACES:
        raise TooLargeError
    return need


def _height(g: sp.Expr, t: sp.Symbol) -> sp.Rational:
    if not g.has(t):
        return sp.S.Zero
    if g == t:
        return sp.S.One
    if g.is_rational_function(t):
        top, bottom = sp.fraction(sp.cancel(sp.together(g)))
        return sp.Integer(max(sp.degree(top, t), sp.degree(bottom, t)))
    if g.is_Add or g.is_Mul:
        rational = [a for a in g.args if a.is_rational_function(t)]
        rest = [a for a in g.args if not a.is_rational_function(t)]
        return sp.Add(*(_height(a, t) for a in rest), _height(g.func(*rational), t))
    if g.is_Pow and g.exp.is_Rational:
        return abs(g.exp) * _height(g.base, t)
    raise UndecidableError


def _parts(f: sp.Expr, x: sp.Symbol) -> Iterable[sp.Expr]:
    """Return the coefficients of f in those functions that stand only outside of roots.

    All vanish if f does termwise.
    """
    roots = [p for p in f.atoms(sp.Pow) if p.has(x) and not p.exp.is_Integer]
    inside = {k for p in roots for k in _kinds(p.base, x)}
    outside = _kinds(f, x)
    if len(outside) <= 1:
        return [f]
    if len(inside) > 1:
        raise UndecidableError
    own = next(iter(inside), next(iter(outside)))
    table = {node: sp.Dummy() for node in _atoms(f, x) if _kind(node, x) != own}
    held = {r: sp.Dummy() for r in roots}
    g = f.xreplace(held).xreplace(table)
    top = sp.fraction(sp.together(g))[0]
    back = {d: r for r, d in held.items()}
    if not top.is_polynomial(*table.values()):
        raise UndecidableError
    return [c.xreplace(back) for c in sp.Poly(top, *table.values()).coeffs()]


def _atoms(f: sp.Expr, x: sp.Symbol) -> list[sp.Expr]:
    """Return the largest functions and the variable that f is algebraic in."""
    if f == x or isinstance(f, sp.Function):
        return [f] if f.has(x) else []
    return [node for a in f.args for node in _atoms(a, x)]


def _kind(node: sp.Expr, x: sp.Symbol) -> str:
    if node == x:
        return "plain"
    return "circular" if isinstance(node, (sp.sin, sp.cos)) else "exponential"


def _kinds(f: sp.Expr, x: sp.Symbol) -> set[str]:
    return {_kind(node, x) for node in _atoms(f, x)}


# -------------------------------------------------------------------------------- logarithms and inverse functions


def _with_primitives(f: sp.Expr, primitives: Sequence[sp.Expr], x: sp.Symbol, bounds: Bounds, budget: Budget) -> bool:
    """Zero where the derivative is, and one value on each piece; f is divided by the coefficient of a primitive."""
    held = {p: sp.Dummy(real=True) for p in primitives}
    g = sp.expand_mul(f.xreplace(held))
    if any(d.has(x) for p in primitives for d in p.args[0].atoms(*PRIMITIVES)):
        raise UndecidableError
    coefficients = [g.diff(d) for d in held.values()]
    if any(c.has(*held.values()) for c in coefficients):
        raise UndecidableError
    lead = next((c for c in coefficients if c != 0), None)
    if lead is None:
        return _vanishes(g, x, bounds, budget)
    ratios = [_constant_ratio(c, lead, x, bounds, budget) for c in coefficients]
    rest = g.xreplace(dict.fromkeys(held.values(), sp.S.Zero)) / lead
    whole = sp.Add(rest, *(r * p for r, p in zip(ratios, primitives, strict=True)))
    slope = composed(sp.diff(whole, x))
    if not all(_algebraic(part, x, bounds, budget) for part in _parts(slope, x)):
        return False
    return _vanishes_somewhere_on_each_piece(whole, x, bounds, budget)


def _constant_ratio(c: sp.Expr, lead: sp.Expr, x: sp.Symbol, bounds: Bounds, budget: Budget) -> sp.Rational:
    ratio = c / lead
    if ratio.is_Rational:
        return ratio
    if not ratio.has(x):
        raise UndecidableError
    for place in (sp.Rational(1, 3), sp.Rational(5, 7), -sp.Rational(2, 5), sp.Rational(13, 4)):
        value = ratio.subs(x, place).evalf(30)
        if value.is_Float and (guess := sp.nsimplify(value, rational=True, tolerance=1e-20)).q < 1000:
            if _vanishes(c - guess * lead, x, bounds, budget):
                return guess
            raise UndecidableError
    raise UndecidableError


def _vanishes_somewhere_on_each_piece(whole: sp.Expr, x: sp.Symbol, bounds: Bounds, budget: Budget) -> bool:
    curve = curve_of([whole], x, bounds)
    inner = [w for p in whole.atoms(*PRIMITIVES) if p.has(x) for w in (p.args[0], _edge(p))]
    watched = curve.carried([*inner, *(r for r in [_without(whole, x)] if r.has(x))])
    defined = False
    for piece in analytic_pieces(watched, curve.t, curve.ends, budget):
        (place,) = piece.places(1)
        for value in curve.values(whole, place):
            budget.check()
            constant = at_one_place(value)
            if not _is_defined(constant):
                continue
            defined = True
            if constant_is_zero(constant) is not True:
                return False
    return defined


_EDGES: dict[object, Callable[[sp.Expr], sp.Expr]] = {
    sp.log: lambda u: 1 / u,
    sp.asin: lambda u: 1 / (1 - u**2),
    sp.acos: lambda u: 1 / (1 - u**2),
    sp.acosh: lambda u: 1 / (u**2 - 1),
    sp.atanh: lambda u: 1 / (1 - u**2),
}
"""Functions with a pole where an inverse function stops being analytic."""


def _edge(p: sp.Expr) -> sp.Expr:
    return _EDGES[p.func](p.args[0]) if p.func in _EDGES else p.args[0]


def _without(whole: sp.Expr, x: sp.Symbol) -> sp.Expr:
    """Return what is neither a primitive nor linear in x."""
    terms = [t for t in sp.Add.make_args(whole) if t.has(x) and not t.has(*PRIMITIVES) and t.diff(x).has(x)]
    return sp.Add(*terms)
