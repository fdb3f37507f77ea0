"""Share of scripted objects of which one of the first five proposed grasps holds through lift, shake and turn.

A free-flying hand (pads 20 x 30 mm, 40 N) grasps each object where it stands on a table; contacts and friction decide.
Held: less than 20 mm of movement in the hand from closing to the end.

    python tests/benchmarks/grasps.py --first 0 --count 200
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace

import mujoco
import numpy as np

from cramlite.geometry import Pose
from cramlite.robots import Gripper
from cramlite.world import Geom, Physics, Thing, World
from cramlite_plugins.experts import antipodal, grasps
from cramlite_plugins.simulation.compile import Compiled, compile_world
from cramlite_plugins.simulation.models import block, table
from cramlite_plugins.simulation.vessels import bottle, bowl, can, mug

HAND = Gripper("hand", (0.0, 0.10), (0.020, 0.030), 0.063, 0.5, Pose(), (40.0, 40.0), (0.1, 0.1))
TABLE = Geom("box", (0.5, 0.5, 0.02), Pose((0.5, 0.0, -0.02)))
HELD = 0.020
KINDS = ("block", "can", "bottle", "bowl", "mug", "ball", "cross")


def thing(seed: int) -> Thing:
    """An object at rest on the table."""
    rng = np.random.default_rng(seed)
    kind, mass = KINDS[seed % len(KINDS)], float(rng.uniform(0.05, 0.6))
    r, h = float(rng.uniform(0.015, 0.038)), float(rng.uniform(0.05, 0.15))
    at = Pose((0.5, 0.0, h / 2))
    if kind == "block":
        return block("it", at, (float(rng.uniform(0.02, 0.075)), float(rng.uniform(0.02, 0.12)), h), mass)
    if kind == "can":
        return can("it", at, r, h, mass)
    if kind == "bottle":
        return bottle("it", at, r, h, r * float(rng.uniform(0.35, 0.7)), float(rng.uniform(0.03, 0.07)), mass)
    if kind == "bowl":
        h = float(rng.uniform(0.035, 0.07))
        return bowl("it", Pose((0.5, 0, h / 2)), float(rng.uniform(0.05, 0.09)), h, mass=mass)
    if kind == "mug":
        h = float(rng.uniform(0.07, 0.11))
        return mug("it", Pose((0.5, 0, h / 2)), float(rng.uniform(0.032, 0.046)), h, mass=mass)
    if kind == "ball":
        return Thing("it", "cram:Product", Pose((0.5, 0, r)), (Geom("sphere", (r,)),), mass=mass)
    arm = float(rng.uniform(0.06, 0.12))
    bars = (Geom("box", (arm, 0.012, 0.012)), Geom("cylinder", (0.012, arm / 2), Pose.from_axes((0, 0, 0), (0, 1, 0), (1, 0, 0))))
    return Thing("it", "cram:Product", Pose((0.5, 0, 0.012)), bars, mass=mass)


def proposals(item: Thing, count: int = 5) -> list[grasps.Grip]:
    """The first grasps that do not go through the table."""
    place = replace(TABLE, pose=item.pose.inverse() * TABLE.pose)
    fit = (
        g for g in grasps.ranked(item, HAND, 0.9)
        if antipodal.clear(antipodal.body((place,)), g.pose * Pose((0, 0, 0.002)), min(g.width + grasps.SLACK, 0.1), HAND)
    )  # fmt: skip
    return [g for g, _ in zip(fit, range(count), strict=False)]


def holds(item: Thing, grip: grasps.Grip, friction: float = 0.9) -> bool:
    """Grasp, lift, shake, turn by 60 degrees."""
    at = item.pose * grip.pose
    world = World((table("table", Pose((0.5, 0, 0))), item), physics=Physics(pad_friction=friction))
    compiled = compile_world(world, {}, hand=Pose((0, 0, 0), at.quaternion))
    data, hand = compiled.data(), compiled.hand
    assert hand is not None
    opening = min(grip.width + grasps.SLACK, 0.1)
    hand.teleport(compiled.model, data, at * Pose((0, 0, -grasps.STANDOFF)), opening)
    mujoco.mj_forward(compiled.model, data)
    for s in np.linspace(0, 1, 300):
        _step(compiled, data, at * Pose((0, 0, -grasps.STANDOFF * (1 - s))), opening)
    for s in np.linspace(0, 1, 300):
        _step(compiled, data, at, opening * max(0.0, 1 - 1.5 * s))
    before = hand.pose(data).inverse() * compiled.pose(data, "it")
    for s in np.linspace(0, 1, 400):
        _step(compiled, data, _up(at, 0.2 * s), 0.0)
    for s in np.linspace(0, 1, 500):
        _step(compiled, data, Pose((0, 0.015 * math.sin(6 * math.pi * s), 0)) * _up(at, 0.2), 0.0)
    for s in np.linspace(0, 1, 500):
        _step(compiled, data, _up(at, 0.2) * Pose((0, 0, 0), (math.cos(s * math.pi / 6), math.sin(s * math.pi / 6), 0, 0)), 0.0)
    after = hand.pose(data).inverse() * compiled.pose(data, "it")
    return before.distance(after)[0] < HELD and compiled.pose(data, "it").position[2] > item.pose.position[2] + 0.1


def _up(at: Pose, by: float) -> Pose:
    return Pose((0, 0, by)) * at


def _step(compiled: Compiled, data: object, pose: Pose, opening: float) -> None:
    assert compiled.hand is not None
    compiled.hand.set_target(data, pose, opening)
    mujoco.mj_step(compiled.model, data)


def wilson(successes: int, total: int) -> tuple[float, float]:
    """The 95 % Wilson score interval (Wilson, JASA 22, 1927)."""
    z, p = 1.96, successes / total
    middle, spread = p + z * z / (2 * total), z * (p * (1 - p) / total + z * z / (4 * total * total)) ** 0.5
    return (middle - spread) / (1 + z * z / total), (middle + spread) / (1 + z * z / total)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=200)
    arguments = parser.parse_args()
    held, failed = 0, []
    for seed in range(arguments.first, arguments.first + arguments.count):
        item = thing(seed)
        found = proposals(item)
        tried = next((k for k, g in enumerate(found, 1) if holds(item, g)), 0)
        print(f"{KINDS[seed % len(KINDS)]} {seed}: {f'grasp {tried} holds' if tried else 'NOT HELD'}", flush=True)
        held += bool(tried)
        if not tried:
            failed.append(f"{KINDS[seed % len(KINDS)]} {seed} ({len(found)} proposed)")
    low, high = wilson(held, arguments.count)
    print(f"{held} of {arguments.count} objects held, 95 % interval {low:.3f} to {high:.3f}; not: {', '.join(failed)}")


if __name__ == "__main__":
    main()
