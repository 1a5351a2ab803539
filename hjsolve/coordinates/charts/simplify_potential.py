"""The potential carried to new coordinates, its radicals made rational where they are perfect squares.

In elliptic coordinates √((x − a)² + y²) = a (cosh μ − cos ν); sympy does not see that. Every radicand is written as a
polynomial with sinh² = cosh² − 1 and sin² = 1 − cos², factored, and its squares are pulled out with the sign they have
on the domain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import sympy as sp

from hjsolve.algebra.time_limit import check_time


@dataclass(frozen=True)
class ChangeOfVariables:
    """How to simplify in the new coordinates.

    Attributes:
        mapping: old symbol → expression in the new ones.
        sign: sign of an expression on the domain: 1, −1, or 0 where it changes or a parameter decides.
        assumed: collects what was taken to be positive where the sign is 0 (|c| is written c).
    """

    mapping: Mapping[sp.Symbol, sp.Expr]
    sign: Callable[[sp.Expr], int]
    assumed: set[sp.Expr]
    _visited: dict[sp.Expr, sp.Expr] = field(default_factory=dict)

    def carry(self, expression: sp.Expr) -> sp.Expr:
        """Return the expression in the new coordinates; its polynomial terms are brought together and reduced.

        Args:
            expression: in Cartesian coordinates.
        """
        result = self._visit(expression)
        polynomial, rest = sp.S.Zero, sp.S.Zero
        for term in sp.Add.make_args(result):
            flat = sp.expand(term)
            if _is_polynomial(flat):
                polynomial += flat
            else:
                rest += term
        return rest + self._short_coefficients(_circular(sp.expand(_reduced(sp.expand(polynomial)))))

    def _short_coefficients(self, polynomial: sp.Expr) -> sp.Expr:
        """Simplify coefficients that have symbolic radicals, so that those that vanish do."""
        new = sorted({s for value in self.mapping.values() for s in value.free_symbols}, key=str)
        surds = [p for p in polynomial.atoms(sp.Pow) if p.exp.is_Rational and not p.exp.is_Integer and p.free_symbols]
        if not surds or not polynomial.is_polynomial(*new):
            return polynomial
        terms = sp.Poly(polynomial, *new).terms()
        return sp.Add(
            *(
                sp.radsimp(sp.simplify(c)) * sp.prod([s**e for s, e in zip(new, powers, strict=True)])
                for powers, c in terms
            )
        )

    def _visit(self, node: sp.Expr) -> sp.Expr:
        if node not in self._visited:
            check_time()
            self._visited[node] = self._carried(node)
        return self._visited[node]

    def _carried(self, node: sp.Expr) -> sp.Expr:
        if node in self.mapping:
            return self.mapping[node]
        if not node.args or not node.free_symbols & set(self.mapping):
            return node
        if node.is_Pow:
            return self._power(self._visit(node.base), self._visit(node.exp))
        if isinstance(node, sp.Abs):
            return self._power(self._visit(node.args[0]) ** 2, sp.S.Half)
        arguments = [self._visit(argument) for argument in node.args]
        if isinstance(node, sp.Subs | sp.Derivative) or node.is_Mul or node.is_Add:
            return node.func(*arguments)
        return self._undone(node.func(*(short(argument) for argument in arguments)))

    def _undone(self, f: sp.Expr) -> sp.Expr:
        """Write acosh(cosh μ) = |μ| and, where sin ν > 0, acos(cos ν) = π/2 − asin(cos ν) = ν; of −cos ν likewise."""
        inner = f.args[0] if f.args else sp.S.Zero
        turned = inner.could_extract_minus_sign()
        inverse = -inner if turned else inner
        if isinstance(f, sp.acosh) and isinstance(inverse, sp.cosh) and not turned:
            return self._size(inverse.args[0])
        if isinstance(f, sp.acos | sp.asin) and isinstance(inverse, sp.cos) and inverse.args[0].is_Symbol:
            ν = inverse.args[0]
            if self.sign(sp.sin(ν)) < 0:
                return f
            self._size(sp.sin(ν))
            angle = sp.pi - ν if turned else ν
            return angle if isinstance(f, sp.acos) else sp.pi / 2 - angle
        return f

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
        base = short(base)
        if exponent.is_Integer:
            return base**exponent
        numerator, denominator = sp.fraction(sp.together(base))
        if denominator.free_symbols:
            return self._power(numerator, exponent) / self._power(denominator, exponent)
        root = self._denested(base) if exponent.is_Rational and exponent.q == 2 else None
        if root is not None:
            return root ** (2 * exponent)
        coefficient, factors = sp.factor_list(base) if base.is_Add or base.is_Mul or base.is_Pow else (base, [])
        inside, outside = coefficient, sp.S.One
        for factor, count in factors:
            whole = count // 2
            outside *= self._size(factor) ** (2 * whole * exponent) if whole else 1
            inside *= factor ** (count - 2 * whole)
        return self._rest(inside, exponent) * outside

    def _denested(self, base: sp.Expr) -> sp.Expr | None:
        """Write √(p + q), q one root of the coordinates, as √((p + d)/2) ± √((p − d)/2), d² = p² − q² a square."""
        new = {s for value in self.mapping.values() for s in value.free_symbols}
        terms = sp.Add.make_args(sp.expand(base))
        q = sp.Add(*(t for t in terms if any(_is_root(f) and f.free_symbols & new for f in sp.Mul.make_args(t))))
        p = sp.Add(*terms) - q
        if q == 0 or p == 0 or q.is_Add or self.sign(p) <= 0 or self.sign(q) == 0:
            return None
        coefficient, factors = sp.factor_list(short(p**2 - q**2))
        root = sp.sqrt(coefficient)
        if any(count % 2 for _, count in factors) or not root.is_Rational:
            return None
        d = root * sp.prod([factor ** (count // 2) for factor, count in factors])
        one, other = (self._power((p + s * d) / 2, sp.S.Half) for s in (1, -1))
        return one + other if self.sign(q) > 0 else self._size(one - other)

    def _size(self, factor: sp.Expr) -> sp.Expr:
        """Return |factor|; where its sign is open it is taken to be positive, and that is noted."""
        sign = self.sign(factor)
        if sign == 0:
            self.assumed.add(factor)
        return -factor if sign < 0 else factor

    def _rest(self, inside: sp.Expr, exponent: sp.Expr) -> sp.Expr:
        """Raise what is left, every factor that keeps its sign by itself."""
        if not inside.is_Mul:
            return inside**exponent
        signs = [self.sign(factor) for factor in inside.args]
        known = sp.prod([(s * f) ** exponent for s, f in zip(signs, inside.args, strict=True) if s])
        rest = sp.prod([s if s else f for s, f in zip(signs, inside.args, strict=True)])
        return known * rest**exponent if rest != -1 else inside**exponent


def _is_root(factor: sp.Expr) -> bool:
    return bool(factor.is_Pow and factor.exp.is_Rational and not factor.exp.is_Integer)


def _is_polynomial(expression: sp.Expr) -> bool:
    """Tell whether there are no radicals, quotients or functions but circular and hyperbolic ones."""
    simple = (sp.sin, sp.cos, sp.sinh, sp.cosh)
    return all(isinstance(f, simple) and f.args[0].is_Symbol for f in expression.atoms(sp.Function)) and all(
        (p.exp.is_Integer and (p.exp > 0 or p.base.is_Symbol)) or not p.free_symbols for p in expression.atoms(sp.Pow)
    )


def short(expression: sp.Expr) -> sp.Expr:
    """Return a short form: reduced by sinh² = cosh² − 1, sin² = 1 − cos², then factored.

    Args:
        expression: in the new coordinates.
    """
    if expression.is_Atom or expression.is_Function:
        return expression
    check_time()
    return _circular(sp.factor(_reduced(sp.together(expression))))


def _reduced(expression: sp.Expr) -> sp.Expr:
    arguments = {f.args[0] for f in expression.atoms(sp.sin, sp.sinh)}
    if not arguments:
        return sp.expand(expression) if not sp.denom(expression).free_symbols else expression
    numerator, denominator = (_by_cosine(sp.expand(part)) for part in sp.fraction(expression))
    return numerator / denominator


def _by_cosine(polynomial: sp.Expr) -> sp.Expr:
    for f in sorted(polynomial.atoms(sp.sin, sp.sinh), key=str):
        u = f.args[0]
        square = 1 - sp.cos(u) ** 2 if isinstance(f, sp.sin) else sp.cosh(u) ** 2 - 1
        polynomial = polynomial.replace(
            lambda node, f=f: node.is_Pow and node.base == f and node.exp.is_Integer and node.exp >= 2,
            lambda node, f=f, square=square: square ** (node.exp // 2) * f ** (node.exp % 2),
        )
        polynomial = sp.expand(polynomial)
    return polynomial


def _circular(expression: sp.Expr) -> sp.Expr:
    """Write (cos − 1)(cos + 1) as −sin² again, and (cosh − 1)(cosh + 1) as sinh²."""
    for f in sorted(expression.atoms(sp.cos, sp.cosh), key=str):
        u = f.args[0]
        other, sign = (sp.sin(u), -1) if isinstance(f, sp.cos) else (sp.sinh(u), 1)
        expression = expression.replace(
            lambda node: node.is_Mul, lambda *a, f=f, o=other, s=sign: _merge(sp.Mul(*a), f, o, s)
        )
    return expression


def _merge(node: sp.Expr, f: sp.Expr, other: sp.Expr, sign: int) -> sp.Expr:
    powers = node.as_powers_dict()
    down, up = powers.get(f - 1, sp.S.Zero), powers.get(f + 1, sp.S.Zero)
    if down == up and down != 0:
        return node / ((f - 1) ** down * (f + 1) ** up) * sp.Integer(sign) ** down * other ** (2 * down)
    return node
