"""Views of p² as a function of an offset, for many orbits: from zero, a domain's end, the start, a zero of p².

A view answers for arrays of shape (n,) or (n, nodes): the value of F = p², its kernels, and a bound on the rounding
error of F. ``DirectEvaluation`` evaluates the formula at x with q = origin + sign·x. ``DifferenceEvaluation`` carries
second-order slopes from the initial place, F(q₀ + δ) = P₀² + δ (F′₀ + δ F[q₀, q₀, q]): small amplitudes keep their
digits (``arithmetic/second_differences.py``). ``DoubleDoubleEvaluation`` evaluates F with 32 digits at a distance x
from a turning point known to 32 digits: close zeros keep theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hjsolve.arithmetic.divided_differences import FUNCTIONS as CHORDS
from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT, Float64
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import Elementwise, Reals, Which
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.second_differences import SecondDifference, in_doubles
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula

_PLACE = 2.0
"""Roundings, in units, that made an offset at a node."""


@dataclass(frozen=True)
class Knowns:
    """Constants of the motion and parameters of many orbits.

    Attributes:
        constants: one array (n,) a constant.
        uncertainty: bounds on their errors.
        parameters: numbers.
    """

    constants: tuple[Reals, ...]
    uncertainty: tuple[Reals, ...]
    parameters: tuple[float, ...]

    def take(self, index: Which) -> Knowns:
        """Return those of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        return replace(
            self,
            constants=tuple(c[index] for c in self.constants),
            uncertainty=tuple(e[index] for e in self.uncertainty),
        )

    def plain(self, like: Reals) -> list[Elementwise]:
        """Return constants that broadcast against an array (n, …), and parameters.

        Args:
            like: an array (n,) or (n, nodes).
        """
        return [with_node_axis(c, like) for c in self.constants] + list(self.parameters)

    def bounded(self, like: Reals) -> list[WithErrorBound]:
        """Return the same with their error bounds.

        Args:
            like: an array (n,) or (n, nodes).
        """
        pairs = zip(self.constants, self.uncertainty, strict=True)
        known = [WithErrorBound(with_node_axis(c, like), with_node_axis(e, like)) for c, e in pairs]
        return known + [WithErrorBound(p, UNIT * abs(p)) for p in self.parameters]


def with_node_axis(array: Reals, like: Reals) -> Reals:
    """Add an axis to an array (n,) where the other has nodes.

    Args:
        array: shape (n,).
        like: shape (n,) or (n, nodes).
    """
    return array[:, None] if np.ndim(like) == 2 else array


_ARITHMETIC = frozenset({"add", "sub", "mul", "div", "power", "rational", "pi"})


def has_chords(formula: LoweredFormula) -> bool:
    """Tell whether F[b, q] can be had without cancellation.

    Args:
        formula: of p².
    """
    codes = {operation.code for operation in formula.squared.operations}
    return bool(formula.squared.operations) and codes <= CHORDS | _ARITHMETIC


@dataclass(frozen=True)
class DirectEvaluation:
    """F(origin + sign·x), evaluated as it is written."""

    formula: LoweredFormula
    knowns: Knowns

    @property
    def sign(self) -> int:
        """+1 where the offset grows with q, else −1."""
        return self.formula.sign

    def take(self, index: Which) -> DirectEvaluation:
        """Return the view of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        return replace(self, knowns=self.knowns.take(index))

    def value(self, x: Reals) -> Reals:
        """Return F.

        Args:
            x: offsets from the origin, shape (n,) or (n, nodes).
        """
        return self.formula.squared.run(Float64(), [x, *self.knowns.plain(x)])[0] + 0.0 * x

    def full(self, x: Reals) -> Sequence[Reals]:
        """Return F and the kernels (which may be scalars).

        Args:
            x: offsets from the origin, shape (n,) or (n, nodes).
        """
        return self.formula.full.run(Float64(), [x, *self.knowns.plain(x)])

    def errors(self, x: Reals, *, kernels: bool, known: Reals | None = None) -> list[Elementwise]:  # noqa: ARG002
        """Return bounds on the errors of F and of the kernels, those of x and of the constants included.

        Args:
            x: offsets from the origin, shape (n,) or (n, nodes).
            kernels: whether bounds for the kernels are wanted, too.
            known: F there; not used by this view.
        """
        place = WithErrorBound(x, _PLACE * UNIT * np.abs(x))
        tape = self.formula.full if kernels else self.formula.squared
        results = tape.run(RunningError(Float64()), [place, *self.knowns.bounded(x)])
        return [0.0 if result.error is None else result.error for result in results]

    def drift(self, kernels: Sequence[Reals], x: Reals) -> Reals:
        """Return what of the error of F comes from the constants: it is smooth in x. Σ |∂F/∂c| δc, ∂F/∂c = 2k.

        Args:
            kernels: ½ ∂F/∂c at x, one array a constant.
            x: offsets from the origin, shape (n,) or (n, nodes).
        """
        parts = (2 * np.abs(k) * with_node_axis(e, x) for k, e in zip(kernels, self.knowns.uncertainty, strict=True))
        return sum(parts, np.zeros_like(x))

    def jet(self, x: Reals) -> tuple[Reals, Reals, Reals]:
        """Return F, dF/dx, d²F/dx².

        Args:
            x: offsets from the origin, shape (n,) or (n, nodes).
        """
        jets = Jets(Float64())
        parts = self.formula.squared.run(jets, [jets.variable(x), *(Jet(k) for k in self.knowns.plain(x))])[0]
        value, first, second = (0.0 * x if part is None else part + 0.0 * x for part in parts)
        return value, first, second

    def place(self, x: Reals) -> Reals:
        """Return q.

        Args:
            x: offsets from the origin, shape (n,) or (n, nodes).
        """
        return self.formula.origin.high + (self.formula.origin.low + self.formula.sign * x)


@dataclass(frozen=True)
class DifferenceEvaluation:
    """F(q₀ + δ) by slopes; arrays of shape (n,).

    Attributes:
        formula: p²(q), plain.
        knowns: of the orbits.
        start: q₀.
        momentum: P₀.
        first: F′(q₀), to full relative accuracy.
        uncertainty: bound on the error of F[q₀, q₀, q].
    """

    formula: LoweredFormula
    knowns: Knowns
    start: Reals
    momentum: Reals
    first: Reals
    uncertainty: Reals

    sign = 1

    def take(self, index: Which) -> DifferenceEvaluation:
        """Return the view of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        own = (self.start, self.momentum, self.first, self.uncertainty)
        return DifferenceEvaluation(self.formula, self.knowns.take(index), *(part[index] for part in own))

    def value(self, δ: Reals) -> Reals:
        """Return F.

        Args:
            δ: q − q₀, shape (n,) or (n, nodes).
        """
        slopes = in_doubles(δ)
        known = [SecondDifference(k) for k in self.knowns.plain(δ)]
        result = self.formula.squared.run(slopes, [slopes.variable(with_node_axis(self.start, δ)), *known])[0]
        second = 0.0 if result.second is None else result.second
        return with_node_axis(self.momentum, δ) ** 2 + δ * (with_node_axis(self.first, δ) + δ * second)

    def full(self, δ: Reals) -> Sequence[Reals]:
        """Return F and the kernels.

        Args:
            δ: q − q₀, shape (n,) or (n, nodes).
        """
        q = with_node_axis(self.start, δ) + δ
        return [self.value(δ), *self.formula.full.run(Float64(), [q, *self.knowns.plain(δ)])[1:]]

    def errors(self, δ: Reals, *, kernels: bool, known: Reals | None = None) -> list[Elementwise]:  # noqa: ARG002
        """Return bounds on the errors of F and of the kernels.

        Args:
            δ: q − q₀, shape (n,) or (n, nodes).
            kernels: whether bounds for the kernels are wanted, too.
            known: F there; not used by this view.
        """
        size = with_node_axis(self.momentum, δ) ** 2 + 2 * np.abs(δ * with_node_axis(self.first, δ))
        own = 6 * UNIT * size + δ**2 * with_node_axis(self.uncertainty, δ)
        if not kernels:
            return [own]
        return [
            own,
            *DirectEvaluation(self.formula, self.knowns).errors(with_node_axis(self.start, δ) + δ, kernels=True)[1:],
        ]

    def drift(self, kernels: Sequence[Reals], x: Reals) -> Reals:  # noqa: ARG002
        """Return what of the error of F comes smoothly from the constants: none is told apart here.

        Args:
            kernels: ½ ∂F/∂c at x; not used by this view.
            x: q − q₀, shape (n,) or (n, nodes).
        """
        return 0.0 * x

    def place(self, δ: Reals) -> Reals:
        """Return q.

        Args:
            δ: q − q₀, shape (n,) or (n, nodes).
        """
        return with_node_axis(self.start, δ) + δ


@dataclass(frozen=True)
class DoubleDoubleEvaluation:
    """F(origin + sign·(base + x)) with 32 digits.

    Attributes:
        raw: the same in doubles, for kernels.
        pairs, numbers: constants and parameters in two doubles.
        base: offset of a turning point (or slow place) in two doubles, arrays (n,).
    """

    raw: DirectEvaluation
    pairs: tuple[Pair, ...]
    numbers: tuple[Pair, ...]
    base: Pair

    @property
    def sign(self) -> int:
        """+1 where the offset grows with q, else −1."""
        return self.raw.sign

    def take(self, index: Which) -> DoubleDoubleEvaluation:
        """Return the view of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        pairs = tuple(Pair(c.high[index], c.low[index]) for c in self.pairs)
        return DoubleDoubleEvaluation(
            self.raw.take(index), pairs, self.numbers, Pair(self.base.high[index], self.base.low[index])
        )

    def _inputs(self, x: Reals) -> tuple[Pair, list[Pair]]:
        place = DoubleDouble().add(
            Pair(with_node_axis(self.base.high, x), with_node_axis(self.base.low, x)), Pair(x, 0.0 * x)
        )
        return place, [Pair(with_node_axis(c.high, x), with_node_axis(c.low, x)) for c in self.pairs] + list(
            self.numbers
        )

    def value(self, x: Reals) -> Reals:
        """Return F.

        Args:
            x: distances from the base, shape (n,) or (n, nodes).
        """
        place, known = self._inputs(x)
        return self.raw.formula.squared.run(DoubleDouble(), [place, *known])[0].high + 0.0 * x

    def jet(self, x: Reals) -> tuple[Reals, Reals, Reals]:
        """Return F, dF/dx, d²F/dx².

        Args:
            x: distances from the base, shape (n,) or (n, nodes).
        """
        place, known = self._inputs(x)
        jets = Jets(DoubleDouble())
        parts = self.raw.formula.squared.run(jets, [jets.variable(place), *(Jet(k) for k in known)])[0]
        value, first, second = (0.0 * x if part is None else part.high + 0.0 * x for part in parts)
        return value, first, second

    def full(self, x: Reals) -> Sequence[Reals]:
        """Return F and the kernels.

        Args:
            x: distances from the base, shape (n,) or (n, nodes).
        """
        offset = with_node_axis(self.base.high, x) + x
        return [self.value(x), *self.raw.full(offset)[1:]]

    def errors(self, x: Reals, *, kernels: bool, known: Reals | None = None) -> list[Elementwise]:
        """Return bounds on the errors of F (relative, but for 2⁻⁴⁴ of those in doubles) and of the kernels.

        Args:
            x: offsets.
            kernels: whether they are wanted.
            known: F there, where it has been worked out.
        """
        rough = self.raw.errors(with_node_axis(self.base.high, x) + x, kernels=kernels)
        value = self.value(x) if known is None else known
        return [4 * UNIT * np.abs(value) + 2.0**-44 * rough[0], *rough[1:]]

    def drift(self, kernels: Sequence[Reals], x: Reals) -> Reals:  # noqa: ARG002
        """Return what of the error of F comes smoothly from the constants: none is told apart here.

        Args:
            kernels: ½ ∂F/∂c at x; not used by this view.
            x: distances from the base, shape (n,) or (n, nodes).
        """
        return 0.0 * x

    def place(self, x: Reals) -> Reals:
        """Return q.

        Args:
            x: distances from the base, shape (n,) or (n, nodes).
        """
        return self.raw.place(self.base.high + (self.base.low + x))


View = DirectEvaluation | DifferenceEvaluation | DoubleDoubleEvaluation


def second_slope(formula: LoweredFormula, knowns: Knowns, q: Reals) -> tuple[Reals, Reals]:
    """Return ½F″ at q, and three times the running error of it: a bound for slopes nearby.

    Args:
        formula: of p²(q).
        knowns: constants and parameters of n orbits.
        q: places, shape (n,).
    """
    jets = Jets(RunningError(Float64()))
    inputs = [jets.variable(WithErrorBound(q)), *(Jet(k) for k in knowns.bounded(q))]
    bend = formula.squared.run(jets, inputs)[0].second
    if bend is None:
        return 0.0 * q, 0.0 * q
    error = 0.0 if bend.error is None else bend.error
    return 0.5 * bend.value + 0.0 * q, 1.5 * (error + 4 * UNIT * np.abs(bend.value)) + 0.0 * q
