"""Chest with a drawer, and a cube, as MJCF files of a library."""

from __future__ import annotations

from pathlib import Path

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
