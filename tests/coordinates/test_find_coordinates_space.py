"""Separable coordinates of space: the potentials of the literature, a round trip for each of the eleven webs."""

from __future__ import annotations

from collections import Counter

import pytest
import sympy as sp

from hjsolve import System, find_coordinates
from hjsolve.coordinates.charts.charts import CoordinateRange, chart
from hjsolve.coordinates.killing.killing_tensors import concircular_basis, kernel, killing_basis, killing_tensor
from hjsolve.coordinates.webs.concircular_families import family
from hjsolve.coordinates.webs.orthonormal_frames import Sign
from hjsolve.coordinates.webs.space import Potential, space_webs
from tests.support.coordinate_checks import SPACE, along, particle, points, same_motion

r = "sqrt(x**2 + y**2 + z**2)"

# potential, dimension of the kernel, of its concircular part, kinds of webs
LITERATURE = {
    "Kepler": (f"-1/{r}", 10, 5, "rotational parabolic, conical, spherical, prolate spheroidal"),
    "isotropic oscillator": (
        "(x**2 + y**2 + z**2)/2", 12, 7,
        "cartesian, circular cylinder, elliptic cylinder, conical, spherical, prolate spheroidal, oblate spheroidal, "
        "ellipsoidal",
    ),
    "Yukawa": (f"-exp(-{r})/{r}", 7, 2, "conical, spherical"),
    "Stark": (f"-1/{r} + z/10", 3, 2, "rotational parabolic"),
    "two centres": (
        "-1/sqrt(x**2 + y**2 + (z - 1)**2) - 2/sqrt(x**2 + y**2 + (z + 1)**2)", 3, 2, "prolate spheroidal",
    ),
    "Calogero-Moser": (
        "1/(x - y)**2 + 1/(y - z)**2 + 1/(z - x)**2", 5, 4,
        "circular cylinder, rotational parabolic, spherical, prolate spheroidal, oblate spheroidal",
    ),
    "Garnier": ("(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 5*z**2", 3, 2, "ellipsoidal"),
    "Miyamoto-Nagai": ("-1/sqrt(x**2 + y**2 + (1 + sqrt(z**2 + 1))**2)", 2, 1, ""),
    "triaxial logarithmic halo": ("log(x**2 + y**2/2 + z**2/3 + 1)", 1, 1, ""),
    "oscillator 1:1:2": (
        "x**2 + y**2 + 4*z**2", 8, 5,
        "cartesian, parabolic cylinder, circular cylinder, elliptic cylinder, paraboloidal, rotational parabolic",
    ),
    "uniform field": (
        "z", 12, 7,
        "cartesian, parabolic cylinder, circular cylinder, elliptic cylinder, paraboloidal, rotational parabolic",
    ),
    "KdV with a bound z": ("(x**2 + 4*y**2)/2 + x**2*y + 2*y**3 + z**4", 3, 2, "parabolic cylinder"),
    "Henon-Heiles with a bound z": ("(x**2 + y**2)/2 + x**2*y - y**3/3 + z**2", 2, 2, ""),
}  # fmt: skip


@pytest.mark.nightly_cases(
    "Calogero-Moser", "Garnier", "Kepler", "Yukawa", "isotropic oscillator", "oscillator 1:1:2", "uniform field",
)  # fmt: skip
@pytest.mark.rotating(4)
@pytest.mark.slow
@pytest.mark.parametrize("name", LITERATURE)
def test_the_potentials_of_the_literature_have_their_integrals_and_their_webs(name: str) -> None:
    potential, dimension, concircular, kinds = LITERATURE[name]
    system = particle(3, potential)
    found = find_coordinates(system)
    assert (found.kernel_dimension, found.concircular_dimension) == (dimension, concircular)
    assert found.complete
    assert set(found.kinds) == set(filter(None, kinds.split(", ")))
    for web in found.webs:
        assert web.certified, web.verdict
        same_motion(system, web)


@pytest.mark.nightly
def test_three_inverse_squares_and_a_spring_separate_in_eighteen_ways() -> None:
    # Smorodinsky–Winternitz: Cartesian, conical, ellipsoidal; cylinders, spherical and spheroidal about each axis
    system = particle(3, "x**2 + y**2 + z**2 + 1/x**2 + 2/y**2 + 3/z**2")
    found = find_coordinates(system)
    assert (found.kernel_dimension, found.concircular_dimension) == (6, 4)
    assert Counter(web.kind for web in found.webs) == {
        "cartesian": 1, "conical": 1, "ellipsoidal": 1, "circular cylinder": 3, "elliptic cylinder": 3, "spherical": 3,
        "prolate spheroidal": 3, "oblate spheroidal": 3,
    }  # fmt: skip
    for web in found.webs:
        assert web.certified
        same_motion(system, web)


# ---- round trip: a potential made in one web, turned and shifted, must give that web back ---------------------------
# E₁, E₂, E₃: elementary symmetric polynomials of the eigenvalues u, v, w of a concircular tensor; h₃ = Σ u³ + Σ u²v + uvw
x, y, z = sp.symbols("x y z", real=True)
X, Y, Z = (
    sp.Matrix([[2, 1, 2], [1, 2, -2], [-2, 2, 1]]) / 3 * sp.Matrix([x - 1, y + 2, z - 3])
)  # fmt: skip
R2, P2 = sp.expand(X**2 + Y**2 + Z**2), sp.expand(X**2 + Y**2)
R, P = sp.sqrt(R2), sp.sqrt(P2)
TURN = sp.expand(X * Y) / P2**2  # depends on the angle about Z, as g(φ)/ρ²
plane1, plane2 = (sp.sqrt(sp.expand((X + s) ** 2 + Y**2)) for s in (-1, 1))
far1, far2 = (sp.sqrt(sp.expand(P2 + (Z + s) ** 2)) for s in (-1, 1))
cone1, cone2 = sp.expand(4 * X**2 + 3 * Y**2 + Z**2) / R2, sp.expand(3 * X**2) / R2
ell1, ell2, ell3 = 4 + R2, 3 + 4 * X**2 + 3 * Y**2 + Z**2, 3 * X**2
par1, par2, par3 = 2 * X + 2, 4 * X - Y**2 - Z**2, -2 * Y**2
e1, e2, e3 = (2, 1, 2), (1, 2, -2), (-2, 2, 1)
MADE = {
    "cartesian": (sp.expand(X**4 + Y**3) + 1 / sp.expand(Z) ** 2, None),
    "circular cylinder": (sp.expand(P2**2 + Z**4) + TURN, e3),
    "elliptic cylinder": (
        ((plane1 + plane2) ** 3 + 5 * (plane1 - plane2)) / (plane1 * plane2) + sp.expand(Z**4), e3,
    ),
    "parabolic cylinder": (((P + X) ** 3 + 5 / (P - X)) / P + sp.expand(Z**4), e3),
    "spherical": (sp.expand(R2**2) + Z / R**3 + TURN, e3),
    "prolate spheroidal": (((far1 + far2) ** 3 + 5 * (far1 - far2)) / (far1 * far2) + TURN, e3),
    "oblate spheroidal": (sp.expand((R2 + 2) ** 2 - 2 * P2) + TURN, e3),
    "rotational parabolic": (((R + Z) ** 3 + 5 / (R - Z)) / R + TURN, e3),
    "conical": (sp.expand(R2**2) + (cone1**2 - cone2) / R2, None),
    "ellipsoidal": (sp.expand(ell1**3 - 2 * ell1 * ell2 + ell3), None),
    "paraboloidal": (sp.expand(par1**3 - 2 * par1 * par2 + par3), e1),
}  # fmt: skip


@pytest.mark.rotating(3)
@pytest.mark.nightly_cases("ellipsoidal")
@pytest.mark.slow
@pytest.mark.parametrize("kind", MADE)
def test_a_potential_made_in_one_web_gives_that_web_back(kind: str) -> None:
    potential, axis = MADE[kind]
    system = particle(3, potential)
    found = find_coordinates(system)
    assert found.kernel_dimension == 3
    (web,) = found.webs
    assert web.kind == kind
    assert web.certified, web.verdict
    frame = (e1, e2, e3)
    assert all(any(along(mine, wanted) for mine in web.axes) for wanted in frame) or axis in (e1, e3)
    assert axis is None or along(web.axes[0 if axis == e1 else 2], axis)
    if kind not in ("cartesian",) and not kind.endswith("cylinder"):
        assert points([web.centre]) == points([(1, -2, 3)])
    if kind == "prolate spheroidal":
        third = sp.Rational(1, 3)
        assert points(web.foci) == points(
            [(1 - 2 * third, -2 + 2 * third, 3 + third), (1 + 2 * third, -2 - 2 * third, 3 - third)]
        )
    if kind == "oblate spheroidal":
        assert web.lengths["a"] == sp.sqrt(2)
    if kind == "conical":
        assert web.lengths["e2"] == sp.Rational(1, 3)
    if kind == "ellipsoidal":
        assert [web.lengths[k] for k in ("a1", "a2", "a3")] == [0, 1, 3]
    same_motion(system, web)


@pytest.mark.parametrize(
    ("kind", "n", "lengths"),
    [
        ("polar", 2, {}), ("parabolic", 2, {}), ("elliptic", 2, {"a": 3}), ("circular cylinder", 3, {}),
        ("parabolic cylinder", 3, {}), ("elliptic cylinder", 3, {"a": 2}), ("spherical", 3, {}),
        ("rotational parabolic", 3, {}), ("prolate spheroidal", 3, {"a": 2}), ("oblate spheroidal", 3, {"a": 2}),
        ("conical", 3, {"e1": 0, "e2": sp.Rational(1, 3), "e3": 1}), ("ellipsoidal", 3, {"a": 2, "a1": 0, "a2": 1, "a3": 4}),
        ("paraboloidal", 3, {"a": 2, "b": 0, "c": 3}),
    ],
)  # fmt: skip
def test_every_chart_has_the_metric_it_claims(kind: str, n: int, lengths: dict[str, object]) -> None:
    def symbol(name: str, where: CoordinateRange) -> sp.Symbol:
        return sp.Symbol(name, real=True)

    local = chart(kind, {k: sp.sympify(v) for k, v in lengths.items()}, n, symbol)
    inside = {}
    for u, where in zip(local.symbols, local.ranges, strict=True):
        low, high = where.lower, where.upper
        third = sp.Rational(1, 3)
        inside[u] = low + (high - low) * third if low is not None and high is not None else (
            third if low is None and high is None else low + third if low is not None else high - third)  # fmt: skip
    jacobian = sp.Matrix(local.place).jacobian(local.symbols).subs(inside).evalf(40)
    metric = jacobian.T * jacobian
    for i in range(n):
        for j in range(n):
            expected = local.scale[i].subs(inside).evalf(40) if i == j else 0
            assert abs(metric[i, j] - expected) < sp.Float("1e-35")
    assert all(h.subs(inside).evalf() > 0 for h in local.scale)


def test_the_Killing_tensors_of_space_are_twenty_and_independent() -> None:
    x = sp.symbols("x y z", real=True)
    basis = killing_basis(x)
    assert len(basis) == 20
    monomials = sp.Matrix(
        [[c for i in range(3) for j in range(i, 3) for c in _coefficients(K[i, j], x)] for K in basis]
    )
    assert monomials.rank() == 20
    for K in basis:  # Killing: the symmetrised derivative vanishes
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    assert sp.expand(sp.diff(K[i, j], x[k]) + sp.diff(K[j, k], x[i]) + sp.diff(K[k, i], x[j])) == 0


def _coefficients(entry: sp.Expr, x: tuple[sp.Symbol, ...]) -> list[sp.Expr]:
    polynomial = sp.Poly(entry, *x)
    exponents = [(a, b, c) for a in range(3) for b in range(3) for c in range(3)]
    return [polynomial.coeff_monomial((a, b, c)) for a, b, c in exponents]


def test_every_central_potential_has_seven_integrals_and_two_webs() -> None:
    x = sp.symbols("x y z", real=True)
    V = sp.Function("f")(sp.sqrt(x[0] ** 2 + x[1] ** 2 + x[2] ** 2))
    assert kernel(V, x, killing_basis(x)).dimension == 7
    concircular = kernel(V, x, tuple(killing_tensor(M, x) for M in concircular_basis(3)))
    assert concircular.dimension == 2
    webs = space_webs(family(concircular.vectors, 3), Potential(V, x, Sign({})))
    assert {web.kind for web in webs} == {"conical", "spherical"}


def test_what_splits_off_without_separating_is_said() -> None:
    found = find_coordinates(particle(3, "exp(x - y) + exp(y - z) + exp(z - x)"))
    assert found.kernel_dimension == 2
    assert found.webs == ()
    assert "splits off the direction (sqrt(3)/3, sqrt(3)/3, sqrt(3)/3)" in found.advice
    assert "may still be integrable" in found.advice
    found = find_coordinates(particle(3, f"x**2 + y**2 + z**2 + x*y*z/{r}**5"))
    assert found.webs == ()
    assert "splits off the distance from (0, 0, 0)" in found.advice


def test_axes_with_irrational_constants_are_exact() -> None:
    system = particle(3, "(x**2 + y**2 + z**2)**2 + x**2 + x*y + 2*y**2 + 3*z**2 + y*z")
    (web,) = find_coordinates(system).webs
    assert (web.kind, web.certified) == ("ellipsoidal", True)
    assert web.lengths["a"] == sp.root(6, 4)
    assert [web.lengths[k] for k in ("a1", "a2", "a3")] == [0, sp.Rational(1, 2), 1]
    same_motion(system, web)


def test_axes_that_are_roots_of_a_cubic_are_not_passed_over_in_silence() -> None:
    found = find_coordinates(particle(3, "(x**2 + y**2 + z**2)**2 + x**2 + 3*x*y + 2*y**2 + 3*z**2 + y*z"))
    assert found.webs == ()
    assert "irreducible cubic" in found.advice
    assert "not separable" not in found.advice


def test_the_frequencies_of_the_oscillator_in_space_with_more_coordinates_are_found() -> None:
    system = particle(3, "A*x**2 + B*y**2 + C*z**2", {"A": None, "B": None, "C": None})
    found = find_coordinates(system)
    A = system.symbols["A"]
    special = [(dict(value.conditions), value.kernel_dimension) for value in found.special]
    assert ({"B": A}, 5) in special
    assert ({"B": 4 * A}, 4) in special
    assert ({"B": A, "C": A}, 12) in special
    assert ({"B": A, "C": 4 * A}, 8) in special
    assert ({"B": 4 * A, "C": 9 * A}, 5) in special  # the resonance 1:2:3 has one of its own


def test_different_masses_in_space_are_scaled_away() -> None:
    kinetic = "m1*dot(x)**2/2 + m2*dot(y)**2/2 + m2*dot(z)**2/2"
    system = System(SPACE, kinetic, "-k/sqrt(y**2 + z**2) + x**4", {"m1": 3, "m2": 1, "k": 1})
    found = find_coordinates(system, special=False)
    assert set(found.kinds) == {"circular cylinder", "parabolic cylinder", "elliptic cylinder"}
    for web in found.webs:
        assert web.certified
        same_motion(system, web)


@pytest.mark.nightly
@pytest.mark.slow
def test_the_free_particle_separates_in_all_eleven_webs() -> None:
    found = find_coordinates(particle(3, "0"), budget=200)  # every web there is: the longest search of all
    assert (found.kernel_dimension, found.concircular_dimension) == (20, 10)
    assert len(set(found.kinds)) == 11
    assert all(web.certified for web in found.webs)
