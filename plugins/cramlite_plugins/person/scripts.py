"""Shipped scripts of the simulated person: six of whole demonstrations, and one for each task that a hand can show."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from cramlite.model import Pose, Rollout, Value, World
from cramlite.plugin import Performance, Performer, RecordScript

from .both_hands import from_above, waiting
from .hanging import hang_onto_hanger
from .sight_of_person import Scene, half_extents, see_hanging, see_standing
from .taking_off import PALM, take_off_hanger
from .task_scripts import TASK_SCRIPTS
from .variety import fetch, hang, not_in_container, not_on_peg, recorded

#: The palm's edge stays above what an object stands on: half its 56 mm (hand.py), and 7 mm for tilt and drift [m].
FLOOR = 0.035

Act = Callable[[Performer, Scene, Pose], None]


class Script(Value):
    """Script of a demonstration in which a person puts a thing with a hole onto a peg, or takes it off.

    Args:
        see: what the person makes out in the world.
        act: how they move, given where the hand will close.
        missed: what did not come about that it is for; "" where all did.
        after: what the recorder makes of it.
        both_hands: the person has two.
    """

    see: Callable[[World], Scene]
    act: Act
    missed: Callable[[Performer, Scene], str] | None = None
    after: Callable[[Rollout, Scene, np.random.Generator], Rollout] | None = None
    both_hands: bool = False

    def prepare(self, world: World, _fillers: Mapping[str, Any], rng: np.random.Generator) -> Performance:
        """Find the script's things in the world, choose the grasp, and return the person's performance."""
        scene = self.see(world)
        grasp = _grasp(scene, rng)
        hands = [grasp, *([from_above(scene.product.pose, scene.product)] if self.both_hands else [])]
        missed, after = self.missed, self.after
        return Performance(
            act=lambda person: self.act(person, scene, grasp),
            rests=tuple(Pose((0, 0, 0), h.quaternion) for h in hands),
            start=lambda: (_start(scene, grasp, rng), *([waiting(scene, rng)] if self.both_hands else [])),
            missed=(lambda person: missed(person, scene)) if missed else None,
            recorded=(lambda rollout: after(rollout, scene, rng)) if after else None,
        )


def _grasp(scene: Scene, rng: np.random.Generator) -> Pose:
    """Grasp of the hand in the product's frame at the start: from the front, across the product's width,
    turned and tilted at random, low enough for palm and wrist to pass under the peg."""
    half = half_extents(scene.product)
    top = scene.hole.pose.position[2] - PALM - 0.02
    height = min(rng.uniform(-0.25, 0.25) * half[2], top)
    tilt, yaw, roll = rng.normal(0, [0.10, 0.06, 0.05])
    if scene.stands:  # palm and wrist stay above what it stands on
        height, tilt = max(height, FLOOR - half[2]), abs(tilt)
    front = scene.product.pose.inverse().rotate(-scene.facing)
    level = Pose.from_axes((0, 0, height), front, (0, 0, -1))
    offset = np.array(level.position) + rng.uniform(-0.15, 0.15) * half[1] * np.array(front)
    turned = Pose((0, 0, 0), level.quaternion) * Pose.from_rotvec((0, 0, 0), (yaw, tilt, roll))
    return scene.product.pose * Pose(tuple(offset), turned.quaternion)


def _start(scene: Scene, grasp: Pose, rng: np.random.Generator) -> Pose:
    """Random start pose of a hand: in front of the object, where a relaxed person holds it, turned a
    little."""
    side = np.cross(scene.facing, (0, 0, 1))
    place = np.array(grasp.position) + scene.facing * rng.uniform(0.22, 0.35)
    sideways, up = rng.uniform(-0.2, 0.2), rng.uniform(-0.12, 0.08)
    place += side * sideways + np.array([0, 0, abs(up) if scene.stands else up])
    return Pose(tuple(place), (grasp * Pose.from_rotvec((0, 0, 0), rng.normal(0, 0.2, 3).tolist())).quaternion)


#: Scripts of whole demonstrations by name.
SCRIPTS: Mapping[str, Script] = {
    "take_off_hanger": Script(see_hanging, take_off_hanger),
    "hang_onto_hanger": Script(see_standing, hang_onto_hanger),
    "take_off_hanger_varied": Script(see_hanging, fetch, not_in_container, recorded),
    "hang_onto_hanger_varied": Script(see_standing, hang, not_on_peg, recorded),
    "take_off_hanger_distracted": Script(
        see_hanging, partial(fetch, distracted=True), not_in_container, recorded, both_hands=True
    ),
    "hang_onto_hanger_distracted": Script(
        see_standing, partial(hang, distracted=True), not_on_peg, recorded, both_hands=True
    ),
}


def shipped_scripts() -> Iterable[RecordScript]:
    """List the shipped scripts of the simulated person: of whole demonstrations, and of single tasks."""
    whole = (RecordScript(name, script.prepare) for name, script in SCRIPTS.items())
    return [*whole, *(RecordScript(name, prepare) for name, prepare in TASK_SCRIPTS.items())]
