"""Nearest free poses of loose things that were read inside others: no two solids share a place, so the reading is off."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Robot, Value, World
from cramlite.plugin import checkpoint

from .compile import Compiled, compile_world
from .index import Data
from .world_doubts import DEEP, TOO_DEEP, overlaps

STEP = 0.001
"""Between distances that are tried [m]."""
WAYS: list[Floats] = [np.array(w) / np.linalg.norm(w) for w in itertools.product((0, 1, -1), repeat=3) if any(w)]
"""Directions that are tried: towards the faces, edges and corners of a cube."""


FARTHER = 2.0
"""Times as far as a thing may rest it may be let go of: a basket that is lifted off what its wall is in falls back around it."""
SETTLE = 1.0
"""So long what was let go of at its free place falls, tips and slides until it is at rest [s]."""


class _Place(Value, eq=False):
    """Free place of a thing, with its distance and direction from the reading."""

    thing: str
    away: float
    pose: Pose


def put_apart(world: World, robots: Mapping[str, Robot], most: float) -> tuple[World, tuple[str, ...]]:
    """Move loose things that are too deep inside others to the nearest free places at rest.

    Args:
        most: that a thing may be from where it was read [m].

    Returns:
        The world, and what was done to it, in clauses; a pair that is not free within ``most`` stays.
    """
    compiled = compile_world(world, robots)
    data = compiled.data()
    held = {m.holds.thing for m in world.robots if m.holds}
    loose = [t.name for t in world.things if compiled.things[t.name].qpos is not None and t.name not in held]
    said, placed = list[str](), world
    pairs = [o for o in overlaps(compiled, data) if o[2] > TOO_DEEP and compiled.things.keys() >= {o[0], o[1]}]
    for a, b, depth in sorted(pairs, key=lambda o: -o[2]):
        ways_out = [(n, other) for n, other in ((a, b), (b, a)) if n in loose and placed.thing(n) is world.thing(n)]
        found = next(_places(compiled, data, placed, ways_out, most), None)
        if found is None:
            continue
        placed = placed.moved({found.thing: found.pose})
        compiled.place(data, found.thing, found.pose)
        inside = f"'{found.thing}' was read {1000 * depth:.1f} mm inside '{b if found.thing == a else a}'"
        said.append(f"{inside}; it is believed {1000 * found.away:.0f} mm off, where it is free")
    return placed, tuple(said)


def _places(compiled: Compiled, data: Data, world: World, ways_out: list[tuple[str, str]], most: float) -> Iterator[_Place]:
    """Places at rest within a distance, of things that were let go of where they are free, the nearest of that first."""
    for step in range(1, round(FARTHER * most / STEP) + 1):
        checkpoint()
        for (name, other), way in itertools.product(ways_out, WAYS):
            x, y, z = (step * STEP * way).tolist()
            pose = Pose((x, y, z)) * world.thing(name).pose
            compiled.place(data, name, pose)
            mujoco.mj_fwdPosition(compiled.model, data)
            met = [(b if a == name else a, depth) for a, b, depth in overlaps(compiled, data) if name in (a, b)]
            compiled.place(data, name, world.thing(name).pose)
            if any(depth > (0.0 if with_ == other else DEEP) for with_, depth in met):
                continue
            rest = _at_rest(world.moved({name: pose}), name)
            away = float(np.linalg.norm(np.subtract(rest.position, world.thing(name).pose.position)))
            if away <= most:
                yield _Place(name, away, rest)


def _at_rest(world: World, name: str) -> Pose:
    """Rest pose of a thing; things in a hand are held."""
    held = {m.holds.thing: world.thing(m.holds.thing).pose for m in world.robots if m.holds}
    compiled = compile_world(replace(world, robots=()), {})
    data = compiled.data()
    while data.time < SETTLE:
        for thing, pose in held.items():
            compiled.place(data, thing, pose)
        mujoco.mj_step(compiled.model, data)
    return compiled.pose(data, name)
