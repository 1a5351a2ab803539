"""``[[constraint]]`` in files and scenes: eliminated, or refused; an integral that does not belong to its form is."""

from __future__ import annotations

from pathlib import Path

import pytest
import sympy as sp

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.errors import CatalogError

PLANE = """
id = "plane"
title = "Isotropic oscillator on a plane"
coordinates = [
    {name = "x", domain = "line", unit = "m"}, {name = "y", domain = "line", unit = "m"},
    {name = "z", domain = "line", unit = "m"},
]
parameters = [
    {name = "m", value = "1", unit = "kg", assume = "positive"}, {name = "k", value = "4", unit = "N/m", assume = "positive"},
]
units = {t = "s"}
kinetic = "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"
potential = "k/2*(x**2 + y**2 + z**2)"
[initial]
q = {x = "1", y = "0"}
velocity = {x = "0", y = "1"}
"""
TABLE = '[[constraint]]\nform = "2*dot(x) + 3*dot(y) + 4*dot(z)"\nintegral = "2*x + 3*y + 4*z"\nconstant = "0"\n'


def written(folder: Path, more: str, text: str = PLANE) -> Path:
    path = folder / "plane.toml"
    path.write_text(text + more, encoding="utf-8")
    return path


def test_an_integrable_constraint_of_a_file_is_eliminated_and_its_constant_has_its_value(tmp_path: Path) -> None:
    """P2-10 without the drift of the plane: isotropic, so that x(t) = x₀ cos 2t + ẋ₀/2 sin 2t on every plane."""
    system = hjsolve.catalog.load(written(tmp_path, TABLE))
    assert [c.name for c in system.coordinates] == ["x", "y"]
    assert dict(system.eliminated).keys() == {"z"}
    assert {p.name: p.value for p in system.parameters}["c_1"] == 0
    assert (system.id, system.units["x"]) == ("plane", "m")
    motion = hjsolve.solve(system, coordinates="find").motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": 1})
    state = motion.at("0.3")
    assert abs(state.q["x"] - float(sp.cos(sp.Rational(3, 5)).evalf(20))) <= state.error.q["x"] + 1e-16
    assert abs(state.q["y"] - float(sp.sin(sp.Rational(3, 5)).evalf(20) / 2)) <= state.error.q["y"] + 1e-16


@pytest.mark.parametrize(
    ("table", "left"),
    [
        ('[[constraint]]\nform = "x**2 + y**2 + z**2 = 4"\n', ["theta", "phi"]),
        ('[[constraint]]\nform = "z = x**2 + y**2"\ncoordinates = ["x", "y", "z"]\n', ["x", "y"]),
        ('[[constraint]]\nform = "dot(x) - dot(y) + dot(z)"\n', ["x", "y"]),
        ('[[constraint]]\nform = "2*x*dot(x) + dot(z) = 0"\nintegral = "x**2 + z"\n', ["x", "y"]),
        ('[[constraint]]\nform = "y*dot(x) - x*dot(y)"\nintegral = "y/x"\n[[constraint]]\nform = "z = 1"\n', ["x"]),
    ],
    ids=["sphere", "paraboloid", "P4-8", "integral typed", "integrating factor, two constraints"],
)
def test_holonomic_and_integrable_constraints_of_a_file(tmp_path: Path, table: str, left: list[str]) -> None:
    plain = PLANE.split("[initial]", maxsplit=1)[0].replace('unit = "m"', 'meaning = "length"').replace("units =", "# ")
    plain = plain.replace('name = "x", domain = "line"', 'name = "x", domain = "0 < x"') if "y/x" in table else plain
    assert [c.name for c in hjsolve.catalog.load(written(tmp_path, table, plain)).coordinates] == left


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (TABLE.replace('integral = "2*x', 'integral = "x'), r"constraint\[1\].integral: its differential is not prop"),
        (TABLE.replace('integral = "2*x + 3*y + 4*z"', 'integral = "1"'), "it does not vary"),
        (TABLE.replace('integral = "2*x + 3*y + 4*z"\n', ""), "write the integral too"),
        ('[[constraint]]\nform = "y*dot(x) + dot(z)"\n', r"not integrable, since -1/y\*\*2 in Frobenius"),
        ('[[constraint]]\nform = "x = y = z"\n', "one equation is needed"),
        ('[[constraint]]\nform = "dot(w)"\ncoordinates = ["w"]\n', "T and V know no w"),
        ('[[constraint]]\nform = "z = 1"\nintegral = "z"\n', "holds no velocity"),
    ],
    ids=["false integral", "constant integral", "constant alone", "nonholonomic", "two equations", "foreign", "level"],
)
def test_what_cannot_be_eliminated_is_refused_with_the_reason(tmp_path: Path, table: str, message: str) -> None:
    with pytest.raises(CatalogError, match=message):
        hjsolve.catalog.load(written(tmp_path, table))


def test_the_same_tables_in_a_scene_and_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, TABLE)
    assert main(["solve", "--find", str(path)]) == 0
    assert main(["check", str(path)]) == 1  # x and y are coupled: the advice is normal modes
    out = capsys.readouterr().out
    assert "z = ¼ c₁ − ½ x − ¾ y by the constraints" in out
    space = {"coordinates": [{"name": n, "domain": "line"} for n in "xyz"],
             "kinetic": "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", "potential": "z",
             "constraint": [{"form": "x = 2"}, {"form": "dot(w)", "coordinates": ["w"]}]}  # fmt: skip
    scene = {"system": space, "initial": {"q": {"y": "0", "z": "0"}, "velocity": {"y": "1", "z": "0"}}}
    with pytest.raises(CatalogError, match=r"constraint\[2\].form: T and V know no w"):
        hjsolve.Scene.load(scene)
    space["constraint"] = [{"form": "x = 2"}]
    run = hjsolve.Scene.load({**scene, "want": ["trajectory"], "times": ["2"]}).run()
    assert [c.name for c in run.scene.system.coordinates] == ["y", "z"]
    assert abs(run.trajectory.q["z"][0] + 2) <= run.trajectory.error.q["z"][0] + 1e-15
