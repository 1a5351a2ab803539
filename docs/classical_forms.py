"""Print docs/classical-forms.md: one line for each classical system, derived from the catalog, next to the book's.

python docs/classical_forms.py > docs/classical-forms.md
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.latex import latex_of

LONGEST = 40
"""Operations of a definition that is written next to its formula."""


@dataclass(frozen=True)
class Line:
    """A system of the page.

    Attributes:
        title: its name.
        entry: of the catalog.
        names: of the forms that are shown.
        book: the formula of a book, as LaTeX, and where it stands; empty where none is compared.
    """

    title: str
    entry: str
    names: tuple[str, ...]
    book: str = ""


LINES = (
    Line("Kepler problem", "kepler-planar", ("orbit.r", "anomaly.r", "anomaly.t", "anomaly.theta", "energy"),
         r"$r = p/(1 + e\cos(\theta - \theta_0))$, $n(t - t_0) = \xi - e\sin\xi$ (Goldstein 3.55, 3.76)"),
    Line("Harmonic oscillator", "harmonic-oscillator", ("inverse.x", "energy"), r"$E = \omega J$ (Greenwood Ex. 5-1)"),
    Line("Isotropic oscillator", "isotropic-oscillator-polar", ("inverse.r", "inverse.theta", "energy")),
    Line("Free particle", "free-particle-polar", ("inverse.r", "inverse.theta")),
    Line("Projectile", "projectile", ("inverse.x", "inverse.y")),
    Line("Morse", "morse", ("inverse.x", "energy")),
    Line("Pöschl and Teller", "poeschl-teller", ("inverse.x", "energy")),
    Line("Pendulum", "pendulum", ("inverse.theta", "periods.theta"),
         r"$\sin\tfrac12\theta = k\,\mathrm{sn}(\omega t, k)$ (Whittaker § 44)"),
    Line("Double well", "double-well", ("inverse.x", "periods.x")),
    Line("Spherical pendulum", "spherical-pendulum", ("inverse.theta", "inverse.phi", "time_law"),
         r"$\cos\theta = x_3 - (x_3 - x_2)\,\mathrm{sn}^2$ (Whittaker § 55)"),
    Line("Lagrange's top", "lagrange-top", ("inverse.theta", "inverse.psi")),
    Line("Geodesics of a sphere", "sphere-geodesics", ("inverse.theta", "orbit_equations.p_phi"),
         r"$\phi - \phi_0 = \arcsin(\cot\theta/\cot\theta_m)$"),
    Line("Isochrone", "isochrone", ("anomaly.r", "anomaly.t", "energy")),
    Line("Bead on a cone", "cone", ("anomaly.r", "anomaly.t", "anomaly.phi")),
    Line("Stark's problem", "stark", ("parametric.u", "parametric.v", "parametric.t")),
    Line("Kepler problem, parabolic coordinates", "kepler-parabolic", ("parametric.u", "parametric.v", "energy")),
)  # fmt: skip


def form_of(entry: str) -> RegimeForms:
    """Return the forms of an entry's own motion.

    Args:
        entry: of the catalog.
    """
    motion = hjsolve.solve(entry).motion(**next(iter(hjsolve.catalog.describe(entry).motions.values())).arguments)
    form = own_form(motion, seconds=None)
    assert form is not None
    return form


def _latex(expression: sp.Basic) -> str:
    return latex_of(box(expression))


def _left(name: str) -> str:
    group, _, q = name.partition(".")
    written = _latex(sp.Symbol(q)) if q else ""
    if group == "anomaly":
        return rf"{written}(\xi)"
    if group == "parametric":
        return rf"{written}(\tau)"
    if group == "periods":
        return f"T_{{{written}}}"
    if group == "energy":
        return "E"
    return f"{written}(t)" if group == "inverse" else written


def written(line: Line) -> str:
    """Return the line as MyST text.

    Args:
        line: of the page.
    """
    form = form_of(line.entry)
    text = [f"## {line.title}\n"]
    for name in line.names:
        value = form.named()[name]
        if name == "time_law":
            formula = f"{_latex(form.time_law.lhs)} = {_latex(value)}"  # type: ignore[union-attr]
        elif name.startswith("orbit_equations"):
            formula = f"{_latex(form.orbit_equations[name.partition('.')[2]].lhs)} = {_latex(value)}"
        else:
            formula = f"{_left(name)} = {_latex(value)}"
        text.append(f"$$\n{formula}\n$$\n")
    held = {s for name in line.names for s in form.named()[name].free_symbols}
    where = needed_names(held, form.where)[0]
    short = [f"${_latex(s)} = {_latex(e)}$" for s, e in where.items()
             if not isinstance(e, tuple) and sp.count_ops(e) <= LONGEST]  # fmt: skip
    polynomials: dict[sp.Poly, list[tuple[int, sp.Symbol]]] = {}
    for s, e in where.items():
        if isinstance(e, tuple):
            polynomials.setdefault(e[0], []).append((e[1], s))
    if short:
        text.append(f"with {', '.join(short)}.\n")
    for polynomial, roots in polynomials.items():
        names = " < ".join(_latex(symbol) for _, symbol in sorted(roots, key=lambda one: one[0]))
        text.append(f"${names}$ are real roots of ${_latex(polynomial.as_expr())}$, counted upwards from 1.\n")
    kinds = ", ".join(f"${_latex(sp.Symbol(q))}$: {kind}" for q, kind in form.regime.kinds.items())
    relations = ", ".join(f"${_latex(relation)}$" for relation in form.regime.relations)
    text.append(f"Regime: {'; '.join(filter(None, (kinds, relations)))}. Entry `{line.entry}`.\n")
    if line.book:
        text.append(f"Book: {line.book}.\n")
    return "\n".join(text)


def page() -> str:
    """Return the whole page."""
    head = (
        "# Closed forms of classical systems\n\n"
        "Printed by `python docs/classical_forms.py` from the catalog. Each form is derived, differentiated back and\n"
        "compared with the quadrature to 40 digits. The last argument of K, E, F, Π, sn, cn, dn and am is the\n"
        "parameter $m = k^2$, the square of the modulus. At the lower limit $q_0$ the momentum is positive.\n"
    )
    return "\n".join([head, *map(written, LINES)])


if __name__ == "__main__":
    print(page())
