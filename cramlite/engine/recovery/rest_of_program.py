"""Rest of a program that was stopped midway, for a world in which all things are where its proof had them.

The step under way is finished and all later ones follow, so nothing is searched for. The rest is judged as any program, by a run in the
believed world. Things that came meanwhile are larger there, so that what passes keeps a distance from them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ...model.designator_name import enclosing_names
from ...model.geometry import Pose
from ...model.handover import Handover
from ...model.program.steps import (
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    SetGripper,
    SetPayload,
    Wait,
    ZeroSensor,
    walk,
)
from ...model.run.readings import Deviation
from ...model.world.thing import Geom
from ..proof.proof import load_on_the_flange

if TYPE_CHECKING:
    from collections.abc import Collection

    from ...model.program.program import Program
    from ...model.program.steps import AnyStep, Joints
    from ...model.run.readings import Notice
    from ...model.world.thing import Thing
    from ...model.world.world import World
    from ...plugin.protocols import Candidate
    from ..setting import Setting
    from .expectation import RunWatch

UNEXPLAINED = frozenset(
    {Deviation.CONTACT, Deviation.STUCK, Deviation.REFUSED, Deviation.GOAL_CHANGED, Deviation.GOAL_MISSED}
)
"""Deviations after which the rest of the same program is not run, because the same would happen again. What the arm met, or what held it,
is not in the belief, or the program does not lead to the goal."""
ROOM = 0.01
"""Clearance between the rest of a program and things that appeared after its proof [m]: 5 mm as for planned paths, 5 mm for noise."""
ON_WAY = 0.05
"""Largest distance of a stopped arm from the line between two via points that it was on, in joint space [rad]: corners are rounded."""


def may_be_finished(notice: Notice, watch: RunWatch) -> bool:
    """Check that a stopped program may be finished: nothing has moved, and the cause of the stop is known and over."""
    return watch.nothing_moved and notice.kind not in UNEXPLAINED


def rest_of(candidate: Candidate, origin: str, setting: Setting) -> Candidate | None:
    """Return the rest of a candidate's program, from the step under way on, as a candidate; None if that step cannot be finished from the
    arm's posture.

    Free and guarded motions go on to their ends, guarded ones with a tared sensor; steps of the gripper and waits run again.
    Force-controlled motions, control steps and platform motions depend on where they began.

    Args:
        origin: designator of the step under way.
        setting: as believed after the stop.
    """
    program, mount = candidate.program, setting.world.robots[0]
    own = [k for k, step in enumerate(program.steps) if origin in {s.origin for s in walk((step,))}]
    first = _finished(program.steps[own[0]], mount.joints) if len(own) == 1 else ()
    if not first or program.late:
        return None
    at, held = own[0], mount.holds.thing if mount.holds else ""
    begun = {name for step in program.steps[: at + 1] for s in walk((step,)) for name in enclosing_names(s.origin)}
    return replace(
        candidate, program=_cut(program, at, first, setting), code=None, rollout=None, episode=None,
        world=_with_room(setting.world, {t.name for t in candidate.world.things}),
        actions=tuple(a for a in candidate.actions if a.name not in begun),
        parts=tuple(p for p in candidate.parts if p.name not in begun),
        handovers=_later(candidate, at, held),
    )  # fmt: skip


def _with_room(world: World, known: Collection[str]) -> World:
    """Return a world in which each thing not in ``known`` has boxes around its shapes, with a margin, as its collision
    geometry."""
    return replace(world, things=tuple(t if t.name in known else replace(t, geoms=_boxes(t)) for t in world.things))


def _boxes(thing: Thing) -> tuple[Geom, ...]:
    """Return boxes around the shapes of a thing, larger by ``ROOM`` on each side and raised by ``ROOM``, to stay above
    the thing's support."""
    up = thing.pose.inverse() * Pose((0.0, 0.0, ROOM)) * thing.pose
    return tuple(Geom("box", tuple(half + ROOM for half in g.half_extents), up * g.pose) for g in thing.geoms)


def _finished(step: AnyStep, joints: Joints) -> tuple[AnyStep, ...]:
    """Return the steps that finish another step from a posture in the middle of it; empty where it cannot be finished."""
    match step:
        case MoveJoints():
            passed = _passed(step.path, joints)
            return (replace(step, path=step.path[passed:], radii=step.radii[passed:]),)
        case MoveUntilContact():
            return ZeroSensor(origin=step.origin, comment="as the guarded motion found it"), step
        case MoveLinear(swing=None) | SetGripper() | SetPayload() | ZeroSensor() | Wait():
            return (step,)
    return ()


def _passed(path: tuple[Joints, ...], joints: Joints) -> int:
    """Return how many via points of a path the arm has passed: those up to the start of the last path segment near the
    arm's joint position."""
    here, points = np.array(joints), np.array(path)
    near = [k for k in range(1, len(points)) if _off(here, points[k - 1], points[k]) <= ON_WAY]
    return near[-1] if near else 0


def _off(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    """Return the distance of a joint position from a line between two others, all (axes,) [rad]."""
    way = end - start
    share = float(np.clip((point - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0))
    return float(np.abs(start + share * way - point).max())


def _cut(program: Program, at: int, first: tuple[AnyStep, ...], setting: Setting) -> Program:
    """Return a program in which the steps ``first`` replace all steps up to and including step ``at``."""
    by = at + 1 - len(first)
    sections = (replace(s, first=0 if s.first <= at else s.first - by, last=s.last - by) for s in program.sections if s.last > at)
    mass, center = load_on_the_flange(setting.belief(), setting.robot.gripper)
    start = setting.world.robots[0].joints
    return replace(program, steps=(*first, *program.steps[at + 1 :]), sections=tuple(sections), start=start, mass=mass, center=center)


def _later(candidate: Candidate, at: int, held: str) -> tuple[Handover, ...] | None:
    """Return the grasps and releases from step ``at`` on, the first being that of a payload already in the
    hand; None if they are not known."""
    if candidate.handovers is None:
        return None
    coming = {name for step in candidate.program.steps[at:] for s in walk((step,)) for name in enclosing_names(s.origin)}
    later = tuple(h for h in candidate.handovers if h.by in coming)
    if held and later and later[0].taken and later[0].thing == held:
        later = later[1:]
    return (Handover(held, "", True), *later) if held else later
