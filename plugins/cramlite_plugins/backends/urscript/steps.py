"""URScript of steps that contain no other steps: definitions, preparation, and the call that returns success."""

from __future__ import annotations

from collections.abc import Callable

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Gripper,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Pose,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Value,
    Wait,
    ZeroSensor,
)

from ..names import Names
from ..unsupported import unsupported_step
from . import search as urscript_search
from .late import shift
from .literals import label, number, pose, vector

# Acceleration of guarded and force-controlled motions [m/s2]: gentle, so that inertia stays below the thresholds.
GENTLE = 0.25
# A slide follows the height of its surface at most this fast [m/s]: in simulation 10 mm/s has peaks of 12 N on a stiff
# board when pressing with 4 N, 20 mm/s of 14 N.
HEIGHT = 0.01
LEAST = 0.25  # share of the pressing force below which a slide has lost its contact: CompliantSlide says so


class Leaf(Value):
    """A step as URScript text.

    Args:
        lines: what leads up to the call, or all of it.
        call: true when the step succeeded; empty for a step that cannot fail.
        thread: the motion that the program starts and watches, and its name; it is defined before.
    """

    lines: tuple[str, ...] = ()
    call: str = ""
    thread: tuple[str, ...] = ()


def leaf(step: AnyStep, gripper: Gripper, name: Callable[[], str], poses: Names, *, watched: bool = False) -> Leaf:
    """Format a step that contains no other steps as URScript.

    Args:
        name: gives a new name for a thread that moves.
        poses: takes what the step leads to, and names it.
        watched: plain motions too run in a thread, so that they can be stopped, and standing still can be interrupted.

    Raises:
        UserError: URScript has no counterpart of the step.
    """
    match step:
        case MoveJoints() | MoveLinear():
            moves = _moves(step, poses)
            return _moving((), moves, name(), "watch_move()") if watched else Leaf(tuple(moves))
        case MoveUntilContact():
            return Leaf(call=_guarded(step))
        case ForceMove():
            return _forced(step, name(), poses)
        case CompliantSlide():
            return _sliding(step, name(), poses)
        case SpiralSearch() | ForceInsert() | ForceExtract():
            return Leaf(call=urscript_search.call(step, poses))
        case SetGripper():
            return Leaf(call=_grip(step, gripper))
        case SetPayload():
            return Leaf((f"set_target_payload({number(step.mass)}, {vector(step.center)})",))
        case ZeroSensor():
            return Leaf(("sleep(0.3)  # the sensor's filter and the arm settle", "zero_ftsensor()"))
        case Wait():
            still = number(step.duration)
            return Leaf(call=f"stand_still({still})") if watched else Leaf((f"sleep({still})",))
    raise unsupported_step(step, "URScript")


def _moves(step: MoveJoints | MoveLinear, poses: Names) -> list[str]:
    rates = f"a={number(step.acceleration)}, v={number(step.speed)}"
    if isinstance(step, MoveLinear):
        return [f"movel({_place(step, poses)}, {rates})"]
    radii = [*(step.radii or (0.0,) * (len(step.path) - 1)), 0.0]
    blends = [f", r={number(r)}" if r > 0 else "" for r in radii]
    names = [poses.of(step.origin, "joints", vector(q)) for q in step.path]
    return [f"movej({q}, {rates}{blend})" for q, blend in zip(names, blends, strict=True)]


def _place(step: MoveLinear, poses: Names) -> str:
    target = poses.of(step.origin, "pose", pose(step.target))
    return f"pose_trans({shift(step.relative)}, {target})" if step.relative else target


def _direction(step: MoveUntilContact) -> str:
    """Direction of a guarded motion in the base frame; a direction relative to a thing turns with it."""
    if not step.relative:
        return vector(step.direction)
    moved, way = shift(step.relative), pose(Pose(step.direction))
    return f"pose_sub(pose_trans({moved}, {way}), {moved})"


def _moving(before: tuple[str, ...], moves: list[str], name: str, watch: str) -> Leaf:
    """URScript of a thread that executes a motion, with its start and the loop that watches it."""
    thread = (f"thread {name}():", *(f"  {line}" for line in moves), "  motion_done = True", "end")
    return Leaf(("motion_done = False", *before, f"motion_thread = run {name}()"), watch, thread)


def _guarded(step: MoveUntilContact) -> str:
    values = [_direction(step), *map(number, (step.distance, step.speed, step.force, step.timeout))]
    said = f"until {step.force:g} N, within {1000 * step.distance:.1f} mm at {1000 * step.speed:g} mm/s"
    return f'move_until_contact({", ".join(values)}, "{step.expect}", "{label(step.origin)}")  # {said}'


def _forced(step: ForceMove, name: str, poses: Names) -> Leaf:
    frame = poses.of(step.origin, "frame", pose(Pose((0.0, 0.0, 0.0), step.frame.quaternion)))
    selection = "[" + ", ".join("1" if c else "0" for c in step.compliant) + "]"
    mode = f"force_mode({frame}, {selection}, {vector(step.wrench)}, 2, {vector(step.limits)})"
    watch = f'watch_force_move({number(step.force_limit)}, {number(step.timeout)}, "{label(step.origin)}"){_ends(step)}'
    return _moving((mode,), _path(step, poses), name, watch)


def _sliding(step: CompliantSlide, name: str, poses: Names) -> Leaf:
    frame = Pose((0.0, 0.0, 0.0), step.frame.quaternion)
    wrench, limits = vector((0, 0, step.force, 0, 0, 0)), vector((0.15, 0.15, HEIGHT, 0.35, 0.35, 0.35))
    own = poses.of(step.origin, "frame", pose(frame))
    mode = f"force_mode({own}, [0, 0, 1, 0, 0, 0], {wrench}, 2, {limits})"
    values = map(number, (LEAST * step.force, step.lost, step.force_limit, step.timeout))
    watch = (
        f'watch_slide({vector(urscript_search.along(frame))}, {", ".join(values)}, "{label(step.origin)}"){_ends(step)}'
    )
    return _moving((mode,), _path(step, poses), name, watch)


def _path(step: ForceMove | CompliantSlide, poses: Names) -> list[str]:
    names = [poses.of(step.origin, "pose", pose(w)) for w in step.waypoints]
    return [f"movel({name}, a={number(GENTLE)}, v={number(step.speed)})" for name in names]


def _ends(step: ForceMove | CompliantSlide) -> str:
    return f"  # at most {step.force_limit:g} N, within {step.timeout:g} s"


def _grip(step: SetGripper, gripper: Gripper) -> str:
    low, high = gripper.opening
    position = count((high - step.opening) / (high - low))
    speed = count((step.speed - gripper.speed[0]) / (gripper.speed[1] - gripper.speed[0]))
    force = count((step.force - gripper.force[0]) / (gripper.force[1] - gripper.force[0]))
    wanted = f'"{step.expect}", {number(step.timeout)}, "{label(step.origin)}"'
    return f"move_gripper({position}, {speed}, {force}, {wanted})  # {step.opening * 1000:.1f} mm, {step.force:.0f} N"


def count(share: float) -> int:
    """Convert a share of a range (0 to 1) to a gripper register 0 .. 255."""
    return min(255, max(0, round(255 * share)))
