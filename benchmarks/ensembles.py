"""Actions and frequencies in a Kuzmin–Kutuzov galaxy, five families of orbits, against 32-digit references.

    python benchmarks/ensembles.py [copies]

Error stands beside time. Inputs are prolate momenta, or cylindrical velocities carried over here: with Δ = 1,
sinh(u + iw) = R + iz, improved by a Newton step in 32 digits, and p_u, p_w from the Jacobian in 32 digits; the result
is rounded once, so the conversion adds half an ulp of each prolate number. Times are CPU seconds of the calling thread,
medians of five, so that a busy machine disturbs them less. ``peers.py`` has the rivals.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import hjsolve
from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.ensembles import engine as batch
from hjsolve.ensembles.engine.programs import available

DATA = Path(__file__).resolve().parents[1] / "tests" / "support" / "kuzmin_kutuzov.npz"
COLUMNS = (("actions", "u"), ("actions", "w"), ("frequencies", "u"), ("frequencies", "phi"), ("frequencies", "w"))


def prolate(cylindrical: Any) -> Any:
    """Carry rows R, v_R, v_T, z, v_z over to u, w, p_u, p_w, p_φ."""
    D = DoubleDouble()
    R, vR, vT, z, vz = (Pair(x, 0.0 * x) for x in cylindrical.T)
    first = np.arcsinh(cylindrical[:, 0] + 1j * cylindrical[:, 3])
    u, w = Pair(first.real, 0.0 * first.real), Pair(first.imag, 0.0 * first.imag)
    for _ in range(2):
        s, c, sn, cn = D.unary("sinh", u), D.unary("cosh", u), D.unary("sin", w), D.unary("cos", w)
        A, B = D.mul(c, cn), D.mul(s, sn)
        f, g = D.sub(D.mul(s, cn), R), D.sub(D.mul(c, sn), z)
        size = D.add(D.mul(A, A), D.mul(B, B))
        u = D.sub(u, D.div(D.add(D.mul(A, f), D.mul(B, g)), size))
        w = D.sub(w, D.div(D.sub(D.mul(A, g), D.mul(B, f)), size))
    s, c, sn, cn = D.unary("sinh", u), D.unary("cosh", u), D.unary("sin", w), D.unary("cos", w)
    A, B = D.mul(c, cn), D.mul(s, sn)
    pu, pw = D.add(D.mul(A, vR), D.mul(B, vz)), D.sub(D.mul(A, vz), D.mul(B, vR))
    return np.stack([x.high for x in (u, w, pu, pw, D.mul(R, vT))], axis=1)


def timed(run: Any) -> tuple[float, Any]:
    result, seconds = run(), []
    for _ in range(5):
        begin = time.thread_time()
        result = run()
        seconds.append(time.thread_time() - begin)
    return statistics.median(seconds), result


def main(copies: int) -> None:
    solution = hjsolve.solve(hjsolve.catalog.load("kuzmin-kutuzov"))
    with np.load(DATA) as file:
        data = dict(file)
    print(f"{copies} copies of 40 orbits a family")
    print("input       family         want                    µs/orbit  ok %  max error/limit  max error/claim")
    for kind in ("prolate", "cylindrical"):
        rows = data["prolate"] if kind == "prolate" else prolate(data["cylindrical"])
        for want in (("actions",), ("actions", "frequencies"), ("actions", "frequencies", "angles")):
            engine = batch.build(solution, frozenset(want), compiled=available())
            for family, title in enumerate(data["family_names"]):
                chosen = np.flatnonzero(data["family"] == family)
                u, w, pu, pw, pφ = np.tile(rows[chosen], (copies, 1)).T
                q, p = {"u": u, "w": w, "phi": 0 * u}, {"u": pu, "w": pw, "phi": pφ}
                seconds, columns = timed(lambda: engine.run(q, p))
                shares, claims = [], []
                for k, (quantity, name) in enumerate(COLUMNS):
                    if quantity in want:
                        high, low, floor = (
                            data[f"{part}_{kind}{tail}"][chosen, k]
                            for part, tail in (("reference", "_high"), ("reference", "_low"), ("floor", ""))
                        )
                        error = np.abs((columns.group(quantity)[name][: len(chosen)] - high) - low)
                        shares.append(np.nanmax(error / np.abs(high) / np.maximum(1e-12, 20 * floor)))
                        claims.append(np.nanmax(error / columns.error[f"{quantity}.{name}"][: len(chosen)]))
                good = 100 * np.mean(columns.status == batch.Status.OK)
                claim = max(claims) if kind == "prolate" else float("nan")
                title_ = f"{kind:11} {title:14} {'+'.join(want):24}{seconds / len(u) * 1e6:8.1f}"
                print(f"{title_} {good:6.1f} {max(shares):12.2g} {claim:15.2g}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 250)
