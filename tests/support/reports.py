"""Reports of entries of the catalog as documents: made once a process and shared by all tests that only read them."""

from __future__ import annotations

from functools import cache

from hjsolve.reports.content import Material, document, gather
from hjsolve.reports.document import Document


@cache
def material(name: str) -> Material:
    """What the report of an entry is written from, with its default motion."""
    return gather(name)


@cache
def report_of(name: str, brief: bool = False) -> Document:
    """The report of an entry, before it is written in a format."""
    return document(material(name), brief=brief)
