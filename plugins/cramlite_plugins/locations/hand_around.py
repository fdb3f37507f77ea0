"""The hand around a bar: how wide its fingers open there, so that they touch neither what is beside it nor what is behind."""

from __future__ import annotations

from cramlite.model import Belief, GripFacts, Place, Pose, Thing
from cramlite.plugin import Context, Refused

from ..motion_planning.planning_scene import PlanningScene
from ..motion_planning.reach import collision_free_ik, make_scene
from ..motion_planning.space import refusal

STANDOFF = 0.08  # in front of the handle [m]: the fingers, open, are clear of the bar
SLACK = (0.05, 0.03, 0.016, 0.01)
"""How much wider than the bar the fingers open [m]: it may be off by half of that. The widest that nothing beside it forbids."""


class HandAround:
    """Hand of a belief around a handle of a thing, at each of its openings."""

    def __init__(self, belief: Belief, context: Context, thing: Thing) -> None:
        self.belief, self.context, self.thing = belief, context, thing
        self.scenes: dict[tuple[float, float], tuple[PlanningScene, PlanningScene, PlanningScene]] = {}

    def around(self, at: Pose, width: float, room: float = 0.0) -> Place | Refused:
        """Find the widest opening at which the hand, not closed yet, touches nothing at a pose and before it.

        Args:
            at: of the TCP, in the base frame.
            width: of what is to be between the fingers [m].
            room: about the hand that must be free there [m].
        """
        refused = refusal(f"the bar is {1000 * width:.0f} mm thick, as wide as the hand opens")
        before = at * Pose((0, 0, -STANDOFF))
        most = self.context.robot.gripper.opening[1]
        for opening in dict.fromkeys(round(min(width + s, most), 4) for s in SLACK if width + SLACK[-1] <= most):
            near, free, bare = self._scenes(opening, room)
            there = collision_free_ik(near, self.context, at, self.belief.joints)
            if not isinstance(there, Refused) and not bare.free(there):
                there = refusal(bare.why(there), collision=bare.collision(there))
            off = there if isinstance(there, Refused) else collision_free_ik(free, self.context, before, there)
            if not isinstance(off, Refused):
                return Place(at, before, opening, tuple(at.rotate((0, 0, 1))), thing=self.thing.name, grip=GripFacts(width))
            refused = off
        return refused

    def _scenes(self, opening: float, room: float) -> tuple[PlanningScene, PlanningScene, PlanningScene]:
        """Where the thing may be touched; where nothing may; and where nothing is, with so much room."""
        if (opening, room) not in self.scenes:
            belief, context = self.belief, self.context
            near, free = make_scene(belief, context, [self.thing.name], opening), make_scene(belief, context, (), opening)
            self.scenes[opening, room] = near, free, make_scene(belief, context, (), opening, clearance=room)
        return self.scenes[opening, room]
