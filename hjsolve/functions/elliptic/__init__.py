"""Real elliptic integrals of rational functions over √P(x), deg P = 3 or 4, in Carlson's functions, and their inverses.

In: roots of P and partial fractions as sympy expressions. Out: sympy expressions, real and positive under every root in
the regime that the order of the real roots describes. Read ``branch_points.py`` first, then ``carlson_forms.py``.
"""

from __future__ import annotations

from hjsolve.functions.elliptic.between_two_roots import Side, complement_squared
from hjsolve.functions.elliptic.branch_points import BranchPoints, NoForm, PartialFractions
from hjsolve.functions.elliptic.carlson_forms import complete, incomplete
from hjsolve.functions.elliptic.jacobi_forms import inverse, odd_root_of_inverse
from hjsolve.functions.elliptic.two_pairs import around, between, inverse_between

__all__ = [
    "BranchPoints",
    "NoForm",
    "PartialFractions",
    "Side",
    "around",
    "between",
    "complement_squared",
    "complete",
    "incomplete",
    "inverse",
    "inverse_between",
    "odd_root_of_inverse",
]  # fmt: skip
