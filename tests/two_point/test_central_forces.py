"""Two places about a centre of force: enclosures of radial arcs against quadrature, proofs against Lambert and a search."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp
from sympy.integrals.quadrature import gauss_legendre

import hjsolve
from hjsolve.arithmetic.interval import Interval
from hjsolve.two_point.asked.central_force import RADIUS as R
from hjsolve.two_point.asked.central_force import central_force_of
from hjsolve.two_point.central.apsidal_arcs import ApsidalBoxes, SquarePotential, arcs_between_apsides
from hjsolve.two_point.central.isolated_constants import energy_and_momentum
from hjsolve.two_point.central.proved_search import all_motions
from hjsolve.two_point.central.radial_arcs import Boxes, arcs_of
from hjsolve.two_point.central.radial_grid import RadialPotential, cells_about, innermost
from hjsolve.two_point.central.radial_range import radial_problem

MP = mpmath.mp.clone()
MP.dps = 30
LOW, HIGH = 1.0, 1.6
POTENTIALS = {
    "Kepler": (-1 / R, lambda r: -1 / r),
    "logarithm": (sp.log(R), MP.log),
    "quartic": (R**4 / 4, lambda r: r**4 / 4),
    "Yukawa": (-sp.exp(-R / 3) / R, lambda r: -MP.exp(-r / 3) / r),
}


def quadrature(V, E, λ, apsides):
    """Time in units of √(m/2) and angle of the direct, outer and inner arc, to 20 digits, by r = c + w sin ψ."""
    p, a = apsides
    c, w = (p + a) / 2, (a - p) / 2
    cuts = [-MP.pi / 2, *(MP.asin((r - c) / w) for r in (MP.mpf(LOW), MP.mpf(HIGH))), MP.pi / 2]

    def rates(ψ):
        r = c + w * MP.sin(ψ)
        element = w * MP.cos(ψ) / MP.sqrt(r**2 * (E - V(r)) - λ**2)
        return r * element, λ / r * element

    found = []
    for begin, end in ((cuts[1], cuts[2]), (cuts[2], cuts[3]), (cuts[0], cuts[1])):
        middle, half = (begin + end) / 2, (end - begin) / 2
        sums = [MP.zero, MP.zero]
        for x, weight in zip(NODES, WEIGHTS, strict=True):
            sums = [t + half * weight * y for t, y in zip(sums, rates(middle + half * x), strict=True)]
        found.append(sums)
    return np.array(found, dtype=object).T


NODES, WEIGHTS = ([MP.mpf(str(z)) for z in row] for row in gauss_legendre(40, 30))


def box(x, y, size=0.0):
    return [Interval(np.array([[z * (1 - size)]]), np.array([[z * (1 + size)]])) for z in (x, y)]


def apsidal(V, x, y):
    """The arcs of the orbit with these parameters."""
    x, y = MP.mpf(x), MP.mpf(y)
    p, a = MP.mpf(LOW) ** 2 - x**2, MP.mpf(HIGH) ** 2 + y**2
    r = MP.sqrt(p), MP.sqrt(a)
    E = (a * V(r[1]) - p * V(r[0])) / (a - p)
    return quadrature(V, E, MP.sqrt(p * (E - V(r[0]))), r)


def encloses(x, values):
    """Whether an enclosure of one box holds some numbers."""
    return bool(np.all(x.low[..., 0] <= values) and np.all(values <= x.high[..., 0]))


@pytest.mark.parametrize("name", POTENTIALS)
@pytest.mark.parametrize(("x", "y"), [(0.3, 0.4), (0.7, 1.1), (0.05, 0.2)])
def test_arcs_between_apsides_and_their_slopes_are_enclosed(name, x, y):
    formula, V = POTENTIALS[name]
    P = SquarePotential(R, formula)
    true = apsidal(V, x, y)
    h = MP.mpf(10) ** -8
    moved = [(apsidal(V, x + i * h, y + j * h), apsidal(V, x - i * h, y - j * h)) for i, j in ((1, 0), (0, 1))]
    slopes = np.stack([(upper - lower) / (2 * h) for upper, lower in moved], axis=1)
    thin = arcs_between_apsides(P, ApsidalBoxes(*box(x, y), LOW**2, HIGH**2), 96, slopes=True)
    assert np.all(thin.there == 1)
    assert encloses(thin.values, true)
    assert np.max((thin.values.high - thin.values.low)[..., 0] / true.astype(float)) < 2e-3
    assert encloses(thin.slopes, slopes)
    wide = arcs_between_apsides(P, ApsidalBoxes(*box(x, y, 0.03), LOW**2, HIGH**2), 48, slopes=True)
    assert encloses(wide.slopes, slopes)
    for i, j in ((0.975, 0.975), (1.025, 0.975), (0.975, 1.025), (1.025, 1.025)):
        assert encloses(wide.values, apsidal(V, x * i, y * j))


@pytest.mark.parametrize("name", POTENTIALS)
@pytest.mark.parametrize(("s", "λ"), [("0.25", "0.3"), ("0.015", "0.5"), ("0.4", "0.1")])
def test_arcs_by_energy_and_angular_momentum_are_enclosed(name, s, λ):
    formula, V = POTENTIALS[name]
    potential = RadialPotential(R, formula)
    grid = cells_about(potential, (LOW, HIGH), 40.0, 1.004, potential.at_centre(innermost(LOW)))

    def true(s, λ):
        outer = MP.mpf(HIGH)
        E = V(outer) + λ**2 / outer**2 + s**2
        ends = []
        for start, factor in ((LOW, MP.mpf("0.999")), (HIGH, MP.mpf("1.001"))):
            r = MP.mpf(start)
            while r**2 * (E - V(r)) > λ**2:
                r *= factor
            ends.append(MP.findroot(lambda z: z**2 * (E - V(z)) - λ**2, (r, r / factor), solver="anderson"))
        return quadrature(V, E, λ, ends)

    h = MP.mpf(10) ** -7
    arcs = arcs_of(grid, Boxes(*box(float(s), float(λ)), np.array([grid.outer])), slopes=True)
    s, λ = MP.mpf(s), MP.mpf(λ)
    moved = (true(s + h, λ), true(s - h, λ)), (true(s, λ + h), true(s, λ - h))
    assert np.all(arcs.there == 1)
    assert encloses(arcs.values, true(s, λ))
    assert encloses(arcs.slopes, np.stack([(upper - lower) / (2 * h) for upper, lower in moved], axis=1))


@pytest.mark.parametrize(
    ("coordinates", "T", "V"),
    [
        ({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "log(r)"),
        ({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "log(x**2 + y**2)/2"),
    ],
)
def test_a_central_force_is_recognised(coordinates, T, V):
    force = central_force_of(hjsolve.System(coordinates, T, V))
    assert sp.simplify(force.potential - sp.log(R)) == 0


def test_a_force_towards_two_centres_is_not_central():
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "1/sqrt((x - 1)**2 + y**2)")
    assert central_force_of(system) is None


@pytest.mark.nightly
def test_the_proof_finds_the_two_conics_of_lambert():
    T, sweep = 3.0, 1.2
    angles = np.array([sweep, 2 * np.pi - sweep])
    problem = radial_problem(R, -1 / R, (LOW, HIGH), T * np.sqrt(2), angles, 0)
    proof = all_motions(problem)
    assert problem.settled
    assert not proof.undecided
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    conics = kepler.two_point(q0={"r": LOW, "theta": 0}, q1={"r": HIGH, "theta": sweep}, time=T, turns=0)
    found = sorted(energy_and_momentum(problem, m.chart, m.at)[0] for m in proof.motions)
    np.testing.assert_allclose(found, sorted(c.energy.value for c in conics), rtol=1e-2, atol=0)


@pytest.mark.nightly
@pytest.mark.parametrize(("V", "time"), [("log(r)", 2), ("log(r)", 4), ("-exp(-r/3)/r", 2)])
def test_a_central_force_is_complete_and_holds_all_that_a_search_finds(V, time, monkeypatch):
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", V)
    ask = {"q0": {"r": 1, "theta": 0}, "q1": {"r": "1.6", "theta": "1.2"}, "time": time, "turns": 0, "budget": 1000}
    proved = hjsolve.solve(system).two_point(**ask)
    assert proved.complete
    for c in proved:
        state = c.motion.at(time)
        assert abs(state.q["r"] - 1.6) < 1e-13
        assert abs(np.sin((state.q["theta"] - 1.2) / 2)) < 1e-13
    monkeypatch.setattr("hjsolve.two_point.ask.joined_about_a_centre", lambda *_: None)
    others = hjsolve.solve(system).two_point(**ask)
    assert len(others) <= len(proved)
    for other in others:
        assert any(abs(other.p0["theta"].value - c.p0["theta"].value) < 1e-9 for c in proved)


def test_where_the_force_repels_without_a_bound_a_search_answers():
    assert radial_problem(R, 1 / R, (LOW, HIGH), 3.0, np.array([1.2]), 0) is None


def test_without_seconds_for_the_proof_a_search_answers_and_says_so():
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "log(r)")
    ask = {"q0": {"r": 1, "theta": 0}, "q1": {"r": "1.6", "theta": "1.2"}, "time": 2}
    found = hjsolve.solve(system).two_point(**ask, budget=0)
    assert len(found) == 1
    assert not found.complete
    assert "budget=" in str(found.complete)
    with pytest.raises(hjsolve.InvalidInputError, match="a number of seconds"):
        hjsolve.solve(system).two_point(**ask, budget="long")
