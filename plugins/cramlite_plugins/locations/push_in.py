"""Pushing something back to where it is believed to lie: fingers come down well behind it, and go on to where its end should be.

What was let go of to tip over comes out with the hand, by more or less; wherever it is on their way, the fingers leave it where it should be.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cramlite.model import Belief, Location, Place, Pose
from cramlite.plugin import Answers, Context, Grounding, Refused, hookimpl

from .push_to import ABOVE, GAP, SPOT, hands_behind

CAME_OUT = 0.1
"""At most, of what was let go of [m]: with pads whose friction is 2 LIBERO's book came out by 48 mm."""
AHEAD = 0.1  # of a thing, a point that gives the way [m]


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Resolve location "pushed_in"; None for other relations."""
    return _pushed_in(location, belief, context) if location.relation == "pushed_in" else None


def _pushed_in(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    """Fingers behind a thing, seen along the approach of the place where it was let go of; the ``path`` ends where it is believed to be."""
    from ..motion_planning.reach import bound, collision_free_ik, make_scene, reference_pose, shift
    from ..motion_planning.space import Refusal

    entity, begun = bound(context, location.of), context.bindings[str(location.parameters["begin"])]
    thing, pose, ahead = belief.thing(entity), reference_pose(belief, location, context), np.asarray(begun.approach)
    there = Pose(tuple((np.asarray(pose.position) + AHEAD * ahead).tolist()))
    for k, (_, near, opening, turn) in enumerate(hands_behind(thing, pose, location, context.robot.gripper, SPOT, there, (0.0,))):
        end, at = shift(near, GAP * ahead), shift(near, -CAME_OUT * ahead)
        before, seed = shift(at, (0.0, 0.0, ABOVE)), belief.joints
        scenes = make_scene(belief, context, (), opening), make_scene(belief, context, [entity], opening, 0.0)
        for scene, hand in ((scenes[0], before), (scenes[0], at), (scenes[1], end)):
            found = collision_free_ik(scene, context, hand, seed)
            if isinstance(found, Refusal):
                yield found.refused(f"hand {turn}")
                break
            seed = found
        else:
            place = Place(at, before, opening, (0.0, 0.0, -1.0), (end,), thing=thing.name)
            yield Grounding(place, f"'{entity}' {1000 * CAME_OUT:.0f} mm from behind, hand {turn}", 0.1 * k, key=turn, anew=True)
