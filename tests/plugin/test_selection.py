"""Plugins that are blocked and preferred: by the command line, by scenarios, and what that leaves out is said."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import COMMANDS, SMALL, TASKS, Run
from test_bad_plugins import EVERY_COMMAND, FIELDS, VALIDATOR

from cramlite import Engine, find_scenario, read_scenario
from cramlite.plugin import UserError

Plugin = Callable[[str, str], Path]
Install = Callable[..., None]

STRICT = (
    "from cramlite.plugin import Finding\n"
    "class Strict:\n    name, cost = 'strict', 'facts'\n"
    "    def check(self, candidate):\n        yield Finding('strict', False, 'never')\n"
    "@hookimpl\ndef validators():\n    return [Strict()]\n"
)


@pytest.mark.heavy
def test_a_blocked_file_is_not_loaded(plugin: Plugin, run: Run, spoiled: Callable[..., Path], tmp_path: Path) -> None:
    file = plugin("strict", STRICT)
    assert "strict" not in {i.name for i in Engine(files=[file], blocked=["strict"]).registry.infos}
    assert "strict" in {i.name for i in Engine(files=[file], blocked=["holding"]).registry.infos}
    with pytest.raises(UserError, match="There is no plugin 'strickt'"):
        Engine(files=[file], blocked=["strickt"])
    scenario = spoiled(("robot:", "block: [strict]\nrobot:"))
    line = scenario.read_text().splitlines().index("block: [strict]") + 1
    wins = run("resolve", scenario, "--plugin", file, "--no-report", "--out", tmp_path / "wins")
    assert wins.code == 0, wins.err
    assert f"warning: {scenario}:{line}: leaves out the plugin file '{file}'." in wins.err
    judged = run("resolve", TASKS, "--plugin", file, "--no-report", "--out", tmp_path / "judged")
    assert judged.code == 1 and "strict: never" in judged.err
    assert "leaves out" not in judged.err


@pytest.mark.parametrize("command", COMMANDS)
def test_to_name_a_file_and_block_it_is_a_contradiction(command: str, plugin: Plugin, run: Run) -> None:
    file = plugin("strict", STRICT)
    ran = run(command, *EVERY_COMMAND.get(command, ()), "--plugin", file, "--block", "strict")
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert f"'--plugin {file}' asks for the plugin 'strict', and '--block strict' blocks it" in ran.err


# Shipped validators that are blocked


@pytest.mark.heavy
def test_checks_that_are_left_out_are_said(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "run"
    ran = run("resolve", SMALL, "--block", "physics", "--block", "pushing", "--out", out)
    assert ran.code == 0, ran.err
    clause = "not judged, since blocked: execution, collision, force_peak, commanded_force, grasp_slip"
    assert f"--  {clause}" in ran.out
    left = ["execution", "collision", "force_peak", "commanded_force", "grasp_slip"]
    for file in ("verdict.json", "summary.json"):
        said = json.loads((out / file).read_text())
        assert said["left_out"] == left
        assert not set(left) & {f["validator"] for f in said["findings"]}
    page = (out / "report.html").read_text("utf-8")
    assert page.count(f"<strong class=\"bad\">{clause}</strong>") == 1  # beside "passed all n checks"
    assert page.count(f"<strong class=\"bad\">{clause.capitalize()}.</strong>") == 1
    again = run("resolve", SMALL, "--out", out)
    assert again.code == 2 and "another run (different: blocked" in again.err, "it is not the same as judged by all"
    full = run("resolve", SMALL, "--block", "pushing", "--out", tmp_path / "full")
    assert full.code == 0 and "not judged" not in full.out + (tmp_path / "full" / "report.html").read_text("utf-8")
    assert json.loads((tmp_path / "full" / "verdict.json").read_text())["left_out"] == []


@pytest.mark.heavy
def test_a_scenario_that_leaves_checks_out_says_so_from_python(plugin: Plugin, tmp_path: Path) -> None:
    text = find_scenario("grasp_one_thing").read_text()
    scenario = tmp_path / "grasp.yaml"
    scenario.write_text(text.replace("robot:", "block: [physics, strict]\nrobot:", 1))
    solution = next(Engine(files=[plugin("strict", STRICT)]).resolve(read_scenario(scenario)))
    assert solution.verdict.left_out == ("execution", "collision", "force_peak", "commanded_force", "grasp_slip")
    assert solution.verdict.not_judged.endswith("grasp_slip")


def test_what_stands_for_a_blocked_validator_is_not_left_out(plugin: Plugin) -> None:
    body = VALIDATOR.format(**FIELDS | {"name": "'collision'"})
    instead = Engine(files=[plugin("my_physics", body)], blocked=["physics"])
    assert instead.knowledge.left_out == ("execution", "force_peak", "commanded_force", "grasp_slip")
    assert Engine(files=[plugin("b", VALIDATOR.format(**FIELDS))], blocked=["pushing"]).knowledge.left_out == ()


# Installed packages


@pytest.mark.heavy
def test_prefer_on_the_command_line(plugin: Plugin, run: Run, tmp_path: Path) -> None:
    body = (
        "@hookimpl\ndef resolve_object(designator, belief, context):\n"
        "    return [Grounding('tea', 'said {name}', cost=-5.0)] if designator.name == 'tea' else None\n"
    )
    files = [plugin(name, body.format(name=name)) for name in ("ant", "bee")]
    for prefer, first in (("ant", "ant"), ("bee", "bee")):
        out = tmp_path / prefer
        ran = run(
            "resolve",
            TASKS,
            "--no-report",
            "--out",
            out,
            "--plugin",
            files[0],
            "--plugin",
            files[1],
            "--prefer",
            prefer,
        )
        assert ran.code == 0, ran.err
        assert f"said {first}" in ran.out


def test_blocked_and_preferred_at_once(run: Run) -> None:
    ran = run("tasks", "--block", "holding", "--prefer", "holding")
    assert ran.code == 2
    assert "both blocked and preferred" in ran.err
    with pytest.raises(UserError, match="did you mean 'holding'"):
        Engine(preferred=["holdin"])


@pytest.mark.parametrize("key", ["block", "prefer"])
def test_a_scenario_names_a_plugin_that_there_is_not(key: str, spoiled: Callable[..., Path], run: Run) -> None:
    path = spoiled(("robot:", f"{key}: [urscrpt]\nrobot:"))
    ran = run("check", path)
    assert ran.code == 2
    line = path.read_text().splitlines().index(f"{key}: [urscrpt]") + 1
    assert f"{path}:{line}: there is no plugin 'urscrpt' to {key}; did you mean 'urscript'?" in ran.err


def test_a_scenario_blocks_a_plugin(spoiled: Callable[..., Path], run: Run) -> None:
    ran = run("check", spoiled(("robot:", "block: [urscript]\nrobot:")))
    assert ran.code == 2
    assert "There is no backend 'urscript'" in ran.err
