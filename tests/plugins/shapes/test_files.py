"""Mesh files of every bad kind: one sentence with numbers and what to do, or a repair that is told."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers import made

from cramlite.model import Pose
from cramlite.plugin import UserError
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.shapes import files


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def _refusal(path: Path, **parameters: object) -> str:
    with pytest.raises(UserError) as caught:
        make("mesh", "it", Pose(), {"file": str(path), "mass": 0.2, **parameters})
    return str(caught.value)


def test_a_missing_file_names_its_neighbours(tmp_path: Path) -> None:
    made.bowl().export(tmp_path / "bowl.stl")
    assert "did you mean 'bowl.stl'" in _refusal(tmp_path / "bowll.stl")
    assert "no reader for '.step'" in _refusal(tmp_path / "bowl.step")


def test_empty_and_broken_files(tmp_path: Path) -> None:
    path = tmp_path / "x.stl"
    path.write_bytes(b"")
    assert "0 bytes" in _refusal(path)
    path.write_bytes(b"solid x\nendsolid x\n")
    assert "mesh" in _refusal(path)
    (tmp_path / "x.obj").write_text("v 0 0 0\nv 1 0 0\n")
    assert "no triangles" in _refusal(tmp_path / "x.obj") or "cannot be read" in _refusal(tmp_path / "x.obj")
    path.write_bytes(b"\0" * 80 + struct.pack("<I", 3) + b"\1" * 70)
    assert "export it anew" in _refusal(path) or "empty" in _refusal(path)


def test_a_huge_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "scan.stl"
    with path.open("wb") as file:
        file.truncate(84 + 50 * 2_400_000)
    said = _refusal(path)
    assert "2,400,000 faces" in said and "500,000" in said and "Simplify" in said


def test_many_faces_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made.mug().export(tmp_path / "mug.stl")
    monkeypatch.setattr(files, "MOST_FACES", 700)
    assert "faces; up to 700 are read" in _refusal(tmp_path / "mug.stl")


def test_millimetres_are_recognised(tmp_path: Path) -> None:
    mesh = made.bowl()
    mesh.apply_scale(1000)
    mesh.export(tmp_path / "bowl.stl")
    said = _refusal(tmp_path / "bowl.stl")
    assert "140 x 140 x 50 m" in said and "millimetres" in said and "'scale: 0.001'" in said
    assert make("mesh", "it", Pose(), {"file": str(tmp_path / "bowl.stl"), "scale": 0.001, "mass": 0.2}).geoms
    assert "small" in _refusal(tmp_path / "bowl.stl", scale=1e-6)


def test_flat_meshes_enclose_nothing(tmp_path: Path) -> None:
    trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]]).export(tmp_path / "flat.stl")
    assert "is flat" in _refusal(tmp_path / "flat.stl")


def test_vertices_that_are_no_numbers(tmp_path: Path) -> None:
    (tmp_path / "x.obj").write_text("v 0 0 0\nv 0.1 0 nan\nv 0 0.1 0\nf 1 2 3\n")
    assert "not finite" in _refusal(tmp_path / "x.obj") or "no triangles" in _refusal(tmp_path / "x.obj")


@pytest.mark.parametrize("mass", [{"mass": 0.2, "density": 500}, {}])
def test_mass_or_density(tmp_path: Path, mass: dict[str, float]) -> None:
    made.bowl().export(tmp_path / "bowl.stl")
    with pytest.raises(UserError, match=r"125.1 cm3 needs exactly one of 'mass' and 'density'"):
        make("mesh", "it", Pose(), {"file": str(tmp_path / "bowl.stl"), **mass})


@pytest.mark.heavy
def test_an_open_mesh_is_closed_and_says_so(tmp_path: Path) -> None:
    made.opened(made.mug(), 1).export(tmp_path / "open.stl")
    thing = make("mesh", "it", Pose(), {"file": str(tmp_path / "open.stl"), "mass": 0.2})
    assert re.search(r"not watertight, \d open edges; closed by adding \d faces", thing.notes[0])
    assert any(f.type == "cram:Handle" for f in thing.features)


def test_what_cannot_be_closed_becomes_its_hull_and_says_so(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    mesh = made.mug()
    trimesh.Trimesh(mesh.vertices, mesh.faces[rng.random(len(mesh.faces)) > 0.3], process=False).export(tmp_path / "torn.stl")
    thing = make("mesh", "it", Pose(), {"file": str(tmp_path / "torn.stl"), "mass": 0.2})
    assert "convex hull is used" in thing.notes[0] and "cm3" in thing.notes[0]
    assert not any(f.type == "cram:Handle" for f in thing.features)


def test_inverted_faces_are_turned(tmp_path: Path) -> None:
    mesh = made.bowl()
    mesh.invert()
    found = files.closed(mesh, "it")
    assert found.mesh.volume > 0 and "turned outwards" in found.notes[0]
    assert not files.closed(made.bowl(), "it").notes
