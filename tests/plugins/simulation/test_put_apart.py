"""Poses that were read inside others: the nearest free ones within the noise that is told, and no others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine, UserError, read_scenario
from cramlite.model import InHand, Joint, Pose, World
from cramlite.scenario.worlds import corrected

ENGINE = Engine()
SCENE = """<mujoco><worldbody>
<geom name="table" type="box" size="0.6 0.6 0.01" pos="0.3 0 -0.011"/>
<body name="box" pos="0.4 0.1 0.03"><freejoint/><geom type="box" size="0.03 0.03 0.03" mass="0.1"/></body>
<body name="can" pos="{at} 0.1 0.03"><freejoint/><geom type="box" size="0.03 0.03 0.03" mass="0.1"/></body>
<body name="wall" pos="0.5 -0.3 0.03"><geom type="box" size="0.03 0.03 0.03"/></body>
</worldbody></mujoco>
"""
SCENARIO = "scenario: read\nrobot: {{type: ur5e}}\nworld: {{file: scene.xml{noise}}}\ntasks: []\n"


def read(folder: Path, noise: str, at: float = 0.44) -> World:
    """A can and a box of 60 mm whose origins are ``at`` - 0.4 m apart."""
    (folder / "scene.xml").write_text(SCENE.format(at=at))
    (folder / "scenario.yaml").write_text(SCENARIO.format(noise=noise))
    return ENGINE.setting(read_scenario(folder / "scenario.yaml"), twins=0).world


def test_what_was_read_inside_another_is_believed_where_it_is_free(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="overlap by 20 mm at the start, more than the 5 mm that are allowed"):
        read(tmp_path, "")
    with pytest.raises(UserError, match="overlap by 20 mm"):
        read(tmp_path, ", noise: 10 mm")
    world = read(tmp_path, ", noise: 30 mm")
    apart = np.subtract(world.thing("can").pose.position, world.thing("box").pose.position)
    assert 0.06 <= abs(apart[0]) <= 0.062 and np.allclose(apart[1:], 0.0, atol=0.002)
    (note,) = [n for n in world.notes if "was perceived 20.0 mm inside" in n]
    assert "it is believed to be 20 mm away from there, where it is free" in note


def test_readings_that_can_be_are_believed(tmp_path: Path) -> None:
    for at in (0.457, 0.48):  # 3 mm inside each other, and apart
        world = read(tmp_path, ", noise: 30 mm", at)
        assert world.thing("can").pose.position[0] == pytest.approx(at) and not [n for n in world.notes if "was read" in n]


def test_what_is_held_or_fixed_stays(tmp_path: Path) -> None:
    world = read(tmp_path, "", 0.48)
    for fixed, other in (("box", "can"), ("wall", "box")):
        there = world.thing(fixed).pose.position
        inside = world.moved({other: Pose((there[0] + 0.02, there[1], there[2]))})
        mount = world.robots[0]
        if fixed == "box":
            inside = replace(inside, robots=(replace(mount, holds=InHand("box", Pose((0, 0, 0)), 10.0)),))
        mended = corrected(inside, ENGINE.knowledge, 0.1)
        assert mended.thing(fixed).pose == inside.thing(fixed).pose, fixed
        assert mended.thing(other).pose != inside.thing(other).pose and len(mended.notes) == len(inside.notes) + 1
        assert corrected(inside, ENGINE.knowledge, 0.0) is inside


def test_what_the_hand_holds_up_is_where_it_was_read(tmp_path: Path) -> None:
    """A can was read 20 mm deep in the box below it, which is in the air: without the hand both would fall."""
    scene = SCENE.format(at=0.4).replace('"0.4 0.1 0.03"><freejoint/><geom', '"0.4 0.1 0.3"><freejoint/><geom', 1)
    (tmp_path / "scene.xml").write_text(scene.replace('"0.4 0.1 0.03"', '"0.4 0.1 0.34"'))
    (tmp_path / "scenario.yaml").write_text(SCENARIO.format(noise=", noise: 30 mm"))
    scenario = read_scenario(tmp_path / "scenario.yaml")
    with pytest.raises(UserError, match="overlap by 20 mm"):
        ENGINE.setting(scenario, twins=0)
    mount = replace(read(tmp_path, "", 0.48).robots[0], holds=InHand("box", Pose((0, 0, 0)), 10.0))
    (tmp_path / "scene.xml").write_text(scene.replace('"0.4 0.1 0.03"', '"0.4 0.1 0.34"'))
    world = ENGINE.setting(scenario, twins=0, now=World((), (mount,))).world
    assert world.thing("box").pose.position[2] == 0.3 and world.robots[0].holds == mount.holds
    assert world.thing("can").pose.position[2] == pytest.approx(0.36, abs=0.002)


def test_each_of_several_things_that_were_read_inside_their_support_is_believed_on_it(tmp_path: Path) -> None:
    world = read(tmp_path, "", 0.6)
    sunk = world.moved({n: Pose((x, y, z - 0.002)) for n in ("box", "can") for x, y, z in [world.thing(n).pose.position]})
    mended = corrected(sunk, ENGINE.knowledge, 0.005, 0.0003)
    assert [mended.thing(n).pose.position[2] for n in ("box", "can")] == pytest.approx([0.029, 0.029], abs=0.0003)
    assert len(mended.notes) == len(sunk.notes) + 2


def test_a_payload_that_was_read_inside_its_support_touches_it_in_belief(tmp_path: Path) -> None:
    world, tool = read(tmp_path, "", 0.6), Pose.from_rotvec((0.4, 0.1, 0.05), (np.pi, 0.0, 0.0))
    sunk = world.moved({"box": Pose((0.4, 0.1, 0.0263))})
    for most, higher in ((0.005, 0.00255), (0.002, 0.0)):
        holds = InHand("box", tool.inverse() * sunk.thing("box").pose, 10.0)
        mended = corrected(replace(sunk, robots=(replace(world.robots[0], holds=holds),)), ENGINE.knowledge, most, 0.0003)
        assert mended.thing("box").pose.position[2] == pytest.approx(0.0263 + higher, abs=1e-5), f"readings are {most} m off at most"
        mount = mended.robots[0]
        assert mount.holds is not None
        there = (tool * mount.holds.tcp_to_thing).position
        assert there == pytest.approx(mended.thing("box").pose.position), "the hand stays, and the thing is elsewhere in it"


def test_a_drawer_whose_handle_is_in_the_hand_stays_while_others_settle(tmp_path: Path) -> None:
    world = read(tmp_path, "", 0.44 + 0.16)
    sunk = world.moved({"can": Pose((0.45, 0.1, 0.03))})  # 10 mm inside the box
    rail = Joint("slide", Pose(), 0.0, 0.2)
    drawer = replace(world.thing("wall"), name="drawer", pose=Pose((0.3, 0.4, 0.03)), mass=0.5, joint=rail)
    mount = replace(world.robots[0], holds=InHand("drawer", Pose(), 10.0))
    mended = corrected(replace(sunk, things=(*sunk.things, drawer), robots=(mount,)), ENGINE.knowledge, 0.03)
    assert mended.thing("drawer").pose == drawer.pose and mended.thing("can").pose != sunk.thing("can").pose


@pytest.mark.parametrize("gap", [0.046, 0.058])
def test_what_physics_leaves_in_another_thing_stays_where_something_put_it(gap: float, tmp_path: Path) -> None:
    """A can of 60 mm between two walls that are one thing: 7 mm inside each, or 1 mm, which needs no correction."""
    walls = "".join(f'<geom type="box" size="0.03 0.03 0.05" pos="{x} 0 0.02" mass="0.5"/>' for x in (gap / 2 + 0.03, -gap / 2 - 0.03))
    box = '<geom type="box" size="0.03 0.03 0.03" mass="0.1"/>'
    scene = SCENE.format(at=0.7).replace(box, walls, 1)
    (tmp_path / "scene.xml").write_text(scene)
    (tmp_path / "scenario.yaml").write_text(SCENARIO.format(noise=""))
    world = ENGINE.setting(read_scenario(tmp_path / "scenario.yaml"), twins=0).world
    between = world.moved({"can": Pose((0.4, 0.1, 0.03))})
    stays = corrected(between, ENGINE.knowledge, 0.06, staying=True)
    assert stays.thing("can").pose.distance(between.thing("can").pose)[0] < 0.01
    said = [n for n in stays.notes if n not in between.notes]
    assert said == (["'box' was perceived 7.0 mm inside 'can', and stays there"] if gap < 0.05 else [])
    assert not [n for n in corrected(between, ENGINE.knowledge, 0.06).notes if "stays there" in n]
