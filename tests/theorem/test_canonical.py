"""The canonical maps of Greenwood's chapter 6 by name, and wrong ones; brackets and integrals of the motion."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
import sympy as sp

import hjsolve


@dataclass(frozen=True)
class Map:
    """A map of the book: what ``canonical`` takes, and what it must find, formulas as text."""

    given: dict[str, object]
    functions: dict[str, str] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    added: str | None = None
    K: str | None = None
    valence: str = "1"


QUARTER = "0 < p < pi/2"
BOOK = {
    "Ex 6-1": Map(
        {"map": {"Q": "(q**2 + p**2)/2", "P": "-atan(q/p)"}, "domains": {"q": "0 < q", "p": "0 < p"},
         "hamiltonian": "(q**2 + p**2)/2"},
        {"F1": "Q*asin(q/sqrt(2*Q)) + q*sqrt(2*Q - q**2)/2", "F2": "-q**2/(2*tan(P))"}, (), "0", "Q",
    ),
    "Ex 6-2": Map(
        {"map": {"Q": "sqrt(2*q)*exp(t)*cos(p)", "P": "sqrt(2*q)*exp(-t)*sin(p)"},
         "domains": {"q": "0 < q", "p": QUARTER}},
        {"F3": "-Q**2*exp(-2*t)*tan(p)/2", "F4": "P**2*exp(2*t)/(2*tan(p))"}, (), "2*q*sin(p)*cos(p)",
    ),
    "Ex 6-5, a Galilean frame": Map(
        {"map": {"Q": "tan(q)", "P": "(p - m*v)*cos(q)**2"}, "parameters": "m, v",
         "domains": {"q": "-pi/2 < q < pi/2"}},
        {"F2": "P*tan(q) + m*v*q"}, ("F1",), "0",
    ),
    "Ex 6-5, a frame that moves": Map(
        {"generating": {"F2": "(P + m*v)*q"}, "parameters": "m, v, k", "hamiltonian": "p**2/(2*m) - v*p + k*q**2/2"},
        {"F2": "(P + m*v)*q"}, ("F1", "F4"), "0", "(P + m*v)**2/(2*m) - v*(P + m*v) + k*Q**2/2",
    ),
    "Ex 6-6, the initial values of free fall": Map(
        {"map": {"Q": "q - p*t + g*t**2/2", "P": "p - g*t"}, "parameters": "g", "domains": {},
         "hamiltonian": "p**2/2 - g*q"},
        {"F1": "(q - Q)**2/(2*t) + g*t*(q + Q)/2"}, ("F4",),
    ),
    "Ex 6-8, valence one half": Map(
        {"map": {"Q": "sqrt(q)*cos(p)", "P": "sqrt(q)*sin(p)"}, "domains": {"q": "0 < q", "p": QUARTER},
         "hamiltonian": "p**2/(2*m) + k*q**2/2", "parameters": "m, k"},
        {"F3": "-Q**2*tan(p)/2"}, (), "0", "atan(P/Q)**2/(4*m) + k*(Q**2 + P**2)**2/4", "1/2",
    ),
    "Ex 6-9, a moving anchor": Map(
        {"map": {"Q": "q - t", "P": "p - m"}, "hamiltonian": "p**2/(2*m) + k*(t - q)**2/2", "parameters": "m, k"},
        {}, ("F1", "F4"), None, "P**2/(2*m) + k*Q**2/2 + m/2",
    ),
    "Ex 6-10": Map({"map": {"Q": "a*q", "P": "b*p"}, "parameters": "a, b"}, {"F2": "a*P*q"}, ("F1", "F4"), "0", None,
                   "a*b"),
    "P6-1": Map(
        {"map": {"Q": "sqrt(q**2 + p**2)", "P": "-sqrt(q**2 + p**2)*atan(q/p)"},
         "domains": {"q": "0 < q", "p": "0 < p"}},
        {"F1": "Q**2*asin(q/Q)/2 + q*sqrt(Q**2 - q**2)/2"}, (), "0",
    ),
    "P6-2": Map(
        {"map": {"Q": "sin(q)", "P": "(p - m*v)/cos(q)"}, "parameters": "m, v", "domains": {"q": "-pi/2 < q < pi/2"}},
        {"F2": "m*v*q + P*sin(q)", "F3": "(m*v - p)*asin(Q)"}, ("F1",), "0",
    ),
    "P6-3": Map(
        {"generating": {"F2": "x*y*P1 + (x**2 - y**2)/2*P2"}, "coordinates": {"x": "px", "y": "py"},
         "new": {"Q1": "P1", "Q2": "P2"}, "domains": {"x": "0 < x", "y": "0 < y"}, "parameters": "m, k",
         "hamiltonian": "(px**2 + py**2)/(2*m) + k*y"},
        {"F2": "x*y*P1 + (x**2 - y**2)/2*P2"}, ("F1",), "0",
        "sqrt(Q1**2 + Q2**2)*(P1**2 + P2**2)/m + k*sqrt(sqrt(Q1**2 + Q2**2) - Q2)",
    ),
    "P6-4": Map(
        {"generating": {"F2": "(P1 + v)*(q1 - v*t) + P2**2*exp(-2*t)*tan(q2)/2"}, "new": {"Q1": "P1", "Q2": "P2"},
         "coordinates": {"q1": "p1", "q2": "p2"}, "domains": {"q2": "-pi/2 < q2 < pi/2", "p2": "0 < p2"},
         "parameters": "v", "hamiltonian": "(p1**2 + p2**2 + q1**2)/2"},
        {}, (), None,
        "P1**2/2 - v**2/2 - Q2*P2 + (Q2**2*exp(2*t) + P2**2*exp(-2*t))**2/8 + (Q1 + v*t)**2/2",
    ),
    "P6-5": Map(
        {"map": {"Q": "sqrt(2*q)*exp(t)*cos(p)", "P": "sqrt(2*q)*exp(-t)*sin(p)"}, "hamiltonian": "(q**2 + p**2)/2",
         "domains": {"q": "0 < q", "p": QUARTER}},
        {}, (), None, "(Q**2*exp(-2*t) + P**2*exp(2*t))**2/8 + atan(P*exp(2*t)/Q)**2/2 + Q*P",
    ),
    "P6-6": Map(
        {"map": {"Q": "q*cos(2*p)**2", "P": "tan(2*p)/2"}, "domains": {"q": "0 < q", "p": "0 < p < pi/4"}},
        {"F1": "q*acos(sqrt(Q/q))/2 - sqrt(Q*(q - Q))/2"}, ("F4",), "0",
    ),
    "P6-8, the oscillator by F2": Map(
        {"generating": {"F2": "P*asin(q/sqrt(2*P)) + q*sqrt(2*P - q**2)/2"}, "domains": {"q": "0 < q", "p": "0 < p"},
         "hamiltonian": "(q**2 + p**2)/2"},
        {"F1": "q**2/(2*tan(Q))"}, (), "0", "P",
    ),
    "P6-10": Map(
        {"map": {"Q1": "q1 - v*t", "Q2": "sqrt(2*q2)*exp(t)*cos(p2)", "P1": "p1 - v", "P2": "sqrt(2*q2)*exp(-t)*sin(p2)"},
         "domains": {"q2": "0 < q2", "p2": "0 < p2 < pi/2"}, "parameters": "v"},
        {}, ("F1", "F4"), None,
    ),
    "P6-11, turning axes": Map(
        {"map": {"Q1": "q1*cos(w*t) + q2*sin(w*t)", "Q2": "-q1*sin(w*t) + q2*cos(w*t)",
                 "P1": "p1*cos(w*t) + p2*sin(w*t)", "P2": "-p1*sin(w*t) + p2*cos(w*t)"}, "parameters": "w",
         "hamiltonian": "(p1**2 + p2**2)/2"},
        {}, ("F1", "F4"), "w*(q2*p1 - q1*p2)", "(P1**2 + P2**2)/2 + w*(Q2*P1 - Q1*P2)",
    ),
    "P6-14, the map of P6-3": Map(
        {"map": {"Q1": "x*y", "Q2": "(x**2 - y**2)/2", "P1": "(y*px + x*py)/(x**2 + y**2)",
                 "P2": "(x*px - y*py)/(x**2 + y**2)"},
         "coordinates": {"x": "px", "y": "py"}, "domains": {"x": "0 < x", "y": "0 < y"}},
        {}, ("F1",), "0",
    ),
    "a logarithm (Goldstein 9-8)": Map(
        {"map": {"Q": "log(sin(p)/q)", "P": "q*cos(p)/sin(p)"}, "domains": {"q": "0 < q", "p": QUARTER}},
        {"F1": "q*asin(q*exp(Q)) + sqrt(exp(-2*Q) - q**2)"}, (), "0",
    ),
    "an orthogonal point transformation": Map(
        {"generating": {"F2": "P1*(3*q1 + 4*q2)/5 + P2*(-4*q1 + 3*q2)/5"}, "coordinates": {"q1": "p1", "q2": "p2"},
         "new": {"Q1": "P1", "Q2": "P2"}, "hamiltonian": "(p1**2 + p2**2)/2 + q1"},
        {"F2": "P1*(3*q1 + 4*q2)/5 + P2*(-4*q1 + 3*q2)/5"}, ("F1", "F4"), "0",
        "(P1**2 + P2**2)/2 + (3*Q1 - 4*Q2)/5",
    ),
}  # fmt: skip
QUICK = ("Ex 6-5, a frame that moves", "Ex 6-9, a moving anchor", "Ex 6-10", "P6-11, turning axes")


def _plain(x: sp.Expr | str) -> sp.Expr:
    """The same formula in symbols without assumptions, for comparing."""
    text = x if isinstance(x, str) else sp.sstr(x)
    names = sp.sympify(text).free_symbols if "Q" not in text and "E" not in text else set()
    letters = {n: sp.Symbol(n) for n in ("Q", "P", "E", "S", "N", *map(str, names))}
    return sp.sympify(text, locals=letters)


def _values(names: set[sp.Symbol], number: int) -> dict[sp.Symbol, sp.Rational]:
    return {s: sp.Rational(7 + 5 * i + number, 23 + 3 * number) for i, s in enumerate(sorted(names, key=str))}


@pytest.mark.nightly_cases(*[name for name in BOOK if name not in QUICK])
@pytest.mark.parametrize("name", BOOK)
def test_a_map_of_the_book(name: str) -> None:
    book = BOOK[name]
    answer = hjsolve.canonical(**book.given)
    assert isinstance(answer, hjsolve.CanonicalMap), str(answer)
    assert _plain(answer.valence) == _plain(book.valence)
    assert set(book.missing) <= set(answer.why_not)
    back = {sp.Symbol(n): _plain(f) for n, f in answer.map.items()}
    n = len(back) // 2
    Z = sp.Matrix(sp.BlockMatrix([[sp.zeros(n), sp.eye(n)], [-sp.eye(n), sp.zeros(n)]]))
    M = answer.jacobian.applyfunc(_plain)
    symplectic = M.T * Z * M - _plain(answer.valence) * Z
    checks = [*symplectic]
    if book.added is not None:
        checks.append(_plain(answer.added_hamiltonian) - _plain(book.added))
    if book.K is not None:
        checks.append(_plain(answer.hamiltonian) - _plain(book.K).subs(back))
    for kind, text in book.functions.items():
        difference = _plain(answer.generating[kind]) - _plain(text)  # it may be a function of the time, or a constant
        checks += [sp.diff(difference, s).subs(back) for s in difference.free_symbols if s.name[0] in "qpQPxy"]
    for number in range(3):
        point = _values(set().union(*(c.free_symbols for c in checks)), number)
        for check in checks:
            assert abs(sp.N(check.subs(point), 30, chop=True)) < 1e-25, (name, check)


@pytest.mark.nightly
def test_a_valence_is_a_constant_even_where_its_formula_does_not_look_so() -> None:
    """Goldstein, Poole and Safko, Classical Mechanics (2002), problem 9.4: (Q, P) = (√q + q cos p)/(√q (1 + √q cos p))."""
    root = "(1 + sqrt(q)*cos(p))"
    answer = hjsolve.canonical({"Q": f"log{root}", "P": f"2*{root}*sqrt(q)*sin(p)"}, domains={"q": "0 < q"})
    assert answer.valence == 1
    twice = hjsolve.canonical(
        {"Q": f"log{root}", "P": f"6*k*{root}*sqrt(q)*sin(p)"}, domains={"q": "0 < q"}, parameters="k"
    )
    assert str(twice.valence) == "3*k"


WRONG = {
    "a bracket of two coordinates": ({"Q1": "q1", "Q2": "q2 + p1", "P1": "p1", "P2": "p2"}, "brackets"),
    "a bracket with another momentum": ({"Q1": "q1 + q2", "Q2": "q2", "P1": "p1", "P2": "p2"}, "brackets"),
    "two valences": ({"Q1": "2*q1", "Q2": "3*q2", "P1": "p1", "P2": "p2"}, "brackets"),
    "a valence that is not a constant": ({"Q": "q*p", "P": "p"}, "valence"),
    "a valence that changes with the time": ({"Q": "t*q", "P": "p"}, "valence"),
    "dependent variables": ({"Q": "q + p", "P": "(q + p)**2"}, "valence"),
    "a sign": ({"Q": "atan(q/p)", "P": "(q**2 - p**2)/2"}, "valence"),
    "a billionth": ({"Q": "q + 0.000000001*p*q", "P": "p"}, "valence"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_map_that_is_not_canonical(name: str) -> None:
    formulas, part = WRONG[name]
    answer = hjsolve.canonical(formulas)
    assert isinstance(answer, hjsolve.Flaw)
    assert answer.part == part
    assert not answer
    assert answer.witness is None or answer.witness.excludes_zero


@pytest.mark.parametrize(("call", "message"), [
    ({}, "one of them"),
    ({"map": {"Q": "q"}}, "as many momenta"),
    ({"map": {"q": "q", "P": "p"}}, "old variable"),
    ({"map": {"Q": "q", "P": "x"}}, "x"),
    ({"map": {"Q": "q", "P": "p"}, "domains": {"x": "0 < x"}}, "not one of"),
    ({"map": {"Q": "q", "P": "p"}, "coordinates": {"q": "q"}}, "two variables"),
    ({"map": {"Q": "q", "P": "p"}, "coordinates": {"q": "0 < q"}}, '"0 < q" belongs in domains'),
    ({"generating": {"F5": "q*Q"}}, "F1, F2, F3, F4"),
    ({"generating": {"F1": "q*P"}}, "P"),
    ({"generating": {"F2": "q + P"}}, "could not be solved"),
])  # fmt: skip
def test_input_that_cannot_be_used(call: dict[str, object], message: str) -> None:
    with pytest.raises(hjsolve.HJSolveError, match=message):
        hjsolve.canonical(**call)


SPACE = hjsolve.System(
    {"x": "line", "y": "line", "z": "line"}, "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)", "-k/sqrt(x**2 + y**2 + z**2)",
    {"m": 1, "k": 1},
)  # fmt: skip
L = {"x": "(y*p_z - z*p_y)", "y": "(z*p_x - x*p_z)", "z": "(x*p_y - y*p_x)"}
LENZ = f"p_y*{L['z']} - p_z*{L['y']} - m*k*x/sqrt(x**2 + y**2 + z**2)"


def test_brackets_of_angular_momenta() -> None:
    """(L_x, L_y) = L_z (6-212), and none of them changes in a central field."""
    x, y = (SPACE.coordinate(n) for n in "xy")
    assert hjsolve.poisson_bracket(L["x"], L["y"], SPACE) == x.symbol * y.momentum - y.symbol * x.momentum
    assert hjsolve.poisson_bracket(L["x"], "H", SPACE) == 0
    assert hjsolve.poisson_bracket("x", "p_x", SPACE) == 1
    assert hjsolve.poisson_bracket("x", "dot(x)", SPACE) == 1 / SPACE.symbols["m"]


def test_poissons_theorem() -> None:
    """The bracket of two integrals is one: of the Lenz vector and L_z."""
    both = hjsolve.poisson_bracket(LENZ, L["z"], SPACE)
    assert both != 0
    assert hjsolve.is_integral(both, SPACE)


INTEGRALS = [
    (LENZ, SPACE, True),
    (f"{LENZ} + 0.000000001*x", SPACE, False),
    ("H", SPACE, True),
    ("m*(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", SPACE, False),
    ("q - t", hjsolve.from_hamiltonian("q + p", {"q": "line"}), True),
    ("q - 2*t", hjsolve.from_hamiltonian("q + p", {"q": "line"}), False),
    ("p_theta", "kepler-planar", True),
    ("atan(x/p_x) - t", hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2"), True),
    ("atan(x/p_x) - 2*t", hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2"), False),
    ("x - t*dot(x) - g*t**2/2", hjsolve.System({"x": "line"}, "dot(x)**2/2", "g*x", {"g": 1}), True),
]


@pytest.mark.parametrize(("f", "system", "right"), INTEGRALS)
def test_integrals_of_the_motion(f: str, system: object, right: bool) -> None:
    answer = hjsolve.is_integral(f, system)
    assert isinstance(answer, hjsolve.Proof if right else hjsolve.Flaw), str(answer)
    assert bool(answer) is right
