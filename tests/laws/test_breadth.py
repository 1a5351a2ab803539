"""Disguises, magnetic terms, ignorable blocks, and the general potential of every web with undetermined functions."""

from __future__ import annotations

import itertools

import pytest
import sympy as sp

from hjsolve.mechanics.system import System, mass_matrix
from hjsolve.separation import Obstruction, Separation, Undecided, region_of, separate
from tests.support.breadth_cases import REFUSED, SEPARABLE
from tests.support.separation_cases import E3
from tests.support.separation_cases import SEPARABLE as ALL

pytestmark = pytest.mark.rotating_file(10)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_it_is_recognised_and_its_matrix_gives_the_shell_back(name):
    """cᵀΦ = (1, 0, …, 0) and cᵀψ = U of the shell at 50 digits, by sympy."""
    verdict = separate(SEPARABLE[name])
    assert isinstance(verdict, Separation), verdict
    form, U = verdict.reduced.stackel, verdict.shell.potential
    everything = sp.Add(*(sp.Dummy() * e for e in (*form.inverse_metric, *form.matrix, *form.column, U)))
    for _, point in zip(range(2), region_of(verdict.system).points(everything, seed=5)):

        def at(e, point=point):
            return e.evalf(50, subs=point)

        c = [at(g) for g in form.inverse_metric]
        for j in range(len(c)):
            terms = [c[i] * at(form.matrix[i, j]) for i in range(len(c))]
            assert abs(sum(terms) - int(j == 0)) < 1e-40 * (1 + max(map(abs, terms)))
        terms = [c[i] * at(form.column[i]) for i in range(len(c))]
        assert abs(sum(terms) - at(U)) < 1e-40 * (1 + max(map(abs, terms)))


@pytest.mark.parametrize("name", list(REFUSED))
def test_the_neighbours_are_refused_with_a_witness(name):
    verdict = separate(REFUSED[name])
    assert isinstance(verdict, Obstruction)
    assert verdict.witness.excludes_zero


def general(system: System, power: int = 1) -> System:
    """The same T with V = Σ f_i(q_i)/h_i², f_i undetermined; with ``power`` 2 one term has the wrong weight."""
    mass = mass_matrix(system)
    symbols = [c.symbol for c in system.coordinates]
    functions = [sp.Function(f"f_{c.name}") for c in system.coordinates]
    terms = [f(q) / mass[i, i] ** (power if i == 0 else 1) for i, (f, q) in enumerate(zip(functions, symbols))]
    places = {c.name: c.domain.written(c.name) for c in system.coordinates}
    return System(places, system.kinetic, sp.Add(*terms), {p.name: p for p in system.parameters})


OF_THE_PLANE = ("projectile", "Kepler, plane", "P5-6", "two centres", "ellipsoidal, plane")
WEBS = {**{name: ALL[name] for name in OF_THE_PLANE}, **E3}


@pytest.mark.parametrize("name", list(WEBS))
def test_the_general_potential_of_every_web_separates_with_undetermined_functions(name):
    verdict = separate(general(WEBS[name]))
    assert isinstance(verdict, Separation)
    for i, ψ in enumerate(verdict.reduced.stackel.column):
        own = verdict.reduced.stackel.coordinates[i]
        assert {type(f).__name__ for f in ψ.atoms(sp.core.function.AppliedUndef)} == {f"f_{own}"}


VARYING = [
    n
    for n in WEBS
    if n not in {"projectile", "Kepler, plane", "1 Cartesian", "2 circular cylinder", "5 spherical", "9 conical"}
]


@pytest.mark.parametrize("name", VARYING)
def test_one_wrong_weight_and_the_undetermined_functions_do_not_separate(name):
    verdict = separate(general(WEBS[name], power=2))
    assert isinstance(verdict, Obstruction)


def liouville(n: int) -> tuple[System, list[sp.Symbol]]:
    """T = ½ Σf_i Σ q̇_i²/R_i, V = Σv_i/Σf_i with undetermined f, R, v: Greenwood (5-125), (5-126)."""
    names = ["x", "y", "z", "w", "s"][:n]
    q = [sp.Symbol(name, real=True) for name in names]
    f, R, v = ([sp.Function(f"{letter}_{name}")(s) for name, s in zip(names, q)] for letter in "fRv")
    speeds = [sp.Symbol(f"dot({name})") for name in names]
    T = sp.Add(*f) / 2 * sp.Add(*(w**2 / r for w, r in zip(speeds, R)))
    return System(dict.fromkeys(names, "line"), T, sp.Add(*v) / sp.Add(*f)), q


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_the_general_class_of_liouville_is_recognised(n):
    system, q = liouville(n)
    verdict = separate(system)
    assert isinstance(verdict, Separation)
    for i, row in enumerate(verdict.stackel.matrix.tolist()):
        others = set(q) - {q[i]}
        assert not set().union(*(e.free_symbols for e in (*row, verdict.stackel.column[i]))) & others


@pytest.mark.parametrize("n", [2, 3])
def test_a_product_in_the_general_class_is_refused(n):
    system, q = liouville(n)
    for a, b in itertools.combinations(q, 2):
        broken = System({s.name: "line" for s in q}, system.kinetic, system.potential + a * b)
        assert isinstance(separate(broken), Obstruction)


def quadric(*axes: str) -> str:
    """T on Σ x_k²/a_k = 1 by its embedding, x_k² = a_k Π(a_k − u_i)/Π(a_k − a_j): nothing cancelled, u and v coupled."""
    terms = []
    for k, a in enumerate(axes):
        others = "*".join(f"(({a}) - ({b}))" for j, b in enumerate(axes) if j != k)
        square = f"({a})*(({a}) - u)*(({a}) - v)/({others})"
        terms.append(f"{square}*(dot(u)/(u - ({a})) + dot(v)/(v - ({a})))**2/8")
    return " + ".join(terms)


QUADRICS = {
    "ellipsoid": ({"u": "c < u < b", "v": "b < v < a"}, quadric("a", "b", "c")),
    "hyperboloid of one sheet": ({"u": "u < -c", "v": "b < v < a"}, quadric("a", "b", "-c")),
    "hyperboloid of two sheets": ({"u": "u < -b", "v": "-b < v < -c"}, quadric("a", "-b", "-c")),
}


@pytest.mark.parametrize("name", QUADRICS)
def test_geodesics_on_quadrics_separate_though_T_is_written_coupled(name):
    domains, kinetic = QUADRICS[name]
    system = System(domains, kinetic, "k/(u*v)", {"a": 5, "b": 3, "c": 2, "k": 1})
    verdict = separate(system)
    assert isinstance(verdict, Separation)
    assert verdict.shell.coordinates == system.coordinates
    for row, q in zip(verdict.reduced.stackel.matrix.tolist(), system.coordinates, strict=True):
        assert set().union(*(e.free_symbols for e in row)) <= {q.symbol, *system.symbols.values()} - {
            c.symbol for c in system.coordinates if c is not q
        }
    broken = System(domains, kinetic, "k/(u + v)**2", {"a": 5, "b": 3, "c": 2, "k": 1})
    assert isinstance(separate(broken), Obstruction)


def test_the_budget_of_a_decision_can_be_set():
    system = WEBS["10 ellipsoidal"]
    hurried = separate(system, budget=0.0)
    assert isinstance(hurried, Undecided)
    assert "time budget" in " ".join(step.explanation for step in hurried.evidence)
    assert isinstance(separate(system, budget=20.0), Separation)
