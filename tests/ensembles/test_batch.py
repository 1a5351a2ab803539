"""A batch as a container and as a table of other libraries; arrays of other libraries as initial conditions."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError, MissingExtraError

WANT = {"actions", "turning_points"}
RADII = np.array([[0.9, 1.0, np.nan], [1.2, 1.4, 1.6]])


def batch(r: Any = RADII) -> hjsolve.Batch:
    return hjsolve.ensemble("kepler-planar", {"r": r, "theta": 0}, {"r": 0.1, "theta": 1.1}, want=WANT, threads=1)


def same(one: hjsolve.Batch, other: hjsolve.Batch) -> bool:
    return one.shape == other.shape and all(
        np.array_equal(one.columns[n], other.columns[n], equal_nan=n not in {"status", "recomputed"})
        for n in one.columns
    )


def test_orbits_are_picked_as_from_a_numpy_array() -> None:
    whole = batch()
    assert len(whole) == 2
    assert same(whole[1], batch(RADII[1]))
    assert same(whole[:, 1:], batch(RADII[:, 1:]))
    assert same(whole[whole.codes == hjsolve.Status.OK], batch(RADII[np.isfinite(RADII)]))
    assert same(whole[np.array([1, 0])], batch(RADII[::-1]))
    one = whole[1, 2]
    assert one.shape == ()
    assert one.actions["r"] == whole.actions["r"][1, 2]
    assert one.status == "ok"
    assert [row.shape for row in whole] == [(3,), (3,)]
    assert [float(x.actions["r"]) for x in whole[1]] == whole.actions["r"][1].tolist()
    with pytest.raises(TypeError):
        len(one)
    with pytest.raises(IndexError):
        _ = whole[2]
    with pytest.raises(InvalidInputError, match="an index selects orbits"):
        _ = whole["actions.r"]


def test_a_lazy_batch_is_sliced_without_computing() -> None:
    da = pytest.importorskip("dask.array")
    lazy = batch(da.from_array(RADII, chunks=(1, 3)))
    assert lazy[1].lazy
    assert same(lazy[1].compute(), batch(RADII[1]))
    assert "not computed" in lazy._repr_html_()


def test_pandas_has_a_row_for_each_orbit() -> None:
    pytest.importorskip("pandas")
    whole = batch()
    frame = whole.to_pandas()
    assert list(frame.columns) == list(whole.columns)
    assert frame.index.names == ["axis_0", "axis_1"]
    assert frame.loc[(0, 2), "status"] == "not_finite"
    assert frame.loc[(1, 1), "actions.r"] == whole.actions["r"][1, 1]
    assert list(whole[1].to_pandas().index) == [0, 1, 2]
    assert len(whole[1, 1].to_pandas()) == 1


def test_xarray_has_the_axes_of_the_batch() -> None:
    pytest.importorskip("xarray")
    whole = batch()
    data = whole.to_xarray()
    assert dict(data.sizes) == {"axis_0": 2, "axis_1": 3}
    assert data["turning_points.r.lower"].values.tolist()[1] == whole.turning_points["r"][0][1].tolist()
    assert data["status"].values[0, 2] == "not_finite"


def test_parquet_gives_back_every_bit(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    whole = batch()
    path = whole.save(tmp_path / "orbits.parquet")
    table = parquet.read_table(path)
    assert table.schema.metadata[b"shape"] == b"[2, 3]"
    for name in whole.layout.numbers():
        assert table[name].to_numpy().tobytes() == whole.columns[name].tobytes()
    assert table["status"].to_pylist() == whole.status.ravel().tolist()
    assert list(tmp_path.iterdir()) == [path]
    group = parquet.ParquetFile(path).metadata.row_group(0)  # a dictionary of numbers takes time and room
    columns = [group.column(k) for k in range(group.num_columns)]
    assert [c.path_in_schema for c in columns if "RLE_DICTIONARY" in c.encodings] == ["status"]
    with pytest.raises(InvalidInputError, match=r"must end in \.parquet"):
        whole.save(tmp_path / "orbits.csv")


def test_a_library_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r"hjsolve\[tables\]"):
        batch().to_pandas()


def test_notebooks_see_counts_and_histograms() -> None:
    whole = batch()
    page = whole._repr_html_()
    assert "5 ok, 1 not_finite" in page
    tree = ET.fromstring(f"<div>{page}</div>")
    rows = tree.findall("./table/tr")
    assert len(rows) == 1 + len(list(whole.layout.values()))
    svg = "{http://www.w3.org/2000/svg}"
    heights = [float(bar.get("height", "0")) for bar in rows[1].findall(f".//{svg}rect")]
    assert 1 <= len(heights) <= 5  # five orbits have a number
    assert max(heights) == 28.0


class Foreign:
    """An array of another library: DLPack, and a refusal of ``__array__`` where one is asked for."""

    def __init__(self, values: Any, *, far: bool = False) -> None:
        self.values, self.far = np.asarray(values, dtype=np.float32), far

    def __dlpack__(self, **options: Any) -> Any:
        if self.far:
            raise BufferError("this memory belongs to another device")
        return self.values.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return (2, 0) if self.far else self.values.__dlpack_device__()


class Refusing(Foreign):
    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        raise TypeError("implicit conversion is not allowed")


@pytest.mark.parametrize("kind", [Foreign, Refusing])
def test_arrays_come_in_by_dlpack(kind: type[Foreign]) -> None:
    values = np.array([0.9, 1.25], dtype=np.float32)
    assert same(batch(kind(values)), batch(values.astype(float)))
    with pytest.raises(InvalidInputError, match=r"q\[r\].*bring it there first"):
        batch(kind(values, far=True))


class Negated(Foreign):
    """As a tensor of torch with its negative bit set: DLPack gives the memory, whose sign is the other one."""

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        raise RuntimeError("negative bit set; use resolve_neg()")


def test_an_array_that_says_no_is_not_read_past_that() -> None:
    with pytest.raises(InvalidInputError, match=r"q\[r\].*gives no numpy array: negative bit set; use resolve_neg\(\)"):
        batch(Negated([0.9, 1.25]))
