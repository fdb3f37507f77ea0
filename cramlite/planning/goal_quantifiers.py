"""Expansion of goals that name a class of things, or have alternatives, into goals that name single things.

Such goals are "each Cup on tray", "2 of Cup on tray", or "tin on tray or tin in basket".
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, islice, product

from ..base.errors import UserError, nearest
from ..interpretation.fluents import Fact, matches
from .goal_parser import NOT, parse_goal
from .operators import Grounder

FORM = re.compile(rf"({NOT})?(each|any|\d+ of) (\S+) (.+)")
OR = " or "
MOST = 1000
"""Largest number of meanings of one goal that are generated."""

Says = tuple[str, ...]


def without_quantifiers(says: Sequence[str], grounder: Grounder) -> Iterator[Says]:
    """Generate the meanings of goals: for each choice of things and alternatives, the goals about them.

    What needs least is first: of alternatives those that hold already, of things those for which the goal does; else in the
    order of goal and world.

    Args:
        says: goals; those that leave nothing open stay as they are.

    Raises:
        UserError: a class that there is not, or too few things of it.
    """
    facts = grounder.initial

    def missing(goals: Says) -> int:
        return sum(not _holds(goal, grounder, facts) for goal in goals)

    for choice in product(*(sorted(islice(_ways(g, says, grounder, facts), MOST), key=missing) for g in says)):
        yield tuple(dict.fromkeys(goal for goals in choice for goal in goals))


def _ways(goal: str, says: Sequence[str], grounder: Grounder, facts: frozenset[Fact]) -> Iterator[Says]:
    """Generate the meanings of one of several goals, and after each meaning other goals that fulfil it as well.

    The last goal of such a list is about that thing; the others are asked for anyway, or hold.
    """
    for meaning in _meanings(goal, grounder, facts):
        yield meaning
        for *others, last in _instead(meaning, grounder):
            if all(other in says or _holds(other, grounder, facts) for other in others):
                yield (*others, last)


def _instead(meaning: Says, grounder: Grounder) -> tuple[Says, ...]:
    """Return alternative lists of goals that fulfil a single goal; () for several goals, and for text that is not a goal."""
    try:
        return parse_goal(meaning[0], grounder).meaning.instead if len(meaning) == 1 else ()
    except UserError:
        return ()


def _meanings(goal: str, grounder: Grounder, facts: frozenset[Fact]) -> Iterator[Says]:
    for option in " ".join(goal.split()).removeprefix("either ").split(OR):
        yield from _of_things(option, grounder, facts)


def _of_things(goal: str, grounder: Grounder, facts: frozenset[Fact]) -> Iterator[Says]:
    """Generate the goals for each choice of things that a quantifier such as "any" or "2 of" allows.

    "not each" becomes "any" of the denied goals, and the reverse (De Morgan).
    """
    found = FORM.fullmatch(goal)
    if found is None:
        yield (goal,)
        return
    denied, quantifier, class_, rest = (g or "" for g in found.groups())
    if denied and quantifier not in ("each", "any"):
        raise UserError(f"the goal '{goal}' denies a number of things; state how many things it shall hold for, or 'not any', 'not each'.")
    quantifier = {"each": "any", "any": "each"}[quantifier] if denied else quantifier
    things = [t for t in _of_class(class_, goal, grounder) if t not in rest.split()]
    count = len(things) if quantifier == "each" else 1 if quantifier == "any" else int(quantifier.split()[0])
    if not 1 <= count <= len(things):
        there = ", ".join(things) or "none"
        raise UserError(f"the goal '{goal}' is about {max(count, 1)} or more of {class_}; in this world there are: {there}.")
    best = sorted((f"{denied}{t} {rest}" for t in things), key=lambda g: not _holds(g, grounder, facts))
    yield from combinations(best, count)


def _holds(goal: str, grounder: Grounder, facts: frozenset[Fact]) -> bool:
    """Check whether a goal about things holds at the start; False for a sentence that is no goal, which
    planning refuses later."""
    try:
        said = parse_goal(goal, grounder)
    except UserError:
        return False
    meaning = said.meaning
    as_asked = not said.side and (meaning.manner is None or meaning.manner.holds)
    return as_asked and meaning.needs <= facts and not _any_match(meaning.without, facts)


def _any_match(patterns: Iterable[tuple[str | None, ...]], facts: frozenset[Fact]) -> bool:
    return any(matches(f, p) for p in patterns for f in facts)


def _of_class(name: str, goal: str, grounder: Grounder) -> list[str]:
    """Return the names of the things of a class; the class name may be given with its prefix or without."""
    scene = grounder.scene
    class_ = scene.taxonomy.resolve(name)
    if class_ is None:
        known = {c.split(":")[-1] for t in grounder.things.values() for c in (t.type, *scene.taxonomy.ancestors(t.type))}
        raise UserError(f"the goal '{goal}' names the class '{name}'; {nearest(name, known)}.")
    return [n for n in grounder.things if scene.is_a(n, class_)]
