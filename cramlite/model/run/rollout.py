"""Rollouts: the recorded run of a program or demonstration, its shapes for drawing, and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import field, to_builtins
from msgspec.structs import replace

from ...base.errors import UserError
from ...base.guarded_files import read_arrays
from ...base.value import Value
from ..entity_name import EntityName
from ..geometry import Floats, Pose, Vector3
from ..world.world import World

MOST_BYTES = 2**32
"""Largest size of a recorded run after unpacking [bytes]. An hour of fifty bodies at 500 Hz takes 5 GB, and runs last minutes."""


class Solid(Value):
    """Triangle mesh of a rigid piece of a body.

    Args:
        body: whose frame it is given in.
        vertices: (V, 3) [m].
        faces: (F, 3) indices, counter-clockwise seen from outside.
        colour: red, green, blue and opacity, 0 to 1.
    """

    body: str
    vertices: Floats
    faces: Any
    colour: tuple[float, float, float, float]


class Scene(Value):
    """Moving solids for drawing: triangle meshes with the poses of their bodies over time.

    Args:
        times: (N,) [s].
        solids: what is seen.
        poses: body -> (N, 7), position [m] and quaternion (w, x, y, z) in the world; (1, 7) for what never moves.
        owners: body -> the thing or robot that it belongs to.
    """

    times: Floats
    solids: tuple[Solid, ...]
    poses: Mapping[str, Floats]
    owners: Mapping[str, str]


class Touch(Value):
    """Contact between two bodies at one sample of a recorded run.

    Args:
        a, b: "thing" or "thing/part" for things; "effector/left" and "effector/right" for the two
            finger pads (thumb and index of a hand); "effector/body" for the rest of it.
        force: normal force, summed over the contact points [N].
        lift: vertical component of the whole force that ``a`` exerts on ``b`` [N], up positive.
        press: magnitude of the vector sum of the normal forces [N]: less than ``force`` where the points face apart, as those of a
            wedge do; None where it was not measured.
    """

    a: str
    b: str
    force: float
    lift: float
    press: float | None = None

    @property
    def pressed(self) -> float:
        """Force with which two bodies press on each other [N].

        Where it was not measured (``press`` is None), it is ``force``, which is at least as large.
        """
        return self.force if self.press is None else self.press


class Message(Value):
    """Message that a program wrote to its log while it ran.

    Args:
        time: since the start [s].
        text: what the program wrote.
        line: of the program, 0 for none.
    """

    time: float
    text: str
    line: int = 0


class Rollout(Value, dict=True):
    """Recorded run of a program or demonstration, sampled at a constant rate.

    Args:
        world: the world at the start.
        effector: name of the hand or robot.
        times: (N,) [s].
        poses: thing name -> (N, 7), position and quaternion (w, x, y, z), world frame; further
            frames "effector", "effector/left", "effector/right" (finger tips).
        touches: N tuples.
        joints: (N, J) arm joints [rad]; J = 0 for a hand.
        wrench: (N, 6) what the effector applies to its environment, at the sensor, world axes [N, Nm].
        opening: (N,) distance between the finger pads [m].
        lines: (N,) program line under execution, 0 for none.
        messages: the program's log.
        outcome: "finished", or why it ended: "halted", "protective stop", "timeout", "error".
        reason: one clause with numbers when the outcome is not "finished".
        extra: further numbers that a simulator measured, by name.
        values: thing name -> (N,) value of the joint that it moves on [m, rad].
        grains: thing name -> (N, count, 3) centres of the balls that it was filled with, world frame [m].
        sizes: of what is in ``poses`` and no thing: "mount/base" is a robot's platform, length, width and height over its
            frame; "effector/left" a pad, along its frame [m].
        seen: thing name -> when a camera first saw it [s], infinite for never; of what nobody knew at the start where it
            is (``World.poses``), so it is empty where everything is known.
        work: thing or robot that moves -> contact points that were computed for it, on the mean of all samples: half of those between
            two of them, none of what slept.
        force: (N,) what the program feels, URScript's ``force()``: at the TCP, without the weight of what the program says
            that it carries, since the last tare; before the first one as ``wrench`` [N]; None where no controller ran.
        commanded: (N,) the largest force that the program told the arm to apply in force mode since the sample before [N], 0
            where it controls position; None where no controller ran.
        payload: (N,) the mass on the flange, gripper included, that the program told the arm [kg]; None where no controller ran.
        grip: (N,) the force that each pad was ordered to press with [N], 0 where the fingers were to open or to stay; None where no
            controller ran.
        faults: that happened while it ran, as clauses.
        asleep: N tuples, those of ``touches`` in which only things take part that the simulation lets sleep: the same tuple for as long as
            the same things sleep; empty where nobody knows. It is not kept in files.
    """

    world: World
    effector: str
    times: Floats
    poses: dict[str, Floats]
    touches: tuple[tuple[Touch, ...], ...]
    joints: Floats
    wrench: Floats
    opening: Floats
    lines: Floats
    messages: tuple[Message, ...] = ()
    outcome: str = "finished"
    reason: str = ""
    extra: dict[str, float] = field(default_factory=dict)
    values: dict[str, Floats] = field(default_factory=dict)
    grains: dict[str, Floats] = field(default_factory=dict)
    sizes: dict[str, Vector3] = field(default_factory=dict)
    seen: dict[str, float] = field(default_factory=dict)
    work: dict[str, float] = field(default_factory=dict)
    force: Floats | None = None
    commanded: Floats | None = None
    payload: Floats | None = None
    grip: Floats | None = None
    faults: tuple[Message, ...] = ()
    asleep: tuple[tuple[Touch, ...], ...] = ()

    @cached_property
    def awake_touches(self) -> tuple[tuple[Touch, ...], ...]:
        """Contacts at each sample, without those between things that the simulation lets sleep while they
        rest (``asleep``)."""
        idle = {id(t) for still in {id(s): s for s in self.asleep}.values() for t in still}
        return tuple(tuple(t for t in touches if id(t) not in idle) for touches in self.touches) if idle else self.touches

    def contact_force(self) -> Floats:
        """Return the magnitude of the contact force (N,) [N]: ``force``, or that of ``wrench`` in runs
        without a tared sensor."""
        norm: Floats = (self.wrench[:, :3] ** 2).sum(axis=1) ** 0.5
        return norm if self.force is None else self.force


def world_after_run(rollout: Rollout, world: World) -> World:
    """Return a world as it is at the end of a run: its things and robot at their last poses.

    Loose fillings are as at the start.
    """
    return world_in_run(rollout, world, -1)


def world_in_run(rollout: Rollout, world: World, sample: int) -> World:
    """Return a world as it is at one sample of a run: its things and robot at their poses then; -1 for the end."""
    mount = world.robots[0]
    joints, opening = tuple(map(float, rollout.joints[sample])), float(rollout.opening[sample])
    base = _pose(rollout, str(EntityName(mount.name, "base")), mount.base, sample)
    mount = replace(mount, base=base, joints=joints, opening=opening)
    poses = {t.name: _pose(rollout, t.name, t.pose, sample) for t in world.things if t.movable}
    return replace(world.put(poses), robots=(mount, *world.robots[1:]))


def _pose(rollout: Rollout, name: str, before: Pose, sample: int) -> Pose:
    if name not in rollout.poses:
        return before
    return Pose.from_row(rollout.poses[name][sample])


_ARRAYS = ("times", "joints", "wrench", "opening", "lines")
_CONTROLLED = ("force", "commanded", "payload", "grip")  # None where no controller ran


def save_rollout(rollout: Rollout, path: Path) -> None:
    """Write a rollout to a file, without its world, which has a file of its own."""
    pairs = sorted({(t.a, t.b) for touches in rollout.touches for t in touches})
    number = {pair: k for k, pair in enumerate(pairs)}
    rows = [
        (k, number[t.a, t.b], t.force, t.lift, t.pressed) for k, touches in enumerate(rollout.touches) for t in touches
    ]  # fmt: skip
    header = {
        "effector": rollout.effector, "outcome": rollout.outcome, "reason": rollout.reason, "extra": rollout.extra,
        "messages": [to_builtins(m) for m in rollout.messages], "faults": [to_builtins(m) for m in rollout.faults],
        "pairs": pairs, "poses": list(rollout.poses),
        "values": {name: values.tolist() for name, values in rollout.values.items()},
        "grains": list(rollout.grains), "sizes": rollout.sizes, "seen": rollout.seen, "work": rollout.work,
    }  # fmt: skip
    arrays: dict[str, Any] = {name: getattr(rollout, name) for name in _ARRAYS}
    arrays |= {name: a for name in _CONTROLLED if (a := getattr(rollout, name)) is not None}
    poses = {f"pose{k}": rows for k, rows in enumerate(rollout.poses.values())}
    poses |= {f"grains{k}": rows for k, rows in enumerate(rollout.grains.values())}
    with path.open("wb") as file:
        np.savez(file, header=json.dumps(header), touches=np.array(rows).reshape(-1, 5), **arrays | poses)


def load_rollout(path: Path, world: World) -> Rollout:
    """Read the file that ``save_rollout`` wrote.

    Args:
        world: at the start.

    Raises:
        UserError: the file is missing or damaged.
    """
    try:
        data: dict[str, Any] = read_arrays(path, MOST_BYTES)
        header = json.loads(str(data["header"]))
        return _rollout(header, data, world)
    except (UserError, ValueError, KeyError, IndexError, TypeError) as error:
        raise UserError(f"'{path}' holds no recorded run ({error}); run 'cramlite execute --out' again.") from error


def _rollout(header: dict[str, Any], data: dict[str, Any], world: World) -> Rollout:
    touches: list[list[Touch]] = [[] for _ in data["times"]]
    controlled: dict[str, Any] = {name: data.get(name) for name in _CONTROLLED}
    for sample, pair, *forces in data["touches"].tolist():
        a, b = header["pairs"][int(pair)]
        touches[int(sample)].append(Touch(a, b, *forces))
    return Rollout(
        world=world,
        effector=header["effector"],
        poses={name: data[f"pose{k}"] for k, name in enumerate(header["poses"])},
        touches=tuple(map(tuple, touches)),
        messages=tuple(Message(**m) for m in header["messages"]),
        outcome=header["outcome"],
        reason=header["reason"],
        extra=header["extra"],
        values={name: np.array(values) for name, values in header.get("values", {}).items()},
        grains={name: data[f"grains{k}"] for k, name in enumerate(header.get("grains", ()))},
        sizes={name: tuple(size) for name, size in header.get("sizes", {}).items()},
        faults=tuple(Message(**m) for m in header.get("faults", ())),
        seen=header.get("seen", {}),
        work=header.get("work", {}),
        **controlled,
        **{name: data[name] for name in _ARRAYS},
    )
