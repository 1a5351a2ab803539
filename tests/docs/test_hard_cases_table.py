"""The page of the hard cases has a row for every case."""

from __future__ import annotations

from tests.support.hard_cases import cases
from tests.support.hard_table import PAGE, PEERS
from tests.support.hard_turning import turning


def test_every_case_has_its_row() -> None:
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    names = {line.split("|")[1].strip() for line in rows}

    assert {case.name for case in (*cases(), *turning())} <= names, "run: python -m tests.support.hard_table"


def test_every_figure_of_a_peer_stands_beside_a_case() -> None:
    assert PEERS.keys() <= {case.name for case in (*cases(), *turning())}
