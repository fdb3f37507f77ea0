"""6D pose estimation of a known object in one depth image: batched registration, scored against the image."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from cramlite.model import Mask, Pose, Value, View

from .icp import PoseBatch, RegistrationStage, register
from .model import Floats32, PoseModel, cube_rotations
from .outline import Outline
from .prior import UPRIGHT, Prior, alignment_error
from .score import Scores, score_poses
from .starts import SceneCloud, scene_clouds, slid, starts_for

COARSE = RegistrationStage(points=120, iterations=7, reach=(0.05, 0.015), beside=0.5, slack=0.003)
MIDDLE = RegistrationStage(points=250, iterations=6, reach=(0.02, 0.008), beside=0.5, slack=0.003, outline=200, weight=0.5)
FINE = RegistrationStage(points=800, iterations=8, reach=(0.010, 0.006), beside=0.5, slack=0.003, outline=600, weight=0.5)
"""Stages of registration, from coarse to fine. Half as many points and iterations again in each stage costs 25 % more time and changes
no figure of tests/benchmarks/perception_pose.py on its development seeds; a quarter less loses 4 points of HARD."""
LEAST = 30
"""Points of a mask below which no pose is tried: a face of 30 pixels leaves more than 5 degrees open."""
KEPT = 5
TIE, OTHER, DOUBT = 0.05, (0.005, math.radians(8)), 0.6
"""Scores nearer than this, of poses farther apart than this [m, rad], leave open which is right: half of the development
views with confident wrong poses have such a rival, and 4 % of those with right ones."""
WHOLE = 0.9
"""Share of a mask's points above which its largest part is searched alone first: what else there is may be an occluder's
edge. Below it all parts together come first: of 95 such views among the HARD development seeds 0 to 249, 93 are right by
all parts and 80 by the largest one, which scores below ``DOUBT`` 12 times; of the 45 others 43 are right by either."""


class PoseHypothesis(Value):
    """Estimated 6D pose of an object with its score and the reasons for it.

    Args:
        pose: of the model's frame in the world.
        score: 0 to 1; above 0.6 a pose is right in most cases (docs/figures/perception_pose.yaml).
        reasons: clauses with numbers.
    """

    pose: Pose
    score: float
    reasons: tuple[str, ...] = ()


def estimate(view: View, mask: Mask, model: PoseModel, prior: Prior = UPRIGHT) -> list[PoseHypothesis]:
    """Estimate the 6D pose of the object that a mask shows; hypotheses, best first.

    A pose that the camera cannot tell from another one (a symmetry) comes with it, at the same score.

    Args:
        mask: (height, width) of the object; a pixel or two too many do no harm.
        prior: what is known of the orientation.

    Returns:
        Empty if the mask shows fewer than ``LEAST`` points, or if no pose keeps to the prior.
    """
    parts = scene_clouds(view, mask)
    if not parts or len(parts[0].points) < LEAST:
        return []
    everything, outline = parts[-1].points, Outline.of(view, parts[-1].mask)
    first, *others = parts if len(parts[0].points) > WHOLE * len(everything) else parts[::-1]
    starts = _search(view, model, prior, first)
    scores = score_poses(model, everything, outline, starts)
    if others and scores.score.max(initial=0.0) < DOUBT:
        starts = starts.joined(_search(view, model, prior, others[0], again=True))
        scores = score_poses(model, everything, outline, starts)
    return distinct(model, prior, hypotheses(view, starts, scores))


def _search(view: View, model: PoseModel, prior: Prior, scene: SceneCloud, *, again: bool = False) -> PoseBatch:
    """The best few poses of a model, registered with some points of a mask; possibly none.

    Args:
        again: a retry leaves out the flip test and the second slides, which takes 35 ms rather than 55 and changed nothing
            where it was needed: 13 of 14 of 160 HARD development views were right with and without them.
    """
    points, outline = scene.points, Outline.of(view, scene.mask)
    starts = register(model, points, starts_for(view.camera, model, prior, points), COARSE, outline)
    starts = best(model, points, outline, allowed(view, prior, starts), 6, 250)
    starts = best(model, points, outline, slid(model, outline, starts), 8, 250)
    starts = register(model, points, starts, MIDDLE, outline)
    starts = best(model, points, outline, starts, 2 if again else 3, 400)
    if again:
        starts = register(model, points, starts, FINE, outline)
    elif len(starts):
        turned = allowed(view, prior, _turned(model, starts.pick([0])))
        starts = starts.joined(register(model, points, turned, MIDDLE, outline))
        starts = register(model, points, best(model, points, outline, starts, KEPT, 400), FINE, outline)
        slides = best(model, points, outline, slid(model, outline, starts.pick(slice(0, 2))), 2, 400)
        starts = starts.joined(register(model, points, slides, FINE, outline))
    return allowed(view, prior, starts)


def best(model: PoseModel, scene: Floats32, outline: Outline, starts: PoseBatch, count: int, surface: int) -> PoseBatch:
    """Return the ``count`` hypotheses with the highest scores."""
    if len(starts) <= 1:
        return starts
    order = np.argsort(-score_poses(model, scene, outline, starts, surface).score, kind="stable")
    return starts.pick(order[:count])


def _turned(model: PoseModel, starts: PoseBatch) -> PoseBatch:
    """The flip test: the best pose turned about the model's centre by each other rotation of a cube."""
    turns = np.array([p.rotation for p in cube_rotations()[1:]], np.float32)
    centre = model.centre.astype(np.float32)
    shift = (turns @ (starts.shift[0] - centre)) + centre
    return PoseBatch(np.asarray(turns @ starts.turn[0]), shift)


def allowed(view: View, prior: Prior, starts: PoseBatch) -> PoseBatch:
    """Return the hypotheses that are finite and deviate from the orientation prior by no more than it allows."""
    keep = np.isfinite(starts.turn).all((1, 2)) & np.isfinite(starts.shift).all(1)
    for a in prior.alignments:
        keep &= alignment_error(view.camera, starts.turn, a) <= a.after
    return starts.pick(keep)


def hypotheses(view: View, starts: PoseBatch, scores: Scores) -> list[PoseHypothesis]:
    """Convert scored registrations to poses in the world frame with reasons, best first."""
    found = []
    for i in np.argsort(-scores.score, kind="stable"):
        in_camera = _pose(starts.turn[i], starts.shift[i])
        reasons = (
            f"explains {100 * scores.explained[i]:.0f} % of the mask",
            f"the image confirms {100 * scores.free[i]:.0f} % of the surface that nothing hides",
            f"{100 * scores.seen[i]:.0f} % of its visible side seen",
        )
        found.append(PoseHypothesis(view.camera * in_camera, float(scores.score[i]), reasons))
    return found


def _pose(turn: Floats32, shift: Floats32) -> Pose:
    """Pose of the model in the optical frame, from rotation and position of the optical frame in the
    model's."""
    u, _, vt = np.linalg.svd(turn.astype(float))
    rotation = u @ vt
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.T, -rotation.T @ shift
    return Pose.from_matrix(matrix)


def without_duplicates(model: PoseModel, found: Sequence[PoseHypothesis]) -> list[PoseHypothesis]:
    """Return hypotheses without those that are within 3 mm and 3 degrees of a better one."""
    kept: list[PoseHypothesis] = []
    for h in found:
        apart = [model.difference(h.pose, k.pose) for k in kept]
        if all(d > 0.003 or a > math.radians(3) for d, a in apart):
            kept.append(h)
    return kept


def distinct(model: PoseModel, prior: Prior, found: list[PoseHypothesis]) -> list[PoseHypothesis]:
    """Remove duplicate poses, and add the symmetric equivalents of the best."""
    kept = _doubted(model, without_duplicates(model, found))
    if not kept or model.axis is not None:
        return kept
    same = [
        PoseHypothesis(kept[0].pose * s, kept[0].score, (*kept[0].reasons, SYMMETRIC)) for s in model.symmetries[1:]
    ]
    upright = [h for h in same if keeps_to(h.pose, prior)]
    return [kept[0], *upright, *kept[1:]]


def _doubted(model: PoseModel, found: list[PoseHypothesis]) -> list[PoseHypothesis]:
    """Cap at ``DOUBT`` the scores of the best pose hypothesis and of each clearly different one that fits
    as well."""
    if not found:
        return found
    best, doubted = found[0], list(found)
    for k, rival in enumerate(found[1:], 1):
        metres, turn = model.difference(rival.pose, best.pose)
        if best.score - rival.score >= TIE or (metres < OTHER[0] and turn < OTHER[1]):
            continue
        far = f"{1000 * metres:.0f} mm and {math.degrees(turn):.0f} deg away"
        doubted[0] = replace(best, score=min(best.score, DOUBT), reasons=(*best.reasons, f"a pose {far} fits as well"))
        doubted[k] = replace(rival, score=min(rival.score, DOUBT))
    return doubted


SYMMETRIC = "depth cannot tell it from the best: the shape is symmetric"


def keeps_to(pose: Pose, prior: Prior) -> bool:
    """Check whether an object pose in the world deviates from the orientation prior by no more than it allows."""
    turn = pose.inverse().rotation[None].astype(np.float32)
    return all(float(alignment_error(Pose(), turn, a)[0]) <= a.after for a in prior.alignments)
