"""Commands, options and words that the command line does not take: one line that says what to write instead."""

from __future__ import annotations

import argparse
import difflib
import re
from collections.abc import Sequence
from typing import NoReturn

from hjsolve.command_line.examples import EXAMPLES
from hjsolve.errors import InvalidInputError


class StrictParser(argparse.ArgumentParser):
    """An argument parser whose complaints are one line, as all errors here are."""

    def error(self, message: str) -> NoReturn:
        """Raise what argparse complains of, with what to write instead."""
        word = re.match(r"argument (COMMAND|action): invalid choice: '(.*?)'", message)
        if word and word[1] == "COMMAND":
            near = difflib.get_close_matches(word[2], EXAMPLES, n=1, cutoff=0.7)
            cure = f"did you mean `hjsolve {near[0]}`?" if near else f"for a system write `hjsolve check {word[2]}`"
            message = f"'{word[2]}' is not a command; {cure}"
        elif word:
            message = f"{message}; to search write `{self.prog} search {word[2]}`"
        else:
            message = _spoken(message)
        raise InvalidInputError(f"{message}; see `{self.prog} --help`")

    def parse_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        """Parse a command line; what the command does not take is refused, with the nearest that it takes."""
        options, rest = self.parse_known_args(args, namespace)
        if rest:
            word = rest[0].partition("=")[0] if rest[0].startswith("-") else rest[0]
            taken = _options_by_command(self)
            known = taken[options.command] if word.startswith("-") else ()
            begins = [name for name in known if name.startswith(word) and len(word) > 3]
            near = begins or difflib.get_close_matches(word, known, n=1, cutoff=0.6)
            others = ", ".join(name for name, options_of in taken.items() if word in options_of)
            cure = f"did you mean {near[0]}?" if near else f"it belongs to {others}" if others else "leave it out"
            command = f"hjsolve {options.command}"
            raise InvalidInputError(f"`{command}` does not take {word}; {cure}; see `{command} --help`")
        return options


def _spoken(message: str) -> str:
    """Return a complaint of argparse with what to write instead."""
    if found := re.match(r"argument (\S+): invalid (int|float) value: (.*)", message):
        return f"{found[1]}: a {'whole ' if found[2] == 'int' else ''}number is needed, not {found[3]}"
    if message == "the following arguments are required: -o/--output":
        return "where should it be written? add -o FILE, such as -o report.html"
    if found := re.match(r"argument (\S+): expected one argument", message):
        option = found[1].rpartition("/")[2]
        return f"{option}: its value is missing; write it after {option}"
    return message


def _options_by_command(top: argparse.ArgumentParser) -> dict[str, list[str]]:
    kinds = next(action for action in top._actions if isinstance(action, argparse._SubParsersAction))
    return {name: list(parser._option_string_actions) for name, parser in kinds.choices.items()}
