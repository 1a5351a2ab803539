"""A batch as a notebook shows it: how many orbits have which status, and a histogram of every number."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from hjsolve.ensembles.orbit_columns import OrbitColumns

_BINS, _WIDTH, _HEIGHT = 32, 160, 28
_MOST_ROWS = 24
"""Rows shown; the others are counted."""


def batch_as_html(batch: OrbitColumns) -> str:
    """Return the fragment that a notebook shows.

    Args:
        batch: lazy ones show their columns alone.
    """
    head = f"<p>Batch of {escape(str(batch.shape))} orbits: {escape(', '.join(batch.layout.want))}"
    if batch.lazy:
        return f"{head}, not computed yet</p>"
    counts = ", ".join(f"{n} {escape(word)}" for word, n in batch.summary().items())
    names = list(batch.layout.values())
    rows = "".join(_row(batch, name) for name in names[:_MOST_ROWS])
    more = f"<p>and {len(names) - _MOST_ROWS} columns more</p>" if len(names) > _MOST_ROWS else ""
    titles = "".join(f"<th>{title}</th>" for title in ("", "least", "median", "largest", "largest error", ""))
    return f"{head}</p><p>{counts}</p><table><tr>{titles}</tr>{rows}</table>{more}"


def _row(batch: OrbitColumns, name: str) -> str:
    values = np.ravel(batch.columns[name])
    values, errors = values[np.isfinite(values)], np.ravel(batch.columns[f"error.{name}"])
    errors = errors[np.isfinite(errors)]
    numbers = (values.min(), np.median(values), values.max()) if len(values) else (np.nan,) * 3
    largest = errors.max() if len(errors) else np.nan
    cells = [escape(name), *(f"{x:.6g}" for x in numbers), f"{largest:.1e}", histogram(values)]
    return f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def histogram(values: Any) -> str:
    """Return a small picture of how values are distributed, as SVG; equal bins from the least to the largest.

    Args:
        values: finite, shape (n,).
    """
    frame = f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}">'
    low, high = (values.min(), values.max()) if len(values) else (0.0, 0.0)
    if not 0 < high - low < np.inf:
        return f"{frame}</svg>"
    counts, _ = np.histogram(values / (high - low), bins=_BINS)
    step, top = _WIDTH / _BINS, counts.max()
    bars = "".join(
        f'<rect x="{k * step:.1f}" y="{_HEIGHT * (1 - n / top):.1f}" width="{step - 1:.1f}" '
        f'height="{_HEIGHT * n / top:.1f}" fill="currentColor" fill-opacity="0.6"/>'
        for k, n in enumerate(counts)
        if n
    )
    return f"{frame}{bars}</svg>"
