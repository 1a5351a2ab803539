"""Poisson brackets and integrals of the motion of a system (Greenwood (6-212), (6-235), (6-236))."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.brackets import bracket
from hjsolve.precision import one_at_a_time
from hjsolve.separation import Undecided
from hjsolve.theorem.answers import Flaw, Proof
from hjsolve.theorem.phase_space import BUDGET, PhaseSpace, Subject, phase_space_of
from hjsolve.theorem.reading import read_formula

SECONDS_FOR_A_SHORT_FORM = 2.0


@arguments.with_known_names('poisson_bracket("q", "p_q", "harmonic-oscillator")')
@one_at_a_time
def poisson_bracket(f: object, g: object, system: Subject | str | Path, *, budget: float = BUDGET) -> sp.Expr:
    """Return the Poisson bracket (f, g) = Σ ∂f/∂q ∂g/∂p − ∂f/∂p ∂g/∂q of two functions.

    Args:
        f, g: functions of coordinates, momenta ``p_q`` (or velocities ``dot(q)``), parameters and t, as text or sympy
            expressions; ``"H"`` is the Hamiltonian.
        system: the system, or the id or file of a catalog entry.
        budget: seconds for the proof that the bracket vanishes.

    Returns:
        The bracket in a short form; 0 where it is proved to vanish.

    Raises:
        ExpressionError: a function cannot be read.
        InvalidInputError: not a system, or a negative budget.

    Example:
        >>> import hjsolve
        >>> space = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", 0, {"m": 1})
        >>> hjsolve.poisson_bracket("p_x", "x*p_y - y*p_x", space)
        -p_y

    References:
        Greenwood, Classical Dynamics (1977), (6-212).
    """
    space = phase_space_of(system, "poisson_bracket")
    value = bracket(_function(f, space, "f"), _function(g, space, "g"), space.pairs)
    vanishes = space.proved_zero(value, "brackets", "", arguments.seconds(budget, "budget")) is None
    return sp.S.Zero if vanishes else short(value, space)


@arguments.with_known_names('is_integral("p_theta", "kepler-planar")')
@one_at_a_time
def is_integral(f: object, system: Subject | str | Path, *, budget: float = BUDGET) -> Proof | Flaw | Undecided:
    """Decide whether a function is an integral of the motion, (f, H) + ∂f/∂t = 0.

    Args:
        f: a function of coordinates, momenta ``p_q`` (or velocities ``dot(q)``), parameters and the time t, as text or
            sympy expression.
        system: the system, or the id or file of a catalog entry.
        budget: seconds.

    Returns:
        ``Proof``: f is constant along every motion. ``Flaw``: it is not, with a witness; ``residual`` is df/dt.
        ``Undecided``: neither was proved.

    Raises:
        ExpressionError: the function cannot be read.
        InvalidInputError: not a system, or a negative budget.

    Example:
        >>> import hjsolve
        >>> kepler = hjsolve.catalog.load("kepler-planar")
        >>> bool(hjsolve.is_integral("p_theta", kepler)), bool(hjsolve.is_integral("p_r", kepler))
        (True, False)

    References:
        Greenwood, Classical Dynamics (1977), (6-235), (6-236).
    """
    space = phase_space_of(system, "is_integral")
    given = _function(f, space, "f")
    rate = bracket(given, space.hamiltonian, space.pairs) + sp.diff(given, space.time)
    wrong = space.proved_zero(rate, "integral", "the function is not an integral, (f, H) + df/dt = 0 fails",
                              arguments.seconds(budget, "budget"))  # fmt: skip
    return Proof("(f, H) + df/dt = 0, so that f is constant along every motion", given) if wrong is None else wrong


def _function(given: object, space: PhaseSpace, name: str) -> sp.Expr:
    """Return a function of (q, p, t); velocities become functions of q and p."""
    names: dict[str, sp.Expr] = dict(space.symbols)
    if "H" not in names:
        names["H"] = space.hamiltonian
    speeds = {q: sp.Dummy(f"dot({q})", real=True) for q in space.velocities}
    found = read_formula(given, names, name, speeds)
    return found.xreplace({symbol: space.velocities[q] for q, symbol in speeds.items()})


@arguments.with_known_names('involution(["p_theta", "p_r**2/2 + p_theta**2/(2*r**2) - 1/r"], "kepler-planar")')
@one_at_a_time
def involution(
    functions: Sequence[object], system: Subject | str | Path, *, budget: float = BUDGET
) -> Proof | Flaw | Undecided:
    """Decide whether functions are in involution: every two of them have the Poisson bracket 0.

    n integrals of the motion of n coordinates in involution are what a complete integral gives (Greenwood (6-236)).

    Args:
        functions: of coordinates, momenta ``p_q``, parameters and t, as text or sympy expressions; ``"H"`` is H.
        system: the system, or the id or file of a catalog entry.
        budget: seconds for each bracket.

    Returns:
        ``Proof``; ``Flaw`` with the first bracket that does not vanish and a witness; ``Undecided``.

    Raises:
        ExpressionError: a function cannot be read.
        InvalidInputError: fewer than two functions, or not a system.

    Example:
        >>> import hjsolve
        >>> bool(hjsolve.involution(["H", "p_theta"], "kepler-planar"))
        True
    """
    given = list(functions) if isinstance(functions, (list, tuple)) else []
    if len(given) < 2:
        raise InvalidInputError('involution: two functions or more are needed, such as ["H", "p_theta"]')
    space, seconds = phase_space_of(system, "is_integral"), arguments.seconds(budget, "budget")
    read = [_function(f, space, f"functions[{k}]") for k, f in enumerate(given, start=1)]
    for i, f in enumerate(read):
        for j in range(i):
            what = f"the bracket of functions {j + 1} and {i + 1} does not vanish"
            wrong = space.proved_zero(bracket(read[j], f, space.pairs), "brackets", what, seconds)
            if wrong is not None:
                return wrong
    return Proof("every two of the functions have the Poisson bracket 0", sp.Tuple(*read))


def short(value: sp.Expr, space: PhaseSpace) -> sp.Expr:
    """Return an expression in the shortest of a few exact forms; as it stands where that takes long.

    Args:
        value: in the symbols of the space.
        space: where it lives.
    """
    if value.has(sp.Integral):
        return value
    try:
        reader = Reader([value], dict(space.bounds), Budget.processor_seconds(SECONDS_FOR_A_SHORT_FORM))
        return shortest_form(reader, reader.element(value))
    except (WorkLimitError, ZeroDivisionError):
        return value
