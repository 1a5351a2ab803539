"""Roots of arrays of polynomials: against polynomials made of known roots, and 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from hjsolve.arithmetic import polynomial_roots
from hjsolve.arithmetic.polynomial_roots import real_roots


def from_roots(leading: float, roots: list[complex]) -> list[float]:
    """Coefficients, rounded once from 50 digits."""
    with mpmath.workdps(50):
        made = [mpmath.mpf(leading)]
        for root in roots:
            made = [a - mpmath.mpc(root) * b for a, b in zip([*made, 0], [0, *made], strict=True)]
        return [float(mpmath.re(c)) for c in made]


def exact_real_roots(coefficients: list[float]) -> list[mpmath.mpf]:
    with mpmath.workdps(50):
        while coefficients[-1] == 0 and len(coefficients) > 2:
            return sorted([mpmath.mpf(0), *exact_real_roots(coefficients[:-1])])
        found = mpmath.polyroots([mpmath.mpf(c) for c in coefficients], maxsteps=400, extraprec=400)
        size = max(abs(r) for r in found)
        return sorted(mpmath.re(r) for r in found if abs(mpmath.im(r)) <= 1e-25 * size)


def drawn(degree: int, seed: int) -> list[list[float]]:
    """Polynomials of all sorts: roots of one size, of many sizes, in pairs, nearly meeting, moved far, biquadratic."""
    draw = np.random.default_rng([degree, seed])
    made = []
    for _ in range(120):
        pairs = draw.integers(0, degree // 2 + 1)
        size = 10.0 ** draw.uniform(-8, 8)
        spread = draw.choice([0.0, 1.0, 3.0])
        real = list(draw.normal(size=degree - 2 * pairs) * 10 ** draw.uniform(-spread, spread, degree - 2 * pairs))
        if draw.random() < 0.2 and len(real) > 1:
            real[1] = real[0] * (1 + 10 ** draw.uniform(-14, -2))
        if draw.random() < 0.2:
            real = [r + 1000 for r in real]
        if draw.random() < 0.2 and len(real) > 1:
            real[0] = -real[1]
        roots: list[complex] = [complex(r * size) for r in real]
        for _ in range(pairs):
            z = complex(draw.normal(), draw.normal() * 10 ** draw.uniform(-6, 0)) * size
            roots += [z, z.conjugate()]
        made.append(from_roots(draw.choice([-1, 1]) * 10 ** draw.uniform(-3, 3), roots))
    return made


@pytest.mark.rotating(3)
@pytest.mark.nightly_cases("0-5", "1-5")
@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("seed", [0, 1])
def test_certain_roots_are_those_of_fifty_digits(degree: int, seed: int) -> None:
    made = drawn(degree, seed)
    roots, unsure = real_roots([np.array(c) for c in zip(*made, strict=True)])
    assert roots.shape == (degree, len(made))
    certain = 0
    for k, coefficients in enumerate(made):
        if unsure[k]:
            continue
        certain += 1
        exact = exact_real_roots(coefficients)
        assert np.isfinite(roots[:, k]).sum() == len(exact), coefficients
        largest = float(max(abs(r) for r in mpmath.polyroots(coefficients, maxsteps=400, extraprec=400)))
        for got, truth in zip(roots[:, k], exact, strict=False):
            with mpmath.workdps(50):
                slope = sum(
                    (degree - j) * mpmath.mpf(c) * truth ** (degree - 1 - j) for j, c in enumerate(coefficients[:-1])
                )
                terms = sum(abs(mpmath.mpf(c) * truth ** (degree - j)) for j, c in enumerate(coefficients))
                limit = float(4 * degree * 2**-53 * terms / abs(slope)) + 1e-17 * largest
                assert abs(float(got - truth)) <= limit, (coefficients, got, truth)
    assert certain >= 20


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_double_roots_and_no_polynomials_are_not_certain(degree: int) -> None:
    double = from_roots(2.0, [1.5, 1.5, -0.3, 4][:degree])
    nothing = [0.0, *double[1:]]
    unknown = [*double[:-1], float("nan")]
    _, unsure = real_roots([np.array(c) for c in zip(double, nothing, unknown, strict=True)])
    assert unsure.all()


def test_roots_of_biquadratics_and_pure_powers() -> None:
    roots, unsure = real_roots(
        [np.array([1.0, 1, 1]), np.zeros(3), np.array([-5.0, 5, 0]), np.zeros(3), np.array([4.0, 4, -16])]
    )
    assert not unsure.any()
    assert roots[:, 0] == pytest.approx([-2, -1, 1, 2], rel=1e-15, abs=0)
    assert np.isinf(roots[:, 1]).all()
    assert roots[:2, 2] == pytest.approx([-2, 2], rel=1e-15, abs=0)


def test_formulas_and_eigenvalues_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    made = [np.array(c) for c in zip(*drawn(4, 7), strict=True)]
    roots, unsure = real_roots(made)
    monkeypatch.setattr(polynomial_roots, "_FORMULAS", {})
    others, doubtful = real_roots(made)
    both = ~unsure & ~doubtful
    assert both.sum() >= 20
    np.testing.assert_allclose(roots[:, both], others[:, both], rtol=1e-9, atol=0)
