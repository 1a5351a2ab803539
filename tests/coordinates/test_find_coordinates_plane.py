"""Separable coordinates of the plane: the sixteen potentials of the literature, round trips, families, parameters."""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve import InvalidSystemError, NotSeparableError, Obstruction, Separation, System, find_coordinates
from hjsolve.coordinates.charts.transform import web_of
from hjsolve.coordinates.find import cartesian_form
from hjsolve.coordinates.killing.killing_tensors import concircular_basis, kernel, killing_basis, killing_tensor
from hjsolve.coordinates.results import Geometry
from hjsolve.coordinates.simplest_chart import find_chart
from hjsolve.coordinates.webs.concircular_families import family
from hjsolve.coordinates.webs.orthonormal_frames import Sign
from hjsolve.coordinates.webs.plane import plane_webs
from tests.support.coordinate_checks import PLANE, along, particle, points, same_motion

r = "sqrt(x**2 + y**2)"

# potential, dimension of the kernel, [(kind, centre, foci, first axis)]; Smirnov math-ph/0604038 and the sources there
LITERATURE = {
    "Kepler": (f"-1/{r}", 4, [("parabolic", (0, 0), None, None), ("polar", (0, 0), (), None), ("elliptic", None, None, None)]),
    "two centres": (
        "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + y**2)", 2,
        [("elliptic", (0, 0), ((1, 0), (-1, 0)), (1, 0))],
    ),
    "two centres off the axes": (
        "-1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)", 2,
        [("elliptic", (2, sp.Rational(1, 2)), ((1, 2), (3, -1)), (2, -3))],
    ),
    "Stark": (f"-1/{r} + x/10", 2, [("parabolic", (0, 0), ((0, 0),), (1, 0))]),
    "oscillator 1:2": ("(x**2 + 4*y**2)/2", 3, [("cartesian", None, (), (1, 0)), ("parabolic", None, None, (0, 1))]),
    "oscillator 1:sqrt(3)": ("(x**2 + 3*y**2)/2", 2, [("cartesian", None, (), (1, 0))]),
    "Henon-Heiles": ("(x**2 + y**2)/2 + x**2*y - y**3/3", 1, []),
    "Sawada-Kotera": ("(x**2 + y**2)/2 + x**2*y + y**3/3", 2, [("cartesian", None, (), (1, -1))]),
    "KdV": ("(x**2 + 4*y**2)/2 + x**2*y + 2*y**3", 2, [("parabolic", (0, 0), ((0, 0),), (0, 1))]),
    "Kaup-Kupershmidt": ("(x**2 + 16*y**2)/2 + x**2*y + 16/3*y**3", 1, []),
    "Toda": ("(exp(2*x + 2*sqrt(3)*y) + exp(2*x - 2*sqrt(3)*y) + exp(-4*x))/24", 1, []),
    "quartic 1:6:1": ("x**4 + 6*x**2*y**2 + y**4", 2, [("cartesian", None, (), (1, 1))]),
    "quartic 1:12:16": ("x**4 + 12*x**2*y**2 + 16*y**4", 2, [("parabolic", (0, 0), ((0, 0),), (0, 1))]),
    "quartic oscillator": ("(x**2 + y**2)**2", 2, [("polar", (0, 0), (), None)]),
    "Garnier": (
        "(x**2 + y**2)**2 + x**2 + 3/2*y**2", 2,
        [("elliptic", (0, 0), ((sp.sqrt(2) / 2, 0), (-sp.sqrt(2) / 2, 0)), (1, 0))],
    ),
    "isotropic oscillator": (
        "(x**2 + y**2)/2", 4, [("cartesian", None, (), None), ("polar", (0, 0), (), None), ("elliptic", (0, 0), None, None)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LITERATURE)
def test_the_potentials_of_the_literature_have_their_integrals_and_their_webs(name: str) -> None:
    potential, dimension, expected = LITERATURE[name]
    system = particle(2, potential)
    found = find_coordinates(system)
    assert found.kernel_dimension == dimension
    assert found.complete
    assert [web.kind for web in found.webs] == [kind for kind, *_ in expected]
    for web, (_, centre, foci, axis) in zip(found.webs, expected, strict=True):
        assert web.certified, web.verdict
        assert centre is None or points([web.centre]) == points([centre])
        assert foci is None or points(web.foci) == points(foci)
        # a Cartesian web is the same with its axes exchanged
        axes = web.axes if web.kind == "cartesian" else web.axes[:1]
        assert axis is None or any(along(mine, axis) for mine in axes)
        same_motion(system, web)


@pytest.mark.parametrize("name", ["Henon-Heiles", "Kaup-Kupershmidt", "Toda"])
def test_without_a_web_it_is_said_that_the_system_may_still_be_integrable(name: str) -> None:
    found = find_coordinates(particle(2, LITERATURE[name][0]))
    assert found.webs == ()
    assert "not separable by a point transformation in orthogonal coordinates" in found.advice
    assert "may still be integrable" in found.advice
    assert "Toda" in found.advice


# a potential made in one web only, at a turned and shifted place, must give that web back
ξ, η = "((3*(x - 1) + 4*(y + 2))/5)", "((-4*(x - 1) + 3*(y + 2))/5)"
ρ = "sqrt((x - 1)**2 + (y + 2)**2)"
r1, r2 = "sqrt((x - 2)**2 + (y - 1)**2)", "sqrt((x + 4)**2 + (y - 9)**2)"
MADE = {
    "cartesian": (f"{ξ}**4 + 1/{η}", None, (3, 4)),
    "polar": (f"{ρ}**3 + {ξ}*{η}/{ρ}**4", (1, -2), None),
    "parabolic": (f"(({ρ} + {ξ})**3 + 5/({ρ} - {ξ}))/{ρ}", (1, -2), (3, 4)),
    "elliptic": (f"(({r1} + {r2})**3 + 5*({r1} - {r2}))/({r1}*{r2})", (-1, 5), (3, -4)),
}


@pytest.mark.nightly_cases("elliptic")
@pytest.mark.parametrize("kind", MADE)
def test_a_potential_made_in_one_web_gives_that_web_back(kind: str) -> None:
    potential, centre, axis = MADE[kind]
    system = particle(2, potential)
    found = find_coordinates(system)
    assert found.kernel_dimension == 2
    (web,) = found.webs
    assert web.kind == kind
    assert web.certified
    assert centre is None or points([web.centre]) == points([centre])
    assert axis is None or any(along(mine, axis) for mine in (web.axes if kind == "cartesian" else web.axes[:1]))
    if kind == "elliptic":
        assert points(web.foci) == points([(2, 1), (-4, 9)])
        assert web.lengths["a"] == 5
    same_motion(system, web)


@pytest.mark.parametrize(
    ("geometry", "separates"),
    [
        (Geometry("parabolic", (0, 0), ((sp.Rational(3, 5), sp.Rational(4, 5)), (-sp.Rational(4, 5), sp.Rational(3, 5)))), True),
        (Geometry("elliptic", (3, 4), ((sp.Rational(3, 5), sp.Rational(4, 5)), (-sp.Rational(4, 5), sp.Rational(3, 5))),
                  lengths={"a": sp.Integer(5)}), True),
        (Geometry("parabolic", (1, 0), ((1, 0), (0, 1))), False),
        (Geometry("elliptic", (3, 4), ((sp.Rational(3, 5), sp.Rational(4, 5)), (-sp.Rational(4, 5), sp.Rational(3, 5))),
                  lengths={"a": sp.Integer(4)}), False),
    ],
)  # fmt: skip
def test_the_whole_family_of_Kepler_separates_and_its_neighbours_do_not(geometry: Geometry, separates: bool) -> None:
    system = particle(2, f"-1/{r}")
    exact = Geometry(geometry.kind, tuple(map(sp.sympify, geometry.centre)),
                     tuple(tuple(map(sp.sympify, axis)) for axis in geometry.axes), (), geometry.lengths)  # fmt: skip
    web = web_of(exact, cartesian_form(system), budget=20)
    assert isinstance(web.verdict, Separation if separates else Obstruction)
    same_motion(system, web)


def test_families_are_described_by_what_may_be_varied() -> None:
    kepler = {web.kind: web for web in find_coordinates(particle(2, f"-1/{r}")).webs}
    assert kepler["parabolic"].freedom == 1
    assert "axis in any direction" in kepler["parabolic"].family
    assert kepler["elliptic"].freedom == 2
    assert kepler["elliptic"].family == "one focus at (0, 0), the other anywhere"
    assert kepler["polar"].freedom == 0
    oscillator = {web.kind: web for web in find_coordinates(particle(2, "x**2 + y**2")).webs}
    assert oscillator["elliptic"].family == "centre at (0, 0); axis in any direction; any focal distance"


def test_the_free_particle_separates_in_all_four_webs_anywhere() -> None:
    found = find_coordinates(particle(2, "0"))
    assert found.kernel_dimension == 6
    assert {web.kind: web.freedom for web in found.webs} == {"cartesian": 1, "parabolic": 3, "polar": 2, "elliptic": 4}
    assert all(web.certified for web in found.webs)


def test_symbolic_centres_give_symbolic_foci() -> None:
    system = particle(2, "-k/sqrt((x - c)**2 + y**2) - j/sqrt((x + c)**2 + y**2)", {"k": 1, "j": None, "c": None})
    (web,) = find_coordinates(system).webs
    c = system.symbols["c"]
    assert points(web.foci) == {(c, 0), (-c, 0)}
    assert web.certified
    assert "for c > 0" in web.remark
    same_motion(system, web)


def test_the_separable_members_of_the_Henon_Heiles_family_are_found() -> None:
    system = particle(2, "(A*x**2 + B*y**2)/2 + x**2*y + C*y**3", {"A": None, "B": None, "C": None})
    found = find_coordinates(system)
    assert found.kernel_dimension == 1
    A = system.symbols["A"]
    special = [(dict(value.conditions), value.kernel_dimension) for value in found.special]
    assert ({"C": sp.Integer(2)}, 2) in special  # KdV: any A, B
    assert ({"C": sp.Rational(1, 3), "B": A}, 2) in special  # Sawada–Kotera
    assert len(special) == 2  # Kaup–Kupershmidt (C = 16/3) is not among them


def test_the_frequency_ratios_of_the_oscillator_with_more_coordinates_are_found() -> None:
    system = particle(2, "A*x**2 + B*y**2", {"A": None, "B": None})
    found = find_coordinates(system)
    A = system.symbols["A"]
    assert {value.conditions["B"]: value.kernel_dimension for value in found.special} == {A: 4, 4 * A: 3, A / 4: 3}


def test_a_symbolic_exponent_gives_Kepler_and_Hooke_as_special_values() -> None:
    found = find_coordinates(particle(2, "k*(x**2 + y**2)**(n/2)", {"k": 1, "n": None}))
    assert [web.kind for web in found.webs] == ["polar"]
    assert {value.conditions["n"]: value.kernel_dimension for value in found.special} == {-1: 4, 2: 4}


def test_different_masses_are_scaled_away() -> None:
    system = System(PLANE, "m*dot(x)**2/2 + M*dot(y)**2/2", "k/2*(x - y)**2", {"m": 1, "M": 2, "k": 1})
    (web,) = find_coordinates(system).webs
    assert web.kind == "cartesian"
    assert web.certified
    assert len(web.verdict.ignorable) == 1  # the centre of mass
    same_motion(system, web)


@pytest.mark.nightly
def test_a_constant_mass_matrix_is_brought_to_Cartesian_form() -> None:
    system = System(PLANE, "dot(x)**2 + dot(x)*dot(y) + dot(y)**2", "x**2 + 3*y**2")
    (web,) = find_coordinates(system).webs
    assert (web.kind, web.certified) == ("cartesian", True)
    same_motion(system, web)


def test_a_symbolic_quadratic_form_is_turned_to_its_axes() -> None:
    system = particle(2, "a*x**2 + b*y**2 + 2*c*x*y", {"a": None, "b": None, "c": None})
    (web,) = find_coordinates(system, special=False).webs
    assert (web.kind, web.certified) == ("cartesian", True)
    same_motion(system, web)


def test_radicals_that_depend_on_each_other_hide_no_integral() -> None:
    # sqrt(r + x) sqrt(r - x) = |y|: found with symbolic strengths and with numbers alike (Smorodinsky, Winternitz)
    V = f"-1/{r} + (sqrt({r} + x) + c*sqrt({r} - x))/{r}"
    assert find_coordinates(particle(2, V, {"c": 2})).kernel_dimension == 3
    assert find_coordinates(particle(2, V.replace("c*", ""))).kernel_dimension == 3
    assert find_coordinates(particle(2, V.replace("c*", "") + " + y")).kernel_dimension == 2


def test_undetermined_functions_are_generic() -> None:
    x = sp.symbols("x y", real=True)
    f, g = sp.Function("f"), sp.Function("g")
    tensors = tuple(killing_tensor(M, x) for M in concircular_basis(2))
    central = kernel(f(sp.sqrt(x[0] ** 2 + x[1] ** 2)), x, tensors)
    assert central.dimension == 2
    assert [web.kind for web in plane_webs(family(central.vectors, 2), Sign({}))] == ["polar"]
    assert kernel(f(x[0]) + g(x[1]), x, tensors).dimension == 2
    assert kernel(f(x[0] + x[1] ** 2), x, tensors).dimension == 1


@pytest.mark.parametrize("name", ["Sawada-Kotera", "KdV", "quartic 1:12:16", "Garnier", "oscillator 1:2"])
def test_every_kernel_vector_satisfies_its_equation_identically(name: str) -> None:
    x = sp.symbols("x y", real=True)
    V = sp.sympify(LITERATURE[name][0], locals={"x": x[0], "y": x[1]})
    basis = killing_basis(x)
    for vector in kernel(V, x, basis).vectors:
        K = sum((c * B for c, B in zip(vector, basis, strict=True)), sp.zeros(2, 2))
        form = K * sp.Matrix([sp.diff(V, q) for q in x])
        assert sp.expand(sp.diff(form[0], x[1]) - sp.diff(form[1], x[0])) == 0


def test_names_that_are_taken_by_parameters_are_avoided() -> None:
    V = "-mu/sqrt((x - nu)**2 + y**2) - r/sqrt((x + nu)**2 + y**2)"
    (web,) = find_coordinates(particle(2, V, {"mu": 1, "nu": 1, "r": 1})).webs
    assert web.coordinates == ("mu_1", "nu_1")
    assert web.certified


@pytest.mark.parametrize(
    ("coordinates", "kinetic", "potential", "says"),
    [
        ({"r": "1 < r", "phi": "angle"}, "(dot(r)**2 + r**2*dot(phi)**2)/2", "-1/r", "phi is an angle"),
        ({"r": "0 < r", "s": "line"}, "(dot(r)**2 + r**2*dot(s)**2)/2", "-1/r", "T depends on the coordinates"),
        (PLANE, "(dot(x)**2 + dot(y)**2)/2 + x*dot(y)", "x", "not quadratic in the velocities"),
        (PLANE, "(dot(x)**2 + dot(y)**2 + x**2)/2", "x", "not quadratic in the velocities"),
        ({"x": "line"}, "dot(x)**2/2", "x", "the plane (2) and space (3)"),
    ],
)
def test_what_is_not_supported_is_said(coordinates: dict[str, str], kinetic: str, potential: str, says: str) -> None:
    with pytest.raises(InvalidSystemError, match="find_coordinates") as refusal:
        find_coordinates(System(coordinates, kinetic, potential))
    assert says in str(refusal.value)


def test_a_web_without_time_to_be_certified_is_not_called_none() -> None:
    """The words of the refusal neither deny the web nor say that the system separates."""
    system = System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x/sqrt(x**2 + y**2) + x**2 - y**2")
    two = System(
        {"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2",
        "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + y**2)",
    )  # fmt: skip
    with pytest.raises(NotSeparableError) as refusal:
        find_chart(two, None, budget=1e-9)
    assert "whether others do was not decided in 1e-09 s" in str(refusal.value)
    with pytest.raises(NotSeparableError) as none:
        find_chart(system, None)
    assert "not decided" not in str(none.value)
