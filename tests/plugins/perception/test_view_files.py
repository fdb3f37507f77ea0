"""Recordings: what is written is read, and each mistake is named."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from cramlite.model import Intrinsics
from cramlite.plugin import UserError
from cramlite_plugins.perception.recordings.cloud_files import read_cloud, unpacked
from cramlite_plugins.perception.recordings.view_files import read_view

CAMERA = {"fx": 60.0, "fy": 60.0, "cx": 31.5, "cy": 23.5, "width": 64, "height": 48}
INTRINSICS = Intrinsics(60.0, 60.0, 31.5, 23.5, 64, 48)


def _depth() -> np.ndarray[Any, Any]:
    depth = np.full((48, 64), 800, np.uint16)
    depth[:, :20] = 600
    depth[0] = 0
    return depth


def _folder(path: Path, depth: Any = None, camera: Any = None, rgb: Any = None) -> Path:
    path.mkdir(exist_ok=True)
    Image.fromarray(_depth() if depth is None else depth).save(path / "depth.png")
    Image.fromarray(np.full((48, 64, 3), 7, np.uint8) if rgb is None else rgb).save(path / "color.png")
    (path / "intrinsics.json").write_text(json.dumps(CAMERA if camera is None else camera))
    return path


def test_a_folder_of_images(tmp_path: Path) -> None:
    view = read_view(_folder(tmp_path / "shot"))
    assert view.depth[10, 5] == pytest.approx(0.6) and view.depth[10, 30] == pytest.approx(0.8)
    assert not view.valid[0].any() and (view.rgb == 7).all() and view.intrinsics == INTRINSICS


def test_the_words_of_librealsense_and_a_known_camera(tmp_path: Path) -> None:
    camera = {**CAMERA, "ppx": 31.5, "ppy": 23.5, "model": "Brown Conrady", "depth_scale": 0.0001}
    del camera["cx"], camera["cy"]
    view = read_view(_folder(tmp_path / "shot", _depth() * 10, {**camera, "camera": {"position": [1, 2, 3]}}))
    assert view.depth[10, 5] == pytest.approx(0.6) and view.camera.position == (1, 2, 3)


def test_arrays_of_metres_and_of_millimetres(tmp_path: Path) -> None:
    for name, depth in (("metres", _depth() / 1000), ("millimetres", _depth())):
        np.savez(tmp_path / f"{name}.npz", depth=depth, intrinsics=json.dumps(CAMERA))
        assert read_view(tmp_path / f"{name}.npz").depth[10, 30] == pytest.approx(0.8)


def _pcd(points: Any, form: str) -> bytes:
    count = len(points)
    bits = np.full(count, (10 << 16) | (20 << 8) | 30, np.uint32)
    head = (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {form}\n"
    )
    if form == "binary":
        rows = np.zeros(count, [("p", "<f4", 3), ("c", "<u4")])
        rows["p"], rows["c"] = points, bits
        return head.encode() + rows.tobytes()
    if form == "binary_compressed":
        return head.encode() + _packed(np.asarray(points, "<f4").T.tobytes() + bits.tobytes())
    return (head + "".join(f"{x} {y} {z} {b}\n" for (x, y, z), b in zip(points, bits, strict=True))).encode()


def _packed(data: bytes) -> bytes:
    """PCD's compressed form, its LZF of literals only: runs of at most 32 bytes as they are."""
    runs = b"".join(bytes([len(data[k : k + 32]) - 1]) + data[k : k + 32] for k in range(0, len(data), 32))
    return np.array([len(runs), len(data)], "<u4").tobytes() + runs


def test_compressed_data_may_reach_back_and_into_themselves() -> None:
    literal, back, long = bytes([2]) + b"abc", bytes([(4 << 5) | 0, 2]), bytes([7 << 5, 3, 0])
    assert unpacked(literal + back, 9) == b"abcabcabc"
    assert unpacked(bytes([0]) + b"x" + long, 13) == b"x" * 13
    assert unpacked(literal + bytes([(1 << 5), 3]), 6) is None, "before the beginning"
    assert unpacked(literal + back, 8) is None and unpacked(literal + back[:1], 9) is None


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_an_organised_cloud_tells_its_intrinsics(tmp_path: Path, form: str) -> None:
    depth = 0.7 + 0.001 * np.arange(64 * 48).reshape(48, 64)
    points = (INTRINSICS.rays * depth[..., None]).reshape(-1, 3)
    points[3] = np.nan
    organised = _pcd(points, form).replace(b"WIDTH 3072\nHEIGHT 1", b"WIDTH 64\nHEIGHT 48")
    (tmp_path / "shot.pcd").write_bytes(organised)
    view = read_view(tmp_path / "shot.pcd")
    k = view.intrinsics
    assert (k.fx, k.fy, k.cx, k.cy) == pytest.approx((INTRINSICS.fx, INTRINSICS.fy, INTRINSICS.cx, INTRINSICS.cy), abs=0.01)
    assert np.isnan(view.depth[0, 3]) and np.allclose(view.depth[1:], depth[1:]) and (view.rgb[10, 10] == (10, 20, 30)).all()
    turned = _pcd(points[:, [2, 0, 1]], form).replace(b"WIDTH 3072\nHEIGHT 1", b"WIDTH 64\nHEIGHT 48")
    (tmp_path / "turned.pcd").write_bytes(turned)
    with pytest.raises(UserError, match="optical frame"):
        read_view(tmp_path / "turned.pcd")


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_a_pcd_cloud_as_a_view(tmp_path: Path, form: str) -> None:
    points = (INTRINSICS.rays * 0.7).reshape(-1, 3)
    points[3] = np.nan
    (tmp_path / "shot.pcd").write_bytes(_pcd(points, form))
    (tmp_path / "shot.json").write_text(json.dumps(CAMERA))
    view = read_view(tmp_path / "shot.pcd")
    assert np.allclose(view.depth[view.valid], 0.7) and view.valid.sum() == 64 * 48 - 1
    assert (view.rgb[10, 10] == (10, 20, 30)).all()


def test_a_ply_cloud(tmp_path: Path) -> None:
    import trimesh

    points = (INTRINSICS.rays * 0.7).reshape(-1, 3)
    trimesh.PointCloud(points, colors=np.full((len(points), 4), 200, np.uint8)).export(tmp_path / "shot.ply")
    cloud = read_cloud(tmp_path / "shot.ply")
    assert np.allclose(cloud.points, points, atol=1e-6)
    (tmp_path / "shot.json").write_text(json.dumps(CAMERA))
    assert (read_view(tmp_path / "shot.ply").rgb[5, 5] == 200).all()


BAD: dict[str, tuple[Callable[[Path], Path], str]] = {
    "empty depth": (lambda p: _folder(p, np.zeros((48, 64), np.uint16)), "no pixel has a depth"),
    "picture of depths": (lambda p: _folder(p, np.zeros((48, 64), np.uint8)), "16 bit"),
    "size mismatch": (lambda p: _folder(p, np.full((24, 32), 500, np.uint16)), "64 x 48"),
    "colour of another size": (lambda p: _folder(p, rgb=np.zeros((4, 4, 3), np.uint8)), "colour"),
    "focal length in metres": (lambda p: _folder(p, camera={**CAMERA, "fx": 0.002}), "degrees wide"),
    "principal point of another image": (lambda p: _folder(p, camera={**CAMERA, "cx": 320}), "outside the image"),
    "a missing key": (lambda p: _folder(p, camera={"fx": 1}), "fy"),
    "metres as millimetres": (lambda p: _folder(p, camera={**CAMERA, "depth_scale": 1.0}), "depth_scale"),
    "nothing there": (lambda p: p / "nothing.npz", "no such file"),
    "an unknown kind": (lambda p: p / "shot.bag", "no kind of recording"),
}


@pytest.mark.parametrize("case", BAD)
def test_mistakes_are_named(case: str, tmp_path: Path) -> None:
    make, said = BAD[case]
    with pytest.raises(UserError, match=said):
        read_view(make(tmp_path / "shot"))


def _cloud(path: Path, data: bytes) -> Path:
    (path / "shot.json").write_text(json.dumps(CAMERA))
    (path / "shot.pcd").write_bytes(data)
    return path / "shot.pcd"


RAYS = (INTRINSICS.rays * 0.7).reshape(-1, 3)
CLOUDS = {
    "all NaN": (_pcd(np.full((5, 3), np.nan), "binary"), "none of the 5 points is finite"),
    "empty": (_pcd(np.zeros((0, 3)), "ascii"), "empty"),
    "cut off": (_pcd(RAYS, "binary")[:-100], "cut off"),
    "cut off text": (_pcd(RAYS, "ascii").replace(b"POINTS 3072", b"POINTS 4000"), "cut off"),
    "behind the camera": (_pcd(-RAYS, "binary"), "optical frame"),
    "no PCD": (b"hello", "no PCD"),
    "said to be compressed": (_pcd(RAYS, "binary").replace(b"DATA binary", b"DATA binary_compressed"), "bytes, and the data say"),
    "compressed and cut off": (_pcd(RAYS, "binary_compressed")[:-100], "cut off"),
    "another form": (_pcd(RAYS, "binary").replace(b"DATA binary", b"DATA zipped"), "PCD data is 'zipped'"),
    "no z": (_pcd(RAYS, "binary").replace(b"x y z rgb", b"x y q rgb"), "no field 'z'"),
}


@pytest.mark.parametrize("case", CLOUDS)
def test_mistakes_in_clouds_are_named(case: str, tmp_path: Path) -> None:
    data, said = CLOUDS[case]
    with pytest.raises(UserError, match=said):
        read_view(_cloud(tmp_path, data))


@given(st.binary(max_size=300), st.integers(0, 400))
def test_no_bytes_crash_the_reader(tmp_path_factory: pytest.TempPathFactory, noise: bytes, cut: int) -> None:
    path = _cloud(tmp_path_factory.getbasetemp(), _pcd(RAYS[:20], "binary")[:cut] + noise)
    with contextlib.suppress(UserError):
        assert np.isfinite(read_cloud(path).points).all()
