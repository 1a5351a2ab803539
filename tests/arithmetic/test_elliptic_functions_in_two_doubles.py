"""Elliptic functions in two doubles against mpmath in 50 digits: about 25 digits are right, whatever the arguments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from hjsolve.arithmetic.carlson_complex_pairs import part_at_a_complex_pole
from hjsolve.arithmetic.carlson_pairs import TwoDoubles, elliptic_function
from hjsolve.arithmetic.error_free import Pair
from hjsolve.functions import complex_pole, many_digits

_COUNT = 40
_OFF = 1e-22
"""Relatively: 25 digits, less what a principal value loses."""
P, S, U = (1e-5, 1e5), (-1e3, 1e3), (-7.0, 7.0)
CASES: list[tuple[str, Callable[..., Any], list[tuple[float, float]]]] = [
    ("CarlsonRF", mpmath.elliprf, [P, P, P]), ("CarlsonRC", mpmath.elliprc, [P, P]),
    ("CarlsonRC", many_digits.carlson_rc, [P, S]), ("CarlsonRD", mpmath.elliprd, [P, P, P]),
    ("CarlsonRJ", mpmath.elliprj, [P, P, P, P]), ("CarlsonRJ", many_digits.carlson_rj, [P, P, P, S]),
    ("elliptic_k", mpmath.ellipk, [(-3.0, 0.99)]), ("elliptic_f", mpmath.ellipf, [U, (-3.0, 0.99)]),
    ("elliptic_e", mpmath.ellipe, [U, (-3.0, 0.99)]), ("elliptic_e", mpmath.ellipe, [(-3.0, 0.99)]),
    ("elliptic_pi", mpmath.ellippi, [(-30.0, 0.9), (-1.5, 1.5), (-3.0, 0.99)]),
    ("elliptic_pi", mpmath.ellippi, [(-30.0, 0.9), (-3.0, 0.99)]),
    *((f"Jacobi{n}", getattr(many_digits, f"jacobi_{f}"), [U, (-3.0, 3.0)])
      for n, f in (("AM", "am"), ("SN", "sn"), ("CN", "cn"), ("DN", "dn"), ("Epsilon", "epsilon"))),
    *((f"Carlson{n}", getattr(complex_pole, f"carlson_{n.lower()}"), [P, S, S]) for n in ("RCRe", "RCIm")),
    *((f"Carlson{n}", getattr(complex_pole, f"carlson_{n.lower()}"), [P, P, P, S, S]) for n in ("RJRe", "RJIm")),
]  # fmt: skip


def _drawn(dice: np.random.Generator, low: float, high: float) -> Pair:
    sizes = 10 ** dice.uniform(np.log10(low), np.log10(high), _COUNT) if low > 0 else dice.uniform(low, high, _COUNT)
    return Pair(sizes, sizes * 2.0**-54 * dice.uniform(-1, 1, _COUNT))


@pytest.mark.parametrize(("name", "right", "ranges"), CASES)
def test_digits(name: str, right: Callable[..., Any], ranges: list[tuple[float, float]]) -> None:
    dice = np.random.default_rng(5)
    given = [_drawn(dice, *ends) for ends in ranges]
    with np.errstate(all="ignore"):
        if name.endswith(("Re", "Im")):
            part = part_at_a_complex_pole(name, *(TwoDoubles(*a) for a in given))
            found = Pair(part.high, part.low)
        else:
            found = elliptic_function(name, *given)
    with mpmath.workdps(50):
        for k in range(_COUNT):
            there = mpmath.re(right(*(mpmath.mpf(float(a.high[k])) + mpmath.mpf(float(a.low[k])) for a in given)))
            value = mpmath.mpf(float(found.high[k])) + mpmath.mpf(float(found.low[k]))
            assert abs(value - there) <= _OFF * abs(there)
