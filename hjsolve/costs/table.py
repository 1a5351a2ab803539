"""What was measured: one row a method and accuracy, frozen, and its text."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hjsolve.display.progress import duration
from hjsolve.display.shown import Shown

_HEADER = ("method", "digits", "claimed error", "true error", "count", "time", "")


@dataclass(frozen=True, repr=False)
class Row(Shown):
    """One method at one accuracy.

    Attributes:
        method: ``float64``, ``mpmath``, ``certified``, ``closed form``, ``integrate``, ``DOP853`` or ``heyoka``.
        digits: asked; of an integrator −log₁₀ of its tolerance. None where the method never started.
        claimed: the largest error it claims, relative to the size of the quantity; None where it claims none.
        error: the largest true error, likewise; None where there is no answer.
        held: whether every single number lies within its claim; None where nothing is claimed.
        count: what it took, in ``unit``: evaluations of p², its kernels and places; right-hand sides; Taylor steps.
        unit: of ``count``.
        seconds: of the processor; median of ``repeats`` runs, all but the symbolic solution and compilation.
        repeats: number of timed runs.
        status: ``ok``, ``claim broken``, ``not converged``, ``not applicable``; ``lost`` where the error is as large as
            the quantity, ``extrapolated`` where the time for all times was worked out from a few of them, ``too slow``
            where it would not fit, ``missing`` where an extra is.
        covers: ``all`` that is wanted; ``states`` or ``numbers`` alone; ``part`` of the numbers.
        note: why, or what the row does not cover.
    """

    method: str
    digits: float | None
    claimed: float | None = None
    error: float | None = None
    held: bool | None = None
    count: int | None = None
    unit: str = "evaluations"
    seconds: float | None = None
    repeats: int = 0
    status: str = "ok"
    covers: str = "all"
    note: str = ""

    @property
    def answered(self) -> bool:
        """Whether there is an answer with a time, right or wrong."""
        return self.error is not None and self.seconds is not None


@dataclass(frozen=True, repr=False)
class Cost(Shown):
    """Accuracy against time for one scene; see ``hjsolve.cost``.

    Attributes:
        title: of the scene.
        id: of its system.
        want: quantities asked.
        times: how many.
        checked: at how many of them states were compared.
        rows: in the order of methods and digits.
        reference: what the true errors were measured against.
        floor: relative error of that.
        budget: seconds allowed.
        spent: seconds used.
    """

    title: str
    id: str
    want: tuple[str, ...]
    times: int
    checked: int
    rows: tuple[Row, ...]
    reference: str
    floor: float
    budget: float
    spent: float

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods, in order."""
        return tuple(dict.fromkeys(row.method for row in self.rows))

    def of(self, method: str) -> tuple[Row, ...]:
        """Return the rows of one method.

        Args:
            method: its name.
        """
        return tuple(row for row in self.rows if row.method == method)

    def cheapest(self, digits: float, covers: str = "all") -> Row | None:
        """Return the quickest row whose true error is at most 10^−digits.

        Args:
            digits: right ones.
            covers: what it has to cover: ``all``, ``states`` or ``numbers``.

        Returns:
            The row; None where no method reaches that.
        """
        fit = [r for r in self.rows if r.answered and r.covers in ("all", covers)]
        fit = [r for r in fit if r.error is not None and r.error <= 10.0**-digits]
        return min(fit, key=lambda r: r.seconds or math.inf, default=None)

    @property
    def text(self) -> str:
        """The table as plain text, with what it was measured against."""
        cells = [_HEADER, *(cells_of(row, self.floor) for row in self.rows)]
        widths = [max(len(line[i]) for line in cells) for i in range(len(_HEADER))]
        lines = ["  ".join(cell.ljust(w) for cell, w in zip(line, widths)).rstrip() for line in cells]
        lines.insert(1, "  ".join("-" * w for w in widths[:-1]))
        return "\n".join([*lines, "", *explanation(self)])

    def __str__(self) -> str:
        return self.text


_WORDS = {"ok": "", "too slow": "did not fit the budget"}
"""What a status is called where it is not itself the word."""


def explanation(cost: Cost) -> list[str]:
    """Return what the table is about, in sentences."""
    states = f" at {cost.times} times, compared at {cost.checked} of them" if cost.checked else ""
    return [
        f"Asked: {', '.join(cost.want)}{states}.",
        f"True errors against {cost.reference}; relative to the size of each quantity, the worst of all."
        if cost.reference
        else "No reference could be computed in the time, so no true errors are known; give more seconds.",
        "Times are processor time, medians of interleaved runs, without the symbolic solution and compilation.",
    ]


def cells_of(row: Row, floor: float) -> tuple[str, ...]:
    """Write the cells of one row.

    Args:
        row: the row.
        floor: below this a true error is not resolved.

    Returns:
        As many texts as the table has columns.
    """
    time = "" if row.seconds is None else ("≈ " if row.status == "extrapolated" else "") + duration(row.seconds)
    return (
        row.method, "" if row.digits is None else f"{row.digits:.3g}", _error(row.claimed, 0.0),
        _error(row.error, floor), "" if row.count is None else f"{row.count} {row.unit}", time,
        " · ".join(part for part in (_WORDS.get(row.status, row.status), row.note) if part),
    )  # fmt: skip


def _error(value: float | None, floor: float) -> str:
    if value is None:
        return "–"
    if value < floor:
        return f"< {floor:.0e}"
    return f"{value:.1e}" if value else "0"
