"""H from T by Legendre's transformation, and what else a system knows of itself."""

from __future__ import annotations

import random

import pytest
import sympy as sp

from hjsolve.mechanics.system import (
    System,
    hamiltonian,
    inverse_mass_matrix,
    kinetic_rest,
    linear_terms,
    mass_matrix,
    momenta,
    velocities,
)
from tests.support.plain_systems import TOP, kepler, positive

SYSTEMS = {
    "kepler": kepler(),
    "top": System({"psi": "angle", "theta": "-pi/2 < theta < pi/2", "phi": "angle"}, TOP, "0", positive("I_a I_t")),
    "double pendulum": System(
        {"a": "angle", "b": "angle"},
        "m1/2*l1**2*dot(a)**2 + m2/2*(l1**2*dot(a)**2 + l2**2*dot(b)**2 + 2*l1*l2*dot(a)*dot(b)*cos(a - b))",
        "-(m1 + m2)*g*l1*cos(a) - m2*g*l2*cos(b)",
        {"m1": 1, "m2": 2, "l1": 3, "l2": 4, "g": 10},
    ),
    "double pendulum in its Cartesian velocities": System(
        {"a": "angle", "b": "angle"},
        "m/2*dot(a)**2 + m/2*(dot(a)*cos(a) + dot(b)*cos(b))**2 + m/2*(dot(a)*sin(a) + dot(b)*sin(b))**2",
        "0",
        {"m": "1/3"},
    ),
    "charge in a field": System(
        {"x": "line", "y": "line", "z": "line"},
        "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2) + B/2*(x*dot(y) - y*dot(x))",
        "k*z**2",
        {"m": 1, "B": 3, "k": 1},
    ),
    "bead on a turning wire": System(
        {"theta": "angle"},
        "m*r**2*(w*(dot(theta) + w)*(1 - cos(theta)) + dot(theta)**2/2)",
        "0",
        {"m": 1, "r": 2, "w": 3},
    ),
    "three coupled": System(
        {"x": "line", "y": "line", "z": "line"},
        "m/6*(dot(x)**2 + dot(x)*dot(y) + 2*dot(y)**2 + dot(y)*dot(z) + dot(z)**2)*(1 + x**2)",
        "x*y*z",
        {"m": 1},
    ),
    "light cone": System({"u": "line", "v": "line"}, "dot(u)*dot(v) + u*dot(u)", "u*v", signature="indefinite"),
    "Schwarzschild": System(
        {"t": "line", "r": "2*M < r", "phi": "angle"},
        "-(1 - 2*M/r)/2*dot(t)**2 + dot(r)**2/(2*(1 - 2*M/r)) + r**2/2*dot(phi)**2",
        parameters={"M": 1},
        signature="indefinite",
    ),
}


def random_point(system: System, seed: int) -> dict[sp.Symbol, sp.Rational]:
    source = random.Random(seed)
    symbols = [*(c.symbol for c in system.coordinates), *(c.velocity for c in system.coordinates)]
    place = {symbol: sp.Rational(source.randint(200, 900), 631) for symbol in symbols}
    if "M" in system.symbols:
        place[system.coordinate("r").symbol] += 3
    return {**place, **system.defaults}


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_hamiltonian_is_legendres_transform_of_the_lagrangian(name):
    """H(q, p(q, q̇)) = Σ p q̇ − T + V, and q̇(q, p(q, q̇)) = q̇, at 40 digits."""
    system = SYSTEMS[name]
    for seed in range(4):
        point = random_point(system, seed)
        slopes = {c.momentum: sp.diff(system.kinetic, c.velocity).evalf(50, subs=point) for c in system.coordinates}
        for c in system.coordinates:
            assert abs(momenta(system)[c.name].evalf(50, subs=point) - slopes[c.momentum]) < 1e-45
        energy = sum(slopes[c.momentum] * point[c.velocity] for c in system.coordinates)
        energy += (system.potential - system.kinetic).evalf(50, subs=point)
        assert abs(hamiltonian(system).evalf(40, subs={**point, **slopes}) - energy) < 1e-35
        for c in system.coordinates:
            speed = velocities(system)[c.name].evalf(40, subs={**point, **slopes})
            assert abs(speed - point[c.velocity]) < 1e-35


@pytest.mark.parametrize("name", SYSTEMS)
def test_kinetic_energy_is_its_three_parts(name):
    system = SYSTEMS[name]
    speeds = sp.Matrix([c.velocity for c in system.coordinates])
    whole = (speeds.T * mass_matrix(system) * speeds)[0] / 2 + kinetic_rest(system)
    whole += sum(a * speed for a, speed in zip(linear_terms(system), speeds))
    for seed in range(3):
        assert abs((whole - system.kinetic).evalf(40, subs=random_point(system, seed))) < 1e-35


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_inverse_mass_matrix_is_the_inverse(name):
    system = SYSTEMS[name]
    n = len(system.coordinates)
    product = mass_matrix(system) * inverse_mass_matrix(system) - sp.eye(n)
    for entry in product:
        assert abs(entry.evalf(40, subs=random_point(system, 7))) < 1e-35


READABLE = {
    "kepler": "-k/r + p_r**2/(2*m) + p_theta**2/(2*m*r**2)",
    "top": "p_theta**2/(2*I_t) + (p_phi*sin(theta) + p_psi)**2/(2*I_t*cos(theta)**2) + p_phi**2/(2*I_a)",
    "double pendulum": "-g*l1*(m1 + m2)*cos(a) - g*l2*m2*cos(b) + p_b**2/(2*l2**2*m2) + "
    "(-l1*p_b*cos(a - b)/l2 + p_a)**2/(2*l1**2*(m1 + m2*sin(a - b)**2))",
    "charge in a field": "k*z**2 + p_z**2/(2*m) + (-B*x/2 + p_y)**2/(2*m) + (B*y/2 + p_x)**2/(2*m)",
    "light cone": "p_v*(p_u - u) + u*v",
}


@pytest.mark.parametrize("name", READABLE)
def test_the_hamiltonian_is_readable(name):
    assert str(hamiltonian(SYSTEMS[name])) == READABLE[name]


def test_squares_of_cartesian_velocities_become_angle_differences():
    m, a, b = (SYSTEMS["double pendulum in its Cartesian velocities"].symbols[name] for name in ("m", "a", "b"))
    expected = sp.Matrix([[2 * m, m * sp.cos(a - b)], [m * sp.cos(a - b), m]])
    assert mass_matrix(SYSTEMS["double pendulum in its Cartesian velocities"]) == expected


@pytest.mark.timeout(60)
def test_a_power_that_would_be_slow_to_expand_leaves_the_door():
    system = System(
        {"x": "line", "y": "line"},
        "(1 + (x**2 + y**2)**20)*(dot(x)**2 + dot(y)**2) + (1 + y**2)**30*x**90*dot(x)*dot(y)/10**99/(1+x**2)**99",
    )
    assert hamiltonian(system).free_symbols == {c.symbol for c in system.coordinates} | {
        c.momentum for c in system.coordinates
    }


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_representation_makes_the_system_again(name):
    again = eval(repr(SYSTEMS[name]))
    assert (again.kinetic, again.potential) == tuple(
        part.subs({s: again.symbols[s.name] for s in SYSTEMS[name].symbols.values()})
        for part in (SYSTEMS[name].kinetic, SYSTEMS[name].potential)
    )
    assert [c.domain for c in again.coordinates] == [c.domain for c in SYSTEMS[name].coordinates]
