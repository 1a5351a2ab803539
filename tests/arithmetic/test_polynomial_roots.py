"""Roots of arrays of polynomials, proved: against polynomials made of known roots, and 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.polynomial_roots import RealRoots, real_roots


def roots_of_doubles(made: list[list[float]], off: float = 0.0) -> RealRoots:
    """Roots of polynomials whose coefficients are doubles, or may be off by a part of them."""
    columns = [np.array(c) for c in zip(*made, strict=True)]
    return real_roots([Pair(c, 0 * c) for c in columns], [off * abs(c) for c in columns])


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
@pytest.mark.nightly_cases("0-5", "1-5", "0-6", "1-6")
@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("seed", [0, 1])
def test_proved_roots_are_those_of_fifty_digits(degree: int, seed: int) -> None:
    made = drawn(degree, seed)
    found = roots_of_doubles(made)
    assert found.roots.shape == (degree, len(made))
    assert found.unsure.sum() <= 6
    assert (found.errors <= 4 * 2**-52 * abs(found.roots))[np.isfinite(found.roots)].mean() > 0.95
    for k, coefficients in enumerate(made):
        if found.unsure[k]:
            continue
        exact = exact_real_roots(coefficients)
        assert np.isfinite(found.roots[:, k]).sum() == len(exact), coefficients
        for got, off, truth in zip(found.roots[:, k], found.errors[:, k], exact, strict=False):
            with mpmath.workdps(50):
                assert abs(mpmath.mpf(float(got)) - truth) <= off, (coefficients, got, truth)


def test_roots_that_nearly_meet_are_told_apart_until_their_disks_meet() -> None:
    """Pairs 1 ± d and 1 ± id next to other roots; below some ulp of distance nothing is proved of either."""
    for d in (2.0**-10, 2.0**-20, 2.0**-30, 2.0**-40, 2.0**-44):
        for inside, count in ((d * d, 4), (-d * d, 2)):
            # (x² − 2x + 1 − d²)(x + 3)(x − 1/2), exact in two doubles
            with mpmath.workdps(60):
                pair, rest = [1, -2, 1 - mpmath.mpf(inside)], [mpmath.mpf(1), mpmath.mpf("2.5"), mpmath.mpf("-1.5")]
                made = [mpmath.mpf(0)] * 5
                for i, a in enumerate(pair):
                    for j, b in enumerate(rest):
                        made[i + j] += a * b
                pairs = [Pair(np.array([float(c)]), np.array([float(c - float(c))])) for c in made]
                off = [np.array([float(abs(c - p.high[0] - mpmath.mpf(p.low[0])))]) for c, p in zip(made, pairs)]
            found = real_roots(pairs, off)
            assert not found.unsure.any(), (d, inside)
            assert np.isfinite(found.roots).sum() == count
            known = [-3.0, 0.5] if count == 2 else [-3.0, 0.5, 1 - d, 1 + d]
            assert found.roots[:count, 0] == pytest.approx(known, rel=2.0**-51, abs=0)
    # as close as coefficients in one double can say, nothing is proved
    made = [[1.0, -2.0, 1 - d, 0.0] for d in (1e-10, 2.0**-52)]
    assert roots_of_doubles(made, off=2.0**-53).unsure.tolist() == [False, True]


def test_roots_of_very_different_sizes_are_proved() -> None:
    draw = np.random.default_rng(4)
    roots = 10 ** draw.uniform(-10, 10, (400, 4)) * draw.choice([-1, 1], (400, 4))
    made = [from_roots(1.0, [complex(r) for r in own]) for own in roots]
    found = roots_of_doubles(made)
    assert not found.unsure.any()
    np.testing.assert_allclose(found.roots.T, np.sort(roots, axis=1), rtol=1e-9, atol=0)


@pytest.mark.parametrize("decades", [-76, -30, -12, -8, -5, 5, 8, 10, 12, 15, 18, 30, 76])
@pytest.mark.parametrize("degree", [3, 4, 5])
def test_roots_of_one_size_next_to_one_of_another_size_are_proved(degree: int, decades: int) -> None:
    # cosh ξ about two centres with E → 0: turning points at 2 and 1e10
    draw = np.random.default_rng([degree, decades + 100])
    truth = 10 ** draw.uniform(-0.5, 0.5, (200, degree))
    truth[:, 0] *= 10.0**decades
    truth *= draw.choice([-1, 1], truth.shape)
    made = [from_roots(-2.0, [complex(r) for r in roots]) for roots in truth]
    found = roots_of_doubles(made)
    assert not found.unsure.any()
    assert (found.errors <= 2 * 2**-52 * abs(found.roots)).all()
    for coefficients, roots, errors in zip(made[:20], found.roots.T, found.errors.T, strict=False):
        with mpmath.workdps(400):  # a sign change of P about each
            for root, off in zip(roots, errors, strict=True):
                ends = [
                    mpmath.polyval(coefficients, mpmath.mpf(float(root)) + s * mpmath.mpf(float(off))) for s in (-1, 1)
                ]
                assert ends[0] * ends[1] <= 0


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_double_roots_and_no_polynomials_are_not_proved(degree: int) -> None:
    double = from_roots(2.0, [1.5, 1.5, -0.25, 4][:degree])  # no coefficient is rounded
    nothing = [0.0, *double[1:]]
    unknown = [*double[:-1], float("nan")]
    assert roots_of_doubles([double, nothing, unknown]).unsure.all()


def test_an_error_of_the_coefficients_is_part_of_the_proof() -> None:
    """x² − 2ax + a² − 10⁻⁸: with coefficients that are off by 10⁻⁶, roots may be complex."""
    made = [[1.0, -2.0, 1.0 - 1e-8]]
    assert not roots_of_doubles(made).unsure.any()
    assert not roots_of_doubles(made, off=1e-10).unsure.any()
    assert roots_of_doubles(made, off=1e-6).unsure.all()
    wide = roots_of_doubles(made, off=1e-10)
    for sign in (-1, 1):  # roots of the polynomials at the edge are within the bounds
        moved = np.sort(np.roots([1.0, -2.0 * (1 + sign * 1e-10), (1 - 1e-8) * (1 - sign * 1e-10)]))
        assert (abs(wide.roots[:, 0] - moved) <= wide.errors[:, 0]).all()


def test_roots_of_biquadratics_and_pure_powers_and_at_zero() -> None:
    found = roots_of_doubles(
        [[1.0, 0, -5, 0, 4], [1.0, 0, 5, 0, 4], [1.0, 0, 0, 0, -16], [2.0, -6, 4, 0, 0], [1, 0, -1, 0, 0]]
    )
    assert found.unsure.tolist() == [False, False, False, True, True]  # the last ones have a double root at 0
    assert found.roots[:, 0] == pytest.approx([-2, -1, 1, 2], rel=1e-15, abs=0)
    assert np.isinf(found.roots[:, 1]).all()
    assert found.roots[:2, 2] == pytest.approx([-2, 2], rel=1e-15, abs=0)
    (zero,) = roots_of_doubles([[1.0, 0, -4, 0]]).roots.T
    assert zero[1] == 0
    assert zero[[0, 2]] == pytest.approx([-2, 2], rel=1e-15, abs=0)


def test_a_double_root_within_the_errors_is_not_told_apart() -> None:
    """Without the errors of the coefficients the same polynomial has two roots, or none, there."""
    double = from_roots(2.0, [1.5, 1.5, -0.25])
    off = [2.0**-50 * abs(c) for c in double]
    moved = [double[0], double[1], double[2], double[3] * (1 - 2.0**-51)]
    columns = [np.array([c]) for c in moved]
    assert real_roots([Pair(c, 0 * c) for c in columns], [np.array([o]) for o in off]).unsure.all()
    assert not real_roots([Pair(c, 0 * c) for c in columns], [np.array([0.0])] * 4).unsure.any()


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_a_root_beyond_the_doubles_is_not_proved_and_spoils_no_other_polynomial(degree: int) -> None:
    found = roots_of_doubles([[1e-320, *degree * [1.0]], from_roots(1.0, [*range(1, degree + 1)])])
    assert found.unsure.tolist() == [True, False]
    np.testing.assert_array_equal(found.roots[:, 1], range(1, degree + 1))
