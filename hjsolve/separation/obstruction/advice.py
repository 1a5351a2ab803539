"""What to try when a system does not separate, in the words of a physicist.

No sentence here says that a system is not integrable: separability belongs to coordinates, integrability to the system
(Kaup–Kupershmidt and Toda are integrable and separate in no point coordinates of the plane).
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.mechanics.system import System, kinetic_rest, linear_terms

ALWAYS = (
    "This verdict is about these coordinates only: the system may separate in others, or be integrable without "
    "separating."
)


def small_oscillations(system: System) -> bool:
    """Whether T has constant coefficients and V − T₀ is a quadratic polynomial in coordinates that are not angles.

    Args:
        system: whose T and V are looked at.
    """
    symbols = [c.symbol for c in system.coordinates]
    if system.kinetic.free_symbols & set(symbols) or any(linear_terms(system)):
        return False
    potential = system.potential - kinetic_rest(system)
    if not potential.is_polynomial(*symbols):
        return False
    return int(sp.Poly(potential, *symbols).total_degree()) <= 2


def advice_for_linear_equations(system: System) -> str:
    """Return what to do with a system whose equations are linear and that has gyroscopic terms; nothing for any other.

    Args:
        system: the one refused.
    """
    symbols = [c.symbol for c in system.coordinates]
    speeds = [c.velocity for c in system.coordinates]
    energy = sp.expand(system.kinetic - system.potential)
    if system.relativity is not None or not any(linear_terms(system)) or not energy.is_polynomial(*symbols, *speeds):
        return ""
    if int(sp.Poly(energy, *symbols, *speeds).total_degree()) > 2:
        return ""
    return (
        "T and V are of second degree with constant coefficients, so the equations of motion are linear: "
        "hjsolve.gyroscopic_modes (hjsolve solve, hjsolve motion) gives the exponents, every motion as a sum of "
        "exponentials, and where all modes oscillate the normal form, in which each is an oscillator of its own. "
        f"{ALWAYS}"
    )


def for_metric(system: System, pair: tuple[str, str], coupled: bool) -> str:
    """Return advice when the kinetic energy is the obstacle.

    Args:
        system: the one refused.
        pair: names of the two coordinates that do not come apart.
        coupled: True where T has a product of their velocities.
    """
    i, j = pair
    if small_oscillations(system):
        return (
            f"T and V are quadratic forms with constant coefficients that couple {i} and {j}. Use the normal modes as "
            f"coordinates: each is a one-dimensional oscillator. {ALWAYS}"
        )
    if words := advice_for_linear_equations(system):
        return f"The kinetic energy couples {i} and {j}. {words}"
    if coupled:
        return (
            f"The kinetic energy couples {i} and {j} by a term dot({i})*dot({j}), and no ignorable coordinate "
            f"absorbs it. Choose coordinates in which T is diagonal. {ALWAYS}"
        )
    return (
        f"The kinetic energy alone couples {i} and {j}, so no potential separates in these coordinates. Try another "
        f"family: polar, parabolic or elliptic; spherical, spheroidal or ellipsoidal. {ALWAYS}"
    )


def for_potential(system: System, pair: tuple[str, str]) -> str:
    """Return advice when the kinetic energy separates and the potential does not.

    Args:
        system: the one refused.
        pair: names of the two coordinates that do not come apart.
    """
    i, j = pair
    if small_oscillations(system):
        return (
            f"V couples {i} and {j}, but T and V are quadratic forms with constant coefficients: use the normal "
            f"modes as coordinates. {ALWAYS}"
        )
    return (
        f"The kinetic energy separates in these coordinates, but the potential does not have the form they require "
        f"between {i} and {j}. {_search(system)}{ALWAYS}"
    )


def _search(system: System) -> str:
    """Return where other coordinates are looked for, if the system may be a particle in a plane or in space."""
    straight = not system.kinetic.free_symbols & {c.symbol for c in system.coordinates}
    bounded = any(c.domain.kind != "line" for c in system.coordinates)
    if len(system.coordinates) not in {2, 3} or system.relativity is not None or (straight and bounded):
        return "Try other coordinates in which the kinetic energy separates. "
    return (
        'To search for coordinates in which it does, write `solve(system, coordinates="find")` or, on the command '
        "line, `hjsolve coordinates`. "
    )


def for_gyroscopic(system: System, pair: tuple[str, str]) -> str:
    """Return advice when linear terms are not a gradient.

    Args:
        system: the one refused.
        pair: names of the two coordinates in which the linear terms have a curl.
    """
    i, j = pair
    if words := advice_for_linear_equations(system):
        return f"The terms linear in the velocities of {i} and {j} are not a gradient. {words}"
    return (
        f"The terms linear in the velocities of {i} and {j} act like a magnetic field: they are not a gradient and "
        "cannot be shifted away. Gauges that differ by a gradient are one system: "
        'coordinates="find" looks for one in which a coordinate is ignorable. Or take coordinates in which '
        f"the symmetry of the field makes one of them ignorable, e.g. polar angles about the field. {ALWAYS}"
    )


def about_blocks(blocks: Sequence[Sequence[str]]) -> str:
    """Return what the finest partition into blocks means; nothing when there is one block only.

    Args:
        blocks: names of the coordinates, block by block.
    """
    if len(blocks) < 2:
        return ""
    names = "; ".join(", ".join(block) for block in blocks)
    return (
        f"The rest does separate: W is a sum of one function for each of the blocks ({names}), so that each block is a "
        "smaller problem of its own, with the separation constants of the others as parameters."
    )


def about_energy(system: System, energy: sp.Expr) -> str:
    """Return what separation at one energy means.

    Args:
        system: the one refused at the other energies.
        energy: E at which it separates, in parameters and constant momenta.
    """
    words = (
        f"The equation separates at the one energy E = {energy}, for the metric is conformally of Staeckel's form: "
        "there W is found by quadratures, at neighbouring energies it is not (conformal separation; after Jacobi and "
        "Maupertuis)."
    )
    if system.signature == "definite" and not (system.potential - kinetic_rest(system) - energy).free_symbols:
        words += " With this potential nothing moves at that energy; it matters for Laplace's equation."
    return words


def for_explicit_time() -> str:
    """Return advice when H holds the time."""
    return (
        "hjsolve.solve (hjsolve solve, hjsolve motion) looks for a frame in which the system is autonomous, and for a "
        "principal function of second degree in the coordinates."
    )


def for_undecided() -> str:
    """Return advice when nothing was proved."""
    return (
        "Neither a proof nor a counterexample was found in the time allowed. Allow more (budget=, --budget), write T "
        "and V in simpler functions, or give numbers to some parameters."
    )
