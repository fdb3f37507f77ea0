"""A thing that was let go and is grasped again: its grasp is asked for anew, where it stands then."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import Held, Location, Motion, Place, Pose, World, initial_belief
from cramlite.planning.search.state import State, renew_places, renewed

GRASP = Location("grasp(box)", "grasp", "box")
SPOT = Place(Pose(), Pose(), thing="box")
EMPTY = initial_belief(World(()), "arm", (0.0,), 0.08)
HOLDING = replace(EMPTY, held=Held("box", Pose(), 0.05))


def test_places_are_renewed_when_the_grip_has_changed_and_only_then() -> None:
    state = State((), EMPTY, {"grasp(box)": SPOT, "box": "coffee"})
    assert renew_places(state) is state and renewed(GRASP, state) is GRASP  # nothing was taken: the hand may still go there
    held = renew_places(replace(state, belief=HOLDING))
    assert renewed(GRASP, held) == replace(GRASP, name="grasp(box)#2")
    assert renewed(Motion("m", "transfer", GRASP), held) == Motion("m", "transfer", replace(GRASP, name="grasp(box)#2"))
    assert renewed(Location("in(basket)", "in", "basket"), held).name == "in(basket)"  # nobody asked for it before
    free = renew_places(replace(held, belief=EMPTY))
    assert renewed(GRASP, free).name == "grasp(box)#2"
    again = renew_places(replace(free, bindings={**free.bindings, "grasp(box)#2": SPOT}, belief=HOLDING))
    assert renewed(GRASP, again).name == "grasp(box)#3"
