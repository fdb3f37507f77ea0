"""Places that several tasks name: tasks that name the same one share its grounding."""

from __future__ import annotations

from cramlite import Action, Location, Object


def grasp_of(thing: Object) -> Location:
    """Where the hand takes a thing."""
    return Location(f"grasp({thing.name})", "grasp", thing.name)


def spot(relation: str, action: Action) -> Location:
    """Where a task puts something down, "on" or "in" its relatum; the task's ``where`` constrains it."""
    relatum = action.roles["Relatum"].name
    return Location(f"{relation}({relatum})", relation, relatum, action.parameters.get("where", {}))
