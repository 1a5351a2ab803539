"""Tables of starts that are read part by part: any row groups and files, against the table as a whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hjsolve

pa = pytest.importorskip("pyarrow", reason="needs the extra cluster")
pq = pytest.importorskip("pyarrow.parquet")
N = 101
SCENE = """
system = "kepler-planar"
want = ["actions"]
initial = {q = {theta = "0"}, p = {r = "1/8"}}
[sweep]
chunk = 7
table = "stars.parquet"
columns = {"q.r" = "radius", "p.theta" = "L"}
keep = ["source_id", "name"]
"""


def stars() -> pa.Table:
    rng = np.random.default_rng(14)
    radius = rng.uniform(0.8, 1.5, N)
    return pa.table({
        "source_id": pa.array((2**62 + 3 * np.arange(N)).tolist(), pa.int64()),  # no double holds it
        "radius": pa.array([None if k == 50 else x for k, x in enumerate(radius.tolist())]),
        "name": [None if k % 9 == 4 else f"star {k}" for k in range(N)],
        "L": pa.array(rng.uniform(0.9, 1.1, N), pa.float32()),
        "unused": [[k] * 3 for k in range(N)],
    })  # fmt: skip


def written(folder: Path, *, split: bool, group: int) -> Path:
    """The table as one file or as three in subfolders, next to things that are no data; and its scene."""
    table, path = stars(), folder / "stars.parquet"
    if split:
        for name, low, high in (("b/x", 40, 41), ("a/y", 0, 40), ("c/x", 41, N)):
            (path / name).parent.mkdir(parents=True)
            pq.write_table(table.slice(low, high - low), path / f"{name}.parquet", row_group_size=group)
        (path / "_old.parquet").write_bytes(b"no data")
    else:
        pq.write_table(table, path, row_group_size=group)
    (folder / "scene.toml").write_text(SCENE)
    return folder / "scene.toml"


@pytest.mark.parametrize(("split", "group"), [(False, 1000), (False, 5), (False, 20), (True, 1), (True, 13)])
def test_rows_come_part_by_part_and_only_the_columns_that_are_asked(
    split: bool, group: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: set[str] = set()
    whole = pq.ParquetFile.read_row_group

    def noted(self: object, number: int, *, columns: list[str], **others: object) -> pa.Table:
        asked.update(columns)
        return whole(self, number, columns=columns, **others)

    monkeypatch.setattr(pq.ParquetFile, "read_row_group", noted)
    monkeypatch.setattr(pq, "read_table", lambda *_, **__: pytest.fail("read as a whole"))
    out = hjsolve.sweep(written(tmp_path, split=split, group=group), tmp_path / "out").path
    monkeypatch.undo()
    assert asked == {"source_id", "name", "radius", "L"}
    import pyarrow.dataset

    found, given = pyarrow.dataset.dataset(out).to_table(), stars()
    assert found["source_id"].to_pylist() == given["source_id"].to_pylist()
    assert found["name"].to_pylist() == given["name"].to_pylist()
    r, L = given["radius"].to_numpy(), given["L"].to_numpy().astype(float)
    batch = hjsolve.ensemble("kepler-planar", q={"r": r, "theta": 0}, p={"r": 0.125, "theta": L}, want="actions")
    assert found["status"].to_pylist() == batch.status.tolist()
    assert batch.summary()["not_finite"] == 1
    assert found["q.r"].to_numpy().tobytes() == r.tobytes()
    assert np.nan_to_num(found["actions.r"].to_numpy()).tolist() == pytest.approx(
        np.nan_to_num(batch.actions["r"]).tolist(), rel=1e-14, abs=0
    )


@pytest.mark.filterwarnings("ignore:The inplace keyword in DataFrame:DeprecationWarning")  # dask's use of pandas
def test_dask_reads_the_results_lazily(tmp_path: Path) -> None:
    frames = pytest.importorskip("dask.dataframe")
    out = hjsolve.sweep(written(tmp_path, split=True, group=13), tmp_path / "out").path
    frame = frames.read_parquet(str(out), columns=["source_id", "actions.r"])
    assert frame.npartitions > 1
    late = frame[frame["source_id"] >= 2**62 + 3 * 90].compute()
    assert sorted(late["source_id"].tolist()) == [2**62 + 3 * k for k in range(90, N)]


def test_duckdb_reads_the_results_lazily_while_a_sweep_is_at_work(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    out = hjsolve.sweep(written(tmp_path, split=True, group=13), tmp_path / "out").path
    (out / "_writing-000015-77").write_bytes(b"half a part")
    rows = f"FROM read_parquet('{out}/part-*.parquet')"
    assert duckdb.sql(f"SELECT count(*), count(DISTINCT orbit) {rows}").fetchall() == [(N, N)]
    found = duckdb.sql(f'SELECT source_id, name {rows} WHERE orbit >= 90 AND "actions.r" IS NOT NULL ORDER BY orbit')
    given = stars().slice(90).to_pydict()
    assert found.fetchall() == list(zip(given["source_id"], given["name"], strict=True))
    counts = dict(duckdb.sql(f"SELECT status, count(*) {rows} GROUP BY status").fetchall())
    assert counts == {"ok": N - 1, "not_finite": 1}
    plan = duckdb.sql(f"EXPLAIN SELECT source_id {rows} WHERE orbit >= 90").fetchall()[0][1]
    assert "orbit>=90" in plan.replace(" ", "")  # the filter is in the scan: whole parts are left out by their bounds
    assert "actions" not in plan


def test_a_table_that_was_touched_is_another_one(tmp_path: Path) -> None:
    scene = written(tmp_path, split=True, group=13)
    hjsolve.sweep(scene, tmp_path / "out")
    part = tmp_path / "stars.parquet" / "a" / "y.parquet"
    pq.write_table(stars().slice(1, 40), part)
    with pytest.raises(hjsolve.InvalidInputError, match=r"another scene \(different: table\)"):
        hjsolve.sweep(scene, tmp_path / "out")
    pq.write_table(stars().select(["radius", "L"]), part)
    with pytest.raises(hjsolve.InvalidInputError, match="has other columns than"):
        hjsolve.sweep(scene, tmp_path / "out")
    part.write_bytes(b"PAR1")
    with pytest.raises(hjsolve.InvalidInputError, match="is not a Parquet file"):
        hjsolve.sweep(scene, tmp_path / "out")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"source_id"', '"sorce_id"', 'no column "sorce_id" to keep; did you mean "source_id"'),
        ('"p.theta" = "L"', '"p.theta" = "name"', 'column "name" must hold one number a row, not string'),
        ('"source_id"', '"name"', '"name" is a column of the results already'),
    ],
)
def test_columns_that_cannot_be_had_are_told(old: str, new: str, message: str, tmp_path: Path) -> None:
    scene = written(tmp_path, split=False, group=50)
    scene.write_text(SCENE.replace(old, new))
    with pytest.raises(hjsolve.InvalidInputError, match=message):
        hjsolve.sweep(scene, tmp_path / "out")


def test_keep_belongs_to_parquet(tmp_path: Path) -> None:
    scene = written(tmp_path, split=False, group=50)
    scene.write_text(SCENE.replace("stars.parquet", "stars.csv"))
    with pytest.raises(hjsolve.CatalogError, match=r"keep: belongs to a table that is a \.parquet"):
        hjsolve.Scene.load(scene)
