"""Type check of a URScript program without running it: places where, for example, a string stands for a
number."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .check import functions, nodes
from .doubts import Doubt
from .syntax import (  # fmt: skip
    Assign,
    Binary,
    Call,
    Expression,
    Function,
    If,
    ListOf,
    Name,
    Number,
    Run,
    Text,
    Truth,
    Unary,
    While,
)

Kinds = Mapping[str, str]
PLACE = "a pose or a list"
TAKES = {
    "movej": (PLACE, "a number", "a number", "a number", "a number"), "movel": (PLACE,) + ("a number",) * 4,
    "servoj": ("a list",) + ("a number",) * 5, "speedj": ("a list", "a number", "a number"),
    "speedl": (PLACE, "a number", "a number", "a number"), "stopj": ("a number",), "stopl": ("a number", "a number"),
    "force_mode": ("a pose", "a list", PLACE, "a number", PLACE), "set_tcp": ("a pose",), "sleep": ("a number",),
    "get_inverse_kin": ("a pose", PLACE), "get_forward_kin": ("a list", "a pose"), "pose_trans": ("a pose", "a pose"),
    "pose_inv": ("a pose",), "pose_add": ("a pose", "a pose"), "pose_sub": ("a pose", "a pose"),
    "set_payload": ("a number", "a list"), "set_target_payload": ("a number", "a list"), "d2r": ("a number",),
    "sin": ("a number",), "cos": ("a number",), "sqrt": ("a number",), "to_num": ("a string",),
    "socket_set_var": ("a string", "a number", "a string"), "socket_open": ("a string", "a number", "a string"),
}  # fmt: skip
GIVES = {
    "get_actual_tcp_pose": "a pose", "get_target_tcp_pose": "a pose", "pose_trans": "a pose", "pose_inv": "a pose",
    "pose_add": "a pose", "pose_sub": "a pose", "get_forward_kin": "a pose", "get_inverse_kin": "a list",
    "get_actual_joint_positions": "a list", "get_target_joint_positions": "a list", "norm": "a number",
    "force": "a number", "get_steptime": "a number", "sqrt": "a number", "d2r": "a number", "to_str": "a string",
    "str_cat": "a string", "is_steady": "a truth value", "length": "a number", "socket_get_var": "a number",
    "pose_dist": "a number", "point_dist": "a number", "floor": "a number", "ceil": "a number",
}  # fmt: skip


def wrong_kinds(program: Function) -> list[Doubt]:
    """List every place at which a value has another type than needed, as far as the program's text shows the
    type."""
    known = _variables(program)
    found = [d for node in nodes(program) for d in _at(node, known)]
    return sorted(set(found), key=lambda d: (d.line, d.text))


def _at(node: object, known: Kinds) -> Iterator[Doubt]:
    if isinstance(node, Call) and node.function in TAKES:
        for i, (value, wanted) in enumerate(zip(node.arguments, TAKES[node.function], strict=False), 1):
            kind = _kind(value, known)
            if kind and kind not in wanted.split(" or "):
                yield Doubt(node.line, f"{node.function}: argument {i} must be {wanted}, and is {kind}")
    elif isinstance(node, Binary) and node.operator in ("+", "-", "*", "/", "%", "<", ">", "<=", ">="):
        yield from _operands(node, known)
    elif isinstance(node, While | If):
        conditions = [node.condition] if isinstance(node, While) else [c for c, _ in node.branches]
        for condition in conditions:
            if (kind := _kind(condition, known)) and kind != "a truth value":
                yield Doubt(node.line, f"a condition must be a truth value, and this is {kind}")


def _operands(node: Binary, known: Kinds) -> Iterator[Doubt]:
    """Operands of a wrong type: neither numbers nor, for arithmetic, lists of numbers; '+' also joins two
    strings."""
    kinds = [_kind(side, known) for side in (node.left, node.right)]
    fits = {"", "a number"} | ({"a list"} if node.operator in ("+", "-", "*", "/", "%") else set())
    if node.operator == "+" and "a string" in kinds:
        fits = {"", "a string"}
    for kind in kinds:
        if kind not in fits:
            needs = "two strings or two numbers" if "a string" in fits else "numbers"
            yield Doubt(node.line, f"'{node.operator}' needs {needs}, and has {kind}")


def _variables(program: Function) -> dict[str, str]:
    """Types of the variables to which only values of one type are assigned; parameters are left out."""
    seen: dict[str, set[str]] = {}
    for function in functions(program).values():
        for name, _ in function.parameters:
            seen.setdefault(name, set()).add("")
    assigned = [n for n in nodes(program) if isinstance(n, Assign) and isinstance(n.target, Name)]
    for node in assigned:
        assert isinstance(node.target, Name)
        seen.setdefault(node.target.name, set()).add(_kind(node.value, {}))
    return {name: kinds.pop() for name, kinds in seen.items() if len(kinds) == 1}


def _kind(value: Expression, known: Kinds) -> str:
    """The type of an expression, such as "a number"; "" if the text does not show it."""
    match value:
        case Number():
            return "a number"
        case Text():
            return "a string"
        case Truth():
            return "a truth value"
        case ListOf():
            return "a pose" if value.pose else "a list"
        case Run():
            return "a thread"
        case Name():
            return known.get(value.name, "")
        case Call():
            return GIVES.get(value.function, "")
        case Unary():
            return "a truth value" if value.operator == "not" else _kind(value.operand, known)
        case Binary() if value.operator in ("+", "-", "*", "/", "%"):
            left, right = _kind(value.left, known), _kind(value.right, known)
            return left if left == right else ""
        case Binary():
            return "a truth value"
    return ""
