"""The kernels of the orbit engine, compiled before they are needed."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from hjsolve.arithmetic.machine.compiling import available
from hjsolve.arithmetic.machine.operations import APART, NAMES
from hjsolve.arithmetic.machine.run import prepared
from hjsolve.ensembles.orbit_derivatives import ensemble_derivatives
from hjsolve.ensembles.orbits import ensemble

_STARTS = {
    "kepler-planar": ({"r": 1.0, "theta": 0.0}, {"r": [0.1, 1e-9, 0.3], "theta": [1.1, 1.0, 1e-6]}),
    "pendulum": ({"theta": 0.1}, {"theta": [0.3, 3.0, 1.9999999]}),
}
"""Librations, small motions, rotations, and motions that take 32 digits."""
_TORI: dict[str, dict[str, object]] = {
    "kepler-planar": {"r": [0.1, 0.2, 0.3, 1e9], "theta": 1.0},
    "pendulum": {"theta": [9.0, 10.0]},
}
"""Actions of neighbours, of a nearly unbound orbit, whose phases take short arcs, and of rotations."""
_SMALL_ANGLE = 1e-15
"""Next to a turning point, where phases take short arcs."""


def compile_kernels(progress: Callable[[float, str], None] = lambda _part, _words: None) -> float | None:
    """Compile all kernels and operations, or read them from disk where they are there already.

    Args:
        progress: told what part is done, 0 … 1, and in words what is compiled.

    Returns:
        The seconds of processor time that it took; None where numba (extra ``fast``) is not installed or switched off.
    """
    if not available():
        return None
    begin, apart = time.process_time(), range(APART, len(NAMES))
    count = len(apart) + len(_STARTS) + len(_TORI)
    for number, code in enumerate(apart):
        progress(number / count, NAMES[code])
        prepared(frozenset({code}))
    for number, (name, (q, p)) in enumerate(_STARTS.items(), len(apart)):
        progress(number / count, "kernels")
        ensemble(name, q=q, p={c: np.array(x) for c, x in p.items()}, threads=1, shown=False, fallback=False)
        ensemble_derivatives(name, q=q, p={c: np.array(x) for c, x in p.items()}, threads=1)
    for number, (name, actions) in enumerate(_TORI.items(), len(apart) + len(_STARTS)):
        progress(number / count, "kernels of states")
        J = {c: np.array(x) for c, x in actions.items()}
        ensemble(name, actions=J, angles=dict.fromkeys(J, _SMALL_ANGLE), threads=1, shown=False, fallback=False)
    progress(1.0, "")
    return time.process_time() - begin
