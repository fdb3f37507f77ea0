"""Hinged scene of ``adroit_door``: a door and its lever on their joints, and a hand of boxes and capsules with jointed fingers.

Recorded states are replayed in it, without dynamics, to compute how near the hand is to the lever and to the door. Lengths [m] and axes are
those of adroit_door.xml and adroit_model.xml of gymnasium-robotics (Apache-2.0); contacts are computed with such primitives there, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from cramlite.model import Floats, Pose

DOOR, PIVOT, LATCH = (0.29, 0.0, 0.0), (0.31, 0.0, 0.0), (-0.15, 0.0, -0.025)
"""Positions of the door in its door frame, of the hinge in the door, and of the lever's axis in the door [m]."""
GRASP = (0.007, -0.05, 0.07)
"""Observed point of the palm, in the palm's own frame [m]."""
FAR = 0.02
"""Largest distance of the hand from a thing that is computed [m]: several times the distance at which a touch ends."""
KNUCKLES = ((0.033, 0.0, 0.095), (0.011, 0.0, 0.099), (-0.011, 0.0, 0.095))
"""Positions of the knuckles of the first, the middle and the ring finger in the palm [m]."""
LITTLE = (-0.017, 0.0, 0.044)
"""Position of the little finger's knuckle in its metacarpal, and of this metacarpal in the palm [m]."""
_HINGED = """<body pos="{frame}"><body pos="{door}"><joint axis="0 0 1" pos="{pivot}"/>
<geom name="door" type="box" size="0.2 0.05 0.25"/><geom name="door_left" type="cylinder" size="0.05 0.25" pos="-0.2 0 0"/>
<geom name="door_right" type="cylinder" size="0.05 0.25" pos="0.2 0 0"/>
<body pos="{latch}"><joint axis="0 1 0"/><geom name="lever_axle" type="cylinder" size="0.05" fromto="0 -0.15 0 0 0.15 0"/>
<geom name="lever" type="capsule" size="0.02" fromto="0 -0.15 0 0.2 -0.15 0"/></body></body></body>"""
_FINGER = """<body pos="{at}"><joint axis="0 1 0"/><joint axis="1 0 0"/><geom class="hand" size="0.01" fromto="0 0 0 0 0 0.045"/>
<body pos="0 0 0.045"><joint axis="1 0 0"/><geom class="hand" size="0.008" fromto="0 0 0 0 0 0.025"/>
<body pos="0 0 0.025"><joint axis="1 0 0"/><geom class="hand" size="0.007" fromto="0 0 0 0 0 0.024"/></body></body></body>"""
_LITTLE = """<body pos="{at}"><joint axis="0.571 0 0.821"/><geom class="hand" type="box" size="0.0095 0.0111 0.025" pos="-0.0165 0 0.01"/>
{finger}</body>"""
_THUMB = """<body pos="0.034 -0.009 0.029" quat="0.924 0 0.3825 0"><joint axis="0 0 -1"/><joint axis="1 0 0"/>
<geom class="hand" size="0.013" fromto="0 0 0 0 0 0.038"/>
<body pos="0 0 0.038"><joint axis="1 0 0"/><joint axis="0 1 0"/><geom class="hand" size="0.011" fromto="0 0 0 0 0 0.032"/>
<body pos="0 0 0.032"><joint axis="0 1 0"/><geom class="hand" size="0.0092" fromto="0 0 0 0 0 0.026"/></body></body></body>"""
_SCENE = """<mujoco><compiler angle="radian" autolimits="false"/>
<default><geom mass="1" margin="{far}" contype="0" conaffinity="1"/>
<default class="hand"><geom type="capsule" contype="1" conaffinity="0"/></default></default><worldbody>{hinged}
<body mocap="true"><geom class="hand" type="box" size="0.032 0.0111 0.049" pos="0.011 0 0.038"/>
<geom class="hand" type="box" size="0.011 0.0111 0.025" pos="-0.032 0 0.014"/>{fingers}</body></worldbody></mujoco>"""


def distances(palm: Sequence[Pose], fingers: Floats, lever: Floats, hinge: Floats, frame: Floats) -> dict[str, Floats]:
    """Return the distance of the hand from "lever" and "door" in each recorded state, (N,) each [m]: below 0 where they overlap, and
    at most ``FAR``.

    Args:
        palm: poses of the palm's observed point, N.
        fingers: (N, 22) angles of the fingers' joints, from the first finger to the little one and the thumb, each from its base on [rad].
        lever, hinge: (N,) angles [rad].
        frame: position of the door's frame [m].
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(_text(frame))
    data = mujoco.MjData(model)
    thing = [model.geom(k).name.partition("_")[0] for k in range(model.ngeom)]
    found = {"lever": np.full(len(palm), FAR), "door": np.full(len(palm), FAR)}
    inside = Pose(tuple(np.negative(GRASP)))
    for k, angles in enumerate(np.column_stack([hinge, lever, fingers])):
        place = palm[k] * inside
        data.mocap_pos[0], data.mocap_quat[0], data.qpos[:] = place.position, place.quaternion, angles
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        for touch in data.contact:
            near = found[next(thing[g] for g in touch.geom if thing[g])]
            near[k] = min(near[k], touch.dist)
    return found


def _text(frame: Floats) -> str:
    """MJCF of the scene: the geoms of lever and door are named after them, those of the hand have no name."""
    straight = [_FINGER.format(at=_row(at)) for at in KNUCKLES]
    little = _LITTLE.format(at=_row(LITTLE), finger=_FINGER.format(at=_row(LITTLE)))
    hinged = _HINGED.format(frame=_row(frame), door=_row(DOOR), pivot=_row(PIVOT), latch=_row(LATCH))
    return _SCENE.format(far=FAR, hinged=hinged, fingers="".join([*straight, little, _THUMB]))


def _row(numbers: Iterable[float]) -> str:
    return " ".join(f"{n:.9g}" for n in numbers)
