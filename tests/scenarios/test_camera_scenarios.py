"""Scenarios whose poses come from a camera, as a user runs them, and their negative siblings."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.as_a_user import changed, cramlite
from helpers.flat_steps import flat
from msgspec.structs import replace

from cramlite import Engine, NoSolution, read_scenario
from cramlite.model import Action, Motion, Object, Pose, World
from cramlite.perception.recognition import renamed
from cramlite.plugin import UserError

SCENARIOS = Path(__file__).parents[2] / "scenarios"
FETCH = SCENARIOS / "fetch_from_hanger_camera.yaml"
variant = partial(changed, FETCH)


@pytest.mark.heavy
def test_a_product_that_was_only_seen_is_fetched(tmp_path: Path) -> None:
    done = cramlite("resolve", "fetch_from_hanger_camera", "--seed", "1", "--out", tmp_path / "run", "--no-report", "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert re.fullmatch(r"[a-z]+_\d", summary["objects"]["object_1"]), "named by perception, not by the scenario"
    text = (tmp_path / "run" / "program.script").read_text()
    header = text.partition("# ---- functions")[0]
    seen = summary["objects"]["object_1"]
    assert re.search(rf"{seen}: p\[.*\], camera: \w+ by expert plausibility, confidence 0\.\d+, 0\.0 s old", header)
    assert re.search(r"basket: p\[.*\], known from the scenario", header)
    assert text.index("0.LookingFor_1") < text.index("1.Grasping")
    for name in ("first", "second", "third"):  # what the simulator calls them
        assert name not in text.replace("cramlite: first", "")


def test_a_camera_that_sees_no_product_gives_no_program(tmp_path: Path) -> None:
    blind = variant(tmp_path, ("mount: flange", "mount: world"), ("[0, 90 mm, 30 mm]", "[0, 0, 2.0]"))
    done = cramlite("resolve", blind, "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 1, done.stderr
    assert "object_1" in done.stderr


def test_poses_from_a_camera_need_one(tmp_path: Path) -> None:
    text = FETCH.read_text()
    start, end = text.index("camera:\n"), text.index("# Poses and classes")
    path = tmp_path / "no_camera.yaml"
    path.write_text(text[:start] + text[end:])
    with pytest.raises(UserError, match="'poses: camera' needs a 'camera'"):
        read_scenario(path)


def test_a_view_that_the_arm_cannot_reach_says_why(tmp_path: Path) -> None:
    far = variant(tmp_path, ("position: [0.86, 0.18, 0.45]", "position: [2.86, 0.18, 0.45]"))
    with pytest.raises(NoSolution, match="camera cannot be brought to a view of left_hook"):
        Engine().setting(read_scenario(far))


@pytest.fixture(scope="module")
def world() -> World:
    scenario = read_scenario(FETCH)
    from cramlite.scenario.worlds import build_world

    return build_world(scenario, scenario.spec.things, (), Engine().knowledge, 0)[0]


def test_the_validator_finds_the_real_thing_by_its_place(world: World) -> None:
    second = world.thing("second")
    seen = replace(second, name="coffeepack_1", pose=Pose((0.003, 0, 0)) * second.pose)
    believed = replace(world, things=(*(t for t in world.things if not t.movable), seen))
    real = renamed(world, believed)
    assert real.thing("coffeepack_1").pose == second.pose
    assert {t.name for t in real.things if t.movable} == {"first", "coffeepack_1", "third"}


def test_a_thing_that_is_nowhere_has_no_real_one(world: World) -> None:
    ghost = replace(world.thing("second"), name="third", pose=Pose((0.3, 0.3, 0.3)))
    believed = replace(world, things=(*(t for t in world.things if not t.movable), ghost))
    real = renamed(world, believed)
    assert "third" not in {t.name for t in real.things}
    assert "unseen_third" in {t.name for t in real.things}


def test_a_thing_that_was_taken_for_something_else_is_an_objection(world: World) -> None:
    """The validator reads three fields of a candidate: the world, the run's world, and the actions."""
    from cramlite_plugins.validators.recognition import Recognised

    action = Action("1.Grasping", "soma:Grasping", {"Patient": Object("object_1", entity="second")})
    wrong = World(tuple(replace(t, type="cram:TeaBox") if t.name == "second" else t for t in world.things))
    gone = World(tuple(t for t in world.things if t.name != "second"))

    def objections(real: World) -> list[str]:
        candidate = SimpleNamespace(world=world, ran=SimpleNamespace(world=real), actions=(action,))
        return [f.reason for f in Recognised().check(candidate)]  # type: ignore[arg-type]

    assert objections(world) == []
    assert objections(wrong) == ["'second', which was taken for a cram:CoffeePack, is a cram:TeaBox"]
    assert objections(gone) == ["'second', which was taken for a cram:CoffeePack, is not there"]


def test_a_run_records_where_its_cameras_are(world: World) -> None:
    """A fixed one stands still, one on a flange moves with it; a robot that is not there carries none."""
    from cramlite.model import Camera
    from cramlite_plugins.episodes.detection.entities import camera_entities
    from cramlite_plugins.simulation.model.compile import compile_world
    from cramlite_plugins.simulation.recording.recorder import Recorder

    above = Camera(Pose((0.4, 0, 1.5), (0, 1, 0, 0)))
    flange, lost = (replace(above, pose=Pose((0, 0.09, 0.03)), mount=name) for name in ("arm", "nobody"))
    compiled = compile_world(replace(world, cameras=(above, flange, lost)), Engine().knowledge.robots)
    recorder, data = Recorder(compiled, "arm"), compiled.data()
    recorder.observe(data)
    rollout = recorder.rollout()
    assert tuple(rollout.poses["world/camera"][0]) == (*above.pose.position, *above.pose.quaternion)
    there = Pose(tuple(rollout.poses["arm/camera"][0][:3]), tuple(rollout.poses["arm/camera"][0][3:]))
    hand = Pose(tuple(rollout.poses["effector"][0][:3]), tuple(rollout.poses["effector"][0][3:]))
    tcp = Engine().knowledge.robots["ur5e"].gripper.tcp
    assert there.distance(hand * tcp.inverse() * flange.pose)[0] < 1e-6
    assert [(e.name, e.part_of) for e in camera_entities(rollout)] == [("world/camera", None), ("arm/camera", "arm")]


BROKEN = """
from cramlite.plugin import Expert, hookimpl

def divide(inputs):
    return {"hypotheses": 1 / 0}

@hookimpl
def experts():
    return [Expert("hasty", "breaks", ("clean",), ("hypotheses",), divide, "object", cost_ms=0.01)]
"""


@pytest.mark.heavy
def test_a_broken_expert_is_named_and_the_next_one_answers(tmp_path: Path) -> None:
    (tmp_path / "hasty.py").write_text(BROKEN)
    done = cramlite(
        "perceive", "fetch_from_hanger_camera", "--query", "colour=red on=hook", "--plugin", tmp_path / "hasty.py"
    )
    assert done.returncode == 1, "nothing red hangs there"
    done = cramlite(
        "perceive", "fetch_from_hanger_camera", "--query", "type=cram:CoffeePack", "--plugin", tmp_path / "hasty.py"
    )
    assert done.returncode == 0, done.stderr
    assert "plugin 'hasty'" in done.stderr and "ZeroDivisionError" in done.stderr
    assert "pose: [0.7" in done.stdout


@pytest.mark.heavy
def test_perceive_answers_and_writes_a_page(tmp_path: Path) -> None:
    done = cramlite("perceive", "fetch_from_hanger_camera", "--query", "colour=red on=Hanger", "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert [a["values"]["type"]["value"] for a in found["answers"]] == ["cram:CocoaBox"]
    pose = found["answers"][0]["values"]["pose"]
    assert pose["expert"] == "plausibility" and abs(pose["value"]["position"][1] + 0.18) < 0.005
    page = (tmp_path / "perception.html").read_text()
    assert "data:image/png;base64," in page and "hsv_colour" in page and "CocoaBox" in page
    assert not re.search(r'(src|href)="https?:', page)


@pytest.mark.parametrize(
    ("query", "code", "said"),
    [
        ("colour=purple on=Hanger", 1, "nothing found for 'colour=purple on=Hanger': object"),
        ("type=cram:TeaBxo", 2, "did you mean 'cram:TeaBox'"),
        ("colour=mauve", 1, "'hsv_colour' never gives colour 'mauve'; its values are: red, orange"),
        ("weight=3", 2, "a query cannot ask for 'weight'"),
    ],
)
def test_questions_without_an_answer_say_why(query: str, code: int, said: str) -> None:
    done = cramlite("perceive", "fetch_from_hanger_camera", "--query", query, "--attributes", "type")
    assert done.returncode == code
    assert said in done.stdout + done.stderr


def test_a_scenario_without_a_camera_cannot_be_looked_at() -> None:
    done = cramlite("perceive", "fetch_from_hanger")
    assert done.returncode == 2
    assert "has no camera" in done.stderr and "add 'camera: {mount: flange}'" in done.stderr


@pytest.mark.parametrize(("sigma", "beyond"), [(0.0, 0.015), (0.002, 0.015), (0.004, 0.015), (0.006, 0.021)])
def test_a_peg_that_is_less_surely_known_is_felt_for_further(world: World, sigma: float, beyond: float) -> None:
    """15 mm at least; three standard deviations and the tip's 3 mm where that is more."""
    from cramlite.model import Estimate, Held, initial_belief
    from cramlite_plugins.tasks.insert_hole_onto_peg import InsertHoleOntoPeg

    belief = initial_belief(world, "arm", (0.0,) * 6, 0.08).grasped(Held("second", Pose(), 0.05))
    poses = {**belief.poses, "hook": Estimate(world.thing("hook").pose, sigma, "camera")}
    roles = {"Locatum": Object("held", entity="second"), "Relatum": Object("peg", entity="hook/peg")}
    action = Action("1.InsertHoleOntoPeg", "artm:InsertHoleOntoPeg", roles)
    (way,) = InsertHoleOntoPeg().decompose(action, replace(belief, poses=poses))
    touch = next(s for s in flat(way.steps) if s.name.endswith("/touch"))
    assert isinstance(touch, Motion)
    assert touch.parameters["beyond_m"] == pytest.approx(beyond)


@pytest.mark.parametrize(("peg", "said"), [("left_hook/peg", ""), ("hook/peg", "hangs on 'left_hook', not on 'hook'")])
def test_a_product_is_taken_off_the_hanger_that_it_hangs_on(world: World, peg: str, said: str) -> None:
    """Else each grasp was planned for each of the wrong hangers: 170 grasps of one seed."""
    from cramlite.model import Held, initial_belief
    from cramlite.plugin import Unresolvable
    from cramlite_plugins.tasks.extract_hole_from_peg import ExtractHoleFromPeg

    hangs = ("hangs_on", "first", "left_hook")
    belief = initial_belief(world, "arm", (0.0,) * 6, 0.08, [hangs]).grasped(Held("first", Pose(), 0.05))
    parts = {"Locatum": Object("object_1", entity="first"), "Relatum": Object("object_3", part_of="object_2", entity=peg)}
    action = Action("3.ExtractHoleFromPeg", "artm:ExtractHoleFromPeg", parts)
    if not said:
        assert len(list(ExtractHoleFromPeg().decompose(action, belief))) == 2
        return
    with pytest.raises(Unresolvable, match=said) as refused:
        list(ExtractHoleFromPeg().decompose(action, belief))
    assert refused.value.because == ("object_1", "object_3", "object_2")


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("mount: flange", (385.0, 385.0, 319.5, 239.5, 640, 480)),
        ("width: 320\n  height: 240", (192.5, 192.5, 159.5, 119.5, 320, 240)),
        ("width: 200\n  height: 100\n  horizontal_fov: 90 deg", (100.0, 100.0, 99.5, 49.5, 200, 100)),
        ("intrinsics: {fx: 600, fy: 590, cx: 330, cy: 250}", (600, 590, 330, 250, 640, 480)),
    ],
)
def test_a_camera_is_as_the_scenario_says(written: str, expected: tuple[float, ...], tmp_path: Path) -> None:
    from cramlite.scenario.worlds import camera_of

    camera = camera_of(read_scenario(variant(tmp_path, ("mount: flange", written))))
    assert camera is not None and camera.noise
    own = camera.intrinsics
    assert (own.fx, own.fy, own.cx, own.cy, own.width, own.height) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("horizontal_fov: 90 deg\n  intrinsics: {fx: 600, fy: 590, cx: 330, cy: 250}", "'horizontal_fov' or 'intrinsics', not both"),
        ("horizontal_fov: 190 deg", "no pinhole camera sees 190 degrees"),
        ("intrinsics: {fx: 600, fy: 590, cx: 900, cy: 250}", "outside the image of 640 x 480"),
        ("intrinsics: {fx: 600, fy: 0, cx: 300, cy: 250}", "greater than 0"),
        ("width: 3", "greater than or equal to 16"),
        ("widht: 640", "did you mean 'width'"),
    ],
)
def test_what_is_no_camera_is_refused(written: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=said):
        read_scenario(variant(tmp_path, ("mount: flange", written)))


def test_a_camera_without_noise_measures_exactly(world: World) -> None:
    from cramlite.model import Camera, Intrinsics

    knowledge = Engine().knowledge
    camera = Camera(Pose((0.2, 0, 1.0), (0, 1, 0, 0)), intrinsics=Intrinsics.from_field_of_view(64, 48), noise=False)
    views = [
        knowledge.simulator.look(world, knowledge.robots, replace(camera, noise=noise), seed=s)
        for noise, s in ((False, 1), (False, 2), (True, 1), (True, 2))
    ]
    assert views[0].depth.shape == (48, 64)
    same = [np.array_equal(a.depth, b.depth, equal_nan=True) for a, b in (views[:2], views[2:])]
    assert same == [True, False]
