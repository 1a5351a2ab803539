"""A sweep into Parquet: the rows of an ensemble, each once, whatever happened to the run on the way."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hjsolve
from hjsolve.command_line.main import main

dataset = pytest.importorskip("pyarrow.dataset", reason="needs the extra cluster")
pq = pytest.importorskip("pyarrow.parquet", reason="needs the extra cluster")

from tests.sweeps.conftest import SCENE, parts, start_slowly, wait_until  # noqa: E402


def rows(out: Path) -> dict[str, Any]:
    table = dataset.dataset(out).to_table()
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


def grid() -> tuple[Any, Any]:
    """The starts of SCENE, the last axis fastest."""
    r, L = np.meshgrid(np.linspace(0.9, 1.6, 4), [0.9, 1.1, 1.9], indexing="ij")
    return r.ravel(), L.ravel()


# ------------------------------------------------------------------------------------------------ what it writes
def test_the_rows_are_those_of_an_ensemble_bit_for_bit(scene: Path, tmp_path: Path) -> None:
    done = hjsolve.sweep(scene, tmp_path / "out.parquet")
    r, L = grid()
    batch = hjsolve.ensemble(
        "kepler-planar", q={"r": r, "theta": 0}, p={"r": 0.1, "theta": L}, want=["actions", "frequencies"]
    )
    found = rows(done.path)
    assert (done.orbits, done.parts, done.kept, done.statuses) == (12, 6, 0, batch.summary())
    assert found["orbit"].tolist() == list(range(12))
    assert found["q.r"].tobytes() == r.tobytes()
    assert found["p.theta"].tobytes() == L.tobytes()
    assert found["status"].tolist() == batch.status.tolist()
    assert {"ok", "unbounded"} <= set(batch.status)
    for name in batch.layout.numbers():
        assert found[name].tobytes() == batch.columns[name].tobytes(), name


def test_the_manifest_says_what_was_made(finished: Path) -> None:
    import hashlib

    out = finished
    held = json.loads((out / "_manifest.json").read_text())
    assert held["complete"]
    assert (held["orbits"], held["chunk"], held["parts"]) == (12, 2, 6)
    assert [file["orbits"] for file in held["files"]] == [2] * 6
    for file in held["files"]:
        assert hashlib.sha256((out / file["file"]).read_bytes()).hexdigest() == file["sha256"]
    assert sum(n for word, n in held["statuses"].items() if word != "recomputed") == 12
    assert {path.name for path in out.iterdir()} - set(parts(out)) == {"_manifest.json", "_lock", "_journal.jsonl"}
    group = pq.ParquetFile(out / held["files"][0]["file"]).metadata.row_group(0)
    columns = [group.column(k) for k in range(group.num_columns)]
    assert [c.path_in_schema for c in columns if "RLE_DICTIONARY" in c.encodings] == ["status"]


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_a_table_of_starts_gives_a_row_for_each_of_its_rows(suffix: str, tmp_path: Path) -> None:
    r, v = np.array([1.0, np.nan, 1.3, 1 / 3]), np.array([1.1, 1.0, 0.9, 2.0])
    path = tmp_path / f"starts{suffix}"
    if suffix == ".csv":
        path.write_text(
            "name,radius,velocity.theta\n"
            + "".join(f"7,{'' if np.isnan(a) else repr(float(a))},{b!r}\n" for a, b in zip(r, map(float, v)))
        )
    elif suffix == ".npz":
        np.savez(path, **{"radius": r, "velocity.theta": v})
    else:
        import pyarrow as pa

        pq.write_table(pa.table({"radius": r, "velocity.theta": v}), path)
    text = f"""
system = "kepler-planar"
want = ["constants"]
initial = {{q = {{theta = "0"}}, velocity = {{r = "1/8"}}}}
[sweep]
table = "{path.name}"
columns = {{"q.r" = "radius"}}
"""
    (tmp_path / "scene.toml").write_text(text)
    found = rows(hjsolve.sweep(tmp_path / "scene.toml", tmp_path / "out").path)
    batch = hjsolve.ensemble(
        "kepler-planar", q={"r": r, "theta": 0}, velocity={"r": 0.125, "theta": v}, want="constants"
    )
    assert found["status"].tolist() == batch.status.tolist()
    assert "not_finite" in batch.status
    assert found["constants.E"].tobytes() == batch.constants["E"].tobytes()
    assert found["q.r"].tobytes() == r.tobytes()
    assert found["velocity.r"].tolist() == [0.125] * 4


def test_log_spacing_has_equal_ratios(tmp_path: Path) -> None:
    table = {"system": "kepler-planar", "want": ["constants"], "sweep": {
        "q": {"r": {"start": "1", "stop": "16", "count": 5, "spacing": "log"}, "theta": "0"}, "p": {"r": 0, "theta": 1}}}  # fmt: skip
    found = rows(hjsolve.sweep(table, tmp_path / "out").path)
    assert found["q.r"] == pytest.approx([1, 2, 4, 8, 16], rel=1e-15)


# ------------------------------------------------------------------------------------------------ killed and gone on
@pytest.mark.nightly
def test_a_run_killed_in_the_middle_goes_on_and_gives_the_same_bytes(
    scene: Path, tmp_path: Path, undisturbed: Path
) -> None:
    out = tmp_path / "killed"
    process = start_slowly(scene, out)
    wait_until(lambda: len(parts(out)) >= 2, process)
    process.kill()
    process.communicate()
    survived = parts(out)
    assert 2 <= len(survived) < 6
    assert not json.loads((out / "_manifest.json").read_text())["complete"]
    (out / "_writing-000004-77").write_bytes(b"half a part")
    stamps = {name: (out / name).stat().st_mtime_ns for name in survived}
    done = hjsolve.sweep(scene, out)
    assert done.kept == len(survived)
    assert {name: (out / name).stat().st_mtime_ns for name in survived} == stamps  # none was computed again
    assert parts(out) == parts(undisturbed)
    assert (out / "_manifest.json").read_bytes() == (undisturbed / "_manifest.json").read_bytes()
    assert not list(out.glob("_writing-*"))


def test_a_damaged_part_is_computed_again(scene: Path, finished: Path) -> None:
    out = finished
    whole = parts(out)
    (out / "part-000002.parquet").write_bytes(whole["part-000002.parquet"][:-100])
    (out / "part-000004.parquet").unlink()
    assert hjsolve.sweep(scene, out).kept == 4
    assert parts(out) == whole


def test_a_complete_sweep_is_not_touched(scene: Path, finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hjsolve.sweeps import conduct

    monkeypatch.setattr(conduct, "columns_of", lambda *_: pytest.fail("computed again"))
    assert hjsolve.sweep(scene, finished).kept == 6


# ------------------------------------------------------------------------------------------------ refused
@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ('"1.9"', '"1.8"', "sweep"), ("chunk = 2", "chunk = 6", "sweep"), (', "frequencies"', "", "want"),
        ('want =', 'parameters = {k = "2"}\nwant =', "parameters"),
        ("want =", 'effects = ["precession"]\nwant =', "effects"),
    ],
)  # fmt: skip
def test_another_scene_is_refused_and_nothing_is_touched(
    old: str, new: str, part: str, scene: Path, finished: Path
) -> None:
    out = finished
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    scene.write_text(SCENE.replace(old, new))
    with pytest.raises(hjsolve.InvalidInputError, match=rf"another scene \(different: {part}\); give another name"):
        hjsolve.sweep(scene, out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_remarks_and_titles_do_not_make_another_scene(scene: Path, finished: Path) -> None:
    scene.write_text('title = "The same"\n# a remark\n' + SCENE)
    assert hjsolve.sweep(scene, finished).kept == 6


def test_other_code_other_folders_and_a_second_writer_are_refused(scene: Path, finished: Path) -> None:
    out = finished
    manifest = out / "_manifest.json"
    text = manifest.read_text()
    manifest.write_text(text.replace('"numpy": "', '"numpy": "0.'))
    with pytest.raises(hjsolve.InvalidInputError, match=r"begun by other code .*numpy 0"):
        hjsolve.sweep(scene, out)
    manifest.write_text("{}")
    with pytest.raises(hjsolve.InvalidInputError, match="is not a manifest of a sweep"):
        hjsolve.sweep(scene, out)
    manifest.unlink()
    with pytest.raises(hjsolve.InvalidInputError, match="a folder with other things in it"):
        hjsolve.sweep(scene, out)
    with pytest.raises(hjsolve.InvalidInputError, match="is a file"):
        hjsolve.sweep(scene, scene)


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="no such locks")
def test_two_writers_do_not_meet(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start_slowly(scene, out)
    wait_until(lambda: len(parts(out)) >= 1, process)
    with pytest.raises(hjsolve.InvalidInputError, match="another process writes this sweep"):
        hjsolve.sweep(scene, out)
    assert process.wait() == 0
    assert hjsolve.sweep(scene, out).kept == 6
    process.communicate()


FAULTS = {
    "a number": (SCENE[SCENE.index("[sweep]"):], "sweep = 3", "sweep: must be a table"),
    "chunk of zero": ("chunk = 2", "chunk = 0", "sweep.chunk: must be a whole number"),
    "unknown key": ("chunk", "chunks", 'sweep.chunks: unknown key; did you mean "chunk"'),
    "unknown coordinate": ("theta = [", "phi = [", 'sweep.p: no coordinate "phi"'),
    "coordinate missing": ('r = "0.1"', "", "sweep.p.r: missing"),
    "empty list": ('["0.9", "1.1", "1.9"]', "[]", "sweep.p.theta: must be a list of numbers, and not empty"),
    "no number": ('"1.9"', '"x"', "sweep.p.theta[3]"),
    "a list in a list": ('"1.9"', "[1]", "sweep.p.theta[3]: must be a number"),
    "one value of a range": ("count = 4", "count = 1", "sweep.q.r.count: must be a whole number from 2"),
    "range without stop": ('stop = "1.6", ', "", "sweep.q.r.stop: missing"),
    "unknown spacing": ("count = 4", 'count = 4, spacing = "logarithmic"', "sweep.q.r.spacing"),
    "log from below zero": ('start = "0.9"', 'spacing = "log", start = "-1"', "log spacing needs a positive start"),
    "p and velocity": ("[sweep.p]", "[sweep.velocity]\nr = 0\n[sweep.p]", "give p or velocity"),
    "grid and table": ("chunk = 2", 'table = "a.csv"', "actions, angles) or a table"),
    "columns without table": ("chunk = 2", 'columns = {"q.r" = "r"}', "sweep.columns: belongs to a table"),
    "times too": ("want =", "times = [1]\nwant =", "times: not in a scene with a sweep"),
    "trajectory": ('"actions"', '"trajectory"', 'want: "trajectory" is not for a sweep'),
    "seconds": ("want =", 'accuracy = {seconds = "3"}\nwant =', "accuracy: a sweep has neither a time nor proofs"),
    "many digits": ("want =", "accuracy = {digits = 30}\nwant =", "computed in doubles, 15 digits at most"),
}  # fmt: skip


@pytest.mark.parametrize("kind", FAULTS)
def test_a_fault_of_the_table_is_one_line_with_file_and_key(kind: str, scene: Path) -> None:
    old, new, message = FAULTS[kind]
    assert SCENE.count(old) >= 1
    scene.write_text(SCENE.replace(old, new, 1))
    with pytest.raises(hjsolve.CatalogError) as caught:
        hjsolve.Scene.load(scene)
    assert any(message in line and line.startswith(str(scene)) for line in str(caught.value).splitlines()), str(
        caught.value
    )


TABLES = {
    "words": ("q.r,p.theta\n1,one\n", "is not a table of numbers"),
    "ragged": ("q.r,p.theta\n1,1\n1\n", "is not a table of numbers"),
    "too few headings": ("q.r\n1,1\n", "1 headings and 2 columns"),
    "no rows": ("q.r,p.theta\n", "holds no rows"),
    "misspelled": ("q.r,p.thta\n1,1\n", 'column "p.thta" is not an initial condition; did you mean "p.theta"'),
    "nothing of use": ("a,b\n1,1\n", "no column is an initial condition"),
    "both kinds": ("q.r,p.theta,velocity.r\n1,1,1\n", "columns of both p and velocity"),
}


@pytest.mark.parametrize("kind", TABLES)
def test_a_fault_of_a_file_of_starts_is_told(kind: str, tmp_path: Path) -> None:
    text, message = TABLES[kind]
    (tmp_path / "starts.csv").write_text(text)
    (tmp_path / "s.toml").write_text(
        'system = "kepler-planar"\nwant = ["constants"]\ninitial = {q = {theta = 0}, p = {r = 0}}\nsweep = {table = "starts.csv"}\n'
    )
    with pytest.raises(hjsolve.InvalidInputError, match=message):
        hjsolve.sweep(tmp_path / "s.toml", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_scene_with_a_sweep_does_not_run_and_one_without_does_not_sweep(scene: Path, tmp_path: Path) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match="has many motions"):
        hjsolve.Scene.load(scene).run()
    with pytest.raises(hjsolve.InvalidInputError, match=r"has no table \[sweep\]"):
        hjsolve.sweep({"system": "kepler-planar"}, tmp_path / "out")
    with pytest.raises(hjsolve.InvalidInputError, match="chunk: a whole number"):
        hjsolve.sweep(scene, tmp_path / "out", chunk=0)


# ------------------------------------------------------------------------------------------------ command line, progress
def test_the_command_says_what_it_wrote_and_ends_with_0_or_2(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.parquet"
    assert main(["sweep", str(scene), "-o", str(out)]) == 0
    printed = capsys.readouterr()
    assert "12 orbits in 6 files; " in printed.out
    assert printed.err == ""  # nobody looks: no bar
    assert main(["sweep", str(scene), "-o", str(out), "--threads", "1"]) == 0
    assert "12 orbits in 6 files, 6 of them by an earlier run" in capsys.readouterr().out
    scene.write_text(SCENE.replace("chunk = 2", "chunk = 7"))
    assert main(["sweep", str(scene), "-o", str(out)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_an_interrupted_command_says_that_it_can_go_on(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from hjsolve.sweeps import conduct

    quick, calls = conduct.columns_of, []

    def interrupted(*arguments: Any) -> Any:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return quick(*arguments)

    monkeypatch.setattr(conduct, "columns_of", interrupted)
    assert main(["sweep", str(scene), "-o", str(tmp_path / "out")]) == 130
    assert "rerun the same command to resume" in capsys.readouterr().err
    assert main(["sweep", str(scene), "-o", str(tmp_path / "out")]) == 0
    assert "2 of them by an earlier run" in capsys.readouterr().out


def test_progress_is_a_bar_a_line_or_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from hjsolve.display.progress import ProgressBar, Tally

    def told(shown: bool | None, *, stays: bool = True) -> str:
        stream = io.StringIO()
        with ProgressBar(stays=stays, shown=shown, stream=stream) as progress:
            tally = Tally(10, 4, progress)
            tally.add(6)
        return stream.getvalue()

    assert told(None) == told(False) == ""
    monkeypatch.setitem(sys.modules, "rich.console", None)
    plain = told(True)
    first, last = plain.removesuffix("\n").split("\r\x1b[2K")[1:]
    assert first == f"[{10 * '#'}{14 * '.'}] 4 of 10 orbits (40 %)"
    assert last == f"[{24 * '#'}] 10 of 10 orbits (100 %)"
    assert told(True, stays=False).endswith("\r\x1b[2K")
    monkeypatch.undo()
    pytest.importorskip("rich")
    assert "10 of 10 orbits" in told(True)
