"""Systems with more integrals than they need are told as such, and their frequencies do what that says."""

from __future__ import annotations

import pytest

import hjsolve

R2, R3 = "sqrt(x**2 + y**2)", "sqrt(x**2 + y**2 + z**2)"


def solved(V: str, names: str) -> hjsolve.Solution:
    kinetic = " + ".join(f"dot({q})**2/2" for q in names)
    return hjsolve.solve(hjsolve.System(dict.fromkeys(names, "line"), kinetic, V), coordinates="find")


@pytest.mark.nightly_cases(
    "-1/sqrt(x**2 + y**2 + z**2)-xyz-5", "x**2 + y**2 + z**2 + 1/(x - y)**2 + 1/(y - z)**2 + 1/(z - x)**2-xyz-4",
)  # fmt: skip
@pytest.mark.parametrize(
    ("V", "names", "independent"),
    [
        (f"-1/{R2}", "xy", 3),
        ("-1/sqrt((x - 1)**2 + (y - 2)**2) - 2/sqrt((x - 3)**2 + (y + 1)**2)", "xy", 2),
        (f"-1/{R2} + x/50 + y/100", "xy", 2),
        (f"-1/{R3}", "xyz", 5),
        ("x**2 + y**2 + z**2 + 1/(x - y)**2 + 1/(y - z)**2 + 1/(z - x)**2", "xyz", 4),
    ],
)
def test_independent_integrals_are_those_of_the_literature(V: str, names: str, independent: int) -> None:
    """Kepler: 2n − 1; two centres and Stark: n; the rational Calogero model in three dimensions: quadratic ones, 4."""
    chart = solved(V, names).chart
    assert chart.independent == independent
    assert ("relation" in chart.remark) == (independent > len(names))


def test_the_choice_of_web_and_the_extra_integrals_are_told() -> None:
    solution = solved(f"-1/{R2}", "xy")
    remark = solution.chart.remark
    assert "parabolic (a family), polar, elliptic (a family)" in remark
    assert "polar ones were taken, whose equations are the simplest" in remark
    assert "bounded motions close" in remark
    assert "(-p_x*y + p_y*x)**2" in remark
    motion = solution.motion(q={"x": "0.3", "y": "0.9"}, velocity={"x": "-0.4", "y": "0.5"}, digits=40)
    r, theta = (motion.frequencies[name] for name in ("r", "theta"))
    assert abs(abs(r.value) - abs(theta.value)) <= r.error + theta.error < 1e-38


def test_a_report_names_the_frequencies_that_agree(tmp_path) -> None:
    motion = solved(f"-1/{R2}", "xy").motion(q={"x": "0.3", "y": "0.9"}, velocity={"x": "-0.4", "y": "0.5"})
    target = tmp_path / "kepler.txt"
    hjsolve.report(motion, target)
    assert "Ω_r = Ω_theta" in target.read_text(encoding="utf-8")


def test_modes_in_a_ratio_of_whole_numbers_are_told() -> None:
    """x + y swings with 1, x − y with 2."""
    remark = solved("(x + y)**2/4 + (x - y)**2", "xy").chart.remark
    assert "2 Ω_mode_1 = Ω_mode_2" in remark
    assert "exactly" not in solved("(x + y)**2/4 + (x - y)**2/3", "xy").chart.remark
