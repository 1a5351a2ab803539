"""A first pass in doubles gives up at the turning points what it would only integrate in vain, and little else."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.arithmetic.machine.compiling import available
from hjsolve.arithmetic.number_types import Mask
from hjsolve.ensembles import engine as batch
from hjsolve.ensembles.engine import Status, passes
from hjsolve.ensembles.engine.engine import GOOD
from hjsolve.ensembles.engine.orbit_regions import LocatedRegions
from hjsolve.ensembles.engine.regions import hopeless_in_doubles
from hjsolve.ensembles.engine.starts import given_momenta
from tests.support import kuzmin_kutuzov as galaxy

WANTED = [("actions",), ("actions", "frequencies"), ("actions", "frequencies", "angles")]


def nobody(found: LocatedRegions, *, kernels: bool) -> Mask:
    """Give up no orbit."""
    return np.zeros(len(found.region.width), dtype=bool)


@pytest.mark.parametrize("want", WANTED, ids="+".join)
def test_what_is_given_up_would_have_been_lost(want: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    data = galaxy.load()
    engine = batch.build(galaxy.solution(), frozenset(want), compiled=False)
    q, p = galaxy.start(data["prolate"])
    starts = given_momenta(*(np.stack([np.asarray(side[n]) for n in engine.model.names]) for side in (q, p)))
    tried = np.flatnonzero(~hopeless_in_doubles(engine.model, starts, kernels="frequencies" in want))

    def first_pass() -> Mask:
        columns = passes.run_pass(engine.model, dict(engine.names), starts.take(tried), depth=0, tolerance=GOOD)
        done: Mask = columns.status == Status.OK
        return done

    done = first_pass()
    monkeypatch.setattr(passes, "beyond_doubles", nobody)
    would = first_pass()
    assert not (done & ~would).any()
    assert (would & ~done).sum() <= 0.1 * would.sum()
    hard = np.isin(data["family"][tried], (3, 4))  # nearly radial, nearly unbound
    assert hard.sum() > 60
    assert would[hard].mean() < 0.15


@pytest.mark.skipif(not available(), reason="numba is not installed")
def test_a_far_apocentre_takes_512_nodes() -> None:
    """A speed of 1 − 1e−10 of that of escape: u reaches 23, and numpy's integrals up to the start need 512 nodes."""
    star = np.array([[1.0138355435025441, 0.19854650419868872, -1.0418900478857982, 1.2214055478808477,
                      -0.017136258934986548]])  # fmt: skip
    want = frozenset({"actions", "frequencies", "angles"})
    one, other = (
        batch.build(galaxy.solution(), want, compiled=compiled).run(*galaxy.start(star)) for compiled in (False, True)
    )
    assert one.status[0] == other.status[0] == Status.OK
    for key, error in one.error.items():
        quantity, name = key.split(".")
        apart = abs(one.group(quantity)[name] - other.group(quantity)[name])
        assert (apart <= error + other.error[key]).all(), key
