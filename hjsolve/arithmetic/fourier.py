"""Discrete Fourier and cosine transforms in any number of digits: the fast transform in fixed-point integers.

Values at the midpoints χₘ = (2m + 1) π/N (of half a turn for an even function: (2m + 1) π/(2N)) give cₖ and sₖ. The
transform splits by the smallest prime factor (Cooley & Tukey, Math. Comp. 19 (1965) 297), the even one runs over the
values in the order 0, 2, 4, …, 5, 3, 1 (Makhoul, IEEE Trans. ASSP 28 (1980) 27). Every step rounds in the last of a
few dozen guard bits, so the coefficients are as good as the values, relative to the largest of them.
"""

from __future__ import annotations

from functools import lru_cache

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf

_GUARD = 24
_PRIMES = (2, 3, 5, 7, 11, 13)

Parts = tuple[list[int], list[int]]
"""Real and imaginary parts of complex numbers, as multiples of 2^−work."""


def smooth(least: int) -> int:
    """Return the smallest number from ``least`` on without a prime factor above 13: its transform is fast.

    Args:
        least: where to begin.
    """
    while _rest(least) > 1:
        least += 1
    return least


def _rest(n: int) -> int:
    for prime in _PRIMES:
        while n % prime == 0:
            n //= prime
    return n


def waves(values: list[Mpf], *, even: bool, bits: int) -> tuple[list[Mpf], list[Mpf]]:
    """Return the coefficients cₖ and sₖ of cos kχ and sin kχ, k = 1, 2, …, below the Nyquist frequency.

    Args:
        values: at the midpoints, ``mpf``, not all zero.
        even: True for values over half a turn; the sₖ are then an empty list.
        bits: precision of the values.

    Returns:
        As ``mpf``, with an error of about 2^−bits times the largest value.
    """
    context, nodes = multiprecision(bits), len(values)
    largest = max(abs(v) for v in values)
    work = bits + 2 * nodes.bit_length() + _GUARD
    fixed = [int(context.nint(context.ldexp(v / largest, work))) for v in values]
    if even:  # the order 0, 2, 4, …, 5, 3, 1 makes a transform of half a turn one of a whole one (Makhoul 1980)
        fixed = fixed[::2] + fixed[1::2][::-1]
    re, im = _transformed(fixed, [0] * nodes, 1, _roots(nodes, work), work)
    turn, top = (4, nodes) if even else (2, (nodes + 1) // 2)
    # the values stand at midpoints: coefficient k is turned by half a step, k times
    cosines, sines = [], []
    for k, (c, s) in enumerate(_turns(turn * nodes, top, work), 1):
        cosines.append(re[k] * c - im[k] * s)
        if not even:
            sines.append(-re[k] * s - im[k] * c)
    scale = 2 * largest / nodes

    def numbers(parts: list[int]) -> list[Mpf]:
        return [context.ldexp(context.mpf(part), -2 * work) * scale for part in parts]

    return numbers(cosines), [] if even else numbers(sines)


def at_midpoints(coefficients: list[tuple[int, int]], turn: int, work: int) -> Parts:
    """Return Σₖ (uₖ + i vₖ) e^{ikψ}, k = 1, 2, …, at ψ = (2m + 1) π/turn for m = 0 … turn − 1.

    Args:
        coefficients: uₖ and vₖ, as multiples of 2^−work, as the sums will be.
        turn: how many places; fast without a prime factor above 13.
    """
    re, im = [0] * turn, [0] * turn
    x, y = _root(2 * turn, work)
    c, s = x, -y  # e^{iπk/turn}, step by step
    for k, (u, v) in enumerate(coefficients, 1):
        re[k % turn] += (u * c - v * s) >> work
        im[k % turn] -= (u * s + v * c) >> work  # the conjugate: what follows has the other sign in the exponent
        c, s = (c * x + s * y) >> work, (s * x - c * y) >> work
    re, im = _transformed(re, im, 1, _roots(turn, work), work)
    return re, [-part for part in im]


def _root(order: int, work: int) -> tuple[int, int]:
    """Cos and −sin of 2π/order."""
    context = multiprecision(work + _GUARD)
    c, s = context.cos_sin(2 * context.pi / order)
    return int(context.nint(context.ldexp(c, work))), -int(context.nint(context.ldexp(s, work)))


@lru_cache(maxsize=64)
def _turns(order: int, top: int, work: int) -> list[tuple[int, int]]:
    """Powers 1 … top − 1 of e^{−2πi/order}, step by step."""
    x, y = _root(order, work)
    powers, c, s = [], x, y
    for _ in range(1, top):
        powers.append((c, s))
        c, s = (c * x - s * y) >> work, (c * y + s * x) >> work
    return powers


@lru_cache(maxsize=64)
def _roots(n: int, work: int) -> Parts:
    """Return all powers of e^{−2πi/n}; each product adds a unit in the last place."""
    re, im = [1 << work], [0]
    x, y = _root(n, work)
    for _ in range(n - 1):
        a, b = re[-1], im[-1]
        re.append((a * x - b * y) >> work)
        im.append((a * y + b * x) >> work)
    return re, im


def _transformed(re: list[int], im: list[int], step: int, roots: Parts, work: int) -> Parts:
    """Σₘ vₘ e^{−2πikm/n}, k = 0 … n − 1; ``step`` is the order of the roots divided by n."""
    n = len(re)
    if n == 1:
        return re, im
    prime = next((p for p in _PRIMES if n % p == 0), n)
    count = n // prime
    parts = [_transformed(re[r::prime], im[r::prime], step * prime, roots, work) for r in range(prime)]
    cosine, sine, order = *roots, n * step
    if prime == 2:
        return _joined(parts, step, roots, work)
    out_re, out_im = [0] * n, [0] * n
    for k in range(n):
        m = k % count
        a, b = parts[0][0][m] << work, parts[0][1][m] << work
        for r in range(1, prime):
            at = r * k * step % order
            c, s, u, v = cosine[at], sine[at], parts[r][0][m], parts[r][1][m]
            a += u * c - v * s
            b += u * s + v * c
        out_re[k], out_im[k] = a >> work, b >> work
    return out_re, out_im


def _joined(parts: list[Parts], step: int, roots: Parts, work: int) -> Parts:
    """Return two transforms of half the length as one."""
    (even_re, even_im), (odd_re, odd_im) = parts
    cosine, sine = roots[0][::step], roots[1][::step]
    first_re, first_im, last_re, last_im = [], [], [], []
    for a, b, u, v, c, s in zip(even_re, even_im, odd_re, odd_im, cosine, sine, strict=False):
        x, y = (u * c - v * s) >> work, (u * s + v * c) >> work
        first_re.append(a + x)
        first_im.append(b + y)
        last_re.append(a - x)
        last_im.append(b - y)
    return first_re + last_re, first_im + last_im
