"""Exact initial data: what the user wrote, as exact numbers, and the constants of the motion they give.

Nothing is rounded here. A float is the binary number it is, "1.2" is 6/5, "sqrt(2)" stays a root; the
constants of the motion are exact expressions that can be evaluated to any number of digits. Whether one of
them is zero (a parabolic orbit, a motion through the axis) is decided with ``ZERO_BITS`` bits.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Integral

import sympy as sp

from hjsolve import arguments
from hjsolve.display.shown import Shown
from hjsolve.errors import ForbiddenPlaceError, InvalidInputError, MissingValueError
from hjsolve.formulas.read import number
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter, contradicts
from hjsolve.mechanics.kinks import signs_at
from hjsolve.mechanics.system import System, check_values, momenta
from hjsolve.motion.exact_numbers import ZERO_BITS as ZERO_BITS
from hjsolve.motion.exact_numbers import InBits as InBits
from hjsolve.motion.exact_numbers import expanded as expanded
from hjsolve.motion.exact_numbers import number_is_zero as number_is_zero
from hjsolve.motion.exact_numbers import sign as sign
from hjsolve.motion.exact_numbers import to_bits as to_bits
from hjsolve.motion.rational_values import rational_value
from hjsolve.solution.quadratures import Solution

Values = Mapping[str, object]


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


def parameter_values(system: System, given: Values) -> dict[sp.Symbol, sp.Expr]:
    """Give every parameter of a system its exact value: the one given, else the default.

    Args:
        system: whose parameters are meant.
        given: name → number; the others take their defaults.

    Raises:
        InvalidInputError: a name that is not a parameter, or a value against the parameter's ``assume``.
        MissingValueError: a parameter without any value, or a function in T or V that is left undetermined.
    """
    if system.functions:
        raise MissingValueError(
            f"{_listed(system.functions)}: left undetermined, so there are formulas but no numbers; write a formula in "
            "its place into T and V"
        )
    values = values_of(system.parameters, given)
    if given:
        given_values = [replace(p, value=values[p.symbol]) for p in system.parameters]
        check_values(system, given_values, refuse_ends=False)
    return values


def values_of(parameters: Sequence[Parameter], given: Values) -> dict[sp.Symbol, sp.Expr]:
    """Give every parameter its exact value, as ``parameter_values``, where there is no T and V next to them.

    Args:
        parameters: as declared.
        given: name → number; the others take their defaults.

    Raises:
        InvalidInputError: a name that is not a parameter, or a value against the parameter's ``assume``.
        MissingValueError: a parameter without any value.
    """
    known = {p.name: p for p in parameters}
    given = arguments.table(given, "parameters", '{"m": 1}')
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
        if contradicts(replace(p, value=value)):
            raise InvalidInputError(f"parameters: {p.name} must be {p.required}, not {value}")
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
    if sum(given is not None for given in (velocity, p, constants)) != 1:
        raise InvalidInputError(
            "initial data: give either velocity={…} or p={…}, each a number for every coordinate, or constants={…}"
        )
    if signs is not None and constants is None:
        raise InvalidInputError("signs: they go with constants={…}; velocity={…} and p={…} have signs already")
    if constants is not None:
        values = read_places(system, q, parameters)
        return _from_constants(solution, values, constants, signs or {}, all_exact(q, constants, parameters))
    values = read_phase_point(system, q, velocity, p, parameters)
    constants = {name: clean(with_numbers(c.expression, values)) for name, c in solution.constants.items()}
    return Initial(values, constants, all_exact(q, velocity, p, parameters))


def read_places(system: System, q: Values, parameters: Values | None) -> dict[sp.Symbol, sp.Expr]:
    """Read parameters and places, inside the domains.

    Args:
        system: whose coordinates and parameters are meant.
        q: every coordinate → number.
        parameters: name → number, where it differs from the default.

    Raises:
        InvalidInputError: unknown names, or a place outside the domain.
        MissingValueError: a value is missing.
    """
    values = parameter_values(system, arguments.table(parameters, "parameters", '{"m": 1}'))
    places = complete_numbers(system.coordinates, q, "q")
    values |= {c.symbol: places[c.name] for c in system.coordinates}
    # |x| and the like are ±x: on which side of a kink the motion begins decides the formula
    values |= signs_at(system.kinks, values)
    _inside_domains(system, values)
    return values


def read_phase_point(
    system: System, q: Values, velocity: Values | None, p: Values | None, parameters: Values | None
) -> dict[sp.Symbol, sp.Expr]:
    """Read parameters, places and momenta, these from the velocities where p is None.

    Args:
        system: whose coordinates and parameters are meant.
        q, velocity, p: every coordinate → number.
        parameters: name → number, where it differs from the default.

    Raises:
        InvalidInputError: unknown names, or a place outside the domain.
        MissingValueError: a value is missing.
    """
    values = read_places(system, q, parameters)
    what, given = one_of_velocity_and_p(velocity, p)
    rates = complete_numbers(system.coordinates, given, what)
    if what == "p":
        return values | {c.momentum: rates[c.name] for c in system.coordinates}
    # p = ∂L/∂q̇, in exact numbers: constants of the motion inherit no rounding
    motion, formulas = {c.velocity: rates[c.name] for c in system.coordinates}, momenta(system)
    known = {**values, **motion}
    return values | {c.momentum: expanded(with_numbers(formulas[c.name], known)) for c in system.coordinates}


def _from_constants(
    solution: Solution, values: dict[sp.Symbol, sp.Expr], given: Values, signs: Values, exact: bool
) -> Initial:
    """Return momenta from the constants of the motion and the signs of the roots: p = ±√P²(q) − A."""
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
    return Initial(values, {name: clean(value) for name, value in constants.items()}, exact)


def _only_known(given: Values, names: Iterable[str], what: str) -> None:
    names = list(names)
    for name in arguments.table(given, what, f'{{"{next(iter(names), "")}": 1}}'):
        if name not in names:
            raise InvalidInputError(f"{what}: {name!r} is not known here; this solution has {_listed(names)}")
    missing = [name for name in names if name not in given]
    if missing and what == "constants":
        raise MissingValueError(f"constants: no value for {_listed(missing)}; all of {_listed(names)} are needed")


def _sign_given(name: str, value: object) -> sp.Integer:
    if not isinstance(value, int | float | sp.Number | Integral) or value not in (1, -1):
        raise InvalidInputError(f"signs[{name}]: 1 or -1 is needed, not {arguments.described(value)}")
    return sp.Integer(int(value))


def with_numbers(formula: sp.Expr, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Return a formula with numbers for its symbols.

    ``subs`` takes longer, and cares for what is 0/0 to ``xreplace``.

    Args:
        formula: of sympy.
        values: symbol → exact number.
    """
    # fractions alone are quick: sympy is asked where roots or functions occur
    rational = rational_value(formula, values)
    if rational is not None:
        return rational
    try:
        result = formula.xreplace(values)
    except (ZeroDivisionError, TypeError):
        return formula.subs(values)
    return formula.subs(values) if result.has(sp.nan, sp.zoo) else result


def clean(value: sp.Expr) -> sp.Expr:
    """Expand, and turn a number that is zero into 0.

    Raises:
        ForbiddenPlaceError: it is infinite.
    """
    value = expanded(value)
    if value.is_Rational:
        return value
    if value.has(sp.zoo, sp.nan, sp.oo):
        raise ForbiddenPlaceError(
            "initial data: a constant of the motion is infinite there; the place is a singularity of the coordinates"
        )
    return sp.Integer(0) if number_is_zero(value) else value


def one_of_velocity_and_p(velocity: Values | None, p: Values | None) -> tuple[str, Values]:
    """Return what was given of the two, and its name.

    Args:
        velocity, p: coordinate → number, or None.

    Raises:
        InvalidInputError: both or neither.
    """
    if velocity is not None and p is None:
        return "velocity", velocity
    if p is not None and velocity is None:
        return "p", p
    raise InvalidInputError("initial data: give either velocity={…} or p={…}, a number for every coordinate")


def complete_numbers(coordinates: Sequence[Coordinate], given: Values, what: str) -> dict[str, sp.Expr]:
    """Read one exact number for every coordinate, in their order.

    Args:
        coordinates: all that need one.
        given: name → number.
        what: the name of the argument.

    Raises:
        InvalidInputError: a name that is not a coordinate, or no number.
        MissingValueError: a coordinate without one.
    """
    names = [c.name for c in coordinates]
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
                # the end of a domain may be √(1 − a), which has no value for every a
                given = ", ".join(f"{symbol} = {values[symbol]}" for symbol in sorted(bound.free_symbols, key=str))
                raise InvalidInputError(
                    f"parameters: the domain of {c.name} {'begins' if side > 0 else 'ends'} at {bound}, which is not a "
                    f"real number for {given}; choose parameters for which it is"
                )
            if sign(side * (place - end)) <= 0:
                raise ForbiddenPlaceError(
                    f"q[{c.name}]: {place} is outside the domain, which {'begins' if side > 0 else 'ends'} at {bound}"
                )


def _real(value: sp.Expr) -> bool:
    """Return False for what is certainly no real number."""
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


def all_exact(*groups: Values | None) -> bool:
    """Tell whether no number given is a float.

    Args:
        groups: name → number each, or None.
    """
    return not any(isinstance(value, float) for group in groups if group for value in group.values())


def _listed(names: Iterable[str]) -> str:
    return ", ".join(str(name) for name in names) or "none"
