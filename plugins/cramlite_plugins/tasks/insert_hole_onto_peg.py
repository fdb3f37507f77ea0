"""artm:InsertHoleOntoPeg: thread a held object with a hole onto a peg, force-controlled."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from msgspec.structs import replace

from cramlite.model import (
    Action,
    Belief,
    ExpectedContact,
    Location,
    Motion,
    Object,
    Place,
    Stage,
    fallback,
    part_name,
    sequence,
)
from cramlite.plugin import HELD, Allowance, Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl

from ..shapes.peg_fit import stands

TIP, DEEP, DOWN = 0, 2, 3  # corners of the place "insert": at the tip, past its bend, on the peg, let down
LOOKED = 0.010  # around a place by attempts there and at the four places beside it [m]
RINGS = 3  # of places beside the believed one, at most: 25 attempts of 15 s
EDGES = 2.0  # standard deviations of a peg's place that attempts reach to
FURTHER = 0.012  # how far below its believed place the peg may be met [m]: 5 mm of error, and the play twice
SIGMAS, ROUND = 3.0, 0.003  # of a perceived peg's place that are felt for, and the hemisphere of a tip [m]


def _rings() -> tuple[tuple[int, int], ...]:
    """Points of a square lattice, sorted by their number of steps from the middle, and then by their steps up or down."""
    span = range(-RINGS, RINGS + 1)
    points = [(across, up) for across in span for up in span if abs(across) + abs(up) <= RINGS]
    return tuple(sorted(points, key=lambda p: (abs(p[0]) + abs(p[1]), abs(p[1]), -p[0], -p[1])))


AROUND = _rings()
"""Positions at which attempts search for the peg, in order, in steps across the peg and up."""


class InsertHoleOntoPeg(TaskType):
    task = "artm:InsertHoleOntoPeg"
    aliases = ("HoleOnPeg", "InsertHole", "ThreadOntoPeg")
    roles = (Role("Locatum", features=("vrps:Hole",), aliases=("object",)), Role("Relatum", features=("vrps:Peg",), aliases=("target",)))
    summary = "move the hole of a held object over a peg's tip and along the peg"
    parameters = (
        Parameter("touch_speed_m_s", 0.01, "a guarded approach at 10 mm/s peaks at 9 N in simulation"),
        Parameter("touch_force_n", 3.0, "above sensor noise and the inertia of slow motion"),
        Parameter("beyond_m", 0.015, "an unknown error of 12 mm along the peg, or 3 sigma if more, and 3 mm"),
        Parameter("search_force_n", 3.0, "keeps contact; 0.9 N of friction at the tip does not shift the grasp"),
        Parameter("search_speed_m_s", 0.01, "found in simulation: the hole drops onto the tip before it has passed"),
        Parameter("search_radius_m", 0.0, "0: from the sizes of hole and peg, 6.5 mm for a play of 1.5 mm"),
        Parameter("advance_m", 0.002, "the tip is in the hole: its hemisphere is 3 mm high"),
        Parameter("push_force_n", 8.0, "slides over a bent tip in simulation; a jammed rim takes 31 N"),
        Parameter("push_speed_m_s", 0.02, "faster compliance oscillates against a stiff peg in simulation"),
        Parameter("sink_speed_m_s", 0.06, "found in simulation: a nut with 4 mm of play touches the peg with less than 4 N"),
        Parameter("attempts", 0.0, "0: 5, or as many as reach 2 sigma of the peg's place; a search that goes too far leaves the rim"),
        Parameter("aside_m", 0.008, "a little more than the radius of a search: together they look 10 mm around, 14 mm to each side"),
        Parameter("lower_speed_m_s", 0.005, "a guarded motion at 5 mm/s peaks at 6 N in simulation"),
        Parameter("lower_force_n", 3.0, "as for the touch: the peg carries; less is within noise and drift of the sensor"),
        Parameter("force_limit_n", 25.0, "as for extraction"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        locatum = action.roles["Locatum"]
        if belief.held is None or belief.held.thing != locatum.entity:
            raise Unresolvable(f"'{locatum.entity}' must be held to be threaded onto a peg")
        way = self.begins_at(action)
        attempts = [self._attempt(action, belief, k, beside) for k, beside in enumerate(self._places(action, belief))]
        steps = (
            way,
            Motion(action.inside("transfer"), "transfer", way, reason="the hole in front of the peg's tip"),
            fallback(action.inside("attempts"), *attempts) if len(attempts) > 1 else attempts[0],
        )
        yield Decomposition(steps, "touch the tip, search for it, push along the peg, let down; elsewhere if the peg does not carry")

    def _places(self, action: Action, belief: Belief) -> tuple[tuple[int, int], ...]:
        """Positions of the attempts, in steps of ``aside_m`` across the peg and up: the believed one first, then rings around it.

        Raises:
            Unresolvable: the peg's place is so uncertain that the attempts would miss it more often than once in twenty times.
        """
        stated, relatum = int(self.parameter(action, "attempts")), action.roles["Relatum"]
        if stated:
            return tuple(AROUND[k % len(AROUND)] for k in range(stated))
        known, step = belief.poses.get(relatum.thing), self.parameter(action, "aside_m")
        sigma = known.sigma if known else 0.0
        rings = max(1, math.ceil((EDGES * sigma - LOOKED) / step) + 1)
        if rings > RINGS:
            raise Unresolvable(
                f"where '{relatum.thing}' is, is uncertain by {1000 * sigma:.0f} mm (standard deviation): attempts feel for its peg"
                f" {1000 * (LOOKED + (RINGS - 1) * step):.0f} mm around; look at it from nearer, or calibrate the camera",
                (relatum.name,),
            )
        return AROUND[: 2 * rings * (rings + 1) + 1]

    def _attempt(self, action: Action, belief: Belief, k: int, place: tuple[int, int]) -> Action:
        """Motions of attempt ``k`` to thread the hole, and to check by force that the peg carries the payload.

        The check is needed since a search can end as if the tip were in the hole when it is not.
        """
        relatum, way, once = action.roles["Relatum"], self.begins_at(action), "" if k == 0 else f"attempt_{k + 1}"
        beside = {"aside_m": tuple(self.parameter(action, "aside_m") * v for v in place)} if k else {}
        known, advance = belief.poses.get(relatum.thing), self.parameter(action, "advance_m")
        beyond = max(self.parameter(action, "beyond_m"), SIGMAS * known.sigma + ROUND if known else 0.0)

        def named(name: str) -> str:
            return part_name(action.inside(name), once) if once else action.inside(name)

        def felt(name: str, kind: str, reason: str, **more: object) -> Motion:
            own = {
                p.name.removeprefix(f"{name}_"): self.parameter(action, p.name)
                for p in self.parameters
                if p.name.startswith(f"{name}_") or (p.name == "force_limit_n" and kind != "until_contact")
            }
            return Motion(named(name), kind, way, {**own, **more}, (relatum.name,), reason)

        return sequence(
            named("thread"),
            *([Motion(named("aside"), "linear", way, {"stage": Stage.BEFORE, **beside}, (), "look beside it")] if k else []),
            Motion(named("tare"), "zero_sensor", reason="the weight of the object is not a contact force"),
            felt("touch", "until_contact", "to the tip", corner=TIP, beyond_m=beyond, expect=ExpectedContact.ANY, **beside),
            felt("search", "spiral_search", "for the tip with the hole", corner=TIP, advance_m=advance, **beside),
            *self._push_along_peg(felt, belief, relatum),
            Motion(named("tare_again"), "zero_sensor", reason="what the sensor drifted by is no contact either"),
            felt("lower", "until_contact", "until the peg carries", corner=DOWN, beyond_m=FURTHER),
        )

    def _push_along_peg(self, felt: Callable[..., Motion], belief: Belief, relatum: Object) -> Iterable[Motion]:
        """Motions along the peg: down an upright peg straight and compliant sideways, since it has no bent
        tip to follow; else by force over the tip."""
        peg = belief.feature(relatum.thing, "vrps:Peg")
        if peg is not None and stands((belief.thing(relatum.thing).pose * peg.pose).rotate((0.0, 0.0, 1.0))):
            yield felt("sink", "force_path", "down along the peg", corner=TIP, end=DEEP)
        else:
            yield felt("push", "force_insert", "over the tip and along the peg", corner=TIP, end=DEEP)

    def effects(self, action: Action, belief: Belief) -> Belief:
        relatum = action.roles["Relatum"].thing
        return belief.related(("hangs_on", action.roles["Locatum"].entity or "", relatum))

    def allowance(self, action: Action, bindings: Mapping[str, Any]) -> Allowance:
        """Return the contacts that the task may make, which include the peg's support with a payload whose hole is led down an upright
        peg."""
        own, place = super().allowance(action, bindings), bindings.get(self.begins_at(action).name)
        feet = place.fit.feet if isinstance(place, Place) and place.fit else ()
        return replace(own, touches=own.touches | {frozenset({HELD, foot}) for foot in feet})

    def begins_at(self, action: Action) -> Location:
        locatum, relatum = action.roles["Locatum"].name, action.roles["Relatum"].name
        return Location(f"insert({locatum}, {relatum})", "insert", relatum)


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [InsertHoleOntoPeg()]
