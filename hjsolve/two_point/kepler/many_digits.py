"""Lambert's problem to many digits: the x of one conic that is known in doubles, and its momenta.

The formulas are those of ``lambert.py`` as they stand there in the text, in as many more digits as their differences
lose; T of an orbit without a full turn is (η³ F + 4λη)/2, F = 4/3 ₂F₁(3, 1; 5/2; S), S = (1 − λ − xη)/2 (Battin 1977).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hjsolve.arithmetic.number_types import Context, Mpf
from hjsolve.arithmetic.root_finding import newton
from hjsolve.errors import NotConvergedError
from hjsolve.two_point.kepler.central_places import CentralPlaces

_GUARD = 25
_SECANT_STEPS = 60


class ExactTransfer(NamedTuple):
    """Two places and a time in many digits.

    Attributes:
        context: of mpmath, with the precision of the rest.
        places: the geometry, counterclockwise.
        chord, s: c, and (r₀ + r₁ + c)/2.
        attraction: μ = k/m.
        mass: m.
        time: t.
    """

    context: Context
    places: CentralPlaces
    chord: Mpf
    s: Mpf
    attraction: Mpf
    mass: Mpf
    time: Mpf

    def λ(self, sense: int) -> Mpf:
        """Return λ of one direction.

        Args:
            sense: 1 or −1.
        """
        root = self.context.sqrt(self.places.r0 * self.places.r1)
        return sense * root * self.places.half_cosine / self.s

    @property
    def wanted(self) -> Mpf:
        """The time in the unit of T."""
        return self.context.sqrt(2 * self.attraction / self.s**3) * self.time


def exact_transfer(context: Context, places: CentralPlaces, attraction: Mpf, mass: Mpf, time: Mpf) -> ExactTransfer:
    """Return a transfer to many digits.

    Args:
        context: of mpmath.
        places: the geometry.
        attraction: μ.
        mass: m.
        time: t.
    """
    r0, r1 = places.r0, places.r1
    c = context.sqrt((r0 - r1) ** 2 + 4 * r0 * r1 * places.half_sine**2)
    return ExactTransfer(context, places, c, (r0 + r1 + c) / 2, attraction, mass, time)


def time_exactly(context: Context, λ: Mpf, N: int, x: Mpf) -> Mpf:
    """Return T(x).

    Args:
        context: of mpmath.
        λ: of the transfer.
        N: full turns.
        x: of the conic.
    """
    u = 1 - x * x
    y = context.sqrt(1 - λ * λ * u)
    if N == 0:
        η = y - λ * x
        return (η**3 * context.hyp2f1(3, 1, context.mpf(5) / 2, (1 - λ - x * η) / 2) * 4 / 3 + 4 * λ * η) / 2
    ψ = context.atan2((y - x * λ) * context.sqrt(u), x * y + λ * u)
    return ((ψ + N * context.pi) / context.sqrt(u) - x + λ * y) / u


def refined(transfer: ExactTransfer, sense: int, N: int, x: float) -> Mpf:
    """Return x of a conic to the digits of the context, by secants from its value in doubles.

    Args:
        transfer: two places and a time.
        sense: 1 or −1.
        N: full turns.
        x: in doubles.

    Raises:
        NotConvergedError: two conics are so near each other that doubles do not separate them.
    """
    context, goal = transfer.context, transfer.wanted
    λ = transfer.λ(sense)
    before, small = (
        context.mpf(x) * (1 + context.mpf(2) ** -40) + context.mpf(2) ** -80,
        context.mpf(2) ** (40 - context.prec),
    )
    miss_before = time_exactly(context, λ, N, before) - goal

    def step(here: Mpf) -> Mpf:
        nonlocal before, miss_before
        miss = time_exactly(context, λ, N, here) - goal
        change = miss * (here - before) / (miss - miss_before) if miss != miss_before else 0 * here
        before, miss_before = here, miss
        return change

    found = newton(step, context.mpf(x), lambda here: small * max(abs(here), 1 - abs(here), small), _SECANT_STEPS)
    if found is None:
        raise NotConvergedError(
            "two of the motions between these places nearly coincide; more digits do not separate them"
        )
    return found


def momenta_exactly(transfer: ExactTransfer, sense: int, x: Mpf) -> list[Mpf]:
    """Return the momenta at the first place, in the order of the geometry (Izzo (2015), algorithm 1).

    Args:
        transfer: two places and a time.
        sense: 1 or −1.
        x: of the conic.
    """
    context, places = transfer.context, transfer.places
    λ, γ = transfer.λ(sense), context.sqrt(transfer.attraction * transfer.s / 2)
    y = context.sqrt(1 - λ * λ * (1 - x * x))
    ρ, σ = context.zero, context.zero
    if transfer.chord:
        ρ = (places.r0 - places.r1) / transfer.chord
        σ = 2 * context.sqrt(places.r0 * places.r1) * places.half_sine / transfer.chord
    radial = γ * ((λ * y - x) - ρ * (λ * y + x)) / places.r0
    across = sense * γ * σ * (y + λ * x) / places.r0
    return _combined(transfer.mass, radial, places.radial0, across, places.tangent0)


def _combined(mass: Mpf, radial: Mpf, along: Sequence[Mpf], across: Mpf, around: Sequence[Mpf]) -> list[Mpf]:
    return [mass * (radial * a + across * b) for a, b in zip(along, around, strict=True)]


def precision(digits: int) -> int:
    """Return the decimal digits to work with.

    Args:
        digits: wanted of the motion.
    """
    return digits + _GUARD
