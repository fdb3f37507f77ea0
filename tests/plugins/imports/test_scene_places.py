"""Places, joints and names in foreign scenes: what sites mark, which end of a joint is closed, what parts are called after."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from cramlite import Engine
from cramlite.model import ImportedScene, Thing
from cramlite.ontology.taxonomy import Taxonomy
from cramlite.plugin import UserError
from cramlite.scenario.imported_world import propose
from cramlite_plugins.imports.scenes.reader import read_scene

TRAY = """
<geom type="box" size=".1 .1 .005"/>
<geom type="box" size=".005 .1 .03" pos=".095 0 .03"/><geom type="box" size=".005 .1 .03" pos="-.095 0 .03"/>
<geom type="box" size=".1 .005 .03" pos="0 .095 .03"/><geom type="box" size=".1 .005 .03" pos="0 -.095 .03"/>"""
CABINET = """
<body name="white_cabinet_1_main"><body name="white_cabinet_1_base">
<geom type="box" size=".1 .1 .005" pos="0 0 .1"/><geom type="box" size=".1 .005 .05" pos="0 .095 .05"/>
<geom type="box" size=".1 .005 .05" pos="0 -.095 .05"/><geom type="box" size=".1 .1 .005"/></body>
<body name="white_cabinet_1_cabinet_top" pos="{at} 0 .05"><joint type="slide" axis="-1 0 0" range="-.01 .15" ref="{ref}"/>
<geom type="box" size=".09 .08 .005" pos="0 0 -.03"/><geom type="box" size=".005 .08 .03" pos="-.095 0 0"/>
<geom type="box" size=".02 .004 .004" pos="-.12 .03 0"/><geom type="box" size=".02 .004 .004" pos="-.12 -.03 0"/>
<geom type="box" size=".005 .035 .005" pos="-.135 0 0"/></body></body>"""


def _scene(tmp_path: Path, body: str, rest: str = "") -> ImportedScene:
    path = tmp_path / "scene.xml"
    path.write_text(f"<mujoco>{rest}<worldbody>{body}</worldbody></mujoco>")
    scene = read_scene(path, {}, "", {})
    assert scene is not None
    return scene


def _thing(scene: ImportedScene, name: str) -> Thing:
    return next(t for t in scene.things if t.name == name)


@cache
def _taxonomy() -> Taxonomy:
    return Engine().knowledge.taxonomy


def test_a_site_inside_is_a_cavity_with_its_height_upwards_whichever_way_it_is_turned(tmp_path: Path) -> None:
    site = '<site name="tray_left_region" type="box" size=".028 .08 .06" pos="0 0 .034" quat=".707107 0 .707107 0"/>'
    tray = _thing(_scene(tmp_path, f'<body name="tray">{TRAY}{site}</body>'), "tray")
    cavity = tray.feature("cram:Cavity")
    assert cavity is not None and cavity.name == "left_region"
    assert cavity.size == pytest.approx({"width": 0.16, "depth": 0.12, "height": 0.057})  # 1 mm more down to the floor
    assert cavity.pose.position == pytest.approx((0, 0, 0.062), abs=1e-6)
    assert cavity.pose.rotate((0, 0, 1)) == pytest.approx((0, 0, 1), abs=1e-6)


@pytest.mark.parametrize(("low", "height"), [(0.015, 0.055), (0.001, 0.059)])
def test_a_cavity_reaches_down_to_the_floor_below_its_site(low: float, height: float, tmp_path: Path) -> None:
    half = (0.06 - low) / 2
    site = f'<site name="tray_left_region" type="box" size=".08 .08 {half}" pos="0 0 {0.06 - half}"/>'
    tray = _thing(_scene(tmp_path, f'<body name="tray">{TRAY}{site}</body>'), "tray")
    cavity = tray.feature("cram:Cavity")
    assert cavity is not None and cavity.size["height"] == pytest.approx(height, abs=1e-4)


def test_each_of_several_sites_keeps_its_name(tmp_path: Path) -> None:
    places = (("left", -0.045), ("right", 0.045))
    sites = "".join(f'<site name="tray_{n}_region" type="box" size=".04 .08 .02" pos="{x} 0 .03"/>' for n, x in places)
    tray = _thing(_scene(tmp_path, f'<body name="tray">{TRAY}{sites}</body>'), "tray")
    assert [f.name for f in tray.features if f.type == "cram:Cavity"] == ["left_region", "right_region"]


@pytest.mark.parametrize("half", [0.05, 0.01])
def test_a_site_upon_a_table_holds_nothing_and_is_an_area_of_its_surface(half: float, tmp_path: Path) -> None:
    """However small it is: a goal that names it is about it."""
    site = f'<site name="table_front_region" type="box" size="{half} {half} .007" pos=".1 0 .03"/>'
    table = _thing(_scene(tmp_path, f'<body name="table"><geom type="box" size=".3 .3 .02"/>{site}</body>'), "table")
    areas = [f for f in table.features if f.type == "vrps:SurfaceFeature"]
    assert table.feature("cram:Cavity") is None and [f.name for f in areas] == ["surface", "front_region"]
    there = {"width": 2 * half, "depth": 2 * half, "lowest": 0.003}  # its lower end is over the table
    assert areas[1].pose.position == pytest.approx((0.1, 0, 0.02)) and areas[1].size == there


def test_a_site_that_reaches_out_below_a_tables_top_is_an_area_of_its_surface(tmp_path: Path) -> None:
    """Nothing is put into what has a roof and no floor; its middle is 3 mm below the top, as in LIBERO's living room."""
    legs = '<geom type="box" size=".1 .3 .2" pos="-.2 0 -.22"/>'
    site = '<site name="table_front_region" type="box" size=".05 .05 .007" pos=".1 0 -.023"/>'
    table = _thing(_scene(tmp_path, f'<body name="table"><geom type="box" size=".3 .3 .02"/>{legs}{site}</body>'), "table")
    area = next(f for f in table.features if f.name == "front_region")
    assert table.feature("cram:Cavity") is None and area.type == "vrps:SurfaceFeature"
    assert area.pose.position == pytest.approx((0.1, 0, 0.02))


@pytest.mark.parametrize("site", ['size=".05 .05 .007" pos="0 0 .5"', 'size=".05 .05 .007" pos="0 0 .03" euler="40 0 0"'])
def test_a_site_in_the_air_or_aslant_is_no_place(site: str, tmp_path: Path) -> None:
    body = f'<body name="table"><geom type="box" size=".3 .3 .02"/><site name="a_region" type="box" {site}/></body>'
    table = _thing(_scene(tmp_path, body), "table")
    assert [f.name for f in table.features] == ["surface"]


@pytest.mark.parametrize(("at", "ref"), [(0.0, 0.0), (-0.15, 0.15)])
def test_a_drawer_that_starts_open_is_closed_where_it_is_inside(at: float, ref: float, tmp_path: Path) -> None:
    drawer = _thing(_scene(tmp_path, CABINET.format(at=at, ref=ref)), "white_cabinet_1_cabinet_top")
    handle = drawer.feature("cram:Handle")
    assert drawer.joint is not None and drawer.joint.value == pytest.approx(ref) and drawer.joint.upper == pytest.approx(0.15)
    assert drawer.joint.pose.rotate((0, 0, 1)) == pytest.approx((-1, 0, 0)) and handle is not None
    assert drawer.joint.lower == pytest.approx(-0.01)  # its stop, wherever it starts: whoever closes it goes on to there
    assert any("take the least room" in n for n in drawer.notes)
    assert handle.pose.position == pytest.approx((-0.135, 0, 0)) and handle.size["radius"] == pytest.approx(0.005)


def test_words_of_the_cabinet_do_not_say_what_its_drawer_is(tmp_path: Path) -> None:
    scene = _scene(tmp_path, CABINET.format(at=0, ref=0))
    found = {t.name: propose(t, scene, {}, _taxonomy()).type for t in scene.things}
    assert found == {"white_cabinet_1_main": "soma:Cupboard", "white_cabinet_1_cabinet_top": "soma:Drawer"}


def test_no_thing_is_taken_for_who_acts_and_few_parts_do_not_name_a_whole(tmp_path: Path) -> None:
    parts = '<geom name="base" size=".1"/><geom name="rod" size=".1"/><geom name="wall_1" size=".1"/>'
    scene = _scene(tmp_path, f'<body name="object_1"><freejoint/>{parts}</body>')
    found = propose(scene.things[0], scene, {}, _taxonomy())
    assert found.type == "cram:Product" and "no label" in found.reason


def test_what_turns_about_its_own_middle_is_a_knob(tmp_path: Path) -> None:
    plate = '<geom type="cylinder" size=".03 .01"/><geom type="box" size=".02 .004 .02" pos="0 0 .03"/>'
    knob = _scene(tmp_path, f'<body name="thing"><joint axis="0 0 1" range="0 90"/>{plate}</body>').things[0]
    assert knob.type == "cram:Knob" and knob.feature("cram:Handle") is not None


def test_where_the_files_robot_stood_is_kept(tmp_path: Path) -> None:
    arm = ""
    for k in range(5, 0, -1):
        arm = f'<body name="link{k}" pos="0 0 .1"><joint name="j{k}"/><geom size=".03"/>{arm}</body>'
    ground = '<geom name="ground" type="plane" size="1 1 .1"/>'
    scene = _scene(tmp_path, f'<body name="arm_base" pos=".1 .2 .3"><geom size=".1"/>{arm}</body>{ground}')
    assert {n: p.position for n, p in scene.stands.items()} == {"arm_base": (0.1, 0.2, 0.3)}


def test_pictures_on_surfaces_are_not_needed_and_tendons_are_named(tmp_path: Path) -> None:
    asset = '<asset><texture name="t" type="2d" file="none.png"/><material name="m" texture="t" rgba="1 0 0 1"/></asset>'
    tendon = '<tendon><fixed name="string"><joint joint="j" coef="1"/></fixed></tendon>'
    body = '<body name="door"><joint name="j" range="0 90"/><geom type="box" size=".1 .01 .1" material="m"/></body>'
    scene = _scene(tmp_path, body, asset + tendon)
    assert scene.things[0].geoms[0].rgba == (1, 0, 0, 1) and "left out: 1 tendon" in scene.notes


def test_two_worlds_are_one_and_an_inverted_mesh_is_turned(tmp_path: Path) -> None:
    import trimesh

    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.invert()
    box.export(tmp_path / "box.stl")
    path = tmp_path / "scene.xml"
    mesh = '<asset><mesh name="box" file="box.stl" inertia="shell"/></asset>'
    one = '<worldbody><body name="a"><freejoint/><geom type="mesh" mesh="box" mass="1"/></body></worldbody>'
    path.write_text(f'<mujoco>{mesh}{one}<worldbody><geom name="b" size=".1" pos="1 0 0"/></worldbody></mujoco>')
    scene = read_scene(path, {}, "", {})
    assert scene is not None and {t.name for t in scene.things} == {"a", "b"}
    assert any("turned outwards" in n for t in scene.things for n in t.notes)


def test_a_million_triangles_are_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "hill.stl").write_bytes(bytes(80) + (1_000_000).to_bytes(4, "little") + bytes(50_000_000))
    path = tmp_path / "scene.xml"
    mesh = '<mesh name="hill" file="hill.stl" inertia="shell"/>'
    path.write_text(f'<mujoco><asset>\n{mesh}</asset><worldbody><geom type="mesh" mesh="hill"/></worldbody></mujoco>')
    with pytest.raises(UserError, match=r"scene.xml:2: .*faces.*simplify") as refused:
        read_scene(path, {}, "", {})
    assert "\n" not in str(refused.value)


RACK = """
<geom type="box" size=".1 .1 .005" pos="0 0 .005"/><geom type="box" size=".1 .1 .005" pos="0 0 {top}"/>
<geom type="box" size=".1 .005 .08" pos="0 .095 .08"/><geom type="box" size=".1 .005 .08" pos="0 -.095 .08"/>
<site name="rack_lower_region" type="box" size=".08 .08 .05" pos="0 0 .07"/>"""


@pytest.mark.parametrize(("top", "type_", "height"), [(0.155, "vrps:SurfaceFeature", 0.0101), (0.005, "cram:Cavity", 0.12)])
def test_a_site_under_a_roof_is_the_area_below_with_the_room_over_it(tmp_path: Path, top: float, type_: str, height: float) -> None:
    body = f'<body name="rack">{RACK.format(top=top)}</body>'
    region = next(f for f in _thing(_scene(tmp_path, body), "rack").features if f.name == "lower_region")
    assert region.type == type_ and region.pose.position[2] == pytest.approx(height, abs=1e-3)
    assert region.size["height"] == pytest.approx(0.11, abs=1e-3)


@pytest.mark.parametrize(("name", "class_"), [("tray_left_region", "soma:DesignedContainer"), ("tray_mark", "soma:DesignedFurniture")])
def test_what_has_cavities_that_sites_mark_is_a_container(tmp_path: Path, name: str, class_: str) -> None:
    site = f'<site name="{name}" type="box" size=".08 .08 .02" pos="0 0 .03"/>'
    assert _thing(_scene(tmp_path, f'<body name="organiser">{TRAY}{site}</body>'), "organiser").type == class_


def test_a_hollow_without_a_level_face_carries_on_its_floor(tmp_path: Path) -> None:
    slopes = ((".056 0 .05", "0 -45 0"), ("-.056 0 .05", "0 45 0"), ("0 .056 .05", "45 0 0"), ("0 -.056 .05", "-45 0 0"))
    walls = "".join(f'<geom type="box" size=".08 .08 .004" pos="{at}" euler="{turn}"/>' for at, turn in slopes)
    bowl = _thing(_scene(tmp_path, f'<body name="funnel" pos="0 0 1"><freejoint/>{walls}</body>'), "funnel")
    cavity, floor = bowl.feature("cram:Cavity"), bowl.feature("vrps:SurfaceFeature")
    assert cavity is not None and floor is not None and floor.name == "floor"
    assert floor.pose.position[2] == pytest.approx(cavity.pose.position[2] - cavity.size["height"], abs=1e-6)


CRADLE = """
<geom type="box" size=".1 .005 .06" pos="0 .05 .1" euler="-60 0 0"/>
<geom type="box" size=".1 .005 .03" pos="0 -.03 .09" euler="30 0 0"/>
<site name="rack_top_region" type="box" size=".09 .03 .002" pos="0 .03 .1" euler="{lean} 0 0"/>"""


def test_a_flat_site_that_leans_is_an_area_that_faces_as_it_does(tmp_path: Path) -> None:
    rack = _thing(_scene(tmp_path, f'<body name="rack">{CRADLE.format(lean=30)}</body>'), "rack")
    area = next(f for f in rack.features if f.name == "top_region")
    assert area.type == "vrps:SurfaceFeature" and area.size == {"width": 0.18, "depth": 0.06}
    assert area.pose.rotate((0, 0, 1)) == pytest.approx((0, -0.5, 0.8660254), abs=1e-6)


def test_a_site_as_steep_as_a_wall_is_none(tmp_path: Path) -> None:
    rack = _thing(_scene(tmp_path, f'<body name="rack">{CRADLE.format(lean=80)}</body>'), "rack")
    assert "top_region" not in {f.name for f in rack.features}


@pytest.mark.parametrize(("cap", "features"), [(0.012, ["surface"]), (0.006, [])])
def test_what_can_be_moved_carries_on_its_only_small_face_as_on_a_bottles_cap(cap: float, features: list[str], tmp_path: Path) -> None:
    """Not on one that is too narrow to bear anything."""
    shape = f'<geom type="cylinder" size=".03 .05" euler="0 0 0"/><geom type="box" size="{cap} {cap} .01" pos="0 0 .06"/>'
    cone = f'<freejoint/><geom type="sphere" size=".03"/><geom type="box" size="{cap} {cap} .02" pos="0 0 .03"/>'
    bottle = _thing(_scene(tmp_path, f'<body name="bottle" pos="0 0 .5">{cone}</body>'), "bottle")
    assert [f.name for f in bottle.features if f.type == "vrps:SurfaceFeature"] == features
    whole = _thing(_scene(tmp_path, f'<body name="tin" pos="0 0 .5"><freejoint/>{shape}</body>'), "tin")
    assert [f.name for f in whole.features if f.type == "vrps:SurfaceFeature"] == ["surface"]
