"""Liouville form, by sympy at 50 digits: T = Σ R p²/(2Σf), V = Σv/Σf, one coordinate each, f and R positive."""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve.algebra.reader import Reader
from hjsolve.formulas.read import parse
from hjsolve.mechanics.system import System, kinetic_rest, mass_matrix
from hjsolve.separation import Liouville, Region, Separation, region_of, separate
from hjsolve.separation.forms.liouville import recognise
from tests.support.separation_cases import CARTESIAN, E3, ONE_DIMENSIONAL, SEPARABLE, SEVERAL, SPACE, decided, make

FULL = {
    "pendulum", "harmonic oscillator", "Kepler, plane", "isotropic oscillator, polar", "spherical pendulum",
    "projectile", "whirling tube, C25a", "P5-6", "Kepler, parabolic", "two centres", "two centres with square roots",
    "ellipsoidal, plane", "1 Cartesian",
}  # fmt: skip


def obeys(form: Liouville, metric: list[sp.Expr], potential: sp.Expr, system: System) -> None:
    sigma, everything = sp.Add(*form.f), [*form.f, *form.R, *form.v, *metric, potential]
    ours = [R / sigma for R in form.R] + [sp.Add(*form.v) / sigma]
    for _, point in zip(range(4), region_of(system).points(sp.Add(*(sp.Dummy() * x for x in everything)), seed=7)):
        for a, b in zip(ours, [*metric, potential]):
            value = b.evalf(50, subs=point)
            assert abs(a.evalf(50, subs=point) - value) < 1e-40 * (1 + abs(value))
        assert sigma.evalf(30, subs=point) > 0
        assert all(R.evalf(30, subs=point) > 0 for R in form.R)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_the_functions_give_T_and_V_back(name):
    verdict = decided(name)
    assert isinstance(verdict, Separation)
    system, shell = verdict.system, verdict.shell
    if verdict.reduced.liouville is not None:
        obeys(verdict.reduced.liouville, list(shell.inverse_metric), shell.potential, system)
    if verdict.liouville is not None:
        mass = mass_matrix(system)
        metric = [1 / mass[i, i] for i in range(mass.rows)]
        obeys(verdict.liouville, metric, system.potential - kinetic_rest(system), system)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_each_function_holds_its_own_coordinate_only(name):
    verdict = decided(name)
    symbols = {c.name: c.symbol for c in verdict.system.coordinates}
    for form in filter(None, (verdict.liouville, verdict.reduced.liouville)):
        for functions in (form.f, form.R, form.v):
            for own, function in zip(form.coordinates, functions):
                assert not function.free_symbols & {s for name, s in symbols.items() if name != own}


@pytest.mark.parametrize("name", [*ONE_DIMENSIONAL, *SEVERAL, *E3])
def test_the_systems_of_liouvilles_form_are_recognised_and_no_others(name):
    assert (decided(name).liouville is not None) == (name in FULL)


def test_kepler_in_space_is_not_liouville_but_is_once_phi_is_ignored():
    """Greenwood (5-178)–(5-180)."""
    verdict = decided("Kepler, space")
    r, theta = (c.symbol for c in verdict.shell.coordinates)
    m, k = sp.symbols("m k", positive=True)
    p_phi = sp.Symbol("p_phi", real=True)
    assert verdict.liouville is None
    assert verdict.reduced.liouville == Liouville(
        ("r", "theta"), (m * r**2, 0), (r**2, 1), (-k * m * r, p_phi**2 / (2 * sp.sin(theta) ** 2))
    )


def test_the_spherical_pendulum_has_the_functions_of_greenwood_2_222():
    form = decided("spherical pendulum").liouville
    m, g, l = sp.symbols("m g l", positive=True)
    theta = SEPARABLE["spherical pendulum"].coordinates[0].symbol
    s = sp.sin(theta) ** 2
    assert form == Liouville(("theta", "phi"), (m * l**2 * s, 0), (s, 1), (-(m**2) * g * l**3 * s * sp.cos(theta), 0))


def test_constant_masses_give_f_equal_to_one():
    system = make(SPACE, "m1/2*dot(x)**2 + m2/2*dot(y)**2 + m3/2*dot(z)**2", "k*x**4 + b*y**2 + z", "m1 m2 m3 k b")
    form = separate(system).liouville
    assert sp.Add(*form.f) == 1
    assert tuple(1 / sp.Symbol(f"m{i}", positive=True) for i in (1, 2, 3)) == form.R


def test_a_three_dimensional_conformal_factor_is_recognised():
    factor = "(x**2 + exp(y) + cosh(z))"
    kinetic = f"{factor}/2*(dot(x)**2/x**2 + dot(y)**2 + dot(z)**2/(1 + z**2))"
    potential = f"(k*x + sin(y) + z**4)/{factor}"
    system = make({"x": "0 < x", "y": "line", "z": "line"}, kinetic, potential, "k")
    form = separate(system).liouville
    x, y, z = (c.symbol for c in system.coordinates)
    assert form.f == (x**2, sp.exp(y), sp.cosh(z))
    assert (x**2, 1, z**2 + 1) == form.R


def test_three_dimensional_neighbours_of_the_form_are_not_liouville():
    assert separate(make(SPACE, CARTESIAN, "k*x**2", "m k")).liouville is not None
    assert decided("8 rotational parabolic").liouville is None


def test_negative_factors_are_turned_so_that_f_and_R_are_positive():
    kinetic = "(u**2 + v**2 + 1)/2*(dot(u)**2/(4 - u**2) + dot(v)**2/(9 - v**2))"
    system = make({"u": "-2 < u < 2", "v": "-3 < v < 3"}, kinetic, "k*u/(u**2 + v**2 + 1)", "k")
    form = separate(system).liouville
    mass = mass_matrix(system)
    obeys(form, [1 / mass[0, 0], 1 / mass[1, 1]], system.potential, system)


@pytest.mark.parametrize(
    ("metric", "potential"),
    [
        (("1/(x*y + z)", "1/(x*y + z)", "1/(x*y + z)"), "0"),
        (("1/(x + y + z)", "1/(x + y + z)", "1/(x + y + z)"), "x*y"),
        (("1/(x + y + z)", "(1 + x*y)/(x + y + z)", "1/(x + y + z)"), "0"),
        (("1/(x + y + z)", "z/(x + y + z)", "1/(x + y + z)"), "0"),
    ],
)
def test_what_is_not_of_the_form_is_not_given_functions(metric, potential):
    """Asked directly, since ``separate`` asks only about systems that separate."""
    symbols = sp.symbols("x y z", positive=True)
    names = {s.name: s for s in symbols}
    expressions = [parse(text, names, source="test") for text in (*metric, potential)]
    bounds = dict.fromkeys(symbols, (sp.S.Zero, None))
    reader = Reader(expressions, bounds)
    *elements, V = (reader.element(x) for x in expressions)
    assert recognise(reader, list(names), symbols, elements, V, Region(bounds)) is None
