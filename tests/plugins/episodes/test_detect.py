"""States from contacts: each with a sibling in which it must not be found."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.episode_builders import rollout, shop
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


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("force", [0.0, 0.1])
def test_a_pad_that_hardly_presses_is_no_second_pad(side: str, force: float) -> None:
    """All the rest speaks for a grasp: the thing goes along, and its weight hangs on the other pad."""
    found = detect(_with_pads(rollout(), **{side: force}), "demo")
    assert states(found, "cram:GraspState") == []


def _with_pads(recorded: Rollout, *, lift: float | None = None, **forces: float) -> Rollout:
    """The recording with other forces of the left or right pad, or another lift of both [N]."""

    def other(touch: Touch) -> Touch:
        pads = [v.removeprefix("effector/") for v in (touch.a, touch.b) if v.startswith("effector/")]
        if not pads:
            return touch
        raised = touch.lift if lift is None else lift * (1 if touch.a.startswith("effector/") else -1)
        return Touch(touch.a, touch.b, forces.get(pads[0], touch.force), raised)

    return replace(recorded, touches=tuple(tuple(map(other, ts)) for ts in recorded.touches))


@pytest.mark.parametrize(("mass", "of", "pads"), [(0.001, 0.0, 0.0), (200.0, 0.0, 0.0), (200.0, 9.0, 9.0), (0.2, 0.0, 0.9)])
def test_what_a_thing_weighs_and_how_it_rubs_is_not_known_to_who_looks_for_grasps(mass: float, of: float, pads: float) -> None:
    for recorded in (rollout(), rollout(slip=1.0, carried=0.0), _standing(10.0)):
        world = recorded.world
        things = tuple(t if t.mass is None else replace(t, mass=mass, friction=of) for t in world.things)
        other = replace(recorded, world=replace(world, things=things, physics=replace(world.physics, pad_friction=pads)))
        assert states(detect(other, "d"), "cram:GraspState") == states(detect(recorded, "d"), "cram:GraspState")


def _standing(force: float, lift: float = 0.0, shift: float = 0.0) -> Rollout:
    """The thing stands all the time; two pads press it from 1 s to 3 s, and it moves by ``shift`` [m] between them, too slowly
    to be seen to slip."""
    recorded = rollout()
    still = {k: np.repeat(v[:1], len(v), axis=0) for k, v in recorded.poses.items()}
    still["product"][:, 2] -= shift * np.clip((recorded.times - 1) / 2, 0, 1)
    stands = Touch("basket", "product", 1.96, 1.96)
    touches = tuple((stands, *(t for t in ts if "effector" in t.a + t.b)) for ts in recorded.touches)
    return _with_pads(replace(recorded, poses=still, touches=touches), lift=lift, left=force, right=force)


@pytest.mark.parametrize(
    ("force", "lift", "shift", "held"),
    [
        (6.0, 0.0, 0.0, True),  # pressed firmly, and let go of again
        (4.0, 0.0, 0.0, False),
        (4.0, 1.2, 0.0, True),  # the pads take most of what pushes it up: 2.4 N beside 1.96 N
        (4.0, 0.8, 0.0, False),  # 1.6 N beside 1.96 N
        (6.0, 0.0, 0.018, True),
        (6.0, 0.0, 0.025, False),  # it creeps out
    ],
)
def test_who_lets_go_of_a_thing_that_stands_had_grasped_it_if_the_pads_meant_it(
    force: float, lift: float, shift: float, held: bool
) -> None:
    assert bool(states(detect(_standing(force, lift, shift), "demo"), "cram:GraspState")) == held


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


@pytest.mark.parametrize(("carried", "stands"), [(1.0, True), (0.2, False)])
def test_what_weighs_less_than_counts_as_a_touch_stands_too(carried: float, stands: bool) -> None:
    """A product of 2 g in the basket; or it leans on the basket, which carries a fifth of it."""
    whole, weight = rollout(), 0.002 * 9.81
    light = replace(whole.world, things=tuple(replace(t, mass=0.002) if t.mass else t for t in whole.world.things))
    leaning = Touch("product", "basket", carried * weight, -carried * weight)
    resting = tuple((leaning,) if time >= 3.0 else touches for time, touches in zip(whole.times, whole.touches, strict=True))
    found = detect(replace(whole, world=light, touches=resting), "demo")
    assert (("basket", "product") in [roles for *_, roles in states(found, "soma:SupportState")]) == stands
    assert (("basket", "product") in [roles for *_, roles in states(found, "soma:ContactState")]) == stands
