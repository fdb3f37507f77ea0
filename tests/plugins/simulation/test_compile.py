"""Worlds compile to what they say, and friction alone holds things."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from helpers.arm import lift, solve
from helpers.standard import BACK, ROBOTS, standard_world, standing_world
from msgspec.structs import replace

from cramlite.model import Geom, Physics, Pose, RobotMount, Thing, World
from cramlite.plugin import UserError
from cramlite_plugins.objects.products_and_fixtures import MODELS, hanger, hung, make, product
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.model.build import SOLREF, Carried
from cramlite_plugins.simulation.model.compile import compile_world


def thing(*geoms: Geom, mass: float | None = None, name: str = "plate", at: Pose | None = None) -> Thing:
    return Thing(name, "cram:Plate", at or Pose(), geoms, (), mass)


def test_every_geom_has_an_owner() -> None:
    compiled = compile_world(standard_world(), ROBOTS, hand=True)
    names = {o.touch for o in compiled.owners}
    assert {"hanger", "hanger/peg", "hanger/tip", "product", "product/hole", "basket", "basket/floor"} <= names
    assert {"effector/left", "effector/right", "effector/body", "arm/forearm_link"} <= names
    assert len(compiled.owners) == compiled.model.ngeom


def test_physics_settings_reach_the_model_although_robots_bring_their_own() -> None:
    physics = Physics(timestep=0.001, cone="pyramidal", noslip_iterations=7, impratio=3.0, pad_friction=0.4)
    option = compile_world(standard_world(physics), ROBOTS).model.opt
    assert (option.timestep, option.cone, option.noslip_iterations, option.impratio) == (0.001, 0, 7, 3.0)
    compiled = compile_world(standard_world(physics), ROBOTS)
    index = compiled.robots["arm"]
    assert set(compiled.model.geom_friction[[*index.left, *index.right], 0]) == {0.4}


def test_masses_are_those_of_the_world() -> None:
    compiled = compile_world(standing_world(), ROBOTS)
    assert compiled.model.body_mass[compiled.things["product"].body] == pytest.approx(0.8)


def test_the_initial_state_is_at_home_open_and_as_the_world_says() -> None:
    compiled = compile_world(standard_world(), ROBOTS)
    data = compiled.data()
    for _ in range(50):
        data.ctrl[:] = 0.1
        mujoco.mj_step(compiled.model, data)
    compiled.initial(data)
    index = compiled.robots["arm"]
    assert data.qpos[list(index.joints)] == pytest.approx(UR5E.home)
    assert index.opening(data.qpos) == pytest.approx(0.085)
    assert compiled.pose(data, "product").distance(compiled.world.thing("product").pose)[0] < 1e-9
    index.set_opening(data, 0.03)
    assert index.opening(data.qpos) == pytest.approx(0.03)


def test_two_robots_in_one_world() -> None:
    far = RobotMount("other", "ur5e", Pose((0, 1.5, 0)))
    world = standard_world()
    compiled = compile_world(replace(world, robots=(*world.robots, far)), ROBOTS)
    data = compiled.data()
    shift = np.subtract(compiled.robots["other"].pose(data).position, compiled.robots["arm"].pose(data).position)
    assert shift == pytest.approx((0, 1.5, 0), abs=1e-9)


@pytest.mark.parametrize(
    ("world", "words"),
    [
        (World((thing(Geom("box", (0.1, 0.1))),)), ("plate", "box needs 3")),
        (World((thing(Geom("sphere", (-0.1,))),)), ("plate", "positive")),
        (World((thing(Geom("cone", (0.1,))),)), ("plate", "cone", "capsule")),  # type: ignore[arg-type]
        (World((thing(),)), ("plate", "no geoms")),
        (World((thing(Geom("sphere", (0.1,)), mass=-1.0),)), ("plate", "-1.0 kg")),
        (World((thing(Geom("sphere", (0.1,)), name="a/b"),)), ("a/b",)),
        (World((thing(Geom("sphere", (1e-6,)), mass=1e-4, name="crumb"),)), ("crumb", "mass and inertia")),
        (World((thing(Geom("sphere", (0.1,))),) * 2), ("plate", "twice")),
        (World((thing(Geom("sphere", (0.1,))),), (RobotMount("arm", "ur5"),)), ("arm", "did you mean 'ur5e'")),
    ],
)
def test_a_world_that_does_not_compile_says_what_and_why(world: World, words: tuple[str, ...]) -> None:
    with pytest.raises(UserError) as caught:
        compile_world(world, ROBOTS)
    assert all(word in str(caught.value) for word in words)


def test_a_planning_model_is_free_at_home_and_not_inside_the_wall() -> None:
    compiled = compile_world(standard_world(), ROBOTS, planning=True)
    data = compiled.data()
    assert data.ncon == 0
    index = compiled.robots["arm"]
    data.qpos[list(index.joints)] = solve(compiled, Pose.from_axes((0.5, 0, 0.01), (0, 0, -1), (-1, 0, 0)), UR5E.home)
    mujoco.mj_kinematics(compiled.model, data)
    mujoco.mj_collision(compiled.model, data)
    assert ("effector/left", "table") in compiled.collisions(data)


def test_a_capsule_through_a_plate_is_seen_when_planning() -> None:
    """The trap: MuJoCo 4.0.0 gives no contact for this pair of primitives."""
    plate = thing(Geom("box", (0.3, 0.3, 0.02)), mass=1.0)
    rod = thing(Geom("capsule", (0.05, 0.2)), name="rod", at=Pose((0.5, 0, 0.2)))
    world = World((plate, rod), (RobotMount("arm", "ur5e", Pose((0, 0, 0.5))),))
    compiled = compile_world(
        world, ROBOTS, planning=True, carried={"plate": Carried("arm", Pose())}
    )
    data = compiled.data()
    index = compiled.robots["arm"]
    q = solve(compiled, Pose.from_axes((0.5, 0, 0.2), (0, 0, -1), (-1, 0, 0)), UR5E.home)
    data.qpos[list(index.joints)] = q
    mujoco.mj_forward(compiled.model, data)
    assert ("plate", "rod") in compiled.collisions(data)


def test_a_carried_thing_moves_with_the_tool_and_collides_for_it() -> None:
    world = standing_world()
    hold = Carried("arm", Pose((0, 0, 0.0)) * Pose.from_axes((0, 0, 0), (-1, 0, 0), (0, 0, 1)))
    compiled = compile_world(world, ROBOTS, planning=True, carried={"product": hold})
    data, index = compiled.data(), compiled.robots["arm"]
    assert compiled.pose(data, "product").distance(index.pose(data) * hold.pose)[0] < 1e-9
    assert data.ncon == 0
    data.qpos[list(index.joints)] = solve(compiled, Pose.from_axes((0.5, 0, 0.055), (1, 0, 0), (0, 0, -1)), UR5E.home)
    mujoco.mj_forward(compiled.model, data)
    assert ("product", "table") in compiled.collisions(data)
    with pytest.raises(UserError, match="no robot of this world"):
        compile_world(world, ROBOTS, planning=True, carried={"product": Carried("leg", Pose())})


def test_a_planning_model_meets_what_it_touches_and_nothing_before() -> None:
    ball = thing(Geom("sphere", (0.05,)), name="ball")
    base = World((), (RobotMount("arm", "ur5e"),))
    tip = compile_world(base, ROBOTS).robots["arm"].pose(compile_world(base, ROBOTS).data()).position
    for gap, touching in ((-0.001, True), (0.001, False)):
        low = tip[2] - UR5E.gripper.pad[1] / 2 - 0.05 - gap
        world = replace(base, things=(replace(ball, pose=Pose((tip[0], tip[1] + 0.046, low))),))
        data = compile_world(world, ROBOTS, planning=True).data()
        assert (data.ncon > 0) == touching


def test_a_grasped_product_stays_in_the_hand() -> None:
    compiled = compile_world(standing_world(), ROBOTS)
    data = compiled.data()
    before, after = lift(compiled, data)
    assert before.distance(after)[0] < 0.5e-3
    assert compiled.pose(data, "product").position[2] > 0.075 + 0.09


def test_without_friction_it_stays_on_the_table() -> None:
    compiled = compile_world(standing_world(Physics(pad_friction=0.0)), ROBOTS)
    data = compiled.data()
    lift(compiled, data)
    assert compiled.pose(data, "product").position[2] < 0.08


@pytest.mark.parametrize("yaw", [0.0, 0.15])
def test_a_hung_product_rests_on_the_peg(yaw: float) -> None:
    world = standard_world(robot=False)
    start = hung(world.thing("product"), world.thing("hanger"), 0.07, yaw)
    compiled = compile_world(world.moved({"product": start}), {})
    data = compiled.data()
    for _ in range(1000):
        mujoco.mj_step(compiled.model, data)
    assert compiled.pose(data, "product").distance(start)[0] < 2e-3
    assert compiled.collisions(data) == {("hanger/peg", "product/hole")}


def test_without_a_peg_it_falls() -> None:
    world = standard_world(robot=False)
    hook = world.thing("hanger")
    bare = replace(hook, geoms=tuple(g for g in hook.geoms if not g.part))
    compiled = compile_world(replace(world, things=(*(t for t in world.things if t != hook), bare)), {})
    data = compiled.data()
    for _ in range(1000):
        mujoco.mj_step(compiled.model, data)
    assert compiled.pose(data, "product").position[2] < 0.2


def dropped(solref: float, count: int = 12) -> int:
    """How many of some products that fall into the basket at random end inside its floor."""
    compiled = compile_world(standard_world(robot=False), {})
    compiled.model.geom_solref[:, 0] = solref
    data, rng, sunk = compiled.data(), np.random.default_rng(1), 0
    for turn in rng.normal(size=(count, 4)):
        compiled.initial(data)
        compiled.place(data, "product", Pose((0.3, -0.45, 0.45), tuple(turn)))
        for _ in range(600):
            mujoco.mj_step(compiled.model, data)
        sunk += bool(data.ncon and data.contact.dist.min() < -0.002)
    return sunk


def test_a_falling_product_does_not_sink_into_a_thin_floor() -> None:
    assert dropped(SOLREF[0]) == 0


def test_with_the_simulators_own_softness_it_would() -> None:
    assert dropped(0.02) > 0


def test_the_hole_is_a_hole() -> None:
    """Rays through the hole's circle hit nothing; rays beside it hit the tab."""
    compiled = compile_world(World((product("product", Pose()),)), {})
    data = compiled.data()
    hole = compiled.world.thing("product").features[0]

    def hits(radius: float) -> int:
        count = 0
        for k in range(36):
            angle = math.tau * k / 36
            start = hole.pose.apply((radius * math.cos(angle), radius * math.sin(angle), -0.1))
            ray = hole.pose.rotate((0.0, 0.0, 1.0))
            count += mujoco.mj_ray(compiled.model, data, start, ray, None, True, -1, np.zeros(1, np.int32)) >= 0
        return count

    assert hits(0.00499) == 0
    assert hits(0.0055) == 36


@pytest.mark.parametrize("name", sorted(set(MODELS) - {"mesh"}))  # which takes a file: tests/plugins/shapes
def test_every_registered_model_compiles(name: str) -> None:
    made = make(name, "it", Pose((0, 0, 1)))
    assert compile_world(World((made,)), {}).things["it"].body > 0
    assert all(f.pose.position is not None and f.size for f in made.features)


def test_models_refuse_what_they_do_not_know() -> None:
    assert make("hanger", "h", Pose(), {"length": 0.2}).features[0].size["length"] == 0.2
    with pytest.raises(UserError, match="did you mean 'hole_diameter'"):
        make("boxed_product", "p", Pose(), {"hole_diametre": 0.01})
    with pytest.raises(UserError, match="did you mean 'hanger'"):
        make("hangar", "h", Pose())
    with pytest.raises(UserError, match="'length' is 'long'"):
        make("hanger", "h", Pose(), {"length": "long"})


def test_hung_refuses_a_peg_that_does_not_fit() -> None:
    with pytest.raises(UserError, match="hole has"):
        hung(product("p", Pose(), hole_diameter=0.005), hanger("h", BACK), 0.07)


@pytest.mark.parametrize("opening", [None, 0.03])
def test_a_robot_starts_as_its_mount_says(opening: float | None) -> None:
    """Joints and fingers, before the first cycle and after half a second of it; at home and open where it says nothing."""
    from cramlite_plugins.simulator.execute import execute

    there = (2.0, -1.6, 1.6, -1.4, -1.57, 1.2) if opening else ()
    world = World((), (RobotMount("arm", "ur5e", joints=there, opening=opening),))
    rollout = execute('def p():\n  textmsg("here")\nend\n', world, {"ur5e": UR5E}, mount="arm")
    assert rollout.joints[0] == pytest.approx(there or UR5E.home, abs=5e-3)
    assert rollout.opening[[0, -1]] == pytest.approx([opening or UR5E.gripper.opening[1]] * 2, abs=1e-3)


def test_a_closed_gripper_opens_when_it_is_told() -> None:
    """Its registers say that it is closed: else an order to open would be nothing new."""
    from cramlite_plugins.simulator.execute import execute

    text = (
        'def p():\n  socket_open("127.0.0.1", 63352, "g")\n  textmsg(socket_get_var("PRE", "g"))\n'
        '  socket_set_var("POS", 0, "g")\n  sleep(2.0)\nend\n'
    )
    world = World((), (RobotMount("arm", "ur5e", opening=0.0),))
    rollout = execute(text, world, {"ur5e": UR5E}, mount="arm")
    assert rollout.messages[0].text == "255"
    assert rollout.opening[0] < 0.002 and rollout.opening[-1] > 0.08
