"""Constraints that last after an impact: against integration with multipliers, closed forms, and the budgets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.errors import CatalogError, InvalidInputError, InvalidSystemError


def lines(*names: str) -> list[dict[str, str]]:
    return [{"name": name, "domain": "line"} for name in names]


ROD = {
    "coordinates": lines("x", "y", "theta"), "kinetic": "m/2*(dot(x)**2 + dot(y)**2) + m*l**2/24*dot(theta)**2",
    "parameters": [{"name": n, "value": v} for n, v in (("m", "1"), ("l", "2"), ("g", "1"))], "potential": "m*g*y",
}  # fmt: skip
BALL = {"coordinates": lines("x", "y"), "kinetic": "(dot(x)**2 + dot(y)**2)/2", "potential": "981/100*y"}
SPRINGS = {**BALL, "potential": "x**2/2 + y**2"}
FALLING = {"q": {"x": "0", "y": "2", "theta": "1/2"}, "velocity": {"x": "1/3", "y": "0", "theta": "1/5"}}
NORMAL, TANGENT = "dot(y) - l/2*cos(theta)*dot(theta) = 0", "dot(x) + l/2*sin(theta)*dot(theta) = 0"
FLOOR = "y - l/2*sin(theta)"
CASES: dict[str, tuple[Any, ...]] = {
    "a rod slides on a floor that it meets obliquely": (ROD, FALLING, {"at": {"surface": FLOOR}}, [NORMAL]),
    "a rod sticks to the floor": (
        ROD, FALLING, {"at": {"surface": FLOOR}, "constraints": [NORMAL, TANGENT]}, [NORMAL, TANGENT]),
    "a string becomes taut": (
        BALL, {"q": {"x": "1/2", "y": "0"}, "velocity": {"x": "1", "y": "0"}}, {"at": {"surface": "x**2 + y**2 - 1"}},
        ["x*dot(x) + y*dot(y) = 0"]),
    "a wall starts and stays": (
        SPRINGS, {"q": {"x": "1/2", "y": "0"}, "velocity": {"x": "0", "y": "1"}},
        {"at": {"t": "1"}, "constraints": ["dot(x) = 1/3"]}, ["dot(x) = 1/3"]),
    "an oblique line in a bowl": (
        SPRINGS, {"q": {"x": "1/2", "y": "0"}, "velocity": {"x": "0", "y": "1"}},
        {"at": {"coordinate": "x", "value": "1/4"}, "constraints": ["dot(x) - 2*dot(y) = 0"]},
        ["dot(x) - 2*dot(y) = 0"]),
}  # fmt: skip


def scene_of(name: str, times: list[str], **changes: Any) -> dict[str, Any]:
    system, initial, event, _ = CASES[name]
    event = {"kind": "impact", "lasts": True, **event}
    return {"system": system, "initial": initial, "want": ["trajectory", "constants"], "times": times,
            "events": [event], **changes}  # fmt: skip


class _Twin:
    """M q'' + a^T lambda = -dV/dq with a q'' + a' q' = 0 after the impact, q' projected at it; all in x, y, theta."""

    def __init__(self, system: dict[str, Any], constraints: list[str]) -> None:
        self.names = [c["name"] for c in system["coordinates"]]
        q = {n: sp.Symbol(n) for n in self.names}
        v = {n: sp.Symbol(f"v_{n}") for n in self.names}
        known = {p["name"]: sp.Rational(p["value"]) for p in system.get("parameters", [])}

        def read(text: str) -> sp.Expr:
            for n in self.names:
                text = text.replace(f"dot({n})", f"v_{n}")
            return sp.sympify(text, locals={**q, **{s.name: s for s in v.values()}, **known})

        Q, U = sp.Matrix(list(q.values())), sp.Matrix(list(v.values()))
        forms = sp.Matrix([read(c.split("=")[0]) - read(c.split("=")[1]) for c in constraints])
        T, V = read(system["kinetic"]), read(system["potential"])
        a = forms.jacobian(U)
        turning = (a * U).jacobian(Q) * U
        self.parts = sp.lambdify(
            [list(Q), list(U)], [sp.hessian(T, list(U)), -sp.Matrix([V]).jacobian(Q).T, a, turning, forms], "numpy"
        )

    def free(self, t: float, y: np.ndarray) -> np.ndarray:
        n = len(self.names)
        M, F, *_ = self.parts(y[:n], y[n:])
        return np.array([*y[n:], *np.linalg.solve(M, F).ravel()])

    def held(self, t: float, y: np.ndarray) -> np.ndarray:
        n = len(self.names)
        M, F, a, turning, _ = self.parts(y[:n], y[n:])
        k = len(a)
        whole = np.block([[M, a.T], [a, np.zeros((k, k))]])
        return np.array([*y[n:], *np.linalg.solve(whole, np.vstack([F, -turning])).ravel()[:n]])

    def hit(self, y: np.ndarray) -> np.ndarray:
        n = len(self.names)
        M, _, a, _, against = self.parts(y[:n], y[n:])
        inverse = np.linalg.inv(M)
        more = inverse @ a.T @ np.linalg.solve(a @ inverse @ a.T, np.asarray(against).reshape(-1, 1))
        return np.array([*y[:n], *(y[n:] - more.ravel())])


@pytest.mark.nightly_cases(*list(CASES)[:2])
@pytest.mark.parametrize("name", CASES)
def test_the_motion_is_that_of_an_integration_with_multipliers(name: str) -> None:
    system, initial, _, constraints = CASES[name]
    run = hjsolve.Scene.load(scene_of(name, ["1/4", "2", "5/2"])).run()
    (budget,) = run.impacts
    twin, names = _Twin(system, constraints), [c["name"] for c in system["coordinates"]]
    y = np.array([float(sp.Rational(initial[g][n])) for g in ("q", "velocity") for n in names])
    settings = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    first = solve_ivp(twin.free, (0, float(budget.time)), y, t_eval=[0.25, float(budget.time)], **settings).y
    second = solve_ivp(twin.held, (float(budget.time), 2.5), twin.hit(first[:, 1]), t_eval=[2.0, 2.5], **settings).y
    expected = np.column_stack([first[:, 0], second])
    path = run.trajectory
    for i, n in enumerate(names):
        for found, truth, error in ((path.q[n], expected[i], path.error.q[n]),
                                    (path.velocity[n], expected[len(names) + i], path.error.velocity[n])):  # fmt: skip
            assert np.abs(found - truth).max() < 2e-11
            assert 0 <= error.max() < 1e-12
    assert list(path.arc) == [0, 1, 1]
    for n in names:
        assert abs(float(budget.velocity[n]) - twin.hit(first[:, 1])[len(names) + names.index(n)]) < 1e-11


@pytest.mark.parametrize("name", CASES)
def test_momentum_and_energy_are_balanced_at_the_impact(name: str) -> None:
    run = hjsolve.Scene.load(scene_of(name, ["2"])).run()
    (budget,) = run.impacts
    assert max(map(abs, budget.residual.values())) < mpf(10) ** -30
    before, after = (arc.quantities["constants"]["E"].value for arc in run.arcs)
    if name != "a wall starts and stays":  # there E of the arc after is that of another Hamiltonian
        assert abs(before - after - float(budget.energy_lost)) < 1e-13
    assert budget.energy_lost > 0
    assert run.lasting.solution.system.coordinates != run.solution.system.coordinates


def test_a_ball_lands_and_slides_to_a_wall_and_is_pushed() -> None:
    """Of the push (1/2, 3) the floor takes the part across it."""
    scene = {
        "system": BALL, "initial": {"q": {"x": "0", "y": "1"}, "velocity": {"x": "1", "y": "0"}},
        "want": ["trajectory"], "times": ["3", "1/4", "1", "2"],
        "events": [
            {"kind": "impact", "at": {"coordinate": "y", "value": "0"}, "constraints": ["dot(y) = 0"], "lasts": True},
            {"kind": "wall", "at": {"coordinate": "x", "value": "3/2"}},
            {"kind": "impulse", "at": {"t": "5/2"}, "momentum": {"x": "1/2", "y": "3"}},
        ],
    }  # fmt: skip
    path = hjsolve.Scene.load(scene).run().trajectory
    assert [float(x) for x in path.q["x"]] == [0.25, 0.25, 1.0, 1.0]
    assert [float(x) for x in path.velocity["x"]] == [-0.5, 1.0, 1.0, -1.0]
    assert abs(path.q["y"][1] - (1 - 9.81 / 32)) < 1e-15
    assert [float(x) for x in path.q["y"][[0, 2, 3]]] == [0.0] * 3
    assert list(path.arc) == [3, 0, 1, 2]


def test_thirty_digits_after_a_string_becomes_taut() -> None:
    """The time is a root of (1/2 + t)^2 + (g t^2/2)^2 = 1; E after it is that of the motion across the string."""
    run = hjsolve.Scene.load(scene_of("a string becomes taut", ["1/10", "1"], accuracy={"digits": 30})).run()
    with mp.workdps(45):
        g = mpf(981) / 100
        t = mp.findroot(lambda t: (mpf(1) / 2 + t) ** 2 + (g * t**2 / 2) ** 2 - 1, mpf("0.335"))
        x, y, vy = mpf(1) / 2 + t, -g * t**2 / 2, -g * t
        E = (x * vy - y) ** 2 / 2 + g * y
        found = run.arcs[1].quantities["constants"]["E"]
        assert abs(found.value - E) <= found.error < mpf(10) ** -28
        radius = mp.sqrt(mpf(run.trajectory.q["x"][1]) ** 2 + mpf(run.trajectory.q["y"][1]) ** 2)
        assert abs(radius - 1) < mpf(10) ** -28
        speed = mpf(run.trajectory.velocity["x"][1]) ** 2 + mpf(run.trajectory.velocity["y"][1]) ** 2
        assert abs(speed / 2 + g * mpf(run.trajectory.q["y"][1]) - E) < mpf(10) ** -27


@pytest.mark.nightly
def test_a_rod_slides_and_sticks_later() -> None:
    """One lasting constraint after the other: the end that slides stops at t = 2, and the rod turns about it."""
    scene = scene_of("a rod slides on a floor that it meets obliquely", ["2", "9/4", "5/2"])
    scene["events"] = [*scene["events"], {"kind": "impact", "at": {"t": "2"}, "constraints": [TANGENT], "lasts": True}]
    run = hjsolve.Scene.load(scene).run()
    path = run.trajectory
    assert len(run.arcs) == 3
    assert len(run.impacts) == 2
    ends = [path.q["x"] - np.cos(path.q["theta"]), path.q["y"] - np.sin(path.q["theta"])]
    assert all(np.ptp(end) < 1e-13 for end in ends)
    T = (path.velocity["x"] ** 2 + path.velocity["y"] ** 2) / 2 + path.velocity["theta"] ** 2 / 6
    assert np.ptp(T + path.q["y"]) < 1e-12
    hit = run.lasting.impacts[0]
    assert hit.energy_lost > 0
    assert max(map(abs, hit.residual.values())) < mpf(10) ** -30


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"restitution": "1/2"}, "a constraint that lasts keeps what meets it"),
    ({"at": {"surface": FLOOR, "t": "1"}}, "a surface alone says where"),
    ({"at": {"surface": "g"}}, "holds no coordinate"),
    ({"kind": "impulse", "momentum": {"x": "1"}}, "belongs to an impact"),
    ({"lasts": "yes"}, "must be true or false"),
    ({"at": {"t": "1"}}, "constraints: missing"),
]


@pytest.mark.parametrize(("change", "words"), REFUSED)
def test_an_impact_that_cannot_be_is_refused(change: dict[str, Any], words: str) -> None:
    scene = scene_of("a rod slides on a floor that it meets obliquely", ["1"])
    scene["events"] = [{**scene["events"][0], **change}]
    with pytest.raises(CatalogError, match=words):
        hjsolve.Scene.load(scene)


def test_what_comes_after_a_constraint_may_be_refused() -> None:
    scene = scene_of("an oblique line in a bowl", ["2"])
    wall = {"kind": "wall", "at": {"coordinate": "x", "value": "-1/4"}}
    gone = hjsolve.Scene.load(
        {**scene, "events": [*scene["events"], {**wall, "at": {"coordinate": "y", "value": "9"}}]}
    )
    names = {c.name for c in hjsolve.Scene.load(scene).run().lasting.solution.system.coordinates}
    assert names == {"y"}
    assert gone.run().trajectory is not None
    with pytest.raises(InvalidInputError, match="which the constraint eliminates"):
        hjsolve.Scene.load({**scene, "events": [*scene["events"], wall]}).run()
    with pytest.raises(CatalogError, match="needs quadratures"):
        hjsolve.Scene.load({**scene, "method": "integrate", "want": ["trajectory"]})
    skate = {**ROD, "potential": "0"}
    event = {
        "kind": "impact",
        "at": {"t": "1"},
        "lasts": True,
        "constraints": ["sin(theta)*dot(x) = cos(theta)*dot(y)"],
    }
    with pytest.raises(InvalidSystemError, match="not integrable"):
        hjsolve.Scene.load({"system": skate, "initial": FALLING, "times": ["2"], "want": ["trajectory"],
                            "events": [event]}).run()  # fmt: skip


def _afterwards(system: dict[str, Any], q: dict[str, str], velocity: dict[str, str], constraints: list[str]) -> Any:
    """Run a scene whose constraints come at t = 1 and last, without forces; states at 1 and 3."""
    scene = {"system": system, "initial": {"q": q, "velocity": velocity}, "times": ["1", "3"], "want": ["trajectory"],
             "events": [{"kind": "impact", "at": {"t": "1"}, "constraints": constraints, "lasts": True}]}  # fmt: skip
    return hjsolve.Scene.load(scene).run()


def test_c47_the_rhombus_stays_on_the_floor() -> None:
    """Ex 3-1: q1' = -3/5 v0, q2' = -6/5 v0, impulse 8/5 m v0, energy lost 4/5 m v0**2; then q1 - q2/2 stays."""
    rhombus = {"coordinates": lines("q1", "q2"), "kinetic": "2*dot(q1)**2 + dot(q2)**2/3", "potential": "0"}
    run = _afterwards(rhombus, {"q1": "1", "q2": "0"}, {"q1": "-1", "q2": "0"}, ["dot(q1) - dot(q2)/2 = 0"])
    path, (hit,) = run.trajectory, run.impacts
    assert path.velocity["q1"] == pytest.approx([-0.6, -0.6], abs=1e-15)
    assert path.velocity["q2"] == pytest.approx([-1.2, -1.2], abs=1e-15)
    assert path.q["q1"] == pytest.approx([0.0, -1.2], abs=1e-15)
    assert abs(abs(5 * hit.multipliers[0]) - 8) + abs(5 * hit.energy_lost - 4) < 1e-30


@pytest.mark.parametrize("sticks", [False, True])
def test_c48_a_particle_slides_or_sticks_on_the_pivoted_bar(sticks: bool) -> None:
    """Ex 3-2: (x', y') = (5/4, -1/4), P3-2: (3/4, -3/4), theta' = -3/4; then (10 + r**2) theta' and E stay."""
    system = {
        "coordinates": [{"name": "r", "domain": "0 < r"}, *lines("phi", "theta")], "potential": "0",
        "kinetic": "(dot(r)**2 + r**2*dot(phi)**2)/2 + 5*dot(theta)**2",
    }  # fmt: skip
    # the particle comes from (1, 0) with the velocity (0, 1), and the bar turns with theta' = -1 to the diagonal
    constraints = ["dot(phi) - dot(theta) = 0", *(["dot(r) = 0"] if sticks else [])]
    run = _afterwards(system, {"r": "1", "phi": "0", "theta": "pi/4 + 1"}, {"r": "0", "phi": "1", "theta": "-1"},
                      constraints)  # fmt: skip
    path, (hit,) = run.trajectory, run.impacts
    r, phi, rate, turn = (path.q["r"], path.q["phi"], path.velocity["r"], path.velocity["phi"])
    x = rate * np.cos(phi) - r * turn * np.sin(phi)
    y = rate * np.sin(phi) + r * turn * np.cos(phi)
    expected = (0.75, -0.75) if sticks else (1.25, -0.25)
    assert (x[0], y[0]) == pytest.approx(expected, abs=1e-14)
    assert path.velocity["theta"][0] == pytest.approx(-0.75, abs=1e-14)
    assert abs(abs(hit.impulse["phi"]) / mp.sqrt(2) - 5 / mp.sqrt(8)) < 1e-15  # the impulse on the bar, by its arm
    assert (10 + r**2) * turn == pytest.approx([-9.0, -9.0], abs=1e-13)
    E = (rate**2 + (10 + r**2) * turn**2) / 2
    assert pytest.approx([3.375 if sticks else 3.625] * 2, abs=1e-13) == E
    assert path.q["phi"] - path.q["theta"] == pytest.approx([0.0, 0.0], abs=1e-14)


def test_c57_the_rod_slides_along_the_oblique_wall() -> None:
    """P3-3: x' = 4/5 v0, y' = v0/5, theta' = 6 v0/(5 l), impulse sqrt(2)/5 m v0; then x + y grows evenly."""
    rod = {**ROD, "potential": "0"}
    run = _afterwards(rod, {"x": "-1", "y": "0", "theta": "0"}, {"x": "1", "y": "0", "theta": "0"},
                      ["(dot(y) - dot(x))/sqrt(2) + l/2*cos(theta)*dot(theta)/sqrt(2) = 0"])  # fmt: skip
    path, (hit,) = run.trajectory, run.impacts
    assert [float(path.velocity[n][0]) for n in ("x", "y", "theta")] == pytest.approx([0.8, 0.2, 0.6], abs=1e-14)
    assert abs(abs(hit.multipliers[0]) - mp.sqrt(2) / 5) < 1e-15
    assert path.q["x"] + path.q["y"] == pytest.approx([0.0, 2.0], abs=1e-13)
    assert path.q["x"] - path.q["y"] - np.sin(path.q["theta"]) == pytest.approx([0.0, 0.0], abs=1e-13)


def test_c58_the_wall_starts_to_move_and_goes_on() -> None:
    """P3-4: x' = 5/8 v0, y' = 3/8 v0, theta' = 3 v0/(2 sqrt(2) l), impulse 5/8 m v0; then theta' stays."""
    rod, rest = {**ROD, "potential": "0"}, {"x": "0", "y": "0", "theta": "0"}
    run = _afterwards(rod, {**rest, "theta": "pi/4"}, rest,
                      ["dot(x) + l/2*sin(theta)*dot(theta) = 1", NORMAL])  # fmt: skip
    path, (hit,) = run.trajectory, run.impacts
    speed = 3 / (4 * np.sqrt(2))
    assert [float(path.velocity[n][0]) for n in ("x", "y", "theta")] == pytest.approx([5 / 8, 3 / 8, speed], abs=1e-14)
    assert abs(hit.multipliers[0] - mpf(5) / 8) < 1e-15
    assert hit.energy_lost < 0
    assert path.velocity["theta"][1] == pytest.approx(speed, abs=1e-14)
    assert path.unwrapped("theta")[1] == pytest.approx(np.pi / 4 + 2 * speed, abs=1e-13)
    assert path.q["x"][1] - np.cos(path.q["theta"][1]) == pytest.approx(2 - np.sqrt(0.5), abs=1e-13)


@pytest.mark.nightly
def test_the_command_line_prints_states_and_budgets(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "taut.toml"
    path.write_text(
        'want = ["trajectory", "constants"]\ntimes = ["1/4", "1"]\ninitial = {q = {x = "1/2", y = "0"}, '
        'velocity = {x = "1", y = "0"}}\n[system]\nkinetic = "(dot(x)**2 + dot(y)**2)/2"\npotential = "981/100*y"\n'
        'coordinates = [{name = "x", domain = "line"}, {name = "y", domain = "line"}]\n[[events]]\nkind = "impact"\n'
        'at = {surface = "x**2 + y**2 - 1"}\nlasts = true\n', encoding="utf-8",
    )  # fmt: skip
    assert main(["motion", str(path)]) == 0
    header, *rows = (line.split(",") for line in capsys.readouterr().out.splitlines())
    last = dict(zip(header, rows[-1], strict=True))
    assert float(last["q.x"]) ** 2 + float(last["q.y"]) ** 2 == pytest.approx(1, abs=1e-14)
    assert main(["report", str(path), "-o", "-"]) == 0
    shown = capsys.readouterr().out
    assert "The impacts" in shown
    assert "The system after the constraint" in shown


def test_an_impact_after_a_wall_that_moves_counts_the_velocity_of_the_wall() -> None:
    """With x' = 1/3 by the wall, x' - y' = 0 makes y' = 1/3."""
    scene = scene_of("a wall starts and stays", ["2", "5/2"])
    scene["events"] = [*scene["events"], {"kind": "impact", "at": {"t": "2"}, "constraints": ["dot(x) - dot(y) = 0"]}]
    run = hjsolve.Scene.load(scene).run()
    assert [float(run.trajectory.velocity[n][0]) for n in "xy"] == pytest.approx([1 / 3, 1 / 3], abs=1e-14)
    assert len(run.arcs) == 3
    assert max(map(abs, run.impacts[1].residual.values())) < mpf(10) ** -30
