"""Mappings of hand-written files as pydantic models: unknown keys, truth values for numbers and infinite
numbers are refused."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, field_validator

LONGEST_NAME = 100
"""Largest length of a name [characters], since names appear in lines for people and in file names."""
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=LONGEST_NAME)]


class Spec(BaseModel):
    """Base class for the data of a hand-written file: it refuses unknown keys and wrong numbers.

    Wrong numbers are ``.nan``, ``.inf``, and ``true`` or ``false``, which pydantic alone reads as 1 or 0.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    @field_validator("*", mode="wrap")
    @classmethod
    def _numbers_are_numbers(cls, value: Any, read: Callable[[Any], Any]) -> Any:
        found = read(value)
        _refuse_no_number(value, found)
        return found


def read_value(kind: Any, value: Any) -> Any:
    """Convert a value to a type; refuse infinite numbers, and truth values in the place of numbers.

    Args:
        kind: a type, or ``Length`` and the like.

    Raises:
        pydantic.ValidationError: it is not of the type.
        ValueError: it is or holds what is not finite, or a truth value where the type asks for a number.
    """
    found = TypeAdapter(kind).validate_python(value)
    _refuse_no_number(value, found)
    return found


def _refuse_no_number(written: Any, found: Any, name: str = "this") -> None:
    """Refuse a number that is not finite, and a truth value in the place of a number.

    Raises:
        ValueError: it was, or something in it.
    """
    if isinstance(written, float) and not math.isfinite(written):
        raise ValueError(f"{name} is {written}, which is not finite; it should be a number")
    if isinstance(written, bool) and not isinstance(found, bool):
        raise ValueError(f"{name} is {str(written).lower()}; it should be a number")
    if isinstance(written, list | tuple) and isinstance(found, list | tuple):
        for one, other in zip(written, found, strict=False):
            _refuse_no_number(one, other, name)
    elif isinstance(written, Mapping) and isinstance(found, Mapping):
        for key in written.keys() & found.keys():
            _refuse_no_number(written[key], found[key], f"'{key}'")
