"""Readers given damaged files: a clear refusal or a reported repair, never a crash, and never much memory."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

import bson
import numpy as np
import pytest
from helpers.episode_builders import episode
from helpers.properties import examples
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from cramlite.model import Entity, Episode, Pose
from cramlite.plugin import UserError
from cramlite_plugins.episodes.formats.neem import read_neem, write_neem
from cramlite_plugins.episodes.repair.dropouts import bridge_dropouts
from cramlite_plugins.episodes.repair.flicker import debounce
from cramlite_plugins.episodes.repair.two_hands import one_handed

QUICK = examples(60, suppress_health_check=list(HealthCheck))
#: What a reader may take of a file that it refuses, beside Python and NumPy themselves [bytes].
MEMORY = 1 << 30


def sound(found: Episode | None) -> None:
    """What every episode must be, whatever it was read from."""
    if found is None:
        return
    names = [e.name for e in found.entities]
    assert len(names) == len(set(names))
    assert len({e.id for e in found.events}) == len(found.events)
    assert all(e.start <= e.end for e in found.events)
    assert all(f in set(names) for e in found.events for f in e.roles.values())
    for track in found.tracks.values():
        assert np.isfinite(track.poses).all()
        assert (np.diff(track.times) >= 0).all()
        assert np.linalg.norm(track.poses[:, 3:], axis=1) == pytest.approx(1.0, abs=1e-4)
    for name in names:
        found.pose_at(name, 0.5)


def read(path: Path) -> None:
    """Read and repair, as a user would."""
    try:
        found = read_neem(path)
    except UserError as refused:
        clear = str(path) in str(refused) and len(str(refused)) < 1500
    else:
        clear = True
        sound(found)
        sound(None if found is None else one_handed(debounce(bridge_dropouts(found))))
    assert clear


def files(folder: Path) -> dict[str, bytes]:
    write_neem(episode(6), folder)
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def damaged(content: bytes, data: st.DataObject) -> bytes:
    """Cut off, bytes changed, pieces doubled, left out, or replaced by what breaks numbers."""
    result = bytearray(content)
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, max(len(result) - 1, 0)))
        length = data.draw(st.integers(1, 200))
        kind = data.draw(st.sampled_from(["cut", "byte", "double", "remove", "nan", "digit"]))
        if kind == "cut":
            del result[place:]
        elif kind == "byte" and result:
            result[place] = data.draw(st.integers(0, 255))
        elif kind == "double":
            result[place:place] = result[place : place + length]
        elif kind == "remove":
            del result[place : place + length]
        elif kind == "nan":
            result[place : place + 8] = b"\x00\x00\x00\x00\x00\x00\xf8\x7f"
        else:
            text = bytes(result)
            at = next((k for k in range(place, len(text)) if text[k : k + 1].isdigit()), place)
            result[at : at + 1] = data.draw(st.sampled_from([b"-9", b"e99", b"nan", b"1e999", b""]))
    return bytes(result)


@QUICK
@given(st.data())
def test_any_file_of_an_episode_may_be_damaged(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.mktemp("fuzz")
    whole = files(folder)
    name = data.draw(st.sampled_from(sorted(whole)))
    (folder / name).write_bytes(damaged(whole[name], data))
    keep = data.draw(st.booleans())
    for other in whole:
        if not keep and other != name:
            (folder / other).unlink()
    read(folder)


values = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**60), 2**60), st.floats(), st.text(max_size=5), st.just({}), st.just([])
)


@QUICK
@given(st.data())
def test_documents_may_hold_anything(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    def poses(names: str) -> dict[str, object]:
        return {k: data.draw(st.floats() | values) for k in names}

    document: dict[str, object] = {
        "header": {"stamp": data.draw(st.floats(0, 9) | values), "frame_id": data.draw(st.just("map") | values)},
        "child_frame_id": data.draw(st.sampled_from(["a", "b"]) | values),
        "transform": {"translation": poses("xyz"), "rotation": poses("xyzw")},
        "force": {"force": poses("xyz"), "torque": poses("xyz")},
        **{k: data.draw(values) for k in "spo"},
        "timestamp": data.draw(st.floats(0, 9) | values),
        "individuals": [{"id": data.draw(values), "pose": data.draw(st.lists(st.floats(), min_size=7, max_size=7))}],
    }
    folder = tmp_path_factory.mktemp("fuzz")
    name = data.draw(st.sampled_from(["tf", "triples", "wrench", "annotations", "inferred", "world_state"]))
    for key in data.draw(st.lists(st.sampled_from(sorted(document)), max_size=2)):
        document.pop(key, None)
    if name == "tf":
        document.pop("individuals", None)
    (folder / f"{name}.bson").write_bytes(bson.encode(document) * 2)
    read(folder)


NESTED = b"".join(
    (
        b'<?xml version="1.0"?><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" xmlns:x="http://x#">',
        b"<x:a><x:b>" * 20_000,
        b"</x:b></x:a>" * 20_000,
        b"</rdf:RDF>",
    )
)


def deep_bson() -> bytes:
    """A document 10,000 documents deep, which no encoder of Python's writes."""
    document = b"\x05\x00\x00\x00\x00"
    for _ in range(10_000):
        inner = b"\x03a\x00" + document + b"\x00"
        document = (len(inner) + 4).to_bytes(4, "little") + inner
    return document


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("X_ED.owl", NESTED),
        ("w.json", b"[" * 100_000),
        ("w.json", b'{"a":' * 100_000),
        ("x.ttl", b"[] <http://x#a> " + b"[ <http://x#a> " * 20_000),
        ("tf.bson", deep_bson()),
        ("x.nt", b"<http://x#a> <http://x#b> " + b'"' + b"a" * 2_000_000 + b'" .'),
        ("x.jsonld", b'{"@context": "http://localhost:9/x", "@id": "http://x#a"}'),
    ],
)
def test_deep_and_long_files(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    read(tmp_path / name)


@pytest.mark.heavy
@pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_AS binds on Linux only")
@pytest.mark.parametrize(
    "name", ["X_ED.owl", "x.ttl", "x.jsonld", "tf.bson", "triples.bson", "w.json", "w.jsonl", "extras.npz"]
)
def test_a_gigabyte_is_refused_in_bounded_memory(tmp_path: Path, name: str) -> None:
    """A sparse file; the reader runs in a process of its own that may not take more than MEMORY beside Python's."""
    with (tmp_path / name).open("wb") as file:
        file.truncate(2**30)
    code = f"""
import sys, numpy, bson, rdflib
from pathlib import Path
from cramlite.plugin import UserError
from cramlite.model import Pose
from cramlite_plugins.episodes.formats.neem import read_neem
try:
    read_neem(Path({str(tmp_path / name)!r}))
except UserError as error:
    print(error)
    sys.exit(2)
"""
    ran = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
    )
    assert ran.returncode == 2, ran.stderr[-600:]
    assert name in ran.stdout


def test_one_wrong_stamp_makes_no_recording_of_fifty_years(tmp_path: Path) -> None:
    """The grid on which motion is looked at would not fit any memory."""
    pose = {"translation": {"x": 1.0, "y": 0.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    rows = [
        {"header": {"stamp": t, "frame_id": "map"}, "child_frame_id": name, "transform": pose}
        for name in ("hand", "cup")
        for t in (0.0, 1.0, 1.6e9)
    ]
    (tmp_path / "tf.bson").write_bytes(b"".join(map(bson.encode, rows)))
    found = read_neem(tmp_path)
    assert found is not None
    assert found.repairs[-1].what == "cut a pause of 1599999999 s to 10 s"


@pytest.mark.parametrize("context", ['"http://localhost:9/x"', '[{}, "file:///etc/passwd"]', '{"@import": "http://x"}'])
def test_reading_opens_nothing_else(tmp_path: Path, context: str) -> None:
    (tmp_path / "x.jsonld").write_text(f'{{"@context": {context}, "@id": "http://x#a"}}')
    with pytest.raises(UserError, match="in another file or at an address"):
        read_neem(tmp_path / "x.jsonld")
    (tmp_path / "x.jsonld").write_text('{"@context": {"a": "http://x#a"}, "@id": "http://x#b", "a": 1}')
    assert read_neem(tmp_path / "x.jsonld") is None


def test_long_chains_of_parts_and_circles_end() -> None:
    parts = tuple(Entity(str(k), (), str(k - 1) if k else None, Pose((0.001, 0, 0))) for k in range(5000))
    end = Episode("x", parts, ()).pose_at("4999", 0.0)
    assert end is not None
    assert end.position == pytest.approx((5.0, 0, 0))
    circle = (Entity("a", (), "b", Pose()), Entity("b", (), "a", Pose()))
    assert Episode("x", circle, ()).pose_at("a", 0.0) is None
