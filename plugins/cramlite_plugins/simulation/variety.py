"""Demonstrations as people really give them: the scripts of ``demonstration.py`` and ``hanging.py``, with habits."""

from __future__ import annotations

import numpy as np

from cramlite.geometry import Pose
from cramlite.rollout import Rollout

from .demonstration import Scene, carry, close, extent, half_extents, let_go, pull_off, reach
from .habits import (
    GLITCH,
    Habits,
    be_interrupted,
    detour,
    glitched,
    go_wrong,
    habits,
    look_twice,
    pause,
    put_down_and_take,
    take_again,
    temper,
)
from .hanging import face, leave, lift, thread
from .person import Person

#: The hole is this near to the peg's axis when it hangs on it [m].
THREADED = 0.008


def fetch(person: Person, scene: Scene, grasp: Pose, *, distracted: bool = False) -> None:
    """Take the object off the peg and put it into the container."""
    own = _come(person, scene, grasp, distracted)
    pull_off(person, scene)
    if own.interrupted:
        be_interrupted(person)
    if own.put_down:
        put_down_and_take(person, scene, grasp)
    if person.rng.random() < own.pause:
        detour(person)
    carry(person, scene)
    let_go(person, scene)


def hang(person: Person, scene: Scene, grasp: Pose, *, distracted: bool = False) -> None:
    """Take the object from where it stands and thread it onto the peg."""
    own = _come(person, scene, grasp, distracted)
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


def _come(person: Person, scene: Scene, grasp: Pose, distracted: bool) -> Habits:
    """Until the hand holds the object."""
    own = habits(person.rng, distracted=distracted)
    temper(person)
    if own.wrong_way:
        go_wrong(person, scene, grasp)
    if own.second_look:
        look_twice(person, grasp)
    reach(person, scene, grasp)
    close(person, extent(scene, grasp))
    if own.regrasp:
        take_again(person, scene, grasp)
    pause(person, own)
    return own


def in_container(person: Person, scene: Scene) -> bool:
    """Whether the object lies in the container."""
    opening = scene.container.pose * scene.cavity.pose
    x, y, z = opening.inverse().apply(person.pose(scene.product.name).position)
    width, depth = (scene.cavity.size[k] for k in ("width", "depth"))
    return bool(abs(x) < width / 2 and abs(y) < depth / 2 and z < half_extents(scene.product)[2])


def on_peg(person: Person, scene: Scene) -> bool:
    """Whether the object hangs on the peg."""
    hole = (person.pose(scene.product.name) * scene.hole.pose).position
    x, y, depth = (scene.hanger.pose * scene.peg.pose).inverse().apply(hole)
    return bool(np.hypot(x, y) < THREADED and 0 <= depth <= scene.peg.size["length"])


def recorded(rollout: Rollout, scene: Scene, rng: np.random.Generator) -> Rollout:
    """With what the tracker missed."""
    return glitched(rollout, scene.product.name, rng) if rng.random() < GLITCH else rollout
