"""One episode of LIBERO: what the judge shows is planned and proven here, streamed there, and judged there."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import yaml
from connection import Judge
from goals import goal_sentences
from msgspec.structs import replace

from cramlite import Engine, NoSolution, Setting, Solution, Trace, UserError, read_scenario
from cramlite.model import Rollout, Value
from cramlite.model.rollout import save_rollout
from cramlite.planning.diagnosis import failure_text
from cramlite_plugins.backends.stream.messages import Action, Hello
from cramlite_plugins.backends.stream.run import stream
from cramlite_plugins.simulation.typed_program.machine import load_program

HERE = Path(__file__).parent
BUDGETS = {"libero_spatial": 220, "libero_object": 280, "libero_goal": 300, "libero_10": 520, "libero_90": 400}
"""Actions of an episode in the published protocol."""
SEARCH = {"sequences": 3, "proofs": 4}
"""Work that an episode's search may take: less than usual (12 and 8), so that a refusal takes a minute or two."""
REST = 20
"""Actions that do nothing, after which things are at rest: 1 s."""


class Result(Value, kw_only=True):
    """What came of an episode.

    Args:
        suite, task, state: which one.
        name: of the task.
        goal: in the words of cramlite; empty where it has none.
        outcome: "refused" (no program), or how the streamed program ended.
        reason: why, where it did not finish.
        proven: a program stood the proof in our model.
        first: action at which LIBERO's check was true for the first time; None for never.
        rest: whether it is true at rest.
        steps: actions taken until the program's end.
        budget: of the published protocol.
        resolving: seconds until the program was proven, the proof included, on a machine that may do other things, too.
    """

    suite: str
    task: int
    state: int
    name: str
    goal: tuple[str, ...] = ()
    outcome: str = "refused"
    reason: str = ""
    proven: bool = False
    first: int | None = None
    rest: bool = False
    steps: int = 0
    budget: int = 0
    resolving: float = 0.0


def play(judge: Judge, suite: str, task: int, state: int, folder: Path, twins: int = 0) -> Result:
    """Play an episode: one attempt, in which the judge's simulator is only ever sent actions.

    Args:
        folder: for the scene, the scenario and the program.
        twins: in how many worlds a program is tried before it is streamed.

    Raises:
        UserError: no such episode, or a judge that does not answer as it must.
    """
    begun = judge.reset(suite, task, state)
    hello = judge.hello()
    result = Result(suite=suite, task=task, state=state, name=begun["task"], budget=BUDGETS.get(suite, 0))
    engine, clock = Engine(files=[HERE / "panda.py"]), time.monotonic()
    try:
        goal, setting = prepare(engine, judge.scene(), hello, folder, twins)
        result = replace(result, goal=goal)
        solution = first_solution(engine, folder / "scenario.yaml", setting)
    except (UserError, NoSolution) as refused:
        return replace(result, reason=str(refused), resolving=time.monotonic() - clock)
    result = replace(result, proven=True, resolving=time.monotonic() - clock)
    (folder / "program.json").write_text(solution.code)
    rollout = stream(load_program(solution.code, setting.robot), setting.robot, judge)
    save_rollout(rollout, folder / "rollout.npz")
    return judged(judge, rollout, result)


def prepare(engine: Engine, scene: dict[str, Any], hello: Hello, folder: Path, twins: int) -> tuple[tuple[str, ...], Setting]:
    """Write scene and scenario of an episode, and build its setting: the goal, and where it is to be achieved."""
    folder.mkdir(parents=True, exist_ok=True)
    state = " ".join(f"{v:.17g}" for v in scene["qpos"])
    key = f'<keyframe><key name="state" qpos="{state}"/></keyframe></mujoco>'
    (folder / "scene.xml").write_text(scene["xml"].replace("</mujoco>", key))
    x, y, z, *turn = scene["base"]
    if abs(turn[0]) < 0.999999:
        raise UserError(f"The robot's base is turned by the quaternion {turn}; all of LIBERO's stand straight.")
    spec: dict[str, Any] = {
        "scenario": "episode", "robot": {"type": "libero_panda", "at": {"position": [x, y, z]}},
        "world": {"file": str(folder.resolve() / "scene.xml"), "keyframe": "state"}, "budget": SEARCH,
    }  # fmt: skip
    setting = engine.setting(read_scenario(spec | {"tasks": []}), twins=twins)
    goal = goal_sentences(scene, setting.world.things)
    (folder / "scenario.yaml").write_text(yaml.safe_dump(spec | {"goal": goal}, sort_keys=False))
    mount = replace(setting.world.robots[0], joints=hello.joints, opening=min(hello.opening, setting.robot.gripper.opening[1]))
    return tuple(goal), replace(setting, world=replace(setting.world, robots=(mount,)))


def first_solution(engine: Engine, scenario: Path, setting: Setting) -> Solution:
    """Resolve an episode's goal.

    Raises:
        NoSolution: nothing was proven.
    """
    trace = Trace()
    solution = next(engine.resolve(read_scenario(scenario), setting=setting, trace=trace), None)
    if solution is None:
        raise NoSolution(failure_text(trace, engine.registry.faults))
    return solution


def judged(judge: Judge, rollout: Rollout, result: Result) -> Result:
    """Ask the judge, now and when everything has come to rest."""
    ended = judge.check()
    still = Action(opening=float(rollout.opening[-1]), grip=10.0, delta=(0.0,) * 6)
    for _ in range(REST):
        judge.step(still)
    rested = judge.check()
    return replace(
        result, outcome=rollout.outcome, reason=rollout.reason, first=rested["first"], rest=rested["success"], steps=ended["steps"]
    )
