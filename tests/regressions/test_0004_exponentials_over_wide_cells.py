"""Products of exponentials are spread out before intervals go through them; they used to be bisected for ever."""

import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.arithmetic.floats import Multi
from hjsolve.lowering import lower, spread_exponentials


def test_a_dissociated_morse_oscillator_escapes_however_its_potential_is_written() -> None:
    """p = √(2(E − D(1 − e^{−ax})²)) has one zero, at x = −ln(1 + √(E/D))/a."""
    for potential in ("(1 - exp(-x))**2", "(exp(x) - 1)**2*exp(-2*x)", "1 - 2/exp(x) + exp(-2*x)"):
        system = hjsolve.System(coordinates={"x": "line"}, kinetic="dot(x)**2/2", potential=potential)
        motion = hjsolve.solve(system).motion(q={"x": "0.3"}, velocity={"x": "-1.8"})
        assert motion.kinds == {"x": "escape"}
        with mp.workdps(40):
            E = mp.mpf("1.62") + (1 - mp.exp(mp.mpf("-0.3"))) ** 2
            exact = -mp.log(1 + mp.sqrt(E))
        lower_end, _ = motion.turning_points["x"]
        assert abs(lower_end.value - exact) <= lower_end.error <= 1e-14


def test_what_is_free_of_exponentials_is_left_as_it_stands() -> None:
    x = sp.Symbol("x", real=True)
    e = (sp.exp(x) - 1) ** 2 * sp.exp(-2 * x) * (x**2 - 1) ** 2 / x
    spread = spread_exponentials(e)
    assert (x**2 - 1) ** 2 in {b for term in spread.args for b in term.args}
    assert abs(sp.N((spread - e).subs(x, sp.Rational(7, 5)), 40)) < 1e-38
    rational = (x**2 - 1) ** 2 / (1 + x)
    assert spread_exponentials(rational) is rational


def test_the_tape_has_no_quotient_by_a_growing_exponential() -> None:
    x = sp.Symbol("x", real=True)
    tape = lower([-3 * sp.exp(-2 * x) / (7 * (1 + x) ** 2)], [x])
    value = tape.run(Multi(160), [Multi(160).rational(3, 2)])[0]
    with mp.workdps(40):
        exact = -3 * mp.exp(-3) / (7 * mp.mpf("6.25"))
        assert abs(value - exact) < mp.mpf(10) ** -38
    assert all(op.code != "div" or tape.operations[op.operands[1] - 1].code != "exp" for op in tape.operations)
