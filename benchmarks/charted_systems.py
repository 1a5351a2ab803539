"""The systems of the table in docs/cartesian.md: potentials in x, y and x, y, z, none given in separated coordinates.

One potential for each web of the plane and of space, and those of papers: Danilov and Nagaitsev, PRST-AB 13, 084002
(2010); Garnier, Rend. Circ. Mat. Palermo 43 (1919) 155; Dejonghe and de Zeeuw, Astrophys. J. 333 (1988) 90 (Kuzmin and
Kutuzov's galaxy); Hartmann, Theor. Chim. Acta 24 (1972) 201; Evans, Phys. Rev. A 41 (1990) 5666.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

import hjsolve
from benchmarks import charted_random

R2, R3 = "sqrt(x**2 + y**2)", "sqrt(x**2 + y**2 + z**2)"
T2, T3 = "(dot(x)**2 + dot(y)**2)/2", "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"


def made() -> dict[str, str]:
    """One potential for each web of space, in a frame turned and shifted; written by hand, no chart is used."""
    x, y, z = sp.symbols("x y z", real=True)
    X, Y, Z = sp.Matrix([[2, 1, 2], [1, 2, -2], [-2, 2, 1]]) / 3 * sp.Matrix([x - 1, y + 2, z - 3])
    r2, p2 = sp.expand(X**2 + Y**2 + Z**2), sp.expand(X**2 + Y**2)
    r, ρ = sp.sqrt(r2), sp.sqrt(p2)
    wall = (ρ + X) / ρ**3
    near, far = (sp.sqrt(sp.expand((X + s) ** 2 + Y**2)) for s in (-1, 1))
    low, high = (sp.sqrt(sp.expand(p2 + (Z + s) ** 2)) for s in (-1, 1))
    cone1, cone2 = sp.expand(4 * X**2 + 3 * Y**2 + Z**2) / r2, sp.expand(3 * X**2) / r2
    ell1, ell2, ell3 = 4 + r2, 3 + 4 * X**2 + 3 * Y**2 + Z**2, 3 * X**2
    par1, par2, par3 = 2 * X + 2, 4 * X - Y**2 - Z**2, -2 * Y**2
    spread = sp.sqrt((r2 - 1) ** 2 + 4 * sp.expand(Z**2))
    return {
        "cartesian, turned": sp.expand(X**4 + Y**4 + Z**2),
        "circular cylinder": sp.expand(p2**2 + Z**4) + wall,
        "elliptic cylinder": (
            ((near + far) ** 3 - (near - far) ** 3 + 5 * (near - far)) / (near * far) + sp.expand(Z**4)
        ),
        "parabolic cylinder": ((ρ + X) ** 4 + (ρ - X) ** 3) / ρ + sp.expand(Z**4),
        "spherical": sp.expand(r2**2) + Z / r**3 + wall,
        "prolate": ((low + high) ** 3 + 5 * (low - high)) / (low * high) + wall,
        "oblate (Vinti)": -sp.sqrt((r2 - 1 + spread) / 2) / spread,
        "rotational parabolic": ((r + Z) ** 4 + (r - Z) ** 3) / r + wall,
        "conical": sp.expand(r2**2) + (cone1**2 - cone2) / r2,
        "ellipsoidal, degree 6": sp.expand(ell1**3 - 2 * ell1 * ell2 + ell3),
        "Garnier 3D, turned": sp.expand(r2**2 + X**2 + 2 * Y**2 + 5 * Z**2),
        "paraboloidal, degree 4": sp.expand(par1**4 - 3 * par1**2 * par2 + par2**2 + 2 * par1 * par3),
    }


PLANE = {
    "two centres, turned": "-1/sqrt((x-1)**2 + (y-2)**2) - 3/sqrt((x-3)**2 + (y+1)**2)",
    "two centres, one repels": "-2/sqrt((x-1)**2 + y**2) + 1/sqrt((x+1)**2 + y**2)",
    "Kepler": f"-1/{R2}",
    "Stark, tilted": f"-1/{R2} + x/50 + y/100",
    "Hénon–Heiles, KdV": "(x**2 + 4*y**2)/2 + x**2*y + 2*y**3",
    "Hénon–Heiles, Sawada–Kotera": "(x**2 + y**2)/2 + x**2*y + y**3/3",
    "quartic 1:6:1": "x**4 + 6*x**2*y**2 + y**4 + (x**2 + y**2)/2",
    "quartic 1:12:16": "x**4 + 12*x**2*y**2 + 16*y**4",
    "oscillator 1:2, sheared": "(x**2 + 4*y**2)/2 + 3/10*x*y",
    "oscillator 1:2 with 1/x²": "(x**2 + y**2)/2 + 3*(4*x + 3*y)**2/50 + 1/(3*x - 4*y)**2",
    "Garnier, turned": "(x**2 + y**2)**2 + (3*x - 4*y)**2/25 + 3*(4*x + 3*y)**2/50",
    "dipole in a spring": f"(x**2 + y**2)/2 + (3/2*{R2} + x + y)/{R2}**3",
    "lens (Danilov–Nagaitsev)": ("(x**2 + y**2)/2 - 1/5*re_lens"),
}
SPACE = {
    "two centres": "-1/sqrt(x**2 + (y-1)**2 + (z-2)**2) - 2/sqrt((x-2)**2 + y**2 + (z+1)**2)",
    "Kepler 3D": f"-1/{R3}",
    "Stark, tilted 3D": f"-1/{R3} + x/100 + y/50 + z/50",
    "Calogero–Moser": "1/(x - y)**2 + 1/(y - z)**2 + 1/(z - x)**2 + (x**2 + y**2 + z**2)/2",
    "Garnier 3D": "(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 5*z**2",
    "KdV with a bound z": "(x**2 + 4*y**2)/2 + x**2*y + 2*y**3 + z**4",
    "springs with a zero mode": "(x - y)**2/2 + (y - z)**2/2",
    "Kuzmin–Kutuzov": "-3/sqrt(x**2 + y**2 + z**2 + 5 + 2*sqrt(4 + x**2 + y**2 + 4*z**2))",
    "Hartmann": f"-2/{R3} + 1/(2*(x**2 + y**2))",
    "Smorodinsky–Winternitz": "(x**2 + y**2 + z**2)/2 + 1/x**2 + 2/y**2 + 3/z**2",
    "Evans, with x/ρ": "-1/sqrt(x**2 + y**2 + z**2) + (2 + x/sqrt(x**2 + y**2))/(4*y**2)",
    **made(),
}
SMALL = {"Hénon–Heiles, KdV": 0.15, "Hénon–Heiles, Sawada–Kotera": 0.25, "KdV with a bound z": 0.15,
         "lens (Danilov–Nagaitsev)": 0.5}  # fmt: skip
"""Half-width of the box of starts where it is not 1: a well that is left at a small energy, an aperture."""


def _lens() -> str:
    """Return the integrable lens of Danilov and Nagaitsev, PRST-AB 13, 084002 (2010), eq. (29), in x and y.

    (ξ√(ξ² − 1) acosh ξ + η√(1 − η²)(acos η − π/2))/(ξ² − η²); ξ, η are half the sum and difference of the distances.
    """
    r1, r2 = "sqrt((x+1)**2 + y**2)", "sqrt((x-1)**2 + y**2)"
    ξ, η = f"(({r1} + {r2})/2)", f"(({r1} - {r2})/2)"
    return f"({ξ}*sqrt({ξ}**2 - 1)*acosh({ξ}) + {η}*sqrt(1 - {η}**2)*(acos({η}) - pi/2))/({ξ}**2 - {η}**2)"


def _text(V: Any) -> Any:
    return V.replace("re_lens", _lens()) if isinstance(V, str) else V


def system_named(name: str) -> hjsolve.System:
    """Return the system of a row; "random 17" is the seventeenth of ``charted_random``."""
    if name.startswith("random "):
        n, web, potential = charted_random.made(int(name.split()[1]))
        return hjsolve.System(dict.fromkeys("xyz"[:n], "line"), (T2, T3)[n - 2], potential, title=f"{name}, {web}")
    n = 2 if name in PLANE else 3
    potential = _text({**PLANE, **SPACE}[name])
    return hjsolve.System(dict.fromkeys("xyz"[:n], "line"), (T2, T3)[n - 2], potential, title=name)


def centre_of(name: str) -> tuple[int, ...]:
    """Return the middle of the box of starts."""
    return (1, -2, 3) if name in made() else (0, 0, 0)
