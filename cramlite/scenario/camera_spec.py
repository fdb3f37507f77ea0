"""Camera of a scenario file: mount, queries and field of view."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationError, model_validator

from ..base.errors import UserError
from ..base.quantities import Angle
from ..base.spec import Spec
from ..base.yaml_file import explain_validation, load_yaml
from ..model.view import D435, Intrinsics
from .pose_spec import PoseSpec


class IntrinsicsSpec(Spec):
    """Focal lengths and principal point of a pinhole camera [pixel]."""

    fx: float = Field(gt=0)
    fy: float = Field(gt=0)
    cx: float
    cy: float


CALIBRATED = {"mount", "at", "width", "height", "intrinsics", "horizontal_fov"}
"""Keys of a camera that its calibration states."""


class CameraSpec(Spec):
    """Depth camera: on the robot's flange, or fixed in the world.

    The pose is that of its optical frame: z forward, x to the right, y down.
    """

    mount: Literal["flange", "world"] = "flange"
    at: PoseSpec = PoseSpec()
    queries: tuple[str, ...] = ()
    finds: tuple[str, ...] = ()
    width: int = Field(D435.width, ge=16, le=4096)
    height: int = Field(D435.height, ge=16, le=4096)
    horizontal_fov: Angle | None = None
    intrinsics: IntrinsicsSpec | None = None
    noise: bool | Annotated[float, Field(ge=0, le=10)] = True
    checks: Literal["none", "end", "tasks"] = "none"
    calibration: str | None = None

    @model_validator(mode="after")
    def _is_a_camera(self) -> CameraSpec:
        if self.calibration is not None and (twice := CALIBRATED & self.model_fields_set):
            raise ValueError(f"'calibration' says where the camera is and how it sees; leave out {', '.join(sorted(twice))}")
        if self.horizontal_fov is not None and self.intrinsics is not None:
            raise ValueError("a camera has 'horizontal_fov' or 'intrinsics', not both: each says how wide it sees")
        try:
            self.pinhole()
        except UserError as error:
            raise ValueError(str(error).removesuffix(".")) from error
        return self

    def pinhole(self) -> Intrinsics:
        """Return the intrinsics: as stated, else of square pixels with ``horizontal_fov``, by default that of
        a D435 camera."""
        if self.intrinsics is not None:
            return Intrinsics(**self.intrinsics.model_dump(), width=self.width, height=self.height)
        return Intrinsics.from_field_of_view(self.width, self.height, self.horizontal_fov)

    def calibrated(self, folder: Path) -> CameraSpec:
        """Return the camera with the values of its calibration file, whose path is relative to ``folder``.

        Raises:
            UserError: the file cannot be read, or was not written by ``cramlite calibrate``.
        """
        if self.calibration is None:
            return self
        path = folder / self.calibration
        data = load_yaml(path)
        said = data.get("camera") if isinstance(data, Mapping) else None
        if not isinstance(said, Mapping):
            raise UserError(f"{path}:1: this is no calibration: it has no key 'camera'; 'cramlite calibrate FOLDER --out FILE' writes one.")
        try:
            found = CameraSpec.model_validate({k: said[k] for k in said if k in CALIBRATED})
        except ValidationError as error:
            raise explain_validation(path, said, error, sorted(CALIBRATED)) from error
        return self.model_copy(update={k: getattr(found, k) for k in found.model_fields_set})
