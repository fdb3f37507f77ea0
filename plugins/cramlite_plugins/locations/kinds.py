"""Kinds of locations: relation, reference object, parameters and the function that grounds it.

One table for the search, for ``cramlite.testing`` and for the page docs/reference/locations.md. The
functions' modules are imported when a relation is first asked for.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping

from cramlite.model import Belief, Location, Stand, Value
from cramlite.plugin import Answer, Context, LocationKind, hookimpl

from .parameters import (
    Along,
    Back,
    Begun,
    Followed,
    Front,
    Handle,
    InnerSide,
    JointWay,
    PushedThing,
    Sight,
    Tilting,
    Turned,
    Up,
    Where,
)


class Lazy(Value):
    """Function of a sibling module, which is imported when the function is first called."""

    module: str
    function: str

    def __call__(self, location: Location, belief: Belief, context: Context) -> Iterable[Answer]:
        """Import the function that grounds locations of this kind, and call it."""
        function = getattr(importlib.import_module(f".{self.module}", __package__), self.function)
        found: Iterable[Answer] = function(location, belief, context)
        return found


THING, JOINTED, FLAT = "a thing", "a drawer or a door with a handle", "a flat thing"

KINDS: Mapping[str, LocationKind] = {
    kind.name: kind
    for kind in (
        LocationKind("home", "The robot's home position.", Lazy("places", "home")),
        LocationKind(
            "retreat",
            "Back along the tool, or up, from where the hand is.",
            Lazy("places", "retreat"),
            parameters=Back,
        ),
        LocationKind(
            "lift",
            "Straight up from where the hand is; last, aside as well; a payload that swings in the hand "
            "hangs there.",
            Lazy("places", "lift"),
            parameters=Up,
        ),
        LocationKind(
            "slide", "A straight path from where the hand is.", Lazy("places", "slide"), "a surface", Along
        ),
        LocationKind(
            "grasp",
            "The open hand around the thing; last, across a slanted rim, with the swing of the thing as it "
            "is lifted.",
            Lazy("grasps", "grasps"),
            THING,
        ),
        LocationKind(
            "in",
            "The payload in the opening, or above it; ``via`` leads in a payload that leans or comes "
            "through an open side.",
            Lazy("placing.driver", "placements"),
            "a thing with a cavity",
            Where,
        ),
        LocationKind(
            "toppled",
            "The payload's foot in the opening, where the payload topples; ``path`` leads the hand back "
            "from under it.",
            Lazy("placing.driver", "placements"),
            "a thing with a cavity",
            Where,
        ),
        LocationKind(
            "before",
            "The payload before an opening under a roof, from where fingers push it in; ``path`` leads the "
            "hand back.",
            Lazy("placing.driver", "placements"),
            "a thing with a cavity",
            Where,
        ),
        LocationKind(
            "on",
            "The payload over or on the thing, under a roof through an open side; a hanging plate is laid "
            "down on a path about its far side.",
            Lazy("placing.driver", "onto"),
            "a thing with a surface",
            Where,
        ),
        LocationKind(
            "pushed_in",
            "Fingers 100 mm behind the thing; the path ends where the thing is at its believed place.",
            Lazy("pushing.back_in", "pushed_in"),
            "a thing that tipped over",
            Begun,
        ),
        LocationKind(
            "off",
            "Level back, until closed fingers are in front of the thing.",
            Lazy("pushing.farther_in", "off"),
            "a thing under a roof",
        ),
        LocationKind(
            "deeper",
            "Straight inwards, until the thing is out of the way of a later closing task.",
            Lazy("pushing.farther_in", "deeper"),
            "a thing under a roof",
        ),
        LocationKind("extract", "A path along the peg, over its tip.", Lazy("pegs", "extract"), "a peg"),
        LocationKind(
            "insert",
            "Before the tip; the path leads to the tip, past its bend, along the peg, and down.",
            Lazy("pegs", "insert"),
            "a peg",
        ),
        LocationKind(
            "push", "Closed fingers beside one of the faces.", Lazy("pushing.straight", "beside"), THING
        ),
        LocationKind(
            "pushed",
            "Straight on from where the fingers are.",
            Lazy("pushing.straight", "beyond"),
            THING,
            Along,
        ),
        LocationKind(
            "behind",
            "Fingers behind the thing, or in it.",
            Lazy("pushing.straight", "behind"),
            FLAT,
            PushedThing,
        ),
        LocationKind(
            "pushed_to",
            "A path on which the thing comes to its region, or aside.",
            Lazy("pushing.straight", "pushed_to"),
            FLAT,
            PushedThing,
        ),
        LocationKind(
            "near",
            "At rest beside or above the thing, clear of all others.",
            Lazy("near", "near_thing"),
            THING,
        ),
        LocationKind(
            "touch",
            "The fingers' tips above the middle of the surface.",
            Lazy("touch", "touch"),
            "a thing with a surface",
        ),
        LocationKind(
            "handle",
            "The hand around the handle, straight or tilted about the bar, as wide open as obstacles allow.",
            Lazy("jointed.handles", "handle_grasps"),
            JOINTED,
            Handle,
        ),
        LocationKind(
            "opened",
            "A path along the joint, held or pushed, open.",
            Lazy("jointed.handles", "joint_way"),
            JOINTED,
            JointWay,
        ),
        LocationKind(
            "turned",
            "A path about the joint, held, by a turn.",
            Lazy("jointed.handles", "turn_on"),
            JOINTED,
            Turned,
        ),
        LocationKind(
            "closed",
            "A path along the joint, held or pushed, all but shut.",
            Lazy("jointed.handles", "joint_way"),
            JOINTED,
            JointWay,
        ),
        LocationKind(
            "stop",
            "A path along the joint, on to its stop.",
            Lazy("jointed.handles", "joint_way"),
            JOINTED,
            JointWay,
        ),
        LocationKind(
            "front",
            "Closed fingers in front of a drawer or door, or over its upper edge, where the arm can follow "
            "until it is shut.",
            Lazy("pushing.along_joint", "before_front"),
            JOINTED,
            Front,
        ),
        LocationKind(
            "inner_side",
            "Closed fingers behind the door, over its upper edge, where the arm can follow until it is "
            "open enough.",
            Lazy("pushing.along_joint", "behind_door"),
            "a door that stands ajar",
            InnerSide,
        ),
        LocationKind(
            "atop",
            "Closed fingers over the bar of the handle, pointing down.",
            Lazy("pushing.along_joint", "atop_handle"),
            "a drawer with a handle",
            Handle,
        ),
        LocationKind(
            "pour",
            "The payload's lip over the vessel; the path tilts the payload.",
            Lazy("pour", "pour"),
            "a vessel",
            Tilting,
        ),
        LocationKind(
            "shown_path",
            "The payload's foot on a path that was shown; ``path`` leads along it, of a closed one a round.",
            Lazy("shown_paths", "followed"),
            THING,
            Followed,
        ),
        LocationKind(
            "stand",
            "The robot itself near the thing, so that the arm reaches it.",
            Lazy("stands", "stands"),
            THING,
            gives=Stand,
        ),
        LocationKind(
            "view", "The camera on the flange sees the thing.", Lazy("viewpoints", "views"), THING, Sight
        ),
    )
}


def ground(location: Location, belief: Belief, context: Context) -> Iterable[Answer]:
    """Ground a location whose relation, such as "near", this package defines."""
    return KINDS[location.relation].ground(location, belief, context)


@hookimpl
def location_kinds() -> Iterable[LocationKind]:
    """Return the kinds of locations of this package, one for each relation."""
    return KINDS.values()
