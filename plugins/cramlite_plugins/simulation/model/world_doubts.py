"""Plausibility of a world at its start: things that penetrate each other, things without support, or well above it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import mujoco
import numpy as np

from cramlite.model import Robot, World
from cramlite.plugin import UserError, checkpoint

from ...shapes.bounds import height
from .compile import Compiled, compile_world
from .index import Data

DEEP = 0.002
"""Depth from which an overlap is reported [m]: shipped scenarios let things settle from above, none begins deeper inside another."""
TOO_DEEP = 0.005
"""Depth of an overlap that no settling cures [m]: contacts would push the two things apart at once, away from their stated places."""
FALL, WITHIN = 0.05, 0.15
"""Fall [m] within a short time [s] that shows that a thing has no support: free fall takes 0.101 s for it."""
LOWER = 1 / 3
"""Largest drop of a thing at the start, as a share of its height: hands go to the stated pose, and pushing fingers are a third of the
thing's height above its support, so that they would pass over a thing that lies lower by two thirds. In shipped scenarios it is a sixth
at most."""


def world_doubts(world: World, robots: Mapping[str, Robot]) -> Iterator[tuple[str, str]]:
    """List implausible things of a world at its start: (thing, reason)."""
    compiled = compile_world(world, robots)
    data = compiled.data()
    for a, b, depth in overlaps(compiled, data):
        if depth > DEEP:
            yield a, f"{_said(compiled, a, b, depth)}; move one of them"
    yield from _falling(compiled, data)


def refuse_overlaps(compiled: Compiled, data: Data) -> None:
    """Refuse a world that begins with things inside each other, or with a link of an arm inside a thing. An
    effector inside a thing is left to the planner, since it may hold it.

    Raises:
        UserError: names the two that do most, by how much, and how much can be.
    """
    pairs = overlaps(compiled, data, but=("grain", "effector"))
    a, b, depth = max(pairs, key=lambda o: o[2], default=("", "", 0.0))
    if depth > TOO_DEEP:
        cure = "move one of them" if b in compiled.things else "move the thing, or the robot with 'robot: {at: ...}'"
        raise UserError(f"{_said(compiled, a, b, depth)}, more than the {1000 * TOO_DEEP:g} mm that are allowed; {cure}")


def _said(compiled: Compiled, a: str, b: str, depth: float) -> str:
    other = f"'{b}'" if b in compiled.things else f"the robot '{b}'"
    return f"'{a}' and {other} overlap by {1000 * depth:.0f} mm at the start"


def overlaps(compiled: Compiled, data: Data, but: Collection[str] = ("grain",)) -> Iterator[tuple[str, str, float]]:
    """Generate the pairs of bodies in contact, a thing first in each, with the depth [m] to which they
    penetrate each other; owners of the kinds ``but`` do not count."""
    deepest: dict[tuple[str, str], float] = {}
    things = {t.name for t in compiled.world.things}
    for i in range(data.ncon):
        first, second = (compiled.owners[g] for g in data.contact.geom[i])
        a, b = sorted((first.name, second.name), key=lambda n: (n not in things, n))
        if a in things and a != b and first.kind not in but and second.kind not in but:
            deepest[a, b] = max(deepest.get((a, b), 0.0), -float(data.contact.dist[i]))
    yield from ((a, b, depth) for (a, b), depth in sorted(deepest.items()))


def _falling(compiled: Compiled, data: Data) -> Iterator[tuple[str, str]]:
    free = [t.name for t in compiled.world.things if compiled.things[t.name].qpos is not None]
    before = {n: compiled.pose(data, n).position for n in free}
    beneath = {n: _beneath(compiled, data, n) for n in free}
    while free and data.time < WITHIN:
        checkpoint()
        mujoco.mj_step(compiled.model, data)
    for name in free:
        fall = before[name][2] - compiled.pose(data, name).position[2]
        if fall > FALL:
            yield name, f"'{name}' stands on nothing and falls; {beneath[name]}"
        elif fall > LOWER * (high := height(thing := compiled.world.thing(name), thing.pose)):
            said = f"'{name}', which is {1000 * high:.0f} mm high, starts {1000 * fall:.0f} mm above where it comes to rest"
            yield name, f"{said}; state a lower pose, since a hand would go to the stated one to grasp it"


def _beneath(compiled: Compiled, data: Data, thing: str) -> str:
    """Describe the first thing below the middle of a thing, and its distance."""
    hit, start = np.zeros(1, np.int32), np.array(compiled.pose(data, thing).position)
    body = compiled.things[thing].body
    gap = mujoco.mj_ray(compiled.model, data, start, np.array([0.0, 0.0, -1.0]), None, 1, body, hit)
    if gap < 0:
        return "nothing is below it"
    return f"the next thing below its middle is '{compiled.owners[hit[0]].name}', {1000 * gap:.0f} mm lower"
