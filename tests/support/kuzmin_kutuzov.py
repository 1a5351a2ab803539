"""The Kuzmin–Kutuzov galaxy in prolate coordinates, with reference orbits (see ``load``)."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import hjsolve

COLUMNS = (("actions", "u"), ("actions", "w"), ("frequencies", "u"), ("frequencies", "phi"), ("frequencies", "w"))


@cache
def solution() -> Any:
    """GM = 1, Δ = 1, a/c = 5: Φ = −(√(c² + cosh²u) − √(c² + sin²w))/(sinh²u + cos²w), c² = 1/24."""
    return hjsolve.solve(
        hjsolve.System(
            coordinates={"u": "0 < u", "w": "-pi/2 < w < pi/2", "phi": "angle"},
            kinetic="1/2*(sinh(u)**2 + cos(w)**2)*(dot(u)**2 + dot(w)**2) + 1/2*sinh(u)**2*cos(w)**2*dot(phi)**2",
            potential="-(sqrt(c2 + cosh(u)**2) - sqrt(c2 + sin(w)**2))/(sinh(u)**2 + cos(w)**2)",
            parameters={"c2": "1/24"},
        )
    )


def load() -> dict[str, Any]:
    """200 orbits, 40 of each of five families, with J_u, J_w, Ω_u, Ω_φ, Ω_w to 32 digits as high + low.

    The references come from ball arithmetic at 55 digits on the quartic in √τ (radius below 1e-41), for exactly these
    inputs; ``floor_prolate`` is what half an ulp of the inputs does, relatively.
    """
    with np.load(Path(__file__).with_name("kuzmin_kutuzov.npz")) as data:
        return dict(data)


def start(prolate: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Positions and momenta from rows u, w, p_u, p_w, p_φ."""
    u, w, pu, pw, pφ = prolate.T
    return {"u": u, "w": w, "phi": np.full_like(u, 0.3)}, {"u": pu, "w": pw, "phi": pφ}
