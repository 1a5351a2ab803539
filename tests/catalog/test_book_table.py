"""docs/book.md says what the checks say now."""

from tests.support import book_table


def test_the_page_is_current() -> None:
    """Run `python -m tests.support.book_table` after a change of the entries or of the checks."""
    assert book_table.PAGE.read_text(encoding="utf-8") == book_table.page()


def test_the_page_has_every_row_once() -> None:
    text = book_table.PAGE.read_text(encoding="utf-8")
    assert [line.split(" | ")[0][2:] for line in text.splitlines() if line.startswith("| C")] == list(book_table.ROWS)
    assert len(book_table.ROWS) == 102
    assert len(book_table.REFUSED_ROWS) == 29
    assert len(book_table.EXTENDED_ROWS) == 10


def test_every_row_has_an_entry_and_every_row_but_one_a_result() -> None:
    """C05, the hollow sphere, is only described by the book."""
    rows = [
        line.split(" | ") for line in book_table.PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| C")
    ]
    assert all(entry != "–" and verdict != "–" for _, entry, verdict, *_ in rows)
    assert {row[2:] for row, _, _, checked, _ in rows if not checked.isdigit()} == book_table.WITHOUT_RESULT
