"""The proofs of separate() asked one by one: the filter is not a proof, every identity counts, coefficients lose nothing."""

from __future__ import annotations

from itertools import islice

import pytest
import sympy as sp

from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.energy_shell import reduce
from hjsolve.separation.constants.constants import inverse_stackel_matrix
from hjsolve.separation.forms import levi_civita, stackel
from hjsolve.separation.forms.base_points import find_base_points
from hjsolve.separation.forms.stackel import Matrix
from hjsolve.separation.obstruction import obstruction
from hjsolve.separation.zero_test.zero_test import NonZero, Unproved, is_zero
from tests.support.random_staeckel import case

x, y = sp.symbols("x y", positive=True)
px, py = sp.symbols("p_x p_y", real=True)


class Believer:
    """A filter that says "perhaps" to everything, as the modular filter must where it has no point."""

    def __init__(self, answer: bool | None):
        self.answer = answer

    def vanishes(self, products: object) -> bool | None:
        return self.answer


@pytest.mark.parametrize("answer", [None, True])
def test_what_the_filter_lets_through_is_still_proved(answer: bool | None) -> None:
    reader = Reader([x, y])
    zero, other = reader.element(x - x), reader.element(x * y)
    assert not levi_civita.sum_vanishes(reader, [[[other]]], Believer(answer))  # type: ignore[arg-type]
    assert levi_civita.sum_vanishes(reader, [[[zero]]], Believer(answer))  # type: ignore[arg-type]


def test_what_the_filter_excludes_is_not_expanded() -> None:
    reader = Reader([x])
    assert not levi_civita.sum_vanishes(reader, [[[reader.field.zero]]], Believer(False))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("expression", "count"),
    [
        ((px + y * py) ** 2 * (x * px + 1) / (x + y), 6),
        ((px + py) / (px - py), 1),
        ((px + y) ** 2 / (py + x), 1),
        ((px + y) ** 2 * (py + x) / (px * x + 1), 1),
        ((x + y) ** 2 * (x + px) / x, 2),
    ],
)
def test_coefficients_in_the_constants_lose_nothing(expression: sp.Expr, count: int) -> None:
    """The sum over the powers of p of the coefficients is the value at p = 1; at other p it is a polynomial or nothing."""
    reader = Reader([expression])
    parts = [reader.write(c) for c in levi_civita.coefficients(reader, reader.element(expression), [px, py])]
    assert len(parts) == count
    if count == 1:
        assert sp.simplify(parts[0] - expression) == 0
    else:
        assert not any(part.free_symbols & {px, py} for part in parts)
        expected = sp.Poly(sp.expand(expression * (x + y) * x), px, py).coeffs()
        ours = {sp.expand(sp.cancel(part * (x + y) * x)) for part in parts}
        assert ours == {sp.expand(sp.cancel(c)) for c in expected}


# polar coordinates: c = (1, 1/r²), Φ = [[1, −1/r²], [0, 1]], ψ = (V, 0)
r, θ = sp.symbols("r theta", positive=True)
GOOD = ([[1, -1 / r**2], [0, 1]], [r**3, 0])
BAD = [
    ([[1, -1 / r**2], [0, 2]], [r**3, 0]),
    ([[2, -1 / r**2], [0, 1]], [r**3, 0]),
    ([[1, -1 / r**2], [0, 1]], [r**3, 1]),
    ([[1, 1 / r**2], [0, 1]], [r**3, 0]),
]


def polar(matrix: tuple[list[list[object]], list[object]]):
    rows, column = matrix
    V = r**3
    reader = Reader([1 / r**2, V, *(sp.sympify(e) for row in rows for e in row), *map(sp.sympify, column)])

    def elements(row: list[object]):
        return [reader.element(sp.sympify(e)) for e in row]

    metric = [reader.field.one, reader.element(1 / r**2)]
    return reader, metric, reader.element(V), Matrix([elements(row) for row in rows], elements(column))


@pytest.mark.parametrize("check", [stackel.certified, stackel.plausible])
def test_every_identity_of_staeckel_counts(check) -> None:
    assert check(*polar(GOOD))
    for wrong in BAD:
        assert not check(*polar(wrong)), wrong


def test_an_open_question_carries_the_point_and_the_value_there() -> None:
    """Inverse functions of x·eˣ, on no algebraic curve: no proof, no witness, the value; 1e-30 away there is a witness."""
    r = sp.Symbol("x", positive=True)
    hidden = sp.atan(r * sp.exp(r)) + sp.atan(sp.exp(-r) / r) - sp.pi / 2
    assert isinstance(is_zero(hidden + sp.Rational(1, 10**30)), NonZero)
    answer = is_zero(hidden)
    assert isinstance(answer, Unproved)
    assert set(answer.point) == {"x"}
    assert answer.point["x"] > 0
    assert abs(answer.value) < sp.Float("1e-100")
    nothing = sp.Integral(sp.exp(-(x**2) * y), (x, 0, 1)) - y
    assert is_zero(nothing) == Unproved({}, None, is_zero(nothing).reason)


def test_base_points_bring_no_irrational_constants() -> None:
    """√5 and log 4 would be generators of the field for good; the square root is rational at x = 2, the logarithm formal."""
    function = sp.sqrt(x**2 + 5) * sp.log(x**2 + 4) + sp.sqrt(y**2 + 2) + sp.exp(2 * y)
    reader = Reader([function])
    element = reader.element(function)
    count = len(reader.field.generators)
    for point in islice(find_base_points(reader, [x, y]), 8):
        value = reader.write(point.keep(element, set()))
        assert value.is_Rational
        assert len(reader.field.generators) == count
        kept = reader.element(sp.sqrt(x**2 + 5)), reader.element(x)
        root, place = (reader.write(point.keep(e, set())) for e in kept)
        assert root**2 == place**2 + 5
    values = {reader.write(point.keep(element, set())) for point in islice(find_base_points(reader, [x, y]), 8)}
    assert len(values) > 4


def test_a_root_that_is_nowhere_rational_is_left_alone() -> None:
    """x² + y² = 3 has no rational points, and neither has √(3 − x²)."""
    reader = Reader([sp.sqrt(3 - x**2)], {x: (sp.Integer(-1), sp.Integer(1))})
    element = reader.element(sp.sqrt(3 - x**2))
    point = next(find_base_points(reader, [x]))
    assert not reader.write(point.keep(element, set())).is_Rational


@pytest.mark.nightly_cases("4")
@pytest.mark.parametrize("n", [2, 3, 4])
def test_the_inverse_of_staeckels_matrix_is_its_inverse_and_stays_small(n: int) -> None:
    system = case(100_000 * n + 3, n, separable=True).system
    shell = reduce(system)
    setting = obstruction.of_shell(shell, Reader().field.budget)
    reader, matrix = (
        setting.reader,
        stackel.construct(setting.reader, setting.symbols, setting.metric, setting.potential),
    )
    inverted = inverse_stackel_matrix(reader, matrix.rows, setting.metric)
    for i in range(n):
        for k in range(n):
            terms = [[[matrix.rows[i][j]], [inverted[j][k]]] for j in range(n)]
            assert levi_civita.sum_of_products(reader, [*terms, [[reader.field.coerce(-int(i == k))]]]).is_zero
    assert max(len(e.numerator) for row in inverted for e in row) < 200
