"""What is imported, and when: a cold start pays only for what it uses."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("sympy", "numpy", "mpmath", "matplotlib", "scipy", "numba", "flint", "dask")


def loaded_by(code: str) -> set[str]:
    script = f"{code}\nimport sys\nprint('LOADED', *sorted({{name.partition('.')[0] for name in sys.modules}}))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    return set(run.stdout.rpartition("LOADED")[2].split())


@pytest.mark.parametrize("code", ["import hjsolve", "import hjsolve.command_line.main", "import hjsolve.errors"])
def test_importing_loads_nothing_heavy(code: str) -> None:
    assert loaded_by(code).isdisjoint(HEAVY)


def test_help_loads_nothing_heavy() -> None:
    code = "import contextlib, io, hjsolve.command_line.main\nwith contextlib.redirect_stdout(io.StringIO()): hjsolve.command_line.main.main(['check', '--help'])"
    assert loaded_by(code).isdisjoint(HEAVY)


def test_checking_a_system_needs_no_numpy() -> None:
    code = "import contextlib, io, hjsolve.command_line.main\nwith contextlib.redirect_stdout(io.StringIO()): hjsolve.command_line.main.main(['check', 'kepler-planar'])"
    loaded = loaded_by(code)
    assert "sympy" in loaded
    assert "numpy" not in loaded


def test_every_public_name_exists_and_nothing_else_does() -> None:
    import hjsolve

    assert all(getattr(hjsolve, name) is not None for name in hjsolve.__all__)
    with pytest.raises(AttributeError, match="no attribute 'solves'"):
        _ = hjsolve.solves


def test_the_lazy_names_are_the_names_that_type_checkers_see() -> None:
    import ast
    from pathlib import Path

    import hjsolve

    tree = ast.parse(Path(hjsolve.__file__).read_text(encoding="utf-8"))
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {alias.asname for node in guarded.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert seen | {"__version__"} == set(hjsolve.__all__)
