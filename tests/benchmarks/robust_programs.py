"""Gain of retries and searches: one program, and the same one without any, in the same perturbed twins.

``python tests/benchmarks/robust_programs.py --twins 20 --hook 4``: resolves hang_onto_hanger (or takes ``--run``, its run directory),
writes the text twice, with and without every search (SpiralSearch) and every attempt but the first (Fallback), and runs both in each
twin. Success: the text came to its end, and the product is where it hangs in an undisturbed run, moved along with the hook.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Iterable
from pathlib import Path

from figure import add_figure, rate, write
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.rate import wilson_interval
from cramlite.model import (
    AnyStep,
    ErrorModel,
    Fallback,
    Monitor,
    Parallel,
    PoseError,
    Program,
    Repeat,
    Rollout,
    SensorErrors,
    SpiralSearch,
    World,
    read_program,
)
from cramlite.model.twins.error_model import NO_ERRORS
from cramlite.scenario.twin import draw_twin
from cramlite.scenario.worlds import read_world
from cramlite_plugins.backends.urscript.emit import emit

NEAR = 0.03  # where the product hangs may differ by this from the undisturbed run [m]


def without(steps: Iterable[AnyStep]) -> tuple[AnyStep, ...]:
    """The steps without searches, and with the first attempt only."""
    found: list[AnyStep] = []
    for step in steps:
        match step:
            case SpiralSearch():
                pass
            case Fallback():
                found += without(step.branches[0])
            case Repeat() | Monitor():
                found.append(replace(step, steps=without(step.steps)))
            case Parallel():
                found.append(replace(step, branches=tuple(without(b) for b in step.branches)))
            case _:
                found.append(step)
    return tuple(found)


def texts(program: Program, robot: object) -> dict[str, str]:
    bare = replace(program, steps=without(program.steps), sections=())
    return {"full": emit(program, robot).text, "bare": emit(bare, robot).text}  # type: ignore[arg-type]


def hangs(done: Rollout, still: Rollout, world: World, believed: World) -> bool:
    """Whether the product is where it was in the undisturbed run, moved along with the hook."""
    off = [a - b for a, b in zip(world.thing("hook").pose.position, believed.thing("hook").pose.position, strict=True)]
    wanted = [p + o for p, o in zip(still.poses["coffee"][-1][:3], off, strict=True)]
    return done.outcome == "finished" and math.dist(done.poses["coffee"][-1][:3], wanted) < NEAR


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--twins", type=int, default=20)
    parser.add_argument("--hook", type=float, default=4.0, help="half-width of the hook's displacement [mm]")
    parser.add_argument("--run", type=Path, help="a run directory of hang_onto_hanger")
    add_figure(parser)
    arguments = parser.parse_args()
    scenario = read_scenario(find_scenario("hang_onto_hanger"))
    engine = Engine()
    if arguments.run is None:
        from cramlite.base.run_directory import RunDirectory
        from cramlite.cli.run_files import write_solution

        arguments.run = Path(tempfile.mkdtemp()) / "run"
        solution = next(engine.resolve(scenario))
        write_solution(RunDirectory(arguments.run, {}), solution, engine, 0)
    knowledge = engine.knowledge
    program = read_program((arguments.run / "program.json").read_text()).program
    believed = read_world(str(arguments.run / "world.json"), knowledge, 0)
    things = {"hook": PoseError(arguments.hook / 1000), "coffee": PoseError(0.002, 0.03)}
    errors: ErrorModel = replace(
        NO_ERRORS, things=things, friction=0.1, mass=0.1, sensor=SensorErrors(0.3, 0.0, 0.01), kinematics=0.001
    )
    hangs_on = tuple(("hangs_on", t.name, t.hangs_on.hanger) for t in scenario.spec.things if t.hangs_on)
    both, robots = texts(program, knowledge.robots[program.robot_type]), knowledge.robots
    still = knowledge.simulator.execute(both["full"], believed, robots, mount="arm", seed=0)
    won: dict[str, list[bool]] = {name: [] for name in both}
    for seed in range(1, arguments.twins + 1):
        world = draw_twin(believed, hangs_on, robots[program.robot_type], errors, seed).world
        for name, text in both.items():
            done = knowledge.simulator.execute(text, world, robots, mount="arm", seed=seed)
            won[name].append(hangs(done, still, world, believed))
            print(f"twin {seed} {name}: {'hangs' if won[name][-1] else 'does not hang'} {done.outcome} {done.reason}", flush=True)
    for name, results in won.items():
        low, high = wilson_interval(sum(results), len(results))
        print(f"{name}: {sum(results)} of {len(results)} ({low:.2f} .. {high:.2f})")
    pairs = list(zip(won["full"], won["bare"], strict=True))
    print(f"only the full text: {sum(f and not b for f, b in pairs)}, only the bare one: {sum(b and not f for f, b in pairs)}")
    write(arguments, [rate(name, sum(w), len(w)) for name, w in won.items()], range(1, arguments.twins + 1))


if __name__ == "__main__":
    main()
