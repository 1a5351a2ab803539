"""Inverse charts: X(u(X)) is X to many digits, everywhere, on coordinate planes, axes, and close to all of them."""

from __future__ import annotations

import random

import pytest
import sympy as sp

from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.coordinates.charts.covering import covering_chart
from hjsolve.lowering import lower
from hjsolve.motion.charted.inverse_charts import inverse_chart

THIRD, HALF = sp.Rational(1, 3), sp.Rational(1, 2)
CASES = {
    "cartesian": {}, "polar": {}, "parabolic": {}, "elliptic": {"a": 2}, "circular cylinder": {},
    "elliptic cylinder": {"a": THIRD}, "parabolic cylinder": {}, "spherical": {}, "rotational parabolic": {},
    "prolate spheroidal": {"a": 2}, "oblate spheroidal": {"a": THIRD}, "conical": {"e1": 0, "e2": THIRD, "e3": 1},
    "ellipsoidal": {"a": 2, "a1": -1, "a2": HALF, "a3": 3}, "paraboloidal": {"a": 2, "b": -1, "c": HALF},
}  # fmt: skip
FIELD = Multi(2000)


def chart_of(kind: str):
    lengths = {name: sp.sympify(value) for name, value in CASES[kind].items()}
    n = 2 if kind in ("polar", "parabolic", "elliptic") else 3
    return n, lengths, covering_chart(kind, lengths, n, lambda name, _: sp.Symbol(name, real=True))


@pytest.mark.parametrize("kind", CASES)
def test_the_point_of_the_coordinates_of_a_point_is_the_point(kind: str) -> None:
    n, lengths, chart = chart_of(kind)
    c, dice = FIELD.context, random.Random(kind)
    tape = lower(chart.place, chart.symbols)
    numbers = {name: c.mpf(value.p) / value.q for name, value in lengths.items()}
    for _ in range(60):
        X = [c.mpf(dice.choice([0, 0, 1, -1, dice.uniform(-3, 3), 10 ** dice.uniform(-90, 3)])) for _ in range(n)]
        u = inverse_chart(kind, X, [c.zero] * n, numbers, FIELD)
        back = tape.run(FIELD, u)
        assert max(abs(a - b) for a, b in zip(X, back, strict=True)) <= c.mpf(10) ** -180 * (1 + max(map(abs, X)))


@pytest.mark.parametrize("kind", CASES)
def test_h_squared_is_the_metric_of_the_chart(kind: str) -> None:
    n, _, chart = chart_of(kind)
    J = sp.Matrix(chart.place).jacobian(chart.symbols)
    dice = random.Random(kind)
    c = multiprecision(200)
    for _ in range(5):
        u = [c.mpf(dice.uniform(0.2, 2.9)) for _ in range(n)]
        values = lower([*(J.T * J), *chart.scale], chart.symbols).run(Multi(200), u)
        for i in range(n):
            for j in range(n):
                wanted = values[n * n + i] if i == j else 0
                assert abs(values[i * n + j] - wanted) <= c.mpf(10) ** -50 * (1 + abs(values[n * n + i]))


@pytest.mark.parametrize("kind", ["elliptic", "prolate spheroidal", "conical", "ellipsoidal", "paraboloidal"])
def test_h_squared_of_a_covering_chart_does_not_cancel(kind: str) -> None:
    _, _, chart = chart_of(kind)
    for h in chart.scale:
        plain = sp.expand(h.subs({s: sp.Symbol(s.name, positive=True) for s in chart.symbols}))
        assert not any(term.could_extract_minus_sign() for term in sp.Add.make_args(sp.numer(sp.together(plain))))
