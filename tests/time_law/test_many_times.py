"""Many times at once: the table of the inverted time law, with numpy and by compiled loops."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hjsolve
from hjsolve.time_law.table import DEGREE, InterpolationTable

pytest.importorskip("numba")

KEPLER = ("0", "0.1", "0.999999", "0.999999999999", "1", "1.0000001", "2")


def kepler(e: str) -> hjsolve.Motion:
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    return solution.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": f"sqrt(1+{e})"})


def pendulum(rate: str) -> hjsolve.Motion:
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    return solution.motion(q={"theta": 0}, velocity={"theta": rate}, parameters={"m": 1, "g": 1, "l": 1})


def by(monkeypatch: pytest.MonkeyPatch, way: str, motion: hjsolve.Motion, t: np.ndarray) -> hjsolve.State:
    """State of a motion at times, all of it worked out with numpy or all by compiled loops."""
    monkeypatch.setenv("HJSOLVE_COMPILED", {"numpy": "0", "compiled": "1"}[way])
    monkeypatch.setattr("hjsolve.time_law.compiled.WORTH", 1)
    state = motion.at(t)
    for group in (state.q, state.p, state.velocity, state.turns, state.error.q):
        for name in group:
            _ = group[name]
    return state


@pytest.mark.parametrize(
    "motion",
    [*(pytest.param(lambda e=e: kepler(e), id=f"kepler {e}") for e in KEPLER),
     pytest.param(lambda: pendulum("2*(1-1e-12)"), id="pendulum near the separatrix"),
     pytest.param(lambda: pendulum("-2.5"), id="pendulum that rotates"),
     pytest.param(lambda: pendulum("2"), id="pendulum on the separatrix")],
)  # fmt: skip
def test_compiled_loops_give_what_numpy_gives(motion, monkeypatch) -> None:
    motion = motion()
    t = np.random.default_rng(2).uniform(-500, 500, 5000)
    ours, theirs = (by(monkeypatch, way, motion, t) for way in ("compiled", "numpy"))
    for name in theirs.q:
        np.testing.assert_allclose(ours.q[name], theirs.q[name], rtol=4e-16, atol=4e-16 * (name == "theta"))
        np.testing.assert_allclose(ours.p[name], theirs.p[name], rtol=4e-16, atol=0)
        np.testing.assert_allclose(ours.velocity[name], theirs.velocity[name], rtol=1e-15, atol=0)
        np.testing.assert_allclose(ours.error.q[name], theirs.error.q[name], rtol=1e-12, atol=0)
    for name in theirs.turns:
        assert np.array_equal(ours.turns[name], theirs.turns[name])


def exact_pendulum(gap: str, t: float) -> mpmath.mpf:
    """θ = 2 asin(k sn t), k = 1 − gap, the period taken out at 60 digits."""
    with mpmath.workdps(60):
        k = 1 - mpmath.mpf(gap)
        period = 4 * mpmath.ellipk(k**2)
        rest = mpmath.mpf(t) - period * mpmath.nint(mpmath.mpf(t) / period)
        return 2 * mpmath.asin(k * mpmath.ellipfun("sn", rest, m=k**2))


@pytest.mark.parametrize("way", ["numpy", "compiled"])
@pytest.mark.parametrize("gap", ["0.9", "1e-6", "1e-12"])
def test_the_pendulum_after_a_billion_periods(gap, way, monkeypatch) -> None:
    motion = pendulum(f"2*(1-{gap})")
    t = np.random.default_rng(1).uniform(0, 1e9 * motion.periods["theta"].value, 3000)
    state = by(monkeypatch, way, motion, t)
    for i in range(0, len(t), 150):
        error = abs(exact_pendulum(gap, t[i]) - mpmath.mpf(state.q["theta"][i]))
        assert error <= 2e-14
        assert error <= state.error.q["theta"][i]


def exact_distance(e: str, t: float) -> mpmath.mpf:
    """Kepler's distance from perihelion 1 at 50 digits, by Kepler's equation (Barker's where e = 1)."""
    with mpmath.workdps(50):
        e, t = mpmath.mpf(e), abs(mpmath.mpf(t))
        if e == 1:
            w = mpmath.mpf(3) / 2 * mpmath.sqrt(2) * t / 2
            u = mpmath.cbrt(w + mpmath.sqrt(w * w + 1))
            return 1 + (u - 1 / u) ** 2
        a = 1 / (1 - e)
        M = t / mpmath.sqrt(abs(a)) ** 3
        if e < 1:
            M -= 2 * mpmath.pi * mpmath.nint(M / (2 * mpmath.pi))
            low, high = sorted((0, mpmath.sign(M) * (mpmath.pi + mpmath.mpf("0.1"))))
            E = _zero(lambda x: x - e * mpmath.sin(x) - M, low, high)
            return 1 + 2 * a * e * mpmath.sin(E / 2) ** 2
        F = _zero(lambda x: e * mpmath.sinh(x) - x - M, 0, mpmath.log(2 * M + 4) + 4)
        return 1 - 2 * a * e * mpmath.sinh(F / 2) ** 2


def _zero(f, low, high):
    """Bisection of an increasing function to all digits."""
    for _ in range(230):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) < 0 else (low, middle)
    return low


@pytest.mark.rotating(6)
@pytest.mark.parametrize("way", ["numpy", "compiled"])
@pytest.mark.parametrize("e", KEPLER)
def test_keplers_distance_at_any_eccentricity(e, way, monkeypatch) -> None:
    motion = kepler(e)
    reach = 3 * motion.periods["r"].value if "r" in motion.periods else 3000.0
    t = np.random.default_rng(4).uniform(-reach, reach, 3000)
    t[::300] = [1e-9, 1e-6, 1e-4, 1e-2, 0.1, 1, 2, 3, 5, 7]
    state = by(monkeypatch, way, motion, t)
    for i in range(0, len(t), 100):
        error = abs(exact_distance(e, t[i]) - mpmath.mpf(state.q["r"][i]))
        assert error <= 2e-14 * state.q["r"][i]
        assert error <= state.error.q["r"][i]


@settings(deadline=None)
@given(
    st.lists(st.floats(1e-13, 1.0), min_size=1, max_size=40),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=40),
)
def test_the_guide_finds_the_panel_that_holds_the_argument(lengths, fractions) -> None:
    edges = np.concatenate([[0.0], np.cumsum(lengths)])
    table = InterpolationTable(edges, (np.zeros((DEGREE + 1, len(lengths))),), (), (), np.zeros(len(lengths)))
    u = np.minimum(np.concatenate([np.array(fractions) * edges[-1], edges]), edges[-1])
    panel = table.panels(u)
    tolerance = 8 * 2.0**-52 * edges[-1]
    assert np.all(edges[panel] <= u + tolerance)
    assert np.all(u <= edges[panel + 1] + tolerance)


def test_threads_share_the_compiled_loops(monkeypatch) -> None:
    motion = pendulum("1")
    t = np.random.default_rng(5).uniform(-1e6, 1e6, 20_000)
    alone = by(monkeypatch, "compiled", motion, t).q["theta"]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda _: motion.at(t).q["theta"], range(8)))
    assert all(np.array_equal(alone, other) for other in together)


def test_machine_code_that_cannot_be_kept_is_made_anyway(monkeypatch) -> None:
    from hjsolve.time_law import compiled_loops

    def njit(*, cache: bool = False, **options):
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return lambda function: function

    monkeypatch.setattr("numba.njit", njit)
    assert compiled_loops._kernel(abs)(-3) == 3


@pytest.mark.nightly
def test_few_times_do_not_load_numba() -> None:
    code = (
        "import sys, numpy as np, hjsolve\n"
        "m = hjsolve.solve(hjsolve.catalog.load('harmonic-oscillator')).motion(q={'x': 1}, velocity={'x': 0})\n"
        "m.at(np.linspace(0, 1, 10_000)).q['x']\n"
        "assert 'numba' not in sys.modules\n"
        "m.at(np.linspace(0, 1, 100_000)).q['x']\n"
        "assert 'numba' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_compiled_and_numpy_count_the_same_whole_turns_beyond_2_to_the_53() -> None:
    from hjsolve.time_law import compiled_loops, phase_reduction

    times = np.array([8.856613100308274e16, -8.089436646608065e17, 1.25, 1e40, -1e40])
    rate, start = (0.2794118, 1e-18), (0.25, 0.0)
    whole, rest = np.empty(5, dtype=np.int64), np.empty(5)
    compiled_loops.turns(rate, times, 0 * times, start, whole, rest)
    theirs, left = phase_reduction._turns(rate, times, 0 * times, start)
    exact = [
        round(Fraction(rate[0]) * Fraction(t) + Fraction(rate[1]) * Fraction(t) + Fraction(1, 4)) for t in times[:3]
    ]
    assert whole.tolist() == theirs.tolist() == [*exact, 2**62, -(2**62)]
    assert np.array_equal(rest[:3], left[:3])
