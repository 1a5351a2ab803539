"""Plain systems that several tests of the door use, typed the way a user would."""

from __future__ import annotations

from hjsolve.mechanics.system import System, parameter

PLANE = "m/2*(dot(r)**2 + r**2*dot(theta)**2)"
TOP = "I_a/2*(dot(phi) - dot(psi)*sin(theta))**2 + I_t/2*(dot(theta)**2 + dot(psi)**2*cos(theta)**2)"


def positive(names: str) -> dict[str, object]:
    return {name: parameter(name, 1 + k, assume="positive") for k, name in enumerate(names.split())}


def kepler(**changes: object) -> System:
    parts: dict[str, object] = {
        "coordinates": {"r": "0 < r", "theta": "angle"},
        "kinetic": PLANE,
        "potential": "-k/r",
        "parameters": {"m": 1, "k": 2},
    }
    return System(**{**parts, **changes})


def oscillator(domain: object = "line", kinetic: object = "dot(x)**2/2", **changes: object) -> System:
    return System({"x": domain}, kinetic, **changes)
