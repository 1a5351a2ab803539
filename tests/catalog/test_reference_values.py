"""The published numbers: are they right (two other ways), and does hjsolve reach them?

The first half never touches ``hjsolve.motion``; the second half is hjsolve against the references at a relative 1e-13.
"""

from typing import Any

import mpmath
import pytest
import sympy as sp
from mpmath import mp
from sympy.core.cache import clear_cache

from hjsolve import catalog
from hjsolve.catalog import Reference
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import hamiltonian, momenta
from tests.reference.forms import THOROUGH, form
from tests.reference.regenerate import TAYLOR
from tests.reference.taylor import Flow
from tests.support.entries import described as entry
from tests.support.entries import motion as motion_of
from tests.support.entries import solution
from tests.support.entries import state as state_of
from tests.support.gauss import gauss

IDS = catalog.ids("separable")
MOTIONS = [(name, motion) for name in IDS for motion in entry(name).motions]
REFERENCES = [
    pytest.param(name, reference, id="-".join([name, reference.quantity, *(str(v) for v in reference.at.values())]))
    for name in IDS
    for reference in entry(name).references
]


def real(value: Any) -> mpmath.mpf:
    return mp.mpf(sp.N(value, mp.dps + 10))


def start(name: str, motion: str) -> tuple[dict[str, mpmath.mpf], dict[str, mpmath.mpf], dict[str, mpmath.mpf]]:
    """(parameters, q, p) of a catalog motion as numbers."""
    system, data = entry(name).system, entry(name).motions[motion]
    texts = {p.name: p.value for p in system.parameters} | {n: number(v, source=n) for n, v in data.parameters.items()}
    parameters = {n: real(v) for n, v in texts.items()}
    q = {c.name: real(number(data.q[c.name], source=c.name)) for c in system.coordinates}
    if data.velocity is None:
        assert data.p is not None
        return parameters, q, {c.name: real(number(data.p[c.name], source=c.name)) for c in system.coordinates}
    point = {system.symbols[n]: v for n, v in (parameters | q).items()}
    point |= {c.velocity: real(number(data.velocity[c.name], source=c.name)) for c in system.coordinates}
    p = {n: real(expression.xreplace(point)) for n, expression in momenta(system).items()}
    return parameters, q, p


def agree(value: mpmath.mpf, text: str, tolerance: str) -> bool:
    expected = mp.mpf(text)
    return bool(abs(value - expected) <= mp.mpf(tolerance) * abs(expected))


@pytest.mark.entries
@pytest.mark.nightly_cases(
    "a-frame-default", "henon-heiles-kdv-default", "kepler-prolate-default", "kerr-default",
    "kuzmin-kutuzov-default", "kuzmin-kutuzov-near-circular", "lagrange-top-turning-frame-default",
    "neumann-default", "oblate-geodesics-default", "perfect-oblate-spheroid-default",
    "triaxial-geodesics-default", "triaxial-geodesics-other-family", "two-centres-space-default",
)  # fmt: skip
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_the_closed_forms_give_the_published_values_again(name: str, motion: str) -> None:
    digits, tolerance = (60, "1e-38") if name in THOROUGH else (18, "1e-15")
    with mp.workdps(digits):
        values = form(name)(*start(name, motion))
        published = {r.quantity: r.value for r in entry(name).references if r.at == {"motion": motion}}
        assert set(values) == set(published)
        for quantity, (value, _) in values.items():
            assert agree(value, published[quantity], tolerance), quantity


def shell_at(name: str, motion: str) -> tuple[dict[str, sp.Expr], list[sp.Symbol], dict[sp.Symbol, mpmath.mpf]]:
    """hjsolve's own P² with numbers for the parameters; the separation constants; all numbers."""
    clear_cache()  # sympy would give cos(3.0) with the digits of the first time it was asked
    solved, (parameters, q, p) = solution(name), start(name, motion)
    system = solved.system
    point = {system.symbols[n]: v for n, v in (parameters | q).items()}
    point |= {c.momentum: p[c.name] for c in system.coordinates}
    values = {c.symbol: real(c.expression.xreplace(point)) for c in solved.constants.values()}
    fixed = {system.symbols[n]: v for n, v in parameters.items()}
    return {n: F.xreplace(fixed) for n, F in solved.momentum_squared.items()}, list(values), values


def cycle(F: sp.Expr, q: sp.Symbol, constant: sp.Symbol | None, numbers: Any, ends: Any) -> mpmath.mpf:
    """(1/2π)∮ p dq, or its derivative by a constant; Gauss–Legendre over χ, q = mid − half·cos χ."""
    kernel = sp.lambdify(q, F.xreplace(numbers), "mpmath")
    slope = sp.lambdify(q, F.diff(constant).xreplace(numbers) if constant is not None else 0, "mpmath")

    def integrand(x: mpmath.mpf) -> mpmath.mpf:
        root = mp.sqrt(abs(kernel(x)))
        return root if constant is None else slope(x) / (2 * root)

    if ends is None:
        return mp.quad(integrand, mp.linspace(-mp.pi, mp.pi, 5), method=gauss) / (2 * mp.pi)
    middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2

    def regular(χ: mpmath.mpf) -> mpmath.mpf:
        return integrand(middle - half * mp.cos(χ)) * half * mp.sin(χ)

    return mp.quad(regular, mp.linspace(0, mp.pi, 3), method=gauss) / mp.pi


@pytest.mark.entries
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_quadratures_of_the_separated_momenta_give_the_actions_and_frequencies(name: str, motion: str) -> None:
    """J by quadrature, Ω = ∂H/∂J by inverting the matrix ∂J/∂α of quadratures: no closed form, no ODE."""
    with mp.workdps(50):
        known = {r.quantity: r.value for r in entry(name).references if r.at == {"motion": motion}}
        kinds = entry(name).motions[motion].kinds
        if not set(kinds.values()) <= {"libration", "rotation", "ignorable"} or not solution(name).coordinates:
            return
        squares, constants, numbers = shell_at(name, motion)
        rows, signs = [], []
        for c in solution(name).system.coordinates:
            sign = 1 if kinds[c.name] != "rotation" else mp.sign(mp.mpf(known[f"action.{c.name}"]))
            signs.append(sign)
            if kinds[c.name] == "ignorable":
                rows.append([mp.mpf(1 if a == c.momentum else 0) for a in constants])
                continue
            ends = None
            if kinds[c.name] == "libration":
                ends = tuple(mp.mpf(known[f"turning_point.{c.name}.{end}"]) for end in ("lower", "upper"))
            J = cycle(squares[c.name], c.symbol, None, numbers, ends)
            assert agree(sign * J, known[f"action.{c.name}"], "1e-20"), c.name
            rows.append([sign * cycle(squares[c.name], c.symbol, a, numbers, ends) for a in constants])
        Ω = mp.matrix(rows) ** -1
        energy = constants.index(solution(name).separation.shell.energy)
        for place, c in enumerate(solution(name).system.coordinates):
            if kinds[c.name] == "ignorable" and c.domain.kind != "angle":
                continue
            assert agree(Ω[energy, place], known[f"frequency.{c.name}"], "1e-20"), c.name


@pytest.mark.entries
@pytest.mark.nightly_cases(
    "henon-heiles-kdv-default", "kepler-prolate-default", "kerr-default", "neumann-default",
    "perfect-oblate-spheroid-default", "schwarzschild-default", "two-centres-space-default",
)  # fmt: skip
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_the_equations_of_motion_of_our_own_hamiltonian_give_the_published_states(name: str, motion: str) -> None:
    """Taylor integration at 25 digits of hjsolve's own H; the published values derived theirs by sympy alone."""
    system = entry(name).system
    clear_cache()
    with mp.workdps(35):
        parameters, q, p = start(name, motion)
        fixed = {system.symbols[n]: v for n, v in parameters.items()}
        symbols = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
        flow = Flow(hamiltonian(system), *symbols, fixed, [*q.values(), *p.values()], digits=25)
        states = [r for r in entry(name).references if r.at.get("motion") == motion and r.how == TAYLOR]
        if not states:
            return
        t = min({str(r.at["t"]) for r in states}, key=lambda text: abs(mp.mpf(text)))
        reached = dict(zip([*(f"q.{n}" for n in q), *(f"p.{n}" for n in p)], flow.at(mp.mpf(t)), strict=True))
        for reference in states:
            if reference.at["t"] == t:
                error = reached[reference.quantity] - mp.mpf(reference.value)
                turns = mp.nint(error / (2 * mp.pi)) if reference.quantity.startswith("q.") else 0
                assert abs(error - 2 * mp.pi * turns) < 1e-18 * abs(mp.mpf(reference.value)), reference.quantity


def measured(name: str, reference: Reference) -> tuple[float, float]:
    """hjsolve's value and its error for one published quantity."""
    motion, (kind, coordinate, *end) = str(reference.at["motion"]), reference.quantity.split(".")
    if kind in ("q", "p", "velocity"):
        state = state_of(name, motion, str(reference.at["t"]))
        return float(getattr(state, kind)[coordinate]), float(getattr(state.error, kind)[coordinate])
    found = motion_of(name, motion)
    if kind == "turning_point":
        estimate = found.turning_points[coordinate][0 if end == ["lower"] else 1]
    else:
        tables = {"period": found.periods, "action": found.actions, "frequency": found.frequencies}
        estimate = tables[kind][coordinate]
    return float(estimate.value), float(estimate.error)


@pytest.mark.entries
@pytest.mark.parametrize(("name", "reference"), REFERENCES)
def test_hjsolve_reaches_the_published_value_to_1e13(name: str, reference: Reference) -> None:
    """Relative, atol = 0; no published value is zero. The reported error must cover the true one."""
    value, error = measured(name, reference)
    with mp.workdps(50):
        off = abs(mp.mpf(value) - mp.mpf(reference.value))
        assert off <= 1e-13 * abs(mp.mpf(reference.value))
        assert off <= mp.mpf(error), f"true error {mp.nstr(off, 3)} above the reported {error}"


@pytest.mark.entries
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_every_coordinate_moves_in_the_way_the_entry_says(name: str, motion: str) -> None:
    assert dict(motion_of(name, motion).kinds) == dict(entry(name).motions[motion].kinds)


@pytest.mark.entries
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_quantities_that_do_not_exist_have_no_key(name: str, motion: str) -> None:
    kinds, found = entry(name).motions[motion].kinds, motion_of(name, motion)
    published = {r.quantity for r in entry(name).references if r.at == {"motion": motion}}
    for coordinate, kind in kinds.items():
        assert (coordinate in found.periods) == (f"period.{coordinate}" in published), (coordinate, kind)
        assert (coordinate in found.frequencies) == (f"frequency.{coordinate}" in published), (coordinate, kind)
