"""The map from the user's coordinates to the separated ones as programs, with parameters and frame in numbers.

With X = A (x − o) the place in the frame of the web, P = B p or B v the momentum there, u near those of X:

    δu_k = Σᵢ (∂Xᵢ/∂u_k)(Xᵢ − Xᵢ(u))/h_k²    (Newton's step: the coordinates are orthogonal),     p_k = Σᵢ (∂Xᵢ/∂u_k) Pᵢ
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from hjsolve.arithmetic.error_free import Pair, split
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.tape import Tape
from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.errors import InternalError, InvalidInputError
from hjsolve.lowering import lower
from hjsolve.mechanics.system import mass_matrix
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.velocity_frame import COORDINATE, ORTHONORMAL
from hjsolve.solution.quadratures import Solution

_BITS, _NOUGHT = 600, 400
"""Bits of what a map holds, and of its entries that are 0 but for rounding: the inverse of a frame of condition 10⁶⁰
leaves 400 bits of 600."""
_SHORT = 20
"""Numbers of so many binary digits are written into the formulas, which then know them to be exact."""


@dataclass(frozen=True, eq=False)
class ChartMap:
    """Formulas and numbers of the map.

    Attributes:
        kind: of the chart.
        names: the separated system's coordinates in the order of ``Chart.symbols``.
        order: place of each coordinate of the system among these.
        lengths: named constants of the chart.
        local: X from (x, numbers); x are the user's coordinates, Cartesian or not.
        step: δu from (u, x, numbers).
        lifted: p_u from (u, x, p or v, numbers).
        numbers: values of the last inputs, in two doubles.
        edges: for each of the first two coordinates whether it has to be positive, and whether π is its end.
        unitless: for each coordinate whether it is not a length (an angle, a hyperbolic argument), so that its scale is
            1.
        model: of the separated system, whose constants and p² are used.
    """

    kind: str
    names: tuple[str, ...]
    order: tuple[int, ...]
    lengths: Mapping[str, float]
    local: Tape
    step: Tape
    lifted: Tape
    numbers: tuple[Pair, ...]
    edges: tuple[tuple[bool, bool], ...]
    unitless: tuple[bool, ...]
    model: Model


def chart_map(
    solution: Solution, model: Model, values: Mapping[sp.Symbol, sp.Expr], kind: str, frame: str = COORDINATE
) -> ChartMap:
    """Write the map of a solution in coordinates that were found.

    Args:
        solution: with a chart.
        model: of the same solution.
        values: every parameter → exact number.
        kind: ``p`` or ``velocity``, what comes with the places.
        frame: of the velocities (``motion.velocity_frame``).

    Raises:
        InvalidInputError: the web is none with these values of the parameters.
    """
    chart = solution.chart
    if chart is None:
        raise InternalError("a chart map of a solution without a chart")
    numbers = _Numbers(values)
    n, own = len(chart.symbols), [c.name for c in chart.original.coordinates]
    x = [sp.Symbol(f"_x{i}", real=True) for i in range(n)]
    rates = [sp.Symbol(f"_w{i}", real=True) for i in range(len(own))]
    place, momentum = _in_space(chart, x, rates, kind, frame)
    origin, inverse, forward = _frame(chart, numbers, kind)
    # x − o before the matrix: next to the centre of a web the difference keeps its digits
    X = [sum(inverse[i][j] * (place[j] - origin[j]) for j in range(n)) for i in range(n)]
    P = [sum(forward[i][j] * momentum[j] for j in range(n)) for i in range(n)]
    lengths = {name: numbers.value(e) for name, e in chart.lengths.items()}
    if any(not float(a) > 0 for name, a in lengths.items() if name == "a"):
        raise InvalidInputError(f"parameters: the {chart.kind} coordinates do not hold for these values")
    u = chart.symbols
    # the columns of J are orthogonal: Newton's step needs no inverse, only the scale factors
    J = [[sp.diff(place, s) for s in u] for place in chart.place]
    squared = [sp.S.One] * n if chart.kind == "normal modes" else list(chart.scale)
    moved = [sp.Symbol(f"_r{i}", real=True) for i in range(n)]
    rest = dict(zip(moved, (X[i] - chart.place[i] for i in range(n)), strict=True))
    steps = [
        sp.Add(*(J[i][k] * moved[i] for i in range(n) if J[i][k] != 0)).xreplace(rest) / squared[k] for k in range(n)
    ]
    shift = chart.linear or (sp.S.Zero,) * n
    lifted = [sp.Add(shift[k], *(J[i][k] * P[i] for i in range(n) if J[i][k] != 0)) for k in range(n)]
    fixed = [*(p.symbol for p in chart.system.parameters), *numbers.known]
    domains = [chart.system.coordinate(name).domain for name in chart.coordinates]
    names = [c.name for c in chart.system.coordinates]
    return ChartMap(
        chart.kind, chart.coordinates, tuple(chart.coordinates.index(name) for name in names),
        {name: float(a) for name, a in lengths.items()},
        lower(X, [*x, *fixed]), lower(steps, [*u, *x, *fixed]), lower(lifted, [*u, *x, *rates, *fixed]),
        (*(split(to_bits(values[p.symbol])(_BITS)) for p in chart.system.parameters), *numbers.known.values()),
        tuple((d.lower == 0, d.upper == sp.pi) for d in domains[:2]),
        tuple(d.kind == "angle" or s.has(sp.sin, sp.sinh) for d, s in zip(domains, _functions_of(chart), strict=True)),
        model,
    )  # fmt: skip


def _in_space(
    chart: Chart, x: list[sp.Symbol], rates: list[sp.Symbol], kind: str, frame: str
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """Return the point of space and its momentum (its velocity where T is Cartesian and velocities are given)."""
    outer = chart.outer
    own = chart.original.coordinates
    if not isinstance(outer, CurvilinearMap):
        at = dict(zip((c.symbol for c in own), x, strict=True))
        a = [e.xreplace(at) for e in outer.linear] if outer.linear and kind == "p" else [sp.S.Zero] * len(rates)
        return list(x), [rate - e for rate, e in zip(rates, a, strict=True)]
    at = dict(zip((c.symbol for c in own), x, strict=True))
    given = dict(zip((c.momentum for c in own), rates, strict=True))
    if kind == "velocity":
        power = 1 if frame == ORTHONORMAL else 2
        given = {p: outer.mass * h**power * v for (p, v), h in zip(given.items(), outer.scales, strict=True)}
    return (
        [sp.sympify(e).xreplace(at) for e in outer.place],
        [sp.cancel(sp.sympify(e).xreplace(given)).xreplace(at) for e in outer.momentum],
    )


def _functions_of(chart: Chart) -> list[sp.Expr]:
    """Return what of a coordinate occurs in X: sines of it, or itself."""
    return [
        sp.Add(*(f for place in chart.place for f in place.atoms(sp.sin, sp.cos, sp.sinh, sp.cosh) if f.has(s)))
        for s in chart.symbols
    ]


class _Numbers:
    """Numbers of a formula: short ones are written into it, the others become inputs."""

    def __init__(self, values: Mapping[sp.Symbol, sp.Expr]):
        self.values = dict(values)
        self.known: dict[sp.Symbol, Pair] = {}

    def value(self, e: sp.Expr) -> Any:
        return to_bits(sp.sympify(e).xreplace(self.values))(_BITS)

    def term(self, value: Any) -> sp.Expr:
        """Return a number of many digits as a term of a formula."""
        # a short binary number is exact in a formula, and costs no input of two doubles
        scaled = value * 2**_SHORT
        if scaled == int(scaled) and abs(scaled) < 2 ** (2 * _SHORT):
            return sp.Rational(int(scaled), 2**_SHORT)
        symbol = sp.Symbol(f"_c{len(self.known)}", real=True)
        self.known[symbol] = split(value)
        return symbol


def _frame(chart: Chart, numbers: _Numbers, kind: str) -> tuple[list[sp.Expr], Any, Any]:
    """Return the origin, frame⁻¹, and frameᵀ (times the masses where velocities are given), entry by entry."""
    c = Multi(_BITS).context
    frame = c.matrix([[numbers.value(e) for e in row] for row in chart.frame.tolist()])
    forward = frame.T
    if kind == "velocity" and not isinstance(chart.outer, CurvilinearMap):
        forward = forward * c.matrix([[numbers.value(e) for e in row] for row in mass_matrix(chart.original).tolist()])
    try:
        inverse = frame**-1
    except ZeroDivisionError:
        raise InvalidInputError(f"parameters: the {chart.kind} coordinates do not hold for these values") from None
    n = len(chart.symbols)

    def terms(matrix: Any) -> list[list[sp.Expr]]:
        # entries that are rounding of an inverse in 600 bits would be terms of every formula
        tiny = max(abs(x) for x in matrix) * c.mpf(2) ** -_NOUGHT
        rows = [[matrix[i, j] for j in range(n)] for i in range(n)]
        return [[numbers.term(_tidy(x, c)) if abs(x) > tiny else sp.S.Zero for x in row] for row in rows]

    return [numbers.term(numbers.value(o)) for o in chart.origin], terms(inverse), terms(forward)


def _tidy(x: Any, c: Any) -> Any:
    """Return a short binary number where x is one but for the rounding of an inverse matrix."""
    near = c.nint(x * 2**_SHORT) / 2**_SHORT
    return near if abs(near - x) <= abs(x) * c.mpf(2) ** (-_NOUGHT // 2) else x
