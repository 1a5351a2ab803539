"""Batches on axes: every orbit at its own numbers, errors that can be seen, orbits without numbers counted."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve

pytest.importorskip("matplotlib").use("Agg")


@pytest.fixture(scope="module")
def batch() -> hjsolve.Batch:
    kepler = hjsolve.catalog.load("kepler-planar")
    v = np.array([0.8, 1.0, 1.2, 1.5, 1.3])  # the fourth escapes
    q, p = {"r": np.ones(5), "theta": np.zeros(5)}, {"r": np.full(5, 0.1), "theta": v}
    return hjsolve.ensemble(kepler, q=q, p=p, want={"actions", "frequencies"})


def test_every_orbit_is_a_point_at_its_numbers(batch: hjsolve.Batch) -> None:
    ax = batch.plot("actions.r", "frequencies.r", colour="actions.theta")
    points = np.asarray(ax.collections[0].get_offsets())
    there = np.isfinite(batch.actions["r"])
    assert there.sum() == 4
    np.testing.assert_array_equal(points[:, 0], batch.actions["r"][there])
    np.testing.assert_array_equal(points[:, 1], batch.frequencies["r"][there])
    assert ax.get_title() == "1 of 5 orbits omitted (no values)"
    # Kepler's third law, Ω = k² m/(J_r + J_θ)³, between the axes and the colour
    shade = np.asarray(ax.collections[0].get_array())
    np.testing.assert_allclose(points[:, 1], (points[:, 0] + shade) ** -3.0, rtol=1e-12)


def test_errors_are_drawn_where_they_can_be_seen(batch: hjsolve.Batch) -> None:
    assert len(batch.plot("actions.r", "frequencies.r").collections) == 1
    columns = dict(batch.columns)
    columns["error.actions.r"] = np.array([0.0, 0.2, 0.0, np.nan, 0.0])
    approximate = hjsolve.Batch(columns, batch.layout, batch.shape)
    bars = approximate.plot("actions.r", "frequencies.r").collections[1].get_segments()
    assert len(bars) == 1
    np.testing.assert_allclose(np.ptp(bars[0][:, 0]), 0.4, rtol=1e-12)


def test_the_first_two_columns_are_drawn_where_none_is_named(batch: hjsolve.Batch) -> None:
    ax = batch.plot()
    names = [n for n in batch.columns if n.startswith(("actions", "frequencies"))][:2]
    found = np.asarray(ax.collections[0].get_offsets())
    there = np.isfinite(batch.columns[names[0]]) & np.isfinite(batch.columns[names[1]])
    np.testing.assert_array_equal(found[:, 1], batch.columns[names[1]][there])


@pytest.mark.parametrize("names", [("actions.x", None), (None, "status"), ("error.actions.r", None)])
def test_what_is_no_column_of_numbers_is_refused(names: tuple[str | None, str | None], batch: hjsolve.Batch) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match="not a numeric column"):
        batch.plot(*names)
    with pytest.raises(hjsolve.InvalidInputError, match="axes of matplotlib"):
        batch.plot(ax=3)
