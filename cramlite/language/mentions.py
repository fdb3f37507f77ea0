"""Things that earlier parts of a sentence named, and the things that a noun phrase refers to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.value import Value
from ..model.entity_name import thing_of
from .refusal import listed

if TYPE_CHECKING:
    from .english import Words


class Referents(Value):
    """Referents: the things that a noun phrase refers to.

    Args:
        said: the description.
        names: of the things.
        some: how many of them will do; 0 where all are meant.
    """

    said: str
    names: tuple[str, ...]
    some: int = 0

    @property
    def listed(self) -> str:
        """Names of the referents as a list in words: "a, b and c"."""
        return listed([*self.names], "or" if self.some else "and")


class Mentions(Value):
    """Things that the requests and statements so far in a sentence have named.

    Args:
        themes, places: of each clause, the first one first.
        words: by which a thing was called last.
        earlier: by which another was called before.
        where: by which a place was called last.
        put: what was put somewhere.
        some: themes of which any were meant, with how many.
        two: the last two things that were named, to which "the former" and "the latter" refer.
    """

    themes: tuple[tuple[str, ...], ...] = ()
    places: tuple[tuple[str, ...], ...] = ()
    words: Words = ()
    earlier: Words = ()
    where: Words = ()
    put: frozenset[str] = frozenset()
    some: frozenset[tuple[tuple[str, ...], int]] = frozenset()
    two: tuple[str, ...] = ()

    @property
    def every(self) -> frozenset[str]:
        """Names of all things that the sentence has named so far."""
        return frozenset(thing_of(n) for group in (*self.themes, *self.places) for n in group)
