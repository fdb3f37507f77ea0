"""Pictures of a rollout: any sample of it, drawn from its recorded poses."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import mujoco

from cramlite import Pose, Robot, Rollout

from .compile import compile_world
from .index import RobotIndex
from .recorder import effector_of
from .render import render


def picture(rollout: Rollout, sample: int, robots: Mapping[str, Robot], size: tuple[int, int]) -> Any:
    """One sample as (height, width, 3) uint8; ``size`` is (width, height) in pixels."""
    compiled = _compiled(_ById(rollout, robots))
    data, index = compiled.data(), effector_of(compiled, rollout.effector)
    for thing in rollout.world.things:
        if thing.movable:
            row = rollout.poses[thing.name][sample]
            compiled.place(data, thing.name, Pose(tuple(row[:3]), tuple(row[3:])))
    if isinstance(index, RobotIndex):
        data.qpos[list(index.joints)] = rollout.joints[sample]
        index.set_opening(compiled.model, data, float(rollout.opening[sample]))
    mujoco.mj_forward(compiled.model, data)
    return render(compiled.model, data, width=size[0], height=size[1])


class _ById:
    """A rollout as a cache key: one model serves all its pictures."""

    def __init__(self, rollout: Rollout, robots: Mapping[str, Robot]) -> None:
        self.rollout, self.robots = rollout, robots

    def __hash__(self) -> int:
        return id(self.rollout)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _ById) and other.rollout is self.rollout


@lru_cache(maxsize=1)
def _compiled(key: _ById) -> Any:
    return compile_world(key.rollout.world, key.robots, hand=not key.rollout.world.robots)
