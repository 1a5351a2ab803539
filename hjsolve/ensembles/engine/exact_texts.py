"""The texts of programs that know p² to 32 digits next to a turning point; the twin of ``DoubleDoubleEvaluation``.

Offsets d are distances from the turning point, in doubles; the turning point b and the constants come in two doubles,
all in one row of known numbers: the constants, their low parts, and high and low of the lower and the upper b.

    exact_squares(place, low, C, f)              F of many orbits at places in two doubles; C as of ``slope``
    fill, uncertainties, relative                as of a view (``program_texts``), at b + d; the last one is not used
"""

from __future__ import annotations

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.pair_source import NamedPair, PairSource, needed, written
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula
from hjsolve.ensembles.engine.program_texts import NO_RELATIVE, doubtful, filled, loop, unpacked

EXACT = ("exact_squares", "fill", "uncertainties", "relative")
"""The functions of a view to 32 digits."""

_RELATIVE, _FINER = f"({4 * UNIT!r})", f"({2.0**-44!r})"
_BASE = NamedPair("base", "base_low")


def exact_text(
    formula: LoweredFormula, constants: int, numbers: tuple[Pair, ...], kernels: bool, upper: bool
) -> str:  # fmt: skip
    """Return the text of the functions of a view.

    Args:
        formula: p² as a function of x.
        constants: how many there are.
        numbers: values of the parameters, in two doubles.
        kernels: whether ∂J/∂c are wanted.
        upper: whether b is the upper turning point.
    """
    known = [*(NamedPair(f"c{j}", f"l{j}") for j in range(constants)), *map(written, numbers)]
    row = [*(f"c{j}" for j in range(constants)), *(f"l{j}" for j in range(constants))]
    row += ["lower", "lower_low", "upper", "upper_low"]
    end = "upper" if upper else "lower"
    unpack = unpacked(row) + f"    base, base_low = {end}, {end}_low\n"
    return "\n".join(
        (
            _squares_text(formula, constants, known),
            _fill_text(formula, unpack, known, kernels),
            _uncertainties_text(formula, unpack, known, constants, tuple(float(x.high) for x in numbers), kernels),
            NO_RELATIVE,
        )
    )


def _squares_text(formula: LoweredFormula, constants: int, known: list[NamedPair]) -> str:
    source = PythonSource()
    square = formula.squared.run(PairSource(source), [NamedPair("x", "e"), *known])[0].high
    lines = ["x = place[i]", "e = low[i]", *(f"c{j} = C[{j}, i]" for j in range(constants))]
    lines += [f"l{j} = C[{constants + j}, i]" for j in range(constants)]
    lines += [*needed(source.lines, [square]), f"f[i] = {square}"]
    return loop("exact_squares(place, low, C, f)", "", "i in range(place.shape[0])", lines)


def _square(formula: LoweredFormula, source: PythonSource, known: list[NamedPair]) -> tuple[str, str]:
    """F at b + d, and b + d in doubles."""
    pairs = PairSource(source)
    place = pairs.add(_BASE, NamedPair("d", "(0.0)"))
    return formula.squared.run(pairs, [place, *known])[0].high, place.high


def _fill_text(formula: LoweredFormula, unpack: str, known: list[NamedPair], kernels: bool) -> str:
    source = PythonSource()
    square, place = _square(formula, source, known)
    weights = formula.full.run(source, [place, *(k.high for k in known)])[1:] if kernels else []
    source.lines[:] = needed(source.lines, [square, *weights])
    return filled(source, unpack, ["d = s * W * near[j]"], square, list(weights))


def _uncertainties_text(
    formula: LoweredFormula, unpack: str, known: list[NamedPair], constants: int, numbers: tuple[float, ...],
    kernels: bool,
) -> str:  # fmt: skip
    """F is known relatively, but for 2⁻⁴⁴ of what doubles lose of it; the constants' errors are never told apart."""
    source = PythonSource()
    square, place = _square(formula, source, known)
    tape = formula.full if kernels else formula.squared
    rough, *others = doubtful(tape, source, place, source.unary("abs", place), constants, numbers)[:-1]
    lost = rough.split(" = ", 1)[1]
    own = source.add(
        source.mul(_RELATIVE, source.unary("abs", square)), source.mul(_FINER, source.unary("abs", lost))
    )  # fmt: skip
    results = [f"out[0, g] = {own}", *others, f"out[{1 + len(others)}, g] = {square}"]
    wanted = [own, square, *(line.split(" = ", 1)[1] for line in others)]
    before = unpack + unpacked([f"e{j}" for j in range(constants)], "e")
    lines = ["d = place[g]", *needed(source.lines, wanted), *results]
    return loop("uncertainties(out, place, size, mask, c, e)", before, "g in range(place.shape[0])", lines)
