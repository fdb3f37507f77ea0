"""Watcher of a run by the fixed camera: things are expected where the proof of the program has them, and pictures are compared with
that."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from msgspec.structs import replace

from cramlite.engine.recovery.expectation import RunWatch
from cramlite.model import Deviation, Notice, Pose, Readings, RobotMount, View, World
from cramlite.perception.unexpected import compared, differ

from .picture_belief import PictureBelief, differs

EVERY = 5
"""Readings between two pictures: a quarter of a second."""
WAITS = 5
"""Largest number of pictures that are waited for until nothing moves in them any more."""


class CameraWatch:
    """Watcher of a run: pictures tell the poses of things that the program has not moved yet. Of those that it has moved, the last picture
    tells.

    Args:
        inner: that compares readings with the program's proof.
        belief: that pictures update.
        look: takes a picture; with it comes the robot as its encoders have it then.
        idle: lets the arm hold still for a quarter of a second.
    """

    def __init__(
        self, inner: RunWatch, belief: PictureBelief, look: Callable[[], tuple[View, RobotMount]], idle: Callable[[], None]
    ) -> None:  # fmt: skip
        self.inner, self.belief, self.look, self.idle, self.period = inner, belief, look, idle, inner.period
        self.number, self.elsewhere = 0, dict[str, Pose]()
        self.start = {t.name: t for t in belief.world.things}

    def see(self, readings: Readings) -> Notice | None:
        """Return why the arm must stop; None while the pictures and what the robot feels are as expected."""
        self.number += 1
        if self.number % EVERY == 0:
            gone = self._update(readings, self.look()[0], running=True)
            if gone:
                said = f"'{gone[0]}' is not where it should be, and nowhere in the picture"
                self.inner.notice = Notice(Deviation.MISSING, readings.time, said, self.inner.expected.step(readings.line), gone[0])
                return self.inner.notice
        return self.inner.see(replace(readings, poses=self.elsewhere))

    def rest(self, readings: Readings) -> None:
        """Take the last picture of a run into the belief, and give all believed poses as the last readings.

        After a stop, wait until nothing moves in the pictures: a thing in the air will lie somewhere.
        """
        self.final = readings
        view, mount = self.look()
        for _ in range(WAITS if self.inner.notice else 0):
            self.idle()
            before, (view, mount) = view, self.look()
            if not differ(compared(before), compared(view)):
                break
        self._ended(view, mount)

    def look_afresh(self) -> None:
        """Recognise all that a picture shows after a run that was stopped: its target may stand a little aside."""
        self._ended(*self.look(), afresh=True)

    def _ended(self, view: View, mount: RobotMount, *, afresh: bool = False) -> None:
        self.final = replace(self.final, joints=mount.joints or self.final.joints, opening=mount.opening or 0.0)
        self._update(self.final, view, afresh=afresh or bool(self.belief.gone))
        self.inner.rest(replace(self.final, poses={t.name: t.pose for t in self.belief.world.things if not t.furniture or t.joint}))

    def _update(self, readings: Readings, view: View, *, running: bool = False, afresh: bool = False) -> list[str]:
        """Take a picture into the belief; return the names of things that are gone."""
        expected, held = self._expected(readings)
        done = {t.name for t in expected.things if differs(self.start.get(t.name, t), t)} if running else set[str]()
        changed = self.belief.update(view, expected, held, done, afresh=afresh) - done
        there = {t.name: t.pose for t in self.belief.world.things if not (running and t.joint)}  # while it moves, the proof has a joint
        self.elsewhere = {n: p for n, p in self.elsewhere.items() if n in there} | {n: there[n] for n in changed if n in there}
        return sorted(changed & self.belief.gone.keys())

    def _expected(self, now: Readings) -> tuple[World, str]:
        """Return the world as the proof has it at the line under execution, with the tool where it is, and what pictures showed since; and
        the payload."""
        expected, world = self.inner.expected, self.belief.world
        rows = expected.rows(now.line) if now.line else [0]
        tool = expected.poses["effector"]
        row = min(rows, key=lambda k: math.dist(tool[k, :3], now.tool.position))
        poses = {n: _pose(track, row, tool, now, held=expected.held[row] == n) for n, track in expected.poses.items() if n != "effector"}
        there = {t.name for t in world.things}
        mount = replace(world.robots[0], joints=now.joints, opening=now.opening)
        poses = {n: world.thing(n).allowed(p) for n, p in poses.items() if n in there and n not in self.elsewhere}
        world = world.put(poses | self.elsewhere)
        held = expected.held[row]
        free = held in expected.loose and held not in self.elsewhere  # a handle is where its joint has it
        return replace(world, robots=(mount, *world.robots[1:])), held if free else ""


def _pose(track: Any, row: int, tool: Any, now: Readings, *, held: bool) -> Pose:
    pose = Pose.from_row(track[row])
    return now.tool * Pose.from_row(tool[row]).inverse() * pose if held else pose
