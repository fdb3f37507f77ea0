"""Helpers of report sections: templates, a colour for each task, and when each task ran."""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from cramlite.model import Value
from cramlite.plugin import html_template

from .links import target

if TYPE_CHECKING:
    from cramlite import Solution
    from cramlite.model import Floats

COLOURS = 8
"""Task colours of the page: the classes t1 to t8, t0 for what belongs to no task."""


class Span(Value):
    """Time span of a task under execution: [start, end) in seconds."""

    task: str
    start: float
    end: float


def fill(name: str, **values: Any) -> str:
    """Render one of this package's templates with values; every value is escaped."""
    text = (files(__package__) / "templates" / f"{name}.html.j2").read_text("utf-8")
    return html_template(text).render(colour=colour, anchor=anchor, target=target, short=short, words=words, **values)


def script(name: str) -> Any:
    """Return one of this package's scripts as markup; nothing in it is escaped, as it comes with the package."""
    from markupsafe import Markup

    return Markup((files(__package__) / "templates" / f"{name}.js").read_text("utf-8"))


def colour(designator: str) -> str:
    """Return the CSS class of a designator's task ("3.Grasping/approach"), by the task's number."""
    number = re.match(r"(\d+)\.", designator)
    return f"t{(int(number[1]) - 1) % COLOURS + 1}" if number else "t0"


def anchor(designator: str) -> str:
    """Return an HTML id by which links reach a designator's entry; special characters of the name are encoded."""
    return "d-" + re.sub(r"[^A-Za-z0-9]+", lambda m: "_" + m[0].encode().hex() + "_", designator)


def short(curie: str) -> str:
    """Return the local name of an ontology's class: "Grasping" of "soma:Grasping"."""
    return curie.split(":")[-1]


def words(curie: str) -> list[str]:
    """Split a class's local name into its words, where a narrow column may break it."""
    return re.findall(r"[A-Z]?[^A-Z]+|[A-Z]", short(curie))


def spans(solution: Solution) -> list[Span]:
    """Return the time spans of the program's tasks, from the program line that ran at each sample of the run.

    Helper functions belong to their caller.
    """
    candidate = solution.candidate
    if candidate.rollout is None or candidate.code is None:
        return []
    times, tasks, task = candidate.rollout.times, [], ""
    for line in candidate.rollout.lines:
        task = candidate.code.task_of(int(line)) or (task if line else "")
        tasks.append(task)
    return _runs(times, tasks)


def _runs(times: Floats, names: Sequence[str]) -> list[Span]:
    found: list[Span] = []
    starts = [k for k, name in enumerate(names) if k == 0 or names[k - 1] != name]
    for k, start in enumerate(starts):
        end = starts[k + 1] if k + 1 < len(starts) else len(names) - 1
        if names[start]:
            found.append(Span(names[start], float(times[start]), float(times[end])))
    return found
