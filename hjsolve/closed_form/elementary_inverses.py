"""x as a function of ∫ du/√(Au² + Bu + C): a + b cos, p/(1 + e cos), their hyperbolic twins, a square, an exponential.

With the centre c = −B/2A and half the distance of the roots, h = √(B²/4 − AC)/|A|, u = c + h cos ψ between two roots,
u = c ± h cosh ψ outside, u = c + h sinh ψ where there are none; ψ = √|A| (v − v_p). In u = 1/(x − r) these are the
conics x = r + p/(1 + e cos ψ), p = 1/c, e = h/c. Greenwood (5-122).
"""

from __future__ import annotations

import sympy as sp

from hjsolve.closed_form.elementary import Antiderivative, BasicIntegral, positive_root
from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities, Phase, sign_of_factors
from hjsolve.closed_form.pieces import monotone_inverse
from hjsolve.closed_form.tidy import one_and_product, shortened_powers, square_root
from hjsolve.errors import required

_CENTRED = {"arcsine": sp.cos, "area sine": sp.sinh, "area cosine right": sp.cosh, "area cosine left": sp.cosh}


def elementary_inverse(basic: BasicIntegral, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities) -> sp.Expr:
    """Return the x at which an integral from a place has a value.

    Args:
        basic: the integral.
        amount: the value.
        begin: the place, an x.
        names: of the quantities of the form.
    """
    A, _, C = basic.quadratic
    # ∫ dx/((r² − x²) √P) of an even P: sin of the amount is a multiple of x/√P, solved for x
    if basic.kind == "pair":
        κ, r = basic.rate, basic.pole
        # written by 1 − x²/r², which is known not to be zero within the motion
        level = monotone_inverse(κ * begin / (positive_root(C) * sp.sqrt(1 - begin**2 / r**2)))
        sine = sp.sin(Phase(names, amount, κ * r**2, sp.asin(level), even=False).argument)
        return sine / sp.sqrt(sp.factor(κ**2 / C) + sine**2 / r**2)
    # u = 1/(x − r) falls where x grows
    u_0, direction = basic.variable(begin), -basic.side
    if basic.kind in _CENTRED:
        return _centred(basic, direction * amount, u_0, names)
    if basic.kind == "root":
        u = _squared(basic, direction * amount, u_0, names)
    elif basic.kind == "line":
        u = u_0 + sp.expand(positive_root(C) * direction * amount)
    else:
        # ∫ du/√(A u²) is a logarithm
        u = u_0 * sp.exp(sp.expand(basic.sign_of_u * direction * positive_root(A) * amount))
    return u if basic.place is None else basic.place + 1 / u


def separatrix_inverse(
    law: Antiderivative, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities
) -> sp.Expr | None:  # fmt: skip
    """Return the x at which w ln |(x − r₁)/(x − r₂)| has a value.

    The middle of r₁ and r₂ and half their distance times tanh between them, times coth outside.

    Args:
        law: the integral; of two logarithms with opposite weights.
        amount: the value.
        begin: the place, an x.
        names: of the quantities of the form.

    Returns:
        The place; None of any other integral.
    """
    logarithms = [
        (w, t) for w, t in law.terms if isinstance(t, BasicIntegral) and t.kind == "logarithm" and t.place is not None
    ]
    if law.algebraic != 0 or len(law.terms) != 2 or len(logarithms) != 2:
        return None
    (w, one), (w_2, other) = logarithms
    if one.quadratic[0] != other.quadratic[0] or sp.cancel(w + w_2) != 0:
        return None
    outside = one.side == other.side
    if one.side < 0 and not outside:
        (w, one), (w_2, other) = (w_2, other), (w, one)
    low, high = required(one.place), required(other.place)
    # (x − r₁)/(x − r₂) = −e^{…} is tanh, + e^{…} is coth: the sign is that of the place
    middle, h = sp.cancel((low + high) / 2), sp.cancel((high - low) / 2)
    function, inverse = (sp.coth, sp.acoth) if outside else (sp.tanh, sp.atanh)
    factor, start = positive_root(one.quadratic[0]) / (2 * w), inverse((begin - middle) / h)
    return middle + h * function(Phase(names, amount, factor, start, even=False).argument)


def power_inverse(law: Antiderivative, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities) -> sp.Expr | None:
    """Return the x at which c xᵏ √(Bx) has a value: a power of the time, Kepler's parabola on a line for k = −2.

    Args:
        law: the integral, algebraic, deg P = 1.
        amount: the value.
        begin: the place, an x.
        names: of the quantities of the form.

    Returns:
        The place; None of any other integral.
    """
    x = law.x
    B, C = sp.Poly(law.polynomial, x).all_coeffs()
    c, power = sp.factor(law.algebraic).as_independent(x, as_Add=False)
    k = 0 if power == 1 else power.as_base_exp()[1]
    if C != 0 or k == 0 or power != x**k or not sp.sympify(k).is_Integer:
        return None
    start = shortened_powers(c * begin**k * positive_root(B * begin))
    argument = Phase(names, amount, sp.S.One, start, even=True).argument
    size = sp.factor(sp.cancel(c**2 * sp.Abs(B)))
    return sign_of_factors(B) * ((argument**2) ** sp.Rational(1, 2 * k + 1) * size ** sp.Rational(-1, 2 * k + 1))


def cubic_inverse(law: Antiderivative, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities) -> sp.Expr | None:
    """Return the x at which (a x + b) √(Bx + C) has a value: a cubic α y³ + β y in the root y = √(Bx + C).

    Along a motion the cubic is monotone in y, which is negative after the turning point. With 3 α s² = |β| and
    w = 2 |β| s/3 its root is y = 2 s sinh(⅓ arsinh(v/w)) where α β > 0, y = 2 s sin(⅓ arcsin(v/w)) with |y| < s where
    α β < 0 (Viète), and a cube root where β = 0.

    Args:
        law: the integral, algebraic, deg P = 1, deg a = 1.
        amount: the value.
        begin: the place, an x.
        names: of the quantities of the form.

    Returns:
        The place; None of any other integral, and where α β < 0 and |y| > s.
    """
    x = law.x
    B, C = sp.Poly(law.polynomial, x).all_coeffs()
    if not law.algebraic.is_polynomial(x) or sp.degree(law.algebraic, x) != 1:
        return None
    slope, constant = sp.Poly(law.algebraic, x).all_coeffs()
    α, β = sp.factor(slope / B), sp.factor(sp.cancel(constant - slope * C / B))
    y_0 = positive_root(B * begin + C)
    if β == 0:
        cube = Phase(names, amount, sp.S.One, α * y_0**3, even=True).argument
        return ((cube**2 / α**2) ** sp.Rational(1, 3) - C) / B
    ratio, numbers = sp.factor(β / (3 * α)), names.numbers | names.located
    growing = number_of(ratio, numbers) > 0
    s = names.named("s", square_root(ratio if growing else -ratio), short=SHORT, positive=True)
    if not growing and number_of(names.written_out(y_0 - s), numbers) > 0:
        return None
    function, inverse = (sp.sinh, sp.asinh) if growing else (sp.sin, sp.asin)
    level = 3 * (α * y_0**3 + β * y_0) / (2 * β * s)
    third = inverse(Phase(names, amount, 3 / (2 * β * s), level, even=True).argument) / 3
    return (4 * s**2 * function(third) ** 2 - C) / B


def square_root_inverse(
    law: Antiderivative, side: int, amount: sp.Expr, begin: sp.Expr, names: NamedQuantities
) -> sp.Expr:  # fmt: skip
    """Return the x at which a √(Ax² + Bx + C) has a value: c ± √(h² + (v − v_p)²…), the hyperbolic motion.

    Args:
        law: the integral, a multiple of √P, deg P = 2.
        side: on which side of the middle of the roots x is.
        amount: the value.
        begin: the place, an x.
        names: of the quantities of the form.
    """
    C, B, A = (sp.Poly(law.polynomial, law.x).coeff_monomial(law.x**k) for k in range(3))
    middle, square = sp.cancel(-B / (2 * A)), sp.expand(sp.cancel(B**2 / (4 * A**2) - C / A))
    start = positive_root(sp.sympify(law.polynomial).subs(law.x, begin))
    # a √P is linear in the variable: P = A ((x − c)² − h²) is solved for x − c
    root = Phase(names, amount, 1 / law.algebraic, start, even=True).argument
    return middle + side * sp.sqrt(sp.factor(square) + root**2 / A)


def _centred(basic: BasicIntegral, amount: sp.Expr, u_0: sp.Expr, names: NamedQuantities) -> sp.Expr:
    """About the middle of the roots of Q."""
    A, B, C = basic.quadratic
    centre, square = sp.cancel(-B / (2 * A)), sp.expand(sp.cancel(B**2 / (4 * A**2) - C / A))
    square = -square if basic.kind == "area sine" else square
    side = -1 if basic.kind == "area cosine left" else 1
    function, rate = _CENTRED[basic.kind], positive_root(-A if basic.kind == "arcsine" else A)
    if basic.place is None or centre == 0:
        h = names.named("a", square_root(square), positive=True)
        middle = names.named("c", centre, short=3 * SHORT)
        level = side * (u_0 - middle) / h
        if basic.place is not None:
            d = names.named("d", 1 / square_root(square), positive=True)
            level = side * u_0 * d
    else:
        # p = 1/c and e = h/c: what a book calls latus rectum and eccentricity
        h = side * _eccentricity(basic, names)
        p = names.named("p", sp.factor(1 / centre))
        level = (p * u_0 - 1) / h
    begin = {sp.cos: -sp.acos(level), sp.sinh: sp.asinh(level), sp.cosh: side * sp.acosh(level)}[function]
    wave = function(Phase(names, amount, rate, begin, even=function is not sp.sinh).argument)
    if basic.place is None:
        return middle + side * h * wave
    return basic.place + (side * d / wave if centre == 0 else p / (1 + h * wave))


def _eccentricity(basic: BasicIntegral, names: NamedQuantities) -> sp.Expr:
    """h/c."""
    A, B, C = basic.quadratic
    square = one_and_product(1 - 4 * A * C / B**2)
    square = -square if basic.kind == "area sine" else square
    sign = sign_of_factors(sp.factor(B)) * (1 if basic.kind == "arcsine" else -1)
    return sign * names.named("e", sp.sqrt(square), positive=True)


def _squared(basic: BasicIntegral, amount: sp.Expr, u_0: sp.Expr, names: NamedQuantities) -> sp.Expr:
    """√(Bu + C) grows evenly: u is a square."""
    _, B, C = basic.quadratic
    root = positive_root(B * u_0 + C)
    argument = Phase(names, amount, sp.S.One, 2 * root / B, even=True).argument
    return sp.cancel(-C / B) + B / 4 * argument**2


def accelerated(
    names: NamedQuantities, u_0: sp.Expr, running: sp.Expr, v: sp.Symbol, root: sp.Expr, B: sp.Expr
) -> sp.Expr:  # fmt: skip
    """u₀ + √(Bu₀ + C) s + (B/4) s², a parabola in the variable v of which s is a linear function.

    Args:
        names: of the quantities of the form.
        u_0: where it begins.
        running: s.
        v: the variable.
        root: √(Bu₀ + C).
        B: the slope of the radicand.
    """
    α = sp.factor_terms(running.coeff(v))
    start = sp.expand(sp.cancel((α * v - running) / α))
    shift = v - start
    letter = "v" if v.name in ("t", "tau") else "slope"
    velocity = names.named(
        f"{letter}_{u_0.name.removesuffix('_0')}" if u_0.is_Symbol else letter, root * α, short=SHORT
    )
    return u_0 + velocity * shift + sp.factor(sp.cancel(B * α**2 / 4)) * shift**2
