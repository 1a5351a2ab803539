"""The complex pair of a polynomial P of degree 3 or 4 whose other roots are real and have names.

With P = (x − x₁)(x − x₂)(x² + βx + γ) by its leading coefficient, β = b + x₁ + x₂ where P is x⁴ + bx³ + …: short, and
without digits in doubles where a root is much larger than the pair. Then the division has to begin at the other end:
by roots smaller than the pair from the highest power down, by larger ones from the constant up.

Peters and Wilkinson, J. Inst. Math. Appl. 8 (1971) 16, section 4 (composite deflation).
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.closed_form.no_form import NoFormError

Parts = tuple[sp.Expr, sp.Expr]
"""Real and imaginary part, the latter positive."""


def remaining_pair(P: sp.Poly, real: Sequence[sp.Symbol]) -> tuple[Parts, ...]:
    """Return the complex pair that is left next to named real roots, by Vieta's formulas; none where all are real.

    Args:
        P: of degree 3 or 4.
        real: its real roots.

    Raises:
        NoFormError: no root is real.
    """
    if len(real) == P.degree():
        return ()
    if len(real) != P.degree() - 2:
        raise NoFormError("P has no real root")
    A, b, c = P.all_coeffs()[:3]
    # x² + βx + γ: the sum of all roots is −b/A, and the sum of products in twos is c/A
    total = sp.Add(*real)
    β = b / A + total
    γ = c / A - (real[0] * real[1] if len(real) == 2 else 0) + β * total
    return (_parts(β, γ),)


def deflated_pair(P: sp.Poly, real: Sequence[sp.Symbol]) -> Parts:
    """Return the same pair for doubles: of each root, the division that leaves the digits of the pair.

    A root x is smaller than the pair, of the size r, where |x|ⁿ⁻² |x₁ x₂| ≤ r² |x₁ x₂|, the constant of P.

    Args:
        P: of degree 3 or 4.
        real: its real roots, two fewer than its degree.
    """
    _, *monic = (sp.factor(c / P.LC()) for c in P.all_coeffs())
    size = sp.Mul(*map(sp.Abs, real))
    small = [sp.Le(x**2 * size, sp.Abs(monic[-1])) for x in real]
    if len(real) == 1:
        b, c, d = monic
        (x,) = real
        down, up = (b + x, c + x * (b + x)), ((-d / x - c) / x, -d / x)
        return _chosen([(_parts(*down), small[0]), (_parts(*up), sp.true)])
    b, c, d, e = monic
    total, product = sp.Add(*real), sp.Mul(*real)
    β, γ = b + total, e / product
    cases = [
        # both real roots smaller than the pair: from the highest power down
        (_parts(β, c + total * β - product), sp.And(*small)),
        # both larger: γ is the constant by their product, β from the next coefficient
        (_parts((d + total * γ) / product, γ), sp.Not(sp.Or(*small))),
    ]
    # one of each: the small root is divided out from above, the large one of what is left from below
    for (x, y), first in (((real[0], real[1]), small[0]), ((real[1], real[0]), sp.true)):
        cubic = c + x * (b + x)
        constant = -(d + x * cubic) / y
        cases.append((_parts((constant - cubic) / y, constant), first))
    return _chosen(cases)


def _parts(β: sp.Expr, γ: sp.Expr) -> Parts:
    return -β / 2, sp.sqrt(γ - β**2 / 4)


def _chosen(cases: Sequence[tuple[Parts, sp.Basic]]) -> Parts:
    along, across = (sp.Piecewise(*((parts[k], condition) for parts, condition in cases)) for k in (0, 1))
    return along, across
