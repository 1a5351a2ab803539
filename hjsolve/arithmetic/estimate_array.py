"""Many estimates of one kind: what a function of the time gives where an array of times is asked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.display.shown import Shown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, repr=False)
class EstimateArray(Shown):
    """Values with errors, arrays of one shape; an element is an ``Estimate``, a slice another ``EstimateArray``.

    Attributes:
        value: the numbers; doubles up to 15 digits, ``mpf`` objects above.
        error: absolute errors, never below the true ones unless the input itself was in doubt.
    """

    value: NDArray[Any]
    error: NDArray[Any]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of both arrays."""
        return self.value.shape

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, key: Any) -> Estimate | EstimateArray:
        value, error = self.value[key], self.error[key]
        if getattr(value, "shape", ()):
            return EstimateArray(value, error)
        return Estimate(_plain(value), _plain(error))

    def __iter__(self) -> Iterator[Estimate | EstimateArray]:
        return (self[k] for k in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray[Any, Any]:
        """Return the values alone, for numpy."""
        return self.value.astype(dtype or self.value.dtype, copy=bool(copy))


def _plain(x: Any) -> float | Mpf:
    """Return a number of numpy as Python's own; others as they are."""
    number: float | Mpf = x.item() if hasattr(x, "item") else x
    return number
