"""A motion taken apart: one motion for every separated coordinate, and the equations that couple them to the time.

A zero of multiplicity three or more cannot be distinguished from a zero and a pair close to it by any number of digits.
Where p² is a rational function of q with rational coefficients, its square-free factorisation decides (Yun 1976).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.display.shown import Shown
from hjsolve.errors import NotConvergedError
from hjsolve.formulas.removable_poles import along_motion
from hjsolve.lowering import momentum_squared_tapes, with_plain_exponents
from hjsolve.mechanics.kinks import Kink, smooth_intervals
from hjsolve.motion import quantities
from hjsolve.motion.initial_data import ZERO_BITS, InBits, Initial, domain_ends, expanded, number_is_zero, sign, to_bits
from hjsolve.motion.joined_terms import by_half_angles, with_exact_coefficients
from hjsolve.motion.winding import radians_of_a_unit
from hjsolve.one_coordinate.allowed_regions import forbidden
from hjsolve.one_coordinate.classify import Located, locate
from hjsolve.one_coordinate.coordinate_start import Cell, CoordinateStart, Winding
from hjsolve.one_coordinate.kinks import cell_of, in_its_cell
from hjsolve.one_coordinate.momentum_squared import MomentumSquared, has_period
from hjsolve.solution.quadratures import Solution
from hjsolve.time_law.open_motion import TriangularScheme, plan
from hjsolve.time_law.torus import TorusEquations, torus_equations

_FARTHEST, _MOST_ANGLE = 2**1000, 2**48
"""Where a motion may start: the largest length, and the largest angle."""


@dataclass(frozen=True, eq=False, repr=False)
class SeparatedMotion(Shown):
    """A motion taken apart; states, passages and proofs are worked out from it, ``Motion`` shows its numbers.

    Attributes:
        solution: what is solved.
        initial: the exact initial data and constants.
        t0: the initial time, exact.
        digits: digits of every number.
        parts: what was integrated, of ``one_coordinate.coordinate_motion.PARTS``.
        located: separated coordinate → its motion and the ends of its region.
        equations: Jacobi's equations made ready for inversion; None where every coordinate is ignorable, or no time
            was asked for.
        turning_points: coordinate → (lower, upper), None where there is none on that side; no key for a rotation.
        frequencies: coordinate → Ω = ∂H/∂J, where it exists.
    """

    solution: Solution
    initial: Initial
    t0: sp.Expr
    digits: int
    parts: frozenset[str]
    located: Mapping[str, Located]
    equations: TorusEquations | TriangularScheme | None
    turning_points: Mapping[str, tuple[Estimate | None, Estimate | None]]
    frequencies: Mapping[str, Estimate]

    @property
    def torus(self) -> TorusEquations | None:
        """The equations in angle form, where every coordinate is bounded."""
        return None if self.equations is None else self.equations.torus

    @property
    def scheme(self) -> TriangularScheme | None:
        """The equations as they stand, where some coordinate does not come back."""
        return None if self.equations is None else self.equations.scheme


def separated_motion(
    solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str]
) -> SeparatedMotion:
    """Integrate every separated coordinate and make the equations ready that couple them.

    Args:
        digits: decimal digits of every number.
        parts: what is integrated, of ``one_coordinate.coordinate_motion.PARTS``.

    Raises:
        ForbiddenMotionError: no real motion has these constants.
        NotConvergedError: a turning point or an integral did not converge to the digits asked.
    """
    begins = {name: replace(coordinate_start(solution, initial, name), parts=parts) for name in solution.coordinates}
    located = {name: locate(checked(begin), digits) for name, begin in begins.items()}
    # in the order of the solution: rows of Jacobi's equations refer to it
    coordinate_motions = [located[name].coordinate_motion for name in solution.coordinates]
    bounded = [stays for c in coordinate_motions if (stays := c.bounded) is not None]
    equations: TorusEquations | TriangularScheme | None = None
    if coordinate_motions and "time" in parts:
        # angles exist where every coordinate comes back; else the equations are solved one after the other
        equations = (
            torus_equations(bounded, bits_for(digits, 128))
            if len(bounded) == len(coordinate_motions)
            else plan(coordinate_motions)
        )
    return SeparatedMotion(
        solution, initial, t0, digits, parts, located, equations, turning_points(located, digits),
        quantities.frequencies(solution, initial, equations, digits) if "time" in parts else {},
    )  # fmt: skip


def turning_points(located: Mapping[str, Located], digits: int) -> dict[str, tuple[Estimate | None, Estimate | None]]:
    """Return the ends of the regions, rounded with their errors; none of a rotation.

    Args:
        located: separated coordinate → its motion and the ends of its region.
        digits: decimal digits to give them to.
    """
    return {
        name: quantities.turning_points_of(place, digits)
        for name, place in located.items()
        if place.lower.kind != "round"
    }


def coordinate_start(solution: Solution, initial: Initial, name: str) -> CoordinateStart:
    """Bring one separated coordinate over to numbers.

    Args:
        name: of the separated coordinate.
    """
    kinks = [kink for kink in solution.system.kinks if kink.coordinate == name]
    if kinks:
        return _with_kinks(solution, initial, name, kinks)
    return _smooth_start(solution, initial, name, solution.momentum_squared[name])


def _with_kinks(solution: Solution, initial: Initial, name: str, kinks: Sequence[Kink]) -> CoordinateStart:
    """Return a coordinate along which p² has kinks, cut into intervals on which it is analytic."""
    F, q = solution.momentum_squared[name], solution.system.coordinate(name).symbol
    known = {solution.constants[c].symbol: value for c, value in initial.constants.items()}
    # everything but q, so that p² at a kink is a number that is decided exactly
    known |= {symbol: value for symbol, value in initial.values.items() if symbol != q}
    cells = []
    ends = domain_ends(solution.system, name, initial.values)
    for low, high, signs in smooth_intervals(kinks, q, initial.values, ends):
        own = F.xreplace(signs)
        start = _smooth_start(solution, initial, name, own)
        lower, upper = (None if end is None else to_bits(end) for end in (low, high))
        cells.append(Cell(lower, upper, start.radicand, *(_limit(own.xreplace(known), q, end) for end in (low, high))))
    own = _smooth_start(solution, initial, name, F.xreplace({k.symbol: initial.values[k.symbol] for k in kinks}))
    return replace(own, winding=None, cells=tuple(cells))


def _limit(squared: sp.Expr, q: sp.Symbol, end: sp.Expr | None) -> InBits | None:
    """p² at an end of an interval; None where it is infinite, or where there is no end."""
    if end is None:
        return None
    value = expanded(squared.xreplace({q: end}))
    if value.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        return None
    return to_bits(sp.S.Zero if number_is_zero(value) else value)


def start_at(
    solution: Solution, name: str, squared: sp.Expr, values: Mapping[sp.Symbol, sp.Expr], place: sp.Expr,
    exact: tuple[sp.Expr, ...] | None = None,
) -> CoordinateStart:  # fmt: skip
    """Make programs of one p², analytic in the coordinate, and begin at a place on the way up.

    Args:
        name: of the separated coordinate.
        squared: p² in terms of the coordinate, the constants and the parameters.
        values: symbol → exact number, of every constant and parameter.
        place: exact.
        exact: as of ``momentum_squared_tapes``.
    """
    coordinate = solution.system.coordinate(name)
    constants = tuple(c.symbol for c in solution.constants.values())
    parameters = tuple(p.symbol for p in solution.system.parameters)
    programs = momentum_squared_tapes(squared, coordinate.symbol, constants, parameters, exact)
    rules = [to_bits(sp.sympify(values[s])) for s in (*constants, *parameters)]
    radicand, here = MomentumSquared(*programs[:2], partial(_at_bits, rules)), to_bits(sp.sympify(place))
    low, high = (None if end is None else to_bits(end) for end in domain_ends(solution.system, name, values))
    angle = coordinate.domain.kind == "angle" and (programs[3] or has_period(radicand, here))
    return CoordinateStart(name, radicand, here, 1, low, high, angle, programs[2])


def _smooth_start(solution: Solution, initial: Initial, name: str, squared: sp.Expr) -> CoordinateStart:
    """Start a motion by one p², analytic in the coordinate."""
    coordinate = solution.system.coordinate(name)
    q, place = coordinate.symbol, initial.values[coordinate.symbol]
    # 1 − cos q = 2 sin²(q/2): next to a zero of p² at the end of a domain the difference would lose its digits
    F = by_half_angles(with_plain_exponents(squared, initial.values), q)
    constants = tuple(solution.constants[c].symbol for c in solution.constants)
    parameters = tuple(p.symbol for p in solution.system.parameters)
    known = {solution.constants[c].symbol: initial.constants[c] for c in solution.constants}
    known |= {s: initial.values[s] for s in parameters}
    F = along_motion(F, q, known | {q: place})
    own = (F, *(sp.diff(F, c) / 2 for c in constants))
    # coefficients that are exact numbers are rounded once, not term by term
    joined = tuple(with_exact_coefficients(e, q, known) for e in own)
    start = start_at(solution, name, F, known, place, None if joined == own else joined)
    momentum, shift = initial.values[coordinate.momentum], solution.shift[name]
    # P = p + A is what goes with p²; its sign says in which direction the coordinate begins
    root = expanded(momentum + shift.subs(initial.values)) if shift != 0 else expanded(momentum)
    forward, radicand = sign(root), start.radicand
    if forward and not solution.system.kinks:
        radicand = radicand.guarded(start.place, _square(to_bits(root)))
    start = replace(start, radicand=radicand, forward=forward, exact=ExactZeros(F, q, known, place))
    if coordinate.domain.kind != "line":
        return start
    return replace(start, winding=_winding(start, F, q, constants, parameters, initial))


def _winding(
    start: CoordinateStart, F: sp.Expr, q: sp.Symbol, constants: tuple[sp.Symbol, ...],
    parameters: tuple[sp.Symbol, ...], initial: Initial,
) -> Winding | None:  # fmt: skip
    """Return a coordinate on a line as an angle.

    None where p² does not repeat itself, or where the place is too far out.
    """
    rate = radians_of_a_unit(F, q, initial.values)
    if rate is None:
        return None
    # along a line on which p² repeats itself q becomes an angle, its momentum p/rate
    scale, angle = to_bits(1 / rate), to_bits(initial.values[q] * rate)
    if abs(angle(64)) >= _MOST_ANGLE:
        return None
    squared, kernels, absent, _ = momentum_squared_tapes(F.xreplace({q: q / rate}) / rate**2, q, constants, parameters)
    radicand = replace(start.radicand, squared=squared, kernels=kernels)
    return Winding(replace(start, radicand=radicand, place=angle, angle=True, skipped=absent), scale)


def _at_bits(rules: list[InBits], bits: int) -> list[Mpf]:
    return [rule(bits) for rule in rules]


def _square(root: Callable[[int], Mpf]) -> Callable[[int], Mpf]:
    """Return the square p² of a root that may be what two large numbers leave."""
    return lambda bits: root(bits + ZERO_BITS) ** 2


def checked(begin: CoordinateStart) -> CoordinateStart:
    """Give a beginning back once p² ≥ 0 there.

    Args:
        begin: place, direction and p²(q) of a coordinate at t₀.

    Raises:
        NotConvergedError: the place is so far out that doubles cannot tell places apart there.
        ForbiddenMotionError: p² < 0 there, although the momentum given is not zero.
    """
    place = begin.place(256 + begin.radicand.guard)
    if abs(place) >= (_MOST_ANGLE if begin.angle else _FARTHEST):
        cure = "take whole turns off" if begin.angle else "write lengths in another unit"
        raise NotConvergedError(f"q[{begin.name}]: is so far out that doubles cannot tell places apart there; {cure}")
    # p² = P² ≥ 0 at the start but for contradictions between constants and momenta
    value = begin.radicand.value(place, 256)
    if begin.forward and value < 0:
        raise forbidden(in_its_cell(begin, cell_of(begin, begin.forward)) if begin.cells else begin)
    return begin


@dataclass(frozen=True)
class ExactZeros:
    """Zeros of p², decided exactly; see ``one_coordinate.coordinate_start.ExactSquare``.

    Attributes:
        squared: p² as a formula.
        variable: the symbol of q.
        values: symbol → exact number, of all other symbols.
        place: q at the start, exact.
    """

    squared: sp.Expr
    variable: sp.Symbol
    values: Mapping[sp.Symbol, sp.Expr]
    place: sp.Expr

    def order_at_start(self) -> int:
        """Return the order of the zero of p² at the initial place, 0 of none; 3 for all from 3 on."""
        slope = self.squared
        for order in range(3):
            value = expanded(slope.xreplace({**self.values, self.variable: self.place}))
            if value.has(sp.nan, sp.zoo, sp.oo) or not number_is_zero(value):
                return order
            slope = sp.diff(slope, self.variable)
        return 3

    def multiple_zeros(self) -> list[InBits]:
        """Return the zeros of p² proved to be triple or higher; none where p² is not a rational function."""
        number = expanded(self.squared.xreplace(dict(self.values)))
        if not number.is_rational_function(self.variable):
            return []
        # a triple zero stops the search by exclusion: neither F, F′ nor F″ keeps its sign there
        above = sp.fraction(sp.together(number))[0]
        polynomial = sp.Poly(above, self.variable)
        if not all(c.is_Rational for c in polynomial.coeffs()):
            return []
        factors = [factor for factor, multiplicity in polynomial.sqf_list()[1] if multiplicity >= 3]
        return [to_bits(root) for factor in factors for root in sp.real_roots(factor)]
