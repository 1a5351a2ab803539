"""What a separation constant is: an energy of a part, an angular momentum, a Runge–Lenz component, Carter's constant.

A constant α = ½ Σ wᵢPᵢ² + U is compared with a known integral K: α = aK + bE + Σ d c c′ + const, with a, b, d free of
coordinates, and E the energy of the whole or of a part that moves by itself. Two of the coefficients of pᵢ² at a base
point give a and b; the rest of the identity is then proved by the exact zero test. Where U keeps a function of the
coordinates, K is the integral of the free motion that α continues.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import mpmath
import sympy as sp

from hjsolve.algebra.field import Element
from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.formulas.point_values import CONTEXT, NoValueError, evaluate
from hjsolve.mechanics.energy_shell import Shell
from hjsolve.mechanics.system import System, inverse_mass_matrix, linear_terms, mass_matrix
from hjsolve.separation.constants.known_charts import Integral, of_dimension
from hjsolve.separation.forms.base_points import find_base_points

MAX_SIZE = 400
MAX_POINTS = 4
Quadratic = dict[tuple[str, str], Element]


@dataclass(frozen=True)
class KnownIntegral:
    """A known integral in the coordinates of a system.

    Attributes:
        symbol, meaning: as in ``known_charts.Integral``.
        form: coefficient of p_a p_b by names of coordinates, a ≤ b in the order of the system.
        attracted: what a centre of force adds, up to a factor, or None.
        with_centre: the meaning then.
    """

    symbol: sp.Expr
    meaning: str
    form: Quadratic
    attracted: Element | None = None
    with_centre: str = ""


@dataclass(frozen=True)
class Energy:
    """The energy of the whole or of a part: ½ Σ gⁱⁱPᵢ² + V; ``words`` explain the symbol where it needs it."""

    symbol: sp.Symbol
    metric: tuple[Element, ...]
    potential: Element
    words: str = ""


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
        self.usable = sp.count_ops(shell.system.kinetic) <= MAX_SIZE
        self.metric = [reader.element(g) for g in shell.inverse_metric]
        self.energies = [Energy(shell.energy, tuple(self.metric), reader.element(shell.potential))]
        self._known: list[KnownIntegral] | None = None

    def __call__(self, rows: Sequence[Sequence[Element]], column: Sequence[Element]) -> list[str]:
        """Return the meaning of every α = Σ wᵢ(½Pᵢ² + ψᵢ), one for each row w; nothing where it is not known."""
        if not self.usable:
            return [""] * len(rows)
        try:
            totals = [self.reader.field.total(w * ψ for w, ψ in zip(row, column)) for row in rows]
            found = [self._energy_of_part(row, U) for row, U in zip(rows, totals)]
            return [words or self._integral(row, U) for words, row, U in zip(found, rows, totals)]
        except (WorkLimitError, ZeroDivisionError):
            return [""] * len(rows)

    # ---------------------------------------------------------------- a part that moves by itself

    def _energy_of_part(self, weights: Sequence[Element], U: Element) -> str:
        """α = λ(½ Σ gⁱⁱPᵢ² + V_part) over some coordinates, with g and V of these alone."""
        moving = [k for k, w in enumerate(weights) if not w.is_zero]
        others = [q for k, q in enumerate(self.symbols) if k not in moving]
        metric = [self.metric[k] for k in moving]
        if any(x.depends_on(q) for x in (*metric, U) for q in others):
            return ""
        λ = self.reader.field.cancelled(weights[moving[0]] / metric[0])
        if self._varies(λ) or any(not (weights[k] - λ * g).is_zero for k, g in zip(moving, metric)):
            return ""
        names = ", ".join(self.shell.coordinates[k].name for k in moving)
        symbol = sp.Symbol("E_" + names.replace(", ", "_"), real=True)
        words = f"{symbol} the energy of the motion in {names}"
        zero = self.reader.field.zero
        own = tuple(g if k in moving else zero for k, g in enumerate(self.metric))
        self.energies.append(Energy(symbol, own, self.reader.field.cancelled(U / λ), words))
        return f"{shortest_form(self.reader, λ) * symbol}, {words}"

    # ---------------------------------------------------------------- known integrals

    def _integral(self, weights: Sequence[Element], U: Element) -> str:
        for known in self._all_known():
            for energy in self.energies:
                if found := self._compared(weights, U, known, energy):
                    return found
        return ""

    def _compared(self, weights: Sequence[Element], U: Element, known: KnownIntegral, energy: Energy) -> str:
        field = self.reader.field
        own = [known.form.get((c.name, c.name), field.zero) for c in self.shell.coordinates]
        half = [w / 2 for w in map(field.coerce, weights)]
        halves = [g / 2 for g in energy.metric]
        solved = self._solved(half, own, halves)
        if solved is None or solved[0].is_zero:
            return ""
        a, b = solved
        if any(not (w - a * k - b * g).is_zero for w, k, g in zip(half, own, halves)):
            return ""
        found = self._with_rest(known, a, b, energy, field.cancelled(U - b * energy.potential))
        return f"{found}, {energy.words}" if found and energy.words and not b.is_zero else found

    def _with_rest(self, known: KnownIntegral, a: Element, b: Element, energy: Energy, rest: Element) -> str:
        """Return the words, once the momenta that are left agree.

        What remains is quadratic in the ignorable momenta.
        """
        reader, field = self.reader, self.reader.field
        written = shortest_form(reader, a) * known.symbol + shortest_form(reader, b) * energy.symbol
        for x, y in ((x, y) for k, x in enumerate(self.shell.ignorable) for y in self.shell.ignorable[k:]):
            coefficient = reader.diff(reader.diff(rest, x.momentum), y.momentum)
            coefficient = coefficient / 2 if x == y else coefficient
            part = known.form.get((x.name, y.name), field.zero)
            difference = field.cancelled(coefficient - a * part)
            if self._varies(difference):
                return ""
            written += shortest_form(reader, difference) * x.momentum * y.momentum
        zero = dict.fromkeys((c.momentum for c in self.shell.ignorable), sp.S.Zero)
        still = field.cancelled(reader.element(reader.write(rest).xreplace(zero)))
        if not self._varies(still):
            return f"{written + shortest_form(reader, still)}, {known.meaning}"
        if known.attracted is not None:
            left = field.cancelled(still - self._slope(still, known.attracted) * known.attracted)
            if not self._varies(left):
                return f"{written + shortest_form(reader, left)}, {known.with_centre}"
        return f"{written} continued by a function of the coordinates that the potential brings in, {known.meaning}"

    def _slope(self, still: Element, attracted: Element) -> Element:
        """∂still/∂attracted along the first coordinate that moves it: κ, where still = κ·attracted + const."""
        q = next(q for q in self.symbols if not self.reader.diff(attracted, q).is_zero)
        return self.reader.field.cancelled(self.reader.diff(still, q) / self.reader.diff(attracted, q))

    def _solved(
        self, α: Sequence[Element], known: Sequence[Element], energy: Sequence[Element]
    ) -> tuple[Element, Element] | None:
        """Return a and b of α = a·known + b·energy from two components at a base point."""
        field = self.reader.field
        for count, point in enumerate(find_base_points(self.reader, self.symbols)):
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

    def _all_known(self) -> list[KnownIntegral]:
        if self._known is None:
            self._known = [*self._of_charts(), *self._of_carter()]
            if not self._known:
                self._known = list(self._of_spheres())
        return self._known

    def _of_charts(self) -> Iterator[KnownIntegral]:
        """Yield the integrals of the chart that T is recognised to be written in."""
        mass = mass_matrix(self.system)
        n = len(self.names)
        if n not in (2, 3) or not mass.is_diagonal() or any(linear_terms(self.system)):
            return
        samples = _sampled(self.system, [mass[i, i] for i in range(n)])
        symbols = [c.symbol for c in self.system.coordinates]
        for chart in of_dimension(n):
            for order in permutations(range(n)):
                squares = chart.squares(*(symbols[k] for k in order))
                if not _proportional(order, squares, samples, chart.free):
                    continue
                ratios = [self.reader.element(mass[k, k] / h) for k, h in zip(order, squares)]
                together = [x for k, x in enumerate(ratios) if k not in chart.free]
                if any(map(self._varies, ratios)) or any(not (x - together[0]).is_zero for x in together):
                    continue
                yield from (self._in_order(integral, order, symbols) for integral in chart.integrals)
                return

    def _in_order(self, integral: Integral, order: Sequence[int], symbols: Sequence[sp.Symbol]) -> KnownIntegral:
        q = [symbols[k] for k in order]
        coefficients = integral.coefficients(*q)
        form = {(self.names[k], self.names[k]): self.reader.element(c) for k, c in zip(order, coefficients)}
        attracted = None if integral.attracted is None else self.reader.element(integral.attracted(*q))
        meaning, centre = (text.format(*q) for text in (integral.meaning, integral.with_centre))
        return KnownIntegral(integral.symbol, meaning, form, attracted, centre)

    def _of_spheres(self) -> Iterator[KnownIntegral]:
        """L² in coordinates r, μ, ν with T = m/2 (ṙ² + r² h(μ, ν)) where h is the unit sphere: its curvature is 1."""
        mass = mass_matrix(self.system)
        if len(self.names) != 3 or not mass.is_diagonal() or any(linear_terms(self.system)):
            return
        elements = [self.reader.element(mass[i, i]) for i in range(3)]
        for k, c in enumerate(self.system.coordinates):
            if self._varies(elements[k]):
                continue
            rest = [(q, elements[i]) for i, q in enumerate(self.system.coordinates) if i != k]
            r = self.reader.element(c.symbol)
            sphere = [self.reader.field.cancelled(m / (elements[k] * r**2)) for _, m in rest]
            if any(h.depends_on(c.symbol) for h in sphere):
                continue
            if (curvature(self.reader, [q.symbol for q, _ in rest], sphere) - 1).is_zero:
                form = {(q.name, q.name): h**-1 for (q, _), h in zip(rest, sphere)}
                yield KnownIntegral(sp.Symbol("L", real=True) ** 2, "L the total angular momentum", form)

    def _of_carter(self) -> Iterator[KnownIntegral]:
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
                    yield KnownIntegral(sp.Symbol("Q", real=True), "Q Carter's constant", elements)


def curvature(reader: Reader, q: Sequence[sp.Symbol], h: Sequence[Element]) -> Element:
    """Gauss's curvature of h₁dx² + h₂dy² (Gauss 1827, Disquisitiones generales circa superficies curvas, art. 11).

    Args:
        reader: of the field of h.
        q: symbols x, y.
        h: the coefficients h₁, h₂ of the metric.
    """
    (x, y), (E, G), d = q, h, reader.diff
    second = (d(d(E, y), y) + d(d(G, x), x)) / (E * G)
    first = (d(E, x) * d(G, x) + d(E, y) ** 2) / (E**2 * G) + (d(E, y) * d(G, y) + d(G, x) ** 2) / (E * G**2)
    return reader.field.cancelled(first / 4 - second / 2)


Sample = tuple[dict[sp.Symbol, mpmath.mpf], list[mpmath.mpf]]


def _sampled(system: System, entries: Sequence[sp.Expr]) -> list[Sample]:
    """Return two points and the values of the entries there; none where they have no values."""
    found = []
    for shift in (3, 5):
        point = {p.symbol: CONTEXT.mpf(3 * k + 5) / 7 for k, p in enumerate(system.parameters)}
        point |= {c.symbol: CONTEXT.mpf(2 * k + shift) / 11 for k, c in enumerate(system.coordinates)}
        try:
            found.append((point, [evaluate(entry, point) for entry in entries]))
        except (NoValueError, KeyError):
            return []
    return found


def _proportional(
    order: Sequence[int], squares: Sequence[sp.Expr], samples: Sequence[Sample], free: frozenset[int]
) -> bool:
    """Return whether the entries are one constant times squares at the points; a filter before the exact test."""
    first = None
    for point, values in samples:
        for k in (k for k in range(len(squares)) if k not in free):
            ratio = values[order[k]] / evaluate(squares[k], point)
            first = ratio if first is None else first
            if abs(ratio / first - 1) > CONTEXT.mpf(10) ** -40:
                return False
    return bool(samples)
