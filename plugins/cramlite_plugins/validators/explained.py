"""Explanation of each grip of a run by the plan: the step by which the plan takes the thing into the hand,
and the one by which it lets go."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from cramlite.model import Handover, Rollout, enclosing_names, walk
from cramlite.plugin import Candidate

from ..shapes.itself import remembered
from .grips import Grip, grips
from .task_times import inner_tasks, origins

EARLY, LATE = 0.5, 0.2
"""Longest times between the beginning or end of a grip and the code of its handover, in the two directions [s]: opening fingers leave a
thing before they have arrived, and contacts of stiff pads chatter (``grips.SHORTEST``)."""


class ExplainedGrip(NamedTuple):
    """Grip of a run with the steps of the plan that begin and end it, or the reason why no task explains it.

    Args:
        grip: thing and samples.
        wrong: why no task explains it; "" where one does.
        at: the sample that ``wrong`` is about.
        left: the handover by which it ends; None where it lasts until the end of the run, or no handovers are known.
        taken: whether its beginning is explained, whatever is wrong with its end.
    """

    grip: Grip
    wrong: str
    at: int
    left: Handover | None
    taken: bool = True


@remembered
def explained_grips(candidate: Candidate) -> list[ExplainedGrip]:
    """Return every grip of a run with the step of the plan that ends it, or the reason why no task explains it."""
    run = _Run(candidate, candidate.ran)
    return [run.explained(grip) for grip in grips(candidate.ran)]


@remembered
def explained_at(candidate: Candidate) -> list[str]:
    """Return the name of the payload at each sample; "" where no task took the held thing into the hand."""
    held = [""] * len(candidate.ran.times)
    for found in explained_grips(candidate):
        for k in range(found.grip.first, found.grip.last + 1) if found.taken else ():
            held[k] = found.grip.thing
    return held


class _Run:
    """Things that the plan takes into the hand or lets go of, with the designator and the task whose code
    runs at each sample of a run."""

    def __init__(self, candidate: Candidate, rollout: Rollout) -> None:
        self.candidate, self.times = candidate, rollout.times
        self.came_from, self.tasks = origins(candidate), inner_tasks(candidate)
        self.handovers = candidate.handovers
        order = dict.fromkeys(s.origin for s in walk(candidate.program.steps))
        self.order = {origin: k for k, origin in enumerate(order)}

    def explained(self, grip: Grip) -> ExplainedGrip:
        if self._declared_move(grip):
            return ExplainedGrip(grip, "", grip.first, None)
        if self.handovers is None or self._own_way(grip):
            wrong = "" if self._about(grip.first, grip.thing) else "no task that runs then is about it"
            return ExplainedGrip(grip, wrong, grip.first, None, taken=not wrong)
        if not self._near(grip.thing, grip.first, taken=True):
            return ExplainedGrip(grip, "no task of the plan takes it then", grip.first, None, taken=False)
        if grip.last == len(self.times) - 1 and self._kept(grip.thing):
            return ExplainedGrip(grip, "", grip.first, None)
        left = self._near(grip.thing, grip.last, taken=False)
        if left is None:
            return ExplainedGrip(grip, "no task of the plan lets go of it then", grip.last, None)
        late = next(self._after(left, grip), None)
        if late is not None:
            said = f"{left.by} lets go of it, but it is still in the hand during {self.came_from[late]}"
            return ExplainedGrip(grip, said, late, left)
        return ExplainedGrip(grip, "", grip.first, left)

    def _declared_move(self, grip: Grip) -> bool:
        """Check whether all tasks during a grip may move the thing without holding it.

        Then both pads of open fingers pushed it, and no grasp began.
        """
        allowed = self.candidate.allowances
        tasks = set(self.tasks[grip.first : grip.last + 1])
        return all(t in allowed and grip.thing in allowed[t].moves for t in tasks) and not self._taken_in(tasks, grip.thing)

    def _taken_in(self, tasks: set[str], thing: str) -> bool:
        found = self.handovers or ()
        return any(h.thing == thing and tasks & set(enclosing_names(h.by)) for h in found)

    def _own_way(self, grip: Grip) -> bool:
        """Whether a grip begins and ends in one and the same task, and the plan does not state what that task
        grasps.

        False if the plan states when it takes the gripped thing, or lets go of it.
        """
        if any(h.thing == grip.thing for h in self.handovers or ()):
            return False
        tasks = {self._whole(k) for k in (grip.first, grip.last)}
        spoken = {n for h in self.handovers or () for n in enclosing_names(h.by)}
        return len(tasks) == 1 and not tasks & (spoken | {""})

    def _whole(self, sample: int) -> str:
        """Name of the action of the plan that runs at a sample; "" if none does."""
        names = set(enclosing_names(self.came_from[sample]))
        return next((a.name for a in self.candidate.actions if a.name in names), "")

    def _about(self, sample: int, thing: str) -> bool:
        """Whether a task that runs at a sample, or a part into which it was decomposed, has a thing in one of its roles."""
        names = set(enclosing_names(self.came_from[sample]))
        acting = (a for a in (*self.candidate.actions, *self.candidate.parts) if a.name in names)
        return any(o.thing == thing for a in acting for o in a.roles.values())

    def _near(self, thing: str, sample: int, *, taken: bool) -> Handover | None:
        """Return the step of the plan that takes, or lets go of, a thing at about a sample; None without one."""
        now = self.times[sample]
        before, after = (LATE, EARLY) if taken else (EARLY, LATE)
        near = {o for t, o in zip(self.times, self.came_from, strict=True) if now - before <= t <= now + after}
        names = {n for o in near for n in enclosing_names(o)} | ({""} if taken and now <= EARLY else set())
        return next((h for h in self.handovers or () if (h.thing, h.taken) == (thing, taken) and h.by in names), None)

    def _kept(self, thing: str) -> bool:
        """Whether the plan's last act on a thing takes it into the hand, so that it is still there when the
        plan ends."""
        last = next((h for h in reversed(self.handovers or ()) if h.thing == thing), None)
        return last is not None and last.taken

    def _after(self, left: Handover, grip: Grip) -> Iterator[int]:
        """Samples of a grip that goes on although the program is past the step that lets go of the thing."""
        until, end = self.order.get(left.by, math.inf), self.times[grip.last] - LATE
        for k in range(grip.first, grip.last):
            if self.order.get(self.came_from[k], 0) > until and self.times[k] < end:
                yield k
