"""Pinches across a slanted rim: where they are, how the thing hangs from them, and which things have none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.locations.laying_down import LEFT, OVER, dropped, released, rolled
from cramlite_plugins.locations.pinching.rim_pinches import LEANS, RimPinch, rim_pinches
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.shapes.bounds import corners
from cramlite_plugins.shapes.nesting import room_under

SLOPE, AT = math.radians(20.0), 0.0535
LIES = Pose.from_rotvec((0.4, 0.1, 0.2), (0.0, 0.0, 0.3))


def slab(turn: float, slope: float = SLOPE, thick: float = 0.0025) -> Geom:
    """One of the slabs of a rim that rises outwards, at this angle about the middle [rad]."""
    around = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, turn))
    return Geom("box", (0.02, 0.027, thick), around * Pose((AT, 0.0, 0.0092)) * Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, -slope, 0.0)))


def plate(slope: float = SLOPE, thick: float = 0.0025) -> Thing:
    rim = tuple(slab(k * math.tau / 8, slope, thick) for k in range(8))
    return Thing("plate", "soma:Plate", Pose(), (Geom("cylinder", (0.036, 0.0025), Pose((0.0, 0.0, 0.0055))), *rim))


def pinches(thing: Thing | None = None, pose: Pose = LIES, friction: float = 0.9) -> list[RimPinch]:
    return rim_pinches(thing or plate(), pose, FR3.gripper, friction)


def test_each_slab_is_pinched_either_way_round_by_a_hand_that_leans_outwards() -> None:
    found = pinches()
    assert len(found) == 8 * 2 * len(LEANS)
    for pinch in found:
        approach, out = pinch.at.rotate((0.0, 0.0, 1.0)), np.subtract(pinch.at.position, LIES.position)
        assert approach @ (0.0, 0.0, -1.0) > math.cos(LEANS[0]) - 1e-9
        assert approach[:2] @ out[:2] < 0  # it points inwards


def test_the_slope_hangs_flat_between_the_pads() -> None:
    for pinch in pinches():
        held = [pinch.swing.end * g.pose for g in plate().geoms[1:]]
        normals = np.array([h.rotate((0.0, 0.0, 1.0)) for h in held])
        between = int(np.argmax(np.abs(normals[:, 1])))
        assert abs(normals[between, 1]) == pytest.approx(1.0, abs=1e-6)
        assert held[between].position[1] == pytest.approx(0.0, abs=1e-6)
        assert pinch.swing.end.position[2] > 0.04  # the rest of it is beyond the tips


@pytest.mark.parametrize(
    ("thing", "pose", "friction"),
    [
        (plate(), LIES, 0.7),
        (plate(slope=math.radians(3.0)), LIES, 0.9),
        (plate(slope=math.radians(60.0)), LIES, 0.9),
        (plate(thick=0.008), LIES, 0.9),
        (plate(), LIES * Pose.from_rotvec((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0)), 0.9),
        (Thing("can", "soma:Can", Pose(), (Geom("cylinder", (0.03, 0.05), Pose()),)), LIES, 0.9),
    ],
    ids=["smooth", "flat", "steep", "thick", "upside down", "no rim"],
)
def test_what_has_none(thing: Thing, pose: Pose, friction: float) -> None:
    assert pinches(thing, pose, friction) == []


def test_it_is_laid_down_by_a_hand_that_keeps_its_attitude_and_a_thing_that_rolls_on_the_floor() -> None:
    pinch = pinches()[0]
    lies = pinch.at
    shares, hands = rolled(plate(), lies, pinch.swing)
    assert shares[0] == 1.0 and shares[-1] == 0.0 and hands[-1] == lies
    floor = corners(plate(), lies * pinch.swing.start)[:, 2].min()
    for share, hand in zip(shares, hands, strict=True):
        assert hand.distance(lies)[1] == pytest.approx(0.0, abs=1e-6)
        assert corners(plate(), hand * pinch.swing.at(share))[:, 2].min() == pytest.approx(floor, abs=1e-6)
    drop = dropped(plate(), lies, pinch.swing)
    assert hands[0].position[2] - lies.position[2] == pytest.approx(drop, abs=1e-6)
    assert drop > 0.08 and OVER < 0.002
    assert np.linalg.norm(np.subtract(hands[0].position, lies.position)[:2]) > 0.03  # and inwards, about the far side


def test_the_hand_lets_go_before_it_is_as_low_as_where_it_took_hold() -> None:
    pinch, low = pinches()[0], pinches()[0].at
    share, hand = released(*rolled(plate(), low, pinch.swing))
    assert hand.position[2] - low.position[2] == pytest.approx(LEFT) and 0.0 < share < 0.15
    shares, hands = rolled(plate(), hand, pinch.swing.part(share, 1.0))
    assert hands[-1] == hand and shares[-1] == 0.0
    floor = corners(plate(), low * pinch.swing.start)[:, 2].min()
    assert corners(plate(), hand * pinch.swing.at(share))[:, 2].min() == pytest.approx(floor, abs=0.0005)


def test_what_is_laid_onto_a_plate_rolls_over_the_rim_of_that() -> None:
    pinch, below = pinches()[0], (plate(), LIES)
    lies = Pose(tuple(np.add(pinch.at.position, (0.0, 0.0, 0.012)).tolist()), pinch.at.quaternion)

    def least(hands: list[Pose], shares: list[float]) -> float:
        return min(room_under(plate(), hand * pinch.swing.at(share), *below) for share, hand in zip(shares, hands, strict=True))

    shares, hands = rolled(plate(), lies, pinch.swing, below)
    flat = rolled(plate(), lies, pinch.swing)[1]
    assert least(hands, shares) > -0.0005
    assert least(flat, shares) < -0.003  # on its final level it would go through that
    assert hands[-1] == flat[-1] == lies
