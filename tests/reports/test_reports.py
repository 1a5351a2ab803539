"""Reports: complete, well-formed, self-contained, and their numbers are the motion's numbers."""

from __future__ import annotations

import html.parser
import json
import math
import re
import unicodedata
import xml.etree.ElementTree as ET
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest

import hjsolve
from hjsolve.reports.content import Material, document, gather
from hjsolve.reports.document import Document
from hjsolve.reports.drawings import orbit_paths, phase_portrait
from hjsolve.reports.drawings.cartesian_picture import embedding, place
from hjsolve.reports.drawings.effective_potential import effective_potential_of
from hjsolve.reports.drawings.svg import ticks
from hjsolve.reports.formats.html import html_page as write_html
from hjsolve.reports.formats.json_format import json_text
from hjsolve.reports.formats.latex_document import tex
from hjsolve.reports.formats.markdown import markdown_page
from hjsolve.reports.formats.text import text_page
from tests.support.reports import material, report_of

T = TypeVar("T")
QUICK = ("kepler-planar", "pendulum", "spherical-pendulum", "kepler-parabolic", "projectile")
LARGE = ("lagrange-top", "spherical-staeckel")
"""Their documents take 2.5 s each: at night."""
SEPARABLE = [*QUICK, *(pytest.param(name, marks=pytest.mark.nightly) for name in LARGE)]
REFUSED = ["henon-heiles", pytest.param("double-pendulum", marks=pytest.mark.nightly)]
SECTIONS = ["system", "reduction", "test", "forms", "characteristic-function", "time-law", "closed-forms", "motion", "numbers", "how"]  # fmt: skip


class Asked(dict[str, T]):
    """What the tests that run ask for, made when they do."""

    def __init__(self, make: Callable[[str], T]):
        super().__init__()
        self.make = make

    def __missing__(self, name: str) -> T:
        self[name] = self.make(name)
        return self[name]


@pytest.fixture(scope="module")
def materials() -> dict[str, Material]:
    return Asked(material)


@pytest.fixture(scope="module")
def documents() -> dict[str, Document]:
    return Asked(report_of)


# ------------------------------------------------------------------------------------------------ the document
@pytest.mark.rotating(2)
@pytest.mark.nightly_cases("kepler-planar")
@pytest.mark.parametrize("name", SEPARABLE)
def test_a_separable_system_has_all_sections_in_order(name: str, documents: dict[str, Document]) -> None:
    keys = [section.key for section in documents[name].sections]
    assert [key for key in keys if key in SECTIONS] == SECTIONS
    assert ("orbit" in keys) == (name != "pendulum")


@pytest.mark.parametrize("name", REFUSED)
def test_a_refused_system_has_its_obstruction_and_no_solution(name: str, documents: dict[str, Document]) -> None:
    keys = [section.key for section in documents[name].sections]
    assert "obstruction" in keys
    assert not {"time-law", "motion", "numbers"} & set(keys)


@pytest.mark.parametrize("name", SEPARABLE)
def test_every_number_of_the_motion_stands_in_the_report_with_its_error(
    name: str, materials: dict[str, Material], documents: dict[str, Document]
) -> None:
    motion = materials[name].motion
    assert motion is not None
    cells = json.loads(json_text(documents[name]))["sections"]["numbers"]["blocks"]
    numbers = [
        cell
        for block in cells
        if block["kind"] == "table"
        for row in block["rows"]
        for cell in row
        if isinstance(cell, dict)
    ]
    estimates = [
        *motion.constants.values(),
        *motion.actions.values(),
        *motion.frequencies.values(),
        *motion.periods.values(),
    ]
    estimates += [end for ends in motion.turning_points.values() for end in ends if end is not None]
    assert len(numbers) == len(estimates)
    for estimate in estimates:  # a number known exactly stands without an error, and lies within the estimate's own
        margins = ((abs(Decimal(n["value"]) - Decimal(float(estimate.value))), Decimal(n["error"])) for n in numbers)
        assert any(off <= (error or Decimal(float(estimate.error))) for off, error in margins)


# ------------------------------------------------------------------------------------------------ HTML
class Outline(html.parser.HTMLParser):
    """Collects what a page refers to, and checks that elements are closed in order."""

    VOID = frozenset({"meta", "br", "hr", "img", "input", "link"})

    def __init__(self) -> None:
        super().__init__()
        self.stack: list[str] = []
        self.tags: set[str] = set()
        self.references: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag not in self.VOID:
            self.stack.append(tag)
        for name, value in attrs:
            if name in {"src", "href", "xlink:href", "action", "data"}:
                self.references.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.stack.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.stack, f"</{tag}> without a start"
        assert self.stack.pop() == tag


@pytest.mark.parametrize("name", [*SEPARABLE, *REFUSED])
def test_html_is_well_formed_and_self_contained(name: str, documents: dict[str, Document]) -> None:
    page = write_html(documents[name])
    outline = Outline()
    outline.feed(page)
    outline.close()
    assert outline.stack == []
    assert len(outline.ids) == len(set(outline.ids)), "ids are unique"
    assert all(reference.startswith("#") and reference[1:] in outline.ids for reference in outline.references)
    assert not outline.tags & {"script", "link", "iframe", "img", "object"}
    assert "url(http" not in page
    assert "@import" not in page
    ET.fromstring(page.partition("\n")[2])  # well-formed as XML, too


@pytest.mark.parametrize("name", SEPARABLE)
def test_html_shows_formulas_as_mathml_and_drawings_that_can_be_read_out(
    name: str, documents: dict[str, Document]
) -> None:
    root = ET.fromstring(write_html(documents[name]).partition("\n")[2])
    formulas = [e for e in root.iter() if e.tag.endswith("}math")]
    drawings = [e for e in root.iter() if e.tag.endswith("}svg")]
    assert len(formulas) > 20
    assert all(e.get("aria-label") for e in formulas)
    assert len(drawings) >= 3
    for drawing in drawings:
        kinds = {child.tag.rpartition("}")[2]: child.text for child in drawing}
        assert kinds["title"]
        assert kinds["desc"]
    for table in (e for e in root.iter() if e.tag == "table"):
        assert all(cell.get("scope") == "col" for cell in table.iterfind("thead/tr/th"))
        assert all(row.find("th") is not None for row in table.iterfind("tbody/tr"))


@pytest.mark.parametrize("name", [*SEPARABLE, *REFUSED])
def test_no_raw_names_are_left_in_the_prose(name: str, documents: dict[str, Document]) -> None:
    page = re.sub(r"<(style|math|svg|code)\b.*?</\1>", "", write_html(documents[name]), flags=re.DOTALL)
    words = re.sub(r"<[^>]+>", " ", page)
    assert not re.search(r"\b(p_\w+|alpha_\d|theta|phi|psi|lambda_?|c\^T)\b", words)


def test_text_that_looks_like_markup_is_escaped() -> None:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2", title="<b>A & B</b>")
    page = write_html(document(gather(system)))
    assert "<b>" not in page
    assert "&lt;b&gt;A &amp; B" in page
    assert r"\<b\>" in markdown_page(document(gather(system)))


# ------------------------------------------------------------------------------------------------ the other formats
@pytest.mark.parametrize("name", [*SEPARABLE, *REFUSED])
def test_all_formats_hold_the_same_sections_and_formulas(name: str, documents: dict[str, Document]) -> None:
    whole = documents[name]
    pages = {
        "md": markdown_page(whole),
        "txt": text_page(whole),
        "tex": tex(whole),
        "json": json_text(whole),
        "html": write_html(whole),
    }
    formulas = sum(len(re.findall(r'"kind": "formula"|"formula": \{', pages["json"])) for _ in [0])
    assert pages["md"].count("$$") == 2 * pages["md"].count("\n$$\n") or pages["md"].count("$$") % 2 == 0
    assert (
        pages["html"].count('class="formula"')
        == pages["tex"].count(r"\begin{equation*}")
        == pages["md"].count("$$") // 2
    )
    assert formulas >= 3
    for section in whole.sections:
        for suffix, page in pages.items():
            title = section.title.replace("ä", "ä")
            shown = (
                json.dumps(title, ensure_ascii=False)[1:-1]
                if suffix == "json"
                else title.replace("'", "&#x27;")
                if suffix == "html"
                else title
            )
            assert shown in page, (suffix, title)


@pytest.mark.parametrize("name", SEPARABLE)
def test_tex_has_balanced_braces_and_only_letters_that_it_declares(name: str, documents: dict[str, Document]) -> None:
    page = tex(documents[name])
    bare = page.replace(r"\{", "").replace(r"\}", "")
    assert bare.count("{") == bare.count("}")
    assert page.count(r"\begin{") == page.count(r"\end{")
    outside = {letter for letter in page if ord(letter) > 127}
    assert all(letter == "’" or unicodedata.name(letter).startswith("LATIN ") for letter in outside), outside
    assert not outside & set("ᵢⱼᵤᵥᵣₓₐₑₕₖₗₘₙₒₚₛₜ"), outside


def test_markdown_embeds_its_drawings(documents: dict[str, Document]) -> None:
    page = markdown_page(documents["kepler-planar"])
    assert page.count("data:image/svg+xml;base64,") == 6
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_json_keeps_the_arrays_of_the_figures(documents: dict[str, Document]) -> None:
    blocks = json.loads(json_text(documents["kepler-planar"]))["sections"]["motion"]["blocks"]
    orbit = next(f for b in blocks if b["kind"] == "figures" for f in b["figures"] if f["title"] == "Orbit")
    x, y = np.array(orbit["data"]["x"]), np.array(orbit["data"]["y"])
    a, e = 1 / 0.56, math.sqrt(1 - 0.56 * 1.44)
    assert np.allclose((x + a * e) ** 2 / a**2 + y**2 / (a**2 * (1 - e**2)), 1.0, rtol=1e-12, atol=0)


# ------------------------------------------------------------------------------------------------ the drawings' numbers
def test_the_effective_potential_meets_the_level_at_the_turning_points(materials: dict[str, Material]) -> None:
    for name in (*QUICK, *LARGE):
        motion = materials[name].motion
        assert motion is not None
        for coordinate in motion.solution.coordinates:
            view = effective_potential_of(motion, coordinate)
            for end in view.ends:
                if end is not None:
                    slope = abs(float(view.potential(end + 1e-6) - view.potential(end - 1e-6))) / 2e-6
                    assert abs(float(view.potential(end)) - view.level) <= 1e-13 * (
                        abs(view.level) + slope * max(1.0, abs(end))
                    )


def test_p_squared_of_the_drawing_is_p_squared_of_the_solution(materials: dict[str, Material]) -> None:
    for name in (*QUICK, *LARGE):
        motion = materials[name].motion
        assert motion is not None
        state = motion.at(float(motion.t0))
        for coordinate in motion.solution.coordinates:
            view = effective_potential_of(motion, coordinate)
            P = float(state.p[coordinate]) + float(view.shift(float(state.q[coordinate])))
            square = float(view.momentum_squared(np.array(float(state.q[coordinate])), view.level))
            assert square == pytest.approx(P**2, rel=1e-11, abs=1e-13)


def test_the_area_of_the_phase_curve_is_two_pi_times_the_action(materials: dict[str, Material]) -> None:
    for name in ["kepler-planar", "pendulum", "lagrange-top", "spherical-staeckel"]:
        motion = materials[name].motion
        assert motion is not None
        for coordinate in motion.solution.coordinates:
            if motion.kinds[coordinate] != "libration":
                continue
            view = effective_potential_of(motion, coordinate)
            low, high = view.ends
            assert low is not None
            assert high is not None
            q, p = phase_portrait.loop(view, view.level, low, high, points=4001)
            area = abs(float(np.sum((p[1:] + p[:-1]) * np.diff(q)) / 2))
            assert area == pytest.approx(2 * math.pi * float(motion.actions[coordinate].value), rel=1e-5)


def test_the_separatrix_of_the_pendulum_is_found(materials: dict[str, Material]) -> None:
    motion = materials["pendulum"].motion
    assert motion is not None
    hills = phase_portrait.hills(effective_potential_of(motion, "theta"))
    assert [kind for _, kind in hills] == ["separatrix"]
    assert hills[0][0] == pytest.approx(9.81, rel=1e-9)


def test_the_edge_of_the_bound_kepler_motions_is_zero_energy(materials: dict[str, Material]) -> None:
    motion = materials["kepler-planar"].motion
    assert motion is not None
    assert phase_portrait.hills(effective_potential_of(motion, "r")) == [
        (pytest.approx(0.0, abs=1e-7), "edge of the bound motions")
    ]


@pytest.mark.parametrize(
    ("name", "shape", "kind", "up"),
    [("kepler-planar", "plane", "polar", 1), ("kepler-spherical", "space", "spherical", 1), ("kepler-parabolic", "plane", "parabolic", 1),
     ("spherical-pendulum", "sphere", "colatitude", -1), ("lagrange-top", "sphere", "elevation", 1), ("projectile", "plane", "cartesian", 1),
     ("pendulum", "line", "", 1)],
)  # fmt: skip
def test_where_a_motion_happens_is_read_off_the_kinetic_energy(name: str, shape: str, kind: str, up: int) -> None:
    where = embedding(hjsolve.catalog.load(name))
    assert (where.shape, where.kind, where.up) == (shape, kind, up)


def test_the_spherical_pendulum_hangs_below_its_support(materials: dict[str, Material]) -> None:
    motion = materials["spherical-pendulum"].motion
    assert motion is not None
    where = embedding(motion.solution.system)
    _, _, z = place(where, {"theta": [0.1], "phi": [0.0]})
    assert z[0] == pytest.approx(-math.cos(0.1))


def test_a_periodic_orbit_is_drawn_over_one_period(materials: dict[str, Material]) -> None:
    motion = materials["kepler-planar"].motion
    assert motion is not None
    times, closed = orbit_paths.times(motion)
    assert closed
    assert times[-1] == pytest.approx(float(motion.periods["r"].value), rel=1e-12)


# ------------------------------------------------------------------------------------------------ axes
@pytest.mark.parametrize(
    ("low", "high", "labels"),
    [
        (0.0, 1.0, ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        (-3.0, 3.0, ["−2", "0", "2"]),
        (0.93, 1.07, ["0.95", "1.00", "1.05"]),
    ],
)
def test_ticks_are_round_numbers(low: float, high: float, labels: list[str]) -> None:
    assert [label for _, label in ticks(low, high)] == labels


def test_ticks_of_an_angle_are_parts_of_pi() -> None:
    assert [label for _, label in ticks(-math.pi, math.pi, angle=True)] == ["−π", "−π/2", "0", "π/2", "π"]


def test_ticks_far_from_zero_are_told_apart() -> None:
    labels = [label for _, label in ticks(1e8, 1e8 + 10)]
    assert len(set(labels)) == len(labels) >= 3


# ------------------------------------------------------------------------------------------------ the verb
@pytest.mark.parametrize("suffix", [".html", ".md", ".json", ".txt", ".tex"])
def test_report_writes_every_suffix_and_returns_the_path(suffix: str, tmp_path: Path) -> None:
    target = tmp_path / f"pendulum{suffix.upper()}"
    assert hjsolve.report("pendulum", target, cost=False) == target
    assert target.stat().st_size > 2000


@pytest.mark.nightly
def test_report_takes_every_stage(tmp_path: Path) -> None:
    system = hjsolve.catalog.load("pendulum")
    verdict = hjsolve.separate(system)
    solution = hjsolve.solve(system)
    motion = solution.motion(q={"theta": 1}, velocity={"theta": 0})
    for subject in (system, verdict, solution, motion):
        page = hjsolve.report(subject, tmp_path / "p.txt", cost=False).read_text(encoding="utf-8")
        assert "Results with error bounds" in page
    refused = hjsolve.separate(hjsolve.catalog.load("henon-heiles"))
    assert "Does not separate" in hjsolve.report(refused, tmp_path / "h.txt").read_text(encoding="utf-8")


def test_a_system_without_initial_data_is_reported_without_numbers(tmp_path: Path) -> None:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4")
    page = hjsolve.report(system, tmp_path / "p.txt", cost=False).read_text(encoding="utf-8")
    assert "No initial data were given" in page
    assert "Time law" in page


def test_report_refuses_what_it_cannot_tell_about(tmp_path: Path) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match="not dict"):
        hjsolve.report({}, tmp_path / "p.html")  # type: ignore[arg-type]


LONG = {"neumann", "garnier", "triaxial-geodesics", "two-centres-space", "stark", "kepler-prolate", "kuzmin-kutuzov"}
"""Reports whose map and wavefronts take seconds: whole ones at night."""


@pytest.mark.rotating(6)
@pytest.mark.parametrize(("name", "brief"), [
    *((name, name in LONG) for name in hjsolve.catalog.ids("separable")),
    *(pytest.param(name, False, marks=pytest.mark.nightly) for name in sorted(LONG)),
])  # fmt: skip
@pytest.mark.slow
def test_every_entry_of_the_catalog_can_be_reported(name: str, brief: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hjsolve.reports.sections.closed_forms.SECONDS", 0.2)
    entry = hjsolve.catalog.describe(name)
    for motion in entry.motions:
        page = write_html(document(gather(name, motion=motion), brief=brief))
        ET.fromstring(page.partition("\n")[2])
        assert "nan" not in re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL).lower().replace("dominant", "")


def test_the_number_of_an_equation_and_the_comma_after_a_formula_stay_on_their_line() -> None:
    from hjsolve.reports.document import Mathematics, Paragraph
    from hjsolve.reports.formats.html import block_html
    from hjsolve.reports.formulas.layout import Glyph

    shown = block_html(Paragraph(("By Greenwood (5-142) and ", Mathematics(Glyph("θ")), ", so.")))
    assert '<span class="together">Greenwood (5-142)</span>' in shown
    assert "</math>,</span> so." in shown
