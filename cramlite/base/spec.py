"""Mappings of hand-written files as pydantic models: unknown keys are refused, and truth values where numbers are asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, TypeAdapter, field_validator


class Spec(BaseModel):
    """Mapping of a file; an unknown key is refused, and so is ``true`` in the place of a number, which pydantic by itself reads as 1."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @field_validator("*", mode="wrap")
    @classmethod
    def _no_truth_as_number(cls, value: Any, read: Callable[[Any], Any]) -> Any:
        found = read(value)
        _refuse_truth(value, found)
        return found


def read_value(kind: Any, value: Any) -> Any:
    """Return a value as a type, by the rules of the fields of a ``Spec``.

    Args:
        kind: a type, or ``Length`` and the like.

    Raises:
        pydantic.ValidationError: it is not of the type.
        ValueError: it is a truth value, or holds one, where the type asks for a number.
    """
    found = TypeAdapter(kind).validate_python(value)
    _refuse_truth(value, found)
    return found


def _refuse_truth(written: Any, found: Any, name: str = "this") -> None:
    """Refuse what was written as true or false and was read as something else.

    Raises:
        ValueError: it was, or something in it.
    """
    if isinstance(written, bool) and not isinstance(found, bool):
        raise ValueError(f"{name} is {str(written).lower()}; it should be a number")
    if isinstance(written, list | tuple) and isinstance(found, list | tuple):
        for one, other in zip(written, found, strict=False):
            _refuse_truth(one, other, name)
    elif isinstance(written, Mapping) and isinstance(found, Mapping):
        for key in written.keys() & found.keys():
            _refuse_truth(written[key], found[key], f"'{key}'")
