"""Derivatives of many orbits against closed forms and against single motions."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve
from benchmarks import galaxy_families
from benchmarks.batch_derivatives import galaxy_orbits
from hjsolve import System
from hjsolve.errors import InvalidInputError

many = mpmath.mp.clone()
many.dps = 40


def kepler_orbits(n, seed):
    rng = np.random.default_rng(seed)
    e, L = 10 ** rng.uniform(-6, -0.05, n), rng.uniform(0.3, 2, n)
    ψ = rng.uniform(0, 2 * np.pi, n)
    return {"r": L**2 / (1 + e * np.cos(ψ)), "theta": 0 * e}, {"r": e * np.sin(ψ) / L, "theta": L}


def test_kepler_in_closed_form_from_circles_to_needles():
    """∂Ω/∂E = −3 √(−2E), the same for both coordinates, and nothing by p_θ; E from the doubles that were given."""
    q, p = kepler_orbits(60, 1)
    found = hjsolve.ensemble_derivatives("kepler-planar", q=q, p=p)
    assert (found.status == "ok").all()
    for k in range(60):
        r, pr, L = (many.mpf(float(x[k])) for x in (q["r"], p["r"], p["theta"]))
        E = (pr**2 + (L / r) ** 2) / 2 - 1 / r
        for name in ("r", "theta"):
            for constant, truth in (("E", -3 * many.sqrt(-2 * E)), ("p_theta", many.mpf(0))):
                value, error = (table["frequencies"][name][constant][k] for table in (found.value, found.error))
                assert abs(many.mpf(float(value)) - truth) <= error
                assert error <= 1e-9 * (abs(truth) or 1 / float(L))
        value, error = (table["actions"]["r"]["E"][k] for table in (found.value, found.error))
        assert abs(many.mpf(float(value)) - (-2 * E) ** many.mpf("-1.5")) <= error


def against(found, exact, k):
    """Error, claim and truth of each derivative of one orbit: turning points have two, the lower and the upper one."""
    for quantity, names in found.value.items():
        for name, constants in names.items():
            for constant, column in constants.items():
                parts = column, found.error[quantity][name][constant], exact.value[quantity][name][constant]
                rows = zip(*parts, strict=True) if quantity == "turning_points" else [parts]
                for values, claims, true in rows:
                    truth = many.convert(true)
                    yield abs(many.mpf(float(values[k])) - truth), float(claims[k]), truth


@pytest.mark.nightly
@pytest.mark.parametrize("family", ["near-circular", "near-planar", "near-radial"])
def test_small_and_needle_like_orbits_have_derivatives(family):
    """J down to 1e-20 of the others, and pericentres down to 1e-8: one orbit in eight had derivatives."""
    q, p = galaxy_orbits(galaxy_families.family(family, 200))
    solution = galaxy_families.galaxy()
    found = hjsolve.ensemble_derivatives(solution, q=q, p=p)
    assert (found.status == "ok").mean() >= 0.98
    k = int(np.flatnonzero(found.status == "ok")[7])
    start = {g: {n: float(x[k]) for n, x in own.items()} for g, own in (("q", q), ("p", p))}
    exact = solution.motion(**start, digits=30).derivatives(set(found.value), {"constants"})
    for error, claim, _ in against(found, exact, k):
        assert error <= claim


def test_small_motions_next_to_either_end_of_a_domain():
    """A cone of light pendulums: θ near 0 and near π, seen from that end; ∂Ω/∂α by the mirror image."""
    system = System({"theta": "0 < theta < pi", "phi": "angle"},
                    "(dot(theta)**2 + sin(theta)**2*dot(phi)**2)/2", "sin(theta)**2 + sin(theta)**4")  # fmt: skip
    θ, pθ = np.array([1e-7, 1e-4, 0.1]), np.array([1e-9, 1e-5, 0.02])
    pφ = 0.8 * θ**2
    below, above = (
        hjsolve.ensemble_derivatives(system, q={"theta": place, "phi": 0 * θ}, p={"theta": pθ, "phi": pφ})
        for place in (θ, np.pi - θ)
    )
    assert (below.status == "ok").all()
    assert (above.status == "ok").all()
    for name in ("theta", "phi"):
        for constant in below.value["frequencies"][name]:
            one, other = (x.value["frequencies"][name][constant] for x in (below, above))
            room = sum(x.error["frequencies"][name][constant] for x in (below, above))
            # π − θ is rounded: E and p_φ are those of another orbit
            assert (np.abs(one - other) <= room + 1e-8 * np.abs(one)).all()


def test_pendulum_to_and_fro_and_over_the_top():
    """Ω = π/(2K(m)), m = (E + 1)/2, in a libration; π/(√(1/m) K(1/m)) over the top, by elliptic integrals."""
    system = System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
    v = np.array([1e-4, 0.3, 1.2, 1.9, 2.02, 2.06, 2.1, 2.2, 3.0, -3.0, 7.0])
    found = hjsolve.ensemble_derivatives(system, q={"x": 0.0 * v}, p={"x": v})
    assert (found.status == "ok").all()
    for k, speed in enumerate(v):
        E, sign = many.mpf(float(speed)) ** 2 / 2 - 1, 1 if speed > -2 else -1

        def Ω(energy, sign=sign):
            m = (energy + 1) / 2
            if m < 1:
                return many.pi / (2 * many.ellipk(m))
            return sign * many.pi * many.sqrt(m) / many.ellipk(1 / m)

        truth = many.diff(Ω, E, h=many.mpf(10) ** -12)
        value, error = (table["frequencies"]["x"]["E"][k] for table in (found.value, found.error))
        assert abs(many.mpf(float(value)) - truth) <= error + 1e-18
        assert error <= 1e-10 * abs(truth) + 1e-13


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["kuzmin-kutuzov", "spherical-pendulum", "isochrone"])
def test_claims_against_single_motions(name):
    rng = np.random.default_rng(3)
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    begin = hjsolve.catalog.describe(name).initial
    motion = solution.motion(**begin.arguments)
    values = motion.initial.values
    q, p = {}, {}
    for c in solution.system.coordinates:
        q[c.name] = float(values[c.symbol]) * rng.uniform(0.9, 1.1, 40)
        p[c.name] = float(values[c.momentum]) * rng.uniform(0.8, 1.2, 40)
    found = hjsolve.ensemble_derivatives(solution, q=q, p=p)
    assert (found.status == "ok").mean() > 0.9
    for k in np.flatnonzero(found.status == "ok")[:12]:
        one = solution.motion(
            q={n: float(x[k]) for n, x in q.items()}, p={n: float(x[k]) for n, x in p.items()}, digits=25
        ).derivatives(set(found.value), {"constants"})
        for error, claim, _ in against(found, one, k):
            assert error <= claim


def test_statuses_of_orbits_without_derivatives():
    found = hjsolve.ensemble_derivatives(
        "kepler-planar", q={"r": [1.0, 1.0], "theta": 0}, p={"r": 0, "theta": [1.2, 1.9]}
    )
    assert found.status.tolist() == ["ok", "unbounded"]
    assert np.isnan(found.value["frequencies"]["r"]["E"][1])
    assert np.isnan(found.error["frequencies"]["r"]["E"][1])


def test_refusals_say_what_to_write():
    with pytest.raises(InvalidInputError, match=r"write motion\.derivatives"):
        hjsolve.ensemble_derivatives("free-particle", q={}, p={})


@pytest.mark.nightly
def test_the_rounding_of_terms_that_cancel_is_in_the_claims():
    """On a path through the complex plane a narrow Gaussian is far larger than V: ∂Ω_φ/∂p_φ was 9.7e-11 ± 8.7e-11."""
    r = "(r/0.7717181362907177)"
    V = (f"1.1434773614902434*{r}**2 + 1.933189491063825*log(1.2323622217314072 + {r}**2)"
         f" + 0.22956812802305682*exp(-({r} - 1)**2/0.18925040035874843)")  # fmt: skip
    system = System({"r": "0 < r", "phi": "angle"}, "dot(r)**2/2 + r**2*dot(phi)**2/2", V)
    q, p = {"r": 2.159744611328811, "phi": 0.0}, {"r": 0.7618506625398624, "phi": 0.003869430978693262}
    found = hjsolve.ensemble_derivatives(system, q={n: np.full(1, x) for n, x in q.items()}, p=p)
    exact = hjsolve.solve(system).motion(q=q, p=p, digits=30).derivatives(set(found.value), {"constants"})
    assert found.status.tolist() == ["ok"]
    for error, claim, truth in against(found, exact, 0):
        assert error <= claim + 1e-25 * (1 + abs(truth))


def test_nearly_radial_orbits_of_the_isochrone_typed_with_its_root_have_derivatives():
    """Ω_r = (−2E)^{3/2} and ∂J_r/∂L = −(1 + L/√(L² + 4))/2 (Binney and Tremaine 3.226), down to l = 1e-12."""
    kinetic = "(dot(r)**2 + r**2*dot(theta)**2)/2"
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, kinetic, "-(sqrt(1+r**2)-1)/r**2")
    l = np.array([1e-1, 1e-4, 1e-8, 1e-12])
    found = hjsolve.ensemble_derivatives(system, q={"r": [1.0, 0.5, 2.0, 1.5], "theta": 0.1}, p={"r": 0.1, "theta": l})
    assert set(found.status) == {"ok"}
    E = np.asarray(found.batch.constants["E"])
    for truth, group, c in (
        (-3 * np.sqrt(-2 * E), "frequencies", "E"), (-(1 + l / np.hypot(l, 2)) / 2, "actions", "p_theta"),
    ):  # fmt: skip
        value, error = (np.asarray(x[group]["r"][c]) for x in (found.value, found.error))
        assert (np.abs(value - truth) <= error + 1e-15 * np.abs(truth)).all()
        assert (error <= 1e-10 * np.abs(truth)).all()


def test_periods_and_turning_points_of_kepler_in_closed_form():
    """T = 2π (−2E)^(−3/2); r = (1 ∓ e)/(−2E), e² = 1 + 2EL²: from the doubles that were given."""
    q, p = kepler_orbits(30, 2)
    found = hjsolve.ensemble_derivatives("kepler-planar", q=q, p=p)
    assert (found.ends["r"] == "ok").all()
    for k in range(30):
        r, pr, L = (many.mpf(float(x[k])) for x in (q["r"], p["r"], p["theta"]))
        E = (pr**2 + (L / r) ** 2) / 2 - 1 / r

        def end(E, L, side):
            return (1 + side * many.sqrt(1 + 2 * E * L**2)) / (-2 * E)

        truth = {("periods", "E"): 6 * many.pi * (-2 * E) ** many.mpf("-2.5"), ("periods", "p_theta"): many.mpf(0)}
        for (quantity, constant), exact in truth.items():
            value, error = (table[quantity]["r"][constant][k] for table in (found.value, found.error))
            assert abs(many.mpf(float(value)) - exact) <= error
            assert error <= 1e-8 * (abs(exact) or truth["periods", "E"] * abs(E / L))
        for i, side in enumerate((-1, 1)):
            for constant, exact in (
                ("E", many.diff(lambda x, side=side, L=L: end(x, L, side), E, h=many.mpf(10) ** -20)),
                ("p_theta", many.diff(lambda x, side=side, E=E: end(E, x, side), L, h=many.mpf(10) ** -20)),
            ):
                value, error = (table["turning_points"]["r"][constant][i][k] for table in (found.value, found.error))
                assert abs(many.mpf(float(value)) - exact) <= error + abs(exact) * many.mpf(10) ** -18
                assert error <= 1e-3 * abs(exact)


def test_where_a_derivative_does_not_exist_a_status_says_so():
    circle = hjsolve.ensemble_derivatives(
        "kepler-planar", q={"r": [1.0, 1.0], "theta": 0}, p={"r": 0, "theta": [1.0, 1.2]}
    )
    assert circle.status.tolist() == ["ok", "ok"]
    assert circle.ends["r"].tolist() == ["square_root", "ok"]
    assert np.isnan(circle.value["turning_points"]["r"]["E"][0][0])
    assert np.isfinite(circle.value["periods"]["r"]["E"]).all()
    assert len(circle.remarks) == 1
    assert "like √J" in circle.remarks[0]
    pendulum = System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
    separatrix = hjsolve.ensemble_derivatives(pendulum, q={"x": [0.0, 0.0]}, p={"x": [2.0, 1.0]})
    assert separatrix.status.tolist() == ["asymptotic", "ok"]
    assert "on a separatrix" in separatrix.remarks[0]


@pytest.mark.parametrize("kind", ["p", "velocity"])
def test_derivatives_by_initial_data_are_those_of_single_motions(kind):
    q, p = kepler_orbits(12, 3)
    rates = p if kind == "p" else {"r": p["r"], "theta": p["theta"] / q["r"] ** 2}
    found = hjsolve.ensemble_derivatives("kepler-planar", q=q, **{kind: rates}, by={"initial", "constants"})
    assert (found.status == "ok").all()
    assert set(found.value["actions"]["r"]) == {"E", "p_theta", "q.r", "q.theta", "p.r", "p.theta"}
    solution, of = hjsolve.solve("kepler-planar"), ("actions", "frequencies", "periods", "turning_points")
    for k in (0, 5, 11):
        start = {"q": {n: float(x[k]) for n, x in q.items()}, kind: {n: float(x[k]) for n, x in rates.items()}}
        exact = solution.motion(**start, digits=30).derivatives(of=of, by=("initial", "constants"))
        for off, claim, truth in against(found, exact, k):  # next to a circle ends move by a small difference
            assert off <= claim <= 1e-2 * (abs(truth) + 1)


def test_the_action_by_the_radial_momentum_is_what_keplers_formulas_give():
    # J_r = 1/sqrt(-2E) - |l|, so that dJ_r/dp_r = p_r (-2E)^(-3/2)
    q, p = kepler_orbits(40, 4)
    found = hjsolve.ensemble_derivatives("kepler-planar", q=q, p=p, by={"initial"})
    assert set(found.value["actions"]["r"]) == {"q.r", "q.theta", "p.r", "p.theta"}
    for k in range(40):
        r, pr, L = (many.mpf(float(x[k])) for x in (q["r"], p["r"], p["theta"]))
        E = (pr**2 + (L / r) ** 2) / 2 - 1 / r
        truth = pr * (-2 * E) ** many.mpf("-1.5")
        value, claim = (float(table["actions"]["r"]["p.r"][k]) for table in (found.value, found.error))
        assert abs(many.mpf(value) - truth) <= claim


def test_what_is_varied_is_named():
    start = {"q": {"r": [1.0], "theta": 0}, "p": {"r": 0.1, "theta": 1.1}}
    with pytest.raises(InvalidInputError, match="by: one or more of constants, initial, parameters are needed"):
        hjsolve.ensemble_derivatives("kepler-planar", **start, by={"mass"})


def test_derivatives_by_parameters_hold_q_and_p():
    # J_r = k sqrt(m)/sqrt(-2E) - |l| and Omega = (-2E)^(3/2)/(k sqrt(m)), E = (p_r^2 + l^2/r^2)/2m - k/r
    q, p = kepler_orbits(30, 6)
    values = {"m": 1.25, "k": 0.75}
    found = hjsolve.ensemble_derivatives("kepler-planar", q=q, p=p, by={"parameters"}, parameters=values)
    assert set(found.value["actions"]["r"]) == {"m", "k"}
    ok = np.flatnonzero(found.status == "ok")
    assert len(ok) > 20  # some are unbound with this k
    for i in ok:
        r, pr, L = (many.mpf(float(x[i])) for x in (q["r"], p["r"], p["theta"]))

        def energy(m, k, r=r, pr=pr, L=L):
            return (pr**2 + (L / r) ** 2) / (2 * m) - k / r

        truths = {
            "actions": lambda m, k, E=energy: k * many.sqrt(m) / many.sqrt(-2 * E(m, k)),
            "frequencies": lambda m, k, E=energy: (-2 * E(m, k)) ** many.mpf("1.5") / (k * many.sqrt(m)),
            "periods": lambda m, k, E=energy: 2 * many.pi * k * many.sqrt(m) / (-2 * E(m, k)) ** many.mpf("1.5"),
        }
        for quantity, formula in truths.items():
            for order, name in (((1, 0), "m"), ((0, 1), "k")):
                truth = many.diff(formula, (1.25, 0.75), order)
                value, claim = (float(table[quantity]["r"][name][i]) for table in (found.value, found.error))
                assert abs(many.mpf(value) - truth) <= claim
                assert claim <= 1e-8 * abs(truth) + 1e-10


@pytest.mark.parametrize("start", [0.4, 2.5])
def test_an_exponent_and_an_end_of_the_domain_are_parameters_like_others(start):
    """V = k rⁿ, differentiated by n; and a particle between r = b, where V has a pole, and a wall of potential."""
    power = System({"r": "0 < r", "phi": "angle"}, "(dot(r)**2 + r**2*dot(phi)**2)/2", "k*r**n", {"k": "2", "n": "3"})
    pole = System({"x": "b < x"}, "dot(x)**2/2", "c/(x - b)**2 + x**2/2", {"b": "1/10", "c": "1/100"})
    for system, q, p in (
        (power, {"r": [start], "phi": [0.1]}, {"r": [0.2], "phi": [0.9]}),
        (pole, {"x": [start]}, {"x": [0.3]}),
    ):
        solution = hjsolve.solve(system)
        found = hjsolve.ensemble_derivatives(solution, q=q, p=p, by=("parameters",))
        assert found.status.tolist() == ["ok"]
        start_ = {n: x[0] for n, x in q.items()}, {n: x[0] for n, x in p.items()}
        exact = solution.motion(q=start_[0], p=start_[1], digits=30).derivatives(set(found.value), {"parameters"})
        for error, claim, truth in against(found, exact, 0):
            assert error <= claim <= 1e-9 * (1 + abs(truth))


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name",
    [
        "kuzmin-kutuzov", "spherical-pendulum", "two-centres-space", "pendulum", "morse", "relativistic-kepler",
        "pendulum-on-block", "rod-with-sliding-end", "spring-in-moving-frame",
    ],
)  # fmt: skip
def test_derivatives_by_parameters_are_those_of_single_motions(name):
    rng = np.random.default_rng(8)
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    values = solution.motion(**hjsolve.catalog.describe(name).initial.arguments).initial.values
    q, p = {}, {}
    for c in solution.system.coordinates:
        q[c.name] = float(values[c.symbol]) * rng.uniform(0.95, 1.05, 12)
        p[c.name] = float(values[c.momentum]) * rng.uniform(0.9, 1.1, 12)
    found = hjsolve.ensemble_derivatives(solution, q=q, p=p, by={"initial", "parameters"})
    fine = np.flatnonzero(found.status == "ok")
    assert len(fine) > 9
    for k in fine[:4]:
        one = solution.motion(
            q={n: float(x[k]) for n, x in q.items()}, p={n: float(x[k]) for n, x in p.items()}, digits=25
        ).derivatives(set(found.value), {"initial", "parameters"})
        for error, claim, _ in against(found, one, k):
            assert error <= claim


def test_a_rotation_whose_momentum_is_shifted():
    """p = θ̇ + w (2 + cos θ)²: the mean of the shift is part of J, and moves with w."""
    kinetic, p = "dot(theta)**2/2 + w*(2 + cos(theta))**2*dot(theta)", [9.0, -14.0, 4.5]
    solution = hjsolve.solve(System({"theta": "angle"}, kinetic, "-k*cos(theta)", {"w": "1/2", "k": "3"}))
    found = hjsolve.ensemble_derivatives(solution, q={"theta": 0.4}, p={"theta": p}, by=("constants", "parameters"))
    assert found.status.tolist() == ["ok"] * 3
    assert [bool(np.isfinite(x)) for x in found.batch.turning_points["theta"][0]] == [False, False, True]
    for k, start in enumerate(p):
        motion = solution.motion(q={"theta": 0.4}, p={"theta": start}, digits=25)
        exact = motion.derivatives({"actions", "frequencies", "periods"}, {"constants", "parameters"})
        for quantity, names in exact.value.items():
            for key, truth in names["theta"].items():
                value, claim = (float(table[quantity]["theta"][key][k]) for table in (found.value, found.error))
                assert abs(many.mpf(value) - many.convert(truth)) <= claim <= 1e-9 * (1 + abs(truth))
