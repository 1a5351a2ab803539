"""Writes the table of docs/hard-cases.md from a run: ``python -m tests.support.hard_table``."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from tests.one_coordinate.test_turning_points import compare
from tests.support.hard_cases import Case, cases, measure
from tests.support.hard_turning import Turning, turning

PAGE = Path(__file__).resolve().parents[2] / "docs" / "hard-cases.md"
BEGIN, END = "<!-- table: python -m tests.support.hard_table -->", "<!-- end of the table -->"

PEERS = {
    "Kepler, e = 0": "heyoka kepE 9e-17",
    "Kepler, e = 0.9": "heyoka kepE 3e-14, DOP853 3e-9",
    "Kepler, e = 0.999999": "heyoka kepE 1e-6, DOP853 5e-4",
    "Kepler, e = 0.999999999999": "heyoka kepE 10 % NaN, DOP853 lost",
    "Kepler, e = 1": "heyoka Taylor 1e-11, DOP853 2e-8",
    "Kepler, e = 1.0000001": "heyoka Taylor 9e-13, DOP853 2e-8",
    "Kepler, e = -0.999999": "galpy Ω_φ 5e-4",
    "Kepler, e = 1e-8": "KerrGeoPy (Kerr, e = 1e-8) 9e-8",
    "pendulum, thrown with 1.999998": "period: scipy quad 9e-15 after sin(q/2) = k sin φ, 1e-9 raw",
    "pendulum, thrown with 1.999999999998": "period: scipy quad 2.4e-12 after sin(q/2) = k sin φ, claims 1e-14; raw: inf",
    "pendulum, thrown with 0.2, 1e+03 periods on": "scipy ellipj 2e-13, heyoka 9e-15, DOP853 8e-11",
    "pendulum, thrown with 0.2, 1e+09 periods on": "scipy ellipj 2e-7",
    "pendulum, thrown with 1.8, 1e+03 periods on": "scipy ellipj 3e-12, heyoka 1e-12, DOP853 5e-6",
    "pendulum, thrown with 1.8, 1e+09 periods on": "scipy ellipj 2e-6",
    "pendulum, thrown with 1.999998, 1e+03 periods on": "scipy ellipj 4e-8, heyoka 1e-5, DOP853 0.35",
    "pendulum, thrown with 1.999998, 1e+09 periods on": "scipy ellipj 4e-2",
    "pendulum, thrown with 1.999999999998, 1e+03 periods on": "scipy ellipj 99.5 % NaN, heyoka lost",
    "pendulum, thrown with 1.999999999998, 1e+09 periods on": "scipy ellipj 100 % NaN, heyoka lost",
    "spherical pendulum, dphi/dt = 1e-3 at theta = 1": "galpy Staeckel, nearly through the axis: 61 % NaN or inf",
}
"""Peers' figures as measured for this project on the same kind of motion (another machine load: errors only)."""


def closed_form(case: Case) -> str:
    """One row."""
    found = measure(case)
    period = f"{found.period_error:.0e}" if case.periods else "–"
    return _row(case.name, case.why, f"{found.error:.0e}", period, found.nodes, found.ratios)


def nutation(case: Turning) -> str:
    """One row."""
    worst, off, ratios, motion = compare(case)
    return _row(case.name, case.why, f"{worst:.0e}", f"{off:.0e}", motion.nodes, ratios)


def _row(name: str, why: str, place: str, period: str, nodes: int, ratios: np.ndarray) -> str:
    claims = f"{np.median(ratios):.0f}"
    return f"| {name} | {why} | {place} | {period} | {nodes or '–'} | {claims} | {PEERS.get(name, '–')} |"


def main() -> None:
    """Measure and write."""
    begin = time.perf_counter()
    head = [
        "| motion | why it is hard | q(t) | period, rates, action | nodes | claimed ÷ true | peers |",
        "|---|---|---|---|---|---|---|",
    ]
    rows = [*(closed_form(case) for case in cases()), *(nutation(case) for case in turning())]
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    PAGE.write_text(before + "\n".join([BEGIN, "", *head, *rows, "", END]) + after, encoding="utf-8")
    print(f"{len(rows)} rows in {time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
