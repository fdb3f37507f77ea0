"""Validator of an edited program: the safeguards of the proven program, such as force limits and monitors, are
still in it and switched on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from difflib import SequenceMatcher

from cramlite.model import (
    Code,
    Monitor,
    MoveUntilContact,
    Program,
    SetGripper,
    Value,
    Wait,
    ZeroSensor,
    is_program_text,
    read_program,
    walk,
)
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

SECTION = re.compile(r"^\s*# ---- \d+\.")
POSE = re.compile(r"global \w+ = p?\[")
SETTING = re.compile(r"(?:global )?(\w+) = ")
LIMIT = re.compile(r"global force_limit = ([\d.]+)")
EXPECTED = re.compile(r'"(object|none|contact)".*"([^"]+)"\)')
"""Pattern of a call of the gripper or of a guarded motion in a program's text: the expectation, and the name of the step."""

CALL = re.compile(r"(\w+)\(")
IDLE = {"sleep", "sync", "textmsg"}
"""Calls that only wait or print."""

WATCHED = ("force", "slip", "time")
"""Fields of ``Monitor``: each a quantity that a monitor may watch."""

LEFT_ON = ("force_mode", "freedrive_mode", "teach_mode")
"""States of a controller in which the arm is compliant; the call that ends one has ``end_`` before the name."""


Asked = Mapping[str, set[str]]
"""Name of a step -> the expectations of its calls, or the functions that it calls."""


class Safeguards(Value):
    """Check that an edited program keeps the safeguards of the one that it was edited from.

    Safeguards of a URScript text are the statements before the first task that are no poses, in their order (functions, force
    limit, start check, watchdog); other statements may stand between. A line that is new does not set a variable that they set,
    nor kill their thread, and ends each state in which the arm gives way. Those of a typed program are its force limit, where it
    must be started, and what its control steps watch. In both, a lower force limit keeps them, a step expects what it did, one
    that tares the sensor still does, and one that has a guarded motion keeps one.
    """

    name: str = "safeguards"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        code, proven = candidate.code, candidate.proven
        if code is None or proven is None or code.text == proven.text:
            return
        if is_program_text(code.text):
            wrong = list(_typed_objections(read_program(code.text).program, candidate.program))
        elif any(SECTION.match(line) for line in proven.text.splitlines()):
            wrong = list(_text_objections(code, proven, candidate.program))
        else:
            return
        yield from (Finding(self.name, False, said) for said in wrong)
        if not wrong:
            yield Finding(self.name, True, "the program keeps the safeguards of the one that was proven")


def _text_objections(code: Code, proven: Code, program: Program) -> Iterator[str]:
    lines, old = _statements(code.text), _statements(proven.text)
    yield from _objections(lines, old, _outside(proven))
    yield from _no_longer_asked(_expected(lines), _expected(old))
    tares = _tares(program) - {s.origin for s in walk(program.steps) if not isinstance(s, ZeroSensor | Wait)}
    yield from _no_longer_called(_called(code, tares), _called(proven, tares))
    with_code = {origin for first, origin in code.origins.items() if code.lines_of(first)}
    yield from _no_longer_felt(with_code & _guarded(old) - _guarded(lines))


def _typed_objections(program: Program, proven: Program) -> Iterator[str]:
    if proven.force_limit > 0 and not 0 < program.force_limit <= proven.force_limit:
        yield f"force_limit is {program.force_limit:g} N, that of the proven program {proven.force_limit:g} N"
    if program.start != proven.start:
        yield "start is not that of the proven program: it may begin where it was not proven"
    yield from _no_longer_asked(_expected_by(program), _expected_by(proven))
    yield from _no_longer_called(*({o: {"ZeroSensor"} for o in _tares(p)} for p in (program, proven)))
    guarded, now = ({s.origin for s in walk(p.steps) if isinstance(s, MoveUntilContact)} for p in (proven, program))
    yield from _no_longer_felt({s.origin for s in walk(program.steps)} & guarded - now)
    yield from _no_longer_watched(program, proven)


def _no_longer_asked(asked: Asked, said: Asked) -> Iterator[str]:
    for step in said.keys() & asked.keys():
        if said[step] - asked[step]:
            yield f"{step} no longer asks for '{min(said[step] - asked[step])}': its failure would go unnoticed"


def _no_longer_called(called: Asked, said: Asked) -> Iterator[str]:
    for step in said:
        if lost := said[step] - called.get(step, set()):
            yield f"{step} no longer calls '{min(lost)}': the forces felt after it begin with an offset"


def _no_longer_felt(steps: Iterable[str]) -> Iterator[str]:
    for step in sorted(steps):
        yield f"{step} has no guarded motion any more: the motion after it would hit an obstacle there unguarded"


def _objections(lines: list[str], proven: list[str], guards: list[str]) -> Iterator[str]:
    left = iter(lines)
    lost = next((g for g in guards if not any(_keeps(line, g) for line in left)), "")
    if lost:
        yield f"'{_missing(lines, guards) or lost}' of the proven text is gone, changed or not in its place"
    new = _new(lines, proven)
    kept = {m[1] for g in guards if g.startswith("global ") and (m := SETTING.match(g))}
    for k in new:
        if (m := SETTING.match(lines[k])) and m[1] in kept and not any(_keeps(lines[k], g) for g in guards):
            yield f"'{lines[k]}' overwrites a setting of a safeguard of the proven text"
        if lines[k].startswith("kill ") and lines[k].split()[1] in kept:
            yield f"'{lines[k]}' ends a safeguard before the tasks are done"
        for state in LEFT_ON:
            if lines[k].startswith(f"{state}(") and f"end_{state}()" not in lines[k:]:
                yield f"'{state}' is switched on and no later line switches it off: the arm stays compliant"


def _statements(text: str) -> list[str]:
    """Statements of a program text: its lines without indentation and comments, empty ones left out."""
    return [s for line in text.splitlines() if (s := re.sub(r"(^|\s+)#.*", "", line).strip())]


def _outside(proven: Code) -> list[str]:
    """Statements of the proven text before its first task, without the definitions of poses."""
    lines = proven.text.splitlines()
    first = next(k for k, line in enumerate(lines) if SECTION.match(line))
    return [s for s in _statements("\n".join(lines[:first])) if not POSE.match(s)]


def _missing(lines: list[str], guards: list[str]) -> str:
    """First safeguard statement that is not found, in order, among the lines of a text; "" if all are.
    Force limits are not looked at."""
    blocks = SequenceMatcher(None, guards, lines, autojunk=False).get_matching_blocks()
    there = {k for block in blocks for k in range(block.a, block.a + block.size)}
    return next((g for k, g in enumerate(guards) if k not in there and not LIMIT.match(g)), "")


def _keeps(line: str, guard: str) -> bool:
    one, other = LIMIT.match(line), LIMIT.match(guard)
    return line == guard or bool(one and other and 0 < float(one[1]) <= float(other[1]))


def _new(lines: list[str], proven: list[str]) -> list[int]:
    """Indices of statements that a text has more often than the proven text; of equal statements the first are
    taken as the new ones."""
    more, found = Counter(lines) - Counter(proven), []
    for k, line in enumerate(lines):
        if more[line] > 0:
            more[line] -= 1
            found.append(k)
    return found


def _expected(lines: list[str]) -> dict[str, set[str]]:
    """Step name -> the expectations ("contact", "object", ...) of the gripper calls and guarded motions
    that carry this name; the name "" stands for calls without one."""
    steps: dict[str, set[str]] = {}
    for line in lines:
        if line.startswith(("move_gripper(", "move_until_contact(")):
            steps.setdefault(line.rsplit('"', 2)[1], set()).update(m[1] for m in [EXPECTED.search(line)] if m)
    return steps


def _guarded(lines: Iterable[str]) -> set[str]:
    """Names of the steps that are guarded motions in a text."""
    return {line.rsplit('"', 2)[1] for line in lines if line.startswith("move_until_contact(")}


def _expected_by(program: Program) -> dict[str, set[str]]:
    """Origin -> the expectations ("contact", "object", ...) of the program's gripper steps and guarded
    motions of that origin; the origin "" stands for steps without one."""
    steps: dict[str, set[str]] = {}
    for step in walk(program.steps):
        if isinstance(step, SetGripper | MoveUntilContact):
            steps.setdefault(step.origin, set()).update({step.expect} - {"any"})
    return steps


def _tares(program: Program) -> set[str]:
    """Origins of the steps that tare the force sensor."""
    return {s.origin for s in walk(program.steps) if isinstance(s, ZeroSensor)}


def _called(code: Code, origins: set[str]) -> dict[str, set[str]]:
    """Functions that the program's lines of each given origin call, without those that only wait or print."""
    found: dict[str, set[str]] = {}
    for first, origin in code.origins.items():
        if origin in origins:
            calls = {m[1] for line in code.lines_of(first) if (m := CALL.match(line))}
            found.setdefault(origin, set()).update(calls - IDLE)
    return found


def _no_longer_watched(program: Program, proven: Program) -> Iterator[str]:
    """Describe the monitors of the proven program for which another program has no monitor as strict, in the
    same order."""
    left = [s for s in walk(program.steps) if isinstance(s, Monitor)]
    for one in (s for s in walk(proven.steps) if isinstance(s, Monitor)):
        same = next((k for k, other in enumerate(left) if _watches(other, one)), None)
        if same is None:
            what = ", ".join(f"{name} {value:g}" for name in WATCHED if (value := getattr(one, name)) is not None)
            yield f"what a monitor of the proven program watches ({what}) is watched no more, or less closely"
        else:
            left = left[same + 1 :]


def _watches(one: Monitor, other: Monitor) -> bool:
    """Whether a monitor is at least as strict as another one: it watches all steps of that one, and none of
    its limits is wider."""
    limits = ((getattr(one, name), getattr(other, name)) for name in WATCHED)
    same_origins = {s.origin for s in walk(other.steps)} <= {s.origin for s in walk(one.steps)}
    return same_origins and all(there is None or (own is not None and own <= there) for own, there in limits)


@hookimpl
def validators() -> list[Validator]:
    return [Safeguards()]
