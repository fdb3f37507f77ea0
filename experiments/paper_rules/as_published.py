"""Predicates of the published rules that cramlite defines otherwise: displacement between the end points of
an action, and contacts that last as long as an action.

``sliding_gripper.yaml`` is not here: as published its class has no 'http://', so that the rule never fires.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cramlite.plugin import Phase, PhaseName, Predicate, Row, hookimpl
from cramlite_plugins.predicates.motion import ARM_MOVED, GRIPPER_MOVED
from cramlite_plugins.predicates.relations import chain, touches

RUN: frozenset[PhaseName] = frozenset({"run"})


@hookimpl
def predicates() -> Iterable[Predicate]:
    return [
        Predicate("arm_displaced", 0, arm_displaced, RUN, cost=3, doc="The effector ends over 1 mm from where it began."),
        Predicate(
            "gripper_displaced", 0, gripper_displaced, RUN, cost=3, doc="The finger tips end over 20 mm nearer or further."
        ),
        Predicate(
            "collides_throughout", 2, collides_throughout, cost=2, doc="A contact of the chain that spans the action."
        ),
    ]


def arm_displaced(phase: Phase) -> Iterator[Row]:
    track = phase.episode.tracks.get(phase.episode.effector or "")
    if track is not None and len(track.times):
        way = track.at(phase.start).distance(track.at(phase.end))[0]
        if way > ARM_MOVED:
            yield ()


def gripper_displaced(phase: Phase) -> Iterator[Row]:
    import numpy as np

    extras = phase.episode.extras
    if "opening" in extras and len(extras["opening"]) == len(extras.get("times", ())):
        begin, end = np.interp([phase.start, phase.end], extras["times"], extras["opening"])
        if abs(end - begin) > GRIPPER_MOVED:
            yield ()


def collides_throughout(phase: Phase, _a: str | None, _b: str | None) -> Iterator[Row]:
    members = {row[0] for row in chain(phase, None)}
    yield from (row for row in touches(phase, None, None) if row[0] in members and row[1] not in members)
