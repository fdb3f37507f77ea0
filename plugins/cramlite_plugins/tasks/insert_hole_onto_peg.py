"""artm:InsertHoleOntoPeg: thread a held object with a hole onto a peg, force-controlled."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from cramlite.model import Action, Belief, Location, Motion, fallback, part_name, sequence
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl

TIP, DEEP, DOWN = 0, 2, 3  # corners of the place "insert": at the tip, past its bend, on the peg, let down
FURTHER = 0.012  # how far below its believed place the peg may be met [m]: 5 mm of error, and the play twice
SIGMAS, ROUND = 3.0, 0.003  # of a perceived peg's place that are felt for, and the hemisphere of a tip [m]


class InsertHoleOntoPeg(TaskType):
    task = "artm:InsertHoleOntoPeg"
    aliases = ("HoleOnPeg", "InsertHole", "ThreadOntoPeg")
    roles = (Role("Locatum", features=("vrps:Hole",)), Role("Relatum", features=("vrps:Peg",)))
    summary = "move the hole of a held object over a peg's tip and along the peg"
    parameters = (
        Parameter("touch_speed_m_s", 0.01, "a guarded approach at 10 mm/s peaks at 9 N in simulation"),
        Parameter("touch_force_n", 3.0, "above sensor noise and the inertia of slow motion"),
        Parameter("beyond_m", 0.008, "an unknown error of 5 mm along the peg, or 3 sigma if more, and 3 mm"),
        Parameter("search_force_n", 3.0, "keeps contact; 0.9 N of friction at the tip does not shift the grasp"),
        Parameter("search_speed_m_s", 0.01, "found in simulation: the hole drops onto the tip before it has passed"),
        Parameter("search_radius_m", 0.0, "0: from the sizes of hole and peg, 8 mm for a play of 1.5 mm"),
        Parameter("advance_m", 0.002, "the tip is in the hole: its hemisphere is 3 mm high"),
        Parameter("push_force_n", 8.0, "slides over a bent tip in simulation; a jammed rim takes 31 N"),
        Parameter("push_speed_m_s", 0.02, "faster compliance oscillates against a stiff peg in simulation"),
        Parameter("attempts", 2.0, "1 of 198 pushes of the paper's experiment met a tip that was not in the hole"),
        Parameter("lower_speed_m_s", 0.005, "a guarded motion at 5 mm/s peaks at 6 N in simulation"),
        Parameter("lower_force_n", 1.2, "the peg carries; less is within the noise of the sensor"),
        Parameter("force_limit_n", 25.0, "as for extraction"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        locatum, relatum = action.roles["Locatum"], action.roles["Relatum"]
        if belief.held is None or belief.held.thing != locatum.entity:
            raise Unresolvable(f"'{locatum.entity}' must be held to be threaded onto a peg")
        way, peg = self.begins_at(action), (relatum.name,)

        def felt(name: str, kind: str, reason: str, stage: str, **more: object) -> Motion:
            own = {
                p.name.removeprefix(f"{stage}_"): self.parameter(action, p.name)
                for p in self.parameters
                if p.name.startswith(f"{stage}_") or (p.name == "force_limit_n" and kind != "until_contact")
            }
            return Motion(action.inside(name), kind, way, {**own, **more}, peg, reason)

        known, advance = belief.poses.get(relatum.thing), self.parameter(action, "advance_m")
        beyond = max(self.parameter(action, "beyond_m"), SIGMAS * known.sigma + ROUND if known else 0.0)
        touch = felt("touch", "until_contact", "to the tip", "touch", corner=TIP, beyond_m=beyond, expect="any")
        search = felt("search", "spiral_search", "for the tip with the hole", "search", corner=TIP, advance_m=advance)
        push = felt("push", "force_insert", "over the tip and along the peg", "push", corner=TIP, end=DEEP)
        steps = (
            way,
            Motion(action.inside("transfer"), "transfer", way, reason="the hole in front of the peg's tip"),
            Motion(action.inside("tare"), "zero_sensor", reason="the weight of the object is not a contact force"),
            _threading(action, int(self.parameter(action, "attempts")), touch, search, push),
            felt("lower", "until_contact", "until the peg carries", "lower", corner=DOWN, beyond_m=FURTHER),
        )
        yield Decomposition(steps, "touch the tip, search for it, push along the peg, let down")

    def effects(self, action: Action, belief: Belief) -> Belief:
        relatum = action.roles["Relatum"].thing
        return belief.related(("hangs_on", action.roles["Locatum"].entity or "", relatum))

    def begins_at(self, action: Action) -> Location:
        locatum, relatum = action.roles["Locatum"].name, action.roles["Relatum"].name
        return Location(f"insert({locatum}, {relatum})", "insert", relatum)


def _threading(action: Action, times: int, *parts: Motion) -> Action:
    """The parts, and the same again from where they began while the run fails: a rim that seemed to hold the tip did not."""
    once = sequence(action.inside("thread"), *parts)
    again = [
        sequence(part_name(once.name, f"attempt_{k}"), *[replace(p, name=part_name(p.name, f"attempt_{k}")) for p in parts])
        for k in range(2, times + 1)
    ]
    return fallback(action.inside("attempts"), once, *again) if again else once


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [InsertHoleOntoPeg()]
