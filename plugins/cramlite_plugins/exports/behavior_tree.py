"""BehaviorTree.CPP tree of a program: XML of version 4, with the manifest of the nodes to be implemented.

The order of tasks and steps, fallbacks, loops and monitors are those of the program that was proven. Each step is an action node
whose input ports are the step's fields (``cramlite.model.Step``): numbers, and lists of numbers as BehaviorTree.CPP writes
``std::vector<double>``, "1;2;3"; poses are x;y;z;qw;qx;qy;qz, several rows one after the other. Source of the format:
BehaviorTree.CPP documentation, "XML format" and "The XML schema: TreeNodesModel".
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as Xml

from msgspec.structs import asdict

from cramlite.model import Control, Fallback, Monitor, Parallel, Pose, Repeat, task_of, walk
from cramlite.plugin import Exporter, UserError, hookimpl

if TYPE_CHECKING:
    from cramlite.model import AnyStep, Program, RunRecord, Step

FORCE, SLIP = "ForceBelow", "SlipBelow"
"""Conditions that monitors watch: the force at the TCP [N], and how far the fingers have closed further [m]."""
NOTICE, WHY = "notice", "why it failed: JSON with kind (a class of the ontology), step, thing, reason, measured, limit, unit; or empty"
"""Output port of every action, which writes the entry of the same name on the blackboard, and a description of this entry."""
PORT_TYPES = {float: "double", int: "double", str: "std::string", tuple: "std::vector<double>", Pose: "std::vector<double>"}
"""Type of a field -> type of its port in C++."""


@hookimpl
def exporters() -> Iterable[Exporter]:
    """Declare the export format BehaviorTree.CPP."""
    return [Exporter("btcpp", ".xml", "BehaviorTree.CPP 4, Groot 2", write_tree)]


def write_tree(run: RunRecord, out: Path) -> None:
    """Write the behaviour tree of a run's program to a new file.

    Raises:
        UserError: the run's folder holds no typed program.
    """
    if run.program is None:
        raise UserError(
            f"The run '{run.name}' holds no typed program, which a behaviour tree is made of: give the run directory of "
            "'cramlite resolve --out'."
        )
    out.write_text(tree_xml(run.program), encoding="utf-8")


def tree_xml(program: Program) -> str:
    """Return the XML text of a program's behaviour tree and of the manifest of its nodes."""
    root = Xml.Element("root", BTCPP_format="4", main_tree_to_execute=safe_name(program.name))
    root.append(Xml.Comment(_preconditions(program)))
    grouped = [(task, list(steps)) for task, steps in groupby(program.steps, key=lambda s: task_of(s.origin))]
    parts = [(safe_name(f"{task.partition('.')[2]} {number}"), steps) for number, (task, steps) in enumerate(grouped, 1)]
    main = Xml.SubElement(root, "BehaviorTree", ID=safe_name(program.name))
    watched = Xml.SubElement(main, "ReactiveSequence", name="watchdog")
    Xml.SubElement(watched, FORCE, limit=repr(program.force_limit))
    whole = Xml.SubElement(watched, "Sequence", name=safe_name(program.name))
    for part, steps in parts:
        Xml.SubElement(whole, "SubTree", ID=part)
        tree = Xml.SubElement(root, "BehaviorTree", ID=part)
        tree.append(_sequence(steps, part))
    root.append(_manifest(program.steps))
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def safe_name(name: str) -> str:
    """Return a name without the characters that BehaviorTree.CPP refuses in names, e.g. "1.Grasping/close" as "1_Grasping_close"."""
    return re.sub(r"\W+", "_", name)


def _preconditions(program: Program) -> str:
    """XML comment on what must hold before the behaviour tree is executed; it has no double hyphens, which
    XML forbids in comments."""
    start = ", ".join(f"{q:.4f}" for q in program.start)
    said = (
        f" cramlite {program.name}: robot {program.robot_type}, start posture [{start}] rad, TCP {_text(program.tcp)} in the flange, "
        f"payload {program.mass:g} kg, force limit {program.force_limit:g} N. What was proven is the program's own text; the "
        "nodes of the tree must do what the program's steps do. "
    )
    return said.replace("--", "- -")


def _sequence(steps: Iterable[AnyStep], name: str) -> Xml.Element:
    sequence = Xml.Element("Sequence", name=name)
    sequence.extend(map(_node, steps))
    return sequence


def _node(step: AnyStep) -> Xml.Element:
    """Return the node of a step in the behaviour tree, as XML, with the nodes of its inner steps as children."""
    match step:
        case Fallback():
            return _with_branches("Fallback", step, {})
        case Parallel():
            needed = {"all": ("-1", "1"), "first": ("1", "-1")}[step.until]
            return _with_branches("Parallel", step, {"success_count": needed[0], "failure_count": needed[1]})
        case Repeat():
            loop = Xml.Element("Repeat", name=safe_name(step.origin), num_cycles=str(step.count))
            loop.append(_sequence(step.steps, safe_name(step.origin)))
            return loop
        case Monitor():
            return _monitored(step)
        case _:
            ports = {name: _text(value) for name, value in _given(step).items()}
            return Xml.Element(type(step).__name__, {"name": safe_name(step.origin), **ports, NOTICE: f"{{{NOTICE}}}"})


def _with_branches(kind: str, step: Fallback | Parallel, more: dict[str, str]) -> Xml.Element:
    name = safe_name(step.origin)
    node = Xml.Element(kind, {"name": name, **more})
    node.extend(_sequence(branch, f"{name}_{number}") for number, branch in enumerate(step.branches, 1))
    return node


def _monitored(step: Monitor) -> Xml.Element:
    """Return the tree node of a monitor step: limits of force and slip, which are checked at every tick while the
    inner steps run, and a time limit."""
    name = safe_name(step.origin)
    inner = _sequence(step.steps, name)
    if step.time is not None:
        limit = Xml.Element("Timeout", name=f"{name}_time", msec=str(round(1000 * step.time)))
        limit.append(inner)
        inner = limit
    node = Xml.Element("ReactiveSequence", name=name)
    for condition, value in ((FORCE, step.force), (SLIP, step.slip)):
        if value is not None:
            Xml.SubElement(node, condition, limit=repr(value))
    node.append(inner)
    return node


def _given(step: Step) -> dict[str, Any]:
    """The fields of a step that have a value."""
    return {name: value for name, value in asdict(step).items() if value not in ("", (), None)}


def _text(value: Any) -> str:
    return ";".join(map(repr, _numbers(value))) if isinstance(value, tuple | Pose) else str(value)


def _numbers(value: Any) -> Iterator[float]:
    """Flatten nested tuples and poses to one sequence of numbers; booleans become 1 and 0."""
    if isinstance(value, Pose):
        yield from (*value.position, *value.quaternion)
    elif isinstance(value, tuple):
        for inner in value:
            yield from _numbers(inner)
    else:
        yield int(value) if isinstance(value, bool) else value


def _manifest(steps: Iterable[AnyStep]) -> Xml.Element:
    """Nodes that BehaviorTree.CPP does not have, with their ports: the user implements them."""
    used: dict[str, dict[str, str]] = {FORCE: {"limit": PORT_TYPES[float]}}
    for step in walk(steps):
        if isinstance(step, Monitor) and step.slip is not None:
            used[SLIP] = {"limit": PORT_TYPES[float]}
        elif not isinstance(step, Control):
            ports = used.setdefault(type(step).__name__, {})
            ports.update({name: PORT_TYPES[type(value)] for name, value in _given(step).items()})
    model = Xml.Element("TreeNodesModel")
    for name, ports in sorted(used.items()):
        entry = Xml.SubElement(model, "Condition" if name in (FORCE, SLIP) else "Action", ID=name)
        for port, kind in ports.items():
            Xml.SubElement(entry, "input_port", name=port, type=kind)
        if entry.tag == "Action":
            Xml.SubElement(entry, "output_port", name=NOTICE, type=PORT_TYPES[str]).text = WHY
    return model
