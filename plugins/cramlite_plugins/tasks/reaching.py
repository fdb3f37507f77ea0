"""soma:Reaching: bring the empty hand near an object."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl

from ..task_kit.preconditions import at_or_near, grasp_of

HOME = Location("home", "home")  # where a free motion leads when nothing follows it
# After a fast motion the arm is up to 5 mm behind, for up to 0.2 s [s]: measured, validators/postconditions.py. What follows
# may ask for an arm that stands (the fingers close), and nothing that follows goes on with this motion.
REST = 0.3


class Reaching(TaskType):
    task = "soma:Reaching"
    aliases = ("MoveToReach", "Reach")
    roles = (Role("Goal", required=False),)
    summary = "bring the empty hand near an object"
    slides = False
    leads_on = True
    touches = ()

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable.because_of_earlier_tasks(
                f"the gripper holds '{belief.held.thing}'; only an empty hand reaches"
            )
        goal = action.goal or self.leads_to(action, None, HOME)
        rest = Motion(action.inside("rest"), "hold", parameters={"duration_s": REST}, reason="the arm comes to rest")
        led = goal.relation != "near"  # what follows says where, and goes on with this motion
        if not led:  # where it could be grasped is better than just near it
            grasp = grasp_of(action.roles["Goal"])
            move = Motion(action.inside("move"), "transfer", grasp, reason=f"to the stand-off of {grasp}")
            yield Decomposition((grasp, move, rest), f"collision-free motion to {grasp}")
        move = Motion(action.inside("move"), "transfer", goal, reason=f"to the stand-off of {goal}")
        yield Decomposition((move,) if led else (move, rest), f"collision-free motion to {goal}", 1.0)

    def leads_to(self, action: Action, following: Action | None, goal: Location) -> Location:
        """Return the location at which the next task begins if that task is about the thing to be reached;
        else a location near that thing."""
        return at_or_near(action.roles.get("Goal"), following, goal)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Reaching()]
