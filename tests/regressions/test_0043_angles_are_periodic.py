"""T and V that are no functions of an angle were accepted in silence: V = a, cos(a/2), T = (2 + cos(a/2)) ȧ²."""

import pytest

import hjsolve
from hjsolve.mechanics.system import parameter, with_values


def system(potential, kinetic="dot(a)**2/2", **parameters):
    return hjsolve.System({"a": "angle"}, kinetic, potential, parameters)


@pytest.mark.parametrize(
    "potential", ["cos(a/2)", "a", "a**2", "atan(a)", "cos(pi*a)", "(cos(a/2) + 2)**2", "sin(a/3)"]
)
def test_a_potential_that_tells_turns_apart_is_refused_with_what_to_write(potential):
    with pytest.raises(hjsolve.InvalidSystemError, match=r"not 2\*pi-periodic in a.*\"line\".*\"-pi < a < pi\""):
        system(potential)


def test_a_kinetic_energy_that_tells_turns_apart_is_refused():
    with pytest.raises(hjsolve.InvalidSystemError, match=r"kinetic: .*T changes"):
        system("0", "(2 + cos(a/2))*dot(a)**2")


@pytest.mark.parametrize(
    "potential",
    ["cos(a)", "cos(a/2)**2", "tan(a/2)", "sin(a/2)*cos(a/2)", "exp(cos(3*a))", "sqrt(2 + cos(a))", "acos(cos(a))"],
)
def test_what_is_periodic_is_accepted_however_it_is_written(potential):
    assert system(potential).potential is not None


def test_a_number_of_waves_is_accepted_where_its_value_or_its_declaration_makes_it_whole():
    assert system("cos(n*a)", n=2).defaults
    assert system("cos(n*a)", n=parameter("n", assume="integer"))
    with pytest.raises(hjsolve.InvalidSystemError, match="declare n integer"):
        system("cos(n*a)", n="1/2")
    with pytest.raises(hjsolve.InvalidSystemError, match="declare n integer"):
        system("cos(n*a)", n=None)
    with pytest.raises(hjsolve.InvalidSystemError, match="must be an integer"):
        system("cos(n*a)", n=parameter("n", "1/2", assume="integer"))


def test_only_a_letter_that_would_help_is_to_be_declared_integer():
    with pytest.raises(hjsolve.InvalidSystemError, match="declare n integer"):
        system("k*cos(n*(a - b))", k=None, b=None, n=None)
    for spring in ("k*(a - b)**2/2", "k*cos(b*a/2)"):
        with pytest.raises(hjsolve.InvalidSystemError) as refused:
            system(spring, k=None, b=None)
        assert "integer" not in str(refused.value)


def test_other_values_given_later_are_held_to_the_same():
    waves = system("cos(n*a)", n=2)
    with pytest.raises(hjsolve.InvalidSystemError, match="not 2"):
        with_values(waves, {"n": "1/2"})
    start = {"q": {"a": 0}, "velocity": {"a": 3}}
    assert hjsolve.solve(waves).motion(**start, parameters={"n": 3}).kinds == {"a": "rotation"}
    with pytest.raises(hjsolve.InvalidSystemError, match="not 2"):
        hjsolve.solve(waves).motion(**start, parameters={"n": "1/2"})
    whole = system("cos(n*a)", n=parameter("n", 2, assume="integer"))
    with pytest.raises(hjsolve.InvalidInputError, match="must be an integer"):
        hjsolve.solve(whole).motion(**start, parameters={"n": "1/2"})


def test_an_undetermined_function_of_an_angle_counts_as_periodic():
    assert hjsolve.System({"a": "angle"}, "dot(a)**2/2", "v(a)", functions=["v(a)"]).functions == ("v(a)",)


def test_a_witness_of_an_integer_parameter_is_an_integer():
    n = parameter("n", assume="integer")
    own = hjsolve.System({"x": "line", "y": "line"}, "dot(x)**2 + dot(y)**2", "x**2*y**2*n*sin(n + 1/2)", {"n": n})
    verdict = hjsolve.separate(own)
    assert isinstance(verdict, hjsolve.Obstruction)
    assert verdict.witness.point["n"].is_Integer
