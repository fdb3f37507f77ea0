"""movep of the virtual UR controller: around corners at one speed."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_programs import down, script
from hypothesis import assume, given
from hypothesis import strategies as st

from cramlite.model import Pose
from cramlite_plugins.simulation.controller.movep import process_motion


def movep(*places: tuple[float, float, float], r: float, v: float = 0.1, last: str = "") -> str:
    """A movel to the first place and movep along the others, looking down, all but the last with a blend radius."""
    there = [", ".join(f"{x:.6f}" for x in (*p, *down(*p).rotvec)) for p in places]
    lines = [f"  movej(get_inverse_kin(p[{there[0]}]))"]
    lines += [f"  movep(p[{p}], a=0.5, v={v}, r={r})" for p in there[1:-1]]
    return "\n".join([*lines, last or f"  movep(p[{there[-1]}], a=0.5, v={v})"])


SQUARE = ((0.45, -0.1, 0.3), (0.6, -0.1, 0.3), (0.6, 0.1, 0.3), (0.45, 0.1, 0.3))


def test_movep_goes_around_corners_on_circles_at_one_speed() -> None:
    rollout = script(movep(*SQUARE, r=0.05))
    assert rollout.outcome == "finished", rollout.reason
    places = rollout.poses["effector"][:, :3]
    speeds = np.linalg.norm(places[2:] - places[:-2], axis=1) / (rollout.times[2:] - rollout.times[:-2])  # 5 control cycles
    begin = int(np.linalg.norm(places - SQUARE[0], axis=1).argmin())
    cruise = speeds[begin:][speeds[begin:] > 0.02]
    assert np.median(cruise) == pytest.approx(0.1, abs=0.003)
    assert cruise[20:-20].min() > 0.09, "it does not slow down in the corners"
    corner = np.linalg.norm(places[begin:] - SQUARE[1], axis=1).min()
    assert corner == pytest.approx(0.05 * (math.sqrt(2) - 1), abs=0.003), "the circle that touches both lines 50 mm away"
    centre = np.array((0.55, -0.05, 0.3))
    round_ = [p for p in places[begin:] if p[0] > 0.551 and p[1] < -0.051]
    assert len(round_) > 10
    assert np.linalg.norm(np.array(round_) - centre, axis=1) == pytest.approx(0.05, abs=0.003)
    assert np.linalg.norm(places[-1] - SQUARE[-1]) < 4e-3  # it sags


def test_movep_without_a_radius_stops_at_the_corner() -> None:
    rollout = script(movep(*SQUARE[:3], r=0.0))
    places = rollout.poses["effector"][:, :3]
    assert rollout.outcome == "finished" and np.linalg.norm(places - SQUARE[1], axis=1).min() < 4e-3


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (movep(*SQUARE, r=0.09), "takes more than half of a motion of 0.150 m"),
        (f"  thread t():\n{movep(*SQUARE[:3], r=0.05, last='  x = 1')}\n  end\n  run t()\n  sleep(9)", "must be followed by another movep"),
        (movep(*SQUARE[:2], SQUARE[0], r=0.05), "turns straight back"),
        ("  movep(pose_trans(get_target_tcp_pose(), p[0, 0, 0, 0, 0, 0.3]), a=0.5, v=0.1)", "turn on the spot with movel"),
        (movep(*SQUARE[:3], r=0.05, last="  movep(p[0.6, 0.1, 0.3, 0, 3.14, 0], a=0.5, v=0.2)"), "the same v and a"),
        (movep(*SQUARE[:3], r=-0.05), "radius of 0 or more"),
    ],
)
def test_a_movep_that_cannot_be_blended_says_why(body: str, said: str) -> None:
    rollout = script(body)
    assert rollout.outcome == "error" and said in rollout.reason, rollout.reason


def test_a_movep_to_where_the_tool_is_by_then_takes_no_time_as_in_a_round_that_ends_where_it_began() -> None:
    once, twice = (script(movep(*SQUARE[:3], *again, r=0.02)) for again in ((), (SQUARE[2], SQUARE[2])))
    assert (once.outcome, twice.outcome) == ("finished", "finished"), twice.reason
    assert twice.times[-1] == pytest.approx(once.times[-1], abs=0.05)
    stays = script(movep(SQUARE[0], SQUARE[0], r=0.0))
    assert stays.outcome == "finished", stays.reason


@examples(25)
@given(
    st.lists(st.tuples(*[st.floats(-0.5, 0.5)] * 3), min_size=3, max_size=5, unique=True),
    st.floats(0.02, 0.98), st.tuples(*[st.floats(-1, 1)] * 3),
)  # fmt: skip
def test_the_way_of_a_movep_has_no_jumps(places: list[tuple[float, float, float]], part: float, turn: tuple[float, float, float]) -> None:
    """Neighbouring places are as far apart as the speed says, the turn goes on steadily, and both ends are met."""
    poses = [Pose.from_rotvec(p, [k * t / 2 for t in turn]) for k, p in enumerate(places)]
    lengths = [math.dist(a, b) for a, b in pairwise(places)]
    assume(min(lengths) > 0.05)
    try:
        motion = process_motion(poses, [part * min(lengths) / 2] * (len(places) - 2), 0.25, 1.0)
    except ValueError as error:
        assume("straight back" not in str(error))
        raise
    times = np.linspace(0, motion.duration, 150)
    found = [motion.at(float(t)) for t in times]
    assert math.dist(found[0].position, places[0]) < 1e-9 and math.dist(found[-1].position, places[-1]) < 1e-9
    assert found[-1].distance(poses[-1])[1] < 1e-6
    step = float(times[1])
    corners = [math.acos(max(-1.0, min(1.0, float(a @ b)))) for a, b in pairwise(np.diff(places, axis=0) / np.reshape(lengths, (-1, 1)))]
    shorter = max(2 * math.tan(c / 2) / c if c > 1e-3 else 1.0 for c in corners)  # two halves of a line against the arc
    fastest = math.hypot(*turn) / 2 * shorter
    for a, b in pairwise(found):
        way, angle = a.distance(b)
        assert way <= 0.25 * step + 1e-9
        assert angle <= 1.01 * fastest * 0.25 * step / min(lengths) + 1e-6
