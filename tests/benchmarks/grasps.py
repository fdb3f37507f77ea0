"""Share of scripted objects of which one of the first five proposed grasps holds through lift, shake and turn.

A free-flying Robotiq 2F-85, the model that the arms carry, grasps each object where it lies on a table; contacts and
friction decide (``flying_gripper``). Seeds from 10000 on were for development; the figure is that of seeds 20000 to 20199,
which were fixed before their first run.

    python tests/benchmarks/grasps.py --first 20000 --count 200
"""

from __future__ import annotations

import argparse

import flying_gripper
import grasp_objects
import numpy as np
from figure import add_figure, rate, write
from msgspec.structs import replace

from cramlite.base.rate import wilson_interval
from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.locations.pinching import antipodal, grips
from cramlite_plugins.shapes import ray_casting as rays

GRIPPER = flying_gripper.GRIPPER
TABLE = Geom("box", (0.6, 0.6, 0.02), Pose((0.5, 0.0, -0.02)))
FIRST = 5


def proposals(item: Thing, count: int = FIRST) -> list[grips.Grip]:
    """The first grasps that do not go through the table."""
    place, found = rays.body([replace(TABLE, pose=item.pose.inverse() * TABLE.pose)]), grips.ranked(item, GRIPPER, 0.9)
    if not found:
        return []
    openings = np.minimum(np.array([g.width for g in found]) + grips.SLACK, GRIPPER.opening[1])
    fit = antipodal.clear(place, antipodal.Hands.at([g.pose for g in found]).moved(0.001), openings, GRIPPER)
    return [found[k] for k in np.flatnonzero(fit)[:count]]


def holds(item: Thing, grip: grips.Grip, friction: float = 0.9) -> bool:
    """Whether the grasp holds in physics."""
    return flying_gripper.holds(item, item.pose * grip.pose, grip.width, friction)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=20000)
    parser.add_argument("--count", type=int, default=200)
    add_figure(parser)
    arguments = parser.parse_args()
    tried: dict[str, list[int]] = {}
    seeds = range(arguments.first, arguments.first + arguments.count)
    for seed in seeds:
        kind, item = grasp_objects.kind(seed), grasp_objects.thing(seed)
        found = proposals(item)
        rank = next((k for k, g in enumerate(found, 1) if holds(item, g)), 0)
        tried.setdefault(kind, []).append(rank)
        print(f"{kind} {seed}: {f'grasp {rank} holds' if rank else f'NOT HELD of {len(found)}'}", flush=True)
    for kind, ranks in tried.items():
        print(f"{kind}: {sum(map(bool, ranks))} of {len(ranks)}, by the first {sum(r == 1 for r in ranks)}")
    every = [r for ranks in tried.values() for r in ranks]
    held = sum(map(bool, every))
    low, high = wilson_interval(held, len(every))
    first = sum(r == 1 for r in every)
    print(f"{held} of {len(every)} objects held, 95 % interval {low:.3f} to {high:.3f}; by the first grasp {first}")
    numbers = [rate(kind, sum(map(bool, ranks)), len(ranks)) for kind, ranks in tried.items()]
    write(arguments, [*numbers, rate("all", held, len(every)), rate("all, by the first grasp", first, len(every))], seeds)


if __name__ == "__main__":
    main()
