"""The virtual UR controller feels contact and grips."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.short_programs import CLOSED, FINGERTIP, GUARDED, WORLD, down, go, near_home, peak, run, script
from msgspec.structs import replace

from cramlite.model import AnyStep, ForceMove, MoveLinear, Pose, SetGripper, SetPayload, Wait, ZeroSensor
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.controller.protective_stop import Safety


@pytest.mark.parametrize(("speed", "most"), [(0.02, 18.0), (0.01, 9.0), (0.005, 6.0)])
def test_a_guarded_motion_stops_on_a_plate(speed: float, most: float) -> None:
    height = FINGERTIP + 0.015
    rollout = run(go(down(0.45, -0.2, height)), CLOSED, replace(GUARDED, speed=speed))
    assert rollout.outcome == "finished"
    assert any("touch: contact" in m.text for m in rollout.messages)
    assert 3.0 < peak(rollout) < most  # docs/explanation/simulation.md: 12 to 18, 9 and 6 N
    assert rollout.poses["effector"][-1, 2] == pytest.approx(FINGERTIP, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "outcome", "reason"),
    [
        ({}, "halted", "touch: no contact within 0.05 m"),
        ({"timeout": 1.0}, "halted", "touch: no contact within 1 s"),
        ({"expect": "any"}, "finished", ""),
    ],
)
def test_a_guarded_motion_without_a_plate(change: dict[str, object], outcome: str, reason: str) -> None:
    rollout = run(go(down(0.45, -0.2, 0.2)), replace(GUARDED, **change))  # type: ignore[arg-type]
    assert (rollout.outcome, rollout.reason) == (outcome, reason)


def test_driving_into_the_table_is_stopped_by_the_programs_own_limit() -> None:
    rollout = run(go(down(0.45, -0.2, 0.1)), MoveLinear(target=down(0.45, -0.2, -0.1), speed=0.1, acceleration=1.0))
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith("force ")
    assert rollout.reason.endswith("N > 60 N")


def test_and_without_one_by_the_controller() -> None:
    x = near_home(down(0.45, -0.2, 0.05))
    body = f"  movej({list(x)})\n  movel(p[0.45, -0.2, -0.1, 3.14159265, 0, 0], v=0.1)"
    rollout = script(body, safety=Safety(force=80))
    assert rollout.outcome == "protective stop"
    assert "N > 80 N" in rollout.reason


PRESS = ForceMove(
    waypoints=(down(0.45, -0.18, FINGERTIP + 0.003), down(0.45, -0.22, FINGERTIP + 0.003)), frame=Pose(),
    compliant=(False, False, True, False, False, False), wrench=(0, 0, -8, 0, 0, 0),
    limits=(0.01, 0.01, 0.02, 0.1, 0.1, 0.1),
    speed=0.02, force_limit=30, timeout=20, origin="press",
)  # fmt: skip


def test_force_mode_presses_with_the_force_that_was_asked_for() -> None:
    rollout = run(go(down(0.45, -0.2, FINGERTIP + 0.003)), CLOSED, ZeroSensor(), PRESS, settle=0.0)
    assert rollout.outcome == "finished"
    pressing = rollout.wrench[-70:-10, 2]
    assert np.median(pressing) == pytest.approx(-8.0, abs=2.5)
    away = rollout.poses["effector"][-70:-10, :3]
    assert np.ptp(away[:, 1]) > 0.01  # the motion in y went on
    assert np.abs(away[:, 2] - FINGERTIP).max() < 1e-3


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"force_limit": 5.0}, "press: force "),
        ({"timeout": 0.5}, "press: not done within 0.5 s"),
    ],
)
def test_force_mode_is_watched(change: dict[str, float], reason: str) -> None:
    steps = (go(down(0.45, -0.2, FINGERTIP + 0.003)), CLOSED, ZeroSensor(), replace(PRESS, **change))  # type: ignore[arg-type]
    rollout = run(*steps, settle=0.0)
    assert rollout.outcome == "halted"
    assert rollout.reason.startswith(reason)


def pick(close: float, expect: str) -> tuple[AnyStep, ...]:
    grip = SetGripper(opening=close, speed=0.1, force=50, expect=expect, origin="grip")  # type: ignore[arg-type]
    payload = SetPayload(mass=UR5E.gripper.mass + 0.8, center=(0.0, 0.0, 0.12))
    return (
        go(down(0.55, 0.1, 0.22)), MoveLinear(target=down(0.55, 0.1, 0.13), speed=0.2, acceleration=1.0), grip, payload,
        MoveLinear(target=down(0.55, 0.1, 0.22), speed=0.2, acceleration=1.0), Wait(duration=0.3),
    )  # fmt: skip


def test_a_grasp_lifts_the_product() -> None:
    rollout = run(*pick(0.0, "object"))
    assert rollout.outcome == "finished"
    assert rollout.opening[-1] == pytest.approx(0.025, abs=1e-3)
    assert rollout.poses["product"][-1, 2] - rollout.poses["product"][0, 2] == pytest.approx(0.09, abs=0.01)
    assert rollout.wrench[-1, 2] == pytest.approx(0.8 * 9.81, abs=0.3)  # it carries the product: upwards
    assert rollout.contact_force()[-1] < 1.0, "its weight is no contact: the program has said that it carries it"


def test_what_the_program_does_not_say_that_it_carries_is_felt() -> None:
    steps = tuple(s for s in pick(0.0, "object") if not isinstance(s, SetPayload))
    rollout = run(*steps)
    assert rollout.contact_force()[-1] == pytest.approx(0.8 * 9.81, abs=1.0)


def test_an_empty_hand_is_noticed() -> None:
    empty = WORLD.moved({"product": Pose((0.2, -0.5, 0.075))})
    rollout = run(*pick(0.0, "object"), world=empty)
    assert (rollout.outcome, rollout.reason) == ("halted", "grip: no object between the fingers")
    assert run(*pick(0.06, "object")).reason == "grip: no object between the fingers"
    assert run(*pick(0.0, "none")).reason == "grip: an object stopped the fingers"


def test_sockets_lead_to_the_gripper_only() -> None:
    good = script('  socket_open("127.0.0.1", 63352, "g")\n  textmsg(socket_get_var("STA", "g"))')
    assert [m.text for m in good.messages] == ["3"]
    bad = script('  socket_open("192.168.1.5", 30002)')
    assert bad.outcome == "error"
    assert "192.168.1.5:30002 refused" in bad.reason


def test_what_arm_and_gripper_were_told_is_recorded() -> None:
    grip = SetGripper(opening=0.0, speed=0.1, force=60, expect="object", origin="grip")
    load = SetPayload(mass=UR5E.gripper.mass + 0.8, center=(0.0, 0.0, 0.12))
    rollout = run(
        go(down(0.55, 0.1, 0.22)), MoveLinear(target=down(0.55, 0.1, 0.13), speed=0.2, acceleration=1.0), grip, load,
        MoveLinear(target=down(0.55, 0.1, 0.2), speed=0.1, acceleration=1.0), replace(grip, opening=0.085, force=20.0, expect="none"),
    )  # fmt: skip
    assert rollout.payload is not None and rollout.grip is not None
    assert sorted(set(np.round(rollout.payload[1:], 6).tolist())) == pytest.approx([UR5E.gripper.mass, UR5E.gripper.mass + 0.8])
    held = np.flatnonzero(np.diff(rollout.payload) > 0)[-1]
    assert rollout.grip[held + 5] == pytest.approx(60.0, abs=0.5) and rollout.grip[0] == 0.0 and rollout.grip[-1] == 0.0
    pads = [t for t in rollout.touches[held + 5] if t.a.startswith("effector/")]
    assert pads and all(t.press is not None and t.pressed <= t.force + 1e-6 for t in pads)
    assert max(t.pressed for t in pads) == pytest.approx(60.0, rel=0.05)
