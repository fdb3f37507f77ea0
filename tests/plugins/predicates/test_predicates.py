"""Each predicate holds where it should, and not in a sibling case."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite import data_folder
from cramlite.model import Entity, Episode, Event, Geom, Pose, Track
from cramlite.ontology.taxonomy import load_taxonomy
from cramlite.plugin import Phase, Row, Segment, Timeline
from cramlite_plugins.predicates.extents import in_extent
from cramlite_plugins.predicates.relations import all_predicates

TAXONOMY = load_taxonomy([data_folder("ontologies")])
TABLE = {p.name: p for p in all_predicates()}

ENTITIES = (
    Entity("hand", ("soma:Hand",)),
    Entity("hand/left", ("soma:Finger",), part_of="hand"),
    Entity("hand/right", ("soma:Finger",), part_of="hand"),
    Entity("hanger", ("cram:Hanger",), pose=Pose((1, 0, 1))),
    Entity("hanger/peg", ("vrps:Peg",), part_of="hanger", pose=Pose()),
    Entity("product", ("cram:BoxedProduct",)),
    Entity("product/hole", ("vrps:Hole",), part_of="product", pose=Pose()),
    Entity("table", ("soma:Table",), pose=Pose((0, 1, 0)), geoms=(Geom("box", (0.5, 0.4, 0.02), Pose((0, 0, -0.02))),)),
    Entity("shelf", ("dul:PhysicalObject",), pose=Pose((0, 3, 0))),
    Entity("shelf/top", ("soma:Surface",), part_of="shelf"),
)


def state(type_: str, start: float = 0.0, end: float = 2.0, **roles: str) -> Event:
    return Event(f"{type_}{start}{sorted(roles.items())}", type_, "state", start, end, roles)


def line(*points: tuple[float, float, float, float]) -> Track:
    keys = np.array(points)
    times = np.arange(keys[0, 0], keys[-1, 0] + 1e-9, 0.05)
    poses = np.zeros((len(times), 7))
    poses[:, 3] = 1
    for axis in range(3):
        poses[:, axis] = np.interp(times, keys[:, 0], keys[:, axis + 1])
    return Track(times, poses)


def phase(
    *events: Event, start: float = 1.0, end: float | None = None, tracks: dict[str, Track] | None = None
) -> Phase:
    """An instant, or an interval of a recording of ten seconds."""
    whole = Event("all", "soma:PhysicalAction", "action", 0, 10)
    episode = Episode("x", ENTITIES, (whole, *events), tracks or {}, "hand")
    timeline = Timeline(episode, TAXONOMY)
    return timeline.instant(start) if end is None else Phase(timeline, start, end)


def rows(name: str, at: Phase, *arguments: str | None) -> set[Row]:
    return set(at.rows(TABLE[name], arguments or (None,) * TABLE[name].arity))


def test_every_predicate_explains_itself() -> None:
    assert len(TABLE) == len(all_predicates())
    assert all(p.doc.endswith(".") and p.function.__doc__ for p in all_predicates())


def test_contact_is_symmetric_and_a_part_counts_for_the_whole() -> None:
    at = phase(state("soma:ContactState", a="hanger/peg", b="product"))
    assert rows("touches", at) == {
        ("hanger/peg", "product"),
        ("product", "hanger/peg"),
        ("hanger", "product"),
        ("product", "hanger"),
    }
    assert rows("touches", phase(state("soma:ContactState", 0, 0.5, a="hand", b="product"))) == set()


def test_a_thing_does_not_touch_its_own_parts() -> None:
    found = rows("touches", phase(state("soma:ContactState", a="hand/left", b="hand/right")))
    assert ("hand", "hand") not in found and {("hand/left", "hand/right"), ("hand/right", "hand/left")} <= found


def test_grasp_support_and_contact_are_separate() -> None:
    at = phase(state("cram:GraspState", gripper="hand", object="product"))
    assert rows("grasps", at) == {("hand", "product")}
    assert rows("supports", at) == rows("touches", at) == set()


def test_the_chain_is_the_effector_and_what_it_grasps() -> None:
    held = phase(state("cram:GraspState", gripper="hand", object="product"))
    assert rows("chain", held) == {("hand",), ("hand/left",), ("hand/right",), ("product",), ("product/hole",)}
    assert rows("chain", phase()) == {("hand",), ("hand/left",), ("hand/right",)}


def test_collisions_are_between_the_chain_and_the_rest() -> None:
    grasp = state("cram:GraspState", gripper="hand", object="product")
    inside, outside = (state("soma:ContactState", a=a, b="product") for a in ("hand/left", "hanger/peg"))
    assert rows("collides", phase(grasp, inside)) == set()
    assert ("product", "hanger") in rows("collides", phase(grasp, outside))
    assert rows("collides", phase(outside)) == set()


def test_a_short_collision_is_seen_while_it_matters() -> None:
    short = state("soma:ContactState", 1.4, 1.5, a="hand", b="table")
    assert rows("collides", phase(short, start=1.0, end=2.0))
    assert not rows("touches", phase(short, start=1.0, end=2.0))
    assert not rows("collides", phase(short, start=1.5, end=2.0))


def test_classes_parts_and_features() -> None:
    at = phase()
    assert rows("isa", at, None, "vrps:Peg") == {("hanger/peg", "vrps:Peg")}
    assert rows("isa", at, "hanger", "vrps:Peg") == set()
    assert {r[0] for r in rows("has", at, None, "soma:Surface")} == {"table", "shelf", "shelf/top"}
    assert rows("has", at, "product", "soma:Surface") == set()
    assert ("hanger", "hanger/peg") in rows("part", at)
    assert rows("thing", at) == {("hanger",), ("product",), ("table",), ("shelf",)}


@pytest.mark.parametrize(("support", "dof"), [("hanger/peg", 4.0), ("hanger", 1.0)])
def test_constrained_dof_is_that_of_the_part_that_supports(support: str, dof: float) -> None:
    at = phase(state("soma:SupportState", supporter=support, supportee="product"))
    assert rows("constrained_dof", at, "hanger", "product") == {("hanger", "product", dof)}


def test_arm_motion_is_the_largest_excursion() -> None:
    there_and_back = {"hand": line((0, 0, 0, 0), (1.5, 0.2, 0, 0), (3, 0, 0, 0))}
    assert rows("arm_moves", phase(start=0.0, end=3.0, tracks=there_and_back)) == {()}
    tremor = {"hand": line((0, 0, 0, 0), (1.5, 0.0005, 0, 0), (3, 0, 0, 0))}
    assert rows("arm_moves", phase(start=0.0, end=3.0, tracks=tremor)) == set()


def test_what_is_driven_goes_the_way_of_the_hand() -> None:
    hand = line((0, 0, 0, 0), (3, 0.3, 0, 0))
    pushed = {"hand": hand, "product": line((0, 0.1, 0, 0), (3, 0.4, 0, 0))}
    falling = {"hand": hand, "product": line((0, 0.1, 0, 0), (3, 0.1, 0, -0.4))}
    assert rows("driven", phase(start=0.0, end=3.0, tracks=pushed), "product") == {("product",)}
    assert rows("driven", phase(start=0.0, end=3.0, tracks=falling), "product") == set()
    assert rows("moves", phase(start=0.0, end=3.0, tracks=falling), "product") == {("product",)}


def test_finger_tips_give_the_opening() -> None:
    def tips(last: float) -> dict[str, Track]:
        return {"hand/left": line((0, 0, 0, 0), (3, 0, 0, 0)), "hand/right": line((0, 0.1, 0, 0), (3, last, 0, 0))}

    assert rows("gripper_moves", phase(start=0.0, end=3.0, tracks=tips(0.01))) == {()}
    assert rows("gripper_moves", phase(start=0.0, end=3.0, tracks=tips(0.09))) == set()
    assert rows("gripper_open", phase(start=0.0, tracks=tips(0.01))) == {()}
    assert rows("gripper_closed", phase(start=3.0, tracks=tips(0.01))) == {()}
    assert rows("gripper_closed", phase(start=3.0, tracks=tips(0.09))) == set()


@pytest.mark.parametrize(
    ("position", "holds"), [((0.3, 1.2, 0.3), True), ((0.7, 1, 0.3), False), ((0, 1, -0.3), False)]
)
def test_in_or_above_is_over_the_footprint(position: tuple[float, float, float], holds: bool) -> None:
    at = phase(tracks={"product": line((0, *position), (3, *position))})
    assert (("product", "table") in rows("in_or_above", at)) == holds


@pytest.mark.parametrize(("height", "holds"), [(-0.02, True), (-0.035, True), (-0.045, False)])
def test_in_or_above_is_also_in_a_cavity_that_ends_below_the_walls(height: float, holds: bool) -> None:
    rack = Entity("rack", ("soma:Shelf",), pose=Pose((0, 0, 0)), geoms=(Geom("box", (0.2, 0.1, 0.1), Pose((0, 0, 0.11))),))
    size = {"width": 0.3, "depth": 0.15, "height": 0.08}
    room = Entity("rack/room", ("cram:Cavity",), part_of="rack", pose=Pose((0, 0, 0.05)), properties=size)
    bowl = Entity("bowl", ("soma:Bowl",), pose=Pose((0.05, 0, height)))
    whole = Event("all", "soma:PhysicalAction", "action", 0, 10)
    timeline = Timeline(Episode("x", (*ENTITIES, rack, room, bowl), (whole,), {}, "hand"), TAXONOMY)
    assert (("bowl", "rack") in rows("in_or_above", timeline.instant(1.0))) == holds


def test_reach_is_to_the_surface_of_the_box() -> None:
    at = phase(start=1.0, end=2.0, tracks={"hand": line((0, 0.6, 1, 0.3), (3, 0.6, 1, 0.0))})
    assert ("table",) in rows("approaches", at)
    assert ("table",) in rows("within_reach", at)
    assert ("hanger",) not in rows("within_reach", at)


def test_states_are_closed_at_the_start_and_open_at_the_end() -> None:
    grasp = state("cram:GraspState", 1.0, 2.0, gripper="hand", object="product")
    held = [bool(rows("grasps", phase(grasp, start=t))) for t in (0.99, 1.0, 1.99, 2.0)]
    assert held == [False, True, True, False]
    assert rows("grasps", phase(grasp, start=1.0, end=2.0))
    assert not rows("grasps", phase(grasp, start=0.9, end=2.0))


def test_a_state_at_the_end_of_the_recording_goes_on() -> None:
    grasp = state("cram:GraspState", 8.0, 10.0, gripper="hand", object="product")
    assert rows("grasps", phase(grasp, start=10.1))


def test_the_log_is_believed_about_its_own_action_only() -> None:
    label = Event("r", "soma:Reaching", "action", 1, 2, {"object": "product"})
    timeline = phase(label).timeline
    during = timeline.phases(Segment(1, 2, label))["run"]
    assert ("soma:Reaching", "product") in rows("labelled", during, "soma:Reaching", None)
    assert rows("labelled", Phase(timeline, 0.0, 10.0), "soma:Reaching", None) == set()


def swung(count: int, height: float, period: float) -> dict[str, Track]:
    """A product that goes up and down so often, and rests before and after."""
    turns = [(1 + k * period, 0.5, 0.0, 1.0 + height * (k % 2)) for k in range(count + 1)]
    return {"product": line((0, 0.5, 0, 1.0), *turns, (9, *turns[-1][1:]))}


@pytest.mark.parametrize(
    ("count", "height", "period", "seen"),
    [(6, 0.04, 0.4, 6), (1, 0.04, 0.4, 1), (6, 0.01, 0.4, 0), (6, 0.04, 1.2, 0), (0, 0.0, 0.4, 0)],
    ids=["six swings", "lifted once", "trembling", "slowly", "at rest"],
)
def test_swings_are_counted(count: int, height: float, period: float, seen: int) -> None:
    found = rows("swings", phase(start=0.5, end=9.0, tracks=swung(count, height, period)), "product")
    assert found == {("product", float(seen))}


def test_what_is_near_a_place_of_unknown_size() -> None:
    at = {n: phase(start=0.0, tracks={"product": line((0, x, 3, 0), (3, x, 3, 0))}) for n, x in (("near", 0.28), ("far", 0.32))}
    assert rows("near", at["near"], "product", "shelf") == {("product", "shelf")}
    assert rows("near", at["far"], "product", "shelf") == set()


@pytest.mark.parametrize(
    ("name", "arguments", "reason"),
    [
        ("within_reach", ("product",), "no pose of 'product'"),
        ("near", ("product", "table"), "no pose of 'product'"),
        ("in_or_above", ("table", "shelf"), "no shape of 'shelf'"),
        ("in_or_above", ("shelf", "table"), None),
        ("gripper_open", (), "no fingers of the hand"),
        ("grasps", ("hand", "product"), "no grasps were recorded"),
        ("touches", ("hand", "product"), "no contacts were recorded"),
        ("isa", ("hanger", "vrps:Peg"), None),
    ],
)
def test_what_cannot_be_told_says_why(name: str, arguments: tuple[str, ...], reason: str | None) -> None:
    unknown = TABLE[name].unknown
    assert unknown is not None and unknown(phase(), *arguments) == reason


def test_who_records_contacts_would_have_recorded_grasps() -> None:
    unknown = TABLE["grasps"].unknown
    assert unknown is not None and unknown(phase(state("soma:ContactState", a="hand", b="product")), "hand", "product") is None


@pytest.mark.parametrize(
    ("x", "width", "between"), [(0.006, 0.016, True), (0.006, 0.008, False), (0.010, 0.016, False), (0.006, None, False)]
)
def test_what_is_between_the_edges_of_pads_is_between_the_fingers(x: float, width: float | None, between: bool) -> None:
    """A mug's round side was held by the ends of the pads' edges, and not between their middles; beside the pads nothing is held."""
    pad = {"pad_length": 0.02} | ({"pad_width": width} if width else {})
    fingers = [Entity(f"hand/{side}", ("soma:Finger",), part_of="hand", properties=pad) for side in ("left", "right")]
    post = Entity("post", ("dul:PhysicalObject",), pose=Pose(), geoms=(Geom("box", (0.003, 0.01, 0.1), Pose((x + 0.003, 0.0, 0.0))),))
    tracks = {f"hand/{side}": line((0, 0, y, 0), (10, 0, y, 0)) for side, y in (("left", -0.024), ("right", 0.024))}
    whole = Event("all", "soma:PhysicalAction", "action", 0, 10)
    episode = Episode("x", (Entity("hand", ("soma:Hand",)), *fingers, post), (whole,), tracks, "hand")
    assert (("post",) in rows("between_fingers", Timeline(episode, TAXONOMY).instant(1.0))) == between


@pytest.mark.parametrize(("z", "there"), [(0.012, True), (0.006, False), (-0.012, False)])
def test_an_area_that_begins_over_its_face_has_no_origin_below_that(z: float, there: bool) -> None:
    size = {"width": 0.1, "depth": 0.1}
    assert in_extent("vrps:SurfaceFeature", {**size, "lowest": 0.007}, np.array([0.0, 0.0, z])) == there
    assert in_extent("vrps:SurfaceFeature", size, np.array([0.0, 0.0, z])) == (z > -0.01)
