"""Problems that are drawn: goals, rules that leave some out, variations of scenes, seeds for what, and two versions on the same files.

What needs LIBERO itself is not asked here; a benchmark's environment is played by this Python.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import yaml
from conftest import ROOT
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.experiment.benchmark.protocol import module_of
from cramlite.experiment.benchmark.results import Attempt, EpisodeResult
from cramlite.experiment.benchmark.spec import read_benchmark

sys.path.insert(0, str(ROOT / "experiments"))
import drawn_goals as goals
import drawn_pair
from seed_ranges import MEASURED, seeds_of

DRAWING = ROOT / "experiments" / "libero" / "drawing"
OFFERS = goals.offered(
    ["plate_1", "bowl_1", "mug_1"],
    {"stove_1_cook_region": ("on", goals.PART), "bowl_1_contain_region": ("in", goals.PART), "table_left": ("on", goals.TABLE)},
    {"door_1": ("open", "close")},
)
OWNER = {"bowl_1_contain_region": "bowl_1"}
KITCHEN: dict[str, Any] = {
    "problem_name": "libero_kitchen", "fixtures": {"kitchen_table": ["kitchen_table"], "stove": ["stove_1"]},
    "objects": {"bowl": ["bowl_1", "bowl_2"], "plate": ["plate_1"]},
    "regions": {
        "kitchen_table_a": {"target": "kitchen_table", "ranges": [[0.0, 0.1, 0.2, 0.3]], "yaw_rotation": [0.0, 1.5]},
        "kitchen_table_b": {"target": "kitchen_table", "ranges": [[0.3, 0.1, 0.4, 0.3]], "yaw_rotation": [0.0, 0.0]},
        "kitchen_table_c": {"target": "kitchen_table", "ranges": [[-0.3, 0.1, -0.2, 0.3]], "yaw_rotation": [0.0, 0.0]},
        "kitchen_table_s": {"target": "kitchen_table", "ranges": [[-0.5, 0.1, -0.4, 0.3]], "yaw_rotation": [0.0, 0.0]},
        "plate_1_top_side": {"target": "plate_1", "ranges": [], "yaw_rotation": [0, 0]},
    },
    "obj_of_interest": ["bowl_1"], "goal_state": [["on", "bowl_1", "plate_1"]],
    "initial_state": [
        ["on", "bowl_1", "kitchen_table_a"], ["on", "bowl_2", "kitchen_table_b"], ["on", "plate_1", "kitchen_table_c"],
        ["on", "stove_1", "kitchen_table_s"], ["open", "stove_1"],
    ],
}  # fmt: skip
seeds = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def variants() -> ModuleType:
    """The module that varies scenes."""
    return module_of(DRAWING / "variants.py")


def test_a_scene_offers_each_thing_at_each_other_one_and_each_state_of_a_joint() -> None:
    assert set(OFFERS) == {"close", "in", "on", "open"}
    part, table, thing = OFFERS["on"]  # sorts of targets are equally likely, however many there are of each
    assert len(thing) == 3 * 2 and ("on", "bowl_1", "bowl_1") not in thing
    assert {p[2] for p in part} == {"stove_1_cook_region"} and {p[2] for p in table} == {"table_left"}
    assert OFFERS["in"] == (tuple(("in", what, "bowl_1_contain_region") for what in ("bowl_1", "mug_1", "plate_1")),)


def test_no_goal_has_more_parts_than_there_is_something_to_say_them_of() -> None:
    assert goals.most_parts(OFFERS) == 3 + 1  # where three things are, and a door
    two = goals.offered(["plate_1", "bowl_1"], {}, {})
    drawn = (goals.drawn_goal(np.random.default_rng(seed), two, 3) for seed in range(50))
    assert goals.most_parts(two) == 2 and all(goals.contradiction(g, {}) for g in drawn)


@given(seeds, st.integers(1, 3))
@examples(60)
def test_a_drawn_goal_is_of_what_is_offered_and_the_same_for_the_same_seed(seed: int, parts: int) -> None:
    drawn = [goals.drawn_goal(np.random.default_rng(seed), OFFERS, parts) for _ in range(2)]
    assert drawn[0] == drawn[1] and len(drawn[0]) == parts
    assert all(any(literal in sort for sort in OFFERS[literal[0]]) for literal in drawn[0])


@given(seeds, st.integers(1, 3))
@examples(100)
def test_what_is_no_contradiction_has_an_order_in_which_what_bears_others_comes_first(seed: int, parts: int) -> None:
    goal = goals.drawn_goal(np.random.default_rng(seed), OFFERS, parts)
    if goals.contradiction(goal, OWNER):
        return
    order, placed = goals.in_order(goal, OWNER), set[str]()
    assert sorted(order) == sorted(p for p in goal if p[0] in goals.PLACES)
    moved = {p[1] for p in order}
    for literal in order:
        bearer = OWNER.get(literal[2], literal[2])
        assert bearer not in moved or bearer in placed
        placed.add(literal[1])


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ([("open", "door_1"), ("open", "door_1")], "said twice"), ([("close", "door_1"), ("open", "door_1")], "in two states"),
        ([("upright", "mug_1"), ("upside_down", "mug_1")], "in two states"),
        ([("on", "mug_1", "plate_1"), ("on", "mug_1", "bowl_1")], "in two places"),
        ([("on", "bowl_1", "plate_1"), ("on", "plate_1", "bowl_1")], "bear each other"),
        ([("on", "bowl_1", "plate_1"), ("in", "plate_1", "bowl_1_contain_region")], "bear each other"),
        ([("in", "bowl_1", "bowl_1_contain_region")], "bear each other"),
        ([("on", "bowl_1", "plate_1"), ("on", "plate_1", "stove_1_cook_region"), ("open", "door_1")], ""),
    ],
)  # fmt: skip
def test_contradictions_are_left_out(goal: list[goals.Literal], said: str) -> None:
    found = goals.contradiction(goal, OWNER)
    assert said in found and bool(said) == bool(found)


def test_a_thing_fits_in_some_attitude_or_in_none() -> None:
    assert goals.fits((0.03, 0.15, 0.2), (0.16, 0.04))  # a book on its edge
    assert not goals.fits((0.05, 0.15, 0.2), (0.16, 0.04))
    assert not goals.fits((0.03, 0.17, 0.2), (0.16, 0.04))


def test_goals_are_compared_by_the_kinds_of_their_things() -> None:
    first = [("on", "bowl_1", "plate_1")]
    same, other = [("On", "bowl_2", "plate_1")], [("on", "plate_1", "bowl_2")]
    kind = str.partition
    signs = [goals.signature(g, lambda n: kind(n, "_")[0]) for g in (first, same, other)]
    assert signs[0] == signs[1] != signs[2]


@given(seeds)
@examples(60)
def test_swapped_things_stand_where_others_stood(variants: ModuleType, seed: int) -> None:
    found = variants.swapped(KITCHEN, np.random.default_rng(seed))
    rows = [r for r in found["initial_state"] if r[0] == "on" and r[1] != "stove_1"]
    assert sorted(r[2] for r in rows) == [f"kitchen_table_{n}" for n in "abc"]
    assert ["on", "plate_1", "kitchen_table_c"] not in rows  # one at least stands where another kind stood
    assert ["on", "stove_1", "kitchen_table_s"] in found["initial_state"]


@given(seeds)
@examples(60)
def test_replaced_things_are_of_the_library_and_no_name_is_left_behind(variants: ModuleType, seed: int) -> None:
    found = variants.replaced(KITCHEN, np.random.default_rng(seed), ("bowl", "can", "plate"))
    things = variants.movables(found)
    assert len(things) == len(set(things)) == 3
    assert set(found["objects"]) <= {"bowl", "can", "plate"}
    named = {n for row in found["initial_state"] for n in row[1:]} | {r["target"] for r in found["regions"].values()}
    assert named <= {*things, "stove_1", "kitchen_table", *found["regions"]}


@given(seeds)
@examples(40)
def test_fixtures_are_pinned_within_the_region_that_they_are_drawn_from(variants: ModuleType, seed: int) -> None:
    found = variants.pinned(KITCHEN, np.random.default_rng(seed))["regions"]
    x0, y0, x1, y1 = found["kitchen_table_s"]["ranges"][0]
    assert -0.5 - 1e-5 < x0 < x1 < -0.4 + 1e-5 and 0.1 - 1e-5 < y0 < y1 < 0.3 + 1e-5
    assert max(x1 - x0, y1 - y0) < 1e-5
    assert found["kitchen_table_a"] == KITCHEN["regions"]["kitchen_table_a"]


def test_a_problem_file_says_all_of_the_problem(variants: ModuleType) -> None:
    text = variants.text(KITCHEN, "put the bowl")
    assert text.count("(") == text.count(")")
    for said in ("(problem libero_kitchen)", "bowl_1 bowl_2 - bowl", "(:goal (And (on bowl_1 plate_1)))", "(open stove_1)",
                 "(a (:target kitchen_table)", "(:yaw_rotation ((0 1.5)))", "(top_side (:target plate_1))"):  # fmt: skip
        assert said in text
    ranges = re.search(r"\(a .*?:ranges \(\((.*?)\)\)", text)
    assert ranges is not None and [float(v) for v in ranges.group(1).split()] == [0.0, 0.1, 0.2, 0.3]


@pytest.mark.parametrize("text", ["0:10", "199", "0:200"])
def test_seeds_for_development_are_drawn(text: str) -> None:
    assert 0 <= seeds_of(text)[0] <= seeds_of(text)[-1] < 200


@pytest.mark.parametrize("text", ["1000:1010", "1100", "399:401", "500", "900:1001", "5:5"])
def test_seeds_of_a_measurement_are_not_opened_by_the_way(text: str) -> None:
    with pytest.raises(ValueError, match=r"not within 0 to 399.*--measure"):
        seeds_of(text)


def test_a_measurement_opens_its_seeds_and_no_others() -> None:
    assert list(seeds_of("1000:1100", measure=True)) == list(MEASURED[0])
    for text in ("0:10", "1150:1170", "1460"):
        with pytest.raises(ValueError, match="not within 1000 to 1099 or 1100 to 1159 or 1160 to 1459"):
            seeds_of(text, measure=True)


def test_a_folder_of_problems_is_an_environment_of_the_benchmark(tmp_path: Path) -> None:
    stand_in = tmp_path / "python"
    stand_in.write_text('#!/bin/sh\necho "$@"\n')
    stand_in.chmod(0o755)
    module_of(DRAWING / "environment.py").make_environment(tmp_path / "problems", str(stand_in))
    said = subprocess.run([tmp_path / "problems/bin/python", "simulator.py"], capture_output=True, text=True, check=True).stdout
    assert said.split() == [str(tmp_path / "problems/bin/launch.py"), "simulator.py"]


def test_files_of_a_problem_that_were_changed_are_refused(tmp_path: Path) -> None:
    launch = module_of(DRAWING / "launch.py")
    folder = tmp_path / "0003"
    folder.mkdir()
    (folder / "problem.bddl").write_text("(define)")
    (folder / "state.txt").write_bytes(b"state")
    (folder / "problem.json").write_text(json.dumps({"digest": "0" * 8, "kind": "On", "words": "put"}))
    launch.PROBLEMS = tmp_path
    suite = launch.Drawn()
    assert suite.get_num_tasks() == 4
    sys.modules["libero.libero.benchmark"] = ModuleType("benchmark")
    sys.modules["libero.libero.benchmark"].Task = None  # type: ignore[attr-defined]
    for package in ("libero", "libero.libero"):
        sys.modules.setdefault(package, ModuleType(package))
    try:
        with pytest.raises(ValueError, match="altered since the problem was drawn"):
            suite.get_task(3)
        with pytest.raises(ValueError, match="no problem 2"):
            suite.get_task(2)
    finally:
        for name in ("libero.libero.benchmark", "libero.libero", "libero"):
            del sys.modules[name]


def result(seed: int, rest: bool, name: str = "1a2b In + Open: put", outcome: str = "finished") -> EpisodeResult:
    attempt = Attempt(outcome=outcome, reason="", first=5 if rest else None, rest=rest, steps=9)
    return EpisodeResult(suite="drawn", task=seed, state=0, name=name, budget=20, proven=True, attempt=attempt)


def test_two_versions_are_paired_by_seed(capsys: pytest.CaptureFixture[str]) -> None:
    old, new = {1: result(1, False), 2: result(2, True)}, {1: result(1, True), 2: result(2, True)}
    numbers = drawn_pair.numbers(drawn_pair.paired(old, new))
    said = capsys.readouterr().out
    assert "both 1, only old 0, only new 1, neither 0" in said and "| In + Open | old | 1 of 2 |" in said
    assert [(n.hits, n.of) for n in numbers if n.what == "all"] == [(1, 2), (2, 2)]


def test_versions_that_were_given_other_files_are_not_compared() -> None:
    with pytest.raises(SystemExit, match=r"seeds \[1\] are not the same files"):
        drawn_pair.paired({1: result(1, True)}, {1: result(1, True, name="ffff In + Open: put")})
    with pytest.raises(SystemExit, match="did not play the same seeds"):
        drawn_pair.paired({1: result(1, True)}, {2: result(2, True)})


def test_an_episode_whose_benchmark_died_is_left_out(capsys: pytest.CaptureFixture[str]) -> None:
    old, new = {1: result(1, True), 2: result(2, True)}, {1: result(1, False, outcome="benchmark died"), 2: result(2, True)}
    numbers = drawn_pair.numbers(drawn_pair.paired(old, new))
    assert [n.of for n in numbers if n.what == "all"] == [1, 1]
    assert "both 1, only old 0" in capsys.readouterr().out


def test_the_chance_of_a_difference_is_that_of_mcnemar() -> None:
    assert drawn_pair.chance(0, 0) == 1.0
    assert drawn_pair.chance(1, 9) == pytest.approx(2 * 11 / 1024)


@pytest.mark.parametrize("key", ["benchmark", "judge"])
def test_an_old_checkout_is_given_the_suite_by_a_file_of_its_own(key: str, tmp_path: Path) -> None:
    folder = tmp_path / "experiments" / "libero"
    folder.mkdir(parents=True)
    spec = yaml.safe_load((ROOT / "experiments/libero/experiment.yaml").read_text())
    del spec["suites"]["drawn"]
    spec[key] = spec.pop("benchmark")
    (folder / "experiment.yaml").write_text(yaml.safe_dump(spec))
    (tmp_path / "old.yaml").write_text(drawn_pair.experiment_for(tmp_path))
    assert key in yaml.safe_load((tmp_path / "old.yaml").read_text())
    found = read_benchmark(tmp_path / "old.yaml")
    assert found.suite("drawn").budget == 1200
    assert found.beside(found.spec.benchmark) == folder / "connection.py"
    assert [found.beside(p) for p in found.spec.plugins] == [folder / "panda.py"]
