"""Recordings as virtual reality writes them, scripted: poses of hands, things and grains, and nothing else.

Each is what somebody might do, with what a person who watches it would say (``EXPECTED``). Not copies of any recording.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from cramlite.model import Episode, Event, Floats
from cramlite_plugins.episodes.formats.complete import episode_of
from cramlite_plugins.episodes.formats.parts import Parts
from cramlite_plugins.episodes.tracks import Rows, compose

RIGHT, LEFT = "SK_TestRightHand", "SK_TestLeftHand"
START = 1_700_000_000.0
"""Start of the recordings, in seconds since 1970, as recorders write their time stamps."""
GRIP = np.array([0.13, 0.0, 0.02])
"""Position of a held thing in the hand's frame [m]: the frame of a recorded hand is at the wrist."""

Key = tuple[float, tuple[float, float, float], float]
"""Key pose of a hand: time [s], position [m], tilt about the y axis [rad]."""
Recording = dict[str, Floats]
"""Recording of poses: frame -> rows (time, x, y, z, qw, qx, qy, qz)."""


def path(times: Floats, *keys: Key) -> Floats:
    """Return poses (N, 7) that interpolate key poses, at rest at each key."""
    at = np.array([k[0] for k in keys])
    where = np.clip(np.searchsorted(at, times, side="right") - 1, 0, len(at) - 2)
    share = np.clip((times - at[where]) / (at[where + 1] - at[where]), 0, 1)
    smooth = share**3 * (10 - 15 * share + 6 * share**2)  # least jerk (Flash and Hogan, 1985)
    positions = np.array([k[1] for k in keys])
    tilts = np.array([k[2] for k in keys])
    poses = np.zeros((len(times), 7))
    poses[:, :3] = positions[where] + smooth[:, None] * (positions[where + 1] - positions[where])
    tilt = tilts[where] + smooth * (tilts[where + 1] - tilts[where])
    poses[:, 3], poses[:, 5] = np.cos(tilt / 2), np.sin(tilt / 2)
    return poses


def at_thing(pose: tuple[float, float, float], tilt: float = 0.0) -> tuple[float, float, float]:
    """Return the position of a hand that holds a thing at a position."""
    grip = Rotation.from_euler("y", tilt).apply(GRIP)
    return (pose[0] - grip[0], pose[1] - grip[1], pose[2] - grip[2])


def held(hand: Floats, times: Floats, start: float, end: float, before: tuple[float, float, float]) -> Floats:
    """Return the poses of a thing that stands, moves with the hand from start to end, and stands where it was released."""
    poses = np.tile([*before, 1.0, 0, 0, 0], (len(times), 1))
    inside = (times >= start) & (times < end)
    poses[inside] = compose(hand[inside], np.tile([*GRIP, 1.0, 0, 0, 0], (int(inside.sum()), 1)))
    poses[times >= end] = poses[inside][-1]
    return poses


def grains(times: Floats, cup: Floats, into: tuple[float, float, float], falls: float, count: int, spilled: int = 0) -> Recording:
    """Return tracks of grains that follow a cup, and from a given time on fall one after the other into a bowl, or beside it."""
    found = {}
    for k in range(count):
        offset = np.array([0.012 * np.cos(k), 0.012 * np.sin(k), 0.02])
        poses = compose(cup, np.tile([*offset, 1.0, 0, 0, 0], (len(times), 1)))
        end = np.add(into, [0.02 * np.cos(2 * k), 0.02 * np.sin(2 * k), 0.01])
        if k < spilled:
            end += [0.3, 0.25, 0.0]
        start = falls + 0.05 * k
        share = np.clip((times - start) / 0.25, 0, 1)[:, None]
        first = poses[int(np.searchsorted(times, start))] if start < times[-1] else poses[-1]
        gone = times >= start
        poses[gone, :3] = (first[:3] + share * (end - first[:3]))[gone]
        found[f"particle{k + 1}"] = poses
    return found


def rows(times: Floats, poses: Floats, on_change: bool = False) -> Floats:
    """Return the recorded rows of a frame: all poses, or those that differ from the one before."""
    table = np.column_stack([START + times, poses])
    if not on_change:
        return table
    changed = np.concatenate([[True], np.any(np.abs(np.diff(poses, axis=0)) > 1e-9, axis=1)])
    return np.asarray(table[changed])


def _once(position: tuple[float, float, float]) -> Floats:
    return np.array([[START, *position, 1.0, 0, 0, 0]])


CUP, BOWL, DISH = (0.6, 0.2, 0.9), (0.45, -0.1, 0.9), (0.9, -0.5, 0.9)
OVER = (0.51, -0.07, 1.12)
HOME = (0.1, 0.4, 1.3)


Point = tuple[float, float, float]


def _pour_keys(cup: Point, over: Point, back: Point, t: float = 0.0) -> list[Key]:
    up = (cup[0], cup[1], cup[2] + 0.2)
    above = (back[0], back[1], back[2] + 0.2)
    return [
        (t + 3.0, at_thing(cup), 0.0), (t + 3.6, at_thing(cup), 0.0), (t + 4.8, at_thing(up), 0.0), (t + 6.0, at_thing(over), 0.0),
        (t + 7.2, at_thing(over, 1.8), 1.8), (t + 8.8, at_thing(over, 1.8), 1.8), (t + 10.0, at_thing(over), 0.0),
        (t + 11.2, at_thing(above), 0.0), (t + 12.2, at_thing(back), 0.0), (t + 12.9, at_thing(back), 0.0),
    ]  # fmt: skip


def pouring(rate: float = 45.0, *, spilled: int = 0, tilts: bool = True, count: int = 6) -> Recording:
    """Record a person who takes a cup, pours its content into a bowl and puts it back; a second dish with grains stands beside."""
    times = np.arange(0, 17, 1 / rate)
    keys = _pour_keys(CUP, OVER, (0.62, 0.21, 0.9))
    if not tilts:
        keys = [(t, at_thing(OVER) if 7 < t < 9 else p, 0.0) for t, p, _ in keys]
    hand = path(times, (0, HOME, 0.0), *keys, (15.0, HOME, 0.0), (17.0, HOME, 0.0))
    cup = held(hand, times, 3.6, 12.2, CUP)
    loose = grains(times, cup, BOWL, 8.0 if tilts else 99.0, count, spilled)
    resting = {f"particle{20 + k}": rows(times[:2], np.tile([DISH[0] + 0.02 * k, *DISH[1:], 1.0, 0, 0, 0], (2, 1))) for k in range(4)}
    still = np.tile([-1.0, 0.8, 0.9, 1.0, 0, 0, 0], (len(times), 1))
    return {
        RIGHT: rows(times, hand), LEFT: rows(times, still), "cup": rows(times, cup), "SM_TestBowl": _once(BOWL), "SM_Dish": _once(DISH),
        **{n: rows(times, p, on_change=True) for n, p in loose.items()}, **resting,
    }  # fmt: skip


def pouring_twice(rate: float = 45.0) -> Recording:
    """Record a person who pours two cups into one bowl, one after the other."""
    times = np.arange(0, 33, 1 / rate)
    other, back = (0.75, 0.2, 0.9), (0.75, 0.22, 0.9)
    hand = path(
        times, (0, HOME, 0.0), *_pour_keys(CUP, OVER, CUP), (14.5, HOME, 0.0), *_pour_keys(other, OVER, back, 15.0),
        (31, HOME, 0.0), (33, HOME, 0.0),
    )  # fmt: skip
    first, second = held(hand, times, 3.6, 12.2, CUP), held(hand, times, 18.6, 27.2, other)
    one = grains(times, first, BOWL, 8.0, 5)
    two = {f"particle{10 + k}": p for k, p in enumerate(grains(times, second, BOWL, 23.0, 5).values())}
    return {
        RIGHT: rows(times, hand), "cup_a": rows(times, first), "cup_b": rows(times, second), "SM_TestBowl": _once(BOWL),
        **{n: rows(times, p, on_change=True) for n, p in {**one, **two}.items()},
    }  # fmt: skip


def pouring_with_both_hands(rate: float = 45.0) -> Recording:
    """Record a person who pours as in ``pouring`` while the left hand also holds the cup."""
    found = pouring(rate)
    cup = found["cup"]
    times = cup[:, 0] - START
    beside = compose(cup[:, 1:], np.tile([0.09, 0.06, 0.0, 1.0, 0, 0, 0], (len(times), 1)))
    away = np.array([1.2, 0.6, 1.2, 1.0, 0, 0, 0])
    come, go = np.clip((times - 1.5) / 1.5, 0, 1)[:, None], np.clip((times - 13.0) / 1.5, 0, 1)[:, None]
    near = come * (1 - go)
    left = away + near * (beside - away)
    left[:, 3:] = np.where(near > 0.99, beside[:, 3:], [1.0, 0, 0, 0])
    return found | {LEFT: rows(times, left)}


def pouring_with_either_hand(rate: float = 45.0) -> Recording:
    """Record a person who pours as in ``pouring_twice``, the second cup with the left hand; each hand rests while the other one works."""
    found = pouring_twice(rate)
    hand = found[RIGHT]
    times = hand[:, 0] - START
    rest, other = np.array([*HOME, 1.0, 0, 0, 0]), np.array([0.1, -0.6, 1.3, 1.0, 0, 0, 0])
    late = (times >= 14.5)[:, None]
    right, left = np.where(late, rest, hand[:, 1:]), np.where(late, hand[:, 1:], other)
    return found | {RIGHT: rows(times, right), LEFT: rows(times, left)}


def shaking(rate: float = 10.0, swings: int = 6) -> Recording:
    """Record a person who takes a shaker, swings it, tilted, over a plate, and puts it back."""
    times = np.arange(0, 14, 1 / rate)
    shaker, plate, over = (0.6, 0.2, 0.9), (0.5, -0.1, 0.86), (0.51, -0.08, 1.0)
    up = (0.6, 0.2, 1.05)
    keys: list[Key] = [
        (0, HOME, 0.0), (2.2, at_thing(shaker), 0.0), (2.6, at_thing(shaker), 0.0), (3.4, at_thing(up), 0.3),
        (4.2, at_thing(over, 1.4), 1.4), (8.6, at_thing(over, 1.4), 1.4), (9.4, at_thing(up), 0.3),
        (10.4, at_thing(shaker), 0.0), (11.0, at_thing(shaker), 0.0),
        (12.5, HOME, 0.0), (14, HOME, 0.0),
    ]  # fmt: skip
    hand = path(times, *keys)
    shaken = (times > 4.3) & (times < 4.3 + 0.7 * swings)
    hand[shaken, 2] += 0.035 * np.sin(2 * np.pi * (times[shaken] - 4.3) / 0.7)
    moved = held(hand, times, 2.6, 10.4, shaker)
    return {RIGHT: rows(times, hand), "salt_shaker": rows(times, moved, on_change=True), "test_plate": _once(plate)}


def carrying_a_tray(rate: float = 30.0) -> Recording:
    """Record a person who carries a tray with two cups on it from one place to another."""
    times = np.arange(0, 11, 1 / rate)
    here, there = (0.6, 0.3, 0.9), (0.6, -0.9, 0.9)
    up, over = (0.6, 0.3, 1.1), (0.6, -0.9, 1.1)
    hand = path(
        times, (0, HOME, 0.0), (2.5, at_thing(here), 0.0), (3.0, at_thing(here), 0.0), (4.0, at_thing(up), 0.0), (6.5, at_thing(over), 0.0),
        (7.5, at_thing(there), 0.0), (8.2, at_thing(there), 0.0), (10, HOME, 0.0), (11, HOME, 0.0),
    )  # fmt: skip
    tray = held(hand, times, 3.0, 7.5, here)
    on = {
        name: compose(tray, np.tile([x, y, 0.05, 1.0, 0, 0, 0], (len(times), 1)))
        for name, x, y in (("mug", 0.12, 0.1), ("glass", 0.1, -0.12))
    }
    return {RIGHT: rows(times, hand), "tray": rows(times, tray), **{n: rows(times, p) for n, p in on.items()}}


def dropped(found: Recording, random: np.random.Generator) -> Recording:
    """Remove a tenth of a recording's poses at random; frames with at most four rows stay complete."""
    return {n: r[random.random(len(r)) > 0.1] if len(r) > 4 else r for n, r in found.items()}


def noisy(found: Recording, random: np.random.Generator) -> Recording:
    """Add noise to a recording's poses: 5 mm on each axis and 2 degrees about a random axis."""
    result = {}
    for name, table in found.items():
        shaken = table.copy()
        shaken[:, 1:4] += random.normal(0, 0.005, (len(table), 3))
        turn = Rotation.from_rotvec(random.normal(0, np.radians(2) / np.sqrt(3), (len(table), 3)))
        quaternions = (turn * Rotation.from_quat(table[:, [5, 6, 7, 4]])).as_quat()
        shaken[:, 4:] = quaternions[:, [3, 0, 1, 2]]
        result[name] = shaken
    return result


def halved(found: Recording, random: np.random.Generator) -> Recording:
    """Keep every second pose of a recording, from the first or the second on."""
    first = int(random.integers(2))
    return {n: r[first::2] if len(r) > 4 else r for n, r in found.items()}


def without(hand: str) -> Callable[[Recording, np.random.Generator], Recording]:
    """Return a function that replaces a hand's track by an identity pose, as trackers write it that do not see the hand."""

    def change(found: Recording, _random: np.random.Generator) -> Recording:
        return {**found, hand: np.array([[START, 0, 0, 0, 1.0, 0, 0, 0]])} if hand in found else found

    return change


def read(found: Recording, parents: Mapping[str, str] | None = None, events: tuple[Event, ...] = ()) -> Episode:
    """Convert a recording of an unknown recorder to the episode that the reader makes of it, with recorded events."""
    tables = {}
    for name, table in found.items():
        parent = (parents or {}).get(name, "map")
        tables[name] = Rows(table[:, 0].copy(), table[:, 1:].copy(), np.zeros(len(table), dtype=np.int32), (parent,), False)
    return episode_of(Parts("scripted", events=events, rows=tables, foreign=True))
