"""What may be asked of a motion, and which integrals each quantity needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from hjsolve import arguments
from hjsolve.errors import InvalidInputError
from hjsolve.one_coordinate.coordinate_motion import PARTS

QUANTITIES: Mapping[str, frozenset[str]] = {
    "constants": frozenset(), "kinds": frozenset(), "turning_points": frozenset(), "actions": frozenset({"action"}),
    "periods": frozenset({"time"}), "frequencies": frozenset({"time"}), "mean_velocities": frozenset({"time"}),
    "angles": frozenset({"time"}), "boundary_times": frozenset({"time"}), "orbit": frozenset({"time", "place"}),
    "trajectory": frozenset({"time", "place"}), "betas": frozenset({"time"}), "characteristic_function": PARTS,
}  # fmt: skip
"""What may be asked of a motion, and the integrals each needs (``one_coordinate.coordinate_motion.PARTS``)."""

OF_MANY_ORBITS = ("actions", "frequencies", "periods", "angles", "constants", "turning_points")
"""Those that may be asked of an ensemble or a sweep, in the order of its columns."""


def parts_of(want: Iterable[str] | None) -> frozenset[str]:
    """Return the integrals that the quantities wanted need.

    Args:
        want: names of quantities; None for all.

    Raises:
        InvalidInputError: a name that is not in ``QUANTITIES``.
    """
    if want is None:
        return PARTS
    names = arguments.words(want, "want", '["actions", "periods"]')
    for name in sorted(names - QUANTITIES.keys()):
        raise InvalidInputError(f'want: "{name}" is not known; known are {", ".join(QUANTITIES)}')
    return frozenset[str]().union(*(QUANTITIES[name] for name in names))
