"""Subset of Python in which generated code must be. Code is checked before it runs, and not executed if it
uses anything else.

The generator writes nothing else, whatever a program says. So this is a second lock: names have a prefix or are helpers, the only
attributes are methods of the machine, and there is no import, class, lambda, comprehension, format string, star or ``del``.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from types import CodeType
from typing import Any

METHODS = frozenset(("at", "critical", "join", "kept", "kill", "main", "run"))
"""Methods of the interpreter that generated Python code may call."""
MACHINE, GLOBALS = "m", "g"
_OWN = re.compile(r"[fvb]_[A-Za-z0-9_]*", re.ASCII)
_PLAIN = frozenset((
    ast.And, ast.BoolOp, ast.Break, ast.Continue, ast.Compare, ast.Dict, ast.Eq, ast.Expr, ast.If, ast.Load, ast.Module, ast.Not,
    ast.NotEq, ast.Or, ast.Pass, ast.Return, ast.Store, ast.UnaryOp, ast.While, ast.Yield, ast.YieldFrom,
))  # fmt: skip
_CONSTANTS = (bool, float, int, str, type(None))


class OtherPython(Exception):
    """Error of generated Python code that uses a construct outside the permitted subset: a defect of the code
    generator, not of the URScript program."""


def compiled(source: str, helpers: Iterable[str]) -> CodeType:
    """Compile generated Python source if it is within the subset that translated programs may use.

    Args:
        helpers: functions that it may name without a prefix.

    Raises:
        OtherPython: it is not; names the construct and its line.
        SyntaxError, RecursionError, MemoryError: it is nested too deeply for Python.
    """
    tree = ast.parse(source)
    names = frozenset(helpers) | {MACHINE, GLOBALS}
    for node in ast.walk(tree):
        check = _CHECKS.get(type(node))
        if not (check(node, names) if check else type(node) in _PLAIN):
            raise OtherPython(f"line {getattr(node, 'lineno', '?')}: {ast.dump(node)[:200]}")
    return compile(tree, "<urscript>", "exec")


def _name(node: ast.Name, names: frozenset[str]) -> bool:
    own = _OWN.fullmatch(node.id) is not None
    return own if isinstance(node.ctx, ast.Store) else own or node.id in names


def _attribute(node: ast.Attribute, names: frozenset[str]) -> bool:
    of_machine = isinstance(node.value, ast.Name) and node.value.id == MACHINE
    return of_machine and node.attr in METHODS and isinstance(node.ctx, ast.Load)


def _subscript(node: ast.Subscript, names: frozenset[str]) -> bool:
    of_globals = isinstance(node.value, ast.Name) and node.value.id == GLOBALS
    return of_globals and isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str)


def _function(node: ast.FunctionDef, names: frozenset[str]) -> bool:
    bare = not (node.decorator_list or node.returns or getattr(node, "type_params", None))
    return bare and _OWN.fullmatch(node.name) is not None


def _arguments(node: ast.arguments, names: frozenset[str]) -> bool:
    return not (node.posonlyargs or node.kwonlyargs or node.vararg or node.kwarg)


def _argument(node: ast.arg, names: frozenset[str]) -> bool:
    return node.annotation is None and _OWN.fullmatch(node.arg) is not None


def _call(node: ast.Call, names: frozenset[str]) -> bool:
    return isinstance(node.func, ast.Name | ast.Attribute)


def _keyword(node: ast.keyword, names: frozenset[str]) -> bool:
    return node.arg is not None


def _constant(node: ast.Constant, names: frozenset[str]) -> bool:
    return type(node.value) in _CONSTANTS


def _assignment(node: ast.Assign, names: frozenset[str]) -> bool:
    return len(node.targets) == 1 and isinstance(node.targets[0], ast.Name | ast.Subscript)


_CHECKS: Mapping[type[ast.AST], Callable[[Any, frozenset[str]], bool]] = {
    ast.Name: _name, ast.Attribute: _attribute, ast.Subscript: _subscript, ast.FunctionDef: _function, ast.arguments: _arguments,
    ast.arg: _argument, ast.Call: _call, ast.keyword: _keyword, ast.Constant: _constant, ast.Assign: _assignment,
}  # fmt: skip
"""Nodes of Python's syntax tree that generated code may have under a condition, with the functions that check it."""
