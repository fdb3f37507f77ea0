"""Random goals: the parts (literals) that a scene offers, and rules against contradictory goals without a simulator.

A literal is a tuple as LIBERO's parser has it: ("on", "plate_1", "flat_stove_1_cook_region"). Nothing of cramlite or LIBERO is imported:
the generators of LIBERO's problems and of kitchens share it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

Literal = tuple[str, ...]
Offers = Mapping[str, tuple[tuple[Literal, ...], ...]]
"""Literals of a scene by predicate, and by the sort of target: things, their regions and compartments, regions of a table."""
THING, PART, TABLE = "thing", "part", "table"
"""Sorts of targets of a literal: a thing, a part of a thing, or a region of a table."""
OPPOSITE = {
    "open": "close", "close": "open", "turnon": "turnoff", "turnoff": "turnon", "upright": "upside_down", "upside_down": "upright",
}  # fmt: skip
NAMES = {
    "on": "On", "in": "In", "open": "Open", "close": "Close", "turnon": "TurnOn", "turnoff": "TurnOff", "upright": "Upright",
    "upside_down": "UpsideDown",
}  # fmt: skip
PLACES = ("on", "in")
MOST = 3
"""Largest number of parts (literals) of a goal."""


def offered(
    movables: Iterable[str], targets: Mapping[str, tuple[str, str]], joints: Mapping[str, Sequence[str]]
) -> Offers:
    """Return the candidates for the parts of a random goal: all literals that a scene's things, targets and
    joints allow.

    Args:
        movables: names of things that can be carried; each is also a target of "on".
        targets: what else things can be put on or in -> "on" or "in", and its sort.
        joints: what has a joint, or stands -> the predicates that the benchmark has about that.
    """
    things = sorted(movables)
    wheres = {**dict.fromkeys(things, ("on", THING)), **targets}
    found: dict[str, dict[str, list[Literal]]] = {}
    for where, (predicate, sort) in sorted(wheres.items()):
        put = [(predicate, what, where) for what in things if what != where]
        found.setdefault(predicate, {}).setdefault(sort, []).extend(put)
    for what, predicates in sorted(joints.items()):
        for predicate in predicates:
            found.setdefault(predicate, {}).setdefault(PART, []).append((predicate, what))
    return {p: tuple(tuple(found[p][sort]) for sort in sorted(found[p]) if found[p][sort]) for p in sorted(found) if any(found[p].values())}


def drawn_goal(rng: Any, offers: Offers, parts: int) -> tuple[Literal, ...]:
    """Draw a random goal: choose for each part a predicate, then a sort of target, such as parts of things, then one literal with both.

    Args:
        rng: ``numpy.random.Generator``.
    """
    return tuple(sorted(_one(rng, _one(rng, offers[_one(rng, list(offers))])) for _ in range(parts)))


def _one(rng: Any, among: Sequence[Any]) -> Any:
    return among[rng.integers(len(among))]


def most_parts(offers: Offers) -> int:
    """Return how many parts a goal can have at most without contradiction: per thing a place and an
    attitude, per joint a state."""
    subjects = {(p[1], p[0] in PLACES) for sorts in offers.values() for sort in sorts for p in sort}
    return len(subjects)


def contradiction(goal: Sequence[Literal], owner: Mapping[str, str]) -> str:
    """Return why the parts of a goal contradict each other whatever the scene is; "" if they do not.

    Args:
        owner: region -> the thing that it belongs to, where that can be carried.
    """
    if len(set(goal)) < len(goal):
        return "a part is said twice"
    if any((OPPOSITE[p[0]], p[1]) in goal for p in goal if p[0] in OPPOSITE):
        return "a thing or a joint shall be in two states"
    places = [p for p in goal if p[0] in PLACES]
    if len({p[1] for p in places}) < len(places):
        return "a thing shall be in two places"
    return "things shall bear each other" if _circle({p[1]: owner.get(p[2], p[2]) for p in places}) else ""


def _circle(on: Mapping[str, str]) -> bool:
    return any(_reaches(on, start) for start in on)


def _reaches(on: Mapping[str, str], start: str) -> bool:
    at = on[start]
    for _ in on:
        if at == start:
            return True
        at = on.get(at, "")
    return False


def in_order(goal: Sequence[Literal], owner: Mapping[str, str]) -> list[Literal]:
    """Return the literals of a goal that place things, supports before the things on them."""
    places = {p[1]: p for p in goal if p[0] in PLACES}
    found: list[Literal] = []
    while len(found) < len(places):
        ready = [
            p for p in places.values() if p not in found and (owner.get(p[2], p[2]) not in places or places[owner.get(p[2], p[2])] in found)
        ]
        found += ready
    return found


def signature(goal: Iterable[Literal], kind: Callable[[str], str]) -> frozenset[Literal]:
    """Return a goal with the name of each thing and region replaced by its kind, to compare goals of
    different scenes.

    Args:
        kind: of a thing or region: its name without the number of the instance.
    """
    return frozenset((p[0].lower(), *map(kind, p[1:])) for p in goal)


def fits(thing: Sequence[float], target: Sequence[float]) -> bool:
    """Return whether a thing fits on or in its target in some attitude.

    Args:
        thing: its three extents [m].
        target: the two horizontal extents of what it is to be put on or in [m].
    """
    small, middle, _ = sorted(thing)
    narrow, wide = sorted(target)
    return small <= narrow and middle <= wide


def kind_of(goal: Iterable[Literal]) -> str:
    """Return the predicates of a goal as a text such as "In + Open", by which goals are counted."""
    return " + ".join(sorted(NAMES[p[0]] for p in goal))


def words(goal: Iterable[Literal]) -> str:
    """Return a goal as an English sentence such as "open the drawer", for a problem file of LIBERO."""
    said = {"on": "put the {} on the {}", "in": "put the {} in the {}", "open": "open the {}", "close": "close the {}",
            "turnon": "turn on the {}", "turnoff": "turn off the {}"}  # fmt: skip
    return " and ".join(said[p[0]].format(*(n.replace("_", " ") for n in p[1:])) for p in goal)
