"""Functions: the elliptic functions of closed forms that sympy lacks, as functions of sympy.

In: sympy expressions. Out: Carlson's R_F, R_C, R_D, R_J and Jacobi's sn, cn, dn, am, ℰ of them: values to any number of
digits, derivatives by every argument, LaTeX, code for numpy, scipy, mpmath and C. Legendre's integrals are sympy's own;
``lambdify`` with ``modules=modules("numpy")`` evaluates them too. Read ``carlson.py`` and ``jacobi.py`` first.
"""

from __future__ import annotations

from hjsolve.functions.c_code import c_source
from hjsolve.functions.carlson import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ
from hjsolve.functions.complex_pole import CarlsonRCIm, CarlsonRCRe, CarlsonRJIm, CarlsonRJRe
from hjsolve.functions.jacobi import JacobiAM, JacobiCN, JacobiDN, JacobiEpsilon, JacobiSN
from hjsolve.functions.tables import modules

__all__ = [
    "CarlsonRC", "CarlsonRCIm", "CarlsonRCRe", "CarlsonRD", "CarlsonRF", "CarlsonRJ", "CarlsonRJIm", "CarlsonRJRe",
    "JacobiAM", "JacobiCN", "JacobiDN", "JacobiEpsilon", "JacobiSN",
    "c_source", "modules",
]  # fmt: skip
