"""Ensembles as functions of JAX: derivatives against closed forms and the batch's own, and what JAX does with them."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import hjsolve

jax = pytest.importorskip("jax", reason="needs the extra jax")
jax.config.update("jax_enable_x64", True)
import hjsolve.jax  # noqa: E402

Q = {"r": np.array([1.0, 0.7, 1.3, 1.0]), "theta": 0.3}
P = {"r": np.array([0.1, -0.2, 0.3, 2.0]), "theta": np.array([0.9, 0.8, 0.4, 1.0])}  # the last one escapes


@pytest.fixture(scope="module")
def orbits():
    return hjsolve.jax.ensemble("kepler-planar")


def kepler(q, p):
    """J_r and Ω of Kepler's problem with m = k = 1, in JAX."""
    E = p["r"] ** 2 / 2 + p["theta"] ** 2 / (2 * q["r"] ** 2) - 1 / q["r"]
    return 1 / jax.numpy.sqrt(-2 * E) - jax.numpy.abs(p["theta"]), (-2 * E) ** 1.5


def test_values_errors_and_statuses_are_those_of_the_ensemble(orbits):
    found, batch = orbits(Q, P), hjsolve.ensemble("kepler-planar", Q, P, want={"actions", "frequencies"})
    for quantity in ("actions", "frequencies"):
        for name in ("r", "theta"):
            np.testing.assert_array_equal(found[quantity][name], getattr(batch, quantity)[name])
            np.testing.assert_array_equal(found["error"][quantity][name], batch.error[quantity][name])
    assert found["status"].tolist() == batch.codes.tolist() == [0, 0, 0, int(hjsolve.Status.UNBOUNDED)]


@pytest.mark.parametrize("quantity", ["actions", "frequencies"])
def test_gradients_are_those_of_the_closed_forms(orbits, quantity):
    def sums(q, p, of):
        return jax.numpy.sum(of(q, p)[:3])

    k = ("actions", "frequencies").index(quantity)
    given = ({c: jax.numpy.broadcast_to(jax.numpy.asarray(v, float), 4) for c, v in x.items()} for x in (Q, P))
    q, p = given
    own = jax.grad(sums, (0, 1))(q, p, lambda q, p: orbits(q, p)[quantity]["r"])
    true = jax.grad(sums, (0, 1))(q, p, lambda q, p: kepler(q, p)[k])
    for mine, exact in zip(own, true, strict=True):
        for c in ("r", "theta"):
            np.testing.assert_allclose(mine[c][:3], exact[c][:3], rtol=1e-11, atol=1e-14)


@pytest.mark.nightly
def test_jit_vmap_and_a_product_with_the_transposed_matrix(orbits):
    def row(x):
        found = orbits({"r": x[0], "theta": x[1]}, {"r": x[2], "theta": x[3]})
        return jax.numpy.stack([found["actions"]["r"], found["frequencies"]["theta"]])

    x = jax.numpy.array([[1.0, 0.3, 0.1, 0.9], [0.7, 0.1, -0.2, 0.8]])
    together = jax.jit(jax.vmap(jax.jacfwd(row)))(x)
    backwards = jax.vmap(jax.jacrev(row))(x)
    alone = jax.numpy.stack([jax.jacfwd(row)(one) for one in x])
    assert together.shape == (2, 2, 4)
    np.testing.assert_array_equal(together, alone)
    np.testing.assert_allclose(backwards, together, rtol=1e-14, atol=0)


def test_derivatives_of_an_orbit_that_escapes_are_nan_and_others_are_not(orbits):
    slopes = jax.vmap(jax.grad(lambda l: orbits({"r": 1.0, "theta": 0.0}, {"r": 0.1, "theta": l})["frequencies"]["r"]))
    found = slopes(jax.numpy.array([0.9, 2.0]))
    assert np.isfinite(found[0])
    assert np.isnan(found[1])


def test_what_has_no_derivatives_is_refused(orbits):
    with pytest.raises(hjsolve.InvalidInputError, match=r"angles.*take actions or frequencies"):
        hjsolve.jax.ensemble("kepler-planar", want={"angles"})
    with pytest.raises(hjsolve.InvalidInputError, match="q: give r, theta, not r"):
        orbits({"r": 1.0}, P)
    for q in (3, {"r": "one", "theta": 0.0}, {"r": np.ones(3), "theta": np.ones(2)}):
        with pytest.raises(hjsolve.InvalidInputError):
            orbits(q, P)
    for wrong in ({"want": 3}, {"parameters": 3}, {"parameters": {"k": "one"}}, {"threads": "two"}):
        with pytest.raises(hjsolve.InvalidInputError):
            hjsolve.jax.ensemble("kepler-planar", **wrong)
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(hjsolve.InvalidInputError, match="jax_enable_x64"):
            orbits(Q, P)
    finally:
        jax.config.update("jax_enable_x64", True)


@pytest.mark.nightly
def test_without_jax_one_error_says_what_to_install():
    code = "import sys; sys.modules['jax'] = None; import hjsolve.jax"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert 'MissingExtraError: hjsolve.jax needs JAX: pip install "hjsolve[jax]"' in done.stderr
