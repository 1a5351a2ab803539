"""The commands that check a formula of the user's: ``verify`` a complete integral, ``canonical`` for a map."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from hjsolve.command_line import arguments_read
from hjsolve.errors import InvalidInputError

if TYPE_CHECKING:
    from hjsolve.separation import Undecided
    from hjsolve.theorem.answers import Flaw
    from hjsolve.theorem.canonical_maps import CanonicalMap
    from hjsolve.theorem.complete_integral import CompleteIntegral
    from hjsolve.theorem.phase_space import Subject


def verify_command(options: Namespace) -> int:
    """Decide whether W or S is a complete integral, and print what follows from it or what fails.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status: 0 it is one, 1 it is not, 3 neither was proved.

    Raises:
        InvalidInputError: W and S or neither, or no constants.
    """
    from hjsolve.theorem.complete_integral import verify

    if (options.W is None) == (options.S is None):
        raise InvalidInputError('verify: give -W "W(q, constants)" or -S "S(q, constants, t)", one of them')
    if not options.constant:
        raise InvalidInputError('verify: name the constants of the formula, e.g. --constant E --constant "a: 0 < a"')
    subject: Subject | None = arguments_read.given_hamiltonian(options)
    given = {"W": options.W} if options.W is not None else {"S": options.S}
    answer = verify(
        subject if subject is not None else arguments_read.system(options), **given,
        constants=_domains(options.constant, "--constant"), energy=options.energy, budget=options.budget,
    )  # fmt: skip
    return _printed(answer)


def canonical_command(options: Namespace) -> int:
    """Decide whether a map is canonical, and print its generating functions or what fails.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status: 0 it is, 1 it is not, 3 neither was proved.

    Raises:
        InvalidInputError: a text that is not an equation or a pair.
    """
    from hjsolve.theorem.canonical_maps import canonical

    answer = canonical(
        dict(_equation(text, "the map") for text in options.formula) or None,
        coordinates=dict(_pair(text, "--pair") for text in options.pair) or None,
        domains=_domains(options.domain, "--domain"),
        parameters=_domains(options.constant, "--constant") if options.constant else (),
        hamiltonian=options.hamiltonian,
        generating=dict([_equation(options.generating, "--generating")]) if options.generating else None,
        new=dict(_pair(text, "--new") for text in options.new) or None,
        budget=options.budget,
    )
    return _printed(answer)


def _domains(texts: list[str], source: str) -> dict[str, str]:
    """Names with their domains; any real number where none is written."""
    pairs = [_pair(text, source) if ":" in text else (text.strip(), "line") for text in texts]
    if twice := [name for name, _ in pairs if [n for n, _ in pairs].count(name) > 1]:
        raise InvalidInputError(f"{source}: {twice[0]} is given twice")
    return dict(pairs)


def _pair(text: str, source: str) -> tuple[str, str]:
    name, colon, rest = (part.strip() for part in text.partition(":"))
    if not (name and colon and rest):
        raise InvalidInputError(f'{source} {text}: write two parts with a colon between them, such as "q: p"')
    return name, rest


def _equation(text: str, source: str) -> tuple[str, str]:
    name, equals, formula = (part.strip() for part in text.partition("="))
    if not (name and equals and formula):
        raise InvalidInputError(f'{source}: "{text[:60]}" is not an equation; write "Q = sqrt(2*q)*cos(p)"')
    return name, formula


def _printed(answer: CompleteIntegral | CanonicalMap | Flaw | Undecided) -> int:
    """Print the answer; the exit status."""
    from hjsolve.reports.formats.text import section_text, wrapped
    from hjsolve.reports.sections.theorem import theorem_answer, theorem_section

    print(wrapped(theorem_answer(answer)))
    print(f"\n{section_text(theorem_section(answer))}")
    return {"Flaw": 1, "Undecided": 3}.get(type(answer).__name__, 0)
