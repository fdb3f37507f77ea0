"""Recovery of executions from faults: each fault is drawn before a run, and the same run is made without it.

``python tests/benchmarks/going_on.py [--first N] [--count N]`` prints a JSON line a run. A fault can be mended, by this rule that was
written before the first run, unless its thing is gone, the task is cancelled, or the fingers stay wider than the thing: then the arm must
stop safely, with the right diagnosis. A run is right if the goal holds in the simulator's own state at the end, or if it stopped so.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from figure import add_figure, rate, value, write

from cramlite import Engine, NoSolution, UserError, read_scenario
from cramlite.engine.recovery.expectation import Noise
from cramlite.engine.recovery.going_on import GoingOn, Stretch
from cramlite.engine.recovery.replanning import Attempt
from cramlite.experiment.figure import Number
from cramlite.model import replace
from cramlite.model.run.rollout import world_after_run
from cramlite.planning.symbolic.planning_problem import planning_problem
from cramlite.planning.task_goals import Goal
from cramlite.scenario.faults import faulty, read_fault_text

NOISE = Noise(position=0.001, turn=0.01, force=0.3)
FLOOR = "  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}\n"
SCENES = {
    "shelf": (
        "goal: [block on shelf]\n", ["block on shelf"], "block", "can", 0.050,
        "  - {name: block, model: block, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}\n"
        "  - {name: can, model: block, at: {position: [0.35, 0.35, 51 mm]}, with: {size: [40 mm, 40 mm, 100 mm]}}\n"
        "  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}\n",
    ),
    "tasks": (
        "tasks:\n  - {task: Grasping, Patient: block}\n  - {task: PickingUp, Locatum: block, Relatum: floor}\n"
        "  - {task: Placing, Locatum: block, Relatum: tray}\n", ["block on tray"], "block", "jar", 0.060,
        "  - {name: block, model: block, at: {position: [0.55, -0.1, 41 mm]}, with: {size: [60 mm, 60 mm, 80 mm]}}\n"
        "  - {name: jar, model: block, at: {position: [0.4, -0.25, 41 mm]}, with: {size: [45 mm, 45 mm, 80 mm]}}\n"
        "  - {name: tray, model: table, at: {position: [0.4, 0.35, 30 mm]}, with: {size: [0.3 m, 0.2 m, 20 mm]}}\n",
    ),
    "two": (
        "goal: [tin on tray, cup on tray]\n", ["tin on tray", "cup on tray"], "tin", "cup", 0.045,
        "  - {name: tin, model: block, at: {position: [0.5, 0.05, 36 mm]}, with: {size: [45 mm, 45 mm, 70 mm]}}\n"
        "  - {name: cup, model: block, at: {position: [0.45, 0.25, 46 mm]}, with: {size: [50 mm, 40 mm, 90 mm]}}\n"
        "  - {name: tray, model: table, at: {position: [0.45, -0.3, 50 mm]}, with: {size: [0.35 m, 0.25 m, 20 mm]}}\n",
    ),
}  # fmt: skip
"""Name -> what is asked, the goal, what is handled, what stands about, how wide the former is [m], and the things."""
KINDS = (
    "none", "moved", "moved_other", "grip_lost", "slip", "missing", "added", "fallen", "closes_short", "readings", "protective_stop",
    "killed", "goal", "cancelled", "payload",
)  # fmt: skip
RIGHT = {
    "moved": {"ObjectMoved"}, "moved_other": {"ObjectMoved"}, "grip_lost": {"GraspLost", "GraspSlip", "ObjectMoved", "NoGrasp"},
    "slip": {"GraspSlip", "GraspLost"}, "missing": {"ObjectMissing"}, "added": {"ObjectAppeared"},
    "fallen": {"ObjectFallen", "ObjectMoved"},
    "closes_short": {"NoGrasp", "GraspLost", "GraspSlip", "GripperDeviation"}, "readings": {"ReadingsLost", "ReadingsFrozen"},
    "protective_stop": {"ProtectiveStop"}, "killed": {"ProgramKilled"}, "goal": {"GoalChanged"}, "cancelled": {"Cancelled"},
    "payload": {"UnexpectedContact"}, "none": set(),
}  # fmt: skip
"""Kind -> the diagnoses that are right for it."""
ENDS = {"missing", "cancelled", "closes_short"}
BEFORE, AFTER = ("Grasping/transfer", "Grasping/approach"), ("PickingUp/lift", "PuttingDown/transfer")


@lru_cache(maxsize=8)
def proven(scene: str) -> tuple[Any, Engine, Any]:
    asked, _, _, _, _, things = SCENES[scene]
    path = Path(tempfile.mkdtemp()) / f"{scene}.yaml"
    path.write_text(f"scenario: {scene}\n{asked}robot: {{type: ur5e}}\nthings:\n{FLOOR}{things}")
    scenario, engine = read_scenario(path), Engine()
    return scenario, engine, next(engine.resolve(scenario, setting=engine.setting(scenario, twins=0)))


def drawn(kind: str, scene: str, rng: np.random.Generator) -> str:
    """A fault with trigger and severity, as text; "" for none."""
    _, _, thing, other, width, _ = SCENES[scene]
    after, angle = f"after: {rng.uniform(0.0, 0.8):.2f} s", rng.uniform(0, 2 * np.pi)
    before, late = f"line: {rng.choice(BEFORE)}, {after}", f"line: {rng.choice(AFTER)}, {after}"
    way = f"by: [{rng.uniform(0.03, 0.08) * np.cos(angle):.3f}, {rng.uniform(0.03, 0.08) * np.sin(angle):.3f}, 0]"
    return {
        "none": "", "moved": f"moved: {thing}, {way}, near: {thing}, within: 0.18 m", "moved_other": f"moved: {other}, {way}, {late}",
        "grip_lost": f"grip_lost: {rng.uniform(0.3, 1.0):.2f} s, {late}",
        "slip": f"slip: 0.02, lasts: {rng.uniform(0.5, 1.5):.2f} s, {late}",
        "missing": f"missing: {thing}, {before}", "added": f"added: {other}, {rng.choice([before, late])}",
        "fallen": f"fallen: {thing}, {before}", "closes_short": f"closes_short: {width + rng.uniform(0.006, 0.02):.3f}",
        "readings": f"readings: {rng.choice(['lost', 'frozen'])}, lasts: {rng.uniform(1, 3):.1f} s, {rng.choice([before, late])}",
        "protective_stop": f"protective_stop: {rng.uniform(1, 8):.2f} s", "killed": f"killed: true, {rng.choice([before, late])}",
        "goal": f"goal: [{other} on {'shelf' if scene == 'shelf' else 'tray'}], {rng.choice([before, late])}",
        "cancelled": f"cancelled: true, {rng.choice([before, late])}", "payload": f"payload: {rng.uniform(0.2, 0.5):.2f} kg, {before}",
    }[kind]  # fmt: skip


def episode(number: int) -> dict[str, Any]:
    """One execution with its fault."""
    rng = np.random.default_rng([number, 2023])
    kind = KINDS[number % len(KINDS)]
    scene = str(rng.choice(sorted(s for s in SCENES if kind != "added" or s != "two")))
    fault = drawn(kind, scene, rng)
    scenario, engine, solution = proven(scene)
    world = faulty(solution.setting.world, [read_fault_text(fault)] if fault else [])
    first = Attempt(solution.plan, solution.program, solution.candidate.code, world)
    going, done, why, began = GoingOn(scenario, engine, number, lambda _: None, NOISE), [], "", time.process_time()
    try:
        for stretch in going.stretches(first, 6):
            done.append(stretch)
    except NoSolution as error:
        why = " ".join(str(error).split())[:300]
    spent = round(time.process_time() - began, 1)
    return {"number": number, "kind": kind, "scene": scene, "fault": fault, "cpu": spent} | told(kind, scene, done, why, going)


def told(kind: str, scene: str, done: list[Stretch], why: str, going: GoingOn) -> dict[str, Any]:
    """What came of a run."""
    notices = [s.notice for s in done if s.notice]
    reached, diagnoses = holds(kind, scene, done[-1], going), [str(n.kind) for n in notices]
    happened = [f.time for f in done[0].round.rollout.faults]
    right = bool(set(diagnoses[:1]) & RIGHT[kind])
    stopped = kind == "cancelled" or bool(why)
    return {
        "mendable": kind not in ENDS, "reached": reached, "stopped": stopped, "diagnoses": diagnoses, "why": why,
        "well": (stopped and right) if kind in ENDS else reached, "alarm": kind == "none" and bool(notices),
        "triggered": bool(happened) or kind == "none",
        "to_notice": round(notices[0].time - happened[0], 3) if notices and happened and kind != "closes_short" else None,
        "thought": [round(s.thought, 2) for s in done if s.decision],
        "peak_n": round(max(float(s.round.rollout.contact_force().max()) for s in done), 1),
    }  # fmt: skip


def holds(kind: str, scene: str, last: Stretch, going: GoingOn) -> bool:
    """Whether the goal holds in the simulator's own state, whatever was read."""
    goal = SCENES[scene][1] if kind != "goal" else going.goal or ()
    after = world_after_run(last.round.rollout, last.round.attempt.world)
    setting = replace(going.setting, world=replace(after, robots=(replace(after.robots[0], holds=None),)), relations=())
    try:
        problem = planning_problem(Goal(tuple(goal)), setting.symbolic(going.engine.knowledge.taxonomy), going.engine.knowledge)
    except UserError:  # what it names is gone
        return False
    return problem.reached and last.round.rollout.outcome in ("finished", "noticed", "killed", "protective stop")


def numbers(rows: list[dict[str, Any]]) -> Iterator[Number]:
    """The figure's numbers."""
    faults, controls = [r for r in rows if r["kind"] != "none"], [r for r in rows if r["kind"] == "none"]
    mended, ends = [r for r in faults if r["mendable"]], [r for r in faults if not r["mendable"]]
    yield rate("faults that one arm could mend: goal reached", sum(r["well"] for r in mended), len(mended))
    yield rate("the others: stopped safely with the right diagnosis", sum(r["well"] for r in ends), len(ends))
    yield rate("controls in which something was noticed", sum(r["alarm"] for r in controls), len(controls))
    late, thought = [r["to_notice"] for r in faults if r["to_notice"] is not None], [t for r in faults for t in r["thought"]]
    for what, found in (("from fault to notice, simulated time", late), ("from notice to the next program, CPU time", thought)):
        yield value(what, float(np.median(found)), "s", "median")
        yield value(what, float(np.percentile(found, 95)), "s", "95 %")
    yield value("force felt at most", max(r["peak_n"] for r in rows), "N")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--count", type=int, default=2 * len(KINDS))
    add_figure(options)
    asked = options.parse_args()
    rows = []
    for number in range(asked.first, asked.first + asked.count):
        rows.append(episode(number))
        print(json.dumps(rows[-1]), flush=True)
    write(asked, numbers(rows), range(asked.first, asked.first + asked.count))


if __name__ == "__main__":
    main()
