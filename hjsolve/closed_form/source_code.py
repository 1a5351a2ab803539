"""Source text of forms, for other programs."""

from __future__ import annotations

import sympy as sp
from sympy.printing.c import C99CodePrinter
from sympy.printing.pycode import PythonCodePrinter

from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.errors import InvalidInputError


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
    head += [f"{mark} {symbol}: {_meaning(meaning)}" for symbol, meaning in form.where.items()]
    head.append("import math" if language == "python" else "#include <math.h>")
    write = _python if language == "python" else _c
    return (
        "\n\n".join(["\n".join(head), *(write(name.replace(".", "_"), e) for name, e in form.named().items())]) + "\n"
    )


def _meaning(meaning: object) -> str:
    if isinstance(meaning, tuple):
        return f"real root number {meaning[1] + 1}, ascending, of {sp.sstr(meaning[0].as_expr())} in {meaning[0].gen}"
    return sp.sstr(meaning)


def _symbols(expression: sp.Expr) -> list[str]:
    return sorted(s.name for s in expression.free_symbols)


def _python(name: str, expression: sp.Expr) -> str:
    printer = PythonCodePrinter({"fully_qualified_modules": True, "allow_unknown_functions": True})
    return f"def {name}({', '.join(_symbols(expression))}):\n    return {printer.doprint(_without_signs(expression))}"


def _c(name: str, expression: sp.Expr) -> str:
    printer = C99CodePrinter({"allow_unknown_functions": True})
    arguments = ", ".join(f"double {s}" for s in _symbols(expression)) or "void"
    return f"double {name}({arguments}) {{\n    return {printer.doprint(_without_signs(expression))};\n}}"


def _without_signs(expression: sp.Expr) -> sp.Expr:
    """s/|s| for sign(s), which few languages have: no form is used where s = 0."""
    return expression.replace(sp.sign, lambda s: s / sp.Abs(s, evaluate=False))
