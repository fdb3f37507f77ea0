"""Phrases of goals, "THING on PLACE": the words, and the facts that they ask for."""

from __future__ import annotations

import math
from functools import partial

from msgspec.structs import replace

from cramlite.model import EntityName, Thing, thing_of
from cramlite.plugin import (
    EFFECTOR,
    Bound,
    GoalCondition,
    GoalPhrase,
    Manner,
    Pattern,
    SymbolicWorld,
    UserError,
    contents,
    nearest,
)

from .extents import CAVITY, PEG, REGIONS, in_extent

OPEN = 0.2
"""Share of a joint's range from which a thing is open: the rule of opening asks for as much."""
EXACT = 0.05
"""Largest deviation of a joint from the opening that a goal states, as a share of the joint's range: 10 mm of a drawer's 200."""
CONTROL = "cram:Control"
"""Class of things that can be turned on and off."""
SHIFTS = 0.005
"""Margin inside the allowed distance of things put beside one another [m]: a released thing shifts by a few
millimetres."""
STANDS = ("is", "hangs", "stands", "lies")


def let_go(thing: str) -> frozenset[Pattern]:
    """Return the facts that must not hold of a released thing: a grasp of it, and contact with the hand."""
    return frozenset({("grasps", None, thing), ("touches", EFFECTOR, thing)})


def _held(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(needs=frozenset({("grasps", EFFECTOR, thing)}))


def _on(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """Goal of a thing on a place: hanging if the place has a peg, else supported by it.

    If the place is a region, the goal is the same as for "in".
    """
    if place != thing_of(place):
        return _at_region(scene, thing, place)
    peg = scene.world.thing(place).feature(PEG)
    there = ("touches", thing, str(EntityName(place, peg.name))) if peg else ("supports", place, thing)
    return GoalCondition(frozenset({there}), let_go(thing), spot=peg is None)


def _amid(scene: SymbolicWorld, thing: str, place: str, amount: str) -> GoalCondition:
    """Goal of a thing on another one, their origins at most a distance apart, seen from above."""
    if place != thing_of(place):
        raise UserError(f"'on ... within' needs a whole thing, not a part: '{thing_of(place)}'.")
    most = _quantity(amount, "length")
    apart = math.dist(*(scene.world.thing(name).pose.position[:2] for name in (thing, place)))
    near = {"near": place, "within": f"{max(most - SHIFTS, most / 2):.4f} m"}
    bound = Bound(("distance_seen_from_above", thing, place), 0.0, most)
    return replace(_on(scene, thing, place), bounds=(bound,), manner=Manner(near, holds=apart <= most))


def _quantity(amount: str, kind: str) -> float:
    from cramlite.plugin import parse_quantity  # it loads pydantic

    try:
        return parse_quantity(amount, kind)
    except ValueError as error:
        raise UserError(f"{error}.") from error


def _off(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """Goal that a thing is no longer on a place; it may still be in the hand."""
    if place != thing_of(place):
        raise UserError(f"'off' needs a whole thing, not a part: '{thing_of(place)}'.")
    return GoalCondition(without=frozenset(_on(scene, thing, place).needs))


def _in(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """Goal of a thing in a place; for planning it is enough that the thing is above the place.

    If the place has a cavity, a run must show that the thing is inside.
    """
    if place != thing_of(place):
        return replace(_at_region(scene, thing, place), instead=_upon_content(scene, thing, place))
    on_peg = scene.world.thing(place).feature(PEG) is not None
    hollow = scene.world.thing(place).feature(CAVITY) is not None
    shown = frozenset({("in_cavity", thing, place)} if hollow else ())
    above, upon = frozenset({("in_or_above", thing, place)}), _upon_content(scene, thing, place) if hollow else ()
    return GoalCondition(above, let_go(thing), spot=not on_peg, shown=shown, instead=upon)


def _upon_content(scene: SymbolicWorld, thing: str, place: str) -> tuple[tuple[str, ...], ...]:
    """Goals that bring a thing into a place by putting it upon another thing in that place."""
    others = (t.name for t in scene.world.things if _loose(t) and t.name != thing)
    return tuple((f"{other} in {place}", f"{thing} on {other} in {place}") for other in others)


def _on_in(scene: SymbolicWorld, thing: str, below: str, place: str) -> GoalCondition:
    """Goal of a thing upon another thing in a place; a run must show that the upper thing is in the place, too."""
    there = "in_cavity" if place == thing_of(place) else "in_region"
    return GoalCondition(
        frozenset({("supports", below, thing)}), let_go(thing), spot=True, shown=frozenset({(there, thing, place)})
    )


def _at_region(scene: SymbolicWorld, thing: str, place: str) -> GoalCondition:
    """Goal of a thing in a named region of another thing: in a cavity, or on an area of a surface.

    A run must show that it is in that region, and not in another one.
    """
    whole, region = thing_of(place), EntityName.parse(place).part
    features = {f.name: f for f in scene.world.thing(whole).features if f.type in REGIONS}
    if region not in features:
        raise UserError(f"'{place}' is no surface and no cavity that things could be put on or in; {nearest(region, features)}.")
    feature = features[region]
    point = (scene.world.thing(whole).pose * feature.pose).inverse().apply(scene.world.thing(thing).pose.position)
    there = ("in_or_above", thing, whole) if feature.type == CAVITY else ("supports", whole, thing)
    return GoalCondition(
        frozenset({there}), let_go(thing), spot=True, shown=frozenset({("in_region", thing, place)}),
        manner=Manner({"region": region}, holds=in_extent(feature.type, feature.size, point)),
    )  # fmt: skip


def _poured_into(scene: SymbolicWorld, source: str, destination: str) -> GoalCondition:
    """Goal of pouring: its facts include that the source vessel is lifted, though the rule does not ask
    for that."""
    if source not in {t.name for t in scene.filled()}:
        raise UserError(f"'{source}' holds nothing that could be poured.")
    return GoalCondition(frozenset({("contains", destination, contents(source))}), frozenset({("supports", None, source)}))


def _is_open(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(frozenset({("joint_open", thing)}), frozenset({("touches", EFFECTOR, thing)}))


def _is_closed(_scene: SymbolicWorld, thing: str) -> GoalCondition:
    return GoalCondition(frozenset({("joint_closed", thing)}), frozenset({("touches", EFFECTOR, thing)}))


def _opened_by(scene: SymbolicWorld, thing: str, amount: str) -> GoalCondition:
    """Goal that a drawer or door is open by an amount; refused if the amount is too small to count as open,
    or beyond the range."""
    joint = scene.world.thing(thing).joint
    if joint is None:
        raise UserError(f"'{thing}' has no joint to be opened by.")
    value = _quantity(amount, "length" if joint.kind == "slide" else "angle")
    span = joint.upper - joint.lower
    share, (least, most) = value / span, (_amount(joint.kind, s * span) for s in (OPEN, 1.0))
    if not OPEN <= share <= 1.0:
        raise UserError(f"'{thing}' opens by {most} at most, and counts as open from {least} on; state an amount between these.")
    bound = Bound(("joint_share", thing), share - EXACT, share + EXACT)
    now = (joint.value - joint.lower) / span
    return replace(_is_open(scene, thing), bounds=(bound,), manner=Manner(parameters={"share": share}, holds=abs(now - share) <= EXACT))


def _amount(kind: str, value: float) -> str:
    return f"{1000 * value:.0f} mm" if kind == "slide" else f"{math.degrees(value):.0f} deg"


def _turned(scene: SymbolicWorld, thing: str, on: bool) -> GoalCondition:
    if not scene.is_a(thing, CONTROL):
        raise UserError(f"'{thing}' is no knob and no switch ({CONTROL}) that could be turned on or off.")
    return (_is_open if on else _is_closed)(scene, thing)


def _loose(thing: Thing) -> bool:
    """Whether a thing can be carried."""
    return not thing.furniture


def _jointed(thing: Thing) -> bool:
    return thing.joint is not None


def _is_hollow(scene: SymbolicWorld, _thing: str, place: str) -> bool:
    """Whether things go into a place rather than onto it, by the depth of the place's cavity; for goals that say neither "in" nor "on"."""
    part = EntityName.parse(place).part
    deep = [f for f in scene.world.thing(thing_of(place)).features if f.type == CAVITY and part in ("", None, f.name)]
    return any(f.size.get("height", 0.0) > DEEP for f in deep)


def _is_level(scene: SymbolicWorld, thing: str, place: str) -> bool:
    return not _is_hollow(scene, thing, place)


DEEP = 0.05
"""Height of a cavity from which people speak of a container, not of a plate [m]."""
PUT = (
    "put|place|set|lay|move|bring|carry|get|drop|deposit|position|transfer|take|relocate|pick|pick_up|grab|transport|deliver|rest|stand|leave|"
    "set_down|put_down|lay_down|place_down|put_back|return|shift|slide|push|drag|pull|stick|arrange|pop|pass|give|send|lift|fetch|have|convey|assign|"
    "haul|lug|tote|cart|ship|ferry|hoist|heave|guide|direct|nudge|scoot|collect|gather|serve|replace|reposition|restore|hand|drive|steer|bring_back|"
    "take_back|move_back|bring_over|take_over|move_over|carry_over|bring_down|set_back|want|locate|dispose|displace|shuttle"
)
"""Verbs of putting, sending and carrying (Levin, English Verb Classes and Alternations, 1993: 9.1 to 9.4, 11): a thing is brought
somewhere, whatever the place is."""
BRING = (
    f"{PUT}|insert|throw|toss|store|stow|pack|tuck|slip|drop_off|dump|slot|file|load|shove|stash|stack|pile|balance|rack|hang|"
    "hang_up|mount|seat|perch|serve|sit|house|plop|plunk|park|plant|squeeze|lower|tidy|put_away|put_up|stack_up|pile_up|chuck|fling|sling|lob|"
    "hurl|pitch|nest|cast|bung|sweep|scoop|cram|jam|wedge|stuff|ram|dunk|dip|nestle|install|lodge|situate|settle|bin|box|shelve|fit|plonk|ditch|"
    "hide|secure|keep|home|land|roll|drop_down|pop_down|lay_out|set_out|sort|line_up|group|combine|build|assemble|clear|add|tidy_away|"
    "clear_away|rest_up|prop|lean|station|set_up|transplant|dispose_of|discard|toss_away|throw_away|"
    "gather_up|collect_up|round_up|unstack|scoop_up|lift_up|take_up|move_up|bring_up|carry_up"
)
"""Verbs of putting, sending and carrying (``PUT``), of throwing and of loading (9.7, 17.1): a preposition says whether the thing goes on or
in the place."""
TAKE = (
    "take|remove|free|lift|get|pick|pick_up|grab|move|clear|fetch|unhook|pull|unstack|bring|extract|withdraw|retrieve|pluck|snatch|draw|dig|tip|"
    "slide|push|shift|knock|haul|hoist|keep|have|want|unload|detach|separate|recover|evict|eject|expel|whisk|put|carry|scoop|collect|take_down"
)
"""Verbs of removing (10.1)."""
HOLD = (
    "pick_up|pick|grab|grasp|take|lift|lift_up|hold|get|fetch|grip|seize|get_hold_of|take_hold_of|collect|raise|hold_on_to|take_up|"
    "bring_me|hand_me|give_me|pass_me|hand_over|catch_hold_of|lay_hold_of|grab_hold_of|clutch|clasp|snatch|hang_on_to|keep_hold_of|retrieve|"
    "take_out|get_out|bring_out|lift_out|fish_out|pull_out|draw_out|take_down|get_down|bring_down|lift_down|lift_off|unhook|bring_us|get_me|fetch_me|hoist|hoist_up|pick_me_up|scoop_up|gather|gather_up|round_up|snatch_up|carry|hold_up|grab_onto|hold_onto|hold_fast|clench|pinch|pluck|recover"
)
"""Verbs of holding (15.1), and of giving to people."""
UPON = "on|onto|on_top_of|upon|over|on_to|across|up_on|down_on|back_on"
INTO = "in|into|inside|within|in_to|inside_of|down_into|back_in|back_into|in_the_inside_of"
CLEAR = "clear|clear_off|clear_out|empty|empty_out|unload|vacate|free|free_up"
"""Verbs of removing all that is on or in a place, which is their object."""
OFF = "off|off_of|out_of|from|away_from|down_from"
OPEN_WAY = f"{PUT} THING to|towards|at|over_to PLACE"
"""Phrases of putting that leave open whether the thing goes on or in the place."""
LOAD = "fill|fill_up|load|load_up|stock|pack|top PLACE with THING"
"""Verbs of loading, whose object is the place."""
OPEN_UP = (
    "open|open_up|pull_open|slide_open|unclose|unlatch|reopen|yank_open|draw_open|throw_open|crack_open|swing_open|pull_out|"
    "slide_out|uncover|draw_out|undo|unfasten|extend THING"
)
START = (
    "turn_on|switch_on|start|start_up|activate|power_on|ignite|light|light_up|fire_up|enable|flip_on|power_up|heat_up|heat|energise|"
    "energize THING"
)
CLOSE = (
    "close|close_up|shut|push_shut|push_closed|push_in|slide_shut|slide_closed|slide_in|swing_shut|close_off|push_to|seal|"
    "push_back_in|retract THING"
)
STOP = (
    "turn_off|switch_off|stop|deactivate|power_off|shut_off|shut_down|disable|extinguish|turn_out|flip_off|power_down|kill|cut_off|"
    "de_energise|de_energize THING"
)
TURN = "turn|switch|set|flip|make|get"
AWAY = "down|up|out|down_from_there|from_there|out_of_there|out_from_under_there|away"
IN_HAND = (
    "in_my_hand|in_our_hands|in_my_hands|in_your_hand|in_the_hand|in_hand|in_your_gripper|in_the_gripper|between_your_fingers|in_the_air"
)
HELD = (
    GoalPhrase(
        "THING held", _held, asked=(
            f"{HOLD} THING", f"take|get|lift|bring|fetch|pull|pick|carry THING {AWAY}",
            f"take|get|lift|hold|keep|have|put|grab THING {IN_HAND}",
            "bring|give|hand|pass|get|carry|take|fetch THING to_me|to_us|over_to_me|over_to_us|over_here|here",
        ), about=_loose,
    ),
)  # fmt: skip
ON_OR_OFF = (
    GoalPhrase(
        "THING on PLACE", _on, STANDS, (
            f"{BRING}|thread|hook|assign THING {UPON} PLACE", "hang|suspend|dangle THING from PLACE", OPEN_WAY, LOAD,
            "cover|top|cap PLACE with THING",
        ), _loose, _is_level,
    ),
    GoalPhrase("THING on PLACE within AMOUNT", _amid, STANDS),
    GoalPhrase("THING on THING in PLACE", _on_in, STANDS),
    GoalPhrase("THING off PLACE", _off, STANDS, (f"{TAKE} THING {OFF} PLACE", f"{CLEAR} PLACE"), _loose),
)  # fmt: skip
CONTENTS = "the_contents_of|contents_of|what_is_in|what_is_inside|whatever_is_in|everything_in|all_that_is_in|everything_from"
POURED = (
    GoalPhrase("VESSEL poured into VESSEL", _poured_into, asked=(
        "pour|pour_out|empty|tip|decant|drain|tip_out VESSEL into|in|out_into|to|over_into|across_into VESSEL",
        f"pour|empty|tip|transfer|decant|drain|get|move|put {CONTENTS} VESSEL into|in|to|over_into|out_into VESSEL",
    ), about=_loose),
)
IN_PLACE = (GoalPhrase("THING in PLACE", _in, STANDS, (f"{BRING} THING {INTO} PLACE", OPEN_WAY, LOAD), _loose, _is_hollow),)
OPENED = (
    GoalPhrase(
        "THING open", _is_open, ("is", "stands"),
        (
            OPEN_UP, "pull|slide|draw THING out", "open|swing|throw|push|pull THING wide",
            "pull|slide|swing|push|draw|make|leave|get|throw|yank|keep|set|turn THING open|wide_open|opened",
        ), _jointed,
    ),
    GoalPhrase(
        "THING open by AMOUNT", _opened_by, ("is", "stands"),
        (
            "open|open_up|pull_open|slide_open|pull_out|draw_out|extend|crack|crack_open|pull|bring|slide|draw|drive|actuate|displace|"
            "advance|set|move THING by AMOUNT",
        ), _jointed,
    ),
    GoalPhrase(
        "THING turned on", partial(_turned, on=True),
        asked=(
            START, "get|set THING going|running", f"{TURN} THING on|to_on|to_the_on_position|to_the_on_state|in_its_on_position",
        ), about=_jointed
    ),
)  # fmt: skip
SHUT = (
    GoalPhrase(
        "THING closed", _is_closed, ("is", "stands"),
        (
            CLOSE, "push|slide|swing|pull|make|leave|get|keep|slam|bring|move|drive THING shut|closed|in|back_in|to|home|"
            "to_its_closed_position|to_the_closed_position|to_its_closed_stop|to_its_closed_end_stop|in_its_closed_position",
        ), _jointed,
    ),
    GoalPhrase(
        "THING turned off", partial(_turned, on=False),
        asked=(STOP, f"{TURN} THING off|to_off|to_the_off_position|to_the_off_state|in_its_off_position"), about=_jointed
    ),
)  # fmt: skip
