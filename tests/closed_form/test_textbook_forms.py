"""Forms as a textbook prints them: their shape, and their values against the quadrature to 40 digits, atol = 0."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.derive import form_of_sample
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.numbers import root_values
from hjsolve.closed_form.sampling import samples
from hjsolve.functions import JacobiAM, JacobiCN, JacobiDN, JacobiSN
from hjsolve.mechanics.coordinates_and_parameters import parameter
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(10)

DIGITS = 40
Values = Mapping[str, sp.Expr]


def _typed(V: str, *, plane: bool = False, line: str = "line", **constants: object) -> RegimeForms:
    """The form of a motion in a potential of x on a line, or of r in the plane."""
    values = {n: v for n, v in constants.items() if n not in ("x", "v", "turning")}
    parameters = {n: parameter(n, str(v), assume="positive") for n, v in {"m": 1, **values}.items()}
    x, v = str(constants["x"]), str(constants["v"])
    if plane:
        T, coordinates = "m*(dot(r)**2 + r**2*dot(theta)**2)/2", {"r": "0 < r", "theta": "angle"}
        q, velocity = {"r": x, "theta": "0"}, {"r": v, "theta": str(constants["turning"])}
    else:
        T, coordinates, q, velocity = "m*dot(x)**2/2", {"x": line}, {"x": x}, {"x": v}
    system = hjsolve.System(coordinates=coordinates, kinetic=T, potential=V, parameters=parameters)
    form = own_form(hjsolve.solve(system).motion(q=q, velocity=velocity))
    assert form is not None
    return form


def _integral(form: RegimeForms, equation: sp.Eq, values: Values, start: sp.Expr, stop: sp.Expr) -> mpmath.mpf:
    """The quadrature of an equation of the solution between two places, in 60 digits."""
    (integral,) = equation.rhs.atoms(sp.Integral)
    q = integral.limits[0][0]
    integrand = integral.function.xreplace(
        {s: values[s.name] for s in integral.function.free_symbols if s.name in values}
    )
    with mpmath.workdps(60):
        function = sp.lambdify(q, integrand, "mpmath")
        ends = [mpmath.mpf(int(end.p)) / int(end.q) for end in (start, stop)]
        return mpmath.quad(function, ends)


def _places(form: RegimeForms, name: str) -> tuple[sp.Expr, sp.Expr]:
    """Two places well inside the region of the example, with q growing."""
    at = dict(form.regime.example)
    lower, upper = form.turning_points.get(name, (None, None))
    ends = [None if e is None else _number(form, e, at) for e in (lower, upper)]
    if ends[0] is None and ends[1] is None:
        low, high = sp.Rational(1, 4), sp.Rational(3, 4)
    elif ends[0] is None:
        high = ends[1] - abs(ends[1]) / 4 - sp.Rational(1, 10)
        low = high - abs(high) / 2 - sp.Rational(1, 10)
        domain = form.solution.system.coordinate(name).domain
        if domain.lower is not None and not low > domain.lower:
            low, high = high * sp.Rational(1, 3), high * sp.Rational(2, 3)
    elif ends[1] is None:
        low = ends[0] + abs(ends[0]) / 8 + sp.Rational(1, 20)
        high = low + abs(low) / 2 + sp.Rational(1, 5)
    else:
        low, high = (ends[0] + (ends[1] - ends[0]) * part for part in (sp.Rational(13, 50), sp.Rational(31, 50)))
    return tuple(sp.Rational(str(sp.N(e, 12))) for e in (low, high))  # type: ignore[return-value]


def _number(form: RegimeForms, e: sp.Expr, at: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    roots = root_values(form, at, 30)
    return sp.N(e.xreplace({s: sp.Float(str(v), 25) for s, v in roots.items()}).xreplace(dict(at)), 25)


def _same(got: mpmath.mpf, expected: mpmath.mpf | sp.Rational) -> None:
    with mpmath.workdps(60):
        if isinstance(expected, sp.Rational):
            expected = mpmath.mpf(int(expected.p)) / int(expected.q)
        assert abs(got - expected) <= abs(expected) * mpmath.mpf(10) ** -DIGITS, (got, expected)


def _values(form: RegimeForms, name: str, start: sp.Expr, **more: object) -> dict[str, object]:
    needed = {s.name for s in form.written_out(name).free_symbols} | {s.name for s in form.regime.example}
    given: dict[str, object] = {s.name: v for s, v in form.regime.example.items()}
    given |= {limit.name: start for limit in form.solution.lower_limits.values()}
    given |= {"t_0": 0, **{s: 0 for s in needed if s.startswith("beta")}, **more}
    return {n: v for n, v in given.items() if n in needed}


def agrees_in_time(form: RegimeForms, name: str) -> None:
    """q(t), or q(ξ) and t(ξ), at the time that the quadrature gives."""
    assert form.solution.time_law is not None
    start, stop = _places(form, name)
    example = {s.name: v for s, v in form.regime.example.items()}
    if name in form.inverse:
        t = _integral(form, form.solution.time_law, example, start, stop)
        given = _values(form, f"inverse.{name}", start, t=sp.Float(str(mpmath.nstr(t, 55)), 55))
        got = form.evaluate(f"inverse.{name}", given, 45).value
        _same(got, stop)
        return
    ξ = sp.Rational(7, 10)
    q = form.evaluate(f"anomaly.{name}", _values(form, f"anomaly.{name}", start, xi=ξ), 50).value
    got = form.evaluate("anomaly.t", _values(form, "anomaly.t", start, xi=ξ), 50).value
    t = _integral(form, form.solution.time_law, example, start, sp.Rational(str(mpmath.nstr(q, 55))))
    _same(got, t)


def agrees_along_the_orbit(form: RegimeForms, name: str, angle: str) -> None:
    """r(θ) at the θ that the quadrature of the orbit equation gives."""
    equation = form.solution.orbit_equations[f"p_{angle}"]
    start, stop = _places(form, name)
    θ = _integral(form, equation, {s.name: v for s, v in form.regime.example.items()}, stop, start)
    given = _values(form, f"orbit.{name}", start, **{angle: sp.Float(str(mpmath.nstr(θ, 55)), 55)})
    got = form.evaluate(f"orbit.{name}", given, 45).value
    _same(got, stop)


def _symbol(form: RegimeForms, name: str) -> sp.Symbol:
    return next(s for s in form.where if s.name == name)


@pytest.mark.parametrize("regime", range(3))
def test_keplers_orbit_is_one_conic_for_every_sign_of_the_energy(regime: int) -> None:
    form = forms("kepler-planar")[regime]
    p, θ_p = _symbol(form, "p"), _symbol(form, "theta_p")
    θ, E, p_θ, m, k = (next(s for s in form.solution.characteristic_function.free_symbols | set(form.regime.example)
                            if s.name == n) for n in ("theta", "E", "p_theta", "m", "k"))  # fmt: skip
    e = sp.S.One if form.regime.special else _symbol(form, "e")
    assert form.orbit["r"] == p / (1 + e * sp.cos(θ - θ_p))
    assert form.where[p] == p_θ**2 / (m * k)
    assert form.regime.special or sp.expand(form.where[e] ** 2 - 1 - 2 * E * p_θ**2 / (m * k**2)) == 0
    agrees_along_the_orbit(form, "r", "theta")


def test_keplers_equation_is_the_parametric_time_law() -> None:
    ellipse, hyperbola, parabola = forms("kepler-planar")[:3]
    ξ = sp.Symbol("xi", real=True)
    for form, wave, whole in ((ellipse, sp.cos, sp.sin), (hyperbola, sp.cosh, sp.sinh)):
        a, e, n, t_p = (_symbol(form, s) for s in ("a", "e", "n", "t_p"))
        side = 1 if wave is sp.cos else -1
        assert sp.expand(form.anomaly["r"] - side * a * (1 - e * wave(ξ))) == 0
        assert sp.expand(form.anomaly["t"] - t_p - (side * (ξ - e * whole(ξ))) / n) == 0
        agrees_in_time(form, "r")
        assert "Kepler's equation" in str(form.why_not["inverse.r"])
    n, t_p = _symbol(parabola, "n"), _symbol(parabola, "t_p")
    assert sp.expand(parabola.anomaly["t"] - t_p - (ξ + ξ**3 / 3) / n) == 0
    assert parabola.inverse["r"].has(sp.sinh)  # Barker's cubic has one real root
    agrees_in_time(parabola, "r")


SHAPES = {
    "k/r": (_typed, {"V": "-k/r + b/r**2", "plane": True, "k": 1, "b": "0.1", "x": 1, "v": "0.1", "turning": 1}),
    "repelled": (_typed, {"V": "k/r", "plane": True, "k": 1, "x": 1, "v": "-0.1", "turning": 1}),
    "isotropic": (
        _typed,
        {"V": "k*r**2/2 + b/r**2", "plane": True, "k": 1, "b": "0.3", "x": 1, "v": "0.1", "turning": 1},
    ),
    "free": (_typed, {"V": "0", "plane": True, "x": 1, "v": "0.1", "turning": 1}),
}


@pytest.mark.parametrize("name", SHAPES)
def test_every_quadratic_under_the_root_in_a_power_of_r_has_its_conic(name: str) -> None:
    """r or r² = p/(1 + e cos κ(θ − θ_p)), whatever letters stand in V."""
    make, arguments = SHAPES[name]
    form = make(**arguments)
    conic = form.orbit["r"] if name in ("k/r", "repelled") else form.orbit["r"] ** 2
    waves = conic.atoms(sp.cos)
    assert len(waves) == 1
    p, e = _symbol(form, "p"), next((s for s in form.where if s.name == "e"), sp.S.One)
    z = sp.Dummy("z")
    ratio = sp.cancel(p / conic.xreplace({waves.pop(): z}) - 1) / z
    assert sp.cancel(ratio / e) in (1, -1)
    agrees_along_the_orbit(form, "r", "theta")
    agrees_in_time(form, "r")


def test_straight_lines_and_parabolas_are_polynomials_of_the_time() -> None:
    t, t_0 = sp.Symbol("t", real=True), sp.Symbol("t_0", real=True)
    for name, degree in (("projectile", 2), ("vertical-fall", 2), ("disk-on-slope", 2), ("block-on-wedge", 2)):
        _, form = _started(name)
        for q, place in form.inverse.items():
            assert place.is_polynomial(t)
            assert sp.degree(place, t) <= degree
            assert sp.count_ops(place) < 40, (name, q)
        (q,) = form.solution.coordinates
        limit = form.solution.lower_limits[q]
        assert form.inverse[q].subs(t, t_0) == limit
        assert sp.Poly(form.inverse[q].subs(t, t + t_0), t).all_coeffs()[1] in form.where
        agrees_in_time(form, q)


def test_the_pendulum_in_sn_am_and_its_separatrix() -> None:
    t = sp.Symbol("t", real=True)
    libration = next(f for f in forms("pendulum") if f.regime.kinds["theta"] == "libration")
    k, ω, t_p = (_symbol(libration, s) for s in ("k", "omega", "t_p"))
    assert libration.inverse["theta"] == 2 * sp.asin(k * JacobiSN(ω * (t - t_p), k**2))
    turning = next(f for f in forms("pendulum") if f.regime.kinds["theta"] == "rotation")
    k, ω, t_p = (_symbol(turning, s) for s in ("k", "omega", "t_p"))
    assert turning.inverse["theta"] == 2 * JacobiAM(ω * (t - t_p), k**2)
    agrees_in_time(libration, "theta")
    agrees_in_time(turning, "theta")


@pytest.mark.nightly
def test_the_spherical_pendulum_and_the_top_between_two_roots_of_a_cubic() -> None:
    t = sp.Symbol("t", real=True)
    _, form = _started("spherical-pendulum")
    x_2, x_3, k, ω, t_p = (_symbol(form, s) for s in ("x_2", "x_3", "k", "omega", "t_p"))
    assert form.inverse["theta"] == sp.acos(x_3 - (x_3 - x_2) * JacobiSN(ω * (t - t_p), k**2) ** 2)
    assert form.where[k] == sp.sqrt((x_3 - x_2) / (x_3 - _symbol(form, "x_1")))
    agrees_in_time(form, "theta")
    _, top = _started("lagrange-top")
    assert sp.count_ops(top.inverse["theta"]) < 12
    agrees_in_time(top, "theta")


@pytest.mark.parametrize(("V", "motion", "function"), [
    ("a*x**2/2 + b*x**4/4", {"x": "0.5", "v": "0.3"}, JacobiCN),
    ("-a*x**2/2 + b*x**4/4", {"x": "1.2", "v": "0.1"}, JacobiDN),
    ("a*x**2/2 - b*x**4/4", {"x": "0.2", "v": "0.1"}, JacobiSN),
])  # fmt: skip
def test_duffings_oscillator_by_the_signs_of_its_letters(V: str, motion: dict[str, str], function: type) -> None:
    form = _typed(V, a="1.3", b="0.7", **motion)
    assert form.inverse["x"].has(function)
    assert sp.count_ops(form.inverse["x"]) < 10
    agrees_in_time(form, "x")


def test_names_are_worked_out_by_evaluate_lambdify_and_code() -> None:
    """Of a form in names nobody needs to know their values: constants, lower limits and β are asked for."""
    form = forms("kepler-planar")[0]
    given = {"E": "-0.5", "p_theta": "0.8", "m": 1, "k": 1, "theta": "0.7", "beta_theta": "0.1", "r_0": "0.6"}
    exact = form.evaluate("orbit.r", given, 30)
    θ_p = mpmath.mpf("-0.1") - mpmath.acos((mpmath.mpf("0.64") / mpmath.mpf("0.6") - 1) / mpmath.mpf("0.6"))
    expected = mpmath.mpf("0.64") / (1 + mpmath.mpf("0.6") * mpmath.cos(mpmath.mpf("0.7") - θ_p))
    assert abs(exact.value - expected) < 1e-14
    numbers = {name: float(value) for name, value in given.items()}
    assert abs(form.lambdify("numpy")["orbit.r"](**numbers) - float(exact.value)) < 4e-16
    assert "theta_p" not in form.lambdify("numpy")["orbit.r"].names
    text = form.code("python")
    body = text[text.index("def orbit_r(") :].split("\n\n")[0]
    assert "theta_p = " in body
    assert set(body[len("def orbit_r(") : body.index(")")].split(", ")) == set(given)
    with pytest.raises(hjsolve.MissingValueError, match="r_0"):
        form.evaluate("orbit.r", {n: v for n, v in given.items() if n != "r_0"})


def test_names_do_not_meet_letters_of_the_user() -> None:
    """Letters a, k, p, e that a user declares keep their meaning."""
    form = _typed("e*x**2/2", e=2, a=1, omega=3, x="0.5", v="0.1")
    assert {s.name for s in form.where} == {"a_1", "omega_1", "t_p", "chi", "chi_0"}
    agrees_in_time(form, "x")


LETTERS = {
    "Morse": ("D*(1 - exp(-a*x))**2", {"D": 2, "a": "0.8"}), "cosh": ("U*cosh(a*x)", {"U": "1.1", "a": "0.8"}),
    "cosine": ("-U*cos(k*x)", {"U": "1.3", "k": "0.9"}), "cosine of x/b": ("U*(1 - cos(x/b))", {"U": 1, "b": "0.7"}),
    "Morse turned": ("D*(1 - exp(a*x))**2", {"D": 2, "a": "-0.8"}), "sech": ("-U/cosh(a*x)**2", {"U": 1, "a": "0.8"}),
    "tanh": ("U*tanh(a*x)**2", {"U": 1, "a": "0.8"}), "exponential": ("U*exp(a*x)", {"U": "1.2", "a": "0.7"}),
    "Toda": ("U*(exp(a*x) + exp(-2*a*x)/2)", {"U": 1, "a": "0.8"}), "sine": ("U*sin(a*x)**2", {"U": "1.3", "a": "0.8"}),
}  # fmt: skip


@pytest.mark.parametrize("name", LETTERS)
def test_letters_of_either_sign_are_scales_in_exponentials_and_circular_functions(name: str) -> None:
    """Letters without an assumption: the sign that a motion has becomes a condition of its regime."""
    V, letters = LETTERS[name]
    system = hjsolve.System(
        coordinates={"x": "line"}, kinetic="m*dot(x)**2/2", potential=V, parameters={"m": 1, **letters}
    )
    form = own_form(hjsolve.solve(system).motion(q={"x": "0.3"}, velocity={"x": "0.3"}))
    assert form is not None
    assert form.time_law is not None
    assert sp.count_ops(form.inverse["x"]) < 20
    agrees_in_time(form, "x")


IMPLICIT = {
    "Hulthén": ("-U/(exp(a*x) - 1)", "0 < x", {"U": 1, "a": "0.8"}), "Woods and Saxon": (
        "-U/(1 + exp((x - b)/a))", "line", {"U": 1, "a": "0.6", "b": "0.4"}),
    "Rosen and Morse": ("U*tanh(a*x) + c/cosh(a*x)**2", "line", {"U": 1, "a": "0.6", "c": "0.4"}),
    "Eckart": ("U/sinh(a*x)**2 - c/tanh(a*x)", "0 < x", {"U": 1, "a": "0.6", "c": "0.4"}),
    "softened": ("U*sqrt(x**2 + a**2)", "line", {"U": 1, "a": "0.6"}),
    "root": ("U*sqrt(x/a)", "0 < x", {"U": 1, "a": "0.6"}),
}  # fmt: skip


@pytest.mark.parametrize("name", IMPLICIT)
def test_where_t_has_no_inverse_the_time_law_is_the_form(name: str) -> None:
    V, domain, letters = IMPLICIT[name]
    system = hjsolve.System(
        coordinates={"x": domain}, kinetic="m*dot(x)**2/2", potential=V, parameters={"m": 1, **letters}
    )
    solution = hjsolve.solve(system)
    context = context_of(solution)
    form = form_of_sample(context, context.at({}), {}, next(samples(solution, 20, 1)))
    assert form is not None
    assert form.time_law is not None
    start, stop = _places(form, "x")
    example = {s.name: v for s, v in form.regime.example.items()}
    t = _integral(form, form.solution.time_law, example, start, stop)
    _same(form.evaluate("time_law", {**example, "x": stop, "x_0": start}, 45).value, t)


def test_a_periodic_potential_on_a_line_has_the_forms_of_the_angle() -> None:
    """−U cos kx on a line: 4K(k)/ω, and the rotation over one turn 2π/k."""
    system = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "-U*cos(k*x)", {"m": 1, "U": "1.3", "k": "0.9"})
    fast = own_form(hjsolve.solve(system).motion(q={"x": "0.3"}, velocity={"x": 3}))
    slow = own_form(hjsolve.solve(system).motion(q={"x": "0.3"}, velocity={"x": "0.3"}))
    assert fast is not None
    assert slow is not None
    assert fast.regime.kinds["x"] == "rotation"
    assert fast.inverse["x"].has(JacobiAM)
    example = {s.name: v for s, v in fast.regime.example.items()}
    with mpmath.workdps(60):
        T = _period_of(fast, example)
    _same(fast.evaluate("periods.x", example, 45).value, T)


def _period_of(form: RegimeForms, example: Values) -> mpmath.mpf:
    assert form.solution.time_law is not None
    (integral,) = form.solution.time_law.rhs.atoms(sp.Integral)
    q = integral.limits[0][0]
    function = sp.lambdify(
        q, integral.function.xreplace({s: example[s.name] for s in integral.function.free_symbols if s != q}), "mpmath"
    )
    turn = 2 * mpmath.pi / mpmath.mpf("0.9")
    count = 200  # the midpoint rule of a smooth periodic function
    return turn / count * mpmath.fsum(function((k + mpmath.mpf(1) / 2) * turn / count) for k in range(count))


def test_the_separatrix_of_the_pendulum_is_a_tanh() -> None:
    form = next(f for f in forms("pendulum") if f.regime.kinds["theta"] == "asymptotic")
    t, ω, t_p = sp.Symbol("t", real=True), _symbol(form, "omega"), _symbol(form, "t_p")
    assert form.inverse["theta"] == 2 * sp.asin(sp.tanh(ω * (t - t_p)))
    agrees_in_time(form, "theta")


def _started(name: str, which: str = "default") -> tuple[hjsolve.Motion, RegimeForms]:
    motion = hjsolve.solve(name).motion(**hjsolve.catalog.describe(name).motions[which].arguments)
    form = own_form(motion, seconds=None)
    assert form is not None
    return motion, form


@pytest.mark.parametrize(("name", "coordinates"), [
    ("spherical-pendulum", ("phi",)), ("lagrange-top", ("phi", "psi")), ("crossed-fields", ("x", "y", "z")),
])  # fmt: skip
def test_ignorable_coordinates_in_time_over_many_turns(name: str, coordinates: tuple[str, ...]) -> None:
    """φ(t) by Π(ν, am u, k²), x(t) of a cycloid: the same as the motion's, turning points passed many times."""
    entry = hjsolve.catalog.describe(name).motions["default"].arguments
    q = {n: sp.Rational(str(v)) for n, v in entry["q"].items()}
    solution = hjsolve.solve(name)
    motion = solution.motion(**entry)
    if any(motion.initial.values[solution.system.coordinate(n).momentum] < 0 for n in solution.coordinates):
        pytest.skip("the forms are those of the branch p > 0")
    form = own_form(motion)
    assert form is not None
    exact = {p.symbol.name: motion.initial.values[p.symbol] for p in solution.system.parameters}
    exact |= {c.symbol.name: motion.initial.constants[n] for n, c in solution.constants.items()}
    exact |= {limit.name: q[n] for n, limit in solution.lower_limits.items()}
    for t in ("0.7", "5.3", "41"):
        state = motion.at(t)
        for coordinate in coordinates:
            needed = {s.name for s in form.written_out(f"inverse.{coordinate}").free_symbols} | {
                s.name for s in form.regime.example
            }
            betas = {n: -q[coordinate] for n in needed if n.startswith("beta")}
            given = {n: v for n, v in {**exact, **betas, "t": t, "t_0": 0}.items() if n in needed}
            got = form.evaluate(f"inverse.{coordinate}", given, 20)
            expected = (
                float(state.unwrapped(coordinate)) if coordinate in ("phi", "psi") else float(state.q[coordinate])
            )
            assert abs(float(got.value) - expected) <= 4e-12 * max(1, abs(expected)), (t, coordinate)


@pytest.mark.nightly
def test_reports_deny_no_form_that_exists() -> None:
    """(7-185), Sommerfeld's E(J), r(t) of a free particle: each was called without a form."""
    _, hyperbolic = _started("constant-proper-acceleration")
    assert any(e.exp == sp.S.Half for e in hyperbolic.inverse["x"].atoms(sp.Pow))
    agrees_in_time(hyperbolic, "x")
    _, rosette = _started("relativistic-kepler")
    assert rosette.energy is not None
    J_r, J_θ = (sp.Symbol(f"J_{q}", real=True) for q in ("r", "theta"))
    c, m, k = (next(s for s in rosette.regime.example if s.name == n) for n in ("c", "m0", "k"))
    printed = m * c**2 / sp.sqrt(1 + k**2 / (c * J_r + sp.sqrt(c**2 * J_θ**2 - k**2)) ** 2)
    at = {
        J_r: sp.Rational(1, 3),
        J_θ: sp.Rational(6, 5),
        c: sp.Rational(7, 2),
        m: sp.Rational(11, 10),
        k: sp.Rational(9, 8),
    }
    assert abs(sp.N((rosette.energy - printed).xreplace(at), 50)) < sp.Float(10) ** -42
    assert sp.count_ops(rosette.energy) < 25
    _, free = _started("free-particle-spherical")
    assert "r" in free.inverse
    agrees_in_time(free, "r")
