"""A process that answers questions, with a limit on the time and the memory of each.

Whatever a question does (a formula that fills the memory, an integral that does not end), it does there: the process is
ended and another one begun, and who asked is told so in a line.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import threading
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from hjsolve.errors import of_kind, required
from hjsolve.explorer.question import PageAnswer, PageQuestion

_BEGINNING, _ENDING = 60.0, 5.0
"""Seconds that the engine may take to be imported, and a process to end that has closed its connection."""
_OUT_OF_MEMORY, _WITHOUT_SERVER = 75, 76
"""Exit statuses of the process."""


class Worker:
    """One process.

    Attributes:
        seconds: one question may take.
        megabytes: it may take next to what the engine itself needs.
    """

    def __init__(self, seconds: float, megabytes: int):
        self.seconds, self.megabytes = seconds, megabytes
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None

    def begin(self) -> None:
        """Start the process, and wait until it has imported the engine."""
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe()
        process = context.Process(target=_answer_all, args=(there, self.megabytes), daemon=True)
        process.start()
        there.close()
        self._process, self._connection = process, here
        try:
            ready = here.poll(_BEGINNING) and here.recv() == "ready"
        except (EOFError, OSError):  # it ended, or this server does
            ready = False
        if not ready:
            self.end()

    def ready(self) -> None:
        """Start the process where there is none."""
        if self._process is None or not self._process.is_alive():
            self.begin()

    def ask(self, question: PageQuestion) -> PageAnswer:
        """Answer, or say which limit it went over."""
        self.ready()
        connection = self._connection
        if connection is None:
            return PageAnswer(problem="the process that computes could not be started")
        try:
            connection.send(question)
            if connection.poll(self.seconds):
                return of_kind(connection.recv(), PageAnswer)
        except (EOFError, OSError):
            why = self._cause()
            self.end()
            return PageAnswer(problem=why)
        self.end()
        return PageAnswer(problem=f"this took more than {self.seconds:g} s, and was stopped; make it simpler")

    def _cause(self) -> str:
        """Say why the process has ended."""
        process = required(self._process)
        process.join(_ENDING)
        code = process.exitcode
        if code == _OUT_OF_MEMORY:
            return f"this took more than {self.megabytes} MB of memory, and was stopped"
        if code is not None and code < 0:
            name = signal.Signals(-code).name if -code in set(signal.Signals) else str(-code)
            return f"the process that computes was ended by the signal {name}, not by hjsolve; ask again"
        return f"the process that computes ended with status {code}; ask again"

    def end(self) -> None:
        """End the process, whatever it does."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
        if self._connection is not None:
            self._connection.close()
        self._process = self._connection = None


class Workers:
    """Some processes, each asked one question at a time."""

    def __init__(self, count: int, seconds: float, megabytes: int):
        self._all = [Worker(seconds, megabytes) for _ in range(count)]
        self._free: asyncio.Queue[Worker] = asyncio.Queue()
        self._beginning = set[asyncio.Task[None]]()
        for worker in self._all:
            self._free.put_nowait(worker)

    async def begin(self) -> None:
        """Start the processes, so that the first question does not wait for them."""
        for _ in self._all:
            self._return(self._free.get_nowait())

    def _return(self, worker: Worker) -> None:
        """Let a process take questions again, as soon as it is there."""

        async def ready() -> None:
            try:
                await asyncio.to_thread(worker.ready)
            finally:
                self._free.put_nowait(worker)

        task = asyncio.create_task(ready())
        self._beginning.add(task)
        task.add_done_callback(self._beginning.discard)

    async def ask(self, question: PageQuestion) -> PageAnswer:
        """Answer as soon as a process is free.

        Args:
            question: what was typed.
        """
        worker = await self._free.get()
        try:
            return await asyncio.to_thread(worker.ask, question)
        finally:
            self._return(worker)

    def end(self) -> None:
        """End all processes."""
        for worker in self._all:
            worker.end()


# ------------------------------------------------------------------------------------------- in the process itself
def _answer_all(connection: Connection, megabytes: int) -> None:
    from hjsolve.errors import FAULTS, HJSolveError
    from hjsolve.explorer.answering import answer_question

    threading.Thread(target=_end_with_server, daemon=True).start()
    _warm()
    _limit(megabytes)
    connection.send("ready")
    while True:
        try:
            question = connection.recv()
        except EOFError:
            return
        try:
            answered = answer_question(question)
        except MemoryError:
            os._exit(_OUT_OF_MEMORY)
        except HJSolveError as error:
            answered = PageAnswer(problem=" ".join(str(error).split()))
        except FAULTS as error:  # a fault of ours must not end the page of who found it
            fault = f"{type(error).__name__}: {error}"
            answered = PageAnswer(problem=f"a fault of hjsolve itself, please report it: {fault}")
        connection.send(answered)


def _end_with_server() -> None:
    """End this process once the server is gone, whatever is being computed."""
    server = multiprocessing.parent_process()
    if server is not None:
        server.join()
        os._exit(_WITHOUT_SERVER)


def _warm() -> None:
    """Import what the first question would wait for."""
    from hjsolve.explorer.answering import answer_question
    from hjsolve.explorer.first_question import question_about

    answer_question(question_about(None))


def _limit(megabytes: int) -> None:
    """Limit the memory to what is in use now and so much more, where the system can."""
    try:
        import resource

        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except (ImportError, OSError):
        return
    most = used + megabytes * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
