"""The result of an ensemble: columns of numbers with their errors, and a status for every orbit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hjsolve.display.by_value import ByValue
from hjsolve.display.renderers import renderer
from hjsolve.ensembles.batch_html import batch_as_html
from hjsolve.ensembles.export import arrow_table, pandas_frame, write_parquet, xarray_dataset
from hjsolve.ensembles.layout import STATUS
from hjsolve.ensembles.orbit_columns import OrbitColumns
from hjsolve.errors import InvalidInputError

if TYPE_CHECKING:
    from hjsolve.ensembles.in_units import BatchInUnits


@dataclass(frozen=True, eq=False, repr=False)
class Batch(ByValue, OrbitColumns):
    """Results of many orbits; numpy arrays, or dask arrays where dask arrays came in, all of one shape.

    ``actions``, ``frequencies``, ``periods``, ``angles``, ``constants`` map names to arrays, ``turning_points`` to
    pairs (lower, upper); ``error`` maps a quantity to bounds on its errors in the same form. Only what was wanted is
    there. A number that does not exist is NaN, and ``status`` says why. ``batch[i]``, ``batch[2:5]``, ``batch[mask]``
    are the batches of some of the orbits, ``for orbit in batch`` goes along the first axis.

    Attributes:
        columns: flat name → array: ``actions.r``, ``turning_points.r.lower``, … of what was wanted, a bound on the
            error of each, such as ``error.actions.r``, ``status`` (a ``Status`` as int8) and ``recomputed``.
        layout: which quantities and names there are.
        shape: of every array, that of the initial conditions.

    Example:
        >>> batch = ensemble("kepler-planar", q={"r": [1.0, 2.0], "theta": 0}, p={"r": 0, "theta": 1.2}, want="actions")
        >>> batch.summary(), batch[0].actions["theta"].tolist()
        ({'ok': 2, 'recomputed': 0}, 1.2)
    """

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

    def to_units(self, library: object) -> BatchInUnits:
        """Tell the numbers as quantities of pint or astropy, in the units of the system.

        Args:
            library: ``"astropy"``, ``"pint"``, a registry of pint, or any unit of one of them.

        Raises:
            InvalidInputError: no library, or the system declares no units that fit T and V.
            MissingExtraError: the library is not installed (extra ``units``).
        """
        from hjsolve.ensembles.in_units import BatchInUnits
        from hjsolve.motion.in_units import measures_of

        if self.layout.solution is None:
            raise InvalidInputError('to_units: the system declares no units; System(…, units={"r": "kpc", "t": "Myr"})')
        return BatchInUnits(self.compute(), measures=measures_of(self.layout.solution, library))

    def in_conventions(self, program: str) -> Batch:
        """Return the batch with actions, frequencies and angles counted as another program counts them.

        Args:
            program: ``"galpy"`` or ``"agama"``, which count alike: angles in [0, 2π), the vertical one from where the
                orbit crosses the plane z = 0 upward; of orbits with L_z = 0 the values of the limit L_z → 0 (J_r is
                half of what it is here).

        Raises:
            InvalidInputError: another program, a system that is not known to be symmetric about the z axis, or orbits
                with L_z = 0 without ``"actions"`` and ``"turning_points"`` in ``want``.
        """
        from hjsolve.ensembles.conventions import in_conventions_of

        known = self.compute()
        return Batch(in_conventions_of(program, dict(known.columns), self.layout.roles), self.layout, self.shape)

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
        return renderer("plots").plotted_batch(self, x, y, colour, ax)

    def __len__(self) -> int:
        """Return orbits along the first axis."""
        if not self.shape:
            raise TypeError("a batch of one orbit has no length")
        return self.shape[0]

    def __getitem__(self, key: Any) -> Batch:
        """Return the batch of some of the orbits.

        Args:
            key: an index, slice, mask or array of indices, as of a numpy array of this shape.

        Raises:
            InvalidInputError: a name; columns have names, orbits have none.
        """
        if isinstance(key, str):
            raise InvalidInputError(f"batch[{key!r}]: an index selects orbits; batch.columns[{key!r}] is a column")
        if isinstance(key, Batch):
            raise InvalidInputError("batch[…]: a batch is not an index; give a mask such as batch.codes == 0")
        columns = {name: column[key] for name, column in self.columns.items()}
        if not self.lazy:
            columns = {name: np.asarray(column) for name, column in columns.items()}
        return Batch(columns, self.layout, tuple(columns[STATUS].shape))

    def __iter__(self) -> Iterator[Batch]:
        """Return the orbits along the first axis, each as a batch."""
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

    def to_table(self) -> Any:
        """Return an astropy ``QTable``: one row an orbit, with the units of the system where it declares them.

        Columns are those of ``columns``, the status as words; of a batch with several axes ``axis_0``, ``axis_1``, …
        come first. The shape is in ``meta``.

        Raises:
            InvalidInputError: the units that the system declares do not fit T and V.
            MissingExtraError: astropy is not installed (extra ``units``).
        """
        from hjsolve.ensembles.in_units import quantity_table

        return quantity_table(self.compute())

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

    def __repr__(self) -> str:
        """Shape, quantities and, once computed, the statuses."""
        counts = "" if self.lazy else f", {', '.join(f'{n} {word}' for word, n in self.summary().items())}"
        return f"<Batch of {self.shape} orbits: {', '.join(self.layout.want)}{', lazy' if self.lazy else counts}>"

    def _repr_html_(self) -> str:
        """Return what a notebook shows: statuses, and a histogram of every number."""
        return batch_as_html(self)
