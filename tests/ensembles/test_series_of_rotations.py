"""Running series of tori that go round: their angles against those of the proved quadrature, and of elliptic integrals."""

import numpy as np
from mpmath import mp

import hjsolve
from hjsolve.ensembles.to_states import states_on_tori
from hjsolve.ensembles.to_states.angles_of_states import angles_at
from hjsolve.ensembles.to_states.followed_tori import angles_along
from hjsolve.ensembles.to_states.places_on_tori import placed
from hjsolve.ensembles.to_states.short_arcs import wrapped
from hjsolve.ensembles.to_states.tori import DOUBLES

ROTATIONS = {"kinds": {"theta": "rotation"}, "parameters": {"g": 1}}


def series_and_engine(monkeypatch, name, actions, angles, **more):
    """Return, for every kind of motion, whether coordinates go round, and angles at random phases: series, engine."""
    seen, dice, original = [], np.random.default_rng(1), states_on_tori.phases_of

    def watched(task, tori, frames, rough, given):
        φ = dice.uniform(-9, 9, given[0].shape)
        at = placed(task, tori, frames, φ)
        engine = angles_at(task, tori, frames, at, DOUBLES)
        good = rough.good & engine.good
        seen.append((frames.rotating[:, 0], good, angles_along(task, rough.series, φ)[0], engine.separated))
        return original(task, tori, frames, rough, given)

    monkeypatch.setattr(states_on_tori, "phases_of", watched)
    found = hjsolve.ensemble(name, actions=actions, angles=angles, want={"state"}, fallback=False, **more)
    assert (found.status == "ok").all()
    return seen


def test_geodesics_on_an_ellipsoid(monkeypatch):
    """Either coordinate goes round while the other one librates, mostly with two slow places."""
    dice = np.random.default_rng(5)
    names = [c.name for c in hjsolve.solve("triaxial-geodesics").system.coordinates]
    q, p = ({n: draw(60) for n in names} for draw in (lambda n: dice.uniform(-3, 3, n), dice.standard_normal))
    forth = hjsolve.ensemble("triaxial-geodesics", q=q, p=p, want={"actions", "angles"})
    seen = series_and_engine(monkeypatch, "triaxial-geodesics", dict(forth.actions), dict(forth.angles), q=q)
    assert {tuple(rotating) for rotating, *_ in seen} == {(True, False), (False, True)}
    for _, good, series, engine in seen:
        assert good.sum() >= 0.9 * len(good)
        assert np.abs(wrapped(series - engine))[:, good].max() < 1e-8


def test_pendulums_either_way(monkeypatch):
    """One slow place, the top: with m = 2 g/(E + g) the angle is π F(φ/2 | m)/K(m), of unit mass, length and g."""
    energies = np.array([1.001, 1.5, 4.0, 30.0])
    mp.dps = 20
    J = np.array([float(4 * mp.sqrt((E + 1) / 2) * mp.ellipe(2 / mp.mpf(E + 1)) / mp.pi) for E in energies])
    angles = np.linspace(-2.8, 2.9, 8)
    actions = {"theta": np.concatenate([J, -J])}
    found = hjsolve.ensemble(
        "pendulum", actions=actions, angles={"theta": angles}, want={"state"}, fallback=False, **ROTATIONS
    )
    assert (found.status == "ok").all()
    for k, θ in enumerate(angles):
        m = 2 / mp.mpf(energies[k % 4] + 1)
        q = 2 * mp.asin(mp.ellipfun("sn", mp.ellipk(m) * θ / mp.pi, m=m))
        assert abs(float(wrapped(np.array(found.q["theta"][k] - float(q))))) <= found.error["q"]["theta"][k]


def test_pendulums_by_series(monkeypatch):
    """Both senses, far from the separatrix and close to it."""
    actions, angles = {"theta": np.array([1.28, 2.0, 60.0, -1.4])}, {"theta": np.linspace(-2, 3, 4)}
    ((rotating, good, series, engine),) = series_and_engine(monkeypatch, "pendulum", actions, angles, **ROTATIONS)
    assert rotating.all()
    assert good.all()
    assert np.abs(wrapped(series - engine)).max() < 1e-8
