"""verify(): is this W or S a complete integral of the Hamilton–Jacobi equation?

    ∂S/∂t + H(q, ∂S/∂q) = 0 (5-52),  H(q, ∂W/∂q) = E (5-69),  det(∂²S/∂q∂α) ≠ 0 (5-48)
    H(−∂F₄/∂p, p) = E,  det(∂²F₄/∂p∂α) ≠ 0 (6-57), (6-83): the same in the momenta

By Jacobi's theorem (5-53)–(5-62) the motion then follows from −β = ∂S/∂α and p = ∂S/∂q. No integral is evaluated:
residual and determinant hold derivatives of the function alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import cast

import sympy as sp

from hjsolve import arguments
from hjsolve.display.shown import Shown, listed_names
from hjsolve.errors import InvalidInputError
from hjsolve.motion.motion import Motion
from hjsolve.precision import one_at_a_time
from hjsolve.separation import Undecided
from hjsolve.separation.zero_test.zero_test import NonZero, Zero
from hjsolve.solution.quadratures import Solution
from hjsolve.theorem import own_motion
from hjsolve.theorem.answers import Flaw
from hjsolve.theorem.own_motion import OwnMotion
from hjsolve.theorem.phase_space import BUDGET, PhaseSpace, Subject, phase_space_of, without_integrals
from hjsolve.theorem.reading import new_names, read_formula


@dataclass(frozen=True, repr=False)
class CompleteIntegral(Shown):
    """A function that is proved to be a complete integral of the Hamilton–Jacobi equation.

    Attributes:
        system: the system.
        principal_function: S(q, α, t); W − E t where W was given.
        constants: names of the constants α, as given.
        energy: E as a function of the constants where W was given, else None.
        residual: the left side of (5-52), as it follows from the formula; proved to vanish.
        determinant: det(∂²S/∂q_i∂α_j) (5-48), rows and columns as declared; proved not to vanish identically.
        momenta: coordinate → p = ∂S/∂q (5-50).
        places: coordinate → q = −∂F₄/∂p (6-57) where F₄ was given, in place of ``momenta``; else empty.
        equations: constant → Jacobi's equation −β = ∂S/∂α (5-54); of the energy t − β_E = ∂W/∂E (5-71).
    """

    system: Subject
    principal_function: sp.Expr
    constants: tuple[str, ...]
    energy: sp.Expr | None
    residual: sp.Expr
    determinant: sp.Expr
    momenta: Mapping[str, sp.Expr]
    equations: Mapping[str, sp.Eq]
    places: Mapping[str, sp.Expr] = field(default_factory=dict)

    def constants_in(self, solution: Solution, *, budget: float = BUDGET) -> dict[str, sp.Expr | Flaw | Undecided]:
        """Return hjsolve's constants of the motion as functions of these: c(q, ∂S/∂q), where it holds no q and no t.

        Args:
            solution: of the same system in the same coordinates, as ``solve`` gives it.
            budget: seconds for each zero test.

        Returns:
            Name of a constant of the solution → its expression in the constants of this integral; ``Flaw`` with a
            witness where it is not a function of them (another separation of a system that has several), ``Undecided``
            where neither was proved.

        Raises:
            InvalidInputError: a solution in other coordinates.

        References:
            Greenwood, Classical Dynamics (1977), (5-50).
        """
        self._refuse_momenta("constants_in")
        space = phase_space_of(self.system, "constants_in")
        return own_motion.constants_in(space, self.principal_function, self._alphas(), solution, budget)

    def along(self, motion: Motion, times: Sequence[float] | None = None) -> OwnMotion | Undecided:
        """Compare Jacobi's equations of this integral with a motion that hjsolve computed by its own quadratures.

        Args:
            motion: of the same system in the same coordinates.
            times: at which states are compared, in the unit of the system; by default 24 over two of the longest
                periods, or over ten units of time.

        Returns:
            The values of the constants, and how well p = ∂S/∂q and (5-54) hold, next to what errors explain. It is true
            as a condition where they hold. ``Undecided`` where the constants were not found, or where fewer than three
            states have the signs of the formula's momenta.

        Raises:
            InvalidInputError: a motion in other coordinates.

        References:
            Greenwood, Classical Dynamics (1977), (5-50), (5-54).
        """
        self._refuse_momenta("along")
        space = phase_space_of(self.system, "along")
        return own_motion.along(space, self.principal_function, self._alphas(), motion, times)

    def _refuse_momenta(self, verb: str) -> None:
        if self.places:
            raise InvalidInputError(f"{verb}: F4 is a function of the momenta; give W(q, …) in its place")

    def _alphas(self) -> tuple[sp.Symbol, ...]:
        held = {s.name: s for s in self.principal_function.free_symbols}
        return tuple(held[name] for name in self.constants)

    def __str__(self) -> str:
        """Return the statement in one sentence."""
        names = listed_names(self.constants)
        return f"A complete integral in the constants {names}: it solves the equation, and |d2S/dq dalpha| is not zero."


@arguments.with_known_names(
    'verify(system, W="alpha*theta + integral(sqrt(2*m*(E + k/r) - alpha**2/r**2), r)", constants=["E", "alpha"])'
)
@one_at_a_time
def verify(
    system: Subject | str | Path,
    *,
    W: object = None,
    S: object = None,
    F4: object = None,
    constants: str | Sequence[object] | Mapping[str, str],
    energy: object = None,
    budget: float = BUDGET,
) -> CompleteIntegral | Flaw | Undecided:
    """Decide whether a function is a complete integral of the Hamilton–Jacobi equation of a system.

    Args:
        system: a system, what ``from_hamiltonian`` gave, or the id or file of a catalog entry.
        W: Hamilton's characteristic function W(q, α), as text or sympy expression. In a text ``integral(f, q)`` is an
            antiderivative over q and ``integral(f, q, a)`` the integral from a to q; sympy's ``Integral`` is accepted.
        S: Hamilton's principal function S(q, α, t), in place of W.
        F4: a function of the momenta ``p_q`` and the constants, F₄(p, α), in place of W.
        constants: the names of the constants α, one for each coordinate, ``("E", "alpha")`` or ``"E, alpha"``; or
            name → domain where the formula holds on one side only, ``{"alpha": "0 < alpha"}``.
        energy: with W or F4, the energy as a function of the constants; by default the constant ``E``.
        budget: seconds for each zero test.

    Returns:
        ``CompleteIntegral``: the equation and the determinant are proved. ``Flaw``: one of them fails, with a witness.
        ``Undecided``: neither was proved.

    Raises:
        InvalidInputError: not one of W, S and F4; a constant too many; no energy.
        ExpressionError: the formula cannot be read.

    Example:
        >>> import hjsolve
        >>> fall = hjsolve.System({"y": "line"}, "m/2*dot(y)**2", "m*g*y", {"m": 1, "g": "9.81"})
        >>> answer = hjsolve.verify(fall, W="integral(sqrt(2*m*(E - m*g*y)), y)", constants="E")
        >>> sp.simplify(answer.determinant**2)
        m/(2*(E - g*m*y))

    References:
        Greenwood, Classical Dynamics (1977), (5-48)–(5-54), (5-65)–(5-72).
    """
    if sum(f is not None for f in (W, S, F4)) != 1:
        raise InvalidInputError("verify: give W=…, S=… or F4=…, one of them")
    space, seconds = phase_space_of(system, "verify"), arguments.seconds(budget, "budget")
    momenta = {p.name for _, p in space.pairs}
    unused = momenta if F4 is None else {q.name for q, _ in space.pairs}
    known = {name: symbol for name, symbol in space.symbols.items() if name not in unused}
    alphas, ranges = new_names(constants, known, "constants")
    space = replace(space, bounds={**space.bounds, **ranges})
    if len(alphas) > len(space.pairs):
        raise InvalidInputError(
            f"constants: {len(alphas)} for {len(space.pairs)} coordinates; name one for each coordinate, and leave out "
            "an additive constant"
        )
    names = known | alphas
    if S is not None:
        if energy is not None:
            raise InvalidInputError("energy: it belongs to W; S holds it itself")
        return _decide(space, read_formula(S, names, "S"), alphas, None, seconds)
    timeless = {name: symbol for name, symbol in names.items() if symbol != space.time}
    E = _energy(energy, alphas, timeless, [x for pair in space.pairs for x in pair])
    if F4 is not None:
        return _decide(space, read_formula(F4, timeless, "F4") - E * space.time, alphas, E, seconds, in_momenta=True)
    return _decide(space, read_formula(W, timeless, "W") - E * space.time, alphas, E, seconds)


def _energy(
    given: object, alphas: Mapping[str, sp.Symbol], names: Mapping[str, sp.Symbol], coordinates: Iterable[sp.Symbol]
) -> sp.Expr:
    """Return the energy in the constants."""
    if given is None:
        if "E" not in alphas:
            first = next(iter(alphas))
            raise InvalidInputError(
                f'energy: none of the constants is called E; say which it is, energy="{first}", or how it follows'
            )
        return alphas["E"]
    E = read_formula(given, names, "energy")
    if others := sorted(q.name for q in E.free_symbols & set(coordinates)):
        raise InvalidInputError(f"energy: it depends on {listed_names(others)}; it is a function of the constants")
    return E


def _decide(
    space: PhaseSpace, S: sp.Expr, alphas: Mapping[str, sp.Symbol], E: sp.Expr | None, seconds: float, *,
    in_momenta: bool = False,
) -> CompleteIntegral | Flaw | Undecided:  # fmt: skip
    if in_momenta:
        slopes = {q: -sp.diff(S, p) for q, p in space.pairs}
    else:
        slopes = {p: sp.diff(S, q) for q, p in space.pairs}
    residual = sp.diff(S, space.time) + space.hamiltonian.xreplace(slopes)
    equation = "dS/dt + H(q, dS/dq) = 0 fails" if E is None else "H(q, dW/dq) = E fails"
    equation = "H(-dF4/dp, p) = E fails" if in_momenta else equation
    wrong = space.proved_zero(residual, "equation", equation, seconds)
    if wrong is not None:
        return wrong
    if len(alphas) < len(space.pairs):
        missing = f"a complete integral of {len(space.pairs)} coordinates has as many constants; here are {len(alphas)}"
        return Flaw("constants", missing, sp.S.Zero)
    matrix = sp.Matrix([[sp.diff(slope, α) for α in alphas.values()] for slope in slopes.values()])
    determinant = matrix.det(method="berkowitz")
    plain, integrals = without_integrals(determinant)
    answer = space.vanishes(plain, seconds)
    if isinstance(answer, Zero):
        statement = f"the constants {listed_names(alphas)} are not independent: |d2S/dq dalpha| vanishes everywhere"
        return Flaw("determinant", statement, sp.S.Zero)
    if not isinstance(answer, NonZero) or integrals:
        return space.undecided(determinant, "determinant", answer)
    coordinates = [c.name for c in space.subject.coordinates]
    momenta = dict(zip(coordinates, slopes.values(), strict=True))
    equations = {name: _jacobi(S, α, E, space.time) for name, α in alphas.items()}
    places, momenta = (momenta, {}) if in_momenta else ({}, momenta)
    return CompleteIntegral(
        cast("Subject", space.subject), S, tuple(alphas), E, residual, determinant, momenta, equations, places
    )


def _jacobi(S: sp.Expr, α: sp.Symbol, E: sp.Expr | None, time: sp.Symbol) -> sp.Eq:
    """−β = ∂S/∂α (5-54), of the energy t − β_E = ∂W/∂E (5-71); β_E is the time at which W's integrals begin."""
    β = sp.Symbol(f"beta_{α.name}", real=True)
    if α == E:
        return sp.Eq(time - β, sp.diff(S + E * time, α), evaluate=False)
    return sp.Eq(-β, sp.diff(S, α), evaluate=False)
