"""The sections of a report about the solution: Stäckel and Liouville forms, W, time law, orbit equations."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.system import kinetic_rest
from hjsolve.reports.document import Block, Formula, Mathematics, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.from_sympy import box, compact, constants_outside
from hjsolve.reports.formulas.layout import Box, Fence, Fraction, Glyph, Script, row, width
from hjsolve.reports.formulas.line_breaks import LINE, broken, display
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.prose import first_unit_vector, listed, typeset_prose, with_names
from hjsolve.reports.sections.system_and_verdict import EQUALS, equation, formula, math
from hjsolve.separation import Liouville, Separation, Stackel
from hjsolve.solution.quadratures import Solution


def forms_section(verdict: Separation) -> Section | None:
    """Show the Stäckel matrix and the Liouville functions, of the full system and of the shell.

    Returns:
        The section; None where there is nothing to show.
    """
    full, shell = (verdict.stackel, verdict.liouville), (verdict.reduced.stackel, verdict.reduced.liouville)
    blocks: list[Block] = []
    if any(full) and verdict.ignorable:
        text = (
            "For the whole system every ignorable coordinate has its own row and separation constant, "
            "unlike in the matrix of the energy shell."
        )
        blocks.append(Paragraph((text,)))
    blocks += _forms(*full, _Whose("H", Glyph("V" if kinetic_rest(verdict.system) == 0 else "V′")))
    if any(shell) and (not all(full) or not verdict.ignorable) and shell != full:
        blocks += [Paragraph((_of_the_shell(verdict),)), *_forms(*shell, _Whose("the shell", name_box("V_eff")))]
    return Section("forms", "Stäckel and Liouville forms", tuple(blocks)) if blocks else None


@dataclass(frozen=True)
class _Whose:
    """What a form belongs to: H of the whole system with V (V′ = V − T₀), or the shell with its effective potential."""

    energy: str
    potential: Box


def _of_the_shell(verdict: Separation) -> str:
    constant = ", with the ignorable momenta as constants" if verdict.ignorable else ""
    if verdict.stackel is not None or verdict.liouville is not None:
        return f"Of the shell{constant}:"
    if verdict.system.relativity is not None:
        return f"Of the shell, the squared energy relation{constant}:"
    return f"The whole system is of neither form; its shell is{constant}:"


def _forms(stackel: Stackel | None, liouville: Liouville | None, whose: _Whose) -> list[Block]:
    blocks: list[Block] = []
    if stackel is not None:
        blocks += _stackel(stackel, whose)
    if liouville is not None:
        blocks += _liouville(liouville, whose)
    return blocks


def _stackel(form: Stackel, whose: _Whose) -> list[Block]:
    Φ, ψ, c = Glyph("Φ"), Glyph("ψ"), Glyph("c")
    column = sp.ImmutableMatrix(form.column)
    metric = sp.ImmutableMatrix(form.inverse_metric)
    gap = Glyph(",  ", "text")
    whole = row(Φ, EQUALS, box(form.matrix), gap, ψ, EQUALS, box(column), gap, c, EQUALS, box(metric))
    transposed = Script(c, sup=Glyph("T", "text"))
    text: Text = (
        "Stäckel matrix ",
        Mathematics(Φ),
        ", column ",
        Mathematics(ψ),
        " and coefficients ",
        Mathematics(c),
        " of ",
        Mathematics(row(Fraction(Glyph("1", "number"), Glyph("2", "number")), _squared("p"))),
        " in ",
        *([Mathematics(Glyph("H"))] if whose.energy == "H" else [whose.energy]),
        ". ",
        *(_rows(form.coordinates) if len(form.coordinates) > 1 else ()),
        "Checked by substitution, exactly: ",
        Mathematics(row(transposed, Φ, EQUALS, first_unit_vector())),
        " and ",
        Mathematics(row(transposed, ψ, EQUALS, whose.potential)),
        ".",
    )
    source = f"Phi = {form.matrix.tolist()}, psi = {list(form.column)}, c = {list(form.inverse_metric)}"
    return [Paragraph(text), Formula(broken(whole), source, "Greenwood (5-139)")]


def _rows(coordinates: tuple[str, ...]) -> Text:
    i = Mathematics(Glyph("i"))
    return ("Row ", i, " depends on coordinate ", i, " only, in the order ", *listed(coordinates), ". ")


def _squared(letter: str) -> Box:
    return Script(Glyph(letter), sup=Glyph("2", "number"))


def _liouville(form: Liouville, whose: _Whose) -> list[Block]:
    names = [name_box(name) for name in form.coordinates]
    rows = tuple(
        ((Mathematics(name),), (math(f),), (math(R),), (math(v),))
        for name, f, R, v in zip(names, form.f, form.R, form.v)
    )
    i, sums = Glyph("i"), Glyph("∑", "operator")
    f, R, v = (Script(Glyph(letter), i) for letter in "fRv")
    two = Glyph("2", "number")
    kinetic = row(Glyph("T"), EQUALS, Fraction(row(sums, R, Script(Glyph("p"), i, two)), row(two, sums, f)))
    potential = row(whose.potential, EQUALS, Fraction(row(sums, v), row(sums, f)))
    whole = row(kinetic, Glyph(",  ", "text"), potential)
    header: tuple[Text, ...] = (("Coordinate",), (Mathematics(f),), (Mathematics(R),), (Mathematics(v),))
    return [
        Paragraph(("Liouville form:",)),
        Formula(whole, "T = sum(R_i*p_i**2)/(2*sum(f_i)), V = sum(v_i)/sum(f_i)", "Greenwood (5-125)"),
        Table(header, rows, "Liouville functions"),
    ]


# ------------------------------------------------------------------------------------------------ the solution
def solution_sections(solution: Solution) -> list[Section]:
    """Give W with the momenta and constants, the time law, and the orbit equations.

    Returns:
        Three sections; the time law is missing where every coordinate is ignorable.
    """
    sections = [_characteristic_function(solution)]
    if solution.time_law is not None:
        letter = time_name(solution.system)
        what = "time" if letter == "t" else "parameter of the motion"
        text = (
            f"This is the {what} as a function of position. The root is positive while the coordinate increases and "
            "negative while it decreases. The lower limit is a constant, or a simple zero of the radicand; it fixes "
            f"the initial {what}."
        )
        if letter != "t":
            text += f" It is called {letter}, for t is a coordinate here."
        law = _jacobi(solution, solution.time_law, "Greenwood (5-71)")
        prose = with_names(text, () if letter == "t" else ("t",))
        sections.append(Section("time-law", "Time law", (Paragraph(prose), law)))
    equations = tuple(
        _jacobi(solution, e, source_of_equation(solution, name)) for name, e in solution.orbit_equations.items()
    )
    if equations:
        timed = any(_holds_time(solution, e) for e in solution.orbit_equations.values())
        text = "There is one equation for each further constant. Together they give the " + (
            "motion, because they contain the time." if timed else "orbit, without the time."
        )
        sections.append(Section("orbit", "Orbit equations", (Paragraph((text,)), *equations)))
    return sections


def source_of_equation(solution: Solution, name: str) -> str:
    """Return where the book has one of Jacobi's equations other than the time law."""
    if _holds_time(solution, solution.orbit_equations[name]):
        return "Greenwood (5-76)"
    passive = {c.momentum.name for c in solution.separation.shell.ignorable}
    return "Greenwood (5-83)" if name in passive else "Greenwood (5-70)"


def _holds_time(solution: Solution, equation: sp.Eq) -> bool:
    """Return whether an equation holds the time, as of a motion without a separated coordinate."""
    coordinates = {c.symbol for c in solution.system.coordinates}
    return any(s.name == "t" for s in equation.free_symbols - coordinates)


def _jacobi(solution: Solution, law: sp.Eq, tag: str) -> Formula:
    """One of Jacobi's equations; the roots of a long one are written by the letters of the momenta."""
    plain = equation(law, tag)
    if not _is_long(solution):
        return plain
    return Formula(display(sp.Eq(law.lhs, _by_momenta(solution, law.rhs), evaluate=False)), plain.source, tag)


def _is_long(solution: Solution) -> bool:
    """Return whether the squared momenta are too long to be repeated under every integral."""
    return any(width(box(square)) > LINE for square in solution.momentum_squared.values())


def _by_momenta(solution: Solution, expression: sp.Expr) -> sp.Expr:
    """Return an expression with p(q), or P(q) with P = p + A, in place of the roots √P²."""
    letters = {}
    for name, square in solution.momentum_squared.items():
        letter = f"P_{name}" if solution.shift[name] != 0 else f"p_{name}"
        letters[square] = sp.Function(letter, positive=True)(solution.system.coordinate(name).symbol) ** 2
    return constants_outside(expression.xreplace(letters))


def _characteristic_function(solution: Solution) -> Section:
    function = constants_outside(solution.characteristic_function)
    words = "The derivatives of W with respect to the coordinates are the momenta:"
    if _is_long(solution):
        function = _by_momenta(solution, solution.characteristic_function)
        words = (
            "The derivatives of W with respect to the coordinates are the momenta. The integrands here and below are "
            "the roots of their squares, which are given next:"
        )
    equality = sp.Eq(sp.Symbol("W"), function, evaluate=False)
    blocks: list[Block] = [
        Paragraph((words,)),
        Formula(display(equality), f"W = {solution.characteristic_function}", "Greenwood (5-65)"),
    ]
    energy = solution.separation.shell.energy
    if solution.coordinates and time_name(solution.system) == "t":
        principal = sp.Eq(sp.Symbol("S"), sp.Symbol("W") - energy * sp.Symbol("t"), evaluate=False)
        blocks.append(Formula(display(principal), f"S = W - {energy}*t", "Greenwood (5-65)"))
    for name, square in solution.momentum_squared.items():
        shifted = solution.shift[name] != 0
        left = Script(Glyph("P" if shifted else "p"), name_box(name), Glyph("2", "number"))
        short = compact(square, solution.constants["E"].symbol if "E" in solution.constants else None)
        shown = short if width(box(short)) <= LINE else square
        blocks.append(formula(left, shown, "Greenwood (5-142)"))
        if shifted:
            blocks.append(formula(name_box(f"p_{name}"), solution.momenta[name]))
    blocks += [formula(name_box(f"p_{name}"), solution.momenta[name]) for name in solution.separation.shell.null]
    blocks += _determinant(solution)
    rows = tuple(
        ((Mathematics(name_box(name)),), typeset_prose(c.meaning, solution.system), (math(c.expression),))
        for name, c in solution.constants.items()
    )
    blocks.append(Table((("Constant",), ("Meaning",), ("In terms of q and p",)), rows, "Constants of the motion"))
    return Section("characteristic-function", "Hamilton's characteristic function", tuple(blocks))


def _determinant(solution: Solution) -> list[Block]:
    """Return the determinant that makes W a complete integral, its roots written as the letters of the momenta."""
    if not solution.momentum_squared:
        return []
    roots = {name: sp.sqrt(square) for name, square in solution.momentum_squared.items()}
    letters = [sp.Symbol(f"{'P' if solution.shift[name] != 0 else 'p'}_{name}") for name in roots]
    value = solution.determinant * sp.Mul(*roots.values()) / sp.Mul(*letters)
    d, two = Glyph("∂", "differential"), Glyph("2", "number")
    below = row(d, Glyph("q"), d, Glyph("α"))
    left = Fence(Fraction(row(Script(d, None, two), Glyph("S")), below), "|", "|")
    words = (
        " is a complete integral: the Jacobian of the momenta with respect to the constants does not vanish "
        "identically. It is the product of its diagonal blocks:"
    )
    return [
        Paragraph((Mathematics(Glyph("W")), words)),
        Formula(row(left, EQUALS, box(value)), f"|d2S/dq dalpha| = {value}", "Greenwood (5-48), (5-154)"),
    ]
