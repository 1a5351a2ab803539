"""The section of closed forms: by regime, the integrals done, their inverses, and what has no form and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import sympy as sp

from hjsolve.closed_form.along_motion import TIME
from hjsolve.closed_form.closed_forms import closed_forms, own_form
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.why_not import WhyNot
from hjsolve.errors import required
from hjsolve.functions import JacobiAM, JacobiCN, JacobiDN, JacobiSN
from hjsolve.motion.motion import Motion
from hjsolve.reports.document import Block, Code, Formula, Inline, Mathematics, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.from_sympy import applied, box, falling_powers
from hjsolve.reports.formulas.layout import Box, Glyph, row, width
from hjsolve.reports.formulas.line_breaks import NARROW, broken, display, narrowed
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.reports.sections.solution import source_of_equation
from hjsolve.reports.sections.system_and_verdict import IN_A_CELL, equation, formula, math
from hjsolve.solution.quadratures import Solution

_MOST_PARTS, _SMALLEST_PART, _LARGEST_PART = 30, 3, 60
"""Of letters; and of operations in what one stands for."""
Parts = list[tuple[sp.Symbol, sp.Expr]]

_MOST_OPERATIONS = 90
"""Of W in the actions: beyond, it fills a page."""
_SHORT_PERIOD = 12
"""Operations of a period that is still read at a glance."""
_GROUPS = {"periods": "Period", "frequencies": "Frequency", "actions": "Action", "mean_velocities": "Mean velocity"}
_MOST_REGIMES = 3
LONGEST_SHOWN = 400
"""Operations of a formula that takes a page."""
_WITH_PARAMETER = (
    sp.elliptic_k, sp.elliptic_f, sp.elliptic_e, sp.elliptic_pi, JacobiSN, JacobiCN, JacobiDN, JacobiAM,
)  # fmt: skip
_CONVENTION = (
    "The last argument of K, E, F, Π, sn, cn, dn and am is the parameter m = k², the square of the modulus k; "
    "the first argument of Π is the characteristic ν. "
)
_BRANCHES = (
    "Arc functions of a coordinate hold on the branch on which it grows, up to the next turning point; "
    "functions of t, ξ and τ hold over all turns. A lower limit q₀ is a constant between the turning points, or one of "
    "them, a simple zero of p²."
)
_WIDEST = NARROW / 0.65
"""Letters of the longest piece of a formula that cannot be broken; it is set smaller on a narrow screen."""
_WIDEST_CELL = 1.2 * IN_A_CELL
"""And in a table, where it is not."""
SECONDS = 6.0
"""Of processor time, for the forms of a report: Kerr, Vinti and two centres, the longest, take three to four."""


def closed_form_report(subject: Motion | Solution) -> list[Section]:
    """Return the forms of a motion's own regime, or of the regimes of a solution, as far as a report has time for them.

    Args:
        subject: a motion, or a solution where no motion is known.
    """
    if (subject.solution if isinstance(subject, Motion) else subject).system.kinks:
        return []
    if isinstance(subject, Motion):
        solution, own = subject.solution, own_form(subject, seconds=SECONDS)
        forms = [] if own is None else [own]
    else:
        solution, forms = subject, [*closed_forms(subject, seconds=SECONDS)[:_MOST_REGIMES]]
    if not solution.coordinates:
        return []
    sections = closed_form_sections(forms)
    more = "python -c 'import hjsolve; hjsolve.closed_forms(…)'"
    which = "the regime of this motion" if isinstance(subject, Motion) else "the first regimes found"
    name = solution.system.id
    note: Text = (
        f"This section shows {which}. The command ", Code(f"hjsolve solve {name} --closed" if name else more),
        f" derives every regime and is not limited to the {SECONDS:g} s of processor time of a report.",
    )  # fmt: skip
    last = sections[-1]
    return [*sections[:-1], replace(last, blocks=(*last.blocks, Paragraph(note)))]


def closed_form_sections(forms: Sequence[RegimeForms]) -> list[Section]:
    """One section for each regime.

    Args:
        forms: of the solution, or of a motion.
    """
    if not forms:
        text = "No regime was found in which the motion is neither at rest nor asymptotic."
        return [Section("closed-forms", "Closed forms", (Paragraph((text,)),))]
    several = len(forms) > 1
    return [_section(form, number if several else 0) for number, form in enumerate(forms, 1)]


def _section(form: RegimeForms, number: int) -> Section:
    system = form.solution.system
    words, conditions = _conditions(typeset_prose(form.regime.words, system))
    intro: Text = (
        "These forms hold in one regime (", *words, "). The derivative of each was compared with its integrand to 40 "
        "digits. Momenta of separated coordinates are taken as positive.",
    )  # fmt: skip
    blocks: list[Block | _TooLong] = [Paragraph(intro), *conditions]
    forms_shown = _ShownForms(form.where)
    blocks += _formulas(form, forms_shown)
    blocks += _in_actions(form)
    blocks += _quantities(form, forms_shown)
    long = [block.name for block in blocks if isinstance(block, _TooLong)]
    shown = [block for block in blocks if not isinstance(block, _TooLong)] + _remarks(form, long)
    suffix = f"-{number}" if number else ""
    title = f"Closed forms, regime {number}" if number else "Closed forms"
    return Section(f"closed-forms{suffix}", title, tuple(shown))


def _formulas(form: RegimeForms, forms_shown: _ShownForms) -> list[Block | _TooLong]:
    """Return the time law, the coordinates along the motion, W and the energy."""
    blocks: list[Block | _TooLong] = []
    if form.time_law is not None:
        blocks += forms_shown.shown("time_law", form.time_law, lambda e: equation(e, "Greenwood (5-71)"))
    for q, e in form.inverse.items():
        blocks += forms_shown.shown(f"inverse.{q}", e, partial(formula, applied(name_box(q), name_box("t"))))
    blocks += _anomaly(form, forms_shown)
    for name, law in form.orbit_equations.items():
        source = source_of_equation(form.solution, name)
        blocks += forms_shown.shown(f"orbit_equations.{name}", law, partial(equation, tag=source))
    for q, e in form.orbit.items():
        blocks += forms_shown.shown(f"orbit.{q}", e, partial(formula, applied(name_box(q), _along(form, q))))
    for q, e in form.parametric.items():
        blocks += forms_shown.shown(f"parametric.{q}", e, partial(formula, applied(name_box(q), name_box("tau"))))
    if form.characteristic_function is not None:
        W = form.characteristic_function
        blocks += forms_shown.shown("characteristic_function", W, lambda e: formula(Glyph("W"), e, "Greenwood (5-65)"))
    if form.energy is not None:
        blocks += forms_shown.shown("energy", form.energy, partial(formula, name_box("E")))
    return blocks


def _quantities(form: RegimeForms, forms_shown: _ShownForms) -> list[Block | _TooLong]:
    """Return the quantities of the motion: short ones in a table, long ones below it."""
    blocks: list[Block | _TooLong] = []
    system = form.solution.system
    numbers = [
        (group, q, _by_frequency(form, group, q, e)) for group in _GROUPS for q, e in getattr(form, group).items()
    ]
    narrow = [one for one in numbers if width(display(one[2], IN_A_CELL)) <= _WIDEST_CELL]
    if narrow:
        blocks += forms_shown.meanings([e for *_, e in narrow])
        rows = tuple((typeset_prose(f"{_GROUPS[group]} of {q}", system), (math(e),)) for group, q, e in narrow)
        blocks.append(Table((("Quantity",), ("Closed form",)), rows, "Quantities of the motion"))
    for group, q, e in numbers:
        if (group, q, e) not in narrow:
            left = row(Glyph(f"{_GROUPS[group]} of ", "text"), name_box(q))
            blocks += forms_shown.shown(f"{group}.{q}", e, partial(formula, left))
    return blocks


def _remarks(form: RegimeForms, long: list[str]) -> list[Block]:
    """Return what is to be said of the forms shown, and of those that are not: too long, or not found."""
    system = form.solution.system
    shown: list[Block] = []
    if any(value.has(*_WITH_PARAMETER) for value in form.named().values()):
        shown.append(Paragraph((_CONVENTION,)))
    if form.solution.coordinates:
        shown.append(Paragraph((_BRANCHES,)))
    if long:
        shown.append(
            Paragraph(
                ("Forms that take more than a page: ", *_names(form, long), ". ", Code("form.code()"), " writes them.")
            )
        )
    if form.why_not:
        missing = tuple((_names(form, names), typeset_prose(text, system)) for text, names in _by_reason(form.why_not))
        shown.append(Table((("Quantity",), ("Why",)), missing, "Without a closed form: proved, or not found"))
    return shown


def _by_frequency(form: RegimeForms, group: str, q: str, e: sp.Expr) -> sp.Expr:
    """Return 2π/|Ω| for a period that would be a fraction of fractions; the frequency stands in the same table."""
    if group != "periods" or q not in form.frequencies or not e.has(sp.Abs) or sp.count_ops(e) <= _SHORT_PERIOD:
        return e
    return 2 * sp.pi / sp.Abs(sp.Symbol(f"Omega_{q}", real=True))


def _in_actions(form: RegimeForms) -> list[Block]:
    """Write down the constants and W in the actions, where W is short enough."""
    others = {name: e for name, e in form.constants_of_actions.items() if name in form.solution.constants}
    rest = list(others.items())[1:]  # E has a line of its own
    shown: list[Block] = [formula(name_box(name), e) for name, e in rest if not e.is_Symbol]
    W = form.function_of_actions
    if W is not None and sp.count_ops(W) <= _MOST_OPERATIONS:
        words = "In the actions, W generates the map to angles and actions; the angles are w = ∂W/∂J (6-88):"
        shown += [Paragraph((words,)), formula(Glyph("W"), W, "Greenwood (6-85)")]
    return shown


class _ShownForms:
    """Which definitions a section has given: each stands after the first formula that uses it.

    Args:
        where: symbol → definition.
    """

    def __init__(self, where: Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]):
        self.where, self.known = where, set[sp.Symbol]()
        self.letters, self.lettered = sp.numbered_symbols("u_", start=1, real=True), dict[sp.Expr, sp.Symbol]()

    def shown(self, name: str, e: sp.Basic, write: Callable[[sp.Basic], Formula]) -> list[Block | _TooLong]:
        """Return a formula, and what the quantities in it are."""
        found = (
            None
            if sp.count_ops(e) > LONGEST_SHOWN
            else in_parts(e, lambda part: _fits(part, write), self.letters, self.lettered)
        )
        if found is None:
            return [_TooLong(name)]
        shown, parts = found
        with_parts = [block for letter, part in parts for block in _meaning([(letter, -1)], part)]
        return [write(shown), *with_parts, *self.meanings([e])]

    def meanings(self, shown: Sequence[sp.Basic]) -> list[Block | _TooLong]:
        """Return what the quantities of formulas are, those of which nothing was said."""
        needed, _ = needed_names({s for e in shown for s in e.free_symbols}, self.where)
        new = {s: meaning for s, meaning in reversed(needed.items()) if s not in self.known}
        self.known |= set(new)
        short = [s for s, e in new.items() if _fits_a_sentence(s, e)]
        pieces: list[Inline] = []
        for s in short:
            pieces += [", " if pieces else "with ", math(sp.Eq(s, new[s], evaluate=False))]
        blocks: list[Block | _TooLong] = [Paragraph(tuple(pieces))] if short else []
        rest = {s: new[s] for s in reversed(new) if s not in short}
        return blocks + [block for meaning, symbols in _by_meaning(rest) for block in _meaning(symbols, meaning)]


def _fits_a_sentence(symbol: sp.Symbol, meaning: object) -> bool:
    if isinstance(meaning, tuple):
        return False
    return width(box(sp.Eq(symbol, meaning, evaluate=False))) <= NARROW


def _along(form: RegimeForms, q: str) -> Box:
    """Return the coordinate on which an orbit formula depends."""
    held = form.written_out(f"orbit.{q}").free_symbols
    return name_box(next(c.name for c in form.solution.system.coordinates if c.symbol in held and c.name != q))


def _anomaly(form: RegimeForms, forms_shown: _ShownForms) -> list[Block | _TooLong]:
    """q(ξ) and n (t − t_p) = ξ − e sin ξ."""
    blocks: list[Block | _TooLong] = []
    for q, e in form.anomaly.items():
        ξ = next(s for s in e.free_symbols if s.name in ("xi", "chi", "xi_1"))
        if q != TIME:
            blocks += forms_shown.shown(f"anomaly.{q}", e, partial(formula, applied(name_box(q), box(ξ))))
            continue
        t = next(term for term in required(form.time_law).lhs.args if term.is_Symbol)
        passed, running = e.as_independent(ξ, as_Add=True)
        scale, rest = running.as_independent(ξ, as_Add=False)
        equal = sp.Eq(sp.Mul(1 / scale, t - passed, evaluate=False), rest, evaluate=False)
        blocks += forms_shown.shown(f"anomaly.{q}", equal, equation)
    return blocks


@dataclass(frozen=True)
class _TooLong:
    """In place of a formula that takes more than a page: its name."""

    name: str


def _by_meaning(where: Mapping[sp.Symbol, object]) -> list[tuple[object, list[tuple[sp.Symbol, int]]]]:
    """Meanings in order, each with its symbols; the real roots of one polynomial together, with their numbers."""
    groups: dict[tuple[bool, object], list[tuple[sp.Symbol, int]]] = {}
    for symbol, meaning in where.items():
        one: tuple[object, int] = meaning if isinstance(meaning, tuple) else (meaning, -1)
        groups.setdefault((one[1] >= 0, one[0]), []).append((symbol, one[1]))
    return [(key[1], symbols) for key, symbols in groups.items()]


def _by_reason(why_not: Mapping[str, WhyNot]) -> list[tuple[str, list[str]]]:
    groups: dict[str, list[str]] = {}
    for name, reason in why_not.items():
        mark = "proved" if reason.proved else "not found"
        groups.setdefault(f"{mark}: {reason}", []).append(name)
    return list(groups.items())


def _names(form: RegimeForms, names: list[str]) -> Text:
    """Name forms as a reader of the page knows them: ``inverse.r`` is r(t)."""
    pieces: list[Inline] = []
    for name in names:
        pieces += [", " if pieces else "", *_readable(form, name)]
    return tuple(pieces)


def _readable(form: RegimeForms, name: str) -> Text:
    group, _, of = name.partition(".")
    if group in ("inverse", "parametric"):
        return (Mathematics(applied(name_box(of), name_box("t" if group == "inverse" else "tau"))),)
    if group == "orbit" and of:
        others = [c.name for c in form.solution.system.coordinates if c.name != of]
        return (Mathematics(applied(name_box(of), name_box(others[0]))),) if len(others) == 1 else ("orbit, ", _set(of))
    if group in _GROUPS and of:
        return (f"{_GROUPS[group].lower()} of ", _set(of))
    if group == "orbit_equations" and of:
        return ("orbit equation of ", _set(of))
    spoken = {"energy": "energy as a function of the actions", "characteristic_function": "W", "time_law": "time law"}
    return (spoken[name],) if name in spoken else (Code(name),)


def _set(name: str) -> Mathematics:
    return Mathematics(name_box(name))


def _conditions(words: Text) -> tuple[Text, list[Formula]]:
    """Return the words of a regime, and the conditions that are too long for a sentence, displayed."""
    kept: list[Inline] = []
    displayed: list[Formula] = []
    for piece in words:
        if isinstance(piece, Mathematics) and width(piece.box) > NARROW:
            tag = f"condition ({len(displayed) + 1})"
            displayed.append(Formula(broken(piece.box), plain(piece.box), tag))
            kept.append(tag)
        else:
            kept.append(piece)
    return tuple(kept), displayed


def _fits(e: sp.Basic, write: Callable[[sp.Basic], Formula]) -> bool:
    """Return whether every piece of a formula that cannot be broken is narrow enough."""
    return width(narrowed(write(e).box)) <= _WIDEST


def _shown(name: str, e: sp.Basic, write: Callable[[sp.Basic], Formula]) -> Formula | _TooLong:
    """Return a definition; of one that takes more than a page its name."""
    return write(e) if sp.count_ops(e) <= LONGEST_SHOWN and _fits(e, write) else _TooLong(name)


def _meaning(symbols: list[tuple[sp.Symbol, int]], meaning: object) -> list[Block | _TooLong]:
    """Return what symbols of a form stand for: in a sentence where it is short, else displayed."""
    if isinstance(meaning, sp.Poly) and symbols[0][1] >= 0:
        e, words = falling_powers(meaning), _root_words(symbols, meaning.degree())
        if width(box(e)) <= NARROW:
            return [Paragraph((*words, math(e)))]
        return [Paragraph(words), _shown(str(symbols[0][0]), e, equation)]
    if len(symbols) > 1:
        return [block for one in symbols for block in _meaning([one], meaning)]
    symbol, e = symbols[0][0], sp.sympify(meaning)
    if width(box(e)) <= NARROW:
        return [Paragraph((math(symbol), " = ", math(e)))]
    return [_shown(str(symbol), e, partial(formula, box(symbol)))]


def _root_words(symbols: list[tuple[sp.Symbol, int]], degree: int) -> Text:
    """Return which of the real roots of one polynomial the symbols are, from the lowest up."""
    upwards = sorted(symbols, key=lambda one: one[1])
    pieces: list[Inline] = []
    for symbol, _ in upwards:
        pieces += [" < " if pieces else "", math(symbol)]
    places = [index + 1 for _, index in upwards]
    if len(places) == 1:
        return (*pieces, f": real root {places[0]}, counted upwards, of ")
    if places == list(range(1, degree + 1)):
        return (*pieces, ": the real roots of ")
    first, last = ", ".join(map(str, places[:-1])), places[-1]
    return (*pieces, f": real roots {first} and {last}, counted upwards, of ")


def in_parts(
    formula: sp.Basic, fits: Callable[[sp.Basic], bool], letters: Iterator[sp.Symbol], known: dict[sp.Expr, sp.Symbol]
) -> tuple[sp.Basic, Parts] | None:  # fmt: skip
    """Give letters to sums until a formula fits, and until what the letters stand for fits.

    Args:
        formula: an expression or an equation.
        fits: whether one can be set.
        letters: to be used.
        known: sum → letter that it has; gets more.

    Returns:
        The formula in letters, and each letter with its meaning, in the order of their use; None where there are too
        many.
    """
    parts: Parts = []
    waiting: list[sp.Basic] = [formula]
    done: list[sp.Basic] = []
    while waiting:
        e = waiting.pop(0)
        while not fits(e):
            sum_ = _widest_sum(e)
            if sum_ is None or len(parts) >= _MOST_PARTS:
                return None
            if sum_ not in known:
                known[sum_] = next(letters)
                parts.append((known[sum_], sum_))
                waiting.append(sum_)
            e = e.xreplace({sum_: known[sum_]})
        done.append(e)
    first, *rest = done
    return first, [(letter, e) for (letter, _), e in zip(parts, rest, strict=True)]


def _widest_sum(e: sp.Basic) -> sp.Expr | None:
    """Return the sum inside a formula that saves most."""
    outer = set(e.args) | {e} if isinstance(e, sp.Eq) else {e}
    found = Counter(p for p in sp.preorder_traversal(e) if p.is_Add and p not in outer)
    sizes = {p: sp.count_ops(p) for p in found}
    good = [(found[p] * n, n, sp.srepr(p), p) for p, n in sizes.items() if _SMALLEST_PART <= n <= _LARGEST_PART]
    return max(good)[-1] if good else None
