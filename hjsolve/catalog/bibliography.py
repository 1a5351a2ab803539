"""The catalog's literature: from a key and a place, ``greenwood1977 P5-8``, to author, title and year."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from unicodedata import normalize

from hjsolve import catalog
from hjsolve.display.shown import Shown

GREENWOOD = "greenwood1977"
"""The book whose equation numbers stand at the formulas of a report."""

_ENTRY = re.compile(r"^@(\w+)\{([^,\s]+),(.*?)^\}", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r"^\s*(\w+)\s*=\s*\{(.*?)\},?\s*$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True, repr=False)
class Publication(Shown):
    """One work.

    Attributes:
        key: in catalog/references.bib.
        fields: as there: author, title, year and so on.
    """

    key: str
    fields: Mapping[str, str]

    @property
    def name(self) -> str:
        """Such as ``Landau and Lifshitz 1976``."""
        people = self.fields.get("author") or self.fields.get("editor") or self.key
        families = [_family(person) for person in people.split(" and ")]
        names = f"{families[0]} et al." if len(families) > 3 else _listed(families)
        return _decoded(" ".join(part for part in (names, self.fields.get("year", "")) if part))

    @property
    def written(self) -> str:
        """The whole reference in one line."""
        f = self.fields
        journal = " ".join(part for part in (f.get("journal", ""), f.get("volume", "")) if part)
        if "journal" in f:
            place = ", ".join(part for part in (journal, f.get("pages", "")) if part)
        else:
            number = f"vol. {f['volume']}" if "volume" in f else ""
            edition = f"{f['edition']}{_ordinal(f['edition'])} edition" if "edition" in f else ""
            inside = f"in {f['booktitle']}" if "booktitle" in f else ""
            parts = (inside, " ".join(p for p in (f.get("series", ""), number) if p), edition, f.get("publisher", ""),
                     f.get("address", ""), f.get("howpublished", ""), _pages(f.get("pages", "")))  # fmt: skip
            place = ", ".join(part for part in parts if part)
        people = _listed(f["author"].split(" and ")) if "author" in f else ""
        year = f"({f['year']})" if "year" in f else ""
        body = ", ".join(part for part in (people, f.get("title", ""), place) if part)
        return _decoded(f"{body} {year}".strip()) + "." + (f" doi:{f['doi']}" if "doi" in f else "")


def _family(person: str) -> str:
    """Return the family name with its particles, de Zeeuw; a name in braces is one word."""
    words = re.findall(r"(?:\{[^{}]*\}|[^\s{}])+", person)
    first = next((i for i, word in enumerate(words[:-1]) if word.islower()), len(words) - 1)
    return " ".join(words[first:])


def _listed(names: list[str]) -> str:
    if names[-1] == "others":
        return f"{', '.join(names[:-1])} and others"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


_ACCENTS = {"'": "\u0301", "`": "\u0300", '"': "\u0308", "^": "\u0302", "v": "\u030c", "~": "\u0303", "c": "\u0327"}


def _decoded(text: str) -> str:
    """TeX's accents as letters, its dashes as dashes, and no braces."""
    accented = re.sub(
        r"\\(['`\"^~]|[vc](?=[\s{]))\s*\{?(\w)\}?", lambda m: normalize("NFC", m[2] + _ACCENTS[m[1]]), text
    )
    return accented.replace("{", "").replace("}", "").replace("--", "–")


def _pages(pages: str) -> str:
    return f"pp. {pages}" if "-" in pages else pages


def _ordinal(number: str) -> str:
    return {"1": "st", "2": "nd", "3": "rd"}.get(number, "th")


@cache
def sources() -> Mapping[str, Publication]:
    """Read catalog/references.bib: key → work."""
    text = (catalog.folder() / "references.bib").read_text(encoding="utf-8")
    return {
        key: Publication(key, {name.lower(): " ".join(value.split()) for name, value in _FIELD.findall(body)})
        for _, key, body in _ENTRY.findall(text)
    }


def cited(references: Iterable[str]) -> list[tuple[Publication, str]]:
    """Resolve what an entry cites.

    Args:
        references: each a key and, where wanted, the place in the work: ``greenwood1977 P5-8``.

    Returns:
        Each work once, in the order in which it is first named, with all places; unknown keys are left out.
    """
    places: dict[str, list[str]] = {}
    for reference in references:
        key, _, place = reference.partition(" ")
        if key in sources():
            places.setdefault(key, [])
            if place and place not in places[key]:
                places[key].append(place)
    return [(sources()[key], ", ".join(found)) for key, found in places.items()]
