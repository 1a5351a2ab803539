"""The kinds of motion that are possible with some constants, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hjsolve.display.shown import Shown

_WORDS = {
    "libration": "librates", "rotation": "turns round", "escape": "escapes", "boundary": "reaches an end of its domain",
    "asymptotic": "is asymptotic", "equilibrium": "rests", "undecided": "is undecided",
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class KindsOfMotion(Shown):
    """One colour of the map: points at which the same kinds of motion are possible.

    Attributes:
        kinds: separated coordinate → the kinds of its regions, in order of q; none where it cannot move.
        example: a point (x, y).
        fraction: part of the window.
    """

    kinds: Mapping[str, tuple[str, ...]]
    example: tuple[float, float]
    fraction: float

    @property
    def name(self) -> str:
        """The kinds in words."""
        if not all(self.kinds.values()):
            return "no real motion"
        return ", ".join(f"{name} {self.name_of(name)}" for name in self.kinds)

    def name_of(self, coordinate: str) -> str:
        """Return the kinds of one coordinate in words.

        Args:
            coordinate: a separated one.
        """
        return _in_words(self.kinds[coordinate])


def _in_words(kinds: tuple[str, ...]) -> str:
    words = []
    for kind in dict.fromkeys(kinds):
        many = kinds.count(kind)
        words.append(_WORDS[kind] + (f" in {many} regions" if many > 1 else ""))
    return " or ".join(words)
