"""``cramlite execute``: runs a program's text in a world. The controller sees the text and the world, nothing else."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from msgspec.structs import replace

from ..base.errors import NoSolution, UserError, nearest
from ..base.json_text import as_json
from ..base.run_directory import require_vacant
from ..engine.proof.judging import JudgedRun
from ..model.program.program_json import is_program_text, read_program
from ..model.robot_file import RobotFile
from ..model.run.rollout import Rollout
from ..plugin.catalogue import Knowledge, pick
from ..scenario.faults import faulty, read_fault_text
from ..scenario.worlds import read_world
from .arguments import Add, add_seed, duration, plugin_choice
from .judge import add_purpose, judged_json, judged_text, purpose_of, refuse
from .program_input import naming, read_text, robots_world
from .run_files import write_run
from .texts import findings_text, rollout_json, rollout_text


def _simulate(arguments: argparse.Namespace) -> int:
    """Run a program's text on the controller model, say how it ended, and judge it if a plan or a goal is given.

    Raises:
        NoSolution: it did not come to its end, for its own last message or what stopped it; or validators object.
        UserError: a file that cannot be used.
    """
    program, seed, out, plan, goals = arguments.program, arguments.seed, arguments.out, arguments.plan, arguments.goal
    knowledge = Knowledge(plugin_choice(arguments).registry())
    require_vacant(out, "run")
    text, place = read_text(program), robots_world(arguments.world, program, knowledge, seed)
    place = faulty(place, map(read_fault_text, arguments.fault))
    judged = None
    if plan or goals:
        judged = judged_text(program, text, place, purpose_of(plan, goals, knowledge, place), knowledge, seed)
        rollout = judged.rollout
    else:
        with naming(program):
            rollout = knowledge.run(text, place, seed)
    if out is not None:
        write_run(out, rollout, program.stem, knowledge, episode=not arguments.no_episode)
    _print(rollout, judged, json_output=arguments.json)
    _refuse_unfinished(program, rollout)
    if judged is not None:
        refuse(program, judged)
    return 0


def _drive(arguments: argparse.Namespace) -> int:
    """Send the motions of a typed program to a process that acts as the robot, and print how the run ended.

    For a robot from a file, the run's ``world.json`` must be beside the program.

    Raises:
        NoSolution: the program did not come to its end.
        UserError: a text that cannot be driven; a process that does not answer as it must.
    """
    program, out = arguments.program, arguments.out
    knowledge = Knowledge(plugin_choice(arguments).registry())
    require_vacant(out, "run")
    text = read_text(program)
    if not is_program_text(text):
        raise UserError(f"{program}: --on runs typed programs (JSON) only; write one with 'resolve --backend stream'.")
    with naming(program):
        kind = read_program(text).program.robot_type
        file = _robots_file(program, kind, knowledge)
        robot = knowledge.read_robot(file).robot if file else pick("robot", knowledge.robots, kind)
    rollout = _with_file(knowledge.driver.drive(text, robot, _words(arguments.on)), file)
    if out is not None:
        write_run(out, rollout, program.stem, knowledge, episode=False)
    _print(rollout, None, json_output=arguments.json)
    _refuse_unfinished(program, rollout)
    return 0


def _robots_file(program: Path, kind: str, knowledge: Knowledge) -> RobotFile | None:
    """Return the file that describes a program's robot, as ``world.json`` beside the program names it.

    None for a robot type that a plugin declares.

    Raises:
        UserError: no plugin declares it, and no world beside it says where it is from.
    """
    beside = program.parent / "world.json"
    mounts = read_world(str(beside), knowledge, 0).robots if beside.is_file() else ()
    file = next((m.file for m in mounts if m.type == kind), None)
    if file is None and kind not in knowledge.robots:
        lacks = "has no robot of that type" if mounts else "is not there"
        raise UserError(
            f"There is no robot '{kind}'; {nearest(kind, knowledge.robots)}. If the robot was read from a file, give the program "
            f"inside its run directory, whose world.json names that file; '{beside}' {lacks}."
        )
    return file


def _with_file(rollout: Rollout, file: RobotFile | None) -> Rollout:
    """Return a run whose world names the robot's description file, so that the robot can be drawn from the saved
    run."""
    mounts = tuple(replace(m, file=file) for m in rollout.world.robots)
    return replace(rollout, world=replace(rollout.world, robots=mounts))


def _words(command: str) -> list[str]:
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise UserError(f"--on '{command}': {error}; quote it as in a shell.") from error
    if not words:
        raise UserError("--on: say the command that starts the robot's process, e.g. --on 'python my_robot.py'.")
    return words


def _print(rollout: Rollout, judged: JudgedRun | None, *, json_output: bool) -> None:
    if json_output:
        print(as_json(rollout_json(rollout) | ({"verdict": judged_json(judged)} if judged else {})))
        return
    print(rollout_text(rollout))
    if judged is not None:
        print(findings_text(judged.verdict, judged.remarks))


def _refuse_unfinished(program: Path, rollout: Rollout) -> None:
    """Raise NoSolution if a program did not come to its end."""
    if rollout.outcome != "finished":
        raise NoSolution(f"'{program}' did not come to its end ({rollout.outcome}): {rollout.reason}")


def _controller(arguments: argparse.Namespace) -> int:
    """Open a virtual robot controller's ports on loopback, and print the log of its programs.

    Raises:
        UserError: the world cannot be used, or a port is taken.
    """
    knowledge = Knowledge(plugin_choice(arguments).registry())
    place = read_world(arguments.world, knowledge, arguments.seed)
    if not place.robots:
        raise UserError(f"The world '{arguments.world}' has no robot, so there is nothing to control.")
    ended = knowledge.simulator.serve(
        place, knowledge.robots_of(place), mount=place.robots[0].name, host=arguments.host, seed=arguments.seed,
        say=lambda text: print(text, flush=True), seconds=arguments.seconds, idle=arguments.idle,
    )  # fmt: skip
    print(f"The controller was closed: {ended}.")
    return 0


def _execute(arguments: argparse.Namespace) -> int:
    if arguments.on is not None:
        if arguments.world or arguments.plan or arguments.goal or arguments.replan:
            raise UserError("--on runs a robot whose world is unknown here, so --world, --plan, --goal and --replan do not apply.")
        return _drive(arguments)
    if not arguments.world:
        raise UserError("Say where the program runs: --world with a run directory or scenario, or --on with a robot's process.")
    if arguments.replan and (arguments.plan or arguments.goal):
        raise UserError("--replan makes a new plan for each round, so --plan and --goal do not apply; judge the program of a round.")
    if arguments.replan:
        from .replan import execute_and_replan

        return execute_and_replan(arguments)
    return _simulate(arguments)


def add_commands(add: Add) -> None:
    """Add the commands ``execute`` and ``controller``, with their arguments, to the command line."""
    _add_execute(add("execute", _execute))
    _add_controller(add("controller", _controller))


def _add_execute(execute: argparse.ArgumentParser) -> None:
    execute.add_argument("program", type=Path, help="the text, such as program.script of a run directory")
    execute.add_argument(
        "--world", default="",
        help="a run directory, a world.json, or a scenario, whose real world with this seed is taken",
    )
    execute.add_argument(
        "--on", metavar="COMMAND",
        help="instead of --world: the process of a robot that takes actions, to which the program is streamed",
    )
    add_seed(execute)
    add_purpose(execute)
    execute.add_argument(
        "--replan", metavar="SCENARIO",
        help="where the program is stopped, resolve the rest of this scenario by what is read or seen then",
    )
    execute.add_argument(
        "--rounds", type=int, default=3,
        help="how many programs may run with --replan, the first one included; default 3",
    )
    execute.add_argument(
        "--verbose", action="store_true", help="with --replan: where the rest cannot be done, print every cause and not the first alone"
    )
    execute.add_argument(
        "--fault", metavar="'KEY: VALUE, ...'", action="append", default=[],
        help="what goes wrong meanwhile, such as 'grip_lost: 0.5 s, line: PickingUp, after: 1 s'; may be given again",
    )
    execute.add_argument(
        "--out", type=Path,
        help="folder for the recorded run: execution.json, rollout.npz with every sample, world.json, "
            "episode/; with --replan one for each round",
    )
    execute.add_argument("--no-episode", action="store_true", help="leave episode/ out")
    execute.add_argument(
        "--json", action="store_true",
        help="print as JSON: outcome, reason, seconds, peak_force [N], messages, poses; where it was judged, "
            "verdict",
    )


def _add_controller(controller: argparse.ArgumentParser) -> None:
    controller.add_argument(
        "--world", default="grasp_one_thing",
        help="a run directory, its world.json, or a scenario; default grasp_one_thing",
    )
    controller.add_argument("--host", default="127.0.0.1", help="a loopback address; default 127.0.0.1")
    controller.add_argument(
        "--seconds", type=duration, default=0.0, help="close after this time; 0 (default) for no limit"
    )
    controller.add_argument(
        "--idle", type=duration, default=600.0,
        help="close after this time without a client; default 600 s, 0 for no limit",
    )
    add_seed(controller)
