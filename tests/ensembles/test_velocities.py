"""Velocities in an ensemble: the rounding of momenta is counted, and harms nobody."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import Multi
from hjsolve.ensembles.engine.starts import MomentumRule, from_velocities
from hjsolve.lowering import lower
from tests.support import kuzmin_kutuzov as galaxy

NAMES = ("u", "w", "phi")
WANT = ("actions", "frequencies")


def _rates(prolate: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Places, and velocities near those of some momenta."""
    q, p = galaxy.start(prolate)
    size = np.sinh(q["u"]) ** 2 + np.cos(q["w"]) ** 2
    round_ = (np.sinh(q["u"]) * np.cos(q["w"])) ** 2
    return q, {"u": p["u"] / size, "w": p["w"] / size, "phi": p["phi"] / round_}


@pytest.mark.nightly
def test_claims_hold_for_velocities() -> None:
    """Each family, against 30 digits from the same velocities; rounding p first would be off by its own floor."""
    data = galaxy.load()
    chosen = np.array([np.flatnonzero(data["family"] == k)[3] for k in range(5)])
    q, v = _rates(data["prolate"][chosen])
    batch = hjsolve.ensemble(galaxy.solution(), q, velocity=v, want=WANT, threads=1, fallback=False)
    assert (batch.status == "ok").all()
    for k, orbit in enumerate(chosen):
        truth = galaxy.solution().motion(
            q={n: float(q[n][k]) for n in NAMES}, velocity={n: float(v[n][k]) for n in NAMES}, digits=30, want=WANT
        )
        for quantity in WANT:
            for name in NAMES:
                exact = getattr(truth, quantity)[name].value
                value, claim = (
                    float(x[quantity][name][k]) for x in ({quantity: getattr(batch, quantity)}, batch.error)
                )
                assert abs(mpf(value) - exact) <= claim + 2.0**-53 * abs(exact), (orbit, quantity, name)
                assert claim <= 4e-11 * abs(value), (orbit, quantity, name)


def test_angular_momentum_has_the_error_of_its_rounding() -> None:
    r, rate = np.array([1.1, 0.7]), np.array([0.9, 1.3])
    batch = hjsolve.ensemble(
        "kepler-planar", q={"r": r, "theta": 0}, velocity={"r": 0.1, "theta": rate}, want="actions", threads=1
    )
    with mp.workdps(40):
        exact = [mpf(x) ** 2 * mpf(y) for x, y in zip(r.tolist(), rate.tolist(), strict=True)]
    for value, claim, true in zip(batch.actions["theta"], batch.error["actions"]["theta"], exact, strict=True):
        assert 0 < abs(mpf(float(value)) - true) <= claim < 1e-15


def test_momenta_that_are_exact_stay_so() -> None:
    """p = v for mass 1: no bit depends on how the start is given."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2 + x**4/4")
    q, v = {"x": np.linspace(-1, 1, 50)}, {"x": np.linspace(0.3, 1, 50)}
    one = hjsolve.ensemble(system, q, p=v, threads=1)
    other = hjsolve.ensemble(system, q, velocity=v, threads=1)
    for name in one.columns:
        assert one.columns[name].tobytes() == other.columns[name].tobytes(), name


def test_a_momentum_that_cancels_has_an_error_of_the_size_of_its_terms() -> None:
    """p = (sin²q + cos²q − 1) v is zero; two doubles make it 1e-33 or so."""
    q, v = sp.symbols("q v")
    rule = MomentumRule(lower([v * (sp.sin(q) ** 2 + sp.cos(q) ** 2 - 1)], [q, v]), ())
    starts = from_velocities(rule, np.linspace(0.1, 3, 40)[None], np.full((1, 40), 0.7))
    assert (np.abs(starts.p) <= starts.uncertainty).all()
    assert (starts.uncertainty < 1e-14).all()
    finer = starts.precise()
    assert (np.abs(finer.p + finer.low) <= finer.uncertainty - np.abs(finer.low)).all()
    assert (finer.p != 0).any()
    assert (finer.uncertainty < 1e-28).all()


def test_momenta_in_two_doubles_have_a_hundred_bits() -> None:
    """p = (sinh²u + cos²w + c) v/3, against 60 digits."""
    u, w, v, c = sp.symbols("u w v c")
    tape = lower([v * (sp.sinh(u) ** 2 + sp.cos(w) ** 2 + c) / 3, w * v], [u, w, v, u, c])
    rows = np.random.default_rng(4).uniform(-2, 2, (2, 2, 1003))
    many, rule = Multi(200), MomentumRule(tape, (Pair(0.1, 1e-18),))
    (high, low), (rounded, errors) = rule.exactly(*rows), rule.rounded(*rows)
    for j in (*range(0, 1003, 50), 1002):
        given = [*(many.convert(float(x)) for x in rows[:, :, j].ravel()), many.convert(0.1) + many.convert(1e-18)]
        for k, true in enumerate(tape.run(many, given)):
            assert abs(many.convert(float(high[k, j])) + many.convert(float(low[k, j])) - true) <= 2.0**-98 * abs(true)
            assert abs(many.convert(float(rounded[k, j])) - true) <= errors[k, j] <= 1e-14 * (1 + abs(true))
    assert (low != 0).any()
