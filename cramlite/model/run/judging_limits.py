"""Limits of judging: allowed disturbance of things that no task is about."""

from __future__ import annotations

import math

from ...base.value import Value


class JudgingLimits(Value):
    """Allowed disturbance of things that no task is about.

    Args:
        bystander_motion: how far any point of a thing that nobody moves on purpose may get [m]. 5 mm: grasps and places are
            planned with margins of a centimetre.
        bystander_tilt: how far such a thing may lean over [rad]. 5 deg: a box three times as high as wide topples at 18 deg.
        brush: contact force below this is a brush, not a touch [N]: the guarded threshold of the controller.
        advisory: names of validators whose objections are told, and refuse nothing; those alone that declare ``may_advise``.
        may_push: whether planning may have things that no task is about pushed out of the way, as by a drawer that opens.
        of_scenario: names of those that a scenario sets; the others are the defaults.
        keep: things that must keep their place, whoever moves them: name, and how far any point of it may get [m].
    """

    bystander_motion: float = 0.005
    bystander_tilt: float = math.radians(5.0)
    brush: float = 2.0
    advisory: tuple[str, ...] = ()
    may_push: bool = False
    of_scenario: tuple[str, ...] = ()
    keep: tuple[tuple[str, float], ...] = ()

    def motion_of(self, thing: str) -> tuple[float, str]:
        """Return how far any point of a thing is allowed to move in a run [m], and the name of the limit that applies."""
        kept = dict(self.keep)
        return (kept[thing], "keep") if thing in kept else (self.bystander_motion, "bystander_motion")

    def source(self, name: str) -> str:
        """Source of a limit in words: "of the scenario", or "by default"."""
        return "of the scenario" if name in self.of_scenario else "by default"
