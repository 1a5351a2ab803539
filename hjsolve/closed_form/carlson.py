"""∫ R(x) dx/√P(x), deg P = 3 or 4, in Carlson's integrals: where P has a complex pair, or Legendre's do not reach."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.functions import elliptic


@dataclass(frozen=True)
class CarlsonMap:
    """The interval between roots, and the roots.

    Attributes:
        roots: of P.
    """

    roots: NamedRoots

    @property
    def start(self) -> str:
        """The end from which integrals are taken."""
        return "lower" if self.roots.interval[0] is not None else "upper"

    @property
    def direction(self) -> int:
        """1 where the integrals grow with x, else −1."""
        return 1 if self.start == "lower" else -1

    @property
    def points(self) -> elliptic.BranchPoints:
        """The branch points."""
        return elliptic.BranchPoints(self.roots.leading, self.roots.real, self.roots.pairs)


def carlson_map(roots: NamedRoots, prefix: str) -> CarlsonMap:
    """The map, every root by a name: Carlson's arguments hold all of them several times.

    Args:
        roots: of P.
        prefix: of the names.
    """
    where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]] = dict(roots.where)
    real, pairs = list[sp.Expr](), list[tuple[sp.Expr, sp.Expr]]()
    for k, r in enumerate(roots.real):
        name = r if r.is_Symbol or r.is_number else sp.Symbol(f"{prefix}_{k + 1}", real=True)
        if name != r:
            where[name] = r
        real.append(name)
    for k, (re, im) in enumerate(roots.pairs):
        mark = "" if len(roots.pairs) == 1 else f"_{k + 1}"
        names = (sp.Symbol(f"{prefix}_re{mark}", real=True), sp.Symbol(f"{prefix}_im{mark}", positive=True))
        where |= {names[0]: re, names[1]: im}
        pairs.append(names)
    return CarlsonMap(NamedRoots(roots.leading, tuple(real), tuple(pairs), where, roots.interval))


def carlson_integral(R: elliptic.PartialFractions, way: CarlsonMap, x: sp.Expr | None) -> sp.Expr:
    """∫ R dx/√P, from an end of the interval to x; over all of it where x is None.

    Args:
        R: in partial fractions.
        way: the interval.
        x: the upper end.

    Raises:
        NoFormError: it diverges, or no form is known.
    """
    try:
        if x is None:
            return elliptic.complete(R, way.points, way.roots.interval)
        return way.direction * elliptic.incomplete(R, way.points, way.roots.interval, x, way.start)
    except elliptic.NoForm as error:
        raise NoFormError(str(error)) from error


def carlson_inverse(way: CarlsonMap, value: sp.Expr, begin: sp.Expr) -> sp.Expr:
    """The x at which ∫ dx/√P from a place has a value.

    Args:
        way: the interval.
        value: of the integral.
        begin: the place, an x.

    Raises:
        NoFormError: P has no real root to begin at.
    """
    first = elliptic.PartialFractions(((0, sp.S.One),))
    try:
        passed = elliptic.incomplete(first, way.points, way.roots.interval, begin, way.start)
        return elliptic.inverse(way.points, way.roots.interval, passed + way.direction * sp.expand(value), way.start)
    except elliptic.NoForm as error:
        raise NoFormError(str(error)) from error
