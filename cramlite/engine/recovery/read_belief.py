"""Belief after a stopped run, from the last sensor readings."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ...model.fault import FaultKind
from ...model.run.rollout import world_after_run
from ...model.world.thing import Thing
from ...model.world.thing_boxes import Box, boxes
from ...model.world.world import InHand, RobotMount
from ...scenario.faults import left_over
from ...scenario.worlds import corrected
from ..setting import with_load

if TYPE_CHECKING:
    from ...model.geometry import Floats, Pose
    from ...model.run.readings import Readings
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...plugin.catalogue import Knowledge
    from ..setting import Setting

REACH = 0.02
"""Largest distance of the tool centre point from the boxes around a thing in the hand [m]: the thing may have slipped."""
LOOSE = 0.002
"""Largest amount by which the opening of the fingers may exceed the width of a thing that they hold [m]."""
SHUT = 0.003
"""Opening beyond that of the closed fingers above which fingers that press have a thing between them [m]."""

STILL = 0.005
"""Distance up to which a thing counts as not moved, on the way back or between two readings [m]: the default for bystanders."""


def setting_as_read(before: Setting, read: World, knowledge: Knowledge, noise: float, deep: float | None = None) -> Setting:
    """Return a setting whose world was read again: impossible poses are corrected, relations of things that moved are dropped.

    Args:
        noise: how far measured poses may be off [m]; with 0 they are not corrected.
        deep: how far a thing may have been read inside another one [m]; None for the simulator's own limit.
    """
    world = corrected(read, knowledge, noise, deep, staying=True)
    where = {t.name: t.pose.position for t in before.world.things}
    stayed = {t.name for t in world.things if t.name in where and math.dist(where[t.name], t.pose.position) <= STILL}
    relations = tuple(r for r in before.relations if r[1] in stayed)
    return with_load(replace(before, world=world, relations=relations, real=None, look=None), knowledge)


def world_as_read(before: World, readings: Readings, models: World, closed: float) -> World:
    """Return the believed world after a run: things at their measured poses; movable things without a measured pose are left out.

    Args:
        before: as it was believed.
        models: of what came meanwhile: who reads poses knows what it reads them of.
        closed: opening of the closed fingers [m].
    """
    read = readings.poses or {}
    known = {t.name for t in before.things}
    come = [t for t in models.things if t.name in read and t.name not in known]
    every = replace(before, things=(*before.things, *come))
    possible: dict[str, Pose] = {}
    for thing in every.things:
        if thing.name in read:
            possible[thing.name] = thing.allowed(read[thing.name], every.carrier_shift(thing.name, possible))
    things = every.put(possible).things
    seen = tuple(t for t in things if t.name in read or t.furniture)
    mount = replace(before.robots[0], joints=readings.joints, opening=readings.opening, holds=in_hand(seen, readings, closed))
    return replace(before, things=seen, robots=(mount, *before.robots[1:]))


def in_hand(things: Iterable[Thing], readings: Readings, closed: float) -> InHand | None:
    """Return the payload: the movable thing nearest to the tool, if the fingers press and are about as far
    open as the thing is wide; else None."""
    if not readings.pressing or readings.opening <= closed + SHUT:
        return None
    near = {t.name: _gap(t, readings.tool) for t in things if t.movable}
    name = min(near, key=lambda n: near[n], default="")
    if not name or near[name] > REACH:
        return None
    thing = next(t for t in things if t.name == name)
    if readings.opening > _width(thing, readings) + LOOSE:
        return None
    return InHand(name, readings.tool.inverse() * thing.pose, readings.pressing)


def real_after(rollout: Rollout, world: World, holds: InHand | None) -> World:
    """Return the real world as a run left it, with the faults that have not happened yet.

    Fingers that pressed go on pressing.
    """
    left = world_after_run(rollout, world)
    faults = left_over(world.faults, (m.text for m in rollout.faults), float(rollout.times[-1]))
    gone = {f.thing for f in world.faults if f.kind is FaultKind.MISSING and f not in faults}
    left = replace(left, things=tuple(t for t in left.things if t.name not in gone))
    left = left.moved({f.thing: world.thing(f.thing).pose for f in faults if f.kind is FaultKind.ADDED})
    mount: RobotMount = replace(left.robots[0], holds=holds)
    return replace(left, faults=faults, robots=(mount, *left.robots[1:]))


def _width(thing: Thing, readings: Readings) -> float:
    """Width of a thing between the fingers [m], by the boxes around those of its geoms near the tool centre point."""
    along, point = np.array(readings.across), np.array(readings.tool.position)
    near = [g for g, box in zip(thing.geoms, boxes(thing), strict=True) if _off(point, box) <= REACH]
    placed = [(thing.pose * g.pose, np.array(g.half_extents)) for g in near]
    middles = [(float(np.dot(p.position, along)), float(abs(along @ p.rotation) @ half)) for p, half in placed]
    return max(m + h for m, h in middles) - min(m - h for m, h in middles)


def _off(point: Floats, box: Box) -> float:
    low, high = map(np.array, box)
    return float(np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0)))


def _gap(thing: Thing, tool: Pose) -> float:
    """Distance of the tool centre point from the nearest of the boxes around a thing's geoms [m]."""
    point = np.array(tool.position)
    return min(_off(point, box) for box in boxes(thing))
