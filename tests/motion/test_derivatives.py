"""Derivatives of numbers of a motion, against closed forms and differences of motions of many digits."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve import System
from hjsolve.errors import InvalidInputError

many = mpmath.mp.clone()
many.dps = 50
ALL = {"actions", "frequencies", "periods", "turning_points", "angles", "constants", "state"}


@pytest.fixture(scope="module")
def kepler():
    return hjsolve.solve(hjsolve.catalog.load("kepler-planar"))


@pytest.fixture(scope="module")
def pendulum():
    return hjsolve.solve(System({"theta": "angle"}, "dot(theta)**2/2", "-cos(theta)"))


def within(found, error, truth):
    """Whether a number is as near to the truth as is claimed, and the claim is not idle."""
    true = abs(many.convert(found) - truth)
    return true <= error and error <= 1e-14 * (1 + abs(truth))


def differences(solution, motion, group, name, read, digits=42, step=15):
    """(f(h) − f(−h))/2h of everything that ``read`` gives of a motion with one number moved."""
    initial, system, found = motion.initial.values, solution.system, []
    for sign in (1, -1):
        base = {
            "q": {c.name: initial[c.symbol] for c in system.coordinates},
            "p": {c.name: initial[c.momentum] for c in system.coordinates},
            "parameters": {p.name: initial[p.symbol] for p in system.parameters},
        }
        base[group][name] = base[group][name] + sign * sp.Rational(1, 10**step)
        found.append(read(solution.motion(**base, digits=digits)))
    return {
        key: (many.convert(found[0][key]) - many.convert(found[1][key])) / 2 * many.mpf(10) ** step for key in found[0]
    }


def everything(motion, t):
    """Numbers of a motion by quantity and name; angles without their turns."""
    state = motion.at(t)
    found = {("q", n): state.unwrapped(n) for n in state.q} | {("p", n): p for n, p in state.p.items()}
    for quantity in ("actions", "frequencies", "periods", "constants"):
        found |= {(quantity, n): e.value for n, e in getattr(motion, quantity).items()}
    for n, ends in motion.turning_points.items():
        found |= {("turning_points", n, k): e.value for k, e in enumerate(ends) if e is not None}
    return found | {("angles", n): x for n, x in motion.angles(t).items()}


def test_kepler_in_closed_form(kepler):
    """J_r = k √(m/(−2E)) − |p_θ|, Ω = (−2E)^(3/2)/(k √m)."""
    E, L, m, k = sp.symbols("E p_theta m k")
    J, Ω = k * sp.sqrt(-m / (2 * E)) - L, (-2 * E) ** sp.Rational(3, 2) / (k * sp.sqrt(m))
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
    at = {E: sp.Rational(-7, 25), L: sp.Rational(6, 5), m: 1, k: 1}
    d = motion.derivatives({"actions", "frequencies"}, {"constants", "actions"})
    for z in (E, L):
        for quantity, name, formula in (("actions", "r", J), ("frequencies", "r", Ω), ("frequencies", "theta", Ω)):
            truth = many.convert(sp.N(sp.diff(formula, z).subs(at), 40))
            assert within(d.value[quantity][name][z.name], d.error[quantity][name][z.name], truth)
    hessian = many.convert(sp.N((-3 * Ω / (J + L)).subs(at), 40))  # E = −m k²/2 (J_r + J_θ)², Ω = m k²/(J_r + J_θ)³
    for one in ("r", "theta"):
        for other in ("J.r", "J.theta"):
            assert within(d.value["frequencies"][one][other], d.error["frequencies"][one][other], hessian)


@pytest.mark.parametrize(
    "group", [pytest.param("q", marks=pytest.mark.nightly), pytest.param("p", marks=pytest.mark.nightly), "parameters"]
)
def test_kepler_by_differences(kepler, group):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": "0.3", "theta": "1.2"})
    d = motion.derivatives(ALL, {"initial", "parameters"}, t="37.5")
    for name in ("r", "theta") if group != "parameters" else ("m", "k"):
        variable = name if group == "parameters" else f"{group}.{name}"
        for key, truth in differences(kepler, motion, group, name, lambda m: everything(m, "37.5")).items():
            value, error = (table[key[0]][key[1]][variable] for table in (d.value, d.error))
            value, error = (value[key[2]], error[key[2]]) if len(key) == 3 else (value, error)
            assert abs(many.convert(value) - truth) <= error + 1e-22, key


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "t"),
    [("spherical-pendulum", "25"), ("kepler-spherical", "12.5"), ("lagrange-top", "12.5"), ("kuzmin-kutuzov", "12.5"),
     ("two-centres-plane", "12.5"), ("crossed-fields", "12.5"), ("charge-in-monopole-field", "12.5"),
     ("calogero-moser", "12.5"), ("kerr", "150"), ("stark", "12.5")],
)  # fmt: skip
def test_catalog_by_differences(name, t):
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    motion = solution.motion(**hjsolve.catalog.describe(name).initial.arguments)
    d = motion.derivatives(ALL, {"initial", "parameters"}, t=t)
    variables = [(g, c.name) for g in ("q", "p") for c in solution.system.coordinates]
    variables += [("parameters", p.name) for p in solution.system.parameters]
    for group, own in variables:
        variable = own if group == "parameters" else f"{group}.{own}"
        for key, truth in differences(solution, motion, group, own, lambda m: _known(m, t)).items():
            if key[0] == "angles":
                continue
            value, error = (table[key[0]][key[1]][variable] for table in (d.value, d.error))
            value, error = (value[key[2]], error[key[2]]) if len(key) == 3 else (value, error)
            assert abs(many.convert(value) - truth) <= error + 1e-20, (key, variable)


def _known(motion, t):
    try:
        return everything(motion, t)
    except InvalidInputError:  # an open motion has no angles
        state = motion.at(t)
        return {("q", n): state.unwrapped(n) for n in state.q} | {("p", n): p for n, p in state.p.items()}


def test_angles_by_differences_where_the_barrier_moves():
    """Angles of a rotation are counted from opposite the barrier, which moves with the parameter b."""
    system = System({"x": "angle"}, "dot(x)**2/2", "-cos(x) - b*sin(x)", {"b": "0.3"})
    solution = hjsolve.solve(system)
    motion = solution.motion(q={"x": "0.5"}, velocity={"x": "-2.9"})
    d = motion.derivatives({"angles"}, {"initial", "parameters"}, t=3)
    assert motion.kinds["x"] == "rotation"
    for group, name, variable in (("q", "x", "q.x"), ("p", "x", "p.x"), ("parameters", "b", "b")):
        truth = differences(solution, motion, group, name, lambda m: {"x": m.angles(3)["x"]})["x"]
        assert within(d.value["angles"]["x"][variable], d.error["angles"]["x"][variable], truth), variable


def test_hessian_of_the_pendulum_from_rest_to_rotation(pendulum):
    """Ω = 1 − J/8 + O(J²) at rest; Ω = π/(2K((E + 1)/2)) in a libration, and dΩ/dJ = Ω dΩ/dE."""
    rest = pendulum.motion(q={"theta": 0}, velocity={"theta": 0})
    d = rest.derivatives({"frequencies"}, {"actions"})
    assert within(
        d.value["frequencies"]["theta"]["J.theta"], d.error["frequencies"]["theta"]["J.theta"], many.mpf(-1) / 8
    )
    libration = pendulum.motion(q={"theta": "0.5"}, velocity={"theta": "0.3"})
    d = libration.derivatives({"frequencies"}, {"constants", "actions"})
    E = many.mpf("0.045") - many.cos(many.mpf("0.5"))

    def Ω(energy):
        return many.pi / (2 * many.ellipk((energy + 1) / 2))

    slope = many.diff(Ω, E)
    assert within(d.value["frequencies"]["theta"]["E"], d.error["frequencies"]["theta"]["E"], slope)
    assert within(d.value["frequencies"]["theta"]["J.theta"], d.error["frequencies"]["theta"]["J.theta"], slope * Ω(E))


def test_sign_of_a_backward_rotation(pendulum):
    forward, backward = (
        pendulum.motion(q={"theta": "0.5"}, velocity={"theta": v}).derivatives(
            {"actions", "frequencies"}, {"constants"}
        )
        for v in ("2.9", "-2.9")
    )
    for quantity in ("actions", "frequencies"):
        one, other = (d.value[quantity]["theta"]["E"] for d in (forward, backward))
        assert one == pytest.approx(-other, rel=1e-15, abs=0)
        assert one > 0


@pytest.mark.parametrize(("p", "digits"), [("2.08", 30), ("1.69", 15), ("-1.6735", 15)])
def test_a_rotation_over_its_elliptic_map_beside_another_coordinate(p, digits):
    """p/(dq/dχ) and dt/dχ are constant over the map of a pendulum: they do not tell how many nodes their slopes take."""
    system = System({"x": "line", "y": "angle"}, "(dot(x)**2 + dot(y)**2)/2", "x**2/2 + 7/10*(1 - cos(y))")
    motion = hjsolve.solve(system).motion(q={"x": 1, "y": 0}, p={"x": 0, "y": p}, digits=digits)
    d = motion.derivatives({"frequencies"}, {"constants"})

    def Ω(α):
        # ∮ dy/√(2α − 4 g sin²(y/2)) = 4 K(2g/α)/√(2α)
        return many.pi * many.sqrt(2 * α) / (2 * many.ellipk(2 * many.mpf("0.7") / α))

    slope = many.diff(Ω, many.mpf(p) ** 2 / 2) * many.sign(many.mpf(p))
    assert within(d.value["frequencies"]["y"]["alpha_2"], d.error["frequencies"]["y"]["alpha_2"], slope)


def test_a_rotation_along_a_line_whose_period_is_a_parameter():
    """V = −cos(κx): J = (1/2π) ∮ p dx over 2π/κ goes like 1/κ at fixed E."""
    system = System({"x": "line"}, "dot(x)**2/2", "-cos(kappa*x)", {"kappa": "1.5"})
    solution = hjsolve.solve(system)
    motion = solution.motion(q={"x": "0.4"}, velocity={"x": "2.7"})
    d = motion.derivatives({"actions", "frequencies", "state"}, {"initial", "parameters"}, t="7.5")

    def read(m):
        state = m.at("7.5")
        return {("q", "x"): state.q["x"], ("p", "x"): state.p["x"], ("actions", "x"): m.actions["x"].value,
                ("frequencies", "x"): m.frequencies["x"].value}  # fmt: skip

    for group, name, variable in (("q", "x", "q.x"), ("parameters", "kappa", "kappa")):
        for key, truth in differences(solution, motion, group, name, read).items():
            assert within(d.value[key[0]]["x"][variable], d.error[key[0]]["x"][variable], truth), (key, variable)


def test_where_a_coordinate_is_at_rest_the_status_names_the_regular_variables(kepler):
    circle = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": 1})
    d = circle.derivatives({"turning_points", "angles", "frequencies", "state"}, {"initial", "constants"}, t=1)
    assert d.status["turning_points"]["r"] == "square_root"
    assert d.status["angles"]["r"] == "square_root" or d.status["angles"]["r"] == "dependent_constants"
    assert d.status["q"]["r"] == "dependent_constants"
    assert d.status["frequencies"]["r"] == "ok"
    assert any("√J" in remark and "regular" in remark for remark in d.remarks)
    assert d.value["frequencies"]["r"]["E"] == pytest.approx(-3, rel=1e-14, abs=0)


def test_errors_say_what_to_write(kepler):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
    with pytest.raises(InvalidInputError, match='of: "energies" is not known; known are actions'):
        motion.derivatives({"energies"})
    with pytest.raises(InvalidInputError, match='by: "masses" is not known'):
        motion.derivatives({"actions"}, {"masses"})
    with pytest.raises(InvalidInputError, match=r'write by=\{"initial"\}'):
        motion.derivatives({"state"}, {"actions"})


def test_thirty_digits(kepler):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}, digits=30)
    d = motion.derivatives({"frequencies"}, {"constants"})
    truth = -3 * many.sqrt(many.mpf(14) / 25)  # dΩ/dE = −3 √(−2E)
    value, error = (table["frequencies"]["r"]["E"] for table in (d.value, d.error))
    assert abs(many.convert(value) - truth) <= error <= 1e-29


def test_even_motion_by_its_parameters():
    """x = x₀ + p t/m: ∂x/∂m = −p t/m²."""
    solution = hjsolve.solve(System({"x": "line"}, "m*dot(x)**2/2", "0", {"m": 4}))
    motion = solution.motion(q={"x": 0}, velocity={"x": 3})
    d = motion.derivatives({"state"}, {"initial", "parameters"}, t=6)
    assert d.value["q"]["x"]["m"] == -4.5
    assert d.value["q"]["x"]["p.x"] == 1.5
    with pytest.raises(InvalidInputError, match=r'of=\{"state"\}'):
        motion.derivatives({"actions"})
