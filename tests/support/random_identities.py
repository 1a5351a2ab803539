"""True identities that hold on a part of the line only, and false neighbours, as users type them.

Every identity is a template in u on an interval; u = a x + b with random rational a, b carries it to another place.
Truth is what mpmath says at 60 digits at many places of the interval, not what the template says.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass

import mpmath
import sympy as sp

X, Y = sp.symbols("x y", real=True)
PLACES, DIGITS = 12, 60
ROUNDING = mpmath.mpf(10) ** -45

HALF_ANGLES = [
    ("sqrt((1 - cos(u))/2) - sin(u/2)", "0", "2*pi"),
    ("sqrt((1 - cos(u))/2) + sin(u/2)", "-2*pi", "0"),
    ("sqrt((1 + cos(u))/2) - cos(u/2)", "-pi", "pi"),
    ("sqrt((1 + cos(u))/2) + cos(u/2)", "pi", "3*pi"),
    ("sqrt(1 + sin(u)) - sin(u/2) - cos(u/2)", "-pi/2", "3*pi/2"),
    ("sqrt(1 - sin(u)) + sin(u/2) - cos(u/2)", "-3*pi/2", "pi/2"),
    ("sqrt((1 - cos(u))/(1 + cos(u))) - tan(u/2)", "0", "pi"),
    ("sqrt(1 - cos(u))*sqrt(1 + cos(u)) - sin(u)", "0", "pi"),
    ("sqrt(1 - cos(u)**2) + sin(u)", "pi", "2*pi"),
    ("sqrt(1 - sin(u)**2) - cos(u)", "-pi/2", "pi/2"),
    ("sqrt(1 + tan(u)**2) - 1/cos(u)", "-pi/2", "pi/2"),
    ("sqrt(2 + sqrt(2 + 2*cos(u))) - 2*cos(u/4)", "-pi", "pi"),
    ("sqrt(2 + 2*cos(4*u)) - 2*cos(2*u)", "-pi/4", "pi/4"),
    ("sqrt((cosh(u) - 1)/2) - sinh(u/2)", "0", None),
    ("sqrt((cosh(u) + 1)/2) - cosh(u/2)", None, None),
    ("sqrt((cosh(u) - 1)/(cosh(u) + 1)) + tanh(u/2)", None, "0"),
    ("sqrt(cosh(u)**2 - 1) - sinh(u)", "0", None),
    ("sqrt(exp(2*u) - 2 + exp(-2*u)) - 2*sinh(u)", "0", None),
    ("sqrt(exp(u)) - exp(u/2)", None, None),
]
LOGARITHMS = [
    ("log(u**2) - 2*log(u)", "0", None),
    ("log(u**2) - 2*log(-u)", None, "0"),
    ("log((u - 1)**2) - 2*log(1 - u)", None, "1"),
    ("log((u - 1)**4) - 4*log(u - 1)", "1", None),
    ("log(u**2 - 1) - log(u - 1) - log(u + 1)", "1", None),
    ("log(u**2 - 1) - log(1 - u) - log(-1 - u)", None, "-1"),
    ("log((1 + u)/(1 - u)) - log(1 + u) + log(1 - u)", "-1", "1"),
    ("log(sqrt(u**2 + 1)) - log(u**2 + 1)/2", None, None),
    ("log(6*u) - log(2) - log(3) - log(u)", "0", None),
    ("log(u**3/8) - 3*log(u) + 3*log(2)", "0", None),
    ("exp(2*log(u)) - u**2", "0", None),
    ("exp(log(u**2)/2) + u", None, "0"),
    ("asinh(u) - log(u + sqrt(u**2 + 1))", None, None),
    ("acosh(u) - log(u + sqrt(u**2 - 1))", "1", None),
    ("2*atanh(u) - log((1 + u)/(1 - u))", "-1", "1"),
    ("log(u + sqrt(u**2 + 1)) + log(sqrt(u**2 + 1) - u)", None, None),
    ("asinh(sinh(u)) - u", None, None),
    ("acosh(cosh(u)) + u", None, "0"),
    ("log(exp(u) + exp(2*u)) - u - log(1 + exp(u))", None, None),
    ("log(sin(u)**2) - 2*log(sin(u))", "0", "pi"),
    ("log(tan(u)) - log(sin(u)) + log(cos(u))", "0", "pi/2"),
    ("log(1 - cos(u)) - 2*log(sin(u/2)) - log(2)", "0", "2*pi"),
    ("sinh(log(u)) - (u - 1/u)/2", "0", None),
    ("tanh(log(u)/2) - (u - 1)/(u + 1)", "0", None),
    ("atanh(u) - asinh(u/sqrt(1 - u**2))", "-1", "1"),
]
ROOTS = [
    ("sqrt(u**2) - u", "0", None),
    ("sqrt(u**2) + u", None, "0"),
    ("sqrt((u - 1)**2) + u - 1", None, "1"),
    ("sqrt(u**2 - 2*u + 1) - u + 1", "1", None),
    ("sqrt(u**2 - 1) - sqrt(u - 1)*sqrt(u + 1)", "1", None),
    ("sqrt(u**2 - 1) - sqrt(1 - u)*sqrt(-1 - u)", None, "-1"),
    ("sqrt(u**4 - u**2) - u*sqrt(u**2 - 1)", "1", None),
    ("sqrt(u + 2*sqrt(u - 1)) - 1 - sqrt(u - 1)", "1", None),
    ("sqrt(u - 2*sqrt(u - 1)) - 1 + sqrt(u - 1)", "1", "2"),
    ("sqrt(u - 2*sqrt(u - 1)) + 1 - sqrt(u - 1)", "2", None),
    ("sqrt(u + 1 - 2*sqrt(u)) - sqrt(u) + 1", "1", None),
    ("sqrt(u/(1 + u)) - sqrt(u)/sqrt(1 + u)", "0", None),
    ("sqrt(u**3) - u*sqrt(u)", "0", None),
    ("sqrt(1/u**2 + 1) + sqrt(1 + u**2)/u", None, "0"),
    ("sqrt(u**2 + 2 + 1/u**2) - u - 1/u", "0", None),
    ("sqrt(u + sqrt(u**2 - 1)) - sqrt((u + 1)/2) - sqrt((u - 1)/2)", "1", None),
    ("sqrt(u - sqrt(u**2 - 1)) - sqrt((u + 1)/2) + sqrt((u - 1)/2)", "1", None),
    ("(sqrt(u + 1) - sqrt(u))*(sqrt(u + 1) + sqrt(u)) - 1", "0", None),
    ("1/(sqrt(u + 1) - 1) - (sqrt(u + 1) + 1)/u", "0", None),
    ("sqrt((u**2 - 1)**2 + 4*u**2) - u**2 - 1", None, None),
    ("sqrt((1 - u**2)**2) - 1 + u**2", "-1", "1"),
    ("sqrt(2*u**2 + 2*u*sqrt(u**2 - 1) - 1) - u - sqrt(u**2 - 1)", "1", None),
]
INVERSES = [
    ("atan(u) + atan(1/u) - pi/2", "0", None),
    ("atan(u) + atan(1/u) + pi/2", None, "0"),
    ("atan((1 - u)/(1 + u)) + atan(u) - pi/4", "-1", None),
    ("atan((1 - u)/(1 + u)) + atan(u) + 3*pi/4", None, "-1"),
    ("atan((u + 2)/(1 - 2*u)) - atan(u) - atan(2)", None, "1/2"),
    ("asin(u) + acos(u) - pi/2", "-1", "1"),
    ("asin(sqrt(1 - u**2)) - acos(u)", "0", "1"),
    ("asin(sqrt(1 - u**2)) + acos(u) - pi", "-1", "0"),
    ("2*atan(u) - asin(2*u/(1 + u**2))", "-1", "1"),
    ("2*atan(u) + asin(2*u/(1 + u**2)) - pi", "1", None),
    ("2*atan(u) - acos((1 - u**2)/(1 + u**2))", "0", None),
    ("asin(u) - atan(u/sqrt(1 - u**2))", "-1", "1"),
    ("acos(cos(u)) - u", "0", "pi"),
    ("acos(cos(u)) + u - 2*pi", "pi", "2*pi"),
    ("asin(sin(u)) - u", "-pi/2", "pi/2"),
    ("asin(sin(u)) - pi + u", "pi/2", "3*pi/2"),
    ("atan(tan(u)) - u", "-pi/2", "pi/2"),
    ("atan(tan(u)) - u + pi", "pi/2", "3*pi/2"),
    ("2*atan(sqrt((1 - u)/(1 + u))) - acos(u)", "-1", "1"),
    ("acos(2*u**2 - 1) - 2*acos(u)", "0", "1"),
    ("acos(1 - 2*u**2) - 2*asin(u)", "0", "1"),
    ("3*asin(u) - asin(3*u - 4*u**3)", "-1/2", "1/2"),
    ("atan(sinh(u)) - 2*atan(tanh(u/2))", None, None),
    ("2*atan(exp(u)) - pi/2 - atan(sinh(u))", None, None),
    ("sin(2*asin(u)) - 2*u*sqrt(1 - u**2)", "-1", "1"),
    ("cos(2*atan(u)) - (1 - u**2)/(1 + u**2)", None, None),
    ("sin(atan(u)) - u/sqrt(1 + u**2)", None, None),
    ("tan(acos(u)/2) - sqrt((1 - u)/(1 + u))", "-1", "1"),
    ("cos(asin(u)/2) - sqrt((1 + sqrt(1 - u**2))/2)", "-1", "1"),
    ("atan(sin(u)/(1 + cos(u))) - u/2", "-pi", "pi"),
    ("asin(cos(u)) - pi/2 + u", "0", "pi"),
    ("acos(1/sqrt(1 + u**2)) - atan(u)", "0", None),
    ("asin(u/sqrt(1 + u**2)) - atan(u)", None, None),
    ("atan(u + sqrt(1 + u**2)) - pi/4 - atan(u)/2", None, None),
]
CONSTANTS = [
    "4*atan(1/5) - atan(1/239) - pi/4",
    "atan(1/2) + atan(1/3) - pi/4",
    "2*atan(1/3) + atan(1/7) - pi/4",
    "5*atan(1/7) + 2*atan(3/79) - pi/4",
    "12*atan(1/18) + 8*atan(1/57) - 5*atan(1/239) - pi/4",
    "atan(1) + atan(2) + atan(3) - pi",
    "asin(3/5) + asin(4/5) - pi/2",
    "asin(3/5) - atan(3/4)",
    "2*asin(1/sqrt(5)) - asin(4/5)",
    "atan(sqrt(2)) + atan(1/sqrt(2)) - pi/2",
    "atan(sqrt(2) - 1) - pi/8",
    "8*cos(2*pi/7)**3 + 4*cos(2*pi/7)**2 - 4*cos(2*pi/7) - 1",
    "cos(pi/7)*cos(2*pi/7)*cos(3*pi/7) - 1/8",
    "cos(2*pi/7) + cos(4*pi/7) + cos(6*pi/7) + 1/2",
    "sin(pi/9)*sin(2*pi/9)*sin(4*pi/9) - sqrt(3)/8",
    "tan(3*pi/11) + 4*sin(2*pi/11) - sqrt(11)",
    "cos(pi/9) - cos(2*pi/9) - cos(4*pi/9)",
    "sinh(log(2)) - 3/4",
    "cosh(log(3)/2) - 2/sqrt(3)",
    "log(12) - 2*log(2) - log(3)",
    "log(3 + 2*sqrt(2)) - 2*log(1 + sqrt(2))",
    "acosh(3) - 2*log(1 + sqrt(2))",
    "asinh(3/4) - log(2)",
    "exp(log(2)/2) - sqrt(2)",
    "sqrt(3 + 2*sqrt(2)) - 1 - sqrt(2)",
    "sqrt(5 + 2*sqrt(6)) - sqrt(2) - sqrt(3)",
    "sqrt(2 + sqrt(3)) - (sqrt(6) + sqrt(2))/2",
    "(2**(1/3) - 1)**(1/3) - (1/9)**(1/3) + (2/9)**(1/3) - (4/9)**(1/3)",
    "(7*20**(1/3) - 19)**(1/6) - (5/3)**(1/3) + (2/3)**(1/3)",
    "(2 + sqrt(5))**(1/3) - (1 + sqrt(5))/2",
    "sqrt(28**(1/3) - 27**(1/3)) - (98**(1/3) - 28**(1/3) - 1)/3",
    "(9 + 4*sqrt(5))**(1/3) - (3 + sqrt(5))/2",
    "sqrt(10 + 2*sqrt(5))*sqrt(10 - 2*sqrt(5)) - 4*sqrt(5)",
    "sqrt(16 - 2*sqrt(29) + 2*sqrt(55 - 10*sqrt(29))) + sqrt(11 + 2*sqrt(29)) - sqrt(5) - sqrt(22 + 2*sqrt(5))",
]
PAIRS = [
    ("sqrt(x)*sqrt(y) - sqrt(x*y)", (None, None), (None, None)),
    ("sqrt(x)*sqrt(y) - sqrt(x*y)", ("0", None), ("0", None)),
    ("sqrt(x**2*y**2) - x*y", ("0", None), ("0", None)),
    ("sqrt(x**2*y**2) + x*y", (None, "0"), ("0", None)),
    ("log(x*y) - log(x) - log(y)", (None, None), (None, None)),
    ("log(x**2*y**4) - 2*log(-x) - 4*log(y)", (None, "0"), ("0", None)),
    ("log(x/y) - log(x) + log(y)", ("0", None), ("0", None)),
    ("atan(x/y) + atan(y/x) - pi/2", ("0", None), ("0", None)),
    ("atan(x/y) + atan(y/x) + pi/2", (None, "0"), ("0", None)),
    ("atan((x - y)/(1 + x*y)) - atan(x) + atan(y)", ("0", None), ("0", None)),
    ("sqrt(x**2 + 2*x*y + y**2) - x - y", ("0", None), ("0", None)),
    ("asin(x/sqrt(x**2 + y**2)) - atan(x/y)", (None, None), ("0", None)),
    ("sqrt(x + y + 2*sqrt(x*y)) - sqrt(x) - sqrt(y)", ("0", None), ("0", None)),
    ("log(x + y) + log(x - y) - log(x**2 - y**2)", ("1", None), ("0", "1")),
    ("acos(x/sqrt(x**2 + y**2)) - 2*atan(y/(x + sqrt(x**2 + y**2)))", (None, None), ("0", None)),
    ("sqrt(exp(2*x)*y**2) - y*exp(x)", (None, None), ("0", None)),
    ("sqrt(x**2*(1 - cos(y))/2) + x*sin(y/2)", (None, "0"), ("0", "2*pi")),
]  # fmt: skip
FAMILIES = {
    "half angles": HALF_ANGLES, "logarithms": LOGARITHMS, "roots": ROOTS, "inverse functions": INVERSES,
    "constants": [(text,) for text in CONSTANTS], "two coordinates": PAIRS,
}  # fmt: skip
Templates = dict[str, list[tuple]]
Bounds = dict[sp.Symbol, tuple[sp.Expr | None, sp.Expr | None]]


@dataclass(frozen=True)
class Identity:
    """An expression, the domain, and whether it is zero everywhere on it (wherever it is defined)."""

    family: str
    expression: sp.Expr
    bounds: Bounds
    true: bool


def _read(text: str) -> sp.Expr:
    return sp.sympify(text, {"x": X, "y": Y, "u": sp.Symbol("u", real=True)}, rational=True)


def _number(source: random.Random) -> sp.Rational:
    return sp.Rational(source.randint(1, 12), source.choice((1, 1, 2, 3, 5)))


def identities(seed: int, count: int, templates: Templates = FAMILIES) -> Iterator[Identity]:
    """Draw identities, true ones and false neighbours in turn; a function of the seed and the templates."""
    source = random.Random(seed)
    of_one = [name for name in templates if name not in {"constants", "two coordinates"}]
    while count:
        family = source.choice([*of_one, *of_one, "constants", "two coordinates"])
        expression, bounds = _drawn(source, family, source.choice(templates[family]))
        false = count % 2 == 0
        if false:
            expression, bounds = _neighbour(source, expression, bounds)
        if (true := _truth(expression, bounds, source)) is None or true is false:
            continue
        count -= 1
        yield Identity(family, expression, bounds, true)


def _drawn(source: random.Random, family: str, template: tuple) -> tuple[sp.Expr, Bounds]:
    if family == "constants":
        return _read(template[0]), {}
    if family == "two coordinates":
        text, *ends = template
        a, b = (sp.Rational(source.choice((1, 1, 2, 3)), source.choice((1, 1, 2))) for _ in range(2))
        expression = _read(text).xreplace({X: a * X, Y: b * Y})
        pairs = [tuple(None if e is None else _read(e) / c for e in pair) for pair, c in zip(ends, (a, b), strict=True)]
        return expression, dict(zip((X, Y), pairs, strict=True))  # type: ignore[arg-type]
    text, low, high = template
    u = sp.Symbol("u", real=True)
    a, b = source.choice([(1, 0), (1, 0), (-1, 0), (_number(source), 0), (1, _number(source)), (-1, _number(source)),
                          (_number(source), _number(source))])  # fmt: skip
    ends = [None if e is None else (_read(e) - b) / a for e in (low, high)]
    expression = _read(text).subs(u, a * X + b)
    if source.random() < 0.2:
        expression *= source.choice((X**2 + 1, sp.cos(X), X, 1 + sp.exp(X)))
    return expression, {X: tuple(ends if a > 0 else ends[::-1])}  # type: ignore[dict-item]


def _neighbour(source: random.Random, expression: sp.Expr, bounds: Bounds) -> tuple[sp.Expr, Bounds]:
    """A changed sign, another branch, a tiny term, or the same on another domain."""
    terms = list(sp.Add.make_args(expression))
    kind = source.choice(("sign", "branch", "tiny", "tiny", "domain", "domain", "coefficient"))
    k = source.randrange(len(terms))
    if kind == "sign":
        terms[k] = -terms[k]
    elif kind == "branch":
        terms.append(source.choice((sp.pi, -sp.pi, sp.pi / 2, 2 * sp.pi, sp.pi / 4, sp.log(2))))
    elif kind == "coefficient":
        terms[k] *= 1 + sp.Rational(1, source.choice((2, 3, 10, 10**6)))
    elif kind == "domain" and bounds:
        changed = {}
        for s, (low, high) in bounds.items():
            new = source.choice([(None, None), (None, low), (high, None), (low, high)])
            changed[s] = (low, high) if new[0] is not None and new[0] == new[1] else new
        bounds = changed
    else:
        size = sp.Rational(1, 10 ** source.choice((6, 12, 20, 30)))
        terms.append(size * source.choice([sp.S.One, *(b for b in bounds)]))
    return sp.Add(*terms), bounds


def _truth(expression: sp.Expr, bounds: Bounds, source: random.Random) -> bool | None:
    """Whether it vanishes at many places of the domain at 60 digits; None where it is defined at none."""
    symbols = list(bounds)
    with mpmath.workdps(DIGITS):
        f = sp.lambdify(symbols, expression, "mpmath")
        known = 0
        for _ in range(20 * PLACES):
            place = [_place(*bounds[s], source) for s in symbols]
            try:
                value = f(*place)
            except (ZeroDivisionError, ValueError, OverflowError):
                continue
            if isinstance(value, mpmath.mpc) or not mpmath.isfinite(value):
                continue
            if abs(value) > ROUNDING:
                return False
            known += 1
            if known == PLACES or not symbols:
                break
        return True if known else None


def _place(low: sp.Expr | None, high: sp.Expr | None, source: random.Random) -> mpmath.mpf:
    fraction = mpmath.mpf(source.randint(1, 996)) / 997
    a, b = (None if e is None else mpmath.mpf(sp.N(e, DIGITS)) for e in (low, high))
    if a is not None and b is not None:
        return a + (b - a) * fraction
    distance = fraction * source.choice((1, 3, 10))
    if a is None and b is None:
        return distance * source.choice((-1, 1))
    return a + distance if a is not None else b - distance
