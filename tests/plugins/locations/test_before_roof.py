"""Under a roof with no room for a hand: a thing is set down before it, on the floor that leads in, and fingers push it in."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.overhang import FRONT, holding, overhang
from msgspec.structs import replace

from cramlite.model import (
    Belief,
    Estimate,
    Geom,
    Location,
    Place,
    Pose,
    Thing,
)
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E

BEFORE = Location("before(shelf)", "before", "shelf", {"region": "below"})
PUSHED = Location("pushed_in(it)", "pushed_in", "it", {"begin": "before(shelf)"})
HIGH = 0.056  # of the thing [m]


def _asked(shelf: Thing, *things: Thing) -> tuple[Belief, Context]:
    """A flat box in the hand, from above."""
    return holding(Geom("box", (0.05, 0.012, HIGH / 2)), Pose((0.45, 0.0, 0.23)), 0.25, 0.0, shelf, *things)


def _first(location: Location, belief: Belief, context: Context) -> Place:
    found: Place = next(a for a in ground(location, belief, context) if isinstance(a, Grounding)).value
    return found


def _set_down() -> tuple[Belief, Context, Place, Pose]:
    """The belief once the thing stands before the shelf, the place where it was let go of, and its pose."""
    belief, context = _asked(overhang())
    place = _first(BEFORE, belief, context)
    assert place.release is not None
    lies = place.pose * belief.payload.tcp_to_thing * place.release.settles
    away = belief.released(Estimate(lies, 0.0, "let go of"), 0.08).moved(
        inverse(UR5E, place.path[-1], seed=belief.joints)[0]
    )
    return away, replace(context, bindings={**context.bindings, BEFORE.name: place}), place, lies


def test_it_stands_on_the_table_before_the_roof_and_falls_into_nothing() -> None:
    _, _, place, lies = _set_down()
    assert lies.position[2] == pytest.approx(HIGH / 2) and lies.position[1] + 0.012 < FRONT
    assert place.release is not None and not place.release.into


def test_fingers_that_lean_push_it_in_until_its_origin_is_in_the_region() -> None:
    belief, context, place, lies = _set_down()
    push = _first(PUSHED, belief, context)
    assert place.carried is not None and place.carried.to_m is not None and push.carried is not None
    assert np.add(lies.position[1], push.carried.pushed_m) == pytest.approx(place.carried.to_m[1])
    assert FRONT + 0.005 < place.carried.to_m[1] < FRONT + 0.05
    assert push.pose.rotate((0.0, 0.0, 1.0))[1] > 0.4  # in, with the hand behind the fingers
    end = np.subtract(push.path[-1].position, push.pose.position)
    assert end == pytest.approx((0.0, push.carried.pushed_m + 0.01, 0.0), abs=1e-6)


@pytest.mark.parametrize("shelf", [overhang(floor=0.01), overhang(room=0.05)])
def test_no_way_leads_over_an_edge_or_into_less_room(shelf: Thing) -> None:
    with pytest.raises(Unresolvable):
        list(ground(BEFORE, *_asked(shelf)))


def test_what_stands_before_it_is_to_blame() -> None:
    with pytest.raises(Unresolvable) as no:
        list(ground(BEFORE, *_asked(overhang(), block("wall", Pose((0.5, 0.23, 0.03)), (0.3, 0.02, 0.06), 1.0))))
    assert ("wall",) in (no.value.blocking or ()) and "not let in:" in no.value.reason
