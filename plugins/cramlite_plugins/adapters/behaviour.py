"""Behaviour for py_trees that resolves a designator, a list of tasks or a goal, and runs the proven program.

Needs py_trees 2.3 or later (``pip install 'cramlite[py-trees]'``). Source of the life cycle (initialise, update,
terminate): py_trees documentation, "Behaviours".
"""

from __future__ import annotations

import threading
from collections.abc import Callable

import py_trees

from cramlite import Engine, Goal, RuleSpec, Setting, Solution, TaskSpec, Trace, nearest_miss
from cramlite.plugin import CramliteError

Work = Goal | TaskSpec | RuleSpec | list[TaskSpec | RuleSpec]


class Resolve(py_trees.behaviour.Behaviour):  # type: ignore[misc]  # an extra, known only where it is installed
    """Behaviour that resolves a goal in a thread of its own, then hands the program over to ``run``.

    RUNNING while it resolves; SUCCESS when ``run`` says so; FAILURE with the nearest miss as feedback message. Ticked
    again after that it goes on from the setting that its own run left. When it is interrupted the search is stopped.

    Args:
        name: of the behaviour.
        engine: whose plugins answer.
        goal: one designator, a list of tasks, or a goal.
        setting: where; it is asked when the behaviour begins, so that behaviours can follow each other.
        run: is given the proven program; whether it was carried out.
    """

    def __init__(
        self,
        name: str,
        engine: Engine,
        goal: Work,
        setting: Callable[[], Setting],
        run: Callable[[Solution], bool],
    ) -> None:
        super().__init__(name)
        self._engine, self._goal, self._setting, self._run = engine, goal, setting, run
        self._worker: threading.Thread | None = None
        self._stop = threading.Event()
        self._said = ""
        self.solution: Solution | None = None

    def initialise(self) -> None:
        """Start resolving."""
        self._leave()
        self._stop, self.solution, self._said = threading.Event(), None, ""
        self._worker = threading.Thread(target=self._work, args=(self._stop,), daemon=True)
        self._worker.start()

    def _work(self, stop: threading.Event) -> None:
        trace = Trace()
        try:
            found = self._engine.resolve(self._goal, setting=self._setting(), trace=trace, stop=stop.is_set)
            solution = next(found, None)
        except CramliteError as error:
            self._said = str(error)
            return
        miss = nearest_miss(trace.entries)
        self._said = "" if solution else f"{miss.designator}: {miss.reason}" if miss else "nothing was found"
        if not stop.is_set():
            self.solution = solution

    def update(self) -> py_trees.common.Status:
        """Return RUNNING until there is a program or none, then SUCCESS or FAILURE."""
        assert self._worker is not None
        if self._worker.is_alive():
            self.feedback_message = "resolving"
            return py_trees.common.Status.RUNNING
        if self.solution is None:
            self.feedback_message = self._said
            return py_trees.common.Status.FAILURE
        done = self._run(self.solution)
        self.feedback_message = f"{self.solution.plan}: {'done' if done else 'its run failed'}"
        return py_trees.common.Status.SUCCESS if done else py_trees.common.Status.FAILURE

    def terminate(self, new_status: py_trees.common.Status) -> None:
        """Stop the search where the behaviour is interrupted."""
        if new_status == py_trees.common.Status.INVALID:
            self._leave()

    def _leave(self) -> None:
        self._stop.set()
        if self._worker is not None:
            self._worker.join()


class Place:
    """Setting of a behaviour tree: what one behaviour's run left is where the next one begins.

    ``place.now`` is the ``setting`` of behaviours, ``place.run`` their ``run``: the text is executed in the simulator, in
    the world as it really is then, and judged there.
    """

    def __init__(self, engine: Engine, setting: Setting) -> None:
        self._engine, self._setting = engine, setting

    def now(self) -> Setting:
        """Return the current setting."""
        return self._setting

    def run(self, solution: Solution) -> bool:
        """Execute a program's text; True if it succeeded."""
        done = self._engine.execute(solution)
        if done.succeeded:
            self._setting = done.setting_after()
        return done.succeeded
