"""Since when fingers have been open: what fell out of them a while ago is what the hand withdraws from, if it has stayed there."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite import Engine
from cramlite.model import Entity, Episode, Event, Pose
from cramlite.model.episode import Track
from cramlite.plugin import Timeline
from cramlite_plugins.validators.postconditions import LONGEST, OPENING, _opened

TAXONOMY = Engine().knowledge.taxonomy
LEFT = 2.0
"""When the thing left the fingers [s]."""


def timeline(way: float) -> Timeline:
    """A hand that lets go of a thing, and moves by a way [m] in the second after that."""
    times = np.arange(0.0, 12.0, 0.1)
    poses = np.tile([0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], (len(times), 1))
    poses[:, 0] = way * np.clip(times - LEFT, 0.0, 1.0)
    events = (Event("g", "cram:GraspState", "state", 0.0, LEFT, {"gripper": "hand", "object": "can"}),)
    entities = (Entity("hand", ("soma:Gripper",), pose=Pose()), Entity("can", ("cram:Product",), pose=Pose()))
    return Timeline(Episode("run", entities, events, {"hand": Track(times, poses)}, "hand"), TAXONOMY)


@pytest.mark.parametrize(
    ("way", "start", "since"),
    [
        (0.0, LEFT + 2.0, LEFT),
        (0.004, LEFT + 2.0, LEFT),
        (0.006, LEFT + 2.0, LEFT + 2.0 - OPENING),  # it went away from there
        (0.0, LEFT + 0.3, LEFT + 0.3 - OPENING),
        (0.0, LEFT + LONGEST + 1.0, LEFT + LONGEST + 1.0 - OPENING),  # too long ago
    ],
)
def test_as_long_as_the_hand_has_stayed(way: float, start: float, since: float) -> None:
    assert _opened(timeline(way), start) == pytest.approx(since)
