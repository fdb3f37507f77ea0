"""Poses over time: frames that follow their parents, and files that are damaged."""

from __future__ import annotations

import json
from pathlib import Path

import bson
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.plugin import UserError
from cramlite_plugins.episodes.formats.neem import read_neem


def tf(child: str, parent: str, time: float, pose: list[float]) -> bytes:
    x, y, z, qw, qx, qy, qz = pose
    transform = {"translation": {"x": x, "y": y, "z": z}, "rotation": {"x": qx, "y": qy, "z": qz, "w": qw}}
    return bytes(
        bson.encode({"header": {"stamp": time, "frame_id": parent}, "child_frame_id": child, "transform": transform})
    )


def dump(folder: Path, content: bytes) -> Path:
    (folder / "tf" / "roslog").mkdir(parents=True)
    (folder / "tf" / "roslog" / "tf.bson").write_bytes(content)
    return folder


def test_frames_follow_their_parents(tmp_path: Path) -> None:
    quarter = [1, 0, 0, 0.5**0.5, 0, 0, 0.5**0.5]
    rows = [
        tf("cup", "drawer", 1, [1, 0, 0, 1, 0, 0, 0]),
        tf("drawer", "map", 1, [0, 0, 0, 1, 0, 0, 0]),
        tf("drawer", "map", 2, quarter),
    ]
    found = read_neem(dump(tmp_path, b"".join(rows)))
    assert found is not None
    assert found.tracks["cup"].at(1.5).position == pytest.approx((1, 0, 0))
    assert found.tracks["cup"].at(2.0).position == pytest.approx((1, 1, 0))


def test_frames_in_a_circle_are_reported(tmp_path: Path) -> None:
    rows = [tf("a", "b", 1, [1, 0, 0, 1, 0, 0, 0]), tf("b", "a", 1, [1, 0, 0, 1, 0, 0, 0])]
    found = read_neem(dump(tmp_path, b"".join(rows)))
    assert found is not None
    assert any("contain each other" in r.why for r in found.repairs)


def test_bad_poses_are_repaired_and_reported(tmp_path: Path) -> None:
    rows = [tf("a", "map", 3, [1, 0, 0, 2, 0, 0, 0]), tf("a", "map", 1, [1, 2, 3, 1, 0, 0, 0]),
            tf("a", "map", 4, [float("nan"), 0, 0, 1, 0, 0, 0]), tf("a", "map", 5, [0, 0, 0, 0, 0, 0, 0]),
            tf("b", "map", 1, [0, 0, 0, 1, 0, 0, 0])]  # fmt: skip
    found = read_neem(dump(tmp_path, b"".join(rows)))
    assert found is not None
    assert found.tracks["a"].times.tolist() == [1.0, 3.0]
    assert "b" not in found.tracks
    assert np.linalg.norm(found.tracks["a"].poses[:, 3:], axis=1) == pytest.approx(1.0)
    assert [r.what.split()[0] for r in found.repairs] == ["dropped", "normalised", "sorted", "dropped"]


WHOLE = tf("a", "map", 1, [0, 0, 1, 1, 0, 0, 0])


@pytest.mark.parametrize(
    "content",
    [
        WHOLE[:-7],
        WHOLE + WHOLE[:2],
        b"\x00" * 40,
        b"this is no bson at all",
        bson.encode({"s": 1}),
        WHOLE + b"\xff\xff\xff\x7f",
    ],
)
def test_broken_bson_names_file_and_place(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(UserError, match=r"tf\.bson: document \d"):
        read_neem(dump(tmp_path, content))


@examples(150)
@given(st.data())
def test_damaged_bson_never_crashes(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    content = bytearray(WHOLE * 3)
    for _ in range(data.draw(st.integers(1, 5))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    try:
        found = read_neem(dump(tmp_path_factory.mktemp("fuzz"), bytes(content)))
    except UserError:
        return
    assert found is None or all(np.isfinite(t.poses).all() for t in found.tracks.values())


FRAMES = (
    {"timestamp": 0.5, "individuals": [{"id": "cup", "pose": [100, 200, 300, 0, 0, 0, 1]}],
     "skel_individuals": [{"id": "hand", "pose": [1, 2, 3, 0, 0, 0, 1], "bones": [
         {"idx": 3, "pose": [1, 2, 4, 0, 0, 0, 1]}, {"idx": 5, "pose": [0, 0, 0, 0, 0, 0, 1]}]}]},
    {"timestamp": 1.0, "individuals": [
        {"id": "cup", "loc": {"x": 0, "y": 0, "z": 1}, "quat": {"x": 1, "y": 0, "z": 0, "w": 1}}]},
)  # fmt: skip


@pytest.mark.parametrize("form", ["array", "lines", "bson", "pretty"])
def test_world_state_of_either_writer(tmp_path: Path, form: str) -> None:
    path = tmp_path / ("w.bson" if form == "bson" else "w.json")
    texts = {
        "array": json.dumps(FRAMES),
        "lines": "\n".join(map(json.dumps, FRAMES)),
        "pretty": json.dumps(FRAMES, indent=1),
    }
    path.write_bytes(b"".join(map(bson.encode, FRAMES)) if form == "bson" else texts[form].encode())
    found = read_neem(path)
    assert found is not None
    assert found.tracks["cup"].at(0.5).position == pytest.approx((2, 1, 3))
    assert found.tracks["cup"].at(1.0).quaternion == pytest.approx((0.5**0.5, -(0.5**0.5), 0, 0))
    assert found.entity("hand/left").part_of == "hand"
    assert found.effector == "hand"


@pytest.mark.parametrize(
    "content", ["{", "[1]", '{"timestamp": 1, "individuals": [{"id": "a", "pose": [1]}]}', '{"individuals": []}']
)
def test_bad_world_state_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "w.json").write_text(content)
    with pytest.raises(UserError, match=r"w\.json"):
        read_neem(tmp_path / "w.json")
