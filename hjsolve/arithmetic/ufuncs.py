"""numpy's functions of Estimates: ``np.sqrt(e)``, ``array * e``."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hjsolve.algebra.ranges import OF_TWO

_OF_ONE = {
    "sqrt": "sqrt", "cbrt": "cbrt", "exp": "exp", "expm1": "expm1", "log": "log", "log2": "log2", "log10": "log10",
    "log1p": "log1p", "sin": "sin", "cos": "cos", "tan": "tan", "arcsin": "asin", "arccos": "acos", "arctan": "atan",
    "sinh": "sinh", "cosh": "cosh", "tanh": "tanh", "arcsinh": "asinh", "arccosh": "acosh", "arctanh": "atanh",
    "absolute": "abs", "fabs": "abs", "negative": "neg", "square": "square", "reciprocal": "reciprocal",
    "rad2deg": "degrees", "degrees": "degrees", "deg2rad": "radians", "radians": "radians",
}  # fmt: skip
"""numpy's name → that of ``ranges.FUNCTIONS``."""
_COMPARISONS = {"less": "lt gt", "less_equal": "le ge", "greater": "gt lt", "greater_equal": "ge le", "equal": "eq eq"}
"""numpy's name → the method that answers, if the first operand is an Estimate and if the second is."""
_QUESTIONS: Mapping[str, Callable[[float], bool]] = {
    "isfinite": np.isfinite, "isnan": np.isnan, "isinf": np.isinf,
}  # fmt: skip


class Combined(Protocol):
    """How a function of numbers is worked out, of which at least one is an Estimate; ``estimate.combined``."""

    def __call__(self, name: str, /, *operands: object) -> object:
        """Return an Estimate; ``NotImplemented`` where an operand is not a real number."""


def of_estimates(
    kind: type, combined: Combined, ufunc: np.ufunc, method: str, inputs: tuple[object, ...],
    options: Mapping[str, object],
) -> object:  # fmt: skip
    """Answer a function of numpy for operands of which at least one is an Estimate.

    Args:
        kind: the class of Estimates.
        combined: gives a function of numbers of which one is an Estimate; ``estimate.combined``.
        method: how it was called; only the plain call is answered.
        inputs: operands; arrays are gone through element by element.
        options: of the call; none is answered.

    Returns:
        An Estimate, or an array of them; of a comparison, bool. ``NotImplemented`` for what has no answer here.
    """
    rule = _rule(kind, combined, ufunc.__name__)
    if rule is None or method != "__call__" or options:
        return NotImplemented
    if not any(isinstance(x, np.ndarray) and x.ndim for x in inputs):
        return rule(*(x[()] if isinstance(x, np.ndarray) else x for x in inputs))
    return np.frompyfunc(rule, len(inputs), 1)(*(x if isinstance(x, np.ndarray) else _boxed(x) for x in inputs))


def _boxed(x: object) -> NDArray[np.object_]:
    """Return an array without axes that holds an object as it is."""
    box = np.empty((), dtype=object)
    box[()] = x
    return box


def _rule(kind: type, combined: Combined, name: str) -> Callable[..., object] | None:
    if name in _OF_ONE:
        return partial(combined, _OF_ONE[name])
    if name in OF_TWO:
        return partial(combined, name)
    if name == "positive":
        return operator.pos
    if name in _QUESTIONS:
        return lambda x: bool(_QUESTIONS[name](float(x)))
    if name == "not_equal":
        return lambda x, y: not _compared(kind, "equal", x, y)
    return partial(_compared, kind, name) if name in _COMPARISONS else None


def _compared(kind: type, name: str, x: object, y: object) -> object:
    """Ask the Estimate, not numpy's number, which would ask here again."""
    forward, backward = (f"__{method}__" for method in _COMPARISONS[name].split())
    return getattr(x, forward)(y) if isinstance(x, kind) else getattr(y, backward)(x)
