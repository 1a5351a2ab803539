"""Exact initial data: what the user wrote, as exact numbers, and the constants of the motion they give.

Nothing is rounded here. A float is the binary number it is, "1.2" is 6/5, "sqrt(2)" stays a root; the
constants of the motion are exact expressions that can be had to any number of digits. Whether one of
them is zero (a parabolic orbit, a motion through the axis) is decided with ``ZERO_BITS`` bits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Integral
from typing import Any

import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.errors import InvalidInputError, MissingValueError
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.mechanics.coordinates_and_parameters import Parameter
from hjsolve.mechanics.system import System, momenta, refuse_turns_that_differ
from hjsolve.motion.rational_values import rational_value
from hjsolve.shown import Shown
from hjsolve.solution.quadratures import Solution

ZERO_BITS = 2048
_SHORT, _MOST_TERMS = 12, 400
"""Terms up to which a number is short, and up to which it is multiplied out."""

Values = Mapping[str, Any]


@dataclass(frozen=True, repr=False)
class Initial(Shown):
    """Everything exact at the initial time.

    Attributes:
        values: symbol → exact number, for parameters, coordinates and momenta.
        constants: name → exact number, in the order of the solution.
        exact: False when some input was a float: its last half ulp is in doubt, the computation is not.
    """

    values: Mapping[sp.Symbol, sp.Expr]
    constants: Mapping[str, sp.Expr]
    exact: bool


class InBits:
    """An exact number as a rule: binary digits asked ↦ its value; made by ``to_bits``, and pickled as the number."""

    __slots__ = ("_known", "_tape", "value")

    def __init__(self, value: sp.Expr):
        self.value, self._known = value, dict[int, Any]()
        self._tape = None if value.is_Rational else lower([value], [])

    def __call__(self, bits: int) -> Any:
        """Return the number, to (about) so many bits."""
        if bits not in self._known:
            more = Multi(bits + 64)
            if self._tape is None:
                exact = more.rational(int(self.value.p), int(self.value.q))
            else:
                exact = self._tape.run(more, [])[0]
            self._known[bits] = multiprecision(bits).convert(exact)
        return self._known[bits]

    def __reduce__(self) -> tuple[Any, ...]:
        return to_bits, (self.value,)


def to_bits(value: sp.Expr) -> InBits:
    """Return a rule that gives an exact number to any binary precision.

    Args:
        value: exact number of sympy.
    """
    return InBits(value)


def number_is_zero(value: sp.Expr) -> bool:
    """Decide whether an exact number is zero.

    A long one that two precisions agree on is not; else by sympy's own rules, which take their time, or to 2048 bits:
    it is zero where it is that small against its largest term, or where two precisions find nothing but rounding.

    Args:
        value: exact number of sympy.
    """
    if value.is_Rational:
        return bool(value == 0)
    short = _terms(value) <= _SHORT
    if (not short and _agreed(value, 128)) or (short and value.is_zero is False):
        return False
    if value.is_zero is not None:
        return bool(value.is_zero)
    if value.is_Mul:
        return any(number_is_zero(factor) for factor in value.args)
    if value.is_Pow and value.exp.is_positive:
        return number_is_zero(value.base)
    size = max(abs(to_bits(term)(64)) for term in sp.Add.make_args(value))
    tiny = abs(to_bits(value)(ZERO_BITS)) <= size * multiprecision(64).mpf(2) ** (64 - ZERO_BITS)
    return bool(tiny or not _agreed(value, ZERO_BITS // 2))


def _agreed(value: sp.Expr, bits: int) -> bool:
    """True where a number is the same, and not zero, at a precision and at twice as much."""
    near, far = (to_bits(value)(b) for b in (bits, 2 * bits))
    return bool(far and abs(near - far) <= abs(far) * multiprecision(64).mpf(2) ** -64)


def expanded(value: sp.Expr) -> sp.Expr:
    """Multiply an exact number out where that leaves it short; what is left as it is, is only worked out in digits.

    Args:
        value: exact number of sympy.
    """
    if value.is_Rational:
        return value
    return sp.expand(value) if _terms(value) <= _MOST_TERMS else value


def _terms(value: sp.Expr) -> int:
    """At least as many terms as the number multiplied out, counted up to a little beyond ``_MOST_TERMS``."""
    if value.is_Add:
        return min(_MOST_TERMS + 1, sum(_terms(part) for part in value.args))
    if value.is_Mul:
        return min(_MOST_TERMS + 1, math.prod(_terms(part) for part in value.args))
    if value.is_Pow:
        power = int(abs(value.exp)) if value.exp.is_Integer else 1
        return min(_MOST_TERMS + 1, _terms(value.base) ** min(power, 64))
    return 1


def sign(value: sp.Expr) -> int:
    """Return −1, 0 or 1.

    Args:
        value: exact real number of sympy.
    """
    if value.is_Rational:
        return (value.p > 0) - (value.p < 0)
    if number_is_zero(value):
        return 0
    return 1 if to_bits(value)(ZERO_BITS) > 0 else -1


def parameter_values(system: System, given: Values) -> dict[sp.Symbol, sp.Expr]:
    """Give every parameter of a system its exact value: the one given, else the default.

    Args:
        system: whose parameters are meant.
        given: name → number; the others take their defaults.

    Raises:
        InvalidInputError: a name that is no parameter, or a value against the parameter's ``assume``.
        MissingValueError: a parameter without any value, or a function in T or V that is left undetermined.
    """
    if system.functions:
        raise MissingValueError(
            f"{_listed(system.functions)}: left undetermined, so there are formulas but no numbers; write a formula in "
            "its place into T and V"
        )
    values = values_of(system.parameters, given)
    if given:
        refuse_turns_that_differ(system, [replace(p, value=values[p.symbol]) for p in system.parameters])
    return values


def values_of(parameters: Sequence[Parameter], given: Values) -> dict[sp.Symbol, sp.Expr]:
    """Give every parameter its exact value, as ``parameter_values``, where there is no T and V beside them.

    Args:
        parameters: as declared.
        given: name → number; the others take their defaults.

    Raises:
        InvalidInputError: a name that is no parameter, or a value against the parameter's ``assume``.
        MissingValueError: a parameter without any value.
    """
    known = {p.name: p for p in parameters}
    for name in given:
        if name not in known:
            raise InvalidInputError(f"parameters: {name!r} is not a parameter of this system; it has {_listed(known)}")
    values = {
        p.symbol: number(given[p.name], source=f"parameter {p.name}") if p.name in given else p.value
        for p in parameters
    }
    missing = [p.name for p in parameters if values[p.symbol] is None]
    if missing:
        raise MissingValueError(f"no value for {_listed(missing)}: write parameters={{{missing[0]!r}: …}}")
    for p in parameters:
        value = values[p.symbol]
        if p.assume == "integer" and value is not None and not value.is_Integer:
            raise InvalidInputError(f"parameters: {p.name} must be an integer, not {value}")
        if p.assume == "positive" and sign(values[p.symbol]) <= 0:
            raise InvalidInputError(f"parameters: {p.name} must be positive, not {values[p.symbol]}")
    return {symbol: value for symbol, value in values.items() if value is not None}


def read_initial_data(
    solution: Solution,
    *,
    q: Values,
    velocity: Values | None = None,
    p: Values | None = None,
    constants: Values | None = None,
    signs: Values | None = None,
    parameters: Values | None,
) -> Initial:
    """Read initial data and work out the constants of the motion.

    Args:
        solution: of the system.
        q: every coordinate → number.
        velocity, p, constants: every coordinate, or every constant of the motion → number; exactly one of the three.
        signs: with constants, every separated coordinate → 1 or −1, the sign of P = √P²; needless where P = 0.
        parameters: name → number, where it differs from the default.

    Raises:
        InvalidInputError: unknown or missing names, not exactly one of velocity, p and constants, a place outside the
            domain.
        MissingValueError: a value is missing.
    """
    system = solution.system
    values = parameter_values(system, arguments.table(parameters, "parameters", '{"m": 1}'))
    if sum(given is not None for given in (velocity, p, constants)) != 1:
        raise InvalidInputError(
            "initial data: give either velocity={…} or p={…}, each a number for every coordinate, or constants={…}"
        )
    if signs is not None and constants is None:
        raise InvalidInputError("signs: they go with constants={…}; velocity={…} and p={…} have signs already")
    places = _complete(system, q, "q")
    if constants is not None:
        values |= {c.symbol: places[c.name] for c in system.coordinates}
        _inside_domains(system, values)
        return _from_constants(solution, values, constants, signs or {}, _all_exact(q, constants, parameters))
    rates = _complete(system, velocity if p is None else p, "velocity" if p is None else "p")  # type: ignore[arg-type]
    values |= {c.symbol: places[c.name] for c in system.coordinates}
    _inside_domains(system, values)
    if p is None:
        motion = {c.velocity: rates[c.name] for c in system.coordinates}
        formulas = momenta(system)
        values |= {c.momentum: expanded(_put(formulas[c.name], {**values, **motion})) for c in system.coordinates}
    else:
        values |= {c.momentum: rates[c.name] for c in system.coordinates}
    constants = {name: _clean(_put(c.expression, values)) for name, c in solution.constants.items()}
    return Initial(values, constants, _all_exact(q, velocity, p, parameters))


def _from_constants(
    solution: Solution, values: dict[sp.Symbol, sp.Expr], given: Values, signs: Values, exact: bool
) -> Initial:
    """Momenta from the constants of the motion and the signs of the roots: p = ±√P²(q) − A."""
    _only_known(given, solution.constants, "constants")
    _only_known(signs, solution.coordinates, "signs")
    constants = {name: number(given[name], source=f"constants[{name}]") for name in solution.constants}
    values |= {solution.constants[name].symbol: value for name, value in constants.items()}
    unsigned = []
    for name in solution.coordinates:
        squared = expanded(solution.momentum_squared[name].subs(values))
        if number_is_zero(squared):
            root = sp.Integer(0)
        elif name not in signs:
            unsigned.append(name)
            continue
        else:  # where P² < 0 any momentum will do: that no motion is there is told when its region is looked for
            root = _sign_given(name, signs[name]) * (sp.sqrt(squared) if sign(squared) > 0 else sp.Integer(1))
        values[solution.system.coordinate(name).momentum] = root - solution.shift[name].subs(values)
    if unsigned:
        raise MissingValueError(f"signs: no sign for {_listed(unsigned)}; write signs={{{unsigned[0]!r}: 1}} or -1")
    return Initial(values, {name: _clean(value) for name, value in constants.items()}, exact)


def _only_known(given: Values, names: Iterable[str], what: str) -> None:
    names = list(names)
    for name in arguments.table(given, what, f'{{"{next(iter(names), "")}": 1}}'):
        if name not in names:
            raise InvalidInputError(f"{what}: {name!r} is not known here; this solution has {_listed(names)}")
    missing = [name for name in names if name not in given]
    if missing and what == "constants":
        raise MissingValueError(f"constants: no value for {_listed(missing)}; all of {_listed(names)} are needed")


def _sign_given(name: str, value: Any) -> sp.Integer:
    if not isinstance(value, int | float | sp.Number | Integral) or value not in (1, -1):
        raise InvalidInputError(f"signs[{name}]: 1 or -1 is needed, not {arguments.described(value)}")
    return sp.Integer(int(value))


def _put(formula: sp.Expr, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """A formula with numbers for its symbols; ``subs`` takes longer, and cares for what is 0/0 to ``xreplace``."""
    rational = rational_value(formula, values)
    if rational is not None:
        return rational
    try:
        result = formula.xreplace(values)
    except (ZeroDivisionError, TypeError):
        return formula.subs(values)
    return formula.subs(values) if result.has(sp.nan, sp.zoo) else result


def _clean(value: sp.Expr) -> sp.Expr:
    """Expand, and turn a number that is zero into 0."""
    value = expanded(value)
    if value.is_Rational:
        return value
    if value.has(sp.zoo, sp.nan, sp.oo):
        raise InvalidInputError(
            "initial data: a constant of the motion is infinite there; the place is a singularity of the coordinates"
        )
    return sp.Integer(0) if number_is_zero(value) else value


def _complete(system: System, given: Values, what: str) -> dict[str, sp.Expr]:
    names = [c.name for c in system.coordinates]
    given = arguments.table(given, what, f'{{"{names[0]}": 1}}')
    for name in given:
        if name not in names:
            raise InvalidInputError(f"{what}: {name!r} is not a coordinate of this system; it has {_listed(names)}")
    missing = [name for name in names if name not in given]
    if missing:
        raise MissingValueError(f"{what}: no value for {_listed(missing)}; every coordinate needs one")
    return {name: number(given[name], source=f"{what}[{name}]") for name in names}


def _inside_domains(system: System, values: Mapping[sp.Symbol, sp.Expr]) -> None:
    for c in system.coordinates:
        place = values[c.symbol]
        for bound, side in ((c.domain.lower, 1), (c.domain.upper, -1)):
            if bound is None:
                continue
            end = bound.subs(values)
            if not _real(end):
                given = ", ".join(f"{symbol} = {values[symbol]}" for symbol in sorted(bound.free_symbols, key=str))
                raise InvalidInputError(
                    f"parameters: the domain of {c.name} {'begins' if side > 0 else 'ends'} at {bound}, which is no "
                    f"real number for {given}; choose parameters for which it is"
                )
            if sign(side * (place - end)) <= 0:
                raise InvalidInputError(
                    f"q[{c.name}]: {place} is outside the domain, which {'begins' if side > 0 else 'ends'} at {bound}"
                )


def _real(value: sp.Expr) -> bool:
    """False for what is certainly no real number."""
    return bool(value.is_Rational or value.evalf(20).is_real is not False)


def domain_ends(
    system: System, name: str, values: Mapping[sp.Symbol, sp.Expr]
) -> tuple[sp.Expr | None, sp.Expr | None]:
    """Return the exact ends of a coordinate's domain, None where it has none.

    Args:
        system: that has the coordinate.
        name: of the coordinate.
        values: symbol → exact number, of the parameters that the ends hold.

    Returns:
        Lower end, upper end.
    """
    domain = system.coordinate(name).domain
    lower_end, upper_end = (None if b is None else b.subs(values) for b in (domain.lower, domain.upper))
    return lower_end, upper_end


def _all_exact(*groups: Values | None) -> bool:
    return not any(isinstance(value, float) for group in groups if group for value in group.values())


def _listed(names: Any) -> str:
    return ", ".join(str(name) for name in names) or "none"
