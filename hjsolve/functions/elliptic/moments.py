"""An integral over √P that begins at a real root, and its reduction to three kinds: moments of x − ρ by recurrence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from hjsolve.errors import required
from hjsolve.functions.complex_pole import Parts, divided
from hjsolve.functions.elliptic.branch_points import BranchPoints, Interval, NoForm, PartialFractions

INFINITY = None
"""The branch point of a cubic that is not a root."""


@dataclass(frozen=True)
class IntegrationPath:
    """From the root e of P to x, all of it between two roots or from a root to infinity.

    Attributes:
        P: the branch points.
        interval: where.
        start: "lower" or "upper": which end of the interval e is.
        x: the other end; None for infinity.
        whole: whether the integral is over the whole interval.
    """

    P: BranchPoints
    interval: Interval
    start: str
    x: sp.Expr | None
    whole: bool

    @cached_property
    def index(self) -> int:
        """Place of e among the real roots."""
        if not self.P.real:
            raise NoForm("P has no real root to begin at")
        index = self.interval[0] if self.start == "lower" else self.interval[1]
        if index is None:
            raise NoForm("the interval does not begin at a root")
        return index

    @cached_property
    def e(self) -> sp.Expr:
        """The root at which the path begins."""
        return self.P.real[self.index]

    @cached_property
    def σ(self) -> int:
        """The side of e on which the interval lies."""
        return 1 if self.start == "lower" else -1

    @cached_property
    def others(self) -> tuple[sp.Expr | None, ...]:
        """The other real branch points, ∞ among them where P is cubic."""
        roots = tuple(r for k, r in enumerate(self.P.real) if k != self.index)
        return (*roots, INFINITY) if self.P.degree == 3 else roots

    @cached_property
    def S(self) -> sp.Expr:
        """√(σ(x − e)); 1 for infinity."""
        return sp.S.One if self.x is None else sp.sqrt(self.σ * (self.x - self.e))

    @cached_property
    def q(self) -> sp.Expr:
        """σ P′(e) > 0."""
        return self.σ * self.P.slope(self.e)

    def v(self, place: sp.Expr | None) -> sp.Expr:
        """Return v of ``carlson_forms`` at a place, positive.

        Args:
            place: outside the interval, or one of its ends; None for infinity.
        """
        if self.x is None:
            return sp.S.Zero if place is INFINITY else self.σ / (self.e - place)
        return sp.S.One if place is INFINITY else (self.x - place) / (self.e - place)


@dataclass(frozen=True)
class Kinds:
    """The basic integrals along a path, in the functions of some author.

    Attributes:
        first: ∫ dx/√P.
        third: place ↦ (2S³/(3√q)) R_J(v(r₁), v(r₂), v(r₃), v(place)), the place a pole, a branch point or ∞.
        at_other_end: for a quartic whose only other real root r is the end of the interval: r ↦ √P/(x − r) and
            ∫ dx/((x − r)√P), without what is infinite in each and cancels between them; None where it is not needed.
        complex_third: the same as ``third`` of a complex place; None where it is not known.
        pole: ∫ dx/((x − place)√P) of a real pole; None where it is that of ``third``.
    """

    first: sp.Expr
    third: Callable[[sp.Expr | None], sp.Expr]
    at_other_end: Callable[[sp.Expr], tuple[sp.Expr, sp.Expr]] | None = None
    complex_third: Callable[[Parts], Parts] | None = None
    pole: Callable[[sp.Expr], sp.Expr] | None = None


def first_and_other_kinds(R: PartialFractions, path: IntegrationPath, kinds: Kinds) -> sp.Expr:
    """∫ R dx/√P along a path.

    Args:
        R: the rational function.
        path: from where to where.
        kinds: the basic integrals.

    Raises:
        NoForm: it diverges, or no form is known here; the text says why.
    """
    moments = _Moments(path, kinds)
    terms = [c * moments.about(sp.S.Zero, k) for k, c in R.powers] + [
        c * moments.pole(place, m) for place, m, c in R.poles
    ]
    return sp.Add(*terms, *(moments.complex_pole(pole) for pole in R.complex_poles))


def whole_path(P: BranchPoints, interval: Interval) -> IntegrationPath:
    """Return the path through the whole interval, from its lower end if that is a root."""
    lower, upper = interval
    start = "lower" if lower is not None else "upper"
    other = upper if lower is not None else lower
    return IntegrationPath(P, interval, start, None if other is None else P.real[other], whole=True)


def refuse(R: PartialFractions, P: BranchPoints, *, complex_poles: bool = False) -> None:
    """Raise where nothing is known.

    Args:
        R: the rational function.
        P: the branch points.
        complex_poles: whether poles at complex places are known.

    Raises:
        NoForm: why.
    """
    if P.degree not in {3, 4}:
        raise NoForm(f"P has degree {P.degree}, not 3 or 4")
    if len(P.pairs) > 1:
        raise NoForm("P has no real root to begin at")
    if R.complex_poles and not complex_poles:
        raise NoForm("the integrand has complex poles")


@dataclass(frozen=True)
class _Moments:
    """A_n(ρ) = ∫ (x − ρ)ⁿ dx/√P, all from A₀, A₁ and A₋₁."""

    path: IntegrationPath
    kinds: Kinds

    @cached_property
    def zeroth(self) -> sp.Expr:
        return self.kinds.first

    @cached_property
    def first(self) -> sp.Expr:
        """∫ (x − e) dx/√P."""
        self._converges("a power of x")
        return self.path.σ * self.kinds.third(INFINITY)

    def _converges(self, what: str) -> None:
        if self.path.x is None:
            raise NoForm(f"the integral of {what} to infinity diverges, or is not known here")

    def _boundary(self, place: sp.Expr, n: int) -> sp.Expr:
        """(x − place)ⁿ √P between the ends, in the direction of the integral; zero at roots."""
        self._converges("a higher pole")
        if self.path.whole:
            return sp.S.Zero
        return self.path.σ * (self.path.x - place) ** n * sp.sqrt(self.path.P.value(self.path.x))

    def _about_start(self, n: int) -> sp.Expr:
        """A_n(e), n ≥ 0, by d[(x − e)ᵐ √P] = Σₖ Pₖ (m + k/2) (x − e)^(m+k−1) dx/√P."""
        if n < 2:
            return (self.zeroth, self.first)[n] if n else self.zeroth
        degree = self.path.P.degree
        if n == 2 and degree == 4:
            return self._second_of_quartic
        P, m = self.path.P.taylor(self.path.e), n - degree + 1
        lower = [P[k] * (m + sp.Rational(k, 2)) * self._about_start(m + k - 1) for k in range(1, degree)]
        return (self._boundary(self.path.e, m) - sp.Add(*lower)) / ((m + sp.Rational(degree, 2)) * P[degree])

    @cached_property
    def _second_of_quartic(self) -> sp.Expr:
        """∫ (x − e)² dx/√P from d[√P/(x − r)] about another root r, where P has no constant term."""
        self._converges("a power of x")
        path, ends = self.path, {self.path.P.real[k] for k in self.path.interval if k is not None}
        free = [r for r in path.others if r not in ends]
        r = free[0] if free else path.others[0]
        P, h = path.P.taylor(r), path.e - r
        first = self.first + h * self.zeroth
        if free:
            edge, inverse = self._boundary(r, -1), self.pole(r, 1)
        else:
            edge, inverse = required(self.kinds.at_other_end)(r)
        second = (edge - P[3] * first / 2 + P[1] * inverse / 2) / P[4]
        return second - 2 * h * self.first - h**2 * self.zeroth

    def pole(self, place: sp.Expr, m: int) -> sp.Expr:
        """A₋ₘ(place), by the same identity about the pole.

        Args:
            place: of the pole.
            m: its order.
        """
        path = self.path
        if place in {path.P.real[k] for k in path.interval if k is not None}:
            raise NoForm("the integrand has a pole at an end of the interval")
        if m == 1 and self.kinds.pole is not None and place not in path.P.real:
            return self.kinds.pole(place)
        if m == 1:
            h = path.e - place
            return (self.zeroth - path.σ / h * self.kinds.third(place)) / h
        P = path.P.taylor(place)
        if P[0] == 0 and P[1] == 0:  # a double root
            lower = [P[k] * (sp.Rational(k, 2) - m - 1) * self.about(place, k - m - 2) for k in range(3, len(P))]
            return (self._boundary(place, -m - 1) - sp.Add(*lower)) / (-m * P[2])
        if P[0] == 0:  # a root of P
            lower = [P[k] * (sp.Rational(k, 2) - m) * self.about(place, k - m - 1) for k in range(2, path.P.degree + 1)]
            return (self._boundary(place, -m) - sp.Add(*lower)) / ((sp.Rational(1, 2) - m) * P[1])
        n = m - 1
        lower = [P[k] * (sp.Rational(k, 2) - n) * self.about(place, k - n - 1) for k in range(1, path.P.degree + 1)]
        return (sp.Add(*lower) - self._boundary(place, -n)) / (n * P[0])

    def complex_pole(self, pole: tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]) -> sp.Expr:
        """∫ (Ax + B)/((x − re)² + im²) dx/√P = 2 Re c ∫ dx/((x − ρ)√P), ρ = re + i im, c = A/2 − i (A re + B)/(2 im).

        Args:
            pole: re, im, A, B.
        """
        re, im, A, B = pole
        if self.kinds.complex_third is None:
            raise NoForm("the integrand has complex poles")
        h, third = (self.path.e - re, -im), self.kinds.complex_third((re, im))
        away = divided((self.path.σ * third[0], self.path.σ * third[1]), h)
        integral = divided((self.zeroth - away[0], -away[1]), h)
        return A * integral[0] + (A * re + B) / im * integral[1]

    def about(self, place: sp.Expr, n: int) -> sp.Expr:
        """A_n(place).

        Args:
            place: ρ.
            n: the power, negative of a pole.
        """
        if n < 0:
            return self.pole(place, -n)
        h = self.path.e - place
        return sp.Add(*(sp.binomial(n, k) * h ** (n - k) * self._about_start(k) for k in range(n + 1)))
