"""Seeds: every query draws from a seed of its own, so that what is asked before it changes nothing."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from operator import index
from typing import SupportsIndex

from .errors import UserError


def derive_seed(seed: int, choices: Iterable[tuple[str, str]], name: str) -> int:
    """A seed for one query, from the run's seed and the choice path: blake2b, so that it is the same everywhere."""
    text = repr((seed, tuple(choices), name)).encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=4).digest(), "big") & 0x7FFFFFFF


def whole_seed(seed: object) -> int:
    """A seed that somebody gave.

    Raises:
        UserError: it is no whole number from 0.
    """
    if not isinstance(seed, SupportsIndex) or isinstance(seed, bool) or index(seed) < 0:
        raise UserError(f"The seed is {seed!r}; it is a whole number: 0 (the world as written) or more.")
    return index(seed)
