"""Draw the figures of README and docs: ``python docs/figures.py`` writes them next to this file."""

from __future__ import annotations

from pathlib import Path

import hjsolve
from hjsolve.reports.document import Figure
from hjsolve.reports.document.drawing_style import standalone
from hjsolve.reports.drawings import orbit_paths
from hjsolve.reports.drawings.effective_potential import effective_potential_of
from hjsolve.reports.drawings.motion_figures import effective_potential, phase_portrait

HERE = Path(__file__).resolve().parent
NAMES = ("potential", "phase", "orbit")
LEGIBLE = "<style>.fig{font-size:18px}.fig .tick{font-size:17px}.fig .name{font-size:20px}</style>"
"""Each drawing is shown at half of its width, on the start page and in the README."""


def side_by_side(figures: list[Figure], title: str, description: str) -> str:
    """Put drawings of equal height next to each other in one SVG that stands alone."""
    width, height, gap = 460.0, 320.0, 24.0
    total = len(figures) * width + (len(figures) - 1) * gap
    parts = []
    for i, figure in enumerate(figures):
        place = f'x="{i * (width + gap):g}" y="0" width="{width:g}" height="{height:g}" '
        parts.append(figure.svg.replace("<svg ", f"<svg {place}", 1))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total:g} {height:g}" role="img"><title>{title}</title>'
    )
    return standalone(f"{head}<desc>{description}</desc>{''.join(parts)}{LEGIBLE}</svg>")


def alone(figure: Figure) -> str:
    """Make one drawing a file."""
    return standalone(figure.svg.replace("</svg>", f"{LEGIBLE}</svg>"))


def drawings() -> list[Figure]:
    """Effective potential, phase portrait and orbit of a Kepler ellipse whose centre also pulls like 1/r³."""
    entry = hjsolve.catalog.describe("kepler-planar")
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-planar", effects=["precession"]))
    motion = solution.motion(**entry.initial.arguments)
    radius = effective_potential_of(motion, "r")
    orbit = orbit_paths.orbit(motion, orbit_paths.trace(motion), "orbit")
    assert orbit is not None
    return [effective_potential(radius, "potential", several=False), phase_portrait(radius, "phase"), orbit]


def kepler() -> str:
    """Put the three drawings next to each other, for the README."""
    return side_by_side(
        drawings(), "A precessing Kepler ellipse", "Effective potential with turning points, phase plane, orbit."
    )


def main() -> None:
    """Write every figure."""
    (HERE / "kepler.svg").write_text(kepler(), encoding="utf-8")
    for name, figure in zip(NAMES, drawings(), strict=True):
        (HERE / f"kepler-{name}.svg").write_text(alone(figure), encoding="utf-8")


if __name__ == "__main__":
    main()
