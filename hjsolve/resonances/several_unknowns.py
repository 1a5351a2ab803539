"""Tori from as many frequencies as there are unknown constants: Newton's method from motions all over phase space.

∂Ω/∂κ comes from the motion itself (``Motion.derivatives``). Where its determinant vanishes the frequencies do not
belong to isolated tori: Kepler's problem, or an inclination that Ω does not depend on.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.orbits import ensemble
from hjsolve.errors import HJSolveError, InvalidInputError
from hjsolve.lowering import lower
from hjsolve.mechanics.system import hamiltonian
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.motion import Motion
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.resonances.families import Well
from hjsolve.resonances.members import Member
from hjsolve.resonances.question import TorusQuestion, in_words

_SAMPLES, _STARTS, _APART = 6000, 10, 0.2
"""Motions that are looked at, how many of them Newton's method begins from, and by how much ln Ω of two differ."""
_NEWTON_STEPS, _HALVINGS_OF_A_STEP, _SPARE = 25, 8, 5
"""Steps of Newton's method, halvings of each, and decimal digits beyond those asked."""
_SINGULAR = 1e-9
"""Ratio of the singular values of ∂ ln Ω/∂ ln κ below which frequencies do not belong to isolated tori."""
_SAME = 1e-9


def tori_by_newton(asked: TorusQuestion) -> list[Motion]:
    """Return the tori that were found, in the order of their first constant.

    Raises:
        InvalidInputError: none was found.
    """
    shell = [c.momentum.name for c in asked.solution.system.coordinates if c.name not in asked.solution.coordinates]
    if odd := [name for name in asked.held if name not in shell]:
        raise InvalidInputError(
            "torus: with several unknowns fixed={…} takes momenta of ignorable coordinates and parameters, "
            f"not {odd[0]}"
        )
    batch = _motions(asked)
    order = _nearest(asked, batch)
    found: list[Member] = []
    degenerate = False
    for k in order:
        member, singular = _newton(asked, _member(asked, batch, int(k)))
        degenerate |= singular
        if member is not None and not any(_same(member, other) for other in found):
            found.append(member)
    if not found:
        raise InvalidInputError(_none(asked, batch, degenerate))
    first = next(iter(asked.unknown))
    found.sort(key=lambda member: float(member.constants[first]))
    users = [replace(member, solution=asked.users) for member in found]
    return [member.motion(asked.digits, certified=asked.certified) for member in users]


def _motions(asked: TorusQuestion) -> Batch:
    """Return motions all over phase space, with their frequencies, constants and turning points."""
    solution, rng = asked.solution, np.random.default_rng(20261126)
    coordinates = solution.system.coordinates
    curves = {curve.name: curve for curve in asked.curves}
    q = {
        c.name: rng.choice(_places(curves[c.name]), _SAMPLES) if c.name in curves else np.zeros(_SAMPLES)
        for c in coordinates
    }
    values = parameter_values(solution.system, asked.parameters)
    numbers = [np.float64(float(to_bits(v)(64))) for v in values.values()]
    H, still = hamiltonian(solution.system), {c.momentum: 0 for c in coordinates}
    V = H.xreplace(still)
    outputs = [sp.diff(V, c.symbol) * c.symbol for c in coordinates] + [sp.diff(H, c.momentum, 2) for c in coordinates]
    symbols = [*(c.symbol for c in coordinates), *(c.momentum for c in coordinates), *values]
    zeros = [np.zeros(_SAMPLES)] * len(coordinates)
    with np.errstate(all="ignore"):
        rows = lower(outputs, symbols).run(Float64(), [*q.values(), *zeros, *numbers])
        work = sum(np.abs(row) for row in rows[: len(coordinates)])
        speeds = [np.sqrt(work / np.abs(row)) * rng.uniform(0, 1.2, _SAMPLES) for row in rows[len(coordinates) :]]
    p = {c.name: np.broadcast_to(speed, _SAMPLES) for c, speed in zip(coordinates, speeds, strict=True)}
    for c in coordinates:
        if c.name not in curves and c.momentum.name in asked.held:
            p[c.name] = np.full(_SAMPLES, float(asked.held[c.momentum.name]))
    return ensemble(
        solution, q=q, p=p, want={"frequencies", "constants", "turning_points"}, fallback=False, shown=False,
        parameters=dict(asked.parameters),
    )  # fmt: skip


def _places(curve: RadicandCurve) -> Reals:
    """Return the samples of a coordinate, those next to its natural scale as often as all the others."""
    q = curve.samples()
    if curve.turn or (np.isfinite(curve.lower) and np.isfinite(curve.upper)):
        return q
    end = curve.lower if np.isfinite(curve.lower) else curve.upper if np.isfinite(curve.upper) else 0.0
    with np.errstate(divide="ignore"):
        near = q[np.abs(np.log2(np.abs(q - end))) < 6]
    return np.concatenate([q[np.abs(q - end) < 2.0**20], np.repeat(near, 4)])


def _nearest(asked: TorusQuestion, batch: Batch) -> list[int]:
    """Return which motions are nearest to what is asked, and apart from each other."""
    good = np.flatnonzero(np.asarray(batch.status == "ok"))
    if not len(good):
        return []
    rates = {name: np.asarray(rate)[good] for name, rate in batch.frequencies.items()}
    total = np.zeros(len(good))
    for equation in asked.equations:
        value, size = equation.of(rates)
        total += np.abs(value) / size
    for name, kind in asked.kinds.items():
        going = np.isnan(np.asarray(batch.turning_points[name][0])[good])
        total[going != (kind == "rotation")] = np.inf
    logarithms = np.log(np.abs(np.stack([rates[name] for name in rates])))
    chosen: list[int] = []
    for k in np.argsort(total, kind="stable"):
        if len(chosen) == _STARTS or not np.isfinite(total[k]):
            break
        if all(np.max(np.abs(logarithms[:, k] - logarithms[:, j])) > _APART for j in chosen):
            chosen.append(int(k))
    return [int(good[k]) for k in chosen]


def _member(asked: TorusQuestion, batch: Batch, k: int) -> Member:
    context = multiprecision(bits_for(asked.digits + _SPARE, 256))
    constants = {name: context.mpf(float(np.asarray(batch.constants[name])[k])) for name in asked.solution.constants}
    constants |= {name: to_bits(value)(context.prec) for name, value in asked.held.items()}
    wells = []
    for curve in asked.curves:
        ends = [float(np.asarray(end)[k]) for end in batch.turning_points[curve.name]]
        round_ = bool(np.isnan(ends).all())
        low, high = (-curve.turn / 2, curve.turn / 2) if round_ else ends
        wells.append(Well(low, high, (low + high) / 2, round_))
    return Member(asked.solution, asked.parameters, asked.curves, tuple(wells), constants)


def _newton(asked: TorusQuestion, member: Member) -> tuple[Member | None, bool]:
    """Return the torus that Newton's method leads to, None where to none; and whether ∂Ω/∂κ is singular."""
    digits, singular = 15, False
    seen = _seen(asked, member, digits)
    for _ in range(_NEWTON_STEPS):
        if seen is None:
            return None, singular
        residuals, allowed, slopes, member = seen
        if np.max(np.abs(residuals.astype(float)) / allowed) <= 1:
            if digits > asked.digits:
                return member, False
            digits = asked.digits + _SPARE
            seen = _seen(asked, member, digits)
            continue
        scale = np.array([abs(float(member.constants[name])) or 1.0 for name in asked.unknown])
        sizes = np.linalg.svd(slopes * scale / np.max(np.abs(slopes * scale), axis=1, keepdims=True))[1]
        if not sizes[-1] > _SINGULAR * sizes[0]:
            return None, True
        step = np.linalg.solve(slopes, -residuals.astype(float))
        seen = _damped(asked, member, step, (residuals, allowed), digits)
    return None, singular


_Seen = tuple[Reals, Reals, Reals, Member]
"""Residuals (many digits, as objects), what is allowed of them, ∂/∂κ, and the motion."""


def _damped(
    asked: TorusQuestion, member: Member, step: Reals, before: tuple[Reals, Reals], digits: int
) -> _Seen | None:  # fmt: skip
    old = float(np.max(np.abs(before[0].astype(float)) / before[1]))
    for halving in range(_HALVINGS_OF_A_STEP):
        constants = dict(member.constants)
        for name, change in zip(asked.unknown, step * 2.0**-halving, strict=True):
            constants[name] = constants[name] + float(change)
        seen = _seen(asked, replace(member, constants=constants), digits)
        if seen is not None and float(np.max(np.abs(seen[0].astype(float)) / seen[1])) < max(0.9 * old, 1.0):
            return seen
    return None


def _seen(asked: TorusQuestion, member: Member, digits: int) -> _Seen | None:
    """Evaluate the equations and their derivatives; None where there is no such motion."""
    try:
        motion = member.motion(digits)
        found = motion.derivatives({"frequencies"}, {"constants"})
    except HJSolveError:
        return None
    names = {name for equation in asked.equations for name in equation.weights}
    if not names <= motion.frequencies.keys():
        return None
    bits = bits_for(digits, 64)
    rows = [equation.exactly(motion.frequencies, bits) for equation in asked.equations]
    slopes = np.array(
        [
            [
                sum(
                    float(w)
                    * np.sign(float(motion.frequencies[name].value))
                    * float(found.value["frequencies"][name][constant])
                    for name, w in equation.weights.items()
                )
                for constant in asked.unknown
            ]
            for equation in asked.equations
        ]
    )
    if not np.isfinite(slopes).all():
        return None
    residuals = np.array([row[0] for row in rows], dtype=object)
    allowed = np.array([2 * row[1] + 1e-300 for row in rows])
    return residuals, allowed, slopes, replace(member, wells=_wells_of(member, motion))


def _wells_of(member: Member, motion: Motion) -> tuple[Well, ...]:
    wells = []
    for curve, well in zip(member.curves, member.wells, strict=True):
        low, high = motion.turning_points.get(curve.name, (None, None))
        if low is None or high is None:
            wells.append(well)
            continue
        ends = float(low.value), float(high.value)
        wells.append(Well(*ends, sum(ends) / 2, round=False))
    return tuple(wells)


def _same(one: Member, other: Member) -> bool:
    alike = all(
        abs(a - b) <= _SAME * max(abs(a), abs(b))
        for a, b in zip(one.constants.values(), other.constants.values(), strict=True)
    )
    return alike and all(a.meets(b, c.turn) for a, b, c in zip(one.wells, other.wells, one.curves, strict=True))


def _none(asked: TorusQuestion, batch: Batch, degenerate: bool) -> str:
    if degenerate:
        return (
            f"torus: {asked.words} does not belong to isolated tori: next to such a motion the frequencies do not "
            "depend on all the constants. Hold some of them, fixed={…}, and give fewer frequencies"
        )
    good = np.asarray(batch.status == "ok")
    if not good.any():
        return "torus: no bounded motion was found; fixed={…} and one unknown, with between={…}, looks more closely"
    names = sorted({name for equation in asked.equations for name in equation.weights})
    told = []
    for name in names:
        rate = np.abs(np.asarray(batch.frequencies[name])[good])
        told.append(f"Ω_{name} from {np.min(rate):.6g} to {np.max(rate):.6g}")
    held = ", ".join(f"{n} = {in_words(v)}" for n, v in asked.held.items())
    where = f" with {held}" if held else ""
    return f"torus: no motion with {asked.words} was found{where}; motions seen have {', '.join(told)}"
