"""The result of an ensemble: columns of numbers with their errors, and a status for every orbit."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from hjsolve.ensembles.batch_html import batch_as_html
from hjsolve.ensembles.export import arrow_table, pandas_frame, write_parquet, xarray_dataset
from hjsolve.ensembles.layout import ERROR, QUANTITIES, RECOMPUTED, STATUS, Layout
from hjsolve.ensembles.status import Status
from hjsolve.errors import InvalidInputError

WORDS = np.array([status.word for status in Status])


@dataclass(frozen=True, eq=False, repr=False)
class Batch:
    """The numbers of many orbits; numpy arrays, or dask arrays where dask arrays came in, all of one shape.

    ``actions``, ``frequencies``, ``periods``, ``angles``, ``constants`` map names to arrays, ``turning_points`` to
    pairs (lower, upper); ``error`` maps a quantity to bounds on its errors in the same form. Only what was wanted is
    there. A number that does not exist is NaN, and ``status`` says why. ``batch[i]``, ``batch[2:5]``, ``batch[mask]``
    are the batches of some of the orbits, ``for orbit in batch`` goes along the first axis.

    Attributes:
        columns: flat name → array: ``actions.r``, ``turning_points.r.lower``, … of what was wanted, ``error.actions.r``
            beside each, ``status`` (a ``Status`` as int8) and ``recomputed``.
        layout: which quantities and names there are.
        shape: of every array, that of the initial conditions.
    """

    columns: Mapping[str, Any]
    layout: Layout
    shape: tuple[int, ...]

    @property
    def actions(self) -> dict[str, Any]:
        """J = (1/2π) ∮ p dq by coordinate."""
        return self._quantity("actions")

    @property
    def frequencies(self) -> dict[str, Any]:
        """Ω = ∂H/∂J by coordinate, radians per unit time."""
        return self._quantity("frequencies")

    @property
    def periods(self) -> dict[str, Any]:
        """2π/abs(Ω) by coordinate; infinite where Ω is zero."""
        return self._quantity("periods")

    @property
    def angles(self) -> dict[str, Any]:
        """The angle variables of the initial states, in (−π, π], by coordinate."""
        return self._quantity("angles")

    @property
    def constants(self) -> dict[str, Any]:
        """The constants of the motion by name."""
        return self._quantity("constants")

    @property
    def turning_points(self) -> dict[str, tuple[Any, Any]]:
        """(lower, upper) by separated coordinate; NaN on a side that has none."""
        return self._quantity("turning_points")

    @property
    def error(self) -> dict[str, dict[str, Any]]:
        """Bounds on the absolute errors: quantity → name → array (or pair)."""
        return {quantity: self._quantity(quantity, ERROR) for quantity in self.layout.want}

    @property
    def status(self) -> Any:
        """A word for every orbit: ``ok`` or what became of it; ``Status`` tells what each means."""
        codes = self.columns[STATUS]
        return codes.map_blocks(_words, dtype=WORDS.dtype) if self.lazy else _words(codes)

    @property
    def codes(self) -> Any:
        """The status as int8, a ``Status`` for every orbit."""
        return self.columns[STATUS]

    @property
    def recomputed(self) -> Any:
        """True where the single-orbit engine computed the orbit, because the vectorised one handed it back."""
        return self.columns[RECOMPUTED]

    @property
    def exact(self) -> Any:
        """The former name of ``recomputed``, with a warning."""
        warnings.warn("Batch.exact is called Batch.recomputed now", DeprecationWarning, stacklevel=2)
        return self.recomputed

    @property
    def lazy(self) -> bool:
        """True while the columns are dask arrays."""
        return hasattr(self.columns[STATUS], "dask")

    def summary(self) -> dict[str, int]:
        """How many orbits have each status, and how many were ``recomputed``; computes a lazy batch's statuses.

        Returns:
            Word → number of orbits; words that no orbit has are left out, ``recomputed`` is always there.
        """
        status, recomputed = self.columns[STATUS], self.columns[RECOMPUTED]
        if self.lazy:
            from dask.base import compute

            status, recomputed = compute(status, recomputed)
        counts = np.bincount(np.ravel(status), minlength=len(Status))
        found = {s.word: int(counts[s]) for s in Status if counts[s]}
        return {**found, RECOMPUTED: int(np.count_nonzero(recomputed))}

    def compute(self, **options: Any) -> Batch:
        """Compute a lazy batch, every block once; one that is computed is returned as it is.

        Args:
            options: for ``dask.compute``, e.g. ``scheduler="threads"``.

        Returns:
            The batch with numpy arrays.
        """
        if not self.lazy:
            return self
        from dask.base import compute

        (columns,) = compute(dict(self.columns), **options)
        return Batch(columns, self.layout, self.shape)

    def plot(self, x: str | None = None, y: str | None = None, *, colour: str | None = None, ax: Any = None) -> Any:
        """Draw one number of the orbits against another with matplotlib (extra ``report``), a point an orbit.

        Args:
            x, y: names of columns, such as ``"actions.r"``; None for the first two.
            colour: name of the column that gives the points their colour.
            ax: axes to draw on; None for new ones.

        Returns:
            The axes. Errors are drawn where they can be seen; orbits without the numbers are counted above.

        Raises:
            InvalidInputError: names that are no columns of numbers, or axes that are none.
            MissingExtraError: matplotlib is not installed.
        """
        return importlib.import_module("hjsolve.plots").plotted_batch(self, x, y, colour, ax)

    def __len__(self) -> int:
        """Orbits along the first axis."""
        if not self.shape:
            raise TypeError("a batch of one orbit has no length")
        return self.shape[0]

    def __getitem__(self, key: Any) -> Batch:
        """The batch of some of the orbits.

        Args:
            key: an index, slice, mask or array of indices, as of a numpy array of this shape.

        Raises:
            InvalidInputError: a name; columns have names, orbits have none.
        """
        if isinstance(key, str):
            raise InvalidInputError(f"batch[{key!r}]: orbits are picked by place; batch.columns[{key!r}] is a column")
        if isinstance(key, Batch):
            raise InvalidInputError("batch[…]: a batch is no index; give a mask such as batch.codes == 0")
        columns = {name: column[key] for name, column in self.columns.items()}
        if not self.lazy:
            columns = {name: np.asarray(column) for name, column in columns.items()}
        return Batch(columns, self.layout, tuple(columns[STATUS].shape))

    def __iter__(self) -> Iterator[Batch]:
        """The orbits along the first axis, each as a batch."""
        return (self[k] for k in range(len(self)))

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame``: one row an orbit, the columns of ``columns``, the status as words.

        Raises:
            MissingExtraError: pandas is not installed (extra ``tables``).
        """
        return pandas_frame(self.compute())

    def to_arrow(self) -> Any:
        """Return a ``pyarrow.Table``: one row an orbit, the columns of ``columns``, the status as words.

        Raises:
            MissingExtraError: pyarrow is not installed (extra ``tables``).
        """
        return arrow_table(self.compute())

    def to_xarray(self) -> Any:
        """Return an ``xarray.Dataset`` over the axes of the batch; a lazy batch stays lazy.

        Raises:
            MissingExtraError: xarray is not installed (extra ``tables``).
        """
        return xarray_dataset(self)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write a Parquet file: one row an orbit, the columns of ``columns``, the status as words.

        Args:
            path: where to, ending in ``.parquet``; a file that is there is replaced.

        Returns:
            The path.

        Raises:
            InvalidInputError: another ending.
            MissingExtraError: pyarrow is not installed (extra ``tables``).
        """
        return write_parquet(self.compute(), path)

    def _quantity(self, quantity: str, prefix: str = "") -> dict[str, Any]:
        if quantity not in self.layout.names:
            raise InvalidInputError(f'"{quantity}" was not computed; add it to want')
        sides: Callable[[str], Any]
        if quantity == "turning_points":
            sides = lambda n: (self.columns[f"{n}.lower"], self.columns[f"{n}.upper"])  # noqa: E731
        else:
            sides = lambda n: self.columns[n]  # noqa: E731
        return {name: sides(f"{prefix}{quantity}.{name}") for name in self.layout.names[quantity]}

    def __repr__(self) -> str:
        """Shape, quantities and, once computed, the statuses."""
        counts = "" if self.lazy else f", {', '.join(f'{n} {word}' for word, n in self.summary().items())}"
        return f"<Batch of {self.shape} orbits: {', '.join(self.layout.want)}{', lazy' if self.lazy else counts}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: statuses, and a histogram of every number."""
        return batch_as_html(self)


def _words(codes: Any) -> Any:
    return WORDS[codes]


__all__ = ["QUANTITIES", "WORDS", "Batch", "Status"]
