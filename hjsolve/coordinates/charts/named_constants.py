"""Irrational constants of a potential as named ones: the geometry of a web does not depend on what they are.

Eigenvectors and lengths of a web whose centres lie at √2, at the golden ratio or at 2^(1/3) are roots over a number
field, which sympy brings to no normal form. With a letter for each constant they are rational functions and one root
of a polynomial, as for parameters. The web that comes out holds for every value of the letters; at the end the
constants are put back, and ``separate`` judges the system with the constants themselves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import sympy as sp

from hjsolve.algebra.time_limit import seconds_left
from hjsolve.coordinates.charts.transform import Cartesian
from hjsolve.coordinates.webs.orthonormal_frames import tidy_constant
from hjsolve.coordinates.webs.web import Vector, Web
from hjsolve.mechanics.system import System, parameter
from hjsolve.separation import separate

Values = Mapping[sp.Symbol, sp.Expr]


def with_named_constants(cartesian: Cartesian) -> tuple[Cartesian, Values]:
    """Replace every irrational constant of the potential by a letter.

    Args:
        cartesian: the system in Cartesian coordinates of equal mass.

    Returns:
        The same with letters for constants, as parameters of its system, and letter → constant; nothing where the
        potential has none.
    """
    system, potential = cartesian.system, cartesian.potential
    found = sorted(set(_irrational(potential)), key=sp.default_sort_key)
    names = (f"c_{k}" for k in range(1, 10_000) if f"c_{k}" not in system.symbols)
    letters = []
    for constant in found:
        sign = "positive" if constant.is_positive else "negative" if constant.is_negative else "real"
        letters.append(parameter(next(names), constant, assume=sign))
    symbols = {p.symbol: constant for p, constant in zip(letters, found, strict=True)}
    back = {constant: symbol for symbol, constant in symbols.items()}
    lettered = System(
        {q.name: q.domain.written(q.name) for q in system.coordinates},
        system.kinetic,
        system.potential.xreplace(back),
        {p.name: p for p in (*system.parameters, *letters)},
        title=system.title,
    )
    values = {**cartesian.values, **symbols}
    return replace(cartesian, system=lettered, potential=potential.xreplace(back), values=values), symbols


def _irrational(x: sp.Expr) -> Iterator[sp.Expr]:
    """Yield the constants of an expression that are not rational: roots, π, values of functions.

    Exponents are left alone.
    """
    if x.is_Rational:
        return
    if x.is_number and not x.is_Mul and not x.is_Add:
        yield x
        return
    for a in (x.base,) if x.is_Pow else x.args:
        yield from _irrational(a)


def restored(web: Web, values: Values, cartesian: Cartesian, *, budget: float) -> Web:
    """Put the constants back into a web and let ``separate`` judge the system with them.

    Args:
        web: found with letters for the constants.
        values: letter → constant.
        cartesian: the system as it was given.
        budget: seconds for ``separate``.
    """

    def value(x: sp.Expr) -> sp.Expr:
        return tidy_constant(x.xreplace(dict(values))) if x.free_symbols & values.keys() else x

    def vector(v: Vector) -> Vector:
        return tuple(value(c) for c in v)

    own = web.system
    plain = System(
        {q.name: q.domain.written(q.name) for q in own.coordinates},
        own.kinetic.xreplace(dict(values)),
        own.potential.xreplace(dict(values)),
        {p.name: p for p in cartesian.system.parameters},
        title=own.title,
    )
    geometry = replace(
        web, centre=vector(web.centre), axes=tuple(map(vector, web.axes)), foci=tuple(map(vector, web.foci)),
        lengths={name: value(x) for name, x in web.lengths.items()},
        transformation={name: sp.expand(x.xreplace(dict(values))) for name, x in web.transformation.items()},
    )  # fmt: skip
    return replace(geometry, system=plain, verdict=separate(plain, budget=seconds_left(budget)))
