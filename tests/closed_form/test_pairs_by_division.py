"""The complex pair next to named real roots, in doubles: against all roots of the same doubles to 60 digits."""

from __future__ import annotations

import random

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.closed_form.complements import ForDoubles
from hjsolve.closed_form.pairs_by_division import deflated_pair, remaining_pair
from hjsolve.functions import modules

X = sp.Symbol("x", real=True)
LETTERS = sp.symbols("a b c d e", real=True)


def _errors(sizes: tuple[float, ...], draw: random.Random) -> list[float]:
    """How far both parts are off, of the last place of the pair's size, of real roots so large and a pair of size 1."""
    angle = draw.uniform(0.2, np.pi - 0.2)
    roots = [draw.choice((-1, 1)) * size for size in sizes]
    coefficients = np.real(np.poly([*roots, np.exp(1j * angle), np.exp(-1j * angle)])) * draw.uniform(-3, 3)
    letters = LETTERS[: len(coefficients)]
    P = sp.Poly.from_list(list(letters), X)
    with mpmath.workdps(60):
        true = mpmath.polyroots([mpmath.mpf(float(c)) for c in coefficients], maxsteps=500, extraprec=600)
        pair = next(z for z in true if z.imag > 0.1)
        real = sorted(float(z.real) for z in true if abs(z.imag) < 1e-40)
    names = [sp.Symbol(f"x_{k + 1}", real=True) for k in range(len(roots))]
    where = {name: (P, k) for k, name in enumerate(names)}
    parts = remaining_pair(P, names)[0]
    along, across = sp.symbols("along across", real=True)
    arranged = ForDoubles({**where, along: parts[0], across: parts[1]}, {}).definitions([along, across])
    assert (arranged[along], arranged[across]) == deflated_pair(P, names)
    function = sp.lambdify([*letters, *names], [arranged[along], arranged[across]], modules=modules("numpy"))
    with np.errstate(all="ignore"):
        got = function(*map(np.float64, coefficients), *map(np.float64, real))
    return [abs(float(value) - float(part)) / 2**-53 for value, part in zip(got, (pair.real, pair.imag), strict=True)]


@pytest.mark.parametrize("sizes", [
    (1e-6,), (1e6,), (0.7,),
    (1e-3, 1e3), (1e3, 2e5), (1e-5, 2e-3), (0.6, 1.7), (2.0, 1e3),
], ids=str)  # fmt: skip
def test_a_pair_keeps_its_digits_next_to_roots_of_any_size(sizes: tuple[float, ...]) -> None:
    draw = random.Random(str(sizes))
    errors = [max(_errors(sizes, draw)) for _ in range(12)]
    assert max(errors) < 60  # units of the last place; by Vieta's formulas alone 1e6 and more where a root is 1e3
