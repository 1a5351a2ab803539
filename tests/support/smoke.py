"""Fifteen public calls, each with a value that is known another way. Run by ``python -m tests.support.smoke``.

What an extra needs and is not installed is skipped by name. Assertions of Python are not used: ``-O`` leaves them out.
"""

from __future__ import annotations

import importlib.util
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import hjsolve

KEPLER = {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}}
PERIOD = 2 * math.pi / 0.56**1.5  # E = 0.72 - 1 = -0.28


def near(value: object, expected: float, tolerance: float = 1e-13) -> None:
    """Fail where a number is not the one expected."""
    if not abs(float(value) - expected) <= tolerance * abs(expected):  # type: ignore[arg-type]
        raise SystemExit(f"{value} is not {expected}")


def holds(condition: object, what: str) -> None:
    """Fail where a statement is false."""
    if not condition:
        raise SystemExit(f"false: {what}")


def system() -> hjsolve.System:
    """The Kepler problem, typed."""
    return hjsolve.System(
        {"r": "0 < r", "theta": "angle"}, "m/2*(dot(r)^2 + r^2*dot(theta)^2)", "-k/r", {"m": 1, "k": 1}
    )


def motion(**options: object) -> object:
    """Its motion."""
    return hjsolve.solve(system()).motion(**KEPLER, **options)


def batch() -> None:
    """An ensemble of two orbits."""
    import numpy as np

    found = hjsolve.ensemble("kepler-planar", q={"r": np.ones(2), "theta": 0}, velocity={"r": 0, "theta": 1.2})
    near(found.frequencies["r"][1], 2 * math.pi / PERIOD)


def found() -> None:
    """Two centres in the plane."""
    V = "-m1/sqrt((x-d)**2+y**2) - m2/sqrt((x+d)**2+y**2)"
    given = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2+dot(y)**2)/2", V, {"m1": 1, "m2": 2, "d": 1})
    holds(hjsolve.solve(given, coordinates="find").chart.kind == "elliptic", "two centres separate in elliptic ones")


def report() -> None:
    """A report as text and as HTML."""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("a.txt", "a.html"):
            hjsolve.report("kepler-planar", Path(folder) / name, brief=True)
            holds((Path(folder) / name).stat().st_size > 1000, f"{name} is written")


def command() -> None:
    """The command line."""
    run = subprocess.run(
        [sys.executable, *(["-O"] if not __debug__ else []), "-m", "hjsolve", "check", "kepler-planar"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    holds(run.returncode == 0 and "\nSeparates in r" in run.stdout, f"check: {run.stdout}{run.stderr}")


def sweep() -> None:
    """A sweep to Parquet."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "s.toml"
        scene.write_text(
            'system = "kepler-planar"\nwant = ["actions"]\ninitial = {q = {theta = "0"}, velocity = {r = "0"}}\n'
            '[sweep]\nq = {r = {start = "1", stop = "2", count = 3}}\nvelocity = {theta = {start = "1", stop = "1.1", '
            "count = 2}}\n"
        )
        run = subprocess.run(
            [sys.executable, "-m", "hjsolve", "sweep", str(scene), "-o", str(Path(folder) / "o"), "--quiet"],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        holds(run.returncode == 0, f"sweep: {run.stdout}{run.stderr}")


def units() -> None:
    """Quantities of astropy and of pint."""
    import astropy.units as u

    given = hjsolve.System(
        {"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "-GM/r", {"GM": 1},
        units={"r": "kpc", "t": "Myr"},
    )  # fmt: skip
    state = hjsolve.solve(given).motion(
        q={"r": 1 * u.kpc, "theta": 0}, velocity={"r": 0 * u.kpc / u.Myr, "theta": 1.2 / u.Myr}
    )
    near(state.periods["r"].value, PERIOD)
    import pint

    near(state.to_units(pint.UnitRegistry()).periods["r"].value.magnitude, PERIOD)


CALLS: dict[str, tuple[tuple[str, ...], Callable[[], object]]] = {
    "separate": ((), lambda: holds(isinstance(hjsolve.separate(system()), hjsolve.Separation), "Kepler separates")),
    "motion": ((), lambda: near(motion().periods["r"].value, PERIOD)),
    "at": ((), lambda: near(motion().at(PERIOD / 2).q["r"], 18 / 7)),
    "time_at": ((), lambda: near(motion().time_at("r", "18/7").value, PERIOD / 2, 1e-7)),
    "30 digits": ((), lambda: near(motion(digits=30).periods["r"].value, PERIOD)),
    "angles": ((), lambda: holds(motion().angles(0).error["r"] < 1e-14, "angles have errors")),
    "certified": (("flint",), lambda: holds(motion(certified=True).periods["r"].certified, "the period is certified")),
    "ensemble": ((), batch),
    "find": ((), found),
    "closed forms": ((), lambda: holds(hjsolve.closed_forms(motion())[0].periods["r"] is not None, "T is written")),
    "report": (("matplotlib", "rich"), report),
    "cost": (("flint",), lambda: holds(hjsolve.cost("kepler-planar", seconds=3), "costs are measured")),
    "sweep": (("pyarrow",), sweep),
    "units": (("astropy", "pint"), units),
    "command line": ((), command),
}


def main() -> int:
    """Run all of them."""
    for name, (needed, call) in CALLS.items():
        missing = [module for module in needed if importlib.util.find_spec(module) is None]
        if missing:
            print(f"{name}: skipped, without {', '.join(missing)}")
            continue
        call()
        print(f"{name}: ok", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
