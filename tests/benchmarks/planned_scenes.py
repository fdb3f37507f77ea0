"""CPU time of planning and proof of scenarios, beside that of MuJoCo for the same scene in the same run.

    python tests/benchmarks/planned_scenes.py SCENARIO... [--plugin experiments/libero/panda.py]

Scenarios may be those that ``cramlite experiment libero --out DIR`` leaves beside the scenes of its episodes. Times are CPU seconds of
this one process; the first scenario given is resolved once beforehand, unmeasured, since modules are imported then. "planned" is all of
the search: task sequences, all grasps, places and paths, proofs apart. Beside it: how many plain checks (MuJoCo's kinematics and
``mj_collision`` of the planning model) take as long, and what the closed loop costs beside a bare loop of ``mj_step`` over its commands.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import closed_loop
import mujoco
import numpy as np
from figure import add_figure, rate, value, write

from cramlite import Engine, Setting, Solution, Trace, read_scenario
from cramlite_plugins.simulation.model.compile import compile_world

CHECKS = 300


class Figures(NamedTuple):
    """CPU seconds of reading, planning (until the first program, and in all) and proof; of a plain check; closed loop over ``mj_step``."""

    proven: bool
    read: float
    first: float
    planned: float
    proof: float
    check: float
    ratio: float


def measured(path: Path, plugins: Sequence[Path]) -> Figures:
    """Read and resolve a scenario, nominally."""
    engine, before, trace = Engine(files=plugins), time.process_time(), Trace()
    scenario = read_scenario(path)
    setting = engine.setting(scenario, twins=0)
    read = time.process_time() - before
    solution = next(engine.resolve(scenario, setting=setting, trace=trace), None)
    took = trace.seconds
    first = took["planning"] if trace.first_program is None else trace.first_program
    ratio = loop_ratio(solution) if solution is not None else float("nan")
    return Figures(solution is not None, read, first, took["planning"], took["proof"], plain_check(setting), ratio)


def loop_ratio(solution: Solution) -> float:
    """Time of a program's run as a multiple of ``mj_step`` alone over the same commands; the quickest of three of each."""
    world, text = solution.setting.world, solution.code
    closed_loop.ROBOTS[solution.setting.robot.type] = solution.setting.robot
    kept = closed_loop.commands(text, world)
    return min(closed_loop.run(text, world)[1] for _ in range(3)) / min(closed_loop.raw(world, kept) for _ in range(3))


def plain_check(setting: Setting) -> float:
    """CPU seconds of kinematics and ``mj_collision`` of the planning model at random positions of the arm."""
    compiled = compile_world(setting.world, {setting.robot.type: setting.robot}, planning=True)
    data, joints = compiled.data(), list(compiled.robots[setting.world.robots[0].name].joints)
    low, high = np.array(setting.robot.limits).T
    positions = np.random.default_rng(0).uniform(np.maximum(low, -3), np.minimum(high, 3), (CHECKS, len(low)))
    before = time.process_time()
    for q in positions:
        data.qpos[joints] = q
        mujoco.mj_kinematics(compiled.model, data)
        mujoco.mj_collision(compiled.model, data)
    return (time.process_time() - before) / CHECKS


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", type=Path, nargs="+", metavar="SCENARIO")
    parser.add_argument("--plugin", type=Path, action="append", default=[], help="a plugin file with the scenarios' robot")
    add_figure(parser)
    options = parser.parse_args()
    measured(options.scenarios[0], options.plugin)
    print("| scenario | proven | read [s] | to the first program [s] | planned [s] | plain checks | proof [s] | closed loop / mj_step |")
    print("|---" * 8 + "|")
    rows = list[Figures]()
    for path in options.scenarios:
        f = measured(path, options.plugin)
        rows.append(f)
        print(
            f"| {path.parent.name}/{path.stem} | {f.proven} | {f.read:.1f} | {f.first:.2f} | {f.planned:.2f} | {f.planned / f.check:.0f} |"
            f" {f.proof:.2f} | {f.ratio:.1f} |", flush=True,
        )  # fmt: skip
    half, most = np.quantile([f.planned for f in rows], (0.5, 0.95))
    print(f"planned: median {half:.2f} s, 95 % under {most:.2f} s, of {len(rows)}; proven {sum(f.proven for f in rows)}")
    times = [value("planned", half, "s", "median"), value("planned", most, "s", "95 %")]
    write(options, [rate("proven", sum(f.proven for f in rows), len(rows)), *times])


if __name__ == "__main__":
    main()
