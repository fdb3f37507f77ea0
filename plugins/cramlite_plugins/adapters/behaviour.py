"""Behaviour for py_trees that resolves a designator, a list of tasks or a goal, and runs the proven program.

Needs py_trees 2.3 or later (``pip install 'cramlite[py-trees]'``). Source of the life cycle (initialise, update,
terminate): py_trees documentation, "Behaviours".
"""

from __future__ import annotations

import threading
from collections.abc import Callable

import py_trees

from cramlite import (
    Engine,
    Goal,
    GoingOn,
    NoSolution,
    RuleSpec,
    Scenario,
    Setting,
    Solution,
    Stretch,
    TaskSpec,
    Trace,
    nearest_miss,
)
from cramlite.model import Deviation, Notice
from cramlite.plugin import CramliteError

Work = Goal | TaskSpec | RuleSpec | list[TaskSpec | RuleSpec]


class Resolve(py_trees.behaviour.Behaviour):  # type: ignore[misc]  # an extra, known only where it is installed
    """Behaviour that resolves a goal and runs the program, both in a thread of its own: no tick waits for either.

    RUNNING meanwhile, with what is being done as feedback message; SUCCESS when ``run`` says so; FAILURE with the nearest miss,
    or what went wrong, as feedback message. Ticked again after that it goes on from the setting that its own run left. When it
    is interrupted the search is stopped and ``cancel`` is called; if it is begun again before that has ended, it waits.

    Args:
        name: of the behaviour.
        engine: whose plugins answer.
        goal: one designator, a list of tasks, or a goal.
        setting: where; it is asked when the behaviour begins, so that behaviours can follow each other.
        run: is given the proven program; whether it was carried out.
        cancel: stops what ``run`` has begun, e.g. the robot; by default ``run`` is waited for, not stopped.
    """

    def __init__(
        self,
        name: str,
        engine: Engine,
        goal: Work,
        setting: Callable[[], Setting],
        run: Callable[[Solution], bool],
        cancel: Callable[[], object] | None = None,
    ) -> None:
        super().__init__(name)
        self._engine, self._goal, self._setting, self._run, self._cancel = engine, goal, setting, run, cancel
        self._job: _Job | None = None
        self._left: _Job | None = None

    @property
    def solution(self) -> Solution | None:
        """Program that was found; None before that, and after an interruption."""
        return self._job.solution if self._job else None

    def initialise(self) -> None:
        """Prepare a new search; it starts at the first tick at which the search before it has ended."""
        self._job = _Job(self._work)

    def update(self) -> py_trees.common.Status:
        """Return RUNNING until the program has run or none was found, then SUCCESS or FAILURE."""
        assert self._job is not None
        if self._left is not None and self._left.thread.is_alive():
            self.feedback_message = "waiting for what was interrupted to end"
            return py_trees.common.Status.RUNNING
        if not self._job.begun:
            self._job.begin()
        self.feedback_message = self._job.status_text()
        if self._job.thread.is_alive():
            return py_trees.common.Status.RUNNING
        return py_trees.common.Status.SUCCESS if self._job.succeeded else py_trees.common.Status.FAILURE

    def terminate(self, new_status: py_trees.common.Status) -> None:
        """Stop the search and the run when the behaviour tree interrupts this behaviour; do not wait for their end."""
        if new_status != py_trees.common.Status.INVALID or self._job is None:
            return
        self._job.stop.set()
        if self._job.begun:
            self._left = self._job
            if self._job.running and self._cancel is not None:
                self._cancel()
        self._job = None

    def _work(self, job: _Job) -> None:
        """Resolve the goal, then run the program; executed in the job's thread."""
        try:
            found = self._engine.resolve(self._goal, setting=self._setting(), trace=job.trace, stop=job.stop.is_set)
            job.solution = next(found, None)
            if job.solution is None:
                miss = nearest_miss(job.trace.entries)
                job.outcome = f"{miss.designator}: {miss.reason}" if miss else "nothing was found"
            elif not job.stop.is_set():
                job.running = True
                job.succeeded = self._run(job.solution)
                job.outcome = f"{job.solution.plan}: {'done' if job.succeeded else 'its run failed'}"
        except CramliteError as error:
            job.outcome = str(error)
        finally:
            job.running = False


class _Job:
    """One search and one run of a behaviour, in a thread of its own.

    After an interruption the thread goes on with its own job only, which nobody reads any more.
    """

    def __init__(self, work: Callable[[_Job], None]) -> None:
        self.thread = threading.Thread(target=work, args=(self,), daemon=True)
        self.stop, self.trace = threading.Event(), Trace()
        self.solution: Solution | None = None
        self.begun = self.running = self.succeeded = False
        self.outcome = ""

    def begin(self) -> None:
        self.begun = True
        self.thread.start()

    def status_text(self) -> str:
        """Sentence on the progress of the search or run, or on its outcome once it has ended."""
        if self.outcome and not self.thread.is_alive():
            return self.outcome
        if self.running:
            return f"running {self.solution.plan}" if self.solution else "running"
        made = self.trace.entries
        return f"resolving: {len(made)} decisions, the last about {made[-1].designator}" if made else "resolving"


class Place:
    """World, robot and belief that the behaviours of a tree share; each behaviour starts where the last
    successful run ended.

    ``place.now`` is the ``setting`` of behaviours, ``place.run`` their ``run``: the text is executed in the simulator, in
    the world as it really is then, and judged there.
    """

    def __init__(self, engine: Engine, setting: Setting) -> None:
        self._engine, self._setting = engine, setting

    def now(self) -> Setting:
        """Return the world, robot and belief as the runs so far left them, for the next behaviour of the
        tree."""
        return self._setting

    def run(self, solution: Solution) -> bool:
        """Execute a program's text; True if it succeeded."""
        done = self._engine.execute(solution)
        if done.succeeded:
            self._setting = done.setting_after()
        return done.succeeded


NOTICE = "cramlite/notice"
"""Key on the blackboard under which the last notice is; its value is None before the first notice, and after a run without one."""


class WatchedPlace(Place):
    """World, robot and belief that the behaviours of a tree share; a run that deviates is continued with a new program.

    The notice of each deviation goes to the blackboard.

    There ``cramlite/notice`` is a dictionary: ``type`` (a class of the ontology), ``step``, ``thing``, ``reason``, ``measured``, ``limit``,
    ``unit``, ``decision`` and ``to_do``, what a person could do. A tree chooses a recovery by them when a run fails.

    Args:
        scenario: where.
        seed: of its world.
        rounds: programs that a run may take, the first one included.
    """

    def __init__(self, engine: Engine, scenario: Scenario, seed: int = 0, rounds: int = 6) -> None:
        super().__init__(engine, engine.setting(scenario, seed=seed))
        self._scenario, self._seed, self._rounds = scenario, seed, rounds
        self._board = py_trees.blackboard.Client(name="cramlite")
        self._board.register_key(key=NOTICE, access=py_trees.common.Access.WRITE)
        self._board.set(NOTICE, None)
        self.notices: list[Notice] = []

    def run(self, solution: Solution) -> bool:
        """Execute a program's text, continuing with new programs after deviations; True if the end was
        reached, False if stuck or cancelled."""
        going = GoingOn(self._scenario, self._engine, self._seed)
        self._board.set(NOTICE, None)
        cancelled = False
        try:
            for stretch in going.execute(solution, self._rounds):
                cancelled = stretch.notice is not None and stretch.notice.kind is Deviation.CANCELLED
                self._tell(stretch)
        except NoSolution:
            return False
        finally:
            self._setting = going.setting
        return not cancelled

    def _tell(self, stretch: Stretch) -> None:
        notice = stretch.notice
        if notice is None:
            return
        self.notices.append(notice)
        numbers = {"measured": notice.measured, "limit": notice.limit, "unit": notice.unit}
        what = {"type": f"cram:{notice.kind}", "step": notice.step, "thing": notice.thing, "reason": notice.reason}
        self._board.set(NOTICE, {**what, **numbers, "decision": stretch.decision, "to_do": stretch.to_do})
