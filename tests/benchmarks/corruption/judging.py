"""Judging of cases: one engine for each process, and one line of JSON for each program, so that a run can go on."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import msgspec

from cramlite.base.value import Value
from cramlite.engine.proof.intent import read_intent
from cramlite.engine.proof.judging import JudgedRun, Purpose, judge_text
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.selection import INSTALLED

from .bases import BASES, Ready, ready
from .cases import Case, cases, rules_named
from .rule import Seen

UNCHANGED = "unchanged"
"""Name of the rule of a base as it is: it must pass, or its cases say nothing."""


class Answer(Value):
    """What came of a case.

    Args:
        case: its name: rule, base, number.
        group: of the rule, "A" to "E", "N" or "H".
        base: its name.
        sealed: whether the rule is.
        oracle: what it said: the harm of a corruption, what went wrong with a harmless edit.
        halted: why the program ended early, "" when it ran to its end.
        passed: what the validators said.
        reasons: of those that objected, each with its validator and task.
        right: whether they are about what was done.
        seconds: CPU time.
        error: why there is no answer.
    """

    case: str
    group: str
    base: str
    sealed: bool
    oracle: str = ""
    halted: str = ""
    passed: bool = False
    reasons: tuple[str, ...] = ()
    right: bool = False
    seconds: float = 0.0
    error: str = ""

    @property
    def counts(self) -> bool:
        """Whether a case does as its rule means: its program ran to the end and did harm, or no harm where it should do none."""
        return not self.error and not self.halted and bool(self.oracle) != (self.group == "H")


@cache
def _knowledge() -> Knowledge:
    return Knowledge(INSTALLED.registry())


@cache
def _ready(name: str, work: Path) -> Ready:
    return ready(next(b for b in BASES if b.name == name), work, _knowledge())


def judged(base: Ready, text: str) -> JudgedRun:
    """Run and judge a text by the plan of its base, as ``cramlite judge`` does."""
    return judge_text(text, base.world, Purpose(intent=read_intent(base.folder)), _knowledge(), 0)


def answer(case: Case, work: Path) -> Answer:
    """Edit, run and judge one program; the answer tells of an exception."""
    told = Answer(case.name, case.rule.group, case.base, case.rule.sealed)
    start = time.process_time()
    try:
        base = _ready(case.base, work)
        found = judged(base, case.text(base))
        oracle = case.rule.oracle(Seen(base, found.rollout))
    except Exception as error:
        return msgspec.structs.replace(told, error=f"{type(error).__name__}: {error}")
    reasons = tuple(f"{f.validator}: {f.origin}: {f.reason}" for f in found.verdict.findings if not f.passed)
    words = (*case.rule.about, base.base.held, base.base.stranger)
    return msgspec.structs.replace(
        told, oracle=oracle, halted=found.rollout.reason if found.rollout.outcome != "finished" else "", passed=found.verdict.passed,
        reasons=reasons, right=any(w in r for w in words for r in reasons), seconds=time.process_time() - start,
    )  # fmt: skip


def as_it_is(name: str, work: Path) -> Answer:
    """Judge a base without any edit."""
    base = _ready(name, work)
    found = judged(base, base.text)
    reasons = tuple(f"{f.validator}: {f.reason}" for f in found.verdict.findings if not f.passed)
    return Answer(f"{UNCHANGED}/{name}/0", "H", name, False, passed=found.verdict.passed, reasons=reasons)


def _named(name: str, rules: str, seed: int, work: Path) -> Answer:
    """Answer a case by its name: functions do not travel between processes."""
    if name.startswith(UNCHANGED):
        return as_it_is(name.split("/")[1], work)
    return answer(next(c for c in cases(rules_named(rules), seed) if c.name == name), work)


def answers(names: Iterable[str], rules: str, seed: int, work: Path, workers: int) -> Iterator[Answer]:
    """Judge cases in some processes; what an earlier run wrote is read, not judged again."""
    names, log = tuple(names), work / f"answers-{seed}.jsonl"
    known = _known(log)
    yield from (known[n] for n in names if n in known)
    waiting = [n for n in names if n not in known]
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool, log.open("ab") as file:
        for one in pool.map(_named, waiting, *([x] * len(waiting) for x in (rules, seed, work))):
            file.write(msgspec.json.encode(one) + b"\n")
            file.flush()
            yield one


def _known(log: Path) -> dict[str, Answer]:
    if not log.is_file():
        return {}
    found = (msgspec.json.decode(line, type=Answer) for line in log.read_bytes().splitlines())
    return {a.case: a for a in found}


def distinct(chosen: Iterable[Case], work: Path) -> list[Case]:
    """Leave out programs with the same text as another one; bases are resolved here, one after the other."""
    found: dict[tuple[str, str], Case] = {}
    for case in chosen:
        found.setdefault((case.base, case.text(_ready(case.base, work))), case)
    return list(found.values())
