"""Small things a reader sees at once: letters in italics, numbers typeset, columns that say something, exact places."""

import re
from pathlib import Path

import pytest
import sympy as sp

import hjsolve
from hjsolve.reports.document import Code, Mathematics, Number, Table
from hjsolve.reports.drawings.energy_momentum_figure import figure_of_map
from hjsolve.reports.formulas.from_sympy import box, compact, contracted, falling_powers
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.sections.motion import numbers_section
from hjsolve.reports.sections.prose import with_names
from hjsolve.reports.sections.rounded_numbers import bound
from hjsolve.reports.sections.system_and_verdict import answer, system_section


def said(text, names=()):
    return [plain(piece.box) for piece in with_names(text, names) if isinstance(piece, Mathematics)]


def test_letters_of_the_system_are_formulas_and_words_are_not():
    assert said("T and V do not contain t, phi, so W is linear in x", ("t", "phi", "x")) == [
        "T",
        "V",
        "t",
        "φ",
        "W",
        "x",
    ]
    assert (
        said("a bound orbit, e.g. d'Alembert's; 5 m deep, a T-shaped beam; M. V. Berry", ("a", "e", "g", "d", "s", "m"))
        == []
    )
    assert said("L_1 and L_2 vanish, a_jt is not zero; hjsolve.find_coordinates") == ["L₁", "L₂", "aⱼₜ"]


def test_a_bound_is_rounded_up():
    assert [bound(x).value for x in (8.881e-16, 0.0, 0.5, 1.01e-13)] == ["8.9e-16", "0", "0.5", "1.1e-13"]


def test_a_column_that_is_empty_is_left_out():
    tables = [b for b in system_section(hjsolve.catalog.load("henon-heiles"), {}, "").blocks if isinstance(b, Table)]
    assert [[head[0] for head in table.header] for table in tables] == [
        ["Coordinate", "Domain"], ["Parameter", "Default", "Assumed", "Meaning"]
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "expected"),
    [("harmonic-oscillator", ["-1", "1"]), ("parabola", ["-0.5", "0.5"]), ("kepler-planar", ["1", ""])],
)
def test_turning_points_that_are_short_decimals_are_exact(name, expected):
    motion = hjsolve.solve(name).motion(**hjsolve.catalog.describe(name).initial.arguments)
    table = next(b for b in numbers_section(motion).blocks if isinstance(b, Table) and b.caption == "Turning points")
    ends = [piece for cell in table.rows[0][1:] for piece in cell]
    assert [end.value if not end.error else "" for end in ends] == expected


def test_an_estimate_beside_a_short_decimal_stays_one():
    """V = x²/2 + 10⁻¹⁷·x: the ends are 1 − 10⁻¹⁷ and so on, not 1."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2 + x/10**17")
    motion = hjsolve.solve(system).motion(q={"x": 0}, velocity={"x": 1})
    table = next(b for b in numbers_section(motion).blocks if isinstance(b, Table) and b.caption == "Turning points")
    assert all(piece.error for cell in table.rows[0][1:] for piece in cell if isinstance(piece, Number))
    assert not any(isinstance(piece, Code) for cell in table.rows[0] for piece in cell)


def test_reports_are_the_same_byte_for_byte_where_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They held durations."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    pages = []
    for name in ("a.html", "b.html"):
        hjsolve.report("free-particle", tmp_path / name, brief=True)
        pages.append((tmp_path / name).read_bytes())
    assert pages[0] == pages[1]
    assert b"Time spent" not in pages[0]


def test_what_is_left_separates_once_the_ignorable_coordinates_are_eliminated() -> None:
    words = answer(hjsolve.separate(hjsolve.catalog.load("lagrange-top")))
    text = "".join(plain(w.box) if isinstance(w, Mathematics) else w if isinstance(w, str) else w.text for w in words)
    assert text.startswith("Separates in θ once the ignorable coordinates ψ and φ are eliminated; ")


def test_a_coupling_is_a_cosine_of_the_difference() -> None:
    verdict = hjsolve.separate(hjsolve.catalog.load("double-pendulum"))
    (coupling,) = (step.formula for step in verdict.evidence if step.title == "Coupling")
    assert plain(box(contracted(coupling))) == "m l² cos(φ − θ)"
    assert sp.expand_trig(contracted(coupling) - coupling).expand() == 0


def test_names_in_descriptions_of_maps_are_letters() -> None:
    found = hjsolve.energy_momentum_map(hjsolve.solve("spherical-pendulum"))
    figure = figure_of_map(found, "map")
    assert "A: θ librates" in figure.description
    assert "theta" not in figure.description


@pytest.mark.parametrize(("x", "words"), [
    ("-2*x**3 + 5*x - 1 + 3*x**2", "−2 x³ + 3 x² + 5 x − 1"),
    ("c*a*x**2 - c*x**2 + p - x", "c x² (a − 1) − x + p"),
    ("x**2 + p - b", "x² + p − b"),
])  # fmt: skip
def test_polynomials_are_written_by_falling_powers(x: str, words: str) -> None:
    polynomial = sp.Poly(sp.sympify(x), sp.Symbol("x"))
    shown = falling_powers(polynomial)
    assert plain(box(shown)) == words
    assert sp.expand(sp.sympify(str(shown)) - polynomial.as_expr()) == 0


@pytest.mark.parametrize(("name", "words"), [
    ("rod-with-sliding-end", "⅙ m l² (1 + 3 cos² θ) (E − pₓ²/(2 m) − ½ m g l sin θ)"),
    ("eccentric-disk", "2 m (E + m g (l cos(α + θ) + r θ sin α)) (l² + r² − 2 l r cos θ)"),
])  # fmt: skip
def test_a_squared_momentum_is_read_as_2m_times_energy_less_potential(name: str, words: str) -> None:
    """The form of Greenwood (5-93)."""
    solution = hjsolve.solve(name)
    (square,) = solution.momentum_squared.values()
    shown = compact(square, solution.constants["E"].symbol)
    assert plain(box(shown)) == words
    assert sp.simplify(shown - square) == 0


def test_a_double_is_written_as_it_was_typed(tmp_path: Path) -> None:
    own = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "m*g*x + k*x**2/2", {"m": 0.3, "g": 9.81, "k": "27/10"})
    start = {"q": {"x": 0.1}, "velocity": {"x": "7/9"}}
    text = hjsolve.report(own, tmp_path / "own.txt", initial=start, brief=True).read_text(encoding="utf-8")
    text = " ".join(text.split())
    assert "With m = 0.3 (double), g = 9.81 (double), k = 27/10." in text
    assert "0.1 (double)" in text
    assert "from 1 quadrature node at most" in text
    assert not re.search(r"\d{12}/\d{12}", text)
