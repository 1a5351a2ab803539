"""``find_coordinates``: all orthogonal separable coordinates of a natural system in plane, space or on a sphere."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.algebra.time_limit import SearchTimeError, seconds_left, within_seconds
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap, curvilinear_map
from hjsolve.coordinates.charts.named_constants import Values, restored, with_named_constants
from hjsolve.coordinates.charts.transform import Cartesian, web_of
from hjsolve.coordinates.curved.embedding import sphere_of
from hjsolve.coordinates.curved.sphere import OnSphere, on_sphere, sphere_kernel, webs_on_sphere
from hjsolve.coordinates.killing.killing_tensors import (
    Kernel,
    concircular_basis,
    dimension_by_numbers,
    kernel,
    killing_basis,
    killing_tensor,
)
from hjsolve.coordinates.killing.special_parameters import exceptional_values
from hjsolve.coordinates.results import Geometry, ParameterValues, SeparableCoordinates, Web
from hjsolve.coordinates.webs.concircular_families import family
from hjsolve.coordinates.webs.orthonormal_frames import Sign, tidy_constant
from hjsolve.coordinates.webs.plane import plane_webs
from hjsolve.coordinates.webs.space import Potential, space_webs
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.precision import one_at_a_time

_NONE = "The energy is the only first integral quadratic in the velocities, so the system is"
_NO_WEB = "Besides the energy there {are} {extra} quadratic first integral{s}, but no orthogonal web belongs to {it}: "
_NOT = (
    "not separable by a point transformation in orthogonal coordinates. It may still be integrable, with integrals of "
    "higher degree (Toda, Kaup–Kupershmidt)."
)
_UNRESOLVED = (
    "A further web or family is not written out: its axes are roots of an irreducible cubic, or its equations are too "
    "many. Turn the coordinates to its axes, or give the parameters numbers; for quadratic T and V use normal_modes."
)
_INCOMPLETE = (
    "The exact elimination and the numerical count of the integrals differ: radicals in V depend on each other, "
    "and there may be more coordinates than those listed."
)
_MOST_LINES = 6
_MOST_LETTERS = 2
"""Of irrational constants in space: with three the elimination takes minutes."""
_PARTIAL = ("split", "sphere", "unresolved")


@arguments.with_known_names("find_coordinates(system, budget=20)")
@one_at_a_time
def find_coordinates(
    system: System | str | Path, *, special: bool = True, budget: float = 20.0
) -> SeparableCoordinates:
    """Find every orthogonal coordinate system in which a natural system of the plane, space or a sphere separates.

    The system is given in Cartesian coordinates: T = ½ Σ m_i ẋ_i² with constant masses (a constant symmetric mass
    matrix is brought to this form), V(x) analytic; or in polar, cylindrical or spherical ones, recognised by T.
    Solves d(K·dV) = 0 exactly for the constants of the Killing
    tensors K (6 in the plane, 20 in space), sorts the solutions that are concircular tensors into the 4 or 11 webs
    (Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117), transforms the system and lets ``separate`` certify it.
    Two coordinates whose T has constant positive curvature are on a sphere: its webs are found (``curved``).

    Args:
        system: the system, or the id or file of a catalog entry; its parameters stay symbolic and count as generic.
        special: also look for parameter values at which there are more coordinates.
        budget: seconds that the whole search may take, to about one. What was not decided in them is said in
            ``undecided`` and ``advice``.

    Returns:
        The coordinates. Where the webs form a family (the elliptic coordinates of the Kepler problem have one
        focus at will), a representative is given and the family described.

    Raises:
        InvalidSystemError: the system is not natural, not in Cartesian, polar, cylindrical or spherical coordinates, or
            not in two or three dimensions.
        InvalidInputError: no system at all, or a negative budget.

    Example:
        >>> from hjsolve import System
        >>> V = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 2/sqrt((x - 3)**2 + (y + 1)**2)"
        >>> found = find_coordinates(System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", V))
        >>> [(web.kind, web.centre, web.lengths["a"], web.certified) for web in found.webs]
        [('elliptic', (2, 1/2), sqrt(13)/2, True)]
    """
    system = system_of(system, "find_coordinates")
    refuse_kinks(system.kinks, "find_coordinates")
    budget = arguments.seconds(budget, "budget")
    with within_seconds(budget):
        curved = curvilinear_map(system)
        if curved is None:
            return _Search(system, special=special, budget=budget).result()
        found = _Search(curved.space, special=special, budget=budget).result()
        return _expressed_in(curved, system, found)


def _expressed_in(curved: CurvilinearMap, system: System, found: SeparableCoordinates) -> SeparableCoordinates:
    """Express webs found in x, y, z in the coordinates that the system was given in."""
    axes, names = [c.name for c in curved.space.coordinates], [c.name for c in system.coordinates]

    def expressed(web: Web) -> Web:
        formulas = curved.in_given_coordinates([web.transformation[axis] for axis in axes])
        return replace(web, transformation=dict(zip(names, formulas, strict=True)))

    place = ", ".join(f"{axis} = {e}" for axis, e in zip(axes, curved.place, strict=True))
    advice = f"{found.advice}\nCentres, axes and foci are those of {place}."
    return replace(found, system=system, webs=tuple(map(expressed, found.webs)), advice=advice)


class _Search:
    """What is found of a system, stage by stage; where the time runs out, what was found before is the result."""

    def __init__(self, system: System, *, special: bool, budget: float):
        self.start, self.system, self.special, self.budget = time.monotonic(), system, special, budget
        self.full: Kernel | None = None
        self.reduced: Kernel | None = None
        self.basis: tuple[sp.ImmutableMatrix, ...] = ()
        self.found: Found = [], []
        self.values: tuple[ParameterValues, ...] = ()
        self.stage = "whether it separates in others"

    def result(self) -> SeparableCoordinates:
        """Return the coordinates, or what is known of them at the end of the budget."""
        undecided = ""
        try:
            sphere = sphere_below(self.system)
            cartesian = cartesian_form(self.system) if sphere is None else sphere.space
            self._look(cartesian, sphere)
            self._look_at_special_values(cartesian)
            if any(not web.certified for web in self.found[1]) and seconds_left(1.0) == 0.0:
                raise SearchTimeError
        except SearchTimeError:
            undecided = f"Not decided in {self.budget:g} s: {self.stage}."
        full, reduced = self.full or _NOTHING, self.reduced or _NOTHING
        geometries, webs = self.found
        words = [_advice(full, geometries, webs, self.values)] if self.reduced else []
        return SeparableCoordinates(
            self.system, full.dimension, reduced.dimension, _combined(full, self.basis) if self.full else (),
            tuple(webs), self.values, not undecided and full.complete and reduced.complete,
            "\n".join([*words, *([undecided] if undecided else [])]), time.monotonic() - self.start, undecided,
        )  # fmt: skip

    def _look(self, cartesian: Cartesian, sphere: OnSphere | None) -> None:
        if sphere is not None:
            self.full, self.basis = sphere_kernel(sphere)
            self.reduced, self.stage = self.full, "which webs there are"
            geometries, webs = webs_on_sphere(sphere, budget=self.budget)
            self.found = [g for g in geometries if g.kind != "sphere"], list(webs)
            return
        full, reduced = _kernels(cartesian)
        self.full, self.reduced, self.basis = full, reduced, killing_basis(cartesian.X)
        self.stage = "which webs there are"
        _webs(reduced, cartesian, self.budget, self.found)

    def _look_at_special_values(self, cartesian: Cartesian) -> None:
        if not self.special or self.full is None or not self.full.pivots:
            return
        self.stage = "at which values of the parameters there are more"
        found, all_tried = exceptional_values(cartesian.potential, cartesian.X, self.basis, self.full)
        self.values = tuple(ParameterValues({s.name: e for s, e in one.conditions}, one.dimension) for one in found)
        if not all_tried:
            raise SearchTimeError


def sphere_below(system: System) -> OnSphere | None:
    """Return the sphere that a natural system of two coordinates moves on; None where it does on none.

    Raises:
        InvalidSystemError: the curvature is constant and negative, or the coordinates or V are not read here.
    """
    if len(system.coordinates) != 2 or any(linear_terms(system)) or kinetic_rest(system) != 0:
        return None
    sphere = sphere_of(system, Sign(_sign_values(system)))
    return None if sphere is None else on_sphere(sphere, _sign_values(system))


def _kernels(cartesian: Cartesian) -> tuple[Kernel, Kernel]:
    """Return the kernels of all Killing tensors and of those that come from concircular tensors.

    In the plane, and next to parameters, irrational constants are letters first: a kernel as large as numbers allow at
    the constants is theirs.
    """
    n, basis = len(cartesian.X), killing_basis(cartesian.X)
    lettered, values = with_named_constants(cartesian)
    if values and (n == 2 or cartesian.system.parameters):
        generic = kernel(lettered.potential, cartesian.X, basis, check=False)
        if generic.dimension == dimension_by_numbers(cartesian.potential, cartesian.X, basis):
            pair = [_at(k, values) for k in (generic, _concircular_kernel(lettered, check=False))]
            if pair[0] is not None and pair[1] is not None:
                return pair[0], pair[1]
    full = kernel(cartesian.potential, cartesian.X, basis)
    return full, _concircular_kernel(cartesian, check=n == 3)


def _at(generic: Kernel, values: Values) -> Kernel | None:
    """Return a kernel at the constants that its letters stand for; None where a denominator vanishes there."""
    vectors = tuple(tuple(tidy_constant(c.xreplace(dict(values))) for c in v) for v in generic.vectors)
    if any(c.has(sp.zoo, sp.nan, sp.oo) for v in vectors for c in v):
        return None
    return Kernel(vectors, True, ())


def _concircular_kernel(cartesian: Cartesian, *, check: bool) -> Kernel:
    basis = tuple(killing_tensor(M, cartesian.X) for M in concircular_basis(len(cartesian.X)))
    return kernel(cartesian.potential, cartesian.X, basis, check=check)


Found = tuple[list[Geometry], list[Web]]
_NOTHING = Kernel((), True, ())


def _webs(reduced: Kernel, cartesian: Cartesian, budget: float, into: Found) -> None:
    """Add the geometries and the webs to what was found.

    Irrational constants are letters in the plane, where this is quick, and in space where their own arithmetic does
    not lead to the end.
    """
    lettered, values = with_named_constants(cartesian)
    own = partial(_with_constants, reduced, cartesian, budget)
    if not values or reduced.dimension == 1:
        return own(into)
    letters = partial(_with_letters, reduced, cartesian, lettered, values, budget)
    if len(cartesian.X) == 2:
        return None if letters(into) else own(into)
    own(into)
    if len(values) > _MOST_LETTERS or _is_resolved(into):
        return None
    again: Found = [], []
    if letters(again):
        into[0][:], into[1][:] = again
    return None


def _is_resolved(found: Found) -> bool:
    return all(web.certified for web in found[1]) and not any(g.kind == "unresolved" for g in found[0])


def _with_constants(reduced: Kernel, cartesian: Cartesian, budget: float | None, into: Found) -> None:
    """Find the webs with the constants as they are; sympy may have no normal form of them, or no end."""
    try:
        into[0].extend(_geometries(reduced, cartesian))
        for g in into[0]:
            if g.kind not in _PARTIAL:
                into[1].append(web_of(g, cartesian, budget=budget))
    except (sp.PolynomialError, NotImplementedError, OverflowError):
        into[0][:], into[1][:] = [Geometry("unresolved", (), ())], []


def _with_letters(
    reduced: Kernel, cartesian: Cartesian, lettered: Cartesian, values: Values, budget: float, into: Found
) -> bool:
    """Find the webs with a letter for each constant; False where the constants have more webs than the letters."""
    generic = _concircular_kernel(lettered, check=False)
    if generic.dimension != reduced.dimension:
        return False
    found: Found = [], []
    _with_constants(generic, lettered, None, found)
    into[0].extend(found[0])
    into[1].extend(restored(web, values, cartesian, budget=budget) for web in found[1])
    return True


def _combined(full: Kernel, basis: Sequence[sp.ImmutableMatrix]) -> tuple[sp.ImmutableMatrix, ...]:
    zero = sp.zeros(*basis[0].shape)
    return tuple(sp.ImmutableMatrix(sum((c * K for c, K in zip(v, basis, strict=True)), zero)) for v in full.vectors)


def _geometries(reduced: Kernel, cartesian: Cartesian) -> list[Geometry]:
    """Return the webs, and in space also what splits off without leading to one."""
    sign = Sign(cartesian.values)
    n = len(cartesian.X)
    tensors = family(reduced.vectors, n)
    if n == 2:
        return plane_webs(tensors, sign)
    return space_webs(tensors, Potential(cartesian.potential, cartesian.X, sign))


def _advice(
    full: Kernel, geometries: Sequence[Geometry], webs: Sequence[Web], values: Sequence[ParameterValues]
) -> str:
    """Put the result in words."""
    parts = [g for g in geometries if g.kind in _PARTIAL]
    if webs:
        lines = [f"Separates in {len(webs)} orthogonal coordinate system{'s' * (len(webs) > 1)}:"]
        lines += [f"- {web}" + ("" if web.certified else " (not certified)") for web in webs]
    elif any(part.kind == "unresolved" for part in parts):
        lines = []
    elif full.dimension == 1:
        lines = [f"{_NONE} {_NOT}"]
    else:
        one = full.dimension == 2
        words = {
            "are": "is" if one else "are",
            "extra": full.dimension - 1,
            "s": "" if one else "s",
            "it": "it" if one else "them",
        }
        lines = [_NO_WEB.format(**words) + "the system is " + _NOT]
    for part in parts:
        if part.kind == "unresolved":
            lines += [] if _UNRESOLVED in lines else [_UNRESOLVED]
        else:
            what = "splits off the direction" if part.kind == "split" else "splits off the distance from"
            where = ", ".join(map(str, part.axes[2] if part.kind == "split" else part.centre))
            lines.append(f"V {what} ({where}), but what is left does not separate.")
    for value in values[:_MOST_LINES]:
        where = ", ".join(f"{name} = {e}" for name, e in value.conditions.items())
        lines.append(f"At {where} there are more quadratic integrals: {value.kernel_dimension} with the energy.")
    if len(values) > _MOST_LINES:
        lines.append(f"{len(values) - _MOST_LINES} more such values of the parameters are in ``special``.")
    return "\n".join(lines if full.complete else [*lines, _INCOMPLETE])


def cartesian_form(system: System) -> Cartesian:
    """Read a system as a particle of one mass in the plane or in space; scale the coordinates where masses differ.

    Args:
        system: natural, in Cartesian coordinates.

    Raises:
        InvalidSystemError: it is not.
    """
    n = len(system.coordinates)
    if n not in (2, 3):
        raise InvalidSystemError(f"find_coordinates: {n} coordinates; the plane (2) and space (3) are supported")
    for q in system.coordinates:
        if q.domain.kind == "angle":
            raise InvalidSystemError(
                f"find_coordinates: {q.name} is an angle; Cartesian coordinates are needed, "
                "write T and V in x, y (z) on the line"
            )
    x = tuple(q.symbol for q in system.coordinates)
    M = mass_matrix(system)
    if any(a != 0 for a in linear_terms(system)) or kinetic_rest(system) != 0:
        raise InvalidSystemError(
            "find_coordinates: T has terms that are not quadratic in the velocities (a magnetic "
            "field or a rotating frame); only natural systems T = ½ Σ m ẋ² are supported"
        )
    if M.free_symbols & set(x):
        raise InvalidSystemError(
            "find_coordinates: T depends on the coordinates; write the system in Cartesian "
            "coordinates, T = m/2 (dot(x)**2 + dot(y)**2)"
        )
    mass = M[0, 0]
    values = _sign_values(system)
    if all(sp.simplify(M[i, j] - mass * int(i == j)) == 0 for i in range(n) for j in range(n)):
        return Cartesian(system, mass, x, sp.ImmutableMatrix(sp.eye(n)), x, system.potential, values)
    X = tuple(sp.Symbol(f"{q.name}_scaled", real=True) for q in system.coordinates)
    stretch = _stretch(M, mass)
    V = system.potential.subs(dict(zip(x, stretch * sp.Matrix(X), strict=True)), simultaneous=True)
    return Cartesian(system, mass, x, stretch, X, V, values)


def _stretch(M: sp.ImmutableMatrix, mass: sp.Expr) -> sp.ImmutableMatrix:
    """Return S with Sᵀ M S = mass·1, upper triangular, from M = L D Lᵀ: S = L⁻ᵀ √(mass/D)."""
    lower, diagonal = sp.Matrix(M).LDLdecomposition(hermitian=False)
    n = M.rows
    scales = sp.diag(*(tidy_constant(sp.sqrt(sp.factor(mass / diagonal[i, i]))) for i in range(n)))
    return sp.ImmutableMatrix((lower.T.inv() * scales).applyfunc(sp.simplify))


def _sign_values(system: System) -> dict[sp.Symbol, sp.Expr]:
    """Return a value for every parameter: its default, else a prime number."""
    values: dict[sp.Symbol, sp.Expr] = {}
    for index, p in enumerate(system.parameters):
        values[p.symbol] = (
            p.value if p.value is not None else sp.Integer(sp.prime(index + 1) * (-1 if p.assume == "negative" else 1))
        )
    return values
