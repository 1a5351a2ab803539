"""A solution made ready for arrays: straight-line programs for the constants, for p² and for its kernels.

Near an end e of a coordinate's domain p² may have a pole (cos θ at the axis), and q itself says too little about the
distance from it. So besides p²(q) there are programs for p²(e + x) and p²(e − x), simplified in x: x keeps its relative
accuracy where q does not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache

import sympy as sp
from mpmath import frexp, ldexp

from hjsolve.arithmetic.error_free import Pair, split
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.removable_poles import without_removable_poles
from hjsolve.lowering import lower, with_plain_exponents, without_inverse_functions
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.winding import radians_of_a_unit
from hjsolve.solution.quadratures import Solution

_HIGHEST_DEGREE = 4
"""Of p² in the constants, which is 2 wherever H is quadratic in the momenta."""
_KEPT = 32
"""Tables of clearances that stay, each of some 0.6 MB."""
_BITS = 256
"""Of a parameter that is not a fraction."""


@dataclass(frozen=True)
class LoweredFormula:
    """The formulas of p² and its kernels as functions of x, q = origin + sign·x.

    Attributes:
        origin: in two doubles.
        sign: +1 or −1.
        squared: tape of F.
        full: tape of F and ½ ∂F/∂cⱼ for every constant. Inputs x, constants, parameters.
        clearance: where the functions of x in these are known to be analytic.
    """

    origin: Pair
    sign: int
    squared: Tape
    full: Tape
    clearance: Clearance = field(compare=False, repr=False)


@dataclass(frozen=True)
class Separated:
    """One separated coordinate.

    Attributes:
        name: of the coordinate.
        index: its place among all coordinates.
        plain: p²(q).
        lower, upper: p² seen from the ends of the domain, None where there is no end.
        periodic: True where p² has period 2π, of an angle or of a place on a line.
        repeats: True where p² has another period along a line.
        shifted: True where P differs from p.
        even: True where p²(−q) = p²(q), on a domain that is even, too.
    """

    name: str
    index: int
    plain: LoweredFormula
    lower: LoweredFormula | None
    upper: LoweredFormula | None
    periodic: bool
    repeats: bool
    shifted: bool
    even: bool


@dataclass(frozen=True)
class Model:
    """What the batch engine needs of a solution.

    Attributes:
        names: all coordinates.
        angles: those that are ignorable angles.
        separated: the separated coordinates.
        constants: names in order.
        ignorable: coordinate → place of its momentum among the constants.
        rule: tape of the constants; inputs all q, all p, parameters.
        shift: tape of Pᵢ − pᵢ, same inputs.
        numbers: parameters in two doubles.
        exact: the same as fractions, of what is none 256 bits.
    """

    names: tuple[str, ...]
    angles: tuple[str, ...]
    separated: tuple[Separated, ...]
    constants: tuple[str, ...]
    ignorable: Mapping[str, int] = field(hash=False)
    rule: Tape
    shift: Tape
    numbers: tuple[Pair, ...]
    exact: tuple[Fraction, ...]


def next_to_poles(solution: Solution) -> Solution | None:
    """Return a solution whose p² keeps its digits next to poles that cancel; None where there are none."""
    squares = {
        name: without_removable_poles(F, solution.system.coordinate(name).symbol, near=True)
        for name, F in solution.momentum_squared.items()
    }
    same = all(F is solution.momentum_squared[name] for name, F in squares.items())
    return None if same else replace(solution, momentum_squared=squares)


def lowered_model(solution: Solution, values: Mapping[sp.Symbol, sp.Expr]) -> Model:
    """Lower a solution."""
    system = solution.system
    parameters = [p.symbol for p in system.parameters]
    constants = [c.symbol for c in solution.constants.values()]
    start = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates] + parameters
    # constants and p² of all orbits are one program each: parameters stay inputs, so a new value makes none
    rule = lower([with_plain_exponents(c.expression, values) for c in solution.constants.values()], start)
    momenta = {c.momentum: c.momentum for c in system.coordinates}
    shift = lower([solution.shift[n].subs(momenta) for n in solution.coordinates], start)
    names = tuple(c.name for c in system.coordinates)
    symbols, known = (tuple(constants), tuple(parameters)), tuple(values.items())
    separated = tuple(
        _separated(
            system.coordinate(name), (solution.momentum_squared[name], solution.shift[name] != 0), names.index(name),
            symbols, known,
        )
        for name in solution.coordinates
    )  # fmt: skip
    ignorable = {
        c.name: list(solution.constants).index(c.momentum.name)
        for c in system.coordinates
        if c.name not in solution.coordinates and c.momentum.name in solution.constants
    }
    angles = tuple(
        c.name for c in system.coordinates if c.name not in solution.coordinates and c.domain.kind == "angle"
    )
    numbers = tuple(parameter_pair(values[s]) for s in parameters)
    exact = tuple(_fraction(values[s]) for s in parameters)
    return Model(names, angles, separated, tuple(solution.constants), ignorable, rule, shift, numbers, exact)


def parameter_pair(value: sp.Expr) -> Pair:
    """Return a number in two doubles."""
    return split(to_bits(value)(160))


def _fraction(value: sp.Expr) -> Fraction:
    if isinstance(value, sp.Rational):
        return Fraction(int(value.p), int(value.q))
    mantissa, power = frexp(to_bits(value)(_BITS))
    return Fraction(int(ldexp(mantissa, _BITS))) * Fraction(2) ** (int(power) - _BITS)


@lru_cache(maxsize=_KEPT)
def _separated(
    coordinate: Coordinate, shell: tuple[sp.Expr, bool], index: int,
    symbols: tuple[tuple[sp.Symbol, ...], tuple[sp.Symbol, ...]], known: tuple[tuple[sp.Symbol, sp.Expr], ...],
) -> Separated:  # fmt: skip
    """Lower p² of a coordinate, ``shell`` with whether P differs from p; ``symbols`` of constants and parameters."""
    (constants, parameters), values = symbols, dict(known)
    q, name = coordinate.symbol, coordinate.name
    F = without_removable_poles(with_plain_exponents(shell[0], values), q)
    # ½ ∂p²/∂c = p ∂p/∂c: the integrand of ∂J/∂c times p, which has no pole at a turning point
    kernels = [sp.diff(F, c) / 2 for c in constants]
    parts = _parts(F, constants)

    domain = coordinate.domain
    lower_end, upper_end = domain.lower, domain.upper

    def formula(origin: sp.Expr, sign: int, near: Callable[[sp.Expr], sp.Expr]) -> LoweredFormula:
        arguments = [q, *constants, *parameters]
        # p²(origin ± x) multiplied out in x: a pole at x = 0 is a power of x, not a difference of q and the end
        seen = [near(e) for e in (F, *kernels)]
        side = 1 if origin == lower_end or sign < 0 else -1 if origin == upper_end else 0
        if parts is None:
            numbers = tuple(parameter_pair(values[s]) for s in parameters)
            clearance = Clearance(lower(seen, arguments), numbers, alone=False, side=side)
        else:
            shapes = _shapes([near(e) for e in parts], q)
            # a table is kept by its numbers: parameters that only scale a function would ask for a new one each time
            inner = tuple(s for s in parameters if any(e.has(s) for e in shapes))
            clearance = _clearance(shapes, (q, *inner), tuple(parameter_pair(values[s]) for s in inner), side)
        return LoweredFormula(
            parameter_pair(origin.subs(values)), sign, lower(seen[:1], arguments), lower(seen, arguments), clearance
        )

    def from_end(end: sp.Expr | None, sign: int) -> LoweredFormula | None:
        if end is None:
            return None
        return formula(end, sign, lambda e: multiplied_out(e.subs(q, end + sign * q), q))

    plain = formula(sp.Integer(0), 1, lambda e: e)
    # a rotation needs the period of p² along q: 2π of an angle, any other along a line
    radians = radians_of_a_unit(F, q, values) if domain.kind == "line" else None
    turns = domain.kind == "angle" or radians == 1
    angle = turns and periodic(plain.squared, values, constants, parameters)
    repeats = radians is not None and not angle
    open_ = lower_end is None and upper_end is None
    same = open_ or (lower_end is not None and upper_end is not None and sp.expand(lower_end + upper_end) == 0)
    # p² even about the middle of its domain: half of the nodes serve
    even = bool(same and not angle and sp.expand(F.subs(q, -q) - F) == 0)
    below, above = from_end(lower_end, 1), from_end(upper_end, -1)
    return Separated(name, index, plain, below, above, angle, repeats, shell[1], even)


def _parts(F: sp.Expr, constants: Sequence[sp.Symbol]) -> list[sp.Expr] | None:
    """Return the coefficients of F as a polynomial in the constants; None where it is none, or of a high degree."""
    found, level = [], [(F, 0)]
    none = dict.fromkeys(constants, 0)
    # Taylor's coefficients at c = 0 but for n!, order by order; F is a polynomial if those of some order are all 0
    for _ in range(_HIGHEST_DEGREE + 1):
        found += [e.subs(none) for e, _ in level]
        level = [
            (slope, k)
            for e, first in level
            for k, c in enumerate(constants)
            if k >= first and (slope := sp.diff(e, c)) != 0
        ]
        if not level:
            return list(dict.fromkeys(found))
    return None


def _shapes(parts: list[sp.Expr], q: sp.Symbol) -> tuple[sp.Expr, ...]:
    """Return some functions of q without their strengths, so that formulas that differ by these alone share a table.

    A factor that q is not in changes nothing of where a function is analytic, nor of how it grows. A sum of powers of q
    gives way to the powers: each of them grows in a disk as it does about every other place.
    """
    shapes: set[sp.Expr] = set()
    for part in parts:
        terms = [term.as_independent(q, as_Add=False)[1] for term in sp.Add.make_args(part)]
        powers = all(term.as_base_exp()[0] == q for term in terms if term.has(q))
        shapes.update(terms if powers else [part.as_independent(q, as_Add=False)[1]])
    return tuple(sorted((shape for shape in shapes if shape.has(q)), key=sp.default_sort_key))


@lru_cache(maxsize=_KEPT)
def _clearance(
    shapes: tuple[sp.Expr, ...], inputs: tuple[sp.Symbol, ...], numbers: tuple[Pair, ...], side: int
) -> Clearance:
    return Clearance(lower(list(shapes), list(inputs)), numbers, alone=True, side=side)


def multiplied_out(expression: sp.Expr, x: sp.Symbol) -> sp.Expr:
    """Multiply out sums that hold x as polynomials, so that what cancels at x = 0 is gone.

    Args:
        expression: a formula in x and other symbols.
        x: the symbol that tends to zero.
    """
    expression = without_inverse_functions(expression)

    def expanded(e: sp.Expr) -> sp.Expr:
        if e.is_Add and e.has(x):
            wide = sp.expand(e)
            # a sum that grows is run at every node of every orbit: it stays as it is
            return wide if sp.count_ops(wide) <= 2 * sp.count_ops(e) + 8 else e
        return e

    return sp.sympify(expression).replace(lambda e: e.is_Add and e.has(x), expanded)


def periodic(
    squared: Tape, values: Mapping[sp.Symbol, sp.Expr], constants: Sequence[sp.Symbol], parameters: Sequence[sp.Symbol]
) -> bool:
    """Tell whether p² has period 2π in q, at three places with arbitrary constants.

    Args:
        squared: tape of p²; its inputs are q, constants, parameters.
        values: numbers of the parameters.
        constants: symbols of the constants of the motion, in the order of the inputs.
        parameters: symbols of the parameters, in the order of the inputs.
    """
    arithmetic = Multi(160)
    turn = 2 * arithmetic.pi()
    inputs = [arithmetic.convert(Fraction(7 + 3 * k, 5)) for k in range(len(constants))]
    inputs += [arithmetic.convert(to_bits(values[s])(160)) for s in parameters]
    for k in range(3):
        q = arithmetic.convert(Fraction(13 + 17 * k, 29))
        try:
            here, there = (squared.run(arithmetic, [x, *inputs])[0] for x in (q, q + turn))
        except (InvalidInputError, ZeroDivisionError):
            return False
        # 160 bits compared to 120: a formula with arbitrary constants is not equal at three places by chance
        if abs(here - there) > arithmetic.convert(2.0**-120) * (abs(here) + abs(there)):
            return False
    return True
