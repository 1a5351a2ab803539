"""separate(): from a system to a verdict with its evidence."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..algebra.field import Element
from ..algebra.poly import Budget, WorkLimitError
from ..algebra.readable import readable
from ..algebra.reader import Reader
from ..shell import Irreducible, Shell, Step, domain_bounds, reduce
from ..system import System, hamiltonian, kinetic_rest, linear_terms, mass_matrix
from . import advice, levi_civita, liouville, stackel
from .constants import constants_of
from .enclosure import Region
from .verdicts import Liouville, Obstruction, Reduced, Separation, Stackel, Undecided, Verdict
from .zero_test import NonZero, Unproved, element_is_zero

DEFAULT_BUDGET = 20.0


@dataclass(frozen=True)
class _Open:
    """A condition that was neither proved nor refuted."""

    pair: tuple[str, str]
    part: str
    residual: sp.Expr
    answer: Unproved


def separate(system: System, *, budget: float = DEFAULT_BUDGET) -> Verdict:
    """Decide whether the Hamilton–Jacobi equation of a system separates in its coordinates.

    The system is reduced to its energy shell, Levi-Civita's conditions are decided exactly, one by one, and Stäckel's matrix
    is constructed and verified. Parameters stay symbolic: a verdict holds for all values that their assumptions allow.

    Args:
        system: the system, as the user wrote it.
        budget: seconds after which undecided conditions are left undecided.

    Returns:
        ``Separation``, ``Obstruction`` (proved not to separate, with a witness) or ``Undecided``.
    """
    start = time.monotonic()
    work = Budget.seconds(budget)
    try:
        shell = reduce(system, work)
        if isinstance(shell, Irreducible):
            return _without_shell(system, shell, work)
        return _of_shell(shell, work, start)
    except WorkLimitError as fault:
        steps = (Step("Budget", str(fault)),)
        return Undecided(system, None, (), "reduction", sp.nan, {}, None, advice.for_undecided(), steps)


def region_of(system: System) -> Region:
    """Domain of the coordinates, default values of the parameters."""
    return Region(domain_bounds(system), dict(system.defaults))


# ---------------------------------------------------------------------------------------------------------- with a shell


def _of_shell(shell: Shell, work: Budget, start: float) -> Verdict:
    system, region = shell.system, region_of(shell.system)
    symbols = [c.symbol for c in shell.coordinates]
    reader = Reader([*shell.inverse_metric, shell.potential, *shell.shift], domain_bounds(system), work)
    metric = [reader.element(g) for g in shell.inverse_metric]
    potential = reader.element(shell.potential)
    evidence = list(shell.steps)
    if len(symbols) > 1:
        failed = _first_failure(shell, reader, symbols, metric, potential, region, evidence)
        if failed is not None:
            return failed
    matrix = stackel.construct(reader, symbols, metric, potential) if symbols else None
    if symbols and matrix is None:
        text = "Levi-Civita's conditions hold, but no regular base point for Stäckel's matrix was found."
        steps = (*evidence, Step("Stäckel's matrix", text))
        return Undecided(system, shell, (), "metric", sp.nan, {}, None, advice.for_undecided(), steps)
    names = [c.name for c in shell.coordinates]
    form = None if matrix is None else stackel.finished(reader, names, shell.inverse_metric, matrix)
    reduced = Reduced(liouville.recognise(reader, names, symbols, metric, potential, region) if symbols else None, form)
    evidence += _evidence_of(reduced, shell)
    full_liouville, full_stackel = _full_forms(shell, reduced, reader, region)
    constants = constants_of(shell, reader, matrix)
    ignorable = tuple(c.name for c in shell.ignorable)
    seconds = time.monotonic() - start
    return Separation(
        system, shell, ignorable, constants, full_liouville, full_stackel, reduced, tuple(evidence), seconds
    )


def _first_failure(
    shell: Shell,
    reader: Reader,
    symbols: Sequence[sp.Symbol],
    metric: Sequence[Element],
    potential: Element,
    region: Region,
    evidence: list[Step],
) -> Obstruction | Undecided | None:
    """The first condition that is proved to fail; else the first that stays open; else None, with the evidence added."""
    count, undecided = 0, None
    for condition in levi_civita.Conditions(reader, symbols, metric, potential):
        count += 1
        if levi_civita.vanishes(reader, condition.products):
            continue
        pair = shell.coordinates[condition.i].name, shell.coordinates[condition.j].name
        found = _judge(shell, reader, condition, region)
        if isinstance(found, tuple):
            residual, answer = found
            words = (
                advice.for_metric(shell.system, pair, coupled=False)
                if condition.part == "metric"
                else advice.for_potential(shell.system, pair)
            )
            step = _failure_step(condition, pair, residual, shell)
            return Obstruction(
                shell.system, shell, pair, condition.part, residual, answer.witness, words, (*evidence, step)
            )
        undecided = undecided or _Open(pair, condition.part, found[0] if isinstance(found, list) else sp.nan, found[1])
    if undecided is not None:
        a, words = undecided.answer, advice.for_undecided()
        step = Step("Levi-Civita's conditions", f"One condition could not be decided: {a.reason}.", undecided.residual)
        return Undecided(
            shell.system, shell, undecided.pair, undecided.part, undecided.residual, a.point, a.value, words, (*evidence, step)
        )
    text = (
        f"All {count} conditions S_ij(g^hh) = 0 and S_ij(V) = 0 hold identically, coefficient by coefficient in the constant "
        "momenta; each was brought to an exact normal form that is zero."
    )
    evidence.append(Step("Levi-Civita's conditions", text))
    return None


def _judge(
    shell: Shell, reader: Reader, condition: levi_civita.Condition, region: Region
) -> tuple[sp.Expr, NonZero] | list[object]:
    """Find the simplest coefficient of a condition that is proved not to vanish."""
    whole = reader.field.cancelled(levi_civita.total(reader, condition.products) * condition.scale)
    constants = [c.momentum for c in shell.ignorable]
    unproved: list[object] = []
    for part in levi_civita.coefficients(reader, whole, constants):
        answer = element_is_zero(reader, part, region)
        if isinstance(answer, NonZero):
            return readable(reader, part), answer
        if isinstance(answer, Unproved) and not unproved:
            unproved = [readable(reader, part), answer]
    return unproved


def _failure_step(condition: levi_civita.Condition, pair: tuple[str, str], residual: sp.Expr, shell: Shell) -> Step:
    i, j = pair
    if condition.part == "metric":
        about = shell.coordinates[condition.about or 0].name
        text = (
            f"For the pair {i}, {j} the kinetic energy fails: S_ij of the inverse metric coefficient of {about} is the expression "
            "shown; it would have to vanish identically, and is proved not to at the witness."
        )
    else:
        text = (
            f"The kinetic energy passes. For the pair {i}, {j} the potential fails: S_ij(V) is the expression shown; it would have "
            "to vanish identically, and is proved not to at the witness."
        )
    return Step("Levi-Civita's conditions", text, residual)


def _evidence_of(reduced: Reduced, shell: Shell) -> list[Step]:
    steps = []
    if reduced.stackel is not None:
        text = (
            "Stäckel's matrix, from the base-point construction; c^T Phi = (1, 0, ..., 0) and c^T psi = V were verified by "
            "substitution, exactly. Row i holds coordinate i only."
        )
        steps.append(Step("Stäckel's matrix", text, reduced.stackel.matrix))
        steps.append(Step("Stäckel's column", "The part of the separated equations without constants.", sp.Tuple(*reduced.stackel.column)))
    if reduced.liouville is not None:
        text = "The shell is of Liouville's form: T = sum(R_i p_i^2)/(2 sum f_i), V = sum(v_i)/sum(f_i), with f, R, v as shown."
        form = reduced.liouville
        steps.append(Step("Liouville's form", text, sp.Tuple(sp.Tuple(*form.f), sp.Tuple(*form.R), sp.Tuple(*form.v))))
    if not shell.coordinates:
        steps.append(Step("All coordinates ignorable", "Every momentum is constant; H is a function of them.", shell.potential))
    return steps


# ------------------------------------------------------------------------------------------------------- the full system


def _full_forms(
    shell: Shell, reduced: Reduced, reader: Reader, region: Region
) -> tuple[Liouville | None, Stackel | None]:
    """Liouville's and Stäckel's forms over all coordinates; None where T is not diagonal or has linear terms."""
    if not shell.ignorable:
        linear = any(shell.shift)
        return (None, None) if linear else (reduced.liouville, reduced.stackel)
    system = shell.system
    mass = mass_matrix(system)
    n = len(system.coordinates)
    if any(linear_terms(system)):
        return None, None
    if any(not reader.element(mass[i, j]).is_zero for i in range(n) for j in range(i)):
        return None, None
    metric = [reader.element(mass[i, i]) ** -1 for i in range(n)]
    potential = reader.element(system.potential - kinetic_rest(system))
    symbols, names = [c.symbol for c in system.coordinates], [c.name for c in system.coordinates]
    form = liouville.recognise(reader, names, symbols, metric, potential, region)
    matrix = stackel.construct(reader, symbols, metric, potential)
    written = [readable(reader, g) for g in metric]
    return form, None if matrix is None else stackel.finished(reader, names, written, matrix)


# --------------------------------------------------------------------------------------------------------- without a shell


def _without_shell(system: System, found: Irreducible, work: Budget) -> Obstruction | Undecided:
    """Levi-Civita's general condition for coordinates that T couples or that linear terms couple."""
    H, region = hamiltonian(system), region_of(system)
    reader = Reader([H, found.residual], domain_bounds(system), work)
    h = reader.element(H)
    q, p = [c.symbol for c in found.essential], [c.momentum for c in found.essential]
    constants = [c.momentum for c in system.coordinates]
    names = [c.name for c in found.essential]
    pairs = sorted(
        ((i, j) for j in range(len(q)) for i in range(j)), key=lambda ij: {names[ij[0]], names[ij[1]]} != set(found.pair)
    )
    for i, j in pairs:
        products = levi_civita.general_condition(reader, h, q, p, i, j)
        if levi_civita.vanishes(reader, products):
            continue
        for part in levi_civita.coefficients(reader, levi_civita.total(reader, products), constants):
            answer = element_is_zero(reader, part, region)
            if isinstance(answer, NonZero):
                return _general_obstruction(system, found, (names[i], names[j]), readable(reader, part), answer, region)
    text = "Levi-Civita's general condition is not refuted although the coordinates are coupled."
    answer = Unproved({}, None, text)
    steps = (*found.steps, Step("Levi-Civita's general condition", text, found.residual))
    words = "Replace an essential coordinate by a combination that decouples T or the linear terms. " + advice.for_undecided()
    return Undecided(system, None, found.pair, found.reason, found.residual, answer.point, answer.value, words, steps)


def _general_obstruction(
    system: System, found: Irreducible, pair: tuple[str, str], residual: sp.Expr, answer: NonZero, region: Region
) -> Obstruction:
    coupling = (
        f"T couples {found.pair[0]} and {found.pair[1]} (mass-matrix entry shown)"
        if found.reason == "metric"
        else f"the terms linear in the velocities of {found.pair[0]} and {found.pair[1]} are no gradient (their curl is shown)"
    )
    steps = (
        *found.steps,
        Step("Coupling", f"After the reduction {coupling}, so there is no orthogonal energy shell.", found.residual),
        Step(
            "Levi-Civita's general condition",
            f"For the pair {pair[0]}, {pair[1]} a coefficient of L_ij in the momenta is the expression shown; it would have to "
            "vanish identically, and is proved not to at the witness.",
            residual,
        ),
    )
    words = (
        advice.for_metric(system, found.pair, coupled=True)
        if found.reason == "metric"
        else advice.for_gyroscopic(found.pair)
    )
    return Obstruction(system, None, pair, found.reason, residual, answer.witness, words, steps)
