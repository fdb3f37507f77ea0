"""Execution of a proven program, once, in the real world, which the search never sees.

A search plans and proves in what is believed. Only here is ``Setting.real`` entered, after a program was accepted, and what
comes of it goes to people: an execution that failed is a failure, and no reason to go on searching until one succeeds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.value import Value
from ..model.run.verdict import Verdict
from .picture_checks import PictureChecks, picture_checks
from .proof.proof import judge_run, run_and_judge, text_that_runs

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate
    from .proof.executor import Executor
    from .setting import Setting


class Execution(Value):
    """Execution: a run of a proven program in the real world, and its verdict there.

    Args:
        candidate: the program, with rollout and episode of this run; ``candidate.world`` is what was believed.
        verdict: of the validators of runs; one of them also compares what things were taken for with what they are.
        checks: what the camera saw of it (``camera: {checks: ...}``); None where no camera checks anything.
    """

    candidate: Candidate
    verdict: Verdict
    checks: PictureChecks | None = None


def execute(candidate: Candidate, setting: Setting, knowledge: Knowledge, executor: Executor | None = None) -> Execution:
    """Run a proven program once in the real world of its setting, or in the believed one if no other is
    declared.

    Args:
        executor: the process that runs it; None runs it in this one.

    Raises:
        ExecutorDied: the process that runs it did, or was killed.
        UserError: its text cannot be run here.
    """
    text = text_that_runs(candidate, setting.backend)
    if text is None:
        raise UserError(f"Text of backend '{setting.backend.name}' cannot be run here, so there is nothing to execute.")
    world = setting.real or setting.world
    if executor is None:
        ran, findings = run_and_judge(candidate, text, world, knowledge, setting.seed)
    else:
        ran, findings = judge_run(candidate, text, executor.run(text.text, world, setting.seed)[0], knowledge)
    checks = picture_checks(candidate, text, ran.ran, world, knowledge, setting.seed)
    return Execution(ran, Verdict(tuple(findings), knowledge.left_out), checks)
