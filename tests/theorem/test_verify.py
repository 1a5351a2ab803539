"""Complete integrals by hand: right, wrong by a factor, a sign or 1e-9, with dependent constants; no wrong verdict."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.system import parameter

LINE = {"x": "line"}
OSCILLATOR = hjsolve.System(LINE, "m/2*dot(x)**2", "k/2*x**2", {"m": 1, "k": 1})
UNIT_OSCILLATOR = hjsolve.System(LINE, "dot(x)**2/2", "x**2/2")
FALL = hjsolve.System({"y": "line"}, "m/2*dot(y)**2", "m*g*y", {"m": 1, "g": "9.81"})
FREE = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", 0, {"m": 1})
PROJECTILE = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", "m*g*y", {"m": 1, "g": 1})
TUBE = hjsolve.System({"q": "line"}, "m/2*((dot(q) + v)**2)", "k/2*q**2", {"m": 1, "k": 1, "v": 1})


@dataclass(frozen=True)
class Case:
    """A complete integral and a sign that may be mistaken in it."""

    system: object
    formula: dict[str, str]
    constants: object
    sign: tuple[str, str]
    more: dict[str, str] = field(default_factory=dict)


RIGHT = {
    "oscillator (5-93)": Case(OSCILLATOR, {"W": "integral(sqrt(2*m*E - m*k*x**2), x)"}, "E", ("- m*k", "+ m*k")),
    "oscillator in closed form": Case(
        UNIT_OSCILLATOR, {"W": "x/2*sqrt(2*E - x**2) + E*asin(x/sqrt(2*E))"}, {"E": "0 < E"}, ("+ E", "- E")
    ),
    "oscillator from place to place (5-108)": Case(
        OSCILLATOR, {"S": "sqrt(m*k)/2*((x**2 + a**2)*cos(sqrt(k/m)*t) - 2*x*a)/sin(sqrt(k/m)*t)"}, "a",
        ("+ a**2", "- a**2"),
    ),
    "fall from place to place, Ex 6-6": Case(
        FALL, {"S": "m*(y - a)**2/(2*t) - m*g*t*(y + a)/2 - m*g**2*t**3/24"}, ["a"], ("- m*g**2", "+ m*g**2")
    ),
    "fall": Case(FALL, {"W": "-(2*m*(E - m*g*y))**(3/2)/(3*m**2*g)"}, "E", ("E - m", "E + m")),
    "free particle, momenta as constants": Case(
        FREE, {"W": "a*x + b*y"}, "a, b", ("a**2 + b", "a**2 - b"), {"energy": "(a**2 + b**2)/(2*m)"}
    ),
    "free particle in plane from place to place": Case(
        FREE, {"S": "m*((x - a)**2 + (y - b)**2)/(2*t)"}, "a, b", ("+ (y", "- (y")
    ),
    "projectile (P5-4)": Case(
        PROJECTILE, {"W": "a*x + integral(sqrt(2*m*E - a**2 - 2*m**2*g*y), y)"}, ("E", "a"), ("- a**2", "+ a**2")
    ),
    "frame that moves (Ex 6-5)": Case(
        TUBE, {"W": "m*v*q + integral(sqrt(2*m*(E - k*q**2/2 + m*v**2/2)), q)"}, "E", ("+ m*v**2/2", "- m*v**2/2")
    ),
    "H = q + p (P5-1)": Case(
        hjsolve.from_hamiltonian("q + p", {"q": "line"}), {"S": "-alpha*t + alpha*q - q**2/2"}, "alpha",
        ("- q**2", "+ q**2"),
    ),
    "Kepler, plane (5-118)": Case(
        "kepler-planar", {"W": "a*theta + integral(sqrt(2*m*(E + k/r) - a**2/r**2), r)"}, "E, a",
        ("- a**2", "+ a**2"),
    ),
    "Kepler, spherical (Ex 5-3)": Case(
        "kepler-spherical",
        {"W": "c*phi + integral(sqrt(b**2 - c**2/sin(theta)**2), theta)"
              " + integral(sqrt(2*m*(E + k/r) - b**2/r**2), r)"},
        "E, b, c", ("b**2 - c", "b**2 + c"),
    ),
    "spherical pendulum (2-218)": Case(
        hjsolve.System({"theta": "0 < theta < pi", "phi": "angle"},
                       "m*l**2/2*(dot(theta)**2 + sin(theta)**2*dot(phi)**2)", "-m*g*l*cos(theta)",
                       {"m": 1, "l": 1, "g": 1}),
        {"W": "c*phi + integral(sqrt(2*m*l**2*(E + m*g*l*cos(theta)) - c**2/sin(theta)**2), theta)"},
        "E, c", ("- c**2", "+ c**2"),
    ),
    "geodesics of a sphere (Ex 4-3)": Case(
        hjsolve.System({"theta": "0 < theta < pi", "phi": "angle"}, "r**2/2*(dot(theta)**2 + sin(theta)**2*dot(phi)**2)",
                       0, {"r": 1}),
        {"W": "c*phi + integral(sqrt(2*r**2*E - c**2/sin(theta)**2), theta)"}, "E, c", ("- c**2", "+ c**2"),
    ),
    "relativistic particle in a plane": Case(
        hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", 0,
                       {name: parameter(name, 1, assume="positive") for name in ("m", "c")},
                       relativity={"mass": "m", "light": "c"}),
        {"W": "a*x + b*y"}, "a, b", ("a**2 +", "a**2 -"), {"energy": "c*sqrt(m**2*c**2 + a**2 + b**2)"},
    ),
    "sum that is not separated": Case(
        FREE, {"S": "m*(x*cos(b) + y*sin(b))*a - m*a**2*t/2"}, "a, b", ("y*sin", "2*y*sin")
    ),
}  # fmt: skip


def _answer(name: str, formula: dict[str, str], **changes: object) -> object:
    case = RIGHT[name]
    return hjsolve.verify(case.system, **{**formula, **case.more, "constants": case.constants, **changes})


@pytest.mark.parametrize("name", RIGHT)
def test_a_complete_integral_is_proved(name: str) -> None:
    answer = _answer(name, RIGHT[name].formula)
    assert isinstance(answer, hjsolve.CompleteIntegral), str(answer)
    assert answer.determinant != 0
    assert len(answer.equations) == len(answer.constants) == len(answer.momenta)


@pytest.mark.parametrize("name", RIGHT)
def test_a_factor_is_seen(name: str) -> None:
    formula = {key: f"2*({text})" for key, text in RIGHT[name].formula.items()}
    answer = _answer(name, formula)
    assert isinstance(answer, hjsolve.Flaw)
    assert answer.part == "equation"
    assert answer.witness.excludes_zero


@pytest.mark.parametrize("name", RIGHT)
def test_a_billionth_is_seen(name: str) -> None:
    coordinate = _first(RIGHT[name].system)
    formula = {key: f"{text} + 0.000000001*{coordinate}" for key, text in RIGHT[name].formula.items()}
    answer = _answer(name, formula)
    assert isinstance(answer, hjsolve.Flaw)
    assert answer.part == "equation"


@pytest.mark.parametrize("name", RIGHT)
def test_a_sign_is_seen(name: str) -> None:
    case = RIGHT[name]
    key, text = next(iter(RIGHT[name].formula.items()))
    wrong, more = text.replace(*case.sign), {k: v.replace(*case.sign) for k, v in case.more.items()}
    assert (wrong, more) != (text, case.more)
    answer = _answer(name, {key: wrong}, **more)
    assert isinstance(answer, hjsolve.Flaw)
    assert answer.part == "equation"


@pytest.mark.parametrize("name", RIGHT)
def test_dependent_constants_are_seen(name: str) -> None:
    """The last constant becomes a number and is added to S: still a solution, no longer a complete one."""
    case = RIGHT[name]
    right = _answer(name, RIGHT[name].formula)
    last = sp.Symbol(right.constants[-1], real=True)
    S = right.principal_function
    (own,) = [s for s in S.free_symbols if s.name == last.name] or [last]
    answer = hjsolve.verify(case.system, S=S.subs(own, sp.Rational(7, 3)) + own, constants=case.constants)
    assert isinstance(answer, hjsolve.Flaw)
    assert answer.part == "determinant"


def _first(system: object) -> str:
    if isinstance(system, str):
        system = hjsolve.catalog.load(system)
    return system.coordinates[0].name


def test_both_signs_of_the_root_are_complete_integrals() -> None:
    """H is even in p, so −W solves as well: no flaw may be reported."""
    assert isinstance(
        _answer("oscillator (5-93)", {"W": "-integral(sqrt(2*m*E - m*k*x**2), x)"}), hjsolve.CompleteIntegral
    )


def test_the_constants_of_jacobis_equations_stay_constant_along_a_motion() -> None:
    """−β = ∂S/∂α of the closed form, on hjsolve's own motion, which is computed without it."""
    answer = _answer("oscillator in closed form", RIGHT["oscillator in closed form"].formula)
    motion = hjsolve.solve(UNIT_OSCILLATOR).motion(q={"x": 0}, velocity={"x": 1})
    law, times = answer.equations["E"], (0.25, 0.5, 1.0)
    betas = []
    for time in times:
        values = {
            s: v
            for s in law.free_symbols
            for n, v in {"x": float(motion.at(time).q["x"]), "E": 0.5}.items()
            if s.name == n
        }
        betas.append(time - float(law.rhs.subs(values)))
    assert betas == pytest.approx([0.0] * 3, abs=1e-14)


def test_too_few_constants_are_a_flaw_and_too_many_an_error() -> None:
    few = hjsolve.verify(FREE, W="sqrt(2*m*E)*x", constants="E")
    assert isinstance(few, hjsolve.Flaw)
    assert few.part == "constants"
    with pytest.raises(hjsolve.InvalidInputError, match="additive"):
        hjsolve.verify(OSCILLATOR, W="integral(sqrt(2*m*E - m*k*x**2), x) + c", constants="E, c")


@pytest.mark.parametrize(("call", "message"), [
    ({"W": "x", "S": "x", "constants": "E"}, "one of them"),
    ({"W": "x", "constants": "a"}, "energy"),
    ({"W": "x", "constants": "a", "energy": "x*a"}, "depends on x"),
    ({"W": "x", "constants": "x"}, "means something already"),
    ({"W": "x", "constants": 3}, "names are needed"),
    ({"W": "integral(x)", "constants": "E"}, "lower limit"),
    ({"W": "integral(x, x", "constants": "E"}, "closing"),
    ({"W": "x*t", "constants": "E"}, "t"),
    ({"W": [1], "constants": "E"}, "text"),
])  # fmt: skip
def test_input_that_cannot_be_used(call: dict[str, object], message: str) -> None:
    with pytest.raises(hjsolve.HJSolveError, match=message):
        hjsolve.verify(OSCILLATOR, **call)


def test_an_integral_that_is_left_proves_nothing() -> None:
    """W is not a sum: its slope in y holds an integral over x that nothing evaluates."""
    x, y, E, a = sp.symbols("x y E a", real=True)
    answer = hjsolve.verify(FREE, W=sp.Integral(sp.sqrt(E + a * x * y), x), constants="E, a")
    assert isinstance(answer, hjsolve.Undecided)
    assert "closed form" in answer.advice


def test_a_lower_limit_and_sympys_integral() -> None:
    x, xi, E, m, k = sp.symbols("x xi E m k")
    W = sp.Integral(sp.sqrt(2 * m * E - m * k * xi**2), (xi, sp.sqrt(2 * E / k), x))
    assert isinstance(hjsolve.verify(OSCILLATOR, W=W, constants="E"), hjsolve.CompleteIntegral)
    for text in ("Integral(sqrt(2*m*E - m*k*x**2), (x, 0, x))", "integrate(sqrt(2*m*E - m*k*x**2), x)"):
        assert isinstance(hjsolve.verify(OSCILLATOR, W=text, constants="E"), hjsolve.CompleteIntegral)
    with pytest.raises(hjsolve.ExpressionError, match="its upper limit is q, not 1"):
        hjsolve.verify(OSCILLATOR, W="Integral(sqrt(2*m*E - m*k*x**2), (x, 0, 1))", constants="E")


MOMENTA = {
    "fall": (FALL, "p_y**3/(6*m**2*g) - E*p_y/(m*g)", "E", ("- E", "+ E")),
    "oscillator, P6-8": (UNIT_OSCILLATOR, "-integral(sqrt(2*E - p_x**2), p_x)", "E", ("- p_x", "+ p_x")),
    "projectile": (PROJECTILE, "p_y**3/(6*m**2*g) + p_x**2*p_y/(2*m**2*g) - E*p_y/(m*g) - a*p_x", "E, a",
                   ("+ p_x**2", "- p_x**2")),
}  # fmt: skip


@pytest.mark.parametrize("name", ["fall", "oscillator, P6-8"])
def test_a_complete_integral_in_the_momenta(name: str) -> None:
    """H(-dF4/dp, p) = E (6-83); q = -dF4/dp along a motion that is computed without it."""
    system, F4, constants, sign = MOMENTA[name]
    answer = hjsolve.verify(system, F4=F4, constants=constants)
    assert isinstance(answer, hjsolve.CompleteIntegral), str(answer)
    assert answer.momenta == {}
    wrong = hjsolve.verify(system, F4=F4.replace(*sign), constants=constants)
    assert isinstance(wrong, hjsolve.Flaw)
    assert wrong.part == "equation"
    assert wrong.witness.excludes_zero
    coordinate = _first(system)
    motion = hjsolve.solve(system).motion(q={coordinate: "1/3"}, velocity={coordinate: "1/2"})
    (place,) = answer.places.values()
    for t in (0, 0.3):
        state = motion.at(t)
        known = {"E": motion.constants["E"].value, f"p_{coordinate}": state.p[coordinate]}
        known |= {p.name: p.value for p in system.parameters}
        value = float(place.subs({s: known[s.name] for s in place.free_symbols}))
        assert abs(value - state.q[coordinate]) < 1e-13
    with pytest.raises(hjsolve.InvalidInputError, match="function of the momenta"):
        answer.along(motion)


def test_a_projectile_in_the_momenta() -> None:
    """x = a - p_x p_y/(m**2 g): with p_x constant and p_y = -m g t the place at the top is the constant a."""
    system, F4, constants, _ = MOMENTA["projectile"]
    answer = hjsolve.verify(system, F4=F4, constants=constants)
    assert isinstance(answer, hjsolve.CompleteIntegral)
    assert sp.simplify(answer.determinant**2 * system.symbols["g"] ** 2 * system.symbols["m"] ** 2) == 1
    with pytest.raises(hjsolve.InvalidInputError, match="one of them"):
        hjsolve.verify(system, F4="p_x", W="x", constants=constants)
