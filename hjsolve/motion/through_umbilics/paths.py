"""One coordinate between two visits of umbilics: its integrals over x, −1 < x < 1, as Chebyshev series and logarithms.

p² has a double zero e at both ends of the path, and 0 < p² between but for one turning point m at most:

    q = c + h x                     from one double zero to the other,
    q = m − (m − e) x²              from e to m and back.

With jac = |dq/dx|/|p| the clock ∫ N jac dx, N = k₁ + w k₂, is smooth where N vanishes at the double zeros, and the
level ∫ k₂ jac dx is c₋ ln(1 + x) − c₊ ln(1 − x) and a smooth function. Smooth functions are interpolated at Chebyshev
points, twice as many until the last eighth of the coefficients is below the digits asked (Trefethen, Approximation
Theory and Approximation Practice, chapters 3, 8); at three other places the series is compared with the function.
"""

from __future__ import annotations

from dataclasses import dataclass

from hjsolve.arithmetic.chebyshev import clenshaw
from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.fourier import waves
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.momentum_squared import MomentumSquared

_FEWEST_TERMS, _MOST_TERMS = 32, 4096  # doubled in between; what more do not resolve has a singularity at the path
_GUARD = 40  # bits that hold the sums of all terms
Row = tuple[Mpf, ...]
_PROBES = (-0.83, 0.11, 0.67)  # places that are nodes of no Chebyshev series here


@dataclass(frozen=True)
class CoordinatePath:
    """Where a coordinate goes: q(x).

    Attributes:
        radicand: p² and its kernels.
        lower, upper: the double zeros at x = −1 and 1; the same where it turns.
        turning: m; None where it goes through.
    """

    radicand: MomentumSquared
    lower: Mpf
    upper: Mpf
    turning: Mpf | None

    def place(self, x: Mpf) -> Mpf:
        """Return q.

        Args:
            x: position on the path.
        """
        if self.turning is None:
            return (self.lower + self.upper) / 2 + (self.upper - self.lower) / 2 * x
        return self.turning - (self.turning - self.lower) * x**2

    def slope(self, x: Mpf) -> Mpf:
        """Return dq/dx.

        Args:
            x: position on the path.
        """
        return (self.upper - self.lower) / 2 if self.turning is None else -2 * (self.turning - self.lower) * x

    def position(self, q: Mpf, forward: int) -> tuple[Mpf, int]:
        """Return x of a place, and the direction in which x goes.

        Args:
            q: a place on the path.
            forward: sign of dq/dt, 0 at m.
        """
        if self.turning is None:
            x = (2 * q - self.lower - self.upper) / (self.upper - self.lower)
            return x, forward * (1 if self.upper > self.lower else -1)
        size = q.context.sqrt(max((self.turning - q) / (self.turning - self.lower), q.context.zero))
        return (-size if forward * (self.turning - self.lower) > 0 else size), 1

    def rates(self, x: Mpf, weight: Mpf, bits: int) -> tuple[Mpf, Mpf]:
        """Return N jac and k₂ jac.

        Args:
            x: position on the path, not ±1.
            weight: w.
        """
        q = self.place(x)
        if self.turning is None or x:
            size = abs(self.slope(x)) / q.context.sqrt(self.radicand.value(q, bits))
        else:
            steep = abs(self.radicand.jet(q, bits).first * (self.turning - self.lower))
            size = 2 * abs(self.turning - self.lower) / q.context.sqrt(steep)
        energy, other = self.radicand.weights(q, bits)
        return (energy + weight * other) * size, other * size


@dataclass(frozen=True)
class Series:
    """A Chebyshev series, summed in integers, which is many times faster than in ``mpf``.

    Attributes:
        whole: coefficients times 2^bits, rounded.
        bits: binary digits after the point.
    """

    whole: tuple[int, ...]
    bits: int

    def at(self, x: Mpf) -> Mpf:
        """Return Σ cₖ Tₖ(x).

        Args:
            x: from −1 to 1.
        """
        context, bits = x.context, self.bits
        y = int(context.nint(context.ldexp(x, bits + 1)))  # 2x
        b1 = b2 = 0
        for c in self.whole[:0:-1]:
            b1, b2 = (y * b1 >> bits) - b2 + c, b1
        return context.ldexp(context.mpf((y * b1 >> bits + 1) - b2 + self.whole[0]), -bits)


@dataclass(frozen=True)
class Path:
    """The integrals of a coordinate over its path.

    In its methods x = tanh z is the position.

    Attributes:
        coordinate_motion: q(x).
        weight: w.
        bits: binary digits of the arithmetic.
        clock: series of N jac, and of its integral from x = 0.
        smooth: series of the smooth part of k₂ jac, and of its integral from x = 0.
        residues: c₋ and c₊.
    """

    coordinate_motion: CoordinatePath
    weight: Mpf
    bits: int
    clock: tuple[Series, Series]
    smooth: tuple[Series, Series]
    residues: tuple[Mpf, Mpf]

    def time(self, x: Mpf) -> Mpf:
        """Return ∫ N jac dx from x = 0, also at x = ±1.

        Args:
            x: position on the path.
        """
        return self.clock[1].at(x)

    def rates(self, z: Mpf, x: Mpf) -> tuple[Mpf, Mpf]:
        """Return N jac and k₂ jac; the second with all its digits, however near x is to ±1."""
        c, (before, after) = z.context, self.residues
        level = before * (1 + c.exp(-2 * z)) / 2 + after * (1 + c.exp(2 * z)) / 2 + self.smooth[0].at(x)
        return self.clock[0].at(x), level

    def momentum(self, z: Mpf, x: Mpf) -> Mpf:
        """Return |p| = |dq/dx| k₂/(k₂ jac), which loses no digits next to a double zero."""
        kernel = self.coordinate_motion.radicand.weights(self.coordinate_motion.place(x), self.bits)[1]
        return abs(self.coordinate_motion.slope(x) * kernel / self.rates(z, x)[1])

    def level(self, z: Mpf, x: Mpf) -> Mpf:
        """Return ∫ k₂ jac dx from x = 0."""
        c, (before, after) = z.context, self.residues
        return before * (c.ln2 - _softplus(-2 * z)) - after * (c.ln2 - _softplus(2 * z)) + self.smooth[1].at(x)

    def constant(self, side: int) -> Mpf:
        """Return what is left of the level at x = side when its logarithm, ∓c± ln(1 − |x|), is taken away.

        Args:
            side: 1 or −1.
        """
        c, (before, after) = self.residues[0].context, self.residues
        own = before if side > 0 else -after
        return own * c.ln2 + self.smooth[1].at(c.mpf(side))


def _softplus(y: Mpf) -> Mpf:
    """ln(1 + e^y)."""
    c = y.context
    return y + c.log1p(c.exp(-y)) if y > 0 else c.log1p(c.exp(y))


def path_of(coordinate_motion: CoordinatePath, weight: Mpf, digits: int, bits: int) -> Path:
    """Integrate a coordinate over its path.

    Args:
        coordinate_motion: q(x).
        weight: w of N = k₁ + w k₂.
        digits: decimal digits of the series.
        bits: binary digits of the arithmetic, with what p² loses next to its double zeros.

    Raises:
        NotConvergedError: the integrands are too rough.
    """
    context = multiprecision(bits)
    n = _FEWEST_TERMS
    while n <= _MOST_TERMS:
        x = [context.cos(context.pi * (2 * m + 1) / (2 * n)) for m in range(n)]
        rates = [coordinate_motion.rates(y, weight, bits) for y in x]
        square = [(1 - y) * (1 + y) for y in x]
        whole = _series([level * s for (_, level), s in zip(rates, square, strict=True)], bits)
        before, after = (clenshaw(whole, context.mpf(side)) / 2 for side in (-1, 1))
        rest = [level - before / (1 + y) - after / (1 - y) for (_, level), y in zip(rates, x, strict=True)]
        clock, smooth = (_series(values, bits) for values in ([time for time, _ in rates], rest))
        tiny = context.mpf(10) ** -digits
        if all(_ends(row, tiny) for row in (whole, clock, smooth)):
            probes = [context.mpf(y) for y in _PROBES]
            true = [coordinate_motion.rates(y, weight, bits) for y in probes]
            near = [(clenshaw(clock, y), clenshaw(smooth, y) + before / (1 + y) + after / (1 - y)) for y in probes]
            if all(
                abs(a - b) <= 64 * tiny * (1 + abs(b)) for one, two in zip(near, true, strict=True)
                for a, b in zip(one, two, strict=True)
            ):  # fmt: skip
                pairs = [(_fixed(row, bits), _fixed(_integral(row), bits)) for row in (clock, smooth)]
                return Path(coordinate_motion, weight, bits, pairs[0], pairs[1], (before, after))
        n *= 2
    raise NotConvergedError(
        "an integral between two umbilics did not converge; request fewer digits, or start farther from the umbilic"
    )


def _series(values: list[Mpf], bits: int) -> Row:
    context = multiprecision(bits)
    mean = context.fsum(values) / len(values)
    return (mean, *(waves(values, even=True, bits=bits)[0] if any(values) else ()))


def _ends(row: Row, tiny: Mpf) -> bool:
    """Whether a series has come to its end."""
    size = max(abs(c) for c in row)
    return all(abs(c) <= tiny * size for c in row[-(len(row) // 8) :])


def _integral(row: Row) -> Row:
    """Return the series of the integral from x = 0."""
    zero = 0 * row[0]
    doubled = (2 * row[0], *row[1:], zero, zero)
    own = [zero, *((doubled[k - 1] - doubled[k + 1]) / (2 * k) for k in range(1, len(row) + 1))]
    own[0] = -clenshaw(own, zero)
    return tuple(own)


def _fixed(row: Row, bits: int) -> Series:
    """Coefficients as integers, without those at the end that are nothing beside the others."""
    context, work = multiprecision(bits), bits + _GUARD
    whole = [int(context.nint(context.ldexp(c, work))) for c in row]
    least = max(map(abs, whole)) >> bits - _GUARD
    while len(whole) > 2 and abs(whole[-1]) <= least:
        whole.pop()
    return Series(tuple(whole), work)
