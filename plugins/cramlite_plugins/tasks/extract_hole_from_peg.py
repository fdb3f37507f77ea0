"""artm:ExtractHoleFromPeg: pull an object with a hole off the peg it hangs on, force-controlled."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Action, Belief, Location, Motion
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl


class ExtractHoleFromPeg(TaskType):
    task = "artm:ExtractHoleFromPeg"
    aliases = ("ExtractHole", "HoleFromPeg", "TakeOffPeg")
    roles = (Role("Locatum", features=("vrps:Hole",), aliases=("object",)), Role("Relatum", features=("vrps:Peg",)))
    summary = "pull a held object along the peg and over its tip, giving way to side forces"
    parameters = (
        Parameter("speed_m_s", 0.04, "half of what kept forces under 12 N on bent tips in simulation"),
        Parameter("force_n", 8.0, "as for threading: slides over a bent tip in simulation; a jammed rim takes 31 N"),
        Parameter("force_limit_n", 25.0, "a jammed rim reached 31 N in simulation; a free one stays below 12 N"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        locatum, relatum = action.roles["Locatum"], action.roles["Relatum"]
        if belief.held is None or belief.held.thing != locatum.entity:
            holds = belief.held.thing if belief.held else "nothing"
            raise Unresolvable(f"'{locatum.entity}' must be held to be pulled off; the gripper holds {holds}")
        hanger, peg = belief.relates("hangs_on", belief.held.thing), relatum.thing
        if hanger and hanger != peg:
            because = tuple(n for n in (locatum.name, relatum.name, relatum.part_of) if n)
            raise Unresolvable(f"'{locatum.entity}' hangs on '{hanger}', not on '{peg}'", because)
        way = Location(f"extract({locatum.name}, {relatum.name})", "extract", relatum.name)
        reason, touch = "lift to the middle of the hole, along the peg, over its tip", (relatum.name,)
        pull = {k: self.parameter(action, k) for k in ("speed_m_s", "force_n", "force_limit_n")}
        path = {k: pull[k] for k in ("speed_m_s", "force_limit_n")}
        tare = Motion(action.inside("tare"), "zero_sensor", reason="the weight of the object is not a contact force")
        along = Motion(action.inside("pull"), "force_extract", way, pull, touch, "along the peg, which leads it over its tip")
        yield Decomposition((way, tare, along), "force-controlled pull: the peg leads, and nothing jams harder than the pull")
        yield Decomposition(
            (way, tare, Motion(action.inside("pull"), "force_path", way, path, touch, reason)),
            "motion along the peg as it is believed to be, sideways compliant", 1.0,
        )  # fmt: skip

    def effects(self, action: Action, belief: Belief) -> Belief:
        return belief.unrelated("hangs_on", action.roles["Locatum"].entity or "")


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [ExtractHoleFromPeg()]
