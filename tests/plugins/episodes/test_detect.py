"""States from contacts: each with a sibling in which it must not be found."""

from __future__ import annotations

import numpy as np
import pytest
from episode_builders import rollout, shop
from msgspec.structs import replace

from cramlite.model import Episode, Rollout, Touch
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.episodes.detection.signals import GAP, SHORT


def states(episode: Episode, type_: str) -> list[tuple[float, float, tuple[str, ...]]]:
    return [(e.start, e.end, tuple(e.roles.values())) for e in episode.of("state", [type_])]


def flicker(touches: tuple[tuple[Touch, ...], ...], gone: slice) -> tuple[tuple[Touch, ...], ...]:
    samples = list(touches)
    samples[gone] = [()] * len(samples[gone])
    return tuple(samples)


def test_taking_off_gives_contact_support_and_grasp() -> None:
    found = detect(rollout(), "demo")
    assert states(found, "soma:ContactState") == [
        (0.0, 1.5, ("hanger/peg", "product/hole")),
        (1.0, pytest.approx(2.99, abs=0.02), ("hand", "product")),
        (pytest.approx(2.99, abs=0.02), 4.0, ("basket", "product")),
    ]
    assert [(s[2], s[1] < 1.6) for s in states(found, "soma:SupportState")] == [
        (("hanger/peg", "product"), True),
        (("basket", "product"), False),
    ]
    assert states(found, "cram:GraspState") == [(1.0, pytest.approx(2.99, abs=0.02), ("hand", "product"))]


def test_squeezing_without_friction_is_no_grasp() -> None:
    found = detect(rollout(slip=1.0, carried=0.0), "demo")
    assert states(found, "cram:GraspState") == []
    assert (1.0, pytest.approx(2.99, abs=0.02), ("hand", "product")) in states(found, "soma:ContactState")


def test_one_pad_is_no_grasp() -> None:
    recorded = rollout()
    one = tuple(tuple(t for t in ts if "effector/left" not in (t.a, t.b)) for ts in recorded.touches)
    assert states(detect(replace(recorded, touches=one), "demo"), "cram:GraspState") == []


def test_a_grasp_ends_when_the_object_slides_out() -> None:
    recorded = rollout()
    product = recorded.poses["product"].copy()
    product[200:, 2] -= np.linspace(0, 0.3, len(product) - 200)
    (grasp,) = states(
        detect(replace(recorded, poses={**recorded.poses, "product": product}), "demo"), "cram:GraspState"
    )
    assert grasp[1] == pytest.approx(2.0, abs=GAP)


def test_the_hand_never_supports() -> None:
    assert all(s[2][0] != "hand" for s in states(detect(rollout(), "demo"), "soma:SupportState"))


@pytest.mark.parametrize(("gone", "count"), [(0.8 * GAP, 1), (2.5 * GAP, 2)])
def test_short_gaps_are_flicker_long_ones_are_not(gone: float, count: int) -> None:
    recorded = rollout()
    touches = flicker(recorded.touches, slice(200, 200 + round(gone * 100)))
    assert len(states(detect(replace(recorded, touches=touches), "demo"), "cram:GraspState")) == count


@pytest.mark.parametrize(("seconds", "count"), [(SHORT / 2, 0), (2 * SHORT, 1)])
def test_impacts_are_no_states(seconds: float, count: int) -> None:
    recorded = rollout()
    samples = list(recorded.touches)
    for k in range(220, 220 + round(seconds * 100)):
        samples[k] = (*samples[k], Touch("hanger", "product", 3.0, 0.0))
    found = states(detect(replace(recorded, touches=tuple(samples)), "demo"), "soma:ContactState")
    assert sum(s[2] == ("hanger", "product") for s in found) == count


def test_the_order_within_a_touch_does_not_matter() -> None:
    recorded = rollout()
    turned = tuple(tuple(Touch(t.b, t.a, t.force, -t.lift) for t in ts) for ts in recorded.touches)
    assert detect(replace(recorded, touches=turned), "demo").events == detect(recorded, "demo").events


def test_entities_carry_types_parts_and_constraints() -> None:
    found = detect(rollout(), "demo")
    peg, hand = found.entity("hanger/peg"), found.entity("hand")
    assert (peg.types, peg.part_of, peg.properties["constrained_dof"]) == (("vrps:Peg",), "hanger", 4.0)
    assert found.entity("basket").properties["constrained_dof"] == 1.0
    assert "constrained_dof" not in found.entity("hanger").properties
    assert hand.types[0] == "soma:Hand"
    assert found.entity("hand/left").part_of == "hand"
    assert found.entity("product").size == pytest.approx((0.04, 0.025, 0.15))
    assert found.pose_at("hanger/peg", 0.0).distance(shop().things[0].pose * peg.pose) == pytest.approx(
        (0, 0), abs=1e-9
    )  # type: ignore[union-attr, operator]


def test_a_robot_is_a_gripper() -> None:
    recorded = replace(rollout(), effector="arm", joints=np.zeros((400, 6)))
    found = detect(recorded, "run")
    assert found.effector == "arm"
    assert found.entity("arm").types[0] == "soma:Gripper"
    assert states(found, "cram:GraspState")[0][2] == ("arm", "product")
    assert found.extras["joints"].shape == (400, 6)


def test_tracks_hold_what_was_recorded() -> None:
    recorded: Rollout = rollout()
    found = detect(recorded, "demo")
    for k in (0, 170, 250, 399):
        row = found.tracks["product"].at(recorded.times[k])
        assert (*row.position, *row.quaternion) == pytest.approx(recorded.poses["product"][k])
    assert len(found.tracks["hanger"].times) == 2


@pytest.mark.parametrize(("seconds", "stands"), [(0.3, False), (0.8, True)])
def test_what_stood_stands_until_it_moves_but_a_bump_is_over_when_it_is_over(seconds: float, stands: bool) -> None:
    """The weight is taken off after some time, and the product does not move before 1.5 s."""
    whole = rollout()
    gone = slice(int(np.searchsorted(whole.times, seconds)), int(np.searchsorted(whole.times, 1.0)))
    found = detect(replace(whole, touches=flicker(whole.touches, gone)), "demo")
    begin, end, roles = states(found, "soma:SupportState")[0]
    assert roles == ("hanger/peg", "product") and begin == 0.0
    assert end > 1.4 if stands else end < seconds + GAP
