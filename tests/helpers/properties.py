"""How many examples a property test tries: the number that it states, a quarter of that in the usual run, ten times that under
``-m fuzz``.

A test that states none has hypothesis' hundred. The usual run is the one that leaves out what is heavy; ``.ci/run`` tries the stated
number, with the same fixed seeds.
"""

from __future__ import annotations

from typing import Any

from hypothesis import settings

USUAL = "not heavy"
"""Mark expression of the usual run (``addopts`` of ``pyproject.toml``)."""
FEWER = 4  # a test tries the stated number divided by this in the usual run
MORE = 10  # times as many examples with fresh seeds as stated
DEFAULT = 100  # examples of a test that states no number

settings.register_profile("usual", derandomize=True, deadline=None, max_examples=DEFAULT // FEWER)
settings.register_profile("stated", derandomize=True, deadline=None, max_examples=DEFAULT)
settings.register_profile("fuzz", derandomize=False, deadline=None, print_blob=True, max_examples=DEFAULT * MORE)


def load_profile(mark_expression: str) -> None:
    """Load hypothesis' profile for a mark expression: fresh seeds for exactly ``fuzz``, fixed seeds for any other."""
    settings.load_profile({"fuzz": "fuzz", USUAL: "usual"}.get(mark_expression, "stated"))


def examples(count: int, **others: Any) -> settings:
    """Return hypothesis settings with the number of examples that a test tries, scaled by the loaded profile.

    It reads the loaded profile when a test is decorated: ``conftest.py`` loads it before test files are imported.
    """
    share = settings().max_examples / DEFAULT
    return settings(max_examples=max(1, round(share * count)), **others)
