"""Designators: symbolic descriptions of actions, objects, locations and motions.

A designator is *open* while it only describes, *late* when its value will be
known at run time, and *grounded* when a plugin has bound it. All are frozen; a
grounding is a new value beside the designator, never a change to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from msgspec import field
from msgspec.structs import force_setattr, replace

from ..base.value import Value
from .designator_name import part_name
from .entity_name import thing_of
from .geometry import Pose
from .place_facts import CarriedAlong, GripFacts, PegFit, Release
from .program.steps import Joints
from .program.swing import Swing


class Object(Value):
    """Object designator: description of something in the world that plays a role.

    Args:
        name: variable, the same for every task that means the same thing, e.g. "object_1".
        types: classes as CURIEs, most specific first; any subclass will do.
        features: feature classes it must have, e.g. ("vrps:Hole",).
        affords: affordances that it must offer, as CURIEs.
        like: classes that the demonstration's name for it suggests, likeliest first, where nobody said its class. A world
            without any such thing has to do with another one.
        filled: one that has contents is meant rather than one that has none.
        part_of: the variable of the whole, when this designates a feature (a peg of a hanger).
        entity: an instance asked for by name; scenarios may, plans from demonstrations never do.
    """

    name: str
    types: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    affords: tuple[str, ...] = ()
    part_of: str | None = None
    entity: str | None = None
    like: tuple[str, ...] = ()
    filled: bool = False

    def __str__(self) -> str:
        return f"{self.name}: {self.wanted}"

    @property
    def wanted(self) -> str:
        """Description, in words, of the object that this designator asks for: "block", or "tools:Cup with handle"."""
        what = " or ".join(self.types or self.like) or "anything"
        having = f" with {', '.join(self.features)}" if self.features else ""
        return f"{self.entity or what}{having}"

    @property
    def thing(self) -> str:
        """Name of the thing that the designator is about, also where it names a part of the thing; "" if it
        names none."""
        return thing_of(self.entity or "")

    def merged(self, other: Object) -> Object:
        """Return this object description merged with another: features and affordances of both, and this one's
        types or, if it states none, the other's."""
        features = tuple(dict.fromkeys((*self.features, *other.features)))
        affords = tuple(dict.fromkeys((*self.affords, *other.affords)))
        filled = self.filled or other.filled
        return replace(self, types=self.types or other.types, features=features, affords=affords, filled=filled)


class Location(Value):
    """Location designator: description of where the hand, or its payload, should be.

    Args:
        name: e.g. "grasp(object_1)"; tasks that name the same location share its grounding.
        relation: what the place is to the object: "grasp", "in", "on", "extract", "insert", "slide", "home", ...;
            "stand" is a place of the robot itself (a ``Stand``).
        of: variable of the reference object; None where the relation needs none.
        parameters: further constraints, by name.
    """

    name: str
    relation: str
    of: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.relation} of {self.of}" if self.of else self.relation


class Place(Value):
    """Grounded location: TCP poses in the robot's base frame.

    Args:
        pose: the TCP when there.
        before: where to stand off before going there.
        opening: finger distance to arrive with [m]; None where it does not matter.
        approach: unit vector of the last motion, base frame.
        path: further TCP poses from ``pose`` onwards, for locations that are traversed.
        rounds: how often a closed path is gone through.
        thing: the thing that is meant; "" for none.
        values: further numbers, for motions of a plugin's own, with units in their names.
        swing: of what is grasped there, as it is lifted; of what is laid down there, the part that it turns back;
            None for what is held fast.
        grip: of the thing there; None where nothing is grasped.
        release: of the payload there; None where nothing is let go of.
        carried: what comes along with the hand; None where nothing does.
        fit: of the payload's hole on a peg; None where there is none.
        reorients: whether the payload is turned there, so that it need not be kept as it is held.
        joints: joint position that is meant [rad]; None where any will do.
        via: further TCP poses on the way from ``before`` to ``pose``.
    """

    pose: Pose
    before: Pose
    opening: float | None = None
    approach: tuple[float, float, float] = (0.0, 0.0, 1.0)
    path: tuple[Pose, ...] = ()
    thing: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    swing: Swing | None = None
    grip: GripFacts | None = None
    release: Release | None = None
    carried: CarriedAlong | None = None
    fit: PegFit | None = None
    reorients: bool = False
    joints: Joints | None = None
    via: tuple[Pose, ...] = ()
    rounds: int = 1

    def __post_init__(self) -> None:
        """Set ``grip`` to the finger opening in ``values["width_m"]``, if a plugin stated it there."""
        if self.grip is None and "width_m" in self.values:
            force_setattr(self, "grip", GripFacts(self.values["width_m"]))

    @property
    def leaves_thing(self) -> bool:
        """Whether a thing stays at the place when the hand leaves: a payload that is released there, or a
        thing that was pushed or pulled there."""
        return self.release is not None or (self.carried is not None and self.carried.to_m is not None)


class Stand(Value):
    """Grounded location for a mobile robot: where its platform stands.

    Args:
        pose: of its platform, in the world: level, on the floor.
        thing: the thing that it stands at.
    """

    pose: Pose
    thing: str = ""


class Motion(Value):
    """Motion designator: a movement without its trajectory.

    Args:
        name: unique in the plan, e.g. "3.Grasping/approach".
        kind: a word that a motion plugin answers; those of cramlite: "transfer", "linear", "gripper", "until_contact",
            "force_path", "spiral_search", "force_insert", "force_extract", "compliant_slide", "payload", "zero_sensor",
            "hold", "tilt", "trace", "drive", "back" (docs/reference/motions.md).
        to: name of a location, or None.
        parameters: by name, with units in the name, e.g. {"speed_m_s": 0.05}.
        may_touch: variables or "held" that may be touched on the way.
        reason: why the task needs it, in a clause; it becomes the comment in the code.
    """

    name: str
    kind: str
    to: Location | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    may_touch: tuple[str, ...] = ()
    reason: str = ""

    def __str__(self) -> str:
        return f"{self.kind} to {self.to}" if self.to else self.kind


class Action(Value):
    """Action designator: a task to be executed.

    Args:
        name: unique in the plan, e.g. "3.Grasping".
        task: class as a CURIE, e.g. "soma:Grasping".
        roles: role name -> object.
        goal: where it leads, for tasks that have one.
        parameters: by name, with units in the name.
    """

    name: str
    task: str
    roles: Mapping[str, Object] = field(default_factory=dict)
    goal: Location | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.task.split(':')[-1]}({', '.join(f'{k}={v.name}' for k, v in self.roles.items())})"

    def inside(self, name: str) -> str:
        """Return the name of a part of this action: "3.Grasping/approach" for "approach"."""
        return part_name(self.name, name)


class Late(Value):
    """Object designator whose pose the program requests from perception while it runs.

    Args:
        query: what to look for.
        prior: where it is believed to be; None if unknown.
        tolerance: how far from the prior a program must still work [m, rad].
    """

    query: Object
    prior: Pose | None = None
    tolerance: tuple[float, float] = (0.0, 0.0)

    @property
    def name(self) -> str:
        """Name of the designator that describes the object."""
        return self.query.name

    def __str__(self) -> str:
        return f"{self.query}, measured at run time within {self.tolerance[0] * 1000:.0f} mm"


Designator = Action | Object | Location | Motion | Late
"""Designator of any kind that plugins are asked to ground."""
