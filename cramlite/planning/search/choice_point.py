"""Choice points of the search: a designator that is being resolved, its conflict set, and no-goods.

Every designator is a choice point, identified by its name. Its failure depends on other choices, its conflict set,
which grows while its alternatives are looked at.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from itertools import takewhile
from typing import Any

from msgspec import Struct, field

from ...model.belief import Belief
from ...model.collision import Collision
from ...model.control_flow import Compound
from ...model.designator_name import is_part_of
from ...model.designators import Action, Designator, Late, Location, Motion, Object, Place
from ...model.entity_name import thing_of
from ...model.remedy import Remedy
from ...plugin.grounding import Grounding, Refused
from ..refutation import ANY, AsItIs, Capped, InTask, Later, Unfit
from ..trace import Kind, Outcome, Trace
from .state import Effect, State, ground_roles

Conflict = frozenset[str | InTask | AsItIs | Capped | Later | Unfit]
"""Conflict set: everything on which a failure of the search depends. It has the names of choices, to which the search goes back, at once or
later; tasks, and unchanged things, which no choice of this plan affects; alternatives that were left out; and things that can play no
role."""


class Nogoods(Struct):
    """Combinations of choices that are known to fail (no-goods).

    Args:
        known: combinations by each of their choices.
        beside: combination -> what its failure depends on beside the choices.
    """

    known: dict[Choice, list[frozenset[Choice]]] = field(default_factory=dict)
    beside: dict[frozenset[Choice], Conflict] = field(default_factory=dict)

    def made_again(self, choices: tuple[Choice, ...]) -> Conflict | None:
        """Return the conflict set of a known no-good that the last choice completes; None if there is
        none."""
        made = set(choices)
        found = next((nogood for nogood in self.known.get(choices[-1], ()) if nogood <= made), None)
        return frozenset(name for name, _ in found) | self.beside[found] if found is not None else None

    def remember(self, conflict: Conflict, choices: tuple[Choice, ...]) -> None:
        """Record that the choices in a conflict set do not go together."""
        nogood = frozenset(c for c in choices if c[0] in conflict)
        beside = frozenset(c for c in conflict if not isinstance(c, str))
        if Capped() in self.beside.setdefault(nogood, beside) and Capped() not in beside:
            self.beside[nogood] = beside
        for choice in nogood:
            self.known.setdefault(choice, []).append(nogood)

    def lasting(self) -> Nogoods:
        """Return the no-goods that stay true when more alternatives are tried: those found with no alternative left out."""
        beside = {nogood: c for nogood, c in self.beside.items() if Capped() not in c}
        known = {choice: [n for n in found if n in beside] for choice, found in self.known.items()}
        return Nogoods(known, beside)


Choice = tuple[str, str]
"""Choice of the search: the name of a designator, and the key of the alternative that was taken."""
CAPS: dict[type, int] = {Action: 6, Object: 8, Late: 8, Location: 12, Motion: 4}
"""Number of alternatives of a designator that are tried in the first round."""
KINDS: dict[type, Kind] = {
    Action: "action", Compound: "compound", Object: "object", Late: "object", Location: "location", Motion: "motion",
}  # fmt: skip
"""Kind of trace entry for each class of designators."""


class ChoicePoint(Struct):
    """Choice point of the search: a designator whose alternatives are tried in a state.

    Args:
        item: the designator.
        state: in which it is asked, without it on the agenda.
        trace: where what is found out goes, below ``node``.
        node: the trace's entry of the question.
        breadth: how many times as many alternatives are tried as in the first round.
        conflict: what its failure depends on, so far.
    """

    item: Designator
    state: State
    trace: Trace
    node: int
    breadth: int = 1
    conflict: set[str | InTask | AsItIs | Capped | Later | Unfit] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.conflict |= {f.compound.name for f in self.state.frames}  # without them it would not be asked for
        if self.state.stand:  # what the arm can do depends on where the robot stands
            self.conflict.add(self.state.stand)

    @classmethod
    def asked(
        cls, item: Designator, state: State, trace: Trace, parent: int, numbers: Mapping[str, int], breadth: int = 1
    ) -> ChoicePoint:
        """Make the choice point of a designator, and record it in the trace below the entry ``parent``."""
        what = item.wanted if isinstance(item, Object) else str(item)
        node = trace.add(parent, item.name, what, "asked", "engine", "", kind=KINDS[type(item)], numbers=numbers)
        return cls(item, state, trace, node, breadth)

    @property
    def cap(self) -> int:
        """Largest number of alternatives of the designator that are tried; of a control structure, the number
        of its branches."""
        return len(self.item.branches) if isinstance(self.item, Compound) else self.breadth * CAPS[type(self.item)]

    @property
    def domain(self) -> set[str]:
        """Names of the earlier choices on which this choice's alternatives depend.

        A place does not depend on motions, nor on places that the arm has passed and left.
        """
        item, made = self.item, {name for name, _ in self.state.choices}
        if isinstance(item, Object | Late):
            part_of = item.part_of if isinstance(item, Object) else None
            return made & ({part_of} if part_of else set())
        if isinstance(item, Action):
            return made & {o.name for o in item.roles.values()}
        if isinstance(item, Location):
            return made - self.state.motions - self.state.passed
        return made - (self.state.passed - {item.to.name if isinstance(item, Motion) and item.to else ""})

    def blamed(self, answer: Grounding | Refused) -> set[str]:
        """Return the names of the earlier choices (a part of ``domain``) on which a plugin's answer depends."""
        if isinstance(answer, Refused) and answer.blocking is not None:
            return self.about(answer.blocking) | self.asked_by
        if isinstance(answer, Grounding) and answer.anew:
            place = self.item.to.name if isinstance(self.item, Motion) and self.item.to else ""
            return self.domain - self.state.led - (self.state.reached - {place})
        return self.domain

    def about(self, things: Collection[str | Collection[str]]) -> set[str]:
        """Return the names of the earlier choices that determined where the given things are.

        The designator's own thing and the payload are added to the given things.
        """
        own = self.state.bindings.get(getattr(self.item, "of", None) or "", "")
        held = self.state.belief.held
        named = (t for one in things for t in ([one] if isinstance(one, str) else one))
        meant = {*named, thing_of(str(own)), *([held.thing] if held else [])}
        if not own or any(_was_moved(name, self.state.belief) for name in meant):  # it may be by a door or a drawer; so may the hand
            meant |= {t.name for t in self.state.belief.world.things if t.joint is not None}
        opened = (i.action for i in self.state.agenda if isinstance(i, Effect))
        known = {a.name: a for a in (*self.state.actions, *self.state.parts, *opened)}
        settled = self.domain - self.state.passed - self.state.reached  # where the arm is led settles nothing of things
        return {n for n in settled - self._held_before if _is_about(n, meant, self.state.bindings, known)}

    @property
    def _held_before(self) -> set[str]:
        """Names of earlier places at which the hand held a thing on a joint, such as a drawer, before the
        thing was moved along the joint.

        They explain no failure any more: only the present value of the joint matters.
        """
        now, earlier = {i.action.name for i in self.state.agenda if isinstance(i, Effect)}, dict[str, Place]()
        for name in takewhile(lambda n: n not in now, (n for n, _ in self.state.choices)):
            if isinstance(place := self.state.bindings.get(name), Place) and isinstance(self.item, Location):
                earlier[name] = place
        joints = {t.name for t in self.state.belief.world.things if t.joint is not None}
        moved = {p.thing for p in earlier.values() if p.path} & joints
        return {name for name, p in earlier.items() if p.thing in moved and not p.path}

    @property
    def asked_by(self) -> set[str]:
        """Names of the choices that brought the designator into the search; after another choice the search may not need the designator."""
        return {name for name, _ in self.state.choices if is_part_of(self.item.name, name)}

    @property
    def unfit(self) -> set[Unfit]:
        """Return a set with the thing named by a refused designator, if no earlier choice or state caused the refusal.

        Else the set is empty.
        """
        named = self.item.entity if isinstance(self.item, Object) else None
        depends = any(isinstance(c, str) or (isinstance(c, AsItIs) and ANY in c.things) for c in self.conflict)
        return {Unfit(named)} if named and not depends else set()

    def say(
        self, outcome: Outcome, plugin: str, reason: str, text: str | None = None, cost: float | None = None, passed: int = 0,
        numbers: Mapping[str, float] | None = None, collision: Collision | None = None, remedy: Remedy | None = None,
    ) -> int:  # fmt: skip
        """Record in the trace the outcome for the designator, or for one alternative of it, which ``text``
        describes."""
        text = str(self.item) if text is None else text
        kind = KINDS[type(self.item)]
        return self.trace.add(
            self.node, self.item.name, text, outcome, plugin, reason, cost, passed,
            kind=kind, numbers=numbers, collision=collision, remedy=remedy,
        )  # fmt: skip

    def exhausted(self, tried: int) -> None:
        """Record in the trace that none of the alternatives led to a solution."""
        causes = ", ".join(sorted(c for c in self.conflict if isinstance(c, str))) or "nothing before it"
        what = "1 alternative" if tried == 1 else f"{tried} alternatives"
        self.say("failed", "engine", f"{what} failed; it depends on {causes}", numbers={"tried": tried})


def _was_moved(thing: str, belief: Belief) -> bool:
    """Check whether a thing is believed to be elsewhere than in the world at the start."""
    first = next((t.pose for t in belief.world.things if t.name == thing), None)
    return first is not None and (thing not in belief.poses or belief.poses[thing].pose != first)


def _is_about(name: str, things: Collection[str], bindings: Mapping[str, Any], actions: Mapping[str, Action]) -> bool:
    """Check whether a choice is about one of the given things; True if that is unknown."""
    value = bindings.get(name)
    if isinstance(value, Place):
        return value.thing in things
    if isinstance(value, str):
        return thing_of(value) in things
    if name in actions:
        roles = ground_roles(actions[name], bindings).roles.values()
        return any(thing_of(r.entity or "") in things for r in roles)
    return True


def key_of(value: Any) -> str:
    """Make a key for an alternative that states none: its text, hashed if it is long."""
    text = str(value)
    return text if len(text) <= 60 else hashlib.blake2b(text.encode(), digest_size=6).hexdigest()
