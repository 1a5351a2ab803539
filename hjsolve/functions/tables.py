"""The elliptic functions by name, for ``sympy.lambdify``."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from hjsolve.errors import InvalidInputError
from hjsolve.functions.carlson import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ
from hjsolve.functions.complex_pole import CarlsonRCIm, CarlsonRCRe, CarlsonRJIm, CarlsonRJRe
from hjsolve.functions.jacobi import JacobiAM, JacobiCN, JacobiDN, JacobiEpsilon, JacobiSN
from hjsolve.functions.many_digits import legendre_e, legendre_pi
from hjsolve.functions.printing import DOUBLES, Printable
from hjsolve.precision import NUMBERS, for_any_context, mp

_OWN: tuple[type[Printable], ...] = (
    CarlsonRF, CarlsonRC, CarlsonRD, CarlsonRJ, CarlsonRCRe, CarlsonRCIm, CarlsonRJRe, CarlsonRJIm,
    JacobiAM, JacobiSN, JacobiCN, JacobiDN, JacobiEpsilon,
)  # fmt: skip
LEGENDRE = ("elliptic_k", "elliptic_f", "elliptic_e", "elliptic_pi")
"""sympy's names of Legendre's integrals."""


def modules(backend: str) -> list[dict[str, Callable[..., object]] | str]:
    """Return what ``sympy.lambdify`` is given as ``modules`` so that every elliptic function has a value.

    Args:
        backend: "numpy" (arrays of doubles, numpy alone) or "mpmath" (any precision).

    Returns:
        A table name → function, sympy's own Legendre integrals among them, and the name of the backend for all else.

    Raises:
        InvalidInputError: another backend.

    Example:
        >>> import sympy as sp
        >>> m = sp.Symbol("m")
        >>> f = sp.lambdify(m, sp.elliptic_k(m), modules=modules("numpy"))
        >>> round(float(f(0.5)), 12)
        1.854074677301
    """
    if backend == "mpmath":
        return [{name: for_any_context(f) for name, f in _many_digits().items()}, backend]
    if backend == "numpy":
        home = importlib.import_module(DOUBLES)
        own = {f.__name__: getattr(importlib.import_module(f.doubles), f.code_name()) for f in _OWN}
        table = {name: getattr(home, name.replace("elliptic", "legendre")) for name in LEGENDRE}
        return [own | table, backend]
    raise InvalidInputError(f'modules: "numpy" or "mpmath" is needed, not {backend!r}')


def own_modules() -> list[dict[str, Callable[..., object]] | str]:
    """Return the table for ``sympy.lambdify`` of functions of ``precision.mp`` numbers, elliptic ones among them.

    Π is that of real forms: of complex arguments, which users may have, mpmath's takes minutes.
    """
    return [NUMBERS | _many_digits() | {"elliptic_pi": legendre_pi}, "mpmath"]


def _many_digits() -> dict[str, Callable[..., object]]:
    own = {f.__name__: f.value for f in _OWN}
    return own | dict(zip(LEGENDRE, (mp.ellipk, mp.ellipf, legendre_e, mp.ellippi), strict=True))
