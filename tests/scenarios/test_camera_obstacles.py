"""What a camera sees and nobody knows is in the way; what is less surely known is kept farther from."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from helpers.as_a_user import cramlite
from msgspec.structs import replace
from test_camera_scenarios import FETCH, SCENARIOS, variant

from cramlite import Engine, read_scenario
from cramlite.model import Action, Estimate, Held, Object, Plan, Pose, Thing, World, initial_belief
from cramlite.perception.view_queries import queries_of
from cramlite.scenario.worlds import build_world

CLUTTER = (
    "  - {name: clutter, model: block, at: {position: [0.52, -0.24, 0.255]}, with: {size: [0.14, 0.1, 0.5], mass: 2}}\n"
)


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


@pytest.fixture(scope="module")
def furniture(engine: Engine) -> World:
    scenario = read_scenario(SCENARIOS / "hang_onto_hanger_camera.yaml")
    world = build_world(scenario, scenario.spec.things, (), engine.knowledge, 0)[0]
    return replace(world, things=tuple(t for t in world.things if not t.movable))


def cluttered(folder: Path) -> Path:
    """A box of 140 mm by 100 mm by 500 mm that nobody declared stands where the shortest ways home lead."""
    return variant(
        folder,
        ("  - name: basket\n", CLUTTER + "  - name: basket\n"),
        ("poses: camera", "poses: camera\nbudget: {proofs: 1, sequences: 1}"),
    )


@pytest.mark.heavy
def test_unknown_things_are_driven_around(tmp_path: Path) -> None:
    done = cramlite("resolve", cluttered(tmp_path), "--out", tmp_path / "run", "--no-report", "--json")
    assert done.returncode == 0, done.stderr
    assert "thing 'obstacle_1': seen; no known model explains it" in done.stderr
    believed, real = (json.loads((tmp_path / "run" / at / "world.json").read_text()) for at in ("", "execution"))
    assert "clutter" not in json.dumps(believed) and "obstacle_1" in json.dumps(believed), "proven with what was seen"
    assert "clutter" in json.dumps(real), "and executed with the box in its world"


@pytest.mark.heavy
def test_without_the_expert_nobody_knows_of_the_box(tmp_path: Path) -> None:
    """Its program passes the box by chance: since the shortest reading of the demonstration no longer drives home past it."""
    done = cramlite(
        "resolve", cluttered(tmp_path), "--block", "perception_obstacles", "--out", tmp_path / "run", "--no-report"
    )
    assert done.returncode == 0, done.stderr
    believed, real = ((tmp_path / "run" / at / "world.json").read_text() for at in ("", "execution"))
    assert "obstacle_1" not in believed and "clutter" in real


def belief_of(engine: Engine, sigma: float, *, held: bool = False) -> Any:
    scenario = read_scenario(FETCH)
    world = build_world(scenario, scenario.spec.things, (), engine.knowledge, 0)[0]
    belief = initial_belief(world, "arm", engine.knowledge.robots["ur5e"].home, 0.08)
    if held:
        return belief.grasped(Held("second", Pose(), 0.05, sigma))
    return replace(belief, poses={**belief.poses, "second": Estimate(world.thing("second").pose, sigma, "camera")})


@pytest.mark.parametrize(("sigma", "more"), [(0.0, 0.0), (0.002, 0.004), (0.005, 0.01), (0.1, 0.01)])
def test_paths_keep_two_standard_deviations_from_things(engine: Engine, sigma: float, more: float) -> None:
    from cramlite_plugins.motion_planning.reach import uncertainty_margins

    for held in (False, True):
        assert uncertainty_margins(belief_of(engine, sigma, held=held)) == (
            {"second": pytest.approx(more)} if more else {}
        )


def test_what_is_free_beside_a_known_thing_is_not_beside_an_unsure_one(engine: Engine) -> None:
    from cramlite.plugin import Context
    from cramlite_plugins.motion_planning.reach import collision_free_ik, make_scene

    robot = engine.knowledge.robots["ur5e"]
    sure, unsure = belief_of(engine, 0.0), belief_of(engine, 0.004)
    context = Context(robot, sure.world.robots[0], {}, engine.knowledge.taxonomy)
    asked = {sigma: make_scene(b, context) for sigma, b in ((0, sure), (4, unsure))}
    reach = [collision_free_ik(asked[0], context, Pose((x, 0.0, 0.385), Pose.from_rotvec((0, 0, 0), (0, 1.5708, 0)).quaternion), robot.home)
             for x in (0.72 + 0.001 * k for k in range(45))]  # fmt: skip
    free = [q for q in reach if not isinstance(q, str)]
    assert free, "some of them are free beside what is known"
    assert any("only" in asked[4].why(q) and "'second" in asked[4].why(q) for q in free if not asked[4].free(q))
    assert asked[4].free(free[0])


def plan(*actions: tuple[str, dict[str, Object]], objects: tuple[Object, ...]) -> Plan:
    return Plan("p", objects, tuple(Action(f"{k}.{t}", f"soma:{t}", roles) for k, (t, roles) in enumerate(actions, 1)))


TEA = Object("object_1", ("cram:TeaBox",), ("vrps:Hole",))
HANGER, PEG = Object("object_3", ("cram:Hanger",)), Object("object_4", ("vrps:Peg",), ("vrps:Peg",), part_of="object_3")
TABLE = Object("object_2", ("cram:Table",))


def asked(engine: Engine, furniture: World, planned: Plan) -> list[list[str]]:
    return [[str(q) for q in queries] for queries in queries_of(planned, furniture, engine.knowledge.taxonomy, engine.knowledge.tasks)]


def test_what_to_look_for_follows_from_the_plan(engine: Engine, furniture: World) -> None:
    """A thing on a table, smaller tables first, then at the hanger; and the peg that is used."""
    hang = plan(
        ("PickingUp", {"Locatum": TEA, "Relatum": TABLE}), ("InsertHoleOntoPeg", {"Locatum": TEA, "Relatum": PEG}),
        objects=(TEA, TABLE, HANGER, PEG),
    )  # fmt: skip
    places = [f"features=vrps:Hole on={place}" for place in ("counter", "floor", "cram:Hanger")]
    assert asked(engine, furniture, hang) == [["on=cram:Hanger"], places]


def test_what_hangs_there_and_the_peg_are_one_picture(engine: Engine, furniture: World) -> None:
    fetch = plan(("ExtractHoleFromPeg", {"Locatum": TEA, "Relatum": PEG}), objects=(TEA, HANGER, PEG))
    assert asked(engine, furniture, fetch) == [["features=vrps:Hole on=cram:Hanger"]]


def test_without_needs_the_class_is_demanded(engine: Engine, furniture: World) -> None:
    tea = replace(TEA, features=())
    everywhere = [f"type=cram:TeaBox on={place}" for place in ("cram:Hanger", "counter", "floor")]
    assert asked(engine, furniture, plan(("Grasping", {"Patient": tea}), objects=(tea,))) == [everywhere]


def test_what_the_map_has_is_not_looked_for(engine: Engine, furniture: World) -> None:
    assert asked(engine, furniture, plan(("LookingAt", {"Patient": HANGER}), objects=(HANGER,))) == []
    named = Object("counter", entity="counter")
    assert asked(engine, furniture, plan(("LookingAt", {"Patient": named}), objects=(named,))) == []


def box(
    name: str, size: tuple[float, float, float], at: tuple[float, float, float], mass: float | None = None
) -> Thing:
    from cramlite.model import Feature, Geom

    top = Feature("top", "vrps:SurfaceFeature", Pose((0, 0, size[2] / 2)))
    half = (size[0] / 2, size[1] / 2, size[2] / 2)
    return Thing(name, "cram:Table", Pose(at), (Geom("box", half),), (top,), mass)


@pytest.mark.parametrize(("known", "count"), [((), 1), (("parcel",), 0)])
def test_obstacles_are_what_nothing_known_explains(engine: Engine, known: tuple[str, ...], count: int) -> None:
    from cramlite.perception.active_perception import ask
    from cramlite.perception.query import ObjectQuery
    from cramlite_plugins.locations.viewpoints import looking_at
    from cramlite_plugins.simulation.camera.depth_camera import render
    from cramlite_plugins.simulation.model.compile import compile_world

    table, parcel = box("table", (0.6, 0.6, 0.04), (0, 0, -0.02)), box("parcel", (0.1, 0.06, 0.12), (0, 0, 0.06), 0.5)
    compiled = compile_world(World((table, parcel)), {})
    view, _ = render(compiled.model, compiled.data(), looking_at((0.45, 0.25, 0.4), (0, 0, 0.05)), seed=2)
    recognised = tuple(t for t in (parcel,) if t.name in known)
    query = ObjectQuery(wanted=("obstacles",))
    found = ask(query, view, (table,), engine.knowledge, recognised=recognised).scene["obstacles"].value
    assert len(found) == count
    for body in found:
        (hull,) = body.geoms
        assert not body.movable and hull.shape == "convex"
        assert 2 * hull.size[0] == pytest.approx(0.1, abs=0.02) and 2 * hull.size[1] == pytest.approx(0.06, abs=0.02)
        low, high = (body.pose.position[2] + side * hull.size[2] for side in (-1, 1))
        assert low == pytest.approx(0.0, abs=0.002), "it is let down to the table"
        assert high == pytest.approx(0.12, abs=0.01)


def test_the_robot_is_no_obstacle(engine: Engine) -> None:
    """A fixed camera sees the arm; that is no thing, and without knowing how the arm stands it is one."""
    from cramlite.model import Camera, RobotMount
    from cramlite.perception.active_perception import ask
    from cramlite.perception.query import ObjectQuery
    from cramlite_plugins.locations.viewpoints import looking_at

    floor, robots = box("floor", (2, 2, 0.04), (0, 0, -0.02)), engine.knowledge.robots
    world = World((floor,), (RobotMount("arm", "ur5e"),))
    camera = Camera(looking_at((1.2, 0.4, 0.8), (0.1, 0, 0.3)))
    view = engine.knowledge.simulator.look(world, robots, camera, seed=1)
    own = engine.knowledge.simulator.look(replace(world, things=()), robots, replace(camera, noise=False), seed=0).depth
    query = ObjectQuery(wanted=("obstacles",))
    found = [ask(query, view, (floor,), engine.knowledge, robot=r).scene["obstacles"].value for r in (own, None)]
    assert [bool(f) for f in found] == [False, True]


def test_an_obstacle_that_is_recognised_later_is_none_any_more(engine: Engine) -> None:
    """The picture of the hanger shows a product on the counter that only the second picture tells."""
    from cramlite import Picture
    from cramlite.model import Camera
    from cramlite.perception.active_perception import Look, _beware
    from cramlite_plugins.locations.viewpoints import looking_at
    from cramlite_plugins.simulation.camera.depth_camera import render
    from cramlite_plugins.simulation.model.compile import compile_world

    table, parcel = box("table", (0.6, 0.6, 0.04), (0, 0, -0.02)), box("parcel", (0.1, 0.06, 0.12), (0, 0, 0.06), 0.5)
    compiled = compile_world(World((table, parcel)), {})
    view, _ = render(compiled.model, compiled.data(), looking_at((0.45, 0.25, 0.4), (0, 0, 0.05)), seed=2)
    seen = Look((Picture(view, Camera(view.camera), (table,)),), World((table,)), (), {}, compiled.world)
    first = _beware(seen, engine.knowledge)
    assert list(first.estimates) == ["obstacle_1"] == [t.name for t in first.obstacles]
    second = _beware(replace(first, known=World((table, parcel))), engine.knowledge)
    assert not second.estimates and not second.obstacles and second.world == second.known
