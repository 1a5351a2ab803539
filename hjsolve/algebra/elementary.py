"""Elementary functions in fewer functions: compositions that are algebraic, and inverse functions as log and atan.

Exponentials of logarithms become powers, circular functions of inverse ones algebraic: cos atan u = 1/√(1 + u²),
sin acos u = √(1 − u²), and by half angles for half of them, whose cosine is not negative (|atan|, |asin| < π/2,
0 < acos < π). At one place, inverse functions are written

    asin u = atan(u/√(1 − u²)),  acos u = π/2 − asin u,  asinh u = log(u + √(u² + 1)),  acosh u = log(u + √(u² − 1)),
    atanh u = ½ (log(1 + u) − log(1 − u)),

each of which is defined where its left side is, ends of the domain left out.
"""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

Pair = tuple[sp.Expr, sp.Expr]
Rule = Callable[[sp.Expr], sp.Expr]
MAX_MULTIPLE = 12
INVERSE_CIRCULAR = (sp.asin, sp.acos, sp.atan)
INVERSE_HYPERBOLIC = (sp.log, sp.asinh, sp.acosh, sp.atanh)
PRIMITIVES = (*INVERSE_CIRCULAR, *INVERSE_HYPERBOLIC)


def composed(x: sp.Expr) -> sp.Expr:
    """Return the same function with exponentials and circular functions of inverse functions made algebraic.

    Args:
        x: a function of one variable, as an expression.
    """
    return _rewritten(x, _COMPOSITIONS)


def at_one_place(x: sp.Expr) -> sp.Expr:
    """Return the same constant with inverse functions only as log and atan."""
    return _rewritten(composed(x), INVERSES)


def _rewritten(x: sp.Expr, rules: dict[object, Rule]) -> sp.Expr:
    if not x.args:
        return x
    arguments = [_rewritten(a, rules) for a in x.args]
    if rule := rules.get(x.func):
        return rule(arguments[0])
    return x.func(*arguments) if arguments != list(x.args) else x


def _exponential(w: sp.Expr) -> sp.Expr:
    """Return the exponential of w, with exp(r log u) as u^r."""
    powers, rest = [], []
    for term in sp.Add.make_args(sp.expand_mul(w)):
        c, f = term.as_coeff_Mul()
        if isinstance(f, INVERSE_HYPERBOLIC):
            powers.append(_BASES[f.func](f.args[0]) ** c)
        else:
            rest.append(term)
    return sp.Mul(sp.exp(sp.Add(*rest)), *powers)


_BASES: dict[object, Rule] = {
    sp.log: lambda u: u,
    sp.asinh: lambda u: u + sp.sqrt(u**2 + 1),
    sp.acosh: lambda u: u + sp.sqrt(u**2 - 1),
    sp.atanh: lambda u: sp.sqrt((1 + u) / (1 - u)),
}


def _hyperbolic(function: type[sp.Function], combine: Rule) -> Rule:
    return lambda w: combine(_exponential(w)) if w.has(*INVERSE_HYPERBOLIC) else function(w)


def circular_pair(w: sp.Expr) -> Pair:
    """(cos w, sin w), algebraic in what inverse circular functions w holds.

    Args:
        w: an angle in radians.
    """
    pair: Pair = (sp.S.One, sp.S.Zero)
    rest = []
    for term in sp.Add.make_args(sp.expand_mul(w)):
        c, f = term.as_coeff_Mul()
        if isinstance(f, INVERSE_CIRCULAR) and c.is_Rational and c.q <= 2 and abs(c.p) <= MAX_MULTIPLE:
            single = _PAIRS[f.func](f.args[0])
            if c.q == 2:
                half = sp.sqrt((1 + single[0]) / 2)
                single = half, single[1] / (2 * half)
            for _ in range(abs(int(c.p))):
                pair = _sum(pair, single if c > 0 else (single[0], -single[1]))
        else:
            rest.append(term)
    other = sp.Add(*rest)
    return _sum(pair, (sp.cos(other), sp.sin(other))) if other != 0 else pair


_PAIRS: dict[object, Callable[[sp.Expr], Pair]] = {
    sp.atan: lambda u: (1 / sp.sqrt(1 + u**2), u / sp.sqrt(1 + u**2)),
    sp.asin: lambda u: (sp.sqrt(1 - u**2), u),
    sp.acos: lambda u: (u, sp.sqrt(1 - u**2)),
}


def _sum(a: Pair, b: Pair) -> Pair:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _circular(function: type[sp.Function], combine: Callable[[Pair], sp.Expr]) -> Rule:
    always = function not in (sp.sin, sp.cos)
    return lambda w: combine(circular_pair(w)) if always or w.has(*INVERSE_CIRCULAR) else function(w)


_COMPOSITIONS: dict[object, Rule] = {
    sp.Abs: lambda u: (u**2) ** sp.S.Half,
    sp.sign: lambda u: u / (u**2) ** sp.S.Half,
    sp.exp: _exponential,
    sp.sinh: _hyperbolic(sp.sinh, lambda e: (e - 1 / e) / 2),
    sp.cosh: _hyperbolic(sp.cosh, lambda e: (e + 1 / e) / 2),
    sp.tanh: _hyperbolic(sp.tanh, lambda e: (e**2 - 1) / (e**2 + 1)),
    sp.sin: _circular(sp.sin, lambda p: p[1]),
    sp.cos: _circular(sp.cos, lambda p: p[0]),
    sp.tan: _circular(sp.tan, lambda p: p[1] / p[0]),
    sp.cot: _circular(sp.cot, lambda p: p[0] / p[1]),
    sp.sec: _circular(sp.sec, lambda p: 1 / p[0]),
    sp.csc: _circular(sp.csc, lambda p: 1 / p[1]),
}


def _arctangent_of_sine(u: sp.Expr) -> sp.Expr:
    return sp.atan(u / sp.sqrt(1 - u**2))


INVERSES: dict[object, Rule] = {
    sp.asin: _arctangent_of_sine,
    sp.acos: lambda u: sp.pi / 2 - _arctangent_of_sine(u),
    sp.asinh: lambda u: sp.log(u + sp.sqrt(u**2 + 1)),
    sp.acosh: lambda u: sp.log(u + sp.sqrt(u**2 - 1)),
    sp.atanh: lambda u: (sp.log(1 + u) - sp.log(1 - u)) / 2,
}
"""Inverse functions as log and atan, as above."""
