"""Common factors leave radicands, denominators and quotients, and nothing changes its value."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.common_factors import with_common_factors
from hjsolve.closed_form.tidy import factored, operations

a, b, c, E, p = sp.symbols("a b c E p", real=True)
m, n = sp.symbols("m n", positive=True)

CASES = (
    (sp.sqrt(2 * E * m**2 + 3 * E * m * n + E * n**2), sp.sqrt(E * (m + n) * (2 * m + n))),
    (sp.sqrt(a**2 - 2 * a * b + b**2 - c), sp.sqrt((a - b) ** 2 - c)),
    ((m**2 - n**2) / (m - n), m + n),
    (1 / sp.Add(2 * m, 2 * n), 1 / (m + n) / 2),
    (sp.asin(a / sp.sqrt(4 * E**2 * b**2 + 4 * E * b * c + c**2 + p)), sp.asin(a / sp.sqrt((2 * E * b + c) ** 2 + p))),
    (sp.sqrt(a + E * b * c * (n + m) - E * b * c * p).expand(), sp.sqrt(a + E * b * c * (n + m - p))),
)
AS_BEFORE = (sp.sqrt(2 * E * m - p**2), sp.sqrt(1 - a**2 / b**2), sp.sqrt(E - a / m - b / m), a * b + a * c, sp.sqrt(p + a * b + a * c + a * E),
             (a * b + a * c) / (b + c * E), sp.sqrt(-2 * E * m - 2 * E * n - 2 * E * b), sp.sqrt(2 * a + 2 * b))  # fmt: skip


@pytest.mark.parametrize(("typed", "wanted"), CASES)
def test_common_factors_are_taken_out(typed, wanted):
    made = with_common_factors(typed)
    assert operations(made) <= operations(wanted) < operations(typed)
    at = {a: 2, b: sp.Rational(1, 3), c: sp.Rational(1, 7), E: 5, p: sp.Rational(1, 2), m: 3, n: 2}
    assert abs(sp.N((made - typed).subs(at), 30)) < 1e-25


@pytest.mark.parametrize("typed", AS_BEFORE)
def test_what_is_not_shorter_in_factors_stays(typed):
    assert with_common_factors(typed) == typed


def test_a_block_on_a_wedge_is_printed_with_its_masses_in_factors():
    motion = next(iter(hjsolve.catalog.describe("block-on-wedge").motions.values())).arguments
    form = own_form(hjsolve.solve("block-on-wedge").motion(**motion))
    m1, m2 = (next(s for s in form.time_law.rhs.free_symbols if s.name == name) for name in ("m1", "m2"))
    sums = {e.base for e in form.time_law.rhs.atoms(sp.Pow)}
    assert {m1 + m2, 2 * m1 + m2} <= sums
    assert sp.count_ops(form.time_law.rhs) < 60


def test_a_radicand_without_factors_is_seen_without_sympy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sympy sought factors of Kerr's radicand, with two of its coefficients named, for 16 s in some runs."""
    r, E, M, a, p, P, alpha, c, d = sp.symbols("r E M a p_phi p_t alpha_2 c c_1", real=True)
    radicand = r**4 * (2 * E + P**2) - 4 * E * M * r**3 + 4 * M * r * (a * p * P + alpha) + c + d * r**2

    def refuse(_: sp.Expr) -> sp.Expr:
        raise AssertionError("sympy was asked for factors")

    with monkeypatch.context() as without:
        without.setattr(sp, "factor", refuse)
        made = factored(radicand)
    assert made == sp.expand(radicand)


@pytest.mark.parametrize("number", [1, -1, 6, sp.Rational(-4, 3)])
def test_factors_are_those_of_sympy(number: sp.Expr) -> None:
    a, b, c, d = sp.symbols("a b c d", real=True)
    plain = [a + b + c + d + a * b, a**2 - b**2 + c**2 - d + 1, 2 * a * b + 2 * c * d - 4 * a - 6 * b + 8]
    products = [(a + b) * (c + d + 1), (a - b * c) * (a + b - d), (a + b) ** 2 * (c - d)]
    for total in (*plain, *map(sp.expand, products)):
        wanted = sp.factor(number * total)
        assert str(factored(sp.expand(number * total))) == str(wanted)
