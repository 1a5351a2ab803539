"""The output of a sweep: a folder of Parquet files with a manifest, where a part is there completely or not at all.

    out.parquet/_manifest.json              what the sweep is, and, once it is complete, every part with its digest
    out.parquet/part-000000.parquet         orbits 0 … chunk − 1, and so on
    out.parquet/_writing-…                  a part on its way; readers skip names with an underscore
    out.parquet/_journal.jsonl              the digest of every part, a line each, as they came

A part is written next to its place, brought to the disk, noted, and renamed: the name is there only when the part is,
and its digest before it. That digest decides whether the part is good when the sweep is resumed: sizes and footers find
a file that was cut, but neither a flipped bit nor the part of other orbits.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BufferedReader
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from hjsolve.arithmetic.number_types import Columns
from hjsolve.catalog.regular_files import bytes_of, opened_regular
from hjsolve.display.first_lines import few_lines
from hjsolve.ensembles.export import columns_of_words
from hjsolve.ensembles.layout import RECOMPUTED, STATUS
from hjsolve.ensembles.orbit_columns import WORDS
from hjsolve.errors import InvalidInputError
from hjsolve.sweeps.journal import JOURNAL, Journal, NotedPart

MANIFEST, _LOCK, _WRITING = "_manifest.json", "_lock", "_writing-"
ORBIT = "orbit"
FORMAT = 1
_ELSE = "give another name, or delete the folder to begin anew"
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL
_ROOM, _ROOM_OF_A_PART = 1_000_000, 1_000
"""Bytes that a manifest may have: its head, and for each part a name and a digest."""


@dataclass(frozen=True)
class SweepPlan:
    """What the folder is for.

    Attributes:
        scene: digests of the parts of the scene.
        code: versions of the code.
        orbits: how many.
        chunk: orbits of one part.
        title: of the scene, for the reader of the manifest.
    """

    scene: Mapping[str, str]
    code: Mapping[str, str]
    orbits: int
    chunk: int
    title: str

    @property
    def parts(self) -> int:
        """How many parts there are."""
        return -(-self.orbits // self.chunk)

    def window(self, part: int) -> tuple[int, int]:
        """First orbit of a part, and the first after it.

        Args:
            part: its number, from 0 on.
        """
        return part * self.chunk, min((part + 1) * self.chunk, self.orbits)

    @property
    def head(self) -> dict[str, object]:
        """The manifest without what is known at the end only."""
        return {
            "format": FORMAT, "title": self.title, "scene": dict(self.scene), "code": dict(self.code),
            "orbits": self.orbits, "chunk": self.chunk, "parts": self.parts,
        }  # fmt: skip


@dataclass(frozen=True)
class WholePart:
    """A part that is good.

    Attributes:
        sha256: digest of its file.
        statuses: word of a status → orbits, and ``recomputed`` → orbits computed singly.
    """

    sha256: str
    statuses: Mapping[str, int]


@dataclass(frozen=True, eq=False)
class Folder:
    """The folder of a plan; made by ``opened``.

    Attributes:
        path: where it is.
        plan: what it is for.
        whole: number of a part → what it holds; filled by ``left`` and ``write``.
        bad: what is wrong with parts that are there, a line each with the file's name; filled by ``left``.
        notes: what else was amiss; the same.
    """

    path: Path
    plan: SweepPlan
    whole: dict[int, WholePart] = field(default_factory=dict)
    bad: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def journal(self) -> Journal:
        """The digests of the parts, as they were written."""
        return Journal(self.path / JOURNAL)

    def part(self, number: int) -> Path:
        """Return the file of a part.

        Args:
            number: of the part, from 0 on.
        """
        return self.path / f"part-{number:06d}.parquet"

    def left(self) -> list[int]:
        """Examine every part that is there, and list those that are to be computed, in order.

        A part is good where its bytes have the digest that was noted when it was written, and its orbits are those of
        its window. What is amiss is said in ``bad`` and ``notes``.

        Raises:
            InvalidInputError: the folder holds what readers would take for more orbits, or a part is not a file.
        """
        there = self._names()
        noted, strange = self.journal.digests(self.plan.parts)
        digests = {**_signed(self.path, self.plan.parts), **noted}
        if strange:
            journal = self.journal.path
            self.notes.append(f"{journal}: {strange} of its lines are no notes of parts and count for nothing")
        missing = []
        for number in range(self.plan.parts):
            found = self._examined(number, digests.get(number)) if self.part(number).name in there else None
            if isinstance(found, WholePart):
                self.whole[number] = found
                continue
            missing.append(number)
            if found is not None:
                self.bad.append(f"{self.part(number)}: {found}")
        return missing

    def begin(self) -> None:
        """Say in the manifest that the sweep is not complete: parts of it are computed from here on.

        The digests that only a complete manifest had go into the journal first.
        """
        noted, _ = self.journal.digests(self.plan.parts)
        with _reported(self.path):
            for number in self.whole.keys() - noted.keys():
                self.journal.note(NotedPart(number, self.whole[number].sha256))
        _write_manifest(self.path, {**self.plan.head, "complete": False})

    def _names(self) -> set[str]:
        """Return the names in the folder, once none of them is foreign."""
        expected = {self.part(number).name for number in range(self.plan.parts)}
        with os.scandir(self.path) as entries:
            names = {entry.name: entry for entry in entries if not entry.name.startswith(("_", "."))}
        if foreign := sorted(names.keys() - expected):
            raise InvalidInputError(
                f"{self.path / foreign[0]}: is not a part of this sweep, which has {self.plan.parts}, and readers "
                "would take it for one; move it out of the folder"
            )
        for name, entry in names.items():
            if not entry.is_file(follow_symlinks=False):
                raise InvalidInputError(f"{self.path / name}: is not a regular file; move it out of the folder")
        return set(names)

    def _examined(self, number: int, digest: str | None) -> WholePart | str:
        """Return what a part that is there holds, or in words why it is not usable."""
        path = self.part(number)
        if digest is None:
            return "no digest of it was noted"
        with _reported(path, "read"), opened_regular(path, follow=False) as file:
            if hashlib.file_digest(cast("BufferedReader", file), "sha256").hexdigest() != digest:
                return "its bytes are not those that were written"
            file.seek(0)
            try:
                table = pq.read_table(file, columns=[ORBIT, STATUS, RECOMPUTED])
                orbits, recomputed = table[ORBIT].to_numpy(), int(np.count_nonzero(table[RECOMPUTED].to_numpy()))
                counts = {entry["values"]: entry["counts"] for entry in table[STATUS].value_counts().to_pylist()}
            except (pa.ArrowException, OSError, KeyError) as error:
                return f"it is not a part of a sweep ({' '.join(str(error).split())[:80]})"
        if not np.array_equal(orbits, np.arange(*self.plan.window(number))):
            return "its orbits are not those of its place"
        return WholePart(digest, {**counts, RECOMPUTED: recomputed})

    def write(
        self, number: int, starts: Columns, columns: Columns, kept: Mapping[str, pa.ChunkedArray] | None = None
    ) -> None:
        """Write one part, completely or not at all.

        Args:
            number: of the part, from 0 on.
            starts: initial conditions, name → array of shape (n,).
            columns: results, name → array of shape (n,).
            kept: columns of the table of starts that are passed on.

        Raises:
            InvalidInputError: the disk is full, or takes nothing; the parts written before stay.
        """
        begin, end = self.plan.window(number)
        words = pa.DictionaryArray.from_arrays(pa.array(columns[STATUS]), pa.array(WORDS.tolist()))
        arrays = {ORBIT: np.arange(begin, end), **(kept or {}), **starts, STATUS: words}
        arrays[RECOMPUTED] = columns[RECOMPUTED]
        arrays |= {name: column for name, column in columns.items() if name not in arrays}
        beside = self.path / f"{_WRITING}{number:06d}-{os.getpid()}"
        with _reported(self.path, beside=beside):
            table = pa.table(arrays)
            with opened_regular(beside, _NEW, follow=False) as file:
                pq.write_table(table, file, use_dictionary=columns_of_words(table))
            part = WholePart(_digest(beside), _counts(columns))
            self.journal.note(NotedPart(number, part.sha256))
            _moved(beside, self.part(number))
        self.whole[number] = part

    def finish(self) -> dict[str, int]:
        """Write the complete manifest.

        Returns:
            Word of a status → orbits, and ``recomputed`` → orbits computed singly.
        """
        files = []
        for number in range(self.plan.parts):
            begin, end = self.plan.window(number)
            files.append({"file": self.part(number).name, "orbits": end - begin, "sha256": self.whole[number].sha256})
        statuses = self.statuses
        _write_manifest(self.path, {**self.plan.head, "complete": True, "statuses": statuses, "files": files})
        return statuses

    @property
    def statuses(self) -> dict[str, int]:
        """Word of a status → orbits of the good parts, and ``recomputed`` → orbits computed singly."""
        counts: dict[str, int] = {}
        for part in self.whole.values():
            for word, count in part.statuses.items():
                counts[word] = counts.get(word, 0) + count
        return {word: counts[word] for word in [*WORDS.tolist(), RECOMPUTED] if word in counts}


@contextlib.contextmanager
def opened(path: Path, plan: SweepPlan) -> Iterator[Folder]:
    """Begin a sweep in a folder, or resume the one it holds.

    Args:
        path: of the folder; made where there is none.
        plan: what the sweep is to compute.

    Raises:
        InvalidInputError: the path is something else; the folder holds another sweep, or one that other code began;
            another process is writing it.
    """
    if path.exists() and not path.is_dir():
        raise InvalidInputError(f"{path}: is a file; a sweep writes a folder, give another name")
    with _reported(path):
        path.mkdir(parents=True, exist_ok=True)
    with _alone(path):
        if (path / MANIFEST).exists():
            _check(path, plan)
        elif others := sorted(p.name for p in path.iterdir() if p.name != _LOCK and not p.name.startswith(_WRITING)):
            raise InvalidInputError(f"{path}: is a folder with other things in it ({others[0]}); give another name")
        else:
            _write_manifest(path, {**plan.head, "complete": False})
        for beside in path.glob(f"{_WRITING}*"):  # what a killed run left half-written
            beside.unlink()
        yield Folder(path, plan)


def verified(path: Path, plan: SweepPlan) -> dict[str, int]:
    """Examine a finished sweep, and change nothing.

    Args:
        path: of the folder.
        plan: what the sweep was to compute; other code may have computed it.

    Returns:
        Word of a status → orbits, and ``recomputed`` → orbits computed singly.

    Raises:
        InvalidInputError: there is no such folder, it holds another sweep, or a part is missing or not what was
            written; the first ten are listed.
    """
    held = _of_same_scene(path, plan)
    folder = Folder(path, plan)
    missing = folder.left()
    bad = folder.bad + folder.notes
    bad += [f"{folder.part(number)}: is missing" for number in missing if not folder.part(number).exists()]
    if held.get("complete") is not True:
        bad.append(f"{path / MANIFEST}: says that the sweep is not complete")
    elif not bad and held.get("statuses") != folder.statuses:
        bad.append(f"{path / MANIFEST}: its numbers of orbits by status are not those of the parts")
    if bad:
        raise InvalidInputError(f"{few_lines(bad)}\nrun the same without verifying to recompute the damaged parts")
    return folder.statuses


def _manifest(path: Path, parts: int) -> dict[str, Any]:
    """Return the manifest of a folder.

    Raises:
        InvalidInputError: it is not a manifest, a link, or far longer than a manifest of so many parts.
    """
    file = path / MANIFEST
    try:
        held = json.loads(bytes_of(file, _ROOM + _ROOM_OF_A_PART * parts, follow=False))
        dict(held["scene"]), dict(held["code"]), held["format"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        if isinstance(error, InvalidInputError):
            raise
        raise InvalidInputError(f"{file}: is not a manifest of a sweep; {_ELSE}") from error
    return dict(held)


def _signed(path: Path, parts: int) -> dict[int, str]:
    """Return the digests in a complete manifest, by the number of the part; none in another one."""
    held = _manifest(path, parts)
    files = held.get("files") if held.get("complete") is True else None
    if not isinstance(files, list):
        return {}
    digests = {number: file.get("sha256") for number, file in enumerate(files[:parts]) if isinstance(file, dict)}
    return {number: digest for number, digest in digests.items() if isinstance(digest, str)}


def _of_same_scene(path: Path, plan: SweepPlan) -> dict[str, Any]:
    """Return the manifest, once it is that of the same scene."""
    held = _manifest(path, plan.parts)
    scene, form = dict(held["scene"]), held["format"]
    if form != FORMAT:
        raise InvalidInputError(f"{path}: was written in another format ({str(form)[:20]}); {_ELSE}")
    changed = [part for part, digest in plan.scene.items() if scene.get(part) != digest]
    if changed:
        raise InvalidInputError(f"{path}: was begun for another scene (different: {', '.join(changed)}); {_ELSE}")
    return held


def _check(path: Path, plan: SweepPlan) -> None:
    made = dict(_of_same_scene(path, plan)["code"])
    if made != dict(plan.code):
        then, now = (", ".join(f"{name} {v}" for name, v in code.items()) for code in (made, plan.code))
        raise InvalidInputError(f"{path}: was begun by other code ({then}; here {now}); finish it by that, or {_ELSE}")


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Hold the folder's lock; the system frees it when the process ends, however it ends.

    The lock is not followed where it is a link, and nothing in it is changed: others may write in this folder.
    """
    try:
        import fcntl
    except ImportError:  # no such locks on this system
        yield
        return
    with _reported(path):
        lock = opened_regular(path / _LOCK, os.O_RDWR | os.O_CREAT, follow=False)
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise InvalidInputError(f"{path}: another process writes this sweep; wait for it, or stop it") from error
        except OSError as error:
            raise InvalidInputError(
                f"{path}: its disk has no locks ({error.strerror}), so two runs could not be kept apart; use another"
            ) from error
        yield


@contextlib.contextmanager
def _reported(path: Path, what: str = "written", beside: Path | None = None) -> Iterator[None]:
    """Report in one line what the disk refuses; a file on its way is removed."""
    try:
        yield
    except OSError as error:
        if beside is not None:
            with contextlib.suppress(OSError):
                beside.unlink(missing_ok=True)
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise InvalidInputError(
            f"{path}: cannot be {what} ({reason}); the parts that are there stay, and the same call resumes with them"
        ) from error


def _write_manifest(path: Path, content: Mapping[str, object]) -> None:
    beside = path / f"{_WRITING}manifest-{os.getpid()}"
    with _reported(path, beside=beside):
        beside.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        _moved(beside, path / MANIFEST)


def _moved(beside: Path, place: Path) -> None:
    """Bring a file to the disk, then give it its name in one step."""
    with beside.open("rb+") as file:
        os.fsync(file.fileno())
    beside.replace(place)


def _counts(columns: Columns) -> dict[str, int]:
    """Word of a status → orbits, and ``recomputed`` → orbits computed singly."""
    codes, counts = np.unique(columns[STATUS], return_counts=True)
    found = {str(WORDS[code]): int(count) for code, count in zip(codes, counts, strict=True)}
    return {**found, RECOMPUTED: int(np.count_nonzero(columns[RECOMPUTED]))}


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
