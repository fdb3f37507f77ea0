"""Mutants of validators, no-goods, places and the detection of grasps: does a quick test object to each?

    pip install cosmic-ray
    python tests/benchmarks/mutants.py [WORD ...] [--by-hand] [--again FILE] [--list]

Cosmic Ray changes one operator, number or condition of a module at a time; the module's own quick tests (``mutants.yaml``) must
then fail. WORD picks the modules whose name contains it. A process that has everything imported is forked for each mutant, which
imports anew only what stands on the changed module: that takes two tenths of a second, beside what its tests take. Mutants of
annotations, of ``assert`` (there for type checkers alone) and of what is written for people in ``f""`` are left out. What survives
and is not listed in ``mutants.yaml`` as equivalent is printed, and makes the exit code 1.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import importlib
import io
import os
import signal
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from itertools import chain
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import yaml
from figure import add_figure, value, write

ROOT = Path(__file__).parents[2]
PATIENCE = 6  # so many times as long as they take for the module as it is, and a second, its tests may: a mutant may run on for ever
PLAINLY = ("-x", "-q", "-o", "addopts=", "-m", "not heavy", "-p", "no:cacheprovider", "--assert=plain")
"""How pytest runs in each process: without its plugins, and without words for what fails, which take most of a quick test's time."""
BINARY = ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Mod_Mul", "BitAnd_BitOr", "BitOr_BitAnd")
COMPARISON = (
    "Eq_NotEq", "NotEq_Eq", "Lt_LtE", "Lt_Gt", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_Lt", "GtE_Gt", "GtE_Lt", "Is_IsNot", "IsNot_Is",
)  # fmt: skip
OTHERS = (
    "AddNot", "NumberReplacer", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue",
    "ReplaceUnaryOperator_Delete_Not", "ReplaceUnaryOperator_USub_UAdd", "ZeroIterationForLoop", "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak",
)  # fmt: skip
OPERATORS = (
    *(f"core/ReplaceBinaryOperator_{name}" for name in BINARY),
    *(f"core/ReplaceComparisonOperator_{name}" for name in COMPARISON),
    *(f"core/{name}" for name in OTHERS),
)
"""Of Cosmic Ray's operators one inverse and one neighbour each: the others change the same places once more."""


class _Changed(SourceFileLoader):
    """Loader of a module from another text."""

    def __init__(self, name: str, path: Path, text: str) -> None:
        super().__init__(name, str(path))
        self.text = text

    def get_code(self, fullname: str) -> CodeType:
        return compile(self.text, self.path, "exec")


class _Finder:
    """Finder of one module that gives it another text."""

    def __init__(self, name: str, path: Path, text: str) -> None:
        self.name, self.path, self.text = name, path, text

    def find_spec(self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != self.name:
            return None
        return spec_from_file_location(name, self.path, loader=_Changed(name, self.path, self.text))


class _Bare(ast.NodeTransformer):
    """Remove code that no run depends on: annotations, imports for them, assertions, and numbers of texts for people."""

    def visit_If(self, node: ast.If) -> ast.AST:
        return ast.Pass() if "TYPE_CHECKING" in ast.dump(node.test) else self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns = None
        return self.generic_visit(node)

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        node.args = [*node.posonlyargs, *node.args, *node.kwonlyargs]  # how they are given changes nothing that runs
        node.defaults = [*node.defaults, *(d for d in node.kw_defaults if d is not None)]
        node.posonlyargs, node.kwonlyargs, node.kw_defaults = [], [], []
        return self.generic_visit(node)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        node.annotation = None
        return node

    def visit_Assert(self, node: ast.Assert) -> ast.AST:
        return ast.Pass()

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        return ast.Constant("")


def mutants(path: Path) -> Iterator[str]:
    """The texts of a module with one change each that can matter when it runs."""
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    text = path.read_text()
    seen = {bare(text)}
    for name in OPERATORS:
        operator, occurrence = get_operator(name)(), 0
        while (changed := mutate_code(text, operator, occurrence)) is not None:
            occurrence += 1
            if (what := bare(changed)) not in seen:
                seen.add(what)
                yield changed


def bare(text: str) -> str:
    """What of a text runs."""
    try:
        return ast.dump(_Bare().visit(ast.parse(text)))
    except SyntaxError:
        return ""


def difference(path: Path, changed: str) -> str:
    """The changed line, before and after."""
    lines = difflib.unified_diff(path.read_text().splitlines(), changed.splitlines(), n=0, lineterm="")
    was, now = ([line[1:].strip() for line in lines_ if line] for lines_ in _sides(lines))
    return f"{' '.join(was)}  ->  {' '.join(now)}"


def _sides(lines: Iterator[str]) -> tuple[list[str], list[str]]:
    kept = [line for line in lines if not line.startswith(("---", "+++", "@@"))]
    return [k for k in kept if k[0] == "-"], [k for k in kept if k[0] == "+"]


def survives(name: str, path: Path, changed: str, entry: dict[str, Any], patience: float = 600.0) -> bool:
    """Whether the tests of a module pass with another text of it within a number of seconds: in a process that begins where
    this one is."""
    child = os.fork()
    if not child:
        os._exit(_tested(name, path, changed, entry))
    until = time.monotonic() + patience
    while time.monotonic() < until:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status) == 0
        time.sleep(0.005)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def _tested(name: str, path: Path, changed: str, entry: dict[str, Any]) -> int:
    import pytest

    _forget([m for m in sys.modules if any(m == p or m.startswith(f"{p}.") for p in entry["afresh"])])
    sys.meta_path.insert(0, _Finder(name, path, changed))
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        return int(pytest.main([*PLAINLY, *(str(ROOT / t) for t in entry["tests"])]))


def _forget(modules: list[str]) -> None:
    """Import modules anew when they are next asked for; a package keeps names that it was asked for (``LazyNames``)."""
    for module in modules:
        del sys.modules[module]
    for package in [m for m in sys.modules.values() if "__getattr__" in vars(m)]:
        for name in [n for n, v in vars(package).items() if getattr(v, "__module__", None) in modules]:
            delattr(package, name)


def surviving(module: str, entry: dict[str, Any], by_hand_alone: bool, again: str | None) -> Iterator[str]:
    """The differences of the mutants of a module that its tests let pass; print their number."""
    name = module.removeprefix("plugins/").removesuffix(".py").replace("/", ".")
    path, count, lived, start = ROOT / module, 0, 0, time.monotonic()
    text = path.read_text()
    if not survives(name, path, text, entry):
        raise SystemExit(f"{module}: its tests fail as it is; run them by themselves: {' '.join(entry['tests'])}")
    patience = 1.0 + PATIENCE * (time.monotonic() - start)
    by_hand = entry.get("by_hand", {})
    if stale := [old for old in by_hand if old not in text]:
        raise SystemExit(f"{module}: mutants.yaml changes what is not there: {stale}")
    for changed in chain((text.replace(old, new) for old, new in by_hand.items()), () if by_hand_alone else mutants(path)):
        if again is not None and difference(path, changed) not in again:
            continue
        count += 1
        if survives(name, path, changed, entry, patience):
            lived += 1
            yield difference(path, changed)
    print(f"{module}: {count} mutants, {lived} survived, {time.monotonic() - start:.0f} s", flush=True)


def stale(module: str, equivalent: Mapping[str, str]) -> list[str]:
    """Mutants listed as equivalent whose line is no longer in the module."""
    text = " ".join(line.strip() for line in (ROOT / module).read_text().splitlines())
    return [what for what in equivalent if what.split("  ->  ")[0] not in text]


def main() -> int:
    """Print the mutants of each module that survive its tests, without those that are known to be equivalent."""
    parser = argparse.ArgumentParser(description="Change validators one operator at a time, and run their tests.")
    parser.add_argument("words", nargs="*", help="modules whose name contains one of these; all without")
    parser.add_argument("--by-hand", action="store_true", help="only the changes that are written in mutants.yaml")
    parser.add_argument("--again", metavar="FILE", type=Path, help="only what survived in a run before, whose output FILE is")
    parser.add_argument("--list", action="store_true", help="print modules and their tests, and run nothing")
    add_figure(parser)
    given = parser.parse_args()
    table = yaml.safe_load((Path(__file__).parent / "mutants.yaml").read_text())
    chosen = {m: e for m, e in table["modules"].items() if not given.words or any(w in m for w in given.words)}
    if given.list:
        print("\n".join(f"{m}: {' '.join(e['tests'])}" for m, e in chosen.items()))
        return 0
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    sys.path.insert(0, str(ROOT / "tests"))
    again = given.again.read_text() if given.again else None
    bad, numbers = 0, []
    for module, entry in chosen.items():
        for before in entry.get("before", ()):
            where, *call = before.split(":")
            loaded = importlib.import_module(where)
            if call:
                getattr(loaded, call[0])(*call[1:])
        equivalent, before_it = table["equivalent"].get(module, {}), bad
        for what in stale(module, equivalent):
            bad += 1
            print(f"{module}: listed as equivalent, and its line is gone: {what}", flush=True)
        for what in surviving(module, entry, given.by_hand, again):
            if what not in equivalent:
                bad += 1
                print(f"  survives: {what}", flush=True)
        numbers.append(value(module, bad - before_it, "survive"))
    write(given, numbers)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
