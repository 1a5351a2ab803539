"""Forces of degree one in each coordinate: q(t) inverts, so S(q0, q1, t) is a formula, and two_point is exact.

For T = Σ m q̇²/2 and V = Σ (κ q²/2 + g q) + V₀, with x = q − c, c = −g/κ, ω = √(κ/m), each coordinate adds to S

    κ > 0:  mω [(x₀² + x₁²) cos ωt − 2 x₀ x₁]/(2 sin ωt) + κ c² t/2          (Greenwood (5-108)),
    κ < 0:  the same with sinh, cosh and √(−κ/m),
    κ = 0:  m (q₁ − q₀)²/(2t) − g t (q₀ + q₁)/2 − g² t³/(24 m).

q1 is conjugate to q0 where ω t is a multiple of π: there q1 is ±x₀, whatever the momentum, or cannot be reached.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import number_is_zero, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.solution.quadratures import Solution
from hjsolve.theorem.complete_integral import CompleteIntegral, verify
from hjsolve.two_point.asked.answers import Completeness, Connection, Connections, Continuum
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.asked.verified import started

_BITS = 128


class Coefficients(NamedTuple):
    """One coordinate of a system with linear forces: m, κ and g."""

    mass: sp.Expr
    stiffness: sp.Expr
    pull: sp.Expr


class LinearForces(NamedTuple):
    """A system with linear forces: its coordinates by name, and V₀."""

    coordinates: Mapping[str, Coefficients]
    constant: sp.Expr


@dataclass(frozen=True, repr=False)
class TwoPointFunction(Shown):
    """Hamilton's principal function of the two end points, with its proofs.

    Attributes:
        principal_function: S(q_0, q, t): p = ∂S/∂q and p_0 = −∂S/∂q_0 (Greenwood (5-17)), H = −∂S/∂t (5-18).
        start: coordinate → symbol of its value at time 0.
        at_end: proof of ∂S/∂t + H(q, ∂S/∂q) = 0, with q_0 as the constants; det(∂²S/∂q∂q_0) is not zero.
        at_start: proof of ∂S/∂t + H(q_0, −∂S/∂q_0) = 0; H is even in the momenta.
    """

    principal_function: sp.Expr
    start: Mapping[str, sp.Symbol]
    at_end: CompleteIntegral
    at_start: CompleteIntegral


def linear_forces(system: System) -> LinearForces | None:
    """Recognise T = Σ m q̇²/2 with constant m, and V of degree two without products; None for another system.

    Args:
        system: the user's.
    """
    if system.relativity is not None or system.kinks or system.functions:
        return None
    symbols = [c.symbol for c in system.coordinates]
    if any(c.domain.kind != "line" for c in system.coordinates):
        return None
    V, T = sp.expand(system.potential), sp.expand(system.kinetic)
    if not V.is_polynomial(*symbols) or sp.Poly(V, *symbols).total_degree() > 2:
        return None
    result = {}
    for c in system.coordinates:
        mass, stiffness = sp.diff(T, c.velocity, 2), sp.diff(V, c.symbol, 2)
        if (mass.free_symbols | stiffness.free_symbols) & set(symbols):
            return None
        result[c.name] = Coefficients(mass, stiffness, sp.diff(V, c.symbol).subs(dict.fromkeys(symbols, 0)))
    plain = sp.Add(*(result[c.name].mass * c.velocity**2 / 2 for c in system.coordinates))
    square = sp.Add(*(result[c.name].stiffness * c.symbol**2 / 2 + result[c.name].pull * c.symbol
                      for c in system.coordinates))  # fmt: skip
    constant = V.subs(dict.fromkeys(symbols, 0))
    if sp.expand(T - plain) != 0 or sp.expand(V - square - constant) != 0:
        return None
    return LinearForces(result, constant)


def _kind(part: Coefficients) -> int:
    """Return the sign of κ/m; 2 where it is not known."""
    ratio = part.stiffness / part.mass
    if ratio == 0:
        return 0
    return 1 if ratio.is_positive else -1 if ratio.is_negative else 2


def action_of(part: Coefficients, kind: int, q0: sp.Expr, q1: sp.Expr, t: sp.Expr) -> sp.Expr:
    """Return what one coordinate adds to S.

    Args:
        part: its coefficients.
        kind: the sign of κ/m.
        q0, q1: its places.
        t: the time.
    """
    m, κ, g = part
    if kind == 0:
        return m * (q1 - q0) ** 2 / (2 * t) - g * t * (q0 + q1) / 2 - g**2 * t**3 / (24 * m)
    c = -g / κ
    ω = sp.sqrt(kind * κ / m).replace(sp.Abs, lambda x: x)  # S is even in ω
    sine, cosine = (sp.sin, sp.cos) if kind > 0 else (sp.sinh, sp.cosh)
    x0, x1 = q0 - c, q1 - c
    return m * ω * ((x0**2 + x1**2) * cosine(ω * t) - 2 * x0 * x1) / (2 * sine(ω * t)) + κ * c**2 * t / 2


def two_point_function(solution: Solution) -> TwoPointFunction:
    """Return S(q_0, q, t) of a system with linear forces; see ``Solution.two_point_function``.

    Raises:
        InvalidInputError: T and V are of another kind, or the sign of a constant of a spring is not declared.
        NotConvergedError: the proof was not finished in its time.
    """
    system = solution.system if solution.chart is None else solution.chart.original
    forces = linear_forces(system)
    if forces is None:
        raise InvalidInputError(
            "two_point_function: S(q_0, q, t) is a formula where T = sum of m*dot(q)**2/2 and V is a sum of k*q**2/2 "
            "and g*q over coordinates on a line; for numbers of any system use two_point(q0=…, q1=…, time=…)"
        )
    kinds = {}
    for name, part in forces.coordinates.items():
        kinds[name] = _kind(part)
        if kinds[name] == 2:  # of the sign that the default values give
            kinds[name] = _kind(Coefficients(*(e.xreplace(system.defaults) for e in part)))
        if kinds[name] == 2:
            raise InvalidInputError(
                f"two_point_function: the sign of {part.stiffness / part.mass} for {name} is not known; give the "
                "parameters values, whose signs are then taken"
            )
    start = {c.name: sp.Symbol(f"{c.name}_0", real=True) for c in system.coordinates}
    t = sp.Symbol(time_name(system), real=True)
    S = sp.Add(
        *(action_of(forces.coordinates[c.name], kinds[c.name], start[c.name], c.symbol, t) for c in system.coordinates),
        -forces.constant * t,
    )
    names = [s.name for s in start.values()]
    swap = {c.symbol: start[c.name] for c in system.coordinates} | {start[c.name]: c.symbol for c in system.coordinates}
    proofs = [verify(system, S=f, constants=names) for f in (S, S.xreplace(swap))]
    for proof in proofs:
        if not isinstance(proof, CompleteIntegral):
            raise NotConvergedError(f"two_point_function: the formula was not proved: {proof}")
    first, second = (p for p in proofs if isinstance(p, CompleteIntegral))
    return TwoPointFunction(S, start, first, second)


# ------------------------------------------------------------------------------------------------ numbers
def joined_linearly(
    forces: LinearForces, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]
) -> Connections:
    """Return the motion that joins two places, which is one, a continuum or none.

    Args:
        forces: of the system.
        question: what is asked.
        values: symbol → exact number, of the parameters.
    """
    t, free, blocked = question.time, [], []
    momenta: dict[str, sp.Expr] = {}
    conjugate, turns = 0, 0
    for name, symbolic in forces.coordinates.items():
        part = Coefficients(*(sp.sympify(e).xreplace(values) for e in symbolic))
        q0, q1, kind = question.q0[name], question.q1[name], _kind(part)
        momenta[name] = sp.S.Zero
        if kind > 0:
            angle = sp.sqrt(part.stiffness / part.mass) * t
            half_turns = to_bits(angle / sp.pi)(_BITS)
            exact = number_is_zero(sp.sin(angle))
            whole = int(half_turns + 0.5) if exact else int(half_turns)
            conjugate += whole - 1 if exact else whole
            turns = max(turns, whole // 2)
            if exact:
                c = -part.pull / part.stiffness
                if number_is_zero(q1 - c - (-1) ** whole * (q0 - c)):
                    free.append(name)
                else:
                    blocked.append(name)
                continue
        a, b = sp.Dummy(real=True), sp.Dummy(real=True)
        momenta[name] = -sp.diff(action_of(part, kind, a, b, t), a).subs({a: q0, b: q1})
    statement = "Complete: the forces are linear, so q1 is a linear function of the initial momentum"
    if blocked:
        return Connections((), Completeness(
            proved=True, statement=f"{statement}, which at this time it does not depend on ({', '.join(blocked)})"
        ))  # fmt: skip
    if turns not in question.turns:
        more = f"; the motion there is has {turns} whole period{'s' if turns != 1 else ''}"
        return Connections((), Completeness(proved=True, statement=statement + more))
    connection = _connection(forces, question, values, momenta, (conjugate, turns))
    proof = Completeness(proved=True, statement=statement)
    if not free:
        return Connections((connection,), proof)
    family = Continuum(
        statement="After whole half-periods every motion from q0 is at q1.",
        free=tuple(f"the initial momentum of {name}" for name in free),
        turns=turns,
        principal_function=connection.principal_function,
        member=connection,
    )
    return Connections((), proof, (family,))


def _connection(
    forces: LinearForces, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr],
    momenta: Mapping[str, sp.Expr],
    counts: tuple[int, int],
) -> Connection:  # fmt: skip
    t = question.time
    S, E, p1 = -forces.constant.xreplace(values) * t, forces.constant.xreplace(values), {}
    for name, symbolic in forces.coordinates.items():
        part = Coefficients(*(sp.sympify(e).xreplace(values) for e in symbolic))
        m, κ, g = part
        q0, q1, p0 = question.q0[name], question.q1[name], momenta[name]
        E += p0**2 / (2 * m) + κ * q0**2 / 2 + g * q0
        c = -g / κ if κ != 0 else sp.S.Zero
        p1[name] = _momentum_after(part, p0, q0 - c, t)
        # S = ½ (q p)|₀¹ + ∫ (½ q ∂V/∂q − V) dt, whatever the time: half of what x p gains, and V at the centre
        S += (q1 - c) * p1[name] / 2 - (q0 - c) * p0 / 2 + κ * c**2 * t / 2
        if κ == 0:
            S += -g * (q0 * t + p0 * t**2 / (2 * m) - g * t**3 / (6 * m)) / 2
    conjugate, turns = counts
    return Connection(
        turns=turns,
        path="directly" if not conjugate else f"through {conjugate} conjugate point{'s' if conjugate > 1 else ''}",
        p0={name: _rounded(p) for name, p in momenta.items()},
        p1={name: _rounded(p) for name, p in p1.items()},
        energy=_rounded(E),
        principal_function=_rounded(S),
        conjugate_points=conjugate,
        sweep={},
        begin=_Beginning(question, momenta),
    )


def _momentum_after(part: Coefficients, p0: sp.Expr, x0: sp.Expr, t: sp.Expr) -> sp.Expr:
    m, κ, g = part
    if κ == 0:
        return p0 - g * t
    ω = sp.sqrt(abs(κ / m))
    if κ / m < 0:
        return p0 * sp.cosh(ω * t) + m * ω * x0 * sp.sinh(ω * t)
    return p0 * sp.cos(ω * t) - m * ω * x0 * sp.sin(ω * t)


def _rounded(x: sp.Expr) -> Estimate:
    value = float(to_bits(sp.sympify(x))(_BITS))
    return Estimate(value, EPS * abs(value))


@dataclass(frozen=True)
class _Beginning:
    """How the motion starts."""

    question: TwoPlaceQuestion
    momenta: Mapping[str, sp.Expr]

    def __call__(self) -> Motion:
        """Return the motion."""
        bits = int(3.33 * (self.question.digits + 25))
        context = multiprecision(bits)
        return started(self.question, {n: context.convert(to_bits(p)(bits)) for n, p in self.momenta.items()})
