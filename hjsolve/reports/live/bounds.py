"""How far the page may be from ``Solution.motion``: measured at settings it was not fitted to, and doubled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.live.neighbours import Neighbours
from hjsolve.reports.live.page_numbers import PageMotion
from hjsolve.reports.live.ranges import SliderRange

_CHECKS, _TIMES = 24, 33
Page = Callable[[Sequence[float]], PageMotion]


def bounds_of(subject: Neighbours, sliders: Sequence[SliderRange], page: Page, motions: int) -> dict[str, float]:
    """Return twice the largest difference seen, of what the page shows in two periods of the slowest coordinate.

    Args:
        subject: the motions round the one given.
        sliders: their ranges.
        page: the page's motion at a setting.
        motions: at so many random settings motions of the engine are the measure, at the others the quadratures.
    """
    rng = np.random.default_rng(12345)
    low, high = (np.array([getattr(s, end) for s in sliders]) for end in ("low", "high"))
    corners = np.array(np.meshgrid(*([0.0, 1.0] for _ in sliders))).reshape(len(sliders), -1).T
    settings = low + (high - low) * np.concatenate([rng.random((_CHECKS, len(sliders))), corners])
    exact, _ = subject.series(settings)
    worst: dict[str, float] = {}
    for i, values in enumerate(settings):
        own = PageMotion(subject.coordinates, subject.ignorable, {key: v[i] for key, v in exact.items()})
        t = np.linspace(0, 4 * np.pi / np.abs(own.rates).min(), _TIMES)
        shown = page(values).state(t)
        true = by_the_engine(subject, values, own, t) if i < motions else own.state(t)
        for name, column in shown.items():
            worst[name] = max(worst.get(name, 0.0), float(np.abs(column - true[name]).max()))
    sizes = sizes_of(subject)
    return {name: 2 * value + 1e-12 * sizes[name] for name, value in worst.items()}


def sizes_of(subject: Neighbours) -> dict[str, float]:
    """Return how far each coordinate and momentum of the motion given goes; of an ignorable angle one radian."""
    motion, sizes = subject.motion, {}
    exact, _ = subject.series(subject.value[None, :])
    own = PageMotion(subject.coordinates, subject.ignorable, {key: v[0] for key, v in exact.items()})
    state = own.state(np.linspace(0, 2 * np.pi / np.abs(own.rates).min(), 65))
    for name, column in state.items():
        sizes[name] = float(np.ptp(column)) or 1.0
    for name in (*subject.ignorable, *(c.name for c in subject.coordinates if c.direction)):
        if motion.solution.system.coordinate(name).domain.kind == "angle":
            sizes[name] = 1.0
    return {name: max(size, 1e-300) for name, size in sizes.items()} | {
        f"p_{c.name}": float(np.abs(state[f"p_{c.name}"]).max()) for c in subject.coordinates if c.direction
    }


def by_the_engine(subject: Neighbours, values: Sequence[float], own: PageMotion, t: Array) -> dict[str, Array]:
    """Return the state at times as ``Solution.motion`` has it, started where the page's motion is away from turns.

    Args:
        subject: the motions round the one given.
        values: of the sliders.
        own: the page's motion with the quadratures' own numbers.
        t: times from the start of the page, shape (m,).
    """
    motion = subject.motion
    solution, system = replace(motion.solution, chart=None), motion.solution.system
    exact = {**motion.initial.constants, **{p.name: motion.initial.values[p.symbol] for p in system.parameters}}
    given = {**exact, **{name: float(v) for name, v in zip(subject.sliders, values, strict=True)}}
    tries = np.linspace(0, 2 * np.pi / np.abs(own.rates).min(), 40)
    libration = [k for k, c in enumerate(subject.coordinates) if not c.direction]
    room = np.abs(np.sin(own.phases(tries)[libration])).min(axis=0, initial=1.0)
    later = float(tries[np.argmax(room)])
    start = {name: float(v[0]) for name, v in own.state(np.array([later])).items()}
    names = [c.name for c in subject.coordinates]
    begun = solution.motion(
        q={n: start[n] for n in names} | dict.fromkeys(subject.ignorable, 0),
        constants={n: given[n] for n in solution.constants},
        signs={n: int(np.sign(start[f"p_{n}"])) for n in names},
        parameters={p.name: given[p.name] for p in system.parameters},
    )
    state, first = begun.at(t - later), begun.at(0.0)
    found: dict[str, Array] = {}
    for name in (*names, *subject.ignorable):
        unwrapped = np.asarray(state.unwrapped(name), float) - float(first.unwrapped(name))
        found[name] = unwrapped + start[name]
        if name in names:
            found[f"p_{name}"] = np.asarray(state.p[name], float)
    return found
