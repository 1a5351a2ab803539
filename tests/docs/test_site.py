"""The pages of the documentation site hold every public name, and every page is in its menu."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path

import pytest

import hjsolve

DOCS = Path(__file__).resolve().parents[2] / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def module(name: str):
    spec = importlib.util.spec_from_file_location(f"docs_{name}", DOCS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = loaded
    spec.loader.exec_module(loaded)
    return loaded


def test_every_public_name_is_described_once():
    text = "".join(path.read_text(encoding="utf-8") for path in (DOCS / "api").glob("*.md") if path.stem != "parts")
    described = re.findall(r"^\.\. auto\w+:: hjsolve\.([\w.]+)$", text, flags=re.MULTILINE)
    described = ["frames" if name == "catalog.moving_frames" else name for name in described]
    assert sorted(described) == sorted((set(hjsolve.__all__) - {"__version__"}) | {"jax.ensemble"})  # of an extra


def test_see_also_leads_to_public_names():
    pytest.importorskip("latex2mathml")
    pytest.importorskip("sphinx")
    extensions = module("site_extensions")
    verbs = {name for name in hjsolve.__all__ if type(getattr(hjsolve, name)).__name__ == "function"}
    assert verbs - set(extensions.SEE_ALSO) == set()
    for others in extensions.SEE_ALSO.values():
        for other in others.split():
            found = hjsolve
            for part in other.split("."):
                found = getattr(found, part)


def test_outputs_stand_below_the_code():
    pytest.importorskip("latex2mathml")
    pytest.importorskip("sphinx")
    page = "Text\n\n```python\nx = 1\nprint(x)  # 1\nprint(x + 1)  # 2\n```\n"
    below = module("site_extensions").with_outputs_below(page)
    assert below == (
        "Text\n\n```python\nx = 1\nprint(x)\nprint(x + 1)\n```\n\n```{code-block} text\n:class: output\n\n1\n2\n```\n"
    )
    assert module("site_extensions").with_outputs_below("```python\nx = 1\n```\n") == "```python\nx = 1\n```\n"


def test_every_page_is_in_the_menu():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    menu = set(re.findall(r"^([\w/-]+)$", index, flags=re.MULTILINE))
    pages = {path.relative_to(DOCS).with_suffix("").as_posix() for path in DOCS.rglob("*.md")}
    pages = {page for page in pages if not page.startswith(("api/", "decisions/", "_generated/"))} - {"index"}
    pages |= {path.relative_to(DOCS).with_suffix("").as_posix() for path in NOTEBOOKS}
    assert menu - {"_generated/gallery", "_generated/catalog", "api/index"} == pages


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_are_kept_without_results(path):
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None


def test_a_card_shows_the_orbit_of_a_report_and_leads_to_it(tmp_path):
    gallery = module("gallery")
    report = hjsolve.report("kepler-planar", tmp_path / "kepler.html").read_text(encoding="utf-8")
    card = gallery.card_of("kepler-planar", report)
    assert card.drawing.startswith("<svg ")
    assert "orbit-figure-title" in card.drawing
    assert card.words
    page = gallery.page({kind: [card] for kind in gallery.GROUPS})
    assert page.count(":link: ../reports/kepler-planar.html") == 4


def test_links_that_lead_nowhere_are_found(tmp_path):
    links = module("check_links")
    (tmp_path / "a.html").write_text('<a href="b.html#there">b</a><h1 id="top">a</h1>', encoding="utf-8")
    (tmp_path / "b.html").write_text('<p id="there">b</p><a href="a.html#top">a</a>', encoding="utf-8")
    assert not links.broken(tmp_path)
    (tmp_path / "b.html").write_text('<a href="a.html#no">a</a><a href="c.html">c</a>', encoding="utf-8")
    assert sorted(links.broken(tmp_path)) == ["a.html: b.html#there", "b.html: a.html#no", "b.html: c.html"]
