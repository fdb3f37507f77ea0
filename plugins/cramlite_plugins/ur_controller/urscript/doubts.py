"""Lint of URScript: degrees for radians, waits without end, code that never runs.

A doubt does not stop a program from running here; ``cramlite check`` reports it, and our own backends must raise none.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping

from cramlite.model import Value

from .check import functions, nodes
from .syntax import (  # fmt: skip
    Assign,
    Binary,
    Call,
    Critical,
    Evaluate,
    Expression,
    Function,
    If,
    Item,
    Jump,
    ListOf,
    Name,
    Number,
    Return,
    Statement,
    Truth,
    Unary,
    While,
)

TURN = 2 * math.pi + 0.01  # joints turn at most once around in each direction on UR arms (user manual, "Limits")
REACH = 3.0  # further than any UR arm [m]
JOINTS = {"movej": 0, "movel": 0, "servoj": 0, "get_forward_kin": 0, "speedj": 0}
POSES = {"movej": 0, "movel": 0, "movep": 0, "get_inverse_kin": 0, "set_tcp": 0, "force_mode": 0}
SPEEDS = {"movej": (math.tau, "rad/s"), "movel": (REACH, "m/s"), "movep": (REACH, "m/s")}
WAITS = {
    "sync", "sleep", "socket_get_var", "socket_read_string", "socket_read_byte_list", "read_input_integer_register",
    "is_steady", "get_tcp_force", "force", "get_digital_in", "get_standard_digital_in",
}  # fmt: skip
NO_BLEND = "a blend radius is not modelled here: the arm stops at each target, where a robot rounds the corner and is there sooner"
UNBLENDED = {"movel": 4, "movec": 4}
"""Motion functions whose blend radius is ignored, with the position of that argument."""
CLOCKS = {"get_steptime", "get_time"}
Body = tuple[Statement, ...]


class Doubt(Value):
    """A lint warning."""

    line: int
    text: str


def doubts(program: Function) -> list[Doubt]:
    """List the lint warnings of a program, by line."""
    found = {*_numbers(program), *_waits(program), *_dead(program), *_unused(program)}
    found |= {*_unblended(program), *_speeds(program), *_left_on(program), *_recursion(program)}
    return sorted(found, key=lambda d: (d.line, d.text))


# Units


def _numbers(program: Function) -> Iterator[Doubt]:
    named = _literals(program)
    for node in nodes(program):
        if isinstance(node, Call):
            for argument, what in ((JOINTS.get(node.function), _joints), (POSES.get(node.function), _pose)):
                if argument is not None and argument < len(node.arguments):
                    yield from what(_resolved(node.arguments[argument], named), node.function)


def _literals(program: Function) -> Mapping[str, ListOf]:
    """Variables to which only one list literal is ever assigned, with that list."""
    seen: dict[str, list[Expression]] = {}
    for node in nodes(program):
        if isinstance(node, Assign):
            name = node.target.name if isinstance(node.target, Name) else ""
            if isinstance(node.target, Item) and isinstance(node.target.value, Name):
                name = node.target.value.name
                seen.setdefault(name, []).append(node.value)
            seen.setdefault(name, []).append(node.value)
    return {n: v[0] for n, v in seen.items() if len(v) == 1 and isinstance(v[0], ListOf)}


def _resolved(expression: Expression, named: Mapping[str, ListOf]) -> Expression:
    return named.get(expression.name, expression) if isinstance(expression, Name) else expression


def _joints(value: Expression, function: str) -> Iterator[Doubt]:
    if isinstance(value, ListOf) and not value.pose:
        for item in value.items:
            if (number := _number(item)) is not None and abs(number) > TURN:
                yield Doubt(
                    value.line,
                    f"{function}: a joint at {number:g} rad is more than a turn: degrees? d2r() converts them",
                )


def _pose(value: Expression, function: str) -> Iterator[Doubt]:
    if not isinstance(value, ListOf) or not value.pose:
        return
    numbers = [_number(item) for item in value.items]
    for number in numbers[:3]:
        if number is not None and abs(number) > REACH:
            yield Doubt(value.line, f"{function}: a position of {number:g} m is out of every arm's reach: millimetres?")
    turn = math.hypot(*(n or 0.0 for n in numbers[3:]))
    if turn > TURN:
        yield Doubt(
            value.line,
            f"{function}: a rotation vector of {turn:g} rad is more than a turn: degrees? d2r() converts them",
        )


def _number(expression: Expression) -> float | None:
    if isinstance(expression, Number):
        return float(expression.value)
    if isinstance(expression, Unary) and expression.operator == "-":
        value = _number(expression.operand)
        return None if value is None else -value
    return None


def _speeds(program: Function) -> Iterator[Doubt]:
    """Yield a lint warning for each number that is a higher speed than any arm of Universal Robots reaches."""
    for node in nodes(program):
        if isinstance(node, Call) and node.function in SPEEDS:
            most, unit = SPEEDS[node.function]
            given = dict(node.named).get("v") or (node.arguments[2] if len(node.arguments) > 2 else None)
            value = _number(given) if given is not None else None
            if value is not None and value > most:
                said = f"{node.function}: a speed of {value:g} {unit} is more than {most:g} {unit}"
                yield Doubt(node.line, f"{said}: degrees or millimetres?")


def _unblended(program: Function) -> Iterator[Doubt]:
    """Yield a lint warning for each blend radius in a motion whose blending is not modelled, unless it is 0."""
    for node in nodes(program):
        if isinstance(node, Call) and node.function in UNBLENDED:
            at = UNBLENDED[node.function]
            given = dict(node.named).get("r") or (node.arguments[at] if len(node.arguments) > at else None)
            if given is not None and _number(given) != 0.0:
                yield Doubt(node.line, f"{node.function}: {NO_BLEND}")


# Ends


def _left_on(program: Function) -> Iterator[Doubt]:
    """Yield a lint warning for each call that switches force mode on, if the program never switches it off."""
    calls = [n for n in nodes(program) if isinstance(n, Call)]
    if not any(c.function == "end_force_mode" for c in calls):
        for call in calls:
            if call.function == "force_mode":
                yield Doubt(call.line, "force mode is switched on and nowhere off: call end_force_mode() on every way out")


def _recursion(program: Function) -> Iterator[Doubt]:
    """Yield a lint warning for each function that calls itself, directly or through others."""
    own = functions(program)
    calls = {name: {n.function for n in nodes(f.body) if isinstance(n, Call)} & set(own) for name, f in own.items() if f is not program}
    for name, called in calls.items():
        reached, waiting = set(), list(called)
        while waiting:
            one = waiting.pop()
            if one not in reached:
                reached.add(one)
                waiting += calls.get(one, ())
        if name in reached:
            yield Doubt(own[name].line, f"'{name}' calls itself: a controller ends a program that does so without end")


# Waiting


def _waits(program: Function) -> Iterator[Doubt]:
    """Yield a lint warning for each loop that waits for something and does not count or measure how long."""
    threads = {f.name for f in functions(program).values() if f.word == "thread"}
    for function in functions(program).values():
        if function.name in threads:
            continue  # a thread may run for ever: whoever started it kills it
        for node in _inside(function.body, loops=True):
            if isinstance(node, While) and _endless_wait(node):
                yield Doubt(node.line, "this loop waits without a time-out: count its cycles and give up with a reason")


def _endless_wait(loop: While) -> bool:
    inside = list(nodes(loop.body)) + list(nodes(loop.condition))
    waits = any(isinstance(n, Call) and n.function in WAITS for n in inside)
    return waits and not _bounded(loop, inside)


def _bounded(loop: While, inside: list[object]) -> bool:
    """Whether the end of a loop depends on a counter that grows in the loop, or the loop reads a clock."""
    if any(isinstance(n, Call) and n.function in CLOCKS for n in inside):
        return True
    growing = {
        n.target.name
        for n in inside
        if isinstance(n, Assign) and isinstance(n.target, Name) and isinstance(n.value, Binary)
        and n.value.operator in "+-" and any(isinstance(v, Name) and v.name == n.target.name for v in nodes(n.value))
    }  # fmt: skip
    deciding = [loop.condition, *(c for n in inside if isinstance(n, If) for c, body in n.branches if _leaves(body))]
    return any(isinstance(v, Name) and v.name in growing for condition in deciding for v in nodes(condition))


def _leaves(body: Body) -> bool:
    return any(isinstance(n, Jump | Return) or (isinstance(n, Call) and _stops(n)) for n in nodes(body))


def _stops(call: Call) -> bool:
    return call.function == "halt" or "abort" in call.function or "fail" in call.function


# Code that never runs


def _dead(program: Function) -> Iterator[Doubt]:
    for node in nodes(program):
        if isinstance(node, Function | While):
            yield from _after_the_end(node.body)
        elif isinstance(node, If):
            for _, body in node.branches:
                yield from _after_the_end(body)
            yield from _after_the_end(node.otherwise)


def _after_the_end(body: Body) -> Iterator[Doubt]:
    for statement, following in itertools.pairwise(body):
        if _ends(statement) and not isinstance(following, Function):
            yield Doubt(following.line, f"this statement is never reached: line {statement.line} never ends, or leaves this block")


def _ends(statement: Statement) -> bool:
    if isinstance(statement, Jump | Return):
        return True
    if isinstance(statement, Evaluate):
        return isinstance(statement.value, Call) and statement.value.function == "halt"
    if isinstance(statement, While):
        always = isinstance(statement.condition, Truth) and statement.condition.value
        return always and not any(
            (isinstance(n, Jump) and n.word == "break") or isinstance(n, Return) for n in _inside(statement.body, loops=False)
        )
    return isinstance(statement, If) and bool(statement.otherwise) and all(
        body and _ends(body[-1]) for body in (*(b for _, b in statement.branches), statement.otherwise)
    )  # fmt: skip


def _inside(body: Iterable[object], *, loops: bool) -> Iterator[object]:
    """Statements of a block of code, of the branches of its conditions, and of the loops in it.

    Without ``loops``, only the returns of inner loops are among them, since a ``break`` there ends the inner
    loop.
    """
    waiting = list(body)
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, If):
            waiting += [s for _, branch in node.branches for s in branch] + list(node.otherwise)
        elif isinstance(node, While):
            waiting += node.body if loops else [n for n in nodes(node.body) if isinstance(n, Return)]


def _unused(program: Function) -> Iterator[Doubt]:
    """Yield a lint warning for each function that enters more critical sections than it leaves: all other
    threads stay blocked."""
    for function in functions(program).values():
        words = [n.word for n in _inside(function.body, loops=True) if isinstance(n, Critical)]
        if words.count("enter_critical") > words.count("exit_critical"):
            yield Doubt(
                function.line,
                f"'{function.name}' enters more critical sections than it leaves: other threads would stop",
            )
