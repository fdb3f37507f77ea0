"""Kinds with a print: which of ten cartons of one size, where, which way round; and what is none of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.as_a_user import cramlite
from helpers.printed_box import labelled_can, printed_box, tiles

from cramlite import Engine
from cramlite.model import Camera, Intrinsics, Pose, Thing, View, World, replace
from cramlite.perception.active_perception import ask
from cramlite.perception.query import parse_query
from cramlite.perception.result import Perceived
from cramlite.plugin import UNKNOWN
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.perception.kinds import appearance
from cramlite_plugins.perception.kinds.agreement import Picture, agreement, best_by_print, edged
from cramlite_plugins.perception.kinds.appearance import _made, appearance_of
from cramlite_plugins.perception.kinds.explain import PARAMETERS
from cramlite_plugins.perception.kinds.kept import file_of
from cramlite_plugins.perception.kinds.possible import possible
from cramlite_plugins.perception.kinds.reading import Reading, Scene
from cramlite_plugins.perception.kinds.region import Region
from cramlite_plugins.perception.kinds.registered import Ranked, full_readings, pose_batch
from cramlite_plugins.perception.kinds.samples import sampled
from cramlite_plugins.perception.kinds.standing import standing as upright
from cramlite_plugins.simulation.camera.depth_camera import look

SIZE = (0.07, 0.045, 0.11)
CAMERA = Intrinsics(500.0, 500.0, 255.5, 191.5, 512, 384)


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    """An engine that knows ten cartons."""
    folder = tmp_path_factory.mktemp("cartons")
    for k in range(10):
        (folder / f"carton_{k}").mkdir()
        printed_box(folder / f"carton_{k}" / f"carton_{k}.glb", SIZE, tiles(k))
    assert cramlite("library", "add", folder, "--out", folder / "lib").returncode == 0
    return Engine(models=[folder / "lib"])


def standing(engine: Engine, kind: str, x: float, y: float, yaw: float) -> Thing:
    """A carton on the table; yaw [deg]."""
    pose = Pose.from_rotvec((x, y, SIZE[2] / 2), (0, 0, math.radians(yaw)))
    return engine.knowledge.models[kind].make(name=f"a_{kind}", pose=pose)


def lying(engine: Engine, kind: str, position: tuple[float, float, float], yaw: float) -> Thing:
    """A carton on its back; yaw [deg]."""
    pose = Pose.from_rotvec(position, (0, 0, math.radians(yaw))) * Pose.from_rotvec((0, 0, 0), (math.pi / 2, 0, 0))
    return engine.knowledge.models[kind].make(name=f"a_{kind}", pose=pose)


def pictured(*things: Thing, seed: int = 1) -> View:
    """A noisy picture of things on a table from 0.7 m away."""
    eye, target = np.array((1.0, 0.0, 0.55)), np.array((0.45, 0.0, 0.05))
    camera = Camera(Pose.from_axes(tuple(eye), target - eye, np.cross(target - eye, (0, 0, 1))), intrinsics=CAMERA)
    table = make("table", "table", Pose((0.45, 0, 0)), {})
    return look(World((table, *things)), {}, camera, seed=seed)


def perceived(engine: Engine, *things: Thing, seed: int = 1, fixtures: tuple[Thing, ...] = ()) -> Perceived:
    """What such a picture is taken for."""
    knowledge = engine.knowledge
    query = replace(parse_query("", knowledge.taxonomy, knowledge.experts), wanted=("type", "pose", "model", "instance"))
    return ask(query, pictured(*things, seed=seed), fixtures, knowledge)


def answered(found: Perceived) -> dict[str, Pose]:
    """Models that were recognised, with their poses."""
    return {p.value("model"): p.value("pose") for p in found.answers if p.value("type") != UNKNOWN and p.value("pose")}


def apart(pose: Pose, thing: Thing) -> tuple[float, float]:
    """How far a pose is from that of a thing [m, deg], no symmetry allowed."""
    metres, turn = pose.distance(thing.pose)
    return metres, math.degrees(turn)


def test_the_print_tells_cartons_of_one_size_and_the_way_round(engine: Engine) -> None:
    things = [standing(engine, "carton_3", 0.40, -0.13, 20), standing(engine, "carton_7", 0.46, 0.05, 250)]
    found = answered(perceived(engine, *things))
    assert found.keys() == {"carton_3", "carton_7"}
    for thing, kind in zip(things, ("carton_3", "carton_7"), strict=True):
        metres, degrees = apart(found[kind], thing)
        assert metres < 0.005 and degrees < 6


def test_the_label_tells_the_turn_of_a_can_that_is_not_quite_round(tmp_path: Path) -> None:
    """It is turned about the middle of its box, 3 mm beside its axis, so that its turns fit the picture only once they are registered."""
    (tmp_path / "tin").mkdir()
    labelled_can(tmp_path / "tin" / "tin.glb", 0.033, 0.08, 0.006, np.concatenate(tiles(5), axis=1))
    assert cramlite("library", "add", tmp_path / "tin", "--out", tmp_path / "lib").returncode == 0
    tin = Engine(models=[tmp_path / "lib"]).knowledge.models["tin"]
    thing, known = tin.make(name="a_tin", pose=Pose((0.45, 0, 0.04))), appearance_of(tin.make(name="c", pose=Pose()))
    view = pictured(thing)
    points = view.world_cloud
    mask = view.valid & (points[..., 2] > 0.004) & (np.abs(points[..., :2] - (0.45, 0)) < 0.06).all(axis=-1)
    scene = Scene(Picture.of(view), points, (known,), {p.name: p.default for p in PARAMETERS}, mask)
    for turn in (60, 120):
        wrong = Pose.from_rotvec((0.45, 0, 0.04), (0, 0, math.radians(turn)))
        begun = Ranked(Reading(known, wrong, 0.8, 0.8), pose_batch(scene, [wrong]))
        found = max(full_readings(Region(scene, mask), begun, upright(known)), key=lambda r: r.score)
        assert apart(found.pose, thing)[1] < 5


def test_the_best_pose_by_print_is_that_of_all_poses(engine: Engine) -> None:
    """Poses are not looked at where their shape alone rules them out, which changes nothing."""
    thing = standing(engine, "carton_3", 0.42, 0.0, 20)
    picture, carton = Picture.of(pictured(thing)), appearance_of(engine.knowledge.models["carton_3"].make(name="c", pose=Pose()))
    poses = [thing.pose * Pose.from_rotvec((0.004 * (k % 3), 0, 0), (0, 0, math.radians(30 * k))) for k in range(12)]
    whole = np.ones(picture.view.depth.shape, bool)
    colours = agreement(picture, whole, carton, poses)
    for seed in range(5):
        fits = np.random.default_rng(seed).uniform(0.3, 1.0, len(poses))
        k, colour = best_by_print(picture, whole, carton, poses, fits)
        assert k == int((fits * fits * colours).argmax()) and colour == pytest.approx(colours[k])


@pytest.mark.heavy
def test_what_is_not_in_the_library_is_unknown(engine: Engine, tmp_path: Path) -> None:
    other = printed_box(tmp_path / "other.glb", SIZE, tiles(77))
    stranger = make("mesh", "stranger", Pose((0.42, 0.10, SIZE[2] / 2)), {"file": str(other), "mass": 0.2})
    can = make("can", "can", Pose((0.45, -0.12, 0.05)), {"rgba": (0.95, 0.95, 0.95, 1.0)})
    known = standing(engine, "carton_5", 0.48, 0.0, 40)
    found = perceived(engine, stranger, can, known)
    assert answered(found).keys() == {"carton_5"}
    assert sum(p.value("type") == UNKNOWN for p in found.answers) >= 2


@pytest.mark.heavy
def test_touching_cartons_are_told_apart(engine: Engine) -> None:
    things = [standing(engine, "carton_1", 0.45, -0.036, 0), standing(engine, "carton_2", 0.45, 0.011, 0)]
    found = answered(perceived(engine, *things))
    assert found.keys() == {"carton_1", "carton_2"}
    assert all(apart(found[k], t)[0] < 0.008 for k, t in zip(("carton_1", "carton_2"), things, strict=True))


@pytest.mark.heavy
def test_a_tilted_carton_has_its_tilt(engine: Engine) -> None:
    tilted = Pose.from_rotvec((0.45, 0.0, 0.065), (0.45, 0.3, 0.2))
    thing = replace(standing(engine, "carton_4", 0, 0, 0), pose=tilted)
    found = answered(perceived(engine, thing))
    assert found.keys() == {"carton_4"}
    metres, degrees = apart(found["carton_4"], thing)
    assert metres < 0.006 and degrees < 8


@pytest.mark.heavy
def test_doubtful_kinds_come_with_probabilities(engine: Engine) -> None:
    (percept,) = perceived(engine, standing(engine, "carton_8", 0.45, 0.0, 30)).answers
    said = percept.values["pose"].judged
    assert 0.5 < said.confidence <= 1.0
    assert "of its printed texture agrees" in said.reason
    kinds = percept.values["type"].judged
    assert kinds.confidence + sum(o.confidence for o in kinds.others) == pytest.approx(1.0, abs=0.05)


def test_a_thing_is_called_after_its_kind_where_the_class_tells_no_kind(engine: Engine) -> None:
    (percept,) = perceived(engine, standing(engine, "carton_3", 0.45, 0.0, 30)).answers
    assert percept.value("instance") == "carton_3_1"


@pytest.mark.heavy
def test_furniture_that_the_map_has_is_no_thing(engine: Engine) -> None:
    post = make("block", "post", Pose((0.42, -0.12, 0.06)), {"size": (0.06, 0.06, 0.12)})
    carton = standing(engine, "carton_5", 0.46, 0.06, 40)
    unmapped, mapped = perceived(engine, post, carton), perceived(engine, post, carton, fixtures=(post,))
    assert sum(p.value("type") == UNKNOWN for p in unmapped.answers) == 1
    assert [p.value("model") for p in mapped.answers] == ["carton_5"]


def test_a_thing_ends_at_an_edge_and_a_piece_of_a_face_does_not(engine: Engine) -> None:
    carton = standing(engine, "carton_3", 0.45, 0.0, 20)
    own = appearance_of(engine.knowledge.models["carton_3"].make(name="carton_3", pose=Pose()))
    wall = make("block", "wall", Pose((0.40, 0.0, 0.15)), {"size": (0.02, 0.5, 0.3)})
    front = replace(carton, pose=Pose((0.41 - SIZE[0] / 2, 0.0, 0.15)))
    there, nowhere = Picture.of(pictured(carton)), Picture.of(pictured(wall))
    whole = np.ones(there.view.depth.shape, bool)
    assert edged(there, whole, own, carton.pose) > 0.5 > edged(nowhere, whole, own, front.pose)


@pytest.mark.heavy
def test_nothing_is_recognised_within_furniture(engine: Engine) -> None:
    carton = standing(engine, "carton_5", 0.46, 0.06, 40)
    around = make("block", "around", Pose((carton.pose.position[0] - 0.06, 0.06, 0.06)), {"size": (0.16, 0.3, 0.2)})
    assert answered(perceived(engine, carton)).keys() == {"carton_5"}
    assert not answered(perceived(engine, carton, fixtures=(around,)))


def test_without_a_print_segmentation_is_as_before(engine: Engine) -> None:
    plain = Engine()
    tea = plain.knowledge.models["tea_box"].make(name="tea", pose=Pose((0.45, 0, 0.065)))
    found = perceived(plain, tea)
    assert [p.value("type") for p in found.answers] == ["cram:TeaBox"]
    assert "printed_things" not in {r.expert for r in found.runs}


@pytest.mark.heavy
def test_the_robot_itself_is_no_thing(engine: Engine) -> None:
    view = pictured(standing(engine, "carton_3", 0.45, 0.0, 20))
    knowledge = engine.knowledge
    query = replace(parse_query("", knowledge.taxonomy, knowledge.experts), wanted=("type", "pose", "model"))
    somewhere, there = (np.full(view.depth.shape, np.nan) for _ in range(2))
    there[:] = view.depth + 0.055  # so far behind that no pixel is cut out as the robot's own, and within the carton
    assert answered(ask(query, view, (), knowledge, robot=somewhere)).keys() == {"carton_3"}
    assert not answered(ask(query, view, (), knowledge, robot=there))


@pytest.mark.parametrize("damaged", [False, True])
def test_a_known_kind_is_the_same_from_what_was_kept_and_made_anew(
    engine: Engine, damaged: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CRAMLITE_CACHE", str(tmp_path))
    model = standing(engine, "carton_3", 0.4, 0.0, 0.0)
    found = []
    for _ in range(2):
        _made.cache_clear()
        found.append(appearance_of(model))
        file = file_of(model.mesh)
        assert file is not None and file.is_file() and file.is_relative_to(tmp_path)
        if damaged:
            file.write_bytes(file.read_bytes()[:1000])
        monkeypatch.setattr(appearance, "sampled", sampled if damaged else None)  # which a kept kind needs no more
    made, again = found
    assert made.surface.symmetries == again.surface.symmetries and made.up == again.up
    tables = [(a.surface.points, a.surface.grid.index, a.surface.opposite_points, a.colours, a.sides) for a in found]
    assert all(np.array_equal(one, other) for one, other in zip(*tables, strict=True))


def test_a_known_kind_without_a_writable_cache_is_made_anew(engine: Engine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("CRAMLITE_CACHE", str(tmp_path / "file"))
    _made.cache_clear()
    assert appearance_of(standing(engine, "carton_4", 0.4, 0.0, 0.0)).printed


def test_a_carton_is_known_by_the_strip_that_another_one_leaves_of_it(engine: Engine) -> None:
    table = make("table", "table", Pose((0.45, 0, 0)), {})
    below = lying(engine, "carton_3", (0.45, 0.0, SIZE[1] / 2), 0)
    above = lying(engine, "carton_7", (0.43, 0.0, 1.5 * SIZE[1]), 90)
    found = answered(perceived(engine, below, above, fixtures=(table,)))
    assert found.keys() == {"carton_3", "carton_7"}
    for kind, thing in (("carton_3", below), ("carton_7", above)):
        metres, degrees = apart(found[kind], thing)
        assert metres < 0.004 and degrees < 4


def test_a_model_is_possible_on_a_table_and_not_in_it(engine: Engine) -> None:
    table = make("block", "table", Pose((0.45, 0.0, -0.05)), {"size": (0.8, 0.8, 0.1)})
    on, within = standing(engine, "carton_3", 0.45, 0.0, 20), standing(engine, "carton_3", 0.45, 0.0, 20)
    within = replace(within, pose=Pose((0.0, 0.0, -0.03)) * within.pose)
    view, own = pictured(on), appearance_of(engine.knowledge.models["carton_3"].make(name="c", pose=Pose()))
    limits = {p.name: p.default for p in PARAMETERS}
    scene = Scene(Picture.of(view), view.world_cloud, (own,), limits, np.ones(view.depth.shape, bool), (table,))
    points = np.stack([t.pose.apply(own.surface.points[::50]) for t in (on, within)])
    assert possible(scene, own, points).tolist() == [True, False]
