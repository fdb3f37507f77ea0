"""A plate beside a wall, with no room for a hand behind it, is pushed by fingers in it, around what is in its way; a flat board is not."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cramlite import Budget, Engine, Trace, failure_text, read_scenario

SCENE = """
<mujoco><worldbody>
<body name="table"><geom name="top" type="box" size=".6 .6 .02" pos=".2 0 -.02" friction=".6 .005 .0001"/>
<site name="table_left_region" type="box" size=".04 .04 .005" pos=".45 .25 0"/></body>
<body name="wall" pos=".45 -.12 .04"><geom type="box" size=".12 .01 .04"/></body>
<body name="plate" pos=".45 0 .003"><freejoint/>{plate}</body>
</worldbody></mujoco>"""
BASE = '<geom type="cylinder" size=".04 .003" pos="0 0 0" mass=".1" friction=".6 .005 .0001"/>'
TILT = math.radians(20)
"""Of the rim, whose slabs stand up outwards like a plate's: pads from above find no two faces to close on."""


def _slab(turn: float, half: float = 0.03, at: float = 0.062, mass: float = 0.01, friction: float = 0.6) -> str:
    """One of the slabs of the rim, at this angle about the middle [rad]."""
    c, s = math.cos(turn / 2), math.sin(turn / 2)
    y, w = -math.sin(TILT / 2), math.cos(TILT / 2)
    up = (half - 0.001) * math.sin(TILT)
    return (
        f'<geom type="box" size="{half} .028 .003" pos="{at * math.cos(turn):.5f} {at * math.sin(turn):.5f} {up:.5f}" mass="{mass}"'
        f' quat="{c * w:.6f} {-s * y:.6f} {c * y:.6f} {s * w:.6f}" friction="{friction} .005 .0001"/>'
    )


RIM = "".join(_slab(k * math.tau / 8) for k in range(8))
LIGHT = '<geom type="cylinder" size=".032 .003" mass=".006" friction=".95 .005 .0001"/>'
LIGHT += "".join(_slab(k * math.tau / 8, half=0.019, at=0.051, mass=0.003, friction=0.95) for k in range(8))
"""As light and as rough as LIBERO's plate."""
ASKED = "scenario: plate\ntasks: [{{task: Pushing, Patient: plate, where: {{region: left_region}}, parameters: {{press_n: {press}}}}}]\n"
ASKED += "robot: {{type: ur5e}}\nworld: {{file: scene.xml}}\n"
SCENARIO = "scenario: plate\ngoal: [plate on table/left_region]\nrobot: {type: ur5e}\nworld: {file: scene.xml}\n"


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


def _pushed(engine: Engine, folder: Path, plate: str, scenario: str = SCENARIO) -> tuple[str, str]:
    """The text of the program that achieves the goal, and why there is none."""
    (folder / "scene.xml").write_text(SCENE.format(plate=plate))
    (folder / "scenario.yaml").write_text(scenario)
    trace = Trace()
    found = next(engine.resolve(read_scenario(folder / "scenario.yaml"), budget=Budget(sequences=2, proofs=2), trace=trace), None)
    reasons = " ".join(e.text for e in trace.entries if e.designator == "1.Pushing" and e.outcome == "chosen")
    return (reasons, "") if found else ("", failure_text(trace, engine.registry.faults))


@pytest.mark.heavy
def test_fingers_in_it_push_a_plate_away_from_a_wall(engine: Engine, tmp_path: Path) -> None:
    ways, reasons = _pushed(engine, tmp_path, BASE + RIM)
    assert ways.endswith("push its rim from inside, straight"), reasons


@pytest.mark.heavy
def test_fingers_press_on_a_light_plate_and_slip_out_of_it_where_they_hardly_do(engine: Engine, tmp_path: Path) -> None:
    ways, reasons = _pushed(engine, tmp_path, LIGHT, ASKED.format(press=10))
    assert ways.endswith("push its rim from inside, straight"), reasons
    ways, reasons = _pushed(engine, tmp_path, LIGHT, ASKED.format(press=1))
    assert not ways and "'touches(Gripper, Patient)' does not hold" in reasons


@pytest.mark.heavy
def test_a_board_without_a_rim_is_refused_there(engine: Engine, tmp_path: Path) -> None:
    ways, reasons = _pushed(engine, tmp_path, BASE)
    assert not ways
    assert "wall" in reasons or "no rim" in reasons
