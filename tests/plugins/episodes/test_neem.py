"""NEEMs on disk: without loss, and from every writer that the field has."""

from __future__ import annotations

import gzip
import shutil
from pathlib import Path
from typing import Any

import bson
import bson.json_util as json_util
import numpy as np
import pytest
from helpers.episode_builders import episode, rollout
from helpers.properties import examples
from helpers.robcog_samples import TIMELINE, event_data
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from test_tracks import dump, tf

from cramlite.model import Entity, Episode, Event, Geom, Pose, Track
from cramlite.plugin import UserError
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.episodes.formats import parts
from cramlite_plugins.episodes.formats.neem import read_neem, write_neem

SAMPLES = Path(__file__).resolve().parents[4] / "shared" / "data" / "neem"
needs_samples = pytest.mark.skipif(not SAMPLES.exists(), reason="the real samples are not here")


def same(a: Episode, b: Episode | None) -> None:
    assert b is not None
    assert (a.name, a.entities, a.events, a.effector, a.repairs) == (
        b.name,
        b.entities,
        b.events,
        b.effector,
        b.repairs,
    )
    assert list(a.tracks) == list(b.tracks)
    assert a.extras.keys() == b.extras.keys()
    for k, track in a.tracks.items():
        assert np.array_equal(track.times, b.tracks[k].times)
        assert np.array_equal(track.poses, b.tracks[k].poses)
    for k, values in a.extras.items():
        assert np.array_equal(values, b.extras[k])


@pytest.mark.parametrize("without", [(), ("*.owl",), ("triples",), ("*_ED.owl", "*_SM.owl"), ("*_ED.owl",)])
def test_an_episode_reads_back_equal(tmp_path: Path, without: tuple[str, ...]) -> None:
    write_neem(episode(), tmp_path)
    for pattern in without:
        for found in tmp_path.glob(pattern):
            shutil.rmtree(found) if found.is_dir() else found.unlink()
    same(episode(), read_neem(tmp_path))


def test_a_detected_episode_reads_back_equal(tmp_path: Path) -> None:
    found = detect(rollout(), "demo")
    same(found, read_neem(write_neem(found, tmp_path / "neem")))


def test_what_is_lost_is_noticed(tmp_path: Path) -> None:
    write_neem(episode(), tmp_path)
    shutil.rmtree(tmp_path / "tf")
    with pytest.raises(AssertionError):
        same(episode(), read_neem(tmp_path))


def collection(folder: Path, name: str, *documents: dict[str, object]) -> Path:
    place = folder / name / "roslog"
    place.mkdir(parents=True)
    (place / f"{name}.bson").write_bytes(b"".join(map(bson.encode, documents)))
    return folder


@pytest.mark.parametrize("name", ["tf", "triples", "annotations", "wrench", "inferred"])
def test_an_empty_collection_is_an_empty_episode(tmp_path: Path, name: str) -> None:
    found = read_neem(collection(tmp_path, name))
    assert found is not None
    assert (found.events, found.entities, found.tracks) == ((), (), {})


def test_annotations_alone_are_said_to_be_no_events(tmp_path: Path) -> None:
    label = {"s": "http://x#Cup", "p": "http://www.w3.org/2000/01/rdf-schema#label", "v": "a cup"}
    found = read_neem(collection(tmp_path, "annotations", label))
    assert found is not None
    assert [r.what for r in found.repairs] == ["left out 1 statements"]


def transforms(count: int = 3) -> list[dict[str, Any]]:
    """A cup that goes along x, one pose a second."""
    place = {"rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return [
        {
            "header": {"seq": k, "stamp": bson.datetime_ms.DatetimeMS(1000 * k + 500), "frame_id": "map"},
            "child_frame_id": "cup",
            "transform": {"translation": {"x": 0.1 * k, "y": 0.0, "z": 1.0}, **place},
        }
        for k in range(1, count + 1)
    ]


PACKED = b"".join(map(bson.encode, transforms()))


def cup_of(folder: Path) -> list[float]:
    found = read_neem(folder)
    assert found is not None
    assert found.tracks["cup"].times == pytest.approx([1.5, 2.5, 3.5])
    return [float(x) for x in found.tracks["cup"].poses[:, 0]]


@pytest.mark.parametrize(
    "name",
    [
        "tf/roslog/tf.bson", "roslog/tf.bson", "tf.bson", "ros_tf/roslog/tf.bson", "5fb3aa_tf.bson", "tf/roslog/tf.bson.gz", "tf.json",
        "neems/5fb3aa_tf.bson", "one/tf/roslog/tf.bson",
    ],
)  # fmt: skip
def test_a_collection_is_found_in_every_layout(tmp_path: Path, name: str) -> None:
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    content = b"".join(map(bson.encode, transforms()))
    if name.endswith(".json"):
        content = "\n".join(json_util.dumps(d) for d in transforms()).encode()
    (tmp_path / name).write_bytes(gzip.compress(content) if name.endswith(".gz") else content)
    assert cup_of(tmp_path) == pytest.approx([0.1, 0.2, 0.3])
    assert cup_of(tmp_path / name) == pytest.approx([0.1, 0.2, 0.3])


def test_an_exported_list_is_read_too(tmp_path: Path) -> None:
    (tmp_path / "tf.json").write_text(json_util.dumps(transforms(), indent=1))
    assert cup_of(tmp_path) == pytest.approx([0.1, 0.2, 0.3])


def test_transforms_without_a_header_and_with_lists(tmp_path: Path) -> None:
    flat = [
        {**d["header"], "child_frame_id": "cup", "transform": {k: list(v.values()) for k, v in d["transform"].items()}}
        for d in transforms()
    ]
    assert cup_of(collection(tmp_path, "tf", *flat)) == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize("names", [("a_tf.bson", "b_tf.bson"), ("a/tf.bson", "b/tf/roslog/tf.bson")])
def test_two_dumps_in_one_folder_are_refused(tmp_path: Path, names: tuple[str, str]) -> None:
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"".join(map(bson.encode, transforms())))
    with pytest.raises(UserError, match=r"holds 2 episodes .a.*, b.*Name one of"):
        read_neem(tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("tf.bson.gz", gzip.compress(PACKED, mtime=0)[:-9], "cannot be unpacked"),
        ("tf.bson.gz", b"no archive", "cannot be unpacked"),
        ("tf.json", b'{"child_frame_id": "cup"', "tf.json:1: no document as mongoexport writes it"),
        ("tf.json", b"[1, 2]", "a document is an object, not '1'"),
        ("tf.json", b'{"child_frame_id": "cup"}', "field 'transform' is missing"),
    ],
)
def test_a_damaged_export_is_refused_with_its_place(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UserError, match=said):
        read_neem(tmp_path)


@pytest.mark.parametrize("key", ["force", "wrench"])
def test_wrenches_of_both_layouts(tmp_path: Path, key: str) -> None:
    value = {"force": {"x": 1.0, "y": 2.0, "z": 3.0}, "torque": {"x": 4.0, "y": 5.0, "z": 6.0}}
    documents = ({"header": {"stamp": t, "frame_id": "tool0"}, key: value} for t in (1.0, 2.0))
    found = read_neem(collection(tmp_path, "wrench", *documents))
    assert found is not None
    assert found.sampled("wrench", 1.5) == pytest.approx((1, 2, 3, 4, 5, 6))
    assert found.sampled("joints", 1.5) is None


@pytest.mark.parametrize("factor", [1.0, 1e3, 1e6, 1e9])
def test_times_of_events_are_in_any_unit_of_the_second(tmp_path: Path, factor: float) -> None:
    dul, soma = "http://www.ontologydesignpatterns.org/ont/dul/DUL.owl#", "http://www.ease-crc.org/ont/SOMA.owl#"
    times = {"hasIntervalBegin": 1.6e9, "hasIntervalEnd": 1.6e9 + 2}
    about = ({"s": "http://x#i1", "p": soma + k, "o": v * factor} for k, v in times.items())
    found = read_neem(collection(tmp_path, "triples", {"s": "http://x#e1", "p": dul + "hasTimeInterval", "o": "http://x#i1"}, *about))
    assert found is not None and [(e.start, e.end) for e in found.events] == [pytest.approx((1.6e9, 1.6e9 + 2))]


def test_statements_of_several_collections_belong_together(tmp_path: Path) -> None:
    dul, soma = "http://www.ontologydesignpatterns.org/ont/dul/DUL.owl#", "http://www.ease-crc.org/ont/SOMA.owl#"
    type_ = "http://www.w3.org/1999/02/22-rdf-syntax-ns#type"
    event, interval, cup = "http://x#e1", "http://x#i1", "http://x#cup1"
    collection(
        tmp_path,
        "triples",
        {"s": event, "p": type_, "o": dul + "Action"},
        {"s": event, "p": dul + "executesTask", "o": "http://x#t1"},
        {"s": "http://x#t1", "p": type_, "o": soma + "PickingUp"},
        {"s": cup, "p": dul + "isParticipantIn", "o": event},
        *({"s": cup, "p": type_, "o": t} for t in (soma + "Cup", "http://knowrob.org/kb/knowrob.owl#RedCup")),
    )
    times = {"hasIntervalBegin": 1.5, "hasIntervalEnd": 2.5}
    about = ({"s": interval, "p": soma + k, "o": v} for k, v in times.items())
    collection(tmp_path, "inferred", {"s": interval, "p": dul + "isTimeIntervalOf", "o": event}, *about)
    found = read_neem(tmp_path)
    assert found is not None
    assert [(e.type, e.start, e.end, e.roles) for e in found.events] == [
        ("soma:PickingUp", 1.5, 2.5, {"object": "cup1"})
    ]
    assert set(found.entity("cup1").types) == {"soma:Cup", "knowrob:RedCup"}


@pytest.mark.parametrize("name", ["a.ttl", "a.nt"])
def test_rdf_is_a_neem_too(tmp_path: Path, name: str) -> None:
    same(replace(episode(), tracks={}, extras={}), read_neem(write_neem(episode(), tmp_path / name)))


names = st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=12).filter(
    lambda s: s.strip() == s and not s.startswith("/")  # tf takes "/cup" for "cup"
)
numbers = st.floats(-1e6, 1e6)
events = st.builds(
    lambda i, s, d, k, r, f: Event(i, f"soma:{k.title()}X", k, s, s + d, {r: "thing"}, f),
    names, numbers, st.floats(0, 100), st.sampled_from(["state", "action", "situation"]), names, st.booleans(),
)  # fmt: skip


@examples(25)
@given(
    st.lists(events, max_size=6, unique_by=lambda e: e.id),
    names,
    st.lists(numbers, min_size=1, max_size=9, unique=True),
)
def test_any_episode_reads_back_equal(
    tmp_path_factory: pytest.TempPathFactory, timeline: list[Event], name: str, times: list[float]
) -> None:
    track = Track(np.array(sorted(times)), np.tile([0.1, 0.2, 0.3, 0.6, 0.8, 0.0, 0.0], (len(times), 1)))
    whole = Episode(
        name, (Entity("thing", (f"cram:{'A'}",)),), tuple(sorted(timeline, key=lambda e: e.start)), {"thing": track}
    )
    same(whole, read_neem(write_neem(whole, tmp_path_factory.mktemp("neem"))))


small = st.floats(-100, 100)
quaternions = st.tuples(small, small, small, small).filter(lambda q: np.linalg.norm(q) > 0.1)
poses = st.builds(Pose, st.tuples(small, small, small), quaternions)
curies = st.sampled_from(["cram:Product", "soma:Cup", "knowrob:RedCup", "http://example.org/a#B", "dul:Object"])
sizes = st.tuples(*[st.floats(1e-3, 10)] * 3)
geoms = st.builds(Geom, st.sampled_from(["box", "cylinder", "capsule", "sphere"]), sizes, poses, names | st.just(""))
things = st.builds(
    Entity, names, st.lists(curies, max_size=3, unique=True).map(tuple), st.none(), st.none() | poses,
    st.none() | sizes, st.lists(geoms, max_size=2).map(tuple), st.dictionaries(names, numbers, max_size=2),
)  # fmt: skip


@examples(40)
@given(st.lists(things, min_size=1, max_size=4, unique_by=lambda e: e.name), st.data())
def test_any_map_and_poses_read_back_equal(
    tmp_path_factory: pytest.TempPathFactory, entities: list[Entity], data: st.DataObject
) -> None:
    tracks = {}
    for entity in entities:
        rows = data.draw(st.lists(poses, min_size=1, max_size=5))
        times = np.cumsum(data.draw(st.lists(st.floats(0, 10), min_size=len(rows), max_size=len(rows))))
        tracks[entity.name] = Track(times, np.array([[*p.position, *p.quaternion] for p in rows]))
    known = tuple(replace(e, part_of=entities[0].name) if k and k % 2 else e for k, e in enumerate(entities))
    whole = Episode("any", known, (), tracks, data.draw(st.none() | st.just(entities[0].name)))
    found = read_neem(write_neem(whole, tmp_path_factory.mktemp("neem")))
    assert found is not None
    same(replace(whole, effector=found.effector if whole.effector is None else whole.effector), found)


@pytest.mark.parametrize(("name", "better"), [("/cup", "'cup'"), ("/", "'thing'")])
def test_a_name_that_would_not_read_back_is_not_written(tmp_path: Path, name: str, better: str) -> None:
    track = Track(np.zeros(1), np.array([[0, 0, 0, 1, 0, 0, 0]], dtype=float))
    with pytest.raises(UserError, match=f"'{name}' would not read back.*call it {better}"):
        write_neem(Episode("any", (Entity(name, ()),), (), {name: track}, None), tmp_path / "neem")
    assert not (tmp_path / "neem").exists()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("Prefix(:=<http://x#>)\nOntology(<http://x>)", "functional"),
        ("<?xml version='1.0'?>\n<rdf:RDF xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'>\n<broken", ":3:"),
        ('<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><a>&b;</a>', "entity 'b'"),
        ('<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>', "entity 'x'"),
        (f'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x "{"ha" * 1000}">]><a>{"&x;" * 1000}</a>', "entity 'x'"),
        ('<?xml version="1.0"?>\n<!DOCTYPE a [\n<!ENTITY owl "http://www.w3.org', ":3: this is not XML"),
        ("", "no XML"),
        ("\x00\x01\x02", "no XML"),
    ],
)
def test_bad_owl_is_refused_with_the_place(tmp_path: Path, content: str, words: str) -> None:
    (tmp_path / "X_ED.owl").write_text(content)
    with pytest.raises(UserError, match=r"X_ED\.owl") as caught:
        read_neem(tmp_path)
    assert words in str(caught.value)


def test_a_gigabyte_of_owl_is_refused_unread(tmp_path: Path) -> None:
    with (tmp_path / "X_ED.owl").open("wb") as file:
        file.truncate(10**9)
    with pytest.raises(UserError, match="1000 MB"):
        read_neem(tmp_path)


@pytest.mark.parametrize("damage", [b"no archive", b"PK\x05\x06" + bytes(9)])
def test_broken_arrays_are_refused(tmp_path: Path, damage: bytes) -> None:
    write_neem(episode(), tmp_path)
    (tmp_path / "extras.npz").write_bytes(damage)
    with pytest.raises(UserError, match=r"extras\.npz"):
        read_neem(tmp_path)


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.savez_compressed(tmp_path / "extras.npz", times=np.zeros(1000))
    assert read_neem(tmp_path) is None
    monkeypatch.setattr(parts, "MAX_EXTRAS", 4000)
    with pytest.raises(UserError, match="GB are allowed"):
        read_neem(tmp_path)


def test_damaged_literals_are_reported_not_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = write_neem(episode(), tmp_path) / "a_test_1_2_ED.owl"
    text = path.read_text().replace('"removed"', '"remoed"').replace(">1</cram:order>", ">one</cram:order>")
    path.write_text(text)
    found = read_neem(tmp_path)
    assert found is not None
    assert found.repairs[0].what == "left out the earlier repairs"
    assert {e.id for e in found.events} == {e.id for e in episode().events}
    assert capfd.readouterr().err == ""


def test_no_neem_is_none(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello")
    assert read_neem(tmp_path) is None
    assert read_neem(tmp_path / "notes.txt") is None
    assert read_neem(tmp_path / "absent") is None


def test_two_episodes_in_one_folder_are_refused(tmp_path: Path) -> None:
    for name in ("A", "B"):
        (tmp_path / f"{name}_ED.owl").write_text(event_data(*TIMELINE))
    with pytest.raises(UserError, match="2 episodes"):
        read_neem(tmp_path)


def test_a_robots_run_has_one_frame_and_a_wrench(tmp_path: Path) -> None:
    """As test_real_runs_and_maps reads them where they are: poses of the flange and forces, nothing else."""
    value = {"force": {"x": 1.0, "y": 0.0, "z": 3.0}, "torque": {"x": 0.0, "y": 0.0, "z": 0.0}}
    times = [1.0 + 0.25 * k for k in range(33)]
    collection(tmp_path, "wrench", *({"header": {"stamp": t, "frame_id": "ee_link"}, "wrench": value} for t in times))
    dump(tmp_path, b"".join(tf("ee_link", "base_link", t, [0.5, 0, t / 10, 1, 0, 0, 0]) for t in times))
    found = read_neem(tmp_path)
    assert found is not None
    assert (found.effector, [e.name for e in found.entities]) == ("ee_link", ["ee_link"])
    assert found.tracks["ee_link"].times == pytest.approx(times)
    assert found.extras["wrench"].shape == (33, 6)


def test_a_hand_that_the_tracker_never_saw_is_said_to_be_missing(tmp_path: Path) -> None:
    """As test_a_real_recording_says_what_was_missing: the tracker's first pose of a thing is the identity."""
    nowhere = [0.0, 0, 0, 1, 0, 0, 0]
    rows = [tf(f"SK_{side}Hand", "map", 1, nowhere) for side in ("Left", "Right")]
    rows += [tf("SK_RightHand", "map", 1 + k, [0.5, 0, k / 10, 1, 0, 0, 0]) for k in range(1, 5)]
    found = read_neem(dump(tmp_path, b"".join(rows)))
    assert found is not None
    assert found.effector == "SK_RightHand" and len(found.tracks["SK_RightHand"].times) == 4
    assert "SK_LeftHand" not in found.tracks
    assert [r.what for r in found.repairs] == [
        "dropped 1 of 1 poses of 'SK_LeftHand'", "dropped 1 of 5 poses of 'SK_RightHand'",
        "read 'SK_LeftHand' as a hand", "read 'SK_RightHand' as a hand",
    ]  # fmt: skip


@needs_samples
def test_real_runs_and_maps() -> None:
    for run in ("lar_run1", "lar_run5"):
        found = read_neem(SAMPLES / run)
        assert found is not None
        assert found.effector == "ee_link"
        assert len(found.tracks["ee_link"].times) == 33
        assert found.extras["wrench"].shape == (33, 6)
    kitchen = read_neem(SAMPLES / "GttFys24Hbn_SM.owl")
    assert kitchen is not None
    assert len(kitchen.entities) == 8
    assert not kitchen.repairs
    door = next(e for e in kitchen.entities if "knowrob:PKDishWasherDoor" in e.types)
    assert door.size == pytest.approx((0.59457397, 0.0485495, 0.69925873))
    assert door.properties["mass"] == pytest.approx(4.744431)
    assert door.pose is not None
    assert door.pose.position == pytest.approx((-2.37000641, -1.7335007, 0.52356094))


@needs_samples
def test_a_real_recording_says_what_was_missing() -> None:
    found = read_neem(SAMPLES / "pouring_shaking")
    assert found is not None
    assert found.effector == "SK_GenesisRightHand"
    assert len(found.tracks["salt_container"].times) == 91
    assert "SK_GenesisLeftHand" not in found.tracks
    assert any("SK_GenesisLeftHand" in r.what for r in found.repairs)
