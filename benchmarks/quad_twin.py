"""Hamilton's equations integrated in quadruple precision by heyoka: q(t), p(t) known another way, to about 1e-30.

No quadrature, no separation, no turning points, and H derived from T and V by sympy alone (tests/reference/mechanics);
the right-hand side of each catalog entry is compiled once.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import heyoka as hy
import mpmath
import numpy as np
import sympy as sp

from hjsolve import catalog
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import hamiltonian as extended_hamiltonian
from hjsolve.mechanics.system import momenta as extended_momenta
from tests.reference import mechanics

Quad = hy.real128
_MOST_STEPS = 1500
_LONG = 80
_ENERGY = 1e-22
"""How much the energy may change against kinetic and potential energy."""
_FUNCTIONS = {sp.sin: hy.sin, sp.cos: hy.cos, sp.tan: hy.tan, sp.exp: hy.exp, sp.log: hy.log, sp.sinh: hy.sinh,
              sp.cosh: hy.cosh, sp.tanh: hy.tanh, sp.asin: hy.asin, sp.atan: hy.atan}  # fmt: skip


def quad(x: Any) -> Any:
    """Round a number to quadruple precision, through forty decimal digits."""
    with mpmath.workdps(45):
        return Quad(mpmath.nstr(mpmath.mpf(x), 40))


def _built(expr: sp.Expr, known: Mapping[sp.Symbol, Any]) -> Any:
    """Return a sympy expression as a heyoka one, every number in quadruple precision."""
    if expr in known:
        return known[expr]
    if not expr.free_symbols:
        return hy.expression(quad(sp.N(expr, 45)))
    if expr.is_Add:
        return hy.sum([_built(a, known) for a in expr.args])
    if expr.is_Mul:
        return hy.prod([_built(a, known) for a in expr.args])
    if expr.is_Pow:
        base = _built(expr.base, known)
        if expr.exp == sp.Rational(1, 2):
            return hy.sqrt(base)
        return base ** _built(expr.exp, known)
    return _FUNCTIONS[expr.func](_built(expr.args[0], known))


@functools.cache
def _formulas(name: str) -> tuple[sp.Expr, dict[str, sp.Expr]]:
    """H(q, p) and p(q, v) in plain symbols q, p_q, v_q."""
    entry = catalog.describe(name)
    if entry.kind == "separable":
        kinetic, _ = mechanics.kinetic_and_potential(name)
        return mechanics.hamiltonian(name), {
            c.name: kinetic.diff(sp.Symbol(f"v_{c.name}")) for c in entry.system.coordinates
        }
    plain = {p.symbol: sp.Symbol(p.name) for p in entry.system.parameters}
    for c in entry.system.coordinates:
        plain |= {c.symbol: sp.Symbol(c.name), c.momentum: sp.Symbol(f"p_{c.name}")}
        plain[c.velocity] = sp.Symbol(f"v_{c.name}")
    ours = extended_momenta(entry.system)
    return extended_hamiltonian(entry.system).xreplace(plain), {n: f.xreplace(plain) for n, f in ours.items()}


@functools.cache
def _integrator(name: str) -> Any:
    names = [c.name for c in catalog.describe(name).system.coordinates]
    H, _ = _formulas(name)
    variables = [sp.Symbol(f"{prefix}{n}") for prefix in ("", "p_") for n in names]
    known: dict[sp.Symbol, Any] = {s: hy.make_vars(f"x{k}") for k, s in enumerate(variables)}
    known |= {sp.Symbol(n): hy.par[k] for k, n in enumerate(_used(name))}
    slopes = [H.diff(sp.Symbol(f"p_{n}")) for n in names] + [-H.diff(sp.Symbol(n)) for n in names]
    equations = [(known[s], _built(f, known)) for s, f in zip(variables, slopes, strict=True)]
    ones = np.array([Quad("1")] * len(_used(name)), dtype=Quad)
    return hy.taylor_adaptive(equations, np.array([Quad("0.3")] * len(equations), dtype=Quad), fp_type=Quad,
                              compact_mode=sp.count_ops(slopes) > _LONG, pars=ones)  # fmt: skip


@functools.cache
def _energy(name: str) -> Callable[..., Any]:
    """H from q, p and the parameters that it holds, in mpmath."""
    names = [c.name for c in catalog.describe(name).system.coordinates]
    symbols = [sp.Symbol(f"{prefix}{n}") for prefix in ("", "p_") for n in names]
    return sp.lambdify([*symbols, *(sp.Symbol(n) for n in _used(name))], _formulas(name)[0], "mpmath")


def _kept(name: str, before: Sequence[Any], after: Sequence[Any], parameters: Sequence[Any]) -> bool:
    """Return True where the energy is the same: a step over a singularity, as r = 0, changes it."""
    energy, half = _energy(name), len(after) // 2
    try:
        first, last = (energy(*state, *parameters) for state in (before, after))
        resting = energy(*after[:half], *(0 * x for x in after[half:]), *parameters)
    except ZeroDivisionError:
        return False
    return bool(abs(last - first) <= _ENERGY * (abs(last - resting) + abs(resting)))


def ready(name: str) -> None:
    """Compile the right-hand side of an entry, which may take longer than the motions."""
    _integrator(name)


def _used(name: str) -> list[str]:
    """Return the parameters that Hamilton's equations hold."""
    there = {s.name for s in _formulas(name)[0].free_symbols}
    return [p.name for p in catalog.describe(name).system.parameters if p.name in there]


def states(name: str, given: Mapping[str, Mapping[str, object]], times: Sequence[float]) -> list[dict[str, Any] | None]:
    """Where the motion is at times after its start.

    Args:
        name: entry of the catalog.
        given: q, velocity and parameters, as for ``solution.motion``.
        times: floats of either sign, taken as the exact numbers they are.

    Returns:
        For each time q and p by name (``q.x``, ``p.x``) as ``mpf``; angles are not reduced. None where the
        integration did not get there (a singularity before, or too many steps) or did not keep the energy.
    """
    system = catalog.describe(name).system
    with mpmath.workdps(60):
        point = {sp.Symbol(p.name): number(given["parameters"].get(p.name, p.value), source=p.name)
                 for p in system.parameters}  # fmt: skip
        fixed = [mpmath.mpf(sp.N(point[sp.Symbol(n)], 45)) for n in _used(name)]
        parameters = [quad(x) for x in fixed]
        point |= {sp.Symbol(c.name): number(given["q"][c.name], source=c.name) for c in system.coordinates}
        point |= {sp.Symbol(f"v_{c.name}"): number(given["velocity"][c.name], source=c.name)
                  for c in system.coordinates}  # fmt: skip
        begin = [sp.N(point[sp.Symbol(c.name)], 45) for c in system.coordinates]
        begin += [sp.N(_formulas(name)[1][c.name].subs(point), 45) for c in system.coordinates]
    results: list[dict[str, Any] | None] = [None] * len(times)
    for side in (1, -1):
        flow = _integrator(name)
        flow.state[:] = [quad(x) for x in begin]
        if parameters:
            flow.pars[:] = parameters
        flow.time = Quad("0")
        for m in sorted((m for m, t in enumerate(times) if t * side >= 0), key=lambda m: abs(times[m])):
            outcome = flow.propagate_until(Quad(times[m]), max_steps=_MOST_STEPS)[0]
            if outcome != hy.taylor_outcome.time_limit:
                break
            with mpmath.workdps(45):
                numbers = [mpmath.mpf(str(x)) for x in flow.state]
                if not _kept(name, [mpmath.mpf(x) for x in begin], numbers, fixed):
                    break
            names = [f"{what}.{c.name}" for what in "qp" for c in system.coordinates]
            results[m] = dict(zip(names, numbers, strict=True))
    return results
