"""From a recording of a person to a proven program in a world of one's own; and worlds in which there must be none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bson
import pytest
from helpers.recorded_people import Recording, pouring, shaking

from cramlite import Engine, read_scenario

pytestmark = pytest.mark.heavy

WORLD = """
scenario: as_shown
title: As a person showed it
demonstration: recording
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: counter, model: table, at: {position: [0.55, 0, 0.15]}, with: {size: [0.4 m, 0.9 m, 40 mm]}}
  - {name: jug, model: jug, at: {position: [0.55, 0.2, 0.201], yaw: 180 deg}, with: {GRAINS}}
  - {name: bowl, model: bowl, at: {position: [BOWL_X, -0.15, 0.176]}, with: {BOWL}}
budget: {proofs: 2, sequences: 2}
"""
PLAIN = {"GRAINS": "grains: 12, grain_radius: 6 mm, grain_mass: 1 g", "BOWL_X": "0.55", "{BOWL}": "{}"}


def written(recording: Recording, folder: Path) -> None:
    """A mongodump as KnowRob writes it, in milliseconds."""
    place = folder / "recording" / "tf" / "roslog"
    place.mkdir(parents=True)
    documents = []
    for name, rows in recording.items():
        for t, x, y, z, qw, qx, qy, qz in rows.tolist():
            where = {"translation": {"x": x, "y": y, "z": z}, "rotation": {"x": qx, "y": qy, "z": qz, "w": qw}}
            header = {"seq": 0, "stamp": bson.datetime_ms.DatetimeMS(round(1000 * t)), "frame_id": "map"}
            documents.append(bson.encode({"header": header, "child_frame_id": name, "transform": where}))
    (place / "tf.bson").write_bytes(b"".join(documents))


def solved(folder: Path, recording: Callable[[], Recording], **changes: str) -> list[str]:
    """The tasks of the first proven program, with what is grasped; none where nothing was proven."""
    written(recording(), folder)
    text = WORLD
    for key, value in {**PLAIN, **changes}.items():
        text = text.replace(key, value)
    (folder / "as_shown.yaml").write_text(text)
    solution = next(iter(Engine().resolve(read_scenario(folder / "as_shown.yaml"))), None)
    if solution is None:
        return []
    taken = solution.candidate.actions[0].roles["Patient"].entity
    return [f"Grasping {taken}", *(a.task.split(":")[1] for a in solution.plan.actions[1:])]


def test_a_pouring_is_poured_and_put_back(tmp_path: Path) -> None:
    done = solved(tmp_path, pouring)
    assert done == ["Grasping jug", "PickingUp", "Transporting", "Pouring", "PuttingDown", "Releasing", "Retracting"]


def test_a_shaking_is_shaken_and_put_back(tmp_path: Path) -> None:
    done = solved(tmp_path, shaking)
    assert done == ["Grasping jug", "PickingUp", "Transporting", "Shaking", "PuttingDown", "Releasing", "Retracting"]


@pytest.mark.parametrize(
    "changes",
    [{"GRAINS": "grains: 0"}, {"BOWL_X": "1.6"}, {"{BOWL}": "{radius: 15 mm, height: 15 mm}"}],
    ids=["an empty jug", "a bowl out of reach", "a bowl too small"],
)
def test_where_it_cannot_be_poured_there_is_no_program(changes: dict[str, str], tmp_path: Path) -> None:
    assert solved(tmp_path, pouring, **changes) == []
