"""The family of the same constants against Hamilton and Jacobi's equation, other quadratures, and known caustics."""

from __future__ import annotations

from functools import cache

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve import catalog
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.system import hamiltonian, mass_matrix

STARK = hjsolve.System(
    coordinates={"u": "line", "v": "line"},
    kinetic="m/2*(u**2 + v**2)*(dot(u)**2 + dot(v)**2)",
    potential="-2*k/(u**2 + v**2) - f*(u**2 - v**2)/2",
    parameters={"m": 1, "k": 1, "f": "1/20"},
    place={"x": "u**2/2 - v**2/2", "y": "u*v"},
)
NAMES = [
    "projectile",
    "kepler-planar",
    "isotropic-oscillator-polar",
    "two-centres-plane",
    "springs-planar",
    "stark in the plane",
]


@cache
def motion_of(name: str):
    if name == "stark in the plane":
        return hjsolve.solve(STARK).motion(q={"u": "0.9", "v": "0.4"}, velocity={"u": "0.2", "v": "0.9"})
    entry = catalog.describe(name)
    return hjsolve.solve(entry.system).motion(**entry.motions["default"].arguments)


@cache
def family_of(name: str):
    return hjsolve.wavefronts(motion_of(name), fronts=8, orbits=6)


def numbers(motion) -> dict:
    return {s: sp.N(v, 40) for s, v in motion.initial.values.items()} | {
        c.symbol: sp.N(motion.initial.constants[n], 40) for n, c in motion.solution.constants.items()
    }


@pytest.mark.parametrize("name", NAMES)
def test_the_gradient_of_w_obeys_hamilton_and_jacobis_equation(name: str) -> None:
    """H(q, ∂W/∂q) = E at every point of every front, within what the errors given allow."""
    family = family_of(name)
    system, values = family.motion.solution.system, numbers(family.motion)
    symbols = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    H = hamiltonian(system).subs({s: v for s, v in values.items() if s not in symbols})
    value, slopes = sp.lambdify(symbols, H), [sp.lambdify(symbols, sp.diff(H, s)) for s in symbols]
    E = float(family.motion.initial.constants["E"])
    for front in family.fronts:
        point = [front.q[c.name] for c in system.coordinates] + [front.p[c.name] for c in system.coordinates]
        errors = [front.error.q[c.name] for c in system.coordinates] + [
            front.error.p[c.name] for c in system.coordinates
        ]
        allowed = sum(np.abs(slope(*point)) * error for slope, error in zip(slopes, errors)) + 1e-14 * (abs(E) + 1)
        # in (q, p) along a sheet the errors of q and p go together, so their sum is not a bound on H; it is one on its parts
        assert np.all(
            np.abs(value(*point) - E) <= allowed + 1e-13 * (1 + np.abs(value(*point[:2], 0 * point[2], 0 * point[3])))
        )


@pytest.mark.nightly_cases("two-centres-plane")
@pytest.mark.parametrize("name", NAMES)
def test_w_on_a_front_is_what_quadratures_in_30_digits_say(name: str) -> None:
    """W = Σ ∫ P dq by mpmath, on the sheet where both momenta are positive."""
    family, motion = family_of(name), motion_of(name)
    values, solution = numbers(motion), motion.solution
    names = [c.name for c in solution.system.coordinates]
    start = {n: mpmath.mpf(str(values[solution.system.coordinate(n).symbol])) for n in names}
    checked = 0
    with mpmath.workdps(30):
        for front in family.fronts[1::3]:
            size = {n: np.abs(front.p[n]).max() for n in names}
            good = np.flatnonzero(np.all([front.p[n] > 0.05 * size[n] for n in names], axis=0))
            for k in good[:: max(1, len(good) // 4)]:
                W = sum(gained(motion, values, n, start[n], mpmath.mpf(float(front.q[n][k]))) for n in names)
                allowed = sum(2 * abs(front.p[n][k]) * front.error.q[n][k] for n in names) + 1e-15 * abs(front.value)
                assert abs(W - modulo(motion, W, front.value)) <= allowed + 1e-15
                checked += 1
    assert checked >= 2


def gained(motion, values, name: str, start, end):
    """∫ P dq from the start of the motion to a place on the sheet P > 0, by way of the lower turning point if it begins on the other."""
    solution = motion.solution
    coordinate = solution.system.coordinate(name)
    if name not in solution.coordinates:
        return mpmath.mpf(str(values[coordinate.momentum])) * (end - start)
    known = {s: v for s, v in values.items() if s not in (coordinate.symbol, coordinate.momentum)}
    F = sp.lambdify(coordinate.symbol, solution.momentum_squared[name].subs(known), "mpmath")
    begin = values[coordinate.momentum]
    ends = motion.turning_points.get(name, (None, None))

    def part(a, b):
        return mpmath.quad(lambda x: mpmath.sqrt(max(F(x), mpmath.mpf(0))), mpmath.linspace(a, b, 5))

    def between(a, b):
        """With q = a + (b − a) sin² s, which takes the roots away at either end."""
        return mpmath.quad(
            lambda s: (
                mpmath.sqrt(abs(F(a + (b - a) * mpmath.sin(s) ** 2))) * 2 * (b - a) * mpmath.sin(s) * mpmath.cos(s)
            ),
            mpmath.linspace(0, mpmath.pi / 2, 5),
        )

    if name not in motion.turning_points or begin > 0:
        return part(start, end)
    low = root_near(F, ends[0].value)
    return between(low, start) + between(low, end)


def root_near(F, place: float):
    return mpmath.findroot(
        F, (mpmath.mpf(place) * (1 - mpmath.mpf("1e-12")), mpmath.mpf(place) * (1 + mpmath.mpf("1e-12")))
    )


def modulo(motion, W, value: float):
    """The value of W nearest to W that a place may have: up to whole cycles of the bounded coordinates."""
    actions = [
        2 * mpmath.pi * mpmath.mpf(motion.actions[n].value) for n in motion.solution.coordinates if n in motion.actions
    ]
    if not actions:
        return mpmath.mpf(value)
    shifts = [mpmath.mpf(0)]
    for J in actions:
        shifts = [s + k * J for s in shifts for k in range(-2, 3)]
    return min((mpmath.mpf(value) + s for s in shifts), key=lambda v: abs(v - W))


@pytest.mark.nightly_cases("stark in the plane", "two-centres-plane")
@pytest.mark.parametrize("name", NAMES)
def test_orbits_cross_fronts_at_right_angles_in_the_metric_of_t(name: str) -> None:
    """The front through the place of an orbit at a time; its tangent by interpolation, the velocity from Motion.at."""
    motion = motion_of(name)
    names = [c.name for c in motion.solution.system.coordinates]
    family = family_of(name)
    span = max((float(e.value) for e in motion.periods.values()), default=1.0)
    t = np.linspace(-0.48, 0.49, 40) * span
    state = motion.at(t)
    fractions = [np.abs(np.asarray(state.p[n], float)) / np.nanmax(np.abs(family.orbits[0].p[n])) for n in names]
    best = np.argsort(np.min(fractions, axis=0))[-3:]
    W = motion.characteristic_function(t).value
    M = sp.lambdify([motion.solution.system.coordinate(n).symbol for n in names], mass_matrix(motion.solution.system).subs(
        {p.symbol: motion.initial.values[p.symbol] for p in motion.solution.system.parameters}))  # fmt: skip
    for k in best:
        place = np.array([float(state.unwrapped(n)[k]) for n in names])
        velocity = np.array([float(state.velocity[n][k]) for n in names])
        momenta = [float(state.p[n][k]) for n in names]
        tangent, miss = tangent_of(motion, family, float(W[k]), place, momenta, 11)
        coarse, approximate = tangent_of(motion, family, float(W[k]), place, momenta, 9)
        metric = np.array(M(*place), dtype=float)
        uncertainty = 1e-11 + np.abs(tangent - coarse).max()
        assert uncertainty < 1e-6  # of the interpolation, which is the test's own
        assert miss < 1e-12 + abs(miss - approximate)
        assert abs(velocity @ metric @ tangent) <= 2 * uncertainty * np.abs(velocity @ metric).sum()


def tangent_of(motion, family, W: float, place, momenta, many: int) -> tuple[np.ndarray, float]:
    """Tangent of the front through a place, from some of its points, and how far the place is from it."""
    names = [c.name for c in motion.solution.system.coordinates]
    periods = [2 * np.pi * float(motion.actions[n].value) for n in motion.solution.coordinates if n in motion.actions]
    best = None
    for a in range(-3, 4) if periods else [0]:
        for b in range(-3, 4) if len(periods) > 1 else [0]:
            front = family.front(W + sum(k * J for k, J in zip((a, b), periods)))
            q = [nearest(front.q[n], x, motion, n) for n, x in zip(names, place)]
            same = np.all([np.sign(front.p[n]) == np.sign(m) for n, m in zip(names, momenta)], axis=0)
            ok = np.flatnonzero(same & np.isfinite(q[0] + q[1]))
            if len(ok) < many + 2:
                continue
            distance = np.hypot(q[0][ok] - place[0], q[1][ok] - place[1])
            if best is None or distance.min() < best[0]:
                best = distance.min(), ok, q
    assert best is not None
    _, ok, q = best
    smooth = [smoothed(motion, n, values, x) for n, values, x in zip(names, q, place)]
    across = int(np.ptp(smooth[1][0][ok]) > np.ptp(smooth[0][0][ok]))
    order = ok[np.argsort(np.abs(smooth[across][0][ok]))][:many]
    s, y = smooth[across][0][order], smooth[1 - across][0][order]
    scale = np.abs(s).max()
    weights = np.linalg.solve(np.vander(s / scale, increasing=True), y)
    tangent = np.zeros(2)
    tangent[across], tangent[1 - across] = smooth[across][1], weights[1] / scale * smooth[1 - across][1]
    return tangent / np.abs(tangent).max(), float(abs(weights[0]))


def smoothed(motion, name: str, values, here: float) -> tuple[np.ndarray, float]:
    """A variable in which fronts are smooth at turning points, counted from a place, and dq/d(variable) there."""
    low, high = (None if e is None else float(e.value) for e in motion.turning_points.get(name, (None, None)))
    with np.errstate(invalid="ignore"):
        if low is not None and high is not None:
            middle, half = (low + high) / 2, (high - low) / 2
            s0 = np.arccos((middle - here) / half)
            return np.arccos((middle - values) / half) - s0, half * np.sin(s0)
        if high is not None:
            s0 = np.sqrt(high - here)
            return np.sqrt(high - values) - s0, -2 * s0
    return values - here, 1.0


def nearest(values, x: float, motion, name: str):
    if motion.solution.system.coordinate(name).domain.kind != "angle":
        return values
    return values - 2 * np.pi * np.round((values - x) / (2 * np.pi))


def test_caustics_are_the_known_curves() -> None:
    kepler = family_of("kepler-planar")
    E, L = mpmath.mpf(-7) / 25, mpmath.mpf(6) / 5
    e = mpmath.sqrt(1 + 2 * E * L**2)
    for caustic, r in zip(kepler.caustics, (L**2 / (1 + e), L**2 / (1 - e))):
        there = caustic.place
        assert np.all(np.abs(np.hypot(there["x"], there["y"]) - float(r)) <= 4e-16 * float(r) + caustic.error.q["r"])
    projectile = family_of("projectile")
    values = motion_of("projectile").initial.values
    by_name = {s.name: v for s, v in values.items()}
    top = by_name["y"] + by_name["p_y"] ** 2 / (2 * by_name["m"] ** 2 * by_name["g"])
    (line,) = projectile.caustics
    assert np.all(np.abs(line.q["y"] - float(top)) <= line.error.q["y"])


def test_caustics_of_two_centres_are_confocal_and_those_of_stark_parabolas() -> None:
    two = family_of("two-centres-plane")
    a = float({s.name: v for s, v in motion_of("two-centres-plane").initial.values.items()}["a"])
    assert len(two.caustics) == 2
    for caustic in two.caustics:
        x, y = caustic.place["x"], caustic.place["y"]
        sums = np.hypot(x - a, y) + np.hypot(x + a, y)
        assert np.all(
            np.abs(sums - 2 * a * np.cosh(caustic.value))
            <= 1e-14 * sums + 2 * a * caustic.error.q["xi"] * np.sinh(caustic.value)
        )
    stark = family_of("stark in the plane")
    assert {next(n for n in ("u", "v") if np.ptp(c.q[n]) == 0) for c in stark.caustics} == {"u", "v"}
    for caustic in stark.caustics:
        x, y, w = caustic.place["x"], caustic.place["y"], caustic.value
        sense = 1 if np.ptp(caustic.q["u"]) == 0 else -1
        assert np.all(
            np.abs(sense * (w**2 / 2 - y**2 / (2 * w**2)) - x)
            <= 1e-14 + 4 * sum(caustic.error.place[s] for s in "xy") * (1 + np.abs(y / w))
        )


@pytest.mark.parametrize("name", NAMES)
def test_every_orbit_of_the_family_touches_its_caustics_and_none_crosses_them(name: str) -> None:
    family = family_of(name)
    assert family.caustics
    for orbit in family.orbits:
        for coordinate, ends in family.motion.turning_points.items():
            q, error = orbit.q[coordinate], orbit.error.q[coordinate]
            for end, side in zip(ends, (1, -1)):
                if end is None:
                    continue
                gap = side * (q - float(end.value))
                assert np.all(gap[np.isfinite(gap)] >= -(2 * error[np.isfinite(gap)] + end.error))
                assert np.nanmin(gap) < 1e-2 * np.nanmax(np.abs(gap))


def test_the_moving_front_carries_the_motion() -> None:
    """S = W − E (t − t₀) keeps its value on a front that moves: the one of W(t) goes through q(t)."""
    motion, family = motion_of("kepler-planar"), family_of("kepler-planar")
    t = 2.5
    S = motion.principal_function(t).value
    assert family.front_at(t, S).value == pytest.approx(motion.characteristic_function(t).value, rel=1e-14, abs=0)


def test_what_has_no_wavefronts_says_so() -> None:
    spherical = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": 1})
    with pytest.raises(InvalidInputError, match="r rests"):
        hjsolve.wavefronts(spherical)
    pendulum = catalog.describe("pendulum")
    single = hjsolve.solve(pendulum.system).motion(**pendulum.motions["default"].arguments)
    with pytest.raises(InvalidInputError, match="two coordinates"):
        hjsolve.wavefronts(single)
    with pytest.raises(InvalidInputError, match="family is one of"):
        hjsolve.wavefronts(motion_of("kepler-planar"), "other")
    with pytest.raises(InvalidInputError, match="a Motion is needed"):
        hjsolve.wavefronts("kepler-planar")
