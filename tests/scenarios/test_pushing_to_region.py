"""A flat thing that no hand gets hold of is pushed to a region, and is refused where something is in its way, or it is too heavy."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Budget, Engine, Goal, Trace, failure_text, planning_problem, read_scenario
from cramlite.planning.symbolic.plan_stream import task_plans

SCENE = """
<mujoco><worldbody>
<body name="table"><geom name="top" type="box" size=".6 .6 .02" pos=".2 0 -.02" friction=".6 .005 .0001"/>
<site name="table_left_region" type="box" size=".04 .04 .005" pos=".45 .25 0"/></body>
<body name="plate" pos=".5 0 .009"><freejoint/><geom type="cylinder" size=".09 .008" mass="{mass}" friction=".6 .005 .0001"/></body>
{rest}</worldbody></mujoco>"""
POST = '<body name="post" pos=".47 .17 .1"><geom type="box" size=".01 .01 .1"/></body>'
SCENARIO = "scenario: plate\ngoal: [plate on table/left_region]\nrobot: {type: ur5e}\nworld: {file: scene.xml}\n"


@pytest.fixture(scope="module")
def engine() -> Engine:
    return Engine()


def _pushed(engine: Engine, folder: Path, mass: float = 0.3, rest: str = "") -> tuple[str, str]:
    """The tasks that achieve the goal, and why there are none."""
    (folder / "scene.xml").write_text(SCENE.format(mass=mass, rest=rest))
    (folder / "scenario.yaml").write_text(SCENARIO)
    trace = Trace()
    found = next(engine.resolve(read_scenario(folder / "scenario.yaml"), budget=Budget(sequences=2, proofs=2), trace=trace), None)
    return (str(found.plan), "") if found else ("", failure_text(trace, engine.registry.faults))


def test_what_is_flat_is_carried_there_before_it_is_pushed(engine: Engine, tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(SCENE.format(mass=0.3, rest=""))
    (path := tmp_path / "scenario.yaml").write_text(SCENARIO)
    scene = engine.setting(read_scenario(path)).symbolic(engine.knowledge.taxonomy)
    plans = task_plans(planning_problem(Goal(("plate on table/left_region",)), scene, engine.knowledge))
    first = next(plans).steps
    assert [s.task for s in first] == ["soma:Grasping", "soma:PickingUp", "soma:Placing"]


@pytest.mark.heavy
def test_it_is_pushed_there(engine: Engine, tmp_path: Path) -> None:
    tasks, reasons = _pushed(engine, tmp_path)
    assert tasks == "Pushing -> Retracting", reasons


@pytest.mark.heavy
@pytest.mark.parametrize(("mass", "rest", "says"), [(0.3, POST, "mm from 'post'"), (30.0, "", "force")])
def test_what_is_blocked_or_too_heavy_is_refused(engine: Engine, tmp_path: Path, mass: float, rest: str, says: str) -> None:
    tasks, reasons = _pushed(engine, tmp_path, mass, rest)
    assert not tasks
    assert says in reasons and "Pushing" in reasons
