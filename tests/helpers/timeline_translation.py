"""A loaded timeline as facts of SWI-Prolog: states with intervals, classes, and what was measured, unjudged.

The phases and predicates are rules there (timeline.pl), so Prolog does all that our matcher and predicates do, but
for the extremes of signals between two samples, which it is given.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from cramlite.model import Floats, Track
from cramlite.ontology.taxonomy import Restriction
from cramlite.plugin import PADDING, Phase, Rule, Segment, Timeline
from cramlite_plugins.predicates.phase_poses import box_of, things, tips
from cramlite_plugins.predicates.relations import _dof
from helpers.rule_translations import atoms, clingo_facts, clingo_program, facts_of, prolog_goal, term

PREDICATES = Path(__file__).parents[1] / "benchmarks" / "timeline.pl"
VARIANTS = {
    "as stated": (
        ":- table subclass/2.",
        "candidate(T, _, _, Id, From, To) :- state(T, Id, From, To).",
    ),
    "tabled": (
        ":- table subclass/2, instance/2, is_thing/1, state_class/2, spanning_states/3, gap/4.",
        "candidate(T, _, _, Id, From, To) :- state(T, Id, From, To).",
    ),
    "tabled and indexed by time": (
        ":- table subclass/2, instance/2, is_thing/1, state_class/2, spanning_states/3, gap/4.",
        "candidate(T, S, E, Id, From, To) :- B is floor(S), C is floor(E), "
        "( B =:= C -> second(T, B, Id, From, To) ; distinct(Id, ( between(B, C, K), second(T, K, Id, From, To) )) ).",
    ),
}
"""Variants of the Prolog program by what is tabled and how states are found: tables only where the program would not end without; the
usual tables; and these with an index of states by second."""
_FACTS = (
    "action/4, labelled/4, padding/1, state/4, state_type/1, second/5, role/3, entity/1, type/2, part_of/2, effector/1, located/2, sub/2, "
    "restriction/3, dof/2, fixed/2, pose/3, box/3, measured/5, opening/4, spread/3, tip/2, joint/7, from_park/3"
)


def timeline_facts(timeline: Timeline, segments: Sequence[Segment]) -> Iterator[str]:
    """Yield the facts of a timeline for SWI-Prolog, in no particular order."""
    yield from _of_classes(timeline)
    yield from _of_things(timeline)
    yield f"padding({PADDING})."
    for number, (phases, segment) in enumerate(zip(map(timeline.phases, segments), segments, strict=True)):
        kind = "anonymous" if segment.event is None else "labelled"
        yield f"action({number}, {segment.start!r}, {segment.end!r}, {kind})."
        for phase in phases.values():
            yield from _of_phase(phase)
    for event in timeline.labelled:
        type_ = timeline.taxonomy.resolve(event.type) or event.type
        yield f"labelled({event.start!r}, {event.end!r}, '{type_}', '{event.roles.get('object', '')}')."
    yield from _of_states(timeline)


def _of_states(timeline: Timeline) -> Iterator[str]:
    first, last = timeline.cuts[0], timeline.cuts[-1]
    for k, event in enumerate(e for e in timeline.episode.events if e.kind == "state" and e.end > e.start):
        type_ = timeline.taxonomy.resolve(event.type) or event.type
        end = event.end if event.end < last else 1e300
        yield f"state_type('{type_}')."
        yield f"state('{type_}', {k}, {event.start!r}, {end!r})."
        yield from (f"role({k}, {role}, '{thing}')." for role, thing in event.roles.items())
        for second in range(int(min(first, event.start) // 1), int((last + PADDING) // 1) + 1):
            if second + 1 > event.start and second <= end:
                yield f"second('{type_}', {second}, {k}, {event.start!r}, {end!r})."


def _of_classes(timeline: Timeline) -> Iterator[str]:
    for class_, parents in timeline.taxonomy.parents.items():
        yield from (f"sub('{class_}', '{parent}')." for parent in parents if parent != class_)
    for class_, restrictions in timeline.taxonomy.restrictions.items():
        yield from (f"restriction('{class_}', '{r.property}', {_filler(r)})." for r in restrictions)


def _filler(restriction: Restriction) -> str:
    return f"'{restriction.filler}'" if isinstance(restriction.filler, str) else repr(restriction.filler)


def _of_things(timeline: Timeline) -> Iterator[str]:
    phase = timeline.instant(timeline.cuts[0])
    if timeline.episode.effector is not None:
        yield f"effector('{timeline.episode.effector}')."
    yield from (f"tip({k}, '{name}')." for k, name in enumerate(tips(timeline), 1))
    yield from (f"located('{name}', {max(since, -1e300)!r})." for name, since in timeline.located.items())
    for name, entity in timeline.entities.items():
        yield f"entity('{name}')."
        yield from (f"type('{name}', '{type_}')." for type_ in timeline.types(name))
        if entity.part_of is not None:
            yield f"part_of('{name}', '{entity.part_of}')."
        if "constrained_dof" in entity.properties:
            yield f"dof('{name}', {entity.properties['constrained_dof']!r})."
        corners = box_of(phase, name)
        if corners is not None:
            yield f"box('{name}', b{corners[0]}, b{corners[1]})."
        if not _moving(timeline, name) and (pose := timeline.episode.pose_at(name, timeline.cuts[0])) is not None:
            yield f"fixed('{name}', p{(*map(float, pose.position), *map(float, pose.quaternion))})."


def _moving(timeline: Timeline, name: str) -> bool:
    return any(whole in timeline.episode.tracks for whole in timeline.wholes[name])


def _of_phase(phase: Phase) -> Iterator[str]:
    """Yield the facts of a phase: poses at its ends, and extremes of signals within it, from the samples themselves."""
    timeline, at = phase.timeline, f"{phase.start!r}, {phase.end!r}"
    for name in timeline.entities:
        if phase.start == phase.end and _moving(timeline, name):
            pose = timeline.episode.pose_at(name, phase.end)
            if pose is not None:
                yield f"pose({phase.end!r}, '{name}', p{(*map(float, pose.position), *map(float, pose.quaternion))})."
        track = timeline.episode.tracks.get(name)
        if phase.start < phase.end and track is not None and len(track.times):
            yield from (f"measured({at}, {q}, '{name}', {v!r})." for q, v in _extremes(track, phase))
    extras = timeline.episode.extras
    if "opening" in extras and len(extras["opening"]):
        values = _within(extras["times"], extras["opening"], phase)
        hand = timeline.entities[timeline.episode.effector or ""]
        widest = hand.properties.get("max_opening") or float(extras["opening"].max())
        low, high = float(values.min()), float(values.max())
        yield f"opening({at}, {low / widest!r}, {high / widest!r})."
        yield f"spread({at}, {high - low!r})."


def _extremes(track: Track, phase: Phase) -> Iterator[tuple[str, float]]:
    rows = _within(track.times, track.poses, phase)
    yield "excursion", float(np.linalg.norm(rows[:, :3] - rows[0, :3], axis=1).max())
    yield "turn", float(2 * np.arccos(min(1.0, np.abs(rows[:, 3:] @ rows[0, 3:]).min())))
    w, x, y, z = rows[:, 3:].T
    up = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    yield "upright", float((track.at(float(track.times[0])).rotation[:, 2] @ up).min())


def _within(times: Floats, values: Floats, phase: Phase) -> Floats:
    first = max(int(np.searchsorted(times, phase.start, side="right")) - 1, 0)
    return values[first : max(int(np.searchsorted(times, phase.end, side="left")), first + 1)]


def timeline_program(rules: Iterable[Rule], variant: str) -> Iterator[str]:
    """Yield a Prolog program of clauses match(Action, Task, [Role, ...]) over the predicates of timeline.pl."""
    yield f":- dynamic {_FACTS}."
    yield from VARIANTS[variant]
    yield PREDICATES.read_text()
    for rule in rules:
        body = [prolog_goal(c.condition, c.phase.capitalize(), "") for c in rule.quick_order]
        phases = [f"phase({name}, A, {name.capitalize()})" for name in dict.fromkeys(c.phase for c in rule.clauses)]
        goals = ", ".join(["action(A, _, _, _)", *phases, *body])
        yield f"match(A, '{rule.task}', [{', '.join(rule.roles)}]) :- {goals}."


def by_prolog(program: Iterable[str], facts: Iterable[str], rounds: int = 1) -> tuple[float, set[tuple[object, ...]]]:
    """Find all matches by SWI-Prolog; return the CPU seconds of the fastest of some rounds, tables emptied before each, and the matches.
    Loading is not counted, and a round before lets just-in-time indices exist."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "episode.pl"
        path.write_text("\n".join([*program, *sorted(set(facts))]))
        goal = (
            "findall(x, match(_,_,_), _), findall(S, (between(1, ROUNDS, _), abolish_all_tables, "
            "statistics(cputime, B), findall(x, match(_,_,_), _), statistics(cputime, E), S is E - B), Ss), "
            "min_list(Ss, Least), writeln(Least), findall(m(A,T,R), match(A,T,R), L), sort(L, U), "
            "forall(member(m(A,T,R), U), (atomic_list_concat([A,T|R], ' ', W), writeln(W))), halt"
        ).replace("ROUNDS", str(rounds))
        done = subprocess.run(["swipl", "-q", "-g", goal, str(path)], capture_output=True, text=True, check=True)
    first, *rows = done.stdout.splitlines()
    return float(first), {(int(k), *others) for k, *others in (row.split() for row in rows)}


def clingo_timeline(rules: Sequence[Rule], timeline: Timeline, segments: Sequence[Segment]) -> Iterator[str]:
    """Yield rules and facts for clingo: states, classes and parts as recorded; measured relations as cramlite's predicates judge them,
    since clingo has no real numbers."""
    yield from clingo_program(rules, ("A",))
    yield PREDICATES.with_suffix(".lp").read_text()
    names = list(timeline.entities)
    columns = [timeline.phases(s) for s in segments]
    asked = {a for r in rules for c in r.clauses for a in atoms(c.condition)}
    for name in ("isa", "has"):
        yield from {f'asked("{name}", {term(a.terms[1])}).' for a in asked if a.predicate.name == name}
    states = [e for e in timeline.episode.events if e.kind == "state" and e.end > e.start]
    instants = {t for p in columns for t in (p["run"].start, p["run"].end, p["post"].start)}
    ranks = {t: k for k, t in enumerate(sorted(instants | {t for e in states for t in (e.start, e.end)}))}
    for number, phases in enumerate(columns):
        run = phases["run"]
        yield f"action({number}, {ranks[run.start]}, {ranks[run.end]}, {ranks[phases['post'].start]})."
    for k, event in enumerate(states):
        end = ranks[event.end] if event.end < timeline.cuts[-1] else len(ranks)
        type_ = timeline.taxonomy.resolve(event.type) or event.type
        yield f'state({k}, "{type_}", {ranks[event.start]}, {end}).'
        yield from (f'role({k}, {role}, "{thing}").' for role, thing in event.roles.items())
    yield from _clingo_things(timeline)
    for number, phases in enumerate(columns):
        judged = facts_of(rules, phases, names, lambda p: not (p.steady or p.timeless) or p.name == "pose_known")
        yield from clingo_facts(judged, [], f"{number}, ")


def _clingo_things(timeline: Timeline) -> Iterator[str]:
    phase, taxonomy = timeline.instant(timeline.cuts[0]), timeline.taxonomy
    yield from (f'sub("{c}", "{p}").' for c, parents in taxonomy.parents.items() for p in parents)
    for class_, restrictions in taxonomy.restrictions.items():
        yield from (f'restriction("{class_}", "{r.property}", {term(r.filler)}).' for r in restrictions)
    yield f'effector("{timeline.episode.effector}").'
    yield from (f'object("{name}").' for name in things(phase))
    for name, entity in timeline.entities.items():
        yield f'thing("{name}").'
        yield from (f'type("{name}", "{type_}").' for type_ in timeline.types(name))
        yield f'degrees("{name}", {term(_dof(phase, name))}).'
        if entity.part_of is not None:
            yield f'part_of("{name}", "{entity.part_of}").'


def by_clingo(lines: Iterable[str]) -> tuple[float, set[tuple[object, ...]]]:
    """Find all matches by clingo; return the CPU seconds to ground and solve, without reading, and the matches."""
    import clingo

    control = clingo.Control(["--warn=none"])
    control.add("base", [], "\n".join(lines))
    begin = time.process_time()
    control.ground([("base", [])])
    with control.solve(yield_=True) as handle:
        symbols = next(iter(handle)).symbols(atoms=True)
    seconds = time.process_time() - begin
    found = [s.arguments for s in symbols if s.name.startswith("match")]
    return seconds, {(a[0].number, *(x.string for x in a[1:])) for a in found}


def absent() -> bool:
    """Check whether SWI-Prolog is missing on this computer."""
    return shutil.which("swipl") is None
