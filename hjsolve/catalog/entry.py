"""What a catalog entry is, as frozen values; ``hjsolve.catalog`` makes them from files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hjsolve.catalog import outside
from hjsolve.coordinates.multipliers import ConstraintForces
from hjsolve.display.shown import Shown
from hjsolve.extended.linear_hamiltonian import LinearHamiltonian
from hjsolve.mechanics.system import System


@dataclass(frozen=True, repr=False)
class InitialData(Shown):
    """Where a motion starts: coordinates, and velocities or momenta; numbers stay the texts of the file.

    Attributes:
        name: ``default`` for the table ``initial``, else the name under ``motions``.
        kinds: the kind of motion expected of each coordinate; may be empty.
    """

    name: str
    q: Mapping[str, object]
    velocity: Mapping[str, object] | None = None
    p: Mapping[str, object] | None = None
    parameters: Mapping[str, object] = field(default_factory=dict)
    kinds: Mapping[str, str] = field(default_factory=dict)
    summary: str = ""

    @property
    def arguments(self) -> dict[str, Mapping[str, object]]:
        """The keyword arguments for ``solution.motion``."""
        given = {"q": self.q, "velocity": self.velocity, "p": self.p, "parameters": self.parameters}
        return {name: value for name, value in given.items() if value}


@dataclass(frozen=True, repr=False)
class Effect(Shown):
    """An optional term of T or V, with the parameters it brings; absent from H until it is called for.

    Attributes:
        force: coordinate → generalized force that no T and V contain, such as drag; only scenes can use it.
    """

    name: str
    summary: str
    kinetic: str = ""
    potential: str = ""
    parameters: tuple[Mapping[str, object], ...] = ()
    verdict: str = ""
    force: Mapping[str, str] = field(default_factory=dict)
    cite: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Reference(Shown):
    """A number known from a method other than hjsolve's; ``value`` has all its digits.

    Attributes:
        quantity: as in catalog/README.md, e.g. ``period.r`` or ``q.theta``.
        at: ``motion`` (a name) and ``t``, or values of constants and parameters.
    """

    quantity: str
    at: Mapping[str, object]
    value: str
    how: str
    cite: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Entry(Shown):
    """One system of the catalog.

    Attributes:
        kind: ``separable``, ``extended``, ``refused``, ``outside`` (no T and V: ``system`` is None), or
            ``unchecked`` where the file expects nothing.
        hamiltonian: H(q, p) where it is given and linear in p; then ``system`` is None.
        initial: the default motion, or None.
        motions: every motion by name, the default one included.
        expect: what is known about separability (catalog/README.md), as in the file.
        reason: why a refused system is refused.
        instead: what to do about it.
        refusal: why a system ``outside`` is none.
        constraints, stated: as the literature states the system.
        meanings: coordinate → (unit, meaning).
    """

    id: str
    title: str
    summary: str
    kind: str
    system: System | None
    initial: InitialData | None
    motions: Mapping[str, InitialData]
    effects: Mapping[str, Effect]
    expect: Mapping[str, object]
    references: tuple[Reference, ...]
    cite: tuple[str, ...]
    book: tuple[str, ...]
    meanings: Mapping[str, tuple[str, str]]
    reason: str = ""
    instead: str = ""
    refusal: outside.Refusal | None = None
    constraints: tuple[outside.Constraint, ...] = ()
    stated: outside.Stated | None = None
    hamiltonian: LinearHamiltonian | None = None

    @property
    def equations(self) -> ConstraintForces | None:
        """Lagrange's equations with multipliers of a nonholonomic entry whose T is stated; else None."""
        return outside.equations(self.constraints, self.stated) if self.refusal is not None else None
