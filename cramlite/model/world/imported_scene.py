"""Scene read from a file such as an MJCF, as things of cramlite."""

from __future__ import annotations

from typing import Literal

from msgspec import field

from ...base.value import Value
from ..geometry import Pose
from .thing import Thing


class StatedJoint(Value):
    """Joint of a scene file as the user describes it, to overrule what the reader of the file finds.

    Args:
        closed: at which end of its range it is closed, as the file counts; None where the reader is to find it.
        kind: what the range is of.
        ends: lower and upper end of its range, as the file counts [m, rad]; None for that of the file.
    """

    closed: Literal["lower", "upper"] | None = None
    kind: Literal["slide", "hinge"] | None = None
    ends: tuple[float, float] | None = None


class ImportedScene(Value):
    """Things of a scene file, with notes on parts that were left out.

    Args:
        things: furniture first, then what is mounted in it, then what is loose.
        names: thing -> what else the file calls it: its meshes, its title; for classes.
        physics: settings that the file states, by the names of ``Physics`` and in its units.
        found: what each thing is taken for and why, with its features, for people.
        notes: what was changed, left out or not understood, for people.
        mounts: jointed thing -> what it is mounted in.
        stands: robot of the file, which is left out -> where its base is.
    """

    things: tuple[Thing, ...]
    names: dict[str, tuple[str, ...]] = field(default_factory=dict)
    physics: dict[str, float | int | str] = field(default_factory=dict)
    found: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    mounts: dict[str, str] = field(default_factory=dict)
    stands: dict[str, Pose] = field(default_factory=dict)
