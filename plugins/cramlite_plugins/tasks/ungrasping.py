"""artm:Ungrasping: let go of an object in or above a container."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from msgspec.structs import replace

from cramlite.model import (
    Action,
    Belief,
    EntityName,
    ExpectedGrip,
    Fingers,
    Location,
    Motion,
    Object,
    Place,
    Stage,
    thing_of,
)
from cramlite.plugin import Allowance, Decomposition, Role, TaskType, hookimpl

from ..task_kit.preconditions import held_payload, spot

SPEED = 0.08  # of fingers that push in what lies there [m/s]: LIBERO's book stays at them; with 0.05 it takes 14 actions more


class Ungrasping(TaskType):
    task = "artm:Ungrasping"
    aliases = ("DropInto", "Ungrasp")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", features=("cram:Cavity",), aliases=("target",)))
    places = True
    summary = "carry a held object into a container's opening and let go"
    slides = False

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        held_payload(belief, "let go")
        container, place = action.roles["Relatum"].entity, self.begins_at(action)
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"above {container}"),
            Motion(action.inside("lower"), "linear", place, {"stage": Stage.POSE}, reason=f"as deep into {container} as the hand fits"),
            *_let_go(action, place),
        )
        yield Decomposition(steps, f"move above {container}, lower, open")
        if _has_a_roof(action, belief):
            yield self._push_in(action, "toppled", "foot first, tips over, and is pushed in", 1.0)
            yield self._push_in(action, "before", "from before it, pushed by fingers", 2.0)

    def _push_in(self, action: Action, relation: str, says: str, cost: float) -> Decomposition:
        """Decomposition for a container under an overhang: the payload is released at the open side, leaning out
        with its foot in or before it, and fingers push it in."""
        relatum, what = action.roles["Relatum"], action.roles["Locatum"].name
        place = spot(relation, action)
        there = Location(_way_in(action.roles["Locatum"]), "pushed_in", what, {"begin": place.name})
        apart = {"to": Fingers.PLACE, "expect": ExpectedGrip.NONE}
        push, touch = {"stage": Stage.END, "speed_m_s": SPEED}, (what,)
        steps = (
            place,
            Motion(action.inside("transfer"), "transfer", place, reason=f"to the open side of {relatum.entity}"),
            Motion(action.inside("enter"), "linear", place, {"stage": Stage.POSE}, reason="where it is let go of"),
            *_let_go(action, place),
            Motion(action.inside("back"), "linear", place, {"stage": Stage.END}, touch, "away from it"),
            there,
            Motion(action.inside("fingers"), "gripper", there, apart, reason="both will touch it"),
            Motion(action.inside("over"), "transfer", there, reason=f"over a place behind {what}"),
            Motion(action.inside("down"), "linear", there, {"stage": Stage.POSE}, touch, f"behind {what}"),
            Motion(action.inside("push"), "linear", there, push, touch, "in"),
        )
        return Decomposition(steps, f"under the roof of {relatum.entity}: the payload goes in {says}", cost)

    def allowance(self, action: Action, bindings: Mapping[str, Any]) -> Allowance:
        """Return the contacts that the task may make and the things that it may move, which include the payload that is pushed
        into its container after its release."""
        pushed: Place | None = bindings.get(_way_in(action.roles["Locatum"]))
        return replace(super().allowance(action, bindings), moves=frozenset({thing_of(pushed.thing)} if pushed else ()))

    def effects(self, action: Action, belief: Belief) -> Belief:
        locatum, relatum = action.roles["Locatum"].entity or "", action.roles["Relatum"].entity or ""
        return belief.related(("in", locatum, relatum))

    def begins_at(self, action: Action) -> Location:
        return spot("in", action)


def _way_in(what: Object) -> str:
    """Name of the location designator for pushing a released thing into its container."""
    return f"pushed_in({what.name})"


def _let_go(action: Action, place: Location) -> tuple[Motion, Motion]:
    return (
        Motion(action.inside("open"), "gripper", place, {"to": Fingers.OPEN, "expect": ExpectedGrip.NONE}, reason="let go"),
        Motion(action.inside("payload"), "payload", reason="the gripper is empty again"),
    )


def _has_a_roof(action: Action, belief: Belief) -> bool:
    """Whether the container's opening that the task is about is under another part of the container."""
    from ..shapes.roofs import has_own_roof

    entity = EntityName.parse(action.roles["Relatum"].entity or "")
    region = str(action.parameters.get("where", {}).get("region") or entity.part)
    return entity.thing in belief.poses and has_own_roof(belief.thing(entity.thing), belief.pose(entity.thing), region)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Ungrasping()]
