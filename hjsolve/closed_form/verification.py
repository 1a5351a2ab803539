"""Every integral is verified twice before it is shown: differentiated, and compared with the quadrature to 40 digits.

The quadrature is of N(q)/√P²(q) in the user's own coordinate, at exact constants of the regime; it knows nothing of
variables, roots or regimes. Between turning points q = m − h cos χ makes the integrand smooth and periodic, and equally
spaced nodes converge geometrically; inside, Gauss's rule on pieces.
"""

from __future__ import annotations

from collections.abc import Callable

import mpmath
import sympy as sp

from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral
from hjsolve.functions import modules

DIGITS, WORK = 40, 60
_MOST = 4096
_SHORT = 250


def flaw(piece: CoordinateIntegrals, key: sp.Symbol) -> str | None:
    """What is wrong with an integral; None where it passes.

    Args:
        piece: the coordinate's integrals in a regime, with the sample they are tried at.
        key: which of them.
    """
    integral = piece.integrals[key]
    if integral.law is not None and integral.law.residual(integral.rational) != 0:
        return "not verified: its derivative was not proved to be the integrand"
    q = integral.curve.coordinate.symbol
    with mpmath.workdps(WORK):
        values = sample_numbers(piece)
        square = _function(integral.curve.substitution_square, q, values)
        numerator = _function(integral.numerator, q, values)
        form = _function(integral.value, q, values)
        slope = _slope(integral, form, values)
        low, high = monotone_span(piece, integral)

        def integrand(place: mpmath.mpf) -> mpmath.mpf:
            return numerator(place) / mpmath.sqrt(square(place))

        places = [low + (high - low) * mpmath.mpf(part) for part in ("0.31", "0.52", "0.77")]
        size = max(abs(integrand(place)) for place in places)
        if any(not _close(slope(place), integrand(place), size) for place in places):
            return "not verified: its derivative is not the integrand at a place tried"
        expected = mpmath.quad(integrand, mpmath.linspace(places[0], places[2], 5))
        got = form(places[2]) - form(places[0])
        size = max(abs(form(places[2])), abs(form(places[0])), abs(expected))
        if not _close(got, expected, size):
            return f"not verified: it is {mpmath.nstr(got, 20)} where the quadrature is {mpmath.nstr(expected, 20)}"
        if integral.cycle is None:
            return None
        expected, size = _cycle(piece, integral, square, numerator)
        got = _function(integral.cycle, q, values)(low)
        if not _close(got, expected, size):
            return f"not verified: a cycle gives {mpmath.nstr(got, 20)}, the quadrature {mpmath.nstr(expected, 20)}"
    return None


def _slope(
    integral: PieceIntegral, form: Callable[[mpmath.mpf], mpmath.mpf], values: dict[sp.Symbol, mpmath.mpf]
) -> Callable[[mpmath.mpf], mpmath.mpf]:  # fmt: skip
    """The derivative of a form: by rules where it is elementary; of a long elliptic one the difference quotient.

    At a distance of 1e-24 and with 115 digits it is right to 45.
    """
    q = integral.curve.coordinate.symbol
    if integral.law is not None or sp.count_ops(integral.value) < _SHORT:
        return _function(sp.diff(integral.value, q), q, values)

    def quotient(place: mpmath.mpf) -> mpmath.mpf:
        with mpmath.workdps(115):
            step = mpmath.mpf(10) ** -24
            return (form(place + step) - form(place - step)) / (2 * step)

    return quotient


def value_at(expression: sp.Expr, numbers: dict[sp.Symbol, mpmath.mpf]) -> mpmath.mpf:
    """An expression at numbers, by mpmath, in the precision that it works in.

    Args:
        expression: of a form.
        numbers: symbol → number, of every symbol.
    """
    symbols = sorted(expression.free_symbols, key=str)
    value = sp.lambdify(symbols, expression, modules=modules("mpmath"))(*(numbers[s] for s in symbols))
    value = mpmath.mpmathify(value)
    small = mpmath.mpf(10) ** -45
    real = not isinstance(value, mpmath.mpc) or abs(value.imag) <= small * (1 + abs(value.real))
    return mpmath.mpf(value.real) if real else mpmath.nan


def sample_numbers(piece: CoordinateIntegrals) -> dict[sp.Symbol, mpmath.mpf]:
    """The parameters, constants and named roots of the sample as numbers.

    Args:
        piece: with the sample.
    """
    exact = piece.sample.values
    with mpmath.workdps(125):
        numbers = {s: mpmath.mpf(int(v.p)) / int(v.q) for s, v in exact.items()}
    for symbol, meaning in piece.where.items():
        if not isinstance(meaning, tuple):
            with mpmath.workdps(125):
                numbers[symbol] = value_at(meaning, numbers)
            continue
        polynomial, index = meaning
        with mpmath.workdps(125):
            coefficients = [mpmath.mpf(sp.N(c.xreplace(dict(exact)), 130)) for c in polynomial.all_coeffs()]
            roots = mpmath.polyroots(coefficients, maxsteps=300, extraprec=900)
            size = max(abs(r) for r in roots) * mpmath.mpf(10) ** -25
            numbers[symbol] = sorted(r.real for r in roots if abs(r.imag) <= size)[index]
    return numbers


def _close(one: mpmath.mpf, other: mpmath.mpf, size: mpmath.mpf) -> bool:
    if not (mpmath.isfinite(one) and mpmath.isfinite(other)) or isinstance(one, mpmath.mpc):
        return False
    return bool(abs(one - other) <= size * mpmath.mpf(10) ** (-DIGITS))


def _function(
    expression: sp.Expr, q: sp.Symbol, values: dict[sp.Symbol, mpmath.mpf]
) -> Callable[[mpmath.mpf], mpmath.mpf]:  # fmt: skip
    if expression.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        return lambda _: mpmath.nan
    symbols = [s for s in expression.free_symbols if s in values]
    compiled = sp.lambdify([q, *symbols], expression, modules=modules("mpmath"), cse=sp.count_ops(expression) < _SHORT)
    numbers = [values[s] for s in symbols]

    def function(place: mpmath.mpf) -> mpmath.mpf:
        try:
            value = mpmath.mpmathify(compiled(place, *numbers))
        except ZeroDivisionError:
            return mpmath.nan
        if isinstance(value, mpmath.mpc):
            return value.real if abs(value.imag) <= abs(value.real) * mpmath.mpf(10) ** -50 else mpmath.nan
        return value

    return function


def monotone_span(piece: CoordinateIntegrals, integral: PieceIntegral) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Two places between which the motion is free of turning points, inside the region.

    Args:
        piece: the coordinate.
        integral: with the curve on which the region is meant.
    """
    region = next(r for c, r in piece.regions if c is integral.curve)
    ends = [_end(region, side) for side in (region.lower, region.upper)]
    if ends[0] is None and ends[1] is None:
        x = [region.place - 1, region.place + 1]
        low, high = (
            mpmath.mpf(sp.N(e.xreplace(dict(piece.sample.values)), WORK)) if e.is_finite else None
            for e in (integral.curve.substitution.lower, integral.curve.substitution.upper)
        )
        x[0] = x[0] if low is None else (low + region.place) / 2
        x[1] = x[1] if high is None else (high + region.place) / 2
    else:
        other = region.place
        x = [ends[0] if ends[0] is not None else other, ends[1] if ends[1] is not None else other]
    q = sorted(_place(integral, end, piece) for end in x)
    return q[0], q[1]


def _end(region: object, side: tuple[str, int]) -> mpmath.mpf | None:
    return region.roots[side[1]] if side[0] == "root" else None  # type: ignore[attr-defined]


def _place(integral: PieceIntegral, x: mpmath.mpf, piece: CoordinateIntegrals) -> mpmath.mpf:
    s = integral.curve.substitution
    value = sp.N(s.inverse.subs(s.x, sp.Float(x, WORK)).xreplace(dict(piece.sample.values)), WORK)
    return mpmath.mpf(sp.re(value))


def _cycle(
    piece: CoordinateIntegrals, integral: PieceIntegral, square: Callable[[mpmath.mpf], mpmath.mpf],
    numerator: Callable[[mpmath.mpf], mpmath.mpf],
) -> tuple[mpmath.mpf, mpmath.mpf]:  # fmt: skip
    """∮ N dq/P by the midpoint rule, doubled until it no longer moves; and ∮ |N| dq/P."""
    region = next(r for c, r in piece.regions if c is integral.curve)
    if region.kind == "rotation":
        middle, half, whole = mpmath.mpf(0), mpmath.pi, True
    else:
        low, high = sorted(_place(integral, _end(region, side), piece) for side in (region.lower, region.upper))
        middle, half, whole = (low + high) / 2, (high - low) / 2, False

    def term(χ: mpmath.mpf) -> mpmath.mpf:
        if whole:
            q = middle + χ - half
            return numerator(q) / mpmath.sqrt(square(q))
        q = middle - half * mpmath.cos(χ)
        return numerator(q) * half * mpmath.sin(χ) / mpmath.sqrt(square(q))

    turn = 2 * mpmath.pi if whole else mpmath.pi
    count, last = 32, None
    while count <= _MOST:
        terms = [term(turn * (k + mpmath.mpf("0.5")) / count) for k in range(count)]
        value, size = (turn * mpmath.fsum(terms, absolute=absolute) / count for absolute in (False, True))
        if last is not None and abs(value - last) <= size * mpmath.mpf(10) ** (-DIGITS - 2):
            break
        count, last = 2 * count, value
    return (value, size) if whole else (2 * value, 2 * size)
