"""Public calls of every kind, run in a fresh process by a number of threads at once; what each gives, to the last bit, is printed as JSON.

    python -m tests.support.thread_jobs THREADS NUMBA JOB …

NUMBA is ``numba`` or ``plain``. Each thread runs every job; the threads begin together, each with another job.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

USERS_DIGITS, USERS_BITS = 23, 77
_TIMES = ("seconds", "solution", "separation")


def bits(value: Any) -> Any:
    """A value as text and numbers that show every bit of it.

    Args:
        value: an estimate, a number, an array, or a container of them.
    """
    if isinstance(value, Mapping):
        return {str(key): bits(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [bits(item) for item in value]
    if isinstance(value, np.ndarray):
        return [bits(item) for item in value.tolist()]
    if hasattr(value, "_mpf_"):
        return [int(part) for part in value._mpf_]
    if isinstance(value, float):
        return value.hex()
    return [bits(value.value), bits(value.error)] if hasattr(value, "error") else str(value)


def fields(value: Any) -> dict[str, str]:
    """The fields of a value as text, but for the seconds that it took.

    Args:
        value: a dataclass.
    """
    return {f.name: str(getattr(value, f.name)) for f in dataclasses.fields(value) if f.name not in _TIMES}


def motion(**more: Any) -> Any:
    """Results of a motion and of a state."""
    import hjsolve

    found = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": "0.1", "theta": "1.2"}, **more)
    state = found.at("7.25")
    told = [found.constants, found.turning_points, found.actions, found.frequencies, found.periods]
    return bits([*told, state.q, state.p, state.velocity, state.error.q])


def ensemble() -> Any:
    """Orbits of Kepler's problem, nearly radial ones among them, whose anomaly is stretched."""
    import hjsolve

    k = np.arange(20)
    q, p = {"r": 1 + 0.025 * k, "theta": 0}, {"r": 0.1, "theta": 10.0 ** (-0.3 - k % 5)}
    found = hjsolve.ensemble(
        "kepler-planar", q=q, p=p, want={"actions", "frequencies", "angles"}, shown=False,
    )  # fmt: skip
    return bits(found.columns)


def forms() -> Any:
    """Closed forms of a quartic oscillator, and numbers of one of them."""
    import hjsolve

    oscillator = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "x**4/4 + 3*x**2/2", {"m": 1})
    return [fields(form) for form in hjsolve.closed_forms(hjsolve.solve(oscillator), seconds=600)]


def separate() -> Any:
    """Verdicts of both kinds."""
    import hjsolve

    return [fields(hjsolve.separate(name)) for name in ("henon-heiles", "two-centres-plane")]


def find() -> Any:
    """Coordinates that a search finds."""
    import hjsolve

    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**2 + 4*y**2 + 1/x**2")
    return fields(hjsolve.find_coordinates(system))


def functions() -> Any:
    """Functions of the user's numbers, at the user's precision."""
    import mpmath
    import sympy as sp

    from hjsolve import functions as own

    x = sp.Symbol("x")
    function = sp.lambdify(x, own.JacobiSN(x, sp.Rational(1, 3)), own.modules("mpmath"))
    return bits(function(mpmath.mpf(3) / 7))


JOBS: dict[str, Callable[[], Any]] = {
    "motion": motion,
    "50 digits": lambda: motion(digits=50),
    "certified": lambda: motion(certified=True),
    "certified, 40 digits": lambda: motion(certified=True, digits=40),
    "ensemble": ensemble,
    "closed forms": forms,
    "separate": separate,
    "find": find,
    "functions": functions,
}


def _told(job: str) -> str:
    try:
        return json.dumps(JOBS[job]())
    except Exception as error:  # noqa: BLE001 - a test reports it
        return f"{type(error).__name__}: {error}"


def all_told(jobs: list[str], threads: int) -> Iterator[dict[str, str]]:
    """What each thread is told by each job.

    Args:
        jobs: their names.
        threads: how many.
    """
    together, found = threading.Barrier(threads), [dict[str, str]() for _ in range(threads)]

    def work(k: int) -> None:
        together.wait()
        for i in range(len(jobs)):
            job = jobs[(i + k * len(jobs) // threads) % len(jobs)]
            found[k][job] = _told(job)

    workers = [threading.Thread(target=work, args=(k,)) for k in range(threads)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    yield from found


def main(threads: str, numba: str, *jobs: str) -> None:
    """Run the jobs and print what they told, and what is left of the user's settings."""
    if numba == "plain":
        sys.modules["numba"] = None  # type: ignore[assignment]
    import flint
    import mpmath
    import sympy  # noqa: F401 - it adds a filter for warnings of its own when it is imported

    mpmath.mp.dps, flint.ctx.prec = USERS_DIGITS, USERS_BITS
    filters = list(warnings.filters)
    sys.setswitchinterval(1e-4)
    told = list(all_told(list(jobs), int(threads)))
    kept = {
        "mpmath": mpmath.mp.dps == USERS_DIGITS,
        "flint": flint.ctx.prec == USERS_BITS,
        "warnings": warnings.filters == filters,
    }
    print(json.dumps({"told": told, "kept": kept}))


if __name__ == "__main__":
    main(*sys.argv[1:])
