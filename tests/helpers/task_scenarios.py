"""The scenarios of the task types: each with a sibling that must fail, and what that one's refusal must say."""

from __future__ import annotations

from functools import cache
from itertools import islice

from msgspec.structs import replace

from cramlite import Engine, NoSolution, Trace, find_scenario, read_scenario
from cramlite.engine.candidates import attempts
from cramlite.engine.execution import execute
from cramlite.engine.search_in_setting import search_in
from cramlite.model import Verdict
from cramlite.planning.search.budget import budget_of
from cramlite.plugin import Candidate
from cramlite.scenario.scenario import RobotSpec

REFUSED = {
    "assuming_arm_pose": "during 1.AssumingArmPose 'arm_moves()' does not hold",
    "assuming_arm_pose_constrained": "1.AssumingArmPoseConstrained/touch: no contact within 0.09 m",
    "closing": "before 1.Closing 'joint_open(Patient) or isa(Patient, soma:Lid) and not on_container(Patient)' does not hold",
    "close_gripper_task": "3.CloseGripperTask/close: an object stopped the fingers",
    "extract_hole_from_peg": "grip_strength: 'pack' slipped",
    "grasping": "after 1.Grasping 'grasps(Gripper, Patient)' does not hold",
    "holding": "before 3.Holding 'grasps(Gripper, Patient)' does not hold",
    "insert_hole_onto_peg": "3.InsertHoleOntoPeg/lower/attempt_5: no contact within 0.0135 m",
    "looking_at": "after 1.LookingAt 'in_view(Patient)' does not hold",
    "looking_for": "dul:PhysicalObject is no cram:CoffeePack",
    "navigating": "after 1.Navigating 'stands_at(Base, Destination)' does not hold",
    "no_op": "'arm/forearm_link' hit 'weight'",
    "opening": "1.Opening/pull: force",
    "open_gripper_task": "before 1.OpenGripperTask 'gripper_closed() or not gripper_open() and not grasps(Agent, _)' does not hold",
    "parking_arms": "during 1.ParkingArms 'arm_moves()' does not hold",
    "picking_up": "after 2.PickingUp 'grasps(Gripper, Locatum)' does not hold",
    "placing": "before 3.Placing/PuttingDown 'grasps(Gripper, Locatum)' does not hold",
    "pouring": "0 of 12 grains of 'jug' are in 'bowl', 11 are wanted",
    "pushing": "during 1.Pushing 'moves(Patient)' does not hold",
    "putting_down": "3.PuttingDown/lower: no contact within 0.03 m",
    "reaching": "during 1.Reaching 'approaches(Goal) or labelled(soma:Reaching, Goal)' does not hold",
    "releasing": "3.Releasing/PuttingDown/lower: no contact within 0.03 m",
    "retracting": "before 1.Retracting 'touches(Locatum, Relatum) or between_fingers(Relatum)' does not hold",
    "shaking": "during 3.Shaking 'swings(Patient) >= 5 or labelled(cram:Shaking, Patient)' does not hold",
    "sliding_gripper": "2.SlidingGripper/stroke: no contact for",
    "sliding_object": "2.SlidingObject/stroke: force",
    "transporting": "before 3.Transporting 'grasps(Gripper, Patient)' does not hold",
    "turning_off": "during 1.TurningOff 'joint_falls(Patient)' does not hold",
    "turning_on": "during 1.TurningOn 'joint_rises(Patient)' does not hold",
    "ungrasping": "from the middle of the opening of 'basket'",
}
"""Scenario -> words of the reason for which its failing variant ``NAME_fails`` is refused."""

MORE = {
    "opening_door": "soma:Opening", "opening_turned_away": "soma:Opening", "closing_drawer": "soma:Closing",
    "looking_at_mobile": "soma:LookingAt", "turning_on_switch": "cram:TurningOn", "pushing_around": "soma:Pushing",
    "placing_inside": "soma:Placing", "placing_deep": "soma:Closing", "laying_down": "soma:Placing", "tipping_under": "artm:Ungrasping",
}  # fmt: skip
"""Further scenarios that must be proven -> the task that each is about."""
BLOCKED = {
    "looking_at_hidden": "0 % of 'coffee' would be seen, 50 % is needed; 'board' hides most",
    "looking_for_far": "view_2: wrist centre at 1.945 m > 0.917 m of arm 'ur5e'",
    "looking_at_mobile_stays": "m > 0.917 m of arm 'ur5e_mobile'",
    "navigating_blocked": "from the start, 1272 places were looked at",
    "opening_blocked": "mm inside 'post'",
    "opening_turned_away_fails": "deg of its own motion 'door/handle' is",
    "pushing_around_fails": "inside 'fence'",
    "tipping_under_fails": "toppling: not lying there: 'book' is",
    "laying_down_fails": "at the grasp: 'effector/body' is",
    "pouring_full": "'bowl' would overflow: it holds 80 of",
    "placing_deep_fails": "collision: 'block' hit 'door' with",
    "placing_inside_low": "the room under the roof of 'cabinet' is -10 mm higher than 'block', 20 mm is needed",
    "placing_inside_shut": "no hand comes into 'cabinet': 'cabinet' and 'door' are on all sides of it",
}
"""Further scenarios that must be refused -> words of the reason."""


COMPOUND = {
    "pick_and_place": "4 kg (39.2 N) on friction 0.171 (pads 0.1, 'block' 0.6) needs 321 N on each pad",
    "from_drawer": "1.Opening/pull: force",
    "set_table": "mm left of 'bowl_stand', at least 20 mm is needed",
    "pour_and_put_back": "0 of 12 grains of 'jug' are in 'bowl', 11 are wanted",
}
"""Scenarios of several tasks -> words of the reason for which the failing variant ``NAME_fails`` is refused."""


def attempt(
    engine: Engine, name: str, seed: int = 0, robot: RobotSpec | None = None, folder: str = "tasks"
) -> tuple[Candidate | None, Verdict | None, str]:
    """Run and judge the first complete program of a scenario; return the candidate, the verdict, and all objections to it, or, if it was
    proven and there is a real world, those to its execution.

    Without a candidate the reasons are those of the search, or of the search for a place to look from.

    Args:
        robot: what its line ``robot:`` says instead.
        folder: below the shipped scenarios.
    """
    scenario = read_scenario(find_scenario(f"{folder}/{name}"))
    if robot is not None:
        scenario = replace(scenario, spec=scenario.spec.model_copy(update={"robot": robot}))
    try:
        setting, trace = engine.setting(scenario, seed=seed), Trace()
    except NoSolution as nowhere:  # the camera cannot be brought to where it is to look
        return None, None, str(nowhere)
    plan = next(plan for plan, _ in engine.plans(scenario, setting, trace))
    search = search_in(setting, engine.knowledge, replace(budget_of(scenario), proofs=1), trace)
    for candidate, verdict in islice(attempts(search, plan, setting, engine.knowledge, engine.executors), 1):
        if verdict.passed and setting.real is not None:
            done = execute(candidate, setting, engine.knowledge)
            candidate, verdict = done.candidate, done.verdict
        return candidate, verdict, "" if verdict.passed else verdict.reason
    return None, None, "; ".join(e.reason for e in trace.entries)


@cache
def engine() -> Engine:
    """Return the engine that all tests of a process share."""
    return Engine()


@cache
def attempted(name: str, folder: str = "tasks") -> tuple[Candidate | None, Verdict | None, str]:
    """Return the result of ``attempt`` at seed 0, computed once for all tests of a process."""
    return attempt(engine(), name, folder=folder)
