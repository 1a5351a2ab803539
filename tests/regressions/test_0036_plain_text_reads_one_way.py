"""A formula in plain text can be read back, whatever its letters are called.

V = k/(d (x + 1)) was printed as k/d (x + 1) when a parameter was called d: a row that began with that letter was taken
for a differential and lost its brackets. Here a strict reader that knows nothing of the writer reads every text back.
"""

from __future__ import annotations

import re
import unicodedata

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.reports.formulas.from_sympy import box, constants_outside
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain

NAMES = [
    "d",
    "e",
    "E",
    "i",
    "partial",
    "Delta",
    "Pi",
    "dx",
    "dd",
    "ln",
    "arcsin",
    "p_d",
    "x1",
    "d_e",
    "theta",
    "GM",
    "t_",
    "n",
    "T",
]
LETTERS = {plain(name_box(name)): name for name in NAMES} | {
    plain(name_box(f"dot({n})")): f"dot({n})" for n in ("d", "theta")
}
SYMBOLS = {name: sp.Symbol(name, positive=True) for name in [*NAMES, "dot(d)", "dot(theta)"]}
CALLS = {"ln": sp.log, "arcsin": sp.asin, "sin": sp.sin, "cosh": sp.cosh, "exp": sp.exp, "artanh": sp.atanh}
SMALL = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ⁿᵀ", "0123456789−+nT"))
VULGAR = {"½": "1/2", "⅓": "1/3", "¼": "1/4", "¾": "3/4", "⅔": "2/3", "⅛": "1/8", "⅙": "1/6"}


class Reader:
    """Sums of products, a blank between factors; after a slash one factor and nothing more; f takes one letter."""

    def __init__(self, text: str) -> None:
        self.text, self.place = unicodedata.normalize("NFC", text), 0

    def whole(self) -> sp.Expr:
        value = self.sum()
        assert self.place == len(self.text), f"{self.text!r}: left over from {self.place}: {self.text[self.place :]!r}"
        return value

    def at(self, *words: str) -> str:
        for word in words:
            if self.text.startswith(word, self.place):
                self.place += len(word)
                return word
        return ""

    def sum(self) -> sp.Expr:
        value = -self.product() if self.at("−") else self.product()
        while sign := self.at(" + ", " − "):
            value = value + self.product() if sign == " + " else value - self.product()
        return value

    def product(self) -> sp.Expr:
        value = self.factor()
        while True:
            if self.at("/"):
                value /= self.factor()
                rest = self.text[self.place : self.place + 2]
                assert re.match(r"$|[);,\]|]| [+−d]", rest), f"{self.text!r}: {rest!r} after a quotient"
                return value
            mark = self.place
            if not self.at("⋅", " ") or self.text[self.place : self.place + 1] in ("+", "−", ""):
                self.place = mark
                return value
            if self.integrand and self.text.startswith(self.integrand, self.place):
                self.place = mark
                return value
            value *= self.factor()

    integrand = ""

    def factor(self) -> sp.Expr:
        return self.raised(self.atom())

    def raised(self, value: sp.Expr) -> sp.Expr:
        if self.at("^("):
            power = self.sum()
            assert self.at(")")
            return value**power
        if self.at("^"):
            return value ** self.letter()
        digits = re.match("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ⁿᵀ]+", self.text[self.place :])
        if not digits:
            return value
        self.place += len(digits.group())
        inner = Reader("".join(SMALL[c] for c in digits.group()))
        return value ** inner.whole()

    def atom(self) -> sp.Expr:
        if any(self.text.startswith(shown, self.place) for shown in LETTERS if shown[0] == "("):
            return self.letter()
        if self.at("("):
            outer, self.integrand = self.integrand, ""
            value = self.sum()
            assert self.at(")"), self.text[self.place :]
            self.integrand = outer
            return value
        if self.at("√"):
            return sp.sqrt(self.atom())
        if root := self.at("∛"):
            return sp.cbrt(self.atom()) if root else sp.nan
        if self.at("∫["):
            lower = self.sum()
            assert self.at(", ")
            upper = self.letter()
            assert self.at("] ")
            self.integrand = f"d{plain(box(upper))}"
            value = self.sum()
            assert self.at(f" {self.integrand}"), self.text[self.place :]
            self.integrand = ""
            return sp.Integral(value, (upper, lower, upper))
        if self.text[self.place] in VULGAR:
            self.place += 1
            return sp.Rational(VULGAR[self.text[self.place - 1]])
        if number := re.match(r"\d+", self.text[self.place :]):
            self.place += len(number.group())
            return sp.Integer(number.group())
        for name in sorted(CALLS, key=len, reverse=True):
            if re.match(rf"{name}[ (²³⁴⁵⁶⁷⁸⁹¹⁰]", self.text[self.place :]):
                return self.call(name)
        return self.letter()

    def call(self, name: str) -> sp.Expr:
        self.place += len(name)
        power = self.raised(sp.Symbol("POWER"))
        if not self.at(" "):
            assert self.text[self.place] == "("
        argument = self.atom()
        return CALLS[name](argument) ** (power.exp if power.is_Pow else 1)

    def letter(self) -> sp.Symbol:
        found = [shown for shown in LETTERS if self.text.startswith(unicodedata.normalize("NFC", shown), self.place)]
        assert found, f"{self.text!r}: no letter at {self.text[self.place :]!r}"
        longest = max(found, key=len)
        self.place += len(unicodedata.normalize("NFC", longest))
        return SYMBOLS[LETTERS[longest]]


symbols = st.sampled_from(sorted(SYMBOLS.values(), key=str))
numbers = st.fractions(min_value=-9, max_value=9, max_denominator=9).map(
    lambda q: sp.Rational(q.numerator, q.denominator)
)
calls = st.sampled_from(list(CALLS.values()))
powers = st.sampled_from(
    [-2, -1, sp.Rational(-1, 2), sp.Rational(1, 2), sp.Rational(1, 3), sp.Rational(3, 2), 2, 3, 12]
)
expressions = st.recursive(
    symbols | numbers | st.tuples(calls, symbols).map(lambda pair: pair[0](pair[1])),
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda pair: pair[0] + pair[1]),
        st.tuples(inner, inner).map(lambda pair: pair[0] * pair[1]),
        st.tuples(inner, symbols, numbers).map(lambda triple: triple[0] / (triple[1] + triple[2] * sp.Symbol("d"))),
        st.tuples(inner, symbols).map(lambda pair: pair[0] / (pair[1] * SYMBOLS["d"])),
        st.tuples(calls, symbols, numbers).map(lambda triple: triple[0](triple[1] + triple[2] * SYMBOLS["e"])),
        st.tuples(symbols, symbols, powers).map(lambda triple: (triple[0] + triple[1]) ** triple[2]),
        st.tuples(symbols, powers | symbols).map(lambda pair: pair[0] ** pair[1]),
    ),
    max_leaves=9,
)


def same(one: sp.Expr, other: sp.Expr) -> bool:
    """Equal as functions, decided by numbers: at two points to 30 digits, integrals by their integrands."""
    one, other = (e.replace(lambda s: s.is_Symbol, lambda s: sp.Symbol(s.name)) for e in (one, other))
    kernel = sp.Function("K")
    one, other = (
        e.replace(lambda s: isinstance(s, sp.Integral), lambda s: kernel(s.function, s.limits[0][1]))
        for e in (one, other)
    )
    one, other = (e.replace(kernel, lambda f, a: sp.sin(f) + 3 * a) for e in (one, other))
    names = sorted(one.free_symbols | other.free_symbols, key=str)
    for shift in (3, 7):
        point = {s: sp.Rational(2 * k + shift, 41) for k, s in enumerate(names)}
        left, right = (e.subs(point).evalf(30) for e in (one, other))
        if left == right or (left.has(sp.zoo, sp.nan) and right.has(sp.zoo, sp.nan)):
            continue
        if not abs(left - right) <= 1e-20 * (1 + abs(left)):
            return False
    return True


@settings(deadline=None, max_examples=80)
@given(expressions)
def test_what_is_printed_is_read_back_as_what_it_is(expression: sp.Expr) -> None:
    if expression.has(sp.zoo, sp.nan, sp.oo, sp.I):
        return
    text = plain(box(expression))
    assert same(Reader(text).whole(), expression.subs(sp.Symbol("d"), SYMBOLS["d"])), text


@settings(deadline=None, max_examples=30)
@given(expressions, st.sampled_from(["dx", "d", "theta", "x1"]), symbols)
def test_integrals_are_read_back(integrand: sp.Expr, name: str, factor: sp.Symbol) -> None:
    q = SYMBOLS[name]
    if integrand.has(sp.zoo, sp.nan, sp.oo, sp.I):
        return
    integral = constants_outside(factor * sp.Integral(integrand * q + 1, (q, SYMBOLS["E"], q)) / SYMBOLS["d"])
    text = plain(box(integral))
    assert same(Reader(text).whole(), integral.subs(sp.Symbol("d"), SYMBOLS["d"])), text


def test_all_letters_look_different() -> None:
    assert len(LETTERS) == len(NAMES) + 2


@pytest.mark.parametrize("letter", ["d", "a", "partial", "e", "dx"])
def test_the_reported_formula_keeps_its_brackets(letter: str, capsys: pytest.CaptureFixture[str]) -> None:
    own = ["--coordinate", "x: 0 < x", "-T", "dot(x)**2/2", "-V", f"k/({letter}*(x+1))"]
    assert main(["check", *own, "--parameter", "k=1", "--parameter", f"{letter}=2"]) == 0
    assert f"V = k/({letter} (x + 1))" in capsys.readouterr().out


def test_the_catalog_s_galaxy_is_printed_right(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "kuzmin-kutuzov"]) == 0
    assert "/(d² (cos² w + sinh² u))" in capsys.readouterr().out


def test_the_lower_limit_is_told_from_a_parameter_that_looks_like_it() -> None:
    """V = (r − r0)² has the parameter r₀, and the quadrature begins somewhere else."""
    system = hjsolve.System({"r": "line"}, "dot(r)**2/2", "(r - r0)**2/2", {"r0": 1, "alpha2": 2, "t0": 1})
    solution = hjsolve.solve(system)
    limit = solution.lower_limits["r"]
    assert plain(name_box(limit.name)) != plain(name_box("r0"))
    assert plain(name_box(str(solution.time_law.lhs.args[0]).lstrip("-"))) != plain(name_box("t0"))
    two = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "alpha2*(x**2 + y**4)", {"alpha2": 2})
    shown = {plain(name_box(name)) for name in hjsolve.solve(two).constants}
    assert plain(name_box("alpha2")) not in shown


def test_a_derivative_is_no_product() -> None:
    x, v = sp.Symbol("x"), sp.Function("v1")
    assert plain(box(sp.Derivative(v(x), x) * SYMBOLS["d"])) == "d ∂v₁(x)/∂x"
