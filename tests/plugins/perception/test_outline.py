"""Silhouettes in depth images with gaps."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite.model import Intrinsics
from cramlite_plugins.perception.pose.outline import SHADOW, Outline


@pytest.mark.parametrize(("width", "hides"), [(SHADOW, True), (SHADOW + 8, False)])
def test_a_narrow_gap_beside_something_nearer_hides_and_a_wide_one_does_not(width: int, hides: bool) -> None:
    depth, mask = np.full((20, 120), 1.0, np.float32), np.zeros((20, 120), bool)
    depth[:, :40], depth[:, 40 : 40 + width] = 0.7, np.nan
    mask[:, 40 + width :] = True
    seen = Outline(Intrinsics(600.0, 600.0, 60.0, 10.0, 120, 20), 0, 0, depth, mask)
    middle = np.array([10 * 120 + 40 + width // 2])
    assert seen.hidden(middle, np.array([1.0], np.float32)).tolist() == [hides]
