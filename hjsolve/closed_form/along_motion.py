"""Coordinates in time, or with the time as functions of a parameter that passes turning points smoothly.

The coordinate over which alone the time law integrates is q(ξ), the time t(ξ), every other coordinate that Jacobi's
equations give a function of ξ too: r(ξ), t(ξ) and θ(ξ) of Kepler's ellipse, or q(u), t(u), φ(u) with u the argument of
sn u. Where t(ξ) is solved for ξ they are functions of the time.
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.form_context import FormContext
from hjsolve.closed_form.jacobi_equations import anomaly_of, integrated_over, time_of, without_integrals
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities, written_out
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.closed_form.regularised import Anomaly, Regularised, by_parameter
from hjsolve.closed_form.tidy import elliptic, in_factors, shortened_powers
from hjsolve.closed_form.time_limit import check_time
from hjsolve.closed_form.verification import DIGITS, sample_numbers, value_at
from hjsolve.closed_form.why_not import Contains, WhyNot
from hjsolve.errors import required
from hjsolve.functions import JacobiAM, JacobiCN, JacobiSN
from hjsolve.precision import mp

TIME = "t"
"""The key of t(ξ)."""


def along_the_motion(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], names: NamedQuantities,
    inverse: dict[str, sp.Expr], why_not: dict[str, WhyNot],
) -> dict[str, sp.Expr]:  # fmt: skip
    """Coordinates and the time as functions of a parameter; empty where the time is solved for it.

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals.
        names: of the quantities of the forms.
        inverse: gets functions of the time where t(ξ) is solved for ξ.
        why_not: loses the reasons of what was found.
    """
    solution, key = context.solution, context.constants[0]
    held = integrated_over(solution, pieces, key)
    if solution.time_law is None or len(held) != 1 or held[0] not in pieces or key not in pieces[held[0]].integrals:
        return {}
    if without_integrals(solution.time_law.rhs) != 0 or all(c.name in inverse for c in solution.system.coordinates):
        return {}
    try:
        made = _Along(context, pieces, names, held[0])
        found = made.coordinates()
    except NoFormError:
        return {}
    ξ = made.solved()
    if ξ is None:
        first = held[0]
        found = {name: value for name, value in found.items() if name not in inverse}
        for name in set(found) - {TIME, first}:
            reason = why_not.get(f"inverse.{first}")
            why_not[f"inverse.{name}"] = Contains(f"{name}(t)", f"{first}(t)", reason)
        return found
    for name, value in found.items():
        if name != TIME and name not in inverse:
            inverse[name] = value.xreplace({made.ξ: ξ})
            why_not.pop(f"inverse.{name}", None)
    return found if ξ.has(sp.asinh) and made.running.is_polynomial(made.ξ) else {}


class _Along:
    """The motion by the parameter of one coordinate."""

    def __init__(
        self, context: FormContext, pieces: Mapping[str, CoordinateIntegrals], names: NamedQuantities, first: str
    ):  # fmt: skip
        self.context, self.pieces, self.names, self.first = context, pieces, names, first
        self.solution, self.ξ, self.key = context.solution, anomaly_of(context.solution), context.constants[0]
        self.elapsed = required(self.solution.time_law).lhs
        (self.t,) = time_of(self.solution)
        own, start = pieces[first], self.solution.lower_limits[first]
        self.main = by_parameter(own, own.integrals[self.key], self.ξ, start, names)
        self.running = self._scaled(self.main.integral(self.key))
        # t − t₀ = t(ξ) − t(ξ₀), so that t_p = t₀ − t(ξ₀), the time of the turning point
        begin = (self.t - self.elapsed) - at_the_limit(self.running.subs(self.ξ, self.main.begin))
        self.passed = names.same(f"{self.t.name}_p", begin)

    def coordinates(self) -> dict[str, sp.Expr]:
        """Q(ξ), t(ξ) and what follows from them."""
        found = {self.first: self.main.place, TIME: self.passed + self.running}
        verify_along(self.names, self.main, self.key, self.running)
        others = dict[str, tuple[Regularised, sp.Expr]]()
        for name in self.solution.coordinates:
            if name != self.first and (second := self._second(name)) is not None:
                others[name] = second
                found[name] = second[0].place.xreplace({second[0].ξ: second[1]})
        for c in self.solution.separation.shell.ignorable:
            value = self._ignorable(c.momentum, others)
            if value is not None:
                constant, running = value
                short = sp.count_ops(constant) <= 3 * SHORT
                found[c.name] = (constant if short else self.names.same(f"{c.name}_p", constant)) + running
        return found

    def _held(self, key: sp.Symbol) -> list[str]:
        """Return the coordinates over which an equation integrates."""
        return integrated_over(self.solution, self.pieces, key)

    def _grown(self, key: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
        """∫ ∂p/∂c dq over the first coordinate: its part at the lower limit, and as a function of ξ."""
        value = self.main.integral(key)
        verify_along(self.names, self.main, key, value)
        return value.subs(self.ξ, self.main.begin), value

    def _second(self, name: str) -> tuple[Regularised, sp.Expr] | None:
        """Another separated coordinate by its own parameter ψ, and ψ(ξ), from the equation of a separation constant."""
        ignorable = {c.momentum for c in self.solution.separation.shell.ignorable}
        for constant, equation in self.solution.orbit_equations.items():
            key = self.solution.constants[constant].symbol
            if key in ignorable or set(self._held(key)) != {self.first, name} or without_integrals(equation.rhs) != 0:
                continue
            try:
                check_time()
                own, start = self.pieces[name], self.solution.lower_limits[name]
                ψ = sp.Dummy("psi", real=True)
                made = by_parameter(own, own.integrals[key], ψ, start, self.names)
                running = sp.expand(made.integral(key))
                if not running.has(ψ) or running.diff(ψ).has(ψ):
                    continue
                begin, grown = self._grown(key)
            except (NoFormError, KeyError):
                continue
            # the equation of the separation constant is linear in ψ, which makes ψ a function of ξ
            rate = running.diff(ψ)
            moving = sp.expand(-grown / rate)
            δ = self.names.named(f"delta_{name}", made.begin + (equation.lhs + begin) / rate, short=SHORT)
            return made, δ + moving
        return None

    def _ignorable(
        self, key: sp.Symbol, others: Mapping[str, tuple[Regularised, sp.Expr]]
    ) -> tuple[sp.Expr, sp.Expr] | None:  # fmt: skip
        """φ as a constant and a function of ξ."""
        equation = self.solution.orbit_equations[key.name]
        held, rest = self._held(key), without_integrals(equation.rhs)
        if any(n != self.first and n not in others for n in held) or rest.has(*self._places()):
            return None
        (q,) = (c.symbol for c in self.solution.separation.shell.ignorable if c.momentum == key)
        constant, moving = equation.lhs - (rest - q), sp.S.Zero
        for name in held:
            try:
                check_time()
                if name == self.first:
                    begin, value = self._grown(key)
                else:
                    made, ψ = others[name]
                    value = made.integral(key)
                    verify_along(self.names, made, key, value)
                    begin, value = value.subs(made.ξ, made.begin), value.xreplace({made.ξ: ψ})
            except (NoFormError, KeyError):
                return None
            constant, moving = constant + begin, moving - value
        more, moving = sp.expand(moving, deep=False).as_independent(self.ξ, as_Add=True)
        return at_the_limit(constant + more), by_parts(moving, self.ξ, self.names)

    def _places(self) -> list[sp.Symbol]:
        return [self.solution.system.coordinate(n).symbol for n in self.solution.coordinates]

    def solved(self) -> sp.Expr | None:
        """ξ(t): of a linear t(ξ), of c sinh ξ, and of s ξ + ξ³/3, a cubic with one real root (Barker's equation)."""
        ξ, running, since = self.ξ, self.running, self.t - self.passed
        slope = sp.diff(running, ξ)
        if not slope.has(ξ):
            rate = shortened_powers(1 / slope)
            return rate * since
        weight, wave = running.as_independent(ξ, as_Add=False)
        # t = c sinh ξ, of a free particle or a repelling oscillator: solved by arsinh
        if wave == sp.sinh(ξ):
            return sp.asinh(shortened_powers(1 / weight) * since)
        running = sp.expand(running)
        if not running.is_polynomial(ξ) or sp.degree(running, ξ) != 3:
            return None
        third, second, first, _ = sp.Poly(running, ξ).all_coeffs()
        ratio = sp.cancel(first / (3 * third))
        if second != 0 or not ratio.is_positive:
            return None
        # ξ³ + 3s²ξ = c: one real root ξ = 2s sinh(⅓ arsinh(c/2s³)), without a difference of cube roots
        s = sp.sqrt(ratio)
        return 2 * s * sp.sinh(sp.asinh(sp.factor(3 / (2 * s * first)) * since) / 3)

    def _scaled(self, running: sp.Expr) -> sp.Expr:
        """(1/n)(ξ − e sin ξ): written in the eccentricity, the factor of ξ taken out and named."""
        ξ, e = self.ξ, getattr(self.main, "e", sp.S.Zero)
        if elliptic(running) or running.has(sp.atan, sp.atanh):
            return running
        running = sp.expand(written_out(running, {s: m for s, m in self.names.where.items() if s != e}))
        α = in_factors(running.coeff(ξ))
        if α == 0 or α.has(ξ):
            return running
        α = shortened_powers(-α if self._sign(α) < 0 else α)
        n = self.names.named("n" if running != ξ * running.coeff(ξ) else "omega", shortened_powers(1 / α), short=SHORT)
        # (ξ − e sin ξ)/n: Kepler's equation, n the mean motion
        waves = _by_waves(running, ξ).items()
        rest = (shortened_powers(in_factors(c / α)) * wave for wave, c in waves)
        return sp.Add(*rest) / n

    def _sign(self, expression: sp.Expr) -> int:
        return self.main.sign_of(expression) if isinstance(self.main, Anomaly) else 1


def verify_along(names: NamedQuantities, made: Regularised, key: sp.Symbol, value: sp.Expr) -> None:
    """Compare an integral as a function of the parameter with the integral between two places, to 40 digits.

    Args:
        names: of the quantities of the forms.
        made: the coordinate by its parameter.
        key: W or a constant.
        value: the integral, as a function of the parameter.

    Raises:
        NoFormError: they differ.
    """
    integral, q = made.own.integrals[key], made.curve.coordinate.symbol
    with mp.workdps(DIGITS + 20):
        ends = list[tuple[mpmath.mpf, mpmath.mpf]]()
        for ξ in made.span():
            at = names.numbers | {made.ξ: number_of(ξ, {})}
            there, got = (value_at(names.written_out(e), at) for e in (made.place, value))
            ends.append((got, value_at(integral.value, names.numbers | sample_numbers(made.own) | {q: there})))
        (a, b), (c, d) = ends
        if not abs((c - a) - (d - b)) <= abs(d - b) * mp.mpf(10) ** -DIGITS:
            raise NoFormError("not verified: the form along the motion differs from the integral")


def at_the_limit(constant: sp.Expr) -> sp.Expr:
    """Am F(φ) is φ, and so on: at the lower limit, whose φ is between 0 and π."""
    for function, plain in ((JacobiAM, sp.Id), (JacobiSN, sp.sin), (JacobiCN, sp.cos)):
        constant = constant.replace(
            lambda e, f=function: isinstance(e, f) and isinstance(e.args[0], sp.elliptic_f),
            lambda e, g=plain: g(e.args[0].args[0]),
        )
    return shortened_powers(constant)


def by_parts(moving: sp.Expr, ξ: sp.Symbol, names: NamedQuantities) -> sp.Expr:
    """Write each function once, its coefficient in factors, and by the constants where that is shorter.

    Args:
        moving: a sum, all of it dependent on the parameter.
        ξ: the parameter.
        names: of the quantities of the forms.
    """
    return sp.Add(*(names.shortest(shortened_powers(c)) * wave for wave, c in _by_waves(moving, ξ).items()))


def _by_waves(moving: sp.Expr, ξ: sp.Symbol) -> dict[sp.Expr, sp.Expr]:
    """Return the coefficient of each function of the parameter in a sum."""
    terms = dict[sp.Expr, sp.Expr]()
    for term in sp.Add.make_args(moving):
        coefficient, wave = term.as_independent(ξ, as_Add=False)
        terms[wave] = terms.get(wave, sp.S.Zero) + coefficient
    return terms
