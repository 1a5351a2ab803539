"""∫ R(x) dx/√P(x), deg P = 3 or 4, in Carlson's integrals: where P has a complex pair, or Legendre's do not reach."""

from __future__ import annotations

from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.signs import Signs
from hjsolve.functions import elliptic
from hjsolve.precision import mp


@dataclass(frozen=True)
class CarlsonMap:
    """The interval between roots, and the roots.

    Attributes:
        roots: of P.
        points: its branch points, with names for what complete integrals hold several times.
    """

    roots: NamedRoots
    points: elliptic.BranchPoints

    @property
    def start(self) -> str:
        """The end from which integrals are taken."""
        return "lower" if self.roots.interval[0] is not None else "upper"

    @property
    def direction(self) -> int:
        """1 where the integrals grow with x, else −1."""
        return 1 if self.start == "lower" else -1


def carlson_map(roots: NamedRoots, prefix: str) -> CarlsonMap:
    """Return the map, every root by a name: Carlson's arguments hold all of them several times.

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
        # both pairs of an even P on one vertical: one name for the real part
        same = next((named for (other, _), (named, _) in zip(roots.pairs, pairs, strict=False) if other == re), None)
        along = re if re.is_number else sp.Symbol(f"{prefix}_re{mark}", real=True) if same is None else same
        across = im if im.is_number else sp.Symbol(f"{prefix}_im{mark}", positive=True)
        where |= {name: meaning for name, meaning in ((along, re), (across, im)) if name.is_Symbol and name != meaning}
        pairs.append((along, across))
    named = replace(roots, real=tuple(real), pairs=tuple(pairs), where=where)
    plain = elliptic.BranchPoints(roots.leading, named.real, named.pairs, roots.polynomial)
    if len(pairs) != 1 or len(real) != 2 or None in roots.interval:
        return CarlsonMap(named, plain)
    # |x₁ − z| and |x₂ − z|: scale and modulus of the complete integrals are theirs (Byrd and Friedman 259)
    distances = {r: sp.Symbol(f"{prefix.replace('x', 'd', 1)}_z{k + 1}", positive=True) for k, r in enumerate(real)}
    where |= {name: plain.distance(r) for r, name in distances.items()}
    complement = sp.Symbol(prefix.replace("x", "k_c", 1), positive=True)
    points = replace(plain, distances=distances, complement=complement)
    where[complement] = sp.sqrt(elliptic.complement_squared(points, *real))
    return CarlsonMap(named, points)


@dataclass(frozen=True)
class PairsMap(CarlsonMap):
    """The whole line, P without a real root: integrals are taken from where the motion begins.

    Attributes:
        begin: the x of the lower limit.
        farther: the pair that is farther from the real axis once P is even, 0 or 1.
    """

    begin: sp.Expr
    farther: int

    @property
    def direction(self) -> int:
        """The integrals grow with x."""
        return 1


def pairs_map(roots: NamedRoots, signs: Signs, prefix: str, begin: sp.Expr) -> PairsMap:
    """Return the map where P has two complex pairs.

    Args:
        roots: of P.
        signs: of the sample.
        prefix: of the names.
        begin: the x of the lower limit.
    """
    own = carlson_map(roots, prefix)
    (α1, β1), (α2, β2) = ((signs.number(α), signs.number(β)) for α, β in roots.pairs)
    if α1 == α2:
        farther = 0 if β1 > β2 else 1
    else:
        # the Möbius map with 0 and ∞ at total/2 ± gap takes both pairs onto the imaginary axis, and P to an even one
        total = (α1**2 + β1**2 - α2**2 - β2**2) / (α1 - α2)
        gap = mp.sqrt(total**2 / 4 - total * α1 + α1**2 + β1**2)
        sizes = [abs((mp.mpc(α, β) - total / 2 - gap) / (mp.mpc(α, β) - total / 2 + gap)) for α, β in
                 ((α1, β1), (α2, β2))]  # fmt: skip
        farther = 0 if sizes[0] > sizes[1] else 1
    return PairsMap(own.roots, own.points, begin, farther)


def carlson_integral(
    R: elliptic.PartialFractions, change: CarlsonMap, x: sp.Expr | None, side: elliptic.Side
) -> sp.Expr:  # fmt: skip
    """∫ R dx/√P, from an end of the interval to x; over all of it where x is None.

    Args:
        R: in partial fractions.
        change: the interval.
        x: the upper end.
        side: real pole ↦ the sign of x − ρ on the interval.

    Raises:
        NoFormError: it diverges, or no form is known.
    """
    try:
        if isinstance(change, PairsMap):
            return (
                elliptic.around(R, change.points) if x is None else elliptic.between(R, change.points, change.begin, x)
            )
        if x is None:
            return elliptic.complete(R, change.points, change.roots.interval, side)
        return change.direction * elliptic.incomplete(R, change.points, change.roots.interval, x, change.start)
    except elliptic.NoForm as error:
        raise NoFormError(str(error)) from error
