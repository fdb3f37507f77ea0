"""Contacts of a run: one that no task permits, or that is too hard, becomes an objection with its force."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from cramlite.model import GRAVITY, Remedy, Rollout, Touch, Value, thing_of
from cramlite.plugin import HAND, HELD, Allowance, Candidate, Cost, Finding, checkpoint

from ..motions.motion_kinds import LIMIT
from ..shapes.joints import mounts
from .explained import explained_at
from .grips import pressed_at
from .movers import moved_by
from .task_times import inner_tasks

GAP = 0.2  # a contact that is lost for less still goes on [s]: what slides or rattles leaps (as long as rules' PADDING)
GRIP = 0.1  # one pad presses a thing that they close on for so long before both do [s]

Pair = frozenset[str]


class Bump(NamedTuple):
    """Touch that no task permits, or that is harder than its task permits; ordered by hardness."""

    excess: float
    force: float
    limit: float
    sample: int
    one: str
    other: str
    why: str


class Collision(Value):
    """Validator of contacts: each must be permitted by the running task, and no harder than that task permits.

    A task that released a thing permits its contacts while the thing still falls. Force is judged by what the
    arm feels; of two things pressed together without a grip, by the task's limit plus their weight. The shock
    of a dropped thing is not judged, since a rigid model says little of it.
    """

    name: str = "collision"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        brush = candidate.limits.brush
        whose = f"limit {brush:g} N {candidate.limits.source('brush')}"
        worst = max(bumps(candidate), default=None)
        if worst is None:
            reason = f"each contact is permitted by a task and stays below the force that it permits (for other contacts, {whose})"
            yield Finding(self.name, True, reason, 0.0, brush, "N")
            return
        task = inner_tasks(candidate)[worst.sample]
        when = f"at {candidate.ran.times[worst.sample]:.1f} s" + (f" in {task}" if task else "")
        said = worst.why or whose
        reason = f"'{worst.one}' hit '{worst.other}' with {worst.force:.0f} N {when}; {said}"
        there = {t.name for t in candidate.world.things}
        hit = tuple(n for n in map(thing_of, (worst.one, worst.other)) if n in there)
        remedy = more_room(worst)
        yield Finding(self.name, False, reason, worst.force, worst.limit, "N", task, blocking=hit, remedy=remedy)


def more_room(worst: Bump) -> Remedy:
    """Return the advice for a contact that is too hard: more room between the two bodies; or a higher limit,
    if other tasks may press as hard by default."""
    meet = f"'{worst.one}' and '{worst.other}' meet with {worst.force:.1f} N where {worst.limit:.0f} N are permitted"
    harmless = f", or, if that contact does no harm, permit it by 'limits: {{brush: {math.ceil(worst.force)} N}}' in the scenario"
    raised = harmless if not worst.why and worst.force <= LIMIT.default else ""
    pair = " ".join(sorted((worst.one, worst.other)))
    return Remedy(f"touch {pair}", f"{meet}: make more room between them, or name another place{raised}", worst.excess)


def bumps(candidate: Candidate) -> Iterator[Bump]:
    """Yield the contacts, at each sample, whose force is above the permitted one, or above ``limits.brush``
    where no task permits a contact."""
    rollout, brush = candidate.ran, candidate.limits.brush
    contacts = _Contacts(candidate, rollout)
    for k, touches in _to_judge(rollout, contacts):
        checkpoint()
        for pair, (force, touch) in _by_pair(touches).items():
            limit = contacts.limit(k, pair)
            if limit is not None:
                contacts.note(k, pair)
            if force > (brush if limit is None else limit):
                why = "" if limit is None else f"limit {limit:.0f} N, the task's force plus the weights of both things"
                yield Bump(force - (limit or brush), force, limit or brush, k, touch.a, touch.b, why)


def _to_judge(rollout: Rollout, contacts: _Contacts) -> Iterator[tuple[int, tuple[Touch, ...]]]:
    """Yield each sample of a run with those of its contacts that are to be judged.

    Contacts of sleeping things are left out if all of them were permitted when the things fell asleep.
    """
    still, known = tuple[Touch, ...](), list[Pair]()
    asleep = itertools.chain(rollout.asleep, itertools.repeat(()))
    for k, (touches, awake, now) in enumerate(zip(rollout.touches, rollout.awake_touches, asleep, strict=False)):
        if now is still and known:
            for pair in known:
                contacts.note(k, pair)
            yield k, awake
            continue
        yield k, touches
        still, pairs = now, list(_by_pair(now))
        known = pairs if all(contacts.last.get(pair) == rollout.times[k] for pair in pairs) else []


def _by_pair(touches: Iterable[Touch]) -> dict[Pair, tuple[float, Touch]]:
    """Sum of the contact forces between each two whole things [N], with the hardest of their contacts."""
    found: dict[Pair, tuple[float, Touch]] = {}
    for touch in touches:
        pair = frozenset({_whole(touch.a), _whole(touch.b)})
        force, hardest = found.get(pair, (0.0, touch))
        found[pair] = force + touch.force, max(hardest, touch, key=lambda t: t.force)
    return found


def _whole(body: str) -> str:
    return HAND if thing_of(body) == "effector" else thing_of(body)


class _Contacts:
    """Contacts that are permitted at each sample of a run; the samples are visited in order."""

    def __init__(self, candidate: Candidate, rollout: Rollout) -> None:
        self.times, self.robot = rollout.times, candidate.program.robot
        self.allowances = candidate.allowances
        self.tasks, self.held, self.moved = inner_tasks(candidate), explained_at(candidate), moved_by(candidate)
        self.mounted = {frozenset((t.name, name)) for t in rollout.world.things for name in mounts(t, rollout.world)}
        self.hollow = {t.name for t in rollout.world.things if t.feature("cram:Cavity")}
        self.weight = {t.name: (t.mass or 0.0) * GRAVITY for t in rollout.world.things}
        near = round(GRIP / float(self.times[1] - self.times[0])) if len(self.times) > 1 else 0
        pressed = pressed_at(rollout)
        explained = {h for h in self.held if h}
        self.gripped = [{*explained.intersection(pressed[k : k + near + 1]), one} for k, one in enumerate(self.held)]
        self.last: dict[Pair, float] = {}  # when two that may touch last did [s]
        self.stood: dict[str, set[str]] = {}  # what a thing touched when it was taken
        self.rested: dict[str, float] = {}  # when one that is held last touched something of that [s]

    def limit(self, k: int, pair: Pair) -> float | None:
        """Largest permitted force between two bodies at a sample [N]; None if they must not touch."""
        if pair == {HAND} or (HAND in pair and pair & self.gripped[k]):
            return math.inf  # pads that close on a thing: the gripper's own force
        if self.robot in pair:
            return None
        if pair in self.mounted:
            return math.inf  # a drawer runs in its cabinet, and against its stop: what that takes the arm feels
        in_hand = pair & {HAND, self.held[k]}
        if not in_hand and pair in self.last:
            return math.inf  # they stand together, and nobody is pressing
        if not self._settles(k, pair) and not self._declared(k, pair) and not self._goes_on(k, pair):
            return None
        if in_hand:
            return math.inf  # contacts of a stiff arm chatter: what it feels of them is judged (``force_peak``)
        own = [f for t in (self.tasks[k], *self._movers(k, pair)) if (f := self.allowances.get(t, Allowance()).force) is not None]
        return own[0] + sum(self.weight[one] for one in pair & self.weight.keys()) if own else math.inf

    def _settles(self, k: int, pair: Pair) -> bool:
        """Whether a contact comes from settling: at the start, or between two things that no task moves at
        that sample."""
        return k == 0 or (HAND not in pair and all(self.moved[one][k] == "" for one in pair & self.moved.keys()))

    def _declared(self, k: int, pair: Pair) -> bool:
        """Whether two bodies may touch: by the running task, or by the task that moved one of them, as a
        thing that it released may still fall."""
        if self._allows(self.tasks[k], k, pair) or self._among_contents(self.tasks[k], k, pair):
            return True
        return HAND not in pair and any(self._allows(t, k, pair) or self._among_contents(t, k, pair) for t in self._movers(k, pair))

    def _movers(self, k: int, pair: Pair) -> list[str]:
        return [task for one in sorted(pair & self.moved.keys()) if (task := self.moved[one][k])]

    def _allows(self, task: str, k: int, pair: Pair) -> bool:
        held, allowance = self.held[k], self.allowances.get(task, Allowance())
        if pair in allowance.touches or frozenset(HELD if one == held else one for one in pair) in allowance.touches:
            return True
        return allowance.carries_on and held in pair and bool(pair & self.stood.get(held, set())) and not self._left(held, k)

    def _left(self, held: str, k: int) -> bool:
        """Whether the payload has been lifted: its old support has not touched it for ``GAP`` seconds."""
        return bool(self.times[k] - self.rested[held] > GAP)

    def _among_contents(self, task: str, k: int, pair: Pair) -> bool:
        """Whether two bodies may touch because both touch one container, and a task permits one of them to
        touch it."""
        touches = self.allowances.get(task, Allowance()).touches
        return HAND not in pair and any(
            frozenset({one, c}) in touches and any(self._goes_on(k, frozenset({other, c})) for other in pair - {one})
            for one in pair for c in self.hollow - pair
        )  # fmt: skip

    def _goes_on(self, k: int, pair: Pair) -> bool:
        return bool(self.times[k] - self.last.get(pair, -math.inf) <= GAP)

    def note(self, k: int, pair: Pair) -> None:
        """Remember a permitted contact of two bodies."""
        self.last[pair] = float(self.times[k])
        taken = self.held[k]
        if taken and (k == 0 or self.held[k - 1] != taken):
            self.stood[taken] = {o for p in self.last if taken in p and HAND not in p and self._goes_on(k, p) for o in p - {taken}}
            self.rested[taken] = float(self.times[k])
        if pair & self.stood.get(taken, set()) and taken in pair:
            self.rested[taken] = float(self.times[k])
