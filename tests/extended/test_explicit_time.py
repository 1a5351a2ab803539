"""Explicit time: frames found, quadratic principal functions, and refusals that name what was tried.

Motions are compared with Taylor series of Hamilton's equations of H(q, p, t) + p_t, the time one more coordinate.
"""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.power_series import FloatingPoint, SeriesProgram
from hjsolve.command_line.main import main
from hjsolve.extended.quadratic_flow import QuadraticFlow, _Walk
from hjsolve.lowering import lower
from hjsolve.mechanics.system import hamiltonian, momenta
from tests.reference.taylor import Flow

LINE, PLANE = {"x": "line"}, {"x": "line", "y": "line"}
M1 = "m/2*dot(x)**2"
CASES: dict[str, tuple[Any, ...]] = {
    "P5 force that grows, -m A t x": (LINE, M1, "-m*A*t*x", {"m": 2, "A": 3}),
    "Ex 6-9, anchor that moves (C82)": (LINE, M1, "k/2*(t - x)**2", {"m": 2, "k": 3}),
    "P6-13, drifting gauge (C88)": (LINE, "m/2*(dot(x) + t)**2", "k/2*x**2", {"m": 2, "k": 3}),
    "Ex 2-5, turning anchor (C26b)": (PLANE, "m/2*(dot(x)**2 + dot(y)**2)",
        "k/2*(x**2 + y**2) - m*a*w**2*(x*cos(w*t) + y*sin(w*t))", {"m": 1, "k": 2, "a": "1/2", "w": 3}),
    "Caldirola-Kanai": (LINE, "m/2*exp(g*t)*dot(x)**2", "k/2*exp(g*t)*x**2", {"m": 1, "k": 4, "g": "1/5"}),
    "driven oscillator": (LINE, "dot(x)**2/2", "x**2/2 - F*x*cos(w*t)", {"F": 1, "w": 2}),
    "driven at resonance": (LINE, "dot(x)**2/2", "x**2/2 - F*x*cos(t)", {"F": "1/3"}),
    "driven by a decaying force": (LINE, "dot(x)**2/2", "x**2 - x*t*exp(-t/2)*sin(3*t)", {}),
    "a well that falls": (LINE, "dot(x)**2/2", "(x - t**2/4)**4/4", {}),
    "waves that run": (LINE, "dot(x)**2/2", "-cos(x - t/3)", {}),
    "a turning field": ({"phi": "angle"}, "dot(phi)**2/2", "-cos(phi - t/4)", {}),
}  # fmt: skip
QUADRATIC: dict[str, tuple[Any, ...]] = {
    "Mathieu": (LINE, "dot(x)**2/2", "(2 + cos(t))*x**2/2", {}),
    "a rope that shortens": (LINE, "exp(-t/4)*dot(x)**2/2", "(3 - t/8)*x**2/2 - x*sqrt(1 + t**2)", {}),
    "two, coupled in time": (PLANE, "(dot(x)**2 + dot(y)**2)/2", "x**2 + y**2 + x*y*sin(2*t) - y*exp(-t)", {}),
    "springs that stiffen by inverse functions": (LINE, "dot(x)**2/2", "(3 + atan(t))*x**2/2 - x*atan(2*t)", {}),
}


def truth(system: hjsolve.System, start: dict[str, str], rate: dict[str, str], t0: str, t: str) -> list[Any]:
    """q, then p, at a time, to 30 digits."""
    clock, p_t = system.time, sp.Symbol("p_clock", real=True)
    values = {p.symbol: p.value for p in system.parameters if p.value is not None}
    at = values | {c.symbol: sp.Rational(start[c.name]) for c in system.coordinates} | {clock: sp.Rational(t0)}
    at |= {c.velocity: sp.Rational(rate[c.name]) for c in system.coordinates}
    p = [sp.N(momenta(system)[c.name].subs(at), 60) for c in system.coordinates]
    q = [sp.N(at[c.symbol], 60) for c in system.coordinates]
    with mp.workdps(50):
        numbers = {s: mpf(sp.N(v, 60)) for s, v in values.items()}
        state = [*(mpf(x) for x in q), mpf(sp.N(at[clock], 60)), *(mpf(x) for x in p), mpf(0)]
        flow = Flow(
            hamiltonian(system) + p_t, [*(c.symbol for c in system.coordinates), clock],
            [*(c.momentum for c in system.coordinates), p_t], numbers, state, digits=32,
        )  # fmt: skip
        found = flow.at(mpf(t) - mpf(t0))
        n = len(system.coordinates)
        return [*found[:n], *found[n + 1 : 2 * n + 1]]


@pytest.mark.nightly_cases(*list(CASES)[3:])
@pytest.mark.parametrize("name", CASES)
def test_a_frame_is_found_and_the_motion_is_the_one_as_posed(name: str) -> None:
    system = hjsolve.System(*CASES[name])
    assert system.time is not None
    assert isinstance(hjsolve.separate(system), hjsolve.Obstruction)
    solution = hjsolve.solve(system)
    assert solution.kind == "frame"
    names = [c.name for c in system.coordinates]
    start, rate = dict(zip(names, ("6/5", "1/3"), strict=False)), dict(zip(names, ("1/2", "2/5"), strict=False))
    state = solution.motion(q=start, velocity=rate, t0="1/4").at("7/4")
    expected = truth(system, start, rate, "0.25", "1.75")
    for group, offset in ((state.q, 0), (state.p, len(names))):
        errors = state.error.q if offset == 0 else state.error.p
        for k, n in enumerate(names):
            gap = abs(mpf(group[n]) - expected[offset + k])
            gap = min(gap, abs(gap - 2 * mp.pi)) if n == "phi" and offset == 0 else gap
            assert gap <= mpf(errors[n]) <= 1e-11


@pytest.mark.nightly_cases(*list(QUADRATIC)[1:])
@pytest.mark.parametrize("name", QUADRATIC)
def test_a_quadratic_principal_function_gives_the_motion_with_a_proved_error(name: str) -> None:
    system = hjsolve.System(*QUADRATIC[name])
    solution = hjsolve.solve(system)
    assert (solution.kind, solution.frame, solution.principal_function) == ("quadratic", None, None)
    names = [c.name for c in system.coordinates]
    start, rate = dict(zip(names, ("6/5", "1/3"), strict=False)), dict(zip(names, ("1/2", "2/5"), strict=False))
    for digits in (15, 25):
        motion = solution.motion(q=start, velocity=rate, t0="1/4", digits=digits)
        state = motion.at(["1/4", "7/4"])
        expected = truth(system, start, rate, "0.25", "1.75")
        with mp.workdps(50):
            for k, n in enumerate(names):
                assert abs(mpf(state.q[n][1]) - expected[k]) <= mpf(state.error.q[n][1]) <= mpf(10) ** (2 - digits)
                assert abs(mpf(state.p[n][1]) - expected[len(names) + k]) <= mpf(state.error.p[n][1])


def test_the_coefficients_of_s_give_the_momenta_of_every_motion_with_these_constants() -> None:
    """p = A q + B on the whole family p(t₀) = α: checked on three motions that start elsewhere; A is symmetric."""
    system = hjsolve.System(*QUADRATIC["two, coupled in time"])
    solution = hjsolve.solve(system)
    alpha = {"x": "1/2", "y": "-1/3"}
    S = solution.motion(q={"x": 0, "y": 0}, p=alpha, digits=20).coefficients("3/4")
    A, B = S.A, S.B
    assert abs(A[0, 1] - A[1, 0]) < mpf(10) ** -18
    for place in ({"x": 0, "y": 1}, {"x": "7/3", "y": "-2"}, {"x": "-1/2", "y": "1/5"}):
        state = solution.motion(q=place, p=alpha, digits=20).at("3/4")
        for i, name in enumerate("xy"):
            slope = A[i, 0] * state.q["x"] + A[i, 1] * state.q["y"] + B[i]
            assert abs(slope - state.p[name]) < mpf(10) ** -17


def riccati(system: hjsolve.System, alpha: list[str], t0: str, t: str) -> list[Any]:
    """A, B and C at a time from dS/dt + H(q, dS/dq, t) = 0, sorted by powers of q, integrated in 25 digits."""
    n = len(system.coordinates)
    q, S = [c.symbol for c in system.coordinates], sp.Dummy("S")
    a = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"a{min(i, j)}{max(i, j)}"))
    b, Q = sp.Matrix([sp.Symbol(f"b{i}") for i in range(n)]), sp.Matrix(q)
    slope = dict(zip((c.momentum for c in system.coordinates), a * Q + b, strict=True))
    H = sp.Poly(sp.expand(hamiltonian(system).subs(slope)), *q)
    rates = [-sp.diff(H.as_expr(), q[i], q[j]) for i in range(n) for j in range(i, n)]
    rates += [-sp.diff(H.as_expr(), x).subs(dict.fromkeys(q, 0)) for x in q] + [-H.as_expr().subs(dict.fromkeys(q, 0))]
    unknown = [a[i, j] for i in range(n) for j in range(i, n)] + list(b) + [S]
    function = sp.lambdify([system.time, unknown], rates, "mpmath")
    start = [mpf(0)] * (n * (n + 1) // 2) + [mpf(sp.Rational(x).p) / sp.Rational(x).q for x in alpha] + [mpf(0)]
    return list(mp.odefun(lambda s, y: function(s, y), mpf(t0), start, tol=mpf(10) ** -22)(mpf(t)))


FORCED = {
    "forced, with a constant of the gauge": (LINE, "dot(x)**2/2", "x**2/2 - x*sin(2*t)/(1 + t**2) + t**2/7", {}),
    "a rope that shortens": QUADRATIC["a rope that shortens"],
    "two, coupled in time": QUADRATIC["two, coupled in time"],
    "a velocity term that moves": (LINE, "dot(x)**2/2 + cos(3*t)*dot(x)/(2 + t)", "(1 + t/5)*x**2/2 - x", {}),
}


@pytest.mark.nightly_cases("a rope that shortens", "two, coupled in time")
@pytest.mark.parametrize("name", FORCED)
def test_a_b_and_c_solve_the_riccati_equations_within_their_errors(name: str) -> None:
    """Of S = q A q/2 + B q + C with S(q, t0) = alpha q; the digits asked are reached."""
    system = hjsolve.System(*FORCED[name])
    names = [c.name for c in system.coordinates]
    alpha, n = ["1/2", "-1/3"][: len(names)], len(names)
    with mp.workdps(30):
        expected = riccati(system, alpha, "0.25", "0.75")  # before the first conjugate time
        for digits in (15, 20):
            motion = hjsolve.solve(system).motion(
                q=dict.fromkeys(names, 7), p=dict(zip(names, alpha, strict=True)), t0="1/4", digits=digits
            )
            S = motion.coefficients("3/4")
            found = [S.A[i, j] for i in range(n) for j in range(i, n)]
            unit = mpf(10) ** (1 - digits)
            for x, e in zip(found, expected, strict=False):
                assert abs(x - e) <= mpf(S.error_A) + mpf(10) ** -20
            for x, e in zip(S.B, expected[len(found) :], strict=False):
                assert abs(x - e) <= mpf(S.error_B) + mpf(10) ** -20
            assert abs(S.C.value - expected[-1]) <= mpf(S.C.error) + mpf(10) ** -20
            assert max(S.error_A, S.error_B, S.C.error) <= 3 * unit * max(map(abs, expected))


def test_at_a_conjugate_time_s_is_not_finite() -> None:
    """With p(t0) constant the trajectories of an oscillator meet a quarter of a period later."""
    system = hjsolve.System(*FORCED["forced, with a constant of the gauge"])
    motion = hjsolve.solve(system).motion(q={"x": 1}, p={"x": "7/10"})
    with pytest.raises(hjsolve.NotConvergedError, match="conjugate"):
        motion.coefficients("pi/2")
    near = "1.5707963267948966"
    S = motion.coefficients(near)
    with mp.workdps(40):
        assert abs(S.A[0, 0] + mp.tan(mpf(near))) <= S.error_A <= 10  # A = -tan t, 5.2e16 here
    assert motion.coefficients(0).A[0, 0] == 0


@pytest.mark.parametrize("name", list(CASES)[:3])
def test_the_principal_function_solves_the_equation_with_the_time(name: str) -> None:
    """∂S/∂t + H(q, ∂S/∂q, t) = 0 (5-52), the integral in S never done."""
    system = hjsolve.System(*CASES[name])
    S = hjsolve.solve(system).principal_function
    x = system.coordinates[0]
    residual = sp.diff(S, system.time) + hamiltonian(system).subs(x.momentum, sp.diff(S, x.symbol))
    letters = {s: sp.Rational(k + 13, 11) for k, s in enumerate(sorted(residual.free_symbols, key=str))}
    letters |= {s: sp.Integer(90) for s in residual.free_symbols if s.name == "E"}
    assert abs(sp.N(residual.subs(letters).doit(), 30)) < 1e-25


def test_a_refusal_names_what_was_tried() -> None:
    driven = hjsolve.System({"th": "angle"}, "(dot(th)**2 + 2*dot(th)*cos(t)*cos(th))/2", "-cos(th)")
    with pytest.raises(hjsolve.NotSeparableError, match="Tried were a frame that moves evenly, an accelerated frame"):
        hjsolve.solve(driven)
    verdict = hjsolve.separate(driven)
    assert (verdict.part, verdict.witness.excludes_zero) == ("time", True)
    moving = hjsolve.System(PLANE, "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt((x - t/2)**2 + y**2) + x*y**3")
    with pytest.raises(hjsolve.NotSeparableError, match="Tried were"):
        hjsolve.solve(moving)
    kepler = hjsolve.System(PLANE, "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt((x - t/2)**2 + y**2)")
    with pytest.raises(hjsolve.NotSeparableError, match="In a frame that was found it does not, but there"):
        hjsolve.solve(kepler)


@pytest.mark.parametrize("verb", ["find_coordinates", "normal_modes", "gyroscopic_modes"])
def test_a_verb_that_knows_no_time_says_so(verb: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match="T or V holds the time"):
        getattr(hjsolve, verb)(hjsolve.System(*CASES["driven oscillator"]))


def test_verify_and_is_integral_know_the_time() -> None:
    """Problem of a force −m A t x: S = a x + m A t² x/2 − …; the energy is no integral, p − m A t²/2 is."""
    system = hjsolve.System(*CASES["P5 force that grows, -m A t x"])
    S = "a*x + m*A*t**2*x/2 - (a**2*t + a*m*A*t**3/3 + m**2*A**2*t**5/20)/(2*m)"
    assert type(hjsolve.verify(system, S=S, constants="a")).__name__ == "CompleteIntegral"
    assert not hjsolve.verify(system, S=S.replace("/20", "/10"), constants="a")
    assert hjsolve.is_integral("p_x - m*A*t**2/2", system)
    assert not hjsolve.is_integral("H", system)


@pytest.mark.nightly
def test_the_command_line_takes_the_time(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    anchor = ["--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "(t - x)**2/2"]
    assert main(["check", *anchor]) == 0
    assert "x = X + t" in capsys.readouterr().out
    assert main(["solve", *anchor]) == 0
    assert "S = " in capsys.readouterr().out
    assert main(["motion", *anchor, "--q", "x=0", "--velocity", "x=1", "--times", "0,2"]) == 0
    header, _, row = (line.split(",") for line in capsys.readouterr().out.splitlines())
    at = dict(zip(header, row, strict=True))
    assert (float(at["q.X"]), float(at["q.x"])) == (0.0, 2.0)  # at rest in the frame of the anchor
    assert main(["solve", "--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "(2 + cos(t))*x**2"]) == 0
    assert "q·A q" in capsys.readouterr().out
    assert main(["solve", "--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "cos(t)*x**4"]) == 1
    assert "Tried were" in capsys.readouterr().out
    path = tmp_path / "anchor.toml"
    path.write_text('id = "anchor"\ntitle = "a"\ncoordinates = [{name = "x", domain = "line"}]\n'
                    'kinetic = "dot(x)**2/2"\npotential = "(t - x)**2/2"\n', encoding="utf-8")  # fmt: skip
    assert main(["check", str(path)]) == 0
    assert main(["report", *anchor, "-o", "-", "--brief"]) == 0
    assert "The system as posed, and its frame" in capsys.readouterr().out


def test_power_series_are_those_of_sympy() -> None:
    t = sp.Symbol("t", real=True)
    f = sp.exp(sp.sin(t)) * sp.sqrt(1 + t**2) / (2 + sp.tanh(t)) + sp.log(3 + t) * sp.cosh(t) - sp.tan(t / 3) ** 2
    program = SeriesProgram(FloatingPoint(Multi(120)))
    inner = program.new()
    entry = program.coefficients(lower([f], [t]).run(program, [inner])[0])
    for k, x in enumerate((0.5, 1, 0, 0, 0)):
        inner.append(Multi(120).convert(x))
        program.extend(k)
    for k, value in enumerate(map(entry, range(5))):
        expected = sp.N(sp.diff(f, t, k).subs(t, sp.Rational(1, 2)) / sp.factorial(k), 30)
        assert abs(mpf(value) - mpf(expected)) < 1e-25


@pytest.mark.nightly
def test_a_kepler_centre_that_moves_is_solved_in_polar_coordinates_of_its_frame() -> None:
    system = hjsolve.System(PLANE, "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt((x - t/2)**2 + y**2)")
    solution = hjsolve.solve(system, coordinates="find")
    assert (solution.kind, solution.solution.chart.kind) == ("frame", "polar")
    start, rate = {"x": "1", "y": "0"}, {"x": "1/2", "y": "11/10"}
    state = solution.motion(q=start, velocity=rate).at(2)
    expected = truth(system, start, rate, "0", "2")
    with mp.workdps(40):
        assert abs(mpf(state.q["x"]) - expected[0]) <= mpf(state.error.q["x"]) <= 1e-12
        assert abs(mpf(state.q["y"]) - expected[1]) <= mpf(state.error.q["y"]) <= 1e-12


def test_the_bound_of_the_taylor_series_holds_where_few_digits_are_carried() -> None:
    """With few digits the remainders are large enough to be seen; the truth has 30."""
    t = sp.Symbol("t", real=True)
    flow = QuadraticFlow(sp.ImmutableMatrix([[0, 1], [-(2 + sp.cos(t)), 0]]), sp.ImmutableMatrix([0, sp.exp(-t)]), t)
    start = [sp.Rational(6, 5), sp.Rational(1, 2)]
    approximate = _Walk(flow, [start], sp.S.Zero, 1)
    for moment in (sp.Rational(3, 2), sp.Integer(5)):
        approximate.to(moment)
        ((exact,),), _, _ = flow.integrate([start], sp.S.Zero, [moment], 30)
        with mp.workdps(40):
            error = max(abs(mpf(a) - mpf(e)) for a, e in zip(approximate.states()[0], exact, strict=True))
            assert 0 < error <= mpf(approximate.error)


@pytest.mark.nightly
def test_a_report_prints_the_coefficients_of_s(capsys: pytest.CaptureFixture[str]) -> None:
    mathieu = ["--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "(2 + cos(t))*x**2/2"]
    assert main(["report", *mathieu, "--q", "x=1", "--velocity", "x=0", "-o", "-", "--brief"]) == 0
    shown = capsys.readouterr().out
    assert "A principal function of second degree" in shown
    assert "11.70270635" in shown
