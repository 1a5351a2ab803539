"""The Python of README and docs is run, and prints what its comments say."""

from __future__ import annotations

import ast
import contextlib
import io
import math
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs/guides").glob("*.md"))]
TUTORIALS = sorted((ROOT / "docs/tutorials").glob("*.md"))
_BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", flags=re.DOTALL | re.MULTILINE)


def blocks(page: Path) -> list[str]:
    return [match[1] for match in _BLOCK.finditer(page.read_text(encoding="utf-8"))]


def outputs(page: Path) -> list[list[str] | None]:
    """The lines of the output block under each block of Python; None where there is none."""
    found = _BLOCK.finditer(page.read_text(encoding="utf-8"))
    return [None if match[2] is None else match[2].splitlines() for match in found]


def promised(code: str) -> list[str]:
    """What the comments after print(...) say."""
    return [match[1] for match in re.finditer(r"print\(.*\)  # (.+)$", code, flags=re.MULTILINE)]


def same(printed: str, said: str) -> bool:
    """Equal word for word, numbers to the last digit but one: the platform's libm may round differently."""
    left, right = printed.split(), said.split()
    return len(left) == len(right) and all(a == b or _close(a, b) for a, b in zip(left, right))


def _close(a: str, b: str) -> bool:
    try:
        return math.isclose(float(a), float(b), rel_tol=4e-15, abs_tol=0.0)
    except ValueError:
        return False


@pytest.mark.nightly_cases(
    "cartesian.md", "closed-forms.md", "coordinates.md", "galaxies.md", "live.md", "relativity.md", "scenes.md",
    "theorem.md", "tori.md", "wavefronts.md",
)  # fmt: skip
@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p)], ids=lambda p: p.name)
def test_python_of_a_page_prints_what_it_says(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if page.name == "start.md":  # it writes files, and reads none of the checkout
        monkeypatch.chdir(tmp_path)
    shared: dict[str, object] = {}
    for code, below in zip(blocks(page), outputs(page)):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(ast.parse(code), str(page), "exec"), shared)
        printed = out.getvalue().splitlines()
        said = promised(code) if below is None else below
        assert below is not None or len(said) == code.count("print(") - code.count("print(why") - code.count(
            "print(open_question"
        ), "each print has its value"
        assert len(printed) == len(said), printed
        for line, expected in zip(printed, said):
            assert same(line, expected), f"{page.name} says {expected!r}, got {line!r}"


def cells(page: Path) -> list[str]:
    """The code of the cells of a tutorial, without options and magics."""
    found = re.findall(
        r"^```\{code-cell\} ipython3\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    return ["\n".join(line for line in code.splitlines() if not line.startswith((":", "%"))) for code in found]


@pytest.mark.nightly
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda p: p.stem)
def test_the_cells_of_a_tutorial_run(page: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    shared: dict[str, object] = {}
    assert len(cells(page)) >= 5
    for code in cells(page):
        exec(compile(ast.parse(code), str(page), "exec"), shared)


def test_readme_shows_at_least_three_numbers() -> None:
    first = outputs(ROOT / "README.md")[0]
    assert first is not None
    assert sum(_close(value.split()[0], value.split()[0]) for value in first) >= 3


def test_the_first_python_of_readme_is_at_most_twelve_lines_and_on_the_first_screen() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(blocks(ROOT / "README.md")[0].strip().splitlines()) <= 12
    assert text[: text.index("```python")].count("\n") < 12


def test_set_up_is_two_commands_of_one_line() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = re.findall(r"^python3 -m venv .*$", text, flags=re.MULTILINE)
    assert len(commands) == 2
    assert "hjsolve report kepler-planar -o kepler.html" in commands[0]
    assert "pytest" in commands[1]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    """Links to what Sphinx writes (`docs/gallery.py`) are followed in the built site, by `docs/check_links.py`."""
    targets = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    for target in targets:
        if not target.startswith(("http", "_generated/")):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_the_figures_of_the_docs_are_what_the_script_draws() -> None:
    """Coordinates may differ in the last tenth of a pixel between machines; the drawing's structure may not."""
    import importlib.util

    specification = importlib.util.spec_from_file_location("docs_figures", ROOT / "docs" / "figures.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    committed = (ROOT / "docs" / "kepler.svg").read_text(encoding="utf-8")
    drawn = module.kepler()
    strip = re.compile(r"[\d.]+")
    heads = [re.sub(r' d="[^"]*"', "", strip.sub("#", svg)) for svg in (committed, drawn)]
    assert heads[0] == heads[1], "run `python docs/figures.py`"
