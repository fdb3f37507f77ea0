"""When fingers have closed on something: a thin wall is not nothing, and nothing is not a thin wall."""

from __future__ import annotations

import itertools

import pytest

from cramlite_plugins.robots.franka_hand import FRANKA_HAND
from cramlite_plugins.simulation.controller.gripper_order import GripperOrder

# a soft hand that closes on nothing, 20 times a second [mm]: friction stops it short of 0
EMPTY = (39.77, 34.99, 27.92, 19.57, 12.09, 7.66, 5.16, 3.77, 2.99, 2.55, 2.31, 2.17, 2.08, 1.99, 1.9, 1.82, 1.74, 1.67, 1.6)

# the same hand, sent from there to 34.9 mm at 0.2 m/s, but for what it rounds its orders to
OPENS = (5.72, 5.9, 8.33, 13.95, 19.88, 23.45, 25.46, 26.58, 27.2, 27.56, 27.75, 27.86, 27.93, 27.97)


def closed_on(thickness: float | None, closed: float | None) -> str:
    """The state in which fingers come to rest on something as thick [mm], of a hand that is this near to closed on nothing [m]."""
    order = GripperOrder(FRANKA_HAND)
    order.tolerance, order.patience, order.opening = 0.0055, 0.45, EMPTY[0] / 1000
    order.closed = order.tolerance if closed is None else closed
    order.move(0.0, 0.1, 20.0)
    for opening in itertools.chain(EMPTY, itertools.repeat(EMPTY[-1], 60)):
        order.follow(max(opening, thickness or 0.0) / 1000, 0.05)
        if order.state() != "moving":
            return order.state()
    return "moving"


@pytest.mark.parametrize("thickness", [2.1, 3.0, 6.0])
def test_a_thin_wall_stops_the_fingers(thickness: float) -> None:
    assert closed_on(thickness, 0.0019) == "stopped closing"


@pytest.mark.parametrize(("opening", "closed", "presses"), [(3.4, 0.0019, True), (1.8, 0.0019, False), (3.4, None, False)])
def test_fingers_press_on_a_thin_wall_and_not_on_each_other(opening: float, closed: float | None, presses: bool) -> None:
    order = GripperOrder(FRANKA_HAND)
    order.tolerance = 0.007
    order.closed = order.tolerance if closed is None else closed
    order.move(0.0, 0.1, 20.0)
    order.follow(opening / 1000, 0.05)
    assert (order.pressing == 20.0) is presses and order.pressing in (0.0, 20.0)


def test_nothing_does_not_stop_them() -> None:
    assert closed_on(None, 0.0019) == "there"


def test_what_is_thinner_than_a_hand_tells_is_taken_for_nothing() -> None:
    assert closed_on(3.0, None) == "there"
    assert closed_on(6.0, None) == "stopped closing"


def test_fingers_that_have_moved_need_not_hesitate_once_they_are_stopped() -> None:
    assert periods(6.0) == len(EMPTY[:6]) + 3  # as soon as they are sent no further, and have stood still for 0.08 s
    assert periods(None, first=True) == 10  # what holds them from the beginning may be that they hesitate: 0.45 s


def periods(thickness: float | None, first: bool = False) -> int:
    """After how many periods fingers that close on something as thick [mm], or are stuck from the first, count as stopped."""
    order = GripperOrder(FRANKA_HAND)
    order.tolerance, order.patience, order.closed, order.opening = 0.0055, 0.45, 0.0019, EMPTY[0] / 1000
    order.move(0.0, 0.1, 20.0)
    for count, opening in enumerate(itertools.chain(EMPTY, itertools.repeat(EMPTY[-1], 60)), 1):
        order.follow(EMPTY[0] / 1000 if first else max(opening, thickness or 0.0) / 1000, 0.05)
        if order.state() == "stopped closing":
            return count
    return 0


def test_fingers_that_open_creep_to_the_end_of_their_way() -> None:
    order = GripperOrder(FRANKA_HAND)
    order.tolerance, order.patience, order.opening = 0.007, 0.45, OPENS[0] / 1000
    order.move(0.03488, 0.2, 5.0)
    seen = []
    for opening in OPENS:
        order.follow(opening / 1000, 0.05)
        seen.append(order.state())
    assert seen[-1] == "there" and "stopped opening" not in seen
