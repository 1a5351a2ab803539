"""Write the gallery: a card with a drawing for every entry of the catalog, and the report that it leads to."""

from __future__ import annotations

import re
import shutil
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from html import unescape
from pathlib import Path

import hjsolve
from hjsolve import catalog
from hjsolve.reports.document.drawing_style import standalone

CATALOG = Path(__file__).resolve().parents[1] / "catalog" / "README.md"
GROUPS = {
    "separable": "Systems that separate",
    "extended": "Separate by their own form of the energy, or in a declared frame",
    "refused": "Refused, with the reason",
    "outside": "No T and V: refused, with the reason",
}
SHOWN = ("orbit-figure", "phase-0", "history", "potential-0")
"""Which drawing of a report stands for it, best first."""
DRAWING = re.compile(r'<svg[^>]* class="fig"[^>]* aria-labelledby="(\S+)-title .*?</svg>', re.DOTALL)
DESCRIPTION = re.compile(r"<desc[^>]*>(.*?)</desc>", re.DOTALL)


@dataclass(frozen=True)
class Card:
    """What the gallery shows of an entry.

    Attributes:
        name, title, summary: of the catalog.
        drawing: an SVG file that stands alone, as text; empty where the report has none.
        words: what it shows, for those who cannot see it.
    """

    name: str
    title: str
    summary: str
    drawing: str
    words: str


def write(folder: Path) -> None:
    """Write the page, the drawings and the reports anew.

    Args:
        folder: is replaced; its ``gallery.md`` and ``catalog.md`` are pages of the site, its ``site`` is copied to the
            site's root.
    """
    shutil.rmtree(folder, ignore_errors=True)
    reports, drawings = folder / "site" / "reports", folder / "drawings"
    reports.mkdir(parents=True)
    drawings.mkdir()
    groups: dict[str, list[Card]] = {kind: [] for kind in GROUPS}
    names = catalog.ids()
    with ProcessPoolExecutor() as pool:
        cards = pool.map(reported, names, [reports] * len(names))
    for name, card in zip(names, cards, strict=True):
        if card.drawing:
            (drawings / f"{name}.svg").write_text(card.drawing, encoding="utf-8")
        groups[catalog.kind_of(name)].append(card)
    (folder / "gallery.md").write_text(page(groups), encoding="utf-8")
    (folder / "catalog.md").write_text(CATALOG.read_text(encoding="utf-8"), encoding="utf-8")


def reported(name: str, folder: Path) -> Card:
    """Write the report of an entry, and make its card.

    The report is brief: two thirds of the time of whole reports goes into what no card shows.

    Args:
        name: its id.
        folder: where the report goes.
    """
    brief = catalog.kind_of(name) != "outside" and catalog.hamiltonian(name) is None
    report = hjsolve.report(name, folder / f"{name}.html", brief=brief)
    return card_of(name, report.read_text(encoding="utf-8"))


def card_of(name: str, report: str) -> Card:
    """Return the card of an entry.

    Args:
        name: its id.
        report: its report, HTML.
    """
    entry = catalog.describe(name)
    found = {match[1]: match[0] for match in DRAWING.finditer(report)}
    chosen = next((found[key] for key in SHOWN if key in found), "")
    words = DESCRIPTION.search(chosen)
    return Card(name, entry.title, entry.summary or entry.reason, standalone(chosen) if chosen else "",
                unescape(words[1]) if words else "")  # fmt: skip


def page(groups: dict[str, list[Card]]) -> str:
    """Return the page with all cards, in Markdown.

    Args:
        groups: kind of entry → its cards.
    """
    count = sum(len(cards) for cards in groups.values())
    lines = [
        "# Gallery", "",
        f"The {count} entries of the catalog. Each card leads to the report that `hjsolve report NAME` writes; "
        "`hjsolve.solve(\"NAME\")` starts from the same entry.", "",
    ]  # fmt: skip
    for kind, cards in groups.items():
        lines += [f"## {GROUPS[kind]}", "", "::::{grid} 1 2 3 3", ":gutter: 3", ""]
        for card in cards:
            lines += [f":::{{grid-item-card}} {_plain(card.title)}"]
            lines += [f":link: ../reports/{card.name}.html", ":link-type: url"]
            if card.drawing:
                lines += [f":img-top: drawings/{card.name}.svg", f":img-alt: {_plain(card.words)}"]
            lines += ["", f"`{card.name}`", "", _plain(card.summary), ":::", ""]
        lines += ["::::", ""]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Text in which Markdown finds no markup."""
    return re.sub(r"([\\`*_{}\[\]<>$|#])", r"\\\1", " ".join(text.split()))
