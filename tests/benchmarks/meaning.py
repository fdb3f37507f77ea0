"""Closed loop of meaning: is a run of each task type read as that task, by the rules that read demonstrations?

    python tests/benchmarks/meaning.py [--seeds 10] [--first 0] [--only grasping,placing]

Every scenario under scenarios/tasks/ is resolved; its first program's run becomes an episode by the event detection for
demonstrations, and the rules interpret it twice: "states" cuts the run where states change and knows nothing else;
"cuts" also cuts it where the program's tasks end, which a log of a robot says, but not what they are (between two samples:
at the later, else at the earlier one). A task counts as read if an action within its span matches it with the same things
in its roles.

The same program is then run with a gripper that stays open, and in a world without the thing that it is about; neither
run may be read as the task. Tasks that need no grasp may be, with an open gripper, and are left out there.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from figure import add_figure, rate, write
from msgspec.structs import replace

from cramlite.experiment.figure import Number

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.task_scenarios import REFUSED, attempt

from cramlite import Engine, data_folder
from cramlite.base.run_directory import content_key
from cramlite.model import Action, Episode, Event, Pose, Rollout, SetGripper
from cramlite.plugin import PADDING, Candidate, Interpreted

GRASPED = {
    "artm:CloseGripperTask", "artm:ExtractHoleFromPeg", "artm:InsertHoleOntoPeg", "artm:OpenGripperTask",
    "artm:SlidingObject", "artm:Ungrasping", "soma:Closing", "soma:Grasping",
    "soma:Holding", "soma:Opening", "soma:PickingUp", "soma:Placing",
    "soma:Pouring", "soma:PuttingDown", "soma:Releasing", "soma:Transporting",
}  # fmt: skip
Spans = dict[str, tuple[float, float]]


def spans(candidate: Candidate) -> Spans:
    """Spans in which the code of each task ran: their first and last samples."""
    rollout, code = candidate.rollout, candidate.code
    assert rollout is not None and code is not None
    found: Spans = {}
    for now, line in zip(rollout.times.tolist(), rollout.lines.tolist(), strict=True):
        if line and (task := code.task_of(int(line))):
            found[task] = (found.get(task, (now, now))[0], now)
    return found


def looks_included(when: Spans, candidate: Candidate, task: Action) -> Spans:
    """The looks that a program begins with, before the plan could be made, belong to the task that looks: one span."""
    own = [a.name for a in candidate.actions if a.task == task.task and (a.name == task.name or a.name.startswith("0."))]
    found = [when[n] for n in own if n in when]
    rest = {n: span for n, span in when.items() if n not in own}
    return {**rest, task.name: (min(a for a, _ in found), max(b for _, b in found))}


def earlier(when: Spans, rollout: Rollout) -> Spans:
    """The spans from the last sample before the code: it began between the two."""
    step = float(rollout.times[1] - rollout.times[0])
    return {task: (max(first - step, float(rollout.times[0])), last) for task, (first, last) in when.items()}


def with_cuts(episode: Episode, when: Spans) -> Episode:
    """The episode with an action of no stated kind for each task."""
    actions = [Event(f"act_{k}", "soma:PhysicalAction", "action", a, b, {}) for k, (a, b) in enumerate(when.values())]
    return replace(episode, events=(*episode.events, *(e for e in actions if e.end > e.start)))


def within(engine: Engine, episode: Episode, span: tuple[float, float]) -> Iterator[Interpreted]:
    """The actions that overlap a span, and those that follow it within the padding of the rules."""
    for action in engine.interpret(episode).actions:
        if action.start < span[1] + PADDING and action.end > span[0]:
            yield action


def reads(engine: Engine, episode: Episode, span: tuple[float, float], task: Action) -> tuple[bool, set[str]]:
    """Whether the task was read with its own things, and everything that was read."""
    meant = {k: (o.entity or "").split("/")[0] for k, o in task.roles.items()}
    found, own = set(), False
    for action in within(engine, episode, span):
        for match in action.matches:
            found.add(match.task)
            same = all(match.roles.get(k, v).split("/")[0] == v for k, v in meant.items())
            own = own or (match.task == task.task and same)
    return own, found


def spoiled(engine: Engine, candidate: Candidate, what: str, task: Action) -> Candidate | None:
    """The same program with a gripper that stays open, or without the thing that the task is about, run again."""
    moved = ("Patient", "Locatum", "Source", "Destination")
    things = {(o.entity or "").split("/")[0] for k, o in task.roles.items() if k in moved}
    world, program = candidate.world, candidate.program
    if what == "open":
        wide = candidate.robot.gripper.opening[1]
        program = replace(program, steps=tuple(
            replace(s, opening=wide, expect="any") if isinstance(s, SetGripper) else s for s in program.steps
        ))  # fmt: skip
    else:
        things = {t for t in things if world.thing(t).movable}
        world = world.moved({t: Pose((3.0, 3.0, 0.1)) for t in things})
    if (what == "open" and task.task not in GRASPED) or (what == "gone" and not things):
        return None
    simulator, backend = engine.knowledge.simulator, engine.knowledge.backends[candidate.robot.backend]
    code = backend.emit(program, candidate.robot)
    rollout = simulator.execute(code.text, world, engine.knowledge.robots, mount=program.robot, seed=0)
    return replace(candidate, code=code, rollout=rollout, episode=engine.knowledge.episodes.detect(rollout, program.name))


def one(engine: Engine, name: str, seed: int, tally: Counter[str], matrix: dict[str, Counter[str]]) -> None:
    candidate, verdict, reasons = attempt(engine, name, seed)
    tally["runs"] += 1
    if candidate is None or verdict is None or not verdict.passed:
        print(f"{name} seed {seed}: not proven: {reasons[:200]}")
        return
    tally["proven"] += 1
    wanted = "".join(w.capitalize() for w in name.split("_"))
    task = next(a for a in candidate.actions if a.task.split(":")[1] == wanted and not a.name.startswith("0."))
    when = looks_included(spans(candidate), candidate, task)
    assert candidate.episode is not None
    either = False
    for kind, episode in (("states", candidate.episode), ("cuts", with_cuts(candidate.episode, when))):
        own, found = reads(engine, episode, when[task.name], task)
        if kind == "cuts" and not own and candidate.rollout is not None:
            before = earlier(when, candidate.rollout)
            own, found = reads(engine, with_cuts(candidate.episode, before), before[task.name], task)
        tally[kind] += own
        either = either or own
        matrix.setdefault(task.task, Counter()).update(f"{f.split(':')[1]}" for f in found if kind == "cuts")
        if not own:
            print(
                f"{name} seed {seed}: by {kind} not read as {task.task}, but as {', '.join(sorted(found)) or 'nothing'}"
            )
    tally["either"] += either
    for what in ("open", "gone"):
        bad = spoiled(engine, candidate, what, task)
        if bad is not None and bad.episode is not None:
            tally[f"{what} runs"] += 1
            end = float(bad.rollout.times[-1]) if bad.rollout else 0.0
            if reads(engine, with_cuts(bad.episode, spans(bad)), (0.0, end), task)[0]:
                tally[f"{what} read"] += 1
                print(
                    f"{name} seed {seed}: read as {task.task} with {'an open gripper' if what == 'open' else 'nothing there'}"
                )


def main() -> None:
    """Print what failed, the matrix, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1, help="how many seeds of the worlds")
    parser.add_argument("--first", type=int, default=0, help="the first of them")
    parser.add_argument("--only", default="", help="scenarios, separated by commas")
    add_figure(parser)
    options = parser.parse_args()
    rules = content_key(*sorted(data_folder("task_rules").glob("*.yaml")))
    print(f"rules {rules}")
    engine, tally, matrix = Engine(), Counter[str](), dict[str, Counter[str]]()
    begin = time.process_time()
    names = options.only.split(",") if options.only else sorted(REFUSED)
    for seed in range(options.first, options.first + options.seeds):
        for name in names:
            one(engine, name, seed, tally, matrix)
        print(f"seeds {options.first} to {seed}: {dict(tally)}", flush=True)
        report(tally, matrix)
    print(f"{time.process_time() - begin:.0f} s of CPU time; rules {rules}")
    write(options, numbers(tally), f"{options.first} to {options.first + options.seeds - 1}")


def numbers(tally: Counter[str]) -> list[Number]:
    """Return the rates of the figure."""
    runs = [("proven", "proven", "runs"), ("read as the task, cut where states change", "states", "runs"),
            ("read as the task, cut where the program's tasks end", "cuts", "runs"), ("read as the task, cut at either", "either", "runs"),
            ("read as the task although the gripper stays open", "open read", "open runs"),
            ("read as the task although the thing is gone", "gone read", "gone runs")]  # fmt: skip
    return [rate(what, tally[hits], tally[of]) for what, hits, of in runs if tally[of]]


def report(tally: Counter[str], matrix: dict[str, Counter[str]]) -> None:
    """Print what runs were read as, and the sums."""
    print("executed -> read as (number of runs), cut at the ends of tasks")
    for task, found in sorted(matrix.items()):
        print(f"{task:34s} " + ", ".join(f"{k} {n}" for k, n in found.most_common()))
    print(", ".join(f"{k} {tally[k]}" for k in ("runs", "proven", "states", "cuts", "either")))
    print(f"open gripper: {tally['open read']} of {tally['open runs']} read as the task")
    print(f"thing removed: {tally['gone read']} of {tally['gone runs']} read as the task", flush=True)


if __name__ == "__main__":
    main()
