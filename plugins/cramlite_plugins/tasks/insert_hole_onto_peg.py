"""artm:InsertHoleOntoPeg: thread a held object with a hole onto a peg, force-controlled."""

from __future__ import annotations

from collections.abc import Iterable

from cramlite import Action, Belief, Decomposition, Location, Motion, Parameter, Role, TaskType, Unresolvable, hookimpl


class InsertHoleOntoPeg(TaskType):
    task = "artm:InsertHoleOntoPeg"
    aliases = ("HoleOnPeg", "InsertHole", "ThreadOntoPeg")
    roles = (Role("Locatum", features=("vrps:Hole",)), Role("Relatum", features=("vrps:Peg",)))
    summary = "move the hole of a held object over a peg's tip and along the peg"
    parameters = (
        Parameter("speed_m_s", 0.03, "slower than extraction: the rim meets the tip head-on"),
        Parameter("force_limit_n", 25.0, "as for extraction"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        locatum, relatum = action.roles["Locatum"], action.roles["Relatum"]
        if belief.held is None or belief.held.thing != locatum.entity:
            raise Unresolvable(f"'{locatum.entity}' must be held to be threaded onto a peg")
        way = self.begins_at(action)
        force = {k: self.parameter(action, k) for k in ("speed_m_s", "force_limit_n")}
        steps = (
            way,
            Motion(action.inside("transfer"), "transfer", way, reason="in front of the peg's tip"),
            Motion(action.inside("tare"), "zero_sensor", reason="the weight of the object is not a contact force"),
            Motion(action.inside("push"), "force_path", way, force, (relatum.name,), "over the tip and along the peg"),
        )
        yield Decomposition(steps, "force-controlled push along the peg")

    def effects(self, action: Action, belief: Belief) -> Belief:
        relatum = (action.roles["Relatum"].entity or "").split("/")[0]
        return belief.related(("hangs_on", action.roles["Locatum"].entity or "", relatum))

    def begins_at(self, action: Action) -> Location:
        locatum, relatum = action.roles["Locatum"].name, action.roles["Relatum"].name
        return Location(f"insert({locatum}, {relatum})", "insert", relatum)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [InsertHoleOntoPeg()]
