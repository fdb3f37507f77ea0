"""One execution of a proven program: the world as it really is, where that is known, and the validators of its proof."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.short_runs import good
from helpers.written_runs import Says, Writes, Written, knowing, planned, ran, written
from msgspec.structs import replace

from cramlite.engine.execution import execute
from cramlite.engine.proof.executor import Executor
from cramlite.model import Pose, Rollout, World
from cramlite.plugin import UserError

BELIEVED = planned().setting.world
REAL = BELIEVED.moved({"block": Pose((0.5, 0.21, 0.051))})


class Process(Executor):
    """Executor whose process is the written simulator."""

    simulator: Any = None

    def run(self, text: str, world: World, seed: int) -> tuple[Rollout, float]:
        return self.simulator.execute(text, world, {}, mount="arm", seed=seed), 0.0


@pytest.mark.parametrize("apart", [False, True])
@pytest.mark.parametrize(("real", "entered"), [(None, BELIEVED), (REAL, REAL)])
def test_it_runs_once_where_it_really_is_and_is_judged_against_what_was_believed(real: World | None, entered: World, apart: bool) -> None:
    simulator, run, facts = Written(), Says("run"), Says("facts", False, "facts")
    knowledge, setting = knowing(simulator, [run, facts]), replace(planned().setting, real=real, seed=11)
    done = execute(written(), setting, knowledge, Process(simulator=simulator) if apart else None)
    ((text, world, mount, seed),) = simulator.asked
    assert written().code is not None and (text, mount, seed) == (written().code.text, "arm", 11) and world == entered
    assert done.verdict.passed and [f.validator for f in done.verdict.findings] == ["run"] and done.verdict.left_out == ("blocked",)
    assert done.candidate.world == BELIEVED and done.candidate.rollout is not None and done.candidate.episode is not None
    assert run.asked[0].rollout is done.candidate.rollout


@pytest.mark.parametrize("apart", [False, True])
def test_an_objection_of_a_validator_of_runs_fails_it(apart: bool) -> None:
    simulator = Written(ran("halted"))
    knowledge = knowing(simulator, [Says("one"), Says("other", False)])
    done = execute(written(), planned().setting, knowledge, Process(simulator=simulator) if apart else None)
    assert not done.verdict.passed and done.verdict.reason == "other: other says so"
    assert done.candidate.rollout is not None and done.candidate.rollout.outcome == "halted"


def test_what_cannot_run_here_is_not_executed() -> None:
    backend: Any = Writes(executable=False)
    with pytest.raises(UserError, match="'writes' cannot be run here, so there is nothing to execute"):
        execute(good(), replace(planned().setting, backend=backend), knowing(Written(), []))
