"""The tables of the catalog as mechanics: H(q, p) from T and V with sympy alone, numbers as mpf; nothing of hjsolve."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import sympy
from mpmath import mp, mpf

CATALOG = Path(__file__).resolve().parents[2] / "catalog" / "systems"


@functools.cache
def table(entry: str) -> Mapping[str, Any]:
    """The TOML table of an entry."""
    return tomllib.loads((CATALOG / f"{entry}.toml").read_text(encoding="utf-8"))


def number(text: str) -> mpf:
    """The value of an exact text such as ``1.2`` or ``pi/3``."""
    return mp.mpf(sympy.N(sympy.sympify(text, rational=True), mp.dps + 10))


def symbolic(entry: str, text: str) -> sympy.Expr:
    """A formula of an entry; ``dot(q)`` becomes the symbol ``v_q``; every name of the entry is a plain symbol."""
    names = [x["name"] for key in ("coordinates", "parameters") for x in table(entry).get(key, [])]
    own = {n: sympy.Symbol(n) for n in names}
    formula = sympy.sympify(text.replace("dot(", "v_("), locals=own, rational=True)
    return formula.xreplace({sympy.Function("v_")(own[n]): sympy.Symbol(f"v_{n}") for n in names})


@functools.cache
def kinetic_and_potential(entry: str) -> tuple[sympy.Expr, sympy.Expr]:
    """T(q, v) and V(q)."""
    return symbolic(entry, table(entry)["kinetic"]), symbolic(entry, table(entry).get("potential", "0"))


@functools.cache
def hamiltonian(entry: str) -> sympy.Expr:
    """H(q, p) = (p − a)ᵀ M⁻¹ (p − a)/2 − T₀ + V for T = T₂ + T₁ + T₀ (Greenwood (4-109)–(4-112))."""
    kinetic, potential = kinetic_and_potential(entry)
    names = [c["name"] for c in table(entry)["coordinates"]]
    v, p = (sympy.Matrix([sympy.Symbol(prefix + n) for n in names]) for prefix in ("v_", "p_"))
    rest = dict.fromkeys(v, sympy.Integer(0))
    mass, linear = sympy.hessian(kinetic, list(v)), sympy.Matrix([kinetic.diff(x).subs(rest) for x in v])
    shifted, inverse = (
        p - linear,
        mass.inv().applyfunc(lambda x: sympy.factor(sympy.trigsimp(x)) if len(names) > 1 else x),
    )
    return (shifted.T * inverse * shifted)[0] / 2 - kinetic.subs(rest) + potential


def velocities(entry: str) -> dict[str, sympy.Expr]:
    """q̇ = ∂H/∂p by name."""
    H = hamiltonian(entry)
    return {c["name"]: H.diff(sympy.Symbol(f"p_{c['name']}")) for c in table(entry)["coordinates"]}
