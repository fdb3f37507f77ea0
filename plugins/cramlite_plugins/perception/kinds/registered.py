"""Known models registered with a part of the picture: coarsely, in full, and turned by their print."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Mask, Pose

from ..pose.estimate import COARSE, FINE, MIDDLE, PoseHypothesis, allowed, best, hypotheses, without_duplicates
from ..pose.icp import PoseBatch, register
from ..pose.model import Floats32, PoseModel
from ..pose.outline import Outline
from ..pose.prior import Alignment, Prior
from ..pose.score import ENOUGH, SURFACE, Scores, score_poses
from ..pose.starts import scene_clouds, slid, starts_for
from .agreement import agreement
from .appearance import Appearance
from .pieces import covered
from .reading import Reading, Scene

STEP = 10
"""Step of the turns about the vertical that are compared by their print [deg]: a letter of 10 mm on a can is 15 deg wide."""


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


def standing(appearance: Appearance) -> Prior:
    return Prior((Alignment(appearance.up, ((0.0, 0.0, 1.0),)),))


def is_covered(scene: Scene, mask: Mask) -> bool:
    return covered(scene.picture.view, mask, scene.front) > scene.limits["covered"]


def seen_part(scene: Scene, mask: Mask) -> tuple[Floats32, Outline] | None:
    """Points of a part of the picture in the optical frame, and its outline; None if the points are too few."""
    clouds = scene_clouds(scene.picture.view, mask)
    if not clouds or len(clouds[-1].points) < scene.limits["pixels"] / 2:
        return None
    return clouds[-1].points, Outline.of(scene.picture.view, clouds[-1].mask)


def coarse_poses(scene: Scene, mask: Mask, appearance: Appearance, prior: Prior) -> PoseBatch | None:
    """The best few poses of a model after coarse registration with a part of the picture; None if there are none.

    The search for a large model has a longer reach and takes more iterations.
    """
    seen, model, view = seen_part(scene, mask), appearance.surface, scene.picture.view
    if seen is None:
        return None
    large = model.diameter > scene.limits["large_m"]
    reach = max(COARSE.reach[0], scene.limits["far"] * model.diameter)
    stage = replace(COARSE, reach=(reach, COARSE.reach[1]), iterations=(2 if large else 1) * COARSE.iterations)
    starts = register(model, seen[0], starts_for(view.camera, model, prior, seen[0]), stage, seen[1])
    starts = allowed(view, prior, starts)
    starts = slid(model, seen[1], starts) if len(starts) and is_covered(scene, mask) else starts
    starts = best(model, *seen, starts, int(scene.limits["yaws"]), 200)
    return register(model, seen[0], starts, MIDDLE, seen[1]) if len(starts) else None


def coarse_reading(scene: Scene, mask: Mask, appearance: Appearance, prior: Prior) -> Reading | None:
    """Best explanation of a part of the picture by a model after coarse registration; None where no pose is
    possible."""
    starts, seen = coarse_poses(scene, mask, appearance, prior), seen_part(scene, mask)
    if starts is None or seen is None:
        return None
    scored = hypotheses(scene.picture.view, starts, _scored(appearance.surface, seen, starts, 300))
    colours = agreement(scene.picture, mask, appearance, [h.pose for h in scored])
    found = [Reading(appearance, h.pose, h.score, float(c)) for h, c in zip(scored, colours, strict=True)]
    return max(found, key=lambda r: r.score)


def full_readings(scene: Scene, mask: Mask, appearance: Appearance, prior: Prior) -> list[Reading]:
    """Explanations of a part of the picture by a model that is fully registered with it, each in the pose at which the
    model's texture agrees best."""
    starts, seen, model, view = coarse_poses(scene, mask, appearance, prior), seen_part(scene, mask), appearance.surface, scene.picture.view
    if starts is None or seen is None:
        return []
    kept = int(scene.limits["poses"])
    starts = best(model, *seen, slid(model, seen[1], best(model, *seen, starts, kept, 300)), kept, 300)
    starts = allowed(view, prior, register(model, seen[0], starts, FINE, seen[1]))
    found = []
    for h in without_duplicates(model, hypotheses(view, starts, _scored(model, seen, starts))):
        found.append(_by_print(scene, mask, appearance, seen, h))
    return found


def _by_print(scene: Scene, mask: Mask, appearance: Appearance, seen: tuple[Floats32, Outline], found: PoseHypothesis) -> Reading:
    """Explanation of a part of the picture by a model at a registered pose, turned by a symmetry or about the vertical
    to where shape and texture agree best.

    The turned pose is registered once more.
    """
    model = appearance.surface
    poses, fits = _turned(scene, seen, model, found.pose)
    colours = agreement(scene.picture, mask, appearance, poses)
    k = int((fits * fits * colours).argmax())
    again = register(model, seen[0], pose_batch(scene, [poses[k]]), FINE, seen[1])
    refined = hypotheses(scene.picture.view, again, _scored(model, seen, again))
    pose, fit, colour = poses[k], float(fits[k]), float(colours[k])
    if refined and refined[0].score >= fit:
        pose, fit = refined[0].pose, refined[0].score
        colour = float(agreement(scene.picture, mask, appearance, [pose])[0])
    return Reading(appearance, pose, fit, colour, (*found.reasons, f"{100 * colour:.0f} % of its printed texture agrees with the picture"))


def _turned(scene: Scene, seen: tuple[Floats32, Outline], model: PoseModel, pose: Pose) -> tuple[list[Pose], Floats]:
    """A pose of a model, and the turned poses (by a symmetry or about the vertical) that fit the picture nearly as
    well, with their scores.

    Of nearly round things many turns fit.
    """
    centre = pose.apply(model.centre)
    there, back = Pose(tuple(centre)), Pose(tuple(-centre))
    yaws = [there * Pose.from_rotvec((0, 0, 0), (0, 0, math.radians(a))) * back * pose for a in range(STEP, 360, STEP)]
    poses = [pose, *yaws, *(pose * s for s in model.symmetries[1:9])]
    scores = _scored(model, seen, pose_batch(scene, poses), 300).score
    kept = np.flatnonzero(scores >= scene.limits["as_well"] * scores[0])
    return [poses[k] for k in kept], np.asarray(scores[kept], dtype=float)


def pose_batch(scene: Scene, poses: Sequence[Pose]) -> PoseBatch:
    """Convert poses of a model in the world to the batch of poses that registration takes."""
    inverse = [(scene.picture.view.camera.inverse() * p).inverse() for p in poses]
    return PoseBatch(np.array([p.rotation for p in inverse], np.float32), np.array([p.position for p in inverse], np.float32))
