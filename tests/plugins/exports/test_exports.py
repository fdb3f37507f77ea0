"""Exports of a run: what the formats' own readers read back is what was recorded; what cannot be written is said in a sentence."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.as_a_user import cramlite
from msgspec.structs import replace

from cramlite.base.pulse import ASKED, Stopped, Work, pulse, working
from cramlite.cli.export import run_record
from cramlite.model import RunRecord, Touch
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite_plugins.exports.animations import write_gif

NS = 1e-9


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run with contacts, tasks and things that move."""
    out = tmp_path_factory.mktemp("ran") / "run"
    done = cramlite("resolve", "place_on_shelf", "--out", out, "--no-report", "--twins", "0")
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def record(ran: Path) -> RunRecord:
    return run_record(ran, None, Knowledge(Registry()))


@pytest.fixture(scope="module")
def exported(ran: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Writes the run in a format, once."""
    folder, written = tmp_path_factory.mktemp("exported"), dict[str, Path]()

    def write(to: str) -> Path:
        if to not in written:
            done = cramlite("export", ran, "--to", to, "--out", folder / to)
            assert done.returncode == 0, done.stderr
            written[to] = Path(done.stdout.strip())
        return written[to]

    return write


@pytest.mark.heavy
def test_tasks_and_steps_follow_each_other(record: RunRecord) -> None:
    assert [s.name for s in record.tasks] == ["1.Grasping", "2.PickingUp", "3.Placing", "4.ParkingArms"]
    for spans in (record.tasks, record.steps):
        assert all(a.end <= b.start + 1e-9 for a, b in pairwise(spans))
        assert all(s.start < s.end for s in spans)


# --- CSV


def _table(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_csv_is_read_back_equal(exported: Any, record: RunRecord) -> None:
    folder, rollout = exported("csv"), record.rollout
    joints = _table(folder, "joints")
    assert np.array_equal([[float(row[j]) for j in record.joints] for row in joints], rollout.joints)
    assert np.array_equal([float(row["time"]) for row in joints], rollout.times)
    assert np.array_equal([float(row["felt"]) for row in _table(folder, "wrench")], rollout.contact_force())
    block = [[float(v) for v in list(row.values())[2:]] for row in _table(folder, "poses") if row["frame"] == "block"]
    assert np.array_equal(block, record.scene.poses["block"])
    rows = _table(folder, "contacts")
    contacts = [(float(r["time"]), Touch(r["a"], r["b"], *(float(r[n]) for n in ("force", "lift", "press")))) for r in rows]
    assert contacts == [(float(t), c) for t, all_ in zip(rollout.times, rollout.touches, strict=True) for c in all_]
    assert [row["task"] for row in _table(folder, "tasks")] == [s.name for s in record.tasks]
    assert len(_table(folder, "events")) == len(record.events) > 3


# --- MCAP


def _messages(folder: Path, topic: str) -> Iterator[tuple[float, Any]]:
    """By Foxglove's own readers of MCAP and of ROS 2 messages, which know nothing of rosbags."""
    reader = pytest.importorskip("mcap.reader")
    decoder = pytest.importorskip("mcap_ros2.decoder")
    (path,) = folder.glob("*.mcap")
    with path.open("rb") as file:
        bag = reader.make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        for _, _, message, read in bag.iter_decoded_messages(topics=[topic]):
            yield message.log_time * NS, read


@pytest.mark.heavy
def test_mcap_is_read_back_equal_by_foxgloves_reader(exported: Any, record: RunRecord) -> None:
    folder, rollout = exported("mcap"), record.rollout
    states = list(_messages(folder, "/joint_states"))
    assert np.array_equal([list(s.position) for _, s in states], rollout.joints)
    assert list(states[0][1].name) == list(record.joints)
    assert np.allclose([t for t, _ in states], rollout.times, atol=NS)
    wrench = [(w.wrench.force.x, w.wrench.force.y, w.wrench.force.z, w.wrench.torque.x) for _, w in _messages(folder, "/wrench")]
    assert np.array_equal(wrench, rollout.wrench[:, :4])
    touches = [tuple(Touch(c.a, c.b, c.force, c.lift, c.press) for c in said.contacts) for _, said in _messages(folder, "/contacts")]
    assert tuple(touches) == rollout.touches
    moved = [next(t.transform for t in m.transforms if t.child_frame_id == "block") for _, m in _messages(folder, "/tf")]
    rows = [[*(getattr(t.translation, a) for a in "xyz"), *(getattr(t.rotation, a) for a in "wxyz")] for t in moved]
    assert np.array_equal(rows, record.scene.poses["block"])


@pytest.mark.heavy
def test_mcap_says_tasks_events_shapes_and_pictures(exported: Any, record: RunRecord) -> None:
    folder = exported("mcap")
    tasks = [(t, m.data) for t, m in _messages(folder, "/task")]
    assert [name for _, name in tasks] == [*(s.name for s in record.tasks), ""]
    assert np.allclose([t for t, _ in tasks[:-1]], [s.start for s in record.tasks], atol=NS)
    events = [m for _, m in _messages(folder, "/events")]
    assert sum(m.begins for m in events) == len(record.events) == len(events) / 2
    ((_, array),) = _messages(folder, "/markers")
    assert len(array.markers) == len(record.scene.solids)
    frames = {t.child_frame_id for topic in ("/tf", "/tf_static") for _, m in _messages(folder, topic) for t in m.transforms}
    assert {m.header.frame_id for m in array.markers} <= frames
    pictures = [bytes(m.data) for _, m in _messages(folder, "/camera/compressed")]
    assert len(pictures) >= record.rollout.times[-1] and all(p.startswith(b"\xff\xd8") for p in pictures)


def test_ros_tools_open_the_same_folder(exported: Any, record: RunRecord) -> None:
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    with rosbag2.Reader(exported("mcap")) as bag:
        assert {c.topic: c.msgcount for c in bag.connections}["/joint_states"] == len(record.rollout.times)


def test_a_truncated_mcap_is_not_read_as_whole(exported: Any, tmp_path: Path) -> None:
    reader, errors = pytest.importorskip("mcap.reader"), pytest.importorskip("mcap.exceptions")
    (path,) = exported("mcap").glob("*.mcap")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with cut.open("rb") as file, pytest.raises(errors.McapError):
        list(reader.make_reader(file).iter_messages())


# --- rerun


def test_rerun_is_read_back_equal(exported: Any, record: RunRecord) -> None:
    chunk = pytest.importorskip("rerun.chunk", reason="the extra cramlite[rerun] is not installed")
    batches: dict[str, list[Any]] = {}
    for piece in chunk.RrdReader(exported("rerun")).stream():
        batches.setdefault(piece.entity_path, []).append(piece.to_record_batch())

    def column(path: str, name: str) -> Any:
        rows = [row for batch in batches[path] for row in batch.column(name).to_pylist()]
        return np.array([row[0] for row in rows])

    assert np.array_equal(column(f"/joints/{record.joints[0]}", "Scalars:scalars"), record.rollout.joints[:, 0])
    assert np.array_equal(column("/force", "Scalars:scalars"), record.rollout.contact_force())
    moved = column("/world/block", "Transform3D:translation")
    assert np.allclose(moved, record.scene.poses["block"][:, :3], atol=1e-6)  # rerun's are single precision
    assert [str(t) for t in column("/tasks", "TextLog:text")] == [s.name for s in record.tasks]


# --- what goes wrong


def test_an_unknown_format_names_those_there_are(ran: Path) -> None:
    done = cramlite("export", ran, "--to", "mcapp")
    assert done.returncode == 2
    assert "There is no format 'mcapp'" in done.stderr and "mcap" in done.stderr and "BehaviorTree.CPP" in done.stderr


def test_nothing_is_overwritten(ran: Path, tmp_path: Path) -> None:
    (tmp_path / "csv").mkdir()
    done = cramlite("export", ran, "--to", "csv", "--out", tmp_path / "csv")
    assert done.returncode == 2 and "exists already" in done.stderr
    assert not list((tmp_path / "csv").iterdir())


def test_a_folder_without_a_run_says_so(tmp_path: Path) -> None:
    done = cramlite("export", tmp_path, "--to", "csv")
    assert done.returncode == 2 and "no rollout.npz" in done.stderr


def test_a_place_that_cannot_be_written_leaves_nothing(ran: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = cramlite("export", ran, "--to", "csv", "--out", tmp_path / "file" / "csv")
    assert done.returncode == 2 and "cannot be written" in done.stderr


@pytest.mark.parametrize("to", ["mp4", "gif"])
def test_what_is_interrupted_leaves_no_half_of_a_file(ran: Path, tmp_path: Path, to: str) -> None:
    out = tmp_path / f"run.{to}"
    command = [sys.executable, "-m", "cramlite", "export", str(ran), "--to", to, "--out", str(out)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        while not out.exists() and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        assert process.stderr is not None
        said = process.stderr.read()
    assert process.returncode == 128 + signal.SIGTERM
    assert said.endswith("cramlite: interrupted; nothing is left of what was written.\n"), said
    assert not out.exists()


@pytest.mark.heavy
def test_a_gif_tells_how_much_of_the_run_is_drawn_and_is_stopped_at_once(record: RunRecord, tmp_path: Path) -> None:
    drawn, told = list[int](), list[float]()

    def picture(sample: int) -> Any:
        drawn.append(sample)
        time.sleep(1.5 * ASKED)
        return np.full((24, 32, 3), len(drawn), np.uint8)

    def tell(work: Work | None) -> None:
        assert work is not None
        told.append(work.at)

    plain, whole = replace(record, picture=picture), float(record.rollout.times[-1] - record.rollout.times[0])
    with pulse(lambda: False, tell), working("writing gif", whole):
        write_gif(plain, tmp_path / "whole.gif")
    assert told == sorted(told) and whole in told and len(set(told)) > 5, "the last picture is that of the end"
    drawn.clear()
    with pytest.raises(Stopped), pulse(lambda: len(drawn) >= 3):
        write_gif(plain, tmp_path / "stopped.gif")
    assert len(drawn) == 3


def test_a_missing_extra_names_how_to_install_it(ran: Path, tmp_path: Path) -> None:
    plugin = tmp_path / "needy.py"
    plugin.write_text(
        "from cramlite.plugin import Exporter, hookimpl\n\n\n@hookimpl\ndef exporters():\n"
        "    return [Exporter('needy', '.x', 'nobody', lambda run, out: None, {'no_such_package': 'cramlite[needy]'})]\n"
    )
    done = cramlite("export", ran, "--to", "needy", "--plugin", plugin)
    assert done.returncode == 2 and "pip install 'cramlite[needy]'" in done.stderr


def test_a_run_without_its_program_has_no_tree(ran: Path, tmp_path: Path) -> None:
    bare = tmp_path / "bare"
    bare.mkdir()
    for name in ("rollout.npz", "world.json"):
        (bare / name).write_bytes((ran / name).read_bytes())
    done = cramlite("export", bare, "--to", "btcpp")
    assert done.returncode == 2 and "holds no typed program" in done.stderr
    assert json.loads((bare / "world.json").read_text())
    assert sorted(p.name for p in bare.iterdir()) == ["rollout.npz", "world.json"]


@pytest.mark.heavy
def test_a_gif_shows_the_whole_run_at_its_own_speed(exported: Any, record: RunRecord) -> None:
    from PIL import Image, ImageSequence

    with Image.open(exported("gif")) as file:
        pauses = [frame.info["duration"] for frame in ImageSequence.Iterator(file)]
        file.seek(file.n_frames - 1)
        last = np.asarray(file.convert("RGB"), dtype=float)
    assert sum(pauses) / 1000 == pytest.approx(record.rollout.times[-1] - record.rollout.times[0], abs=0.5)
    assert np.abs(last - record.picture(len(record.rollout.times) - 1)).mean() < 4, "the end is not the run's end"


@pytest.mark.heavy  # a GIF shows the same, beside its own format
def test_an_mp4_shows_the_whole_run_at_its_own_speed(exported: Any, record: RunRecord) -> None:
    av = pytest.importorskip("av")
    with av.open(str(exported("mp4"))) as file:
        frames = list(file.decode(video=0))
    assert float(frames[-1].time) == pytest.approx(record.rollout.times[-1] - record.rollout.times[0], abs=0.3)
    last = frames[-1].to_ndarray(format="rgb24").astype(float)
    assert np.abs(last - record.picture(len(record.rollout.times) - 1)).mean() < 6, "the end is not the run's end"
