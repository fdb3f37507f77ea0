"""Keys of a scenario's robot: of a robot type that a plugin declares, or of a robot file such as a URDF."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from ..base.quantities import Angle, Force, Length, Mass
from ..base.spec import Spec
from .pose_spec import PoseSpec


class GripperSpec(Spec):
    """Gripper of a robot that is read from files: the gripper's own file, if it has one, and data that no file states.

    ``at``: of the hand's root on the flange; ``pads``: geoms or bodies that grip, one of each finger; ``tcp``: site or body at the
    pinch point; ``opening``, ``force`` and ``speed`` [m/s]: lowest and highest; ``torsion``: lever of the pads' torsional friction.
    """

    file: str | None = None
    at: PoseSpec = PoseSpec()
    pads: tuple[str, str] | None = None
    tcp: str = ""
    opening: tuple[Length, Length] | None = None
    force: tuple[Force, Force] | None = None
    speed: tuple[float, float] | None = None
    torsion: Length | None = Field(None, gt=0, le=0.1)

    @model_validator(mode="after")
    def _rises(self) -> GripperSpec:
        for key in ("opening", "force", "speed"):
            pair = getattr(self, key)
            if pair is not None and not 0 <= pair[0] < pair[1]:
                raise ValueError(f"'{key}' is a pair of lowest and highest value, the lower one first, none below 0")
        return self


class RobotSpec(Spec):
    """Robot: name and base pose of its mount, and its type (declared by a plugin) or the file of an arm.

    Of an arm from a file further keys say what the file does not (``cramlite.model.Stated``): angles count as the file counts,
    ``speed`` is in rad/s, ``torques`` in Nm.
    """

    name: str = "arm"
    type: str | None = None
    at: PoseSpec = PoseSpec()
    file: str | None = None
    gripper: GripperSpec | str = "robotiq_2f85"
    payload: Mass | None = Field(None, gt=0)
    flange: str = ""
    home: tuple[Angle, ...] = ()
    speed: Annotated[float, Field(gt=0, le=100)] = 2.0
    torques: tuple[Annotated[float, Field(gt=0, lt=1e5)], ...] = ()
    limits: dict[str, tuple[Angle, Angle]] = Field({})
    sensor: str = ""
    apart: tuple[tuple[str, str], ...] = ()
    packages: dict[str, str] = Field({})

    @model_validator(mode="after")
    def _one_source(self) -> RobotSpec:
        if (self.type is None) == (self.file is None):
            raise ValueError("a robot needs exactly one of 'type', a robot that a plugin declares, and 'file', an MJCF or URDF of an arm")
        beside = sorted(self.model_fields_set - {"name", "type", "at", "file"})
        if self.type is not None and beside:
            raise ValueError(f"'{beside[0]}' is for a robot from a 'file'; the 'type' of a plugin already defines it")
        return self
