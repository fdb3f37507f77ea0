"""Tasks in scenarios: single tasks with roles, and tasks inside control structures such as ``retry``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    model_validator,
)

from ..base.errors import nearest
from ..base.quantities import Force, Length, Time, beyond_reason_by_name
from ..base.spec import Spec

RULES = ("sequence", "choose", "fallback", "try_all", "parallel", "repeat", "retry", "monitor")
"""Names of control structures: a mapping with one of these as its only key is a control structure, not a task."""

RENAMED: Mapping[str, str] = {
    "try_in_order": "'choose' where the search decides while planning, 'fallback' where the program decides while it runs",
}
"""Former names of control structures in scenario files, with advice on the present names."""

Path = tuple[str | int, ...]


class WhereSpec(Spec):
    """Constraints on the place that a task chooses.

    Left and in front are seen from the robot's base, which looks along x.

    Args:
        near, left_of, right_of, in_front_of, behind: things.
        within: how far ``near`` may be, between the middles, seen from above [m].
        visible_from: "camera", the scenario's where it is fixed, or a point in the world [m].
        attitude: which way its z axis points: "upright" up, "upside down" down; else as it is held.
        facing: a thing that its front looks at, seen from above.
        region: the feature of the place, a surface or a cavity, that its origin is put on or in.
    """

    near: str | None = None
    within: Annotated[Length, Field(gt=0)] = 0.2
    left_of: str | None = None
    right_of: str | None = None
    in_front_of: str | None = None
    behind: str | None = None
    visible_from: Literal["camera"] | tuple[Length, Length, Length] | None = None
    attitude: Literal["upright", "upside down"] | None = None
    facing: str | None = None
    region: str | None = None

    @classmethod
    def sides(cls) -> tuple[str, ...]:
        """Return the names of those constraint fields that relate a task's place to a thing: ``near``,
        ``left_of``, ``behind`` ..."""
        return tuple(name for name, spec in cls.model_fields.items() if spec.annotation == str | None and name not in ("facing", "region"))

    @property
    def things(self) -> tuple[str, ...]:
        """Names of the things to which the constraints on a task's place refer, such as in ``near`` and ``facing``."""
        return tuple(t for t in (getattr(self, name) for name in (*self.sides(), "facing")) if t)


def _within_reason(parameters: dict[str, float]) -> dict[str, float]:
    """Check that the values of a task's parameters are plausible, and return them.

    Raises:
        ValueError: one is no finite number, or more than can be meant.
    """
    for name, value in parameters.items():
        said = beyond_reason_by_name(name, value) if math.isfinite(value) else "not finite"
        if said:
            raise ValueError(f"'{name}: {value:g}' is {said}")
    return parameters


Parameters = Annotated[dict[str, float], AfterValidator(_within_reason)]
"""Parameter of a task -> its value, in the unit that the name ends with."""


class TaskSpec(Spec):
    """Task with its roles: an entry under ``tasks`` of a scenario, and one goal of ``Engine.resolve``.

    Whether there are such a task, roles, things and parameters is seen when it is planned: ``Engine.resolve`` and ``Engine.plans``
    raise UserError with the nearest right name.

    Args:
        task: the task type's class, local name or alias, e.g. "soma:Grasping", "Grasping", "Grasp".
        roles: role -> its filler: a thing ("tea"), a feature of one ("hook/peg"), or one of a scenario's ``objects``.
        parameters: name -> value, in the unit that the name ends with, e.g. {"force_n": 40.0} [N].
        where: conditions on the place that the task chooses, for tasks that put something down; also as a mapping.

    Raises:
        pydantic.ValidationError: a field that there is not, or of another type.
    """

    task: str
    roles: dict[str, str] = Field(default={})
    parameters: Parameters = Field(default={})
    where: WhereSpec | None = None


class RuleSpec(Spec):
    """Control structure with the tasks inside it, which may be nested; ``task_entry`` makes it from ``{RULE: ...}``.

    Args:
        rule: "sequence", "choose", "fallback", "try_all", "parallel", "repeat", "retry" or "monitor".
        do: the branches, each a list of tasks or rules; sequence, repeat, retry and monitor have one.
        paths: where each task of each branch stands in the YAML or Python data, from the rule on: for messages.
        times: of repeat, 1 to 1000.
        changes: of retry, written ``with``: the parameters that each further attempt changes.
        force, slip, time: of monitor: what is watched, and how much is too much [N, m, s].

    Raises:
        pydantic.ValidationError: a field that there is not or of another type, or a rule without what it needs.
    """

    rule: str
    do: tuple[tuple[TaskEntry, ...], ...]
    paths: tuple[tuple[Path, ...], ...]
    times: int = Field(1, ge=1, le=1000)
    changes: tuple[Parameters, ...] = Field((), alias="with")
    force: Annotated[Force, Field(gt=0)] | None = None
    slip: Annotated[Length, Field(gt=0)] | None = None
    time: Annotated[Time, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _complete(self) -> RuleSpec:
        if not self.do or not all(self.do):
            raise ValueError(f"'{self.rule}' needs something to do")
        if self.rule == "retry" and (len(self.do[0]) > 1 or not isinstance(self.do[0][0], TaskSpec)):
            raise ValueError("'retry' is for one task, whose parameters it changes; 'fallback' is for more")
        if self.rule == "retry" and not self.changes:
            raise ValueError("'retry' needs 'with': a list of changed parameters, one for each further attempt")
        if self.rule == "monitor" and self.force is None and self.slip is None and self.time is None:
            raise ValueError("'monitor' needs 'force', 'slip' or 'time': what is watched, and how much is too much")
        return self


OWN: Mapping[str, tuple[str, ...]] = {
    "repeat": ("times",), "retry": ("with",), "monitor": ("force", "slip", "time"),
}  # fmt: skip


def _entry(value: Any) -> Any:
    """Normalise an entry for a task: a bare name, {task: T, Role: filler, parameters: {...}}, or {RULE:
    ...}."""
    if isinstance(value, TaskSpec | RuleSpec):
        return value
    if isinstance(value, str):
        return {"task": value}
    if isinstance(value, Mapping) and len(value) == 1 and next(iter(value)) in RULES:
        return _rule(*next(iter(value.items())))
    if isinstance(value, Mapping) and len(value) == 1 and (old := str(next(iter(value)))) in RENAMED:
        raise ValueError(f"the rule '{old}' is called {RENAMED[old]}")
    if not isinstance(value, Mapping) or "task" not in value:
        keys = list(value) if isinstance(value, Mapping) else []
        hint = f" ({nearest(str(keys[0]), RULES)})" if len(keys) == 1 else ""
        raise ValueError(f"a task is a name, a mapping with 'task' and its roles, or one of {', '.join(RULES)}{hint}")
    own = {"task", "parameters", "where"}
    return {"roles": {k: v for k, v in value.items() if k not in own}, **{k: value[k] for k in own if k in value}}


def _rule(rule: str, value: Any) -> dict[str, Any]:
    """Normalise the body of a control structure: its tasks, or a mapping of options with the tasks under 'do'."""
    single = rule in ("sequence", "repeat", "retry", "monitor")
    options: dict[str, Any] = {}
    path: Path = (rule,)
    do = value
    if isinstance(value, Mapping) and "task" not in value:
        valid = ("do", *OWN.get(rule, ()))
        for key in value:
            if key not in valid:
                raise ValueError(f"'{rule}' has no '{key}'; {nearest(str(key), valid)}")
        options = {k: v for k, v in value.items() if k != "do"}
        do, path = value.get("do", ()), (rule, "do")
    parts = [(path, do)] if not isinstance(do, list | tuple) else [((*path, k), v) for k, v in enumerate(do)]
    branches = [parts] if single and parts else [_listed(*p) for p in parts]
    tasks = [[v for _, v in b] for b in branches]
    return {"rule": rule, "do": tasks, "paths": [[p for p, _ in b] for b in branches], **options}


def _listed(path: Path, value: Any) -> list[tuple[Path, Any]]:
    """Return the tasks in a branch of a control structure, each with the keys that lead to it in the file's data."""
    return [((*path, k), v) for k, v in enumerate(value)] if isinstance(value, list | tuple) else [(path, value)]


def _which(value: Any) -> str:
    return "rule" if isinstance(value, RuleSpec) or (isinstance(value, Mapping) and "rule" in value) else "call"


TaskEntry = Annotated[
    Annotated[TaskSpec, Tag("call")] | Annotated[RuleSpec, Tag("rule")], Discriminator(_which), BeforeValidator(_entry)
]
RuleSpec.model_rebuild()


def task_entry(value: Any) -> TaskSpec | RuleSpec:
    """Return the task or control structure that Python data describe as YAML would, e.g. ``{"repeat": {"times": 3,
    "do": ["ParkArms"]}}``.

    Raises:
        pydantic.ValidationError: it is none.
    """
    found: TaskSpec | RuleSpec = TypeAdapter(TaskEntry).validate_python(value)
    return found
