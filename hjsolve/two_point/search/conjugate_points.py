"""How many places conjugate to the first lie along a motion: Maslov's index of the frame of its variations.

The frame (B, D) = (∂q/∂p0, ∂p/∂p0) is Lagrangian, so U = (D + iB)(D − iB)⁻¹ is unitary; its eigenvalues pass 1 where q
is conjugate to q0, all in one direction where T is positive definite. With φ_j their arguments in [0, 2π) and Φ that of
det U, followed continuously from 0, the number of conjugate points is (Φ − Σ φ_j)/2π, each counted with its
multiplicity (Arnold, Functional Analysis and its Applications 1 (1967) 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Reals

_WHOLE = 0.05
"""How far a count may be from a whole number."""


@dataclass(frozen=True)
class ConjugatePoints:
    """How det U turns.

    Attributes:
        scale: A of q = A⁻¹ x, units in which B is about the identity after the time: A M⁻¹ Aᵀ = 1/time.
    """

    scale: Reals

    def _scaled(self, frame: Reals) -> tuple[Reals, Reals]:
        """B and D in these units, of frames of shape (m, 2n, n)."""
        A, back, n = self.scale, np.linalg.inv(self.scale), len(self.scale)
        return A @ frame[:, :n] @ A.T, back.T @ frame[:, n:] @ A.T

    def rate(self, frame: Reals, rates: Reals) -> Reals:
        """Return (arg det U)' = 2 Im tr((D + iB)⁻¹ (D' + iB')), shape (m,).

        Args:
            frame, rates: B and D, and how they change; shape (m, 2n, n).
        """
        (B, D), (B_rate, D_rate) = self._scaled(frame), self._scaled(rates)
        try:
            return 2 * np.trace(np.linalg.solve(D + 1j * B, D_rate + 1j * B_rate), axis1=1, axis2=2).imag
        except np.linalg.LinAlgError:
            return np.full(B.shape[0], np.nan)

    def index(self, frame: Reals, argument: Reals) -> Integers:
        """Return how many conjugate points are passed; −1 where doubles do not decide them.

        Args:
            frame: B and D at the end, shape (m, 2n, n).
            argument: of det U, from 0 at the start; shape (m,).
        """
        B, D = self._scaled(frame)
        known = np.isfinite(B).all(axis=(1, 2)) & np.isfinite(D).all(axis=(1, 2)) & np.isfinite(argument)
        B, D = (np.where(known[:, None, None], x, np.eye(len(self.scale))) for x in (B, D))
        phases = np.angle(np.linalg.eigvals((D + 1j * B) @ np.linalg.inv(D - 1j * B))) % (2 * np.pi)
        turns = np.where(known, argument - np.sum(phases, axis=1), np.nan) / (2 * np.pi)
        with np.errstate(invalid="ignore"):
            return np.where(np.abs(turns - np.rint(turns)) < _WHOLE, np.rint(turns), -1).astype(int)
