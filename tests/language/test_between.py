"""Things on the line between two others are between them, more than things beside that line."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, NotUnderstood, read_scenario
from cramlite.planning.spoken_goals import understand

ENGINE = Engine()
SCENE = """\
scenario: between
goal: [tin in basket]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.8 m, 1.8 m, 20 mm]}}
  - {name: basket, model: basket, at: {position: [0.5, 0.35, 5 mm]}, with: {size: [0.3 m, 0.3 m, 0.12 m]}}
  - {name: tin, model: can, type: cram:Tin, at: {position: [0.5, -0.2, 31 mm]}, with: {radius: 28 mm, height: 70 mm, mass: 200 g}}
"""


def goals(folder: Path, *cubes: tuple[float, float]) -> tuple[str, ...]:
    """What a sentence means, of cubes between a basket and a tin."""
    size = "with: {size: [50 mm, 50 mm, 50 mm]}"
    more = [f"  - {{name: cube_{k}, model: block, at: {{position: [{x}, {y}, 31 mm]}}, {size}}}\n" for k, (x, y) in enumerate(cubes)]
    (folder / "scene.yaml").write_text(SCENE + "".join(more))
    scene = ENGINE.setting(read_scenario(folder / "scene.yaml"), twins=0).symbolic(ENGINE.knowledge.taxonomy)
    return understand("put the cube between the basket and the tin in the basket", scene, ENGINE.knowledge).goals


def test_what_the_line_passes_through_is_meant(tmp_path: Path) -> None:
    assert goals(tmp_path, (0.5, 0.05), (0.6, -0.05)) == ("cube_0 in basket",)
    assert goals(tmp_path, (0.6, -0.05), (0.8, 0.05)) == ("cube_0 in basket",), "without such a one, one that is roughly between"


def test_two_on_the_line_are_asked_back(tmp_path: Path) -> None:
    with pytest.raises(NotUnderstood, match=r"may be cube_0 at .* or cube_1 at"):
        goals(tmp_path, (0.5, 0.05), (0.51, -0.08))
