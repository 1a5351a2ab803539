"""Names as a physicist writes them: Greek letters, indices, a dot for a velocity."""

from __future__ import annotations

import re
from keyword import iskeyword

from hjsolve.reports.formulas.layout import Box, Dotted, Glyph, Script, row

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "varepsilon": "ε", "zeta": "ζ", "eta": "η",
    "theta": "θ", "iota": "ι", "kappa": "κ", "lambda": "λ", "lamda": "λ", "lam": "λ", "mu": "μ", "nu": "ν", "xi": "ξ",
    "omicron": "ο", "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ", "upsilon": "υ", "phi": "φ", "varphi": "φ",
    "chi": "χ", "psi": "ψ", "omega": "ω", "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π",
    "Sigma": "Σ", "Upsilon": "Υ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
LATEX_SIGNS = {
    **{letter: f"\\{name}" for name, letter in GREEK.items() if name not in {"lamda", "lam"}},
    "ο": "o", "−": "-", "⋅": r"\cdot", "×": r"\times", "∑": r"\sum", "∫": r"\int", "∮": r"\oint", "∂": r"\partial",
    "±": r"\pm", "∓": r"\mp", "≤": r"\le", "≥": r"\ge", "≠": r"\ne", "≈": r"\approx", "→": r"\to", "∞": r"\infty",
    "√": r"\surd", "…": r"\dots", "ℰ": r"\mathcal{E}",
}  # fmt: skip
"""A letter or sign → what LaTeX writes for it in mathematics mode."""
RAISED = dict(zip("0123456789−-+nhT", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻⁺ⁿʰᵀ", strict=True))
LOWERED = dict(zip("0123456789aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ", strict=True))
"""A letter → its form as an index above or below the line, of those that Unicode has."""
FUNCTION_NAMES = {
    "log": "ln", "asin": "arcsin", "acos": "arccos", "atan": "arctan", "asinh": "arsinh", "acosh": "arcosh",
    "atanh": "artanh", "sign": "sgn", "elliptic_k": "K", "elliptic_f": "F", "elliptic_e": "E", "elliptic_pi": "Π",
    "CarlsonRF": "R_F", "CarlsonRC": "R_C", "CarlsonRD": "R_D", "CarlsonRJ": "R_J", "JacobiSN": "sn", "JacobiCN": "cn",
    "JacobiDN": "dn", "JacobiAM": "am", "JacobiEpsilon": "ℰ",
}  # fmt: skip


def name_box(name: str) -> Box:
    """Set a name the way a physicist writes it: ``p_theta1`` as p with index θ₁, ``dot(r)`` as ṙ, ``ddot(r)`` as r̈.

    Args:
        name: the name of a coordinate, parameter, velocity, momentum or constant.

    Returns:
        Its box.
    """
    if match := re.fullmatch(r"(d?d)ot\((.+)\)", name):
        return Dotted(name_box(match[2]), len(match[1]))
    if name.endswith("_") and name.strip("_"):
        bare = name.rstrip("_")
        primes = len(name) - len(bare) - iskeyword(bare)  # lambda_ is a λ that Python lets stand
        return _primed(name_box(bare), primes) if primes else name_box(bare)
    if "_" in name.strip("_"):
        base, _, index = name.strip("_").partition("_")
        if re.fullmatch(r"\d+(_\d+)*", index):  # chi_6_0 is χ₆,₀
            inner: Box = row(
                *(
                    Glyph(part, "operator" if part == "," else "number")
                    for part in re.split("(,)", index.replace("_", ","))
                )
            )
        else:
            inner = name_box(index)
        outer = name_box(base)
        if isinstance(outer, Script) and outer.sub is not None and outer.sup is None:
            return Script(outer.base, row(outer.sub, Glyph(",", "operator"), inner))
        return Script(outer, inner)
    if (match := re.fullmatch(r"([^\W\d]+)(\d+)", name)) and (len(match[1]) == 1 or match[1] in GREEK):
        return Script(name_box(match[1]), Glyph(match[2], "number"))
    return Glyph(GREEK.get(name, name), "identifier")


def _primed(inner: Box, primes: int) -> Box:
    """Write the underscores at a name's end, which tell it from another name, as primes at its letter."""
    if isinstance(inner, Script):
        return Script(_primed(inner.base, primes), inner.sub, inner.sup)
    return Glyph(f"{inner.text}{'′' * primes}", "identifier") if isinstance(inner, Glyph) else inner
