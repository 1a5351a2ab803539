"""Derivatives and numbers of a potential, part by part, against sympy's own."""

from __future__ import annotations

from itertools import combinations_with_replacement

import mpmath
import pytest
import sympy as sp

from hjsolve.algebra.shared_parts import common_parts, derivatives, holds, parts

x, y = sp.symbols("x y", real=True)
k, c = sp.symbols("k c", real=True)
f = sp.Function("f")
r1, r2 = sp.sqrt((x + 1) ** 2 + y**2), sp.sqrt((x - 1) ** 2 + y**2)
ξ, η = (r1 + r2) / 2, (r1 - r2) / 2
POTENTIALS = {
    "lens": (ξ * sp.sqrt(ξ**2 - 1) * sp.acosh(ξ) + η * sp.sqrt(1 - η**2) * (sp.acos(η) - c)) / (ξ**2 - η**2),
    "two centres": -k / r1 - c / r2,
    "symbolic power": x**y + (x**2 + y**2) ** k,
    "undetermined function": f(sp.sqrt(x**2 + y**2)) * x + f(x).diff(x),
    "creases": abs(x - y) + sp.sign(x) * y**2 + sp.atan2(y, x),
    "exponentials": sp.exp(2 * x + sp.sqrt(3) * y) / sp.cosh(x) + sp.log(1 + x**2) * sp.tan(y),
    "constant": sp.Integer(0),
}


@pytest.mark.parametrize("name", list(POTENTIALS))
def test_derivatives_are_those_of_sympy_as_they_stand(name):
    V = POTENTIALS[name]
    first = [sp.diff(V, q).doit() for q in (x, y)]
    second = [sp.diff(first[a], (x, y)[b]).doit() for a, b in combinations_with_replacement(range(2), 2)]
    assert list(derivatives(V, (x, y))) == first + second


def test_parts_are_each_met_once_in_the_order_of_a_traversal():
    V = POTENTIALS["lens"]
    assert parts([V, V + x]) == list(dict.fromkeys(sp.preorder_traversal(sp.Tuple(V, V + x))))[1:]


@pytest.mark.parametrize("name", list(POTENTIALS))
def test_an_expression_holds_its_free_symbols(name):
    for part in parts([POTENTIALS[name]]):
        assert holds(part, (x,)) == (x in part.free_symbols)


def test_named_parts_put_back_give_the_expressions():
    V = derivatives(POTENTIALS["lens"], (x, y))
    named, left = common_parts(V)
    assert len(named) > 20
    direct, shared = (sp.lambdify([x, y, c], V, "mpmath", cse=cse) for cse in (False, lambda _: (named, left)))
    with mpmath.workdps(60):
        place = [mpmath.mpf(p) / 7 for p in (3, 2, 11)]
        for a, b in zip(direct(*place), shared(*place), strict=True):
            assert abs(a - b) < mpmath.mpf(10) ** -55 * abs(a)
