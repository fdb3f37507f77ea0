"""Record of a run, for exporters: motions, forces, and the spans of the program's steps."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from ...base.value import Value
from ..designator_name import task_of
from ..episode import Event
from ..program.program import Code, Program
from .rollout import Rollout, Scene


class TimeSpan(Value):
    """Stretch of a run that one task, or one step of a task, took.

    Args:
        name: of the task, e.g. "3.Placing", or of the step, e.g. "3.Placing/lower".
        start, end: first and last instant [s].
    """

    name: str
    start: float
    end: float


class RunRecord(Value, dict=True):
    """Record of a run: a rollout with the program that ran, its events and its shapes.

    Args:
        name: of the program, or of the run's folder.
        rollout: what was recorded.
        joints: names of the arm's joints, in the order of ``rollout.joints``.
        scene: shapes, and where they are at every sample of the rollout.
        events: contacts, supports and grasps, as demonstrations are read.
        picture: renders one sample of the rollout: (height, width, 3) uint8.
        program, code: typed, and its text; None for a run whose folder does not hold them.
    """

    name: str
    rollout: Rollout
    joints: tuple[str, ...]
    scene: Scene
    events: tuple[Event, ...]
    picture: Callable[[int], Any]
    program: Program | None = None
    code: Code | None = None

    @cached_property
    def steps(self) -> tuple[TimeSpan, ...]:
        """Time spans of the steps in the order in which they ran; a step that ran twice has two."""
        return self._spans([self._origin(int(line)) for line in self.rollout.lines])

    @cached_property
    def tasks(self) -> tuple[TimeSpan, ...]:
        """Time spans of the tasks in the order in which they ran."""
        return self._spans([task_of(self._origin(int(line))) for line in self.rollout.lines])

    def _origin(self, line: int) -> str:
        return self.code.origin_of(line) if self.code is not None and line else ""

    def _spans(self, names: list[str]) -> tuple[TimeSpan, ...]:
        """Return a time span for each series of consecutive samples that have the same name of a step or task.

        It ends where the next one begins; samples without a name ("") have none.
        """
        times, last = self.rollout.times, len(names) - 1
        starts = [k for k, name in enumerate(names) if not k or names[k - 1] != name]
        ends = [*starts[1:], last]
        return tuple(
            TimeSpan(names[a], float(times[a]), float(times[b])) for a, b in zip(starts, ends, strict=True) if names[a]
        )
