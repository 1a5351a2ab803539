"""Closed forms of textbook potentials that the library was not written for: ``python -m benchmarks.held_out_forms``.

Potentials of textbooks on mechanics and of solvable quantum mechanics, with letters as scales, widths and shifts, and
some typed in two ways. One line for each: the kind of the motion, x(t) or r(t), the orbit, E(J) or why there is none
(``no`` proved, ``?`` only not found), operations of the longest form, and seconds. ``--forms`` prints the forms.
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

import sympy as sp

import hjsolve
from hjsolve import System
from hjsolve.errors import HJSolveError

_LINE, _HALF, _CELL = {"x": "line"}, {"x": "0 < x"}, {"x": "0 < x < pi/a"}
_PLANE = {"r": "0 < r", "phi": "angle"}
_KINETIC = "m*(dot(r)**2 + r**2*dot(phi)**2)/2"
Case = tuple[str, System, dict[str, dict[str, str]]]


def one(
    name: str, potential: str, values: dict[str, str], domain: dict[str, str] = _LINE, kinetic: str = "m*dot(x)**2/2",
    place: str = "1/3", speed: str = "1/5",
) -> Case:  # fmt: skip
    """Return a motion along x."""
    system = System(domain, kinetic, potential, {"m": "1", **values})
    return name, system, {"q": {"x": place}, "velocity": {"x": speed}}


def central(name: str, potential: str, values: dict[str, str], turning: str = "4/5") -> Case:
    """Return a motion in a plane."""
    start = {"q": {"r": "1", "phi": "0"}, "velocity": {"r": "1/5", "phi": turning}}
    return name, System(_PLANE, _KINETIC, potential, {"m": "1", **values}), start


_U, _UB, _AB = {"U": "2", "a": "2/3"}, {"U": "2", "a": "2/3", "B": "1/3"}, {"A": "1", "a": "2/3", "B": "1/3"}
_WIDE, _K, _KB = {"x": "-3*pi/4 < x < 3*pi/4"}, {"k": "1"}, {"k": "1", "b": "1/9"}
_PENDULUM, _RING = {"g": "1", "l": "1"}, {"g": "1", "R": "1", "w": "3/2"}

CASES: tuple[Case, ...] = (
    one("Morse, two exponentials", "D*exp(-2*a*x) - 2*D*exp(-a*x)", {"D": "2", "a": "1/2"}),
    one("Morse about x0", "D*(1 - exp(-a*(x - x0)))**2", {"D": "2", "a": "1/2", "x0": "1/4"}),
    one("Pöschl-Teller, cosh", "-U/cosh(a*x)**2", _U),
    one("Pöschl-Teller, exponentials", "-4*U/(exp(a*x) + exp(-a*x))**2", _U),
    one("tan²", "U*tan(a*x)**2", _U, _WIDE),
    one("1/sin²", "U/sin(a*x)**2", _U, {"x": "0 < x < 3*pi/2"}, place="1"),
    one("cot²", "U*cot(a*x)**2", _U, {"x": "0 < x < 3*pi/2"}, place="1"),
    one("Pöschl-Teller, two walls", "A/sin(a*x)**2 + B/cos(a*x)**2", _AB, {"x": "0 < x < pi/(2*a)"}, place="1"),
    one("Rosen-Morse", "-U/cosh(a*x)**2 + B*tanh(a*x)", _UB),
    one("Rosen-Morse, trigonometric", "A/sin(a*x)**2 + 2*B*cot(a*x)", _AB, _CELL, place="1"),
    one("Eckart", "A/sinh(a*x)**2 - B*coth(a*x)", {"A": "1", "a": "2/3", "B": "6"}, _HALF, place="1"),
    one("Scarf, trigonometric", "(A + B*sin(a*x))/cos(a*x)**2", _AB, _WIDE),
    one("Scarf, hyperbolic", "(-A + B*sinh(a*x))/cosh(a*x)**2", _AB),
    one("Hulthén", "-U/(exp(a*x) - 1)", {"U": "1", "a": "2/3"}, _HALF, place="1", speed="-1/5"),
    one("Woods-Saxon", "-U/(1 + exp((x - R)/a))", {"U": "1", "a": "1/2", "R": "2"}),
    one("exponential", "A*exp(a*x)", {"A": "1/2", "a": "2/3"}),
    one("cosh", "A*cosh(a*x)", {"A": "1/2", "a": "2/3"}),
    one("sinh²", "A*sinh(a*x)**2", {"A": "1/2", "a": "2/3"}),
    one("1/sinh²", "-U/sinh(a*x)**2", {"U": "1", "a": "2/3"}, _HALF, place="1", speed="-1/5"),
    one("-coth", "-U*coth(a*x)", {"U": "1", "a": "2/3"}, _HALF, place="1", speed="-1/5"),
    one("x⁴", "A*x**4", {"A": "1/2"}),
    one("Duffing", "k*x**2/2 + b*x**4/4", {"k": "2", "b": "3"}),
    one("double well", "-k*x**2/2 + b*x**4/4", {"k": "2", "b": "3"}),
    one("(x² - a²)²", "l*(x**2 - a**2)**2", {"l": "2", "a": "3/4"}),
    one("cubic well", "k*x**2/2 - b*x**3/3", {"k": "2", "b": "1/2"}),
    one("x³", "A*x**3", {"A": "1/2"}),
    one("cubic", "a*x**3 + b*x**2 + c*x", {"a": "1/5", "b": "1", "c": "1/7"}),
    one("quartic", "a*x**4 + b*x**3 + c*x**2 + d*x", {"a": "1/5", "b": "1/9", "c": "1", "d": "1/7"}),
    one("x⁶", "A*x**6", {"A": "1/2"}),
    one("x² + 1/x²", "k*x**2/2 + g/x**2", {"k": "2", "g": "1/3"}, _HALF, place="1"),
    one("-1/x²", "-g/x**2", {"g": "1/3"}, _HALF, place="1"),
    one("Kratzer", "-2*D*(a/x - a**2/(2*x**2))", {"D": "1", "a": "3/4"}, _HALF, place="1"),
    one("1/x", "k/x", _K, _HALF, place="1"),
    one("-1/x", "-k/x", _K, _HALF, place="1"),
    one("linear", "F*x", {"F": "1"}),
    one("√x", "k*sqrt(x)", _K, _HALF, place="1"),
    one("x^(2/3)", "k*x**(2/3)", _K, _HALF, place="1"),
    one("1/x⁴", "k/x**4", _K, _HALF, place="1"),
    one("log", "k*log(x)", _K, _HALF, place="1"),
    one("lattice", "-U*cos(k*x)", {"U": "1", "k": "2"}),
    one("lattice, sin²", "U*sin(k*x)**2", {"U": "1", "k": "2"}),
    one("washboard", "-U*cos(x) - F*x", {"U": "1", "F": "1/5"}),
    one("two cosines", "-U*cos(x) - W*cos(2*x)", {"U": "1", "W": "1/3"}, {"x": "angle"}),
    one("pendulum", "-m*g*l*cos(x)", _PENDULUM, {"x": "angle"}, "m*l**2*dot(x)**2/2"),
    one("turning ring", "-m*g*R*cos(x) - m*w**2*R**2*sin(x)**2/2", _RING, {"x": "angle"}, "m*R**2*dot(x)**2/2"),
    one("bead on a parabola", "m*g*a*x**2", {"g": "1", "a": "1/2"}, kinetic="m*(1 + 4*a**2*x**2)*dot(x)**2/2"),
    one("cycloidal pendulum", "m*g*R*(1 - cos(x))", {"g": "1", "R": "1"}, {"x": "-pi < x < pi"},
        "m*R**2*(1 + cos(x))*dot(x)**2"),
    one("Mathews-Lakshmanan", "k*x**2/(2*(1 + a*x**2))", {"k": "1", "a": "1/3"},
        kinetic="m*dot(x)**2/(2*(1 + a*x**2))"),
    one("√(a² + x²)", "k*sqrt(a**2 + x**2)", {"k": "1", "a": "1/2"}),
    one("-1/√(a² + x²)", "-k/sqrt(a**2 + x**2)", {"k": "1", "a": "1/2"}),
    one("-1/(a² + x²)", "-k/(a**2 + x**2)", {"k": "1", "a": "1/2"}),
    one("Gauss", "-k*exp(-x**2)", _K),
    central("Kepler", "-k/r", _K),
    central("Kepler, hyperbola", "-k/r", _K, "9/5"),
    central("repulsion", "k/r", _K),
    central("oscillator", "k*r**2/2", _K),
    central("Kepler + 1/r²", "-k/r + b/r**2", _KB),
    central("Kepler - 1/r²", "-k/r - b/r**2", _KB),
    central("oscillator + 1/r²", "k*r**2/2 + b/r**2", _KB),
    central("-1/r²", "-b/r**2", {"b": "1/9"}),
    central("-1/r³", "-b/r**3", {"b": "1/9"}),
    central("-1/r⁴", "-b/r**4", {"b": "1/9"}),
    central("Kepler - 1/r³", "-k/r - b/r**3", {"k": "1", "b": "1/90"}),
    central("Cornell", "-k/r + b*r", _KB),
    central("r", "b*r", {"b": "1"}),
    central("isochrone", "-k/(b + sqrt(b**2 + r**2))", {"k": "1", "b": "1/2"}),
    central("Plummer", "-k/sqrt(r**2 + b**2)", {"k": "1", "b": "1/2"}),
    central("free", "0*r", {}),
    central("log r", "k*log(r)", _K),
    central("r⁴", "k*r**4", _K),
    central("r⁶", "k*r**6", _K),
    central("-1/r⁶", "-b/r**6", {"b": "1/9"}),
    central("Kepler + r²", "-k/r + c*r**2/2", {"k": "1", "c": "1/9"}),
)  # fmt: skip


def _told(form: Any, table: Any, key: str, name: str) -> str:
    if table and name in table:
        return "yes"
    reason = form.why_not.get(f"{key}.{name}" if name else key)
    return "" if reason is None else "no" if reason.proved else "?"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--forms", action="store_true")
    options = parser.parse_args()
    print("| system | motion | t(q) | q(t) | by parameter | orbit | J | E(J) | longest | seconds |\n|" + "---|" * 10)
    failed = 0
    for name, system, start in CASES:
        if options.names and not any(part in name for part in options.names):
            continue
        begin = time.process_time()
        try:
            motion = hjsolve.solve(system).motion(**start)
            form = hjsolve.closed_forms(motion)[0]
        except HJSolveError as error:
            failed += 1
            print(f"| {name} | {type(error).__name__}: {error} |" + " |" * 8, flush=True)
            continue
        q = next(iter(motion.turning_points or motion.kinds))
        law = "yes" if form.time_law is not None else _told(form, None, "time_law", "")
        energy = "yes" if form.energy is not None else _told(form, None, "energy", "")
        orbit = _told(form, form.orbit, "orbit", q)
        cells = [law, _told(form, form.inverse, "inverse", q), "yes" if form.anomaly else "", orbit,
                 "yes" if form.actions else "", energy]  # fmt: skip
        forms = [form.time_law, form.energy, *form.inverse.values(), *form.orbit.values(), *form.actions.values()]
        longest = max((int(sp.count_ops(f)) for f in forms if f is not None), default=0)
        seconds = time.process_time() - begin
        print(f"| {name} | {motion.kinds[q]} | {' | '.join(cells)} | {longest} | {seconds:.1f} |", flush=True)
        if options.forms:
            print(*(f"    {f}" for f in forms if f is not None), sep="\n", file=sys.stderr)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
