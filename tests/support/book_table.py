"""docs/book.md: every row of the table of Greenwood's systems, its entry, verdict, results checked and worst error.

python -m tests.support.book_table            # writes docs/book.md from a run of the checks
"""

from __future__ import annotations

import importlib
import math
from pathlib import Path

from hjsolve import catalog
from hjsolve.catalog import Entry
from tests.support.entries import described

PAGE = Path(__file__).resolve().parents[2] / "docs" / "book.md"
MODULES = tuple(
    f"tests.catalog.test_book_{name}"
    for name in (*(f"chapter_{n}" for n in range(1, 7)), "problems_2", "canonical", "extended", "relativity", "machine")
)
_SPLIT = {"C23", "C25", "C26", "C38", "C43", "C84"}
ROWS = tuple(
    name for n in range(1, 97) for name in ((f"C{n:02}a", f"C{n:02}b") if f"C{n:02}" in _SPLIT else (f"C{n:02}",))
)
"""The 102 rows: C01 to C96, six of them in two versions."""
REFUSED_ROWS = frozenset(
    ["C03", "C04", "C05", "C07", "C08", "C11", "C23a", "C25b", "C26a", "C27", "C33", "C35", "C43a", "C46", "C49", "C50"]
    + ["C53", "C54", "C59", "C60", "C63", "C68", "C70", "C81", "C84b", "C86", "C87", "C95", "C96"]
)
EXTENDED_ROWS = frozenset(["C26b", "C51", "C62", "C74", "C82", "C88", "C91", "C92", "C93", "C94"])
"""Relativistic, with explicit time, or general H: other kinds of input."""
WITHOUT_RESULT = frozenset({"C05"})
"""Rows for which the book gives nothing to check."""
_HEAD = """# Greenwood's systems, row by row

Every mechanical system of Greenwood, *Classical Dynamics* (1977), with its catalog entry and what the tests check of
it. This page is written by `python -m tests.support.book_table` from a run of the checks in
`tests/catalog/test_book_*.py`, and a test keeps it current. An exact result is an identity proved by computer algebra;
a number is the worst relative error of the numerical results of the row, rounded up to a power of ten, 1e-13 at least.
Errors above 1e-4 are those of numbers that the book prints with two to four digits. C05 shows no count: the book gives
nothing to check there.

| row | entry | verdict | results checked | worst error |
|---|---|---|---|---|
"""


def _entries() -> dict[str, Entry]:
    return {name: described(name) for name in catalog.ids()}


def entries_of(row: str) -> list[str]:
    """Ids of the entries that are this row, those of its own verdict first."""
    found = [n for n, e in _entries().items() if row in e.book]
    if row in REFUSED_ROWS:
        found.sort(key=lambda n: _entries()[n].kind not in ("refused", "outside"))
    return found


def _verdict(name: str) -> str:
    entry = _entries()[name]
    if entry.refusal is not None:
        return f"refused: {entry.refusal.kind}"
    if entry.kind == "refused":
        return f"refused: {entry.expect['part']} couples {' and '.join(entry.expect['pair'])}"
    verdict = str(entry.expect.get("verdict", entry.kind))
    if verdict == "refused":  # an extended entry: no point transformation, but a linear symplectic one
        return "by linear symplectic normal form"
    return f"{verdict}, in a declared frame" if "frame" in catalog.read(name)[0] else verdict


def _bound(errors: list[object]) -> str:
    """A power of ten not below the errors; 1e-13 stands for everything the arithmetic of another machine may change."""
    if all(isinstance(error, int) for error in errors):
        return "exact"
    worst = max(float(error) for error in errors)  # type: ignore[arg-type]
    return f"1e{max(-13, math.ceil(math.log10(worst)) if worst else -13)}"


def page() -> str:
    """The page, from a fresh run of all checks."""
    book = importlib.import_module("tests.support.book")
    for module in MODULES:
        importlib.import_module(module)
    results = [r for module in MODULES for r in book.RESULTS[module]]
    lines, total = [], 0
    for row in ROWS:
        own = [r for r in results if r.row == row]
        errors = [r.error() for r in own]
        total += len(own)
        names = entries_of(row)
        links = ", ".join(f"`{n}`" for n in names) or "–"
        verdict = _verdict(names[0]) if names else "–"
        lines.append(f"| {row} | {links} | {verdict} | {len(own) or '–'} | {_bound(errors) if errors else '–'} |")
    return _HEAD + "\n".join(lines) + f"\n\n{len(ROWS)} rows, {total} results.\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
