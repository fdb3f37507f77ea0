"""Motion planning of a mobile base: the whole robot among things, its arm held still, and paths on the floor.

Every shape of the robot is grown by the clearance (the platform's only sideways: it stands on the floor), in
a copy of the planning model in which only robot and things collide; one collision check then answers for a
place. A leg is looked at every ``STEP``: no point of the robot moves further between two looks than the
clearance.

A way is one leg, or a turn and a leg, or is found by A* (Hart, Nilsson and Raphael 1968) on a lattice around
one end, and then shortened. Two such searches, one from each end, take turns: an end that is shut in is soon
known. Nothing is drawn at random.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Pose, Robot, Value, Vector3, World

from ..simulation.model.build import Carried
from ..simulation.model.compile import Compiled, compile_world
from ..simulation.model.index import PlatformIndex, flat
from .inflated import CORNER, GROWS

CLEARANCES = (0.05, 0.02)  # [m]; the smaller one where the robot itself stands nearer to something already
STEP = 0.02, math.radians(2.0)  # [m, rad]: with 0.6 m from the middle to a corner at most 41 mm
CELL, HEADINGS = 0.10, 8  # of the lattice [m], and in a full turn
AROUND = 2.5  # how far the lattice reaches beyond start and goal [m]
LOOKS = 8000  # cells that one search may look at
TURNING = 0.4  # length of a turn of one radian [m]: about equal in time at the usual speeds
HALF = 3.0  # legs that turn by more are halved [rad]
ROBOT, THING = 1, 2


class Ground(Value):
    """Planning scene of a mobile robot on the floor; make one with ``ground``.

    Args:
        compiled: the planning model with a grown robot.
        data: scratch state, with the arm's joints and the things where they are.
        index: of the platform.
        start: where the platform stands when its joints are at zero, in the world.
        clearance: [m].
        checks: counts places looked at; a list of one.
    """

    compiled: Compiled
    data: Any
    index: PlatformIndex
    start: Pose
    clearance: float
    checks: list[int]

    def hit(self, place: Vector3) -> str:
        """Return the obstacle nearer than the clearance with the platform at (x, y, yaw) in the world [m,
        rad]; "" for none."""
        self.index.put(self.data, self.start, level(place))
        mujoco.mj_kinematics(self.compiled.model, self.data)
        mujoco.mj_collision(self.compiled.model, self.data)
        self.checks[0] += 1
        if not self.data.ncon:
            return ""
        a, b = min(self.compiled.collisions(self.data))
        return f"'{a}' is less than {1000 * self.clearance:.0f} mm from '{b}'"

    def leg(self, a: Vector3, b: Vector3) -> str:
        """Return the obstacle too near to a straight leg between two places (x, y, yaw); "" for none.

        The end of the leg is checked first.
        """
        way = np.subtract(b, a)
        count = max(1, math.ceil(max(math.hypot(way[0], way[1]) / STEP[0], abs(way[2]) / STEP[1])))
        shares = [1.0, *(k / count for k in range(1, count))]
        return next((h for s in shares if (h := self.hit(_between(a, way, s)))), "")


def ground(
    world: World,
    robots: Mapping[str, Robot],
    mount: str,
    joints: tuple[float, ...],
    *,
    poses: Mapping[str, Pose],
    held: Mapping[str, Pose] = MappingProxyType({}),
    opening: float,
    clearance: float = CLEARANCES[0],
) -> Ground:
    """Build the planning scene of a mobile robot with its arm at a joint position [rad].

    ``poses``, ``held`` and ``opening`` are as for ``scene_of_world.scene``.

    Raises:
        ValueError: the robot has no platform.
    """
    carried = {name: Carried(mount, pose) for name, pose in held.items()}
    compiled = compile_world(world.moved(dict(poses)), robots, planning=True, carried=carried)
    index, data = compiled.robots[mount], compiled.data()
    if index.platform is None:
        raise ValueError(f"'{mount}' has no platform")
    index.set_opening(data, opening)
    data.qpos[list(index.joints)] = joints
    _grow(compiled.model, index.platform.body, clearance)
    start = next(m.base for m in world.robots if m.name == mount)
    return Ground(compiled, data, index.platform, start, clearance, [0])


def _grow(model: Any, platform: int, by: float) -> None:
    """Grow all shapes of the robot by a distance [m] for collision checks, its platform horizontally only.

    From then on the robot collides with things only, and things do not collide with one another.
    """
    for g in range(model.ngeom):
        robot = int(model.body_rootid[model.geom_bodyid[g]]) == int(model.body_rootid[platform])
        model.geom_contype[g], model.geom_conaffinity[g] = (ROBOT, THING) if robot else (THING, ROBOT)
        if robot:
            grows = GROWS[model.geom_type[g]].copy()
            if model.geom_bodyid[g] == platform:
                grows[2] = 0.0
            model.geom_size[g] += by * grows
            model.geom_rbound[g] += by * CORNER
            model.geom_aabb[g, 3:] += by
    model.opt.disableflags |= int(
        mujoco.mjtDisableBit.mjDSBL_MIDPHASE
    )  # its boxes are those of the model as it was


def level(place: Vector3) -> Pose:
    """Return the pose of a place (x, y, yaw) [m, rad] on the floor."""
    x, y, turn = place
    return Pose((x, y, 0.0), (math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)))


def unwound(place: Vector3, near: Vector3) -> Vector3:
    """Add whole turns to the yaw of a place (x, y, yaw), so that it is nearest to the yaw of another
    place."""
    turns = round((near[2] - place[2]) / math.tau)
    return place[0], place[1], place[2] + turns * math.tau


def plan_base_path(floor: Ground, start: Vector3, goal: Vector3) -> list[Vector3] | NoBasePath:
    """Plan a path of straight legs from a free start to a goal, places (x, y, yaw) in the world [m, rad].

    Returns:
        The ends of the legs, the goal last; or why there is no path.
    """
    goal = unwound(goal, start)
    if blocked := floor.hit(goal):
        return NoBasePath(f"at the goal {blocked}")
    for corners in ([], [(*start[:2], goal[2])], [(*goal[:2], start[2])]):
        places = [start, *corners, goal]
        if not any(floor.leg(a, b) for a, b in itertools.pairwise(places)):
            return _halved(places)
    found = _both_ends(floor, start, goal)
    return found if isinstance(found, NoBasePath) else _halved(_shortened(floor, found))


class NoBasePath(Value):
    """Refusal of a base path; ``shut_in`` if the free cells around the start are enclosed, so that the
    platform gets nowhere, whatever the goal."""

    reason: str
    shut_in: bool = False


def _both_ends(floor: Ground, start: Vector3, goal: Vector3) -> list[Vector3] | NoBasePath:
    """Path of a platform that is found first by two searches in turn, one from the start and one from the
    goal, both ends included; or why there is none."""
    searches = {"start": _Search(floor, start, goal), "goal": _Search(floor, goal, start)}
    while True:
        for end, search in searches.items():
            if search.found:
                return _rewound(search.found if end == "start" else search.found[::-1], start)
            if not search.step():
                return NoBasePath(f"from the {end}, {search.why()}", end == "start" and not search.cut)


Cell = tuple[int, int, int]


class _Search:
    """A* search for a base path on the lattice around the start, up to a place from which a straight leg
    leads to the goal.

    Args:
        floor: what is asked whether places and legs are free.
    """

    def __init__(self, floor: Ground, start: Vector3, goal: Vector3) -> None:
        self.floor, self.start, self.goal = floor, start, goal
        origin = (0, 0, 0)
        self.best, self.came, self.spots = {origin: 0.0}, {origin: origin}, {origin: ""}
        self.queue, self.closed = [(self._ahead(origin), origin)], set[Cell]()
        self.last, self.nearest, self.cut = "", math.inf, False
        self.found: list[Vector3] = []

    def step(self) -> bool:
        """Advance an A* search by its most promising cell; return False if there is no cell left, or too
        many places were looked at."""
        while self.queue and self.queue[0][1] in self.closed:
            heapq.heappop(self.queue)
        if not self.queue or len(self.spots) >= LOOKS:
            self.cut = self.cut or bool(self.queue)
            return False
        _, cell = heapq.heappop(self.queue)
        self.closed.add(cell)
        here = unwound(self._place(cell), self.goal)
        gap = math.dist(here[:2], self.goal[:2])
        self.nearest = min(self.nearest, gap)
        if gap <= 1.5 * CELL and not self.floor.leg(here, self.goal):
            self.found = [*_places(cell, self.came, self._place), self.goal]
        for other, cost in _neighbours(cell):
            self._offer(cell, other, self.best[cell] + cost)
        return True

    def why(self) -> str:
        """Say why the search found no path."""
        looked = f"{len(self.spots)} places were looked at, none nearer to the goal than {self.nearest:.2f} m"
        return f"{looked}; one of the obstacles: {self.last}"

    def _offer(self, cell: Cell, other: Cell, total: float) -> None:
        if other in self.closed or total >= self.best.get(other, math.inf):
            return
        place = unwound(self._place(other), self._place(cell))
        if _outside(place, self.start, self.goal):
            self.cut = True
            return
        if other not in self.spots:
            self.spots[other] = self.floor.hit(place)
        blocked = self.spots[other] or self.floor.leg(self._place(cell), place)
        if blocked:
            self.last = blocked
            return
        self.best[other], self.came[other] = total, cell
        heapq.heappush(self.queue, (total + self._ahead(other), other))

    def _place(self, cell: Cell) -> Vector3:
        x, y, turn = self.start
        return x + CELL * cell[0], y + CELL * cell[1], turn + math.tau / HEADINGS * cell[2]

    def _ahead(self, cell: Cell) -> float:
        here = self._place(cell)
        return math.dist(here[:2], self.goal[:2]) + TURNING * abs(unwound(here, self.goal)[2] - self.goal[2])


def _neighbours(cell: Cell) -> Iterator[tuple[Cell, float]]:
    x, y, k = cell
    for dx, dy in itertools.product((-1, 0, 1), repeat=2):
        if dx or dy:
            yield (x + dx, y + dy, k), CELL * math.hypot(dx, dy)
    for turn in (-1, 1):
        yield (x, y, (k + turn) % HEADINGS), TURNING * math.tau / HEADINGS


def _outside(place: Vector3, start: Vector3, goal: Vector3) -> bool:
    return any(
        not min(a, b) - AROUND <= v <= max(a, b) + AROUND
        for v, a, b in zip(place[:2], start[:2], goal[:2], strict=True)
    )


def _places(cell: Cell, came: Mapping[Cell, Cell], place: Callable[[Cell], Vector3]) -> list[Vector3]:
    """Places (x, y, yaw) along the path that the search found from its start to a cell, in order."""
    found = [place(cell)]
    while came[cell] != cell:
        cell = came[cell]
        found.append(place(cell))
    return found[::-1]


def _rewound(places: list[Vector3], start: Vector3) -> list[Vector3]:
    """Places of a path with yaw unwrapped: each is turned by less than half a turn from the one before it."""
    done = [start]
    for place in places[1:]:
        done.append(unwound(place, done[-1]))
    return done


def _shortened(floor: Ground, places: list[Vector3]) -> list[Vector3]:
    """Places of a path without the corners that a straight leg can skip, from the start on, the longest
    leg first."""
    done, k = [places[0]], 0
    while k < len(places) - 1:
        k = next(
            j for j in range(len(places) - 1, k, -1) if j == k + 1 or not floor.leg(places[k], places[j])
        )
        done.append(places[k])
    return done


def _halved(places: list[Vector3]) -> list[Vector3]:
    """Places at which the legs of a base path end; a leg that turns by nearly 180 deg is split, so that each
    half has a shorter way round."""
    done: list[Vector3] = []
    for a, b in itertools.pairwise(places):
        if abs(b[2] - a[2]) > HALF:
            done.append(_between(a, np.subtract(b, a), 0.5))
        done += [b] if b != a else []
    return done


def _between(a: Vector3, way: Any, share: float) -> Vector3:
    return a[0] + share * float(way[0]), a[1] + share * float(way[1]), a[2] + share * float(way[2])


def at(pose: Pose) -> Vector3:
    """Return the place (x, y, yaw) [m, rad] of a level pose."""
    return flat(pose)
