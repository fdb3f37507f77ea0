"""JSON Schemas of scenario and rule files, so that editors complete and check them."""

from __future__ import annotations

from typing import Any

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema of scenario files; it covers all checks of ``read_scenario`` that need no
    world."""
    from .scenario import ScenarioSpec

    schema = ScenarioSpec.model_json_schema(by_alias=True)
    entry = {"$ref": "#/$defs/task"}
    schema["properties"] |= {"tasks": {"type": "array", "items": entry}, "designator": entry}
    schema["$defs"] = {n: d for n, d in schema["$defs"].items() if n not in ("TaskSpec", "RuleSpec")} | {"task": _task()}
    return {"$schema": DIALECT, **schema, "title": "cramlite scenario"}


def _task() -> dict[str, Any]:
    """Return the schema of an entry for a task: a name, a mapping with roles, or a control structure over tasks."""
    from .task_specs import OWN, RULES

    entry = {"$ref": "#/$defs/task"}
    do = {"anyOf": [entry, {"type": "array", "items": {"anyOf": [entry, {"type": "array", "items": entry}]}}]}
    call = {
        "type": "object",
        "required": ["task"],
        "properties": {
            "task": {"type": "string", "description": "a task type's name or alias"},
            "parameters": {"type": "object", "additionalProperties": {"type": "number"}},
        },
        "additionalProperties": {"type": "string", "description": "the filler of a role"},
    }
    rules = [
        {
            "type": "object",
            "required": [rule],
            "additionalProperties": False,
            "properties": {rule: {"anyOf": [do, _body(do, OWN.get(rule, ()))]}},
        }
        for rule in RULES
    ]
    return {"anyOf": [{"type": "string"}, call, *rules]}


def _body(do: dict[str, Any], options: tuple[str, ...]) -> dict[str, Any]:
    """Return the schema of a control structure's options, with its tasks under 'do'."""
    properties = {"do": do, **{name: {} for name in options}}
    return {"type": "object", "required": ["do"], "additionalProperties": False, "properties": properties}


def rule_schema() -> dict[str, Any]:
    """Return the JSON Schema of rule files; the text of a condition is checked by ``cramlite check``."""
    from ..interpretation.rules import PHASES

    name = {"type": "string", "pattern": r"^[a-z]+:\w+$"}
    conditions = {
        "type": "array",
        "items": {"type": "string", "minLength": 3},
        "description": "atoms such as 'grasps(Gripper, Patient)', 'not atom', 'A or B', 'every A -> B', comparisons",
    }
    when = {"pre": "just before the action", "run": "all through the action", "post": "just after the action"}
    phases = {p: {**conditions, "description": f"what holds {when[p]}: {conditions['description']}"} for p in PHASES}
    return {
        "$schema": DIALECT,
        "title": "cramlite rule",
        "type": "object",
        "required": ["task"],
        "additionalProperties": False,
        "properties": {
            "task": {**name, "description": "class of the task, below dul:Task"},
            "roles": {
                "type": "object",
                "description": "role and variable name: class of the role",
                "additionalProperties": name,
                "propertyNames": {"pattern": "^[A-Z]"},
            },
            "source": {"type": "string", "description": "where the conditions come from"},
            **phases,
            "needs": {**conditions, "description": f"conditions before the task, for planning only: {conditions['description']}"},
            "leaves": {**conditions, "description": f"conditions after the task, for planning only: {conditions['description']}"},
            "explain": {"type": "string", "description": "a sentence with {Variable} placeholders"},
        },
    }


SCHEMAS = {"scenario": scenario_schema, "rule": rule_schema}
