"""``hjsolve setup`` compiles every kernel of ensembles, so that no call does it afterwards."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("numba")

RUN = """
import importlib, pkgutil
from numba.core.dispatcher import Dispatcher
import hjsolve.ensembles.engine.kernels as folder
from hjsolve.arithmetic.machine import compiling
from hjsolve.ensembles.kernels_on_disk import compile_kernels
compile_kernels()
for one in pkgutil.iter_modules(folder.__path__):
    for name, found in vars(importlib.import_module(f"{folder.__name__}.{one.name}")).items():
        if isinstance(found, Dispatcher) and found.__module__ == compiling.__name__:
            print(f"{one.name}.{name}", len(found.signatures))
"""


@pytest.mark.nightly
def test_no_kernel_is_left_to_its_first_use() -> None:
    done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True)
    compiled = dict(line.split() for line in done.stdout.splitlines())
    assert len(compiled) > 10
    assert not [name for name, signatures in compiled.items() if signatures == "0"]
