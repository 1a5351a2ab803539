"""Dask arrays in, dask arrays out: lazy, one task a block, the same numbers bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hjsolve

da = pytest.importorskip("dask.array", reason="needs the extra cluster")

R = np.linspace(0.9, 1.6, 6).reshape(2, 3)
P: dict[str, Any] = {"r": 0.1, "theta": 1.1}


def untouchable(block: Any) -> Any:
    raise AssertionError(f"a block of shape {block.shape} was computed")


def test_nothing_is_computed_before_it_is_asked_for() -> None:
    r = da.zeros((4, 6), chunks=(2, 3)).map_blocks(untouchable, dtype=float, meta=np.empty((0, 0)))
    batch = hjsolve.ensemble("kepler-planar", q={"r": r, "theta": 0}, p=P, want={"actions", "turning_points"})
    assert batch.lazy
    assert "lazy" in repr(batch)
    assert batch.shape == batch.actions["r"].shape == batch.status.shape == (4, 6)
    with pytest.raises(AssertionError, match="was computed"):
        batch.actions["r"].compute(scheduler="synchronous")


def test_blocks_types_and_meta_are_right_before_and_after() -> None:
    r = da.from_array(R, chunks=(1, 2))
    batch = hjsolve.ensemble("kepler-planar", q={"r": r, "theta": 0}, p=P, want={"actions", "turning_points"})
    for array in (
        batch.actions["r"],
        batch.error["turning_points"]["r"][1],
        batch.status,
        batch.codes,
        batch.recomputed,
    ):
        assert array.chunks == ((1, 1), (2, 1))
        assert isinstance(array._meta, np.ndarray)
        found = array.compute(scheduler="synchronous")
        assert (found.dtype, found.ndim, found.shape) == (array.dtype, array._meta.ndim, R.shape)
        assert array._meta.dtype == array.dtype


def test_one_block_is_one_task_however_many_columns_are_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    from hjsolve.ensembles import dask_blocks

    shapes = []
    compute = dask_blocks.compute_columns
    monkeypatch.setattr(dask_blocks, "compute_columns", lambda task, q, *rest, **more: (shapes.append(q[0].shape), compute(task, q, *rest, **more))[1])  # fmt: skip
    r = da.from_array(R, chunks=(1, 2))
    batch = hjsolve.ensemble("kepler-planar", q={"r": r, "theta": 0}, p=P, want={"actions", "constants"})
    batch.compute(scheduler="synchronous")
    assert sorted(shapes) == [(1,), (1,), (2,), (2,)]


def test_results_are_those_of_arrays_bit_for_bit() -> None:
    theta = da.from_array(np.linspace(0, 1, 3), chunks=3)
    r = da.from_array(R.astype(np.float32), chunks=(2, 2))
    lazy = hjsolve.ensemble("kepler-planar", q={"r": r, "theta": theta}, p=P)
    plain = hjsolve.ensemble("kepler-planar", q={"r": R.astype(np.float32), "theta": np.linspace(0, 1, 3)}, p=P)
    found = lazy.compute(scheduler="threads")
    assert not found.lazy
    assert found.compute() is found
    assert found.columns.keys() == plain.columns.keys()
    assert all(found.columns[name].tobytes() == column.tobytes() for name, column in plain.columns.items())
    assert lazy.summary() == plain.summary()
    assert (lazy.status.compute(scheduler="threads") == plain.status).all()


def test_blocks_of_unknown_size_and_complex_blocks_are_refused_at_the_door() -> None:
    r = da.from_array(R.ravel(), chunks=2)
    with pytest.raises(hjsolve.InvalidInputError, match=r"q\[r\].*compute_chunk_sizes"):
        hjsolve.ensemble("kepler-planar", q={"r": r[r > 1], "theta": 0}, p=P)
    with pytest.raises(hjsolve.InvalidInputError, match=r"q\[r\]: must hold real numbers, not complex128"):
        hjsolve.ensemble("kepler-planar", q={"r": r.astype(complex), "theta": 0}, p=P)


def test_states_from_actions_are_lazy_and_those_of_each_block_bit_for_bit() -> None:
    J = np.linspace(0.05, 0.6, 6).reshape(2, 3)
    J[1, 1] = np.nan
    given: dict[str, Any] = {"r": da.from_array(J, chunks=(1, 2)), "theta": 1.1}
    angles = {"theta": da.from_array(np.linspace(0, 3, 3), chunks=3)}
    lazy = hjsolve.ensemble("kepler-planar", actions=given, angles=angles)
    assert lazy.lazy
    assert lazy.q["r"].chunks == lazy.error["p"]["r"].chunks == ((1, 1), (2, 1))
    found = lazy.compute(scheduler="threads")
    assert found.status.tolist() == [["ok"] * 3, ["ok", "not_finite", "ok"]]
    for part in ((slice(0, 1), slice(0, 2)), (slice(1, 2), slice(2, 3))):
        θ = np.linspace(0, 3, 3)[part[1]]
        plain = hjsolve.ensemble("kepler-planar", actions={"r": J[part], "theta": 1.1}, angles={"theta": θ})
        assert found.columns.keys() == plain.columns.keys()
        for name, column in plain.columns.items():
            assert lazy.columns[name].dtype == column.dtype
            assert found.columns[name][part].tobytes() == column.tobytes(), name


def test_states_from_actions_are_not_computed_before_they_are_asked_for() -> None:
    J = da.zeros((4, 6), chunks=(2, 3)).map_blocks(untouchable, dtype=float, meta=np.empty((0, 0)))
    batch = hjsolve.ensemble("kepler-planar", actions={"r": J, "theta": 1})
    assert batch.q["r"].shape == batch.status.shape == (4, 6)
    with pytest.raises(AssertionError, match="was computed"):
        batch.q["r"].compute(scheduler="synchronous")


def test_a_task_of_states_can_be_sent_to_other_processes() -> None:
    import pickle

    batch = hjsolve.ensemble("kepler-planar", actions={"r": da.from_array([0.1, 0.2], chunks=1), "theta": 1})
    again = pickle.loads(pickle.dumps(batch.q["r"]))
    whole = hjsolve.ensemble("kepler-planar", actions={"r": [0.1, 0.2], "theta": 1})
    claims = whole.error["q"]["r"]  # of states the last bits depend on the rest of the batch
    assert (abs(again.compute(scheduler="synchronous") - whole.q["r"]) <= 2 * claims).all()
