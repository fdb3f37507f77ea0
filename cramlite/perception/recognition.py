"""Beliefs from recognised objects: things, pose estimates and relations."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable

import numpy as np
from msgspec.structs import replace

from ..model.belief import Estimate, Relation
from ..model.geometry import Pose, vector3
from ..model.world.thing import Thing
from ..model.world.world import World
from ..plugin.expert import UNKNOWN
from .result import Perceived, Percept

SIGMA = 0.002
"""Standard deviation of a perceived position [m]: twice the median error of confident poses at 0.6 m
(docs/figures/perception_pose.yaml), which leaves room for the tail."""
ASKEW = 0.035
"""Tilt of a fixed thing that is an error of its pose [rad]: of 52 that were seen and stood level 95 % tilted by at most 0.6 degrees, one by
1.94."""
SAME = 0.10
"""Largest distance between the centres of a recognised and a believed thing that count as the same thing [m]. The least distance of
neighbouring products is 70 mm along a peg, 160 mm across."""


def least_pose_confidence(perceived: Perceived) -> float:
    """Return the confidence of the least certain pose of a perception result.

    0 where something that could be an answer has none, 1 where nothing is seen.
    """
    conditions = perceived.query.conditions
    open_ = (p for p in perceived.dropped if any(c.output in p.missing for c in conditions))
    things = [p for p in (*perceived.answers, *open_) if p.value("type") != UNKNOWN and not p.value("fixture")]
    return min((p.values["pose"].judged.confidence if "pose" in p.values else 0.0 for p in things), default=1.0)


def thing_from_percept(percept: Percept, models: Iterable[Thing]) -> Thing | None:
    """Return a recognised object as a thing, its joints where they were seen; None if it has no model or no pose. What is fixed stands
    level."""
    model = next((t for t in models if t.name == percept.value("model")), None)
    pose, name = percept.value("pose"), percept.value("instance")
    if model is None or pose is None:
        return None
    joints = {joint: value for joint, value, _ in percept.value("joints", ())}
    return replace(model.at_joints(joints), name=name or model.name, pose=levelled(pose) if model.furniture else pose)


def levelled(pose: Pose) -> Pose:
    """Return a pose with that axis vertical which is so but for the errors of poses; the same pose if none is."""
    axes = pose.rotation
    nearest = int(np.abs(axes[2]).argmax())
    up = axes[:, nearest] * np.sign(axes[2, nearest])
    angle = float(np.arccos(min(1.0, float(up[2]))))
    if not 0.0 < angle < ASKEW:
        return pose
    axis = np.cross(up, (0.0, 0.0, 1.0))
    back = Pose.from_rotvec((0.0, 0.0, 0.0), vector3(axis / np.linalg.norm(axis) * angle))
    return Pose.at(pose.position, back * Pose.at((0.0, 0.0, 0.0), pose))


def estimates_of(percept: Percept, things: Iterable[Thing]) -> dict[str, Estimate]:
    """Return the pose estimates of the things that a percept was taken for; their standard deviation [m] grows as the confidence
    falls."""
    said = percept.values["pose"]
    sure = said.judged.confidence
    source = f"camera: {percept.value('model')} by expert {said.expert}, confidence {sure:.2f}"
    return {t.name: Estimate(t.pose, SIGMA / max(sure, 0.1), source) for t in things}


def unlocated(scenes: Iterable[Perceived], located: Container[str]) -> dict[str, str]:
    """Return the fixtures that perception looked for in pictures and located in none of them, each with the reason.

    Args:
        scenes: result of perception for each picture.
        located: names of the things that were located.
    """
    said = (scene.scene["refined"].value for scene in scenes if "refined" in scene.scene)
    return {name: judged.reason for fixtures in said for name, judged in fixtures.items() if name not in located}


def facts(name: str, percept: Percept, fixtures: tuple[Thing, ...]) -> tuple[Relation, ...]:
    """Return the relations of a percept to fixtures, as facts of the belief."""
    known = {t.name for t in fixtures}
    said = percept.value("relations", ())
    hanging = {n for p, n, _ in said if p == "hangs_on"}
    return tuple((p, name, n) for p, n, _ in said if n in known and not (p == "on" and n in hanging))


def renamed(real: World, belief: World) -> World:
    """Return the real world with the names of the believed one, for validators; a believed thing is matched
    with the nearest real one.

    Nobody who decides sees this: physics and controllers do not know names.
    """
    mine = {t.name: t for t in belief.things if not t.furniture}
    theirs = {t.name: t for t in real.things if not t.furniture}
    pairs = sorted(
        (math.dist(a.pose.position, b.pose.position), a.name, b.name) for a in mine.values() for b in theirs.values()
    )
    names: dict[str, str] = {}
    for gap, own, other in pairs:
        if gap <= SAME and own not in names.values() and other not in names:
            names[other] = own
    taken = {t.name for t in belief.things}
    for other in theirs:
        names.setdefault(other, other if other not in taken else f"unseen_{other}")
    return replace(real, things=tuple(replace(t, name=names.get(t.name, t.name)) for t in real.things))
