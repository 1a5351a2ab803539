"""Loading entries: what is accepted, what is refused, and in which words."""

import tomllib
from pathlib import Path

import pytest
import sympy as sp

from hjsolve import catalog
from hjsolve.command_line.main import main
from hjsolve.errors import CatalogError, NotSeparableError

GOOD = """
id = "spring"
title = "Spring"
coordinates = [{name = "x", domain = "line"}]
parameters = [{name = "k", value = "2", assume = "positive"}]
kinetic = "dot(x)**2/2"
potential = "k*x**2/2"
[initial]
q = {x = "1"}
velocity = {x = "0"}
[effects.quartic]
summary = "harder"
potential = "b*x**4"
parameters = [{name = "b", value = "0.1"}]
[expect]
verdict = "liouville"
[[reference]]
quantity = "period.x"
at = {motion = "default"}
value = "4.44288293815836624701588099006"
how = "2*pi/sqrt(2)"
"""


def write(folder: Path, text: str, name: str = "spring") -> Path:
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def fault(folder: Path, text: str) -> list[str]:
    with pytest.raises(CatalogError) as caught:
        catalog.describe(write(folder, text))
    return str(caught.value).replace(str(folder) + "/", "").splitlines()


def test_a_file_of_ones_own_is_an_entry(tmp_path: Path) -> None:
    entry = catalog.describe(write(tmp_path, GOOD))
    assert (entry.id, entry.kind) == ("spring", "separable")
    assert entry.initial is not None
    assert entry.initial.arguments == {"q": {"x": "1"}, "velocity": {"x": "0"}}
    assert entry.references[0].quantity == "period.x"
    assert catalog.load(str(tmp_path / "spring.toml")).title == "Spring"


def test_an_entry_is_frozen(tmp_path: Path) -> None:
    entry = catalog.describe(write(tmp_path, GOOD))
    with pytest.raises(AttributeError):
        entry.title = "other"  # type: ignore[misc]


FAULTS = {
    "an unknown key names the nearest one": ("title =", "titel =", 'titel: unknown key; did you mean "title"?'),
    "an unknown key deep inside says where": ('assume = "p', 'asume = "p', "parameters[1].asume: unknown key"),
    "a wrong type": ('title = "Spring"', "title = 3", "title: must be a text, not an integer (3)"),
    "a wrong type of a list": ('[{name = "x", domain = "line"}]', '"x"', "coordinates: must be a list of tables, not a text (x); write coordinates = [{name = \"r\""),
    "true is not a number": ('value = "2"', "value = true", "parameters[1].value: must be a number"),
    "a missing field": ('kinetic = "dot(x)**2/2"\n', "", "kinetic: missing; it must be a text"),
    "an unknown assumption": ('"positive"', '"positiv"', '"positiv" is not known; did you mean "positive"?'),
    "an unparsable formula names the file and the key": ("k*x**2/2", "k*x**", "spring.toml: potential"),
    "an undeclared name": ("k*x**2/2", "q*x**2/2", "potential"),
    "an unparsable number": ('q = {x = "1"}', 'q = {x = "one"}', "initial.q.x"),
    "an unknown coordinate": ('q = {x = "1"}', 'q = {xx = "1"}', 'initial.q: no coordinate "xx"'),
    "a coordinate without a value": ('q = {x = "1"}', "q = {}", "initial.q.x: missing"),
    "neither velocity nor p": ('velocity = {x = "0"}', "", "initial: give velocity or p, one of the two"),
    "velocity and p": ('velocity = {x = "0"}', 'velocity = {x = "0"}\np = {x = "0"}', "one of the two"),
    "an unknown parameter": ('q = {x = "1"}', 'q = {x = "1"}\nparameters = {z = "1"}', 'no parameter "z"'),
    "an unknown kind": ('q = {x = "1"}', 'q = {x = "1"}\nkinds = {x = "liberation"}', 'did you mean "libration"?'),
    "an unknown quantity": ('"period.x"', '"periode.x"', '"periode.x" is not known'),
    "a quantity of no coordinate": ('"period.x"', '"period.y"', 'no coordinate "y"'),
    "a state without a time": ('"period.x"', '"q.x"', "needs a time t"),
    "a period with a time": ('motion = "default"', 'motion = "default", t = "1"', "must not have a time t"),
    "an unknown motion": ('motion = "default"', 'motion = "fast"', 'no motion "fast"'),
    "an effect whose term does not parse": ("b*x**4", "b*x**4)", "effects.quartic"),
    "an effect without a term": ('potential = "b*x**4"\n', "", "needs a term"),
    "an effect that brings a parameter twice": ('{name = "b",', '{name = "k",', '"k" is declared twice'),
    "the same coordinate twice": ('[{name = "x", domain = "line"}]',
                                  '[{name = "x", domain = "line"}, {name = "x", domain = "line"}]', "declared twice"),
    "a verdict nobody knows": ('verdict = "liouville"', 'verdict = "Liouville"', 'did you mean "liouville"?'),
    "a refusal without words": ('verdict = "liouville"', 'verdict = "refused"', "reason, instead"),
    "not TOML": ("title =", "title", "not TOML"),
    "an integer of thousands of digits": ('value = "2"', f"value = {'9' * 5000}", "an integer of thousands of digits"),
    "a value of more than a thousand digits": ('value = "2"', f'value = "{"9" * 1001}"', "at most 1000 are accepted"),
    "a value that is not finite": ('value = "2"', "value = inf", "one finite real number"),
    "a value against its assumption": ('value = "2"', 'value = "-2"', "it must be positive"),
    "lists nested beyond reason": ('title = "Spring"', "title = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
    "a domain that makes no sense": ('domain = "line"', 'domain = "circle"', "spring.toml:"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_in_one_line(tmp_path: Path, name: str) -> None:
    old, new, expected = FAULTS[name]
    assert GOOD.count(old) >= 1
    lines = fault(tmp_path, GOOD.replace(old, new, 1))
    assert any(expected in line for line in lines), lines
    assert all(line.startswith("spring.toml: ") for line in lines)


@pytest.mark.parametrize("name", FAULTS)
def test_the_command_line_ends_with_status_2(tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    old, new, _ = FAULTS[name]
    file = write(tmp_path, GOOD.replace(old, new, 1))
    assert main(["catalog", "check", str(file)]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.startswith("hjsolve: ")
    assert "Traceback" not in err


def test_every_fault_has_its_own_line(tmp_path: Path) -> None:
    text = GOOD.replace("title =", "titel =").replace('assume = "positive"', 'asume = "positive"')
    assert len(fault(tmp_path, text)) == 3


def test_no_such_entry_names_the_nearest() -> None:
    with pytest.raises(CatalogError, match=r'no catalog entry "kepler-plannar"; did you mean "kepler-planar"\?'):
        catalog.load("kepler-plannar")


@pytest.mark.parametrize("name", ["../systems/pendulum", "", "/", "systems/pendulum", "no such.toml", "x" * 5000])
def test_an_id_is_not_a_path(name: str) -> None:
    with pytest.raises(CatalogError):
        catalog.load(name)


def test_a_folder_and_a_file_that_is_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    for name, expected in (("folder", "not a regular file"), ("bytes", "not UTF-8")):
        with pytest.raises(CatalogError, match=expected):
            catalog.load(tmp_path / f"{name}.toml")


def test_a_decimal_written_without_quotes_is_that_decimal(tmp_path: Path) -> None:
    system = catalog.load(write(tmp_path, GOOD.replace('value = "2"', "value = 0.1")))
    assert system.parameters[0].value == sp.Rational(1, 10)


def test_a_parameter_needs_no_value(tmp_path: Path) -> None:
    assert catalog.load(write(tmp_path, GOOD.replace('value = "2", ', ""))).parameters[0].value is None


def test_an_effect_is_absent_until_it_is_called_for() -> None:
    plain, with_b = catalog.load("kepler-planar"), catalog.load("kepler-planar", effects=["precession"])
    assert [p.name for p in plain.parameters] == ["m", "k"]
    assert [p.name for p in with_b.parameters] == ["m", "k", "b"]
    r, b = with_b.symbols["r"], with_b.symbols["b"]
    assert with_b.potential - plain.potential == -b / r**2
    assert with_b.kinetic == plain.kinetic


def test_several_effects_add_up_and_a_repeated_one_counts_once() -> None:
    system = catalog.load("kepler-planar", effects=["precession", "magnetic-field", "precession"])
    assert [p.name for p in system.parameters] == ["m", "k", "b", "w"]
    assert system.id == "kepler-planar+precession+magnetic-field"


def test_an_unknown_effect_names_the_nearest() -> None:
    with pytest.raises(CatalogError, match=r'no effect "precesion"; did you mean "precession"\?'):
        catalog.load("kepler-planar", effects=["precesion"])


def test_an_inline_table_is_a_system() -> None:
    table = tomllib.loads(GOOD)
    inline = {key: table[key] for key in ("coordinates", "parameters", "kinetic", "potential")}
    assert catalog.from_table(inline).potential == catalog.from_table(table).potential


@pytest.mark.parametrize("table", [{}, {"kinetic": "1"}, {"coordinates": [], "kinetic": 3}])
def test_an_inline_table_with_faults_names_them(table: dict[str, object]) -> None:
    with pytest.raises(CatalogError, match=r"^scene\.toml: "):
        catalog.from_table(table, source="scene.toml")


def test_listing_separates_the_refused_from_the_rest() -> None:
    kinds = ("separable", "extended", "refused", "outside")
    assert catalog.ids() == tuple(name for kind in kinds for name in catalog.ids(kind))
    assert "double-pendulum" in catalog.ids("refused")
    assert list(catalog.titles()) == list(catalog.ids())
    with pytest.raises(CatalogError, match="separable"):
        catalog.ids("separabel")


@pytest.mark.parametrize("name", catalog.ids())
def test_every_entry_of_the_catalog_follows_the_schema(name: str) -> None:
    entry = catalog.describe(name)
    assert entry.id == name
    assert name in catalog.ids(entry.kind)
    assert (entry.initial is None) == (entry.kind == "outside") == (entry.system is entry.hamiltonian is None)


@pytest.mark.parametrize("name", catalog.ids("outside"))
def test_a_system_that_is_no_t_and_v_answers_with_its_reason(name: str) -> None:
    entry = catalog.describe(name)
    with pytest.raises(NotSeparableError, match=entry.refusal.kind) as caught:  # type: ignore[union-attr]
        catalog.load(name)
    assert caught.value.verdict == entry.refusal
    assert entry.reason in str(caught.value)
    assert entry.instead in str(caught.value)


def test_a_refusal_without_words_or_constraint_is_told(tmp_path: Path) -> None:
    text = 'id = "spring"\ntitle = "x"\n[refused_because]\nkind = "nonholonomic"\n'
    assert fault(tmp_path, text) == [
        "spring.toml: reason, instead: a refused entry says why, and what to do",
        "spring.toml: constraint: missing; a nonholonomic entry states its constraint",
    ]
    assert 'did you mean "nonholonomic"' in fault(tmp_path, text.replace("nonholonomic", "nonholonom"))[0]
    assert "needs T" in fault(tmp_path, text.replace("nonholonomic", "gyroscopic"))[0]


def test_an_integrable_constraint_is_no_reason_to_refuse(tmp_path: Path) -> None:
    text = """id = "spring"\ntitle = "x"\nreason = "a."\ninstead = "b."\n[refused_because]\nkind = "nonholonomic"
[[constraint]]\nform = "dot(x) - 1"\ncoordinates = ["x"]\nintegral = "x - t"\n"""
    assert "integrate it" in fault(tmp_path, text)[0]


HAMILTONIAN = """
id = "spring"
title = "Spring"
coordinates = [{name = "x", domain = "line"}]
parameters = [{name = "k", value = "2", assume = "positive"}]
hamiltonian = "p**2/2 + k*x**2/2"
[initial]
q = {x = "1"}
p = {x = "0"}
"""


def test_an_entry_may_give_a_hamiltonian(tmp_path: Path) -> None:
    """Quadratic in p it is a system; linear in p it is solved as it stands."""
    quadratic = write(tmp_path, HAMILTONIAN)
    assert catalog.hamiltonian(quadratic) is None
    assert catalog.describe(quadratic).hamiltonian is None
    system = catalog.load(quadratic)
    x = system.coordinate("x")
    assert sp.expand(system.kinetic - x.velocity**2 / 2) == 0
    assert sp.expand(system.potential - system.symbols["k"] * x.symbol**2 / 2) == 0
    linear = write(tmp_path, HAMILTONIAN.replace("p**2/2", "p"))
    problem = catalog.hamiltonian(linear)
    assert problem is not None
    assert (problem.id, problem.rate) == ("spring", 1)
    entry = catalog.describe(linear)
    assert (entry.system, entry.hamiltonian) == (None, problem)
    with pytest.raises(CatalogError, match=r"spring\.toml: hamiltonian: linear in p"):
        catalog.load(linear)


@pytest.mark.parametrize(("old", "new", "expected"), [
    ("p**2/2 +", "p**3/2 +", "first or second degree"), ("p**2/2 +", "p**2/2 + z +", "z"),
    ('hamiltonian = "p**2', 'kinetic = "dot(x)**2/2"\nhamiltonian = "p**2', "kinetic: belongs to T and V"),
    ('p = {x = "0"}', 'velocity = {x = "0"}', "initial: give p"),
    ('"line"}]', '"line"}, {name = "y", domain = "line"}]', "the momenta are p_x, p_y, not p"),
    ("hamiltonian = ", "hamiltonain = ", 'did you mean "hamiltonian"?'),
])  # fmt: skip
def test_a_fault_of_a_hamiltonian_is_told_in_one_line(tmp_path: Path, old: str, new: str, expected: str) -> None:
    lines = fault(tmp_path, HAMILTONIAN.replace(old, new, 1))
    assert any(expected in line for line in lines), lines
    assert all(line.startswith("spring.toml: ") for line in lines)
