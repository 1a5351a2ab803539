"""Units of a system: which follow, which do not fit, and what quantities become."""

import random

import astropy.units as u
import pint
import pytest

import hjsolve
from hjsolve.mechanics.quantities_given import measures
from hjsolve.units.libraries import library

REGISTRY = pint.UnitRegistry()
POLAR = {"coordinates": {"r": "0 < r", "theta": "angle"}, "kinetic": "m/2*(dot(r)**2 + r**2*dot(theta)**2)"}


def kepler(units, **parameters):
    return hjsolve.System(**POLAR, potential="-k/r", parameters={"m": 1, "k": 1, **parameters}, units=units)


def test_units_that_follow_are_worked_out():
    assert kepler({"r": "kpc", "t": "Myr", "m": "solMass"}).units == {
        "theta": "rad", "r": "kpc", "t": "Myr", "m": "solMass", "k": "solMass*kpc^3/Myr^2"
    }  # fmt: skip
    assert kepler({"r": "m", "k": "J*m", "m": "kg"}).units["t"] == "kg^(1/2)*m^(3/2)/(J*m)^(1/2)"
    halo = hjsolve.System({"R": "0 < R"}, "dot(R)**2/2", "v**2/2*log(R**2 + c**2)", {"v": 1, "c": 1}, units={"R": "kpc", "t": "Myr"})
    assert (halo.units["v"], halo.units["c"]) == ("kpc/Myr", "kpc")


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: kepler({"r": "m", "theta": "deg"}), "theta is an angle, in T and V in radians"),
        (lambda: kepler({"rr": "m"}), "did you mean r"),
        (lambda: kepler({"r": 3}), 'r: a text such as "kpc" is needed'),
        (lambda: hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2 + x**3", units={"x": "m"}), "x is in m, but .* a pure number"),
        (lambda: hjsolve.System({"x": "line"}, "dot(x)**2/2", "exp(x)", units={"x": "m"}), "x is in m, but"),
        (lambda: hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2", units={"x": "m", "t": "s"}), "t is in s, but"),
        (lambda: kepler(None, m=1 * u.kg), "it declares none; write"),
        (lambda: kepler({"r": "m", "t": "s", "m": "kg"}, m=1 * u.s), r"parameters\[m\]: is in s; a quantity in kg"),
        (lambda: kepler({"r": "m", "t": "s"}, m=1 * u.kg), "that of m .parameters. does not follow from those of r, t"),
    ],
)
def test_what_does_not_fit_is_refused_with_what_to_write(make, says):
    with pytest.raises(hjsolve.HJSolveError, match=says):
        make()


@pytest.mark.parametrize("chosen", ["astropy", "pint"])
def test_units_that_are_no_product_of_each_other_are_refused(chosen):
    fits = {"r": "m", "t": "s", "m": "kg", "k": "J*m"}
    assert measures(kepler(fits), library(chosen)).unit("k", "parameters") == library(chosen).unit({"J": 1, "m": 1})
    with pytest.raises(hjsolve.InvalidInputError, match="do not fit together: with T and V a pure 1 would be "):
        measures(kepler({**fits, "t": "hour"}), library(chosen))


def test_quantities_as_parameters_are_numbers_in_the_units_of_the_system():
    units = {"r": "km", "t": "s", "m": "kg"}
    for km, g, newton in ((u.km, u.g, u.N), (REGISTRY.km, REGISTRY.g, REGISTRY.newton)):
        system = kepler(units, m=500 * g, k=2 * newton * km**2)
        assert [float(p.value) for p in system.parameters] == pytest.approx([0.5, 0.002], rel=1e-15)
    assert kepler(units, m=1 * u.kg) == kepler(units)
    assert eval(repr(kepler(units)), {"System": hjsolve.System}) == kepler(units)


@pytest.mark.parametrize("name", ["kepler-planar", "crossed-fields", "lagrange-top", "calogero-moser", "triaxial-geodesics"])
def test_the_units_of_the_catalog_fit_t_and_v_in_both_libraries(name):
    system = hjsolve.catalog.load(name)
    for chosen in ("astropy", "pint"):
        found = measures(system, library(chosen))
        for parameter in system.parameters:
            assert found.library.number(1 * found.unit(parameter.name, "parameters"), found.library.unit({parameter.unit or "1": 1})) == 1
    assert system.units["t"]
    assert hjsolve.catalog.from_table(hjsolve.catalog.table_of(system)) == system


def test_random_products_of_powers_are_consistent_and_a_changed_one_is_not():
    """V = Σ k_i x^n_i: the unit of each k_i follows; declared in J/m^n it fits, one power off it does not."""
    rng = random.Random(11)
    for _ in range(10):
        powers = rng.sample(range(1, 9), 3)
        potential = " + ".join(f"k{n}*x**{n}/{rng.randint(1, 9)}" for n in powers)
        units = {"x": "m", "m": "kg", "t": "s"} | {f"k{n}": f"J/m^{n}" for n in powers}
        make = lambda table: hjsolve.System({"x": "line"}, "m*dot(x)**2/2", potential, dict.fromkeys(["m", *(f"k{n}" for n in powers)], 1), units=table)  # noqa: B023, E731
        measures(make(units), library("pint"))
        off = rng.choice(powers)
        with pytest.raises(hjsolve.InvalidInputError, match="do not fit together"):
            measures(make({**units, f"k{off}": f"J/m^{off + 1}"}), library("pint"))
