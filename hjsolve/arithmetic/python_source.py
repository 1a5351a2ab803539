"""An arithmetic that writes Python: run a tape in it and the lines of a straight-line program come out.

The text is made of our own operation codes and of numbers, never of anything a user wrote: a tape has no names but its
slots. Composite arithmetics (``jet``, ``running_error``) write the program of their components.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import pi

from hjsolve.arithmetic.floats import by_squaring
from hjsolve.arithmetic.tape import UNARY

_PAIRED = {"sin": ("sincos", 0), "cos": ("sincos", 1), "sinh": ("sinhcosh", 0), "cosh": ("sinhcosh", 1)}


@dataclass
class PythonSource:
    """Arithmetic on the names of variables and on literals.

    Attributes:
        lines: the program so far.
    """

    lines: list[str] = field(default_factory=list)
    _known: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def called(self, name: str, *arguments: str, results: int) -> tuple[str, ...]:
        """Write the line that calls a function of ours.

        Args:
            name: of the function.
            arguments: names of variables, or literals.
            results: how many values it returns.

        Returns:
            The names of the variables that hold them.
        """
        return self._assigned(f"{name}({', '.join(arguments)})", results)

    def _assigned(self, text: str, results: int = 1) -> tuple[str, ...]:
        if text not in self._known:
            names = tuple(f"t{len(self._known)}_{k}" for k in range(results))
            self.lines.append(f"{', '.join(names)} = {text}")
            self._known[text] = names
        return self._known[text]

    def rational(self, numerator: int, denominator: int) -> str:
        """Return the literal of a fraction, rounded to a double.

        Args:
            numerator, denominator: whole numbers, the second not zero.
        """
        return f"({float(Fraction(numerator, denominator))!r})"

    def pi(self) -> str:
        return f"({pi!r})"

    def add(self, x: str, y: str) -> str:
        """Write a line with x + y and return the name of its variable; none for a term 0.

        Args:
            x, y: names of variables, or literals.
        """
        if "(0.0)" in (x, y):
            return y if x == "(0.0)" else x
        return self._assigned(f"{x} + {y}")[0]

    def sub(self, x: str, y: str) -> str:
        """Write a line with x − y and return the name of its variable.

        Args:
            x, y: names of variables, or literals.
        """
        if x == "(0.0)":
            return self.unary("neg", y)
        return self._assigned(f"{x} - {y}")[0]

    def mul(self, x: str, y: str) -> str:
        """Write a line with x·y and return the name of its variable; none for a factor 1 or 0.

        Args:
            x, y: names of variables, or literals.
        """
        if "(1.0)" in (x, y):
            return y if x == "(1.0)" else x
        if "(0.0)" in (x, y):
            return "(0.0)"
        return self._assigned(f"{x} * {y}")[0]

    def div(self, x: str, y: str) -> str:
        """Write a line with x/y and return the name of its variable.

        Args:
            x, y: names of variables, or literals.
        """
        return self._assigned(f"{x} / {y}")[0]

    def power(self, x: str, n: int) -> str:
        """Write xⁿ as products and return the name of the last variable.

        Args:
            x: a name of a variable, or a literal.
            n: the exponent, of either sign.
        """
        if n <= 0:
            return "(1.0)" if n == 0 else self.div("(1.0)", self.power(x, -n))
        result: str = by_squaring(self.mul, x, n)
        return result

    def unary(self, name: str, x: str) -> str:
        """Write the line that takes a function of one variable.

        Args:
            name: of the function, such as ``sqrt``.
            x: name of the variable it is taken of.

        Returns:
            The name of the variable that holds the value.

        Raises:
            ValueError: a function that is not known here.
        """
        if name not in UNARY:
            raise ValueError(name)
        if name == "neg":
            return self._assigned(f"-{x}")[0]
        if name in _PAIRED:
            function, place = _PAIRED[name]
            return self._assigned(f"{function}({x})", 2)[place]
        return self._assigned(f"{name}_({x})")[0]


def function(name: str, arguments: Sequence[str], source: PythonSource, results: Sequence[str]) -> str:
    """Return the text of a function that runs the program.

    Args:
        name: of the function.
        arguments: names of its arguments.
        source: the program that its body runs.
        results: names of the variables it returns.
    """
    body = "".join(f"    {line}\n" for line in source.lines)
    values = "".join(f"{result}, " for result in results)
    return f"def {name}({', '.join(arguments)}):\n{body}    return ({values})\n"
