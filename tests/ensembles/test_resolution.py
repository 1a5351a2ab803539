"""Ensembles only believe nodes that are proved to resolve p²: narrow features cannot hide between them."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve
from hjsolve.ensembles import engine
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.ensembles.engine.node_maps import COUNTS
from hjsolve.ensembles.engine.proof_of_resolution import ResolutionProof
from hjsolve.lowering import lower
from tests.support.kuzmin_kutuzov import load, solution

pytestmark = pytest.mark.rotating_file(6)

NEAR_RADIAL = [
    ((1.700952792685187, -1.4174105912280575, 0.09392437137045764, 0.1025890155461678, -1.731143245972768e-09),
     (0.3872664972613454, -0.19363329646994623, 0.2195424304942989)),
    ((1.2767962197234781, 1.1803231370051208, 0.7406958397843033, 0.29334926049349463, 2.4041729128954737e-06),
     (0.33305846412812956, 0.19946536127390915, 0.19947040968200233)),
]  # fmt: skip

# potential, widths of pieces from the feature, its place; all start at q = 1, p = 2 (period and action: `_truth`)
NARROW = {
    "dip 0.05": ("x**2/2 - exp(-400*x**2)", 0.05, 0.0),
    "dip 0.01": ("x**2/2 - exp(-10000*x**2)", 0.01, 0.0),
    "dip 1e-5": ("x**2/2 - exp(-10000000000*x**2)", 1e-5, 0.0),
    "sech": ("x**2/2 - 1/cosh(100*x)**2", 0.01, 0.0),
    "bump": ("x**2/2 + exp(-2500*x**2)", 0.02, 0.0),
    "wave": ("x**2/2 + exp(-400*x**2)*sin(50*x)/3", 0.05, 0.0),
    "next to the turning point": ("x**2/2 - exp(-1000000*(x - 19/10)**2)", 0.001, 1.9),
    "step": ("x**2/2 + tanh(200*x)/10", 0.005, 0.0),
    "Lorentzian": ("x**2/2 - 1/(5*(1 + 10000*x**2))", 0.01, 0.0),
    "quartic with a ring": ("x**4/4 + exp(-40000*(x + 1/3)**2)/20", 0.005, -1 / 3),
}


def _truth(text: str, width: float, place: float) -> tuple[mpf, mpf]:
    """Action and period by Gauss–Legendre rules between points that are dense about the feature, in 30 digits."""
    import sympy as sp

    x = sp.Symbol("x")
    V = sp.lambdify(x, sp.sympify(text, rational=True), "mpmath")
    with mp.workdps(30):
        E = 2 + V(mpf(1))
        ends = [mp.findroot(lambda q: E - V(q), guess) for guess in _brackets(lambda q: E - V(q))]
        a, b = ends
        middle, half = (a + b) / 2, (b - a) / 2
        near = [mpf(place) + s * width * mpf(2) ** k for k in range(-3, 30) for s in (-1, 1)]
        near = [q for q in [mpf(place), *near] if a < q < b]
        cuts = sorted({mpf(0), mp.pi, *(mp.acos((middle - q) / half) for q in near)})

        def speed(φ: mpf) -> mpf:  # dq/dφ over p, smooth at both ends
            q = middle - half * mp.cos(φ)
            return half * mp.sin(φ) / mp.sqrt(2 * (E - V(q)))

        def momentum(φ: mpf) -> mpf:
            return half * mp.sin(φ) * mp.sqrt(2 * abs(E - V(middle - half * mp.cos(φ))))

        period = 2 * mp.quad(speed, cuts)
        return mp.quad(momentum, cuts) / mp.pi, period


def _brackets(f: Any) -> list[tuple[Any, Any]]:
    low = next(k for k in range(1, 400) if f(1 - mpf(k) / 64) < 0)
    high = next(k for k in range(1, 400) if f(1 + mpf(k) / 64) < 0)
    return [(1 - mpf(low) / 64, 1 - mpf(low - 1) / 64), (1 + mpf(high - 1) / 64, 1 + mpf(high) / 64)]


def _orbits(text: str, **how: Any) -> hjsolve.Batch:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", text)
    return hjsolve.ensemble(system, {"x": [1.0]}, {"x": [2.0]}, want={"actions", "periods"}, threads=1, **how)


def _error(found: hjsolve.Batch, quantity: str, value: mpf) -> float:
    return float(abs(mpf(getattr(found, quantity)["x"].item()) - value))


@pytest.mark.rotating(4)
@pytest.mark.parametrize("name", NARROW)
def test_narrow_features_are_seen_by_ensembles(name: str) -> None:
    text, width, place = NARROW[name]
    found = _orbits(text)
    assert found.status.item() == "ok"
    for quantity, value in zip(("actions", "periods"), _truth(text, width, place), strict=True):
        claim = found.error[quantity]["x"].item()
        assert _error(found, quantity, value) <= claim <= 1e-12 * abs(value)


def test_the_engine_itself_hands_back_what_it_cannot_prove() -> None:
    # nodes crowd about one narrow dip, not about two
    two = "x**2/2 - exp(-10**10*x**2) - exp(-10**10*(x - 1/2)**2)"
    assert _orbits(two, fallback=False).status.item() == "not_converged"


def test_without_the_proof_the_false_number_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    text, width, place = NARROW["dip 1e-5"]
    monkeypatch.setattr(ResolutionProof, "least", lambda self, left, maps, span: np.full(len(left), COUNTS.index(32)))
    found = _orbits(text, fallback=False)
    period = _truth(text, width, place)[1]
    assert found.status.item() == "ok"
    assert _error(found, "periods", period) > 100 * found.error["periods"]["x"].item()


def _clearance(*texts: str) -> Clearance:
    import sympy as sp

    x = sp.Symbol("x")
    return Clearance(lower([sp.sympify(t, rational=True) for t in texts], [x]), (), alone=True)


@pytest.mark.parametrize("seed", range(8))
def test_disks_end_before_the_nearest_singularity(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poles = rng.uniform(-2, 2, 3) + 1j * 10.0 ** rng.uniform(-5, 0, 3)
    terms = [f"1/((x - ({float(z.real)!r}))**2 + ({float(z.imag)!r})**2)" for z in poles]
    known = _clearance(*terms[:2], f"sqrt((x - ({float(poles[2].real)!r}))**2 + ({float(poles[2].imag)!r})**2)")
    x = np.concatenate([rng.uniform(-3, 3, 200), poles.real, poles.real + poles.imag])
    x = x + 1j * np.concatenate([np.zeros(100), rng.uniform(0, 1, 106)])
    nearest = np.min([np.abs(x - p) for z in poles for p in (z, z.conj())], axis=0)
    radius = known.radius(x)
    assert (radius <= nearest).all()
    assert np.median(radius / nearest) > 0.1  # and they are not empty


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-6])
def test_disks_do_not_hold_a_narrow_gaussian(width: float) -> None:
    x = np.array([1e-9, 1e-3, 1.0, -2.0])
    radius = _clearance(f"x**2/2 - exp(-(x/{width!r})**2)").radius(x)
    assert (radius <= np.abs(x) + 3 * width).all()  # exp(9) is more than a disk may grow


def test_the_frequencies_of_two_near_radial_orbits_are_right_to_1e_13() -> None:
    # u, w, p_u, p_w, p_φ as doubles; Ω_u, Ω_φ, Ω_w by ball arithmetic at 55 digits
    data = NEAR_RADIAL
    u, w, pu, pw, pφ = np.array([row[0] for row in data]).T
    made = engine.build(solution(), frozenset({"actions", "frequencies"}))
    columns = made.run({"u": u, "w": w, "phi": 0 * u}, {"u": pu, "w": pw, "phi": pφ})
    for k, name in enumerate(("u", "phi", "w")):
        exact = np.array([row[1][k] for row in data])
        size = np.abs(exact)
        error, claim = np.abs(columns.frequencies[name] - exact), columns.error[f"frequencies.{name}"]
        assert (error <= claim).all()
        assert (error <= 2e-14 * size).all()
        assert (claim <= 1e-12 * size).all()


def test_bound_orbits_that_are_not_computed_are_not_called_unbounded() -> None:
    q = {"r": np.array([1.0, 1e300]), "theta": 0}
    p = {"r": 0.0, "theta": np.array([0.0, 1.0])}
    found = hjsolve.ensemble("kepler-planar", q=q, p=p, want={"actions"}, fallback=False)
    assert set(found.status.tolist()) <= {"not_converged", "reaches_boundary"}


def test_no_warning_of_numpy_reaches_the_user() -> None:
    data = load()
    rows = data["prolate"][np.isin(data["family"], (1, 2))]  # nearly circular, nearly planar
    made = engine.build(solution(), frozenset({"actions", "frequencies"}))
    u, w, pu, pw, pφ = rows.T
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert (made.run({"u": u, "w": w, "phi": 0 * u}, {"u": pu, "w": pw, "phi": pφ}).status == 0).all()
