"""Printed output of commands: values become text for people, or JSON for machines."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import asdict, replace

from ..ontology.foundation import ACTION

if TYPE_CHECKING:
    from ..engine.picture_checks import PictureChecks
    from ..engine.solution import Solution
    from ..interpretation.interpretation import Interpretation, Interpreted
    from ..interpretation.matching import Match
    from ..model.episode import Repair
    from ..model.run.rollout import Rollout
    from ..model.run.verdict import Verdict
    from ..plugin.registry import Fault, PluginInfo, Registry
    from ..plugin.task_type import TaskType
    from ..scenario.scenario import Scenario


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: "0 shapes", "1 shape", "2 shapes"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def solution_text(solution: Solution, folder: str) -> str:
    """Return a short summary of a proven program, and of its first execution."""
    from ..planning.goal_parts import goal_answers
    from ..planning.trace import understood_entries

    program, plan, execution = solution.program, solution.plan, solution.execution
    lines = [
        f"{solution.headline}: {plan}",
        f"  from candidate sequence {solution.number}, {counted(len(program.steps), 'step')}, "
        f"{counted(solution.code.count(chr(10)), 'line')}",
    ]
    chosen = {e.designator: e for e in solution.trace.entries if e.outcome == "chosen"}
    for designator in plan.objects:
        entry = chosen.get(designator.name)
        found = f"{entry.text}: {entry.reason}" if entry else "?"
        lines.append(f"  {designator.name} ({', '.join(designator.types) or 'by name'}) = {found}")
    lines += [f"  Understood: {e.text}, {e.reason}" for e in understood_entries(solution.trace.entries)]
    lines += [f"  Goal: {answer}" for answer in goal_answers(solution.trace, solution.number)]
    lines.append("  Judged after running the text:")
    lines += _finding_lines(solution.verdict)
    lines += ["  Judged after its first execution, in the world as it really is:", *_finding_lines(execution.verdict)] if execution else []
    lines += [f"  Seen by the camera, {line}" for line in seen_lines(execution.checks)] if execution and execution.checks else []
    return "\n".join([*lines, f"  Files: {folder}"])


def seen_lines(checks: PictureChecks) -> list[str]:
    """Return what the pictures of an execution tell, as lines: each thing that was noticed, and whether the goal looks reached."""
    noticed = [f"{'after ' + n.step if n.step else 'at rest'}: {n.reason}" for n in checks.notices]
    return [*noticed, f"at rest: {checks}"]


def _finding_lines(verdict: Verdict) -> list[str]:
    lines = [f"    {'--' if f.advice else 'ok' if f.passed else 'NO'}  {f.validator}: {f.reason}" for f in verdict.findings]
    return lines + ([f"    --  {verdict.not_judged}"] if verdict.left_out else [])


def first_execution_failed(solution: Solution, run: Path, scenario: Scenario) -> str:
    """Return the reason why a proven program failed in the real world, and the next step."""
    assert solution.execution is not None
    text = run / f"program{solution.candidate.written.suffix}"
    verdict = solution.execution.verdict
    first, *others = [f"{f.validator}: {f.reason}" for f in verdict.objections] or [verdict.reason]
    more = f" (and {len(others)} more, listed above)" if others else ""
    again = f"'cramlite execute {text} --world {run} --replan {scenario.path}' takes a camera picture after the stop, and plans the rest"
    blind = "what is believed of the world is not true of it: measure it again, or let a camera look ('poses: camera')"
    return (
        f"The program was proven in the believed world, but its first execution failed: {first}{more}.\n"
        f"  Next: {again if scenario.spec.poses == 'camera' else blind}.\n  Files: {run / 'execution'}"
    )


def findings_text(verdict: Verdict, remarks: Iterable[str]) -> str:
    """Format a verdict about a program: whether it passed, and what each validator found."""
    lines = [f"    --  {r}" for r in remarks]
    outcome = "Refused" if not verdict.passed else "Passed, with advice" if verdict.advice else "Passed"
    return "\n".join([f"{outcome}:", *_finding_lines(verdict), *lines])


def warn_of(faults: Iterable[object]) -> None:
    """Print each fault of a plugin that did not end the command, once, as a warning on standard error."""
    for fault in dict.fromkeys(str(f) for f in faults):
        print(f"cramlite: warning: {fault}", file=sys.stderr)


def repairs_json(repairs: Iterable[Repair]) -> list[dict[str, Any]]:
    """Return the repairs of an episode as JSON values."""
    return [{"start": r.when[0], "end": r.when[1], "what": r.what, "why": r.why} for r in repairs]


def _label(action: Interpreted) -> str:
    """Format an action's label and object, and whether the label was recorded or inferred from motion; ""
    without a label."""
    event = action.segments[0].event if action.segments else None
    if event is None or event.type == ACTION:
        return ""
    whom = event.roles.get("object", "")
    source = "inferred from motion" if event.inferred else "so named in the recording"
    return f"  {action.label or event.type}{f' of {whom}' if whom else ''}, {source}"


def _repair_lines(repairs: Sequence[Repair], zero: float, most: int = 20) -> list[str]:
    """Format the repairs of a recording as lines; of many with one reason only the first, and how many more
    there are."""
    groups: dict[str, list[Repair]] = {}
    for r in repairs:
        groups.setdefault(r.why, []).append(r)
    shown = [r for of_one in groups.values() for r in of_one[: most if len(of_one) <= ALIKE else 1]]
    lines = []
    for r in shown[:most]:
        others = len(groups[r.why]) - 1 if len(groups[r.why]) > ALIKE else 0
        start, end = (max(t - zero, 0.0) for t in r.when)
        lines.append(f"  repaired  {start:7.2f} to {end:7.2f} s  {r.what}: {r.why}" + (f"; {others} more like it" if others else ""))
    left = len(shown) - most
    return lines + ([f"  repaired  {left} more; --json lists them all"] if left > 0 else [])


ALIKE = 3
"""Largest number of repairs with the same reason that are listed one by one; of more repairs, only the first is listed."""
SHOWN = 3
"""Number of candidate task sequences that are shown with the terms of their description length."""


def interpretation_text(found: Interpretation, repairs: Iterable[Repair] = ()) -> str:
    """Format an interpretation: repairs of the recording, each action with its possible tasks, and the best
    candidate sequences."""
    lines = [f"{found.episode}: {counted(len(found.actions), 'action')}, {counted(found.count(), 'reading')}"]
    zero = found.zero
    if zero:
        lines.append(f"  times count from {datetime.fromtimestamp(zero, UTC):%Y-%m-%d %H:%M:%S} UTC, {zero:.3f} s of Unix time")
    lines += _repair_lines(list(repairs), zero)
    for k, action in enumerate(found.actions):
        lines.append(f"  {k}  {action.start - zero:7.2f} to {action.end - zero:7.2f} s{_label(action)}")
        lines += [f"       {_match(m)}" for m in action.matches]
        if action.unexplained:
            lines.append(
                f"       no task explains it; 'cramlite interpret EPISODE --why TASK@{k}' says what is missing"
            )
    return "\n".join(lines + _candidates(found))


def _match(match: Match) -> str:
    roles = ", ".join(f"{r}={e}" for r, e in match.roles.items())
    unknown = f" (not known: {'; '.join(match.unknown)})" if match.unknown else ""
    return f"{match.task}({roles}): {match.explanation}{unknown}"


def _candidates(found: Interpretation) -> list[str]:
    lines = []
    for k, sequence in enumerate(islice(found.sequences(), SHOWN), 1):
        lines.append(f"  {'best' if k == 1 else f'no. {k}'}: {sequence.reason}")
        explained = [n for n, action in enumerate(found.actions) if not action.unexplained]
        lines += [f"       {explained[n]}  {m.task}: {m.explanation}" for n, m in zip(sequence.actions, sequence.matches, strict=True)]
    return lines


def rollout_json(rollout: Rollout) -> dict[str, Any]:
    """Return the end of a run as JSON values: seconds, newtons, last poses (position [m], quaternion w first)."""
    names = [t.name for t in rollout.world.things]
    forces = rollout.contact_force()
    return {
        "outcome": rollout.outcome,
        "reason": rollout.reason,
        "seconds": float(rollout.times[-1]),
        "peak_force": float(forces.max()) if len(forces) else 0.0,
        "messages": [asdict(m) for m in rollout.messages],
        "faults": [asdict(m) for m in rollout.faults],
        "poses": {n: [float(v) for v in rollout.poses[n][-1]] for n in names if n in rollout.poses},
    }


def rollout_text(rollout: Rollout) -> str:
    """Format a run as text: messages and faults with their times, how it ended, peak force, last poses of things."""
    said = sorted([*rollout.messages, *(replace(f, text=f"fault: {f.text}") for f in rollout.faults)], key=lambda m: m.time)
    lines = [f"{m.time:8.2f} s  {m.text}" for m in said]
    data = rollout_json(rollout)
    lines.append(f"{data['seconds']:8.2f} s  {rollout.outcome}; peak force {data['peak_force']:.1f} N")
    for name, pose in data["poses"].items():
        lines.append(f"            {name} at {', '.join(f'{v:.3f}' for v in pose[:3])} m")
    return "\n".join(lines)


def tasks_text(tasks: Iterable[TaskType]) -> str:
    """Return the task types as text."""
    lines = []
    for task in sorted(tasks, key=lambda t: t.task):
        roles = ", ".join(" or ".join((r.name, *r.aliases)) + ("" if r.required else "?") for r in task.roles)
        names = f"  also {', '.join(task.aliases)}" if task.aliases else ""
        lines.append(f"{task.task}({roles}): {task.summary}{names}")
    return "\n".join(lines)


def tasks_json(tasks: Iterable[TaskType]) -> list[dict[str, Any]]:
    """Return the task types as JSON values."""
    return [
        {
            "task": t.task, "aliases": list(t.aliases), "summary": t.summary,
            "roles": [asdict(r) for r in t.roles], "parameters": [asdict(p) for p in t.parameters],
        }
        for t in sorted(tasks, key=lambda t: t.task)
    ]  # fmt: skip


def plugins_text(registry: Registry, *, every: bool = True) -> str:
    """Return each plugin with its origin, loading time, hooks and faults, as text.

    Args:
        every: also shipped plugins that nothing is wrong with; else their names by folder.
    """
    from ..plugin.entry_points import OWN_DISTRIBUTION

    shipped = [i for i in registry.infos if i.distribution == OWN_DISTRIBUTION and not i.fault and not _later(registry, i)]
    lines = []
    for info in registry.infos:
        if info in shipped and not every:
            continue
        lines.append(
            f"{info.name} ({info.distribution} {info.version}) {info.load_ms:.1f} ms: {', '.join(info.hooks) or 'no hooks'}"
        )
        lines.append(f"    {info.file}")
        if info.fault:
            lines.append(f"    NOT LOADED: {info.fault}")
        lines += [f"    FAULT in {f.hook}: {f.error}" for f in _later(registry, info)]
    return "\n".join(lines if every else [*lines, *_shipped(shipped)])


def _shipped(infos: Sequence[PluginInfo]) -> Iterable[str]:
    """Number of the shipped plugins, and their names by folder."""
    if infos:
        took = sum(i.load_ms for i in infos)
        yield f"{len(infos)} plugins of cramlite {infos[0].version}, loaded in {took:.0f} ms; --all says more of each:"
    rooms: dict[str, list[str]] = {}
    for info in infos:
        rooms.setdefault(Path(info.file).parent.name, []).append(info.name)
    for room, names in sorted(rooms.items()):
        yield textwrap.fill(f"{room}: {', '.join(sorted(names))}", 110, initial_indent="  ", subsequent_indent="      ")


def plugins_json(registry: Registry) -> list[dict[str, Any]]:
    """Return each plugin with its origin, loading time, hooks and faults, as JSON values."""
    return [asdict(i) | {"faults": [f"{f.hook}: {f.error}" for f in _later(registry, i)]} for i in registry.infos]


def _later(registry: Registry, info: PluginInfo) -> list[Fault]:
    """The faults of a plugin that was loaded."""
    return [] if info.fault else [f for f in registry.faults if f.plugin == info.name and f.hook != "import"]
