"""A search for tori took a well behind the end of the domain; integrating there, it filled the memory of the machine."""

from __future__ import annotations

import mpmath
import pytest
from mpmath import mp

import hjsolve
from hjsolve.arithmetic.elliptic import jacobi_complex, means, quarter_period
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.one_coordinate.anomaly import libration_anomaly

ACTIONS = {"xi": 0.2845593688081434, "eta": 0.035586032683447046, "phi": 0.293178260002714}


def test_two_tori_are_told_and_none_behind_the_end_of_eta() -> None:
    """Orbits about either of two centres, 0 < η < π; their images at 2π − η are no others."""
    solution = hjsolve.solve("two-centres-space")
    with pytest.raises(hjsolve.SeveralToriError) as told:
        solution.motion(actions=ACTIONS)
    assert str(told.value).count("eta libration from") == 2
    with pytest.raises(hjsolve.InvalidInputError, match="no torus with these actions is there"):
        solution.motion(actions=ACTIONS, q={"eta": "3.5"})
    about_one = solution.motion(actions=ACTIONS, q={"eta": "2.7"})
    assert abs(about_one.actions["eta"].value / ACTIONS["eta"] - 1) < 1e-15
    assert about_one.turning_points["eta"][1].value < 3.1415926


@pytest.mark.parametrize(("below", "above"), [("-3", "-2"), ("-2", "-3"), ("5", "4"), ("4", "5"), ("-1", "3")])
def test_the_anomaly_is_the_same_whichever_of_two_zeros_on_one_side_comes_first(below: str, above: str) -> None:
    """∫ dq/√((q − a)(b − q)) g(q) over a cycle, with g = 1/√|(q − c)(q − d)|, against mpmath's quadrature."""
    arithmetic = Multi(128)
    number = arithmetic.context.mpf
    anomaly = libration_anomaly(number(0), number(1), number(below), number(above), arithmetic)
    assert 0 < anomaly.complement <= 1
    n, total = 64, number(0)
    for k in range(n):
        at = anomaly.place(arithmetic.pi() * (k + number(1) / 2) / n, arithmetic)
        total += at.stretch / abs((at.q - number(below)) * (at.q - number(above))) ** (number(1) / 2)
    with mp.workdps(30):

        def along(χ: mpmath.mpf) -> mpmath.mpf:
            q = (1 - mp.cos(χ)) / 2
            return 1 / mp.sqrt(abs((q - mp.mpf(below)) * (q - mp.mpf(above))))

        expected = mp.quad(along, [0, mp.pi])
        assert abs(mp.mpf(str(total * arithmetic.pi() / n)) / expected - 1) < 1e-25


def test_means_that_do_not_meet_are_a_fault_and_not_an_endless_list() -> None:
    with pytest.raises(hjsolve.InternalError, match="does not converge"):
        means((1.0, float("nan")), lambda a, b: a == b, Float64())
    assert quarter_period(1e-300, Float64()) > 300
    sn, _, _ = jacobi_complex([0.3 + 0.2j], 0.75, quarter_period(0.75, Float64()))
    assert abs(complex(sn[0]) - complex(mpmath.ellipfun("sn", 0.3 + 0.2j, m=0.25))) < 1e-15
