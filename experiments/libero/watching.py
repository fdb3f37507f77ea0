"""Watching a run by the fixed camera: pictures tell what is no longer where the proof of the program has it.

While pictures are as the program's proof predicts them, things are believed to be where the proof has them. Where a picture is not, known
kinds are recognised in it anew, and what explains the pixels that were not expected is believed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite import Engine
from cramlite.engine.recovery.expectation import RunWatch
from cramlite.model import Camera, Deviation, Notice, Pose, Readings, RobotMount, Thing, Vector3, View, World
from cramlite.model.world.thing_boxes import boxes
from cramlite.perception.sightings import Seen, sightings
from cramlite.perception.unexpected import differ, predicted, share_of_robot, thinned, unexpected, without_robot

EVERY = 5
"""Readings between two pictures: a quarter of a second."""
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
"""Share of a thing's pixels beyond which what is behind it shows that it is gone, and has not only moved a little."""
WAITS = 5
"""Largest number of pictures that are waited for until nothing moves in them any more."""
UNKNOWN = "unknown_"
"""Beginning of the names of things that are none of the known kinds."""
OWN = 0.7
"""Least share of the robot's predicted pixels that show it; a picture that shows less was taken by a camera that was moved."""
Shown = tuple[Sequence[Thing], Sequence[Thing]]
"""What a picture shows: things of known kinds, each named after its kind, and obstacles."""


class Sight:
    """Belief of an episode by camera: the world as it is believed, and the last picture that was as expected.

    Args:
        engine: whose knowledge predicts pictures.
        world: as it was believed at first.
        kinds: name of each thing of that -> its kind.
        view: the picture that this was recognised in.
        recognise: takes a picture with colours: what it shows of known kinds, and what else is in the way, beside what is believed.
        region: lowest and highest corner of the box within which pictures matter [m].
    """

    def __init__(
        self, engine: Engine, world: World, kinds: Mapping[str, str], view: View, recognise: Callable[[World], Shown],
        region: tuple[Vector3, Vector3],
    ) -> None:  # fmt: skip
        self.engine, self.world, self.kinds, self.recognise, self.region = engine, world, dict(kinds), recognise, region
        few = thinned(view)
        self.then, own = predicted(few, world, engine.knowledge)
        self.before = without_robot(few, own)
        self.gone: dict[str, Thing] = {}
        self.displaced, self.told = "", list[str]()

    def update(self, view: View, expected: World, held: str = "", done: Iterable[str] = (), *, afresh: bool = False) -> set[str]:
        """Take a picture into the belief, beside the world that is expected; return the names of things that are not as expected.

        A picture in which the robot is not where its joints put it tells nothing, nor do later ones: the camera was moved.

        Args:
            held: name of the payload, whose own pixels tell nothing, as those of the robot; "" for none.
            done: names of things about which the picture tells nothing: the program let go of them, and they may still move.
            afresh: recognise all that is in the picture, though it may be as expected.
        """
        few = thinned(view)
        believed, own = predicted(few, expected, self.engine.knowledge, held)
        share, depth = share_of_robot(few, own), without_robot(few, own)
        if share < OWN:
            self.displaced = f"the camera was moved: {100 * share:.0f} % of the robot's pixels show it"
        changed, self.world = set[str](), expected
        if self.displaced:
            self.told = [*self.told, self.displaced] if self.displaced not in self.told else self.told
            return changed
        points = few.world_cloud[unexpected(depth, believed, self.before, self.then)].astype(float)
        points = points[((points > self.region[0]) & (points < self.region[1])).all(axis=1)]
        for name in done:
            points = points[~_within(expected.thing(name), points, FALLEN)]
        if len(points) >= POINTS or afresh:
            changed = self._explain(view, points, 0.0 if afresh else MOVED)
            self.told.append(f"{len(points)} pixels are not as expected; {', '.join(sorted(changed)) or 'no thing explains them'}")
        tells = ~np.isnan(depth)
        self.before, self.then = np.where(tells, depth, self.before), np.where(tells, believed, self.then)
        return changed

    def _explain(self, view: View, points: Any, least: float) -> set[str]:
        """Change the believed world so that it explains a picture with unexpected points (n, 3) [m]; return the names of what is new,
        moved by a least distance [m], or gone in it. With 0 also what was unknown is looked at again."""
        world, before = self.world, [t for t in self.world.things if t.name.startswith(UNKNOWN)]
        things, obstacles = self.recognise(world if least else replace(world, things=tuple(t for t in world.things if t not in before)))
        loose = [t for t in world.things if t.name in self.kinds]
        unknown = [] if least else before

        def new_here(thing: Thing) -> bool:
            return _explains(thing, points) or any(_off(thing, t) < FALLEN for t in unknown)

        shown = [t for t in things if not t.furniture and (new_here(t) or _there(t, loose))]
        pairs, new = matched([*loose, *self.gone.values()], shown, self.kinds)
        moved = {n: t.pose for n, t in pairs.items() if n in self.gone or _off(world.thing(n), t) > least}
        moved |= turned((t for t in things if t.furniture), world)
        back = [self.gone.pop(n) for n in moved if n in self.gone]
        come = [self._named(t, world) for t in new if new_here(t)]
        blocks = [replace(t, name=f"{UNKNOWN}{len(self.told)}_{k}") for k, t in enumerate(filter(new_here, obstacles))]
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


class CameraWatch:
    """Watcher of a run that is shown, as poses of things, what pictures tell of those that the program has not moved yet; of those that it
    has moved, the last picture tells.

    Args:
        inner: that compares readings with the program's proof.
        sight: the belief, which pictures update.
        look: takes a picture; with it comes the robot as its encoders have it then.
        idle: lets the arm hold still for a quarter of a second.
    """

    def __init__(self, inner: RunWatch, sight: Sight, look: Callable[[], tuple[View, RobotMount]], idle: Callable[[], None]) -> None:
        self.inner, self.sight, self.look, self.idle, self.period = inner, sight, look, idle, inner.period
        self.number, self.told = 0, dict[str, Pose]()
        self.start = {t.name: t for t in sight.world.things}

    def see(self, readings: Readings) -> Notice | None:
        """Return why the arm must stop; None while the pictures and what the robot feels are as expected."""
        self.number += 1
        if self.number % EVERY == 0:
            gone = self._update(readings, self.look()[0], running=True)
            if gone:
                said = f"'{gone[0]}' is not where it should be, and nowhere in the picture"
                self.inner.notice = Notice(Deviation.MISSING, readings.time, said, self.inner.expected.step(readings.line), gone[0])
                return self.inner.notice
        return self.inner.see(replace(readings, poses=self.told))

    def rest(self, readings: Readings) -> None:
        """Take the last picture of a run into the belief, and give all believed poses as the last readings.

        After a stop, wait until nothing moves in the pictures: what is in the air will lie somewhere.
        """
        self.final = readings
        view, mount = self.look()
        for _ in range(WAITS if self.inner.notice else 0):
            self.idle()
            before, (view, mount) = view, self.look()
            if not differ(thinned(before), thinned(view)):
                break
        self._ended(view, mount)

    def look_afresh(self) -> None:
        """Recognise all that a picture shows after a run that was stopped: its target may stand a little aside."""
        self._ended(*self.look(), afresh=True)

    def _ended(self, view: View, mount: RobotMount, *, afresh: bool = False) -> None:
        self.final = replace(self.final, joints=mount.joints or self.final.joints, opening=mount.opening or 0.0)
        self._update(self.final, view, afresh=afresh or bool(self.sight.gone))
        self.inner.rest(replace(self.final, poses={t.name: t.pose for t in self.sight.world.things if not t.furniture or t.joint}))

    def _update(self, readings: Readings, view: View, *, running: bool = False, afresh: bool = False) -> list[str]:
        """Take a picture into the belief; return what is gone."""
        expected, held = self._expected(readings)
        done = {t.name for t in expected.things if _differs(self.start.get(t.name, t), t)} if running else set[str]()
        changed = self.sight.update(view, expected, held, done, afresh=afresh) - done
        there = {t.name: t.pose for t in self.sight.world.things if not (running and t.joint)}  # while it moves, the proof has a joint
        self.told = {n: p for n, p in self.told.items() if n in there} | {n: there[n] for n in changed if n in there}
        return sorted(changed & self.sight.gone.keys())

    def _expected(self, now: Readings) -> tuple[World, str]:
        """Return the world as the proof has it at the line under execution, with the tool where it is, and what pictures showed since; and
        the payload."""
        expected, world = self.inner.expected, self.sight.world
        rows = expected.rows(now.line) if now.line else [0]
        tool = expected.poses["effector"]
        row = min(rows, key=lambda k: math.dist(tool[k, :3], now.tool.position))
        poses = {n: _pose(track, row, tool, now, held=expected.held[row] == n) for n, track in expected.poses.items() if n != "effector"}
        there = {t.name for t in world.things}
        mount = replace(world.robots[0], joints=now.joints, opening=now.opening)
        poses = {n: possible(world.thing(n), p) for n, p in poses.items() if n in there and n not in self.told}
        world = world.put(poses | self.told)
        held = expected.held[row]
        free = held in expected.loose and held not in self.told  # a handle is where its joint has it
        return replace(world, robots=(mount, *world.robots[1:])), held if free else ""


def _pose(track: Any, row: int, tool: Any, now: Readings, *, held: bool) -> Pose:
    pose = Pose.from_row(track[row])
    return now.tool * Pose.from_row(tool[row]).inverse() * pose if held else pose


def matched(believed: Sequence[Thing], seen: Sequence[Thing], kinds: Mapping[str, str]) -> tuple[dict[str, Thing], list[Thing]]:
    """Match seen things with believed ones of their kinds, together the nearest.

    Returns:
        Name of each believed thing that was matched -> as it was seen; and those that were seen and not matched.
    """
    from scipy.optimize import linear_sum_assignment

    pairs: dict[str, Thing] = {}
    for kind in sorted({t.name for t in seen}):
        mine, theirs = [t for t in believed if kinds[t.name] == kind], [t for t in seen if t.name == kind]
        gaps = np.array([[_off(a, b) for b in theirs] for a in mine]).reshape(len(mine), len(theirs))
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
        mine = [t for t in world.things if t.name.startswith(f"{base.name}_") and t.joint is None and _off(t, base) < MOVED]
        for part in parts if mine else ():
            ends = part.name.removeprefix(base.name)
            own = next((t for t in world.things if t.joint and t.joint.parent == mine[0].name and t.name.endswith(ends)), None)
            at = mine[0].pose * base.pose.inverse() * part.pose
            if own is not None and _differs(own, own.moved_to(at)):
                found[own.name] = possible(own, at)
    return found


def possible(thing: Thing, pose: Pose) -> Pose:
    """Return the pose nearest to a given one that a thing's joint allows; the given one of a thing without a joint."""
    joint = thing.moved_to(pose).joint
    if joint is None:
        return pose
    return joint.moved(pose, min(max(joint.value, joint.lower), joint.upper) - joint.value)


def _differs(one: Thing, other: Thing) -> bool:
    """Whether a thing is elsewhere, or its joint has another value."""
    turned = one.joint is not None and other.joint is not None and abs(one.joint.value - other.joint.value) > TURNED
    return turned or _off(one, other) > MOVED


def _off(believed: Thing, seen: Thing) -> float:
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
    return any(_off(t, thing) <= MOVED for t in believed)


def kinds_in(things: Iterable[Thing], kinds: Sequence[str]) -> dict[str, str]:
    """Return the kind of each movable thing of a scene that was written of kinds: its name begins with it, longest first."""
    by_length = sorted(kinds, key=len, reverse=True)
    found = {t.name: next((k for k in by_length if t.name.startswith(f"{k}_")), "") for t in things if t.movable}
    return {name: kind for name, kind in found.items() if kind}
