"""Hierarchical names of designators: "3.Grasping" is a task of a plan, "3.Grasping/approach" a part of it.

Steps of a program carry the name of their designator. The notation is read and written here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator

BETWEEN = "/"


def part_name(whole: str, part: str) -> str:
    """Return the name of a part of a designator: "3.Grasping/approach" for "3.Grasping" and "approach".

    If the whole has no name (""), it is the part's own.
    """
    return f"{whole}{BETWEEN}{part}" if whole else part


def is_part_of(name: str, whole: str) -> bool:
    """Check whether a designator is a part of another one, at any depth."""
    return name.startswith(f"{whole}{BETWEEN}")


def task_of(name: str) -> str:
    """Return the task of the plan that a designator belongs to: "3.Grasping" for "3.Grasping" and "3.Grasping/approach"."""
    return name.partition(BETWEEN)[0]


def enclosing_names(name: str) -> Iterator[str]:
    """Yield a designator's name and those of all that enclose it, innermost first: "2.Grasping/approach", "2.Grasping"."""
    while name:
        yield name
        name = name.rpartition(BETWEEN)[0]


def freed_name(name: str) -> str:
    """Return the name of a part of a task that becomes a task of its own: "3.Placing" for "3.PickAndPlace/Placing". Other names are
    unchanged."""
    whole, _, own = name.rpartition(BETWEEN)
    return f"{whole.partition('.')[0]}.{own}" if whole else name
