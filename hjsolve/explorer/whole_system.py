"""What the boxes of the page still lack together, before any of them is called wrong.

Whoever types T first uses names that a later box declares. Each box has faults of its own (a bracket that is not
closed); what only does not fit the other boxes yet is unfinished until the system is submitted as a whole.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import sympy as sp

from hjsolve.arguments import ascii_name
from hjsolve.explorer.question import PageQuestion
from hjsolve.formulas.checked_arithmetic import FUNCTIONS
from hjsolve.formulas.read import parse
from hjsolve.formulas.tokens import FormulaText, coordinate_of_velocity, is_known_elsewhere, scan
from hjsolve.mechanics.typed_texts import typed_coordinates, typed_parameters

_NOT_NAMES = {*FUNCTIONS, "dot", "pi", "atan2", "abs", "Abs", "sign"}

_DOMAINS = {"line", "angle"}


def lines_of(text: str) -> list[str]:
    """Return the lines of a box; a semicolon ends one as well."""
    return [line for line in text.replace(";", "\n").splitlines() if line.strip()]


def unfinished(question: PageQuestion) -> tuple[str, ...]:
    """Return what is missing in the system as a whole, one sentence each.

    Raises:
        InvalidInputError: one box is wrong, whatever the others hold; ExpressionError where it is a formula.
    """
    coordinates = list(typed_coordinates(lines_of(question.coordinates), "coordinate"))
    parameters = list(typed_parameters(lines_of(question.parameters), "parameter"))
    missing = [] if coordinates else ["the coordinates are missing"]
    boxes = {"T": question.kinetic, "V": question.potential}
    if not question.kinetic.strip():
        missing.append("T is missing")
    for line in lines_of(question.coordinates):
        name, _, domain = line.partition(":")
        used = {ascii_name(word) for word in re.findall(r"[^\W\d]\w*", domain)}
        if strange := sorted(used - {ascii_name(name.strip()), *parameters, *_NOT_NAMES, *_DOMAINS}):
            missing.append(f"the domain of {name.strip()} uses {', '.join(strange)}, not among the parameters so far")
    functions = {ascii_name(text.partition("(")[0].strip()) for text in question.functions}
    velocities: set[str] = set()
    for box, text in boxes.items():
        if not text.strip():
            continue
        names, speeds = _used(text, box, coordinates, functions)
        velocities |= speeds
        strange = sorted(names - {*coordinates, *parameters})
        still = sorted(speeds - {*coordinates, *strange})
        if strange:
            verb = "neither a coordinate nor a parameter" if len(strange) == 1 else "neither coordinates nor parameters"
            missing.append(f"{box} uses {', '.join(strange)}, {verb} so far")
        if still:
            missing.append(f"{box} uses {', '.join(f'dot({q})' for q in still)}, not among the coordinates so far")
    if coordinates and question.kinetic.strip():
        missing += [f"dot({q}) does not occur in T so far" for q in coordinates if q not in velocities]
    return tuple(missing)


def _used(text: str, box: str, coordinates: Iterable[str], functions: set[str]) -> tuple[set[str], set[str]]:
    """Return the names and the coordinates of velocities in a formula, read with all of them declared.

    Raises:
        ExpressionError: it cannot be read, whatever is declared.
    """
    source = {"T": "kinetic", "V": "potential"}[box]
    tokens = scan(FormulaText(source, text))
    free: set[str] = set()
    speeds: set[str] = set()
    for k, token in enumerate(tokens):
        if token.kind != "name" or token.text in _NOT_NAMES | functions or is_known_elsewhere(token.text):
            continue
        around = [t.text for t in (*tokens[max(0, k - 2) : k], tokens[k + 1])]
        if around == ["dot", "(", ")"] or around[-1] == "'":
            speeds.add(token.text)
        elif spelled := coordinate_of_velocity(token.text, coordinates):
            speeds.add(spelled)
        elif around[-1] != "(":
            free.add(token.text)
    declared: Mapping[str, sp.Symbol] = {name: sp.Symbol(name, real=True) for name in free | speeds}
    if not functions:
        parse(text, declared, velocities=declared, kinks=box == "V", source=source)
    return free, speeds
