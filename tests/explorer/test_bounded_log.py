"""Forged events write a traceback each; the log takes ten messages a minute and says that it leaves the rest out."""

from __future__ import annotations

import asyncio
import io
import logging

import pytest

from hjsolve.explorer.bounded_log import MOST_MESSAGES, BoundedLog, bound_logs


@pytest.fixture
def log():
    logger, stream = logging.Logger("forged"), io.StringIO()
    logger.addHandler(logging.StreamHandler(stream))
    return logger, stream


def test_a_flood_is_cut_and_the_next_minute_speaks_again(log):
    (logger, stream), now = log, [0.0]
    logger.addFilter(BoundedLog(3, lambda: now[0]))
    for k in range(1000):
        try:
            raise ValueError(k)
        except ValueError:
            logger.exception("no such listener %d", k)
    text = stream.getvalue()
    assert text.count("Traceback") == 3
    assert text.count("more than 3 messages in a minute") == 1
    assert len(text.splitlines()) < 30
    now[0] = 61.0
    logger.error("later")
    assert stream.getvalue().endswith("later\n")


def test_a_message_is_cut(log):
    logger, stream = log
    logger.addFilter(BoundedLog())
    logger.error("%s", "x" * 10**6)
    assert len(stream.getvalue()) < 2100
    assert "998000 more characters" in stream.getvalue()


def test_tasks_that_fail_are_counted_with_the_rest(caplog):
    """An event of socket.io runs in a task of its own; asyncio reports what nobody awaits."""
    bounded = bound_logs(["asyncio"])
    try:

        async def flood() -> None:
            for _ in range(200):
                asyncio.get_running_loop().call_exception_handler({"message": "forged", "exception": KeyError("id")})

        asyncio.run(flood())
        assert len([r for r in caplog.records if r.name == "asyncio" and "forged" in r.getMessage()]) == MOST_MESSAGES
    finally:
        logging.getLogger("asyncio").removeFilter(bounded)
