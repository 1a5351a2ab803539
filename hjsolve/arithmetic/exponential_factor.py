"""Formulas with exponentials over disks far out: f = e^{λq} φ with a disk for φ.

Where all λ are multiples of one number ``arithmetic.local_expansion`` knows more; here they may be anything: these are
its expansions without differences, in u = e^{−|q|} and of any real order −λ·sign q.

A disk that holds e^z over |z − c| ≤ r holds 0 as soon as r is above log 2, and cosh overflows; but what a motion needs
is a quotient, 8 e^{2q}/(1 + e^{2q})², whose exponentials go together: λ = −2, and φ = 8/(1 + e^{−2q})² is nearly
constant.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks
from hjsolve.arithmetic.local_expansion import LocalExpansion, Locals
from hjsolve.arithmetic.number_types import Reals
from hjsolve.errors import required

EXPONENTIAL = frozenset({"exp", "sinh", "cosh", "sech"})
_LARGE = 600.0
_D = Disks()


class Rates(Locals):
    """Arithmetic on e^{λq} φ over disks that all lie on one side of 0; ``LocalExpansion.order`` is λ/``rate``."""

    @staticmethod
    def over(q: Disk, side: int) -> Rates:
        """Return the arithmetic over some disks.

        Args:
            q: the disks.
            side: the sign of their real parts.
        """
        return Rates(q, 0, rate=-float(side), q=q)

    def _scale(self, n: float) -> Disk:
        return _D.unary("exp", _D.times(required(self.q), n * self.rate))

    def _order(self, rate: float) -> float:
        return rate / self.rate

    def _unary(self, name: str, x: LocalExpansion) -> LocalExpansion:
        if name == "sqrt" and not x.constant:  # e^{λq/2} has no branch point
            return LocalExpansion(x.order / 2, (_D.unary("sqrt", x.parts[0]),))
        return super()._unary(name, x)

    def _exponential(self, name: str, line: tuple[Disk, Disk]) -> LocalExpansion:
        a, b = line
        if abs(np.real(b.centre)) > _LARGE:  # about a place far away: e^b would overflow
            return LocalExpansion(0, (_D.unary(name, _D.add(_D.mul(a, required(self.q)), b)),))
        return super()._exponential(name, line)


def largest(q: Disk, rate: float) -> Reals:
    """Return the exponent of the largest |e^{λq}|.

    Args:
        q: disks.
        rate: λ.
    """
    return rate * np.real(q.centre) + abs(rate) * q.radius
