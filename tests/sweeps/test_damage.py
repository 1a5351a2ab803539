"""Folders of sweeps that were spoilt: whatever was changed is found by its digest, said, and computed again."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import hjsolve
from hjsolve.command_line.main import main

pytest.importorskip("pyarrow", reason="needs the extra cluster")

from tests.sweeps.conftest import SCENE, parts

SHAS = "0" * 64


def _flip(out: Path, rng: random.Random) -> None:
    path = rng.choice(sorted(out.glob("part-*")))
    data = bytearray(path.read_bytes())
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    path.write_bytes(data)


def _swap(out: Path, rng: random.Random) -> None:
    first, second = rng.sample(sorted(out.glob("part-*")), 2)
    one, other = first.read_bytes(), second.read_bytes()
    first.write_bytes(other)
    second.write_bytes(one if rng.random() < 0.5 else other)


def _truncate(out: Path, rng: random.Random) -> None:
    path = rng.choice(sorted(out.glob("part-*")))
    data = path.read_bytes()
    kept = rng.randrange(len(data))
    path.write_bytes(data[:kept] + (bytes(len(data) - kept) if rng.random() < 0.5 else b""))


def _lose(out: Path, rng: random.Random) -> None:
    """The journal, the promise of the manifest, or both are gone before a part is spoilt."""
    (out / "_journal.jsonl").unlink()
    if rng.random() < 0.5:
        held = json.loads((out / "_manifest.json").read_text())
        (out / "_manifest.json").write_text(json.dumps({**held, "complete": False}))
    _flip(out, rng)


DAMAGES: tuple[Callable[[Path, random.Random], None], ...] = (_flip, _swap, _truncate, _lose)


def _none_is_blessed(seed: int, scene: Path, finished: Path, undisturbed: Path) -> None:
    rng = random.Random(seed)
    DAMAGES[seed % len(DAMAGES)](finished, rng)
    whole = parts(undisturbed)
    spoilt = [name for name, data in parts(finished).items() if data != whole[name]]
    with pytest.raises(hjsolve.InvalidInputError, match=spoilt[0] if len(spoilt) == 1 else "part-"):
        hjsolve.sweep(scene, finished, verify=True)
    done = hjsolve.sweep(scene, finished)
    assert all(any(name in note and "computed again" in note for note in done.notes) for name in spoilt)
    assert parts(finished) == whole
    assert (finished / "_manifest.json").read_bytes() == (undisturbed / "_manifest.json").read_bytes()
    assert hjsolve.sweep(scene, finished, verify=True).orbits == 12


@pytest.mark.parametrize("seed", range(4))
def test_no_spoilt_part_is_blessed(seed: int, scene: Path, finished: Path, undisturbed: Path) -> None:
    _none_is_blessed(seed, scene, finished, undisturbed)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(4, 44))
def test_no_spoilt_part_is_blessed_in_forty_more_ways(
    seed: int, scene: Path, finished: Path, undisturbed: Path
) -> None:
    _none_is_blessed(seed, scene, finished, undisturbed)


def test_a_part_of_other_orbits_is_found_though_the_journal_vouches_for_it(
    scene: Path, finished: Path, undisturbed: Path
) -> None:
    third = finished / "part-000003.parquet"
    shutil.copy(third, finished / "part-000005.parquet")
    lines = [json.loads(line) for line in (finished / "_journal.jsonl").read_text().splitlines() if line]
    digest = next(line["sha256"] for line in lines if line["part"] == 3)
    with (finished / "_journal.jsonl").open("a") as journal:
        journal.write(json.dumps({"part": 5, "sha256": digest}) + "\n")
    done = hjsolve.sweep(scene, finished)
    assert any("its orbits are not those of its place" in note for note in done.notes)
    assert parts(finished) == parts(undisturbed)


@pytest.mark.parametrize(
    "line",
    [f'{{"part": [3], "sha256": "{SHAS}"}}', '{"part": 3, "sha256": null}', "[" * 100_000, "0", '{"part": true}', "\x00"],
    ids=["a list", "no digest", "brackets", "a number", "a truth value", "a zero"],
)  # fmt: skip
def test_a_line_that_is_no_note_counts_for_nothing_and_is_reported_with_its_file(
    line: str, scene: Path, finished: Path
) -> None:
    with (finished / "_journal.jsonl").open("a") as journal:
        journal.write(line + "\n")
    done = hjsolve.sweep(scene, finished)
    assert done.kept == 6
    assert done.notes == (f"{finished / '_journal.jsonl'}: 1 of its lines are no notes of parts and count for nothing",)


def test_a_manifest_of_brackets_is_no_manifest(scene: Path, finished: Path) -> None:
    (finished / "_manifest.json").write_text("[" * 200_000)
    with pytest.raises(hjsolve.InvalidInputError, match="is not a manifest of a sweep"):
        hjsolve.sweep(scene, finished)


def test_what_readers_would_take_for_a_part_is_refused(scene: Path, finished: Path) -> None:
    shutil.copy(finished / "part-000000.parquet", finished / "part-000099.parquet")
    for verify in (True, False):
        with pytest.raises(hjsolve.InvalidInputError, match=r"part-000099.parquet: is not a part of this sweep"):
            hjsolve.sweep(scene, finished, verify=verify)


@pytest.mark.parametrize("kind", ["folder", "link", "pipe"])
def test_a_part_that_is_no_file_is_named(kind: str, scene: Path, finished: Path, undisturbed: Path) -> None:
    part = finished / "part-000002.parquet"
    part.unlink()
    if kind == "folder":
        part.mkdir()
    elif kind == "link":
        part.symlink_to(undisturbed / part.name)
    else:
        os.mkfifo(part)
    with pytest.raises(hjsolve.InvalidInputError, match=r"part-000002.parquet: is not a regular file"):
        hjsolve.sweep(scene, finished)


@pytest.mark.parametrize("name", ["_lock", "_journal.jsonl", "_manifest.json"])
def test_a_link_among_the_own_files_is_not_followed(name: str, scene: Path, finished: Path, tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("a thesis")
    (finished / name).unlink()
    (finished / name).symlink_to(precious)
    with pytest.raises(hjsolve.InvalidInputError, match=f"{name}: is a link"):
        hjsolve.sweep(scene, finished)
    assert precious.read_text() == "a thesis"


def test_verifying_changes_nothing_and_says_what_is_missing(
    scene: Path, finished: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (finished / "_lock").unlink()
    before = {path.name: path.read_bytes() for path in finished.iterdir()}
    command = ["sweep", str(scene), "-o", str(finished), "--verify"]
    assert main(command) == 0
    assert capsys.readouterr().out.startswith(f"verified {finished}: 12 orbits in 6 files; ")
    assert {path.name: path.read_bytes() for path in finished.iterdir()} == before
    (finished / "part-000001.parquet").unlink()
    held = json.loads(before["_manifest.json"])
    held["statuses"]["ok"] += 1
    (finished / "_manifest.json").write_text(json.dumps(held))
    assert main(command) == 2
    assert "part-000001.parquet: is missing" in capsys.readouterr().err
    assert not (finished / "part-000001.parquet").exists()


def test_numbers_by_status_that_are_not_those_of_the_parts_are_found(scene: Path, finished: Path) -> None:
    held = json.loads((finished / "_manifest.json").read_text())
    held["statuses"]["ok"] += 1
    (finished / "_manifest.json").write_text(json.dumps(held))
    with pytest.raises(hjsolve.InvalidInputError, match="its numbers of orbits by status"):
        hjsolve.sweep(scene, finished, verify=True)


def test_a_sweep_of_which_most_orbits_fail_says_the_commonest_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "far.toml"
    scene.write_text(SCENE.replace('["0.9", "1.1", "1.9"]', '["0.9", "2.9", "3.9"]'))
    assert main(["sweep", str(scene), "-o", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().err
    assert told.startswith("hjsolve: 8 of 12 orbits are not ok; 8 of them are unbounded (a coordinate escapes")
    assert told.count("\n") == 1
