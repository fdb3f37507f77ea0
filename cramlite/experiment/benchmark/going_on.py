"""Runs of programs in a benchmark's simulator that changes its world during execution, with replanning after each stop.

The benchmark sends readings; when the program stops, the rest is planned anew.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.errors import UserError
from ...base.run_directory import write_whole
from ...base.value import Value
from ...engine.recovery.expectation import Expectation, Limits, RunWatch, expectation
from ...engine.recovery.next_program import Stopped, attempt_of, next_program, way_back_of
from ...engine.recovery.read_belief import world_as_read
from ...engine.recovery.replanning import BACK, Attempt, Round
from ...model.geometry import Pose
from ...model.run.readings import Deviation, Notice
from ...planning.search.budget import budget_of
from ...planning.symbolic.planning_problem import planning_problem
from ...planning.task_goals import Goal
from ...planning.trace import Trace
from ...scenario.scenario import read_scenario

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ...engine.engine import Engine
    from ...engine.setting import Setting
    from ...engine.solution import Solution
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...planning.search.budget import Budget
    from ...plugin.protocols import Candidate
    from .protocol import Benchmark

ROUNDS = 6
"""Largest number of programs that an attempt runs, the first one included."""
ANOTHER = Limits(place=0.03, lean=0.4, width=math.inf, push=math.inf, slower=3.0, later=4.0)
"""Limits of deviations for runs in another simulator than that of the proof, where grasped things settle differently, fingers creep and
forces differ."""
STOPS = {"halted": Deviation.REFUSED, "protective stop": Deviation.STOPPED}
"""Outcome of a run that ended early -> class of the deviation."""
PERSON = "a protective stop waits for a person, and an episode has none"


class Played(Value):
    """Outcome of a run in the benchmark's simulator: of a program, and of the programs that replaced it after
    stops.

    Args:
        rollout: of the last program.
        notices: what was noticed in each but the last, in order.
        thought: CPU time from each notice to the next program [s].
        decisions: why each next program was chosen, in clauses.
        reason: why it was not gone on with; "" where it was not stopped.
        corrections: of poses that were read and cannot be, in clauses.
    """

    rollout: Rollout
    notices: tuple[Notice, ...] = ()
    thought: tuple[float, ...] = ()
    decisions: tuple[str, ...] = ()
    reason: str = ""
    corrections: tuple[str, ...] = ()


def play_on(benchmark: Benchmark, engine: Engine, solution: Solution, folder: Path, twins: int) -> Played:
    """Run a program in the benchmark's simulator; after each stop, and where the goal was missed, prove and run another one.

    Args:
        folder: for the scenes and scenarios of later rounds.
        twins: in how many their programs are tried, but for the rest of one that was stopped.
    """
    notices, thought, decisions, corrections, asked = list[Notice](), list[float](), list[str](), list[str](), None
    setting, known, offsets = solution.setting, frozenset(solution.setting.world.notes), dict[str, Pose]()
    attempt = attempt_of(solution.candidate, setting.world)

    def played(reason: str = "") -> Played:
        return Played(done.rollout, tuple(notices), tuple(thought), tuple(decisions), reason, tuple(corrections))

    for number in range(1, ROUNDS + 1):
        if number > 1:
            write_whole(folder / f"round_{number}" / f"program{attempt.code.suffix}", attempt.code.text)
        watch = RunWatch(_expected(attempt, engine, setting), limits=ANOTHER, asked=asked, offsets=offsets)
        done = Round(attempt, benchmark.play(attempt.code.text, setting, watch))
        notice = _noticed(done, watch) or _missed(benchmark, engine, done, folder / "end")
        if notice is None:
            return played()
        notices.append(notice)
        asked = watch.last.goal if watch.last is not None else asked
        if notice.kind is Deviation.CANCELLED or number == ROUNDS:
            return played(str(notice))
        if notice.kind is Deviation.STOPPED:
            return played(f"{notice}; {PERSON}")
        began = time.process_time()
        following, setting, why = _following(benchmark, engine, (done, notice, watch, setting), folder / f"round_{number + 1}", twins)
        thought.append(time.process_time() - began)
        corrections += [n for n in setting.world.notes if n not in known]
        if following is None:
            return played(f"{notice}; {why}")
        decisions.append(why)
        attempt, offsets = following, _offsets(watch, setting.world)
    raise AssertionError("the last round returns")


def _expected(attempt: Attempt, engine: Engine, setting: Setting) -> Expectation:
    """Return the expected course of a run, as its proof recorded it; a program without a recorded proof is simulated again."""
    proof = attempt.candidate.rollout if attempt.candidate else None
    if proof is None:
        proof = engine.knowledge.run(attempt.code.text, setting.world, setting.seed)
    return expectation(proof, attempt.code.origins, setting.robot)


def _noticed(done: Round, watch: RunWatch) -> Notice | None:
    """Return the notice that says why a run did not come to its end; None if it did, or its time was over."""
    outcome, ended = done.rollout.outcome, float(done.rollout.times[-1])
    if outcome == "noticed":
        return watch.notice
    if outcome in STOPS:
        return Notice(STOPS[outcome], ended, done.rollout.reason, done.step)
    return None


def _missed(benchmark: Benchmark, engine: Engine, done: Round, folder: Path) -> Notice | None:
    """Return the notice that the goal does not hold at rest, although the program came to its end; else None."""
    if done.rollout.outcome != "finished" or (done.step != BACK and holds_here(benchmark, engine, folder) is not False):
        return None
    benchmark.rest()
    held = holds_here(benchmark, engine, folder)
    if held or (held is None and done.step != BACK):
        return None
    return Notice(Deviation.GOAL_MISSED, float(done.rollout.times[-1]), "the program ended, and the goal does not hold", done.step)


def holds_here(benchmark: Benchmark, engine: Engine, folder: Path) -> bool | None:
    """Return whether the goal, as cramlite understands it, holds in the benchmark's present world; None if that cannot be told.

    Args:
        folder: for the scene and scenario of that world.
    """
    try:
        path, setting = benchmark.setting(engine, folder, 0)
        goal = Goal(tuple(map(str, read_scenario(path).spec.goal or ())))
        problem = planning_problem(goal, setting.symbolic(engine.knowledge.taxonomy), engine.knowledge)
        return problem.reached
    except UserError:
        return None


def _following(
    benchmark: Benchmark, engine: Engine, ran: tuple[Round, Notice, RunWatch, Setting], folder: Path, twins: int
) -> tuple[Attempt | None, Setting, str]:
    """Return the first proven program from the benchmark's present world, or None, with the setting of that world, and why the program was
    chosen or none was found.

    Args:
        ran: a run that was stopped, why, its watcher, and the setting before it.
    """
    from ...planning.failure import failure_text

    done, notice, watch, before = ran
    trace, setting = Trace(), before
    try:
        path, setting = benchmark.setting(engine, folder, twins, _read(before, watch))
        scenario, now = read_scenario(path), setting

        def search(budget: Budget) -> Iterator[Candidate]:
            return (s.candidate for s in engine.resolve(scenario, setting=now, budget=budget, trace=trace))

        stopped = Stopped(done, notice, watch, setting, setting.world)
        budgets = (budget_of(scenario),) * 2  # an episode's actions are few: the arm goes back where no search helps
        found, why = next_program(stopped, search, budgets, engine.knowledge, setting.seed, trace)
    except UserError as error:
        setting = replace(before, world=_read(before, watch))
        back = way_back_of(Stopped(done, notice, watch, setting, setting.world), engine.knowledge, setting.seed)
        return back, setting, f"the arm goes back the way it came, to see more: {error}" if back else str(error)
    return found, setting, why if found else f"{why} {failure_text(trace, engine.registry.faults)}"


def _offsets(watch: RunWatch, believed: World) -> dict[str, Pose]:
    """Return the believed pose of each thing that was read, in the frame of its pose as read last."""
    read = (watch.last.poses if watch.last else None) or {}
    return {t.name: read[t.name].inverse() * t.pose for t in believed.things if t.name in read}


def _read(before: Setting, watch: RunWatch) -> World:
    """Return the world at the moment when a run stopped: the world before the run, with the poses read last
    and the payload in the hand."""
    assert watch.last is not None
    return world_as_read(before.world, watch.last, before.world, before.robot.gripper.opening[0])
