"""Base class of all values: immutable, equal if their fields are, and quick to define (https://jcristharif.com/msgspec/structs.html)."""

from __future__ import annotations

from inspect import Parameter, Signature
from typing import Any, TypeVar, dataclass_transform

import msgspec.structs
from msgspec import NODEFAULT, Struct, StructMeta, field


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class _ValueMeta(StructMeta):
    __match_args__: tuple[str, ...]
    __mro__: tuple[type, ...]

    @property
    def __signature__(cls) -> Signature:
        """Signature of the class with its annotations as they are written in the source, not evaluated.

        msgspec's own evaluates the annotations, and fails at names that are there for type checkers only.
        """
        names, defaults = cls.__struct_fields__, cls.__struct_defaults__
        notes = {n: a for c in reversed(cls.__mro__) for n, a in vars(c).get("__annotations__", {}).items()}
        given = [NODEFAULT] * (len(names) - len(defaults)) + list(defaults)
        return Signature([_parameter(cls, n, notes[n], d) for n, d in zip(names, given, strict=True)])


def _parameter(cls: _ValueMeta, name: str, note: str, default: Any) -> Parameter:
    kind = Parameter.POSITIONAL_OR_KEYWORD if name in cls.__match_args__ else Parameter.KEYWORD_ONLY
    return Parameter(name, kind, annotation=note, default=Parameter.empty if default is NODEFAULT else default)


class Value(Struct, frozen=True, metaclass=_ValueMeta):
    """Immutable value with fields by annotation, as a frozen dataclass has; ``replace`` makes a changed copy."""


V = TypeVar("V", bound=Struct)


def replace(value: V, **changes: Any) -> V:
    """Return a copy of a value with some of its fields changed.

    Raises:
        TypeError: it has no such field.
    """
    return msgspec.structs.replace(value, **changes)
