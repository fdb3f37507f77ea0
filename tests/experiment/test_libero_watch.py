"""Belief that pictures of a run update: what moved, came, went and came back; nothing is recognised anew where all is as expected."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import ROOT
from msgspec.structs import replace

from cramlite import Engine
from cramlite.engine.recovery.expectation import Expectation, RunWatch
from cramlite.experiment.benchmark.protocol import module_of
from cramlite.model import Camera, Deviation, Joint, Looks, Pose, Readings, RobotMount, Thing, View, World
from cramlite_plugins.objects.products_and_fixtures import make

BELIEF, WATCH = (module_of(ROOT / "experiments" / "libero" / f"{name}.py") for name in ("picture_belief", "camera_watch"))
EYE, TARGET = np.array((1.5, 0.2, 0.9)), np.array((0.45, 0.0, 0.1))
CAMERA = Camera(Pose.from_axes(tuple(EYE), TARGET - EYE, np.cross(TARGET - EYE, (0, 0, 1))))
ARM = RobotMount("arm", "ur5e", joints=(0.0, -1.9, 2.2, -1.9, -1.57, 0.0), opening=0.05)


def box(name: str, x: float, y: float = 0.2) -> Thing:
    """A box of 80 mm on the table."""
    return make("block", name, Pose((x, y, 0.041)), {"size": (0.08, 0.08, 0.08), "mass": 0.2})


def world(*things: Thing) -> World:
    """Things on a table before an arm."""
    return World((make("table", "table", Pose((0.5, 0, -0.01)), {"size": (1.4, 1.6, 0.02)}), *things), (ARM,))


class Scene:
    """A belief of one box, and the real scene."""

    def __init__(self, engine: Engine) -> None:
        self.engine, self.asked, self.there = engine, 0, world(box("box_1", 0.5))
        region = (0.1, -0.8, -0.1), (1.1, 0.8, 0.6)
        self.belief = BELIEF.PictureBelief(engine, self.there, {"box_1": "box"}, self.view(), self.recognise, region)

    def view(self, camera: Camera = CAMERA) -> View:
        """A picture of the real scene."""
        view = self.engine.knowledge.simulator.look(self.there, self.engine.knowledge.robots_of(self.there), camera, seed=self.asked)
        return replace(view, camera=CAMERA.pose)

    def recognise(self, believed: World) -> tuple[list[Thing], list[Thing]]:
        """Boxes are a known kind, jars are not."""
        self.asked += 1
        things = [t for t in self.there.things if t.movable]
        return [replace(t, name="box") for t in things if "box" in t.name], [t for t in things if "box" not in t.name]

    def update(self, *things: Thing) -> set[str]:
        """Put other things there, and look."""
        self.there = world(*things)
        changed: set[str] = self.belief.update(self.view(), self.belief.world)
        return changed


@pytest.fixture
def scene() -> Scene:
    """A box, as it is believed."""
    return Scene(Engine())


def test_nothing_is_recognised_anew_where_all_is_as_expected(scene: Scene) -> None:
    assert scene.update(box("box_1", 0.505)) == set() and scene.asked == 0, "5 mm are no change"


def test_what_moved_is_believed_where_it_is_seen(scene: Scene) -> None:
    assert scene.update(box("box_1", 0.56)) == {"box_1"}
    assert scene.belief.world.thing("box_1").pose.position[0] == pytest.approx(0.56)
    assert scene.update(box("box_1", 0.56)) == set() and scene.asked == 1, "from then on it is expected there"


def test_what_came_is_believed_too_known_or_not(scene: Scene) -> None:
    changed = scene.update(box("box_1", 0.5), box("box_2", 0.6, -0.2), replace(box("jar", 0.7, 0.4), name="jar"))
    assert len(changed) == 2 and "box_1" not in changed
    assert sorted(round(scene.belief.world.thing(n).pose.position[1], 3) for n in changed) == [-0.2, 0.4]


def test_what_was_unknown_is_looked_at_again(scene: Scene) -> None:
    scene.update(box("box_1", 0.5), replace(box("jar", 0.6, -0.2), name="jar"))
    assert len(scene.belief.world.things) == 3
    scene.there = world(box("box_1", 0.5), box("box_2", 0.6, -0.2))
    scene.belief.update(scene.view(), scene.belief.world, afresh=True)
    assert [t.name for t in scene.belief.world.things] == ["table", "box_1", "box_1_new"]


def test_what_went_is_missed_and_what_comes_back_is_the_same(scene: Scene) -> None:
    assert scene.update() == {"box_1"}
    assert "box_1" not in {t.name for t in scene.belief.world.things}
    assert scene.update(box("box_9", 0.7, 0.4)) == {"box_1"}
    assert scene.belief.world.thing("box_1").pose.position == pytest.approx((0.7, 0.4, 0.041))


def test_a_camera_that_was_moved_tells_nothing_any_more(scene: Scene) -> None:
    scene.there = world(box("box_1", 0.58))
    askew = replace(CAMERA, pose=Pose.from_rotvec((0.02, 0, 0), (0, 0, 0.0873)) * CAMERA.pose)
    assert scene.belief.update(scene.view(askew), scene.belief.world) == set() and "camera was moved" in scene.belief.displaced
    assert scene.update(box("box_1", 0.58)) == set() and scene.asked == 0


def test_a_door_is_believed_as_far_open_as_it_is_seen() -> None:
    hinge = Joint("hinge", Pose((0.0, -0.1, 0.0)), 0.0, 2.0, parent="chest_1_main")
    base = replace(box("chest_1_main", 0.7, 0.0), mass=None)
    door = replace(box("chest_1_door", 0.6, 0.0), joint=hinge)
    for angle, expected in ((0.05, 0), (0.8, 1)):
        seen = SimpleNamespace(as_parts=lambda a=angle: (
            replace(base, name="chest"), replace(door, name="chest_door", pose=hinge.moved(door.pose, a), joint=replace(hinge, value=a)),
        ))  # fmt: skip
        found = BELIEF.turned([seen], world(base, door))
        assert len(found) == expected
        assert not found or door.moved_to(found["chest_1_door"]).joint.value == pytest.approx(angle)


def watch(scene: Scene, idle: Callable[[], None] = lambda: None) -> Any:
    """A watcher of a run that moves nothing."""
    still = np.array([[*t.pose.position, *t.pose.quaternion] for t in [box("box_1", 0.5)] * 2])
    tracks = {"box_1": still, "effector": np.array([[0.4, 0, 0.5, 1, 0, 0, 0]] * 2)}
    expected = Expectation(
        np.ones(2), np.array([0.0, 9.0]), tracks, {"box_1": still[:, :3]}, ("", ""), np.full(2, 0.05), np.zeros(2), np.zeros((2, 6)),
        ("box_1",), frozenset({"box_1", "table"}),
    )  # fmt: skip
    return WATCH.CameraWatch(RunWatch(expected), scene.belief, lambda: (scene.view(), ARM), idle)


def reading(number: int) -> Readings:
    """What the robot feels: nothing."""
    return Readings(0.05 * number, 1, tuple(ARM.joints or ()), 0.05, 0.0, 0.0, Pose((0.4, 0.0, 0.5)), (0.0, 1.0, 0.0))


def test_a_run_is_stopped_by_what_a_picture_shows(scene: Scene) -> None:
    watcher = watch(scene)
    assert not any(watcher.see(reading(k)) for k in range(12)), "all is where the proof has it"
    scene.there = world(box("box_1", 0.56))
    notices = [n for k in range(12, 22) if (n := watcher.see(reading(k)))]
    assert notices[0].kind is Deviation.MOVED and notices[0].thing == "box_1" and "60 mm" in notices[0].reason


def test_what_is_nowhere_stops_a_run_and_is_found_where_it_comes_to_rest(scene: Scene) -> None:
    falling = iter([world(box("box_1", 0.7, 0.3)), world(box("box_1", 0.8, 0.4)), *[world(box("box_1", 0.8, 0.4))] * 9])

    def idle() -> None:
        scene.there = next(falling)

    watcher = watch(scene, idle)
    scene.there = world()
    notice = next(n for k in range(12) if (n := watcher.see(reading(k))))
    assert notice.kind is Deviation.MISSING and notice.thing == "box_1"
    watcher.rest(reading(12))
    assert watcher.inner.last.poses["box_1"].position == pytest.approx((0.8, 0.4, 0.041))
    assert len([*falling]) == 8, "it was waited for until nothing moved"


def test_two_of_a_kind_are_the_nearest_together() -> None:
    believed, seen = [box("a", 0.5), box("b", 0.6)], [box("box", 0.58), box("box", 0.49), box("box", 0.9)]
    pairs, new = BELIEF.matched(believed, seen, {"a": "box", "b": "box"})
    assert {n: t.pose.position[0] for n, t in pairs.items()} == {"a": 0.49, "b": 0.58}
    assert [t.pose.position[0] for t in new] == [0.9]


def test_drawers_are_no_things_of_a_kind() -> None:
    drawer = replace(box("chest_1_drawer", 0.6), joint=Joint("slide", Pose(), 0.0, 0.2, parent="chest_1_main"))
    assert BELIEF.kinds_in([drawer, box("box_1_main", 0.5)], ["chest", "box"]) == {"box_1_main": "box"}


def test_things_and_parts_of_a_scene_of_kinds_have_the_looks_of_their_kind() -> None:
    kinds = [replace(box(kind, 0.5), looks=Looks((noun,))) for kind, noun in (("mug", "can"), ("mug_rack", "box"))]
    scene = world(box("mug_1_main", 0.4), box("mug_rack_1_main", 0.6), box("mug_rack_1_drawer", 0.7), box("hidden_1", 0.8))
    found = BELIEF.with_looks(scene, kinds)
    assert [t.looks.nouns for t in found.things] == [(), ("can",), ("box",), ("box",), ()]
