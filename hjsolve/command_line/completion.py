"""Completion of commands in a shell: the options of the parser, files, and the ids of the catalog."""

from __future__ import annotations

import argparse

from hjsolve.command_line.parser import command_parser
from hjsolve.errors import MissingExtraError

_FILES = ("output", "scene")


def completion_script(shell: str) -> str:
    """Write the script.

    Args:
        shell: bash, zsh, tcsh, fish or powershell.

    Returns:
        Its text, to be put where the shell looks for it.

    Raises:
        MissingExtraError: the extra ``completion`` is not installed.
    """
    try:
        import shtab
    except ImportError as error:
        raise MissingExtraError(
            "completion needs the extra completion; install it with pip install 'hjsolve[completion]'"
        ) from error
    from hjsolve import catalog

    top = command_parser()
    for command in _commands(top):
        for action in command._actions:
            if action.dest in _FILES:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
            elif action.dest in {"system", "entry"} and action.choices is None:
                action.choices = catalog.ids()
    return str(shtab.complete(top, shell))


def _commands(top: argparse.ArgumentParser) -> list[argparse.ArgumentParser]:
    groups = [action.choices for action in top._actions if isinstance(action.choices, dict)]
    return [command for group in groups for command in group.values()]
