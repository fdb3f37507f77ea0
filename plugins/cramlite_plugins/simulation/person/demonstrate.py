"""Demonstrations by a scripted person; physics decides whether they succeed.

A script is a sequence of intentions (reach, grip, pull along the peg, carry). It knows where things are, as a person
who looks at them does, but nothing holds unless contacts and friction hold it. All variety (approach, speeds,
hesitation, detours, grip, height of release, tremor) comes from the seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from msgspec.structs import replace

from cramlite.model import Pose, Rollout, Value, World, thing_of
from cramlite.plugin import UserError, nearest

from ..model.compile import Compiled, compile_world
from .both_hands import from_above, waiting
from .hanging import hang_onto_hanger
from .person import Person
from .sight_of_person import Scene, half_extents, see_hanging, see_standing
from .taking_off import PALM, take_off_hanger
from .variety import fetch, hang, not_in_container, not_on_peg, recorded

#: The palm's edge stays above what an object stands on: half its 56 mm (hand.py), and 7 mm for tilt and drift [m].
FLOOR = 0.035


def demonstrate(world: World, *, seed: int, script: str = "take_off_hanger", rate: float = 50.0) -> Rollout:
    """Record a person who performs a script in a world.

    Args:
        world: with the things that the script needs; robots are left out.
        seed: of everything that varies between two demonstrations.
        script: one of ``SCRIPTS``.
        rate: samples a second.

    Returns:
        The recording, whatever came of it; its outcome is "failed", with the reason, where the script knows what it is for and
        that did not come about. Nobody makes another one: a person's failures are data, too.

    Raises:
        UserError: there is no such script, or the world lacks what it needs.
    """
    if script not in SCRIPTS:
        raise UserError(f"there is no script '{script}' for a demonstration; {nearest(script, SCRIPTS)}")
    chosen = SCRIPTS[script]
    scene = chosen.see(world)
    rng = np.random.default_rng(seed)
    person = perform(scene, chosen.act, rng, rate, both=chosen.both_hands)
    rollout = chosen.after(person.rollout(), scene, rng) if chosen.after else person.rollout()
    wrong = chosen.missed(person, scene) if chosen.missed else ""
    return replace(rollout, outcome="failed", reason=wrong) if wrong else rollout


def perform(scene: Scene, act: Act, rng: np.random.Generator, rate: float, *, both: bool = False) -> Person:
    """Simulate one performance of a script; return the person with its recording.

    Args:
        both: they have two hands.
    """
    grasp = _grasp(scene, rng)
    hands = [grasp, *([from_above(scene.product.pose, scene.product)] if both else [])]
    rests = tuple(Pose((0, 0, 0), h.quaternion) for h in hands)
    compiled = compile_world(replace(scene.world, robots=()), {}, hand=rests)
    person = _beginning(compiled, scene, grasp, rng, rate)
    act(person, scene, grasp)
    return person


def _grasp(scene: Scene, rng: np.random.Generator) -> Pose:
    """Where the hand will close, in the product's frame at the start, given in the world: from the front, across the
    product's width, turned and tilted as it happens, low enough for palm and wrist to pass under the peg."""
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


def _beginning(compiled: Compiled, scene: Scene, grasp: Pose, rng: np.random.Generator, rate: float) -> Person:
    """A person whose hands touch nothing yet.

    Raises:
        UserError: there is no room for the hand in front of the object.
    """
    for _ in range(50):
        starts = [_start(scene, grasp, rng), *([waiting(scene, rng)] if compiled.other_hand else [])]
        person = Person(compiled, rng, starts, rate)
        if not any(thing_of(name) == "effector" for pair in compiled.collisions(person.data) for name in pair):
            return person
    raise UserError(f"there is no room for a hand in front of '{scene.product.name}'; move what stands there")


def _start(scene: Scene, grasp: Pose, rng: np.random.Generator) -> Pose:
    """Somewhere in front of the shelf, at ease, turned a little."""
    side = np.cross(scene.facing, (0, 0, 1))
    place = np.array(grasp.position) + scene.facing * rng.uniform(0.22, 0.35)
    sideways, up = rng.uniform(-0.2, 0.2), rng.uniform(-0.12, 0.08)
    place += side * sideways + np.array([0, 0, abs(up) if scene.stands else up])
    return Pose(tuple(place), (grasp * Pose.from_rotvec((0, 0, 0), rng.normal(0, 0.2, 3).tolist())).quaternion)


Act = Callable[[Person, Scene, Pose], None]


class Script(Value):
    """A demonstration script.

    Args:
        see: what the person makes out in the world.
        act: how they move, given where the hand will close.
        missed: what did not come about that it is for; "" where all did.
        after: what the recorder makes of it.
        both_hands: the person has two.
    """

    see: Callable[[World], Scene]
    act: Act
    missed: Callable[[Person, Scene], str] | None = None
    after: Callable[[Rollout, Scene, np.random.Generator], Rollout] | None = None
    both_hands: bool = False


#: Scripts by name.
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
