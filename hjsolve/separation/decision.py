"""separate(): from a system to a verdict with its evidence."""

from __future__ import annotations

import time
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.algebra.modular import Filter
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import HYPERBOLIC, is_shifted
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.energy_shell import Irreducible, ReductionStep, Shell, reduce
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.precision import one_at_a_time
from hjsolve.separation import relativistic
from hjsolve.separation.constants.constants import constants_of
from hjsolve.separation.forms import levi_civita, liouville, stackel
from hjsolve.separation.obstruction import advice
from hjsolve.separation.obstruction.diagnose import diagnosed
from hjsolve.separation.obstruction.obstruction import (
    Setting,
    of_shell,
    refuse_condition,
    refuse_time,
    refuse_without_shell,
    region_of,
)
from hjsolve.separation.verdicts import Liouville, Obstruction, Reduced, Separation, Stackel, Undecided, Verdict

DEFAULT_BUDGET = 20.0
SMALL_SYSTEM = 120


@arguments.with_known_names("separate(system, budget=20)")
@one_at_a_time
def separate(system: System | str | Path, *, budget: float = DEFAULT_BUDGET) -> Verdict:
    """Decide whether the Hamilton–Jacobi equation of a system separates in its coordinates.

    The system is reduced to its energy shell, Levi-Civita's conditions are decided exactly, one by one, and the Stäckel
    matrix is constructed and verified. Parameters stay symbolic: a verdict holds for all values that their assumptions
    allow.

    Args:
        system: the system, as the user wrote it; or the id or file of a catalog entry.
        budget: seconds after which undecided conditions are left undecided.

    Returns:
        ``Separation``, ``Obstruction`` (proved not to separate, with a witness) or ``Undecided``.

    Raises:
        InvalidInputError: not a system, or a negative budget; or T or V divides by what is zero everywhere. What
            cannot be decided is a verdict, no error.

    Example:
        >>> print(separate("kepler-planar"))
        Separates in r and theta: it is of Liouville form, and theta is ignorable.
        >>> separate("henon-heiles").residual
        2*lambda_*x
    """
    system = system_of(system, "separate")
    budget = arguments.seconds(budget, "budget")
    if system.time is not None:
        return refuse_time(system, budget)
    if system.relativity is not None:
        return relativistic.decided(system, lambda shell: separate(shell, budget=budget))
    start = time.monotonic()
    work = Budget.seconds(budget)
    shell: Shell | None = None
    try:
        reduced = reduce(system, work)
        if isinstance(reduced, Irreducible):
            return refuse_without_shell(system, reduced, work)
        shell = reduced
        return _of_one_coordinate(_decide(*_constructed(shell, work), start))
    except WorkLimitError as fault:
        steps = (*(shell.steps if shell else ()), ReductionStep("Budget", f"Exact arithmetic stopped: {fault}."))
        return Undecided(system, shell, (), "reduction", sp.nan, {}, None, advice.for_undecided(), steps)


def _of_one_coordinate(verdict: Verdict) -> Verdict:
    """Return a verdict, once a kink of V in one coordinate leaves the separated equations of the others as they are.

    Raises:
        InvalidSystemError: V separates on both sides of a jump, but with other constants.
    """
    if not isinstance(verdict, Separation) or not verdict.system.kinks or verdict.reduced.stackel is None:
        return verdict
    matrix, column = verdict.reduced.stackel.matrix, verdict.reduced.stackel.column
    for kink in verdict.system.kinks:
        for i, c in enumerate(verdict.shell.coordinates):
            if c.name != kink.coordinate and any(e.has(kink.symbol) for e in (*matrix.row(i), column[i])):
                raise InvalidSystemError(
                    f"potential: where {kink.argument} changes its sign V jumps by a function of {c.name}; on either "
                    f"side the system separates, across it does not. Give {kink.coordinate} a domain that ends there"
                )
    return verdict


def _constructed(shell: Shell, work: Budget) -> tuple[Setting, stackel.Matrix | None]:
    """Read a shell and construct the Stäckel matrix; None where there is none, or no coordinate it would be of.

    Steep functions of shifted places, tanh(1000 x - 300), are kept whole where that is possible: multiplied out by
    addition theorems they could not be worked out in numbers.
    """
    held = {c.symbol for c in shell.coordinates}
    steep = [f for e in (*shell.inverse_metric, shell.potential) for f in e.atoms(*HYPERBOLIC, sp.exp)]
    for whole in (True, False) if any(is_shifted(f.args[0], held) for f in steep) else (False,):
        setting = of_shell(shell, work, whole=whole)
        matrix = None
        if setting.symbols:
            matrix = stackel.construct(setting.reader, setting.symbols, setting.metric, setting.potential)
        if matrix is not None:
            break
    return setting, matrix


def _decide(setting: Setting, matrix: stackel.Matrix | None, start: float) -> Verdict:
    shell, reader = setting.shell, setting.reader
    proved = list[ReductionStep]()
    if setting.symbols:
        if matrix is None or _small(setting):
            failed, proved = _conditions(setting, hunting=matrix is None)
            if failed is not None:
                return failed
        if matrix is None:
            text = "Levi-Civita's conditions hold, but no regular base point for the Stäckel matrix was found."
            steps = (*shell.steps, *proved, ReductionStep("Stäckel matrix", text))
            words = advice.for_undecided()
            return Undecided(shell.system, shell, (), "metric", sp.nan, {}, None, words, steps)
    reduced = _reduced_forms(setting, matrix)
    full_liouville, full_stackel = _full_forms(setting, reduced)
    evidence = (*shell.steps, *proved, *_evidence_of(reduced, shell))
    constants = constants_of(shell, reader, matrix)
    ignorable = tuple(c.name for c in shell.ignorable)
    seconds = time.monotonic() - start
    return Separation(
        shell.system, shell, ignorable, constants, full_liouville, full_stackel, reduced, evidence, seconds
    )


def _small(setting: Setting) -> bool:
    """Return whether Levi-Civita's conditions are worth a second, independent proof next to Stäckel's certificate."""
    elements = [*setting.metric, setting.potential]
    return sum(len(x.numerator) + sum(len(base) for base, _ in x.bases) for x in elements) <= SMALL_SYSTEM


def _conditions(setting: Setting, *, hunting: bool) -> tuple[Obstruction | Undecided | None, list[ReductionStep]]:
    """Return the first condition proved to fail, else the first that stays open, else the step that says all hold.

    Hunting: Stäckel's certificate has failed, so some condition fails; those that pass the filter are not proved first.
    """
    if len(setting.symbols) < 2:
        return None, []
    count = 0
    undecided: Undecided | None = None
    sieve = Filter(setting.reader.field)
    conditions = levi_civita.LeviCivitaConditions(setting.reader, setting.symbols, setting.metric, setting.potential)
    for condition in conditions:
        count += 1
        if hunting and condition.passes_filter:
            continue
        if conditions.holds(condition, sieve):
            continue
        found = refuse_condition(setting, condition)
        if isinstance(found, Obstruction):
            return diagnosed(found, setting, conditions), []
        undecided = undecided or found
    if hunting and undecided is None:
        return None, []
    text = (
        f"All {count} conditions S_ij(g^hh) = 0 and S_ij(V) = 0 hold identically, coefficient by coefficient in the "
        "constant momenta; each was brought to an exact normal form that is zero."
    )
    return undecided, [ReductionStep("Levi-Civita's conditions", text)]


def _reduced_forms(setting: Setting, matrix: stackel.Matrix | None) -> Reduced:
    """Stäckel and Liouville forms of the shell; with one coordinate f = 1, R = g, v = V.

    A shell that holds a momentum to first degree is not of Liouville form.
    """
    if matrix is None:
        return Reduced(None, None)
    shell, names = setting.shell, [c.name for c in setting.shell.coordinates]
    form = stackel.finished(setting.reader, names, shell.inverse_metric, shell.potential, matrix)
    if shell.null:
        return Reduced(None, form)
    if len(names) == 1:
        return Reduced(Liouville(tuple(names), (sp.S.One,), shell.inverse_metric, (shell.potential,)), form)
    functions = liouville.recognise(
        setting.reader, names, setting.symbols, setting.metric, setting.potential, setting.region
    )
    return Reduced(functions, form)


def _full_forms(setting: Setting, reduced: Reduced) -> tuple[Liouville | None, Stackel | None]:
    """Liouville and Stäckel forms over all coordinates; None where T is not diagonal or has linear terms."""
    shell, reader = setting.shell, setting.reader
    system = shell.system
    if any(linear_terms(system)):
        return None, None
    if not shell.ignorable:
        return reduced.liouville, reduced.stackel
    mass, n = mass_matrix(system), len(system.coordinates)
    if any(not reader.element(mass[i, j]).is_zero for i in range(n) for j in range(i)):
        return None, None
    metric = [reader.element(mass[i, i]) ** -1 for i in range(n)]
    V = system.potential - kinetic_rest(system)
    potential = reader.element(V)
    symbols, names = [c.symbol for c in system.coordinates], [c.name for c in system.coordinates]
    functions = liouville.recognise(reader, names, symbols, metric, potential, setting.region)
    matrix = stackel.construct(reader, symbols, metric, potential)
    if matrix is None:
        return functions, None
    return functions, stackel.finished(reader, names, [shortest_form(reader, g) for g in metric], V, matrix)


def _evidence_of(reduced: Reduced, shell: Shell) -> list[ReductionStep]:
    """Return the forms found, as steps."""
    steps = []
    V = "V_eff" if shell.ignorable else "V"
    if reduced.stackel is not None:
        text = (
            "It is read off from the shell along the coordinate lines through one base point. Row i depends "
            f"on coordinate i only. Exact substitution verified c^T Phi = (1, 0, ..., 0) and c^T psi = {V}."
        )
        steps.append(ReductionStep("Stäckel matrix", text, reduced.stackel.matrix))
        text = "The part of the separated equations without separation constants."
        steps.append(ReductionStep("Stäckel column", text, sp.Tuple(*reduced.stackel.column)))
    if reduced.liouville is not None:
        form = reduced.liouville
        text = "The shell is of Liouville form: T = sum(R_i p_i^2)/(2 sum f_i), V = sum(v_i)/sum(f_i)"
        text += ", where V is the effective potential." if shell.ignorable else "."
        steps.append(
            ReductionStep("Liouville form", text, sp.Tuple(sp.Tuple(*form.f), sp.Tuple(*form.R), sp.Tuple(*form.v)))
        )
    if not shell.coordinates:
        text = "Every momentum is constant and H is a function of them: the motion is uniform."
        steps.append(ReductionStep("All coordinates ignorable", text, shell.potential))
    return steps


__all__ = ["DEFAULT_BUDGET", "region_of", "separate"]
