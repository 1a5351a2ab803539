"""Resonances of Kerr's geodesics: how well the ratio is met, and in what time.

    python -m benchmarks.resonances [--count 200] [--seed 1]

Spin up to 0.998, e to 0.8, any inclination; half of the ratios are those of whole numbers up to 9, half are of the
small ratios 1:n that only geodesics next to the separatrix have. Each motion is run again with 30 digits.
"""

from __future__ import annotations

import argparse
import time
from fractions import Fraction

import numpy as np

import hjsolve
from hjsolve.errors import HJSolveError


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    kerr = hjsolve.solve(hjsolve.catalog.load("kerr"))
    off, room, seconds, missed = [], [], [], []
    for k in range(chosen.count):
        n = int(rng.integers(2, 10))
        m = int(rng.integers(1, n)) if k % 2 else 1
        n = n if k % 2 else int(rng.integers(8, 21))
        a, e = f"{rng.uniform(0, 0.998):.3f}", f"{rng.uniform(0.05, 0.8):.3f}"
        x = f"{rng.choice([-1, 1]) * rng.uniform(0.05, 0.99):.3f}"
        ratio = Fraction(m, n)
        asked = {"r": ratio.numerator, "theta": ratio.denominator}
        begin = time.process_time()
        try:
            motion = kerr.torus(ratio=asked, fixed={"a": a, "e": e, "x": x}, digits=30)
        except HJSolveError as fault:
            missed.append(f"{ratio} a={a} e={e} x={x}: {str(fault)[:160]}")
            print(missed[-1], flush=True)
            continue
        seconds.append(time.process_time() - begin)
        for one in motion if isinstance(motion, tuple) else (motion,):
            f = one.frequencies
            off.append(abs(float(abs(f["r"].value / f["theta"].value) * ratio.denominator / ratio.numerator - 1)))
            p = float(one.turning_points["r"][0].value) * (1 + float(e))
            room.append(p - hjsolve.separatrix(a, e, x).value)
    print(f"{len(seconds)} of {chosen.count} found, ratio off by at most {max(off):.1e} (digits=30)")
    print(f"p beyond the separatrix by {min(room):.1e} to {max(room):.1e}; {np.median(seconds):.1f} s each (median)")


if __name__ == "__main__":
    main()
