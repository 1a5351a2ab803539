"""The problems of chapter 6 that are theorems, and P6-9, P6-12, P6-13; sympy's algorithms end in time."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.algebra.time_limit import in_time
from hjsolve.mechanics.brackets import bracket

QUARTER = "0 < p < pi/2"


def proved(**given: object) -> hjsolve.CanonicalMap:
    found = hjsolve.canonical(**given)  # type: ignore[arg-type]
    assert isinstance(found, hjsolve.CanonicalMap)
    return found


@pytest.mark.nightly
def test_p6_7_a_vanishing_f4_means_that_sum_q_dP_dq_vanishes() -> None:
    """F4 = ψ + Σ QP − Σ qp in the old variables: 0 for P6-6 and for every P = f(p), where Σ q ∂P/∂q = 0; not Ex 6-2."""
    maps = [
        ({"map": {"Q": "q*cos(2*p)**2", "P": "tan(2*p)/2"}, "domains": {"q": "0 < q", "p": "0 < p < pi/4"}}, True),
        ({"map": {"Q1": "q1/p2", "Q2": "q2 - q1*p1/p2", "P1": "p1*p2", "P2": "p2"},
          "coordinates": {"q1": "p1", "q2": "p2"}, "domains": {"p2": "0 < p2"}}, True),
        ({"map": {"Q": "sqrt(2*q)*cos(p)", "P": "sqrt(2*q)*sin(p)"}, "domains": {"q": "0 < q", "p": QUARTER}}, False),
    ]  # fmt: skip
    for given, vanishes in maps:
        found = proved(**given)
        n = len(found.map) // 2
        Q, P = list(found.map.values())[:n], list(found.map.values())[n:]
        symbols = {str(x): x for f in found.map.values() for x in f.free_symbols}
        pairs = [(symbols[q], symbols[p]) for q, p in given.get("coordinates", {"q": "p"}).items()]
        F4 = found.psi + sum(a * b for a, b in zip(Q, P, strict=True)) - sum(q * p for q, p in pairs)
        slopes = [sp.simplify(sum(q * sp.diff(b, q) for q, _ in pairs)) for b in P]
        assert (sp.simplify(F4) == 0) is vanishes
        assert all(slope == 0 for slope in slopes) is vanishes


def test_p6_9_the_map_with_one_relation_between_old_and_new_coordinates() -> None:
    """Ω = sin(q1 + Q1) − √(q2² + Q2²) = 0 holds identically; the brackets are those of a canonical map; rank one."""
    q1, q2, p1, p2 = sp.symbols("q1 q2 p1 p2", real=True)
    α = sp.asin(-2 * q2 * p1 / p2)
    root = sp.sqrt((1 - sp.cos(α)) / 2 - q2**2)
    Q, P = [α / 2 - q1, root], [-p1, -p2 / q2 * root]
    at = {q1: sp.Rational(1, 5), q2: sp.Rational(1, 7), p1: sp.Rational(3, 4), p2: sp.Rational(-2, 5)}
    Ω = sp.sin(q1 + Q[0]) - sp.sqrt(q2**2 + Q[1] ** 2)
    assert abs(sp.N(Ω.subs(at), 40)) < 1e-35
    pairs = [(q1, p1), (q2, p2)]
    for i, a in enumerate([*Q, *P]):
        for j, b in enumerate([*Q, *P]):
            expected = 1 if j == i + 2 else -1 if i == j + 2 else 0
            assert abs(sp.N(bracket(a, b, pairs).subs(at), 40) - expected) < 1e-30
    slopes = sp.Matrix(Q).jacobian([p1, p2]).subs(at)
    assert abs(sp.N(slopes.det(), 40)) < 1e-35
    assert abs(sp.N(slopes[0, 0], 20)) > 0.1


def test_p6_12_a_rotation_and_then_a_translation() -> None:
    """F2 = Σ (P_i − d_i) a_ij q_j + Σ c_i P_i: Q = A q + c, p = Aᵀ (P − d)."""
    found = proved(
        generating={"F2": "(P1 - d1)*(q1*cos(w) + q2*sin(w)) + (P2 - d2)*(q2*cos(w) - q1*sin(w)) + c1*P1 + c2*P2"},
        coordinates={"q1": "p1", "q2": "p2"}, parameters="w, c1, c2, d1, d2",
    )  # fmt: skip
    s = {str(x): x for f in found.map.values() for x in f.free_symbols}
    rotated = {"Q1": s["q1"] * sp.cos(s["w"]) + s["q2"] * sp.sin(s["w"]) + s["c1"],
               "Q2": s["q2"] * sp.cos(s["w"]) - s["q1"] * sp.sin(s["w"]) + s["c2"],
               "P1": s["p1"] * sp.cos(s["w"]) + s["p2"] * sp.sin(s["w"]) + s["d1"],
               "P2": s["p2"] * sp.cos(s["w"]) - s["p1"] * sp.sin(s["w"]) + s["d2"]}  # fmt: skip
    assert {n: sp.simplify(f - rotated[n]) for n, f in found.map.items()} == dict.fromkeys(rotated, 0)


def test_p6_13_the_drifting_gauge_removes_the_linear_term() -> None:
    """H = p²/2m − p t + k q²/2 (T = ½ m (q̇ + t)²): P = p − m t gives K = P²/2m + k q²/2 + m q up to f(t)."""
    found = proved(map={"Q": "q", "P": "p - m*t"}, parameters={"m": "0 < m", "k": "0 < k"},
                   hamiltonian="p**2/(2*m) - p*t + k*q**2/2")  # fmt: skip
    s = {str(x): x for x in found.hamiltonian.free_symbols} | {str(x): x for x in found.map["P"].free_symbols}
    P = s["p"] - s["m"] * s["t"]
    rest = sp.expand(found.hamiltonian - (P**2 / (2 * s["m"]) + s["k"] * s["q"] ** 2 / 2 + s["m"] * s["q"]))
    assert not rest.free_symbols & {s["q"], s["p"]}


@pytest.mark.parametrize("entry", ["kepler-planar", "lagrange-top", "pendulum-on-block"])
def test_p6_15_the_flow_of_hamiltons_equations_has_no_divergence(entry: str) -> None:
    """Σ ∂q̇/∂q + ∂ṗ/∂p = 0: 1 is a multiplier of Jacobi (6-387), and Liouville's theorem follows."""
    system = hjsolve.catalog.load(entry)
    rates = {name: equation.rhs for name, equation in system.canonical_equations.items()}
    divergence = sp.Add(
        *(sp.diff(rates[c.name], c.symbol) + sp.diff(rates[c.momentum.name], c.momentum) for c in system.coordinates)
    )
    assert sp.simplify(divergence) == 0


@pytest.mark.nightly
def test_p6_16_the_symmetry_relations_of_a_canonical_map() -> None:
    """(6-224), (6-225): ∂q/∂Q = ∂P/∂p, ∂q/∂P = −∂Q/∂p, ∂p/∂Q = −∂P/∂q, ∂p/∂P = ∂Q/∂q; a map of valence 2 breaks them."""
    found = proved(map={"Q": "sqrt(2*q)*cos(p)", "P": "sqrt(2*q)*sin(p)"}, domains={"q": "0 < q", "p": QUARTER})
    M = sp.Matrix(found.jacobian)
    inverse = sp.simplify(M.inv())
    (Qq, Qp), (Pq, Pp) = M.row(0), M.row(1)
    assert sp.simplify(inverse - sp.Matrix([[Pp, -Qp], [-Pq, Qq]])) == sp.zeros(2)
    scaled = sp.Matrix(proved(map={"Q": "2*q", "P": "p"}).jacobian)
    assert scaled.inv()[0, 0] != scaled[1, 1]


@pytest.mark.nightly
def test_p6_17_a_loop_integral_of_q_dp_is_kept_by_the_motion() -> None:
    """∮ q dp round a loop of 48 pendulums and round its image at t = 2: midpoint rule of a periodic analytic function."""
    solution = hjsolve.solve("pendulum")
    turns = 2 * np.pi * np.arange(48) / 48
    begin = np.array([[0.9 + 0.2 * np.cos(u), 0.1 + 0.3 * np.sin(u)] for u in turns])
    moved = []
    for q, p in begin:
        state = solution.motion(q={"theta": float(q)}, p={"theta": float(p)}).at(2)
        moved.append([state.q["theta"], state.p["theta"]])

    def loop(points: np.ndarray) -> float:
        waves = np.fft.rfft(points[:, 1])
        slope = np.fft.irfft(1j * np.arange(25) * waves, 48)  # dp/du
        return float(np.sum(points[:, 0] * slope) * 2 * np.pi / 48)

    before, after = loop(begin), loop(np.array(moved))
    assert abs(before - np.pi * 0.06) < 1e-14
    assert abs(after - before) < 1e-10


def test_sympy_is_ended_in_time_and_a_timer_that_runs_is_put_back() -> None:
    def forever() -> int:
        total = 0
        while True:
            total += 1

    assert in_time(0.2, forever) is None
    assert in_time(5.0, lambda: 3) == 3
    assert in_time(1.0, lambda: in_time(0.1, forever)) is None
    assert in_time(0.2, lambda: in_time(60.0, forever)) is None
