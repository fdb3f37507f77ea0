"""Objects as keys of remembered results, for objects whose comparison would take as long as computing
again."""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")


class Itself(Generic[T]):
    """Object as a key of remembered results: equal to itself alone, so that worlds of thousands of corners
    are not compared.

    Args:
        it: the object, which must not change; it lives as long as the key.
    """

    __slots__ = ("it",)

    def __init__(self, it: T) -> None:
        self.it = it

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Itself) and self.it is other.it

    def __hash__(self) -> int:
        return id(self.it)
