"""Nearest collision-free poses of loose things whose perceived poses lie inside others: no two solids share a
place, so one pose must be wrong. But what physics leaves in each other was not read wrong."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, InHand, Pose, Robot, Value, World, vector3
from cramlite.plugin import checkpoint

from .compile import Compiled, compile_world
from .index import Data
from .world_doubts import DEEP, TOO_DEEP, overlaps

STEP = 0.001
"""Step of the distances that are tried [m]."""
WAYS: list[Floats] = [np.array(w) / np.linalg.norm(w) for w in itertools.product((0, 1, -1), repeat=3) if any(w)]
"""Directions that are tried: towards the faces, edges and corners of a cube."""


FARTHER = 2.0
"""Ratio of the largest distance at which a thing may be released to the largest one at which it may come to rest: a basket that is
lifted until its wall is free falls back around the other thing."""
SETTLE = 1.0
"""Time for which a thing that was let go of at its free place falls, tips and slides until it is at rest [s]."""


MOVED = 0.001
"""Distance within which a thing keeps the pose of its reading [m]."""
STAYS = 0.01, 0.2
"""Largest displacement and turn of a thing that settles in another one and counts as staying there [m, rad]: mugs that a benchmark put into
each other settle by 1 mm, a bowl in a ramekin by 7 mm, a book in a mug by 7 mm; what did not stay moved by 37 mm and more."""


class _Rest(Value, eq=False):
    """World at rest after the release of a thing: the thing's distance from its perceived pose, and the poses
    of all moved things."""

    thing: str
    away: float
    poses: dict[str, Pose]


def put_apart(
    world: World, robots: Mapping[str, Robot], most: float, deep: float = TOO_DEEP, staying: bool = False
) -> tuple[World, tuple[str, ...]]:
    """Move loose things that are too deep inside others to the nearest free places at rest, and a payload within the hand.

    Args:
        most: that a thing may be from where it was read [m].
        deep: that one may be inside another [m].
        staying: whether two loose things may stay in each other if physics leaves them there.

    Returns:
        The world, and what was done to it, in clauses; a pair that is not free within ``most`` stays.
    """
    compiled = compile_world(world, robots)
    data = compiled.data()
    held = {m.holds.thing for m in world.robots if m.holds}
    loose = [t.name for t in world.things if compiled.things[t.name].qpos is not None and t.name not in held]
    said, placed = list[str](), world
    for a, b, depth in _wrong(compiled, data, deep):
        ways_out = [(n, other) for n, other in ((a, b), (b, a)) if n in loose and placed.thing(n) is world.thing(n)]
        if staying and depth > TOO_DEEP and len(ways_out) == 2 and (kept := _stuck(placed, (a, b))):
            placed = placed.moved(kept)
            for name, pose in kept.items():
                compiled.place(data, name, pose)
            said.append(f"'{a}' was perceived {1000 * depth:.1f} mm inside '{b}', and stays there")
            continue
        if not ways_out:
            found = next(_in_hand(compiled, data, placed, [(n, o) for n, o in ((a, b), (b, a)) if n in held], depth, most, deep), None)
        else:
            found = next(_rests(compiled, data, placed, ways_out, most, deep), None)
        if found is None:
            continue
        placed = _regrasped(placed, found.poses).moved(found.poses)
        for name, pose in found.poses.items():
            compiled.place(data, name, pose)
        inside = f"'{found.thing}' was perceived {1000 * depth:.1f} mm inside '{b if found.thing == a else a}'"
        said.append(f"{inside}; it is believed to be {1000 * found.away:.0f} mm away from there, where it is free")
    return placed, tuple(said)


def _wrong(compiled: Compiled, data: Data, deep: float) -> list[tuple[str, str, float]]:
    """Pairs of things that are too deep in each other, the deepest first."""
    found = [o for o in overlaps(compiled, data) if o[2] > deep and compiled.things.keys() >= {o[0], o[1]}]
    return sorted(found, key=lambda o: -o[2])


def _regrasped(world: World, poses: Mapping[str, Pose]) -> World:
    """World in which each held payload that gets a new pose is held at that pose, while the hands stay where
    they are."""
    held = {m.name: replace(m.holds, tcp_to_thing=_in_tool(m.holds, world, poses)) for m in world.robots if m.holds}
    return replace(world, robots=tuple(replace(m, holds=held.get(m.name)) for m in world.robots))


def _in_tool(holds: InHand, world: World, poses: Mapping[str, Pose]) -> Pose:
    """Pose of a held payload in the tool frame, from its new pose in the world if it gets one."""
    before = world.thing(holds.thing).pose
    return holds.tcp_to_thing * before.inverse() * poses[holds.thing] if holds.thing in poses else holds.tcp_to_thing


def _free(
    compiled: Compiled, data: Data, world: World, ways_out: list[tuple[str, str]], lengths: Iterable[float], touching: float = 0.0
) -> Iterator[tuple[str, str, Pose]]:
    """Yield (thing, other, pose): collision-free poses for things that were perceived inside another thing,
    each shifted out of it."""
    for length in lengths:
        checkpoint()
        for (name, other), way in itertools.product(ways_out, WAYS):
            pose = Pose(vector3(length * way)) * world.thing(name).pose
            compiled.place(data, name, pose)
            mujoco.mj_fwdPosition(compiled.model, data)
            met = [(b if a == name else a, depth) for a, b, depth in overlaps(compiled, data) if name in (a, b)]
            compiled.place(data, name, world.thing(name).pose)
            if all(depth <= (touching if with_ == other else DEEP) for with_, depth in met):
                yield name, other, pose


def _steps(most: float) -> Iterator[float]:
    """Distances [m], up to ``most``, by which a thing is shifted to look for a free pose."""
    return (step * STEP for step in range(1, round(most / STEP) + 1))


def _in_hand(
    compiled: Compiled, data: Data, world: World, ways_out: list[tuple[str, str]], depth: float, most: float, deep: float
) -> Iterator[_Rest]:
    """Worlds in which a held payload that overlaps a thing is shifted in the hand: until the two just touch, then farther."""
    touching = depth - deep / 2
    for name, _, pose in _free(compiled, data, world, ways_out, (touching, *_steps(most)), deep):
        away = _distance(pose, world.thing(name).pose)
        if away <= most:
            yield _Rest(name, away, {name: pose})


def _rests(
    compiled: Compiled, data: Data, world: World, ways_out: list[tuple[str, str]], most: float, deep: float
) -> Iterator[_Rest]:
    """Worlds at rest, each after one thing was released at a free place, the places nearest to the perceived
    pose first; no thing is far from its perceived pose."""
    for name, other, pose in _free(compiled, data, world, ways_out, _steps(FARTHER * most)):
        poses = _at_rest(world.moved({name: pose}), world, (name, other), deep)
        off = {n: _distance(p, world.thing(n).pose) for n, p in poses.items()}
        if poses and max(off.values()) <= most:
            yield _Rest(name, off.get(name, 0.0), poses)


def _at_rest(start: World, read: World, pair: tuple[str, str], deep: float) -> dict[str, Pose]:
    """Return the rest poses of a thing that was moved aside, the first of ``pair``, and of other loose things
    that it then pushed away.

    Empty if the pair overlaps again.
    """
    now, apart = _settled(start, pair, deep)
    return {n: p for n, p in now.items() if n == pair[0] or _distance(p, read.thing(n).pose) > MOVED} if apart else {}


def _stuck(world: World, pair: tuple[str, str]) -> dict[str, Pose]:
    """Return the rest poses of two loose things that stay in each other, almost where they are; empty if they come apart or move."""
    now, apart = _settled(world, pair, TOO_DEEP)
    off = [world.thing(n).pose.distance(now[n]) for n in pair]
    return {} if apart or any(way > STAYS[0] or turn > STAYS[1] for way, turn in off) else {n: now[n] for n in pair}


def _settled(world: World, pair: tuple[str, str], deep: float) -> tuple[dict[str, Pose], bool]:
    """Return the rest poses of loose things, and whether those of a pair are apart then. Payloads are fixed meanwhile."""
    held = {m.holds.thing for m in world.robots if m.holds}
    things = tuple(replace(t, mass=None, joint=None) if t.name in held else t for t in world.things)
    compiled = compile_world(replace(world, robots=(), things=things), {})
    data = compiled.data()
    while data.time < SETTLE:
        mujoco.mj_step(compiled.model, data)
    apart = not any({a, b} == set(pair) for a, b, _ in _wrong(compiled, data, deep))
    free = [t.name for t in world.things if compiled.things[t.name].qpos is not None and t.name not in held]
    return {n: compiled.pose(data, n) for n in free}, apart


def _distance(one: Pose, other: Pose) -> float:
    return float(np.linalg.norm(np.subtract(one.position, other.position)))
