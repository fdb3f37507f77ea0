"""Plugins that break while they are asked are isolated and named; those that clash are refused; two engines share nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import SMALL, TASKS, Run
from msgspec.structs import replace

from cramlite import Engine, PluginError, read_scenario
from cramlite.plugin import Unresolvable, UserError
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.entry_points import entry_points
from cramlite.plugin.registry import Registry

Plugin = Callable[[str, str], Path]

SILENT = "@hookimpl\ndef resolve_object(designator, belief, context):\n    "
BROKEN = {
    "hook": (f"{SILENT}raise RuntimeError('no camera')", "RuntimeError: no camera"),
    "yield": (f"{SILENT}yield Refused('x', 'y')\n    raise RuntimeError('no camera')", "RuntimeError: no camera"),
    "exit": (f"{SILENT}raise SystemExit(0)", "SystemExit: 0"),
    "exit while yielding": (f"{SILENT}yield Refused('x', 'y')\n    raise SystemExit(0)", "SystemExit: 0"),
}


@pytest.mark.heavy
@pytest.mark.parametrize("when", BROKEN)
def test_a_broken_plugin_does_not_stop_the_others(when: str, plugin: Plugin, run: Run, tmp_path: Path) -> None:
    body, said = BROKEN[when]
    ran = run("resolve", SMALL, "--no-report", "--out", tmp_path / "run", "--plugin", plugin("camera", body))
    assert ran.code == 0, ran.err
    assert "Solved" in ran.out
    assert "warning: plugin 'camera'" in ran.err
    assert f"hook resolve_object, at something: {said}" in ran.err
    assert "Traceback" not in ran.err
    assert "camera.py:" in ran.err


NO_LIST = {
    "resolve_object(designator, belief, context)": "warning: plugin 'camera', hook resolve_object, at something: resolve_object gave 5",
    "validators()": "'{file}' cannot be used: hook validators: validators gave 5",
}


@pytest.mark.parametrize("hook", NO_LIST)
def test_who_answers_with_no_list_is_told_so(hook: str, plugin: Plugin, run: Run, tmp_path: Path) -> None:
    file = plugin("camera", f"@hookimpl\ndef {hook}:\n    return 5\n")
    ran = run("resolve", SMALL, "--no-report", "--out", tmp_path / "run", "--plugin", file)
    assert f"{NO_LIST[hook].format(file=file)}; it must give a list, empty where there is nothing, or yield" in ran.err


def test_who_ends_the_process_when_asked_what_it_declares_is_named(plugin: Plugin, run: Run) -> None:
    file = plugin("camera", "@hookimpl\ndef object_models():\n    raise SystemExit(0)\n")
    ran = run("check", SMALL, "--plugin", file)
    assert ran.code == 2
    assert "hook object_models: SystemExit: 0 (camera.py:6)" in ran.err


def test_who_breaks_when_told_of_a_step_is_named_with_the_program(plugin: Plugin, run: Run, tmp_path: Path) -> None:
    file = plugin("camera", "@hookimpl\ndef on_step(step, candidate):\n    raise SystemExit(0)\n")
    ran = run("resolve", SMALL, "--no-report", "--out", tmp_path / "run", "--plugin", file)
    assert ran.code == 0
    assert "plugin 'camera', hook on_step, at grasp_one_thing: SystemExit: 0" in ran.err


def test_a_broken_plugin_without_a_solution_is_exit_3(
    plugin: Plugin, run: Run, spoiled: Callable[..., Path], tmp_path: Path
) -> None:
    far = spoiled(("[0.87, 0, 0.45]", "[2.87, 0, 0.45]"))
    ran = run("resolve", far, "--no-report", "--out", tmp_path / "run", "--plugin", plugin("camera", BROKEN["hook"][0]))
    assert ran.code == 3
    assert "plugin 'camera'" in ran.err
    assert "hook resolve_object" in ran.err
    assert "Traceback" not in ran.err


def test_plugins_lists_a_fault(plugin: Plugin, run: Run) -> None:
    ran = run("plugins", "--plugin", plugin("camera", "raise RuntimeError('no camera')"))
    assert ran.code == 3
    assert "NOT LOADED: RuntimeError: no camera (camera.py:4)" in ran.out
    assert run("plugins").code == 0


def test_a_wrong_signature_is_named(plugin: Plugin) -> None:
    body = "@hookimpl\ndef resolve_object(designator, beleif):\n    return None\n"
    (fault,) = Registry((plugin("wrong", body),), strict=False).faults
    assert fault.plugin == "wrong"
    assert "beleif" in fault.error


def test_a_hook_that_does_not_exist_is_named(plugin: Plugin) -> None:
    body = "@hookimpl\ndef resolve_objct(designator):\n    return None\n"
    (fault,) = Registry((plugin("wrong", body),), strict=False).faults
    assert "resolve_objct" in fault.error


TASK = """
class Grab(TaskType):
    task = "{name}"
    aliases = ({alias!r},)
    def decompose(self, action, belief):
        return []

@hookimpl
def task_types():
    return [Grab()]
"""


@pytest.mark.parametrize(("name", "alias"), [("soma:Grasping", "Grab"), ("x:Grab", "Grasp")])
def test_two_plugins_with_one_task_name(name: str, alias: str, plugin: Plugin, run: Run) -> None:
    ran = run("tasks", "--plugin", plugin("grab", TASK.format(name=name, alias=alias)))
    assert ran.code == 3
    assert "'grab'" in ran.err
    assert "'grasping'" in ran.err
    assert "--block" in ran.err


def test_two_plugins_with_different_names_live_together(plugin: Plugin, run: Run) -> None:
    assert "x:Grab" in run("tasks", "--plugin", plugin("grab", TASK.format(name="x:Grab", alias="Grab"))).out


ANSWER = "@hookimpl\ndef resolve_object(designator, belief, context):\n    return [Grounding('{name}', '{name}')]\n"


def test_preferred_plugins_are_asked_first_and_files_before_others(plugin: Plugin) -> None:
    files = tuple(plugin(name, ANSWER.format(name=name)) for name in ("zebra", "ant"))
    for preferred, expected in (((), ["zebra", "ant"]), (("ant",), ["ant", "zebra"])):
        registry = Registry(files, preferred=preferred)
        answers = registry.alternatives("resolve_object", "cup", belief=None, context=None)
        assert [next(answers)[0], next(answers)[0]] == expected


def test_three_answers(plugin: Plugin) -> None:
    file = plugin(
        "three",
        "@hookimpl\ndef resolve_object(designator, belief, context):\n"
        "    if designator == 'mine': return []\n"
        "    if designator == 'impossible': raise Unresolvable('too far', ('cup',))\n"
        "    if designator == 'misuse': raise UserError('this file is empty')\n",
    )
    own = ("arms", "objects")
    registry = Registry((file,), blocked=own)
    ask = {"belief": None, "context": None}
    assert list(registry.alternatives("resolve_object", "other", **ask)) == []
    ((_, answers),) = registry.alternatives("resolve_object", "mine", **ask)
    assert list(answers) == []  # type: ignore[arg-type]
    ((_, answer),) = registry.alternatives("resolve_object", "impossible", **ask)
    assert isinstance(answer, Unresolvable)
    assert answer.because == ("cup",)
    with pytest.raises(UserError, match="empty"):
        list(registry.alternatives("resolve_object", "misuse", **ask))
    assert registry.faults == []


def test_two_engines_share_nothing(plugin: Plugin) -> None:
    file = plugin("grab", TASK.format(name="x:Grab", alias="Grab"))
    first, second = Engine(files=[file]), Engine(blocked=["holding"])
    assert "x:Grab" in first.knowledge.tasks
    assert "x:Grab" not in second.knowledge.tasks
    assert "soma:Holding" in first.knowledge.tasks
    assert "soma:Holding" not in second.knowledge.tasks
    first.registry.fault("grab", "task_types", "", ValueError("x"))
    assert second.registry.faults == []


def test_no_simulator_is_the_users_choice() -> None:
    with pytest.raises((UserError, PluginError)):
        Engine(blocked=["mujoco"]).setting(read_scenario(TASKS))


def test_nothing_is_proven_without_a_validator_that_cannot_be_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    def cut_off() -> None:
        raise ImportError("cannot import name 'box_around'")

    found = [replace(p, load=cut_off) if p.name == "bystanders" else p for p in entry_points()]
    monkeypatch.setattr("cramlite.plugin.registry.entry_points", lambda: found)
    with pytest.raises(PluginError, match=r"A validator is missing.*'bystanders'.*box_around.*--block bystanders"):
        _ = Engine().knowledge.validators
    blocked = Engine(blocked=["bystanders"]).knowledge
    assert "bystanders" not in {v.name for v in blocked.validators}


def test_nothing_is_proven_without_a_validator_that_is_declared_wrong(plugin: Plugin) -> None:
    file = plugin("half", "@hookimpl\ndef validators():\n    return [1 / 0]\n")
    registry = Registry((file,), strict=False)
    with pytest.raises(PluginError, match=r"A validator is missing.*'half'.*ZeroDivisionError"):
        _ = Knowledge(registry).validators
