"""Belief of an episode by camera, which pictures update.

While pictures are as predicted, things are believed to be where they are expected. Where a picture is not, known kinds are recognised in it
anew, and the things that explain its unexpected pixels are believed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Pose, Thing, Vector3, View, World
from cramlite.model.world.thing_boxes import boxes
from cramlite.perception.sightings import Seen, sightings
from cramlite.perception.unexpected import compared, predicted, share_of_robot, unexpected, without_robot

MOVED = 0.025
"""Least distance from where a thing is believed at which it counts as moved [m]: three times the errors of poses, at 95 %, and what a
grasp displaces."""
TURNED = 0.1
"""Least difference of a joint's values that counts [m, rad]: a door that is open by 6 deg."""
AROUND = 0.015
"""Margin of the boxes around a thing within which pixels are explained by it [m]."""
POINTS = 4
"""Least number of unexpected pixels that a thing must explain."""
FALLEN = 0.1
"""Distance from where the proof has a thing that was let go within which it may come to rest [m]."""
CLEARLY = 0.8
"""Share of a thing's pixels that show its background, beyond which it is gone, and has not only moved a little."""
UNKNOWN = "unknown_"
"""Beginning of the names of things that are none of the known kinds."""
OWN = 0.7
"""Least share of the robot's predicted pixels that show it; a picture that shows less was taken by a camera that was moved."""
Shown = tuple[Sequence[Thing], Sequence[Thing]]
"""Contents of a picture: things of known kinds, each named after its kind, and obstacles."""


class PictureBelief:
    """Belief of an episode by camera: the world as it is believed, and the last picture that was as expected.

    Args:
        engine: whose knowledge predicts pictures.
        world: as it was believed at first.
        kinds: name of each thing of that -> its kind.
        view: the picture that this was recognised in.
        recognise: takes a picture with colours; returns things of known kinds in it, and obstacles beside these and the believed ones.
        region: lowest and highest corner of the box within which pictures matter [m].
    """

    def __init__(
        self, engine: Engine, world: World, kinds: Mapping[str, str], view: View, recognise: Callable[[World], Shown],
        region: tuple[Vector3, Vector3],
    ) -> None:  # fmt: skip
        self.engine, self.world, self.kinds, self.recognise, self.region = engine, world, dict(kinds), recognise, region
        few = compared(view)
        self.then, own = predicted(few, world, engine.knowledge)
        self.before = without_robot(few, own)
        self.gone: dict[str, Thing] = {}
        self.displaced, self.log = "", list[str]()

    def update(self, view: View, expected: World, held: str = "", done: Iterable[str] = (), *, afresh: bool = False) -> set[str]:
        """Take a picture into the belief, beside the world that is expected; return the names of things that are not as expected.

        A picture in which the robot is not where its joints put it tells nothing, nor do later ones: the camera was moved.

        Args:
            held: name of the payload, whose own pixels tell nothing, as those of the robot; "" for none.
            done: names of things about which the picture tells nothing: the program let go of them, and they may still move.
            afresh: recognise all that is in the picture, though it may be as expected.
        """
        few = compared(view)
        believed, own = predicted(few, expected, self.engine.knowledge, held)
        share, depth = share_of_robot(few, own), without_robot(few, own)
        if share < OWN:
            self.displaced = f"the camera was moved: {100 * share:.0f} % of the robot's pixels show it"
        changed, self.world = set[str](), expected
        if self.displaced:
            self.log = [*self.log, self.displaced] if self.displaced not in self.log else self.log
            return changed
        points = few.world_cloud[unexpected(depth, believed, self.before, self.then)].astype(float)
        points = points[((points > self.region[0]) & (points < self.region[1])).all(axis=1)]
        for name in done:
            points = points[~_within(expected.thing(name), points, FALLEN)]
        if len(points) >= POINTS or afresh:
            changed = self._explain(view, points, 0.0 if afresh else MOVED)
            self.log.append(f"{len(points)} pixels are not as expected; {', '.join(sorted(changed)) or 'no thing explains them'}")
        tells = ~np.isnan(depth)
        self.before, self.then = np.where(tells, depth, self.before), np.where(tells, believed, self.then)
        return changed

    def _explain(self, view: View, points: Any, least: float) -> set[str]:
        """Change the believed world so that it explains a picture with unexpected points (n, 3) [m]; return the names of new things, gone
        ones, and those that moved by a least distance [m]. With 0, unknown things are recognised again, too."""
        world, before = self.world, [t for t in self.world.things if t.name.startswith(UNKNOWN)]
        things, obstacles = self.recognise(world if least else replace(world, things=tuple(t for t in world.things if t not in before)))
        loose = [t for t in world.things if t.name in self.kinds]
        unknown = [] if least else before

        def new_here(thing: Thing) -> bool:
            return _explains(thing, points) or any(off(thing, t) < FALLEN for t in unknown)

        shown = [t for t in things if not t.furniture and (new_here(t) or _there(t, loose))]
        pairs, new = matched([*loose, *self.gone.values()], shown, self.kinds)
        moved = {n: t.pose for n, t in pairs.items() if n in self.gone or off(world.thing(n), t) > least}
        moved |= turned((t for t in things if t.furniture), world)
        back = [self.gone.pop(n) for n in moved if n in self.gone]
        come = [self._named(t, world) for t in new if new_here(t)]
        blocks = [replace(t, name=f"{UNKNOWN}{len(self.log)}_{k}") for k, t in enumerate(filter(new_here, obstacles))]
        self.kinds |= {t.name: kind for t, kind in come}
        arrived = [t for t, _ in come] + blocks
        unseen = {t.name for t in loose} - pairs.keys()
        gone = self._gone(view, [*unseen, *(t.name for t in before)]) | {t.name for t in unknown}
        self.gone |= {n: world.thing(n) for n in gone if n in self.kinds}
        kept = [t for t in world.things if t.name not in gone]
        self.world = replace(world, things=(*kept, *back, *arrived)).put(moved)
        return {*moved, *(t.name for t in arrived), *gone}

    def _gone(self, view: View, names: Iterable[str]) -> set[str]:
        """Return which of some believed things a picture shows not to be there."""
        camera = Camera(view.camera, intrinsics=view.intrinsics)
        found = sightings(view, camera, self.world, names, self.engine.knowledge)
        return {s.thing for s in found if s.seen is Seen.GONE and s.gone > CLEARLY}

    def _named(self, thing: Thing, world: World) -> tuple[Thing, str]:
        """Return a thing that came under a name of its own, and its kind."""
        taken = {t.name for t in world.things}
        number = next(k for k in range(1, 100) if f"{thing.name}_{k}_new" not in taken)
        return replace(thing, name=f"{thing.name}_{number}_new"), thing.name


def matched(believed: Sequence[Thing], seen: Sequence[Thing], kinds: Mapping[str, str]) -> tuple[dict[str, Thing], list[Thing]]:
    """Match seen things with believed ones of their kinds, together the nearest.

    Returns:
        Name of each believed thing that was matched -> as it was seen; and those that were seen and not matched.
    """
    from scipy.optimize import linear_sum_assignment

    pairs: dict[str, Thing] = {}
    for kind in sorted({t.name for t in seen}):
        mine, theirs = [t for t in believed if kinds[t.name] == kind], [t for t in seen if t.name == kind]
        gaps = np.array([[off(a, b) for b in theirs] for a in mine]).reshape(len(mine), len(theirs))
        pairs |= {mine[i].name: theirs[j] for i, j in zip(*linear_sum_assignment(gaps), strict=True)}
    taken = {id(t) for t in pairs.values()}
    return pairs, [t for t in seen if id(t) not in taken]


def turned(seen: Iterable[Thing], world: World) -> dict[str, Pose]:
    """Return the pose of each part on a joint of a world's fixed things, such as a door, that is seen at another value of its joint.

    Args:
        seen: things of known kinds, each named after its kind, at the joints that are seen.
    """
    found: dict[str, Pose] = {}
    for base, *parts in (t.as_parts() for t in seen):
        mine = [t for t in world.things if t.name.startswith(f"{base.name}_") and t.joint is None and off(t, base) < MOVED]
        for part in parts if mine else ():
            ends = part.name.removeprefix(base.name)
            own = next((t for t in world.things if t.joint and t.joint.parent == mine[0].name and t.name.endswith(ends)), None)
            at = mine[0].pose * base.pose.inverse() * part.pose
            if own is not None and differs(own, own.moved_to(at)):
                found[own.name] = own.allowed(at)
    return found


def differs(one: Thing, other: Thing) -> bool:
    """Whether a thing is elsewhere, or its joint has another value."""
    turned = one.joint is not None and other.joint is not None and abs(one.joint.value - other.joint.value) > TURNED
    return turned or off(one, other) > MOVED


def off(believed: Thing, seen: Thing) -> float:
    return math.dist(believed.pose.position, seen.pose.position)


def _explains(thing: Thing, points: Any) -> bool:
    """Whether enough points (n, 3) [m] are in a thing, or at its surface."""
    return int(_within(thing, points, AROUND).sum()) >= POINTS


def _within(thing: Thing, points: Any, margin: float) -> Any:
    """Mask of points (n, 3) [m] in the boxes around a thing's parts, or nearer to them than a margin [m]."""
    inside = np.zeros(len(points), bool)
    for low, high in boxes(thing):
        inside |= ((points > np.subtract(low, margin)) & (points < np.add(high, margin))).all(axis=1)
    return inside


def _there(thing: Thing, believed: Iterable[Thing]) -> bool:
    """Whether a thing was seen where some thing is believed."""
    return any(off(t, thing) <= MOVED for t in believed)


def with_looks(world: World, kinds: Sequence[Thing]) -> World:
    """Return a scene that was written of kinds, with the words for each kind's looks, and for those of furniture's parts."""
    looks = {k.name: k.looks for k in kinds}
    of = _kinds(world.things, looks)
    return replace(world, things=tuple(replace(t, looks=looks.get(of[t.name], t.looks)) for t in world.things))


def kinds_in(things: Iterable[Thing], kinds: Iterable[str]) -> dict[str, str]:
    """Return the kind of each movable thing of a scene that was written of kinds. Drawers and doors are furniture."""
    return {name: kind for name, kind in _kinds((t for t in things if not t.furniture), kinds).items() if kind}


def _kinds(things: Iterable[Thing], kinds: Iterable[str]) -> dict[str, str]:
    """Return the kind of each thing, "" for none: its name begins with it, the longest one."""
    by_length = sorted(kinds, key=len, reverse=True)
    return {t.name: next((k for k in by_length if t.name.startswith(f"{k}_")), "") for t in things}
