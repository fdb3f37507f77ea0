"""Scenario files: YAML with a request (demonstration, tasks or goal), a robot and its world."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec.structs import replace
from pydantic import BaseModel, Field, ValidationError, model_validator

from ..base.errors import UserError, nearest
from ..base.quantities import Angle, Force, Length
from ..base.spec import Name, Spec
from ..base.value import Value
from ..base.yaml_file import explain_validation, line_of, load_yaml
from ..model.robot import HIGHEST_FORCE_LIMIT
from ..model.run.judging_limits import JudgingLimits
from ..model.world.imported_scene import StatedJoint
from ..plugin.entry_points import plugin_names
from ..plugin.selection import PluginChoice
from .camera_spec import CameraSpec, IntrinsicsSpec
from .error_spec import ErrorSpec, PoseErrorSpec, ProofSpec, ThingErrorSpec
from .faults import FaultSpec
from .goal_spec import GoalTexts, goal_texts, listed_goals
from .pose_spec import PoseSpec
from .robot_spec import GripperSpec, RobotSpec
from .task_specs import TaskEntry
from .thing_spec import HangSpec, LateSpec, ThingSpec, UnknownErrorSpec, VarySpec

RENAMED: Mapping[str, str] = {"fov": "horizontal_fov", "look": "queries"}
"""Former names of keys in scenario files, with the present names."""
STARTS = ("demonstration", "tasks", "designator", "goal")
"""Keys that say what is asked for; a scenario has exactly one of them."""


class RecordSpec(Spec):
    """Recording of a demonstration for a scenario: the person's script or tasks, and the world in which the
    person acts.

    Without things it is the scenario's own world, as its own ``vary`` changes it.
    """

    script: str | None = None
    tasks: tuple[TaskEntry, ...] | None = Field(None, min_length=1)
    things: tuple[ThingSpec, ...] = ()
    vary: tuple[VarySpec, ...] = ()

    @model_validator(mode="after")
    def _one_of_both(self) -> RecordSpec:
        if (self.script is None) == (self.tasks is None):
            raise ValueError("'record' needs exactly one of 'script' and 'tasks', which say what the person does")
        return self


class ObjectSpec(Spec):
    """Object that tasks refer to: by classes and required features, or a single thing by name."""

    types: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    affords: tuple[str, ...] = ()
    entity: str | None = None


class PhysicsSpec(Spec):
    """Physics settings of a scenario that differ from the defaults.

    Scenarios that must fail use them.

    The ranges are those in which MuJoCo integrates a robot at all; above 5 ms contacts of 5 ms time constant diverge.
    """

    timestep: Annotated[float, Field(ge=1e-5, le=0.005)] = 0.002
    cone: Literal["elliptic", "pyramidal"] = "elliptic"
    noslip_iterations: Annotated[int, Field(ge=0, le=100)] = 5
    impratio: Annotated[float, Field(ge=1, le=1000)] = 10.0
    pad_friction: Annotated[float, Field(ge=0, le=10)] = 0.9


class JointSpec(Spec):
    """Properties of a scene file's joint that a scenario states: the end of its range at which it is closed, and the
    range of a sliding or turning joint."""

    closed: Literal["lower", "upper"] | None = None
    slides: tuple[Length, Length] | None = None
    turns: tuple[Angle, Angle] | None = None

    @model_validator(mode="after")
    def _one_range(self) -> JointSpec:
        if self.slides is not None and self.turns is not None:
            raise ValueError("a joint either 'slides' or 'turns'; its range is one of the two")
        for key in ("slides", "turns"):
            pair = getattr(self, key)
            if pair is not None and not pair[0] < pair[1]:
                raise ValueError(f"'{key}' gives the lower and the upper end of the joint, the lower one first")
        if not self.model_fields_set:
            raise ValueError("the joint's entry is empty; give 'closed' (lower or upper), or its range by 'slides' or 'turns'")
        return self

    def stated(self) -> StatedJoint:
        """Return what is stated about the joint as a ``StatedJoint``, which readers of scene files take."""
        ends = self.slides or self.turns
        return StatedJoint(self.closed, ("slide" if self.slides else "hinge") if ends else None, ends)


class WorldFileSpec(Spec):
    """Scene file, such as an MJCF, whose things are added to the scenario's own.

    ``types``: pattern of names -> class; ``packages``: name in ``package://`` -> folder; ``leave_out``: patterns of names;
    ``joints``: pattern of names of jointed things -> what is wrong in what was found of their joints; ``noise``: how far its poses of
    loose things may be off.
    """

    file: str
    types: dict[str, str] = Field({})
    packages: dict[str, str] = Field({})
    leave_out: tuple[str, ...] = ()
    keyframe: str = ""
    joints: dict[str, JointSpec] = Field({})
    noise: Length = Field(0.0, ge=0.0, le=0.1)


class LimitsSpec(Spec):
    """Limits on how far a run may disturb bystanders (``cramlite.model.JudgingLimits``).

    ``may_push`` is what ``advisory`` says where it is not written: what is told and refuses nothing may be planned.
    """

    bystander_motion: Length | None = Field(default=None, ge=0.0, le=1.0)
    keep: dict[str, Length] | None = None
    bystander_tilt: Angle | None = Field(default=None, ge=0.0, le=math.pi)
    brush: Force | None = Field(default=None, ge=0.0, le=HIGHEST_FORCE_LIMIT)
    advisory: tuple[str, ...] | None = None
    may_push: bool | None = None

    def judging(self) -> JudgingLimits:
        """Return the limits of judging a run: those that the scenario states, and the defaults of all others."""
        written = self.model_dump(exclude_none=True)
        written |= {"keep": tuple(self.keep.items())} if self.keep is not None else {}
        return JudgingLimits(**{"may_push": bool(self.advisory), **written}, of_scenario=tuple(written))


class ThenSpec(Spec):
    """Stage of an open program: tasks that are resolved only after the earlier tasks were executed, in the world as it
    is measured then.

    ``else``: tasks in their place, where no program for them can be proven; without it the execution ends there, with the reason.
    """

    do: tuple[TaskEntry, ...] = Field(min_length=1)
    otherwise: tuple[TaskEntry, ...] = Field((), alias="else")


class ScenarioSpec(Spec):
    """Keys of a scenario file."""

    scenario: Name
    title: str = ""
    demonstration: str | None = None
    tasks: tuple[TaskEntry, ...] | None = None
    designator: TaskEntry | None = None
    reading: str | int | None = None
    goal: GoalTexts | None = Field(default=None, min_length=1)
    plan: str | None = None
    then: tuple[ThenSpec, ...] = ()
    objects: dict[str, ObjectSpec] = Field({})
    robot: RobotSpec
    force_limit: Force | None = Field(None, gt=0, le=HIGHEST_FORCE_LIMIT)
    world: WorldFileSpec | None = None
    things: tuple[ThingSpec, ...] = ()
    vary: tuple[VarySpec, ...] = ()
    unknown_error: UnknownErrorSpec | None = None
    faults: tuple[FaultSpec, ...] = ()
    late: tuple[LateSpec, ...] = ()
    camera: CameraSpec | None = None
    poses: Literal["known", "camera"] = "known"
    record: RecordSpec | None = None
    physics: PhysicsSpec = PhysicsSpec()
    limits: LimitsSpec = LimitsSpec()
    proof: ProofSpec = ProofSpec()
    ontologies: tuple[str, ...] = ()
    models: tuple[str, ...] = ()
    backend: str | None = None
    block: tuple[str, ...] = ()
    prefer: tuple[str, ...] = ()
    budget: dict[str, int] = Field({})

    @model_validator(mode="after")
    def _one_start(self) -> ScenarioSpec:
        starts = [k for k in STARTS if getattr(self, k) is not None]
        if len(starts) != 1:
            raise ValueError(
                "a scenario starts from exactly one of 'demonstration', 'tasks', 'designator' and 'goal'; "
                f"this one has {' and '.join(starts) or 'none'}"
            )
        if self.reading is not None and self.demonstration is None:
            raise ValueError("'reading' chooses a reading of a 'demonstration', and the scenario has none")
        if self.plan is not None and self.goal is None:
            raise ValueError("'plan' is a PDDL plan for a 'goal', and the scenario has none")
        if self.world is None and "things" not in self.model_fields_set:
            raise ValueError("a scenario needs 'things', or a 'world' with a scene file")
        if self.poses == "camera" and self.camera is None:
            raise ValueError("'poses: camera' needs a 'camera'")
        return self


class Scenario(Value):
    """Scenario file that was read and checked.

    Args:
        path: where it is; relative paths in it start from its folder.
        spec: its content.
        data: the YAML with line positions.
    """

    path: Path
    spec: ScenarioSpec
    data: Any

    @property
    def name(self) -> str:
        """Name of the scenario, as its file states it."""
        return self.spec.scenario

    def where(self, *location: str | int) -> str:
        """Return "file:line" of a part of the scenario."""
        return f"{self.path}:{line_of(self.data, location)}"

    def where_thing(self, name: str) -> str:
        """Return "file:line" of the entry under ``things`` that defines a thing.

        For a thing without an entry it is that of ``world``, else of the recording's things.
        """
        names = [t.get("name") for t in self.data.get("things", ())]
        if name in names:
            return self.where("things", names.index(name))
        return self.where("world") if self.spec.world else self.where("record", "things")

    def resolve_path(self, name: str) -> Path:
        """Resolve a path that the scenario names, relative to the scenario's folder."""
        return self.path.parent / name

    @property
    def ontologies(self) -> tuple[Path, ...]:
        """Ontology files that the scenario adds."""
        return tuple(map(self.resolve_path, self.spec.ontologies))

    def with_plugins(self, chosen: PluginChoice) -> PluginChoice:
        """Return a selection of plugins extended by the scenario's ``block``, ``prefer`` and ``models``.

        Raises:
            UserError: it names a plugin that there is not; with file and line.
        """
        block, prefer = self.spec.block, self.spec.prefer
        known = plugin_names(chosen.files) if block or prefer else set()
        for key, names in (("block", block), ("prefer", prefer)):
            for k, name in enumerate(names):
                if name not in known:
                    raise UserError(f"{self.where(key, k)}: there is no plugin '{name}' to {key}; {nearest(name, known)}.")
        return chosen.extended(block, prefer, tuple(map(self.resolve_path, self.spec.models)))

    def demonstrated_by(self, episode: Path) -> Scenario:
        """Return this scenario with a demonstration in place of its tasks, designator or goal."""
        update = {"demonstration": str(episode.resolve()), "tasks": None, "designator": None, "goal": None, "plan": None}
        return replace(self, spec=self.spec.model_copy(update=update))

    def read_as(self, reading: int | str) -> Scenario:
        """Return this scenario with one reading of its demonstration chosen.

        Args:
            reading: its number, from 1, as ``cramlite interpret`` lists them; or a task that it has.

        Raises:
            UserError: it has no demonstration.
        """
        if self.spec.demonstration is None:
            raise UserError(f"{self.path}: only a demonstration has readings, and this scenario has no demonstration.")
        return replace(self, spec=self.spec.model_copy(update={"reading": reading}))

    def with_goal(self, goal: Sequence[Any] | Mapping[str, Any]) -> Scenario:
        """Return this scenario with a goal in place of its demonstration, tasks or designator.

        Args:
            goal: sentences such as "tin on tray", or goals as data (``goal_spec``), of which ``{"say": ...}`` may stand alone.

        Raises:
            UserError: it is no list of goals.
        """
        update = {"goal": goal_texts(goal), "demonstration": None, "reading": None, "tasks": None, "designator": None, "plan": None}
        return replace(self, spec=self.spec.model_copy(update=update))

    def stage(self, number: int, key: Literal["do", "else"]) -> Scenario | None:
        """Return this scenario with the tasks of one stage of its ``then`` in place of its own tasks; None if the
        stage has no tasks under ``key``."""
        stage = self.spec.then[number]
        tasks = stage.do if key == "do" else stage.otherwise
        update = {**dict.fromkeys((*STARTS, "reading", "plan")), "tasks": tasks, "then": ()}
        data = {**self.data, "tasks": self.data["then"][number].get(key, [])}
        return replace(self, spec=self.spec.model_copy(update=update), data=data) if tasks else None

    def planned_by(self, plan: Path) -> Scenario:
        """Return this scenario with an external planner's plan for its goal.

        Raises:
            UserError: it has no goal.
        """
        if self.spec.goal is None:
            raise UserError(f"{self.path}: a plan is for a goal, and this scenario has none; write 'goal: [drawer open]'.")
        return replace(self, spec=self.spec.model_copy(update={"plan": str(plan.resolve())}))


INLINE = Path("inline scenario")
"""Path that messages state for a scenario that was given as data and not as a file."""


def read_scenario(path: Path | str | Mapping[str, Any]) -> Scenario:
    """Read a scenario from a file, or from the data that such a file would hold.

    Paths in such data start from the working directory.

    Raises:
        UserError: not YAML, an unknown key, a wrong type or unit: with file, line and the nearest right name.
    """
    if isinstance(path, Mapping):
        return scenario_from(INLINE, path)
    path = Path(path)
    return scenario_from(path, load_yaml(path))


def started_by(data: Any, goal: Any) -> Any:
    """Return scenario data with a client's goal added, if the data have no demonstration, tasks,
    designator or goal of their own."""
    says_where = isinstance(data, Mapping) and data.keys().isdisjoint(STARTS)
    goal = listed_goals(goal)
    return {**data, "goal": list(goal)} if says_where and isinstance(goal, list | tuple) else data


def scenario_from(path: Path, data: Any) -> Scenario:
    """Validate the data of a scenario file that ``load_yaml`` read.

    It raises the same errors as ``read_scenario``.
    """
    if not isinstance(data, Mapping):
        what = "nothing" if data is None else "a list" if isinstance(data, list) else f"'{str(data)[:40]}'"
        raise UserError(
            f"{path}:1: a scenario is a mapping that begins with 'scenario: NAME', but this file holds {what}."
        )
    try:
        return Scenario(path, ScenarioSpec.model_validate(data), data)
    except ValidationError as error:
        raise explain_validation(path, data, error, _valid_keys(error), RENAMED) from error


def _valid_keys(error: ValidationError) -> list[str]:
    """Return the valid keys of that part of a scenario file in which a validation error found the first unknown key."""
    models: dict[str, type[BaseModel]] = {
        "at": PoseSpec,
        "hangs_on": HangSpec,
        "things": ThingSpec,
        "robot": RobotSpec,
        "gripper": GripperSpec,
        "vary": VarySpec,
        "unknown_error": UnknownErrorSpec,
        "late": LateSpec,
        "then": ThenSpec,
        "camera": CameraSpec,
        "intrinsics": IntrinsicsSpec,
        "record": RecordSpec,
        "objects": ObjectSpec,
        "physics": PhysicsSpec,
        "world": WorldFileSpec,
        "joints": JointSpec,
        "limits": LimitsSpec,
        "proof": ProofSpec,
        "errors": ErrorSpec,
        "hand_eye": PoseErrorSpec,
    }
    loc = next((p["loc"] for p in error.errors() if p["type"] == "extra_forbidden"), ())
    if "errors" in loc:
        models["things"] = ThingErrorSpec
    holder = next((models[str(s)] for s in reversed(loc[:-1]) if str(s) in models), ScenarioSpec)
    return [field.alias or name for name, field in holder.model_fields.items()]
