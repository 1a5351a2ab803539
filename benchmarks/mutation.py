"""Do the tests notice a wrong sign? ``python benchmarks/mutation.py [--modules NAME …] [--sample N] [--seconds S]``.

One sign, index, comparison or number at a time is changed in the modules that decide, in a copy of the project, and
the tests that matter are run there until one fails. What survives is printed with its line: either a test is missing,
or the change means nothing (a limit, a size, an order of trial), and then it stands in ``HARMLESS`` with the reason.
The process ends with status 1 when something else survives.

Mutants: + ↔ −, · ↔ /, −x → x, not x → x, == ↔ !=, < ↔ >=, > ↔ <=, is ↔ is not, in ↔ not in, and ↔ or, any ↔ all,
m[i][j] → m[j][i], i ↔ j, n → n + 1, True ↔ False.
"""

from __future__ import annotations

import argparse
import ast
import copy
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAWS = ("tests/laws/test_levi_civita.py", "tests/laws/test_staeckel_matrix.py", "tests/laws/test_liouville.py")
TESTS = {
    "separation/forms/levi_civita": (
        "tests/algebra/test_element_jets.py",
        "tests/separation/test_separation_parts.py",
        "tests/laws/test_levi_civita.py",
        "tests/laws/test_why_not.py",
    ),
    "separation/forms/liouville": ("tests/separation/test_liouville_parts.py", "tests/laws/test_liouville.py"),
    "separation/forms/stackel": (
        "tests/separation/test_separation_parts.py",
        "tests/laws/test_staeckel_matrix.py",
        "tests/laws/test_why_not.py",
    ),
    "separation/zero_test/zero_test": (
        "tests/separation/test_separation_parts.py",
        "tests/separation/test_zero_test.py",
        *LAWS,
    ),
    "shell": ("tests/mechanics/test_energy_shell.py", *LAWS, "tests/solution/test_solution.py"),
    "separation/constants/constants": ("tests/laws/test_staeckel_matrix.py", "tests/laws/test_involution.py"),
    "separation/obstruction/blocks": ("tests/laws/test_why_not.py",),
    "separation/obstruction/diagnose": ("tests/laws/test_why_not.py",),
    "separation/obstruction/distance": ("tests/laws/test_why_not.py",),
}
NAMED = (
    "separation/forms/levi_civita",
    "separation/forms/liouville",
    "separation/forms/stackel",
    "separation/zero_test/zero_test",
    "shell",
)

SYMMETRIC = "the mass matrix is symmetric"

# module → {(line of source, change): why it means nothing}
HARMLESS: dict[str, dict[tuple[str, str], str]] = {
    "separation/forms/levi_civita": {
        (
            "return not any(self._value(i, j, about, *place) for place in self._jets)",
            "any → all",
        ): "what fails at one random point fails at the other, but for a chance of 1e-17",
        (
            "return all(len({self._value(i, j, h, *place) for h in n}) == 1 for place in self._jets)",
            "all → any",
        ): "what fails at one random point fails at the other, but for a chance of 1e-17",
        ("if h == i:", "i → j at 16"): "the general formula gives the same with two terms that cancel",
        ("if any(e < 0 for _, e in holding):", "0 → 1"): "no exponent is zero",
        ("if h == j:", "j → i at 16"): "the general formula gives the same with two terms that cancel",
    },
    "shell": {
        (
            'steps += (Step("Energy shell", text, sp.Eq(shell, energy, evaluate=False)),)',
            "False → True",
        ): "the energy is a symbol of its own, so that nothing is evaluated: it only takes time",
        (
            "places = at_random_points(reader, symbols, elements, points=1) or []",
            "1 → 2",
        ): "a second point for the same answer",
        ("return lower + 1", "1 → 2"): "another place inside",
        ("return sp.S.Zero if upper is None else upper - 1", "1 → 2"): "another place inside",
        (
            "k = min(left, key=lambda i: (any(m[i][i].depends_on(q) for q in positions), cost(m[i][i])))",
            "any → all",
        ): "the order of elimination",
        ("others = [i for i in (*left, *essential) if not m[i][k].is_zero]", "indices of m[i][k] exchanged"): SYMMETRIC,
        (
            "share = {i: reader.field.cancelled(m[i][k] / m[k][k]) for i in others}",
            "indices of m[i][k] exchanged",
        ): SYMMETRIC,
        (
            "m[i][j] = reader.field.cancelled(m[i][j] - share[i] * m[k][j])",
            "indices of m[k][j] exchanged",
        ): SYMMETRIC,
        (
            "return _Eliminated([[m[i][j] for j in essential] for i in essential], [r[i] for i in essential], "
            "centrifugal)",
            "indices of m[i][j] exchanged",
        ): SYMMETRIC,
        ("if not mass[i][j].is_zero:", "indices of mass[i][j] exchanged"): SYMMETRIC,
        ("return j, i, readable(reader, mass[i][j])", "indices of mass[i][j] exchanged"): SYMMETRIC,
    },
    "separation/forms/stackel": {
        ("if any(x.is_zero for x in (*g, *g0)):", "any → all"): "the division that follows raises the same error",
    },
    "separation/forms/liouville": {
        ("factor = Element(field, Fraction(1), {0: 1}, {base: e})", "0 → 1"): "asked only what it depends on",
        ("if lower > 0 or upper < 0:", "0 → 1"): "the sign is +1 where none is found",
        ("return 1", "1 → 2"): "asked is only whether it is negative",
        (
            "return Element(field, x.coefficient, x.numerator, a), Element(field, Fraction(1), {0: 1}, b)",
            "1 → 2",
        ): "the factor goes from one function R to the other",
        (
            "if not set(holds) <= {j} and not set(holds) <= {i}:",
            "j → i at 30",
        ): "the way through a base point gives the same product",
    },
}

OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One changed module."""

    module: str
    line: str
    number: int
    change: str
    source: str


def _changes(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield a copy of the node for every way to change it."""

    def copied() -> ast.AST:
        return copy.deepcopy(node)

    match node:
        case ast.BinOp(op=op) | ast.BoolOp(op=op) if type(op) in OPERATORS:
            new = copied()
            new.op = OPERATORS[type(op)]()
            yield f"{type(op).__name__} → {type(new.op).__name__}", new
        case ast.Compare(ops=[op]) if type(op) in OPERATORS:
            new = copied()
            new.ops = [OPERATORS[type(op)]()]
            yield f"{type(op).__name__} → {type(new.ops[0]).__name__}", new
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            yield f"{type(node.op).__name__} removed", copied().operand
        case ast.Call(func=ast.Name(id="any" | "all")):
            new = copied()
            new.func.id = "all" if node.func.id == "any" else "any"
            yield f"{node.func.id} → {new.func.id}", new
        case ast.Subscript(value=ast.Subscript()) if ast.dump(node.slice) != ast.dump(node.value.slice):
            new = copied()
            new.slice, new.value.slice = new.value.slice, new.slice
            yield f"indices of {ast.unparse(node)} exchanged", new
        case ast.Name(id="i" | "j", ctx=ast.Load()):
            new = copied()
            new.id = "j" if node.id == "i" else "i"
            yield f"{node.id} → {new.id} at {node.col_offset}", new
        case ast.Constant(value=bool() as value):
            yield f"{value} → {not value}", ast.Constant(not value)
        case ast.Constant(value=int() as value):
            yield f"{value} → {value + 1}", ast.Constant(value + 1)


def _places(tree: ast.AST) -> Iterator[tuple[ast.AST, str, int | None]]:
    """Every node that may be changed, as (parent, field, index); annotations, messages and texts are left alone."""
    for name, value in ast.iter_fields(tree):
        if name in {"annotation", "returns", "decorator_list"} or isinstance(value, ast.JoinedStr | ast.Raise):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if isinstance(child, ast.AST) and not isinstance(child, ast.JoinedStr | ast.Raise):
                yield tree, name, index
                yield from _places(child)


def mutants(module: str) -> list[Mutant]:
    """All mutants of a module, in order."""
    text = (ROOT / "hjsolve" / f"{module}.py").read_text(encoding="utf-8")
    lines, tree, found = text.splitlines(), ast.parse(text), []
    for parent, name, index in list(_places(tree)):
        value = getattr(parent, name)
        node = value if index is None else value[index]
        for change, new in _changes(node):
            if index is None:
                setattr(parent, name, new)
            else:
                value[index] = new
            source = ast.unparse(ast.fix_missing_locations(tree))
            found.append(Mutant(module, lines[node.lineno - 1].strip(), node.lineno, change, source))
            if index is None:
                setattr(parent, name, node)
            else:
                value[index] = node
    return found


def killed(mutant: Mutant, folder: Path, limit: float) -> str:
    """Return the first test that fails, or an empty text."""
    target = folder / "hjsolve" / f"{mutant.module}.py"
    kept = target.read_text(encoding="utf-8")
    target.write_text(mutant.source, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--timeout=60"]
    try:
        done = subprocess.run(
            [*command, *TESTS[mutant.module]],
            cwd=folder, capture_output=True, text=True, timeout=limit, check=False, env=_environment(folder),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "it takes too long"
    finally:
        target.write_text(kept, encoding="utf-8")
    lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return (lines[0] if lines else f"status {done.returncode}") if done.returncode else ""


def _environment(folder: Path) -> dict[str, str]:
    import os

    return {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--modules", nargs="*", default=list(NAMED), choices=list(TESTS))
    parser.add_argument("--sample", type=int, default=None, help="that many of each module, at random")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="stop after this time")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds for the tests of one mutant")
    given = parser.parse_args()
    start, survivors, count = time.monotonic(), list[Mutant](), 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name in ("hjsolve", "tests", "catalog"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", folder)
        for module in given.modules:
            found = mutants(module)
            if given.sample is not None and given.sample < len(found):
                found = random.Random(given.seed).sample(found, given.sample)
            for mutant in found:
                if time.monotonic() - start > given.seconds:
                    break
                if (mutant.line, mutant.change) in HARMLESS.get(module, {}):
                    continue
                count += 1
                by = killed(mutant, folder, given.limit)
                if not by:
                    survivors.append(mutant)
                mark = "killed  " if by else "SURVIVED"
                print(f"{mark} {module}:{mutant.number} {mutant.change} | {mutant.line} | {by[:90]}", flush=True)
    print(f"{count} mutants, {len(survivors)} survivors")
    for mutant in survivors:
        print(f"  {mutant.module}:{mutant.number} {mutant.change} | {mutant.line}")
    return int(bool(survivors))


if __name__ == "__main__":
    sys.exit(main())
