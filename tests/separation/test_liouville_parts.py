"""The steps of Liouville form one by one: products and sums taken apart, also where only a base point does it."""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve.algebra.reader import Reader
from hjsolve.separation import Region
from hjsolve.separation.forms import liouville

x, y = sp.symbols("x y", positive=True)
BOUNDS = {x: (sp.S.Zero, None), y: (sp.S.Zero, None)}
SUMS = [
    x**2 + sp.sin(y) + 7,
    1 / (x + 1) + 1 / (y + 1) + 3,
    sp.S(5) + 0 * x,
    (x**2 + y**2 + 2) / ((x**2 + 1) * (y**2 + 1)),
]


@pytest.mark.parametrize("total", SUMS, ids=str)
def test_a_sum_is_taken_apart_and_adds_up_again(total: sp.Expr) -> None:
    reader = Reader([total], BOUNDS)
    parts = liouville.split_sum(reader, reader.element(total), (x, y))
    assert parts is not None
    written = [reader.write(part) for part in parts]
    assert sp.simplify(sp.Add(*written) - total) == 0
    assert not sp.simplify(written[0]).has(y)
    assert not sp.simplify(written[1]).has(x)


def test_constants_go_to_the_first() -> None:
    """To the first coordinate that has a function at all."""
    reader = Reader([x, y], BOUNDS)
    for total, expected in ((x + y**2 + 3, [x + 3, y**2]), (y**2 + 3, [0, y**2 + 3]), (x + 3, [x + 3, 0])):
        assert [reader.write(p) for p in liouville.split_sum(reader, reader.element(total), (x, y)) or ()] == expected
    assert [reader.write(p) for p in liouville.split_sum(reader, reader.element(sp.S(5)), (x, y)) or ()] == [5, 0]


@pytest.mark.parametrize(
    "product",
    [3 * x**2 * sp.sin(y) ** 2, 5 / (x * y + x + y + 1), 7 * (x + 1) / (y**2 + 2), 2 * sp.exp(x - y)],
    ids=str,
)
def test_a_product_is_taken_apart_and_multiplies_again(product: sp.Expr) -> None:
    reader = Reader([product], BOUNDS)
    element = reader.field.factored(reader.element(product))
    parts = liouville.split_product(reader, element, (x, y), 0, 1)
    assert parts is not None
    a, b = map(reader.write, parts)
    assert sp.simplify(a * b - product) == 0
    assert not sp.simplify(a).has(y)
    assert not sp.simplify(b).has(x)


def test_a_product_that_is_none_is_not_taken_apart() -> None:
    reader = Reader([x + y], BOUNDS)
    assert liouville.split_product(reader, reader.element(x + y), (x, y), 0, 1) is None


def test_a_symbol_that_only_seems_to_be_there_is_written_away() -> None:
    reader = Reader([x, y], BOUNDS)
    seeming = reader.element(x * y + x) / reader.element(y + 1)
    assert seeming.depends_on(y)
    other = sp.Symbol("z", positive=True)
    found = liouville._without(reader, seeming, [y, other])
    assert not found.depends_on(y)
    assert reader.write(found) == x


def test_the_sign_is_taken_where_it_is_certain() -> None:
    """At the first point of the region the value is exactly zero, which says nothing."""
    region = Region(BOUNDS)
    first = next(iter(region.points(x)))[x]
    for sign in (1, -1):
        expression = sign * (x - first) ** 2 / 10**6
        reader = Reader([expression], BOUNDS)
        assert liouville._sign_somewhere(reader, reader.element(expression), region) == sign


@pytest.mark.parametrize("missing", [0, 1])
def test_without_one_of_the_sums_there_is_no_form(missing: int, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = Reader([x, y], BOUNDS)
    metric = [reader.element(1 / (x + y))] * 2
    arguments = (reader, ["x", "y"], (x, y), metric, reader.element(x / (x + y)), Region(BOUNDS))
    assert liouville.recognise(*arguments) is not None
    original, calls = liouville.split_sum, []

    def failing(*given: object) -> object:
        calls.append(given)
        return None if len(calls) == missing + 1 else original(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(liouville, "split_sum", failing)
    assert liouville.recognise(*arguments) is None


def test_a_root_that_holds_a_product_is_taken_apart_at_a_base_point() -> None:
    """√((x + 1)(y + 1)) stays one root where the signs are unknown; the second factor is the one of y."""
    x, y = sp.symbols("x y", real=True)
    function = 3 * sp.sqrt(x * y + x + y + 1)
    reader = Reader([function])
    element = reader.element(function)
    for i, j in ((0, 1), (1, 0)):
        parts = liouville.split_product(reader, element, [x, y], i, j)
        assert parts is not None
        a, b = map(reader.write, parts)
        places = [{x: sp.Rational(1, 3), y: sp.Rational(k, 2)} for k in (1, 5)]
        assert all(abs((a * b - function).subs(at).evalf(40)) < 1e-35 for at in places)
        of_j = (x, y)[j]
        assert b.free_symbols == {of_j}
        other = [{of_j: sp.Rational(k, 3), (x, y)[i]: sp.Rational(2, 7)} for k in (1, 4)]
        assert abs((a.subs(other[0]) - a.subs(other[1])).evalf(40)) < 1e-35


def test_a_constant_factor_stays_with_the_first_at_a_base_point() -> None:
    x, y = sp.symbols("x y", real=True)
    seconds = []
    for constant in (3, 5):
        function = constant * sp.sqrt(x * y + x + y + 1)
        reader = Reader([function])
        parts = liouville.split_product(reader, reader.element(function), [x, y], 0, 1)
        assert parts is not None
        seconds.append(reader.write(parts[1]))
    assert seconds[0] == seconds[1]
