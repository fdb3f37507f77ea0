"""Summary in words: the plan and its objects; or the nearest miss of the search."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite import how_it_ended, nearest_miss, what_to_try
from cramlite.plugin import ReportSection, hookimpl

from .decisions import attempts, path
from .moment import moment
from .readings import number_of
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished, Solution
    from cramlite.model import Rollout, World


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("Summary", 10, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's summary as HTML."""
    solution = done.shown
    chosen = next((path(a) for a in attempts(done.trace) if a.number == number_of(done)), {})
    rollout = solution.candidate.rollout if solution is not None else None
    return fill(
        "summary",
        done=done,
        solution=solution,
        chosen=chosen,
        substitutes=_substitutes(solution) if solution is not None else (),
        duration=_ran(rollout) if rollout is not None else None,
        ran=sum(e.kind == "proof" for e in done.trace.entries),
        tried=len({e.candidate for e in done.trace.entries}),
        ended=how_it_ended(done.trace.entries),
        doubts=_doubts(done.setting.world),
        miss=None if done.proven else nearest_miss(done.trace.entries),
        tries=() if done.proven else what_to_try(done.trace.entries),
        moment=None if done.proven or not done.drawn else moment(done),
    )


def _doubts(world: World) -> list[str]:
    """Notes on what was changed or guessed about the robot and the things of a world."""
    return [*world.notes, *(f"thing '{t.name}': {note}" for t in world.things for note in t.notes)]


def _substitutes(solution: Solution) -> frozenset[str]:
    """Names of the plan's objects for which a thing of another class than asked was taken."""
    bindings, belief, classes = solution.candidate.bindings, solution.candidate.belief, solution.candidate.taxonomy
    found = set()
    for asked in (o for o in solution.plan.objects if o.types and not o.entity and o.name in bindings):
        taken = str(bindings[asked.name])
        own = (belief.feature(taken) or belief.thing(taken)).type
        if not any(classes.is_a(own, t) for t in asked.types):
            found.add(asked.name)
    return frozenset(found)


def _ran(rollout: Rollout) -> float | None:
    """Time until the last line of the program ran [s], as validators state it; the recording goes on while
    things settle."""
    running = [time for time, line in zip(rollout.times, rollout.lines, strict=True) if line]
    return float(running[-1]) if running else None
