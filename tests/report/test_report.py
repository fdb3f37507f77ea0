"""The report of the shipped scenario: what is on it, and that nothing on it can do harm."""

from __future__ import annotations

import base64
import json
import re
from datetime import date
from html import escape
from pathlib import Path

import numpy as np
import pytest
from conftest import Proven
from helpers.page_checks import faults
from msgspec.structs import replace

from cramlite import Engine, Goal, Solution, TaskSpec, Trace, find_scenario, read_scenario
from cramlite.base.run_directory import RunDirectory
from cramlite.model import Plan
from cramlite.plugin import html_template
from cramlite.report import write_report
from cramlite.version import VERSION
from cramlite_plugins.reports.before_and_after import things_named
from cramlite_plugins.reports.shared import anchor

SUBSTITUTE = '<span class="warn">substitute</span>'
HOSTILE = "<script>alert('x')</script>\"onload=\"y"
BROKEN = """
from cramlite.plugin import ReportSection, hookimpl

def render(done):
    raise ValueError("no <b>ink</b> left")

@hookimpl
def report_sections():
    return [ReportSection("Weather", 15, render), ReportSection("Extra", 16, lambda done: f"<p id=extra>{done.solution.number}</p>")]
"""


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


@pytest.fixture(scope="module")
def solution(proven: Proven) -> Solution:
    return proven("fetch_from_hanger")


def written(path: Path, solution: Solution, engine: Engine) -> str:
    write_report(RunDirectory(path, {"test": 1}), solution, engine)
    return (path / "report.html").read_text("utf-8")


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory, solution: Solution, engine: Engine) -> str:
    return written(tmp_path_factory.mktemp("run"), solution, engine)


def test_every_section_is_there(page: str, engine: Engine) -> None:
    sections = [section for _, section in engine.registry.collect("report_sections")]
    assert len(sections) >= 7
    refused = {"Why nothing was proven", "What collides with what"}
    elsewhere = {"What it saw", "The first execution", "Proof under doubt", *refused}  # camera; real world; twins
    for section in sections:
        assert (f">{escape(section.title)}</h2>" in page) == (section.title not in elsewhere)
    assert not engine.registry.faults


def test_the_first_screen_says_what_was_asked_and_what_came_of_it(page: str, solution: Solution) -> None:
    """Title, question, verdict, date and version in the header; pictures of start and end are the first section."""
    top, first = page.split("</header>")[0], page.split("<section")[1]
    assert f"<h1>{escape(solution.setting.title)}</h1>" in top and solution.setting.title
    assert "Asked: what the demonstration shows" in top
    assert re.search(r'class="outcome good">Program proven', top)
    assert date.today().isoformat() in top and f"cramlite {VERSION}" in top
    assert "Before and after" in first and first.count("data:image/webp") == 4  # start, run with its still, end


def test_the_question_is_the_goal_that_was_resolved_and_not_the_one_of_the_scenario(engine: Engine) -> None:
    scenario = read_scenario(find_scenario("fetch_from_hanger"))
    setting = engine.setting(scenario)
    for goal, said in ((Goal(("coffee in basket",)), "coffee in basket"), (TaskSpec(task="ParkArms"), "ParkArms")):
        found = next(engine.candidates(goal, setting=setting)).setting
        assert (found.title, found.asked) == ("", said)


def test_the_things_that_tasks_name_are_what_pictures_are_fitted_to(solution: Solution, engine: Engine) -> None:
    """Seen from nearby they take more of the picture; every one is in it, at the start and at the end."""
    rollout = solution.candidate.rollout
    assert rollout is not None
    named = things_named(solution)
    assert named and set(named) <= {t.name for t in rollout.world.things}
    simulator, robots = engine.knowledge.simulator, engine.knowledge.robots_of(rollout.world)
    usual, fitted = (simulator.picture(rollout, 0, robots, (120, 90), about) for about in ((), named))
    assert np.abs(usual.astype(float) - fitted).mean() > 5, "the view is the usual one"


def test_summary_names_groundings_and_findings(page: str, solution: Solution) -> None:
    for finding in solution.verdict.findings:
        assert escape(finding.reason, quote=False).split("'")[0] in page
    assert page.count(SUBSTITUTE) == 1
    for entity in solution.candidate.bindings.values():
        assert not isinstance(entity, str) or f"<strong>{entity}</strong>" in page


def test_what_is_of_the_class_asked_for_is_no_substitute(tmp_path: Path, solution: Solution, engine: Engine) -> None:
    """Whatever the trace says in words: the class decides."""
    plan, candidate = solution.plan, solution.candidate
    things = {o.name: str(candidate.bindings[o.name]) for o in plan.objects if o.part_of is None}
    own = tuple(replace(o, types=(candidate.belief.thing(things[o.name]).type,)) if o.name in things else o for o in plan.objects)
    same = replace(solution, candidate=replace(candidate, plan=replace(plan, objects=own)))
    assert SUBSTITUTE not in written(tmp_path, same, engine)


def test_refused_alternatives_are_listed_with_reasons(page: str, solution: Solution) -> None:
    refused = [e for e in solution.trace.entries if e.outcome in ("refused", "impossible")]
    assert refused
    text = re.sub(r"&#39;|&#x27;", "'", page)
    for entry in refused:
        assert escape(entry.reason, quote=False) in text


def test_each_line_of_the_program_leads_to_a_decision(page: str, solution: Solution) -> None:
    assert len(re.findall(r' id="L\d+"', page)) == len(solution.code.splitlines())
    links = re.findall(r'class="from" href="#([^"]+)"', page)
    assert len(links) == len(solution.candidate.code.origins)  # type: ignore[union-attr]
    for link in links:
        assert page.count(f' id="{link}"') == 1


def test_each_motion_leads_to_its_lines(page: str, solution: Solution) -> None:
    code = solution.candidate.code
    assert code is not None
    for line, origin in code.origins.items():
        decision = page.split(f' id="{anchor(origin)}"')[1].split("</li>")[0]
        first, last = re.findall(r'href="#L(\d+)">lines? (?:\d+–)?(\d+)<', decision)[0]
        assert int(first) <= line <= int(last)


def test_interpretation_says_why_not(page: str, solution: Solution) -> None:
    assert solution.interpretation is not None
    rejection = solution.interpretation.actions[0].rejections[0]
    assert escape(rejection.sentence, quote=False).split("'")[0] in page


def test_page_is_small_whole_and_offline(page: str) -> None:
    assert len(page.encode()) < 1_500_000
    assert faults(page) == []


def test_the_animation_is_the_recorded_run(page: str, solution: Solution) -> None:
    rollout = solution.candidate.rollout
    assert rollout is not None
    data = json.loads(page.split('id="run-data">')[1].split("</script>")[0])
    scene = data["scene"]
    path = np.frombuffer(base64.b64decode(scene["path"]), "<i2").reshape(-1, 3) * scene["unit"]
    assert len(path) == len(scene["colours"]) == len(data["lines"])
    assert len(path) * data["tick"] == pytest.approx(rollout.times[-1], abs=0.1)
    assert path[0] == pytest.approx(rollout.poses["effector"][0, :3], abs=1e-4)
    assert path[-1] == pytest.approx(rollout.poses["effector"][-1, :3], abs=2e-3)
    moving = np.frombuffer(base64.b64decode(scene["poses"]), "<i2").reshape(len(path), len(scene["moving"]), 7)
    assert np.linalg.norm(moving[:, :, 3:] * scene["turn"], axis=2) == pytest.approx(1.0, abs=1e-3)
    assert {s["body"] for s in scene["solids"]} == {*scene["moving"], *map(int, scene["still"])}


def test_same_run_same_page(page: str, tmp_path: Path, solution: Solution, engine: Engine) -> None:
    assert written(tmp_path, solution, engine) == page


def test_hostile_names_are_escaped(tmp_path: Path, solution: Solution, engine: Engine) -> None:
    trace = Trace([replace(e, reason=HOSTILE, text=HOSTILE, designator=HOSTILE) for e in solution.trace.entries])
    plan = Plan(
        HOSTILE, tuple(replace(o, name=HOSTILE, types=(HOSTILE,)) for o in solution.plan.objects), solution.plan.actions
    )
    code = replace(solution.candidate.code, text=HOSTILE)  # type: ignore[type-var]
    actions = tuple(replace(a, name=HOSTILE, task=HOSTILE) for a in solution.candidate.actions)
    candidate = replace(solution.candidate, plan=plan, code=code, actions=actions)
    hostile = replace(solution, trace=trace, candidate=candidate, setting=replace(solution.setting, name=HOSTILE))
    page = written(tmp_path, hostile, engine)
    assert "alert(" in page
    assert "<script>alert" not in page
    assert '"onload="y' not in page


def test_a_broken_section_is_named_and_the_rest_stands(tmp_path: Path, solution: Solution) -> None:
    plugin = tmp_path / "weather.py"
    plugin.write_text(BROKEN)
    engine = Engine(files=[plugin])
    page = written(tmp_path / "run", solution, engine)
    assert "plugin &#39;weather&#39;" in page
    assert "no &lt;b&gt;ink&lt;/b&gt; left" in page
    assert "<p id=extra>" in page
    assert ">The program</h2>" in page
    assert [f.plugin for f in engine.registry.faults] == ["weather"]


def test_without_a_demonstration_its_sections_are_left_out(tmp_path: Path, solution: Solution, engine: Engine) -> None:
    page = written(tmp_path, replace(solution, episode=None, interpretation=None), engine)
    assert ">The demonstration</h2>" not in page
    assert ">The search</h2>" in page


@pytest.mark.heavy
def test_text_that_cannot_run_here_is_said_to(tmp_path: Path, solution: Solution, engine: Engine) -> None:
    candidate = replace(solution.candidate, rollout=None, episode=None)
    page = written(tmp_path, replace(solution, candidate=candidate), engine)
    assert "cannot be run here" in page
    assert 'class="strip"' not in page
    assert not engine.registry.faults


def test_templates_escape() -> None:
    assert html_template("{{ x }}").render(x="<b>") == "&lt;b&gt;"
