"""Kitchens that are drawn: the same for the same seed, goals that the rules leave out, and those that our predicates can hold."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from drawn_kitchens import draw
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from kitchen_drawing import APART, Kitchen, Literal, Rules, drawn_kitchen, kitchen_of, sentence

from cramlite import Engine, read_scenario


@pytest.fixture(scope="module")
def engine() -> Engine:
    """One for all."""
    return Engine()


@pytest.fixture(scope="module")
def rules(engine: Engine) -> Rules:
    """The rules of a kitchen that is written by hand."""
    made = Kitchen({"type": "ur5e"})
    made.add("floor", "table", (0.2, 0.0, -0.005), size=[2.0, 2.0, 0.02])
    made.add("cabinet", "cabinet", (0.75, 0.1, 0.35), 3.14159)
    made.add("drawer", "drawer", (0.75, 0.1, 0.35), 3.14159, parent="cabinet")
    made.add("shelf", "table", (0.45, -0.35, 0.15), size=[0.25, 0.25, 0.02])
    made.tops = {"floor": ("on", (9.0, 9.0)), "shelf": ("on", (0.25, 0.25)), "cabinet": ("on", (0.3, 0.3)), "drawer": ("in", (0.25, 0.264))}
    for name, size, at in (("block_0", (0.05, 0.05, 0.08), (0.45, 0.3)), ("block_1", (0.04, 0.03, 0.2), (0.3, 0.4))):
        made.add(name, "block", (*at, size[2] / 2 + 0.006), size=list(size))
        made.extents[name] = size
    made.add("can_2", "can", (0.45, -0.35, 0.19), radius=0.03, height=0.07)
    made.extents["can_2"] = (0.06, 0.06, 0.07)
    return Rules(engine, made)


@given(st.integers(0, 2**32 - 1))
@examples(40)
def test_what_stands_on_the_floor_at_first_stands_apart(seed: int) -> None:
    first, again = (kitchen_of(np.random.default_rng(seed)) for _ in range(2))
    assert first.spec() == again.spec()
    movable = [t for t in first.things if t["name"] in first.extents]
    floor = [t for t in movable if t["at"]["position"][2] < 0.1 and not _borne(first, t)]
    for k, one in enumerate(floor):
        for other in floor[:k]:
            apart = np.hypot(*np.subtract(one["at"]["position"][:2], other["at"]["position"][:2]))
            assert apart > min(min(first.extents[t["name"]][:2]) for t in (one, other)) + APART


def _borne(kitchen: Kitchen, thing: dict[str, Any]) -> bool:
    x, y, _ = thing["at"]["position"]
    plates = [t for t in kitchen.things if t["name"] in ("shelf", "tray")]
    return any(abs(x - p["at"]["position"][0]) < 0.2 and abs(y - p["at"]["position"][1]) < 0.2 for p in plates)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ([("on", "can_2", "shelf")], "holds already"), ([("close", "drawer")], "holds already"),
        ([("open", "drawer"), ("close", "drawer")], "a contradiction"),
        ([("on", "block_0", "block_1")], "larger than its target"),
        ([("on", "block_0", "can_2"), ("on", "block_1", "can_2")], "cannot hold it"),  # there is room for one
        ([("on", "can_2", "block_0")], "larger than its target"),
        ([("on", "block_0", "shelf")], ""), ([("in", "block_0", "drawer"), ("open", "drawer")], ""),
        ([("on", "block_1", "block_0"), ("on", "block_0", "cabinet")], ""), ([("in", "can_2", "drawer"), ("on", "block_0", "shelf")], ""),
    ],
)  # fmt: skip
def test_rules_leave_out_what_they_say(rules: Rules, goal: list[Literal], said: str) -> None:
    found = rules.left_out(goal)
    assert said in found and bool(said) == bool(found)


def test_a_drawn_kitchen_is_a_scenario_whose_goal_does_not_hold(engine: Engine) -> None:
    told: Counter[str] = Counter()
    kitchen, goal = drawn_kitchen(engine, 1, told)
    assert drawn_kitchen(engine, 1, Counter())[1] == goal
    rules = Rules(engine, kitchen)
    assert not any(rules.holds(p, rules.setting.world) for p in goal)
    assert read_scenario(kitchen.spec(goal)).spec.goal == tuple(map(sentence, goal))
    assert told["goals drawn"] == 1 + sum(n for what, n in told.items() if what.startswith("goals left out"))


def test_a_kitchen_for_an_arm_from_a_file_takes_the_file_along(engine: Engine, tmp_path: Any) -> None:
    seed = next(s for s in range(200) if "file" in kitchen_of(np.random.default_rng([s, 0])).robot)
    facts = draw(engine, seed, tmp_path)
    assert facts["robot"] == "arm from a file" and (tmp_path / "six.urdf").is_file()
    assert engine.setting(read_scenario(tmp_path / "scenario.yaml"), twins=0).robot.type.startswith("six")
