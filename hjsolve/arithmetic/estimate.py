"""A number that carries how good it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with a bound on its error.

    What is integrated over a bounded coordinate rests on as many nodes as a proved strip of analyticity asks for
    (``one_coordinate.resolution``, docs/theory.md): no feature of a potential is too narrow to be counted. The error is
    the rounding of the value and what is known to be lost on the way to it.

    Attributes:
        value: the number; float up to 15 digits, ``mpf`` above. An array of them where times in an array were asked.
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
        errors = self.error.ravel() if hasattr(self.error, "ravel") else [self.error]
        return f"{self.value} ± {float(max(errors, default=0.0)):.1e}"
