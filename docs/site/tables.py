"""Tables of the reference that are written from the code: one stands after each ``<!-- table: KIND NAME -->`` in a page.

``python docs/site/tables.py`` writes them anew into the pages.
"""

from __future__ import annotations

import argparse
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from cramlite import Engine, TaskSpec, data_folder
from cramlite.plugin import Angle, Length, Mass, load_yaml

MARK = re.compile(r"^(<!-- table: (\w+) ?(\w*) -->)(?:\n\n\|.*(?:\n\|.*)*)?$", re.MULTILINE)
"""The comment that names a table, and the table after it."""
REFERENCE = Path(__file__).parents[1] / "reference"
UNITS = {Length: "length", Angle: "angle", Mass: "mass"}
PLAIN = {str: "text", float: "number", int: "whole number", bool: "true or false", Any: "anything"}
COMMON = ("--plugin", "--block", "--prefer")
"""Options that every command takes: they stand once, in the index of commands."""


def filled(markdown: str) -> str:
    """Rewrite each table that a comment of a page names (``<!-- table: KIND NAME -->``)."""
    return MARK.sub(lambda m: f"{m[1]}\n\n{table(m[2], m[3])}", markdown)


def table(kind: str, name: str = "") -> str:
    """Return the table of a kind and name as Markdown.

    Raises:
        KeyError: there is no such kind, or nothing of that name.
    """
    return TABLES[kind](name)


def rows(*cells: Iterable[str]) -> str:
    """Return rows of cells as a Markdown table; the first row is the head."""
    head, *body = [[c.replace("|", "\\|") for c in row] for row in cells]
    return "\n".join("| " + " | ".join(r) + " |" for r in [head, ["---"] * len(head), *body])


def commands() -> Mapping[str, argparse.ArgumentParser]:
    """Return the parser of each command."""
    from cramlite.cli.main import parser

    actions = parser()._actions
    return dict(next(a for a in actions if isinstance(a, argparse._SubParsersAction)).choices)


def options(command: str) -> str:
    """Return the arguments of a command with their help."""
    found = [a for a in commands()[command]._actions[1:] if not set(a.option_strings) & set(COMMON)]
    return rows(("argument", "meaning"), *((f"`{argument(a)}`", str(a.help or "")) for a in found))


def argument(action: argparse.Action) -> str:
    """Return an argument as it is typed, such as ``--out FILE``."""
    name = ", ".join(action.option_strings) or str(action.metavar or action.dest)
    value = "" if action.nargs == 0 or not action.option_strings else f" {action.metavar or action.dest.upper()}"
    return name + value


def model(name: str) -> str:
    """Return the parameters of an object model, each with the meaning that the docstring gives."""
    from cramlite_plugins.objects.products_and_fixtures import MODELS

    function = MODELS[name]
    hints, meanings = get_type_hints(function, include_extras=True), explained(function)
    own = [p for p in inspect.signature(function).parameters.values() if p.name not in ("name", "pose")]
    body = ((f"`{p.name}`", kind_of(hints[p.name]), default_of(p), meanings.get(p.name, "")) for p in own)
    return rows(("parameter", "type", "default", "meaning"), *body)


def explained(function: Callable[..., Any]) -> dict[str, str]:
    """Return the entries of a function's docstring under ``Args``, by parameter."""
    listed = re.search(r"^Args:\n((?:    .*\n?)+)", inspect.getdoc(function) or "", re.MULTILINE)
    entries = re.findall(r"^    (\w+(?:, \w+)*): (.*(?:\n        .*)*)", listed[1] if listed else "", re.MULTILINE)
    return {name: " ".join(text.split()).removesuffix(".") for names, text in entries for name in names.split(", ")}


def kind_of(hint: Any) -> str:
    """Return a type in words."""
    known = {**UNITS, **PLAIN}
    if hint in known:
        return known[hint]
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return "task" if arguments[0] is TaskSpec else kind_of(arguments[0])
    if origin in (UnionType, Union):
        return kind_of(next(a for a in arguments if a is not type(None)))
    if origin is Literal:
        return " or ".join(map(str, arguments))
    if origin is tuple:
        several = arguments[-1] is Ellipsis
        return f"list of {kind_of(arguments[0])}" if several else f"{len(arguments)} x {kind_of(arguments[0])}"
    return f"list of {kind_of(arguments[0])}" if origin is list else "declared feature"


def default_of(parameter: inspect.Parameter) -> str:
    """Return a default as a scenario would write it."""
    value = parameter.default
    if value is parameter.empty:
        return "required"
    if isinstance(value, tuple | list):
        return "[" + ", ".join(f"{v:g}" for v in value) + "]" if value else "none"
    return "none" if value in (None, "") else f"{value:g}" if isinstance(value, float) else str(value)


def motion(which: str) -> str:
    """Return a table of the kinds of motions, of their parameters, or of the words that parameters take."""
    from cramlite_plugins.motions.motion_kinds import KINDS

    kinds = KINDS.values()
    if which == "kinds":
        body = ((f"`{k.name}`", f"`{k.step}`", k.ends, "; ".join(k.aborts) or "-", millimetres(k.widens)) for k in kinds)
        return rows(("kind", "step", "ends well", "aborts", "widens"), *body)
    if which == "parameters":
        each = ((k, p) for k in kinds for p in k.parameters)
        body = ((f"`{k.name}`", f"`{p.name}`", f"{p.default:g}", p.source) for k, p in each)
        return rows(("kind", "parameter", "default", "source"), *body)
    words = ((k, name, "; ".join(f"`{w}`: {w.says}" for w in known)) for k in kinds for name, known in k.words.items())
    return rows(("kind", "parameter", "words"), *((f"`{k.name}`", f"`{n}` (`{k.words[n].__name__}`)", t) for k, n, t in words))


def millimetres(metres: float) -> str:
    """Return a length for a table, "-" for none."""
    return f"{1000 * metres:g} mm" if metres else "-"


def task(_: str) -> str:
    """Return the task types that the shipped plugins declare."""
    from cramlite.cli.texts import tasks_json

    rules = {load_yaml(p)["task"]: p.name for p in data_folder("task_rules").glob("*.yaml")}
    body = []
    for t in tasks_json(Engine().knowledge.tasks.values()):
        roles = ", ".join(r["name"] + ("" if r["required"] else "?") for r in t["roles"])
        numbers = ", ".join(f"{p['name']} = {p['default']:g}" for p in t["parameters"])
        rule = rules.get(t["task"], "none")
        body.append((f"`{t['task']}`", ", ".join(t["aliases"]), roles, numbers, rule, t["summary"]))
    return rows(("task", "also", "roles", "parameters", "rule file", "what it does"), *body)


def experts(_: str) -> str:
    """Return the experts of perception with what they need and make."""

    def names(values: Iterable[str]) -> str:
        return ", ".join(f"`{v}`" for v in values)

    order = {"view": 0, "object": 1, "scene": 2}
    found = sorted(Engine().knowledge.experts, key=lambda e: (order[e.scope], e.name))
    body = ((f"`{e.name}`: {e.summary}", e.scope, names(e.inputs), names(e.uses), names(e.outputs)) for e in found)
    return rows(("expert", "scope", "inputs", "uses", "makes"), *body)


TABLES: dict[str, Callable[[str], str]] = {
    "options": options, "model": model, "motion": motion, "task": task, "experts": experts,
}  # fmt: skip


def everything() -> list[tuple[str, str]]:
    """Return kind and name of every table that some page of the reference should show."""
    from cramlite_plugins.objects.products_and_fixtures import MODELS

    taking = [c for c, p in commands().items() if len(p._actions) > 1 + len(COMMON)]
    found = [("options", c) for c in taking] + [("model", m) for m in MODELS]
    return [*found, *(("motion", w) for w in ("kinds", "parameters", "words")), ("task", "types"), ("experts", "")]


if __name__ == "__main__":
    for path in sorted(REFERENCE.rglob("*.md")):
        path.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
