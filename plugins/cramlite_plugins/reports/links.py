"""Links of the report page: from a program line or a finding to the decision that it came from, and from decisions to
program lines."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from cramlite.model import enclosing_names

from .decisions import attempts
from .readings import number_of

if TYPE_CHECKING:
    from cramlite import Finished
    from cramlite.plugin import Code

COMMENTS = ("#", "//", ";")
"""Beginnings of comment lines in the languages of robots."""


def targets(done: Finished) -> frozenset[str]:
    """Return the designators to which a link on the report page can lead: those decided for the shown
    candidate, and those of camera pictures."""
    decided = {d.asked.designator for a in attempts(done.trace) if a.number == number_of(done) for d in a.decisions if d.asks}
    looks = done.setting.look.pictures if done.setting.look is not None else ()
    return frozenset(decided | {look_name(k) for k, _ in enumerate(looks, 1)})


def look_name(number: int) -> str:
    """Return the name of the task that takes the picture of a number, such as "0.LookingFor_2" for the
    second picture.

    cramlite.perception.active_perception gives these names.
    """
    return f"0.LookingFor_{number}"


def target(designator: str, known: Collection[str]) -> str:
    """Return the designator itself if a link on the report page can lead to it, else the nearest enclosing one with a link; "" for none."""
    return next((name for name in enclosing_names(designator) if name in known), "")


def lines_of(steps: Sequence[str]) -> Mapping[str, list[tuple[int, int]]]:
    """Return for each designator the first and last lines of each stretch of program text that came from it.

    Args:
        steps: of each line, what it came from; "" for nothing.
    """
    found: dict[str, list[tuple[int, int]]] = {}
    for number, step in enumerate(steps, 1):
        for name in enclosing_names(step):
            stretches = found.setdefault(name, [])
            if stretches and stretches[-1][1] == number - 1:
                stretches[-1] = (stretches[-1][0], number)
            else:
                stretches.append((number, number))
    return found


def steps_of(code: Code) -> list[str]:
    """Return the origin of each line of a program; a comment or an empty line has that of the next line."""
    texts = code.text.splitlines()
    steps, step = [""] * len(texts), ""
    for k in range(len(texts)):
        step = code.origins.get(k + 1, step)
        steps[k] = step
    for k in range(len(texts) - 2, -1, -1):
        if k + 1 not in code.origins and (not texts[k].strip() or texts[k].lstrip().startswith(COMMENTS)):
            steps[k] = steps[k + 1]
    return steps
