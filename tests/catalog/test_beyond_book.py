"""Systems beyond the book: hjsolve's motions against the closed forms of the literature."""

from collections.abc import Callable
from typing import Any

import pytest
import sympy as sp
from mpmath import mp

from hjsolve import catalog
from tests.support import entries
from tests.support.book import motion, off, start

FREQUENCIES: dict[tuple[str, str, str], Callable[[Any], Any]] = {
    # Landau & Lifshitz, Quantum Mechanics §23: E = D − (a J/√(2m) − √D)², so Ω = a√(2(D − E)/m)
    ("morse", "default", "x"): lambda E: mp.sqrt(2 * (1 - E)),
    # E = −(√V₀ − a J/√(2m))², so Ω = a√(−2E/m)
    ("poeschl-teller", "default", "x"): lambda E: mp.sqrt(-2 * E),
    # Binney & Tremaine (3.49): the radial frequency depends on the energy alone, Ω_r = (−2E)^(3/2)/k
    ("isochrone", "default", "r"): lambda E: (-2 * E) ** mp.mpf("1.5"),
    # superintegrable: both coordinates have twice the frequency of the oscillator, at every energy
    ("smorodinsky-winternitz", "default", "x"): lambda _: mp.mpf(2),
    ("smorodinsky-winternitz", "default", "y"): lambda _: mp.mpf(2),
    ("anisotropic-oscillator", "default", "y"): lambda _: mp.sqrt(2),
    ("anisotropic-oscillator", "default", "z"): lambda _: mp.sqrt(3),
    # the cyclotron frequency
    ("charge-in-uniform-field", "default", "r"): lambda _: mp.mpf(1),
}


@pytest.mark.parametrize(("entry", "name", "coordinate"), FREQUENCIES)
def test_the_frequency_is_that_of_the_literature(entry: str, name: str, coordinate: str) -> None:
    run = motion(entry, name)
    expected = FREQUENCIES[entry, name, coordinate](mp.mpf(float(run.constants["E"].value)))
    assert off(run.frequencies[coordinate].value, expected) < 1e-13


def test_the_isochrone_turns_by_the_angle_of_henon() -> None:
    """Ω_θ/Ω_r = ½(1 + L/√(L² + 4kb)) (Binney & Tremaine (3.54), unit mass)."""
    run = motion("isochrone")
    L = mp.mpf(float(run.constants["p_theta"].value))
    ratio = mp.mpf(run.frequencies["theta"].value) / mp.mpf(run.frequencies["r"].value)
    assert off(float(ratio), (1 + L / mp.sqrt(L**2 + 2)) / 2) < 1e-13


def test_a_geodesic_of_the_cone_is_a_straight_line_when_unrolled() -> None:
    """The unrolled angle is φ·sin α; the distance from the tip obeys Pythagoras."""
    run, state, time = motion("cone-geodesics"), motion("cone-geodesics").at(5), mp.mpf(5)
    across = mp.mpf("0.8") * mp.sin(mp.pi / 6)
    assert off(state.q["s"], mp.sqrt((1 - time / 2) ** 2 + (across * time) ** 2)) < 1e-13
    assert off(run.turning_points["s"][0].value, across / mp.sqrt(mp.mpf("0.25") + across**2)) < 1e-13


def test_one_centre_of_two_is_kepler() -> None:
    """With k₂ = 0 both frequencies of the elliptic coordinates are Kepler's, √((−2E)³)/k (degeneracy)."""
    data = {"q": {"xi": "1", "eta": "2/5"}, "velocity": {"xi": "1/10", "eta": "3/5"}}
    run = start("two-centres-plane", **data, k2=0)
    expected = mp.sqrt((-2 * mp.mpf(float(run.constants["E"].value))) ** 3)
    assert run.kinds == {"xi": "libration", "eta": "rotation"}
    for name in ("xi", "eta"):
        assert off(run.frequencies[name].value, expected) < 1e-12


def test_the_spheroid_that_is_a_sphere_has_great_circles() -> None:
    run = start("oblate-geodesics", {"beta": "1/5", "lambda_": 0}, {"beta": "7/10", "lambda_": "3/5"}, b=1)
    speed = mp.sqrt(mp.mpf("0.49") + (mp.cos(mp.mpf("0.2")) * mp.mpf("0.6")) ** 2)
    assert off(run.frequencies["beta"].value, speed) < 1e-13
    assert off(run.frequencies["lambda_"].value, speed) < 1e-13


def test_the_double_well_takes_for_ever_at_the_height_of_the_barrier() -> None:
    """E = 0: x = √2 sech t for a = b = m = 1, which reaches the top only in the limit."""
    run = start("double-well", {"x": "sqrt(2)"}, {"x": 0})
    assert run.kinds == {"x": "asymptotic"}
    assert off(run.at(2).q["x"], mp.sqrt(2) / mp.cosh(2)) < 1e-12


def test_every_system_beyond_the_book_cites_its_literature() -> None:
    for name in catalog.ids("separable"):
        entry = entries.described(name)
        if not entry.book:
            assert any(not text.startswith("greenwood") for text in entry.cite), name


def test_the_perfect_oblate_spheroid_has_its_density() -> None:
    """∇²Φ = 4π G ρ₀/(1 + R²/a² + z²/c²)² with mass π² a² c ρ₀ (de Zeeuw 1985, (22)–(26)): Laplacian by differences."""
    system = catalog.load("perfect-oblate-spheroid")
    potential = sp.lambdify([system.symbols[n] for n in ("u", "w", "d", "c", "GM")], system.potential, "mpmath")

    def at(x: Any, y: Any, z: Any) -> Any:
        R2, d = x * x + y * y, mp.mpf("1.5")
        whole = R2 + z * z - d * d  # s = d² sinh²u: s² − (R² + z² − d²) s − d² R² = 0
        s = (whole + mp.sqrt(whole**2 + 4 * d * d * R2)) / 2
        return potential(mp.asinh(mp.sqrt(s) / d), mp.asin(z / mp.sqrt(s + d * d)), d, mp.mpf("0.8"), 2)

    with mp.workdps(60):
        a2, c2, place, h = (
            mp.mpf("1.5") ** 2 + mp.mpf("0.64"),
            mp.mpf("0.64"),
            (mp.mpf("0.7"), mp.mpf("0.4"), mp.mpf("0.3")),
            mp.mpf(10) ** -12,
        )
        second = [[at(*(x + k * h * (i == j) for j, x in enumerate(place))) for k in (-1, 0, 1)] for i in range(3)]
        laplacian = mp.fsum(low - 2 * mid + high for low, mid, high in second) / h**2
        x, y, z = place
        density = 2 / (mp.pi**2 * a2 * mp.sqrt(c2)) / (1 + (x * x + y * y) / a2 + z * z / c2) ** 2
        assert off(float(laplacian), 4 * mp.pi * density) < 1e-14
