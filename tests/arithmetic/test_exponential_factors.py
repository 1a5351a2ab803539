"""e^{λq} φ over disks far out: φ holds f e^{−λq} at every place of a disk, where f itself over- or underflows."""

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.arithmetic.complex_disks import Disk
from hjsolve.arithmetic.exponential_factor import Rates, largest
from hjsolve.lowering import lower

q = sp.Symbol("q", real=True)
CASES = [
    ("exp(-q) + exp(-137*q/100)", {1: -1.0, -1: -1.37}),
    ("8*exp(2*q)/(1 + exp(2*q))**2", {1: -2.0, -1: 2.0}),
    ("cosh(q)*sinh(137*q/100) + 3", {1: 2.37, -1: -2.37}),
    ("sqrt(exp(-q) + exp(-137*q/50))/cosh(q/3)", {1: -0.5 - 1 / 3, -1: -1.37 + 1 / 3}),
    ("log(exp(q) + exp(137*q/100)) - q/exp(q)", {1: 0.0, -1: -1.0}),
    ("exp(-q)*(2 + exp(-q/7))**(-3)", {1: -1.0, -1: -1 + 3 / 7}),
    ("tanh(q)*exp(-q**2/10**6)", {1: 0.0, -1: 0.0}),
]


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("text,rates", CASES)  # noqa: PT006
def test_the_disk_holds_the_formula_without_its_exponential(text, rates, side):
    formula = sp.sympify(text, locals={"q": q})
    function = sp.lambdify(q, formula, "mpmath")
    # |Im λz| < π there: the root is the principal one
    for centre, radius in ((side * 420.0, 1.0), (side * 60.0 + 0.5j, 0.4)):
        disk = Disk(np.array([complex(centre)]), np.array([radius]))
        arithmetic = Rates.over(disk, side)
        with np.errstate(all="ignore"):
            found = lower([formula], [q]).run(arithmetic, [arithmetic.exponent()])[0]
        rate = found.order * arithmetic.rate
        assert abs(rate - rates[side]) < 1e-12
        middle, reach = found.parts[0]
        assert np.isfinite(reach).all()
        for turn in np.exp(2j * np.pi * np.arange(5) / 5):
            z = mpmath.mpmathify(centre) + mpmath.mpmathify(complex(radius * turn))
            with mpmath.workdps(500):
                truth = function(z) * mpmath.exp(-mpmath.mpf(rate) * z)
                assert abs(truth - mpmath.mpmathify(complex(np.ravel(middle)[0]))) <= float(np.ravel(reach)[0])
        assert largest(disk, 2.0)[0] == 2 * np.real(centre) + 2 * radius
