"""Episodes by hooks: whoever reads a recording, it is repaired; whoever detects or writes, the answer is checked."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Run
from helpers.episode_builders import rollout
from test_neem import same

from cramlite import Engine, PluginError
from cramlite.model import Entity, Episode, Event, Track
from cramlite.plugin import UserError
from cramlite_plugins.episodes.formats.neem import write_neem

Plugin = Callable[[str, str], Path]

READER = """
import json
import numpy as np

@hookimpl
def read_episode(path):
    if path.suffix != ".mine":
        return None
    data = json.loads(path.read_text())
    entities = tuple(Entity(name, ("dul:PhysicalObject",)) for name in data["things"])
    events = tuple(Event(id_, type_, "state", start, end, roles) for id_, type_, start, end, roles in data["events"])
    tracks = {n: Track(np.array(t["times"]), np.array(t["poses"])) for n, t in data["tracks"].items()}
    return Episode(data["name"], entities, events, tracks, "hand")
"""
"""A reader that knows nothing of repairs."""


def _moving() -> Track:
    """Along x at 0.1 m/s for 8 s."""
    times = np.arange(401) / 50
    return Track(times, np.column_stack([0.1 * times, *np.zeros((2, 401)), np.ones(401), *np.zeros((3, 401))]))


def recorded() -> Episode:
    """A cup is taken by one hand and passed to the other; it vanishes for 0.6 s, and contacts flicker."""
    contact, grasp = "soma:ContactState", "cram:GraspState"
    held = {"gripper": "hand", "object": "cup"}
    events = [
        Event("g1", grasp, "state", 1.0, 2.0, held),
        Event("g2", grasp, "state", 2.6, 5.0, held),
        Event("c0", contact, "state", 0.5, 0.52, {"a": "cup", "b": "other_hand"}),
        *(Event(f"c{k}", contact, "state", 6 + 0.2 * k, 6.1 + 0.2 * k, {"a": "cup", "b": "table"}) for k in range(1, 8)),
        Event("h1", grasp, "state", 4.0, 8.0, held | {"gripper": "other_hand"}),
    ]
    names = ("cup", "hand", "other_hand", "table")
    moving = {name: _moving() for name in names[:3]}
    entities = tuple(Entity(name, ("dul:PhysicalObject",)) for name in names)
    events.sort(key=lambda e: (e.start, e.end, e.id))
    return Episode("passed", entities, tuple(events), moving, "hand")


def in_another_format(episode: Episode, folder: Path) -> Path:
    events = [(e.id, e.type, e.start, e.end, e.roles) for e in episode.events]
    tracks = {n: {"times": t.times.tolist(), "poses": t.poses.tolist()} for n, t in episode.tracks.items()}
    data = {"name": episode.name, "things": [e.name for e in episode.entities], "events": events, "tracks": tracks}
    (folder / "demo.mine").write_text(json.dumps(data))
    return folder / "demo.mine"


def changed(episode: Episode) -> list[str]:
    """Which repairs an episode lists, each time."""
    words = ("vanished", "joined", "dropped", "as one hand")
    return [next((word for word in words if word in repair.what), repair.what) for repair in episode.repairs]


# Whoever reads it, it is repaired


def test_a_reader_of_a_plugin_file_gets_the_repairs_of_the_shipped_one(tmp_path: Path, plugin: Plugin) -> None:
    engine = Engine(files=[plugin("mine", READER)])
    found = engine.read_episode(in_another_format(recorded(), tmp_path))
    same(found, engine.read_episode(write_neem(recorded(), tmp_path / "neem")))
    assert sorted(changed(found)) == ["as one hand", "dropped", "joined", "vanished"]
    (held,) = found.of("state", ["cram:GraspState"])
    assert (held.start, held.end, held.roles) == (1.0, 8.0, {"gripper": "hand", "object": "cup"})
    assert not engine.registry.faults


@pytest.mark.parametrize(
    ("blocked", "left"),
    [
        (["episode_repair"], ["as one hand"]),
        (["one_handed"], ["dropped", "joined", "vanished"]),
        (["episode_repair", "one_handed"], []),
    ],
)
def test_a_repair_that_is_blocked_is_not_made(blocked: list[str], left: list[str], tmp_path: Path, plugin: Plugin) -> None:
    engine = Engine(files=[plugin("mine", READER)], blocked=blocked)
    found = engine.read_episode(in_another_format(recorded(), tmp_path))
    assert sorted(changed(found)) == left
    assert (found.events == recorded().events) == (not left)


def test_a_reader_may_leave_undescribed_who_takes_part(tmp_path: Path, plugin: Plugin) -> None:
    engine = Engine(files=[plugin("mine", READER)])
    states = recorded()
    ghostly = Episode("ghost", (), states.events, {"hand": states.tracks["hand"]}, "hand")
    found = engine.read_episode(in_another_format(ghostly, tmp_path))
    assert found.pose_at("cup", 1.0) is None
    assert "as one hand" in changed(found) and not engine.registry.faults


REPAIRS = """
def said(name):
    def repair(episode):
        return replace(episode, repairs=(*episode.repairs, Repair(name, (0.0, 0.0), str(len(episode.events)))))
    return repair

@hookimpl
def episode_repairs():
    return [EpisodeRepair(name, order, said(name)) for name, order in (("late", 99), ("between", 25), ("early", 5))]
"""


def test_repairs_are_made_once_each_and_in_order(tmp_path: Path, plugin: Plugin) -> None:
    engine = Engine(files=[plugin("further", REPAIRS)])
    found = engine.read_episode(write_neem(recorded(), tmp_path / "neem"))
    assert changed(found) == ["early", "vanished", "dropped", "joined", "between", "as one hand", "late"]
    seen = [int(r.why) for r in found.repairs if r.what in ("early", "between")]
    assert seen[0] == len(recorded().events) > seen[1]


BAD_REPAIRS = {
    "raises": ("raise RuntimeError('no idea')", "RuntimeError: no idea (worse.py:"),
    "gives text": ("return 'better'", "episode_repairs gives Episode, not 'better'"),
    "gives nothing": ("return None", "episode_repairs gives Episode, not None"),
    "gives wrong events": (
        "return replace(episode, events=({'start': 1},))",
        "gives an Episode whose 'events' have {'start': 1}, which is no Event",
    ),
}


@pytest.mark.heavy
@pytest.mark.parametrize("what", BAD_REPAIRS)
def test_a_repair_that_fails_changes_nothing_and_is_named(what: str, tmp_path: Path, plugin: Plugin, run: Run) -> None:
    body, says = BAD_REPAIRS[what]
    text = f"def worse(episode):\n    {body}\n\n@hookimpl\ndef episode_repairs():\n    return [EpisodeRepair('worse', 1, worse)]\n"
    path, file = write_neem(recorded(), tmp_path / "neem"), plugin("worse", text)
    engine = Engine(files=[file])
    same(engine.read_episode(path), Engine().read_episode(path))
    (fault,) = engine.registry.faults
    assert (fault.plugin, fault.hook, fault.designator) == ("worse", "episode_repairs", "worse")
    assert says in fault.error
    ran = run("interpret", path, "--plugin", file)
    assert ran.code == 0 and "warning: plugin 'worse', hook episode_repairs, at worse" in ran.err
    assert run("interpret", path).err == ""


@pytest.mark.parametrize(
    ("declared", "says"),
    [
        ("EpisodeRepair('mine', 'early', id)", "'order' is 'early'; it must be a number"),
        ("EpisodeRepair('mine', 1, 'repair')", "'repair' is 'repair'; it must be a function"),
        ("ReportSection('mine', 1, id)", "has no 'name'"),
    ],
)
def test_a_repair_that_is_declared_wrongly_is_refused(declared: str, says: str, plugin: Plugin) -> None:
    with pytest.raises(UserError, match=says):
        Engine(files=[plugin("mine", f"@hookimpl\ndef episode_repairs():\n    return [{declared}]\n")])


def test_two_repairs_of_one_name_are_refused(plugin: Plugin, tmp_path: Path) -> None:
    text = "@hookimpl\ndef episode_repairs():\n    return [EpisodeRepair('flicker', 1, lambda e: e)]\n"
    with pytest.raises(PluginError, match="'mine' and 'episode_repair' both declare"):
        Engine(files=[plugin("mine", text)]).read_episode(write_neem(recorded(), tmp_path / "neem"))


# Answers are checked

WRONG = {
    "text": ("return 'an episode'", "gives Episode, not 'an episode'"),
    "a generator": ("yield 1", "gives Episode, not <generator"),
    "an episode of something else": ("return Episode('x', ('cup',), ())", "'entities' have 'cup', which is no Entity"),
    "an exception": ("raise RuntimeError('no disk')", "RuntimeError: no disk"),
}


@pytest.mark.heavy
@pytest.mark.parametrize("what", WRONG)
def test_a_reader_that_answers_wrongly_is_named(what: str, tmp_path: Path, plugin: Plugin, run: Run) -> None:
    body, says = WRONG[what]
    file = plugin("wrong", f"@hookimpl\ndef read_episode(path):\n    {body}\n")
    (tmp_path / "demo.mine").write_text("")
    ran = run("interpret", tmp_path / "demo.mine", "--plugin", file)
    assert ran.code == 3
    assert "demo.mine' is in no format that a plugin reads" in ran.err
    assert "plugin 'wrong', hook read_episode, at" in ran.err and says in ran.err
    path = write_neem(recorded(), tmp_path / "neem")
    others = run("interpret", path, "--plugin", file)
    assert (others.code, others.out) == (0, run("interpret", path).out)
    assert "warning: plugin 'wrong', hook read_episode" in others.err


@pytest.mark.parametrize("what", WRONG)
def test_a_detection_that_answers_wrongly_is_named(what: str, plugin: Plugin) -> None:
    body, says = WRONG[what]
    file = plugin("wrong", f"@hookimpl\ndef detect_events(rollout, name):\n    {body}\n")
    engine = Engine(files=[file])
    assert engine.knowledge.episodes.detect(rollout(), "x").of("state")  # the shipped one's
    (fault,) = engine.registry.faults
    assert (fault.plugin, fault.hook, fault.designator) == ("wrong", "detect_events", "x") and says in fault.error
    with pytest.raises(PluginError, match=r"No plugin detects the events of 'x'.*plugin 'wrong', hook detect_events, at x"):
        Engine(files=[file], blocked=["event_detection"]).knowledge.episodes.detect(rollout(), "x")


@pytest.mark.parametrize("body", ["return str(path)", "raise RuntimeError('no disk')"])
def test_a_writer_that_answers_wrongly_is_named(body: str, plugin: Plugin, tmp_path: Path) -> None:
    file = plugin("wrong", f"@hookimpl\ndef write_episode(episode, path):\n    {body}\n")
    engine = Engine(files=[file])
    assert engine.knowledge.episodes.write(recorded(), tmp_path / "neem") == tmp_path / "neem"
    same(engine.read_episode(tmp_path / "neem"), Engine().read_episode(tmp_path / "neem"))
    assert [(f.plugin, f.hook) for f in engine.registry.faults] == [("wrong", "write_episode")]
    with pytest.raises(PluginError, match=r"No plugin writes the episode 'passed' to .*plugin 'wrong', hook write_episode"):
        Engine(files=[file], blocked=["neem"]).knowledge.episodes.write(recorded(), tmp_path / "none")
    assert not (tmp_path / "none").exists()


# Who detects and who writes

OWN = """
@hookimpl
def detect_events(rollout, name):
    return Episode(f"{name} of mine", (), (), {}, rollout.effector)

@hookimpl
def write_episode(episode, path):
    path.mkdir()
    (path / "mine.txt").write_text(episode.name)
    return path
"""


def test_a_plugin_may_detect_and_write(plugin: Plugin, tmp_path: Path, run: Run) -> None:
    (tmp_path / "nap.script").write_text("def p():\n  sleep(0.1)\nend\n")
    words = ("execute", tmp_path / "nap.script", "--world", "tasks/holding")
    assert run(*words, "--out", tmp_path / "own", "--plugin", plugin("own", OWN)).code == 0
    assert (tmp_path / "own" / "episode" / "mine.txt").read_text() == "nap of mine"
    assert run(*words, "--out", tmp_path / "shipped").code == 0
    found = Engine().read_episode(tmp_path / "shipped" / "episode")
    assert found.name == "nap" and found.of("state", ["soma:SupportState"])
    for blocked, says in (("event_detection", "No plugin detects the events"), ("neem", "No plugin writes the episode")):
        ran = run(*words, "--out", tmp_path / blocked, "--block", blocked)
        assert ran.code == 2 and says in ran.err
        assert not (tmp_path / blocked / "episode").exists()


def test_a_folder_is_read_once_until_a_file_in_it_changes(tmp_path: Path) -> None:
    folder, engine = tmp_path / "told", Engine()
    write_neem(recorded(), folder)
    read = engine.knowledge.episodes.read
    first = read(folder)
    assert read(folder) is first
    assert Engine().knowledge.episodes.read(folder) is not first  # two engines share nothing
    (folder / "more.txt").write_text("more")
    again = read(folder)
    assert again is not first
    same(again, first)
    for k in range(6):
        write_neem(recorded(), tmp_path / f"other{k}")
        read(tmp_path / f"other{k}")
    assert read(folder) is not again  # few are kept


def test_a_writer_may_leave_a_path_to_others(plugin: Plugin, tmp_path: Path) -> None:
    text = "@hookimpl\ndef write_episode(episode, path):\n    return None if path.suffix != '.mine' else path\n"
    engine = Engine(files=[plugin("mine", text)])
    assert engine.knowledge.episodes.write(recorded(), tmp_path / "a.mine") == tmp_path / "a.mine"
    assert not (tmp_path / "a.mine").exists()  # this one writes nothing
    engine.knowledge.episodes.write(recorded(), tmp_path / "a.nt")
    assert engine.read_episode(tmp_path / "a.nt").events
