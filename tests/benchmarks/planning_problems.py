"""Pick and place problems in a cluttered shelf, and each as MJCF for planners that know nothing of cramlite."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

import numpy as np

sys.path.insert(0, str(File(__file__).parents[1]))

from helpers.scenes import TABLE, box, make

from cramlite.model import Pose, Thing
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.robots.ur5e import UR5E

Joints = tuple[float, ...]
HELD = Pose((0.0, 0.0, 0.02))  # of a carried box in the tcp frame
SHAPES = {2: "sphere", 5: "cylinder", 6: "box"}  # mjtGeom


@dataclass(frozen=True)
class Problem:
    """Problem: a start position of the joints, and a goal pose of the tool; every second one carries a box. ``known`` is a free goal."""

    scene: PlanningScene
    start: Joints
    goal: Pose
    known: Joints


def problem(number: int, seed: int) -> Problem:
    """One problem; its start and its goal have a free inverse solution by construction."""
    rng = np.random.default_rng((seed, number))
    things = shelf(rng)
    carried = box("carried", (0.02, 0.02, 0.03), (0.4, -0.4, 0.02), 0.2)
    scene = make(*things, carried, held={"carried": HELD}, opening=0.042) if number % 2 else make(*things)
    (_, start), (goal, known) = stand(scene, rng), stand(scene, rng)
    return Problem(scene, start, goal, known)


def shelf(rng: np.random.Generator) -> tuple[Thing, ...]:
    """Two boards, two sides, a back and a post, and six boxes standing on table and board."""
    walls = (
        TABLE,
        box("back", (0.4, 0.01, 0.35), (0.45, 0.72, 0.34)),
        box("board", (0.4, 0.14, 0.01), (0.45, 0.57, 0.34)),
        box("top", (0.4, 0.14, 0.01), (0.45, 0.57, 0.69)),
        box("left", (0.01, 0.14, 0.35), (0.05, 0.57, 0.34)),
        box("right", (0.01, 0.14, 0.35), (0.85, 0.57, 0.34)),
        box("post", (0.01, 0.14, 0.16), (0.45, 0.57, 0.17)),
    )
    clutter = []
    for k in range(6):
        half = rng.uniform((0.02, 0.02, 0.03), (0.04, 0.04, 0.07))
        floor = -0.01 if k % 2 else 0.35
        place = (float(rng.uniform(0.1, 0.8)), float(rng.uniform(0.5, 0.68)), floor + float(half[2]) + 0.001)
        clutter.append(box(f"box{k}", (float(half[0]), float(half[1]), float(half[2])), place, 0.2))
    return (*walls, *clutter)


def stand(scene: PlanningScene, rng: np.random.Generator) -> tuple[Pose, Joints]:
    """A tool pose in the shelf or before it that has a free inverse solution, and that solution."""
    while True:
        inside = rng.random() < 0.75
        low, high = ((0.12, 0.42, 0.06), (0.78, 0.56, 0.6)) if inside else ((0.2, 0.1, 0.1), (0.6, 0.3, 0.5))
        position = rng.uniform(low, high)
        axis = np.array((0.0, 1.0, 0.0)) + rng.normal(0, 0.15, 3) if inside else np.array((0.1, 0.2, -1.0))
        pose = Pose.from_axes(position.tolist(), axis, rng.normal(0, 1, 3))
        free = [q for q in inverse(UR5E, pose)[:24] if scene.free(q)]
        if free:
            return pose, free[0]


def mjcf(scene: PlanningScene) -> str:
    """The planning model with the arm's joints only, ``joint0`` to ``jointN``, and the site ``tcp``."""
    model, data = scene.compiled.model, scene.data
    scene.tip([0.0] * len(scene.robot.joints))
    arm = {int(model.jnt_bodyid[scene.chains.first + i]): i for i in range(len(scene.robot.joints))}

    def body(b: int) -> str:
        parent, joint = int(model.body_parentid[b]), ""
        here = _pose(data.xpos[parent], data.xquat[parent]).inverse() * _pose(data.xpos[b], data.xquat[b])
        if b in arm:
            here, j = _pose(model.body_pos[b], model.body_quat[b]), scene.chains.first + arm[b]
            low, high = scene.limits[arm[b]]
            joint = (
                f'<joint name="joint{arm[b]}" axis="{_text(model.jnt_axis[j])}" pos="{_text(model.jnt_pos[j])}" '
                f'range="{low} {high}"/><inertial pos="0 0 0" mass="1" diaginertia=".1 .1 .1"/>'
            )
        return f'<body name="b{b}" {_place(here.position, here.quaternion)}>{joint}{inside(b)}</body>'

    def inside(b: int) -> str:
        geoms = [_geom(model, g) for g in range(model.ngeom) if int(model.geom_bodyid[g]) == b]
        tcp = scene.index.tcp
        if int(model.site_bodyid[tcp]) == b:
            geoms.append(f'<site name="tcp" {_place(model.site_pos[tcp], model.site_quat[tcp])}/>')
        return "".join(geoms) + "".join(body(c) for c in range(1, model.nbody) if int(model.body_parentid[c]) == b)

    excluded = [(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature]
    pairs = "".join(f'<exclude body1="b{a}" body2="b{b}"/>' for a, b in excluded)
    angles = '<compiler angle="radian" autolimits="true"/>'
    return f"<mujoco>{angles}<worldbody>{inside(0)}</worldbody><contact>{pairs}</contact></mujoco>"


def _geom(model: Any, g: int) -> str:
    masks = f'contype="{model.geom_contype[g]}" conaffinity="{model.geom_conaffinity[g]}"'
    shape = f'type="{SHAPES[int(model.geom_type[g])]}" size="{_text(model.geom_size[g])}"'
    return f"<geom {shape} {_place(model.geom_pos[g], model.geom_quat[g])} {masks}/>"


def _pose(position: Any, quaternion: Any) -> Pose:
    return Pose(tuple(position), tuple(quaternion))


def _place(position: Any, quaternion: Any) -> str:
    return f'pos="{_text(position)}" quat="{_text(quaternion)}"'


def _text(values: Any) -> str:
    return " ".join(repr(float(v)) for v in values)
