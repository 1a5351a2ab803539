"""What reports, commands and checks say about a system is true of it: found false for relativistic and framed systems.

The headline of 13 entries said that T is not diagonal where it is; of a relativistic particle p = ∂T/∂q̇ stood beside
its H; ``checks.check`` raised sympy's PolynomialError for it; a remark lost a bracket.
"""

from __future__ import annotations

import json
import re

import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.system import linear_terms, mass_matrix, parameter, with_values
from hjsolve.reports.content import document, gather
from hjsolve.reports.formats.json_format import json_text
from hjsolve.reports.formats.text import line, section_text, text_page
from hjsolve.reports.sections import system_and_verdict
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.solution.laws import check
from hjsolve.solution.quadratures import Solution
from tests.support import entries
from tests.support.reports import report_of

pytestmark = pytest.mark.rotating_file(2)

RELATIVITY = {"mass": "m0", "light": "c"}
POSITIVE = {"m0": parameter("m0", 1, assume="positive"), "c": parameter("c", 2, assume="positive"), "k": "0.3"}
RELATIVISTIC = {
    "free in a plane": ({"x": "line", "y": "line"}, "m0/2*(dot(x)**2 + dot(y)**2)", "0"),
    "central force in space": (
        {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"},
        "m0/2*(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)", "-k/r",
    ),
    "field and gradient": (
        {"x": "line", "y": "line", "z": "line"}, "m0/2*(dot(x)**2 + dot(y)**2 + dot(z)**2) + k*x*dot(y) + 3*x*dot(x)",
        "k*x",
    ),
}  # fmt: skip


def relativistic(name: str) -> hjsolve.System:
    coordinates, kinetic, potential = RELATIVISTIC[name]
    return hjsolve.System(coordinates, kinetic, potential, POSITIVE, relativity=RELATIVITY)


# ------------------------------------------------------------------------------------------------ the laws
@pytest.mark.parametrize("name", RELATIVISTIC)
def test_the_laws_are_proved_for_relativistic_systems_of_ones_own(name: str) -> None:
    assert [c.verdict for c in check(hjsolve.solve(relativistic(name)))] == ["proved"] * 4


def test_a_wrong_mass_in_a_relativistic_solution_is_seen() -> None:
    solution = hjsolve.solve(relativistic("field and gradient"))
    m0 = solution.system.symbols["m0"]
    wrong = {name: square.subs(m0, 2 * m0) for name, square in solution.momentum_squared.items()}
    forged = {c.name: c.verdict for c in check(Solution(**{**vars(solution), "momentum_squared": wrong}))}
    assert forged["hamilton-jacobi"] == "failed"


@pytest.mark.nightly
def test_without_time_nothing_is_called_failed_and_nothing_breaks() -> None:
    """Kerr's radius begins at M + √(M² − a²): places were looked for with M and a not yet known."""
    for name in ("kerr", "vinti", "lagrange-top", "relativistic-kepler"):
        assert {c.verdict for c in check(entries.solution(name), budget=0.0)} <= {"proved", "numeric", "undecided"}


def test_reports_and_the_command_line_say_whether_the_solution_solves(capsys: pytest.CaptureFixture[str]) -> None:
    from hjsolve.command_line.main import main

    assert main(["solve", "relativistic-oscillator"]) == 0
    out = capsys.readouterr().out
    assert "Check of the solution" in out
    assert out.count("proved, exactly") == 4
    assert "laws" in [section.key for section in report_of("kepler-planar").sections]


# ------------------------------------------------------------------------------------------------ the headline
@pytest.mark.entries
@pytest.mark.parametrize("name", entries.separable())
def test_the_headline_says_why_the_full_system_has_no_form_and_only_what_is_true(name: str) -> None:
    verdict = entries.verdict(name)
    words = line(system_and_verdict.answer(verdict))
    system = verdict.system
    mass = mass_matrix(system)
    mixed = any(sp.simplify(mass[i, j]) != 0 for i in range(mass.rows) for j in range(i))
    assert ("not diagonal" in words) <= mixed
    assert ("ignorable coordinates are" in words) <= bool(verdict.ignorable)
    assert ("linear in the velocities" in words) <= any(linear_terms(system))
    if verdict.stackel is None and verdict.liouville is None and verdict.reduced.stackel is not None:
        assert system.relativity or mixed or any(linear_terms(system))
        assert ("energy relation, squared" in words) == (system.relativity is not None)


@pytest.mark.parametrize("name", [n for n in entries.separable() if entries.loaded(n).relativity])
def test_a_relativistic_report_does_not_contradict_itself(name: str) -> None:
    """p as printed is the p whose H is printed: H(q, p(q̇)) is the relativistic energy γ m₀ c² + V."""
    system = entries.loaded(name)
    section = system_and_verdict.system_section(system, {}, "")
    shown = section_text(section)
    assert "∂T" not in shown
    assert "4-109" not in shown
    assert "classical kinetic energy" in shown
    sources = [b.source for b in section.blocks if hasattr(b, "source")]
    momenta, H = sources[2:-1], sources[-1]
    names = {s.name: s for c in system.coordinates for s in (c.symbol, c.momentum)} | dict(system.symbols)
    speeds = {f"v_{c.name}": c.velocity for c in system.coordinates}

    def read(source: str) -> sp.Expr:
        plain = re.sub(r"dot\((\w+)\)", r"v_\1", source)
        return sp.sympify(plain, locals={**names, **speeds})

    point = {c.velocity: sp.Rational(1, 7 + i) for i, c in enumerate(system.coordinates)}
    point |= {c.symbol: sp.Rational(3 + i, 4) for i, c in enumerate(system.coordinates)}
    point |= {p.symbol: p.value for p in system.parameters}
    p = {c.momentum: read(source).xreplace(point) for c, source in zip(system.coordinates, momenta, strict=True)}
    energy = read(H).xreplace(p).xreplace(point)
    m, c = system.relativity.mass, system.relativity.light
    quadratic = (system.kinetic - sum(a * q.velocity for a, q in zip(linear_terms(system), system.coordinates))) * 2
    expected = (m * c**2 / sp.sqrt(1 - quadratic / (m * c**2)) + system.potential).xreplace(point)
    assert abs(sp.N(energy - expected, 30)) < 1e-28


def test_the_shell_of_a_relativistic_particle_is_at_minus_half_its_rest_energy() -> None:
    verdict = entries.verdict("relativistic-oscillator")
    step = next(s for s in verdict.shell.steps if s.title == "Energy shell")
    m0, c = (verdict.system.symbols[n] for n in ("m0", "c"))
    assert step.formula.rhs == -m0 * c**2 / 2
    assert verdict.shell.steps[0].title == "Relativistic energy shell"


# ------------------------------------------------------------------------------------------------ words
def test_a_remark_keeps_its_brackets() -> None:
    system = entries.loaded("relativistic-oscillator")
    words = line(typeset_prose("drawn out: eta^2 = k*a^2/(4*m0*c^2) = 9/16, almost", system))
    assert words == "drawn out: η² = k a²/(4 m₀ c²) = 9/16, almost"


@pytest.mark.parametrize(
    ("plain", "shown"),
    [
        ("the repulsion g^2/(2 m r^2) that", "the repulsion g²/(2 m r²) that"),
        ("with v3 = m c (1 - cos(phi)).", "with v3 = m c (1 − cos φ)."),
        ("swings at sqrt(3g/(2l)).", "swings at √(3 g/(2 l))."),
        ("K = P^2/2m + w*(y*p_x - x*p_y): no", "K = P²/(2 m) + w (y pₓ − x p_y): no"),
        ("a speed of 5 m/s and/or a jump at (2-171)", "a speed of 5 m/s and/or a jump at (2-171)"),
        ("where (x - y)^2 + 2*x (or so) grows", "where (x − y)² + 2 x (or so) grows"),
        ("like x**(-3/2), sinh(u)**2 and exp(-k*x)", "like x^(−3/2), sinh² u and exp(−k x)"),
        ("E = -x*(y + 1)*k", "E = −x (y + 1) k"),
    ],
)
def test_formulas_in_a_sentence_are_set_as_they_are_written(plain: str, shown: str) -> None:
    system = hjsolve.System({"x": "line", "y": "line"}, "dot(x)**2 + dot(y)**2", "k*x", {"k": 1})
    assert line(typeset_prose(plain, system)) == shown


@pytest.mark.entries
@pytest.mark.parametrize("name", [n for n in hjsolve.catalog.ids() if entries.described(n).system is not None])
def test_no_raw_formula_is_left_in_the_prose_of_an_entry(name: str) -> None:
    entry = entries.described(name)
    texts = [entry.summary, entry.reason, *(m.summary for m in entry.motions.values())]
    texts += [meaning for _, meaning in entry.meanings.values()] + [p.meaning for p in entry.system.parameters]
    if name in entries.separable():
        texts += [c.meaning for c in entries.solution(name).constants.values()]
    for words in texts:
        shown = " ".join(piece for piece in typeset_prose(words, entry.system) if isinstance(piece, str))
        shown = shown.replace("gyroscopic_modes", "")
        assert not re.search(r"\*|\^\w|\w_[a-z]|(sqrt|sin|cos|exp|dot)\(|\bphi\b|\btheta\b|do not hold", shown), shown


@pytest.mark.nightly
def test_ignorable_orbit_equations_cite_their_own_equation() -> None:
    blocks = json.loads(json_text(report_of("kepler-spherical")))["sections"]["orbit"]["blocks"]
    tags = [block["tag"] for block in blocks if block["kind"] == "formula"]
    assert tags == ["Greenwood (5-70)", "Greenwood (5-83)"]


@pytest.mark.nightly
def test_capital_momenta_stand_only_where_they_differ_and_are_explained() -> None:
    plain = text_page(document(gather("kepler-planar", initial=None)))
    assert "Pᵣ" not in plain
    shifted = text_page(report_of("bead-on-turning-wire"))
    assert "P_θ²" in shifted
    assert "P = p + gradient" in shifted


def test_what_is_no_energy_is_not_called_one() -> None:
    for name in ("kerr", "schwarzschild"):
        constants = entries.solution(name).constants
        assert "not an energy" in constants["E"].meaning
        assert constants["p_t"].meaning.startswith("minus the energy that belongs to t")
        assert constants["p_phi"].meaning.startswith("angular momentum")
    other = entries.loaded("schwarzschild")
    flipped = hjsolve.System(
        {c.name: c.domain.written(c.name) for c in other.coordinates}, -other.kinetic, "0", {"M": 1},
        signature="indefinite",
    )  # fmt: skip
    assert hjsolve.solve(flipped).constants["p_t"].meaning.startswith("energy that belongs to t")
    magnetic = entries.solution("charge-in-uniform-field").constants["E"].meaning
    assert magnetic == "energy T2 + V"
    assert with_values(other, {"M": 2}) is not None


@pytest.mark.parametrize(
    ("domains", "kinetic", "named"),
    [
        ({"x": "line", "y": "line"}, "m*(dot(x)**2 + dot(y)**2)/2", True),
        ({"x": "line", "y": "line"}, "m*(dot(x)**2 + 2*dot(y)**2)/2", True),
        ({"x": "line", "y": "0 < y"}, "m*(dot(x)**2 + dot(y)**2)/2", False),
    ],
)
def test_the_search_for_coordinates_is_advised_where_it_does_not_refuse_the_domains(domains, kinetic, named):
    system = hjsolve.System(domains, kinetic, "x**2*y - y**3/3 + x**4*y", parameters={"m": 1})
    advice = hjsolve.separate(system).advice
    assert ('coordinates="find"' in advice) is named
    assert "The kinetic energy separates in these coordinates" in advice
