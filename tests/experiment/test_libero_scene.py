"""The scene that LIBERO's judge hands out reads as the model that it was saved from, which MuJoCo's own text does not."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import mujoco
import numpy as np
import pytest
from conftest import ROOT

SCENE = """
<mujoco>
  <compiler inertiagrouprange="0 0"/>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="bowl" pos="0 0 0.1"><freejoint/>
      <geom type="box" size="0.02 0.03 0.01" pos="0.01 0 0" density="100"/>
      <geom type="sphere" size="0.05" group="1" contype="0" conaffinity="0" density="100"/>
      <body pos="0 0 0.1"><geom type="sphere" size="0.05" group="1" contype="0" conaffinity="0"/></body>
    </body>
    <body name="tin" pos="0.3 0 0.1"><freejoint/><inertial pos="0 0 0.01" mass="0.4" diaginertia="0.001 0.002 0.0025"/>
      <geom type="box" size="0.02 0.03 0.01"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """The judge's script as a module; it needs LIBERO only when it is asked for an episode."""
    spec = importlib.util.spec_from_file_location("libero_judge", ROOT / "experiments" / "libero" / "judge.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_is_only_drawn_does_not_weigh_when_it_is_read_again(script: ModuleType) -> None:
    spec = mujoco.MjSpec.from_string(SCENE)
    model = spec.compile()
    saved = spec.to_xml().replace('inertiagrouprange="0 0"', "")  # as older versions of MuJoCo save it
    again, own = (mujoco.MjModel.from_xml_string(text) for text in (script.with_inertia(saved, model), saved))
    for name in ("body_mass", "body_ipos", "body_inertia"):
        assert np.allclose(getattr(again, name)[1:], getattr(model, name)[1:], rtol=1e-9, atol=1e-15), name
    assert own.body("bowl").mass[0] > 10 * model.body("bowl").mass[0], "without it the bowl is another one"
