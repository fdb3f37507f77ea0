"""Preconditions of tasks: that the hand is empty, or that it holds something; and locations that several tasks use."""

from __future__ import annotations

from cramlite.model import Action, Belief, Held, Location, Object
from cramlite.plugin import Unresolvable


def near(thing: Object) -> Location:
    """Return the location designator "near" the thing that an object designator describes."""
    return Location(f"near({thing.name})", "near", thing.name)


def at_or_near(thing: Object | None, following: Action | None, goal: Location) -> Location:
    """Return the location to which a collision-free motion towards a thing leads.

    To ``goal``, where the following task begins, if that is about the thing or a part of it; else near the thing.
    """
    about = {n for o in (following.roles.values() if following else ()) for n in (o.name, o.part_of)}
    return goal if thing is None or thing.name in about else near(thing)


def empty_hand(belief: Belief) -> None:
    """Check that the hand is empty, before a thing is taken.

    Raises:
        Unresolvable: something is; earlier tasks are to blame.
    """
    if belief.held is not None:
        raise Unresolvable.because_of_earlier_tasks(f"the gripper already holds '{belief.held.thing}'", blocking=())


def held_payload(belief: Belief, to_be: str) -> Held:
    """Return the payload; refuse, since a task needs one, if nothing is held.

    Args:
        to_be: what, such as "let go".

    Raises:
        Unresolvable: nothing is; earlier tasks are to blame.
    """
    if belief.held is None:
        raise Unresolvable.because_of_earlier_tasks(f"nothing is held that could be {to_be}", blocking=())
    return belief.held


def grasp_of(thing: Object) -> Location:
    """Return the location designator for a grasp of a thing."""
    return Location(f"grasp({thing.name})", "grasp", thing.name)


def spot(relation: str, action: Action) -> Location:
    """Return the location where a task puts something down, "on" or "in" its relatum, with the task's ``where``."""
    relatum = action.roles["Relatum"].name
    return Location(f"{relation}({relatum})", relation, relatum, action.parameters.get("where", {}))
