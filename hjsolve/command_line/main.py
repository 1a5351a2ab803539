"""The command line: arguments in, text out, one exit status. Only argparse is imported before a command is known.

Exit status: 0 an answer · 1 the system does not separate, and the answer is the obstruction · 2 bad input ·
3 undecided, or a number that did not converge.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from typing import Any, TextIO, cast

from hjsolve.command_line import commands, theorem_commands
from hjsolve.command_line.commands import ANSWER, BAD_INPUT, INTERRUPTED, REFUSED, UNSETTLED
from hjsolve.command_line.parser import command_parser
from hjsolve.display.visible_text import visible
from hjsolve.errors import (
    FAULTS,
    ClusterError,
    HJSolveError,
    InternalError,
    InvalidInputError,
    MissingExtraError,
    NotConvergedError,
    NotSeparableError,
)


class VisibleStream:
    """A text stream in front of another one.

    Args:
        stream: where the text goes.
    """

    def __init__(self, stream: TextIO):
        self._stream = stream
        self._failed: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text."""
        try:
            return self._stream.write(visible(text))
        except OSError as error:  # argparse would pass over it
            self._failed = error
            raise

    def flush(self) -> None:
        """Write what is held back.

        Raises:
            OSError: now, or when something was written before.
        """
        if self._failed is not None:
            raise self._failed
        self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


BROKEN_PIPE = 141


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: what follows ``hjsolve`` on the command line; None for the process's own arguments.

    Returns:
        The exit status; see the module's text.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        top = command_parser()
        given = _joined(sys.argv[1:] if arguments is None else arguments, top)
        with redirect_stdout(_output()):
            if given:
                status = _printed(top, given)
            else:
                top.print_help()
                status = BAD_INPUT
            sys.stdout.flush()
    except KeyboardInterrupt:
        return _complain("interrupted; nothing was written", INTERRUPTED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except (NotSeparableError, NotConvergedError) as error:
        return _complain(_with_estimate(error), REFUSED if isinstance(error, NotSeparableError) else UNSETTLED)
    except (InvalidInputError, MissingExtraError) as error:
        return _complain(str(error), BAD_INPUT)
    except ClusterError as error:
        return _complain(str(error), UNSETTLED)
    except OSError as error:
        if error.filename is None and sys.stdout is not None:  # what could not be written is not tried again at the end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _complain(f"{error.filename or 'output'}: {error.strerror or type(error).__name__}", BAD_INPUT)
    except (HJSolveError, *FAULTS) as error:
        return _complain(_fault(error), UNSETTLED)
    return status


def _output() -> TextIO:
    """Return where a command prints; nowhere where the stream is closed, as by ``>&-`` or without a console."""
    return cast("TextIO", VisibleStream(sys.stdout if sys.stdout is not None else io.StringIO()))


def _printed(top: argparse.ArgumentParser, given: Sequence[str]) -> int:
    """Run a command; ``--help`` and ``--version`` of argparse end by an exception."""
    try:
        return _run(top.parse_args(given))
    except SystemExit as exit_request:
        return exit_request.code if isinstance(exit_request.code, int) else ANSWER


def _joined(arguments: Sequence[str], top: argparse.ArgumentParser) -> list[str]:
    """Join an option and its value, so that a value may begin with a minus sign: ``--potential -k/r``.

    After ``--q r=1`` another ``theta=0`` is one more value of that option.
    """
    valued = _valued(top)
    result: list[str] = []
    for argument in arguments:
        last = result[-1] if result else ""
        if last in valued:
            result[-1] += f"={argument}"
        elif last.startswith(_NAMED_VALUES) and _NAMED_VALUE.match(argument):
            result.append(f"{last.partition('=')[0]}={argument}")
        else:
            result.append(valued.get(argument, argument))
    return result


_NAMED_VALUES = ("--q=", "--velocity=", "--momentum=", "--parameter=", "--from=", "--to=")
_NAMED_VALUE = re.compile(r"\w+\s*=")
_ENDLESS_WORD = re.compile(r"\S{300,}")


def _valued(top: argparse.ArgumentParser) -> dict[str, str]:
    """Return the options of all commands that take a value: each way to write one ↦ the long way."""
    commands_of = [action.choices.values() for action in top._actions if isinstance(action.choices, dict)]
    parsers = [top, *(parser for group in commands_of for parser in group)]
    options = [option for parser in parsers for option in parser._actions if option.nargs is None]
    return {spelling: option.option_strings[-1] for option in options for spelling in option.option_strings}


def _run(options: argparse.Namespace) -> int:
    name = f"{options.command.replace('-', '_')}_command"
    return int(getattr(commands if hasattr(commands, name) else theorem_commands, name)(options))


def _complain(message: str, status: int) -> int:
    told = _ENDLESS_WORD.sub(lambda word: f"{word[0][:60]}...{word[0][-20:]}", message)
    if sys.stderr is not None:
        print(f"hjsolve: {visible(told)}", file=sys.stderr)
    return status


def _with_estimate(error: HJSolveError) -> str:
    estimate = getattr(error, "estimate", None)
    return f"{error} (reached: {estimate})" if estimate is not None else str(error)


def _fault(error: BaseException) -> str:
    """Return a fault of ours: one line, and the place of the fault on request."""
    if os.environ.get("HJSOLVE_TRACEBACK"):
        import traceback

        return "".join(traceback.format_exception(error))
    what = str(error) if isinstance(error, InternalError) else f"{type(error).__name__}: {error}"
    how = "please report it with the output of HJSOLVE_TRACEBACK=1 hjsolve …"
    return f"a fault of hjsolve itself ({' '.join(what.split())[:300]}); {how}"
