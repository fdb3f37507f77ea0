"""What is decided when a run ended or was stopped, on runs written by hand."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engine.test_going_on import GOAL, TASKS
from helpers.short_runs import COUNT, good
from helpers.watched_runs import proof, readings
from msgspec.structs import replace

from cramlite import Engine, read_scenario
from cramlite.engine.recovery.expectation import RunWatch
from cramlite.engine.recovery.going_on import ACKNOWLEDGED, SAME, GoingOn, _declared
from cramlite.engine.recovery.next_program import _moved
from cramlite.engine.recovery.replanning import BACK, Attempt, Round
from cramlite.engine.recovery.rest_of_plan import rests_of_plan
from cramlite.model import Action, Code, Deviation, MoveJoints, Notice, Object, Plan, Pose, Program
from cramlite.model.belief import initial_belief
from cramlite.model.fault import Fault, FaultKind
from cramlite.model.run.rollout import Message
from cramlite.model.world.world import InHand, RobotMount
from cramlite.perception.active_perception import Look, Picture
from cramlite.planning.search.state import State
from cramlite_plugins.robots.ur5e import UR5E

LINES = {1: "1.Grasping/close", 3: "2.PickingUp/lift", 5: "3.Placing/lower"}
PLAN = Plan("p", (), tuple(Action(name, "soma:x") for name in ("1.Grasping", "2.PickingUp", "3.Placing")))
ON_SHELF = Pose((0.45, -0.35, 0.21))


@cache
def engine() -> Engine:
    return Engine()


@pytest.fixture
def going(tmp_path: Path) -> GoingOn:
    return made(tmp_path, GOAL)


@pytest.fixture
def with_tasks(tmp_path: Path) -> GoingOn:
    return made(tmp_path, GOAL.replace("goal: [block on shelf]\n", TASKS))


def made(folder: Path, text: str) -> GoingOn:
    (folder / "scenario.yaml").write_text(text)
    return GoingOn(read_scenario(folder / "scenario.yaml"), engine(), 0, lambda said: None)


def ended(going: GoingOn, ran: Sequence[tuple[int, int]] = ((3, COUNT),), **changed: Any) -> Round:
    """A run of so many samples in each line, with fields of its record changed."""
    run, base = changed.pop("origins", LINES), good().rollout
    assert base is not None
    lines = np.concatenate([np.full(count, float(line)) for line, count in ran])
    world = changed.pop("world", going.setting.world)
    program = Program("p", "arm", "ur5e", Pose(), world.robots[0].joints, (), ())
    attempt = Attempt(PLAN, program, Code("urscript", "", run, ".script"), world)
    return Round(attempt, replace(base, world=world, lines=lines, **changed))


def watch(going: GoingOn, block: Pose | None = None, **changed: Any) -> RunWatch:
    """The watcher of a run, that read things where they are believed at last, or the block elsewhere."""
    found, world = RunWatch(proof()), going.setting.world
    poses = {t.name: t.pose for t in world.things if t.movable} | ({"block": block} if block else {})
    usual: dict[str, Any] = {"joints": world.robots[0].joints, "opening": 0.085, "poses": poses}
    found.rest(readings(5.0, **(usual | changed)))
    return found


# Why a stretch ended


def test_what_was_noticed_is_why_it_ended(going: GoingOn) -> None:
    seen = watch(going)
    seen.notice = Notice(Deviation.MOVED, 1.0, "it moved")
    assert going._noticed(seen, ended(going, outcome="noticed")) is seen.notice
    assert going._noticed(seen, ended(going, outcome="killed", reason="gone")) != seen.notice


@pytest.mark.parametrize(
    ("outcome", "kind"),
    [
        ("halted", Deviation.REFUSED),
        ("protective stop", Deviation.STOPPED),
        ("killed", Deviation.KILLED),
        ("timeout", Deviation.REFUSED),
    ],
)
def test_a_run_that_did_not_finish_says_why_and_where(going: GoingOn, outcome: str, kind: Deviation) -> None:
    found = going._noticed(watch(going), ended(going, outcome=outcome, reason="so it was"))
    assert found is not None and (found.kind, found.reason) == (kind, "so it was")
    assert found.step == "2.PickingUp/lift"


@pytest.mark.parametrize(
    ("ran", "sample"),
    [
        ([(0, 10), (1, 20), (0, 70)], 30),
        ([(0, 10), (1, 20), (0, 5), (3, 20), (0, 45)], 55),
        ([(1, COUNT)], COUNT - 1),
        ([(1, COUNT - 1), (0, 1)], COUNT - 1),
        ([(0, COUNT)], COUNT - 1),
        ([(1, 1), (0, COUNT - 1)], 1),
    ],
)
def test_a_run_ends_after_its_last_line(going: GoingOn, ran: list[tuple[int, int]], sample: int) -> None:
    """A way from there on, in which nothing runs, is that of an arm that brakes."""
    for more in ({"outcome": "killed"}, {"outcome": "finished"}):
        done = ended(going, ran, **more)
        found = going._noticed(watch(going), done)
        assert found is not None and found.time == done.rollout.times[sample]


def test_a_program_that_finished_is_asked_whether_its_goal_holds(going: GoingOn) -> None:
    done = ended(going, outcome="finished")
    found = going._noticed(watch(going), done)
    assert found is not None and (found.kind, found.step) == (Deviation.GOAL_MISSED, "2.PickingUp/lift")
    assert found.reason == "'block on shelf' does not hold in the world as it was read"
    assert going._noticed(watch(going, ON_SHELF), done) is None
    going.goal = None
    assert going._noticed(watch(going), done) is None


def test_after_the_way_back_the_goal_is_still_to_be_reached(going: GoingOn) -> None:
    back = ended(going, outcome="finished", origins={1: BACK})
    for block in (None, ON_SHELF):
        found = going._noticed(watch(going, block), back)
        assert found is not None and (found.kind, found.step) == (Deviation.GOAL_MISSED, BACK)


def test_a_goal_about_what_is_not_there_does_not_hold(going: GoingOn) -> None:
    going.goal = ("zebra on shelf",)
    assert not going._holds(watch(going))


# Whether it goes on


LOST = Notice(Deviation.READINGS_LOST, 1.0, "no poses can be read", "2.PickingUp/lift")
BLIND = "there are no readings; when they are back, execute again with --replan"


def decided(going: GoingOn, notice: Notice, done: Round | None = None, given_up: bool = False) -> str:
    """What is said where no poses can be read: whatever passes the decisions before is told so."""
    following, said = going._decided(
        done or ended(going), watch(going, poses=None), notice, given_up=given_up
    )
    assert following is None
    return said


def test_without_readings_nothing_is_proven(going: GoingOn) -> None:
    assert decided(going, LOST) == BLIND


def test_the_last_program_that_is_allowed_is_the_last(going: GoingOn) -> None:
    assert decided(going, LOST, given_up=True) == "the allowed number of programs was executed"


def test_the_third_of_the_same_in_a_step_is_not_tried_again(going: GoingOn) -> None:
    """Also where the step has another number; another thing, step or deviation is another one."""
    assert SAME == 2
    again = replace(LOST, step="7.PickingUp/lift")
    others = [replace(LOST, step="2.PickingUp/close"), replace(LOST, thing="block")]
    others += [replace(LOST, kind=Deviation.SLIP)]
    said = [decided(going, n) for n in (LOST, again, *others, *others, LOST)]
    assert said[:-1] == [BLIND] * 8
    assert said[-1] == "the same deviation was noticed 3 times, so another try would not help"
    assert decided(going, LOST).startswith("the same deviation was noticed 4 times")
    assert decided(going, LOST, ended(going, origins={1: BACK})) == BLIND


STOP = Fault(FaultKind.STOP, after=2.0)


def stopped(going: GoingOn, *texts: str, declared: Sequence[Fault] = (STOP,)) -> Round:
    """A run in which faults happened with such words, in a world with these faults."""
    world = replace(going.setting.world, faults=tuple(declared))
    messages = tuple(Message(2.0, text) for text in texts)
    return ended(going, outcome="protective stop", world=world, faults=messages)


def test_only_a_stop_that_the_world_declares_is_gone_on_from(going: GoingOn) -> None:
    stop = Notice(Deviation.STOPPED, 2.0, "too fast", "2.PickingUp/lift")
    said = str(STOP)
    assert decided(going, stop, stopped(going, said)) == BLIND
    killed = Fault(FaultKind.KILLED)
    for done in (stopped(going), stopped(going, "another"), stopped(going, said, declared=()),
                 stopped(going, str(killed), declared=(killed,))):  # fmt: skip
        assert not _declared(done) and decided(going, stop, done) == ACKNOWLEDGED
        going.noticed.clear()
    assert _declared(stopped(going, "another", said))
    assert decided(going, replace(stop, kind=Deviation.KILLED), stopped(going)) == BLIND


def test_a_goal_that_holds_already_is_reached(going: GoingOn) -> None:
    moved = Notice(Deviation.MOVED, 1.0, "it moved")
    assert going._next(ended(going), watch(going, ON_SHELF), moved) == (None, "the goal holds as things are")


def test_another_goal_is_taken_over_where_that_was_noticed(going: GoingOn) -> None:
    changed, reached = Notice(Deviation.GOAL_CHANGED, 1.0, "block on floor"), "the goal holds as things are"
    asked = watch(going, goal=("block on floor",))
    assert going._next(ended(going), asked, changed) == (None, reached) and going.goal == ("block on floor",)
    other = ("block on shelf",)
    moved = replace(changed, kind=Deviation.MOVED)
    assert going._next(ended(going), watch(going, goal=other), moved)[1] == reached
    assert going._next(ended(going), watch(going, goal=()), changed)[1] == reached
    assert going.goal == ("block on floor",)


@pytest.mark.parametrize(
    ("step", "moves"), [("2.PickingUp/lift", True), ("2.PickingUp/lift", False), (BACK, True)]
)
def test_where_nothing_is_proven_the_arm_goes_back_once(going: GoingOn, step: str, moves: bool) -> None:
    """The way that it came, if it came one, and was not on its way back."""
    going.goal = ("zebra on shelf",)
    joints = UR5E.home + np.outer(np.linspace(0.0, 0.1 if moves else 0.0, COUNT), [0, 0, 0, 0, 0, 1])
    done = ended(going, origins={1: step}, joints=joints)
    seen = watch(going, joints=tuple(joints[-1].tolist()))
    following, said = going._next(done, seen, Notice(Deviation.MOVED, 1.0, "it moved"))
    if step == BACK or not moves:
        assert following is None and said.startswith("no program was proven from here. ")
    else:
        assert said == "the arm goes back the way it came: no program was proven from here" and following is not None
        (back,) = following.program.steps
        assert isinstance(back, MoveJoints) and back.origin == BACK
        assert back.path[-1] == pytest.approx(UR5E.home, abs=1e-6)


def test_what_is_in_the_hand_is_told(going: GoingOn) -> None:
    """That of the robot whose program ran, the first."""
    world = going.setting.world
    two = replace(world, robots=(*world.robots, RobotMount("other", "ur5e")))
    going.setting = replace(going.setting, world=two)
    going.goal = ("zebra on shelf",)
    block = going.setting.world.thing("block").pose
    for pressing, said in ((40.0, ", with 'block' in the hand. "), (0.0, ". ")):
        seen = watch(going, tool=block, opening=0.05, pressing=pressing)
        found = going._next(ended(going), seen, Notice(Deviation.MOVED, 1.0, "it moved"))
        assert found[0] is None and found[1].startswith(f"no program was proven from here{said}")


# What is believed then


@pytest.mark.parametrize(("off", "stays"), [(0.0049, True), (0.0051, False)])
def test_relations_of_what_stayed_are_believed_on(going: GoingOn, off: float, stays: bool) -> None:
    relations = (("on", "block", "floor"), ("on", "can", "floor"))
    going.setting = replace(going.setting, relations=relations)
    block = going.setting.world.thing("block").pose
    x, y, z = block.position
    going._believe(ended(going), watch(going, Pose((x, y + off, z))))
    assert going.setting.relations == (relations if stays else relations[1:])
    assert going.setting.world.thing("block").pose.position == (x, y + off, z)


def test_poses_that_a_camera_saw_at_the_start_give_way_to_readings(going: GoingOn) -> None:
    world, joints = going.setting.world, tuple(v + 0.1 for v in UR5E.home)
    start = initial_belief(world, world.robots[0].name, UR5E.home, 0.085)
    nothing: Any = None
    taken = Picture(nothing, nothing, (), State((), start))
    seen = {"block": replace(start.poses["block"], source="seen by the camera")}
    going.setting = replace(going.setting, look=Look((taken,), world, (), seen, world))
    going._believe(ended(going), watch(going, ON_SHELF, joints=joints))
    belief = going.setting.start(PLAN).belief
    assert belief.poses["block"].pose == ON_SHELF and belief.joints == joints


def test_what_came_meanwhile_has_no_place_that_it_left(going: GoingOn) -> None:
    """A thing that nobody knew of is believed where it is read, and no relation of it is."""
    world = going.setting.world
    going.setting = replace(
        going.setting, relations=(("on", "can", "floor"),), world=replace(world, things=world.things[:2])
    )
    seen = watch(going, poses={t.name: t.pose for t in world.things if t.movable})
    going._believe(ended(going, world=world), seen)
    assert going.setting.world.thing("can").pose == world.thing("can").pose and going.setting.relations == ()


@pytest.mark.parametrize(
    ("ran", "at"), [([(1, COUNT)], 0), ([(3, COUNT)], 1), ([(3, 50), (5, 50)], 2), ([(0, COUNT)], 0)]
)
def test_the_task_under_way_is_that_of_the_last_step(
    going: GoingOn, ran: list[tuple[int, int]], at: int
) -> None:
    going.at = 1
    going._believe(ended(going, ran), watch(going))
    assert going.at == at
    going._believe(ended(going, origins={1: BACK}), watch(going))
    assert going.at == at, "the way back is no task"


# What of a list of tasks is left


@pytest.mark.parametrize(
    ("at", "held", "starts"),
    [(0, False, [0]), (2, False, [2, 1, 0]), (1, True, [1, 2]), (2, True, [2]), (0, True, [0, 1])],
)
def test_the_rest_begins_with_the_task_under_way_or_one_near_it(
    with_tasks: GoingOn, at: int, held: bool, starts: list[int]
) -> None:
    if held:
        mount = replace(with_tasks.setting.world.robots[0], holds=InHand("block", Pose(), 40.0))
        with_tasks.setting = replace(
            with_tasks.setting,
            world=replace(with_tasks.setting.world, robots=(mount, RobotMount("other", "ur5e"))),
        )
    names = [a.name for a in PLAN.actions]
    rests = rests_of_plan(PLAN, at, "", with_tasks.setting, with_tasks.engine.knowledge)
    assert [[a.name for a in p.actions] for p in rests] == [names[k:] for k in starts]


@pytest.mark.parametrize(
    ("step", "rests"),
    [
        ("1.PickAndPlace/Grasping/close", [["1.PickingUp", "1.Placing"], ["1.Placing"]]),
        ("1.PickAndPlace/PickingUp/lift", [["1.PickingUp", "1.Placing"], ["1.Placing"]]),
        ("1.PickAndPlace/Placing/PuttingDown/lower", [["1.Placing"]]),
    ],
)
def test_of_a_task_with_parts_the_rest_begins_with_the_part_under_way(with_tasks: GoingOn, step: str, rests: list[list[str]]) -> None:
    roles = {"Locatum": Object("block", entity="block"), "Relatum": Object("shelf", entity="shelf")}
    whole, then = Action("1.PickAndPlace", "cram:PickAndPlace", roles), Action("2.ParkingArms", "soma:AssumingArmPose")
    mount = replace(with_tasks.setting.world.robots[0], holds=InHand("block", Pose(), 40.0))
    with_tasks.setting = replace(with_tasks.setting, world=replace(with_tasks.setting.world, robots=(mount,)))
    rests_found = rests_of_plan(Plan("p", (), (whole, then)), 0, step, with_tasks.setting, with_tasks.engine.knowledge)
    found = [[a.name for a in p.actions] for p in rests_found]
    assert found == [["1.PickAndPlace", "2.ParkingArms"], *([*rest, "2.ParkingArms"] for rest in rests), ["2.ParkingArms"]]


# How far a thing moved


def test_a_thing_moved_as_far_as_it_was_from_its_start_at_most() -> None:
    run = good().rollout
    assert run is not None
    way = run.poses["cup"].copy()
    way[1:20, 2] -= 0.01
    way[20:30, :3] += (0.03, 0.0, 0.04)
    way[30:, :3] += (0.01, 0.0, 0.0)
    way[40:, 3:] = 0.5
    assert _moved(replace(run, poses={"cup": way}), "cup") == pytest.approx(0.05)
