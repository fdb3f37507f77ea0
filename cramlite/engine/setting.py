"""Settings: the world, robot and initial state that a plan is to be carried out in."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from msgspec import field
from msgspec.structs import replace

from ..base.value import Value
from ..interpretation.fluents import SymbolicWorld, symbolic_world
from ..model.belief import Estimate, Held, initial_belief
from ..model.geometry import Pose
from ..model.handover import Handover
from ..model.run.judging_limits import JudgingLimits
from ..model.twins.proof_doubts import ProofDoubts
from ..planning.operators import Grounder
from ..planning.search.state import State
from ..scenario.twin_places import Sight

if TYPE_CHECKING:
    from ..model.belief import Belief, Relation
    from ..model.plan import Plan
    from ..model.robot import Robot
    from ..model.world.world import InHand, World
    from ..ontology.taxonomy import Taxonomy
    from ..perception.active_perception import Look
    from ..planning.search.state import Item
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Backend
    from .late_poses import Tolerance


class Setting(Value):
    """Setting of a goal: world, robot, backend and the belief at the start.

    ``Engine.setting`` makes one from a scenario; ``cramlite.model.replace`` changes a field, and ``after`` goes on from where a
    program ended.

    Args:
        name: of the programs; what is no letter, digit or underscore in it becomes an underscore in their texts.
        world: the robot's world, as it is believed to be; poses in the world's frame, z up [m].
        relations: what is known to hold in it at the start: (predicate, thing, place).
        robot: the robot's model; the first mount of ``world`` acts.
        backend: writes the code.
        seed: of everything that is drawn, a whole number of at least 0; the same one gives the same programs.
        real: the world as it really is, where it differs from what is believed. No search and no proof sees it: an accepted
            program is executed in it (``Engine.execute``), and cameras look at it.
        look: the pictures that the belief comes from, where poses come from a camera; None where they are known.
        late: name of each thing whose pose is asked for when the program runs, and how far off it may be then [m, rad].
        force_limit: protective limit on the TCP force of its programs [N]; None for the robot's.
        limits: how far a run may disturb what no task is about.
        doubts: in how many twins programs are tried, how far those are off, and how many runs must succeed.
        title: of the scenario, for people; "" where it has none.
        asked: what is to be done, in words; "" where nobody wrote it down.
        carried: what lies in or on the payload at the start, directly or through others.
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
    force_limit: float | None = None
    limits: JudgingLimits = JudgingLimits()
    doubts: ProofDoubts = ProofDoubts()
    title: str = ""
    asked: str = ""
    carried: tuple[str, ...] = ()

    def belief(self) -> Belief:
        """Return the initial belief: poses, relations, joint values, and the payload."""
        mount = self.world.robots[0]
        at = self.robot.arm_at(mount.base) if self.robot.platform else None
        belief = initial_belief(self.world, mount.name, *self.robot.start(mount), self.relations, at)
        belief = replace(belief, poses={**belief.poses, **self._seen()})
        return belief.grasped(held_at_start(mount.holds, belief, self.carried)) if mount.holds else belief

    @property
    def sight(self) -> Sight | None:
        """Return the camera's last pose, and the things whose poses come from its pictures; None where the
        scenario states the poses of things."""
        look = self.look
        if look is None or look.camera is None:
            return None
        camera, mount = look.camera, self.world.robots[0]
        at = camera.pose
        if camera.mount is not None:
            from .late_poses import flange

            at = self.robot.arm_at(mount.base) * flange(self.robot, camera.joints or self.robot.start(mount)[0]) * camera.pose
        return Sight(Pose(at.position, at.quaternion), frozenset(look.estimates))

    def _seen(self) -> Mapping[str, Estimate]:
        """Estimates of the things that the camera saw, with the uncertainty of where the camera itself is (hand-eye)."""
        sight, errors = self.sight, self.doubts.errors
        if self.look is None or sight is None:
            return self.look.estimates if self.look else {}
        of, scale, eye = errors.hand_eye, errors.scale, sight.camera.position
        seen = {
            name: replace(e, sigma=math.hypot(e.sigma, scale * of.sigma(math.dist(eye, e.pose.position))))
            for name, e in self.look.estimates.items()
        }
        return {**seen, **{name: self._mapped(name, why) for name, why in self.look.unlocated.items()}}

    def _mapped(self, name: str, why: str) -> Estimate:
        """Estimate of a fixture that the camera looked for and did not locate: at the map's pose, as uncertain as declared."""
        errors = self.doubts.errors
        sigma = errors.scale * errors.of(name).sigma(0.0)
        return Estimate(self.world.thing(name).pose, sigma, f"known from the scenario, not located by the camera: {why}")

    def symbolic(self, taxonomy: Taxonomy) -> SymbolicWorld:
        """Return the symbolic state at the start for task planning: things, relations, the thing in the hand, and things
        that no task may move."""
        holds = next((robot.holds.thing for robot in self.world.robots if robot.holds), "")
        return replace(symbolic_world(self.now, taxonomy, self.relations), in_hand=holds, kept=frozenset(dict(self.limits.keep)))

    @property
    def now(self) -> World:
        """Believed world at the start of the plan: things that the robot moved to see behind or inside them are where it left them."""
        since = self.look.since if self.look else {}
        return self.world.put(since)

    def start(self, plan: Plan) -> State:
        """Return the state in which the search for a plan begins: the start or, after exploration, where the
        robot stopped.

        The steps that led there are part of it.
        """
        agenda: tuple[Item, ...] = (*plan.objects, *plan.actions)
        done = self.look.state if self.look else None
        if done is None:
            belief = self.belief()
            grip = belief.held.thing if belief.held else ""
            return State(agenda, belief, grip=grip, handovers=(Handover(grip, "", taken=True),) if grip else ())
        belief, since = self.belief().moved(done.belief.joints), self.look.since if self.look else {}
        poses = {n: replace(e, pose=since.get(n, e.pose)) for n, e in belief.poses.items()}
        return replace(done, agenda=agenda, belief=replace(belief, poses=poses), choices=())


def held_at_start(holds: InHand, belief: Belief, carried: Iterable[str] = ()) -> Held:
    """Return the belief about the payload at the start of a plan, with the things that lie in or on it."""
    there = belief.poses[holds.thing].pose.inverse()
    load = {n: replace(belief.poses[n], pose=there * belief.poses[n].pose) for n in carried if n in belief.poses}
    return Held(holds.thing, holds.tcp_to_thing, belief.opening, carries=load)


def with_load(setting: Setting, knowledge: Knowledge) -> Setting:
    """Return the setting with the names of all things that lie in or on the thing held at the start, directly
    or through others."""
    held = next((robot.holds.thing for robot in setting.world.robots if robot.holds), "")
    if not held:
        return replace(setting, carried=())
    grounder = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates)
    pairs = [grounder.fluents.carries(f) for f in sorted(grounder.initial) if grounder.fluents[f[0]].carrier is not None]
    found, new = [held], [held]
    while new:
        new = [above for below, above in dict.fromkeys(pairs) if below in new and above not in found]
        found += dict.fromkeys(new)
    return replace(setting, carried=tuple(found[1:]))
