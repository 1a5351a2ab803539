"""States of many orbits from actions and angles: against closed forms, single motions, and the way forth."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.ensembles.to_states import from_actions
from tests.support import entries, kuzmin_kutuzov

RANDOM = np.random.default_rng(5)


def kepler(J_r, L, M, θ):
    """r, p_r and the azimuth of a Kepler orbit with mean anomaly M, by Kepler's equation in 40 digits."""
    with mp.workdps(40):
        J_r, L, M, θ = (mp.mpf(float(x)) for x in (J_r, L, M, θ))
        n = J_r + abs(L)
        e = mp.sqrt(1 - (L / n) ** 2)
        E = mp.findroot(lambda x: x - e * mp.sin(x) - M, M + e * mp.sin(M) / (1 - e * mp.cos(M) / 2))
        r = n**2 * (1 - e * mp.cos(E))
        true = 2 * mp.atan2(mp.sqrt(1 + e) * mp.sin(E / 2), mp.sqrt(1 - e) * mp.cos(E / 2))
        return r, n * e * mp.sin(E) / r, θ + mp.sign(L) * (true - M)


def apart(one, other):
    """Distance of angles modulo 2π."""
    with mp.workdps(40):
        difference = mp.mpf(float(one)) - other
        return float(abs(difference - 2 * mp.pi * mp.nint(difference / (2 * mp.pi))))


@pytest.mark.nightly
def test_kepler_orbits_are_where_keplers_equation_says_within_their_claims():
    n = 30
    J_r = np.concatenate([10.0 ** RANDOM.uniform(-2, 0.5, n - 10), 10.0 ** RANDOM.uniform(-18, -6, 10)])
    L = RANDOM.choice([-1.0, 1.0], n) * 10.0 ** RANDOM.uniform(-1, 0.5, n)
    M, θ = RANDOM.uniform(-3, 3, (2, n))
    batch = hjsolve.ensemble(
        "kepler-planar", actions={"r": J_r, "theta": L}, angles={"r": M, "theta": θ}, want={"state"}
    )
    assert batch.status.tolist() == ["ok"] * n
    assert batch.recomputed.sum() <= 3
    for k in range(n):
        r, p, azimuth = kepler(J_r[k], L[k], M[k], θ[k])
        assert abs(batch.q["r"][k] - r) <= batch.error["q"]["r"][k] <= 1e-11 * r, k
        assert abs(batch.p["r"][k] - p) <= batch.error["p"]["r"][k], k
        assert apart(batch.q["theta"][k], azimuth) <= batch.error["q"]["theta"][k] <= 1e-9, k
        assert batch.p["theta"][k] == L[k]


@pytest.mark.nightly
def test_nearly_radial_kepler_orbits_are_where_keplers_equation_says_within_their_claims():
    """J_r was shifted by a part of the largest p times the width, 1/l too much: below l = 1e-5 every state was lost."""
    n = 24
    random = np.random.default_rng(3)
    J_r, L = random.uniform(0.3, 2, n), random.choice([-1.0, 1.0], n) * 10.0 ** random.uniform(-11, -1, n)
    M, θ = random.uniform(0.3, 3, n) * random.choice([-1.0, 1.0], n), random.uniform(-3, 3, n)
    batch = hjsolve.ensemble(
        "kepler-planar", actions={"r": J_r, "theta": L}, angles={"r": M, "theta": θ}, want={"state"}, fallback=False
    )
    assert batch.status.tolist() == ["ok"] * n
    for k in range(n):
        r, p, azimuth = kepler(J_r[k], L[k], M[k], θ[k])
        assert abs(batch.q["r"][k] - r) <= batch.error["q"]["r"][k] <= 1e-10 * r, k
        assert abs(batch.p["r"][k] - p) <= batch.error["p"]["r"][k], k
        assert apart(batch.q["theta"][k], azimuth) <= batch.error["q"]["theta"][k], k


@pytest.mark.nightly
@pytest.mark.parametrize("V", ["-log(1+r)/r", "-(1-exp(-r))/r", "-(sqrt(1+r**2)-1)/r**2"])
def test_states_of_nearly_radial_orbits_next_to_poles_that_cancel(V):
    kinetic = "(dot(r)**2 + r**2*dot(theta)**2)/2"
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r", "theta": "angle"}, kinetic, V))
    actions = {"r": [0.1, 0.12, 0.2, 0.1], "theta": [1e-3, 1e-6, 1e-9, 1e-12]}
    angles = {"r": [0.4, -2.0, 3.1, 1.0], "theta": [0.1, 1.0, -1.0, 2.0]}
    batch = hjsolve.ensemble(solution, actions=actions, angles=angles, fallback=False)
    assert batch.status.tolist() == ["ok"] * 4
    for k in range(4):
        given = ({key: column[k] for key, column in group.items()} for group in (actions, angles))
        state = solution.motion(**dict(zip(("actions", "angles"), given, strict=True))).at(0)
        for name in ("r", "theta"):
            far = apart(batch.q[name][k], state.q[name])
            assert far <= batch.error["q"][name][k] + state.error.q[name], (k, name)


def test_circles_rest_at_their_radius():
    batch = hjsolve.ensemble(
        "kepler-planar", actions={"r": 0, "theta": [1.0, -0.5, 3.0]}, angles={"theta": 0.25}, fallback=False
    )
    assert (batch.error["q"]["r"] < 1e-14 * batch.q["r"]).all()
    np.testing.assert_allclose(batch.q["r"], [1.0, 0.25, 9.0], rtol=4e-16, atol=0)
    assert batch.p["r"].tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(batch.q["theta"], 0.25, rtol=1e-14, atol=0)


@pytest.mark.nightly_cases("spherical-pendulum-actions2-kinds2")
@pytest.mark.parametrize(
    ("name", "actions", "kinds"),
    [
        ("pendulum", {"theta": [0.3, 4.0, 7.9]}, {"theta": "libration"}),
        ("pendulum", {"theta": [9.0, -9.0, 30.0]}, {}),
        ("spherical-pendulum", {"theta": [0.2, 2.0, 6.0], "phi": [0.5, -2.0, 0.05]}, {}),
        pytest.param(
            "two-centres-space",
            {"xi": [0.3, 0.2, 1.0], "eta": [0.4, 1.5, 0.1], "phi": [1.0, -0.5, 2.0]},
            {},
            marks=pytest.mark.nightly,
        ),
    ],
)
def test_states_are_those_of_single_motions(name, actions, kinds):
    angles = {key: [0.4, -2.0, 3.1] for key in actions}
    solution = entries.solved(name)
    batch = hjsolve.ensemble(solution, actions=actions, angles=angles, kinds=kinds, fallback=False)
    assert batch.status.tolist() == ["ok"] * 3
    for k in range(3):
        state = solution.motion(
            actions={n: x[k] for n, x in actions.items()}, angles={n: x[k] for n, x in angles.items()}, kinds=kinds
        ).at(0)
        for c in solution.system.coordinates:
            gap = abs(batch.q[c.name][k] - state.q[c.name])
            gap = min(gap, abs(gap - 2 * np.pi)) if c.domain.kind == "angle" else gap
            assert gap <= batch.error["q"][c.name][k] + state.error.q[c.name], (c.name, k)
            assert abs(batch.p[c.name][k] - state.p[c.name]) <= batch.error["p"][c.name][k] + state.error.p[c.name]


def there_and_back(count, fallback):
    """Relative residuals of J over what the reference allows, of orbits of the galaxy: J, θ to states, and again."""
    data = kuzmin_kutuzov.load()
    picked = np.concatenate([np.flatnonzero(data["family"] == f)[:count] for f in range(5)])
    q, p = kuzmin_kutuzov.start(data["prolate"][picked])
    forth = hjsolve.ensemble(kuzmin_kutuzov.solution(), q=q, p=p, want={"actions", "angles"})
    back = hjsolve.ensemble(
        kuzmin_kutuzov.solution(), actions=forth.actions, angles=forth.angles, want="state", fallback=fallback
    )
    again = hjsolve.ensemble(kuzmin_kutuzov.solution(), q=back.q, p=back.p, want={"actions"})
    worst = np.zeros(len(picked))
    for j, name in enumerate(("u", "w")):
        off = np.abs(again.actions[name] - forth.actions[name]) / forth.actions[name]
        worst = np.fmax(worst, off / np.fmax(1e-12, 20 * data["floor_prolate"][picked, j]))
    return back, again, worst


@pytest.mark.nightly
def test_no_orbit_of_the_galaxy_is_lost():
    """J comes back within 20 times the conditioning, but for the smallest J_w of nearly planar orbits."""
    back, again, worst = there_and_back(40, fallback=True)
    assert back.recomputed.sum() <= 2
    assert set(back.status) == {"ok"}
    assert set(again.status) == {"ok"}
    assert np.median(worst) < 0.05
    assert (worst < 1).mean() > 0.98
    assert worst.max() < 20


def nearly_unbound(count):
    """Actions and angles of the orbits that are bound least: they pass their inner turning point with tiny angles."""
    data = kuzmin_kutuzov.load()
    picked = np.flatnonzero(data["family"] == 4)[:count]
    q, p = kuzmin_kutuzov.start(data["prolate"][picked])
    return hjsolve.ensemble(kuzmin_kutuzov.solution(), q=q, p=p, want={"actions", "angles"})


@pytest.mark.nightly
def test_tiny_angles_keep_their_digits():
    """An orbit and its reversal in time, reflected so that p_φ stays, meet at opposite angles, however small they are."""
    forth = nearly_unbound(12)
    assert np.abs(forth.angles["u"]).min() < 1e-9
    solution, θ = kuzmin_kutuzov.solution(), np.linspace(-1, 1, 12) * 1e-14
    turned = {"u": θ, "w": forth.angles["w"], "phi": forth.angles["phi"]}
    back = {name: -x for name, x in turned.items()}
    one = hjsolve.ensemble(solution, actions=forth.actions, angles=turned, want={"state"}, fallback=False)
    other = hjsolve.ensemble(solution, actions=forth.actions, angles=back, fallback=False)
    assert set(one.status) == set(other.status) == {"ok"}
    for name in ("u", "w"):
        np.testing.assert_allclose(one.q[name], other.q[name], rtol=1e-9, atol=0)
        np.testing.assert_allclose(one.p[name], -other.p[name], rtol=1e-9, atol=0)
    assert np.ptp(one.q["u"][[0, 5]]) > 0.01
    assert (one.error["q"]["u"] < 1e-6).all()


def within_claims(batch, solution, actions, angles, k):
    """The state of 25 digits of an orbit, from which u and w and their momenta differ by no more than is claimed."""
    J, at = ({c: float(x[k]) for c, x in group.items()} for group in (actions, angles))
    state = solution.motion(actions=J, angles=at, digits=25).at(0)
    for c in ("u", "w"):
        assert abs(batch.q[c][k] - state.q[c]) <= batch.error["q"][c][k] + state.error.q[c], (c, k)
        assert abs(batch.p[c][k] - state.p[c]) <= batch.error["p"][c][k] + state.error.p[c], (c, k)
    return state


@pytest.mark.nightly
def test_nearly_unbound_states_are_those_of_25_digits_within_their_claims():
    forth, solution = nearly_unbound(40), kuzmin_kutuzov.solution()
    batch = hjsolve.ensemble(solution, actions=forth.actions, angles=forth.angles, want={"state"}, fallback=False)
    for k in range(0, 40, 6):
        state = within_claims(batch, solution, forth.actions, forth.angles, k)
        assert apart(batch.q["phi"][k], state.q["phi"]) <= batch.error["q"]["phi"][k] + float(state.error.q["phi"])


@pytest.mark.nightly
def test_the_smallest_motions_keep_their_claims():
    """Nearly circular orbits with J below 1e-20: what two doubles leave open of the constants is in the claims."""
    data, solution = kuzmin_kutuzov.load(), kuzmin_kutuzov.solution()
    forth = hjsolve.ensemble(solution, **dict(zip("qp", kuzmin_kutuzov.start(data["prolate"]), strict=True)))
    J, L = forth.actions["w"], forth.actions["phi"]
    picked = np.argsort(np.where(forth.codes == 0, J / np.abs(L), np.inf))[:6]
    wanted, angles = ({c: x[picked] for c, x in group.items()} for group in (forth.actions, forth.angles))
    wanted["w"] = wanted["w"] * 0.1
    batch = hjsolve.ensemble(solution, actions=wanted, angles=angles, want={"state"}, fallback=False)
    kept = np.flatnonzero(batch.codes == 0)
    assert len(kept) >= 3
    for k in kept:
        within_claims(batch, solution, wanted, angles, k)


def test_librations_whose_height_the_constants_do_not_know_have_their_action():
    """p_y² = 2(E − α) − 2(1 − E) y², so that J_y = (p_y² + 2(1 − E) y²)/√(8(1 − E)); E and α have 32 digits."""
    metric, J = "(2 + x**2 + y**2)", 10.0 ** -np.arange(9, 32, 2.0)
    system = hjsolve.System(
        {"x": "line", "y": "line"}, f"{metric}*(dot(x)**2 + dot(y)**2)/2", f"(x**2 + y**2)/{metric}"
    )
    actions, angles = {"x": 0.3, "y": J}, {"x": 0.4, "y": np.linspace(-3, 3, len(J))}
    states = hjsolve.ensemble(system, actions=actions, angles=angles, want={"state"}, fallback=False)
    assert (states.status == "ok").all()
    (x, y), (p_x, p_y) = ((group["x"], group["y"]) for group in (states.q, states.p))
    E = ((p_x**2 + p_y**2) / 2 + x**2 + y**2) / (2 + x**2 + y**2)
    found = (p_y**2 + 2 * (1 - E) * y**2) / np.sqrt(8 * (1 - E))
    assert (np.abs(found - J) <= 1e-13 * J).all(), np.abs(found - J) / J
    claimed = (np.abs(p_y) * states.error["p"]["y"] + 2 * (1 - E) * np.abs(y) * states.error["q"]["y"]) / J
    assert (claimed <= 1e-6).all()


@pytest.mark.parametrize("name", ["kepler-planar", "kepler-spherical"])
def test_nearly_circular_orbits_keep_the_digits_of_their_radial_action(name):
    J_r = 10.0 ** -np.arange(8.5, 30)
    M = np.linspace(-3, 3, len(J_r))
    inclined = {"phi": 0.5} if name == "kepler-spherical" else {}
    actions = {"r": J_r, "theta": 0.75 if inclined else 1.25, **inclined}
    states = hjsolve.ensemble(name, actions=actions, angles={"r": M}, want={"state"}, fallback=False)
    assert (states.status == "ok").all()
    for k in range(len(M)):
        with mp.workdps(80):
            n, mean = mp.mpf(J_r[k]) + mp.mpf(5) / 4, mp.mpf(M[k])
            e = mp.sqrt(1 - (mp.mpf(5) / 4 / n) ** 2)
            E = mp.findroot(lambda x, e=e, M=mean: x - e * mp.sin(x) - M, mean)
            r = n**2 * (1 - e * mp.cos(E))
            q, p = abs(states.q["r"][k] - r), abs(states.p["r"][k] - n * e * mp.sin(E) / r)
        assert q <= states.error["q"]["r"][k] <= 1e-12 * r
        assert p <= states.error["p"]["r"][k]


def test_bad_orbits_stop_nobody():
    batch = hjsolve.ensemble("kepler-planar", actions={"r": [0.1, -1.0, np.nan], "theta": 1.0}, angles={"r": 1.0})
    assert batch.status.tolist() == ["ok", "forbidden", "not_finite"]
    assert np.isnan(batch.q["r"][1:]).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"actions": {"r": [1.0]}}, "no values for theta"),
        ({"actions": {"r": 1, "theta": 1, "x": 1}}, "'x' has none"),
        ({"actions": {"r": 1, "theta": 1}, "p": {"r": 1}}, "p: is not used"),
        ({"actions": {"r": 1, "theta": 1}, "q": {"x": 1}}, "q: 'x' has none"),
        ({"actions": {"r": 1, "theta": 1}, "want": "actions"}, 'from actions "state" is computed'),
        ({"q": {"r": 1, "theta": 0}, "p": {"r": 0, "theta": 1}, "angles": {"r": 1}}, "angles: is not used"),
        ({}, "no q="),
    ],
)
def test_bad_input_names_what_is_wrong(arguments, words):
    with pytest.raises(hjsolve.InvalidInputError, match=words):
        hjsolve.ensemble("kepler-planar", **arguments)


@pytest.mark.nightly_cases("0.0-isochrone")
@pytest.mark.parametrize("name", ["kepler-planar", "pendulum", "isochrone", "stark"])
@pytest.mark.parametrize("angle", [0.0, pytest.param(1e-30, marks=pytest.mark.nightly)])
def test_the_states_at_the_lower_turning_points_need_no_single_motions(name, angle):
    # angles left out are 0: not one Kepler orbit was ok without single motions
    solution = entries.solved(name)
    rng, names = np.random.default_rng(4), [c.name for c in solution.system.coordinates]
    J = {key: 10 ** rng.uniform(-3, -0.5, 20) for key in names}
    batch = hjsolve.ensemble(solution, actions=J, angles=dict.fromkeys(names, angle), fallback=False)
    assert (batch.status == "ok").all()
    if name == "pendulum":
        assert (abs(batch.q["theta"]) < np.pi).all()  # not the same place some turns away
    for i in (0, 1):
        motion = solution.motion(actions={k: float(v[i]) for k, v in J.items()}, digits=30)
        state = motion.at(0)
        for group in ("q", "p"):
            for key in names:
                value, claim = (float(x[key][i]) for x in (getattr(batch, group), batch.error[group]))
                allowed = claim + 1e-16 * J[key][i] * (group == "p")  # of J itself, read as a decimal
                assert abs(mp.mpf(value) - mp.mpf(getattr(state, group)[key])) <= allowed, (group, key)


@pytest.mark.nightly
@pytest.mark.parametrize("V", ["-1/sqrt(1 + r**2)", "log(1 + r**2)/2"])
def test_tori_in_the_core_of_a_potential_are_found_in_a_batch(V):
    # J = 1e-9: E - V(0) is 1e-9 as well; not one of 40 orbits was ok without single motions
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", V)
    rng, n = np.random.default_rng(2), 12
    J = {key: 10.0 ** rng.uniform(-14, -4, n) for key in ("r", "theta")}
    θ = {key: rng.uniform(-3, 3, n) for key in J}
    batch = hjsolve.ensemble(system, actions=J, angles=θ, fallback=False)
    assert (batch.status == "ok").all()
    again = hjsolve.ensemble(system, q=batch.q, p=batch.p, want={"actions", "angles"}, fallback=False)
    assert np.allclose(again.actions["r"], J["r"], rtol=1e-11, atol=0)
    assert np.allclose(again.angles["r"], θ["r"], rtol=0, atol=1e-9)
    small = np.argmax(J["r"] + J["theta"])  # single motions search down to 1e-10
    motion = hjsolve.solve(system).motion(
        actions={k: sp.Rational(float(v[small])) for k, v in J.items()},
        angles={k: sp.Rational(float(v[small])) for k, v in θ.items()}, digits=30,
    )  # fmt: skip
    state = motion.at(0)
    for group, key in (("q", "r"), ("p", "r"), ("q", "theta")):
        value, claim = (float(x[key][small]) for x in (getattr(batch, group), batch.error[group]))
        assert abs(mp.mpf(value) - mp.mpf(getattr(state, group)[key])) <= claim, (group, key)


@pytest.mark.parametrize(
    "V", ["-1/sqrt(x**2 + y**2 + z**2)", "log(1 + x**2 + y**2 + z**2)/2", "(x**2 + y**2 + z**2)/2 + x*y/3"]
)
def test_states_on_tori_in_coordinates_that_were_found(V):
    system = hjsolve.System(dict.fromkeys("xyz", "line"), "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", V)
    solution = hjsolve.solve(system, "find")
    names, rng = [c.name for c in solution.system.coordinates], np.random.default_rng(1)
    J, θ = ({k: rng.uniform(low, high, 20) for k in names} for low, high in ((0.05, 0.5), (-3, 3)))
    batch = hjsolve.ensemble(system, coordinates="find", actions=J, angles=θ, fallback=False)
    assert (batch.status == "ok").all()
    assert set(batch.q) == set("xyz")
    again = hjsolve.ensemble(system, coordinates="find", q=batch.q, p=batch.p, want={"actions"}, fallback=False)
    for name in names:
        assert np.allclose(again.actions[name], J[name], rtol=1e-13, atol=0)
    exact = [{k: sp.Rational(float(x[0])) for k, x in group.items()} for group in (J, θ)]
    state = solution.motion(actions=exact[0], angles=exact[1], digits=30).at(0)
    for group in ("q", "p"):
        for name in "xyz":
            value, claim = (float(x[name][0]) for x in (getattr(batch, group), batch.error[group]))
            assert abs(mp.mpf(value) - mp.mpf(getattr(state, group)[name])) <= claim < 1e-9, (group, name)


def test_actions_that_two_tori_have_are_ambiguous_and_the_others_keep_their_states():
    # a pendulum that librates or rotates: J = 1.5 of a libration, or of a rotation; 0.5 of a libration alone
    system = hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
    batch = hjsolve.ensemble(system, actions={"x": [0.5, 1.5, -1.5]}, angles={"x": 0.3}, want={"state"})
    assert batch.status.tolist() == ["ok", "ambiguous", "ok"]
    assert np.isnan(batch.q["x"][1])
    with pytest.raises(hjsolve.SeveralToriError, match="choose one by"):
        hjsolve.solve(system).motion(actions={"x": 1.5})
    chosen = hjsolve.ensemble(system, actions={"x": [1.5]}, angles={"x": 0.3}, kinds={"x": "rotation"}, want={"state"})
    assert chosen.status.tolist() == ["ok"]
    # next to the separatrix the libration was missed, and the rotation was taken without a word
    J = 8 / np.pi * (1 - np.array([1e-3, 1e-5, 1e-7]))
    batch = hjsolve.ensemble(system, actions={"x": J}, angles={"x": 0.3}, want={"state"}, fallback=False)
    assert batch.status.tolist() == ["ambiguous"] * 3


def test_librations_next_to_a_separatrix_are_found_in_a_batch():
    # J of the cubic well at E = (1 − d)/6, to 30 digits; d = 1e-3 was left to single motions
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2 - x**3/3"))
    gaps = [1e-2, 1e-3, 1e-4, 1e-5]
    energies = [sp.Rational(1, 6) * (1 - sp.Rational(str(d))) for d in gaps]
    J = [
        float(solution.motion(q={"x": 0}, constants={"E": E}, signs={"x": 1}, digits=30).actions["x"].value)
        for E in energies
    ]
    batch = hjsolve.ensemble(solution, actions={"x": J}, angles={"x": 2.0}, want={"state"}, fallback=False)
    assert batch.status.tolist() == ["ok"] * 4
    for k, E in enumerate(energies):
        x, p = (mp.mpf(float(group["x"][k])) for group in (batch.q, batch.p))
        δx, δp = (float(batch.error[name]["x"][k]) for name in ("q", "p"))
        off = p**2 / 2 + x**2 / 2 - x**3 / 3 - mp.mpf(E.p) / E.q
        frequency = float(solution.motion(q={"x": 0}, constants={"E": E}, signs={"x": 1}).frequencies["x"])
        assert abs(off) <= abs(p) * δp + abs(x - x**2) * δx + 2e-16 * frequency * J[k] < 1e-9


def _hernquist():
    q = {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}
    T = "(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)/2"
    return hjsolve.solve(hjsolve.System(q, T, "-1/(1 + r)"))


@pytest.mark.parametrize(
    ("name", "actions", "angles", "q", "p"),
    [
        # nearly unbound: the last step of the phases moves θ_u by noise, of which φ_w makes 1e-6 radians
        (
            "galaxy", {"u": 7065.658388135006, "w": 0.9403639814185047, "phi": 0.24524810093952248},
            {"u": -8.811784635298636e-12, "w": -0.50156971063208, "phi": 1.4608075216910974},
            {"u": "1.66346339817781269279361599", "w": "0.34158744209059964209160680"},
            {"u": "-1.6398709403548038147016595", "w": "-1.3897804894803036176310329"},
        ),
        (
            "galaxy", {"u": 6215.738730506061, "w": 0.7368749277324476, "phi": 0.576647508752526},
            {"u": -1.4715839657952756e-11, "w": -0.5084366069786288, "phi": 1.5136221869141877},
            {"u": "1.77473573616856658053893574", "w": "0.30688064081369291837830795"},
            {"u": "-1.7517331415982029369819701", "w": "-1.3703247112954739609155774"},
        ),
        # next to a turning point the rounding of q is many roundings of P
        (
            "galaxy", {"u": 0.005421868776837102, "w": 0.3749029292569884, "phi": -0.7088596989474175},
            {"u": -0.013725177715932882, "w": -1.9909987497347807, "phi": 0.38434004343828254},
            {"u": "1.40793690783534102769027931", "w": "0.30347150463144163680445390"},
            {"u": "0.00064307148262917275673082", "w": "-0.9298780742007785166970855"},
        ),
        (
            "isochrone", {"r": 0.004159192307791693, "theta": 1.0613433321827794},
            {"r": 3.1373957201449216, "theta": -0.7275720141333251},
            {"r": "2.10392074120275883588196720", "theta": "-0.7270887113461389348194602"},
            {"r": "0.00019526735574487946058787"},
        ),
        # the centre is a 1e-12th of the width of the motion, and most of the azimuth is gained next to it
        (
            "isochrone", {"r": 396218.80405291036, "theta": 0.012133361567596083},
            {"r": -3.75402703777771e-08, "theta": 0.017836253721911444},
            {"r": "2905850.62597418508194007212", "theta": "-1.5664262684211816409586527"},
            {"r": "-0.0008296144500031367806533"},
        ),
        # the rounding of (∂J/∂c)⁻¹ mixed 1e-16 of θ into θ_r: p_r was wrong by 2e-4 of itself
        (
            "sphere", {"r": 0.9517272747280855, "theta": 0.051925996674762866, "phi": 0.029950147358269487},
            {"r": -2.209519962678636e-12, "theta": 3.068052229951687, "phi": -3.1042498900152737},
            {"theta": "2.760284530565321857223246"}, {"r": "-0.00000000033595633605398061"},
        ),
        (
            "sphere", {"r": 1.19996935827294, "theta": 0.0035972561770309373, "phi": 0.002106884050112244},
            {"r": 4.549911098164375e-09, "theta": 2.2651300575270295, "phi": -0.0006407552647142603},
            {"r": "0.0042977766151557976834", "theta": "2.2076074379954320788127"},
            {"r": "0.0000165874255813592590"},
        ),
    ],
)  # fmt: skip
def test_claims_hold_where_a_step_a_rounding_or_a_narrow_passage_was_not_counted(name, actions, angles, q, p):
    """Against single motions with 25 digits, whose values are written here."""
    solution = {"galaxy": kuzmin_kutuzov.solution, "sphere": _hernquist}.get(name, lambda: hjsolve.solve(name))()
    batch = hjsolve.ensemble(solution, actions=actions, angles=angles, want={"state"}, fallback=False)
    assert batch.status.item() == "ok"
    with mp.workdps(30):
        for rows, errors, wanted in ((batch.q, batch.error["q"], q), (batch.p, batch.error["p"], p)):
            for c, digits in wanted.items():
                assert abs(mp.mpf(float(rows[c])) - mp.mpf(digits)) <= float(errors[c]), c
                assert float(errors[c]) <= 1e-10 * max(1.0, abs(float(digits))), c


def test_states_do_not_depend_on_the_number_of_threads(monkeypatch):
    monkeypatch.setattr(from_actions, "_CHUNK", 16)
    dice = np.random.default_rng(4)
    actions = {"r": np.exp(dice.uniform(-6, 1, 70)), "theta": np.exp(dice.uniform(-2, 1, 70))}
    angles = {c: dice.uniform(-3, 3, 70) for c in actions}
    one, *others = (
        hjsolve.ensemble("isochrone", actions=actions, angles=angles, fallback=False, threads=threads)
        for threads in (1, 2, 4, None)
    )
    for other in others:
        assert (one.codes == other.codes).all()
        for mine, theirs in ((one.q, other.q), (one.p, other.p), (one.error["q"], other.error["q"])):
            for c in actions:
                np.testing.assert_array_equal(mine[c], theirs[c])
    with pytest.raises(hjsolve.InvalidInputError, match="threads"):
        hjsolve.ensemble("isochrone", actions=actions, angles=angles, threads=0)


_PENDULUM = hjsolve.System({"theta": "angle"}, "dot(theta)**2/2", "-cos(theta)")


def test_in_a_large_batch_no_kind_of_motion_is_missed_of_an_orbit_far_from_the_others():
    # a pendulum librates with J < 8/π and rotates with J > 4/π, ω = 1: in between both have the action
    J = np.random.default_rng(4).uniform(0.1, 1.0, 4096)
    J[[1001, 2003, 3005]] = 2.0, 3.0, 0.001
    batch = hjsolve.ensemble(_PENDULUM, actions={"theta": J}, want={"state"}, fallback=False)
    assert batch.status[[1001, 2003, 3005]].tolist() == ["ambiguous", "ok", "ok"]
    assert (np.delete(batch.status, 1001) == "ok").all()


def test_in_a_large_batch_both_kinds_of_motion_are_found_next_to_either_border():
    J = np.random.default_rng(5).uniform(0.1, 4.0, 4096)
    batch = hjsolve.ensemble(_PENDULUM, actions={"theta": J}, want={"state"}, fallback=False)
    both = np.abs(J - 6 / np.pi) < 2 / np.pi
    clear = np.minimum(np.abs(J - 4 / np.pi), np.abs(J - 8 / np.pi)) > 1e-3
    assert (batch.status == np.where(both, "ambiguous", "ok"))[clear].all()


def test_in_a_large_batch_no_second_well_is_missed_of_an_orbit_far_from_the_others():
    # above the crest there is one motion with each action, below one in either well
    wells = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4 - x**2/2 + x/20")
    J = np.random.default_rng(6).uniform(0.5, 0.8, 4096)
    J[2003] = 0.05
    batch = hjsolve.ensemble(wells, actions={"x": J}, want={"state"}, fallback=False)
    assert batch.status[2003] == "ambiguous"
    assert (np.delete(batch.status, 2003) == "ok").all()
