"""Reading a TOML file: everything that can be wrong with it before its first key is one line that names the file."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from decimal import Decimal
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeAlias

from hjsolve.catalog.regular_files import bytes_of
from hjsolve.errors import CatalogError, InvalidInputError

LONGEST = 1_000_000
"""Bytes of a file: far more than any entry or scene has."""
_MOST_PARTS = 50
_DEEP_KEY = re.compile(rf"(?<![\w\"'.-])(?:[\w\"'-]++[ \t]*+\.[ \t]*+){{{_MOST_PARTS}}}")
"""Parts of a dotted key or header; tomllib needs a time that grows with their square."""
TomlTable: TypeAlias = dict[str, Any]
"""A table of a TOML file: texts, whole numbers, ``Decimal``, truth values, lists, tables; ``schema`` checks them."""
Toml: TypeAlias = Mapping[str, Any]
"""The same, to be read only."""


def exact_table(file: Traversable, source: str) -> TomlTable:
    """Read a file whole; decimals stay exact.

    Args:
        source: what it is called in errors.

    Raises:
        CatalogError: the file cannot be read, is too long, is not UTF-8 text, or no TOML.
    """
    try:
        data = bytes_of(file, LONGEST, shown=source) if isinstance(file, Path) else file.read_bytes()
        text = data.decode("utf-8")
        if _DEEP_KEY.search(text):
            raise InvalidInputError(f"{source}: holds a key of {_MOST_PARTS} parts or more")
        return tomllib.loads(text, parse_float=Decimal)
    except InvalidInputError as error:
        raise CatalogError(f"{error}; an entry or a scene is a few pages of text") from error
    except FileNotFoundError as error:
        cure = "give the path of a .toml file, or an id that `hjsolve catalog` lists"
        raise CatalogError(f"{source}: there is no such file here; {cure}") from error
    except OSError as error:
        raise CatalogError(f"{source}: cannot be read ({error.strerror or type(error).__name__})") from error
    except UnicodeDecodeError as error:
        raise CatalogError(f"{source}: is not UTF-8 text (byte {error.start})") from error
    except tomllib.TOMLDecodeError as error:
        raise CatalogError(f"{source}: is not TOML: {' '.join(str(error).split())}") from error
    except ValueError as error:  # an integer of more digits than Python reads
        raise CatalogError(f"{source}: holds an integer of thousands of digits; choose other units") from error
    except RecursionError as error:
        raise CatalogError(f"{source}: tables or lists nested too deeply") from error
