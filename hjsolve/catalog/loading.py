"""The catalog: mechanical systems as data, each with its literature, initial data, effects and reference values.

An entry is one TOML file (catalog/README.md). Loading checks it once and gives frozen values; a user's own file and an
inline ``[system]`` table are read in the same way.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from hjsolve.catalog import outside as refusals
from hjsolve.catalog import schema, toml_file
from hjsolve.catalog.constraints import constraint_faults, to_eliminate
from hjsolve.catalog.cross_checks import form_faults, motion_faults, reference_faults
from hjsolve.catalog.effects import forces, with_effects
from hjsolve.catalog.entry import Effect as Effect
from hjsolve.catalog.entry import Entry as Entry
from hjsolve.catalog.entry import InitialData as InitialData
from hjsolve.catalog.entry import Reference as Reference
from hjsolve.catalog.toml_file import Toml, TomlTable
from hjsolve.display.first_lines import few_lines
from hjsolve.errors import CatalogError, InvalidInputError, NotSeparableError
from hjsolve.extended.linear_hamiltonian import (
    GeneralHamiltonian,
    HamiltonianInTime,
    LinearHamiltonian,
    SumOfHamiltonians,
    from_hamiltonian,
)
from hjsolve.formulas.tokens import printable
from hjsolve.mechanics.system import Parameter, System, parameter
from hjsolve.precision import one_at_a_time

_FOLDERS = {"separable": "systems", "extended": "extended", "refused": "refused", "outside": "outside"}
_ENTRY = schema.ENTRY | refusals.KEYS


def ids(kind: str | None = None) -> tuple[str, ...]:
    """List the catalog: the separable systems first, then the refused ones, then those that are no T and V.

    Args:
        kind: ``separable``, ``extended``, ``refused``, ``outside`` or None for all.

    Raises:
        CatalogError: another kind.
    """
    if kind is not None and kind not in _FOLDERS:
        raise CatalogError(f'kind: "{kind}" is not known{schema.nearest(kind, _FOLDERS)}')
    kinds = [kind] if kind else list(_FOLDERS)
    return tuple(name for k in kinds for name in sorted(f.name.removesuffix(".toml") for f in _toml_files(k)))


def titles(*, book: str | None = None) -> dict[str, str]:
    """Give the title of every entry by its id, without building any system.

    Args:
        book: only the entries that are this row of the table of Greenwood's systems, such as ``C28``.
    """
    tables = {name: toml_file.exact_table(*_locate(name)) for name in ids()}
    return {n: str(t["title"]) for n, t in tables.items() if book is None or book in t.get("book", ())}


def kind_of(entry: str) -> str:
    """Give the kind of an entry of the catalog: ``separable``, ``extended``, ``refused`` or ``outside``.

    Args:
        entry: its id.
    """
    return next(kind for kind in _FOLDERS if entry in ids(kind))


@one_at_a_time
def load(entry: str | Path, *, effects: Iterable[str] = ()) -> System:
    """Give the system of a catalog entry or of a TOML file, with some of its effects switched on.

    Args:
        entry: an id such as ``kepler-planar``, or the path of a ``.toml`` file of the same format.
        effects: names of its effects; their terms are added to T and V, their parameters to the system's.

    Returns:
        The system; refused entries load too, so that ``separate`` can say why.

    Raises:
        CatalogError: no such entry or effect, or a file that does not follow the schema; one line for every fault.
        NotSeparableError: the entry is outside of what T and V can say; its verdict is the ``Refusal``.

    Example:
        >>> [c.name for c in load("kepler-planar").coordinates]
        ['r', 'theta']
    """
    table, source = read(entry)
    outside = refusals.refusal(table)
    if outside is not None:
        raise NotSeparableError(str(outside), outside)
    for name in (names := tuple(effects)):
        if table.get("effects", {}).get(name, {}).get("force"):
            raise CatalogError(
                f'{source}: "{name}" is a force that no T and V contain; use it in a scene with method = "integrate"'
            )
    return from_table(with_effects(table, names, source), source=source)


def describe(entry: str | Path) -> Entry:
    """Give everything an entry holds.

    Args:
        entry: an id, or the path of a ``.toml`` file.

    Returns:
        The entry, its system built without effects.

    Raises:
        CatalogError: as ``load``; here initial data, effects, motions and references are checked as well.
    """
    table, source = read(entry)
    outside = refusals.refusal(table)
    built = None if outside else _built(table, source)
    problems = list(_entry_faults(table, built) if built else ())
    if problems:
        raise _refused(source, problems)
    tables = {"default": table["initial"]} if "initial" in table else {}
    motions = {name: InitialData(name=name, **data) for name, data in {**tables, **table.get("motions", {})}.items()}
    expect = table.get("expect", {})
    return Entry(
        id=table["id"], title=table["title"], summary=table.get("summary", ""),
        system=built if isinstance(built, System) else None,
        hamiltonian=built if isinstance(built, LinearHamiltonian) else None,
        kind="extended" if table["id"] in ids("extended") else _kind(expect, outside), refusal=outside,
        constraints=refusals.constraints(table), stated=refusals.stated(table),
        initial=motions.get("default"), motions=motions, effects=_effects(table), expect=expect,
        references=tuple(_reference(r) for r in table.get("reference", [])),
        cite=tuple(table.get("cite", ())), book=tuple(table.get("book", ())),
        meanings={c["name"]: (c.get("unit", ""), c.get("meaning", "")) for c in table.get("coordinates", [])},
        reason=table.get("reason", ""), instead=table.get("instead", ""),
    )  # fmt: skip


def from_table(table: Toml, *, source: str = "system") -> System:
    """Build a system from an inline ``[system]`` table or the table of an entry.

    Args:
        table: keys ``coordinates``, ``kinetic`` and, where wanted, ``potential``, ``parameters``, ``signature``,
            ``title``, ``id``; the further keys of an entry are allowed and not looked at.
        source: what the table is called in errors, e.g. a file name.

    Raises:
        CatalogError: one line for every fault: the source, the key, what is wrong and what to write instead.
    """
    built = _built(table, source)
    if isinstance(built, LinearHamiltonian):
        raise CatalogError(
            f"{source}: hamiltonian: linear in p, so there are no T and V; use hjsolve.from_hamiltonian, or for an "
            "entry hjsolve.catalog.hamiltonian"
        )
    return built


def entry_of(system: System) -> Entry | None:
    """Give the entry a system was loaded from; None where it has none or was changed since.

    Args:
        system: any system.
    """
    if not system.id or system.id not in ids():
        return None
    entry = describe(system.id)
    return entry if entry.system == system else None


def table_of(system: System) -> TomlTable:
    """Give a system as the table ``[system]`` that ``from_table`` reads back.

    Args:
        system: any system.

    Example:
        >>> from_table(table_of(load("kepler-planar"))) == load("kepler-planar")
        True
    """
    table: TomlTable = {
        "coordinates": [{"name": c.name, "domain": c.domain.written(c.name)} for c in system.coordinates],
        "kinetic": str(system.kinetic), "potential": str(system.potential),
        "parameters": [
            {"name": p.name, "assume": p.assume, "unit": p.unit, "meaning": p.meaning}
            | ({} if p.value is None else {"value": str(p.value)})
            for p in system.parameters
        ],
        "signature": system.signature, "title": system.title, "id": system.id,
    }  # fmt: skip
    if system.places:
        table["place"] = {axis: str(formula) for axis, formula in system.places}
    named = {p.name: p.unit for p in system.parameters}
    if units := {name: unit for name, unit in system.declared_units if named.get(name) != unit}:
        table["units"] = units
    if system.relativity is not None:
        table["relativity"] = {"mass": str(system.relativity.mass), "light": str(system.relativity.light)}
    return {key: value for key, value in table.items() if value not in ("", [])}


def hamiltonian(entry: str | Path) -> LinearHamiltonian | None:
    """Give the solved H(q, p) of an entry that gives one, linear in p; None for an entry with T and V.

    Args:
        entry: id, or path of a .toml file.

    Raises:
        CatalogError: as ``load``.

    Example:
        >>> hamiltonian("hamiltonian-q-plus-p").principal_function
        E*q - E*t - q**2/2
    """
    table, source = read(entry)
    built = _built(table, source) if "hamiltonian" in table else None
    return built if isinstance(built, LinearHamiltonian) else None


def _built(table: Toml, source: str) -> System | LinearHamiltonian:
    own = {key: value for key, value in table.items() if key not in _ENTRY or key in schema.SYSTEM}
    keys = schema.optional(schema.SYSTEM, "kinetic") if "hamiltonian" in own else schema.SYSTEM
    problems = list(schema.faults(own, keys)) or list(form_faults(own))
    if not problems:
        problems = [f for k in ("coordinates", "parameters") for f in schema.repeated(own.get(k, []), k)]
    problems = problems or list(constraint_faults(table))
    if problems:
        raise _refused(source, problems)
    try:
        coordinates = {c["name"]: c["domain"] for c in own["coordinates"]}
        parameters = {p["name"]: _parameter(p) for p in own.get("parameters", [])}
        if "hamiltonian" in own:
            found = from_hamiltonian(
                own["hamiltonian"], coordinates, parameters, title=own.get("title", ""), id=own.get("id", "")
            )
            if isinstance(found, (GeneralHamiltonian, HamiltonianInTime, SumOfHamiltonians)):
                raise CatalogError(
                    f"{source}: hamiltonian: an entry takes first or second degree in p; in Python "
                    "hjsolve.from_hamiltonian takes any other H(q, p)"
                )
            return found
        constraints = to_eliminate(table)
        constants = [c.constant for c in constraints if c.constant is not None]
        return System(
            coordinates, own["kinetic"], own.get("potential", "0"),
            parameters | {p["name"]: _parameter(p) for p in constants},
            constraints=[c.equation for c in constraints],
            signature=own.get("signature", "definite"), title=own.get("title", ""), id=own.get("id", ""),
            relativity=own.get("relativity"), functions=own.get("functions", ()), place=own.get("place"),
            units={c["name"]: c["unit"] for c in own["coordinates"] if c.get("unit")} | own.get("units", {}),
        )  # fmt: skip
    except InvalidInputError as error:
        raise CatalogError(f"{source}: {_one_line(error)}") from error


def folder() -> Traversable:
    """Return the catalog's folder: inside the installed package, or at the top of a source checkout."""
    installed = files("hjsolve") / "_catalog"
    return installed if installed.is_dir() else Path(__file__).resolve().parents[2] / "catalog"


def _toml_files(kind: str) -> list[Traversable]:
    place = folder() / _FOLDERS[kind]
    return [f for f in place.iterdir() if f.name.endswith(".toml")] if place.is_dir() else []


def _is_file(entry: str | Path) -> bool:
    """Return whether it is a file of the user's, and not the id of an entry of the catalog, whose file has its name."""
    return isinstance(entry, Path) or str(entry).endswith(".toml")


def _locate(entry: str | Path) -> tuple[Traversable, str]:
    if _is_file(entry):
        return Path(entry), str(entry)
    for file in (file for kind in _FOLDERS for file in _toml_files(kind)):
        if file.name == f"{entry}.toml":
            return file, file.name
    shown = printable(str(entry)[:40])
    raise CatalogError(f'no catalog entry "{shown}"{_alike(shown)}')


def _alike(word: str) -> str:
    """Return the entries that look most like a word, and where all are listed."""
    known = ids()
    if re.search(r"[*/^+=(]", word):
        return "; to type a system of your own write --coordinate NAME:DOMAIN --kinetic FORMULA --potential FORMULA"
    close = difflib.get_close_matches(word, known, n=3, cutoff=0.6)
    if close:
        others = f" Similar: {', '.join(close[1:])}." if close[1:] else ""
        first, _, more = word.lower().partition(" ")
        search = f" `hjsolve catalog search {first}` looks in titles." if more else ""
        return f'; did you mean "{close[0]}"?{others}{search}'
    held = [name for name in known if len(word) > 2 and word.lower() in name]
    near = held or difflib.get_close_matches(word, known, n=3, cutoff=0.0)
    return f"; the nearest are {', '.join(near[:5])}; `hjsolve catalog` (hjsolve.catalog.ids()) lists all {len(known)}"


def _kind(expect: Toml, outside: refusals.Refusal | None) -> str:
    if outside:
        return "outside"
    return "unchecked" if not expect else "refused" if expect["verdict"] == "refused" else "separable"


def read(entry: str | Path) -> tuple[TomlTable, str]:
    """Give the table of an entry as it stands in its file, its schema checked, and what it is called in errors.

    Args:
        entry: id, or path of a .toml file.

    Raises:
        CatalogError: as ``load``.
    """
    file, source = _locate(entry)
    table = toml_file.exact_table(file, source)
    keys = schema.optional(_ENTRY, "kinetic") if "hamiltonian" in table else _ENTRY
    if "refused_because" in table and "kinetic" not in table:
        keys = schema.optional(_ENTRY, "kinetic", "coordinates")
    problems = list(schema.faults(table, keys)) or [*refusals.outside_faults(table), *form_faults(table)]
    if not problems and not _is_file(entry) and table["id"] != file.name.removesuffix(".toml"):
        problems.append(f'id: "{table["id"]}" must be the name of the file, "{file.name.removesuffix(".toml")}"')
    if problems:
        raise _refused(source, problems)
    return table, source


def _effects(table: Toml) -> dict[str, Effect]:
    return {name: Effect(name=name, **_frozen(effect)) for name, effect in table.get("effects", {}).items()}


def _reference(table: Toml) -> Reference:
    return Reference(**_frozen(table))


def _frozen(table: Toml) -> TomlTable:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in table.items()}


def _parameter(table: Toml) -> Parameter:
    return parameter(
        table["name"], value=table.get("value"), assume=table.get("assume", "real"), unit=table.get("unit", ""),
        meaning=table.get("meaning", ""),
    )  # fmt: skip


def _entry_faults(table: Toml, system: System | LinearHamiltonian) -> Iterator[str]:
    """Yield faults the schema cannot see: names that disagree, numbers that do not parse, meaningless references."""
    names, declared = [c.name for c in system.coordinates], [p.name for p in system.parameters]
    motions = {"initial": table["initial"]} if "initial" in table else {}
    motions |= {f"motions.{name}": data for name, data in table.get("motions", {}).items()}
    for where, data in motions.items():
        yield from motion_faults(where, data, names, declared)
    for name, effect in table.get("effects", {}).items():
        if not any(effect.get(term) for term in ("kinetic", "potential", "force")):
            yield f"effects.{name}: needs a term: kinetic, potential or force"
        yield from schema.unknown(effect.get("force", ()), names, f"effects.{name}.force", "coordinate")
        yield from _effect_faults(table, name)
    refused = table.get("expect", {}).get("verdict") == "refused"
    if refused and not (table.get("reason") and table.get("instead")):
        yield "reason, instead: a refused entry says why, and what to do"
    for key in ("pair", "ignorable"):
        yield from schema.unknown(table.get("expect", {}).get(key, ()), names, f"expect.{key}", "coordinate")
    known = {"default"} if "initial" in table else set()
    for place, reference in enumerate(table.get("reference", []), start=1):
        yield from reference_faults(reference, f"reference[{place}]", names, known | set(table.get("motions", {})))


def _effect_faults(table: Toml, name: str) -> Iterator[str]:
    try:
        system = from_table(with_effects(table, (name,), ""), source=f"effects.{name}")
        forces(table, (name,), system, source=f"effects.{name}")
    except InvalidInputError as error:
        yield _one_line(error)


def _refused(source: str, problems: list[str]) -> CatalogError:
    return CatalogError(few_lines(f"{source}: {problem}" for problem in problems))


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


__all__ = [
    "Effect", "Entry", "InitialData", "Reference", "describe", "entry_of", "folder", "from_table", "hamiltonian", "ids",
    "kind_of", "load", "read", "table_of", "titles",
]  # fmt: skip


def __dir__() -> list[str]:
    """List what is public, without what this module needs itself."""
    return sorted(__all__)
