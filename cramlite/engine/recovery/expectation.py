"""Expected sensor readings of a run at each program line, from the run that proved the program; and how far they may
differ."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from msgspec import field
from msgspec.structs import replace

from ...base.value import Value
from ...model.entity_name import thing_of
from ...model.geometry import Floats, Pose, Vector3, seen_from
from ...model.run.readings import Deviation, Notice, Readings
from ...model.world.thing_boxes import boxes

if TYPE_CHECKING:
    from ...model.robot import Robot
    from ...model.run.rollout import Rollout
    from ...model.world.world import World

PLACE = 0.015
"""Largest distance of a thing from its place in the proof [m]: validators let nothing slip by more than 12 mm, or slide by
more than 15 mm."""
LEAN = math.radians(15.0)
"""Angle by which a thing may lean from its attitude in the proof [rad]: 10 deg from the vertical is upright."""
LOST = 0.05
"""Distance from which on a payload has left its place in the hand [m]; a nearer one has slipped."""
WIDTH = 0.002
"""Distance by which the opening of the fingers may differ from the proof [m]."""
PUSH, SHARE = 10.0, 1.5
"""Tolerance of the measured force: force beyond that of the proof [N], and multiple of it; the larger limit counts. Free motion of an arm
shows 3 to 9 N of inertia."""
SLOWER, LATER = 1.5, 2.0
"""Factor on the time that a line took in the proof, and time beyond that [s], after which the line takes too long."""
SIGMAS = 5.0
"""Number of standard deviations of the sensor noise that is added to every limit."""
SLACK = 0.2
"""Time before and after a program line of the proof from which readings are also accepted at that line [s]."""
AGAIN = 2
"""Number of readings in a row that must show a deviation."""
ASKED = {Deviation.GOAL_CHANGED, Deviation.CANCELLED}
"""Deviations that a single reading suffices to show, since they are changes of the request and not measurements."""
SAME = 0.5
"""Time after which unchanged readings count as frozen, if the arm should move [s]."""
MOVING = 0.02
"""Least motion of a joint at a program line of the proof with which the arm counts as moving there [rad]."""


class Noise(Value):
    """Noise of sensor readings, as standard deviations.

    Args:
        position: of things [m].
        turn: of things [rad].
        force: that is felt [N].
    """

    position: float = 0.0
    turn: float = 0.0
    force: float = 0.0


EXACT = Noise()


class Limits(Value):
    """Limits of how far a run may deviate from its proof; the constants of this module are the defaults.

    Args:
        place: of things [m].
        lean: of things [rad].
        width: of the fingers [m].
        push: beyond what the proof felt [N].
        slower, later: of a line of the program: a factor, and a time [s].
    """

    place: float = PLACE
    lean: float = LEAN
    width: float = WIDTH
    push: float = PUSH
    slower: float = SLOWER
    later: float = LATER


USUAL = Limits()


class Expectation(Value, eq=False):
    """Sensor values that a run should show, taken from the run that proved its program.

    Args:
        lines: (N,) under execution at each sample.
        times: (N,) [s].
        poses: thing -> (N, 7) in the world, of what moves freely or on a joint; "effector" is the tool centre point.
        in_hand: thing -> (N, 3) its origin in the tool's frame.
        held: what both pads press at each sample; "" for nothing.
        opening: (N,) of the fingers [m].
        force: (N,) felt [N].
        joints: (N, J) [rad].
        loose: things whose poses are compared.
        known: all things of the world that was believed.
        steps: line -> designator.
        base: of the arm in the world [m].
        reach: distance from there beyond which neither the arm nor its payload meets a thing [m].
    """

    lines: Floats
    times: Floats
    poses: Mapping[str, Floats]
    in_hand: Mapping[str, Floats]
    held: tuple[str, ...]
    opening: Floats
    force: Floats
    joints: Floats
    loose: tuple[str, ...]
    known: frozenset[str]
    steps: Mapping[int, str] = field(default_factory=dict)
    base: Vector3 = (0.0, 0.0, 0.0)
    reach: float = math.inf

    def no_matter(self, name: str, position: Vector3) -> bool:
        """Whether a thing was out of reach when the proof began, and still is: the run cannot meet it."""
        start = self.poses[name][0, :3].tolist()
        return min(math.dist(start, self.base), math.dist(position, self.base)) > self.reach

    def step(self, line: int) -> str:
        """Return the designator of the step that a program line belongs to; "" for lines before the first step."""
        before = [k for k in self.steps if k <= line]
        return self.steps[max(before)] if before else ""

    def rows(self, line: int) -> list[int]:
        """Return the indices of the proof's samples from ``SLACK`` seconds before a program line ran to ``SLACK``
        seconds after it; all for a line that never ran."""
        own = np.flatnonzero(self.lines == line)
        if not len(own):
            return list(range(len(self.lines)))
        begin, end = self.times[own[0]] - SLACK, self.times[own[-1]] + SLACK
        return [int(k) for k in np.flatnonzero((self.times >= begin) & (self.times <= end))]

    def own(self, line: int) -> list[int]:
        """Return the indices of the proof's samples at which a program line was being executed."""
        return [int(k) for k in np.flatnonzero(self.lines == line)]


def expectation(proof: Rollout, steps: Mapping[int, str], robot: Robot | None = None) -> Expectation:
    """Return the sensor values that a run should show, taken from the run that proved its program.

    Args:
        steps: line -> designator, as ``Code.origins``.
        robot: that runs; None where nobody knows how far it gets.
    """
    loose = tuple(t.name for t in proof.world.things if not t.furniture)
    tool, jointed = proof.poses["effector"], tuple(t.name for t in proof.world.things if t.movable and t.joint)
    tracks = {n: proof.poses[n] for n in (*loose, *jointed, "effector")}
    return Expectation(
        proof.lines, proof.times, tracks, {n: _in(tool, proof.poses[n]) for n in loose},
        tuple(_held(proof, k) for k in range(len(proof.times))), proof.opening, proof.contact_force(), proof.joints, loose,
        frozenset(t.name for t in proof.world.things), steps, proof.world.robots[0].base.position, _reach(proof.world, robot),
    )  # fmt: skip


def _reach(world: World, robot: Robot | None) -> float:
    """Return the distance from an arm's base within which the origins of all things lie that it or its payload can meet [m]."""
    if robot is None or robot.platform is not None:
        return math.inf
    loose = [t for t in world.things if not t.furniture]
    size = max((math.dist(c, t.pose.position) for t in loose for box in boxes(t) for c in product(*zip(*box, strict=True))), default=0.0)
    return robot.reach + math.hypot(*robot.gripper.tcp.position) + 2 * size


def _in(tool: Floats, track: Floats) -> Floats:
    """Return the positions of a pose track (N, 7) in the frames of another pose track (N, 7): (N, 3) [m]."""
    return seen_from(tool, track[:, :3])


def _held(proof: Rollout, sample: int) -> str:
    sides: dict[str, set[str]] = {"effector/left": set(), "effector/right": set()}
    for touch in proof.awake_touches[sample]:
        for pad, other in ((touch.a, touch.b), (touch.b, touch.a)):
            if pad in sides:
                sides[pad].add(thing_of(other))
    loose = {t.name for t in proof.world.things if t.movable}
    return min((sides["effector/left"] & sides["effector/right"]) & loose, default="")


class RunWatch:
    """Watcher that reports where the sensor readings of a run deviate from those of the run that proved its program.

    See ``cramlite.model.run.readings.Watch``.

    Args:
        expected: of the program.
        noise: of the readings, by which limits are wider; it is drawn here for readings of a simulation, which have none.
        seed: of that.
        period: between readings [s].
        limits: of deviations.
        asked: what was asked for last in place of the first goal, which the program follows; None for nothing.
        offsets: thing -> its believed pose in the frame of its pose as read, for things at poses that were corrected.
    """

    def __init__(
        self, expected: Expectation, noise: Noise = EXACT, seed: int = 0, period: float = 0.04, limits: Limits = USUAL,
        asked: tuple[str, ...] | None = None, offsets: Mapping[str, Pose] | None = None,
    ) -> None:  # fmt: skip
        self.asked, self.offsets = asked, offsets or {}
        self.expected, self.noise, self.period, self.limits = expected, noise, period, limits
        self._seen: set[str] = set()
        self.notice: Notice | None = None
        self.last: Readings | None = None
        self._draw = np.random.default_rng([seed, 79])
        self._before: tuple[Deviation, str] | None = None
        self._times = 0
        self._line, self._since = -1, 0.0
        self._same_since = 0.0
        self._raw: Readings | None = None

    def see(self, readings: Readings) -> Notice | None:
        """Return why the arm must stop; None while all is as expected."""
        frozen = self._frozen(readings)
        readings = self._noisy(readings) if readings.poses is not None else readings
        found = frozen or next(self._deviations(readings), None)
        self._seen |= (readings.poses or {}).keys()
        key = (found.kind, found.thing) if found else None
        self._times = self._times + 1 if key is not None and key == self._before else 1
        self._before = key
        self.notice = found if found is not None and (self._times >= AGAIN or found.kind in ASKED) else None
        return self.notice

    def rest(self, readings: Readings) -> None:
        """Take sensor readings at rest after a run as the run's last readings; noise is added to them."""
        self.last = self._noisy(readings) if readings.poses is not None else readings

    @property
    def nothing_moved(self) -> bool:
        """Whether the last sensor readings show every thing and the fingers where they were in the proof at the same
        program line."""
        now = self.last
        if now is None or now.poses is None:
            return False
        return not any(self._hand(now)) and not any(n for name in self.expected.loose for n in self._thing(name, now))

    def _noisy(self, readings: Readings) -> Readings:
        if not (self.noise.position or self.noise.turn or self.noise.force):
            return readings
        assert readings.poses is not None
        poses = {n: self._off(p) for n, p in sorted(readings.poses.items())}
        return replace(readings, poses=poses, force=readings.force + float(self._draw.normal(0.0, self.noise.force)))

    def _off(self, pose: Pose) -> Pose:
        way, turn = self._draw.normal(0.0, self.noise.position, 3), self._draw.normal(0.0, self.noise.turn, 3)
        return Pose.from_rotvec(np.add(pose.position, way), turn) * Pose(quaternion=pose.quaternion)

    def _frozen(self, readings: Readings) -> Notice | None:
        """Return a notice if all joint readings have stayed the same for ``SAME`` seconds at a line that
        moves the arm in the proof; None otherwise."""
        before, expected = self._raw, self.expected
        self._raw = readings
        if before is None or readings.joints != before.joints or readings.poses is None:
            self._same_since = readings.time
            return None
        own = expected.own(readings.line)
        moves = len(own) and float(np.ptp(expected.joints[own], axis=0).max()) > MOVING
        still = readings.time - self._same_since
        if not moves or still < SAME:
            return None
        said = f"the joint readings have not changed for {still:.2f} s, in which the arm moves in the proof"
        return self._said(Deviation.READINGS_FROZEN, readings, said, "", still, SAME, "s")

    def _deviations(self, now: Readings) -> Iterator[Notice]:
        """Generate notices of how the present readings deviate from those of the proof, the most important
        first."""
        if now.goal is not None and now.goal != self.asked:
            kind = Deviation.GOAL_CHANGED if now.goal else Deviation.CANCELLED
            yield self._said(kind, now, " and ".join(now.goal) or "the task was cancelled")
        if now.poses is None:
            yield self._said(Deviation.READINGS_LOST, now, "no poses can be read")
            return
        yield from self._hand(now)
        for name in self.expected.loose:
            yield from self._thing(name, now)
        for name in sorted(now.poses.keys() - self.expected.known):
            yield self._said(Deviation.ADDED, now, f"'{name}' is in the scene, and was not when the program was planned", name)
        yield from self._felt(now)
        yield from self._late(now)

    def _hand(self, now: Readings) -> Iterator[Notice]:
        rows = self.expected.rows(now.line)
        if not now.line:
            return
        off = float(np.min(np.abs(self.expected.opening[rows] - now.opening)))
        if off <= self.limits.width:
            return
        near = self.expected.opening[rows][np.argmin(np.abs(self.expected.opening[rows] - now.opening))]
        own, thing = self.expected.own(now.line), self._held_then(rows, now)
        kind = Deviation.NO_GRASP if now.opening < near and thing else Deviation.GRIPPER
        if own and all(self.expected.held[k] for k in own):
            kind, thing = Deviation.GRASP_LOST, self._held_then(own, now)
        said = f"the fingers are {1000 * now.opening:.1f} mm apart, {1000 * near:.1f} mm in the proof"
        yield self._said(kind, now, said, thing if kind is not Deviation.GRIPPER else "", off, self.limits.width, "m")

    def _held_then(self, rows: list[int], now: Readings) -> str:
        """Return the thing that was held in the proof at about the same time after the program line's start; "" if none
        was."""
        own, times = self.expected.own(now.line), self.expected.times
        since = now.time - self._since if now.line == self._line else 0.0
        then = times[own[0]] + since if own else now.time
        return min(((abs(times[k] - then), self.expected.held[k]) for k in rows if self.expected.held[k]), default=(0.0, ""))[1]

    def _thing(self, name: str, now: Readings) -> Iterator[Notice]:
        expected, rows = self.expected, self.expected.rows(now.line)
        assert now.poses is not None
        pose = now.poses.get(name)
        if pose is None and name not in self._seen:
            return  # what was never read is not missed
        if pose is None:
            yield self._said(Deviation.MISSING, now, f"'{name}' can no longer be seen", name)
            return
        pose *= self.offsets.get(name, Pose())
        if expected.no_matter(name, pose.position):
            return
        held = [k for k in rows if expected.held[k] == name]
        own = expected.own(now.line)
        always = len(own) > 0 and all(expected.held[k] == name for k in own)
        local = (now.tool.inverse() * pose).position
        hand = float(np.min(np.linalg.norm(expected.in_hand[name][held] - local, axis=1))) if held else math.inf
        world = _distance(expected.poses[name][rows, :3], np.array(pose.position))
        off, limit = hand if always else min(hand, world), self.limits.place + SIGMAS * self.noise.position
        lean, most = self._lean(name, pose, rows), self.limits.lean + SIGMAS * self.noise.turn
        if lean > most and not always:
            said = f"'{name}' leans {math.degrees(lean):.0f} deg from how it stood"
            yield self._said(Deviation.FALLEN, now, said, name, lean, most, "rad")
        if off > limit:
            yield self._displaced(name, now, off, limit, always)

    def _displaced(self, name: str, now: Readings, off: float, limit: float, always: bool) -> Notice:
        kind = Deviation.MOVED if not always else Deviation.GRASP_LOST if off > LOST else Deviation.SLIP
        what = "from its place in the hand" if always else "from where it should be"
        return self._said(kind, now, f"'{name}' is {1000 * off:.0f} mm {what}, more than {1000 * limit:.0f} mm", name, off, limit, "m")

    def _lean(self, name: str, pose: Pose, rows: list[int]) -> float:
        """Return the least angle between the measured z axis of a thing and its z axis in samples of the
        proof [rad]."""
        w, x, y, z = self.expected.poses[name][rows, 3:].T
        axes = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
        return float(np.arccos(np.clip(axes @ pose.rotation[:, 2], -1.0, 1.0)).min())

    def _felt(self, now: Readings) -> Iterator[Notice]:
        most = float(self.expected.force[self.expected.rows(now.line)].max())
        limit = max(SHARE * most, most + self.limits.push) + SIGMAS * self.noise.force
        if now.force > limit:
            said = f"{now.force:.1f} N are felt, at most {most:.1f} N in the proof"
            yield self._said(Deviation.CONTACT, now, said, "", now.force, limit, "N")

    def _late(self, now: Readings) -> Iterator[Notice]:
        if now.line != self._line:
            self._line, self._since = now.line, now.time
        own = self.expected.own(now.line)
        usual = float(np.ptp(self.expected.times[own])) if len(own) else 0.0
        lasted, limit = now.time - self._since, self.limits.slower * usual + self.limits.later
        if lasted > limit and now.line:
            said = f"the line has run for {lasted:.1f} s, {usual:.1f} s in the proof"
            yield self._said(Deviation.STUCK, now, said, "", lasted, limit, "s")

    def _said(
        self, kind: Deviation, now: Readings, reason: str, thing: str = "", measured: float | None = None, limit: float | None = None,
        unit: str = "",
    ) -> Notice:  # fmt: skip
        return Notice(kind, now.time, reason, self.expected.step(now.line), thing, measured, limit, unit)


def _distance(path: Floats, point: Floats) -> float:
    """Distance from a point (3,) to a path (N, 3) of straight pieces [m]."""
    starts, ways = path[:-1], np.diff(path, axis=0)
    if not len(ways):
        return float(np.linalg.norm(path[0] - point))
    share = np.clip(((point - starts) * ways).sum(axis=1) / np.maximum((ways * ways).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(starts + share[:, None] * ways - point, axis=1).min())
