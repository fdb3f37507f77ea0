"""Names of things and of their parts: "hook" is a thing, "hook/peg" a part of it.

Texts, YAML, JSON and mappings from names to values use this notation. It is read and written here and nowhere else.
"""

from __future__ import annotations

from ..base.value import Value

BETWEEN = "/"
"""Separator between the name of a thing and the name of its part. The names of things and robots in a world do not contain it."""


class EntityName(Value):
    """Name of a thing, or of a part of it; ``str()`` is its notation.

    Args:
        thing: the whole.
        part: a feature, a finger, a link, ...; "" for the thing itself.
    """

    thing: str
    part: str = ""

    @classmethod
    def parse(cls, notation: str) -> EntityName:
        """Split the name of an entity, such as "rack/peg", at its first "/" into the thing and its part."""
        thing, _, part = notation.partition(BETWEEN)
        return cls(thing, part)

    def __str__(self) -> str:
        return f"{self.thing}{BETWEEN}{self.part}" if self.part else self.thing


def thing_of(notation: str) -> str:
    """Return the thing that a name refers to, by itself or by a part: "hook" for "hook" and "hook/peg"."""
    return notation.partition(BETWEEN)[0]
