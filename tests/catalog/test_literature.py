"""Systems beyond the book against what the literature knows of them: invariants, limits, frequencies, other programs."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
import sympy as sp
from mpmath import mp

from hjsolve import catalog
from tests.support import entries
from tests.support.book import H_of, bracket, mechanics, motion, off, solution, start

FREQUENCIES: dict[tuple[str, str], Callable[[Any], Any]] = {
    # whatever the coordinates, Kepler's frequencies all are sqrt(-8 E^3/(m k^2))
    ("kepler-prolate", "xi"): lambda E: mp.sqrt(-8 * E**3),
    ("kepler-prolate", "eta"): lambda E: mp.sqrt(-8 * E**3),
    ("kepler-prolate", "phi"): lambda E: mp.sqrt(-8 * E**3),
    # Calogero (1969): 2 and 3 times the frequency of the springs, at every amplitude and every strength
    ("calogero-moser", "rho"): lambda _: mp.mpf(2),
    ("calogero-moser", "phi"): lambda _: mp.mpf(3),
}


@pytest.mark.parametrize(("entry", "coordinate"), FREQUENCIES)
def test_the_frequency_is_that_of_the_literature(entry: str, coordinate: str) -> None:
    run = motion(entry)
    expected = FREQUENCIES[entry, coordinate](number(run.constants["E"]))
    assert off(run.frequencies[coordinate].value, expected) < 1e-13


def number(estimate: Any) -> Any:
    return mp.mpf(float(estimate.value))


def test_the_kaup_case_of_henon_heiles_has_an_integral_of_fourth_degree() -> None:
    """Ravoson, Gavrilov & Caboz (1993): no coordinates, and yet an integral; (I, H) = 0."""
    H = H_of("henon-heiles-kaup")
    x, y, p, c = (sp.Symbol(n) for n in ("x", "y", "p_x", "c"))
    integral = p**4 + 2 * p**2 * x**2 * (1 + 2 * c * y) - 4 * c * p * sp.Symbol("p_y") * x**3 / 3
    integral += x**4 * (1 - 4 * c * y / 3 - 4 * c**2 * y**2 / 3) - 2 * c**2 * x**6 / 9
    assert sp.expand(bracket(integral, H, [("x", "p_x"), ("y", "p_y")])) == 0


def state_at(entry: str, t: Any, name: str = "default") -> dict[str, Any]:
    """q and q' by plain names."""
    state = motion(entry, name).at(t)
    numbers = {n: mp.mpf(float(v)) for n, v in state.q.items()}
    return numbers | {f"{n}_d": mp.mpf(float(v)) for n, v in state.velocity.items()}


def in_space(entry: str, t: Any, name: str = "default") -> tuple[list[Any], list[Any]]:
    """Cartesian place and velocity by the map that the entry states."""
    described, own = entries.described(entry), mechanics(entry)
    assert described.stated is not None
    values = {sp.Symbol(p.name): p.value for p in described.system.parameters}
    values |= {sp.Symbol(n): sp.sympify(v) for n, v in described.motions[name].parameters.items()}
    values |= {sp.Symbol(n): sp.Float(v, 17) for n, v in state_at(entry, t, name).items()}
    places = [own.of(described.stated.map[n]) for n in described.stated.coordinates]
    there, speeds = (
        [mp.mpf(sp.N(f.xreplace(values), 17)) for f in column] for column in (places, map(own.rate, places))
    )
    return there, speeds


def spread(values: list[Any]) -> Any:
    """How far numbers that should agree are apart, by the largest."""
    return (max(values) - min(values)) / max(abs(v) for v in values)


def test_neumann_keeps_the_integrals_of_uhlenbeck() -> None:
    """F_k = x_k^2 + sum of (x_k v_j - x_j v_k)^2/(a_k - a_j) is constant for each k (Moser 1980)."""
    a, found = (1, 2, 4), []
    for t in (0, 1, "5.5", 30):
        x, v = in_space("neumann", t)
        assert abs(mp.fsum(q**2 for q in x) - 1) < 1e-13
        found.append([x[k] ** 2 + mp.fsum((x[k] * v[j] - x[j] * v[k]) ** 2 / (a[k] - a[j]) for j in range(3) if j != k)
                      for k in range(3)])  # fmt: skip
    for k in range(3):
        assert spread([values[k] for values in found]) < 1e-12


@pytest.mark.parametrize(("name", "a"), [("default", (1, 2, 4)), ("other-family", (2, 3, 5))])
def test_a_geodesic_of_the_ellipsoid_keeps_the_constant_of_joachimsthal(name: str, a: tuple[int, ...]) -> None:
    """(sum of x_i^2/a_i^2)*(sum of v_i^2/a_i) is constant along a geodesic, and the place stays on the ellipsoid."""
    found = []
    for t in (0, "4.5", 20):
        x, v = in_space("triaxial-geodesics", t, name)
        assert abs(mp.fsum(q**2 / k for q, k in zip(x, a, strict=True)) - 1) < 1e-13
        first = mp.fsum(q**2 / mp.mpf(k) ** 2 for q, k in zip(x, a, strict=True))
        found.append(first * mp.fsum(u**2 / mp.mpf(k) for u, k in zip(v, a, strict=True)))
    assert spread(found) < 1e-12


def test_a_charge_and_a_pole_keep_the_total_angular_momentum() -> None:
    """Poincaré: m r x v - g*r/|r| is constant, and r^2 is a quadratic function of the time."""
    g, found = mp.mpf("0.5"), []
    v2 = mp.mpf("0.09") + mp.mpf("0.16") + (mp.sin(mp.mpf("1.1")) * mp.mpf("0.6")) ** 2
    for t in (0, 1, "4.5", 20):
        s = state_at("charge-in-monopole-field", t)
        θ, φ = s["theta"], s["phi"]
        out = mp.matrix([mp.sin(θ) * mp.cos(φ), mp.sin(θ) * mp.sin(φ), mp.cos(θ)])
        south = mp.matrix([mp.cos(θ) * mp.cos(φ), mp.cos(θ) * mp.sin(φ), -mp.sin(θ)])
        east = mp.matrix([-mp.sin(φ), mp.cos(φ), 0])
        # r x v = r^2*(theta'*east - sin(theta)*phi'*south)
        found.append(s["r"] ** 2 * (s["theta_d"] * east - mp.sin(θ) * s["phi_d"] * south) - g * out)
        assert off(s["r"] ** 2, 1 - mp.mpf("0.6") * mp.mpf(t) + v2 * mp.mpf(t) ** 2) < 1e-12
    for axis in range(3):
        assert max(abs(v[axis] - found[0][axis]) for v in found) < 1e-12


def test_one_centre_of_two_in_space_is_kepler() -> None:
    data = {"q": {"xi": "1", "eta": "1.2", "phi": "0.3"}, "velocity": {"xi": "0.1", "eta": "0.3", "phi": "0.5"}}
    run = start("two-centres-space", **data, k2=0)
    expected = mp.sqrt((-2 * number(run.constants["E"])) ** 3)
    for name in ("xi", "eta", "phi"):
        assert off(run.frequencies[name].value, expected) < 1e-12


def test_a_weak_field_parts_the_frequencies_as_the_linear_stark_effect_says() -> None:
    """E = -1/(2n^2) + (3/2)*F*n*(J_u - J_v) to first order, n = J_u + J_v + |J_phi|: the frequencies differ by 3*F*n."""
    data = {"q": {"u": "1", "v": "0.8", "phi": "0"}, "velocity": {"u": "0.1", "v": "0.2", "phi": "0.6"}}
    for F, tolerance in (("1/10000", 1e-3), ("1/1000000", 1e-5)):
        run = start("stark", **data, F=F)
        n = mp.fsum(number(run.actions[k]) for k in ("u", "v", "phi"))
        parted = number(run.frequencies["u"]) - number(run.frequencies["v"])
        assert off(parted, 3 * mp.mpf(sp.Rational(F)) * n) < tolerance


def test_the_perihelion_advances_by_darwins_elliptic_integral() -> None:
    """r = p/(1 + e*cos x): phi grows by 4*sqrt(p/(p - 6 + 2e))*K(4e/(p - 6 + 2e)) from perihelion to perihelion."""
    run = motion("schwarzschild")
    low, high = map(number, run.turning_points["r"])
    e, p = (high - low) / (high + low), 2 * high * low / (high + low)
    k2 = 4 * e / (p - 6 + 2 * e)
    expected = 4 * mp.sqrt(p / (p - 6 + 2 * e)) * mp.ellipk(k2)
    assert off(2 * mp.pi * number(run.frequencies["phi"]) / number(run.frequencies["r"]), expected) < 1e-12
    assert off(run.frequencies["theta"].value, number(run.frequencies["phi"])) < 1e-13


def test_circles_about_a_turning_hole_have_the_frequencies_of_the_literature() -> None:
    """r = 9, a = 1/2, M = 1: E and L of Bardeen, Press & Teukolsky (ApJ 178, 347); the ratios are those of epicycles."""
    r, a, root = mp.mpf(9), mp.mpf("0.5"), mp.mpf(27)
    run = solution("kerr").motion(
        q={"t": 0, "r": 9, "theta": "pi/2", "phi": 0},
        p={"t": "-43/54*sqrt(27/19)", "r": 0, "theta": 0, "phi": "313/108*sqrt(27/19)"}, parameters={"a": "1/2"},
    )  # fmt: skip
    assert dict(run.kinds) == {"t": "ignorable", "r": "equilibrium", "theta": "equilibrium", "phi": "ignorable"}
    φ = number(run.frequencies["phi"])
    assert off(number(run.frequencies["theta"]) / φ, mp.sqrt(1 - 4 * a / root + 3 * a**2 / r**2)) < 1e-13
    assert off(number(run.frequencies["r"]) / φ, mp.sqrt(1 - 6 / r + 8 * a / root - 3 * a**2 / r**2)) < 1e-13
    state = run.at(100)
    assert off(state.velocity["phi"] / state.velocity["t"], 1 / (root + a)) < 1e-13
    assert off(run.constants["E"].value, "-0.5") < 1e-14


def test_a_hole_that_does_not_turn_is_schwarzschilds() -> None:
    given = entries.described("schwarzschild").motions["default"].arguments
    run = solution("kerr").motion(**given, parameters={"a": 0})
    for name in ("r", "theta", "phi"):
        assert off(run.frequencies[name].value, number(motion("schwarzschild").frequencies[name])) < 1e-13


def test_the_node_of_a_satellite_goes_back_as_j2_says() -> None:
    """To first order in c^2 = J2*R^2 the node moves by -(3/2)*(c/p)^2*cos(i) of the mean motion."""
    data = {"q": {"rho": "1", "beta": "0.3", "phi": "0"}, "velocity": {"rho": "0.1", "beta": "0.4", "phi": "0.9"}}
    for c, tolerance in (("1/100", 1e-3), ("1/1000", 1e-5)):
        run = start("vinti", **data, c=c)
        E, h = (number(run.constants[n]) for n in ("E", "p_phi"))
        L = number(run.actions["beta"]) + h
        node = number(run.frequencies["phi"]) - number(run.frequencies["beta"])
        expected = -mp.mpf("1.5") * mp.mpf(sp.Rational(c)) ** 2 / L**4 * h / L * mp.sqrt(-8 * E**3)
        assert off(node, expected) < tolerance


def test_the_kuzmin_kutuzov_galaxy_is_that_of_the_literature() -> None:
    """V = -G*M/(sqrt(lambda) + sqrt(nu)), lambda and nu roots of s^2 - (R^2 + z^2 + a^2 + c^2)*s + a^2*c^2 + ... = 0."""
    system = catalog.load("kuzmin-kutuzov")
    values = {p.symbol: p.value for p in system.parameters} | {system.symbols["c"]: sp.Rational(1, 2)}
    V = sp.lambdify([system.symbols[n] for n in ("u", "w")], system.potential.xreplace(values), "mpmath")
    a2, c2 = mp.mpf("1.25"), mp.mpf("0.25")
    for R, z in ((mp.mpf("0.7"), mp.mpf("0.3")), (mp.mpf(2), mp.mpf("0.1")), (mp.mpf("0.2"), mp.mpf("1.5"))):
        half, product = (R**2 + z**2 + a2 + c2) / 2, a2 * c2 + c2 * R**2 + a2 * z**2
        root = mp.sqrt(half**2 - product)
        far, near = mp.hypot(R, z + 1), mp.hypot(R, z - 1)
        here = V(mp.acosh((far + near) / 2), mp.asin((far - near) / 2))
        assert off(here, -1 / (mp.sqrt(half + root) + mp.sqrt(half - root))) < 1e-13


ORBITS = {
    # a/c = 5, d = G*M = 1; u, w, p_u, p_w, p_phi as binary numbers; J_u, J_w and the frequencies of u, w, phi in ball
    # arithmetic to 55 digits from the quartic in sqrt(tau), made without hjsolve
    "disk": (("0x1.6b807d5e71c0ap-1", "-0x1.e93e9f4568598p-1", "0x1.38f0c26825bc0p-2", "-0x1.8bea34a3658d2p-2",
              "-0x1.8baabe392faa1p-3"),
             ("0.1825053745896320948390873591322", "0.5086609294637620648604056305207",
              "0.3464431563221704452622884988782", "0.2504171552145410592213490523143",
              "-0.2168685137688826712812862084146")),
    "high": (("0x1.4eee43f3f626dp+0", "-0x1.19e6ed3c5bff2p+0", "0x1.d98dd58132ad3p-3", "0x1.fb374d4531fabp-1",
              "0x1.30622eb1de02ap-2"),
             ("0.4389011285636028217610437484107", "1.05024662704169599464429121521",
              "0.09733872348994847441230833058061", "0.07996124485842962258908221964444",
              "0.07655891820917986232398319334947")),
    "wide": (("0x1.c269098fc02dap+0", "0x1.f02d915877221p-5", "0x1.73519a4ea6178p+0", "0x1.e09cf42f6dab4p-2",
              "-0x1.3394dbb412377p+0"),
             ("0.8304546798066371934078703160325", "0.05195233403459188551924610459905",
              "0.07626184806324643554042893892443", "0.09115448320240860503822015380985",
              "-0.0604613973582053948878182774788")),
}  # fmt: skip


@pytest.mark.parametrize("name", ORBITS)
def test_orbits_of_the_galaxy_agree_with_ball_arithmetic(name: str) -> None:
    given, expected = ORBITS[name]
    u, w, p_u, p_w, p_phi = (str(Fraction(float.fromhex(x))) for x in given)
    run = solution("kuzmin-kutuzov").motion(
        q={"u": u, "w": w, "phi": 0}, p={"u": p_u, "w": p_w, "phi": p_phi}, parameters={"c": "sqrt(1/24)"}
    )
    found = [run.actions["u"], run.actions["w"], *(run.frequencies[n] for n in ("u", "w", "phi"))]
    for estimate, text in zip(found, expected, strict=True):
        assert off(estimate.value, text) < 1e-13
        assert abs(number(estimate) - mp.mpf(text)) <= mp.mpf(float(estimate.error))
