"""Whether arms open a door that its own lever holds shut: the lever is turned, held while the door opens, and led back.

A seed draws the world: where the cabinet stands and how it is turned, the door's height, the lever's height, length and tongue, its
spring, and the height of what the tongue lies behind, which says how far the lever must be turned. A program counts if it is proven, with
or without twins, and so the door is open in its run.

    python tests/benchmarks/lever_door.py [--first SEED] [--count N] [--twins N] [--robot TYPE]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from figure import add_figure, rate, write

from cramlite import Engine, Trace, read_scenario

ROBOTS = {"ur5e": (0.0, 0.0), "fr3": (0.1, 0.0), "panda": (0.1, 0.0)}
"""Where each robot stands [m]; an FR3 and a Panda reach less far than a UR5e."""
PANDA = Path(__file__).with_name("panda_arm.py")


def world(robot: str, seed: int) -> str:
    """Scenario of a seed, as text."""
    rng = np.random.default_rng(seed)
    x, y, z = np.add((0.75, 0.1, 0.37), rng.uniform((-0.04, -0.06, -0.03), (0.02, 0.06, 0.03)))
    yaw, high = np.radians(180.0 + rng.uniform(-12.0, 12.0)), rng.uniform(0.24, 0.34)
    low, aside = -rng.uniform(0.07, high / 2 - 0.03), -rng.uniform(0.10, 0.12)
    length, tongue, spring = rng.uniform(0.09, 0.13), rng.uniform(0.07, 0.085), rng.uniform(0.3, 0.9)
    keeper = rng.uniform(0.04, 0.07)

    def at(out: float, left: float, up: float) -> str:
        """A place in the frame of the cabinet's front."""
        place = (x + np.cos(yaw) * out - np.sin(yaw) * left, y + np.sin(yaw) * out + np.cos(yaw) * left, z + up)
        return f"position: [{', '.join(f'{v:.4f}' for v in place)}]"

    turned, (bx, by) = f"yaw: {np.degrees(yaw):.2f} deg", ROBOTS[robot]
    size = f"size: [0.30, 0.30, {high:.3f}]"
    return f"""scenario: lever_door_{seed}
goal: [door open]
robot: {{type: {robot}, at: {{position: [{bx}, {by}, 0]}}}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: cabinet, model: cabinet, at: {{{at(0, 0, 0)}, {turned}}}, with: {{{size}}}}}
  - {{name: door, model: door, at: {{{at(0, 0, 0)}, {turned}}}, with: {{parent: cabinet, height: {high:.3f}}}}}
  - {{name: lever, model: lever, at: {{{at(0.018, aside, low)}, {turned}}},
      with: {{parent: door, length: {length:.3f}, tongue: {tongue:.3f}, spring: {spring:.2f}}}}}
  - {{name: keeper, model: table, at: {{{at(0.06, aside - tongue + 0.005, low)}, pitch: -90 deg, yaw: {np.degrees(yaw) - 180:.2f} deg}},
      with: {{size: [{keeper:.3f}, 30 mm, 25 mm]}}}}
"""


def opens(engine: Engine, robot: str, seed: int, twins: int, folder: Path) -> bool:
    """Whether a program that opens the door is proven."""
    path = folder / f"{robot}_{seed}.yaml"
    path.write_text(world(robot, seed), encoding="utf-8")
    scenario, trace = read_scenario(path), Trace()
    solution = next(engine.resolve(scenario, setting=engine.setting(scenario, seed=seed, twins=twins), seed=seed, trace=trace), None)
    print(robot, seed, "proven" if solution else "; ".join(e.reason for e in trace.entries)[-600:], flush=True)
    return solution is not None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--twins", type=int, default=0)
    parser.add_argument("--robot", action="append", choices=[*ROBOTS], help="all by default")
    add_figure(parser)
    arguments = parser.parse_args()
    engine, seeds = Engine(files=[PANDA]), range(arguments.first, arguments.first + arguments.count)
    with tempfile.TemporaryDirectory() as name:
        asked, folder = arguments.robot or ROBOTS, Path(name)
        done = {robot: sum(opens(engine, robot, seed, arguments.twins, folder) for seed in seeds) for robot in asked}
    write(arguments, [rate(f"worlds in which the {r} opens the door by its lever", n, len(seeds)) for r, n in done.items()], seeds)
    print(done)


if __name__ == "__main__":
    main()
