"""From sympy expressions to boxes, in the notation of the mechanics books: ½ m ṙ², p_θ, sin²θ, ∂W/∂E."""

from __future__ import annotations

import re
from collections.abc import Callable

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational
from sympy.printing.str import StrPrinter
from sympy.simplify.fu import TR10i

from hjsolve.reports.formulas.abbreviations import abbreviated
from hjsolve.reports.formulas.layout import (
    Box,
    Definite,
    Fence,
    Fraction,
    Glyph,
    Grid,
    RadicalBox,
    RowBox,
    Script,
    row,
    width,
)
from hjsolve.reports.formulas.names import FUNCTION_NAMES, name_box

RELATIONS = {"==": "=", "!=": "≠", "<=": "≤", ">=": "≥", "<": "<", ">": ">"}
EULER = Glyph("e", "constant")
_FEW_TERMS, _MANY_TERMS, _LONGEST_CONTRACTED = 4, 6, 60
MINUS, PLUS, TIMES, APPLY = "−", "+", "⋅", "\u2061"


class InOrder(sp.Expr):
    """A sum whose terms are read in the order of the arguments."""

    def _sympystr(self, printer: StrPrinter) -> str:
        return str(printer.doprint(sp.Add(*self.args)))


def falling_powers(polynomial: sp.Poly) -> sp.Expr:
    """Write a polynomial in one variable by falling powers, each coefficient in few factors.

    Args:
        polynomial: of any degree.
    """
    x = polynomial.gen
    coefficients = [(n, sp.factor_terms(sp.factor(c))) for (n,), c in polynomial.terms()]
    terms = [term for n, c in coefficients for term in (sp.Add.make_args(c) if n == 0 else [c * x**n])]
    return InOrder(*terms) if len(terms) > 1 else polynomial.as_expr()


def contracted(expression: sp.Expr) -> sp.Expr:
    """Write products of sines and cosines of two angles by their difference or sum, where that is shorter.

    Args:
        expression: any expression; a long one comes back as it is.
    """
    angles = {f.args[0] for f in expression.atoms(sp.sin, sp.cos)}
    if len(angles) < 2 or sp.count_ops(expression) > _LONGEST_CONTRACTED:
        return expression
    return min((expression, TR10i(expression)), key=sp.count_ops)


def box(expression: sp.Basic) -> Box:
    """Lay out an expression, an equation or a matrix.

    Args:
        expression: any sympy object; kinds unknown here are set as the text sympy gives them.

    Returns:
        The box.
    """
    return _box(abbreviated(expression))


def _box(expression: sp.Basic) -> Box:
    for kind, method in _METHODS:
        if isinstance(expression, kind):
            return method(expression)
    return Glyph(str(expression), "text")


def constants_outside(expression: sp.Basic) -> sp.Basic:
    """Take constant factors and signs out of integrals, for reading; the value stays the same."""
    return expression.replace(lambda e: isinstance(e, sp.Integral), _outside)


def compact(expression: sp.Expr, level: sp.Symbol | None = None) -> sp.Expr:
    """Write a long sum of quotients in fewer factors, where that is shorter.

    Args:
        expression: any expression.
        level: a symbol of which the expression may be linear; it is then written as A (level − V), like 2m (E − V).

    Returns:
        An equal expression: as it is, as one fraction with its factors apart, or by the level.
    """
    if len(sp.Add.make_args(expression)) <= _FEW_TERMS:
        return expression
    forms = [expression]
    if level is not None and expression.has(level):
        A = sp.factor(sp.cancel(sp.diff(expression, level)))
        rest = sp.expand(sp.cancel((expression - A * level) / A)) if not A.has(level) else None
        if rest is not None and not rest.has(level):
            inside = (sp.Add(*map(sp.factor, sp.Add.make_args(rest))), _by_denominators(rest))
            forms += [sp.Mul(*_without_sign(A), level + V, evaluate=False) for V in inside]
    if len(sp.Add.make_args(expression)) > _MANY_TERMS and expression.is_rational_function():
        forms.append(sp.factor(sp.together(expression)))
    return min(forms, key=sp.count_ops)


def _without_sign(product: sp.Expr) -> list[sp.Expr]:
    """Return the factors of a product, a minus before it taken into the first sum."""
    coefficient, rest = product.as_coeff_Mul()
    factors = list(sp.Mul.make_args(rest))
    sums = [k for k, f in enumerate(factors) if f.is_Add and sum(t.could_extract_minus_sign() for t in f.args) > 1]
    if coefficient.is_negative and sums:
        coefficient, factors[sums[0]] = -coefficient, -factors[sums[0]]
    return [*([coefficient] if coefficient != 1 else []), *factors]


def _by_denominators(expression: sp.Expr) -> sp.Expr:
    """Add up the terms that have the same denominator, each sum factored."""
    groups: dict[sp.Expr, sp.Expr] = {}
    for term in sp.Add.make_args(expression):
        over, under = sp.fraction(sp.factor(term))
        groups[under] = groups.get(under, sp.S.Zero) + over
    return sp.Add(*(sp.factor(sp.cancel(over / under)) for under, over in groups.items()))


def _outside(integral: sp.Integral) -> sp.Expr:
    variables = [limit[0] for limit in integral.limits]
    # what stands under a root is kept as it is written
    radicands = {
        p.base for p in integral.function.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2 and p.base.is_Add
    }
    hidden = {radicand: sp.Dummy(positive=True) for radicand in radicands}
    shown = {dummy: radicand for radicand, dummy in hidden.items()}
    factored = sp.factor_terms(integral.function.xreplace(hidden)).xreplace(shown)
    constant, rest = factored.as_independent(*variables, as_Add=False)
    return constant * sp.Integral(rest, *integral.limits)


# ------------------------------------------------------------------------------------------------ sums and products
def _terms(expression: sp.Add | InOrder) -> list[sp.Expr]:
    """Give the terms in sympy's order, powers of the time rising, functions last, the first one positive if any is.

    So 1 + e cos θ, and y₀ + v (t − t₀) − ½ g (t − t₀)². A number stands before quotients: 1 + 2EL²/mk².
    """
    if isinstance(expression, InOrder):
        return list(expression.args)
    quotients = any(sp.fraction(term)[1].free_symbols for term in expression.args)
    terms = sorted(
        expression.as_ordered_terms(),
        key=lambda term: (
            bool(term.atoms(sp.Function) - term.atoms(sp.Abs, sp.sign)),
            _power_of_time(term),
            quotients and not term.is_number,
        ),
    )
    first = next((i for i, term in enumerate(terms) if not term.could_extract_minus_sign()), 0)
    return [terms[first], *terms[:first], *terms[first + 1 :]]


def _power_of_time(term: sp.Expr) -> sp.Rational:
    """Return the exponent of the factor that holds t; a term without the time has 0."""
    exponents = [
        exponent
        for base, exponent in term.as_powers_dict().items()
        if exponent.is_Rational and any(s.name == "t" for s in base.free_symbols)
    ]
    return sum(exponents, sp.S.Zero)


def _signed_terms(expression: sp.Add | InOrder) -> list[Box]:
    boxes: list[Box] = []
    for i, term in enumerate(_terms(expression)):
        negative = term.could_extract_minus_sign()
        body = _operand(-term if negative else term)
        sign = MINUS if negative else PLUS
        boxes.append(row(Glyph(sign, "operator"), body) if i or negative else body)
    return boxes


def _operand(term: sp.Expr) -> Box:
    return Fence(_box(term)) if isinstance(term, sp.Add | Relational) else _box(term)


def _sum(expression: sp.Add | InOrder) -> Box:
    return row(*_signed_terms(expression))


def _factor_key(factor: sp.Expr, momenta: set[str]) -> int:
    """Order factors as physicists do: numbers, masses, E, letters, p, the q of a p, sin θ, sums, calls, signs, ∫."""
    base = factor.base if isinstance(factor, sp.Pow) else factor
    if factor.is_number:
        return 0
    if isinstance(base, sp.Symbol):
        if re.fullmatch(r"[mM]\d*|mu|m_\w+", base.name):
            return 1
        if f"p_{base.name}" in momenta:
            return 5
        return 4 if base.name.startswith(("dot(", "p_")) else 2 if re.fullmatch(r"E|alpha_\d+", base.name) else 3
    if isinstance(base, sp.sign):
        return 9
    if isinstance(base, sp.Function):
        return 6 if all(a.is_Symbol for a in base.args) else 8
    return 10 if isinstance(factor, sp.Integral) else 7


def _ordered_factors(product: sp.Expr) -> list[sp.Expr]:
    momenta = {symbol.name for symbol in product.free_symbols if symbol.name.startswith("p_")}
    return sorted(product.as_ordered_factors(), key=lambda factor: _factor_key(factor, momenta))


def _roots_joined(coefficient: sp.Expr, factors: list[sp.Expr]) -> tuple[sp.Expr, list[sp.Expr]]:
    """Write several square roots as one, as printed formulas are real: √(2E/k) for √2 √E/√k.

    Args:
        coefficient: the rational number in front.
        factors: the others.

    Returns:
        Both, the root before the first sum, function or integral: ½ √2 √E is √(E/2).
    """
    half = sp.Rational(1, 2)
    roots = [f for f in factors if f.is_Pow and abs(f.exp) == half and _may_join(f.base)]
    if len(roots) < 2 or all(f.is_number for f in roots):
        return coefficient, factors
    under = sp.Mul(*[f.base ** (2 * f.exp) for f in roots])
    for number in (f.base for f in roots if f.is_number):
        if coefficient.is_Rational and coefficient.q % number == 0 and number in (f.base for f in roots if f.exp > 0):
            under, coefficient = under / number**2, coefficient * number
    above, below = sp.fraction(under)
    joined = sp.Pow(below, -half, evaluate=False) if above == 1 else sp.Pow(under, half, evaluate=False)
    kept = [f for f in factors if f not in roots]
    place = next((i for i, f in enumerate(kept) if not f.as_base_exp()[0].is_Symbol), len(kept))
    return coefficient, [*kept[:place], joined, *kept[place:]]


def _may_join(base: sp.Expr) -> bool:
    return not base.is_number or bool(base.is_Integer and base.is_positive)


def _product(expression: sp.Mul) -> Box:
    if expression.could_extract_minus_sign():
        return row(Glyph(MINUS, "operator"), _operand(-expression))
    coefficient, rest = expression.as_coeff_Mul()
    above: list[sp.Expr] = []
    below: list[sp.Expr] = []
    coefficient, factors = _roots_joined(coefficient, _ordered_factors(rest))
    for factor in factors:
        base, exponent = factor.as_base_exp()
        if base is not sp.E and exponent.is_Rational and exponent.is_negative and not base.is_Integer:
            below.append(base ** (-exponent))
        else:
            above.append(factor)
    if not isinstance(coefficient, sp.Rational):
        return _side_by_side([coefficient, *above], below)
    if coefficient.q != 1 and not below and (not rest.is_number or rest.has(sp.Function)):  # but π/2, √6/12
        return row(_box(coefficient), _side_by_side(above, []))
    top = [sp.Integer(coefficient.p)] if coefficient.p != 1 or not above else []
    bottom = [sp.Integer(coefficient.q)] if coefficient.q != 1 else []
    loose = [f for f in above if isinstance(f, sp.Integral)]
    if loose and not bottom + below:  # a sum before an integral keeps its parentheses
        return _side_by_side([*top, *above], [])
    fraction = _side_by_side(top + [f for f in above if f not in loose], bottom + below)
    return row(fraction, *map(box, loose)) if loose else fraction


def _side_by_side(above: list[sp.Expr], below: list[sp.Expr]) -> Box:
    if below:
        return Fraction(_side_by_side(above or [sp.Integer(1)], []), _side_by_side(below, []))
    if len(above) == 1:
        return _box(above[0])
    boxes: list[Box] = []
    for factor in above:
        item = Fence(_box(factor)) if isinstance(factor, sp.Add | Relational) else _box(factor)
        if boxes and isinstance(boxes[-1], Glyph) and boxes[-1].kind == "number" and _starts_with_number(item):
            boxes.append(Glyph(TIMES, "operator"))
        boxes.append(item)
    return row(*boxes)


def _starts_with_number(item: Box) -> bool:
    first = item.base if isinstance(item, Script) else item
    return isinstance(first, Fraction) or (isinstance(first, Glyph) and first.kind == "number")


# ------------------------------------------------------------------------------------------------ powers and functions
def _power(expression: sp.Pow) -> Box:
    base, exponent = expression.as_base_exp()
    if exponent.is_Rational and exponent.is_negative:
        return Fraction(Glyph("1", "number"), _box(base ** (-exponent)))
    if exponent.is_Rational and exponent.p == 1 and exponent.q != 1:
        return RadicalBox(_under_root(base), None if exponent.q == 2 else Glyph(str(exponent.q), "number"))
    if isinstance(base, sp.Function) and not isinstance(base, sp.exp | sp.Abs | AppliedUndef) and exponent.is_Integer:
        return _call(base, _box(exponent))
    if isinstance(base, sp.Symbol):
        inner = name_box(base.name)
        power = on_a_line(_box(exponent))
        return Script(inner.base, inner.sub, power) if isinstance(inner, Script) else Script(inner, sup=power)
    bare = isinstance(base, sp.NumberSymbol | sp.exp) or (base.is_Integer and base.is_nonnegative)
    return Script(_box(base) if bare else Fence(_box(base)), sup=on_a_line(_box(exponent)))


def _under_root(base: sp.Expr) -> Box:
    """One fraction, not a half in front: √(m/2)."""
    coefficient, rest = base.as_coeff_Mul()
    if not base.is_Mul or not coefficient.is_Rational or coefficient.q == 1 or base.could_extract_minus_sign():
        return _box(base)
    above, below = sp.fraction(rest)
    return Fraction(_box(coefficient.p * above), _box(coefficient.q * below))


def on_a_line(inner: Box) -> Box:
    """Set a formula that shall not grow in height, such as an exponent: with slashes where it has fractions."""
    items = inner.items if isinstance(inner, RowBox) else (inner,)
    flat: list[Box] = []
    for item, following in zip(items, [*items[1:], None]):
        factor = following is not None and not (isinstance(following, Glyph) and following.kind == "operator")
        flat.append(Fence(_slashed(item)) if factor and isinstance(item, Fraction) else _slashed(item))
    return row(*flat)


def _slashed(item: Box) -> Box:
    if not isinstance(item, Fraction):
        return item
    top, bottom = (Fence(part) if _compound(part) else part for part in (item.top, item.bottom))
    return row(top, Glyph("/", "operator"), Fence(bottom) if isinstance(bottom, RowBox) else bottom)


def _compound(part: Box) -> bool:
    return isinstance(part, RowBox) and any(
        isinstance(item, Glyph) and item.text in {PLUS, MINUS} for item in part.items
    )


def _call(expression: sp.Function, power: Box | None = None) -> Box:
    name = type(expression).__name__
    shown = FUNCTION_NAMES.get(name, name)
    head: Box = Glyph(shown, "function")
    if isinstance(expression, AppliedUndef) or "_" in FUNCTION_NAMES.get(name, ""):
        head = _callable(name_box(shown))
    head = Script(head, sup=power) if power is not None else head
    arguments: list[Box] = []
    for i, argument in enumerate(expression.args):
        arguments += ([Glyph(",", "operator")] if i else []) + [_box(argument)]
    if len(expression.args) == 1 and _simple(expression.args[0]) and not isinstance(expression, AppliedUndef):
        return row(head, Glyph(APPLY, "operator"), arguments[0])
    return row(head, Fence(row(*arguments)))


def applied(name: Box, argument: Box) -> Box:
    """Set a coordinate as a function: θ(t).

    Args:
        argument: what it is a function of.
    """
    return row(_callable(name), Fence(argument))


def _callable(shown: Box) -> Box:
    """Return the name of a function that is not known: v₁ of v₁(r)."""
    if isinstance(shown, Script):
        return Script(_callable(shown.base), shown.sub, shown.sup)
    return Glyph(shown.text, "function") if isinstance(shown, Glyph) else shown


def _simple(argument: sp.Expr) -> bool:
    return isinstance(argument, sp.Symbol)


def _exponential(expression: sp.exp) -> Box:
    inner = on_a_line(_box(expression.args[0]))
    if width(inner) > 14:
        return row(Glyph("exp", "function"), Fence(inner))
    return Script(EULER, sup=inner)


# ------------------------------------------------------------------------------------------------ calculus and the rest
def _integral(expression: sp.Integral) -> Box:
    inner = _box(expression.function)
    if isinstance(expression.function, sp.Add):
        inner = Fence(inner)
    for limit in expression.limits:
        lower = _box(limit[1]) if len(limit) == 3 else None
        upper = _box(limit[-1]) if len(limit) > 1 else None
        inner = Definite("∫", inner, lower, upper, _box(limit[0]))
    return inner


def _derivative(expression: sp.Derivative) -> Box:
    order = sum(count for _, count in expression.variable_count)
    partial = len(expression.expr.free_symbols) > 1 or len(expression.variable_count) > 1
    d = Glyph("∂" if partial else "d", "differential")
    bottom: list[Box] = []
    for variable, count in expression.variable_count:
        bottom += [d, Script(_box(variable), sup=Glyph(str(count), "number")) if count != 1 else _box(variable)]
    top = d if order == 1 else Script(d, sup=Glyph(str(order), "number"))
    return Fraction(row(top, _operand(expression.expr)), row(*bottom))


def _rational(expression: sp.Rational) -> Box:
    sign = [Glyph(MINUS, "operator")] if expression.p < 0 else []
    top = Glyph(str(abs(expression.p)), "number")
    return row(*sign, top if expression.q == 1 else Fraction(top, Glyph(str(expression.q), "number")))


def _float(expression: sp.Float) -> Box:
    text = repr(float(expression)) if expression._prec <= 53 else str(expression)
    mantissa, _, exponent = text.partition("e")
    sign = [Glyph(MINUS, "operator")] if mantissa.startswith("-") else []
    number: Box = Glyph(mantissa.lstrip("-"), "number")
    if exponent:
        ten = Script(Glyph("10", "number"), sup=_box(sp.Integer(int(exponent))))
        number = row(number, Glyph("×", "operator"), ten)
    return row(*sign, number)


def _relation(expression: Relational) -> Box:
    sign = Glyph(RELATIONS[expression.rel_op], "operator")
    return row(_box(expression.lhs), sign, _box(expression.rhs))


def _matrix(expression: sp.MatrixBase) -> Box:
    rows = tuple(tuple(_box(expression[i, j]) for j in range(expression.cols)) for i in range(expression.rows))
    return Grid(rows, "(", ")", "c" * expression.cols)


def _piecewise(expression: sp.Piecewise) -> Box:
    otherwise = Glyph("otherwise", "text")
    rows = tuple(
        (_box(value), otherwise if condition == sp.true else row(Glyph("if ", "text"), _box(condition)))
        for value, condition in expression.args
    )
    return Grid(rows, "{", "", "ll")


def _constant(expression: sp.Basic) -> Box:
    texts = {sp.pi: "π", sp.E: "e", sp.I: "i", sp.oo: "∞", sp.zoo: "∞̃", sp.nan: "undefined"}
    if expression is sp.S.NegativeInfinity:
        return row(Glyph(MINUS, "operator"), Glyph("∞", "number"))
    return EULER if expression is sp.E else Glyph(texts.get(expression, str(expression)), "identifier")


def _tuple(expression: sp.Tuple) -> Box:
    items: list[Box] = []
    for i, item in enumerate(expression):
        items += ([Glyph(",", "operator")] if i else []) + [_box(item)]
    return Fence(row(*items) if items else Glyph("", "text"))


_METHODS: tuple[tuple[type | tuple[type, ...], Callable[[sp.Basic], Box]], ...] = (
    (sp.Symbol, lambda e: name_box(e.name)),
    (sp.Rational, _rational),
    (sp.Float, _float),
    ((sp.NumberSymbol, type(sp.I), type(sp.oo), type(-sp.oo), type(sp.zoo), type(sp.nan)), _constant),
    (sp.Add, _sum),
    (InOrder, _sum),
    (sp.Mul, _product),
    (sp.exp, _exponential),
    (sp.Pow, _power),
    (sp.Abs, lambda e: Fence(_box(e.args[0]), "|", "|")),
    (sp.Piecewise, _piecewise),
    (sp.Function, _call),
    (sp.Integral, _integral),
    (sp.Derivative, _derivative),
    (Relational, _relation),
    (sp.MatrixBase, _matrix),
    (sp.Tuple, _tuple),
)
