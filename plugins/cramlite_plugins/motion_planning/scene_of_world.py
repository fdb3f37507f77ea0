"""Planning scenes of a world: which things move with the arm, what may touch, and which distances are
kept."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from msgspec.structs import replace

from cramlite.model import Pose, Robot, World

from ..simulation.model.build import Carried
from .pairs import Pairs, required_distances
from .planning_models import arm_chains, arm_movers, inflated_model, planning_model
from .planning_scene import KEPT, PlanningScene
from .postures import CLEARANCE, HORIZON, LEVELS, joint_view


def _farthest(clearance: float, wider: Mapping[str, float]) -> float:
    """Return the largest distance that any pair must keep [m]; refuse one above ``HORIZON``, the largest that
    is measured."""
    most = clearance + max(wider.values(), default=0.0)
    if not 0 <= clearance <= most <= HORIZON:
        raise ValueError(f"clearance {clearance} m and {dict(wider)}; it must lie between 0 and {HORIZON} m")
    return most


def scene(
    world: World,
    robots: Mapping[str, Robot],
    mount: str,
    *,
    poses: Mapping[str, Pose] | None = None,
    held: Mapping[str, Pose] = MappingProxyType({}),
    opening: float | None = None,
    allowed: Pairs = frozenset(),
    clearance: float = CLEARANCE,
    wider: Mapping[str, float] = MappingProxyType({}),
) -> PlanningScene:
    """Build a planning scene of a world.

    Args:
        robots: descriptions by type name.
        mount: the name of the robot that moves; others stay at home.
        poses: where things are now, in the world frame; those not named are where the world has them.
        held: thing -> its pose in the tcp frame: moves with the tool and may touch the gripper.
        opening: distance between the pads [m]; None is fully open.
        allowed: unordered pairs of names that may touch: "thing", "thing/part", "effector", "effector/left",
            "arm" or "mount/link". A pair allows every part of what it names.
        clearance: distance that every other pair must keep [m], up to ``HORIZON``.
        wider: thing -> what is kept from it beyond the clearance [m]; both together up to ``HORIZON``.

    Raises:
        UserError: the world does not compile.
        ValueError: the clearance is negative or above the horizon.
        KeyError: there is no such robot or thing.
    """
    most = _farthest(clearance, wider)
    for name in [*(poses or {}), *held]:
        world.thing(name)
    placed = world.moved(dict(poses or {}))
    carried = {name: Carried(mount, pose) for name, pose in held.items()}
    kept = planning_model(world, robots, carried)
    compiled = replace(kept, world=placed)
    index, data = compiled.robots[mount], compiled.places()
    width = index.reach[1] if opening is None else opening
    index.set_opening(data, width)
    movers = arm_movers(kept, mount)
    need = required_distances(compiled, movers, allowed, clearance, wider)
    distances = (most, *(v for v in LEVELS if v > most))
    levels = tuple(inflated_model(kept, mount, v) for v in distances)
    displaced = _displaced(world, poses or {}, held)
    return PlanningScene(
        compiled, index, data, joint_view(data, index), need, movers, arm_chains(kept, mount), levels,
        KEPT * most, [0], width, held, displaced,
    )  # fmt: skip


def _displaced(world: World, poses: Mapping[str, Pose], held: Mapping[str, Pose]) -> dict[str, Pose]:
    """Return the stated poses of the things that stand elsewhere in the world and are not in the hand."""
    return {n: p for n, p in poses.items() if p != world.thing(n).pose and n not in held}
