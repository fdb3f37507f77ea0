"""Demonstrations by a simulated person: scripts that plugins declare, and the hands that a script moves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from ..base.errors import PluginError
from ..base.value import Value

if TYPE_CHECKING:
    import numpy as np

    from ..model.geometry import Pose
    from ..model.run.rollout import Rollout
    from ..model.world.world import World


class Hand(Protocol):
    """Second hand of a performer: its movements are queued, and executed while the first hand moves."""

    @property
    def aim(self) -> Pose:
        """Commanded pose of the hand's tool frame in the world."""
        ...

    def move(self, path: Sequence[Pose], speed: float, *, curved: bool = False) -> None:
        """Queue a movement along poses of the tool frame in the world, with a mean speed [m/s]."""
        ...

    def grip(self, opening: float, seconds: float) -> None:
        """Queue a movement of the fingers to an opening [m] within a time [s]."""
        ...

    def wait(self, seconds: float) -> None:
        """Queue a time of keeping still [s]."""
        ...


class Performer(Protocol):
    """Simulated person while a script runs: hands of finite strength that hold by contact and friction alone.

    A tool frame has z along the approach and y along the closing direction; its origin is between the finger pads.
    """

    pace: float
    """Factor on the speed of every movement of the simulated person."""

    @property
    def rng(self) -> np.random.Generator:
        """Random generator from which all variation of the performance is drawn."""
        ...

    @property
    def other(self) -> Hand | None:
        """Hand that is not the active one; None if the simulated person has only one hand."""
        ...

    @property
    def aim(self) -> Pose:
        """Commanded pose of the active hand's tool frame in the world."""
        ...

    @property
    def opening(self) -> float:
        """Target opening of the active hand's fingers [m]."""
        ...

    def between(self, low: float, high: float) -> float:
        """Draw a number uniformly between two limits, in their unit, from the random generator of this demonstration."""
        ...

    def pose(self, thing: str) -> Pose:
        """Return the pose of a thing in the world, as the person sees it now."""
        ...

    def tool(self) -> Pose:
        """Return the tool frame of the active hand in the world."""
        ...

    def touches(self, thing: str) -> bool:
        """Check whether any part of the active hand is in contact with a thing."""
        ...

    def holds(self, thing: str) -> bool:
        """Check whether both fingers of the active hand are in contact with a thing."""
        ...

    def fits(self, tool: Pose, opening: float) -> bool:
        """Check that the active hand, with its fingers at an opening [m], would touch nothing at a pose of
        its tool frame."""
        ...

    def move(self, path: Sequence[Pose], speed: float, *, curved: bool = False) -> None:
        """Move the active hand from its present target pose along further poses with a mean speed [m/s].

        If ``curved``, the poses before the last are control points of a Bézier curve.
        """
        ...

    def follow(self, path: Sequence[Pose], seconds: float) -> None:
        """Move the active hand from its present target pose through further poses within a time [s], position and
        orientation together at constant speed."""
        ...

    def grip(self, opening: float, seconds: float) -> None:
        """Move the active hand's fingers to an opening [m] within a time [s]."""
        ...

    def wait(self, seconds: float) -> None:
        """Keep the active hand still for a time [s], except for drift and tremor."""
        ...

    def wait_for_other(self) -> None:
        """Keep the active hand still until the other hand has executed its queued movements."""
        ...

    def change_hands(self) -> None:
        """Make the other hand the active one."""
        ...

    def shake(self, share: float) -> None:
        """Scale the tremor of both hands from now on: 1 is the person's own, 0 none."""
        ...


class Performance(Value):
    """Performance of a script by the simulated person, prepared for one world with one random generator.

    Args:
        act: moves the hands.
        rests: orientations of the tool frames at rest, one for each hand (a hand turns up to 170 degrees away from it); none for one
            hand that points forward and down.
        start: draws tool frames to begin with, asked again while a hand would touch something; None begins in front of the things.
        missed: what did not come about that the script is for, as a clause; "" where all did.
        recorded: what the recorder makes of the rollout.
    """

    act: Callable[[Performer], None]
    rests: tuple[Pose, ...] = ()
    start: Callable[[], tuple[Pose, ...]] | None = None
    missed: Callable[[Performer], str] | None = None
    recorded: Callable[[Rollout], Rollout] | None = None


class RecordScript(Value):
    """Script of a simulated person, which ``cramlite record`` performs.

    Args:
        name: what a scenario's ``record:`` section calls it; or the class of a task, such as "soma:Pouring", which it shows.
        prepare: called with the world, what fills the task's roles and parameters (both by name), and the generator of all variety.

            Raises UserError where the world lacks what the script needs.
    """

    name: str
    prepare: Callable[[World, Mapping[str, Any], np.random.Generator], Performance]


class Shown(Value):
    """Part of a demonstration: a script of the simulated person, with the things and parameters of its task.

    Args:
        script: of the person.
        fillers: of its task's roles and parameters, by name.
    """

    script: RecordScript
    fillers: Mapping[str, Any] = {}

    def prepared(self, world: World, rng: np.random.Generator) -> Performance:
        """Return the performance of the simulated person that the script prepares for a world.

        Raises:
            PluginError: the script gives none.
        """
        made = self.script.prepare(world, self.fillers, rng)
        if not isinstance(made, Performance):
            raise PluginError(f"The script '{self.script.name}' prepares {made!r:.80}; it should be a cramlite.plugin.Performance.")
        return made
