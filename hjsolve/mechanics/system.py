"""A mechanical system: T and V in generalized coordinates, checked once when it is made.

    L = T(q, q̇) − V(q),   T = ½ Σ m_ij(q) q̇_i q̇_j + Σ a_i(q) q̇_i + T₀(q)

Everything else here is a pure function of a system.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Literal

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve import arguments
from hjsolve.display.shown import Shown, as_argument, as_call, cut
from hjsolve.errors import InvalidSystemError, MissingValueError
from hjsolve.formulas.point_values import NoValueError, evaluate
from hjsolve.mechanics.canonical_functions import Y, energy, right_hand_side
from hjsolve.mechanics.closed_ends import check_closed_ends
from hjsolve.mechanics.coordinates_and_parameters import (
    Assumption,
    Coordinate,
    Parameter,
    clock_of,
    parameter,
    read_coordinates,
    read_functions,
    read_parameters,
    refuse_hidden,
    replaced,
    unknown_names,
    with_assumption,
)
from hjsolve.mechanics.domains import Domain
from hjsolve.mechanics.equations_of_motion import canonical_equations, routhian
from hjsolve.mechanics.kinetic_and_potential import Formulas, read_signature
from hjsolve.mechanics.kinetic_energy import (
    half_inverse_form,
    inverse_of_mass_matrix,
    mass_entries,
    velocity_coefficients,
)
from hjsolve.mechanics.kinks import Kink, with_signs, without_kinks
from hjsolve.mechanics.periodicity import check_periodic
from hjsolve.mechanics.place import Places, place_of, read_place
from hjsolve.mechanics.positive_definite import check_mass_matrix, end_values
from hjsolve.mechanics.quantities_given import in_units, without_quantities
from hjsolve.mechanics.relativity import Relativity, relativity_of
from hjsolve.mechanics.signs_of_letters import needed_signs
from hjsolve.mechanics.units import Units, check_units, names_and_units, read_units
from hjsolve.precision import one_at_a_time

__all__ = [
    "Coordinate", "Domain", "Parameter", "System", "hamiltonian", "inverse_mass_matrix", "kinetic_rest", "linear_terms",
    "mass_matrix", "momenta", "parameter", "require_values", "velocities", "with_values",
]  # fmt: skip


@dataclass(frozen=True, init=False, repr=False)
class System(Shown):
    """A mechanical system, checked when it is made; two systems are equal when all their parts are.

    Args:
        coordinates: name → domain: ``"line"``, ``"angle"`` or an inequality such as ``"0 < r"``, ``"-a < x < a"``.
        kinetic: T, as text or as a sympy expression in which a velocity is ``Derivative(q(t), t)`` or
            ``Symbol("dot(q)")``. A polynomial of second degree in the velocities; terms linear in them (a charge in a
            magnetic field, a moving frame) belong here.
        potential: V, of the coordinates (and the time t). ``abs(x)``, ``sign(x)``, sympy's ``Piecewise`` and roots of
            squares may depend on one coordinate by a polynomial: V then has kinks or jumps (``kinks``), and a letter
            sign_x stands for the sign in V and in all formulas of the solution.
        parameters: name → default value, ``None`` for no default, or a ``parameter(...)`` with assumption and unit;
            with ``units`` a quantity as well.
        signature: ``definite``: T must be positive definite on the domain; ``indefinite``: not degenerate (relativity).
        title: for display.
        id: of the catalog entry.
        relativity: ``{"mass": name, "light": name}``, the parameters that are rest mass and speed of light, for a
            relativistic particle; ``kinetic`` is then the classical T, whose metric it shares.
        functions: functions left undetermined in the texts of T and V, such as ``["v1(r)", "f(x, y)"]``; the solution
            is then one of formulas, numbers cannot be asked of it.
        place: where the coordinates are in space, for drawings and tables: ``{"x": "r*cos(phi)", "y": "r*sin(phi)"}``;
            known by itself of coordinates called x, y, z. T need not be that of this point. ``places`` is what was
            declared.
        units: in which units coordinates, the time and parameters are, ``{"r": "kpc", "t": "Myr", "m": "solMass"}``,
            so that quantities of pint or astropy can be given; those that follow from T and V need not be said.
            ``declared_units`` is what was declared.
        constraints: equations such as ``x**2 + y**2 = l**2`` or ``dot(x) - dot(y) = 0`` (linear in the velocities).
            Holonomic and integrable ones are eliminated, so that fewer coordinates are left; ``eliminated`` says how
            the others follow, and ``unconstrained`` is the system without them. One that is proved not to be
            integrable is refused by a ``NonholonomicError``, whose ``equations`` have multipliers.

    Raises:
        InvalidSystemError: the parts do not make a mechanical system; the message says which and why.
        ExpressionError: a formula, a bound or a value cannot be read.

    Example:
        >>> kinetic = "m/2*(dot(r)**2 + r**2*dot(theta)**2)"
        >>> kepler = System({"r": "0 < r", "theta": "angle"}, kinetic, "-k/r", {"m": 1, "k": 1})
        >>> kepler.canonical_equations["p_r"].rhs
        -k/r**2 + p_theta**2/(m*r**3)
    """

    coordinates: tuple[Coordinate, ...]
    parameters: tuple[Parameter, ...]
    kinetic: sp.Expr
    potential: sp.Expr
    signature: Literal["definite", "indefinite"]
    title: str
    id: str
    relativity: Relativity | None
    places: Places
    declared_units: Units
    kinks: tuple[Kink, ...]
    eliminated: tuple[tuple[str, sp.Expr], ...] = field(compare=False)
    time: sp.Symbol | None
    unconstrained: System | None = field(default=None, compare=False, repr=False)
    constraints: tuple[str, ...] = field(default=(), compare=False, repr=False)

    @arguments.with_known_names('System({"x": "line"}, kinetic="dot(x)**2/2", potential="x**2/2")')
    @one_at_a_time
    def __init__(
        self,
        coordinates: Mapping[str, str],
        kinetic: str | sp.Expr,
        potential: str | float | sp.Expr = 0,
        parameters: Mapping[str, object] | None = None,
        *,
        signature: str = "definite",
        title: str = "",
        id: str = "",  # noqa: A002 - the catalog's word
        relativity: Mapping[str, str] | None = None,
        functions: Iterable[str] = (),
        place: Mapping[str, object] | None = None,
        units: Mapping[str, object] | None = None,
        constraints: Iterable[str] = (),
    ):
        if constraints:
            # a call upward: proving what is integrable needs the zero test
            from hjsolve.coordinates.constraints import without_constraints

            free = System(
                coordinates, kinetic, potential, parameters, signature=signature, title=title, id=id,
                relativity=relativity, functions=functions, place=place, units=units,
            )  # fmt: skip
            _set(self, **vars(without_constraints(free, constraints)) | {"id": str(id)})
            return
        for name, text in (("title", title), ("id", id)):
            refuse_hidden(text, name)
        numbers, quantities = without_quantities({} if parameters is None else parameters)
        constants = read_parameters(numbers)
        places = read_coordinates(coordinates, constants)
        clock = clock_of((kinetic, potential), {p.name for p in constants} | {c.name for c in places})
        constants = (*constants, *clock)
        _set(self, coordinates=places, parameters=constants, title=str(title), id=str(id), eliminated=())
        _set(self, signature=read_signature(signature))
        unknowns = read_functions(functions, (c.name for c in places), self.symbols)
        _set(self, kinetic=Formulas(places, self.symbols, unknowns).kinetic(kinetic))
        if signs := _needed_signs(self):
            constants = tuple(with_assumption(p, signs.get(p.name, p.assume)) for p in constants)
            places = read_coordinates(coordinates, constants)
            _set(self, coordinates=places, parameters=constants)
            _set(self, kinetic=Formulas(places, self.symbols, unknowns).kinetic(kinetic))
        formulas = Formulas(places, self.symbols, unknowns)
        _set(self, time=next((p.symbol for p in constants if p.name == "t"), None))
        _set(self, relativity=relativity_of(relativity, constants))
        smooth, kinks = without_kinks(formulas.potential(potential), places, [*self.symbols, *unknowns])
        _set(self, potential=smooth, kinks=kinks)
        _set(self, declared_units=read_units(units, places, constants), places=())
        if units or quantities:
            check_units(self)
            _set(self, parameters=tuple(replaced(constants, in_units(self, quantities, "parameters"))))
        check_closed_ends(mass_matrix(self), places)
        check_values(self, self.parameters)
        _set(self, places=read_place(place, self.symbols, places, self.parameters))
        if self.relativity is not None and kinetic_rest(self) != 0:
            raise InvalidSystemError("relativity: the classical T may have no part without velocities; put it into V")

    @property
    def symbols(self) -> dict[str, sp.Symbol]:
        """Symbols of coordinates and parameters by name."""
        return {c.name: c.symbol for c in self.coordinates} | {p.name: p.symbol for p in self.parameters}

    @property
    def defaults(self) -> dict[sp.Symbol, sp.Expr]:
        """Exact default values by symbol, of the parameters that have one."""
        return {p.symbol: p.value for p in self.parameters if p.value is not None}

    @property
    def place(self) -> dict[str, sp.Expr]:
        """Where the system is in space: x, y, z → function of the coordinates; empty where nothing is known of it."""
        return place_of(self.coordinates, self.places)

    @property
    def units(self) -> dict[str, str]:
        """The units of coordinates, time and parameters, those that follow included; empty where none is declared."""
        return names_and_units(self)

    @property
    def functions(self) -> tuple[str, ...]:
        """The functions left undetermined in T and V, such as ``v1(r)``."""
        return tuple(sorted({str(f) for e in (self.kinetic, self.potential) for f in e.atoms(AppliedUndef)}))

    @property
    def canonical_equations(self) -> dict[str, sp.Eq]:
        """Hamilton's equations by the names of q and p: dot(q) = ∂H/∂p (4-16), dot(p_q) = −∂H/∂q (4-17)."""
        return canonical_equations(self.coordinates, hamiltonian(self))

    @property
    def routhian(self) -> sp.Expr:
        """R = L − Σ p_i dot(q_i) over the coordinates that T and V do not hold, their velocities eliminated (2-122).

        Raises:
            InvalidSystemError: a relativistic particle, or ignorable velocities that do not follow from their momenta.
        """
        if self.relativity is not None:
            raise InvalidSystemError(
                "routhian: the Lagrangian of a relativistic particle is not T - V; use hamiltonian"
            )
        held = self.kinetic.free_symbols | self.potential.free_symbols
        rest = kinetic_rest(self) - self.potential
        return routhian(self.coordinates, mass_matrix(self), linear_terms(self), rest, held)

    def coordinate(self, name: str) -> Coordinate:
        """Return the coordinate of this name.

        Args:
            name: as declared.

        Raises:
            InvalidSystemError: the system has no coordinate of this name; the message lists those it has.
        """
        arguments.refuse_other(name, str, "coordinate", f'a name such as "{self.coordinates[0].name}" is needed')
        for coordinate in self.coordinates:
            if coordinate.name == name:
                return coordinate
        raise unknown_names(name, (c.name for c in self.coordinates), "coordinate")

    def rhs(self, parameters: Mapping[str, object] | None = None, *, module: str = "numpy") -> Callable[[object, Y], Y]:
        """Return Hamilton's equations as a function f(t, y) for integrators, y = [q…, p…] as of ``State.as_array``.

        Args:
            parameters: name → value, where other than the default or where there is none.
            module: ``numpy`` for doubles, ``mpmath`` for many digits.

        Returns:
            A function of t and of y: an array of shape (2n,) or, for many states at once, (2n, m); or a list of 2n
            numbers. It returns dy/dt in the same form.

        Raises:
            MissingValueError: a parameter has no value.
            InvalidSystemError: a name is not a parameter, or a value contradicts what was declared.
            InvalidInputError: another module, or a function that is left undetermined.

        Example:
            >>> System({"x": "line"}, "m/2*dot(x)**2", "k/2*x**2", {"m": 2, "k": 3}).rhs()(0.0, [1.0, 4.0])
            [2.0, -3.0]
        """
        valued = with_values(self, parameters or {})
        return right_hand_side(valued.coordinates, _in_numbers(valued), _signs(valued), module)

    def hamiltonian_function(
        self, parameters: Mapping[str, object] | None = None, *, module: str = "numpy"
    ) -> Callable[[Any], Any]:
        """Return the Hamiltonian as a function H(y), y as of ``rhs``; for y of shape (2n, m) an array of shape (m,).

        Args:
            parameters, module: as of ``rhs``.

        Raises:
            MissingValueError, InvalidSystemError, InvalidInputError: as of ``rhs``.
        """
        valued = with_values(self, parameters or {})
        return energy(valued.coordinates, _in_numbers(valued), _signs(valued), module)

    def __repr__(self) -> str:
        """Return the call that makes the system, as far as it differs from the defaults."""
        places = {c.name: c.domain.written(c.name) for c in self.coordinates}
        own = [p for p in self.parameters if p.symbol != self.time]
        values = {p.name: None if p.value is None else as_argument(p.value) for p in own}
        parts: dict[str, object] = {"coordinates": places, "kinetic": str(self.kinetic)}
        parts |= {"potential": str(with_signs(self.potential, self.kinks)), "parameters": values}
        if self.relativity is not None:
            parts["relativity"] = {"mass": str(self.relativity.mass), "light": str(self.relativity.light)}
        if self.functions:
            parts["functions"] = list(self.functions)
        if self.signature != "definite":
            parts["signature"] = self.signature
        if self.places:
            parts["place"] = {axis: str(formula) for axis, formula in self.places}
        if self.declared_units:
            parts["units"] = dict(self.declared_units)
        parts |= {key: getattr(self, key) for key in ("title", "id") if getattr(self, key)}
        return as_call("System", parts)

    def _label(self) -> str:
        return self.id or cut(f"T = {self.kinetic}, V = {with_signs(self.potential, self.kinks)}", 60)


def _signs(system: System) -> dict[sp.Symbol, sp.Expr]:
    """Return what the letters for signs stand for, in numbers."""
    return {kink.symbol: kink.sign.xreplace(system.defaults) for kink in system.kinks}


def _set(system: System, **fields: object) -> None:
    for name, value in fields.items():
        object.__setattr__(system, name, value)


def _needed_signs(system: System) -> Mapping[str, Assumption]:
    """Return the signs of letters without which T is not positive definite, or a domain is empty."""
    masses = mass_matrix(system).diagonal() if system.signature == "definite" else ()
    return needed_signs(tuple(masses), system.coordinates, system.parameters)


def check_values(system: System, parameters: Sequence[Parameter], *, refuse_ends: bool = True) -> None:
    """Check that with the values of parameters no domain is empty, T is definite, and T and V are periodic in angles.

    Args:
        system: whose T and V are looked at.
        parameters: those whose values are put in.
        refuse_ends: whether ends of domains that are not real are refused here, or left to who needs their numbers.

    Raises:
        InvalidSystemError: which is not so, and where.
    """
    values = {p.symbol: p.value for p in parameters if p.value is not None}
    if any(c.domain.kind == "angle" for c in system.coordinates):
        parts = (("kinetic", system.kinetic), ("potential", system.potential))
        check_periodic(parts, system.coordinates, parameters)
    for c in system.coordinates:
        ends = [end for end in (c.domain.lower, c.domain.upper) if end is not None]
        known = all(end.free_symbols <= values.keys() for end in ends)
        if known and not _has_ends(c, values, refuse=refuse_ends):
            return
    check_mass_matrix(mass_matrix(system), system.coordinates, parameters, system.signature)


def _has_ends(coordinate: Coordinate, values: Mapping[sp.Symbol, sp.Expr], *, refuse: bool) -> bool:
    """Return whether the ends are real, the lower one below the upper; refuse what is not."""
    written = f'domain of {coordinate.name}: "{coordinate.domain.written(coordinate.name)}"'
    try:
        lower, upper = end_values(coordinate.domain, {symbol: evaluate(v, {}) for symbol, v in values.items()})
    except NoValueError:
        if not refuse:
            return False
        raise InvalidSystemError(f"{written}: an end is not a finite real number with the values given") from None
    if lower is not None and upper is not None and lower >= upper:
        raise InvalidSystemError(f"{written} is empty with the values given; the lower end must be below the upper")
    return True


def placed(system: System, places: Places) -> System:
    """Return the same system with another place in space, taken as it is.

    Args:
        system: a system.
        places: axis and formula.
    """
    other = object.__new__(System)
    _set(other, **{**vars(system), "places": places})
    return other


def with_values(system: System, values: Mapping[str, object]) -> System:
    """Return the same system with other default values.

    Args:
        system: a system.
        values: parameter name → number, as in ``System``; None takes the default away.

    Raises:
        InvalidSystemError: a name is not a parameter, a value contradicts an assumption, or T is not positive definite.
        ExpressionError: a value is not a number.
    """
    if not values:
        return system
    names = [p.name for p in system.parameters]
    for name in values:
        if name not in names:
            raise unknown_names(name, names, "parameter")
    other, changed = object.__new__(System), replaced(system.parameters, in_units(system, values, "parameters"))
    _set(other, **{**vars(system), "parameters": tuple(changed)})
    check_values(other, other.parameters)
    return other


def require_values(system: System) -> dict[sp.Symbol, sp.Expr]:
    """Return the values of all parameters, by symbol.

    Args:
        system: whose parameters are meant.

    Raises:
        MissingValueError: some have none; the message lists them.
    """
    missing = [p.name for p in system.parameters if p.value is None]
    if missing:
        example = ", ".join(f'"{name}": …' for name in missing)
        raise MissingValueError(f"no value for {', '.join(missing)}; give parameters={{{example}}}")
    return {p.symbol: p.value for p in system.parameters if p.value is not None}


def _speeds(system: System) -> list[sp.Symbol]:
    return [c.velocity for c in system.coordinates]


def mass_matrix(system: System) -> sp.ImmutableMatrix:
    """m_ij(q) = ∂²T/∂q̇_i∂q̇_j, shape (n, n)."""
    return mass_entries(system.kinetic, _speeds(system))


def linear_terms(system: System) -> tuple[sp.Expr, ...]:
    """a_i(q) of T₁ = Σ a_i q̇_i, one for each coordinate."""
    found = velocity_coefficients(system.kinetic, _speeds(system))
    return tuple(found.get((i,), sp.S.Zero) for i in range(len(system.coordinates)))


def kinetic_rest(system: System) -> sp.Expr:
    """T₀(q), the part of T without velocities."""
    speeds = _speeds(system)
    rest = dict.fromkeys(speeds, sp.S.Zero)

    def moves(term: sp.Expr) -> bool:
        """Return whether a velocity is a factor; 0·x is not left to sympy, which asks first whether x is finite."""
        return any(factor.as_base_exp()[0] in rest for factor in sp.Mul.make_args(term))

    return sp.Add(*(term.xreplace(rest) for term in sp.Add.make_args(system.kinetic) if not moves(term)))


def inverse_mass_matrix(system: System) -> sp.ImmutableMatrix:
    """Return the inverse of the mass matrix, shape (n, n)."""
    return inverse_of_mass_matrix(mass_matrix(system))


def _in_numbers(system: System) -> sp.Expr:
    """H with the values of the parameters."""
    return hamiltonian(system).xreplace(require_values(system))


def _shifted(system: System) -> list[sp.Expr]:
    """p_i − a_i, the part of the momentum that moves."""
    return [c.momentum - a for c, a in zip(system.coordinates, linear_terms(system))]


def hamiltonian(system: System) -> sp.Expr:
    """H(q, p) = ½ (p − a)ᵀ M⁻¹ (p − a) − T₀ + V, Greenwood (4-109)–(4-112); the first term as a sum of squares.

    For a relativistic particle c √(m₀²c² + m₀ (p − a)ᵀ M⁻¹ (p − a)) + V, (7-165), (7-170).

    Args:
        system: T and V as declared.
    """
    kinetic = half_inverse_form(mass_matrix(system), _shifted(system))
    if system.relativity is not None:
        return system.relativity.energy(2 * kinetic) + system.potential
    return kinetic - kinetic_rest(system) + system.potential


def momenta(system: System) -> dict[str, sp.Expr]:
    """p_i = ∂T/∂q̇_i by name of the coordinate, in coordinates and velocities; relativistic a + γ M q̇.

    Args:
        system: T and V as declared.
    """
    if system.relativity is None:
        return {c.name: _slope(system.kinetic, c.velocity) for c in system.coordinates}
    speeds = sp.Matrix(_speeds(system))
    classical = mass_matrix(system) * speeds
    square = (speeds.T * classical)[0, 0]
    found = system.relativity.momenta(linear_terms(system), list(classical), square)
    return {c.name: p for c, p in zip(system.coordinates, found)}


@lru_cache(maxsize=256)
def _slope(kinetic: sp.Expr, velocity: sp.Symbol) -> sp.Expr:
    return sp.diff(kinetic, velocity)


def velocities(system: System) -> dict[str, sp.Expr]:
    """q̇ = M⁻¹ (p − a) by name of the coordinate, in coordinates and momenta; relativistic c m₀ M⁻¹ (p − a)/√(…)."""
    return dict(zip([c.name for c in system.coordinates], _rates(system)))


@lru_cache(maxsize=256)
def _rates(system: System) -> tuple[sp.Expr, ...]:
    shifted = _shifted(system)
    speeds = list(inverse_mass_matrix(system) * sp.Matrix(shifted))
    if system.relativity is not None:
        square = 2 * half_inverse_form(mass_matrix(system), shifted)
        speeds = system.relativity.speeds(speeds, square)
    return tuple(speeds)
