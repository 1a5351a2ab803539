"""Greenwood chapter 5: Hamilton-Jacobi theory; the worked systems of its text and problems."""

import pytest
import sympy as sp
from mpmath import mp

from hjsolve import catalog
from hjsolve.separation import separate
from tests.support.book import (
    RESULTS,
    H_of,
    Result,
    exact,
    formula,
    mechanics,
    motion,
    off,
    plain,
    result,
    solution,
    start,
)

S = sp.Symbol


@result("C75", "P5-3")
def rolling_disk():
    """t = (1/(g*sin))*sqrt(3/m)*(sqrt(E + m*g*r*theta*sin) - sqrt(E)); theta = theta0'*t + g*sin*t^2/(3r)."""
    run = start("disk-on-slope", {"theta": 0}, {"theta": "0.4"})
    slope, E, time = mp.sin(mp.mpf("0.3")), mp.mpf(float(run.constants["E"].value)), mp.mpf(3)
    θ = mp.mpf("0.4") * time + slope * time**2 / 3
    law = mp.sqrt(3) / slope * (mp.sqrt(E + θ * slope) - mp.sqrt(E))
    return max(
        off(run.at(3).q["theta"], θ), off(float(run.time_at("theta", mp.nstr(θ, 30)).value), law), off(float(law), time)
    )


OSCILLATOR = {"q": {"r": "1.2", "theta": 0}, "velocity": {"r": 0, "theta": "0.6"}}


@result("C76", "P5-5, r(t)")
def oscillator_distance():
    """r(t) = sqrt(E/k + sqrt(E^2 - k*L^2/m)*cos(2*sqrt(k/m)*t)/k), starting at r_max."""
    run = start("isotropic-oscillator-polar", **OSCILLATOR, m=1, k=1)
    E, L = (mp.mpf(float(run.constants[n].value)) for n in ("E", "p_theta"))
    return max(
        off(run.at(str(t)).q["r"], mp.sqrt(E + mp.sqrt(E**2 - L**2) * mp.cos(2 * mp.mpf(str(t)))))
        for t in ("0.4", "1.3", "5.1")
    )


@result("C76", "P5-5, r(theta)")
def oscillator_orbit():
    """r(theta) = (L/sqrt(m))*(E - sqrt(E^2 - k*L^2/m)*cos(2*theta))^(-1/2)."""
    run = start("isotropic-oscillator-polar", **OSCILLATOR, m=1, k=1)
    E, L = (mp.mpf(float(run.constants[n].value)) for n in ("E", "p_theta"))
    worst = mp.zero
    for t in ("0.4", "1.3", "5.1"):
        state = run.at(t)
        θ = mp.mpf(float(state.q["theta"]))
        worst = max(worst, off(state.q["r"], L / mp.sqrt(E - mp.sqrt(E**2 - L**2) * mp.cos(2 * θ))))
    return worst


@result("C76", "P5-5, quadratures")
def oscillator_quadratures():
    """t = integral of -m*d(r^2)/(2*sqrt(-L^2 + 2mE*r^2 - mk*r^4)), theta = integral of -L*d(r^2)/(2r^2*sqrt(...))."""
    run = start("isotropic-oscillator-polar", **OSCILLATOR, m=1, k=1)
    E, L = (mp.mpf(float(run.constants[n].value)) for n in ("E", "p_theta"))
    a, b = run.at("0.3"), run.at("0.9")
    u, v = (mp.mpf(float(s.q["r"])) ** 2 for s in (a, b))
    root = lambda x: mp.sqrt(-(L**2) + 2 * E * x - x**2)  # noqa: E731
    return max(
        off(0.6, mp.quad(lambda x: -1 / (2 * root(x)), [u, v])),
        off(float(b.q["theta"]) - float(a.q["theta"]), mp.quad(lambda x: -L / (2 * x * root(x)), [u, v])),
    )


@result("C77", "P5-6", 1e-11)
def hyperbola():
    """(q1 + sqrt(q1^2 + a^2))/(q2 + sqrt(q2^2 - b^2)) is constant along the path, on each branch."""
    run = motion("liouville-p5-6")
    E, K = mp.mpf(float(run.constants["E"].value)), mp.one
    begin = run.at(0)
    q, p = ({n: mp.mpf(float(x[n])) for n in ("q1", "q2")} for x in (begin.q, begin.p))
    a2, b2 = (p["q1"] ** 2 - 2 * E * q["q1"] ** 2) / (2 * E), (2 * E * q["q2"] ** 2 - p["q2"] ** 2) / (2 * E)
    assert a2 > 0
    assert b2 > 0
    values = []
    for t in ("0", "0.4", "1.7", "5.0"):
        state = run.at(t)
        x, y, px, py = (mp.mpf(float(z)) for z in (state.q["q1"], state.q["q2"], state.p["q1"], state.p["q2"]))
        values.append((mp.asinh(x / mp.sqrt(a2)) * mp.sign(px), mp.acosh(abs(y) / mp.sqrt(b2)) * mp.sign(py * y)))
    values = [u - v for u, v in values]
    assert K == 1
    return max(abs(v - values[0]) / abs(values[0]) for v in values)


@result("C78", "P5-8")
def spherical_quadratures():
    """W1' = sqrt(2mE - 2a/r^2 - 2v1), W2' = sqrt(2a - 2b/sin^2 - 2v2), W3' = sqrt(2b - 2v3), up to naming the
    constants."""
    found = solution("spherical-staeckel")
    F = {n: plain(x) for n, x in found.momentum_squared.items()}
    a, b = (plain(found.constants[n].symbol) for n in ("alpha_2", "alpha_3"))
    book = {
        "r": "2*m*E - 2*A/r**2 + 2*m*k/r",
        "theta": "2*A - 2*B/sin(theta)**2 - 2*m*b*cos(theta)",
        "phi": "2*B - 2*m*c*(1 - cos(phi))",
    }
    A = sp.solve(F["r"] - formula(book["r"]), S("A"))[0]
    B = sp.solve(F["phi"] - formula(book["phi"]), S("B"))[0]
    assert (A.free_symbols | B.free_symbols) & {a, b}
    return exact(*(F[n] - formula(text).xreplace({S("A"): A, S("B"): B}) for n, text in book.items()))


@result("C78", "P5-8, (5-152)")
def spherical_matrix():
    """Phi_ij = p_i*dp_i/dalpha_j."""
    found = solution("spherical-staeckel")
    stackel = found.separation.stackel
    constants = [c.symbol for c in found.constants.values()]
    return exact(
        *(
            found.momentum_squared[name].diff(α) / 2 - stackel.matrix[i, j]
            for i, name in enumerate(stackel.coordinates)
            for j, α in enumerate(constants)
        )
    )


@result("C79", "Ex 5-3, (5-167)-(5-169)")
def kepler_staeckel():
    """c = (1, 1/r^2, 1/(r^2*sin^2)), Phi of (5-168) with nonlinear constants: c*Phi = (1, 0, 0), |Phi| =
    a_theta*a_phi."""
    c = sp.Matrix([[formula(x) for x in ("1", "1/r**2", "1/(r**2*sin(theta)**2)")]])
    rows = [["1", "-at/r**2", "0"], ["0", "at", "-ap/sin(theta)**2"], ["0", "0", "ap"]]
    matrix = sp.Matrix([[formula(x) for x in row] for row in rows])
    own = separate(catalog.load("kepler-spherical")).stackel
    ours = sp.Matrix([plain(x) for x in own.inverse_metric]).T.subs(S("m"), 1)
    return exact(
        c * matrix - sp.Matrix([[1, 0, 0]]),
        matrix.det() - S("at") * S("ap"),
        ours - c,
        (c * sp.Matrix([formula("-mu/r"), 0, 0]))[0] - formula("-mu/r"),
    )


@result("C79", "Ex 5-3, (5-175)-(5-180)")
def kepler_reduced():
    """n = 2: Liouville after ignoring phi with f_r = r^2, R_r = r^2, R_theta = 1, v_r = -mu*r, v_theta =
    a_phi^2/(2*sin^2)."""
    f, v = formula("r**2"), formula("-mu*r + p_phi**2/(2*sin(theta)**2)")
    H = H_of("kepler-spherical").subs({S("m"): 1, S("k"): S("mu")})
    book = (S("r") ** 2 * S("p_r") ** 2 + S("p_theta") ** 2) / (2 * f) + v / f
    assert separate(catalog.load("kepler-spherical")).reduced.liouville is not None
    assert separate(catalog.load("kepler-spherical")).liouville is None
    return exact(H - book)


@result("C79", "(5-153), item 71")
def kepler_constants_stay_out_of_psi():
    """With the squared constants (5-153) still gives c*psi = V, but psi then holds them: ours are linear."""
    found = solution("kepler-spherical")
    stackel = found.separation.stackel
    assert not any(x.free_symbols & {c.symbol for c in found.constants.values()} for x in stackel.column)
    L2 = found.momentum_squared["r"].diff(found.constants["alpha_2"].symbol, 2)
    return exact(L2)


@result("C30", "P5-9")
def liouville_is_staeckel():
    """psi_i = v_i/R_i, Phi_ij = p_i*dp_i/dalpha_j with the first constant eliminated: c*Phi = (1, 0, 0)."""
    f = [formula(x) for x in ("q1**2", "q2**2", "1")]
    R, v = [1, 2, 1], [formula(x) for x in ("q1**4", "q2**2", "a**2*q3**2/2")]
    c = sp.Matrix([[r / sum(f) for r in R]])
    matrix = sp.Matrix([[f[0] / R[0], -1, -1], [f[1] / R[1], sp.Rational(1, 2), 0], [f[2] / R[2], 0, 1]])
    psi = sp.Matrix([x / r for x, r in zip(v, R, strict=True)])
    own = mechanics("liouville-three")
    return exact(c * matrix - sp.Matrix([[1, 0, 0]]), (c * psi)[0] - own.V)


@result("C77", "P5-11")
def staeckel_is_liouville_for_two():
    """R1 = 1/Phi12, R2 = -1/Phi22, f1 = Phi11/Phi12, f2 = -Phi21/Phi22, v1 = psi1/Phi12, v2 = -psi2/Phi22 give
    H again."""
    stackel = separate(catalog.load("liouville-p5-6")).stackel
    Φ, ψ = stackel.matrix.applyfunc(plain), [plain(x) for x in stackel.column]
    R, f = (1 / Φ[0, 1], -1 / Φ[1, 1]), (Φ[0, 0] / Φ[0, 1], -Φ[1, 0] / Φ[1, 1])
    v = (ψ[0] / Φ[0, 1], -ψ[1] / Φ[1, 1])
    H = (R[0] * S("p_q1") ** 2 + R[1] * S("p_q2") ** 2) / (2 * sum(f)) + sum(v) / sum(f)
    return exact(H - H_of("liouville-p5-6"))


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
