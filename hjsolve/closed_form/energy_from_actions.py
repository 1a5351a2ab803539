"""H(J): the energy as a function of the actions, where the actions can be solved for the constants one by one."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.closed_form.curves import named_constants
from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.closed_form.regime import Regime
from hjsolve.closed_form.workshop import Workshop
from hjsolve.precision import mp

MOST_OPERATIONS = 120
_DIGITS, _AGREE = 60, 40


def solved_for_energy(
    shop: Workshop, actions: Mapping[str, sp.Expr], made: Regime, why_not: dict[str, str]
) -> sp.Expr | None:  # fmt: skip
    """Solve J_i(E, α, c) one constant after the other, as far as each equation holds only one that is not known.

    Args:
        shop: of the solution.
        actions: coordinate → J.
        made: the regime.
        why_not: gets the reason where there is none.

    Returns:
        E in terms of symbols J_<coordinate>; None where it was not found, or a coordinate has no action.
    """
    constants, system = shop.constants, shop.solution.system
    if made.special or any(c.name not in actions for c in system.coordinates):
        return None
    named = {c.name: sp.Symbol(f"J_{c.name}", real=True) for c in system.coordinates}
    known, left = dict[sp.Symbol, sp.Expr](), dict(actions)
    while left:
        step = _next(left, known, constants)
        if step is None:
            why_not["energy"] = "the actions could not be solved for the constants in closed form"
            return None
        name, unknown = step
        solved = _solved(left.pop(name).xreplace(known), named[name], unknown, made, actions, named)
        if solved is None:
            why_not["energy"] = f"J_{name} could not be solved for {unknown} in closed form"
            return None
        known[unknown] = solved.xreplace(known)
    energy = known.get(constants[0])
    if energy is None:
        return None
    return sp.factor(energy) if energy.is_rational_function() else energy


def _next(
    left: Mapping[str, sp.Expr], known: Mapping[sp.Symbol, sp.Expr], constants: list[sp.Symbol]
) -> tuple[str, sp.Symbol] | None:  # fmt: skip
    """An action that holds one constant that is not known yet."""
    for name, action in left.items():
        unknown = [c for c in constants if action.has(c) and c not in known]
        if len(unknown) == 1 and sp.count_ops(action) <= MOST_OPERATIONS:
            return name, unknown[0]
    return None


def _solved(
    action: sp.Expr, J: sp.Symbol, unknown: sp.Symbol, made: Regime, actions: Mapping[str, sp.Expr],
    named: Mapping[str, sp.Symbol],
) -> sp.Expr | None:  # fmt: skip
    """The root of J = action(unknown) that is right at the regime's example, to 30 digits."""
    if action == unknown:
        return J
    radicals = [p for p in action.atoms(sp.Pow) if p.has(unknown) and p.exp.is_Rational and not p.exp.is_Integer]
    bases = {p.base for p in radicals}
    if action.atoms(sp.Function) - action.atoms(sp.Abs, sp.sign) or any(
        a.has(unknown) for a in action.atoms(sp.Abs, sp.sign)
    ):
        return None
    found: list[sp.Expr] = []
    if not bases:
        if not action.is_rational_function(unknown):
            return None
        found = _roots(sp.numer(sp.together(action - J)), unknown)
    elif len(bases) == 1:
        (base,) = bases
        if sp.Poly(base, unknown).degree() != 1:
            return None
        z, step = sp.Dummy("z", positive=True), 2
        b, c = sp.Poly(base, unknown).all_coeffs()
        back = (z**step - c) / b
        plain = action.xreplace({p: z ** (step * p.exp) for p in radicals}).subs(unknown, back)
        if not plain.is_rational_function(z):
            return None
        found = [back.subs(z, root) for root in _roots(sp.numer(sp.together(plain - J)), z)]
    numbers = many_digits(made.example, _DIGITS)
    with mp.workdps(_DIGITS):
        numbers |= {named[name]: number_of(other, numbers) for name, other in actions.items()}
        for root in found:
            got = number_of(root, numbers)
            if mp.isfinite(got) and abs(got - numbers[unknown]) <= abs(got) * mp.mpf(10) ** -_AGREE:
                return sp.factor(root)
    return None


def _roots(polynomial: sp.Expr, unknown: sp.Symbol) -> list[sp.Expr]:
    """The roots of factors of the first and second degree."""
    found = list[sp.Expr]()
    bare, back = named_constants(sp.expand(polynomial), unknown)
    if not bare.is_polynomial(unknown):
        return []
    for factor, _ in sp.factor_list(sp.numer(sp.together(bare)), unknown)[1]:
        coefficients = sp.Poly(factor, unknown).all_coeffs()
        if len(coefficients) == 2:
            found.append(-coefficients[1] / coefficients[0])
        elif len(coefficients) == 3:
            a, b, c = coefficients
            root = sp.sqrt(sp.factor(b**2 - 4 * a * c))
            found += [(-b + root) / (2 * a), (-b - root) / (2 * a)]
    return [root.xreplace(back) for root in found]
