"""Timeline of the demonstration: states by kind and pair, and actions with the task chosen for each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite.model import Value
from cramlite.plugin import ReportSection, hookimpl

from .readings import chosen_sequence, pair_up
from .shared import fill, short

if TYPE_CHECKING:
    from cramlite import Finished
    from cramlite.model import Episode, Event
    from cramlite.plugin import Interpreted


class Bar(Value):
    """Timeline bar: left edge and width in percent of the demonstration, and words."""

    left: float
    width: float
    label: str
    text: str
    colour: str = "t0"


class Row(Value):
    """Timeline row: all that happened of one kind to one pair of things."""

    kind: str
    about: str
    bars: tuple[Bar, ...]


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The demonstration", 30, render, refused=True)


def render(done: Finished) -> str:
    """Render the section as HTML."""
    episode = done.episode
    if episode is None:
        return ""
    begin, end = episode.span
    rows = _state_rows(episode, begin, end)
    marks = [(f"{begin + k * (end - begin) / 4:.1f} s", 25 * k) for k in range(5)]
    return fill(
        "demonstration",
        episode=episode,
        rows=rows,
        actions=_actions(done, begin, end),
        marks=marks,
        begin=begin,
        end=end,
    )


def _state_rows(episode: Episode, begin: float, end: float) -> list[Row]:
    rows: dict[tuple[str, str], list[Event]] = {}
    for event in episode.events:
        if event.kind != "action":
            rows.setdefault((short(event.type), " · ".join(event.roles.values())), []).append(event)
    return [
        Row(kind, about, tuple(_bar(e, begin, end) for e in events)) for (kind, about), events in sorted(rows.items())
    ]


def _bar(event: Event, begin: float, end: float) -> Bar:
    left, width = _place(event.start, event.end, begin, end)
    roles = ", ".join(f"{k} {v}" for k, v in event.roles.items())
    text = f"{short(event.type)} ({roles}), {event.start:.2f} to {event.end:.2f} s" + (
        ", inferred from motion" if event.inferred else ""
    )
    return Bar(left, width, "", text)


def _actions(done: Finished, begin: float, end: float) -> list[Bar]:
    found = done.interpretation
    if found is None:
        return []
    pairs = pair_up(found, chosen_sequence(done))
    bars, number = [], 0
    for action, match in pairs:
        number += match is not None
        label = short(match.task) if match else "unexplained" if action.unexplained else "left out"
        text = match.explanation if match else "no task explains it" if action.unexplained else "nothing changed in it"
        left, width = _place(action.start, action.end, begin, end)
        colour = f"t{(number - 1) % 8 + 1}" if match else "t0"
        bars.append(Bar(left, width, label, f"{_when(action)}: {label}, {text}", colour))
    return bars


def _when(action: Interpreted) -> str:
    return f"{action.start:.2f} to {action.end:.2f} s"


def _place(start: float, stop: float, begin: float, end: float) -> tuple[float, float]:
    scale = 100 / max(end - begin, 1e-9)
    return (start - begin) * scale, max((stop - start) * scale, 0.3)
