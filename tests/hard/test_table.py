"""The page of the hard cases has a row for every case."""

from __future__ import annotations

from tests.hard.cases import cases
from tests.hard.table import PAGE, PEERS
from tests.hard.turning import turning


def test_every_case_has_its_row() -> None:
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    names = {line.split("|")[1].strip() for line in rows}

    assert {case.name for case in (*cases(), *turning())} <= names, "run: python -m tests.hard.table"


def test_every_figure_of_a_peer_stands_beside_a_case() -> None:
    assert PEERS.keys() <= {case.name for case in (*cases(), *turning())}
