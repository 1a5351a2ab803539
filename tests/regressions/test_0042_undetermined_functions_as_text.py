"""v1(r) in a text was "'v1' is not declared": functions left undetermined worked only as sympy objects from Python."""

import pytest
import sympy as sp

import hjsolve
from hjsolve.command_line import main

POLAR = {"r": "0 < r", "theta": "angle"}
KINETIC = "(dot(r)**2 + r**2*dot(theta)**2)/2"


def system(potential, functions):
    return hjsolve.System(POLAR, KINETIC, potential, functions=functions)


def test_a_central_field_plus_a_field_of_the_angle_separates_in_formulas():
    solution = hjsolve.solve(system("v1(r) + v2(theta)/r**2", ["v1(r)", " v2 ( theta )"]))
    E, a, r, θ = (sp.Symbol(n, real=True) for n in ("E", "alpha_2", "r", "theta"))
    r = solution.system.coordinate("r").symbol
    v1, v2 = sp.Function("v1")(r), sp.Function("v2")(θ)
    assert sp.expand(solution.momentum_squared["r"] - (2 * E - 2 * a / r**2 - 2 * v1)) == 0
    assert sp.expand(solution.momentum_squared["theta"] - (2 * a - 2 * v2)) == 0


def test_text_and_sympy_make_the_same_system_and_its_repr_makes_it_again():
    text = system("v1(r)", ["v1(r)"])
    assert text == hjsolve.System(POLAR, KINETIC, sp.Function("v1")(sp.Symbol("r")))
    assert text.functions == ("v1(r)",)
    assert eval(repr(text), {"System": hjsolve.System}) == text


def test_a_function_of_both_coordinates_does_not_separate_and_one_in_T_does():
    assert isinstance(hjsolve.separate(system("f(r, theta)", ["f(r, theta)"])), hjsolve.Obstruction)
    own = hjsolve.System({"x": "line"}, "m(x)*dot(x)**2/2", "v(x)", functions=["m(x)", "v(x)"])
    assert isinstance(hjsolve.separate(own), hjsolve.Separation)


@pytest.mark.parametrize(
    ("potential", "functions", "message"),
    [
        ("v1(r)", [], r"'v1' is not declared.*declare functions=\[\"v1\(r\)\"\]"),
        ("sine(r)", [], "did you mean sin"),
        ("sn(r)", [], "did you mean sin"),
        ("v1(2*r)", ["v1(r)"], r"v1 is declared as v1\(r\); write v1\(r\)"),
        ("v1", ["v1(r)"], r"write v1\(r\)"),
        ("v1(theta)", ["v1(r)"], r"write v1\(r\)"),
        ("0", ["sin(r)"], "the name is taken"),
        ("0", ["v1(x)"], "'x' is not a coordinate"),
        ("0", ["r(r)"], "declared twice"),
        ("0", ["v1(r)", "v1(theta)"], "declared twice"),
        ("0", "v1(r)", "a list of texts"),
        ("0", ["v1"], r"not a function of coordinates; write functions=\[\"v1\(r\)\"\]"),
        ("0", [3], "not a function of coordinates"),
    ],
)
def test_what_is_no_declared_function_is_refused_with_what_to_write(potential, functions, message):
    with pytest.raises(hjsolve.InvalidInputError, match=message):
        system(potential, functions)


def test_numbers_are_refused_in_one_clear_error():
    solution = hjsolve.solve(system("v1(r)", ["v1(r)"]))
    data = {"q": {"r": 1, "theta": 0}, "p": {"r": 0, "theta": 1}}
    for ask in (lambda: solution.motion(**data), lambda: hjsolve.ensemble(solution, **data)):
        with pytest.raises(hjsolve.MissingValueError, match=r"v1\(r\): left undetermined.*write a formula"):
            ask()


def test_the_command_line_and_a_file_declare_functions_too(capsys, tmp_path):
    own = ["--coordinate", "r: 0 < r", "--coordinate", "theta: angle", "-T", KINETIC, "-V", "v1(r)"]
    assert main.main(["solve", *own, "--function", "v1(r)"]) == 0
    assert "v₁" in (out := capsys.readouterr().out) or "v1" in out
    assert main.main(["solve", *own]) == 2
    assert "declare functions" in capsys.readouterr().err
    file = tmp_path / "central.toml"
    file.write_text(
        'id = "central"\ntitle = "Central field"\nkinetic = "(dot(r)**2 + r**2*dot(theta)**2)/2"\n'
        'potential = "v1(r)"\nfunctions = ["v1(r)"]\n'
        'coordinates = [{name = "r", domain = "0 < r"}, {name = "theta", domain = "angle"}]\n'
    )
    assert main.main(["check", str(file)]) == 0
