"""The texts of the programs of one system, written from its tapes for numba (extra ``fast``).

A program is straight-line Python over doubles, or the same inside a loop over places that LLVM vectorises. Its text
comes from operation codes and numbers (``arithmetic/python_source.py``); nothing that a user wrote gets into it.

Every view of p² (``radicand_views``) has the same functions, over offsets x in it and known numbers c:

    value(x, c)                                  F; of small motions F[q₀, q₀, q₀ + x]
    bend(x, c)                                   F, F′, F″; not of small motions
    slopes(x, C, f, d)                           F and F′ of many orbits
    fill(buffer, b, s, W, h, g, along, near, far, derivative, start, stop, c)
                                                 F r, r, F, kernels times r at x = h + g W along, d = s W near from b
    uncertainties(out, place, size, mask, c, e)  bounds on the errors of F and of the kernels, and F
    relative(out, base, offset, place, size, c)  bounds on the relative error of F[b, x], x = b + d

A place x is counted from that turning point h at which the smaller offset is: b − W y next to a pole at x = 0 would be
the small difference of two large numbers. ``size`` is what the roundings of x are in proportion to.
    slope(place, C, d)                           F′ to full relative accuracy, from 32 digits; of small motions only
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from hjsolve.arithmetic.divided_differences import FirstDifferences
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.pair_source import NamedPair, PairSource, needed, written
from hjsolve.arithmetic.python_source import PythonSource, function
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.second_differences import SecondDifference, SecondDifferences
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model
from hjsolve.ensembles.engine.orbit_vectors import vector_text
from hjsolve.ensembles.engine.radicand_views import has_chords

OWN = 4
"""Units of rounding of a compiled elementary function."""
_PLACE = f"({2 * UNIT!r})"
_ROUNDED = f"({6 * UNIT!r})"
_OFFSETS = f"({16 * UNIT!r})"
"""Roundings of distances from the turning points and of what they are multiplied with."""
NO_RELATIVE = "def relative(out, base, offset, place, size, c):\n    out[:] = 0.0\n"

_MORE = ("start0", "square0", "first0", "doubt0", "width0")
"""What programs of small motions know after the constants: q₀, P₀², F′₀, a bound on errors of F[q, q, q + x], and W."""

VIEW = ("value", "bend", "slopes", "fill", "uncertainties", "relative")
SMALL = ("value", "bounds", "fill", "uncertainties", "relative", "slope")
"""The functions of a view, and of small motions."""


def view_text(formula: LoweredFormula, constants: int, numbers: tuple[float, ...], kernels: bool) -> str:
    """Return the text of the functions of a view.

    Args:
        formula: p² as a function of x.
        constants: how many there are.
        numbers: values of the parameters, doubles.
        kernels: whether ∂J/∂c are wanted.
    """
    names, literals = [f"c{j}" for j in range(constants)], [f"({x!r})" for x in numbers]
    squared = formula.squared

    def jet(source: PythonSource, order: int) -> list[str]:
        jets = Jets(source)
        inputs = [jets.variable("x"), *(Jet(k) for k in names + literals)]
        parts = squared.run(jets, inputs)[0]
        return ["(0.0)" if part is None else part for part in parts[: order + 1]]

    unpack = unpacked(names)
    return "\n".join(
        (
            _plain("value", unpack, lambda s: squared.run(s, ["x", *names, *literals])[:1], single=True),
            _plain("bend", unpack, lambda s: jet(s, 2)),
            _slopes_text(constants, lambda s: jet(s, 1)),
            _fill_text(formula, unpack, names + literals, kernels),
            _uncertainties_text(formula.full if kernels else squared, constants, numbers),
            _relative_text(formula, unpack, names, numbers) if has_chords(formula) else NO_RELATIVE,
        )
    )


def unpacked(names: list[str], array: str = "c") -> str:
    """Return lines that give the numbers of an array their names.

    Args:
        names: in order.
        array: its name.
    """
    return "".join(f"    {name} = {array}[{j}]\n" for j, name in enumerate(names))


def _plain(name: str, unpack: str, run: Callable[[PythonSource], Sequence[str]], *, single: bool = False) -> str:
    source = PythonSource()
    results = run(source)
    head, body = function(name, ["x", "c"], source, results).split("\n", 1)
    body = body.replace(f"return ({results[0]}, )", f"return {results[0]}") if single else body
    return f"{head}\n{unpack}{body}"


def loop(head: str, before: str, over: str, lines: list[str]) -> str:
    """Return the text of a function that is one loop.

    Args:
        head: its name and arguments.
        before: lines before the loop, indented.
        over: what the loop runs over.
        lines: what it does.
    """
    return f"def {head}:\n{before}    for {over}:\n" + "".join(f"        {line}\n" for line in lines)


def _slopes_text(constants: int, run: Callable[[PythonSource], Sequence[str]]) -> str:
    source = PythonSource()
    value, slope = run(source)
    lines = ["x = place[i]", *(f"c{j} = C[{j}, i]" for j in range(constants)), *source.lines]
    lines += [f"f[i] = {value}", f"d[i] = {slope}"]
    return loop("slopes(place, C, f, d)", "", "i in range(place.shape[0])", lines)


_FILL = "fill(buffer, b, s, W, h, g, along, near, far, derivative, start, stop, c)"


def _fill_text(formula: LoweredFormula, unpack: str, known: list[str], kernels: bool) -> str:
    """Fill the buffer; with kernels F next to a turning point b is d F[b, b + d], which keeps its digits."""
    source = PythonSource()
    if kernels and has_chords(formula):
        chords = FirstDifferences(source, "d")
        inputs = [chords.variable("b", "x"), *(chords.constant(k) for k in known)]
        (F,) = formula.squared.run(chords, inputs)
        square = source.mul("d", F.slope)
        _, *weights = formula.full.run(source, ["x", *known])
    else:
        square, *weights = (formula.full if kernels else formula.squared).run(source, ["x", *known])
    return filled(source, unpack, ["d = s * W * near[j]", "x = h + g * W * along[j]"], square, weights)


def filled(source: PythonSource, unpack: str, places: list[str], square: str, weights: list[str]) -> str:
    """Return the text of ``fill``.

    Args:
        source: the program that works out F and the kernels.
        unpack: lines before the loop.
        places: lines that make the place.
        square: F.
        weights: the kernels.
    """
    fixed, moving = _divided([*places, *source.lines])
    rows = [square + " * r", "r", square, *(f"{w} * r" for w in weights)]
    lines = [
        *moving,
        f"r = derivative[j] * sqrt_((W * near[j]) * (W * far[j]) / {square})",
        *(f"b{k}[j] = {row}" for k, row in enumerate(rows)),
    ]
    # slices, because LLVM makes vectors only of loops that begin at 0
    sliced = [f"{name} = {name}[start:stop]" for name in ("along", "near", "far", "derivative")]
    sliced += [f"b{k} = buffer[{k}, start:stop]" for k in range(len(rows))]
    before = unpack + "".join(f"    {line}\n" for line in (*fixed, *sliced))
    return loop(_FILL, before, "j in range(near.shape[0])", lines)


def _divided(lines: list[str]) -> tuple[list[str], list[str]]:
    """Lines that depend on the turning point alone, and those that depend on the node."""
    fixed, moving, depends = [], [], {"near", "along"}
    for line in lines:
        left, right = line.split(" = ", 1)
        words = re.findall(r"[A-Za-z_]\w*", right)
        if depends.isdisjoint(words):
            fixed.append(line)
        else:
            moving.append(line)
            depends.update(left.split(", "))
    return fixed, moving


def _relative_text(formula: LoweredFormula, unpack: str, names: list[str], numbers: tuple[float, ...]) -> str:
    """Bounds on the relative error of F[b, x], x = b + d."""
    source = PythonSource()
    chords = FirstDifferences(RunningError(source, own=OWN), WithErrorBound("d"))
    inputs = [chords.variable(WithErrorBound("b"), WithErrorBound("x", source.mul(_PLACE, "z")))]
    inputs += [chords.constant(WithErrorBound(c)) for c in names]
    inputs += [chords.constant(x) for x in _rounded(numbers)]
    slope = formula.squared.run(chords, inputs)[0].slope
    error = "(0.0)" if slope.error is None else slope.error
    lines = ["b = base[g]", "d = offset[g]", "x = place[g]", "z = size[g]", *source.lines]
    lines += [f"out[g] = abs({error}) / abs({slope.value})"]
    return loop("relative(out, base, offset, place, size, c)", unpack, "g in range(out.shape[0])", lines)


def _rounded(numbers: tuple[float, ...]) -> list[WithErrorBound]:
    return [WithErrorBound(f"({x!r})", f"({abs(x) * UNIT!r})") for x in numbers]


def doubtful(
    tape: Tape, source: PythonSource, place: str, size: str, constants: int, numbers: tuple[float, ...]
) -> list[str]:
    """Return lines that fill ``out`` with the errors of a tape's results, and at last the first result itself.

    Args:
        tape: of F, and of kernels after it.
        source: the program so far, which grows.
        place: where, a name.
        size: what the roundings of the place are in proportion to, a name.
        constants: how many there are; e0, e1, … bound their errors.
        numbers: values of the parameters.
    """
    inputs = [WithErrorBound(place, source.mul(_PLACE, size))]
    inputs += [*(WithErrorBound(f"c{j}", f"e{j}") for j in range(constants)), *_rounded(numbers)]
    results = tape.run(RunningError(source, own=OWN), inputs)
    lines = [f"out[{k}, g] = {'(0.0)' if r.error is None else r.error}" for k, r in enumerate(results)]
    return [*lines, f"out[{len(results)}, g] = {results[0].value}"]


def _uncertainties_text(tape: Tape, constants: int, numbers: tuple[float, ...]) -> str:
    source = PythonSource()
    results = doubtful(tape, source, "x", "z", constants, numbers)
    lines = ["x = place[g]", "z = size[g]", *(f"e{j} = mask[g] * s{j}" for j in range(constants))]
    lines += [*source.lines, *results]
    return loop("uncertainties(out, place, size, mask, c, e)", _both(constants), "g in range(place.shape[0])", lines)


def _both(constants: int) -> str:
    return unpacked([f"c{j}" for j in range(constants)]) + unpacked([f"s{j}" for j in range(constants)], "e")


def small_text(formula: LoweredFormula, constants: int, pairs: tuple[Pair, ...], kernels: bool) -> str:
    """Return the text of the functions of small motions, F(q₀ + x) = P₀² + x (F′₀ + x F[q₀, q₀, q₀ + x]).

    With kernels F is seen from the turning points, where it keeps its digits: as F vanishes at both, a distance s W
    apart, F(b + d) = d (d F[b, b, b + d] − s W F[b, b, b + s W]). What F is at the numbers that stand for the turning
    points is left out by that, as a linear function.

    Args:
        formula: p²(q).
        constants: how many there are.
        pairs: values of the parameters, in two doubles.
        kernels: whether ∂J/∂c are wanted.
    """
    numbers = tuple(float(pair.high) for pair in pairs)
    names, literals = [f"c{j}" for j in range(constants)], [f"({x!r})" for x in numbers]
    unpack = unpacked([*names, *_MORE])
    values = PythonSource()
    second = _second(formula, values, names + literals)
    source = PythonSource()
    if kernels:
        square = source.mul("d", _from_end(formula, source, names + literals)[0])
        _, *weights = formula.full.run(source, [source.add("start0", "x"), *names, *literals])
    else:
        square, weights = _square(source, _second(formula, source, names + literals)), []
    ends = ["origin = start0 + b", "span = s * W"] if kernels else []
    return "\n".join(
        (
            _plain("value", unpack, lambda s: _taken(values, s, second), single=True),
            _bounds_text(formula, constants, numbers),
            filled(source, unpack, [*ends, "d = s * W * near[j]", "x = b + d"], square, weights),
            _small_uncertainties_text(formula, constants, numbers, kernels),
            _small_relative_text(formula, unpack, names + literals) if kernels else NO_RELATIVE,
            _slope_text(formula, constants, pairs),
        )
    )


def _from_end(formula: LoweredFormula, source: PythonSource, known: list[str]) -> tuple[str, str]:
    """F[b, b + d] of a small motion, and the sizes of its two terms."""
    here = source.mul("d", _second(formula, source, known, "origin", "d"))
    there = source.mul("span", _second(formula, source, known, "origin", "span"))
    return source.sub(here, there), source.add(source.unary("abs", here), source.unary("abs", there))


def _small_relative_text(formula: LoweredFormula, unpack: str, known: list[str]) -> str:
    """Bounds on the relative error of F[b, b + d] of small motions."""
    source = PythonSource()
    slope, terms = _from_end(formula, source, known)
    doubt = source.mul("doubt0", source.add(source.unary("abs", "d"), "width0"))
    error = source.div(source.add(doubt, source.mul(_OFFSETS, terms)), source.unary("abs", slope))
    lines = ["b = base[g]", "d = offset[g]", "origin = start0 + b", "span = width0 if d > 0.0 else -width0"]
    lines += [*source.lines, f"out[g] = {error}"]
    return loop("relative(out, base, offset, place, size, c)", unpack, "g in range(out.shape[0])", lines)


def _taken(values: PythonSource, source: PythonSource, result: str) -> list[str]:
    source.lines[:] = values.lines
    return [result]


def _second(
    formula: LoweredFormula, source: PythonSource, known: list[str], start: str = "start0", offset: str = "x"
) -> str:
    """F[b, b, b + x]; of the start b = q₀."""

    def elementary(name: str, x: str, d: str) -> tuple[str, str, str]:
        if name in {"sin", "cos"}:
            s, c, bend_s, bend_c = source.called("sincos_bends", x, d, results=4)
            return (s, c, bend_s) if name == "sin" else (c, source.unary("neg", s), bend_c)
        if name in {"sinh", "cosh"}:
            s, c, bend_s, bend_c = source.called("sinhcosh_bends", x, d, results=4)
            return (s, c, bend_s) if name == "sinh" else (c, s, bend_c)
        if name == "exp":
            e, bend = source.called("exp_bend", x, d, results=2)
            return e, e, bend
        value, slope, bend = source.called("log_bend", x, d, results=3)
        return value, slope, bend

    def sign(x: str, y: str) -> str:
        return source.called("common_sign", x, y, results=1)[0]

    slopes = SecondDifferences(source, offset, elementary, sign)
    inputs = [slopes.variable(start), *(SecondDifference(k) for k in known)]
    result = formula.squared.run(slopes, inputs)[0]
    return "(0.0)" if result.second is None else result.second


def _square(source: PythonSource, second: str) -> str:
    return source.add("square0", source.mul("x", source.add("first0", source.mul("x", second))))


def _bounds_text(formula: LoweredFormula, constants: int, numbers: tuple[float, ...]) -> str:
    """½F″ at some places, and three times its running error; see ``radicand_views.second_slope``."""
    source = PythonSource()
    jets = Jets(RunningError(source, own=OWN))
    known = [*(WithErrorBound(f"c{j}", f"s{j}") for j in range(constants)), *_rounded(numbers)]
    place = WithErrorBound("x", source.mul(f"({UNIT!r})", source.unary("abs", "x")))
    bend = formula.squared.run(jets, [jets.variable(place), *(Jet(k) for k in known)])[0].second
    half, error = "(0.0)", "(0.0)"
    if bend is not None:
        half = source.mul("(0.5)", bend.value)
        size = source.mul(f"({4 * UNIT!r})", source.unary("abs", bend.value))
        error = source.mul("(1.5)", size if bend.error is None else source.add(bend.error, size))
    lines = ["x = place[g]", *source.lines, f"out[0, g] = {half}", f"out[1, g] = {error}"]
    return loop("bounds(out, place, c, e)", _both(constants), "g in range(place.shape[0])", lines)


def _small_uncertainties_text(
    formula: LoweredFormula, constants: int, numbers: tuple[float, ...], kernels: bool
) -> str:
    source = PythonSource()
    known = [f"c{j}" for j in range(constants)] + [f"({x!r})" for x in numbers]
    value = _square(source, _second(formula, source, known))
    wide = source.mul("(2.0)", source.unary("abs", source.mul("x", "first0")))
    rounding = source.mul(_ROUNDED, source.add("square0", wide))
    own = source.add(rounding, source.mul(source.mul("x", "x"), "doubt0"))
    results = [f"out[0, g] = {own}", f"out[1, g] = {value}"]
    if kernels:
        place = source.add("start0", "x")
        weights = doubtful(formula.full, source, place, source.unary("abs", place), constants, numbers)[1:-1]
        results = [results[0], *weights, f"out[{1 + len(weights)}, g] = {value}"]
    lines = ["x = place[g]", *(f"e{j} = mask[g] * s{j}" for j in range(constants)), *source.lines, *results]
    extra = "".join(f"    {name} = c[{constants + k}]\n" for k, name in enumerate(_MORE))
    before = _both(constants) + extra
    return loop("uncertainties(out, place, size, mask, c, e)", before, "g in range(place.shape[0])", lines)


def start_text(model: Model) -> str:
    """Return the text of ``start(given, made, cell)``; see ``orbit_vectors``.

    Rows given: q, p, the low parts of p, and bounds on the errors that p has in doubles, of which 2⁻⁴⁴ count. Rows
    made: the constants, their low parts, their uncertainties, and the shell momenta.

    Args:
        model: the lowered solution.
    """
    n = len(model.names)
    source = PythonSource()
    rows = [f"g{k}" for k in range(4 * n)]
    places, momenta, low, spread = (rows[k : k + n] for k in range(0, 4 * n, n))
    rounded = [WithErrorBound(f"({x.high!r})", f"({abs(x.high) * UNIT!r})") for x in model.numbers]
    given = [*map(WithErrorBound, places), *map(WithErrorBound, momenta, spread)]
    errors = [r.error or "(0.0)" for r in model.rule.run(RunningError(source, own=OWN), [*given, *rounded])]
    pairs = PairSource(source)
    inputs = [NamedPair(x, "(0.0)") for x in places]
    inputs += [*map(NamedPair, momenta, low), *map(written, model.numbers)]
    constants = model.rule.run(pairs, inputs)
    shifts = model.shift.run(pairs, inputs)
    shell = [pairs.add(inputs[n + c.index], shift).high for c, shift in zip(model.separated, shifts, strict=True)]
    uncertain = [
        source.add(source.unary("abs", value.low), source.mul(f"({2.0**-44!r})", error))
        for value, error in zip(constants, errors, strict=True)
    ]
    results = [*(c.high for c in constants), *(c.low for c in constants), *uncertain, *shell]
    return vector_text("start", len(rows), source, results)


def _slope_text(formula: LoweredFormula, constants: int, numbers: tuple[Pair, ...]) -> str:
    """F′ of many orbits to full relative accuracy; C has the high parts of the constants, then the low ones."""
    source = PythonSource()
    jets = Jets(PairSource(source))
    names = [NamedPair(f"c{j}", f"e{j}") for j in range(constants)]
    inputs = [jets.variable(NamedPair("x", "(0.0)")), *(Jet(k) for k in (*names, *map(written, numbers)))]
    first = formula.squared.run(jets, inputs)[0].first
    result = "(0.0)" if first is None else first.high
    lines = ["x = place[i]", *(f"c{j} = C[{j}, i]" for j in range(constants))]
    lines += [f"e{j} = C[{constants + j}, i]" for j in range(constants)]
    return loop(
        "slope(place, C, d)", "", "i in range(place.shape[0])",
        [*lines, *needed(source.lines, [result]), f"d[i] = {result}"],
    )  # fmt: skip
