"""Tunes of particles in the integrable lens of Danilov and Nagaitsev, against frequency analysis of tracked orbits.

    python -m benchmarks.lens_tunes [PARTICLES] [PERIODS] [TRACKED]

The ensemble is given x, y and their velocities; its frequencies Ω_ν and Ω_μ are the tunes of x and y. TRACKED of the
particles are followed by heyoka's Taylor integration for PERIODS times 2π, by equations that know nothing of elliptic
coordinates: with z = x + iy the lens is V = (x² + y²)/2 + Re(z f(z))/5, f = arcsin z/√(1 − z²), (1 − z²) f′ = z f + 1,
and f is integrated along with z. The frequencies of x(t) and y(t) are the maxima of their Fourier integrals with a
window cos⁸ (Laskar, Physica D 67 (1993) 257). Where another line is so near that the window does not part them, and the
two differ by more than 10⁻¹⁰, the orbit is followed 16 times as long. Printed: the largest differences, and times.
"""

from __future__ import annotations

import cmath
import sys
import time
from collections.abc import Sequence
from typing import Any

import heyoka as hy
import numpy as np

import hjsolve
from benchmarks.charted_systems import system_named

_STRENGTH, _PER_PERIOD, _WINDOW = -0.2, 24, 4
_CLOSE, _LONGER = 1e-10, 16


def particles(count: int, seed: int = 1) -> Any:
    """Return starts x, y, vx, vy inside |x| < 1, well away from the foci; shape (4, count)."""
    dice = np.random.default_rng(seed)
    return np.concatenate([dice.uniform(-0.5, 0.5, (2, count)), dice.uniform(-0.4, 0.4, (2, count))])


def tracker() -> Any:
    """Return the equations of x, y, their velocities, and f."""
    x, y, vx, vy, a, b = hy.make_vars("x", "y", "vx", "vy", "a", "b")
    real, imaginary = 1.0 - x * x + y * y, -2.0 * x * y  # 1 − z²
    size = real * real + imaginary * imaginary
    above, beside = x * a - y * b + 1.0, x * b + y * a  # z f + 1
    da, db = (above * real + beside * imaginary) / size, (beside * real - above * imaginary) / size  # f′
    force_x = a + x * da - y * db  # Re (z f)′
    force_y = b + x * db + y * da  # Im (z f)′
    equations = [
        (x, vx), (y, vy), (vx, -x + _STRENGTH * force_x), (vy, -y - _STRENGTH * force_y),
        (a, da * vx - db * vy), (b, da * vy + db * vx),
    ]  # fmt: skip
    return hy.taylor_adaptive(equations, [0.1] * 6, tol=1e-16)


def track(flow: Any, start: Any, times: Any) -> Any:
    """Follow a particle: x and y at the times, shape (2, times)."""
    z = complex(start[0], start[1])
    f = cmath.asin(z) / cmath.sqrt(1 - z * z)
    flow.time = 0.0
    flow.state[:] = [*start, f.real, f.imag]
    return flow.propagate_grid(times)[-1][:, :2].T


def frequency(signal: Any, times: Any) -> float:
    """Return the frequency of the largest line of a signal."""
    span = times[-1] - times[0]
    phase = np.pi * (2 * (times - times[0]) / span - 1)
    windowed = (signal - np.mean(signal)) * (1 + np.cos(phase)) ** _WINDOW
    spectrum = np.abs(np.fft.rfft(windowed))
    width = 2 * np.pi / (len(times) * (times[1] - times[0]))
    middle = times - (times[0] + times[-1]) / 2

    def slope(ω: float) -> float:
        wave = np.exp(-1j * ω * middle)
        total, moved = wave @ windowed, (-1j * middle * wave) @ windowed
        return float((np.conj(total) * moved).real)

    ω = width * int(np.argmax(spectrum[1:]) + 1)
    low, high = ω - width, ω + width
    for _ in range(60):
        middle_ω = (low + high) / 2
        low, high = (middle_ω, high) if slope(middle_ω) > 0 else (low, middle_ω)
    return (low + high) / 2


def main() -> None:
    """Print the comparison."""
    count, periods, tracked = (int(a) for a in (sys.argv[1:] + ["1000", "600", "1000"][len(sys.argv) - 1 :])[:3])
    starts = particles(count)
    begin = time.process_time()
    solution = hjsolve.solve(system_named("lens (Danilov–Nagaitsev)"), coordinates="find")
    solved = time.process_time() - begin
    q, v = ({"x": a[0], "y": a[1]} for a in (starts[:2], starts[2:]))
    begin = time.process_time()
    batch = hjsolve.ensemble(solution, q=q, velocity=v, want="frequencies", threads=1)
    spent = time.process_time() - begin
    print(f"solved in {solved:.1f} s; {count} particles in {spent:.2f} s ({spent / count * 1e6:.0f} µs each)")
    print(batch.summary(), "largest claim", *(f"{np.nanmax(e):.1e}" for e in batch.error["frequencies"].values()))
    flow, begin, off, longer = tracker(), time.process_time(), [], 0
    for k in range(min(tracked, count)):
        mine = [abs(batch.frequencies[name][k]) for name in ("nu", "mu")]
        apart = differences(flow, starts[:, k], periods, mine)
        if max(apart) > _CLOSE:
            longer += 1
            print(f"particle {k}: {apart[0]:.1e}, {apart[1]:.1e} over {periods} periods", flush=True)
            apart = differences(flow, starts[:, k], periods * _LONGER, mine)
        off.append(apart)
    worst = np.array(off)
    print(f"{len(off)} tracked over {periods} periods, {longer} of them {_LONGER} times as long, "
          f"in {time.process_time() - begin:.1f} s")  # fmt: skip
    print(f"largest difference of the tunes of x {worst[:, 0].max():.1e}, of y {worst[:, 1].max():.1e}")
    print(f"95 of 100 are below {np.quantile(worst, 0.95):.1e}; above 1e-9: {int((worst > 1e-9).sum())}")


def differences(flow: Any, start: Any, periods: int, tunes: Sequence[float]) -> list[float]:
    """How far the tunes are from the frequencies of the tracked orbit."""
    times = np.arange(periods * _PER_PERIOD + 1) * 2 * np.pi / _PER_PERIOD
    return [abs(frequency(z, times) - tune) for z, tune in zip(track(flow, start, times), tunes, strict=True)]


if __name__ == "__main__":
    main()
