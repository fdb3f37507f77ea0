"""Continuation of an execution after the world has changed, for ``cramlite execute --replan`` with sensors
that report poses.

A program runs while a watcher compares what is read with what its proof showed. Where that deviates the arm brakes, belief takes what
was read, with what is in the hand, and the rest is resolved from there and proven. Nothing moves that was not proven from what is
believed, but the braking.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.errors import NoSolution, UserError
from ...base.value import Value
from ...model.designator_name import task_of
from ...model.fault import FaultKind
from ...model.run.readings import Deviation, Notice
from ...model.run.rollout import world_after_run
from ...planning.failure import brief_failure_text, failure_text
from ...planning.search.budget import Budget, budget_of
from ...planning.search.search import Effort, WholeWork
from ...planning.symbolic.planning_problem import planning_problem
from ...planning.task_goals import Goal
from ...planning.trace import Trace
from ...scenario.faults import foreseen
from ..candidates import attempts
from ..search_in_setting import search_in
from .expectation import EXACT, SIGMAS, Noise, RunWatch, expectation
from .next_program import Stopped, at_last, at_once, attempt_of, next_program
from .open_stages import stage_program
from .read_belief import STILL, real_after, setting_as_read, world_as_read
from .replanning import BACK, Attempt, Round, Say
from .rest_of_plan import rests_of_plan

if TYPE_CHECKING:
    from ...plugin.protocols import Candidate
    from ...scenario.scenario import Scenario
    from ..engine import Engine
    from ..solution import Solution

RESTING = 0.0003
"""Depth of a contact at rest [m]. A thing that was read deeper inside another is believed to stand on it, since a proof begins there."""
STOPS = {"halted": Deviation.REFUSED, "protective stop": Deviation.STOPPED, "killed": Deviation.KILLED}
"""Deviation for each outcome of a run that can be continued."""


ACKNOWLEDGED = "a protective stop is acknowledged by a person, who has looked why; execute again with --replan then"
REACHED = "the goal holds as things are"
SAME = 2
"""Largest number of times that a new program is sought after the same deviation in the same step."""
TO_DO: Mapping[Deviation, str] = {
    Deviation.NO_GRASP: "look whether the fingers close and the thing is between them",
    Deviation.GRASP_LOST: "look at pads, air and grip force, and where the thing fell",
    Deviation.SLIP: "look at pads and grip force; a smoother or heavier thing needs more of it",
    Deviation.GRIPPER: "look whether something is between the fingers, or the gripper is stuck",
    Deviation.MOVED: "put the thing where the arm reaches it, and keep it there",
    Deviation.FALLEN: "set the thing upright",
    Deviation.MISSING: "put the thing back, or ask for another goal",
    Deviation.ADDED: "take it out of the way",
    Deviation.CONTACT: "look what the arm met, and take it out of the way",
    Deviation.STUCK: "look what holds the arm or what it moves",
    Deviation.READINGS_LOST: "look at the camera and its connection",
    Deviation.READINGS_FROZEN: "look at the camera and its connection",
    Deviation.STOPPED: "look why the controller stopped the arm, and release the stop",
    Deviation.KILLED: "find out who ended the program",
    Deviation.REFUSED: "mend what the program's last message says",
    Deviation.GOAL_CHANGED: "ask for a goal that can be reached from there",
    Deviation.CANCELLED: "take what is in the hand",
    Deviation.GOAL_MISSED: "look what keeps the goal from holding",
}
"""Advice to a person where nothing more can be proven."""


class Stretch(Value):
    """Part of an execution with replanning: one run, the notice that ended it, and what was decided then.

    Args:
        round: the run, with its program and ``rollout``.
        notice: None where the program came to its end and the goal holds.
        decision: as a clause; "" where nothing was to be decided.
        thought: CPU time that it took [s].
    """

    round: Round
    notice: Notice | None
    decision: str = ""
    thought: float = 0.0

    @property
    def to_do(self) -> str:
        """What a person can do after a notice, in words; "" without a notice."""
        return TO_DO[self.notice.kind] if self.notice else ""


class GoingOn:
    """Execution that continues with new programs when the world changes.

    Args:
        scenario: that the first program was made from.
        engine: resolves the rest.
        seed: of sensors and of the search.
        say: is told what happens, in lines.
        noise: of the readings.
        verbose: whether a refusal has every cause, or three lines.
    """

    def __init__(
        self, scenario: Scenario, engine: Engine, seed: int = 0, say: Say = lambda _: None, noise: Noise = EXACT, *, verbose: bool = False
    ) -> None:
        self._failure = failure_text if verbose else brief_failure_text
        self.scenario, self.engine, self.seed, self.say, self.noise = scenario, engine, seed, say, noise
        self.setting = engine.setting(scenario, seed=seed, twins=0)
        self.goal = self._asked()
        self.at = 0  # the action of the plan that was under way
        self.step = ""  # and its step
        self.opened = 0  # stages of an open program that were resolved
        self.trace = Trace()
        self.noticed: Counter[tuple[Deviation, str, str]] = Counter()

    def _asked(self) -> tuple[str, ...] | None:
        """Return the goal in terms of things of the initial world: "the left one" stays the same thing after
        it was moved."""
        from ...planning.spoken_goals import spoken

        if self.scenario.spec.goal is None:
            return None
        scene, knowledge = self.setting.symbolic(self.engine.knowledge.taxonomy), self.engine.knowledge
        return spoken(Goal(self.scenario.spec.goal), scene, knowledge).says

    def execute(self, solution: Solution, most: int = 6) -> Iterator[Stretch]:
        """Run a proven program in the real world and, after each stop, resolve and run the rest of its plan; see
        ``stretches``.

        When the iterator has ended, ``setting`` is what was left.
        """
        before, self.goal = solution.setting, None
        real = before.real or before.world
        self.setting, last = replace(before, real=None), None
        for last in self.stretches(attempt_of(solution.candidate, real), most):
            yield last
        if last is not None:
            self._leave(last, real=before.real is not None)

    def _leave(self, last: Stretch, *, real: bool) -> None:
        """Update the believed world and the robot to how the last run left them."""
        rollout, world = last.round.rollout, self.setting.world
        left = world_after_run(rollout, world)
        stays = {t.name for t in left.things if math.dist(world.thing(t.name).pose.position, t.pose.position) <= STILL}
        relations = tuple(r for r in self.setting.relations if r[1] in stays)
        now = world_after_run(rollout, last.round.attempt.world) if real else None
        self.setting = replace(self.setting, world=left, relations=relations, real=now)

    def stretches(self, first: Attempt, most: int) -> Iterator[Stretch]:
        """Run a program, and go on with further ones from where it was stopped; ``most`` programs at most,
        the first included.

        Yields:
            Each stretch when it has ended; the last one reached the goal, or was cancelled.

        Raises:
            NoSolution: it cannot go on; says why. The arm stands still.
        """
        attempt = first
        self.setting = replace(self.setting, world=foreseen(first.world.faults, self.setting.world))
        for number in range(1, most + 1):
            watch, done = self._run(attempt)
            notice = self._noticed(watch, done)
            self.say(f"round {number}: {notice or done.said}")
            if (notice is None and not self._open) or (notice and notice.kind is Deviation.CANCELLED):
                yield Stretch(done, notice, "the arm stands still" if notice else "")
                return
            began = time.process_time()
            following, decision = self._decided(done, watch, notice, given_up=number == most) if notice else self._stage(done, watch)
            if decision == REACHED and self._open:
                following, decision = self._stage(done, watch)
            self.say(f"round {number}: {decision.splitlines()[0]}")
            yield Stretch(done, notice, decision, time.process_time() - began)
            if decision == REACHED:
                return
            if following is None:
                raise NoSolution(_stopped(number, notice, decision))
            attempt = following

    @property
    def _open(self) -> bool:
        """Whether stages that the scenario lists under 'then' have not yet been resolved.

        A changed goal replaces all of them.
        """
        return self.opened < len(self.scenario.spec.then)

    def _stage(self, done: Round, watch: RunWatch) -> tuple[Attempt | None, str]:
        """Return a proven program for the next stage of the scenario's 'then', else for that stage's 'else'.

        Programs are proven in the world of the last readings. None, with the reasons, if none is found.
        """
        self._believe(done, watch)
        number, self.opened, self.goal = self.opened, self.opened + 1, None
        world = real_after(done.rollout, done.attempt.world, self.setting.world.robots[0].holds)
        found, why = stage_program(self.scenario, number, self.engine, self.seed, lambda _: self.setting, self._failure)
        return (attempt_of(found.candidate, world) if found else None), why

    def _run(self, attempt: Attempt) -> tuple[RunWatch, Round]:
        knowledge, code = self.engine.knowledge, attempt.code
        proof = knowledge.run(code.text, self.setting.world, self.seed)
        watch = RunWatch(expectation(proof, code.origins, self.setting.robot), self.noise, self.seed)
        return watch, Round(attempt, knowledge.run(code.text, attempt.world, self.seed, watch=watch))

    def _noticed(self, watch: RunWatch, done: Round) -> Notice | None:
        """Return the notice that says why a run did not reach the goal; None if it reached it."""
        outcome, ran = done.rollout.outcome, [k for k, line in enumerate(done.rollout.lines) if line > 0]
        at = float(done.rollout.times[min(ran[-1] + 1, len(done.rollout.times) - 1) if ran else -1])
        if outcome == "noticed":
            return watch.notice
        if outcome != "finished":
            return Notice(STOPS.get(outcome, Deviation.REFUSED), at, done.rollout.reason, done.step)
        if done.step == BACK:
            return Notice(Deviation.GOAL_MISSED, at, "the arm went back, and the goal is still to be reached", BACK)
        if self.goal is None or self._holds(watch):
            return None
        return Notice(Deviation.GOAL_MISSED, at, f"'{' and '.join(self.goal)}' does not hold in the world as it was read", done.step)

    def _holds(self, watch: RunWatch) -> bool:
        """Whether the goal holds in the world as last sensed; things that were not sensed keep their last known pose."""
        assert watch.last is not None and self.goal is not None
        knowledge = self.engine.knowledge
        world = world_as_read(self.setting.world, watch.last, self.setting.world, self._closed)
        setting = replace(self.setting, world=world, relations=())
        try:
            problem = planning_problem(Goal(self.goal), setting.symbolic(knowledge.taxonomy), knowledge)
        except UserError:
            return False
        return problem.reached

    @property
    def _closed(self) -> float:
        return self.setting.robot.gripper.opening[0]

    def _decided(self, done: Round, watch: RunWatch, notice: Notice, *, given_up: bool) -> tuple[Attempt | None, str]:
        """Decide how to go on after a deviation: return the next program and why it was chosen, or None and why the
        execution ends."""
        key = notice.kind, notice.thing, notice.step.partition(".")[2]
        self.noticed[key] += 1
        if given_up:
            return None, "the allowed number of programs was executed"
        if notice.kind is Deviation.STOPPED and not _declared(done):
            return None, ACKNOWLEDGED
        if self.noticed[key] > SAME and done.step != BACK:
            return None, f"the same deviation was noticed {self.noticed[key]} times, so another try would not help"
        return self._next(done, watch, notice)

    def _next(self, done: Round, watch: RunWatch, notice: Notice) -> tuple[Attempt | None, str]:
        """Return a program to go on with after a stop and why it was chosen, or None and why there is none.

        It is proven in the world of the last sensor readings.
        """
        assert watch.last is not None
        if watch.last.poses is None:
            return None, "there are no readings; when they are back, execute again with --replan"
        if notice.kind is Deviation.GOAL_CHANGED and watch.last.goal:
            self.goal, self.opened = watch.last.goal, len(self.scenario.spec.then)
        self._believe(done, watch)
        self.trace = Trace()
        holds = self.setting.world.robots[0].holds
        if self.goal is not None and holds is None and self._holds(watch):
            return None, REACHED
        stopped = Stopped(done, notice, watch, self.setting, real_after(done.rollout, done.attempt.world, holds))
        whole, knowledge = budget_of(self.scenario), self.engine.knowledge
        budgets = at_once(whole), at_last(whole)
        found, why = next_program(stopped, lambda budget: self._candidates(done, budget), budgets, knowledge, self.seed, self.trace)
        return found, why if found else f"{why} {self._failure(self.trace, self.engine.registry.faults)}"

    def _believe(self, done: Round, watch: RunWatch) -> None:
        """Update the setting, in which the rest of the plan is resolved, from the last sensor readings of a run."""
        before, attempt = self.setting, done.attempt
        assert watch.last is not None
        read = world_as_read(before.world, watch.last, attempt.world, self._closed)
        self.setting = setting_as_read(before, read, self.engine.knowledge, SIGMAS * self.noise.position, RESTING)
        for note in self.setting.world.notes[len(read.notes) :]:
            self.say(note)
        names = [a.name for a in attempt.plan.actions]
        if done.step != BACK:
            self.at, self.step = next((k for k, n in enumerate(names) if n == task_of(done.step)), 0), done.step

    def _candidates(self, done: Round, budget: Budget) -> Iterator[Candidate]:
        """Generate programs for the rest of the plan that were proven in the belief, best first."""
        setting, engine = self.setting, self.engine
        if self.goal is not None:
            try:
                found = engine.resolve(Goal(self.goal), setting=setting, seed=self.seed, budget=budget, trace=self.trace)
                yield from (one.candidate for one in found)
            except UserError as error:
                self.trace.add(0, "goal", " and ".join(self.goal), "impossible", "engine", str(error), kind="goal")
            return
        whole = WholeWork(budget.work)
        for plan in rests_of_plan(done.attempt.plan, self.at, self.step, setting, engine.knowledge):
            search = search_in(setting, engine.knowledge, budget, self.trace, effort=Effort(whole=whole))
            yield from (c for c, verdict in attempts(search, plan, setting, engine.knowledge, engine.executors) if verdict.passed)


def _stopped(number: int, notice: Notice | None, decision: str) -> str:
    """Reason why an execution ends, for people."""
    if notice is None:
        return f"The program of round {number} came to its end. The arm stands still: {decision}"
    return f"The program of round {number} was stopped by {notice}. The arm stands still: {decision}. To do: {TO_DO[notice.kind]}."


def _declared(done: Round) -> bool:
    """Check whether a protective stop is a declared fault of the world, rather than one that the robot made
    itself."""
    stops = {str(f) for f in done.attempt.world.faults if f.kind is FaultKind.STOP}
    return any(m.text in stops for m in done.rollout.faults)
