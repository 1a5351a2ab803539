"""Linear gyroscopic systems (Ex 3-4, P3-10, P3-11): exponents, ratios, stability, and the symplectic normal form."""

from __future__ import annotations

from typing import Any

import mpmath
import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve import catalog
from hjsolve.errors import InvalidInputError, InvalidSystemError, MissingValueError
from hjsolve.extended.gyroscopic import LAMBDA, gyroscopic_modes
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.separation import Obstruction, separate
from tests.reference.taylor import Flow
from tests.support import entries

CASES: dict[int, dict[str, Any]] = {
    1: {"gamma": 1, "k11": 1, "k12": -1, "k22": 8}, 2: {"gamma": 7, "k11": -1, "k12": 1, "k22": -8},
    3: {"gamma": 7, "k11": -1, "k12": 1, "k22": 8},
}  # fmt: skip


def close(a: Any, b: complex, digits: int) -> bool:
    """Equal to the digits that the book prints."""
    return abs(complex(a) - b) <= 1.01 * 10.0**-digits


def test_neither_separates_in_its_own_coordinates() -> None:
    for name in ("gyroscopic-pair", "gyroscopic-three"):
        verdict = separate(catalog.load(name))
        assert isinstance(verdict, Obstruction)
        expected = entries.described(name).expect
        assert (list(verdict.pair), verdict.part) == (expected["pair"], expected["part"])


def test_the_exponents_and_amplitude_ratios_of_example_3_4() -> None:
    system = catalog.load("gyroscopic-pair")
    for case, roots, ratios, signs in (
        (1, (0.583, 1.716), (0.202 + 0.0877j, -1.043 - 0.453j), (1, 1)),
        (2, (0.529, 1.891), (0.0790 - 0.406j, -0.1155 - 0.594j), (-1, 1)),
    ):
        modes = gyroscopic_modes(system, parameters=CASES[case], digits=20)
        assert modes.stable
        assert modes.signs == signs
        for k in (0, 1):
            assert close(modes.exponents[2 * k], 1j * roots[k], 3)
            assert close(modes.ratios[2 * k]["q2"], ratios[k], 3)
            assert close(modes.frequencies[k], roots[k], 3)


def test_case_three_is_unstable_for_every_gamma() -> None:
    """7λ⁴ + (10 + γ²)λ² − 9 = 0."""
    system = catalog.load("gyroscopic-pair")
    modes = gyroscopic_modes(system, parameters=CASES[3])
    γ = system.symbols["gamma"]
    case = {system.symbols[n]: v for n, v in CASES[3].items() if n != "gamma"}
    assert sp.expand(modes.polynomial.subs(case) - (7 * LAMBDA**4 + (10 + γ**2) * LAMBDA**2 - 9)) == 0
    for value in (0, 1, 100):
        assert not gyroscopic_modes(system, parameters={**CASES[3], "gamma": value}).stable
    assert modes.motion(q={"q1": 1, "q2": 0}, velocity={"q1": 0, "q2": 0}).kinds == {"q1": "escape", "q2": "escape"}


@pytest.mark.parametrize(("gamma", "stable"), [("5.9999", False), ("6.0001", True), ("-6.0001", True), (0, False)])
def test_case_two_is_stabilised_beyond_gamma_six(gamma: Any, stable: bool) -> None:
    assert gyroscopic_modes(catalog.load("gyroscopic-pair"), parameters={**CASES[2], "gamma": gamma}).stable == stable


def test_three_coordinates_have_the_books_exponents() -> None:
    """P3-10: γ² = 5mk gives λ² = −k/2m, −3k/2m, −3k/m; stable from γ² = 4.490 mk on (P3-11)."""
    system = catalog.load("gyroscopic-three")
    modes = gyroscopic_modes(system, parameters={"m": 2, "k": 3, "gamma": "sqrt(30)"}, digits=30)
    with mp.workdps(40):
        squares = [λ**2 for λ in modes.exponents[::2]]
        for found, expected in zip(squares, (mpf(-3) / 4, mpf(-9) / 4, mpf(-9) / 2), strict=True):
            assert abs(found - expected) < mpf(10) ** -28
    assert gyroscopic_modes(system, parameters={"gamma": "sqrt(4.4901)"}).stable
    assert not gyroscopic_modes(system, parameters={"gamma": "sqrt(4.4900)"}).stable


@pytest.mark.parametrize(("name", "given"), [("gyroscopic-pair", CASES[1]), ("gyroscopic-pair", CASES[2]),
                                             ("gyroscopic-three", {})])  # fmt: skip
def test_the_map_is_symplectic_and_h_becomes_a_sum_of_oscillators(name: str, given: dict[str, Any]) -> None:
    """(6-334): NᵀJN = J; and NᵀSN = diag(σω, σω)."""
    system = catalog.load(name)
    modes, n = gyroscopic_modes(system, parameters=given, digits=30), len(system.coordinates)
    with mp.workdps(40):
        J = mp.matrix(2 * n)
        for i in range(n):
            J[i, n + i], J[n + i, i] = 1, -1
        N = mp.matrix(modes.matrix.tolist())
        assert mp.norm(N.T * J * N - J, mp.inf) < mpf(10) ** -28
        z = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
        S = mp.matrix(sp.hessian(sp.expand(hamiltonian(system)), z).subs(modes.values).evalf(45).tolist())
        D = N.T * S * N
        for i in range(n):
            for k in (i, n + i):
                D[k, k] -= modes.signs[i] * modes.frequencies[i]
        assert mp.norm(D, mp.inf) < mpf(10) ** -28


@pytest.mark.parametrize(("name", "given"), [("gyroscopic-pair", CASES[2]), ("gyroscopic-three", {})])
def test_the_motion_is_that_of_a_taylor_integration(name: str, given: dict[str, Any]) -> None:
    entry = entries.described(name)
    system, start = entry.system, entry.initial
    moved = gyroscopic_modes(system, parameters=given, digits=25).motion(q=start.q, velocity=start.velocity)
    with mp.workdps(50):
        values = {s: mpf(sp.N(v, 50)) for s, v in moved.modes.values.items()}
        q, p = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
        places = {c.symbol: sp.Rational(str(start.q[c.name])) for c in system.coordinates}
        speeds = {c.velocity: sp.Rational(str(start.velocity[c.name])) for c in system.coordinates}
        momenta = [sp.diff(system.kinetic, c.velocity).subs({**places, **speeds, **moved.modes.values})
                   for c in system.coordinates]  # fmt: skip
        begin = [mpf(sp.N(x, 50)) for x in (*places.values(), *momenta)]
        flow = Flow(hamiltonian(system), q, p, values, begin, digits=30)
        for t in ("0", "1.5", "6"):
            expected, state = flow.at(mpf(t)), moved.at(t)
            rates = [sp.diff(hamiltonian(system), c.momentum).subs(moved.modes.values) for c in system.coordinates]
            speeds = [sp.lambdify([*q, *p], rate, "mpmath")(*expected) for rate in rates]
            found = [*state.q.values(), *state.p.values(), *state.velocity.values()]
            errors = [*state.error.q.values(), *state.error.p.values(), *state.error.velocity.values()]
            for value, error, reference in zip(found, errors, [*expected, *speeds], strict=True):
                assert abs(mp.mpf(value) - reference) <= error < mpf(10) ** -20
        several = moved.at([0.0, 1.5])
        assert [abs(several.q[name][1] - moved.at("1.5").q[name]) < mpf(10) ** -22 for name in several.q]


def test_a_system_that_is_not_linear_is_refused() -> None:
    with pytest.raises(InvalidSystemError, match="constant masses and linear terms bilinear"):
        gyroscopic_modes(catalog.load("pendulum"))


def test_a_constant_force_moves_the_equilibrium() -> None:
    """ẍ = −2 x − 1 from rest at 0: x = (cos √2 t − 1)/2."""
    modes = gyroscopic_modes(System({"x": "line"}, "dot(x)**2/2", "x**2 + x"))
    motion = modes.motion(q={"x": 0}, velocity={"x": 0})
    state = motion.at("1.5")
    with mp.workdps(40):
        assert abs(state.q["x"] - (mp.cos(mp.sqrt(2) * mpf("1.5")) - 1) / 2) <= state.error.q["x"] < mpf(10) ** -29
    assert motion.kinds == {"Q1": "libration"}


def test_without_gyroscopic_terms_the_modes_are_the_usual_ones() -> None:
    modes = gyroscopic_modes(System({"x": "line", "y": "line"}, "dot(x)**2/2 + dot(y)**2/2", "x**2 + y**2 - x*y"))
    assert modes.signs == (1, 1)
    assert abs(modes.frequencies[0] - 1) < mpmath.mpf(10) ** -29
    assert abs(modes.frequencies[1] ** 2 - 3) < mpmath.mpf(10) ** -28


def test_initial_data_are_checked_as_those_of_any_motion() -> None:
    modes = gyroscopic_modes("gyroscopic-three")
    names = [c.name for c in modes.system.coordinates]
    rest = dict.fromkeys(names, 0)
    with pytest.raises(InvalidInputError, match="either velocity"):
        modes.motion(q=rest)
    with pytest.raises(MissingValueError, match=f"velocity: no value for {names[-1]}"):
        modes.motion(q=rest, velocity=dict.fromkeys(names[:-1], 0))
    with pytest.raises(InvalidInputError, match="'height' is not a coordinate"):
        modes.motion(q={**rest, "height": 1}, p=rest)


def test_a_penning_trap_has_its_modes_although_z_is_decoupled() -> None:
    """ω = ω_c/2 ± √(ω_c²/4 − ω_z²/2) and ω_z, in closed form."""
    trap = System(
        {"x": "line", "y": "line", "z": "line"},
        "(dot(x)**2+dot(y)**2+dot(z)**2)/2+wc/2*(x*dot(y)-y*dot(x))",
        "wz**2/4*(2*z**2-x**2-y**2)",
        parameters={"wc": 10, "wz": 1},
    )
    modes = gyroscopic_modes(trap)
    with mp.workdps(40):
        root = mp.sqrt(mpf(25) - mpf(1) / 2)
        for ω, expected in zip(modes.frequencies, (5 - root, mpf(1), 5 + root), strict=True):
            assert abs(ω - expected) < mpf(10) ** -30
        z = modes.motion(q={"x": 1, "y": 0, "z": 1}, velocity={"x": 0, "y": 0, "z": 0}).at(1).q["z"]
        assert abs(z - mp.cos(1)) < mpf(10) ** -29


def test_two_oscillators_that_are_not_coupled_are_their_own_modes() -> None:
    pair = System({"x": "line", "y": "line"}, "(dot(x)**2+dot(y)**2)/2", "x**2/2 + 3*y**2/2")
    with mp.workdps(40):
        for ω, expected in zip(gyroscopic_modes(pair).frequencies, (mpf(1), mp.sqrt(3)), strict=True):
            assert abs(ω - expected) < mpf(10) ** -30
