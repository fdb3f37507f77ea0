"""The report where nothing was proven: the refusals are the main thing, and the exit code stays 1."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path

import pytest
from conftest import Run
from helpers.page_checks import faults

from cramlite import Engine, Finished, Trace, find_scenario, read_scenario
from cramlite.base.run_directory import RunDirectory
from cramlite.report import write_page

NEVER = """
from cramlite.plugin import Finding, Validator, hookimpl

class Never:
    name, cost = "never", "rollout"
    def check(self, candidate):
        yield Finding("never", False, "no weather for it", 3.0, 2.0, "m")

@hookimpl
def validators():
    return [Never()]
"""
ONLY_PROVEN = """
from cramlite.plugin import ReportSection, hookimpl

@hookimpl
def report_sections():
    return [ReportSection("In one line", 5, lambda done: str(done.solution.plan))]
"""


def titles(page: str) -> list[str]:
    return re.findall(r"<h2[^>]*>(.*?)</h2>", page)


def test_without_any_program_the_refusals_are_the_page(tmp_path: Path, run: Run) -> None:
    done = run("resolve", "tasks/opening_blocked", "--out", tmp_path / "run")
    assert done.code == 1
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert faults(page) == []
    assert titles(page) == ["Summary", "Why nothing was proven", "What collides with what"]
    assert "nothing ran" in page and "Proven" not in page
    entries = json.loads((tmp_path / "run" / "trace.json").read_text())["entries"]
    for entry in entries:
        if entry["outcome"] in ("refused", "impossible"):
            assert entry["reason"] in unescape(page)
    assert "Nearest miss: handle(drawer)" in page
    drawn = re.findall(r'<figure><img src="(data:image/webp[^"]+)"[^>]* alt="([^"]*)"', page)
    assert "drawer and post in the state that was refused" in [alt for _, alt in drawn]
    count = sum(entry.get("collision") is not None for entry in entries)
    assert count == 1 and "1 alternative was refused since two bodies" in page


@pytest.mark.heavy
def test_a_run_that_was_refused_is_shown(tmp_path: Path, run: Run) -> None:
    plugins = [tmp_path / "never.py", tmp_path / "one_line.py"]
    for path, text in zip(plugins, (NEVER, ONLY_PROVEN), strict=True):
        path.write_text(text)
    scenario = tmp_path / "take.yaml"
    scenario.write_text(find_scenario("grasp_one_thing").read_text() + "budget: {proofs: 1}\n")
    files = [a for p in plugins for a in ("--plugin", p)]
    done = run("resolve", scenario, "--out", tmp_path / "run", *files)
    assert done.code == 1, done.err
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert faults(page) == []
    assert titles(page)[:4] == ["Summary", "Why nothing was proven", "The run", "What the validators found"]
    assert titles(page).index("What collides with what") > titles(page).index("What the validators found")
    assert "One complete program ran; it is shown below as it failed" in page
    checks = page.split('class="stack checks"')[1]
    assert checks.index("no weather for it") < checks.index("✓")
    assert "In one line" not in page
    assert not (tmp_path / "run" / "program.script").exists()


def test_no_report_means_none(tmp_path: Path, run: Run) -> None:
    assert run("resolve", "tasks/opening_blocked", "--no-report", "--out", tmp_path / "run").code == 1
    assert not (tmp_path / "run" / "report.html").exists()


def test_the_demonstration_is_shown_without_a_program(tmp_path: Path) -> None:
    engine, scenario = Engine(), read_scenario(find_scenario("fetch_from_hanger"))
    setting = engine.setting(scenario)
    episode = engine.read_episode(scenario.resolve_path(scenario.spec.demonstration or ""))
    trace = Trace()
    node = trace.add(0, "object_1", "cram:TeaBox", "asked", "engine", "", kind="object")
    trace.add(node, "object_1", "floor", "impossible", "objects", "nothing has a vrps:Hole", kind="object")
    run = RunDirectory(tmp_path, {})
    write_page(Finished(engine, run, setting, trace, None, engine.interpret(episode), episode))
    page = (tmp_path / "report.html").read_text("utf-8")
    assert faults(page) == []
    assert titles(page) == ["Summary", "Why nothing was proven", "The demonstration", "What it may mean"]
    assert '<span class="t1 unreached"' in page
    assert "nothing has a vrps:Hole" in page
    assert not engine.registry.faults


def test_a_reason_that_several_programs_failed_for_is_said_once(tmp_path: Path) -> None:
    engine, trace, reason = Engine(), Trace(), "'tin' got 30 mm away from the hand"
    for number in (1, 2, 3):
        trace.candidate = number
        trace.add(0, "program", "3 steps", "failed", "engine", reason if number < 3 else "'tin' fell", kind="proof")
    setting = engine.setting(read_scenario(find_scenario("grasp_one_thing")))
    write_page(Finished(engine, RunDirectory(tmp_path, {}), setting, trace, None, None, None))
    ends = re.findall(r'<p class="end">(.*?)</p>', (tmp_path / "report.html").read_text("utf-8"))
    assert [sum(said in unescape(e) for e in ends) for said in (reason, "same reason as candidate 1", "'tin' fell")] == [1, 1, 1], ends


def test_a_page_needs_a_directory(tmp_path: Path) -> None:
    with pytest.raises(AssertionError):
        Finished(Engine(), RunDirectory(tmp_path, {}), None, Trace(), None, None, None).solution  # type: ignore[arg-type]  # noqa: B018
