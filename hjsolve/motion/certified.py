"""Proved enclosures of a motion's numbers: ``motion(..., certified=True)``.

The kinds of motion and first guesses come from the ordinary computation; everything returned is then enclosed by balls
(``arithmetic/ball``): constants from the exact initial data, turning points by the interval Newton test, actions and
mean growths by quadrature with a proved error, frequencies from the inverse of the matrix of growths in ball
arithmetic.

A ``motion`` is computed without proof, a ``line`` is p² of a coordinate in balls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.arithmetic import ball
from hjsolve.arithmetic.ball import Balls, flint, from_mpf, working
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.certified.ball_radicand import BallMomentumSquared, turning_point
from hjsolve.certified.integrands import AnomalyMap, CycleIntegrand, all_round, between_turns
from hjsolve.certified.proved_turning_points import prove_turning_points
from hjsolve.certified.strip_bound import certified_means
from hjsolve.errors import InvalidInputError, NotConvergedError, required
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import Initial
from hjsolve.one_coordinate.anomaly import Libration, Rotation
from hjsolve.one_coordinate.classify import Located, ray
from hjsolve.one_coordinate.coordinate_motion import Anomaly, Periodic
from hjsolve.one_coordinate.coordinate_start import CoordinateStart
from hjsolve.one_coordinate.fourier_series import zero
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.turning_points import end_of
from hjsolve.solution.quadratures import Solution

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion

_FARTHEST = 4
"""Quarters of a turn from 0 up to which a centre of symmetry is looked for."""
_LONG = 60
"""Operations from which on a formula is not multiplied out to see whether it is even."""


@dataclass(frozen=True)
class Enclosed:
    """Enclosures of one motion; keys as in ``Motion``."""

    constants: Mapping[str, Estimate]
    turning_points: Mapping[str, tuple[Estimate | None, Estimate | None]]
    actions: Mapping[str, Estimate]
    frequencies: Mapping[str, Estimate]
    periods: Mapping[str, Estimate]


def work_bits(digits: int) -> int:
    """Return the precision to begin with; two words for 15 digits."""
    return bits_for(digits, 79)


def lines(
    radicands: Mapping[str, MomentumSquared], initial: Initial, solution: Solution, bits: int
) -> dict[str, BallMomentumSquared]:
    """Return p² of each separated coordinate in balls.

    Args:
        radicands: separated coordinate → p².

    Raises:
        MissingExtraError: python-flint is not installed.
    """
    ball.require_flint()
    with working(bits):
        exact = (*initial.constants.values(), *(initial.values[p.symbol] for p in solution.system.parameters))
        inputs = [exact_ball(value) for value in exact]
    return {name: BallMomentumSquared(radicand, inputs, bits) for name, radicand in radicands.items()}


def enclosed_numbers(motion: SeparatedMotion, digits: int, known: Mapping[str, BallMomentumSquared]) -> Enclosed:
    """Enclose all numbers of a bounded motion.

    Args:
        known: p² of each separated coordinate; worked out anew where more precision is needed.

    Returns:
        Estimates with ``certified`` True, each containing the truth.

    Raises:
        InvalidInputError: a coordinate neither librates nor rotates; that is not certified yet.
        NotConvergedError: an enclosure stayed wider than asked.
    """
    refuse_unfit(motion)
    work = work_bits(digits)
    # doubled six times, 79 bits become 5 000; the attempt after these says what is wrong
    for _ in range(6):
        try:
            with working(work):
                return _enclose(motion, digits, known)
        except NotConvergedError:
            work *= 2
            radicands = {name: line.radicand for name, line in known.items()}
            known = lines(radicands, motion.initial, motion.solution, work)
    with working(work):
        return _enclose(motion, digits, known)


def refuse_unfit(motion: SeparatedMotion) -> None:
    """Check that every coordinate librates, or is an angle that rotates.

    Raises:
        InvalidInputError: another kind, which is not certified yet.
    """
    located = {name: place.coordinate_motion for name, place in motion.located.items()}
    unfit = [(name, own.kind) for name, own in located.items() if own.cycle is None] + [
        (name, "rotation along a line") for name, own in located.items()
        if own.rotates and motion.solution.system.coordinate(name).domain.kind != "angle"
    ]  # fmt: skip
    if unfit:
        raise InvalidInputError(
            f"certified=True encloses librations and rotations of angles; {unfit[0][0]} is in {unfit[0][1]}"
        )


def _enclose(motion: SeparatedMotion, digits: int, known: Mapping[str, BallMomentumSquared]) -> Enclosed:
    cycles = {name: cycle_of(motion, name, line) for name, line in known.items()}
    constants = {name: exact_ball(value) for name, value in motion.initial.constants.items()}
    bits = bits_for(digits, 12)
    # all means of a coordinate in one pass: they share the nodes, and the bound on the strip
    found = {n: dict(zip(f.wanted, certified_means(f, bits), strict=True)) for n, f in cycles.items() if f.wanted}
    count = len(motion.solution.constants)
    growths = {n: [row.get(j, flint.arb(0)) for j in range(count)] for n, row in found.items()}
    actions = _actions(motion, found) if "action" in motion.parts else {}
    return rounded(motion, digits, cycles, (constants, actions, growths if "time" in motion.parts else {}))


def rounded(
    motion: SeparatedMotion, digits: int, cycles: Mapping[str, CycleIntegrand],
    balls: tuple[Mapping[str, flint.arb], Mapping[str, flint.arb], Mapping[str, list[flint.arb]]],
) -> Enclosed:  # fmt: skip
    """Return what is enclosed of a motion from balls, rounded.

    Args:
        cycles: separated coordinate → its integrands.
        balls: constants, actions, and the growths of Jacobi's integrals of every separated coordinate.

    Raises:
        NotConvergedError: a ball is wider than the digits asked.
    """
    constants, actions, growths = balls
    ends = {n: (f.lower, f.upper) for n, f in cycles.items() if f.lower is not None and f.upper is not None}
    frequencies = _frequencies(motion, growths) if growths else {}

    def estimates(values: Mapping[str, flint.arb]) -> dict[str, Estimate]:
        return {key: estimate(value, digits) for key, value in values.items()}

    # a ball that holds 0 has no proved period
    periods = {n: 2 * flint.arb.pi() / abs(f) for n, f in frequencies.items() if not f.contains(0)}
    pairs = {n: (estimate(a, digits), estimate(b, digits)) for n, (a, b) in ends.items()}
    return Enclosed(estimates(constants), pairs, estimates(actions), estimates(frequencies), estimates(periods))


def exact_ball(value: sp.Expr) -> flint.arb:
    """Enclose an exact number at the current precision."""
    if value.is_Rational:
        return Balls().rational(int(value.p), int(value.q))
    return lower([value], []).run(Balls(), [])[0]


def proved_libration(
    begin: CoordinateStart, initial: Initial, solution: Solution, line: BallMomentumSquared
) -> Located | None:
    """Prove that a coordinate librates, without integrating anything; None where that is not seen quickly.

    Args:
        initial, solution: where its initial place stands.
    """
    with working(line.bits):
        place = exact_ball(initial.values[solution.system.coordinate(begin.name).symbol])
    found = prove_turning_points(begin, place, line)
    if found is None:
        return None
    context = multiprecision(64)
    ends = [end_of(ray(begin, side), wall.inside, wall.outside) for side, wall in zip((-1, 1), found, strict=True)]
    a, b = (to_mpf(wall.guess, 128) for wall in found)
    # the plain cosine map: it is only asked for its turning points, which balls prove again
    anomaly = Libration(a, b - a, b, context.zero, context.zero, context.one, context.pi / 2)
    empty = [zero() for _ in begin.skipped]
    return Located(Periodic("libration", anomaly, empty, zero(), None, context.zero, begin.radicand), *ends)


def cycle_of(motion: SeparatedMotion, name: str, line: BallMomentumSquared) -> CycleIntegrand:
    """Prove the turning points and set up the integrands of one coordinate.

    Args:
        motion: computed without proof.

    Raises:
        NotConvergedError: a turning point is not proved to be one.
    """
    solution, coordinate_motion = motion.solution, motion.located[name].coordinate_motion.cycle
    coordinate_motion = required(coordinate_motion)
    anomaly = coordinate_motion.anomaly
    F = solution.momentum_squared[name]
    # ∂p²/∂αⱼ = 0 otherwise: no integral, and a proved zero
    held = [j for j, c in enumerate(solution.constants.values()) if c.symbol in F.free_symbols]
    wanted = tuple(held) if "time" in motion.parts else ()
    # the mean of a shift A over a turn is not enclosed yet; over a libration ∮ A dq = 0
    wanted += (-1,) if "action" in motion.parts and (anomaly.even or solution.shift[name] == 0) else ()
    q = solution.system.coordinate(name).symbol
    if not anomaly.even:
        slow = from_mpf(anomaly.slow) if isinstance(anomaly, Rotation) else flint.arb(0)
        centre = _centre(F, q, slow, turns=True)
        # p² even about a centre and periodic: half a turn has every value, so half of the nodes do
        symmetry = 1 if centre is None else 2
        slow = slow if centre is None else centre
        return CycleIntegrand(line, None, None, slow, wanted, spread=_spread_round(anomaly), symmetry=symmetry)
    a, b = (turning_point(line, from_mpf(guess), line.bits) for guess in coordinate_motion.turning_points)
    centre = _centre(F, q, (a + b) / 2, turns=False)
    mirrored = centre is not None and a < centre < b  # p² > 0 between: what is mirrored is the same region
    below = _near(line, a, b - a)
    near = (below, below if mirrored else _near(line, b, a - b))
    # the next zero or pole is a width away, or more: the cosine map has a wide strip already
    spread = between_turns(*near) if max(near) > 1 else None
    return CycleIntegrand(
        line, a, b, flint.arb(0), wanted, spread=spread, near=max(near), symmetry=4 if mirrored else 2
    )


def _near(line: BallMomentumSquared, end: flint.arb, inward: flint.arb) -> float:
    """Return the width over the distance of the next zero or pole of R = p²/((q−a)(b−q)) from a turning point.

    W|R′/R|.
    """
    # p² = s δ + h δ² about an end: R′/R = h/s + 1/W there, W counted inward
    _, slope, half = line.taylor(end, 3)
    return abs(float((inward * half / slope).mid()) + 1)


def _centre(F: sp.Expr, q: sp.Symbol, near: flint.arb, *, turns: bool) -> flint.arb | None:
    """Return a place nπ/2 about which p² is an even function by its form, if there is one at the place given."""
    n = near * 2 / flint.arb.pi()
    if not n.is_finite() or abs(n) > _FARTHEST:
        return None
    whole = round(float(n.mid()))
    close = abs(float(n.mid()) - whole) < 1e-6
    return whole * flint.arb.pi() / 2 if close and _even_about(F, q, whole, turns) else None


@lru_cache(maxsize=256)
def _even_about(F: sp.Expr, q: sp.Symbol, n: int, turns: bool) -> bool:
    """Return True when F(nπ − q) = F(q), and for a rotation F(q + 2π) = F(q), are identities."""

    def same(place: sp.Expr) -> bool:
        other = F.xreplace({q: place})
        return bool(other == F or (sp.count_ops(F) < _LONG and sp.expand(other - F) == 0))

    return same(n * sp.pi - q) and (not turns or same(q + 2 * sp.pi))


def _spread_round(anomaly: Anomaly) -> AnomalyMap | None:
    """Return the map of a rotation that is slow at one place, from k′² = (gap/2)²/(1 + (gap/2)²)."""
    if not isinstance(anomaly, Rotation) or anomaly.complement > 0.1:
        return None
    return all_round(2 * float(anomaly.complement) ** 0.5)


def _actions(motion: SeparatedMotion, found: Mapping[str, Mapping[int, flint.arb]]) -> dict[str, flint.arb]:
    result = {}
    for c in motion.solution.system.coordinates:
        if c.name in found:
            direction = motion.located[c.name].coordinate_motion.direction
            if -1 in found[c.name]:
                result[c.name] = direction * found[c.name][-1]
        elif c.name not in motion.located and c.domain.kind == "angle":
            result[c.name] = exact_ball(motion.initial.values[c.momentum])
    return result


def _frequencies(motion: SeparatedMotion, growths: Mapping[str, list[flint.arb]]) -> dict[str, flint.arb]:
    """Ω from the growths: first row of the inverse, and −Σ Ωᵢ·growth for ignorable angles."""
    names = list(motion.solution.coordinates)
    n = len(names)
    if n == 0:
        return {}
    # growthᵢⱼ = ∂Jᵢ/∂αⱼ, and E is the first constant: ∂E/∂J stands in a column of the inverse of the transpose
    matrix = flint.arb_mat([[growths[i][j] for i in names] for j in range(n)])
    rates = [matrix.inv()[k, 0] for k in range(n)]
    result = {}
    for c in motion.solution.system.coordinates:
        if c.name in names:
            direction = motion.located[c.name].coordinate_motion.direction
            result[c.name] = direction * rates[names.index(c.name)]
        # E(J, p_φ) at constant J: ∂E/∂p_φ = −Σ Ωᵢ ∂Jᵢ/∂p_φ
        elif c.domain.kind == "angle":
            j = list(motion.solution.constants).index(c.momentum.name)
            result[c.name] = -sum((rate * growths[i][j] for rate, i in zip(rates, names, strict=True)), flint.arb(0))
    return result


def estimate(value: flint.arb, digits: int) -> Estimate:
    """Return a ball as an estimate whose error holds the radius and the rounding of its centre.

    Args:
        value: a real ball.

    Raises:
        NotConvergedError: the ball is wider than the digits asked.
    """
    middle = value.mid()
    if digits <= 15:
        # the radius and the rounding of the centre at once, in balls: an upper bound of both
        approximate = float(middle)
        number: float | Mpf = approximate
        error: float | Mpf = float((value - flint.arb(approximate)).abs_upper()) * (1 + 2.0**-50)
        widest: float | Mpf = abs(approximate) * 10.0 ** (1 - digits)
    else:
        fine = to_mpf(middle, bits_for(digits, 16))
        number = fine
        error = to_mpf((value - from_mpf(fine)).abs_upper(), 64) * (1 + 2.0**-50)
        widest = abs(fine) * multiprecision(64).mpf(10) ** (1 - digits)
    if not value.is_finite() or error > widest:
        raise NotConvergedError("an enclosure stayed wider than the digits asked")
    return Estimate(number, error, certified=True)


def to_mpf(x: flint.arb, bits: int) -> Mpf:
    """Round the centre of a ball to an mpf.

    Args:
        x: a real ball.
    """
    mantissa, exponent = x.mid().man_exp()
    context = multiprecision(bits)
    return context.ldexp(context.convert(int(mantissa)), int(exponent))
