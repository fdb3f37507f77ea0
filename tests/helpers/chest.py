"""Chest with a drawer, and a cube, as MJCF files of a library; a chest on a table, and a picture of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cramlite import Engine
from cramlite.model import Camera, Intrinsics, Pose, Thing, View, World
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.simulation.camera.depth_camera import look

from .as_a_user import cramlite

CHEST = """<mujoco><worldbody><body name="chest">
  <geom type="box" size=".1 .09 .005" pos="0 0 .005" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".1 .09 .005" pos="0 0 .125" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".1 .005 .055" pos="0 .085 .065" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".1 .005 .055" pos="0 -.085 .065" rgba=".55 .35 .2 1"/>
  <geom type="box" size=".005 .08 .055" pos="-.095 0 .065" rgba=".55 .35 .2 1"/>
  <body name="drawer"><joint name="slide" type="slide" axis="1 0 0" range="0 .16" damping="5" frictionloss="1"/>
    <geom type="box" size=".005 .076 .051" pos=".105 0 .066" rgba=".2 .3 .7 1"/>
    <geom type="box" size=".085 .075 .003" pos="0 0 .018" rgba=".8 .75 .3 1"/>
    <geom type="box" size=".085 .003 .03" pos="0 .072 .047" rgba=".8 .75 .3 1"/>
    <geom type="box" size=".085 .003 .03" pos="0 -.072 .047" rgba=".8 .75 .3 1"/>
    <geom type="box" size=".006 .046 .006" pos=".14 0 .065" rgba=".1 .1 .1 1"/>
    <geom type="box" size=".015 .006 .006" pos=".12 .04 .065" rgba=".1 .1 .1 1"/>
    <geom type="box" size=".015 .006 .006" pos=".12 -.04 .065" rgba=".1 .1 .1 1"/>
  </body></body></worldbody></mujoco>"""
CUBE = """<mujoco><worldbody><body name="cube"><freejoint/>
  <geom type="box" size=".02 .025 .03" rgba=".8 .15 .2 1" mass=".1"/></body></worldbody></mujoco>"""


def write_chest(folder: Path) -> None:
    """Write the files of both kinds."""
    for name, text in (("chest", CHEST), ("cube", CUBE)):
        (folder / name).mkdir(parents=True)
        (folder / name / f"{name}.xml").write_text(text)


def engine_with_chest(folder: Path) -> Engine:
    """Return an engine that knows both kinds, from a library that the command line made in a folder."""
    write_chest(folder / "kinds")
    assert cramlite("library", "add", folder / "kinds", "--out", folder / "lib", "--up", "z").returncode == 0
    return Engine(models=[folder / "lib"])


def chest(engine: Engine, opened: float) -> Thing:
    """A chest on the table, turned a little, its drawer open by so much [m]."""
    pose = Pose.from_rotvec((0.40, 0.02, 0.0), (0, 0, 0.2))
    return engine.knowledge.models["chest"].make(name="a_chest", pose=pose).at_joints({"slide": opened})


def pictured(*things: Thing) -> View:
    """A noisy picture of things on a table from 0.9 m away."""
    eye, target = np.array((1.1, 0.0, 0.65)), np.array((0.45, 0.0, 0.05))
    intrinsics = Intrinsics(450.0, 450.0, 199.5, 149.5, 400, 300)
    camera = Camera(Pose.from_axes(tuple(eye), target - eye, np.cross(target - eye, (0, 0, 1))), intrinsics=intrinsics)
    return look(World((make("table", "table", Pose((0.45, 0, 0)), {}), *things)), {}, camera, seed=1)
