"""Prose of the symbolic half turned into text with formulas: ``p_theta`` becomes p with index θ."""

from __future__ import annotations

import re
from collections.abc import Collection

from hjsolve.extended.one_freedom import LinearInMomentum
from hjsolve.mechanics.system import Domain, System
from hjsolve.reports.document import Block, Code, Formula, Inline, Mathematics, Paragraph, Text
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import Box, Fence, Fraction, Glyph, Script, row
from hjsolve.reports.formulas.names import GREEK, name_box
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.sections.inside_text import formulas, typeset_name

_SPELLED = (
    ("Staeckel", "Stäckel"),
    ("V' = V - T0", "V′ = V − T₀"),
    ("T2 - T0 + V", "T₂ − T₀ + V"),
    ("T2 + V", "T₂ + V"),
)


def _pair(letter: str) -> Box:
    return Script(Glyph(letter), _indices("ij"))


def _indices(letters: str) -> Box:
    """Return indices side by side, each a letter of its own: a name of two letters would be set upright."""
    return row(*map(Glyph, letters))


def _transposed(column: str, *result: Box) -> Box:
    return row(Script(Glyph("c"), sup=Glyph("T", "text")), Glyph(column), Glyph("=", "operator"), *result)


def first_unit_vector() -> Box:
    """Return (1, 0, …, 0)."""
    comma, zero = Glyph(",", "operator"), Glyph("0", "number")
    return Fence(row(Glyph("1", "number"), comma, zero, comma, Glyph("…", "operator"), comma, zero))


def _liouville_sums() -> tuple[Inline, ...]:
    i, sums, two = Glyph("i"), Glyph("∑", "operator"), Glyph("2", "number")
    f, R, v = (Script(Glyph(letter), i) for letter in "fRv")
    kinetic = Fraction(row(sums, R, Script(Glyph("p"), i, two)), row(two, sums, f))
    return (
        Mathematics(row(Glyph("T"), Glyph("=", "operator"), kinetic)), " and ",
        Mathematics(row(Glyph("V"), Glyph("=", "operator"), Fraction(row(sums, v), row(sums, f)))),
    )  # fmt: skip


def _conditions() -> dict[str, Box]:
    """Return the conditions of Levi-Civita, as they are tested.

    S_ij(f) = ∂ᵢ∂ⱼf − (∂ᵢ ln gʲʲ) ∂ⱼf − (∂ⱼ ln gⁱⁱ) ∂ᵢf;  L_ij = Hⁱ Hʲ H_ij + Hᵢ Hⱼ Hⁱʲ − Hⁱ Hⱼ H_iʲ − Hᵢ Hʲ H_jⁱ.
    """
    equals, plus, minus, d = (Glyph(x, "operator") for x in ("=", "+", "−", "∂"))

    def H(sub: str = "", sup: str = "") -> Box:
        return Script(Glyph("H"), _indices(sub) if sub else None, _indices(sup) if sup else None)

    def slope(i: str, *of: Box) -> Box:
        return row(Script(d, Glyph(i)), *of)

    f, ln = Glyph("f"), Glyph("ln ", "text")
    g = {i: Script(Glyph("g"), sup=_indices(i * 2)) for i in "ij"}
    curvature = row(
        _pair("S"), Fence(f), equals, slope("i"), slope("j", f), minus, Fence(slope("i", ln, g["j"])), slope("j", f),
        minus, Fence(slope("j", ln, g["i"])), slope("i", f),
    )  # fmt: skip
    general = row(
        _pair("L"), equals, H(sup="i"), H(sup="j"), H(sub="ij"), plus, H(sub="i"), H(sub="j"), H(sup="ij"), minus,
        H(sup="i"), H(sub="j"), H(sub="i", sup="j"), minus, H(sub="i"), H(sup="j"), H(sub="j", sup="i"),
    )  # fmt: skip
    return {"S_ij": curvature, "L_ij": general}


def condition_formulas(text: str) -> tuple[Block, ...]:
    """Write out the conditions of Levi-Civita that an argument speaks of."""
    written = {
        "S_ij": "S_ij(f) = d_i d_j f - (d_i ln g^jj) d_j f - (d_j ln g^ii) d_i f",
        "L_ij": "L_ij = H^i H^j H_ij + H_i H_j H^ij - H^i H_j H_i^j - H_i H^j H_j^i",
    }
    found: list[Block] = [Formula(shape, written[name]) for name, shape in _conditions().items() if name in text]
    if found:
        words = "Upper indices of H are derivatives by momenta, lower ones by coordinates." if "L_ij" in text else ""
        found.insert(0, Paragraph(("Written out:",)))
        found += [Paragraph((words,))] if words else []
    return tuple(found)


_TYPESET: dict[str, tuple[Inline, ...]] = {
    "c^T Phi = (1, 0, ..., 0)": (Mathematics(_transposed("Φ", first_unit_vector())),),
    "c^T psi = V_eff": (Mathematics(_transposed("ψ", name_box("V_eff"))),),
    "c^T psi = V": (Mathematics(_transposed("ψ", Glyph("V"))),),
    "S_ij(g^hh)": (Mathematics(row(_pair("S"), Fence(Script(Glyph("g"), sup=_indices("hh"))))),),
    "S_ij(V)": (Mathematics(row(_pair("S"), Fence(Glyph("V")))),),
    "S_ij": (Mathematics(_pair("S")),),
    "L_ij": (Mathematics(_pair("L")),),
    "Row i depends on coordinate i": (
        "Row ", Mathematics(Glyph("i")), " depends on coordinate ", Mathematics(Glyph("i")),
    ),
    "T = sum(R_i p_i^2)/(2 sum f_i), V = sum(v_i)/sum(f_i)": _liouville_sums(),
}  # fmt: skip
_PHRASE = re.compile("(" + "|".join(map(re.escape, _TYPESET)) + ")")
"""What the symbolic half writes in ASCII, and how it is set."""
_WORDS_OF_ONE_LETTER = "aAI"


def typeset_prose(text: str, system: System | LinearInMomentum) -> Text:
    """Set the names and the plain formulas of a sentence as mathematics.

    Args:
        system: whose names they are.
    """
    return with_names(text, {c.name for c in system.coordinates} | {p.name for p in system.parameters})


def with_names(text: str, names: Collection[str]) -> Text:
    """Set names and plain formulas of a sentence as mathematics.

    Args:
        names: what is a name in it; single letters and Greek ones in formulas are names anyway.
    """
    for ascii_form, better in _SPELLED:
        text = text.replace(ascii_form, better)
    pieces: list[Inline] = []
    for k, part in enumerate(_PHRASE.split(text)):
        pieces += _TYPESET[part] if k % 2 else _with_names(part, names)
    return tuple(pieces)


def _with_names(text: str, names: Collection[str]) -> Text:
    """Set names and formulas; what stands between backticks is something to type."""
    pieces: list[Inline] = []
    for k, part in enumerate(text.split("`")):
        pieces += [Code(part)] if k % 2 else _without_code(part, names)
    return tuple(pieces)


def _without_code(text: str, names: Collection[str]) -> Text:
    pieces: list[Inline] = []
    for piece in formulas(text, names):
        if not isinstance(piece, str):
            pieces.append(piece)
            continue
        for i, part in enumerate(re.split(r"(hjsolve\.\w+|normal_modes|gyroscopic_modes|find_coordinates)", piece)):
            pieces += [Code(part)] if i % 2 else _named(part, names) if part else []
    return tuple(pieces)


def heading(title: str, names: Collection[str] = ()) -> str:
    """Write a title, whose plain formulas are set as text: ``T = m*dot(q)^2/2`` as T = m q̇²/2.

    Args:
        title: as given.
        names: what is a name in it.
    """
    pieces = with_names(title, names)
    return "".join(plain(p.box) if isinstance(p, Mathematics) else str(p) for p in pieces)


def _named(text: str, names: Collection[str]) -> list[Inline]:
    """Words with the names that cannot be meant as words set as mathematics."""
    letters = {n for n in names if len(n) == 1 and n not in _WORDS_OF_ONE_LETTER} | {"T", "V", "W", "H", "E"}
    telling = {n for n in names if n in GREEK or re.fullmatch(r"[A-Za-z]+\d+", n)} | {f"p_{n}" for n in names}
    spelled_names = "|".join(re.escape(n) for n in sorted(names, key=len, reverse=True))
    telling |= {f"dot({n})" for n in names} | {f"alpha_{i}" for i in range(2, 10)}
    spelled = rf"(?:{'|'.join(sorted(GREEK.keys() - {'iota', 'lam', 'lamda'}, key=len, reverse=True))})(?:_?\d+)?"
    indexed = [rf"[A-Z](?:_(?:{spelled_names}))+"] if names else []
    indexed.append(r"[A-Za-z]_(?:\d|[a-z])[a-z0-9]*")
    pattern = "|".join([*(re.escape(n) for n in sorted(telling, key=len, reverse=True)), spelled, *indexed])
    apart, after = r"(?<![\d’'-] )(?<![’'*/^(-])(?<![A-Z]\. )", r"(?![’'*/^(-]|\.\w|\. [A-Z]\.)"  # 5 m, d'Alembert
    alone = f"{apart}[{''.join(sorted(letters))}]{after}"
    pieces = re.split(rf"(?<![\w.])({pattern}|{alone})(?!\w)", text)
    return [Mathematics(typeset_name(p, names)) if i % 2 else typeset(p) for i, p in enumerate(pieces) if p]


def domain_text(domain: Domain, name: str) -> Text:
    """Say where a coordinate may go.

    Returns:
        Such as "0 < r" or "angle, period 2π".
    """
    if domain.kind == "angle":
        return ("angle, period ", Mathematics(row(Glyph("2", "number"), Glyph("π"))))
    less, infinity = Glyph("<", "operator"), Glyph("∞", "number")
    parts: list[Box] = [name_box(name)]
    if domain.lower is not None or domain.kind == "line":
        parts = [*([Glyph("−", "operator"), infinity] if domain.lower is None else [box(domain.lower)]), less, *parts]
    if domain.upper is not None or domain.kind == "line":
        parts = [*parts, less, infinity if domain.upper is None else box(domain.upper)]
    return (Mathematics(row(*parts)),)


def listed(names: tuple[str, ...] | list[str], word: str = "and") -> Text:
    """Enumerate names: q₁, q₂ and q₃.

    Args:
        names: at least one name.
        word: the word before the last.

    Returns:
        The enumeration in pieces.
    """
    pieces: list[Inline] = []
    for i, name in enumerate(names):
        if i:
            pieces.append(f" {word} " if i == len(names) - 1 else ", ")
        pieces.append(Mathematics(name_box(name)))
    return tuple(pieces)


def typeset(text: str) -> str:
    """Write the plain powers and products of units and remarks properly: ``kg*m^2/s^2`` as kg·m²/s²."""
    raised = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
    text = re.sub(r"(?:\^|\*\*)(?:\((-?\d+)\)|(-?\d+)(?![\w.]))", lambda m: (m[1] or m[2]).translate(raised), text)
    text = re.sub(r"(?<=[=(,] )-(?=\w)|(?<=[=(])-(?=\w)|(?<=\b\w )-(?= \w\b)", "−", text)
    return re.sub(r"(?<=[\w²³⁰¹⁴⁵⁶⁷⁸⁹)])\*(?=[\w(])", "·", text)
