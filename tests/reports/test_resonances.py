"""Relations between frequencies are told where they hold, and not where they do not."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

import hjsolve
from hjsolve.reports.sections.resonances import frequency_relations


def known(**frequencies: tuple[float, float]) -> SimpleNamespace:
    """A motion of which nothing but the frequencies is known, with their errors."""
    rows = {name: SimpleNamespace(value=value, error=error) for name, (value, error) in frequencies.items()}
    return SimpleNamespace(frequencies=rows)


@pytest.mark.parametrize(
    ("frequencies", "words"),
    [
        ({"x": (2.0, 1e-15), "y": (2.0, 1e-15)}, ("Ω_x = Ω_y",)),
        ({"x": (2.0, 1e-15), "y": (-2.0, 1e-15)}, ("Ω_x = −Ω_y",)),
        ({"x": (2.0, 1e-15), "y": (3.0, 1e-15)}, ("3 Ω_x = 2 Ω_y",)),
        ({"x": (2.0, 1e-15), "y": (2.0 + 1e-13, 1e-15)}, ()),
        ({"x": (2.0, 1e-5), "y": (2.0, 1e-5)}, ()),  # nobody knows
        ({"x": (2**0.5, 4e-16), "y": (3**0.5, 4e-16), "z": (2**0.5 + 3**0.5, 8e-16)}, ("Ω_x + Ω_y = Ω_z",)),
        ({"x": (1.5, 1e-15), "y": (1.5, 1e-15), "z": (3.0, 1e-15)}, ("Ω_x = Ω_y", "2 Ω_x = Ω_z")),
        ({"x": (2**0.5, 1e-15), "y": (3**0.5, 1e-15), "z": (5**0.5, 1e-15)}, ()),
    ],
)
def test_relations_in_words(frequencies: dict[str, tuple[float, float]], words: tuple[str, ...]) -> None:
    assert frequency_relations(known(**frequencies)) == words  # type: ignore[arg-type]


@pytest.mark.nightly
def test_a_kepler_orbit_in_found_coordinates() -> None:
    """Turned and shifted by numbers of no meaning; and two unlike centres, which have none."""
    kepler = hjsolve.System(
        {"x": "line", "y": "line"}, "dot(x)**2/2 + dot(y)**2/2", "-1/sqrt((x - 3/7)**2 + (y + 2)**2)"
    )
    start = {"q": {"x": "1.3", "y": "-1.4"}, "velocity": {"x": "-0.4", "y": "0.6"}}
    words = frequency_relations(hjsolve.solve(kepler, coordinates="find").motion(**start))
    assert len(words) == 1
    assert words[0].count("Ω") == 2
    two = hjsolve.System(
        {"x": "line", "y": "line"},
        "dot(x)**2/2 + dot(y)**2/2",
        "-1/sqrt(x**2 + (y + 2)**2) - 2/sqrt((x - 3)**2 + (y + 2)**2)",
    )
    assert frequency_relations(hjsolve.solve(two, coordinates="find").motion(**start)) == ()
