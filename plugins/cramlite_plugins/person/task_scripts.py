"""Scripts of single tasks by a person with one hand, and the checks that say whether one failed.

Parking an arm, driving, looking at and looking for have none: they need joints, a base, and a camera, and a hand has none of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from cramlite.model import Thing, World, thing_of
from cramlite.plugin import Performance, Performer, UserError, nearest

from . import acts

Fillers = Mapping[str, Any]
Prepare = Callable[[World, Fillers, np.random.Generator], Performance]
Missed = Callable[[Performer, World, list[Thing]], str]


def _held(person: Performer, _world: World, things: list[Thing]) -> str:
    """Objection if the first of the task's things is not in the hand, else ""."""
    return "" if person.holds(things[0].name) else f"'{things[0].name}' is not in the hand"


def _let_go(person: Performer, _world: World, things: list[Thing]) -> str:
    return f"'{things[0].name}' still touches the hand" if person.holds(things[0].name) else ""


def _stands(person: Performer, world: World, things: list[Thing]) -> str:
    """Return an objection if the first of the task's two things does not stand on the second; else ""."""
    thing, onto = things
    return "" if acts.stands_on(person, thing, onto) else f"'{thing.name}' does not stand on '{onto.name}'"


def _inside(person: Performer, _world: World, things: list[Thing]) -> str:
    """Objection if the first of the task's things is not inside the second, else ""."""
    thing, into = things
    inside = acts.is_inside(person, thing, into)
    return "" if inside else f"'{thing.name}' is not in '{into.name}'"


def _moved(share: float) -> Missed:
    """Make a check that objects if the joint of the task's first thing is not near a share of its range."""

    def missed(person: Performer, _world: World, things: list[Thing]) -> str:
        reached = acts.opened(person, things[0])
        return "" if abs(reached - share) < 0.15 else f"'{things[0].name}' is open by {reached:.0%}, not {share:.0%}, of its range"

    return missed


def _script(act: Callable[..., None], *roles: str, missed: Missed | None = None, also: tuple[str, ...] = ()) -> Prepare:
    """Make a function that prepares the simulated person's act for a task, given a world and the things that
    fill the roles.

    Args:
        act: called with person, world, the things of the roles, and those parameters of the task that it knows.
        roles: of things; one that ends with "?" may be left out.
        missed: what tells that it did not come off.
        also: parameters of the task that the act knows.
    """

    def prepare(world: World, fillers: Fillers, _rng: np.random.Generator) -> Performance:
        things = [_thing(world, fillers, role) for role in roles]
        parameters = {k: fillers[k] for k in also if k in fillers}
        known = [t for t in things if t is not None]
        return Performance(
            act=lambda person: act(person, world, *things, **parameters),
            missed=(lambda person: missed(person, world, known)) if missed else None,
        )

    return prepare


def _thing(world: World, fillers: Fillers, role: str) -> Thing | None:
    """Thing that fills a role; if a part fills the role, the thing that the part belongs to."""
    name = fillers.get(role.rstrip("?"))
    if name is None and role.endswith("?"):
        return None
    things = {t.name: t for t in world.things}
    if name is None or thing_of(name) not in things:
        raise UserError(f"the simulated person needs a thing for the role '{role.rstrip('?')}'; {nearest(str(name), things)}")
    return things[thing_of(name)]


TASK_SCRIPTS: Mapping[str, Prepare] = {
    "artm:AssumingArmPoseConstrained": _script(acts.touch, "Relatum"),
    "artm:CloseGripperTask": _script(acts.close_fingers),
    "artm:ExtractHoleFromPeg": _script(acts.extract, "Locatum", "Relatum", missed=_held),
    "artm:InsertHoleOntoPeg": _script(acts.insert, "Locatum", "Relatum", missed=_held),
    "artm:NoOp": _script(acts.stay),
    "artm:OpenGripperTask": _script(acts.open_fingers),
    "artm:SlidingGripper": _script(acts.stroke, "Relatum", also=("distance_m",)),
    "artm:SlidingObject": _script(acts.slide, "Locatum", missed=_held, also=("distance_m",)),
    "artm:Ungrasping": _script(acts.drop_into, "Locatum", "Relatum", missed=_inside),
    "cram:PickAndPlace": _script(acts.place, "Locatum", "Relatum", missed=_stands),
    "cram:Shaking": _script(acts.shake, "Patient", missed=_held, also=("swings",)),
    "cram:TurningOff": _script(partial(acts.move_joint, share=0.0), "Patient", missed=_moved(0.0)),
    "cram:TurningOn": _script(partial(acts.move_joint, share=acts.OPEN), "Patient", missed=_moved(acts.OPEN)),
    "soma:AssumingArmPose": _script(acts.roam),
    "soma:Closing": _script(partial(acts.move_joint, share=0.0), "Patient", missed=_moved(0.0)),
    "soma:Grasping": _script(acts.grasp, "Patient", missed=_held),
    "soma:Holding": _script(acts.hold, "Patient", missed=_held, also=("duration_s",)),
    "soma:Opening": _script(partial(acts.move_joint, share=acts.OPEN), "Patient", missed=_moved(acts.OPEN)),
    "soma:PickingUp": _script(acts.pick_up, "Locatum", missed=_held),
    "soma:Placing": _script(acts.place, "Locatum", "Relatum", missed=_stands),
    "soma:Pouring": _script(acts.pour, "Source", "Destination", missed=_held),
    "soma:Pushing": _script(acts.push, "Patient", also=("distance_m",)),
    "soma:PuttingDown": _script(acts.put_down, "Locatum", "Relatum", missed=_held),
    "soma:Reaching": _script(acts.reach_for, "Goal"),
    "soma:Releasing": _script(acts.release, "Locatum", missed=_let_go),
    "soma:Retracting": _script(acts.withdraw),
    "soma:Transporting": _script(acts.carry, "Patient", "Destination?", missed=_held),
}
"""Class of a task -> the script that shows it."""
