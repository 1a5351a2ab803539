"""Contact that ends: closed forms, quadratures by mpmath, and Newton's equations with multipliers integrated by scipy."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mp
from scipy.integrate import solve_ivp

import hjsolve

PLANE, SPACE = {"x": "line", "y": "line"}, {"x": "line", "y": "line", "z": "line"}
BALL = hjsolve.System(PLANE, "m/2*(dot(x)**2 + dot(y)**2)", "m*g*y", {"m": 3, "g": 2})
SPHERE = hjsolve.System(SPACE, "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)", "m*g*z", {"m": 3, "g": 2})
LADDER = hjsolve.System(
    {"x": "line", "y": "line", "theta": "line"},
    "m/2*(dot(x)**2 + dot(y)**2) + m*l**2/24*dot(theta)**2",
    "m*g*y",
    {"m": 3, "g": 2, "l": 2},
)
OUTSIDE, INSIDE = ["x**2 + y**2 >= 4"], ["x**2 + y**2 <= 4"]


def _hoop(square: str, **more: Any) -> hjsolve.Contact:
    """Return a start at the bottom of a hoop of radius 2 with v² = square·g R, g R = 4."""
    return hjsolve.contact(
        BALL, q={"x": 0, "y": -2}, velocity={"x": f"2*sqrt({square})", "y": 0}, constraints=INSIDE, **more
    )


@pytest.mark.nightly_cases("1/10-0", "0-1/5")
@pytest.mark.parametrize(
    ("sine", "speed"), [("1/10", "0"), ("3/5", "0"), ("3/5", "1/2"), ("-7/25", "2/3"), ("0", "1/5")]
)
def test_a_particle_leaves_a_cylinder_at_two_thirds(sine: str, speed: str) -> None:
    """cos θ = 2 E/(3 m g R), E = m v²/2 + m g y₀; the time is ∫ R dθ/v, and what follows is a parabola."""
    cosine = f"sqrt(1 - ({sine})**2)"
    found = hjsolve.contact(
        BALL, q={"x": f"2*({sine})", "y": f"2*{cosine}"}, constraints=OUTSIDE,
        velocity={"x": f"({speed})*{cosine}", "y": f"-({speed})*({sine})"}, digits=30, t0="1/2",
    )  # fmt: skip
    with mp.workdps(40):
        s, v0 = (mp.mpf(x.numerator) / x.denominator for x in map(Fraction, (sine, speed)))
        top = mp.sqrt(1 - s**2)
        leaves = v0**2 / 12 + 2 * top / 3  # cos θ: v² = v0² + 2 g R (top − cos) = g R cos
        start, end = mp.asin(s), mp.acos(leaves)
        if v0 or s > 0:

            def inverse_speed(u: mpmath.mpf) -> mpmath.mpf:  # θ = θ₀ + u²; cos θ₀ − cos θ without cancellation
                return 4 * u / mp.sqrt(v0**2 + 16 * mp.sin(start + u**2 / 2) * mp.sin(u**2 / 2))

            time = mp.quad(inverse_speed, mp.linspace(0, mp.sqrt(end - start), 9))
            assert abs(found.time.value - mp.mpf("0.5") - time) < 1e-24
            assert found.time.error < 1e-27
        assert abs(found.q["y"].value - 2 * leaves) < 1e-28
        assert abs(found.velocity["x"].value - mp.sqrt(4 * leaves) * leaves) < 1e-28
        x, y = (found.q[n].value for n in "xy")
        vx, vy = (found.velocity[n].value for n in "xy")
        state = found.after.at(found.time.value + 1)
        assert abs(state.q["x"] - x - vx) < 1e-25
        assert abs(state.q["y"] - y - vy + 1) < 1e-25
    assert found.proved
    assert found.ended == tuple(OUTSIDE)
    for later in np.linspace(0.01, 3, 40):  # it never meets the cylinder again
        state = found.after.at(float(found.time.value) + later)
        assert float(state.q["x"] ** 2 + state.q["y"] ** 2) > 4


@pytest.mark.nightly_cases("3", "2.001")
@pytest.mark.parametrize("square", ["2.001", "3", "7/2", "4.999"])
def test_a_particle_falls_off_inside_a_hoop(square: str) -> None:
    """Between 2 g R and 5 g R: cos θ = (v₀² − 2 g R)/(3 g R) from the top; the time against scipy."""
    found = _hoop(square)
    value = float(Fraction(square))
    assert abs(found.q["y"].value - 2 * (value - 2) / 3) < 1e-14
    assert found.proved
    assert abs(found.time.value - _twin(value)) < 1e-8
    assert found.time.error < 1e-14


def _twin(square: float) -> float:
    """Integrate m q̈ = −m g e_y + λ a with λ from a q̈ + ȧ q̇ = 0 at each step, up to λ = 0."""

    def multiplier(y: np.ndarray) -> float:
        a, v = -2 * y[:2], y[2:]
        return float(((2 * v @ v) + 2.0 * a[1]) / (a @ a))

    def rates(_t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], np.array([0, -2.0]) - 2 * y[:2] * multiplier(y)])

    def event(_t: float, y: np.ndarray) -> float:
        return multiplier(y)

    event.terminal = True  # type: ignore[attr-defined]
    start = np.array([0, -2, 2 * square**0.5, 0.0])
    return float(
        solve_ivp(rates, (0, 50), start, "DOP853", rtol=1e-12, atol=1e-13, max_step=5e-3, events=event).t_events[0][0]
    )


@pytest.mark.nightly_cases("1/2", "9")
@pytest.mark.parametrize("square", ["1/2", "1.999", "5.001", "9"])
def test_a_particle_that_swings_or_goes_round_stays_on_the_hoop(square: str) -> None:
    found = _hoop(square)
    assert found.time is None
    assert found.ended == ()
    assert found.proved
    with pytest.raises(hjsolve.InvalidInputError, match="does not end"):
        found.next_arc()


@pytest.mark.parametrize("square", ["2", "5"])
def test_a_multiplier_that_only_touches_zero_is_not_decided(square: str) -> None:
    with pytest.raises(hjsolve.NotConvergedError, match="touches zero at theta"):
        _hoop(square)


def test_the_multiplier_in_the_state_and_in_one_coordinate() -> None:
    """λ ∂g/∂q on the hoop, g = 4 − x² − y²: N = 2 R λ = m v²/R − m g sin θ = (2 E − 3 m g R sin θ)/R."""
    found = _hoop("3")
    (text,) = INSIDE
    system = found.motion.solution.system
    theta, m, g = system.coordinates[0], system.symbols["m"], system.symbols["g"]
    assert (4 * found.multipliers[text] - (2 * m * theta.velocity**2 - m * g * sp.sin(theta.symbol))).expand() == 0
    E = found.motion.solution.constants["E"].symbol
    assert (4 * found.along[text] - (E - 3 * m * g * sp.sin(theta.symbol))).expand() == 0
    assert pickle.loads(pickle.dumps(found)).time == found.time


def test_a_particle_leaves_a_sphere_whichever_way_it_goes() -> None:
    """z = 2 E/(3 m g), with φ going round; L_z and E go on on the parabola."""
    found = hjsolve.contact(
        SPHERE, q={"x": "6/5", "y": 0, "z": "8/5"}, velocity={"x": "4/10", "y": "1/3", "z": "-3/10"},
        constraints=["x**2 + y**2 + z**2 >= 4"],
    )  # fmt: skip
    E = 3 * (0.25 + 1 / 9) / 2 + 6 * 1.6
    assert found.proved
    assert abs(found.q["z"].value - E / 9) < 1e-14
    assert abs(found.motion.constants["E"].value - E) < 1e-13
    after = found.after
    t = float(found.time.value)
    for later in (0, 0.3, 2):
        state = after.at(t + later)
        x, y, z, vx, vy, vz = *(state.q[n] for n in "xyz"), *(state.velocity[n] for n in "xyz")
        assert abs(x * vy - y * vx - 1.2 / 3) < 1e-13
        assert abs(3 * (vx**2 + vy**2 + vz**2) / 2 + 6 * z - E) < 1e-12
        assert x**2 + y**2 + z**2 > 4 - 1e-13


@pytest.mark.nightly
def test_a_block_that_also_moves_along_the_cylinder() -> None:
    """The motion along the axis has no part in it: z goes on evenly, the rest as in the plane."""
    plain = hjsolve.contact(BALL, q={"x": "6/5", "y": "8/5"}, velocity={"x": 0, "y": 0}, constraints=OUTSIDE)
    block = hjsolve.System(SPACE, "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)", "m*g*y", {"m": 3, "g": 2})
    found = hjsolve.contact(
        block, q={"x": "6/5", "y": "8/5", "z": 0}, velocity={"x": 0, "y": 0, "z": "5"}, constraints=OUTSIDE
    )
    assert found.proved
    assert abs(found.time.value - plain.time.value) < 1e-14
    assert abs(found.q["z"].value - 5 * plain.time.value) < 1e-14


def test_a_ladder_leaves_the_wall_and_goes_on_along_the_floor() -> None:
    """At 2/3 of its height; then the centre moves evenly and the rod turns as y = l/2 sin θ lets it."""
    texts = ["x >= l/2*cos(theta)", "y = l/2*sin(theta)"]
    found = hjsolve.contact(
        LADDER, q={"x": "3/5", "y": "4/5", "theta": "asin(4/5)"}, velocity=dict.fromkeys(("x", "y", "theta"), 0),
        constraints=texts,
    )  # fmt: skip
    assert found.ended == (texts[0],)
    assert abs(found.q["y"].value - 8 / 15) < 1e-15
    system, data = found.next_arc()
    assert [c.name for c in system.coordinates] == ["x", "theta"]
    after, t = found.after, float(found.time.value)
    assert abs(after.constants["E"].value - 3 * 2 * 4 / 5) < 1e-13
    assert abs(after.constants["p_x"].value / 3 - found.velocity["x"].value) < 1e-14

    def rates(_t: float, y: np.ndarray) -> list[float]:
        """T = m ẏ²/2 + m l²/24 θ̇², y = sin θ: (1/3 + cos² θ) θ̈ = cos θ sin θ θ̇² − g cos θ."""
        c, s = np.cos(y[0]), np.sin(y[0])
        return [y[1], (c * s * y[1] ** 2 - 2 * c) / (1 / 3 + c * c)]

    start = [found.q["theta"].value, found.velocity["theta"].value]
    twin = solve_ivp(rates, (0, 0.3), start, "DOP853", rtol=1e-12, atol=1e-13)
    assert abs(after.at(t + 0.3).q["theta"] - twin.y[0, -1]) < 1e-10
    state = after.at(t + 0.2)
    assert float(state.q["x"]) > np.cos(float(state.q["theta"]))  # off the wall
    assert data["t0"] == found.released.t0


@pytest.mark.nightly
def test_a_multiplier_of_two_coordinates_is_sampled_along_the_motion() -> None:
    """V = x²/2 + 2 y² + z (2 − x − y) on z ≥ 0: λ = 2 − x − y, x = cos t + sin t, y = (cos 2t + sin 2t)/2."""
    field = hjsolve.System(SPACE, "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", "x**2/2 + 2*y**2 + z*(1.8 - x - y)")
    start = {"q": {"x": 1, "y": "1/2", "z": 0}, "constraints": ["z >= 0"]}
    found = hjsolve.contact(field, velocity={"x": 1, "y": 1, "z": 0}, **start)
    assert not found.proved
    assert found.along == {}
    time = mpmath.findroot(lambda t: 1.8 - mp.cos(t) - mp.sin(t) - (mp.cos(2 * t) + mp.sin(2 * t)) / 2, 0.2)
    assert abs(found.time.value - time) < 1e-14
    still = hjsolve.contact(field, velocity={"x": 0, "y": 0, "z": 0}, **start, until=20)
    assert still.time is None
    assert not still.proved
    with pytest.raises(hjsolve.NotConvergedError, match="until"):
        hjsolve.contact(field, velocity={"x": 0, "y": 0, "z": 0}, **start)
    t = float(found.time.value)

    def rates(_t: float, y: np.ndarray) -> list[float]:
        return [*y[3:], -y[0] + y[2], -4 * y[1] + y[2], y[0] + y[1] - 1.8]

    begin = [found.q[n].value for n in "xyz"] + [found.velocity[n].value for n in "xyz"]
    twin = solve_ivp(rates, (0, 0.5), begin, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    state = found.after.at(t + 0.5)
    assert np.allclose([float(state.q[n]) for n in "xyz"], twin[:3], rtol=0, atol=1e-11)
    assert float(state.q["z"]) > 1e-4


@pytest.mark.nightly
def test_a_motion_whose_coordinates_are_found() -> None:
    """V = x² + y² + x y + z (1.8 − x − 2 y) on z ≥ 0: x ± y have the frequencies √3 and 1."""
    V = "x**2 + y**2 + x*y + z*(1.8 - x - 2*y)"
    field = hjsolve.System(SPACE, "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", V)
    found = hjsolve.contact(
        field, q={"x": "1/2", "y": "1/3", "z": 0}, velocity={"x": 1, "y": 1, "z": 0}, constraints=["z >= 0"]
    )

    def multiplier(t: mpmath.mpf) -> mpmath.mpf:
        u = mp.mpf(5) / 6 * mp.cos(mp.sqrt(3) * t) + 2 * mp.sin(mp.sqrt(3) * t) / mp.sqrt(3)
        v = mp.cos(t) / 6
        return mp.mpf("1.8") - (u + v) / 2 - (u - v)

    assert abs(found.time.value - mpmath.findroot(multiplier, 0.25)) < 1e-14
    assert not found.proved


def test_a_hill_that_repeats_itself_is_searched_over_one_period() -> None:
    """z = cos x: with v = 1/2 on the tops it presses on every hill; with E = 8/5 it flies off before a top."""
    hills = hjsolve.System({"x": "line", "z": "line"}, "m/2*(dot(x)**2 + dot(z)**2)", "m*g*z", {"m": 1, "g": 1})
    start = {"q": {"x": 0, "z": 1}, "constraints": ["z >= cos(x)"]}
    slow = hjsolve.contact(hills, velocity={"x": "1/2", "z": 0}, **start)
    assert slow.time is None
    assert slow.proved
    fast = hjsolve.contact(
        hills, q={"x": "-pi", "z": -1}, velocity={"x": "sqrt(26/5)", "z": 0}, constraints=["z >= cos(x)"]
    )
    E = mpmath.mpf(8) / 5  # λ ∝ g − ẋ² cos x = 0 with ẋ² (1 + sin² x)/2 + cos x = E: cos² x − 2 E cos x + 2 = 0
    assert abs(fast.q["x"].value + mpmath.acos(E - mpmath.sqrt(E**2 - 2))) < 1e-14
    assert fast.proved


def test_polar_coordinates_and_a_velocity_that_is_held() -> None:
    """r >= 2 in polar coordinates, and dot(y) = 0 next to a cylinder, leave as in the plane."""
    plain = hjsolve.contact(BALL, q={"x": "6/5", "y": "8/5"}, velocity={"x": 0, "y": 0}, constraints=OUTSIDE)
    polar = hjsolve.System(
        {"r": "0 < r", "phi": "angle"}, "m/2*(dot(r)**2 + r**2*dot(phi)**2)", "m*g*r*sin(phi)", {"m": 3, "g": 2}
    )
    found = hjsolve.contact(polar, q={"r": 2, "phi": "asin(4/5)"}, velocity={"r": 0, "phi": 0}, constraints=["r >= 2"])
    assert abs(found.time.value - plain.time.value) < 1e-14
    assert found.q["r"].value == 2
    block = hjsolve.System(SPACE, "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)", "m*g*y", {"m": 3, "g": 2})
    held = hjsolve.contact(
        block,
        q={"x": "6/5", "y": "8/5", "z": 7},
        velocity=dict.fromkeys("xyz", 0),
        constraints=[*OUTSIDE, "dot(z) = 0"],
    )
    assert abs(held.time.value - plain.time.value) < 1e-14
    assert held.q["z"].value == 7


def test_until_ends_the_search() -> None:
    time = float(_hoop("3").time.value)
    assert _hoop("3", until=time * 0.99).time is None
    assert _hoop("3", until=time * 1.01).time is not None


@pytest.mark.parametrize(("change", "message"), [
    ({"q": {"x": 1, "y": 1}}, "does not hold exactly"),
    ({"velocity": {"x": 0, "y": 1}}, "not along"),
    ({"velocity": {"x": 10, "y": 0}}, "does not push"),
    ({"constraints": ["x**2 + y**2 = 4"]}, "one-sided"),
    ({"constraints": []}, "texts"),
    ({"constraints": ["2 <= y <= 3"]}, "one equation or inequality"),
    ({"constraints": ["x**2 + y**2 > 4"]}, "one equation or inequality"),
    ({"q": {"x": 0, "y": -2}}, "does not push"),
])  # fmt: skip
def test_what_cannot_be_a_contact_is_refused(change: dict[str, Any], message: str) -> None:
    start = {"q": {"x": 0, "y": 2}, "velocity": {"x": 1, "y": 0}, "constraints": OUTSIDE}
    with pytest.raises(hjsolve.InvalidInputError, match=message):
        hjsolve.contact(BALL, **{**start, **change})


def test_a_particle_leaves_an_ellipse_where_the_cubic_of_its_sine_says() -> None:
    """On x = 2 cos u, y = sin u: λ ∝ g sin u − u̇², so that 3 s³ + 3 s = 2E/mg at s = sin u; t = ∫ du/u̇."""
    found = hjsolve.contact(
        BALL, q={"x": 0, "y": 1}, velocity={"x": "1/2", "y": 0}, constraints=["x**2/4 + y**2 >= 1"], digits=30
    )
    assert found.proved
    with mp.workdps(40):
        E = mp.mpf("2.125")  # over m; g = 2
        s = mp.findroot(lambda s: 3 * s**3 + 3 * s - E, 0.5)
        time = mp.quad(lambda u: mp.sqrt((1 + 3 * mp.sin(u) ** 2) / (2 * (E - 2 * mp.sin(u)))), [mp.asin(s), mp.pi / 2])
        assert abs(found.q["y"].value / s - 1) < 1e-28
        assert abs(found.time.value / time - 1) < 1e-28
