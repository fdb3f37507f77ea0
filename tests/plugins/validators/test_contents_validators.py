"""Poured and spilled: grains are counted where they are at the end, against what the task says."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_runs import COUNT, FLOOR, candidate, good, only, said, track
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Action, Object, Pose, World
from cramlite.plugin import Candidate
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.objects.vessels import bowl, jug
from cramlite_plugins.validators.contents import Poured, Spilled, validators

JUG, BOWL = jug("jug", Pose((0.5, 0.2, 0.051)), grains=20), bowl("bowl", Pose((0.5, -0.2, 0.026)))
ROLES = {"Source": Object("s", entity="jug"), "Destination": Object("d", entity="bowl")}


def ended(in_bowl: int, in_jug: int, task: str = "soma:Pouring", roles: dict[str, Object] | None = None, **parameters: float) -> Candidate:
    """A run at whose end some of 20 grains are in the bowl, some in the jug, and the rest beside both."""
    base = good().rollout
    assert base is not None
    places = [BOWL.pose.position] * in_bowl + [JUG.pose.position] * in_jug + [(0.0, 0.6, 0.0)] * (20 - in_bowl - in_jug)
    grains = np.tile(np.array([JUG.pose.position] * 20), (COUNT, 1, 1)).astype(float)
    grains[-1] = places
    world = World((FLOOR, JUG, BOWL), base.world.robots)
    poses = {t.name: track((0, t.pose.position)) for t in world.things} | {"effector": base.poses["effector"]}
    made = candidate(replace(base, world=world, poses=poses, grains={"jug": grains}))
    own = ROLES if roles is None else roles
    return replace(made, actions=(Action("1.Other", "soma:Grasping"), Action("2.Pouring", task, own, parameters=parameters)))


def test_all_of_them_are_asked() -> None:
    assert [v.name for v in validators()] == ["poured", "spilled"]


@pytest.mark.parametrize(("arrived", "passes"), [(20, True), (18, True), (17, False), (0, False)])
def test_nine_tenths_have_to_arrive(arrived: int, passes: bool) -> None:
    found = only(Poured(), ended(arrived, 20 - arrived))
    assert (found.passed, found.value, found.limit, found.origin) == (passes, arrived / 20, 0.9, "2.Pouring")
    assert found.reason == f"{arrived} of 20 grains of 'jug' are in 'bowl', 18 are wanted"


@pytest.mark.parametrize(("arrived", "passes"), [(10, True), (9, False)])
def test_or_the_share_that_the_task_says(arrived: int, passes: bool) -> None:
    found = only(Poured(), ended(arrived, 0, share=0.5))
    assert found.passed is passes and found.reason.endswith("10 are wanted")
    assert only(Poured(), ended(arrived, 0, share=0.49)).reason.endswith("10 are wanted")


def test_only_pouring_is_judged_by_it() -> None:
    assert list(Poured().check(ended(0, 0, task="soma:Grasping"))) == []
    assert list(Poured().check(ended(0, 0, roles={"Destination": ROLES["Destination"]}))) == []
    empty = ended(0, 0)
    assert empty.rollout is not None
    assert list(Poured().check(replace(empty, rollout=replace(empty.rollout, grains={})))) == []


def test_a_destination_that_holds_nothing_has_got_nothing() -> None:
    floor = {"Source": ROLES["Source"], "Destination": Object("d", entity="floor")}
    with pytest.raises(KeyError):  # no plan pours onto a floor: a validator that breaks is an objection
        list(Poured().check(ended(20, 0, roles=floor)))


@pytest.mark.parametrize(("lost", "passes"), [(0, True), (2, True), (3, False), (20, False)])
def test_a_tenth_may_be_lost(lost: int, passes: bool) -> None:
    found = only(Spilled(), ended(20 - lost, 0))
    assert (found.passed, found.value, found.limit) == (passes, lost / 20, 0.1)
    assert found.reason == f"{lost} of 20 grains of 'jug' are beside all vessels, at most 2 may be"


@pytest.mark.parametrize(("lost", "passes"), [(5, True), (6, False)])
def test_or_what_the_task_says(lost: int, passes: bool) -> None:
    assert only(Spilled(), ended(10, 10 - lost, spilled=0.25)).passed is passes
    assert only(Spilled(), ended(18, 0, spilled=0.05)).passed is False


@given(in_bowl=st.integers(0, 20), in_jug=st.integers(0, 20))
@examples(40)
def test_what_is_in_any_vessel_is_not_lost(in_bowl: int, in_jug: int) -> None:
    in_jug = min(in_jug, 20 - in_bowl)
    assert only(Spilled(), ended(in_bowl, in_jug)).value == pytest.approx((20 - in_bowl - in_jug) / 20)


def test_what_arrived_is_counted_where_the_bowl_then_is() -> None:
    moved = ended(20, 0)
    assert moved.rollout is not None
    poses = {**moved.rollout.poses, "bowl": moved.rollout.poses["bowl"] + (0.3, 0, 0, 0, 0, 0, 0)}
    away = replace(moved, rollout=replace(moved.rollout, poses=poses))
    assert said(Poured(), away) and said(Spilled(), away)


@pytest.mark.parametrize(("off", "passes"), [(0, True), (2, True), (3, False)])
def test_what_lay_on_a_plate_may_lie_there_still(off: int, passes: bool) -> None:
    plate, made = table("plate", Pose((0.5, 0.5, 0.1)), (0.2, 0.2, 0.02), grains=20), ended(0, 0)
    assert made.rollout is not None
    rollout, grains = made.rollout, np.tile([(0.55, 0.5, 0.105)] * (20 - off) + [(0.5, 0.5, 0.0)] * off, (COUNT, 1, 1))
    world, poses = replace(rollout.world, things=(FLOOR, plate)), {**rollout.poses, "plate": track((0, plate.pose.position))}
    found = only(Spilled(), replace(made, rollout=replace(rollout, world=world, poses=poses, grains={"plate": grains})))
    assert (found.passed, found.value) == (passes, off / 20)
