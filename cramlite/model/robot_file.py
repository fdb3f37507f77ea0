"""Files of arms and grippers (such as URDF), with additions from data sheets."""

from __future__ import annotations

from ..base.value import Value
from .geometry import Pose


class HandFile(Value):
    """File of a gripper, with statements of its data sheet that the file lacks.

    Args:
        path: of an MJCF or URDF file; empty if the hand is in the arm's own file.
        at: of the hand's root on the flange.
        pads: two names, of geoms or bodies, a finger each; empty looks for the faces that meet.
        tcp: site or body whose place is the pinch point; empty takes the middle between the pads.
        opening: smallest and largest distance between the pads that is used [m]; None for the whole stroke.
        force: lowest and highest grip force [N]; None for what the file's actuators exert.
        speed: lowest and highest speed of the pads towards each other [m/s]; None for 10 to 100 mm/s.
        torsion: torsional friction of the pads, as a lever [m]; None for what the file says of their contacts.
    """

    path: str = ""
    at: Pose = Pose()
    pads: tuple[str, str] | None = None
    tcp: str = ""
    opening: tuple[float, float] | None = None
    force: tuple[float, float] | None = None
    speed: tuple[float, float] | None = None
    torsion: float | None = None


class Stated(Value):
    """Data of an arm that its data sheet states and its file does not.

    Joint angles are zero where the file has its zero.

    Args:
        payload: of the arm, gripper included [kg]; 0 where nobody says it, which is refused.
        gripper: name of one that comes with cramlite, which is bolted to the flange; or one from a file.
        flange: site or body behind the last joint where tools are bolted on; empty looks for usual names.
        home: a parked joint position [rad]; empty takes the keyframe "home", else the middle of the ranges.
        speed: of joints whose file states none [rad/s]; the slowest joints of a UR10 have 2.1.
        torques: highest of each joint [Nm]; needed where the file states none, and then in place of its own.
        limits: (joint, lower, upper) of joints whose file states none [rad].
        sensor: where forces are measured, "flange" or a sensor's name; empty looks for a force sensor in the file.
        apart: pairs of links whose shapes overlap although the real ones never meet, beside those that the file excludes.
        packages: pairs of the name in ``package://`` of a URDF and its folder.
    """

    payload: float = 0.0
    gripper: str | HandFile = "robotiq_2f85"
    flange: str = ""
    home: tuple[float, ...] = ()
    speed: float = 2.0
    torques: tuple[float, ...] = ()
    limits: tuple[tuple[str, float, float], ...] = ()
    sensor: str = ""
    apart: tuple[tuple[str, str], ...] = ()
    packages: tuple[tuple[str, str], ...] = ()


class RobotFile(Value):
    """File of an arm, with what the scenario states about the arm.

    Args:
        path: of an MJCF or URDF file.
        stated: what a data sheet says and the file does not.
    """

    path: str
    stated: Stated = Stated()
