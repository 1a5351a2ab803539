"""What a separation constant is: an energy of a part, an angular momentum, a Runge–Lenz component, Carter's constant.

A constant α = ½ Σ wᵢPᵢ² + U is compared with a known integral K: α = aK + bE + Σ d c c′ + const, with a, b, d free of
coordinates. Two of the coefficients of pᵢ² at a base point give a and b; the rest of the identity is then proved by the
exact zero test. Where U keeps a function of the coordinates, K is the integral of the free motion that α continues.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import mpmath
import sympy as sp

from ..algebra.field import Element
from ..algebra.poly import WorkLimitError
from ..algebra.readable import readable
from ..algebra.reader import Reader
from ..evaluation import CONTEXT, NoValueError, evaluate
from ..shell import Shell
from ..system import System, inverse_mass_matrix, linear_terms, mass_matrix
from .basepoint import base_points
from .charts import Integral, of_dimension

MAX_SIZE = 400
MAX_POINTS = 4
Quadratic = dict[tuple[str, str], Element]


@dataclass(frozen=True)
class Known:
    """A known integral in the coordinates of a system.

    Attributes:
        symbol, meaning: as in ``charts.Integral``.
        form: coefficient of p_a p_b by names of coordinates, a ≤ b in the order of the system.
        attracted: what a centre of force adds, up to a factor, or None.
        with_centre: the meaning then.
    """

    symbol: sp.Expr
    meaning: str
    form: Quadratic
    attracted: Element | None = None
    with_centre: str = ""


class Naming:
    """Names for the separation constants of one shell.

    Args:
        shell: the shell.
        reader: reader of its field.
    """

    def __init__(self, shell: Shell, reader: Reader):
        self.shell, self.reader, self.system = shell, reader, shell.system
        self.names = [c.name for c in self.system.coordinates]
        self.symbols = [c.symbol for c in shell.coordinates]
        self.usable = not any(shell.shift) and sp.count_ops(shell.system.kinetic) <= MAX_SIZE
        self._known: list[Known] | None = None

    def __call__(self, weights: Sequence[Element], column: Sequence[Element]) -> str:
        """The meaning of α = Σ wᵢ(½Pᵢ² + ψᵢ), or nothing where it is not known."""
        if not self.usable:
            return ""
        try:
            total = self.reader.field.total(w * ψ for w, ψ in zip(weights, column))
            return self._energy_of_part(weights, total) or self._integral(weights, total)
        except (WorkLimitError, ZeroDivisionError):
            return ""

    # ---------------------------------------------------------------- a part that moves by itself

    def _energy_of_part(self, weights: Sequence[Element], U: Element) -> str:
        """α = λ(½ Σ gⁱⁱpᵢ² + V_part) over some coordinates, with g and V of these alone."""
        moving = [k for k, w in enumerate(weights) if not w.is_zero]
        others = [q for k, q in enumerate(self.symbols) if k not in moving]
        metric = [self.reader.element(self.shell.inverse_metric[k]) for k in moving]
        if any(x.depends_on(q) for x in (*metric, U) for q in others):
            return ""
        λ = self.reader.field.cancelled(weights[moving[0]] / metric[0])
        if self._varies(λ) or any(not (weights[k] - λ * g).is_zero for k, g in zip(moving, metric)):
            return ""
        names = ", ".join(self.shell.coordinates[k].name for k in moving)
        symbol = sp.Symbol("E_" + names.replace(", ", "_"), real=True)
        return f"{readable(self.reader, λ) * symbol}, {symbol} the energy of the motion in {names}"

    # ---------------------------------------------------------------- known integrals

    def _integral(self, weights: Sequence[Element], U: Element) -> str:
        for known in self._all_known():
            if found := self._compared(weights, U, known):
                return found
        return ""

    def _compared(self, weights: Sequence[Element], U: Element, known: Known) -> str:
        reader, shell = self.reader, self.shell
        own = [known.form.get((c.name, c.name), reader.field.zero) for c in shell.coordinates]
        metric = [reader.element(g) for g in shell.inverse_metric]
        half = [w / 2 for w in map(reader.field.coerce, weights)]
        solved = self._solved(half, own, [g / 2 for g in metric])
        if solved is None or solved[0].is_zero:
            return ""
        a, b = solved
        if any(not (w - a * k - b * g / 2).is_zero for w, k, g in zip(half, own, metric)):
            return ""
        rest = reader.field.cancelled(U - b * reader.element(shell.potential))
        return self._with_rest(known, a, b, rest)

    def _with_rest(self, known: Known, a: Element, b: Element, rest: Element) -> str:
        """The words, once the momenta that are left agree: what remains is quadratic in the ignorable momenta."""
        reader, field = self.reader, self.reader.field
        written = readable(reader, a) * known.symbol + readable(reader, b) * self.shell.energy
        for x, y in ((x, y) for k, x in enumerate(self.shell.ignorable) for y in self.shell.ignorable[k:]):
            coefficient = reader.diff(reader.diff(rest, x.momentum), y.momentum)
            coefficient = coefficient / 2 if x == y else coefficient
            part = known.form.get((x.name, y.name), field.zero)
            difference = field.cancelled(coefficient - a * part)
            if self._varies(difference):
                return ""
            written += readable(reader, difference) * x.momentum * y.momentum
        zero = dict.fromkeys((c.momentum for c in self.shell.ignorable), sp.S.Zero)
        still = field.cancelled(reader.element(reader.write(rest).xreplace(zero)))
        if not self._varies(still):
            return f"{written + readable(reader, still)}, {known.meaning}"
        if known.attracted is not None and not self._varies(field.cancelled(self._slope(still, known.attracted))):
            return f"{written}, {known.with_centre}"
        return f"{written} continued by a function of the coordinates that the potential brings in, {known.meaning}"

    def _slope(self, still: Element, attracted: Element) -> Element:
        """∂still/∂attracted along the first coordinate that moves it; constant when still = κ·attracted + const."""
        for q in self.symbols:
            slope = self.reader.diff(attracted, q)
            if not slope.is_zero:
                return self.reader.diff(still, q) / slope
        return still

    def _solved(
        self, α: Sequence[Element], known: Sequence[Element], energy: Sequence[Element]
    ) -> tuple[Element, Element] | None:
        """Return a and b of α = a·known + b·energy from two components at a base point."""
        field = self.reader.field
        for count, point in enumerate(base_points(self.reader, self.symbols)):
            if count == MAX_POINTS:
                return None
            try:
                rows = [[point.keep(x, set()) for x in row] for row in zip(α, known, energy)]
            except ZeroDivisionError:
                continue
            for (α1, k1, e1), (α2, k2, e2) in combinations(rows, 2):
                determinant = field.cancelled(k1 * e2 - k2 * e1)
                if not determinant.is_zero:
                    a = field.cancelled((α1 * e2 - α2 * e1) / determinant)
                    return a, field.cancelled((k1 * α2 - k2 * α1) / determinant)
        return None

    def _varies(self, x: Element) -> bool:
        return any(x.depends_on(q) and not self.reader.diff(x, q).is_zero for q in self.symbols)

    # ---------------------------------------------------------------- which integrals are known here

    def _all_known(self) -> list[Known]:
        if self._known is None:
            self._known = [*self._of_charts(), *self._of_carter()]
        return self._known

    def _of_charts(self) -> Iterator[Known]:
        """The integrals of the chart that T is recognised to be written in."""
        mass = mass_matrix(self.system)
        n = len(self.names)
        if n not in (2, 3) or not mass.is_diagonal() or any(linear_terms(self.system)):
            return
        values = _sampled(self.system, [mass[i, i] for i in range(n)])
        symbols = [c.symbol for c in self.system.coordinates]
        for chart in of_dimension(n):
            for order in permutations(range(n)):
                squares = chart.squares(*(symbols[k] for k in order))
                if not _proportional([mass[k, k] for k in order], squares, values):
                    continue
                ratios = [self.reader.element(mass[k, k] / h) for k, h in zip(order, squares)]
                if self._varies(ratios[0]) or any(not (x - ratios[0]).is_zero for x in ratios[1:]):
                    continue
                yield from (self._in_order(integral, order, symbols) for integral in chart.integrals)
                return

    def _in_order(self, integral: Integral, order: Sequence[int], symbols: Sequence[sp.Symbol]) -> Known:
        q = [symbols[k] for k in order]
        coefficients = integral.coefficients(*q)
        form = {(self.names[k], self.names[k]): self.reader.element(c) for k, c in zip(order, coefficients)}
        attracted = None if integral.attracted is None else self.reader.element(integral.attracted(*q))
        return Known(integral.symbol, integral.meaning, form, attracted, integral.with_centre)

    def _of_carter(self) -> Iterator[Known]:
        """Carter's constant Q = p_θ² + cos²θ [a²(−2H − p_t²) + p_φ²/sin²θ], for unit mass (Carter 1968)."""
        shell = self.shell
        if self.system.signature != "indefinite" or len(shell.coordinates) != 2 or len(shell.ignorable) != 2:
            return
        inverse = inverse_mass_matrix(self.system)
        place = {c.name: k for k, c in enumerate(self.system.coordinates)}
        for r, θ in permutations(shell.coordinates):
            for t, φ in permutations(shell.ignorable):
                for a in self.system.parameters:
                    cos2 = a.symbol**2 * sp.cos(θ.symbol) ** 2
                    form = {(x.name, x.name): -cos2 * inverse[place[x.name], place[x.name]] for x in (r, θ, t, φ)}
                    form[θ.name, θ.name] += 1
                    form[t.name, t.name] -= cos2
                    form[φ.name, φ.name] += sp.cot(θ.symbol) ** 2
                    x, y = sorted((t.name, φ.name), key=self.names.index)
                    form[x, y] = -2 * cos2 * inverse[place[x], place[y]]
                    elements = {key: self.reader.element(value) for key, value in form.items()}
                    yield Known(sp.Symbol("Q", real=True), "Q Carter's constant", elements)


def _sampled(system: System, entries: Sequence[sp.Expr]) -> list[dict[sp.Symbol, mpmath.mpf]]:
    """Two points where the entries have values; none where they have not."""
    found = []
    for shift in (3, 5):
        point = {p.symbol: CONTEXT.mpf(3 * k + 5) / 7 for k, p in enumerate(system.parameters)}
        point |= {c.symbol: CONTEXT.mpf(2 * k + shift) / 9 for k, c in enumerate(system.coordinates)}
        try:
            for entry in entries:
                evaluate(entry, point)
        except (NoValueError, KeyError):
            return []
        found.append(point)
    return found


def _proportional(
    entries: Sequence[sp.Expr], squares: Sequence[sp.Expr], points: Sequence[dict[sp.Symbol, mpmath.mpf]]
) -> bool:
    """Whether entries are one constant times squares at the points; a filter before the exact test."""
    ratios = [evaluate(m, point) / evaluate(h, point) for point in points for m, h in zip(entries, squares)]
    return bool(ratios) and all(abs(x / ratios[0] - 1) < CONTEXT.mpf(10) ** -40 for x in ratios[1:])
