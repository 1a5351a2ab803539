"""K(q, p, t) of one degree of freedom and of any degree in p, without the time in a scaled frame that moves evenly.

    F₂ = (q + v t) e^{a t} Y:    X = (q + v t) e^{a t},   p = Y e^{a t},   K′ = K + ∂F₂/∂t = K + (v e^{a t} + a X) Y

(Greenwood (6-45)–(6-48)). a is taken from the exponentials of t in K, v from its sums of q and t; that K′ does not hold
the time is proved, and K′ is solved as any H(q, p) of one degree of freedom.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Protocol

import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.display.shown import Shown
from hjsolve.extended.one_freedom import Beginning
from hjsolve.formulas.read import number
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter
from hjsolve.motion.initial_data import complete_numbers, to_bits, values_of
from hjsolve.motion.shapes import state_of_one
from hjsolve.motion.state import AnyMotion, State

_FLOAT_DIGITS = 15
_PARTS = (1, sp.Rational(1, 2), sp.Rational(1, 4))
"""a as a part of the exponents: K of degree 1, 2 or 4 in q and p together."""


class Startable(Protocol):
    """What solves H(q, p) of one coordinate: a solution, or what ``from_hamiltonian`` gave."""

    @property
    def parameters(self) -> Sequence[Parameter]:
        """Of H."""

    def motion(
        self, *, q: Mapping[str, object], p: Mapping[str, object], parameters: Mapping[str, object], t0: object,
        digits: int,
    ) -> AnyMotion:  # fmt: skip
        """Start a motion.

        Args:
            q, p: numbers by name of the coordinate.
            parameters: numbers by name.
            t0: time of the initial data.
            digits: relative digits wanted.
        """


@dataclass(frozen=True, repr=False)
class ScaledFrame(Shown):
    """X = (q + v t) e^{a t}, Y = p e^{−a t}.

    Attributes:
        coordinate: q; X and Y have its symbols.
        rate: a.
        drift: v.
        hamiltonian: K′(X, Y).
    """

    coordinate: Coordinate
    rate: sp.Expr
    drift: sp.Expr
    hamiltonian: sp.Expr


def scaled_frame(K: sp.Expr, coordinate: Coordinate, clock: sp.Symbol) -> ScaledFrame | None:
    """Return a frame in which K does not hold the time; None where none of those tried serves.

    Args:
        K: K(q, p, t).
        coordinate: q.
        clock: t.
    """
    q, p = coordinate.symbol, coordinate.momentum
    ends = [end for end in (coordinate.domain.lower, coordinate.domain.upper) if end is not None]
    if coordinate.domain.kind == "angle" or any(end != 0 for end in ends):
        return None
    scales = [s * part * c for c in _exponents(K, clock) for part in _PARTS for s in (1, -1)]
    rates = dict.fromkeys([sp.S.Zero, *scales])
    drifts = dict.fromkeys([sp.S.Zero, *([] if ends else _drifts(K, q, clock))])
    for a, v in product(rates, drifts):
        grown = sp.exp(a * clock)
        put = {q: q / grown - v * clock, p: p * grown}
        new = K.subs(put, simultaneous=True) + v * grown * p + a * q * p
        if sp.simplify(sp.powsimp(sp.diff(new, clock))) == 0:
            still = sp.simplify(sp.powsimp(sp.expand(new)))
            return ScaledFrame(coordinate, a, v, still if not still.has(clock) else new.subs(clock, 0))
    return None


def _exponents(K: sp.Expr, clock: sp.Symbol) -> Iterator[sp.Expr]:
    """Yield c of each e^{c t} in K."""
    for power in sorted(K.atoms(sp.exp), key=sp.default_sort_key):
        c = sp.diff(power.args[0], clock)
        if c != 0 and not c.has(clock):
            yield c


def _drifts(K: sp.Expr, q: sp.Symbol, clock: sp.Symbol) -> Iterator[sp.Expr]:
    """Yield v of each sum in K that is c (q + v t) + …."""
    for total in sorted(K.atoms(sp.Add), key=sp.default_sort_key):
        along, later = sp.diff(total, q), sp.diff(total, clock)
        if along != 0 and later != 0 and not (later / along).has(clock, q):
            yield sp.cancel(later / along)


@dataclass(frozen=True, eq=False, repr=False)
class ScaledMotion(Shown):
    """A motion of K(q, p, t), carried back from its frame.

    Attributes:
        frame: X, Y and K′.
        motion: in X and Y.
        values: parameter → exact value.
        digits: asked for.
    """

    frame: ScaledFrame
    motion: AnyMotion
    values: Mapping[sp.Symbol, sp.Expr]
    digits: int

    @property
    def kinds(self) -> Mapping[str, str]:
        """The kind of motion of X."""
        return self.motion.kinds

    @property
    def constants(self) -> Mapping[str, Estimate]:
        """E, the value of K′."""
        return self.motion.constants

    def at(self, t: object) -> State:
        """Return the state at a time or at an array of times.

        Args:
            t: a time or an array of times.
        """
        return state_of_one(self.frame.coordinate, t, self._state)

    def _state(self, t: sp.Expr) -> tuple[object, ...]:
        """(q, p, q̇, their errors, status, 0): q = X s − v t, p = Y/s, q̇ = s (Ẋ − a X) − v with s = e^{−a t}."""
        name, bits = self.frame.coordinate.name, bits_for(max(self.digits, _FLOAT_DIGITS), 64)
        a, v = (self._number(x, bits) for x in (self.frame.rate, self.frame.drift))
        now = to_bits(t)(bits)
        s = now.context.exp(-a * now)
        state = self.motion.at(t)
        X, Y, speed = (now.context.convert(x[name]) for x in (state.q, state.p, state.velocity))
        wide, high, fast = (now.context.convert(x[name]) for x in (state.error.q, state.error.p, state.error.velocity))
        found = (X * s - v * now, Y / s, s * (speed - a * X) - v)
        sizes = (abs(X * s) + abs(v * now), abs(Y / s), abs(s * speed) + abs(s * a * X) + abs(v))
        errors = (wide * s, high / s, s * (fast + abs(a) * wide))
        small = EPS if self.digits <= _FLOAT_DIGITS else now.context.mpf(10) ** -self.digits
        bounds = [e + small * size for e, size in zip(errors, sizes, strict=True)]
        if self.digits > _FLOAT_DIGITS:
            return *found, *bounds, str(state.status), 0
        return *map(float, found), *map(float, bounds), str(state.status), 0

    def _number(self, x: sp.Expr, bits: int) -> Mpf:
        return to_bits(x.xreplace(dict(self.values)))(bits)


def start_scaled(frame: ScaledFrame, problem: Startable, known: Sequence[Parameter], begin: Beginning) -> ScaledMotion:
    """Start a motion; see ``StartedByMomenta.motion``.

    Args:
        frame: X, Y and K′.
        problem: what solves K′.
        known: the parameters of K.
        begin: in q, p and t.
    """
    c, t0 = frame.coordinate, number(begin.t0, source="t0")
    values = values_of(known, arguments.table(begin.parameters, "parameters"))
    place, momentum = (complete_numbers([c], group, what)[c.name] for group, what in ((begin.q, "q"), (begin.p, "p")))
    grown = sp.exp(frame.rate.xreplace(values) * t0)
    X, Y = (place + frame.drift.xreplace(values) * t0) * grown, momentum / grown
    own = {x.name: values[x.symbol] for x in known if x.symbol in {y.symbol for y in problem.parameters}}
    motion = problem.motion(q={c.name: X}, p={c.name: Y}, parameters=own, t0=t0, digits=begin.digits)
    return ScaledMotion(frame, motion, values, begin.digits)
