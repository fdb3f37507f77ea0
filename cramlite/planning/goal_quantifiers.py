"""Goals about classes of things: "each Cup on tray", "any Cup on tray", "2 of Cup on tray", as goals about things."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import combinations, product

from ..base.errors import UserError, nearest
from .operators import Grounder

FORM = re.compile(r"(each|any|\d+ of) (\S+) (.+)")


def without_quantifiers(says: Sequence[str], grounder: Grounder) -> Iterator[tuple[str, ...]]:
    """Generate what goals may mean: for each choice of things, the goals about them, in the order of the world.

    Args:
        says: goals; those without a quantifier stay as they are.

    Raises:
        UserError: a class that there is not, or too few things of it.
    """
    for choice in product(*(list(_meanings(" ".join(g.split()), grounder)) for g in says)):
        yield tuple(goal for goals in choice for goal in goals)


def _meanings(goal: str, grounder: Grounder) -> Iterator[tuple[str, ...]]:
    found = FORM.fullmatch(goal)
    if found is None:
        yield (goal,)
        return
    quantifier, class_, rest = found.groups()
    things = [t for t in _of_class(class_, goal, grounder) if t not in rest.split()]
    count = len(things) if quantifier == "each" else 1 if quantifier == "any" else int(quantifier.split()[0])
    if not 1 <= count <= len(things):
        there = ", ".join(things) or "none"
        raise UserError(f"the goal '{goal}' is about {max(count, 1)} or more of {class_}; in this world there are: {there}.")
    yield from (tuple(f"{t} {rest}" for t in chosen) for chosen in combinations(things, count))


def _of_class(name: str, goal: str, grounder: Grounder) -> list[str]:
    """Things of a class, which is written with its prefix or without."""
    scene = grounder.scene
    class_ = scene.taxonomy.resolve(name)
    if class_ is None:
        known = {c.split(":")[-1] for t in grounder.things.values() for c in (t.type, *scene.taxonomy.ancestors(t.type))}
        raise UserError(f"the goal '{goal}' names the class '{name}'; {nearest(name, known)}.")
    return [n for n in grounder.things if scene.is_a(n, class_)]
