"""Robot from the MJCF or URDF of an arm, with a gripper on its flange: one that comes with cramlite, or one
from a file."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite.model import Gripper, ImportedRobot, Pose, Robot, Stated
from cramlite.plugin import UserError, nearest

from ...robots import franka_hand, robotiq_2f85
from ..scenes.source import Source, read_source
from .chain import Chain, find_chain
from .dh_table import Table, reach_of, table_of
from .hand_file import Hand, Mjcf, read_hand
from .model_text import is_drawn, numbers, posed, write_looks, write_model

GRIPPERS: Mapping[str, tuple[Gripper, Mjcf]] = {
    "franka_hand": (franka_hand.FRANKA_HAND, franka_hand.gripper_mjcf),
    "robotiq_2f85": (robotiq_2f85.GRIPPER, robotiq_2f85.gripper_mjcf),
}
ACCELERATION = 5.0  # no file states it: as for the UR5e [rad/s2]
JOINT = int(mujoco.mjtTrn.mjTRN_JOINT)
UPRIGHT = 1e-6  # how far the first axis may lean before that is said


def read_robot(path: Path | str, name: str, stated: Stated) -> ImportedRobot:
    """Read an arm, and bolt a gripper to its flange.

    Args:
        path: of an MJCF or URDF file.
        name: of the robot's type.
        stated: what the file does not say.

    Raises:
        UserError: the file is no arm, or cannot be used, or what is stated does not fit it; says what would be right.
    """
    path = Path(path)
    if not path.is_file():
        raise UserError(f"There is no robot file '{path}'.")
    packages = {name: Path(folder) for name, folder in stated.packages}
    source = read_source(path, packages)
    own = find_chain(source, stated.flange, stated.limits)
    chain = replace(own, torques=_torques(path, own, stated.torques))
    table = table_of(chain.axes, chain.flange)
    at_zero = posed(source, chain)
    tip = at_zero.body(chain.bodies[-1])
    flange = tip.inverse() * at_zero.body(chain.base) * chain.flange
    hand = _hand(path, source, stated, chain, flange)
    _check_stated(path, stated, hand.gripper)
    tool = _bolted(hand.mjcf(chain.links[-1]), flange, table.tool)
    text, overlaps = write_model(name, at_zero, chain, table, tool, _known(path, chain, stated.apart))
    home, where = _home(path, source.model, chain, stated.home)
    parked = tuple(v + z for v, z in zip(home, table.zeros, strict=True))
    _check_free(path, text, parked, where)
    sensor = stated.sensor or ("flange" if _has_force_sensor(source.model) else None)
    reach = round(reach_of(table, chain.limits), 3)
    gripper = replace(hand.gripper, tcp=table.tool * hand.gripper.tcp)
    looks = cache(partial(write_looks, name, at_zero, chain, table, tool)) if is_drawn(at_zero, chain) else None
    robot = replace(_robot(name, chain, table, gripper, stated, parked, reach, sensor, text), looks=looks)
    found = (*_found(path, chain, robot, where), *hand.found)
    servos = _servos(source.model, chain, text, bool(stated.torques))
    notes = (*_leaning(chain, table.base), *servos, *_missing(chain, robot, stated, where), *hand.notes, *overlaps)
    root = source.model.body(chain.base).name or "world"
    return ImportedRobot(robot, found, notes, table.tool, chain.place, root)


def _hand(path: Path, source: Source, stated: Stated, chain: Chain, flange: Pose) -> Hand:
    """Return the gripper for an arm: one that comes with cramlite, one from its own file, or the hand in the
    arm's file."""
    if isinstance(stated.gripper, str):
        if stated.gripper not in GRIPPERS:
            raise UserError(
                f"{path}: there is no gripper '{stated.gripper}' for arms from files; {nearest(stated.gripper, list(GRIPPERS))}, or "
                "{file: ...} for that of a file."
            )
        gripper, mjcf = GRIPPERS[stated.gripper]
        left = ("the hand in the file is left out; 'gripper: {}' takes it",) if chain.hand else ()
        return Hand(gripper, mjcf, (f"the gripper is '{gripper.type}'",), left)
    if not stated.gripper.path:
        return read_hand(source, stated.gripper, chain.bodies[-1], flange.inverse())
    own = Path(stated.gripper.path)
    if not own.is_file():
        raise UserError(f"{path}: there is no gripper file '{own}'.")
    return read_hand(read_source(own, {name: Path(folder) for name, folder in stated.packages}), stated.gripper)


def _check_stated(path: Path, stated: Stated, gripper: Gripper) -> None:
    if not stated.payload:
        raise UserError(
            f"{path}: no payload is stated, and no file states one; state 'payload' as the data sheet does, gripper included, such as 5 kg."
        )
    if not gripper.mass < stated.payload < 1000.0:
        raise UserError(
            f"{path}: a payload of {stated.payload:g} kg does not carry the gripper '{gripper.type}' of {gripper.mass:.3g} kg; "
            "'payload' is the data sheet's, gripper included."
        )
    if not stated.speed > 0.0:
        raise UserError(f"{path}: 'speed' is {stated.speed:g} rad/s; it must be larger than 0.")


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
        root=table.base,
    )


def _torques(path: Path, chain: Chain, stated: tuple[float, ...]) -> tuple[float, ...]:
    """Torque limits of the joints [Nm]: as the scenario states them, else as in the robot file."""
    if stated and (len(stated) != len(chain.joints) or not all(0 < t < 1e5 for t in stated)):
        raise UserError(f"{path}: 'torques' must be a number above 0 for each of {len(chain.joints)} joints [Nm]; it is {stated}.")
    weak = [n for n, t in zip(chain.joints, chain.torques, strict=True) if not t]
    if weak and not stated:
        raise UserError(
            f"{path}: no torque is stated for {', '.join(weak)}; state 'torques', a number for each of {len(chain.joints)} joints "
            "[Nm], as the arm's data sheet does: a proof needs to know when the arm would stop."
        )
    return stated or chain.torques


def _known(path: Path, chain: Chain, apart: tuple[tuple[str, str], ...]) -> tuple[tuple[str, str], ...]:
    links = ["base_link", *chain.links]
    for name in (n for pair in apart for n in pair):
        if name not in links:
            raise UserError(f"{path}: 'apart' names '{name}', which is no link of the arm; its links are {', '.join(links)}.")
    return apart


def _leaning(chain: Chain, root: Pose) -> tuple[str, ...]:
    """Return the remark that the arm's first axis is not along the base's z axis, which is assumed to point up; () if it is."""
    x, y, z = root.rotate((0.0, 0.0, 1.0))
    if z > 1.0 - UPRIGHT:
        return ()
    about = f"({x:.3g}, {y:.3g}, {z:.3g})"
    return (f"joint '{chain.joints[0]}' turns about {about} of its base, whose z is assumed to point up; 'at' can turn the base",)


def _servos(model: Any, chain: Chain, text: str, stated: bool) -> tuple[str, ...]:
    """Return the message that cramlite's position servos replace the actuators of the arm's file; none if the file has none."""
    driven = [a for a in range(model.nu) if int(model.actuator_trntype[a]) == JOINT]
    own = [a for a in driven if model.joint(model.actuator_trnid[a][0]).name in chain.joints]
    if not own:
        return ()
    servos = sum(int(model.actuator_biastype[a]) != 0 for a in own)
    kind = "position or velocity servos" if servos == len(own) else "motors" if not servos else "servos and motors"
    gains = [float(v) for v in re.findall(r'<position [^>]*kp="([^"]+)"', text)[: len(chain.joints)]]
    kept = "nothing of them is kept, as 'torques' states the highest torques" if stated else "of them only the highest torques are kept"
    ours = f"{min(gains):.0f} to {max(gains):.0f} Nm/rad"
    return (f"the file's {len(own)} actuators of the arm ({kind}) are replaced by cramlite's position servos of {ours}; {kept}",)


def _bolted(tool: tuple[str, str], place: Pose, on_flange: Pose) -> tuple[str, str]:
    """MJCF of the gripper at the file's flange, on the arm's last body; its force sensor reads in frame n
    of the Denavit-Hartenberg table."""
    body = ElementTree.fromstring(tool[0])
    x, y, z = map(float, body.get("pos", "0 0 0").split())
    w, i, j, k = map(float, body.get("quat", "1 0 0 0").split())
    own = Pose((x, y, z), (w, i, j, k))
    (site,) = [s for s in body.iter("site") if s.get("name") == "ft"]
    for element, pose in ((body, place * own), (site, (on_flange * own).inverse())):
        element.set("pos", numbers(pose.position))
        element.set("quat", numbers(pose.quaternion))
    return ElementTree.tostring(body, encoding="unicode"), tool[1]


def _home(path: Path, model: Any, chain: Chain, said: tuple[float, ...]) -> tuple[tuple[float, ...], str]:
    """Home joint position of an arm, counted from the joint zeros of its file, and where it was taken from, in
    words."""
    keys = [k for k in range(model.nkey) if model.key(k).name == "home"]
    if said:
        own, where = said, "as said"
    elif keys:
        addresses = [int(model.jnt_qposadr[model.body_jntadr[b]]) for b in chain.bodies]
        own, where = tuple(float(v) for v in model.key_qpos[keys[0]][addresses]), "the file's keyframe 'home'"
    else:
        own, where = tuple((lo + hi) / 2 for lo, hi in chain.limits), "the middle of the ranges, as the file has no keyframe 'home'"
    if len(own) != len(chain.joints) or not all(lo <= v <= hi for v, (lo, hi) in zip(own, chain.limits, strict=True)):
        raise UserError(f"{path}: home {own} is not a position of {len(chain.joints)} joints within their limits; state another by 'home'.")
    return own, where


def _check_free(path: Path, text: str, q: Sequence[float], where: str) -> None:
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[: len(q)] = np.array(q)
    mujoco.mj_forward(model, data)
    if data.ncon:
        a, b = (model.body(model.geom_bodyid[g]).name for g in data.contact[0].geom)
        raise UserError(
            f"{path}: at home, {where}, '{a}' and '{b}' collide; state another position by 'home', or by 'apart' that these two never meet."
        )


def _has_force_sensor(model: Any) -> bool:
    return bool((model.sensor_type == int(mujoco.mjtSensor.mjSENS_FORCE)).any())


def _found(path: Path, chain: Chain, robot: Robot, home: str) -> tuple[str, ...]:
    return (
        f"{path.name}: {len(chain.joints)} joints: {', '.join(chain.joints)}; the flange reaches {robot.reach:g} m from the base's axis",
        f"tools are bolted to {chain.said.split(':')[0]}; home is {home}",
    )


def _missing(chain: Chain, robot: Robot, stated: Stated, home: str) -> tuple[str, ...]:
    """Notes on values that the file does not state, with the values used instead and the keys of the
    scenario that state others."""
    slow = [n for n, v in zip(chain.joints, chain.speeds, strict=True) if not v]
    notes = [f"tools are bolted to {chain.said}"] if ":" in chain.said else []
    notes += [f"home is {home}; 'home' can state another"] if home.startswith("the middle") else []
    notes += [f"no speed is stated for {', '.join(slow)}: {stated.speed:g} rad/s; 'speed' can state another"] if slow else []
    notes += [] if robot.sensor else ["no force sensor is in the file: motions that feel are refused; 'sensor' can state where one is"]
    return (*notes, f"no file states accelerations: {ACCELERATION:g} rad/s2 for each joint")
