"""Periods, actions and frequencies by tanh-sinh quadrature of the textbook integrals over q itself.

A second way for systems without a closed form: hjsolve integrates over an anomaly with the midpoint rule; here the
integrand keeps its end singularities, the precision is doubled instead, and the turning points are bracketed roots.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy
from mpmath import mp, mpf
from sympy.core.cache import clear_cache

from tests.reference.mechanics import hamiltonian, symbolic, table

Numbers = Mapping[str, mpf]
Values = dict[str, tuple[mpf, str]]
HOW = "tanh-sinh quadrature of the textbook integral between the bracketed roots of the radicand, doubled precision"
_BOUNDED = {"libration", "rotation", "ignorable"}


@dataclass(frozen=True)
class CoordinatePath:
    """One coordinate: where it starts, how it moves, and the square of what vanishes at a turning point."""

    name: str
    kind: str
    start: mpf
    momentum: mpf
    speed: mpf
    square: Callable[[mpf], mpf]
    ends: tuple[mpf, mpf]

    def turning(self) -> tuple[mpf | None, mpf | None]:
        """The roots of the square below and above the start, None where there is none."""
        if self.kind in ("rotation", "ignorable"):
            return None, None
        return self._root(-1), self._root(1)

    def _root(self, way: int) -> mpf | None:
        last, step, end = self.start, mp.mpf("0.01"), self.ends[(way + 1) // 2]
        if abs(self.speed) < mp.mpf(10) ** (-mp.dps // 2):
            if self.square(self.start + way * mp.mpf("1e-5")) < 0:
                return self.start
            last += way * mp.mpf("1e-5")
        for _ in range(400):
            there = last + way * step
            if way * (there - end) >= 0:  # ever closer to the end of the domain, never on it
                there = (last + end) / 2
                if abs(there - end) < mp.mpf("1e-12"):
                    return None
            if abs(there - self.start) > 1000:
                return None
            if self.square(there) < 0:
                return mp.findroot(
                    self.square, (last, there), solver="anderson", tol=mp.mpf(10) ** (-2 * mp.dps + 20), maxsteps=400
                )
            last, step = there, min(step * mp.mpf("1.2"), mp.mpf("0.2") + abs(last - self.start) / 4)
        return None

    def root(self, x: mpf) -> mpf:
        """√ of the square; at a node that rounds onto the turning point itself the size of the rounding instead."""
        return mp.sqrt(abs(self.square(x)) or mp.eps)

    def mean(self, integrand: Callable[[mpf], mpf]) -> mpf:
        """(1/2π) ∮: there and back for a libration, one turn for a rotation."""
        if self.kind == "libration":
            a, b = self.turning()
            return mp.quad(integrand, [a, (a + b) / 2, b]) / mp.pi
        return mp.quad(integrand, mp.linspace(self.start, self.start + 2 * mp.pi, 5)) / (2 * mp.pi)


def doubled(form: Callable[[Numbers, Numbers, Numbers], Values]) -> Callable[[Numbers, Numbers, Numbers], Values]:
    """Work with twice the digits: near a root half of them are lost.

    sympy's cache takes cos(Float(3, 20 digits)) for cos(Float(3, 100 digits)), so it is emptied at each change.
    """

    def careful(par: Numbers, q: Numbers, p: Numbers) -> Values:
        clear_cache()
        with mp.workdps(2 * mp.dps + 10):
            values = form(par, q, p)
        clear_cache()
        return values

    return careful


def _kinds(entry: str, par: Numbers, q: Numbers) -> Mapping[str, str]:
    """The kinds of the motion that has these data."""
    for data in (table(entry)["initial"], *table(entry).get("motions", {}).values()):
        values = {x["name"]: x["value"] for x in table(entry).get("parameters", [])} | data.get("parameters", {})
        pairs = [(data["q"][n], value) for n, value in q.items()] + [(values[n], value) for n, value in par.items()]
        if all(abs(mp.mpf(sympy.N(sympy.sympify(t, rational=True), 40)) - v) < mp.mpf("1e-14") for t, v in pairs):
            return data["kinds"]
    raise LookupError(entry)


def _ends(entry: str, name: str, par: Numbers) -> tuple[mpf, mpf]:
    domain = next(c["domain"] for c in table(entry)["coordinates"] if c["name"] == name)
    ends = {"lower": -mp.inf, "upper": mp.inf}
    if "<" in domain:
        parts = [x.strip() for x in domain.split("<")]
        place = parts.index(name)
        for key, at in (("lower", place - 1), ("upper", place + 1)):
            if 0 <= at < len(parts):
                bound = sympy.sympify(parts[at]).xreplace({sympy.Symbol(n): v for n, v in par.items()})
                ends[key] = mp.mpf(sympy.N(bound, mp.dps))
    return ends["lower"], ends["upper"]


def _report(coordinate_motions: Sequence[CoordinatePath]) -> Values:
    values: Values = {}
    for c in coordinate_motions:
        for end, place in zip(("lower", "upper"), c.turning(), strict=True):
            if place is not None:
                values[f"turning_point.{c.name}.{end}"] = (place, HOW)
    return values


def _cycle(name: str, frequency: mpf) -> Values:
    return {f"frequency.{name}": (frequency, HOW), f"period.{name}": (2 * mp.pi / abs(frequency), HOW)}


def one_at_a_time(entry: str) -> Callable[[Numbers, Numbers, Numbers], Values]:
    """For H with at most one essential coordinate, or essential coordinates that do not couple at all."""

    @doubled
    def form(par: Numbers, q: Numbers, p: Numbers) -> Values:
        H, kinds = hamiltonian(entry), _kinds(entry, par, q)
        fixed = {sympy.Symbol(n): value for n, value in par.items()}
        state = {sympy.Symbol(n): v for n, v in q.items()} | {sympy.Symbol(f"p_{n}"): v for n, v in p.items()}
        essential = [n for n in q if kinds[n] != "ignorable"]
        cycles = {n: _Cycle(entry, H, n, kinds[n], fixed, state) for n in essential}
        values = _report([c.coordinate_motion for c in cycles.values()])
        bounded = set(kinds.values()) <= _BOUNDED
        for name, cycle in cycles.items():
            if kinds[name] in _BOUNDED:
                values[f"action.{name}"] = (cycle.action(), HOW)
            if bounded:
                values |= _cycle(name, cycle.frequency())
        for name in q:
            if kinds[name] != "ignorable" or _domain(entry, name) != "angle":
                continue
            values[f"action.{name}"] = (p[name], "the constant momentum")
            rate = H.diff(sympy.Symbol(f"p_{name}"))
            if bounded and not essential:
                values |= _cycle(name, mp.mpf(sympy.N(rate.xreplace(fixed | state), mp.dps)))
            elif bounded:
                values |= _cycle(name, cycles[essential[0]].time_average(rate))
        return values

    return form


def _domain(entry: str, name: str) -> str:
    return next(c["domain"] for c in table(entry)["coordinates"] if c["name"] == name)


class _Cycle:
    """H = A p²/2 + B p + C in one coordinate, everything else at its initial value; q̇² = B² − 2A(C − E)."""

    def __init__(self, entry: str, H: sympy.Expr, name: str, kind: str, fixed: Any, state: Any):
        self.q, self.p = sympy.Symbol(name), sympy.Symbol(f"p_{name}")
        self.rest = fixed | {s: v for s, v in state.items() if s not in (self.q, self.p)}
        zero = {self.p: sympy.Integer(0)}
        A, B, C = H.diff(self.p, 2), H.diff(self.p).subs(zero), H.subs(zero)
        E = mp.mpf(sympy.N(H.xreplace(fixed | state), mp.dps))
        self.A, self.B = self._function(A), self._function(B)
        square = self._function(B**2 - 2 * A * C)
        twice_E = self._function(2 * A)
        speed = mp.mpf(sympy.N(H.diff(self.p).xreplace(fixed | state), mp.dps))
        par = {s.name: v for s, v in fixed.items()}
        self.coordinate_motion = CoordinatePath(
            name,
            kind,
            state[self.q],
            state[self.p],
            speed,
            lambda x: square(x) + E * twice_E(x),
            _ends(entry, name, par),
        )

    def _function(self, formula: sympy.Expr, *more: sympy.Symbol) -> Callable[..., mpf]:
        return sympy.lambdify([self.q, *more], formula.xreplace(self.rest), "mpmath", cse=True)

    def _root(self, x: mpf) -> mpf:
        return self.coordinate_motion.root(x)

    def action(self) -> mpf:
        """(1/2π) ∮ p dq."""
        if self.coordinate_motion.kind == "libration":
            return self.coordinate_motion.mean(lambda x: self._root(x) / self.A(x))
        sign = mp.sign(self.coordinate_motion.speed)
        return self.coordinate_motion.mean(lambda x: (sign * self._root(x) - self.B(x)) / self.A(x))

    def frequency(self) -> mpf:
        """2π over the time of a cycle."""
        rate = 1 / self.coordinate_motion.mean(lambda x: 1 / self._root(x))
        return rate * (mp.sign(self.coordinate_motion.speed) if self.coordinate_motion.kind == "rotation" else 1)

    def time_average(self, rate: sympy.Expr) -> mpf:
        """The mean over time of a function of q and p."""
        function = self._function(rate, self.p)
        signs = (1, -1) if self.coordinate_motion.kind == "libration" else (mp.sign(self.coordinate_motion.speed),)

        def integrand(x: mpf) -> mpf:
            root = self._root(x)
            momenta = [(sign * root - self.B(x)) / self.A(x) for sign in signs]
            return mp.fsum(function(x, value) for value in momenta) / (len(signs) * root)

        return self.coordinate_motion.mean(integrand) * abs(self.frequency())


def staeckel(entry: str) -> Callable[[Numbers, Numbers, Numbers], Values]:
    """From the book's Φ and ψ (or f, R, v) of the entry: pᵢ² = 2(Σ Φᵢⱼ αⱼ − ψᵢ), Ω = first row of (∂J/∂(α, c))⁻¹.

    The constants are the α and, where Φ and ψ belong to the shell, the momenta c of the ignorable coordinates.
    """

    @doubled
    def form(par: Numbers, q: Numbers, p: Numbers) -> Values:
        kinds = _kinds(entry, par, q)
        matrix, column = _matrix(entry)
        names = list(q) if len(matrix) == len(q) else [x for x in q if kinds[x] != "ignorable"]
        others = [x for x in q if x not in names]
        fixed = {sympy.Symbol(x): value for x, value in par.items()}
        c = {sympy.Symbol(f"p_{x}"): p[x] for x in others}
        n = len(names)
        at = fixed | c | {sympy.Symbol(x): value for x, value in q.items()}
        Φ0 = mp.matrix([[mp.mpf(sympy.N(x.xreplace(at), mp.dps)) for x in row] for row in matrix])
        ψ0 = mp.matrix([mp.mpf(sympy.N(x.xreplace(at), mp.dps)) for x in column])
        α = mp.lu_solve(Φ0, mp.matrix([ψ0[i] + p[x] ** 2 / 2 for i, x in enumerate(names)]))
        rows = [
            [
                sympy.lambdify(sympy.Symbol(x), y.xreplace(fixed | c), "mpmath", cse=True)
                for y in (*matrix[i], *(-column[i].diff(s) for s in c), column[i])
            ]
            for i, x in enumerate(names)
        ]

        def square(i: int) -> Callable[[mpf], mpf]:
            return lambda x: 2 * (mp.fsum(rows[i][j](x) * α[j] for j in range(n)) - rows[i][-1](x))

        coordinate_motions = [
            CoordinatePath(x, kinds[x], q[x], p[x], p[x], square(i), _ends(entry, x, par)) for i, x in enumerate(names)
        ]
        values = _report(coordinate_motions)
        for i, coordinate_motion in enumerate(coordinate_motions):
            if coordinate_motion.kind in _BOUNDED and _has_action(
                entry, coordinate_motion.name, coordinate_motion.kind
            ):
                sign = 1 if coordinate_motion.kind == "libration" else mp.sign(coordinate_motion.momentum)
                values[f"action.{coordinate_motion.name}"] = (
                    sign * coordinate_motion.mean(lambda x, i=i: coordinate_motions[i].root(x)),
                    HOW,
                )
        for name in others:
            if _has_action(entry, name, "ignorable"):
                values[f"action.{name}"] = (p[name], "the constant momentum")
        if set(kinds.values()) <= _BOUNDED:
            M = mp.eye(len(q))
            for i, coordinate_motion in enumerate(coordinate_motions):
                for j in range(len(q)):
                    M[i, j] = coordinate_motion.mean(lambda x, i=i, j=j: rows[i][j](x) / coordinate_motions[i].root(x))
            Ω = (M**-1)[0, :]
            for i, name in enumerate([*names, *others]):
                if _has_action(entry, name, kinds[name]):
                    turned = name in names and kinds[name] != "libration"
                    values |= _cycle(name, Ω[i] * (mp.sign(p[name]) if turned else 1))
        return values

    return form


def _has_action(entry: str, name: str, kind: str) -> bool:
    """An ignorable coordinate on a line runs away: no cycle, no action."""
    return kind != "ignorable" or _domain(entry, name) == "angle"


def _matrix(entry: str) -> tuple[list[list[sympy.Expr]], list[sympy.Expr]]:
    expect = table(entry)["expect"]
    book = expect.get("staeckel") or expect.get("reduced", {}).get("staeckel")
    if book:
        return [[symbolic(entry, x) for x in row] for row in book["matrix"]], [
            symbolic(entry, x) for x in book["column"]
        ]
    names = [c["name"] for c in table(entry)["coordinates"]]
    f, R, v = ([symbolic(entry, expect["liouville"][part][n]) for n in names] for part in ("f", "R", "v"))
    last = len(names) - 1
    rows = [
        [f[i] / R[i], *((sympy.Integer(-1 if i == last else i == j) / R[i]) for j in range(last))]
        for i in range(last + 1)
    ]
    return rows, [v[i] / R[i] for i in range(last + 1)]
