"""A thing of which nobody knows where it is is known once a camera that stands has seen it, and not before."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.task_scenarios import attempted
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Episode, Geom, Pose, Thing, World
from cramlite.model.run.rollout import load_rollout, save_rollout
from cramlite.plugin import Candidate
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulation.recording.sight import Sight

BOX = Thing("box", "cram:TeaBox", Pose((0.0, 0.0, 0.05)), (Geom("box", (0.03, 0.03, 0.05)),), mass=0.2)
FLOOR = Thing("floor", "cram:Table", Pose(), (Geom("box", (1.0, 1.0, 0.01), Pose((0, 0, -0.01))),))
ABOVE = Camera(Pose((0.0, 0.0, 1.0), (0, 1, 0, 0)))


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


@pytest.fixture(scope="module")
def found() -> Candidate:
    candidate, verdict, reasons = attempted("looking_for")
    assert candidate is not None and verdict is not None and verdict.passed, reasons
    return candidate


def sought(engine: Engine, episode: Episode | None) -> set[str]:
    """The things of which the rules say that they were looked for."""
    assert episode is not None
    actions = engine.interpret(episode).actions
    return {m.roles["Patient"] for a in actions for m in a.matches if m.task == "soma:LookingFor"}


def test_the_run_is_read_as_looking_for_what_was_found(engine: Engine, found: Candidate) -> None:
    assert found.rollout is not None and sought(engine, found.episode) == {"coffeepack_1"}
    assert 1.0 < found.rollout.seen["coffeepack_1"] < found.rollout.times[-1]
    moves = [s.origin.split("/")[0] for s in found.program.steps]
    assert moves == ["0.LookingFor_1", "0.LookingFor_2", "1.LookingFor"], "one shelf after the other"


def test_a_run_that_looks_at_one_shelf_only_is_not(engine: Engine, found: Candidate) -> None:
    assert found.rollout is not None
    short = replace(found.program, steps=found.program.steps[:1], sections=found.program.sections[:1])
    text = engine.knowledge.backends[found.robot.backend].emit(short, found.robot).text
    simulator = engine.knowledge.simulator
    rollout = simulator.execute(text, found.rollout.world, engine.knowledge.robots, mount=short.robot, seed=0)
    assert rollout.outcome == "finished" and math.isinf(rollout.seen["coffeepack_1"])
    assert sought(engine, engine.knowledge.episodes.detect(rollout, "short")) == set()


def test_a_run_in_which_poses_are_known_is_not(engine: Engine, found: Candidate) -> None:
    assert found.rollout is not None
    assert sought(engine, detect(replace(found.rollout, seen={}), "known")) == set()


def test_when_things_were_seen_is_kept_in_the_file(found: Candidate, tmp_path: Path) -> None:
    assert found.rollout is not None
    lost = replace(found.rollout, seen={"coffeepack_1": math.inf})
    for rollout in (found.rollout, lost):
        save_rollout(rollout, tmp_path / "rollout.npz")
        assert load_rollout(tmp_path / "rollout.npz", rollout.world).seen == rollout.seen


def seen(world: World, *eyes: Pose, step: float = 0.1) -> float:
    """When a camera that is at one place after another first sees the box."""
    compiled = compile_world(world, {})
    sight, data = Sight(compiled), compiled.data()
    for k, eye in enumerate(eyes):
        sight.look(data, {"world/camera": eye}, k * step)
    return sight.seen.get("box", -1.0)


WORLD = World((FLOOR, BOX), cameras=(ABOVE,), poses="camera")


def test_a_camera_sees_what_is_before_it_and_large_enough() -> None:
    assert seen(WORLD, ABOVE.pose) == 0.0
    assert math.isinf(seen(WORLD, Pose((0, 0, 1.0)))), "it looks up"
    assert math.isinf(seen(WORLD, Pose((0.9, 0, 1.0), (0, 1, 0, 0)))), "beside the image"
    far = [Pose((0, 0, height), (0, 1, 0, 0)) for height in (2.0, 8.0)]
    # 60 mm at 385 pixels: 12 x 12 of them at 2 m, 3 x 3 at 8 m; 60 are needed
    assert [seen(WORLD, eye) for eye in far] == [0.0, math.inf]
    known = replace(WORLD, poses="known")
    assert seen(known, ABOVE.pose) == -1.0


def test_what_stands_before_a_thing_hides_it() -> None:
    board = Thing("board", "cram:Table", Pose((0, 0, 0.5)), (Geom("box", (0.2, 0.2, 0.01)),))
    assert math.isinf(seen(replace(WORLD, things=(*WORLD.things, board)), ABOVE.pose))


def test_a_camera_in_passing_looks_at_nothing() -> None:
    away = Pose((0.9, 0, 1.0), (0, 1, 0, 0))
    passing = [Pose((x, 0, 1.0), (0, 1, 0, 0)) for x in np.linspace(0.9, -0.9, 11)]
    assert math.isinf(seen(WORLD, *passing))
    assert seen(WORLD, away, ABOVE.pose, ABOVE.pose) == pytest.approx(0.2)


def test_the_world_of_a_run_says_whether_poses_are_known(found: Candidate) -> None:
    assert found.rollout is not None and found.rollout.world.poses == "camera"
    other, _, reasons = attempted("reaching")
    assert other is not None and other.rollout is not None, reasons
    assert other.rollout.world.poses == "known" and other.rollout.seen == {}
