"""The solution by quadratures: momenta, Hamilton's characteristic function W, Jacobi's equations, all unevaluated.

Greenwood (1977), chapter 5. With the separated shell Pᵢ² = 2(Σⱼ Φᵢⱼ αⱼ − ψᵢ), α₁ = E, and pᵢ = Pᵢ − Aᵢ,

    W = Σ c_k q_k + Σᵢ ∫ Pᵢ dqᵢ − χ,     t − t₀ = ∂W/∂E (5-71),     −βⱼ = ∂W/∂αⱼ (5-70),     −β_k = ∂W/∂c_k (5-83).

**Lower limits** are symbols q_0, one for each separated coordinate. An admissible value is a constant that does not
depend on the separation constants, or a simple zero of Pᵢ²: only then does differentiation under the integral sign
leave no boundary term (Greenwood, after (5-94)). The choice fixes what t₀ and the β mean. **Sign of the root**: printed
+; it is + while the coordinate increases and − while it decreases, flips at each turning point, and enters W itself,
which is therefore multivalued: it grows by ∮p dq with every cycle.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, cast

import sympy as sp

from hjsolve import arguments
from hjsolve.algebra.addition_theorems import rejoined
from hjsolve.coordinates.chart import Chart
from hjsolve.display.shown import ShownSolution
from hjsolve.errors import InvalidInputError, NotSeparableError
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System
from hjsolve.precision import one_at_a_time
from hjsolve.separation import DEFAULT_BUDGET, Constant, Obstruction, Separation, Undecided, separate
from hjsolve.separation.relativistic import shell_energy
from hjsolve.separation.verdicts import Verdict
from hjsolve.solution.jacobi_equations import (
    fresh_symbol,
    named_constants,
    names_taken,
    orbit_equations_of,
    quadrature,
    separation_constants,
    time_law_of,
)

if TYPE_CHECKING:
    from hjsolve.motion.motion import Motion
    from hjsolve.resonances.double_zeros import Separatrix
    from hjsolve.two_point.asked.answers import Connections
    from hjsolve.two_point.kepler.arrays import ConnectionTable
    from hjsolve.two_point.linear import TwoPointFunction

AS_GIVEN, FIND = "as given", "find"
"""What ``solve`` takes for ``coordinates``."""


@dataclass(frozen=True, repr=False)
class Solution(ShownSolution):
    """A complete integral of the Hamilton–Jacobi equation and what follows from it.

    Attributes:
        system: the system solved.
        separation: the verdict it was made from.
        coordinates: names of the separated (essential) coordinates, in the order of Φ's rows.
        constants: name → constant of the motion; E, then alpha_2, …, then the ignorable momenta.
        momentum_squared: separated coordinate → Pᵢ²(qᵢ; constants, parameters); none for a null coordinate
            (``Shell.null``), whose momentum enters H to first degree and is given by ``momenta`` without a root.
        shift: separated coordinate → Aᵢ(q; c), Pᵢ = pᵢ + Aᵢ; zero unless T has terms linear in the velocities.
        shift_potential: χ, with ∂χ/∂qᵢ = Aᵢ.
        momenta: every coordinate → its momentum ∂W/∂q; +√Pᵢ² − Aᵢ, or the constant itself.
        lower_limits: separated coordinate → the symbol its quadratures start from.
        characteristic_function: W, with unevaluated integrals.
        time_law: t − t₀ = ∂W/∂E (τ for t where t is a coordinate);
            None where every coordinate is ignorable (then E is a function of the other constants
            and the orbit equations carry the time).
        orbit_equations: name of a constant → −β = ∂W/∂(constant); for all constants but E.
        chart: how the coordinates were found and are related to the user's own, which motions are started and expressed
            in; None where they are the user's own.

    Example:
        >>> solve("kepler-planar").momenta["r"]
        sqrt(2*E*m + 2*k*m/r - p_theta**2/r**2)
    """

    system: System
    separation: Separation
    coordinates: tuple[str, ...]
    constants: Mapping[str, Constant]
    momentum_squared: Mapping[str, sp.Expr]
    shift: Mapping[str, sp.Expr]
    shift_potential: sp.Expr
    momenta: Mapping[str, sp.Expr]
    lower_limits: Mapping[str, sp.Symbol]
    characteristic_function: sp.Expr
    time_law: sp.Eq | None
    orbit_equations: Mapping[str, sp.Eq]
    chart: Chart | None = None

    @property
    def _shown_names(self) -> list[str]:  # without what follows from p² at once, and shifts that are zero
        names = ["system", "coordinates", "constants", "momentum_squared", *["shift"] * any(self.shift.values())]
        return [*names, "characteristic_function", "time_law", "orbit_equations", "chart"]

    @property
    def system_as_given(self) -> System:
        """The system in the coordinates that motions are started in: the user's, where others were found."""
        return self.system if self.chart is None else self.chart.original

    @property
    def principal_function(self) -> sp.Expr:
        """S = W − E t, Hamilton's principal function (5-65); where every coordinate is ignorable E is H(c), (5-74)."""
        shell = self.separation.shell
        t = sp.Symbol(time_name(self.system), real=True)
        return self.characteristic_function - (shell.energy if self.coordinates else shell.potential) * t

    @property
    def determinant(self) -> sp.Expr:
        """det(∂²S/∂q∂α) (5-48), which a complete integral keeps away from zero.

        Rows are the separated coordinates, then the ignorable ones; columns their constants in the order of
        ``constants``. It is the product of its diagonal blocks, det(∂Pᵢ²/∂αⱼ)/Π 2Pᵢ (5-154) and 1, since ∂W/∂q of an
        ignorable coordinate is its own constant. 1 where every coordinate is ignorable.
        """
        alphas = [c.symbol for c in separation_constants(self.separation)]
        roots = [(self.momentum_squared.get(n), self.momenta[n]) for n in self.coordinates]
        rows = [[sp.diff(p if square is None else square, α) for α in alphas] for square, p in roots]
        scale = [2 * sp.sqrt(square) for square, _ in roots if square is not None]
        return sp.Matrix(rows).det(method="berkowitz") / sp.Mul(*scale) if rows else sp.S.One

    @arguments.by_name('motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})')
    def motion(
        self,
        *,
        q: Mapping[str, object] | None = None,
        velocity: Mapping[str, object] | None = None,
        p: Mapping[str, object] | None = None,
        constants: Mapping[str, object] | None = None,
        signs: Mapping[str, int] | None = None,
        actions: Mapping[str, object] | None = None,
        angles: Mapping[str, object] | None = None,
        kinds: Mapping[str, str] | None = None,
        parameters: Mapping[str, object] | None = None,
        t0: object = 0,
        digits: int = 15,
        certified: bool = False,
        want: Iterable[str] | None = None,
        velocity_frame: str = "coordinate",
    ) -> Motion:
        """Start a motion: numbers for this solution.

        A number is an int, a float (the binary number it is), a Fraction, a Decimal, an ``mpf``, or a text such as
        "1.2", "1/24", "pi/3", "sqrt(2)", which is taken exactly.

        Args:
            q: coordinate → position at t0, every one; with ``chart`` the coordinates as the system was given in,
                beside constants those that were found.
            velocity: coordinate → velocity at t0, every one; or
            p: coordinate → canonical momentum at t0, every one; or
            constants: name of a constant of the motion (``Solution.constants``) → value, every one, with
            signs: separated coordinate → 1 or −1, the sign its root P = √P² starts with; needless where P = 0.
            actions: instead of the four above, coordinate → J, every one that has an action
                (``Motion.actions``); 0 is a coordinate at rest. With
            angles: coordinate → angle variable at t0 in radians (``Motion.angles``), 0 where left out. Where several
                tori have these actions, q gives a place in the well that is meant, or
            kinds: separated coordinate → libration or rotation.
            parameters: name → value, where it differs from the default.
            t0: time of the initial data.
            digits: relative digits wanted, from 1 on; float64 up to 15, ``mpf`` above.
            certified: prove constants, turning points, actions, frequencies and periods (needs the extra
                ``certified``); states stay estimates, at the digits asked.
            want: which quantities will be asked, such as ["actions", "periods"]; nothing else is integrated. None: all.
            velocity_frame: ``coordinate``: velocities are the rates of the coordinates; ``orthonormal``: lengths per
                time along their unit vectors (v_R, v_T = R φ̇, v_z), in polar, cylindrical, spherical or Cartesian
                coordinates.

        Returns:
            The motion: ``kinds``, ``turning_points``, ``constants``, ``actions``, ``frequencies``, ``periods``, and
            ``at(t)`` for its state at any time.

        Raises:
            InvalidInputError: initial data that are no numbers, incomplete, or outside the domain; arguments by
                position, or of unknown names; no torus has the actions, or several have.
            MissingValueError: a parameter or an initial value is missing.
            ForbiddenMotionError: no real motion has these constants.
            NotConvergedError: a turning point or an integral did not converge to the digits asked.

        Example:
            >>> import hjsolve
            >>> kepler = hjsolve.solve("kepler-planar")
            >>> motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
            >>> motion.kinds["r"], round(motion.periods["r"].value, 9)
            ('libration', 14.99332061)
        """
        # the one call from the symbolic half up into the numeric half: solving loads no numerical library
        from hjsolve.motion.charted.begin import StartGiven, start

        refuse_null(self)
        given = StartGiven(
            q=q, velocity=velocity, p=p, constants=constants, signs=signs, actions=actions, angles=angles, kinds=kinds,
            parameters=parameters, t0=t0, digits=digits, certified=certified, want=want, velocity_frame=velocity_frame,
        )  # fmt: skip
        return start(self, given)

    @arguments.by_name('torus(ratio={"r": 2, "theta": 3}, fixed={"E": "-3/10"})')
    def torus(
        self,
        *,
        frequencies: Mapping[str, object] | None = None,
        ratio: Mapping[str, object] | None = None,
        fixed: Mapping[str, object] | None = None,
        between: Mapping[str, tuple[object, object]] | None = None,
        kinds: Mapping[str, str] | None = None,
        parameters: Mapping[str, object] | None = None,
        digits: int = 15,
        certified: bool = False,
    ) -> Motion | tuple[Motion, ...]:
        """Find the motions that have given frequencies, or frequencies in a given ratio.

        With one unknown constant the whole family is looked through and every change of sign of the equation is
        followed; with several, Newton's method begins at motions all over phase space.

        Args:
            frequencies: coordinate → abs(Ω) in radians per unit time, > 0; or
            ratio: coordinates → positive numbers in the ratio of their abs(Ω): {"r": 2, "theta": 3} is
                3 abs(Ω_r) = 2 abs(Ω_theta).
            fixed: constant or parameter → value; leaves as many constants unknown as there are equations: one for
                each frequency, one less than a ratio has coordinates.
            between: constant → the least and the greatest value that are looked at; the whole family where left out.
            kinds: separated coordinate → libration or rotation, where only such motions are meant.
            parameters: name → value, where it differs from the default.
            digits: of the motions, at least 15.
            certified: the motions are certified, and the equation is proved to have a root within a part in
                10^(digits − 2) of the unknown: certified motions on both sides have opposite signs.

        Returns:
            The motion, or a tuple of them where several were found, by growing unknown.

        Raises:
            InvalidInputError: none was found (the error says what was looked at, and which ratios there are), all
                motions of the family have the ratio, or there are not as many unknowns as equations.
            NotConvergedError: a root could not be proved.

        Example:
            >>> isochrone = hjsolve.solve("isochrone")
            >>> motion = isochrone.torus(ratio={"r": 3, "theta": 2}, fixed={"E": "-1/5"})
            >>> round(motion.frequencies["r"].value / motion.frequencies["theta"].value, 13)
            1.5
        """
        # a call upward: the family is looked through by the engine of ensembles
        from hjsolve.resonances.found_tori import tori
        from hjsolve.resonances.question import asked

        question = asked(
            self, frequencies=frequencies, ratio=ratio, fixed=fixed, between=between, kinds=kinds,
            parameters=parameters, digits=digits, certified=certified,
        )  # fmt: skip
        return tori(question)

    @arguments.by_name('separatrices(fixed={"p_theta": "0.4"})')
    def separatrices(
        self,
        *,
        fixed: Mapping[str, object] | None = None,
        parameters: Mapping[str, object] | None = None,
        digits: int = 15,
    ) -> tuple[Separatrix, ...]:
        """Find the values of one constant at which a coordinate has a separatrix, the others held.

        There p² has a double zero that is a minimum: motions on either side are of different kinds, and the motion
        itself takes for ever to the unstable equilibrium, ``place``.

        Args:
            fixed: constant → value, every one but the one that is looked for.
            parameters: name → value, where it differs from the default.

        Returns:
            Each with ``value`` and ``place``, by growing value. A search on samples of each coordinate, every result
            solved to the digits asked.

        Raises:
            InvalidInputError: names that are not known, or not one constant that is left.

        Example:
            >>> pendulum = hjsolve.solve("pendulum")
            >>> [found.value.value for found in pendulum.separatrices(parameters={"g": 2})]
            [2.0]
        """
        # a call upward: the same search as of tori
        from hjsolve.resonances.double_zeros import separatrices

        return separatrices(self, fixed, parameters, arguments.digits(digits))

    @arguments.by_name('two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": "pi/2"}, time=3, turns=range(0, 3))')
    def two_point(
        self,
        *,
        q0: Mapping[str, object],
        q1: Mapping[str, object],
        time: object,
        turns: object = (0,),
        parameters: Mapping[str, object] | None = None,
        digits: int = 15,
        budget: float = 60.0,
    ) -> Connections | ConnectionTable:
        """Find every motion that joins two places in a given time (Greenwood §5-1; Lambert's problem).

        Args:
            q0, q1: coordinate → place at time 0 and after ``time``, every one, in the coordinates the system was
                given in; numbers as of ``motion``. In a Kepler problem also arrays of shape (n,): many problems.
            time: from q0 to q1, > 0; in a Kepler problem also an array of shape (n,).
            turns: numbers of whole turns, such as ``range(0, 3)``: whole periods of a single coordinate that the time
                holds, whole revolutions of an angle.
            parameters: name → value, where it differs from the default.
            digits: of the motions, from 1 on.
            budget: seconds for the proof that these are all, where it takes boxes or intervals of constants; what it
                leaves open in them ``complete`` names.

        Returns:
            ``Connections``: iterable over the motions, each with ``motion``, ``principal_function`` (S, with
            p0 = −∂S/∂q0 and p1 = ∂S/∂q1 (5-17), ∂S/∂T = −E (5-18)), ``conjugate_points`` and ``turns``; ``complete``
            says whether they are proved to be all, else where the search looked. Where a family of motions joins the
            places, ``continua`` says what is free; where none does, ``least_time`` is the least time in which one
            does. For arrays a ``ConnectionTable``, one row for each motion.

        Raises:
            InvalidInputError: places that are incomplete or outside the domain, a time that is not positive, turns
                that are not whole.
            MissingValueError: a parameter or a place is missing.
            NotConvergedError: the digits asked were not reached.

        Example:
            >>> import hjsolve
            >>> kepler = hjsolve.solve("kepler-planar")
            >>> quarter = {"r": 1, "theta": "pi/2"}
            >>> found = kepler.two_point(q0={"r": 1, "theta": 0}, q1=quarter, time="pi/2", turns=0)
            >>> [(c.path, round(c.principal_function.value, 6)) for c in found]
            [('counterclockwise', 2.356194), ('clockwise', 3.811747)]

        References:
            Lancaster and Blanchard, NASA TN D-5368 (1969); Izzo, Celestial Mechanics 121 (2015) 1.
        """
        from hjsolve.two_point.ask import two_point

        refuse_null(self)
        return two_point(
            self, q0=q0, q1=q1, time=time, turns=turns, parameters=parameters, digits=digits, budget=budget
        )  # fmt: skip

    def two_point_function(self) -> TwoPointFunction:
        """Return Hamilton's principal function of the two end points, S(q_0, q, t), as a formula.

        It exists where q(t) inverts: free particles, uniform fields, springs and inverted springs, and their sums over
        coordinates (Greenwood (5-108)). The Hamilton–Jacobi equation is proved at both ends.

        Returns:
            ``TwoPointFunction``: ``principal_function`` with p = ∂S/∂q and p_0 = −∂S/∂q_0 (5-17), and both proofs.

        Raises:
            InvalidInputError: T and V are of another kind; use ``two_point`` for numbers.
            NotConvergedError: a proof was not finished in its time.

        Example:
            >>> import hjsolve
            >>> fall = hjsolve.System({"y": "line"}, "dot(y)**2/2", "g*y", {"g": 1})
            >>> hjsolve.solve(fall).two_point_function().principal_function
            -g**2*t**3/24 - g*t*(y + y_0)/2 + (y - y_0)**2/(2*t)
        """
        from hjsolve.two_point.linear import two_point_function

        return two_point_function(self)


def refuse_null(solution: Solution) -> None:
    """Refuse numbers of a solution that holds a momentum to first degree.

    Raises:
        InvalidInputError: it does; the message says what to use instead.
    """
    names = ", ".join(solution.separation.shell.null)
    if names:
        raise InvalidInputError(
            f"H is linear in the momentum of {names} (T is indefinite): such a motion has no turning points "
            "and is not computed here; use the formulas, solution.momenta, time_law and orbit_equations"
        )


@arguments.with_known_names('solve(system, coordinates="find")')
@one_at_a_time
def solve(
    system: System | Separation | str | Path, coordinates: str = "as given", *, budget: float = DEFAULT_BUDGET
) -> Solution:
    """Solve a system by quadratures.

    A system that was solved before in this process is not solved again: equal systems share one solution.

    Args:
        system: a system, or the ``Separation`` it already gave; or the id or file of a catalog entry.
        coordinates: ``as given``; or ``find``: the given ones if they separate, else normal modes, else the simplest
            certified web of ``find_coordinates``. Motions are then started and expressed in the given ones all the
            same.
        budget: seconds for the decision in the given coordinates, and as many for the search for others.

    Returns:
        The solution; every integral stays unevaluated. Of a system whose T or V holds the time it is a
        ``SolutionInTime``: in a frame that is found, or with a quadratic principal function.

    Raises:
        NotSeparableError: the system does not separate in its coordinates, or that could not be decided; the error
            carries the verdict.
        InvalidInputError: neither a system nor a verdict; ``coordinates`` is neither of the two words; a negative
            budget.

    Example:
        >>> from hjsolve import System
        >>> V = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 2/sqrt((x - 3)**2 + (y + 1)**2)"
        >>> solution = solve(System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", V), coordinates="find")
        >>> solution.chart.kind, solution.coordinates
        ('elliptic', ('mu', 'nu'))

    References:
        Greenwood, Classical Dynamics (1977), (5-65)–(5-83), (5-142); Jacobi's theorem (5-53)–(5-62).
    """
    if coordinates not in (AS_GIVEN, FIND):
        raise InvalidInputError(
            f'coordinates: "{AS_GIVEN}" or "{FIND}" is needed, not {arguments.described(coordinates)}'
        )
    if isinstance(system, (Separation, Obstruction, Undecided)):
        return _solved(system)
    meant, seconds = system_of(system, "solve"), arguments.seconds(budget, "budget")
    if meant.time is not None:
        # a call upward: a frame is looked for, and solved in turn
        from hjsolve.extended.explicit_time import solve_in_time

        return cast("Solution", solve_in_time(meant, seconds, coordinates))
    return _remembered(meant, coordinates == FIND, seconds)


@lru_cache(maxsize=128)
def _remembered(system: System, find: bool, budget: float) -> Solution:
    """Return the solution of a system; a refusal raises and is not remembered, more time may decide it."""
    verdict = separate(system, budget=budget)
    if isinstance(verdict, Separation) or not find:
        return _solved(verdict)
    from hjsolve.coordinates.simplest_chart import find_chart  # a search costs a tenth of a second to load

    chart = find_chart(system, verdict, budget=budget)
    return replace(_solved(chart.separation), chart=chart)


def _solved(verdict: Verdict) -> Solution:
    if not isinstance(verdict, Separation):
        raise NotSeparableError(_why_not(verdict), verdict)
    shell, names = verdict.shell, tuple(c.name for c in verdict.shell.coordinates)
    halves = dict(zip(names, _separated_terms(verdict), strict=True))
    symbols = {c.name: c.symbol for c in shell.coordinates}
    squares = {n: rejoined(sp.expand_mul(2 * half), symbols[n]) for n, half in halves.items() if n not in shell.null}
    shift = dict(zip(names, shell.shift, strict=True))
    roots = {name: sp.sqrt(squares[name]) if name in squares else half for name, half in halves.items()}
    taken = names_taken(verdict)
    limits = {name: fresh_symbol(f"{name}_0", taken, real=True) for name in names}
    separated = [(c.symbol, roots[c.name], limits[c.name]) for c in shell.coordinates]
    W = sp.Add(
        *(c.momentum * c.symbol for c in shell.ignorable),
        *(quadrature(root, q, start) for q, root, start in separated),
        -shell.shift_potential,
    )
    momenta = {c.name: c.momentum for c in shell.ignorable} | {n: roots[n] - shift[n] for n in names}
    return Solution(
        system=verdict.system, separation=verdict, coordinates=names, constants=named_constants(verdict),
        momentum_squared=squares, shift=shift, shift_potential=shell.shift_potential,
        momenta={c.name: momenta[c.name] for c in verdict.system.coordinates}, lower_limits=limits,
        characteristic_function=W, time_law=time_law_of(verdict, separated, taken),
        orbit_equations=orbit_equations_of(verdict, separated, taken),
    )  # fmt: skip


def _separated_terms(verdict: Separation) -> tuple[sp.Expr, ...]:
    """½Pᵢ² = Σⱼ Φᵢⱼ αⱼ − ψᵢ, Greenwood (5-142), or pᵢ itself where null; none where every coordinate is ignorable."""
    staeckel = verdict.reduced.stackel
    if staeckel is None:
        return ()
    alphas: list[sp.Expr] = [c.symbol for c in separation_constants(verdict)]
    if verdict.system.relativity is not None:
        alphas[0] = shell_energy(verdict.system)
    Φ, ψ = staeckel.matrix, staeckel.column
    return tuple(sum(Φ[i, j] * α for j, α in enumerate(alphas)) - ψ[i] for i in range(len(ψ)))


def _why_not(verdict: Obstruction | Undecided) -> str:
    pair = " and ".join(verdict.pair)
    if isinstance(verdict, Undecided):
        return f"whether the system separates could not be decided ({pair}, {verdict.part}). {verdict.advice}"
    return f"the system does not separate in these coordinates: {pair} ({verdict.part}). {verdict.advice}"


__all__ = ["Solution", "separation_constants", "solve"]
