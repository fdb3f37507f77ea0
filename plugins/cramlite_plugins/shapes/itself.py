"""Cache keys that compare objects by identity: comparing contents would take as long as computing the result
anew."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Generic, TypeVar

T = TypeVar("T")
R = TypeVar("R")
LAST = 2
"""Number of latest objects for which a decorated function remembers its results."""


class Itself(Generic[T]):
    """Cache key of an object that is equal to itself alone, so that worlds of thousands of corners are not
    compared.

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


def remembered(function: Callable[[T], R]) -> Callable[[T], R]:
    """Decorate a function to remember its results for the objects of the last calls.

    Neither these objects nor the results may be changed.
    """
    kept: Callable[[Itself[T]], R] = lru_cache(maxsize=LAST)(lambda key: function(key.it))

    @wraps(function)
    def asked(it: T) -> R:
        return kept(Itself(it))

    return asked
