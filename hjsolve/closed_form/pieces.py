"""One coordinate's integrals in one regime: antiderivatives, values over a cycle, and the conditions they rest on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import mpmath
import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots, named_roots
from hjsolve.closed_form.carlson import CarlsonMap, carlson_integral, carlson_map, pairs_map
from hjsolve.closed_form.change_of_variable import Substitution
from hjsolve.closed_form.complex_poles import PairOfComplexPoles
from hjsolve.closed_form.curves import MomentumCurve, W, named_constants
from hjsolve.closed_form.elementary import Antiderivative, elementary_antiderivative, positive_root
from hjsolve.closed_form.even_curves import EvenMap, even_integral, even_map
from hjsolve.closed_form.fractions import partial_fractions
from hjsolve.closed_form.involutions import why_no_form
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.real_branch_points import LegendreMap, elliptic_integral, legendre_map, without_square
from hjsolve.closed_form.reduction import reduced
from hjsolve.closed_form.regions import RootInterval, in_its_well, root_interval_of
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.special_cases import deciders
from hjsolve.closed_form.square_curves import (
    SquareCurve,
    between_the_roots_of_a_power,
    reduces,
    roots_of_a_power,
    square_curve,
)
from hjsolve.closed_form.tidy import longer_than
from hjsolve.closed_form.time_limit import check_time
from hjsolve.closed_form.why_not import NotFound, WhyNot
from hjsolve.errors import required
from hjsolve.functions.elliptic import PartialFractions
from hjsolve.precision import mp

LONGEST_FORM = 20000
"""Operations above which a form is of no use."""
_SAME = mp.mpf(10) ** -30
"""Of themselves, how near a pole and a branch point are the same: of 50 digits of roots a pair may lose 20."""
LONGEST_CONDITION = 40
"""Operations of a condition that is still worth stating next to the order of the roots."""


@dataclass(frozen=True)
class PieceIntegral:
    """∫ N dq/√P², one of the integrals of a coordinate.

    Attributes:
        numerator: N(q).
        value: the antiderivative as a function of q; nan where only the cycle has a form.
        cycle: over a full cycle; None where the motion has none, or where there is no form of it.
        rational: R(x) of ∫ R dx/√P.
        law: the elementary antiderivative in x; None of an elliptic one.
        curve: the curve it was found on.
        first: R, where it is a constant: the integral of the first kind; else None.
        change: the map to Legendre's integrals; None of an elementary one.
        squared: the curve in x² that it was integrated on; None of another one.
    """

    numerator: sp.Expr
    value: sp.Expr
    cycle: sp.Expr | None
    rational: sp.Expr
    law: Antiderivative | None
    curve: MomentumCurve
    first: sp.Expr | None = None
    change: EvenMap | LegendreMap | CarlsonMap | None = None
    squared: SquareCurve | None = None


@dataclass
class CoordinateIntegrals:
    """A coordinate in a regime.

    Attributes:
        name: of the coordinate.
        sample: the motion it was found with.
        numerators: W or a constant → N(q), none zero.
        region: where the motion is on the x-axis of the first curve.
        regions: all curves used, with the region on each.
        conditions: expression in the constants → its sign.
        integrals: W or a constant → its integral; no key where the coordinate does not contribute.
        cycles: W or a constant → an integral of which only the value over a cycle has a form.
        roots: the real roots of P of the first curve, ascending; None where they have no names.
        why_not: W or a constant → why there is no form.
        where: named symbol → what it is.
        rates: modulus, or factor of an argument → what it is.
        start: the lower limit, in forms that are integrals from there.
    """

    name: str
    sample: Sample
    numerators: Mapping[sp.Symbol, sp.Expr]
    region: RootInterval | None = None
    regions: list[tuple[MomentumCurve, RootInterval]] = field(default_factory=list)
    conditions: dict[sp.Expr, int] = field(default_factory=dict)
    integrals: dict[sp.Symbol, PieceIntegral] = field(default_factory=dict)
    cycles: dict[sp.Symbol, PieceIntegral] = field(default_factory=dict)
    roots: tuple[sp.Expr, ...] | None = None
    why_not: dict[sp.Symbol, WhyNot] = field(default_factory=dict)
    where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]] = field(default_factory=dict)
    rates: dict[sp.Symbol, sp.Expr] = field(default_factory=dict)
    start: sp.Symbol | None = None

    @property
    def kind(self) -> str:
        """Libration, rotation, escape, boundary or asymptotic."""
        kinds = [region.kind for _, region in self.regions]  # a rest at the end of a turn is seen on one curve only
        return "asymptotic" if "asymptotic" in kinds else required(self.region).kind

    def add(self, done: Mapping[sp.Symbol, PieceIntegral], task: _Task) -> None:
        """Take over what was integrated on a curve.

        Args:
            done: W or a constant → its integral.
            task: the curve and the interval.
        """
        if not self.regions:
            self.roots = task.real_roots()
        self.regions.append((task.curve, task.region))
        self.conditions |= task.conditions([key for key in self.numerators if key != W])
        self.integrals |= done
        self.why_not = {key: reason for key, reason in self.why_not.items() if key not in self.integrals}
        # names that no form holds are dropped; what a kept name is defined by is kept
        held = {s for found in done.values() for s in (found.value + (found.cycle or 0)).free_symbols}
        held |= {s for root in self.roots or () for s in root.free_symbols}
        for change in task.changes:
            if not isinstance(change, CarlsonMap):
                self.rates |= {s: e for s, e in ((change.k, sp.sqrt(change.m)), (change.rate, change.Ω)) if s in held}
        held |= {s for e in self.rates.values() for s in e.free_symbols}
        for roots in (task.roots, *(change.roots for change in task.changes if isinstance(change, CarlsonMap))):
            if roots is not None:
                held |= needed_names(held, roots.where)[0].keys()
                self.where |= {s: meaning for s, meaning in roots.where.items() if s in held | _inside(roots)}

    def add_cycles(self, curve: MomentumCurve, region: RootInterval, signs: Signs) -> None:
        """Take over the values over cycles on a curve of a high degree, where Euler's integral gives them.

        Args:
            curve: of more than the fourth degree.
            region: where the motion is.
            signs: of the sample.
        """
        ends = roots_of_a_power(curve)
        if self.regions or ends is None or region.kind != "libration":
            return
        for key, numerator in self.numerators.items():
            R = rational_factor(curve, region, signs, key)
            # of C − A(x − b)ⁿ the value of ∮ is a beta function (Euler), where t(q) itself has genus ≥ 2
            cycle = between_the_roots_of_a_power(R, curve)
            if cycle is None:
                return
            # there and back
            turned = 2 * cycle * (1 if curve.substitution.increasing else -1)
            self.cycles[key] = PieceIntegral(numerator, sp.nan, turned, R, None, curve)
        for c in (curve.polynomial.LC(), curve.polynomial.coeff_monomial(1)):
            signs.sign(sp.factor(c))
        self.regions, self.roots = [(curve, region)], ends
        self.conditions |= signs.decided

    def refuse(self, flaws: Mapping[sp.Symbol, str]) -> None:
        """Take integrals out that failed.

        Args:
            flaws: W or a constant → what is wrong with it.
        """
        self.integrals = {key: value for key, value in self.integrals.items() if key not in flaws}
        self.cycles = {key: value for key, value in self.cycles.items() if key not in flaws}
        self.why_not |= {key: NotFound(flaw) for key, flaw in flaws.items()}


def piece(
    name: str, numerators: Mapping[sp.Symbol, sp.Expr], found: list[MomentumCurve], sample: Sample, prefix: str = "x",
    start: sp.Symbol | None = None,
) -> CoordinateIntegrals | None:  # fmt: skip
    """Integrate a coordinate in the regime of a sample.

    Args:
        name: of the coordinate.
        numerators: W or a constant → N(q), none that is zero.
        found: its curves, the simplest first, in the special case of the sample.
        sample: a motion.
        prefix: of the names of roots.
        start: the lower limit of its integrals.

    Returns:
        The piece; None where the motion is at rest or asymptotic in this coordinate.
    """
    made = CoordinateIntegrals(name, sample, numerators, start=start)
    # of an angle with several wells the variables of the own well of the motion first
    for curve in sorted(found, key=lambda one: not in_its_well(one, sample)):
        missing = [key for key in numerators if key not in made.integrals]
        if not missing:
            break
        region = root_interval_of(curve, sample)
        # an interval that ends where its variable is cut (cos θ of a motion through θ = π) is not the whole motion
        if region is None or not region.whole:
            continue
        made.region = made.region or region
        signs = Signs(sample.values, region.place)
        try:
            check_time()
            task = _Task(
                curve, region, signs, prefix + "b" * len(made.regions), start
            )  # roots of another P: other names
        except NoFormError as error:
            made.why_not |= {key: error.why for key in missing if key not in made.why_not}
            made.add_cycles(curve, region, signs)
            continue
        done = dict[sp.Symbol, PieceIntegral]()
        for key in missing:
            try:
                check_time()
                done[key] = task.integral(key, numerators[key])
            except NoFormError as error:
                made.why_not.setdefault(key, error.why)
        if done:
            made.add(done, task)
    return made if made.region is not None else None


class _Task:
    """One curve and the interval of it that a motion is on."""

    def __init__(self, curve: MomentumCurve, region: RootInterval, signs: Signs, prefix: str, start: sp.Symbol | None):
        self.curve, self.region, self.signs = curve, region, signs
        self.denominators = dict[sp.Expr, None]()
        # y² = P(x²) is elliptic in X = x² up to P of degree 3: x⁶ + x² and its kind have genus 2 but split
        self.squared = square_curve(curve, region, signs, prefix) if reduces(curve) else None
        if curve.degree > 4 and self.squared is None:
            raise NoFormError(why_no_form([curve]))
        self.changes: list[EvenMap | LegendreMap | CarlsonMap] = []
        if self.squared is not None:
            self.roots: NamedRoots | None = self.squared.roots
            self.changes = _maps(self.squared.inner, self.squared.roots, signs, prefix)
        else:
            self.roots = named_roots(curve, region, signs, prefix) if curve.degree > 2 else None
            # no real root: the integral has no turning point to begin at, and is taken from the lower limit (Carlson)
            if self.roots is not None and not self.roots.real and start is not None:
                begin = curve.substitution.place.subs(curve.coordinate.symbol, start)
                self.changes = [pairs_map(self.roots, signs, prefix, begin)]
            elif self.roots is not None:
                self.changes = _maps(curve, self.roots, signs, prefix)

    def integral(self, key: sp.Symbol, numerator: sp.Expr) -> PieceIntegral:
        """∫ N dq/√P² = ε ∫ N dx/(S √P)."""
        curve, s, region = self.curve, self.curve.substitution, self.region
        R = rational_factor(curve, region, self.signs, key)
        self.denominators[sp.denom(sp.cancel(sp.together(R)))] = None
        cyclic, change = region.kind in ("libration", "rotation"), None
        law: Antiderivative | None = None
        if self.roots is not None:
            value, whole, change = self._reduced_elliptic(R, cyclic=cyclic)
            if whole is not None and self.squared is not None and self.squared.passes and region.kind == "libration":
                plain = between_the_roots_of_a_power(R, curve)
                whole = whole if plain is None else plain
            value = value.xreplace({curve.x: s.place})
        else:
            # deg P ≤ 2: genus 0
            law = elementary_antiderivative(R, curve.polynomial, self.signs, self.side)
            if region.kind == "rotation" and any(isinstance(term, PairOfComplexPoles) for _, term in law.terms):
                # past complex poles a whole turn has no form here, and a rest at its end is not seen in this variable
                raise NoFormError("the integrand has poles at complex places, and no form over a turn is known here")
            value, whole = law.written(s.place), law.complete() if self._from_root_to_root() else None
        cycle = None
        if whole is not None:
            # a libration passes its interval twice; x may fall where q grows
            cycle = whole * (2 if region.kind == "libration" else s.turns) * (1 if s.increasing else -1)
        value = monotone_inverse(s.unwound(value, curve.coordinate.symbol, curve.coordinate.symbol))
        if longer_than(value, LONGEST_FORM):
            raise NoFormError(f"the form has more than {LONGEST_FORM} operations")
        # only an integral of the first kind has a single-valued inverse (Jacobi): sn, cn, dn
        first = None if R.has(curve.x) or self.squared is not None else R
        return PieceIntegral(numerator, value, cycle, R, law, curve, first, change, self.squared)

    def _reduced_elliptic(
        self, R: sp.Expr, *, cyclic: bool
    ) -> tuple[sp.Expr, sp.Expr | None, EvenMap | LegendreMap | CarlsonMap]:  # fmt: skip
        """Return an integral as a √P and few of the three kinds."""
        x, squared = self.curve.x, self.squared
        P = self.curve.polynomial if squared is None else squared.inner.polynomial
        a, rest = reduced(R if squared is None else squared.integrand(R, x), P)
        found, whole, change, more = self._elliptic(rest, P, cyclic=cyclic)
        a += more
        if squared is None:
            found += a * positive_root(P.as_expr()) if a != 0 else 0
        else:
            X = squared.X
            found += a * sp.sqrt(X) * positive_root(sp.quo(P, sp.Poly(X, X)).as_expr()) if a != 0 else 0
            found = squared.in_x(found, x)
            whole = None if whole is None else (2 if squared.passes else squared.side) * whole
        if whole is not None and self.region.kind == "rotation":
            whole += _edges(a, P, self.curve.substitution, squared)
        return found, whole, change

    def _elliptic(
        self, R: sp.Expr, P: sp.Poly, *, cyclic: bool
    ) -> tuple[sp.Expr, sp.Expr | None, EvenMap | LegendreMap | CarlsonMap, sp.Expr]:
        """Return the integral by the first map that reaches it.

        Over the whole interval too, where the motion has cycles.

        The last is a of a part a √P that is not in the integral yet.
        """
        reason: WhyNot = NotFound("P has complex roots in this regime")
        x, more = P.gen, sp.S.Zero
        for change in self.changes:
            try:
                if isinstance(change, EvenMap):
                    value = even_integral(R, change, x, self.signs, complete=False)
                    whole = even_integral(R, change, x, self.signs, complete=True) if cyclic else None
                    return value, whole, change, more
                parts = partial_fractions(R, x, self.signs)
                if isinstance(change, LegendreMap) and self._passes_a_pole(parts, change):
                    raise NoFormError("the integral passes a pole on the way from the root")
                if self._has_poles_at_roots(parts):
                    raise NoFormError("the integrand has poles at complex roots of P")
                if isinstance(change, CarlsonMap):
                    whole = carlson_integral(parts, change, None, self._side_of_pole) if cyclic else None
                    return carlson_integral(parts, change, x, self._side_of_pole), whole, change, more
                parts, a = without_square(parts, change, P)
                whole = elliptic_integral(parts, change, None) if cyclic else None
                return elliptic_integral(parts, change, x), whole, change, a
            except NoFormError as error:
                reason = error.why
        raise NoFormError(reason)

    def _has_poles_at_roots(self, parts: PartialFractions) -> bool:
        """Return whether a complex pole is a branch point, as of W on curves that hold 1 + x²."""
        if not parts.complex_poles or self.roots is None:
            return False
        at = self.signs.number
        roots = [(at(re), at(im)) for re, im in self.roots.pairs]
        poles = [(at(re), at(im)) for re, im, _, _ in parts.complex_poles]
        return any(abs(a - c) + abs(b - d) < _SAME * (abs(a) + abs(b)) for a, b in poles for c, d in roots)

    @property
    def _place(self) -> mpmath.mpf:
        """The place of the sample on the curve that is integrated on."""
        return self.region.place if self.squared is None else self.squared.place

    def _side_of_pole(self, r: sp.Expr) -> int:
        return 1 if self._place > self.signs.number(r) else -1

    def _passes_a_pole(self, parts: PartialFractions, change: LegendreMap) -> bool:
        """Return whether a pole lies between the motion and the root from which the integrals are taken."""
        start, here = self.signs.number(change.a), self._place
        low, high = min(start, here), max(start, here)
        return any(low < self.signs.number(r) < high for r, _, _ in parts.poles)

    def _from_root_to_root(self) -> bool:
        """Whether a cycle goes over the piece between the two roots of P: a libration, or sin(q/2) from −1 to 1."""
        if self.region.kind != "rotation":
            return self.region.kind == "libration"
        s, P = self.curve.substitution, self.curve.polynomial.as_expr()
        return all(end.is_finite and P.subs(self.curve.x, end).expand() == 0 for end in (s.lower, s.upper))

    def side(self, r: sp.Expr) -> int:
        """Return the sign of x − r on the interval."""
        return 1 if self.region.place > self.signs.number(r) else -1

    def real_roots(self) -> tuple[sp.Expr, ...] | None:
        """Return the real roots of P, ascending."""
        if self.squared is not None:
            return self.squared.turning_points(self.signs)
        return _roots(self.curve, self.signs) if self.roots is None else self.roots.real

    def conditions(self, constants: Sequence[sp.Symbol]) -> dict[sp.Expr, int]:
        """Return what the regime rests on."""
        if self.roots is not None:
            for decider in deciders(self.curve if self.squared is None else self.squared.inner, constants):
                if sp.count_ops(decider) <= LONGEST_CONDITION:
                    self.signs.sign(decider)
            self._keep_poles_apart(frozenset(constants))
        return self.signs.decided | self.region.conditions(self.signs)

    def _keep_poles_apart(self, constants: frozenset[sp.Symbol]) -> None:
        """Record parameters at which a pole is a root of P, or infinite, as R = r of a torus: other integrals hold."""
        P, x = self.curve.polynomial.as_expr(), self.curve.x
        for denominator in self.denominators:
            bare, back = named_constants(denominator, x)
            for pole, _ in sp.factor_list(bare, x)[1]:
                if sp.degree(pole, x) > 2 or not pole.free_symbols - {x}:
                    continue
                meeting = sp.resultant(pole.xreplace(back), P, x)
                for special in (sp.LC(pole, x).xreplace(back), meeting):
                    for factor, power in sp.factor_list(sp.numer(sp.together(special)))[1]:
                        if not factor.free_symbols & constants:
                            self.signs.sign(factor if power % 2 else factor**2)


def rational_factor(curve: MomentumCurve, region: RootInterval, signs: Signs, key: sp.Symbol) -> sp.Expr:
    """R(x) of an integral ∫ N dq/√P² = ∫ R dx/√P on a curve.

    Args:
        curve: the curve.
        region: where the motion is.
        signs: of the sample.
        key: W or a constant.
    """
    return sp.cancel(sp.together(region.orientation(signs) * curve.numerator(key) / curve.square))


def _edges(a: sp.Expr, P: sp.Poly, s: Substitution, squared: SquareCurve | None) -> sp.Expr:
    """Give a √P at the upper end of the turn less that at the lower; twice that where it is odd, on a curve in X = x².

    Raises:
        NoFormError: it is infinite there.
    """
    if a == 0:
        return sp.S.Zero
    if squared is not None:
        return (2 if squared.passes else 1) * _at_an_end(a, P, s.upper**2)
    return _at_an_end(a, P, s.upper) - _at_an_end(a, P, s.lower)


def _at_an_end(a: sp.Expr, P: sp.Poly, end: sp.Expr) -> sp.Expr:
    x = P.gen
    if end.is_finite:
        there = sp.expand(P.as_expr().subs(x, end))
        return sp.S.Zero if there == 0 else a.subs(x, end) * positive_root(there)
    top, bottom = (sp.Poly(part, x) for part in sp.fraction(sp.together(a)))
    excess = top.degree() - bottom.degree()
    if 2 * excess + P.degree() > 0:
        raise NoFormError("the integral is infinite at the end of the turn")
    if 2 * excess + P.degree() < 0:
        return sp.S.Zero
    return sp.sign(end) ** excess * top.LC() / bottom.LC() * positive_root(P.LC())


def monotone_inverse(value: sp.Expr) -> sp.Expr:
    """arcsin(sin w) is w, √(1 − cos² w) is sin w: the variable is monotone on the domain, w the principal value.

    Args:
        value: what holds them.
    """
    return value.replace(
        lambda e: isinstance(e, (sp.asin, sp.acos, sp.atan)) and e.args[0].func is e.inverse(),
        lambda e: e.args[0].args[0],
    ).replace(
        lambda e: e.is_Pow and abs(e.exp) == sp.S.Half and _of_one_angle(e.base) is not None,
        lambda e: _of_one_angle(e.base) ** (2 * e.exp),
    )


def _of_one_angle(radicand: sp.Expr) -> sp.Expr | None:
    """Return the sine of 1 − cos² w, w from 0 to π, the cosine of 1 − sin² w."""
    rest = 1 - radicand
    if not (rest.is_Pow and rest.exp == 2 and isinstance(rest.base, (sp.cos, sp.sin))):
        return None
    return (sp.sin if isinstance(rest.base, sp.cos) else sp.cos)(rest.base.args[0])


def _inside(roots: NamedRoots) -> set[sp.Symbol]:
    """Return the named roots that other names, and turning points, are written in."""
    return {s for s, meaning in roots.where.items() if isinstance(meaning, tuple)}


def _maps(
    curve: MomentumCurve, roots: NamedRoots, signs: Signs, prefix: str
) -> list[EvenMap | LegendreMap | CarlsonMap]:  # fmt: skip
    """Return the maps to Legendre's integrals, the plainest first."""
    # x² linear in sn² takes two squares of roots, others take differences of all; R_F and R_J take complex pairs, too
    found: list[EvenMap | LegendreMap | CarlsonMap] = []
    P = curve.polynomial
    if P.degree() == 4 and P.coeff_monomial(curve.x**3) == 0 and P.coeff_monomial(curve.x) == 0:
        even = even_map(roots)
        found += [even] if even is not None else []
    if not roots.pairs:
        found.append(legendre_map(roots, signs))
    found.append(carlson_map(roots, prefix))
    return found


def _roots(curve: MomentumCurve, signs: Signs) -> tuple[sp.Expr, ...] | None:
    """Return the real roots of P, deg P ≤ 2, ascending."""
    if curve.degree > 2:
        return None
    C, B, A = (curve.polynomial.coeff_monomial(curve.x**k) for k in range(3))
    if A == 0:
        return (sp.factor(sp.cancel(-C / B)),) if B != 0 else ()
    D = sp.factor_terms(sp.expand(B**2 / 4 - A * C))
    if signs.sign(D) < 0:
        return ()
    # (−B/2 ± √D)/A, ascending: dividing by A < 0 turns the order around
    order = (-1, 1) if signs.sign(A) > 0 else (1, -1)
    return tuple((-B / 2 + side * positive_root(D)) / A for side in order)
