"""Names of designators: "3.Grasping" is a task of a plan, "3.Grasping/approach" a part of it.

Steps of a program carry the name of the designator that they came from. It is read and written here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator

BETWEEN = "/"


def inside(whole: str, part: str) -> str:
    """The name of a part of a designator; ``part`` alone where the whole is ""."""
    return f"{whole}{BETWEEN}{part}" if whole else part


def is_inside(name: str, whole: str) -> bool:
    """Whether a designator is a part of another one, at any depth."""
    return name.startswith(f"{whole}{BETWEEN}")


def top_of(name: str) -> str:
    """The task of the plan that a designator belongs to: "3.Grasping" of "3.Grasping" and of "3.Grasping/approach"."""
    return name.partition(BETWEEN)[0]


def with_enclosing(name: str) -> Iterator[str]:
    """Each designator that a name is inside of, the name itself first: "2.Grasping/approach", "2.Grasping"."""
    while name:
        yield name
        name = name.rpartition(BETWEEN)[0]
