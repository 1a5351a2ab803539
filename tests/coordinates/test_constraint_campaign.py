"""Constraints typed by the user: motions against an ODE with multipliers, and what is not integrable is refused."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import hjsolve
from hjsolve.errors import InvalidSystemError

NAMES = ("x", "y", "z")
T3 = "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"
BOWL = "x**2/2 + y**2 + 3*z**2/2"


@dataclass(frozen=True)
class Case:
    """A constraint of a particle, the coefficients a(q) of its velocities, V, and where the free coordinates start."""

    constraint: str
    rows: tuple[str, str, str]
    potential: str
    q: dict[str, str]
    velocity: dict[str, str]
    constant: str = ""


XY, VXY = {"x": "0.3", "y": "-0.2"}, {"x": "0.4", "y": "0.7"}
XZ, VXZ = {"x": "0.3", "z": "-0.2"}, {"x": "0.4", "z": "0.7"}
BALL, VBALL = {"theta": "1.1", "phi": "0.2"}, {"theta": "0.3", "phi": "0.9"}
INTEGRABLE = {
    "plane": Case("z = x + 2*y", ("1", "2", "-1"), BOWL, XY, VXY),
    "plane under gravity": Case("z = x - y", ("1", "-1", "-1"), "z", XY, VXY),
    "slope": Case("2*z = 3*x + 1", ("3", "0", "-2"), "z + y**2/2", XY, VXY),
    "plane through a spring": Case("z = y", ("0", "1", "-1"), BOWL, XY, VXY),
    "shifted plane": Case("x + y + z = 2", ("1", "1", "1"), BOWL, XY, VXY),
    "velocities of a plane": Case("dot(z) = dot(x) + dot(y)", ("1", "1", "-1"), BOWL, XY, VXY, "0.5"),
    "velocities under gravity": Case("dot(x) - dot(y) + dot(z) = 0", ("1", "-1", "1"), "z", XY, VXY, "0"),
    "velocities, one of them absent": Case("2*dot(z) - dot(y) = 0", ("0", "-1", "2"), BOWL, XZ, VXZ, "0"),
    "parabolic channel": Case("z = x**2/2", ("x", "0", "-1"), "y**2/2 + z", XY, VXY),
    "cubic channel": Case("z = y**3", ("0", "3*y**2", "-1"), "x**2/2 + z + y**2", XY, VXY),
    "paraboloid's generator": Case("dot(z) = x*dot(x)", ("x", "0", "-1"), "y**2/2 + z", XY, VXY, "0"),
    "sphere": Case("x**2 + y**2 + z**2 = 4", ("x", "y", "z"), "z", BALL, VBALL),
}
REFUSED = (
    "dot(z) = y*dot(x)", "dot(z) = x*dot(y)", "dot(z) = x*dot(y) - y*dot(x)", "dot(x)*cos(z) + dot(y)*sin(z) = 0",
    "x*dot(y) + z*dot(x) = 0", "dot(y) - z**2*dot(x) = 0", "exp(x)*dot(y) + dot(z) = 0", "dot(x) + x*y*dot(z) = 0",
)  # fmt: skip


def _multipliers(case: Case, start: np.ndarray, times: list[float]) -> np.ndarray:
    """Integrate q'' = -grad V + a lambda, with lambda from a.q'' + (da/dt).q' = 0."""
    q, v = sp.symbols("x y z"), sp.symbols("vx vy vz")
    names = dict(zip(NAMES, q, strict=True))
    a = sp.Matrix([sp.sympify(row, locals=names) for row in case.rows])
    force = -sp.Matrix([sp.diff(sp.sympify(case.potential, locals=names), s) for s in q])
    turning = (a.jacobian(q) * sp.Matrix(v)).dot(sp.Matrix(v))
    multiplier = -(a.dot(force) + turning) / a.dot(a)
    rhs = sp.lambdify([(*q, *v)], [*v, *(force + a * multiplier)])
    found = solve_ivp(lambda _, y: rhs(y), (0, times[-1]), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times)
    return found.y[:3]


def _check(case: Case) -> None:
    system = hjsolve.System(dict.fromkeys(NAMES, "line"), T3, case.potential, constraints=[case.constraint])
    values = {"c_1": case.constant} if case.constant else {}
    left = [c.name for c in system.coordinates]
    q, velocity = ({n: given[n] for n in left if n in given} for given in (case.q, case.velocity))
    assert {*q} == {*left}, left
    motion = hjsolve.solve(system, coordinates="find").motion(q=q, velocity=velocity, parameters=values)
    gone = dict(system.eliminated)
    place = [sp.sympify(gone.get(n, sp.Symbol(n))) for n in NAMES]
    plain = [sp.sympify(str(e)).subs({sp.Symbol(k): sp.Rational(v) for k, v in values.items()}) for e in place]
    free = [sp.Symbol(n) for n in left]
    where = sp.lambdify([free], plain)
    speed = sp.lambdify([free], sp.Matrix(plain).jacobian(free))
    q0, v0 = [float(q[n]) for n in left], [float(velocity[n]) for n in left]
    start = np.array([*where(q0), *(np.array(speed(q0), dtype=float) @ v0)], dtype=float)
    times = [0.5, 1.0, 2.0]
    truth = _multipliers(case, start, times)
    for k, t in enumerate(times):
        state = motion.at(t)
        apart = where([float(state.q[n]) for n in left]) - truth[:, k]
        assert np.linalg.norm(apart) <= 1e-10 * np.linalg.norm(truth[:, k])


QUICK = ("plane under gravity",)


@pytest.mark.nightly_cases(*[name for name in INTEGRABLE if name not in QUICK])
@pytest.mark.parametrize("name", INTEGRABLE)
def test_the_motion_is_that_of_an_ode_with_multipliers(name: str) -> None:
    _check(INTEGRABLE[name])


@pytest.mark.parametrize("constraint", REFUSED)
def test_what_is_not_integrable_is_refused_with_the_equations_to_use(constraint: str) -> None:
    with pytest.raises(InvalidSystemError, match="not integrable") as caught:
        hjsolve.System(dict.fromkeys(NAMES, "line"), T3, 0, constraints=[constraint])
    assert "(5-22)" in str(caught.value)
    assert "(5-25)" in str(caught.value)
