"""A plate that no hand gets hold of and that a drawer would meet is pushed aside first; one that a fence keeps there is not, and the
drawer stays shut."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cramlite import Budget, Engine, Trace, failure_text, read_scenario

TILT = math.radians(20)
"""Of the rim of the plate, whose slabs stand up outwards: pads from above find no two faces to close on."""


def _slab(turn: float) -> str:
    """One of the slabs of the rim, at this angle about the middle [rad]."""
    c, s, y, w = math.cos(turn / 2), math.sin(turn / 2), -math.sin(TILT / 2), math.cos(TILT / 2)
    at = f"{0.062 * math.cos(turn):.5f} {0.062 * math.sin(turn):.5f} {0.029 * math.sin(TILT):.5f}"
    turned = f"{c * w:.6f} {-s * y:.6f} {c * y:.6f} {s * w:.6f}"
    return f'<geom type="box" size=".03 .028 .003" pos="{at}" mass=".003" quat="{turned}" friction=".6 .005 .0001"/>'


SCENE = """
<mujoco><worldbody>
<body name="table"><geom name="top" type="box" size=".6 .6 .02" pos=".2 0 -.02" friction=".6 .005 .0001"/></body>{fence}
<body name="cabinet" pos=".73 0 .09"><geom type="box" size=".09 .11 .005" pos="0 0 .085"/>
<geom type="box" size=".09 .005 .08" pos="0 .1 0"/>
<geom type="box" size=".09 .005 .08" pos="0 -.1 0"/>
<body name="drawer"><joint name="rail" type="slide" axis="-1 0 0" range="0 .16" damping="5"/>
<geom type="box" size=".005 .09 .07" pos="-.1 0 .002" mass=".2"/><geom type="box" size=".08 .08 .004" pos="-.01 0 -.05" mass=".2"/>
<geom name="drawer_handle" type="box" size=".006 .05 .006" pos="-.135 0 .03" mass=".02"/>
<geom type="box" size=".015 .004 .004" pos="-.12 .045 .03" mass=".01"/>
<geom type="box" size=".015 .004 .004" pos="-.12 -.045 .03" mass=".01"/></body></body>
<body name="plate" pos=".47 .14 .003"><freejoint/>
<geom type="cylinder" size=".04 .003" mass=".03" friction=".6 .005 .0001"/>{rim}</body>
</worldbody></mujoco>"""
RIM = "".join(_slab(k * math.tau / 8) for k in range(8))
FENCE = '<body name="fence">{}</body>'.format(
    "".join(
        f'<geom type="box" size="{size} .009" pos="{x} {y} .009"/>'
        for size, x, y in ((".11 .004", 0.47, 0.25), (".11 .004", 0.47, 0.03), (".004 .11", 0.36, 0.14), (".004 .11", 0.58, 0.14))
    )
)
"""Lower than the drawer, and higher than where the plate's rim begins to rise."""
SCENARIO = "scenario: drawer\ngoal: [drawer open]\nrobot: {type: ur5e}\nworld: {file: scene.xml}\n"


def _opened(folder: Path, fence: str) -> tuple[str, Trace]:
    """The tasks that open the drawer, and what was refused."""
    (folder / "scene.xml").write_text(SCENE.format(rim=RIM, fence=fence))
    (folder / "scenario.yaml").write_text(SCENARIO)
    trace, engine = Trace(), Engine()
    setting = engine.setting(scenario := read_scenario(folder / "scenario.yaml"), twins=0)
    solutions = engine.resolve(scenario, setting=setting, budget=Budget(sequences=3, proofs=2), trace=trace)
    found = next(solutions, None)
    return str(found.plan) if found else "", trace


pytestmark = pytest.mark.heavy


def test_a_plate_before_a_drawer_is_pushed_aside_first(tmp_path: Path) -> None:
    tasks, trace = _opened(tmp_path, "")
    assert tasks == "Pushing -> Retracting -> Opening", failure_text(trace, ())


def test_within_a_fence_it_is_not_and_the_drawer_stays_shut(tmp_path: Path) -> None:
    tasks, trace = _opened(tmp_path, FENCE)
    refused = [e.reason for e in trace.entries if e.outcome in ("refused", "impossible")]
    assert not tasks
    assert any("'drawer' is" in r and "inside 'plate'" in r for r in refused) and any("'plate' is" in r and "'fence'" in r for r in refused)
