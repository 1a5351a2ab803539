"""Greenwood's worked examples 5-1, 5-2 and problems P5-3 … P5-6 end in the formulas the book prints."""

from __future__ import annotations

import random

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from tests.support.entries import forms

t, t_0 = sp.symbols("t t_0", real=True)


def regime(name: str, **kinds: str) -> RegimeForms:
    return next(f for f in forms(name) if dict(f.regime.kinds) == kinds and not f.regime.special)


def symbols(form: RegimeForms, *names: str) -> list[sp.Symbol]:
    known = {s.name: s for name in form.named() for s in form.written_out(name).free_symbols}
    known |= {s.name: s for s in form.regime.example}
    return [known[name] for name in names]


def agrees(one: sp.Expr, other: sp.Expr, ranges: dict[sp.Symbol, tuple[float, float]], count: int = 6) -> None:
    draw = random.Random(5)
    for _ in range(count):
        at = {s: sp.Rational(str(round(draw.uniform(*r), 3))) for s, r in ranges.items()}
        a, b = (sp.N(e.xreplace(at), 50) for e in (one, other))
        assert not a.free_symbols | b.free_symbols
        assert abs(a - b) <= abs(b) * sp.Float(10) ** -38, (at, a, b)


def test_example_5_1_spring() -> None:
    """(5-95), (5-100): x = x₀ cos ω(t − t₀) + (v₀/ω) sin ω(t − t₀)."""
    form = regime("harmonic-oscillator", x="libration")
    x_0, E, m, k = symbols(form, "x_0", "E", "m", "k")
    v_0, ω = sp.sqrt((2 * E - k * x_0**2) / m), sp.sqrt(k / m)
    printed = x_0 * sp.cos(ω * (t - t_0)) + v_0 / ω * sp.sin(ω * (t - t_0))
    agrees(
        form.written_out("inverse.x"), printed, {x_0: (-1, 1), E: (4, 6), m: (1, 2), k: (1, 3), t: (-4, 9), t_0: (0, 1)}
    )


def test_example_5_2_kepler_orbit() -> None:
    """(5-122): r = (α²/μ)/(1 + e cos θ), e = √(1 + 2E α²/μ²), from the perihelion, in every regime."""
    for form in forms("kepler-planar")[:2]:
        r_0, p, m, k, E, θ, β = symbols(form, "r_0", "p_theta", "m", "k", "E", "theta", "beta_theta")
        e = sp.sqrt(1 + 2 * E * p**2 / (m * k**2))
        perihelion = p**2 / (m * k) / (1 + e)
        printed = p**2 / (m * k) / (1 + e * sp.cos(θ + β))
        bound = form.regime.kinds["r"] == "libration"
        energies = (-0.12, -0.05) if bound else (0.05, 0.3)
        ranges = {E: energies, p: (0.5, 1.2), m: (1, 1.5), k: (1, 2), θ: (0, 1.5), β: (0, 0.2)}
        agrees(form.written_out("orbit.r").subs(r_0, perihelion), printed, ranges)
    assert "Kepler's equation" in str(forms("kepler-planar")[0].why_not["inverse.r"])


def test_example_5_2_parabola() -> None:
    form = next(f for f in forms("kepler-planar") if f.regime.special and "E = 0" in f.regime.words)
    r_0, p, m, k, θ, β = symbols(form, "r_0", "p_theta", "m", "k", "theta", "beta_theta")
    printed = p**2 / (m * k) / (1 + sp.cos(θ + β))
    orbit = form.written_out("orbit.r").subs(r_0, p**2 / (2 * m * k))
    agrees(orbit, printed, {p: (0.5, 1.2), m: (1, 1.5), k: (1, 2), θ: (0, 1.5), β: (0, 0.2)})


def test_problem_5_3_disk_on_slope() -> None:
    """t = (1/(g sin γ)) √(3/m) [√(α + mgrθ sin γ) − √α]; θ = θ̇₀ t + (g sin γ/3r) t²."""
    form = regime("disk-on-slope", theta="escape")
    θ, θ_0, E, m, g, r, γ = symbols(form, "theta", "theta_0", "E", "m", "g", "r", "gamma")
    assert form.time_law is not None
    slope = g * sp.sin(γ)
    printed = sp.sqrt(3 / m) / slope * (sp.sqrt(E + m * r * slope * θ) - sp.sqrt(E))
    ranges = {E: (1, 2), m: (1, 2), g: (9, 10), r: (0.2, 1), γ: (0.1, 0.7)}
    agrees(form.time_law.rhs.subs(θ_0, 0), printed, ranges | {θ: (0.1, 5)})
    place = sp.sqrt(4 * E / (3 * m * r**2)) * (t - t_0) + slope / (3 * r) * (t - t_0) ** 2
    agrees(form.written_out("inverse.theta").subs(θ_0, 0), place, ranges | {t: (0, 5), t_0: (0, 0.1)})


def test_problem_5_4_projectile() -> None:
    """x = ẋ₀ t, y = ẏ₀ t − ½ g t², y = x tan θ₀ − g x²/(2 v₀² cos² θ₀)."""
    form = regime("projectile", y="escape")
    x, y_0, β, p_x, E, m, g = symbols(form, "x", "y_0", "beta_x", "p_x", "E", "m", "g")
    v_y = sp.sqrt(2 * E * m - p_x**2) / m
    ranges = {E: (3, 4), m: (1, 1.2), g: (9, 10), p_x: (0.4, 1)}
    rise = v_y * (t - t_0) - g * (t - t_0) ** 2 / 2
    agrees(form.written_out("inverse.y").subs(y_0, 0), rise, ranges | {t: (0, 2), t_0: (0, 0.1)})
    agrees(form.written_out("inverse.x"), p_x / m * (t - t_0) - β, ranges | {t: (0, 2), t_0: (0, 0.1), β: (-1, 1)})
    v_x = p_x / m
    parabola = x * v_y / v_x - g * x**2 / (2 * v_x**2)
    agrees(form.written_out("orbit.y").subs({y_0: 0, β: 0}), parabola, ranges | {x: (-1, 1)})


@pytest.mark.nightly
def test_problem_5_5_isotropic_oscillator() -> None:
    """r(t) = [α_t/k + (1/k)√(α_t² − (k/m) α_θ²) cos 2√(k/m) t]^½, r(θ) = (α_θ/√m)[α_t − √(…) cos 2θ]^(−½).

    The first starts at r_max, the second at the perihelion.
    """
    form = regime("isotropic-oscillator-polar", r="libration")
    r_0, p, m, k, E, θ, β = symbols(form, "r_0", "p_theta", "m", "k", "E", "theta", "beta_theta")
    root = sp.sqrt(E**2 - k / m * p**2)
    ranges = {E: (2.5, 3), m: (1, 1.5), k: (1, 1.4), p: (0.5, 1.2)}
    in_time = sp.sqrt(E / k + root / k * sp.cos(2 * sp.sqrt(k / m) * (t - t_0)))
    agrees(
        form.written_out("inverse.r").subs(r_0, sp.sqrt((E + root) / k)), in_time, ranges | {t: (0, 3), t_0: (0, 0.1)}
    )
    along = p / sp.sqrt(m) / sp.sqrt(E + root * sp.cos(2 * (θ + β)))
    agrees(form.written_out("orbit.r").subs(r_0, sp.sqrt((E - root) / k)), along, ranges | {θ: (0, 3), β: (0, 0.1)})


def test_problem_5_6_hyperbola() -> None:
    """(q₁ + √(q₁² + a²))/(q₂ + √(q₂² − b²)) = A: the orbit equation is its logarithm, to a factor."""
    solution = hjsolve.solve("liouville-p5-6")
    motion = solution.motion(q={"q1": "0.3", "q2": "3"}, velocity={"q1": "0.5", "q2": "0.4"})
    form = own_form(motion)
    assert form is not None
    q1, q2, E, α, K = symbols(form, "q1", "q2", "E", "alpha_2", "K")
    law = form.orbit_equations["alpha_2"].rhs
    values = dict(form.regime.example)
    a2, b2 = (values[K] + values[α]) / values[E] * -1, values[α] / values[E] * -1
    left = sp.log((q1 + sp.sqrt(q1**2 + a2)) / (q2 + sp.sqrt(q2**2 - b2))) / sp.sqrt(2 * values[E])
    difference = law.xreplace(values) + left
    assert {s.name for s in difference.free_symbols} == {"q1", "q2", "q1_0", "q2_0"}
    (u0, v0) = symbols(form, "q1_0", "q2_0")
    found = [
        sp.N(difference.xreplace({q1: sp.Rational(a, 10), q2: sp.Rational(b, 10), u0: sp.S(1), v0: sp.S(3)}), 50)
        for a, b in ((3, 31), (7, 45), (12, 80))
    ]
    assert all(abs(value - found[0]) < sp.Float(10) ** -38 for value in found[1:]), found


@pytest.mark.rotating(2)
@pytest.mark.nightly_cases("isochrone", "kepler-planar", "morse")
@pytest.mark.parametrize("name", ["kepler-planar", "isochrone", "morse", "poeschl-teller", "harmonic-oscillator"])
def test_energies_from_actions(name: str) -> None:
    """H(J) put through J(E) is E, and its derivatives are the frequencies."""
    form = next(f for f in forms(name) if f.energy is not None)
    assert form.energy is not None
    at = dict(form.regime.example)
    actions = {sp.Symbol(f"J_{n}", real=True): sp.N(J.xreplace(at), 60) for n, J in form.actions.items()}
    (E,) = symbols(form, "E")
    assert abs(sp.N(form.energy.xreplace(at).xreplace(actions), 50) - at[E]) < sp.Float(10) ** -38 * abs(at[E])
    for n, Ω in form.frequencies.items():
        slope = sp.diff(form.energy, sp.Symbol(f"J_{n}", real=True)).xreplace(at).xreplace(actions)
        assert abs(sp.N(slope, 50) - sp.N(Ω.xreplace(at), 50)) < sp.Float(10) ** -36 * abs(sp.N(Ω.xreplace(at), 50))
