"""cosh((x − c)/w) next to cosh(x/L) was a RecursionError: sympy turned the sign of an argument that was turned back."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.separation import Zero, is_zero

PARAMETERS: dict[str, object] = {"L": 2, "U": 1, "a": 3, "b": "1/2", "c": "1/3", "w": "1/5"}
SHIFTED = [
    "w*(3/7 - x/L)", "x - L", "x*(1 - L) - (a - c)", "(L - x)/(a - b)", "(x/(a - b) - L)*9", "(x - c)/(b - a)",
    "x*(L - 1) + c", "(x/L - 67/99)/(59/500000)", "-x/L - sqrt(2)", "(c - x/L)/7",
]  # fmt: skip


@pytest.mark.parametrize("argument", SHIFTED)
@pytest.mark.parametrize("narrow", ["1/cosh({})**2", "sinh({})", "sin({})**2", "tan({})"])
def test_a_shifted_function_beside_one_that_is_not(argument: str, narrow: str) -> None:
    potential = f"U*(cosh(x/L) + {narrow.format(argument)})"
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", potential, PARAMETERS)
    assert isinstance(hjsolve.separate(system), hjsolve.Separation)


@pytest.mark.parametrize("argument", SHIFTED)
@pytest.mark.parametrize(("sine", "cosine", "sign"), [(sp.sin, sp.cos, 1), (sp.sinh, sp.cosh, -1)])
def test_identities_of_shifted_arguments_are_decided(argument: str, sine: type, cosine: type, sign: int) -> None:
    names = {name: sp.Symbol(name, real=True) for name in ("x", *PARAMETERS)}
    u = sp.sympify(argument, locals=names)
    beside = cosine(names["x"] / names["L"])
    square = sine(u) ** 2 + sign * cosine(u) ** 2 - sign
    odd = sine(u) + sine(-u)
    slope = sp.diff(beside * sine(u), names["x"]) - sp.diff(beside, names["x"]) * sine(u)
    slope -= beside * cosine(u) * sp.diff(u, names["x"])
    for identity in (square, odd, slope):
        assert isinstance(is_zero(identity * beside), Zero)
        assert not isinstance(is_zero((identity + sp.Rational(1, 1000) * sine(u)) * beside), Zero)


def test_its_motion_is_right() -> None:
    """A narrow dip off the centre of a well, in numbers far from 1; by quadrature in 30 digits."""
    mp = mpmath.mp.clone()
    mp.dps = 30
    units = {"L": "1e-10", "m": "1e-17", "U": "1e-2"}
    well = hjsolve.System(
        {"x": "line"}, "m*dot(x)**2/2", "U*(cosh(x/L) - 0.0742/cosh((x/L - 0.67680286)/0.000118)**2)", units
    )
    motion = hjsolve.solve(well).motion(q={"x": "1.28105963e-11"}, velocity={"x": "2.82961e+7"})

    def height(z: mpmath.mpf) -> mpmath.mpf:
        return mp.cosh(z) - mp.mpf("0.0742") / mp.cosh((z - mp.mpf("0.67680286")) / mp.mpf("0.000118")) ** 2

    start = mp.mpf("0.128105963")
    energy = mp.mpf("2.82961e7") ** 2 / 2 * mp.mpf("1e-15") + height(start)
    end = mp.acosh(energy)
    dip = [mp.mpf("0.67680286") + k * mp.mpf("0.000118") for k in (-40, -20, -8, -3, -1, 0, 1, 3, 8, 20, 40)]
    places = [mp.asin(z / end) for z in (-end, *dip, end)]

    def slowness(χ: mpmath.mpf) -> mpmath.mpf:
        return end * mp.cos(χ) / mp.sqrt(2 * (energy - height(end * mp.sin(χ))))

    period = 2 * mp.quad(slowness, places) * mp.mpf("1e-10") * mp.sqrt(mp.mpf("1e-15"))
    claimed = motion.periods["x"]
    assert abs(mp.mpf(claimed.value) - period) <= claimed.error
    assert claimed.error < 1e-12 * claimed.value
    upper = motion.turning_points["x"][1]
    assert abs(mp.mpf(upper.value) - end * mp.mpf("1e-10")) <= upper.error
