"""What lies on the payload when the rest is resolved goes along with it; what stands beside it does not."""

from __future__ import annotations

from pathlib import Path

from msgspec.structs import replace

from cramlite import Engine, read_scenario
from cramlite.engine.setting import Setting, with_load
from cramlite.model import InHand, Pose

ENGINE = Engine()
PILE = """scenario: pile
robot: {type: ur5e}
tasks: []
things:
  - {name: floor, model: table, at: {position: [0.3, 0, -5 mm]}, with: {size: [1.2 m, 1.2 m, 20 mm]}}
  - {name: taken, model: block, at: {position: [0.5, 0.2, 31 mm]}}
  - {name: upper, model: block, at: {position: [0.5, 0.2, 92 mm]}}
  - {name: top, model: block, at: {position: [0.5, 0.2, 153 mm]}}
  - {name: beside, model: block, at: {position: [0.5, -0.2, 31 mm]}}
"""
GRIP = Pose((0.0, 0.0, 0.03))


def _holding(folder: Path, name: str) -> Setting:
    (folder / "pile.yaml").write_text(PILE)
    setting = ENGINE.setting(read_scenario(folder / "pile.yaml"))
    mount = replace(setting.world.robots[0], holds=InHand(name, GRIP, 40.0))
    return with_load(replace(setting, world=replace(setting.world, robots=(mount,))), ENGINE.knowledge)


def test_what_lies_on_the_payload_goes_along_also_through_others(tmp_path: Path) -> None:
    belief = _holding(tmp_path, "taken").belief()
    assert belief.in_hand().keys() == {"taken", "upper", "top"} and belief.poses.keys() == {"floor", "beside"}
    metres, _ = belief.in_hand()["top"].distance(GRIP * Pose((0.0, 0.0, 0.122)))
    assert metres < 1e-9


def test_what_is_under_it_or_beside_it_stays(tmp_path: Path) -> None:
    assert _holding(tmp_path, "top").belief().in_hand().keys() == {"top"}
    assert _holding(tmp_path, "beside").belief().in_hand().keys() == {"beside"}


def test_an_empty_hand_takes_nothing_along(tmp_path: Path) -> None:
    full = _holding(tmp_path, "taken")
    let_go = replace(full, world=replace(full.world, robots=(replace(full.world.robots[0], holds=None),)))
    assert full.carried == ("upper", "top") and with_load(let_go, ENGINE.knowledge).carried == ()
