"""A variable in which p² is rational where it holds one square root of a wave: for the genus of its curve.

With f = cos κq, sin κq, cosh κq or sinh κq, f′² = κ² s (1 − σ f²), and r² = A + B f²,

    p² rational in f² and r:  x = r,          f² = (x² − A)/B,            x′² = B² f² f′²/x²
    p² rational in f and r:   x = √B f + r,   f = (x² − A)/(2 √B x),  r = (x² + A)/(2x),  x′² = B x² f′²/r²

the latter Euler's, of the conic r² = A + B f². Neither need be monotone along the motion: no form is made of them, but
the genus of y² = p² x′² is that of the integrals of the coordinate. Of the potential of Kuzmin and Kutuzov, whose
p² sinh² u is a quartic in x = √(c² + d² cosh² u), y² = (x² − c²) × that quartic has genus 2.
"""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from hjsolve.closed_form.change_of_variable import Substitution

_WAVES = {sp.cos: (1, 1), sp.sin: (1, 1), sp.cosh: (-1, 1), sp.sinh: (1, -1)}
"""Wave → s and σ of its f′² = κ² s (1 − σ f²)."""
_OTHER = {sp.cos: sp.sin, sp.sin: sp.cos, sp.cosh: sp.sinh, sp.sinh: sp.cosh}
"""Wave → the one of which the square is f′²/κ²."""


def conic_variables(square: sp.Expr, q: sp.Symbol, x: sp.Symbol) -> Iterator[Substitution]:
    """Yield the variables in which a squared momentum is rational.

    Args:
        square: P²(q).
        q: the coordinate.
        x: the symbol to use for the variable.
    """
    roots = [p for p in square.atoms(sp.Pow) if p.has(q) and not p.exp.is_Integer]
    waves = [f for f in square.atoms(sp.Function) if f.has(q)]
    if len({p.base for p in roots}) != 1 or any(p.exp.q != 2 for p in roots) or len({f.args for f in waves}) != 1:
        return
    w, κ, r = waves[0].args[0], sp.diff(waves[0].args[0], q), sp.Dummy("r", positive=True)
    for wave, (s, σ) in _WAVES.items():
        if κ.has(q) or not any(isinstance(one, wave) for one in waves):
            continue
        f, other = sp.Dummy("f"), _OTHER[wave]
        plain = square.xreplace({p: r ** (2 * p.exp) for p in roots}).xreplace({wave(w): f})
        conic = roots[0].base.xreplace({wave(w): f})
        rest = s * (1 - σ * f**2)  # g² of the other wave
        plain, conic = (_without(e, other(w), rest) for e in (plain, conic))
        if plain.has(q) or not conic.is_polynomial(f) or sp.degree(conic, f) != 2 or conic.has(q):
            continue
        B, middle, A = sp.Poly(conic, f).all_coeffs()
        if middle != 0:
            continue
        slope, place = κ**2 * rest, wave(w)
        even = sp.cancel(sp.together(plain))
        if sp.cancel(even - even.subs(f, -f)) == 0:
            z = sp.Dummy("z", positive=True)
            by_square = sp.powdenest(even.subs(f, sp.sqrt(z)), force=True).subs({z: (x**2 - A) / B, r: x})
            change = (B**2 * f**2 * slope).subs(f, sp.sqrt((x**2 - A) / B)) / x**2
            yield _variable(x, sp.sqrt(roots[0].base), by_square, change)
            return
        if B.is_negative:  # √B of an ellipse is imaginary, and so would be P
            continue
        root = sp.sqrt(B)
        at = {f: (x**2 - A) / (2 * root * x), r: (x**2 + A) / (2 * x)}
        yield _variable(x, root * place + sp.sqrt(roots[0].base), plain.subs(at), (B * x**2 * slope / r**2).subs(at))
        return


def _without(e: sp.Expr, other: sp.Expr, square: sp.Expr) -> sp.Expr:
    """Return an expression with g² for even powers of the other wave."""
    return e.replace(
        lambda p: p.is_Pow and p.base == other and p.exp.is_Integer and p.exp % 2 == 0,
        lambda p: square ** (p.exp // 2),
    )


def _variable(x: sp.Symbol, place: sp.Expr, function: sp.Expr, slope: sp.Expr) -> Substitution:
    plain, slope = (sp.cancel(sp.together(e)) for e in (function, slope))
    return Substitution(x, place, sp.nan, slope, plain, -sp.oo, sp.oo, True)
