"""The C and Python text of forms, compiled and run at random constants, gives what ``evaluate`` gives."""

from __future__ import annotations

import inspect
import random
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import sympy as sp

from hjsolve.closed_form.forms import RegimeForms
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(4)

ENTRIES = ["kepler-planar", "pendulum", "double-well", "spherical-pendulum", "isochrone", "cone"]


def _places(form: RegimeForms, count: int) -> Iterator[dict[sp.Symbol, sp.Expr]]:
    """Symbol → number: constants and parameters near those of the example, in the regime; roots as they are there."""
    draw, found = random.Random(form.regime.words), 0
    while found < count:
        at = {s: v * (1 + sp.Rational(draw.randint(-20, 20), 1000)) for s, v in form.regime.example.items()}
        for symbol, meaning in form.regime.special.items():
            at[symbol] = meaning.xreplace(at)
        if not form.regime.holds(at):
            continue
        found += 1
        for symbol, meaning in form.where.items():
            if isinstance(meaning, tuple):
                roots = sp.Poly(meaning[0].as_expr().xreplace(at), meaning[0].gen).nroots(n=30)
                at[symbol] = sorted(r for r in roots if r.is_real)[meaning[1]]
        yield at


def _cases(form: RegimeForms) -> list[tuple[str, list[sp.Symbol], list[float], float]]:
    """Function, its arguments, their values, and the value of the form there to 25 digits."""
    cases, space = [], dict[str, object]()
    exec(form.code("python"), space)  # what is arranged for doubles may rest on more roots than the form
    for at in _places(form, 2):
        for name in form.named():
            expression = form.written_out(name)
            if name.startswith(("inverse", "orbit.")):
                free = sorted(expression.free_symbols - set(at), key=str)
                at = at | {s: sp.Rational(k + 1, 19) for k, s in enumerate(free)}
            names, own = {s.name: s for s in at}, inspect.signature(space[name.replace(".", "_")]).parameters  # type: ignore[arg-type]
            if not set(own) <= set(names):
                continue
            arguments = [names[argument] for argument in own]
            given = {s: sp.Float(sp.N(at[s], 20), 17) for s in arguments}
            exact = sp.N(expression.xreplace({s: sp.Rational(float(v)) for s, v in given.items()}), 25)
            if exact.is_real:
                cases.append((name.replace(".", "_"), arguments, [float(given[s]) for s in arguments], float(exact)))
    assert len(cases) >= 6
    return cases


def _close(got: float, exact: float) -> bool:
    return abs(got - exact) <= 2e-12 * max(abs(exact), 1e-2)


@pytest.mark.nightly_cases("isochrone", "spherical-pendulum", "cone")
@pytest.mark.rotating(2)
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("name", ENTRIES)
def test_c_compiles_without_a_warning_and_agrees(name: str, tmp_path: Path) -> None:
    form = forms(name)[0]
    cases = _cases(form)
    calls = [f'    printf("%.17g\\n", {n}({", ".join(map(repr, values))}));' for n, _, values, _ in cases]
    text = "#include <stdio.h>\n" + form.code("c") + "int main(void) {\n" + "\n".join(calls) + "\n    return 0;\n}\n"
    (tmp_path / "form.c").write_text(text, encoding="utf-8")
    program = tmp_path / "form"
    flags = ["-std=c99", "-Wall", "-Werror"]
    subprocess.run(["cc", *flags, "-o", program, tmp_path / "form.c", "-lm"], check=True, timeout=100)
    printed = subprocess.run([program], check=True, capture_output=True, text=True, timeout=100).stdout.split()
    for (function, _, values, exact), got in zip(cases, printed, strict=True):
        assert _close(float(got), exact), (function, values, got, exact)


@pytest.mark.nightly_cases("isochrone", "spherical-pendulum", "cone")
@pytest.mark.parametrize("name", ENTRIES)
def test_python_runs_and_agrees(name: str) -> None:
    form = forms(name)[0]
    space: dict[str, object] = {}
    exec(form.code("python"), space)
    for function, _, values, exact in _cases(form):
        assert _close(float(space[function](*values)), exact), (function, values, exact)  # type: ignore[operator]


@pytest.mark.parametrize("name", ENTRIES)
def test_latex_of_every_form_is_balanced_and_names_the_functions(name: str) -> None:
    for form in forms(name)[:3]:
        for expression in form.named().values():
            text = sp.latex(expression)
            depth = 0
            for mark in re.findall(r"(?<!\\)[{}]", text):
                depth += 1 if mark == "{" else -1
                assert depth >= 0
            assert depth == 0
            assert text.count(r"\left") == text.count(r"\right")
            assert not re.search(r"elliptic_|Carlson|Jacobi", text), text


@pytest.mark.parametrize(("language", "mark"), [("python", "#"), ("c", "//")])
def test_the_head_says_that_doubles_lose_digits(language: str, mark: str) -> None:
    head = forms("pendulum")[0].code(language).split("\n\n")[0]
    told = " ".join(line.removeprefix(mark).strip() for line in head.splitlines() if line.startswith(mark))
    assert "compute in doubles: next to separatrices" in told
    assert "lose digits without a sign; evaluate() and lambdify() do not" in told
