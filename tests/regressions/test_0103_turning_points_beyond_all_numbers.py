"""E − log q with a large E turns at e^E; beyond 2^2000 lengths of the start this was said to be an escape, or a fall."""

from __future__ import annotations

import pytest

import hjsolve


@pytest.mark.parametrize(
    ("domain", "potential", "momentum"),
    [
        ("0 < q", "log(q)", 60),
        ("0 < q", "log(q) + 1/q", 75),
        ("line", "log(1 + q**2)", -110),
        ("0 < q", "-log(q)", -60),
        ("0 < q", "log(1 + log(q)**2)**3", 90),
    ],
)
def test_a_turning_point_that_is_too_far_is_not_an_escape(domain: str, potential: str, momentum: int) -> None:
    solution = hjsolve.solve(hjsolve.System({"q": domain}, "dot(q)**2/2", potential))
    with pytest.raises(hjsolve.NotConvergedError, match=r"p² vanishes (beyond|within) .*(farther|decided)"):
        solution.motion(q={"q": 2}, p={"q": momentum})
    batch = hjsolve.ensemble(solution, q={"q": [2.0]}, p={"q": [float(momentum)]}, want={"actions"})
    assert list(batch.status) == ["not_converged"]


@pytest.mark.parametrize(
    ("domain", "potential", "kind"),
    [("0 < q", "-1/log(3 + q)", "escape"), ("line", "-log(1 + q**2)", "escape"), ("0 < q", "log(q)", "boundary")],
)
def test_motions_that_do_not_turn_keep_their_kinds(domain: str, potential: str, kind: str) -> None:
    solution = hjsolve.solve(hjsolve.System({"q": domain}, "dot(q)**2/2", potential))
    assert solution.motion(q={"q": 2}, p={"q": 60 if kind == "escape" else "-1/10"}).kinds == {"q": kind}
