"""Frames that hjsolve finds by itself in which a system with explicit time is autonomous.

Each candidate is a map q = f(Q, t), affine in Q, with a gauge Λ such that L(f, ḟ, t) = L′(Q, Q̇) + dΛ/dt; nothing is
believed before ``verified`` has proved that identity (Greenwood (6-143)–(6-153); his Ex 6-5, 6-9, P6-13).

- **scaled**: T = g(t) T₁(q̇): q = Q/s, s = √g, Λ = −½ (ṡ/s) QᵀMQ, V′ = V(Q/s, t) − ½ (s̈/s) QᵀMQ (Caldirola and Kanai).
- **uniform**: q = Q + v t, with ∂V/∂t + Σ v_i ∂V/∂q_i = 0 over coordinates that T does not hold: Galilean frames, and
  frames that turn where q is an angle.
- **accelerated**: q = Q + d(t), M constant, Λ = ḋᵀMQ + ∫ (½ ḋᵀMḋ − c) dt, V′ = V(Q + d, t) + d̈ᵀMQ − c(t). Where V is of
  second degree with constant stiffness K, M d̈ + K d = F(t) by undetermined coefficients; else ḋ follows from third
  derivatives of V.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp
from sympy.simplify.fu import TR8

from hjsolve.arithmetic.floats import Float64
from hjsolve.errors import HJSolveError, required
from hjsolve.extended.change_of_frame import verified
from hjsolve.extended.moving_frame import Frame
from hjsolve.lowering import lower
from hjsolve.mechanics.coordinates_and_parameters import free_name
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.separation.zero_test.zero_test import Zero, is_zero

_PLACES = tuple(
    tuple(map(sp.Rational, row.split()))
    for row in ("3/7 5/4 2/9 7/5 4/11", "6/5 1/3 8/7 2/5 9/8", "1/6 7/9 5/3 3/8 6/11")
)


@dataclass(frozen=True)
class _Posed:
    """L = ½ q̇ᵀMq̇ − V(q, t) on the way: the place and the gauge that led there from the system as posed."""

    kinetic: sp.Expr
    potential: sp.Expr
    place: Mapping[str, sp.Expr]
    gauge: sp.Expr


def find_frame(system: System) -> tuple[Frame | None, tuple[str, ...]]:
    """Look for a frame in which a system is autonomous.

    Args:
        system: with explicit time.

    Returns:
        The frame, verified, or None; and the kinds that were tried, in words.
    """
    new = _new_names(system)
    start = _start(system, new)
    tried: list[str] = []
    for words, candidates in (
        ("a frame that moves evenly", _uniform), ("an accelerated frame", _accelerated), ("a scaled one", _scaled),
    ):  # fmt: skip
        tried.append(words)
        for posed in candidates(system, new, start):
            if (frame := _frame(system, new, posed)) is not None:
                return frame, tuple(tried)
    return None, tuple(tried)


def _new_names(system: System) -> dict[str, str]:
    """Return a name of the new coordinate for each old one: X for x."""
    taken = [*system.symbols, *(c.momentum.name for c in system.coordinates)]
    names: dict[str, str] = {}
    for c in system.coordinates:
        wished = c.name[:1].upper() + c.name[1:]
        names[c.name] = free_name(wished if wished != c.name else f"{c.name}_f", [*taken, *names.values()])
    return names


def _symbols(system: System, new: Mapping[str, str]) -> tuple[list[sp.Symbol], list[sp.Symbol], sp.Symbol]:
    Q = [sp.Symbol(new[c.name], real=True) for c in system.coordinates]
    speeds = [sp.Symbol(f"dot({q.name})", real=True) for q in Q]
    return Q, speeds, required(system.time)


def _start(system: System, new: Mapping[str, str]) -> _Posed:
    Q, speeds, _ = _symbols(system, new)
    renamed = {c.symbol: q for c, q in zip(system.coordinates, Q, strict=True)}
    renamed |= {c.velocity: v for c, v in zip(system.coordinates, speeds, strict=True)}
    place = {c.name: q for c, q in zip(system.coordinates, Q, strict=True)}
    T, V = system.kinetic.xreplace(renamed), system.potential.xreplace(renamed)
    return _without_gauge(system, _Posed(T, V, place, sp.S.Zero), Q, speeds)


def _without_gauge(system: System, posed: _Posed, Q: list[sp.Symbol], speeds: list[sp.Symbol]) -> _Posed:
    """Linear terms a_i(q_i, t) q̇_i are d/dt of Λ = Σ ∫ a_i dq_i but for −∂Λ/∂t, which joins V as T₀ does."""
    rest = dict.fromkeys(speeds, sp.S.Zero)
    a = [sp.diff(posed.kinetic, v).subs(rest) for v in speeds]
    alone = all(not x.free_symbols & (set(Q) - {q}) for x, q in zip(a, Q, strict=True))
    T0, t = posed.kinetic.subs(rest), required(system.time)
    if (not any(a) and T0 == 0) or not alone:
        return posed
    Λ = sp.Add(*(sp.integrate(x, q) for x, q in zip(a, Q, strict=True)))
    if Λ.has(sp.Integral):
        return posed
    Λ += T0 * t if not T0.free_symbols & {*Q, t} else 0  # a constant joins the gauge, not V
    T2 = sp.expand(posed.kinetic - T0 - sp.Add(*(x * v for x, v in zip(a, speeds, strict=True))))
    V = posed.potential - T0 + sp.diff(Λ, t)
    return _Posed(T2, sp.expand(V), posed.place, posed.gauge + Λ)


def _frame(system: System, new: Mapping[str, str], posed: _Posed) -> Frame | None:
    """Return the frame of what is autonomous, proved; None where it is not, or the identity is not proved."""
    _, _, t = _symbols(system, new)
    if (posed.kinetic.free_symbols | posed.potential.free_symbols) & {t}:
        return None
    domains = {new[c.name]: c.domain.written(new[c.name]) for c in system.coordinates}
    parameters = {p.name: p for p in system.parameters if p.symbol != t}
    try:
        autonomous = System(domains, posed.kinetic, posed.potential, parameters, title=system.title)
        own = {sp.Symbol(c.name, real=True): c.symbol for c in autonomous.coordinates}
        place = {name: f.xreplace(own) for name, f in posed.place.items()}
        return verified(Frame(autonomous, system, place, posed.gauge.xreplace(own), t))
    except HJSolveError:
        return None


def _mass(system: System, posed: _Posed, speeds: list[sp.Symbol]) -> sp.Matrix | None:
    """M where T = ½ q̇ᵀMq̇ holds neither coordinates nor the time; None otherwise."""
    M = sp.hessian(posed.kinetic, speeds)
    fixed = {p.symbol for p in system.parameters if p.symbol != system.time}
    rest = posed.kinetic - (sp.Matrix(speeds).T * M * sp.Matrix(speeds))[0] / 2
    return M if sp.expand(rest) == 0 and M.free_symbols <= fixed else None


# ------------------------------------------------------------------------------------------------ uniform
def _uniform(system: System, new: Mapping[str, str], posed: _Posed) -> Iterator[_Posed]:
    """Q = Q + v t."""
    Q, speeds, t = _symbols(system, new)
    if t in posed.kinetic.free_symbols:
        return
    free = [k for k, q in enumerate(Q) if q not in posed.kinetic.free_symbols]
    v = [sp.Dummy(f"v_{k}") for k in free]
    rate = sp.diff(posed.potential, t) + sp.Add(*(x * sp.diff(posed.potential, Q[k]) for x, k in zip(v, free)))
    if not v or not _soluble([rate], v, [*Q, t]):
        return
    for values in _solutions(rate, v, [*Q, t]):
        d = [sp.S.Zero] * len(Q)
        for k, value in zip(free, values, strict=True):
            d[k] = value * t
        shift = dict(zip(Q, (q + x for q, x in zip(Q, d, strict=True)), strict=True))
        faster = {s: s + sp.diff(x, t) for s, x in zip(speeds, d, strict=True)}
        V = _without_time(posed.potential.subs(shift, simultaneous=True), t)
        if V is not None:
            place = {name: f.subs(shift, simultaneous=True) for name, f in posed.place.items()}
            T, Λ = sp.expand(posed.kinetic.subs(faster, simultaneous=True)), posed.gauge.subs(shift, simultaneous=True)
            yield _without_gauge(system, _Posed(T, V, place, Λ), Q, speeds)


def _solutions(condition: sp.Expr, unknown: list[sp.Dummy], at: list[sp.Symbol]) -> Iterator[list[sp.Expr]]:
    """Values of the unknowns, linear in the condition, with which it vanishes at some places; free ones are 0."""
    equations = []
    for row in _PLACES:
        for turn in range(len(at)):
            place = dict(zip(at, (row[(turn + k) % len(row)] for k in range(len(at))), strict=True))
            equations.append(condition.subs(place))
    yield from _solved(equations, unknown)


def _soluble(conditions: list[sp.Expr], unknown: list[sp.Dummy], varied: list[sp.Symbol]) -> bool:
    """Whether conditions linear in the unknowns may have one solution for all values of some letters.

    They are evaluated in doubles at many places, the other letters fixed: a filter before exact algebra, which takes
    long where there is no solution. What passes is verified exactly later.
    """
    fixed = sorted(sp.Add(*conditions).free_symbols - {*unknown, *varied}, key=str)
    places = np.random.default_rng(7).uniform(0.4, 1.6, (6 * len(unknown) + 8, len(varied)))
    values = np.random.default_rng(8).uniform(0.5, 1.5, len(fixed))
    rows = [[*(sp.diff(c, u) for u in unknown), c.subs(dict.fromkeys(unknown, 0))] for c in conditions]
    with np.errstate(all="ignore"):
        columns = lower([e for row in rows for e in row], [*varied, *fixed]).run(Float64(), [*places.T, *values])
    table = np.stack([np.broadcast_to(c, len(places)) for c in columns], axis=1).reshape(-1, len(unknown) + 1)
    table = table[np.isfinite(table).all(axis=1)]
    if not len(table):
        return True
    A, b = table[:, :-1], table[:, -1]
    x = np.linalg.lstsq(A, -b, rcond=None)[0]
    return bool(np.abs(A @ x + b).max() <= 1e-8 * (1 + np.abs(b).max()))


def _solved(equations: list[sp.Expr], unknown: list[sp.Dummy]) -> Iterator[list[sp.Expr]]:
    """Solutions of as many equations as there are unknowns, free ones 0: candidates, which are verified later."""
    chosen = [e for e in equations if e != 0]
    for first in (chosen[: len(unknown)], chosen[-len(unknown) :]):
        try:
            found = sp.linsolve(first, unknown)
        except (ValueError, NotImplementedError):
            continue
        for values in found:
            yield [sp.simplify(sp.sympify(x).subs(dict.fromkeys(unknown, 0))) for x in values]


def _without_time(f: sp.Expr, t: sp.Symbol) -> sp.Expr | None:
    """Return the same function without the time in it; None where ∂/∂t is not proved to vanish."""
    if t not in f.free_symbols:
        return f
    if not isinstance(is_zero(sp.diff(f, t), budget=5.0), Zero):
        return None
    for moment in (0, 1):
        value = f.subs(t, moment)
        if value.is_finite is not False and not value.has(sp.nan, sp.zoo, sp.oo):
            return sp.expand(value) if value.is_polynomial() else value
    return None


# ------------------------------------------------------------------------------------------------ accelerated
def _accelerated(system: System, new: Mapping[str, str], posed: _Posed) -> Iterator[_Posed]:
    """Q = Q + d(t)."""
    Q, speeds, t = _symbols(system, new)
    M = _mass(system, posed, speeds)
    if M is None:
        return
    for d in _paths(posed.potential, Q, M, t):
        first, second = d.diff(t), d.diff(t, 2)
        shift = dict(zip(Q, (q + x for q, x in zip(Q, d, strict=True)), strict=True))
        moved = sp.expand(posed.potential.subs(shift, simultaneous=True) + (second.T * M * sp.Matrix(Q))[0])
        origin = dict.fromkeys(Q, sp.S.Zero if _finite(moved.subs(dict.fromkeys(Q, 0))) else sp.S.One)
        added = moved.subs(origin)
        V = _without_time(moved - added, t)
        if V is None:
            continue
        V = min((V, sp.simplify(V)), key=sp.count_ops) if V.is_polynomial(*Q) else V
        clock = (first.T * M * first)[0] / 2 - added
        Λ = (first.T * M * sp.Matrix(Q))[0] + _integral(TR8(sp.expand(clock)), t)
        place = {name: f.subs(shift, simultaneous=True) for name, f in posed.place.items()}
        yield _Posed(posed.kinetic, V, place, posed.gauge.subs(shift, simultaneous=True) + Λ)


def _finite(x: sp.Expr) -> bool:
    return not x.has(sp.nan, sp.zoo, sp.oo, -sp.oo)


def _paths(V: sp.Expr, Q: list[sp.Symbol], M: sp.Matrix, t: sp.Symbol) -> Iterator[sp.Matrix]:
    """Candidates for d(t)."""
    K = sp.hessian(V, Q)
    K = K.applyfunc(sp.simplify if V.is_polynomial(*Q) else sp.expand)
    if not K.free_symbols & set(Q):
        if t in K.free_symbols:
            return
        F = -sp.Matrix([sp.diff(V, q) for q in Q]).subs(dict.fromkeys(Q, 0))
        if (d := _driven(M, K, F, t)) is not None:
            yield d
        return
    rates = [sp.Dummy(f"rate_{k}") for k in range(len(Q))]
    conditions = []
    for i in range(len(Q)):
        for j in range(i + 1):
            slope = sp.Add(*(r * sp.diff(K[i, j], q) for r, q in zip(rates, Q, strict=True)))
            conditions += [sp.diff(K[i, j], t) + slope]
    if not _soluble(conditions, rates, Q):
        return
    for values in _solutions_in_time(conditions, rates, Q):
        found = [_integral(x, t) for x in values]
        yield sp.Matrix([x - x.subs(t, 0) if _finite(x.subs(t, 0)) else x for x in found])


def _solutions_in_time(
    conditions: list[sp.Expr], unknown: list[sp.Dummy], at: list[sp.Symbol]
) -> Iterator[list[sp.Expr]]:
    """Functions of the time with which conditions linear in them vanish at some places; free ones are 0."""
    equations = []
    for row in _PLACES:
        place = dict(zip(at, (row[k % len(row)] for k in range(len(at))), strict=True))
        equations += [c.subs(place) for c in conditions]
    yield from _solved(equations, unknown)


def _integral(f: sp.Expr, t: sp.Symbol) -> sp.Expr:
    """Return an antiderivative: term by term where it is elementary and short, else left as an integral from 0."""
    parts = []
    for term in sp.Add.make_args(sp.expand(f)):
        kinds = _kinds_of(term, t)
        if kinds is not None or term.is_rational_function(t):
            found = sp.integrate(term, t)
            parts.append(found.replace(sp.Piecewise, lambda *pieces: pieces[0][0]))  # the generic case; proved later
        else:
            dummy = sp.Symbol("tau", real=True)
            parts.append(sp.Integral(term.subs(t, dummy), (dummy, 0, t)))
    return sp.Add(*parts)


# ------------------------------------------------------------------------------------------------ a driven system
def _driven(M: sp.Matrix, K: sp.Matrix, F: sp.Matrix, t: sp.Symbol) -> sp.Matrix | None:
    """Return a solution of M d̈ + K d = F(t), F a sum of t^k e^{at} cos(bt + c) and the like, by coefficients."""
    bases: dict[sp.Expr, int] = {}
    for term in (term for f in F for term in sp.Add.make_args(sp.expand(f))):
        kinds = _kinds_of(term, t)
        if kinds is None:
            return None
        power, growth, waves = kinds
        for wave in waves:
            base = growth * wave
            bases[base] = max(bases.get(base, 0), power)
    functions = [t**j * base for base, power in bases.items() for j in range(power + 3)]
    n = len(functions)
    unknown = [sp.Dummy(f"c_{i}") for i in range(n * F.rows)]
    d = sp.Matrix([sp.Add(*(unknown[r * n + i] * f for i, f in enumerate(functions))) for r in range(F.rows)])
    residual = (M * d.diff(t, 2) + K * d - F).applyfunc(sp.expand)
    letters = {base: sp.Dummy(f"base_{i}") for i, base in enumerate(bases) if base != 1}
    conditions = []
    for row in residual:
        told = _in_letters(row, letters, t)
        if told.free_symbols & {t} and not told.is_polynomial(t):
            return None
        polynomial = sp.Poly(told, t, *letters.values())
        conditions += polynomial.coeffs()
    found = list(sp.linsolve(conditions, unknown))
    if not found:
        return None
    values = dict(zip(unknown, (sp.sympify(x).subs(dict.fromkeys(unknown, 0)) for x in found[0]), strict=True))
    return d.subs(values).applyfunc(sp.simplify)


def _kinds_of(term: sp.Expr, t: sp.Symbol) -> tuple[int, sp.Expr, tuple[sp.Expr, ...]] | None:
    """k, e^{at} and the waves of a term c t^k e^{at} cos(bt + c); None of any other."""
    power, growth = 0, sp.S.One
    waves: tuple[sp.Expr, ...] = (sp.S.One,)
    for factor in sp.Mul.make_args(term):
        if t not in factor.free_symbols:
            continue
        base, exponent = factor.as_base_exp()
        linear = factor.args and isinstance(factor, (sp.exp, sp.cos, sp.sin)) and sp.diff(factor.args[0], t, 2) == 0
        if base == t and exponent.is_Integer and exponent > 0:
            power = int(exponent)
        elif linear and isinstance(factor, sp.exp) and growth == 1:
            growth = factor
        elif linear and isinstance(factor, (sp.cos, sp.sin)) and waves == (sp.S.One,):
            waves = (sp.cos(factor.args[0]), sp.sin(factor.args[0]))
        else:
            return None
    return power, growth, waves


def _in_letters(row: sp.Expr, letters: Mapping[sp.Expr, sp.Dummy], t: sp.Symbol) -> sp.Expr:
    """Every base function as a letter: they are independent over the polynomials in t."""
    total = sp.S.Zero
    for term in sp.Add.make_args(row):
        moving = [f for f in sp.Mul.make_args(term) if t in f.free_symbols and f.as_base_exp()[0] != t]
        base = sp.Mul(*moving)
        rest = sp.Mul(*(f for f in sp.Mul.make_args(term) if f not in moving))
        total += rest * letters.get(base, base)
    return sp.expand(total)


# ------------------------------------------------------------------------------------------------ scaled
def _scaled(system: System, new: Mapping[str, str], posed: _Posed) -> Iterator[_Posed]:
    """Q = Q/s(t), and then a translation where one is needed."""
    Q, speeds, t = _symbols(system, new)
    M = sp.Matrix(mass_matrix(system))
    moving = {c.symbol for c in system.coordinates}
    if any(linear_terms(system)) or kinetic_rest(system) != 0 or M.free_symbols & moving:
        return
    top = next(x for x in M if x != 0)
    g = sp.simplify(top / top.subs(t, 0)) if _finite(top.subs(t, 0)) and top.subs(t, 0) != 0 else sp.simplify(top)
    fixed = (M / g).applyfunc(sp.simplify)
    if t in fixed.free_symbols or t not in g.free_symbols:
        return
    s = sp.powdenest(sp.sqrt(g), force=True)
    V = posed.potential.subs({q: q / s for q in Q}, simultaneous=True)
    square = (sp.Matrix(Q).T * fixed * sp.Matrix(Q))[0]
    rate = sp.simplify(sp.diff(s, t) / s)
    V = sp.expand(sp.simplify(V)) - sp.expand(sp.simplify(sp.diff(s, t, 2) / s) * square / 2)
    T = sp.expand((sp.Matrix(speeds).T * fixed * sp.Matrix(speeds))[0] / 2)
    place = {c.name: q / s for c, q in zip(system.coordinates, Q, strict=True)}
    scaled = _Posed(T, V, place, -rate * square / 2)
    if (still := _without_time(V, t)) is not None:
        yield _Posed(T, still, place, scaled.gauge)
        return
    yield from _accelerated(system, new, scaled)
