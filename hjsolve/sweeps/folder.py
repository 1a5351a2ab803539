"""The output of a sweep: a folder of Parquet files with a manifest, where a part is there completely or not at all.

    out.parquet/_manifest.json              what the sweep is, and, once it is complete, every part with its digest
    out.parquet/part-000000.parquet         orbits 0 … chunk − 1, and so on
    out.parquet/_writing-…                  a part on its way; readers skip names with an underscore
    out.parquet/_journal.jsonl              size, digest and statuses of parts, a line each, as they came

A part is written beside its place, brought to the disk, and renamed: the name is there only when the part is. The
journal saves looking into parts: going on with, and finishing, a sweep of 10⁵ parts lists the folder and opens none.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from hjsolve.arithmetic.number_types import Columns
from hjsolve.ensembles.export import columns_of_words
from hjsolve.ensembles.layout import RECOMPUTED, STATUS
from hjsolve.ensembles.orbit_columns import WORDS
from hjsolve.errors import InvalidInputError
from hjsolve.sweeps.journal import JOURNAL, Journal, NotedPart

MANIFEST, _LOCK, _WRITING = "_manifest.json", "_lock", "_writing-"
FORMAT = 1


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
class Folder:
    """The folder of a plan; made by ``opened``."""

    path: Path
    plan: SweepPlan

    @property
    def journal(self) -> Journal:
        """What is known of the parts without opening them."""
        return Journal(self.path / JOURNAL)

    def part(self, number: int) -> Path:
        """The file of a part.

        Args:
            number: of the part, from 0 on.
        """
        return self.path / f"part-{number:06d}.parquet"

    def left(self) -> list[int]:
        """The parts that are not there yet, in order; a file that is no whole part counts as not there.

        A part whose size is that in the journal is whole. Others, which a killed run had no time to note, or which were
        changed, are looked into, and noted if they are whole.
        """
        sizes = _sizes(self.path)
        noted = self.journal.parts()
        missing = []
        for number in range(self.plan.parts):
            size = sizes.get(self.part(number).name)
            if size is None:
                missing.append(number)
            elif number not in noted or noted[number].size != size:
                if self._whole(number):
                    with _told(self.path):
                        self.journal.note(_looked_into(number, self.part(number)))
                else:
                    missing.append(number)
        return missing

    def _whole(self, number: int) -> bool:
        begin, end = self.plan.window(number)
        try:
            return bool(pq.read_metadata(self.part(number)).num_rows == end - begin)
        except (FileNotFoundError, pa.ArrowInvalid):
            return False

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
        arrays = {"orbit": np.arange(begin, end), **(kept or {}), **starts, STATUS: words}
        arrays[RECOMPUTED] = columns[RECOMPUTED]
        arrays |= {name: column for name, column in columns.items() if name not in arrays}
        beside = self.path / f"{_WRITING}{number:06d}-{os.getpid()}"
        with _told(self.path, beside):
            table = pa.table(arrays)
            pq.write_table(table, beside, use_dictionary=columns_of_words(table))
            line = NotedPart(number, beside.stat().st_size, _digest(beside), _counts(columns))
            _moved(beside, self.part(number))
            self.journal.note(line)

    def finish(self) -> dict[str, int]:
        """Write the complete manifest.

        Returns:
            Word of a status → orbits, and ``recomputed`` → orbits computed singly.
        """
        counts: dict[str, int] = {}
        files, noted = [], self.journal.parts()
        for number in range(self.plan.parts):
            begin, end = self.plan.window(number)
            files.append({"file": self.part(number).name, "orbits": end - begin, "sha256": noted[number].sha256})
            for word, count in noted[number].statuses.items():
                counts[word] = counts.get(word, 0) + count
        ordered = {word: counts[word] for word in [*WORDS.tolist(), RECOMPUTED] if word in counts}
        _write_manifest(self.path, {**self.plan.head, "complete": True, "statuses": ordered, "files": files})
        return ordered


@contextlib.contextmanager
def opened(path: Path, plan: SweepPlan) -> Iterator[Folder]:
    """Begin a sweep in a folder, or go on with the one it holds.

    Args:
        path: of the folder; made where there is none.
        plan: what the sweep is to compute.

    Raises:
        InvalidInputError: the path is something else; the folder holds another sweep, or one that other code began;
            another process is writing it.
    """
    if path.exists() and not path.is_dir():
        raise InvalidInputError(f"{path}: is a file; a sweep writes a folder, give another name")
    with _told(path):
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


def _check(path: Path, plan: SweepPlan) -> None:
    how = "give another name, or delete the folder to begin anew"
    try:
        held = json.loads((path / MANIFEST).read_text(encoding="utf-8"))
        scene, made, form = dict(held["scene"]), dict(held["code"]), held["format"]
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidInputError(f"{path / MANIFEST}: is no manifest of a sweep; {how}") from error
    if form != FORMAT:
        raise InvalidInputError(f"{path}: was written in another format ({form}); {how}")
    changed = [part for part, digest in plan.scene.items() if scene.get(part) != digest]
    if changed:
        raise InvalidInputError(f"{path}: was begun for another scene (different: {', '.join(changed)}); {how}")
    if made != dict(plan.code):
        then, now = (", ".join(f"{name} {v}" for name, v in code.items()) for code in (made, plan.code))
        raise InvalidInputError(f"{path}: was begun by other code ({then}; here {now}); finish it by that, or {how}")


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Hold the folder's lock; the system frees it when the process ends, however it ends."""
    try:
        import fcntl
    except ImportError:  # no such locks on this system
        yield
        return
    with _told(path):
        lock = (path / _LOCK).open("w")
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
def _told(path: Path, beside: Path | None = None) -> Iterator[None]:
    """Tell in one line what the disk refuses; a file on its way is taken away."""
    try:
        yield
    except OSError as error:
        if beside is not None:
            with contextlib.suppress(OSError):
                beside.unlink(missing_ok=True)
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise InvalidInputError(
            f"{path}: cannot be written ({reason}); the parts that are there stay, and the same call goes on with them"
        ) from error


def _write_manifest(path: Path, content: Mapping[str, object]) -> None:
    beside = path / f"{_WRITING}manifest-{os.getpid()}"
    with _told(path, beside):
        beside.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        _moved(beside, path / MANIFEST)


def _moved(beside: Path, place: Path) -> None:
    """Bring a file to the disk, then give it its name in one step."""
    with beside.open("rb+") as file:
        os.fsync(file.fileno())
    beside.replace(place)


def _sizes(path: Path) -> dict[str, int]:
    with os.scandir(path) as entries:
        return {entry.name: entry.stat().st_size for entry in entries}


def _counts(columns: Columns) -> dict[str, int]:
    """Word of a status → orbits, and ``recomputed`` → orbits computed singly."""
    codes, counts = np.unique(columns[STATUS], return_counts=True)
    found = {str(WORDS[code]): int(count) for code, count in zip(codes, counts, strict=True)}
    return {**found, RECOMPUTED: int(np.count_nonzero(columns[RECOMPUTED]))}


def _looked_into(number: int, path: Path) -> NotedPart:
    """What the journal would say of a part that is there."""
    table = pq.read_table(path, columns=[STATUS, RECOMPUTED])
    counts = {entry["values"]: entry["counts"] for entry in table[STATUS].value_counts().to_pylist()}
    counts[RECOMPUTED] = int(np.count_nonzero(table[RECOMPUTED].to_numpy()))
    return NotedPart(number, path.stat().st_size, _digest(path), counts)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
