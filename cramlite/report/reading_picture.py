"""Picture of how a demonstration was read: states and actions over time, the best two readings, and why the second one lost.

Recordings have hundreds of states. Those that the two readings do not speak of, or that hold from beginning to end, are folded:
the picture says how many they are, and of what.
"""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.resources import files
from itertools import islice
from typing import Any

from ..base.html_template import html_template
from ..base.value import Value
from ..interpretation.interpretation import EPOCH, Interpretation
from ..interpretation.matching import Match
from ..interpretation.ranking import DescriptionLength, TaskSequence
from ..model.entity_name import thing_of
from ..model.episode import Episode, Event
from .spoken_names import SpokenNames, spoken_names

LEFT, WIDTH = 270, 830
"""Width of the names and of the time axis [pixel]; a page is 1100 wide."""
ROW, TALL = 22, 80
"""Height of a lane of states, and of one of a reading [pixel]."""
CHARACTER, LINE = 6.4, 13.5
"""Mean width of a character of 12 pixels, and height of a line [pixel]."""
LANES = 14
"""Largest number of lanes of states: what fits on a screen together with the readings."""
ALWAYS = 0.05
"""Largest distance of the ends of a state from the ends of the recording [s] for which the state counts as holding all the time."""

PHRASES: Mapping[str, tuple[int, str, str, str]] = {
    "GraspState": (0, "In the hand", "{object} in {gripper}", "t3"),
    "ContainmentState": (1, "Inside", "{content} in {container}", "t4"),
    "SupportState": (2, "Standing or lying on", "{supportee} on {supporter}", "t5"),
    "ContactState": (3, "Touching", "{a} and {b}", "t1"),
}
"""Display of a state by the local name of its class: order, heading, phrase and colour."""
TERMS = (
    ("tasks", "naming its tasks", 1),
    ("choices", "which things fill their roles", 1),
    ("unknown", "conditions that could not be judged", 1),
    ("unexplained", "changes that it does not explain", 1),
    ("checked", "conditions that were checked and held", -1),
)
"""Terms of a description length, each with its words and its sign."""


class Block(Value):
    """Rectangle with text in a lane (a row along the time axis) of the picture of readings.

    Left edge and width [pixel], its lines of text or an upright word, the whole text with its time, and CSS
    classes.
    """

    x: float
    width: float
    lines: tuple[str, ...]
    upright: str
    text: str
    colour: str


class Lane(Value):
    """Lane of the picture of readings, a row along the time axis: its name and its blocks.

    The first lane under a heading also has the heading.
    """

    name: str
    blocks: tuple[Block, ...]
    heading: str = ""


class Told(Value):
    """Entry of the picture of readings: one action, or several in a row, and what each reading says that they are.

    Args:
        numbers: of the first and the last.
        start, end: [s].
        explained: whether some task explains one of them.
        says: what each reading says, "" for nothing.
        tasks: the tasks that they name, "" for none.
        lengths: what each reading takes to say it.
    """

    numbers: tuple[int, int]
    start: float
    end: float
    explained: bool
    says: tuple[str, ...]
    tasks: tuple[str, ...]
    lengths: tuple[DescriptionLength, ...]

    @property
    def number(self) -> str:
        """Numbers of the actions of this entry: "3" for a single one, "3–5" for several."""
        first, last = self.numbers
        return str(first) if first == last else f"{first}–{last}"

    @property
    def differs(self) -> bool:
        """Whether the readings of the demonstration disagree about what the actions of this entry are."""
        return len(set(zip(self.says, self.tasks, strict=True))) > 1

    def joined(self, other: Told) -> Told:
        """Return one entry for the actions of this entry and of the one after it, because the readings claim
        the same about both."""
        lengths = tuple(a + b for a, b in zip(self.lengths, other.lengths, strict=True))
        numbers = (self.numbers[0], other.numbers[1])
        return Told(numbers, self.start, other.end, self.explained or other.explained, self.says, self.tasks, lengths)


class Axis(Value):
    """Time axis of a picture, from ``begin`` to ``end`` [s]; written times count from ``zero`` [s]."""

    begin: float
    end: float
    zero: float

    def x(self, time: float) -> float:
        """Return the horizontal position of an instant on the axis [pixel]."""
        share = (time - self.begin) / max(self.end - self.begin, 1e-9)
        return LEFT + WIDTH * min(max(share, 0.0), 1.0)

    def span(self, start: float, end: float) -> tuple[float, float]:
        """Return the left edge and width of a time span on the axis [pixel]; the width is at least 1.5
        pixels."""
        return self.x(start), max(self.x(end) - self.x(start), 1.5)

    def when(self, start: float, end: float) -> str:
        """Format a time span: "1.0 to 2.5 s"."""
        return f"{start - self.zero:.1f} to {end - self.zero:.1f} s"

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Positions and labels of about ten tick marks on the time axis; the marked times are round numbers."""
        wanted = max(self.end - self.begin, 1e-3) / 10
        power = 10.0 ** math.floor(math.log10(wanted))
        step = next(s * power for s in (1, 2, 5, 10) if s * power >= wanted)
        first = math.ceil((self.begin - self.zero) / step - 1e-9)
        last = math.floor((self.end - self.zero) / step + 1e-9)
        return [(self.x(self.zero + k * step), f"{k * step:g}") for k in range(first, last + 1)]


def reading_picture(episode: Episode, found: Interpretation | None, shown: int = 1) -> str:
    """Return the picture with its captions as an HTML fragment that needs no script and no network.

    Args:
        episode: the demonstration.
        found: how it was read; None if it was not.
        shown: number of the reading to be shown, from 1: the best, unless another one became a program.
    """
    sequences = list(islice(found.sequences(), max(shown, 2))) if found is not None else []
    mine = sequences[shown - 1 : shown]
    readings = mine + [s for s in sequences if s not in mine][:1]
    names = spoken_names([*(e.name for e in episode.entities), *(f for e in episode.events for f in e.roles.values())])
    begin, end = episode.span
    axis = Axis(begin, end, found.zero if found is not None else begin if begin > EPOCH else 0.0)
    told = _told(found, readings, names) if found is not None else []
    lanes, folded = _states(episode, readings, names, axis)
    titles = ("Best reading", "Runner-up") if shown == 1 else (f"Reading no. {shown}, which was used", "Best reading")
    text = (files(__package__) / "reading_picture.html.j2").read_text("utf-8")
    return html_template(text).render(
        episode=episode, axis=axis, lanes=lanes, folded=folded, names=_renamed(names, readings), titles=titles, told=told,
        readings=_reading_lanes(told, titles, axis), cuts=_cuts(told, axis), read=bool(readings),
        actions=len(found.actions) if found is not None else 0, actor=names(episode.effector) if episode.effector else "",
        lost=_lost(told, [s.length for s in readings], axis), sizes=(LEFT, WIDTH, ROW, TALL),
    )  # fmt: skip


def _told(found: Interpretation, readings: Sequence[TaskSequence], names: SpokenNames) -> list[Told]:
    """Return what each reading claims about the actions; neighbouring actions with the same claims are
    joined."""
    pairs = [_pairs(found, s) for s in readings]
    steps: list[Told] = []
    for k, action in enumerate(found.actions):
        matches = [p[k][0] for p in pairs]
        step = Told(
            (k, k), action.start, action.end, not action.unexplained, tuple(_sentence(m, names) for m in matches),
            tuple(_local(m.task) if m else "" for m in matches), tuple(p[k][1] for p in pairs),
        )  # fmt: skip
        if steps and (steps[-1].says, steps[-1].tasks) == (step.says, step.tasks):
            steps[-1] = steps[-1].joined(step)
        else:
            steps.append(step)
    return steps


def _pairs(found: Interpretation, sequence: TaskSequence) -> list[tuple[Match | None, DescriptionLength]]:
    """Return for each action the task that a reading assigns to it, and the description length that this adds."""
    explained = [k for k, a in enumerate(found.actions) if not a.unexplained]
    said = dict(zip([explained[k] for k in sequence.actions], sequence.matches, strict=True))
    cost = dict(zip(explained, sequence.lengths, strict=True))
    return [(said.get(k), cost.get(k, DescriptionLength())) for k in range(len(found.actions))]


def _sentence(match: Match | None, names: SpokenNames) -> str:
    return names.text(match.explanation, match.roles.values()) if match is not None else ""


def _cuts(told: Sequence[Told], axis: Axis) -> list[float]:
    return sorted({axis.x(t) for one in told for t in (one.start, one.end)})


def _reading_lanes(told: Sequence[Told], titles: Sequence[str], axis: Axis) -> list[Lane]:
    if not told:
        return []
    lanes = [Lane("Action no.", tuple(_block(axis, t, t.number, "", "cut") for t in told))]
    for k, title in enumerate(titles[: len(told[0].says)]):
        lanes.append(Lane(title, tuple(_said_block(axis, t, k) for t in told)))
    return lanes


def _said_block(axis: Axis, one: Told, reading: int) -> Block:
    said = one.says[reading]
    colour = ("said" if said else "quiet") + (" differs" if one.differs else "")
    return _block(axis, one, said or "–", one.tasks[reading], colour)


def _block(axis: Axis, one: Told, label: str, short: str, colour: str) -> Block:
    x, width = axis.span(one.start, one.end)
    lines = textwrap.wrap(label, max(int((width - 8) / CHARACTER), 1), break_long_words=False)
    fits = len(lines) * LINE < TALL and all(len(line) * CHARACTER < width - 4 for line in lines)
    upright = short if not fits and width > LINE and len(short) * CHARACTER < TALL + 4 else ""
    return Block(x, width, tuple(lines) if fits else (), upright, f"{axis.when(one.start, one.end)}: {label}", colour)


def _states(
    episode: Episode, readings: Sequence[TaskSequence], names: SpokenNames, axis: Axis
) -> tuple[list[Lane], list[tuple[str, int]]]:
    """Return a lane (a row along the time axis) for each state that is about things of the readings.

    With them comes a count of the other states, by class and things.
    """
    spoken_of = {thing_of(f) for s in readings for m in s.matches for f in m.roles.values()} - {episode.effector}
    pairs: dict[tuple[int, str, str, str], list[Event]] = {}
    for event in episode.of("state"):
        order, heading, phrase, colour = PHRASES.get(_local(event.type), (4, _local(event.type), "", "t0"))
        name = _phrase(phrase, event, names)
        pairs.setdefault((order, heading, name, colour), []).append(event)
    mine = [k for k, events in pairs.items() if _matters(events, spoken_of, axis) or not readings]
    kept = sorted(mine, key=lambda k: (k[0], -_spoken_of(pairs[k][0], {*spoken_of, episode.effector}), pairs[k][0].start))[:LANES]
    lanes = []
    for key in kept:
        heading = key[1] if key[1] not in [k[1] for k in kept[: kept.index(key)]] else ""
        lanes.append(Lane(key[2], tuple(_state_block(e, key, axis) for e in pairs[key]), heading))
    folded = Counter({f"{k[1]}: {k[2]}": len(events) for k, events in pairs.items() if k not in kept})
    return lanes, folded.most_common()


def _phrase(phrase: str, event: Event, names: SpokenNames) -> str:
    said = {role: names(f) for role, f in event.roles.items()}
    try:
        return phrase.format(**said) if phrase else ", ".join(said.values())
    except KeyError:  # a state of another writer, with roles of its own
        return ", ".join(said.values())


def _matters(events: Iterable[Event], spoken_of: Collection[str | None], axis: Axis) -> bool:
    """Check whether the picture of the readings shows a row of states: some reading must mention a thing that these states are about.

    It must mention all of them if the states last the whole time.
    """
    listed = list(events)
    about = _spoken_of(listed[0], spoken_of)
    always = all(e.start < axis.begin + ALWAYS and e.end > axis.end - ALWAYS for e in listed)
    return about > 0 and (not always or about == len(listed[0].roles))


def _spoken_of(event: Event, spoken_of: Collection[str | None]) -> int:
    return sum(thing_of(f) in spoken_of for f in event.roles.values())


def _state_block(event: Event, key: tuple[int, str, str, str], axis: Axis) -> Block:
    text = f"{axis.when(event.start, event.end)}: {key[1].lower()}: {key[2]}"
    concluded = ", concluded from motion and shapes" if event.inferred else ""
    return Block(*axis.span(event.start, event.end), (), "", text + concluded, key[3])


def _local(type_: str) -> str:
    return type_.split(":")[-1].split("#")[-1]


def _renamed(names: SpokenNames, readings: Sequence[TaskSequence]) -> list[tuple[str, str]]:
    """Return spoken names with the names of the recording that they replace, where the two differ."""
    used = dict.fromkeys(f for s in readings for m in s.matches for f in m.roles.values())
    return [(names(n), n) for n in used if names(n) != n.replace("_", " ").lower()]


def _lost(told: Sequence[Told], lengths: Sequence[DescriptionLength], axis: Axis) -> dict[str, Any] | None:
    """Return why the second reading lost: the terms of both description lengths, and the actions on which the
    readings differ."""
    if not lengths:
        return None
    terms = [(words, [sign * getattr(one, term) for one in lengths]) for term, words, sign in TERMS]
    rows = [_difference(one, axis) for one in told if one.differs]
    return {"terms": terms, "bits": [one.bits for one in lengths], "rows": rows, "more": lengths[-1].bits - lengths[0].bits}


def _difference(one: Told, axis: Axis) -> dict[str, Any]:
    """Return what each of two readings says about an action, and how much longer the second description is [bits], by term."""
    mine, other = one.lengths
    changed = [(words, sign * (getattr(other, t) - getattr(mine, t))) for t, words, sign in TERMS]
    terms = ", ".join(f"{words} {more:+.1f}".replace("-", "−") for words, more in changed if abs(more) > 0.05)
    when = axis.when(one.start, one.end)
    return {"when": when, "says": one.says, "more": other.bits - mine.bits, "terms": terms or "the same length"}
