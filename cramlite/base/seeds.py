"""Seeds of random numbers: each designator or twin has a seed of its own, so that its draws do not depend on earlier
ones."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from operator import index
from typing import SupportsIndex

from .errors import UserError


def derive_seed(seed: int, choices: Iterable[tuple[str, str]], name: str) -> int:
    """Derive the seed of one random draw from the search's seed, the choices made before, and the draw's name (blake2b:
    the same on every platform)."""
    text = repr((seed, tuple(choices), name)).encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=4).digest(), "big") & 0x7FFFFFFF


def whole_seed(seed: object) -> int:
    """Check that a given seed is a whole number of at least 0, and return it.

    Raises:
        UserError: it is no whole number from 0.
    """
    if not isinstance(seed, SupportsIndex) or isinstance(seed, bool) or index(seed) < 0:
        raise UserError(f"The seed is {seed!r}; it must be a whole number: 0 (the world as written) or more.")
    return index(seed)
