"""Words that read like a translation stay out of everything a reader sees; CONTRIBUTING names the style sheet's rules."""

import ast
import json
import re
from pathlib import Path

import pytest

from tests.support.sources import ROOT, tree_of

REFUSED = {
    r"\b(could|can|may|might) (not )?be had\b|\bto be had\b": "is available, did not converge, can be computed",
    r"\b(are|is|was|were) had\b": "is computed, is available",
    r"\bgone on with\b": "resumed",
    r"\bstands? in the way\b": "couples, prevents",
    r"\btold places\b": "expressed in",
    r"\bby numpy\b": "with numpy",
    r"\bstops nobody\b": "does not stop the batch",
    r"\bof its own here\b": "name the difference",
    r"\b(Stäckel|Liouville)'s (matrix|form|column|functions)\b": "Stäckel matrix, Liouville form",
    r"\bHamilton's function\b": "the Hamiltonian",
    r"\bas many digits as it takes\b": "raises its precision as needed",
    r"\bbeside it\b": "next to it",
    r"\bthe numbers of\b": "the results of, the values of",
    r"(?<!there )\bis no (?!(?:longer|more|less|other|[a-z]+er)\b)\w+": "is not a",
}
ALLOWED = {
    # The words of the style sheet themselves, in the note on them.
}


def _of_python(path: Path) -> str:
    """String literals (docstrings and messages among them; parts of an f-string joined) and comments of a file."""
    text = path.read_text(encoding="utf-8")
    found = [line.split("#", 1)[1] for line in text.splitlines() if line.lstrip().startswith("#")]
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.append(node.value)
        elif isinstance(node, ast.JoinedStr):
            found.append("".join(str(p.value) if isinstance(p, ast.Constant) else "X" for p in node.values))
    return "\n".join(found)


def _of_notebook(path: Path) -> str:
    """Texts between the cells of code."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def _texts() -> list[Path]:
    folders = [ROOT / "hjsolve", ROOT / "docs", ROOT / "catalog", ROOT / "scenes"]
    inside = (path for folder in folders for path in folder.rglob("*") if "_generated" not in path.parts)
    kinds = {".py", ".md", ".toml", ".js", ".ipynb"}
    return [*ROOT.glob("*.md"), *sorted(path for path in inside if path.suffix in kinds)]


def _words(path: Path) -> str:
    """What a reader sees of a file, on one line."""
    reader = {".py": _of_python, ".ipynb": _of_notebook}.get(path.suffix, lambda p: p.read_text(encoding="utf-8"))
    return re.sub(r"\s+", " ", reader(path))


def refused(text: str) -> list[str]:
    """Each refused phrase in a text, with what to write instead."""
    found = []
    for pattern, instead in REFUSED.items():
        hits = re.finditer(pattern, text, re.IGNORECASE)
        found += [f"...{text[max(0, hit.start() - 30) : hit.end() + 20]}... (write: {instead})" for hit in hits]
    return found


def test_no_refused_phrase_in_anything_that_is_read():
    faults = {str(path.relative_to(ROOT)): refused(_words(path)) for path in _texts()}
    faults = {name: found for name, found in faults.items() if found and name not in ALLOWED}
    assert not faults, "\n".join(f"{name}: {one}" for name, found in faults.items() for one in found)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("A number could not be had to 15 digits.", 1),
        ("x is no coordinate; there is no y, and it is no longer than z.", 1),
        ("Stäckel's matrix of Hamilton's function", 2),
        ("Hamilton's equations; Stäckel's theorem; the number of orbits", 0),
    ],
)
def test_the_list_finds_what_it_should(text, number):
    assert len(refused(text)) == number
