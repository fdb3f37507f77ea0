"""soma:Transporting: carry a held object to another thing."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion, thing_of
from cramlite.plugin import Decomposition, Role, TaskType, Unresolvable, hookimpl

from ..task_kit.preconditions import at_or_near, held_payload


class Transporting(TaskType):
    task = "soma:Transporting"
    aliases = ("Transport", "Carry")
    roles = (Role("Patient", aliases=("object",)), Role("Destination", required=False, aliases=("target",)))
    summary = "carry a held object to another thing"
    slides = False
    leads_on = True
    touches = ()

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        held = held_payload(belief, "carried")
        there = action.roles.get("Destination")
        if hanger := belief.relates("hangs_on", held.thing):
            if there is None or thing_of(hanger) != there.thing:
                about = tuple(o.name for o in action.roles.values())
                reason = f"'{held.thing}' hangs on '{hanger}' and must be pulled off first"
                raise Unresolvable.because_of_earlier_tasks(reason, about)
            yield Decomposition((), f"it hangs on '{hanger}' already")
            return
        goal = action.goal or self.leads_to(action, None, Location("home", "home"))
        yield Decomposition(
            (Motion(action.inside("carry"), "transfer", goal, reason=f"to the stand-off of {goal}"),),
            f"collision-free motion to {goal}",
        )

    def leads_to(self, action: Action, following: Action | None, goal: Location) -> Location:
        """Return the location where the next task begins, if that is at the destination; else a location
        near the destination."""
        return at_or_near(action.roles.get("Destination"), following, goal)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Transporting()]
