"""Goals of LIBERO's problem files (BDDL) as goals about the things of an imported scene."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cramlite import UserError

JOINTS = {"open": "open", "close": "closed", "turnon": "turned on", "turnoff": "turned off"}
"""Predicates about a joint, and what they are called here."""
PLACES = {"in": "in", "on": "on"}


def goal_sentences(scene: Mapping[str, Any], things: Iterable[str]) -> list[str]:
    """Say a problem's goal, all parts of which shall hold, in sentences about things.

    Args:
        scene: what the judge says of it: ``goal``, ``bodies`` of objects, and ``regions`` with the bodies that they belong to.
        things: of the imported scene, by the names of their bodies, and their regions: "table/left_region".

    Raises:
        UserError: a predicate, an object or a region that has no words here.
    """
    known = set(things)
    return [_sentence(literal, scene, known) for literal in scene["goal"]]


def _sentence(literal: Sequence[str], scene: Mapping[str, Any], things: set[str]) -> str:
    predicate, *names = literal
    found = [_thing(name, scene, things) for name in names]
    match predicate, found:
        case ("in" | "on"), [what, where]:
            return f"{what} {PLACES[predicate]} {where}"
        case ("open" | "close" | "turnon" | "turnoff"), [what]:
            return f"{what.partition('/')[0]} {JOINTS[predicate]}"
    raise UserError(f"The problem's goal ({' '.join(literal)}) has no words here; there are those for {', '.join([*PLACES, *JOINTS])}.")


def _thing(name: str, scene: Mapping[str, Any], things: set[str]) -> str:
    """The thing that an object is, or the region of a thing, by the end of its site's name; of a region that is none, its thing."""
    region = scene["regions"].get(name)
    bodies = region["bodies"] if region else [scene["bodies"][name]] if name in scene["bodies"] else []
    found = next((b for b in bodies if b in things), None)
    if found is not None:
        parts = [n for n in things if region and n.startswith(f"{found}/") and name.endswith(n.removeprefix(f"{found}/"))]
        return max(parts, key=len, default=str(found))
    if region:
        raise UserError(f"The region '{name}' belongs to no thing: only a site marks it on a table, and goals here cannot name it.")
    raise UserError(f"The goal's '{name}' is none of the scene's things: {', '.join(sorted(things))}.")
