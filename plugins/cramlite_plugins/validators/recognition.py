"""Validator of recognition: each thing is, in the real world, the one that it was recognised as.

A proof runs in the world as it is believed to be, so there each thing is what it is taken for: this can only object to the
execution of a program that was accepted, and no search learns of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cramlite.model import Value
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl


class Recognised(Value):
    """Check that the things that play a role exist, and are of the class that they were believed to be."""

    name: str = "recognised"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        real = {t.name: t for t in candidate.ran.world.things}
        believed = {t.name: t for t in candidate.world.things}
        named = {o.thing: a.name for a in candidate.actions for o in a.roles.values()}
        for name, origin in sorted(named.items()):
            if name not in believed or (name in real and real[name].type == believed[name].type):
                continue
            truth = f"is a {real[name].type}" if name in real else "is not there"
            yield Finding(
                self.name, False, f"'{name}', which was taken for a {believed[name].type}, {truth}", origin=origin
            )


@hookimpl
def validators() -> Iterable[Validator]:
    return [Recognised()]
