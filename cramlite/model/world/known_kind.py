"""Object models of a library, described for people, and the files that could not become object models."""

from __future__ import annotations

from ...base.value import Value
from ..geometry import Vector3
from .looks import Looks


class KnownKind(Value):
    """Object model of a library, described for people.

    Args:
        name: of the object model.
        file: that it comes from.
        extents: of the box around it [m].
        triangles: of what it looks like.
        texture: (width, height) of its largest image [pixel]; None if it has none.
        mass: [kg], None where it is fixed; ``mass_source``: where that comes from, in a clause.
        joints: names and ranges, in words.
        up: the direction that usually points up, in words, and who says so.
        notes: what was changed.
        looks: words for its shape and colours.
        kept: whether the library had it already, from the same files.
    """

    name: str
    file: str
    extents: Vector3
    triangles: int
    texture: tuple[int, int] | None
    mass: float | None
    mass_source: str
    joints: tuple[str, ...] = ()
    up: str = ""
    notes: tuple[str, ...] = ()
    kept: bool = False
    looks: Looks = Looks()


class BuiltLibrary(Value):
    """Library of object models that was made or extended, with the files that were refused.

    Args:
        kinds: those of the folders that were added.
        refused: file -> why it is no kind, in a sentence.
        parts: how many files belong to kinds of other files.
    """

    kinds: tuple[KnownKind, ...]
    refused: dict[str, str]
    parts: int = 0
