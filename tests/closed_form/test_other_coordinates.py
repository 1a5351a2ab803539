"""A motion typed in another coordinate, Q = φ⁻¹(u), has the forms that it has in u."""

from __future__ import annotations

import pytest
from mpmath import mp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form

CASES = {
    "tan": ("line", "dot(x)**2/(2*(1 + x**2)**2)", "atan(x)", mp.atan, mp.tan, "1/3"),
    "sinh": ("line", "dot(x)**2/(2*(1 + x**2))", "asinh(x)", mp.asinh, mp.sinh, "1/3"),
    "exponential": ("0 < x", "dot(x)**2/(2*x**2)", "log(x)", mp.log, mp.exp, "4/3"),
}


@pytest.mark.parametrize("potential", ["k*u**2/2", "k*u**4"])
@pytest.mark.parametrize("name", CASES)
def test_an_oscillator_in_another_coordinate(name: str, potential: str) -> None:
    domain, kinetic, inner, φ, back, place = CASES[name]
    system = hjsolve.System({"x": domain}, kinetic, potential.replace("u", inner), parameters={"k": "2"})
    form = own_form(hjsolve.solve(system).motion(q={"x": place}, velocity={"x": "1/5"}))
    plain = own_form(
        hjsolve.solve(
            hjsolve.System({"u": "line"}, "dot(u)**2/2", potential, parameters={"k": "2"})
        ).motion(q={"u": "1/3"}, velocity={"u": "1/5"})
    )  # fmt: skip
    assert form is not None
    assert plain is not None
    assert "inverse.x" in form.named()
    with mp.workdps(30):
        u = φ(mp.mpf(4) / 3 if place == "4/3" else mp.mpf(1) / 3)
        for t in ("0.4", "5.9"):
            got = form.evaluate("inverse.x", {"t": t, "t_0": "0", "x_0": place, "E": "1/3"}, 25).value
            there = plain.evaluate("inverse.u", {"t": t, "t_0": "0", "u_0": mp.nstr(u, 30), "E": "1/3"}, 25).value
            assert abs(got - back(there)) < 1e-22
        assert abs(form.evaluate("actions.x", {"E": "1/3"}, 25).value
                   - plain.evaluate("actions.u", {"E": "1/3"}, 25).value) < 1e-22  # fmt: skip


def test_the_entry_in_the_tangent_is_the_tangent_of_a_cosine() -> None:
    motion = hjsolve.solve("oscillator-tan").motion(**next(iter(_motions().values())).arguments)
    form = own_form(motion)
    assert form is not None
    assert form.why_not == {}
    assert str(form.inverse["Q"]) == "tan(a*cos(omega*(t - t_p)))"


def _motions():
    return hjsolve.catalog.describe("oscillator-tan").motions
