"""Meshes of what LIBERO's robot looks like, one for each of its bodies, as its cameras see them.

It runs in LIBERO's environment, before any episode, as part of kinds.py.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

LINKS = tuple(f"link{k}" for k in range(8))
"""Bodies whose meshes are written in their own frames."""
HAND, MOUNT = "right_gripper", "right_hand"
"""Body of the hand, and the one in whose frame its mesh and those of its fingers are written: the flange."""
FINGERS = {"leftfinger": 0.04, "rightfinger": -0.04}
"""Bodies of the fingers, and the positions of their joints when the hand is open [m]."""
VISIBLE = 1
"""Group of the geoms that robosuite's cameras see."""


def write_robot(folder: Path) -> None:
    """Write the visible meshes of the robot's bodies as OBJ files, named by the bodies."""
    from robosuite.models.grippers import PandaGripper
    from robosuite.models.robots import Panda
    from robosuite.models.world import MujocoWorldBase
    from robosuite.utils.binding_utils import MjSim

    robot, world = Panda(), MujocoWorldBase()
    robot.add_gripper(PandaGripper())
    world.merge(robot)
    sim = MjSim.from_xml_string(world.get_xml())
    folder.mkdir(parents=True, exist_ok=True)
    bodies = {name.split("_", 1)[1]: name for name in (sim.model.body_id2name(k) for k in range(1, sim.model.nbody)) if "_" in name}
    for finger, opened in FINGERS.items():
        sim.data.qpos[sim.model._model.body(bodies[finger]).jntadr[0]] = opened
    sim.forward()
    for part in (*LINKS, HAND, *FINGERS):
        frame = sim.model._model.body(bodies[part if part in LINKS else MOUNT]).id
        (folder / f"{part}.obj").write_text(obj_text(*surface(sim, sim.model._model.body(bodies[part]).id, frame)), encoding="utf-8")


def surface(sim: Any, body: int, frame: int) -> tuple[Any, Any]:
    """Return vertices (N, 3) [m] and triangles (M, 3) of a body's visible geoms, in the frame of a body."""
    model, data = sim.model._model, sim.data._data
    back, origin = data.xmat[frame].reshape(3, 3).T, data.xpos[frame]
    points, faces, count = [], [], 0
    for geom in np.flatnonzero((model.geom_bodyid == body) & (model.geom_group == VISIBLE) & (model.geom_dataid >= 0)):
        mesh = model.geom_dataid[geom]
        first, number = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        start, most = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        at = model.mesh_vert[first : first + number] @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        points.append((at - origin) @ back.T)
        faces.append(model.mesh_face[start : start + most] + count)
        count += number
    return np.concatenate(points), np.concatenate(faces)


def obj_text(points: Any, faces: Any) -> str:
    """Format a mesh as the text of an OBJ file."""
    vertices = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
    return "\n".join([*vertices, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces)]) + "\n"
