"""H(q, p) of several degrees of freedom that is a sum of Hamiltonians of its own coordinates each, of any degree in p.

    H = Σ hₖ(qₖ, pₖ),    W = Σ Wₖ(qₖ; Eₖ),    hₖ = Eₖ,    E = Σ Eₖ                            (Greenwood (5-69), (5-71))

Every hₖ is a constant of the motion, and the time law of each part is that of its own Hamiltonian: the parts are solved
one by one, by whatever solves them. A part may have several coordinates, if H couples them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Protocol

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.extended.one_freedom import Beginning
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.system import Parameter, System
from hjsolve.motion.state import AnyMotion, Errors, State
from hjsolve.solution.quadratures import solve


class StartedPart(Protocol):
    """A part that starts its motions itself."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Those of the part."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """With their default values."""
        ...

    @property
    def motion(self) -> Callable[..., AnyMotion]:
        """Start a motion of the part, as ``StartedByMomenta.motion`` does."""
        ...


Part = System | StartedPart


@dataclass(frozen=True, eq=False, repr=False)
class SumMotion(Shown):
    """A motion of a sum of Hamiltonians.

    Attributes:
        motions: of the parts, in order.
        constants: E, and ``E_`` with the names of its coordinates for each part; of a part that holds the time the
            energy in its frame, and then no E.
        t0: time of the initial data.
    """

    motions: tuple[AnyMotion, ...]
    constants: Mapping[str, Estimate]
    t0: object = 0

    @property
    def kinds(self) -> Mapping[str, str]:
        """Coordinate → its kind of motion."""
        return {name: kind for motion in self.motions for name, kind in motion.kinds.items()}

    @property
    def turning_points(self) -> Mapping[str, tuple[Estimate | None, Estimate | None]]:
        """Coordinate → (lower, upper), of the parts that have them."""
        return {name: x for motion in self.motions for name, x in getattr(motion, "turning_points", {}).items()}

    @property
    def actions(self) -> Mapping[str, Estimate]:
        """Coordinate → J, of the parts that have actions."""
        return self._merged("actions")

    @property
    def periods(self) -> Mapping[str, Estimate]:
        """Coordinate → T, of the parts that come back."""
        return self._merged("periods")

    @property
    def frequencies(self) -> Mapping[str, Estimate]:
        """Coordinate → 2π/T, of the parts that come back."""
        return self._merged("frequencies")

    def _merged(self, what: str) -> Mapping[str, Estimate]:
        return {name: x for motion in self.motions for name, x in getattr(motion, what, {}).items()}

    def at(self, t: object) -> State:
        """Return the state at a time or at an array of times.

        Args:
            t: a time or an array of times.
        """
        states = [motion.at(t) for motion in self.motions]
        rows = [np.asarray(state.status, dtype=object) for state in states]
        status = rows[0]
        for row in rows[1:]:
            status = np.where(status == "ok", row, status)
        q, p, velocity, turns = (
            {name: x for state in states for name, x in getattr(state, group).items()}
            for group in ("q", "p", "velocity", "turns")
        )

        def errors() -> Errors:
            bounds = [state.error for state in states]
            return Errors(*(
                {name: x for bound in bounds for name, x in getattr(bound, group).items()}
                for group in ("q", "p", "velocity")
            ))  # fmt: skip

        found = status.astype(str) if status.shape else str(status[()])
        return State(t, q, p, velocity, turns, found, errors)


def start_sum(parts: Sequence[Part], begin: Beginning, *, in_time: bool) -> SumMotion:
    """Start a motion; see ``StartedByMomenta.motion``.

    Args:
        parts: of the Hamiltonian.
        begin: in all coordinates.
        in_time: whether some part holds the time: then the energies have no sum that stays.

    Raises:
        InvalidInputError: a name that is not one of the coordinates or parameters.
    """
    q, p, parameters, t0, digits = begin
    names = [{c.name for c in part.coordinates} for part in parts]
    letters = [{x.name for x in part.parameters} for part in parts]
    places, momenta = (_parted(arguments.table(x, what), names, what) for x, what in ((q, "q"), (p, "p")))
    values = _parted(arguments.table(parameters, "parameters"), letters, "parameters")
    motions = tuple(
        (solve(part) if isinstance(part, System) else part).motion(q=x, p=y, parameters=z, t0=t0, digits=digits)
        for part, x, y, z in zip(parts, places, momenta, values, strict=True)
    )
    energies = {
        f"E_{'_'.join(c.name for c in part.coordinates)}": motion.constants["E"]
        for part, motion in zip(parts, motions, strict=True) if "E" in motion.constants
    }  # fmt: skip
    if in_time:
        return SumMotion(motions, energies, t0)
    return SumMotion(motions, {"E": reduce(operator.add, energies.values()), **energies}, t0)


def independent_parts(
    hamiltonian: sp.Expr, coordinates: Sequence[Coordinate]
) -> list[tuple[tuple[Coordinate, ...], sp.Expr]]:
    """Return the parts of H that share no coordinate and no momentum, with their coordinates; one where H is not a sum.

    Args:
        hamiltonian: H.
        coordinates: all of them, each with its momentum in H.
    """
    for H in (hamiltonian, sp.expand(hamiltonian)):
        groups: list[set[str]] = [{c.name} for c in coordinates]
        terms = [(term, {c.name for c in coordinates if term.has(c.symbol, c.momentum)})
                 for term in sp.Add.make_args(H)]  # fmt: skip
        for held in [names for _, names in terms] + [_in_ends(c, coordinates) for c in coordinates]:
            touched = [g for g in groups if g & held]
            if len(touched) > 1:
                groups = [g for g in groups if g not in touched] + [set().union(*touched)]
        if len(groups) > 1:
            break
    order = {c.name: k for k, c in enumerate(coordinates)}
    groups.sort(key=lambda g: min(order[n] for n in g))
    found = []
    for k, group in enumerate(groups):
        own = [term for term, held in terms if held & group or (not held and k == 0)]
        found.append((tuple(c for c in coordinates if c.name in group), sp.Add(*own)))
    return found


def _in_ends(c: Coordinate, coordinates: Iterable[Coordinate]) -> set[str]:
    ends = [end for end in (c.domain.lower, c.domain.upper) if end is not None]
    return {c.name} | {o.name for o in coordinates if any(end.has(o.symbol) for end in ends)}


def used_parameters(
    parameters: Iterable[Parameter], coordinates: Iterable[Coordinate], part: sp.Expr
) -> dict[str, Parameter]:
    """Return the parameters that a part or the domains of its coordinates hold.

    Args:
        parameters: all of them.
        coordinates: of the part.
        part: h(q, p).
    """
    ends = [end for c in coordinates for end in (c.domain.lower, c.domain.upper) if end is not None]
    held = part.free_symbols.union(*(sp.sympify(end).free_symbols for end in ends))
    return {p.name: p for p in parameters if p.symbol in held}


def _parted(given: Mapping[str, object], names: Sequence[set[str]], what: str) -> list[dict[str, object]]:
    """Return a table name → number for each part."""
    for name in given:
        if not any(name in own for own in names):
            raise InvalidInputError(
                f"{what}: {name!r} is not one of {', '.join(sorted(set().union(*names))) or 'none'}"
            )
    return [{name: x for name, x in given.items() if name in own} for own in names]
