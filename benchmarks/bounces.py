"""Ten thousand bounces: processor time, true errors against closed forms in 60 digits next to what is claimed.

The energy is compared on every arc. Numbers whose claim is below their true error are counted as false. Run it
by ``python -m benchmarks.bounces [bounces]``.
"""

from __future__ import annotations

import sys
import time

from mpmath import mp

from hjsolve.scenes import Scene
from tests.support import billiards

RAYS = {**billiards.KEPLER, "events": [billiards.wall("theta", "1"), billiards.wall("theta", "-0.5")]}
CASES = {
    "ball on a floor": (billiards.BALL, billiards.ball, "12.3075", 1.02),
    "box": (billiards.BOX, billiards.box, "0.34625", 1.25),
    "quartic well": (billiards.QUARTIC, billiards.quartic, "0.5", 4.76),
    "Kepler in a circle": (billiards.CIRCLE, billiards.circle, "-0.375", 2.92),
    "Kepler between rays": (RAYS, billiards.rays, "-0.375", 2.31),
    "Kepler in a sector": (billiards.SECTOR, billiards.sector, "-0.375", 0.955),
}
"""Scene, closed form, energy, and the time of a bounce in the mean."""

HEADER = "scene", "bounces", "seconds", "error", "claim", "energy", "claim", "false"


def main(bounces: int) -> None:
    """Print a line for each scene."""
    print(("{:22} {:>8} {:>8}" + 4 * " {:>9}" + " {:>6}").format(*HEADER))
    for name, (table, truth, energy, each) in CASES.items():
        times = {"start": 0, "stop": round(each * bounces), "count": 201}
        scene = Scene.load({**table, "want": ["constants", "trajectory"], "times": times})
        begin = time.process_time()
        run = scene.run()
        spent = time.process_time() - begin
        path = run.trajectory
        assert path is not None
        claim = max(float(max(path.error.q[coordinate])) for coordinate in path.q)
        with mp.workdps(60):
            worst, false = billiards.violations(run, truth)
            energies = [arc.quantities["constants"]["E"] for arc in run.arcs]
            drifts = [abs(mp.mpf(E.value) - mp.mpf(energy)) for E in energies]
            false += sum(drift > E.error for drift, E in zip(drifts, energies, strict=True))
        parts = spent, float(worst), claim, float(max(drifts)), float(max(E.error for E in energies))
        numbers = "{:8.2f} {:9.1e} {:9.1e} {:9.1e} {:9.1e}".format(*parts)
        print(f"{name:22} {len(run.arcs) - 1:8} {numbers} {false:6}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
