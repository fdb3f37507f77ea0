"""Whether arms open a latched door: the latch is turned out of the way first, since the door would meet it.

A seed draws where the robot stands: up to 50 mm and 10 deg from where the scenario has it; and the friction of the latch. A program
counts if it is proven nominally, and so the door is open in its run.

    python tests/benchmarks/latched_door.py [--first SEED] [--count N]
"""

from __future__ import annotations

import argparse

import numpy as np
from figure import add_figure, rate, write
from msgspec.structs import replace

from cramlite import Engine, Trace, find_scenario, read_scenario
from cramlite.scenario.robot_spec import RobotSpec

ROBOTS = {"ur5e": (0.0, 0.0), "fr3": (0.1, 0.0)}
"""Where each robot stands without an error [m]; an FR3 reaches less far than a UR5e."""
FAR, TURNED = 0.05, 10.0
"""How far a robot stands from there in x and y [m], and how far it is turned [deg]."""


def opens(engine: Engine, robot: str, seed: int) -> bool:
    """Whether a program that opens the door is proven."""
    scenario, rng = read_scenario(find_scenario("kitchen/latched_door")), np.random.default_rng(seed)
    x, y = np.add(ROBOTS[robot], rng.uniform(-FAR, FAR, 2)).round(4)
    stands = {"position": [float(x), float(y), 0.0], "yaw": f"{rng.uniform(-TURNED, TURNED):.2f} deg"}
    spec = RobotSpec.model_validate({"type": robot, "at": stands})
    scenario = replace(scenario, spec=scenario.spec.model_copy(update={"robot": spec}))
    trace = Trace()
    solution = next(engine.resolve(scenario, setting=engine.setting(scenario, seed=seed, twins=0), seed=seed, trace=trace), None)
    print(robot, seed, "proven" if solution else "; ".join(e.reason for e in trace.entries)[-300:], flush=True)
    return solution is not None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    add_figure(parser)
    arguments = parser.parse_args()
    engine, seeds = Engine(), range(arguments.first, arguments.first + arguments.count)
    done = {robot: sum(opens(engine, robot, seed) for seed in seeds) for robot in ROBOTS}
    write(arguments, [rate(f"worlds in which the {r} opens the latched door", n, len(seeds)) for r, n in done.items()], seeds)
    print(done)


if __name__ == "__main__":
    main()
