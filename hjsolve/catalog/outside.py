"""What a catalog entry says besides T and V: why it is refused, its constraints, and the system as the book states it.

A system with a nonintegrable constraint, friction or explicit time is not given by T and V, so it has no ``System``;
the entry still says what was asked (Greenwood ch. 1, 3 and 7) and ``load`` answers with its reason. Where T is stated,
a nonholonomic one has Lagrange's equations with multipliers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from hjsolve.catalog.schema import Key
from hjsolve.catalog.toml_file import Toml
from hjsolve.coordinates.multipliers import ConstraintForces, constraint_forces
from hjsolve.display.shown import Shown
from hjsolve.mechanics.system import System, parameter

REFUSALS = (
    "nonholonomic", "dissipative", "unilateral", "impulsive", "explicit time", "variable mass", "collision",
    "no Lagrangian", "not quadratic in the momenta", "gyroscopic", "not separable in these coordinates",
)  # fmt: skip
"""Why a system is refused, in the book's words; the last two are found by ``separate`` itself."""
_FOUND_BY_US = REFUSALS[-2:]
_TEXT, _TEXTS, _FORMULAS = Key("text"), Key("texts"), Key("formulas")
KEYS = {
    "refused_because": Key(
        "table", keys={"kind": Key("text", True, choices=REFUSALS), "forces": _FORMULAS, "conditions": _TEXTS}),
    "stated": Key("table", keys={
        "summary": _TEXT, "coordinates": _TEXTS, "kinetic": _TEXT, "potential": _TEXT, "map": _FORMULAS,
        "gauge": _TEXT}),
}  # fmt: skip
"""The keys of a catalog file that belong here."""


@dataclass(frozen=True, repr=False)
class Refusal(Shown):
    """Why a system that is not given by T and V is refused; the verdict that ``NotSeparableError`` carries for it.

    Attributes:
        id: the entry.
        kind: one of ``REFUSALS``.
        reason: in words.
        instead: what to do.
        formulas: the constraints, forces or conditions that prevent separation, as written in the entry.
    """

    id: str
    kind: str
    reason: str
    instead: str
    formulas: tuple[str, ...] = ()

    def __str__(self) -> str:
        shown = f" ({'; '.join(self.formulas)})" if self.formulas else ""
        return f"{self.id} is refused, {self.kind}{shown}: {self.reason} {self.instead}"


@dataclass(frozen=True, repr=False)
class Constraint(Shown):
    """A constraint linear in the velocities, ``form`` = 0 (Greenwood (1-16), (2-48)).

    Attributes:
        form: Σ aᵢ(q, t) dot(qᵢ) + a_t(q, t), as a text.
        coordinates: the names it speaks of; ``t`` is the time.
        integral: a function whose total time derivative is proportional to the form; empty for a nonholonomic one,
            and where it is to be found.
        name: for display.
        constant: the value of the integral; None where the entry does not say it.
    """

    form: str
    coordinates: tuple[str, ...] = ()
    integral: str = ""
    name: str = ""
    constant: object = None


@dataclass(frozen=True, repr=False)
class Stated(Shown):
    """The system as the literature states it, where the entry uses other coordinates or another gauge.

    Attributes:
        kinetic, potential: T and V in the literature's coordinates; empty where they are those of the entry.
        map: literature's coordinate → formula in the entry's coordinates, parameters and ``t``.
        gauge: F(q, t) with L_stated = L_entry + dF/dt.
    """

    coordinates: tuple[str, ...] = ()
    kinetic: str = ""
    potential: str = ""
    map: Mapping[str, str] = field(default_factory=dict)
    gauge: str = "0"
    summary: str = ""


def refusal(table: Toml) -> Refusal | None:
    """Return the refusal of an entry that is not given by T and V; None for every other entry."""
    because = table.get("refused_because", {})
    if "kind" not in because or because["kind"] in _FOUND_BY_US or "kinetic" in table:
        return None
    formulas = [f"{c['form']} = 0" for c in table.get("constraint", [])]
    formulas += [f"force along {name}: {text}" for name, text in because.get("forces", {}).items()]
    formulas += because.get("conditions", [])
    return Refusal(table["id"], because["kind"], table.get("reason", ""), table.get("instead", ""), tuple(formulas))


def constraints(table: Toml) -> tuple[Constraint, ...]:
    """Return the constraints of an entry."""
    given = table.get("constraint", [])
    return tuple(Constraint(**{**c, "coordinates": tuple(c.get("coordinates", ()))}) for c in given)


def stated(table: Toml) -> Stated | None:
    """Return the system as the literature states it, or None.

    Args:
        table: of the entry.
    """
    if "stated" not in table:
        return None
    return Stated(**{**table["stated"], "coordinates": tuple(table["stated"].get("coordinates", ()))})


def equations(constraints: tuple[Constraint, ...], stated: Stated | None) -> ConstraintForces | None:
    """Return Lagrange's equations with multipliers, where the literature's T and V are stated.

    Args:
        constraints: of an entry that is refused because of them.
        stated: T and V without them; names that are not coordinates are parameters.
    """
    if stated is None or not (constraints and stated.kinetic):
        return None
    words = " ".join((stated.kinetic, stated.potential, *(c.form for c in constraints)))
    names = set(re.findall(r"[A-Za-z_]\w*", words)) - set(stated.coordinates) - {"dot", "t", "sin", "cos", "sqrt"}
    parameters = {name: parameter(name, assume="positive") for name in sorted(names)}
    free = System(dict.fromkeys(stated.coordinates, "line"), stated.kinetic, stated.potential or 0, parameters)
    return constraint_forces(free, [c.form for c in constraints])


def outside_faults(table: Toml) -> Iterator[str]:
    """Yield what is missing in an entry without T and V, one line each."""
    because = table.get("refused_because", {}).get("kind", "")
    if "kinetic" not in table and because in _FOUND_BY_US:
        yield f'kinetic: missing; an entry refused as "{because}" needs T, so that separate() can show it'
    if not {"kinetic", "hamiltonian"} & table.keys() and not (table.get("reason") and table.get("instead")):
        yield "reason, instead: a refused entry says why, and what to do"
    if because == "nonholonomic" and not table.get("constraint"):
        yield "constraint: missing; a nonholonomic entry states its constraint"
    for place, constraint in enumerate(table.get("constraint", []), start=1):
        if because == "nonholonomic" and constraint.get("integral"):
            yield f"constraint[{place}].integral: an integrable constraint is not a reason to refuse; integrate it"
        if "hamiltonian" in table:
            yield f"constraint[{place}]: belongs to T and V; this entry gives H(q, p)"
    if "kinetic" in table and because and because not in _FOUND_BY_US:
        yield f'kinetic: T and V do not hold what is "{because}"; leave kinetic out, or refused_because'
    if "kinetic" in table and table.get("refused_because", {}).get("forces"):
        yield "refused_because.forces: T and V do not hold them; write an effect with the force, for scenes"
