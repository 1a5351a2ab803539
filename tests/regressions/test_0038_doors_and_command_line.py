"""Every verb takes an id; Greek letters, titles and assumptions are typed; the catalog is searched; advice names the tool."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import hjsolve
from hjsolve import catalog
from hjsolve.command_line.main import main

pytestmark = pytest.mark.rotating_file(2)

Capture = pytest.CaptureFixture[str]
KEPLER = catalog.load("kepler-planar")


# ------------------------------------------------------------------------------------------------ ids
def test_every_verb_takes_an_id_a_file_or_a_system() -> None:
    file = Path(__file__).resolve().parents[2] / "catalog" / "systems" / "kepler-planar.toml"
    for named in ("kepler-planar", file, str(file), KEPLER):
        assert hjsolve.solve(named).system == KEPLER
        assert isinstance(hjsolve.separate(named), hjsolve.Separation)
        assert hjsolve.ensemble(named, q={"r": [1.0], "theta": [0.0]}, p={"r": [0.0], "theta": [1.0]}).status[0] == "ok"
    assert hjsolve.find_coordinates("henon-heiles").system.id == "henon-heiles"
    assert len(hjsolve.normal_modes("anisotropic-oscillator").modes) == 3
    assert hjsolve.gyroscopic_modes("gyroscopic-pair").system.id == "gyroscopic-pair"


@pytest.mark.parametrize("verb", ["solve", "separate", "find_coordinates", "normal_modes", "gyroscopic_modes"])
@pytest.mark.parametrize(
    ("subject", "says"),
    [("keplr-planar", 'did you mean "kepler-planar"'), (3, "the id of a catalog entry"), (None, "a System is needed"),
     ("missing.toml", "missing.toml")],
)  # fmt: skip
def test_what_is_no_system_is_refused_in_one_line(verb: str, subject: object, says: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=says):
        getattr(hjsolve, verb)(subject)


def test_an_unknown_id_is_no_wall_of_text() -> None:
    with pytest.raises(hjsolve.InvalidInputError) as caught:
        hjsolve.solve("qqqq")
    assert len(str(caught.value)) < 400


def test_an_entry_that_is_no_system_says_why() -> None:
    with pytest.raises(hjsolve.NotSeparableError, match="nonholonomic") as caught:
        hjsolve.solve("skate")
    assert caught.value.verdict.kind == "nonholonomic"


def test_cost_takes_a_system_and_its_solution() -> None:
    for subject in (catalog.load("harmonic-oscillator"), hjsolve.solve("harmonic-oscillator")):
        table = hjsolve.cost(subject, seconds=1, digits=(20,), repeats=1, rivals=False)
        assert table.id == "harmonic-oscillator"
        assert table.of("float64")[0].held
    own = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4")
    with pytest.raises(hjsolve.MissingValueError, match=r"give a motion, hjsolve.cost"):
        hjsolve.cost(own)


def test_a_scene_takes_a_system_of_ones_own() -> None:
    own = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "x**2/2", {"m": 4})
    scene = hjsolve.Scene.load({"system": own, "initial": {"q": {"x": 1}, "velocity": {"x": 0}}, "want": ["periods"]})
    assert scene.run().quantity("periods")["x"].value == pytest.approx(4 * 3.141592653589793, rel=1e-14)
    assert hjsolve.Scene.load(catalog.load("pendulum")).initial is not None
    assert hjsolve.Scene.load("pendulum").system == catalog.load("pendulum")


@pytest.mark.entries
@pytest.mark.parametrize("name", [n for n in catalog.ids() if n not in catalog.ids("outside")][::3])
def test_a_system_and_its_table_are_the_same_system(name: str) -> None:
    if catalog.hamiltonian(name) is not None:
        return
    system = catalog.load(name)
    other = catalog.from_table(catalog.table_of(system))
    assert (other.kinetic - system.kinetic).expand().simplify() == 0
    assert other.potential.equals(system.potential)
    assert (other.coordinates, other.parameters, other.signature, other.relativity, other.id) == (
        system.coordinates, system.parameters, system.signature, system.relativity, system.id,
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------ what is typed
def test_greek_letters_are_names() -> None:
    spelled = hjsolve.System(
        {"theta": "-pi < theta < 2*pi/3"}, "m*dot(theta)**2/2", "-lam*cos(theta)", {"m": 1, "lam": 2}
    )
    typed = hjsolve.System({"θ": "-π < θ < 2*π/3"}, "m*dot(θ)**2/2", "-λ*cos(θ)", {"m": 1, "λ": 2})
    assert typed == spelled
    motion = hjsolve.solve(typed).motion(q={"θ": 1}, velocity={"θ": 0}, parameters={"λ": 3})
    assert motion.kinds == {"theta": "libration"}


@pytest.mark.parametrize(
    ("typed", "spelled"),
    [("θ", "theta"), ("θ1", "theta1"), ("p_φ", "p_phi"), ("Ω", "Omega"), ("ϕ", "phi"), ("µ", "mu"), ("λ_2", "lam_2"),
     ("Λ", "Lambda"), ("x", "x"), ("ж", "ж")],
)  # fmt: skip
def test_each_letter_has_one_name(typed: str, spelled: str) -> None:
    from hjsolve.arguments import ascii_name

    assert ascii_name(typed) == spelled


def test_a_name_given_twice_in_two_scripts_is_seen(capsys: Capture) -> None:
    given = ["--coordinate", "θ: angle", "--coordinate", "theta: angle", "-T", "dot(θ)**2/2"]
    assert main(["check", *given]) == 2
    assert "given twice" in capsys.readouterr().err


@pytest.mark.nightly
def test_titles_and_assumptions_are_typed(tmp_path: Path, capsys: Capture) -> None:
    own = ["--title", "My swing, T = m*l**2/2", "--coordinate", "θ: angle", "-T", "m*l**2/2*dot(θ)**2",
           "-V", "-m*g*l*cos(θ)", "--parameter", "m=1:positive", "--parameter", "l:positive", "--parameter", "g=9.81"]  # fmt: skip
    assert main(["check", *own]) == 0
    assert capsys.readouterr().out.startswith("My swing, T = m l²/2\n")
    assert main(["report", *own, "-o", str(tmp_path / "own.json")]) == 0
    page = json.loads((tmp_path / "own.json").read_text(encoding="utf-8"))
    assert page["title"] == "My swing, T = m l²/2"
    table = next(b for b in page["sections"]["system"]["blocks"] if b.get("caption") == "Parameters")
    assert [row[2] for row in table["rows"]] == ["positive", "positive", "real"]


@pytest.mark.parametrize("text", ["m=1:", "m:strange", "m=-1:positive", ":positive"])
def test_an_assumption_that_makes_no_sense_is_one_line(text: str, capsys: Capture) -> None:
    assert main(["check", "--coordinate", "x: line", "-T", "m*dot(x)**2/2", "--parameter", text]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_the_bare_command_shows_its_help(capsys: Capture) -> None:
    assert main([]) == 2
    assert "examples:" in capsys.readouterr().out


# ------------------------------------------------------------------------------------------------ the catalog
def test_the_catalog_is_searched(capsys: Capture) -> None:
    assert main(["catalog", "search", "black hole"]) == 0
    out = capsys.readouterr().out
    assert {line.split()[0] for line in out.splitlines() if line.startswith("  ")} == {"kerr", "schwarzschild"}
    assert main(["catalog", "search", "Hénon"]) == 0
    assert "henon-heiles" in capsys.readouterr().out
    assert main(["catalog", "search", "carter", "--kind", "refused"]) == 1
    assert main(["catalog", "search"]) == 2


def test_the_catalog_module_lists_what_is_public() -> None:
    assert not {"Any", "Mapping", "Path", "Traversable", "annotations", "schema"} & set(dir(catalog))
    assert {"load", "ids", "describe", "titles"} <= set(dir(catalog))
    assert all(hasattr(catalog, name) for name in dir(catalog))


def test_catalog_show_gives_whole_references(capsys: Capture) -> None:
    assert main(["catalog", "show", "kerr"]) == 0
    assert "Global structure of the Kerr family" in " ".join(capsys.readouterr().out.split())


# ------------------------------------------------------------------------------------------------ advice and speed
@pytest.mark.parametrize("name", ["gyroscopic-pair", "gyroscopic-three"])
def test_linear_modes_are_named_where_they_are_the_answer(name: str, capsys: Capture) -> None:
    assert main(["check", name]) == 1
    assert "hjsolve.gyroscopic_modes" in capsys.readouterr().out
    assert hjsolve.gyroscopic_modes(name).polynomial is not None


def test_they_are_not_named_where_they_would_refuse() -> None:
    kinetic = "(dot(x)**2 + dot(y)**2)/2 + B*(x*dot(y) - y*dot(x))"
    for potential, named in (("x*y", True), ("x*y + g*y", True), ("x*y + x**4", False)):
        system = hjsolve.System({"x": "line", "y": "line"}, kinetic, potential, {"B": 1, "g": 1})
        assert ("gyroscopic_modes" in hjsolve.separate(system).advice) == named


def test_a_wrong_output_is_told_before_anything_heavy_is_loaded() -> None:
    code = (
        "import sys\nfrom hjsolve.command_line.main import main\nstatus = main(['report', 'kepler-planar', '-o', 'x.doc'])\n"
        "print(status, 'sympy' in sys.modules, 'numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["2", "False", "False"]
