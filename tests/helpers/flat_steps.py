"""What a decomposition is made of, whatever rules its steps stand under."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cramlite.model import Compound, Designator


def flat(steps: Iterable[Designator]) -> Iterator[Designator]:
    """Yield steps, with the branches of compound steps in place of the compounds."""
    for step in steps:
        yield from flat(p for branch in step.branches for p in branch) if isinstance(step, Compound) else (step,)
