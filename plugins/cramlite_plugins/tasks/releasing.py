"""soma:Releasing: open the fingers when the payload rests on something."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, ExpectedGrip, Fingers, Held, Location, Motion, thing_of
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl

from ..task_kit.preconditions import held_payload, near


class Releasing(TaskType):
    task = "soma:Releasing"
    aliases = ("Release", "LetGo")
    roles = (Role("Locatum", aliases=("object",)), Role("Relatum", required=False))
    summary = "open the fingers; what they held stays with what supports it, and is put down there first if it does not"
    slides = False

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        held = held_payload(belief, "released")
        steps = (
            Motion(action.inside("open"), "gripper", None, {"to": Fingers.OPEN, "expect": ExpectedGrip.NONE}, reason="let go"),
            Motion(action.inside("payload"), "payload", reason="the gripper is empty again"),
        )
        if _rests(action, held, belief):
            yield Decomposition(steps, "open the fingers here")
        else:
            down = Action(action.inside("PuttingDown"), "soma:PuttingDown", action.roles)
            yield Decomposition((down, *steps), "it is in the air: put it down first, then open the fingers")

    def begins_at(self, action: Action) -> Location | None:
        """Return the location near the relatum, where the payload is brought; None without a relatum.

        Not where the next task begins: nothing is held any more then.
        """
        return near(action.roles["Relatum"]) if "Relatum" in action.roles else None


def _rests(action: Action, held: Held, belief: Belief) -> bool:
    """Whether the payload would stay when released: the Relatum is known to support it, the hand has not moved
    since the grasp, or no surface is named."""
    relatum = action.roles.get("Relatum")
    if relatum is None or relatum.entity is None:
        return True
    there = relatum.thing
    if any(thing_of(belief.relates(p, held.thing) or "") == there for p in ("on", "hangs_on", "in")):
        return True
    if belief.feature(there, "vrps:Peg"):
        about = tuple(o.name for o in action.roles.values())
        raise Unresolvable.because_of_earlier_tasks(f"'{held.thing}' does not hang on '{there}'", about)
    return held.joints == belief.joints or belief.feature(relatum.entity, "vrps:SurfaceFeature") is None


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Releasing()]
