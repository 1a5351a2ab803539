"""The drawings of a separated coordinate: its effective potential and its phase portrait.

``key`` is a name that is unique on the page, ``plain`` whether the potential is that of the system itself.
"""

from __future__ import annotations

import numpy as np

from hjsolve.reports.document import Figure, Mathematics, Text
from hjsolve.reports.drawings import phase_portrait as portrait
from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.effective_potential import Array, EffectivePotential
from hjsolve.reports.formulas.layout import Box, Glyph, Script, row
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import spoken

_HALF = 181  # places on one branch of a loop
_KINDS = {
    "libration": "librates between its turning points",
    "rotation": "turns on and on",
    "escape": "runs off to infinity",
    "equilibrium": "rests at an equilibrium",
    "asymptotic": "creeps towards an unstable equilibrium",
    "boundary": "reaches an end of its domain",
}


def potential_name(well: EffectivePotential, *, several: bool, plain: bool = False) -> Box:
    """Name the effective potential of a coordinate, with the coordinate as index where there are several.

    Args:
        several: whether the system has more than one separated coordinate.

    Returns:
        V, or V with an index.
    """
    if plain:
        return Glyph("V")
    return Script(Glyph("V"), name_box(well.name)) if several else Script(Glyph("V"), Glyph("eff", "text"))


def level_box(well: EffectivePotential) -> Box:
    """Name the constant that plays the part of the energy, with its sign.

    Returns:
        E, α₂ or −α₂; 0 where no constant does.
    """
    if not well.level_name:
        return Glyph("0", "number")
    name = name_box(well.level_name)
    return name if well.sign > 0 else row(Glyph("−", "operator"), name)


def effective_potential(well: EffectivePotential, key: str, *, several: bool, plain: bool = False) -> Figure:
    """Draw the effective potential, the level of the motion and its turning points.

    Args:
        several: whether there are other separated coordinates.

    Returns:
        The figure.
    """
    q = portrait.window_places(well)
    V = well.potential(q)
    frame = svg.DrawingFrame(well.window, levels_shown(well, q, V))
    name = potential_name(well, several=several, plain=plain)
    inside = [_allowed_area(well, frame), svg.curve(frame, q, V)]
    hills = [hill for hill in portrait.hills(well) if frame.y[0] < hill[0] < frame.y[1]]
    inside += [svg.curve(frame, np.array(well.window), np.full(2, level), "edge") for level, _ in hills]
    inside.append(svg.curve(frame, np.array(well.window), np.full(2, well.level), "energy"))
    inside += [svg.curve(frame, np.array(span), np.full(2, well.level), "motion") for span in spans_covered(well)]
    above = [svg.disc(frame, end, well.level) for end in well.ends if end is not None]
    above.append(
        svg.annotate(
            frame,
            well.window[1],
            well.level,
            svg.label(level_box(well)),
            style="name warm",
            anchor="end",
            shift=(-3, -6),
        )
    )
    below = [
        svg.axes(frame, svg.label(name_box(well.name)), svg.label(name), angles=(is_angle(well), False), zero=True)
    ]
    title = f"Effective potential of {spoken(well.name)}"
    level = f"has {spoken(well.level_name)} = {well.level:.6g}" if well.level_name else "lies at the height zero"
    description = (
        f"Effective potential against {spoken(well.name)}. The motion {level} and {_KINDS[well.kind]}{_between(well)}."
    )
    caption: Text = (
        "Potential " if plain else "Effective potential ",
        Mathematics(name),
        ". Red: the motion, which ",
        _KINDS[well.kind],
        _hill_words(hills),
        ".",
    )
    svg_text = svg.assemble(frame, key, title, description, below, inside, above)
    return Figure(
        svg_text,
        title,
        description,
        caption,
        {well.name: svg.finite(q), "potential": svg.finite(V), "level": [well.level]},
    )


def phase_portrait(well: EffectivePotential, key: str) -> Figure:
    """Draw the phase plane of a coordinate: some levels, the separatrices, the motion.

    Returns:
        The figure.
    """
    own, others, frame = own_loops(well), _other_loops(well), phase_frame(well)
    hills = [(level, word) for level, word in portrait.hills(well) if loops_at(well, level)]
    edges = [loop for level, _ in hills for loop in loops_at(well, level)]
    inside = [svg.curve(frame, *loop, "level") for loop in others] + [svg.curve(frame, *loop, "edge") for loop in edges]
    inside += [
        svg.area(frame, q[: len(q) // 2], p[len(q) // 2 :][::-1], p[: len(q) // 2])
        for q, p in own
        if well.kind == "libration"
    ]
    inside += [svg.curve(frame, *loop, "motion") for loop in own]
    above = []
    if well.kind == "equilibrium":
        above.append(svg.disc(frame, well.place, -float(well.shift(well.place))))
    name, momentum = name_box(well.name), name_box(f"p_{well.name}")
    below = [svg.axes(frame, svg.label(name), svg.label(momentum), angles=(is_angle(well), False), zero=True)]
    title = f"Phase portrait of {spoken(well.name)}"
    level = spoken(well.level_name) if well.level_name else "the constants"
    description = (
        f"Momentum {spoken(f'p_{well.name}')} against {spoken(well.name)} at several values of {level}; "
        "the motion is marked."
    )
    caption: Text = (
        "Phase plane of ",
        Mathematics(name),
        ". Red: the motion",
        *_area_words(well),
        "; blue: other values of ",
        Mathematics(level_box(well)) if well.level_name else "the constants",
        _hill_words(hills),
        ".",
    )
    q, p = (np.concatenate([loop[i] for loop in own]) if own else np.empty(0) for i in (0, 1))
    return Figure(
        svg.assemble(frame, key, title, description, below, inside, above),
        title,
        description,
        caption,
        {well.name: svg.finite(q), f"p_{well.name}": svg.finite(p)},
    )


def phase_frame(well: EffectivePotential) -> svg.DrawingFrame:
    """Give the part of the phase plane that ``phase_portrait`` shows, and where on the drawing."""
    return svg.DrawingFrame(well.window, momenta_shown(well, own_loops(well), _other_loops(well)))


def _other_loops(well: EffectivePotential) -> list[tuple[Array, Array]]:
    return [loop for level in portrait.levels(well) for loop in loops_at(well, level)]


# -------------------------------------------------------------------------------- what the motion covers
def spans_covered(well: EffectivePotential) -> list[tuple[float, float]]:
    """Give the intervals of the window that the motion itself covers."""
    low, high = well.ends
    if well.kind == "equilibrium":
        return []
    if low is not None and high is not None and well.kind == "libration":
        return [(low + turn, high + turn) for turn in _turns(well, low, high)]
    if well.kind == "rotation":
        return [well.window]
    return [(well.window[0] if low is None else low, well.window[1] if high is None else high)]


def _turns(well: EffectivePotential, low: float, high: float) -> list[float]:
    """Return copies of an interval of an angle that meet the window."""
    if not well.periodic:
        return [0.0]
    first = np.ceil((well.window[0] - high) / (2 * np.pi))
    last = np.floor((well.window[1] - low) / (2 * np.pi))
    return [2 * np.pi * float(n) for n in np.arange(first, last + 1)]


def own_loops(well: EffectivePotential) -> list[tuple[Array, Array]]:
    """Give the phase curves of the motion itself.

    Returns:
        (q, p) of each.
    """
    loops = [portrait.loop(well, well.level, low, high) for low, high in spans_covered(well)]
    if well.kind != "rotation":
        return loops
    half = slice(None, _HALF) if well.direction > 0 else slice(_HALF, None)
    return [(q[half], p[half]) for q, p in loops]


def loops_at(well: EffectivePotential, level: float) -> list[tuple[Array, Array]]:
    """Give the phase curves of another level, in the window.

    Args:
        level: value of the level constant.

    Returns:
        (q, p) of each.
    """
    return [portrait.loop(well, level, low, high) for low, high in portrait.allowed(well, level) if high > low]


def _allowed_area(well: EffectivePotential, frame: svg.DrawingFrame) -> str:
    parts = []
    for low, high in spans_covered(well):
        q = np.linspace(low, high, 400)
        V = well.potential(q)
        parts.append(
            svg.area(
                frame, q, np.where(np.isfinite(V), np.minimum(V, well.level), well.level), np.full_like(q, well.level)
            )
        )
    return "".join(parts)


# -------------------------------------------------------------------------------- ranges
def levels_shown(well: EffectivePotential, q: Array, V: Array) -> tuple[float, float]:
    """Show the bottom of the well and as much above the level as is below it.

    Args:
        q: places across the window.
        V: the potential there.

    Returns:
        (lowest, highest).
    """
    inside = np.isfinite(V)
    spans = spans_covered(well)
    reached = np.zeros_like(inside)
    for low, high in spans:
        reached |= (q >= low) & (q <= high)
    floor = float(np.min(V[inside & (reached if reached.any() else inside)], initial=well.level))
    hills = [h for h, _ in portrait.hills(well) if h - floor < 4 * (well.level - floor)]
    depth = max(well.level, *hills, floor) - floor if hills else well.level - floor
    if depth < 1e-9 * max(abs(floor), 1e-300):
        depth = 0.4 * float(np.quantile(V[inside], 0.8) - floor) if inside.any() else 1.0
        depth = depth or 1.0
    return floor - 0.3 * depth, floor + 1.7 * depth


def momenta_shown(
    well: EffectivePotential, own: list[tuple[Array, Array]], others: list[tuple[Array, Array]]
) -> tuple[float, float]:
    """Show the motion and as much again around it.

    Args:
        own: phase curves of the motion.
        others: those of other levels.

    Returns:
        (lowest, highest).
    """
    mine = np.concatenate([p for _, p in own]) if own else np.empty(0)
    mine = np.concatenate([mine, -mine]) if well.kind == "rotation" else mine
    shown = mine if mine.size and np.ptp(mine) > 0 else np.concatenate([p for _, p in others]) if others else mine
    low, high = svg.spread(shown, 0.0)
    room = high - low
    return low - 0.38 * room, high + 0.38 * room


# -------------------------------------------------------------------------------- words
def is_angle(well: EffectivePotential) -> bool:
    """Return whether a coordinate is marked in parts of π."""
    width = well.window[1] - well.window[0]
    return well.periodic or abs(width - np.pi) < 1e-9


def _between(well: EffectivePotential) -> str:
    low, high = well.ends
    return f", {low:.6g} and {high:.6g}" if low is not None and high is not None else ""


def _hill_words(hills: list[tuple[float, str]]) -> str:
    words = list(dict.fromkeys(word for _, word in hills))
    return f"; dashed: {' and '.join(words)}" if words else ""


def _area_words(well: EffectivePotential) -> Text:
    return (
        (
            " (the shaded area is ",
            Mathematics(row(Glyph("2", "number"), Glyph("π"), Script(Glyph("J"), name_box(well.name)))),
            ")",
        )
        if well.kind == "libration"
        else ()
    )
