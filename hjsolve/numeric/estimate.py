"""A number that carries how good it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with a bound on its error.

    Attributes:
        value: the number; float up to 15 digits, ``mpf`` above.
        error: absolute error, never below the true one unless the input itself was in doubt.
        certified: True where ``error`` is a proved bound (ball arithmetic), False where it is measured.
        nodes: quadrature nodes used, 0 where none were needed.
    """

    value: Any
    error: Any
    certified: bool = False
    nodes: int = 0

    def __float__(self) -> float:
        return float(self.value)

    def __str__(self) -> str:
        return f"{self.value} ± {float(self.error):.1e}"
