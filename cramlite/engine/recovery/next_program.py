"""Program that follows a stopped one: the rest of the same program, another one from where the arm stands, or the way back.

Each is proven in the believed world before anything moves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.value import Value
from ..proof.proof import prove
from .read_belief import STILL
from .replanning import BACK, Attempt, Round, back_program, way_back
from .rest_of_program import may_be_finished, rest_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ...model.run.readings import Notice
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...planning.search.budget import Budget
    from ...planning.trace import Trace
    from ...plugin.catalogue import Knowledge
    from ...plugin.protocols import Candidate
    from ..setting import Setting
    from .expectation import RunWatch

AT_ONCE = {"expansions": 50, "proofs": 2, "sequences": 3, "work": 200}
"""Budget of the first search after a stop: searches that found a program from there took at most 32 expansions of a task sequence, and one
proof."""
AT_LAST = {"work": 1000}
"""Budget of the last search after a stop, beside the scenario's: it fails within some 20 s of CPU."""
Search = Callable[["Budget"], "Iterator[Candidate]"]
"""Search for proven programs that reach the rest of the goal, best first, within a budget."""


class Stopped(Value, eq=False):
    """Program that was stopped.

    Args:
        done: its run.
        notice, watch: why it was stopped, and the watcher of the run.
        setting: as believed since.
        world: as it really is since; the believed one for a world that nobody here simulates.
    """

    done: Round
    notice: Notice
    watch: RunWatch
    setting: Setting
    world: World

    @property
    def hand(self) -> str:
        """Clause for messages that names the payload; "" if the hand is empty."""
        holds = self.setting.world.robots[0].holds
        return f", with '{holds.thing}' in the hand" if holds else ""


def next_program(
    stopped: Stopped, search: Search, budgets: tuple[Budget, Budget], knowledge: Knowledge, seed: int, trace: Trace
) -> tuple[Attempt | None, str]:
    """Return the proven program that follows a stopped one, and why it was chosen; None if there is none.

    Args:
        budgets: of the search where the arm was stopped, and of the one once it went back or could not.
        trace: is told how the rest of the same program fared.
    """
    first, whole = budgets
    hand, stands = stopped.hand, stopped.done.step != BACK
    rest = _same_program(stopped, knowledge, seed, trace) if may_be_finished(stopped.notice, stopped.watch) else None
    if rest is not None:
        return rest, f"goes on with the rest of the same program{hand}: all things are where its proof had them"
    candidate = next(search(first if stands else whole), None)
    back = way_back_of(stopped, knowledge, seed) if candidate is None else None
    if back is not None:
        return back, f"the arm goes back the way it came{hand}: no program was proven from here"
    if candidate is None and stands and first != whole:
        candidate = next(search(whole), None)
    if candidate is not None:
        return attempt_of(candidate, stopped.world), f"goes on from here{hand}: {candidate.plan}"
    return None, f"no program was proven from here{hand}."


def attempt_of(candidate: Candidate, world: World) -> Attempt:
    """Return a proven candidate as an attempt, a program to be run in a world."""
    return Attempt(candidate.plan, candidate.program, candidate.written, world, candidate)


def _same_program(stopped: Stopped, knowledge: Knowledge, seed: int, trace: Trace) -> Attempt | None:
    """Return the rest of the program that was stopped; None if it cannot be finished from here, or its proof fails."""
    done, setting = stopped.done, stopped.setting
    proven = done.attempt.candidate
    rest = rest_of(proven, done.step, setting) if proven is not None else None
    if rest is None:
        return None
    ran, verdict = prove(rest, knowledge, setting.backend, seed)
    said = f"rest of the same program from {done.step} on"
    trace.add(0, "rest", said, "proven" if verdict.passed else "failed", "engine", verdict.reason, kind="proof")
    return attempt_of(ran, stopped.world) if verdict.passed and ran.code is not None else None


def way_back_of(stopped: Stopped, knowledge: Knowledge, seed: int) -> Attempt | None:
    """Return a program that leads the arm back along its recorded path; None if it is back already, or a run in the belief shows that it
    fails or moves a thing."""
    done, setting = stopped.done, stopped.setting
    path = way_back(done.rollout.joints) if done.step != BACK else ()
    if not path:
        return None
    program = back_program(done.attempt.program, path, setting.world.robots[0].joints)
    code = setting.backend.emit(program, setting.robot)
    proof, holds = knowledge.run(code.text, setting.world, seed), setting.world.robots[0].holds
    held = holds.thing if holds else ""
    still = all(_moved(proof, t.name) <= STILL for t in setting.world.things if t.movable and t.name != held)
    return Attempt(done.attempt.plan, program, code, stopped.world) if proof.outcome == "finished" and still else None


def at_once(whole: Budget) -> Budget:
    """Return the small budget of the first search after a stop: the arm should rather go back the way it came
    than wait for a longer search."""
    return _at_most(whole, AT_ONCE)


def at_last(whole: Budget) -> Budget:
    """Return the budget of the last search after a stop."""
    return _at_most(whole, AT_LAST)


def _at_most(whole: Budget, limits: Mapping[str, int]) -> Budget:
    """Return a budget lowered to some limits; 0 is no limit."""
    return replace(whole, **{name: min(most, getattr(whole, name) or most) for name, most in limits.items()})


def _moved(rollout: Rollout, name: str) -> float:
    track = rollout.poses[name]
    return max(math.dist(tuple(row[:3]), tuple(track[0][:3])) for row in track)
