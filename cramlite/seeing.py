"""Asking what a camera sees: ``cramlite perceive``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from .errors import NoSolution, UserError
from .experts import Judged
from .explain import as_json
from .geometry import Pose
from .knowledge import pick
from .looking import Look, Picture, ask, pictures
from .object_query import parse_query
from .plugin_choice import INSTALLED, PluginChoice
from .resources import find_scenario
from .scenario import read_scenario
from .scenario_world import build_world, real_world
from .world import Camera

if TYPE_CHECKING:
    from .engine import Engine
    from .object_query import ObjectQuery
    from .perceived import Perceived, Percept

SHOWN = 3
"""Lost hypotheses of a value that the text names; the page and the JSON have all."""


def perceive_view(
    source: str,
    text: str,
    *,
    wants: tuple[str, ...] = ("type", "pose"),
    seed: int = 0,
    out: Path | None = None,
    plugins: PluginChoice = INSTALLED,
    json_output: bool = False,
) -> int:
    """Answer a query about a scenario's camera, or about a recorded view.

    Args:
        source: a scenario's path or name, or a file that a plugin reads as a view.
        text: the query, as ``object_query.parse_query`` reads it.
        wants: values that answers should have, beside those that decide.
        out: folder for the page ``perception.html``.

    Returns:
        0 when something was found.

    Raises:
        NoSolution: nothing was found; the message has the reasons.
        NoPipeline: the experts cannot answer it.
        UserError: a query or a source that cannot be used.
    """
    engine = plugins.engine()
    knowledge = engine.knowledge
    outputs = {o for e in knowledge.experts if e.scope != "view" for o in e.outputs}
    query = replace(parse_query(text, knowledge.taxonomy, outputs), wanted=wants)
    taken = picture_of(source, query, engine, seed)
    found = ask(query, taken.view, taken.fixtures, knowledge, robot=taken.robot)
    if out is not None:
        from .report.perception_page import write_page

        write_page(out, found, taken.view, knowledge.products)
    print(as_json(perceived_json(found)) if json_output else perceived_text(found))
    for fault in dict.fromkeys(str(f) for f in engine.registry.faults):
        print(f"cramlite: warning: {fault}", file=sys.stderr)
    if not found.answers:
        raise NoSolution("Nothing was found; the reasons are above." if not json_output else found.remarks[0])
    return 0


def picture_of(source: str, query: ObjectQuery, engine: Engine, seed: int) -> Picture:
    """What is seen, and the fixtures whose poses are known: those of a scenario, none for a recording."""
    knowledge, path = engine.knowledge, Path(source)
    if path.exists() and path.suffix not in (".yaml", ".yml"):
        view = engine.registry.first("read_view", path=path)
        if view is not None:
            return Picture(view, Camera(view.camera, intrinsics=view.intrinsics), ())
        if path.is_file():
            raise UserError(f"'{path}' is in no format that a plugin reads as a view; see 'cramlite plugins'.")
    scenario = read_scenario(find_scenario(source))
    robot = pick("robot", knowledge.robots, scenario.spec.robot.type, scenario.where("robot", "type"))
    world, relations = build_world(scenario, scenario.spec.things, scenario.spec.vary, knowledge.models, seed)
    real = real_world(scenario, world, relations, seed)
    return next(pictures(scenario, query, Look((), world, relations, {}, real), robot, knowledge, seed))


def perceived_text(found: Perceived) -> str:
    """Answers, what was left out and why, and the pipeline, for people."""
    lines = [f"{len(found.answers)} answers to '{found.query}' in {found.ms:.0f} ms of CPU time"]
    for k, answer in enumerate(found.answers, 1):
        lines.append(f"  {k}. object {answer.number}, confidence {answer.confidence:.2f}")
        lines += [f"       {line}" for line in _value_lines(answer, found)]
    lines += [f"  not object {p.number}: {p.dropped}" for p in found.dropped]
    lines += [f"  remark: {r}" for r in found.remarks]
    lines.append(f"  pipeline: {found.pipeline}")
    lines += [f"  failed: {f}" for r in found.runs for f in r.failures]
    return "\n".join(lines)


def _value_lines(answer: Percept, found: Perceived) -> Iterator[str]:
    for name in found.query.outputs:
        said = answer.values.get(name)
        if said is None or (shown := plain(said.value)) is None:
            continue
        lost = ", ".join(f"{plain(o.value)} {o.confidence:.2f}" for o in said.judged.others[:SHOWN] if name != "pose")
        yield f"{name}: {in_words(shown)}  ({said.expert}, {said.judged.confidence:.2f}: {said.judged.reason})" + (
            f"; rather than {lost}" if lost else ""
        )


def in_words(value: Any) -> str:
    """A plain value for people."""
    if isinstance(value, dict) and "position" in value:
        x, y, z = value["position"]
        w, *v = value["quaternion"]
        return f"[{x:.4f}, {y:.4f}, {z:.4f}] m, [{w:.4f}, {v[0]:.4f}, {v[1]:.4f}, {v[2]:.4f}]"
    if isinstance(value, list):
        return "; ".join(" ".join(v) if isinstance(v, list) else str(v) for v in value) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def plain(value: Any) -> Any:
    """A value as JSON knows it; None for images and point clouds."""
    if isinstance(value, str | int | float):
        return value
    if isinstance(value, Pose):
        return {"position": list(value.position), "quaternion": list(value.quaternion)}
    if isinstance(value, tuple) and all(isinstance(v, str) or (isinstance(v, tuple) and v) for v in value):
        return [list(v) if isinstance(v, tuple) else v for v in value]
    return None


def perceived_json(found: Perceived) -> dict[str, Any]:
    """All of it that is no image."""
    return {
        "query": str(found.query),
        "answers": [_percept_json(p) for p in found.answers],
        "dropped": [_percept_json(p) for p in found.dropped],
        "remarks": found.remarks,
        "pipeline": [{"value": s.output, "experts": [p.name for p in s.providers]} for s in found.pipeline.stages],
        "runs": found.runs,
        "cpu_ms": found.ms,
    }


def _percept_json(percept: Percept) -> dict[str, Any]:
    values = {
        name: {"expert": said.expert, **_judged_json(said.judged)}
        for name, said in percept.values.items()
        if plain(said.value) is not None
    }
    own = {"object": percept.number, "confidence": percept.confidence, "experts": percept.experts, "values": values}
    return own | {"dropped": percept.dropped, "missing": percept.missing}


def _judged_json(judged: Judged) -> dict[str, Any]:
    others = [_judged_json(o) for o in judged.others]
    return {"value": plain(judged.value), "confidence": judged.confidence, "reason": judged.reason, "others": others}
