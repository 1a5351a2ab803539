"""Whatever names a system → the system: one reading for every verb that takes one."""

from __future__ import annotations

from pathlib import Path

from hjsolve.arguments import described
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.system import System

A_SYSTEM = (
    'a System is needed, made by hjsolve.System(…), or the id of a catalog entry such as "kepler-planar", or the '
    "path of a .toml entry"
)


def system_of(subject: object, verb: str) -> System:
    """Give the system that is meant.

    A name goes to ``hjsolve.catalog``, asked for at call time through the package's public face, as a user would.

    Args:
        subject: a ``System``; the id of a catalog entry; the path of an entry's file.
        verb: the function that asks, for the message.

    Raises:
        InvalidInputError: none of these; ``CatalogError`` for an id or a file that is not an entry.
        NotSeparableError: an entry that is not given by T and V; the error carries its ``Refusal``.
    """
    if isinstance(subject, System):
        return _timeless(subject, verb)
    if isinstance(subject, (str, Path)):
        import hjsolve

        loaded = hjsolve.catalog.load(Path(subject) if str(subject).endswith(".toml") else subject)
        return _timeless(loaded, verb)
    raise InvalidInputError(f"{verb}: {A_SYSTEM}, not {described(subject)}")


_OF_THE_TIME = (
    "solve", "separate", "verify", "poisson_bracket", "is_integral", "action_integral", "constraint_forces",
)  # fmt: skip
"""Verbs that take a system whose T or V holds the time."""


def _timeless(system: System, verb: str) -> System:
    if system.time is None or verb in _OF_THE_TIME:
        return system
    raise InvalidInputError(
        f"{verb}: T or V holds the time; hjsolve.solve looks for a frame in which it does not, and gives the system "
        "there as solution.frame.system"
    )
