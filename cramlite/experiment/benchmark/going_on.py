"""Runs of programs in a benchmark's simulator that changes its world during execution, with replanning after each stop.

The benchmark sends readings; when the program stops, the rest is planned anew.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import UserError
from ...base.run_directory import write_whole
from ...base.value import Value
from ...engine.expectation import Limits, RunWatch, expectation
from ...engine.read_belief import world_as_read
from ...model.readings import Deviation, Notice
from ...planning.trace import Trace
from ...scenario.scenario import read_scenario

if TYPE_CHECKING:
    from ...engine.engine import Engine
    from ...engine.setting import Setting
    from ...engine.solution import Solution
    from ...model.rollout import Rollout
    from ...model.world import World
    from .protocol import Benchmark

ROUNDS = 6
"""Programs of an attempt, the first one included."""
ANOTHER = Limits(place=0.03, lean=0.4, width=math.inf, push=math.inf, slower=3.0, later=4.0)
"""Limits of deviations for runs in another simulator than the one of the proof: in it grasped things settle otherwise,
fingers creep, forces differ."""
STOPS = {"halted": Deviation.REFUSED, "protective stop": Deviation.STOPPED}
"""Outcome -> its description, of runs that did not come to their end."""
PERSON = "a protective stop waits for a person, and an episode has none"


class Played(Value):
    """Outcome of a run in the benchmark's simulator: of a program, and of the programs that replaced it after
    stops.

    Args:
        rollout: of the last program.
        notices: what was noticed in each but the last, in order.
        thought: CPU time from each notice to the next program [s].
        reason: why it was not gone on with; "" where it was not stopped.
        corrections: of poses that were read and cannot be, in clauses.
    """

    rollout: Rollout
    notices: tuple[Notice, ...]
    thought: tuple[float, ...]
    reason: str = ""
    corrections: tuple[str, ...] = ()


def play_on(benchmark: Benchmark, engine: Engine, solution: Solution, folder: Path, twins: int) -> Played:
    """Run a program in the benchmark's simulator; after each stop prove and run a program for the rest of the goal.

    Args:
        folder: for the scenes and scenarios of later rounds.
        twins: in how many their programs are tried.
    """
    notices, thought, corrections, asked = list[Notice](), list[float](), list[str](), None

    def played(reason: str = "") -> Played:
        return Played(rollout, tuple(notices), tuple(thought), reason, tuple(corrections))

    known = frozenset(solution.setting.world.notes)
    for number in range(1, ROUNDS + 1):
        code, proof = solution.candidate.code, solution.candidate.rollout
        assert code is not None and proof is not None
        if number > 1:
            write_whole(folder / f"round_{number}" / f"program{code.suffix}", code.text)
        watch = RunWatch(expectation(proof, code.origins), limits=ANOTHER, asked=asked)
        rollout = benchmark.play(code.text, solution.setting, watch)
        notice = watch.notice if rollout.outcome == "noticed" else None
        if rollout.outcome in STOPS:
            notice = Notice(STOPS[rollout.outcome], float(rollout.times[-1]), rollout.reason)
        if notice is None:
            return played()
        notices.append(notice)
        asked = watch.last.goal if watch.last is not None else asked
        if notice.kind is Deviation.CANCELLED or number == ROUNDS:
            return played(str(notice))
        if notice.kind is Deviation.STOPPED:
            return played(f"{notice}; {PERSON}")
        began = time.process_time()
        following, why, notes = _following(benchmark, engine, _read(solution.setting, watch), folder / f"round_{number + 1}", twins)
        thought.append(time.process_time() - began)
        corrections += [n for n in notes if n not in known]
        if following is None:
            return played(f"{notice}; {why}")
        solution = following
    raise AssertionError("the last round returns")


def _following(
    benchmark: Benchmark, engine: Engine, read: World, folder: Path, twins: int
) -> tuple[Solution | None, str, tuple[str, ...]]:
    """Search for a program from the benchmark's present world; return the first proven one or None, the reason
    why there is none, and the notes on corrected poses of the world."""
    trace = Trace()
    notes: tuple[str, ...] = ()
    try:
        path, setting = benchmark.setting(engine, folder, twins, read)
        notes = setting.world.notes
        found = engine.resolve(read_scenario(path), setting=setting, trace=trace)
        solution = next(found, None)
    except UserError as error:
        return None, str(error), notes
    from ...planning.failure import failure_text

    return solution, "" if solution else failure_text(trace, engine.registry.faults), notes


def _read(before: Setting, watch: RunWatch) -> World:
    """Return the world at the moment when a run stopped: the world before the run, with the poses read last
    and the payload in the hand."""
    assert watch.last is not None
    return world_as_read(before.world, watch.last, before.world, before.robot.gripper.opening[0])
