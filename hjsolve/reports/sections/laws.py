"""The section that says whether the solution solves: the laws it must obey, each tested exactly on what is printed."""

from __future__ import annotations

from hjsolve.reports.document import Block, Note, Paragraph, Section, Table, Text
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.solution.laws import Outcome, check
from hjsolve.solution.quadratures import Solution

BUDGET = 0.3
"""Seconds that one identity may take here; ``hjsolve.solution.laws.check`` takes more."""
_LAWS = {
    "hamilton-jacobi": "H(q, ∂W/∂q) = E identically in q and the constants",
    "momenta": "p = ∂W/∂q gives back every momentum when the constants are functions of q and p",
    "involution": "the constants are integrals of the motion and in involution: their brackets vanish",
    "canonical": "(q, p) → (α, β) is canonical, so β and α stay constant (Jacobi's theorem)",
}
_SOURCES = {"hamilton-jacobi": "(5-69)", "momenta": "(5-72)", "involution": "(6-236)", "canonical": "(6-215)"}
_OUTCOMES: dict[Outcome, str] = {
    "proved": "proved, exactly",
    "numeric": "zero to 40 digits at a place of the domain; not proved in the time given",
    "undecided": "not decided in the time given",
    "failed": "does not hold",
}


def laws_section(solution: Solution) -> Section:
    """Test a solution and tell the outcome.

    Args:
        solution: the solution as it is printed.
    """
    found = check(solution, budget=BUDGET)
    rows: tuple[tuple[Text, ...], ...] = tuple(
        ((_LAWS[c.name],), (f"Greenwood {_SOURCES[c.name]}",), (_OUTCOMES[c.verdict],)) for c in found
    )
    text = (
        "W enters only through its derivatives, so no integral has to be evaluated: each law is an identity between "
        "elementary functions."
    )
    header: tuple[Text, ...] = (("Law",), ("Equation",), ("Outcome",))
    blocks: list[Block] = [
        Paragraph(typeset_prose(text, solution.system)),
        Table(header, rows, "Laws the solution must obey"),
    ]
    failed = any(c.verdict == "failed" for c in found)
    warning = "This is a fault of hjsolve: please report it, and do not use this solution."
    blocks += [Note((warning,))] if failed else []
    return Section("laws", "Check of the solution", tuple(blocks))
