"""A candidate whose run is written by hand: a block is taken from the floor, carried, and put onto a shelf beside a cup.

No physics runs: each validator reads what a run could have been, in milliseconds. 100 samples, one each ``STEP``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import (
    Action,
    Belief,
    Code,
    Estimate,
    Finding,
    Floats,
    Handover,
    Object,
    Plan,
    Pose,
    Program,
    RobotMount,
    Rollout,
    Thing,
    Touch,
    World,
)
from cramlite.plugin import HAND, HELD, Allowance, Candidate, Validator
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E

STEP, COUNT = 0.05, 100
TAKEN, LIFTED, LANDED, OPENED = 10, 25, 65, 70  # samples: pads close, the floor is left, the shelf is reached, pads open
WEIGHT = 9.81 * 0.2
LEFT, RIGHT = "effector/left", "effector/right"
FLOOR, SHELF = table("floor", Pose((0.4, 0, 0)), size=(1.6, 1.6, 0.02)), table("shelf", Pose((0.45, -0.35, 0.15)), size=(0.3, 0.3, 0.02))
TASKS = {"1.Grasping": "soma:Grasping", "2.PickingUp": "soma:PickingUp", "3.Placing": "soma:Placing", "4.ParkingArms": "soma:ParkingArms"}
ORIGINS = {
    1: "1.Grasping/close", 3: "2.PickingUp/lift", 5: "3.Placing/PuttingDown/lower", 7: "3.Placing/Releasing/open", 9: "4.ParkingArms/move",
}  # fmt: skip
HANDOVERS = (
    Handover("block", "1.Grasping/close", taken=True),
    Handover("block", "3.Placing/Releasing/open", taken=False, rest=Estimate(Pose((0.5, -0.35, 0.20)), 0.005, "predicted")),
)
LINES = np.repeat([0, 1, 3, 5, 7, 9, 0], [2, 23, 25, 20, 10, 10, 10])


def lying(name: str, at: tuple[float, float, float], mass: float = 0.2) -> Thing:
    return block(name, Pose(at), size=(0.06, 0.06, 0.06), mass=mass)


@cache
def taxonomy() -> Any:
    return Engine().knowledge.taxonomy


def track(*knots: tuple[int, tuple[float, float, float]]) -> Floats:
    """Return upright poses (COUNT, 7) on straight lines between positions at given samples."""
    samples, places = [k for k, _ in knots], np.array([p for _, p in knots])
    ways = [np.interp(range(COUNT), samples, places[:, axis]) for axis in range(3)]
    return np.column_stack([*ways, np.ones(COUNT), np.zeros((COUNT, 3))])


def good(**changes: Any) -> Candidate:
    """Return the hand-written candidate, with changed fields of its rollout."""
    things = (FLOOR, SHELF, lying("block", (0.5, 0.2, 0.03)), lying("cup", (0.4, -0.35, 0.20)))
    world = World(things, (RobotMount("arm", "ur5e"),))
    carried = track((LIFTED, (0.5, 0.2, 0.03)), (LANDED, (0.5, -0.35, 0.20)))
    hand = track((0, (0.5, 0.2, 0.33)), (TAKEN - 2, (0.5, 0.2, 0.03)), (LIFTED, (0.5, 0.2, 0.03)), (LANDED, (0.5, -0.35, 0.20)),
                 (OPENED + 4, (0.5, -0.35, 0.20)), (OPENED + 14, (0.5, -0.35, 0.40)))  # fmt: skip
    still = {t.name: track((0, t.pose.position)) for t in things if t.name != "block"}
    pads = {side: hand + np.array([x, 0, 0, 0, 0, 0, 0]) for side, x in ((LEFT, 0.03), (RIGHT, -0.03))}
    rollout = Rollout(
        world, "effector", np.arange(COUNT) * STEP, {**still, "block": carried, "effector": hand, **pads},
        tuple(touches(k) for k in range(COUNT)),
        np.tile(UR5E.home, (COUNT, 1)), np.zeros((COUNT, 6)), np.where([TAKEN <= k < OPENED for k in range(COUNT)], 0.06, 0.085),
        LINES.astype(float), force=np.zeros(COUNT), commanded=np.zeros(COUNT),
    )  # fmt: skip
    return candidate(replace(rollout, **changes))


def candidate(rollout: Rollout) -> Candidate:
    """Return the hand-written candidate with another rollout of its program."""
    it = Object("it", entity="block")
    roles = {"Locatum": it, "Relatum": Object("place", entity="shelf")}
    own = {"1.Grasping": {"Patient": it}, "2.PickingUp": {"Locatum": it, "Relatum": Object("from", entity="floor")}, "3.Placing": roles}
    actions = tuple(Action(name, task, own.get(name, {})) for name, task in TASKS.items())
    parts = (Action("3.Placing/PuttingDown", "soma:PuttingDown", roles), Action("3.Placing/Releasing", "soma:Releasing", roles))
    down = Allowance(frozenset({frozenset({HELD, "shelf"}), frozenset({"block", "shelf"})}), force=25.0)
    allowed = {"1.Grasping": Allowance(frozenset({frozenset({HAND, "block"})})), "2.PickingUp": Allowance(),
               "3.Placing/PuttingDown": down, "3.Placing/Releasing": replace(down, force=None), "4.ParkingArms": Allowance()}  # fmt: skip
    text = "\n".join(f"step {k}" for k in range(1, 11))
    belief = Belief(rollout.world, {}, "arm", UR5E.home, 0.085, relations=frozenset({("on", "block", "shelf")}))
    return Candidate(
        Plan("p", (), ()), Program("p", "arm", "ur5e", UR5E.gripper.tcp, UR5E.home, (), ()), Code("text", text, ORIGINS, ".txt"), {},
        belief, actions, UR5E, rollout.world, (), taxonomy(), rollout, None, (), parts, allowed, handovers=HANDOVERS,
    )  # fmt: skip


def touches(k: int) -> tuple[Touch, ...]:
    """List the contacts of the hand-written run at a sample."""
    found = [Touch("shelf", "cup", WEIGHT, WEIGHT)]
    if k < LIFTED:
        found.append(Touch("floor", "block", WEIGHT, WEIGHT))
    if TAKEN <= k < OPENED:
        found += [Touch(LEFT, "block", 50.0, WEIGHT / 2), Touch("block", RIGHT, 50.0, -WEIGHT / 2)]
    if k >= LANDED:
        found.append(Touch("block", "shelf", WEIGHT, -WEIGHT))
    return tuple(found)


def touching(when: Iterable[int], *more: Touch, without: Callable[[Touch], bool] = lambda _: False) -> Candidate:
    """Return the hand-written candidate with contacts added and removed at some samples of its run."""
    rows, base = set(when), good().rollout
    assert base is not None
    return good(touches=tuple((*(t for t in row if not without(t)), *more) if k in rows else row for k, row in enumerate(base.touches)))


def posed(**poses: Floats) -> Candidate:
    """Return the hand-written candidate with other tracks of some things."""
    base = good().rollout
    assert base is not None
    return good(poses={**base.poses, **poses})


def shifted(by: Any, thing: str, first: int, last: int = COUNT) -> Candidate:
    """Return the hand-written candidate with a thing displaced by a vector [m] at samples [first, last)."""
    base = good().rollout
    assert base is not None
    poses = base.poses[thing].copy()
    poses[first:last, :3] += by
    return posed(**{thing: poses})


def said(validator: Validator, of: Candidate) -> list[str]:
    """Return the objections of a validator to a candidate."""
    return [f.reason for f in validator.check(of) if not f.passed]


def only(validator: Validator, of: Candidate) -> Finding:
    """Return the only finding of a validator on a candidate."""
    (found,) = validator.check(of)
    return found
