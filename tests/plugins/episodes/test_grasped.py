"""Grasps at the borders of what counts as one: each force, way and speed just inside, and just outside."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.episode_builders import rollout
from msgspec.structs import replace

from cramlite.model import Floats
from cramlite_plugins.episodes.detection.grasped import grasps
from cramlite_plugins.episodes.detection.signals import GAP
from cramlite_plugins.episodes.detection.touches import Pair

COUNT, STEP = 200, 0.01
FIRST, LAST = 50, 150
"""Both pads press from sample FIRST on, and at LAST no longer."""
UP, ACROSS, ALONG = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
"""The pads close along y."""


def pressing(force: float, last: int = LAST) -> Floats:
    return np.where((np.arange(COUNT) >= FIRST) & (np.arange(COUNT) < last), force, 0.0)


def way(axis: tuple[float, float, float], metres: Any) -> Floats:
    """(COUNT, 3) positions: on a line from 0 while the pads press, or as they are given."""
    if np.ndim(metres) == 0:
        metres = metres * np.clip((np.arange(COUNT) - FIRST) / (LAST - 1 - FIRST), 0.0, 1.0)
    return np.outer(metres, axis)


NOWHERE = np.zeros((COUNT, 3))


def held(
    left: Any = 10.0, right: Any = 10.0, *, lift: tuple[float, float] = (0.0, 0.0), others: float = 0.0, hand: Floats = NOWHERE,
    inside: Floats = NOWHERE, opening: float = 0.04, step: float = STEP, turn: Floats | None = None, pads: float = 0.02,
) -> list[tuple[float, float]]:  # fmt: skip
    """When a thing was grasped, of which is known what the pads and others do to it, and where the hand and the thing in it are."""
    base, angle = rollout(), np.zeros(COUNT) if turn is None else turn
    quaternion = np.column_stack([np.cos(angle / 2), np.zeros((COUNT, 2)), np.sin(angle / 2)])
    c, s = np.cos(angle), np.sin(angle)
    turned = np.column_stack([c * inside[:, 0] - s * inside[:, 1], s * inside[:, 0] + c * inside[:, 1], inside[:, 2]])
    tips = {f"effector/{n}": hand + np.array([0.0, y, 0.0]) for n, y in (("left", pads), ("right", -pads))}
    poses = {n: np.hstack([p, quaternion]) for n, p in {"effector": hand, "product": hand + turned, **tips}.items()}
    run = replace(base, times=np.arange(COUNT) * step, opening=np.full(COUNT, opening), poses=poses)
    forces = (pressing(v) if np.ndim(v) == 0 else v for v in (left, right))
    pairs = {(f"hand/{n}", "product"): Pair(f, pressing(up)) for n, f, up in zip(("left", "right"), forces, lift, strict=True)}
    pairs["basket", "product"] = Pair(np.full(COUNT, others), np.full(COUNT, others))
    found = grasps(run, pairs)
    assert all(e.roles == {"gripper": "hand", "object": "product"} for e in found)
    return [(e.start, e.end) for e in found]


WHOLE = [(pytest.approx(0.5), pytest.approx(1.5))]
CARRIED: Any = {"lift": (1.0, 1.0)}


# How hard the pads press


def test_what_is_pressed_firmly_is_grasped_as_long_as_it_is() -> None:
    assert held() == WHOLE
    assert held(4.0, 4.0) == []


@pytest.mark.parametrize(("force", "grasped"), [(5.0, False), (5.001, True)])
def test_the_weaker_pad_says_whether_it_is_firm(force: float, grasped: bool) -> None:
    assert (held(left=force) == WHOLE) is grasped and (held(right=force) == WHOLE) is grasped
    assert grasped or held(left=force) == held(right=force) == []


@pytest.mark.parametrize(("force", "grasped"), [(0.6, False), (0.601, True)])
def test_each_pad_presses_from_a_force_on(force: float, grasped: bool) -> None:
    assert bool(held(left=force, **CARRIED)) is bool(held(right=force, **CARRIED)) is grasped


@pytest.mark.parametrize(("force", "until"), [(0.2, 1.0), (0.201, 1.5)])
def test_and_goes_on_pressing_down_to_a_lower_one(force: float, until: float) -> None:
    fades = np.where(np.arange(COUNT) < 100, pressing(10.0), pressing(force))
    for found in (held(left=fades, **CARRIED), held(right=fades, **CARRIED)):
        assert found == [(pytest.approx(0.5), pytest.approx(until))]


@pytest.mark.parametrize(("opening", "grasped"), [(0.001, False), (0.0011, True)])
def test_what_is_held_keeps_the_pads_apart(opening: float, grasped: bool) -> None:
    assert bool(held(opening=opening)) is grasped


def test_what_is_held_to_the_end_is_grasped_to_the_end() -> None:
    always = pressing(10.0, COUNT)
    assert held(always, always) == [(pytest.approx(0.5), pytest.approx(2.0))]


# Friction was seen to hold


@pytest.mark.parametrize("lift", [(1.2, 0.0), (0.0, 1.2)])
def test_the_lift_of_both_pads_is_theirs(lift: tuple[float, float]) -> None:
    assert held(4.0, 4.0, lift=lift, others=1.0) == WHOLE


@pytest.mark.parametrize(("others", "grasped"), [(0.97, True), (1.0, False)])
def test_the_pads_carry_more_than_all_others(others: float, grasped: bool) -> None:
    assert bool(held(4.0, 4.0, lift=(0.5, 0.5), others=others)) is grasped


@pytest.mark.parametrize(("lift", "grasped"), [(0.05, False), (0.051, True)])
def test_what_is_hardly_pushed_up_is_not_carried(lift: float, grasped: bool) -> None:
    """At one sample in GAP there is nothing to average."""
    assert bool(held(4.0, 4.0, lift=(lift, 0.0), step=GAP)) is grasped


@pytest.mark.parametrize(("metres", "grasped"), [(0.02, False), (0.021, True)])
def test_what_goes_along_is_held(metres: float, grasped: bool) -> None:
    for axis in (UP, ACROSS):
        assert bool(held(4.0, 4.0, hand=way(axis, metres))) is grasped


def test_what_is_pushed_along_by_one_of_the_pads_is_not() -> None:
    assert held(4.0, 4.0, hand=way(ALONG, 0.05)) == []


def test_without_a_direction_in_which_they_close_every_way_counts() -> None:
    """On average over half a turn of the hand there is none."""
    assert held(4.0, 4.0, hand=way(ALONG, 0.03), pads=0.0) == WHOLE
    assert held(4.0, 4.0, hand=way(ALONG, 0.03), pads=1e-3) == []


@pytest.mark.parametrize(("creeps", "grasped"), [(0.008, True), (0.012, False)])
def test_it_goes_along_further_than_it_creeps(creeps: float, grasped: bool) -> None:
    """The hand goes 30 mm up, and the thing by so much less."""
    assert bool(held(4.0, 4.0, hand=way(UP, 0.03 + creeps), inside=way(UP, -creeps))) is grasped


# It stays where it is in the hand


@pytest.mark.parametrize(("metres", "grasped"), [(0.02, False), (math.nextafter(0.02, 0.0), True)])
def test_what_creeps_out_was_not_held(metres: float, grasped: bool) -> None:
    assert bool(held(inside=way(UP, metres))) is grasped


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_where_it_is_in_the_hand_does_not_matter_nor_that_the_hand_turns(turn: float) -> None:
    """Turned by 40 deg while it is held 0.1 m beside the hand's middle, and 0.1 m below it."""
    aside = np.tile((0.1, 0.0, -0.1), (COUNT, 1))
    assert held(inside=aside, turn=turn * np.clip((np.arange(COUNT) - FIRST) / 100, 0.0, 1.0)) == WHOLE


@pytest.mark.parametrize(("way_in_hand", "grasped"), [(0.0075, True), (math.nextafter(0.0075, 1.0), False)])
def test_it_slips_where_it_is_faster_than_30_mm_in_a_second(way_in_hand: float, grasped: bool) -> None:
    """To and fro at four samples a second."""
    assert bool(held(inside=way(UP, way_in_hand * (np.arange(COUNT) % 2)), step=0.25)) is grasped


@pytest.mark.parametrize("axis", [UP, ACROSS])
@pytest.mark.parametrize(("speed", "grasped"), [(0.08, True), (0.1, False)])
def test_in_a_hand_that_moves_it_may_be_faster_by_a_share(axis: tuple[float, float, float], speed: float, grasped: bool) -> None:
    """At 0.2 m/s by 60 mm/s."""
    seconds = np.arange(COUNT) * STEP
    slides = speed * np.clip(seconds - 0.8, 0.0, 0.5)
    found = held(**CARRIED, hand=way(axis, 0.2 * seconds), inside=way(axis, -slides))
    assert (found == WHOLE) is grasped


def test_in_a_hand_that_only_turns_it_may_not() -> None:
    seconds = np.arange(COUNT) * STEP
    slides = 0.1 * np.clip(seconds - 0.8, 0.0, 0.5)
    assert held(**CARRIED, inside=way(UP, -slides), turn=2.0 + 2.0 * seconds) != WHOLE
    assert held(**CARRIED, turn=2.0 + 2.0 * seconds) == WHOLE
