"""A system from H(q, p): the Legendre transformation back to T and V (Greenwood §4-2).

Of H = ½ pᵀWp + bᵀp + c the velocities are q̇ = Wp + b and L = ½ (q̇ − b)ᵀ W⁻¹ (q̇ − b) − c, so T is the first part with
what b adds to it, and V = c. Of H = V + √(m²c⁴ + c² pᵀg p) the classical kinetic energy is m/2 q̇ᵀ g⁻¹ q̇; the
relation of energy and momentum is then that of special relativity.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import permutations

import sympy as sp

from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.read import parse
from hjsolve.mechanics.coordinates_and_parameters import clock_of
from hjsolve.mechanics.system import Parameter, System, parameter

_OTHERS = (
    "hamiltonian: of several degrees of freedom H must be quadratic in the momenta, or V + sqrt(m**2*c**4 + c**2*(…)) "
    "with parameters for the rest mass and the speed of light, or a sum of Hamiltonians that share no coordinate; of "
    "one degree of freedom any H(q, p) is taken"
)


def system_from_momenta(
    hamiltonian: str, coordinates: Mapping[str, str], parameters: Mapping[str, object] | None, title: str, id_: str
) -> System:
    """Take a system from H(q, p), written with ``p_`` before the name of each coordinate.

    Args:
        hamiltonian: H.
        coordinates: name → domain.
        parameters: name → value.
        title, id_: for display.

    Raises:
        InvalidSystemError: H is of neither form, or does not determine the velocities.
    """
    shape, H, momenta = read_with_momenta(hamiltonian, coordinates, parameters)
    velocities = sp.Matrix([c.velocity for c in shape.coordinates])
    if H.is_polynomial(*momenta):
        W, b, V = _parts(H, momenta)
        return System(dict(coordinates), _kinetic(W, velocities - b), V, parameters, title=title, id=id_)
    if any(s.name == "t" for s in H.free_symbols) and "t" not in shape.symbols:
        raise InvalidSystemError("hamiltonian: with the time t only H of second degree in the momenta is taken")
    names, _, _ = _relativistic(H, momenta, shape)
    positive = {p.name: _assumed(p, names) for p in shape.parameters}
    shape, H, momenta = read_with_momenta(hamiltonian, coordinates, positive)
    _, g, V = _relativistic(H, momenta, shape)
    T = shape.symbols[names["mass"]] * _kinetic(g, velocities)
    return System(dict(coordinates), T, V, positive, title=title, id=id_, relativity=names)


def read_with_momenta(
    hamiltonian: str, coordinates: Mapping[str, str], parameters: Mapping[str, object] | None
) -> tuple[System, sp.Expr, list[sp.Symbol]]:
    """Return a system with the symbols, H, and the momenta in it.

    Args:
        hamiltonian: H.
        coordinates: name → domain.
        parameters: name → value.

    Raises:
        InvalidSystemError: a momentum is missing, or its name is taken.
    """
    shape = System(dict(coordinates), " + ".join(f"dot({name})**2/2" for name in coordinates), "0", parameters)
    names = {f"p_{c.name}": c.momentum for c in shape.coordinates}
    if taken := sorted(names.keys() & shape.symbols.keys()):
        raise InvalidSystemError(f"hamiltonian: {taken[0]} is the momentum; rename the coordinate or parameter")
    if re.search(r"\bp\b", str(hamiltonian)) and "p" not in shape.symbols:
        raise InvalidSystemError(f"hamiltonian: of several coordinates the momenta are {', '.join(names)}, not p")
    clock = {c.name: c.symbol for c in clock_of((hamiltonian,), shape.symbols)}
    H = parse(hamiltonian, {**shape.symbols, **names, **clock}, source="hamiltonian")
    if missing := [name for name, p in names.items() if not H.has(p)]:
        raise InvalidSystemError(f"hamiltonian: there is no {missing[0]} in it; leave out the coordinate")
    return shape, H, list(names.values())


def _assumed(one: Parameter, names: Mapping[str, str]) -> Parameter:
    """Return a parameter, positive where it is a rest mass or a speed of light."""
    if one.name not in names.values():
        return one
    return parameter(one.name, one.value, assume="positive", unit=one.unit, meaning=one.meaning)


def _parts(H: sp.Expr, momenta: list[sp.Symbol]) -> tuple[sp.Matrix, sp.Matrix, sp.Expr]:
    """Return W, b and c of an H of second degree."""
    if sp.Poly(H, *momenta).total_degree() != 2:
        raise InvalidSystemError(_OTHERS)
    still = dict.fromkeys(momenta, 0)
    W = sp.hessian(H, momenta).applyfunc(sp.factor)
    b = sp.Matrix([sp.diff(H, p).xreplace(still) for p in momenta])
    return W, b, H.xreplace(still)


def _kinetic(W: sp.Matrix, velocities: sp.Matrix) -> sp.Expr:
    """Return ½ vᵀ W⁻¹ v."""
    if sp.simplify(W.det()) == 0:
        raise InvalidSystemError(
            "hamiltonian: the velocities do not follow from the momenta, since det(∂²H/∂p∂p) = 0; H of first degree in "
            "a momentum is taken with one coordinate alone"
        )
    inverse = W.inv().applyfunc(sp.factor)
    return sp.Add(*(
        inverse[i, j] * velocities[i] * velocities[j] / 2 for i in range(W.rows) for j in range(W.rows)
    ))  # fmt: skip


def _relativistic(H: sp.Expr, momenta: list[sp.Symbol], shape: System) -> tuple[dict[str, str], sp.Matrix, sp.Expr]:
    """Return the names of m and c, g and V of H = V + √(m²c⁴ + c² pᵀg p)."""
    roots = [term for term in sp.Add.make_args(H) if term.has(*momenta)]
    if len(roots) == 1 and (square := sp.expand(roots[0] ** 2)).is_polynomial(*momenta):
        bend, slope, rest = _parts(square, momenta)
        for mass, light in permutations(shape.parameters, 2):
            m, c = mass.symbol, light.symbol
            if all(e == 0 for e in slope) and sp.simplify(rest - m**2 * c**4) == 0:
                g = (bend / (2 * c**2)).applyfunc(sp.factor)
                return {"mass": mass.name, "light": light.name}, g, H - roots[0]
    raise InvalidSystemError(_OTHERS)
