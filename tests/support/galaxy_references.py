"""Actions, frequencies and angles of the orbits of ``kuzmin_kutuzov.npz``, to 32 digits, for tests of claimed errors.

    python tests/support/galaxy_references.py

writes ``galaxy_claims.npz``. The starts are the file's prolate ones as exact doubles, which are its cylindrical ones
carried over and rounded, bit for bit (checked here), so one reference serves both inputs. Everything is from the textbook integrals over u and w by the double exponential rule (Takahasi & Mori, Publ. RIMS 9 (1974) 721) in
170 digits, and shares nothing with hjsolve: with √(c² + …) of a Kuzmin-Kutuzov galaxy with GM = d = 1,

    p_u² = 2E sinh²u - 2α - L²/sinh²u + 2√(c² + cosh²u),    p_w² = 2E cos²w + 2α - L²/cos²w - 2√(c² + sin²w).

The step is halved until two results agree to 34 digits. Actions and frequencies are compared with the file's own, which come from ball arithmetic on another form of the integrals.
"""

from __future__ import annotations

import multiprocessing
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

HERE = Path(__file__).parent
QUANTITIES = (
    "actions.u", "actions.w", "frequencies.u", "frequencies.w", "frequencies.phi", "angles.u", "angles.w", "angles.phi",
)  # fmt: skip
LONGITUDE = 0.3
"""φ of every start, as in ``kuzmin_kutuzov.start``."""

_DIGITS = 170
_AGREE = mpf(10) ** -34
_SPAN = mpf("4.75")
Vector = list[Any]


class Wing:
    """One of the two coordinates: p² and its derivatives by E, α, L, each divided by two."""

    def __init__(self, name: str, constants: tuple[Any, Any, Any]) -> None:
        self.name, self.constants, self.c2 = name, constants, mpf(1) / 24

    def __call__(self, x: Any) -> tuple[Any, Vector]:
        E, α, L = self.constants
        if self.name == "u":
            s2 = mpmath.sinh(x) ** 2
            return 2 * E * s2 - 2 * α - L * L / s2 + 2 * mpmath.sqrt(self.c2 + 1 + s2), [s2, mpf(-1), -L / s2]
        c2 = mpmath.cos(x) ** 2
        return 2 * E * c2 + 2 * α - L * L / c2 - 2 * mpmath.sqrt(self.c2 + 1 - c2), [c2, mpf(1), -L / c2]


def turning_point(wing: Wing, start: Any, side: int) -> Any:
    """The first zero of p² on one side: steps that grow from nothing, then bisection, then Newton's method."""
    floor = mpf(0) if wing.name == "u" and side < 0 else None if wing.name == "u" else side * mpmath.pi / 2
    inner, step = start, mpf(10) ** -30
    while True:
        x = inner + side * step
        if floor is not None and side * (x - floor) > -side * (floor - inner) / 2:
            x = (inner + floor) / 2
        if wing(x)[0] < 0:
            break
        inner, step = x, 1.4 * step
    outer = x
    for _ in range(520):
        middle = (inner + outer) / 2
        inner, outer = (middle, outer) if wing(middle)[0] >= 0 else (inner, middle)
    return (inner + outer) / 2


def over(wing: Wing, low: Any, high: Any) -> Vector:
    """∫ p dq, ∫ (½ ∂p²/∂c) dq/p between two places, turning points or not."""
    width, known = high - low, None
    h = mpf(1) / 8
    total = _nodes(wing, low, width, h, mpf(0))
    for _ in range(10):
        result = [h * part for part in total]
        if known is not None and all(abs(a - b) <= _AGREE * abs(a) for a, b in zip(result, known, strict=True)):
            return result
        known = result
        total = [a + b for a, b in zip(total, _nodes(wing, low, width, h, h / 2), strict=True)]
        h /= 2
    raise ArithmeticError("the integral does not converge")


def _nodes(wing: Wing, low: Any, width: Any, h: Any, shift: Any) -> Vector:
    sums = [mpf(0)] * 4
    for k in range(int(-_SPAN / h), int(_SPAN / h) + 1):
        t = k * h + shift
        libration = mpmath.pi * mpmath.sinh(t)
        x, y = 1 / (1 + mpmath.exp(-libration)), 1 / (1 + mpmath.exp(libration))
        place = low + width * x if x < y else low + width - width * y
        squared, kernels = wing(place)
        if squared <= 0:  # nothing is left of the weight there
            continue
        weight = width * mpmath.pi * mpmath.cosh(t) * x * y / mpmath.sqrt(squared)
        sums = [a + b * weight for a, b in zip(sums, [squared, *kernels], strict=True)]
    return sums


def orbit(row: Any) -> Vector:
    """The quantities of one start u, w, p_u, p_w, L."""
    u, w, pu, pw, L = (mpf(float(x)) for x in row)
    c2, s2, k2 = mpf(1) / 24, mpmath.sinh(u) ** 2, mpmath.cos(w) ** 2
    own = [pu**2 / 2 + L * L / (2 * s2) - mpmath.sqrt(c2 + 1 + s2), pw**2 / 2 + L * L / (2 * k2)]
    own[1] += mpmath.sqrt(c2 + 1 - k2)
    E = sum(own) / (s2 + k2)
    constants = E, E * s2 - own[0], L
    actions, means, runs = [], [], []
    for name, place, momentum in (("u", u, pu), ("w", w, pw)):
        wing = Wing(name, constants)
        low, high = (turning_point(wing, place, side) for side in (-1, 1))
        J, *slopes = (part / mpmath.pi for part in over(wing, low, high))
        run = over(wing, low, place)[1:]
        actions.append(J)
        means.append(slopes)
        runs.append([mpmath.sign(momentum) * part for part in run])
    (a, b, mu), (c, d, mw) = means
    det = a * d - b * c
    Ωu, Ωw = d / det, -b / det  # Ω_u a + Ω_w c = 1, Ω_u b + Ω_w d = 0
    G = [runs[0][j] + runs[1][j] for j in range(3)]
    θu, θw = (d * G[0] - c * G[1]) / det, (a * G[1] - b * G[0]) / det
    θφ = mpf(LONGITUDE) + G[2] - mu * θu - mw * θw
    turn = 2 * mpmath.pi
    angles = [θ - turn * mpmath.nint(θ / turn) for θ in (θu, θw, θφ)]
    return [*actions, Ωu, Ωw, -(mu * Ωu + mw * Ωw), *angles]


def parts(values: Any) -> tuple[Any, Any]:
    """Two doubles for every number."""
    high = np.array([[float(x) for x in row] for row in values])
    low = [
        [float(x - float(h)) for x, h in zip(row, tops, strict=True)] for row, tops in zip(values, high, strict=True)
    ]
    return high, np.array(low)


def carried(cylindrical: Any) -> Any:
    """Rows R, v_R, v_T, z, v_z as rounded rows u, w, p_u, p_w, L: sinh(u + iw) = R + iz."""
    rows = []
    for row in cylindrical:
        R, vR, vT, z, vz = (mpf(float(x)) for x in row)
        place = mpmath.asinh(mpmath.mpc(R, z))
        slope = mpmath.cosh(place)
        A, B = slope.real, slope.imag
        rows.append([place.real, place.imag, A * vR + B * vz, A * vz - B * vR, R * vT])
    return np.array([[float(x) for x in row] for row in rows])


def prepared() -> None:
    mpmath.mp.dps = _DIGITS


def main() -> None:
    prepared()
    with np.load(HERE / "kuzmin_kutuzov.npz") as file:
        data = dict(file)
    rows = data["prolate"]
    assert np.array_equal(rows, carried(data["cylindrical"]))
    with multiprocessing.Pool(initializer=prepared) as pool:
        high, low = parts(pool.map(orbit, list(rows), chunksize=4))
    for mine, theirs in enumerate((0, 1, 2, 4, 3)):
        gap = high[:, mine] - data["reference_prolate_high"][:, theirs]
        gap += low[:, mine] - data["reference_prolate_low"][:, theirs]
        assert np.max(np.abs(gap / high[:, mine])) < 1e-30, QUANTITIES[mine]
    np.savez_compressed(HERE / "galaxy_claims.npz", high=high, low=low)


if __name__ == "__main__":
    main()
