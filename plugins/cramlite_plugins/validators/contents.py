"""Validators of poured contents: grains are counted in the physics of the run."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from cramlite.model import Value
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from ..shapes.contents import SHARE, SPILLED, on_its_surface, where


class Poured(Value):
    """Check that enough of the poured content is in the destination at the end."""

    name: str = "poured"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        for action in candidate.actions:
            source, into = (action.roles[r].entity if r in action.roles else None for r in ("Source", "Destination"))
            if action.task == "soma:Pouring" and source in rollout.grains:
                arrived, count = int(where(rollout, source or "")[into or ""][-1]), rollout.grains[source or ""].shape[1]
                wanted = float(action.parameters.get("share", SHARE))
                said = f"{arrived} of {count} grains of '{source}' are in '{into}', {math.ceil(wanted * count - 1e-9)} are wanted"
                share = arrived / count
                yield Finding(self.name, share >= wanted, said, share, wanted, "", action.name)


class Spilled(Value):
    """Check that at most a permitted share of a vessel's grains is outside of all vessels at the end; grains
    scattered on a surface may stay there."""

    name: str = "spilled"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        limits = [float(a.parameters["spilled"]) for a in candidate.actions if "spilled" in a.parameters]
        limit = max(limits, default=SPILLED)
        for thing, grains in rollout.grains.items():
            held, count = sum(int(inside[-1]) for inside in where(rollout, thing).values()), grains.shape[1]
            lost = count - held - int(on_its_surface(rollout, thing)[-1])
            said = f"{lost} of {count} grains of '{thing}' are beside all vessels, at most {math.floor(limit * count + 1e-9)} may be"
            yield Finding(self.name, lost <= limit * count, said, lost / count, limit, "", "")


@hookimpl
def validators() -> Iterable[Validator]:
    return [Poured(), Spilled()]
