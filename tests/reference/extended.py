"""Write the ``[[reference]]`` tables of catalog/extended/*.toml anew; nothing of hjsolve is used.

    python -m tests.reference.extended [id …]

H is written down by hand below, entry by entry. Periods, actions and turning points are closed forms or tanh-sinh
quadratures, states closed forms, matrix exponentials (linear systems) or Taylor series of Hamilton's equations.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sympy
from mpmath import mp, mpf

from tests.reference.closed_forms import Values, _cycle, _turns
from tests.reference.mechanics import number
from tests.reference.taylor import Flow

FOLDER = Path(__file__).resolve().parents[2] / "catalog" / "extended"
MARKER = "# Reference values below this line are written by tests/reference/extended.py; see catalog/README.md.\n"
DIGITS, TIMES = 40, ("0.7", "-1.3", "6.1")
TAYLOR = "Taylor series of Hamilton's equations of the H written down by hand, local error 1e-55"
QUADRATURE = "tanh-sinh quadrature over x = a*sin(f), doubled precision"
Numbers = Mapping[str, mpf]


@dataclass(frozen=True)
class Data:
    """One motion: parameters, q and p (or q̇ where the file gives velocities) as numbers."""

    entry: str
    name: str
    par: Numbers
    q: Numbers
    given: Numbers
    momenta: bool


def motions(entry: str) -> Iterator[Data]:
    """Every motion of one entry."""
    table = tomllib.loads((FOLDER / f"{entry}.toml").read_text(encoding="utf-8"))
    for name, data in {"default": table["initial"], **table.get("motions", {})}.items():
        par = {x["name"]: number(x["value"]) for x in table.get("parameters", [])}
        par |= {n: number(x) for n, x in data.get("parameters", {}).items()}
        key = "p" if "p" in data else "velocity"
        q, given = ({n: number(x) for n, x in data[part].items()} for part in ("q", key))
        yield Data(entry, name, par, q, given, key == "p")


# ------------------------------------------------------------------------------------------------ oscillators in a frame
def _oscillator(name: str, m: mpf, k: mpf, centre: mpf, d: Data) -> tuple[Values, Any]:
    """mẍ = −k(x − centre)."""
    ω, x, v = mp.sqrt(k / m), d.q[name] - centre, d.given[name]
    a2 = x**2 + v**2 / ω**2
    a = mp.sqrt(a2)
    values = _cycle(name, ω, m * ω * a2 / 2, "omega = sqrt(k/m), J = m*omega*a^2/2")
    values |= _turns(name, centre - a, centre + a, "centre -+ a, a^2 = x^2 + v^2/omega^2")

    def at(t: mpf) -> tuple[mpf, mpf]:
        place = x * mp.cos(ω * t) + v / ω * mp.sin(ω * t)
        return centre + place, m * (v * mp.cos(ω * t) - x * ω * mp.sin(ω * t))

    return values, at


def spring_moving_anchor(d: Data) -> tuple[Values, Any]:
    values, at = _oscillator("Q", d.par["m"], d.par["k"], mpf(0), d)
    return values, lambda t: dict(zip(("q.Q", "p.Q"), at(t), strict=True))


def oscillator_drifting_gauge(d: Data) -> tuple[Values, Any]:
    values, at = _oscillator("Q", d.par["m"], d.par["k"], -d.par["m"] / d.par["k"], d)
    return values, lambda t: dict(zip(("q.Q", "p.Q"), at(t), strict=True))


def spring_turning_anchor(d: Data) -> tuple[Values, Any]:
    (one, first), (two, second) = (_oscillator(n, d.par["m"], d.par["k"], mpf(0), d) for n in ("X", "Y"))
    return one | two, lambda t: dict(zip(("q.X", "p.X", "q.Y", "p.Y"), (*first(t), *second(t)), strict=True))


def linear_hamiltonian(d: Data) -> tuple[Values, Any]:
    q, p = d.q["q"], d.given["q"]
    values: Values = {"constant.E": (q + p, "q + p at the start")}
    return values, lambda t: {"q.q": q + t, "p.q": p - t}


# ------------------------------------------------------------------------------------------------ linear gyroscopic
def _linear(d: Data, M: Any, G: Any, K: Any) -> tuple[Values, Any]:
    """T = ½ q̇ᵀMq̇ + q̇ᵀGq, V = ½ qᵀKq: H = ½ (p − Gq)ᵀM⁻¹(p − Gq) + ½ qᵀKq and z(t) = exp(JSt) z(0)."""
    M, G, K = (mp.matrix(x) for x in (M, G, K))
    n, W = M.rows, mp.matrix(M) ** -1
    S = mp.matrix(2 * n)
    blocks = {(0, 0): G.T * W * G + K, (0, n): -(G.T * W), (n, 0): -(W * G), (n, n): W}
    for (row, column), block in blocks.items():
        for i in range(n):
            for j in range(n):
                S[row + i, column + j] = block[i, j]
    A = mp.matrix(2 * n)
    for i in range(n):
        for j in range(2 * n):
            A[i, j], A[n + i, j] = S[n + i, j], -S[i, j]
    q, v = mp.matrix(list(d.q.values())), mp.matrix(list(d.given.values()))
    start = mp.matrix([*q, *(M * v + G * q)])
    names = [*(f"q.{x}" for x in d.q), *(f"p.{x}" for x in d.q)]
    return {}, lambda t: dict(zip(names, mp.expm(A * t) * start, strict=True))


def gyroscopic_pair(d: Data) -> tuple[Values, Any]:
    k = d.par
    return _linear(d, [[2, 1], [1, 4]], [[0, k["gamma"]], [0, 0]], [[k["k11"], k["k12"]], [k["k12"], k["k22"]]])


def gyroscopic_three(d: Data) -> tuple[Values, Any]:
    m, k, γ = (d.par[n] for n in ("m", "k", "gamma"))
    M, G = [[m, 0, 0], [0, m, 0], [0, 0, m]], [[0, 0, 0], [0, 0, γ], [0, 0, 0]]
    return _linear(d, M, G, [[2 * k, -k / 2, 0], [-k / 2, -k, 0], [0, 0, -k]])


# ------------------------------------------------------------------------------------------------ relativity
def _relativistic(d: Data, square: str, potential: str, weights: Mapping[str, mpf], field: Mapping[str, mpf]) -> Any:
    """p(0) = mγ g q̇ + a, and the flow of H = c√(m²c² + square) + V by Taylor series."""
    m, c = d.par["m0"], d.par["c"]
    γ = 1 / mp.sqrt(1 - mp.fsum(weights[n] * v**2 for n, v in d.given.items()) / c**2)
    p = {n: m * γ * weights[n] * v + field.get(n, 0) for n, v in d.given.items()}
    H = sympy.sympify(f"c*sqrt(m0**2*c**2 + {square}) + {potential}")
    symbols = [sympy.Symbol(n) for n in d.q], [sympy.Symbol(f"p_{n}") for n in d.q]
    values = {sympy.Symbol(n): v for n, v in d.par.items()}
    E = mp.mpf(sympy.N(H.subs(values | {sympy.Symbol(n): v for n, v in d.q.items()}
                              | {sympy.Symbol(f"p_{n}"): v for n, v in p.items()}), mp.dps))  # fmt: skip
    names = [*(f"q.{x}" for x in d.q), *(f"p.{x}" for x in d.q)]

    def at(t: mpf) -> dict[str, mpf]:
        flow = Flow(H, *symbols, values, [*d.q.values(), *p.values()], digits=mp.dps - 15)
        return dict(zip(names, flow.at(t), strict=True))

    return p, E, at


def _mean(integrand: Callable[[mpf], mpf], low: mpf, high: mpf) -> mpf:
    """(1/π)∫ over a libration, x = mid − half·cos f."""
    mid, half = (low + high) / 2, (high - low) / 2
    return mp.quad(lambda f: integrand(mid - half * mp.cos(f)) * half * mp.sin(f), mp.linspace(0, mp.pi, 5)) / mp.pi


def relativistic_oscillator(d: Data) -> tuple[Values, Any]:
    m, k, c = (d.par[n] for n in ("m0", "k", "c"))
    _, E, at = _relativistic(d, "p_x**2", "k*x**2/2", {"x": mp.one}, {})
    a = mp.sqrt(2 * (E - m * c**2) / k)
    η2 = k * a**2 / (4 * m * c**2)
    # P7-15: a quarter of the period; p = m*c*sqrt((2*n^2*cos^2 f + 1)^2 - 1), x = a*sin f
    quarter = mp.quad(lambda f: (1 + 2 * η2 * mp.cos(f) ** 2) / mp.sqrt(1 + η2 * mp.cos(f) ** 2),
                      mp.linspace(0, mp.pi / 2, 5)) * mp.sqrt(m / k)  # fmt: skip
    momentum = lambda f: 2 * m * c * mp.sqrt(η2) * mp.cos(f) * mp.sqrt(1 + η2 * mp.cos(f) ** 2)  # noqa: E731
    action = 2 * a / mp.pi * mp.quad(lambda f: momentum(f) * mp.cos(f), mp.linspace(0, mp.pi / 2, 5))
    values = _cycle("x", mp.pi / (2 * quarter), action, f"Greenwood P7-15, {QUADRATURE}")
    return values | _turns("x", -a, a, "a^2 = 2*(E - m0*c^2)/k"), at


def constant_proper_acceleration(d: Data) -> tuple[Values, Any]:
    m, g, c = (d.par[n] for n in ("m0", "g", "c"))
    p, E, _ = _relativistic(d, "p_x**2", "-m0*g*x", {"x": mp.one}, {})
    values: Values = {"turning_point.x.lower": ((m * c**2 - E) / (m * g), "E = m0*c^2 - m0*g*x")}

    def at(t: mpf) -> dict[str, mpf]:
        momentum = p["x"] + m * g * t
        return {"q.x": (mp.sqrt(m**2 * c**4 + c**2 * momentum**2) - E) / (m * g), "p.x": momentum}

    return values, at


def relativistic_kepler(d: Data) -> tuple[Values, Any]:
    m, k, c = (d.par[n] for n in ("m0", "k", "c"))
    p, E, at = _relativistic(d, "p_r**2 + p_theta**2/r**2", "-k/r", {"r": mp.one, "theta": d.q["r"] ** 2}, {})
    L = abs(p["theta"])
    # p_r^2 = (E^2/c^2 - m^2 c^2) + 2 E k/(c^2 r) - (L^2 - k^2/c^2)/r^2
    A, B, C = E**2 / c**2 - m**2 * c**2, E * k / c**2, L**2 - k**2 / c**2
    roots = sorted((-B + s * mp.sqrt(B**2 + A * C)) / A for s in (1, -1))
    if A > 0:
        return {"turning_point.r.lower": (roots[1], "roots of a quadratic in r")}, at
    s = mp.sqrt(C)
    J = B / mp.sqrt(-A) - s
    u = (k / c) / (J + s)
    slope = m * c**2 * (1 + u**2) ** mp.mpf("-1.5") * u**2 / (J + s)
    how = "Sommerfeld: E = m0*c^2/sqrt(1 + (k/c)^2/(J + sqrt(L^2 - (k/c)^2))^2), differentiated"
    values = _cycle("r", slope, J, how) | _turns("r", *roots, "roots of a quadratic in r")
    return values | _cycle("theta", mp.sign(p["theta"]) * slope * L / s, p["theta"], how), at


def relativistic_isotropic(d: Data) -> tuple[Values, Any]:
    m, k, c = (d.par[n] for n in ("m0", "k", "c"))
    p, E, at = _relativistic(d, "p_r**2 + p_theta**2/r**2", "k*r**2/2", {"r": mp.one, "theta": d.q["r"] ** 2}, {})
    L = p["theta"]
    # with s = r^2: s*p_r^2 = s*((E - k s/2)^2/c^2 - m^2 c^2) - L^2, a cubic
    coefficients = [k**2 / (4 * c**2), -E * k / c**2, E**2 / c**2 - m**2 * c**2, -(L**2)]
    s1, s2, s3 = sorted(mp.re(z) for z in mp.polyroots(coefficients, maxsteps=300, extraprec=300))

    def rest(s: mpf) -> mpf:
        return mp.sqrt(coefficients[0] * (s3 - s))

    # dr/p_r = ds/(2 sqrt(s p_r^2)); s = mid - half*cos f
    mid, half = (s1 + s2) / 2, (s2 - s1) / 2

    def mean(g: Callable[[mpf], mpf]) -> mpf:
        return mp.quad(lambda f: g(mid - half * mp.cos(f)), mp.linspace(0, mp.pi, 5)) / mp.pi

    J = mean(lambda s: (s - s1) * (s2 - s) * rest(s) / (2 * s))
    in_E = mean(lambda s: (E - k * s / 2) / (c**2 * 2 * rest(s)))
    in_L = mean(lambda s: -L / (s * 2 * rest(s)))
    how = f"roots of a cubic in r^2; {QUADRATURE.replace('x = a*sin(f)', 'r^2 = mid - half*cos(f)')}"
    values = _cycle("r", 1 / in_E, J, how) | _turns("r", mp.sqrt(s1), mp.sqrt(s2), "roots of a cubic in r^2")
    return values | _cycle("theta", -in_L / in_E, L, how), at


def relativistic_crossed_fields(d: Data) -> tuple[Values, Any]:
    m, B, F, c = (d.par[n] for n in ("m0", "eB", "eF", "c"))
    weights, field = {"x": mp.one, "y": mp.one}, {"y": B * d.q["x"]}
    p, E, at = _relativistic(d, "p_x**2 + (p_y - eB*x)**2", "-eF*x", weights, field)
    # p_x^2 = -A x^2 + 2 b x - C
    A, b, C = B**2 - F**2 / c**2, E * F / c**2 + p["y"] * B, m**2 * c**2 + p["y"] ** 2 - E**2 / c**2
    root = mp.sqrt(b**2 - A * C)
    rate = A ** mp.mpf("1.5") / (b * F / c**2 + A * E / c**2)  # 1/(dJ/dE), J = (b^2 - A C)/(2 A^(3/2))
    how = "J = (b^2 - A*C)/(2*A^(3/2)) of p_x^2 = -A*x^2 + 2*b*x - C, and its derivative by E"
    values = _cycle("x", rate, root**2 / (2 * A ** mp.mpf("1.5")), how)
    return values | _turns("x", (b - root) / A, (b + root) / A, "roots of a quadratic in x"), at


FORMS: dict[str, Callable[[Data], tuple[Values, Any]]] = {
    "spring-moving-anchor": spring_moving_anchor, "oscillator-drifting-gauge": oscillator_drifting_gauge,
    "spring-turning-anchor": spring_turning_anchor, "hamiltonian-q-plus-p": linear_hamiltonian,
    "gyroscopic-pair": gyroscopic_pair, "gyroscopic-three": gyroscopic_three,
    "relativistic-oscillator": relativistic_oscillator, "constant-proper-acceleration": constant_proper_acceleration,
    "relativistic-kepler": relativistic_kepler, "relativistic-isotropic-oscillator": relativistic_isotropic,
    "relativistic-crossed-fields": relativistic_crossed_fields,
}  # fmt: skip
_STATES = {
    "gyroscopic-pair": "matrix exponential of the linear equations", "constant-proper-acceleration": "closed form",
    "gyroscopic-three": "matrix exponential of the linear equations", "hamiltonian-q-plus-p": "closed form",
    "spring-moving-anchor": "closed form", "oscillator-drifting-gauge": "closed form",
    "spring-turning-anchor": "closed form",
}  # fmt: skip
ANGLES = frozenset({"q.theta"})


def block(quantity: str, at: str, value: mpf, how: str) -> str:
    """One [[reference]] table."""
    text = mp.nstr(value, DIGITS, strip_zeros=True)
    return f'\n[[reference]]\nquantity = "{quantity}"\nat = {{{at}}}\nvalue = "{text}"\nhow = "{how}"\n'


def tables(entry: str) -> str:
    """All [[reference]] tables of one entry; a state near its own zero is left out."""
    text = ""
    for data in motions(entry):
        values, at = FORMS[entry](data)
        for quantity, (value, how) in values.items():
            text += block(quantity, f'motion = "{data.name}"', value, how)
        for t in TIMES:
            for quantity, value in at(number(t)).items():
                if quantity in ANGLES:
                    value -= 2 * mp.pi * mp.ceil((value - mp.pi) / (2 * mp.pi))
                if abs(value) > mp.mpf("0.05"):
                    text += block(quantity, f'motion = "{data.name}", t = "{t}"', value, _STATES.get(entry, TAYLOR))
    return text


def main(entries: list[str]) -> None:
    """Rewrite the reference tables of the entries named, or of all."""
    mp.dps = 70
    for entry in entries or sorted(FORMS):
        path = FOLDER / f"{entry}.toml"
        head = path.read_text(encoding="utf-8").split(MARKER)[0].rstrip("\n") + "\n\n"
        path.write_text(head + MARKER + tables(entry), encoding="utf-8")
        sys.stdout.write(f"{entry}: {path.read_text(encoding='utf-8').count('[[reference]]')} values\n")


if __name__ == "__main__":
    main(sys.argv[1:])
