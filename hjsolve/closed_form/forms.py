"""Closed forms of a separable system, regime by regime: derived, verified, and only then given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.closed_form.compiled_forms import functions
from hjsolve.closed_form.named_quantities import written_out
from hjsolve.closed_form.numbers import form_at_numbers, wanted_form
from hjsolve.closed_form.regime import Regime
from hjsolve.closed_form.source_code import source
from hjsolve.closed_form.why_not import WhyNot
from hjsolve.display.shown import Shown
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, repr=False)
class RegimeForms(Shown):
    """The closed forms of one regime; on the branch on which every separated momentum is positive.

    Free symbols are parameters, constants of the motion, coordinates, the time t, t_0, the lower limits q_0 and the β;
    any other is defined in ``where``.

    Attributes:
        solution: what they are forms of.
        regime: for which constants they hold.
        time_law: t − t₀ = …, without an integral; None where there is no such form.
        orbit_equations: constant → −β = ….
        characteristic_function: W; None where there is no such form.
        turning_points: coordinate → (lower, upper), None where the motion does not turn; no key where it never turns.
        periods: coordinate → 2π/abs(Ω).
        actions: coordinate → J = (1/2π) ∮ p dq.
        frequencies: coordinate → Ω = ∂H/∂J.
        mean_velocities: ignorable coordinate that is not an angle → ⟨dq/dt⟩.
        inverse: coordinate → q(t).
        orbit: coordinate → q as a function of another coordinate, the one that it holds.
        parametric: coordinate → q(τ) of two separated coordinates, τ the common value of the integrals of first kind in
            the orbit equation of the separation constant (Liouville's τ, Mino's time); zero at the lower limits.
        anomaly: coordinate, or t → q(ξ) and t(ξ) where t(q) cannot be solved for q: ξ is the eccentric anomaly of an
            ellipse, its hyperbolic twin, or tan ν/2 of a parabola; q grows where ξ is positive.
        energy: E as a function of the actions J_<name>, and momenta of ignorable coordinates that are no angles; None
            where it was not solved for.
        where: symbol → its definition: an expression, or (polynomial, index of the real root).
        why_not: quantity → why there is no form of it: a proof as data, or what was not found (``why_not.py``).
        constants_of_actions: constant of the motion → its formula in the actions J_<name>; empty where ``energy`` is
            None.
    """

    solution: Solution = field(repr=False)
    regime: Regime
    time_law: sp.Eq | None
    orbit_equations: Mapping[str, sp.Eq]
    characteristic_function: sp.Expr | None
    turning_points: Mapping[str, tuple[sp.Expr | None, sp.Expr | None]]
    periods: Mapping[str, sp.Expr]
    actions: Mapping[str, sp.Expr]
    frequencies: Mapping[str, sp.Expr]
    mean_velocities: Mapping[str, sp.Expr]
    inverse: Mapping[str, sp.Expr]
    orbit: Mapping[str, sp.Expr]
    parametric: Mapping[str, sp.Expr]
    anomaly: Mapping[str, sp.Expr]
    energy: sp.Expr | None
    where: Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
    why_not: Mapping[str, WhyNot]
    constants_of_actions: Mapping[str, sp.Expr] = field(default_factory=dict)

    @property
    def function_of_actions(self) -> sp.Expr | None:
        """W(q, J), which generates the map to angles and actions (6-85); None where W or the constants have no form."""
        constants = self.solution.constants
        if self.characteristic_function is None or any(n not in self.constants_of_actions for n in constants):
            return None
        librating = [name for name, kind in self.regime.kinds.items() if kind == "libration"]
        positive = {sp.Symbol(f"J_{name}", real=True): sp.Dummy(positive=True) for name in librating}
        put = {c.symbol: self.constants_of_actions[n].xreplace(positive) for n, c in constants.items()}
        W = self.written_out("characteristic_function").xreplace(put)
        return W.xreplace({d: J for J, d in positive.items()})

    @property
    def angle_variables(self) -> dict[str, sp.Expr]:
        """Coordinate → w = ∂W(q, J)/∂J (6-88), in radians, which grows by Ω a unit of time; empty without W(q, J)."""
        W = self.function_of_actions
        if W is None:
            return {}
        return {name: sp.diff(W, sp.Symbol(f"J_{name}", real=True)) for name in self.actions}

    def named(self) -> dict[str, sp.Expr]:
        """Return every form that is a function, by name: ``time_law``, ``periods.r``, ``inverse.x``….

        Returns:
            Name → expression; of an equation its right side.
        """
        found = dict[str, sp.Expr]()
        if self.time_law is not None:
            found["time_law"] = self.time_law.rhs
        if self.characteristic_function is not None:
            found["characteristic_function"] = self.characteristic_function
        found |= {f"orbit_equations.{name}": equation.rhs for name, equation in self.orbit_equations.items()}
        for group in (
            "periods",
            "actions",
            "frequencies",
            "mean_velocities",
            "inverse",
            "orbit",
            "parametric",
            "anomaly",
        ):
            found |= {f"{group}.{name}": value for name, value in getattr(self, group).items()}
        for name, ends in self.turning_points.items():
            for side, end in zip(("lower", "upper"), ends, strict=True):
                if end is not None:
                    found[f"turning_points.{name}.{side}"] = end
        if self.energy is not None:
            found["energy"] = self.energy
        return found

    def written_out(self, name: str) -> sp.Expr:
        """One form with the definitions of ``where`` in place of their names; roots of polynomials stay by name.

        Args:
            name: of the form, as in ``named``.

        Raises:
            InvalidInputError: an unknown name.
        """
        return written_out(wanted_form(self, name), self.where)

    def evaluate(self, name: str, values: Mapping[str, object], digits: int = 15) -> Estimate:
        """One form at numbers.

        Args:
            name: of the form, as in ``named``.
            values: symbol's name → number, of every symbol the regime and the form hold; parameters may be left out
                where they have a default.
            digits: of the result.

        Returns:
            An ``Estimate``.

        Raises:
            InvalidInputError: an unknown name, a value that is missing, or constants that are not of this regime.
        """
        return form_at_numbers(self, name, values, digits)

    def lambdify(self, module: str = "numpy") -> dict[str, Callable[..., Any]]:
        """Functions of numbers: of keyword arguments by the names of the symbols.

        Args:
            module: "numpy" (arrays, nan outside the regime) or "mpmath".

        Returns:
            Name, as in ``named`` → function; with the attribute ``names``, the arguments that it needs.

        Raises:
            InvalidInputError: another module.
        """
        return functions(self, module)

    def code(self, language: str = "python") -> str:
        """Source text of one function for each form, in doubles.

        Next to separatrices, in small motions, next to turning points and where constants are of very different sizes
        the functions lose digits without a sign, as the head of the text says. ``evaluate`` and ``lambdify`` do not:
        they see what doubles lose, and work it out in more digits.

        Args:
            language: "python" or "c".

        Raises:
            InvalidInputError: another language.
        """
        return source(self, language)
