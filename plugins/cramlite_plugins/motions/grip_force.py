"""Grip force: from a thing's weight, the friction of pads and thing, and a margin; limited by gripper and
thing.

Two pads that press with F each hold 2 mu F along their faces. Asked for is, on each pad,

    F = s (m (g + a) (1 + d / r) + P) / (2 mu)

with the mass m, the pair's friction mu, the margin s, the acceleration a of the arm, the distance d of the centre of mass from the line
between the pads, the mean distance r of a pad's points from its middle (a pad that turns on a face resists with mu F r), and the push P
that a motion in contact may apply before it stops. The weight's part without d, s m (g + a) / (2 mu), is what a grasp cannot do without:
where the gripper or the thing does not bear that, it is refused. The others are given as far as both bear them.
"""

from __future__ import annotations

import math

from cramlite.model import GRAVITY, Gripper, Held, Pose, Remedy, Robot, Thing, Value, World, pair_friction
from cramlite.plugin import Context, Unresolvable

from ..shapes.bounds import centre_of_mass
from .motion_kinds import LIMIT
from .ontology_limits import Knowing, lowest

MARGIN = 2.5
"""Safety factor of the grip force: friction may be half of what is believed, and mass a fifth more, 1.2 / 0.5 = 2.4."""
ACCELERATION = 1.2
"""Acceleration of the tool that a grip must bear [m/s2]: URScript's default, and that of 1.4 rad/s2 of a leading axis at 0.85 m; straight
lines take 0.5."""


class GripLoad(Value):
    """Load on the two pads of a gripper, and the friction with which they hold it.

    Args:
        thing: what is gripped.
        mass: that hangs on the pads, contents included [kg]; 0 for what a joint carries.
        pads, surface: friction coefficients of the pads and of the thing's smoothest face.
        lever: of the centre of mass about the line between the pads [m].
        gripper: that grips.
    """

    thing: Thing
    mass: float
    pads: float
    surface: float
    lever: float
    gripper: Gripper

    @property
    def friction(self) -> float:
        """Friction coefficient of pads and thing."""
        return pair_friction(self.pads, self.surface)

    @property
    def least(self) -> float:
        """Force on each pad that the weight needs [N]; infinite without friction."""
        weight = MARGIN * self.mass * (GRAVITY + ACCELERATION)
        return weight / (2 * self.friction) if self.friction else math.inf if weight else 0.0

    @property
    def wanted(self) -> float:
        """Force on each pad that also holds the weight's moment and a motion's push [N], rounded up to
        whole newtons; infinite without friction."""
        if not self.friction:
            return self.least
        radius = math.hypot(*self.gripper.pad) / 4  # exact for a line; a rectangle's is up to a tenth larger
        return float(math.ceil(self.least * (1 + self.lever / radius) + MARGIN * LIMIT.default / (2 * self.friction)))

    def __str__(self) -> str:
        return (
            f"{self.mass:.3g} kg ({GRAVITY * self.mass:.1f} N) on friction {self.friction:.3g}"
            f" (pads {self.pads:g}, '{self.thing.name}' {self.surface:g})"
        )


def load(thing: Thing) -> float:
    """Return the mass of a thing in the hand, contents included [kg]; 0 for a thing on a joint, since the joint carries the thing."""
    content = thing.filling.count * thing.filling.mass if thing.filling else 0.0
    return 0.0 if thing.joint is not None else (thing.mass or 0.0) + content


def grip_of(held: Held, world: World, gripper: Gripper) -> GripLoad:
    """Return the load of the pads by a held thing with its content; 0 kg for a thing on a joint, which bears
    the weight."""
    thing = world.thing(held.thing)
    x, _, z = (held.tcp_to_thing * Pose(centre_of_mass(thing))).position
    mass = load(thing) and load(thing) + sum(load(world.thing(name)) for name in held.carries)
    return GripLoad(thing, mass, world.physics.pad_friction, thing.least_friction, math.hypot(x, z), gripper)


def grip_force(
    grip: GripLoad, asked: float, context: Context, of_thing: tuple[str, ...], within: tuple[str, ...], most: float = math.inf
) -> tuple[float, str]:
    """Return the force of each pad [N] and its source; a force that was asked for is kept, up to what the
    thing bears.

    Args:
        asked: 0 for what the weight needs [N].
        of_thing: names of the objects that the thing is: another thing, not another place, changes what it weighs.
        within: names of the actions that it is asked within: no other choice changes what is asked for.
        most: bound of a force that was not asked for [N]: what a motion's push would need beyond it is not given.

    Raises:
        Unresolvable: the gripper cannot press so, the thing bears less than the gripper's least, or its weight needs more than
            either can.
    """
    low, high = grip.gripper.force
    limit, why = _limit(grip, context, (*of_thing, *within))
    if asked and not low <= asked <= high:
        reason = f"a grip force of {asked:g} N is outside {low:g} .. {high:g} N of gripper '{grip.gripper.type}'"
        raise Unresolvable(reason, within, {"force_N": asked, "least_N": low, "most_N": high}, blocking=())
    if not asked and grip.least > limit:
        if (mass := grip.mass + grip.gripper.mass) > context.robot.payload:
            raise overload(grip.thing.name, mass, context.robot, (*of_thing, *within))
        raise _too_weak(grip, limit, why, (*of_thing, *within))
    wanted = asked or max(low, min(grip.wanted, max(grip.least, most)))
    instead = f" instead of {wanted:g} N, {why}" if wanted > limit else ""
    force = min(wanted, limit)
    source = _doubt(grip, force) if asked else f" for {grip}"
    return force, f"grip {force:g} N{instead}{source}" if source or instead else ""


def _doubt(grip: GripLoad, force: float) -> str:
    """Return a remark if a stated grip force is too small to carry the thing's weight; "" if it is large enough."""
    carried = 2 * grip.friction * force
    return f", which carries {carried:.1f} N: doubtful for {grip}" if carried < GRAVITY * grip.mass else ""


def _limit(grip: GripLoad, context: Context, because: tuple[str, ...]) -> tuple[float, str]:
    """Largest force that a pad may exert [N], and whether the gripper or the thing sets this limit."""
    low, high = grip.gripper.force
    borne = most_borne(grip.thing, context)
    limit, why = min((high, f"the most of gripper '{grip.gripper.type}'"), borne or (math.inf, ""), key=lambda x: x[0])
    if limit < low:
        reason = f"the gripper presses with {low:.0f} N at least, more than {limit:g} N: {why}"
        raise Unresolvable(reason, because, {"least_N": low, "limit_N": limit}, blocking=())
    return limit, why


def most_borne(thing: Thing, context: Knowing) -> tuple[float, str] | None:
    """Return the largest force that a pad may exert on a thing [N], and the source of this limit; None
    without a limit."""
    limits = list[tuple[float, str]]()
    if (said := lowest([thing], "cram:maximumGripForce", context)) is not None:
        limits.append((said.value, str(said)))
    if thing.max_grip_force is not None:
        limits.append((thing.max_grip_force, f"the max_grip_force of '{thing.name}'"))
    return min(limits, key=lambda x: x[0], default=None)


def overload(thing: str, mass: float, robot: Robot, because: tuple[str, ...]) -> Unresolvable:
    """Return the refusal of a load that is too heavy for the arm.

    Args:
        thing: the payload; "" if it is the gripper alone.
        mass: on the flange, gripper included [kg].
    """
    reason = f"{mass:.2f} kg on the flange, gripper included, > {robot.payload:g} kg that '{robot.type}' carries"
    what, over = f"'{thing}' with the gripper" if thing else "the gripper", mass - robot.payload
    says = f"{what} is {over:.2f} kg too heavy for '{robot.type}': make it lighter ('mass'), or take an arm that carries {mass:.2f} kg"
    numbers = {"load_kg": mass, "payload_kg": robot.payload}
    return Unresolvable(reason, because, numbers, blocking=(), remedy=Remedy(f"payload {what}", says, over))


def _too_weak(grip: GripLoad, limit: float, why: str, because: tuple[str, ...]) -> Unresolvable:
    numbers = {"weight_N": GRAVITY * grip.mass, "friction": grip.friction, "limit_N": limit}
    if math.isinf(grip.least):
        said = f"no grip force holds {grip}; {limit:g} N is {why}"
        return Unresolvable(said, because, numbers, blocking=(), remedy=_rougher(grip, limit))
    reason = (
        f"{grip} needs {grip.least:.0f} N on each pad, with a margin of {MARGIN:g} and {ACCELERATION:g} m/s2 of the arm,"
        f" > {limit:g} N, {why}"
    )
    return Unresolvable(reason, because, {**numbers, "needed_N": grip.least}, blocking=(), remedy=_rougher(grip, limit))


def _rougher(grip: GripLoad, limit: float) -> Remedy:
    """Return the advice for a thing that slips even at the highest grip force: more friction, less mass, or a
    stronger gripper."""
    weight = MARGIN * grip.mass * (GRAVITY + ACCELERATION)
    enough, mass = weight / (2 * limit), 2 * grip.friction * limit / (MARGIN * (GRAVITY + ACCELERATION))
    lighter = f", or make it lighter than {mass:.2g} kg" if mass > 0 else ""
    says = (
        f"the grip on '{grip.thing.name}' slips: friction {grip.friction:.2g} between pads and thing, {enough:.2g} is needed for "
        f"{grip.mass:.3g} kg at {limit:g} N: give thing ('friction') or pads ('physics: {{pad_friction: ...}}') more{lighter}, or take a "
        f"gripper that presses harder"
    )
    return Remedy(f"grip {grip.thing.name}", says, enough - grip.friction)
