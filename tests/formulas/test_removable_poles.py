"""Formulas whose poles cancel keep their digits next to them: in doubles, in single motions, in ensembles."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.arithmetic.floats import Float64
from hjsolve.formulas.removable_poles import without_removable_poles
from hjsolve.lowering import lower

r = sp.Symbol("r", positive=True)
E, L, k = sp.symbols("E L k", real=True)
a = sp.Symbol("a", positive=True)
FORMULAS = {
    "NFW": 2 * k * sp.log(1 + r / a) / r,
    "cut off": 2 * k / r - 2 * k * sp.exp(-r / a) / r,
    "two ranges": (sp.exp(-r) - sp.exp(-2 * r)) / r,
    "hydrogen": 2 / r - 2 * sp.exp(-r) / r - sp.exp(-r),
    "modified Hubble": 2 * sp.log(r + sp.sqrt(1 + r**2)) / r,
    "a root": 2 * sp.sqrt(r**2 + 1) / r**2 - 2 / r**2,
    "a root with a letter": sp.sqrt(a**2 + r**2) / r - a / r,
    "a wave": (1 - sp.cos(r)) / r**2,
    "a hyperbolic wave": (sp.cosh(r / a) - 1) / r,
}
KINETIC = "(dot(r)**2 + r**2*dot(theta)**2)/2"


@pytest.mark.parametrize("name", FORMULAS)
def test_the_formula_is_equal_and_keeps_its_digits_in_doubles(name):
    F = 2 * E - L**2 / r**2 + FORMULAS[name]
    written = without_removable_poles(F, r, near=True)
    assert written != F
    values = {E: sp.Rational(-1, 7), L: 0, k: sp.Rational(3, 2), a: sp.Rational(5, 4)}
    tape = lower([written.subs(L, 0)], [r, E, k, a])
    for place in (sp.Integer(2), sp.Rational(1, 1000), sp.Rational(1, 10**9), sp.Rational(1, 10**13)):
        exact = sp.N(F.subs(values | {r: place}), 60)
        numbers = [np.float64(float(v)) for v in (place, values[E], values[k], values[a])]
        found = tape.run(Float64(), numbers)[0]
        assert abs(float(found) - exact) <= 1e-14 * abs(exact), place


@pytest.mark.parametrize("F", [
    2 * E - L**2 / r**2 + 2 * k / r, k * sp.exp(-r) / r + E, E + k * sp.log(r) / r, sp.log(2 + r) / r,
    (sp.sqrt(1 + r**2) - 2) / r, 1 / r - 2 * sp.exp(-r) / r, sp.log(1 + r) - L**2 / r**2,
])  # fmt: skip
def test_a_pole_that_does_not_cancel_is_left_as_it_stands(F):
    assert without_removable_poles(F, r, near=True) is F


def test_a_pole_elsewhere_cancels_too():
    written = without_removable_poles(E + sp.log(r) / (r - 1), r, near=True)
    place = sp.Rational(10**12 + 1, 10**12)
    found = lower([written], [r, E]).run(Float64(), [np.float64(float(place)), np.float64(0)])[0]
    assert abs(float(found) - 1) < 1e-11


@pytest.mark.parametrize("l", ["1e-3", "1e-12"])
def test_a_single_motion_of_the_isochrone_typed_with_its_root(l):
    """−(√(1 + r²) − 1)/r² is −1/(1 + √(1 + r²)): J_r = 1/√(−2E) − (L + √(L² + 4))/2 (Binney and Tremaine 3.225)."""
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r", "theta": "angle"}, KINETIC, "-(sqrt(1+r**2)-1)/r**2"))
    motion = solution.motion(q={"r": "1", "theta": "0"}, p={"r": "0.1", "theta": l})
    with mp.workdps(40):
        ell = mp.mpf(l)
        energy = mp.mpf("0.005") + ell**2 / 2 - (mp.sqrt(2) - 1)
        period = 2 * mp.pi / (-2 * energy) ** mp.mpf(1.5)
        action = 1 / mp.sqrt(-2 * energy) - (ell + mp.sqrt(ell**2 + 4)) / 2
        assert abs(motion.periods["r"].value - period) <= motion.periods["r"].error < 1e-14 * period
        assert abs(motion.actions["r"].value - action) <= motion.actions["r"].error < 1e-14 * action


def test_nearly_radial_motions_in_a_field_with_a_cut_off_are_found():
    """They were not decided below l = 1e-6. V differs from −1 + r/2 − r²/6 by O(r³), and a turn through r = 0 takes O(l)."""
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r", "theta": "angle"}, KINETIC, "-(1 - exp(-r))/r"))
    periods = [
        solution.motion(q={"r": "1", "theta": "0"}, p={"r": "0", "theta": l}).periods["r"].value
        for l in ("1e-9", "1e-13")
    ]
    with mp.workdps(30):  # l = 0: from r = 1 to the centre and back, r = cos² u
        V = lambda r: mp.expm1(-r) / r  # noqa: E731
        speed = lambda r: mp.sqrt(2 * (V(mp.mpf(1)) - V(r)))  # noqa: E731
        fall = mp.quad(lambda u: mp.sin(2 * u) / speed(mp.cos(u) ** 2), [0, 0.8, mp.pi / 2], method="gauss-legendre")
    assert all(abs(period - 2 * fall) < 1e-13 * period for period in periods)


def nearly_radial(V):
    """Forty orbits, l from 1e-13 to 0.1, without single motions."""
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, KINETIC, V)
    rng = np.random.default_rng(1)
    q = {"r": rng.uniform(0.3, 3, 40), "theta": 0.1}
    p = {"r": rng.uniform(-0.2, 0.2, 40), "theta": 10 ** rng.uniform(-13, -1, 40)}
    return q, p, hjsolve.ensemble(system, q=q, p=p, want={"actions", "frequencies"}, fallback=False)


@pytest.mark.nightly
def test_nearly_radial_orbits_of_the_isochrone_typed_with_its_root():
    q, p, batch = nearly_radial("-(sqrt(1+r**2)-1)/r**2")
    assert set(batch.status) == {"ok"}
    for i in range(40):
        with mp.workdps(30):
            radius, momentum, ell = (mp.mpf(float(x)) for x in (q["r"][i], p["r"][i], p["theta"][i]))
            energy = (momentum**2 + (ell / radius) ** 2) / 2 - 1 / (1 + mp.sqrt(1 + radius**2))
            action = 1 / mp.sqrt(-2 * energy) - (ell + mp.sqrt(ell**2 + 4)) / 2
            rate = (-2 * energy) ** mp.mpf(1.5)
            assert abs(batch.actions["r"][i] - action) <= batch.error["actions"]["r"][i] < 1e-11 * action
            assert abs(batch.frequencies["r"][i] - rate) <= batch.error["frequencies"]["r"][i] < 1e-11 * rate


@pytest.mark.nightly
@pytest.mark.parametrize("V", [
    "-log(1+r)/r", "-(1-exp(-r))/r", "-log(r+sqrt(1+r**2))/r", "-(1-(1+r/2)*exp(-r))/r", "(exp(-2*r)-exp(-r))/r",
])  # fmt: skip
def test_nearly_radial_orbits_are_those_of_single_motions(V):
    q, p, batch = nearly_radial(V)
    assert set(batch.status) == {"ok"}
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r", "theta": "angle"}, KINETIC, V))
    for i in (0, 13, 29):
        motion = solution.motion(
            q={"r": float(q["r"][i]), "theta": 0.1}, p={"r": float(p["r"][i]), "theta": float(p["theta"][i])}
        )
        for quantity, single in (("actions", motion.actions), ("frequencies", motion.frequencies)):
            value, error = getattr(batch, quantity)["r"][i], batch.error[quantity]["r"][i]
            assert abs(value - single["r"].value) <= error + single["r"].error
