"""The sections of a report about the question: the system, its reduction, the evidence, and the obstruction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from hjsolve.arithmetic.printed_digits import shortest
from hjsolve.display.shown import as_argument
from hjsolve.mechanics.energy_shell import ReductionStep
from hjsolve.mechanics.system import System, hamiltonian, linear_terms, mass_matrix, momenta
from hjsolve.precision import mp
from hjsolve.reports.document import (
    ArgumentStep,
    Block,
    Formula,
    Mathematics,
    Number,
    Paragraph,
    Section,
    Steps,
    Strong,
    Table,
    Text,
)
from hjsolve.reports.formulas.abbreviations import abbreviating, letters_for_sums
from hjsolve.reports.formulas.from_sympy import box, constants_outside, contracted
from hjsolve.reports.formulas.layout import Box, Glyph, Script, row
from hjsolve.reports.formulas.line_breaks import LINE, broken, display
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.prose import condition_formulas, domain_text, listed, typeset, typeset_prose
from hjsolve.reports.sections.rounded_numbers import terminating
from hjsolve.separation import Obstruction, Separation, Undecided
from hjsolve.separation.zero_test.zero_test import Zero, is_zero

EQUALS = Glyph("=", "operator")


IN_A_CELL = 0.6 * LINE
"""Letters after which an expression in the cell of a table takes another line."""


def math(expression: sp.Basic) -> Mathematics:
    """Set an expression inside a sentence or a cell, a long one on several lines."""
    return Mathematics(display(expression, IN_A_CELL))


_SIMPLE, _FIRST_DIGITS, _READABLE = 12, 6, 24
"""Denominators up to which fractions are read best; digits shown of a long exact number; letters of one that is shown
whole before them."""


def exactly(value: sp.Expr) -> Text:
    """Write a number that is known exactly: short fractions as they are, decimals where they end, doubles as typed.

    Args:
        value: an exact number.

    Returns:
        The number in pieces, a long one followed by its first digits, or as these alone.
    """
    if isinstance(value, sp.Rational) and value.q <= _SIMPLE:
        return (math(value),)
    ending = terminating(value)
    if ending is not None:
        return (ending,)
    typed = as_argument(value)
    if isinstance(typed, float):
        return (Number(repr(typed)), " (double)")
    digits = Number(shortest(mp.mpf(sp.N(value, 20)), _FIRST_DIGITS))
    return ("≈ ", digits) if len(typed) > _READABLE else (math(value), " ≈ ", digits)


def formula(left: Box, expression: sp.Basic, tag: str = "") -> Formula:
    """Display an equation.

    Args:
        left: the box of its left side.
        expression: its right side.
        tag: the equation's number in the literature.

    Returns:
        The displayed formula.
    """
    return Formula(broken(row(left, EQUALS, box(expression))), str(expression), tag)


def equation(relation: sp.Basic, tag: str = "") -> Formula:
    """Display an equation that is a sympy object, constants taken out of its integrals.

    Args:
        relation: the equation or expression.
        tag: the equation's number in the literature.

    Returns:
        The displayed formula.
    """
    shown = relation
    if isinstance(relation, sp.Eq):
        shown = sp.Eq(relation.lhs, constants_outside(relation.rhs), evaluate=False)
    return Formula(display(shown), str(relation), tag)


# -------------------------------------------------------------------------------- the system
def system_section(
    system: System, meanings: Mapping[str, tuple[str, str]], summary: str,
    letters: Mapping[sp.Expr, sp.Symbol] | None = None,
) -> Section:  # fmt: skip
    """Write down what was given.

    Args:
        meanings: coordinate → (unit, meaning); may be empty.
        summary: what the catalog says about it; may be empty.
        letters: sums that are abbreviated → their letters.
    """
    blocks: list[Block] = [Paragraph(typeset_prose(summary, system))] if summary else []
    if system.relativity is not None:
        blocks.append(Paragraph((RELATIVISTIC,)))
    blocks += [formula(Glyph("T"), system.kinetic), formula(Glyph("V"), system.potential), *_letters(letters)]
    blocks += [*_kinks(system), *eliminated_blocks(system)]
    blocks.append(_coordinates(system, meanings))
    if system.parameters:
        blocks.append(_parameters(system))
    return Section("system", "The system", (*blocks, *_hamilton(system)))


def eliminated_blocks(system: System) -> list[Block]:
    """Say how the coordinates that constraints eliminated follow from the others; empty without constraints."""
    if not system.eliminated:
        return []
    names = [c.name for c in system.coordinates]
    left = f"The constraints leave the {'coordinate' if len(names) == 1 else 'coordinates'} {listed(names)}, with"
    return [Paragraph(typeset_prose(left, system)), *(formula(name_box(n), f) for n, f in system.eliminated)]


def letters_of(system: System, momentum_squared: Mapping[str, sp.Expr]) -> dict[sp.Expr, sp.Symbol]:
    """Return sums in the formulas of a system that are abbreviated in its report.

    Args:
        system: what is given.
        momentum_squared: coordinate → P², of its solution; empty where there is none.
    """
    shown = [system.kinetic, system.potential, hamiltonian(system), *momentum_squared.values()]
    return letters_for_sums(shown, [c.symbol for c in system.coordinates], [p.symbol for p in system.parameters])


def _kinks(system: System) -> list[Block]:
    """Return what the letters for signs in V stand for."""
    if not system.kinks:
        return []
    note = "V has kinks or jumps where these signs change; between them each is a constant, 1 or −1:"
    return [Paragraph((note,)), *(formula(name_box(kink.symbol.name), kink.sign) for kink in system.kinks)]


def _letters(letters: Mapping[sp.Expr, sp.Symbol] | None) -> list[Block]:
    if not letters:
        return []
    with abbreviating({}):
        defined = [formula(name_box(symbol.name), e) for e, symbol in letters.items()]
    return [Paragraph(("Here and in everything that follows:",)), *defined]


RELATIVISTIC = (
    "A relativistic particle. T is not its energy but the classical kinetic energy, which gives the metric and the "
    "terms linear in the velocities."
)


def _hamilton(system: System) -> list[Block]:
    """Show the Hamiltonian and its momenta; of a relativistic particle they are not ∂T/∂q̇."""
    H = hamiltonian(system)
    if system.relativity is None:
        text = ("The Hamiltonian, with the momenta ", Mathematics(_momentum_definition()), ":")
        return [Paragraph(text), formula(Glyph("H"), H, "Greenwood (4-109)")]
    field = any(linear_terms(system))
    tag = "" if field else "Greenwood (7-159)"
    return [
        Paragraph(("The momenta:",)),
        *(formula(name_box(f"p_{name}"), p, tag) for name, p in momenta(system).items()),
        Paragraph(("The Hamiltonian, the rest energy included:",)),
        formula(Glyph("H"), H, "Greenwood (7-170)" if field else "Greenwood (7-165)"),
    ]


def _momentum_definition() -> Box:
    partial = Glyph("∂", "differential")
    dot = name_box("dot(q)")
    top, bottom = row(partial, Glyph("T")), row(partial, Script(dot, Glyph("i")))
    return row(Script(Glyph("p"), Glyph("i")), EQUALS, top, Glyph("/", "operator"), bottom)


def _coordinates(system: System, meanings: Mapping[str, tuple[str, str]]) -> Table:
    rows = [((Mathematics(name_box(c.name)),), domain_text(c.domain, c.name)) for c in system.coordinates]
    meanings_and_units = [meanings.get(c.name, ("", "")) for c in system.coordinates]
    return _with_meanings((("Coordinate",), ("Domain",)), rows, meanings_and_units, system, "Coordinates")


def _with_meanings(
    header: tuple[Text, ...], rows: Sequence[tuple[Text, ...]], meanings_and_units: Sequence[tuple[str, str]],
    system: System, caption: str,
) -> Table:  # fmt: skip
    """Return a table with columns for meanings and units, those that are not empty."""
    columns: list[tuple[Text, list[Text]]] = [
        (("Meaning",), [typeset_prose(meaning, system) for _, meaning in meanings_and_units]),
        (("Unit",), [(typeset(unit),) if unit else () for unit, _ in meanings_and_units]),
    ]
    kept = [(head, cells) for head, cells in columns if any(cells)]
    full = tuple(row + tuple(cells[k] for _, cells in kept) for k, row in enumerate(rows))
    return Table((*header, *(head for head, _ in kept)), full, caption)


def _parameters(system: System) -> Table:
    rows: list[tuple[Text, ...]] = [
        ((Mathematics(name_box(p.name)),), exactly(p.value) if p.value is not None else ("no default",), (p.assume,))
        for p in system.parameters
    ]
    meanings_and_units = [(p.unit, p.meaning) for p in system.parameters]
    return _with_meanings((("Parameter",), ("Default",), ("Assumed",)), rows, meanings_and_units, system, "Parameters")


# -------------------------------------------------------------------------------- the reduction and the test
def steps_block(steps: Sequence[ReductionStep], system: System) -> Steps:
    """Write an argument of the symbolic half.

    Args:
        steps: its ``ArgumentStep`` values.
        system: whose names they use.

    Returns:
        The argument.
    """
    return Steps(
        tuple(
            ArgumentStep(s.title, typeset_prose(s.explanation, system), _step_formula(s.title, s.formula))
            for s in steps
        )
    )


def _step_formula(title: str, result: sp.Basic | None) -> Formula | None:
    """Nested tuples (the Liouville functions) have their own table and are not repeated here."""
    if result is None or (isinstance(result, sp.Tuple) and any(isinstance(item, sp.Tuple) for item in result)):
        return None
    if title in _LEFT:
        return Formula(broken(row(Glyph(_LEFT[title]), EQUALS, box(result))), str(result))
    shown = contracted(result) if isinstance(result, sp.Expr) else result
    return Formula(display(shown), str(shown))


_LEFT = {"Stäckel matrix": "Φ", "Stäckel column": "ψ"}


def reduction_section(verdict: Separation | Obstruction | Undecided) -> Section | None:
    """Tell how the system was reduced to its energy shell; None where it never had one."""
    if verdict.shell is None:
        return None
    text = (
        "Ignorable coordinates are replaced by their constant momenta. The energy shell that remains "
        "consists of a quadratic form in the momenta of the other coordinates and an effective potential."
    )
    return Section(
        "reduction",
        "Reduction to the energy shell",
        (Paragraph((text,)), steps_block(verdict.shell.steps, verdict.system)),
    )


def evidence_section(verdict: Separation | Obstruction | Undecided, *, lead: bool = True) -> Section | None:
    """Give the evidence for the verdict.

    Args:
        verdict: any verdict.
        lead: whether the section begins with the answer itself.

    Returns:
        The section; None where there is nothing to say.
    """
    known = verdict.shell.steps if verdict.shell else ()
    rest = [step for step in verdict.evidence if step not in known]
    blocks: tuple[Block, ...] = (Paragraph(answer(verdict)),) if lead else ()
    if rest:
        blocks += (steps_block(rest, verdict.system),)
        blocks += condition_formulas(" ".join(step.explanation for step in rest))
    return Section("test", "Does it separate?", blocks) if blocks else None


def answer(verdict: Separation | Obstruction | Undecided) -> Text:
    """Say the verdict in a sentence or two."""
    names = [c.name for c in verdict.system.coordinates]
    inside = ("in ", *listed(names))
    match verdict:
        case Separation():
            free = verdict.ignorable
            ignorable: Text = (
                (" ", *listed(free), " " + ("is" if len(free) == 1 else "are") + " ignorable.") if free else ()
            )
            left = [name for name in names if name not in free]
            if free and left and verdict.stackel is None and verdict.liouville is None and verdict.reduced.stackel:
                many = ("s", "are") if len(free) > 1 else ("", "is")
                gone: Text = (f" once the ignorable coordinate{many[0]} ", *listed(free), f" {many[1]} eliminated")
                return (Strong("Separates"), " in ", *listed(left), *gone, _by_its_shell(verdict))
            return (Strong("Separates"), " ", *inside, _form(verdict), *ignorable)
        case Obstruction():
            part = f": the {_PARTS.get(verdict.part, verdict.part)}"
            pair = (" couples ", *listed(verdict.pair)) if len(set(verdict.pair)) > 1 else (" prevents it",)
            return (Strong("Does not separate"), " ", *inside, part, *pair, ".")
        case Undecided():
            return (
                Strong("Not decided"),
                " ",
                *inside,
                ": the residual could neither be proved zero nor proved different from zero.",
            )


_PARTS = {
    "metric": "kinetic energy",
    "potential": "potential",
    "gyroscopic": "gyroscopic term",
    "time": "explicit time",
    "reduction": "reduction",
}


def _form(verdict: Separation) -> str:
    if verdict.liouville is not None:
        return ": a system of Liouville form."
    if verdict.stackel is not None:
        return (
            ": a system of Stäckel form, not of Liouville form."
            if verdict.reduced.liouville is None
            else (": a system of Stäckel form; of Liouville form only once the ignorable coordinates are eliminated.")
        )
    if verdict.reduced.stackel is None:
        return ": no coordinate is left after the ignorable ones; the motion is uniform."
    return _by_its_shell(verdict)


def _by_its_shell(verdict: Separation) -> str:
    """Say what stands between the full system and its separable shell: relativity, linear terms, mixed products."""
    whose = "Stäckel" if verdict.reduced.liouville is None else "Liouville"
    if verdict.system.relativity is not None:
        return f": the energy relation, squared, is a shell of {whose} form for every energy."
    if not _diagonal(verdict.system):
        return f"; the kinetic energy has products of velocities. The shell is of {whose} form."
    if any(linear_terms(verdict.system)):
        how = "are a gradient and are shifted away" if any(verdict.shell.shift) else "become part of the potential"
        return f": T has terms linear in the velocities, which {how}. The shell is of {whose} form."
    return f": the shell is of {whose} form."


def _diagonal(system: System) -> bool:
    """Return whether T holds no product of two velocities; entries that only look like something are decided."""
    mass = mass_matrix(system)
    mixed = (mass[i, j] for i in range(mass.rows) for j in range(i))
    return all(entry == 0 or isinstance(is_zero(entry), Zero) for entry in mixed)
