"""Forms as functions of numbers and of arrays, nan outside their regime; what a regime asks for is compiled once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import sympy as sp

from hjsolve.arithmetic.number_types import Mask, Mpf, Reals
from hjsolve.closed_form.complements import ForDoubles
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.doubles import CurveForArrays, FormulasForArrays, RootsOfPolynomial, Solved, roots_of
from hjsolve.closed_form.evaluation import magnitude
from hjsolve.closed_form.lost_digits import FormInTwoDoubles, lost, lost_in_two_doubles
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.numbers import root_values
from hjsolve.closed_form.regions import RootInterval, holds_place, region_exists
from hjsolve.closed_form.turns_of_angles import (
    DIGITS_AT_ENDS,
    CompiledAngle,
    CountedAngle,
    counted_angles,
    curves_held,
    gained_in_a_turn,
    passing_angles,
)
from hjsolve.errors import InvalidInputError, MissingValueError
from hjsolve.formulas.read import number as read_number
from hjsolve.functions import modules
from hjsolve.functions.tables import own_modules
from hjsolve.precision import for_the_user, mp, users_precision

_SPECIAL = 1e-12
"""Of the terms, how far a constant may be off its special value: both are doubles. E = 0 is 0, in any unit."""
_DIGITS_BEYOND_DOUBLES = 50, 120, 480
"""Of what is next to a border or not finite in doubles, nor in fewer digits: roots of a small E may be 1e90 apart."""
_SAME = 2.0**-58
"""Of themselves, how far numbers in fewer and in more digits are apart that round to the same double, or next to it."""
_SHORT = 2.0**-44
"""Of a turn, how far from its end a form is taken there: rounding must not lead beyond."""
_BLOCK = 16384
"""Elements worked on together: coefficients and roots of so many polynomials stay in the processor's cache."""
_Compiled = Callable[..., Any]
"""A function of numbers or arrays."""


def functions(form: NamedForms, module: str) -> dict[str, Callable[..., Mpf | Reals | float]]:
    """Functions of numbers; see ``RegimeForms.lambdify``.

    Args:
        form: of a regime.
        module: "numpy" or "mpmath".

    Raises:
        InvalidInputError: another module.
    """
    if module not in ("numpy", "mpmath"):
        raise InvalidInputError(f'lambdify: {module!r} is not known; write "numpy" or "mpmath"')
    regime = CompiledRegime(form, module == "numpy")
    return {name: regime.function(expression, name) for name, expression in form.named().items()}


class CompiledRegime:
    """What all forms of a regime ask for, each compiled when it is first asked for.

    Args:
        form: of the regime.
        numpy: whether for arrays of doubles; else for numbers of mpmath.
    """

    def __init__(self, form: NamedForms, numpy: bool):
        self.form, self.numpy = form, numpy
        made = form.regime
        self.curves = [(c, r) for c, r in made.regions if c.degree > 2]
        held = {s for e in (*made.conditions, *made.special.values()) for s in e.free_symbols} | set(made.special)
        held |= {s for c, _ in self.curves for p in c.polynomial.coeffs() for s in p.free_symbols}
        self.symbols = sorted(held, key=str)
        self.defaults = {p.name: p.value for p in form.solution.system.parameters if p.value is not None}
        self._arrays = dict[int, CurveForArrays]()  # by id: the form keeps its curves
        self._places = dict[tuple[int, sp.Symbol], FormulasForArrays | None]()
        self._definitions = dict[sp.Symbol, tuple[list[sp.Symbol], _Compiled]]()
        self._polynomials = dict[sp.Poly, RootsOfPolynomial | None]()

    @cached_property
    def arrange(self) -> ForDoubles | None:
        """How forms are arranged for doubles; None for mpmath's numbers."""
        return ForDoubles.of(self.form) if self.numpy else None

    @cached_property
    def many_digits(self) -> CompiledRegime:
        """The same for numbers of mpmath."""
        return CompiledRegime(self.form, numpy=False)

    def function(self, expression: sp.Expr, name: str = "") -> Callable[..., Mpf | Reals | float]:
        """Return a form as a function of keyword arguments; its attribute ``names`` are those that it needs.

        Args:
            expression: the form.
            name: of the quantity.
        """
        compiled = CompiledForm(self, expression, name)

        def function(**given: object) -> Mpf | Reals | float:
            if self.numpy:
                return compiled.arrays(given)
            with users_precision():
                return for_the_user(compiled.one([*map(_exactly, compiled.values(given))]))

        function.names = compiled.names  # type: ignore[attr-defined]
        return function

    def compiled(self, symbols: Sequence[sp.Symbol], expression: sp.Expr, *, cse: bool = False) -> _Compiled:
        """Return an expression as a function of numbers, or arrays.

        Args:
            symbols: in the order of the numbers.
            expression: of them.
            cse: whether common parts are worked out once.
        """
        table = [{"atan2": _angle}, *modules("numpy")] if self.numpy else own_modules()
        return sp.lambdify([*symbols], expression, modules=table, cse=cse)

    @cached_property
    def tests(self) -> list[_Compiled]:
        """What is positive in the regime."""
        return [self.compiled(self.symbols, sign * e) for e, sign in self.form.regime.conditions.items()]

    @cached_property
    def equal(self) -> list[tuple[_Compiled, _Compiled]]:
        """What is zero in the regime, and the size of its terms."""
        zeros = [c - e for c, e in self.form.regime.special.items()]
        return [(self.compiled(self.symbols, e), self.compiled(self.symbols, magnitude(e))) for e in zeros]

    def for_arrays(self, curve: MomentumCurve) -> CurveForArrays:
        """Return a curve, made ready for arrays."""
        if id(curve) not in self._arrays:
            self._arrays[id(curve)] = CurveForArrays(curve)
        return self._arrays[id(curve)]

    def place(self, curve: MomentumCurve, symbol: sp.Symbol) -> FormulasForArrays | None:
        """Return what is asked of a place, made ready for arrays."""
        key = id(curve), symbol
        if key not in self._places:
            self._places[key] = self.for_arrays(curve).place(symbol)
        return self._places[key]

    def root(self, polynomial: sp.Poly) -> RootsOfPolynomial | None:
        """Return the roots of a polynomial, made ready for arrays."""
        if polynomial not in self._polynomials:
            curves = (self.for_arrays(c).roots_like(polynomial) for c, _ in self.curves)
            found = next((own for own in curves if own is not None), None)
            self._polynomials[polynomial] = found or roots_of(polynomial)
        return self._polynomials[polynomial]

    def definition(self, symbol: sp.Symbol, meaning: sp.Expr) -> tuple[list[sp.Symbol], _Compiled]:
        """Return a named quantity as a function of arrays, and the symbols of these."""
        if symbol not in self._definitions:
            held = sorted(meaning.free_symbols, key=str)
            self._definitions[symbol] = held, self.compiled(held, meaning, cse=True)
        return self._definitions[symbol]

    def one_is_inside(
        self, given: Mapping[sp.Symbol, Mpf | float], placed: Sequence[tuple[MomentumCurve, RootInterval, sp.Symbol]]
    ) -> bool:  # fmt: skip
        """Return whether one motion is of the regime, and places are of the motion.

        Args:
            given: symbol → its number.
            placed: curves with symbols of places.
        """
        numbers = [given[s] for s in self.symbols]
        # the cheap tests first: roots of 50 digits cost milliseconds
        if any(not abs(test(*numbers)) <= _SPECIAL * size(*numbers) for test, size in self.equal):
            return False
        if any(not test(*numbers) > 0 for test in self.tests):
            return False
        exact = {s: mp.mpmathify(v) for s, v in given.items()} if self.curves or placed else {}
        if not all(region_exists(c, r, exact) for c, r in self.curves):
            return False
        return all(holds_place(c, r, exact[symbol], exact) for c, r, symbol in placed)

    def signs_hold(self, table: Mapping[sp.Symbol, Reals], shape: tuple[int, ...]) -> Mask:
        """Return where the constants have the signs and the special values of the regime.

        Args:
            table: symbol → its values.
            shape: of the arrays.
        """
        import numpy as np

        good, arrays = np.ones(shape, dtype=bool), [table[s] for s in self.symbols]
        for test in self.tests:
            good &= np.asarray(test(*arrays)) > 0
        for test, size in self.equal:
            good &= np.abs(test(*arrays)) <= _SPECIAL * size(*arrays)
        return good

    def inside(
        self, table: Mapping[sp.Symbol, Reals], shape: tuple[int, ...],
        placed: Sequence[tuple[MomentumCurve, RootInterval, sp.Symbol]], solved: Solved,
    ) -> tuple[Mask, Mask]:  # fmt: skip
        """Return where motions are of the regime and places of the motions, or may be; and where that is not certain.

        Args:
            table: symbol → its values, all with the signs of the regime.
            shape: of the arrays.
            placed: curves with symbols of places.
            solved: roots that were found for these arrays, and are kept there.
        """
        import numpy as np

        good, unsure = np.ones(shape, dtype=bool), np.zeros(shape, dtype=bool)
        curves = [*(c for c, _ in self.curves), *(c for c, *_ in placed)]
        wanted = {id(c): self.for_arrays(c).at(table, shape, solved) for c in curves}
        places = [(c, r, self.place(c, symbol)) for c, r, symbol in placed]
        # a curve without numbers in two doubles: every element is asked for by itself
        if any(found is None for found in (*wanted.values(), *(p for *_, p in places))):
            return good, np.ones(shape, dtype=bool)
        found = [wanted[id(c)].has(r) for c, r in self.curves]  # type: ignore[union-attr]
        found += [wanted[id(c)].holds(r, p(table, shape)) for c, r, p in places]  # type: ignore[union-attr, misc]
        for there, doubtful in found:
            good, unsure = good & (there | doubtful), unsure | doubtful
        return good, unsure


class CompiledForm:
    """One form of a regime, compiled for numbers when it is first asked for.

    Args:
        regime: what it has in common with others.
        expression: the form.
        name: of the quantity.
    """

    def __init__(self, regime: CompiledRegime, expression: sp.Expr, name: str = ""):
        self.regime, self.form, where = regime, regime.form, regime.form.where
        self.name = name
        self.as_derived = expression
        if regime.arrange is not None:
            expression = regime.arrange.form(expression)
        self.expression, self.roots = expression, [s for s in expression.free_symbols if s in where]
        self.held = needed_names(expression.free_symbols, where)[1]
        self.symbols = sorted(self.held | set(regime.symbols), key=str)
        self.names = tuple(s.name for s in self.symbols)

    @cached_property
    def plain(self) -> _Compiled:
        """The form itself, of its symbols and its names."""
        return self.regime.compiled([*self.symbols, *self.roots], self.expression, cse=True)

    @cached_property
    def placed(self) -> list[tuple[MomentumCurve, RootInterval, sp.Symbol]]:
        """The curves of coordinates and lower limits of the form."""
        return curves_held(self.form, self.held)

    @cached_property
    def turned(self) -> list[CompiledAngle]:
        """Angles and lower limits whose turns are taken off, as the lower limits count them."""
        return self._turned(counted_angles(self.form, self.held))

    @cached_property
    def passing(self) -> list[CompiledAngle]:
        """Angles that may go on beyond the turn of the form."""
        return self._turned(passing_angles(self.form, self.name, self.held))

    def _turned(self, angles: Sequence[CountedAngle]) -> list[CompiledAngle]:
        known, found = set(self.symbols), list[CompiledAngle]()
        for own in angles:
            if (own.middle.free_symbols | own.turn.free_symbols) <= known:
                places = self.symbols.index(own.symbol), self.symbols.index(own.begin)
                found.append(
                    CompiledAngle(*places, *(self.regime.compiled(self.symbols, e) for e in (own.middle, own.turn)))
                )
        return found

    @cached_property
    def in_a_turn(self) -> dict[int, _Compiled]:
        """Position of an angle → what the form gains where it moves on by a whole turn."""
        held, gains = self.symbols, gained_in_a_turn(self.form, self.name).items()
        return {held.index(s): self.regime.compiled(held, e) for s, e in gains if s in held}

    def _gained(self, turns: Mapping[int, Any], numbers: Sequence[Any]) -> Any:
        """Return what the form gained in whole turns."""
        return sum(count * self.in_a_turn[k](*numbers) for k, count in turns.items() if k in self.in_a_turn)

    @cached_property
    def where(self) -> dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]:
        """What the form rests on, in order."""
        where = self.regime.arrange.definitions(self.roots) if self.regime.arrange else self.form.where
        return needed_names(self.roots, where)[0] if self.roots else {}

    @cached_property
    def in_two_doubles(self) -> FormInTwoDoubles | None:
        """The form for two doubles; None where it has no numbers there."""
        try:
            return FormInTwoDoubles(self.expression, self.where, self.symbols, self.regime.root)
        except InvalidInputError:
            return None

    @cached_property
    def in_many_digits(self) -> CompiledForm:
        """The same for numbers of mpmath, which do not overflow."""
        return CompiledForm(self.regime.many_digits, self.as_derived)

    def values(self, given: Mapping[str, object]) -> list[object]:
        """Return the arguments in order."""
        for name in given:
            if name not in self.names:
                raise InvalidInputError(f"{name!r} is not an argument; they are {', '.join(self.names)}")
        known = self.regime.defaults
        missing = [name for name in self.names if name not in given and name not in known]
        if missing:
            raise MissingValueError(f"a value is missing for {', '.join(missing)}")
        return [given[name] if name in given else known[name] for name in self.names]

    def one(self, numbers: Sequence[Mpf | float]) -> Mpf:
        """At one place; nan outside the regime."""
        numbers, begun = ([*map(mp.mpmathify, numbers)] for _ in range(2))
        turns = {own.place: own.turns_at(begun, own.begin, mp.nint) for own in self.turned}
        for own in self.turned:
            numbers[own.place] -= turns[own.place] * own.turn(*begun)
        gained = self._gained(turns, numbers)
        for own in self.passing:
            count = own.turns_at(numbers, own.place, mp.nint)
            if count:
                numbers[own.place] -= count * own.turn(*numbers)
                short = mp.mpf(10) ** -mp.dps
                with mp.workdps(DIGITS_AT_ENDS * mp.dps):
                    ends = [self._within(own.at_end(numbers, side, short)) for side in (1, -1)]
                gained += count * (ends[0] - ends[1])
        return self._within(numbers) + gained

    def _within(self, numbers: list[Mpf]) -> Mpf:
        """At one place of the turn that the form is for."""
        given = dict(zip(self.symbols, numbers, strict=True))
        if not self.regime.one_is_inside(given, self.placed):
            return mp.nan
        if self.roots:
            exact = {s: sp.sympify(v) for s, v in given.items()}
            table = root_values(self.form, exact, mp.dps + 5, self.roots)
            numbers = [*numbers, *(table[s] for s in self.roots)]
        return self.plain(*map(mp.mpmathify, numbers))

    def arrays(self, given: Mapping[str, object]) -> Reals | float:
        """At arrays of doubles; nan outside the regime."""
        import numpy as np

        listed = [np.asarray(v, dtype=float) for v in self.values(given)]
        places = np.broadcast_arrays(*listed) if listed else []
        shape = places[0].shape if places else ()
        flat = [np.ravel(a) for a in places]
        begun, count, gained = [*flat], math.prod(shape), np.zeros(math.prod(shape))
        with np.errstate(all="ignore"):
            turns = {own.place: own.turns_at(begun, own.begin, np.rint) for own in self.turned}
            for own in self.turned:
                # of a rotation q is moved by the turns of q₀: the distance between them is that of the motion
                flat[own.place] = begun[own.place] - turns[own.place] * own.turn(*begun)
            if any(times.any() for times in turns.values()):
                gained = gained + self._gained(turns, flat)
            for own in self.passing:
                times = own.turns_at(flat, own.place, np.rint)
                some = np.flatnonzero(times)  # nan as well
                flat[own.place] = flat[own.place] - times * own.turn(*flat)
                if len(some):
                    gained[some] += times[some] * self._over_a_turn(own, [a[some] for a in flat], len(some))
        return (self._blocks(flat, count) + gained).reshape(shape)[()]

    def _over_a_turn(self, own: CompiledAngle, places: Sequence[Reals], count: int) -> Reals:
        """Return what the form gains over a turn, its values next to both ends continued to these."""
        near, far = (
            self._blocks(own.at_end(places, 1, short), count) - self._blocks(own.at_end(places, -1, short), count)
            for short in (_SHORT, 2 * _SHORT)
        )
        # what is left out next to an end is linear in the distance: twice the value at one less that at two
        return 2 * near - far

    def _blocks(self, places: Sequence[Reals], count: int) -> Reals:
        import numpy as np

        begins = range(0, max(1, count), _BLOCK)
        blocks = [self._block([a[k : k + _BLOCK] for a in places], min(_BLOCK, count - k)) for k in begins]
        return np.concatenate(blocks)

    def _block(self, places: Sequence[Reals], count: int) -> Reals:
        import numpy as np

        table, solved = dict(zip(self.symbols, places, strict=True)), Solved()
        with np.errstate(all="ignore"):
            signs = self.regime.signs_hold(table, (count,))
            if not signs.all():  # roots and integrals cost a hundred times more than signs, and are asked of few
                result, kept = np.full(count, np.nan), np.flatnonzero(signs)
                if len(kept):
                    result[kept] = self._block([a[kept] for a in places], len(kept))
                return result
            good, unsure = self.regime.inside(table, (count,), self.placed, solved)
            named, doubtful = self._names(table, (count,), solved)
            result = np.where(good & ~unsure & ~doubtful, self.plain(*places, *(named[s] for s in self.roots)), np.nan)
            for k in np.flatnonzero(good & (unsure | doubtful)):
                result[k] = self._in_digits_enough([float(a[k]) for a in places])
                good[k] = not np.isnan(result[k])
            self._where_digits_are_lost(result, ~unsure & ~doubtful, table, solved)
        self._not_finite(result, good, places)
        return result

    def _where_digits_are_lost(
        self, result: Reals, certain: Mask, table: Mapping[sp.Symbol, Reals], solved: Solved
    ) -> None:  # fmt: skip
        """Work out again what doubles lose, in two doubles, and in many digits where these lose it as well.

        What is not certain has been in many digits.
        """
        import numpy as np

        if self.in_two_doubles is None:
            return
        error = self.in_two_doubles.error(table, result.shape, solved)
        kept = np.flatnonzero(certain & lost(result, error))
        if not len(kept):
            return
        some = {s: a[kept] for s, a in table.items()}
        # roots of the whole block are of other shapes: those of the few are found anew
        again = self.in_two_doubles.again(some, (len(kept),), Solved())
        result[kept] = np.where(np.isfinite(again), again, result[kept])
        for k in kept[lost_in_two_doubles(again, error[kept])]:
            value = self._in_digits_enough([float(table[s][k]) for s in self.symbols])
            result[k] = result[k] if np.isnan(value) else value

    def _not_finite(self, result: Reals, good: Mask, places: Sequence[Reals]) -> None:
        """Work out again what is not finite: cosh 800 in doubles, or √(1 − x²) where rounding left x above 1."""
        import numpy as np

        for k in np.flatnonzero(good & ~np.isfinite(result)):
            value = self._in_digits_enough([float(a[k]) for a in places])
            result[k] = result[k] if np.isnan(value) else value

    def _in_digits_enough(self, numbers: Sequence[float]) -> float:
        """Return one element in so many digits that more make no difference.

        Returns:
            A double; nan where the element is of another regime, or not real, or in no digits finite.
        """
        given = dict(zip(self.symbols, map(mp.mpf, numbers), strict=True))
        value: Mpf | None = None
        for digits in _DIGITS_BEYOND_DOUBLES:
            before, found = value, self._at_digits(given, digits)
            if mp.isfinite(found):
                value = found
                # as far as they agree, both have the digits: of E = −1e−72 none of 50 may be left
                if before is not None and abs(value - before) <= _SAME * abs(value):
                    break
        return float(value) if value is not None and mp.im(value) == 0 else math.nan

    def _at_digits(self, given: Mapping[sp.Symbol, Mpf], digits: int) -> Mpf:
        """Return the form in so many digits; infinite at a pole."""
        try:
            with mp.workdps(digits):
                return self.in_many_digits.one([given[s] for s in self.in_many_digits.symbols])
        except ZeroDivisionError:
            return mp.inf

    def _names(
        self, table: Mapping[sp.Symbol, Reals], shape: tuple[int, ...], solved: Solved
    ) -> tuple[dict[sp.Symbol, Reals], Mask]:  # fmt: skip
        """Return the values of what the form rests on, and where a root is not certain in doubles."""
        import numpy as np

        known, unsure = dict(table), np.zeros(shape, dtype=bool)
        for symbol, meaning in self.where.items():
            definition, index = meaning if isinstance(meaning, tuple) else (meaning, 0)
            held = definition.free_symbols - ({definition.gen} if isinstance(definition, sp.Poly) else set())
            if not held <= known.keys():
                continue
            if not isinstance(definition, sp.Poly):
                symbols, value = self.regime.definition(symbol, definition)
                known[symbol] = np.broadcast_to(value(*(known[s] for s in symbols)), shape)
                continue
            root = self.regime.root(definition)
            if root is None:  # its coefficients have no numbers in two doubles
                known[symbol], unsure = np.full(shape, np.nan), np.ones(shape, dtype=bool)
                continue
            roots, doubtful = root.rounded(known, shape, solved)
            known[symbol] = roots[index]
            # fewer real roots than the regime has: either not of it, or two of them just met
            unsure = unsure | doubtful | np.isinf(roots[index])
        return known, unsure


def _angle(y: Reals, x: Reals) -> Reals:
    """Return atan2, nan where an argument overflowed: it would be a multiple of π/4, which nobody sees to be wrong."""
    import numpy as np

    return np.where(np.isinf(y) | np.isinf(x), np.nan, np.arctan2(y, x))


def _exactly(value: object) -> Mpf:
    return mp.mpmathify(read_number(value, source="value") if isinstance(value, str) else value)
