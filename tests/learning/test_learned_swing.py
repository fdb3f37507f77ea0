"""A motion about the payload's own place is learned from a recording of poses, recognised elsewhere, and done by a robot."""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.recorded_people import pouring, read, shaking

from cramlite import Engine
from cramlite.base.resources import data_folder
from cramlite.interpretation.in_place import done_in_place, strokes_along
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.example import Marked, example
from cramlite.learning.from_episodes import learn_task
from cramlite.learning.learner import covers
from cramlite.learning.package import page_text, write_package
from cramlite.learning.proposal import Proposal
from cramlite.learning.shown_swing import shown_swing
from cramlite.learning.span import Span
from cramlite.model import Episode
from cramlite.testing import check_plugin

TIMES = np.arange(0.0, 6.0, 0.02)


def wave(rounds: float, size: float = 0.06, period: float = 1.0) -> np.ndarray:
    """A signal that goes up and down and then keeps still [m]."""
    return 0.5 * size * (1 - np.cos(2 * np.pi * np.minimum(TIMES / period, rounds)))


def test_strokes_are_counted_between_a_way_there_and_a_way_back() -> None:
    found = strokes_along(TIMES, wave(3))
    assert found is not None and found.rounds == 3 and found.size == pytest.approx(0.06, abs=0.002)
    assert found.seconds == pytest.approx(0.37, abs=0.02), "a sine is faster in its middle"
    carried = np.concatenate([np.linspace(-0.4, 0.0, 100), wave(3), np.linspace(0.0, -0.4, 100)])
    longer = strokes_along(np.arange(len(carried)) * 0.02, carried, 0.06, 0.37)
    assert longer is not None and 2 <= longer.rounds <= 3


def test_other_strokes_are_not_like_the_shown_ones() -> None:
    assert strokes_along(TIMES, wave(3), 0.2, 0.5) is None, "too short"
    assert strokes_along(TIMES, wave(3), 0.06, 2.0) is None, "too fast"
    assert strokes_along(TIMES, np.zeros(len(TIMES))) is None
    tremor = np.random.default_rng(0).normal(0, 0.001, len(TIMES))
    assert strokes_along(TIMES, tremor) is None


@cache
def shown() -> tuple[Engine, Episode, Episode]:
    engine = Engine()
    return engine, read(shaking()), read(pouring())


@cache
def learned(folder: Path) -> Proposal:
    rules = folder / "rules"
    shutil.copytree(data_folder("task_rules"), rules, ignore=shutil.ignore_patterns("shaking.yaml"))
    _, shaken, _ = shown()
    start, end = stretch("cram:Shaking", shaken)
    return learn_task("sprinkling", [(shaken, start, end)], Engine(rules=rules).knowledge)


@pytest.fixture(scope="module")
def proposal(tmp_path_factory: pytest.TempPathFactory) -> Proposal:
    return learned(tmp_path_factory.mktemp("learned"))


def stretch(task: str, episode: Episode) -> tuple[float, float]:
    (action,) = [a for a in shown()[0].interpret(episode).actions if a.named(task)]
    return action.start, action.end


def test_its_rule_asks_for_the_motion_of_one_thing(proposal: Proposal) -> None:
    engine, shaken, poured = shown()
    assert "follows_sprinkling(Patient)" in proposal.rule["run"] and proposal.done
    assert proposal.moving is not None and proposal.moving[1:] == ("Patient", "Patient")
    path = proposal.moving[0].path
    assert path.anchor.own and path.closed and path.least >= 2.0
    taxonomy = engine.knowledge.taxonomy
    assert covers(proposal.learned, Span(Timeline(shaken, taxonomy), *stretch("cram:Shaking", shaken)))
    for episode in (shaken, poured):
        for action in engine.interpret(episode).actions:
            if not action.named("cram:Shaking"):
                assert not covers(proposal.learned, Span(Timeline(episode, taxonomy), action.start, action.end))
    assert not done_in_place(path, poured, "cup", poured.span) >= path.least


def test_pouring_is_no_motion_to_and_fro() -> None:
    engine, _, poured = shown()
    start, end = stretch("soma:Pouring", poured)
    assert shown_swing([example(Marked(poured, start, end), engine.knowledge.rules, engine.knowledge.taxonomy).span]) is None


def test_a_known_task_explains_it() -> None:
    engine, shaken, _ = shown()
    found = learn_task("sprinkling", [(shaken, *stretch("cram:Shaking", shaken))], engine.knowledge)
    assert found.motion is None


@pytest.mark.heavy
def test_a_robot_does_it_in_the_scenario_of_the_package(proposal: Proposal, tmp_path: Path) -> None:
    import importlib.util

    from cramlite import read_scenario
    from cramlite.learning.trial import trials

    written = write_package(proposal, "sprinkling", tmp_path / "package")
    module, scenario = (next(p for p in written if p.name == name) for name in ("__init__.py", "try_sprinkling.yaml"))
    assert "about its first place" in page_text(proposal)
    spec = importlib.util.spec_from_file_location("cramlite_sprinkling", module)
    assert spec is not None and spec.loader is not None
    plugin = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plugin)
    check_plugin(plugin)
    (trial,) = trials(proposal, module, read_scenario(scenario), range(1, 2))
    assert trial.passed, trial.reason
