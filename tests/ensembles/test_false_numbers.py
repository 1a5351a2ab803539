"""Numbers of orbits that come near a pole of p², against closed forms of the very doubles that are given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from mpmath import mp, mpf, sqrt

import hjsolve

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
