"""How many examples a property test tries: as many as it says in the usual run, ten times as many under ``-m fuzz``.

A test that says nothing tries hypothesis' hundred, or ten hundred.
"""

from __future__ import annotations

from typing import Any

from hypothesis import settings

MORE = 10  # times as many examples with fresh seeds as with fixed ones

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.register_profile("fuzz", derandomize=False, deadline=None, print_blob=True, max_examples=100 * MORE)


def load_profile(mark_expression: str) -> None:
    """Load the profile of ``-m fuzz``, fresh seeds, for exactly that mark expression; fixed seeds for any other."""
    settings.load_profile("fuzz" if mark_expression == "fuzz" else "fixed")


def examples(count: int, **others: Any) -> settings:
    """Try that many examples in the usual run; other settings are hypothesis' own.

    It reads the loaded profile when a test is decorated: ``conftest.py`` loads it before test files are imported.
    """
    more = MORE if settings.get_current_profile_name() == "fuzz" else 1
    return settings(max_examples=more * count, **others)
