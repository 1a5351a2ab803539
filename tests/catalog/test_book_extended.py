"""The extended rows of Greenwood's table: explicit time undone by a frame, linear gyroscopic systems, H(q, p); modes."""

import functools
from typing import Any

import pytest
import sympy as sp
from mpmath import mp

from hjsolve import catalog, frames
from hjsolve.extended.gyroscopic import LAMBDA, LinearModes, gyroscopic_modes
from tests.support import entries
from tests.support.book import RESULTS, H_of, Mechanics, Result, bracket, exact, formula, mechanics, off, plain, result

S = sp.Symbol
DIGITS_PRINTED = 2e-3
"""The book prints three digits of these numbers."""


@functools.cache
def framed(name: str) -> Any:
    return frames.load(name)


# ------------------------------------------------------------------------------------------------ frames and gauges
@result("C26b", "(2-92), (2-93) with r0 = 0")
def turning_anchor_equations():
    """m*r'' - m*r*theta'^2 - m*a*w^2*cos(theta - w*t) + k*r = 0 and m*r^2*theta'' + ... = 0 from L in x, y."""
    original = framed("spring-turning-anchor").original
    L = plain(original.kinetic - original.potential)
    polar = Mechanics("0", "0", ["r", "theta"])
    places = {"x": polar.of("r*cos(theta)"), "y": polar.of("r*sin(theta)")}
    polar.L = L.xreplace({S(n): f for n, f in places.items()} | {S(f"{n}_d"): polar.rate(f) for n, f in places.items()})
    radial = polar.of("m*r_dd - m*r*theta_d**2 - m*a*w**2*cos(theta - w*t) + k*r")
    angular = polar.of("m*r**2*theta_dd + 2*m*r*r_d*theta_d + m*a*w**2*r*sin(theta - w*t)")
    return exact(polar.equation("r") - radial, polar.equation("theta") - angular)


@result("C26b", "Ex 2-5 with r0 = 0, motion")
def turning_anchor_motion():
    """x = A*cos(wt) + a free oscillation, A = m*a*w^2/(k - m*w^2); y likewise with sin(wt)."""
    state = framed("spring-turning-anchor").motion(q={"x": "0.3", "y": "1"}, velocity={"x": "0.4", "y": 0}).at(3)
    A, n, time = mp.mpf("0.5") / 3, mp.mpf(2), mp.mpf(3)
    x = A * mp.cos(time) + (mp.mpf("0.3") - A) * mp.cos(n * time) + mp.mpf("0.2") * mp.sin(n * time)
    y = A * mp.sin(time) + mp.cos(n * time) - A / n * mp.sin(n * time)
    return max(off(state.q["x"], x), off(state.q["y"], y))


@result("C82", "Ex 6-9")
def moving_anchor_equations():
    """q' = p/m, p' = k*(t - q) from H = p^2/2m + k*(t - q)^2/2."""
    H = H_of(framed("spring-moving-anchor").original)
    book = formula("p_q**2/(2*m) + k*(t - q)**2/2")
    return exact(H - book, H.diff(S("p_q")) - formula("p_q/m"), -H.diff(S("q")) - formula("k*(t - q)"))


@result("C82", "Ex 6-9, extended phase space")
def moving_anchor_extended():
    """Q = p, P = -q, T = p_t, P_T = -t is canonical: lambda*(p_t + H) = lambda*(T + Q^2/2m + k*(P - P_T)^2/2)."""
    q, time, p, p_t, lam = (S(n) for n in ("q", "t", "p_q", "p_t", "lam"))
    augmented = lam * (p_t + H_of(framed("spring-moving-anchor").original))
    old = {"Q": p, "P": -q, "T": p_t, "P_T": -time}
    new = lam * formula("T + Q**2/(2*m) + k*(P - P_T)**2/2").xreplace({S(n): f for n, f in old.items()})
    pairs = [("q", "p_q"), ("t", "p_t")]
    unit = [bracket(old["Q"], old["P"], pairs) - 1, bracket(old["T"], old["P_T"], pairs) - 1]
    return exact(new - augmented, *unit, bracket(old["Q"], old["P_T"], pairs), bracket(old["T"], old["P"], pairs))


@result("C82", "Ex 6-9, motion")
def moving_anchor_motion():
    """q = t + free oscillation of q - t with sqrt(k/m)."""
    given = {"q": {"q": "0.3"}, "velocity": {"q": "-0.4"}, "parameters": {"m": 2, "k": 3}}
    state = framed("spring-moving-anchor").motion(**given).at(5)
    n, time = mp.sqrt(mp.mpf(3) / 2), mp.mpf(5)
    return off(state.q["q"], time + mp.mpf("0.3") * mp.cos(n * time) - mp.mpf("1.4") / n * mp.sin(n * time))


@result("C88", "P6-13")
def drifting_gauge():
    """H = p^2/2m - t*p + k*q^2/2, and by F2 = (P + m*t)*q K = P^2/2m + k*q^2/2 + m*q."""
    frame = framed("oscillator-drifting-gauge")
    H, K = H_of(frame.original), H_of(frame.system)
    F2 = formula("(P + m*t)*q")
    moved = H.subs(S("p_q"), F2.diff(S("q"))) + F2.diff(S("t"))
    return exact(
        H - formula("p_q**2/(2*m) - t*p_q + k*q**2/2"),
        K - formula("p_Q**2/(2*m) + k*Q**2/2 + m*Q"),
        moved - K.subs({S("Q"): S("q"), S("p_Q"): S("P")}) + formula("m*t**2/2"),  # K is free to a function of t (6-20)
        F2.diff(S("P")) - S("q"),
    )


@result("C88", "P6-13, extended phase space")
def drifting_gauge_extended():
    """Q = t, T = q, P = p_t, P_T = p: lambda*(p_t + H) = lambda*(P + P_T^2/2m - Q*P_T + k*T^2/2)."""
    lam = S("lam")
    augmented = lam * (S("p_t") + H_of(framed("oscillator-drifting-gauge").original))
    new = augmented.xreplace({S("t"): S("Q"), S("q"): S("T"), S("p_t"): S("P"), S("p_q"): S("P_T")})
    return exact(new - lam * formula("P + P_T**2/(2*m) - Q*P_T + k*T**2/2"))


@result("C88", "P6-13, motion")
def drifting_gauge_motion():
    """m*q'' + k*q = -m: q = -m/k + free oscillation."""
    state = framed("oscillator-drifting-gauge").motion(q={"q": "0.3"}, velocity={"q": "0.4"}).at(2)
    return off(state.q["q"], -1 + mp.mpf("1.3") * mp.cos(2) + mp.mpf("0.4") * mp.sin(2))


# ------------------------------------------------------------------------------------------------ gyroscopic systems
CASES: dict[int, dict[str, Any]] = {
    1: {"gamma": 1, "k11": 1, "k12": -1, "k22": 8}, 2: {"gamma": 7, "k11": -1, "k12": 1, "k22": -8},
    3: {"gamma": 7, "k11": -1, "k12": 1, "k22": 8},
}  # fmt: skip


def pair(case: int, **change: Any) -> LinearModes:
    return gyroscopic_modes(catalog.load("gyroscopic-pair"), parameters={**CASES[case], **change})


@result("C51", "Ex 3-4, case 1", DIGITS_PRINTED)
def gyroscopic_first_case():
    """gamma = 1: lambda = +-0.583i, +-1.716i with A2/A1 = 0.202 + 0.0877i, -1.043 - 0.453i."""
    modes = pair(1)
    assert modes.stable
    return worst_of(modes, {0: ("0.583", 0.202 + 0.0877j), 1: ("1.716", -1.043 - 0.453j)})


@result("C51", "Ex 3-4, case 2", DIGITS_PRINTED)
def gyroscopic_second_case():
    """gamma = 7: lambda = +-0.529i, +-1.891i with A2/A1 = 0.0790 - 0.406i, -0.1155 - 0.594i."""
    return worst_of(pair(2), {0: ("0.529", 0.0790 - 0.406j), 1: ("1.891", -0.1155 - 0.594j)})


def worst_of(modes: LinearModes, expected: dict[int, tuple[str, complex]]) -> Any:
    worst = mp.zero
    for k, (root, ratio) in expected.items():
        worst = max(worst, off(modes.frequencies[k], root), off(modes.exponents[2 * k].imag, root))
        worst = max(worst, abs(complex(modes.ratios[2 * k]["q2"]) - ratio) / abs(ratio))
    return worst


@result("C51", "Ex 3-4, case 2, stability")
def gyroscopic_second_case_is_stabilised():
    """Stable exactly for gamma^2 > 36: the biquadratic's discriminant and middle coefficient."""
    λ2, γ = S("z"), S("gamma", real=True)
    polynomial = plain_polynomial(2).subs(plain(LAMBDA) ** 2, λ2)
    a, b, c = sp.Poly(polynomial.subs(S("gamma"), γ), λ2).all_coeffs()
    assert c > 0
    bounds = sp.solveset(b**2 - 4 * a * c, γ, sp.S.Reals)
    real = {x for x in bounds if b.subs(γ, x) > 0}
    for value, stable in ((5, False), (7, True), (-7, True)):
        assert pair(2, gamma=value).stable == stable
    return exact(*(x**2 - 36 for x in real), len(real) - 2)


@result("C51", "Ex 3-4, case 3")
def gyroscopic_third_case_is_unstable():
    """7*lambda^4 + (10 + gamma^2)*lambda^2 - 9 = 0: one root lambda^2 > 0 whatever gamma."""
    z, γ = S("z"), S("gamma")
    polynomial = plain_polynomial(3)
    assert not pair(3, gamma=1000).stable
    return exact(polynomial.subs(plain(LAMBDA) ** 2, z) - (7 * z**2 + (10 + γ**2) * z - 9))


def plain_polynomial(case: int) -> sp.Expr:
    modes = pair(case)
    values = {S(n): v for n, v in CASES[case].items() if n != "gamma"}
    return sp.expand(plain(modes.polynomial).subs(values))


@result("C51", "(3-129)")
def gyroscopic_criterion():
    """Stable iff |k| > 0 and m11*k22 + m22*k11 - 2m12*k12 + gamma^2 > 2*sqrt(|m|*|k|): the roots lambda^2 are negative."""
    m11, m12, m22, k11, k12, k22, γ, z = sp.symbols("m11 m12 m22 k11 k12 k22 gamma z")
    square = sp.Matrix([[m11 * z + k11, m12 * z + k12], [m12 * z + k12, m22 * z + k22]])
    polynomial = sp.expand(square.det() + γ**2 * z)
    a, b, c = m11 * m22 - m12**2, m11 * k22 + m22 * k11 - 2 * m12 * k12 + γ**2, k11 * k22 - k12**2
    own = plain(pair(1).polynomial).subs(plain(LAMBDA) ** 2, z)
    numbers = {m11: 2, m12: 1, m22: 4, **{S(n): S(n) for n in ("k11", "k12", "k22", "gamma")}}
    return exact(
        polynomial - (a * z**2 + b * z + c), sp.expand(own.subs(S("lambda") ** 2, z) - polynomial.subs(numbers))
    )


@result("C62", "P3-10")
def three_coordinates():
    """gamma^2 = 5mk: lambda^2 = -k/2m, -3k/2m, -3k/m."""
    modes = gyroscopic_modes(catalog.load("gyroscopic-three"), parameters={"m": 2, "k": 3, "gamma": "sqrt(30)"})
    assert modes.stable
    squares = sorted(mp.mpf(w) ** 2 for w in modes.frequencies)
    return off(squares, [mp.mpf(3) / 4, mp.mpf(9) / 4, mp.mpf(9) / 2])


@result("C62", "P3-11", 1e-5)
def three_coordinates_threshold():
    """Stable for gamma^2 > 4.490*m*k: where two roots of the cubic in lambda^2 meet."""
    z, γ2 = S("z"), S("g2")
    modes = gyroscopic_modes(catalog.load("gyroscopic-three"))
    cubic = plain(modes.polynomial).subs({S("m"): 1, S("k"): 1}).subs(S("gamma"), sp.sqrt(γ2))
    cubic = sp.expand(sp.expand(cubic).subs(plain(LAMBDA), sp.sqrt(z)))
    meetings = [sp.re(x) for x in sp.Poly(sp.discriminant(cubic, z), γ2).nroots(n=30) if abs(sp.im(x)) < 1e-20]
    limit = max(meetings)
    for shift, stable in ((sp.Rational(1, 10**6), True), (-sp.Rational(1, 10**6), False)):
        value = sp.sqrt(sp.Rational(str(limit)) + shift)
        assert gyroscopic_modes(catalog.load("gyroscopic-three"), parameters={"gamma": value}).stable == stable
    return off(limit, "4.49004")


# ------------------------------------------------------------------------------------------------ H(q, p)
@result("C74", "P5-1")
def linear_hamiltonian():
    """S = -E*t + E*q - q^2/2 solves the Hamilton-Jacobi equation of H = q + p; q = t - b, p = E - q."""
    problem = catalog.hamiltonian("hamiltonian-q-plus-p")
    assert problem is not None
    S_ours, E, q, time = plain(problem.principal_function), S("E"), S("q"), S("t")
    H = plain(problem.hamiltonian)
    return exact(
        S_ours - (-E * time + E * q - q**2 / 2),
        S_ours.diff(time) + H.subs(S("p_q"), S_ours.diff(q)),
        S_ours.diff(E) - (q - time),
        plain(problem.momentum) - (E - q),
        H - (S("p_q") + q),
    )


@result("C74", "P5-1, motion")
def linear_hamiltonian_motion():
    """q = q0 + t, p = p0 - t."""
    entry = entries.described("hamiltonian-q-plus-p")
    assert entry.hamiltonian is not None
    assert entry.initial is not None
    state = entry.hamiltonian.motion(**entry.initial.arguments).at("2.25")
    return max(off(state.q["q"], "2.75"), off(state.p["q"], "-1.25"))


# ------------------------------------------------------------------------------------------------ shapes of modes
SHAPES = {
    ("C43b", "P2-13(b)", "tube-pendulum-small"): {"u1": {"theta": "1", "phi": "0"}, "u2": {"theta": "1", "phi": "-3"}},
    ("C45", "P2-15", "particles-on-elastic-rod"): {
        "u1": {"y1": "1", "y2": "1", "y3": "1"}, "u2": {"y1": "1", "y2": "0", "y3": "-1"},
        "u3": {"y1": "1", "y2": "-2", "y3": "1"}},
}  # fmt: skip
for (row, place, name), shapes in SHAPES.items():

    @result(row, f"{place}, shapes")
    def shape_of_modes(name=name, shapes=shapes):
        """The amplitudes of the normal modes have the ratios of the book."""
        stated, own = entries.described(name).stated, mechanics(name)
        assert stated is not None
        residuals = []
        for mode, amplitudes in shapes.items():
            columns = {q: own.of(stated.map[q]).diff(S(mode)) for q in amplitudes}
            first = next(iter(amplitudes))
            residuals += [columns[q] - sp.Rational(a) * columns[first] for q, a in amplitudes.items()]
            assert columns[first] != 0
        return exact(*residuals)


@result("C44", "P2-14, shapes")
def decoupled_springs():
    """A_y/A_x = 0 and infinity: x and y are the normal modes themselves."""
    own = mechanics("springs-planar")
    return exact(own.L.diff(S("x"), S("y")), own.L.diff(S("x_d"), S("y_d")))


@result("C52", "Ex 3-5, fast top")
def fast_top():
    """The slow precession of a fast top is -m*g*l/(I_a*Omega), to first order in 1/Omega."""
    h = S("h", positive=True)  # 1/p_phi, p_phi = I_a*Omega
    inner = formula("I_t*m*g*l*sin(theta)")
    slow = -(1 / h) / (2 * formula("I_t*sin(theta)")) * (1 - sp.sqrt(1 - 4 * inner * h**2))
    return exact(sp.limit(slow / h, h, 0) + formula("m*g*l"))


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
