"""The changelog: one page a release, fragments that can be collected, one version everywhere."""

import datetime as dt
import importlib.util
import re
import tomllib
from pathlib import Path

import hjsolve

ROOT = Path(__file__).resolve().parents[2]
_SPEC = importlib.util.spec_from_file_location("collect", ROOT / "changelog.d" / "collect.py")
collect = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(collect)


def test_every_fragment_can_be_collected():
    assert collect.faults(collect.fragments(ROOT / "changelog.d")) == []


def test_faults_of_fragments_are_named():
    texts = {
        "a.md": "x",
        "b.added.md": "1\n2\n3\n4",
        "c.moved.md": "no table",
        "d.fixed.md": "",
        "e.added.md": "fine",
        "f.fixed.md": "- x",
    }
    assert [fault.split(":")[0] for fault in collect.faults(texts)] == [
        "a.md",
        "b.added.md",
        "c.moved.md",
        "d.fixed.md",
        "f.fixed.md",
    ]


def test_a_release_goes_above_the_others():
    texts = {"walls.fixed.md": "Walls reflect.\nTwice.", "period.moved.md": "| T | 1 | 2 | twice |"}
    new = collect.section("0.2.0", dt.date(2027, 1, 2), texts)
    assert new == (
        "## 0.2.0 (2027-01-02)\n\n### Fixed\n\n- Walls reflect.\n  Twice.\n\n### Numbers that moved\n\n"
        "| what | before | now | why |\n|---|---|---|---|\n| T | 1 | 2 | twice |\n\n"
    )
    whole = collect.merged("# Changes\n\nText.\n\n## 0.1.0 (2026-11-26)\n\nOld.\n", new)
    assert re.findall(r"^## (\S+)", whole, re.MULTILINE) == ["0.2.0", "0.1.0"]
    assert whole.endswith("## 0.1.0 (2026-11-26)\n\nOld.\n")
    assert "no result moved" in collect.section("0.3.0", dt.date(2027, 1, 2), {})


def test_the_version_is_the_same_everywhere():
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^## (\S+)", changelog, re.MULTILINE)[1] == hjsolve.__version__
    assert re.search(r"^version: (\S+)", citation, re.MULTILINE)[1] == hjsolve.__version__
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {f"Programming Language :: Python :: 3.{minor}" for minor in (11, 12, 13)} <= set(project["classifiers"])


def test_every_release_has_a_table_of_numbers_that_moved_and_fits_a_page():
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for release in changelog.split("\n## ")[1:]:
        assert "### Numbers that moved\n\n| what | before | now | why |" in release
        assert len(release.splitlines()) < 100
