"""Nothing hides between the nodes: strips of analyticity are proved, and narrow features are resolved or refused."""

from __future__ import annotations

import cmath
import math
import tracemalloc

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.arithmetic.complex_disks import Disk, Disks
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.reciprocals import without_overflow
from hjsolve.arithmetic.tape import UNARY
from hjsolve.lowering import lower
from hjsolve.one_coordinate import resolution
from hjsolve.one_coordinate.anomaly import libration_anomaly
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.regular_factor import deflated
from hjsolve.one_coordinate.strip_squares import StripSquares
from tests.support.random_features import Draw, Feature, draw, truth

pytestmark = pytest.mark.rotating_file(12)

x = sp.Symbol("x")
FORMULAS = [
    x**2 / 2 + x**4,
    1 / x - 3 / x**2 + sp.log(x),
    sp.exp(-x) * sp.sin(3 * x) / (1 + x**2),
    sp.tanh(5 * (x - 1)) / sp.cosh(4 * x) ** 2,
    sp.sqrt(1 + x**2) * sp.atan(x) - sp.asinh(x) / x,
    sp.cos(x) ** 3 / sp.sinh(x) + sp.cosh(x) / sp.exp(2 * x),
    sp.acosh(1 + x) + sp.asin(x / 9) * sp.acos(x / 9) + sp.atanh(x / 9) * sp.tan(x / 7),
]


def swinging(amplitude, digits=15):
    """The pendulum with m = g = l = 1, released at an amplitude."""
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    return solution.motion(
        q={"theta": amplitude}, velocity={"theta": 0}, parameters={"m": 1, "g": 1, "l": 1}, digits=digits
    )


def moving(potential, place, speed, digits=15, kinetic="dot(x)**2/2"):
    """A motion on a line."""
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, kinetic, potential))
    return solution.motion(q={"x": place}, velocity={"x": speed}, digits=digits)


def drawn(potential, place, speed, features):
    """A system of the kind that ``random_features`` draws, whose references are cut at the features."""
    return Draw(
        0, "own", {"x": "line"}, "dot(x)**2/2", potential, {"x": float(place)}, {"x": float(speed)},
        tuple(Feature(shape, *map(str, rest), reach) for shape, *rest, reach in features), f"2*({potential})",
    )  # fmt: skip


@pytest.mark.parametrize("name", [n for n in UNARY if n not in {"neg", "abs"}])
def test_a_disk_holds_every_value_of_a_function_and_of_its_derivatives(name):
    rng = np.random.default_rng(7)
    disks, known = Disks(), 0
    for _ in range(60):
        centre, radius = complex(*rng.normal(size=2)) * 10 ** rng.uniform(-2, 1.2), 10 ** rng.uniform(-4, 0.5)
        disk = Disk(np.array([centre]), np.array([radius]))
        with np.errstate(all="ignore"):
            found = [rule(name, disk) for rule in (disks.unary, disks.derivative, disks.bend)]
        for order, image in enumerate(found):
            if not image.known[0]:
                continue
            known += 1
            for angle, fraction in rng.uniform(0, (2 * math.pi, 1), size=(3, 2)):
                z = mp.mpc(centre + fraction * radius * cmath.exp(1j * angle))
                value = complex(mp.diff(getattr(mp, name), z, order) if order else getattr(mp, name)(z))
                tolerance = 1e-13 if not order else 1e-5
                assert abs(value - image.centre[0]) <= image.radius[0] + tolerance * (1 + abs(value))
    assert known > 60


@pytest.mark.parametrize("formula", FORMULAS, ids=str)
@pytest.mark.parametrize("span", [("1", "3"), ("1.99999999", "2.00000001"), ("2", "2.1")], ids=str)
def test_the_regular_factor_over_disks_holds_the_second_difference_in_many_digits(formula, span):
    ends = [sp.Rational(v) for v in span]
    values = [formula.subs(x, end) for end in ends]
    formula = formula - values[0] - (x - ends[0]) * (values[1] - values[0]) / (ends[1] - ends[0])
    tape = without_overflow(lower([formula], [x]))
    with mp.workdps(60):
        a, b = map(mp.mpf, span)
        f = sp.lambdify(x, formula, "mpmath")
        disks = [Disks().point(v) for v in (a, b, b - a)]
        program = deflated(tape, [], *disks)
        q0 = (a + b) / 2 + mp.mpc(0, "0.1") * (b - a)
        r = 0.05 * float(b - a)

        def regular(q):
            return f(q) / ((q - a) * (b - q))

        low, up = complex(q0 - a), complex(q0 - b)
        with np.errstate(all="ignore"):
            disk, _ = program.over(*(Disk(np.array([c]), np.array([r])) for c in (complex(q0), low, up)))
            point = program.at(*(np.array([c]) for c in (complex(q0), low, up)))
        assert np.all(disk.known)
        for angle in np.linspace(0, 6, 7):
            value = regular(q0 + r * mp.expj(angle))
            assert abs(complex(value) - disk.centre[0]) <= disk.radius[0] * (1 + 1e-9)
        exact = complex(regular(q0))
        assert abs(exact - point[0]) <= 1e-5 * abs(exact)


def to_resolve(motion):
    place = motion.separated.located["theta"]
    plain = libration_anomaly(place.lower.place(200), place.upper.place(200), None, None, Multi(200))
    return resolution.integrands_to_resolve(
        plain, place.coordinate_motion.radicand, (False,), motion.separated.parts, 200
    )


@pytest.mark.parametrize("amplitude", ["0.3", "1.5", "2.6"])
def test_a_proved_strip_ends_below_the_nearest_zero_and_not_far_below(amplitude):
    """The pendulum's p² is zero next at θ = 2π − A, where cosh Im χ = 2π/A − 1."""
    subject = to_resolve(swinging(amplitude))
    found = resolution.strip(subject, 1000)
    nearest = math.acosh(2 * math.pi / float(amplitude) - 1)
    assert 0.5 * min(nearest, 3.2) < found.width < nearest


def test_many_squares_take_no_more_memory_than_a_block_of_them():
    subject, count = to_resolve(swinging("1.5")), 8000
    squares = StripSquares(np.linspace(0.1, 3, count), np.zeros(count), np.full(count, 1e-3))
    logs, sizes = resolution._sizes(subject, squares)
    tracemalloc.start()
    again = resolution._sizes(subject, squares)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 1e7  # 4e7 all at once
    assert np.array_equal(again[0], logs)
    for part in (0, count - 1):
        alone, _ = resolution._sizes(subject, squares.chosen(slice(part, part + 1)))
        np.testing.assert_allclose(alone[:, 0], logs[:, part], rtol=1e-9, atol=0)
    assert np.all(sizes > 0)


def test_few_values_of_p_squared_are_worked_out_twice(monkeypatch):
    """The nodes are known before the first value: one set of them is worked out, in full digits."""
    costly = []
    own = MomentumSquared.value

    def value(self, q, bits):
        costly.append(bits > 300)
        return own(self, q, bits)

    monkeypatch.setattr(MomentumSquared, "value", value)
    motion = swinging("2.2", 120)
    assert sum(costly) <= 1.05 * motion.nodes + 240  # the rest: zeros of p² next to the motion, sought by doubling
    with mp.workdps(170):
        period, better = motion.periods["theta"], swinging("2.2", 160).periods["theta"]
        assert abs(period.value - better.value) <= period.error <= mp.mpf("1e-119") * period.value


NARROW = [
    ("x**2/2 - exp(-400*x**2)", 1, 2, ("Gaussian", 0, 1, 0.05, 7)),
    ("x**2/2 - 1/cosh(100*x)**2", 1, 2, ("sech2", 0, 1, 0.01, 20)),
    ("x**2/2 + exp(-2500*x**2)", 1, 2, ("Gaussian", 0, 1, 0.02, 7)),
    ("x**2/2 + exp(-400*x**2)*sin(50*x)/3", 1, 2, ("Gaussian", 0, 1, 0.02, 20)),
    ("x**2/2 - exp(-10**6*(x - 19/10)**2)", 1, 2, ("Gaussian", 1.9, 1, 0.001, 7)),
    ("(1 - exp(-x))**2 - exp(-40000*(x - 1)**2)/5", 0, 1, ("Gaussian", 1, 1, 0.005, 7)),
    ("x**4/4 + tanh(100*x)/5", 0, 1, ("step", 0, 1, 0.01, 20)),
]


@pytest.mark.rotating(4)
@pytest.mark.parametrize("digits", [15, 30])
@pytest.mark.parametrize(("potential", "place", "speed", "feature"), NARROW, ids=[case[0] for case in NARROW])
def test_a_motion_counts_what_is_narrower_than_the_first_nodes(potential, place, speed, feature, digits):
    motion = moving(potential, str(place), str(speed), digits)
    with mp.workdps(40):
        exact = truth(drawn(potential, place, speed, [feature]))
        for found, value in ((motion.frequencies["x"], exact.frequency), (motion.actions["x"], exact.action)):
            assert abs(found.value - value) <= found.error + value * mp.mpf(10) ** -18
            assert found.error <= 1e-14 * value


def resolved(one):
    """The motion of a draw, its frequency and action within their claims of those of 40 digits."""
    solution = hjsolve.solve(hjsolve.System(dict(one.coordinates), one.kinetic, one.potential))
    motion = solution.motion(q=one.exact("q"), p=one.exact("p"))
    with mp.workdps(40):
        exact = truth(one)
        for found, value in ((motion.frequencies, exact.frequency), (motion.actions, exact.action)):
            assert abs(abs(found[one.name].value) - value) <= found[one.name].error + value * mp.mpf(10) ** -17
            assert found[one.name].error <= 1e-12 * value
    return motion


@pytest.mark.nightly_cases("4", "6", "8")
@pytest.mark.parametrize("index", range(0, 9, 2))
def test_random_narrow_features_are_resolved(index):
    """One of each second base of the generator; benchmarks/features.py runs thousands."""
    resolved(draw(11, index))


@pytest.mark.nightly_cases(
    "one in another", "packet of 10", "packet of 1e-6", "packet of 30", "packet", "rotor of 2e-6",
)  # fmt: skip
@pytest.mark.parametrize(
    ("seed", "index"),
    [(5, 48), (7, 65), (7, 84), (7, 104), (5, 14), (7, 18), (7, 91)],
    ids=["packet", "packet of 10", "packet of 1e-6", "rotor", "rotor of 2e-6", "packet of 30", "one in another"],
)
def test_crowds_of_obstacles_and_products_that_overflow_are_resolved(seed, index):
    """Drawn at random, and refused once: waves in an envelope, and sines about a place on a circle."""
    assert resolved(draw(seed, index)).nodes <= 2500


def test_without_the_enclosures_the_narrow_dip_would_not_be_seen(monkeypatch):
    """The proof broken on purpose: formulas taken as bounded without a look at them."""
    start = "x**2/2 - 1/(1 + 10**12*(x - 19/10)**2)/5", "1", "2"
    seen = moving(*start).periods["x"]
    own = resolution.Integrands.over
    monkeypatch.setattr(
        resolution.Integrands,
        "over",
        lambda self, image: ([Disk(0 * d.centre, 0 * np.abs(d.centre)) for d in own(self, image)[0]], False),
    )
    unseen = moving(*start).periods["x"]
    assert abs(unseen.value - 2 * math.pi) < 1e-9 < 1e-8 < abs(seen.value - 2 * math.pi)


@pytest.mark.nightly
def test_rapid_oscillation_is_resolved_by_as_many_nodes_as_it_needs():
    potential = "x**2/2 + sin(100*x)/20"
    found = moving(potential, "1", "0.5").frequencies["x"]
    with mp.workdps(40):
        exact = truth(drawn(potential, 1, 0.5, [("packet of 30", 0, 1, 0.01, 200)])).frequency
        assert abs(found.value - exact) <= found.error <= 1e-14 * exact
