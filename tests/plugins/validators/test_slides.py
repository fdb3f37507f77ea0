"""Slides of a payload: from where a contact begins, as far as it goes, in the frame of what is touched, and whatever only turns."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from helpers.short_runs import COUNT, STEP, TAKEN, posed
from msgspec.structs import replace

from cramlite.model import Floats, Joint, Pose, Rollout, Touch
from cramlite_plugins.validators.grips import Grip
from cramlite_plugins.validators.slides import GAP, SKIMS, Slide, slides

GRIP, ALL = Grip("block", TAKEN, 69), range(COUNT)


def run(way: Floats, touches: Iterable[int], **poses: Floats) -> Rollout:
    """A run in which the block goes a way and touches the cup at some samples, and nothing else touches anything."""
    rows, made = set(touches), posed(block=way, **poses).rollout
    assert made is not None
    contact = (Touch("block", "cup", 1.0, 0.0), Touch("floor", "cup", 1.0, 0.0))
    return replace(made, touches=tuple(contact if k in rows else () for k in ALL))


def led(*knots: tuple[int, float, float]) -> Floats:
    """(COUNT, 7) the block's poses: sample, x, and height between them."""
    way = np.zeros((COUNT, 7))
    samples = [k for k, _, _ in knots]
    way[:, 0] = np.interp(ALL, samples, [x for _, x, _ in knots])
    way[:, 2] = np.interp(ALL, samples, [z for _, _, z in knots])
    way[:, 3] = 1.0
    return way


def found(rollout: Rollout, within: range = ALL) -> list[Slide]:
    return list(slides(rollout, GRIP, within))


def test_a_slide_is_from_the_first_contact_to_the_furthest_point() -> None:
    there_and_back = led((20, 0.0, 0.0), (30, 0.1, 0.0), (40, 0.02, 0.0), (41, 0.02, 0.5))
    (slide,) = found(run(there_and_back, range(22, 41)))
    assert slide == Slide("block", "cup", pytest.approx(0.08), 22, 30)


def test_only_what_is_in_the_hand_and_within_the_task_counts() -> None:
    away = run(led((0, 0.0, 0.0), (COUNT - 1, 0.99, 0.0)), ALL)
    for within, first, last in ((ALL, TAKEN, 69), (range(15), TAKEN, 14), (range(30, 50), 30, 49), (range(60, 99), 60, 69)):
        assert found(away, within) == [Slide("block", "cup", pytest.approx(0.01 * (last - first)), first, last)]
    assert found(away, range(5)) == [] == found(away, range(70, 90))


@pytest.mark.parametrize(("pause", "stretches"), [(round(GAP / STEP) - 1, 1), (round(GAP / STEP) + 2, 2)])
def test_a_contact_that_is_lost_for_long_is_another_one(pause: int, stretches: int) -> None:
    leaps = led((29, 0.0, 0.0), (30, 0.05, 0.1), (29 + pause, 0.05, 0.1), (30 + pause, 0.1, 0.0))
    slid = found(run(leaps, [*range(20, 30), *range(30 + pause, 50)]))
    assert [(s.first, s.last) for s in slid] == ([(20, 30 + pause)] if stretches == 1 else [(20, 20), (30 + pause, 30 + pause)])


@pytest.mark.parametrize(("height", "way"), [(0.0, 0.1), (0.9 * SKIMS, 0.1), (-0.9 * SKIMS, 0.1), (1.1 * SKIMS, 0.0)])
def test_who_skims_what_it_touched_slides_on(height: float, way: float) -> None:
    led_on = led((29, 0.0, 0.0), (30, 0.0, height), (40, 0.0, height), (50, 0.1, height))
    (slide,) = found(run(led_on, range(20, 30)))
    assert slide.way == pytest.approx(way, abs=1e-4) and slide.last == (50 if way else 20)


@pytest.mark.parametrize(("hop", "slid"), [(round(GAP / STEP) - 1, 0.1), (round(GAP / STEP) + 2, 0.0)])
def test_who_hops_and_skims_on_slides_on(hop: int, slid: float) -> None:
    low, end = 0.5 * SKIMS, 30 + hop
    hops = led((29, 0.0, 0.0), (30, 0.0, 0.1), (end - 1, 0.0, 0.1), (end, 0.0, low), (50, 0.1, low))
    (slide,) = found(run(hops, range(20, 30)))
    assert slide.way == pytest.approx(slid, abs=1e-4)


def test_a_contact_at_the_start_of_the_run_counts() -> None:
    led_on = run(led((0, 0.0, 0.0), (10, 0.1, 0.0)), range(1))
    (slide,) = slides(led_on, Grip("block", 0, 69), ALL)
    assert slide == Slide("block", "cup", pytest.approx(0.1), 0, 10)


def test_what_rose_and_comes_down_beside_it_touches_nothing() -> None:
    over = led((29, 0.0, 0.0), (35, 0.0, 0.1), (45, 0.3, 0.1), (50, 0.3, 0.0), (60, 0.9, 0.0))
    assert max(s.way for s in found(run(over, range(20, 30)))) < 0.001


def test_who_is_carried_along_does_not_slide() -> None:
    together = led((20, 0.0, 0.0), (40, 0.4, 0.0))
    assert max(s.way for s in found(run(together, ALL, cup=together))) == pytest.approx(0.0)
    turned = together.copy()
    turned[:, 3:] = np.array(Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)).quaternion)
    half = together.copy()
    half[:, 0] /= 2
    assert max(s.way for s in found(run(together, ALL, cup=half))) == pytest.approx(0.2)
    assert max(s.way for s in found(run(together, ALL, cup=turned))) == pytest.approx(0.0)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)])
@pytest.mark.parametrize("corner", [(0.0, 0.0, 0.0), (0.03, 0.03, -0.03), (-0.03, 0.03, 0.03)])
def test_what_turns_about_one_of_its_corners_does_not_slide(axis: tuple[float, ...], corner: tuple[float, float, float]) -> None:
    about, away = Pose(corner), Pose(tuple(-c for c in corner))
    turns = [about * Pose.from_rotvec((0.0, 0.0, 0.0), tuple(0.02 * k * a for a in axis)) * away for k in ALL]
    rocks = np.array([[*t.position, *t.quaternion] for t in turns])
    (slide,) = found(run(rocks, ALL))
    assert slide.way < 1e-6
    rocks[:, 1] += np.linspace(0.0, 0.99, COUNT)
    assert found(run(rocks, ALL))[0].way > 0.2


def test_the_hand_and_the_mounts_of_a_thing_are_nothing_that_it_slides_along() -> None:
    away = run(led((0, 0.0, 0.0), (COUNT - 1, 0.99, 0.0)), ALL)
    joint = Joint("slide", Pose(), 0.0, 1.0, parent="cup")
    things = tuple(replace(t, joint=joint) if t.name == "block" else t for t in away.world.things)
    assert found(replace(away, world=replace(away.world, things=things))) == []
    hand = tuple((Touch("effector/left", "block", 1.0, 0.0),) for _ in ALL)
    assert found(replace(away, touches=hand)) == []
