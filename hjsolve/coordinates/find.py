"""``find_coordinates``: all orthogonal separable coordinates of a natural system in plane, space or on a sphere."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import sympy as sp

from hjsolve import arguments
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
from hjsolve.coordinates.webs.orthonormal_frames import sign_by, tidy_constant
from hjsolve.coordinates.webs.plane import plane_webs
from hjsolve.coordinates.webs.space import Potential, space_webs
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix

_NONE = "No quadratic first integral of this kind besides the energy: the system is"
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


def find_coordinates(
    system: System | str | Path, *, special: bool = True, budget: float = 20.0
) -> SeparableCoordinates:
    """Find every orthogonal coordinate system in which a natural system of the plane, space or a sphere separates.

    The system must be given in Cartesian coordinates: T = ½ Σ m_i ẋ_i² with constant masses (a constant symmetric
    mass matrix is brought to this form), V(x) analytic. Solves d(K·dV) = 0 exactly for the constants of the Killing
    tensors K (6 in the plane, 20 in space), sorts the solutions that are concircular tensors into the 4 or 11 webs
    (Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117), transforms the system and lets ``separate`` certify it.
    Two coordinates whose T has constant positive curvature are on a sphere: its webs are found (``curved``).

    Args:
        system: the system, or the id or file of a catalog entry; its parameters stay symbolic and count as generic.
        special: also look for parameter values at which there are more coordinates.
        budget: seconds that ``separate`` may take for one web.

    Returns:
        The coordinates. Where the webs form a family (the elliptic coordinates of the Kepler problem have one
        focus at will), a representative is given and the family described.

    Raises:
        InvalidSystemError: the system is not natural, not in Cartesian coordinates, or not in two or three dimensions.
        InvalidInputError: no system at all, or a negative budget.

    Example:
        >>> from hjsolve import System
        >>> V = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 2/sqrt((x - 3)**2 + (y + 1)**2)"
        >>> found = find_coordinates(System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", V))
        >>> [(web.kind, web.centre, web.lengths["a"], web.certified) for web in found.webs]
        [('elliptic', (2, 1/2), sqrt(13)/2, True)]
    """
    system = system_of(system, "find_coordinates")
    start, budget = time.monotonic(), arguments.seconds(budget, "budget")
    sphere = sphere_below(system)
    if sphere is not None:
        return _on_sphere(sphere, start, special=special, budget=budget)
    cartesian = cartesian_form(system)
    full, reduced = _kernels(cartesian)
    geometries, webs = _webs(reduced, cartesian, budget)
    values: tuple[ParameterValues, ...] = ()
    if special and full.pivots:
        values = _special_values(cartesian, killing_basis(cartesian.X), full)
    return SeparableCoordinates(
        system,
        full.dimension,
        reduced.dimension,
        _combined(full, killing_basis(cartesian.X)),
        webs,
        values,
        full.complete and reduced.complete,
        _advice(full, geometries, webs, values),
        time.monotonic() - start,
    )


def sphere_below(system: System) -> OnSphere | None:
    """Return the sphere that a natural system of two coordinates moves on; None where it does on none.

    Args:
        system: any.

    Raises:
        InvalidSystemError: the curvature is constant and negative, or the coordinates or V are not read here.
    """
    if len(system.coordinates) != 2 or any(linear_terms(system)) or kinetic_rest(system) != 0:
        return None
    sphere = sphere_of(system, sign_by(_sign_values(system)))
    return None if sphere is None else on_sphere(sphere, _sign_values(system))


def _on_sphere(given: OnSphere, start: float, *, special: bool, budget: float) -> SeparableCoordinates:
    full, basis = sphere_kernel(given)
    geometries, webs = webs_on_sphere(given, budget=budget)
    values = _special_values(given.space, basis, full) if special and full.pivots else ()
    return SeparableCoordinates(
        given.sphere.system,
        full.dimension,
        full.dimension,
        _combined(full, basis),
        webs,
        values,
        full.complete,
        _advice(full, [g for g in geometries if g.kind != "sphere"], webs, values),
        time.monotonic() - start,
    )


def _special_values(
    cartesian: Cartesian, basis: Sequence[sp.ImmutableMatrix], full: Kernel
) -> tuple[ParameterValues, ...]:
    found = exceptional_values(cartesian.potential, cartesian.X, basis, full)
    return tuple(ParameterValues({s.name: e for s, e in one.conditions}, one.dimension) for one in found)


def _kernels(cartesian: Cartesian) -> tuple[Kernel, Kernel]:
    """Return the kernels of all Killing tensors and of those that come from concircular tensors.

    In the plane irrational constants are letters first: a kernel as large as numbers allow at the constants is theirs.
    """
    n, basis = len(cartesian.X), killing_basis(cartesian.X)
    lettered, values = with_named_constants(cartesian)
    if n == 2 and values and not cartesian.system.parameters:
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


Found = tuple[list[Geometry], tuple[Web, ...]]


def _webs(reduced: Kernel, cartesian: Cartesian, budget: float) -> Found:
    """Return the geometries and the webs.

    Irrational constants are letters in the plane, where this is quick, and in space where their own arithmetic does
    not lead to the end.
    """
    lettered, values = with_named_constants(cartesian)
    if not values or reduced.dimension == 1:
        return _with_constants(reduced, cartesian, budget)
    if len(cartesian.X) == 2:
        return _with_letters(reduced, cartesian, lettered, values, budget) or _with_constants(
            reduced, cartesian, budget
        )
    found = _with_constants(reduced, cartesian, budget)
    if len(values) > _MOST_LETTERS or _is_resolved(found):
        return found
    return _with_letters(reduced, cartesian, lettered, values, budget) or found


def _is_resolved(found: Found) -> bool:
    return all(web.certified for web in found[1]) and not any(g.kind == "unresolved" for g in found[0])


def _with_constants(reduced: Kernel, cartesian: Cartesian, budget: float | None) -> Found:
    """Find the webs with the constants as they are; sympy may have no normal form of them, or no end."""
    try:
        geometries = _geometries(reduced, cartesian)
        return geometries, tuple(web_of(g, cartesian, budget=budget) for g in geometries if g.kind not in _PARTIAL)
    except (sp.PolynomialError, NotImplementedError, OverflowError):
        return [Geometry("unresolved", (), ())], ()


def _with_letters(
    reduced: Kernel, cartesian: Cartesian, lettered: Cartesian, values: Values, budget: float
) -> Found | None:
    """Find the webs with a letter for each constant; None where the constants have more webs than the letters."""
    generic = _concircular_kernel(lettered, check=False)
    if generic.dimension != reduced.dimension:
        return None
    geometries, webs = _with_constants(generic, lettered, None)
    return geometries, tuple(restored(web, values, cartesian, budget=budget) for web in webs)


def _combined(full: Kernel, basis: Sequence[sp.ImmutableMatrix]) -> tuple[sp.ImmutableMatrix, ...]:
    zero = sp.zeros(*basis[0].shape)
    return tuple(sp.ImmutableMatrix(sum((c * K for c, K in zip(v, basis, strict=True)), zero)) for v in full.vectors)


def _geometries(reduced: Kernel, cartesian: Cartesian) -> list[Geometry]:
    """Return the webs, and in space also what splits off without leading to one."""
    sign = sign_by(cartesian.values)
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
