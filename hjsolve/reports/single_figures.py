"""The figures of a report one by one: each a drawing to save or to show in a notebook."""

from __future__ import annotations

import sympy as sp

from hjsolve.arguments import described, with_known_names
from hjsolve.errors import InvalidInputError
from hjsolve.motion.motion import Motion
from hjsolve.precision import one_at_a_time
from hjsolve.reports.document import Figure
from hjsolve.reports.drawings import orbit_paths
from hjsolve.reports.drawings.effective_potential import effective_potential_of
from hjsolve.reports.drawings.motion_figures import effective_potential, phase_portrait


@with_known_names("figures(motion)")
@one_at_a_time
def figures(motion: Motion) -> dict[str, Figure]:
    """Draw the figures that the report of a motion has.

    Args:
        motion: the motion.

    Returns:
        Name → figure, in reading order: ``potential.r`` and ``phase.r`` of each separated coordinate, ``orbit`` where
        there is more than one coordinate, ``time``. ``figure.save("orbit.svg")`` writes one; a notebook shows it.

    Raises:
        InvalidInputError: this is not a motion.

    Example:
        >>> import hjsolve
        >>> motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        >>> list(figures(motion))
        ['potential.r', 'phase.r', 'orbit', 'time']
    """
    if not isinstance(motion, Motion):
        raise InvalidInputError(f"figures: a Motion is needed, from solution.motion(…), not {described(motion)}")
    motion = motion.as_solved
    drawn: dict[str, Figure] = {}
    names = motion.solution.coordinates
    for name in names:
        well = effective_potential_of(motion, name)
        plain = bool(sp.expand(well.formula - motion.solution.system.potential) == 0)
        drawn[f"potential.{name}"] = effective_potential(well, f"potential-{name}", several=len(names) > 1, plain=plain)
        drawn[f"phase.{name}"] = phase_portrait(well, f"phase-{name}")
    trace = orbit_paths.trace(motion)
    if (orbit := orbit_paths.orbit(motion, trace, "orbit")) is not None:
        drawn["orbit"] = orbit
    drawn["time"] = orbit_paths.history(motion, trace, "time")
    return drawn
