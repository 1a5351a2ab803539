"""What a user can import says what it takes, what it gives and when it fails."""

from __future__ import annotations

import inspect

import pytest

import hjsolve

CALLABLES = [
    name
    for name in hjsolve.__all__
    if callable(getattr(hjsolve, name))
    and not (inspect.isclass(getattr(hjsolve, name)) and issubclass(getattr(hjsolve, name), Exception))
]
FUNCTIONS = [name for name in CALLABLES if inspect.isfunction(getattr(hjsolve, name))]
VALUES = [name for name in CALLABLES if inspect.isclass(getattr(hjsolve, name))]


@pytest.mark.parametrize("name", sorted(hjsolve.__all__))
def test_every_public_name_has_a_docstring(name: str) -> None:
    if name != "__version__":
        assert (inspect.getdoc(getattr(hjsolve, name)) or "").strip()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_tell_arguments_returns_and_errors(name: str) -> None:
    text = inspect.getdoc(getattr(hjsolve, name)) or ""
    parameters = list(inspect.signature(getattr(hjsolve, name)).parameters)
    for heading in (["Args:"] if parameters else []) + ["Returns:", "Raises:"]:
        assert heading in text, f"{name} lacks {heading}"
    for parameter in parameters:
        assert parameter in text, f"{name} does not tell about {parameter}"


@pytest.mark.parametrize("name", VALUES)
def test_values_tell_their_fields(name: str) -> None:
    value = getattr(hjsolve, name)
    text = inspect.getdoc(value) or ""
    for field in getattr(value, "__dataclass_fields__", {}):
        if not field.startswith("_"):
            assert field in text, f"{name} does not tell about {field}"
