"""A setting: where a plan is to be carried out, and from which state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from msgspec import field
from msgspec.structs import replace

from ..base.value import Value
from ..model.belief import initial_belief
from ..planning.state import State

if TYPE_CHECKING:
    from ..model.belief import Belief, Relation
    from ..model.plan import Plan
    from ..model.robot import Robot
    from ..model.world import World
    from ..perception.active_perception import Look
    from ..planning.state import Item
    from ..plugin.protocols import Backend
    from .late_poses import Tolerance



class Setting(Value):
    """Where a plan is to be carried out.

    Args:
        name: of the program.
        world: the robot's world.
        relations: what is known to hold in it.
        robot: the robot's model; the first mount of the world acts.
        backend: who writes the code.
        seed: of everything that is drawn.
        real: the world that programs run in, where it differs from what is believed; never shown to plugins.
        look: the picture that the belief comes from, where poses come from a camera.
        late: things whose poses are asked for when the program runs, and how far off they may be then [m, rad].
    """

    name: str
    world: World
    relations: tuple[Relation, ...]
    robot: Robot
    backend: Backend
    seed: int
    real: World | None = None
    look: Look | None = None
    late: Mapping[str, Tolerance] = field(default_factory=dict)

    def belief(self) -> Belief:
        mount = self.world.robots[0]
        at = self.robot.arm_at(mount.base) if self.robot.platform else None
        belief = initial_belief(self.world, mount.name, *self.robot.start(mount), self.relations, at)
        return replace(belief, poses={**belief.poses, **self.look.estimates}) if self.look else belief

    def start(self, plan: Plan) -> State:
        """Where the search begins: at home, or where the robot stands since it looked, with the steps that led there."""
        agenda: tuple[Item, ...] = (*plan.objects, *plan.actions)
        done = self.look.state if self.look else None
        if done is None:
            return State(agenda, self.belief())
        return replace(done, agenda=agenda, belief=self.belief().moved(done.belief.joints), choices=())
