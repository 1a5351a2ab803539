"""Separable coordinates of the potentials of the literature: integrals, webs, certificates, seconds.

    python benchmarks/coordinates.py [plane | space]

One line for each potential: the dimension of the Killing kernel (and of its concircular part), the seconds of wall and
of CPU time of one call, the largest time ``separate`` took for one of the webs, and the webs found. Expected dimensions
and webs stand next to them, and a line that differs is marked. Times are for a single call in a process that has warmed
up on another potential; read the CPU column on a busy machine.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

from hjsolve import System, find_coordinates

R2 = "sqrt(x**2 + y**2)"
R3 = "sqrt(x**2 + y**2 + z**2)"

# potential, parameters, dimension of the kernel, kinds of webs
PLANE = {
    "Kepler": (f"-k/{R2}", {"k": 1}, 4, "parabolic polar elliptic"),
    "two centres (±1, 0)": ("-1/sqrt((x-1)**2 + y**2) - 2/sqrt((x+1)**2 + y**2)", {}, 2, "elliptic"),
    "two centres (1, 2), (3, −1)": ("-1/sqrt((x-1)**2 + (y-2)**2) - 3/sqrt((x-3)**2 + (y+1)**2)", {}, 2, "elliptic"),
    "two centres (±c, 0), symbolic": (
        "-k/sqrt((x-c)**2 + y**2) - j/sqrt((x+c)**2 + y**2)",
        {"k": None, "j": None, "c": None},
        2,
        "elliptic",
    ),
    "Stark": (f"-1/{R2} + x/10", {}, 2, "parabolic"),
    "oscillator 1:2": ("(x**2 + 4*y**2)/2", {}, 3, "cartesian parabolic"),
    "oscillator ω² = 1:3": ("(x**2 + 3*y**2)/2", {}, 2, "cartesian"),
    "isotropic oscillator": ("(x**2 + y**2)/2", {}, 4, "cartesian polar elliptic"),
    "Hénon–Heiles": ("(x**2 + y**2)/2 + x**2*y - y**3/3", {}, 1, ""),
    "Sawada–Kotera": ("(x**2 + y**2)/2 + x**2*y + y**3/3", {}, 2, "cartesian"),
    "KdV": ("(x**2 + 4*y**2)/2 + x**2*y + 2*y**3", {}, 2, "parabolic"),
    "Kaup–Kupershmidt": ("(x**2 + 16*y**2)/2 + x**2*y + 16/3*y**3", {}, 1, ""),
    "Hénon–Heiles family, symbolic": (
        "(A*x**2 + B*y**2)/2 + x**2*y + C*y**3",
        {"A": None, "B": None, "C": None},
        1,
        "",
    ),
    "Toda": ("(exp(2*x + 2*sqrt(3)*y) + exp(2*x - 2*sqrt(3)*y) + exp(-4*x))/24", {}, 1, ""),
    "x⁴ + 6x²y² + y⁴": ("x**4 + 6*x**2*y**2 + y**4", {}, 2, "cartesian"),
    "x⁴ + 12x²y² + 16y⁴": ("x**4 + 12*x**2*y**2 + 16*y**4", {}, 2, "parabolic"),
    "r⁴": ("(x**2 + y**2)**2", {}, 2, "polar"),
    "Garnier": ("(x**2 + y**2)**2 + x**2 + 3/2*y**2", {}, 2, "elliptic"),
}
SPACE = {
    "Kepler": (f"-1/{R3}", {}, (10, 5), "rotational_parabolic conical spherical prolate_spheroidal"),
    "isotropic oscillator": (
        "(x**2 + y**2 + z**2)/2",
        {},
        (12, 7),
        "cartesian circular_cylinder elliptic_cylinder conical spherical prolate_spheroidal oblate_spheroidal "
        "ellipsoidal",
    ),
    "Yukawa (any central)": (f"-exp(-{R3})/{R3}", {}, (7, 2), "conical spherical"),
    "Stark": (f"-1/{R3} + z/10", {}, (3, 2), "rotational_parabolic"),
    "two centres": (
        "-1/sqrt(x**2 + y**2 + (z-1)**2) - 2/sqrt(x**2 + y**2 + (z+1)**2)",
        {},
        (3, 2),
        "prolate_spheroidal",
    ),
    "Calogero–Moser": (
        "1/(x-y)**2 + 1/(y-z)**2 + 1/(z-x)**2",
        {},
        (5, 4),
        "circular_cylinder rotational_parabolic spherical prolate_spheroidal oblate_spheroidal",
    ),
    "Garnier": ("(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 5*z**2", {}, (3, 2), "ellipsoidal"),
    "Miyamoto–Nagai": ("-1/sqrt(x**2 + y**2 + (1 + sqrt(z**2 + 1))**2)", {}, (2, 1), ""),
    "triaxial log halo": ("log(x**2 + y**2/2 + z**2/3 + 1)", {}, (1, 1), ""),
    "Smorodinsky–Winternitz": (
        "x**2 + y**2 + z**2 + 1/x**2 + 2/y**2 + 3/z**2",
        {},
        (6, 4),
        "cartesian circular_cylinder*3 elliptic_cylinder*3 conical spherical*3 prolate_spheroidal*3 "
        "oblate_spheroidal*3 ellipsoidal",
    ),
    "uniform field": (
        "z",
        {},
        (12, 7),
        "cartesian parabolic_cylinder circular_cylinder elliptic_cylinder paraboloidal rotational_parabolic",
    ),
    "oscillator, symbolic": ("A*x**2 + B*y**2 + C*z**2", {"A": None, "B": None, "C": None}, (3, 3), "cartesian"),
    "Garnier, symbolic": (
        "(x**2 + y**2 + z**2)**2 + A*x**2 + B*y**2 + C*z**2",
        {"A": None, "B": None, "C": None},
        (3, 2),
        "ellipsoidal",
    ),
    "free particle": (
        "0",
        {},
        (20, 10),
        "cartesian circular_cylinder elliptic_cylinder parabolic_cylinder conical spherical prolate_spheroidal "
        "oblate_spheroidal rotational_parabolic ellipsoidal paraboloidal",
    ),
}


def wanted(kinds: str) -> Counter[str]:
    """Read ``kind kind*3``."""
    count: Counter[str] = Counter()
    for word in kinds.split():
        kind, _, number = word.partition("*")
        count[kind.replace("_", " ")] += int(number or 1)
    return count


def row(n: int, name: str, entry: tuple[str, dict[str, object], object, str]) -> bool:
    """Print one line; return whether it is as expected."""
    potential, parameters, dimension, kinds = entry
    names = ("x", "y", "z")[:n]
    kinetic = "(" + " + ".join(f"dot({q})**2" for q in names) + ")/2"
    system = System(dict.fromkeys(names, "line"), kinetic, potential, parameters)
    wall, cpu = time.perf_counter(), time.process_time()
    found = find_coordinates(system)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    got = found.kernel_dimension if n == 2 else (found.kernel_dimension, found.concircular_dimension)
    kinds_found = Counter(web.kind for web in found.webs)
    good = got == dimension and kinds_found == wanted(kinds) and found.complete and all(w.certified for w in found.webs)
    slowest = max((web.verdict.seconds for web in found.webs if web.certified), default=0.0)
    words = ", ".join(f"{kind}×{number}" if number > 1 else kind for kind, number in kinds_found.items()) or "none"
    special = "; ".join(
        ", ".join(f"{k} = {v}" for k, v in value.conditions.items()) + f": {value.kernel_dimension}"
        for value in found.special
    )
    mark = "" if good else f"  DIFFERS, expected {dimension}: {kinds}"
    more = f"  [{special}]" if special else ""
    print(f"{name:31} {got!s:>8} {wall:7.2f} {cpu:7.2f} {slowest:9.2f}  {words}{more}{mark}")
    return good


def main() -> int:
    """Print the tables."""
    which = sys.argv[1:] or ["plane", "space"]
    find_coordinates(System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**2 + x*y"))
    good = True
    for title, n, table in (("plane", 2, PLANE), ("space", 3, SPACE)):
        if title in which:
            print(f"\n{title:31}   kernel  wall s   CPU s  separate  webs")
            good &= sum(row(n, name, entry) for name, entry in table.items()) == len(table)
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
