"""Goals of LIBERO's problem files (BDDL) as goals about the things of an imported scene."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cramlite import UserError
from cramlite.model import Thing

JOINTS = {"open": "open", "close": "closed", "turnon": "turned on", "turnoff": "turned off"}
"""LIBERO's predicates about a joint, with their words in goals of cramlite."""
AMID = "within 30 mm"
"""Largest horizontal distance between the origins of a thing and its support (LIBERO's ``check_ontop``); it does not apply to regions."""


def goal_sentences(scene: Mapping[str, Any], things: Iterable[Thing]) -> list[str]:
    """Write a problem's goal, a conjunction of literals, as sentences about things.

    Args:
        scene: what the benchmark says of it: ``goal``, ``bodies`` of objects, and ``regions`` with the bodies that they belong to.
        things: of the imported scene, called as their bodies are; their regions are theirs: "table/left_region".

    Raises:
        UserError: a predicate, an object or a region that has no words here.
    """
    known = {t.name: t for t in things}
    return [_sentence(literal, scene, known) for literal in scene["goal"]]


def _sentence(literal: Sequence[str], scene: Mapping[str, Any], things: Mapping[str, Thing]) -> str:
    predicate, *names = literal
    found = [_thing(name, scene, things) for name in names]
    match predicate, found:
        case "on", [what, where] if names[1] in scene["bodies"]:
            return f"{what} on {where} {AMID}"
        case ("in" | "on"), [what, where]:
            return f"{what} {predicate} {where}"
        case ("open" | "close" | "turnon" | "turnoff"), [what]:
            return f"{_jointed(what.partition('/')[0], names[0], things)} {JOINTS[predicate]}"
    raise UserError(
        f"The problem's goal ({' '.join(literal)}) has no words here; predicates that have words are {', '.join(['in', 'on', *JOINTS])}."
    )


def _jointed(what: str, name: str, things: Mapping[str, Thing]) -> str:
    """Return the name of an object's only part on a joint, such as a stove's knob; the object's own if it has
    several.

    Its own, too, if it moves on a joint itself.
    """
    parts = [t.name for t in things.values() if t.joint is not None and t.name.startswith(f"{name}_")]
    return parts[0] if things[what].joint is None and len(parts) == 1 else what


def _thing(name: str, scene: Mapping[str, Any], things: Mapping[str, Thing]) -> str:
    """Return the name of the thing that an object of a LIBERO goal is or, for a region, of the thing's
    feature: "thing/feature".

    The feature is the one with the longest name that ends the name of the region; without one it is the thing
    itself.
    """
    region = scene["regions"].get(name)
    bodies = region["bodies"] if region else [scene["bodies"][name]] if name in scene["bodies"] else []
    found = next((b for b in bodies if b in things), None)
    if found is not None:
        parts = [f.name for f in things[found].features if region and name.endswith(f.name)]
        return f"{found}/{max(parts, key=len)}" if parts else str(found)
    if region:
        raise UserError(f"The region '{name}' belongs to no thing: only a site marks it on a table, and goals here cannot name it.")
    raise UserError(f"The goal's '{name}' is none of the scene's things: {', '.join(sorted(things))}.")
