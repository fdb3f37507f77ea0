"""Demonstrations by the scripts of ``taking_off.py`` and ``hanging.py`` with a person's habits added, such as
pauses."""

from __future__ import annotations

import numpy as np

from cramlite.model import Pose, Rollout
from cramlite.plugin import Performer

from .both_hands import be_busy, from_above, hand_over
from .habits import (
    GLITCH,
    Habits,
    be_interrupted,
    detour,
    draw_pace_and_tremor,
    go_wrong,
    habits,
    look_twice,
    pause,
    put_down_and_take,
    take_again,
    with_tracking_loss,
)
from .hand_moves import close, extent, reach
from .hanging import face, leave, lift, thread
from .sight_of_person import Scene, half_extents
from .taking_off import carry, let_go, pull_off

#: The hole is this near to the peg's axis when it hangs on it [m].
THREADED = 0.008


def fetch(person: Performer, scene: Scene, grasp: Pose, *, distracted: bool = False) -> None:
    """Take the object off the peg and put it into the container."""
    own = habits(person.rng, distracted=distracted)
    _come(person, scene, grasp, own)
    pull_off(person, scene)
    if own.interrupted:
        be_interrupted(person)
    if own.put_down:
        put_down_and_take(person, scene, grasp)
    if own.other_hand == "hand_over":
        step_back(person, scene)
        hand_over(person, scene, grasp, from_above(scene.product.pose, scene.product))
    if person.rng.random() < own.pause:
        detour(person)
    carry(person, scene)
    let_go(person, scene)


def hang(person: Performer, scene: Scene, grasp: Pose, *, distracted: bool = False) -> None:
    """Take the object from where it stands and thread it onto the peg."""
    own = habits(person.rng, distracted=distracted)
    if own.other_hand == "hand_over":
        above = from_above(scene.product.pose, scene.product)
        person.change_hands()
        _come(person, scene, above, own)
        lift(person)
        hand_over(person, scene, above, grasp)
    else:
        _come(person, scene, grasp, own)
        lift(person)
    if own.interrupted:
        be_interrupted(person)
    if own.put_down:
        put_down_and_take(person, scene, grasp)
    if person.rng.random() < own.pause:
        detour(person)
    pause(person, own)
    face(person, scene)
    thread(person, scene)
    leave(person, scene, grasp)


def step_back(person: Performer, scene: Scene) -> None:
    """Move the object away from the wall, to where the other hand has room."""
    back = np.add(person.aim.position, scene.along * person.between(0.08, 0.12))
    person.move([Pose(tuple(back), person.aim.quaternion)], person.between(0.15, 0.3))


def _come(person: Performer, scene: Scene, grasp: Pose, own: Habits) -> None:
    """Perform the acts until the hand holds the object, with the drawn habits: reach, close, pause."""
    draw_pace_and_tremor(person)
    if own.other_hand == "busy":
        be_busy(person, scene)
    if own.wrong_way:
        go_wrong(person, scene, grasp)
    if own.second_look:
        look_twice(person, grasp)
    reach(person, scene, grasp)
    close(person, extent(scene, grasp))
    if own.regrasp:
        take_again(person, scene, grasp)
    pause(person, own)


def not_in_container(person: Performer, scene: Scene) -> str:
    """Return an objection if the object does not lie in the container, else ""."""
    opening = scene.container.pose * scene.cavity.pose
    x, y, z = opening.inverse().apply(person.pose(scene.product.name).position)
    width, depth = (scene.cavity.size[k] for k in ("width", "depth"))
    inside = abs(x) < width / 2 and abs(y) < depth / 2 and z < half_extents(scene.product)[2]
    return "" if inside else f"'{scene.product.name}' is not in '{scene.container.name}' at the end"


def not_on_peg(person: Performer, scene: Scene) -> str:
    """Return an objection if the object does not hang on the peg, else ""."""
    hole = (person.pose(scene.product.name) * scene.hole.pose).position
    x, y, depth = (scene.hanger.pose * scene.peg.pose).inverse().apply(hole)
    threaded = np.hypot(x, y) < THREADED and 0 <= depth <= scene.peg.size["length"]
    return "" if threaded else f"'{scene.product.name}' does not hang on '{scene.hanger.name}' at the end"


def recorded(rollout: Rollout, scene: Scene, rng: np.random.Generator) -> Rollout:
    """Return the rollout as a tracker would have recorded it: by chance, the tracker loses the product in the hand for a while."""
    return with_tracking_loss(rollout, scene.product.name, rng) if rng.random() < GLITCH else rollout
