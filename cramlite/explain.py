"""The only printer: values become text for people, or JSON for machines."""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import asdict

from .budget import STOPPED
from .trace import Entry, Trace

if TYPE_CHECKING:
    from .episode import Repair
    from .interpretation import Interpretation, Interpreted
    from .registry import Fault, PluginInfo, Registry
    from .rollout import Rollout
    from .solution import Solution
    from .tasks import TaskType


def as_json(value: Any) -> str:
    """Indented JSON of plain data, structs and arrays; null for numbers that JSON has not: infinite ones, and NaN."""
    return _json(value, 1)


def plain_json(value: Any) -> str:
    """The same on one line."""
    return _json(value, None)


def _json(value: Any, indent: int | None) -> str:
    try:
        return json.dumps(value, indent=indent, default=_plain, allow_nan=False)
    except ValueError:  # rare, so that only then everything is looked at
        return json.dumps(_finite(value), indent=indent)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return value if value is None or isinstance(value, bool | int | str) else _finite(_plain(value))


def _plain(value: Any) -> Any:
    if isinstance(value, Struct):
        return asdict(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    return str(value)


def solution_text(solution: Solution, folder: str) -> str:
    """A short summary of a proven program."""
    program, plan = solution.program, solution.plan
    lines = [
        f"Solved: {plan}",
        f"  from candidate sequence {solution.number}, {len(program.steps)} steps, {solution.code.count(chr(10))} lines",
    ]
    chosen = {e.designator: e for e in solution.trace.entries if e.outcome == "chosen"}
    for designator in plan.objects:
        entry = chosen.get(designator.name)
        found = f"{entry.text}: {entry.reason}" if entry else "?"
        lines.append(f"  {designator.name} ({', '.join(designator.types) or 'by name'}) = {found}")
    lines.append("  Judged after running the text:")
    lines += [f"    {'ok' if f.passed else 'NO'}  {f.validator}: {f.reason}" for f in solution.verdict.findings]
    lines += [f"    --  {solution.verdict.not_judged}"] if solution.verdict.left_out else []
    return "\n".join([*lines, f"  Files: {folder}"])


def failure_text(trace: Trace, faults: Iterable[object]) -> str:
    """Why nothing was found: the nearest miss of all, and the one of each candidate."""
    lines = [f"No solution: {how_it_ended(trace.entries)}."]
    lines += [f"  Fault: {f}" for f in dict.fromkeys(str(f) for f in faults)]
    nearest = nearest_miss(trace.entries)
    if nearest is not None:
        lines.append(f"  Nearest miss: {_miss(nearest)}")
    for number in dict.fromkeys(e.candidate for e in trace.entries):
        miss = nearest_miss([e for e in trace.entries if e.candidate == number])
        if miss is not None and miss is not nearest:
            lines.append(f"  Also {_miss(miss)}")
    return "\n".join(lines)


def how_it_ended(entries: Sequence[Entry]) -> str:
    """Whether all alternatives were refused, or what ended the search before, and how to raise it."""
    capped = [e for e in entries if e.outcome == "capped"]
    if any(e.reason == STOPPED for e in capped):
        return f"the search was {STOPPED} before every alternative was tried"
    spent = list(dict.fromkeys(e.text for e in capped if e.designator == "budget"))
    if spent:
        more = ", ".join(f"{s.split()[0]}: {2 * int(s.split()[-1])}" for s in spent)
        return (
            f"the search was cut short by its budget {' and '.join(spent)}, other alternatives may do; "
            f"raise it with 'budget: {{{more}}}' in the scenario, or Budget({more.replace(': ', '=')}) in Python"
        )
    if capped:
        return "every alternative that was tried was refused; limits left others out, marked '!' in the trace"
    return "every alternative was refused"


def _miss(entry: Entry) -> str:
    return f"candidate {entry.candidate}, {entry.designator}: {entry.reason} [{entry.plugin}]"


def nearest_miss(entries: Sequence[Entry]) -> Entry | None:
    """The refusal that came after the most choices; a program whose text ran comes nearer than any."""
    known = {e.number: e for e in entries}
    reasons = [
        e
        for e in entries
        if e.outcome in ("refused", "impossible") or (e.designator == "proof" and e.outcome == "failed")
    ]
    return max(
        reasons,
        key=lambda e: (e.designator == "proof", _depth(known, e), e.outcome == "impossible", e.passed, -e.number),
        default=None,
    )


def _depth(entries: Mapping[int, Entry], entry: Entry) -> int:
    depth = 0
    while entry.parent in entries:
        entry, depth = entries[entry.parent], depth + 1
    return depth


def repairs_json(repairs: Iterable[Repair]) -> list[dict[str, Any]]:
    return [{"start": r.when[0], "end": r.when[1], "what": r.what, "why": r.why} for r in repairs]


def _label(action: Interpreted) -> str:
    """What the recording itself calls the action, or what was concluded from motion."""
    event = action.segments[0].event if action.segments else None
    if event is None or event.type == "soma:PhysicalAction":
        return ""
    whom = event.roles.get("object", "")
    source = "inferred from motion" if event.inferred else "so named in the recording"
    return f"  {action.label or event.type}{f' of {whom}' if whom else ''}, {source}"


def _repair_lines(repairs: Sequence[Repair], most: int = 20) -> list[str]:
    """A line for each; a flickering log has hundreds, so only the first are shown."""
    lines = [f"  repaired  {r.when[0]:7.2f} to {r.when[1]:7.2f} s  {r.what}: {r.why}" for r in repairs[:most]]
    more = [f"  repaired  {len(repairs) - most} more; --json lists them all"]
    return lines + (more if len(repairs) > most else [])


def interpretation_text(found: Interpretation, repairs: Iterable[Repair] = ()) -> str:
    """Every action with the tasks it may execute; first what was repaired before."""
    lines = [f"{found.episode}: {len(found.actions)} actions, {found.count()} candidate task sequences"]
    lines += _repair_lines(list(repairs))
    for k, action in enumerate(found.actions):
        lines.append(f"  {k}  {action.start:7.2f} to {action.end:7.2f} s{_label(action)}")
        lines += [
            f"       {m.task}({', '.join(f'{r}={e}' for r, e in m.roles.items())}): {m.explanation}"
            for m in action.matches
        ]
        if action.hole:
            lines.append(
                f"       no task explains it; 'cramlite interpret EPISODE --why TASK@{k}' says what is missing"
            )
    return "\n".join(lines)


def rollout_json(rollout: Rollout) -> dict[str, Any]:
    """How the run of a program ended: seconds, newtons, and the last pose of every thing (position, quaternion w first)."""
    names = [t.name for t in rollout.world.things]
    forces = rollout.contact_force()
    return {
        "outcome": rollout.outcome,
        "reason": rollout.reason,
        "seconds": float(rollout.times[-1]),
        "peak_force": float(forces.max()) if len(forces) else 0.0,
        "messages": [asdict(m) for m in rollout.messages],
        "poses": {n: [float(v) for v in rollout.poses[n][-1]] for n in names if n in rollout.poses},
    }


def rollout_text(rollout: Rollout) -> str:
    """The program's own log, and how it ended."""
    lines = [f"{m.time:8.2f} s  {m.text}" for m in rollout.messages]
    data = rollout_json(rollout)
    lines.append(f"{data['seconds']:8.2f} s  {rollout.outcome}; peak force {data['peak_force']:.1f} N")
    for name, pose in data["poses"].items():
        lines.append(f"            {name} at {', '.join(f'{v:.3f}' for v in pose[:3])} m")
    return "\n".join(lines)


def tasks_text(tasks: Iterable[TaskType]) -> str:
    lines = []
    for task in sorted(tasks, key=lambda t: t.task):
        roles = ", ".join(r.name + ("" if r.required else "?") for r in task.roles)
        names = f"  also {', '.join(task.aliases)}" if task.aliases else ""
        lines.append(f"{task.task}({roles}): {task.summary}{names}")
    return "\n".join(lines)


def tasks_json(tasks: Iterable[TaskType]) -> list[dict[str, Any]]:
    return [
        {
            "task": t.task, "aliases": list(t.aliases), "summary": t.summary,
            "roles": [asdict(r) for r in t.roles], "parameters": [asdict(p) for p in t.parameters],
        }
        for t in sorted(tasks, key=lambda t: t.task)
    ]  # fmt: skip


def plugins_text(registry: Registry, *, every: bool = True) -> str:
    """Each plugin with where it comes from, how long it took to load, its hooks, and what is wrong with it.

    Args:
        every: also shipped plugins that nothing is wrong with; else their names by folder.
    """
    from .entry_points import OWN_DISTRIBUTION

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
    """How many, and their names by the folder that they are in."""
    if infos:
        took = sum(i.load_ms for i in infos)
        yield f"{len(infos)} plugins of cramlite {infos[0].version}, loaded in {took:.0f} ms; --all says more of each:"
    rooms: dict[str, list[str]] = {}
    for info in infos:
        rooms.setdefault(Path(info.file).parent.name, []).append(info.name)
    for room, names in sorted(rooms.items()):
        yield textwrap.fill(f"{room}: {', '.join(sorted(names))}", 110, initial_indent="  ", subsequent_indent="      ")


def plugins_json(registry: Registry) -> list[dict[str, Any]]:
    """The same for programs."""
    return [asdict(i) | {"faults": [f"{f.hook}: {f.error}" for f in _later(registry, i)]} for i in registry.infos]


def _later(registry: Registry, info: PluginInfo) -> list[Fault]:
    """The faults of a plugin that was loaded."""
    return [] if info.fault else [f for f in registry.faults if f.plugin == info.name and f.hook != "import"]
