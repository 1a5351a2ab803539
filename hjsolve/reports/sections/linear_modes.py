"""The section about a linear system with gyroscopic terms: exponents, energies of the modes, stability, one motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from hjsolve.arithmetic.number_types import Mpc, Mpf
from hjsolve.arithmetic.printed_digits import shortest
from hjsolve.errors import InvalidInputError
from hjsolve.extended.gyroscopic import LAMBDA, LinearModes
from hjsolve.extended.stability_limit import StableRange, stability_ranges
from hjsolve.mechanics.system import linear_terms
from hjsolve.precision import mp
from hjsolve.reports.document import Block, Formula, Inline, Mathematics, Number, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.from_sympy import box, falling_powers
from hjsolve.reports.formulas.layout import Box, Glyph, row
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.sections.prose import listed

_DIGITS, _TIMES = 10, (0, 1, 2, 3, 4)


def linear_modes_section(modes: LinearModes, initial: Mapping[str, object] | None = None) -> Section:
    """Write down the modes of a linear system.

    Args:
        modes: of the system, with numbers.
        initial: initial data of a motion, with ``q`` and ``velocity`` or ``p``; None for no table of it.
    """
    coordinates = [c.name for c in modes.system.coordinates]
    λ = sp.Symbol("lambda")
    characteristic = sp.Eq(falling_powers(sp.Poly(modes.polynomial.subs(LAMBDA, λ), λ)), 0, evaluate=False)
    values = [(name_box(s.name), v) for s, v in modes.values.items() if s in modes.polynomial.free_symbols]
    blocks: list[Block] = [
        Paragraph((
            "T and V are of second degree with constant coefficients, so the equations of motion are linear. The "
            "exponents of e^(λt) are the roots of the characteristic equation",
        )),
        Formula(box(characteristic), str(characteristic), "Greenwood (3-118)"),
        _exponents(modes, coordinates, values),
        Paragraph(_stability(modes)),
    ]  # fmt: skip
    if modes.signs and modes.matrix is not None:
        blocks.append(Paragraph(("A linear symplectic map makes every mode an oscillator of its own:",)))
        blocks.append(_normal_form(modes))
    blocks += _limits(modes)
    if initial is not None and {"q"} < initial.keys() <= {"q", "velocity", "p"}:
        blocks.append(_motion(modes, initial, coordinates))
    return Section("linear-modes", "Its modes", tuple(blocks))


def _exponents(modes: LinearModes, coordinates: list[str], values: list[tuple[Box, sp.Expr]]) -> Table:
    """Each λ once, with what it means and the amplitudes of the other coordinates over that of the first."""
    rows, signs = list[tuple[Text, ...]](), dict(zip(modes.frequencies, modes.signs, strict=True))
    others = coordinates[1:]
    counted: list[Mpf | Mpc] = []
    for λ, ratio in zip(modes.exponents[::2], modes.ratios[::2], strict=True):
        near = [μ for μ in counted if abs(μ - λ) <= abs(λ) * 1e-15]
        counted.append(λ)
        if near:
            continue
        times = sum(abs(μ - λ) <= abs(λ) * 1e-15 for μ in modes.exponents[::2])
        amplitudes: tuple[Text, ...] = tuple((_complex(ratio[n]) if ratio else "–",) for n in others)
        sign: Text = ("±" if λ != 0 else "", _complex(λ))
        rows.append((sign, (str(times),), (_meaning(λ, signs),), *amplitudes))
    named: list[Inline] = []
    for k, (letter, value) in enumerate(values):
        named += [", " if k else "Exponents at ", Mathematics(row(letter, Glyph("=", "operator"), box(value)))]
    header: list[Text] = [("Exponent",), ("Pairs",), ("Motion",)]
    header += [(Mathematics(row(name_box(n), Glyph("/"), name_box(coordinates[0]))),) for n in others]
    caption = "".join(plain(x.box) if isinstance(x, Mathematics) else str(x) for x in named) or "Exponents"
    return Table(tuple(header), tuple(rows), caption)


def _meaning(λ: Mpf | Mpc, signs: Mapping[Mpf, int]) -> str:
    if λ == 0:
        return "drift, or rest"
    if abs(λ.real) > abs(λ) * 1e-15:
        return "growth and decay" if abs(λ.imag) <= abs(λ) * 1e-15 else "spiral outward and inward"
    ω = abs(λ.imag)
    here = {sign for w, sign in signs.items() if abs(w - ω) <= ω * 1e-15}
    energy = {1: ", positive energy", -1: ", negative energy"}.get(here.pop(), "") if len(here) == 1 else ""
    return f"oscillation{energy}"


def _verdict(modes: LinearModes) -> str:
    if modes.stable:
        return "Every motion stays bounded: it is stable."
    if modes.signs and modes.drifts:
        return "Nothing grows exponentially, but it drifts: an exponent is 0."
    if not modes.complete and all(abs(λ.real) <= abs(λ) * 1e-15 for λ in modes.exponents):
        return "All exponents are imaginary, but a repeated one has too few modes, so that some motion grows with t."
    return "Some motion grows exponentially: it is not stable."


def _stability(modes: LinearModes) -> Text:
    words = _verdict(modes)
    if modes.stable and -1 in modes.signs:
        words += (
            " Modes of negative energy are kept stable by the gyroscopic terms alone; friction would make them grow."
        )
    repeated = len(modes.frequencies) > len({round(float(w), 12) for w in modes.frequencies})
    if modes.stable and repeated:
        words += " A repeated exponent has as many modes as it has roots, so that no factor t occurs."
    return (words,)


def _normal_form(modes: LinearModes) -> Formula:
    terms: list[Box] = [Glyph("H"), Glyph("=", "operator")]
    source = []
    for k, sign in enumerate(modes.signs, start=1):
        symbol = sp.Symbol(f"omega_{k}")
        Q, P = sp.Symbol(f"Q{k}"), sp.Symbol(f"P{k}")
        mode = sign * symbol * (Q**2 + P**2) / 2
        source.append(mode)
    total = sp.Add(*source, evaluate=False)
    return Formula(row(*terms, box(total)), str(total), "Greenwood (6-334)")


def _limits(modes: LinearModes) -> list[Block]:
    """Return the ranges of each parameter of the linear terms in which it is stable."""
    held = {s for a in linear_terms(modes.system) for s in sp.sympify(a).free_symbols}
    rows: list[tuple[Text, ...]] = []
    for parameter in modes.system.parameters:
        if parameter.symbol not in held:
            continue
        try:
            found = stability_ranges(modes, parameter.name)
        except InvalidInputError:
            continue
        rows += [(listed([parameter.name]), _ends(r), ("stable" if r.stable else "not stable",)) for r in found]
    if not rows:
        return []
    return [Table((("Parameter",), ("Range",), ("Motion",)), tuple(rows), "Stability, the other parameters as above")]


def _ends(found: StableRange) -> Text:
    low, high = (
        "−∞" if end == -sp.oo else "∞" if end == sp.oo else shortest(mp.mpf(sp.N(end, 20)), _DIGITS)
        for end in (found.lower, found.upper)
    )
    return (f"{low} to {high}",)


def _motion(modes: LinearModes, initial: Mapping[str, Any], coordinates: list[str]) -> Table:
    given = {key: value for key, value in initial.items() if key in ("q", "velocity", "p")}
    state = modes.motion(**given).at(list(_TIMES))
    header: tuple[Text, ...] = (("t",), *((Mathematics(name_box(n)),) for n in coordinates))
    rows: tuple[tuple[Text, ...], ...] = tuple(
        ((str(t),), *((Number(shortest(state.q[n][k], _DIGITS)),) for n in coordinates)) for k, t in enumerate(_TIMES)
    )
    return Table(header, rows, "The motion, to ten digits")


def _complex(value: Any) -> str:
    """Return a complex number with ten digits, the part that is rounding left out."""
    parts = [value.real, value.imag]
    real, imag = (0 if abs(x) <= abs(value) * 1e-15 else x for x in parts)
    if imag == 0:
        return shortest(real, _DIGITS).replace("-", "−") if real != 0 else "0"
    words = f"{shortest(abs(imag), _DIGITS)} i"
    if real == 0:
        return words if imag > 0 else f"−{words}"
    return f"{shortest(real, _DIGITS).replace('-', '−')} {'+' if imag > 0 else '−'} {words}"
