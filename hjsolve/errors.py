"""Every deliberate error of hjsolve; one base, so that one ``except`` catches them all."""

from __future__ import annotations

from typing import TypeVar

T = TypeVar("T")


class HJSolveError(Exception):
    """Base of every error that hjsolve raises on purpose."""


class InvalidInputError(HJSolveError, ValueError):
    """An argument that cannot be used; the message says what to write instead."""


class ExpressionError(InvalidInputError):
    """A text that is not a formula hjsolve accepts.

    Attributes:
        source: what the text was given as, e.g. ``potential``.
        text: the text itself, shortened where it is long.
        position: zero-based place of the fault in the text, or None.
    """

    def __init__(self, message: str, *, source: str = "expression", text: str = "", position: int | None = None):
        super().__init__(message)
        self.source, self.text, self.position = source, text, position


class InvalidSystemError(InvalidInputError):
    """T, V, the coordinates or the parameters do not make a mechanical system."""


class NonholonomicError(InvalidSystemError):
    """A constraint on velocities that is proved not to be integrable.

    Attributes:
        equations: the ``ConstraintForces``, Lagrange's equations with multipliers. It has a default because pickle
            makes an error from its message alone and sets the attributes afterwards.
    """

    def __init__(self, message: str, equations: object = None):
        super().__init__(message)
        self.equations = equations


class MissingValueError(InvalidInputError):
    """A number was asked for and a parameter or an initial value has none."""


class CatalogError(InvalidInputError):
    """A catalog entry that does not exist or does not follow the schema."""


class OutsideMotionError(InvalidInputError):
    """A place or time was asked for that the motion never reaches."""


class ForbiddenMotionError(InvalidInputError):
    """No real motion has the constants given; the message names the nearest allowed regions.

    Attributes:
        name: the coordinate that cannot be where it was said to be.
        regions: nearest allowed region on each side, the nearer one first, as (lower, upper); None for an end that is
            not a turning point but the end of the domain or infinity. Empty where there is none.
    """

    def __init__(self, message: str, *, name: str = "", regions: tuple[tuple[float | None, float | None], ...] = ()):
        super().__init__(message)
        self.name, self.regions = name, regions


class SeveralToriError(InvalidInputError):
    """Several tori have the actions that were given; the message lists them."""


class ForbiddenPlaceError(InvalidInputError):
    """No motion starts at the place given: it is outside the domain of a coordinate, or singular."""


class NotSeparableError(HJSolveError, ArithmeticError):
    """A solution was asked of a system that does not separate in its coordinates.

    Attributes:
        verdict: the ``Obstruction`` or ``Undecided`` that says why. It has a default because pickle makes an error from
            its message alone and sets the attributes afterwards.
    """

    def __init__(self, message: str, verdict: object = None):
        super().__init__(message)
        self.verdict = verdict


class NotConvergedError(HJSolveError, ArithmeticError):
    """A computation fell short of the accuracy asked.

    Attributes:
        estimate: the unfinished ``Estimate``, or None.
    """

    def __init__(self, message: str, estimate: object = None):
        super().__init__(message)
        self.estimate = estimate


class ClusterError(HJSolveError, RuntimeError):
    """A cluster failed: no scheduler is reached, workers ended or have other code; finished parts are kept."""


class MissingExtraError(HJSolveError, ImportError):
    """A feature needs an optional extra that is not installed; the message names it."""


class InternalError(HJSolveError, AssertionError):
    """A fault of hjsolve itself; please report it."""


FAULTS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    MemoryError,
    NameError,
    NotImplementedError,
    RecursionError,
    TypeError,
    ValueError,
)
"""Builtin errors that come out of a fault of ours; reported as one where a user must never see a traceback."""


def required(value: T | None) -> T:
    """Return a value that earlier steps have made certain to exist.

    It states an invariant of hjsolve, also under ``python -O``; it is never the answer to a user's input.

    Args:
        value: anything; None is a fault of hjsolve.

    Returns:
        The same value.

    Raises:
        InternalError: it is None.
    """
    if value is None:
        raise InternalError("a value is missing that the steps before should have given; please report it")
    return value


def of_kind(value: object, kind: type[T]) -> T:
    """Return a value whose type earlier steps have made certain, as ``required`` does.

    Args:
        value: anything.
        kind: its class.

    Returns:
        The same value.

    Raises:
        InternalError: it is not an instance of that class.
    """
    if not isinstance(value, kind):
        raise InternalError(f"a {kind.__name__} is needed here, not {type(value).__name__}; please report it")
    return value
