"""soma:Releasing: open the fingers, where what they hold rests on something."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import (
    EARLIER_TASKS,
    Action,
    Belief,
    Decomposition,
    Location,
    Motion,
    Role,
    TaskType,
    Unresolvable,
    hookimpl,
)
from cramlite_plugins.experts.near import near


class Releasing(TaskType):
    task = "soma:Releasing"
    aliases = ("Release", "LetGo")
    roles = (Role("Locatum"), Role("Relatum", required=False))
    summary = "open the fingers; what they held stays with what supports it, and is put down there first if it does not"

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is None:
            raise Unresolvable("nothing is held that could be released", because=(EARLIER_TASKS,))
        steps = (
            Motion(action.inside("open"), "gripper", None, {"to": "open", "expect": "none"}, reason="let go"),
            Motion(action.inside("payload"), "payload", reason="the gripper is empty again"),
        )
        if _rests(action, belief):
            yield Decomposition(steps, "open the fingers here")
        else:
            down = Action(action.inside("PuttingDown"), "soma:PuttingDown", action.roles)
            yield Decomposition((down, *steps), "it is in the air: put it down first, then open the fingers")

    def begins_at(self, action: Action) -> Location | None:
        """What is held is brought there, not to where the next task begins, when nothing is held any more."""
        return near(action.roles["Relatum"]) if "Relatum" in action.roles else None


def _rests(action: Action, belief: Belief) -> bool:
    """Whether what is held is where it would stay: not moved since it was grasped, known to rest there, or nothing that
    it could be put down on is named."""
    held, relatum = belief.held, action.roles.get("Relatum")
    assert held is not None
    if relatum is None or relatum.entity is None:
        return True
    there = relatum.entity.split("/")[0]
    if any((belief.relates(p, held.thing) or "").split("/")[0] == there for p in ("on", "hangs_on", "in")):
        return True
    if belief.feature(there, "vrps:Peg"):
        raise Unresolvable(
            f"'{held.thing}' does not hang on '{there}'", (EARLIER_TASKS, *(o.name for o in action.roles.values()))
        )
    return held.joints == belief.joints or belief.feature(relatum.entity, "vrps:SurfaceFeature") is None


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Releasing()]
