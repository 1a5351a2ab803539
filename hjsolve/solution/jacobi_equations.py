"""Jacobi's equations of a separated system: ∂W/∂E = t − t₀, ∂W/∂α = −β; and its constants in plain words.

Greenwood (5-70), (5-71), (5-83); without a separated coordinate (5-74).

``taken`` are names that symbols already have.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import sympy as sp

from hjsolve.mechanics.coordinates_and_parameters import free_name
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.separation import Constant, Separation

Separated = list[tuple[sp.Symbol, sp.Expr, sp.Symbol]]
"""Of every separated coordinate: q, the root √Pᵢ² (the momentum itself where null), the lower limit."""


def separation_constants(verdict: Separation) -> tuple[Constant, ...]:
    """E, alpha_2, …: the constants that multiply the columns of Φ, in their order.

    Args:
        verdict: with the Stäckel matrix Φ.
    """
    ignorable = {c.momentum for c in verdict.shell.ignorable}
    return tuple(c for c in verdict.constants.values() if c.symbol not in ignorable)


def named_constants(verdict: Separation) -> dict[str, Constant]:
    """Return the constants, those meanings made plainer that a physicist would recognise."""
    plainer = {c.name: _recognised(c, verdict) for c in separation_constants(verdict)[1:]}
    return {name: replace(c, meaning=plainer.get(name) or c.meaning) for name, c in verdict.constants.items()}


def _recognised(constant: Constant, verdict: Separation) -> str:
    """Half the squared angular momentum (with what a field adds to it), or the motion of one coordinate alone."""
    held = [c for c in verdict.system.coordinates if constant.expression.has(c.symbol, c.momentum)]
    for polar in held:
        for azimuth in held:
            square = polar.momentum**2 / 2 + azimuth.momentum**2 / (2 * sp.sin(polar.symbol) ** 2)
            if azimuth == polar or not _alike(constant.expression, square, polar.momentum, azimuth.momentum):
                continue
            rest = sp.expand(constant.expression - square)
            if not rest.has(*(c.momentum for c in held)):
                more = f", plus {sp.sstr(rest)}" if rest != 0 else ""
                return f"half the square of the total angular momentum{more}"
    if len(held) == 1:
        return f"constant of the motion of {held[0].name} alone"
    return ""


def _alike(one: sp.Expr, other: sp.Expr, *momenta: sp.Symbol) -> bool:
    """Whether two functions have equal second derivatives in some momenta at one place: expanding may take for ever."""
    place = {s: sp.Float(2 + k) / 7 for k, s in enumerate(sorted((one - other).free_symbols, key=str))}
    bends = [(sp.diff(one - other, p, 2)).xreplace(place) for p in momenta]
    return all(bend.is_number and abs(sp.N(bend)) < 1e-6 for bend in bends)


def quadrature(integrand: sp.Expr, q: sp.Symbol, start: sp.Symbol) -> sp.Expr:
    """Return ∫ from a lower limit to q, unevaluated.

    Args:
        integrand: a function of q.
        start: the lower limit.
    """
    return sp.S.Zero if integrand == 0 else sp.Integral(integrand, (q, start, q))


def _derivative(verdict: Separation, separated: Separated, constant: sp.Symbol) -> sp.Expr:
    """∂W/∂(constant) without the term c·q: Σ ∫ (∂Pᵢ²/∂c)/(2Pᵢ) dqᵢ − ∂χ/∂c."""
    null = {c.symbol for c in verdict.shell.coordinates if c.name in verdict.shell.null}
    slopes = [
        sp.diff(root, constant) if q in null else sp.diff(root**2, constant) / (2 * root) for q, root, _ in separated
    ]
    terms = [quadrature(slope, q, start) for slope, (q, _, start) in zip(slopes, separated, strict=True)]
    return sp.Add(*terms, -sp.diff(verdict.shell.shift_potential, constant))


def time_law_of(verdict: Separation, separated: Separated, taken: frozenset[str]) -> sp.Eq | None:
    """Return t − t₀ = ∂W/∂E (5-71); None where every coordinate is ignorable."""
    if not separated:
        return None
    name = time_name(verdict.system)
    t, t0 = sp.Symbol(name, real=True), fresh_symbol(f"{name}_0", taken, real=True)
    return sp.Eq(t - t0, _derivative(verdict, separated, verdict.shell.energy), evaluate=False)


def orbit_equations_of(verdict: Separation, separated: Separated, taken: frozenset[str]) -> dict[str, sp.Eq]:
    """−β = ∂W/∂α, −β = q + ∂W′/∂c; with no separated coordinate −β = q − t ∂H/∂c, from S = Σ c q − H(c) t (5-74)."""
    position = {c.momentum: c.symbol for c in verdict.shell.ignorable}
    equations = {}
    for name, constant in verdict.constants.items():
        if constant.symbol == verdict.shell.energy:
            continue
        right = position.get(constant.symbol, sp.S.Zero) + _derivative(verdict, separated, constant.symbol)
        if not separated:
            right -= sp.Symbol(time_name(verdict.system), real=True) * sp.diff(verdict.shell.potential, constant.symbol)
        beta = fresh_symbol("beta_" + name.removeprefix("alpha_").removeprefix("p_"), taken, real=True)
        equations[name] = sp.Eq(-beta, right, evaluate=False)
    return equations


def names_taken(verdict: Separation) -> frozenset[str]:
    """Return the names that the symbols of a system have."""
    symbols = set(verdict.system.symbols) | {c.symbol.name for c in verdict.constants.values()}
    return frozenset(symbols | {c.momentum.name for c in verdict.system.coordinates})


def fresh_symbol(name: str, taken: Iterable[str], **assumptions: bool) -> sp.Symbol:
    """Return a symbol of this name, or with underscores added where the user already has one that looks like it.

    Args:
        name: wanted.
        taken: names that are not free.
        assumptions: of the symbol.
    """
    return sp.Symbol(free_name(name, taken), **assumptions)
