"""Equations that the frequencies of a torus meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.motion.exact_numbers import to_bits


@dataclass(frozen=True)
class Equation:
    """Σ weight·|Ω| = target.

    Attributes:
        weights: coordinate → its factor, exact.
        target: the sum, exact.
    """

    weights: Mapping[str, sp.Expr]
    target: sp.Expr

    def of(self, rates: Mapping[str, Reals]) -> tuple[Reals, Reals]:
        """Return the left side less the right one, and the sum of the sizes of its terms.

        Args:
            rates: coordinate → Ω, arrays of one shape.
        """
        terms = np.stack([float(w) * np.abs(rates[name]) for name, w in self.weights.items()])
        target = float(self.target)
        return np.sum(terms, axis=0) - target, np.sum(np.abs(terms), axis=0) + abs(target)

    def exactly(self, rates: Mapping[str, Estimate], bits: int) -> tuple[Mpf, float, float]:
        """Return the same of one motion, to many digits: the difference, its error, and the size of the terms.

        Args:
            rates: coordinate → Ω.
        """
        context = multiprecision(bits)
        total, error, size = -to_bits(self.target)(bits), 0.0, abs(float(self.target))
        for name, weight in self.weights.items():
            w, rate = to_bits(weight)(bits), rates[name]
            total = total + w * abs(context.convert(rate.value))
            error += abs(float(w)) * float(rate.error)
            size += abs(float(w) * float(rate.value))
        return total, error, size
