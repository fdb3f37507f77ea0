"""cram:Shaking: swing a held thing to and fro, upright, so that its content stays in it."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion, Stage
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl


class Shaking(TaskType):
    task = "cram:Shaking"
    aliases = ("Shake",)
    roles = (Role("Patient", filled=True, aliases=("object",)),)
    summary = "swing a held thing up and down"
    slides = False
    touches = ()
    parameters = (
        Parameter("swings", 6.0, "up or down, each counts; a demonstration says how many, and its rule asks for 5"),
        Parameter("height_m", 0.04, "of a swing: people swing salt by 30 to 90 mm"),
        Parameter("speed_m_s", 0.2, "below URScript's default 0.25: a swing takes 0.4 s"),
        Parameter("acceleration_m_s2", 1.2, "URScript's default: an eighth of gravity, so nothing leaves its bed"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        patient = action.roles["Patient"]
        if belief.held is None or belief.held.thing != patient.entity:
            raise Unresolvable.because_of_earlier_tasks(f"'{patient.entity}' is not in the hand", (patient.name,))
        height, count = self.parameter(action, "height_m"), max(1, round(self.parameter(action, "swings")))
        pace = {k: self.parameter(action, k) for k in ("speed_m_s", "acceleration_m_s2")}
        steps: list[Location | Motion] = []
        for k in range(count + count % 2):  # as often down as up
            up = k % 2 == 0
            name = f"{'up' if up else 'down'}_{k // 2 + 1}"
            place = Location(action.inside(f"at_{name}"), "lift", parameters={"height_m": height if up else -height})
            steps += [place, Motion(action.inside(name), "linear", place, {"stage": Stage.POSE, **pace}, (), f"swing {name}")]
        yield Decomposition(tuple(steps), f"{count} swings of {1000 * height:.0f} mm")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Shaking()]
