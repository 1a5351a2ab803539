"""Which tests go to one process together."""

import pytest

from tests.conftest import scope_of


@pytest.mark.parametrize(("nodeid", "scope"), [
    ("tests/catalog/test_reference_values.py::test_x[kepler-planar-period.r-default]", "kepler-planar"),
    ("tests/catalog/test_reference_values.py::test_x[kepler-planar-default]", "kepler-planar"),
    ("tests/catalog/test_every_entry.py::test_y[pendulum-on-block-small]", "pendulum-on-block-small"),
    ("tests/catalog/test_every_entry.py::test_y[pendulum+drag]", "pendulum"),
    ("tests/laws/test_involution.py::test_z[pendulum]", "pendulum"),
    ("tests/laws/test_liouville.py::test_z[top, C52]", "top, C52]"),
    ("tests/catalog/test_book_chapter_1.py::test_r[C09 (1-78): Each]", "book"),
    ("tests/catalog/test_book_table.py::test_the_page_is_current", "book"),
    ("tests/ensembles/test_claims.py::test_u[actions-False]", "tests/ensembles/test_claims.py::test_u[actions-False]"),
    ("tests/reports/test_reports.py::test_z[pendulum]", "reports"),
    ("tests/regressions/test_0039_reports_that_can_be_read.py::test_z", "reports"),
    ("tests/reports/test_reports.py::test_every_entry_x[kerr]", "tests/reports/test_reports.py::test_every_entry_x[kerr]"),
    ("tests/display/test_values_in_notebooks.py::test_z", "values"),
    ("tests/architecture/test_types.py::test_z[motion]", "sources"),
    ("tests/closed_form/test_borders.py::test_v[pendulum-10]", "forms of pendulum"),
    ("tests/closed_form/test_elliptic_forms.py::test_v[1]", "tests/closed_form/test_elliptic_forms.py::test_v[1]"),
    ("tests/command_line/test_command_line.py::test_w[pendulum]", "tests/command_line/test_command_line.py::test_w[pendulum]"),
])  # fmt: skip
def test_tests_of_one_entry_share_a_process(nodeid: str, scope: str) -> None:
    assert scope_of(nodeid) == scope
