"""Stäckel's theorem on every system, evaluated at 50 digits by sympy alone.

Away from the exact arithmetic of hjsolve.
"""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve.mechanics.system import System, hamiltonian, kinetic_rest
from hjsolve.separation import Obstruction, Separation, region_of, separate
from hjsolve.separation.verdicts import Stackel
from tests.support.separation_cases import E3, SEPARABLE, SEVERAL, SPHERICAL, SPHERICAL_COORDINATES, decided, kerr, make

TOLERANCE = sp.Float("1e-40", 50)


@pytest.fixture(scope="module")
def verdicts() -> dict[str, Separation]:
    return Verdicts()


class Verdicts(dict):
    """Made when they are asked for."""

    def __missing__(self, name: str) -> Separation:
        found = decided(name)
        assert isinstance(found, Separation), name
        return found


def points(system: System, *expressions: sp.Expr, count: int = 3):
    """Rational points of the domain that hold every symbol of the expressions."""
    everything = sp.Add(*(sp.Dummy() * x for x in expressions))
    for _, point in zip(range(count), region_of(system).points(everything, seed=3)):
        yield {s: v for s, v in point.items() if not isinstance(s, sp.Dummy)}


def at(expression: sp.Expr, point: dict) -> sp.Expr:
    return expression.evalf(50, subs=point)


def small(value: sp.Expr, size: sp.Expr = sp.S.One) -> bool:
    return abs(value) < TOLERANCE * (abs(size) + 1)


def obeys(form: Stackel, potential: sp.Expr, system: System) -> None:
    n = len(form.coordinates)
    for point in points(system, *form.inverse_metric, *form.matrix, *form.column, potential):
        c = [at(g, point) for g in form.inverse_metric]
        for j in range(n):
            terms = [c[i] * at(form.matrix[i, j], point) for i in range(n)]
            assert small(sum(terms) - int(j == 0), max(map(abs, terms)))
        terms = [c[i] * at(form.column[i], point) for i in range(n)]
        assert small(sum(terms) - at(potential, point), max(map(abs, terms)))


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_the_matrix_and_column_of_the_shell_fulfil_greenwood_5_139_and_5_140(name, verdicts):
    verdict = verdicts[name]
    obeys(verdict.reduced.stackel, verdict.shell.potential, verdict.system)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_the_matrix_of_the_full_system_fulfils_them_too(name, verdicts):
    verdict = verdicts[name]
    if verdict.stackel is not None:
        obeys(verdict.stackel, verdict.system.potential - kinetic_rest(verdict.system), verdict.system)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_row_i_depends_on_coordinate_i_only_and_no_separation_constant_enters(name, verdicts):
    verdict = verdicts[name]
    symbols = {c.name: c.symbol for c in verdict.system.coordinates}
    forbidden = {c.symbol for c in verdict.constants.values() if c.name == "E" or c.name.startswith("alpha")}
    for form in filter(None, (verdict.stackel, verdict.reduced.stackel)):
        for i, own in enumerate(form.coordinates):
            row = [*form.matrix.row(i), form.column[i]]
            others = {s for name, s in symbols.items() if name != own}
            assert not set().union(*(x.free_symbols for x in row)) & (others | forbidden)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_the_matrix_is_not_singular(name, verdicts):
    verdict = verdicts[name]
    for form in filter(None, (verdict.stackel, verdict.reduced.stackel)):
        (point,) = points(verdict.system, *form.matrix, count=1)
        values = [at(x, point) for x in form.matrix]
        assert abs(sp.Matrix(*form.matrix.shape, values).det()) > 1e-20


@pytest.mark.rotating(8)
@pytest.mark.parametrize("name", [*SEVERAL, *E3])
def test_the_constants_are_in_involution_with_each_other(name, verdicts):
    """(α_i, α_j) = 0 (Greenwood item 89), by Poisson brackets at 50 digits."""
    verdict = verdicts[name]
    constants = [c.expression for c in verdict.constants.values()]
    q = [c.symbol for c in verdict.system.coordinates]
    p = [c.momentum for c in verdict.system.coordinates]
    for point in points(verdict.system, *constants, count=2):
        slopes = [[[at(f.diff(s), point) for s in symbols] for symbols in (q, p)] for f in constants]
        for j, (fq, fp) in enumerate(slopes):
            for gq, gp in slopes[:j]:
                terms = [a * b for a, b in zip(fq, gp)] + [-a * b for a, b in zip(fp, gq)]
                assert small(sum(terms), max(map(abs, terms)))


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_the_first_constant_is_the_hamiltonian_and_the_separated_equations_hold(name, verdicts):
    """½P_i² = Σ Φ_ij α_j − ψ_i identically in q and p (Greenwood (5-142))."""
    verdict = verdicts[name]
    shell, form = verdict.shell, verdict.reduced.stackel
    names = [str(shell.energy), *(n for n in verdict.constants if n.startswith("alpha"))]
    values = [verdict.constants[n].expression for n in names]
    for point in points(verdict.system, values[0], count=2):
        assert small(at(values[0] - hamiltonian(verdict.system), point), at(values[0], point))
    for i, c in enumerate(shell.coordinates):
        right = [form.matrix[i, j] * values[j] for j in range(len(values))] + [-form.column[i]]
        left = (c.momentum + shell.shift[i]) ** 2 / 2
        for point in points(verdict.system, left, *right, count=2):
            terms = [at(x, point) for x in right]
            assert small(sum(terms) - at(left, point), max(map(abs, terms)))


def test_kepler_in_space_has_the_matrix_of_greenwood_5_168_with_linear_constants(verdicts):
    verdict = verdicts["Kepler, space"]
    m, k = (sp.Symbol(n, positive=True) for n in "mk")
    r, theta = verdict.system.coordinates[0].symbol, verdict.system.coordinates[1].symbol
    assert verdict.stackel.matrix == sp.ImmutableMatrix([[m, -1 / r**2, 0], [0, 1, -1 / sp.sin(theta) ** 2], [0, 0, 1]])
    assert verdict.stackel.column == (-k * m / r, 0, 0)


def test_the_general_spherical_potential_has_the_matrix_of_problem_5_8(verdicts):
    verdict = verdicts["P5-8"]
    r, theta, phi = (c.symbol for c in verdict.system.coordinates)
    m, k, a, b = (sp.Symbol(n, positive=True) for n in "mkab")
    assert verdict.stackel.matrix == sp.ImmutableMatrix([[m, -1 / r**2, 0], [0, 1, -1 / sp.sin(theta) ** 2], [0, 0, 1]])
    assert verdict.stackel.column == (-k * m / r, a * sp.cos(theta) ** 2, b * sp.cos(phi))


def test_decoupled_coordinates_get_a_constant_each(verdicts):
    verdict = verdicts["1 Cartesian"]
    m = sp.Symbol("m", positive=True)
    assert verdict.stackel.matrix == sp.ImmutableMatrix([[m, -1, -1], [0, 1, 0], [0, 0, 1]])
    assert [bool(x.free_symbols & {c.symbol}) for c, x in zip(verdict.system.coordinates, verdict.stackel.column)] == [
        True,
        True,
        True,
    ]


def test_ellipsoidal_coordinates_get_the_powers_of_each_coordinate(verdicts):
    verdict = verdicts["10 ellipsoidal"]
    u = verdict.system.coordinates[0].symbol
    row = verdict.stackel.matrix.row(0)
    assert [sp.cancel(x / row[1]).subs(sp.Symbol("m", positive=True), -4) for x in row] == [u**2, 1, u]


def test_a_potential_with_undetermined_functions_gives_the_matrix_of_problem_5_8():
    r, theta, phi, m = sp.symbols("r theta phi m")
    v1, v2, v3 = map(sp.Function, ("v1", "v2", "v3"))
    V = v1(r) / m + v2(theta) / (m * r**2) + v3(phi) / (m * r**2 * sp.sin(theta) ** 2)
    system = System(SPHERICAL_COORDINATES, SPHERICAL, V, {"m": 1})
    form = separate(system).stackel
    r, theta, phi = (c.symbol for c in system.coordinates)
    m = system.symbols["m"]
    assert form.matrix == sp.ImmutableMatrix([[m, -1 / r**2, 0], [0, 1, -1 / sp.sin(theta) ** 2], [0, 0, 1]])
    assert form.column == (v1(r), v2(theta), v3(phi))


def test_one_wrong_power_beside_an_undetermined_function_is_refused():
    r, theta = sp.symbols("r theta")
    v1, v2 = map(sp.Function, ("v1", "v2"))
    kinetic = "m/2*(dot(r)**2 + r**2*dot(theta)**2)"
    verdict = separate(System({"r": "0 < r", "theta": "angle"}, kinetic, v1(r) + v2(theta) / r**3, {"m": 1}))
    assert isinstance(verdict, Obstruction)
    assert verdict.residual.has(sp.Derivative)


def test_kerr_geodesics_separate_in_boyer_lindquist_coordinates():
    verdict = separate(kerr())
    assert isinstance(verdict, Separation)
    assert verdict.ignorable == ("t", "phi")
    theta, a = verdict.system.coordinates[2].symbol, sp.Symbol("a", real=True)
    p_t, p_phi = sp.symbols("p_t p_phi", real=True)
    carter = p_phi**2 / sp.sin(theta) ** 2 + a**2 * p_t**2 * sp.sin(theta) ** 2
    assert sp.simplify(2 * verdict.reduced.stackel.column[1] - carter) == 0
    obeys(verdict.reduced.stackel, verdict.shell.potential, verdict.system)


@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("surface", ["sphere", "ellipsoid"])
def test_jacobi_coordinates_on_the_sphere_and_on_the_ellipsoid_separate(surface, n):
    """g_ii = −¼ h(u_i) Π_{j≠i}(u_i − u_j) / Π_k (u_i − a_k), k = 0 … n, with h = 1 on the sphere, u_i on the ellipsoid."""
    names, ends = "uvwxy"[:n], "abcdef"[: n + 1]
    terms = []
    for q in names:
        top = "*".join(f"({q} - {o})" for o in names if o != q)
        bottom = "*".join(f"({q} - {a})" for a in ends)
        terms.append(f"-1/8*{q if surface == 'ellipsoid' else 1}*{top}/({bottom})*dot({q})**2")
    domains = {q: f"{ends[i]} < {q} < {ends[i + 1]}" for i, q in enumerate(names)}
    potential = f"k*({' + '.join(names)})" if surface == "sphere" else f"k/({'*'.join(names)})"
    system = make(domains, " ".join(terms), potential, " ".join([*ends, "k"]))
    verdict = separate(system)
    assert isinstance(verdict, Separation)
    obeys(verdict.stackel, verdict.shell.potential, system)
