"""RobCoG's event data and its poses, which are Unreal's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robcog_samples import TIMELINE, Lines, event_data

from cramlite.model import Pose
from cramlite_plugins.episodes.formats.neem import read_neem
from cramlite_plugins.episodes.formats.robcog import to_unreal, unreal_pose


@given(st.lists(st.floats(-1, 1), min_size=7, max_size=7).filter(lambda v: np.linalg.norm(v[3:]) > 0.1))
def test_unreal_poses_and_back(v: list[float]) -> None:
    pose = Pose((v[0], v[1], v[2]), (v[3], v[4], v[5], v[6]))
    assert unreal_pose(to_unreal(pose)).distance(pose) == pytest.approx((0, 0), abs=1e-6)


KNOWROB = {False: "knowrob:", True: "http://knowrob.org/kb/knowrob_u.owl#"}


@pytest.mark.parametrize("old", [False, True])
def test_both_generations_of_robcog(tmp_path: Path, old: bool) -> None:
    (tmp_path / "X_ED.owl").write_text(event_data(*TIMELINE, old=old))
    found = read_neem(tmp_path)
    assert found is not None
    assert [(e.type, e.kind, e.start, e.end) for e in found.events] == [
        ("soma:SupportState", "state", 0.5, 4.0),
        ("soma:Reaching", "action", 1.0, 2.0),
        ("soma:ContactState", "state", 1.25, 2.5),
        ("cram:GraspState", "state", 3.5, 5.0),
        (f"{KNOWROB[old]}ContainerManipulation", "action", 6.0, 7.0),
    ]
    assert found.events[0].roles == {"supporter": "table", "supportee": "cup"}
    assert set(found.events[2].roles.values()) == {"hand", "cup"}
    assert found.effector == "hand"
    assert {r.what for r in found.repairs} == {f"added entity '{n}'" for n in ("cup", "hand", "table")}


def test_impossible_events_are_left_out_and_reported(tmp_path: Path) -> None:
    lines: Lines = (("a", "TouchingSituation", 2, 1, {"inContact": "x", "inContact_": "y"}),
             ("b", "TouchingSituation", "soon", 1, {"inContact": "x"}),
             ("c", "TouchingSituation", "nan", 1, {"inContact": "x"}),
             ("d", "TouchingSituation", 1, 2, {"inContact": "x", "inContact_": "y"}),
             ("d", "TouchingSituation", 3, 4, {}))  # fmt: skip
    (tmp_path / "X_ED.owl").write_text(event_data(*lines))
    found = read_neem(tmp_path / "X_ED.owl")
    assert found is not None
    assert [(e.id, e.start, e.end) for e in found.events] == [("d_1", 1.0, 2.0), ("d_2", 3.0, 4.0)]
    assert {r.what for r in found.repairs} >= {f"left out event '{k}'" for k in "abc"} | {"split event 'd' in 2"}
