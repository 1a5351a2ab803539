"""Products for many orbits at once in which an orbit's last bit does not depend on its company.

A matrix product by BLAS may add its terms in another order, and fuse them or not, when the number of rows or the place
of a row changes; results would then depend on chunks and threads. Single sums and products of arrays are rounded the
same everywhere, and start no threads of their own.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.number_types import Reals


def stacked(left: Reals, right: Reals) -> Reals:
    """Return left[n] · right[n] for every n, small matrices.

    Args:
        left: shape (n, i, j).
        right: shape (n, j, k).

    Returns:
        Shape (n, i, k).
    """
    terms = (left[:, :, j, None] * right[:, None, j, :] for j in range(left.shape[2]))
    total: Reals = sum(terms, start=np.zeros(()))
    return total
