"""What is drawn on axes of matplotlib is the motion: its curves obey its laws; single figures; without matplotlib."""

from __future__ import annotations

import builtins
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import hjsolve
from hjsolve.plots import style

mpl = pytest.importorskip("matplotlib", reason="needs the extra report")
mpl.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

PLOTTED = (
    "kepler-planar",
    "pendulum",
    "spherical-pendulum",
    "kepler-spherical",
    "kerr",
    "stark",
    "projectile",
    "double-well",
)


def default_motion(name: str) -> Any:
    return hjsolve.solve(name).motion(**hjsolve.catalog.describe(name).motions["default"].arguments)


def of_motion(ax: Any) -> Any:
    """The strong line."""
    return next(line for line in ax.lines if line.get_color() == style.RED and line.get_linewidth() == 2.0)


def test_the_orbit_of_kepler_is_its_ellipse() -> None:
    """r = p/(1 + e cos θ) with p = L² = 36/25 and e = 11/25 (m = k = 1)."""
    ax = default_motion("kepler-planar").plot()
    x, y = of_motion(ax).get_data()
    r = np.hypot(x, y)
    assert np.abs(r + 0.44 * x - 1.44).max() < 1e-12
    assert x.min() == pytest.approx(-18 / 7, abs=1e-3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x$", "$y$")


def test_the_phase_curve_has_the_energy_of_the_motion() -> None:
    motion = default_motion("pendulum")
    ax = motion.plot("phase", "theta")
    theta, p = of_motion(ax).get_data()
    values = {symbol.name: float(value) for symbol, value in motion.initial.values.items()}
    energy = p**2 / (2 * values["m"] * values["l"] ** 2) - values["m"] * values["g"] * values["l"] * np.cos(theta)
    assert np.abs(energy - motion.constants["E"].value).max() < 1e-9
    assert np.ptp(theta) == pytest.approx(np.ptp([e.value for e in motion.turning_points["theta"]]))


def test_the_turning_points_lie_where_the_potential_has_the_energy() -> None:
    motion = default_motion("kepler-planar")
    ax = motion.plot("potential", "r")
    dots = next(line for line in ax.lines if line.get_marker() == "o")
    assert list(dots.get_xdata()) == [end.value for end in motion.turning_points["r"]]
    q = np.asarray(dots.get_xdata())
    assert np.abs(-1 / q + 0.72 / q**2 - motion.constants["E"].value).max() < 1e-14


def test_the_graph_in_time_passes_its_turning_points() -> None:
    motion = default_motion("kepler-planar")
    t, r = of_motion(motion.plot("time", "r")).get_data()
    assert t[-1] - t[0] == pytest.approx(motion.periods["r"].value)
    assert r.max() == pytest.approx(18 / 7, abs=1e-3)


@pytest.mark.nightly_cases("kerr")
@pytest.mark.parametrize("name", PLOTTED)
def test_every_kind_is_drawn_for_every_separated_coordinate(name: str) -> None:
    motion = default_motion(name)
    for kind, coordinate in [
        ("orbit", None),
        *((k, q) for k in ("time", "phase", "potential") for q in motion.solution.coordinates),
    ]:
        ax = motion.plot(kind, coordinate)
        assert of_motion(ax) is not None
        ax.figure.canvas.draw()  # labels are mathematics that matplotlib understands
        plt.close(ax.figure)


def test_axes_given_are_drawn_on_and_given_back() -> None:
    _, (left, right) = plt.subplots(1, 2)
    motion = default_motion("kepler-spherical")
    assert motion.plot("orbit", ax=left) is left
    assert motion.plot("phase", "theta", ax=right) is right
    assert len(plt.get_fignums()) == 1


def test_a_solution_plots_a_motion_of_its_own() -> None:
    solution = hjsolve.solve("kepler-planar")
    wide = of_motion(solution.plot("orbit", q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.3"}))
    near = of_motion(solution.plot("orbit"))
    assert np.ptp(wide.get_xdata()) > np.ptp(near.get_xdata())
    own = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4"))
    with pytest.raises(hjsolve.InvalidInputError, match="which motion"):
        own.plot()


def test_the_animated_point_is_where_the_motion_is() -> None:
    motion = default_motion("kepler-planar")
    animation = motion.animate(frames=12, seconds=1)
    (point,) = animation._func(3)
    state = motion.at(3 * motion.periods["r"].value / 12)
    assert point.get_xdata()[0] == pytest.approx(state.q["r"] * np.cos(state.q["theta"]), rel=1e-12)
    assert point.get_ydata()[0] == pytest.approx(state.q["r"] * np.sin(state.q["theta"]), rel=1e-12)
    animation._draw_was_started = True  # nothing is rendered here, and that is meant


def test_an_animation_can_be_saved(tmp_path: Path) -> None:
    from matplotlib.animation import PillowWriter

    for name in ("pendulum", "spherical-pendulum"):
        default_motion(name).animate(frames=3, seconds=1).save(tmp_path / f"{name}.gif", writer=PillowWriter(3))
        assert (tmp_path / f"{name}.gif").read_bytes()[:3] == b"GIF"


def test_wavefronts_are_plotted_between_their_caustics() -> None:
    axes = default_motion("kepler-planar").plot("wavefronts")
    radii = [np.hypot(line.get_xdata(), line.get_ydata()) for line in axes.lines]
    assert min(np.nanmin(r) for r in radii) == pytest.approx(1, rel=1e-12)
    assert max(np.nanmax(r) for r in radii) == pytest.approx(18 / 7, rel=1e-12)
    assert len(axes.lines) == 2 * 24 + 12 + 2  # two sheets of each front, orbits, two circles


@pytest.mark.parametrize(("call", "said"), [
    (lambda m: m.plot("rays"), "kind is one of orbit, time, phase, potential"),
    (lambda m: m.plot("phase", "theta"), '"theta" is not separated; r'),
    (lambda m: m.plot("time", "x"), "not a coordinate; they are r, theta"),
    (lambda m: m.plot("orbit", ax=3), "axes of matplotlib"),
    (lambda m: m.animate(frames=1), "frames"),
    (lambda m: m.animate(seconds=-1), "seconds > 0"),
])  # fmt: skip
def test_what_cannot_be_drawn_is_told(call: Any, said: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=said):
        call(default_motion("kepler-planar"))


def test_without_matplotlib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name.partition(".")[0] == "matplotlib":
            raise ImportError(name)
        return real(name, *rest)

    motion = default_motion("pendulum")
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(hjsolve.MissingExtraError, match=r"hjsolve\[report\]"):
        motion.plot()


def test_single_figures_are_files_of_their_own(tmp_path: Path) -> None:
    figures = hjsolve.figures(default_motion("kerr"))
    assert list(figures) == ["potential.r", "phase.r", "potential.theta", "phase.theta", "orbit", "time"]
    for name, figure in figures.items():
        path = figure.save(tmp_path / f"{name}.svg")
        assert ET.parse(path).getroot().tag.endswith("svg")
        assert figure._repr_svg_() == path.read_text(encoding="utf-8")
    with pytest.raises(hjsolve.InvalidInputError, match=r"suffix must be one of \.svg"):
        figures["orbit"].save(tmp_path / "orbit.png")
    with pytest.raises(hjsolve.InvalidInputError, match="a Motion is needed"):
        hjsolve.figures("kerr")


def test_a_motion_in_found_coordinates_draws_its_orbit_in_space() -> None:
    plane = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt(x**2 + y**2)")
    motion = hjsolve.solve(plane, coordinates="find").motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": "1.2"})
    x, y = of_motion(motion.plot()).get_data()
    assert np.abs(np.hypot(x, y) + 0.44 * x - 1.44).max() < 1e-12
    assert list(hjsolve.figures(motion)) == ["potential.r", "phase.r", "orbit", "time"]
    assert motion.plot("time").get_ylabel() == "$r$"
    animation = motion.animate(frames=5)
    (point,) = animation._func(2)
    assert point.get_xdata()[0] == pytest.approx(float(motion.at(2 * motion.periods["r"].value / 5).q["x"]), rel=1e-9)
    animation._draw_was_started = True
