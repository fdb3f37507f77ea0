"""ur_rtde does not wait until a command of force mode was taken: programs do, or the next command replaces it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from test_ur_rtde import BLOCK, CLIENT, SLIDE, typed

from cramlite.model import MoveUntilContact, RobotMount, Rollout, World
from cramlite_plugins.backends.ur_rtde.emit import emit
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.ur_controller import client_program
from cramlite_plugins.ur_controller.registers import Registers
from cramlite_plugins.ur_controller.virtual_robot import VirtualRobot

COMMAND, FORCE_MODE, END_FORCE_MODE = "input_int_register_0", 6, 7  # of ur_rtde's control script
DELAY = 0.016  # robot time until a command of force mode is taken [s]; programs wait for 0.02 s (ur_rtde_arm.py, TAKEN)


class Late(Registers):
    """A controller that looks at its inputs somewhat later when they bring a command of force mode: what comes until then
    replaces it. A real one is as late when its script is busy for a few cycles."""

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__(clock)
        self.waiting: dict[str, Any] = {}
        self.due = 0.0

    def write_inputs(self, values: dict[str, Any]) -> None:
        if not self.waiting and values.get(COMMAND) in (FORCE_MODE, END_FORCE_MODE):
            self.due = self.clock() + DELAY
            self.waiting = dict(values)
        elif self.waiting:
            self.waiting |= values
        else:
            super().write_inputs(values)

    def late(self) -> str | None:
        """Asked once a cycle."""
        if self.waiting and self.clock() >= self.due:
            values, self.waiting = self.waiting, {}
            super().write_inputs(values)
        return super().late()


class LateRobot(VirtualRobot):
    """With such registers."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.functions.registers = Late(lambda: self.time)


def run(monkeypatch: pytest.MonkeyPatch, *changes: tuple[str, str]) -> Rollout:
    """Touch a block and slide over it, pressing."""
    touch = MoveUntilContact((0.0, 0.0, -1.0), 0.03, 3.0, 0.1, 20.0, origin="touch")
    text = emit(typed(touch, SLIDE), UR5E).text
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    monkeypatch.setattr(client_program, "VirtualRobot", LateRobot)
    world = World((BLOCK,), (RobotMount("arm", "ur5e"),))
    return client_program.execute_client(text, world, {"ur5e": UR5E}, mount="arm")


@pytest.mark.heavy
@CLIENT
def test_a_command_of_force_mode_is_taken_before_the_next_one_is_given(monkeypatch: pytest.MonkeyPatch) -> None:
    done = run(monkeypatch)
    assert done.outcome == "finished", (done.reason, [m.text for m in done.messages])


@pytest.mark.heavy
@CLIENT
def test_without_waiting_it_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """A client that its machine keeps from its next command for longer than the delay loses nothing, so it may take more
    than one attempt."""
    reasons = []
    for _ in range(4):
        done = run(monkeypatch, ("        time.sleep(ARRIVED)\n", "        return\n"))
        reasons.append(done.reason)
        if done.outcome != "finished":
            break
    assert any(reasons), "the slide was done without a force, or force mode never ended"
