"""Refusals: which pair, which part, what does not vanish, where it is proved not to, and what to try."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import sympy as sp

from hjsolve.algebra.element_jets import ElementJet, ElementJets
from hjsolve.algebra.element_point import Value
from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter, Products
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.errors import required
from hjsolve.mechanics.energy_shell import Irreducible, ReductionStep, Shell, domain_bounds
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.forms.levi_civita import Condition
from hjsolve.separation.obstruction import advice
from hjsolve.separation.verdicts import Obstruction, Undecided
from hjsolve.separation.zero_test.interval_elements import find_witness_by_jets
from hjsolve.separation.zero_test.interval_evaluation import UNKNOWNS, Region, Witness
from hjsolve.separation.zero_test.zero_test import NonZero, Unproved, is_zero, not_zero

EXPANSION_SECONDS, EXPANSION_TERMS = 0.2, 20_000
LARGE = 120


@dataclass(frozen=True)
class Setting:
    """A shell as elements of its field.

    Attributes:
        shell: the shell.
        region: domain of the coordinates and first values for parameters.
        reader: reads and differentiates.
        symbols: essential coordinates.
        metric: inverse metric.
        potential: V_eff.
    """

    shell: Shell
    region: Region
    reader: Reader
    symbols: list[sp.Symbol]
    metric: list[Element]
    potential: Element


def region_of(system: System) -> Region:
    """Domain of the coordinates, default values of the parameters.

    Args:
        system: whose domains and default values are meant.
    """
    return Region(domain_bounds(system.coordinates), dict(system.defaults))


def of_shell(shell: Shell, work: Budget, *, whole: bool = False) -> Setting:
    """Read a shell into a field; ``whole`` as in ``Reader``.

    Args:
        shell: what is read.
        work: budget of the exact computation.
        whole: as in ``Reader``.
    """
    parts = [*shell.inverse_metric, shell.potential, *shell.shift]
    reader = Reader(parts, domain_bounds(shell.system.coordinates), work, whole=whole)
    metric = [reader.element(g) for g in shell.inverse_metric]
    symbols = [c.symbol for c in shell.coordinates]
    return Setting(shell, region_of(shell.system), reader, symbols, metric, reader.element(shell.potential))


def refuse_condition(setting: Setting, condition: Condition) -> Obstruction | Undecided:
    """Verdict on a condition that was not proved to hold.

    Args:
        setting: the shell in its field.
        condition: Levi-Civita's, of the metric or of the potential.
    """
    shell = setting.shell
    pair = shell.coordinates[condition.i].name, shell.coordinates[condition.j].name
    constants = [c.momentum for c in shell.ignorable]
    residual, answer = _failing(
        setting.reader,
        lambda: [[*factors, [condition.scale]] for factors in condition.products],
        constants,
        partial(_written_out, setting, condition),
        partial(_enclosed, setting, condition),
        setting.region,
    )
    if isinstance(answer, NonZero):
        words = advice.for_potential(shell.system, pair)
        if condition.part == "metric":
            words = advice.for_metric(shell.system, pair, coupled=False)
        steps = (*shell.steps, _failure_step(condition, pair, residual, shell))
        return Obstruction(shell.system, shell, pair, condition.part, residual, answer.witness, words, steps)
    step = ReductionStep("Levi-Civita's conditions", f"One condition could not be decided: {answer.reason}.", residual)
    return Undecided(
        shell.system,
        shell,
        pair,
        condition.part,
        residual,
        answer.point,
        answer.value,
        advice.for_undecided(),
        (*shell.steps, step),
    )


def _written_out(setting: Setting, condition: Condition) -> sp.Expr:
    """S_ij(f) from the expressions of the shell, nothing simplified and large derivatives not carried out."""
    i, j = condition.i, condition.j
    shell, x, y = setting.shell, setting.symbols[i], setting.symbols[j]
    gi, gj = shell.inverse_metric[i], shell.inverse_metric[j]
    f = shell.potential if condition.about is None else shell.inverse_metric[condition.about]
    return _d(f, x, y) - _d(gj, x) / gj * _d(f, y) - _d(gi, y) / gi * _d(f, x)


def _enclosed(setting: Setting, condition: Condition) -> Witness | None:
    """Return a witness of S_ij(f) by jets of the elements of the shell."""
    i, j, metric = condition.i, condition.j, setting.metric

    def value(jets: ElementJets, parts: Sequence[ElementJet]) -> Value:
        f, gi, gj = parts
        return levi_civita.condition_of_jets(f, jets.logarithm(gi), jets.logarithm(gj), 0, 1)

    f = setting.potential if condition.about is None else metric[condition.about]
    symbols = setting.symbols[i], setting.symbols[j]
    return find_witness_by_jets(setting.reader, symbols, [f, metric[i], metric[j]], value, setting.region)


def _d(f: sp.Expr, *symbols: sp.Symbol) -> sp.Expr:
    """Return a derivative; left as it stands where f is large."""
    if not f.free_symbols.issuperset(symbols):
        return sp.S.Zero
    if f.has(*UNKNOWNS) or sum(1 for _ in islice(sp.preorder_traversal(f), LARGE)) < LARGE:
        return f.diff(*symbols)
    return sp.Derivative(f, *symbols, evaluate=False)


def _failing(
    reader: Reader,
    products: Callable[[], Products],
    constants: list[sp.Symbol],
    written_out: Callable[[], sp.Expr],
    enclosed: Callable[[], Witness | None],
    region: Region,
) -> tuple[sp.Expr, NonZero | Unproved]:
    """Return what does not vanish, with the proof: the simplest coefficient of a sum of products in the constants.

    Where it is too much to multiply out, the whole as written out, enclosed by jets.
    """
    field = reader.field
    whole_budget = field.budget
    field.budget = whole_budget.part(EXPANSION_SECONDS, EXPANSION_TERMS)
    try:
        whole = field.cancelled(levi_civita.sum_of_products(reader, products()))
        parts = levi_civita.coefficients(reader, whole, constants)
    except WorkLimitError:
        parts = []
    finally:
        field.budget = whole_budget
    if parts:
        return _simplest_nonzero((shortest_form(reader, part) for part in parts), region, whole_budget)
    residual = written_out()
    if (witness := enclosed()) is not None:
        return residual, NonZero(witness)
    return residual, not_zero(residual.doit(), region, whole_budget, "no witness was found")


def _simplest_nonzero(parts: Iterable[sp.Expr], region: Region, budget: Budget) -> tuple[sp.Expr, NonZero | Unproved]:
    """Return the first expression proved not to vanish, else the first of all with what is known about it."""
    open_case: tuple[sp.Expr, Unproved] | None = None
    for part in parts:
        answer = not_zero(part, region, budget, "no witness was found")
        if isinstance(answer, NonZero):
            return part, answer
        open_case = open_case or (part, answer)
    return required(open_case)


def _failure_step(condition: Condition, pair: tuple[str, str], residual: sp.Expr, shell: Shell) -> ReductionStep:
    proof = "The expression shown would have to vanish identically; it is proved to be non-zero at the counterexample."
    names = " and ".join(pair)
    if condition.part == "metric":
        about = shell.coordinates[condition.about or 0].name
        text = f"The kinetic energy violates that of {names}: S_ij of the inverse metric of {about}. {proof}"
    else:
        text = f"The kinetic energy satisfies them. The potential violates that of {names}: S_ij(V). {proof}"
    return ReductionStep("Levi-Civita's conditions", text, residual)


# ------------------------------------------------------------------------------------------------ without a shell


def refuse_time(system: System, seconds: float) -> Obstruction | Undecided:
    """Refuse a system whose H holds the time: H = E does not hold then, W does not exist.

    Args:
        system: with the time in T or V.
        seconds: for the proof that ∂H/∂t is not zero.
    """
    rate = sp.diff(hamiltonian(system), required(system.time))
    held = [c.name for c in system.coordinates if rate.has(c.symbol)] or [system.coordinates[0].name]
    pair = (held[0], held[0])
    answer = is_zero(rate, region_of(system), budget=seconds)
    text = "H holds the time, so that it is not a constant of the motion (4-95): its derivative by t is shown."
    steps = (ReductionStep("Explicit time", text, rate),)
    words = advice.for_explicit_time()
    if isinstance(answer, NonZero):
        return Obstruction(system, None, pair, "time", rate, answer.witness, words, steps)
    point, value = getattr(answer, "point", {}), getattr(answer, "value", None)
    return Undecided(system, None, pair, "time", rate, point, value, words, steps)


def refuse_without_shell(system: System, found: Irreducible, work: Budget) -> Obstruction | Undecided:
    """Levi-Civita's general condition for coordinates that T couples, or that linear terms couple.

    Args:
        found: the coordinates that stay coupled.
        work: budget of the exact computation.
    """
    H, region = hamiltonian(system), region_of(system)
    reader = Reader([H, found.residual], domain_bounds(system.coordinates), work)
    sieve = Filter(reader.field)
    h = reader.element(H)
    q, p = [c.symbol for c in found.essential], [c.momentum for c in found.essential]
    constants = [c.momentum for c in system.coordinates]
    names = [c.name for c in found.essential]
    pairs = [(i, j) for j in range(len(q)) for i in range(j)]
    for i, j in sorted(pairs, key=lambda ij: {names[ij[0]], names[ij[1]]} != set(found.pair)):
        products = levi_civita.general_condition(reader, h, q, p, i, j)
        if levi_civita.sum_vanishes(reader, products, sieve):
            continue
        residual, answer = _failing(
            reader,
            partial(list, products),
            constants,
            partial(_general_written_out, H, q, p, i, j),
            partial(find_witness_by_jets, reader, [q[i], q[j], p[i], p[j]], [h], _general_value, region),
            region,
        )
        if isinstance(answer, NonZero):
            return _general_obstruction(system, found, (names[i], names[j]), residual, answer)
        return _general_undecided(system, found, residual, answer, f"it could not be decided: {answer.reason}")
    text = "it holds, so the system may separate after a change of coordinates that decouples T"
    return _general_undecided(system, found, found.residual, Unproved({}, None, text), text)


def _general_value(_jets: ElementJets, parts: Sequence[ElementJet]) -> Value:
    return levi_civita.general_condition_of_jets(parts[0])


def _general_written_out(H: sp.Expr, q: list[sp.Symbol], p: list[sp.Symbol], i: int, j: int) -> sp.Expr:
    """L_ij from the expression of H, nothing simplified."""
    a, b, c, d = H.diff(p[i]), H.diff(p[j]), H.diff(q[i]), H.diff(q[j])
    return a * b * c.diff(q[j]) + c * d * a.diff(p[j]) - a * d * c.diff(p[j]) - c * b * d.diff(p[i])


def _general_undecided(system: System, found: Irreducible, residual: sp.Expr, answer: Unproved, text: str) -> Undecided:
    steps = (*found.steps, ReductionStep("Levi-Civita's general condition", f"{text[0].upper()}{text[1:]}.", residual))
    words = "Replace one of the coordinates by a combination that decouples T or the linear terms. "
    words += advice.for_undecided()
    return Undecided(system, None, found.pair, found.reason, residual, answer.point, answer.value, words, steps)


def _general_obstruction(
    system: System, found: Irreducible, pair: tuple[str, str], residual: sp.Expr, answer: NonZero
) -> Obstruction:
    coupled = " and ".join(found.pair)
    coupling = f"the terms linear in the velocities of {coupled} are not a gradient (their curl is shown)"
    words = advice.for_gyroscopic(system, found.pair)
    if found.reason == "metric":
        coupling = f"T couples {coupled} (mass-matrix entry shown)"
        words = advice.for_metric(system, found.pair, coupled=True)
    text = (
        f"For {pair[0]} and {pair[1]} the expression shown, a coefficient of L_ij in the momenta, would have to "
        "vanish identically; it is proved to be non-zero at the counterexample."
    )
    steps = (
        *found.steps,
        ReductionStep(
            "Coupling", f"After the reduction {coupling}: there is no orthogonal energy shell.", found.residual
        ),
        ReductionStep("Levi-Civita's general condition", text, residual),
    )
    return Obstruction(system, None, pair, found.reason, residual, answer.witness, words, steps)
