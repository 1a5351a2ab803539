"""Random analytic functions of one coordinate as text, and what mpmath makes of the textbook integrals over them.

The turning points are found by scanning and bisection, the integrals keep their end singularities and are done by
tanh-sinh quadrature at doubled precision: nothing here comes from hjsolve.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from hypothesis import strategies as st
from mpmath import mp, mpf

NEAR = 1e-7
"""Smaller than this, relative to its size, p² is called near zero in doubles, and the case is passed over."""


def coefficient(low: str = "-3", high: str = "3") -> st.SearchStrategy[str]:
    """A number of two decimals, as text."""
    return st.decimals(low, high, places=2).map(lambda x: format(x, "f"))


positive = coefficient("0.20", "4")
terms = st.one_of(
    st.tuples(coefficient(), st.integers(1, 4)).map(lambda t: f"({t[0]})*x**{t[1]}"),
    st.tuples(coefficient(), positive, coefficient()).map(lambda t: f"({t[0]})*sin({t[1]}*x + ({t[2]}))"),
    st.tuples(coefficient(), coefficient("-1.5", "1.5")).map(lambda t: f"({t[0]})*exp(({t[1]})*x)"),
    st.tuples(coefficient(), positive).map(lambda t: f"({t[0]})/(x**2 + {t[1]})"),
    st.tuples(coefficient(), positive).map(lambda t: f"({t[0]})*log(x**2 + {t[1]})"),
    st.tuples(coefficient(), positive).map(lambda t: f"({t[0]})*sqrt(x**2 + {t[1]})"),
    st.tuples(coefficient(), positive).map(lambda t: f"({t[0]})*cosh({t[1]}*x)*exp(-x**2)"),
    st.tuples(coefficient(), positive).map(lambda t: f"({t[0]})*cos(x**2/{t[1]})"),
)
potentials = st.lists(terms, min_size=1, max_size=4).map(" + ".join)
walls = positive.flatmap(lambda a: st.sampled_from([f"{a}*x**2", f"{a}*x**4", f"{a}*cosh(x)"]))
confining = st.tuples(potentials, walls).map(" + ".join)


@dataclass(frozen=True)
class Line:
    """Motion of one coordinate with q̇² = square(q); ``scan`` is the same in doubles."""

    square: Callable[[mpf], mpf]
    scan: Callable[[Any], Any]
    start: mpf

    def turning(self, reach: float = 60.0, count: int = 240_000) -> tuple[mpf | None, mpf | None] | None:
        """Return the zeros of q̇² next to the start, None for a side without; None alone where doubles cannot tell."""
        ends: list[mpf | None] = []
        for side in (-1, 1):
            far = np.geomspace(reach, 1e12, count // 4)[1:]  # a logarithm turns back far out
            grid = float(self.start) + side * np.concatenate([np.linspace(0, reach, count)[1:], far])
            with np.errstate(all="ignore"):
                values = np.broadcast_to(self.scan(grid), grid.shape)
            known = np.isfinite(values)
            stop = len(grid) if known.all() else int(np.argmin(known))
            negative = np.flatnonzero(values[:stop] < 0)
            first = int(negative[0]) if len(negative) else stop
            size = max(1.0, abs(float(values[0])))
            inner = values[: max(first - 3, 0)]
            dips = (inner[1:-1] < inner[:-2]) & (inner[1:-1] < inner[2:]) & (inner[1:-1] < NEAR**0.5 * size)
            if dips.any():
                return None
            if not len(negative):
                ends.append(None)
                continue
            inside = grid[first - 1] if first else float(self.start)
            ends.append(self._bisected(mp.mpf(inside), mp.mpf(grid[first])))
        return ends[0], ends[1]

    def _bisected(self, inside: mpf, outside: mpf) -> mpf:
        for _ in range(40):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self.square(middle) > 0 else (inside, middle)
        return mp.findroot(self.square, (inside, outside), solver="anderson", tol=mp.mpf(10) ** (10 - 2 * mp.dps))

    def time(self, a: mpf, b: mpf) -> mpf:
        """∫ dq/q̇ from a to b."""
        return integral(lambda x: 1 / mp.sqrt(abs(self.square(x)) or mp.eps), a, b)

    def mean(self, weight: Callable[[mpf], mpf], a: mpf, b: mpf) -> mpf:
        """(1/π) ∫ weight·q̇ dq between turning points."""
        return integral(lambda x: weight(x) * mp.sqrt(abs(self.square(x))), a, b) / mp.pi


ROUNDING_ERROR = 0.45
"""The error of an integral is below mp.eps to this power."""


def integral(function: Callable[[mpf], mpf], a: mpf, b: mpf) -> mpf:
    """By tanh-sinh rules to nearly half of the digits (a root in the integrand takes the others), ``ROUNDING_ERROR``.

    The rule tells its own error; where that is more, the way is cut into more pieces.
    """
    pieces, error, value = 1, mp.inf, mp.zero
    while error > abs(value) * mp.eps**ROUNDING_ERROR and pieces < 64:
        pieces *= 2
        value, error = mp.quad(function, mp.linspace(a, b, pieces + 1), error=True)
    return value


def line(potential: str, place: str, speed: str) -> tuple[Line, mpf]:
    """q̇² = v² + 2 (V(q₀) − V(q)) for a unit mass, and the energy."""
    x = sp.Symbol("x")
    V = sp.sympify(potential, rational=True)
    begin, velocity = sp.Rational(place), sp.Rational(speed)
    exact, doubles = sp.lambdify(x, V, "mpmath"), sp.lambdify(x, V, "numpy")
    q0 = mp.mpf(begin.p) / begin.q
    v0 = mp.mpf(velocity.p) / velocity.q
    level = exact(q0)
    return Line(
        lambda q: v0**2 + 2 * (level - exact(q)), lambda q: float(v0) ** 2 + 2 * (float(level) - doubles(q)), q0
    ), v0**2 / 2 + level


def degenerate(square: Line, ends: tuple[mpf | None, mpf | None]) -> bool:
    """True where the slope of q̇² at a turning point is lost in rounding: a multiple zero, for another test."""
    for end in ends:
        if end is not None:
            slope = mp.diff(square.square, end)
            if abs(slope) < math.sqrt(NEAR) * max(1, abs(mp.diff(square.square, end, 2))):
                return True
    return False
