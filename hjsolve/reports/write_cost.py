"""Writing a measured cost to a file."""

from __future__ import annotations

import json
from pathlib import Path

from hjsolve.costs import Cost
from hjsolve.errors import InvalidInputError
from hjsolve.reports.document.drawing_style import standalone
from hjsolve.reports.document.files import SUFFIXES, checked_path, replace
from hjsolve.reports.drawings.work_precision import figure
from hjsolve.reports.sections.cost import cost_document, plain_rows
from hjsolve.reports.write import write_document


def checked_cost_path(path: str | Path) -> Path:
    """Check where a table shall go, as ``checked_path``; ``.svg`` is a suffix as well.

    Raises:
        InvalidInputError: unknown suffix, or a place that cannot be written to.
    """
    target = Path(path)
    if target.suffix.lower() == ".svg":
        return target.parent / checked_path(target.with_suffix(".html")).with_suffix(target.suffix).name
    if target.suffix.lower() not in SUFFIXES:
        raise InvalidInputError(f"{target}: the suffix must be one of {', '.join(SUFFIXES)} or .svg")
    return checked_path(target)


def save_cost(table: Cost, target: Path) -> Path:
    """Write what was measured: the figure alone (``.svg``), the rows (``.json``), or a document.

    Args:
        table: what was measured.
        target: a path that ``checked_cost_path`` has passed.

    Returns:
        The path.
    """
    suffix = target.suffix.lower()
    if suffix == ".svg":
        replace(target, standalone(figure(table, "cost-figure").svg))
    elif suffix == ".json":
        replace(target, json.dumps(plain_rows(table), ensure_ascii=False, indent=1, allow_nan=False) + "\n")
    else:
        write_document(cost_document(table), target)
    return target
