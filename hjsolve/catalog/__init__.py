"""The catalog: mechanical systems as data, each with its literature, initial data, effects and reference values.

In: an entry's id, or a TOML file of the same format. Out: a ``System``, or a frozen ``Entry`` with all it holds.
Read ``loading.py`` first, then ``schema.py`` (which keys there are). The names below are imported when they are first
used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hjsolve.catalog.entry import Effect as Effect
    from hjsolve.catalog.entry import Entry as Entry
    from hjsolve.catalog.entry import InitialData as InitialData
    from hjsolve.catalog.entry import Reference as Reference
    from hjsolve.catalog.loading import describe as describe
    from hjsolve.catalog.loading import entry_of as entry_of
    from hjsolve.catalog.loading import folder as folder
    from hjsolve.catalog.loading import from_table as from_table
    from hjsolve.catalog.loading import hamiltonian as hamiltonian
    from hjsolve.catalog.loading import ids as ids
    from hjsolve.catalog.loading import kind_of as kind_of
    from hjsolve.catalog.loading import load as load
    from hjsolve.catalog.loading import read as read
    from hjsolve.catalog.loading import table_of as table_of
    from hjsolve.catalog.loading import titles as titles

__all__ = [
    "Effect", "Entry", "InitialData", "Reference", "describe", "entry_of", "folder", "from_table", "hamiltonian", "ids",
    "kind_of", "load", "read", "table_of", "titles",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a name of the catalog when it is first asked for (PEP 562): its schema is wanted far below."""
    if name in __all__:
        from hjsolve.catalog import loading

        return getattr(loading, name)
    raise AttributeError(f"module 'hjsolve.catalog' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List what is public."""
    return sorted(__all__)
