"""The kinds of motions: documented as they are, in the words of the text that is emitted, and used as declared."""

from __future__ import annotations

import pytest
from helpers.flat_steps import flat
from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Motion,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Pose,
    Program,
    Robot,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Stage,
    Wait,
    ZeroSensor,
)
from cramlite.plugin import MotionKind, Unresolvable
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite.testing.task_checks import sample_action, sample_belief
from cramlite_plugins.backends.urscript.emit import emit
from cramlite_plugins.motions.motion_kinds import KINDS, value, word
from cramlite_plugins.robots.ur5 import UR5
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.ur_controller.urscript.parser import parse

WAY: tuple[AnyStep, ...] = (
    MoveJoints((UR5E.home,), 1.0, 1.0), MoveLinear(Pose(), 0.1, 0.5),
    MoveUntilContact((0, 0, -1), 0.01, 3.0, 0.1, 9.0),
    ForceMove((Pose(),), Pose(), (True,) * 6, (0.0,) * 6, (0.1,) * 6, 0.03, 25.0, 9.0),  # type: ignore[arg-type]
    SpiralSearch(Pose(), 3.0, 0.001, 0.008, 0.01, 0.002, 25.0, 60.0), ForceInsert(Pose(), 8.0, 0.06, 0.02, 25.0, 9.0),
    ForceExtract(Pose(), 8.0, (0.0, 0.0), 0.06, 0.04, 25.0, 9.0),
    CompliantSlide((Pose(),), Pose(), 3.0, 0.03, 0.5, 25.0, 9.0),
    SetGripper(0.0, 0.1, 50.0), SetPayload(1.0, (0, 0, 0)), ZeroSensor(), Wait(1.0),
)  # fmt: skip
STEPS = {type(s).__name__: s for s in WAY}


WRITTEN = {name: kind for name, kind in KINDS.items() if kind.step != "Drive"}
"""Kinds that URScript has words for; that it refuses to drive is tested in tests/plugins/simulation/test_platform_drive.py."""


@pytest.mark.parametrize("robot", [UR5E, UR5], ids=["e-Series", "CB3"])
@pytest.mark.parametrize("kind", WRITTEN.values(), ids=list(WRITTEN))
def test_abort_reasons_are_those_of_the_text(kind: MotionKind, robot: Robot) -> None:
    step = replace(STEPS[kind.step], origin="here")
    program = Program("p", "arm", robot.type, robot.gripper.tcp, robot.home, (step,), ())
    text = emit(program, robot).text
    assert parse(text).name == "p"
    for reason in kind.aborts:
        for words in filter(None, (w.strip() for w in reason.split("#"))):
            assert words in text, f"'{words}' of '{reason}'"
    assert ("zero_ftsensor()" in text) == (robot is UR5E)


def test_tasks_say_only_what_kinds_know() -> None:
    seen = set()
    for task in Knowledge(Registry()).tasks.values():
        for belief in (sample_belief(), sample_belief("cube")):
            try:
                steps = [s for way in task.decompose(sample_action(task), belief) for s in flat(way.steps)]
            except Unresolvable:
                continue
            for motion in (s for s in steps if isinstance(s, Motion) and s.kind in KINDS):
                seen.add(motion.kind)
                assert set(motion.parameters) <= set(KINDS[motion.kind].knows()), task.task
    assert {"force_extract", "compliant_slide", "spiral_search", "until_contact"} <= seen


def test_a_motion_without_parameters_has_the_defaults() -> None:
    assert value(Motion("m", "force_extract"), "force_n") == 8.0
    assert value(Motion("m", "force_extract", parameters={"force_n": 5}), "force_n") == 5.0


@pytest.mark.parametrize("said", ["end", Stage.END])
def test_words_are_their_texts(said: str) -> None:
    assert word(Motion("m", "linear", parameters={"stage": said}), "stage", Stage) is Stage.END
    assert word(Motion("m", "linear"), "stage", Stage, Stage.POSE) is Stage.POSE


def test_a_word_that_there_is_not_is_refused_with_the_nearest() -> None:
    with pytest.raises(Unresolvable, match=r"kind 'linear' knows no stage 'ende'; did you mean 'end'\? valid are: before, end, pose"):
        word(Motion("m", "linear", parameters={"stage": "ende"}), "stage", Stage)
