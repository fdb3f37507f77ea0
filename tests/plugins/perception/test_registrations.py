"""Other registrations as experts: asked in place of the default, and recordings through the hook."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from cramlite import Engine, data_folder
from cramlite.model import Pose, World
from cramlite.plugin import Expert, Inputs, Judged, UserError
from cramlite_plugins.locations.viewpoints import looking_at
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.perception.pose.registration import FITTING, hypotheses
from cramlite_plugins.simulation.camera.depth_camera import render
from cramlite_plugins.simulation.model.compile import compile_world


def _inputs(confidence: float) -> Inputs:
    box = block("box", Pose((0.5, 0, 0.045)), (0.06, 0.05, 0.09))
    compiled = compile_world(World((box,)), {})
    view, ids = render(compiled.model, compiled.data(), looking_at((0.1, 0.1, 0.35), (0.5, 0, 0.05)), seed=1)
    mask = ids == compiled.things["box"].body
    values = {"view": view, "clean": mask, "candidates": (Judged("box", confidence),), "models": (box,)}
    return Inputs(values, {p.name: p.default for p in FITTING})


PAPER = data_folder("experiments") / "pose_recipes" / "paper_registration.py"


def _registrations(engine: Engine) -> dict[str, Expert]:
    return {e.name: e for e in engine.knowledge.experts if "hypotheses" in e.outputs and "clean" in e.inputs}


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["registration", "paper_registration"])
def test_registrations_make_hypotheses(name: str) -> None:
    fits = _registrations(Engine(files=[PAPER]))[name].run(_inputs(0.9))["hypotheses"]
    assert np.linalg.norm(np.subtract(fits[0].pose.position, (0.5, 0, 0.045))) < 0.02 and fits[0].reason


def test_what_looks_like_nothing_has_no_hypotheses() -> None:
    assert hypotheses(_inputs(0.0))["hypotheses"] == ()


def test_the_default_is_asked_first_and_the_others_without_it() -> None:
    cost = {name: e.cost_ms for name, e in _registrations(Engine(files=[PAPER])).items()}
    assert min(cost, key=cost.__getitem__) == "registration" and "paper_registration" in cost
    assert set(_registrations(Engine())) == {"registration", "open3d_registration", "small_gicp_registration"}
    others = {e.name for e in Engine(blocked=("perception_registration",)).knowledge.experts}
    assert "registration" not in others and "plausibility" in others


def test_a_recording_is_read_through_the_hook(tmp_path: Path) -> None:
    camera = {"fx": 60.0, "fy": 60.0, "cx": 31.5, "cy": 23.5, "width": 64, "height": 48}
    path = tmp_path / "shot.npz"
    np.savez(path, depth=np.full((48, 64), 0.8), intrinsics=json.dumps(camera))
    assert Engine().registry.first("read_view", path=path).depth[0, 0] == pytest.approx(0.8)
    assert Engine().registry.first("read_view", path=tmp_path) is None
    np.savez(path, depth=np.zeros((48, 64)), intrinsics=json.dumps(camera))
    with pytest.raises(UserError, match="no pixel has a depth"):
        Engine().registry.first("read_view", path=path)
