"""Generating functions F₁(q, Q), F₂(q, P), F₃(p, Q), F₄(p, P): from a map, and back to it.

    μ Σ p dq − Σ P dQ = dψ:  F₁ = ψ, F₂ = ψ + Σ QP, F₃ = ψ − μ Σ qp, F₄ = F₂ − μ Σ qp   (6-18), (6-45), (6-51), (6-56)

Each is written in its own variables by solving for the others, and its equations are then verified on the map.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp

from hjsolve.algebra.time_limit import in_time
from hjsolve.arguments import described
from hjsolve.display.shown import listed_names
from hjsolve.errors import InvalidInputError
from hjsolve.separation.zero_test.zero_test import Zero, is_zero
from hjsolve.theorem.integrals import short
from hjsolve.theorem.phase_space import PhaseSpace
from hjsolve.theorem.reading import new_names, read_formula

KINDS = ("F1", "F2", "F3", "F4")
MOST_OPERATIONS = 120
SECONDS_TO_SOLVE, SECONDS_TO_SIMPLIFY = 10.0, 3.0
"""Equations that are longer are not solved."""


@dataclass(frozen=True)
class Generating:
    """A canonical map and what its generating functions are made of.

    Attributes:
        space: of the old variables.
        formulas: new variable → formula; coordinates first.
        valence: μ.
        psi: ψ(q, p, t).
    """

    space: PhaseSpace
    formulas: dict[str, sp.Expr]
    valence: sp.Expr
    psi: sp.Expr


@dataclass
class Found:
    """What was found: by kind the function, why there is none, and where it holds."""

    functions: dict[str, sp.Expr] = field(default_factory=dict)
    why_not: dict[str, str] = field(default_factory=dict)
    where: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Kind:
    """One kind: the old variables it keeps and those it gives up, the new ones it holds, and the signs of its slopes.

    Attributes:
        kept, gone: old symbols.
        held, other: new names.
        old_sign: μ·gone = old_sign ∂F/∂kept.
        new_sign: other = new_sign ∂F/∂held.
    """

    kept: list[sp.Symbol]
    gone: list[sp.Symbol]
    held: list[str]
    other: list[str]
    old_sign: int
    new_sign: int


def _kind(name: str, space: PhaseSpace, new: Sequence[str]) -> _Kind:
    q, p = [q for q, _ in space.pairs], [p for _, p in space.pairs]
    Q, P = list(new[: len(q)]), list(new[len(q) :])
    old = (q, p, 1) if name in ("F1", "F2") else (p, q, -1)
    fresh = (Q, P, -1) if name in ("F1", "F3") else (P, Q, 1)
    return _Kind(old[0], old[1], fresh[0], fresh[1], old[2], fresh[2])


def functions_of(given: Generating, seconds: float) -> Found:
    """Find F₁ … F₄ of a canonical map.

    Args:
        given: the map with its ψ.
        seconds: for each zero test.
    """
    found = Found()
    for name in KINDS:
        kind = _kind(name, given.space, list(given.formulas))
        formulas = [given.formulas[h] for h in kind.held]
        independent = sp.Matrix(formulas).jacobian(kind.gone).det(method="berkowitz")
        if isinstance(given.space.vanishes(independent, seconds), Zero):
            words = listed_names([*(s.name for s in kind.kept), *kind.held])
            found.why_not[name] = f"{words} are not independent variables"
        elif given.psi.has(sp.Integral):
            found.why_not[name] = "psi was not integrated in closed form"
        else:
            _search(name, kind, given, found, seconds)
    return found


def _search(name: str, kind: _Kind, given: Generating, found: Found, seconds: float) -> None:
    letters = {h: sp.Symbol(h, real=True) for h in kind.held}
    equations = [given.formulas[h] - letter for h, letter in letters.items()]
    value = given.psi
    new, n = list(given.formulas.values()), len(given.space.pairs)
    if name in ("F2", "F4"):
        value += sp.Add(*(a * b for a, b in zip(new[:n], new[n:], strict=True)))
    if name in ("F3", "F4"):
        value -= given.valence * sp.Add(*(q * p for q, p in given.space.pairs))
    for solution in solutions(equations, kind.gone):
        F = _shorter(sp.expand_mul(value.xreplace(solution)))
        for positive in (False, True):
            if _holds(F, kind, letters, given, seconds, positive=positive):
                found.functions[name] = F
                found.where[name] = "where every variable without a declared domain is positive" if positive else ""
                return
    words = listed_names(s.name for s in kind.gone)
    found.why_not[name] = (
        f"no solution of the formulas of {listed_names(kind.held)} for {words} was proved on the whole domain; declare "
        "with domains={…} where one branch holds"
    )


def _shorter(F: sp.Expr) -> sp.Expr:
    """Of the function and sympy's simplification the shorter one; which it is is verified afterwards."""
    if sp.count_ops(F) > MOST_OPERATIONS:
        return F
    simple = in_time(SECONDS_TO_SIMPLIFY, lambda: sp.simplify(F))
    return F if simple is None else min(F, simple, key=sp.count_ops)


def _holds(
    F: sp.Expr, kind: _Kind, letters: Mapping[str, sp.Symbol], given: Generating, seconds: float, *, positive: bool
) -> bool:
    """Return whether μ·gone = ± ∂F/∂kept and other = ± ∂F/∂held, proved with the map put in."""
    back = {letter: given.formulas[h] for h, letter in letters.items()}
    pairs = zip(kind.kept, kind.gone, strict=True)
    residuals = [given.valence * g - kind.old_sign * sp.diff(F, k).xreplace(back) for k, g in pairs]
    residuals += [
        given.formulas[other] - kind.new_sign * sp.diff(F, letters[h]).xreplace(back)
        for h, other in zip(kind.held, kind.other, strict=True)
    ]
    if not positive:
        return all(isinstance(given.space.vanishes(r, seconds), Zero) for r in residuals)
    bounds = given.space.bounds
    free = {
        x: sp.Symbol(x.name, positive=True)
        for pair in (*given.space.pairs, (given.space.time,))
        for x in pair
        if bounds.get(x, (None, None)) == (None, None)
    }
    return all(isinstance(is_zero(r.xreplace(free), budget=seconds), Zero) for r in residuals)


def solutions(equations: Sequence[sp.Expr], unknowns: Sequence[sp.Symbol]) -> list[dict[sp.Symbol, sp.Expr]]:
    """Return the solutions that sympy finds, none where the equations are long, of no known kind, or take too long.

    Args:
        equations: what has to vanish.
        unknowns: as many symbols.
    """
    if sum(int(sp.count_ops(e)) for e in equations) > MOST_OPERATIONS:
        return []
    try:
        found = in_time(SECONDS_TO_SOLVE, lambda: sp.solve(list(equations), list(unknowns), dict=True))
    except NotImplementedError:
        return []
    if found is None:
        return []
    whole = [s for s in found if set(s) == set(unknowns)]
    signed = [{x: v.replace(sp.Abs, lambda a: a) for x, v in s.items()} for s in whole]  # which sign is verified later
    strange = (sp.I, sp.Piecewise, sp.Abs, *unknowns)
    return [s for s in signed if not any(v.has(*strange) for v in s.values())]


def map_of(
    given: object, new: Mapping[str, str], space: PhaseSpace, seconds: float
) -> tuple[dict[str, sp.Expr], sp.Expr]:
    """Solve a map from a generating function; its relations are verified, whatever solved them.

    Returns:
        The map, and its ψ(q, p, t): F₁, F₂ − Σ QP, F₃ + Σ qp or F₄ − Σ QP + Σ qp with the map put in.

    Args:
        given: kind → function.
        new: new coordinate → its momentum.
        space: of the old variables.
        seconds: for each zero test.

    Raises:
        InvalidInputError: another kind, a function of other variables, or no map was found.
        ExpressionError: the function cannot be read.
    """
    if not isinstance(given, Mapping) or len(given) != 1 or next(iter(given)) not in KINDS:
        raise InvalidInputError(f'generating: one of F1, F2, F3, F4 is needed, {{"F2": "P*q"}}, not {described(given)}')
    ((name, formula),) = given.items()
    names = [*new, *new.values()]
    if len(names) != 2 * len(space.pairs):
        raise InvalidInputError(f"new: {len(space.pairs)} pairs are needed")
    own, _ = new_names(names, space.symbols, "new")
    kind = _kind(name, space, names)
    allowed = {n: s for n, s in space.symbols.items() if s not in kind.gone} | {h: own[h] for h in kind.held}
    F = read_formula(formula, allowed, name)
    equations = [g - kind.old_sign * sp.diff(F, k) for k, g in zip(kind.kept, kind.gone, strict=True)]
    held = [own[h] for h in kind.held]
    for solution in solutions(equations, held):
        if not all(isinstance(space.vanishes(e.xreplace(solution), seconds), Zero) for e in equations):
            continue
        values = {h: solution[own[h]] for h in kind.held}
        for h, other in zip(kind.held, kind.other, strict=True):
            values[other] = (kind.new_sign * sp.diff(F, own[h])).xreplace(solution)
        values = {n: short(value, space) for n, value in values.items()}
        ψ = F.xreplace(solution)
        if name in ("F2", "F4"):
            ψ -= sp.Add(*(values[Q] * values[P] for Q, P in new.items()))
        if name in ("F3", "F4"):
            ψ += sp.Add(*(q * p for q, p in space.pairs))
        return {n: values[n] for n in names}, ψ
    raise InvalidInputError(
        f"{name}: its equations could not be solved for {listed_names(kind.held)}; give the map itself, or a domain of "
        "the variables on which one solution holds"
    )
