"""Whether rules that were hidden are learned again from demonstrations: leave one out over the tasks that a hand can show.

Run with ``python tests/benchmarks/learning.py [--examples N] [--first SEED] [--seeds N] [--losses SHARE] [--wrong]``. Each rule is hidden
with those that name its task, and learned from N people who show it; known besides are three demonstrations of each other task, with the
tasks that those people were told. It is then asked about people of other seeds:

- stretches in which the task was done, by what the person was told, are to be recognised with the right thing in a role (recall);
- all other stretches that a person was told, and all actions of all episodes, are not (precision), but for those that the hidden rule
  recognises itself, and those inside a stretch in which the task was done.

``--losses`` takes a share of all poses away, ``--wrong`` makes the last example another task's. To reach: both 0.95 for 23 of 26 rules.
A run that was interrupted goes on with the next task: episodes and, of a commit without changes, outcomes stay in ``--cache``.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from figure import add_figure, rate, value, write
from learning_demonstrations import SCENARIOS, Done, Shown, all_shown, named, with_losses
from msgspec import json

from cramlite import Engine
from cramlite.base.value import Value
from cramlite.experiment.figure import Number
from cramlite.experiment.measured import revision
from cramlite.interpretation.interpretation import interpret
from cramlite.interpretation.rules import Rule
from cramlite.interpretation.timeline import Segment, Timeline
from cramlite.learning.example import Example, Library, Marked, example
from cramlite.learning.learner import Learned, conditions, language_of, learn
from cramlite.learning.span import Span
from cramlite.learning.tables import Tables
from cramlite.model import thing_of
from cramlite.plugin import UserError

CACHE = Path.home() / ".cache" / "cramlite" / "learning"
"""Recordings are made once, and outcomes once for each commit. Delete it when persons or scenarios have changed."""
KNOWN = range(500, 503)
"""Seeds of the people who show what is known besides; the first of them are the examples."""


class Asked:
    """Stretches of unseen episodes that rules are asked about."""

    def __init__(self, engine: Engine, shown: Sequence[tuple[str, Shown]]) -> None:
        knowledge = engine.knowledge
        self.of: list[tuple[str, Shown, Done | None]] = []
        spans = []
        for task, one in shown:
            timeline, last = Timeline(one.episode, knowledge.taxonomy), one.episode.span[1]
            for done in one.done:
                spans.append(Span(timeline, done.start, min(done.end, last)))
                self.of.append((task, one, done))
            for action in interpret(one.episode, knowledge.rules, knowledge.taxonomy).actions:
                spans.append(Span(timeline, action.start, action.end))
                self.of.append((task, one, None))
        self.tables = Tables(language_of(knowledge.predicates, knowledge.taxonomy, spans), spans)

    def fillings(self, learned: Learned) -> list[list[tuple[str, ...]]]:
        """For each stretch the fillings of the roles under which a rule holds."""
        roles = learned.cast.roles
        holds = self.tables.truths(learned.literals, roles).all(axis=0) & self.tables.valid(roles)
        return [[self.tables.names(k, int(p), roles) for p in np.flatnonzero(row)] for k, row in enumerate(holds)]


def scored(task: str, rule: Rule, learned: Learned, asked: Asked) -> tuple[int, int, int, Counter[str]]:
    """Numbers of stretches that were rightly and wrongly recognised, of those that were missed, and those stretches."""
    right = wrong = missed = 0
    which = Counter[str]()
    for (shown_task, one, done), span, found in zip(asked.of, asked.tables.spans, asked.fillings(learned), strict=True):
        if done is not None and done.task == task:
            told = [thing_of(f) for f in done.fillers.values()]
            good = [f for f in found if not told or not f or told[0] in f]
            right, missed, wrong = right + bool(good), missed + (not good), wrong + (len(good) < len(found))
            which[f"missed in {shown_task}"] += not good
            which[f"another filler in {shown_task}"] += len(good) < len(found)
        elif found and not _inside(task, one, span) and not _hidden(rule, span):
            wrong += 1
            which[f"{done.task if done else 'an action'} of {shown_task}"] += 1
    return right, wrong, missed, +which


def _inside(task: str, one: Shown, span: Span) -> bool:
    """Whether most of a stretch lies where the task was done."""
    half = 0.5 * (span.end - span.start)
    return any(d.task == task and min(span.end, d.end) - max(span.start, d.start) > half for d in one.done)


def _hidden(rule: Rule, span: Span) -> bool:
    """Whether the hidden rule recognises a stretch."""
    phases, bindings = span.timeline.phases(Segment(span.start, span.end)), [{}]
    for clause in rule.quick_order:
        bindings = [f for b in bindings for f in clause.condition.solve(phases[clause.phase], b)]
    return bool(bindings)


def examples_of(task: str, shown: Sequence[Shown], wrong: Shown | None, rules: Sequence[Rule], engine: Engine) -> list[Example]:
    """Examples that a teacher marks: demonstrations in which the person did the task; the last one may be another task's."""
    marked = []
    for one in shown:
        done = next(d for d in one.done if d.task == task)
        marked.append(Marked(one.episode, done.start, min(done.end, one.episode.span[1])))
    if wrong is not None:
        done = wrong.done[-1]
        marked[-1] = Marked(wrong.episode, done.start, min(done.end, wrong.episode.span[1]))
    return [example(m, rules, engine.knowledge.taxonomy) for m in marked]


class Outcome(Value):
    """What was learned of one task, and its scores.

    Args:
        right, false, missed: stretches, as ``scored`` counts them; of a task that was not learned all that were done are missed.
        shipped: stretches among those that were done that the hidden rule recognises.
        cpu_s: of learning it.
        text: of the rule, or why there is none.
        which: stretches that were told wrongly, and how many.
        roles: of the rule, beside the agent's.
    """

    task: str
    right: int
    false: int
    missed: int
    shipped: int
    cpu_s: float
    text: str
    which: dict[str, int]
    roles: int = 0

    @property
    def precision(self) -> float:
        return self.right / max(self.right + self.false, 1)

    @property
    def recall(self) -> float:
        return self.right / max(self.right + self.missed, 1)

    @property
    def reached(self) -> bool:
        return self.right > 0 and min(self.precision, self.recall) >= 0.95


class Lesson:
    """All that is shown to the learner, and all questions about it afterwards, with one set of options."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.engine, self.options = Engine(), options
        self.knowledge = self.engine.knowledge
        teachers = range(KNOWN[0], KNOWN[0] + max(options.examples, len(KNOWN)))
        test = range(options.first, options.first + options.seeds)
        self.shown, unseen = ([*self.demonstrations(seeds)] for seeds in (teachers, test))
        self.asked = Asked(self.engine, unseen)
        tasks, taxonomy = dict.fromkeys(t for t, _ in self.shown), self.knowledge.taxonomy
        self.libraries = {t: Library([named(s) for o, s in self.shown if o == t][: len(KNOWN)], taxonomy) for t in tasks}

    def demonstrations(self, seeds: range) -> Iterator[tuple[str, Shown]]:
        """Each task with what is shown of it on some seeds."""
        yield from ((t, _lossy(s, self.options.losses)) for t, s in all_shown(self.engine, seeds, self.options.cache))

    def outcome(self, task: str) -> Outcome:
        """Learn a task whose rule is hidden, and score what was learned."""
        knowledge = self.knowledge
        hidden = next(r for r in knowledge.rules if r.task == task)
        rules = [r for r in knowledge.rules if r.task != task and not any(task in c.text for c in r.clauses)]
        wrong = next(s for t, s in self.shown if t == WRONG.get(task, OTHER)) if self.options.wrong else None
        examples = examples_of(task, [s for t, s in self.shown if t == task][: self.options.examples], wrong, rules, self.engine)
        others = [k for t, library in self.libraries.items() if t != task for k in library.known(rules)]
        of_task = [span for (_, _, done), span in zip(self.asked.of, self.asked.tables.spans, strict=True) if done and done.task == task]
        shipped, start = sum(_hidden(hidden, span) for span in of_task), time.process_time()
        try:
            learned = learn(examples, others, knowledge.predicates, knowledge.taxonomy)
        except UserError as error:
            return Outcome(task, 0, 0, len(of_task), shipped, time.process_time() - start, str(error), {})
        seconds = time.process_time() - start
        right, false, missed, which = scored(task, hidden, learned, self.asked)
        text = f"{learned.bits:.0f} bits: {_text(learned)}"
        return Outcome(task, right, false, missed, shipped, seconds, text, dict(which), learned.cast.roles)


def outcomes(options: argparse.Namespace) -> Iterator[Outcome]:
    """Outcomes of the tasks: those that this commit measured before with the same options are read from the cache."""
    commit, changed = revision(Path(__file__).parents[2])
    said = f"{options.examples}_{options.first}_{options.seeds}_{options.losses:g}{'_wrong' * options.wrong}"
    file = options.cache / f"outcomes_{commit}_{said}.jsonl"
    known = [] if changed or not file.exists() else [json.decode(line, type=Outcome) for line in file.read_bytes().splitlines()]
    yield from (one for one in known if one.task in options.tasks)
    left = [t for t in options.tasks if t not in {one.task for one in known}]
    lesson = Lesson(options) if left else None
    for task in left:
        assert lesson is not None
        one = lesson.outcome(task)
        if not changed:
            with file.open("ab") as written:
                written.write(json.encode(one) + b"\n")
        yield one


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=[*SCENARIOS], help="classes of tasks; all by default")
    parser.add_argument("--examples", type=int, default=3)
    parser.add_argument("--first", type=int, default=600, help="first seed of those who are asked about (default 600)")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--losses", type=float, default=0.0, help="share of all poses that are lost")
    parser.add_argument("--wrong", action="store_true", help="the last example shows another task")
    parser.add_argument("--cache", type=Path, default=CACHE, help=f"folder of recorded episodes and outcomes (default {CACHE})")
    add_figure(parser)
    arguments = parser.parse_args()
    arguments.cache.mkdir(parents=True, exist_ok=True)
    found = [told(one) for one in outcomes(arguments)]
    write(arguments, numbers(found), range(arguments.first, arguments.first + arguments.seeds))


def told(one: Outcome) -> Outcome:
    """Print an outcome."""
    counts = f"{one.right} right, {one.false} false, {one.missed} missed, {one.shipped} by the shipped rule"
    print(f"{one.task}: precision {one.precision:.2f}, recall {one.recall:.2f} ({counts}); {one.cpu_s:.1f} s")
    print(f"  {one.text}; {one.which or ''}", flush=True)
    return one


def numbers(found: Sequence[Outcome]) -> list[Number]:
    """Print the sums of outcomes, and give them as numbers of a figure."""
    right, false, missed, shipped = (sum(getattr(one, k) for one in found) for k in ("right", "false", "missed", "shipped"))
    reached = sum(one.reached for one in found)
    print(f"{reached} of {len(found)}; {right} right, {false} false, {missed} missed; {time.process_time():.0f} s of CPU")
    return [
        rate("rules learned with precision and recall of 0.95", reached, len(found)),
        rate("stretches recognised", right, right + missed),
        rate("the same stretches, by the shipped rules", shipped, right + missed),
        rate("recognised stretches that are right", right, right + false),
        value("longest time of learning [s of CPU]", round(max((one.cpu_s for one in found), default=0.0), 1)),
    ]


OTHER = "soma:Pushing"
WRONG = {"soma:Pushing": "soma:Reaching"}
"""Whose demonstration the wrong example is."""


def _lossy(one: Shown, share: float) -> Shown:
    if not share:
        return one
    from cramlite.base.value import replace

    rng = np.random.default_rng([int(one.name.rsplit("_", 1)[1]), 7])
    return replace(one, episode=with_losses(one.episode, share, rng))


def _text(learned: Learned) -> str:
    names = ["Hand", "A", "B", "C"][: learned.cast.roles + 1]
    return "; ".join(f"{phase} {', '.join(texts)}" for phase, texts in conditions(learned, names).items() if texts)


if __name__ == "__main__":
    main()
