"""Records of runs, as exporters take them: a rollout with its shapes, events and pictures."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..model.run.run_record import RunRecord

if TYPE_CHECKING:
    from ..model.program.program import Code, Program
    from ..model.run.rollout import Rollout
    from ..plugin.catalogue import Knowledge

PICTURE = (640, 480)
"""Width and height of pictures [pixels]."""


def record_of(
    rollout: Rollout, knowledge: Knowledge, name: str, program: Program | None = None, code: Code | None = None
) -> RunRecord:
    """Make the record of a run that exporters read, from the run's rollout.

    Args:
        name: of the run; the program's own name is taken where there is a program.

    Raises:
        KeyError, IndexError, ValueError: the run was not in the world that the rollout has.
    """
    mount = next((m for m in rollout.world.robots if m.name == rollout.effector), None)
    robots = knowledge.robots_of(rollout.world)
    return RunRecord(
        name=program.name if program else name,
        rollout=rollout,
        joints=robots[mount.type].joints if mount else (),
        scene=knowledge.simulator.scene(rollout, robots, range(len(rollout.times))),
        events=knowledge.episodes.detect(rollout, name).events,
        picture=pictures_of(rollout, knowledge),
        program=program,
        code=code,
    )


def pictures_of(rollout: Rollout, knowledge: Knowledge, size: tuple[int, int] = PICTURE) -> Callable[[int], Any]:
    """Return a function that renders one sample of a run: (height, width, 3) uint8; ``size`` is (width,
    height) [pixel]."""
    robots = knowledge.robots_of(rollout.world)
    return lambda sample: knowledge.simulator.picture(rollout, sample, robots, size)


def sample_at(rollout: Rollout, share: float) -> int:
    """Return the sample at a share of a run's time: 0 is the start, 1 the end.

    Raises:
        ValueError: it is no share.
    """
    if not 0 <= share <= 1:
        raise ValueError(f"'at' is {share}; it is a share of the run's time, from 0 to 1")
    return round(share * (len(rollout.times) - 1))
