"""Signs of letters that follow from what must be positive: masses in T, and the lengths of domains.

Whoever types m*dot(x)**2/2 means a positive m without saying so. T is refused where it is not positive definite and a
domain where it is empty, so that the sign is known, and formulas need no sign(m).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy as sp

from hjsolve.mechanics.coordinates_and_parameters import Assumption, Coordinate, Parameter, contradicts

_OPEN = ("real", "nonnegative", "nonzero")


def needed_signs(
    masses: Sequence[sp.Expr], coordinates: Iterable[Coordinate], parameters: Sequence[Parameter]
) -> Mapping[str, Assumption]:
    """Return the signs that letters of products must have, by name; of none whose value has another sign.

    Args:
        masses: coefficients that are positive inside the domain: of squared velocities, of a positive definite T.
        coordinates: with their domains.
        parameters: as declared.
    """
    ends = [(c.domain.lower, c.domain.upper) for c in coordinates]
    positive = [*masses, *(high - low for low, high in ends if low is not None and high is not None)]
    products, found = [sp.factor_terms(one) for one in positive], dict[str, Assumption]()
    letters = {p.symbol: p for p in parameters if p.assume in _OPEN}
    while True:
        known = {s: sp.Symbol(s.name, real=True, **{found[s.name]: True}) for s in letters if s.name in found}
        new = dict(filter(None, (_sign_in(one.xreplace(known), letters) for one in products)))
        if not new:
            return found
        for symbol, sign in new.items():
            if contradicts(letters[symbol], sign):
                del letters[symbol]
            else:
                found[symbol.name] = sign


def _sign_in(product: sp.Expr, letters: Mapping[sp.Symbol, Parameter]) -> tuple[sp.Symbol, Assumption] | None:
    """Return the only letter of open sign among the factors, and its sign; squares have one that is known."""
    side, odd = 1, list[sp.Expr]()
    for factor in sp.Mul.make_args(product):
        base, power = factor.as_base_exp()
        if not power.is_integer:
            base, power = factor, sp.S.One
        if power.is_even or base.is_positive:
            continue
        if base.is_negative:
            side = -side
        else:
            odd.append(base)
    if len(odd) != 1 or odd[0] not in letters:
        return None
    return odd[0], "positive" if side > 0 else "negative"
