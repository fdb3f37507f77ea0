"""Known models registered with a part of the picture: coarsely, in full, and turned by their print."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Value

from ..pose.estimate import COARSE, FINE, MIDDLE, PoseHypothesis, allowed, best, hypotheses, without_duplicates
from ..pose.icp import PoseBatch, RegistrationStage, register, spread
from ..pose.model import Floats32, PoseModel
from ..pose.outline import Outline
from ..pose.prior import Prior
from ..pose.score import ENOUGH, SURFACE, Scores, score_poses
from ..pose.starts import slid, starts_for
from .agreement import agreement, best_by_print
from .appearance import Appearance
from .possible import possible
from .reading import Reading, Scene
from .region import Region
from .standing import as_high, standing_at

STEP = 10
"""Step of the turns about the vertical that are compared by their print [deg]: a letter of 10 mm on a can is 15 deg wide."""
TURNED = RegistrationStage(points=200, iterations=3, reach=(0.010, 0.006), beside=0.5, slack=0.003, outline=200, weight=0.5)
"""Stage in which turned poses are registered: the middle of a nearly round thing's box is some millimetres beside its axis."""
FEWER = 60
"""Points of a model by which impossible poses are left out at first."""


def _scored(model: PoseModel, seen: tuple[Floats32, Outline], poses: PoseBatch, surface: int = SURFACE) -> Scores:
    """Score poses of a model against a part of the depth image.

    Each score is divided by the square root of the seen share of the model's visible side: scores are squared
    later, which would count this share twice.
    """
    scores = score_poses(model, *seen, poses, surface)
    return replace(scores, score=scores.score / np.sqrt(np.clip(scores.seen / ENOUGH, 1e-3, 1.0)))


def posed(scene: Scene, starts: PoseBatch) -> list[PoseHypothesis]:
    """Convert a batch of registered poses to pose hypotheses in the world frame, in the same order."""
    ones = np.arange(len(starts), 0, -1, dtype=np.float32)
    return hypotheses(scene.picture.view, starts, Scores(ones, ones, ones, ones, ones))


class Started(Value, eq=False):
    """The best few poses of a model after the first stage of registration with a region, and the best score of their shapes."""

    appearance: Appearance
    starts: PoseBatch
    score: float


def started(region: Region, appearance: Appearance, prior: Prior) -> Started | None:
    """Register a model with a region of the picture from all usual attitudes, with few points; None if no pose is possible.

    The search for a large model has a longer reach and takes more iterations.
    """
    seen, model, scene = region.seen, appearance.surface, region.scene
    if seen is None:
        return None
    view = scene.picture.view
    reach = max(COARSE.reach[0], scene.limits["far"] * model.diameter)
    stage = replace(COARSE, reach=(reach, COARSE.reach[1]), iterations=(2 if _is_large(scene, model) else 1) * COARSE.iterations)
    begun = _begun(region, appearance, prior, seen[0])
    starts = register(model, seen[0], begun, stage, seen[1])
    starts = allowed(view, prior, starts)
    starts = slid(model, seen[1], starts) if len(starts) and region.is_covered else starts
    if not len(starts):
        return None
    scores = score_poses(model, *seen, starts, 200).score
    order: Any = np.argsort(-scores, kind="stable")
    free = _possible(scene, appearance, starts, order)
    if len(free) or (region.is_covered and region.rarity == 1):  # few of the many poses that fit a strip are possible
        order = free
    order = order[: int(scene.limits["yaws"])]
    return Started(appearance, starts.pick(order), float(scores[order[0]])) if len(order) else None


def _begun(region: Region, appearance: Appearance, prior: Prior, seen: Floats32) -> PoseBatch:
    """Poses from which a model's registration starts: in all attitudes of a prior, and if it stands, those alone that are as high."""
    scene, floor, camera = region.scene, region.floor, region.scene.picture.view.camera
    if floor is None:
        return starts_for(camera, appearance.surface, prior, seen)
    prior = as_high(appearance, prior, region.highest - floor, scene.limits, whole=not region.is_covered)
    return standing_at(scene, appearance, starts_for(camera, appearance.surface, prior, seen), floor)


def _is_large(scene: Scene, model: PoseModel) -> bool:
    return model.diameter > scene.limits["large_m"]


def _fine(scene: Scene, model: PoseModel) -> RegistrationStage:
    """Return the last stage of registration; in its short reach a large model takes more iterations."""
    return replace(FINE, iterations=int(scene.limits["slow"]) * FINE.iterations) if _is_large(scene, model) else FINE


def _possible(scene: Scene, appearance: Appearance, starts: PoseBatch, order: Any) -> Any:
    """Return the indices of those of the best poses, in their ``order``, that lie outside of furniture and robot."""
    tried = order[: int(scene.limits["yaws"] * scene.limits["tried"])]
    some = spread(appearance.surface.points, FEWER)
    in_camera = (some - starts.shift[tried][:, None]) @ starts.turn[tried]  # of rows: the inverse of a rotation is its transpose
    points = scene.picture.view.camera.apply(in_camera.reshape(-1, 3).astype(float)).reshape(in_camera.shape)
    return tried[possible(scene, appearance, points)]


def coarse_poses(region: Region, found: Started) -> PoseBatch | None:
    """Refine the poses that a model's registration was started with; of them, those that are possible are returned, all if none is."""
    seen = region.seen
    if seen is None:
        return None
    starts = register(found.appearance.surface, seen[0], found.starts, MIDDLE, seen[1])
    free = _possible(region.scene, found.appearance, starts, np.arange(len(starts)))
    return starts.pick(free) if len(free) else starts


class Ranked(Value, eq=False):
    """Best explanation of a region by a model after coarse registration, and all poses that it was chosen from."""

    reading: Reading
    starts: PoseBatch


def coarse_reading(region: Region, found: Started) -> Ranked | None:
    """Choose the best of a model's coarsely registered poses by shape and print."""
    starts, seen, scene, appearance = coarse_poses(region, found), region.seen, region.scene, found.appearance
    if starts is None or seen is None:
        return None
    scored = hypotheses(scene.picture.view, starts, _scored(appearance.surface, seen, starts, 300))
    k, colour = best_by_print(scene.picture, region.mask, appearance, [h.pose for h in scored], np.array([h.score for h in scored]))
    return Ranked(Reading(appearance, scored[k].pose, scored[k].score, colour), starts)


def full_readings(region: Region, ranked: Ranked, prior: Prior) -> list[Reading]:
    """Explanations of a region of the picture by a model that is fully registered with it, each in the pose at which the
    model's texture agrees best."""
    appearance, seen, scene = ranked.reading.appearance, region.seen, region.scene
    if seen is None:
        return []
    model, view, kept = appearance.surface, scene.picture.view, int(scene.limits["poses"])
    starts = best(model, *seen, slid(model, seen[1], best(model, *seen, ranked.starts, kept, 300)), kept, 300)
    starts = allowed(view, prior, register(model, seen[0], starts, _fine(scene, model), seen[1]))
    scored = hypotheses(view, starts, _scored(model, seen, starts))
    return [_by_print(region, appearance, seen, h) for h in without_duplicates(model, scored)]


def _by_print(region: Region, appearance: Appearance, seen: tuple[Floats32, Outline], found: PoseHypothesis) -> Reading:
    """Explanation of a region of the picture by a model at a registered pose, turned by a symmetry or about the vertical
    to where shape and texture agree best.

    The turned pose is registered once more.
    """
    model, scene = appearance.surface, region.scene
    poses, fits = _turned(scene, seen, model, found.pose)
    k, colour = best_by_print(scene.picture, region.mask, appearance, poses, fits)
    again = register(model, seen[0], pose_batch(scene, [poses[k]]), _fine(scene, model), seen[1])
    refined = hypotheses(scene.picture.view, again, _scored(model, seen, again))
    pose, fit = poses[k], float(fits[k])
    if refined and refined[0].score >= fit:
        pose, fit = refined[0].pose, refined[0].score
        colour = float(agreement(scene.picture, region.mask, appearance, [pose])[0])
    return Reading(appearance, pose, fit, colour, (*found.reasons, f"{100 * colour:.0f} % of its printed texture agrees with the picture"))


def again(region: Region, appearance: Appearance, pose: Pose, reasons: tuple[str, ...]) -> Reading | None:
    """Register a model once more from a pose, finely; None if no pose is possible."""
    seen, model, scene = region.seen, appearance.surface, region.scene
    if seen is None:
        return None
    starts = register(model, seen[0], pose_batch(scene, [pose]), _fine(scene, model), seen[1])
    scored = hypotheses(scene.picture.view, starts, _scored(model, seen, starts))
    if not scored:
        return None
    colour = float(agreement(scene.picture, region.mask, appearance, [scored[0].pose])[0])
    return Reading(appearance, scored[0].pose, scored[0].score, colour, (*scored[0].reasons, *reasons))


def _turned(scene: Scene, seen: tuple[Floats32, Outline], model: PoseModel, pose: Pose) -> tuple[list[Pose], Floats]:
    """A pose of a model, and the turned poses (by a symmetry or about the vertical) that fit the picture nearly as
    well, with their scores.

    Of nearly round things many turns fit. Since they are not quite round, those that fit by half are registered before they are compared.
    """
    centre = pose.apply(model.centre)
    there, back = Pose(tuple(centre)), Pose(tuple(-centre))
    yaws = [there * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(a))) * back * pose for a in range(STEP, 360, STEP)]
    begun = pose_batch(scene, [pose, *yaws, *(pose * s for s in model.symmetries[1:9])])
    scores = _scored(model, seen, begun, 300).score
    nearly = np.flatnonzero(scores[1:] >= scene.limits["half"] * scores[0]) + 1
    turned = begun.pick([0]).joined(register(model, seen[0], begun.pick(nearly), TURNED, seen[1]))
    scores = _scored(model, seen, turned).score
    kept = np.flatnonzero(scores >= scene.limits["as_well"] * scores[0])
    poses = [h.pose for h in posed(scene, turned.pick(kept))]
    return [pose, *poses[1:]], np.asarray(scores[kept], dtype=float)


def pose_batch(scene: Scene, poses: Sequence[Pose]) -> PoseBatch:
    """Convert poses of a model in the world to the batch of poses that registration takes."""
    inverse = [(scene.picture.view.camera.inverse() * p).inverse() for p in poses]
    return PoseBatch(np.array([p.rotation for p in inverse], np.float32), np.array([p.position for p in inverse], np.float32))
