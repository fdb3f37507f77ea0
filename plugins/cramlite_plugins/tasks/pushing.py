"""soma:Pushing: closed fingers push a thing along its support; open fingers push a flat thing to a region of
the support, or out of the way."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from cramlite.model import (
    GRAVITY,
    Action,
    Belief,
    ExpectedContact,
    ExpectedGrip,
    Fingers,
    Location,
    Motion,
    Stage,
)
from cramlite.plugin import Decomposition, Parameter, Role, TaskType, Unresolvable, hookimpl

from ..shapes.bounds import height
from ..shapes.carried_along import CAME_ALONG

APART = 0.6
"""Distance between the open fingers that push a thing, as a share of the thing's width: two fingers that touch the thing keep it from
turning away."""
PRESSED = 0.6
"""Friction of a thing [N] above which closed fingers are tried first: it presses on each of two open fingers with more than 0.3 N, and 0.6
N that last count as a grasp (episodes/detection/grasped.py)."""
DOWN = {"speed_m_s": 0.02, "free_m_s": 0.1, "force_n": 2.0, "beyond_m": 0.01}
"""Parameters of the guarded motion of the fingers down to the floor of a thing."""
LOW = 0.03
"""Height of a thing below which closed fingers that feel for its side would slide over it [m]."""
OUT_OF_THE_WAY = 0.1
"""Distance by which a low thing is pushed aside if no region for it is asked [m]."""
LOST = 2.0
"""Longest time for which fingers inside a thing may move without pressing on it [s]: at the rim they take it along again."""
SLIPS = 0.005
"""Slip of a thing on the fingers that push it to a region [m]."""


class Pushing(TaskType):
    task = "soma:Pushing"
    aliases = ("Push",)
    roles = (Role("Patient", aliases=("object",)),)
    summary = "touch a thing with closed fingers and push it along, or push a flat one to a region"
    moves = ("Patient",)
    places = True
    parameters = (
        Parameter("distance_m", 0.06, "five times what rules call displaced, and more than the play at the start"),
        Parameter("speed_m_s", 0.02, "at 30 mm/s a pushed block runs ahead of the fingers in simulation"),
        Parameter("slide_m_s", 0.06, "fingers pressed into a thing hold it back, too, so that it does not run ahead"),
        Parameter("press_n", 10.0, "on the floor of a thing that fingers push from inside: with 3 N they tip a plate up at its rim"),
        Parameter("touch_force_n", 1.0, "0.2 kg on wood slides at 1.2 N; less is noise of the sensor"),
    )

    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        if belief.held is not None:
            raise Unresolvable.because_of_earlier_tasks(f"the gripper holds '{belief.held.thing}'; empty fingers push")
        patient, name = action.roles["Patient"].name, action.roles["Patient"].entity or ""
        to_region, low = bool(action.parameters.get("where")), height(belief.thing(name), belief.pose(name)) < LOW
        if to_region or low:
            far = self.begins_at(action) if to_region else Location(f"behind({patient})", "behind", patient, {"aside_m": OUT_OF_THE_WAY})
            heavy = _resists(belief, name) > PRESSED
            yield self._from_behind(action, far, 0.0 if heavy else APART, 0.0)
            yield self._from_behind(action, far, APART if heavy else 0.0, 1.0)
            yield self._from_inside(action, far, around=False, cost=2.0)
            if to_region:
                yield self._from_inside(action, far, around=True, cost=3.0)
        if not to_region:
            yield self._along(action, 3.0 if low else 0.0)

    def _along(self, action: Action, cost: float) -> Decomposition:
        patient, beside = action.roles["Patient"], self.begins_at(action)
        far = Location(
            action.inside("far"), "pushed", patient.name, {"distance_m": self.parameter(action, "distance_m")}
        )
        feel = {
            "speed_m_s": 0.01, "force_n": self.parameter(action, "touch_force_n"), "beyond_m": 0.01, "expect": ExpectedContact.ANY,
        }  # fmt: skip
        push, touch = {"stage": Stage.POSE, "speed_m_s": self.parameter(action, "speed_m_s")}, (patient.name,)
        steps = (
            beside,
            Motion(action.inside("transfer"), "transfer", beside, reason=f"beside {patient.entity}"),
            Motion(action.inside("shut"), "gripper", None, {"to": Fingers.SHUT, "expect": ExpectedGrip.NONE}, reason="fingers together"),
            Motion(action.inside("tare"), "zero_sensor", reason="what the sensor reads here is no contact force"),
            Motion(action.inside("touch"), "until_contact", beside, feel, touch, f"to {patient.entity}"),
            far,
            Motion(action.inside("push"), "linear", far, push, touch, f"{patient.entity} moves along"),
        )
        return Decomposition(steps, "touch, then straight on", cost)

    def _from_behind(self, action: Action, behind: Location, apart: float, cost: float) -> Decomposition:
        behind = replace(behind, parameters={**behind.parameters, "apart": apart})
        says = "with open fingers" if apart else "with closed fingers"
        patient, push = action.roles["Patient"], {"stage": Stage.POSE, "speed_m_s": self.parameter(action, "speed_m_s")}
        far = Location(action.inside("far"), "pushed_to", patient.name, {"begin": behind.name})
        steps = (
            *self._over(action, behind, says, Fingers.PLACE if apart else Fingers.SHUT),
            Motion(action.inside("down"), "linear", behind, {"stage": Stage.POSE}, (patient.name,), f"to {patient.entity}"),
            far,
            Motion(action.inside("push"), "linear", far, push, (patient.name,), f"{patient.entity} moves along"),
        )
        return Decomposition(steps, f"from behind {says}, straight {_where(behind)}", cost)

    def _from_inside(self, action: Action, begin: Location, around: bool, cost: float) -> Decomposition:
        patient = action.roles["Patient"]
        where, touch = {**begin.parameters, "around": around}, (patient.name,)
        inside = Location(action.inside("amid" if around else "inside"), "behind", patient.name, {**where, "inside": True})
        far = Location(action.inside("far"), "pushed_to", patient.name, {**where, "begin": inside.name})
        slide = {
            "press_n": self.parameter(action, "press_n"), "speed_m_s": self.parameter(action, "slide_m_s"), "lost_s": LOST,
        }  # fmt: skip
        steps = (
            *self._over(action, inside, "with closed fingers in it", Fingers.SHUT),
            Motion(action.inside("tare"), "zero_sensor", reason="what the sensor reads here is no contact force"),
            Motion(action.inside("down"), "until_contact", inside, DOWN, touch, f"to the floor of {patient.entity}"),
            far,
            Motion(action.inside("push"), "compliant_slide", far, slide, touch, f"{patient.entity} comes along"),
        )
        return Decomposition(steps, f"push its rim from inside, {'around obstacles' if around else 'straight'}", cost)

    @staticmethod
    def _over(action: Action, begin: Location, says: str, fingers: Fingers) -> tuple[Location | Motion, ...]:
        entity = action.roles["Patient"].entity
        return (
            begin,
            Motion(action.inside("fingers"), "gripper", begin, {"to": fingers, "expect": ExpectedGrip.NONE}, reason=says),
            Motion(action.inside("transfer"), "transfer", begin, reason=f"above the place where the push of {entity} begins"),
        )

    def effects(self, action: Action, belief: Belief) -> Belief:
        """Return the belief after a push: the thing's pose is uncertain by the distance pushed.

        The uncertainty is less if the thing moved with the fingers.
        """
        thing = action.roles["Patient"].entity or ""
        known = belief.poses[thing]
        before_them = action.parameters.get("where") or known.source == CAME_ALONG
        spread = known.sigma + (SLIPS if before_them else self.parameter(action, "distance_m"))
        return replace(belief, poses={**belief.poses, thing: replace(known, sigma=spread, source="predicted: pushed")})

    def begins_at(self, action: Action) -> Location:
        patient, where = action.roles["Patient"].name, action.parameters.get("where")
        if not where:
            return Location(f"push({patient})", "push", patient)
        if set(where) - {"region", "within"}:
            raise Unresolvable("flat things are pushed to regions only, not to a side of something or near it", (patient,))
        return Location(f"behind({patient})", "behind", patient, where)


def _where(far: Location) -> str:
    return "to its region" if "region" in far.parameters else "out of the way"


def _resists(belief: Belief, name: str) -> float:
    """Friction [N] between a thing and a support that has the same coefficient of friction."""
    thing = belief.thing(name)
    rough = max((g.friction for g in thing.geoms if g.friction is not None), default=thing.friction)
    return GRAVITY * (thing.mass or 0.0) * rough


@hookimpl
def task_types() -> Iterable[TaskType]:
    return [Pushing()]
