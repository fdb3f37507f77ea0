"""Since when fingers have been open: what fell out of them a while ago is what the hand withdraws from, if it has stayed there."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite import Engine
from cramlite.model import Entity, Episode, Event, Pose
from cramlite.model.episode import Track
from cramlite.plugin import Timeline
from cramlite_plugins.validators.postconditions import OPENING, _opened

TAXONOMY = Engine().knowledge.taxonomy
LEFT = 2.0
"""When the thing left the fingers [s]."""


def timeline(way: float, *earlier: float) -> Timeline:
    """A hand that lets go of a thing, and moves by a way [m] in the second after that; at times before it let go of another one [s]."""
    times = np.arange(0.0, 12.0, 0.1)
    poses = np.tile([0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], (len(times), 1))
    poses[:, 0] = way * np.clip(times - LEFT, 0.0, 1.0)
    ends = {"g": LEFT, **{f"e{k}": end for k, end in enumerate(earlier)}}
    events = tuple(
        Event(name, "cram:GraspState", "state", 0.0, end, {"gripper": "hand", "object": "can"}) for name, end in ends.items()
    )
    entities = (Entity("hand", ("soma:Gripper",), pose=Pose()), Entity("can", ("cram:Product",), pose=Pose()))
    return Timeline(Episode("run", entities, events, {"hand": Track(times, poses)}, "hand"), TAXONOMY)


@pytest.mark.parametrize(
    ("way", "start", "since"),
    [
        (0.0, LEFT + 2.0, LEFT),
        (0.004, LEFT + 2.0, LEFT),
        (0.006, LEFT + 2.0, LEFT + 2.0 - OPENING),  # it went away from there
        (0.0, LEFT + 0.3, LEFT + 0.3 - OPENING),
        (0.0, LEFT + 4.9, LEFT),
        (0.0, LEFT + 5.1, LEFT + 5.1 - OPENING),  # too long ago
    ],
)
def test_as_long_as_the_hand_has_stayed(way: float, start: float, since: float) -> None:
    assert _opened(timeline(way), start) == pytest.approx(since)


def test_what_is_let_go_of_as_the_fingers_are_open_is_the_last() -> None:
    assert _opened(timeline(0.0, LEFT - 1.0), LEFT) == pytest.approx(LEFT - OPENING)
