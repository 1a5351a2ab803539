"""The kernels as plain Python, and compiled for another processor: the same statuses, results within both claims."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hjsolve.arithmetic.machine.compiling import available

ORBITS = """
import pickle, sys
import numpy as np
import hjsolve

def asked(system, q, p):
    want = ("actions", "frequencies", "angles")
    batch = hjsolve.ensemble(system, q=q, p=p, want=set(want), fallback=False, shown=False)
    columns = {w: {n: (getattr(batch, w)[n], batch.error[w][n]) for n in getattr(batch, w)} for w in want}
    return list(map(str, batch.status)), columns

r = {"r": np.array([1.0, 1.0, 0.7, 1.3, 2.0, 1.0]), "theta": 0.3}
l = {"r": np.array([0.1, 1e-7, 0.3, 0.8, 0.2, 3.0]), "theta": np.array([1.1, 1.0, 1e-6, -0.5, 0.9, 1.0])}
swing = {"theta": 0.1}, {"theta": np.array([0.3, 1.9, 3.0, -2.5])}
told = [asked("kepler-planar", r, l), asked("pendulum", *swing)]
"""
"""Circular, eccentric, nearly radial and unbound orbits; librations and rotations, one next to the separatrix."""

TELL = "sys.stdout.buffer.write(pickle.dumps(told))"

Found = list[tuple[list[str], dict[str, dict[str, tuple[Any, Any]]]]]


def found(**surroundings: str) -> Found:
    environment = {**os.environ, **surroundings, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, "-c", ORBITS + TELL], env=environment, capture_output=True, check=True)
    result: Found = pickle.loads(done.stdout)
    return result


def here() -> Found:
    """What this process finds, which saves another one."""
    names: dict[str, Any] = {}
    exec(ORBITS, names)
    result: Found = names["told"]
    return result


def agree(one: Found, other: Found) -> None:
    for (statuses, columns), (others, expected) in zip(one, other, strict=True):
        assert statuses == others
        assert {"ok"} < set(statuses) | {"unbounded"}
        ok = np.array(statuses) == "ok"
        for want, named in columns.items():
            for name, (value, error) in named.items():
                truth, claim = expected[want][name]
                assert np.all(np.abs(value - truth)[ok] <= (error + claim)[ok]), (want, name)
                assert np.all(error[ok] <= 2 * claim[ok]), (want, name)
                assert np.all(claim[ok] <= 2 * error[ok]), (want, name)


@pytest.mark.skipif(not available(), reason="nothing to compare with")
@pytest.mark.parametrize("switch", [{"HJSOLVE_COMPILED": "0"}, {"NUMBA_DISABLE_JIT": "1"}], ids=lambda s: next(iter(s)))
@pytest.mark.nightly_cases("NUMBA_DISABLE_JIT")
def test_plain_python_has_the_same_statuses_and_claims(switch: dict[str, str]) -> None:
    agree(found(**switch), here())


@pytest.mark.nightly
@pytest.mark.skipif(not available(), reason="nothing to compare with")
def test_a_processor_without_wide_vectors_has_the_same_statuses_and_claims(tmp_path: Path) -> None:
    tmp_path.chmod(0o700)
    features = "-avx512f,-avx512dq,-avx512bw,-avx512vl,-avx512cd,+avx2,+fma,+avx,+sse4.2,+sse4.1,+ssse3,+sse3,+sse2"
    small = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": features, "HJSOLVE_CACHE_DIR": str(tmp_path)}
    agree(found(**small), found())
