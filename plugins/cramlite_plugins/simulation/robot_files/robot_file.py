"""A robot from the MJCF or URDF of its arm, with one of our grippers on its flange."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from msgspec import field
from msgspec.structs import replace

from cramlite.model import Gripper, Pose, Robot, Value
from cramlite.plugin import UserError, nearest

from ...robots import franka_hand, robotiq_2f85
from ..scenes.source import read_source
from .chain import Chain, find_chain
from .dh_table import Table, reach_of, table_of
from .model_text import posed, write_model

GRIPPERS: Mapping[str, tuple[Gripper, Callable[[str], tuple[str, str]]]] = {
    "franka_hand": (franka_hand.FRANKA_HAND, franka_hand.gripper_mjcf),
    "robotiq_2f85": (robotiq_2f85.GRIPPER, robotiq_2f85.gripper_mjcf),
}
ACCELERATION = 5.0  # no file states it: as for the UR5e [rad/s2]
UPRIGHT = 1e-6  # how far the first axis may lean


class Stated(Value):
    """What a data sheet says of an arm, and its file does not; angles count as the file counts.

    Args:
        payload: of the arm, gripper included [kg].
        gripper: one of ``GRIPPERS``; a hand in the file is left out.
        flange: site or body behind the last joint where tools are bolted on; empty looks for usual names.
        home: a parked joint position [rad]; empty takes the keyframe "home", else the middle of the ranges.
        speed: of joints whose file states none [rad/s]; the slowest joints of a UR10 have 2.1.
        torques: highest of each joint [Nm]; needed where the file states none, and then in place of its own.
        sensor: where forces are measured, "flange" or a sensor's name; empty looks for a force sensor in the file.
        apart: pairs of links whose shapes overlap although the real ones never meet, beside those that the file excludes.
        packages: name in ``package://`` of a URDF -> its folder.
    """

    payload: float
    gripper: str = "robotiq_2f85"
    flange: str = ""
    home: tuple[float, ...] = ()
    speed: float = 2.0
    torques: tuple[float, ...] = ()
    sensor: str = ""
    apart: tuple[tuple[str, str], ...] = ()
    packages: Mapping[str, Path] = field(default_factory=dict)


class RobotFile(Value):
    """A robot that was read from a file, and what was found there.

    Args:
        robot: joints count as its Denavit-Hartenberg table does; ``axis_zeros`` is where the file counts zero.
        notes: what was found, what is missing and taken from elsewhere, and what says another; one sentence each.
    """

    robot: Robot
    notes: tuple[str, ...]


def read_robot(path: Path | str, name: str, stated: Stated) -> RobotFile:
    """Read an arm, and bolt one of our grippers to its flange.

    Args:
        path: of an MJCF or URDF file.
        name: that scenarios use for the robot.
        stated: what the file does not say.

    Raises:
        UserError: the file is no arm, or cannot be used, or what is stated does not fit it; says what would be right.
    """
    path = Path(path)
    if not path.is_file():
        raise UserError(f"There is no robot file '{path}'.")
    hand, hand_mjcf = _gripper(path, stated)
    source = read_source(path, stated.packages)
    found = find_chain(source, stated.flange)
    chain = replace(found, torques=_torques(path, found, stated.torques))
    table = table_of(chain.axes, chain.flange)
    _check_upright(path, chain.joints[0], table.base)
    at_zero = posed(source, chain)
    tip = at_zero.body(chain.bodies[-1])
    flange = tip.inverse() * at_zero.body(chain.base) * chain.flange
    tool = _bolted(hand_mjcf(chain.links[-1]), flange, table.tool)
    text, overlaps = write_model(name, at_zero, chain, table, tool, _known(path, chain, stated.apart))
    own, where = _home(path, source.model, chain, stated.home)
    parked = tuple(v + z for v, z in zip(own, table.zeros, strict=True))
    _check_free(path, text, parked, where)
    sensor = stated.sensor or ("flange" if _has_force_sensor(source.model) else None)
    reach = round(reach_of(table, chain.limits), 3)
    robot = _robot(name, chain, table, replace(hand, tcp=table.tool * hand.tcp), stated, parked, reach, sensor, text)
    return RobotFile(robot, (*_found(path, chain, robot, stated, where), *overlaps))


def _robot(
    name: str, chain: Chain, table: Table, hand: Gripper, stated: Stated, home: tuple[float, ...], reach: float,
    sensor: str | None, text: str,
) -> Robot:  # fmt: skip
    return Robot(
        type=name,
        joints=chain.joints,
        dh=table.rows,
        limits=tuple((lo + z, hi + z) for (lo, hi), z in zip(chain.limits, table.zeros, strict=True)),
        velocity=tuple(v or stated.speed for v in chain.speeds),
        acceleration=(ACCELERATION,) * len(chain.joints),
        home=home,
        reach=reach,
        payload=stated.payload,
        gripper=hand,
        sensor=sensor,
        backend="typed_json",
        mjcf=lambda: text,
        axis_zeros=table.zeros,
    )


def _gripper(path: Path, stated: Stated) -> tuple[Gripper, Callable[[str], tuple[str, str]]]:
    if stated.gripper not in GRIPPERS:
        raise UserError(f"{path}: there is no gripper '{stated.gripper}' for arms from files; {nearest(stated.gripper, list(GRIPPERS))}.")
    hand = GRIPPERS[stated.gripper][0]
    if not hand.mass < stated.payload < 1000.0:
        raise UserError(
            f"{path}: a payload of {stated.payload:g} kg does not carry the gripper '{stated.gripper}' of {hand.mass:g} kg; "
            "'payload' is the data sheet's, gripper included."
        )
    if not stated.speed > 0.0:
        raise UserError(f"{path}: 'speed' is {stated.speed:g} rad/s; it is larger than 0.")
    return GRIPPERS[stated.gripper]


def _torques(path: Path, chain: Chain, stated: tuple[float, ...]) -> tuple[float, ...]:
    """The joints' torques, as stated or as in the file."""
    if stated and (len(stated) != len(chain.joints) or not all(0 < t < 1e5 for t in stated)):
        raise UserError(f"{path}: 'torques' is a number above 0 for each of {len(chain.joints)} joints [Nm], not {stated}.")
    weak = [n for n, t in zip(chain.joints, chain.torques, strict=True) if not t]
    if weak and not stated:
        raise UserError(
            f"{path}: no torque is stated for {', '.join(weak)}; 'torques' says them, a number for each of {len(chain.joints)} joints "
            "[Nm], as the arm's data sheet does: a proof needs to know when the arm would stop."
        )
    return stated or chain.torques


def _known(path: Path, chain: Chain, apart: tuple[tuple[str, str], ...]) -> tuple[tuple[str, str], ...]:
    links = ["base_link", *chain.links]
    for name in (n for pair in apart for n in pair):
        if name not in links:
            raise UserError(f"{path}: 'apart' names '{name}', and the arm's links are {', '.join(links)}.")
    return apart


def _check_upright(path: Path, joint: str, base: Pose) -> None:
    x, y, z = base.rotate((0.0, 0.0, 1.0))
    if z < 1.0 - UPRIGHT:
        raise UserError(
            f"{path}: joint '{joint}' turns about ({x:.3g}, {y:.3g}, {z:.3g}) of its base; the first axis must be the base's z, "
            "upwards. Turn the base in the file; if the axis only points down, negate it, and swap and negate the joint's range."
        )


def _bolted(tool: tuple[str, str], place: Pose, on_flange: Pose) -> tuple[str, str]:
    """The gripper where the file's flange is on the last body; its sensor reads in frame n of the table."""
    body = ElementTree.fromstring(tool[0])
    x, y, z = map(float, body.get("pos", "0 0 0").split())
    w, i, j, k = map(float, body.get("quat", "1 0 0 0").split())
    own = Pose((x, y, z), (w, i, j, k))
    (site,) = [s for s in body.iter("site") if s.get("name") == "ft"]
    for element, pose in ((body, place * own), (site, (on_flange * own).inverse())):
        element.set("pos", _line(pose.position))
        element.set("quat", _line(pose.quaternion))
    return ElementTree.tostring(body, encoding="unicode"), tool[1]


def _home(path: Path, model: Any, chain: Chain, said: tuple[float, ...]) -> tuple[tuple[float, ...], str]:
    """A parked position as the file counts, and where it is from."""
    keys = [k for k in range(model.nkey) if model.key(k).name == "home"]
    if said:
        own, where = said, "as said"
    elif keys:
        addresses = [int(model.jnt_qposadr[model.body_jntadr[b]]) for b in chain.bodies]
        own, where = tuple(float(v) for v in model.key_qpos[keys[0]][addresses]), "the file's keyframe 'home'"
    else:
        own, where = tuple((lo + hi) / 2 for lo, hi in chain.limits), "the middle of the ranges, as the file has no keyframe 'home'"
    if len(own) != len(chain.joints) or not all(lo <= v <= hi for v, (lo, hi) in zip(own, chain.limits, strict=True)):
        raise UserError(f"{path}: home {own} is not a position of {len(chain.joints)} joints within their limits; 'home' says another.")
    return own, where


def _check_free(path: Path, text: str, q: Sequence[float], where: str) -> None:
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[: len(q)] = np.array(q)
    mujoco.mj_forward(model, data)
    if data.ncon:
        a, b = (model.body(model.geom_bodyid[g]).name for g in data.contact[0].geom)
        raise UserError(
            f"{path}: at home, {where}, '{a}' meets '{b}'; 'home' says a position that is free, or 'apart' that these two never meet."
        )


def _has_force_sensor(model: Any) -> bool:
    return bool((model.sensor_type == int(mujoco.mjtSensor.mjSENS_FORCE)).any())


def _found(path: Path, chain: Chain, robot: Robot, stated: Stated, home: str) -> tuple[str, ...]:
    """What was found and what is missing."""
    slow = [n for n, v in zip(chain.joints, chain.speeds, strict=True) if not v]
    notes = [
        f"{path}: {len(chain.joints)} joints: {', '.join(chain.joints)}; the flange reaches {robot.reach:g} m from the first axis",
        f"tools are bolted to {chain.said}",
        f"home is {home}",
        f"the gripper is '{robot.gripper.type}'; a hand in the file is left out",
    ]
    notes += [f"no speed is stated for {', '.join(slow)}: {stated.speed:g} rad/s; 'speed' says another"] if slow else []
    notes += [] if robot.sensor else ["no force sensor is in the file: motions that feel are refused; 'sensor' says where one is"]
    return (*notes, f"no file states accelerations: {ACCELERATION:g} rad/s2 for each joint")


def _line(values: Sequence[float]) -> str:
    return " ".join(f"{v:.12g}" for v in values)
