"""More integrals than a system needs: how many, with which leading parts, and what that does to the frequencies.

Integrals ½K^{ij}p_i p_j + U are functionally independent where their leading parts are: the terms of highest degree in
p of a minor of ∂(I₁, I₂, …)/∂(x, p) are that minor of the leading parts. With r independent integrals of n degrees of
freedom the closure of a bounded motion lies in a set of dimension 2n − r, and it is a torus with as many dimensions as
there are independent frequencies: r − n relations Σ kᵢ Ωᵢ = 0 with whole kᵢ hold, the same ones for all neighbours
(Nekhoroshev, Trans. Moscow Math. Soc. 26 (1972) 180; Miller, Post, Winternitz, J. Phys. A 46 (2013) 423001, §2).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from random import Random

import sympy as sp

from hjsolve.coordinates.charts.transform import Cartesian
from hjsolve.coordinates.results import SeparableCoordinates
from hjsolve.coordinates.small_oscillations import NormalModes

_DIGITS, _NOUGHT = 60, 40
_MOST_TOLD, _LONGEST = 5, 160


def independent_integrals(found: SeparableCoordinates, cartesian: Cartesian) -> int:
    """Count the functionally independent ones among the quadratic integrals, energy included; at least so many.

    Args:
        found: the coordinates found for a system.
        cartesian: the same system as a particle of one mass.
    """
    p = [sp.Symbol(f"_p{i}", real=True) for i in range(len(cartesian.X))]
    at_values = dict(cartesian.values)
    leading = sp.Matrix([_leading(K.xreplace(at_values), p) for K in found.killing_tensors])
    variables, dice = [*cartesian.X, *p], Random(7)  # noqa: S311 - a sample point
    at = {s: sp.Rational(dice.randint(-99, 99), 37) for s in variables}
    values = leading.jacobian(variables).subs(at).evalf(_DIGITS)
    return int(values.rank(iszerofunc=lambda entry: abs(entry) < sp.Float(10) ** -_NOUGHT))


def _leading(K: sp.MatrixBase, p: Sequence[sp.Expr]) -> sp.Expr:
    column = sp.Matrix(list(p))
    return sp.expand((column.T * K * column)[0, 0])


def webs_in_words(found: SeparableCoordinates, cartesian: Cartesian, chosen: str, independent: int) -> str:
    """Say which webs there are, why one was taken, and what more integrals than needed do; empty for a single web.

    Args:
        found: the coordinates found.
        cartesian: the system as a particle of one mass.
        chosen: kind of the web taken.
        independent: from ``independent_integrals``.
    """
    n = len(cartesian.system.coordinates)
    if len(found.webs) < 2 and not any(web.freedom for web in found.webs) and independent <= n:
        return ""
    kinds = [web.kind + (" (a family)" if web.freedom else "") for web in found.webs]
    sentences = [f"it separates in {', '.join(kinds)} coordinates"]
    if len(found.webs) > 1:
        sentences.append(f"{chosen} ones were taken, whose equations are the simplest")
    if independent > n:
        more, s = independent - n, "s" if independent - n > 1 else ""
        sentences.append(
            f"{independent} independent integrals quadratic in the momenta, {more} more than {n} degrees of freedom "
            f"need{_begin(found, cartesian)}"
        )
        closed = (
            "bounded motions close" if independent == 2 * n - 1 else f"bounded motions fill {2 * n - independent}-tori"
        )
        sentences.append(
            f"so {closed}: their frequencies obey {more} relation{s} with whole numbers, the same for all neighbours"
        )
    return "; ".join(sentences)


def _begin(found: SeparableCoordinates, cartesian: Cartesian) -> str:
    """Return the leading parts, in the user's own coordinates, where they are these and few."""
    own = [c.symbol for c in cartesian.system.coordinates]
    if list(cartesian.X) != own:
        return ""
    p = [c.momentum for c in cartesian.system.coordinates]
    parts = list[str]()
    for K in found.killing_tensors[: _MOST_TOLD + 1]:
        parts.append(str(sp.factor(_leading(K, p))))
        if len(", ".join(parts)) > _LONGEST:
            return ""
    return f" (they begin with {', '.join(parts)})"


def modes_in_words(modes: NormalModes) -> str:
    """Say which frequencies of normal modes are the same, or in a ratio of whole numbers; empty where none are."""
    moving = [mode for mode in modes.modes if mode.kind == "oscillation"]
    found = []
    for one, other in combinations(moving, 2):
        ratio = sp.sqrt(sp.cancel(one.frequency_squared / other.frequency_squared))
        if ratio.is_Rational:
            k, m = (f"{n} " if n > 1 else "" for n in (int(ratio.q), int(ratio.p)))
            found.append(f"{k}Ω_{one.name} = {m}Ω_{other.name}")
    return f"{', '.join(found)} exactly, so there are more integrals than needed" if found else ""
