"""The catalog on the terminal: the list with its filters, and one entry in full."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hjsolve import catalog
from hjsolve.catalog.bibliography import cited
from hjsolve.catalog.loading import Entry
from hjsolve.errors import InvalidInputError


def entries(*, separable: bool, kind: str | None, book: str | None) -> None:
    """List the entries that pass the filters, by kind.

    Args:
        separable: only what is solved.
        kind: only this kind.
        book: only this row of the table of Greenwood's systems.

    Raises:
        InvalidInputError: filters that exclude each other, or nothing passes.
    """
    if separable and kind not in (None, "separable", "extended"):
        raise InvalidInputError(f"catalog: --separable and --kind {kind} exclude each other")
    kinds = {kind} if kind else {"separable", "extended"} if separable else None
    chosen = catalog.titles(book=book)
    titles = {name: title for name, title in chosen.items() if kinds is None or catalog.kind_of(name) in kinds}
    if not titles:
        raise InvalidInputError("catalog: no entry is of that kind and row; rows are C01 to C96, some with a or b")
    _listed(titles)


def search_catalog(words: str, *, separable: bool, kind: str | None, book: str | None) -> bool:
    """List the entries that speak of something: in id, title, summary, parameters, effects or literature.

    Args:
        words: every one of them has to occur, in any order, small or capital.
        separable, kind, book: as in ``entries``.

    Returns:
        Whether any entry does.

    Raises:
        InvalidInputError: filters that exclude each other.
    """
    if separable and kind not in (None, "separable", "extended"):
        raise InvalidInputError(f"catalog: --separable and --kind {kind} exclude each other")
    kinds = {kind} if kind else {"separable", "extended"} if separable else None
    wanted, titles = words.casefold().split(), {}
    for name, title in catalog.titles(book=book).items():
        if kinds is not None and catalog.kind_of(name) not in kinds:
            continue
        text = " ".join(_texts(catalog.read(name)[0])).casefold()
        if all(word in text for word in wanted):
            titles[name] = title
    if titles:
        _listed(titles)
    else:
        print(f"no entry of the catalog speaks of {words}; `hjsolve catalog` lists all of them")
    return bool(titles)


_SPEAKING = ("id", "title", "summary", "meaning", "reason", "instead", "cite", "name", "kind")


def _texts(table: object, key: str = "") -> Iterator[str]:
    """Every text of an entry's file that is words, with the authors of the works it cites."""
    if isinstance(table, Mapping):
        for inner, value in table.items():
            if inner != "reference":
                yield inner if key in ("effects", "motions") else ""
                yield from _texts(value, inner)
    elif isinstance(table, list):
        for value in table:
            yield from _texts(value, key)
    elif key == "cite":
        yield from (source.name for source, _ in cited([str(table)]))
    elif key in _SPEAKING:
        yield str(table)


def _listed(titles: Mapping[str, str]) -> None:
    """Print entries by kind."""
    width = max(map(len, titles))
    for each, words in (
        ("separable", "separates"),
        ("extended", "separates, by its own form of the energy or in a declared frame"),
        ("refused", "is refused, with the reason"),
        ("outside", "is not given by T and V, and is refused"),
    ):
        names = [name for name in catalog.ids(each) if name in titles]
        if names:
            print(f"{words}:")
        for name in names:
            print(f"  {name:<{width}}  {titles[name]}")
    print("\n`hjsolve catalog show NAME` tells more about one of them")


def entry(entry: Entry) -> None:
    """Show one entry.

    Args:
        entry: from ``catalog.describe``.
    """
    from hjsolve.reports.formats.text import section_text, wrapped
    from hjsolve.reports.sections.linear_hamiltonian import given_section
    from hjsolve.reports.sections.system_and_verdict import system_section

    print(f"{entry.title}  [{entry.id}]\n")
    if entry.hamiltonian is not None:
        print(section_text(given_section(entry.hamiltonian, entry.meanings, entry.summary)))
    elif entry.system is not None:
        print(section_text(system_section(entry.system, entry.meanings, entry.summary)))
    else:
        print(wrapped((entry.summary,)))
    for title, items in (("Motions", entry.motions), ("Effects", entry.effects)):
        if items:
            print(f"\n{title}\n{'-' * len(title)}\n")
            print(
                "\n".join(wrapped((f"{name}: {item.summary or 'the default'}",), "  ") for name, item in items.items())
            )
    if entry.reason:
        print("\nWhy it is refused\n-----------------\n")
        if entry.refusal is not None:
            print(wrapped((f"{entry.refusal.kind}: {'; '.join(entry.refusal.formulas)}".rstrip(": "),)))
        print(wrapped((entry.reason,)))
        print(wrapped((entry.instead,)))
    if entry.cite:
        print("\nLiterature\n----------\n")
        for source, places in cited(entry.cite):
            print(wrapped((f"{source.name}{', ' if places else ''}{places}: {source.written}",), "  "))
