"""Systems whose T or V holds the time: solved in a frame that is found, or by a quadratic principal function.

First a frame is looked for in which the system is autonomous (``found_frames``); there it has to separate. Where none
serves and H is of second degree in q and p, S = ½ q·A q + B·q + C solves the Hamilton–Jacobi equation, with A, B and C
from the linear equations of motion (``quadratic_flow``). Otherwise the refusal names what was tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Mpf, Numbers
from hjsolve.display.shown import Shown
from hjsolve.errors import NotSeparableError, required
from hjsolve.extended.coefficients_of_action import PrincipalCoefficients, principal_coefficients
from hjsolve.extended.ends_of_domains import Wall, walls_of
from hjsolve.extended.found_frames import find_frame
from hjsolve.extended.gyroscopic import equations, phase_space
from hjsolve.extended.moving_frame import Frame
from hjsolve.extended.moving_frame_motion import FramedMotion, start_framed_motion
from hjsolve.extended.quadratic_flow import QuadraticFlow, with_action
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.motion.charted.collisions import between
from hjsolve.motion.initial_data import read_phase_point
from hjsolve.motion.shapes import by_coordinate
from hjsolve.motion.state import Errors, State
from hjsolve.motion.times import exact_numbers
from hjsolve.solution.quadratures import AS_GIVEN, Solution, solve

_EXAMPLE = 'motion(q={"x": 1}, velocity={"x": 0}, t0=0)'


@dataclass(frozen=True, repr=False)
class SolutionInTime(Shown):
    """The solution of a system whose T or V holds the time.

    Attributes:
        system: as posed.
        kind: ``frame`` or ``quadratic``.
        frame: in which it is autonomous; None where S is quadratic.
        solution: of the autonomous system, by quadratures; None where S is quadratic.
        tried: the kinds of frames that were looked for, in words.
    """

    system: System
    kind: str
    frame: Frame | None
    solution: Solution | None
    tried: tuple[str, ...]

    @property
    def principal_function(self) -> sp.Expr | None:
        """S(q, t) in the coordinates as posed, S = W(Q) − E t + Λ (5-65); None where its coefficients are numbers."""
        return None if self.frame is None else self.frame.principal_function(required(self.solution))

    @arguments.by_name(_EXAMPLE)
    def motion(
        self, *, q: Mapping[str, object], velocity: Mapping[str, object] | None = None,
        p: Mapping[str, object] | None = None, parameters: Mapping[str, object] | None = None,
        t0: object = 0, digits: int = 15,
    ) -> FramedMotion | QuadraticMotion:  # fmt: skip
        """Start a motion from initial data of the system as posed.

        Args:
            q: position of every coordinate at t0.
            velocity: of every coordinate, or
            p: its canonical momentum.
            parameters: values that differ from the defaults.
            t0: the initial time; it matters, since the system contains the time.
            digits: relative digits wanted.

        Raises:
            InvalidInputError: velocity and p both or neither.
            MissingValueError: a coordinate or a parameter without a value.
        """
        if self.frame is not None:
            return start_framed_motion(
                self.frame, q=q, velocity=velocity, p=p, parameters=parameters or {}, t0=t0, digits=digits,
                solution=self.solution,
            )  # fmt: skip
        return _quadratic_motion(self.system, q, velocity, p, parameters or {}, t0, arguments.digits(digits))


@dataclass(frozen=True, eq=False, repr=False)
class QuadraticMotion(Shown):
    """A motion of a system whose H is of second degree in q and p, with coefficients that depend on the time.

    Attributes:
        system: as posed.
        flow: its linear equations of motion.
        start: q and p at t0, exact.
        t0: the initial time, exact.
        digits: of the numbers.
        rest: H₀(t), H where q and p are 0.
        walls: ends of domains, where it ends.
    """

    system: System
    flow: QuadraticFlow
    start: tuple[sp.Expr, ...]
    t0: sp.Expr
    digits: int
    rest: sp.Expr
    walls: tuple[Wall, ...] = ()

    @property
    def kinds(self) -> Mapping[str, str]:
        """Empty: a motion that is driven has no kind for all times."""
        return {}

    @property
    def constants(self) -> Mapping[str, Estimate]:
        """The constants of the motion: the momenta α at t0, in which S is a complete integral."""
        n, bits = len(self.system.coordinates), bits_for(self.digits, 64)
        found = {}
        for c, p in zip(self.system.coordinates, self.start[n:], strict=True):
            value = sp.N(p, self.digits + 10)
            alpha = multiprecision(bits).convert(value)
            found[f"alpha_{c.name}"] = Estimate(alpha, abs(alpha) * 10.0**-self.digits)
        return found

    def at(self, t: object) -> State:
        """Return the state at a time or at an array of times; as ``Motion.at``, angles not counted in turns."""
        shape, times = exact_numbers(t, "t")
        digits = max(self.digits, 15)
        found, bounds, ends = self.flow.integrate([list(self.start)], self.t0, times, digits, self.walls)
        n = len(self.system.coordinates)
        rates, sizes = self._speeds(times, [states[0] for states in found])
        context = bounds[0].context if bounds else None
        unit = 2.0**-53 if self.digits <= 15 else required(context).mpf(10) ** -self.digits
        rows = np.array([[*states[0], *rate] for states, rate in zip(found, rates, strict=True)], dtype=object)
        errors = np.array([[*[e] * (2 * n), *(e * s for s in row)] for e, row in zip(bounds, sizes, strict=True)],
                          dtype=object)  # fmt: skip

        def uncertain() -> Errors:
            return Errors(*self._named(errors + unit * np.abs(rows), shape))

        q, p, velocity = self._named(rows, shape)
        state = State(t, q, p, velocity, {}, np.full(shape, "ok") if shape else "ok", uncertain)
        return state if ends == (None, None) else between(ends, state)

    def coefficients(self, t: object) -> PrincipalCoefficients:
        """Return A, B and C of S = ½ q·A q + B·q + C at a time, α = p(t0) constant: ∂S/∂q = A q + B and S(q, t0) = α·q.

        Args:
            t: one time, at which det ∂q/∂q(t0) is not 0.

        Raises:
            NotConvergedError: the time is conjugate to t0: det ∂q/∂q(t0) is 0, and S is not finite.
        """
        n, moment = len(self.system.coordinates), number(t, source="t")
        flow = with_action(self.flow, self.rest)
        zero = [sp.S.Zero] * (n + 1)
        alpha, still = [*zero, *self.start[n:], sp.S.One], [*zero, *zero[:n], sp.S.One]
        columns = [[sp.S.One if j == k else x for j, x in enumerate(still)] for k in range(n)]

        def followed(digits: int) -> tuple[list[list[Mpf]], Mpf]:
            (states,), (bound,), _ = flow.integrate([alpha, still, *columns], self.t0, [moment], digits)
            return states, bound

        return principal_coefficients(t, n, followed, max(self.digits, 15))

    def _speeds(self, times: list[sp.Expr], states: list[list[Mpf]]) -> tuple[list[list[Mpf]], list[list[Mpf]]]:
        """q̇ = ∂H/∂p at the times, and by how much an error of the state is enlarged in it."""
        n, rates, sizes = len(self.system.coordinates), [], []
        for t, z in zip(times, states, strict=True):
            context = z[0].context
            rows = self.flow.matrix[:n, :].row_join(self.flow.force[:n, :]).subs(self.flow.time, t)
            numbers = [[context.convert(sp.N(x, int(context.prec / 3) + 5)) for x in rows.row(i)] for i in range(n)]
            rates.append([context.fdot(row, [*z, 1]) for row in numbers])
            sizes.append([context.fsum(map(abs, row)) for row in numbers])
        return rates, sizes

    def _named(self, rows: Numbers, shape: tuple[int, ...]) -> Iterator[dict[str, AtTimes]]:
        columns = (rows.astype(float) if self.digits <= 15 else rows).T
        return by_coordinate([c.name for c in self.system.coordinates], columns, shape)


@lru_cache(maxsize=64)
def solve_in_time(system: System, budget: float, coordinates: str = AS_GIVEN) -> SolutionInTime:
    """Solve a system whose T or V holds the time.

    Args:
        system: as posed.
        budget: seconds for the decision in the frame that is found.
        coordinates: of the frame, as for ``solve``.

    Raises:
        NotSeparableError: no frame was found in which it is autonomous and separates, and H is not of second degree
            in q and p; the message names what was tried.
    """
    frame, tried = find_frame(system)
    refused: NotSeparableError | None = None
    if frame is not None:
        try:
            return SolutionInTime(system, "frame", frame, solve(frame.system, coordinates, budget=budget), tried)
        except NotSeparableError as error:
            refused = error
    if _quadratic(system) is not None:
        return SolutionInTime(system, "quadratic", None, None, tried)
    raise NotSeparableError(_refusal(tried, refused), None if refused is None else refused.verdict)


def _refusal(tried: tuple[str, ...], refused: NotSeparableError | None) -> str:
    words = f"{', '.join(tried[:-1])} and {tried[-1]}" if len(tried) > 1 else "".join(tried)
    if refused is not None:
        return f"T or V holds the time. In a frame that was found it does not, but there {refused}"
    return (
        f"T or V holds the time. Tried were {words}: in none of them is the system autonomous; nor is H of second "
        "degree in q and p. A frame of your own is declared by the table [frame] of an entry"
    )


def _quadratic(system: System) -> QuadraticFlow | None:
    """Return the linear equations of motion, where H is of second degree in z = (q, p)."""
    if system.relativity is not None or system.kinks or any(c.domain.kind == "angle" for c in system.coordinates):
        return None
    A, b = equations(system, {})
    if A.free_symbols & set(phase_space(system)):
        return None
    return QuadraticFlow(A.as_immutable(), b.as_immutable(), required(system.time))


def _quadratic_motion(
    system: System, q: Mapping[str, object], velocity: Mapping[str, object] | None, p: Mapping[str, object] | None,
    parameters: Mapping[str, object], t0: object, digits: int,
) -> QuadraticMotion:  # fmt: skip
    flow, start = required(_quadratic(system)), number(t0, source="t0")
    values, z = (
        read_phase_point(system, q, velocity, p, {**parameters, required(system.time).name: start}),
        phase_space(system),
    )
    fixed = {x.symbol: values[x.symbol] for x in system.parameters if x.symbol != system.time}
    numbers = QuadraticFlow(flow.matrix.subs(fixed), flow.force.subs(fixed), flow.time)
    rest = hamiltonian(system).subs(dict.fromkeys(z, 0)).subs(fixed)
    walls = walls_of(system, fixed)
    return QuadraticMotion(system, numbers, tuple(values[x] for x in z), start, digits, rest, walls)
