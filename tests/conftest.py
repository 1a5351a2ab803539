"""Hypothesis profiles, which tests are left for the night, and which share a process where there are several."""

import gc
import os
import re
import sys
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from tests.support import rotation

settings.register_profile("dev", max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", parent=settings.get_profile("dev"), max_examples=100, derandomize=True)
settings.register_profile("nightly", parent=settings.get_profile("dev"), max_examples=5000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci" if os.environ.get("CI") else "dev"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let a rotation be chosen by hand."""
    parser.addoption(
        "--rotation",
        type=int,
        metavar="N",
        help="which part of the long lists runs, -1 for all; of the commit if not given",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Settle the rotation once: the processes of pytest-xdist receive the options of the first one."""
    # looking for circles among thousands of tests and formulas took a seventh of the time
    gc.set_threshold(50_000, 20, 50)
    if config.option.rotation is None:
        config.option.rotation = rotation.of_the_commit()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave cases of long lists for the night, before ``-m "not nightly"`` deselects what is marked so."""
    rotation.leave_the_rest(items, config.option.rotation)


def pytest_collection_finish() -> None:
    """What was collected stays to the end: circles are not looked for in it."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    """Close what a test drew: pyplot keeps figures open, and the next test of the process would count them as its own."""
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say how to run the same cases again."""
    terminalreporter.write_line(f"The same cases of the long lists run again with --rotation={config.option.rotation}")


_TOGETHER = {
    "reports": r"tests/(reports/test_(reports\.py(?!.*every_entry)|abbreviations|closed_form_sections)|regressions/test_00(35|37|39)_)",
    "values": r"tests/display/test_values_in_notebooks",
    "sources": r"tests/architecture/test_(shape_of_the_code|types|docstrings|clocks|circles)",
}
"""Files whose tests share something that takes seconds to make."""


def scope_of(nodeid: str) -> str:
    """What a test shares with others; itself where that is nothing.

    An entry of the catalog, or its closed forms; a system of the laws; the book's results; the reports; the sources.
    """
    file, _, parameter = nodeid.partition("[")
    if "/catalog/test_book_" in file:
        return "book"
    for scope, files in _TOGETHER.items():
        if re.match(files, nodeid):
            return scope
    if not (shared := re.match(r"tests/(catalog|laws|closed_form)/", file)):
        return nodeid
    entry = rotation.entry_of(nodeid)
    if shared[1] == "closed_form":
        return f"forms of {entry}" if entry else nodeid
    return entry or (parameter or nodeid)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """With several processes, tests that share a scope go to one of them: what they share is made once."""
    if config.getoption("dist") != "load":
        return None
    from xdist.scheduler.loadscope import LoadScopeScheduling

    class ByScope(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return scope_of(nodeid)

    return ByScope(config, log)
