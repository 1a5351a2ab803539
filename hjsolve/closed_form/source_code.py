"""Source text of forms, for other programs."""

from __future__ import annotations

import re

import sympy as sp
from sympy.printing.c import C99CodePrinter, get_math_macros
from sympy.printing.pycode import PythonCodePrinter

from hjsolve.closed_form.complements import ForDoubles
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.regions import Where
from hjsolve.errors import InvalidInputError
from hjsolve.functions.c_code import c_source, in_c
from hjsolve.functions.printing import DOUBLES, Printable
from hjsolve.functions.tables import LEGENDRE

_DOUBLES_ALONE = (
    "The functions compute in doubles: next to separatrices, in small motions, next to turning points and where",
    "constants are of very different sizes they lose digits without a sign; evaluate() and lambdify() do not.",
)
"""What whoever has the text alone should know."""


class _PythonPrinter(PythonCodePrinter):
    """Python, with the elliptic functions by their plain names."""

    def _print_Function(self, expr: sp.Function) -> str:
        if isinstance(expr, Printable):
            return expr._called(self, expr.code_name())
        return str(super()._print_Function(expr))


def source(form: NamedForms, language: str) -> str:
    """One function for each form; see ``RegimeForms.code``.

    Args:
        form: of a regime.
        language: "python" or "c".

    Raises:
        InvalidInputError: another language.
    """
    if language not in ("python", "c"):
        raise InvalidInputError(f'code: {language!r} is not known; write "python" or "c"')
    mark = "#" if language == "python" else "//"
    head = [f"{mark} {form.solution.system.id or 'closed forms'}: {form.regime.words}"]
    head += [f"{mark} {line}" for line in _DOUBLES_ALONE]
    head += [f"{mark} {symbol}: {_meaning(meaning)}" for symbol, meaning in form.where.items()]
    # the arrangement for arrays: with it doubles lose fewer digits, and there is nothing else here
    arrange = ForDoubles.of(form)
    named = {name: arrange.form(e) for name, e in form.named().items()}
    where = arrange.definitions(s for e in named.values() for s in e.free_symbols)
    defined = where.values()
    every = sp.Tuple(*named.values(), *(e for e in defined if not isinstance(e, tuple)))
    write = _python if language == "python" else _c
    functions = [write(name.replace(".", "_"), e, where) for name, e in named.items()]
    if language == "python":
        head += _python_head(every)
    else:
        head += ["#include <math.h>", *_macros("".join(functions)), c_source(every).rstrip()]
    return "\n\n".join(["\n".join(head).rstrip(), *functions]) + "\n"


def _python_head(every: sp.Tuple) -> list[str]:
    """Return what the functions import: the standard library, and this package for elliptic functions."""
    own = sorted({f"{f.code_name()}" for f in every.atoms(Printable)})
    used = [name for name in LEGENDRE if every.has(getattr(sp, name))]
    needed = [*own, *(f"{name.replace('elliptic', 'legendre')} as {name}" for name in used)]
    return ["import math", *([f"from {DOUBLES} import {', '.join(needed)}"] if needed else [])]


def _meaning(meaning: object) -> str:
    if isinstance(meaning, tuple):
        return f"real root number {meaning[1] + 1}, ascending, of {sp.sstr(meaning[0].as_expr())} in {meaning[0].gen}"
    return sp.sstr(meaning)


def _arguments(expression: sp.Expr, where: Where) -> tuple[list[str], list[tuple[sp.Symbol, sp.Expr]]]:
    """Return what a function is given, roots of polynomials among it, and the quantities that it works out first."""
    defined, plain = needed_names(expression.free_symbols, {s: e for s, e in where.items() if not isinstance(e, tuple)})
    return sorted(s.name for s in plain), [(s, e) for s, e in defined.items() if not isinstance(e, tuple)]


def _lines(
    expression: sp.Expr, where: Where
) -> tuple[list[str], list[tuple[sp.Symbol, sp.Expr]], sp.Expr]:  # fmt: skip
    """Arguments; definitions and parts that occur more than once, by names that the form does not use; what is left."""
    given, defined = _arguments(expression, where)
    taken = {*given, *(s.name for s, _ in defined)}
    names = (s for s in sp.numbered_symbols("part", start=1) if s.name not in taken)
    # K and its modulus occur in most terms: they are worked out once
    parts, (rest,) = sp.cse(_without_signs(expression), symbols=names)
    return given, [*((s, _without_signs(e)) for s, e in defined), *parts], rest


def _python(name: str, expression: sp.Expr, where: Where) -> str:
    printer = _PythonPrinter({"fully_qualified_modules": True, "allow_unknown_functions": True})
    given, parts, rest = _lines(expression, where)
    lines = [f"    {part} = {printer.doprint(value)}" for part, value in parts]
    return "\n".join([f"def {name}({', '.join(given)}):", *lines, f"    return {printer.doprint(rest)}"])


def _c(name: str, expression: sp.Expr, where: Where) -> str:
    printer = C99CodePrinter({"allow_unknown_functions": True})
    given, parts, rest = _lines(expression, where)
    arguments = ", ".join(f"double {s}" for s in given) or "void"
    lines = [f"    const double {part} = {printer.doprint(in_c(value))};" for part, value in parts]
    return "\n".join([f"double {name}({arguments}) {{", *lines, f"    return {printer.doprint(in_c(rest))};", "}"])


def _macros(text: str) -> list[str]:
    """Return the constants of <math.h> that a text uses: C99 by itself does not have them."""
    known = {name: value for value, name in get_math_macros().items()}
    return [
        f"#ifndef {name}\n#define {name} {sp.N(sp.expand_func(known[name]), 20)}\n#endif"
        for name in sorted(set(re.findall(r"\bM_\w+", text)) & set(known))
    ]


def _without_signs(expression: sp.Expr) -> sp.Expr:
    """s/|s| for sign(s), which few languages have: no form is used where s = 0."""
    return expression.replace(sp.sign, lambda s: s / sp.Abs(s, evaluate=False))
