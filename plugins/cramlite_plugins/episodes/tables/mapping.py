"""Mapping files of recordings: meaning of the columns, units and axes, tracks of hands, and shapes of things."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from cramlite.model import Floats
from cramlite.plugin import Spec, UserError, explain_validation, load_yaml

from .convention import EULER, PRESETS, QUATERNIONS, ROTATION_VECTOR, TIMES, UNITS, Convention, axes_from, axes_of

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Format = Literal["csv", "jsonl", "optitrack", "vicon"]
FORMATS = {".csv": "csv", ".tsv": "csv", ".txt": "csv", ".jsonl": "jsonl", ".ndjson": "jsonl", ".json": "jsonl"}
"""Formats by the end of a file's name."""


class TimeSpec(Spec):
    """Time of a row: a column with its unit, or a rate of rows."""

    column: str | None = None
    unit: Literal["s", "ms", "us", "ns"] = "s"
    rate: Positive | None = None

    @property
    def seconds(self) -> float:
        """Number of seconds in one unit of the time column."""
        return TIMES[self.unit]

    @model_validator(mode="after")
    def _one_of_both(self) -> TimeSpec:
        if (self.column is None) == (self.rate is None):
            raise ValueError("say either 'column', with the times, or 'rate', frames a second of rows without times")
        return self


class ColumnsSpec(Spec):
    """Columns of a table that hold the poses of a track.

    In the columns' names ``{name}`` stands for the track's name; or ``track`` is the column in which each row
    names its track.
    """

    track: str | None = None
    position: tuple[str, str, str]
    rotation: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _turns(self) -> ColumnsSpec:
        if not self.rotation:
            raise ValueError(
                "'rotation' is missing: positions alone do not say what tilts or turns. Name the columns of a quaternion or of three "
                "angles; for what never turned write constant columns into the recording, 0, 0, 0 and 1 for x, y, z and w"
            )
        return self


class GripperSpec(Spec):
    """Column with the opening of a gripper or hand.

    It holds the opening itself, in the recording's unit of length; or, with ``closed`` and ``open``, any measure of it: its values for
    a hand that is closed, and for one that is open by ``width`` [m].
    """

    column: str
    closed: Number | None = None
    open: Number | None = None
    width: Positive = 0.08

    @model_validator(mode="after")
    def _both_ends(self) -> GripperSpec:
        if (self.closed is None) != (self.open is None) or (self.closed is not None and self.closed == self.open):
            raise ValueError("'closed' and 'open' are two different values of the column, such as closed: 1 and open: 0")
        return self


class ShapeSpec(Spec):
    """Shape in the recording's unit and axes: a box, hollow box, cylinder or mesh, with its middle at ``at``
    in the track's frame."""

    box: tuple[Positive, Positive, Positive] | None = None
    hollow: tuple[Positive, Positive, Positive] | None = None
    cylinder: tuple[Positive, Positive] | None = None
    mesh: str | None = None
    at: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _one(self) -> ShapeSpec:
        if sum(s is not None for s in (self.box, self.hollow, self.cylinder, self.mesh)) != 1:
            raise ValueError("a shape is one of box: [x, y, z], hollow: [x, y, z], cylinder: [radius, height] and mesh: FILE")
        return self


class PlaceSpec(Spec):
    """Pose of an untracked thing, in the recording's unit, axes and kind of rotation."""

    position: tuple[Number, Number, Number]
    rotation: tuple[Number, ...] = ()


class OpensSpec(Spec):
    """Opening of a drawer or door that is closed at the start of a recording: how far it slides or turns, in the
    recording's unit of length or in degrees; and the moving thing that carries it, if any."""

    slides: Positive | None = None
    turns: Annotated[float, Field(gt=0, le=360)] | None = None
    on: str | None = None

    @model_validator(mode="after")
    def _one(self) -> OpensSpec:
        if (self.slides is None) == (self.turns is None):
            raise ValueError("say either 'slides', how far the thing can be pulled out, or 'turns', by how many degrees it opens")
        return self


class TrackSpec(Spec):
    """Track: the name it has in the recording, its own columns, and the frame that its poses are in."""

    track: str | None = None
    position: tuple[str, str, str] | None = None
    rotation: tuple[str, ...] | None = None
    within: str | None = Field(None, alias="in")


class HandSpec(TrackSpec):
    """Hand or gripper in a mapping file: its track, and the column of its opening if there is one."""

    gripper: GripperSpec | None = None


class ThingSpec(TrackSpec):
    """Thing in a mapping file: its class, its shape, where it stands if it was not tracked, and how it opens if
    it can."""

    type: str | None = Field(None, alias="class")
    shape: ShapeSpec | None = None
    at: PlaceSpec | None = None
    opens: OpensSpec | None = None


class Mapping(Spec):
    """Mapping file of a recording: which columns of its table belong to which hands and things, in which units and axes."""

    recording: str
    format: Format | None = None
    convention: str | None = None
    time: TimeSpec | None = None
    length: str | None = None
    up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None
    handedness: Literal["left", "right"] | None = None
    axes: tuple[str, str, str] | None = None
    rotation: str | None = None
    angles: Literal["rad", "deg"] | None = None
    columns: ColumnsSpec | None = None
    gaps: tuple[Literal["empty", "nan", "zero"] | Number, ...] = ("empty",)
    valid: str | None = None
    hands: dict[str, HandSpec]
    things: dict[str, ThingSpec]

    @model_validator(mode="after")
    def _somebody_and_something(self) -> Mapping:
        if not self.hands or not self.things:
            raise ValueError("name one hand at least under 'hands', and one thing at least under 'things'")
        for name, thing in self.things.items():
            if thing.opens is not None and thing.opens.on is not None and thing.opens.on not in set(self.tracks) - {name}:
                raise ValueError(f"'{name}': 'opens' names '{thing.opens.on}' under 'on'; it must be another thing with a track")
        return self

    @property
    def kind(self) -> str:
        """Format of the recording: the stated one, else by the file's ending, else CSV."""
        return self.format or FORMATS.get(Path(self.recording).suffix.lower(), "csv")

    @property
    def tracks(self) -> dict[str, TrackSpec]:
        """Tracks of hands and of tracked things, by name; things with a fixed pose are left out."""
        still = {n for n, t in self.things.items() if t.at is not None}
        return {**self.hands, **{n: t for n, t in self.things.items() if n not in still}}

    def conventional(self, unit: str | None = None, rotation: str | None = None) -> Convention:
        """Return the units and axes of the recording: as its own file states them, else the mapping, else as
        usual for its format.

        Args:
            unit, rotation: that the file states in its header.

        Raises:
            UserError: something is not known, or two statements contradict each other.
        """
        preset = self.convention or self.kind
        if self.convention is not None and self.convention not in PRESETS:
            raise UserError(f"'convention: {self.convention}' is none of {', '.join(PRESETS)}.")
        usual = PRESETS.get(preset, (None, None, None, None))
        length = _agreed("length", self.length, unit) or usual[0]
        kind = _agreed("rotation", self.rotation, rotation) or usual[3]
        if length not in UNITS:
            raise UserError(f"'length' is {'missing' if length is None else repr(length)}; say the unit of positions: {', '.join(UNITS)}.")
        if kind is None or not (kind in (*QUATERNIONS, ROTATION_VECTOR) or EULER.fullmatch(kind)):
            said = "is missing" if kind is None else f"'{kind}' is not known"
            raise UserError(
                f"'rotation' {said}; say how rotations are written: xyzw or wxyz (quaternions in the order of the columns), "
                "rotation_vector, or euler_XYZ (about axes that turn along; euler_xyz: about fixed ones) with 'angles: deg' or rad."
            )
        if kind not in QUATERNIONS and self.angles is None:
            raise UserError(f"'angles' is missing; 'rotation: {kind}' needs 'angles: deg' or 'angles: rad'.")
        angle = math.pi / 180 if self.angles == "deg" else 1.0
        return Convention(UNITS[str(length)], self._axes(usual[1], usual[2]), kind, angle)

    def _axes(self, up: str | None, hand: str | None) -> Floats:
        if self.axes is not None:
            rows = axes_from(self.axes)
            said = "left" if np.linalg.det(rows) < 0 else "right"
            if self.handedness not in (None, said):
                raise UserError(
                    f"'axes: [{', '.join(self.axes)}]' makes the recording {said}-handed, and 'handedness: {self.handedness}' says the "
                    "opposite; leave one of them out, or change a sign."
                )
            return rows
        up, hand = self.up or up, self.handedness or hand
        if up is None or hand is None:
            raise UserError(
                f"'{'up' if up is None else 'handedness'}' is missing; say which axis points up and whether the axes are left- or "
                f"right-handed ('up: y' and 'handedness: left'), or name a convention: {', '.join(PRESETS)}."
            )
        return axes_of(up, hand)


def _agreed(key: str, said: str | None, stated: str | None) -> str | None:
    """Return the value of a key from the mapping, or else from the recording's header; refuse two that differ."""
    if said is not None and stated is not None and said != stated:
        raise UserError(f"'{key}: {said}' contradicts the recording's own header, which says {stated}; leave '{key}' out.")
    return said or stated


def read_mapping(path: Path) -> Mapping | None:
    """Read a mapping file; None if the YAML has neither 'recording' nor 'hands'.

    Raises:
        UserError: it is one and is wrong.
    """
    data = load_yaml(path)
    if not isinstance(data, dict) or not {"recording", "hands"} & set(data):
        return None
    try:
        return Mapping.model_validate(data)
    except ValidationError as error:
        raise explain_validation(path, data, error, _fields(error)) from None


def _fields(error: ValidationError) -> list[str]:
    """Return the keys that a mapping file allows at the place of its first invalid key."""
    place = error.errors()[0]["loc"][:-1]
    specs: dict[str, type[Spec]] = {
        "time": TimeSpec, "columns": ColumnsSpec, "gripper": GripperSpec, "shape": ShapeSpec, "at": PlaceSpec, "opens": OpensSpec,
    }  # fmt: skip
    whole: dict[str, type[Spec]] = {"hands": HandSpec, "things": ThingSpec}
    spec = next((specs[str(k)] for k in reversed(place) if k in specs), whole.get(str(place[0]), Mapping) if place else Mapping)
    return [f.alias or n for n, f in spec.model_fields.items()]
