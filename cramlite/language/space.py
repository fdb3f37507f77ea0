"""Directions seen by an observer: left and right, in front and behind, near and between."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import median

import numpy as np

from ..base.errors import UserError
from ..base.value import Value
from ..model.geometry import Pose
from ..model.world.thing_boxes import Box, around, boxes
from ..model.world.world import World

MARGIN = 0.02
"""Least distance by which one thing must be farther left, nearer, ... than all others to be the one meant [m]: twice what a depth camera
errs by."""
WIDE = 0.35
"""Largest gap at which things count as next to one another [m]: two widths of a plate."""
ASIDE = 0.15
"""Smallest offset from the middle of all things, as a share of their extent, at which the only thing of its kind counts as "the left
one"."""
Plane = tuple[float, float]
AXES: Mapping[str, Plane] = {"+x of": (1.0, 0.0), "-x of": (-1.0, 0.0), "+y of": (0.0, 1.0), "-y of": (0.0, -1.0)}
"""Relation along an axis of the world -> its direction."""


class View(Value):
    """View of an observer, from which left, right, front and back are judged.

    Args:
        name: of it, for people: "the robot", "the camera".
        right, away: directions in the world's plane.
    """

    name: str
    right: Plane
    away: Plane


def view_of(world: World, name: str = "") -> View:
    """Return the view named "robot", "camera", or "x, y" (a point of the world [m]).

    Without a name it is that of a fixed camera, else the robot's.

    Raises:
        UserError: there is no such view.
    """
    cameras = [c for c in world.cameras if c.mount is None]
    if name == "camera" and not cameras:
        raise UserError("there is no fixed camera to look from; say 'from the robot's view', or give the scenario a camera")
    if cameras and name in ("", "camera"):
        turn = cameras[0].pose.rotation
        ahead = turn[:2, 2] if float(np.hypot(*turn[:2, 2])) > 0.1 else -turn[:2, 1]
        return _view("the camera", ahead)
    if name in ("", "robot"):
        return _view("the robot", world.robots[0].base.rotation[:2, 0] if world.robots else np.array([1.0, 0.0]))
    try:
        x, y = (float(v) for v in name.split(","))
    except ValueError:
        raise UserError(f"there is no view '{name}'; it is robot, camera, or a point such as '1.2, 0' in metres") from None
    middle = np.mean([centre(around(boxes(t)))[:2] for t in world.things if t.movable and t.geoms] or [(0.0, 0.0)], axis=0)
    return _view(f"({x:g}, {y:g})", middle - np.array([x, y]))


def _view(name: str, ahead: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> View:
    x, y = (ahead / max(float(np.hypot(*ahead)), 1e-9)).tolist()
    return View(name, (y, -x), (x, y))


def centre(box: Box) -> tuple[float, float, float]:
    """Return the middle of a box [m]."""
    (a, b, c), (x, y, z) = box
    return (a + x) / 2, (b + y) / 2, (c + z) / 2


class Space:
    """Positions of things relative to a viewpoint, from which left, right and front are judged.

    Args:
        world: with the things at their believed poses.
        view: from where left and right are told.
    """

    def __init__(self, world: World, view: View) -> None:
        self.view, self._base = view, world.robots[0].base.inverse() if world.robots else Pose()
        self._boxes = {t.name: around(boxes(t)) for t in world.things if t.geoms}
        self._at = {t.name: t.pose.position for t in world.things}
        self._loose = [t.name for t in world.things if not t.furniture and t.geoms]

    def along(self, name: str, side: str) -> float:
        """Return the coordinate of a thing's centre towards a side ("left", "right", "front", "back", "top"
        or "bottom") [m]."""
        x, y, z = centre(self._boxes[name])
        right = x * self.view.right[0] + y * self.view.right[1]
        away = x * self.view.away[0] + y * self.view.away[1]
        return {"right": right, "left": -right, "back": away, "front": -away, "top": z, "bottom": -z}[side]

    def place(self, name: str) -> str:
        """Return a thing's name with its position, for people."""
        x, y, _ = self._at[name] if name in self._loose else centre(self._boxes[name])
        return f"{name} at ({x:.2f}, {y:.2f}) m"

    def below(self, name: str, furniture: Sequence[str]) -> str:
        """Return the highest furniture that is below a thing; "" if there is none."""
        x, y, _ = centre(self._boxes[name])
        floor = self._boxes[name][0][2] + MARGIN
        found = [
            (high[2], n) for n in furniture if n != name for low, high in (self._boxes[n],)
            if low[0] <= x <= high[0] and low[1] <= y <= high[1] and high[2] <= floor
        ]  # fmt: skip
        return max(found)[1] if found else ""

    def is_under(self, name: str, other: str) -> bool:
        """Check whether a thing is below another and, seen from above, overlaps it."""
        return self.gap(name, other) == 0 and self._boxes[name][1][2] < self._boxes[other][0][2] + MARGIN

    def gap(self, one: str, other: str) -> float:
        """Return the distance between two things, seen from above [m]; 0 where one is over the other."""
        (a, b), (c, d) = self._boxes[one], self._boxes[other]
        beside = (max(a[k] - d[k], c[k] - b[k], 0.0) for k in (0, 1))
        return math.hypot(*beside)

    def apart(self, one: str, other: str) -> float:
        """Return the horizontal distance between the centres of two things [m]."""
        return math.dist(centre(self._boxes[one])[:2], centre(self._boxes[other])[:2])

    def most(self, names: Sequence[str], side: str) -> list[str]:
        """Return the things farthest to a side: the farthest and all within ``MARGIN`` of it."""
        far = {n: self.along(n, side) for n in names}
        return [n for n in names if far[n] > max(far.values()) - MARGIN]

    def middle(self, names: Sequence[str]) -> list[str]:
        """Return the middle one of an odd number of things, along the direction in which they are spread
        most."""
        if len(names) % 2 == 0 or len(names) < 3:
            return []
        spread = {side: max(v) - min(v) for side in ("right", "back", "top") for v in ([self.along(n, side) for n in names],)}
        for side in sorted(spread, key=lambda s: -spread[s]):
            level = median(self.along(n, side) for n in names)
            names = [n for n in names if abs(self.along(n, side) - level) < MARGIN]
            if len(names) < 2:
                break
        return list(names)

    def nearest(self, names: Sequence[str], other: str, *, far: bool = False) -> list[str]:
        """Return the things nearest to another thing (or farthest from it), with all within ``MARGIN`` of the
        nearest."""
        sign = -1.0 if far else 1.0
        off = {n: sign * self.apart(n, other) for n in names}
        return [n for n in names if off[n] < min(off.values()) + MARGIN]

    def from_observer(self, names: Sequence[str], *, robot: bool, far: bool) -> list[str]:
        """Return the things nearest to the robot's base or to the observer; with ``far`` the farthest."""
        if not robot:
            return self.most(names, "back" if far else "front")
        x, y, _ = self._base.inverse().position
        off = {n: (-1.0 if far else 1.0) * math.dist(centre(self._boxes[n])[:2], (x, y)) for n in names}
        return [n for n in names if off[n] < min(off.values()) + MARGIN]

    def is_at(self, name: str, side: str) -> bool:
        """Check whether a thing is clearly at one side, or in the middle, of all movable things; the scene's
        only mug is "the left mug" only then."""
        if side in ("top", "bottom"):
            return True
        if side == "middle":
            return all(abs(self._off(name, s)) < 0.34 for s in ("right", "back"))
        return self._off(name, side) > ASIDE

    def _off(self, name: str, side: str) -> float:
        """Return how far a thing is from the middle of all movable things towards a side, as a share of their
        extent."""
        every = [self.along(n, side) for n in {*self._loose, name}]
        low, high = min(every), max(every)
        return (self.along(name, side) - (low + high) / 2) / max(high - low, 1e-9)

    def beside(self, name: str, relation: str, others: Sequence[str]) -> bool:
        """Check whether a thing is "left of", "right of", "in front of", "behind", "+x of", "next to" or "between" others."""
        if relation == "next to":
            return self.gap(name, others[0]) <= WIDE
        if relation == "between":
            return len(others) == 2 and self._between(name, *others)
        (x, y), (dx, dy) = self.towards(relation), self._off_from(name, others[0])
        ahead = dx * x + dy * y
        return ahead > MARGIN and ahead > abs(dx * y - dy * x) / 2

    def straight(self, name: str, relation: str, other: str) -> bool:
        """Check whether a thing is within 45 degrees of the direction from another one that a relation such as "behind" means."""
        (x, y), (dx, dy) = self.towards(relation), self._off_from(name, other)
        return dx * x + dy * y >= abs(dx * y - dy * x)

    def _off_from(self, name: str, other: str) -> Plane:
        (x, y, _), (a, b, _) = centre(self._boxes[name]), centre(self._boxes[other])
        return x - a, y - b

    def towards(self, relation: str) -> Plane:
        """Return the direction of a relation such as "left of" or "+x of" in the world's plane."""
        (x, y), (a, b) = self.view.right, self.view.away
        seen = {"left of": (-x, -y), "right of": (x, y), "in front of": (-a, -b), "behind": (a, b)}
        return {**seen, **AXES}[relation]

    def _between(self, name: str, one: str, other: str) -> bool:
        share, aside, long = self._on_line(name, one, other)
        return 0.1 < share < 0.9 and aside < long / 2

    def crosses(self, name: str, one: str, other: str) -> bool:
        """Check whether the line between two things, seen from above, passes through a thing: it is between them more than one beside."""
        (a, b, _), (x, y, _) = self._boxes[name]
        return self._on_line(name, one, other)[1] <= min(x - a, y - b) / 2

    def _on_line(self, name: str, one: str, other: str) -> tuple[float, float, float]:
        """Return the share of the way between two things at which a thing is, how far it is aside, and the length of that way [m]."""
        (a, b), (c, d), (x, y) = (centre(self._boxes[n])[:2] for n in (one, other, name))
        long = max(math.dist((a, b), (c, d)), 1e-9)
        share = ((x - a) * (c - a) + (y - b) * (d - b)) / long**2
        aside = abs((x - a) * (d - b) - (y - b) * (c - a)) / long
        return share, aside, long

    def size(self, name: str, *, height: bool) -> float:
        """Return a thing's size [m]: its height if ``height`` is true, else the cube root of its box's volume."""
        low, high = self._boxes[name]
        sides = [b - a for a, b in zip(low, high, strict=True)]
        return sides[2] if height else float(np.prod(sides)) ** (1 / 3)

    def side_word(self, relation: str) -> str:
        """Return the word for a relation in the robot's frame, which goals use, from the relation as the view
        sees it."""
        x, y = self.towards(relation)
        x, y, _ = self._base.rotate((x, y, 0.0)).tolist()
        ways = {"behind": x, "in front of": -x, "left of": y, "right of": -y}
        return max(ways, key=lambda w: ways[w])
