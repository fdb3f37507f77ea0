"""Validator of safeguards: what watches over the tasks of the proven text is still there and on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from cramlite.model import Code, Value, is_program_text
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

SECTION = re.compile(r"^\s*# ---- \d+\.")
POSE = re.compile(r"global \w+ = p?\[")
SETTING = re.compile(r"(?:global )?(\w+) = ")
LIMIT = re.compile(r"global force_limit = ([\d.]+)")
EXPECTED = re.compile(r'"(object|none|contact)".*"([^"]+)"\)')
"""What a call of the fingers or of a guarded motion expects, and the step that it names."""

LEFT_ON = ("force_mode", "freedrive_mode", "teach_mode")
"""States of a controller in which the arm gives way; ``end_`` before the name is the call that ends one."""


class Safeguards(Value):
    """Check that an edited URScript text keeps the safeguards of the one that it was edited from.

    Safeguards are the statements before the first task that are no poses, in their order (functions, force limit,
    start check, watchdog), and what a call of a step expects. A lower force limit keeps them; other statements may stand between. A line
    that is new does not set a variable that they set, nor kill their thread, and ends each state in which the arm
    gives way.
    """

    name: str = "safeguards"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        code, proven = candidate.code, candidate.proven
        if code is None or proven is None or code.text == proven.text or is_program_text(code.text):
            return
        if not any(SECTION.match(line) for line in proven.text.splitlines()):
            return
        wrong = list(_objections(_statements(code.text), _statements(proven.text), _outside(proven)))
        yield from (Finding(self.name, False, said) for said in wrong)
        if not wrong:
            yield Finding(self.name, True, "the text watches over its tasks as the one that was proven")


def _objections(lines: list[str], proven: list[str], guards: list[str]) -> Iterator[str]:
    left = iter(lines)
    lost = next((g for g in guards if not any(_keeps(line, g) for line in left)), "")
    if lost:
        yield f"'{lost}' of the proven text is gone, changed or not in its place"
    new = _new(lines, proven)
    kept = {m[1] for g in guards if g.startswith("global ") and (m := SETTING.match(g))}
    for k in new:
        if (m := SETTING.match(lines[k])) and m[1] in kept and not any(_keeps(lines[k], g) for g in guards):
            yield f"'{lines[k]}' sets what a safeguard of the proven text sets"
        if lines[k].startswith("kill ") and lines[k].split()[1] in kept:
            yield f"'{lines[k]}' ends a safeguard before the tasks are done"
        for state in LEFT_ON:
            if lines[k].startswith(f"{state}(") and f"end_{state}()" not in lines[k:]:
                yield f"'{state}' is switched on and nothing behind it switches it off: the arm gives way"
    asked, said = _expected(lines), _expected(proven)
    for step in said.keys() & asked.keys():
        if said[step] - asked[step]:
            yield f"{step} no longer asks for '{min(said[step] - asked[step])}': its failure would go unnoticed"


def _statements(text: str) -> list[str]:
    """Lines of code, without indentation and comments."""
    return [s for line in text.splitlines() if (s := re.sub(r"(^|\s+)#.*", "", line).strip())]


def _outside(proven: Code) -> list[str]:
    """Statements before the first task that are no poses."""
    lines = proven.text.splitlines()
    first = next(k for k, line in enumerate(lines) if SECTION.match(line))
    return [s for s in _statements("\n".join(lines[:first])) if not POSE.match(s)]


def _keeps(line: str, guard: str) -> bool:
    one, other = LIMIT.match(line), LIMIT.match(guard)
    return line == guard or bool(one and other and 0 < float(one[1]) <= float(other[1]))


def _new(lines: list[str], proven: list[str]) -> list[int]:
    """Numbers of the statements that the proven text has not, or fewer times; of equal ones the first are new."""
    more, found = Counter(lines) - Counter(proven), []
    for k, line in enumerate(lines):
        if more[line] > 0:
            more[line] -= 1
            found.append(k)
    return found


def _expected(lines: list[str]) -> dict[str, set[str]]:
    """What the calls that name a step expect, also "" where one expects nothing."""
    steps: dict[str, set[str]] = {}
    for line in lines:
        if line.startswith(("move_gripper(", "move_until_contact(")):
            steps.setdefault(line.rsplit('"', 2)[1], set()).update(m[1] for m in [EXPECTED.search(line)] if m)
    return steps


@hookimpl
def validators() -> list[Validator]:
    return [Safeguards()]
