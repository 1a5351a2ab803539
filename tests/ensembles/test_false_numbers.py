"""Numbers of orbits that come near a pole of p², against closed forms of the very doubles that are given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf, sqrt

import hjsolve
from benchmarks.false_numbers import FIELDS, PLANE, checked
from hjsolve.ensembles.engine.lowered_solution import lowered_model

WANT = {"actions", "frequencies"}


def _kepler(r: float, p: float, momenta: Sequence[float]) -> Any:
    start = {"q": {"r": r, "theta": 0}, "p": {"r": p, "theta": np.array(momenta)}}
    return hjsolve.ensemble("kepler-planar", **start, want=WANT, shown=False, fallback=False)


def _held(batch: Any, r: float, p: float, momenta: Sequence[float]) -> None:
    """J_r = 1/√(−2E) − |l|, and both frequencies are √(−2E)³."""
    assert (batch.status == "ok").all()
    with mp.workdps(60):
        for i, l in enumerate(map(mpf, momenta)):
            twice = 2 / mpf(r) - mpf(p) ** 2 - (l / mpf(r)) ** 2
            rate = twice * sqrt(twice)
            for group, name, truth in (
                ("actions", "r", 1 / sqrt(twice) - abs(l)),
                ("frequencies", "r", rate),
                ("frequencies", "theta", mp.sign(l) * rate),
            ):
                value, claim = (mpf(float(x[name][i])) for x in (getattr(batch, group), batch.error[group]))
                assert abs(value - truth) <= claim, (group, name, float(l), float(abs(value - truth) / claim))


def test_an_eccentric_orbit_is_known_next_to_the_pole_however_far_its_other_end_is() -> None:
    # q = b - W y was rounded by an ulp of b where q was near a << b: the frequency of theta was off by 80 000 claims
    r, p, momenta = 1.3015750652476612, 0.799556899061829, [0.48, -0.011, 1e-3, 5.844038133153313e-05, -3e-6, 1e-8]
    _held(_kepler(r, p, momenta), r, p, momenta)


@pytest.mark.nightly_cases("isochrone, all scales")
@pytest.mark.rotating(4)
@pytest.mark.parametrize("name", [name for name, field in FIELDS.items() if field.truth])
def test_no_claim_is_smaller_than_its_error_in_fields_of_closed_form(name: str, request: pytest.FixtureRequest) -> None:
    _, count, false, *_ = checked(name, FIELDS[name], 40, seed=abs(request.config.option.rotation))
    assert (count, false) == (40, 0)


def test_a_pole_of_the_tangent_inside_a_well_of_its_inverse_is_no_obstacle() -> None:
    # cot² r was 1/tan² r, which divides by infinity in the middle of the well: not one orbit of tan² r was ok
    place = np.array([0.43, -1.2, 1e-3])
    for domain, potential, shift in (
        ("-pi/2 < r < pi/2", "tan(r)**2", 0.0), ("0 < r < pi", "1/tan(r)**2", np.pi / 2)
    ):  # fmt: skip
        system = hjsolve.System({"r": domain}, "dot(r)**2/2", potential)
        batch = hjsolve.ensemble(system, q={"r": place + shift}, p={"r": 0.3}, fallback=False, shown=False)
        assert (batch.status == "ok").all()
        total = np.sqrt(2 * (0.045 + np.tan(place) ** 2) + 2)  # J = √(2 + 2E) − √2, Ω = √(2 + 2E)
        assert np.allclose(batch.frequencies["r"], total, rtol=1e-13, atol=0)


def test_formulas_that_differ_by_strengths_share_what_is_known_of_their_functions() -> None:
    def clearances(potential: str, **parameters: Any) -> list[Any]:
        system = hjsolve.System(PLANE[0], PLANE[1], potential, parameters)
        values = {p.symbol: p.value for p in system.parameters}
        (one,) = lowered_model(hjsolve.solve(system), values).separated
        return [one.plain.clearance, one.lower.clearance]

    once = clearances("-k/r", k="1")
    assert clearances("-k/r", k="2.5") == once
    assert clearances("-1/r - r**2/10**6") == clearances("-3/r - r**2/77")
    assert clearances("-1/(a + r)", a="1") != clearances("-1/(a + r)", a="2")
    # a narrow hill is hidden by what it is added to: alone it would grow without bounds
    assert len(clearances("r**2/2 - exp(-1000*(r - 1/2)**2)/5")[0]._parts.outputs) == 2


def test_circular_orbits_of_an_oscillator_at_1e76_are_right_or_not_ok() -> None:
    # J was off by up to 310 000 claims from 8e75 on
    scale = 2.0 ** np.arange(-40, 4)
    r, p, l = 1.6307760616272337e76 * scale, 1.1541120809242145e65 * scale, 2.6594305631764312e152 * scale**2
    start = {"q": {"r": r, "theta": 0}, "p": {"r": p, "theta": l}}
    system = hjsolve.System(PLANE[0], PLANE[1], "r**2/2")
    batch = hjsolve.ensemble(system, **start, want="actions", shown=False, fallback=False)
    assert (batch.status[:12] == "ok").all()
    with mp.workdps(60):
        for i in np.flatnonzero(batch.status == "ok"):
            x, v, L = map(mpf, (float(r[i]), float(p[i]), float(l[i])))
            truth = (v**2 / 2 + x**2 / 2 + L**2 / (2 * x**2) - L) / 2
            assert abs(mpf(float(batch.actions["r"][i])) - truth) <= float(batch.error["actions"]["r"][i])
