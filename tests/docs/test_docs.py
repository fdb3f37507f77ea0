"""The documentation is run: commands, snippets and scenario files of README.md and docs/ work as they are written.

What a comment before a fenced block means:

- ``<!-- file: NAME -->``: the block is a file; it is written into the page's folder before what follows runs.
- ``<!-- exit: 1 -->``: the last command of the block ends with this code; 0 if nothing is said.
- ``<!-- output -->``: every line of the block is part of what the last command printed; "..." stands for anything.
- ``<!-- command: NAME -->``: continuous integration runs this one from scratch (.ci/run), so it is left out here.
- ``<!-- rule -->``: a rule file, read by ``load_rules``.
- ``<!-- not run -->``: shown only, with the reason in the text.
"""

from __future__ import annotations

import argparse
import importlib.util
import inspect
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import pytest
from msgspec.structs import fields
from pydantic import BaseModel

from cramlite import Budget, Engine, TaskSpec, read_scenario
from cramlite.base.quantities import Force, Time
from cramlite.base.spec import Spec
from cramlite.cli.main import main
from cramlite.model import Pose
from cramlite.plugin import Angle, Length, Mass, hookspecs, load_yaml
from cramlite.plugin.registry import Registry
from cramlite.scenario import error_spec, scenario

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
REFERENCE = ROOT / "docs" / "reference"
DOORS = ("python/cramlite", "python/plugin", "python/model", "python/testing")
GENERATED = {REFERENCE / f"{name}.md" for name in ("errors", "locations", "predicates", "python", *DOORS, "schema")}
"""Pages that docs/site/generated.py writes when the site is built."""
_BLOCK = re.compile(r"(?:<!-- ([a-z ]+)(?:: ([^\n]*?))? -->\n\n?)?^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and the comment before it."""

    language: str
    text: str
    mark: str
    value: str
    line: int


def blocks(page: Path) -> Iterator[Block]:
    text = page.read_text()
    for m in _BLOCK.finditer(text):
        yield Block(m[3], m[4], m[1] or "", m[2] or "", text[: m.start(4)].count("\n"))


def runs(block: Block) -> bool:
    command = block.language == "bash" and re.search(r"^(cramlite|pytest) ", block.text, re.MULTILINE)
    return block.mark not in ("command", "not run") and bool(command or block.language in ("python", "yaml"))


WITH_CODE = [p for p in PAGES if any(runs(b) for b in blocks(p))]
HEAVY = {
    "docs/how-to/before_a_real_arm.md", "docs/how-to/behaviour_tree.md", "docs/how-to/drive_a_robot.md", "docs/how-to/embed.md",
    "docs/how-to/judge_a_program.md", "docs/how-to/benchmarks.md", "docs/how-to/look_at_a_run.md", "docs/how-to/many_machines.md",
    "docs/how-to/mcp.md", "docs/how-to/other_languages.md", "docs/how-to/own_recording.md", "docs/how-to/own_robot.md",
    "docs/how-to/own_scene.md", "docs/how-to/planner.md", "docs/how-to/test_programs.md", "docs/reference/tasks.md",
    "docs/tutorial/scenario.md", "docs/tutorial/wiping.md",
}  # fmt: skip
"""Pages whose commands take longer than those of all others together: they prove several programs each."""


def named(page: Path) -> Any:
    """A page as a parameter of tests, called by its path."""
    name = page.relative_to(ROOT).as_posix()
    return pytest.param(page, id=name, marks=pytest.mark.heavy if name in HEAVY else ())


# What runs


@pytest.mark.parametrize("page", [named(p) for p in WITH_CODE])
def test_a_page_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {"__name__": "snippet"}
    said = ""
    for block in blocks(page):
        where = f"{page.relative_to(ROOT)}:{block.line}"
        if block.mark == "file":
            Path(block.value).write_text(block.text)
        if block.mark == "output":
            said_there(block.text, said, where)
        elif runs(block):
            said = run(block, space, where, capfd) or said


def run(block: Block, space: dict[str, Any], where: str, capfd: pytest.CaptureFixture[str]) -> str:
    """Run one block; return its output."""
    capfd.readouterr()
    if block.language == "bash":
        lines = block.text.replace("\\\n", " ").splitlines()
        codes = [command(shlex.split(c, comments=True)) for c in lines if re.match("(cramlite|pytest) ", c)]
        printed = "".join(capfd.readouterr())
        assert codes[-1] == int(block.value if block.mark == "exit" else 0), f"{where}: {printed}"
        return printed
    if block.language == "yaml":
        read_yaml(block, where)
    elif not block.value.endswith(".py"):
        exec(compile("\n" * block.line + block.text, where, "exec"), space)
    return "".join(capfd.readouterr())


def command(words: list[str]) -> int:
    """The exit code of one command; tests run in a process of their own."""
    if words[0] == "cramlite":
        return main(words[1:])
    plain = ("-p", "no:cacheprovider", "-p", "no:xdist")
    return subprocess.run([sys.executable, "-m", *words, *plain], check=False).returncode


def read_yaml(block: Block, where: str) -> None:
    """Scenarios are read as scenarios, rules as rules."""
    path = Path(block.value or f"block_{block.line}.yaml")
    path.write_text(block.text)
    if block.mark == "rule":
        from cramlite.interpretation.rules import load_rules
        from cramlite_plugins.predicates.relations import all_predicates

        assert load_rules([path], all_predicates(), Engine().knowledge.taxonomy), where
    elif "scenario" in (load_yaml(path) or ()):
        assert read_scenario(path).name, where


def said_there(wanted: str, said: str, where: str) -> None:
    for line in wanted.splitlines():
        pattern = ".*".join(re.escape(part) for part in line.strip().split("..."))
        assert re.search(pattern, said), f"{where}: nothing printed this: {line}\nbut this:\n{said}"


def test_a_wrong_output_is_noticed() -> None:
    said_there("Solved: ...\n", "Solved: Grasping", "here")
    with pytest.raises(AssertionError, match="nothing printed this"):
        said_there("Solved: Pouring\n", "Solved: Grasping", "here")


def test_the_tutorials_task_is_small() -> None:
    page = list(blocks(ROOT / "docs" / "tutorial" / "wiping.md"))
    (module,) = [b for b in page if b.value == "wiping.py"]
    assert len(module.text.splitlines()) <= 40


# Links


def anchors(page: Path) -> set[str]:
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    heads = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if not re.match(r"[a-z]+:", target):
            name, _, anchor = target.partition("#")
            there = (page.parent / name).resolve() if name else page
            if there in GENERATED:  # its anchors are checked by mkdocs build --strict
                continue
            assert there.exists(), f"{page}: no file '{target}'"
            assert not anchor or anchor in anchors(there), f"{page}: no heading '{target}'"


# Tables that are checked against the code


def text_of(name: str) -> str:
    """The text of a page of the reference and of the pages in the folder of its name."""
    return "\n".join(p.read_text() for p in (REFERENCE / f"{name}.md", *sorted((REFERENCE / name).glob("*.md"))))


def table_under(name: str, heading: str) -> list[list[str]]:
    """The cells of the first table under a heading of ``text_of(name)``, without its head."""
    parts = re.split(r"^#+ (.*)$", text_of(name), flags=re.MULTILINE)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    assert heading in sections, f"{name} has no heading '{heading}'; it has {list(sections)}"
    table = re.search(r"(?:^\|.*\n)+", sections[heading], re.MULTILINE)
    rows = table[0].splitlines()[2:] if table else []
    return [[c.strip().replace("\\|", "|") for c in re.split(r"(?<!\\)\|", row)[1:-1]] for row in rows]


def same(table: list[list[str]], wanted: list[list[str]], what: str) -> None:
    """The first cells of every row are as the code has them."""
    width = len(wanted[0])
    rows = "\n".join("| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in wanted)
    assert [row[:width] for row in table] == wanted, f"{what} should begin with these cells:\n{rows}"


SPECS = {
    "The file": scenario.ScenarioSpec,
    "robot": scenario.RobotSpec,
    "gripper": scenario.GripperSpec,
    "things": scenario.ThingSpec,
    "at": scenario.PoseSpec,
    "hangs_on": scenario.HangSpec,
    "vary": scenario.VarySpec,
    "objects": scenario.ObjectSpec,
    "camera": scenario.CameraSpec,
    "intrinsics": scenario.IntrinsicsSpec,
    "unknown_error": scenario.UnknownErrorSpec,
    "faults": scenario.FaultSpec,
    "late": scenario.LateSpec,
    "then": scenario.ThenSpec,
    "record": scenario.RecordSpec,
    "physics": scenario.PhysicsSpec,
    "world": scenario.WorldFileSpec,
    "joints": scenario.JointSpec,
    "limits": scenario.LimitsSpec,
    "proof": error_spec.ProofSpec,
    "errors": error_spec.ErrorSpec,
    "errors of things": error_spec.ThingErrorSpec,
    "hand_eye": error_spec.PoseErrorSpec,
}
KINDS = {Length: "length", Angle: "angle", Mass: "mass", Force: "force", Time: "time"}
PLAIN = {str: "text", float: "number", int: "whole number", bool: "true or false", Any: "anything"}


def kind_of(hint: Any) -> str:
    """A type in words."""
    if hint in KINDS or hint in PLAIN:
        return {**KINDS, **PLAIN}[hint]
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return "task" if arguments[0] is TaskSpec else kind_of(arguments[0])
    if origin in (UnionType, Union):
        return kind_of(next(a for a in arguments if a is not type(None)))
    if origin is Literal:
        return " or ".join(map(str, arguments))
    if origin is tuple:
        return (
            f"list of {kind_of(arguments[0])}"
            if arguments[-1] is Ellipsis
            else f"{len(arguments)} x {kind_of(arguments[0])}"
        )
    if origin is list:
        return f"list of {kind_of(arguments[0])}"
    if origin is dict:
        return f"mapping to {kind_of(arguments[1])}"
    return next((name for name, model in SPECS.items() if model is hint), "declared feature")


def default_of(value: Any) -> str:
    if isinstance(value, BaseModel):
        return "its defaults"
    if isinstance(value, tuple | list | dict):
        return "[" + ", ".join(f"{v:g}" if isinstance(v, float) else f'"{v}"' for v in value) + "]" if value else "none"
    return "none" if value in (None, "") else f"{value:g}" if isinstance(value, float) else str(value)


@pytest.mark.parametrize("heading", SPECS)
def test_every_key_of_scenario_files_is_documented(heading: str) -> None:
    model = SPECS[heading]
    hints = get_type_hints(model, include_extras=True)
    rows = []
    for name, field in model.model_fields.items():
        default = "required" if field.is_required() else default_of(field.get_default(call_default_factory=True))
        rows.append([f"`{field.alias or name}`", kind_of(hints[name]), default])
    same(table_under("scenarios", heading), rows, f"the table '{heading}'")


def test_no_model_of_scenario_files_is_left_out() -> None:
    written = {m for p in (scenario, error_spec) for m in vars(p).values() if isinstance(m, type) and issubclass(m, Spec)}
    assert written - {Spec} == set(SPECS.values())


def test_budgets_are_documented() -> None:
    rows = [[f"`{f.name}`", "whole number", str(f.default)] for f in fields(Budget)]
    same(table_under("scenarios", "budget"), rows, "the table 'budget'")


def _tables() -> ModuleType:
    spec = importlib.util.spec_from_file_location("tables", ROOT / "docs" / "site" / "tables.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TABLES = _tables()


def test_every_table_that_is_written_from_the_code_has_its_place_and_is_of_today() -> None:
    marks = [(p, (kind, name)) for p in PAGES for _, kind, name in TABLES.MARK.findall(p.read_text())]
    assert [p.name for p in PAGES if TABLES.filled(p.read_text()) != p.read_text()] == [], "run python docs/site/tables.py"
    assert sorted(m for _, m in marks) == sorted(TABLES.everything())
    for page, (kind, name) in marks:
        found = TABLES.table(kind, name).splitlines()
        assert len(found) > 2 and len({re.sub(r"\\\|", "", row).count("|") for row in found}) == 1, (page, kind, name)
        assert kind not in ("options", "model") or f"\n## {name}\n" in page.read_text()


def test_a_table_of_nothing_is_refused() -> None:
    with pytest.raises(KeyError):
        TABLES.filled("<!-- table: options fly -->")
    assert "| `file` |" in TABLES.filled("# check\n\n<!-- table: options check -->\n")


def test_every_parameter_of_an_object_model_that_needs_words_has_some() -> None:
    from cramlite_plugins.objects.products_and_fixtures import MODELS

    page = text_of("scenarios")
    for name, function in MODELS.items():
        own = [p for p in inspect.signature(function).parameters.values() if p.name not in ("name", "pose")]
        assert set(TABLES.explained(function)) <= {p.name for p in own}, name
        if all(p.default is not p.empty for p in own):
            assert function("x", Pose()).type in page


def _commands() -> dict[str, argparse.ArgumentParser]:
    return dict(TABLES.commands())


@pytest.mark.parametrize("command", _commands())
def test_every_option_is_explained(command: str) -> None:
    """Those that every command takes stand once, under "Common options"."""
    actions = _commands()[command]._actions[1:]
    common = [row[0].strip("`") for row in table_under("cli", "Common options")]
    assert [TABLES.argument(a) for a in actions[: len(common)]] == common
    assert [TABLES.argument(a) for a in actions if len(a.help or "") < 5] == []


def test_no_command_is_documented_that_there_is_not() -> None:
    documented = re.findall(r"^## (\w+)$", text_of("cli"), re.MULTILINE)
    assert sorted(documented) == sorted(_commands())


@pytest.mark.parametrize("page", PAGES[1:], ids=lambda p: p.relative_to(ROOT).as_posix())
def test_commands_that_a_page_names_exist(page: Path) -> None:
    shell = "\n".join(b.text for b in blocks(page) if b.language == "bash")
    named = re.findall(r"^cramlite (\w+)", shell, re.MULTILINE) + re.findall(r"`cramlite (\w+)", page.read_text())
    assert set(named) <= {*_commands(), "COMMAND"}


def test_the_urscript_that_is_documented_is_the_one_that_runs() -> None:
    from cramlite_plugins.ur_controller.functions import NAMES
    from cramlite_plugins.ur_controller.urscript.builtins import PURE

    page = (REFERENCE / "robot_code.md").read_text()
    language, _, missing = page.partition("### What the model does not do")
    assert {n for n in (*NAMES, *PURE) if f"`{n}`" not in language} == set()
    absent = {"get_target_waypoint", "servoc"}
    assert all(f"`{n}`" in missing for n in absent) and not absent & {*NAMES, *PURE}


# Hooks

HOOKS = [name for name, value in vars(hookspecs).items() if hasattr(value, "cramlite_spec")]


def example(hook: str) -> str:
    text = (REFERENCE / "hooks.md").read_text()
    found = re.search(rf"^### {hook}$(.*?)(?=^##)", text + "\n## end", re.MULTILINE | re.DOTALL)
    assert found, f"hooks.md has no heading '### {hook}'"
    return found[1]


@pytest.mark.parametrize("hook", HOOKS)
def test_every_hook_is_documented_with_its_arguments(hook: str) -> None:
    function = getattr(hookspecs, hook)
    signature = f"{hook}{inspect.signature(function)}".replace("'", "")
    assert f"`{signature}`" in example(hook), f"hooks.md should say: `{signature}`"


def test_every_example_of_a_hook_loads_as_a_plugin(tmp_path: Path) -> None:
    files = []
    for hook in HOOKS:
        code = re.search(r"```python\n(.*?)```", example(hook), re.DOTALL)
        assert code, f"hooks.md has no example of '{hook}'"
        files.append(tmp_path / f"example_{hook}.py")
        files[-1].write_text(code[1])
    registry = Registry(tuple(files))
    assert not [f for f in registry.faults if f.plugin.startswith("example_")]
    hooks = {i.name: i.hooks for i in registry.infos}
    assert all(hook in hooks[f"example_{hook}"] for hook in HOOKS)


def test_an_example_with_a_wrong_argument_is_refused(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.py"
    wrong.write_text("from cramlite.plugin import hookimpl\n\n@hookimpl\ndef on_step(stepp): ...\n")
    assert [f.plugin for f in Registry((wrong,), strict=False).faults if f.plugin == "wrong"] == ["wrong"]


TOGETHER = """
scenario: together
tasks:
  - {task: Grasping, Patient: tin}
  - {task: Holding, Patient: tin}
  - {task: PickingUp, Locatum: tin}
  - Pausing
objects: {tin: {types: [cram:Tin]}}
robot: {type: ur5e_slow}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, 0]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: beans, model: block, type: cram:Tin, with: {size: [50 mm, 50 mm, 90 mm]}, at: {position: [0.45, 0.15, 46 mm]}}
  - {name: soup, model: drum, with: {radius: 30 mm}, at: {position: [0.45, -0.25, 51 mm]}}
"""


@pytest.mark.heavy
def test_the_examples_of_all_hooks_work_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("together.yaml").write_text(TOGETHER)
    arguments = ["resolve", "together.yaml", "--out", "run", "--no-report"]
    for hook in HOOKS:
        code = re.search(r"```python\n(.*?)```", example(hook), re.DOTALL)
        Path(f"example_{hook}.py").write_text(code[1] if code else "")
        arguments += ["--plugin", f"example_{hook}.py"]
    assert main(arguments) == 0, capfd.readouterr()
    said = "".join(capfd.readouterr())
    assert "Solved: Grasping -> Holding -> PickingUp -> Pausing" in said
    assert "tin (cram:Tin) = beans: weighs 0.20 kg" in said
    assert "short_enough: took" in said and "times as fast as real time" in said
    assert "Wait 2.Holding/hold" in said and "warning" not in said
    trace = Path("run/trace.json").read_text()
    assert "half a second is enough" in trace
    assert "sleep(0.5" in Path("run/program.script").read_text()
