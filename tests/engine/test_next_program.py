"""Which program follows a stopped one: in what order, and with which budgets, searches and the way back are tried."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from engine.test_going_on import GOAL
from engine.test_going_on_decisions import COUNT, ended, made, watch
from helpers.short_runs import good
from msgspec.structs import replace

from cramlite.engine.recovery.next_program import AT_LAST, AT_ONCE, Stopped, at_last, at_once, next_program
from cramlite.engine.recovery.replanning import BACK, Attempt
from cramlite.model import Deviation, Notice
from cramlite.planning.search.budget import Budget, budget_of
from cramlite.planning.trace import Trace
from cramlite.plugin.protocols import Candidate
from cramlite_plugins.robots.ur5e import UR5E

STEP = "2.PickingUp/lift"
SMALL, WHOLE = Budget(expansions=7), Budget(expansions=700)


def followed(
    folder: Path, step: str, moves: bool, proven: bool, budgets: tuple[Budget, Budget] = (SMALL, WHOLE)
) -> tuple[Attempt | None, str, list[Budget]]:
    """What follows a run that was stopped in a step, why, and the budgets of the searches, each of which finds a program or none."""
    going, asked = made(folder, GOAL), list[Budget]()
    joints = UR5E.home + np.outer(np.linspace(0.0, 0.1 if moves else 0.0, COUNT), [0, 0, 0, 0, 0, 1])
    done, seen = ended(going, origins={1: step}, joints=joints), watch(going, joints=tuple(joints[-1].tolist()))
    going._believe(done, seen)

    def search(budget: Budget) -> Iterator[Candidate]:
        asked.append(budget)
        yield from [good()] if proven else []

    stopped = Stopped(done, Notice(Deviation.MOVED, 1.0, "it moved"), seen, going.setting, going.setting.world)
    found, why = next_program(stopped, search, budgets, going.engine.knowledge, 0, Trace())
    return found, why, asked


@pytest.mark.parametrize(("step", "budget"), [(STEP, SMALL), (BACK, WHOLE)])
def test_the_first_search_is_small_but_for_an_arm_that_went_back(step: str, budget: Budget, tmp_path: Path) -> None:
    found, why, asked = followed(tmp_path, step, moves=True, proven=True)
    assert found is not None and found.candidate is not None and found.candidate.plan == good().plan and asked == [budget]
    assert why == f"goes on from here: {good().plan}"


def test_the_way_back_comes_before_the_whole_search(tmp_path: Path) -> None:
    found, why, asked = followed(tmp_path, STEP, moves=True, proven=False)
    assert found is not None and {s.origin for s in found.program.steps} == {BACK} and asked == [SMALL]
    assert why == "the arm goes back the way it came: no program was proven from here"


def test_without_a_way_back_the_whole_search_is_the_last(tmp_path: Path) -> None:
    assert followed(tmp_path, STEP, moves=False, proven=False) == (None, "no program was proven from here.", [SMALL, WHOLE])


@pytest.mark.parametrize(("step", "budgets"), [(BACK, (SMALL, WHOLE)), (STEP, (WHOLE, WHOLE))])
def test_no_search_is_made_twice(step: str, budgets: tuple[Budget, Budget], tmp_path: Path) -> None:
    assert followed(tmp_path, step, moves=step == BACK, proven=False, budgets=budgets)[2] == [WHOLE]


@pytest.mark.parametrize(("smaller", "limits"), [(at_once, AT_ONCE), (at_last, AT_LAST)])
def test_a_budget_after_a_stop_is_no_larger_than_the_whole(
    smaller: Callable[[Budget], Budget], limits: Mapping[str, int], tmp_path: Path
) -> None:
    whole = budget_of(made(tmp_path, GOAL).scenario)
    assert whole.work == 0 and {name: getattr(smaller(whole), name) for name in limits} == limits
    assert smaller(replace(whole, work=9)).work == 9 and at_once(replace(whole, expansions=9)).expansions == 9
