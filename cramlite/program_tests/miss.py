"""Findings of failed assertions: what happened, when, and in which line of the program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.entity_name import EntityName, thing_of
from ..model.run.rollout import Rollout, Touch

EFFECTOR = "effector"
"""Name of the gripper in recordings."""
HAND = "hand"
"""Name of the gripper in assertions, whatever the robot is called."""


class ProgramFailure(AssertionError):
    """Failure of an assertion about a program's run; the message has the finding, its time and line."""


class Miss(Value):
    """Finding of a failed assertion.

    Args:
        reason: what happened instead, a clause with numbers.
        time: when [s]; None where it is about no moment.
        about: names of the things that it is about, which are drawn.
        in_twins: whether twins were asked, too.
    """

    reason: str
    time: float | None = None
    about: tuple[str, ...] = ()
    in_twins: bool = True

    def sample(self, rollout: Rollout) -> int:
        """Return the index of the recorded sample at the time of the failed assertion; without a time the last index."""
        last = len(rollout.times) - 1
        return last if self.time is None else min(int(np.searchsorted(rollout.times, self.time)), last)

    def line(self, rollout: Rollout) -> int:
        """Return the line of the program that ran at the finding's time, from 1; 0 if none did."""
        return 0 if self.time is None else int(rollout.lines[self.sample(rollout)])

    def where(self, rollout: Rollout, text: str) -> Sequence[str]:
        """Return lines of text with the finding's time and its line of the program."""
        if self.time is None:
            return ()
        line, lines = self.line(rollout), text.splitlines()
        ran = (
            f", line {line}: {lines[line - 1].strip()[:100]}" if 0 < line <= len(lines) else ", after the program's end"
        )
        return (f"At {self.time:.2f} s{ran}",)


def name_is(recorded: str, asked: str) -> bool:
    """Check whether a recorded name means the thing or part that an assertion names, or a part of that thing."""
    name = EntityName.parse(asked)
    wanted = EntityName(EFFECTOR if name.thing == HAND else name.thing, name.part)
    return recorded == str(wanted) or (not wanted.part and thing_of(recorded) == wanted.thing)


def names_of(rollout: Rollout, names: Iterable[str]) -> None:
    """Check that the named bodies exist in a run's world.

    Raises:
        UserError: one is no thing of the world, nor the hand.
    """
    known = [HAND, *(t.name for t in rollout.world.things), *(m.name for m in rollout.world.robots)]
    for name in names:
        if thing_of(name) not in known:
            raise UserError(f"There is no '{thing_of(name)}' in the world; {nearest(thing_of(name), known)}.")


def said_touch(touch: Touch) -> str:
    """Describe a contact in words, such as "'hand' touches 'tray'"."""
    one, other = (name.replace(EFFECTOR, HAND) for name in (touch.a, touch.b))
    return f"'{one}' touches '{other}'"
