"""Grip force from weight and friction: what is just held, and what is refused once, before any program, with the numbers."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Budget, Engine, Solution, Trace, read_scenario
from cramlite.model import Filling, Held, Pose, World, pair_friction
from cramlite.plugin import UserError
from cramlite_plugins.motions.grip_force import GripLoad, grip_of, load
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.robotiq_2f85 import GRIPPER
from cramlite_plugins.validators.grip_strength import explained

ORIGIN = Pose()
SCENARIO = """
scenario: gripped
tasks:
  - {{task: Grasping, Patient: block{parameters}}}
  - {{task: PickingUp, Locatum: block, Relatum: floor}}
robot: {{type: ur5e}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - name: block
    model: block
    at: {{position: [0.5, 0.2, 51 mm]}}{bears}
    with: {{size: [50 mm, 50 mm, 100 mm], mass: {mass}, friction: {friction}}}
"""


def resolved(
    folder: Path, mass: str, friction: float, parameters: str = "", bears: str = "", proofs: int = 8
) -> tuple[Solution | None, Trace, int]:
    """The first solution, the trace, and how many programs were made."""
    path, trace = folder / "gripped.yaml", Trace()
    bears = f"\n    max_grip_force: {bears}" if bears else ""
    parameters = f", parameters: {{{parameters}}}" if parameters else ""
    path.write_text(SCENARIO.format(mass=mass, friction=friction, parameters=parameters, bears=bears))
    engine, made, solution = Engine(), 0, None
    scenario = read_scenario(path)
    for candidate in engine.candidates(scenario, budget=Budget(proofs=proofs), trace=trace):
        for attempt in candidate.attempts():
            made += 1
            if attempt.verdict.passed:
                return attempt, trace, made
    return solution, trace, made


def reasons(trace: Trace) -> list[str]:
    return [e.reason for e in trace.entries if e.outcome in ("impossible", "failed")]



def test_a_heavy_block_without_friction_is_refused_once_and_said_why(tmp_path: Path) -> None:
    solution, trace, made = resolved(tmp_path, "4 kg", 0.0)
    assert solution is None and made == 0
    said = [r for r in reasons(trace) if "grip force" in r]
    assert said == ["no grip force holds 4 kg (39.2 N) on friction 0 (pads 0.9, 'block' 0); 235 N is the most of gripper 'robotiq_2f85'"]


def test_what_the_strongest_grip_does_not_hold_is_refused_with_the_numbers(tmp_path: Path) -> None:
    solution, trace, made = resolved(tmp_path, "4 kg", 0.05)
    assert solution is None and made == 0
    said = [r for r in reasons(trace) if "on each pad" in r]
    assert said == [
        "4 kg (39.2 N) on friction 0.0947 (pads 0.9, 'block' 0.05) needs 581 N on each pad, with a margin of 2.5 and 1.2 m/s2 of"
        " the arm, > 235 N, the most of gripper 'robotiq_2f85'"
    ]


def test_its_sibling_is_just_held(tmp_path: Path) -> None:
    """Needed are 4 x 11.01 x 2.5 / (2 x 0.2423) = 227 N of 235 N."""
    solution, _, made = resolved(tmp_path, "4 kg", 0.14)
    assert solution is not None and made == 1


@pytest.mark.heavy
@pytest.mark.parametrize(("friction", "held"), [(0.05, False), (0.14, True)])
def test_a_force_that_is_given_stays_and_the_physics_says_whether_it_holds(friction: float, held: bool, tmp_path: Path) -> None:
    """50 N on each pad carry 2 x 50 x 0.0947 = 9.5 N of a weight of 14.7 N, or 24 N of it."""
    solution, trace, made = resolved(tmp_path, "1.5 kg", friction, "force_n: 50", proofs=1)
    assert made == 1
    assert (solution is not None) == held
    doubted = [e.reason for e in trace.entries if "which carries 9.5 N: doubtful for 1.5 kg (14.7 N) on friction 0.0947" in e.reason]
    assert bool(doubted) != held
    slipped = [r for r in reasons(trace) if "grip_strength: 'block' slipped" in r]
    assert bool(slipped) != held
    if not held:
        assert any("2.PickingUp 'grasps(Gripper, Locatum)' does not hold" in r for r in reasons(trace))
        assert (
            "50 N on each pad carry 9.5 N of 1.5 kg (14.7 N) on friction 0.0947 (pads 0.9, 'block' 0.05); 78 N just carry it,"
            " 218 N with a margin of 2.5 and 1.2 m/s2 of the arm (gripper 'robotiq_2f85': 20 .. 235 N)"
        ) in slipped[0]


def test_what_the_thing_bears_limits_the_wish(tmp_path: Path) -> None:
    free, _, _ = resolved(tmp_path, "500 g", 0.6)
    soft, trace, _ = resolved(tmp_path, "500 g", 0.6, bears="22 N")
    assert free is not None and soft is not None
    assert ", 22 N" not in free.code and ", 22 N" in soft.code
    assert any("grip 22 N instead of" in e.reason and "N, the max_grip_force of 'block' for 0.5 kg" in e.reason for e in trace.entries)


def test_what_bears_less_than_its_weight_needs_is_refused_once(tmp_path: Path) -> None:
    solution, trace, made = resolved(tmp_path, "2 kg", 0.6, bears="30 N")
    assert solution is None and made == 0
    said = [r for r in reasons(trace) if "on each pad" in r]
    assert len(said) == 1 and "needs 38 N" in said[0] and said[0].endswith("> 30 N, the max_grip_force of 'block'")


def test_what_bears_less_than_the_gripper_presses_is_refused_once(tmp_path: Path) -> None:
    solution, trace, made = resolved(tmp_path, "100 g", 0.6, bears="12 N")
    assert solution is None and made == 0
    assert [r for r in reasons(trace) if "12 N" in r] == [
        "the gripper presses with 20 N at least, more than 12 N: the max_grip_force of 'block'"
    ]


@pytest.mark.parametrize(("written", "said"), [("0 N", "0.1"), ("-3 N", "0.1"), ("1e12", "1000"), ("3 kg", "'kg' is not a unit of force")])
def test_a_limit_beyond_reason_is_refused_with_its_line(written: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=rf"gripped\.yaml:\d+: .*max_grip_force.*{said}"):
        resolved(tmp_path, "100 g", 0.6, bears=written)


def held(mass: float, friction: float, at: Pose = ORIGIN) -> GripLoad:
    """A block between pads of 0.9."""
    item = block("block", Pose(), mass=mass, friction=friction)
    return grip_of(Held("block", at, 0.06), World((item,)), GRIPPER)


def test_without_friction_no_force_carries() -> None:
    assert explained(held(1.0, 0.0), 50.0) == (
        "50 N on each pad carry 0.0 N of 1 kg (9.8 N) on friction 0 (pads 0.9, 'block' 0); no force does"
    )


@given(st.floats(0.01, 10.0), st.floats(0.01, 1.0))
def test_the_least_holds_the_weight_with_the_margin(mass: float, friction: float) -> None:
    grip = held(mass, friction)
    assert 2 * grip.friction * grip.least == pytest.approx(2.5 * mass * 11.01)
    assert grip.friction == pair_friction(0.9, friction)
    assert grip.least < grip.wanted < math.inf


@given(st.floats(0.0, 0.1), st.floats(0.0, 0.1), st.floats(0.0, 0.1))
def test_only_what_is_off_the_line_between_the_pads_turns(x: float, y: float, z: float) -> None:
    assert held(0.5, 0.6, Pose((x, y, z))).lever == pytest.approx(math.hypot(x, z), abs=1e-12)


def test_contents_weigh_and_rails_carry() -> None:
    full = replace(block("b", Pose(), mass=0.3), filling=Filling(100, 0.005, 0.001))
    assert load(full) == pytest.approx(0.4)
    at = Pose((0.75, 0.1, 0.35))
    pulled = drawer("drawer", at, "cabinet")
    assert pulled.mass and load(pulled) == 0.0 and load(cabinet("cabinet", at)) == 0.0
    assert grip_of(Held("drawer", Pose(), 0.02), World((pulled,)), GRIPPER).least == 0.0


def test_the_smoothest_face_counts_but_no_tab() -> None:
    item = block("b", Pose(), friction=0.6)
    smooth, tab = replace(item.geoms[0], friction=0.2), replace(item.geoms[0], friction=0.1, part="tab")
    assert replace(item, geoms=(*item.geoms, smooth, tab)).least_friction == 0.2
    assert item.least_friction == 0.6
