"""Motion limits from ontologies: knowledge about things limits forces, speeds and accelerations, with its
sources.

Fragile things lower forces, heavy ones speed and acceleration, holes say how they are searched for (ontologies/motions.ttl;
properties ``cram:maximumForce`` and so on). Nothing that is said there can be exceeded by a task's parameters; who needs
more says so of a class of their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from cramlite.model import Belief, Motion, Thing, Value, thing_of
from cramlite.plugin import Candidate, Context

from .motion_kinds import KINDS, value

LIMITS = {
    "force_n": "cram:maximumForce", "press_n": "cram:maximumForce", "force_limit_n": "cram:maximumForce",
    "speed_m_s": "cram:speedShare", "speed_rad_s": "cram:speedShare",
    "acceleration_m_s2": "cram:accelerationShare", "acceleration_rad_s2": "cram:accelerationShare",
}  # fmt: skip
"""Property of the ontology that limits each parameter of a motion: forces by a highest value, speeds and accelerations by a share."""
MASS = "cram:minimumMass"

Knowing = Context | Candidate
"""Planning context or candidate program whose taxonomy is used to look up limits."""


class Known(Value):
    """Number that an ontology states for a class of things, such as the highest force that such things bear,
    with its source.

    Args:
        of: what it was asked for, e.g. "vase (soma:Glass)".
        said_of: the class that says it: the thing's own or one above it.
        source: why, in the ontology's words; and the file.
    """

    value: float
    of: str
    said_of: str
    source: str

    def __str__(self) -> str:
        return f"{self.of} is a {self.said_of}: {self.source}"


def known(class_: str, property_: str, context: Knowing, of: str = "") -> Known | None:
    """Look up the number that an ontology states for a property of a class, or else of the nearest class
    above it; None if it states none."""
    for said_of, said in context.taxonomy.restrictions_on(class_, property_):
        if isinstance(said.filler, float):
            source = f"{said.source} [{said.file}]" if said.source else f"[{said.file}]"
            return Known(said.filler, of or class_, said_of, source)
    return None


def classes(thing: Thing, context: Knowing) -> Iterator[str]:
    """Yield a thing's class, and, unless a joint carries the thing, the classes of the ontology that its mass makes it belong to."""
    yield thing.type
    if thing.joint is not None:
        return
    for name in sorted(context.taxonomy.restrictions):
        heavy = known(name, MASS, context) if any(r.property == MASS for r in context.taxonomy.restrictions[name]) else None
        if heavy is not None and (thing.mass or 0.0) >= heavy.value:
            yield name


def lowest(things: Iterable[Thing], property_: str, context: Knowing) -> Known | None:
    """Return the smallest number that an ontology states for a property of any of the given things; None if
    it states none."""
    found = [
        k for t in things for c in classes(t, context)
        if (k := known(c, property_, context, f"{t.name} ({t.type})")) is not None
    ]  # fmt: skip
    return min(found, key=lambda k: k.value, default=None)


def adapted(motion: Motion, belief: Belief, context: Context) -> Motion:
    """Limit a motion's parameters to those that its held and touched things bear; the reason says which,
    and why.

    Gripping is no force on a thing in this sense: ``grip_force`` has its own property.
    """
    if motion.kind == "gripper":
        return motion
    changed: dict[str, float] = {}
    reasons: list[str] = []
    for parameter in KINDS[motion.kind].parameters:
        limit = lowest(_things(motion, parameter.name, belief, context), LIMITS.get(parameter.name, ""), context)
        asked = value(motion, parameter.name)
        now = asked if limit is None else min(asked, limit.value) if parameter.name.endswith("_n") else asked * limit.value
        if limit is not None and now < asked:
            changed[parameter.name] = now
            reasons.append(f"{parameter.name} {now:g} instead of {asked:g}, {limit}")
    if not changed:
        return motion
    why = "; ".join((motion.reason, *reasons) if motion.reason else reasons)
    return replace(motion, parameters={**motion.parameters, **changed}, reason=why)


def noted(motion: Motion) -> str:
    """Return the note about limits from ontologies in a motion's reason, for the trace; "" if there is none."""
    note = motion.reason.partition("; ")[2]
    return f"; {note}" if note else ""


def _things(motion: Motion, parameter: str, belief: Belief, context: Context) -> list[Thing]:
    """Things whose properties limit a motion: the payload, and for a force parameter also the things that the motion may touch."""
    names = [belief.held.thing] if belief.held else []
    if parameter.endswith("_n"):
        names += [thing_of(str(context.bindings[n])) for n in motion.may_touch if n in context.bindings]
    return [belief.world.thing(n) for n in dict.fromkeys(names)]
