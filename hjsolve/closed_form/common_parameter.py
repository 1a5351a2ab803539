"""t(τ) and φ(τ) next to q₁(τ) and q₂(τ), in the parameter that decouples the motion.

Where the time law holds integrals over two coordinates, Jacobi's equation of the separation constant gives
dτ = |∂p₁/∂α| dq₁ = |∂p₂/∂α| dq₂, and each coordinate is a function of τ (``inverses.parametric_formulas``); then so are
the integrals over it, and their sums: Kepler's problem in parabolic coordinates, two centres, Kerr's geodesics in
Mino's time (Mino, Phys. Rev. D 67, 084027).
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.closed_form.along_motion import at_the_limit, by_parts, verify_along
from hjsolve.closed_form.form_context import FormContext, SpecialCase
from hjsolve.closed_form.jacobi_equations import common_parameter, time_of, without_integrals
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.closed_form.regularised import Regularised, by_parameter
from hjsolve.closed_form.time_limit import check_time
from hjsolve.closed_form.verification import sample_numbers, sample_place, value_at

Pieces = Mapping[str, CoordinateIntegrals]


def others_in_parameter(
    context: FormContext, pieces: Pieces, special: SpecialCase, parametric: Mapping[str, sp.Expr],
    names: NamedQuantities,
) -> dict[str, sp.Expr]:  # fmt: skip
    """Return the time, by its name, and ignorable coordinates as functions of τ; those that have such a form.

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
        parametric: q₁(τ), q₂(τ).
        names: of the quantities of the forms.
    """
    solution, two = context.solution, list(context.solution.coordinates)
    if set(parametric) != set(two) or len(two) != 2:
        return {}
    ignorable = {c.momentum: c for c in solution.separation.shell.ignorable}
    key = next(
        solution.constants[n].symbol
        for n in solution.orbit_equations
        if solution.constants[n].symbol not in ignorable and solution.constants[n].symbol not in special
    )
    try:
        made = [_In(pieces[n], key, solution.lower_limits[n], common_parameter(solution), names) for n in two]
    except NoFormError:
        return {}
    found = dict[str, sp.Expr]()
    if solution.time_law is not None and time_of(solution):
        (t,) = time_of(solution)
        value = _summed(made, context.constants[0], solution.time_law)
        if value is not None:
            found[t.name] = names.named(f"{t.name}_p", t - value[0], short=3 * SHORT) + value[1]
    for momentum, c in ignorable.items():
        equation = solution.orbit_equations[momentum.name]
        value = _summed(made, momentum, sp.Eq(equation.lhs, equation.rhs - c.symbol, evaluate=False))
        if value is not None:
            found[c.name] = names.named(f"{c.name}_p", value[0], short=3 * SHORT) - value[1]
    return found


class _In:
    """A coordinate by its own parameter ψ, and ψ(τ) = ± rate (τ − τ_p)."""

    def __init__(
        self, own: CoordinateIntegrals, key: sp.Symbol, start: sp.Symbol, τ: sp.Symbol, names: NamedQuantities
    ):  # fmt: skip
        ψ = sp.Dummy("psi", real=True)
        self.own, self.τ, self.ψ, self.names = own, τ, ψ, names
        self.made: Regularised = by_parameter(own, own.integrals[key], ψ, start, names)
        # of the first kind it is linear in ψ, the anomaly or the argument u of sn u
        running = self.made.integral(key)
        slope = sp.factor(sp.diff(running, ψ))
        if slope == 0 or slope.has(ψ):
            raise NoFormError("the integral in the separation constant is not of the first kind")
        q = self.made.curve.coordinate.symbol
        numerator = value_at(own.integrals[key].numerator, sample_numbers(own) | {q: sample_place(own)})
        # dτ = |∂p/∂α| dq, so that τ grows with every coordinate on the branch p > 0
        rate = names.shortest((1 if numerator > 0 else -1) / slope)
        passed = names.same(f"{τ.name}_p", -at_the_limit(self.made.begin) / rate)
        self.argument = rate * (τ - passed)

    def integral(self, key: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
        """∫ ∂p/∂c dq at the lower limit, and as a function of τ."""
        if key not in self.own.numerators:
            return sp.S.Zero, sp.S.Zero
        if key not in self.own.integrals:
            raise NoFormError("an integral has no form")
        value = sp.expand(self.made.integral(key), deep=False)
        verify_along(self.names, self.made, key, value)
        begin = at_the_limit(value.xreplace({self.ψ: self.made.begin}))
        return begin, by_parts(value, self.ψ, self.names).xreplace({self.ψ: self.argument})


def _summed(made: list[_In], key: sp.Symbol, equation: sp.Eq) -> tuple[sp.Expr, sp.Expr] | None:
    """Return a constant, and Σ ∫ ∂p/∂c dq as a function of τ: lhs = −constant' + Σ.

    None where an integral has no form.
    """
    if without_integrals(equation.rhs) != 0:
        return None
    try:
        check_time()
        parts = [one.integral(key) for one in made]
    except NoFormError:
        return None
    return equation.lhs + sp.Add(*(begin for begin, _ in parts)), sp.Add(*(value for _, value in parts))
