"""Reasons why predicates cannot be evaluated: gaps of a recording, in which the closed world assumption
would say "false"."""

from __future__ import annotations

from cramlite.plugin import Phase

from .phase_poses import box_of, pose_of, tips


def no_pose(phase: Phase, *names: str | None) -> str | None:
    """Return "no pose of ..." if the pose of an entity, or of the effector, is not known in a phase; None otherwise."""
    for name in (*names, phase.episode.effector or ""):
        if name is not None and pose_of(phase, name, phase.end) is None:
            return f"no pose of '{name}'" if name else "no pose of a hand"
    return None


def no_pose_of(phase: Phase, *names: str | None) -> str | None:
    """Return "no pose of ..." if the pose of an entity is not known; None otherwise."""
    lost = next((n for n in names if n is not None and pose_of(phase, n, phase.end) is None), None)
    return None if lost is None else f"no pose of '{lost}'"


def no_hand(phase: Phase, *_names: str | None) -> str | None:
    """Return the reason why the position of the hand is unknown; None if it is known."""
    return no_pose(phase)


def no_box(phase: Phase, name: str | None, place: str | None) -> str | None:
    """Return the reason why it is unknown whether a thing is in or above a place; None if it is known.

    The reason is that the pose of one of the two, or the shape of the place, is unknown.
    """
    if place is not None and pose_of(phase, place, phase.end) is not None and box_of(phase, place) is None:
        return f"no shape of '{place}'"
    without = any(box_of(phase, n) is None for n, e in phase.timeline.entities.items() if e.part_of is None)
    return no_pose_of(phase, name, place) or ("no shape of what it was over" if place is None and without else None)


def no_fingers(phase: Phase, *_names: str | None) -> str | None:
    """Return the text "no fingers of the hand" if a recording has neither finger tips nor a hand's opening; else
    None."""
    return None if len(tips(phase.timeline)) > 1 or "opening" in phase.episode.extras else "no fingers of the hand"


def no_effector(phase: Phase, _name: str | None) -> str | None:
    """Return the text "who acts" if a recording names no effector, so that a predicate about it cannot be
    judged; else None."""
    known = phase.episode.effector is not None or phase.timeline.entities_of("soma:PrehensileEffector")
    return None if known else "who acts"


def no_class(phase: Phase, name: str | None, _class: str | None) -> str | None:
    """Return the text "what NAME is" if an entity's class is unknown, so that a predicate about it cannot be
    judged; else None."""
    unknown = name in phase.timeline.entities and not phase.timeline.types(name or "")
    return f"what '{name}' is" if unknown else None


def no_contacts(phase: Phase, *_names: str | None) -> str | None:
    """Return the reason why contacts are unknown: none was recorded or inferred, at any time."""
    return _none_of(phase, "soma:ContactState", "no contacts were recorded")


def no_supports(phase: Phase, *_names: str | None) -> str | None:
    """Return the reason why supports are unknown: no such state was recorded or inferred, at any time."""
    return _none_of(phase, "soma:SupportState", "no supports were recorded")


def no_grasps(phase: Phase, *_names: str | None) -> str | None:
    """Return the reason why grasps are unknown: no states were recorded at all. A recorder of contacts
    records grasps, if there are any."""
    return None if phase.episode.of("state") else "no grasps were recorded"


def no_contents(phase: Phase, container: str | None, _content: str | None) -> str | None:
    """Return the reason why contents are unknown. A thing that is known to be no container, such as a
    table, holds nothing."""
    types = phase.timeline.types(container) if container is not None else ()
    if types and not phase.timeline.taxonomy.any_is_a(types, "soma:DesignedContainer"):
        return None
    return _none_of(phase, "soma:ContainmentState", "no contents were recorded")


def _none_of(phase: Phase, type_: str, reason: str) -> str | None:
    return None if phase.timeline.boundaries(type_) else reason
