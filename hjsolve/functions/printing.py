"""How the functions are written: LaTeX, and the code of numpy, scipy, mpmath and C."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import mpmath
import sympy as sp

from hjsolve.functions.many_digits import evaluated

if TYPE_CHECKING:
    from sympy.printing.str import StrPrinter

_FOURTH = {"sn": "[0]", "cn": "[1]", "dn": "[2]", "am": "[3]"}
"""scipy's ellipj gives four functions."""
_LATEX = {"epsilon": r"\mathcal{E}"}
MANY_DIGITS = "hjsolve.functions.many_digits"
DOUBLES = "hjsolve.arithmetic.carlson"


class Printable(sp.Function):
    """A function of sympy that has a value to any number of digits and prints as code.

    Attributes:
        letter: how books write it.
        scipy_name: the function of ``scipy.special``, or nothing.
        value: the function of mpmath's numbers.
        doubles, many_digits: the modules of the functions of numpy's arrays and of mpmath's numbers.
    """

    letter: ClassVar[str]
    scipy_name: ClassVar[str] = ""
    value: ClassVar[Callable[..., mpmath.mpf]]
    doubles: ClassVar[str] = DOUBLES
    many_digits: ClassVar[str] = MANY_DIGITS

    def _eval_evalf(self, prec: int) -> sp.Expr | None:
        return evaluated(type(self).value, self.args, prec)

    @classmethod
    def code_name(cls) -> str:
        """Return the name of the function in every code: ``carlson_rf``, ``jacobi_sn``."""
        return f"carlson_{cls.letter.replace('_', '').lower()}" if "_" in cls.letter else f"jacobi_{cls.letter}"

    def _latex(self, printer: StrPrinter, exp: str | None = None) -> str:
        head, _, index = self.letter.partition("_")
        name = rf"{head}_{{{index}}}" if index else _LATEX.get(head, rf"\operatorname{{{head}}}")
        power = f"^{{{exp}}}" if exp is not None else ""
        texts = [printer._print(argument) for argument in self.args]
        inner = r"\middle| ".join(texts) if not index else ", ".join(texts)
        return rf"{name}{power}\left({inner}\right)"

    def _called(self, printer: StrPrinter, name: str) -> str:
        return f"{name}({', '.join(printer._print(argument) for argument in self.args)})"

    def _mpmathcode(self, printer: StrPrinter) -> str:
        return self._called(printer, printer._module_format(f"{self.many_digits}.{self.code_name()}"))

    def _numpycode(self, printer: StrPrinter) -> str:
        if "SciPy" not in type(printer).__name__ or not self.scipy_name:
            return self._called(printer, printer._module_format(f"{self.doubles}.{self.code_name()}"))
        called = self._called(printer, printer._module_format(f"scipy.special.{self.scipy_name}"))
        return called + _FOURTH.get(self.letter, "")

    def _ccode(self, printer: StrPrinter) -> str:
        return self._called(printer, self.code_name())
