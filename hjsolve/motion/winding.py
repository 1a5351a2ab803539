"""A coordinate on a line along which p² repeats itself: over the barriers it goes round like an angle."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy.functions.elementary.trigonometric import TrigonometricFunction


def radians_of_a_unit(F: sp.Expr, q: sp.Symbol, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr | None:
    """Return a > 0 such that F is a function of the angle a·q: q stands in sines of commensurate arguments only.

    Args:
        F: p²(q; κ).
        values: symbol → exact number, for the parameters in the arguments.

    Returns:
        a, an exact number; None where F does not repeat itself.
    """
    waves = [w for w in F.atoms(TrigonometricFunction) if w.has(q)]
    if not waves or F.xreplace({w: sp.Dummy() for w in waves}).has(q):
        return None
    rates = [sp.diff(w.args[0], q) for w in waves]
    if any(rate.has(q) for rate in rates):
        return None
    numbers = [rate.xreplace(dict(values)) for rate in rates]
    first = numbers[0]
    if first == 0 or not all(x.is_number for x in numbers):
        return None
    ratios = [sp.cancel(x / first) for x in numbers]
    if not all(ratio.is_Rational for ratio in ratios):
        return None
    return sp.Abs(first) * sp.gcd_list(ratios)
