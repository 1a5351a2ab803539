"""What is typed and would not be used is an error: constraints, keys of scenes and entries, options, keywords."""

from __future__ import annotations

from pathlib import Path

import pytest

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.errors import CatalogError, InvalidInputError, InvalidSystemError

SPRING = """
id = "spring"
title = "an isotropic oscillator in the plane"
coordinates = [{name = "x", domain = "line"}, {name = "y", domain = "line"}]
parameters = [{name = "m", value = "1"}, {name = "w", value = "1"}]
kinetic = "m/2*(dot(x)**2 + dot(y)**2)"
potential = "x**2 + y**2"
"""
START = {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0", "theta": "1.2"}}


def entry(folder: Path, more: str, text: str = SPRING) -> Path:
    path = folder / "spring.toml"
    path.write_text(text + more, encoding="utf-8")
    return path


def constraint(form: str, integral: str, names: str = '["x", "y"]') -> str:
    return f'[[constraint]]\nform = "{form}"\ncoordinates = {names}\nintegral = "{integral}"\n'


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (constraint("2*dot(x) + 3*dot(y)", "x"), "its differential is not proportional to the form"),
        (constraint("2*dot(X)", "2*X", '["X"]'), "T and V know no X; choose coordinates in which it holds"),
        (constraint("dot(x) - dot(y)", ""), "constraint.1..integral: the text is empty"),
        (
            '[stated]\nmap = {X = "x + w*t"}\n' + constraint("dot(X) - m", "X - m*t", '["X"]'),
            "the constraint does not hold",
        ),
        (
            '[refused_because]\nkind = "dissipative"\nforces = {x = "-dot(x)"}\n',
            "T and V do not hold what is .dissipative",
        ),
        ('[refused_because]\nkind = "gyroscopic"\nforces = {x = "-dot(x)"}\n', "T and V do not hold them"),
    ],
)
def test_a_file_whose_T_and_V_do_not_obey_what_it_says_is_refused_by_every_reader(tmp_path, more, message, capsys):
    path = entry(tmp_path, more)
    for read in (hjsolve.catalog.load, hjsolve.catalog.describe, hjsolve.separate, hjsolve.solve):
        with pytest.raises(CatalogError, match=message):
            read(path)
    with pytest.raises(CatalogError, match=message):
        hjsolve.Scene.load({"system": str(path)})
    assert main(["check", str(path)]) == 2
    assert main(["motion", str(path), "--q", "x=1", "y=1", "--velocity", "x=0", "y=0"]) == 2
    assert "Separates" not in capsys.readouterr().out


def test_a_constraint_that_the_coordinates_obey_is_proved_and_accepted(tmp_path):
    text = SPRING.replace('{name = "y", domain = "line"}]', "]").replace(", ]", "]").replace("+ dot(y)**2", "")
    stated = '[stated]\nmap = {X = "3*x + t", Y = "-2*x"}\n'
    more = stated + constraint("2*dot(X) + 3*dot(Y) - 2", "2*X + 3*Y - 2*t", '["X", "Y"]')
    assert hjsolve.catalog.load(entry(tmp_path, more, text.replace(" + y**2", ""))).coordinates
    false = more.replace('"2*X + 3*Y - 2*t"', '"X"')
    with pytest.raises(CatalogError, match="the rate of the integral is"):
        hjsolve.catalog.load(entry(tmp_path, false, text.replace(" + y**2", "")))


def test_a_constraint_given_to_a_system_is_used_or_refused():
    system = hjsolve.System({"x": "line", "y": "line"}, "x'^2/2 + y'^2/2", constraints=["x = y"])
    assert [c.name for c in system.coordinates] == ["x"]
    with pytest.raises(InvalidSystemError, match=r"constraints\[1\]: not solved"):
        hjsolve.System({"x": "line", "y": "line"}, "x'^2/2 + y'^2/2", constraints=["x*y = 1"])


@pytest.mark.parametrize("key", ['functions = ["f(q)"]', 'place = {x = "q"}', 'units = {q = "m"}'])
def test_keys_of_T_and_V_beside_a_hamiltonian_are_refused(tmp_path, key):
    text = 'id = "spring"\ntitle = "H"\nhamiltonian = "p_q + q"\ncoordinates = [{name = "q", domain = "line"}]\n'
    with pytest.raises(CatalogError, match="belongs to T and V"):
        hjsolve.catalog.hamiltonian(entry(tmp_path, key, text))


KICK = {"kind": "impulse", "momentum": {"r": "1"}}
SCENES = [
    ({"want": ["periods"], "times": ["1", "2"]}, "times: nothing wanted depends on them"),
    ({"velocity_frame": "orthonormal"}, "velocity_frame: it says what the velocities in initial or sweep mean"),
    (
        {"want": ["trajectory"], "times": ["1"], "events": [{**KICK, "at": {"t": "1", "passage": 3}}]},
        "at.passage: belongs to a coordinate",
    ),
]


@pytest.mark.parametrize(("keys", "message"), SCENES)
def test_a_key_of_a_scene_that_nothing_uses_is_refused(keys, message):
    with pytest.raises(CatalogError, match=message):
        hjsolve.Scene.load({"system": "kepler-planar", **keys})


def test_keywords_of_a_report_and_of_a_cost_that_nothing_uses_are_refused(tmp_path):
    scene = hjsolve.Scene.load({"system": "kepler-planar"})
    motion = hjsolve.solve("kepler-planar").motion(**START)
    line, path = hjsolve.System({"x": "line"}, "x'^2/2", "x^2"), tmp_path / "report.txt"
    cases = [
        (scene, {"initial": START}), (scene, {"motion": "hyperbolic"}), (scene, {"digits": 30}), (scene, {"brief": True}),
        (motion, {"initial": START}), (motion, {"motion": "hyperbolic"}), (motion, {"digits": 30}),
        ("kepler-planar", {"initial": START, "motion": "hyperbolic"}), (line, {"motion": "hyperbolic"}),
        ("skate", {"initial": START}), ("hamiltonian-q-plus-p", {"cost": True}),
    ]  # fmt: skip
    for subject, keywords in cases:
        with pytest.raises(InvalidInputError, match="is not used, because"):
            hjsolve.report(subject, path, **keywords)
    with pytest.raises(InvalidInputError, match="motion: is not used"):
        hjsolve.cost(motion, motion="hyperbolic", seconds=0.1)
    assert not path.exists()


SCENE = str(Path(__file__).parents[2] / "scenes" / "precessing-ellipse.toml")
FREE = ["--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**2"]
AT = ["--q", "r=1,theta=0", "--velocity", "r=0,theta=1"]
OPTIONS = [
    ["check", "kepler-planar", "--parameter", "zzz=5"],
    ["solve", "kepler-planar", "--parameter", "zzz=5"],
    ["coordinates", "kepler-planar", "--parameter", "zzz=5"],
    ["check", "kepler-planar", "--title", "X"],
    ["check", SCENE, "--title", "X"],
    ["cost", "kepler-planar", "--title", "X"],
    ["motion", "kepler-planar", "--motion", "hyperbolic", *AT],
    ["motion", SCENE, "--digits", "30"],
    ["motion", SCENE, "--motion", "hyperbolic"],
    ["motion", SCENE, "--find"],
    ["report", SCENE, "--find", "-o", "-"],
    ["report", SCENE, "--slider", "k", "-o", "-"],
    ["report", SCENE, "--brief", "-o", "-"],
    ["report", "hamiltonian-q-plus-p", "--find", "-o", "-"],
    ["report", "hamiltonian-q-plus-p", "--brief", "-o", "-"],
    ["report", "skate", *AT, "-o", "-"],
    ["report", *FREE, "--motion", "hyperbolic", "-o", "-"],
    ["motion", *FREE, "--motion", "hyperbolic", "--q", "x=1", "--velocity", "x=0"],
    ["cost", SCENE, "--motion", "hyperbolic"],
    ["check", "hamiltonian-q-plus-p", "--parameter", "zzz=5"],
]


@pytest.mark.parametrize("arguments", OPTIONS, ids=" ".join)
def test_an_option_that_nothing_uses_is_bad_input(arguments, capsys):
    assert main(arguments) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert len(told.err.splitlines()) == 1
