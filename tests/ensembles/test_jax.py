"""Ensembles as functions of JAX: derivatives against closed forms and the batch's own, and what JAX does with them."""

from __future__ import annotations

import math
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


def test_all_is_computed_with_subnormal_numbers_though_jax_takes_them_for_0(orbits, monkeypatch):
    """JAX calls back with flags of the processor under which bounds on errors need not hold."""
    tiny = np.array([5e-324, 1e-310])
    seen = []
    for name in ("values", "derivatives"):
        own = getattr(hjsolve.jax._Outside, name)
        monkeypatch.setattr(
            hjsolve.jax._Outside, name, lambda self, *x, own=own: seen.append(tiny * np.ones(2)) or own(self, *x)
        )
    jax.jit(jax.grad(lambda l: orbits({"r": 1.0, "theta": 0.0}, {"r": 0.1, "theta": l})["actions"]["r"]))(0.9)
    orbits({"r": 1.0, "theta": 0.0}, {"r": 0.1, "theta": 0.9})
    assert len(seen) == 2
    np.testing.assert_array_equal(seen, [tiny, tiny])


def test_an_ensemble_where_subnormal_numbers_are_0():
    """The cell about 0 of the table of disks has no width there."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/5")

    def action(x):
        return hjsolve.ensemble(system, q={"x": np.asarray(x)}, p={"x": 0.0}, want={"actions"}).actions["x"]

    found = jax.pure_callback(action, jax.ShapeDtypeStruct((), np.float64), jax.numpy.asarray(2.0))
    # J = (2/π) √(2E) x ∫₀¹ √(1 − s⁴) ds
    exact = 2 / np.pi * np.sqrt(2 * 16 / 5) * 2 * np.sqrt(np.pi) * math.gamma(1.25) / (2 * math.gamma(1.75))
    np.testing.assert_allclose(found, exact, rtol=1e-14, atol=0)


def test_derivatives_that_there_are_not_are_refused_where_they_are_asked_for(orbits):
    def action(l):
        return orbits({"r": 1.0, "theta": 0.0}, {"r": 0.1, "theta": l})["actions"]["r"]

    with pytest.raises(hjsolve.InvalidInputError, match="no second derivatives"):
        jax.grad(jax.grad(action))(0.9)
    with pytest.raises(hjsolve.InvalidInputError, match=r"parameter k: expected one finite real number, got .*Tracer"):
        jax.grad(lambda k: hjsolve.jax.ensemble("kepler-planar", parameters={"k": k})(Q, P)["actions"]["r"][0])(1.0)
    kinked = hjsolve.jax.ensemble(hjsolve.System({"x": "line"}, "dot(x)**2/2", "abs(x)"))
    assert kinked({"x": 0.2}, {"x": 1.0})["status"] == 0
    with pytest.raises(hjsolve.InvalidSystemError, match="kink"):
        jax.grad(lambda p: kinked({"x": 0.2}, {"x": p})["actions"]["x"])(1.0)
    mixed = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**4/4 + y**4/4 + 3*x**2*y**2/2")
    with pytest.raises(hjsolve.InvalidInputError, match=r"give solution\.system"):
        hjsolve.jax.ensemble(hjsolve.solve(mixed, coordinates="find"))


@pytest.mark.nightly
def test_without_jax_one_error_says_what_to_install():
    code = "import sys; sys.modules['jax'] = None; import hjsolve.jax"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert 'MissingExtraError: hjsolve.jax needs JAX: pip install "hjsolve[jax]"' in done.stderr
