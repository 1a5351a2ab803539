"""Transition matrices against the variational equations, integrated in quadruple precision by heyoka.

    python -m benchmarks.variational                     # 12 systems, up to 100 periods; needs the extra ``bench``
    python -m benchmarks.variational --far               # symplectic defects at a million periods

Truth is Taylor's method on Hamilton's equations and their variational equations: no quadrature, no separation, and H
derived from T and V by sympy alone (``quad_twin``). The error is relative to the largest entry of the matrix.
"""

from __future__ import annotations

import argparse
import functools
import time
from typing import Any

import mpmath
import numpy as np

import hjsolve
from hjsolve import catalog

SYSTEMS = (
    "kepler-planar", "kepler-spherical", "isochrone", "pendulum", "spherical-pendulum", "kuzmin-kutuzov",
    "two-centres-plane", "lagrange-top", "morse", "henon-heiles-separable", "double-well", "calogero-moser",
)  # fmt: skip
PERIODS = (1, 10, 100)
FAR = 1e6


@functools.cache
def initial(name: str) -> dict[str, Any]:
    """Return Initial data of the catalog's own motion."""
    return catalog.describe(name).initial.arguments


def slowest_period(motion: Any) -> float:
    """Return the longest period; 5 where there is none."""
    return max((float(p.value) for p in motion.periods.values()), default=5.0)


def integrated(name: str, motion: Any, times: list[float]) -> list[Any]:
    """∂(q, p)(t)/∂(q, p)(t₀) by heyoka in quadruple precision, one matrix a time."""
    import heyoka as hy
    import sympy as sp

    from benchmarks import quad_twin

    system = motion.solution.system
    names = [c.name for c in system.coordinates]
    H, _ = quad_twin._formulas(name)
    H = H.xreplace({sp.Symbol(p.name): motion.initial.values[p.symbol] for p in system.parameters})
    variables = [sp.Symbol(prefix + n) for prefix in ("", "p_") for n in names]
    known = {s: hy.make_vars(f"x{k}") for k, s in enumerate(variables)}
    n = len(names)
    rates = [H.diff(p) for p in variables[n:]] + [-H.diff(q) for q in variables[:n]]
    sys = [(known[v], quad_twin._built(r, known) + 0 * known[v]) for v, r in zip(variables, rates, strict=True)]
    symbols = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    start = [quad_twin.quad(sp.N(motion.initial.values[s], 45)) for s in symbols]
    equations = hy.var_ode_sys(sys, hy.var_args.vars)
    stepper = hy.taylor_adaptive(
        equations, start, fp_type=quad_twin.Quad, tol=quad_twin.Quad("1e-30"), compact_mode=True
    )
    result = []
    for t in times:
        stepper.propagate_until(quad_twin.quad(t))
        with mpmath.workdps(40):
            numbers = [mpmath.mpf(str(x)) for x in stepper.state[2 * n :]]
        result.append(np.array(numbers, dtype=object).reshape(2 * n, 2 * n))
    return result


def against_integration(names: tuple[str, ...]) -> None:
    """Print errors and claims of twelve systems at 1, 10 and 100 periods."""
    print("system                  periods  |M|       error/|M|  error/claim  defect    defect claim  ms")
    for name in names:
        motion = hjsolve.solve(catalog.load(name)).motion(**initial(name))
        times = [float(f"{k * slowest_period(motion):.4f}") for k in PERIODS]
        motion.transition_matrix(times[0])
        begin = time.perf_counter()
        found = motion.transition_matrix(times)
        took = (time.perf_counter() - begin) / len(times)
        for k, truth in enumerate(integrated(name, motion, times)):
            M, claim = found.value[k], found.error[k]
            with mpmath.workdps(40):
                error = np.abs(truth - M.astype(object)).astype(float)
            size = float(np.abs(truth).max())
            resolved = np.maximum(claim, 1e-25 * size)  # what the integration leaves open
            ratio = float(np.max(error / resolved))
            defect, bound = symplectic(M, claim)
            print(
                f"{name:24s}{PERIODS[k]:6d}   {size:8.1e}  {error.max() / size:8.1e}   {ratio:8.2f}    {defect:8.1e}"
                f"  {bound:8.1e}     {1e3 * took:.0f}",
                flush=True,
            )


def symplectic(M: Any, claim: Any) -> tuple[float, float]:
    """Return the largest entry of MᵀJM − J, and what the errors claimed allow."""
    n = len(M) // 2
    J = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    defect = np.abs(M.T @ J @ M - J).max()
    rounding = 2 * n * 2.0**-52 * (np.abs(M).T @ np.abs(M)).max()  # of the products here
    return float(defect), float((claim.T @ np.abs(J @ M) + np.abs(M.T @ J) @ claim).max() + rounding)


def far(names: tuple[str, ...]) -> None:
    """Print symplectic defects at a million periods, and how much longer that took than one period."""
    print("system                  |M|       condition  defect    claim     defect/condition  ms   ms at 1 period")
    for name in names:
        motion = hjsolve.solve(catalog.load(name)).motion(**initial(name))
        T = slowest_period(motion)
        motion.transition_matrix(T)
        took = []
        for t in (T, FAR * T):
            begin = time.perf_counter()
            found = motion.transition_matrix(t)
            took.append(1e3 * (time.perf_counter() - begin))
        M = found.value
        defect, bound = symplectic(M, found.error)
        condition = np.abs(M).max() ** 2
        print(
            f"{name:24s}{np.abs(M).max():8.1e}  {condition:8.1e}   {defect:8.1e}  {bound:8.1e}"
            f"  {defect / condition:8.1e}"
            f"          {took[1]:.0f}   {took[0]:.0f}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--far", action="store_true", help="a million periods")
    parser.add_argument("names", nargs="*", help="catalog entries")
    options = parser.parse_args()
    (far if options.far else against_integration)(tuple(options.names) or SYSTEMS)


if __name__ == "__main__":
    main()
