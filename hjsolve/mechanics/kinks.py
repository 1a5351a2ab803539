"""Kinks and jumps of V in one coordinate: |x|, sign(x), Piecewise, √(x²), written with a sign that is constant between.

|u| = s u with s = sign u. Between two zeros of u the letter s is a constant, ±1, and V is analytic: what is decided and
solved with the letter s holds on every interval, and motions are pieced together at the zeros.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy.logic.boolalg import BooleanFalse, BooleanTrue

from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, free_name

Interval = tuple[sp.Expr | None, sp.Expr | None, dict[sp.Symbol, sp.Expr]]
_MADE_BY = (sp.Abs, sp.sign, sp.Heaviside, sp.Piecewise, sp.Max, sp.Min)


@dataclass(frozen=True, repr=False)
class Kink(Shown):
    """A function of one coordinate whose sign V depends on.

    Attributes:
        coordinate: its name.
        symbol: s, which stands for the sign.
        argument: u, a polynomial in the coordinate.
    """

    coordinate: str
    symbol: sp.Symbol
    argument: sp.Expr

    @property
    def sign(self) -> sp.Expr:
        """The sign as a function of the coordinate."""
        return sp.sign(self.argument)


def has_kinks(expression: sp.Expr) -> bool:
    """Return whether a formula has absolute values, signs or pieces; a real root |u|^(p/q) alone is none."""
    roots = {e: sp.S.One for e in expression.atoms(sp.Pow) if isinstance(e.base, sp.Abs) and e.exp.is_integer is False}
    return bool(expression.xreplace(roots).has(*_MADE_BY))


def without_kinks(
    potential: sp.Expr, coordinates: Iterable[Coordinate], taken: Iterable[str]
) -> tuple[sp.Expr, tuple[Kink, ...]]:
    """Write V with letters for its signs.

    Args:
        potential: V.
        taken: names in use.

    Raises:
        InvalidSystemError: a sign depends on several coordinates or on an angle, or not by a polynomial.
    """
    places = list(coordinates)
    if not (has_kinks(potential) or (len(places) == 1 and potential.has(sp.Abs))):
        return potential, ()
    writer = _Writer(places, list(taken))
    written = writer.written(potential)
    return writer.reduced(written), tuple(writer.kinks)


class _Writer:
    def __init__(self, coordinates: list[Coordinate], taken: list[str]):
        self.coordinates, self.taken = coordinates, taken
        self.kinks: list[Kink] = []

    def written(self, e: sp.Expr) -> sp.Expr:
        if not e.has(*_MADE_BY):
            return e
        if isinstance(e, sp.Piecewise):
            return self._pieces([(self.written(value), condition) for value, condition in e.args])
        parts = [self.written(part) for part in e.args]
        if isinstance(e, sp.Abs):
            return parts[0] * self._sign(parts[0])
        if isinstance(e, sp.sign):
            return self._sign(parts[0])
        if isinstance(e, sp.Heaviside):
            return (1 + self._sign(parts[0])) / 2
        if isinstance(e, sp.Max | sp.Min):
            side, result = 1 if isinstance(e, sp.Max) else -1, parts[0]
            for part in parts[1:]:
                result = (result + part + side * (result - part) * self._sign(result - part)) / 2
            return result
        return e.func(*parts)

    def _pieces(self, pieces: list[tuple[sp.Expr, sp.Basic]]) -> sp.Expr:
        if not pieces:
            raise InvalidSystemError(
                "potential: a Piecewise without a last piece has no value somewhere; add (…, True)"
            )
        (value, condition), rest = pieces[0], pieces[1:]
        share = self._share(condition)
        return value if share == 1 else share * value + (1 - share) * self._pieces(rest)

    def _share(self, condition: sp.Basic) -> sp.Expr:
        """1 where a condition holds, 0 where it does not."""
        if isinstance(condition, BooleanTrue | BooleanFalse):
            return sp.Integer(bool(condition))
        if isinstance(condition, sp.And):
            return sp.Mul(*map(self._share, condition.args))
        if isinstance(condition, sp.Or):
            return 1 - sp.Mul(*(1 - self._share(part) for part in condition.args))
        if isinstance(condition, sp.Not):
            return 1 - self._share(condition.args[0])
        if isinstance(condition, sp.StrictGreaterThan | sp.GreaterThan):
            return (1 + self._sign(condition.lhs - condition.rhs)) / 2
        if isinstance(condition, sp.StrictLessThan | sp.LessThan):
            return (1 - self._sign(condition.lhs - condition.rhs)) / 2
        raise InvalidSystemError(f"potential: the condition {condition} of a Piecewise is not an inequality")

    def _sign(self, u: sp.Expr) -> sp.Expr:
        if u.is_positive or u.is_negative:
            return sp.Integer(1 if u.is_positive else -1)
        held = [c for c in self.coordinates if u.has(c.symbol)]
        if len(held) != 1 or held[0].domain.kind == "angle":
            raise InvalidSystemError(
                f"potential: the sign of {u} decides; kinks and jumps may depend on one coordinate that is not an angle"
            )
        symbol = held[0].symbol
        if not u.is_polynomial(symbol):
            raise InvalidSystemError(f"potential: the sign of {u} decides, which is not a polynomial in {symbol}")
        for kink in self.kinks:
            ratio = sp.cancel(u / kink.argument)
            if ratio.is_positive or ratio.is_negative:
                return kink.symbol if ratio.is_positive else -kink.symbol
        letter = sp.Symbol(free_name(f"sign_{held[0].name}", self.taken), real=True)
        self.taken.append(letter.name)
        self.kinks.append(Kink(held[0].name, letter, u))
        return letter

    def reduced(self, e: sp.Expr) -> sp.Expr:
        """s² = 1."""
        letters = {kink.symbol for kink in self.kinks}
        powers = {
            p: p.base if p.exp % 2 else sp.S.One for p in e.atoms(sp.Pow) if p.base in letters and p.exp.is_Integer
        }
        return e.xreplace(powers)


def with_signs(expression: sp.Expr, kinks: Iterable[Kink]) -> sp.Expr:
    """Return a formula with sign(u) for its letters.

    Args:
        expression: of V, H, p² ….
    """
    return expression.xreplace({kink.symbol: kink.sign for kink in kinks})


def with_quotients(expression: sp.Expr, kinks: Iterable[Kink]) -> sp.Expr:
    """Return a formula with u/|u| for its letters, for drawings.

    Args:
        expression: of V, p² ….
    """
    return expression.xreplace({kink.symbol: kink.argument / sp.Abs(kink.argument) for kink in kinks})


def refuse_kinks(kinks: Iterable[Kink], what: str) -> None:
    """Refuse what is not worked out where V has kinks.

    Args:
        what: is not worked out.

    Raises:
        InvalidSystemError: there are kinks.
    """
    for kink in kinks:
        raise InvalidSystemError(
            f"{what}: V has a kink or a jump where {kink.argument} changes its sign; single motions and ensembles go "
            "through it, this does not. Give the coordinate a domain that ends there"
        )


def smooth_intervals(
    kinks: Sequence[Kink],
    q: sp.Symbol,
    values: Mapping[sp.Symbol, sp.Expr],
    ends: tuple[sp.Expr | None, sp.Expr | None],
) -> list[Interval]:
    """Return the intervals between kinks, upwards: their ends, None where there is none, and the letters' values.

    Args:
        kinks: those in one coordinate.
        q: its symbol.
        values: symbol → exact number, of the parameters.
        ends: of the domain.

    Raises:
        InvalidSystemError: a kink is a zero of a polynomial that sympy does not solve.
    """
    arguments = {k.symbol: k.argument.xreplace({s: v for s, v in values.items() if s != q}) for k in kinks}
    low, high = ends
    inside = [x for u in arguments.values() for x in _zeros(u, q)]
    zeros = sorted({x for x in inside if (low is None or x > low) and (high is None or x < high)})
    found: list[Interval] = []
    for lower, upper in itertools.pairwise([low, *zeros, high]):
        some = (
            (lower + upper) / 2
            if lower is not None and upper is not None
            else lower + 1
            if lower is not None
            else upper - 1
            if upper is not None
            else sp.S.Zero
        )
        found.append((lower, upper, {letter: sp.sign(u.xreplace({q: some})) for letter, u in arguments.items()}))
    return found


def _zeros(u: sp.Expr, q: sp.Symbol) -> list[sp.Expr]:
    polynomial = sp.Poly(u, q)
    if polynomial.degree() == 1:
        slope, constant = polynomial.all_coeffs()
        return [-constant / slope]
    try:
        return list(dict.fromkeys(sp.real_roots(polynomial)))
    except NotImplementedError:
        raise InvalidSystemError(f"potential: the zeros of {u}, where V has kinks, are not found") from None


def signs_at(kinks: Iterable[Kink], values: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    """Return the values of the letters at a place; 1 at the kink itself.

    Args:
        values: symbol → exact number, of coordinates and parameters.
    """
    from hjsolve.formulas.point_values import CONTEXT, evaluate

    found = {}
    for kink in kinks:
        u = sp.expand(kink.argument.xreplace(values))
        found[kink.symbol] = sp.Integer(-1 if not u.is_zero and CONTEXT.sign(evaluate(u, {})) < 0 else 1)
    return found
