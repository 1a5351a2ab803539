"""Numbers of forms: with an error, and only for constants of the form's regime."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mask, Mpf, Reals
from hjsolve.closed_form.complements import ForDoubles
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.doubles import PlaceTest, RegionTest, RootsOfPolynomial, place_test, region_test, roots_of
from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.regions import (
    DIGITS,
    RootInterval,
    holds_place,
    middle_of,
    ordered_real_roots,
    region_exists,
)  # fmt: skip
from hjsolve.errors import InvalidInputError, MissingValueError
from hjsolve.formulas.read import number as read_number
from hjsolve.functions import modules
from hjsolve.functions.tables import own_modules
from hjsolve.precision import for_the_user, mp, multiprecision, users_precision

_GUARD, _FLOAT_DIGITS = 20, 15
_SPECIAL = 1e-12
_DIGITS_OF_EXAMPLE = 30
"""Of what is only put in order."""


def form_at_numbers(form: NamedForms, name: str, values: Mapping[str, object], digits: int) -> Estimate:
    """One form at numbers; see ``RegimeForms.evaluate``.

    Args:
        form: of a regime.
        name: of the quantity.
        values: symbol's name → number.
        digits: of the result.

    Raises:
        InvalidInputError: an unknown name, or constants that are not of this regime.
        MissingValueError: a value that is missing.
    """
    expression = wanted_form(form, name)
    exact = _exact(form, expression, values)
    refuse_outside(form, exact)
    refuse_places(form, exact)
    working = 2 * (digits + _GUARD)
    table = many_digits(exact, working) | root_values(form, exact, working, expression.free_symbols)
    with mp.workdps(digits + _GUARD):
        near = number_of(expression, table)
    with mp.workdps(working):
        far = number_of(expression, table)
        if not mp.isfinite(far) or not mp.isfinite(near):
            raise InvalidInputError(f"{name} is infinite there")
        if abs(mp.im(far)) > abs(far) * mp.mpf(10) ** -digits:
            raise InvalidInputError(f"{name} has no real value there: the place is not one the motion reaches")
        again = mp.re(far)
        lost = 2 * abs(mp.re(near) - again)
    if digits <= _FLOAT_DIGITS:
        return Estimate(float(again), float(lost) + abs(float(again)) * EPS)
    context = multiprecision(libmp.dps_to_prec(digits + 2))
    return Estimate(context.mpf(again), context.mpf(lost) + abs(context.mpf(again)) * context.mpf(10) ** -digits)


def refuse_outside(form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr]) -> None:
    """Refuse constants that are not of a form's regime.

    Args:
        form: of a regime.
        exact: symbol → exact value, of every parameter and constant.

    Raises:
        InvalidInputError: they are of another one.
    """
    if not form.regime.holds(exact):
        raise InvalidInputError(
            f"these constants are not of the form's regime ({form.regime.words}); "
            "take the form of closed_forms(solution) whose regime holds, or closed_forms(motion)"
        )


def refuse_places(form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr]) -> None:
    """Refuse a coordinate, or a lower limit, at which the motion of the regime never is.

    Args:
        form: of a regime.
        exact: symbol → exact value, of constants, coordinates and lower limits.

    Raises:
        InvalidInputError: it is such a place.
    """
    for curve, region, symbol in curves_held(form, exact):
        numbers = many_digits(exact, DIGITS)
        if holds_place(curve, region, numbers[symbol], numbers):
            continue
        turn = ""
        if curve.substitution.closed:
            middle, half = float(middle_of(curve, numbers)), float(number_of(curve.substitution.turn, numbers)) / 2
            turn = f"; the form is that of one turn, {symbol} from {middle - half:.3g} to {middle + half:.3g}"
        raise InvalidInputError(f"{symbol} = {float(numbers[symbol]):.6g} is outside this regime's motion{turn}")


def curves_held(form: NamedForms, held: Iterable[sp.Symbol]) -> list[tuple[MomentumCurve, RootInterval, sp.Symbol]]:
    """Return the curves of coordinates and lower limits that are among symbols.

    Args:
        form: of a regime.
        held: the symbols.
    """
    known = set(held)
    return [
        (curve, region, symbol)
        for curve, region in form.regime.regions
        for symbol in (curve.coordinate.symbol, form.solution.lower_limits.get(curve.coordinate.name))
        if symbol in known
    ]


def wanted_form(form: NamedForms, name: str) -> sp.Expr:
    """Return a form by its name.

    Args:
        form: of a regime.
        name: of the quantity.

    Raises:
        InvalidInputError: an unknown name, or one of which there is no form.
    """
    named = form.named()
    if name not in named:
        reason = form.why_not.get(name)
        more = f"there is no form of it: {reason}" if reason else f"known are {', '.join(named)}"
        raise InvalidInputError(f"{name!r}: {more}")
    return named[name]


def _exact(form: NamedForms, expression: sp.Expr, values: Mapping[str, object]) -> dict[sp.Symbol, sp.Expr]:
    """Return the symbol → exact value, of everything the regime and the expression need."""
    exact = {p.symbol: p.value for p in form.solution.system.parameters if p.value is not None}
    needed = {s.name: s for s in (*form.regime.example, *needed_names(expression.free_symbols, form.where)[1])}
    for name, value in values.items():
        if name not in needed:
            raise InvalidInputError(
                f"{name!r} occurs neither in the form nor in its regime; they contain {', '.join(needed)}"
            )
        exact[needed[name]] = read_number(value, source=name)
    for constant, meaning in form.regime.special.items():
        if constant not in exact:
            exact[constant] = meaning.xreplace(exact)
    missing = [name for name, symbol in needed.items() if symbol not in exact]
    if missing:
        raise MissingValueError(f"a value is missing for {', '.join(missing)}")
    return exact


def root_values(
    form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr], digits: int, wanted: Iterable[sp.Symbol] | None = None
) -> dict[sp.Symbol, mpmath.mpf]:  # fmt: skip
    """Return the values of the symbols that ``where`` defines, as far as what they rest on is known.

    Args:
        form: of a regime.
        exact: symbol → exact value.
        digits: to which roots are found.
        wanted: symbols whose values, and those of what they rest on, are enough; None for all.
    """
    known = many_digits(exact, digits)
    where = needed_names(form.where if wanted is None else wanted, form.where)[0]
    with mp.workdps(digits):
        for symbol, meaning in where.items():
            rests_on = sp.Tuple(*meaning[0].all_coeffs()) if isinstance(meaning, tuple) else meaning
            if not rests_on.free_symbols <= known.keys():
                continue
            if isinstance(meaning, tuple):
                polynomial, index = meaning
                known[symbol] = ordered_real_roots(polynomial, known, digits)[index]
            else:
                known[symbol] = mp.re(number_of(meaning, known))
    return {symbol: known[symbol] for symbol in where if symbol in known}


def at_example(form: NamedForms, wanted: Iterable[sp.Symbol]) -> dict[sp.Symbol, Mpf]:
    """Return the constants, the named roots and some named quantities at the motion that a regime was found with.

    Args:
        form: of a regime.
        wanted: symbols of what is to be arranged.
    """
    exact = dict(form.regime.example)
    roots = (s for s, meaning in form.where.items() if isinstance(meaning, tuple))
    return many_digits(exact, _DIGITS_OF_EXAMPLE) | root_values(form, exact, _DIGITS_OF_EXAMPLE, (*roots, *wanted))


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
    arrange = ForDoubles(form.where, at_example(form, form.where)) if module == "numpy" else None
    return {name: _function(form, expression, arrange) for name, expression in form.named().items()}


def _function(
    form: NamedForms, expression: sp.Expr, arrange: ForDoubles | None
) -> Callable[..., Mpf | Reals | float]:  # fmt: skip
    compiled = _CompiledForm(form, expression, arrange)

    def function(**given: object) -> Mpf | Reals | float:
        if arrange is not None:
            return compiled.arrays(given)
        with users_precision():
            return for_the_user(compiled.one([*map(_exactly, compiled.values(given))]))

    function.names = compiled.names  # type: ignore[attr-defined]
    return function


def _exactly(value: object) -> Mpf:
    return mp.mpmathify(read_number(value, source="value") if isinstance(value, str) else value)


_Compiled = Callable[..., Any]
_Definitions = list[tuple[sp.Symbol, Any]]
"""A function of numbers or arrays."""


class _CompiledForm:
    """A form and the conditions of its regime, each compiled for numbers when it is first asked for."""

    def __init__(self, form: NamedForms, expression: sp.Expr, arrange: ForDoubles | None):
        made, where = form.regime, form.where
        if arrange is not None:
            expression = arrange.form(expression)
        self.form, self.roots = form, [s for s in expression.free_symbols if s in where]
        self.curves = [(c, r) for c, r in made.regions if c.degree > 2]
        plain = needed_names(expression.free_symbols, where)[1]
        held = plain | set(made.special)
        held |= {s for e in (*made.conditions, *made.special.values()) for s in e.free_symbols}
        held |= {s for c, _ in self.curves for p in c.polynomial.coeffs() for s in p.free_symbols}
        self.symbols = sorted(held, key=str)
        self.names = tuple(s.name for s in self.symbols)
        self.defaults = {p.name: p.value for p in form.solution.system.parameters if p.value is not None}
        self.numpy, self.arrange, self.expression, self.held = arrange is not None, arrange, expression, plain

    @cached_property
    def plain(self) -> _Compiled:
        """The form itself."""
        return self._compiled(self.expression, *self.roots)

    @cached_property
    def tests(self) -> list[_Compiled]:
        """What is positive in the regime."""
        return [self._compiled(sign * e) for e, sign in self.form.regime.conditions.items()]

    @cached_property
    def equal(self) -> list[_Compiled]:
        """What is zero in the regime."""
        return [self._compiled(c - e) for c, e in self.form.regime.special.items()]

    @cached_property
    def placed(self) -> list[tuple[MomentumCurve, RootInterval, sp.Symbol]]:
        """The curves of coordinates and lower limits of the form."""
        return curves_held(self.form, self.held)

    @cached_property
    def inside(self) -> list[PlaceTest | None]:
        """Whether places are of the motion."""
        return [place_test(c, r, s, self.symbols) for c, r, s in self.placed]

    @cached_property
    def regions(self) -> list[RegionTest | None]:
        """Whether the regions exist."""
        return [region_test(c, r, self.symbols) for c, r in self.curves]

    @cached_property
    def named(self) -> _Definitions:
        """What the form rests on."""
        return self._definitions() if self.roots else []

    def _compiled(self, expression: sp.Expr, *more: sp.Symbol) -> _Compiled:
        known = modules("numpy") if self.numpy else own_modules()
        return sp.lambdify([*self.symbols, *more], expression, modules=known, cse=expression is self.expression)

    def values(self, given: Mapping[str, object]) -> list[object]:
        """Return the arguments in order."""
        for name in given:
            if name not in self.names:
                raise InvalidInputError(f"{name!r} is not an argument; they are {', '.join(self.names)}")
        missing = [name for name in self.names if name not in given and name not in self.defaults]
        if missing:
            raise MissingValueError(f"a value is missing for {', '.join(missing)}")
        return [given[name] if name in given else self.defaults[name] for name in self.names]

    def one(self, numbers: Sequence[Mpf | float]) -> Mpf:
        """At one place; nan outside the regime."""
        if not self._inside(numbers):
            return mp.nan
        if self.roots:
            exact = {s: sp.sympify(v) for s, v in zip(self.symbols, numbers, strict=True)}
            table = root_values(self.form, exact, mp.dps + 5, self.roots)
            numbers = [*numbers, *(table[s] for s in self.roots)]
        if not self.numpy:
            return self.plain(*map(mp.mpmathify, numbers))
        import numpy as np  # whose numbers divide by zero in a case that is not taken

        return self.plain(*map(np.float64, numbers))

    def _inside(self, numbers: Sequence[Mpf | float]) -> bool:
        if any(abs(test(*numbers)) > _SPECIAL for test in self.equal):
            return False
        if any(not test(*numbers) > 0 for test in self.tests):
            return False
        pairs = zip(self.symbols, numbers, strict=True)
        given = {s: mp.mpmathify(v) for s, v in pairs} if self.curves or self.placed else {}
        if not all(region_exists(c, r, given) for c, r in self.curves):
            return False
        return all(holds_place(c, r, given[symbol], given) for c, r, symbol in self.placed)

    def arrays(self, given: Mapping[str, object]) -> Reals | float:
        """At arrays of doubles; nan outside the regime."""
        import numpy as np

        listed = [np.asarray(v, dtype=float) for v in self.values(given)]
        places = np.broadcast_arrays(*listed) if listed else []
        with np.errstate(all="ignore"):
            good = np.ones(places[0].shape if places else (), dtype=bool)
            for test in self.tests:
                good &= np.asarray(test(*places)) > 0
            for test in self.equal:
                good &= np.abs(test(*places)) <= _SPECIAL
            good, unsure = self._in_regions(places, good)
            tables, doubtful = self._root_arrays(places, good.shape)
            result = np.where(good & ~unsure & ~doubtful, self.plain(*places, *tables), np.nan)
            for place in np.argwhere(good & (unsure | doubtful)):
                result[tuple(place)] = float(self.one([float(a[tuple(place)]) for a in places]))
        return result[()]

    def _in_regions(self, places: Sequence[Reals], good: Mask) -> tuple[Mask, Mask]:
        """Return where the regions exist, or may exist, of those; and where that is not certain in doubles."""
        import numpy as np

        unsure = np.zeros(good.shape, dtype=bool)
        for test in self.regions:
            if test is None:
                return good, np.ones(good.shape, dtype=bool)
            exists, doubtful = test(places, good.shape)
            good, unsure = good & (exists | doubtful), unsure | doubtful
        for there in self.inside:
            if there is None:
                return good, np.ones(good.shape, dtype=bool)
            inside, doubtful = there(places, good.shape)
            good, unsure = good & (inside | doubtful), unsure | doubtful
        return good, unsure

    def _definitions(self) -> _Definitions:
        """Return what the form rests on, with its value for arrays, in order; of a root: polynomial and index."""
        known, found = list(self.symbols), _Definitions()
        polynomials = dict[sp.Poly, RootsOfPolynomial]()
        where = self.arrange.definitions(self.roots) if self.arrange else self.form.where
        for symbol, meaning in needed_names(self.roots, where)[0].items():
            definition = meaning[0] if isinstance(meaning, tuple) else meaning
            held = definition.free_symbols - ({definition.gen} if isinstance(definition, sp.Poly) else set())
            if not held <= set(known):
                continue
            if isinstance(meaning, tuple):
                if meaning[0] not in polynomials:
                    polynomials[meaning[0]] = roots_of(meaning[0], known)
                found.append((symbol, (polynomials[meaning[0]], meaning[1])))
            else:
                found.append((symbol, sp.lambdify(known, meaning, modules=modules("numpy"), cse=True)))
            known.append(symbol)
        return found

    def _root_arrays(self, places: Sequence[Reals], shape: tuple[int, ...]) -> tuple[list[Reals], Mask]:
        """Return the values of the named symbols of the form, and where a root is not certain in doubles."""
        import numpy as np

        known, table, unsure = list(places), dict[sp.Symbol, Reals](), np.zeros(shape, dtype=bool)
        solved = dict[int, tuple[Reals, Mask]]()
        for symbol, value in self.named:
            if isinstance(value, tuple):
                polynomial, index = value
                if id(polynomial) not in solved:
                    solved[id(polynomial)] = polynomial(known, shape)
                roots, doubtful = solved[id(polynomial)]
                table[symbol] = roots[index]
                unsure = unsure | doubtful | np.isinf(roots[index])
            else:
                table[symbol] = np.broadcast_to(value(*known), shape)
            known.append(table[symbol])
        return [table[s] for s in self.roots], unsure
