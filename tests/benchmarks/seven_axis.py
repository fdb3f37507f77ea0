"""The scenarios of the task types on an arm with seven axes: one line of each is changed, `robot:`.

    python tests/benchmarks/seven_axis.py [--robot fr3_2f85] [--forward 0.1] [--only grasping,placing]

As tests/test_task_scenarios.py does on the UR5e: the first complete program of each scenario is run and judged, seed 0. No
further program is tried, so a scenario may still be solved by `cramlite resolve`; ``--whole`` asks for that.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from figure import add_figure, rate, write
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.task_scenarios import REFUSED, attempt

from cramlite import Engine, Trace, find_scenario, read_scenario
from cramlite.plugin import UserError
from cramlite.scenario.scenario import PoseSpec, RobotSpec


def judged(engine: Engine, name: str, robot: RobotSpec, *, whole: bool) -> str:
    """Why a scenario is not proven on a robot; "" where it is."""
    try:
        if not whole:
            _, verdict, reasons = attempt(engine, name, robot=robot)
            return "" if verdict is not None and verdict.passed else reasons or "no program"
        scenario, trace = read_scenario(find_scenario(f"tasks/{name}")), Trace()
        changed = replace(scenario, spec=scenario.spec.model_copy(update={"robot": robot}))
        if next(engine.resolve(changed, trace=trace), None) is not None:
            return ""
        return "; ".join(e.reason for e in trace.entries[-5:])
    except UserError as error:
        return str(error)


def main() -> None:
    """Print each scenario with how it ended, and the sum."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="fr3_2f85", help="type of the robot")
    parser.add_argument("--forward", type=float, default=0.1, help="where it stands on the x axis [m]")
    parser.add_argument("--only", default="", help="scenarios, separated by commas")
    parser.add_argument("--whole", action="store_true", help="resolve, not only the first program")
    add_figure(parser)
    options = parser.parse_args()
    at = PoseSpec.model_validate({"position": [options.forward, 0, 0]})
    robot, engine, proven = RobotSpec(type=options.robot, at=at), Engine(), 0
    names = options.only.split(",") if options.only else sorted(REFUSED)
    begin = time.process_time()
    for name in names:
        why = judged(engine, name, robot, whole=options.whole)
        proven += not why
        print(f"{name}: {'proven' if not why else 'not proven: ' + why[-400:]}", flush=True)
    print(f"{proven} of {len(names)} proven on '{options.robot}', {time.process_time() - begin:.0f} s of CPU time")
    write(options, [rate("proven", proven, len(names))], "0")


if __name__ == "__main__":
    main()
