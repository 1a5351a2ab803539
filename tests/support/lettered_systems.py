"""Forty systems whose formulas hold letters with values: the same formula is typed with the letters and with the values.

``{k}`` in a formula is the letter k, or its value. They are the systems that the tests of ``coordinates`` use with
numbers, and galaxies as the guides type them.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from hjsolve import System

_AXES = {2: ("x", "y"), 3: ("x", "y", "z")}


@dataclass(frozen=True)
class Lettered:
    """A potential with letters.

    Attributes:
        name: of the case.
        formula: V with {letter} for every letter.
        values: letter → value.
        n: dimension.
        special: whether its coordinates exist at these values alone.
    """

    name: str
    formula: str
    values: dict[str, str]
    n: int
    special: bool = False

    @property
    def label(self) -> str:
        """Its name and what it moves in."""
        return f"{self.name}, {'plane' if self.n == 2 else 'space'}"

    def with_letters(self) -> System:
        """The system whose parameters have the values."""
        return self._system(self.formula.format(**{s: s for s in self.values}), self.values)

    def with_numbers(self) -> System:
        """The system with the values in its formula."""
        return self._system(self.formula.format(**{s: _written(v) for s, v in self.values.items()}), {})

    def _system(self, potential: str, values: dict[str, str]) -> System:
        names = _AXES[self.n]
        kinetic = "(" + " + ".join(f"dot({q})**2" for q in names) + ")/2"
        return System(dict.fromkeys(names, "line"), kinetic, potential, values)


def _written(value: str) -> str:
    return value if Fraction(value) >= 0 and "/" not in value else f"({value})"


r, R = "sqrt(x**2 + y**2)", "sqrt(x**2 + y**2 + z**2)"
_KUZMIN = "-{GM}/sqrt(x**2+y**2+z**2+{a}**2+{c}**2+2*sqrt({a}**2*{c}**2+{c}**2*(x**2+y**2)+{a}**2*z**2))"
_TWO = "-{k}/sqrt((x-{a})**2 + (y-{b})**2) - {j}/sqrt((x-{c})**2 + (y-{d})**2)"
_MAGNET = f"-{{GM}}/{R} + {{k}}*({{a}}*x + {{b}}*y + {{c}}*z)/{R}**3"

PLANE = (
    Lettered("Kepler", f"-{{k}}/{r}", {"k": "2"}, 2),
    Lettered("Kepler elsewhere", "-{k}/sqrt((x-{a})**2 + (y-{b})**2)", {"k": "1", "a": "1", "b": "2"}, 2),
    Lettered("two centres", "-{k}/sqrt((x-{a})**2 + y**2) - {j}/sqrt((x+{a})**2 + y**2)", {"k": "1", "j": "2", "a": "1"}, 2),
    Lettered("two centres off the axes", _TWO, {"k": "1", "j": "3", "a": "1", "b": "2", "c": "3", "d": "-1"}, 2),
    Lettered("Stark", f"-{{k}}/{r} + {{F}}*x", {"k": "1", "F": "1/10"}, 2),
    Lettered("Stark, oblique", f"-{{k}}/{r} + {{F}}*x + {{G}}*y", {"k": "1", "F": "1/10", "G": "1/5"}, 2),
    Lettered("oscillator 1:2", "({A}*x**2 + {B}*y**2)/2", {"A": "1", "B": "4"}, 2),
    Lettered("coupled oscillators", "({A}*x**2 + {B}*y**2)/2 + {C}*x*y", {"A": "1", "B": "3", "C": "1/2"}, 2),
    Lettered("Henon-Heiles", "({A}*x**2 + {B}*y**2)/2 + {D}*x**2*y - {C}*y**3", {"A": "1", "B": "1", "D": "1", "C": "1/3"}, 2),
    Lettered("Sawada-Kotera", "({A}*x**2 + {B}*y**2)/2 + x**2*y + {C}*y**3", {"A": "1", "B": "1", "C": "1/3"}, 2, True),
    Lettered("KdV", "({A}*x**2 + {B}*y**2)/2 + {D}*(x**2*y + 2*y**3)", {"A": "1", "B": "4", "D": "1"}, 2),
    Lettered("Kaup-Kupershmidt", "({A}*x**2 + 16*{A}*y**2)/2 + x**2*y + {C}*y**3", {"A": "1", "C": "16/3"}, 2),
    Lettered("Toda", "(exp({a}*x + 2*sqrt(3)*y) + exp({a}*x - 2*sqrt(3)*y) + exp(-{b}*x))/24", {"a": "2", "b": "4"}, 2),
    Lettered("quartic 1:6:1", "{a}*(x**4 + 6*x**2*y**2 + y**4)", {"a": "1"}, 2),
    Lettered("quartic 1:12:16", "{a}*(x**4 + {b}*x**2*y**2 + {c}*y**4)", {"a": "1", "b": "12", "c": "16"}, 2, True),
    Lettered("quartic oscillator", "{a}*(x**2 + y**2)**2", {"a": "1"}, 2),
    Lettered("Garnier", "{a}*(x**2 + y**2)**2 + {A}*x**2 + {B}*y**2", {"a": "1", "A": "1", "B": "3/2"}, 2),
    Lettered("anisotropic inverse squares", "{A}*(x**2 + y**2) + {b}/x**2 + {c}/y**2", {"A": "1", "b": "1", "c": "2"}, 2),
    Lettered("Yukawa", f"-{{k}}*exp(-{{a}}*{r})/{r}", {"k": "1", "a": "1/2"}, 2),
    Lettered("logarithmic halo", "{v}**2/2*log({c}**2 + x**2 + y**2/{q}**2)", {"v": "1", "c": "1/2", "q": "4/5"}, 2),
    Lettered("perfect ellipse", "-{GM}/sqrt(x**2+y**2+{a}**2+{c}**2+2*sqrt({a}**2*{c}**2+{c}**2*x**2+{a}**2*y**2))", {"GM": "1", "a": "1", "c": "1/2"}, 2),
)  # fmt: skip
SPACE = (
    Lettered("Kepler", f"-{{k}}/{R}", {"k": "1"}, 3),
    Lettered("Kepler elsewhere", "-{k}/sqrt((x-{a})**2 + (y-{b})**2 + (z-{c})**2)", {"k": "1", "a": "1", "b": "2", "c": "-1"}, 3),
    Lettered("Yukawa", f"-{{k}}*exp(-{{a}}*{R})/{R}", {"k": "1", "a": "1"}, 3),
    Lettered("isochrone", "-{GM}/({b} + sqrt({b}**2 + x**2 + y**2 + z**2))", {"GM": "1", "b": "1"}, 3),
    Lettered("NFW", f"-{{GM}}*log(1 + {R}/{{a}})/{R}", {"GM": "1", "a": "2"}, 3),
    Lettered("Plummer", "-{GM}/sqrt(x**2 + y**2 + z**2 + {b}**2)", {"GM": "1", "b": "1/2"}, 3),
    Lettered("Stark", f"-{{k}}/{R} + {{F}}*z", {"k": "1", "F": "1/10"}, 3),
    Lettered("two centres", "-{m1}/sqrt(x**2 + y**2 + (z-{d})**2) - {m2}/sqrt(x**2 + y**2 + (z+{d})**2)", {"m1": "1", "m2": "2", "d": "1"}, 3),
    Lettered("Kuzmin-Kutuzov", _KUZMIN, {"GM": "1", "a": "1", "c": "1/2"}, 3),
    Lettered("Miyamoto-Nagai", "-{GM}/sqrt(x**2 + y**2 + ({a} + sqrt(z**2 + {b}**2))**2)", {"GM": "1", "a": "1", "b": "1/2"}, 3),
    Lettered("triaxial logarithmic halo", "{v}**2/2*log({c}**2 + x**2 + y**2/{p}**2 + z**2/{q}**2)", {"v": "1", "c": "1", "p": "3/2", "q": "2"}, 3),
    Lettered("oscillator", "{A}*x**2 + {B}*y**2 + {C}*z**2", {"A": "1", "B": "2", "C": "3"}, 3),
    Lettered("Calogero-Moser", "{g}/(x - y)**2 + {g}/(y - z)**2 + {g}/(z - x)**2", {"g": "1"}, 3),
    Lettered("Garnier", "{a}*(x**2 + y**2 + z**2)**2 + {A}*x**2 + {B}*y**2 + {C}*z**2", {"a": "1", "A": "1", "B": "2", "C": "5"}, 3),
    Lettered("Smorodinsky-Winternitz", "{A}*(x**2 + y**2 + z**2) + {a}/x**2 + {b}/y**2 + {c}/z**2", {"A": "1", "a": "1", "b": "2", "c": "3"}, 3),
    Lettered("KdV with a bound z", "({A}*x**2 + {B}*y**2)/2 + {D}*(x**2*y + 2*y**3) + {e}*z**4", {"A": "1", "B": "4", "D": "1", "e": "1"}, 3),
    Lettered("Henon-Heiles with a bound z", "({A}*x**2 + {B}*y**2)/2 + x**2*y - {C}*y**3 + {D}*z**2", {"A": "1", "B": "1", "C": "1/3", "D": "1"}, 3),
    Lettered("dipole and charge", f"-{{GM}}/{R} + {{k}}*z/{R}**3", {"GM": "1", "k": "1"}, 3),
    Lettered("Hartmann's ring", f"-{{k}}/{R} + {{b}}/(x**2 + y**2)", {"k": "1", "b": "1/2"}, 3),
)  # fmt: skip
ALL = PLANE + SPACE
