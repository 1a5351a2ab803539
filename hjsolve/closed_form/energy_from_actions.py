"""H(J), α(J): the constants as functions of the actions, where J(E, α) can be solved for them one by one."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.closed_form.curves import named_constants
from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.form_context import FormContext
from hjsolve.closed_form.named_quantities import NamedQuantities
from hjsolve.closed_form.regime import Regime, settled
from hjsolve.closed_form.tidy import elliptic, plain_roots
from hjsolve.closed_form.why_not import NotFound, WhyNot
from hjsolve.precision import mp

MOST_OPERATIONS = 120
"""Of E(J): nobody reads a longer one, and its parts take sympy seconds."""
_DIGITS, _AGREE = 60, 40
"""Digits at the example, and those in which a root of the equation is the constant: 20 are left to cancellation."""


def solved_for_constants(
    context: FormContext, actions: Mapping[str, sp.Expr], made: Regime, names: NamedQuantities,
    why_not: dict[str, WhyNot],
) -> dict[str, sp.Expr]:  # fmt: skip
    """Solve J_i(E, α, c) one constant after the other, as far as each equation holds only one that is not known.

    Args:
        context: of the solution.
        actions: coordinate → J.
        made: the regime.
        names: of the quantities in the actions.
        why_not: gets the reason where there is none.

    Returns:
        Constant → its formula in symbols J_<coordinate>, and in momenta of ignorable coordinates that are no angles, E
        first; empty where E was not found, or another coordinate has no action.
    """
    constants, system = context.constants, context.solution.system
    # of a line there is no J: p itself is conserved, as in Landau's levels, which drift across crossed fields
    lines = {c.momentum for c in context.solution.separation.shell.ignorable if c.domain.kind != "angle"}
    if made.special or not actions:
        return {}
    if any(c.name not in actions and c.momentum not in lines for c in system.coordinates):
        return {}
    named = {c.name: sp.Symbol(f"J_{c.name}", real=True) for c in system.coordinates}
    actions = {name: settled(made, names.written_out(action)) for name, action in actions.items()}
    known, left = {p: sp.sympify(p) for p in lines}, dict(actions)
    while left:
        step = _next(left, known, constants) or _linear(left, known, constants)
        if step is None:
            why_not["energy"] = NotFound(_unsolved(left, constants))
            return {}
        name, unknown = step
        solved = _solved(left.pop(name).xreplace(known), named[name], unknown, names, actions, named)
        if solved is None:
            why_not["energy"] = NotFound(_unsolved({name: actions[name]}, [unknown]))
            return {}
        known = {c: e.xreplace({unknown: solved}) for c, e in known.items()} | {unknown: solved.xreplace(known)}
    if constants[0] not in known:
        return {}
    positive = {named[n]: sp.Dummy(positive=True) for n, kind in made.kinds.items() if kind == "libration"}
    found: dict[str, sp.Expr] = {}
    for constant in constants:
        if constant not in lines and (value := known.get(constant)) is not None:
            value = sp.factor(value) if value.is_rational_function() else value
            value = _of_whole_squares(value, names, actions, named)
            back = {d: J for J, d in positive.items()}
            found[constant.name] = settled(made, value.xreplace(positive)).xreplace(back)
    return found


def _linear(
    left: Mapping[str, sp.Expr], known: Mapping[sp.Symbol, sp.Expr], constants: list[sp.Symbol]
) -> tuple[str, sp.Symbol] | None:  # fmt: skip
    """Return an action of first degree in a separation constant: it is solved for it, whatever else it holds."""
    for name, action in left.items():
        for c in () if elliptic(action) else constants[1:]:
            slope = sp.diff(action.xreplace(dict(known)), c)
            if c not in known and slope != 0 and not slope.has(c):
                return name, c
    return None


def _unsolved(left: Mapping[str, sp.Expr], constants: list[sp.Symbol]) -> str:
    """Return why actions are not solved for the constants."""
    for name, action in left.items():
        if elliptic(action):
            held = ", ".join(str(c) for c in constants if action.has(c))
            return f"J_{name} is made of complete elliptic integrals, a transcendental equation for {held}"
    names = ", ".join(f"J_{name}" for name in left)
    return f"{names} could not be solved for {', '.join(map(str, constants))}"


def _next(
    left: Mapping[str, sp.Expr], known: Mapping[sp.Symbol, sp.Expr], constants: list[sp.Symbol]
) -> tuple[str, sp.Symbol] | None:  # fmt: skip
    """Return an action that holds one constant that is not known yet."""
    for name, action in left.items():
        unknown = [c for c in constants if action.has(c) and c not in known]
        if len(unknown) == 1 and sp.count_ops(action) <= MOST_OPERATIONS:
            return name, unknown[0]
    return None


def _solved(
    action: sp.Expr, J: sp.Symbol, unknown: sp.Symbol, names: NamedQuantities, actions: Mapping[str, sp.Expr],
    named: Mapping[str, sp.Symbol],
) -> sp.Expr | None:  # fmt: skip
    """Return the root of J = action(unknown) that is right at the regime's example, to 30 digits."""
    # p_φ is its own action: J is the constant itself
    if action == unknown:
        return J
    if elliptic(action) or action.free_symbols & names.roots:
        return None
    slope = sp.diff(action, unknown)
    if slope != 0 and not slope.has(unknown):
        return _right_one([J / slope - sp.expand((action - slope * unknown) / slope)], names, actions, named, unknown)
    radicals = [p for p in action.atoms(sp.Pow) if p.has(unknown) and p.exp.is_Rational and not p.exp.is_Integer]
    bases = {p.base for p in radicals}
    if any(a.has(unknown) for a in action.atoms(sp.Function)):
        return None
    found: list[sp.Expr] = []
    if not bases:
        if not action.is_rational_function(unknown):
            return None
        found = _roots(sp.numer(sp.together(action - J)), unknown)
    elif len(bases) == 1:
        (base,) = bases
        if sp.Poly(base, unknown).degree() != 1:
            found = _without_root(action - J, base, radicals, unknown)
            return _right_one(found, names, actions, named, unknown)
        z, step = sp.Dummy("z", positive=True), sp.ilcm(1, *(p.exp.q for p in radicals))
        b, c = sp.Poly(base, unknown).all_coeffs()
        back = (z**step - c) / b
        plain = action.xreplace({p: z ** (step * p.exp) for p in radicals}).subs(unknown, back)
        if not plain.is_rational_function(z):
            return None
        found = [back.subs(z, root) for root in _roots(sp.numer(sp.together(plain - J)), z)]
    elif (nested := _of_nested_roots(action - J, radicals, unknown)) is not None:
        found = nested
    elif (power := _power_of(action, unknown)) is not None:
        found = [side * (J / action.subs(unknown, side)) ** (1 / power) for side in (1, -1)]
    elif len(bases) == 2:
        found = _of_two_roots(action - J, sorted(radicals, key=sp.default_sort_key), unknown)
    return _right_one(found, names, actions, named, unknown)


def _power_of(action: sp.Expr, unknown: sp.Symbol) -> sp.Expr | None:
    """Return s of J = K Eˢ, a product of powers of multiples of E; None of another J."""
    factors = [f.as_base_exp() for f in sp.Mul.make_args(action) if f.has(unknown)]
    if any(sp.cancel(base / unknown).has(unknown) for base, _ in factors):
        return None
    total = sp.Add(*(power for _, power in factors))
    return total if total.is_Rational and total != 0 else None


def _of_nested_roots(equation: sp.Expr, radicals: list[sp.Pow], unknown: sp.Symbol) -> list[sp.Expr] | None:
    """Return the roots of α √(b + c √d) + γ = 0, squared once; None of another equation (Rosen and Morse, Scarf)."""
    # J + … = √(b + c √(E₀ − E)): one squaring gives √d, a second E
    outer = [p for p in radicals if any(p.base.has(other) for other in radicals)]
    if len(outer) != 1 or outer[0].exp != sp.S.Half:
        return None
    z, (root,) = sp.Dummy("z"), outer
    plain = sp.expand(equation.xreplace({root: z}))
    α, γ = plain.coeff(z), plain.subs(z, 0)
    inner = [p for p in radicals if p is not root]
    if plain.has(unknown) or sp.expand(plain - α * z - γ) != 0 or len({p.base for p in inner}) != 1:
        return None
    # for the inner square root, so that the outer one is the root of a polynomial in w
    w = sp.Dummy("w", positive=True)
    roots = _without_root(root.base - w**2, inner[0].base, inner, unknown)
    return [sp.apart(root, w).xreplace({w: sp.factor(-γ / α)}) for root in roots if root.is_rational_function(w)]


def _of_two_roots(equation: sp.Expr, radicals: list[sp.Pow], unknown: sp.Symbol) -> list[sp.Expr]:
    """Return the root of α (√b₁ ± √b₂) + γ = 0 with b₁ − b₂ = d free of it.

    2 √b₁ = w + d/w, w = −γ/α (Rosen and Morse).
    """
    if len(radicals) != 2 or any(p.exp != sp.S.Half or sp.degree(p.base, unknown) != 1 for p in radicals):
        return []
    y, z = sp.symbols("y z", positive=True)
    # α y + β z + γ with y² − (β/α)² z² = d: then y + (β/α) z = w gives y − (β/α) z = d/w
    plain = sp.expand(equation.xreplace(dict(zip(radicals, (y, z), strict=True))))
    α, β, γ = plain.coeff(y), plain.coeff(z), plain.subs({y: 0, z: 0})
    b, c = (p.base for p in radicals)
    one, other = (sp.diff(e, unknown) for e in (b, c))
    if plain.has(unknown) or α == 0 or sp.expand(plain - α * y - β * z - γ) != 0:
        return []
    if sp.cancel(α**2 * one - β**2 * other) != 0:
        return []
    w, d = -γ / α, sp.expand(b - (β / α) ** 2 * c)
    w = sp.factor(w)
    return [(w**2 + (d / w) ** 2) / (4 * one) + sp.cancel((d / 2 - b.subs(unknown, 0)) / one)]


def _without_root(
    equation: sp.Expr, base: sp.Expr, radicals: list[sp.Pow], unknown: sp.Symbol
) -> list[sp.Expr]:  # fmt: skip
    """Return the roots of an equation with one square root in it, squared: Sommerfeld's energy."""
    if any(p.exp.q != 2 for p in radicals) or not base.is_polynomial(unknown):
        return []
    z = sp.Dummy("z")
    plain = sp.together(equation.xreplace({p: z ** (2 * p.exp) for p in radicals}))
    w, even = sp.Dummy("w"), sp.Poly(base, unknown)
    # Sommerfeld: J holds E/√(m²c⁴ − E²) alone, so that E = w √(…) with w rational in J
    homogeneous = sp.cancel(plain.subs(unknown, w * z))
    if not homogeneous.has(z) and sp.degree(sp.numer(homogeneous), w) == 1 and even.coeff_monomial(unknown) == 0:
        w_J = plain_roots(sp.solve_linear(homogeneous, symbols=[w])[1])  # E = w √(b E² + c)
        b, c = even.coeff_monomial(unknown**2), even.coeff_monomial(1)
        return [side * sp.sqrt(sp.factor(c)) / sp.sqrt(w_J**-2 - b) for side in (1, -1)]
    top = sp.numer(plain)
    if not top.is_polynomial(z) or sp.degree(top, z) != 1:
        return []
    # α z + γ = 0 squared, α² z² = γ²: a root that the first equation does not have is left out by ``_right_one``
    one, zero = sp.Poly(top, z).all_coeffs()
    return _roots(sp.expand(one**2 * base - zero**2), unknown)


def _right_one(
    found: list[sp.Expr], names: NamedQuantities, actions: Mapping[str, sp.Expr], named: Mapping[str, sp.Expr],
    unknown: sp.Symbol,
) -> sp.Expr | None:  # fmt: skip
    """Return the root that is right at the regime's example, to 40 digits."""
    numbers = dict(names.numbers)
    with mp.workdps(_DIGITS):
        numbers |= {named[name]: number_of(other, numbers) for name, other in actions.items()}
        # squaring has brought in false roots: the right one is E at the example, to 40 digits
        for root in found:
            got = number_of(root, numbers)
            if mp.isfinite(got) and abs(got - numbers[unknown]) <= abs(got) * mp.mpf(10) ** -_AGREE:
                return min((root, sp.factor(root)), key=sp.count_ops)
    return None


def _of_whole_squares(
    value: sp.Expr, names: NamedQuantities, actions: Mapping[str, sp.Expr], named: Mapping[str, sp.Symbol]
) -> sp.Expr:  # fmt: skip
    """Return a formula with J + s in place of √(J² + 2Js + s²), whatever root s is; by its sign at the example."""
    with mp.workdps(_DIGITS):
        numbers = dict(names.numbers)
        numbers |= {named[name]: number_of(other, numbers) for name, other in actions.items()}

        def plain(power: sp.Pow) -> sp.Expr:
            for J in named.values():
                if not (power.base.is_polynomial(J) and sp.degree(power.base, J) == 2):
                    continue
                a, b, c = sp.Poly(power.base, J).all_coeffs()
                if not a.is_positive or sp.expand(b**2 - 4 * a * c) != 0:
                    continue
                inner = J + sp.expand(b / (2 * a))
                side = 1 if number_of(inner, numbers) > 0 else -1
                return (sp.sqrt(a) * side * inner) ** (2 * power.exp)
            return power

        return value.replace(lambda e: e.is_Pow and e.base.is_Add and e.exp.is_Rational and e.exp.q == 2, plain)


def _roots(polynomial: sp.Expr, unknown: sp.Symbol) -> list[sp.Expr]:
    """Return the roots of factors of the first and second degree, and the positive root of a pure power."""
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
        # E^n = value: of the powers (J^{2n/(n+2)} of a power potential) the positive root
        elif not any(coefficients[1:-1]):
            found.append((-coefficients[-1] / coefficients[0]) ** sp.Rational(1, len(coefficients) - 1))
    return [root.xreplace(back) for root in found]
