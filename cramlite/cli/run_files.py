"""Files of a run directory: its results, and the key by which unchanged inputs are recognised."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import json, to_builtins
from msgspec.structs import replace

from ..base.errors import UserError
from ..base.json_text import as_json
from ..base.run_directory import RunDirectory, content_key
from ..engine.proof.intent import FILE as INTENT
from ..engine.proof.intent import write_intent
from ..planning.diagnosis import how_it_ended, nearest_miss
from ..planning.goal_parts import goal_answers
from ..planning.what_to_try import what_to_try
from ..version import VERSION
from .texts import rollout_json, warn_of

if TYPE_CHECKING:
    from ..engine.engine import Engine
    from ..engine.execution import Execution
    from ..engine.picture_checks import PictureChecks
    from ..engine.setting import Setting
    from ..engine.solution import Solution
    from ..model.episode import Event
    from ..model.run.rollout import Rollout
    from ..model.run.twin_verdict import TwinVerdict
    from ..planning.trace import Trace
    from ..plugin.catalogue import Knowledge
    from ..scenario.scenario import Scenario


def run_key(scenario: Scenario, setting: Setting, backend: str | None, engine: Engine) -> dict[str, Any]:
    """Return the inputs by which an unchanged run is recognised: hash of its files, seed, settings of the
    proof in twins, backend and plugins."""
    files = [*([scenario.path] if scenario.path.is_file() else []), *(Path(t.mesh.path) for t in setting.world.things if t.mesh)]
    if scenario.spec.demonstration and scenario.resolve_path(scenario.spec.demonstration).exists():
        files.append(scenario.resolve_path(scenario.spec.demonstration))
    if scenario.spec.plan and scenario.resolve_path(scenario.spec.plan).is_file():
        files.append(scenario.resolve_path(scenario.spec.plan))
    said = [goal for goal in scenario.spec.goal or () if goal.startswith("say")]
    plugins = [f"{i.name} {i.version}" for i in engine.registry.infos]
    return {
        "cramlite": VERSION, "scenario": scenario.name, "content": content_key(*files),
        "seed": setting.seed, "blocked": sorted(engine.registry.blocked),
        "reading": scenario.spec.reading, "doubts": json.decode(json.encode(setting.doubts)), "backend": backend,
        "plugins": content_key(*engine.registry.files) if engine.registry.files else len(plugins),
        **({"said": said} if said else {}),
    }  # fmt: skip


def write_trace(run: RunDirectory, trace: Trace, engine: Engine) -> None:
    """Write every decision of a search, and the plugins that failed during it, into its run directory."""
    faults = [str(f) for f in engine.registry.faults]
    run.write("trace.json", as_json({"entries": trace.to_json(), "faults": faults}))


def write_solution(run: RunDirectory, solution: Solution, engine: Engine, seed: int) -> None:
    """Write program, world, plan, verdict, recorded run and summary of a solution into a run directory, each
    into a file."""
    from ..model.program.program_json import write_program
    from ..model.run.rollout import save_rollout

    candidate = solution.candidate
    run.write(f"program{candidate.written.suffix}", candidate.written.text)
    run.write("program.json", write_program(candidate.program))
    run.write("world.json", json.format(json.encode(candidate.world), indent=1))
    run.write("plan.json", as_json(candidate.plan))
    run.write(INTENT, write_intent(candidate))
    run.write("verdict.json", as_json(solution.verdict))
    if candidate.rollout is not None:
        save_rollout(candidate.rollout, run.path / "rollout.npz")
    run.write("summary.json", as_json(solution_summary(solution, run, engine, seed)))
    if solution.interpretation is not None:
        run.write("interpretation.json", as_json(solution.interpretation.to_json()))
    if candidate.episode is not None and not (run.path / "episode").exists():
        engine.knowledge.episodes.write(candidate.episode, run.path / "episode")
    if solution.execution is not None:
        write_execution(run, solution.execution, engine)


def write_execution(run: RunDirectory, execution: Execution, engine: Engine) -> None:
    """Write an execution, with the real world that it was in, into a folder as ``cramlite execute --out`` writes one."""
    from ..model.run.rollout import save_rollout

    candidate, place = execution.candidate, "execution"
    assert candidate.episode is not None
    run.write(f"{place}/execution.json", as_json(rollout_json(candidate.ran)))
    run.write(f"{place}/world.json", json.format(json.encode(candidate.ran.world), indent=1))
    run.write(f"{place}/verdict.json", as_json(execution.verdict))
    if execution.checks is not None:
        run.write(f"{place}/checks.json", as_json(checks_json(execution.checks)))
    run.write(f"{place}/program{candidate.written.suffix}", candidate.written.text)
    save_rollout(candidate.ran, run.path / place / "rollout.npz")
    if not (run.path / place / "episode").exists():
        engine.knowledge.episodes.write(candidate.episode, run.path / place / "episode")


def write_run(
    out: Path, rollout: Rollout, name: str, knowledge: Knowledge, *, episode: bool, events: Sequence[Event] = ()
) -> None:
    """Write a recorded run into a folder: result, recording, world and episode."""
    from ..model.run.rollout import save_rollout

    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / "execution.json").write_text(as_json(rollout_json(rollout)), encoding="utf-8", newline="\n")
        save_rollout(rollout, out / "rollout.npz")
        (out / "world.json").write_bytes(json.format(json.encode(rollout.world), indent=1))
    except OSError as error:
        raise UserError(f"'{out}' cannot be written: {error.strerror}.") from error
    if episode:
        found = knowledge.episodes.detect(rollout, name)
        whole = replace(found, events=tuple(sorted((*found.events, *events), key=lambda e: e.start)))
        knowledge.episodes.write(whole, out / "episode")
        warn_of(knowledge.registry.faults)


def solution_summary(solution: Solution, run: RunDirectory, engine: Engine, seed: int) -> dict[str, Any]:
    """Return the summary of a proven program, for ``--json`` and summary.json."""
    entities = {k: v for k, v in solution.candidate.bindings.items() if isinstance(v, str)}
    return {
        "solved": solution.succeeded, "proven": True, "headline": solution.headline, "execution": _execution(solution.execution),
        "directory": str(run.path), "seed": seed, "candidate": solution.number, "plan": str(solution.plan),
        "objects": entities, "steps": len(solution.program.steps), "findings": solution.verdict.findings,
        "advice": [f.reason for f in solution.advice], "left_out": solution.verdict.left_out, "twins": twins_json(solution.verdict.twins),
        "goal": goal_answers(solution.trace, solution.number),
        "reason": _reason(solution), "nearest": None, "try": (), "faults": _faults(engine),
    }  # fmt: skip


def _execution(execution: Execution | None) -> dict[str, Any] | None:
    """Result of the first execution; None without a real world, or if nothing could be run."""
    if execution is None:
        return None
    verdict = execution.verdict
    said = {"succeeded": verdict.passed, "reason": verdict.reason, "findings": verdict.findings}
    return said | ({} if execution.checks is None else {"checks": checks_json(execution.checks)})


def checks_json(checks: PictureChecks) -> dict[str, Any]:
    """Return what the pictures of an execution tell, for ``--json`` and checks.json."""
    pictures = [
        {"task": p.task, "time": p.time, "things": [{**to_builtins(s), "seen": s.seen, "reason": s.reason} for s in p.things]}
        for p in checks.pictures
    ]
    return {"looks": checks.looks, "reason": checks.reason, "notices": to_builtins(checks.notices), "pictures": pictures}


def twins_json(found: TwinVerdict | None) -> dict[str, Any] | None:
    """Return how many of a program's runs in twins succeeded, and why others failed; None if it ran in no twin.

    The errors that were drawn for the twins are in verdict.json.
    """
    if found is None:
        return None
    return {
        "succeeded": found.succeeded, "ran": found.ran, "of": found.doubts.runs, "interval": found.interval,
        "at_least": found.doubts.at_least, "failed": [{"twin": t.number, "reason": t.text} for t in found.failed],
    }  # fmt: skip


def _reason(solution: Solution) -> str:
    """Return why a program failed in its first execution or, if it did not, the reason of the verdict on
    its proof."""
    failed = solution.execution is not None and not solution.succeeded
    return f"first execution: {solution.execution.verdict.reason}" if failed and solution.execution else solution.verdict.reason


def failure_summary(trace: Trace, run: RunDirectory, engine: Engine, seed: int) -> dict[str, Any]:
    """Return the summary of a search that found no proven program, with the keys that the summary of a
    program has."""
    return {
        "solved": False, "proven": False, "headline": "No solution", "execution": None,
        "directory": str(run.path), "seed": seed, "candidate": None, "plan": None,
        "objects": {}, "steps": 0, "findings": [], "advice": [], "left_out": [], "twins": None, "goal": goal_answers(trace),
        "reason": how_it_ended(trace.entries), "nearest": nearest_miss(trace.entries), "try": what_to_try(trace.entries),
        "faults": _faults(engine),
    }  # fmt: skip


def _faults(engine: Engine) -> list[str]:
    return list(dict.fromkeys(map(str, engine.registry.faults)))
