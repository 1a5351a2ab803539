"""The commands of the theorem as tools: complete integrals, canonical maps, brackets, integrals, impacts."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from hjsolve.arguments import refuse_unused
from hjsolve.command_line import arguments_read
from hjsolve.errors import InvalidInputError, of_kind

if TYPE_CHECKING:
    from hjsolve.mechanics.system import System
    from hjsolve.reports.document import Section
    from hjsolve.separation import Undecided
    from hjsolve.theorem.answers import Flaw
    from hjsolve.theorem.canonical_maps import CanonicalMap
    from hjsolve.theorem.complete_integral import CompleteIntegral
    from hjsolve.theorem.own_motion import OwnMotion
    from hjsolve.theorem.phase_space import Subject


def verify_command(options: Namespace) -> int:
    """Decide whether W or S is a complete integral, and print what follows from it or what fails.

    Returns:
        The exit status: 0 it is one, 1 it is not, 3 neither was proved.

    Raises:
        InvalidInputError: W and S or neither, or no constants.
    """
    from hjsolve.theorem.complete_integral import CompleteIntegral, verify

    given = {name: f for name in ("W", "S", "F4") if (f := getattr(options, name)) is not None}
    if len(given) != 1:
        raise InvalidInputError('verify: give -W "W(q, constants)", -S "S(q, constants, t)" or --F4, one of them')
    if not options.constant:
        raise InvalidInputError('verify: name the constants of the formula, e.g. --constant E --constant "a: 0 < a"')
    answer = verify(
        _subject(options), **given,
        constants=_domains(options.constant, "--constant"), energy=options.energy, budget=options.budget,
    )  # fmt: skip
    if not isinstance(answer, CompleteIntegral) or not (options.q or options.velocity or options.momentum):
        return _printed(answer, options)
    along = answer.along(arguments_read.motion_meant(options, 15))
    status = _printed(answer, options, along)
    return status or (3 if type(along).__name__ == "Undecided" else 0 if along else 1)


def bracket_command(options: Namespace) -> int:
    """Print the Poisson brackets of every two functions.

    Returns:
        The exit status, 0.

    Raises:
        InvalidInputError: fewer than two functions.
    """
    from hjsolve.theorem.integrals import poisson_bracket

    if len(options.of) < 2:
        raise InvalidInputError("bracket: give two functions or more, e.g. --of p_x --of H")
    subject = _subject(options)
    found = {
        (f, g): poisson_bracket(f, g, subject, budget=options.budget)
        for k, f in enumerate(options.of) for g in options.of[k + 1 :]
    }  # fmt: skip
    if options.json:
        return _json([{"f": f, "g": g, "bracket": str(value)} for (f, g), value in found.items()])
    from hjsolve.reports.sections.theorem import brackets_section

    return _sections(brackets_section(found))


def integral_command(options: Namespace) -> int:
    """Decide whether functions are integrals of the motion, and whether they are in involution.

    Returns:
        The exit status: 0 all of them are, 1 one is not, 3 neither was proved.

    Raises:
        InvalidInputError: no function.
    """
    from hjsolve.theorem.answers import Flaw, Proof
    from hjsolve.theorem.integrals import involution, is_integral

    if not options.of:
        raise InvalidInputError("integral: give a function, e.g. --of p_theta")
    subject = _subject(options)
    answers = {f: is_integral(f, subject, budget=options.budget) for f in options.of}
    proved = all(isinstance(a, Proof) for a in answers.values())
    together = involution(options.of, subject, budget=options.budget) if proved and len(answers) > 1 else None
    status = 1 if any(isinstance(a, Flaw) for a in answers.values()) else 0 if proved else 3
    if options.json:
        _json({"integrals": answers, "involution": together})
        return status
    from hjsolve.reports.sections.theorem import integrals_section

    _sections(integrals_section(answers, together))
    return status


def impact_command(options: Namespace) -> int:
    """Compute what constraints that appear do to the velocities.

    Returns:
        The exit status, 0.

    Raises:
        InvalidInputError: no constraint, no place, or a motion with a name.
    """
    from hjsolve.errors import InvalidSystemError
    from hjsolve.extended.impacts import impact

    if not options.meets:
        raise InvalidInputError('impact: say what holds just after, e.g. --meets "dot(y) = 0"')
    refuse_unused({"--motion": options.motion != "default"}, "an impact is at the place of --q")
    data = arguments_read.initial(options)
    if data is None:
        raise InvalidInputError("impact: give --q and --velocity (or --momentum) just before, for every coordinate")
    e = options.restitution
    groups = {key: of_kind(group, dict) for key, group in data.items()}
    hit = impact(
        arguments_read.system(options), **groups, constraints=options.meets,
        restitution=0 if not e else e[0] if len(e) == 1 else e,
    )  # fmt: skip
    try:
        later = hit.next_arc()
    except InvalidSystemError:
        later = None
    if options.json:
        return _json({"impact": hit, "energy_lost": hit.energy_lost, "budget": hit.budget, "next_arc": later})
    from hjsolve.reports.sections.impacts import impact_section

    return _sections(impact_section(hit, later))


def forces_command(options: Namespace) -> int:
    """Print Lagrange's equations with multipliers.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status, 0.
    """
    from hjsolve.coordinates.multipliers import constraint_forces

    found = constraint_forces(arguments_read.system(options), options.holds)
    if options.json:
        return _json(found)
    from hjsolve.reports.sections.constraint_forces import forces_section

    return _sections(forces_section(found))


def contact_command(options: Namespace) -> int:
    """Compute when a one-sided constraint lets go.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status, 0.

    Raises:
        InvalidInputError: no constraint, no place, or a motion with a name.
    """
    from hjsolve.scenes.one_sided_contact import contact

    if not options.holds:
        raise InvalidInputError('contact: give the one-sided constraint, e.g. --holds "x**2 + y**2 >= 1"')
    refuse_unused({"--motion": options.motion != "default"}, "contact begins at the place of --q")
    data = arguments_read.initial(options)
    if data is None:
        raise InvalidInputError("contact: give --q and --velocity (or --momentum), for every coordinate")
    groups = {key: of_kind(group, dict) for key, group in data.items()}
    found = contact(
        arguments_read.system(options), **groups, constraints=options.holds, until=options.until, digits=options.digits
    )
    if options.json:
        told = ("constraints", "multipliers", "along", "ended", "time", "place", "q", "velocity", "proved")
        return _json({name: getattr(found, name) for name in told})
    from hjsolve.reports.sections.constraint_forces import contact_section

    return _sections(contact_section(found))


def action_command(options: Namespace) -> int:
    """Compute the integral of L dt along a path.

    Returns:
        The exit status, 0.

    Raises:
        InvalidInputError: no path, or no times.
    """
    from hjsolve.reports.sections.theorem import action_section
    from hjsolve.theorem.action_along_path import action_integral

    first, colon, last = (options.between or "").partition(":")
    if not options.path or not (first and colon and last):
        raise InvalidInputError('action: give a path and times, e.g. --path "x = t**2" --between 0:1')
    path = dict(_equation(text, "--path", "x = t**2") for text in options.path)
    found = action_integral(arguments_read.system(options), path, between=(first, last), digits=options.digits)
    return _json(found) if options.json else _sections(action_section(found))


def loop_command(options: Namespace) -> int:
    """Compute the integral of p dq along a closed curve as it moves.

    Returns:
        The exit status: 0 where the values agree, 1 where they do not.

    Raises:
        InvalidInputError: no curve.
    """
    from hjsolve.command_line.motion_tables import times_from_text
    from hjsolve.mechanics.typed_texts import typed_values
    from hjsolve.reports.sections.theorem import loop_section
    from hjsolve.solution.quadratures import solve
    from hjsolve.theorem.loop_integrals import loop_integral

    if not options.q or not options.momentum:
        raise InvalidInputError('loop: give a closed curve, e.g. --q "x=cos(s)" --momentum "x=sin(s)"')
    solution = solve(arguments_read.system(options), "find" if options.find else "as given")
    found = loop_integral(
        solution, q=typed_values(options.q, "--q"), p=typed_values(options.momentum, "--momentum"),
        times=times_from_text(options.times, 15),
    )  # fmt: skip
    if options.json:
        _json({name: getattr(found, name).tolist() for name in ("times", "value", "error")})
    else:
        _sections(loop_section(found))
    return 0 if found else 1


def own_coordinates(options: Namespace, system: System) -> tuple[System, Section]:
    """Return the system in coordinates that the user types, and what was proved about them.

    Args:
        options: the parsed arguments, with ``--place`` and ``--new``.
        system: in its own coordinates.

    Raises:
        InvalidInputError: a text that is not an equation or a domain.
        InvalidSystemError: the map is not regular, or leaves the domain.
    """
    from hjsolve.coordinates.typed_change import change_coordinates
    from hjsolve.reports.sections.theorem import own_coordinates_section

    place = dict(_equation(text, "--place", "x = r*cos(phi)") for text in options.place)
    new = dict(_pair(text, "--new", "r: 0 < r") for text in options.new)
    changed = change_coordinates(system, place, coordinates=new)
    return changed, own_coordinates_section(place)


def _subject(options: Namespace) -> Subject:
    given: Subject | None = arguments_read.given_hamiltonian(options)
    return given if given is not None else arguments_read.system(options)


def canonical_command(options: Namespace) -> int:
    """Decide whether a map is canonical, and print its generating functions or what fails.

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
    return _printed(answer, options)


def _domains(texts: list[str], source: str) -> dict[str, str]:
    """Names with their domains; any real number where none is written."""
    pairs = [_pair(text, source) if ":" in text else (text.strip(), "line") for text in texts]
    if twice := [name for name, _ in pairs if [n for n, _ in pairs].count(name) > 1]:
        raise InvalidInputError(f"{source}: {twice[0]} is given twice")
    return dict(pairs)


def _pair(text: str, source: str, example: str = "q: p") -> tuple[str, str]:
    name, colon, rest = (part.strip() for part in text.partition(":"))
    if not (name and colon and rest):
        raise InvalidInputError(f'{source} {text}: write two parts with a colon between them, such as "{example}"')
    return name, rest


def _equation(text: str, source: str, example: str = "Q = sqrt(2*q)*cos(p)") -> tuple[str, str]:
    name, equals, formula = (part.strip() for part in text.partition("="))
    if not (name and equals and formula):
        raise InvalidInputError(f'{source}: "{text[:60]}" is not an equation; write "{example}"')
    return name, formula


def _printed(
    answer: CompleteIntegral | CanonicalMap | Flaw | Undecided, options: Namespace,
    along: OwnMotion | Undecided | None = None,
) -> int:  # fmt: skip
    """Print the answer; the exit status."""
    status = {"Flaw": 1, "Undecided": 3}.get(type(answer).__name__, 0)
    if options.json:
        _json({"answer": answer, **({} if along is None else {"along": along})})
        return status
    from hjsolve.reports.formats.text import section_text, wrapped
    from hjsolve.reports.sections.theorem import own_motion_section, theorem_answer, theorem_section

    print(wrapped(theorem_answer(answer)))
    print(f"\n{section_text(theorem_section(answer))}")
    if along is not None:
        print(f"\n{section_text(own_motion_section(along))}")
    return status


def _sections(section: Section) -> int:
    from hjsolve.reports.formats.text import section_text

    print(section_text(section))
    return 0


def _json(answer: object) -> int:
    from hjsolve.command_line.answers_as_json import print_answer

    print_answer(answer)
    return 0
