"""Points of many frames at once, as pegs in holes are looked for."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite.model import Pose
from cramlite_plugins.episodes.detection.threaded import _into, _out_of


def test_points_in_frames_are_those_of_their_poses() -> None:
    rng = np.random.default_rng(0)
    frames, points, point = rng.normal(size=(20, 7)), rng.normal(size=(20, 3)), rng.normal(size=3)
    poses = [Pose(tuple(row[:3]), tuple(row[3:])) for row in frames]
    there = [pose.inverse().apply(p) for pose, p in zip(poses, points, strict=True)]
    assert _into(frames, points) == pytest.approx(np.array(there))
    assert _out_of(frames, point) == pytest.approx(np.array([pose.apply(point) for pose in poses]))
