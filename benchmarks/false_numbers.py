"""Ensembles against closed forms: is every claimed error at least the true one?

    python -m benchmarks.false_numbers --orbits 1000000

Fields with a pole, and others whose actions and frequencies are known in closed form. Angular momenta are spread evenly
in their logarithm down to 1e-13, distances on demand from 1e-100 to 1e100, and the binding of orbits from circular to
barely bound. Truth: the closed form in 60 digits, from the doubles that the ensemble was given. Fields without one
(Yukawa, a ring) are compared with mpmath's quadrature between turning points found by bisection: some hundred orbits.

Each orbit is asked for by the default call, single motions excepted. An orbit that is not ``ok`` is not a fault, but
there should be few; one that is ``ok`` and farther from the truth than its claim is false. Status 1 where one is.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import mpmath
import numpy as np
from flint import arb, ctx

import hjsolve
from benchmarks.ensembles import surroundings

quadrature = mpmath.mp.clone()
quadrature.dps = 60
_DIGITS, _WIDE = 60, 460
"""Of truths; and where distances differ by 200 powers of ten, so that 60 are left of a difference of energies."""


def sqrt(x: Any) -> Any:
    """√x of a ball of flint, or of a number of mpmath."""
    return x.sqrt() if isinstance(x, arb) else quadrature.sqrt(x)


def exp(x: Any) -> Any:
    """eˣ of either."""
    return x.exp() if isinstance(x, arb) else quadrature.exp(x)


Array = np.ndarray[Any, np.dtype[np.float64]]
PLANE = ({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2")
LINE = ({"r": "0 < r"}, "dot(r)**2/2")


@dataclass(frozen=True)
class Field:
    """A potential whose action and frequency are known.

    Attributes:
        potential: V(r), as text.
        value: V(r) in 60 digits.
        truth: (E, |p_θ|) → (J_r, Ω_r); None where a quadrature has to do.
        plane: False for one freedom.
        wide: True where orbits are drawn at all scales.
    """

    potential: str
    value: Callable[[Any], Any]
    truth: Callable[[Any, Any], tuple[Any, Any]] | None = None
    plane: bool = True
    wide: bool = False


def kepler(E: Any, L: Any) -> tuple[Any, Any]:
    """J = 1/√(−2E) − L, Ω = (−2E)^(3/2)."""
    return 1 / sqrt(-2 * E) - L, (-2 * E) ** 1.5


def isochrone(E: Any, L: Any) -> tuple[Any, Any]:
    """Binney & Tremaine, Galactic Dynamics (2008), section 3.5.2, with GM = b = 1."""
    return 1 / sqrt(-2 * E) - (L + sqrt(L * L + 4)) / 2, (-2 * E) ** 1.5


def oscillator(E: Any, L: Any) -> tuple[Any, Any]:
    """J = (E − L)/2, Ω = 2, of ω = 1 in a plane."""
    return (E - L) / 2, arb(2)


def barrier(strength: str) -> Callable[[Any, Any], tuple[Any, Any]]:
    """−1/r and a barrier: Kepler's problem with another angular momentum."""
    return lambda E, L: kepler(E, sqrt(L * L + 2 * arb(strength)))


def davidson(E: Any, L: Any) -> tuple[Any, Any]:
    """r²/2 + 1/(8 r²): an oscillator with another angular momentum."""
    return oscillator(E, sqrt(L * L + arb(1) / 4))


def morse(E: Any, _L: Any) -> tuple[Any, Any]:
    """(1 − e^−r)²: J = √2 (1 − √(1 − E)), Ω = √(2 (1 − E))."""
    return sqrt(2) * (1 - sqrt(1 - E)), sqrt(2 * (1 - E))


def poeschl_teller(E: Any, _L: Any) -> tuple[Any, Any]:
    """tan² r: J = √(2 + 2E) − √2, Ω = √(2 + 2E)."""
    return sqrt(2 + 2 * E) - sqrt(2), sqrt(2 + 2 * E)


FIELDS = {
    "Kepler": Field("-1/r", lambda r: -1 / r, kepler),
    "Kepler, all scales": Field("-1/r", lambda r: -1 / r, kepler, wide=True),
    "Kepler with a barrier": Field("-1/r + 1/(500*r**2)", lambda r: -1 / r + 1 / (500 * r * r), barrier("0.002")),
    "1/x with a thin wall": Field(
        "-1/r + 1/(1000000*r**2)", lambda r: -1 / r + 1 / (1000000 * r * r), barrier("1e-6"), plane=False
    ),
    "isochrone": Field("-1/(1 + sqrt(1 + r**2))", lambda r: -1 / (1 + sqrt(1 + r * r)), isochrone),
    "isochrone, all scales": Field(
        "-1/(1 + sqrt(1 + r**2))", lambda r: -1 / (1 + sqrt(1 + r * r)), isochrone, wide=True
    ),
    "oscillator": Field("r**2/2", lambda r: r * r / 2, oscillator),
    "oscillator, all scales": Field("r**2/2", lambda r: r * r / 2, oscillator, wide=True),
    "Davidson": Field("r**2/2 + 1/(8*r**2)", lambda r: r * r / 2 + 1 / (8 * r * r), davidson),
    "Morse": Field("(1 - exp(-r))**2", lambda r: (1 - exp(-r)) ** 2, morse, plane=False),
    "Pöschl and Teller": Field("tan(r)**2", lambda r: r.tan() ** 2, poeschl_teller, plane=False),
    "Yukawa": Field("-exp(-r/10)/r", lambda r: -exp(-r / 10) / r),
    "a ring about a pole": Field("(r**2 - 4)**2/20 - 1/r", lambda r: (r * r - 4) ** 2 / 20 - 1 / r),
    "Plummer and a pole": Field("-1/r - 1/sqrt(1 + r**2) + r/10", lambda r: -1 / r - 1 / sqrt(1 + r * r) + r / 10),
}
CLOSED = sum(field.truth is not None for field in FIELDS.values())
DOMAINS = {"Morse": "line", "Pöschl and Teller": "-pi/2 < r < pi/2"}


def by_quadrature(value: Callable[[Any], Any], E: Any, L: Any, r: Any) -> tuple[Any, Any]:
    """J and Ω by r = a + (b − a) sin²(s/2), tanh–sinh in pieces that double from the lower turning point on.

    Pieces whose error is not small are halved: where a crest is passed slowly, tanh–sinh is off by 1e-10 of the whole.
    """

    def F(x: Any) -> Any:
        return 2 * (E - value(x)) - L * L / (x * x)

    def end(step: Any) -> Any:
        inside, outside = r, r * step
        while F(outside) > 0:
            inside, outside = outside, outside * step
        for _ in range(200):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if F(middle) > 0 else (inside, middle)
        return (inside + outside) / 2

    a, b = end(quadrature.mpf("0.998")), end(1 / quadrature.mpf("0.998"))

    def at(s: Any) -> Any:
        return a + (b - a) * quadrature.sin(s / 2) ** 2

    cuts, x = [quadrature.mpf(0)], 2 * a
    while x < b:
        cuts.append(2 * quadrature.asin(sqrt((x - a) / (b - a))))
        x *= 4
    cuts.append(quadrature.pi)
    half = (b - a) / 2
    action = integral(lambda s: sqrt(abs(F(at(s)))) * quadrature.sin(s) * half, cuts)
    time = integral(lambda s: quadrature.sin(s) * half / sqrt(abs(F(at(s)))), cuts)
    return action / quadrature.pi, quadrature.pi / time


def integral(f: Callable[[Any], Any], cuts: list[Any]) -> Any:
    """Return an integral from piece to piece, each known to 1e-22 of the whole; ``ArithmeticError`` where it is not."""
    total, pieces, whole = quadrature.mpf(0), list(pairwise(cuts)), abs(quadrature.quad(f, cuts))
    for _ in range(400):
        if not pieces:
            return total
        low, high = pieces.pop()
        part, error = quadrature.quad(f, [low, high], error=True)
        if error <= quadrature.mpf("1e-22") * whole:
            total += part
        else:
            pieces += [(low, (low + high) / 2), ((low + high) / 2, high)]
    raise ArithmeticError("a quadrature does not converge")


def drawn(name: str, field: Field, count: int, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Places, momenta and angular momenta, the latter spread in their logarithm; speeds from the field's own.

    A third of the orbits is nearly circular or at rest, a third nearly radial, a third neither.
    """
    scale = 10.0 ** rng.uniform(-100, 100, count) if field.wide else 1.0
    place = rng.uniform(0.3, 3.0, count) * scale
    if name == "Morse":
        place = rng.uniform(-0.5, 2.0, count)
    if name == "Pöschl and Teller":
        place = rng.uniform(-1.4, 1.4, count)
    signs = rng.choice([-1.0, 1.0], count)
    if not field.plane:
        fastest = np.full(count, 3.0)
        if name == "Morse":
            fastest = np.sqrt(2 * (1 - (1 - np.exp(-place)) ** 2))
        elif name == "1/x with a thin wall":
            fastest = np.sqrt(2 / place)
        return place, fastest * 10.0 ** rng.uniform(-13, -0.01, count) * signs, 0 * place
    with ctx.workdps(_WIDE if field.wide else _DIGITS):
        speed = np.array([_circular(field, arb(float(x))) for x in place])
    kind = rng.integers(0, 3, count)
    radial = 10.0 ** rng.uniform(-13, 0, count)
    along = np.where(kind == 0, 1.0, np.where(kind == 1, radial, rng.uniform(0, 1.2, count)))
    outward = np.where(kind == 0, 10.0 ** rng.uniform(-13, -0.3, count), rng.uniform(-1, 1, count))
    return place, outward * speed, along * speed * place * signs


def _circular(field: Field, r: Any) -> float:
    """Return the speed √(r V′) of a circular orbit."""
    h = r / arb(10) ** 30
    return float(sqrt(abs(r * (field.value(r + h) - field.value(r - h)) / (2 * h))))


def system_of(name: str, field: Field) -> hjsolve.System:
    """Return the system as somebody types it."""
    coordinates, kinetic = PLANE if field.plane else LINE
    return hjsolve.System({**coordinates, "r": DOMAINS.get(name, "0 < r")}, kinetic, field.potential)


def checked(name: str, field: Field, count: int, seed: int) -> tuple[Any, ...]:
    """Compare a field's orbits with the truth; the worst ratio of error and claim for each quantity."""
    r, p, l = drawn(name, field, count, np.random.default_rng(seed))
    q, momenta = {"r": r, "theta": 0.0}, {"r": p, "theta": l}
    if not field.plane:
        q, momenta = {"r": r}, {"r": p}
    batch = hjsolve.ensemble(
        system_of(name, field), q=q, p=momenta, want={"actions", "frequencies"}, fallback=False, shown=False
    )
    ok = np.flatnonzero(np.asarray(batch.status) == "ok")
    bound = np.flatnonzero(np.asarray(batch.status) != "unbounded")
    claims = [(getattr(batch, what)["r"], batch.error[what]["r"]) for what in ("actions", "frequencies")]
    worst, false = [0.0, 0.0], 0
    number = arb if field.truth else quadrature.mpf
    with ctx.workdps(_WIDE if field.wide else _DIGITS):
        for i in ok:
            x, v, L = number(float(r[i])), number(float(p[i])), abs(number(float(l[i])))
            E = v * v / 2 + field.value(x) + L * L / (2 * x * x)
            truths = field.truth(E, L) if field.truth else by_quadrature(field.value, E, L, x)
            for k, (truth, (found, claim)) in enumerate(zip(truths, claims, strict=True)):
                error, claimed = abs(number(float(found[i])) - truth), float(claim[i])
                ratio = float(error / claimed) if claimed > 0 else (0.0 if error == 0 else np.inf)
                worst[k], false = max(worst[k], ratio), false + (not ratio <= 1)
    return name, len(r), false, worst[0], worst[1], 100 * (1 - len(ok) / max(len(bound), 1))


def rows(count: int, seed: int) -> Iterator[str]:
    """Yield the table, a line a field; the last one counts what is false."""
    yield f"Seed {seed}, {surroundings()}."
    yield ""
    yield "| field | orbits | false | J_r: worst error/claim | Ω_r: worst error/claim | bound and not ok, % |"
    yield "|---|---|---|---|---|---|"
    total, all_ = 0, 0
    for number, (name, field) in enumerate(FIELDS.items()):
        orbits = count // CLOSED if field.truth else max(count // 5000, 10)
        name, n, false, action, frequency, lost = checked(name, field, orbits, seed + number)
        total, all_ = total + false, all_ + n
        yield f"| {name} | {n} | {false} | {action:.2f} | {frequency:.2f} | {lost:.2f} |"
    yield f"| all | {all_} | {total} | | | |"


def main() -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--orbits", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    false = 0
    for line in rows(arguments.orbits, arguments.seed):
        print(line, flush=True)
        false = int(line.split("|")[3]) if line.startswith("| all") else false
    return int(false > 0)


if __name__ == "__main__":
    sys.exit(main())
