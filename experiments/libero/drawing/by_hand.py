"""Goals made true without the arm: whether the benchmark accepts a goal at all, once bodies and joints have been
set to it and released.

The arm takes no part: it neither moves nor collides. Nor do things that the goal does not name; they are out of the scene. It runs in the
benchmark's environment.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import mujoco
import numpy as np
from drawn_goals import PLACES, Literal, in_order
from world import World, joint_value

ROUNDS = 3
"""Number of search rounds: the first begins at the target's middle, the others try poses in random order."""
POSES, FREE = 900, 8
"""Largest number of poses tried for a thing in a round, and of collision-free ones among them that are simulated."""
SETTLE, END = 0.4, 1.5
"""Time for which the physics runs after a thing is placed, and after all things are placed [s]."""
DEEP = 0.0005
"""Depth of contact up to which a pose counts as free of contact [m]."""
HEIGHTS = (0.002, 0.006, 0.01, 0.015, 0.02, 0.03, 0.05, 0.1)
"""Heights above the target, or its floor, at which things are let go of, from low to high [m]."""
FAR = 20.0
"""Coordinate at which things are parked that take no part in the goal [m]."""


class Hand:
    """Stand-in for the robot's hand in the benchmark's simulator: sets poses of bodies and values of joints.

    Args:
        world: at the start of an episode; left as it was.
        owner: region -> thing that it belongs to, where that can be carried.
    """

    def __init__(self, world: World, owner: dict[str, str]) -> None:
        self.world, self.owner = world, owner
        self.kept = world.state()
        self.still: dict[int, float] = {}
        model = world.model
        self.parked: list[str] = []
        self.robot = [b for b in range(model.nbody) if model.body(b).name.startswith(("robot0", "gripper0", "mount0"))]
        self.arm = [j for j in range(model.njnt) if int(model.jnt_bodyid[j]) in self.robot]

    def can(self, goal: Sequence[Literal]) -> bool:
        """Return whether the benchmark accepts a goal that was made true without the arm."""
        model, geoms = self.world.model, self._robot_geoms()
        kept = model.geom_contype[geoms].copy(), model.geom_conaffinity[geoms].copy()
        model.geom_contype[geoms] = model.geom_conaffinity[geoms] = 0
        try:
            return any(self._round(goal, k) for k in range(ROUNDS))
        finally:
            model.geom_contype[geoms], model.geom_conaffinity[geoms] = kept
            self._restore()

    def _round(self, goal: Sequence[Literal], number: int) -> bool:
        self._restore()
        self._park(goal)
        self.still = {j: v for p in goal if p[0] not in PLACES for j, v in self._values(p)}
        self.still |= self._opened(goal) if number else {}
        self._holding()
        self._hold()
        mujoco.mj_forward(self.world.model, self.world.data)
        rng = np.random.default_rng(number)
        for literal in in_order(goal, self.owner):
            if not self._put(literal, rng if number else None):
                return False
        self.still = {}
        self._holding()
        self._settle(END)
        return all(self.world.holds(p) for p in goal)

    def _values(self, literal: Literal) -> list[tuple[int, float]]:
        return [(j, joint_value(self.world, literal)) for j in self.world.joints(literal[1])]

    def _opened(self, goal: Sequence[Literal]) -> dict[int, float]:
        """Return a dictionary from joint to open value, for the drawers that the goal puts things in and does not close."""
        targets = [p[2] for p in goal if p[0] == "in" and p[2] in self.world.env.env.object_sites_dict and self.world.joints(p[2])]
        return {j: v for t in targets for j, v in self._values(("open", t)) if j not in self.still}

    def _park(self, goal: Sequence[Literal]) -> None:
        named = {n for p in goal for n in p[1:]}
        named |= {self.owner[n] for n in named if n in self.owner}
        self.parked = [t for t in self.world.things if t not in named]

    def _put(self, literal: Literal, rng: Any) -> bool:
        """Find a pose of a thing in which the benchmark says that a literal holds after the thing has settled."""
        asked, start = 0, self.world.state()
        for position, turn in self._poses(literal, rng):
            self._place(literal[1], position, turn)
            if not self._free(literal[1]):
                continue
            self._settle(SETTLE)
            if self.world.holds(literal):
                return True
            self._back(start)
            if (asked := asked + 1) == FREE:
                break
        return False

    def _poses(self, literal: Literal, rng: Any) -> Iterator[tuple[Any, Any]]:
        """Poses to try for a thing at its target: upright and lying, at several yaw angles, positions and
        heights; in random order with rng, else the target's middle first."""
        low, high = self._box(literal)
        turns = [_product(_about(2, yaw), face) for face in self._faces(literal[1]) for yaw in (0, np.pi / 2, np.pi / 4, -np.pi / 4)]
        steps = sorted(product((-0.8, -0.4, 0.0, 0.4, 0.8), repeat=2), key=lambda s: s[0] ** 2 + s[1] ** 2)
        found = list(product(turns, steps, HEIGHTS))
        order = range(len(found)) if rng is None else rng.permutation(len(found))
        middle, half = (low + high) / 2, (high - low) / 2
        for k in list(order)[:POSES]:
            turn, (x, y), up = found[k]
            z = low[2] + self._below(literal[1], turn) + up
            yield np.array([middle[0] + x * half[0], middle[1] + y * half[1], z]), turn

    def _box(self, literal: Literal) -> tuple[Any, Any]:
        """Lowest and highest position of a thing's origin that a literal allows: in a region ("in"), on
        top of it ("on"), or on top of another thing's middle."""
        world, name = self.world, literal[2]
        if name not in world.env.env.object_sites_dict:
            middle, top = world.data.body(world.root(name)).xpos.copy(), world.corners(name)[:, 2].max()
            return np.array([*(middle[:2] - 0.025), top]), np.array([*(middle[:2] + 0.025), top])
        site = world.data.site(name)
        half = np.abs(site.xmat.reshape(3, 3) @ world.model.site(name).size)
        low, high = site.xpos - half, site.xpos + half
        return (low, high) if literal[0] == "in" else (np.array([*low[:2], high[2]]), high)

    def _faces(self, thing: str) -> list[Any]:
        """Attitudes of a thing (quaternions): the present one, and those on its five other sides."""
        now = self.world.data.body(self.world.root(thing)).xquat.copy()
        turns = [_about(0, 0.0), _about(0, np.pi / 2), _about(0, -np.pi / 2), _about(1, np.pi / 2), _about(1, -np.pi / 2), _about(0, np.pi)]
        return [_product(turn, now) for turn in turns]

    def _below(self, thing: str, turn: Any) -> float:
        """How far a thing reaches below its origin in an attitude [m]."""
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, turn)
        return float(-(self.world.own_corners(thing) @ matrix.reshape(3, 3).T)[:, 2].min())

    def _place(self, thing: str, position: Any, turn: Any) -> None:
        world = self.world
        at = int(self._free_joint(thing).qposadr[0])
        world.data.qpos[at : at + 7] = [*position, *turn]
        world.data.qvel[:] = 0.0
        self._hold()
        for step in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_collision):
            step(world.model, world.data)

    def _free(self, thing: str) -> bool:
        geoms, data = set(self.world.geoms(thing)), self.world.data
        contacts = (data.contact[k] for k in range(data.ncon))
        return not any(c.dist < -DEEP for c in contacts if c.geom1 in geoms or c.geom2 in geoms)

    def _settle(self, seconds: float) -> None:
        world = self.world
        for _ in range(round(seconds / world.model.opt.timestep)):
            self._hold()
            mujoco.mj_step(world.model, world.data)
        mujoco.mj_forward(world.model, world.data)

    def _hold(self) -> None:
        """Reset the arm, the things that the goal does not name, and the goal's joints to the positions at
        which they are held while other bodies settle."""
        data = self.world.data
        data.qpos[self.held], data.qvel[self.braked] = self.at, 0.0

    def _holding(self) -> None:
        """Note the positions that do not change while bodies settle: of the arm, of things that the goal
        does not name, and of the goal's joints."""
        model = self.world.model
        places = {int(model.jnt_qposadr[j]): float(self.kept[1 + model.jnt_qposadr[j]]) for j in self.arm}
        brakes = [int(model.jnt_dofadr[j]) for j in (*self.arm, *self.still)]
        places |= {int(model.jnt_qposadr[j]): v for j, v in self.still.items()}
        for k, joint in enumerate(map(self._free_joint, self.parked)):
            places |= dict(zip(range(int(joint.qposadr[0]), int(joint.qposadr[0]) + 3), (FAR, float(k), FAR), strict=True))
            brakes += range(int(joint.dofadr[0]), int(joint.dofadr[0]) + 6)
        self.held, self.braked, self.at = list(places), brakes, list(places.values())

    def _free_joint(self, thing: str) -> Any:
        return self.world.model.joint(self.world.env.env.get_object(thing).joints[-1])

    def _robot_geoms(self) -> list[int]:
        model = self.world.model
        return [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in self.robot]

    def _restore(self) -> None:
        self.still, self.parked = {}, []
        self._back(self.kept)

    def _back(self, state: Any) -> None:
        self.world.env.sim.set_state_from_flattened(state)
        mujoco.mj_forward(self.world.model, self.world.data)


def _about(axis: int, angle: float) -> Any:
    """Quaternion (w, x, y, z) of a turn about an axis of the world."""
    found = np.zeros(4)
    found[0], found[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return found


def _product(first: Any, second: Any) -> Any:
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, first, second)
    return found
